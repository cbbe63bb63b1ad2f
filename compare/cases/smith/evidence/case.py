"""The bearings and the axis of Smith (1994), as the source gives them, and what had to be assumed."""

from __future__ import annotations

from functools import cache

import numpy as np

from rollbench.lowfi.bearings.angular_contact import BallBearing, BallRow
from rollbench.lowfi.bearings.axis import Axis
from rollbench.lowfi.bearings.sets import BearingSet, arrangement, preloaded
from rollbench.lowfi.rollers.tapered_roller import RollerRow, TaperedBearing
from rollbench.meshes.units import parse

#: The source's units in SI.
INCH = parse("1 in", "length")
POUND = parse("1 lbf", "force")
INCH_POUND = parse("1 in-lbf", "moment")
POUND_PER_INCH = parse("1 lbf/in", "stiffness")
PSI = parse("1 psi", "pressure")
DEG_F = parse("1 degF", "temperature difference")
RPM = np.pi / 30.0
#: What the source leaves open.
ASSUMED = (
    "Poisson's ratio of steel 0.3; Young's modulus of 4.1, 30e6 psi, for the bearings too (the factor 2.15e5 of the sheet "
    "implies 207.5 GPa).",
    "Rings of the tapered bearing 5 mm thick, from bore and outside diameter: the depth to which the line contacts' "
    "deformation is counted.",
    "Density of the grease's base oil 900 kg/m3.",
)
#: What was identified from printed results of the source, and so is confirmed by none of them.
IDENTIFIED = (
    "the exponents 2/3 and 0.66666 of the sheet (from delta* and K_n), its constant 2.15e5 (from K_i, K_o), F(p)_o as an "
    "input (from all cells after it); 1/D in 3.24, the exponent 1/2 in 3.26 and areas without pi (from b, A and the areas "
    "compared)"
)
YOUNG, POISSON = parse("30e6 psi", "pressure"), 0.3
RING_DEPTH, DENSITY = parse("5 mm", "length"), 900.0
#: Load of the sheets, preload of a single bearing, thrust of the torque calculations [N].
SHEET_LOAD, PRELOAD = parse("2040 lbf", "force"), parse("1500 lbf", "force")
BALL_TORQUE_LOAD, TAPER_TORQUE_LOAD = parse("1000 lbf", "force"), parse("1500 lbf", "force")
VISCOSITY, SPEED = 27e-6, 1450.0 * RPM
#: Stretch of 4.1 [m], thermal expansion [1/K], load on the carriage of 4.2 [N], stiffness of the nut [N/m].
STRETCH, EXPANSION = parse("0.0015 in", "length"), 6e-6 / DEG_F
APPLIED, NUT = parse("1000 lbf", "force"), parse("5.5e6 lbf/in", "stiffness")
#: Directions of the rows of 4.2, +1 for those that the shaft's tension loads.
DIRECTIONS: dict[str, dict[str, tuple[int, ...]]] = {
    "ball": {"left": (1, 1, -1), "right": (-1, 1, 1)},
    "taper": {"left": (-1, 1), "right": (1, -1)},
}


@cache
def ball_bearing() -> BallBearing:
    """MM35BS72 of figure 2-10; the outer groove is 0.53 D, which prints as 0.182188 in."""
    d = 0.34375 * INCH
    return BallBearing(18, d, 1.817159 * INCH, 2.520305 * INCH, 0.52 * d, 0.53 * d, YOUNG, POISSON)


@cache
def taper_bearing() -> TaperedBearing:
    """Prototype of figure 3-6."""
    return TaperedBearing(
        16, 0.33 * INCH, 0.49 * INCH, float(np.radians(30.8)), float(np.radians(4.0)), YOUNG, POISSON, RING_DEPTH
    )


@cache
def bearing_set(kind: str, end: str, preload: float = PRELOAD) -> BearingSet:
    """Set of an end: ball bearings ground with the gap of one bearing under the preload, tapered rows preloaded to it."""
    directions = DIRECTIONS[kind][end]
    if kind == "ball":
        row = BallRow(ball_bearing())
        return arrangement(row, directions, row.deflection(preload))
    return preloaded(RollerRow(taper_bearing()), directions, preload)


def axis(left: float = np.inf, right: float = np.inf) -> Axis:
    """Screw of 4.1 on supports of a stiffness [N/m]."""
    return Axis(52.0 * INCH, 0.25 * np.pi * (1.378 * INCH) ** 2, YOUNG, left, right)
