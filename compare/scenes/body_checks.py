"""Checks of a scene file: bodies that cannot be built, and contacts that cannot be solved."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from rollbench.compare.scenes.fault import TOLERANCE, Fault, mm
from rollbench.lowfi.statics.problem import Held, contradiction, show
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import beyond_step, specimen
from rollbench.meshes.helix import ball_layout, lead_angle
from rollbench.meshes.numerics import close_pairs
from rollbench.meshes.parts import SIDES, Flange, Nut, Scene
from rollbench.meshes.section import volume_ratio
from rollbench.meshes.solid import groove_depths

#: Number of standard deviations of random ball errors for which a ball must still be smaller than its groove.
SIGMAS = 6.0
#: Smallest difference of the diameters of a flange's annulus [m].
SEAT = 1e-4
#: Largest groove radius over ball radius; a larger one does not guide a ball.
WIDEST = 10.0


def ball_radii(scene: Scene) -> Array:
    """Return the radii of all balls with oversize and listed errors, without random ones, (n,) [m], start by start."""
    radii = np.full(scene.ball_count, scene.balls.radius + scene.errors.balls.oversize)
    for number, error in scene.errors.balls.listed:
        radii[number - 1] += error
    return radii


def geometry_faults(scene: Scene) -> Iterator[Fault]:
    """Yield faults of bodies that cannot be built, in the order in which a user would correct them."""
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
    if scene.nut.flange is not None:
        yield from _flange_faults(scene.nut, scene.nut.flange)
    if scene.track.pitch_radius > scene.balls.radius:
        yield from _packing_faults(scene, radii)
    if scene.circulation is not None or scene.time is not None:
        yield from _circuit_faults(scene)


def _path_error_faults(scene: Scene) -> Iterator[Fault]:
    """Yield faults of errors of pitch and roundness larger than a ball."""
    for side in SIDES:
        for kind in ("pitch", "roundness"):
            terms = getattr(scene.errors.side(side), kind)
            size = sum(math.hypot(t.sin, t.cos) + SIGMAS * t.sigma for t in terms)
            if size > scene.balls.radius:
                allowed = f"up to {mm(scene.balls.radius)}, the ball radius, in all ({SIGMAS:g} sigma of random ones)"
                value = f"{kind} errors of {mm(size)}"
                yield Fault((f"errors.{side}.{kind}",), allowed, "check the unit: such errors are micrometres", value)
    if scene.errors.lead_offset:
        yield from _lead_offset_faults(scene)


def _lead_offset_faults(scene: Scene) -> Iterator[Fault]:
    """Yield faults of a lead offset larger than a ball, or of a nut with all balls on one side."""
    where, radius, offset = ("preload.lead_offset",), scene.balls.radius, scene.errors.lead_offset
    beyond = beyond_step(scene, ball_layout(scene).z)
    if abs(offset) > radius:
        yield Fault(where, f"up to {mm(radius)}, the ball radius", "check the unit: offsets are micrometres", mm(offset))
    if beyond.all() or not beyond.any():
        yield Fault(where, "balls on both sides of the nut's centre", "it shifts one half against the other", mm(offset))


def contact_faults(scene: Scene) -> Iterator[Fault]:
    """Yield faults of contacts without Hertz constants, for bodies that can be built.

    Ball and flank conform, or the printed formula has no solution.
    """
    from rollbench.lowfi.statics.contacts import curvature_changes, nominal_curvatures, printed_sides

    if scene.ingredients.hertz == "as printed":
        try:
            with np.errstate(invalid="ignore"):
                printed_sides(scene)
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
            advice = "the ball would jam: the groove's profile error leaves no clearance"
            yield Fault((f"errors.{side}.profile",), allowed, advice, f"an offset of {mm(inward)}")


def _section_faults(scene: Scene) -> Iterator[Fault]:
    pitch, ball = scene.track.pitch_radius, scene.balls.radius
    if pitch <= ball:
        reach = f"balls of {mm(2.0 * ball)} would reach the axis"
        advice = f"{reach}: check their diameter and its unit, or enlarge the pitch diameter"
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
    """Yield faults of beams without material in their section (Lin C.6-C.8)."""
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
    """Yield faults of a nut, supports or loads beyond the screw's ends."""
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
    """Yield a fault of contradictory supports: no motion of the rigid screw satisfies them all."""
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
    """Yield faults of the table ``[solid]``, whose dimensions only the 3D reference uses."""
    solid, R = scene.solid, scene.track.pitch_radius
    of_screw, of_nut = groove_depths(scene)
    if solid.nut_inner_diameter is not None:
        most = min(2.0 * (R + of_nut), scene.nut.outer_diameter)
        if not 2.0 * R < solid.nut_inner_diameter < most:
            advice = "the lands lie outside the pitch cylinder and must leave a groove and a wall"
            yield Fault(("solid.nut_inner_diameter",), f"above {mm(2.0 * R)}, below {mm(most)}", advice)
    if solid.hole_diameter is not None:
        most = 2.0 * (R - of_screw)
        if not scene.screw.bore <= solid.hole_diameter < most:
            advice = "the hole holds the bore and must leave a wall under the groove"
            yield Fault(("solid.hole_diameter",), f"from {mm(scene.screw.bore)}, below {mm(most)}", advice)
    if solid.screw_held == "bore" and scene.screw.bore <= 0.0:
        yield Fault(("solid.screw_held",), '"ends" for a screw without bore', 'give screw.bore, or write "ends"')


def _flange_faults(nut: Nut, flange: Flange) -> Iterator[Fault]:
    """Yield faults of a flange smaller than the nut or longer than it, and of an annulus beyond its face."""
    if flange.diameter <= nut.outer_diameter + SEAT:
        advice = "a flange stands out from the nut: check diameter against radius"
        yield Fault(("nut.flange.diameter",), f"above {mm(nut.outer_diameter + SEAT)}", advice)
        return
    if flange.thickness + flange.centring > nut.length - TOLERANCE:
        room = nut.length - (flange.thickness if flange.centring else 0.0)
        advice = "flange and centring fit lie within the nut's length: shorten them or lengthen the nut"
        yield Fault(("nut.flange.centring" if flange.centring else "nut.flange.thickness",), f"below {mm(room)}", advice)
    low, high = (2.0 * r for r in flange.seat)
    if not nut.outer_diameter - TOLERANCE <= low < flange.diameter - SEAT:
        allowed = f"{mm(nut.outer_diameter)} to {mm(flange.diameter - SEAT)}"
        yield Fault(("nut.held.inner_diameter", "nut.flange"), allowed, "the annulus lies on the flange's face")
    elif not low + SEAT <= high <= flange.diameter + TOLERANCE:
        allowed = f"{mm(low + SEAT)} to {mm(flange.diameter)}"
        yield Fault(("nut.held.outer_diameter", "nut.flange"), allowed, "the annulus lies on the flange's face")


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
    """Return the indices of a pair of overlapping balls, the lower first, or None.

    Parameters
    ----------
    centres
        Ball centres, (n, 3) [m].
    radii
        Ball radii, (n,) [m]; touching balls do not overlap.
    """
    following = np.arange(len(radii) - 1)[:, None] + np.array([0, 1])
    for pairs in (following, None):  # of balls in a row first: where they overlap, there may be very many pairs
        i, j = (close_pairs(centres, 2.0 * float(radii.max(initial=0.0))) if pairs is None else pairs).T
        bad = np.flatnonzero(np.linalg.norm(centres[i] - centres[j], axis=1) < radii[i] + radii[j] - TOLERANCE)
        if bad.size:
            return int(i[bad[0]]), int(j[bad[0]])
    return None


def _circuit_faults(scene: Scene) -> Iterator[Fault]:
    """Yield faults of circuits that cannot be built, and runs that leave the screw."""
    from rollbench.lowfi.friction.whole.circuit import CircuitError, circuits, travel

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
