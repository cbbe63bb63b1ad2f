"""Compliance of screw, nut and balls of the 3D reference under contact loads, by static condensation.

Each body is meshed coarsely, with a refinement box (a pocket that a fine patch fills) at every contact, and condensed to
a few displacement modes of each contact. The part of the screw that is meshed in 3D is also condensed to its upper end and
to its supports and loads. The local compliance of a contact is computed once for each flank, from the patches of its groove
and its ball.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy.sparse as sp
from skfem import Mesh, condense
from skfem.models.poisson import mass

from rollbench.hifi.bodies import coarse
from rollbench.hifi.bodies.coarse import BodySocket, ContactSubmodel, contact_modes_of_patch, degrees_of_freedom_of_nodes
from rollbench.hifi.bodies.grid_wave import GapCorrectionTable, tabulate_gap_corrections
from rollbench.hifi.bodies.patch import CondensedPatch, condense_patch
from rollbench.hifi.elements.forms import cell_basis
from rollbench.hifi.elements.rigid import nodal_displacements_of_rigid_motions, rigid_motion_transfer_along_z
from rollbench.hifi.linear_algebra import symmetric_compliance_of_loads
from rollbench.hifi.meshing import part_meshes
from rollbench.hifi.meshing.settings import Settings
from rollbench.hifi.shaft.mounting import MeshedShaftPart
from rollbench.meshes import sockets
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.ball_body import CoarseBallMesh, mesh_ball_with_refinement_boxes
from rollbench.meshes.fem import degrees_of_freedom_on_boundaries, node_coordinates, nodes_on_boundaries
from rollbench.meshes.groove import GroovedBodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import CoarseGroovedBodyMesh, mesh_grooved_body
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import Material, Nut, Scene
from rollbench.meshes.solid import Dimensions

#: Length of a submodel on either side of its refinement box, over the ball's radius, within which the coarse mesh's error
#: decays.
BEYOND = 1.5

#: Factors on coordinates x, y, z by a turn of 180 degrees about the radius through a ball at azimuth 0, which maps left
#: flanks onto right ones.
TURN = np.array([1.0, -1.0, -1.0])

#: Condensed fine meshes (patches) at the contacts of each flank, by the number of the flank.
Patches = dict[int, CondensedPatch]

#: Piece of a body around one contact, and the faces of its refinement box.
Piece = tuple[ContactSubmodel, sockets.RefinementBoxFaces]

SideArguments = tuple[GrooveMap, int, tuple[float, float], tuple[Material, Material], part_meshes.FlankSockets, Settings]


@dataclass(frozen=True)
class FlankPatches:
    """Condensed fine meshes (patches) of groove and ball at the contact on one flank, which are the same for all balls.

    The contact nodes of groove and ball coincide.
    """

    #: Condensed fine mesh (patch) of the groove at the contact.
    groove_patch: CondensedPatch
    #: Condensed fine mesh (patch) of the ball at the contact.
    ball_patch: CondensedPatch
    #: Local compliance of ball and groove between the c contact nodes, less the part that the displacement modes of the
    #: coarse bodies represent ``(c, c)`` [m/N] (`hifi.bodies.coarse`).
    local_compliance: Array
    #: Correction of the gap between ball and groove for the position of the contact's centre relative to the nodes of the
    #: mesh; None: no correction.
    gap_correction: GapCorrectionTable | None


def collect_flank_condensation_arguments(
    scene: Scene, m: GrooveMap, dims: Dimensions, meshes: part_meshes.PartMeshes, side: int, settings: Settings
) -> SideArguments:
    """Return the arguments of `condense_patches_of_flank`, in their order, for one flank of a ball screw or bearing.

    ``m``: geometry of the track; ``dims``: dimensions of the solid parts; ``meshes``: meshes of the parts; ``side``: flank
    0 to 3; ``settings``: mesh settings.
    """
    part, inner = (scene.screw, dims.hole) if side < 2 else (scene.nut, dims.land)
    radii, materials = (inner, part.outer_diameter / 2.0), (part.material, scene.balls.material)
    return m, side, radii, materials, meshes.refinement_boxes_of_flank(side), settings


def condense_patches_of_flank(
    m: GrooveMap,
    side: int,
    body_radii: tuple[float, float],
    materials: tuple[Material, Material],
    boxes: part_meshes.FlankSockets,
    settings: Settings,
) -> FlankPatches:
    """Condense the fine meshes (patches) of groove and ball at one flank, and compute the local compliance of the contact.

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
    body_radii : tuple[float, float]
        Inner and outer radius of the grooved body [m]: hole and outer radius of the screw, or land and outer radius of the
        nut.
    materials : tuple[Material, Material]
        Materials of the grooved body and of the ball.
    boxes : FlankSockets
        Refinement boxes of groove and ball.
    settings : Settings
        Mesh settings: cell sizes, modes and element type.

    Returns
    -------
    FlankPatches
        Condensed fine meshes (patches) of groove and ball, and their local compliance.

    Raises
    ------
    ValueError
        The contact nodes of groove and ball do not match, or a submodel cannot be meshed.
    """
    size = boxes.socket_size
    on_groove = partial(sockets.points_in_box_at_azimuth_zero, m, size, side)
    ball_box, on_ball = part_meshes.ball_refinement_box_and_map(m, size, side, boxes.relative_zone_size)
    mesh = part_meshes.mesh_patch(boxes, boxes.groove_socket, on_groove, settings)
    ball_mesh = part_meshes.mesh_patch(boxes, boxes.ball_socket, on_ball, settings)
    normals = part_meshes.contact_normals_of_patch(mesh, np.array([m.R, 0.0, 0.0]))
    ball_normals = part_meshes.contact_normals_of_patch(ball_mesh, np.zeros(3))
    spread = float(np.abs(ball_normals - normals).max())
    if spread > 1e-9:
        raise ValueError(
            f"the contact nodes of the meshes of ball and groove do not match: their unit normals differ by {spread:.1e}; "
            "allowed: up to 1e-9"
        )
    of_body, of_ball = ((x.youngs_modulus, x.poissons_ratio) for x in materials)
    carrier = part_meshes.mesh_coarser_patch(boxes, boxes.groove_socket, on_groove, settings)
    groove = condense_patch(mesh, normals, *of_body, carrier)
    carrier = part_meshes.mesh_coarser_patch(boxes, boxes.ball_socket, on_ball, settings)
    ball = condense_patch(ball_mesh, -normals, *of_ball, carrier)
    if settings.element == "P1":  # the mesh of Lin's thesis is not changed
        return FlankPatches(groove, ball, groove.A + ball.A, None)

    def mesh_groove_piece(box: sockets.RefinementBoxSize, near: float, far: float) -> Piece:
        half = max(sockets.axial_reach_of_refinement_boxes(m, size, (side,))) + BEYOND * m.ball
        ends, place = (m.z0 - half, m.z0 + half), (m.phase, m.z0, side)
        spec = GroovedBodySpec(*body_radii, *ends, side < 2, (place,), box, near, far)
        body: CoarseGroovedBodyMesh = mesh_grooved_body(m, spec)
        turn, fixed = part_meshes.rotation_about_z(m.phase), ("low end", "high end")
        return ContactSubmodel(body.mesh, body.nodes_on_box_faces[0], turn, fixed), body.box_faces[side]

    def mesh_ball_piece(box: sockets.RefinementBoxSize, near: float, far: float) -> Piece:
        body = mesh_ball_with_refinement_boxes(m, (ball_box,), near, far, box.edge_divisions)
        return ContactSubmodel(body.mesh, body.nodes_on_box_faces[side], np.eye(3), ()), body.box_faces[side]

    fine_box = replace(size, edge_divisions=settings.own_cuts)
    coarse_sizes, ball_sizes = (settings.fine, settings.coarse), (settings.ball_fine, settings.ball_coarse)
    local, total = np.zeros_like(groove.A), np.zeros_like(groove.A)
    for mesh_piece, to_space, condensed, along, elastic, modes, fine_sizes, sizes in (
        (mesh_groove_piece, on_groove, groove, normals, of_body, settings.modes, settings.own_sizes, coarse_sizes),
        (mesh_ball_piece, on_ball, ball, -normals, of_ball, settings.ball_modes, settings.own_ball_sizes, ball_sizes),
    ):
        piece, box_faces = mesh_piece(fine_box, *fine_sizes)
        fine_mesh = part_meshes.mesh_patch(boxes, box_faces, to_space, settings)
        C = coarse.contact_compliance_in_fine_submodel(piece, fine_mesh, along, *elastic)
        V, rows = contact_modes_of_patch(condensed, modes)
        scales = [1.0 + coarse.STEP * n for n in range(coarse.REALISATIONS)]
        pieces = [mesh_piece(size, scale * sizes[0], scale * sizes[1])[0] for scale in scales]
        G = [coarse.mode_compliance_in_coarse_submodel(each, condensed, rows, *elastic) for each in pieces]
        local += coarse.local_contact_compliance(C, V, G)
        total += C
    return FlankPatches(groove, ball, local, tabulate_gap_corrections(m, side, groove, total, materials[1]))


def is_left_flank_after_half_turn(m: GrooveMap, side: int) -> bool:
    """Return whether a flank is a right flank that coincides with its groove's left flank after a turn by 180 degrees.

    The axis of the turn is the radius through the ball's centre.

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.

    Returns
    -------
    bool
        True for a right flank with the groove radius of the left flank; False for a left flank.
    """
    return side % 2 == 1 and float(m.radius[side]) == float(m.radius[side - 1])


def turn_patches_to_right_flank(patches: FlankPatches) -> FlankPatches:
    """Turn the patches of a left flank by 180 degrees about the radius through the ball's centre, onto the right flank.

    The contact nodes are reordered, because the turn reverses azimuths.

    Parameters
    ----------
    patches : FlankPatches
        Patches of the left flank.

    Returns
    -------
    FlankPatches
        Patches of the right flank.
    """
    shape = patches.groove_patch.contact_grid_shape
    assert shape is not None  # a grid
    order = np.arange(shape[0] * shape[1]).reshape(shape)[:, ::-1].ravel()

    def turn_patch(patch: CondensedPatch) -> CondensedPatch:
        signs = np.tile(TURN, patch.H.shape[1] // 3)
        return replace(
            patch,
            A=patch.A[np.ix_(order, order)],
            H=patch.H[order] * signs,
            S=patch.S * np.outer(signs, signs),
            contact_points=patch.contact_points[order] * TURN,
            normals=patch.normals[order] * TURN,
            nodal_areas=patch.nodal_areas[order],
            on_zone_edge=patch.on_zone_edge[order],
            pressure_weights=patch.pressure_weights[order][:, order],
            socket_points=patch.socket_points * TURN,
        )

    wave = patches.gap_correction
    if wave is not None:
        wave = replace(wave, middle_node=wave.middle_node * TURN, grid_directions=wave.grid_directions * TURN)
    groove, ball = turn_patch(patches.groove_patch), turn_patch(patches.ball_patch)
    return FlankPatches(groove, ball, patches.local_compliance[np.ix_(order, order)], wave)


#: Boundaries of the nut's mesh that are fixed, by ``Solid.nut_held``.
NUT_HELD = {
    "outer surface": ("outside",),
    "left face": ("low end",),
    "right face": ("high end",),
    "both faces": ("low end", "high end"),
    "flange face": ("seat",),
}

#: Text at the end of ``Dimensions.nut_held`` if the flange's centring fit is bonded as well.
FIT = " and centring"

#: Half the thickness of the slice whose mean motion counts as the motion of a cross-section, over the screw's radius; least
#: number of cells in such a slice.
SLICE, LEAST = 0.25, 30


@dataclass(frozen=True)
class CondensedBody:
    """Base class of an elastic body condensed to displacement modes of its contacts, ordered by ball, then by flank."""

    #: For each flank (0, 1: screw, 2, 3: nut), the k displacement modes V of a contact at its c contact nodes ``(c, k)``.
    modes_by_flank: dict[int, Array]
    #: Number of degrees of freedom before condensation.
    degree_of_freedom_count: int

    @property
    def modes_per_ball(self) -> int:
        """Number of displacement modes that this body has at the contacts of one ball, all flanks together."""
        return sum(V.shape[1] for V in self.modes_by_flank.values())

    def mode_indices_of_contact(self, side: int, ball: int = 0) -> Index:
        """Return the rows of the body's modal compliance matrix that belong to one contact's displacement modes.

        Parameters
        ----------
        side : int
            Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
        ball : int, default 0
            Number of the ball, from 0.

        Returns
        -------
        (k,) Index
            Indices of the contact's k modes among the rows, and columns, of that matrix.
        """
        before = sum(V.shape[1] for V in list(self.modes_by_flank.values())[: list(self.modes_by_flank).index(side)])
        return np.asarray(ball * self.modes_per_ball + before + np.arange(self.modes_by_flank[side].shape[1]))

    def compliance_blocks_of_contacts(self, side: int, ball_count: int) -> list[tuple[Index, ...]]:
        """Return the indices of the block that each ball's contact on a flank has in the body's modal compliance matrix.

        ``side``: groove flank (0 to 3); ``ball_count``: number of balls. The indices are those of `numpy.ix_`.
        """
        return [np.ix_(rows, rows) for rows in (self.mode_indices_of_contact(side, i) for i in range(ball_count))]


@dataclass(frozen=True)
class CondensedScrew(CondensedBody):
    """Compliance of the part of the screw that is meshed in 3D, condensed to its contacts, upper end, supports and loads.

    In a `CondensedGeometry` the compliance is corrected for the effect of cutting the shaft at the ends of this part.
    """

    #: Compliance of this part of the screw at its contacts, upper end, supports and loads.
    stretch: MeshedShaftPart
    #: Displacements of every contact's modes by unit rigid motions of the screw (translations and rotations about the
    #: contact's axial position) ``(contacts, k, 6)``.
    modes_by_rigid_motions: Array

    @property
    def G(self) -> Array:
        """Compliance matrix between the displacement modes of all contacts of the screw [m/N]."""
        return self.stretch.F[: self.stretch.mode_count, : self.stretch.mode_count]


@dataclass(frozen=True)
class CondensedNut(CondensedBody):
    """Compliance of the nut, condensed to displacement modes of its contacts; the scene defines which surface is fixed."""

    #: Compliance matrix between the displacement modes of all contacts of the nut [m/N].
    G: Array
    #: Displacements of the modes of all contacts by unit rigid motions of the nut (translations and rotations about the
    #: point z = 0 of the axis) ``(k, 6)``.
    modes_by_rigid_motions: Array


@dataclass(frozen=True)
class CondensedBall(CondensedBody):
    """Compliance of one ball, condensed to displacement modes of its contacts, with its six rigid motions constrained."""

    #: Compliance matrix between the displacement modes of the ball's contacts, flank after flank [m/N].
    G: Array


def assemble_stiffness_and_contact_modes(
    material: Material, mesh: Mesh, boxes: list[BodySocket], patches: Patches, count: int, settings: Settings
) -> tuple[sp.csc_array, sp.csr_array, dict[int, tuple[Array, Array]]]:
    """Assemble the stiffness of a body with its condensed fine meshes (patches), and its contacts' displacement modes.

    Parameters
    ----------
    material : Material
        Elastic material.
    mesh : Mesh
        Coarse body.
    boxes : list[BodySocket]
        Refinement boxes of the body: pockets of its coarse mesh that the fine patches fill.
    patches : Patches
        Condensed fine mesh (patch) at the contacts of each flank.
    count : int
        Number of displacement modes of every contact.
    settings : Settings
        Mesh settings: cell sizes, modes and element type.

    Returns
    -------
    K : (n, n) sparse array
        Stiffness of the body with all its patches, on its n degrees of freedom [N/m].
    rows : (r, n) sparse array
        Rows Q of the r modes of all refinement boxes on these degrees of freedom, box after box.
    by_flank : dict[int, tuple[Array, Array]]
        For each flank, the modes V and their rows Q, both in the frame of the patch.
    """
    body = coarse.convert_mesh_order(mesh, part_meshes.element_type_of_bodies(settings))
    K = coarse.assemble_body_stiffness(body, boxes, patches, material.youngs_modulus, material.poissons_ratio)
    kept = {s: contact_modes_of_patch(p, count) for s, p in patches.items()}
    return K, coarse.assemble_mode_forces(boxes, {s: k[1] for s, k in kept.items()}, K.shape[0]), kept


def condense_ball(
    material: Material, mesh: CoarseBallMesh, patches: dict[int, FlankPatches], settings: Settings
) -> CondensedBall:
    """Condense the mesh of one ball to displacement modes of its contacts, with its rigid motions constrained.

    The six constraints carry no force, because the loads on a ball balance.

    Parameters
    ----------
    material : Material
        Elastic material.
    mesh : CoarseBallMesh
        Mesh of the ball.
    patches : dict[int, FlankPatches]
        Condensed fine meshes (patches) at the contacts of each flank.
    settings : Settings
        Mesh settings: cell sizes, modes and element type.

    Returns
    -------
    CondensedBall
        The condensed ball.
    """
    ball_patches = {s: p.ball_patch for s, p in patches.items()}
    boxes = [BodySocket(mesh.nodes_on_box_faces[s], np.eye(3), s) for s in ball_patches]
    modes = settings.ball_modes
    K, rows, kept = assemble_stiffness_and_contact_modes(material, mesh.mesh, boxes, ball_patches, modes, settings)
    held = coarse.select_isostatic_freedoms(mesh.points, np.concatenate([box.node_indices for box in boxes]))
    free = np.setdiff1d(np.arange(K.shape[0]), held)
    G = symmetric_compliance_of_loads(condense(K, D=held, expand=False), rows[:, free])
    return CondensedBall({s: k[0] for s, k in kept.items()}, int(free.size), G)


def condense_screw(
    material: Material,
    nut: Nut,
    end_positions: tuple[float, float],
    stations_inside: Sequence[float],
    mesh: CoarseGroovedBodyMesh,
    layout: BallLayout,
    sides: tuple[int, ...],
    patches: Patches,
    settings: Settings,
    dims: Dimensions,
) -> CondensedScrew:
    """Condense the part of the screw that is meshed in 3D to its contacts, upper end, supports and loads.

    That part is fixed at its bore (a ring on a stiff shaft) or at its lower end.

    Parameters
    ----------
    material : Material
        Elastic material.
    nut : Nut
        The nut; the motion of the screw is computed at five sections, from one face of the nut to the other.
    end_positions : tuple[float, float]
        Axial positions of the ends of that part [m].
    stations_inside : Sequence[float]
        Axial positions of the supports and loads that lie within that part [m].
    mesh : CoarseGroovedBodyMesh
        Mesh of that part.
    layout : BallLayout
        Positions of the balls.
    sides : tuple[int, ...]
        Groove flanks (0, 1: screw, 2, 3: nut) that carry contacts.
    patches : Patches
        Condensed fine mesh (patch) at the contacts of each flank of the screw.
    settings : Settings
        Mesh settings: cell sizes, modes and element type.
    dims : Dimensions
        Dimensions of the solid parts.

    Returns
    -------
    CondensedScrew
        The condensed screw.
    """
    places = part_meshes.contact_positions_on_body(layout, sides, True)
    boxes = part_meshes.refinement_boxes_at_contact_azimuths(mesh, places)
    K, modes, kept = assemble_stiffness_and_contact_modes(material, mesh.mesh, boxes, patches, settings.modes, settings)
    low, high = end_positions
    bore = dims.screw_held == "bore"
    T = screw_freedoms_from_free_ones(mesh, dims, high)
    base = nut.position if bore else low
    ports = () if bore else (high, *stations_inside)
    on_nut = tuple(float(nut.position + x * nut.length / 2.0) for x in (-1.0, -0.5, 0.0, 0.5, 1.0))
    observers = () if bore else on_nut
    rows = modes @ T
    if not bore:
        end = sp.eye_array(T.shape[1], format="csr")[-6:]
        follow = [section_motion_matrix(mesh.mesh, z) @ T for z in (*stations_inside, *observers)]
        rows = sp.vstack([rows, end, *follow]).tocsr()
    K = (T.T @ K @ T).tocsc()  # frees the stiffness of the free body: a gigabyte with 400 contacts
    F = symmetric_compliance_of_loads(K, rows)
    rigid = np.asarray(modes @ nodal_displacements_of_rigid_motions(mesh.points, np.array([0.0, 0.0, base])))
    B = np.concatenate([rigid, *(rigid_motion_transfer_along_z(z - base) for z in (*ports, *observers))])
    stretch = MeshedShaftPart(F, B, base, ports, observers, (low, high), modes.shape[0], moves_with_base=bore)
    starts = np.concatenate([[0], np.cumsum([kept[p[2]][1].shape[0] for p in places])])
    least = min(k[1].shape[0] for k in kept.values()) if kept else 0
    about = np.zeros((len(places), least, 6))
    for i, (_, z, _) in enumerate(places):
        about[i] = rigid[starts[i] : starts[i] + least] @ rigid_motion_transfer_along_z(base - z)
    return CondensedScrew({s: k[0] for s, k in kept.items()}, T.shape[1], stretch, about)


def section_motion_matrix(mesh: Mesh, z: float) -> sp.csr_array:
    """Return the matrix that gives the mean rigid motion of a thin cross-sectional slice of the screw from its nodes.

    The motion is fitted to the nodal displacements by least squares over the slice's volume. The transposed matrix
    distributes a force or moment on the cross-section over the nodes, in proportion to rigid motions.

    Parameters
    ----------
    mesh : Mesh
        Mesh of the screw.
    z : float
        Axial position of the section [m].

    Returns
    -------
    (6, freedoms) sparse array
        Rows that give the three translations [m] and three rotations [rad] of the section.
    """
    points, corners = node_coordinates(mesh), mesh.p[2, mesh.t]
    radius = float(np.hypot(points[:, 0], points[:, 1]).max())
    away = np.abs(corners.mean(axis=0) - z)
    reach = max(SLICE * radius, float(np.partition(away, LEAST)[LEAST]))
    volume = mass.assemble(cell_basis(mesh, elements=np.flatnonzero(away <= reach)))
    nodes = np.flatnonzero(volume.diagonal())
    rigid = nodal_displacements_of_rigid_motions(points[nodes], np.array([0.0, 0.0, z]))
    carried = (volume[nodes][:, nodes] @ rigid.reshape(nodes.size, 18)).reshape(-1, 6)
    motion = np.linalg.solve(rigid.T @ carried, carried.T)
    place = (np.repeat(np.arange(6), 3 * nodes.size), np.tile(degrees_of_freedom_of_nodes(nodes), 6))
    return sp.csr_array((motion.ravel(), place), (6, 3 * len(points)))


def screw_freedoms_from_free_ones(mesh: CoarseGroovedBodyMesh, dims: Dimensions, high: float) -> sp.csc_array:
    """Return the matrix that gives all degrees of freedom of the screw's 3D mesh from its free degrees of freedom.

    ``mesh``: mesh of the screw's part; ``dims``: dimensions, which say whether the bore of the screw is fixed; ``high``:
    axial position of the upper end [m]. If the bore is not fixed, the lower end is, and the upper end is a rigid section,
    whose six motions about its centre come last.
    """
    if dims.screw_held == "bore":
        return coarse.all_freedoms_from_free_ones(mesh.mesh, degrees_of_freedom_on_boundaries(mesh.mesh, "bore"))
    return coarse.all_freedoms_with_rigid_end(mesh.mesh, high)


def points_clamped_by_bolts(x: Array, y: Array, seat: tuple[float, float], count: int) -> Array:
    """Find which points of a nut flange's face lie in the circular areas clamped by the flange's bolts.

    Parameters
    ----------
    x, y : (n,) Array
        Coordinates of the points [m].
    seat : tuple[float, float]
        Inner and outer radius of the flange's contact face [m]; the circles touch both radii.
    count : int
        Number of bolts, the first at azimuth 0.

    Returns
    -------
    (n,) Array of bool
        Whether each point lies within a circle.

    Examples
    --------
    >>> points_clamped_by_bolts(np.array([40e-3, 0.0]), np.array([0.0, 40e-3]), (35e-3, 45e-3), 2).tolist()
    [True, False]
    """
    middles = 0.5 * sum(seat) * np.exp(2j * np.pi / count * np.arange(count))
    return np.asarray((np.abs((x + 1j * y)[:, None] - middles) <= 0.5 * (seat[1] - seat[0]) + 1e-7).any(axis=1))


def nut_freedoms_from_free_ones(mesh: CoarseGroovedBodyMesh, dims: Dimensions) -> sp.csc_array:
    """Return the matrix that gives all degrees of freedom of the nut's mesh from its free degrees of freedom.

    ``dims``: dimensions of the solid parts; their field `Dimensions.nut_held` names the fixed surface of the nut.
    """
    surface, _, bolts = dims.nut_held.partition(", ")
    fit = surface.endswith(FIT) or (surface == "outer surface" and "centring" in (mesh.mesh.boundaries or {}))
    nodes = nodes_on_boundaries(mesh.mesh, *NUT_HELD[surface.removesuffix(FIT)])
    low, high = dims.held_radii
    x, y = mesh.points[nodes, 0], mesh.points[nodes, 1]
    on = (np.hypot(x, y) >= low - 1e-7) & (np.hypot(x, y) <= high + 1e-7)
    if bolts:
        on &= points_clamped_by_bolts(x, y, (low, high), int(bolts.split()[0]))
    held_nodes = np.union1d(nodes[on], nodes_on_boundaries(mesh.mesh, "centring")) if fit else nodes[on]
    held = degrees_of_freedom_of_nodes(held_nodes)
    return coarse.all_freedoms_from_free_ones(mesh.mesh, held)


def condense_nut(
    material: Material,
    mesh: CoarseGroovedBodyMesh,
    layout: BallLayout,
    sides: tuple[int, ...],
    patches: Patches,
    settings: Settings,
    dims: Dimensions,
) -> CondensedNut:
    """Condense the mesh of the nut to displacement modes of its contacts, with the surface fixed that ``dims`` names.

    Parameters
    ----------
    material : Material
        Elastic material.
    mesh : CoarseGroovedBodyMesh
        Mesh of the nut.
    layout : BallLayout
        Positions of the balls.
    sides : tuple[int, ...]
        Groove flanks (0, 1: screw, 2, 3: nut) that carry contacts.
    patches : Patches
        Condensed fine mesh (patch) at the contacts of each flank of the nut.
    settings : Settings
        Mesh settings: cell sizes, modes and element type.
    dims : Dimensions
        Dimensions of the solid parts.

    Returns
    -------
    CondensedNut
        The condensed nut.
    """
    places = part_meshes.contact_positions_on_body(layout, sides, False)
    boxes = part_meshes.refinement_boxes_at_contact_azimuths(mesh, places)
    K, rows, kept = assemble_stiffness_and_contact_modes(material, mesh.mesh, boxes, patches, settings.modes, settings)
    T = nut_freedoms_from_free_ones(mesh, dims)
    K = (T.T @ K @ T).tocsc()
    rigid = np.asarray(rows @ nodal_displacements_of_rigid_motions(mesh.points, np.zeros(3)))
    G = symmetric_compliance_of_loads(K, rows @ T)
    return CondensedNut({s: k[0] for s, k in kept.items()}, T.shape[1], G, rigid)
