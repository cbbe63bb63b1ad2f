"""Curves of contact loads and displacements for the report's figures, and the convergence figure of a mesh study."""

from __future__ import annotations

from rollbench.compare.models.comparison import ContactSolution
from rollbench.compare.reference.estimate import Reference
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.reports.content import Panel, Series


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
    return Panel(title, "ball", "contact_load", series, include_zero=axis_from_zero, integer_x=True)


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
