"""What a scene file may not describe: contradictory choices, and bodies that cannot be built."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from compare.scenes.catalogue_input import ball_total
from compare.scenes.keys import MAX_BALLS, GrooveKeys
from compare.scenes.schema import BallKeys, SceneKeys
from lowfi.statics.supports import Held, contradiction, show
from meshes.errors import specimen
from meshes.helix import ball_layout, lead_angle
from meshes.partition import MERGE
from meshes.parts import SIDES, Scene
from meshes.section import volume_ratio

Array = NDArray[np.float64]

#: Lengths that differ by less than this [m] count as equal.
TOLERANCE = 1e-9
#: Random ball errors are refused if this many standard deviations would make a ball as large as its groove.
SIGMAS = 6.0
#: Largest groove radius, in ball radii: beyond it a groove guides no ball.
WIDEST = 10.0


@dataclass(frozen=True)
class Fault:
    """One fault: the keys it may be blamed on (the first one that the file has is named), and what to say.

    ``value`` is left empty where the text found in the file says it best.
    """

    keys: tuple[str, ...]
    allowed: str
    advice: str
    value: str = ""


def mm(length: float) -> str:
    """A length [m] for a message: in mm, or in um below 0.1 mm."""
    return f"{length * 1e6:.6g} um" if 0.0 < abs(length) < 1e-4 else f"{length * 1e3:.7g} mm"


def choice_faults(keys: SceneKeys) -> Iterator[Fault]:
    """Faults that show before geometry is built: keys that exclude or need each other, counts, supports."""
    from compare.scenes.catalogue_faults import catalogue_faults

    for part in ("screw", "nut", "balls"):
        yield from _material_faults(keys, part)
    yield from _kind_faults(keys)
    yield from groove_choice_faults(keys.screw, "screw")
    yield from groove_choice_faults(keys.nut, "nut")
    yield from _ball_choice_faults(keys)
    yield from _support_faults(keys)
    if keys.motion is not None and keys.motion.speed == 0.0:
        advice = "friction at rest may have any value up to its limit: give the speed at which the part turns"
        yield Fault(("motion.speed",), "any angular speed but zero", advice)
    yield from _circuit_choice_faults(keys)
    yield from catalogue_faults(keys)


def _circuit_choice_faults(keys: SceneKeys) -> Iterator[Fault]:
    found, time = keys.circulation, keys.time
    if found is not None:
        if keys.track.lead == 0.0:
            advice = "the balls of a bearing go round its one turn: leave the table out"
            yield Fault(("circulation",), "a lead above 0 mm", advice, "a bearing with [circulation]")
        if found.gap is not None and found.filling is not None:
            allowed, advice = "either gap or filling", "they say the same: leave one out"
            yield Fault(("circulation.gap",), allowed, advice, "both")
    if time is not None and time.steps is not None and time.steps % 4:
        advice = f"the run is repeated with half and a quarter of its steps: write e.g. steps = {4 * round(time.steps / 4)}"
        yield Fault(("time.steps",), "a multiple of 4", advice)
    if time is not None and (time.angle is None) == (time.duration is None):
        value = "neither" if time.angle is None else "both"
        advice = 'write angle = "360 deg", or duration = "1 s"'
        yield Fault(("time.angle", "time"), "either angle or duration", advice, value)


def _kind_faults(keys: SceneKeys) -> Iterator[Fault]:
    found = "bearing" if keys.track.lead == 0.0 else "ball screw"
    if keys.kind not in (None, found):
        advice = f"a lead {'of zero' if keys.track.lead == 0.0 else 'above zero'} is a {found}: mend kind or track.lead"
        yield Fault(("kind",), f'"{found}" with this lead', advice)


def groove_choice_faults(groove: GrooveKeys, table: str) -> Iterator[Fault]:
    """A groove must be given in one of two ways; ``table`` is where it stands in the file."""
    if (groove.groove_radius is None) == (groove.conformity is None):
        found = "neither" if groove.conformity is None else "both"
        advice = "groove radius = conformity x ball diameter: give one and leave out the other"
        yield Fault((f"{table}.groove_radius",), "one of groove_radius and conformity", advice, found)


def _material_faults(keys: SceneKeys, part: str) -> Iterator[Fault]:
    own = getattr(keys, part).material
    for name, unit in (("youngs_modulus", '"210 GPa"'), ("poissons_ratio", "0.28")):
        if getattr(own, name, None) is None and getattr(keys.material, name) is None:
            where = f"{part}.material.{name}"
            advice = f"write {name} = {unit} under [material] for all parts, or in {part}.material"
            yield Fault((where,), "a value here or under [material]", advice, "nothing")


def _ball_choice_faults(keys: SceneKeys) -> Iterator[Fault]:
    balls, starts, ring = keys.balls, keys.track.starts, keys.track.lead == 0.0
    if ring and starts > 1:
        advice = "a bearing has one row: set starts = 1, or give a lead"
        yield Fault(("track.starts",), "1 for zero lead", advice)
    if balls.azimuths is not None and any(x is not None for x in (balls.count, balls.turns, balls.arcs)):
        advice = "leave out azimuths, or count with turns or arcs"
        yield Fault(("balls.azimuths",), "either azimuths, or count with turns", advice, "both")
        return
    if balls.azimuths is None and balls.count is None and balls.filling is None:
        advice = "write count and turns for balls spread evenly, or azimuths to list them"
        yield Fault(("balls.count",), "either azimuths, or count with turns", advice, "nothing")
        return
    if balls.arcs is not None:
        yield from _arc_faults(balls)
    elif balls.azimuths is None and balls.turns is None and not ring:
        advice = "write the number of turns that the balls of one start fill, e.g. turns = 2"
        yield Fault(("balls.turns",), "above 0", advice, "nothing")
    if ring and balls.turns is not None and balls.turns > 1.0:
        advice = "a bearing has one turn: leave turns out"
        yield Fault(("balls.turns",), "above 0, up to 1 for zero lead", advice)
    shares = starts * balls.circuits
    if balls.count is not None and balls.count % shares:
        near = max(shares, round(balls.count / shares) * shares)
        what = f"the {starts} starts" if balls.circuits == 1 else f"the {shares} circuits"
        advice = f"every {'start' if balls.circuits == 1 else 'circuit'} has as many balls: write e.g. count = {near}"
        yield Fault(("balls.count",), f"a multiple of {what}", advice)
    total = ball_total(balls, keys.track) if balls.azimuths is None else len(balls.azimuths) * starts
    yield from _listed_faults(keys, total)


def _arc_faults(balls: BallKeys) -> Iterator[Fault]:
    """Angle ranges that are empty, out of order, or given beside turns."""
    ends = [end for arc in balls.arcs or [] for end in arc]
    if balls.turns is not None:
        yield Fault(("balls.arcs",), "either turns or arcs", "arcs say how far the balls go: leave out turns", "both")
    elif any(b <= a for a, b in itertools.pairwise(ends)):
        advice = 'write them in order, e.g. arcs = [["-900 deg", "-180 deg"], ["180 deg", "900 deg"]]'
        yield Fault(("balls.arcs",), "ranges with growing ends that do not overlap", advice)


def _listed_faults(keys: SceneKeys, total: int) -> Iterator[Fault]:
    if total > MAX_BALLS:
        allowed = f"at most {MAX_BALLS} balls"
        yield Fault(("balls.azimuths",), allowed, "list fewer azimuths", f"{total} balls")
    seen: set[int] = set()
    for text in keys.errors.balls.listed:
        where = (f"errors.balls.listed.{text}",)
        whole = text.isascii() and text.isdecimal() and len(text) <= 9
        if not whole or not 1 <= int(text) <= total:
            advice = f"balls are numbered from 1 to {total}, all balls of start 1 first"
            yield Fault(where, f"a ball number from 1 to {total}", advice, f"ball {text}")
        elif int(text) in seen:
            advice = f"ball {int(text)} is listed twice: keep one"
            yield Fault(where, "each ball once", advice, f"ball {text}")
        else:
            seen.add(int(text))


def _support_faults(keys: SceneKeys) -> Iterator[Fault]:
    taken: list[tuple[float, str, str]] = []
    for i, support in enumerate(keys.supports):
        given: list[tuple[str, str]] = [(name, f"supports[{i}].fix") for name in support.fix]
        moved = support.displace.model_dump(exclude_none=True)
        given += [(name, f"supports[{i}].displace.{name}") for name in moved]
        if not given:
            advice = 'write fix = ["ux", ...] or displace = { ux = "0 mm" }, or delete the support'
            yield Fault((f"supports[{i}].fix",), "at least one of ux, uy, uz, rx, ry, rz", advice, "no freedom")
        for name, where in given:
            for at, other, first in taken:
                if other == name and abs(at - support.at) <= MERGE * (1.0 + TOLERANCE):
                    advice = f"{name} at {mm(at)} is already held by {first}: keep one of the two"
                    allowed = f"each freedom once per station (stations up to {mm(MERGE)} apart are one)"
                    yield Fault((where,), allowed, advice, f'"{name}" twice')
                    break
            else:
                taken.append((support.at, name, where))


def ball_radii(scene: Scene) -> Array:
    """Radii of all balls [m] with oversize and listed errors, not random ones; shape ``(n,)``, by starts."""
    radii = np.full(scene.ball_count, scene.balls.radius + scene.errors.balls.oversize)
    for number, error in scene.errors.balls.listed:
        radii[number - 1] += error
    return radii


def geometry_faults(scene: Scene) -> Iterator[Fault]:
    """Bodies that cannot be built, in the order in which a reader would mend them."""
    radii = ball_radii(scene)
    small = np.flatnonzero(radii <= 0.0)
    if small.size:
        allowed = f"above -{mm(scene.balls.radius)} in all"
        value = f"{mm(float(radii[small[0]]))} as the radius of ball {small[0] + 1}"
        listed = f"errors.balls.listed.{small[0] + 1}"
        yield Fault((listed, "errors.balls.oversize"), allowed, "a ball must keep a positive radius", value)
    largest = float(radii.max())
    yield from _groove_faults(scene, largest)
    yield from _path_error_faults(scene)
    yield from _section_faults(scene)
    yield from _station_faults(scene)
    yield from _rigid_faults(scene)
    yield from _solid_faults(scene)
    if scene.track.pitch_radius > scene.balls.radius:
        yield from _packing_faults(scene, radii)
    if scene.circulation is not None or scene.time is not None:
        yield from _circuit_faults(scene)


def _path_error_faults(scene: Scene) -> Iterator[Fault]:
    """Errors of pitch and roundness that are larger than a ball."""
    for side in SIDES:
        for kind in ("pitch", "roundness"):
            terms = getattr(scene.errors.side(side), kind)
            size = sum(math.hypot(t.sin, t.cos) + SIGMAS * t.sigma for t in terms)
            if size > scene.balls.radius:
                allowed = f"up to {mm(scene.balls.radius)}, the ball radius, in all ({SIGMAS:g} sigma of random ones)"
                value = f"{kind} errors of {mm(size)}"
                yield Fault((f"errors.{side}.{kind}",), allowed, "check the unit: such errors are micrometres", value)


def contact_faults(scene: Scene) -> Iterator[Fault]:
    """Contacts without Hertz constants, for bodies that can be built: ball and flank conform, or the printed formula has no
    solution."""
    from lowfi.statics.conformity import curvature_changes
    from lowfi.statics.problem import nominal_curvatures, printed_constants

    if scene.ingredients.hertz == "as printed":
        try:
            with np.errstate(invalid="ignore"):
                printed_constants(scene)
        except ValueError as error:
            advice = f"the printed formula (Lin Table B.1) has no solution for these radii ({error})"
            yield Fault(("ingredients.hertz",), '"nominal", "error-free" or "actual" for this geometry', advice)
        return
    drawn = specimen(scene, ball_layout(scene))
    curvature = nominal_curvatures(scene) + curvature_changes(scene, drawn, drawn.ball_radius)
    bad = np.argwhere(~(curvature.min(axis=-1) > 0.0) | ~np.isfinite(curvature).all(axis=-1))
    if bad.size:
        ball, side = (int(k) for k in bad[0])
        across, along = curvature[ball, side]
        allowed = "a groove that is less curved than the ball in every contact"
        value = (
            f"relative curvatures {across:.3g} 1/m across and {along:.3g} 1/m along flank {SIDES[side]} at ball {ball + 1}"
        )
        advice = "ball and flank conform there: lower the profile error's curvature, or enlarge the groove radius"
        part = "screw" if side < 2 else "nut"
        keys = (f"errors.{SIDES[side]}.profile", f"errors.{SIDES[side]}.profile_sigma", f"{part}.groove_radius")
        yield Fault((*keys, f"{part}.conformity"), allowed, advice, value)


def _circuit_faults(scene: Scene) -> Iterator[Fault]:
    """Circuits that cannot be built, and runs that leave the screw."""
    from lowfi.friction.whole.circuit import CircuitError, circuits, travel

    try:
        circuits(scene)
    except CircuitError as error:
        yield Fault(
            (f"circulation.{error.key}", "circulation", "balls.count", "balls.azimuths"), error.allowed, error.advice
        )
    ends = travel(scene) + scene.nut.position
    half, length = 0.5 * scene.nut.length, scene.screw.length
    if ends.min() < half - TOLERANCE or ends.max() > length - half + TOLERANCE:
        allowed = f"the nut on the screw, its centre from {mm(half)} to {mm(length - half)}"
        advice = f"it would run from {mm(float(ends[0]))} to {mm(float(ends[1]))}: shorten the run or lengthen the screw"
        yield Fault(("time.angle", "time.duration"), allowed, advice)


def _groove_faults(scene: Scene, largest: float) -> Iterator[Fault]:
    spread = SIGMAS * scene.errors.balls.sigma
    diameter = 2.0 * scene.balls.radius
    for name, radius in (("screw", scene.screw.groove_radius), ("nut", scene.nut.groove_radius)):
        where = (f"{name}.conformity", f"{name}.groove_radius")
        if radius <= largest:
            allowed = f"groove radius above {mm(largest)} (conformity above {largest / diameter:.6g})"
            advice = "the ball would jam: its radius with oversize and listed errors must be below the groove's"
            yield Fault(where, allowed, advice)
        elif radius <= largest + spread:
            allowed = f"below {mm((radius - largest) / SIGMAS)} with this groove"
            advice = f"a ball {SIGMAS:g} sigma too large would jam in the groove of {mm(radius)}"
            yield Fault(("errors.balls.sigma",), allowed, advice)
        elif radius > WIDEST * scene.balls.radius:
            allowed = f"groove radius up to {mm(WIDEST * scene.balls.radius)} ({WIDEST:g} ball radii)"
            yield Fault(where, allowed, "check the unit: a groove is usually 1.02 to 1.2 ball radii")
        else:
            yield from _profile_faults(scene, name[0].upper(), radius - largest)


def _profile_faults(scene: Scene, part: str, room: float) -> Iterator[Fault]:
    gamma = np.linspace(0.0, math.pi / 2.0, 91)
    for side in (s for s in SIDES if s[0] == part):
        profile = scene.errors.side(side).profile
        inward = float(np.polynomial.polynomial.polyval(gamma, profile or (0.0,)).max())
        if inward >= room:
            allowed = f"an inward offset below {mm(room)} for gamma from 0 to 90 deg"
            advice = "the ball would jam: the groove's profile error leaves it no room"
            yield Fault((f"errors.{side}.profile",), allowed, advice, f"an offset of {mm(inward)}")


def _section_faults(scene: Scene) -> Iterator[Fault]:
    pitch, ball = scene.track.pitch_radius, scene.balls.radius
    if pitch <= ball:
        advice = "the balls would reach the axis: enlarge the pitch radius or use smaller balls"
        yield Fault(("track.pitch_radius",), f"above the ball radius, {mm(ball)}", advice)
        return
    low, high = 2.0 * (pitch - ball), 2.0 * (pitch + ball)
    between = f"above {mm(low)}, below {mm(high)}"
    if not low < scene.screw.outer_diameter < high:
        advice = "the screw's surface must pass through the balls, or there is no groove"
        yield Fault(("screw.outer_diameter",), f"{between} (twice pitch radius -/+ ball radius)", advice)
    if scene.screw.bore >= low:
        yield Fault(("screw.bore",), f"below the root diameter, {mm(low)}", "leave material under the groove")
    if scene.nut.outer_diameter <= high:
        advice = "the nut must enclose the balls: check diameter against radius"
        yield Fault(("nut.outer_diameter",), f"above {mm(high)} (twice pitch radius + ball radius)", advice)
    if low < scene.screw.outer_diameter < high and scene.screw.bore < low:
        yield from _beam_faults(scene)


def _beam_faults(scene: Scene) -> Iterator[Fault]:
    """A beam needs material left in its section (Lin C.6-C.8)."""
    if scene.ingredients.screw == "rigid":
        return
    ratio = volume_ratio(scene)
    if ratio <= 0.0:
        advice = 'the groove leaves no screw: enlarge lead or pitch radius, or take screw = "rigid"'
        yield Fault(("track.lead",), "more screw than groove per turn", advice)
        return
    factor = {"groove": math.sqrt(ratio), "groove squared": ratio, "full": 1.0}[scene.ingredients.section]
    if scene.screw.bore >= factor * scene.screw.outer_diameter:
        allowed = f"below {mm(factor * scene.screw.outer_diameter)}, the diameter reduced by the groove"
        yield Fault(("screw.bore",), allowed, 'use a smaller bore, or section = "full" under [ingredients]')


def _station_faults(scene: Scene) -> Iterator[Fault]:
    length, nut = scene.screw.length, scene.nut
    ends = (nut.position - nut.length / 2.0, nut.position + nut.length / 2.0)
    if ends[0] < -TOLERANCE or ends[1] > length + TOLERANCE:
        if nut.length > length:
            allowed = f"up to {mm(length)}, the screw's length"
            yield Fault(("nut.length",), allowed, "shorten the nut or lengthen the screw")
        else:
            allowed = f"{mm(nut.length / 2.0)} to {mm(length - nut.length / 2.0)}"
            advice = f"the nut, {mm(ends[0])} to {mm(ends[1])}, must lie on the screw, 0 mm to {mm(length)}"
            yield Fault(("nut.position",), allowed, advice)
    stations = [(f"supports[{i}].at", s.at) for i, s in enumerate(scene.supports)]
    stations += [(f"loads[{i}].at", p.at) for i, p in enumerate(scene.loads)]
    for where, at in stations:
        if at > length + TOLERANCE:
            advice = "stations are measured from the screw's left end and must lie on the screw"
            yield Fault((where,), f"0 mm to {mm(length)}", advice)


def _rigid_faults(scene: Scene) -> Iterator[Fault]:
    """Supports that no motion of a rigid screw can meet together."""
    if scene.ingredients.screw != "rigid":
        return
    clash = contradiction(scene)
    if clash is None:
        return
    held, others = clash.held, ", ".join(f"{x.freedom} of supports[{x.support}]" for x in clash.by)
    where = f"supports[{held.support}]"
    advice = f'the screw is rigid, and {others} leave no other value: mend one, or take screw = "beam"'
    value = f"{held.freedom} = {show(held)} at {mm(scene.supports[held.support].at)}"
    allowed = show(Held(held.support, held.freedom, clash.implied))
    yield Fault((f"{where}.displace.{held.freedom}", f"{where}.fix"), allowed, advice, value)


def _solid_faults(scene: Scene) -> Iterator[Fault]:
    """Dimensions that only the 3D reference needs, where the scene gives them."""
    solid, R = scene.solid, scene.track.pitch_radius
    if solid.nut_inner_diameter is not None:
        most = min(2.0 * (R + scene.nut.groove_radius), scene.nut.outer_diameter)
        if not 2.0 * R < solid.nut_inner_diameter < most:
            advice = "the lands lie outside the pitch cylinder and must leave a groove and a wall"
            yield Fault(("solid.nut_inner_diameter",), f"above {mm(2.0 * R)}, below {mm(most)}", advice)
    if solid.hole_diameter is not None:
        most = 2.0 * (R - scene.screw.groove_radius)
        if not scene.screw.bore <= solid.hole_diameter < most:
            advice = "the hole holds the bore and must leave a wall under the groove"
            yield Fault(("solid.hole_diameter",), f"from {mm(scene.screw.bore)}, below {mm(most)}", advice)
    if solid.screw_held == "bore" and scene.screw.bore <= 0.0:
        yield Fault(("solid.screw_held",), '"ends" for a screw without bore', 'give screw.bore, or write "ends"')


def _packing_faults(scene: Scene, radii: Array) -> Iterator[Fault]:
    track, nut = scene.track, scene.nut
    centres = ball_layout(scene).centre
    where = ("balls.azimuths", "balls.count")
    outside = np.flatnonzero(np.abs(centres[:, 2] - nut.position) > nut.length / 2.0 + TOLERANCE)
    if outside.size:
        first = int(outside[0])
        ends = (nut.position - nut.length / 2.0, nut.position + nut.length / 2.0)
        allowed = f"{mm(ends[0])} to {mm(ends[1])}, inside the nut"
        advice = "lengthen the nut, or fill fewer turns"
        value = f"ball {first + 1} at z = {mm(float(centres[first, 2]))}"
        yield Fault(("balls.azimuths", "balls.turns"), allowed, advice, value)
    span = max(scene.balls.azimuths) - min(scene.balls.azimuths)
    slope = math.cos(lead_angle(track))
    gap = track.lead / track.starts * slope
    if track.lead > 0.0 and (track.starts > 1 or span > 2.0 * math.pi) and gap <= 2.0 * radii.max():
        allowed = f"above {mm(2.0 * float(radii.max()) * track.starts / slope)} with these balls"
        advice = "the balls of neighbouring turns would overlap: enlarge the lead or use smaller balls"
        yield Fault(("track.lead",), allowed, advice)
        return
    pair = overlapping(centres, radii)
    if pair is not None:
        i, j = pair
        apart = float(np.linalg.norm(centres[i] - centres[j]))
        value = f"balls {i + 1} and {j + 1} overlapping, centres {mm(apart)} apart"
        allowed = f"at least {mm(float(radii[i] + radii[j]))} between centres"
        yield Fault(where, allowed, "use fewer or smaller balls, or spread them over more turns", value)


def overlapping(centres: Array, radii: Array) -> tuple[int, int] | None:
    """Indices of a pair of overlapping balls (that of the lowest index), or None.

    ``centres`` [m], shape ``(n, 3)``; ``radii`` [m], shape ``(n,)``; touching balls do not overlap.
    """
    if len(radii) < 2:
        return None
    from scipy.spatial import cKDTree

    tree = cKDTree(centres)
    distance, neighbour = tree.query(centres, k=2)
    # A ball may be its own second neighbour where centres coincide.
    other = np.where(neighbour[:, 1] == np.arange(len(radii)), neighbour[:, 0], neighbour[:, 1])
    bad = np.flatnonzero(distance[:, 1] < radii + radii[other] - TOLERANCE)
    if bad.size:
        i, j = int(bad[0]), int(other[bad[0]])
        return min(i, j), max(i, j)
    # Unequal balls: the nearest one need not be the one that is overlapped. Few pairs are left to look at.
    pairs = tree.query_pairs(2.0 * float(radii.max()), output_type="ndarray")
    gaps = np.linalg.norm(centres[pairs[:, 0]] - centres[pairs[:, 1]], axis=1) - radii[pairs].sum(axis=1)
    bad = np.flatnonzero(gaps < -TOLERANCE)
    if not bad.size:
        return None
    i, j = min((int(a), int(b)) for a, b in pairs[bad])
    return i, j
