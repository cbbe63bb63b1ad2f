"""Smith (1994), chapters 2 and 3: stiffness and torque of an angular-contact ball bearing and a tapered roller bearing.

Also the dimensions of bearings and axis that Smith prints, and the assumptions where the thesis leaves inputs open.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import product
from math import degrees

import numpy as np

from rollbench.compare.evidence import ComputedEntryValues
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import load_printed_table
from rollbench.lowfi import rollers
from rollbench.lowfi.bearings import angular_contact, as_printed, axis, tapered_roller, torque
from rollbench.lowfi.rating.displacement import motion_at
from rollbench.lowfi.statics.axis.solve import solve_assembly
from rollbench.lowfi.statics.validity import DENT_PRESSURE
from rollbench.meshes.axis import Assembly, RollerRow, RollingSet
from rollbench.meshes.parts import Load, Lubricant, Material, Screw, Support
from rollbench.meshes.units import parse_quantity

#: Units that Smith's thesis uses, in SI.
INCH = parse_quantity("1 in", "length")

POUND = parse_quantity("1 lbf", "force")

INCH_POUND = parse_quantity("1 in-lbf", "moment")

POUND_PER_INCH = parse_quantity("1 lbf/in", "stiffness")

PSI = parse_quantity("1 psi", "pressure")

DEG_F = parse_quantity("1 degF", "temperature difference")

RPM = np.pi / 30.0

#: Assumptions where Smith's thesis leaves an input open.
ASSUMED = (
    "Poisson's ratio of steel 0.3; Young's modulus of 4.1, 30e6 psi, for the bearings too (the factor 2.15e5 of the sheet "
    "implies 207.5 GPa).",
    "Rings of the tapered bearing 5 mm thick, from bore and outside diameter: the depth to which the line contacts' "
    "deformation is counted.",
    "Density of the grease's base oil 900 kg/m3.",
)

#: Constants of Smith's spreadsheets that were inferred from printed results; these results cannot confirm them.
IDENTIFIED = (
    "the exponents 2/3 and 0.66666 of the sheet (from delta* and K_n), its constant 2.15e5 (from K_i, K_o), F(p)_o as an "
    "input (from all cells after it); 1/D in 3.24, the exponent 1/2 in 3.26 and areas without pi (from b, A and the areas "
    "compared)"
)

YOUNG, POISSON = parse_quantity("30e6 psi", "pressure"), 0.3

RING_DEPTH, DENSITY = parse_quantity("5 mm", "length"), 900.0

#: Thrust of Smith's spreadsheets, preload of a single bearing, thrust of the torque calculations [N].
SHEET_LOAD, PRELOAD = parse_quantity("2040 lbf", "force"), parse_quantity("1500 lbf", "force")

BALL_TORQUE_LOAD, TAPER_TORQUE_LOAD = parse_quantity("1000 lbf", "force"), parse_quantity("1500 lbf", "force")

VISCOSITY, SPEED, ATMOSPHERE = 27e-6, 1450.0 * RPM, 101325.0

#: Stretch of the screw in section 4.1 [m], thermal expansion [1/K], load on the carriage in 4.2 [N], stiffness of the nut
#: [N/m].
STRETCH, EXPANSION = parse_quantity("0.0015 in", "length"), 6e-6 / DEG_F

APPLIED, NUT = parse_quantity("1000 lbf", "force"), parse_quantity("5.5e6 lbf/in", "stiffness")

#: Directions in which the bearing rows of section 4.2 carry thrust, by kind of bearing and end of the screw: +1 for rows
#: that the screw's tension loads, -1 for the others.
DIRECTIONS: dict[str, dict[str, tuple[int, ...]]] = {
    "ball": {"left": (1, 1, -1), "right": (-1, 1, 1)},
    "taper": {"left": (-1, 1), "right": (1, -1)},
}


@cache
def smith_ball_bearing() -> angular_contact.BallBearing:
    """Return the angular-contact ball bearing MM35BS72 of Smith's Figure 2-10.

    The radius of the outer groove is 0.53 ball diameters, 0.182188 in.
    """
    d = 0.34375 * INCH
    return angular_contact.BallBearing(18, d, 1.817159 * INCH, 2.520305 * INCH, 0.52 * d, 0.53 * d, YOUNG, POISSON)


@cache
def smith_tapered_bearing() -> rollers.TaperedBearing:
    """Return the prototype tapered roller bearing of Smith's Figure 3-6."""
    return rollers.TaperedBearing(
        16, 0.33 * INCH, 0.49 * INCH, float(np.radians(30.8)), float(np.radians(4.0)), YOUNG, POISSON, RING_DEPTH
    )


@cache
def bearing_rows_at_end(kind: str, end: str, preload: float = PRELOAD) -> axis.BearingRows:
    """Return the preloaded bearing rows at one end of the screw.

    ``kind``: "ball" or "taper"; ``end``: "left" or "right"; ``preload``: for tapered bearings, preload of the rows [N];
    for ball bearings, thrust [N] on a single bearing, whose deflection is the initial gap of every row.
    """
    directions = DIRECTIONS[kind][end]
    if kind == "ball":
        row = smith_ball_bearing()
        return axis.equal_rows_with_gap(row, directions, row.deflection(preload))
    return axis.equal_rows_with_preload(rollers.TaperedRow(smith_tapered_bearing()), directions, preload)


def screw_bar(left: float = np.inf, right: float = np.inf) -> axis.ScrewShaftSprings:
    """Return the screw of Smith's section 4.1 as a bar between supports.

    ``left``, ``right``: axial stiffness of the supports [N/m]; infinite: rigid; 0: free to slide.
    """
    return axis.ScrewShaftSprings(52.0 * INCH, 0.25 * np.pi * (1.378 * INCH) ** 2, YOUNG, left, right)


#: Curvature difference F(p)_o of the outer race printed in Figure 2-10; it does not follow from the dimensions.
SHEET_DIFFERENCE = 0.9013479

#: Newtons per pound-force in Smith's spreadsheet.
SHEET_POUND = 4.448

#: Curvature differences F(p) of Table 2-1, without the last row, which is a line contact.
DIFFERENCES = tuple(row.value or 0.0 for row in load_printed_table("smith-table-2-1") if row.key.startswith("F_"))[:-1]

#: Curvature differences F(p) close to 1, the value of a line contact.
NEARLY_LINE = (1.0 - 1e-4, 1.0 - 1e-7, 1.0 - 1e-10)


@cache
def ball_bearing_state(load: float) -> angular_contact.BallBearingThrustState:
    """Return contact angle, ball load and stiffness of the ball bearing under a thrust [N], by exact elliptic integrals."""
    return angular_contact.bearing_state_at_displacement(smith_ball_bearing(), smith_ball_bearing().deflection(load))


@cache
def ball_sheet(
    thrust_lbf: float, curvature_difference: float | None = SHEET_DIFFERENCE
) -> as_printed.SmithSpreadsheetValues:
    """Return the results of Smith's spreadsheet for the ball bearing (Figure 2-10), recomputed with its errors.

    ``thrust_lbf``: thrust on the bearing [lbf]; ``curvature_difference``: curvature difference F(p)_o of the outer race, by
    default the printed one; None: from the dimensions.
    """
    b = smith_ball_bearing()
    mm = [1e3 * v for v in (b.ball_diameter, b.inner_groove, b.outer_groove, b.inner_raceway, b.outer_raceway)]
    return as_printed.compute_smith_spreadsheet(
        SHEET_POUND * thrust_lbf, b.balls, mm[0], (mm[1], mm[2]), (mm[3], mm[4]), curvature_difference
    )


def ball_sheet_stiffness(thrust_lbf: float) -> float:
    """Return the ball bearing's axial stiffness [lbf/in] by Smith's spreadsheet at the thrust ``thrust_lbf`` [lbf].

    The stiffness is the difference quotient between thrusts 0.1 % smaller and 0.1 % larger.
    """
    step = 1e-3 * thrust_lbf
    low, high = (ball_sheet(thrust).deflection for thrust in (thrust_lbf - step, thrust_lbf + step))
    return 2.0 * step * 25.4 / (high - low)


def table_2_1(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the Hertz contact parameters delta*, a*, b* of Smith's Table 2-1 by elliptic integrals.

    ``findings``: receives the computed value to compare with each number of the table, and whether each claim on the line
    contact holds. ``cache``: not used here.
    """
    for i, difference in enumerate(DIFFERENCES):
        parameters = angular_contact.dimensionless_hertz_parameters(difference)
        names = (f"{name}_{i}" for name in ("F", "delta", "a", "b"))
        findings.numbers(dict(zip(names, (difference, *parameters), strict=True)))
    findings.numbers({f"F_{len(DIFFERENCES)}": 1.0})
    limit = np.array([angular_contact.dimensionless_hertz_parameters(f) for f in NEARLY_LINE])
    for name, column, sign in (("delta", 0, -1.0), ("a", 1, 1.0), ("b", 2, -1.0)):
        steps = np.diff(np.log(limit[:, column])) * sign
        words = ", ".join(f"{v:.3g}" for v in limit[:, column])
        findings.add_claim(f"{name}_22", bool(np.all(steps > 1.0)), f"{words} at 1 - F(p) = 1e-4, 1e-7, 1e-10")


def _compute_ball_bearing_dimensions(findings: ComputedEntryValues) -> None:
    """Compute the ball bearing's dimensions in Smith's Figure 2-10; ``findings`` receives the results."""
    b = smith_ball_bearing()
    given = {
        "D": b.ball_diameter,
        "d_i": b.inner_raceway,
        "d_o": b.outer_raceway,
        "r_i": b.inner_groove,
        "r_o": b.outer_groove,
    }
    sums = {"d_m": b.pitch_diameter, "P_d": b.clearance}
    findings.numbers({key: value / INCH for key, value in given.items()})
    findings.follow({key: value / INCH for key, value in sums.items()})
    findings.follow({f"{key}_mm": 1e3 * value for key, value in (given | sums).items()})
    findings.numbers({"Z": float(b.balls), "F": SHEET_LOAD / POUND, "F_p": PRELOAD / POUND, "stretch": 2000.0})
    curvature = b.centre_distance / b.ball_diameter
    findings.follow({"B": curvature, "B_mm": curvature, "alpha_0_rad": float(np.radians(findings.printed("alpha_0")))})
    findings.add_number("alpha_0", degrees(b.free_angle))
    words = f"{degrees(float(ball_bearing_state(SHEET_LOAD).contact_angle)):.2f} deg under 2040 lbf"
    findings.add_number("alpha_nominal", degrees(b.free_angle), words)


def _compute_spreadsheet_cells_under_load(findings: ComputedEntryValues) -> None:
    """Compute the spreadsheet cells of Smith's Figure 2-10 that depend on the contact angle under load.

    ``findings``: receives the results.
    """
    source, s = ball_sheet(SHEET_LOAD / POUND), ball_bearing_state(SHEET_LOAD)
    angle, q = float(s.contact_angle), float(s.ball_load)
    findings.add_number("F_N", SHEET_LOAD, as_printed=SHEET_POUND * SHEET_LOAD / POUND)
    findings.add_number("Q", q / POUND, as_printed=source.ball_load / SHEET_POUND)
    findings.add_number("Q_N", q, as_printed=source.ball_load)
    pairs = angular_contact.relative_curvatures(smith_ball_bearing(), s.contact_angle)
    for i, (name, pair, h) in enumerate(zip("io", pairs, (s.inner_hertz, s.outer_hertz), strict=True)):
        across, along = (1e-3 * float(k) for k in pair)
        difference = (along - across) / (along + across)
        findings.add_number(f"sum_{name}", across + along, as_printed=source.curvature_sums[i])
        findings.add_number(f"F_{name}", difference, as_printed=source.curvature_differences[i] if name == "i" else None)
        approach = angular_contact.dimensionless_hertz_parameters(difference)[0]
        findings.add_number(f"delta_{name}", approach, as_printed=source.dimensionless_approaches[i])
        findings.add_number(f"K_{name}", float(h.C) ** -1.5 * 1e-3**1.5, as_printed=source.race_load_constants[i])
    constant = float(s.inner_hertz.C + s.outer_hertz.C) ** -1.5 * 1e-3**1.5
    findings.add_number("K_n", constant, as_printed=source.load_constant)
    findings.add_number("alpha", degrees(angle), as_printed=degrees(source.contact_angle))
    findings.add_number("alpha_rad", angle, as_printed=source.contact_angle)
    free, loaded = (np.cos(np.radians(findings.printed(key))) for key in ("alpha_0", "alpha"))
    normal = findings.printed("B") * findings.printed("D_mm") * (free / loaded - 1.0)
    rest = findings.printed("Q_N") - findings.printed("K_n") * normal**1.5
    findings.add_remark("balance", f"Q_n - K_n delta_n^1.5 of the printed cells is {rest:.2g} N")
    findings.add_number("delta_a", float(s.displacement) / INCH, as_printed=source.deflection / 25.4)
    inner, outer = (float(a) / INCH**2 for a in s.contact_areas())
    words = f"pi a b: inner {inner:.6f}, outer {outer:.6f} in2; printed {findings.printed('area') / inner:.1f} times"
    findings.add_number("area", inner, words)
    slope = float(s.stiffness) / POUND_PER_INCH
    words = f"tangent of the sheet's curve {ball_sheet_stiffness(2040.0):.3g} lbf/in"
    findings.add_number("S_2040", slope, words, as_printed=ball_sheet_stiffness(2040.0))


def _compute_triplex_preload(findings: ComputedEntryValues) -> None:
    """Compute the preload of three matched bearings: section 2.1.2 of Smith (1994); ``findings`` receives the results."""
    for key, load, rows in (("delta_1500", 1500.0, 1.0), ("delta_1020", 1020.0, 1.0), ("gap", 1500.0, 2.0)):
        deflection = rows * float(ball_bearing_state(load * POUND).displacement) / INCH
        findings.add_number(key, deflection, as_printed=rows * ball_sheet(load).deflection / 25.4)
    triplex = bearing_rows_at_end("ball", "left")
    tensions = 0.0, 2000.0 * POUND
    ready, pulled = (axis.solve_bearing_row_equilibrium(triplex, force).row_thrusts / POUND for force in tensions)
    findings.numbers({"P_tandem": float(ready[0]), "P_third": float(ready[2]), "ratio": float(ready[2] * POUND / PRELOAD)})
    findings.add_number("stretch_end", 2000.0, as_printed=1000.0)
    shared = as_printed.bearing_row_loads_as_printed((1020.0, 1020.0, 2040.0), (1, 1, -1), 1000.0)
    words = "equilibrium under the shaft's whole tension, 2000 lbf, at the end"
    findings.add_number("P_tandem_s", float(pulled[0]), words, as_printed=float(shared[0]))
    findings.add_number("P_third_s", float(pulled[2]), words, as_printed=float(shared[2]))


def range_of_good_approach_fit() -> tuple[float, float, float]:
    """Return the range of the curvature difference F(p) in which Smith's fit (2.18) of the approach has errors below 2 %.

    First: lower end; second: upper end; third: error of the fit at F(p) = 0.5 [%]. The fit gives the dimensionless approach
    delta*.
    """

    def approach_fit_error_percent(difference: float) -> float:
        """Return the error [%] of Smith's fit of the approach delta* at a curvature difference F(p)."""
        fitted = as_printed.hertz_parameter_by_smith_polynomial(difference, "approach")
        return abs(float(error_percent(fitted, angular_contact.dimensionless_hertz_parameters(difference)[0])))

    low = high = 0.9
    while approach_fit_error_percent(low - 1e-3) <= 2.0:
        low -= 1e-3
    while approach_fit_error_percent(high + 1e-3) <= 2.0:
        high += 1e-3
    return low, high, approach_fit_error_percent(0.5)


def section_2_1(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Recompute the numbers printed in Figure 2-10 and section 2.1.2 of Smith (1994), and check the claims made there.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds.
    ``cache``: not used here.
    """
    _compute_ball_bearing_dimensions(findings)
    _compute_spreadsheet_cells_under_load(findings)
    _compute_triplex_preload(findings)
    low, high, worst = range_of_good_approach_fit()
    words = f"within 2 % for F(p) from {low:.3f} to {high:.3f}; {worst:.0f} % off at 0.5"
    findings.add_claim("fit_good", worst < 2.0, words)
    f = ball_sheet(2040.0).curvature_differences[0]
    minor = as_printed.hertz_parameter_by_smith_polynomial(f, "minor")
    exact = angular_contact.dimensionless_hertz_parameters(f)[2]
    percent = float(error_percent(minor, exact))
    words = f"b* = {minor:.4f} for {exact:.4f}: {percent:+.0f} % at F(p) = {f:.3f}"
    findings.add_claim("fit_minor", abs(percent) < 5.0, words)


def section_2_2(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the ball bearing's axial stiffness over thrust: Table 2-2 of Smith (1994).

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds.
    ``cache``: not used here.
    """
    loads = [row.key.removeprefix("theory_") for row in load_printed_table(findings.table) if row.key.startswith("theory_")]
    measured, theory = (np.array([findings.printed(f"{k}_{n}") for n in loads]) for k in ("measured", "theory"))
    right = np.array([float(ball_bearing_state(float(n) * POUND).stiffness) / POUND_PER_INCH for n in loads])
    for n, value in zip(loads, right, strict=True):
        findings.numbers({f"load_{n}": float(n), f"measured_{n}": value})
        findings.add_number(f"theory_{n}", float(value), as_printed=ball_sheet_stiffness(float(n)))
    off, ours = error_percent(theory, measured), error_percent(right, measured)
    bad = [f"{p:+.0f} % at {n} lbf" for n, p in zip(loads, off, strict=True) if abs(p) > 10.0]
    words = f"{', '.join(bad)}; the right stiffness is {ours.min():+.0f} to {ours.max():+.0f} % off the test"
    findings.add_claim("within_10", not bad, words)
    findings.add_claim("grows", bool(np.all(np.diff(right) > 0.0)), f"from {right[0]:.3g} to {right[-1]:.3g} lbf/in")
    steps = np.diff(1e6 / measured)
    # half a unit of the last digit of S, both rows of a difference
    digits = 1e6 * 500.0 * (1.0 / measured[1:] ** 2 + 1.0 / measured[:-1] ** 2)
    straight = bool(np.all(np.abs(steps - steps.mean()) <= 2.0 * digits))
    findings.add_claim("parabola", straight, f"differences of 1/S {steps.min():.5f} to {steps.max():.5f} 1e-6 in/lbf a row")


def static_rating_of_ball_bearing_row() -> float:
    """Return Palmgren's static load rating [N] of Smith's ball bearing at its contact angle under `BALL_TORQUE_LOAD`."""
    b, s = smith_ball_bearing(), ball_bearing_state(BALL_TORQUE_LOAD)
    (across, along), _ = angular_contact.relative_curvatures(b, s.contact_angle)
    return torque.palmgren_static_rating(1, b.balls, b.ball_diameter, float(s.contact_angle), float(across), float(along))


def load_dependent_torque(static_rating: float, **factors: float) -> float:
    """Return the torque of Smith's ball bearing by Palmgren's load-dependent part [in-lbf].

    ``static_rating``: static load rating [N]; ``factors``: changed factors of `torque.load_dependent_torque`.
    """
    thrust, diameter = BALL_TORQUE_LOAD, smith_ball_bearing().pitch_diameter
    return torque.load_dependent_torque(thrust, 0.0, diameter, static_rating, **factors).torque / INCH_POUND


def torque_of_ball_bearing_row() -> tuple[float, float]:
    """Return the two parts of the friction torque of one row of Smith's ball bearing [in-lbf]: viscous, and by load."""
    viscous = torque.load_independent_torque(2.0, smith_ball_bearing().pitch_diameter, VISCOSITY, SPEED)
    return viscous / INCH_POUND, load_dependent_torque(static_rating_of_ball_bearing_row())


def section_2_3(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Compute the friction torque of the ball bearing: section 2.3 of Smith (1994).

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds.
    ``cache``: not used here.
    """
    b = smith_ball_bearing()
    findings.numbers(
        {"nu": 1e6 * VISCOSITY, "n": SPEED / RPM, "f_0": 2.0, "F": BALL_TORQUE_LOAD / POUND, "Y_0": 0.3, "X_0": 0.5}
    )
    findings.add_number("F_kg", BALL_TORQUE_LOAD / 9.80665, "1 kg taken as 2.2 lb", as_printed=1000.0 / 2.2)
    viscous, loaded = torque_of_ball_bearing_row()
    findings.numbers({"M_0": viscous, "f_1": 0.0013, "k_0": 2.8})
    product = 1e6 * VISCOSITY * SPEED / RPM
    findings.add_claim("form", product >= 2000.0, f"v n = {product:.0f} cSt rpm")
    s, rating = ball_bearing_state(BALL_TORQUE_LOAD), static_rating_of_ball_bearing_row()
    radial = 1.25e6 * torque.KILOGRAM_FORCE * b.balls * b.ball_diameter**2 * float(np.cos(b.free_angle))
    whole, three = load_dependent_torque(rating, axial_factor=1.0), load_dependent_torque(3.0 * rating)
    nearest = load_dependent_torque(radial, axial_factor=0.5)
    share = float((s.inner_hertz.pressure(s.ball_load) / DENT_PRESSURE) ** 3)
    thrust = BALL_TORQUE_LOAD, 0.0, share
    row = torque.ball_bearing_torque("angular contact", float(s.contact_angle), b.pitch_diameter, thrust, None)
    low, high = (x / INCH_POUND for x in row.load)
    words = (
        f"one row {loaded:.2f} in-lb, with three rows in C_0 {three:.2f}, with P_0 = F_a {whole:.2f}; published "
        f"coefficients with P_0/C_0 by the largest contact load {low:.2f} to {high:.2f}; nearest reading {nearest:.2f}, "
        "by what the text does not say: X_0 in place of Y_0, and Palmgren's radial C_0 = 1.25 kg/mm2 Z D^2 cos(alpha)"
    )
    findings.add_number("M_1", loaded, words)
    words = f"computed: {viscous:.2f} + {loaded:.2f} in-lb"
    findings.add_number("M", viscous + loaded, words, follows=findings.printed("M_0") + findings.printed("M_1"))
    pound = 1e-3 * torque.KILOGRAM_FORCE / INCH_POUND
    findings.add_number("unit", pound, "kg mm in in-lbf", as_printed=2.2 / 25.4)
    film = 1e-6 * torque.LEAST_FILM * RPM * DENSITY / ATMOSPHERE
    words = f"nu n = {torque.LEAST_FILM:g} cSt rpm, oil of {DENSITY:g} kg/m3, one atmosphere"
    findings.add_number("film", None, words, follows=film)
    test = findings.printed("M_test")
    least, most = (viscous + x / INCH_POUND for x in row.starting)
    words = f"from rest {least:.2f} to {most:.2f} in-lb: film and twice the load's part, which fresh grease exceeds"
    findings.add_number("M_test", most, words)
    growth = (2000.0 / 500.0) ** (4.0 / 3.0)
    words = f"by (2.33), (2.34) the load's part grows {growth:.1f} times from 500 to 2000 lbf"
    findings.add_claim("insensitive", growth < 1.5, words)
    findings.add_number("M_test_3", 3.0 * most, follows=3.0 * test)
    percent = float(error_percent(findings.printed("M"), test))
    off = float(error_percent(viscous + loaded, test))
    words = f"{findings.printed('M'):g} is {percent:+.0f} % off {test:g} in-lb, the computed sum {off:+.0f} %"
    findings.add_claim("fair", abs(percent) <= 10.0, words)


#: Radial load in Smith's spreadsheet of the tapered bearing [N], and exponent of its load-distribution integrals.
RADIAL, EXPONENT = POUND, 1.1

#: Ends of the range of thrust [lbf] over which the load-deflection curve is judged to be straight or not.
ENDS = (500.0, 2500.0)

#: Other depths of the rings [m], by which the influence of the assumed depth `RING_DEPTH` is shown.
DEPTHS = (2.5e-3, 10e-3)

#: Crown radius [m] with which the stiffness would be about the measured one; number of slices of a roller.
CROWN, SLICES = 2.0, 101


@cache
def taper_displacements() -> tuple[float, float]:
    """Return the axial and the radial displacement [m] of Smith's tapered bearing under the loads of his Figure 3-6.

    The bearing sits on a shaft that cannot tilt.
    """
    b, steel, at = smith_tapered_bearing(), Material(YOUNG, POISSON), 0.1
    row = RollerRow(b.rollers, b.diameter, b.length, b.cup_angle, b.roller_angle, b.depth, steel)
    bearing = RollingSet("row", "tapered roller bearing", row, at, thrust="+z")
    upright = Support(at, tuple((name, 0.0) for name in ("uy", "rx", "ry", "rz")))
    loads = (Load(at, (RADIAL, 0.0, SHEET_LOAD)),)
    shaft = Screw(2.0 * at, 35e-3, 3e-3, steel)
    found = solve_assembly(Assembly("taper", "taper", shaft, (bearing,), supports=(upright,), loads=loads))
    moved = motion_at(found, at)
    return float(moved[2]), float(moved[0])


def taper_stiffness(thrust_lbf: float, depth: float = RING_DEPTH) -> float:
    """Return the tapered roller bearing's axial stiffness [lbf/in] from the deformation of its line contacts.

    ``thrust_lbf``: thrust [lbf]; ``depth``: depth [m] in the rings down to which the contact deformation is counted.
    """
    row = rollers.TaperedRow(replace(smith_tapered_bearing(), depth=depth))
    return row.stiffness(row.deflection(thrust_lbf * POUND)) / POUND_PER_INCH


def crowned_tapered_bearing_stiffness(thrust_lbf: float) -> float:
    """Return the tapered roller bearing's axial stiffness [lbf/in] with crowned rollers, computed in slices of a roller.

    ``thrust_lbf``: thrust [lbf]; the crown's radius is `CROWN`.
    """
    row = rollers.TaperedRow(smith_tapered_bearing(), SLICES, rollers.circular_crown_profile(CROWN))
    return row.stiffness(row.deflection(thrust_lbf * POUND)) / POUND_PER_INCH


def taper_deflection_as_printed(
    thrust_lbf: float, length: float, diameter: float, cup_angle: float, roller_angle: float
) -> float:
    """Return the tapered bearing's axial deflection [in] by Smith's equations 3.17 to 3.21.

    ``thrust_lbf``: thrust [lbf]; ``length``, ``diameter``: length and diameter of a roller [in]; ``cup_angle``,
    ``roller_angle``: half cone angles of outer race and roller [rad].
    """
    line = thrust_lbf / (smith_tapered_bearing().rollers * np.sin(cup_angle) * length)
    return as_printed.roller_approach_as_printed(float(line), diameter, cup_angle, roller_angle) / float(np.sin(cup_angle))


def taper_sheet_deflection(thrust_lbf: float = SHEET_LOAD / POUND) -> float:
    """Return the tapered bearing's axial deflection [in] by Smith's spreadsheet (Figure 3-6).

    ``thrust_lbf``: thrust [lbf].
    """
    b = smith_tapered_bearing()
    return taper_deflection_as_printed(thrust_lbf, b.length / INCH, b.diameter / INCH, b.cup_angle, b.roller_angle)


def taper_deflection_range() -> tuple[float, float]:
    """Return smallest and largest axial deflection [in] of the tapered bearing within the rounding of Smith's inputs."""
    b = smith_tapered_bearing()
    half = (0.005, 0.005, np.radians(0.05), np.radians(0.005))
    middle = (b.length / INCH, b.diameter / INCH, b.cup_angle, b.roller_angle)
    found = []
    for signs in product((-1.0, 1.0), repeat=4):
        inputs = np.add(middle, np.multiply(signs, half)).tolist()
        found.append(taper_deflection_as_printed(SHEET_LOAD / POUND, *inputs))
    return min(found), max(found)


def taper_sheet_stiffness(thrust_lbf: float) -> float:
    """Return the tapered bearing's axial stiffness [lbf/in] by Smith's spreadsheet at the thrust ``thrust_lbf`` [lbf]."""
    return 2.0 / (taper_sheet_deflection(thrust_lbf + 1.0) - taper_sheet_deflection(thrust_lbf - 1.0))


def _compute_taper_spreadsheet(findings: ComputedEntryValues) -> None:
    """Compute inputs, load zone and deflection of the tapered bearing in Smith's Figure 3-6.

    ``findings`` receives the results.
    """
    b = smith_tapered_bearing()
    findings.numbers(
        {
            "F_r": RADIAL / POUND,
            "F_a": SHEET_LOAD / POUND,
            "alpha": float(np.degrees(b.cup_angle)),
            "N": float(b.rollers),
            "L": b.length / INCH,
            "gamma": float(np.degrees(b.roller_angle)),
            "D": b.diameter / INCH,
            "Z": float(np.tan(b.cup_angle)) * RADIAL / SHEET_LOAD,
        }
    )
    zone = tapered_roller.load_zone_under_thrust_and_radial_load(SHEET_LOAD, RADIAL, b.cup_angle, EXPONENT)
    exact = tapered_roller.load_zone_integrals(findings.printed("eps"), EXPONENT)
    ratio = findings.printed("J_r") / findings.printed("J_a")
    words = f"printed J_r/J_a = {ratio:.6g}, Z = {findings.printed('Z'):.6g}; "
    words += f"exact at the printed eps: {exact.thrust_integral:.6f}, {exact.radial_integral:.6g}"
    for key, value in {"J_a": zone.thrust_integral, "J_r": zone.radial_integral, "eps": zone.eps}.items():
        findings.add_number(key, value, words)
    low, high = taper_deflection_range()
    words = (
        f"3.19 gives {taper_sheet_deflection():.6f} in, over the roundings of the inputs {low:.6f} to {high:.6f}; line "
        f"contacts to the rings' depth {taper_displacements()[0] / INCH:.6f}"
    )
    findings.add_number("delta_a", taper_displacements()[0] / INCH, words, as_printed=taper_sheet_deflection())
    radial = taper_sheet_deflection() * float(np.tan(b.cup_angle)) / (2.0 * findings.printed("eps") - 1.0)
    words = f"3.20 with the printed eps {radial:.3g} in"
    findings.add_number("delta_r", taper_displacements()[1] / INCH, words, as_printed=radial)
    slopes, printed = [taper_stiffness(f) for f in ENDS], [taper_sheet_stiffness(f) for f in ENDS]
    balls = [float(ball_bearing_state(f * POUND).stiffness) for f in ENDS]
    *growth, of_balls = (float(error_percent(high, low)) for low, high in (slopes, printed, balls))
    words = (
        f"stiffness grows from {ENDS[0]:.0f} to {ENDS[1]:.0f} lbf by {growth[0]:.0f} % (3.19: {growth[1]:.0f} %); "
        f"that of the ball bearing by {of_balls:.0f} %"
    )
    findings.add_claim("linear", max(growth) < 5.0, words)


def _compute_taper_contacts(findings: ComputedEntryValues) -> None:
    """Compute contact areas and pressures of the tapered roller bearing: chapter 3 of Smith (1994).

    ``findings``: receives the results.
    """
    b = smith_tapered_bearing()
    roller_load = SHEET_LOAD / (b.rollers * float(np.sin(b.cup_angle)))
    widths, pressures = rollers.half_widths_and_pressures_of_slices(b, np.array([roller_load / b.length]))
    areas, rib = 2.0 * widths[0] * b.length, 2.0 * roller_load * float(np.sin(b.roller_angle))
    printed_load, half_width, contact_area, pressure = as_printed.roller_contact_as_printed(
        SHEET_LOAD / POUND, b.rollers, b.length / INCH, b.diameter / INCH, b.pitch_diameter / INCH, b.cone_angle
    )
    findings.follow({"a": 0.5 * b.length / INCH})
    words = f"race load {roller_load / POUND:.0f} lbf with the rib's part, {printed_load:.0f} as printed"
    findings.add_number("b", float(widths[0, 0]) / INCH, words, as_printed=half_width)
    findings.add_number("A", float(areas[0]) / INCH**2, words, as_printed=contact_area)
    findings.add_number("sigma", float(pressures[0, 0]) / PSI, words, as_printed=pressure)
    a_rib, b_rib, area = (findings.printed(k) for k in ("rib_a", "rib_b", "rib_A"))
    load = 2.0 / 3.0 * np.pi * a_rib * b_rib * findings.printed("rib_sigma")
    words = f"printed ellipse and pressure need {load:.0f} lbf, balance of the roller gives {rib / POUND:.0f}"
    for key in ("rib_a", "rib_b", "rib_sigma"):
        findings.add_number(key, None, words)
    words = "pi a b of the printed semi-axes beside a b"
    findings.add_number("rib_A", None, words, as_printed=a_rib * b_rib, follows=np.pi * a_rib * b_rib)
    ours = b.rollers * float(areas.sum()) / INCH**2
    inner, outer = (float(a) / INCH**2 for a in ball_bearing_state(SHEET_LOAD).contact_areas())
    balls = smith_ball_bearing().balls * (inner + outer)
    findings.add_number("area_taper", ours, as_printed=2.0 * b.rollers * contact_area)
    words = "as printed from 0.0065 in2, itself open"
    findings.add_number("area_ball", balls, words, as_printed=2.0 * smith_ball_bearing().balls * 0.0065)
    findings.add_number("area_rib", None, as_printed=b.rollers * area, follows=b.rollers * np.pi * a_rib * b_rib)
    findings.add_claim("less_area", ours < balls, f"{ours:.3f} in2 against {balls:.3f} in2: {ours / balls:.1f} times")


def torque_of_tapered_row_in_lbf(thrust: float) -> tuple[float, float]:
    """Return the friction torque of a row of Smith's tapered bearing at his oil and speed, (low, high) [in-lbf].

    The ends are for coefficients of friction on the rib of 0.03 and 0.15, which are assumed (Smith prints none); the rib's
    contact is a point. ``thrust``: thrust on the row [N], shared equally by its rollers.
    """
    b = smith_tapered_bearing()
    row = RollerRow(b.rollers, b.diameter, b.length, b.cup_angle, b.roller_angle, b.depth, Material(b.young, b.poisson))
    even = np.full((b.rollers, row.slices), thrust / (b.rollers * np.sin(b.cup_angle) * b.length))
    found = torque.roller_bearing_torque(row, even, SPEED, Lubricant(VISCOSITY, DENSITY))
    assert found is not None
    assert found.low is not None
    assert found.high is not None
    return found.low / INCH_POUND, found.high / INCH_POUND


def rib_speed_ft_per_min(speed: float) -> float:
    """Return the speed of the cone's rib [ft/min] where it touches the rollers; ``speed``: of the shaft [rad/s]."""
    b = smith_tapered_bearing()
    from_apex = 0.5 * b.diameter / np.tan(b.roller_angle) + 0.5 * b.length
    radius = from_apex * np.sin(b.cup_angle - 2.0 * b.roller_angle) / np.cos(b.roller_angle)
    return float(60.0 * speed * radius / (12.0 * INCH))


def torque_band_words(thrust: float) -> str:
    """Return a remark with our band of a tapered row's torque at a thrust [N]."""
    low, high = torque_of_tapered_row_in_lbf(thrust)
    return f"ours {low:.2g} to {high:.3g} in-lb, with 0.03 to 0.15 assumed for the rib's friction"


def _compute_taper_tests(findings: ComputedEntryValues) -> None:
    """Compute stiffness and friction torque of the tapered bearing, to compare with the tests in Smith's chapter 3.

    ``findings``: receives the results.
    """
    load = TAPER_TORQUE_LOAD / POUND
    middle = taper_stiffness(load)
    drop = 1e6 * float(rollers.circular_crown_profile(CROWN)(np.array(0.5 * smith_tapered_bearing().length)))
    by_depth = [taper_stiffness(load, depth) for depth in DEPTHS]
    model, test = taper_sheet_stiffness(load), findings.printed("S_test")
    words = (
        f"model as printed {model:.3g}, line contacts {middle:.3g} lbf/in at 1500 lbf: "
        f"{float(error_percent(model, test)):+.0f} and {float(error_percent(middle, test)):+.0f} %; rings "
        f"{1e3 * DEPTHS[0]:g} to {1e3 * DEPTHS[1]:g} mm deep instead of {1e3 * RING_DEPTH:g}: {by_depth[0]:.3g} to "
        f"{by_depth[1]:.3g} lbf/in; a crown of {CROWN:g} m radius, {drop:.0f} um at the ends of both contacts together, "
        f"{crowned_tapered_bearing_stiffness(load):.3g}, but then {crowned_tapered_bearing_stiffness(ENDS[0]):.3g} to "
        f"{crowned_tapered_bearing_stiffness(ENDS[1]):.3g} from {ENDS[0]:.0f} to {ENDS[1]:.0f} lbf, no straight line as "
        "measured"
    )
    findings.add_number("S_test", middle, words)
    findings.add_number("F_torque", load)
    viscosity = VISCOSITY * DENSITY
    implied = torque.timken_factor_from_torque(findings.printed("M") * INCH_POUND, viscosity, SPEED, TAPER_TORQUE_LOAD)
    unit = torque.timken_running_torque(1.0, viscosity, SPEED, TAPER_TORQUE_LOAD) / INCH_POUND
    ours = torque_band_words(TAPER_TORQUE_LOAD)
    findings.add_number("M", None, f"{ours}; by Timken {unit:.4f} in-lb times G_1: needs G_1 = {implied:.0f}")
    factor = 1700.0 * (TAPER_TORQUE_LOAD / POUND) ** 0.67 / (SPEED / RPM * 1e3 * viscosity)
    findings.add_remark("least_speed", f"{SPEED / RPM:.0f} rpm is enough if G_2 is at least {factor:.1f}")
    test = findings.printed("M_test")
    findings.add_number("M_test", None, f"{ours}; needs G_1 = {test / unit:.0f}")
    findings.follow({"M_test_2": 2.0 * test})
    percent = float(error_percent(findings.printed("M"), test))
    findings.add_claim("fair", abs(percent) <= 10.0, f"{percent:+.0f} %")


def chapter_3(findings: ComputedEntryValues, cache: SceneResultCache) -> None:  # noqa: ARG001 - every table takes the study
    """Recompute the numbers printed in chapter 3 of Smith (1994), and check the claims made there.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds.
    ``cache``: not used here.
    """
    _compute_taper_spreadsheet(findings)
    _compute_taper_contacts(findings)
    _compute_taper_tests(findings)
