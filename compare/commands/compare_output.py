"""Tables and files in which ``rollbench compare`` shows the results of one scene."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.files import write_csv, write_figure
from rollbench.compare.measure import mean_load
from rollbench.compare.models.registry import is_model
from rollbench.compare.reference.estimate import Reference
from rollbench.compare.results.compared import OURS, Compared, ComparedLoads
from rollbench.compare.sections.curves import load_curve, load_panel
from rollbench.compare.text.printing import cell, plain_table, ruled_table
from rollbench.meshes.parts import SIDES, Scene
from rollbench.reports.content import Figure

if TYPE_CHECKING:
    from rich.console import RenderableType

    from rollbench.compare.studies.rolling.rows import RollingRow

#: Headings of the table of models.
COLUMNS = ("model", "max err %", "at", "RMS %", "gate %", "max N", "mean N", "MPa", "uz um", "s")


def start_lines(whole: Compared) -> list[str]:
    """Return a line that states from which position displacements are measured; no line if it is the nominal position."""
    if not whole.start:
        return []
    return [
        f"displacements of models and reference are measured from the position without loads, which is "
        f"{1e6 * whole.start:.3g} um from the nominal position by the model {whole.judged_model.title}"
    ]


def _error_cells(b: ComparedLoads) -> list[str]:
    """Return the cells of the table of models for one model or the reference, in the order of `COLUMNS`."""
    e, loads = b.error, b.answer.load[b.answer.load > 0.0]
    at = "" if e is None else f"{e.ball} {e.side}".strip()
    errors = () if e is None else (f"{e.max_percent:.2f}", at, f"{e.rms_percent:.2f}", f"{b.by_gate:.2f}")
    return [
        b.title,
        *(errors or [""] * 4),
        f"{loads.max(initial=0.0):.1f}",
        f"{mean_load(loads, b.contacts):.1f}",
        f"{1e-6 * b.pressure:.0f}",
        f"{1e6 * b.displacement:.3f}" if np.isfinite(b.displacement) else "–",
        "" if not b.answer.seconds or b.answer.measured else f"{b.answer.seconds:.{0 if b.answer.seconds >= 10.0 else 2}f}",
    ]


def models_table(models: Sequence[ComparedLoads], itself: ComparedLoads) -> RenderableType:
    """Return the table of models and coarser meshes with their errors, the reference ``itself`` in the first row."""
    return plain_table(COLUMNS, map(_error_cells, (itself, *models)), COLUMNS[:1])


def older_times(models: Sequence[ComparedLoads], itself: ComparedLoads) -> list[str]:
    """Return lines with the computing times of stored runs, and with which version and computer they were measured.

    The table of models has only times that were measured now.
    """
    by_stamp: dict[str, list[str]] = {}
    for b in (itself, *models):
        if b.answer.seconds and b.answer.measured:
            by_stamp.setdefault(b.answer.measured, []).append(f"{b.title} {b.answer.seconds:.0f} s")
    return [f"stored times, measured with {stamp}: {', '.join(times)}" for stamp, times in by_stamp.items()]


def contact_rows(scene: Scene, models: Sequence[ComparedLoads], reference: Reference) -> list[dict[str, Any]]:
    """Return a row for each loaded contact: load of the reference, its uncertainty, and loads of the models [N]."""
    rows = []
    loaded = (reference.load > 0.0) | np.any([b.answer.load > 0.0 for b in models], axis=0)
    for i, s in zip(*np.nonzero(loaded), strict=True):
        row: dict[str, Any] = {"scene": scene.name, "ball": int(i) + 1, "side": SIDES[int(s)]}
        row |= {"reference_N": float(reference.load[i, s])}
        row |= {"uncertainty_N": float(reference.uncertainty[i, s])}
        rows.append(row | {f"{b.title}_N": float(b.answer.load[i, s]) for b in models})
    return rows


def load_figure(name: str, models: Sequence[ComparedLoads], reference: Reference) -> Figure:
    """Return the figure of contact loads over the ball number, with a panel for each loaded groove flank of the screw."""
    panels = []
    for s in (0, 1):
        if not (reference.load[:, s] > 0.0).any():
            continue
        series = [load_curve(reference.label, reference, s, emphasis=True, bar=reference.uncertainty)]
        series += [load_curve(b.title, b.answer, s, "line") for b in models if b.label == OURS or is_model(b.label)]
        panels.append(load_panel(f"screw's flank {SIDES[s]}", *series))
    return Figure(name, "Contact loads: prediction and reference", panels)


def write_files(scene: Scene, models: Sequence[ComparedLoads], reference: Reference, store: Path) -> str:
    """Write the loads of all contacts (CSV) and their figure (SVG) to a folder; return a line that names both files."""
    rows = contact_rows(scene, models, reference)
    stem = store / f"{scene.name}-compare"
    write_csv(Path(f"{stem}.csv"), rows)
    figure = write_figure(Path(f"{stem}.svg"), load_figure("compare-loads", models, reference))
    return f"wrote {stem}.csv (every contact) and {figure}"


#: Columns of the table of rolling contact after the quantity: attribute of a row, heading, number format.
ROLLING_COLUMNS = (
    ("low", "low-order", ".5g"),
    ("reference", "3D", ".5g"),
    ("uncertainty", "+-", ".2g"),
    ("error_percent", "error %", ".2f"),
    ("uncertainty_percent", "+- %", ".2f"),
    ("printed", "printed", ".5g"),
    ("printed_ansys", "ANSYS", ".5g"),
    ("flat", "3D flat", ".5g"),
    ("rigid", "3D rigid", ".5g"),
    ("half_space", "3D half space", ".5g"),
)


def rolling_table(name: str, rows: Sequence[RollingRow]) -> Any:
    """Return the table that compares the low-order model of rolling contact with the 3D model and with printed values."""
    from rollbench.compare.studies.rolling.rows import UNSTATED, without_infinity

    state = f" ({rows[0].load_state} load state{UNSTATED})" if rows[0].load_state else ""
    title = f"{name}{state}: low-order model against the 3D model of rolling"
    known = [without_infinity({key: getattr(r, key) for key, *_ in ROLLING_COLUMNS}) for r in rows]
    cells = (
        [f"{r.quantity} [{r.unit}]", *(cell(x[key], form) for key, _, form in ROLLING_COLUMNS)]
        for r, x in zip(rows, known, strict=True)
    )
    table = ruled_table(title, ["quantity", *(heading for _, heading, _ in ROLLING_COLUMNS)], cells, ["quantity"])
    table.caption = f"time of the low-order model: {1e3 * rows[0].low_seconds:.2f} ms, measured now; of the 3D model on "
    table.caption += f"the finest grid: {rows[0].seconds:.2f} s, measured with {rows[0].measured_with}"
    return table
