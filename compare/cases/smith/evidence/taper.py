"""Smith, chapter 3: the tapered roller bearing, its contacts and its torque."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np

from rollbench.compare.cases.smith.evidence import case
from rollbench.compare.cases.smith.evidence.ball import state
from rollbench.compare.evidence.record import Sheet
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study
from rollbench.lowfi.bearings import as_printed
from rollbench.lowfi.bearings.combined_load import CombinedState, combined
from rollbench.lowfi.bearings.load_zone import load_zone, zone_of_load
from rollbench.lowfi.bearings.torque import taper_geometry, taper_torque
from rollbench.lowfi.rollers.roller_slices import SlicedRow, circular_crown
from rollbench.lowfi.rollers.tapered_roller import RollerContacts, RollerRow, roller_contacts

#: Radial load of the sheet [N], and exponent of its load zone.
RADIAL, EXPONENT = case.POUND, 1.1
#: Thrusts [lbf] over which the curve is judged straight or not.
ENDS = (500.0, 2500.0)
#: Depths [m] that show what the assumed thickness of the rings is worth.
DEPTHS = (2.5e-3, 10e-3)
#: Radius [m] of a crown that would make the stiffness about the measured one, and slices of the roller.
CROWN, SLICES = 2.0, 101


@cache
def right() -> CombinedState:
    """Figure 3-6 with line contacts, roller by roller."""
    return combined(case.taper_bearing(), case.SHEET_LOAD, RADIAL)


@cache
def contacts() -> RollerContacts:
    """Contacts of a roller under the thrust of the sheet."""
    b = case.taper_bearing()
    return roller_contacts(b, case.SHEET_LOAD / (b.rollers * float(np.sin(b.cup_angle))))


def tangent(pounds: float, depth: float = case.RING_DEPTH) -> float:
    """Right axial stiffness [lbf/in] at a thrust [lbf], with the rings' deformation counted to a depth [m]."""
    row = RollerRow(replace(case.taper_bearing(), depth=depth))
    return row.stiffness(row.deflection(pounds * case.POUND)) / case.POUND_PER_INCH


def crowned(pounds: float) -> float:
    """Stiffness [lbf/in] at a thrust [lbf] with crowned rollers, in slices: what a crown could explain."""
    row = SlicedRow(case.taper_bearing(), SLICES, circular_crown(CROWN))
    return row.stiffness(row.deflection(pounds * case.POUND)) / case.POUND_PER_INCH


def printed_deflection(pounds: float, length: float, diameter: float, cup: float, roller: float) -> float:
    """Axial deflection [in] by 3.17-3.21 as printed, pure thrust [lbf]; lengths [in], angles [rad]."""
    line = pounds / (case.taper_bearing().rollers * np.sin(cup) * length)
    return as_printed.roller_approach(float(line), diameter, cup, roller) / float(np.sin(cup))


def sheet_deflection(pounds: float = case.SHEET_LOAD / case.POUND) -> float:
    """The same with the inputs of figure 3-6 [in]."""
    b = case.taper_bearing()
    return printed_deflection(pounds, b.length / case.INCH, b.diameter / case.INCH, b.cup_angle, b.roller_angle)


def rounding_range() -> tuple[float, float]:
    """Least and greatest deflection [in] as printed over all roundings of the printed inputs."""
    b = case.taper_bearing()
    half = (0.005, 0.005, np.radians(0.05), np.radians(0.005))
    middle = (b.length / case.INCH, b.diameter / case.INCH, b.cup_angle, b.roller_angle)
    found = []
    for signs in product((-1.0, 1.0), repeat=4):
        length, diameter, cup, roller = (float(m + s * h) for m, s, h in zip(middle, signs, half, strict=True))
        found.append(printed_deflection(case.SHEET_LOAD / case.POUND, length, diameter, cup, roller))
    return min(found), max(found)


def sheet_tangent(pounds: float) -> float:
    """Slope of the sheet's own curve [lbf/in]."""
    return 2.0 / (sheet_deflection(pounds + 1.0) - sheet_deflection(pounds - 1.0))


def _sheet(e: Sheet) -> None:
    b = case.taper_bearing()
    e.numbers(
        {
            "F_r": RADIAL / case.POUND,
            "F_a": case.SHEET_LOAD / case.POUND,
            "alpha": float(np.degrees(b.cup_angle)),
            "N": float(b.rollers),
            "L": b.length / case.INCH,
            "gamma": float(np.degrees(b.roller_angle)),
            "D": b.diameter / case.INCH,
            "Z": float(np.tan(b.cup_angle)) * RADIAL / case.SHEET_LOAD,
        }
    )
    zone = zone_of_load(case.SHEET_LOAD, RADIAL, b.cup_angle, EXPONENT)
    exact = load_zone(e.printed("eps"), EXPONENT)
    ratio = e.printed("J_r") / e.printed("J_a")
    words = f"printed J_r/J_a = {ratio:.6g}, Z = {e.printed('Z'):.6g}; "
    words += f"exact at the printed eps: {exact.axial:.6f}, {exact.radial:.6g}"
    e.number("J_a", zone.axial, words)
    e.number("J_r", zone.radial, words)
    e.number("eps", zone.eps, words)
    low, high = rounding_range()
    e.number(
        "delta_a",
        right().axial / case.INCH,
        f"3.19 gives {sheet_deflection():.6f} in, over the roundings of the inputs {low:.6f} to {high:.6f}; line contacts "
        f"to the rings' depth {right().axial / case.INCH:.6f}",
        as_printed=sheet_deflection(),
    )
    radial = sheet_deflection() * float(np.tan(b.cup_angle)) / (2.0 * e.printed("eps") - 1.0)
    e.number("delta_r", right().radial / case.INCH, f"3.20 with the printed eps {radial:.3g} in", as_printed=radial)
    slopes, printed = [tangent(f) for f in ENDS], [sheet_tangent(f) for f in ENDS]
    growth = [float(error_percent(v[1], v[0])) for v in (slopes, printed)]
    e.claim(
        "linear",
        max(growth) < 5.0,
        f"stiffness grows from {ENDS[0]:.0f} to {ENDS[1]:.0f} lbf by {growth[0]:.0f} % (3.19: {growth[1]:.0f} %); "
        f"that of the ball bearing by {_ball_growth():.0f} %",
    )


def _ball_growth() -> float:
    low, high = (float(state(f * case.POUND).stiffness) for f in ENDS)
    return float(error_percent(high, low))


def _contacts(e: Sheet) -> None:
    b, c = case.taper_bearing(), contacts()
    p = as_printed.taper_contact(
        case.SHEET_LOAD / case.POUND,
        b.rollers,
        b.length / case.INCH,
        b.diameter / case.INCH,
        b.pitch_diameter / case.INCH,
        b.cone_angle,
    )
    e.number("a", 0.5 * b.length / case.INCH)
    race = case.SHEET_LOAD / (b.rollers * float(np.sin(b.cup_angle))) / case.POUND
    words = f"race load {race:.0f} lbf with the rib's part, {p.load:.0f} as printed"
    e.number("b", float(c.half_widths[0]) / case.INCH, words, as_printed=p.half_width)
    e.number("A", float(c.areas[0]) / case.INCH**2, words, as_printed=p.area)
    e.number("sigma", float(c.pressures[0]) / case.PSI, words, as_printed=p.pressure)
    a_rib, b_rib, area = (e.printed(k) for k in ("rib_a", "rib_b", "rib_A"))
    load = 2.0 / 3.0 * np.pi * a_rib * b_rib * e.printed("rib_sigma")
    words = f"printed ellipse and pressure need {load:.0f} lbf, balance of the roller gives {c.rib_load / case.POUND:.0f}"
    for key in ("rib_a", "rib_b", "rib_sigma"):
        e.number(key, None, words)
    e.number("rib_A", np.pi * a_rib * b_rib, "pi a b of the printed semi-axes beside a b", as_printed=a_rib * b_rib)
    ours = b.rollers * float(c.areas.sum()) / case.INCH**2
    inner, outer = (float(a) / case.INCH**2 for a in state(case.SHEET_LOAD).areas())
    balls = case.ball_bearing().balls * (inner + outer)
    e.number("area_taper", ours, as_printed=2.0 * b.rollers * p.area)
    e.number(
        "area_ball", balls, "as printed from 0.0065 in2, itself open", as_printed=2.0 * case.ball_bearing().balls * 0.0065
    )
    e.number("area_rib", b.rollers * np.pi * a_rib * b_rib, as_printed=b.rollers * area)
    e.claim("less_area", ours < balls, f"{ours:.3f} in2 against {balls:.3f} in2: {ours / balls:.1f} times")


def _torque(e: Sheet) -> None:
    load = case.TAPER_TORQUE_LOAD / case.POUND
    middle = tangent(load)
    drop = 1e6 * float(circular_crown(CROWN)(np.array(0.5 * case.taper_bearing().length)))
    by_depth = [tangent(load, depth) for depth in DEPTHS]
    model, test = sheet_tangent(load), e.printed("S_test")
    e.number(
        "S_test",
        middle,
        f"model as printed {model:.3g}, line contacts {middle:.3g} lbf/in at 1500 lbf: "
        f"{float(error_percent(model, test)):+.0f} and {float(error_percent(middle, test)):+.0f} %; rings "
        f"{1e3 * DEPTHS[0]:g} to {1e3 * DEPTHS[1]:g} mm deep instead of {1e3 * case.RING_DEPTH:g}: {by_depth[0]:.3g} to "
        f"{by_depth[1]:.3g} lbf/in; a crown of {CROWN:g} m radius, {drop:.0f} um at the ends of both contacts together, "
        f"{crowned(load):.3g}, but then {crowned(ENDS[0]):.3g} to {crowned(ENDS[1]):.3g} from "
        f"{ENDS[0]:.0f} to {ENDS[1]:.0f} lbf, no straight line as measured",
    )
    e.number("F_torque", load)
    viscosity = case.VISCOSITY * case.DENSITY
    implied = taper_geometry(e.printed("M") * case.INCH_POUND, viscosity, case.SPEED, case.TAPER_TORQUE_LOAD)
    unit = taper_torque(1.0, viscosity, case.SPEED, case.TAPER_TORQUE_LOAD) / case.INCH_POUND
    e.number("M", None, f"{unit:.4f} in-lb times G_1: needs G_1 = {implied:.0f}")
    test = e.printed("M_test")
    e.number("M_test", None, f"needs G_1 = {test / unit:.0f}")
    e.number("M_test_2", 2.0 * test)
    percent = float(error_percent(e.printed("M"), test))
    e.claim("fair", abs(percent) <= 10.0, f"{percent:+.0f} %")


def chapter_3(e: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Every entry of chapter 3."""
    _sheet(e)
    _contacts(e)
    _torque(e)
