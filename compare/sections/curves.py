"""Curves of contact loads and displacements for the report's figures, and the convergence figure of a mesh study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.models.comparison import ContactSolution
from rollbench.compare.reference.estimate import Reference
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Figure, Panel, Series


def scale_to_python_floats(values: Array, factor: float = 1.0) -> list[float]:
    """Return ``factor`` times the values of an array as a list of Python floats, which the records of figures take."""
    return [factor * float(v) for v in values]


def lateral_displacement_curves(
    axial_positions: Array,
    displacements: Array,
    label_pattern: str = "u_{}",
    style: str = "line",
    *,
    emphasis: bool = False,
) -> tuple[Series, Series]:
    """Return two curves of a screw centreline's lateral displacement [um], in x and in y, over the axial position [mm].

    Parameters
    ----------
    axial_positions
        Axial positions, (k,) [m].
    displacements
        Displacements in x, y and possibly further directions, (k, 2 or more) [m].
    label_pattern
        Label of each curve, with the placeholder {} for the direction x or y.
    style
        Style of the curves, as in `Series`.
    emphasis
        Whether the curves are drawn bold.
    """
    z = scale_to_python_floats(axial_positions, 1e3)
    x, y = (
        Series(label_pattern.format(axis), z, scale_to_python_floats(displacements[:, k], 1e6), style, bold=emphasis)
        for k, axis in enumerate("xy")
    )
    return x, y


def contact_load_panel(title: str, *series: Series, axis_from_zero: bool = False) -> Panel:
    """Return a panel titled ``title`` with curves of contact loads [N] over the ball number.

    ``series``: the curves. ``axis_from_zero``: whether the ordinate begins at zero.
    """
    return Panel(title, "ball", "contact load / N", series, include_zero=axis_from_zero, integer_x=True)


def contact_load_curve(
    label: str,
    result: StaticResult | ContactSolution | Reference,
    side: int,
    style: str = "line+markers",
    *,
    emphasis: bool = False,
    uncertainty: Array | None = None,
) -> Series:
    """Return the curve of the contact loads [N] of all balls on one groove flank, over the ball number.

    Parameters
    ----------
    label
        Label of the curve.
    result
        Solution or reference whose contact loads are drawn.
    side
        Number of the flank: 0 to 3 for SL, SR, NL, NR (screw or nut, left or right).
    style
        Style of the curve, as in `Series`.
    emphasis
        Whether the curve is drawn bold.
    uncertainty
        Uncertainty of the loads of n balls on the four flanks, (n, 4) [N], drawn as error bars; None: no bars.
    """
    load = result.load[:, side]
    balls = [float(i + 1) for i in range(load.size)]
    ends = None
    if uncertainty is not None:
        bar = uncertainty[:, side]
        ends = (scale_to_python_floats(load - bar), scale_to_python_floats(load + bar))
    return Series(label, balls, scale_to_python_floats(load), style, bold=emphasis, error_bars=ends)


#: Largest number of curves in a panel.
MOST = 8


def mesh_convergence_figure(name: str, study_rows: Sequence[Mapping[str, Any]], reference: Reference) -> Figure | None:
    """Draw how the largest and smallest contact loads and the displacements of a scene converge with the cell size.

    The curves are differences from the finest mesh level, in per cent of the largest value in the panel, over the cell size
    relative to that of the finest level. The uncertainty at the finest level and the extrapolation to zero cell size are
    drawn too. Returns None for fewer than two mesh levels.

    Parameters
    ----------
    name
        Name of the scene.
    study_rows
        Rows of the mesh-study table: one quantity each, with its value on every mesh level.
    reference
        3D reference of the scene.
    """
    if len(reference.runs) < 2:
        return None
    sizes = [size / reference.sizes[-1] for size in reference.sizes]
    keys = [f"level {run.level}" for run in reference.runs]
    panels = []
    for title, rows in (
        ("contact loads", [row for row in study_rows if "est load" in row["quantity"]]),
        ("displacement of the centreline", [row for row in study_rows if row["quantity"].startswith("centreline")]),
    ):
        scale = max((abs(row[keys[-1]]) for row in rows), default=0.0)
        series = [s for row in rows[:MOST] for s in _convergence_curve_and_power_law(row, keys, sizes, scale)]
        if series:
            label = f"difference from the finest level / % of {scale:.3g} {rows[0]['unit']}"
            panels.append(Panel(title, "cell size / cell size of the finest level", label, tuple(series)))
    if not panels:
        return None
    caption = "Bars: uncertainty of the finest mesh level. Thin lines to cell size zero: extrapolations by a power law."
    title = f"Convergence of contact loads and displacements of {name} with the cell size"
    return Figure(f"mesh-study-{name}", title, tuple(panels), caption)


def _convergence_curve_and_power_law(
    row: Mapping[str, Any], level_keys: Sequence[str], relative_cell_sizes: Sequence[float], scale: float
) -> list[Series]:
    """Return the curve of one quantity over the cell size, and the fitted power law to cell size zero if there is one.

    Parameters
    ----------
    row
        Row of the mesh-study table for the quantity.
    level_keys
        Keys under which the row has the value on each mesh level; the finest level last.
    relative_cell_sizes
        Cell sizes of the levels relative to the finest.
    scale
        Value by which the differences from the finest level are divided; 0: no curve is returned.
    """
    finest, bar = row[level_keys[-1]], row["uncertainty"] or 0.0
    if scale == 0.0:
        return []

    def off(value: Any) -> Any:
        return error_percent(value, finest, scale)

    y = [float(off(row[key])) for key in level_keys]
    ends = (*y[:-1], float(off(finest - bar))), (*y[:-1], float(off(finest + bar)))
    out = [Series(row["quantity"], relative_cell_sizes, y, "line+markers", error_bars=ends)]
    if row["extrapolated"] is not None and row["order"]:
        h = np.linspace(0.0, 1.0, 21)
        line = off(row["extrapolated"] + (finest - row["extrapolated"]) * h ** row["order"])
        out.append(Series(row["quantity"], h.tolist(), np.asarray(line, float).tolist(), "line", pale=True))
    return out
