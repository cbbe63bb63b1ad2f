"""Ball nuts: load ratings where balls are printed, rigidity as ISO 3408-4 separates it, its growth with preload."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from math import pi, prod, radians

import numpy as np

from rollbench.compare.cases.makers.outside import Band, Outside, of_row
from rollbench.compare.cases.makers.tables import Table, half_step, table, tables
from rollbench.compare.scenes import catalogue
from rollbench.compare.scenes.from_keys import touching_angle
from rollbench.compare.scenes.like import BEYOND, STOCK, WALL
from rollbench.lowfi.rating.life import rating
from rollbench.lowfi.rating.rigidity import PRACTICE, body_compliance, slope_of
from rollbench.lowfi.rating.static import static_rating
from rollbench.lowfi.statics.contacts import nominal_hertz
from rollbench.meshes.parts import Scene

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
    found = catalogue.shipped("unseen-40x10")
    assert isinstance(found, Scene)
    return found


@dataclass(frozen=True)
class Nut:
    """A nut of a catalogue, lengths in m: ball, pitch diameter, lead, turns of all circuits, whether they are of one
    turn."""

    ball: float
    pitch: float
    lead: float
    turns: float
    short: bool

    @property
    def touching(self) -> float:
        """Balls of a turn that touch."""
        return float(2.0 * pi / touching_angle(0.5 * self.pitch, self.lead, self.ball))

    @property
    def filling(self) -> tuple[float, float]:
        """Share of the turns filled with balls, lowest and highest."""
        return SHORT if self.short else LONG


def one_turn(nut: Nut, conformity: float) -> Scene:
    """One turn of a nut's balls, as many as touch."""
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
    """C and C_0 [N] by ISO 3408-5: of one turn, with the balls and turns that there are."""
    one = one_turn(nut, conformity)
    share = filling * nut.touching / one.ball_count
    return rating(one) * share ** (2.0 / 3.0) * nut.turns**0.86, static_rating(one) * share * nut.turns


def displacement(nut: Nut, conformity: float, filling: float, load: float, *, bodies: bool = True) -> float:
    """Axial displacement [m] of a nut without preload: equal balls, and the widening of nut and screw as thick tubes."""
    one = one_turn(nut, conformity)
    constants, slope = nominal_hertz(one).C, slope_of(one)
    each = load / (filling * nut.touching * nut.turns * slope)
    tubes = (body_compliance(one) or 0.0) / nut.turns if bodies else 0.0
    return float((constants[0] + constants[3]) * np.cbrt(each) ** 2 / slope + tubes * load)


# --- reading


def turns_printed(row: Mapping[str, str]) -> tuple[float, bool]:
    """Turns of all circuits of a row, and whether each circuit is of one turn: ``4`` of ``T4`` or ``K4``, ``2x2.5`` whose
    sign may be lost, circuits and turns apart, ``1,2x4`` of several starts."""
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
    """The nut of a row; a ball that is not printed is the one in stock that fits pitch and root diameter, a pitch circle
    that is not printed lies as usual beyond the nominal diameter."""
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
    """Maker, with what tells apart nuts that he rates by different rules."""
    maker = source.head["maker"]
    if maker == "HIWIN":
        return f"{maker}, " + ("whole" if row["turns"].startswith("K") else "one-turn") + " recirculation"
    if maker == "THK":
        return f"{maker}, " + ("without preload" if row["type"] == "single nut" else "preloaded")
    return "TBI, Wangong" if maker in ("TBI", "Wangong") else maker  # whose tables of one series are one


# --- laws


def nut_ratings() -> Iterator[Outside]:
    """C and C_0 of nuts whose balls are printed; band: usual conformities and fillings."""
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
    """Share of the balls that touch on which a maker's C_0 [N] rests, by ISO 3408-5 at the middle conformity."""
    return static / of_ratings(nut, CONFORMITY, 1.0)[1]


def nut_rigidity() -> Iterator[Outside]:
    """Rigidity of nuts under 0.3 C: secants without preload, and from the preload of 0.1 C on. Contacts and tubes; as many
    balls as the maker's own C_0 rests on, so that nothing is free but the band of conformities and 5 % of the balls."""
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
    """Rigidity of preloaded nuts at several preloads: that at the highest from contacts, the others by the cube root of the
    preload from it."""
    source = table("rexroth-preload")
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
