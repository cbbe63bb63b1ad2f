"""Options and help of ``rollbench sweep``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from rollbench.compare.commands.arguments.terminal import Json, Where, Word, app, engine
from rollbench.compare.commands.printing import print_answer


@app.command
def sweep(
    scene: str,
    *,
    vary: Annotated[list[str], Parameter(negative="")],
    samples: int = 256,
    method: Literal["sobol", "lhs", "grid"] = "sobol",
    model: Word = "",
    seed: int = 0,
    outputs: Word = "",
    out: Path = Path("rollbench-sweep"),
    as_json: Json = False,
    where: Where | None = None,
) -> int:
    """Solve a scene at many values of its keys; each sample is stored, and an interrupted sweep resumes.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file.
    vary
        KEY=A:B or KEY=v1,v2, again for every key: dotted path, lists by [0], units as in the scene, e.g.
        "loads[0].force[2]=1 kN:5 kN"; KEY+KEY=... gives several keys one value. A range of bare whole numbers gives whole
        numbers (errors.seed=1:1000).
    samples
        How many; sobol takes the nearest n (keys + 2) with n a power of two, grid at most so many.
    method
        sobol (with Sobol indices), lhs (Latin hypercube) or grid.
    model
        refined unless given; see: rollbench list.
    seed
        Seed of the design.
    outputs
        NAME,NAME: compute these alone, beside the largest load; all unless given. Without rigidity_N_per_um and preload_N
        a sample needs one solution, not two. Names are those of samples.csv.
    out
        Folder of the records and the summary; samples stored there are not solved again.
    """
    from rollbench.compare.wings.sweep.command import run_sweep, sweep_of

    names = [name.strip() for name in outputs.split(",") if name.strip()]
    what = sweep_of(scene, vary, samples, method, seed, model, names)
    return print_answer(run_sweep(what, out, engine(where)), as_json)
