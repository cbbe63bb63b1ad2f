"""Many specimens of one screw on the motions of its flanks alone: the common part of their equations, kept.

One kernel serves balls that one diagonal pair each holds, specimens alike in lever arms; another one four flanks a ball.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.statics.problem import lever_arms
from rollbench.lowfi.statics.records import FlankCommon, FlankMembers, PairCommon, PairMembers, PairStates
from rollbench.lowfi.statics.static import Prepared
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimens

#: Most balls: above, the product with a matrix of that size costs more than the beam's own equations.
LARGEST = 128
#: Number of soft modes, and how often random forces go through flanks and contacts to find them.
SOFT, PASSES = 8, 2


@dataclass(frozen=True)
class Pressed:
    """What specimens share that differ in radii of balls and grooves' centres.

    common: see `lowfi.statics.records`; seen (c, j): linear functions of the nodes' motions by unit forces on the flanks,
    and at_start (j,) their values in the solution ``prepared`` that all begin from.
    """

    prepared: Prepared
    common: PairCommon | FlankCommon
    seen: Array
    at_start: Array

    def solve(self, drawn: Specimens, offset: Array, closure: Array, C: Array) -> PairStates:
        """Solutions of specimens of given `distances` and Hertz constants (m, N, 4)."""
        k, n = closure.shape[:2]
        found = PairStates(
            np.empty((k, n, 4)),
            np.empty(k, dtype=np.int64),
            np.empty(k),
            np.empty((k, len(self.seen))),
            np.empty((k, n, 2)),
        )
        p = self.prepared
        if isinstance(self.common, PairCommon):
            p.engine.press_members(self.common, p.options, p.contacts.tiny, PairMembers(offset, closure, C), found)
        else:
            lever = (drawn.centre - p.problem.drawn.centre)[:, :, :2] / p.options.arm + np.zeros((k, 1, 1, 1))
            p.engine.flank_members(self.common, p.options, FlankMembers(offset, C, lever), found)
        return found

    def functions(self, pulls: Array) -> Array:
        """Those linear functions (m, j) in solutions of pulls (m, c)."""
        return np.asarray(pulls @ self.seen + self.at_start)


def pressed(prepared: Prepared, functions: Array, own_arms: bool) -> Pressed | None:
    """The common part of specimens that all begin from a solution; None where the flanks alone do not serve: profiles, a
    solution that is no start for others, or too many balls.

    functions: see `Pressed`, by the motions of the nodes (j, 6 n); own_arms: whether specimens differ in lever arms.
    """
    engine, contacts, state, options = prepared.engine, prepared.contacts, prepared.state, prepared.options
    count, side = contacts.r_ball.size, int(engine.pair_alone(contacts))
    if not 0 < count <= LARGEST or options.floor == 0.0 or contacts.profile.shape[1]:
        return None
    pair, (arms, first) = side >= 0 and not own_arms, flank_rows(prepared)
    picked = slice(2 * side, 2 * side + 2) if pair else slice(None)
    arms, first = np.ascontiguousarray(arms[:, picked]).reshape(-1, arms.shape[2]), first[:, picked].ravel()
    motions, reach, stiffness = np.empty((state.q.size, first.size)), np.empty((first.size,) * 2), np.zeros((count, 4, 4))
    found = motions, reach, stiffness
    if not engine.answers(prepared.beam, contacts, state, options, (arms, first), found):
        return None
    own, flat = first[:, None] + np.arange(arms.shape[1]), state.q.ravel()
    motion = (arms * flat[own]).sum(axis=1).reshape(count, -1)
    sums = np.bincount(own.ravel(), np.abs(arms).ravel(), flat.size).reshape(-1, 6) / np.repeat([1.0, options.arm], 3)
    spread = float(sums[~prepared.beam.fixed].max(initial=0.0))
    force = prepared.force[:, :2, None] * prepared.normal[:, :2]
    common: PairCommon | FlankCommon
    if pair:
        common = PairCommon(side, reach, motion, -force[:, side], stiffness[:, picked, picked].copy(), spread)
    else:
        forces, centre, use = force.reshape(count, 4), state.p.copy(), prepared.problem.use
        modes = soft_modes(reach, stiffness)
        common = FlankCommon(reach, motion, forces, stiffness, centre, *modes, use, spread, contacts.tiny)
    return Pressed(prepared, common, (functions @ motions).T, functions @ flat)


def flank_rows(prepared: Prepared) -> tuple[Array, NDArray[np.int64]]:
    """Motions of each ball's flanks SL and SR along x3, z3, and their turns about the track times ``options.arm``:
    coefficients (N, 6, m) of the motions of the nodes, and the freedoms (N, 6) from which on these are."""
    problem, B = prepared.problem, prepared.contacts.B
    # a centre that is further out moves along z3 by that distance times the turn more
    turns = lever_arms(problem, (problem.drawn.centre + np.array([prepared.options.arm, 0.0]))[None])[0] - B
    arms = np.concatenate([B.reshape(len(B), 4, -1), turns[:, :, 1]], axis=1)
    return arms, 6 * problem.node[:, [0, 0, 1, 1, 0, 1]]


def soft_modes(reach: Array, stiffness: Array) -> tuple[Array, Array]:
    """Modes U (6 N, `SOFT`) of the flanks' motions by which U U^T is nearest to ``reach`` (6 N, 6 N) where contacts of the
    given stiffness (N, 4, 4) resist: subspace iteration from random forces, Nystrom's approximation. And U^T D U (k (k + 1)
    / 2, 10 N), lower triangle row by row, of the balls' symmetric D (4, 4), upper triangles row by row."""
    count = len(stiffness)
    picks = (6 * np.arange(count)[:, None] + np.arange(4)).ravel()
    own = reach[np.ix_(picks, picks)]
    forces = np.random.default_rng(0).standard_normal((4 * count, min(SOFT, 4 * count)))
    for _ in range(PASSES):
        pressed_by = stiffness @ (own @ forces).reshape(count, 4, -1)
        forces = np.linalg.qr(pressed_by.reshape(4 * count, -1))[0]
    moved = own @ forces
    size, turned = np.linalg.eigh(forces.T @ moved)
    kept = size > 1e-12 * size[-1]
    moved = moved @ turned[:, kept] / np.sqrt(size[kept])
    soft = np.zeros((6 * count, moved.shape[1]))
    soft[picks] = moved
    modes = moved.reshape(count, 4, -1)
    (j, k), (a, b) = np.tril_indices(moved.shape[1]), np.triu_indices(4)
    both = modes[:, a][:, :, j] * modes[:, b][:, :, k]
    both += np.where(a == b, 0.0, 1.0)[:, None] * modes[:, b][:, :, j] * modes[:, a][:, :, k]
    return soft, np.ascontiguousarray(both.reshape(-1, j.size).T)
