"""Command ``rollbench stability``: solves extreme scenes, or randomly drawn screws, to find failures of the solvers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.commands.terminal import Json, app
from rollbench.compare.errors import ArgumentError
from rollbench.compare.running import on_terminal
from rollbench.compare.text.printing import Answer, aligned_table, cell, print_answer, ruled_table

if TYPE_CHECKING:
    from rich.console import RenderableType

    from rollbench.compare.studies.extremes import Attempt


def run_stability() -> Answer:
    """Solve the extreme scenes with all solvers, and return the outcomes; exit code 1 if rollbench's solver fails."""
    from rollbench.compare.studies.extremes import solve_cases, unexpected_attempts

    rows = solve_cases(lambda done, total, case: on_terminal(f"[{done}/{total}] {case}"))
    bad = unexpected_attempts(rows)
    data = {"failures": len(bad), "rows": [asdict(r) for r in rows]}
    return Answer(data, _stability_tables(rows, bad), 1 if bad else 0)


def _stability_tables(rows: Sequence[Attempt], bad: Sequence[Attempt]) -> Iterator[RenderableType]:
    """Yield the table of outcomes by case and solver, the counts of each solver, and a line for each failure ``bad``."""
    from rollbench.compare.studies.extremes import FORMULATIONS, count_outcomes, rows_by_case

    words = ("case", *FORMULATIONS)
    lines = (
        [*(str(line[f]) for f in words), cell(line["residual"], ".1e"), cell(line["difference"], ".0e")]
        for line in rows_by_case(rows)
    )
    yield ruled_table("stability: cases by formulations", (*words, "residual", "difference %"), lines, words)
    for name, (solved, tried, total) in count_outcomes(rows).items():
        yield f"{name}: solved {solved} of {tried} attempted cases, out of {total}"
    for row in bad:
        yield f"FAILED: {row.case}: {row.status}; expected outcome: {row.expected}"


def run_drawn(count: int, folder: Path, workers: int, keep: Path | None) -> Answer:
    """Solve the first ``count`` randomly drawn screws with the 3D reference, and return errors of the models and failures.

    ``folder``: folder of the runs. ``keep``: file for the results that the report reads; None: not written. The exit code
    is 1 if a screw has no result. Raises InputError for a count out of range, a folder with other contents, and a file that
    cannot be written.
    """
    from rollbench.compare.files import need_writable, replace_file
    from rollbench.compare.running import on_terminal
    from rollbench.compare.studies import survey
    from rollbench.compare.studies.survey import SCENES, SEED

    if not 1 <= count <= SCENES:
        raise ArgumentError("survey", str(count), f"1 to {SCENES}", "choose a number in that range")
    if keep is not None:
        need_writable(keep)
    records = survey.run_survey(SEED, count, folder, workers, on_terminal, keep)
    bad = survey.unsolved_records(records)
    if keep is not None:
        from rollbench.compare.studies.survey_models import LOADS, store_loads

        replace_file(keep, survey.survey_json(SEED, records))
        store_loads(keep.with_name(LOADS), folder / "runs", count)
    found = survey.summary_rows(records)
    parts: list[Any] = [aligned_table(found)] if found else []
    parts.append(f"{len(records) - len(bad)} of {len(records)} scenes have a result")
    parts += [f"scene {r['number']}: {r['status']}" for r in bad]
    return Answer({"scenes": records, "without_answer": len(bad)}, parts, 1 if bad else 0)


@app.command
def stability(
    *,
    survey: int | None = None,
    out: Path | None = None,
    workers: int | None = None,
    keep: Path | None = None,
    as_json: Json = False,
) -> int:
    """Solve a table of very stiff and other extreme scenes with all solvers; exit code 1 if the solver of rollbench fails.

    With --survey, solves the 3D reference of ordinary catalogue screws instead, which takes half a minute to some minutes
    for each; exit code 1 if a screw has no result, or if its loads did not converge with mesh refinement.

    Parameters
    ----------
    survey
        Number of randomly drawn catalogue screws to solve; the report uses 300.
    out
        Folder with one line per screw and the runs of the 3D reference, where an interrupted survey resumes. Default:
        rollbench-survey.
    workers
        Number of screws solved in parallel, which need up to 4 GB each. Default: 1.
    keep
        File for the results, which the report reads. The loads are written to a file in the same folder, which rollbench
        survey reads. Screws that this file already has are not solved again.
    """
    if survey is not None:
        return print_answer(run_drawn(survey, out or Path("rollbench-survey"), workers or 1, keep), as_json)
    if (out, workers, keep) != (None, None, None):
        given = "one of these options without --survey"
        raise ArgumentError("out, workers, keep", given, "only with --survey", "add --survey COUNT")
    return print_answer(run_stability(), as_json)
