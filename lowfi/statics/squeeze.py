"""What section forces of the shaft do to its contacts beyond a beam's rigid sections, and the contacts to the shaft.

A stretch of shaft between its cut ends is a body on which contact forces f and the wrench F of all that lies above it act;
the rest is equilibrium. Held at its low end it has the complementary energy

    f . G f / 2 + f . D^T F + F . H F / 2

beyond that of the beam: G is what `lowfi.compliance.bodies` gives, D and H are `lowfi.compliance.bodies`, Saint-Venant's
contraction under tension and bending and the warping under shear among them. The beam has the wrench F = S q from the
motions q of its nodes. As F is the derivative of the energy by the jump d = D f + H F that the stretch adds at its cut, the
beam with these jumps answers loads p by q = K^-1 (p + S^T d), F = S q - k d (k: stiffness of the cut element), and with
p = L^T f

    F = (I + B H)^-1 (A - B D) f,   A = S K^-1 L^T,   B = k - S K^-1 S^T,

B being the stiffness of the supported shaft against a jump: none where it is held once. Contacts move by L q + G f + D^T F.
The energy of a body does not know at which end it is held, so that neither does the answer, however many stretches there
are. Each contact's jump lies at its station: sections between it and the cut move by it too, and a load on one of them is
felt by the contacts below. Supports between the contacts of one set are taken as if they were below them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.compliance.bodies import end_response
from rollbench.lowfi.compliance.parts import Backend
from rollbench.lowfi.statics.kernel.beam import element_constants, force_of
from rollbench.lowfi.statics.problem import Problem
from rollbench.lowfi.statics.shaft import Shaft, rows_of
from rollbench.lowfi.statics.shape import rigid_transport
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import Scene
from rollbench.meshes.section import MERGE, contact_stations

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Stretch:
    """Shaft under one set. flanks ``(m,)``: places of its contacts' motions among those of all; stations ``(m,)`` [m]; feel
    ``(m, 6)``, at_cut ``(6, 6)``: D^T and H by the wrench at the cut, the node above its contacts."""

    flanks: Ints
    stations: Array
    feel: Array
    at_cut: Array
    cut: int


@dataclass(frozen=True)
class Inside:
    """Motions of a shaft's n nodes by jumps at the contacts of its stretches, which lie on c flanks: of the nodes from
    these to the cuts, and beyond a cut that carries no wrench."""

    problem: Problem
    stretches: Sequence[Stretch]
    flanks: int

    def _moves(self, x: Stretch) -> tuple[Array, Ints]:
        """Motions ``(m, 6, 6)`` of the nodes below the end of a stretch by a jump at its cut, and the first node above each
        of its flanks."""
        nodes = self.problem.nodes
        z = nodes[: x.cut + 1] if loaded_beyond(self.problem, x.cut) else nodes
        return rigid_transport(z - nodes[x.cut]), np.searchsorted(z, x.stations - MERGE)

    def by_flanks(self, pushes: Array) -> Array:
        """Motions ``(6 n,)`` of the nodes by the flanks' forces ``(2 c,)`` [N]."""
        out = np.zeros((self.problem.nodes.size, 6))
        for x in self.stretches:
            moves, first = self._moves(x)
            jumps = np.zeros((len(moves) + 1, 6))
            np.add.at(jumps, first, x.feel * pushes[x.flanks, None])
            out[: len(moves)] += np.einsum("nij,nj->ni", moves, jumps.cumsum(axis=0)[:-1])
        return out.ravel()

    def by_loads(self, loads: Array) -> Array:
        """Motions ``(2 c, k)`` of the flanks by loads ``(6 n, k)`` on the nodes: reciprocal to `by_flanks`."""
        out, nodal = np.zeros((2 * self.flanks, loads.shape[1])), loads.reshape(-1, 6, loads.shape[1])
        for x in self.stretches:
            moves, first = self._moves(x)
            wrenches = np.zeros((len(moves) + 1, *nodal.shape[1:]))
            wrenches[:-1] = np.einsum("nij,nik->njk", moves, nodal[: len(moves)])
            out[x.flanks] += np.einsum("cj,cjk->ck", x.feel, wrenches[::-1].cumsum(axis=0)[::-1][first])
        return out


@dataclass(frozen=True)
class Squeeze:
    """Stretches on a shaft of n nodes, W = 6 motions of each cut that carries a wrench, c flanks.

    added ``(2 c, 2 c)`` [m/N]: to the compliance of the flanks and the stretches' own; moved ``(2 c,)`` [m]: by the scene's
    loads and prescribed displacements; wrenches ``(W, 6 n)``: S; feel ``(2 c, W)`` and nodes ``(6 n, W)``: motions of the
    flanks and of the nodes by S q; jumps ``(W, 2 c)`` and given ``(W,)``: d by the flanks' forces and by loads; inside:
    what the flanks' forces add to the nodes' motion that the beam's nodal loads do not bring about. Of these, moved and
    only depend on the loads (`under`): bent ``(W, W)`` makes jumps of wrenches.
    """

    added: Array
    moved: Array
    wrenches: Array
    feel: Array
    nodes: Array
    jumps: Array
    given: Array
    inside: Inside
    bent: Array

    def under(self, shaft: Shaft, thermal: Array | float = 0.0) -> Squeeze:
        """The same under the loads and prescribed displacements of a shaft; thermal ``(W,)`` [N, N m]: wrenches at the cuts
        that are among its loads and no strain of the stretches."""
        wrench = self.wrenches @ shaft.by_loads[1] - thermal
        moved = self.feel @ wrench + self.inside.by_loads(shaft.problem.load.reshape(-1, 1))[:, 0]
        return replace(self, moved=moved, given=self.bent @ wrench)

    def node_loads(self, pushes: Array) -> Array:
        """Nodal loads ``(6 n,)`` that stand for the jumps, by the flanks' forces ``(2 c,)`` [N]."""
        return np.asarray(self.wrenches.T @ (self.jumps @ pushes + self.given))

    def with_inside(self, motion: Array, pushes: Array, fixed: NDArray[np.bool_]) -> Array:
        """Motions ``(n, 6)`` of the nodes with what the flanks' forces add inside, where not held."""
        return np.where(fixed, motion, motion + (self.inside.by_flanks(pushes.ravel())).reshape(-1, 6))

    def by_loads(self, loads: Array, motions: Array) -> tuple[Array, Array]:
        """Motions of the flanks ``(2 c, k)``, and of the nodes ``(6 n, k)`` beside these, by nodal loads ``(6 n, k)`` under
        which the beam by itself moves by ``motions``."""
        wrench = self.wrenches @ motions
        return np.asarray(self.feel @ wrench + self.inside.by_loads(loads)), np.asarray(self.nodes @ wrench)


def stretch_of(
    problem: Problem, scene: Scene, layout: BallLayout, backend: Backend, used: Sequence[int], balls: slice
) -> Stretch | None:
    """Stretch under the balls ``balls`` of a problem, which are those of ``scene``; used: the sides that are built. None
    where the shaft is rigid there."""
    response = None if problem.basis is not None else end_response(scene, layout, backend)
    if response is None or not used:
        return None
    cut = int(problem.node[balls][:, list(used)].max()) + (problem.B.shape[3] == 12)
    N, first = problem.node.shape[0], np.arange(layout.z.size) + range(problem.node.shape[0])[balls].start
    places = np.array([2 * (k * N + first)[:, None] + np.arange(2) for k in range(len(used))], dtype=np.int64)
    up = rigid_transport(float(problem.nodes[cut]) - response.high)
    feel = response.contacts.reshape(2, -1, 6)[list(used)].reshape(-1, 6) @ up.T
    stations = np.repeat(contact_stations(scene, layout)[:, list(used)].T.ravel(), 2)
    return Stretch(places.ravel(), stations, feel, up @ response.end @ up.T, cut)


def loaded_beyond(problem: Problem, cut: int) -> bool:
    """Whether the beam carries anything beyond a node: support, load or contact."""
    beyond = slice(cut + 1, None)
    return bool(problem.fixed[beyond].any() or problem.load[beyond].any() or (problem.node > cut).any())


def cut_stiffness(problem: Problem, cut: int) -> tuple[Array, Array, float]:
    """k ``(6, 6)`` and S ``(6, 12)`` of the element above a node: the wrench on what is below, by a jump there and by the
    motions of both its nodes; its EA [N]."""
    section = problem.section if problem.sections is None else problem.sections[cut]
    length = float(problem.nodes[cut + 1] - problem.nodes[cut])
    constants = element_constants(length, np.array([section.EA, section.EI, section.GJ, section.kGA]))
    k = np.zeros((6, 6))
    for unit, row in zip(np.eye(6), k, strict=True):
        force_of(unit, constants, row)
    T = rigid_transport(length)
    return T.T @ k @ T, T.T @ k @ np.hstack([-T, np.eye(6)]), section.EA


def squeezed(shaft: Shaft, used: Sequence[int], stretches: Sequence[Stretch], strain: float = 0.0) -> Squeeze | None:
    """What stretches add to a shaft and its flanks of the sides ``used``; None without stretches.

    strain: thermal, of the free shaft, which is among the problem's loads.
    """
    if not stretches:
        return None
    problem = shaft.problem
    dof, rows = rows_of(problem, list(used))
    count, inside = 2 * len(rows), Inside(problem, stretches, len(rows))
    loaded = [x for x in stretches if loaded_beyond(problem, x.cut)]
    W = 6 * len(loaded)
    S, k, warm = np.zeros((W, 6 * problem.nodes.size)), np.zeros((W, W)), np.zeros(W)
    D, H = np.zeros((W, count)), np.zeros((W, W))
    for i, x in enumerate(loaded):
        block = slice(6 * i, 6 * i + 6)
        stiff, S[block, 6 * x.cut : 6 * x.cut + 12], EA = cut_stiffness(problem, x.cut)
        for j, other in enumerate(loaded):  # jumps of one element share its stiffness
            if other.cut == x.cut:
                k[block, 6 * j : 6 * j + 6] = stiff
        D[block, x.flanks], H[block, block], warm[6 * i + 2] = x.feel.T, x.at_cut, EA * strain
    X = shaft.solve(S.T)
    A = np.einsum("cak,ckw->wca", rows, X[dof]).reshape(W, count)
    B = k - S @ X
    M = np.linalg.inv(np.eye(W) + 0.5 * (B + B.T) @ H)
    feel, by_forces = (D.T + A.T @ H) @ M, A - B @ D
    added = A.T @ D + feel @ by_forces
    bent, none = H @ M, np.zeros(0)
    squeeze = Squeeze(0.5 * (added + added.T), none, S, feel, X @ H @ M, D + bent @ by_forces, none, inside, bent)
    return squeeze.under(shaft, warm)
