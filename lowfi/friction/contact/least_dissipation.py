"""Motions of least dissipation of independent bodies on elliptical contacts, some of which may stick, as arrays.

The unknown is the motion q of a body. Its contacts have the motion (vx, vz, spin) = ``maps @ q + drives`` and the friction
bound mu F. The convex function sum_i mu F_i D_i(v_i; speed) - push . q is minimised by Newton's method for a sequence of
decreasing regularising speeds. Then contacts that nearly stand still are set to rest exactly.

Axes of the arrays: K bodies, m contacts of a body, three components (sliding vx, vz along the semi-axes a, b, and spin), n
unknowns.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rollbench.lowfi.friction.contact.descent import move_along_steps
from rollbench.lowfi.friction.contact.dissipation import dissipation_ratio
from rollbench.meshes.arrays import Array, Index, Mask

#: Status of a solution: each contact rests or slips exactly; friction is regularised, because a contact is on the verge of
#: slip; every contact rests, because there is neither drive nor force.
EXACT, REGULARISED, AT_REST = 0, 1, 2

#: Regularising speeds over the drive's speed: the first, that from which on contacts may be set to rest, and the last. They
#: are powers of ten, and these are their exponents with the sign reversed.
FIRST, LAST_SMOOTH, LEAST = 1, 6, 10
#: Largest unbalanced force over the sum of the friction bounds at which a search ends: while the speed decreases, from
#: ``LAST_SMOOTH`` on, and without regularisation.
ROUGH, FINE, EXACTLY = 1e-3, 1e-11, 1e-13
#: Largest numbers of Newton steps: at one speed, from a motion that is near, without regularisation, and for one contact
#: that may stick; from a motion that is near if the search from afar costs little more.
STEPS, NEAR_STEPS, EXACT_STEPS, STICK_STEPS, FEW_STEPS = 200, 20, 12, 100, 6
#: Largest numbers of trials of a step: in general, and without regularisation, where shorter steps lead to a contact that
#: is about to stick; least factor between two trials.
TRIALS, FEW_TRIALS, SHORTEST = 40, 8, 1e-6
#: Surface speed over the speed of the drive, above which the other forces exceed friction, and the search is given up.
REACH = 1e9
#: Unbalanced force on a body, as a fraction of the sum of its friction bounds, up to which friction that is not regularised
#: is in balance, and above which there is no equilibrium.
BALANCED, UNBALANCED = 1e-9, 1e-6
#: Contacts slower than this multiple of the regularising speed are set to rest; they rest if their speed is then at most
#: this fraction of it.
SLOW, AT_MOST = 100.0, 1e-6


class FrictionalBodies(NamedTuple):
    """Contacts, kinematics and forces of K bodies with m contacts and n unknown velocities each."""

    #: Semi-axes a >= b of the contact ellipses ``(K, m)`` [m].
    a: Array
    #: Semi-axes b > 0 of the contact ellipses ``(K, m)`` [m].
    b: Array
    #: Friction bounds mu F of the contacts ``(K, m)`` [N]; zero for a contact without load.
    bound: Array
    #: Motion of the contacts per unit of each unknown ``(K, m, 3, n)``.
    maps: Array
    #: Motion of the contacts at q = 0, which the drive imposes ``(K, m, 3)``.
    drives: Array
    #: Forces other than friction ``(K, n)`` [W per unit of the unknown].
    push: Array

    def take(self, bodies: Index | Mask) -> FrictionalBodies:
        """Return some of the bodies, given by their numbers or a mask."""
        return FrictionalBodies(*(values[bodies] for values in self))

    def contact_motions(self, q: Array) -> Array:
        """Return the motions of the contacts ``(K, m, 3)`` at the motions q ``(K, n)`` of the bodies."""
        return np.asarray(self.drives + (self.maps @ q[:, None, :, None])[..., 0])

    def surface_speeds(self, motion: Array) -> Array:
        """Return surface speeds sqrt(vx^2 + vz^2 + (a spin)^2) ``(K, m)`` [m/s] of contacts with motions ``(K, m, 3)``."""
        return np.asarray(np.linalg.norm(motion * self.levers, axis=-1))

    def slowest_contact(self, q: Array) -> Array:
        """Return the smallest surface speed of a loaded contact of each body ``(K,)`` [m/s] at the motions q ``(K, n)``."""
        speeds = self.surface_speeds(self.contact_motions(q))
        return np.asarray(np.where(self.bound > 0.0, speeds, np.inf).min(axis=1))

    @property
    def levers(self) -> Array:
        """Factors that turn sliding and spin into surface speeds: 1, 1, a ``(K, m, 3)``."""
        one = np.ones_like(self.a)
        return np.stack([one, one, self.a], axis=-1)

    @property
    def surface_speed_per_unknown(self) -> Array:
        """Root of the sum of squares of the loaded contacts' surface speeds per unit of each unknown ``(K, n)``.

        It is 1 for an unknown that moves no loaded contact. The search scales the unknowns by these values.
        """
        rows = np.where((self.bound > 0.0)[..., None, None], self.levers[..., None] * self.maps, 0.0)
        total = (rows**2).sum(axis=(1, 2))
        return np.where(total > 0.0, np.sqrt(total), 1.0)


class DissipationState(NamedTuple):
    """Dissipated power of K bodies less the power of the other forces, with its derivatives by the motion q."""

    #: Dissipated power less power of the other forces ``(K,)`` [W].
    value: Array
    #: Negative friction on the bodies ``(K, m, 3)``: forces along the semi-axes [N], moments about the normals [N m].
    friction: Array
    #: Derivatives of the value by q ``(K, n)``: unbalanced forces with reversed sign.
    gradient: Array
    #: Second derivatives of the value by q ``(K, n, n)``.
    hessian: Array
    #: Largest unbalanced force on each body ``(K,)`` [N].
    imbalance: Array


def evaluate_dissipation(bodies: FrictionalBodies, units: Array, speed: Array, q: Array) -> DissipationState:
    """Return the dissipation of K bodies at motions q ``(K, n)`` and regularising speeds ``(K,)`` [m/s].

    ``units``: surface speed per unit of each unknown (`FrictionalBodies.surface_speed_per_unknown`), by which unbalanced
    forces are divided.
    """
    rubs = bodies.bound > 0.0
    motion, each = bodies.contact_motions(q), np.broadcast_to(speed[:, None], rubs.shape)
    law = dissipation_ratio(bodies.a[rubs], bodies.b[rubs], motion[rubs], each[rubs])
    bound = bodies.bound[rubs]
    power, friction, bend = (np.zeros(rubs.shape + rest) for rest in ((), (3,), (3, 3)))
    power[rubs] = bound * law.value
    friction[rubs], bend[rubs] = bound[:, None] * law.gradient, bound[:, None, None] * law.hessian
    gradient = resultant(bodies, friction) - bodies.push
    hessian = (bodies.maps.swapaxes(2, 3) @ (bend @ bodies.maps)).sum(axis=1)
    value = power.sum(axis=1) - (bodies.push * q).sum(axis=1)
    return DissipationState(value, friction, gradient, hessian, np.abs(gradient / units).max(axis=1))


def resultant(bodies: FrictionalBodies, forces: Array) -> Array:
    """Return the generalised forces ``(K, n)`` of forces and moments at the contacts ``(K, m, 3)``."""
    return np.asarray(np.einsum("kmr,kmrn->kn", forces, bodies.maps))


def newton_step(hessian: Array, gradient: Array, units: Array) -> Array:
    """Return Newton's steps of K motions ``(K, n)``, by Cholesky factorisations with pivots bounded below.

    A motion without dissipation, whose pivot is round-off, does not move. ``hessian`` ``(K, n, n)``, ``gradient`` ``(K,
    n)``: derivatives of the dissipation; ``units`` ``(K, n)``: surface speed per unit of each unknown.
    """
    n = gradient.shape[1]
    factor, scaled = hessian / (units[:, :, None] * units[:, None, :]), np.empty_like(gradient)
    floor = np.maximum(1e-13 * np.einsum("knn->kn", factor).max(axis=1), 1e-300)
    for j in range(n):
        row = factor[:, j, :j]
        pivot = np.sqrt(np.maximum(factor[:, j, j] + floor - (row**2).sum(axis=1), floor))
        below = factor[:, j + 1 :]
        below[:, :, j] = (below[:, :, j] - (below[:, :, :j] @ row[..., None])[..., 0]) / pivot[:, None]
        factor[:, j, j] = pivot
    for j in range(n):
        known = (factor[:, j, :j] * scaled[:, :j]).sum(axis=1)
        scaled[:, j] = (-gradient[:, j] / units[:, j] - known) / factor[:, j, j]
    for j in reversed(range(n)):
        known = (factor[:, j + 1 :, j] * scaled[:, j + 1 :]).sum(axis=1)
        scaled[:, j] = (scaled[:, j] - known) / factor[:, j, j]
    return scaled / units


def minimise_dissipation(
    bodies: FrictionalBodies,
    speed: Array,
    q: Array,
    tolerance: Array | float,
    limit: Array | int,
    reach: Array | float,
    trials: int = TRIALS,
) -> tuple[DissipationState, Index]:
    """Find the motions q of least dissipation at the regularising speeds; return the state there and the numbers of steps.

    Parameters
    ----------
    bodies
        K bodies.
    speed
        Regularising speeds ``(K,)`` [m/s].
    q
        Motions from which the search begins ``(K, n)``; overwritten by the result.
    tolerance
        Largest unbalanced force, over the sum of the friction bounds, at which the search ends ``(K,)``.
    limit
        Largest number of Newton steps ``(K,)``.
    reach
        Surface speed at which the search is given up, because other forces exceed friction ``(K,)`` [m/s].
    trials
        Largest number of trials of a step, each shorter than the one before.
    """
    units, goal = bodies.surface_speed_per_unknown, tolerance * bodies.bound.sum(axis=1)
    state = evaluate_dissipation(bodies, units, speed, q)
    count, moving = np.zeros(len(q), dtype=int), np.ones(len(q), dtype=bool)
    while True:
        moving &= (count < limit) & (state.imbalance > goal) & (np.abs(q * units).max(axis=1) <= reach)
        on = np.flatnonzero(moving)
        if not on.size:
            return state, count
        count[on] += 1
        step = newton_step(state.hessian[on], state.gradient[on], units[on])
        slope, value, imbalance = (state.gradient[on] * step).sum(axis=1), state.value[on], state.imbalance[on]
        hidden = -slope <= 1e-13 * np.abs(value)  # the change of the value is round-off: compare unbalanced forces

        def evaluate(some: Index, trial: Array) -> DissipationState:
            """Return the dissipation of some bodies at motions to be tried."""
            return evaluate_dissipation(bodies.take(some), units[some], speed[some], trial)

        def accept(
            at: Index,
            length: Array,
            there: DissipationState,
            known: tuple[Array, Array, Array, Mask] = (slope, value, imbalance, hidden),
        ) -> Mask:
            """Return whether the value, or where round-off hides its change the unbalanced force, has decreased enough."""
            slope, value, imbalance, hidden = (values[at] for values in known)
            enough = there.value <= value + 1e-4 * length * slope
            return np.where(hidden, there.imbalance < 0.5 * imbalance, enough)

        def shorten(
            at: Index, length: Array, there: DissipationState, known: tuple[Array, Array, Array] = (step, slope, value)
        ) -> Array:
            """Return the factor that leads to where the tangents at both ends of a step meet.

            The value is convex, so that this is between them; where a contact stops on the way, the tangents meet there.
            """
            step, slope, value = (values[at] for values in known)
            slope_there = (there.gradient * step).sum(axis=1)
            bend, part = length * (slope_there - slope), np.full(at.size, 0.5)
            np.divide(length * slope_there - (there.value - value), bend, out=part, where=bend > 1e-200)
            return np.asarray(np.clip(np.nan_to_num(part, nan=0.5), SHORTEST, 0.5))

        moving[on] = move_along_steps(q, state, on, (step, np.ones(on.size)), evaluate, accept, trials, shorten)


def motion_nearest_to_rolling(bodies: FrictionalBodies) -> Array:
    """Return the motions ``(K, n)`` of bodies that are nearest to pure rolling in their contacts.

    The sum of squared surface speeds of the contacts, weighted by their friction bounds, is least. This motion is the
    solution of a linear system, and unique except for motions without surface speed.
    """
    weight = bodies.bound[..., None] * bodies.levers**2
    hessian = np.einsum("kmr,kmri,kmrj->kij", weight, bodies.maps, bodies.maps)
    return newton_step(hessian, resultant(bodies, weight * bodies.drives), bodies.surface_speed_per_unknown)


def motions_of_least_dissipation(bodies: FrictionalBodies, speeds: Sequence[float], start: Array) -> Array:
    """Return the motions of least dissipation ``(K, n)`` at the last of some falling regularising speeds [m/s].

    The search begins at the last speed from ``start`` ``(K, n)``; for bodies that do not arrive with few Newton steps,
    and for starts with nan, it begins at the first speed from the motion nearest to rolling.
    """
    rolling, bound, near = (
        motion_nearest_to_rolling(bodies),
        bodies.bound.sum(axis=1),
        np.asarray(~np.isnan(start).any(axis=1)),
    )
    q = np.where(near[:, None], start, rolling)

    def descend(on: Index, speed: float, goal: float, limit: int = STEPS) -> Mask:
        """Minimise the dissipation of some bodies at one regularising speed; return which of them arrive."""
        # the change of the motion is the unknown, as in `least_dissipation_of_bodies`
        some, change = bodies.take(on), np.zeros((on.size, q.shape[1]))
        some = some._replace(drives=some.contact_motions(q[on]))
        state, _ = minimise_dissipation(some, np.full(on.size, speed), change, goal, limit, REACH)
        q[on] += change
        return np.asarray(state.imbalance <= goal * bound[on])

    begun = np.flatnonzero(near)
    far = np.concatenate([np.flatnonzero(~near), begun[~descend(begun, speeds[-1], FINE, FEW_STEPS)]])
    q[far] = rolling[far]
    for speed in speeds if far.size else ():
        descend(far, speed, FINE if speed == speeds[-1] else ROUGH)
    return q


class LeastDissipation(NamedTuple):
    """Motions of least dissipation of K bodies, and the friction on them."""

    #: Unknown velocities of the bodies ``(K, n)``.
    q: Array
    #: Negative friction and reactions on the bodies ``(K, m, 3)`` [N, N m].
    forces: Array
    #: Whether each contact sticks ``(K, m)``.
    rest: Mask
    #: ``EXACT``, ``REGULARISED`` or ``AT_REST`` ``(K,)``.
    status: Index
    #: Largest unbalanced force on each body ``(K,)`` [N].
    imbalance: Array
    #: Number of Newton steps ``(K,)``.
    steps: Index

    def balanced(self, bodies: FrictionalBodies) -> Mask:
        """Return whether the unbalanced force of each body is at most 1e-6 of the sum of its friction bounds ``(K,)``."""
        return np.asarray((self.imbalance <= UNBALANCED * bodies.bound.sum(axis=1)) | (self.status == AT_REST))


def least_dissipation_of_bodies(
    bodies: FrictionalBodies, start: Array | None = None, near: bool = False
) -> LeastDissipation:
    """Return the motions of least dissipation of K independent bodies with given normal loads.

    The regularising speed decreases from 0.1 to 1e-6 times the drive's speed (to 1e-10 if a contact is on the verge of
    slip); each minimum is the start of the next. Then contacts that stand still are set to rest.

    Parameters
    ----------
    bodies
        The bodies.
    start
        Motions from which the search begins ``(K, n)``; nan, or None for all bodies, to begin with the motion nearest to
        rolling.
    near
        Whether ``start`` is near the solution: where all contacts slide, the search is then first made without
        regularisation; else it begins with the speed 1e-6 at once, and from the motion nearest to rolling if this fails.
    """
    count, n = bodies.push.shape
    pressed = np.where(bodies.bound > 0.0, bodies.surface_speeds(bodies.drives), 0.0)
    top = pressed.max(axis=1, initial=0.0)
    still = np.asarray((top == 0.0) & ~bodies.push.any(axis=1))
    top = np.where(top == 0.0, 1.0, top)  # [m/s]: only ``push`` acts, and no other speed is known
    begin = np.full((count, n), np.nan) if start is None else start
    unknown = np.asarray(np.isnan(begin).any(axis=1))
    q = np.where(unknown[:, None], motion_nearest_to_rolling(bodies), begin)
    q[still] = 0.0
    hurried: Mask = np.asarray(~unknown & near)
    out = LeastDissipation(
        q,
        np.zeros(bodies.drives.shape),
        np.repeat(still[:, None], bodies.a.shape[1], axis=1),
        np.where(still, AT_REST, REGULARISED),
        np.zeros(count),
        np.zeros(count, dtype=int),
    )

    def keep(at: Index, exact: LeastDissipation, good: Mask) -> None:
        """Write those solutions of some bodies that are good."""
        to = at[good]
        q[to], out.forces[to], out.rest[to] = exact.q[good], exact.forces[good], exact.rest[good]
        out.status[to], out.imbalance[to] = EXACT, exact.imbalance[good]
        out.steps[at] += exact.steps

    left, slow = ~still, SLOW * 10.0**-LAST_SMOOTH * top
    first = np.flatnonzero(left & hurried & (bodies.slowest_contact(q) >= slow))
    if first.size:
        exact, good = slide_in_all_contacts(bodies.take(first), q[first], slow[first])
        keep(first, exact, good)
        left[first[good]] = False
    level, on = np.where(hurried, LAST_SMOOTH, FIRST), np.flatnonzero(left)
    while on.size:
        some, last = bodies.take(on), level[on] >= LAST_SMOOTH
        speed = top[on] * 10.0 ** -level[on].astype(float)
        goal, limit = np.where(last, FINE, ROUGH), np.where(hurried[on], NEAR_STEPS, STEPS)
        # the change of the motion is the unknown: a sticking contact's speed is tiny, and lost in differences of large ones
        near_here, change = some._replace(drives=some.contact_motions(q[on])), np.zeros((on.size, n))
        state, taken = minimise_dissipation(near_here, speed, change, goal, limit, REACH * top[on])
        found = q[on] = q[on] + change
        out.imbalance[on] = state.imbalance
        out.steps[on] += taken
        missed = hurried[on] & (state.imbalance > goal * some.bound.sum(axis=1))
        again = on[missed]
        hurried[on] = False
        q[again], level[again] = motion_nearest_to_rolling(some.take(missed)), FIRST
        done, end = np.zeros(on.size, dtype=bool), np.flatnonzero(last & ~missed)
        if end.size:
            out.forces[on[end]] = state.friction[end]
            exact, good = set_slow_contacts_to_rest(some.take(end), found[end], state.friction[end], SLOW * speed[end])
            keep(on[end], exact, good)
            done[end] = good
        level[on[~missed]] += 1
        on = on[~done & (level[on] <= LEAST)]
    return out


def slide_in_all_contacts(bodies: FrictionalBodies, start: Array, slow: Array) -> tuple[LeastDissipation, Mask]:
    """Search motions of least dissipation without regularisation near ``start`` ``(K, n)``.

    Returns the motions, and whether each is found ``(K,)``: forces are in balance, and every loaded contact is faster than
    ``slow`` ``(K,)`` [m/s], so that none may stick.
    """
    q, bound = start.copy(), bodies.bound.sum(axis=1)
    state, steps = minimise_dissipation(bodies, np.zeros(len(q)), q, EXACTLY, EXACT_STEPS, REACH * slow, FEW_TRIALS)
    good = (state.imbalance <= BALANCED * bound) & (bodies.slowest_contact(q) >= slow)
    none, rest = np.full(len(q), EXACT), np.zeros(bodies.bound.shape, dtype=bool)
    return LeastDissipation(q, state.friction, rest, none, state.imbalance, steps), good


def set_slow_contacts_to_rest(
    bodies: FrictionalBodies, q: Array, forces: Array, still: Array
) -> tuple[LeastDissipation, Mask]:
    """Let contacts slower than ``still`` stick, and minimise the dissipation of the other contacts without regularisation.

    Parameters
    ----------
    bodies
        K bodies.
    q, forces
        Motions ``(K, n)`` and negative friction ``(K, m, 3)`` with regularised friction.
    still
        Surface speed of the contacts below which they are set to rest ``(K,)`` [m/s].

    Returns
    -------
    tuple
        The motions, and whether each is the least dissipation ``(K,)``: sticking is kinematically possible, and every
        reaction lies inside its limit surface.
    """
    count, n = q.shape
    units, levers, motion = bodies.surface_speed_per_unknown, bodies.levers, bodies.contact_motions(q)
    rest = (bodies.bound > 0.0) & (bodies.surface_speeds(motion) < still[:, None])
    slipping = bodies._replace(bound=np.where(rest, 0.0, bodies.bound))
    # surface speeds of the sticking contacts by the unknowns times their units
    rows = np.where(rest[..., None, None], levers[..., None] * bodies.maps / units[:, None, None, :], 0.0)
    inverse, basis = np.zeros((count, n, rows.shape[1] * 3)), np.tile(np.eye(n), (count, 1, 1))
    some = rest.any(axis=1)
    if some.any():
        inverse[some], basis[some] = kinematic_inverse_and_null_space(rows[some].reshape(-1, rows.shape[1] * 3, n))
        seen = np.where(rest[..., None], levers * motion, 0.0).reshape(count, -1, 1)
        q = q - (inverse @ seen)[..., 0] / units
        basis[some] /= units[some][:, None]
    # motions of the basis as unknowns
    free = slipping._replace(
        maps=bodies.maps @ basis.swapaxes(1, 2)[:, None],
        drives=bodies.contact_motions(q),
        push=(basis @ bodies.push[..., None])[..., 0],
    )
    y = np.zeros((count, n))
    state, steps = minimise_dissipation(free, np.zeros(count), y, EXACTLY, EXACT_STEPS, REACH * still, FEW_TRIALS)
    q = q + (y[:, None] @ basis)[:, 0]
    # reactions of the sticking contacts: those with regularised friction, and what is missing for balance
    held = np.where(rest[..., None], forces, state.friction)
    missing = (bodies.push - resultant(bodies, held)) / units
    held = held + np.where(rest[..., None], (missing[:, None] @ inverse).reshape(held.shape) * levers, 0.0)
    imbalance = np.abs((resultant(bodies, held) - bodies.push) / units).max(axis=1)
    speeds = bodies.surface_speeds(bodies.contact_motions(q))
    good = (imbalance <= BALANCED * bodies.bound.sum(axis=1)) & ~(rest & (speeds > AT_MOST * still[:, None])).any(axis=1)
    body, contact = np.nonzero(rest & good[:, None])
    if body.size:
        each = bodies.a[body, contact], bodies.b[body, contact], bodies.bound[body, contact]
        good[body[~contacts_can_stick(*each, held[body, contact])]] = False
    result = LeastDissipation(q, held, rest, np.full(count, EXACT), imbalance, steps)
    return result, good


def kinematic_inverse_and_null_space(rows: Array) -> tuple[Array, Array]:
    """Return the pseudo-inverses ``(K, n, c)`` and the null spaces ``(K, n, n)`` of conditions on motions ``(K, c, n)``.

    Rows of a null space are orthonormal motions that fulfil the homogeneous conditions, filled up with rows of zeros.
    """
    left, size, right = np.linalg.svd(rows)
    few = size.shape[1]
    used = size > 1e-9 * size[:, :1]
    by_size = np.where(used, 1.0 / np.where(used, size, 1.0), 0.0)
    inverse = (right[:, :few].swapaxes(1, 2) * by_size[:, None]) @ left[..., :few].swapaxes(1, 2)
    bound = np.zeros(right.shape[:2], dtype=bool)
    bound[:, :few] = used
    return inverse, np.where(bound[..., None], 0.0, right)


def contacts_can_stick(a: Array, b: Array, bound: Array, force: Array) -> Mask:
    """Return whether friction in each of k contacts can transmit a given force and moment without sliding.

    A contact can stick if the dissipated power D(v), regularised with a speed of 1 m/s, less the power force . v has a
    minimum over the sliding and spin v: the force is then a gradient of D and lies inside the limit surface of friction.
    ``a``, ``b``, ``bound``: semi-axes [m] and friction bounds [N] ``(k,)``; ``force``: components along the semi-axes [N],
    and moments about the normals [N m] ``(k, 3)``.
    """
    k = a.size
    maps, drives = np.tile(np.eye(3), (k, 1, 1, 1)), np.zeros((k, 1, 3))
    single = FrictionalBodies(a[:, None], b[:, None], bound[:, None], maps, drives, force)
    state, _ = minimise_dissipation(single, np.ones(k), np.zeros((k, 3)), 1e-9, STICK_STEPS, REACH)
    return np.asarray(state.imbalance <= 1e-6 * bound)
