"""Compliance between contacts of bodies that are not in the cache, by finite elements in sections of the bodies.

A beam with the section constants of the grooved body, plus what a smooth body of revolution does beyond the same beam
theory, plus what grooves and faces add.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from rollbench.lowfi.compliance.beyond_hertz import NARROW, Flank, half_space
from rollbench.lowfi.compliance.faces import REACH, NearFace, motions_by_wrench, near_face, quarter_turn
from rollbench.lowfi.compliance.groove import RingCompliance, ring_compliance, ring_contacts
from rollbench.lowfi.compliance.parts import (
    BOTH,
    CLAMPED,
    REFINED,
    Backend,
    fixed_surface,
    geometry_only,
    groove_of_body,
    grooved_section,
    is_ring,
    nut_beam_ends,
    of_flanks,
    smooth_body,
)
from rollbench.lowfi.compliance.tube import (
    Tube,
    TubeCompliance,
    by_section,
    cantilever_compliance,
    clamped_beam_compliance,
    contact_compliance,
    end_springs,
    motion_rows,
    on_line,
    patch_weights,
    points_in_space,
    section_jump_compliance,
    spring_compliance,
    tube_compliance,
)
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import BallLayout, nominal_contact_points
from rollbench.meshes.kept import kept
from rollbench.meshes.parts import Scene
from rollbench.meshes.section import BeamSection
from rollbench.meshes.solid import dimensions

#: How far beyond the nut's faces the screw takes loads, over the patch's width: a contact near a face keeps its patch.
BESIDE = 2.5


def ball_axes(layout: BallLayout) -> Array:
    """Return the radial and binormal axes of every ball ``(N, 2, 3)``."""
    return np.stack([layout.radial, layout.binormal], axis=1)


def contact_frames(scene: Scene, layout: BallLayout, screw: bool, flanks: Sequence[int] = BOTH) -> tuple[Array, Array]:
    """Return nominal contact points ``(c, 3)`` [m] and section axes ``(c, 2, 3)`` of a body's flanks, of N balls each."""
    at = nominal_contact_points(scene)[:2] if screw else nominal_contact_points(scene)[2:]
    x = [layout.centre + at[s][0] * layout.radial + at[s][1] * layout.binormal for s in flanks]
    return np.concatenate(x), np.concatenate([ball_axes(layout)] * len(flanks))


@lru_cache(maxsize=32)
def smooth_compliance(geometry: Scene, screw: bool, backend: Backend) -> TubeCompliance:
    """Return the compliance of the smooth body over the stretch that the nut covers, cached by geometry."""
    tube = smooth_body(geometry, screw, backend)
    return of_tube(tube, stretch_zone(geometry, tube))


def stretch_zone(geometry: Scene, tube: Tube) -> tuple[float, float]:
    """Return the stretch [m] of a smooth body that contains every contact."""
    half = geometry.nut.length / 2.0 + BESIDE * tube.width
    return geometry.nut.position - half, geometry.nut.position + half


#: Kept for scenes whose other body differs.
of_tube, section_of_tube = lru_cache(maxsize=32)(tube_compliance), lru_cache(maxsize=32)(by_section)


@lru_cache(maxsize=32)
@kept(RingCompliance)
def whole_ring(geometry: Scene, screw: bool) -> RingCompliance:
    """Return the compliance of a ring with its groove, cached by geometry."""
    return ring_compliance(groove_of_body(geometry, screw), fixed_surface(geometry, screw))


def own_flank(geometry: Scene, screw: bool, backend: Backend) -> float:
    """Return e [m/N] of a contact on the true flank, for a narrow patch (`NearFace`)."""
    flank = groove_of_body(geometry, screw)
    if is_ring(geometry, screw):
        return whole_ring(geometry, screw).normals - half_space(NARROW * flank.map.ball, flank.material)
    tube = smooth_body(geometry, screw, backend)
    if not backend.flank:  # the half space at the smooth body's own patch only
        return -half_space(tube.width, tube.material)
    return kept_near_face(geometry, screw, backend).alone


def kernel_part(scene: Scene, layout: BallLayout, screw: bool, backend: Backend, flanks: Sequence[int] = BOTH) -> Array:
    """Return the compliance ``(2 c, 2 c)`` [m/N] that the smooth body has in addition to its beam."""
    geometry = geometry_only(scene)
    x, axes = contact_frames(scene, layout, screw, flanks)
    if float(np.abs(x[:, 2] - scene.nut.position).max()) > 0.5 * scene.nut.length:
        raise ValueError("a contact lies beyond the nut's faces: lengthen the nut or reduce the turns")
    smooth = smooth_compliance(geometry, screw, backend)
    G = contact_compliance(smooth, points_in_space(x, axes))
    tube = smooth.tube
    plain = tube.section
    x = on_line(tube, x)
    rows, stations = motion_rows(x, axes), np.repeat(x[:, 2], 2)
    if tube.held == "section":
        G = G - spring_compliance(tube, x, axes) - clamped_beam_compliance(rows, stations, tube.ends, "low", plain)
        if backend.flank:
            G = G + section_jump_compliance(
                strained_by_section(scene, layout, True, backend, flanks), rows, stations, tube.ends[0]
            )
    elif tube.held in CLAMPED:
        G = G - clamped_beam_compliance(rows, stations, *nut_beam_ends(tube), plain)
    return G


def strained_by_section(
    scene: Scene, layout: BallLayout, screw: bool, backend: Backend, flanks: Sequence[int] = BOTH
) -> Array:
    """Return the motions ``(2 c, 6)`` of contacts by a wrench on their sections, beyond those of the smooth body."""
    found = kept_near_face(geometry_only(scene), screw, backend)
    points = points_in_space(*contact_frames(scene, layout, screw, flanks))
    return motions_by_wrench(points, np.repeat([2.0 * side - 1.0 for side in flanks], layout.z.size), found.strains)


def nut_beam(scene: Scene, layout: BallLayout, flanks: Sequence[int] = BOTH, feel: Array | None = None) -> Array:
    """Return the compliance of the nut as a Timoshenko tube ``(2 c, 2 c)`` [m/N].

    Clamped at its faces, or at its flange; zero if its outside is fixed. feel: see `clamped_beam_compliance`.
    """
    geometry = geometry_only(scene)
    x, axes = contact_frames(scene, layout, False, flanks)
    if fixed_surface(geometry, False) not in CLAMPED:
        return np.zeros((2 * len(x),) * 2)
    section, tube = grooved_section(geometry, False), smooth_body(geometry, False, REFINED)
    return clamped_beam_compliance(motion_rows(x, axes), np.repeat(x[:, 2], 2), *nut_beam_ends(tube), section, feel)


@lru_cache(maxsize=32)
def kept_near_face(geometry: Scene, screw: bool, backend: Backend) -> NearFace:
    """Return the compliance added by grooves and faces of screw or nut between contacts of a turn, cached."""
    radii = (0.0, np.inf) if screw else dimensions(geometry).held_radii
    section, tube = grooved_section(geometry, screw), smooth_body(geometry, screw, backend)
    low, high = (abs(end - geometry.nut.position) - 0.5 * geometry.nut.length for end in tube.ends)
    near = min(low, high) < REACH * geometry.balls.radius
    return of_sections(groove_of_body(geometry, screw), replace(tube, ends=(0.0, 0.0), flange=None), section, radii, near)


@lru_cache(maxsize=32)
@kept(NearFace)
def of_sections(flank: Flank, tube: Tube, section: BeamSection, radii: tuple[float, float], near: bool) -> NearFace:
    """Return `near_face`, which uses neither ends nor flange of the smooth body."""
    return near_face(flank, tube, section, radii, near=near)


def grooved_part(scene: Scene, layout: BallLayout, screw: bool, backend: Backend, flanks: Sequence[int] = BOTH) -> Array:
    """Return the compliance ``(2 c, 2 c)`` [m/N] that grooves and faces add between contacts within half a lead."""
    geometry = geometry_only(scene)
    flank, held, found = (
        groove_of_body(geometry, screw),
        fixed_surface(geometry, screw),
        kept_near_face(geometry, screw, backend),
    )
    z = contact_frames(scene, layout, screw, flanks)[0][:, 2]
    azimuth, side = np.tile(layout.azimuth, len(flanks)), np.repeat(flanks, layout.z.size)
    middle = z - found.beside * np.where(side == 0, -1.0, 1.0)
    ahead = middle[:, None] - middle
    i, j = np.nonzero((ahead >= 0.0) & (ahead < (2 * found.turns - 1) * flank.half))
    turn = np.rint((middle[i] - middle[j]) / (2.0 * flank.half)).astype(int)
    angle, between = azimuth[i] - azimuth[j], 0.5 * (middle[i] + middle[j])
    gain = np.zeros((i.size, 2, 2))
    gain[:, 0, 0] = np.where(i == j, 0.0, found.between(angle)[np.arange(i.size), 1 - side[i], 2 * turn + 1 - side[j]])
    for high, face in enumerate(smooth_body(geometry, screw, backend).ends):
        distance = np.abs(face - between) - turn * flank.half
        near = np.flatnonzero(distance < REACH * scene.balls.radius)
        if not near.size:
            continue
        away = (side != high).astype(int)
        fixed = held in ("both", "high" if high else "low")
        front, back = (i[near], j[near]) if high else (j[near], i[near])
        added = found.by_face(fixed, angle[near], distance[near])
        block = added[np.arange(near.size), away[front], :, 2 * turn[near] + away[back]]
        gain[near] += block if high else block.swapaxes(1, 2) * np.array([[1.0, -1.0], [-1.0, 1.0]])  # from its other end
    signs = flank.map.signs[[s if screw else s + 2 for s in BOTH]][side]
    normal = signs * np.array([np.cos(flank.map.beta), np.sin(flank.map.beta)])
    axes = np.stack([normal, quarter_turn(normal)], axis=1)
    G = np.zeros((side.size, 2, side.size, 2))
    G[i, :, j] = axes[i].swapaxes(1, 2) @ gain @ axes[j]
    G[j, :, i] = G[i, :, j].swapaxes(1, 2)
    return G.reshape(2 * side.size, -1)


def body_between_contacts(
    scene: Scene, layout: BallLayout, screw: bool, backend: Backend, flanks: Sequence[int] = BOTH
) -> Array:
    """Return `lowfi.compliance.bodies.whole_body` of a body that is not rigid, for contacts at any positions."""
    held = fixed_surface(scene, screw)
    if is_ring(geometry_only(scene), screw):
        G = of_flanks(ring_contacts(whole_ring(geometry_only(scene), screw), layout.azimuth), flanks)
    else:
        G = kernel_part(scene, layout, screw, backend, flanks)
        if not screw and held != "outer":
            feel = strained_by_section(scene, layout, False, backend, flanks) if backend.flank else None
            G = G + nut_beam(scene, layout, flanks, feel)
        if backend.flank:
            G = G + grooved_part(scene, layout, screw, backend, flanks)
    G = 0.5 * (G + G.T)
    G.flags.writeable = False
    return G


def motions_by_end(scene: Scene, layout: BallLayout, backend: Backend) -> tuple[Array, Array, float, float]:
    """Return the fields of `lowfi.compliance.bodies.EndResponse` of a screw that is fixed by its section."""
    geometry = geometry_only(scene)
    compliance = smooth_compliance(geometry, True, backend)
    x, axes = contact_frames(scene, layout, True)
    tube = compliance.tube
    (low, high), taken = tube.ends, on_line(tube, x)
    plain = tube.section
    rows = np.concatenate([motion_rows(taken, axes), np.eye(6)])
    stations = np.append(np.repeat(x[:, 2], 2), np.full(6, high))
    shift, tilt, axial, twist = end_springs(tube)
    end = np.eye(6)
    end[0, 4], end[1, 3] = high - low, low - high
    by_springs = np.concatenate([motion_rows(taken, axes, low), end])
    beam = cantilever_compliance(rows, stations, low, plain, slice(-6, None))
    beam += (by_springs / np.array([shift, shift, axial, tilt, tilt, twist])) @ end.T
    motions = np.concatenate([contacts_by_end(compliance, x, axes), end_by_end(compliance)]) - beam
    if backend.flank:
        motions[:-6] += by_wrench_at(strained_by_section(scene, layout, True, backend), stations[:-6], high)
    return motions[:-6], 0.5 * (motions[-6:] + motions[-6:].T), low, high


def motions_by_section(scene: Scene, layout: BallLayout, backend: Backend, at: float) -> Array:
    """Return `lowfi.compliance.bodies.section_response` of contacts wherever they are."""
    geometry = geometry_only(scene)
    tube = smooth_body(geometry, True, backend)
    x, axes = contact_frames(scene, layout, True)
    low, taken = tube.ends[0], on_line(tube, x)
    rows = np.concatenate([motion_rows(taken, axes), np.eye(6)])
    stations = np.append(np.repeat(x[:, 2], 2), np.full(6, at))
    shift, tilt, axial, twist = end_springs(tube)
    end = np.eye(6)
    end[0, 4], end[1, 3] = at - low, low - at
    beam = cantilever_compliance(rows, stations, low, tube.section, slice(-6, None))[:-6]
    beam += (motion_rows(taken, axes, low) / np.array([shift, shift, axial, tilt, tilt, twist])) @ end.T
    motions = contacts_by_end(section_of_tube(tube, stretch_zone(geometry, tube), at), x, axes) - beam
    if backend.flank:
        motions += by_wrench_at(strained_by_section(scene, layout, True, backend), stations[:-6], at)
    return motions


def by_wrench_at(feel: Array, stations: Array, at: float) -> Array:
    """Return the motions ``(2 c, 6)`` by a wrench on the section at the station ``at`` [m].

    feel ``(2 c, 6)``: motion by the wrench on the section of the contact itself, which only those below ``at`` feel.
    """
    out, reach = feel.copy(), at - stations
    out[:, 0] += reach * feel[:, 4]
    out[:, 1] -= reach * feel[:, 3]
    return np.asarray(out * np.heaviside(reach, 0.5)[:, None])


def contacts_by_end(compliance: TubeCompliance, x: Array, axes: Array) -> Array:
    """Return the motions ``(2 c, 6)`` of contacts by a wrench on the mean motions of the high end.

    Contacts at ``(c, 3)`` [m] along axes ``(c, 2, 3)``.
    """
    points = points_in_space(x, axes)
    weights = patch_weights(compliance.z, points.z, compliance.tube.width)
    (axial, twist), (shift, tilt) = ((motions @ weights.T).swapaxes(1, 2) for motions in compliance.ends)
    c, s = np.cos(points.azimuth)[:, None], np.sin(points.azimuth)[:, None]
    here, turned = np.hstack([c, s, c]), np.hstack([s, -c, s])  # at azimuth 0, and a quarter turn on
    by_load = (shift * here, shift * turned, axial, -tilt * turned, tilt * here, twist)
    return np.stack([np.einsum("cak,ck->ca", points.axes, u).ravel() for u in by_load], axis=1)


def end_by_end(compliance: TubeCompliance) -> Array:
    """Return the mean motions of the high end by a wrench on them ``(6, 6)``."""
    (axial, twist), (shift, tilt) = compliance.corner
    out = np.zeros((6, 6))
    out[2, 2], out[2, 5], out[5, 2], out[5, 5] = axial[0], axial[1], twist[0], twist[1]
    for across, about, sign in ((0, 4, 1.0), (1, 3, -1.0)):
        out[across, across], out[about, about] = shift[0], tilt[1]
        out[across, about] = out[about, across] = sign * shift[1]
    return out
