"""A whole sweep: what is missing is solved batch by batch, side by side where asked, and every sample is stored."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rollbench.compare import __version__
from rollbench.compare.errors import ArgumentError, InputError, ProgramError, Refusal
from rollbench.compare.models import user_models
from rollbench.compare.models.registry import AXIS_MODELS, MODELS, known_model
from rollbench.compare.reference import parallel
from rollbench.compare.reference.jobs import Engine, first_here
from rollbench.compare.scenes import scene_file, scene_tables
from rollbench.compare.studies.sweep import sample
from rollbench.compare.studies.sweep.keys import Method, Vary, changed, displaced, points, values
from rollbench.compare.studies.sweep.sample import MAIN, OUTPUTS, attempt, reason, solve_batch
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly

Step = Callable[[str], None]
#: From this many samples on the compiled kernels are used: by the size of the design, so that it is always the same. Plain
#: Python takes about as long over them as the kernels take to be compiled.
COMPILE_FROM = 50
#: Samples that are tried before anything is stored: where each is refused for the same reason, nothing else is.
FIRST = 10
#: Most samples of a job, which its process stores together; least number of jobs a worker.
LARGEST_BATCH, BATCHES = 20, 20
#: Workers that a scheduler may come to have, where their number is not given: they can join at any time.
MANY = 100


@dataclass(frozen=True)
class Sweep:
    """What is swept: text of the scene and the name that errors give it, varied keys, design, model, and the outputs that
    are computed (none: all)."""

    text: str
    origin: str
    keys: tuple[Vary, ...]
    samples: int
    method: Method = "sobol"
    seed: int = 0
    model: str = "refined"
    outputs: tuple[str, ...] = ()

    @property
    def wanted(self) -> tuple[str, ...]:
        """Outputs that are kept, in the order of `OUTPUTS`: all unless some are named, `MAIN` always."""
        return tuple(name for name in OUTPUTS if not self.outputs or name in (MAIN, *self.outputs))

    def places(self) -> Array:
        """Places of all samples in the unit cube, ``(m, d)``."""
        return points(self.method, self.keys, self.samples, self.seed)

    def header(self) -> dict[str, Any]:
        """All that the records depend on."""
        names = ("samples", "method", "seed", "model")
        what = {"scene": self.origin, "text": self.text, "vary": [vary.text for vary in self.keys]}
        some: dict[str, Any] = {"outputs_kept": list(self.wanted)} if self.outputs else {}
        if self.model not in MODELS:
            some["model_of"] = user_models.origin(self.model)
        return {"rollbench": __version__, **what, **{name: getattr(self, name) for name in names}, **some}

    def check(self) -> None:
        """Raise InputError for an unknown model or output, a key that a scene does not have, or values out of its range."""
        for name in self.outputs:
            if name not in OUTPUTS:
                raise ArgumentError("outputs", name, ", ".join(OUTPUTS), "names with commas between")
        raw = scene_file.read_toml(self.text, self.origin)
        scene = scene_tables.read_tables(raw, self.origin)
        if not isinstance(scene, Assembly):
            known_model(self.model, without=("condensed",))
        elif self.model not in AXIS_MODELS:
            raise ArgumentError("model", self.model, ", ".join(AXIS_MODELS), "choose one of these")
        scene_file.each_case(scene, self.origin)
        for vary in self.keys:
            for value in vary.ends:
                scene_tables.keys_of(changed(raw, [vary], [value]), self.origin)


def run_samples(sweep: Sweep, folder: Path, engine: Engine, step: Step) -> dict[int, sample.Record]:
    """Records of all samples by number; what the folder holds already is not solved again.

    Raises InputError for what cannot be swept, a folder that holds something else, and workers that are lost.
    """
    sweep.check()
    places = sweep.places()
    if not sample.load(folder):
        _try_first(sweep, places)
    for path, other in displaced(scene_file.read_toml(sweep.text, sweep.origin), sweep.keys):
        step(f"{path} takes the place of the scene's {other}")
    sample.open_folder(folder, sweep.header())
    with sample.taken_over(folder) as token:
        have = sample.load(folder)
        left = [n for n in range(len(places)) if n not in have]
        step(f"{len(places)} samples, {len(have)} stored in {folder}, {len(left)} to solve")
        if left:
            _solve_missing(sweep, folder, engine, step, (token, places, left))
            have = sample.load(folder)
    return have


def _try_first(sweep: Sweep, places: Array) -> None:
    """Raise InputError where the first samples are all refused for one reason."""
    refused: list[InputError] = []
    for place in places[:FIRST]:
        try:
            attempt(
                sweep.text, sweep.origin, sweep.keys, values(sweep.keys, place), sweep.model, "interpreted", sweep.wanted
            )
            return
        except InputError as error:
            refused.append(error)
    if len({reason(error) for error in refused}) > 1:
        return
    if isinstance(refused[-1], ProgramError):
        raise refused[-1]
    few = f"each of the first {min(FIRST, len(places))} samples is refused for one reason, the last one so"
    raise Refusal(sweep.origin, "vary", f"{few}: {refused[-1]}", "vary other keys, or other ranges")


def _solve_missing(sweep: Sweep, folder: Path, engine: Engine, step: Step, work: tuple[str, Array, list[int]]) -> None:
    token, places, left = work
    kernels = "compiled" if len(places) >= COMPILE_FROM else "interpreted"
    what = (sweep.text, sweep.origin, sweep.keys, sweep.model, kernels, sweep.wanted)
    workers = engine.workers or (MANY if engine.scheduler else 1)
    size = max(1, min(LARGEST_BATCH, len(left) // (BATCHES * workers)))
    batches = [left[k : k + size] for k in range(0, len(left), size)]
    jobs: list[parallel.Job] = [
        (solve_batch, (str(folder.resolve()), token, what, [(n, values(sweep.keys, places[n])) for n in batch]))
        for batch in batches
    ]
    writer = sample.Writer(folder, token)
    done = failed = 0
    for _, (records, stored) in first_here(jobs, engine, "samples", step):
        if not stored:
            writer.append(records)
        done += len(records)
        failed += sum(record["status"] != "converged" for record in records)
        step(f"[{done}/{len(left)}] {failed} failed")
