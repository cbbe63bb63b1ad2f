"""Kernels of finite bodies (`hifi.rolling.patch`) from finite elements: ball and groove.

A kernel is the response of a body to smooth tractions on its contact zone, in all three directions, less that of a
half-space whose zone has the same nodes. The effect of the grid on the singular part is contained in both, and cancels.

For rings and helices the bodies are patches of the static reference in pieces of their bodies. For straight tracks, which
the static reference does not have, they are a whole ball and a grooved bar (`hifi.rolling.contact_bodies`). A patch is
meshed by `hifi.bodies.patch.mesh_hexahedral_patch` on the exact groove, or on the ball, in its refinement box of a piece of
screw, ring, nut or ball cut as in `hifi.condensation`. Patch and piece are solved together
(`hifi.bodies.coarse.compliance_of_patch_in_submodel`). The cells of the contact zone are those of the other bodies of
rolling (`hifi.rolling.contact_bodies.ContactZone`).

A body is free, with its loads balanced by a rigid field of body forces, or fixed at its boundary "held". The cut of a
half-space's block moves by Boussinesq's and Cerruti's point forces.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from time import process_time
from typing import Any

import numpy as np
import scipy.sparse as sp

from rollbench.hifi.bodies import coarse
from rollbench.hifi.bodies import patch as bodies_patch
from rollbench.hifi.condensation import BEYOND
from rollbench.hifi.contact.block import boussinesq_displacements
from rollbench.hifi.contact.hertz import solve_hertz
from rollbench.hifi.elements import forms
from rollbench.hifi.elements.forms import normalise_weight_rows, pressure_function_integrals
from rollbench.hifi.linear_algebra import symmetric_compliance_of_loads
from rollbench.hifi.meshing.part_meshes import ball_refinement_box_and_map
from rollbench.hifi.rolling import contact_bodies
from rollbench.hifi.rolling.contact_bodies import ContactBody, ContactZone
from rollbench.hifi.rolling.patch import ComplianceKernel, monomial_values
from rollbench.hifi.setup import RecordJob, compute_records
from rollbench.meshes import fem, sockets
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.ball_body import mesh_ball_with_refinement_boxes
from rollbench.meshes.cache import Cache
from rollbench.meshes.groove import GroovedBodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import mesh_grooved_body
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import SIDE_SIGNS
from rollbench.meshes.record_keys import frozen_default, frozen_record

#: Numbers of the left flanks of screw or inner ring, and of nut or outer ring; right flanks are left ones after half a
#: turn.
INNER, OUTER = 0, 2

#: Largest distances of the land and of the surface behind the groove from the pitch circle, both over the ball's radius;
#: smallest inner radius of a piece over the pitch radius.
LAND, WALL, CORE = 0.18, 2.7, 1.0 / 11.0

#: Fixed boundaries of the pieces of grooved bodies.
ENDS = ("low end", "high end")

#: Subdivisions of the refinement boxes' edges; element sizes near the refinement box and away from it, over the ball's
#: radius, for grooves and for balls. These are the sizes of mesh level 1 of the static 3D reference
#: (`compare.reference.levels`).
CUTS, GROOVE_SIZES, BALL_SIZES = (4, 4, 4), (0.216, 1.3), (0.119, 0.27)


@dataclass(frozen=True)
class ContactPiece:
    """Fine mesh (patch) of a groove or ball at one contact, with the coarse mesh of a piece of the body around it."""

    #: Fine mesh (patch) of the groove or ball at the contact.
    patch_mesh: bodies_patch.PatchMesh
    #: Coarse mesh of the piece of the body around the fine mesh.
    body_piece: coarse.ContactSubmodel
    #: Centre of the ball in the frame of the fine mesh ``(3,)`` [m].
    ball_centre: Array
    #: Unit vectors along the track, across it towards the bottom of the groove, and into the body, as rows ``(3, 3)``.
    contact_axes: Array
    #: Boundaries of the fine mesh's cells along the track, across it and into the body [m].
    cell_boundaries: tuple[Array, Array, Array]
    #: Grid indices of the c nodes of the contact zone, along and across the track ``(c, 2)``.
    node_grid_indices: Index


def mesh_contact_pieces(at: ContactGeometry, zone: ContactZone) -> tuple[ContactPiece, ContactPiece]:
    """Mesh a piece of the grooved body and the ball around one contact, with fine meshes (patches) at the contact.

    Parameters
    ----------
    at : ContactGeometry
        Geometry of the contact, on a ring or a helix.
    zone : ContactZone
        Contact zone.

    Returns
    -------
    groove, ball : ContactPiece
        Meshes of groove and ball.

    Raises
    ------
    ValueError
        The body has no room for the hole into which the patch is fitted, or a mesh cannot be built.
    """
    on_nut_or_outer_ring, ball = at.groove_curvature_along > 0.0, at.ball_radius
    side = OUTER if on_nut_or_outer_ring else INNER
    m = track_geometry_of_contact(at)
    walls = max(m.R - WALL * ball, CORE * m.R), m.R + WALL * ball
    lands = m.R - LAND * ball, m.R + LAND * ball
    nothing = np.zeros(1)
    alone = BallLayout(nothing, nothing, np.array([[m.R, 0.0, 0.0]]), *np.eye(3)[[0, 2, 1]][:, None])
    radii, ends = (lands[0], walls[0], lands[1], walls[1]), (-3.0 * ball, 3.0 * ball)
    size = sockets.largest_fitting_refinement_box(m, alone, (side,), *radii, ends, zone.half_lengths[::-1])
    size = replace(size, edge_divisions=CUTS)
    lines, local = _patch_cell_boundaries_and_zone(m, size, side, zone)
    half = max(sockets.axial_reach_of_refinement_boxes(m, size, (side,))) + BEYOND * ball
    inner, outer = (lands[1], walls[1]) if on_nut_or_outer_ring else (walls[0], lands[0])
    near, away = (ball * share for share in GROOVE_SIZES)
    contact = (0.0, 0.0, side)
    spec = GroovedBodySpec(inner, outer, -half, half, not on_nut_or_outer_ring, (contact,), size, near, away)
    body = mesh_grooved_body(m, spec)
    on_groove = partial(sockets.points_in_box_at_azimuth_zero, m, size, side)
    ball_box, on_ball = ball_refinement_box_and_map(m, size, side, local)
    near, away = (ball * share for share in BALL_SIZES)
    sphere = mesh_ball_with_refinement_boxes(m, (ball_box,), near, away, CUTS)
    normal, axes = _contact_normal_and_axes(m, side)
    x, y = lines.along * zone.half_lengths[0] / local[1], lines.across * zone.half_lengths[1] / local[0]
    out = []
    for mesh, nodes, fixed, to_space, centre, inward, depth in (
        (body, body.nodes_on_box_faces[0], ENDS, on_groove, np.array([m.R, 0.0, 0.0]), normal, size.depth),
        (sphere, sphere.nodes_on_box_faces[side], (), on_ball, np.zeros(3), -normal, ball_box.depth),
    ):
        patch = bodies_patch.mesh_hexahedral_patch(lines, local, to_space, mesh.box_faces[side])
        piece = coarse.ContactSubmodel(mesh.mesh, nodes, np.eye(3), fixed)
        number = _grid_indices_of_contact_nodes(patch, axes, centre)
        out.append(ContactPiece(patch, piece, centre, np.vstack([axes, inward]), (x, y, depth * lines.depth), number))
    return out[0], out[1]


def track_geometry_of_contact(at: ContactGeometry) -> GrooveMap:
    """Describe a track whose four groove flanks have the same radius, by the groove map of the static 3D reference.

    Parameters
    ----------
    at : ContactGeometry
        Geometry of the contact.

    Returns
    -------
    GrooveMap
        Geometry of the track.

    Raises
    ------
    ValueError
        The track is straight.
    """
    if at.path_radius_and_rise is None:
        raise ValueError(
            "the static 3D reference does not model straight tracks: the balls must move along a ring or a helix"
        )
    (radius, rise), angle = at.path_radius_and_rise, at.contact_angle
    signs = np.array(SIDE_SIGNS)
    to_contact = signs * np.array([np.cos(angle), np.sin(angle)])
    centres, radii = -(at.groove_radius - at.ball_radius) * to_contact, np.full(4, at.groove_radius)
    lead_angle = float(np.arctan2(rise, radius))
    return GrooveMap(radius, rise, lead_angle, angle, at.ball_radius, signs, centres, radii, 0.0, 0.0, 1)


def _patch_cell_boundaries_and_zone(
    m: GrooveMap, size: sockets.RefinementBoxSize, side: int, zone: ContactZone
) -> tuple[bodies_patch.PatchCellBoundaries, tuple[float, float]]:
    """Compute the cell boundaries of the fine mesh (patch) around a contact from the cells of the contact zone.

    Also returns the half lengths of the zone across and along the track, over those of the patch. ``m``: geometry of the
    track; ``size``: dimensions of the patch; ``side``: groove flank, 0 to 3; ``zone``: the contact zone.
    """
    along = size.phi * float(np.hypot(sockets.unrolled_nominal_contact_point(m, side)[0], m.rg))
    width = size.gamma * float(m.radius[side])
    local = (zone.half_lengths[1] / width, zone.half_lengths[0] / along)
    first = min(2.0 * h / n for h, n in zip(zone.half_lengths, zone.cell_counts, strict=True)) / size.depth
    growth, steps = zone.cell_growth, [2.0 * local[k] / zone.cell_counts[1 - k] for k in (0, 1)]
    across, forth = (bodies_patch.graded_cell_boundaries(local[k], steps[k], growth) for k in (0, 1))
    depth = bodies_patch.growing_cell_boundaries(0.0, 1.0, first / growth, growth)
    return bodies_patch.PatchCellBoundaries(across, depth, forth), local


def _contact_normal_and_axes(m: GrooveMap, side: int) -> tuple[Array, Array]:
    """Compute the contact normal from ball to groove ``(3,)``, and the tangential axes of the contact ``(2, 3)``.

    ``m``: geometry of the track; ``side``: index of the flank, 0 to 3. The rows of the second result are unit vectors
    along the groove and across it towards its bottom; with the normal they are right-handed.
    """
    radial, binormal = np.array([1.0, 0.0, 0.0]), np.array([0.0, -np.sin(m.alpha), np.cos(m.alpha)])
    sx, sz = m.signs[side]
    normal = sx * np.cos(m.beta) * radial + sz * np.sin(m.beta) * binormal
    touched = m.R * radial + m.ball * normal
    along = np.array([-touched[1], touched[0], m.rg])
    along = (along - (along @ normal) * normal) / np.linalg.norm(along - (along @ normal) * normal)
    across = np.cross(normal, along)
    sign = np.sign(sx * (across @ radial))
    return normal, sign * np.stack([along, across])


def _grid_indices_of_contact_nodes(patch: bodies_patch.PatchMesh, axes: Array, centre: Array) -> Index:
    """Return the column and row of each of a patch's c contact nodes in the grid that they form, from zero ``(c, 2)``.

    The indices grow along the rows of ``axes`` (2, 3); ``centre``: centre of the ball (3,) [m].
    """
    assert patch.contact_grid_shape is not None  # a grid
    places = np.stack(np.unravel_index(np.arange(patch.contact_nodes.size), patch.contact_grid_shape)[::-1], axis=1)
    at = (patch.points[patch.contact_nodes] - centre) @ axes.T
    for k in range(2):
        if (places[:, k] - places[:, k].mean()) @ at[:, k] < 0.0:
            places[:, k] = places[:, k].max() - places[:, k]
    return places


def cerruti_displacements(points: Array, sources: Array, shear: float, poisson: float) -> Array:
    """Compute the displacements of the half-space z > 0 under unit forces along x on its surface, by Cerruti.

    The displacement is infinite at the point where a force acts. n: number of points; m: number of forces.

    Parameters
    ----------
    points : (n, 3) Array
        Points [m].
    sources : (m, 2) Array
        Coordinates x, y of the points on the surface z = 0 where the forces act [m].
    shear : float
        Shear modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    (n, 3, m) Array
        Displacements along x, y, z [m/N].

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. (3.75).

    Examples
    --------
    >>> on_axis = cerruti_displacements(np.array([[0.0, 0.0, 1e-3]]), np.zeros((1, 2)), 80e9, 0.25)
    >>> f"{1e9 * on_axis[0, 0, 0]:.4f} nm/N"  # (1 + (1 - 2 nu) / 2) / (4 pi G z)
    '1.2434 nm/N'
    """
    x, y = np.moveaxis(points[:, None, :2] - sources, 2, 0)
    z = points[:, 2, None]
    r = np.sqrt(x**2 + y**2 + z**2)
    k, s = 1.0 - 2.0 * poisson, r * (r + z)
    parts = [
        1.0 / r + x**2 / r**3 + k * (1.0 / (r + z) - x**2 / (s * (r + z))),
        x * y / r**3 - k * x * y / (s * (r + z)),
        x * z / r**3 + k * x / s,
    ]
    return np.stack(parts, axis=1) / (4.0 * np.pi * shear)


@dataclass(frozen=True)
class ContactAxes:
    """Axes of a contact in the coordinates of a body's mesh."""

    #: Point on the normal through the contact's centre ``(3,)`` [m].
    centre: Array = field(default_factory=lambda: np.zeros(3))
    #: Unit vectors along x, y and into the body, as rows ``(3, 3)``.
    axes: Array = field(default_factory=lambda: np.eye(3))


def contact_node_coordinates(body: ContactBody, frame: ContactAxes) -> Array:
    """Return the coordinates x and y ``(c, 2)`` [m] of a body's c contact nodes in the axes of the contact, ``frame``."""
    return np.asarray(((fem.node_coordinates(body.mesh)[body.contact_nodes] - frame.centre) @ frame.axes.T)[:, :2])


def nodal_forces_of_tractions(
    body: ContactBody, zone: ContactZone, degree: int, curvatures: tuple[float, float], frame: ContactAxes | None = None
) -> sp.csr_array:
    """Compute the nodal forces of smooth (polynomial) tractions on a contact zone, along two tangents and the normal.

    The directions follow the curved surface. The work of a traction on a displacement of the zone equals the coefficient of
    one monomial in a polynomial that is fitted to this displacement by least squares over the zone's area.

    Parameters
    ----------
    body : ContactBody
        The body, with n nodes.
    zone : ContactZone
        Contact zone.
    degree : int
        Degree of the monomials, k of them.
    curvatures : tuple[float, float]
        Curvatures along x and y of the surface that ball and groove share [1/m], positive towards the ball.
    frame : ContactAxes | None, default None
        Axes of the contact in the body's mesh; None: they are the axes of the mesh.

    Returns
    -------
    (3 k, 3 n) sparse array
        Nodal forces, one row for each traction: k rows along x, then k along y, then k into the body.
    """
    frame = frame or ContactAxes()
    at = contact_node_coordinates(body, frame)
    c = len(at)
    integrals = pressure_function_integrals(body.mesh, body.contact_nodes)
    root = np.sqrt(np.asarray(integrals.sum(axis=1))[:, None])
    to_coefficients = np.linalg.pinv(root * monomial_values(at, zone.half_lengths, degree))
    fit = to_coefficients @ (root * normalise_weight_rows(integrals).toarray())
    tilt = -body.normal_sense * at * np.array(curvatures)  # rise of the surface into the body, per length
    frames = np.zeros((c, 3, 3))  # rows: local x, y, inward
    frames[:, 0, 0] = frames[:, 1, 1] = frames[:, 2, 2] = 1.0
    frames[:, :2, 2], frames[:, 2, :2] = tilt, -tilt
    frames /= np.linalg.norm(frames, axis=2, keepdims=True)
    k = len(fit)
    nodal = np.einsum("kc,cdx->dkcx", fit, frames @ frame.axes).reshape(3 * k, 3 * c)
    columns = (3 * body.contact_nodes[:, None] + np.arange(3)).ravel()
    spread = sp.csr_array((np.ones(3 * c), (np.arange(3 * c), columns)), (3 * c, body.mesh.doflocs.size))
    return sp.csr_array(sp.csr_array(nodal) @ spread)


def compliance_of_body(body: ContactBody, nodal_forces: sp.csr_array, young: float, poisson: float) -> Array:
    """Compute the compliance of a body that is fixed on its boundary "held", or free if it has none.

    A free body is loaded by body forces that vary in space like rigid-body motions and balance the loads; the motions of
    the whole body are left out (inertia relief).

    Parameters
    ----------
    body : ContactBody
        The body.
    nodal_forces : (m, 3 n) sparse array
        Nodal forces of m load cases.
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    (m, m) Array
        Compliance between the m load cases [m/N].
    """
    K = forms.elastic_stiffness(body.mesh, young, poisson)
    fixed = ("held",) if "held" in body.mesh.boundaries else ()
    whole = coarse.ContactSubmodel(body.mesh, body.contact_nodes, np.eye(3), fixed)
    return coarse.compliance_of_submodel(whole, K, nodal_forces)


def compliance_of_half_space_block(body: ContactBody, nodal_forces: sp.csr_array, young: float, poisson: float) -> Array:
    """Compute the compliance of a half-space between m load cases, on a block whose cut faces move as in the half-space.

    The motion of the cut faces is that of Boussinesq's and Cerruti's point forces, as in `hifi.contact.block`. ``body``:
    the block, of n nodes; ``nodal_forces``: nodal forces of the m load cases (m, 3 n); ``young``: Young's modulus [Pa];
    ``poisson``: Poisson's ratio.

    Returns
    -------
    (m, m) Array
        Compliance between the m load cases [m/N].
    """
    K = forms.elastic_stiffness(body.mesh, young, poisson)
    cut = fem.degrees_of_freedom_on_boundaries(body.mesh, "held")
    by_cut = sp.csr_array(-(K[cut].T @ _half_space_motion_at_cut(body, nodal_forces, young, poisson)).T)
    free, m = np.setdiff1d(np.arange(K.shape[0]), cut), nodal_forces.shape[0]
    F = symmetric_compliance_of_loads(K[free][:, free], sp.vstack([nodal_forces, by_cut]).tocsr()[:, free])
    out = F[:m, :m] + F[:m, m:]
    return np.asarray(0.5 * (out + out.T))


def _half_space_motion_at_cut(body: ContactBody, nodal_forces: sp.csr_array, young: float, poisson: float) -> Array:
    """Compute the displacements that a half-space has at the cut faces of a block, ``(3 cut nodes, m)`` [m/N].

    ``nodal_forces``: nodal forces of m load cases on the nodes of the contact zone (m, 3 n).
    """
    points = fem.node_coordinates(body.mesh)
    cut, sources = points[fem.nodes_on_boundaries(body.mesh, "held")], points[body.contact_nodes, :2]
    shear = 0.5 * young / (1.0 + poisson)
    along = cerruti_displacements(cut, sources, shear, poisson)
    turned = cerruti_displacements(cut[:, [1, 0, 2]], sources[:, ::-1], shear, poisson)[:, [1, 0, 2]]
    down = boussinesq_displacements(cut, sources, young, poisson)
    out = np.zeros((3 * len(cut), nodal_forces.shape[0]))
    for axis, motion in enumerate((along, turned, down)):
        out += motion.reshape(3 * len(cut), -1) @ nodal_forces[:, 3 * body.contact_nodes + axis].toarray().T
    return out


def half_space_compliance_on_same_nodes(
    body: ContactBody,
    zone: ContactZone,
    size: float,
    young: float,
    poisson: float,
    degree: int,
    frame: ContactAxes | None = None,
    inner_cell_boundaries: tuple[Array, Array, Array] | None = None,
) -> Array:
    """Compute the compliance of a half-space on a mesh whose contact nodes have the coordinates x, y of a body's nodes.

    If the mesh makes the contact zone wider by a fraction e, its displacement under a linear traction is smaller by 2 e to
    3 e. With equal nodes this error is the same in both bodies and cancels in the difference of their compliances.

    Parameters
    ----------
    body : ContactBody
        The body.
    zone : ContactZone
        Contact zone.
    size : float
        Distance of the cut faces from the contact's centre [m].
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.
    degree : int
        Degree of the monomials, k of them.
    frame : ContactAxes | None, default None
        Axes of the contact in the body's mesh; None: they are the axes of the mesh.
    inner_cell_boundaries : tuple[Array, Array, Array] | None, default None
        Cell boundaries near the contact along x, y and z [m], as for `hifi.rolling.contact_bodies.mesh_half_space`.

    Returns
    -------
    (3 k, 3 k) Array
        Compliance between the smooth tractions of `nodal_forces_of_tractions` [m/N].
    """
    block = contact_bodies.mesh_half_space(size, zone, inner_cell_boundaries)
    cells, places = np.array(zone.cell_counts), body.node_grid_indices
    regular = np.array(zone.half_lengths) * (places / cells - 1.0)
    off = np.zeros((*(2 * cells + 1), 2))
    off[tuple(places.T)] = contact_node_coordinates(body, frame or ContactAxes()) - regular
    points = fem.node_coordinates(block.mesh).copy()
    points[:, :2] += off[tuple(zone.nearest_node_indices(points[:, :2]).T)]
    block = replace(block, mesh=fem.with_node_coordinates(block.mesh, points))
    return compliance_of_half_space_block(block, nodal_forces_of_tractions(block, zone, degree, (0.0, 0.0)), young, poisson)


@frozen_record
class Sizes:
    """Numerical settings for the compliance of finite bodies at a contact (kernels): meshes and polynomial degree."""

    #: Numbers of cells of the contact zone along and across the groove.
    cells: tuple[int, int] = frozen_default((4, 4))
    #: Ratio of the sizes of neighbouring cells outside the contact zone.
    growth: float = frozen_default(2.5)
    #: Ratio of the contact zone's half lengths to the semi-axes of the contact ellipse.
    margin: float = frozen_default(1.1)
    #: Degree of the polynomials that describe the compliance of a finite body less that of a half-space.
    degree: int = frozen_default(4)
    #: Ratio of the outer radius of the grooved bars that represent screw, nut or ring (about the ball's centre) to the
    #: ball's radius.
    bar: float = frozen_default(5.0)
    #: Half of the opening angle of the groove in these bars, seen from the ball's centre [rad].
    opening: float = frozen_default(1.4)
    #: True: grooves of rings and helices are meshed as in the static 3D reference; False: as bent bars.
    patches: bool = frozen_default(True)


#: Call of a function that computes compliance kernels, and its arguments.
KernelCall = tuple[Callable[..., Any], tuple[Any, ...]]

#: Results of these calls that are kept in memory; the oldest goes if there are more than `MOST`.
_KEPT: dict[KernelCall, Any] = {}
MOST = 32


def _store_result(call: KernelCall, value: Any) -> None:
    """Keep the result of a call in memory."""
    _KEPT[call] = value
    while len(_KEPT) > MOST:
        del _KEPT[next(iter(_KEPT))]


def kept_or_computed(call: KernelCall) -> Any:
    """Return the result of a call that computes compliance kernels: from memory, or computed and kept."""
    if call not in _KEPT:
        _store_result(call, call[0](*call[1]))
    return _KEPT[call]


def compliance_kernel_of_ball(
    radius: float, zone: ContactZone, curvatures: tuple[float, float], young: float, poisson: float, degree: int
) -> ComplianceKernel:
    """Compute the compliance of a whole ball at a contact less that of a half-space (its kernel).

    ``radius``: radius of the ball [m]; ``zone``: contact zone; ``curvatures``: curvatures along x and y of the
    surface that ball and groove share [1/m], positive towards the ball; ``young``: Young's modulus [Pa]; ``poisson``:
    Poisson's ratio; ``degree``: degree of the kernel's polynomials.
    """
    body = contact_bodies.mesh_whole_ball(radius, zone)
    forces = nodal_forces_of_tractions(body, zone, degree, curvatures)
    half_space = half_space_compliance_on_same_nodes(body, zone, radius, young, poisson, degree)
    return ComplianceKernel(compliance_of_body(body, forces, young, poisson) - half_space, zone.half_lengths, degree)


def compliance_kernel_of_bar(
    groove: contact_bodies.Groove,
    size: float,
    zone: ContactZone,
    curvatures: tuple[float, float],
    young: float,
    poisson: float,
    degree: int,
) -> ComplianceKernel:
    """Compute the compliance of a grooved bar at a contact less that of a half-space (its kernel).

    ``groove``: cross-section of the groove; ``size``: radius of the outside of the bar, from the ball's centre [m];
    ``zone``: contact zone; ``curvatures``: curvatures along x and y of the surface that ball and groove share
    [1/m], positive towards the ball; ``young``: Young's modulus [Pa]; ``poisson``: Poisson's ratio; ``degree``: degree of
    the kernel's polynomials. Forces and motions are those of a ball on the bar, as in `kernel_from_groove_response`.
    """
    body = contact_bodies.mesh_grooved_bar(groove, size, zone)
    forces = nodal_forces_of_tractions(body, zone, degree, curvatures)
    half_space = half_space_compliance_on_same_nodes(body, zone, groove.ball_radius, young, poisson, degree)
    return kernel_from_groove_response(compliance_of_body(body, forces, young, poisson) - half_space, zone, degree)


def compliance_kernels_of_patches(
    at: ContactGeometry, zone: ContactZone, young: float, poisson: float, degree: int
) -> tuple[ComplianceKernel, ComplianceKernel]:
    """Compute the compliances of groove and of ball at a contact less that of a half-space (kernels), on fine meshes.

    The meshes are made like the contact patches of the static 3D reference.

    Parameters
    ----------
    at : ContactGeometry
        Geometry of the contact, on a ring or a helix.
    zone : ContactZone
        Contact zone.
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.
    degree : int
        Degree of the kernel's polynomials.

    Returns
    -------
    groove, ball : ComplianceKernel
        Kernels of the groove and of the ball.
    """
    kernels, elastic = [], (young, poisson)
    for cut, sense in zip(mesh_contact_pieces(at, zone), (1, -1), strict=True):
        body = ContactBody(cut.patch_mesh.mesh, cut.patch_mesh.contact_nodes, sense, cut.node_grid_indices)
        frame, lines = ContactAxes(cut.ball_centre, cut.contact_axes), cut.cell_boundaries
        forces = nodal_forces_of_tractions(body, zone, degree, at.shared_surface_curvatures, frame)
        matrix = coarse.compliance_of_patch_in_submodel(cut.body_piece, cut.patch_mesh, forces, *elastic)
        half_space = half_space_compliance_on_same_nodes(body, zone, at.ball_radius, *elastic, degree, frame, lines)
        kernels.append(matrix - half_space)
    return kernel_from_groove_response(kernels[0], zone, degree), ComplianceKernel(kernels[1], zone.half_lengths, degree)


def kernel_from_groove_response(added: Array, zone: ContactZone, degree: int) -> ComplianceKernel:
    """Convert a groove's compliance to a kernel for forces on the ball and motions of the ball relative to the groove.

    Tangential forces and motions change their signs, because those of ball and groove are opposite.

    Parameters
    ----------
    added : (3 k, 3 k) Array
        Compliance of the groove less that of the half-space [m/N]; k: number of monomials of the kernel.
    zone : ContactZone
        Contact zone.
    degree : int
        Degree of the kernel's polynomials.

    Returns
    -------
    ComplianceKernel
        The kernel.
    """
    signs = np.repeat([-1.0, -1.0, 1.0], len(added) // 3)
    return ComplianceKernel(added * np.outer(signs, signs), zone.half_lengths, degree)


#: Contact angles are rounded to multiples of this angle [rad], and loads to whole powers of two, so that similar contacts
#: share their kernel.
STEP = 0.1


@dataclass(frozen=True)
class ContactGeometry:
    """Geometry of a ball's contact with a groove: radii, contact angle, and path of the balls."""

    #: Radius of the ball [m].
    ball_radius: float
    #: Relative radii of curvature of ball and groove along and across the groove [m].
    relative_radii: tuple[float, float]
    #: Angle from the groove's bottom to the contact [rad].
    contact_angle: float
    #: Radius [m] and rise [m/rad] of the path of the balls' centres, as in
    #: `hifi.rolling.kinematics.TrackMotion.path_radius_and_rise`; None: the path is straight.
    path_radius_and_rise: tuple[float, float] | None

    @property
    def groove_radius(self) -> float:
        """Radius of the groove's arc [m]."""
        return 1.0 / (1.0 / self.ball_radius - 1.0 / self.relative_radii[1])

    @property
    def groove_curvature_along(self) -> float:
        """Curvature of the groove's surface along the track [1/m]; positive: concave."""
        return 1.0 / self.ball_radius - 1.0 / self.relative_radii[0]

    @property
    def shared_surface_curvatures(self) -> tuple[float, float]:
        """Curvatures along and across the groove of the surface that ball and groove share [1/m]."""
        one, two = (1.0 / self.ball_radius - 0.5 / r for r in self.relative_radii)
        return one, two

    def contact_zone(self, load: float, young: float, poisson: float, sizes: Sizes) -> ContactZone:
        """Compute the contact zone under a load: the Hertzian ellipse's semi-axes times `Sizes.margin`, with its cells.

        Parameters
        ----------
        load : float
            Contact load [N].
        young : float
            Young's modulus [Pa].
        poisson : float
            Poisson's ratio.
        sizes : Sizes
            Numerical settings.

        Returns
        -------
        ContactZone
            The zone.
        """
        ellipse = solve_hertz(load, *self.relative_radii, young, poisson)
        return ContactZone((sizes.margin * ellipse.semi_x, sizes.margin * ellipse.semi_y), sizes.cells, sizes.growth)


def _calls_that_compute_kernels(
    at: ContactGeometry, load: float, young: float, poisson: float, sizes: Sizes
) -> list[KernelCall]:
    """List the function calls that compute the compliance kernels of ball and groove at one contact.

    These are two calls for a whole ball and a grooved bar, or one call for the patches of both. ``at``: position of the
    contact; ``load``: contact load [N]; ``sizes``: mesh settings of the bodies.
    """
    zone, settings = at.contact_zone(load, young, poisson, sizes), (young, poisson, sizes.degree)
    if sizes.patches and at.path_radius_and_rise is not None:
        return [(compliance_kernels_of_patches, (at, zone, *settings))]
    groove = contact_bodies.Groove(
        at.ball_radius, at.groove_radius, at.contact_angle, sizes.opening, at.groove_curvature_along
    )
    common = (zone, at.shared_surface_curvatures, *settings)
    return [
        (compliance_kernel_of_ball, (at.ball_radius, *common)),
        (compliance_kernel_of_bar, (groove, sizes.bar * at.ball_radius, *common)),
    ]


@lru_cache(maxsize=8)
def _sum_kernels_of_contact(
    at: ContactGeometry, load: float, young: float, poisson: float, sizes: Sizes
) -> ComplianceKernel:
    """Compute the compliance kernel of one contact: the sum of the kernels of its ball and its groove.

    ``at``: position of the contact; ``load``: contact load [N]; ``sizes``: mesh settings of the bodies.
    """
    kernels = [kept_or_computed(call) for call in _calls_that_compute_kernels(at, load, young, poisson, sizes)]
    first, second = kernels if len(kernels) == 2 else kernels[0]
    kernel: ComplianceKernel = first + second
    return kernel if len(kernels) == 1 else kernel.symmetric_in_x


def _round_for_shared_kernel(at: ContactGeometry, load: float) -> tuple[ContactGeometry, float]:
    """Round the contact angle and the load [N] of a contact, so that similar contacts share one compliance kernel.

    Returns the position with a rounded contact angle, and the load rounded up to a power of two [N].
    """
    return replace(at, contact_angle=STEP * round(at.contact_angle / STEP)), float(2.0 ** np.ceil(np.log2(load)))


def compliance_kernel_of_contact(
    at: ContactGeometry, load: float, young: float, poisson: float, sizes: Sizes
) -> ComplianceKernel:
    """Compute the compliance of ball and groove at a contact less that of two half-spaces (kernel of the contact).

    Axis y of the kernel points towards the bottom of the groove; x, y and the normal are right-handed. The effect of the
    ball's other contacts is not included.

    Parameters
    ----------
    at : ContactGeometry
        Position of the contact.
    load : float
        Largest load of the contacts that share the kernel [N].
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.
    sizes : Sizes
        Numerical settings.

    Returns
    -------
    ComplianceKernel
        The kernel.

    Raises
    ------
    ValueError
        The groove, ring or nut has no room for the contact zone or for a patch.
    """
    return _sum_kernels_of_contact(*_round_for_shared_kernel(at, load), young, poisson, sizes)


def compute_and_cache_kernels(
    contacts: Iterable[tuple[ContactGeometry, float]], young: float, poisson: float, sizes: Sizes, processes: int
) -> float:
    """Compute the compliance kernels of several contacts in several processes, and cache them in memory.

    With one process, or one missing kernel, nothing is computed here: kernels are then computed when they are needed.

    Parameters
    ----------
    contacts : Iterable[tuple[ContactGeometry, float]]
        Position of each contact, and the largest load of the contacts that share its kernel [N].
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.
    sizes : Sizes
        Numerical settings.
    processes : int
        Number of processes.

    Returns
    -------
    float
        Processor time of the kernels that were computed here [s].

    Raises
    ------
    ValueError
        The groove, ring or nut of a contact has no room for the contact zone or for a patch.
    """
    rounded = [_round_for_shared_kernel(at, load) for at, load in contacts]
    calls = (call for contact in rounded for call in _calls_that_compute_kernels(*contact, young, poisson, sizes))
    missing = [call for call in dict.fromkeys(calls) if call not in _KEPT]
    if processes == 1 or len(missing) < 2:
        return 0.0
    jobs = [RecordJob("kernels", _result_and_processor_time, call, tuple) for call in missing]
    results = compute_records(jobs, Cache(None), processes)
    for call, result in zip(missing, results, strict=True):
        _store_result(call, result.result[0])
    return float(sum(result.result[1] for result in results))


def _result_and_processor_time(make: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[Any, float]:
    """Compute compliance kernels in a worker process, without keeping them there; also returns the processor time [s]."""
    begin = process_time()
    return make(*arguments), process_time() - begin
