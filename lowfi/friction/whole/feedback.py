"""What friction does to the place of a ball: new contact forces and angles at the same axial load of every ball.

Friction across the groove pushes each ball sideways until its contacts hold it, at other contact angles or on a third
flank (Lin 3.4.1). Each ball moves in its section and the screw yields along its axis by as much as keeps the axial load
that this ball carries, friction included; how loads are shared among balls stays as the static model has it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.friction.screw.motion import Mixer
from rollbench.lowfi.friction.screw.path import ON_SCREW
from rollbench.lowfi.friction.whole.contacts import StaticContacts, with_loads
from rollbench.lowfi.friction.whole.losses import BallFriction, ball_friction
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.settle import contact_angles
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimen, specimen
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: Difference of friction and what of it is fed back, as a fraction of a ball's contact forces: aimed at, and accepted
#: after most rounds.
AGREED, ACCEPTED, ROUNDS = 1e-7, 1e-4, 200
#: Displaced starts in the search for other states, and difference of states, as fractions of a ball's largest force.
DISPLACED, ANOTHER = 3.0, 1e-3
#: Coefficient of friction from which a second, jammed state of a ball was seen.
JAMMED = 0.3
#: Force out of balance as a fraction of a ball's contact forces; Newton steps; longest step as a fraction of the reach.
GOAL, STEPS, FAR = 1e-13, 60, 0.3


@dataclass(frozen=True)
class Seats:
    """N balls between their grooves at the static state; SI.

    away (N, 4, 2): from the centre of each groove's profile to the ball's centre along x3, z3; reach (N, 4): its length
    where ball and groove just touch; C (N, 4): Hertz constants; axis (3,): direction of the screw's axis in x3, y3, z3.
    """

    away: Array
    reach: Array
    C: Array
    axis: Array


def feeds_back(scene: Scene, friction: Friction) -> bool:
    """Whether friction moves balls in their grooves: it is asked for, there is friction, and a lead."""
    return friction.feedback and scene.track.lead != 0.0 and max(friction.screw, friction.nut) > 0.0


def seats(at: StaticContacts, C: Array, reach: Array, centre: Array) -> Seats:
    """Seats of balls from their contacts; reach (N, 4), centre (N, 4, 2): of the profiles without load [m].

    A flank without contact moves with the other one of its body. A ball without load keeps its nominal place.
    """
    squeeze = C * np.cbrt(at.force) ** 2
    away = (reach + squeeze)[..., None] * at.normals[..., [0, 2]]
    other = [1, 0, 3, 2]
    by_other = away[:, other] + centre[:, other] - centre
    free = (at.force == 0.0) & (at.force[:, other] > 0.0)
    away = np.where(free[..., None], by_other, away)
    reach = np.where(free, np.maximum(reach, np.hypot(away[..., 0], away[..., 1])), reach)
    return Seats(away, reach, C, np.asarray(at.frames[0, :, 2]))


def seats_of(scene: Scene, result: StaticResult, at: StaticContacts, member: int = 0) -> Seats:
    """Seats of the balls of a solved scene; member: as for ``contacts_of``."""
    return seats_at(at, specimen(scene, at.layout, member), result.hertz_C)


def seats_at(at: StaticContacts, drawn: Specimen, C: Array) -> Seats:
    """Seats of balls with errors ``drawn`` and Hertz constants C (N, 4)."""
    inward = np.zeros_like(at.angle)
    for s, row in enumerate(drawn.profile):
        inward[:, s] = np.polynomial.polynomial.polyval(at.angle[:, s], row) if row.size else 0.0
    reach = drawn.radius[None, :] - inward - drawn.ball_radius[:, None]
    return seats(at, C, reach, drawn.centre)


def forces(place: Seats, shift: Array) -> tuple[Array, Array, Array]:
    """Contact forces (N, 4) [N], normals (N, 4, 2), lengths (N, 4) [m] after shifts (N, 3): ball x3, z3, screw along z."""
    move = np.repeat(shift[:, None, :2], 4, axis=1)
    move[:, ON_SCREW] -= shift[:, None, 2:] * place.axis[[0, 2]]
    away = place.away + move
    length = np.hypot(away[..., 0], away[..., 1])
    depth = np.maximum(length - place.reach, 0.0) / place.C
    return depth**1.5, away / length[..., None], length


def settle_seats(place: Seats, given: Array, start: Array) -> tuple[Array, Array, Array, Array]:
    """Shifts (N, 3) [m] at which contacts balance given forces (N, 3) [N] on balls (x3, z3) and screw (z), by Newton.

    Each ball is the minimum of a convex energy. start (N, 3): shifts to begin from. Returns shifts, forces (N, 4),
    normals (N, 4, 2), and the largest force out of balance of each ball (N,) [N].
    """
    x, along = start.copy(), place.axis[[0, 2]]
    force, normal, length = forces(place, x)
    left = _left(force, normal, along, given)
    for _ in range(STEPS):
        size = force.sum(axis=1) + np.abs(given).sum(axis=1)
        open_ = np.abs(left).max(axis=1) > GOAL * size
        if not open_.any():
            break
        step = -np.linalg.solve(_stiffness(place, force, normal, length), left[..., None])[..., 0]
        most = np.abs(step).max(axis=1)
        scale = np.where(open_, np.minimum(1.0, FAR * place.reach.min(axis=1) / np.maximum(most, 1e-300)), 0.0)
        worst, energy = np.abs(left).max(axis=1), _energy(place, force, given, x)
        slope = np.einsum("ni,ni->n", left, step)
        for _ in range(40):
            trial = x + scale[:, None] * step
            new = forces(place, trial)
            off = np.abs(_left(new[0], new[1], along, given)).max(axis=1)
            falls = _energy(place, new[0], given, trial) <= energy + 1e-4 * scale * slope
            good = (scale == 0.0) | falls | (off < 0.5 * worst)
            if good.all():
                break
            scale = np.where(good, scale, 0.5 * scale)
        x = x + np.where(good, scale, 0.0)[:, None] * step
        force, normal, length = forces(place, x)
        left = _left(force, normal, along, given)
        if not (good & open_).any():
            break
    return x, force, normal, np.abs(left).max(axis=1)


def _energy(place: Seats, force: Array, given: Array, x: Array) -> Array:
    """Elastic energy less the work of the given forces, (N,) [J]."""
    return np.asarray((0.4 * place.C * force ** (5.0 / 3.0)).sum(axis=1) - np.einsum("ni,ni->n", given, x))


def _left(force: Array, normal: Array, along: Array, given: Array) -> Array:
    """Derivatives of the energy (N, 3) [N]."""
    push = force[..., None] * normal
    screw = -np.einsum("nsi,i->n", push[:, ON_SCREW], along)
    return np.column_stack([push.sum(axis=1), screw]) - given


def _stiffness(place: Seats, force: Array, normal: Array, length: Array) -> Array:
    """Second derivatives of the energy (N, 3, 3) [N/m], with a floor for balls that float."""
    k_n, k_t = 1.5 * np.cbrt(force) / place.C, force / length
    each = k_t[..., None, None] * np.eye(2) + (k_n - k_t)[..., None, None] * np.einsum("nsi,nsj->nsij", normal, normal)
    rows = np.zeros((4, 2, 3))
    rows[:, :, :2] = np.eye(2)
    rows[ON_SCREW, :, 2] = -place.axis[[0, 2]]
    full = np.einsum("sia,nsij,sjb->nab", rows, each, rows)
    floor = 1e-12 * max(float(k_n.max()), 1.0)
    return np.asarray(full + floor * np.eye(3))


@dataclass(frozen=True)
class FedBack:
    """Contacts and friction that agree, balls whose feedback did not settle (N,), and rounds.

    A ball fails where the contacts and the friction returned leave it, or the axial load that it carried without friction,
    out of balance by more than ``ACCEPTED`` of its contact forces. change: largest such fraction; push (N, 3): forces of
    friction on balls and screw that the contacts balance, see ``settle_seats`` [N].
    """

    at: StaticContacts
    friction: BallFriction
    failed: NDArray[np.bool_]
    rounds: int
    change: float
    push: Array


def feed_back(
    scene: Scene,
    at: StaticContacts,
    place: Seats,
    friction: Friction,
    drive: Drive,
    fast: bool = False,
    near: Array | None = None,
) -> FedBack:
    """Contacts and friction in agreement, ball by ball; begun at the static state, so that of several states it is the one
    that rolls on from there; near (N, 3): forces of friction of a similar state (``FedBack.push``) to begin with instead.

    Failure is data: see ``FedBack.failed``.
    """
    count = at.force.shape[0]
    along, loaded = place.axis[[0, 2]], at.force.sum(axis=1) > 0.0
    still = _left(at.force, at.normals[..., [0, 2]], along, np.zeros((count, 3)))
    guess, shift, mixers = np.zeros((count, 3)), np.zeros((count, 3)), [Mixer(2, 40) for _ in range(count)]
    now, active, rounds = at, np.flatnonzero(loaded), 0
    if near is not None and active.size:
        guess[active] = near[active]
        now, shift[active], _ = _seated(at, place, active, still[active] + guess[active], shift[active], at)
    failed = np.zeros(count, dtype=bool)
    while active.size and rounds < ROUNDS:
        rounds += 1
        some = now.part(active)
        found = ball_friction(scene, some, friction, drive, fast)
        answer = _answer(found, some, place.axis)
        more = (np.abs(answer - guess[active]).max(axis=1) > AGREED * some.force.sum(axis=1)) | failed[active]
        for k in np.flatnonzero(more):
            guess[active[k]] = mixers[active[k]].next(guess[active[k]], answer[k])
        active = active[more]
        now, shift[active], failed[active] = _seated(now, place, active, still[active] + guess[active], shift[active], at)
    final = ball_friction(scene, now, friction, drive, fast)
    off = _left(now.force, now.normals[..., [0, 2]], along, still + _answer(final, now, place.axis))
    change = np.abs(off).max(axis=1) / np.maximum(now.force.sum(axis=1), 1e-300)
    return FedBack(now, final, failed | (change > ACCEPTED), rounds, float(change.max(initial=0.0)), guess)


def _answer(found: BallFriction, at: StaticContacts, axis: Array) -> Array:
    """Friction on balls along x3, z3 and on the screw along its axis (3,), (N, 3) [N]."""
    wrench = found.wrench(at.normals)[..., :3]
    drag = -np.einsum("nsi,i->n", wrench[:, ON_SCREW], axis)
    return np.column_stack([wrench[:, :, [0, 2]].sum(axis=1), drag])


def second_states(
    scene: Scene, place: Seats, at: StaticContacts, found: FedBack, friction: Friction, drive: Drive, fast: bool = False
) -> tuple[int, ...]:
    """Balls that settle in another state, jammed between their grooves, from one of four displaced starts.

    Starts push the balls with ``DISPLACED`` times their largest contact force along x3 and z3. A search: that it finds
    none is no proof that there is none. ``at``: contacts without friction, ``found``: the state that rolls on from them.
    """
    size, other = found.at.force.max(axis=1), np.zeros(at.force.shape[0], dtype=bool)
    for axis in range(2):
        for sign in (-1.0, 1.0):
            push = np.zeros((size.size, 3))
            push[:, axis] = sign * DISPLACED * size
            again = feed_back(scene, at, place, friction, drive, fast, push)
            apart = np.abs(again.at.force - found.at.force).max(axis=1) > ANOTHER * np.maximum(size, 1e-300)
            other |= apart & ~again.failed & ~found.failed & (size > 0.0)
    return tuple(int(k) for k in np.flatnonzero(other))


def _seated(
    now: StaticContacts, place: Seats, which: NDArray[np.int64], given: Array, start: Array, bare: StaticContacts
) -> tuple[StaticContacts, Array, NDArray[np.bool_]]:
    """Contacts with the balls ``which`` where forces (k, 3) hold them, their shifts (k, 3), and which did not settle."""
    part = Seats(place.away[which], place.reach[which], place.C[which], place.axis)
    x, force, normal, left = settle_seats(part, given, start)
    failed = left > 1e-8 * np.maximum(force.sum(axis=1), bare.force[which].sum(axis=1))
    new_force, angle = now.force.copy(), now.angle.copy()
    new_force[which] = force
    angle[which] = contact_angles(normal)
    return with_loads(now, new_force, angle), x, failed
