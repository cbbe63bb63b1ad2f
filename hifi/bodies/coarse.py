"""Elastic bodies with refinement boxes: compliance between contact patches through the body.

A body is its coarse mesh plus the condensed patches in its refinement boxes (`hifi.bodies.patch`). A contact with the
forces f moves by A f + H q: A is its compliance with its box fixed, q are the displacements of the box's nodes, and H is
nearly V Q with a few smooth displacement modes V of the contact. So the contact moves by A f + V z with the amplitudes z =
Q q of these modes, and the coarse body of stiffness K responds to the contact forces with z = G V^T f, G = Q K^-1 Q^T.

The local compliance of a contact comes from a submodel: a short, finely meshed piece of its body around the contact. A
coarse body tied to a condensed patch transfers loads from contact to contact well, but is too stiff under a contact's own
load: the displacements of its refinement box and the cells around the refinement box suppress a part of the approach, which
no finer patch restores. That part is local, equal for all contacts of a flank, and decays within a refinement box's size.
So a contact's local compliance is computed in a piece of the body cut off around one contact and meshed as finely as
needed, and the contribution of the coarse body is subtracted:

    A_own = C_fine - V G_coarse V^T,

C_fine (c, c): compliance between the contact's pressure functions in the fine piece; V G_coarse V^T: the same through the
modes V of the coarse body, in the same piece meshed like the coarse body. Both pieces are constrained alike, so that the
effect of the constraint cancels. Modes that the coarse body does not represent are included in A_own as well, as far as
they act on the contact itself. (Known as local defect correction, Hackbusch 1984, or submodelling.) With A_own in place
of A, C = blkdiag(A_own) + V G V^T.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import scipy.sparse as sp
from scipy.linalg import qr
from skfem import Mesh

from rollbench.hifi.bodies.patch import CondensedPatch, PatchMesh, mean_normal_displacement_matrix
from rollbench.hifi.elements import forms
from rollbench.hifi.elements.forms import nodal_volume_form, normalise_weight_rows
from rollbench.hifi.elements.rigid import nodal_displacements_of_rigid_motions
from rollbench.hifi.linear_algebra import symmetric_compliance_of_loads
from rollbench.meshes import fem
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.tet_patch import SUB_TRIANGLES, split_into_linear_tetrahedra


@dataclass(frozen=True)
class BodySocket:
    """Refinement box of a body: the box cut out of its coarse mesh around one contact, which a fine patch fills."""

    #: Indices of the refinement box's nodes in the body's mesh, in the node order of the fine mesh (patch) that fills the
    #: box.
    node_indices: Index
    #: Rotation matrix from the frame of the fine mesh (patch) to that of the body ``(3, 3)``.
    rotation: Array
    #: Groove flank of the contact (0, 1: screw, 2, 3: nut).
    flank: int


#: Sizes of the elliptic pressures that `contact_modes_of_patch` has to represent, over the size of the contact
#: zone, and their positions along each axis of the zone, over the width by which they can be moved inside it.
SIZES, SHIFTS = (0.35, 0.5, 0.65, 0.8, 0.95), (-1.0, -0.5, 0.0, 0.5, 1.0)

#: Weight of loads on single nodes relative to these elliptic pressures; singular value, over the largest one, that counts
#: as round-off.
REST, ROUND_OFF = 1e-3, 1e-13

#: Singular value of a resultant over the largest one that counts as zero: forces through the ball's centre have no moment
#: about it.
NO_RESULTANT = 1e-9


def contact_modes_of_patch(patch: CondensedPatch, mode_count: int) -> tuple[Array, Array]:
    """Find a few displacement modes V of a contact and their nodal forces Q on its refinement box, so that H is nearly V Q.

    H (`CondensedPatch.H`) gives the displacements of the contact by the motion of the refinement box, the box that the
    patch fills; H^T gives the forces on the refinement box by the contact loads.

    The first modes belong to the independent resultants (forces and moments) of the contact loads. Each gives the nodal
    forces on the refinement box that contact pressures cause on average per unit of the resultant, so that the forces
    Q^T V^T f on the box have the same resultant as any contact loads f. The resultants are computed from the contact loads
    themselves; H of a coarser patch gives them only to some 1e-4 (`hifi.bodies.patch.condense_patch`). The next modes
    belong to the strongest of the remaining forces on the refinement box, which have no resultant. The last modes belong to
    the small forces with a resultant that remain because of the error of H, so that V Q equals H with all modes.

    The contact pressures are elliptic, of several sizes and positions in the contact zone
    (`elliptic_pressures_of_unit_force`), so that the modes do not depend on the grid and few are needed. Unit loads on
    single contact nodes are included with the small weight `REST`.

    Parameters
    ----------
    patch : CondensedPatch
        Condensed fine mesh (patch) around the contact, with c contact nodes.
    mode_count : int
        Number of modes; fewer where the remainder is below `ROUND_OFF`.

    Returns
    -------
    V : (c, k) Array
        k orthonormal displacement modes of the contact.
    Q : (k, 3 nodes) Array
        Nodal forces of these modes on the degrees of freedom of the refinement box's nodes.
    """
    rigid, moved = rigid_motions_of_patch(patch)
    W, strength, _ = np.linalg.svd(moved, full_matrices=False)
    resultants = (W * strength)[:, strength > NO_RESULTANT * strength[0]]
    pressures = elliptic_pressures_of_unit_force(patch)
    mean = patch.H.T @ pressures - rigid @ ((patch.H @ rigid - moved).T @ pressures)
    mean = mean @ np.linalg.pinv(resultants.T @ pressures)
    remainder = patch.H - resultants @ mean.T
    traces = remainder.T @ np.hstack([pressures, REST * np.eye(len(remainder))])
    wrong = rigid.T @ traces
    least = ROUND_OFF * float(np.linalg.norm(patch.H.T @ pressures))
    balanced = _dominant_left_singular_vectors(traces - rigid @ wrong, least)
    U = np.hstack([balanced, rigid @ _dominant_left_singular_vectors(wrong, least)])
    U = U[:, : max(mode_count - mean.shape[1], 0)]
    V, T = np.linalg.qr(np.hstack([resultants, remainder @ U]))
    return V, T @ np.vstack([mean.T, U.T])


def _dominant_left_singular_vectors(traces: Array, least: float) -> Array:
    """Return as columns the left singular vectors of a matrix ``(n, s)`` whose singular values exceed ``least``.

    The vector of the largest singular value comes first. ``traces``: the matrix; its columns are s nodal loads on a
    refinement box of n degrees of freedom.
    """
    U, strength, _ = np.linalg.svd(traces, full_matrices=False)
    return np.asarray(U[:, strength > least])


def rigid_motions_of_patch(patch: CondensedPatch) -> tuple[Array, Array]:
    """Compute six independent rigid motions of a patch, as displacements of its contact nodes and of its refinement box.

    Parameters
    ----------
    patch : CondensedPatch
        Condensed fine mesh (patch) around the contact.

    Returns
    -------
    rigid : (3 nodes, 6) Array
        Orthonormal rigid motions of the refinement box's nodes.
    moved : (c, 6) Array
        Displacement along the normal at each of c contact nodes, averaged with its pressure basis function, by each motion.
    """
    centre = patch.socket_points.mean(axis=0)
    rigid, T = np.linalg.qr(nodal_displacements_of_rigid_motions(patch.socket_points, centre))
    at_contact = nodal_displacements_of_rigid_motions(patch.contact_points, centre).reshape(-1, 3, 6)
    along = np.einsum("cx,cxk->ck", patch.normals, at_contact)
    return rigid, np.linalg.solve(T.T, (normalise_weight_rows(patch.pressure_weights) @ along).T).T


def elliptic_pressures_of_unit_force(patch: CondensedPatch) -> Array:
    """Compute the nodal forces of elliptic (Hertzian) pressures with unit resultant in the contact zone of a patch.

    The ellipses have the proportions of the contact zone, the relative sizes `SIZES` and the positions `SHIFTS`.

    Parameters
    ----------
    patch : CondensedPatch
        Condensed fine mesh (patch) around the contact.

    Returns
    -------
    (c, s) Array
        Forces at the c contact nodes [N] for each of s pressure distributions, as columns.
    """
    middle = patch.contact_points - patch.contact_points.mean(axis=0)
    x = middle @ np.linalg.svd(middle, full_matrices=False)[2][:2].T
    x = (x - 0.5 * (x.max(axis=0) + x.min(axis=0))) / (0.5 * np.ptp(x, axis=0))
    out = []
    for size, *place in product(SIZES, SHIFTS, SHIFTS):
        at = (1.0 - size) * np.array(place)
        force = patch.nodal_areas * np.sqrt(np.maximum(1.0 - (((x - at) / size) ** 2).sum(axis=1), 0.0))
        if force.any():
            out.append(force / force.sum())
    return np.array(out).T


def degrees_of_freedom_of_nodes(nodes: Index) -> Index:
    """Return the indices 3 i, 3 i + 1, 3 i + 2 of the degrees of freedom of nodes i, along x, y and z.

    Parameters
    ----------
    nodes : (n,) Index
        Indices i of the nodes.

    Returns
    -------
    (3 n,) Index
        Indices of the degrees of freedom, node after node.

    Examples
    --------
    >>> degrees_of_freedom_of_nodes(np.array([0, 2])).tolist()
    [0, 1, 2, 6, 7, 8]
    """
    return np.asarray((3 * nodes[:, None] + np.arange(3)).ravel(), dtype=np.int64)


def convert_mesh_order(mesh: Mesh, element_type: str) -> Mesh:
    """Convert a mesh of 10-node tetrahedra to elements of the wanted order, with its named boundaries.

    For "P1" each tetrahedron is split into eight first-order ones of half the size with the same nodes. The fine meshes
    (patches) around the contacts are then tied to the coarse mesh by linear interpolation
    (`hifi.bodies.patch.refinement_box_interpolation_matrix`).

    Parameters
    ----------
    mesh : Mesh
        10-node tetrahedra.
    element_type : str
        Wanted order: "P2" (second order, the mesh as given) or "P1" (first order).

    Returns
    -------
    Mesh
        The mesh.

    Raises
    ------
    ValueError
        ``element_type`` is neither "P1" nor "P2".
    """
    if element_type not in ("P1", "P2"):
        raise ValueError(f"the element type of a body's coarse mesh must be 'P1' or 'P2', got {element_type!r}")
    if element_type == "P2":
        return mesh
    points = fem.node_coordinates(mesh)
    named = {
        name: fem.nodes_of_boundary_faces(mesh, name)[:, np.array(SUB_TRIANGLES)].reshape(-1, 3)
        for name in mesh.boundaries or {}
    }
    return fem.build_mesh(points, split_into_linear_tetrahedra(points, fem.nodes_of_cells(mesh)), "P1", named)[0]


def assemble_body_stiffness(
    mesh: Mesh, boxes: Sequence[BodySocket], patches: dict[int, CondensedPatch], young: float, poisson: float
) -> sp.csc_array:
    """Assemble the stiffness of a coarsely meshed body with condensed fine patches in the refinement boxes at its contacts.

    Parameters
    ----------
    mesh : Mesh
        Mesh of the coarse body, of n nodes.
    boxes : Sequence[BodySocket]
        Refinement boxes of the body: pockets of its coarse mesh that the fine patches fill.
    patches : dict[int, CondensedPatch]
        Condensed fine mesh (patch) at the contacts of each flank.
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    (3 n, 3 n) sparse array
        Stiffness [N/m].
    """
    K = forms.elastic_stiffness(mesh, young, poisson)
    rows, columns, values = [], [], []
    for box in boxes:
        S = patches[box.flank].S
        k = len(box.node_indices)
        R = box.rotation
        turned = np.einsum("ab,ibjc,dc->iajd", R, S.reshape(k, 3, k, 3), R).reshape(3 * k, 3 * k)
        dof = degrees_of_freedom_of_nodes(box.node_indices)
        rows.append(np.repeat(dof, 3 * k))
        columns.append(np.tile(dof, 3 * k))
        values.append(turned.ravel())
    if values:
        added = sp.coo_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=K.shape)
        K = (K + added.tocsc()).tocsc()
    return K


def assemble_mode_forces(boxes: Sequence[BodySocket], mode_forces: dict[int, Array], freedom_count: int) -> sp.csr_array:
    """Assemble the matrix Q of nodal forces that unit modal forces of all contacts exert on a body's degrees of freedom.

    The nodal forces of a refinement box are given in the frame of its patch, and rotated into the frame of the body.

    Parameters
    ----------
    boxes : Sequence[BodySocket]
        Refinement boxes of the body: pockets of its coarse mesh that the fine patches fill.
    mode_forces : dict[int, Array]
        For each flank, the nodal forces Q of a patch's k modes on the degrees of freedom of its refinement box ``(k, 3
        nodes)``.
    freedom_count : int
        Number of the body's degrees of freedom.

    Returns
    -------
    (r, freedom_count) sparse array
        Matrix Q with a row for each of the r modes of all refinement boxes, box after box.
    """
    data, row, column = [], [], []
    start = 0
    for box in boxes:
        Q = mode_forces[box.flank]
        k = len(box.node_indices)
        turned = np.einsum("mib,ab->mia", Q.reshape(len(Q), k, 3), box.rotation).reshape(len(Q), 3 * k)
        data.append(turned.ravel())
        row.append(np.repeat(start + np.arange(len(Q)), 3 * k))
        column.append(np.tile(degrees_of_freedom_of_nodes(box.node_indices), len(Q)))
        start += len(Q)
    parts = (np.concatenate(data), (np.concatenate(row), np.concatenate(column)))
    return sp.coo_array(parts, shape=(start, freedom_count)).tocsr()


def select_isostatic_freedoms(points: Array, excluded_nodes: Index) -> Index:
    """Select six degrees of freedom that constrain the rigid motions of a free body without straining it.

    The six are chosen by a pivoted factorisation of the body's rigid motions.

    Parameters
    ----------
    points : (n, 3) Array
        Coordinates of the nodes [m].
    excluded_nodes : Index
        Indices of nodes that must not be constrained.

    Returns
    -------
    (6,) Index
        Indices of the degrees of freedom.
    """
    allowed = np.setdiff1d(np.arange(len(points)), excluded_nodes)
    pick = allowed[np.linspace(0, len(allowed) - 1, min(200, len(allowed))).astype(int)]
    modes = nodal_displacements_of_rigid_motions(points[pick], points.mean(axis=0))
    size = float(np.abs(points - points.mean(axis=0)).max())
    modes = modes / np.array([1, 1, 1, size, size, size])
    _, _, order = qr(modes.T, pivoting=True)
    return np.asarray(degrees_of_freedom_of_nodes(pick)[order[:6]])


def body_forces_like_rigid_motions(mesh: Mesh) -> Array:
    """Compute the nodal forces of six body-force fields that are distributed over the volume like the six rigid motions.

    Such fields balance the loads on a free body (inertia relief).

    Parameters
    ----------
    mesh : Mesh
        Body of n nodes.

    Returns
    -------
    (6, 3 n) Array
        Nodal forces of each field [N], in the order of the motions of `nodal_displacements_of_rigid_motions`.
    """
    V = forms.cell_basis(mesh)
    volume = nodal_volume_form().assemble(V)
    first_moments = np.stack([nodal_volume_form(k).assemble(V) for k in range(3)], axis=1)
    loads = nodal_displacements_of_rigid_motions(first_moments).reshape(-1, 3, 6)
    loads[..., :3] *= volume[:, None, None]
    return np.asarray(loads.reshape(-1, 6).T)


def all_freedoms_from_free_ones(mesh: Mesh, fixed_freedoms: Index) -> sp.csc_array:
    """Return the matrix that gives all degrees of freedom of a body from the free ones; fixed degrees of freedom are zero.

    Parameters
    ----------
    mesh : Mesh
        The body.
    fixed_freedoms : Index
        Indices of the fixed degrees of freedom.

    Returns
    -------
    (3 n, f) sparse array
        Transformation matrix with one column for each of the f free degrees of freedom.
    """
    size = mesh.doflocs.size
    return sp.eye_array(size, format="csc")[:, np.setdiff1d(np.arange(size), fixed_freedoms)]


def all_freedoms_with_rigid_end(mesh: Mesh, high: float) -> sp.csc_array:
    """Return the matrix C that gives all degrees of freedom of a body with one fixed and one rigid end from the free ones.

    The boundary "low end" is fixed, and the boundary "high end" moves as a rigid section. With the stiffness K of the mesh,
    C^T K C is the stiffness of the constrained body. (scikit-fem's `mpc` would drop the equations of the section.)

    Parameters
    ----------
    mesh : Mesh
        The body.
    high : float
        Axial position z of the reference point of the rigid section [m].

    Returns
    -------
    (3 n, f + 6) sparse array
        Transformation matrix C from f free degrees of freedom and the six of the section, which come last.
    """
    upper = fem.nodes_on_boundaries(mesh, "high end")
    slaves = degrees_of_freedom_of_nodes(upper)
    fixed = fem.degrees_of_freedom_on_boundaries(mesh, "low end")
    free = all_freedoms_from_free_ones(mesh, np.concatenate([fixed, slaves]))
    section = nodal_displacements_of_rigid_motions(fem.node_coordinates(mesh)[upper], np.array([0.0, 0.0, high]))
    at_section = sp.eye_array(free.shape[0], format="csc")[:, slaves] @ sp.csc_array(section)
    return sp.hstack([free, at_section]).tocsc()


#: Number of meshes of a coarse piece over which the response of the piece is averaged. Their sizes differ by a hundredth,
#: so that the scatter of unstructured meshes (some ten thousandths of an approach) does not enter all contacts of a flank.
REALISATIONS = 3

#: Relative difference of the element sizes of these meshes.
STEP = 0.01


@dataclass(frozen=True)
class ContactSubmodel:
    """Mesh of a short piece of a body around one contact: the submodel that gives the contact's local compliance."""

    #: Mesh of the piece of the body.
    mesh: Mesh
    #: Indices, in ``mesh``, of the nodes of the refinement box (the hole for the fine mesh at the contact), in the order of
    #: the mesh of the box's faces.
    box_nodes: Index
    #: Rotation matrix from the frame of the fine mesh (patch) at the contact to that of ``mesh`` ``(3, 3)``.
    rotation: Array
    #: Names of the boundaries at which the piece is fixed; without any, the loads are balanced by body forces that vary in
    #: space like rigid-body motions (inertia relief).
    fixed_boundaries: tuple[str, ...]


def contact_compliance_in_fine_submodel(
    piece: ContactSubmodel, patch: PatchMesh, normals: Array, young: float, poisson: float
) -> Array:
    """Compute the compliance C_fine between the c nodes of a contact in a finely meshed piece of its body.

    Parameters
    ----------
    piece : ContactSubmodel
        Piece of the body.
    patch : PatchMesh
        Fine mesh (patch) that fills the refinement box of the piece.
    normals : (c, 3) Array
        Directions of the contact loads at the c contact nodes.
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    (c, c) Array
        Displacement along the normal at each node, averaged with its pressure basis function, by unit nodal forces [m/N].

    Raises
    ------
    FactorError
        The stiffness of the piece cannot be factored.
    """
    return compliance_of_patch_in_submodel(piece, patch, mean_normal_displacement_matrix(patch, normals), young, poisson)


def compliance_of_patch_in_submodel(
    piece: ContactSubmodel, patch: PatchMesh, nodal_forces: sp.csr_array, young: float, poisson: float
) -> Array:
    """Compute the compliance between several load cases on a fine patch that is solved together with the body around it.

    The body is a short piece, in whose refinement box the patch lies.

    Parameters
    ----------
    piece : ContactSubmodel
        Piece of the body.
    patch : PatchMesh
        Fine mesh (patch) of n nodes around the contact.
    nodal_forces : (m, 3 n) sparse array
        Nodal forces on the patch in m load cases.
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    (m, m) Array
        Compliance [m/N]: work of load case i on the displacements by a unit of load case j.

    Raises
    ------
    FactorError
        The stiffness of the piece cannot be factored.
    """
    K_patch, K_body = (forms.elastic_stiffness(x.mesh, young, poisson) for x in (patch, piece))
    size = K_patch.shape[0]
    outer = degrees_of_freedom_of_nodes(patch.interface_nodes)
    inner = np.setdiff1d(np.arange(size), outer)
    free, loads = _free_freedoms_and_balancing_loads(piece)
    place = np.full(K_body.shape[0], -1, dtype=np.int64)
    place[free] = inner.size + np.arange(free.size)
    # the interface follows the refinement box's nodes: patch's frame = R^T times the body's
    turn = sp.block_diag([sp.csr_array(piece.rotation.T)] * piece.box_nodes.size)
    tie = (sp.kron(patch.interface_weights, sp.eye_array(3)) @ turn).tocoo()
    lines = np.concatenate([inner, outer[tie.row]])
    columns = np.concatenate([np.arange(inner.size), place[degrees_of_freedom_of_nodes(piece.box_nodes)][tie.col]])
    T = sp.csr_array((np.concatenate([np.ones(inner.size), tie.data]), (lines, columns)), (size, inner.size + free.size))
    body = K_body[free][:, free].tocoo()
    shape = (T.shape[1], T.shape[1])
    K = (T.T @ K_patch @ T + sp.coo_array((body.data, (body.row + inner.size, body.col + inner.size)), shape)).tocsc()
    relief = sp.hstack([sp.csr_array((loads.shape[0], inner.size)), loads[:, free]])
    F = symmetric_compliance_of_loads(K, sp.vstack([nodal_forces @ T, relief]).tocsr())
    work = nodal_forces @ _rigid_motions_in_patch_frame(patch, piece)
    return _compliance_of_balanced_loads(F, nodal_forces.shape[0], work, loads, piece)


def mode_compliance_in_coarse_submodel(
    piece: ContactSubmodel, patch: CondensedPatch, mode_forces: Array, young: float, poisson: float
) -> Array:
    """Compute the compliance G_coarse between the displacement modes of a contact in a piece meshed like the coarse body.

    Parameters
    ----------
    piece : ContactSubmodel
        Piece of the body.
    patch : CondensedPatch
        Condensed fine mesh (patch) that fills the refinement box of the piece.
    mode_forces : (k, 3 nodes) Array
        Nodal forces Q of the k modes on the degrees of freedom of the refinement box's nodes.
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    (k, k) Array
        Compliance G_coarse between the modes [m/N].

    Raises
    ------
    FactorError
        The stiffness of the piece cannot be factored.
    """
    box = BodySocket(piece.box_nodes, piece.rotation, 0)
    K = assemble_body_stiffness(piece.mesh, [box], {0: patch}, young, poisson)
    return compliance_of_submodel(piece, K, assemble_mode_forces([box], {0: mode_forces}, K.shape[0]))


def compliance_of_submodel(piece: ContactSubmodel, K: sp.sparray, nodal_forces: sp.csr_array) -> Array:
    """Compute the compliance between several load cases on a piece of a body, fixed at its boundaries or balanced.

    Parameters
    ----------
    piece : ContactSubmodel
        Piece of the body, with n nodes.
    K : (3 n, 3 n) sparse array
        Its stiffness [N/m].
    nodal_forces : (m, 3 n) sparse array
        Nodal forces of m load cases.

    Returns
    -------
    (m, m) Array
        Compliance [m/N]: work of load case i on the displacements by a unit of load case j.

    Raises
    ------
    FactorError
        The stiffness of the piece cannot be factored.
    """
    free, loads = _free_freedoms_and_balancing_loads(piece)
    F = symmetric_compliance_of_loads(K[free][:, free].tocsc(), sp.vstack([nodal_forces, loads]).tocsr()[:, free])
    work = nodal_forces @ nodal_displacements_of_rigid_motions(fem.node_coordinates(piece.mesh))
    return _compliance_of_balanced_loads(F, nodal_forces.shape[0], work, loads, piece)


def local_contact_compliance(fine_compliance: Array, V: Array, coarse_mode_compliances: Sequence[Array]) -> Array:
    """Compute a contact's local compliance, which its body's coarse mesh lacks: fine less coarse compliance of a piece.

    Parameters
    ----------
    fine_compliance : (c, c) Array
        Compliance C_fine between the c contact nodes in the finely meshed piece [m/N].
    V : (c, k) Array
        Displacement modes of the contact that the coarse body represents.
    coarse_mode_compliances : Sequence[Array]
        Compliance G_coarse ``(k, k)`` [m/N] of each of several coarse pieces, by `mode_compliance_in_coarse_submodel`;
        their element sizes differ by multiples of `STEP`.

    Returns
    -------
    (c, c) Array
        C_fine - V G_coarse V^T [m/N], with the mean of G_coarse over the coarse pieces.
    """
    G = np.mean(coarse_mode_compliances, axis=0)
    A = fine_compliance - V @ G @ V.T  # A_own = C_fine - V G_coarse V^T
    return np.asarray(0.5 * (A + A.T))


def _free_freedoms_and_balancing_loads(piece: ContactSubmodel) -> tuple[Index, sp.csr_array]:
    """Return the free degrees of freedom of a piece of a body, and six fields of nodal forces that can balance its loads.

    The fields ``(6, 3 n)`` are body forces distributed like the rigid motions; a piece with fixed boundaries has none.
    """
    size = piece.mesh.doflocs.size
    if piece.fixed_boundaries:
        held = fem.degrees_of_freedom_on_boundaries(piece.mesh, *piece.fixed_boundaries)
        return np.setdiff1d(np.arange(size), held), sp.csr_array((0, size))
    held = select_isostatic_freedoms(fem.node_coordinates(piece.mesh), piece.box_nodes)
    return np.setdiff1d(np.arange(size), held), sp.csr_array(body_forces_like_rigid_motions(piece.mesh))


def _rigid_motions_in_patch_frame(patch: PatchMesh, piece: ContactSubmodel) -> Array:
    """Compute the displacements of a patch's n nodes by six unit rigid motions of the body around it ``(3 n, 6)``.

    The displacements are components along the axes of the patch; the motions are along and about the axes of ``piece``, the
    piece of the body around the patch.
    """
    rigid = nodal_displacements_of_rigid_motions(fem.node_coordinates(patch.mesh) @ piece.rotation.T).reshape(-1, 3, 6)
    return np.asarray(np.einsum("ba,nbk->nak", piece.rotation, rigid).reshape(-1, 6))


def _compliance_of_balanced_loads(F: Array, count: int, rigid: Array, loads: sp.csr_array, piece: ContactSubmodel) -> Array:
    """Compute the compliance ``(count, count)`` [m/N] between loads that body forces balance on a free body.

    The body forces are distributed like the rigid motions. F: compliance between the loads and, after them, the six fields
    of body forces [m/N]; ``count``: number of loads; ``rigid``: work of the loads on the rigid motions (count, 6);
    ``loads``: nodal forces of the body forces (6, 3 n), or none for a fixed piece, whose F is returned.
    """
    if loads.shape[0] == 0:
        return F
    mass = loads @ nodal_displacements_of_rigid_motions(fem.node_coordinates(piece.mesh))
    S = np.hstack([np.eye(count), -np.linalg.solve(mass, rigid.T).T])
    return np.asarray(S @ F @ S.T)
