"""Options and help of ``rollbench bench``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from rollbench.compare.commands.arguments.terminal import Flag, Json, app
from rollbench.compare.commands.printing import print_answer


@app.command
def bench(
    names: Annotated[list[str] | None, Parameter(negative="", show_default=False)] = None,
    /,
    *,
    long: Flag = False,
    store: Annotated[Path | None, Parameter(show_default=False)] = None,
    as_json: Json = False,
) -> int:
    """Measure run times as ratios to the source's formulation in the same process.

    Parameters
    ----------
    names
        With --long: beginnings of the names of jobs; all unless given.
    long
        Measure what takes minutes instead, an hour in all on quiet cores: friction in time, first use after installation,
        sweeps, audit, reports and, in a checkout, the tests.
    store
        With --long: folder of stored runs to keep these times in, which a report then shows.
    """
    from rollbench.compare.errors import ArgumentError
    from rollbench.compare.wings.bench.command import run_bench_command, run_long

    if not long and (names or store is not None):
        raise ArgumentError("names, store", "given", "with --long", "add --long")
    return print_answer(run_long(names or (), store) if long else run_bench_command(), as_json)
