"""Friction of a whole screw or bearing at the loads of a static model: one call from scene to sums."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from rollbench.lowfi.friction.whole.circuit import balls_of, chain_motion
from rollbench.lowfi.friction.whole.contacts import StaticContacts, contacts_of_result, spread_to_all_balls
from rollbench.lowfi.friction.whole.feedback import JAMMED, feed_back, seats_of, second_states
from rollbench.lowfi.friction.whole.losses import BallFriction, ball_friction, closing_speeds, from_motions
from rollbench.lowfi.friction.whole.torque import ScrewTorque, feeds_back, sum_up, will_compile
from rollbench.lowfi.jit import CONTACT, is_copy_loaded, is_machine_code_cached, register_compile_job
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: Balls up to which nobody waits for the kernels to be compiled: interpreted ones take some 0.05 s a ball and state, and
#: a whole answer, with its drag and the band of coefficients, has up to seven.
UNCOMPILED = 120
#: Gap [m] up to which neighbours count as touching.
TOUCHING = 1e-6


@dataclass(frozen=True)
class Neighbours:
    """Friction of N balls, in the order of the scene, with neighbours that touch."""

    #: Motion and friction of the balls.
    balls: BallFriction
    #: Force of a ball on the next one at the larger azimuth ``(N,)`` [N].
    force: Array
    #: Lost between balls [W].
    power: float
    #: Number of pairs that touch.
    touching: int
    #: Smallest gap of all neighbours on the loaded arcs [rad]; inf without any.
    least: float


def neighbours(
    scene: Scene, at: StaticContacts, friction: Friction, drive: Drive, member: int = 0, fast: bool = False
) -> Neighbours:
    """Return the motions of all balls at loads that do not change, where those within ``TOUCHING`` of each other push.

    Balls in the return touch none.

    Raises
    ------
    CircuitError
        Impossible circuits.
    ValueError
        Balls that overlap.
    """
    track, drawn = scene.track, draw(scene, member)
    all_balls = balls_of(scene, friction, drive, drawn, member)
    on_arc = np.flatnonzero(all_balls.number >= 0)
    order = all_balls.number[on_arc]
    layout = all_balls.layout(scene, all_balls.azimuth)
    full = spread_to_all_balls(at.subset(order), layout, on_arc, all_balls.radius, track.contact_angle)
    gap = all_balls.gaps(all_balls.azimuth) * all_balls.grooves.pair.closing
    slack = np.where(gap <= TOUCHING, 0.0, np.inf)
    least = np.inf
    q, force, status = np.full((order.size, 4), np.nan), np.zeros(order.size), ["no load"] * order.size
    motion, pull = np.zeros((order.size, 4, 3)), np.zeros((order.size, 4, 3))
    power, touching, left = 0.0, 0, 0.0
    for members in (track.balls for track in all_balls.tracks):
        number = all_balls.number[members]
        free = (number < 0) | (np.roll(number, -1) < 0)
        if track.lead != 0.0:
            free[-1] = True  # the return lies between the last ball and the first
        limit = np.where(free, np.inf, slack[members])
        least = min(least, float(np.min(np.where(free, np.inf, gap[members]))))
        touching += int(np.sum(limit == 0.0))
        moved = chain_motion(scene, full.subset(members), limit, friction, drive, all_balls.grooves, None, fast)
        kept, to = number >= 0, number[number >= 0]
        pressed = at.force[to].sum(axis=1) > 0.0
        q[to] = np.where(pressed[:, None], moved.q[kept], np.nan)
        motion[to], pull[to], force[to] = moved.seen[kept], moved.pull[kept], moved.ball_force[kept]
        power += float(moved.ball_loss.sum() + moved.closing_loss.sum())
        left = max(left, moved.left)
        for k in to[pressed]:
            status[k] = "balanced" if moved.converged else "failed"
    rest = np.zeros(at.force.shape, dtype=bool)
    scale = max(max(friction.screw, friction.nut) * float(at.force.sum(axis=1).max(initial=0.0)), 1e-30)
    by_ball = from_motions(at, q, motion, pull, rest, status, left / scale)
    return Neighbours(by_ball, force, power, touching, least)


@dataclass(frozen=True)
class FrictionState:
    """Friction of a scene at one pair of coefficients."""

    #: The contacts.
    at: StaticContacts
    #: Motion and friction of every ball.
    balls: BallFriction
    #: Sums over all balls.
    torque: ScrewTorque
    #: Speeds at which neighbours approach ``(N,)`` [m/s].
    closing: Array
    #: The sums at the static loads, without feedback.
    bare: ScrewTorque
    #: Indices of balls whose feedback did not settle, in one direction of motion or the other.
    unsettled: tuple[int, ...]
    #: Difference of friction and what of it is fed back, see ``FedBack``.
    change: float
    #: Whether friction feeds back.
    coupled: bool
    #: Forces and losses between touching balls; None if not requested.
    neighbours: Neighbours | None = None
    #: Indices of balls for which a second, jammed state was found; None where none was looked for.
    second: tuple[int, ...] | None = None

    @property
    def settled(self) -> bool:
        """Whether friction balances on every ball, and agrees with its position."""
        return self.balls.converged and not self.unsettled

    @property
    def loaded(self) -> bool:
        """Whether any contact carries load."""
        return bool(np.any(self.at.force > 0.0))


def friction_state(
    scene: Scene, result: StaticResult, friction: Friction, drive: Drive, member: int = 0, *, fast: bool | None = None
) -> FrictionState:
    """Return the friction of a solved scene.

    Fed back on the positions of the balls, and with neighbours that push each other, where ``friction`` asks for it; with
    both, neighbours push at the loads that each ball's own friction leaves, as in a run in time. Friction of a ring runs
    along its groove and moves no ball.

    Parameters
    ----------
    scene, result
        The scene and its static result.
    friction, drive
        Coefficients, and the motion of screw or nut.
    member
        Number of the specimen that ``result`` was solved for.
    fast
        Whether to use compiled kernels; by default where they pay. A few balls do not wait for kernels to be compiled:
        `lowfi.jit.compile_afterwards` does that.

    Raises
    ------
    CircuitError
        Impossible circuits of a scene with neighbours.
    ValueError
        A result that did not converge, no motion, or balls that overlap.
    """
    at = contacts_of_result(scene, result, member)
    coupled = feeds_back(scene, friction)
    pushed = friction.neighbours
    first = (
        fast is None
        and not is_machine_code_cached(CONTACT)
        and not is_copy_loaded(CONTACT)
        and not pushed
        and scene.ball_count <= UNCOMPILED
    )
    if first and will_compile(scene, friction):
        register_compile_job(CONTACT, partial(friction_state, scene, result, friction, drive, member, fast=True))
    if fast is None:
        fast = not first and (
            will_compile(scene, friction) or is_copy_loaded(CONTACT) or (coupled and is_machine_code_cached(CONTACT))
        )
    balls = ball_friction(scene, at, friction, drive, fast)
    torque = bare = sum_up(scene, at, balls, drive)
    unsettled: tuple[int, ...] = ()
    second: tuple[int, ...] | None
    change, second, at_back = 0.0, None, at
    if coupled:
        place = seats_of(scene, result, at, member)
        there, back = (feed_back(scene, at, place, friction, d, fast) for d in (drive, reverse(drive)))
        still, at, at_back, balls = at, there.at, back.at, there.friction
        torque = replace(sum_up(scene, at, balls, drive, coupled=True), reverse_power=back.friction.power)
        change = max(there.change, back.change)
        unsettled = tuple(int(k) for k in np.flatnonzero(there.failed | back.failed))
        if max(friction.screw, friction.nut) >= JAMMED:
            second = second_states(scene, place, still, there, friction, drive, fast)
    touching: Neighbours | None = None
    if pushed:
        ways = ((at, drive), (at_back, reverse(drive)))
        touching, back_again = (neighbours(scene, contacts, friction, d, member, fast) for contacts, d in ways)
        balls = touching.balls
        sums = sum_up(scene, at, balls, drive, coupled=coupled)
        torque = replace(sums, power=sums.power + touching.power, reverse_power=back_again.balls.power + back_again.power)
    closing = closing_speeds(scene, at, balls, drive)
    return FrictionState(at, balls, torque, closing, bare, unsettled, change, coupled, touching, second)


def reverse(drive: Drive) -> Drive:
    """Return the motion backwards."""
    return replace(drive, speed=-drive.speed)
