"""Many specimens of one screw whose balls are held by one diagonal pair each: the common part of their equations, kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lowfi.statics.records import PairCommon, PairMembers, PairStates
from lowfi.statics.static import Prepared
from meshes.arrays import Array

#: Most balls: above, the product with a matrix of that size costs more than the beam's own equations.
LARGEST = 128


@dataclass(frozen=True)
class Pressed:
    """What specimens share that differ in radii of balls and grooves' centres, but not in lever arms.

    common: see `lowfi.statics.records.PairCommon`; seen (2 N, j): linear functions of the nodes' motions by unit forces on
    the flanks, and at_start (j,) their values in the solution ``prepared`` that all begin from.
    """

    prepared: Prepared
    common: PairCommon
    seen: Array
    at_start: Array

    def solve(self, members: PairMembers, side_by_side: Callable[[Callable[[slice], None], int], None]) -> PairStates:
        """Solutions of specimens; ``side_by_side`` calls a function with slices of their range."""
        k, n = members.closure.shape[:2]
        found = PairStates(
            np.empty((k, n, 4)), np.empty(k, dtype=np.int64), np.empty(k), np.empty((k, 2 * n)), np.empty((k, n, 2))
        )

        def some(own: slice) -> None:
            given, into = PairMembers(*(x[own] for x in members)), PairStates(*(x[own] for x in found))
            p = self.prepared
            p.engine.press_members(self.common, p.options, p.contacts.tiny, given, into)

        side_by_side(some, k)
        return found

    def functions(self, pulls: Array) -> Array:
        """Those linear functions (m, j) in solutions of pulls (m, 2 N)."""
        return np.asarray(pulls @ self.seen + self.at_start)


def pressed(prepared: Prepared, functions: Array) -> Pressed | None:
    """The common part of specimens that all begin from a solution; None where balls have more than one pair of flanks, or
    profiles, or the solution is no start for others, or there are too many. functions: see `Pressed`, by the motions of the
    nodes (j, 6 n)."""
    engine, contacts, state, options = prepared.engine, prepared.contacts, prepared.state, prepared.options
    count, size = contacts.r_ball.size, state.q.size
    side = int(engine.pair_alone(contacts))
    if side < 0 or not 0 < count <= LARGEST or options.floor == 0.0:
        return None
    motions = np.empty((2 * count, size))
    rows = np.zeros((2 * count, size))
    picks = 6 * contacts.node[:, side, None, None] + np.arange(contacts.B.shape[3])
    rows.reshape(count, 2, size)[np.arange(count)[:, None, None], np.arange(2)[:, None], picks] = contacts.B[:, side]
    moments = np.where(np.arange(size) % 6 < 3, 1.0, 1.0 / options.arm)
    spread = float((np.abs(rows).sum(axis=0) * moments)[~prepared.beam.fixed.ravel()].max(initial=0.0))
    motion = (rows @ state.q.ravel()).reshape(count, 2)
    common = PairCommon(
        side, np.empty((2 * count, 2 * count)), motion, np.empty((count, 2)), np.empty((count, 2, 2)), spread
    )
    if not engine.answers(prepared.beam, contacts, state, options, side, common, motions):
        return None
    common.reach[...] = motions @ rows.T
    return Pressed(prepared, common, motions @ functions.T, functions @ state.q.ravel())
