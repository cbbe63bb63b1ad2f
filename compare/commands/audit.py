"""Many entries: audit."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from rollbench.compare.commands.terminal import Json, app
from rollbench.compare.text.printing import print_answer


@app.command
def audit(
    *,
    only: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    write: Path | None = None,
    as_json: Json = False,
) -> int:
    """Judge every printed entry of the sources; exit 1 where a verdict differs from the stored list.

    Parameters
    ----------
    only
        Names of printed tables; all unless given.
    write
        File to write the list of verdicts to, as compare/printed/audit/verdicts.json holds it, or with --only the
        verdicts.json of a source's folder.
    """
    from rollbench.compare.wings.evidence.command import run_audit

    return print_answer(run_audit(only or (), write=write), as_json)
