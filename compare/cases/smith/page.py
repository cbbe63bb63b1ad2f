"""Smith (1994) in the report: support bearings and the axis, every printed entry with both values and its verdict."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from rollbench.compare.cases.smith.evidence import axis, bearings
from rollbench.compare.evidence import Evidence, evidence
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study
from rollbench.compare.sections.verdicts import printed_table
from rollbench.lowfi.bearings.axis import axis_stiffness
from rollbench.reports.content import Figure, Panel, Quantity, Row, Section, Series, Table, Text

#: Titles of the tables.
TITLES = {
    "smith-table-2-1": "Table 2-1: parameters of elliptical contact",
    "smith-2.1": "Figure 2-10 and section 2.1.2: angular-contact ball bearing, triplex set",
    "smith-2.2": "Table 2-2: stiffness of the ball bearing",
    "smith-2.3": "Sections 2.3, 2.4: torque of the ball bearing",
    "smith-3": "Chapter 3: tapered roller bearing",
    "smith-4.1": "Section 4.1: stretch of the screw",
    "smith-4.2": "Section 4.2: loads of the supports, stiffness of the axis",
    "smith-4.3": "Section 4.3: torque of the axis",
    "smith-5": "Chapter 5: tests of the axis",
}
ABOUT = (
    "Support bearings of a ball screw: three angular-contact ball bearings or two tapered roller bearings at either end. "
    "Right values: exact elliptic integrals, line contacts, equilibrium of every set of rows, both ends of the axis side "
    "by side. As printed: the source's fits, sharing and sum in series, kept only to show what they do.",
    (
        "The formulas of the axis are closed and linear; they are a baseline for scenes with beams and rolling "
        "sets, not a substitute."
    ),
    *(f"Assumed: {text}" for text in bearings.ASSUMED),
    f"As printed, identified from printed results, which confirm none of it: {bearings.IDENTIFIED}.",
)


def stiffness_panel(found: Sequence[Evidence]) -> Panel:
    """Stiffness of one bearing over its thrust: right, as printed, tested."""
    loads = np.linspace(100.0, 3000.0, 30)
    tested = [f for f in found if f.printed.table == "smith-2.2" and f.printed.key.startswith("measured_")]
    at = [float(f.printed.key.removeprefix("measured_")) for f in tested]
    ours = [float(bearings.state(x * bearings.POUND).stiffness) / bearings.POUND_PER_INCH / 1e6 for x in loads]
    series = (
        Series("ball, right", [float(x) for x in loads], ours, "line", emphasis=True),
        Series("ball, sheet", [float(x) for x in loads], [bearings.sheet_tangent(float(x)) / 1e6 for x in loads], "line"),
        Series("ball, tested", at, [1e-6 * (f.printed.value or 0.0) for f in tested], "markers"),
        Series("taper, right", [float(x) for x in loads], [bearings.tangent(float(x)) / 1e6 for x in loads], "line"),
        Series(
            "taper, sheet", [float(x) for x in loads], [bearings.taper_sheet_tangent(float(x)) / 1e6 for x in loads], "line"
        ),
    )
    return Panel("one bearing", "thrust / lbf", "stiffness / 10⁶ lbf/in", series, zero=True)


def axis_panel(found: Sequence[Evidence]) -> Panel:
    """Stiffness of the axis over the nut's position: fixed-fixed and fixed-supported, and the sum in series."""
    places = np.linspace(0.0, 1.0, 41)
    at = [float(x) for x in places]
    unit = 1e6 * bearings.POUND_PER_INCH
    series = []
    for kind in axis.KINDS:
        k = axis.end_state(kind, "left", "stretch").stiffness
        for words, right in (("fixed-fixed", k), ("fixed-supported", 0.0)):
            a = bearings.axis(k, right)
            values = axis_stiffness(a, a.length * places, bearings.NUT) / unit
            series.append(Series(f"{kind}, {words}", at, [float(v) for v in values], "line"))
        total = next(f for f in found if f.printed.key == f"total_{kind}")
        series.append(Series(f"{kind}, sum in series", [0.5], [1e-6 * (total.as_printed or 0.0)], "markers"))
    return Panel("axis", "nut's position / L", "stiffness / 10⁶ lbf/in", series, zero=True)


def figure(found: Sequence[Evidence]) -> Figure:
    """Stiffness of bearings and axis."""
    sums = [f for kind in axis.KINDS for f in found if f.printed.key == f"total_{kind}"]
    stiffer = [100.0 * (f.value / f.as_printed - 1.0) for f in sums if f.value and f.as_printed]
    caption = (
        "Left: the measured curve of the ball bearing is flatter than any Hertz contact; the tapered "
        "bearing is computed stiffer than its test by more than the depth of its rings explains. Right: "
        f"with both ends in parallel the axis is stiffer by {min(stiffer):.0f} to {max(stiffer):.0f} % than the "
        "sum in series, which an end-to-end test with hammer and accelerometer seemed to confirm."
    )
    title = "Stiffness of the support bearings and of the axis"
    return Figure("smith-stiffness", title, (stiffness_panel(found), axis_panel(found)), caption)


LAYOUT_NOTE = (
    "Load of 1000 lbf towards the left end; thrust at either end from the tension of the shaft; stiffness "
    "of shaft and supports without the nut. Scene: beam and contacts, rows at their own places. Formulas: "
    "rows by their laws, all rows of an end at one place, and a bar. Sum in series (4.6): both ends and the "
    "whole screw between rigid walls, which is the stiffness of none of them. Differences grow towards an "
    "end, because there the distance between its rows counts."
)


def layout_table(study: Study) -> Table:
    """Layouts of the axis over the nut's position: scenes, closed formulas, the source's sum."""
    unit = 1e6 * bearings.POUND_PER_INCH
    rows: list[Row] = []
    for layout, place, scene, closed in axis.every_place(study):
        study.uses((layout.scene,))
        difference = float(error_percent(scene.stiffness, closed.stiffness))
        series = axis.in_series(layout) / unit
        rows.append(
            {
                "layout": layout.words,
                Quantity("place", "nut's position / L", "", ".1f"): place,
                Quantity("left_scene", "left end, scene", "lbf", ".0f"): scene.left / bearings.POUND,
                Quantity("left_formula", "left end, formulas", "lbf", ".0f"): closed.left / bearings.POUND,
                Quantity("right_scene", "right end, scene", "lbf", ".0f"): scene.right / bearings.POUND,
                Quantity("right_formula", "right end, formulas", "lbf", ".0f"): closed.right / bearings.POUND,
                Quantity("scene", "stiffness, scene", "10⁶ lbf/in", ".3f"): scene.stiffness / unit,
                Quantity("formula", "stiffness, formulas", "10⁶ lbf/in", ".3f"): closed.stiffness / unit,
                Quantity("difference", "scene against formulas", "%", ".2f"): difference,
                Quantity("series", "sum in series", "10⁶ lbf/in", ".3f"): series if np.isfinite(series) else None,
            }
        )
    return Table.of("smith-layouts", "The axis in its layouts, as scenes", rows, LAYOUT_NOTE)


def section(study: Study, step: Callable[[str], None]) -> Section:
    """Section of the report."""
    step("support bearings and axis")
    found = evidence(study, *TITLES)
    tables = [printed_table(name, title, [f for f in found if f.printed.table == name]) for name, title in TITLES.items()]
    tables.append(layout_table(study))
    return Section(
        "smith", "Support bearings and the axis (Smith 1994)", (Text(ABOUT, bullets=True), figure(found), *tables)
    )
