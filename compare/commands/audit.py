"""The command ``rollbench audit``."""

from __future__ import annotations

from pathlib import Path

from rollbench.compare.commands.terminal import Json, Names, app
from rollbench.compare.text.printing import print_answer


@app.command
def audit(*, only: Names = None, write: Path | None = None, as_json: Json = False) -> int:
    """Judge every printed entry of the sources: the name that rollbench check --printed had, kept until 1.0.

    Parameters
    ----------
    only
        Names of printed tables or entries; all unless given.
    write
        File to write the verdicts to.
    """
    from rollbench.compare.commands.printed import run_printed

    return print_answer(run_printed((), only or (), write), as_json)
