"""Displacements and stresses of the 3D reference, recovered from its contact loads.

The equations are solved once more, with one right-hand side: first the coarse mesh of a body under the forces that all its
contacts exert on it through their displacement modes, then each patch under its contact loads and the displacement of its
refinement box. All stresses are linear elastic, of nominal geometry; rigid motions, which cause no strain, are left out.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import partial

import numpy as np
import scipy.sparse as sp
from skfem import Mesh, condense

from rollbench.hifi import condensation
from rollbench.hifi.bodies import coarse
from rollbench.hifi.bodies.patch import CondensedPatch, PatchMesh, nodal_displacements_of_patch
from rollbench.hifi.contact import balls
from rollbench.hifi.contact.hertz import HertzSolution, solve_hertz
from rollbench.hifi.elements import forms
from rollbench.hifi.elements.forms import isotropic_stress_law, normalise_weight_rows
from rollbench.hifi.linear_algebra import factorise_positive_definite
from rollbench.hifi.meshing import part_meshes
from rollbench.hifi.meshing.part_meshes import PartMeshes
from rollbench.hifi.meshing.settings import Settings
from rollbench.hifi.reference import ReferenceResult
from rollbench.hifi.setup import CondensedGeometry
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.ball_body import contact_frame_vectors
from rollbench.meshes.fem import nodes_of_cells, with_node_coordinates
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import CoarseGroovedBodyMesh
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.parts import Material, Scene
from rollbench.meshes.sockets import points_in_box_at_azimuth_zero
from rollbench.meshes.solid import Dimensions, dimensions_of_3d_parts


@dataclass(frozen=True)
class SolidField:
    """Displacements and stresses at the nodes of the mesh of an elastic body, or of a part of it."""

    #: Coordinates of the n nodes ``(n, 3)`` [m].
    points: Array
    #: Indices of the nodes of each cell ``(cells, nodes per cell)``, in gmsh's order.
    cell_nodes: Index
    #: Type of the cells: tetrahedra of first or second order, "P1" or "P2"; hexahedra of first or second order, "Q1", "Q2".
    element_type: str
    #: Nodal displacements ``(n, 3)`` [m].
    displacements: Array
    #: Nodal stresses ``(n, 6)`` [Pa]: xx, yy, zz, yz, xz, xy.
    stresses: Array

    @property
    def von_mises(self) -> Array:
        """Von Mises stresses ``(n,)`` [Pa]."""
        return von_mises(self.stresses)


def von_mises(stress: Array) -> Array:
    """Compute the von Mises equivalent stress.

    Parameters
    ----------
    stress : (..., 6) Array
        Stresses xx, yy, zz, yz, xz, xy [Pa].

    Returns
    -------
    (...,) Array
        Equivalent stress [Pa].

    Examples
    --------
    >>> float(von_mises(np.array([3.0, 0.0, 0.0, 0.0, 0.0, 0.0])))
    3.0
    >>> f"{von_mises(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])):.4f}"  # pure shear: sqrt(3)
    '1.7321'
    """
    direct = stress[..., :3]
    spread = direct - np.roll(direct, 1, axis=-1)
    return np.asarray(np.sqrt(0.5 * (spread**2).sum(axis=-1) + 3.0 * (stress[..., 3:] ** 2).sum(axis=-1)))


def nodal_stress(mesh: Mesh, u: Array, material: Material, elements: Index | None = None) -> Array:
    """Compute nodal stresses from displacements: mean over all cells at a node of the stress that each cell has there.

    Extrapolating the values of the reduced Gauss points to the nodes would overshoot by a fifth below a contact with three
    cells across it; this average overshoots by a twentieth.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    u : (n, 3) Array
        Displacements [m].
    material : Material
        Elastic material.
    elements : Index | None, default None
        Indices of the cells whose stresses are computed and averaged; None: all cells.

    Returns
    -------
    (n, 6) Array
        Stresses xx, yy, zz, yz, xz, xy [Pa]; nan at nodes that belong to none of these cells.
    """
    nodes = mesh.elem.doflocs.T
    basis = forms.cell_basis(mesh, elements=elements, quadrature=(nodes, np.ones(nodes.shape[1])))
    slope = np.stack([basis.interpolate(component).grad for component in u.T])  # du_i/dx_j
    stress = isotropic_stress_law(material.youngs_modulus, material.poissons_ratio)(0.5 * (slope + slope.swapaxes(0, 1)))
    at_nodes = np.stack([stress[i, j].T for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))], axis=-1)
    cells = mesh.dofs.element_dofs if elements is None else mesh.dofs.element_dofs[:, elements]
    total, count = np.zeros((len(u), 6)), np.zeros(len(u))
    np.add.at(total, cells, at_nodes)
    np.add.at(count, cells, 1.0)
    out = np.full((len(u), 6), np.nan)
    used = count > 0.0
    out[used] = total[used] / count[used, None]
    return out


def contact_node_forces_by_flank(setup: CondensedGeometry, result: ReferenceResult) -> dict[int, Array]:
    """Return the normal forces at the contact nodes of all balls, separately for each groove flank.

    Each force is the coefficient of the pressure basis function that belongs to the node.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    result : ReferenceResult
        Solution of the 3D reference for this geometry.

    Returns
    -------
    dict[int, Array]
        By flank (0 to 3), the forces at the c contact nodes of each ball ``(balls, c)`` [N].
    """
    ends = np.cumsum([len(setup.patches_by_flank[s].groove_patch.A) for s in result.closable_flanks])
    rows = result.contact_solution.forces.reshape(setup.ball_positions.z.size, -1)
    return dict(zip(result.closable_flanks, np.split(rows, ends[:-1], axis=1), strict=True))


def nodal_displacements_of_screw(
    setup: CondensedGeometry, mesh: CoarseGroovedBodyMesh, forces: dict[int, Array], scene: Scene | None = None
) -> Array:
    """Compute the nodal displacements of the screw's coarse 3D mesh under all contact loads.

    The mesh covers a part of the screw around the nut; it is fixed at its low end, or at its bore.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    mesh : CoarseGroovedBodyMesh
        Mesh of that part, with n nodes.
    forces : dict[int, Array]
        Normal forces at the contact nodes, by flank, from `contact_node_forces_by_flank`.
    scene : Scene | None, default None
        Scene with supports and loads; None: the scene with which ``setup`` was made.

    Returns
    -------
    (n, 3) Array
        Displacements [m].

    Raises
    ------
    ValueError
        A support or load lies above the low end of the mesh, so that its high end carries an unknown reaction.
    """
    refuse_supports_beyond_low_end(scene or setup.scene, setup.solid_dimensions)
    high = setup.solid_dimensions.ends_of_meshed_screw(setup.scene)[1]
    T = condensation.screw_freedoms_from_free_ones(mesh, setup.solid_dimensions, high)
    return _nodal_displacements_of_coarse_body(setup, mesh, forces, T, screw=True)


def refuse_supports_beyond_low_end(scene: Scene, dims: Dimensions) -> None:
    """Raise ValueError if a support or load lies at larger z than the beginning of the screw's part that is meshed in 3D.

    Parameters
    ----------
    scene : Scene
        Load case.
    dims : Dimensions
        Dimensions of the solid parts.
    """
    low = dims.ends_of_meshed_screw(scene)[0]
    beyond = sorted(z for z in scene.stations if z > low)
    if dims.screw_held != "bore" and beyond:
        raise ValueError(
            f"{scene.name}: the stress field of the screw cannot be computed, because the screw is supported or loaded at "
            f"z = {1e3 * beyond[0]:.4g} mm; allowed: supports and loads only at z up to {1e3 * low:.4g} mm, where its 3D "
            "mesh begins"
        )


def nodal_displacements_of_nut(setup: CondensedGeometry, mesh: CoarseGroovedBodyMesh, forces: dict[int, Array]) -> Array:
    """Compute the nodal displacements of the nut's coarse mesh under all contact loads, supported as in the scene.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    mesh : CoarseGroovedBodyMesh
        Mesh of the nut, with n nodes.
    forces : dict[int, Array]
        Normal forces at the contact nodes, by flank, from `contact_node_forces_by_flank`.

    Returns
    -------
    (n, 3) Array
        Displacements [m].
    """
    T = condensation.nut_freedoms_from_free_ones(mesh, setup.solid_dimensions)
    return _nodal_displacements_of_coarse_body(setup, mesh, forces, T, screw=False)


def _nodal_displacements_of_coarse_body(
    setup: CondensedGeometry, mesh: CoarseGroovedBodyMesh, forces: dict[int, Array], T: sp.csc_array, *, screw: bool
) -> Array:
    """Solve for the nodal displacements ``(n, 3)`` [m] of the coarse mesh of screw or nut under its contact loads.

    ``mesh``: mesh of the body with n nodes; ``forces``: normal forces at the contact nodes, by flank, from
    `contact_node_forces_by_flank`; ``T``: matrix that gives all degrees of freedom from the free ones; ``screw``:
    whether the body is the screw (True) or the nut.
    """
    material = (setup.scene.screw if screw else setup.scene.nut).material
    patches = {s: p.groove_patch for s, p in setup.patches_by_flank.items() if (s < 2) == screw}
    places = part_meshes.contact_positions_on_body(setup.ball_positions, setup.loaded_flanks, screw)
    boxes = part_meshes.refinement_boxes_at_contact_azimuths(mesh, places)
    modes, settings = setup.mesh_settings.modes, setup.mesh_settings
    K, Q, kept = condensation.assemble_stiffness_and_contact_modes(material, mesh.mesh, boxes, patches, modes, settings)
    amplitude = [
        kept[s][0].T @ (forces[s][i] if s in forces else np.zeros(len(patches[s].A)))
        for i in range(setup.ball_positions.z.size)
        for s in patches
    ]
    q = factorise_positive_definite((T.T @ K @ T).tocsc())(T.T @ (Q.T @ np.concatenate(amplitude)))
    return np.asarray(T @ q).reshape(-1, 3)


def mesh_contact_patch(
    m: GrooveMap, settings: Settings, meshes: PartMeshes, side: int, *, on_ball: bool = False
) -> PatchMesh:
    """Create the fine mesh (patch) of groove or ball around a contact on one flank, for a ball at azimuth 0 and z = 0.

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.
    settings : Settings
        Mesh settings: cell sizes, modes and element type.
    meshes : PartMeshes
        Meshes of the geometry.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
    on_ball : bool, default False
        True: the ball's patch, with the ball's centre as origin; False: the groove's.

    Returns
    -------
    PatchMesh
        Fine mesh (patch) around the contact.
    """
    boxes = meshes.refinement_boxes_of_flank(side)
    if on_ball:
        _, on_surface = part_meshes.ball_refinement_box_and_map(m, meshes.socket_size, side, meshes.relative_zone_size)
        return part_meshes.mesh_patch(meshes, boxes.ball_socket, on_surface, settings)
    on_groove = partial(points_in_box_at_azimuth_zero, m, meshes.socket_size, side)
    return part_meshes.mesh_patch(meshes, boxes.groove_socket, on_groove, settings)


def stress_field_of_groove_patch(
    setup: CondensedGeometry, meshes: PartMeshes, body_displacements: Array, ball: int, side: int, forces: dict[int, Array]
) -> SolidField:
    """Compute displacements and stresses in the fine mesh (patch) of a groove at the contact with one ball.

    They are in a frame with the origin on the screw's axis, turned so that the ball is at azimuth 0 and z = 0.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    meshes : PartMeshes
        Meshes of the geometry.
    body_displacements : (n, 3) Array
        Displacements of the n nodes of the coarse mesh of screw or nut [m].
    ball : int
        Number of the ball, from 0.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
    forces : dict[int, Array]
        Normal forces at the contact nodes, by flank, from `contact_node_forces_by_flank`.

    Returns
    -------
    SolidField
        Displacements and stresses of the patch.
    """
    mesh = mesh_contact_patch(setup.groove_map, setup.mesh_settings, meshes, side)
    body, part = (meshes.screw_mesh, setup.scene.screw) if side < 2 else (meshes.nut_mesh, setup.scene.nut)
    body_sides = [s for s in setup.loaded_flanks if (s < 2) == (side < 2)]
    nodes = body.nodes_on_box_faces[ball * len(body_sides) + body_sides.index(side)]
    R = part_meshes.rotation_about_z(float(setup.ball_positions.azimuth[ball]))
    normals = part_meshes.contact_normals_of_patch(mesh, np.array([setup.groove_map.R, 0.0, 0.0]))
    return _stress_field_of_patch(mesh, normals, part.material, forces[side][ball], (body_displacements[nodes] @ R).ravel())


def _stress_field_of_patch(
    mesh: PatchMesh, normals: Array, material: Material, forces: Array, box_displacements: Array
) -> SolidField:
    """Compute displacements and stresses of a fine patch under its contact loads and the motion of its boundary.

    ``normals``: directions of the loads at the c contact nodes (c, 3); ``forces``: these loads (c,) [N];
    ``box_displacements``: displacements of the k nodes of the refinement box that the patch fills, in the patch's frame
    (3 k,) [m].
    """
    elastic = material.youngs_modulus, material.poissons_ratio
    u = nodal_displacements_of_patch(mesh, normals, *elastic, forces, box_displacements)
    return SolidField(mesh.points, mesh.cells, mesh.element_type, u, nodal_stress(mesh.mesh, u, material))


def stress_field_near_ball(
    setup: CondensedGeometry, mesh: CoarseGroovedBodyMesh, displacements: Array, ball: int, material: Material, reach: float
) -> SolidField:
    """Return displacements and stresses in the coarse mesh of screw or nut near one ball.

    They are in a frame with the origin on the screw's axis, turned so that the ball is at azimuth 0 and z = 0.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    mesh : CoarseGroovedBodyMesh
        Mesh of the body.
    displacements : (n, 3) Array
        Displacements of the body's nodes [m].
    ball : int
        Number of the ball, from 0.
    material : Material
        Elastic material.
    reach : float
        Largest distance from the ball's centre at which cells are included [m].

    Returns
    -------
    SolidField
        Displacements and stresses of the cells near the ball.
    """
    R = part_meshes.rotation_about_z(float(setup.ball_positions.azimuth[ball]))
    points = (mesh.points - np.array([0.0, 0.0, setup.ball_positions.z[ball]])) @ R
    near = np.linalg.norm(points - np.array([setup.groove_map.R, 0.0, 0.0]), axis=1) < reach
    elements = np.flatnonzero(near[mesh.cells].any(axis=1))
    kind = part_meshes.element_type_of_bodies(setup.mesh_settings)
    body = coarse.convert_mesh_order(with_node_coordinates(mesh.mesh, points), kind)
    if kind == "P1":  # eight first-order cells for each second-order one
        elements = (8 * elements[:, None] + np.arange(8)).ravel()
    stress = nodal_stress(body, displacements @ R, material, elements)
    used, cells = np.unique(nodes_of_cells(body)[elements], return_inverse=True)
    return SolidField(points[used], cells.reshape(len(elements), -1), kind, displacements[used] @ R, stress[used])


def stress_fields_of_ball(
    setup: CondensedGeometry, meshes: PartMeshes, ball: int, forces: dict[int, Array]
) -> dict[int | None, SolidField]:
    """Compute displacements and stresses in the coarse mesh and the fine contact meshes of one ball.

    They are in a frame with the ball's centre as origin, turned so that the ball's azimuth is 0.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    meshes : PartMeshes
        Meshes of the geometry.
    ball : int
        Number of the ball, from 0.
    forces : dict[int, Array]
        Normal forces at the contact nodes, by flank, from `contact_node_forces_by_flank`.

    Returns
    -------
    dict[int | None, SolidField]
        Fields of the coarse mesh of the ball (key None), and of its fine contact meshes by flank.
    """
    material, mesh = setup.scene.balls.material, meshes.ball_mesh
    e, nu = material.youngs_modulus, material.poissons_ratio
    patches: dict[int, CondensedPatch] = {s: p.ball_patch for s, p in setup.patches_by_flank.items()}
    boxes = [coarse.BodySocket(mesh.nodes_on_box_faces[s], np.eye(3), s) for s in patches]
    body = coarse.convert_mesh_order(mesh.mesh, kind := part_meshes.element_type_of_bodies(setup.mesh_settings))
    K = coarse.assemble_body_stiffness(body, boxes, patches, e, nu)
    held = coarse.select_isostatic_freedoms(mesh.points, np.concatenate([box.node_indices for box in boxes]))
    free = np.setdiff1d(np.arange(K.shape[0]), held)
    load = np.zeros(K.shape[0])
    for s, patch in patches.items():
        if s in forces:
            np.add.at(load, coarse.degrees_of_freedom_of_nodes(mesh.nodes_on_box_faces[s]), patch.H.T @ forces[s][ball])
    u = np.zeros(K.shape[0])
    u[free] = factorise_positive_definite(condense(K, D=held, expand=False))(load[free])
    u = u.reshape(-1, 3)
    whole = SolidField(mesh.points, nodes_of_cells(body), kind, u, nodal_stress(body, u, material))
    by_side: dict[int | None, SolidField] = {None: whole}
    for s in forces:
        piece = mesh_contact_patch(setup.groove_map, setup.mesh_settings, meshes, s, on_ball=True)
        normals = -part_meshes.contact_normals_of_patch(piece, np.zeros(3))
        at_box = u[mesh.nodes_on_box_faces[s]].ravel()
        by_side[s] = _stress_field_of_patch(piece, normals, material, forces[s][ball], at_box)
    return by_side


@dataclass(frozen=True)
class ContactPressure:
    """Pressure distribution of one contact at its c nodes, and Hertz's solution for the same load.

    Positions are in the tangent plane of the ball at the nominal contact point.
    """

    #: Coordinate of the nodes in the tangent plane across the groove, growing with the contact angle ``(c,)`` [m].
    position_across: Array
    #: Coordinate of the nodes in the tangent plane along the groove ``(c,)`` [m].
    position_along: Array
    #: Contact pressures at the nodes ``(c,)`` [Pa].
    pressure: Array
    #: Centre of pressure, across and along the groove ``(2,)`` [m].
    pressure_centre: Array
    #: Contact load, the resultant of the pressures [N].
    load: float
    #: Hertz's closed-form solution of the contact under this load.
    hertz_solution: HertzSolution
    #: Area that each node carries (integral of its pressure basis function) ``(c,)`` [m2].
    nodal_areas: Array
    #: Numbers of nodes across and along the groove; None: the nodes form no grid.
    grid_shape: tuple[int, int] | None


def pressure_from_nodal_forces(
    scene: Scene, m: GrooveMap, side: int, patch: CondensedPatch, forces: Array
) -> ContactPressure:
    """Compute the pressure distribution of one contact: the force at each contact node over the area that it carries.

    Parameters
    ----------
    scene : Scene
        Scene with the balls and their material.
    m : GrooveMap
        Geometry of the track.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
    patch : CondensedPatch
        Condensed fine mesh of the groove at the contact.
    forces : (c,) Array
        Normal forces at its c contact nodes [N].

    Returns
    -------
    ContactPressure
        Pressure distribution, its resultant and Hertz's solution.

    Raises
    ------
    ValueError
        The contact carries no load.
    """
    if not forces.sum() > 0.0:
        raise ValueError(
            f"no contact pressure on flank {side}: its contact carries a force of {forces.sum():.3g} N; allowed: > 0 N"
        )
    arms = patch.contact_points - np.array([m.R, 0.0, 0.0])
    n, t1, t2 = contact_frame_vectors(m, side)
    across, along = arms @ t1, arms @ t2
    nodal = normalise_weight_rows(patch.pressure_weights).T @ forces
    resultant = nodal @ (arms / np.linalg.norm(arms, axis=1)[:, None])
    load = float(np.linalg.norm(resultant))
    angle = m.beta + float(np.arctan2(resultant @ t1, resultant @ n))
    centre = np.array([nodal @ across, nodal @ along]) / nodal.sum()
    material = scene.balls.material
    closed = solve_hertz(load, *m.relative_curvature_radii(side, angle), material.youngs_modulus, material.poissons_ratio)
    areas, shape = patch.nodal_areas, patch.contact_grid_shape
    return ContactPressure(across, along, forces / areas, centre, load, closed, areas, shape)


def contact_pressures_of_ball(
    scene: Scene, settings: Settings, ball: int, loads: Array, angles: Array
) -> dict[int, ContactPressure]:
    """Compute the contact pressures between one ball and its grooves for given contact loads and contact angles.

    The whole ball is elastic. Each groove is represented by a fine elastic mesh around the contact, which is fixed on its
    boundary to screw or nut: the compliance of the body beyond hardly changes the curvature at a contact. Each groove mesh
    is moved towards the ball until it carries the given load. Flanks without load are left out.

    Parameters
    ----------
    scene : Scene
        Ball screw or bearing.
    settings : Settings
        Mesh settings: cell sizes, modes and element type.
    ball : int
        Number of the ball, from 0.
    loads : (4,) Array
        Contact load on each flank [N].
    angles : (4,) Array
        Contact angle on each flank [rad].

    Returns
    -------
    dict[int, ContactPressure]
        Pressure distribution of each loaded flank (0 to 3).

    Raises
    ------
    ValueError
        No flank is loaded, or the contact does not converge.
    """
    sides = tuple(s for s in range(4) if loads[s] > 0.0)
    if not sides:
        raise ValueError(
            f"ball {ball + 1} carries no load, so that it has no contact pressure: choose a ball with a contact load > 0 N"
        )
    m, all_balls, dims = GrooveMap.from_scene(scene), ball_layout(scene), dimensions_of_3d_parts(scene)
    row = slice(ball, ball + 1)
    layout = BallLayout(*(getattr(all_balls, x.name)[row] for x in fields(BallLayout)))
    meshes = part_meshes.mesh_parts(scene, m, layout, dims, sides, settings)
    patches = {}
    for s in sides:
        given = condensation.collect_flank_condensation_arguments(scene, m, dims, meshes, s, settings)
        patches[s] = condensation.condense_patches_of_flank(*given)
    whole_ball = condensation.condense_ball(scene.balls.material, meshes.ball_mesh, patches, settings)
    local, modes = (patches[s].local_compliance for s in sides), (whole_ball.modes_by_flank[s] for s in sides)
    block = balls.BallContactCompliance(tuple(local), tuple(modes), whole_ball.G)
    x3, _, z3 = m.section_axes()
    gaps, N, f = [], np.zeros((len(block), 3 * len(sides))), np.zeros(3 * len(sides))
    pairs_of_flank = dict(zip(sides, block.pair_slices_by_flank, strict=True))
    for k, (s, pairs) in enumerate(pairs_of_flank.items()):
        groove = patches[s].groove_patch
        mean = normalise_weight_rows(groove.pressure_weights)
        arms = groove.contact_points - np.array([m.R, 0.0, 0.0])
        length = np.linalg.norm(arms, axis=1)
        columns = slice(3 * k, 3 * k + 3)
        N[pairs, columns] = mean @ (arms / length[:, None])
        sx, sz = m.signs[s]
        f[columns] = loads[s] * (sx * np.cos(angles[s]) * x3 + sz * np.sin(angles[s]) * z3)
        gaps.append(mean @ (length - m.ball))
    C = balls.contact_compliance_of_single_ball(block)
    result, _ = balls.solve_contacts_of_all_balls(C, np.concatenate(gaps), sp.csr_array(N), f)
    if not result.converged:
        raise ValueError(f"the contact pressures of ball {ball + 1} cannot be computed: {result.status}")
    return {
        s: pressure_from_nodal_forces(scene, m, s, patches[s].groove_patch, result.forces[pairs])
        for s, pairs in pairs_of_flank.items()
    }


def von_mises_below_hertz_contact(contact: HertzSolution, depth: Array, poisson: float) -> Array:
    """Compute the von Mises stress below the centre of a Hertzian contact ellipse, at several depths.

    Boussinesq's point loads are integrated over the pressure p0 sqrt(1 - x^2/a^2 - y^2/b^2). Valid at depths of at
    least 0.2 b.

    Parameters
    ----------
    contact : HertzSolution
        Hertz's contact.
    depth : (d,) Array
        Depths [m].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    (d,) Array
        Equivalent stress at each depth [Pa].

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. (3.19).

    Examples
    --------
    >>> ball = solve_hertz(100.0, 5e-3, 5e-3, 210e9, 0.3)
    >>> f"{von_mises_below_hertz_contact(ball, np.array([0.481 * ball.semi_x]), 0.3)[0] / ball.pole_pressure:.3f}"
    '0.620'
    """
    g, w = np.polynomial.legendre.leggauss(80)
    phi = 0.25 * np.pi * (1.0 + g)
    theta = (np.arange(160) + 0.5) * np.pi / 160.0
    s = np.sin(phi)
    x = contact.semi_x * s[:, None] * np.cos(theta)
    y = contact.semi_y * s[:, None] * np.sin(theta)
    weight = 0.25 * np.pi * w * np.cos(phi) ** 2 * s * (2.0 * np.pi / 160.0)
    P = contact.pole_pressure * contact.semi_x * contact.semi_y * np.broadcast_to(weight[:, None], x.shape)
    r2 = x * x + y * y
    out = np.empty(np.shape(depth))
    for k, z in enumerate(depth):
        R = np.sqrt(r2 + z * z)
        share = r2 / (R * (R + z)) / r2**2  # (1 - z/R) / r^4 without cancellation

        def stress_along_axis(u: Array, v: Array, z: float = z, R: Array = R, share: Array = share) -> float:
            soft = (1.0 - 2.0 * poisson) * (share * (u * u - v * v) + z * v * v / (r2 * R**3))
            return float((P * (soft - 3.0 * z * u * u / R**5)).sum() / (2.0 * np.pi))

        axial = -float((P * 3.0 * z**3 / R**5).sum() / (2.0 * np.pi))
        out[k] = von_mises(np.array([stress_along_axis(x, y), stress_along_axis(y, x), axial, 0.0, 0.0, 0.0]))
    return out
