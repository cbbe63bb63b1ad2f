"""Options and help of ``rollbench doctor``."""

from __future__ import annotations

from pathlib import Path

from rollbench.compare.commands.arguments.terminal import Json, app
from rollbench.compare.commands.printing import print_answer


@app.command
def doctor(*, store: Path = Path("rollbench-reference"), as_json: Json = False) -> int:
    """Check this machine: packages, system libraries, drawing, folders, memory; what is missing and disabled; licences.

    Exit codes: 0 nothing is missing (programs marked optional may be, and packages of an extra that is not installed),
    1 something is.

    Parameters
    ----------
    store
        Folder of the reference's runs.
    """
    from rollbench.compare.wings.doctor.command import run_doctor

    return print_answer(run_doctor(store), as_json)
