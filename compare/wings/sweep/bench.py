"""What a sample of a sweep costs by the default model: a key that leaves the bodies as they are, and one of a body."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import count

from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.scenes.catalogue import scene, scene_text
from rollbench.compare.wings.bench.costs.timing import Job, timed
from rollbench.compare.wings.sweep.keys import Vary, read_vary
from rollbench.compare.wings.sweep.sample import solve_sample

SCENE, MODEL = "lin-pitch", "refined"
#: Varied key by what it changes, and time of a sample that is aimed at [s].
KEYS = {"no body": ("errors.balls.oversize=0 um:7 um", 3e-3), "one body": ("nut.outer_diameter=46 mm:60 mm", 0.25)}


def jobs(repeats: int = 5) -> Iterator[Job]:
    """Samples one after the other, each at a value of its own; compiled, one core."""
    text = scene_text(SCENE)
    options = Options(discretisation=False, engine="compiled")
    alone = timed(lambda: run_model(scene(SCENE), MODEL, options), repeats)
    for what, (varied, aim) in KEYS.items():
        (vary,) = read_vary([varied])
        work = partial(_sample, text, vary, count(1))
        note = f"{varied}: two solutions, their answers, the scene read; one solution of known bodies takes "
        note += f"{1e3 * alone:.2g} ms, no sample less than two; aim {1e3 * aim:g} ms"
        yield Job(f"sample of a sweep, {what} changed", timed(work, repeats), None, None, None, note)


def _sample(text: str, vary: Vary, numbers: Iterator[int]) -> None:
    value = vary.at((0.618 * next(numbers)) % 1.0)
    solve_sample(text, f"{SCENE}.toml", [vary], [value], MODEL, "compiled")
