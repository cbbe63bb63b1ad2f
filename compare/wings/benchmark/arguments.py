"""Options and help of ``rollbench benchmark``."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from rollbench.comparison.commands.arguments.terminal import Flag, Json, Word, app, cache_folder
from rollbench.comparison.commands.printing import print_answer


@app.command
def benchmark(
    action: Literal["export", "score", "compute"],
    path: Path | None = None,
    /,
    *,
    problem: Word = "",
    meshes: Flag = False,
    step: Flag = False,
    as_json: Json = False,
) -> int:
    """Export BSCB-1, twelve contact problems with their answers, or score the contact loads of a program.

    export DIR writes the problems (scenes and plain JSON), the answers and the page that explains them. score FILE.csv
    judges loads, and angles, approaches and pressures where they are given: exit code 0 where all pass, 1 where a contact
    is missing or beyond its tolerance. compute makes the answers again from the 3D reference; runs that are not stored are
    computed.

    Parameters
    ----------
    action
        export, score or compute.
    path
        export: folder to write to; score: file with the columns problem, contact, load_N; further ones: angle_deg,
        approach_um, pressure_MPa. compute: folder for the answers, that of the package unless given.
    problem
        score: one problem; all unless given.
    meshes
        export: whole bodies as meshes too (VTU).
    step
        export: geometry as STEP files too.
    """
    from rollbench.comparison.reference.jobs import Engine
    from rollbench.comparison.wings.benchmark.command import run_benchmark

    found = run_benchmark(
        action, path, problem=problem, meshes=meshes, step_files=step, engine=Engine(cache=cache_folder())
    )
    return print_answer(found, as_json)
