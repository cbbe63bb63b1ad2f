"""Screw as a beam with supports and loads, condensed to the motions of the flanks, and coupled to their deformation.

The condensation is exact for the beam. `Squeeze` is what the shaft's section forces do to the contacts beyond a beam's
rigid sections, and the contacts to the shaft.

A stretch of shaft between its cut ends is a body on which contact loads f and the wrench F of all that lies above it act;
the rest is equilibrium. Fixed at its low end it has the complementary energy

    f . G f / 2 + f . D^T F + F . H F / 2                                                                              (1)

beyond that of the beam: G is what `lowfi.compliance.bodies` gives, D and H are `lowfi.compliance.between`, Saint-Venant's
contraction under tension and bending and the warping under shear among them. The beam has the wrench F = S q from the
motions q of its nodes. As F is the derivative of the energy by the jump d = D f + H F that the stretch adds at its cut, the
beam with these jumps responds to loads p by q = K^-1 (p + S^T d), F = S q - k d (k: stiffness of the cut element), and with
p = L^T f

    F = (I + B H)^-1 (A - B D) f,   A = S K^-1 L^T,   B = k - S K^-1 S^T,                                              (2)

B being the stiffness of the supported shaft against a jump: zero where it is statically determinate. Contacts move by
L q + G f + D^T F. The energy of a body does not depend on the end at which it is fixed, so that neither does the result,
however many stretches there are. Each contact's jump lies at its station: sections between it and the cut move by it too,
and a load on one of them is felt by the contacts below. Supports between the contacts of one set are taken as if they were
below them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.compliance.bodies import end_response, section_response
from rollbench.lowfi.compliance.parts import Backend
from rollbench.lowfi.statics.kernel.beam import add_element, element_constants, force_of
from rollbench.lowfi.statics.kernel.matrices import factor_band, inverse_blocks, substitute_blocks
from rollbench.lowfi.statics.problem import Problem
from rollbench.lowfi.statics.shape import pivots, principal, rigid_transport
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import Scene
from rollbench.meshes.section import MERGE, contact_stations

#: Right-hand sides solved at a time.
CHUNK = 512


@dataclass
class Shaft:
    """Beam of a problem with its supports, and pins where these leave k rigid motions."""

    #: The problem.
    problem: Problem
    #: Those rigid motions of node ``pin`` by amplitudes in metres, rotations times the pitch radius ``(6, k)``.
    motions: Array
    #: Work of the loads on them ``(k,)`` [N].
    work: Array
    #: Number of the node nearest to the nut.
    pin: int
    #: Freedoms that are neither fixed nor pinned ``(6 n,)``.
    free: NDArray[np.bool_]
    #: Factor of the stiffness.
    factor: tuple[Array, Array] = field(repr=False)
    #: Stiffness in the lower band ``(12, 6 n)``.
    band: Array = field(repr=False)

    def under(self, problem: Problem) -> Shaft:
        """Return a copy of the shaft with the loads and prescribed displacements of another problem."""
        return replace(self, problem=problem, work=_work(problem, self.motions, self.pin))

    def solve(self, loads: Array) -> Array:
        """Return the motions ``(6 n, c)`` of all nodes by nodal loads ``(6 n, c)``, fixed freedoms at zero."""
        out = np.where(self.free[:, None], loads, 0.0)
        if self.free.any():
            substitute_blocks(self.factor, out)
        return out

    @cached_property
    def by_loads(self) -> tuple[Array, Array]:
        """Result of `free_state`, computed once."""
        return free_state(self)

    def times(self, q: Array) -> Array:
        """Return the stiffness times motions ``(6 n,)``: the nodal forces that they need."""
        out = self.band[0] * q
        for k in range(1, self.band.shape[0]):
            out[k:] += self.band[k, : q.size - k] * q[: q.size - k]
            out[: q.size - k] += self.band[k, : q.size - k] * q[k:]
        return np.asarray(out)


def unheld(problem: Problem) -> Array:
    """Return the rigid motions ``(6, k)`` of the node nearest the nut that no support prevents."""
    scale, z = in_metres(problem), problem.nodes
    origin = z[pin_node(problem)]
    rows = rigid_transport(z - origin)[problem.fixed] * scale
    if rows.size == 0:
        return np.diag(scale)
    sv, vt = principal(rows)
    rank = int((sv > 1e-9 * sv[0]).sum())
    return np.asarray(scale[:, None] * vt[rank:].T)


def in_metres(problem: Problem) -> Array:
    """Return the motions ``(6,)`` [m, rad] of a node by one metre of each freedom: rotations over the pitch radius."""
    return np.repeat([1.0, 1.0 / problem.scene.track.pitch_radius], 3)


def pin_node(problem: Problem) -> int:
    """Return the number of the node nearest to the nut's centre."""
    return int(np.abs(problem.nodes - problem.scene.nut.position).argmin())


def shaft_of(problem: Problem) -> Shaft:
    """Return the factored stiffness of the beam; a rigid screw has only its free motions."""
    if problem.basis is not None:
        motions = np.diag(in_metres(problem))[:, ~problem.fixed[0]]
        none, no = np.zeros(6, dtype=bool), np.zeros((0, 6, 6))
        return Shaft(problem, motions, _work(problem, motions, 0), 0, none, (no, no), np.zeros((1, 6)))
    n = problem.nodes.size
    band = np.zeros((6 * n, 12))
    lengths = np.diff(problem.nodes)
    sections = problem.sections or (problem.section,) * lengths.size
    constants = np.array([(s.EA, s.EI, s.GJ, s.kGA) for s in sections]).reshape(-1, 4).T
    add: Callable[..., None] = add_element  # as plain Python it takes all elements at once
    add(band, np.arange(lengths.size), lengths, constants)
    motions = unheld(problem)
    pin = pin_node(problem)
    held = problem.fixed.copy()
    if motions.shape[1]:
        held[pin, pivots(motions.T)] = True
    free = ~held.ravel()
    work = _work(problem, motions, pin)
    return Shaft(problem, motions, work, pin, free, inverse_blocks(_factor(band, free)), band.T.copy())


def _work(problem: Problem, motions: Array, pin: int) -> Array:
    """Return the work ``(k,)`` [N] of the loads on free rigid motions ``(6, k)``."""
    if problem.basis is not None:
        return np.asarray(problem.load[0] @ motions)
    at_pin = np.einsum("nij,ni->j", rigid_transport(problem.nodes - problem.nodes[pin]), problem.load)
    return np.asarray(motions.T @ at_pin)


def _factor(band: Array, free: NDArray[np.bool_]) -> Array:
    """Return factor of a lower band ``(6 n, 12)`` (`kernel.matrices`), with a unit diagonal at freedoms not free."""
    kept = band.copy()
    for k in range(1, band.shape[1]):
        kept[: len(free) - k, k] *= free[: len(free) - k] & free[k:]
    kept[~free, 0] = 1.0
    if not factor_band(kept):
        raise np.linalg.LinAlgError("the stiffness of a shaft with supports is not positive")
    return kept


def rows_of(problem: Problem, used: list[int]) -> tuple[NDArray[np.int64], Array]:
    """Return the freedoms ``(c, m)`` and rows ``(c, 2, m)`` of the flanks in use, flank after flank."""
    m = problem.B.shape[3]
    dof = [6 * problem.node[:, s, None] + np.arange(m) for s in used]
    return np.concatenate(dof), np.concatenate([problem.B[:, s] for s in used])


def flank_response(shaft: Shaft, used: list[int]) -> tuple[Array, Array]:
    """Return compliance of the flanks in use through the beam ``(2 c, 2 c)`` [m/N], and their free motions ``(2 c, k)``."""
    problem = shaft.problem
    dof, rows = rows_of(problem, used)
    count = rows.shape[0]
    if problem.basis is not None:
        return np.zeros((2 * count, 2 * count)), rows.reshape(2 * count, -1) @ shaft.motions
    size = 6 * problem.nodes.size
    G = np.zeros((2 * count, 2 * count))
    for start in range(0, 2 * count, CHUNK):
        pick = np.arange(start, min(start + CHUNK, 2 * count))
        loads = np.zeros((size, pick.size))
        loads[dof[pick // 2].T, np.arange(pick.size)] = rows[pick // 2, pick % 2].T
        q = shaft.solve(loads)
        G[:, pick] = np.einsum("cak,ckp->cap", rows, q[dof]).reshape(2 * count, pick.size)
    R = np.einsum("cak,ckp->cap", rows, rigid_nodes(shaft)[dof]).reshape(2 * count, -1)
    return 0.5 * (G + G.T), R


def flank_motions_by_loads(shaft: Shaft, used: list[int]) -> Array:
    """Return the motion ``(2 c,)`` [m] of the flanks in use by loads and prescribed displacements."""
    problem = shaft.problem
    dof, rows = rows_of(problem, used)
    if problem.basis is not None:
        return np.asarray(rows.reshape(2 * len(rows), -1) @ np.where(problem.fixed[0], problem.prescribed[0], 0.0))
    return np.asarray(np.einsum("cak,ck->ca", rows, np.add(*shaft.by_loads)[dof]).ravel())


def free_state(shaft: Shaft) -> tuple[Array, Array]:
    """Return the nodal motions ``(6 n,)`` by loads and prescribed displacements, as a rigid part and the rest.

    The rigid part is the motion that the prescribed displacements are, or zero where they strain the beam: round-off of a
    rigid motion that was solved for would strain it.
    """
    problem, held = shaft.problem, shaft.problem.fixed
    prescribed = np.where(held, shaft.problem.prescribed, 0.0)
    moved, loads = np.zeros_like(prescribed), problem.load.ravel()
    if prescribed.any():
        rigid = rigid_transport(problem.nodes - problem.nodes[shaft.pin])
        nearest = rigid @ np.linalg.lstsq(rigid[held], prescribed[held])[0]
        remainder = np.where(held, prescribed - nearest, 0.0)
        if np.abs(remainder).max() <= 1e-12 * np.abs(prescribed).max():
            moved, prescribed = nearest, remainder
        loads = loads - shaft.times(prescribed.ravel())
    return moved.ravel(), prescribed.ravel() + shaft.solve(loads[:, None])[:, 0]


def rigid_nodes(shaft: Shaft) -> Array:
    """Return the nodal motions ``(6 n, k)`` by the free rigid motions."""
    z = shaft.problem.nodes
    return np.asarray((rigid_transport(z - z[shaft.pin]) @ shaft.motions).reshape(6 * z.size, -1))


def node_motions(shaft: Shaft, loads: Array, amplitudes: Array) -> Array:
    """Return the nodal motions ``(n, 6)`` by additional nodal loads and free motions.

    Parameters
    ----------
    shaft
        The shaft.
    loads
        Nodal loads ``(6 n,)`` in addition to the scene's [N, N m].
    amplitudes
        Of the free motions ``(k,)`` [m].
    """
    problem = shaft.problem
    if problem.basis is not None:
        return np.asarray(np.where(problem.fixed, problem.prescribed, 0.0) + shaft.motions @ amplitudes)
    moved, bent = shaft.by_loads
    q = bent + shaft.solve(loads[:, None])[:, 0]
    return np.asarray((moved + q + rigid_nodes(shaft) @ amplitudes).reshape(-1, 6))


def node_forces(shaft: Shaft, loads: Array) -> Array:
    """Return the forces and moments ``(n, 6)`` [N, N m] on the beam's nodes for the motion of `node_motions`."""
    return shaft.times(shaft.by_loads[1] + shaft.solve(loads[:, None])[:, 0]).reshape(-1, 6)


def flank_loads(problem: Problem, forces: Array, used: list[int]) -> Array:
    """Return the nodal loads ``(6 n,)`` of the flanks' forces ``(c, 2)`` [N]."""
    dof, rows = rows_of(problem, used)
    out = np.zeros(6 * problem.nodes.size)
    np.add.at(out, dof, np.einsum("cak,ca->ck", rows, forces))
    return out


Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Stretch:
    """Shaft under one set."""

    #: Indices of its contacts' motions among those of all ``(m,)``.
    flanks: Ints
    #: Stations of the contacts ``(m,)`` [m].
    stations: Array
    #: D^T of (1) by the wrench at the cut ``(m, 6)``.
    feel: Array
    #: H of (1) by the wrench at the cut ``(6, 6)``.
    at_cut: Array
    #: Number of the node above its contacts.
    cut: int
    #: Motions of the flanks ``(m, 6)`` by loads on nodes below the cut, beyond those that the wrench at a contact makes.
    sections: dict[int, Array]


@dataclass(frozen=True)
class Inside:
    """Motions of a shaft's nodes within its stretches by jumps at the contacts.

    Of the nodes from the contacts to the cuts, and beyond a cut that carries no wrench.
    """

    #: The problem.
    problem: Problem
    #: The stretches.
    stretches: Sequence[Stretch]
    #: Number c of flanks.
    flanks: int

    def _moves(self, x: Stretch) -> tuple[Array, Ints]:
        """Return the motions ``(m, 6, 6)`` of the nodes below the end of a stretch by a jump at its cut, and first nodes.

        The first node above each of its flanks.
        """
        nodes = self.problem.nodes
        z = nodes[: x.cut + 1] if loaded_beyond(self.problem, x.cut) else nodes
        return rigid_transport(z - nodes[x.cut]), np.searchsorted(z, x.stations - MERGE)

    def by_flanks(self, pushes: Array) -> Array:
        """Return the motions ``(6 n,)`` of the nodes by the flanks' forces ``(2 c,)`` [N]."""
        out = np.zeros((self.problem.nodes.size, 6))
        for x in self.stretches:
            moves, first = self._moves(x)
            jumps = np.zeros((len(moves) + 1, 6))
            np.add.at(jumps, first, x.feel * pushes[x.flanks, None])
            out[: len(moves)] += np.einsum("nij,nj->ni", moves, jumps.cumsum(axis=0)[:-1])
            for node, beyond in x.sections.items():
                out[node] += pushes[x.flanks] @ beyond
        return out.ravel()

    def by_loads(self, loads: Array) -> Array:
        """Return the motions ``(2 c, k)`` of the flanks by loads ``(6 n, k)`` on the nodes: reciprocal to `by_flanks`."""
        out, nodal = np.zeros((2 * self.flanks, loads.shape[1])), loads.reshape(-1, 6, loads.shape[1])
        for x in self.stretches:
            moves, first = self._moves(x)
            wrenches = np.zeros((len(moves) + 1, *nodal.shape[1:]))
            wrenches[:-1] = np.einsum("nij,nik->njk", moves, nodal[: len(moves)])
            out[x.flanks] += np.einsum("cj,cjk->ck", x.feel, wrenches[::-1].cumsum(axis=0)[::-1][first])
            for node, beyond in x.sections.items():
                out[x.flanks] += beyond @ nodal[node]
        return out


@dataclass(frozen=True)
class Squeeze:
    """Coupling of contact loads and section forces of a shaft of n nodes with c flanks, by (2).

    W = 6 wrench components for each cut that carries a wrench. Only ``moved`` and ``given`` depend on the loads (`under`).
    """

    #: Added to the compliance of the flanks ``(2 c, 2 c)`` [m/N].
    added: Array
    #: Motion of the flanks by the scene's loads and prescribed displacements ``(2 c,)`` [m].
    moved: Array
    #: S ``(W, 6 n)``.
    wrenches: Array
    #: Motions of the flanks by S q ``(2 c, W)``.
    feel: Array
    #: Motions of the nodes by S q ``(6 n, W)``.
    nodes: Array
    #: d by the flanks' forces ``(W, 2 c)``.
    jumps: Array
    #: d by loads ``(W,)``.
    given: Array
    #: Motion of the nodes by the flanks' forces that the beam's nodal loads do not produce.
    inside: Inside
    #: Jumps by wrenches ``(W, W)``.
    bent: Array

    def under(self, shaft: Shaft, thermal: Array | float = 0.0) -> Squeeze:
        """Return the coupling under the loads and prescribed displacements of a shaft.

        thermal ``(W,)`` [N, N m]: wrenches at the cuts that are among its loads and do not strain the stretches.
        """
        wrench = self.wrenches @ shaft.by_loads[1] - thermal
        moved = self.feel @ wrench + self.inside.by_loads(shaft.problem.load.reshape(-1, 1))[:, 0]
        return replace(self, moved=moved, given=self.bent @ wrench)

    def node_loads(self, pushes: Array) -> Array:
        """Return the nodal loads ``(6 n,)`` equivalent to the jumps, by the flanks' forces ``(2 c,)`` [N]."""
        return np.asarray(self.wrenches.T @ (self.jumps @ pushes + self.given))

    def with_inside(self, motion: Array, pushes: Array, fixed: NDArray[np.bool_]) -> Array:
        """Return motions ``(n, 6)`` of the nodes with what the flanks' forces add within the stretches, where not fixed."""
        return np.where(fixed, motion, motion + (self.inside.by_flanks(pushes.ravel())).reshape(-1, 6))

    def by_loads(self, loads: Array, motions: Array) -> tuple[Array, Array]:
        """Return the added motions of the flanks ``(2 c, k)`` and of the nodes ``(6 n, k)`` by nodal loads ``(6 n, k)``.

        motions: of the beam under these loads without the coupling.
        """
        wrench = self.wrenches @ motions
        return np.asarray(self.feel @ wrench + self.inside.by_loads(loads)), np.asarray(self.nodes @ wrench)


def stretch_of(
    problem: Problem, scene: Scene, layout: BallLayout, backend: Backend, used: Sequence[int], balls: slice
) -> Stretch | None:
    """Return the stretch under some balls of a problem, those of ``scene``; None where the shaft is rigid there.

    used: the flanks that are built.
    """
    response = None if problem.basis is not None else end_response(scene, layout, backend)
    if response is None or not used:
        return None
    cut = int(problem.node[balls][:, list(used)].max()) + (problem.B.shape[3] == 12)
    N, first = problem.node.shape[0], np.arange(layout.z.size) + range(problem.node.shape[0])[balls].start
    places = np.array([2 * (k * N + first)[:, None] + np.arange(2) for k in range(len(used))], dtype=np.int64)
    up = rigid_transport(float(problem.nodes[cut]) - response.high)
    feel = response.contacts.reshape(2, -1, 6)[list(used)].reshape(-1, 6) @ up.T
    stations = np.repeat(contact_stations(scene, layout)[:, list(used)].T.ravel(), 2)
    sections = {}
    for node in np.flatnonzero(problem.load[:cut].any(axis=1)).tolist():
        at = float(problem.nodes[node])
        if response.low < at:
            by_section = section_response(scene, layout, backend, at).reshape(2, -1, 6)[list(used)].reshape(-1, 6)
            felt = feel @ rigid_transport(at - float(problem.nodes[cut])).T
            sections[node] = by_section - np.where(stations[:, None] - MERGE <= at, felt, 0.0)
    return Stretch(places.ravel(), stations, feel, up @ response.end @ up.T, cut, sections)


def loaded_beyond(problem: Problem, cut: int) -> bool:
    """Return whether the beam carries anything beyond a node: support, load or contact."""
    beyond = slice(cut + 1, None)
    return bool(problem.fixed[beyond].any() or problem.load[beyond].any() or (problem.node > cut).any())


def cut_stiffness(problem: Problem, cut: int) -> tuple[Array, Array, float]:
    """Return k ``(6, 6)`` and S ``(6, 12)`` of the element above a node, and its EA [N].

    The wrench on what is below, by a jump there and by the motions of both its nodes.
    """
    section = problem.section if problem.sections is None else problem.sections[cut]
    length = float(problem.nodes[cut + 1] - problem.nodes[cut])
    constants = element_constants(length, np.array([section.EA, section.EI, section.GJ, section.kGA]))
    k = np.zeros((6, 6))
    for unit, row in zip(np.eye(6), k, strict=True):
        force_of(unit, constants, row)
    T = rigid_transport(length)
    return T.T @ k @ T, T.T @ k @ np.hstack([-T, np.eye(6)]), section.EA


def squeezed(shaft: Shaft, used: Sequence[int], stretches: Sequence[Stretch], strain: float = 0.0) -> Squeeze | None:
    """Return the terms that stretches add to a shaft and its flanks in use; None without stretches."""
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
