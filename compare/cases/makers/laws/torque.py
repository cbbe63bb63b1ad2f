"""Drag torque of a preloaded nut from the sliding of its balls, beside the makers' formulas and what was measured."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from math import pi, prod, sqrt

import numpy as np

from rollbench.compare.cases.makers.laws.nuts import CONFORMITY, Nut, of_ratings, one_turn
from rollbench.compare.cases.makers.outside import Band, Outside, of_row
from rollbench.compare.cases.makers.tables import table
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.scenes.from_keys import oversize_for
from rollbench.compare.scenes.like import STOCK
from rollbench.lowfi.friction.whole.state import friction_state
from rollbench.meshes.parts import BallErrors, Friction, Load, Motion, Scene, Support

#: Coefficient of friction of balls on grooves: the command's default, and the least that bearings with a film have.
DEFAULT, LEAST = 0.1, 0.003
#: The law, in words.
SLIDING = "sliding of the balls, coefficient 0.1"
#: Balls that stand for all of them.
FEW = 8


def _few(nut: Nut) -> Scene:
    """A turn of a nut with few balls, held at its ends."""
    one = one_turn(nut, CONFORMITY)
    ends = (("ux", "uy", "rx", "ry", "rz"), ("ux", "uy"))
    at = (0.0, one.screw.length)
    return replace(
        one,
        balls=replace(one.balls, azimuths=tuple(2.0 * pi * np.arange(FEW) / FEW)),
        errors=replace(one.errors, balls=BallErrors()),
        supports=tuple(Support(z, tuple((f, 0.0) for f in held)) for z, held in zip(at, ends, strict=True)),
        loads=(),
    )


@cache
def torque_of_ball(nut: Nut, share: float, coefficient: float, *, double: bool) -> float:
    """Drag torque [N m] of one ball whose share of the axial preload is ``share`` [N]: pressed on four flanks by its size,
    or twice that of a ball on two flanks, as the two nuts of a double nut have it."""
    scene = _few(nut)
    if double:
        loaded = replace(scene, loads=(Load(0.0, (0.0, 0.0, share * FEW)),))
    else:
        size = BallErrors(oversize=oversize_for(scene, share * FEW))
        loaded = replace(scene, errors=replace(scene.errors, balls=size))
    found = run_model(loaded, "lin", Options(discretisation=False))
    torque = friction_state(loaded, found, Friction(coefficient, coefficient), Motion(2.0 * pi)).torque.friction
    return (2.0 if double else 1.0) * torque / FEW


def drag_torque(nut: Nut, preload: float, coefficient: float = DEFAULT, *, double: bool = False) -> float:
    """Drag torque [N m] of a nut under a preload [N], of each nut of a double nut; all its turns filled with balls."""
    balls = nut.touching * nut.turns
    return balls * torque_of_ball(nut, preload / balls, coefficient, double=double)


# --- makers' formulas, of preload F [N], nominal diameter and lead [m]


def by_diameter(preload: float, diameter: float, lead: float) -> float:  # noqa: ARG001 - of every formula
    """T = 0.0100 F d_0 [N m], what Rexroth's table of single nuts obeys."""
    return 0.01 * preload * diameter


def by_slope(preload: float, diameter: float, lead: float) -> float:
    """T = 0.05/sqrt(tan beta) F P/(2 pi) [N m] (THK; JIS B 1192), beta the lead angle."""
    return 0.05 / sqrt(lead / (pi * diameter)) * preload * lead / (2.0 * pi)


def by_lead(preload: float, diameter: float, lead: float) -> float:  # noqa: ARG001 - of every formula
    """T = K_p F P/(2 pi) [N m], K_p of 0.2 in the middle of what HIWIN states."""
    return 0.2 * preload * lead / (2.0 * pi)


FORMULAS = (
    ("Rexroth: 0.0100 F d0", by_diameter),
    ("THK: 0.05/sqrt(tan beta) F P/2 pi", by_slope),
    ("HIWIN: 0.2 F P/2 pi", by_lead),
)


@dataclass(frozen=True)
class Drag:
    """Drag torque over preload times nominal diameter of a size: of a single and of a double nut by the sliding of the
    balls, of both at the least coefficient, and by the formulas."""

    diameter: float
    lead: float
    single: float
    double: float
    least: tuple[float, float]
    formulas: tuple[float, ...]


#: Nominal diameter and leads [mm] over which formulas are compared, the ball [mm] that all of them take, axial share of a
#: ball [N].
SWEPT, BALL, SHARE = (32.0, (8.0, 10.0, 16.0, 20.0, 32.0)), 4.763, 60.0


def size(lead: float) -> Nut:
    """One turn of the nut that is swept, at a lead [m]."""
    return Nut(1e-3 * BALL, 1e-3 * (SWEPT[0] + 0.22 * BALL), lead, 1.0, short=False)


def sweep() -> list[Drag]:
    """The same balls under the same preload over the lead."""
    rows = []
    for lead in SWEPT[1]:
        nut, d0 = size(1e-3 * lead), 1e-3 * SWEPT[0]
        drag = [torque_of_ball(nut, SHARE, mu, double=x) / (SHARE * d0) for mu in (DEFAULT, LEAST) for x in (False, True)]
        formulas = tuple(f(1.0, d0, 1e-3 * lead) / d0 for _, f in FORMULAS)
        rows.append(Drag(d0, 1e-3 * lead, drag[0], drag[1], (drag[2], drag[3]), formulas))
    return rows


def order(values: list[float], over: list[float]) -> float:
    """Exponent of a power law through values."""
    return float(np.polyfit(np.log(over), np.log(values), 1)[0])


def printed_torques() -> Iterator[Outside]:
    """Rexroth's ranges of drag torque: their middle is a formula, so that none is judged."""
    source = table("rexroth-preload")
    for row in source.rows:
        ball, outer, lead = (1e-3 * source.number(row[k]) for k in ("ball_diameter_mm", "nominal_diameter_mm", "lead_mm"))
        if not row["torque_low_Nm"]:
            continue
        turns = prod(map(float, row["turns"].replace(",", ".").split("x")))
        share = source.number(row["preload_percent_of_C"])
        nut = Nut(ball, outer + 0.22 * ball, lead, turns, short=False)
        preload, double = 0.01 * share * source.number(row["C_N"]), row["nut_kind"] == "double nut"
        torque = drag_torque(nut, preload, double=double)
        low, high = (source.number(row[k]) for k in ("torque_low_Nm", "torque_high_Nm"))
        what = ("torque", SLIDING, f"{row['nut_kind']} {row['size']}, {share:g} % of C", "N m")
        one = of_row(source, row, "line_values", "torque_high_Nm", what, Band.of((torque,)), left="a formula in disguise")
        yield replace(one, value=0.5 * (low + high), rounding=0.5 * (high - low))


#: What is printed of the two measured screws: lead [m], C and preload [N]; nominal diameters [mm] of such screws.
MEASURED_LEAD, MEASURED_C, MEASURED_PRELOAD, DIAMETERS = 8e-3, 16_400.0, 1_500.0, (25.0, 32.0, 40.0)


def measured_band() -> Band:
    """Drag torque [N m] of the measured screws at the default coefficient: the middle size as a double nut, and the least
    and largest of all sizes, single and double; turns from C, the ball the largest in stock for the lead."""
    ball = 1e-3 * max(b for b in STOCK if b <= 0.635e3 * MEASURED_LEAD)
    found = {}
    for outer in DIAMETERS:
        one = Nut(ball, 1e-3 * outer + 0.22 * ball, MEASURED_LEAD, 1.0, short=False)
        turns = (MEASURED_C / of_ratings(one, CONFORMITY, 0.95)[0]) ** (1.0 / 0.86)
        for double in (False, True):
            found[outer, double] = drag_torque(replace(one, turns=turns), MEASURED_PRELOAD, double=double)
    return Band.of((found[DIAMETERS[1], True], *found.values()))


def measured() -> Iterator[Outside]:
    """Mean friction torque of two screws over their wear: new and at the end of the run; those between are one run."""
    source = table("xjtu-torque")
    band = measured_band()
    ends = {name: [r for r in source.rows if r["screw"] == name] for name in dict.fromkeys(r["screw"] for r in source.rows)}
    for name, rows in ends.items():
        for row, state in ((rows[0], "new"), (rows[-1], "worn")):
            what, maker = ("torque", SLIDING, f"{name}, {state}", "N m"), f"{source.head['maker']}, rig"
            yield of_row(source, row, "line", "torque_Nm", what, band, maker=maker)
