"""Friction of a whole screw or bearing at the loads that a static model gives: one call from scene to sums."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from rollbench.lowfi.friction.whole.contacts import StaticContacts, contacts_of
from rollbench.lowfi.friction.whole.feedback import JAMMED, feed_back, seats_of, second_states
from rollbench.lowfi.friction.whole.losses import BallFriction, ball_friction, closing_speeds
from rollbench.lowfi.friction.whole.neighbours import Neighbours, neighbours
from rollbench.lowfi.friction.whole.settings import feeds_back, will_compile
from rollbench.lowfi.friction.whole.torque import ScrewTorque, sum_up
from rollbench.lowfi.jit import CONTACT, afterwards, cached, loaded
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: Balls up to which nobody waits for the kernels to be compiled: interpreted ones take some 0.1 s a ball.
UNCOMPILED = 50


@dataclass(frozen=True)
class FrictionState:
    """Contacts, friction of every ball, sums, and closing speeds (N,) [m/s] of a scene at one pair of coefficients.

    bare: the sums at the static loads, without feedback; unsettled: indices of balls whose feedback did not settle, in one
    direction of motion or the other; change: difference of friction and what of it is fed back, see ``FedBack``;
    coupled: whether friction feeds back; neighbours: what balls that touch do to each other, where asked;
    second: indices of balls for which a second, jammed state was found, None where none was looked for.
    """

    at: StaticContacts
    balls: BallFriction
    torque: ScrewTorque
    closing: Array
    bare: ScrewTorque
    unsettled: tuple[int, ...]
    change: float
    coupled: bool
    neighbours: Neighbours | None = None
    second: tuple[int, ...] | None = None

    @property
    def loaded(self) -> bool:
        """Whether any contact carries load."""
        return bool(np.any(self.at.force > 0.0))


def friction_state(
    scene: Scene, result: StaticResult, friction: Friction, drive: Drive, member: int = 0, *, fast: bool | None = None
) -> FrictionState:
    """Friction of a solved scene, fed back on the places of the balls and with neighbours that push each other where
    ``friction`` says so. Both: neighbours push at the loads that each ball's own friction leaves, as in a run in time.

    Friction of a ring runs along its groove and moves no ball. Arguments as for ``contacts_of`` and ``ball_friction``,
    which say what they refuse. fast: compiled kernels; unless given where they pay, but few balls do not wait for them to
    be compiled: `lowfi.jit.compile_afterwards` does that.
    """
    at = contacts_of(scene, result, member)
    coupled = feeds_back(scene, friction)
    pushed = friction.neighbours
    first = fast is None and not cached(CONTACT) and not loaded(CONTACT) and not pushed and scene.ball_count <= UNCOMPILED
    if first and will_compile(scene, friction):
        afterwards(CONTACT, partial(friction_state, scene, result, friction, drive, member, fast=True))
    if fast is None:
        fast = not first and (will_compile(scene, friction) or loaded(CONTACT) or (coupled and cached(CONTACT)))
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
    """The motion backwards."""
    return replace(drive, speed=-drive.speed)
