"""Ball nuts: load ratings where balls are printed, rigidity as ISO 3408-4 separates it, its growth with preload.

Drag torque of a preloaded nut from the sliding of its balls, beside the makers' formulas and what was measured.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from math import pi, prod, radians, sqrt

import numpy as np

from rollbench.compare.cases.makers.outside import Band, Outside, of_row
from rollbench.compare.cases.makers.tables import Table, half_step, read_table, tables
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.from_keys import oversize_for, touching_angle
from rollbench.compare.scenes.template import BEYOND, STOCK, WALL
from rollbench.lowfi.friction.whole.state import friction_state
from rollbench.lowfi.rating.contacts import static_rating
from rollbench.lowfi.rating.life import dynamic_rating
from rollbench.lowfi.rating.rigidity import PRACTICE, approach_per_displacement, body_compliance
from rollbench.lowfi.statics.contacts import error_free_hertz
from rollbench.meshes.parts import BallErrors, Friction, Load, Motion, Scene, Support

#: Conformity: middle and ends of what is usual; contact angle [deg]. Neither is printed.
CONFORMITY, CONFORMITIES, ANGLE = 0.5225, (0.515, 0.53), 45.0

#: Share of the turns that is filled with balls, lowest and highest: circuits of more than one turn, and those of one, whose
#: deflector may take a third of it.
LONG, SHORT = (0.9, 1.0), (0.65, 1.0)

#: Pitch less root diameter over the ball's diameter: the ball at 45 deg in a gothic arch of usual conformity.
DEPTH = 1.03

#: Load over C under which rigidity is computed; preload over C of THK's preloaded nuts.
LOADED, PRELOADED = 0.3, 0.1

#: Secant up to the load at which a nut of a preloaded pair is loose, 2^(3/2) preloads.
LIFT = 2.0**1.5


@cache
def _base() -> Scene:
    """Return the shipped scene of a ball screw that all nuts are made from."""
    found = catalogue.shipped("unseen-40x10")
    assert isinstance(found, Scene)
    return found


@dataclass(frozen=True)
class Nut:
    """A nut of a catalogue, lengths in m."""

    ball: float
    pitch: float
    lead: float
    turns: float
    short: bool

    @property
    def touching(self) -> float:
        """Number of balls in one turn if they touch one another."""
        return float(2.0 * pi / touching_angle(0.5 * self.pitch, self.lead, self.ball))

    @property
    def filling(self) -> tuple[float, float]:
        """Share of the turns filled with balls, lowest and highest."""
        return SHORT if self.short else LONG


def one_turn(nut: Nut, conformity: float) -> Scene:
    """Return a scene with one turn of a nut, filled with balls that touch each other."""
    one, groove = _base(), conformity * nut.ball
    balls = max(1, round(nut.touching))
    outside = nut.pitch + (1.0 + 2.0 * WALL) * nut.ball
    return replace(
        one,
        track=replace(one.track, pitch_radius=0.5 * nut.pitch, lead=nut.lead, contact_angle=radians(ANGLE), starts=1),
        screw=replace(one.screw, groove_radius=groove, outer_diameter=nut.pitch - 2.0 * BEYOND * nut.ball, bore=0.0),
        nut=replace(one.nut, groove_radius=groove, outer_diameter=outside),
        balls=replace(one.balls, radius=0.5 * nut.ball, azimuths=tuple(2.0 * pi * np.arange(balls) / balls)),
    )


def of_ratings(nut: Nut, conformity: float, filling: float) -> tuple[float, float]:
    """Return C and C_0 [N] by ISO 3408-5: computed for one turn, scaled to the nut's balls and turns."""
    one = one_turn(nut, conformity)
    share = filling * nut.touching / one.ball_count
    return dynamic_rating(one) * share ** (2.0 / 3.0) * nut.turns**0.86, static_rating(one) * share * nut.turns


def displacement(nut: Nut, conformity: float, filling: float, load: float, *, bodies: bool = True) -> float:
    """Return the axial displacement of a nut without preload [m]: equal balls, nut and screw as thick tubes."""
    one = one_turn(nut, conformity)
    constants, slope = error_free_hertz(one).C, approach_per_displacement(one)
    each = load / (filling * nut.touching * nut.turns * slope)
    tubes = (body_compliance(one) or 0.0) / nut.turns if bodies else 0.0
    return float((constants[0] + constants[3]) * np.cbrt(each) ** 2 / slope + tubes * load)


# --- reading


def turns_printed(row: Mapping[str, str]) -> tuple[float, bool]:
    """Return the turns of all circuits of a row, and whether each circuit has one turn.

    ``4`` of ``T4`` or ``K4``, ``2x2.5`` whose sign may be lost, circuits and turns separately, ``1,2x4`` of several starts.
    """
    circuits, turns = row["circuits"], row["turns"].replace(",", ".")
    if "of the name" in turns:
        return float(circuits), turns.startswith("T")
    if turns == "rows x turns":
        rows, each = circuits.split("x") if "x" in circuits else (circuits[0], circuits[1:])
        return float(rows) * float(each), float(each) == 1.0
    if circuits == turns:  # 1x4: four circuits of one turn
        return float(prod(map(float, turns.split("x")))), True
    if circuits:
        return float(circuits) * float(turns), float(turns) == 1.0
    return float(prod(map(float, turns.split("x")))), False


def nut_of(source: Table, row: Mapping[str, str]) -> Nut:
    """Return the nut of a catalogue row.

    If the ball is not printed, it is the stock size that fits pitch and root diameter. If the pitch circle is not
    printed, it lies beyond the nominal diameter by the usual amount.
    """
    pitch = source.number(row["pitch_mm"]) if row["pitch_mm"] else 0.0
    if row["ball_mm"]:
        ball = source.number(row["ball_mm"])
    else:
        fits = (pitch - source.number(row["root_mm"])) / DEPTH
        ball = min(STOCK, key=lambda known: abs(known - fits))
    pitch = pitch or source.number(row["diameter_mm"]) + 2.0 * BEYOND * ball
    turns, short = turns_printed(row)
    return Nut(1e-3 * ball, 1e-3 * pitch, 1e-3 * source.number(row["lead_mm"]), turns, short)


def family(source: Table, row: Mapping[str, str]) -> str:
    """Return the maker, with the type of nut if this maker rates types by different rules."""
    maker = source.head["maker"]
    if maker == "HIWIN":
        return f"{maker}, " + ("whole" if row["turns"].startswith("K") else "one-turn") + " recirculation"
    if maker == "THK":
        return f"{maker}, " + ("without preload" if row["type"] == "single nut" else "preloaded")
    return "TBI, Wangong" if maker in ("TBI", "Wangong") else maker  # whose tables of one series are one


# --- laws


def nut_ratings() -> Iterator[Outside]:
    """Yield C and C_0 of nuts whose balls are printed; band: usual conformities and fillings."""
    for source in tables("nuts-"):
        for row in source.rows:
            if not row["ball_mm"]:
                continue
            nut, unit = nut_of(source, row), source.unit("load_unit")
            corners = [(CONFORMITY, 0.5 * sum(nut.filling))] + [(c, x) for c in CONFORMITIES for x in nut.filling]
            found = np.array([of_ratings(nut, *corner) for corner in corners]) / unit
            for k, key in enumerate(("C", "C0")):
                what = ("rating", "ISO 3408-5", f"{row['nut']} {key}", source.head["load_unit"])
                yield of_row(source, row, "line", key, what, Band.of(found[:, k]), maker=family(source, row))


def share_of_balls(nut: Nut, static: float) -> float:
    """Return the number of balls implied by a maker's C_0 [N] over that of touching balls (ISO 3408-5)."""
    return static / of_ratings(nut, CONFORMITY, 1.0)[1]


def nut_rigidity() -> Iterator[Outside]:
    """Yield the secant rigidity of nuts under 0.3 C, without preload or from a preload of 0.1 C.

    Contacts and tubes only. The maker's C_0 sets the number of balls, so that only conformity and 5 % of the balls
    can vary.
    """
    for source in tables("nuts-"):
        for row in source.rows:
            if not row.get("rigidity"):
                continue
            nut, unit = nut_of(source, row), source.unit("load_unit")
            load = LOADED * source.number(row["C"]) * unit
            share = share_of_balls(nut, source.number(row["C0"]) * unit)
            preload = PRELOADED / LOADED * load if row["type"] in source.head.get("preloaded", "-").split(", ") else 0.0

            def secant(
                conformity: float, filling: float, nut: Nut = nut, load: float = load, held: float = preload
            ) -> float:
                start = displacement(nut, conformity, filling, held) if held else 0.0
                return load / (displacement(nut, conformity, filling, load) - start)

            stiff = source.unit("rigidity_unit")
            corners = [(CONFORMITY, share)] + [(c, x * share) for c in CONFORMITIES for x in (0.95, 1.05)]
            band = Band.of(secant(*corner) / stiff for corner in corners)
            what = ("rigidity", "contacts and tubes under 0.3 C", row["nut"], source.head["rigidity_unit"])
            maker, practice = family(source, row), PRACTICE * band.value
            yield of_row(source, row, "line", "rigidity", what, band, maker=maker, practice=practice)


def preloaded_nuts() -> Iterator[Outside]:
    """Yield the rigidity of preloaded nuts at several preloads.

    From contacts at the highest preload; at the others scaled from there by the cube root of the preload.
    """
    source = read_table("rexroth-preload")
    groups: dict[tuple[str, str], list[Mapping[str, str]]] = {}
    for row in source.rows:
        groups.setdefault((row["nut_kind"], row["size"]), []).append(row)
    for (kind, size), rows in groups.items():
        turns = prod(map(float, rows[0]["turns"].replace(",", ".").split("x")))
        ball, outer, lead = (
            1e-3 * source.number(rows[0][k]) for k in ("ball_diameter_mm", "nominal_diameter_mm", "lead_mm")
        )
        nut = Nut(ball, outer + 2.0 * BEYOND * ball, lead, turns, short=False)
        ordered = sorted(rows, key=lambda row: source.number(row["preload_percent_of_C"]))
        top = ordered[-1]
        for row in ordered:
            share = source.number(row["preload_percent_of_C"])
            preload = 0.01 * share * source.number(row["C_N"])
            if row is top:
                ends = [
                    1e-6 * LIFT * preload / displacement(nut, c, x, preload, bodies=bodies)
                    for c, x, bodies in ((CONFORMITY, 0.95, True), (0.515, 1.0, False), (0.53, 0.9, True))
                ]
                law, practice = "contacts and tubes, both nuts loaded", PRACTICE * ends[0]
            else:
                base, step = source.number(top["Rnu_N_per_um"]), half_step(top["Rnu_N_per_um"])
                growth = np.cbrt(share / source.number(top["preload_percent_of_C"]))
                ends, law, practice = [x * growth for x in (base, base + step, base - step)], "growth with preload", None
            what = ("rigidity", law, f"{kind} {size}, {share:g} % of C", "N/um")
            yield of_row(source, row, "line_values", "Rnu_N_per_um", what, Band.of(ends), practice=practice)


#: Coefficient of friction of balls on grooves: the command's default, and the least that bearings with a film have.
DEFAULT, LEAST = 0.1, 0.003

#: The law, in words.
SLIDING = "sliding of the balls, coefficient 0.1"

#: Balls that stand for all of them.
FEW = 8


def _few(nut: Nut) -> Scene:
    """Return one turn of a nut with only a few balls, on a screw that is supported at both ends."""
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
    """Return the drag torque [N m] of one ball that carries a ``share`` [N] of the axial preload.

    A single nut presses its oversize ball on four flanks. For a double nut: twice the torque of a ball on two flanks.
    """
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
    """Return the drag torque [N m] of a nut under a preload [N]; ``double``: of a double nut.

    All turns are filled with balls.
    """
    balls = nut.touching * nut.turns
    return balls * torque_of_ball(nut, preload / balls, coefficient, double=double)


# --- makers' formulas, of preload F [N], nominal diameter and lead [m]


def by_diameter(preload: float, diameter: float, lead: float) -> float:  # noqa: ARG001 - of every formula
    """Return T = 0.0100 F d_0 [N m], the formula behind Rexroth's table of single nuts."""
    return 0.01 * preload * diameter


def by_slope(preload: float, diameter: float, lead: float) -> float:
    """Return T = 0.05/sqrt(tan beta) F P/(2 pi) [N m] (THK; JIS B 1192), beta the lead angle."""
    return 0.05 / sqrt(lead / (pi * diameter)) * preload * lead / (2.0 * pi)


def by_lead(preload: float, diameter: float, lead: float) -> float:  # noqa: ARG001 - of every formula
    """Return T = K_p F P/(2 pi) [N m] with K_p = 0.2, the middle of the range that HIWIN states."""
    return 0.2 * preload * lead / (2.0 * pi)


FORMULAS = (
    ("Rexroth: 0.0100 F d0", by_diameter),
    ("THK: 0.05/sqrt(tan beta) F P/2 pi", by_slope),
    ("HIWIN: 0.2 F P/2 pi", by_lead),
)


@dataclass(frozen=True)
class Drag:
    """Drag torque over preload times nominal diameter, of one size."""

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
    """Return one turn of the nut used for the sweep over lead, at a lead [m]."""
    return Nut(1e-3 * BALL, 1e-3 * (SWEPT[0] + 0.22 * BALL), lead, 1.0, short=False)


def sweep() -> list[Drag]:
    """Return the computed torque of a nut over the lead, with the balls and the preload unchanged."""
    rows = []
    for lead in SWEPT[1]:
        nut, d0 = size(1e-3 * lead), 1e-3 * SWEPT[0]
        drag = [torque_of_ball(nut, SHARE, mu, double=x) / (SHARE * d0) for mu in (DEFAULT, LEAST) for x in (False, True)]
        formulas = tuple(f(1.0, d0, 1e-3 * lead) / d0 for _, f in FORMULAS)
        rows.append(Drag(d0, 1e-3 * lead, drag[0], drag[1], (drag[2], drag[3]), formulas))
    return rows


def power_exponent(values: list[float], over: list[float]) -> float:
    """Return the exponent of a power law through values."""
    return float(np.polyfit(np.log(over), np.log(values), 1)[0])


def printed_torques() -> Iterator[Outside]:
    """Yield Rexroth's drag-torque ranges, not judged since their middle follows a formula."""
    source = read_table("rexroth-preload")
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
    """Return the drag torque [N m] of the measured screws at the default friction coefficient, as a band.

    First value: the middle size as a double nut; the band covers all sizes, single and double. The turns follow from
    C, the ball is the largest in stock for the lead.
    """
    ball = 1e-3 * max(b for b in STOCK if b <= 0.635e3 * MEASURED_LEAD)
    found = {}
    for outer in DIAMETERS:
        one = Nut(ball, 1e-3 * outer + 0.22 * ball, MEASURED_LEAD, 1.0, short=False)
        turns = (MEASURED_C / of_ratings(one, CONFORMITY, 0.95)[0]) ** (1.0 / 0.86)
        for double in (False, True):
            found[outer, double] = drag_torque(replace(one, turns=turns), MEASURED_PRELOAD, double=double)
    return Band.of((found[DIAMETERS[1], True], *found.values()))


def measured_torques() -> Iterator[Outside]:
    """Yield the mean friction torque of two screws: new, and worn at the end of the test.

    Values in between belong to the same test and are left out.
    """
    source = read_table("xjtu-torque")
    band = measured_band()
    ends = {name: [r for r in source.rows if r["screw"] == name] for name in dict.fromkeys(r["screw"] for r in source.rows)}
    for name, rows in ends.items():
        for row, state in ((rows[0], "new"), (rows[-1], "worn")):
            what, maker = ("torque", SLIDING, f"{name}, {state}", "N m"), f"{source.head['maker']}, rig"
            yield of_row(source, row, "line", "torque_Nm", what, band, maker=maker)
