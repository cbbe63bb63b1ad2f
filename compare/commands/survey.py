"""Commands ``survey`` and ``stability``: solve many scenes that test the models and the solvers.

``survey`` measures the errors of a model on 360 randomly drawn ball screws with stored 3D references. ``stability`` solves
extreme scenes to find failures of the solvers; it also draws the ball screws and solves their 3D references.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

from rollbench.compare.commands.terminal import (
    Json,
    Names,
    ProgramOptions,
    app,
    model_or_program_name,
    refuse_given_arguments,
)
from rollbench.compare.errors import ArgumentError
from rollbench.compare.running import show_progress_message
from rollbench.compare.text.printing import CommandOutput, TextTable, format_cell, print_command_output, table_of_records

if TYPE_CHECKING:
    from rollbench.compare.studies.extremes import FormulationOutcome
    from rollbench.compare.studies.survey_models import Survey, SurveyRow


@app.command
def survey(
    *,
    model: Names = None,
    count: int = 360,
    max_error: float = 7.0,
    screw: int | None = None,
    out: Path = Path(),
    workers: int | None = None,
    store: Path | None = None,
    as_json: Json = False,
    program: ProgramOptions | None = None,
) -> int:
    """Measure the errors of a model on 360 typical ball screws, for which runs of the 3D reference are stored.

    The dimensions of the screws were drawn at random within the range of catalogues. Only the model is computed. Prints a
    table that also has the models of rollbench, and writes the results for every screw (CSV) and a figure. Exit code 1 if
    the model has no result for a screw. If it fails on the first five screws, the others are skipped.

    Parameters
    ----------
    model
        Names of models (rollbench list shows all), or models of an installed package.
    count
        Number of screws to solve, counted from the first. Default: all 360.
    max_error
        Largest permitted error of the contact loads for the verdicts, in per cent, as in rollbench check.
    screw
        Number of a randomly drawn screw. Writes it as a scene file, with its reference loads for check and compare
        --reference, and solves nothing.
    out
        Folder for the written files. Default: the current folder.
    workers
        Number of screws solved in parallel. Default: 1.
    store
        Folder in which each solved screw is stored, and from which an interrupted run of the same model resumes.
    """
    from rollbench.compare.files import check_writable, write_csv, write_figure, written_together
    from rollbench.compare.models.programs import model_title
    from rollbench.compare.studies.survey_models import compare_models_on_random_screws

    command = model_or_program_name(program)
    models = list(dict.fromkeys([*(model or ()), *filter(None, [command])]))
    if screw is not None:
        if models:
            advice = "leave the model out: this option only writes the randomly drawn screw"
            raise ArgumentError("screw", f"{screw} with a model", "only without a model", advice)
        return print_command_output(write_drawn_screw(screw, out), as_json)
    if not models:
        raise ArgumentError("model", "nothing", "a model, or `model_command`", "state the model to be judged")
    stem = re.sub(r"[^\w.]+", "-", f"survey-{'-'.join(map(model_title, models))}")
    table, drawing = out / f"{stem}.csv", out / f"{stem}.svg"
    for path in (table, drawing):
        check_writable(path)
    found = compare_models_on_random_screws(models, count, workers, max_error, show_progress_message, store)
    drawn = "no figure"
    with written_together():
        write_csv(table, found.frame_rows())
        if (figure := found.figure()) is not None:
            drawn = write_figure(drawing, figure)
    parts = [*_survey_terminal_parts(found), f"wrote {table} (every screw) and {drawn}"]
    answer = CommandOutput(found.to_dict(), parts, 1 if any(found.without_answer.values()) else 0)
    return print_command_output(answer, as_json)


def _survey_terminal_parts(found: Survey) -> Iterator[Any]:
    """Yield the sentences and tables in which the terminal shows the errors of models on the randomly drawn screws."""
    from rollbench.compare.models.programs import model_title
    from rollbench.compare.studies.survey import LEVEL as SURVEY_LEVEL
    from rollbench.compare.studies.survey_models import WORST, median_errors_by_screw_kind

    missing = "" if found.screws == found.of else f", out of {found.of}"
    for name in found.judged:
        rows, title = found.rows[name], model_title(name)
        answered = sorted((r for r in rows if r.verdict), key=lambda r: -(r.largest_percent or 0.0))
        if answered:
            known = [(r.largest_percent, r.uncertainty_percent, r.seconds) for r in answered]
            sizes, bars, times = ([x for x in column if x is not None] for column in zip(*known, strict=True))
            counts = ", ".join(f"{n} {word}" for word, n in sorted(found.verdicts[name].items()))
            yield (
                f"error of {title} on the worst contact: median {median(sizes):.3g} %, largest {max(sizes):.3g} % of the "
                f"mean load, over {len(answered)} drawn ball screws; uncertainty of the 3D reference on mesh level "
                f"{SURVEY_LEVEL}, from experience: median {median(bars):.2g} %, largest {max(bars):.2g} %; computing time "
                f"{median(times):.2g} s a screw"
            )
            yield f"verdicts with a limit of {found.max_error:g} %: {counts}"
            yield "screws with the largest errors: " + "; ".join(
                f"screw {r.screw} ({r.title}) {r.largest_percent:.3g} % at ball {r.at}" for r in answered[:WORST]
            )
        reasons: dict[str, list[int]] = {}
        for r in (r for r in rows if not r.verdict):
            reasons.setdefault(re.sub(r"survey-\d+-\d+", "the screw", r.status), []).append(r.screw)
        for reason, numbers in reasons.items():
            yield f"no result for {len(numbers)} of {len(rows)} screws, the first is number {numbers[0]}: {reason}"
    yield f"screws with a stored reference: {found.screws}{missing}"
    yield from _errors_on_screws_drawn_later(found.rows)
    title = "absolute errors over the screws / %; errors of loads in per cent of the mean load"
    yield table_of_records(found.summary, ".2f", title)
    title = "median error of the worst contact load by kind of screw / % of the mean load"
    yield table_of_records(median_errors_by_screw_kind(found.rows), ".2f", title)


def _errors_on_screws_drawn_later(models: Mapping[str, Sequence[SurveyRow]]) -> Iterator[str]:
    """Yield a sentence for each model on its errors on the screws that were drawn after refined and lin last changed.

    ``models``: errors of each model on each screw.
    """
    import numpy as np

    from rollbench.compare.models.programs import model_title
    from rollbench.compare.studies.survey import SCENES
    from rollbench.compare.studies.survey_models import errors_of_rows

    for name, rows in models.items():
        sizes = errors_of_rows([r for r in rows if r.screw >= SCENES], "largest_percent")
        if sizes:
            yield (
                f"on {len(sizes)} screws drawn after refined and lin last changed, error of {model_title(name)} on the "
                f"worst contact: median {median(sizes):.3g} %, 95th percentile {np.percentile(sizes, 95):.3g} %, largest "
                f"{max(sizes):.3g} % of the mean load"
            )


def write_drawn_screw(number: int, out: Path) -> CommandOutput:
    """Write a randomly drawn screw as a scene file, and its reference loads as a CSV file, to the folder ``out``.

    ``number``: number of the screw. Raises InputError in the cases in which `write_scene_and_reference_files` raises it.
    """
    from rollbench.compare.studies.survey_models import write_scene_and_reference_files

    text, loads = write_scene_and_reference_files(number, out)
    command = f"rollbench check {shlex.quote(str(text))} --reference {shlex.quote(str(loads))} --model MODEL"
    line = f"wrote {text} and {loads}; judge a model on them by: {command}"
    return CommandOutput({"files": [str(text), str(loads)]}, [line])


def _stability_tables(rows: Sequence[FormulationOutcome], failures: Sequence[FormulationOutcome]) -> Iterator[Any]:
    """Yield the table of the outcome of each solver on each extreme scene, counts by solver, and a line for each failure.

    ``rows``: outcomes of every solver on every scene. ``failures``: outcomes of rollbench's own solvers that did not
    converge as expected, or whose contact loads differ between two solvers.
    """
    from rollbench.compare.studies.extremes import count_expected_outcomes, formulations, stability_table_rows

    words = ("case", *formulations())
    lines = [[*(str(line[f]) for f in words), format_cell(line["residual"], ".1e")] for line in stability_table_rows(rows)]
    yield TextTable((*words, "residual"), lines, "outcome of every solver on extreme scenes")
    for name, (solved, tried, total) in count_expected_outcomes(rows).items():
        yield f"{name}: solved {solved} of {tried} attempted scenes; the table has {total}"
    for row in failures:
        yield f"FAILED: {row.case}: {row.status}; expected outcome: {row.expected}"


def solve_drawn_screws(
    count: int, folder: Path, workers: int, keep: Path | None, kind: str = "ball screw"
) -> CommandOutput:
    """Compute the 3D reference of randomly drawn screws, and return the errors of the models on them and the failures.

    ``count``: number of screws, counted from the first. ``kind``: their kind, a key of `survey.KINDS`.

    ``folder``: folder in which each solved screw is stored. ``workers``: number of screws solved in parallel. ``keep``:
    file for the results that the report reads; None: it is not written. The exit code is 1 if a screw has no result. Raises
    InputError for a count out of range, a folder with other contents, and a file that cannot be written.
    """
    from rollbench.compare.files import check_writable, replace_file
    from rollbench.compare.studies import survey
    from rollbench.compare.studies.survey import KINDS, SEED

    kind = kind.replace("-", " ")
    if kind not in KINDS:
        allowed = ", ".join(name.replace(" ", "-") for name in KINDS)
        raise ArgumentError("kind", kind, allowed, "choose one of these kinds")
    if not 1 <= count <= KINDS[kind].scenes:
        allowed = f"a number of scenes from 1 to {KINDS[kind].scenes}"
        raise ArgumentError("survey", str(count), allowed, "choose a number in that range")
    if keep is not None:
        check_writable(keep)
    records = survey.solve_screws_of_survey(SEED, count, folder, workers, show_progress_message, keep, kind)
    bad = survey.records_without_converged_loads(records)
    if keep is not None:
        from rollbench.compare.studies.survey_models import store_reference_loads

        replace_file(keep, survey.survey_records_as_json(SEED, records, kind))
        store_reference_loads(keep.with_name(KINDS[kind].loads), folder / "runs", count, kind)
    found = survey.error_summary_rows_of_all_models(records)
    parts: list[Any] = [table_of_records(found)] if found else []
    parts.append(f"{len(records) - len(bad)} of {len(records)} scenes have a result")
    parts += [f"scene {r['number']}: {r['status']}" for r in bad]
    return CommandOutput({"scenes": records, "without_answer": len(bad)}, parts, 1 if bad else 0)


@app.command
def stability(
    *,
    survey: int | None = None,
    kind: str | None = None,
    out: Path | None = None,
    workers: int | None = None,
    keep: Path | None = None,
    as_json: Json = False,
) -> int:
    """Solve very stiff and other extreme scenes by rollbench's solvers and by Lin's Newton method, and print a table.

    Exit code 1 if a solver of rollbench fails; failures of Lin's Newton method are only shown.

    With --survey, solves the 3D reference of ordinary catalogue screws instead, which takes half a minute to some minutes
    for each; exit code 1 if a screw has no result, or if its contact loads did not converge.

    Parameters
    ----------
    survey
        Number of screws to solve, whose dimensions are drawn at random within the range of catalogues; the report uses
        300, 60 new screws of another seed, and 24 double nuts.
    kind
        Kind of the screws: ball-screw (default) or double-nut.
    out
        Folder for a record of each screw and for the runs of the 3D reference, from which an interrupted survey
        resumes. Default: rollbench-survey.
    workers
        Number of screws solved in parallel, which need up to 4 GB each. Default: 1.
    keep
        File for the results, which the report reads. The loads are written to a file in the same folder, which rollbench
        survey reads. Screws whose results are in this file already are not solved again.
    """
    if survey is not None:
        found = solve_drawn_screws(survey, out or Path("rollbench-survey"), workers or 1, keep, kind or "ball screw")
        return print_command_output(found, as_json)
    given, advice = {"kind": kind, "out": out, "workers": workers, "keep": keep}, "add --survey COUNT, the number of screws"
    refuse_given_arguments(given, "only with `survey`", advice)
    from rollbench.compare.studies.extremes import solve_all_hard_scenes, unexpected_outcomes

    rows = solve_all_hard_scenes(lambda done, total, case: show_progress_message(f"[{done}/{total}] {case}"))
    bad = unexpected_outcomes(rows)
    data = {"failures": len(bad), "rows": [asdict(r) for r in rows]}
    answer = CommandOutput(data, _stability_tables(rows, bad), 1 if bad else 0)
    return print_command_output(answer, as_json)
