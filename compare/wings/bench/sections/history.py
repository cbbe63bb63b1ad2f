"""What each release reached on the case studies: errors, uncertainty, run times, memory."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from rollbench.comparison import __version__
from rollbench.comparison.models.comparison import REFERENCED
from rollbench.comparison.models.registry import MODELS
from rollbench.comparison.models.study import Study
from rollbench.comparison.provenance import commit
from rollbench.comparison.reference.estimate import Reference
from rollbench.comparison.reference.grid_summary import uncertainty_percent
from rollbench.comparison.reference.store import shipped_store
from rollbench.comparison.wings.bench.costs.kept import (
    HISTORY,
    NAMES,
    QUANTITIES,
    Release,
    added,
    load_releases,
    save_rows,
    today,
)
from rollbench.comparison.wings.bench.sections.reference_time import TimePoint, all_points
from rollbench.reports.content import Cell, Figure, Panel, Quantity, Section, Series, Table, Text

#: How a report names its own numbers.
NOW = "this report"
ABOUT = (
    (
        "One row for each release and quantity over the four case studies of the source, which every release "
        "had: largest error, largest grid uncertainty, median run time, largest peak memory. Errors refer to "
        "the 3D reference that the release shipped, so a row changes with its reference too. Past releases are "
        "not recomputed."
    ),
)


def measured(points: Mapping[str, Sequence[TimePoint]], found: Mapping[str, Reference], commit: str) -> Release:
    """Numbers of this report as a release of the present version."""
    by_scene = {name: points[name] for name in REFERENCED if name in points}
    labels = {name: MODELS[name].label for name in NAMES if name in MODELS}
    taken: dict[str, list[TimePoint]] = {
        name: [p for several in by_scene.values() for p in several if p.label == label and p.status == "converged"]
        for name, label in labels.items()
    }
    taken[NAMES[-1]] = [[p for p in several if p.kind == "level"][-1] for several in by_scene.values()]
    bars = [uncertainty_percent(found[name]) for name in by_scene]
    errors: dict[str, float | None] = {name: max((p.error for p in taken[name]), default=None) for name in labels}
    memory = {name: [p.memory for p in some if p.memory is not None] for name, some in taken.items()}
    return Release(
        __version__,
        today(),
        commit,
        {
            "error": errors,
            "u": {NAMES[-1]: max(bars, default=None)},
            "cold": {name: float(np.median([p.cold for p in some])) if some else None for name, some in taken.items()},
            "memory": {name: max(some, default=None) for name, some in memory.items()},
        },
    )


def history_table(releases: Sequence[tuple[str, Release]]) -> Table:
    """A row for each release, by its name, and quantity."""
    rows: list[dict[str, Cell]] = [
        {"release": name, "date": one.date, "quantity": words, **one.values.get(key, {})}
        for name, one in releases
        for key, words in QUANTITIES.items()
    ]
    columns = [Quantity(name, name, "", "s") for name in ("release", "date", "quantity")]
    columns += [Quantity(name, name, "", "g3") for name in NAMES]
    note = "\n".join(f"{name}: {one.remark}" for name, one in releases if one.remark)
    return Table("history", "What each release reached on the case studies", columns, rows, note)


def history_figure(releases: Sequence[tuple[str, Release]]) -> Figure:
    """Every quantity over the releases."""
    panels = []
    for key, words in QUANTITIES.items():
        series = []
        for name in NAMES:
            points = [(k, one.values.get(key, {}).get(name)) for k, (_, one) in enumerate(releases, start=1)]
            known = [(float(k), float(value)) for k, value in points if value is not None]
            if known:
                series.append(Series(name, [k for k, _ in known], [value for _, value in known], "line+markers"))
        if series:
            panels.append(Panel("", "", words, tuple(series), log="y", names=[label for label, _ in releases]))
    return Figure("history", "Releases on the case studies", tuple(panels))


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report; a study that keeps adds the present version to its store."""
    step("numbers of this report beside those of the releases")
    points = study.once(all_points, step)
    title = "History of the releases"
    known = load_releases((*(study.stores or ()), shipped_store()))
    releases = [(one.version, one) for one in known]
    if any(name in points for name in REFERENCED):
        present = measured(points, study.references(tuple(points)), commit())
        releases.append((NOW, present))
        if study.keeps and study.stores and not study.quick:
            save_rows(study.stores[0], HISTORY, added(known, present))
    if not releases:
        return Section("history", title, (Text(("No release and no run of the 3D reference was found.",)),))
    return Section("history", title, (Text(ABOUT), history_table(releases), history_figure(releases)))
