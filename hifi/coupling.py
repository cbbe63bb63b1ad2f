"""Contacts of all balls of a prepared geometry: compliance between them, and gaps and normals as balls and screw move.

The compliance combines bodies condensed to modes, balls, and the screw on its supports.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy.sparse as sp
from scipy.linalg import block_diag

from rollbench.hifi.condensation import ModalBody
from rollbench.hifi.contact.balls import BallBlock, Compliance, compliance_of_coupled_balls
from rollbench.hifi.elements.forms import normalise_rows_of_weights
from rollbench.hifi.meshing.part_meshes import rotation_about_z
from rollbench.hifi.setup import Setup
from rollbench.hifi.shaft.mounting import MountedShaft, mount_stretch, replace_stretch_by_beam
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.errors import Specimen
from rollbench.meshes.helix import nominal_groove_centres, nominal_groove_radii
from rollbench.meshes.parts import Scene
from rollbench.meshes.surface import groove_radius_with_slopes


@dataclass(frozen=True)
class PlacedSet:
    """One nut or bearing with its balls, meshed and condensed, at its place on the shaft and on its housing."""

    #: The prepared geometry.
    setup: Setup
    #: Scene that gives the manufacturing errors.
    scene: Scene
    #: Flanks (0 to 3) whose contacts may close.
    sides: tuple[int, ...]
    #: Axial position on the shaft of the origin of the geometry's local axis [m].
    shift: float = 0.0
    #: Index of the movable housing that carries its nut; None: the nut is fixed.
    housing: int | None = None
    #: Shift of the nut along z relative to its housing [m].
    offset: float = 0.0

    @property
    def ball_count(self) -> int:
        """Number of balls of the nut or bearing."""
        return self.setup.layout.z.size

    @cached_property
    def node_slices_of_flanks(self) -> tuple[tuple[slice, int], ...]:
        """For each flank: the slice of one ball's contact nodes that lie on it, and the number of the flank (0 to 3)."""
        ends = np.cumsum([0] + [len(self.setup.patches[s].groove.A) for s in self.sides]).tolist()
        return tuple((slice(a, b), s) for (a, b), s in zip(pairwise(ends), self.sides, strict=True))

    @property
    def nodes_per_ball(self) -> int:
        """Number of contact nodes of one ball."""
        return int(self.node_slices_of_flanks[-1][0].stop)


def assemble_contact_compliance(
    sets: Sequence[PlacedSet], mounted: MountedShaft, leave_out: frozenset[str] = frozenset()
) -> tuple[Compliance, Index]:
    """Assemble the compliance between the contact nodes of all balls, ordered by nut or bearing, ball and flank.

    Parameters
    ----------
    sets : Sequence[PlacedSet]
        Nuts or bearings on the shaft.
    mounted : MountedShaft
        Stretches of the screw and nuts on movable housings, under their supports and loads.
    leave_out : frozenset[str], optional
        Names of the parts of the model that are left out, from `hifi.reference.INGREDIENTS`.

    Returns
    -------
    C : Compliance
        Compliance between the contact nodes, with r modes.
    rows : (r,) Index
        Index of each of these modes among those of all bodies: first those of ``mounted``, then those of the fixed nuts.
    """
    screw, carried, held = 0, sum(p.setup.screw.stretch.modes for p in sets), len(mounted.G)
    couplings, blocks, modes, rows = [mounted.G], list[BallBlock](), list[Array](), list[Index]()
    for p in sets:
        nut = p.setup.nut
        first = (screw, held if p.housing is None else carried)
        block = compliance_block_of_ball(p.setup, p.sides, rigid=bool(leave_out & {"finite ball", "patch coupling"}))
        for i in range(p.ball_count):
            pieces = []
            for nodes, s in p.node_slices_of_flanks:
                if (body := p.setup.body(s)) is not None:
                    V = np.zeros((p.nodes_per_ball, body.modes[s].shape[1]))
                    V[nodes] = body.modes[s]
                    pieces.append(V)
                    rows.append(first[s >= 2] + body.mode_indices_of_contact(s, i))
            blocks.append(block)
            modes.append(np.hstack(pieces))
        screw += p.setup.screw.stretch.modes
        if nut is not None and p.housing is None:
            couplings.append(keep_local_response(nut.G, nut) if leave_out & {"elastic nut", "patch coupling"} else nut.G)
            held += len(nut.G)
        elif nut is not None:
            carried += len(nut.G)
    pick = np.concatenate(rows)
    return compliance_of_coupled_balls(blocks, modes, block_diag(*couplings)[np.ix_(pick, pick)]), pick


def compliance_block_of_ball(setup: Setup, sides: tuple[int, ...], *, rigid: bool) -> BallBlock:
    """Return the compliance between the contact nodes of one ball, including the local compliance of its grooves.

    Parameters
    ----------
    setup : Setup
        Meshed and condensed parts of one geometry.
    sides : tuple[int, ...]
        Groove flanks (0, 1: screw, 2, 3: nut) whose contact nodes are included.
    rigid : bool
        Whether the ball is rigid apart from its local compliance at each contact.

    Returns
    -------
    BallBlock
        Compliance between the contact nodes of these flanks.
    """
    local = tuple(setup.patches[s].local for s in sides)
    ball = setup.ball
    if rigid:
        return BallBlock(local, tuple(np.zeros((len(a), 0)) for a in local), np.zeros((0, 0)))
    pick = np.concatenate([ball.mode_indices_of_contact(s) for s in sides])
    return BallBlock(local, tuple(ball.modes[s] for s in sides), ball.G[np.ix_(pick, pick)])


def keep_local_response(G: Array, body: ModalBody) -> Array:
    """Set the compliance of a body to zero between different contacts, so that each load moves only its own contact.

    Every contact keeps its response to its own load, averaged over all contacts of its flank.

    Parameters
    ----------
    G : (m, m) Array
        Compliance between the displacement modes of all contacts of the elastic body [m/N].
    body : ModalBody
        The condensed body.

    Returns
    -------
    (m, m) Array
        Compliance with one block for each contact, zero between contacts [m/N].
    """
    out = np.zeros_like(G)
    for s in body.modes:
        own = [
            np.ix_(rows, rows)
            for rows in (body.mode_indices_of_contact(s, i) for i in range(len(G) // body.modes_per_ball))
        ]
        mean = np.mean([G[block] for block in own], axis=0)
        for block in own:
            out[block] = mean
    return out


def mount_screw(setup: Setup, scene: Scene, leave_out: frozenset[str] = frozenset()) -> MountedShaft:
    """Compute the compliance between the screw's contacts when the screw stands on the supports of a scene.

    If the 3D shaft is left out of the model, the screw is a beam with the same local response at its contacts.

    Parameters
    ----------
    setup : Setup
        Meshed and condensed parts of one geometry.
    scene : Scene
        Supports and loads.
    leave_out : frozenset[str], optional
        Names of the parts of the model that are left out, from `hifi.reference.INGREDIENTS`.

    Returns
    -------
    MountedShaft
        Compliance of the supported screw at its contacts, and its displacement under the loads.
    """
    full, m = setup.screw.stretch, setup.screw.stretch.modes
    if not leave_out & {"3D shaft", "patch coupling"} or full.rigid:
        return mount_stretch(full, scene, setup.section)
    stations = np.repeat(setup.layout.z, len(setup.screw.modes))
    beam = replace_stretch_by_beam(setup.screw.rigid, stations, full, setup.section)
    F = beam.F.copy()
    F[:m, :m] += keep_local_response(full.F[:m, :m] - beam.F[:m, :m], setup.screw)
    return mount_stretch(replace(beam, F=F), scene, setup.section)


def normal_motion_by_modes(C: Compliance, z: Array) -> Array:
    """Compute the motion of every contact node along its normal from the displacements of the contacts' modes.

    Parameters
    ----------
    C : Compliance
        Compliance of n contact nodes.
    z : (r,) Array
        Displacements of the modes of the compliance [m].

    Returns
    -------
    (n,) Array
        Motions of the contact nodes along their normals [m].
    """
    return np.concatenate([V @ z[c] for V, c in zip(C.modes, C.columns, strict=True)])


def expected_touching_nodes(p: PlacedSet, gap: Array) -> Array:
    """Return which contact nodes are expected to touch: on each flank, the third of its nodes with the smallest gaps.

    Parameters
    ----------
    p : PlacedSet
        Nut or bearing with its condensed parts, at its place on the shaft.
    gap : (balls, n) Array
        Gaps at the n contact nodes of each ball [m].

    Returns
    -------
    (balls, n) Mask
        Whether each node is expected to touch.
    """
    out = np.zeros(gap.shape, dtype=bool)
    for nodes, _ in p.node_slices_of_flanks:
        gaps = gap[:, nodes]
        third = gaps.shape[1] // 3
        out[:, nodes] = gaps < np.partition(gaps, third, axis=1)[:, third, None]
    return out


def average_over_pressure_functions(p: PlacedSet, values: Array) -> Array:
    """Average values at the contact nodes, with the pressure basis function of each node as weight.

    Parameters
    ----------
    p : PlacedSet
        Nut or bearing with its condensed parts, at its place on the shaft.
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
        mean = normalise_rows_of_weights(p.setup.patches[s].groove.weights) @ by_node.reshape(len(by_node), -1)
        out[:, nodes] = np.moveaxis(mean.reshape(by_node.shape), 0, 1)
    return out


def gap_corrections_for_grid_positions(p: PlacedSet, forces: Array, directions: Array) -> Array:
    """Compute corrections of all gaps that remove the discretisation error due to each contact's position on its mesh grid.

    They are interpolated in the tables of `hifi.bodies.grid_wave`.

    Parameters
    ----------
    p : PlacedSet
        Nut or bearing with its condensed parts, at its place on the shaft.
    forces : (balls, n) Array
        Contact forces at the n contact nodes of each ball [N].
    directions : (balls, n, 3) Array
        Contact normals at the nodes.

    Returns
    -------
    (balls, n) Array
        Corrections to be added to the gaps [m].
    """
    out = np.zeros_like(forces)
    for nodes, s in p.node_slices_of_flanks:
        pair = p.setup.patches[s]
        if pair.wave is not None:
            pressed = forces[:, nodes]
            centres = (pressed @ pair.groove.points) / np.maximum(pressed.sum(axis=1), 1e-300)[:, None]
            loads = np.linalg.norm(np.einsum("ic,icx->ix", pressed, directions[:, nodes]), axis=1)
            out[:, nodes] = pair.wave.at(loads, centres)[:, None]
    return out


def ball_centre_to_groove_nodes(p: PlacedSet, drawn: Specimen) -> Array:
    """Return the vectors from the nominal centre of each ball to the contact nodes of its grooves, in the ball's frame.

    The nominal groove is changed by the manufacturing errors at each ball and by the axial shift of the nut.

    Parameters
    ----------
    p : PlacedSet
        Nut or bearing with its condensed parts, at its place on the shaft.
    drawn : Specimen
        Radii of balls and grooves with their manufacturing errors.

    Returns
    -------
    (balls, n, 3) Array
        Vectors to the n contact nodes of each ball [m].
    """
    m = p.setup.map
    x3, _, z3 = m.axes()
    nominal_centres, radii = nominal_groove_centres(p.setup.scene), nominal_groove_radii(p.setup.scene)
    rows = []
    for s in p.sides:
        local = p.setup.patches[s].groove.points - np.array([m.R, 0.0, 0.0])
        offset = drawn.centre[:, s] - nominal_centres[s]
        shift = offset[:, :1, None] * x3 + offset[:, 1:, None] * z3
        gamma, _ = m.section_to_polar(s, local @ x3, local @ z3)
        inward = radii[s] - groove_radius_with_slopes(gamma, drawn.radius[s], drawn.profile[s])[0]
        sx, sz = m.signs[s]
        outward = sx * np.cos(gamma)[:, None] * x3 + sz * np.sin(gamma)[:, None] * z3
        by_nut = p.offset * np.cos(m.alpha) * z3 if s >= 2 else np.zeros(3)
        rows.append(local + (shift - (inward[:, None] * outward)[None]) + by_nut)
    return np.concatenate(rows, axis=1)


def gap_closing_matrix(directions: Sequence[Array], free_motions: Array) -> sp.csr_array:
    """Assemble the matrix N: the gap that each contact pair loses by unit rigid motions of balls, shaft and housings.

    Parameters
    ----------
    directions : Sequence[Array]
        Contact normals of every nut or bearing ``(balls, n, 3)``.
    free_motions : (pairs, k) Array
        Motion of the grooves' nodes along their normals by the k rigid motions of shaft and housings that no support
        prevents.

    Returns
    -------
    (pairs, 3 balls + k) sparse array
        Gap closed at each contact pair by three unit displacements of each ball, then by the k rigid motions.
    """
    balls = sp.block_diag([sp.csr_array(normals) for of_set in directions for normals in of_set])
    return sp.hstack([balls, sp.csr_array(-free_motions)]).tocsr()


def rigid_body_normal_motion(p: PlacedSet, directions: Array, origin: float, *, screw: bool) -> Array:
    """Compute how far contact nodes of screw or nut move along their normals by unit rigid motions of that body.

    Parameters
    ----------
    p : PlacedSet
        Nut or bearing with its condensed parts, at its place on the shaft.
    directions : (balls, n, 3) Array
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
    layout = p.setup.layout
    out = np.zeros((*directions.shape[:2], 6))
    for nodes, s in p.node_slices_of_flanks:
        if (s < 2) != screw:
            continue
        for i in range(p.ball_count):
            R = rotation_about_z(float(layout.azimuth[i]))
            x = p.setup.patches[s].groove.points @ R.T + np.array([0.0, 0.0, layout.z[i] - (origin - p.shift)])
            d = directions[i, nodes] @ R.T
            out[i, nodes, :3], out[i, nodes, 3:] = d, np.cross(x, d)
    return out


def ball_motion_relative_to_grooves(p: PlacedSet, balls: Array, along: Array, directions: Array) -> tuple[Array, Array]:
    """Compute the displacement of each ball's centre relative to each of its groove flanks, across and along the track.

    The part across the track turns the contact normals. The part along the track has no effect: a groove is invariant
    under its helical motion, which changes no gap and in which frictionless contact forces do no work, so that every
    contact stays level with its ball.

    Linear kinematics alone would err here: a screw that winds up by an angle theta moves its contacts R theta/2 along
    the track and R theta^2/2 out of their section. The motion could also be taken from the centre of pressure, but
    under a light contact that closes few nodes of the grid the centre of pressure sticks to them, or jumps.

    Parameters
    ----------
    p : PlacedSet
        Nut or bearing with its condensed parts, at its place on the shaft.
    balls : (balls, 3) Array
        Motions of the ball centres [m].
    along : (balls, n) Array
        Motions of the grooves' nodes along their normals, which the modes and rigid motions of the bodies cause [m].
    directions : (balls, n, 3) Array
        Contact normals at the nodes.

    Returns
    -------
    shift : (balls, n, 3) Array
        Displacement across the track, in the plane of its section [m].
    slid : (balls, n) Array
        Displacement along the track, less its mean over the flanks of the ball [m].
    """
    motion = np.zeros((len(balls), len(p.node_slices_of_flanks), 3))
    for k, (nodes, _) in enumerate(p.node_slices_of_flanks):
        for i in range(len(balls)):
            motion[i, k] = balls[i] - np.linalg.lstsq(directions[i, nodes], along[i, nodes], rcond=1e-6)[0]
    y3 = p.setup.map.axes()[1]
    slid = motion @ y3
    shift = motion - slid[..., None] * y3
    sizes = [nodes.stop - nodes.start for nodes, _ in p.node_slices_of_flanks]
    return np.repeat(shift, sizes, axis=1), np.repeat(slid - slid.mean(axis=1, keepdims=True), sizes, axis=1)


def helical_motion_at_nodes(p: PlacedSet) -> Array:
    """Return the velocity field of the screw motion along the track at the n contact nodes of a ball ``(n, 3)``.

    The velocities are in the ball's frame, and scaled so that the speed at the ball's centre is 1.
    """
    m = p.setup.map
    x = np.concatenate([p.setup.patches[s].groove.points for s in p.sides])
    return np.asarray(np.stack([-x[:, 1], x[:, 0], np.full(len(x), m.rg)], axis=1) * (np.cos(m.alpha) / m.R))
