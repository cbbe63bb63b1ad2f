"""Bearings of other programs, makers and textbooks: displacements, contact angles, load zones, preloaded pairs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from rollbench.compare.cases.external.evidence.case import assembly, given, inputs, solved
from rollbench.compare.evidence.record import Sheet
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import entry, load_table
from rollbench.lowfi.bearings.angular_contact import BallBearing, BallRow, of_angle, thrust_state
from rollbench.lowfi.bearings.load_zone import load_zone
from rollbench.lowfi.bearings.sets import BearingSet, equilibrium, lift_off_force, preloaded
from rollbench.lowfi.rating.equivalent import PARTING, equivalent_life, factors, halves, mean_force
from rollbench.lowfi.rating.life import rating
from rollbench.lowfi.statics.result import AxisResult
from rollbench.meshes.parts import FREEDOMS
from rollbench.meshes.units import parse

CLASSES = ("light", "medium", "strong")
#: Conformities between which the growth of rigidity is looked at without an inferred number.
ANY = (0.53, 0.56)


def _motion(found: AxisResult, station: float, freedom: str) -> float:
    """Motion of the shaft at a station [m] in a freedom [m, rad]."""
    place = int(np.abs(found.centreline_z - station).argmin())
    return float(found.centreline[place, FREEDOMS.index(freedom)])


def masta(sheet: Sheet, study: Study) -> None:
    """Deep-groove bearing between rigid rings, the inner one free only along each load."""
    for key, name, freedom, unit in (
        ("radial", "masta-radial", "ux", 1e6),
        ("axial", "masta-axial", "uz", 1e6),
        ("tilt", "masta-moment", "ry", 1e3),
    ):
        result, ring = solved(study, name)
        sheet.number(key, unit * _motion(result, ring.of.position, freedom))


def harris(sheet: Sheet, study: Study) -> None:
    """218 bearing under thrust."""
    result, ring = solved(study, "harris-218")
    assert ring.balls is not None
    angle, moved = float(np.degrees(ring.balls.contact_angle[0, 0])), 1e6 * _motion(result, ring.of.position, "uz")
    sheet.number("angle", angle)
    sheet.number("angle_quoted", angle)
    sheet.number("displacement", moved)
    sheet.number("displacement_quoted", moved)
    sheet.number("ball_load", float(ring.balls.load[:, 0].mean()))


def half_zone(sheet: Sheet, study: Study) -> None:
    """Load zone of half the circumference, by a row of many balls and by the integrals."""
    for key, name in (("radial", "sjovall-radial"), ("combined", "sjovall-combined")):
        ring = solved(study, name)[1]
        assert ring.balls is not None
        across = assembly(name).loads[0].force[0]
        load, rest = ring.balls.load[:, 0], ring.balls.contact_angle[:, 0]
        top = int(load.argmax())
        # a ball of the deep groove carries the same force at both its contacts: the inner one counts
        sheet.number(key, float(load[top]) * load.size * float(np.cos(rest[top])) / across)
        if key == "combined":
            sheet.number("loaded", float(np.count_nonzero(load > 0.0)))
    zone = load_zone(0.5, 1.5)
    sheet.number("thrust", zone.axial / zone.radial)


def _spindle(case: str, row: Sequence[float], conformity: float) -> BallBearing:
    """Bearing of a catalogue row (pitch diameter mm, ball diameter mm, number of balls)."""
    d_m, d_w, balls = row[:3]
    angle, young = given(case, "contact_angle", "angle"), given(case, "youngs_modulus", "pressure")
    poisson = float(inputs()[case]["poissons_ratio"])
    return of_angle(int(balls), 1e-3 * d_w, 1e-3 * d_m, (conformity, conformity), angle, young, poisson)


def _pair(bearing: BallBearing, preload: float) -> BearingSet:
    """Two bearings against each other under a preload [N]."""
    return preloaded(BallRow(bearing), (1, -1), preload)


@cache
def gmn_rigidity(name: str, which: str, conformity: float) -> float:
    """Rigidity [N/um] of a pair of the catalogue at its preload, both rows side by side, at a conformity of the series."""
    row = inputs()["gmn"]["rows"][name]
    one = BallRow(_spindle("gmn", row, conformity))
    return 2e-6 * one.stiffness(one.deflection(float(row[3 + CLASSES.index(which)])))


def gmn_growth(conformity: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Strong over light rigidity of every row, over that printed."""
    out = []
    for name in inputs()["gmn"]["rows"]:
        printed = [entry("external-gmn", f"{name}_{which}").value or np.nan for which in ("light", "strong")]
        ours = [gmn_rigidity(name, which, conformity) for which in ("light", "strong")]
        out.append(ours[1] / ours[0] * printed[0] / printed[1])
    return np.array(out)


def gmn(sheet: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """Preloaded pairs of a series of spindle bearings."""
    inferred = float(inputs()["gmn"]["conformity"])
    for name in inputs()["gmn"]["rows"]:
        for which in CLASSES:
            sheet.number(f"{name}_{which}", gmn_rigidity(name, which, inferred))
    middle = {c: float(np.median(gmn_growth(c))) for c in (*ANY, inferred)}
    words = ", ".join(f"{m:.3f} at conformity {c:g}" for c, m in middle.items())
    sheet.claim("growth", all(abs(float(error_percent(m, 1.0))) <= 2.0 for m in middle.values()), f"median {words}")


def gmn_rms_percent() -> float:
    """RMS [%] of the rigidities of the series against those printed, without the slip."""
    inferred = float(inputs()["gmn"]["conformity"])
    rows = [(r.key.rsplit("_", 1), r.value) for r in load_table("external-gmn") if r.cls == "band" and r.value is not None]
    off = [float(error_percent(gmn_rigidity(name, which, inferred), value)) for (name, which), value in rows]
    return float(np.sqrt(np.mean(np.square(off))))


def snfa(sheet: Sheet, study: Study) -> None:  # noqa: ARG001 - every table takes the study
    """A catalogue whose contact angles stand still: as printed with rigid balls scaled back, right with turning angles."""
    case = inputs()["snfa"]
    row = [1e3 * given("snfa", k, "length") for k in ("pitch_diameter", "ball_diameter")]
    bearing = _spindle("snfa", [*row, case["balls"]], float(case["conformity"]))
    loads = [parse(text, "force") for text in case["preloads"]]
    right = [1e-6 * equilibrium(_pair(bearing, p)).stiffness for p in loads]
    still = [1e-6 * frozen_rigidity(bearing, p) for p in loads]
    for name, value, at in zip(("light", "medium", "heavy"), right, still, strict=True):
        sheet.number(f"rigidity_{name}", value, f"{at:.1f} N/um at a constant angle, conformity {case['conformity']:g}")
    growth = right[-1] / right[0]
    words = f"{growth / (still[-1] / still[0]):.2f} times that at a constant angle: a bearing that may turn stiffens faster"
    sheet.number("growth", growth, words, as_printed=still[-1] / still[0])
    off = lift_off_force(_pair(bearing, loads[-1])) / loads[-1]
    words = f"at {loads[-1]:g} N; the angle turns, and the pair holds together longer"
    sheet.number("lift_off", off, words, as_printed=frozen_lift_off())


def frozen_rigidity(bearing: BallBearing, preload: float) -> float:
    """Rigidity [N/m] of a pair at its preload [N] if the contact angle stood still: 3 F/u, as F ~ u^(3/2) in either row."""
    rest = thrust_state(bearing, 1e-9 * bearing.ball_diameter)
    sin = float(np.sin(bearing.free_angle))
    u = float(rest.inner.C + rest.outer.C) * float(np.cbrt(preload / (bearing.balls * sin))) ** 2 / sin
    return 3.0 * preload / u


def frozen_lift_off() -> float:
    """Load over preload at which a row of a pair becomes loose if the contact angle stood still: 2^(3/2)."""
    return float(2.0**1.5)


#: Examples of mean forces: key of the entry, and of the case with its phases.
EXAMPLES = {"mean_hiwin_mill": "hiwin_mill", "mean_hiwin": "hiwin", "mean_rexroth": "rexroth"}
#: What makers print for 2^(3/2), and how far [%] that may move the force of a half before the halves part.
ROUNDED, WITHIN = 3.0, 5.0
#: Scene whose ratings the combined life is computed with, its preload and force [N].
SCENE, PRELOAD, FORCE = "external-thk-bnf-4010-5", 5000.0, 3000.0


def mean_of_phases(case: str) -> float:
    """Mean force of phases with forces, speeds and shares of the time, in the unit of the forces."""
    given = inputs()[case]
    turned = np.array(given["speeds"], dtype=float) * np.array(given["time"], dtype=float)
    return float(given.get("factor", 1.0)) * mean_force(turned / turned.sum(), np.array(given["forces"], dtype=float))


def loads(sheet: Sheet, study: Study) -> None:
    """Mean forces, forces and life of preloaded halves, factors of rows by contact angle."""
    for key, case in EXAMPLES.items():
        sheet.number(key, mean_of_phases(case))
    sheet.number("parting", PARTING)
    force = np.linspace(0.0, PARTING, 50)
    loaded, other = halves(force, 1.0)
    lower = error_percent((1.0 + force / ROUNDED) ** 1.5, loaded)
    words = (
        f"with 3 the loaded half's force is {-float(lower.min()):.1f} % lower where the halves part, and no higher anywhere"
    )
    holds = bool((lower <= 1e-9).all() and lower.min() >= -WITHIN and np.allclose(loaded - other, force))
    sheet.claim("loaded_half", holds, words)
    scene = study.scene(SCENE)
    nut = replace(scene, loads=tuple(replace(x, force=(0.0, 0.0, FORCE)) for x in scene.loads))
    found = equivalent_life([nut], [1.0], [np.array([0.0, 0.0, FORCE])], PRELOAD)
    assert found is not None
    lives = (rating(nut) / np.array(found.loads)) ** 3
    printed = float((lives ** (-10.0 / 9.0)).sum() ** -0.9)
    words = f"{found.revolutions:.4g} 10^6 revolutions, of {lives[0]:.4g} and {lives[1]:.4g}"
    sheet.claim("combined_life", bool(np.isclose(found.revolutions, printed, rtol=1e-12)), words)
    for name, angle in (row.key.split("_") for row in load_table(sheet.table) if row.key[0] in "eXY"):
        sheet.number(f"{name}_{angle}", factors(float(np.radians(float(angle))))["eXY".index(name)])
