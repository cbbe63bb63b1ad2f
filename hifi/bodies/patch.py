"""A fine groove or ball patch, condensed once onto its refinement box and its contact normals.

The patch consists of 27-node hexahedra on a rectangular grid, or of first-order tetrahedra sized as in Lin's thesis. It
is loaded by forces f along the contact normals, each distributed by a pressure basis function (`hifi.elements.forms`), and
its boundary follows the displacements q of the nodes of its refinement box, the box in the coarse mesh that the patch
fills. The mean displacements u_c of the contact along its normals, and the forces r on the nodes of the box, are

    u_c = A f + H q,   r = S q - H^T f,

with the compliance A of the contact for a fixed box, the stiffness S of the patch at the box, and the displacements H of
the contact by unit displacements of the box's nodes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from skfem import ElementLineP2, Mesh, condense

from rollbench.hifi.elements import forms
from rollbench.hifi.linear_algebra import factorise_positive_definite, symmetric_compliance_of_loads
from rollbench.meshes import fem
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.sockets import RefinementBoxFaces
from rollbench.meshes.tet_patch import TetrahedralPatchMesh, signed_volumes

Flags = NDArray[np.bool_]

#: Tie of a patch to its refinement box of k nodes: indices of the patch's nodes on the box's faces (interface), weights
#: that interpolate them from the box's nodes, and positions of the box's nodes ``(k, 3)`` [m].
Tie = tuple[Index, sp.csr_array, Array]

#: Planes (axis, value) of local coordinates on which a patch's inner faces lie.
PLANES = ((0, -1.0), (0, 1.0), (1, 1.0), (2, -1.0), (2, 1.0))


@dataclass(frozen=True)
class PatchCellBoundaries:
    """Cell boundaries of the fine mesh (patch) around a contact, in its three local coordinates."""

    #: Boundaries across the groove, in the direction of the contact angle gamma, from -1 to 1.
    across: Array
    #: Boundaries in depth, from 0 at the surface to 1.
    depth: Array
    #: Boundaries along the groove, in the direction of the azimuth, from -1 to 1.
    along: Array


@dataclass(frozen=True)
class PatchMesh(fem.MeshedBody):
    """Fine mesh (patch) around one contact, which fills a box cut out of the coarse mesh of a body (refinement box).

    Its named boundaries are "surface", "contact" (the contact zone on the surface) and "interface" (to the body).
    """

    #: Local coordinates of the nodes: across the groove, in depth, along the groove ``(n, 3)``.
    local_coordinates: Array
    #: Indices of the nodes of the contact zone ``(c,)``.
    contact_nodes: Index
    #: Numbers of the contact zone's nodes across and along the groove; None: they form no grid.
    contact_grid_shape: tuple[int, int] | None
    #: Whether each node of the contact zone is one of its outermost nodes ``(c,)``.
    on_zone_edge: Flags
    #: Indices of the nodes on the interface to the coarse mesh of the body.
    interface_nodes: Index
    #: Weights that interpolate displacements of the interface nodes from those of the refinement box's nodes
    #: ``(interface nodes, box nodes)``.
    interface_weights: sp.csr_array
    #: Integration weights W ``(c, c)`` [m2] of the pressure basis functions (rows) at the displacements of the contact
    #: nodes (columns), by `hifi.elements.forms.pressure_function_integrals`.
    pressure_weights: sp.csr_array
    #: Positions of the refinement box's nodes ``(k, 3)`` [m].
    socket_points: Array

    @property
    def element_type(self) -> str:
        """Element type: "P1" (first-order tetrahedra) or "Q2" (hexahedra of 27 nodes)."""
        return fem.element_type_of_mesh(self.mesh)

    @property
    def areas(self) -> Array:
        """Areas of the surface that belong to the c contact nodes: integrals of their pressure basis functions [m2]."""
        return np.asarray(self.pressure_weights.sum(axis=1)).ravel()


@dataclass(frozen=True)
class CondensedPatch:
    """Fine mesh (patch) around a contact, condensed to its c contact nodes and to the k nodes of its refinement box.

    The refinement box is the box in the coarse mesh of the body that the patch fills. The condensed equations are u_c = A f
    + H q and r = S q - H^T f. f: contact loads (c,) [N]; u_c: displacements along the normals, averaged with each node's
    pressure basis function (c,) [m]; q: displacements of the refinement box's nodes (3 k,) [m]; r: forces on them (3 k,)
    [N].
    """

    #: Compliance of the contact nodes with the refinement box fixed: mean normal displacements by unit contact loads
    #: ``(c, c)`` [m/N].
    A: Array
    #: Mean normal displacements of the contact nodes by unit displacements of the refinement box's nodes ``(c, 3 k)``; H^T
    #: gives the nodal forces on the box by contact loads.
    H: Array
    #: Stiffness of the patch at the nodes of the refinement box ``(3 k, 3 k)`` [N/m].
    S: Array
    #: Positions of the contact nodes ``(c, 3)`` [m].
    contact_points: Array
    #: Unit contact normals at the contact nodes ``(c, 3)``.
    normals: Array
    #: Areas of the contact nodes (integrals of their pressure basis functions) ``(c,)`` [m2].
    nodal_areas: Array
    #: Whether each contact node is one of the outermost nodes of the contact zone ``(c,)``.
    on_zone_edge: Flags
    #: Numbers of contact nodes across and along the groove; None: they form no grid.
    contact_grid_shape: tuple[int, int] | None
    #: Integration weights W ``(c, c)`` [m2]: pressure basis functions as rows, displacements of the contact nodes as
    #: columns.
    pressure_weights: sp.csr_array
    #: Positions of the refinement box's nodes ``(k, 3)`` [m], in the patch's frame.
    socket_points: Array
    #: Number of degrees of freedom of the fine mesh before condensation.
    degree_of_freedom_count: int


def graded_cell_boundaries(uniform_half_length: float, step: float, growth: float) -> Array:
    """Divide the interval [-1, 1] into cells of equal size in its inner part, and of growing size towards its ends.

    Parameters
    ----------
    uniform_half_length : float
        Half the length of the inner part, from -uniform_half_length to uniform_half_length.
    step : float
        Approximate cell size in that part.
    growth : float
        Approximate ratio of neighbouring cell sizes beyond that part.

    Returns
    -------
    Array
        Boundaries of the cells, ascending from -1 to 1.

    Examples
    --------
    >>> graded_cell_boundaries(0.5, 0.5, 1.0).tolist()
    [-1.0, -0.5, 0.0, 0.5, 1.0]
    """
    cells = max(1, round(2.0 * uniform_half_length / step))
    beyond = growing_cell_boundaries(uniform_half_length, 1.0, 2.0 * uniform_half_length / cells, growth)[1:]
    return np.concatenate([-beyond[::-1], np.linspace(-uniform_half_length, uniform_half_length, cells + 1), beyond])


def growing_cell_boundaries(start: float, end: float, first: float, ratio: float) -> Array:
    """Divide an interval into cells whose sizes grow by a constant ratio.

    Parameters
    ----------
    start, end : float
        First and last boundary.
    first : float
        Approximate size of an imaginary cell before ``start``, from which the cells grow.
    ratio : float
        Ratio of neighbouring cell sizes.

    Returns
    -------
    Array
        Boundaries of the cells, ascending from ``start`` to ``end``.

    Examples
    --------
    >>> growing_cell_boundaries(0.0, 7.0, 0.5, 2.0).tolist()
    [0.0, 1.0, 3.0, 7.0]
    """
    steps = [first * ratio]
    while sum(steps) < end - start:
        steps.append(steps[-1] * ratio)
    widths = np.array(steps) * (end - start) / sum(steps)
    return start + np.concatenate([[0.0], np.cumsum(widths)])


def mesh_hexahedral_patch(
    lines: PatchCellBoundaries, zone: tuple[float, float], to_space: Callable[[Array], Array], box_faces: RefinementBoxFaces
) -> PatchMesh:
    """Mesh the patch around a contact with 27-node hexahedra, and tie it to the box that it fills in the coarse mesh.

    The patch's nodes on the faces of this refinement box (interface) are moved onto the box's second-order triangles, so
    that rigid motions of the refinement box cause no strain.

    Parameters
    ----------
    lines : PatchCellBoundaries
        Cell boundaries in local coordinates.
    zone : tuple[float, float]
        Half widths of the contact zone across and along the groove, in local coordinates.
    to_space : Callable[[Array], Array]
        Function that maps local coordinates ``(n, 3)`` to points ``(n, 3)`` [m].
    box_faces : RefinementBoxFaces
        Mesh of the refinement box's faces.

    Returns
    -------
    PatchMesh
        Fine mesh (patch) around the contact.

    Raises
    ------
    ValueError
        An interface node lies on no triangle.
    """
    for left_handed in (False, True):
        grid = fem.mesh_rectangular_grid(lines.across, lines.depth, lines.along, "Q2", left_handed=left_handed)
        points, tie = _map_nodes_into_refinement_box(fem.node_coordinates(grid), to_space, box_faces)
        mesh = fem.with_node_coordinates(grid, points)
        if forms.CachedIsoparametricMap(mesh).detDF(np.full((3, 1), 0.5), tind=np.array([0])) >= 0.0:
            break  # else the map is left-handed, and every cell is mirrored
    xi = fem.node_coordinates(grid)
    top = np.abs(xi[:, 1]) < 1e-12
    inside = (np.abs(xi[:, 0]) <= zone[0] + 1e-9) & (np.abs(xi[:, 2]) <= zone[1] + 1e-9)
    contact = np.flatnonzero(top & inside)
    place_of = np.round(xi[contact], 9)
    contact = contact[np.lexsort((place_of[:, 2], place_of[:, 0]))]
    counts = (len(np.unique(place_of[:, 0])), len(np.unique(place_of[:, 2])))
    i, k = np.divmod(np.arange(contact.size), counts[1])
    rim = (i % (counts[0] - 1) == 0) | (k % (counts[1] - 1) == 0)
    return _create_patch_mesh(mesh, xi, top, contact, counts, rim, tie)


def fit_tetrahedral_patch(
    local: TetrahedralPatchMesh, to_space: Callable[[Array], Array], box_faces: RefinementBoxFaces
) -> PatchMesh:
    """Map a box of first-order tetrahedra into space as the patch around a contact, and tie it to the coarse mesh.

    The coarse body may be of first or second order. The area of a contact node is a third of the area of the triangles
    around it. See `mesh_hexahedral_patch` for hexahedra.

    Parameters
    ----------
    local : TetrahedralPatchMesh
        Tetrahedra in local coordinates.
    to_space : Callable[[Array], Array]
        Function that maps local coordinates ``(n, 3)`` to points ``(n, 3)`` [m].
    box_faces : RefinementBoxFaces
        Mesh of the refinement box's faces.

    Returns
    -------
    PatchMesh
        Fine mesh (patch) around the contact.

    Raises
    ------
    ValueError
        The map turns cells inside out, or an interface node lies on no triangle.
    """
    points, tie = _map_nodes_into_refinement_box(local.xi, to_space, box_faces, linear=True)
    volumes = signed_volumes(points, local.tetrahedra)
    if not (np.all(volumes > 0.0) or np.all(volumes < 0.0)):
        raise ValueError(
            "tetrahedra of the fine mesh around a contact are turned inside out when the mesh is mapped from its plane box "
            "onto the curved body: make the edges of the tetrahedra at the rim of the fine mesh shorter"
        )
    cells = local.tetrahedra
    if volumes[0] < 0.0:  # a left-handed map: mirror every cell
        cells = cells[:, [0, 2, 1, 3]]
    mesh, _ = fem.build_mesh(points, cells, "P1")
    top = np.zeros(len(points), dtype=bool)
    top[local.top_triangles] = True
    loose = np.ones(len(points), dtype=bool)
    loose[local.contact_nodes] = False
    beside = np.zeros(len(points), dtype=bool)
    beside[local.top_triangles[loose[local.top_triangles].any(axis=1)]] = True
    contact = local.contact_nodes
    return _create_patch_mesh(mesh, local.xi, top, contact, None, beside[contact], tie)


def _create_patch_mesh(
    mesh: Mesh, xi: Array, top: Flags, contact: Index, shape: tuple[int, int] | None, rim: Flags, tie: Tie
) -> PatchMesh:
    """Create the record of a patch from its mesh and the data of its nodes, and name the boundaries of the mesh.

    A face belongs to the surface, the contact or the interface if all its corners do. ``xi``: local coordinates of the
    nodes (n, 3); ``top``: whether each node lies on the surface (n,); ``contact``: nodes of the contact zone (c,);
    ``shape``: numbers of these nodes across and along the groove, or None; ``rim``: whether each of them is one of the
    outermost (c,); ``tie``: tie of the patch to its refinement box.
    """
    outer = mesh.boundary_facets()
    corners = mesh.facets[:, outer]
    zone = np.zeros(len(top), dtype=bool)
    zone[contact] = True
    tied = np.any([np.all(np.abs(xi[corners, axis] - value) < 1e-9, axis=0) for axis, value in PLANES], axis=0)
    boundaries = {"surface": top[corners].all(axis=0), "contact": zone[corners].all(axis=0), "interface": tied}
    mesh = fem.with_boundaries_from_facets(mesh, {name: outer[on] for name, on in boundaries.items()})
    interface, weights, box_points = tie
    pressure_weights = forms.pressure_function_integrals(mesh, contact)
    return PatchMesh(mesh, xi, contact, shape, rim, interface, weights, pressure_weights, box_points)


def mean_normal_displacement_matrix(mesh: PatchMesh, normals: Array, carrier: PatchMesh | None = None) -> sp.csr_array:
    """Return the matrix that gives the normal displacements of c contact nodes from all nodal displacements of a patch.

    Each displacement is a mean over the contact zone, weighted by the pressure basis function of the node.

    Parameters
    ----------
    mesh : PatchMesh
        Fine mesh (patch) of n nodes around the contact.
    normals : (c, 3) Array
        Directions of the displacements at the c contact nodes.
    carrier : PatchMesh, optional, default None
        Another patch, fitted into the same cut-out (refinement box) of the coarse mesh. If given, the matrix acts on the
        displacements of the n nodes of this other patch, interpolated at the contact nodes of ``mesh``.

    Returns
    -------
    (c, 3 n) sparse array
        Weights of the patch's degrees of freedom in each mean displacement.

    Raises
    ------
    ValueError
        The carrier has no grid.
    """
    c = mesh.contact_nodes.size
    if carrier is None:
        carrier = mesh
        place = sp.csr_array((np.ones(c), (np.arange(c), mesh.contact_nodes)), (c, mesh.mesh.doflocs.shape[1]))
    else:
        place = _grid_interpolation_matrix(carrier, mesh.local_coordinates[mesh.contact_nodes])
    nodal = sp.csr_array((normals.ravel(), (np.repeat(np.arange(c), 3), np.arange(3 * c))), (c, 3 * c))
    means, vectors = forms.normalise_weight_rows(mesh.pressure_weights), sp.kron(place, sp.eye_array(3), format="csr")
    return sp.csr_array(means @ nodal @ vectors)


def _grid_interpolation_matrix(mesh: PatchMesh, xi: Array) -> sp.csr_array:
    """Return the weights ``(p, n)`` that interpolate p points on the surface from the n nodes of a patch with a grid.

    ``xi``: local coordinates of the points (p, 3).
    """
    if mesh.contact_grid_shape is None:
        raise ValueError(
            "displacements cannot be interpolated on a mesh whose contact nodes form no grid: use a mesh of hexahedra"
        )
    top = np.flatnonzero(np.abs(mesh.local_coordinates[:, 1]) < 1e-12)
    nodes, at = mesh.local_coordinates[top][:, [0, 2]], xi[:, [0, 2]]
    axes = [np.unique(np.round(x, 12)) for x in nodes.T]
    number = np.empty([a.size for a in axes], dtype=np.int64)
    number[tuple(np.searchsorted(a, x - 1e-9) for a, x in zip(axes, nodes.T, strict=True))] = top
    rows, columns, values = [], [], []
    shapes = [_quadratic_line_shapes(a, x) for a, x in zip(axes, at.T, strict=True)]
    for (i, u), (k, v) in product(zip(*shapes[0], strict=True), zip(*shapes[1], strict=True)):
        rows.append(np.arange(len(xi)))
        columns.append(number[i, k])
        values.append(u * v)
    parts = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sp.csr_array(parts, (len(xi), mesh.mesh.doflocs.shape[1]))


def _quadratic_line_shapes(nodes: Array, at: Array) -> tuple[list[Index], list[Array]]:
    """Evaluate the shape functions of second-order line elements at p points.

    ``nodes``: coordinates of the nodes of all cells, ascending; ``at``: coordinates of the points (p,). Returned are, for
    each of the three nodes of a point's cell, the index of the node (p,) and the value of its shape function (p,).
    """
    cell = np.clip((np.searchsorted(nodes[::2], at, side="right") - 1), 0, (nodes.size - 3) // 2)
    local = (at - nodes[2 * cell]) / (nodes[2 * cell + 2] - nodes[2 * cell])
    element = ElementLineP2()  # ends, then the middle
    return [2 * cell, 2 * cell + 2, 2 * cell + 1], [element.lbasis(local[None], k)[0] for k in range(3)]


def _map_nodes_into_refinement_box(
    xi: Array, to_space: Callable[[Array], Array], box_faces: RefinementBoxFaces, *, linear: bool = False
) -> tuple[Array, Tie]:
    """Map the nodes of a patch into space; those on the interface to the body lie on the refinement box's triangles.

    ``xi``: local coordinates of the nodes (n, 3); ``to_space``: function that maps them to points [m]; ``linear``: as
    for `refinement_box_interpolation_matrix`. Returned are the points (n, 3) [m], and the tie to the refinement box.
    """
    on_face = np.any([np.abs(xi[:, axis] - value) < 1e-9 for axis, value in PLANES], axis=0)
    interface = np.flatnonzero(on_face)
    weights = refinement_box_interpolation_matrix(xi[interface], box_faces, linear=linear)
    points, box_points = to_space(xi), to_space(box_faces.xi)
    points[interface] = weights @ box_points
    return points, (interface, weights, box_points)


def refinement_box_interpolation_matrix(xi: Array, box_faces: RefinementBoxFaces, *, linear: bool = False) -> sp.csr_array:
    """Return the weights that interpolate points on the inner faces of a refinement box from the nodes of the box.

    Parameters
    ----------
    xi : (n, 3) Array
        Local coordinates of the points.
    box_faces : RefinementBoxFaces
        Mesh of the faces, with k nodes.
    linear : bool, default False
        True: interpolate on four first-order triangles between the nodes of each second-order one.

    Returns
    -------
    (n, k) sparse array
        Weights of the refinement box's nodes at each point.

    Raises
    ------
    ValueError
        A point lies on no triangle of the refinement box.
    """
    rows, columns, values = [], [], []
    done = np.zeros(len(xi), dtype=bool)
    for axis, value in PLANES:
        flat = [k for k in range(3) if k != axis]
        points = np.flatnonzero(~done & (np.abs(xi[:, axis] - value) < 1e-9))
        on_plane = np.all(np.abs(box_faces.xi[box_faces.triangles[:, :3], axis] - value) < 1e-6, axis=1)
        tri = box_faces.triangles[on_plane]
        corner = box_faces.xi[tri[:, :3]][..., flat]
        edges, arms = ((x - corner[:, :1]).swapaxes(1, 2) for x in (corner[:, 1:], xi[points][:, flat]))
        t = np.linalg.solve(edges, arms)
        bary = np.stack([1.0 - t.sum(axis=1), *t.swapaxes(0, 1)], axis=2)
        inside = np.all(bary > -1e-7, axis=2)
        found = np.flatnonzero(inside.any(axis=0))
        first = inside[:, found].argmax(axis=0)
        w = bary[first, found]
        rows.append(np.repeat(points[found], 6))
        columns.append(tri[first].ravel())
        values.append((_linear_triangle_shapes(w) if linear else _quadratic_triangle_shapes(w)).ravel())
        done[points[found]] = True
    if not done.all():
        raise ValueError(
            "a boundary node of the fine mesh around a contact lies on no triangle of the refinement box, the cavity in "
            "the coarse mesh that the fine mesh fills: fine mesh and cavity must have the same size"
        )
    parts = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sp.coo_array(parts, (len(xi), len(box_faces.xi))).tocsr()


def _quadratic_triangle_shapes(w: Array) -> Array:
    """Evaluate the shape functions ``(n, 6)`` of a 6-node triangle at n points of barycentric coordinates ``(n, 3)``."""
    return np.hstack([w * (2 * w - 1), 4 * w * w[:, [1, 2, 0]]])


def _linear_triangle_shapes(w: Array) -> Array:
    """Evaluate piecewise linear shape functions of a 6-node triangle ``(n, 6)`` at barycentric coordinates ``(n, 3)``.

    The functions are linear on each of the four triangles into which the midside nodes divide the 6-node triangle.
    """
    corner, opposite = np.maximum(2 * w - 1, 0.0), np.maximum(1 - 2 * w, 0.0)
    return np.hstack([corner, opposite[:, [2, 0, 1]] - corner - corner[:, [1, 2, 0]]])


@dataclass(frozen=True)
class _PatchStiffnessBlocks:
    """Stiffness of a patch in blocks: inner degrees of freedom, its boundary, and the refinement box it is tied to."""

    #: Stiffness of the inner degrees of freedom ``(i, i)`` [N/m].
    inner_stiffness: sp.csc_array
    #: Stiffness between the inner degrees of freedom and those of the refinement box ``(i, 3 k)`` [N/m].
    inner_to_box_stiffness: sp.csc_array
    #: Stiffness of the degrees of freedom on the patch's boundary to the body (interface) [N/m].
    interface_stiffness: sp.csc_array
    #: Unit contact loads on the inner degrees of freedom ``(i, c)``.
    contact_forces: sp.csc_array
    #: Weights that interpolate the degrees of freedom of the patch's boundary (interface) from those of the refinement box.
    interface_weights: sp.csc_array
    #: Indices of the inner degrees of freedom among all degrees of freedom of the patch ``(i,)``.
    inner_freedoms: Index


def _assemble_patch_stiffness_blocks(
    mesh: PatchMesh, normals: Array, young: float, poisson: float, carrier: PatchMesh | None = None
) -> _PatchStiffnessBlocks:
    """Assemble the stiffness of a patch in blocks for condensation: inner and boundary degrees of freedom.

    ``mesh``: the patch; ``normals``: directions of the contact loads (c, 3); ``young``: Young's modulus [Pa]; ``poisson``:
    Poisson's ratio; ``carrier``: coarser patch of the same refinement box whose mesh is used instead; None: ``mesh``.
    """
    base = mesh if carrier is None else carrier
    K = forms.elastic_stiffness(base.mesh, young, poisson)
    if np.isin(mesh.contact_nodes, mesh.interface_nodes).any():
        raise ValueError(
            "the contact zone reaches the edge of the fine mesh around the contact: make the zone smaller than that mesh"
        )
    inner = np.setdiff1d(np.arange(K.shape[0]), fem.degrees_of_freedom_on_boundaries(base.mesh, "interface"))
    outer = (3 * base.interface_nodes[:, None] + np.arange(3)).ravel()
    T = sp.kron(base.interface_weights, sp.eye_array(3), format="csc")
    coupling = (K[inner][:, outer] @ T).tocsc()
    forces = mean_normal_displacement_matrix(mesh, normals, carrier)[:, inner].T.tocsc()
    return _PatchStiffnessBlocks(condense(K, I=inner, expand=False), coupling, K[outer][:, outer], forces, T, inner)


def condense_patch(
    mesh: PatchMesh, normals: Array, young: float, poisson: float, coarser_patch: PatchMesh | None = None
) -> CondensedPatch:
    """Condense the fine mesh (patch) around a contact to its contact nodes and to the nodes of the refinement box it fills.

    The condensation is exact. If the mesh of a coarser patch in the same refinement box is used instead, the matrices H and
    S of `CondensedPatch` hardly change, but the compliance A of the contact does.

    Parameters
    ----------
    mesh : PatchMesh
        Fine mesh (patch) around the contact.
    normals : (c, 3) Array
        Directions of contact loads and displacements.
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.
    coarser_patch : PatchMesh, optional, default None
        A coarser patch of the same refinement box whose mesh is used in place of that of ``mesh``; None: ``mesh`` is used.

    Returns
    -------
    CondensedPatch
        Condensed fine mesh (patch) around the contact.

    Raises
    ------
    ValueError
        The contact zone reaches the edge of the patch.
    """
    blocks = _assemble_patch_stiffness_blocks(mesh, normals, young, poisson, coarser_patch)
    boundary = (blocks.interface_weights.T @ (blocks.interface_stiffness @ blocks.interface_weights)).toarray()
    c = blocks.contact_forces.shape[1]
    loads = sp.hstack([blocks.contact_forces, blocks.inner_to_box_stiffness])
    F = symmetric_compliance_of_loads(blocks.inner_stiffness, loads.T)
    A, H, S = F[:c, :c], -F[:c, c:], boundary - F[c:, c:]
    return CondensedPatch(
        A=0.5 * (A + A.T),
        H=H,
        S=0.5 * (S + S.T),
        contact_points=mesh.points[mesh.contact_nodes],
        normals=normals,
        nodal_areas=mesh.areas,
        on_zone_edge=mesh.on_zone_edge,
        contact_grid_shape=mesh.contact_grid_shape,
        pressure_weights=mesh.pressure_weights,
        socket_points=mesh.socket_points,
        degree_of_freedom_count=3 * (mesh.mesh.doflocs.shape[1] - mesh.interface_nodes.size),
    )


def nodal_displacements_of_patch(
    mesh: PatchMesh, normals: Array, young: float, poisson: float, forces: Array, box_displacements: Array
) -> Array:
    """Compute the displacements of all nodes of a patch from its contact forces and the motion of its refinement box.

    The equations of the patch are solved once more. At the contact the mean displacements along the normals are those of
    the condensed patch, A f + H q, with its matrices A and H (`CondensedPatch`).

    Parameters
    ----------
    mesh : PatchMesh
        Fine mesh (patch) of n nodes around the contact.
    normals : (c, 3) Array
        Directions of the contact loads.
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.
    forces : (c,) Array
        Contact forces f [N].
    box_displacements : (3 k,) Array
        Displacements q of the refinement box's nodes in the patch's frame [m].

    Returns
    -------
    (n, 3) Array
        Displacements [m].
    """
    blocks = _assemble_patch_stiffness_blocks(mesh, normals, young, poisson)
    u = np.empty(mesh.mesh.doflocs.size)
    loads = blocks.contact_forces @ forces - blocks.inner_to_box_stiffness @ box_displacements
    u[blocks.inner_freedoms] = factorise_positive_definite(blocks.inner_stiffness)(loads)
    u[(3 * mesh.interface_nodes[:, None] + np.arange(3)).ravel()] = blocks.interface_weights @ box_displacements
    return u.reshape(-1, 3)
