"""Compliance of screw or nut between its contacts, computed by finite elements (results are cached by the caller).

It is the sum of three parts: a beam with the section constants of the grooved body; the compliance of a smooth elastic body
of revolution less that of its own beam; and the compliance that grooves and end faces add.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from rollbench.lowfi.compliance import faces, parts, tube
from rollbench.lowfi.compliance.beyond_hertz import NARROW, half_space_compliance
from rollbench.lowfi.compliance.groove import GrooveRingCompliance, compliance_between_ring_contacts, ring_compliance
from rollbench.lowfi.compliance.parts import BOTH, REFINED, ComplianceModel
from rollbench.lowfi.compliance.tube import HalfGroove
from rollbench.lowfi.compliance.washer import washer_compliance
from rollbench.meshes.arrays import Array
from rollbench.meshes.cache import cached_on_disk
from rollbench.meshes.helix import BallLayout, nominal_contact_points
from rollbench.meshes.parts import Scene
from rollbench.meshes.section import BeamSection
from rollbench.meshes.solid import dimensions_of_3d_parts
from rollbench.meshes.washers import has_washers, washer_of_ring

#: Length by which the loaded zone of a smooth body extends beyond either face of the nut, in widths of a load patch;
#: patches near a face are then complete.
BESIDE = 2.5


def contact_points_and_axes(
    scene: Scene, layout: BallLayout, screw: bool, flanks: Sequence[int] = BOTH
) -> tuple[Array, Array]:
    """Return the nominal contact points of screw or nut ``(c, 3)`` [m], then the two section axes at each ``(c, 2, 3)``.

    The c contacts are those of all balls on the first of ``flanks``, then those on the second (0: left, 1: right). The axes
    are the radial and binormal directions of the groove's section. ``layout``: positions of the balls; ``screw``: whether
    the body is the screw (True) or the nut.
    """
    at = nominal_contact_points(scene)[:2] if screw else nominal_contact_points(scene)[2:]
    x = [layout.centre + at[s][0] * layout.radial + at[s][1] * layout.binormal for s in flanks]
    axes = np.stack([layout.radial, layout.binormal], axis=1)
    return np.concatenate(x), np.concatenate([axes] * len(flanks))


@lru_cache(maxsize=32)
def compliance_of_smooth_body(geometry: Scene, screw: bool, backend: ComplianceModel) -> tube.SmoothBodyCompliance:
    """Return the compliance of the smooth body (without grooves) that represents screw or nut, where its contacts lie.

    ``geometry``: scene of `reduce_to_compliance_geometry`; ``screw``: whether the body is the screw (True) or the nut;
    ``backend``: model of the bodies.
    """
    body = parts.smooth_body(geometry, screw, backend)
    return cached_tube_compliance(body, axial_range_of_contacts(geometry, body))


def axial_range_of_contacts(geometry: Scene, body: tube.SmoothBody) -> tuple[float, float]:
    """Return the lower and upper end of the axial range [m] that contains all load patches on a smooth body.

    It reaches beyond both faces of the nut by `BESIDE` times the width (standard deviation) of a patch. ``geometry``: scene
    of `reduce_to_compliance_geometry`; ``body``: smooth body, which gives the width of the patches.
    """
    half = geometry.nut.length / 2.0 + BESIDE * body.patch_width
    return geometry.nut.position - half, geometry.nut.position + half


#: Functions whose results are cached with the tube as key, so that the same screw with another nut needs no computation.
cached_tube_compliance = lru_cache(maxsize=32)(tube.tube_compliance)
cached_section_motions = lru_cache(maxsize=32)(tube.shaft_motions_by_section_loads)


@lru_cache(maxsize=32)
@cached_on_disk(GrooveRingCompliance)
def grooved_ring_compliance(geometry: Scene, screw: bool) -> GrooveRingCompliance:
    """Return the compliance of a bearing ring with its groove, cached on disk by its geometry.

    ``geometry``: scene of `reduce_to_compliance_geometry`; ``screw``: whether the ring is the inner ring (True) or the
    outer ring.
    """
    flank = parts.half_groove_of_body(geometry, screw)
    if has_washers(geometry):
        return washer_compliance(flank, washer_of_ring(geometry, screw))
    return ring_compliance(flank, parts.fixed_surface(geometry, screw))


def flank_self_compliance(geometry: Scene, screw: bool, backend: ComplianceModel) -> float:
    """Return a groove flank's local compliance at a contact [m/N], beyond Hertz's law and the ungrooved smooth body.

    The compliance is the motion of the contact by a unit load on the contact, less the motions by Hertz's law and by the
    smooth body. It holds for a narrow load patch; `lowfi.compliance.beyond_hertz.contact_size_correction` adds the
    influence of the contact's size.

    ``geometry``: scene of `reduce_to_compliance_geometry`; ``screw``: whether the body is the screw (True) or the nut;
    ``backend``: model of the bodies.
    """
    flank = parts.half_groove_of_body(geometry, screw)
    if parts.is_elastic_bearing_ring(geometry, screw):
        narrow = half_space_compliance(NARROW * flank.groove_map.ball, flank.material)
        return grooved_ring_compliance(geometry, screw).local_normal_correction - narrow
    body = parts.smooth_body(geometry, screw, backend)
    if not backend.flank:  # the half space at the smooth body's own patch only
        return -half_space_compliance(body.patch_width, body.material)
    return groove_and_face_compliance_of_body(geometry, screw, backend).self_compliance


def smooth_body_compliance_beyond_beam(
    scene: Scene, layout: BallLayout, screw: bool, backend: ComplianceModel, flanks: Sequence[int] = BOTH
) -> Array:
    """Return the compliance ``(2 c, 2 c)`` [m/N] of a smooth body between c contacts, less that of an equally stiff beam.

    Each contact has two axes (`contact_points_and_axes`). ``layout``: positions of the balls; ``screw``: whether the body
    is the screw (True) or the nut; ``flanks``: flanks with contacts, 0 left, 1 right. Raises ValueError if a contact lies
    beyond the faces of the nut.
    """
    geometry = parts.reduce_to_compliance_geometry(scene)
    x, axes = contact_points_and_axes(scene, layout, screw, flanks)
    if float(np.abs(x[:, 2] - scene.nut.position).max()) > 0.5 * scene.nut.length:
        raise ValueError("a ball contact lies beyond the nut's faces: lengthen the nut or reduce the number of turns")
    smooth = compliance_of_smooth_body(geometry, screw, backend)
    G = tube.contact_compliance(smooth, tube.convert_contacts_to_cylindrical(x, axes))
    body = smooth.tube
    x = tube.move_contacts_to_surface(body, x)
    rows, stations = tube.contact_motions_by_rigid_motions(x, axes), np.repeat(x[:, 2], 2)
    if body.held == "section":
        G = G - tube.low_end_spring_compliance(body, x, axes)
        G = G - tube.clamped_beam_compliance(rows, stations, body.ends, "low", body.section)
        if backend.flank:
            local = contact_motions_by_section_wrench(scene, layout, True, backend, flanks)
            G = G + tube.compliance_of_local_groove_strains(local, rows, stations, body.ends[0])
    elif body.held in parts.CLAMPED:
        G = G - tube.clamped_beam_compliance(rows, stations, *parts.nut_beam_ends_and_clamps(body), body.section)
    return G


def contact_motions_by_section_wrench(
    scene: Scene, layout: BallLayout, screw: bool, backend: ComplianceModel, flanks: Sequence[int] = BOTH
) -> Array:
    """Return the local motions ``(2 c, 6)`` of c contacts by six unit loads that the contact's cross-section transmits.

    The loads are three forces and three moments. The motions of the smooth body under the same loads are subtracted. A
    difference remains, because at a groove the body is thinner than on average and therefore strains more
    (`GrooveAndFaceCompliance.section_strain_motions`). Arguments, and the c contacts with two axes each, are those of
    `smooth_body_compliance_beyond_beam`.
    """
    found = groove_and_face_compliance_of_body(parts.reduce_to_compliance_geometry(scene), screw, backend)
    points = tube.convert_contacts_to_cylindrical(*contact_points_and_axes(scene, layout, screw, flanks))
    return faces.contact_motions_by_own_section_wrench(
        points, np.repeat([2.0 * side - 1.0 for side in flanks], layout.z.size), found.section_strain_motions
    )


def nut_beam_compliance(
    scene: Scene, layout: BallLayout, flanks: Sequence[int] = BOTH, section_strain_motions: Array | None = None
) -> Array:
    """Return the compliance ``(2 c, 2 c)`` [m/N] between the c contacts of a nut modelled as a Timoshenko beam.

    The beam has the section of the grooved nut. It is clamped at the nut's faces or at its flange. The compliance is zero
    if the outer surface is fixed. ``layout``: positions of the balls; ``flanks``: flanks with contacts, 0 left, 1 right;
    ``section_strain_motions``: local motions by wrenches at the grooves, see `clamped_beam_compliance`, or None to neglect
    these motions.
    """
    geometry = parts.reduce_to_compliance_geometry(scene)
    x, axes = contact_points_and_axes(scene, layout, False, flanks)
    if parts.fixed_surface(geometry, False) not in parts.CLAMPED:
        return np.zeros((2 * len(x),) * 2)
    section, body = parts.grooved_section(geometry, False), parts.smooth_body(geometry, False, REFINED)
    rows, stations = tube.contact_motions_by_rigid_motions(x, axes), np.repeat(x[:, 2], 2)
    ends, clamps = parts.nut_beam_ends_and_clamps(body)
    return tube.clamped_beam_compliance(rows, stations, ends, clamps, section, section_strain_motions)


@lru_cache(maxsize=32)
def groove_and_face_compliance_of_body(
    geometry: Scene, screw: bool, backend: ComplianceModel
) -> faces.GrooveAndFaceCompliance:
    """Return the compliance that grooves and end faces of screw or nut add between contacts on the same or the next turn.

    The result is cached in memory by the geometry, and that of `cached_groove_and_face_compliance` on disk.

    ``geometry``: scene of `reduce_to_compliance_geometry`; ``screw``: whether the body is the screw (True) or the nut;
    ``backend``: model of the bodies.
    """
    radii = (0.0, np.inf) if screw else dimensions_of_3d_parts(geometry).held_radii
    section, body = parts.grooved_section(geometry, screw), parts.smooth_body(geometry, screw, backend)
    low, high = (abs(end - geometry.nut.position) - 0.5 * geometry.nut.length for end in body.ends)
    near = min(low, high) < faces.REACH * geometry.balls.radius
    return cached_groove_and_face_compliance(
        parts.half_groove_of_body(geometry, screw), replace(body, ends=(0.0, 0.0), flange=None), section, radii, near
    )


@lru_cache(maxsize=32)
@cached_on_disk(faces.GrooveAndFaceCompliance)
def cached_groove_and_face_compliance(
    flank: HalfGroove, body: tube.SmoothBody, section: BeamSection, fixed_radii: tuple[float, float], has_near_face: bool
) -> faces.GrooveAndFaceCompliance:
    """Return the compliance that grooves and end faces add between contacts, cached on disk by the arguments.

    It is that of `compute_groove_and_face_compliance`. ``flank``: groove of the body; ``body``: smooth body; ``section``:
    section of the grooved body's beam; ``fixed_radii``: range of radii in which a face is fixed [m]; ``has_near_face``:
    whether an end face is so near to a contact that its effect is computed. The axial positions of the body's ends and its
    flange do not influence the result.
    """
    return faces.compute_groove_and_face_compliance(flank, body, section, fixed_radii, has_near_face=has_near_face)


def groove_and_face_compliance(
    scene: Scene, layout: BallLayout, screw: bool, backend: ComplianceModel, flanks: Sequence[int] = BOTH
) -> Array:
    """Return the compliance ``(2 c, 2 c)`` [m/N] that grooves and end faces add between c contacts of screw or nut.

    Only contacts on the flanks of the same turn of the groove, or also of the next turn, are coupled
    (`GrooveAndFaceCompliance.coupled_turns`). Arguments are those of `smooth_body_compliance_beyond_beam`.
    """
    geometry = parts.reduce_to_compliance_geometry(scene)
    flank = parts.half_groove_of_body(geometry, screw)
    held = parts.fixed_surface(geometry, screw)
    found = groove_and_face_compliance_of_body(geometry, screw, backend)
    z = contact_points_and_axes(scene, layout, screw, flanks)[0][:, 2]
    azimuth, side = np.tile(layout.azimuth, len(flanks)), np.repeat(flanks, layout.z.size)
    middle = z - found.contact_to_mid_groove * np.where(side == 0, -1.0, 1.0)
    ahead = middle[:, None] - middle
    i, j = np.nonzero((ahead >= 0.0) & (ahead < (2 * found.coupled_turns - 1) * flank.half_length))
    turn = np.rint((middle[i] - middle[j]) / (2.0 * flank.half_length)).astype(int)
    angle, between = azimuth[i] - azimuth[j], 0.5 * (middle[i] + middle[j])
    gain = np.zeros((i.size, 2, 2))
    far = found.compliance_far_from_faces(angle)[np.arange(i.size), 1 - side[i], 2 * turn + 1 - side[j]]
    gain[:, 0, 0] = np.where(i == j, 0.0, far)
    for high, face in enumerate(parts.smooth_body(geometry, screw, backend).ends):
        distance = np.abs(face - between) - turn * flank.half_length
        near = np.flatnonzero(distance < faces.REACH * scene.balls.radius)
        if not near.size:
            continue
        away = (side != high).astype(int)
        fixed = held in ("both", "high" if high else "low")
        front, back = (i[near], j[near]) if high else (j[near], i[near])
        added = found.compliance_by_face(fixed, angle[near], distance[near])
        block = added[np.arange(near.size), away[front], :, 2 * turn[near] + away[back]]
        gain[near] += block if high else block.swapaxes(1, 2) * np.array([[1.0, -1.0], [-1.0, 1.0]])  # mirror image
    signs = flank.groove_map.signs[[s if screw else s + 2 for s in BOTH]][side]
    normal = signs * np.array([np.cos(flank.groove_map.beta), np.sin(flank.groove_map.beta)])
    axes = np.stack([normal, faces.perpendicular_directions(normal)], axis=1)
    G = np.zeros((side.size, 2, side.size, 2))
    G[i, :, j] = axes[i].swapaxes(1, 2) @ gain @ axes[j]
    G[j, :, i] = G[i, :, j].swapaxes(1, 2)
    return G.reshape(2 * side.size, -1)


def compute_compliance_between_contacts(
    scene: Scene, layout: BallLayout, screw: bool, backend: ComplianceModel, flanks: Sequence[int] = BOTH
) -> Array:
    """Compute the compliance ``(2 c, 2 c)`` [m/N] between c contacts of the nut, or of the screw in addition to its beam.

    It is `lowfi.compliance.bodies.compliance_between_contacts` without a cache, for a body that is not rigid and for balls
    at any positions. Arguments are those of `smooth_body_compliance_beyond_beam`.
    """
    held = parts.fixed_surface(scene, screw)
    geometry = parts.reduce_to_compliance_geometry(scene)
    if parts.is_elastic_bearing_ring(geometry, screw):
        whole = compliance_between_ring_contacts(grooved_ring_compliance(geometry, screw), layout.azimuth)
        G = parts.compliance_block_of_flanks(whole, flanks)
    else:
        G = smooth_body_compliance_beyond_beam(scene, layout, screw, backend, flanks)
        if not screw and held != "outer":
            feel = contact_motions_by_section_wrench(scene, layout, False, backend, flanks) if backend.flank else None
            G = G + nut_beam_compliance(scene, layout, flanks, feel)
        if backend.flank:
            G = G + groove_and_face_compliance(scene, layout, screw, backend, flanks)
    G = 0.5 * (G + G.T)
    G.flags.writeable = False
    return G


@dataclass(frozen=True)
class EndWrenchMotions:
    """Motions of a screw by six unit loads (3 forces, 3 moments) on its end face at high z, beyond those of its beam."""

    #: Motions of the contacts by each of the six loads: all left contacts, then all right contacts, along the radial and
    #: the binormal axis each ``(4 N, 6)``.
    contact_motions: Array
    #: Six mean motions (3 displacements, 3 rotations) of the end face at high z by each of the six loads ``(6, 6)``.
    end_motions: Array
    #: Axial position of the screw's end at low z [m].
    low_end: float
    #: Axial position of the screw's end at high z [m].
    high_end: float


def screw_motions_by_end_wrench(scene: Scene, layout: BallLayout, backend: ComplianceModel) -> EndWrenchMotions:
    """Return the motions of a screw's contacts and high-z end face by six unit loads on that face, less the beam's motions.

    The loads are three forces and three moments. The end face at low z has no mean displacement and no mean rotation.

    ``layout``: positions of the N balls; ``backend``: model of the bodies.

    Returns
    -------
    tuple
        Motions of the contacts, all left contacts, then all right contacts, two axes each ``(4 N, 6)``; mean motions of the
        end face at high z ``(6, 6)``; axial positions of the low and the high end [m]. These are the fields of
        `lowfi.compliance.bodies.EndWrenchMotions`.
    """
    geometry = parts.reduce_to_compliance_geometry(scene)
    compliance = compliance_of_smooth_body(geometry, True, backend)
    x, axes = contact_points_and_axes(scene, layout, True)
    low, high = compliance.tube.ends
    motions = np.concatenate([contact_motions_by_end_wrench(compliance, x, axes), high_end_compliance_matrix(compliance)])
    motions -= shaft_beam_motions_by_section_wrench(compliance.tube, x, axes, high)
    if backend.flank:
        local = contact_motions_by_section_wrench(scene, layout, True, backend)
        motions[:-6] += section_strain_motions_by_wrench(local, np.repeat(x[:, 2], 2), high)
    return EndWrenchMotions(motions[:-6], 0.5 * (motions[-6:] + motions[-6:].T), low, high)


def screw_motions_by_section_wrench(scene: Scene, layout: BallLayout, backend: ComplianceModel, section_z: float) -> Array:
    """Compute the motions ``(4 N, 6)`` of a screw's contacts by six unit loads on a cross-section, less the beam's motions.

    The columns are for three forces and three moments, the rows for all left contacts, then all right contacts, with two
    axes each. ``layout``: positions of the N balls; ``section_z``: axial position of the cross-section [m]. The function is
    `lowfi.compliance.bodies.screw_response_to_section_wrench` without a cache, for balls at any positions.
    """
    geometry = parts.reduce_to_compliance_geometry(scene)
    body = parts.smooth_body(geometry, True, backend)
    x, axes = contact_points_and_axes(scene, layout, True)
    compliance = cached_section_motions(body, axial_range_of_contacts(geometry, body), section_z)
    motions = contact_motions_by_end_wrench(compliance, x, axes)
    motions -= shaft_beam_motions_by_section_wrench(body, x, axes, section_z)[:-6]
    if backend.flank:
        local = contact_motions_by_section_wrench(scene, layout, True, backend)
        motions += section_strain_motions_by_wrench(local, np.repeat(x[:, 2], 2), section_z)
    return motions


def shaft_beam_motions_by_section_wrench(body: tube.SmoothBody, contact_points: Array, axes: Array, z: float) -> Array:
    """Return the motions ``(2 c + 6, 6)`` of a smooth shaft's beam by six unit loads on its cross-section at ``z`` [m].

    The loads are three forces and three moments. The motions are those of c contacts, along two axes each, then the six of
    the loaded cross-section. The springs at the shaft's end at low z are included. ``contact_points`` ``(c, 3)``: contact
    points [m]; ``axes`` ``(c, 2, 3)``: directions of their motions.
    """
    low, taken = body.ends[0], tube.move_contacts_to_surface(body, contact_points)
    rows = np.concatenate([tube.contact_motions_by_rigid_motions(taken, axes), np.eye(6)])
    stations = np.append(np.repeat(contact_points[:, 2], 2), np.full(6, z))
    end = np.eye(6)
    end[0, 4], end[1, 3] = z - low, low - z
    by_springs = np.concatenate([tube.contact_motions_by_rigid_motions(taken, axes, low), end])
    beam = tube.cantilever_compliance(rows, stations, low, body.section, slice(-6, None))
    return np.asarray(beam + (by_springs / np.repeat(tube.low_end_spring_stiffnesses(body)[:2], 3)) @ end.T)


def section_strain_motions_by_wrench(section_strain_motions: Array, stations: Array, section_z: float) -> Array:
    """Return the motions ``(2 c, 6)`` of c contacts by six unit loads on a section, due to local strains at grooves.

    The loads are three forces and three moments. ``section_strain_motions`` ``(2 c, 6)``: the motions if the loads act on
    the cross-section of the contact itself; ``stations``: axial positions of the contacts, one for each axis ``(2 c,)``
    [m]; ``section_z``: axial position of the loaded cross-section [m]. The shaft transmits the loads to its end at low z,
    through the sections below ``section_z``, so contacts above it do not move.
    """
    out, reach = section_strain_motions.copy(), section_z - stations
    out[:, 0] += reach * section_strain_motions[:, 4]
    out[:, 1] -= reach * section_strain_motions[:, 3]
    return np.asarray(out * np.heaviside(reach, 0.5)[:, None])


def contact_motions_by_end_wrench(compliance: tube.SmoothBodyCompliance, contact_points: Array, axes: Array) -> Array:
    """Return the motions ``(2 c, 6)`` of c contacts on a shaft without grooves by six unit loads on its end face at high z.

    The loads are three forces and three moments. Each is spread over the end face so that its work is the load times the
    mean motion of the face (displacement or rotation) in its direction. ``compliance``: compliance of the shaft without
    grooves; ``contact_points`` ``(c, 3)``: contact points [m]; ``axes`` ``(c, 2, 3)``: directions of their motions.
    """
    points = tube.convert_contacts_to_cylindrical(contact_points, axes)
    weights = tube.gaussian_weights_on_line(compliance.z, points.z, compliance.tube.patch_width)
    (axial, twist), (shift, tilt) = ((motions @ weights.T).swapaxes(1, 2) for motions in compliance.line_motions_by_end)
    c, s = np.cos(points.azimuth)[:, None], np.sin(points.azimuth)[:, None]
    here, turned = np.hstack([c, s, c]), np.hstack([s, -c, s])  # at azimuth 0, and a quarter turn on
    by_load = (shift * here, shift * turned, axial, -tilt * turned, tilt * here, twist)
    return np.stack([np.einsum("cak,ck->ca", points.axes, u).ravel() for u in by_load], axis=1)


def high_end_compliance_matrix(compliance: tube.SmoothBodyCompliance) -> Array:
    """Return the compliance ``(6, 6)`` of a shaft's end face at high z: its six mean motions by six unit loads on it."""
    (axial, twist), (shift, tilt) = compliance.end_compliance
    out = np.zeros((6, 6))
    out[2, 2], out[2, 5], out[5, 2], out[5, 5] = axial[0], axial[1], twist[0], twist[1]
    for across, about, sign in ((0, 4, 1.0), (1, 3, -1.0)):
        out[across, across], out[about, about] = shift[0], tilt[1]
        out[across, about] = out[about, across] = sign * shift[1]
    return out
