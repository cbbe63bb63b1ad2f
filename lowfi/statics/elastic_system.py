"""Flanks of a scene with elastic bodies, as the kernels take them: compliance, motions by loads, springs to start with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.hertz import contact_stiffness
from rollbench.lowfi.statics.kernel_types import Bodies
from rollbench.lowfi.statics.problem import Problem
from rollbench.lowfi.statics.response import NOTHING, Response, by_ball, normals_of, one_pair
from rollbench.lowfi.statics.shaft import Shaft, flank_motions_by_loads
from rollbench.lowfi.statics.squeeze import Squeeze
from rollbench.meshes.arrays import Array

#: Largest number of balls: compliance between all contacts is formed whole, so memory and set-up grow as its square.
LARGEST = 1000


@dataclass(frozen=True)
class Flanks:
    """How the flanks of all balls move, ball by ball: four flanks each (d = 8 motions), or one pair's relative motion (2).

    e ``(N, 4)`` [m/N] and h ``(N, 4)`` [m/N^(4/3)] besides Hertz; clipped: largest negative compliance cut away
    over a contact's own. kept: what the flanks' motions are found from again: compliance of screw and of nut on the
    built sides, v0 ``(N, 2, 2)`` and R ``(N, 2, 2, k)`` of the screw's flanks;
    squeeze: what is in them of the shaft's section forces, where it carries anything above the contacts. slope ``(4,)``
    [m/N]: what e gains by the logarithm of the cube root of the typical force, which h has over that root; lent [m/N]: the
    most that a contact lent to the bodies (`positive`).
    """

    bodies: Bodies
    e: Array
    h: Array
    clipped: float
    kept: tuple[Array, Array, Array, Array]
    slope: Array
    lent: float
    squeeze: Squeeze | None = None


def contact_compliance(problem: Problem, force: float) -> float:
    """Tangent compliance [m/N] of a contact under a force [N]."""
    return float(1.0 / contact_stiffness(force, float(np.mean(problem.C))))


def flanks_of(problem: Problem, force: float, shaft: Shaft, response: Response) -> Flanks:
    """Motions of all flanks of a problem, with what balls add to the contacts' laws; force [N]: at which small terms are
    taken that depend on a contact's size; shaft: under the problem's loads."""
    N, squeeze = len(problem.C), response.squeeze
    size, tangent = float(np.cbrt(force)), contact_compliance(problem, force)
    sides = [s for s in (0, 1) if problem.use[s]]
    moved, v0 = flank_motions_by_loads(shaft, sides), np.zeros((N, 2, 2))
    if squeeze is not None:
        squeeze = squeeze.under(shaft)
        moved = moved + squeeze.moved
    v0[:, sides] = moved[by_ball(N, len(sides))].reshape(N, len(sides), 2)
    e, h = np.zeros((N, 4)), np.zeros((N, 4))
    used = problem.use  # e by its tangent at the typical force, as the logarithm of F^(1/3) is taken
    e[:, used] = (response.e + response.slope * (np.log(size) - 1.0))[used]
    h[:, used] = (response.h + response.slope / size)[used]
    pair = one_pair(problem)
    if pair is not None:
        first, lent, clipped = response.solved[0].positive(tangent)
        e[:, pair[0]] -= lent
        second, most_lent, s = NOTHING, float(lent.max(initial=0.0)), pair[0] % 2
        start, free = v0[:, s], response.R[:, s]
    else:
        (first, on_screw, low), (second, on_nut, high) = (body.positive(tangent) for body in response.solved)
        e -= np.concatenate([on_screw.reshape(N, 2), on_nut.reshape(N, 2)], axis=1)
        clipped, most_lent = max(low, high), float(max(on_screw.max(initial=0.0), on_nut.max(initial=0.0)))
        start, free = np.zeros((N, 4, 2)), np.zeros((N, 4, 2, shaft.work.size))
        start[:, :2], free[:, :2] = v0, response.R
    R, moved = np.ascontiguousarray(free.reshape(N, start[0].size, -1)), np.ascontiguousarray(start.reshape(N, -1))
    bodies = Bodies(first.G, second.G, R, moved, shaft.work)
    kept = *response.bodies, v0, response.R
    return Flanks(bodies, e, h, clipped / tangent, kept, response.slope, most_lent, squeeze)


def pair_data(problem: Problem, pair: tuple[int, int], e: Array, h: Array) -> Array:
    """Rows of `lowfi.statics.kernel.elastic_balls.pair_balls`, ``(N, 7)``."""
    a, b = pair
    geometry = problem.geometry
    D = geometry[:, b, :2] - geometry[:, a, :2]
    size = np.hypot(D[:, 0], D[:, 1])
    constant = geometry[:, a, 4] + geometry[:, b, 4]
    return np.column_stack([D, size, problem.closure[:, a], constant, e[:, a] + e[:, b], h[:, a] + h[:, b]])


def spring_rows(problem: Problem, pair: tuple[int, int] | None, stiffness: float) -> Array:
    """Linear springs between opposite flanks, ``(N, 1, 2)`` for one pair or ``(N, 2, 8)``."""
    w = normals_of(problem.geometry)
    root = np.sqrt(stiffness)
    if pair is not None:
        return np.ascontiguousarray(root * w[:, pair[0], None, :])
    rows = np.zeros((w.shape[0], 2, 4, 2))
    for s in range(2):
        if problem.use[s] and problem.use[3 - s]:
            rows[:, s, s], rows[:, s, 3 - s] = root * w[:, s], -root * w[:, s]
    return rows.reshape(-1, 2, 8)
