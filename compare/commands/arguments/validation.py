"""The whole validation: report, check, stability, bench."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from compare.commands.arguments.terminal import Json, Tls, app, engine, print_json, show
from compare.errors import InputError


@app.command
def report(
    *,
    only: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    out: Path = Path("rollbench-report"),
    quick: Annotated[bool, Parameter(negative="")] = False,
    stored: Annotated[bool, Parameter(negative="")] = False,
    store: Path = Path("rollbench-reference"),
    fresh: Annotated[bool, Parameter(negative="")] = False,
    backend: str = "joblib",
    scheduler: str | None = None,
    workers: int | None = None,
    tls: Tls | None = None,
) -> int:
    """Regenerate the validation report: one HTML file, its tables as CSV, its figures as SVG.

    Parameters
    ----------
    only
        Names of the sections to make; all of them unless given.
    out
        Folder to write to.
    quick
        Coarsest mesh of the 3D reference and cases 1 and 2 only, no pictures, stability or timing; the report says so.
    stored
        Compute no run of the 3D reference: use those that come with the package, and leave out what they do not hold.
    store
        Folder of the runs of the 3D reference that are computed; an interrupted report goes on from there. Runs of the
        package are used where the key of all that they depend on holds.
    fresh
        Compute all runs anew, whatever the folder and the package hold.
    backend
        joblib (this machine) or dask (a cluster), for the 3D reference.
    scheduler
        Address of the Dask scheduler.
    workers
        Runs of the 3D reference at the same time, each of up to 4 GB; 2 here, or what the cluster has, unless given.
    """
    from compare.commands.report import make_report

    where = engine(backend, scheduler, workers or (2 if scheduler is None else None), tls)
    return make_report(only or (), out, quick=quick, stored=stored, store=store, engine=where, fresh=fresh)


@app.command
def check(*, max_error: float = 7.0, as_json: Json = False) -> int:
    """Check against hard printed values and closed forms; exit 1 and the rows where the error is too large.

    Parameters
    ----------
    max_error
        Largest error allowed, in per cent, for rows that have no tighter tolerance of their own.
    """
    from compare.gate.gate import run_gate

    if not 0.0 < max_error <= 100.0:
        raise InputError("command line", "--max-error", str(max_error), "above 0 to 100 per cent", "the gate uses 7")
    rows = run_gate(max_error)
    bad = [row for row in rows if not row.passed]
    if as_json:
        print_json({"max_error_percent": max_error, "passed": not bad, "rows": [row.as_json() for row in rows]})
    else:
        from compare.gate.gate import as_table

        show(as_table(rows), f"{len(rows) - len(bad)} passed, {len(bad)} failed")
    return 1 if bad else 0


@app.command
def stability(
    *,
    random: int | None = None,
    seed: int = 1,
    model: str = "",
    files: int = 0,
    kills: int = 0,
    keep: Path | None = None,
    as_json: Json = False,
) -> int:
    """Run the table of stiff and extreme scenes; exit 1 where this project's solver fails on any.

    With --random instead: a campaign of random extreme screws and bearings, each outcome judged by a check of its own.

    Parameters
    ----------
    random
        Number of random extreme scenes.
    seed
        Seed of the campaign; scene K of a seed is the same whatever else is run.
    model
        Model of the campaign's contact loads; lin unless given.
    files
        Besides, so many mutated scene files and half as many mutated stored files.
    kills
        Besides, so often a process that writes is killed.
    keep
        File to write the campaign's counts to, for the report's table.
    """
    from compare.commands.stability import run_campaign, run_stability

    if random is None:
        if seed != 1 or model or files or kills or keep is not None:
            raise InputError(
                "command line", "--seed, --model, --files, --kills, --keep", "given", "with --random", "add it"
            )
        return run_stability(as_json=as_json, show=show, print_json=print_json)
    return run_campaign(random, seed, model or "lin", files, kills, keep, as_json=as_json, show=show, print_json=print_json)


@app.command
def bench(*, as_json: Json = False) -> int:
    """Measure run times as ratios to the source's formulation in the same process."""
    from compare.commands.bench import run_bench_command

    return run_bench_command(as_json=as_json, show=show, print_json=print_json)
