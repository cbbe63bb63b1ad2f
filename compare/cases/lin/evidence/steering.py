"""Section 4.2: lash tests of a ball screw, sizing of bearing and ball screw in a steering gear, and what is not printed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import TypeVar

import numpy as np

from rollbench.compare.evidence import Findings
from rollbench.compare.measure import error_percent
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.models.study import Study
from rollbench.compare.results.load_curve import LoadCurve, load_curve, read_course
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.statics.result import AxisResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.helix import reduced_lead
from rollbench.meshes.parts import BallErrors, Errors, Scene, Support

#: Ends of the axial lash test; those of the conical one are not printed, and taken to be the same.
ENDS = "-200N:200N:2"
#: Loaded track of Table 4.1 [turns], and directions of the lateral force [rad]: each with its opposite.
TURNS, DIRECTIONS = 3.75, np.radians([0.0, 45.0, 90.0, 135.0])
#: Freedoms of the screw's left end that are held: turning only.
TURNING = ("rz",)
PATTERNS = ("evenly distributed", "stacked on one end", "stacked on one side", "half-half")


def ball_azimuths(scene: Scene, pattern: str) -> tuple[float, ...]:
    """Return the azimuths [rad] of the balls in a pattern of Figure 4.2; stacked balls touch one another.

    For "stacked on one side", every turn has its gap opposite the x axis, at an azimuth of pi.
    """
    n, track = scene.ball_count, scene.track
    full = 2.0 * np.pi * TURNS
    if pattern == "evenly distributed":
        return tuple(full * ((np.arange(n) + 0.5) / n - 0.5))
    step = 2.0 * scene.balls.radius * (1.0 + 1e-9) / float(np.hypot(track.pitch_radius, reduced_lead(track)))
    free = full - step * n
    at = -0.5 * full + step * (np.arange(n) + 0.5)
    if pattern == "stacked on one end":
        return tuple(at)
    if pattern == "half-half":
        return tuple(np.where(np.arange(n) < n // 2, at, at + free))
    gaps = np.pi * np.array([k for k in range(-9, 10, 2) if abs(k) < TURNS])
    wide = free / gaps.size
    out = at.copy()
    for gap in gaps:
        out = np.where(out > gap - 0.5 * wide, out + wide, out)
    return tuple(out)


def with_balls(scene: Scene, pattern: str) -> Scene:
    """Return the screw with its balls at the places of a pattern."""
    return replace(scene, balls=replace(scene.balls, azimuths=ball_azimuths(scene, pattern)))


def axial(scene: Scene, loads: str = ENDS, held: Sequence[str] = TURNING) -> LoadCurve:
    """Solve the axial test.

    Parameters
    ----------
    scene
        The screw.
    loads
        Axial loads at the screw's left end, as ``rollbench solve --curve`` takes them.
    held
        Fixed freedoms of the left end.
    """
    return _test(scene, f"{loads}:0mm", held)


def conical(scene: Scene, direction: float, reach: float, loads: str = ENDS, held: Sequence[str] = TURNING) -> LoadCurve:
    """Solve the conical test.

    Parameters
    ----------
    scene
        The screw.
    direction
        Direction of the lateral load [rad].
    reach
        Distance of the load to the right of the nut's centre [m].
    loads
        Loads, as ``rollbench solve --curve`` takes them.
    held
        Fixed freedoms of the left end.
    """
    return _test(scene, f"{loads}:{direction!r}rad:{scene.nut.position + reach!r}m", held)


def _test(scene: Scene, course: str, held: Sequence[str]) -> LoadCurve:
    """Return the load curve of a test with some freedoms of the left end fixed."""
    scene = replace(scene, supports=(Support(0.0, tuple((name, 0.0) for name in held)),))
    return load_curve(scene, read_course(course), "lin", Options(engine="compiled"))


def peak_to_peak(test: LoadCurve) -> float:
    """Return the displacement [m] between both ends of a lash test.

    Raises ValueError if an end has no equilibrium.
    """
    if test.peak_to_peak is None:
        raise ValueError(f"{test.scene}: no equilibrium at the ends of its lash test")
    return test.peak_to_peak


def difference(values: list[float]) -> float:
    """Return (largest - smallest) / smallest [%] over the patterns: the definition that fits the printed axial one best."""
    return float(error_percent(max(values), min(values)))


@dataclass(frozen=True)
class Lash:
    """Differences of the lash between ball patterns [%]: axial, and conical by direction of the force."""

    axial: float
    conical: tuple[float, ...]


def lash(scene: Scene, reach: float, held: Sequence[str] = TURNING) -> Lash:
    """Return the lash differences of both tests, with the lateral force at a distance [m] from the nut.

    ``held``: fixed freedoms of the screw's left end.
    """
    screws = [with_balls(scene, p) for p in PATTERNS]
    cones = [[peak_to_peak(conical(s, float(d), reach, held=held)) for s in screws] for d in DIRECTIONS]
    return Lash(difference([peak_to_peak(axial(s, held=held)) for s in screws]), tuple(map(difference, cones)))


# --- section 4.2: lash tests of a ball screw, sizing of bearing and ball screw in a steering gear


#: Shipped scenes, total rack force [N], distance of the lateral force of the conical lash test from the nut [m].
SCREW, RACK = "lin-nominal-4p1", "lin-steering-rack"
RACK_FORCE, REACH = 14500.0, 0.3
#: Tie-rod angles [deg].
TIE_ROD = (0.0, 6.0, 12.0, 18.0)


def rack() -> Assembly:
    """Return the shipped steering gear."""
    found = catalogue.shipped(RACK)
    if not isinstance(found, Assembly):
        raise AssertionError(f"{RACK} has several sets")
    return found


def at_angle(gear: Assembly, angle: float, *, opposed: bool = False) -> AxisResult:
    """Solve the gear with half of the rack force at each end, at a tie-rod angle [deg].

    ``opposed``: whether the side forces of the two ends oppose each other.
    """
    t = np.radians(angle)
    sides = (1.0, -1.0 if opposed else 1.0)
    forces = [(side * 0.5 * RACK_FORCE * float(np.sin(t)), 0.0, 0.5 * RACK_FORCE * float(np.cos(t))) for side in sides]
    loads = tuple(replace(x, force=f) for x, f in zip(gear.loads, forces, strict=True))
    return run_model(replace(gear, loads=loads), "lin", Options(engine="compiled"))


def largest_loads(result: AxisResult) -> tuple[float, float]:
    """Return the largest contact loads [N] of ball screw and bearing."""
    screw, bearing = (0.0 if s.balls is None else float(s.balls.load.max()) for s in result.sets)
    return screw, bearing


def ratios(gear: Assembly, *, opposed: bool = False) -> tuple[float, float]:
    """Return the largest loads at 18 deg over those at 0 deg, ball screw and bearing; opposed: see `at_angle`."""
    low, high = largest_loads(at_angle(gear, 0.0)), largest_loads(at_angle(gear, 18.0, opposed=opposed))
    return high[0] / low[0], high[1] / low[1]


def section_4_2(findings: Findings, study: Study) -> None:
    """Compute the entries of Table 4.1 and sections 4.2.1, 4.2.2."""
    scene = study.scene(SCREW)
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
    _lash(findings, study)
    _sizing(findings)


def _lash(findings: Findings, study: Study) -> None:
    """Compute the entries of the lash tests."""
    found = lash(study.scene(SCREW), REACH)
    by_direction = ", ".join(f"{x:.1f}" for x in found.conical)
    words = f"lateral force at {1e3 * REACH:.0f} mm; by direction {by_direction} %"
    findings.number("axial", found.axial, "screw kept from turning only")
    findings.number("conical", max(found.conical), words)
    findings.claim("robust", found.axial < min(found.conical), f"{found.axial:.1f} % against {by_direction} %")


def _sizing(findings: Findings) -> None:
    """Compute the entries of the sizing of ball screw and bearing."""
    gear = rack()
    results = [at_angle(gear, angle) for angle in TIE_ROD]
    loads = np.array([largest_loads(r) for r in results])
    bands = ratio_bands(gear)
    for k, key in enumerate(("screw", "bearing")):
        by_input = "; ".join(f"{b.changed} {_words(getattr(b, key), findings.printed(f'ratio_{key}'))}" for b in bands)
        findings.number(
            f"ratio_{key}", float(loads[-1, k] / loads[0, k]), f"over what is not printed, one at a time: {by_input}"
        )
    over = ", ".join(f"{a:.0f} and {b:.0f} N at {t:.0f} deg" for (a, b), t in zip(loads, TIE_ROD, strict=True))
    findings.claim("grows", bool(np.all(np.diff(loads, axis=0) > 0.0)), f"ball screw and bearing {over}")
    even, ring = (_loaded(results[0], i) for i in range(2))
    findings.claim("even_bearing", bool(ring.min() > 0.8 * ring.max()), f"{ring.min():.0f} to {ring.max():.0f} N")
    tilted = _loaded(results[-1], 0)
    low, high = (float(x / even.mean()) for x in (even.min(), even.max()))
    words = (
        f"{even.min():.0f} to {even.max():.0f} N, {low:.2f} to {high:.2f} of the mean, scatter "
        f"{100.0 * even.std() / even.mean():.0f} %; at 18 deg up to {tilted.max() / tilted.mean():.2f} of it"
    )
    findings.claim("even_screw", bool(even.min() > 0.8 * even.max()), words)


def _words(band: tuple[float, float], printed: float) -> str:
    """Return a range as text, with whether it contains the printed value."""
    return f"{band[0]:.2f} to {band[1]:.2f} ({'holds' if band_holds(band, printed) else 'without'} it)"


def band_holds(band: tuple[float, float], printed: float) -> bool:
    """Return whether a range contains a printed value that is rounded to two decimals."""
    return band[0] - 0.005 <= printed <= band[1] + 0.005


def _loaded(result: AxisResult, i: int) -> Array:
    """Return the nonzero contact loads [N] of one set of balls."""
    balls = result.sets[i].balls
    if balls is None:
        raise AssertionError("the set has balls")
    return np.asarray(balls.load[balls.load > 0.0])


# --- how the results of Lin 4.2 depend on what the source does not print: lash of 4.2.1, ratios of 4.2.2


#: Outer diameters [m], distances of the lateral force from the nut [m], restraints of the screw's left end.
DIAMETERS, REACHES = (26e-3, 28e-3, 30e-3), (0.1, 0.2, 0.3, 0.5)
RESTRAINTS = {
    "turning only": TURNING,
    "guided across": ("ux", "uy", "rz"),
    "clamped but for its axis": ("ux", "uy", "rx", "ry", "rz"),
}
#: Stations of the pinion [m], its restraints, offsets of the bearing from the nut's centre [m], angles [deg].
PINIONS = (0.35, 0.45, 0.55, 0.65, 0.75)
PINION_HOLDS = {"held but along the rack": ("ux", "uy", "rx", "ry", "rz"), "pinned across": ("ux", "uy", "rz")}
OFFSETS, ANGLES = (-0.02, 0.0, 0.02), (0.0, 3.0, 6.0, 9.0, 12.0, 15.0, 18.0)


@dataclass(frozen=True)
class LashPoint:
    """Inputs of the lash tests that the source leaves open, and the lash differences between patterns [%]."""

    changed: str
    diameter: float
    position: float
    reach: float
    restraint: str
    found: Lash


def lash_map(scene: Scene) -> Iterator[LashPoint]:
    """Yield the lash differences with one open input changed at a time.

    The lateral force stays on the longer side of the screw.
    """
    usual = scene.screw.outer_diameter, scene.nut.position, REACH, "turning only"
    cases = [("as taken", usual)]
    cases += [("outer diameter", (d, *usual[1:])) for d in DIAMETERS if d != usual[0]]
    cases += [("position of the nut", (usual[0], 0.5 * scene.screw.length, *usual[2:]))]
    cases += [("distance of the lateral force", (*usual[:2], x, usual[3])) for x in REACHES if x != usual[2]]
    cases += [("restraint", (*usual[:3], name)) for name in RESTRAINTS if name != usual[3]]
    for changed, (diameter, position, reach, restraint) in cases:
        screw, nut = replace(scene.screw, outer_diameter=diameter), replace(scene.nut, position=position)
        found = lash(replace(scene, screw=screw, nut=nut), reach, RESTRAINTS[restraint])
        yield LashPoint(changed, diameter, position, reach, restraint, found)


@dataclass(frozen=True)
class RatioPoint:
    """Layout of the steering gear, and largest loads at 18 deg over those at 0 deg of ball screw and bearing."""

    pinion: float
    hold: str
    opposed: bool
    offset: float
    screw: float
    bearing: float


def with_layout(gear: Assembly, pinion: float, hold: str, offset: float) -> Assembly:
    """Return the gear with another station of its pinion [m], restraint, and offset of its bearing from the nut [m]."""
    (support,) = gear.supports
    held = replace(support, at=pinion, fixed=tuple((name, 0.0) for name in PINION_HOLDS[hold]))
    sets = []
    for s in gear.sets:
        at = s.position + offset
        if s.carrier is not None and isinstance(s.parts, Scene):
            s = replace(s, position=at, parts=replace(s.parts, nut=replace(s.parts.nut, position=at)))
        sets.append(s)
    return replace(gear, supports=(held,), sets=tuple(sets))


def ratio_map(gear: Assembly) -> Iterator[RatioPoint]:
    """Yield the load ratios over pinion station, pinion restraint, sense of the side forces, and bearing offset.

    A pinion that holds the rack against tilting keeps the far end's side force from the nut, so that its sense does
    not matter.
    """
    for hold in PINION_HOLDS:
        for opposed in (False, True)[: 1 if "rx" in PINION_HOLDS[hold] else 2]:
            for offset in OFFSETS:
                for pinion in PINIONS:
                    layout = with_layout(gear, pinion, hold, offset)
                    yield RatioPoint(pinion, hold, opposed, offset, *ratios(layout, opposed=opposed))


@dataclass(frozen=True)
class RatioBand:
    """Range of the load ratios over one input that is not printed, with all else as in the shipped scene."""

    #: The input.
    changed: str
    #: Stated range of the input.
    values: str
    #: Smallest and largest ratio of the ball screw.
    screw: tuple[float, float]
    #: Smallest and largest ratio of the bearing.
    bearing: tuple[float, float]


#: Excess radii of the balls of bearing and screw [m], and places of the bearing's first ball [deg], over a pitch of 40 deg.
BEARING_FITS, SCREW_FITS, FIRST = (-10e-6, -5e-6, 0.0, 2e-6), (-5e-6, 0.0, 5e-6), (0.0, 10.0, 20.0, 30.0)


def _changed(gear: Assembly, of_nut: bool, change: Callable[[Scene], Scene]) -> Assembly:
    """Return the gear with its ball screw or its bearing changed."""
    sets = tuple(
        replace(s, parts=change(s.parts)) if isinstance(s.parts, Scene) and (s.parts.track.lead > 0.0) == of_nut else s
        for s in gear.sets
    )
    return replace(gear, sets=sets)


def _oversize(scene: Scene, excess: float) -> Scene:
    """Return the scene with all ball radii larger by an excess [m]."""
    return replace(scene, errors=Errors(balls=BallErrors(oversize=excess)))


Parts = TypeVar("Parts", Scene, Assembly)


def _thick(scene: Parts, diameter: float) -> Parts:
    """Return the scene with another outer diameter of its screw [m]."""
    return replace(scene, screw=replace(scene.screw, outer_diameter=diameter))


def _turned(scene: Scene, angle: float) -> Scene:
    """Return the scene with its balls moved on by an angle [deg]."""
    azimuths = tuple(a + float(np.radians(angle)) for a in scene.balls.azimuths)
    return replace(scene, balls=replace(scene.balls, azimuths=azimuths))


def open_inputs(gear: Assembly) -> Iterator[tuple[str, str, list[tuple[Assembly, bool]]]]:
    """Yield the inputs of the load ratios that are not printed: name, range, gears with ``opposed`` of `ratios`."""
    (pinion,), (held, pinned) = gear.supports, PINION_HOLDS
    yield "pinion's station", "350 to 750 mm", [(with_layout(gear, z, held, 0.0), False) for z in PINIONS]
    across = with_layout(gear, pinion.at, pinned, 0.0)
    yield (
        "pinion's restraint, sense of the side forces",
        f"{held}; {pinned}, alike or opposed",
        [*((gear, False), (across, False), (across, True))],
    )
    yield "bearing from the nut's centre", "-20 to 20 mm", [(with_layout(gear, pinion.at, held, x), False) for x in OFFSETS]
    yield (
        "outer diameter of the rack",
        "26 to 30 mm",
        [(_changed(_thick(gear, d), True, partial(_thick, diameter=d)), False) for d in DIAMETERS],
    )
    yield (
        "excess radius of the bearing's balls",
        "-10 to 2 um",
        [(_changed(gear, False, partial(_oversize, excess=x)), False) for x in BEARING_FITS],
    )
    yield (
        "excess radius of the screw's balls",
        "-5 to 5 um",
        [(_changed(gear, True, partial(_oversize, excess=x)), False) for x in SCREW_FITS],
    )
    yield (
        "first ball of the bearing",
        "0 to 30 deg from the side force",
        [(_changed(gear, False, partial(_turned, angle=x)), False) for x in FIRST],
    )
    yield (
        "places of the screw's balls",
        ", ".join(PATTERNS),
        [(_changed(gear, True, partial(with_balls, pattern=p)), False) for p in PATTERNS],
    )


@cache
def ratio_bands(gear: Assembly) -> tuple[RatioBand, ...]:
    """Return the range of the load ratios over each input that is not printed, one input varied at a time."""
    out = []
    for changed, values, gears in open_inputs(gear):
        screw, bearing = zip(*(ratios(one, opposed=opposed) for one, opposed in gears), strict=True)
        out.append(RatioBand(changed, values, (min(screw), max(screw)), (min(bearing), max(bearing))))
    return tuple(out)


def band_of(points: Sequence[RatioPoint]) -> RatioBand:
    """Return the range of the load ratios over all layouts of `ratio_map` together."""
    screw, bearing = [p.screw for p in points], [p.bearing for p in points]
    words = "station, restraint, sense and bearing, each with each"
    return RatioBand("layout as a whole", words, (min(screw), max(screw)), (min(bearing), max(bearing)))


def over_angles(gear: Assembly) -> list[tuple[float, float]]:
    """Return the largest contact loads [N] of ball screw and bearing at each of ``ANGLES``."""
    return [largest_loads(at_angle(gear, angle)) for angle in ANGLES]
