"""Contact-load errors of models and 3D mesh levels over their run time, all on the same randomly drawn screws."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rollbench.compare.gate.verdict import LIMIT
from rollbench.compare.models.comparison import RULE
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_value
from rollbench.compare.reference.store import UNMEASURED, shipped_store, shows_times_of
from rollbench.compare.studies.survey_models import JUDGE, LoadErrorsAndTimes, errors_and_times, load_timed_runs
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Figure, Panel, Row, Series, Table, Text

#: Columns of the table of models and mesh levels, each with a field of `LoadErrorsAndTimes` and the percentile [%] shown.
STATISTICS = {
    "check_error_median": ("gate_errors", 50),
    "check_error_p95": ("gate_errors", 95),
    "largest_load_error_median": ("errors_of_mean_load", 50),
    "largest_load_error_of_screw": ("errors_of_mean_load", 100),
    "cpu_time_median": ("first_case_seconds", 50),
    "cpu_time_p95": ("first_case_seconds", 95),
    "cpu_time_further_median": ("further_case_seconds", 50),
}
#: Models and mesh level whose run times the first page tells.
SHOWN = ("lin", "refined", "3D level 1")
#: What the times are.
TIMES = (
    "Times are processor times of one core: of a new screw from its geometry to its loads, with an empty cache of meshes "
    "and without start and imports of Python; then of a further load case of the same screw."
)


def measured_on_drawn_screws(cache: SceneResultCache) -> list[LoadErrorsAndTimes]:
    """Return errors and times of models and mesh levels on random screws; empty if this version has not measured them."""
    kept = load_timed_runs((*(cache.reference_folders or ()), shipped_store()))
    return errors_and_times(kept.runs) if kept and shows_times_of(kept.measuring_conditions.version) else []


def number_of_screws(found: Sequence[LoadErrorsAndTimes]) -> int:
    """Return the number of screws on which models and mesh levels were timed, of errors and times of each."""
    return next(s.first_case_seconds.size for s in found if s.name == JUDGE)


def error_over_time_panel(found: Sequence[LoadErrorsAndTimes], time_kind: str = "new screw") -> Panel:
    """Return the panel of largest contact-load errors of models and 3D mesh levels over processor time, on random screws.

    Parameters
    ----------
    found
        Errors and times of each model or mesh level.
    time_kind
        Abscissa: time for a "new screw" or for a "further load case" of a screw solved before.
    """
    new = time_kind == "new screw"
    judged = [s for s in found if s.gate_errors.size]
    times = [float(np.median(s.first_case_seconds if new else s.further_case_seconds)) for s in judged]
    errors = [float(np.median(s.gate_errors)) for s in judged]
    bars = errors, [float(s.gate_errors.max()) for s in judged]
    fewer = [s.gate_errors.size < s.first_case_seconds.size for s in judged]
    names = [f"{s.name} ({s.gate_errors.size} screws)" if few else s.name for s, few in zip(judged, fewer, strict=True)]
    label = f"{number_of_screws(found)} drawn screws"
    series = [Series(label, times, errors, "markers", bold=True, error_bars=bars, point_labels=names)]
    edge: list[tuple[float, float]] = []
    for x, y in sorted(zip(times, errors, strict=True)):
        if not edge or y < edge[-1][1]:
            edge.append((x, y))
    series.append(Series("Pareto front", [x for x, _ in edge], [y for _, y in edge], "line"))
    ends = list(times)
    if new:
        errors = [printed_value("lin-2.4.1", f"case{case}_max_error") for case in (1, 2)]
        theirs = [printed_value("lin-2.2", f"time_proposed_{case}") for case in (1, 2)]
        series.append(Series("printed in Lin's thesis", theirs, errors, "markers", point_labels=["Lin's thesis", ""]))
        ansys = ansys_seconds()
        series.append(Series("ANSYS in the thesis", [ansys, ansys], [min(bars[0]), LIMIT], "line"))
        ends.append(ansys)
    series.append(Series(f"limit of {LIMIT:g} %", [min(ends), max(ends)], [LIMIT, LIMIT], "line"))
    return Panel("", f"processor time of a {time_kind} / s", "largest_check_error", tuple(series), log_axes="xy")


def ansys_seconds() -> float:
    """Return the run time of ANSYS on the first case study that Lin's thesis prints [s]."""
    return 3600.0 * printed_value("lin-2.2", "time_ansys_1")


def run_time_sentence(found: Sequence[LoadErrorsAndTimes]) -> str:
    """Return the sentence on the run times of models and mesh levels; ``found``: empty if they are not measured."""
    if not found:
        return UNMEASURED
    medians = {s.name: float(np.median(s.first_case_seconds)) for s in found}
    ours = ", ".join(f"{medians[name]:.2g} s by {name}" for name in SHOWN)
    return (
        f"A new screw takes {ours} (median processor time on {number_of_screws(found)} drawn screws, without "
        f"start and imports of Python). Lin's thesis prints {printed_value('lin-2.2', 'time_proposed_1'):g} s for its "
        f"model and {ansys_seconds() / 3600.0:.3g} h for ANSYS on its first case study."
    )


def caption_of_panel(found: Sequence[LoadErrorsAndTimes]) -> str:
    """Return the words that explain `error_over_time_panel`."""
    return (
        f"Markers: median of the largest error on a screw, {RULE}, against {JUDGE} (this one: against the next level); "
        f"bars: up to the largest on {number_of_screws(found)} screws drawn at random. Horizontal line: {LIMIT:g} %, the "
        "default limit of "
        "rollbench check. Lin's thesis: errors of its model against ANSYS, and run times, that it prints; vertical line: "
        "its run time of ANSYS."
    )


def error_and_time_items(cache: SceneResultCache) -> tuple[Text | Table | Figure, ...]:
    """Return figure, text and table of load errors and run times of models and 3D mesh levels on random screws.

    ``cache``: source of the folders of stored runs.
    """
    found = measured_on_drawn_screws(cache)
    if not found:
        return (Text((UNMEASURED,)),)
    screws, models = number_of_screws(found), [s for s in found if s.judge == JUDGE]
    fewer = {s.name: screws - s.first_case_seconds.size for s in models if s.first_case_seconds.size < screws}
    finest = {s.judge: s.gate_errors.size for s in found if s.name == JUDGE and s.gate_errors.size}
    own = "".join(f", those of {JUDGE} from {name} on {count} screws" for name, count in finest.items())
    failed = "".join(f"; {name} fails on {count} of them" for name, count in fewer.items())
    about = (
        f"All models and mesh levels were run on the same {screws} of the drawn screws, chosen with a fixed seed{failed}. "
        f"Errors are differences from {JUDGE}{own or ', whose own error is not known from these runs'}. {TIMES}"
    )
    rows: list[Row] = [
        {
            "model_or_level": s.name,
            "screws": s.first_case_seconds.size,
            **{column: _percentile(getattr(s, field), percent) for column, (field, percent) in STATISTICS.items()},
        }
        for s in found
    ]
    coarse = models[-1]
    title = (
        f"Largest difference of a contact load between mesh levels 1 and 2 on a drawn screw: median "
        f"{_percentile(coarse.gate_errors, 50):.2f} %; level 1 takes "
        f"{_percentile(coarse.first_case_seconds, 50):.0f} s per screw"
    )
    panels = tuple(error_over_time_panel(found, kind) for kind in ("new screw", "further load case"))
    return (
        Figure("survey-levels", title, panels, caption_of_panel(found), columns=2),
        Text((about,)),
        Table.from_rows(
            "stability-levels",
            "Contact-load errors and run times of models and 3D mesh levels on the same randomly drawn screws",
            rows,
            f"Rule of rollbench check: errors {RULE}.",
        ),
    )


def _percentile(values: Array, percent: float) -> float | None:
    """Return a percentile of the numbers in ``values`` (``percent``: 0 to 100); None if the array is empty."""
    return float(np.percentile(values, percent)) if values.size else None
