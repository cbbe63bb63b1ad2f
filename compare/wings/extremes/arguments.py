"""Options and help of ``rollbench stability``."""

from __future__ import annotations

from pathlib import Path

from rollbench.compare.commands.arguments.terminal import Json, app
from rollbench.compare.commands.printing import print_answer
from rollbench.compare.errors import ArgumentError


@app.command
def stability(
    *,
    survey: int | None = None,
    out: Path | None = None,
    workers: int | None = None,
    keep: Path | None = None,
    as_json: Json = False,
) -> int:
    """Run the table of stiff and extreme scenes; exit 1 where this project's solver fails on any.

    With --survey instead: ordinary catalogue screws on the 3D reference, half a minute to some minutes each; exit 1 where
    one has no answer or did not settle.

    Parameters
    ----------
    survey
        Number of drawn catalogue screws; the report's are 240.
    out
        Folder of the survey: a line a scene, and the runs of the 3D reference; an interrupted survey resumes there;
        rollbench-survey unless given.
    workers
        Number of scenes of the survey in parallel, 1 unless given; each needs up to 4 GB.
    keep
        File to write the survey's record to, for the report's table; scenes that this file answers are not solved again.
    """
    from rollbench.compare.wings.extremes.command import run_drawn, run_stability

    if survey is not None:
        return print_answer(run_drawn(survey, out or Path("rollbench-survey"), workers or 1, keep), as_json)
    if (out, workers, keep) != (None, None, None):
        raise ArgumentError("out, workers, keep", "given", "with --survey", "add --survey COUNT")
    return print_answer(run_stability(as_json=as_json), as_json)
