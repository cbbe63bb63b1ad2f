"""Many specimens of one screw on the motions of its flanks alone: the common part of their equations, kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.statics.problem import lever_arms
from rollbench.lowfi.statics.records import FlankCommon, FlankMembers, FlankStates, MemberArrays
from rollbench.lowfi.statics.static import Prepared
from rollbench.meshes.arrays import Array

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
    common: FlankCommon
    seen: Array
    at_start: Array

    def solve(self, members: MemberArrays, centre: Array) -> FlankStates:
        """Solutions of specimens whose grooves have the centres (m or 1, N, 4, 2) [m]."""
        p, (k, n) = self.prepared, members.r_ball.shape
        lever = (centre - p.problem.drawn.centre)[:, :, :2] / p.options.arm + np.zeros((k, 1, 1, 1))
        status, residual = np.empty(k, dtype=np.int64), np.empty(k)
        states = FlankStates(np.empty((k, n, 4)), status, residual, np.empty((k, len(self.seen))), np.empty((k, n, 2)))
        p.engine.flank_members(self.common, FlankMembers(*members[1:], lever), p.options.tolerance, states)
        return states

    def functions(self, pulls: Array) -> Array:
        """Those linear functions (m, j) in solutions of pulls (m, c)."""
        return np.asarray(pulls @ self.seen + self.at_start)


def pressed(prepared: Prepared, functions: Array) -> Pressed | None:
    """The common part of specimens that all begin from a solution; None where the flanks alone do not serve: profiles, a
    solution that is no start for others, or too many balls.

    functions: see `Pressed`, by the motions of the nodes (j, 6 n).
    """
    engine, contacts, state, options = prepared.engine, prepared.contacts, prepared.state, prepared.options
    count = contacts.r_ball.size
    if not 0 < count <= LARGEST or options.floor == 0.0 or contacts.profile.shape[1]:
        return None
    arms, first = flank_rows(prepared)
    arms, first = arms.reshape(6 * count, -1), first.ravel()
    motions, reach, stiffness = np.empty((state.q.size, first.size)), np.empty((first.size,) * 2), np.zeros((count, 4, 4))
    if not engine.answers(prepared.beam, contacts, state, options, (arms, first), (motions, reach, stiffness)):
        return None
    freedoms, flat = first[:, None] + np.arange(arms.shape[1]), state.q.ravel()
    motion = (arms * flat[freedoms]).sum(axis=1).reshape(count, 6)
    sums = np.bincount(freedoms.ravel(), np.abs(arms).ravel(), flat.size).reshape(-1, 6) / np.repeat([1.0, options.arm], 3)
    spread = float(sums[~prepared.beam.fixed].max(initial=0.0))
    force = (prepared.force[:, :2, None] * prepared.normal[:, :2]).reshape(count, 4)
    common = FlankCommon(
        reach,
        motion,
        force,
        stiffness,
        state.p.copy(),
        soft_modes(reach, stiffness),
        contacts.profile,
        contacts.tiny,
        options.floor,
        spread,
    )
    return Pressed(prepared, common, (functions @ motions).T, functions @ flat)


def flank_rows(prepared: Prepared) -> tuple[Array, NDArray[np.int64]]:
    """Motions of each ball's flanks SL and SR along x3, z3, and their turns about the track times ``options.arm``:
    coefficients (N, 6, m) of the motions of the nodes, and the freedoms (N, 6) from which on these are."""
    problem, B = prepared.problem, prepared.contacts.B
    # a centre that is further out moves along z3 by that distance times the turn more
    turns = lever_arms(problem, (problem.drawn.centre + np.array([prepared.options.arm, 0.0]))[None])[0] - B
    arms = np.concatenate([B.reshape(len(B), 4, -1), turns[:, :, 1]], axis=1)
    return arms, 6 * problem.node[:, [0, 0, 1, 1, 0, 1]]


def soft_modes(reach: Array, stiffness: Array) -> Array:
    """Modes U (6 N, `SOFT`) of the flanks' motions by which U U^T is nearest to ``reach`` (6 N, 6 N) where contacts of the
    given stiffness (N, 4, 4) resist: subspace iteration from random forces, Nystrom's approximation."""
    count = len(stiffness)
    picks = (6 * np.arange(count)[:, None] + np.arange(4)).ravel()
    picked = reach[np.ix_(picks, picks)]
    forces = np.random.default_rng(0).standard_normal((4 * count, min(SOFT, 4 * count)))
    for _ in range(PASSES):
        pressed_by = stiffness @ (picked @ forces).reshape(count, 4, -1)
        forces = np.linalg.qr(pressed_by.reshape(4 * count, -1))[0]
    moved = picked @ forces
    size, turned = np.linalg.eigh(forces.T @ moved)
    kept = size > 1e-12 * size[-1]
    soft = np.zeros((6 * count, int(kept.sum())))
    soft[picks] = moved @ turned[:, kept] / np.sqrt(size[kept])
    return soft
