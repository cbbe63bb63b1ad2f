"""Options and help of ``rollbench doctor``."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from rollbench.comparison.commands.arguments.terminal import Json, app
from rollbench.comparison.commands.printing import print_answer


@app.command
def doctor(
    *,
    store: Path = Path("rollbench-reference"),
    requirements: Literal["check", "solve", "compare", "report", "all"] | None = None,
    as_json: Json = False,
) -> int:
    """Check this machine: packages, system libraries, drawing, folders, memory; what is missing and disabled; licences.

    Exit codes: 0 nothing is missing (programs marked optional may be), 1 something is.

    Parameters
    ----------
    store
        Folder of the reference's runs.
    requirements
        Instead: the pinned lines of packages that a command needs, as installed here: check beside stored runs, solve,
        compare, report, or all.
    """
    if requirements is not None:
        from rollbench.comparison.wings.doctor.requirements import run_requirements

        return print_answer(run_requirements(requirements), as_json)
    from rollbench.comparison.wings.doctor.command import run_doctor

    return print_answer(run_doctor(store), as_json)
