"""The machine that rollbench runs on: doctor."""

from __future__ import annotations

from pathlib import Path

from compare.commands.arguments.terminal import Json, app, print_json, show


@app.command
def doctor(*, store: Path = Path("rollbench-reference"), as_json: Json = False) -> int:
    """Check this machine: packages, system libraries, drawing, folders, memory; what lacks, what that costs, licences.

    Exit codes: 0 nothing is missing (programs marked optional may be), 1 something is.

    Parameters
    ----------
    store
        Folder of the reference's runs.
    """
    from compare.commands.doctor import run_doctor

    return run_doctor(store, show, print_json if as_json else None)
