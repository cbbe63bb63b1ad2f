"""Report pages on Smith (1994): printed tables and figures of each chapter, with the computed values."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np

from rollbench.compare.cases.smith.evidence import axis, bearings
from rollbench.compare.evidence import PrintedEntryComparison, evidence
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import load_printed_table
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.scenes import catalogue
from rollbench.compare.sections.source_tables import publication_sections
from rollbench.compare.studies import roller as rollers
from rollbench.lowfi.bearings import as_printed
from rollbench.lowfi.bearings.angular_contact import dimensionless_hertz_parameters
from rollbench.lowfi.bearings.axis import carriage_to_frame_stiffness
from rollbench.meshes.axis import Assembly
from rollbench.reports.content import Figure, Panel, Row, Section, Series, Table

#: Sections of the report by name: title, names of the printed tables.
CHAPTERS = {
    "smith-ball": (
        "Smith (1994), Chapter 2: angular-contact ball bearing",
        ("smith-table-2-1", "smith-2.1", "smith-2.2", "smith-2.3"),
    ),
    "smith-taper": ("Smith (1994), Chapter 3: tapered roller bearing", ("smith-3",)),
    "smith-axis": (
        "Smith (1994), Chapter 4: bearing loads and stiffness of the ball-screw axis",
        ("smith-4.1", "smith-4.2", "smith-4.3"),
    ),
    "smith-tests": ("Smith (1994), Chapter 5: tests of the ball-screw axis", ("smith-5",)),
}
PRINTED = tuple(name for _, names in CHAPTERS.values() for name in names)
ABOUT = (
    "Support bearings of a ball screw: three angular-contact ball bearings or two tapered roller bearings at either end. "
    "Correct values: exact elliptic integrals, line contacts, equilibrium of the bearing rows, both halves of the screw in "
    "parallel. As printed: Smith's fits, load sharing and formula for springs in series, computed only to show "
    "their effect.",
    "Units are Smith's: lb are pounds-force, 4.44822 N (4.448 N in his spreadsheet), in-lb 0.112985 N m, lb/in "
    "175.127 N/m, psi 6894.76 Pa. A number printed in two units is compared twice.",
    (
        "The formulas of the axis are closed and linear; they are a baseline for scenes with beams and rolling "
        "sets, not a substitute."
    ),
    *(f"Assumed: {text}" for text in bearings.ASSUMED),
    f"As printed, identified from printed results, which confirm none of it: {bearings.IDENTIFIED}.",
)


def hertz_parameters_figure() -> Figure:
    """Draw Smith's Figure 2-8: Hertz contact parameters of Table 2-1, with the errors of the table and of Smith's fits."""
    at = np.linspace(0.0, 0.9999, 200)
    exact = np.array([dimensionless_hertz_parameters(float(f)) for f in at])
    names = {"delta": ("δ*", "approach", 0), "a": ("a*", "major", 1), "b": ("b*", "minor", 2)}
    differences = bearings.DIFFERENCES
    right = np.array([dimensionless_hertz_parameters(f) for f in differences])
    inside = [k for k, f in enumerate(differences) if 0.3 < f < 0.99]
    curves, off = [], []
    for key, (label, fit, column) in names.items():
        rows = (row for row in load_printed_table("smith-table-2-1") if row.key.startswith(f"{key}_"))
        values = [row.value for row in rows if row.value]
        if key != "a":
            curves.append(Series(f"{label}, exact", at.tolist(), exact[:, column].tolist(), "line"))
            curves.append(Series(f"{label}, printed", differences, values, "markers"))
        errors = error_percent(np.array(values), right[:, column]).tolist()
        off.append(Series(f"{label}, table", differences, errors, "markers"))
        if key != "b":
            shown = [differences[k] for k in inside]
            fits = np.array([as_printed.hertz_parameter_by_smith_polynomial(f, fit) for f in shown])
            off.append(Series(f"{label}, fit", shown, error_percent(fits, right[inside, column]).tolist(), "line"))
    panels = (
        Panel("Hertz parameters of Table 2-1 and by exact integrals", "F(p)", "δ*, b*", curves, include_zero=True),
        Panel("error of table and fits against exact integrals", "F(p)", "error_percent", off),
    )
    caption = (
        "δ*: dimensionless approach; a*, b*: dimensionless semi-axes of the contact ellipse. The last b* of Table 2-1 is "
        "printed with a digit too many and is 3.5 % wrong. Smith's fitted formula for b*, with its coefficient 2.26 as "
        "printed, is about 40 % wrong and not shown."
    )
    title = (
        "Smith (1994), Figure 2-8: dimensionless Hertz parameters, plotted against the curvature difference F(p): "
        "printed, and exact"
    )
    return Figure("smith-figure-2-8", title, panels, caption)


def bearing_stiffness_panel(found: Sequence[PrintedEntryComparison]) -> Panel:
    """Draw the axial stiffness of one bearing over its thrust: computed, by Smith's spreadsheets, and tested.

    ``found``: printed values of Smith's thesis with the computed ones.
    """
    loads = [float(x) for x in np.linspace(100.0, 3000.0, 30)]
    tested = [f for f in found if f.printed.table == "smith-2.2" and f.printed.key.startswith("measured_")]
    at = [float(f.printed.key.removeprefix("measured_")) for f in tested]
    theory = [1e-6 * (f.printed.value or 0.0) for f in found if f.printed.key.startswith("theory_")]

    def curve(label: str, stiffness_lbf_per_inch: Callable[[float], float], *, bold: bool = False) -> Series:
        """Return the curve of a bearing's stiffness over the thrust [lbf]; the function returns it in lbf/in."""
        return Series(label, loads, [stiffness_lbf_per_inch(x) / 1e6 for x in loads], "line", bold=bold)

    def correct_ball_stiffness(thrust_lbf: float) -> float:
        """Return the ball bearing's axial stiffness [lbf/in] by exact elliptic integrals at a thrust [lbf]."""
        return float(bearings.ball_bearing_state(thrust_lbf * bearings.POUND).stiffness) / bearings.POUND_PER_INCH

    series = (
        curve("ball, correct", correct_ball_stiffness, bold=True),
        curve("ball, Smith's spreadsheet", bearings.ball_sheet_stiffness),
        Series("ball, tested", at, [1e-6 * (f.printed.value or 0.0) for f in tested], "markers"),
        Series("ball, printed theory", at, theory, "markers"),
        curve("taper, correct", bearings.taper_stiffness),
        curve("taper, Smith's spreadsheet", bearings.taper_sheet_stiffness),
    )
    return Panel("axial stiffness of one bearing", "thrust / lbf", "stiffness_1e6_lbf_in", series, include_zero=True)


def axis_stiffness_panel(found: Sequence[PrintedEntryComparison]) -> Panel:
    """Draw the axial stiffness of the screw axis over the nut's position, for ball and tapered support bearings.

    Markers: stiffness by Smith's formula, which treats both supports and the whole screw as springs in series.

    ``found``: printed values of Smith's thesis with the computed ones.
    """
    places = np.linspace(0.0, 1.0, 41)
    at = [float(x) for x in places]
    unit = 1e6 * bearings.POUND_PER_INCH
    series = []
    for kind in axis.KINDS:
        k = axis.bearing_set_state(kind, "left", "stretch").stiffness
        for words, right in (("fixed-fixed", k), ("fixed-supported", 0.0)):
            a = bearings.screw_bar(k, right)
            values = carriage_to_frame_stiffness(a, a.length * places, bearings.NUT) / unit
            series.append(Series(f"{kind}, {words}", at, [float(v) for v in values], "line"))
        total = next(f for f in found if f.printed.key == f"total_{kind}")
        series.append(Series(f"{kind}, Smith's springs in series", [0.5], [1e-6 * (total.as_printed or 0.0)], "markers"))
    return Panel("axial stiffness of the screw axis", "nut_place", "stiffness_1e6_lbf_in", series, include_zero=True)


def stiffness_figure(found: Sequence[PrintedEntryComparison]) -> Figure:
    """Draw the stiffness of the support bearings over thrust, and the stiffness of the screw axis over the nut's position.

    ``found``: printed values of Smith's thesis with the computed ones.
    """
    sums = [f for kind in axis.KINDS for f in found if f.printed.key == f"total_{kind}"]
    stiffer = [100.0 * (f.value / f.as_printed - 1.0) for f in sums if f.value and f.as_printed]
    caption = (
        "Left: one bearing. The measured stiffness of the ball bearing grows less with thrust than that of Hertz "
        "contacts; the tapered bearing is computed stiffer than tested. Right: the axis. With both ends in parallel, "
        f"the axis is {min(stiffer):.0f} to {max(stiffer):.0f} % stiffer than by Smith's formula for springs in series."
    )
    title = "Axial stiffness of support bearings and of the screw axis: measured by Smith, and computed"
    return Figure("smith-stiffness", title, (bearing_stiffness_panel(found), axis_stiffness_panel(found)), caption)


def bearing_row_loads_figure(found: Sequence[PrintedEntryComparison]) -> Figure:
    """Draw the loads of all bearing rows of section 4.2 as Smith prints them, and as computed from equilibrium.

    ``found``: printed values of Smith's thesis with the computed ones.
    """
    panels = []
    for kind, words in (("ball", "ball bearings"), ("taper", "tapered roller bearings")):
        series, names = [], []
        for state in ("preload", "stretch", "applied"):
            rows = [f for f in found if f.printed.table == "smith-4.2" and f.printed.key.startswith(f"{kind}_")]
            rows = [f for f in rows if f"_{state}_" in f.printed.key]
            names = [f"{f.printed.key.split('_')[1]} {f.printed.key[-1]}" for f in rows]
            at = list(range(1, len(rows) + 1))
            series.append(Series(f"{state}, computed", at, [f.value or 0.0 for f in rows], "line+markers"))
            series.append(Series(f"{state}, printed", at, [f.printed.value or 0.0 for f in rows], "markers", bold=True))
        axes = "end of the screw and number of the row", "load / lbf"
        panels.append(Panel(f"loads of the {words}", *axes, series, "", True, True, names))
    caption = (
        "Preload: bearings alone; stretch: screw stretched as well; applied: also 1000 lbf on the carriage towards the "
        "left. Smith does not solve for equilibrium: at each end he adds half of the tension and of this load to the rows "
        "in its direction, and subtracts it from the opposite rows."
    )
    title = "Loads of the bearing rows at both ends of the axis (Smith 4.2): printed, and computed"
    return Figure("smith-loads", title, panels, caption)


LAYOUT_NOTE = (
    "Load on the nut: 1000 lbf towards the left end. Stiffness: of screw and supports, without the nut. Beam model: beam "
    "and contacts, each bearing row at its own position. Closed formulas (of this package): bar and load-deflection laws "
    "of the rows, all rows of "
    "an end at one position. Sum in series: Smith's equation (4.6), which adds the compliances of both ends and of the "
    "screw. Beam model and formulas differ more near an end, where the distance between its rows counts."
)


def end_thrusts_and_stiffness_table(cache: SceneResultCache) -> Table:
    """Return the table of the thrust on both end supports and of the axis stiffness, by bearing layout and nut position.

    Thrusts and stiffness are computed by the beam model, by closed formulas, and by Smith's formula for springs in series.
    ``cache``: gives the solved scenes.
    """
    unit = 1e6 * bearings.POUND_PER_INCH
    rows: list[Row] = []
    for layout, place in product(axis.LAYOUTS, axis.PLACES):
        beam, closed = cache.compute_once(axis.solve_by_beam_model, layout, place), axis.solve_by_formulas(layout, place)
        cache.record_used_scenes((layout.scene_name,))
        models = {"beam model": beam, "closed formulas": closed}
        row: Row = {"support_bearings": layout.description, "nut_place": place}
        for end in ("left", "right"):
            for model, result in models.items():
                row["thrust_on_end", end, model] = getattr(result, f"{end}_thrust") / bearings.POUND
        for model, result in models.items():
            row["axis_stiffness", model] = result.axis_stiffness / unit
        row["stiffness_difference"] = float(error_percent(beam.axis_stiffness, closed.axis_stiffness))
        series = axis.axis_stiffness_by_sum_in_series(layout) / unit
        row["axis_stiffness", "Smith's formula for springs in series"] = series if np.isfinite(series) else None
        rows.append(row)
    title = "Thrust on both end supports and stiffness of the screw axis, for each bearing layout and nut position"
    return Table.from_rows("smith-layouts", title, rows, LAYOUT_NOTE)


TORQUE_NOTE = (
    "Ours: power lost in film, steel and rib, at Smith's 27 cSt and 1,450 rpm (`rollbench friction smith-axis-taper`: the "
    "same for each row of the axis). He prints neither friction nor geometry of the rib: 0.03 to 0.15 is assumed, and a "
    "contact at a point. Thrust: computed, of 5.3 after the stretch."
)


def tapered_row_torque_table() -> Table:
    """Return the table of the torques of tapered rows that Smith prints, each beside our band."""
    labels = {f.key: f.label for name in ("smith-3", "smith-5") for f in load_printed_table(name)}
    rows: list[Row] = [
        {
            "roller_row": labels[key],
            "thrust": thrust,
            "smith_torque": printed,
            ("roller_torque", "0.03"): low,
            ("roller_torque", "0.15"): high,
        }
        for key, thrust, printed, (low, high) in axis.tapered_row_torques()
    ]
    title = "Friction torque of a row of tapered rollers: Smith's formula and tests, and ours as a band"
    return Table.from_rows("smith-taper-torque", title, rows, TORQUE_NOTE)


ROLLER_NOTE = (
    "3D: one roller between its races (`rollbench mesh-study smith-axis-taper`), its ends rounded with a radius of 1 mm, "
    "which is assumed. Slices: load-deflection law of roller rows in this package. Line contact: Hertz pressure under the "
    "load per length that 3D has at mid-length. Uncertainty: by the mesh, from all levels."
)


def tapered_roller_table_and_figure(cache: SceneResultCache) -> tuple[Table | Figure, ...]:
    """Return table and figure of deflection, line load and pressure of a tapered roller, in 3D and by low-order laws.

    The result is empty without stored 3D results. ``cache``: records that the scene smith-axis-taper is used.
    """
    cache.record_used_scenes(("smith-axis-taper",))
    scene = catalogue.shipped_scene_of_kind("smith-axis-taper", Assembly)
    (roller,) = rollers.roller_kinds_with_largest_load(scene)
    stored = (rollers.stored_roller_run(roller, level, (shipped_store(),)) for level in rollers.LEVELS)
    runs = [run for run in stored if run is not None]
    if not runs:
        return ()
    rows: list[Row] = []
    for one in rollers.roller_quantities(roller, runs):
        row: Row = {"quantity": f"{one.name}, {one.unit}"}
        for level, value in zip(one.levels, one.values, strict=True):
            row["value_on_level", str(level)] = value
        row |= {"mesh_uncertainty_of_value": one.uncertainty}
        for law, words in rollers.LAWS.items():
            row["value_by", words] = one.by_laws[law]
            row["error_by", words] = one.law_errors[law]
        rows.append(row)
    best = runs[-1]
    note = f"{ROLLER_NOTE} {rollers.low_order_error_sentence(roller, runs)}"
    along = [1e3 * x for x in best.along]
    even = [1e-3 * roller.largest_load / roller.roller_row.length] * 2
    half = 500.0 * roller.roller_row.length
    loads, pressures = [], []
    for race, line_load, pressure in zip(rollers.RACES, best.line_load, best.along_pressure, strict=True):
        loads.append(Series(f"3D, {race}", along, [1e-3 * q for q in line_load], "line"))
        pressures.append(Series(f"3D, {race}", along, [1e-6 * p for p in pressure], "line"))
    loads.append(Series("slices", [-half, half], even, "line"))
    x = "along the roller / mm"
    panels = (
        Panel("contact load per length", x, "N/mm", loads, include_zero=True),
        Panel("largest contact pressure", x, "MPa", pressures, include_zero=True),
    )
    caption = f"One roller under {roller.largest_load:.4g} N. Load and pressure are even, except at the rounded ends."
    title = "Deflection and pressure of a tapered roller between its races: in 3D, and by load-deflection laws"
    table = Table.from_rows("smith-roller-3d", title, rows, note)
    title = "Line load and contact pressure along a tapered roller in 3D"
    return table, Figure("smith-roller-along", title, panels, caption)


def make_section(cache: SceneResultCache, step: Callable[[str], None]) -> tuple[Section, ...]:
    """Return the report's sections on Smith (1994).

    ``cache``: gives the solved scenes; ``step``: function that receives a message before each step.
    """
    step("support bearings and axis")
    found = evidence(cache, *PRINTED)
    drawn = {
        "smith-ball": (hertz_parameters_figure(), stiffness_figure(found)),
        "smith-taper": (tapered_row_torque_table(), *tapered_roller_table_and_figure(cache)),
        "smith-axis": (bearing_row_loads_figure(found), end_thrusts_and_stiffness_table(cache)),
    }
    title = "Smith (1994): support bearings and stiffness of a ball-screw axis"
    return publication_sections("smith", "Smith (1994)", title, ABOUT, CHAPTERS, found, drawn)
