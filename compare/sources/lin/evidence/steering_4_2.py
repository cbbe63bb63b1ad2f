"""Section 4.2: lash tests of a ball screw, sizing of bearing and ball screw in a steering gear."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rollbench.comparison.models.registry import Options, run_model
from rollbench.comparison.models.study import Study
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.sources.lin.evidence.lash_4_2_1 import TURNS, lash
from rollbench.comparison.wings.evidence.record import Evidence, Sheet
from rollbench.lowfi.statics.result import AxisResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly

#: Shipped scenes, total rack force [N], distance of the lateral force of the conical lash test from the nut [m].
SCREW, RACK = "lin-nominal-4p1", "lin-steering-rack"
FORCE, REACH = 14500.0, 0.3
#: Tie-rod angles [deg], and stations of the pinion [m], which the source does not print.
ANGLES, PINIONS = (0.0, 6.0, 12.0, 18.0), (0.45, 0.6, 0.7)


def rack() -> Assembly:
    """The shipped steering gear."""
    found = catalogue.shipped(RACK)
    if not isinstance(found, Assembly):
        raise AssertionError(f"{RACK} has several sets")
    return found


def at_angle(gear: Assembly, angle: float, *, opposed: bool = False) -> AxisResult:
    """The gear with half of the rack force at either end, at a tie-rod angle [deg]; opposed: the side forces of both ends
    against one another."""
    t = np.radians(angle)
    sides = (1.0, -1.0 if opposed else 1.0)
    forces = [(side * 0.5 * FORCE * float(np.sin(t)), 0.0, 0.5 * FORCE * float(np.cos(t))) for side in sides]
    loads = tuple(replace(x, force=f) for x, f in zip(gear.loads, forces, strict=True))
    return run_model(replace(gear, loads=loads), "lin", Options(engine="compiled"))


def largest(result: AxisResult) -> tuple[float, float]:
    """Largest contact loads [N] of ball screw and bearing."""
    screw, bearing = (0.0 if s.balls is None else float(s.balls.load.max()) for s in result.sets)
    return screw, bearing


def ratios(gear: Assembly, *, opposed: bool = False) -> tuple[float, float]:
    """Largest loads at 18 deg over those at 0 deg, ball screw and bearing; opposed: see `at_angle`."""
    low, high = largest(at_angle(gear, 0.0)), largest(at_angle(gear, 18.0, opposed=opposed))
    return high[0] / low[0], high[1] / low[1]


def section_4_2(study: Study) -> tuple[Evidence, ...]:
    """Table 4.1 and sections 4.2.1, 4.2.2."""
    sheet, scene = Sheet("lin-4.2.1"), study.scene(SCREW)
    material = scene.balls.material
    given = {
        "length": 1e3 * scene.screw.length,
        "position": 1e3 * scene.nut.position,
        "pitch_radius": 1e3 * scene.track.pitch_radius,
        "lead": 1e3 * scene.track.lead,
        "beta": float(np.degrees(scene.track.contact_angle)),
        "ball": 1e3 * scene.balls.radius,
        "groove": 1e3 * scene.screw.groove_radius,
        "balls": float(scene.ball_count),
        "turns": TURNS,
        "E": material.youngs_modulus,
        "nu": material.poissons_ratio,
    }
    for key, value in given.items():
        sheet.number(key, value)
    _lash(sheet, study)
    _sizing(sheet)
    return sheet.evidence()


def _lash(sheet: Sheet, study: Study) -> None:
    found = lash(study.scene(SCREW), REACH)
    by_direction = ", ".join(f"{x:.1f}" for x in found.conical)
    words = f"lateral force at {1e3 * REACH:.0f} mm; by direction {by_direction} %"
    sheet.number("axial", found.axial, "screw kept from turning only")
    sheet.number("conical", max(found.conical), words)
    sheet.claim("robust", found.axial < min(found.conical), f"{found.axial:.1f} % against {by_direction} %")


def _sizing(sheet: Sheet) -> None:
    gear = rack()
    results = [at_angle(gear, angle) for angle in ANGLES]
    loads = np.array([largest(r) for r in results])
    places = []
    for z in PINIONS:
        (pinion,) = gear.supports
        screw, bearing = ratios(replace(gear, supports=(replace(pinion, at=z),)))
        places.append(f"{1e3 * z:.0f} mm: {screw:.2f} and {bearing:.2f}")
    words = f"by the pinion's station, ball screw and bearing: {'; '.join(places)}"
    sheet.number("ratio_screw", float(loads[-1, 0] / loads[0, 0]), words)
    sheet.number("ratio_bearing", float(loads[-1, 1] / loads[0, 1]), words)
    over = ", ".join(f"{a:.0f} and {b:.0f} N at {t:.0f} deg" for (a, b), t in zip(loads, ANGLES, strict=True))
    sheet.claim("grows", bool(np.all(np.diff(loads, axis=0) > 0.0)), f"ball screw and bearing {over}")
    even, ring = (_loaded(results[0], i) for i in range(2))
    sheet.claim("even_bearing", bool(ring.min() > 0.8 * ring.max()), f"{ring.min():.0f} to {ring.max():.0f} N")
    tilted = _loaded(results[-1], 0)
    low, high = (float(x / even.mean()) for x in (even.min(), even.max()))
    words = (
        f"{even.min():.0f} to {even.max():.0f} N, {low:.2f} to {high:.2f} of the mean, scatter "
        f"{100.0 * even.std() / even.mean():.0f} %; at 18 deg up to {tilted.max() / tilted.mean():.2f} of it"
    )
    sheet.claim("even_screw", bool(even.min() > 0.8 * even.max()), words)


def _loaded(result: AxisResult, i: int) -> Array:
    """Loads [N] of the contacts of a set that carry."""
    balls = result.sets[i].balls
    if balls is None:
        raise AssertionError("the set has balls")
    return np.asarray(balls.load[balls.load > 0.0])
