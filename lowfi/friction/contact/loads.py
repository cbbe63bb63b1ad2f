"""Contact loads of balls between the grooves of two rigid bodies at the minimum of elastic energy, by Newton's method.

The bodies are screw and nut, inner and outer ring (a screw of zero lead), or carriage and rail. Other than in
`lowfi.statics.equilibrium`, whose balls carry contact forces only, friction and neighbours push each ball. Axes of the
arrays: K independent groups, each of N balls around an inner body that is free in m motions; contact; component along x, z
of the ball's groove section.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rollbench.lowfi.friction.contact.descent import move_along_steps
from rollbench.lowfi.friction.contact.normal_force import ON_INNER, BallContactArrays, normal_forces
from rollbench.meshes.arrays import Array, Index, Mask

#: Longest Newton step, as a fraction of the distance of the grooves' centres of curvature from the ball's centre.
LONGEST_STEP = 0.3
#: Stiffness on the diagonal of Newton's equations, which gives balls without contact a finite step, as a fraction of the
#: largest contact stiffness, and of the applied forces (at least ``LEAST_FORCE`` [N]) over the distance of the centres.
FLOOR, LEAST_FORCE = 1e-12, 1e-9
#: Largest number of trials of a step, and of Newton steps; ratio of the largest unbalanced force to the sum of all forces
#: at which a search ends.
HALVINGS, STEPS, GOAL = 50, 600, 1e-13


class GroupState(NamedTuple):
    """Elastic energy, contact forces and unbalanced forces of K groups at given displacements."""

    #: Elastic energy of the contacts ``(K,)`` [J].
    energy: Array
    #: Unbalanced forces on the balls ``(K, N, 2)`` [N]: derivatives of the energy less the work of the applied forces.
    on_balls: Array
    #: Unbalanced forces on the inner bodies along their motions ``(K, m)`` [N].
    on_inner: Array
    #: Contact forces ``(K, N, 4)`` [N].
    force: Array
    #: Contact normals ``(K, N, 4, 2)``.
    normal: Array
    #: Stiffness of each contact against displacements of the ball ``(K, N, 4, 2, 2)`` [N/m].
    stiffness: Array
    #: Largest unbalanced force of each group ``(K,)`` [N].
    imbalance: Array


def one_group(cell: BallContactArrays) -> BallContactArrays:
    """Return the balls of ``cell`` as the only one of K = 1 groups."""
    return BallContactArrays(*(np.asarray(values, dtype=float)[None] for values in cell))


def groups_at(groups: BallContactArrays, which: Index) -> BallContactArrays:
    """Return some of K groups, given by their numbers."""
    return BallContactArrays(*(values[which] for values in groups))


def state_of_groups(groups: BallContactArrays, ball: Array, inner: Array) -> GroupState:
    """Return the state of K groups after displacements of balls ``(K, N, 2)`` and inner bodies ``(K, m)`` [m]."""
    F, along, normal, distance = normal_forces(groups, ball, inner)
    energy = 0.4 * groups.C * F * np.cbrt(F) ** 2
    across = F / distance
    outer = normal[..., :, None] * normal[..., None, :]
    stiffness = across[..., None, None] * np.eye(2) + (along - across)[..., None, None] * outer
    push = F[..., None] * normal
    on_balls = push.sum(axis=2) - groups.ball_forces
    on_inner = -np.einsum("knsc,kncm->km", push[:, :, ON_INNER], groups.inner_displacement_maps) - groups.inner_body_forces
    imbalance = np.maximum(np.abs(on_balls).max(axis=(1, 2)), np.abs(on_inner).max(axis=1, initial=0.0))
    return GroupState(energy.sum(axis=(1, 2)), on_balls, on_inner, F, normal, stiffness, imbalance)


def newton_step_of_groups(groups: BallContactArrays, state: GroupState, floor: Array) -> tuple[Array, Array]:
    """Return Newton's steps of the balls ``(K, N, 2)``, then of the inner bodies ``(K, m)`` [m].

    The balls are eliminated first. ``floor``: stiffness on the diagonal ``(K,)`` [N/m]; it is larger for a ball without
    contact, whose step would shorten those of all others.
    """
    longest = LONGEST_STEP * groups.groove_ball_centre_distance[:, None]
    alone = np.maximum(floor[:, None], np.linalg.norm(state.on_balls, axis=-1) / longest)
    least = np.where(state.force.max(axis=-1) > 0.0, floor[:, None], alone)
    of_ball = state.stiffness.sum(axis=2) + least[..., None, None] * np.eye(2)
    maps = groups.inner_displacement_maps
    between = state.stiffness[:, :, ON_INNER].sum(axis=2) @ maps  # (K, N, 2, m)
    solved = np.linalg.solve(of_ball, np.concatenate([-state.on_balls[..., None], between], axis=-1))
    alone_step, per_inner = solved[..., 0], solved[..., 1:]
    whole = np.einsum("kncp,kncq->kpq", maps, between) - np.einsum("kncp,kncq->kpq", between, per_inner)
    whole += floor[:, None, None] * np.eye(maps.shape[-1])
    right = -state.on_inner + np.einsum("kncm,knc->km", between, alone_step)
    inner = np.linalg.solve(whole, right[..., None])[..., 0]
    return alone_step + (per_inner @ inner[:, None, :, None])[..., 0], inner


def minimise_energy(
    groups: BallContactArrays, load: Array, ball: Array, inner: Array
) -> tuple[Array, Array, GroupState, int]:
    """Return displacements of balls ``(K, N, 2)`` and inner bodies ``(K, m)`` of least energy, the state there, and steps.

    A search ends when the largest unbalanced force is at most `GOAL` times the sum of all forces, after `STEPS` steps,
    or when round-off prevents a further decrease of energy and imbalance.

    Parameters
    ----------
    groups
        Geometry, stiffness and applied forces of K groups: all fields with the axis of the groups in front.
    load
        Sums of the magnitudes of the applied forces ``(K,)`` [N].
    ball, inner
        Displacements from which the search begins [m].
    """
    count, n, _ = ball.shape
    x = np.concatenate([ball.reshape(count, 2 * n), inner], axis=1)

    def parts(x: Array) -> tuple[Array, Array]:
        """Return unknowns ``(k, 2 N + m)`` as those of balls ``(k, N, 2)`` and inner bodies ``(k, m)``."""
        return x[:, : 2 * n].reshape(-1, n, 2), x[:, 2 * n :]

    def evaluate(some: Index, trial: Array) -> GroupState:
        """Return the state of some groups at displacements to be tried."""
        return state_of_groups(groups_at(groups, some), *parts(trial))

    state, moving, steps = state_of_groups(groups, *parts(x)), np.ones(count, dtype=bool), 0
    reach = groups.groove_ball_centre_distance
    while steps < STEPS:
        moving &= state.imbalance > GOAL * (load + state.force.sum(axis=(1, 2)))
        on = np.flatnonzero(moving)
        if not on.size:
            break
        steps += 1
        some, there = groups_at(groups, on), GroupState(*(values[on] for values in state))
        stiffest = np.abs(there.stiffness).max(axis=(1, 2, 3, 4))
        floor = FLOOR * (stiffest + np.maximum(load[on], LEAST_FORCE) / reach[on])
        dp, du = newton_step_of_groups(some, there, floor)
        step = np.concatenate([dp.reshape(on.size, 2 * n), du], axis=1)
        first = np.minimum(1.0, LONGEST_STEP * reach[on] / np.maximum(np.abs(step).max(axis=1), 1e-300))
        slope = (there.on_balls * dp).sum(axis=(1, 2)) + (there.on_inner * du).sum(axis=1)
        work = (some.ball_forces * dp).sum(axis=(1, 2)) + (some.inner_body_forces * du).sum(axis=1)

        def accept(
            at: Index,
            length: Array,
            new: GroupState,
            known: tuple[Array, ...] = (slope, work, there.energy, there.imbalance),
        ) -> Mask:
            """Return whether the energy, or where round-off hides its change the imbalance, has decreased.

            The work of the step is added separately, which is precise also for nearly unloaded balls.
            """
            slope, work, energy, imbalance = (values[at] for values in known)
            enough = new.energy - energy - length * work <= 1e-4 * length * slope
            return np.where(-length * slope <= 1e-12 * energy, new.imbalance < imbalance, enough)

        moving[on] = move_along_steps(x, state, on, (step, first), evaluate, accept, HALVINGS)
    return *parts(x), state, steps
