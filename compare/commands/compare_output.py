"""What ``rollbench compare`` says of a scene: a verdict, one table, predictions beside the reference, files."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from compare.measure import LoadError, load_error
from compare.models.answers import load_answers
from compare.models.comparison import Loads
from compare.models.registry import DEFAULT, MODELS
from compare.reference.estimate import Reference
from compare.reference.grid_summary import uncertainty_percent
from compare.writing import replace_file
from meshes.parts import SIDES, Scene
from reports.html import harmless
from reports.records import Figure, Panel, Series

if TYPE_CHECKING:
    from rich.console import RenderableType

COLUMNS = ("model", "max err %", "at", "RMS %", "max N", "mean N", "MPa", "uz um", "s")


@dataclass(frozen=True)
class Beside:
    """A model beside the reference: its answer, its errors (None for the reference itself), pole pressure [Pa] of its worst
    contact and axial displacement [m] of the screw at the nut's centre."""

    answer: Loads
    error: LoadError | None
    pressure: float
    displacement: float

    @property
    def label(self) -> str:
        """Name for tables."""
        return self.answer.model


def beside(scene: Scene, answer: Loads, found: Reference | None) -> Beside:
    """An answer beside a reference, or by itself."""
    worst = load_answers(scene, answer.load, np.radians(answer.angle)).worst
    moved = float(np.interp(scene.nut.position, answer.stations, answer.line[:, 2])) if answer.stations.size else np.nan
    error = None if found is None else load_error(answer.load, found.load)
    return Beside(answer, error, 0.0 if worst is None else worst.pressure, moved)


def is_itself(answer: Loads, found: Reference) -> bool:
    """Whether an answer is the run that it would be compared with."""
    return answer.model == f"3D level {found.best.level}"


def levels_text(found: Reference) -> str:
    """Levels of the reference and its uncertainty, in words."""
    levels = ", ".join(str(run.level) for run in found.runs)
    bar = uncertainty_percent(found)
    if bar is None or len(found.runs) < 2:
        return (
            f"3D reference on level {levels} only: one level gives no uncertainty, so that part of the error may be its own"
        )
    return f"3D reference on levels {levels}, itself uncertain by {bar:.2f} %"


def verdict(models: Sequence[Beside], found: Reference) -> str:
    """The first sentence: the error of the default model, or of the first one."""
    own = next((b for b in models if b.label == DEFAULT), models[0])
    e = own.error
    if e is None:
        return levels_text(found)
    where = f" (ball {e.ball} {e.side})" if e.ball else ""
    return (
        f"{own.label} is off by {e.max_percent:.2f} % of the mean load on the worst contact{where}, "
        f"{e.rms_percent:.2f} % RMS; {levels_text(found)}"
    )


def _cells(b: Beside) -> list[str]:
    e, held = b.error, b.answer.load[b.answer.load > 0.0]
    errors = ["", "", ""] if e is None else [f"{e.max_percent:.2f}", f"{e.ball} {e.side}".strip(), f"{e.rms_percent:.2f}"]
    return [
        b.label,
        *errors,
        f"{held.max(initial=0.0):.1f}",
        f"{held.mean() if held.size else 0.0:.1f}",
        f"{1e-6 * b.pressure:.0f}",
        f"{1e6 * b.displacement:.3f}",
        "" if b.answer.seconds is None else f"{b.answer.seconds:.2g}",
    ]


def table(models: Sequence[Beside], itself: Beside) -> RenderableType:
    """One row for each model, the reference first; narrower than 80 columns."""
    from rich.table import Table

    out = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0))
    for k, name in enumerate(COLUMNS):
        out.add_column(name, justify="left" if k == 0 else "right", no_wrap=True)
    for b in (itself, *models):
        out.add_row(*_cells(b))
    return out


def contact_rows(scene: Scene, models: Sequence[Beside], found: Reference) -> list[dict[str, Any]]:
    """One row for each contact: loads [N] of reference, its uncertainty, and of the models."""
    rows = []
    loaded = (found.load > 0.0) | np.any([b.answer.load > 0.0 for b in models], axis=0)
    for i, s in zip(*np.nonzero(loaded), strict=True):
        row: dict[str, Any] = {"scene": scene.name, "ball": int(i) + 1, "side": SIDES[int(s)]}
        row |= {"reference_N": float(found.load[i, s])}
        row |= {"uncertainty_N": None if found.uncertainty is None else float(found.uncertainty[i, s])}
        rows.append(row | {f"{b.label}_N": float(b.answer.load[i, s]) for b in models})
    return rows


def load_figure(name: str, models: Sequence[Beside], found: Reference) -> Figure:
    """Loads over the balls, a panel for each flank of the screw that carries load."""
    panels = []
    for s in (0, 1):
        if not (found.load[:, s] > 0.0).any():
            continue
        balls = list(range(1, found.load.shape[0] + 1))
        value = found.load[:, s]
        bar = None if found.uncertainty is None else found.uncertainty[:, s]
        ends = None if bar is None else ((value - bar).tolist(), (value + bar).tolist())
        series = [Series("3D reference", balls, value.tolist(), "line+markers", emphasis=True, bars=ends)]
        series += [Series(b.label, balls, b.answer.load[:, s].tolist(), "line") for b in models if b.label in MODELS]
        panels.append(Panel(f"screw's flank {SIDES[s]}", "ball", "contact load / N", series, integer_x=True))
    return Figure(name, "Contact loads: prediction beside reference", panels)


def write_files(scene: Scene, models: Sequence[Beside], found: Reference, store: Path) -> str:
    """Write the contacts as CSV and the figure as SVG into the store; a line that says so."""
    from reports.figures import draw

    rows = contact_rows(scene, models, found)
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]))
    writer.writeheader()
    writer.writerows({k: harmless(v) if isinstance(v, str) else v for k, v in row.items()} for row in rows)
    stem = store / f"{scene.name}-compare"
    replace_file(Path(f"{stem}.csv"), text.getvalue())
    replace_file(Path(f"{stem}.svg"), draw(load_figure("compare-loads", models, found)))
    return f"wrote {stem}.csv (every contact) and {stem}.svg"
