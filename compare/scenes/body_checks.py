"""Checks of a scene's geometry: bodies that cannot be built, and contacts whose Hertz constants do not exist."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator

import numpy as np

from rollbench.compare.scenes.fault import TOLERANCE, Fault, length_text
from rollbench.lowfi.statics.problem import PrescribedMotion, describe_prescribed_value, find_support_contradiction
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import are_in_shifted_half, ball_radii_without_random_errors, draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.numerics import pairs_of_close_points
from rollbench.meshes.parts import SIDES, Errors, Flange, Nut, Scene, Solid, UnfitKey, Washers
from rollbench.meshes.section import grooved_volume_ratio
from rollbench.meshes.solid import largest_groove_depths
from rollbench.meshes.washers import THRUST_ABOVE, has_washers, washer_of_ring

#: A ball whose random radius error is this many standard deviations must still be smaller than its groove.
SIGMAS = 6.0
#: Smallest difference of outer and inner diameter of the annulus by which a flange is fixed [m].
SMALLEST_WIDTH = 1e-4
#: Largest groove radius over ball radius; a larger one does not guide a ball.
WIDEST_GROOVE = 10.0


def geometry_faults(scene: Scene) -> Iterator[Fault]:
    """Yield the faults of dimensions with which a scene cannot be built, in the order in which to correct them."""
    radii = ball_radii_without_random_errors(scene)
    small = np.flatnonzero(radii <= 0.0)
    if small.size:
        allowed = f"oversize and listed error whose sum is above -{length_text(scene.balls.radius)}"
        value = f"{length_text(float(radii[small[0]]))} as the radius of ball {small[0] + 1}"
        listed = f"errors.balls.listed.{small[0] + 1}"
        yield Fault((listed, "errors.balls.oversize"), allowed, "check the unit: a ball needs a positive radius", value)
    largest = float(radii.max())
    yield from _groove_width_faults(scene, largest)
    if scene.errors != Errors(scene.errors.seed, scene.errors.balls):
        yield from _path_error_faults(scene)
    yield from _diameter_faults(scene)
    yield from _position_beyond_screw_faults(scene)
    if scene.ingredients.screw == "rigid":
        yield from _rigid_screw_support_faults(scene)
    if min(scene.screw.groove_radius, scene.nut.groove_radius) > scene.balls.radius:  # otherwise no groove has a depth
        if scene.track.lead == 0.0 or scene.track.washers != Washers():
            yield from _washer_faults(scene)
        if scene.solid != Solid():
            yield from _solid_table_faults(scene)
    if scene.nut.flange is not None:
        yield from _flange_faults(scene.nut, scene.nut.flange)
    if scene.track.pitch_radius > scene.balls.radius:
        yield from _ball_position_faults(scene, radii)
    if scene.circulation is not None or scene.time is not None:
        yield from _ball_circuit_faults(scene)


def _path_error_faults(scene: Scene) -> Iterator[Fault]:
    """Yield the faults of pitch and roundness errors (larger than the ball radius) and of the lead offset."""
    radius = scene.balls.radius
    allowed = f"a sum up to {length_text(radius)}, the ball radius (random errors count {SIGMAS:g} sigma)"
    for side, kind in itertools.product(SIDES, ("pitch", "roundness")):
        terms = getattr(scene.errors.side(side), kind)
        size = sum(math.hypot(t.sin, t.cos) + SIGMAS * t.sigma for t in terms)
        if size > radius:
            value = f"{kind} errors of {length_text(size)}"
            yield Fault((f"errors.{side}.{kind}",), allowed, "check the unit: such errors are some um", value)
    if scene.errors.lead_offset:
        yield from _lead_offset_faults(scene)


def _lead_offset_faults(scene: Scene) -> Iterator[Fault]:
    """Yield the faults of a nut's lead offset: above the ball radius, or with all balls on one side of the nut's centre."""
    where, radius, offset = ("preload.lead_offset",), scene.balls.radius, scene.errors.lead_offset
    beyond = are_in_shifted_half(scene, ball_layout(scene).z)
    if abs(offset) > radius:
        allowed, advice = f"up to {length_text(radius)}, the ball radius", "check the unit: offsets are some um"
        yield Fault(where, allowed, advice, length_text(offset))
    if beyond.all() or not beyond.any():
        advice = "leave lead_offset out, or fill turns on both sides: it shifts one half of the nut's groove along the axis"
        yield Fault(where, "only with balls on both sides of the nut's centre", advice, length_text(offset))


def printed_hertz_constant_faults(scene: Scene) -> Iterator[Fault]:
    """Yield the fault that the formula of Lin's Table B.1, which the scene selects, has no solution."""
    from rollbench.lowfi.statics.contacts import misprinted_hertz_of_flanks

    try:
        with np.errstate(invalid="ignore"):
            misprinted_hertz_of_flanks(scene)
    except ValueError as error:
        advice = f"choose one of these: the printed formula (Lin Table B.1) has no solution for these radii ({error})"
        yield Fault(("ingredients.hertz",), '"nominal", "error-free" or "actual" for this geometry', advice)


def hertz_constant_faults(scene: Scene) -> Iterator[Fault]:
    """Yield the faults of contacts without Hertz constants, as the flank is at least as strongly curved as the ball."""
    from rollbench.lowfi.statics.contacts import curvature_changes, nominal_curvatures

    drawn = draw_geometry_with_errors(scene, ball_layout(scene))
    curvature = nominal_curvatures(scene) + curvature_changes(scene, drawn, drawn.ball_radii)
    bad = np.argwhere(~(curvature.min(axis=-1) > 0.0) | ~np.isfinite(curvature).all(axis=-1))
    if bad.size:
        ball, side = (int(k) for k in bad[0])
        across, along = curvature[ball, side]
        allowed = "a groove that is less curved than the ball in every contact"
        place = f"flank {SIDES[side]} at ball {ball + 1}"
        value = f"relative curvatures {across:.3g} 1/m across and {along:.3g} 1/m along {place}"
        advice = "lower the curvature of the profile error, or enlarge the groove radius: ball and flank conform there"
        part = "screw" if side < 2 else "nut"
        keys = (f"errors.{SIDES[side]}.profile", f"errors.{SIDES[side]}.profile_sigma", f"{part}.groove_radius")
        yield Fault((*keys, f"{part}.conformity"), allowed, advice, value)


def _groove_width_faults(scene: Scene, largest_ball_radius: float) -> Iterator[Fault]:
    """Yield the faults of groove radii (too small for the largest ball, or far too large) and of profile errors.

    ``largest_ball_radius``: radius of the largest ball, without random errors [m].
    """
    spread = SIGMAS * scene.errors.balls.sigma
    diameter = 2.0 * scene.balls.radius
    largest, widest = largest_ball_radius, WIDEST_GROOVE * scene.balls.radius
    for name, radius in (("screw", scene.screw.groove_radius), ("nut", scene.nut.groove_radius)):
        where = (f"{name}.conformity", f"{name}.groove_radius")
        if radius <= largest:
            allowed = f"a groove radius above {length_text(largest)} (conformity above {largest / diameter:.6g})"
            advice = "enlarge the groove: the ball would jam, as its radius with oversize and listed errors is not smaller"
            yield Fault(where, allowed, advice)
        elif radius <= largest + spread:
            groove = f"the groove of radius {length_text(radius)}"
            advice = f"check the unit: a ball {SIGMAS:g} sigma too large would jam in {groove}"
            allowed = f"below {length_text((radius - largest) / SIGMAS)} with this groove"
            yield Fault(("errors.balls.sigma",), allowed, advice)
        elif radius > widest:
            allowed = f"a groove radius up to {length_text(widest)} ({WIDEST_GROOVE:g} ball radii)"
            yield Fault(where, allowed, "check the unit: a groove is usually 1.02 to 1.2 ball radii")
        else:
            for side in (s for s in SIDES if s[0] == name[0].upper() and getattr(scene.errors, s).profile):
                yield from _profile_error_faults(scene, side, radius - largest)


def _profile_error_faults(scene: Scene, side: str, clearance: float) -> Iterator[Fault]:
    """Yield the fault of a flank's profile error that is larger than groove radius minus ball radius, so that balls jam.

    ``side``: name of the flank; ``clearance``: groove radius minus radius of the largest ball [m].
    """
    gamma = np.linspace(0.0, math.pi / 2.0, 91)
    inward = float(np.polynomial.polynomial.polyval(gamma, scene.errors.side(side).profile).max())
    if inward >= clearance:
        allowed = f"an inward offset below {length_text(clearance)} at every angle gamma from 0 to 90 deg"
        advice = "check the unit: the ball would jam, as the groove's profile error leaves no clearance"
        yield Fault((f"errors.{side}.profile",), allowed, advice, f"an inward offset of {length_text(inward)}")


def _diameter_faults(scene: Scene) -> Iterator[Fault]:
    """Yield the faults of diameters: the screw's surface must cut the balls, and the nut must enclose them."""
    pitch, ball = scene.track.pitch_radius, scene.balls.radius
    if pitch <= ball:
        reach = f"balls of diameter {length_text(2.0 * ball)} would reach the axis"
        advice = f"check the ball diameter and its unit, or enlarge the pitch diameter: {reach}"
        yield Fault(("track.pitch_radius",), f"above the ball radius, {length_text(ball)}", advice)
        return
    low, high = 2.0 * (pitch - ball), 2.0 * (pitch + ball)
    if not low < scene.screw.outer_diameter < high:
        advice = "check the diameter: the screw's surface must cut the balls, otherwise the screw has no groove"
        allowed = f"above {length_text(low)}, below {length_text(high)} (pitch diameter -/+ ball diameter)"
        yield Fault(("screw.outer_diameter",), allowed, advice)
    if scene.screw.bore >= low:
        yield Fault(("screw.bore",), f"below the root diameter, {length_text(low)}", "leave material under the groove")
    if scene.nut.outer_diameter <= high:
        advice = "check that this is a diameter, not a radius: the nut must enclose the balls"
        yield Fault(("nut.outer_diameter",), f"above {length_text(high)} (pitch diameter + ball diameter)", advice)
    # the beam's cross-section, reduced for the groove after Lin (2019), eqs. (C.6) to (C.8), needs material
    beam = scene.ingredients.screw != "rigid" and scene.screw.groove_radius > scene.balls.radius  # else told already
    if not (beam and low < scene.screw.outer_diameter < high and scene.screw.bore < low):
        return
    ratio = grooved_volume_ratio(scene)
    if ratio <= 0.0:
        advice = 'enlarge lead or pitch radius, or write screw = "rigid" under [ingredients]: the groove leaves no material'
        yield Fault(("track.lead",), "a lead at which one turn of the groove has less volume than the screw", advice)
        return
    factor = {"groove": math.sqrt(ratio), "groove squared": ratio, "full": 1.0}[scene.ingredients.section]
    if scene.screw.bore >= factor * scene.screw.outer_diameter:
        allowed = f"below {length_text(factor * scene.screw.outer_diameter)}, the diameter reduced by the groove"
        yield Fault(("screw.bore",), allowed, 'choose a smaller bore, or write section = "full" under [ingredients]')


def _position_beyond_screw_faults(scene: Scene) -> Iterator[Fault]:
    """Yield the faults of positions of nut, supports and loads beyond the ends of the screw."""
    length, nut = scene.screw.length, scene.nut
    ends = (nut.position - nut.length / 2.0, nut.position + nut.length / 2.0)
    if ends[0] < -TOLERANCE or ends[1] > length + TOLERANCE:
        if nut.length > length:
            allowed = f"up to {length_text(length)}, the screw's length"
            yield Fault(("nut.length",), allowed, "shorten the nut or lengthen the screw")
        else:
            allowed = f"{length_text(nut.length / 2.0)} to {length_text(length - nut.length / 2.0)}"
            present = f"{length_text(ends[0])} to {length_text(ends[1])}"
            advice = f"move the nut, {present}, so that it lies on the screw, 0 mm to {length_text(length)}"
            yield Fault(("nut.position",), allowed, advice)
    stations = [(f"supports[{i}].at", s.at) for i, s in enumerate(scene.supports)]
    stations += [(f"loads[{i}].at", p.at) for i, p in enumerate(scene.loads)]
    yield from position_beyond_end_faults(stations, length, "screw")


def position_beyond_end_faults(stations: Iterable[tuple[str, float]], length: float, part: str) -> Iterator[Fault]:
    """Yield a fault for each position beyond the right end of a screw or shaft.

    ``stations``: keys of the file, each with the axial position that it states [m]; ``length``: length of the screw or
    shaft [m]; ``part``: its name in messages, "screw" or "shaft".
    """
    for where, at in stations:
        if at > length + TOLERANCE:
            advice = f"check the position, which is measured from the {part}'s left end, or lengthen the {part}"
            yield Fault((where,), f"0 mm to {length_text(length)}, the {part}'s length", advice)


def _rigid_screw_support_faults(scene: Scene) -> Iterator[Fault]:
    """Yield a fault if no rigid-body motion of a rigid screw fits the prescribed displacements of all its supports."""
    clash = find_support_contradiction(scene)
    if clash is None:
        return
    held, others = clash.contradicted, ", ".join(f"{x.freedom} of supports[{x.support_index}]" for x in clash.implied_by)
    where = f"supports[{held.support_index}]"
    advice = f'correct one of the supports, or write screw = "beam": for a rigid screw, {others} determine this value'
    value = f"{held.freedom} = {describe_prescribed_value(held)} at {length_text(scene.supports[held.support_index].at)}"
    allowed = describe_prescribed_value(PrescribedMotion(held.support_index, held.freedom, clash.implied))
    yield Fault((f"{where}.displace.{held.freedom}", f"{where}.fix"), allowed, advice, value)


def _washer_faults(scene: Scene) -> Iterator[Fault]:
    """Yield the faults of the washers' dimensions, or the fault that a screw or a radial bearing has no washers."""
    try:
        washers = has_washers(scene)
    except ValueError:  # the ring's land does not cut its groove, which is told as a fault of its diameter
        return
    if washers:
        for inner in (True, False):
            try:
                washer_of_ring(scene, inner)
            except UnfitKey as error:
                yield Fault((error.key,), str(error), "check that diameters are not radii, and the depth of the groove")
                return
    elif scene.track.washers != Washers():
        allowed = f'only for a bearing, lead = "0 mm", with a contact angle above {THRUST_ABOVE:g} deg'
        yield Fault(("track.washers",), allowed, "leave the dimensions of the washers out")


def _solid_table_faults(scene: Scene) -> Iterator[Fault]:
    """Yield the faults of the table ``[solid]``, the dimensions that only the 3D finite-element model uses."""
    solid, R = scene.solid, scene.track.pitch_radius
    if solid.nut_inner_diameter is not None:
        most = min(2.0 * (R + largest_groove_depths(scene)[1]), scene.nut.outer_diameter)
        if not 2.0 * R < solid.nut_inner_diameter < most:
            advice = "check the diameter: the nut's lands lie outside the pitch cylinder and leave a groove and a wall"
            yield Fault(("solid.nut_inner_diameter",), f"above {length_text(2.0 * R)}, below {length_text(most)}", advice)
    if solid.hole_diameter is not None:
        most = 2.0 * (R - largest_groove_depths(scene)[0])
        if not scene.screw.bore <= solid.hole_diameter < most:
            advice = "check the diameter: the hole is at least as wide as the bore and leaves a wall under the groove"
            allowed = f"from {length_text(scene.screw.bore)}, below {length_text(most)}"
            yield Fault(("solid.hole_diameter",), allowed, advice)
    if solid.screw_held == "bore" and scene.screw.bore <= 0.0:
        yield Fault(("solid.screw_held",), '"ends" for a screw without bore', 'give screw.bore, or write "ends"')


def _flange_faults(nut: Nut, flange: Flange) -> Iterator[Fault]:
    """Yield the faults of a nut's flange: not wider than the nut, longer than the nut, or fixed beyond its face."""
    if flange.diameter <= nut.outer_diameter + SMALLEST_WIDTH:
        advice = "check that this is a diameter, not a radius: a flange is wider than its nut"
        yield Fault(("nut.flange.diameter",), f"above {length_text(nut.outer_diameter + SMALLEST_WIDTH)}", advice)
        return
    if flange.thickness + flange.centring > nut.length - TOLERANCE:
        room = nut.length - (flange.thickness if flange.centring else 0.0)
        advice = "shorten flange or centring fit, or lengthen the nut: both lie within the nut's length"
        key = "nut.flange.centring" if flange.centring else "nut.flange.thickness"
        yield Fault((key,), f"below {length_text(room)}", advice)
    low, high = (2.0 * r for r in flange.seat)
    advice = "check the diameters of the fixed annulus: it lies on the flange's face"
    if not nut.outer_diameter - TOLERANCE <= low < flange.diameter - SMALLEST_WIDTH:
        allowed = f"{length_text(nut.outer_diameter)} to {length_text(flange.diameter - SMALLEST_WIDTH)}"
        yield Fault(("nut.held.inner_diameter", "nut.flange"), allowed, advice)
    elif not low + SMALLEST_WIDTH <= high <= flange.diameter + TOLERANCE:
        allowed = f"{length_text(low + SMALLEST_WIDTH)} to {length_text(flange.diameter)}"
        yield Fault(("nut.held.outer_diameter", "nut.flange"), allowed, advice)


def _ball_position_faults(scene: Scene, radii: Array) -> Iterator[Fault]:
    """Yield the faults of ball positions: outside the nut, or overlapping; ``radii``: radii of all balls ``(n,)`` [m]."""
    track, nut = scene.track, scene.nut
    centres = ball_layout(scene).centre
    where = ("balls.azimuths", "balls.count")
    outside = np.flatnonzero(np.abs(centres[:, 2] - nut.position) > nut.length / 2.0 + TOLERANCE)
    if outside.size:
        first = int(outside[0])
        ends = (nut.position - nut.length / 2.0, nut.position + nut.length / 2.0)
        allowed = f"{length_text(ends[0])} to {length_text(ends[1])}, inside the nut"
        advice = "lengthen the nut, or fill fewer turns"
        value = f"ball {first + 1} at z = {length_text(float(centres[first, 2]))}"
        yield Fault(("balls.azimuths", "balls.turns"), allowed, advice, value)
    span = max(scene.balls.azimuths) - min(scene.balls.azimuths)
    slope = math.cos(lead_angle(track))
    gap = track.lead / track.starts * slope
    if track.lead > 0.0 and (track.starts > 1 or span > 2.0 * math.pi) and gap <= 2.0 * radii.max():
        allowed = f"above {length_text(2.0 * float(radii.max()) * track.starts / slope)} with these balls"
        advice = "enlarge the lead or use smaller balls: those of neighbouring turns would overlap"
        yield Fault(("track.lead",), allowed, advice)
        return
    following = np.arange(len(radii) - 1)[:, None] + np.array([0, 1])
    for pairs in (following, None):  # neighbours first: if they overlap, there may be very many close pairs
        i, j = (pairs_of_close_points(centres, 2.0 * float(radii.max(initial=0.0))) if pairs is None else pairs).T
        apart, least = np.linalg.norm(centres[i] - centres[j], axis=1), radii[i] + radii[j]
        bad = np.flatnonzero(apart < least - TOLERANCE)
        if bad.size:
            k = bad[0]
            value = f"overlapping balls {i[k] + 1} and {j[k] + 1} with centres {length_text(float(apart[k]))} apart"
            allowed = f"centres at least {length_text(float(least[k]))} apart"
            yield Fault(where, allowed, "use fewer or smaller balls, or spread them over more turns", value)
            return


def _ball_circuit_faults(scene: Scene) -> Iterator[Fault]:
    """Yield the faults of ball circuits that are impossible, and of a simulation that moves the nut off the screw."""
    from rollbench.lowfi.friction.whole.circuit import CircuitError, circuits_of_scene, nut_positions_at_start_and_end

    try:
        circuits_of_scene(scene)
    except CircuitError as error:
        keys = (f"circulation.{error.key}", "circulation", "balls.count", "balls.azimuths")
        yield Fault(keys, error.allowed, error.advice)
    ends = nut_positions_at_start_and_end(scene) + scene.nut.position
    half, length = 0.5 * scene.nut.length, scene.screw.length
    if ends.min() < half - TOLERANCE or ends.max() > length - half + TOLERANCE:
        span = f"from {length_text(half)} to {length_text(length - half)}"
        allowed = f"a simulation with the nut's centre {span}, so that the nut is on the screw"
        path = f"the nut's centre would move from {length_text(float(ends[0]))} to {length_text(float(ends[1]))}"
        advice = f"shorten the simulation or lengthen the screw: {path}"
        yield Fault(("time.angle", "time.duration"), allowed, advice)
