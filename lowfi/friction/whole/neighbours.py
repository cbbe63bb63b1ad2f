"""Balls that touch at one instant: what neighbours do to motions, losses and torque at the static loads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.friction.whole.balls import balls_of
from rollbench.lowfi.friction.whole.chain import chain_motion
from rollbench.lowfi.friction.whole.contacts import StaticContacts, spread
from rollbench.lowfi.friction.whole.losses import BallFriction, from_motions
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: Gap [m] up to which neighbours count as touching.
TOUCHING = 1e-6


@dataclass(frozen=True)
class Neighbours:
    """Friction of N balls, in the order of the scene, with neighbours that touch; SI.

    force (N,): of a ball on the next one at the larger azimuth; power: lost between balls; touching: pairs; least: smallest
    gap of all neighbours on the loaded arcs, inf without any.
    """

    balls: BallFriction
    force: Array
    power: float
    touching: int
    least: float


def neighbours(
    scene: Scene, at: StaticContacts, friction: Friction, drive: Drive, member: int = 0, fast: bool = False
) -> Neighbours:
    """Motions of all balls at loads that do not change, where those within ``TOUCHING`` of each other push.

    Balls in the return touch none. Raises CircuitError for circuits that cannot be, ValueError for balls that overlap.
    """
    track, drawn = scene.track, draw(scene, member)
    all_balls = balls_of(scene, friction, drive, drawn, member)
    on_arc = np.flatnonzero(all_balls.number >= 0)
    order = all_balls.number[on_arc]
    layout = all_balls.layout(scene, all_balls.azimuth)
    full = spread(at.subset(order), layout, on_arc, all_balls.radius, track.contact_angle)
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
