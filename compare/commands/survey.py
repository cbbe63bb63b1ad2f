"""The command ``rollbench survey``: errors of a model on drawn ball screws whose reference is stored."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from rollbench.compare.commands.terminal import Json, Names, OfProgram, app, model_of
from rollbench.compare.errors import ArgumentError
from rollbench.compare.running import on_terminal
from rollbench.compare.text.printing import Answer, aligned, print_answer


@app.command
def survey(
    *,
    model: Names = None,
    count: int = 240,
    max_error: float = 7.0,
    screw: int | None = None,
    out: Path = Path(),
    workers: int | None = None,
    as_json: Json = False,
    program: OfProgram | None = None,
) -> int:
    """Measure the errors of a model on 240 typical ball screws whose 3D reference is stored.

    The screws are drawn at random from the range of catalogues; only the model is computed. Prints a table that also has
    the models of rollbench; writes every screw as CSV, and a figure. Exit code 1 where the model has no answer for a
    screw; after failures on the first five screws, the others are skipped.

    Parameters
    ----------
    model
        Models, by name (see: rollbench list), or of an installed package.
    count
        Use only the first screws, this many.
    max_error
        Limit of the error of loads for the verdicts, in per cent, as in rollbench check.
    screw
        Write the drawn screw of this number as a scene file, with its reference for check and compare --reference; judge
        nothing.
    out
        Folder for the written files. Default: the current folder.
    workers
        Number of screws solved in parallel. Default: 1.
    """
    command = model_of(program)
    models = [*(model or ()), *filter(None, [command])]
    if screw is not None:
        if models:
            raise ArgumentError("screw", str(screw), "without a model", "it writes a drawn screw")
        return print_answer(run_screw(screw, out), as_json)
    if not models:
        raise ArgumentError("model", "nothing", "a model, or `model_command`", "name the model to be judged")
    return print_answer(run_survey(models, count, max_error, out, workers), as_json)


def run_survey(models: Sequence[str], count: int, max_error: float, out: Path, workers: int | None) -> Answer:
    """Judge models and write table and figure; exit code 1 if a model fails on a screw.

    Raises InputError as `run_models`.
    """
    from rollbench.compare.files import need_writable, write_csv, write_figure
    from rollbench.compare.models.programs import title_of
    from rollbench.compare.studies.survey_models import run_models, survey_figure

    stem = re.sub(r"[^\w.]+", "-", f"survey-{'-'.join(map(title_of, models))}")
    table, drawing = out / f"{stem}.csv", out / f"{stem}.svg"
    for path in (table, drawing):
        need_writable(path)
    data = run_models(models, count, workers, max_error, on_terminal)
    write_csv(table, [{"model": title_of(name)} | dict(row) for name, rows in data["models"].items() for row in rows])
    drawn = (
        write_figure(drawing, survey_figure(data))
        if any("verdict" in r for r in data["models"][models[0]])
        else "no figure"
    )
    bad = sum(data["without_answer"].values())
    return Answer(data, [*_parts(data, models), f"wrote {table} (every screw) and {drawn}"], 1 if bad else 0)


def _parts(data: Mapping[str, Any], models: Sequence[str]) -> Iterator[Any]:
    from rollbench.compare.models.programs import title_of
    from rollbench.compare.studies.survey_models import WORST, median_errors_by_kind

    missing = "" if data["screws"] == data["of"] else f" of {data['of']}; of the others none is stored"
    for name in models:
        rows, title = data["models"][name], title_of(name)
        answered = sorted((r for r in rows if "verdict" in r), key=lambda r: -float(r["largest_percent"]))
        if answered:
            sizes, bars, times = ([r[k] for r in answered] for k in ("largest_percent", "uncertainty_percent", "seconds"))
            counts = ", ".join(f"{n} {word}" for word, n in sorted(data["verdicts"][name].items()))
            yield (
                f"{title} is off by {median(sizes):.3g} % of the mean load on the worst contact, median of "
                f"{len(answered)} drawn ball screws, by {max(sizes):.3g} % at most; 3D reference on "
                f"level {data['level']}, uncertain by {median(bars):.2g} % in the median, {max(bars):.2g} % at "
                f"most, by experience with its level; {median(times):.2g} s a screw"
            )
            yield f"check at {data['max_error_percent']:g} %: {counts}"
            yield "worst: " + "; ".join(
                f"screw {r['screw']} ({r['title']}) {r['largest_percent']:.3g} % at ball {r['at']}"
                for r in answered[:WORST]
            )
        reasons: dict[str, list[int]] = {}
        for r in (r for r in rows if "verdict" not in r):
            reasons.setdefault(re.sub(r"survey-\d+-\d+", "the screw", r["status"]), []).append(r["screw"])
        for reason, numbers in reasons.items():
            yield f"no answer for {len(numbers)} of {len(rows)} screws, the first {numbers[0]}: {reason}"
    yield f"{data['screws']} screws with a stored reference{missing}"
    yield aligned(data["summary"], ".2f", "sizes of errors over the screws / %, those of loads of the mean load")
    yield aligned(
        median_errors_by_kind(data["models"]),
        ".2f",
        "error of the worst load by kind of screw, medians / % of the mean load",
    )


def run_screw(number: int, out: Path) -> Answer:
    """Write a drawn screw and its reference. Raises InputError as `write_screw`."""
    from rollbench.compare.studies.survey_models import write_screw

    text, loads = write_screw(number, out)
    command = f"rollbench check {shlex.quote(str(text))} --reference {shlex.quote(str(loads))} --model MODEL"
    return Answer({"files": [str(text), str(loads)]}, [f"wrote {text} and {loads}, for: {command}"])
