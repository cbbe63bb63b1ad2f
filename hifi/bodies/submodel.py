"""A contact's own compliance from a submodel: a short piece of its body around it, meshed finely.

A coarse body tied to a condensed patch carries loads from contact to contact well, but is too stiff where a contact
answers itself: the trace of its socket and the cells beside it hold back a share of the approach that no finer patch gives
back. That share is local, the same for all contacts of a side, and decays within a socket's size. So a contact's own
compliance is taken from a piece of the body cut off around one contact and meshed as finely as needed, and what the coarse
body has there is taken out:

    A_own = C_fine - V G_coarse V^T,

C_fine (c, c): pressure hats of the contact against one another in the fine piece; V G_coarse V^T: the same through the
modes V that the coarse body keeps, in the same piece cut and meshed as the coarse body is. Both pieces are held alike, so
that what the holding does cancels. Modes that the coarse body does not keep are in A_own too, as far as a contact feels
itself. (Local defect correction, Hackbusch 1984; submodelling in the field.) With A_own in place of A,
C = blkdiag(A_own) + V G V^T.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from skfem import Mesh

from rollbench.hifi.bodies.coarse import Socket, assemble, freedoms, isostatic, mode_rows, rigid_loads
from rollbench.hifi.bodies.patch import CondensedPatch, PatchMesh, hat_rows
from rollbench.hifi.elements import assembly
from rollbench.hifi.elements.forms import elasticity
from rollbench.hifi.elements.rigid import rigid_modes
from rollbench.hifi.linear_algebra.solvers import compliance
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.fem import freedoms_on, points_of

#: Meshes of the coarse piece over which its response is averaged: sizes differ by a hundredth, so that the scatter of
#: unstructured meshes (some ten thousandths of an approach) does not pass into all contacts of a side.
REALISATIONS = 3
STEP = 0.01


@dataclass(frozen=True)
class Piece:
    """A body around one contact: mesh, nodes of its socket in the order of the side's socket mesh, rotation (3, 3) of the
    patch's frame, boundaries that are held (none: inertia relief, loads balanced by a rigid field of body forces)."""

    mesh: Mesh
    socket: Index
    rotation: Array
    held: tuple[str, ...]


def fine_compliance(piece: Piece, patch: PatchMesh, normals: Array, young: float, poisson: float) -> Array:
    """C_fine ``(c, c)`` [m/N]: means over hats of the motion along ``normals`` ``(c, 3)`` under unit forces spread by hats.

    Raises hifi.linear_algebra.solvers.FactorError for a piece that does not hold together.
    """
    return piece_compliance(piece, patch, hat_rows(patch, normals), young, poisson)


def piece_compliance(piece: Piece, patch: PatchMesh, rows: sp.csr_array, young: float, poisson: float) -> Array:
    """Answers ``(m, m)`` [m/N] of a piece with a patch in its socket to loads ``rows`` ``(m, 3 n)`` on the patch.

    The patch is not condensed: its inner freedoms and the piece's are solved as one. Raises
    hifi.linear_algebra.solvers.FactorError for a piece that does not hold together.
    """
    form = elasticity(young, poisson)
    K_patch, K_body = assembly.assemble(form, patch.mesh), assembly.assemble(form, piece.mesh)
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
    """G_coarse ``(k, k)``: response of the modes with ``rows`` Q ``(k, 3 nodes)`` in a piece with the condensed patch."""
    socket = Socket(piece.socket, piece.rotation, 0)
    K = assemble(piece.mesh, [socket], {0: patch}, young, poisson)
    free, loads = _supports(piece)
    Q = mode_rows([socket], {0: rows}, K.shape[0])
    F = compliance(K[free][:, free].tocsc(), sp.vstack([Q[:, free], loads[:, free]]).tocsr())
    return _relieved(F, len(rows), Q @ rigid_modes(points_of(piece.mesh)), loads, piece)


def own_compliance(fine: Array, V: Array, coarse: Callable[[float], Array]) -> Array:
    """A_own ``(c, c)`` from C_fine, the modes V ``(c, k)`` and G_coarse of meshes whose sizes are scaled by a factor."""
    G = np.mean([coarse(1.0 + STEP * n) for n in range(REALISATIONS)], axis=0)
    A = fine - V @ G @ V.T
    return np.asarray(0.5 * (A + A.T))


def _supports(piece: Piece) -> tuple[Index, sp.csr_array]:
    """Free freedoms of a piece, and rigid fields of body forces ``(6, 3 n)`` that balance loads (none where it is held)."""
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
    """F of ``count`` loads, balanced by the rigid fields that follow them; rigid ``(count, 6)``: their work on motions."""
    if loads.shape[0] == 0:
        return F
    mass = loads @ rigid_modes(points_of(piece.mesh))
    S = np.hstack([np.eye(count), -np.linalg.solve(mass, rigid.T).T])
    return np.asarray(S @ F @ S.T)
