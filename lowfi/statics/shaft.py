"""The screw as a beam with its supports and loads, condensed to the motions of the flanks: exact for the beam."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.statics.kernel.banded import factor_band, inverse_blocks, substitute_blocks
from rollbench.lowfi.statics.kernel.beam import add_element
from rollbench.lowfi.statics.problem import Problem
from rollbench.lowfi.statics.shape import pivots, principal, rigid_transport
from rollbench.meshes.arrays import Array

#: Right-hand sides solved at a time.
CHUNK = 512


@dataclass
class Shaft:
    """Beam of a problem with its supports, and pins where these leave rigid motions.

    motions ``(6, k)``: those rigid motions about node ``pin``; work ``(k,)``: of the loads on them; arms ``(k,)``: what
    makes a force of their unbalanced work (1 for a shift [m], one over the pitch radius for a rotation [rad]).
    """

    problem: Problem
    motions: Array
    work: Array
    arms: Array
    pin: int
    free: NDArray[np.bool_]
    factor: tuple[Array, Array] = field(repr=False)
    band: Array = field(repr=False)

    def under(self, problem: Problem) -> Shaft:
        """The same shaft under the loads and prescribed displacements of another problem."""
        return replace(self, problem=problem, work=_work(problem, self.motions, self.pin))

    def solve(self, loads: Array) -> Array:
        """Motions ``(6 n, c)`` of all nodes by nodal loads ``(6 n, c)``, held freedoms at zero."""
        out = np.where(self.free[:, None], loads, 0.0)
        if self.free.any():
            substitute_blocks(self.factor, out)
        return out

    @cached_property
    def by_loads(self) -> tuple[Array, Array]:
        """`free_state`, found once."""
        return free_state(self)

    def times(self, q: Array) -> Array:
        """Stiffness times motions ``(6 n,)``: the nodal forces they take."""
        out = self.band[0] * q
        for k in range(1, self.band.shape[0]):
            out[k:] += self.band[k, : q.size - k] * q[: q.size - k]
            out[: q.size - k] += self.band[k, : q.size - k] * q[k:]
        return np.asarray(out)


def unheld(problem: Problem) -> Array:
    """Rigid motions ``(6, k)`` of the node nearest the nut that no support holds."""
    arm = problem.scene.track.pitch_radius
    scale = np.array([1.0, 1.0, 1.0, 1.0 / arm, 1.0 / arm, 1.0 / arm])
    z = problem.nodes
    origin = z[pin_node(problem)]
    rows = rigid_transport(z - origin)[problem.fixed] * scale
    if rows.size == 0:
        return np.diag(scale)
    sv, vt = principal(rows)
    rank = int((sv > 1e-9 * sv[0]).sum())
    return np.asarray(scale[:, None] * vt[rank:].T)


def pin_node(problem: Problem) -> int:
    """Node nearest to the nut's centre."""
    return int(np.abs(problem.nodes - problem.scene.nut.position).argmin())


def shaft_of(problem: Problem) -> Shaft:
    """Stiffness of the beam, factored. A rigid screw has no stiffness: its free motions are all there is."""
    arm = problem.scene.track.pitch_radius
    if problem.basis is not None:
        loose = np.flatnonzero(~problem.fixed[0])
        arms = np.where(loose < 3, 1.0, 1.0 / arm)
        motions = np.eye(6)[:, loose]
        none, no = np.zeros(6, dtype=bool), np.zeros((0, 6, 6))
        return Shaft(problem, motions, _work(problem, motions, 0), arms, 0, none, (no, no), np.zeros((1, 6)))
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
    arms = np.ones(motions.shape[1])
    work = _work(problem, motions, pin)
    return Shaft(problem, motions, work, arms, pin, free, inverse_blocks(_factor(band, free)), band.T.copy())


def _work(problem: Problem, motions: Array, pin: int) -> Array:
    """Work ``(k,)`` of the loads on free rigid motions ``(6, k)``."""
    if problem.basis is not None:
        return np.asarray(problem.load[0] @ motions)
    at_pin = np.einsum("nij,ni->j", rigid_transport(problem.nodes - problem.nodes[pin]), problem.load)
    return np.asarray(motions.T @ at_pin)


def _factor(band: Array, free: NDArray[np.bool_]) -> Array:
    """Factor of a lower band ``(6 n, 12)`` (`kernel.banded`) with freedoms that are not free held by a unit diagonal."""
    kept = band.copy()
    for k in range(1, band.shape[1]):
        kept[: len(free) - k, k] *= free[: len(free) - k] & free[k:]
    kept[~free, 0] = 1.0
    if not factor_band(kept):
        raise np.linalg.LinAlgError("the stiffness of a shaft with supports is not positive")
    return kept


def rows_of(problem: Problem, used: list[int]) -> tuple[NDArray[np.int64], Array]:
    """Freedoms ``(c, m)`` and rows ``(c, 2, m)`` of the flanks of the used sides, side after side."""
    m = problem.B.shape[3]
    dof = [6 * problem.node[:, s, None] + np.arange(m) for s in used]
    return np.concatenate(dof), np.concatenate([problem.B[:, s] for s in used])


def flank_response(shaft: Shaft, used: list[int]) -> tuple[Array, Array]:
    """Compliance ``(2 c, 2 c)`` of the used flanks through the beam, and their motion by the free rigid motions
    ``(2 c, k)``."""
    problem = shaft.problem
    dof, rows = rows_of(problem, used)
    count = rows.shape[0]
    if problem.basis is not None:
        flat = rows.reshape(2 * count, -1)
        loose = np.flatnonzero(~problem.fixed[0])
        return np.zeros((2 * count, 2 * count)), flat[:, loose]
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
    """Motion ``(2 c,)`` [m] of the used flanks by loads and prescribed displacements."""
    problem = shaft.problem
    dof, rows = rows_of(problem, used)
    if problem.basis is not None:
        return np.asarray(rows.reshape(2 * len(rows), -1) @ np.where(problem.fixed[0], problem.prescribed[0], 0.0))
    return np.asarray(np.einsum("cak,ck->ca", rows, np.add(*shaft.by_loads)[dof]).ravel())


def free_state(shaft: Shaft) -> tuple[Array, Array]:
    """Nodal motions ``(6 n,)`` by loads and prescribed displacements: the rigid one that these displacements are, or zero
    where they strain the beam, and what is beyond it. Round-off of a rigid motion that was solved for would strain it."""
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
    """Nodal motions ``(6 n, k)`` by the free rigid motions."""
    z = shaft.problem.nodes
    return np.asarray((rigid_transport(z - z[shaft.pin]) @ shaft.motions).reshape(6 * z.size, -1))


def node_motions(shaft: Shaft, loads: Array, amplitudes: Array) -> Array:
    """Nodal motions ``(n, 6)`` by nodal loads ``(6 n,)`` in addition to the scene's and the amplitudes ``(k,)`` of the free
    motions."""
    problem = shaft.problem
    if problem.basis is not None:
        q = np.where(problem.fixed, problem.prescribed, 0.0)
        q[0, ~problem.fixed[0]] = amplitudes
        return q
    moved, bent = shaft.by_loads
    q = bent + shaft.solve(loads[:, None])[:, 0]
    return np.asarray((moved + q + rigid_nodes(shaft) @ amplitudes).reshape(-1, 6))


def node_forces(shaft: Shaft, loads: Array) -> Array:
    """Forces and moments ``(n, 6)`` [N, N m] that the beam takes at its nodes when it moves as `node_motions` says."""
    return shaft.times(shaft.by_loads[1] + shaft.solve(loads[:, None])[:, 0]).reshape(-1, 6)


def flank_loads(problem: Problem, forces: Array, used: list[int]) -> Array:
    """Nodal loads ``(6 n,)`` of the flanks' forces ``(c, 2)`` [N]."""
    dof, rows = rows_of(problem, used)
    out = np.zeros(6 * problem.nodes.size)
    np.add.at(out, dof, np.einsum("cak,ca->ck", rows, forces))
    return out
