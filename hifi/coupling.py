"""Contacts of all balls of a meshed geometry: compliance between them; gaps and normals as balls and screw move.

The compliance combines bodies condensed to modes, balls, and the screw on its supports.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.linalg import block_diag

from rollbench.hifi.bodies.patch import CondensedPatch
from rollbench.hifi.condensation import CondensedBody
from rollbench.hifi.contact import balls
from rollbench.hifi.contact.balls import BallContactCompliance, ContactCompliance, consecutive_slices
from rollbench.hifi.elements.forms import normalise_weight_rows
from rollbench.hifi.meshing.part_meshes import rotation_about_z
from rollbench.hifi.setup import CondensedGeometry
from rollbench.hifi.shaft.mounting import SupportedShaft, replace_shaft_part_by_beam, support_shaft_part
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.errors import GeometryWithErrors
from rollbench.meshes.helix import nominal_groove_centres, nominal_groove_radii
from rollbench.meshes.parts import Scene
from rollbench.meshes.surface import groove_radius_with_slopes


@dataclass(frozen=True)
class PlacedNut:
    """One nut or bearing with its balls, meshed and condensed, with its position on the shaft and its housing."""

    #: Meshed and condensed bodies of the nut or bearing.
    geometry: CondensedGeometry
    #: Scene of the nut or bearing with its manufacturing errors.
    scene_with_errors: Scene
    #: Groove flanks (0, 1: screw, 2, 3: nut) whose contacts may close.
    closable_flanks: tuple[int, ...]
    #: Axial position on the shaft of the point z = 0 of ``geometry`` [m].
    origin_on_shaft: float = 0.0
    #: Index of the movable housing that carries the nut; None: the nut is fixed.
    housing_index: int | None = None
    #: Shift of the nut along z relative to its housing [m].
    nut_offset: float = 0.0

    @property
    def ball_count(self) -> int:
        """Number of balls of the nut or bearing."""
        return self.geometry.ball_positions.z.size

    def groove_patch(self, side: int) -> CondensedPatch:
        """Return the condensed fine mesh (patch) of the groove at the contacts on a flank (0 to 3)."""
        return self.geometry.patches_by_flank[side].groove_patch

    @cached_property
    def node_slices_of_flanks(self) -> tuple[tuple[slice, int], ...]:
        """For each flank: the slice of one ball's contact nodes that lie on it, and the number of the flank (0 to 3)."""
        slices = consecutive_slices([len(self.groove_patch(s).A) for s in self.closable_flanks])
        return tuple(zip(slices, self.closable_flanks, strict=True))

    @property
    def nodes_per_ball(self) -> int:
        """Number of contact nodes of one ball."""
        return int(self.node_slices_of_flanks[-1][0].stop)


def assemble_contact_compliance(
    sets: Sequence[PlacedNut], mounted: SupportedShaft, leave_out: frozenset[str] = frozenset()
) -> tuple[ContactCompliance, Index]:
    """Assemble the compliance between the contact nodes of all balls, ordered by nut or bearing, ball and flank.

    Parameters
    ----------
    sets : Sequence[PlacedNut]
        Nuts or bearings on the shaft.
    mounted : SupportedShaft
        Parts of the screw that are meshed in 3D, and nuts on movable housings, under the supports and loads.
    leave_out : frozenset[str], optional
        Names of the features that are left out of the model, from `hifi.reference.INGREDIENTS`.

    Returns
    -------
    C : ContactCompliance
        Compliance between the contact nodes, with r modes.
    rows : (r,) Index
        Index of each of these modes among those of all bodies: first those of ``mounted``, then those of the fixed nuts.
    """
    screw, carried, held = 0, sum(p.geometry.condensed_screw.stretch.mode_count for p in sets), len(mounted.G)
    couplings, blocks, modes, rows = [mounted.G], list[BallContactCompliance](), list[Array](), list[Index]()
    for p in sets:
        nut = p.geometry.condensed_nut
        first = (screw, held if p.housing_index is None else carried)
        rigid_ball = bool(leave_out & {"finite ball", "patch coupling"})
        block = compliance_block_of_ball(p.geometry, p.closable_flanks, rigid=rigid_ball)
        for i in range(p.ball_count):
            pieces = []
            for nodes, s in p.node_slices_of_flanks:
                if (body := p.geometry.condensed_body_of_flank(s)) is not None:
                    V = np.zeros((p.nodes_per_ball, body.modes_by_flank[s].shape[1]))
                    V[nodes] = body.modes_by_flank[s]
                    pieces.append(V)
                    rows.append(first[s >= 2] + body.mode_indices_of_contact(s, i))
            blocks.append(block)
            modes.append(np.hstack(pieces))
        screw += p.geometry.condensed_screw.stretch.mode_count
        if nut is None:
            continue
        if p.housing_index is not None:
            carried += len(nut.G)
            continue
        uncoupled = leave_out & {"elastic nut", "patch coupling"}
        couplings.append(compliance_without_contact_coupling(nut.G, nut) if uncoupled else nut.G)
        held += len(nut.G)
    pick = np.concatenate(rows)
    return balls.contact_compliance_of_coupled_balls(blocks, modes, block_diag(*couplings)[np.ix_(pick, pick)]), pick


def compliance_block_of_ball(setup: CondensedGeometry, sides: tuple[int, ...], *, rigid: bool) -> BallContactCompliance:
    """Return the compliance between the contact nodes of one ball, with the local compliance of ball and grooves.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    sides : tuple[int, ...]
        Groove flanks (0, 1: screw, 2, 3: nut) whose contact nodes are included.
    rigid : bool
        Whether the ball is rigid apart from its local compliance at each contact.

    Returns
    -------
    BallContactCompliance
        Compliance between the contact nodes of these flanks.
    """
    local = tuple(setup.patches_by_flank[s].local_compliance for s in sides)
    ball = setup.condensed_ball
    if rigid:
        return BallContactCompliance(local, tuple(np.zeros((len(a), 0)) for a in local), np.zeros((0, 0)))
    pick = np.concatenate([ball.mode_indices_of_contact(s) for s in sides])
    return BallContactCompliance(local, tuple(ball.modes_by_flank[s] for s in sides), ball.G[np.ix_(pick, pick)])


def compliance_without_contact_coupling(compliance: Array, body: CondensedBody) -> Array:
    """Set the compliance of a body to zero between different contacts, so that each load moves only its own contact.

    Every contact keeps its response to its own load, averaged over all contacts of its flank.

    Parameters
    ----------
    compliance : (m, m) Array
        Compliance between the displacement modes of all contacts of the elastic body [m/N].
    body : CondensedBody
        The condensed body.

    Returns
    -------
    (m, m) Array
        Compliance with one block for each contact, zero between contacts [m/N].
    """
    out = np.zeros_like(compliance)
    for s in body.modes_by_flank:
        own = body.compliance_blocks_of_contacts(s, len(compliance) // body.modes_per_ball)
        mean = np.mean([compliance[block] for block in own], axis=0)
        for block in own:
            out[block] = mean
    return out


def compliance_of_supported_screw(
    setup: CondensedGeometry, scene: Scene, leave_out: frozenset[str] = frozenset()
) -> SupportedShaft:
    """Compute the compliance between the screw's contacts when the screw stands on the supports of a scene.

    If the 3D shaft is left out of the model, the screw is a beam with the same local response at its contacts.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    scene : Scene
        Supports and loads.
    leave_out : frozenset[str], optional
        Names of the features that are left out of the model, from `hifi.reference.INGREDIENTS`.

    Returns
    -------
    SupportedShaft
        Compliance of the supported screw at its contacts, and its displacement under the loads.
    """
    full, m = setup.condensed_screw.stretch, setup.condensed_screw.stretch.mode_count
    if not leave_out & {"3D shaft", "patch coupling"} or full.moves_with_base:
        return support_shaft_part(full, scene, setup.shaft_section)
    stations = np.repeat(setup.ball_positions.z, len(setup.condensed_screw.modes_by_flank))
    beam = replace_shaft_part_by_beam(setup.condensed_screw.modes_by_rigid_motions, stations, full, setup.shaft_section)
    F = beam.F.copy()
    F[:m, :m] += compliance_without_contact_coupling(full.F[:m, :m] - beam.F[:m, :m], setup.condensed_screw)
    return support_shaft_part(replace(beam, F=F), scene, setup.shaft_section)


def normal_motion_of_nodes(C: ContactCompliance, mode_displacements: Array) -> Array:
    """Compute the motion of every contact node along its normal from the displacements of the contacts' modes.

    Parameters
    ----------
    C : ContactCompliance
        Compliance of n contact nodes.
    mode_displacements : (r,) Array
        Displacements of the modes of the compliance [m].

    Returns
    -------
    (n,) Array
        Motions of the contact nodes along their normals [m].
    """
    return np.concatenate([V @ mode_displacements[c] for V, c in zip(C.modes_by_ball, C.mode_slices_by_ball, strict=True)])


def expected_touching_nodes(p: PlacedNut, gap: Array) -> Array:
    """Return which contact nodes are expected to touch: on each flank, the third of its nodes with the smallest gaps.

    Parameters
    ----------
    p : PlacedNut
        Nut or bearing with its condensed bodies and its position on the shaft.
    gap : (balls, n) Array
        Gaps at the n contact nodes of each ball [m].

    Returns
    -------
    (balls, n) Array of bool
        Whether each node is expected to touch.
    """
    out = np.zeros(gap.shape, dtype=bool)
    for nodes, _ in p.node_slices_of_flanks:
        gaps = gap[:, nodes]
        third = gaps.shape[1] // 3
        out[:, nodes] = gaps < np.partition(gaps, third, axis=1)[:, third, None]
    return out


def average_over_pressure_functions(p: PlacedNut, values: Array) -> Array:
    """Average values over the surroundings of each contact node, with the node's pressure basis function as weight.

    Parameters
    ----------
    p : PlacedNut
        Nut or bearing with its condensed bodies and its position on the shaft.
    values : (balls, n, ...) Array
        Values at the n contact nodes of each ball.

    Returns
    -------
    Array of the shape of ``values``
        Weighted mean for each node.
    """
    out = np.empty_like(values)
    for nodes, s in p.node_slices_of_flanks:
        by_node = np.moveaxis(values[:, nodes], 1, 0)
        mean = normalise_weight_rows(p.groove_patch(s).pressure_weights) @ by_node.reshape(len(by_node), -1)
        out[:, nodes] = np.moveaxis(mean.reshape(by_node.shape), 0, 1)
    return out


def grid_position_gap_corrections(p: PlacedNut, forces: Array, normals: Array) -> Array:
    """Compute gap corrections that remove the discretisation error due to each contact's position on its mesh grid.

    The corrections are interpolated in the tables of `hifi.bodies.grid_wave`.

    Parameters
    ----------
    p : PlacedNut
        Nut or bearing with its condensed bodies and its position on the shaft.
    forces : (balls, n) Array
        Contact forces at the n contact nodes of each ball [N].
    normals : (balls, n, 3) Array
        Contact normals at the nodes.

    Returns
    -------
    (balls, n) Array
        Corrections to be added to the gaps [m].
    """
    out = np.zeros_like(forces)
    for nodes, s in p.node_slices_of_flanks:
        pair = p.geometry.patches_by_flank[s]
        if pair.gap_correction is not None:
            pressed = forces[:, nodes]
            centres = (pressed @ pair.groove_patch.contact_points) / np.maximum(pressed.sum(axis=1), 1e-300)[:, None]
            loads = np.linalg.norm(np.einsum("ic,icx->ix", pressed, normals[:, nodes]), axis=1)
            out[:, nodes] = pair.gap_correction.interpolate(loads, centres)[:, None]
    return out


def vectors_from_ball_centre_to_nodes(p: PlacedNut, parts_with_errors: GeometryWithErrors) -> Array:
    """Return the vectors from the nominal centre of each ball to the contact nodes of its grooves, in the ball's frame.

    The nominal groove is changed by the manufacturing errors at each ball and by the axial shift of the nut.

    Parameters
    ----------
    p : PlacedNut
        Nut or bearing with its condensed bodies and its position on the shaft.
    parts_with_errors : GeometryWithErrors
        Radii of balls and grooves with their manufacturing errors.

    Returns
    -------
    (balls, n, 3) Array
        Vectors to the n contact nodes of each ball [m].
    """
    m = p.geometry.groove_map
    x3, _, z3 = m.section_axes()
    nominal_centres, radii = nominal_groove_centres(p.geometry.scene), nominal_groove_radii(p.geometry.scene)
    rows = []
    for s in p.closable_flanks:
        local = p.groove_patch(s).contact_points - np.array([m.R, 0.0, 0.0])
        offset = parts_with_errors.groove_centres[:, s] - nominal_centres[s]
        shift = offset[:, :1, None] * x3 + offset[:, 1:, None] * z3
        gamma, _ = m.section_to_polar(s, local @ x3, local @ z3)
        real = parts_with_errors.groove_radii[s], parts_with_errors.profile_coefficients[s]
        inward = radii[s] - groove_radius_with_slopes(gamma, *real)[0]
        sx, sz = m.signs[s]
        outward = sx * np.cos(gamma)[:, None] * x3 + sz * np.sin(gamma)[:, None] * z3
        by_nut = p.nut_offset * np.cos(m.alpha) * z3 if s >= 2 else np.zeros(3)
        rows.append(local + (shift - (inward[:, None] * outward)[None]) + by_nut)
    return np.concatenate(rows, axis=1)


def gap_closing_matrix(contact_normals: Sequence[Array], free_motions: Array) -> sp.csr_array:
    """Assemble the matrix N: the gap that each contact pair loses by unit rigid motions of balls, shaft and housings.

    Parameters
    ----------
    contact_normals : Sequence[Array]
        Contact normals of every nut or bearing ``(balls, n, 3)``.
    free_motions : (pairs, k) Array
        Motion of the grooves' nodes along their normals by the k rigid motions of shaft and housings that no support
        prevents.

    Returns
    -------
    (pairs, 3 balls + k) sparse array
        Gap closed at each contact pair by three unit displacements of each ball, then by the k rigid motions.
    """
    balls = sp.block_diag([sp.csr_array(normals) for of_set in contact_normals for normals in of_set])
    return sp.hstack([balls, sp.csr_array(-free_motions)]).tocsr()


def normal_motion_by_rigid_motions(p: PlacedNut, normals: Array, origin: float, *, screw: bool) -> Array:
    """Compute how far contact nodes of screw or nut move along their normals by unit rigid motions of that body.

    Parameters
    ----------
    p : PlacedNut
        Nut or bearing with its condensed bodies and its position on the shaft.
    normals : (balls, n, 3) Array
        Contact normals at the n nodes of each ball.
    origin : float
        Axial position on the shaft about which the body rotates [m].
    screw : bool
        True: the screw moves; False: the nut.

    Returns
    -------
    (balls, n, 6) Array
        Motion of each node along its normal by unit translations and rotations; zero for nodes of the other body.
    """
    layout = p.geometry.ball_positions
    out = np.zeros((*normals.shape[:2], 6))
    for nodes, s in p.node_slices_of_flanks:
        if (s < 2) != screw:
            continue
        for i in range(p.ball_count):
            R = rotation_about_z(float(layout.azimuth[i]))
            arm = np.array([0.0, 0.0, layout.z[i] - (origin - p.origin_on_shaft)])
            x = p.groove_patch(s).contact_points @ R.T + arm
            d = normals[i, nodes] @ R.T
            out[i, nodes, :3], out[i, nodes, 3:] = d, np.cross(x, d)
    return out


def ball_motion_relative_to_grooves(
    p: PlacedNut, ball_displacements: Array, normal_motions: Array, normals: Array
) -> tuple[Array, Array]:
    """Compute the displacement of each ball's centre relative to each of its groove flanks, across and along the track.

    The component across the track turns the contact normals. The component along the track has no effect, because a groove
    is invariant under its helical motion: that motion changes no gap, frictionless contact forces do no work in it, and
    every contact stays in the cross-section of the track in which its ball lies.

    Linear kinematics alone would give wrong normals: a screw that is twisted by an angle theta moves its contacts, at the
    pitch radius R, by R theta/2 along the track and by R theta^2/2 out of the section in which they lie. The motion could
    also be taken from the centre of pressure, but under a light contact that closes few nodes of the grid the centre of
    pressure sticks to them, or jumps.

    Parameters
    ----------
    p : PlacedNut
        Nut or bearing with its condensed bodies and its position on the shaft.
    ball_displacements : (balls, 3) Array
        Motions of the ball centres [m].
    normal_motions : (balls, n) Array
        Motions of the grooves' nodes along their normals, which the modes and rigid motions of the bodies cause [m].
    normals : (balls, n, 3) Array
        Contact normals at the nodes.

    Returns
    -------
    shift : (balls, n, 3) Array
        Displacement across the track, in the plane of its section [m].
    slid : (balls, n) Array
        Displacement along the track, less its mean over the flanks of the ball [m].
    """
    motion = np.zeros((len(ball_displacements), len(p.node_slices_of_flanks), 3))
    for k, (nodes, _) in enumerate(p.node_slices_of_flanks):
        for i in range(len(ball_displacements)):
            of_groove = np.linalg.lstsq(normals[i, nodes], normal_motions[i, nodes], rcond=1e-6)[0]
            motion[i, k] = ball_displacements[i] - of_groove
    y3 = p.geometry.groove_map.section_axes()[1]
    slid = motion @ y3
    shift = motion - slid[..., None] * y3
    sizes = [nodes.stop - nodes.start for nodes, _ in p.node_slices_of_flanks]
    return np.repeat(shift, sizes, axis=1), np.repeat(slid - slid.mean(axis=1, keepdims=True), sizes, axis=1)


def track_velocity_at_nodes(p: PlacedNut) -> Array:
    """Return the velocity field of the screw motion along the track at the n contact nodes of a ball ``(n, 3)``.

    The velocities are in the ball's frame, and scaled so that the speed at the ball's centre is 1.
    """
    m = p.geometry.groove_map
    x = np.concatenate([p.groove_patch(s).contact_points for s in p.closable_flanks])
    return np.asarray(np.stack([-x[:, 1], x[:, 0], np.full(len(x), m.rg)], axis=1) * (np.cos(m.alpha) / m.R))
