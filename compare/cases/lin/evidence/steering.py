"""Section 4.2 of Lin's thesis: lash tests of a ball screw; contact loads of ball screw and bearing in a steering gear."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache, partial
from itertools import product
from typing import TypeVar

import numpy as np

from rollbench.compare.evidence import ComputedEntryValues
from rollbench.compare.measure import error_percent
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.results.load_curve import LoadCurve, compute_load_curve, read_load_range
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.statics.result import AxisResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import BallErrors, Errors, Scene, Support
from rollbench.reports.content import Row

#: Axial loads of the axial lash test: first, last and number of loads. The lateral loads of the conical test are not
#: printed and are assumed to be the same.
ENDS = "-200N:200N:2"
#: Length of the loaded track of Table 4.1 [turns]; directions of the lateral force [rad], each also reversed.
TURNS, DIRECTIONS = 3.75, np.radians([0.0, 45.0, 90.0, 135.0])
#: Motions that are restrained at the screw's left end: rotation about its axis only.
TURNING = ("rz",)
#: Patterns of balls in Lin's Figure 4.2, with the scene of each.
PATTERNS = {
    "evenly distributed": "lin-lash-even",
    "stacked on one end": "lin-lash-one-end",
    "stacked on one side": "lin-lash-one-side",
    "half-half": "lin-lash-half-half",
}


def arrange_balls_in_pattern(scene: Scene, pattern: str) -> Scene:
    """Return a copy of the screw with its balls in a pattern of Lin's Figure 4.2; ``pattern``: one of `PATTERNS`."""
    balls = catalogue.scene(PATTERNS[pattern]).balls
    return replace(scene, balls=replace(scene.balls, azimuths=balls.azimuths))


def solve_axial_lash_test(scene: Scene, loads: str = ENDS, restrained: Sequence[str] = TURNING) -> LoadCurve:
    """Solve the axial lash test of a ball screw: axial displacement over an axial load that reverses.

    Parameters
    ----------
    scene
        The screw.
    loads
        Axial loads at the screw's left end: first, last and number of loads, such as "-200N:200N:2".
    restrained
        Displacements and rotations that are restrained at the left end, such as "rz" (rotation about the axis).
    """
    return _solve_lash_test(scene, f"{loads}:0mm", restrained)


def solve_conical_lash_test(
    scene: Scene, direction: float, force_distance: float, loads: str = ENDS, restrained: Sequence[str] = TURNING
) -> LoadCurve:
    """Solve the conical lash test of a ball screw: lateral displacement over a lateral load that reverses.

    Parameters
    ----------
    scene
        The screw.
    direction
        Direction of the lateral load: angle about the screw's axis from x [rad].
    force_distance
        Axial distance [m] by which the load acts to the right of the nut's centre.
    loads
        Lateral loads: first, last and number of loads, such as "-200N:200N:2".
    restrained
        Displacements and rotations that are restrained at the left end, such as "rz" (rotation about the axis).
    """
    return _solve_lash_test(scene, f"{loads}:{direction!r}rad:{scene.nut.position + force_distance!r}m", restrained)


def _solve_lash_test(scene: Scene, load_range: str, restrained: Sequence[str]) -> LoadCurve:
    """Return the load curve of a lash test: displacement over a force that reverses.

    ``scene``: the ball screw; ``load_range``: range of the loads, direction and position of the force, in the form of
    ``rollbench solve --curve``; ``restrained``: displacements and rotations that are restrained at the screw's left end,
    such as "rz" (rotation about the axis).
    """
    scene = replace(scene, supports=(Support(0.0, tuple((name, 0.0) for name in restrained)),))
    return compute_load_curve(scene, read_load_range(load_range), "lin", ModelOptions())


def peak_to_peak_displacement(test: LoadCurve) -> float:
    """Return the lash of a ball screw [m]: its displacement between both ends of the load range of a lash test.

    ``test``: load curve of the test. Raises ValueError if there is no equilibrium at an end of the load range.
    """
    if test.peak_to_peak is None:
        raise ValueError(f"scene {test.scene}: no equilibrium at the first or last load of the lash test")
    return test.peak_to_peak


def relative_range_percent(values: list[float]) -> float:
    """Return the relative range (largest - smallest)/smallest [%] of a screw's lash over the four patterns of its balls.

    ``values``: lash for each pattern, in any unit. Lin does not define his relative difference of the lash. Of several
    definitions, this one comes nearest to the axial difference that he prints.
    """
    return float(error_percent(max(values), min(values)))


def relative_lash_differences(
    scene: Scene, force_distance: float, restrained: Sequence[str] = TURNING
) -> tuple[float, tuple[float, ...]]:
    """Return the relative differences [%] of a ball screw's lash between its ball patterns.

    First: in the axial test; second: in the conical test (lateral force), for each direction of the force in `DIRECTIONS`.
    ``scene``: the ball screw; ``force_distance``: distance of the lateral force from the nut's centre [m]; ``restrained``:
    displacements and rotations that are restrained at the screw's left end, such as "rz" (rotation about the axis).
    """
    screws = [arrange_balls_in_pattern(scene, p) for p in PATTERNS]
    tests = [[solve_axial_lash_test(s, restrained=restrained) for s in screws]]
    for direction in DIRECTIONS:
        solve = partial(solve_conical_lash_test, direction=float(direction), force_distance=force_distance)
        tests.append([solve(s, restrained=restrained) for s in screws])
    axial, *conical = (relative_range_percent([*map(peak_to_peak_displacement, of)]) for of in tests)
    return axial, tuple(conical)


# --- lash tests of a ball screw; contact loads of bearing and ball screw in a steering gear


#: Names of the scenes of ball screw and steering gear; total rack force [N], distance of the lateral force of the conical
#: lash test from the nut's centre [m].
SCREW, RACK = "lin-lash-even", "lin-steering-rack"
RACK_FORCE, REACH = 14500.0, 0.3
#: Both parts of the steering gear with contact loads, in words, by the ends of the keys of their printed load ratios.
PARTS = {"screw": "ball screw", "bearing": "bearing"}
#: Angles between tie rods and rack [deg] at which the contact loads are computed.
TIE_ROD = (0.0, 6.0, 12.0, 18.0)


def shipped_steering_gear() -> Assembly:
    """Return the scene, included with rollbench, of Lin's steering gear: a rack with ball screw and bearing."""
    return catalogue.shipped_scene_of_kind(RACK, Assembly)


def solve_gear_at_tie_rod_angle(gear: Assembly, angle: float, *, side_forces_opposed: bool = False) -> AxisResult:
    """Solve the steering gear under half of the rack force at each end of the rack, at one angle of both tie rods.

    ``angle``: angle between tie rod and rack [deg]; ``side_forces_opposed``: whether the lateral forces of both tie rods
    have opposite directions.
    """
    t = np.radians(angle)
    sides = (1.0, -1.0 if side_forces_opposed else 1.0)
    forces = [(side * 0.5 * RACK_FORCE * float(np.sin(t)), 0.0, 0.5 * RACK_FORCE * float(np.cos(t))) for side in sides]
    loads = tuple(replace(x, force=f) for x, f in zip(gear.loads, forces, strict=True))
    return run_model(replace(gear, loads=loads), "lin", ModelOptions())


def largest_screw_and_bearing_loads(result: AxisResult) -> tuple[float, float]:
    """Return the largest contact load [N] of the steering gear's ball screw, then that of its bearing.

    ``result``: solution of the steering gear. The load is zero if no contact loads were computed for the ball screw or the
    bearing.
    """
    screw, bearing = (0.0 if s.balls is None else float(s.balls.load.max()) for s in result.sets)
    return screw, bearing


def load_ratios_at_18_degrees(gear: Assembly, *, side_forces_opposed: bool = False) -> tuple[float, float]:
    """Return the load ratio of the steering gear's ball screw, then that of its bearing, for tie-rod angles 18 and 0 deg.

    A load ratio is the largest contact load at 18 deg divided by its value at 0 deg. ``gear``: the steering gear;
    ``side_forces_opposed``: whether the lateral forces of both tie rods have opposite directions.
    """
    low, high = (
        largest_screw_and_bearing_loads(solve_gear_at_tie_rod_angle(gear, 0.0)),
        largest_screw_and_bearing_loads(solve_gear_at_tie_rod_angle(gear, 18.0, side_forces_opposed=side_forces_opposed)),
    )
    return high[0] / low[0], high[1] / low[1]


def section_4_2(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Compute lash and contact loads of the steering gear: Table 4.1, sections 4.2.1 and 4.2.2 of Lin's thesis.

    ``findings``: receives the computed value to compare with each printed number, and whether each printed claim holds;
    ``cache``: gives the scenes included with rollbench.
    """
    scene = cache.built_in_scene(SCREW)
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
    findings.numbers(given)
    _compute_lash(findings, cache)
    _compute_load_ratios(findings)


def _compute_lash(findings: ComputedEntryValues, cache: SceneResultCache) -> None:
    """Compute the relative differences of lash between ball patterns: section 4.2.1 of Lin's thesis.

    ``cache``: gives the scenes included with rollbench; ``findings``: receives the results.
    """
    axial, conical = relative_lash_differences(cache.built_in_scene(SCREW), REACH)
    by_direction = ", ".join(f"{x:.1f}" for x in conical)
    words = f"lateral force at {1e3 * REACH:.0f} mm; by direction {by_direction} %"
    findings.add_number("axial", axial, "screw kept from turning only")
    findings.add_number("conical", max(conical), words)
    words = f"{axial:.1f} % against {by_direction} %"
    findings.add_claim("robust", axial < min(conical), words)


def _compute_load_ratios(findings: ComputedEntryValues) -> None:
    """Compute contact loads of the steering gear's ball screw and bearing at several tie-rod angles: Lin's section 4.2.2.

    ``findings``: receives the results.
    """
    gear = shipped_steering_gear()
    results = [solve_gear_at_tie_rod_angle(gear, angle) for angle in TIE_ROD]
    loads = np.array([largest_screw_and_bearing_loads(r) for r in results])
    bands = load_ratio_ranges(gear)
    for k, key in enumerate(PARTS):
        printed = findings.printed(f"ratio_{key}")
        by_input = "; ".join(f"{name} {_load_ratio_range_in_words(band[k], printed)}" for (name, _), band in bands.items())
        words = f"over what is not printed, one at a time: {by_input}"
        findings.add_number(f"ratio_{key}", float(loads[-1, k] / loads[0, k]), words)
    over = ", ".join(f"{a:.0f} and {b:.0f} N at {t:.0f} deg" for (a, b), t in zip(loads, TIE_ROD, strict=True))
    findings.add_claim("grows", bool(np.all(np.diff(loads, axis=0) > 0.0)), f"ball screw and bearing {over}")
    even, ring = (_nonzero_contact_loads(results[0], i) for i in range(2))
    findings.add_claim("even_bearing", bool(ring.min() > 0.8 * ring.max()), f"{ring.min():.0f} to {ring.max():.0f} N")
    tilted = _nonzero_contact_loads(results[-1], 0)
    low, high = (float(x / even.mean()) for x in (even.min(), even.max()))
    words = (
        f"{even.min():.0f} to {even.max():.0f} N, {low:.2f} to {high:.2f} of the mean, scatter "
        f"{100.0 * even.std() / even.mean():.0f} %; at 18 deg up to {tilted.max() / tilted.mean():.2f} of it"
    )
    findings.add_claim("even_screw", bool(even.min() > 0.8 * even.max()), words)


def _load_ratio_range_in_words(band: tuple[float, float], printed: float) -> str:
    """Return in words the range of a load ratio, and whether it contains the printed value; ``band``: its two ends."""
    return f"{band[0]:.2f} to {band[1]:.2f} ({'holds' if rounded_value_lies_in_range(band, printed) else 'without'} it)"


def rounded_value_lies_in_range(band: tuple[float, float], printed: float) -> bool:
    """Return whether a range contains a printed value that is rounded to two decimals; ``band``: both ends of the range."""
    return band[0] - 0.005 <= printed <= band[1] + 0.005


def _nonzero_contact_loads(result: AxisResult, part: int) -> Array:
    """Return the nonzero contact loads [N] of the steering gear's ball screw (``part`` 0) or its bearing (``part`` 1)."""
    balls = result.sets[part].balls
    assert balls is not None
    return np.asarray(balls.load[balls.load > 0.0])


# --- influence of inputs that Lin does not print: on the lash of 4.2.1, on the load ratios of 4.2.2


#: Outer diameters [m], distances of the lateral force from the nut [m], restraints of the screw's left end.
DIAMETERS, REACHES = (26e-3, 28e-3, 30e-3), (0.1, 0.2, 0.3, 0.5)
RESTRAINTS = {
    "turning only": TURNING,
    "guided across": ("ux", "uy", "rz"),
    "clamped but for its axis": ("ux", "uy", "rx", "ry", "rz"),
}
#: Axial positions of the pinion [m], its restraints, offsets of bearing from nut centre [m], tie-rod angles [deg].
PINIONS = (0.35, 0.45, 0.55, 0.65, 0.75)
PINION_HOLDS = {"held but along the rack": ("ux", "uy", "rx", "ry", "rz"), "pinned across": ("ux", "uy", "rz")}
OFFSETS, ANGLES = (-0.02, 0.0, 0.02), (0.0, 3.0, 6.0, 9.0, 12.0, 15.0, 18.0)


def lash_difference_rows(scene: Scene) -> Iterator[Row]:
    """Yield table rows of the lash differences between ball patterns, one input changed at a time that Lin does not print.

    The first row has the inputs of ``scene``. The lateral force stays on the longer side of the screw.
    """
    usual = scene.screw.outer_diameter, scene.nut.position, REACH, "turning only"
    cases = [("as taken", usual)]
    cases += [("outer diameter", (d, *usual[1:])) for d in DIAMETERS if d != usual[0]]
    cases += [("position of the nut", (usual[0], 0.5 * scene.screw.length, *usual[2:]))]
    cases += [("distance of the lateral force", (*usual[:2], x, usual[3])) for x in REACHES if x != usual[2]]
    cases += [("restraint", (*usual[:3], name)) for name in RESTRAINTS if name != usual[3]]
    for changed, (diameter, position, reach, restraint) in cases:
        screw, nut = replace(scene.screw, outer_diameter=diameter), replace(scene.nut, position=position)
        axial, conical = relative_lash_differences(replace(scene, screw=screw, nut=nut), reach, RESTRAINTS[restraint])
        yield {
            "varied_input": changed,
            "screw_diameter": 1e3 * diameter,
            "nut_position": 1e3 * position,
            "lateral_force_distance": 1e3 * reach,
            "left_end_restraint": restraint,
            "axial_lash_difference": axial,
            "smallest_conical_lash_difference": min(conical),
            "largest_conical_lash_difference": max(conical),
            "directions_with_smaller_axial": f"{sum(axial < x for x in conical)} of {len(conical)} directions",
        }


def change_gear_layout(gear: Assembly, pinion: float, pinion_restraint: str, offset: float) -> Assembly:
    """Return a copy of the steering gear with another layout of pinion and bearing.

    ``pinion``: axial position of the pinion [m]; ``pinion_restraint``: what the pinion restrains, a key of `PINION_HOLDS`;
    ``offset``: axial distance [m] by which the bearing is moved from the nut's centre.
    """
    (support,) = gear.supports
    held = replace(support, at=pinion, fixed=tuple((name, 0.0) for name in PINION_HOLDS[pinion_restraint]))
    sets = []
    for s in gear.sets:
        at = s.position + offset
        if s.carrier is not None and isinstance(s.parts, Scene):
            s = replace(s, position=at, parts=replace(s.parts, nut=replace(s.parts.nut, position=at)))
        sets.append(s)
    return replace(gear, supports=(held,), sets=tuple(sets))


def load_ratio_rows(gear: Assembly) -> list[Row]:
    """Return table rows of the steering gear's load ratios for every layout: largest contact load at 18 deg over that at 0.

    The angles are those of the tie rods. A layout has a position and a restraint of the pinion, directions of both lateral
    forces, and an offset of the bearing. If the pinion restrains tilting of the rack, the lateral force of the tie rod
    beyond the pinion does not reach the nut, and only one direction of this force is solved.
    """
    rows: list[Row] = []
    for hold in PINION_HOLDS:
        for opposed in (False, True)[: 1 if "rx" in PINION_HOLDS[hold] else 2]:
            for offset, pinion in product(OFFSETS, PINIONS):
                layout = change_gear_layout(gear, pinion, hold, offset)
                screw, bearing = load_ratios_at_18_degrees(layout, side_forces_opposed=opposed)
                rows.append(
                    {
                        "pinion_restraint": hold,
                        "lateral_force_directions": "opposed" if opposed else "alike",
                        "bearing_distance": 1e3 * offset,
                        "pinion_position": 1e3 * pinion,
                        ("load_ratio_18_deg", "ball screw"): screw,
                        ("load_ratio_18_deg", "bearing"): bearing,
                    }
                )
    return rows


#: Smallest and largest load ratio of the ball screw, then of the bearing, over the range of an input. A load ratio is the
#: largest contact load at a tie-rod angle of 18 deg over that at 0 deg.
Ranges = tuple[tuple[float, float], ...]

#: Oversizes of the ball radius in bearing and screw [m]; azimuths of the bearing's first ball [deg], within a pitch of 40.
BEARING_FITS, SCREW_FITS, FIRST = (-10e-6, -5e-6, 0.0, 2e-6), (-5e-6, 0.0, 5e-6), (0.0, 10.0, 20.0, 30.0)


def _change_screw_or_bearing(gear: Assembly, of_nut: bool, change: Callable[[Scene], Scene]) -> Assembly:
    """Return a copy of the steering gear in which either the ball screw or the bearing is changed.

    ``of_nut``: True: the ball screw is changed; False: the bearing; ``change``: function that returns the changed ball
    screw or bearing.
    """
    sets = tuple(
        replace(s, parts=change(s.parts)) if isinstance(s.parts, Scene) and (s.parts.track.lead > 0.0) == of_nut else s
        for s in gear.sets
    )
    return replace(gear, sets=sets)


def _enlarge_balls(scene: Scene, excess: float) -> Scene:
    """Return a copy of the scene with all ball radii enlarged by ``excess`` [m]."""
    return replace(scene, errors=Errors(balls=BallErrors(oversize=excess)))


Parts = TypeVar("Parts", Scene, Assembly)


def _set_outer_diameter(scene: Parts, diameter: float) -> Parts:
    """Return a copy of the scene with the outer diameter ``diameter`` [m] of the screw."""
    return replace(scene, screw=replace(scene.screw, outer_diameter=diameter))


def _rotate_balls_about_axis(scene: Scene, angle: float) -> Scene:
    """Return a copy of the scene with all balls rotated about the screw's axis by ``angle`` [deg]."""
    azimuths = tuple(a + float(np.radians(angle)) for a in scene.balls.azimuths)
    return replace(scene, balls=replace(scene.balls, azimuths=azimuths))


def gears_with_unprinted_inputs_varied(gear: Assembly) -> Iterator[tuple[tuple[str, str], list[tuple[Assembly, bool]]]]:
    """Yield each input that Lin does not print and that changes the steering gear's load ratios, with gears over its range.

    Each entry: name of the input, with its range in words; list of pairs: the gear, and whether the lateral forces of both
    tie rods have opposite directions.
    """
    (pinion,), (held, pinned) = gear.supports, PINION_HOLDS

    bearing, screw = (partial(_change_screw_or_bearing, gear, of_nut) for of_nut in (False, True))
    across = change_gear_layout(gear, pinion.at, pinned, 0.0)
    thick = [(_set_outer_diameter(gear, d), partial(_set_outer_diameter, diameter=d)) for d in DIAMETERS]
    inputs: dict[tuple[str, str], list[Assembly]] = {
        ("axial position of the pinion", "350 to 750 mm"): [change_gear_layout(gear, z, held, 0.0) for z in PINIONS],
        ("restraint by the pinion, directions of the lateral forces", f"{held}; {pinned}, alike or opposed"): [
            gear,
            across,
        ],
        ("distance of the bearing from the nut's centre", "-20 to 20 mm"): [
            change_gear_layout(gear, pinion.at, held, x) for x in OFFSETS
        ],
        ("outer diameter of the rack", "26 to 30 mm"): [
            _change_screw_or_bearing(one, True, set_it) for one, set_it in thick
        ],
        ("oversize of the bearing's ball radius", "-10 to 2 um"): [
            bearing(partial(_enlarge_balls, excess=x)) for x in BEARING_FITS
        ],
        ("oversize of the screw's ball radius", "-5 to 5 um"): [
            screw(partial(_enlarge_balls, excess=x)) for x in SCREW_FITS
        ],
        ("azimuth of the bearing's first ball", "0 to 30 deg from the lateral force"): [
            bearing(partial(_rotate_balls_about_axis, angle=x)) for x in FIRST
        ],
        ("pattern of the screw's balls", ", ".join(PATTERNS)): [
            screw(partial(arrange_balls_in_pattern, pattern=p)) for p in PATTERNS
        ],
    }
    for name, gears in inputs.items():  # opposed forces differ only where the pinion lets the rack tilt
        yield name, [*((one, False) for one in gears), *([(across, True)] if across in gears else [])]


@cache
def load_ratio_ranges(gear: Assembly) -> dict[tuple[str, str], Ranges]:
    """Return the ranges of the steering gear's load ratios over inputs that Lin does not print, one varied at a time.

    The keys are the name of the input and its range in words. ``gear``: the steering gear with the usual inputs.
    """
    out = {}
    for name, gears in gears_with_unprinted_inputs_varied(gear):
        ratios = [load_ratios_at_18_degrees(one, side_forces_opposed=opposed) for one, opposed in gears]
        out[name] = tuple((min(of), max(of)) for of in zip(*ratios, strict=True))
    return out
