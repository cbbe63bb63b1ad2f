"""Elastic bodies with sockets: compliance between contact patches through the body.

A body is its coarse mesh plus the condensed patches in its sockets. Only the few smooth modes in which a patch's contact
forces reach its socket matter: with the transfer H = V Q, of few modes V, the contact nodes of a patch move by u = A f +
V z, z = Q q, and the coarse body responds with z = G V^T f, G = Q K^-1 Q^T.

The local compliance of a contact comes from a submodel: a short piece of its body around it, meshed finely. A coarse body
tied to a condensed patch carries loads from contact to contact well, but is too stiff under a contact's load: the trace
of its socket and the cells around it take away a part of the approach that no finer patch restores. That part is local,
the same for all contacts of a flank, and decays within a socket's size. So a contact's local compliance is taken from a
piece of the body cut off around one contact and meshed as finely as needed, and the share of the coarse body is
subtracted:

    A_own = C_fine - V G_coarse V^T,

C_fine (c, c): compliance between the contact's pressure functions in the fine piece; V G_coarse V^T: the same through the
modes V that the coarse body keeps, in the same piece cut and meshed as the coarse body is. Both pieces are constrained
alike, so that the effect of the constraint cancels. Modes that the coarse body does not keep are in A_own too, as far as
they act on the contact itself. (Local defect correction, Hackbusch 1984; submodelling in the field.) With A_own in place
of A, C = blkdiag(A_own) + V G V^T.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import scipy.sparse as sp
from scipy.linalg import qr
from skfem import Mesh

from rollbench.hifi.bodies.patch import CondensedPatch, PatchMesh, pressure_rows
from rollbench.hifi.elements import forms
from rollbench.hifi.elements.forms import elasticity, mean_weights, nodal_share_form
from rollbench.hifi.elements.rigid import rigid_modes
from rollbench.hifi.linear_algebra import compliance
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.fem import cells_of, faces_of, freedoms_on, mesh_of, nodes_on, points_of
from rollbench.meshes.tet_patch import SUB_TRIANGLES, split_second_order


@dataclass(frozen=True)
class Socket:
    """One socket of a coarse body: the box around a contact that a fine patch fills."""

    #: Nodes of the socket, in the order of the patch of its flank.
    nodes: Index
    #: Rotation of its local frame ``(3, 3)``.
    rotation: Array
    #: Flank 0 to 3.
    side: int


#: Sizes of the elliptic pressures that `patch_modes` has to carry, over the contact zone, and their places along each of
#: its axes, over the free width around them.
SIZES, SHIFTS = (0.35, 0.5, 0.65, 0.8, 0.95), (-1.0, -0.5, 0.0, 0.5, 1.0)

#: Weight of all other forces against them; strength over the largest that is round-off.
REST, ROUND_OFF = 1e-3, 1e-13

#: The same for resultants: forces through the ball's centre have no moment about it.
NO_RESULTANT = 1e-9


def patch_modes(patch: CondensedPatch, count: int) -> tuple[Array, Array]:
    """Reduce the transfer H of contact loads to a socket to few modes: V Q approximates H.

    First come, for every independent resultant of contact loads, the nodal forces on the socket that contact pressures
    cause per unit of it on average: Q^T V^T f is in equilibrium with f for all forces f. Resultants are those of the
    forces, by the rigid motions' means over the pressure functions; H of a carrier patch has them only to some 1e-4
    (`hifi.bodies.patch.condense_patch`). Then come the strongest of the other traces, without resultants.

    Pressures are elliptic, of several sizes and places in the contact zone (`contact_pressures`), so that the modes do
    not depend on the grid and few are needed; then, weighted by `REST`, single pressure functions. Last come errors of H
    in the resultants, so that V Q is exact with all modes.

    Parameters
    ----------
    patch : CondensedPatch
        The condensed patch, with c contact nodes.
    count : int
        Number of modes; fewer where the remainder is below `ROUND_OFF`.

    Returns
    -------
    V : (c, k) Array
        Orthonormal modes.
    Q : (k, 3 nodes) Array
        Their rows on the socket's degrees of freedom.
    """
    rigid, moved = rigid_motions(patch)
    W, strength, _ = np.linalg.svd(moved, full_matrices=False)
    resultants = (W * strength)[:, strength > NO_RESULTANT * strength[0]]
    pressures = contact_pressures(patch)
    mean = patch.H.T @ pressures - rigid @ ((patch.H @ rigid - moved).T @ pressures)
    mean = mean @ np.linalg.pinv(resultants.T @ pressures)
    remainder = patch.H - resultants @ mean.T
    traces = remainder.T @ np.hstack([pressures, REST * np.eye(len(remainder))])
    wrong = rigid.T @ traces
    least = ROUND_OFF * float(np.linalg.norm(patch.H.T @ pressures))
    U = np.hstack([_strongest(traces - rigid @ wrong, least), rigid @ _strongest(wrong, least)])
    U = U[:, : max(count - mean.shape[1], 0)]
    V, T = np.linalg.qr(np.hstack([resultants, remainder @ U]))
    return V, T @ np.vstack([mean.T, U.T])


def _strongest(traces: Array, least: float) -> Array:
    """Orthonormal directions of traces ``(n, s)``, strongest first, down to the strength ``least``."""
    U, strength, _ = np.linalg.svd(traces, full_matrices=False)
    return np.asarray(U[:, strength > least])


def rigid_motions(patch: CondensedPatch) -> tuple[Array, Array]:
    """Rigid motions of a patch, at its socket and at its contact.

    Parameters
    ----------
    patch : CondensedPatch
        The condensed patch.

    Returns
    -------
    rigid : (3 nodes, 6) Array
        Orthonormal rigid motions of the socket's nodes.
    moved : (c, 6) Array
        Mean displacement along the normals over each pressure function, by each of these motions.
    """
    centre = patch.socket.mean(axis=0)
    rigid, T = np.linalg.qr(rigid_modes(patch.socket, centre))
    along = np.einsum("cx,cxk->ck", patch.normals, rigid_modes(patch.points, centre).reshape(-1, 3, 6))
    return rigid, np.linalg.solve(T.T, (mean_weights(patch.weights) @ along).T).T


def contact_pressures(patch: CondensedPatch) -> Array:
    """Hertz pressures of unit force on the pressure functions of a patch.

    Ellipses similar to its contact zone, of `SIZES` and `SHIFTS`, sampled at the nodes.

    Parameters
    ----------
    patch : CondensedPatch
        The condensed patch.

    Returns
    -------
    (c, s) Array
        Forces, one pressure a column.
    """
    middle = patch.points - patch.points.mean(axis=0)
    x = middle @ np.linalg.svd(middle, full_matrices=False)[2][:2].T
    x = (x - 0.5 * (x.max(axis=0) + x.min(axis=0))) / (0.5 * np.ptp(x, axis=0))
    out = []
    for size, *place in product(SIZES, SHIFTS, SHIFTS):
        at = (1.0 - size) * np.array(place)
        force = patch.areas * np.sqrt(np.maximum(1.0 - (((x - at) / size) ** 2).sum(axis=1), 0.0))
        if force.any():
            out.append(force / force.sum())
    return np.array(out).T


def freedoms(nodes: Index) -> Index:
    """Degrees of freedom 3 i + k of nodes.

    Parameters
    ----------
    nodes : (n,) Index
        Nodes i.

    Returns
    -------
    (3 n,) Index
        Degrees of freedom.

    Examples
    --------
    >>> freedoms(np.array([0, 2])).tolist()
    [0, 1, 2, 6, 7, 8]
    """
    return np.asarray((3 * nodes[:, None] + np.arange(3)).ravel(), dtype=np.int64)


def of_order(mesh: Mesh, kind: str) -> Mesh:
    """Mesh of 10-node tetrahedra, or of eight first-order ones in each; boundaries are kept.

    First-order ones have the same nodes and half the size; patches are then tied linearly
    (`hifi.bodies.patch.tie_matrix`).

    Parameters
    ----------
    mesh : Mesh
        10-node tetrahedra.
    kind : str
        "P2" or "P1".

    Returns
    -------
    Mesh
        The mesh.

    Raises
    ------
    ValueError
        Another kind.
    """
    if kind not in ("P1", "P2"):
        raise ValueError(f"coarse body of {kind!r} elements: P1 or P2")
    if kind == "P2":
        return mesh
    points = points_of(mesh)
    named = {name: faces_of(mesh, name)[:, np.array(SUB_TRIANGLES)].reshape(-1, 3) for name in mesh.boundaries or {}}
    return mesh_of(points, split_second_order(points, cells_of(mesh)), "P1", named)[0]


def assemble(
    mesh: Mesh, sockets: Sequence[Socket], patches: dict[int, CondensedPatch], young: float, poisson: float
) -> sp.csc_array:
    """Stiffness of a coarse body with a condensed patch in every socket.

    Parameters
    ----------
    mesh : Mesh
        Coarse body of n nodes.
    sockets : Sequence[Socket]
        Its sockets.
    patches : dict[int, CondensedPatch]
        Condensed patch of each flank.
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    (3 n, 3 n) sparse array
        Stiffness.
    """
    K = forms.assemble(elasticity(young, poisson), mesh)
    rows, columns, values = [], [], []
    for socket in sockets:
        S = patches[socket.side].S
        k = len(socket.nodes)
        R = socket.rotation
        turned = np.einsum("ab,ibjc,dc->iajd", R, S.reshape(k, 3, k, 3), R).reshape(3 * k, 3 * k)
        dof = freedoms(socket.nodes)
        rows.append(np.repeat(dof, 3 * k))
        columns.append(np.tile(dof, 3 * k))
        values.append(turned.ravel())
    if values:
        added = sp.coo_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=K.shape)
        K = (K + added.tocsc()).tocsc()
    return K


def mode_rows(sockets: Sequence[Socket], rows: dict[int, Array], size: int) -> sp.csr_array:
    """Rows Q of all sockets on the body's degrees of freedom; local motion is R^T times the global one.

    Parameters
    ----------
    sockets : Sequence[Socket]
        Sockets of the body.
    rows : dict[int, Array]
        Rows Q ``(k, 3 nodes)`` of each flank.
    size : int
        Number of the body's degrees of freedom.

    Returns
    -------
    (r, size) sparse array
        Rows, socket after socket.
    """
    data, row, column = [], [], []
    start = 0
    for socket in sockets:
        Q = rows[socket.side]
        k = len(socket.nodes)
        turned = np.einsum("mib,ab->mia", Q.reshape(len(Q), k, 3), socket.rotation).reshape(len(Q), 3 * k)
        data.append(turned.ravel())
        row.append(np.repeat(start + np.arange(len(Q)), 3 * k))
        column.append(np.tile(freedoms(socket.nodes), len(Q)))
        start += len(Q)
    matrix = sp.coo_array((np.concatenate(data), (np.concatenate(row), np.concatenate(column))), shape=(start, size))
    return matrix.tocsr()


def isostatic(points: Array, avoid: Index) -> Index:
    """Six degrees of freedom that constrain a free body without straining it: pivoted rows of its rigid motions.

    Parameters
    ----------
    points : (n, 3) Array
        Nodes [m].
    avoid : Index
        Nodes that are not constrained.

    Returns
    -------
    (6,) Index
        Degrees of freedom.
    """
    allowed = np.setdiff1d(np.arange(len(points)), avoid)
    pick = allowed[np.linspace(0, len(allowed) - 1, min(200, len(allowed))).astype(int)]
    modes = rigid_modes(points[pick], points.mean(axis=0))
    size = float(np.abs(points - points.mean(axis=0)).max())
    modes = modes / np.array([1, 1, 1, size, size, size])
    _, _, order = qr(modes.T, pivoting=True)
    return np.asarray(freedoms(pick)[order[:6]])


def rigid_loads(mesh: Mesh) -> Array:
    """Nodal forces of body forces [N/m3] that are rigid motions.

    Parameters
    ----------
    mesh : Mesh
        Body of n nodes.

    Returns
    -------
    (6, 3 n) Array
        In the order of `rigid_modes`.
    """
    V = forms.cell_basis(mesh)
    volume = nodal_share_form().assemble(V)
    loads = rigid_modes(np.stack([nodal_share_form(k).assemble(V) for k in range(3)], axis=1)).reshape(-1, 3, 6)
    loads[..., :3] *= volume[:, None, None]
    return np.asarray(loads.reshape(-1, 6).T)


def free_transform(mesh: Mesh, held: Index) -> sp.csc_array:
    """Map the free degrees of freedom of a body to all of them, with some fixed.

    Parameters
    ----------
    mesh : Mesh
        The body.
    held : Index
        Fixed degrees of freedom.

    Returns
    -------
    sparse array
        C, one column for each free degree of freedom.
    """
    size = mesh.doflocs.size
    return sp.eye_array(size, format="csc")[:, np.setdiff1d(np.arange(size), held)]


def end_transform(mesh: Mesh, high: float) -> sp.csc_array:
    """Map the free degrees of freedom of a body that is fixed at its "low end" and rigid at its "high end" to all.

    C^T K C is the Galerkin stiffness; scikit-fem's `mpc` takes only the equations of the free degrees of freedom.

    Parameters
    ----------
    mesh : Mesh
        The body.
    high : float
        Height z of the reference point of the rigid section [m].

    Returns
    -------
    sparse array
        C; the six degrees of freedom of the section come last.
    """
    upper = nodes_on(mesh, "high end")
    slaves = freedoms(upper)
    free = free_transform(mesh, np.concatenate([freedoms_on(mesh, "low end"), slaves]))
    section = sp.csc_array(rigid_modes(points_of(mesh)[upper], np.array([0.0, 0.0, high])))
    return sp.hstack([free, sp.eye_array(free.shape[0], format="csc")[:, slaves] @ section]).tocsc()


#: Meshes of the coarse piece over which its response is averaged: sizes differ by a hundredth, so that the scatter of
#: unstructured meshes (some ten thousandths of an approach) does not pass into all contacts of a flank.
REALISATIONS = 3

STEP = 0.01


@dataclass(frozen=True)
class Piece:
    """A short piece of a body around one contact, the submodel that gives the contact's local compliance."""

    #: The mesh.
    mesh: Mesh
    #: Nodes of its socket, in the order of the side's socket mesh.
    socket: Index
    #: Rotation of the patch's frame ``(3, 3)``.
    rotation: Array
    #: Fixed boundaries; none: inertia relief, loads are balanced by a rigid field of body forces.
    held: tuple[str, ...]


def fine_compliance(piece: Piece, patch: PatchMesh, normals: Array, young: float, poisson: float) -> Array:
    """Compliance C_fine between the pressure functions of a contact, in a fine piece of its body.

    Parameters
    ----------
    piece : Piece
        Piece of the body.
    patch : PatchMesh
        Patch in its socket.
    normals : (c, 3) Array
        Directions of the contact loads.
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    (c, c) Array
        Mean displacement along the normals per unit force [m/N].

    Raises
    ------
    FactorError
        The stiffness of the piece cannot be factored.
    """
    return piece_compliance(piece, patch, pressure_rows(patch, normals), young, poisson)


def piece_compliance(piece: Piece, patch: PatchMesh, rows: sp.csr_array, young: float, poisson: float) -> Array:
    """Response of a piece with a patch in its socket to loads on the patch.

    The patch is not condensed: it is solved together with the piece.

    Parameters
    ----------
    piece : Piece
        Piece of the body.
    patch : PatchMesh
        Patch of n nodes.
    rows : (m, 3 n) sparse array
        Loads on the patch.
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    (m, m) Array
        Displacements that do work on the loads [m/N].

    Raises
    ------
    FactorError
        The stiffness of the piece cannot be factored.
    """
    form = elasticity(young, poisson)
    K_patch, K_body = forms.assemble(form, patch.mesh), forms.assemble(form, piece.mesh)
    size = K_patch.shape[0]
    outer = freedoms(patch.interface)
    inner = np.setdiff1d(np.arange(size), outer)
    free, loads = _supports(piece)
    place = np.full(K_body.shape[0], -1, dtype=np.int64)
    place[free] = inner.size + np.arange(free.size)
    # the interface follows the socket's nodes: patch's frame = R^T times the body's
    turn = sp.block_diag([sp.csr_array(piece.rotation.T)] * piece.socket.size)
    tie = (sp.kron(patch.tie, sp.eye_array(3)) @ turn).tocoo()
    lines = np.concatenate([inner, outer[tie.row]])
    columns = np.concatenate([np.arange(inner.size), place[freedoms(piece.socket)][tie.col]])
    T = sp.csr_array((np.concatenate([np.ones(inner.size), tie.data]), (lines, columns)), (size, inner.size + free.size))
    body = K_body[free][:, free].tocoo()
    shape = (T.shape[1], T.shape[1])
    K = (T.T @ K_patch @ T + sp.coo_array((body.data, (body.row + inner.size, body.col + inner.size)), shape)).tocsc()
    relief = sp.hstack([sp.csr_array((loads.shape[0], inner.size)), loads[:, free]])
    F = compliance(K, sp.vstack([rows @ T, relief]).tocsr())
    return _relieved(F, rows.shape[0], rows @ _turned_rigid(patch, piece), loads, piece)


def coarse_compliance(piece: Piece, patch: CondensedPatch, rows: Array, young: float, poisson: float) -> Array:
    """Compliance G_coarse of the modes of a contact, in a piece that is meshed as the coarse body.

    Parameters
    ----------
    piece : Piece
        Piece of the body.
    patch : CondensedPatch
        Condensed patch in its socket.
    rows : (k, 3 nodes) Array
        Rows Q of the modes.
    young : float
        Young's modulus [Pa].
    poisson : float
        Poisson's ratio.

    Returns
    -------
    (k, k) Array
        [m/N].

    Raises
    ------
    FactorError
        The stiffness of the piece cannot be factored.
    """
    socket = Socket(piece.socket, piece.rotation, 0)
    K = assemble(piece.mesh, [socket], {0: patch}, young, poisson)
    free, loads = _supports(piece)
    Q = mode_rows([socket], {0: rows}, K.shape[0])
    F = compliance(K[free][:, free].tocsc(), sp.vstack([Q[:, free], loads[:, free]]).tocsr())
    return _relieved(F, len(rows), Q @ rigid_modes(points_of(piece.mesh)), loads, piece)


def local_compliance(fine: Array, V: Array, coarse: Callable[[float], Array]) -> Array:
    """Local compliance A_own of a contact, beyond the modes that the coarse body keeps.

    Parameters
    ----------
    fine : (c, c) Array
        C_fine [m/N].
    V : (c, k) Array
        Modes.
    coarse : Callable[[float], Array]
        G_coarse ``(k, k)`` [m/N] of meshes whose sizes are scaled by a factor.

    Returns
    -------
    (c, c) Array
        C_fine - V G_coarse V^T [m/N], over the mean of `REALISATIONS` coarse meshes.
    """
    G = np.mean([coarse(1.0 + STEP * n) for n in range(REALISATIONS)], axis=0)
    A = fine - V @ G @ V.T  # A_own = C_fine - V G_coarse V^T
    return np.asarray(0.5 * (A + A.T))


def _supports(piece: Piece) -> tuple[Index, sp.csr_array]:
    """Free degrees of freedom of a piece, and the body forces that balance its loads.

    Rigid fields ``(6, 3 n)``; none where the piece is fixed.
    """
    size = piece.mesh.doflocs.size
    if piece.held:
        return np.setdiff1d(np.arange(size), freedoms_on(piece.mesh, *piece.held)), sp.csr_array((0, size))
    held = isostatic(points_of(piece.mesh), piece.socket)
    return np.setdiff1d(np.arange(size), held), sp.csr_array(rigid_loads(piece.mesh))


def _turned_rigid(patch: PatchMesh, piece: Piece) -> Array:
    """Rigid motions of the body's frame at the patch's freedoms, in the patch's frame, ``(3 n, 6)``."""
    rigid = rigid_modes(points_of(patch.mesh) @ piece.rotation.T).reshape(-1, 3, 6)
    return np.asarray(np.einsum("ba,nbk->nak", piece.rotation, rigid).reshape(-1, 6))


def _relieved(F: Array, count: int, rigid: Array, loads: sp.csr_array, piece: Piece) -> Array:
    """Balance the responses F of ``count`` loads by rigid fields of body forces.

    rigid ``(count, 6)``: work of the loads on rigid motions.
    """
    if loads.shape[0] == 0:
        return F
    mass = loads @ rigid_modes(points_of(piece.mesh))
    S = np.hstack([np.eye(count), -np.linalg.solve(mass, rigid.T).T])
    return np.asarray(S @ F @ S.T)
