"""Motion, friction and losses of every ball of a screw or bearing at the contact loads of a static model.

The motion of each ball is that of least dissipation (``motion``); friction does not change the loads. The sums that
follow from it, torques and efficiencies, are in ``screw_torque``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from lowfi.friction.contact.ellipse import Array, Contacts
from lowfi.friction.contact.motion import Problem, least_dissipation
from lowfi.friction.screw.motion import contact_wrench
from lowfi.friction.screw.path import HelicalMotion
from lowfi.friction.whole.contacts import StaticContacts
from meshes.helix import reduced_lead
from meshes.parts import Friction, Scene
from meshes.parts import Motion as Drive

#: What a contact loses power by: sliding of its centre across the groove, along the path, spin about the normal.
CAUSES = ("sliding_across", "sliding_along", "spin")


@dataclass(frozen=True)
class BallPath(HelicalMotion):
    """A ball of its own radius [m] on the scene's helix; see ``HelicalMotion``."""

    ball_radius: float
    pitch_radius: float
    contact_angle: float
    lead: float
    nut_speed: float
    screw_speed: float


def ball_path(scene: Scene, drive: Drive, ball_radius: float) -> BallPath:
    """Kinematics of a ball of radius [m] in a scene whose screw or nut turns."""
    screw = drive.speed if drive.turns == "screw" else 0.0
    track = scene.track
    lead = 2.0 * np.pi * reduced_lead(track)
    return BallPath(ball_radius, track.pitch_radius, track.contact_angle, lead, drive.speed - screw, screw)


@dataclass(frozen=True)
class BallFriction:
    """Motion and friction of N balls, contacts in the order SL, SR, NL, NR; SI.

    orbit (N,): speed about the axis, of a frame in which the part that does not turn stands; rotation (N, 3): about x3,
    y3, z3, relative to that turning frame; both nan for a ball without load. Of each contact: motion (N, 4, 3) of the
    ball against the groove, sliding of its centre across (x) and along (z) the groove and spin about the normal; force
    (N, 4, 2) and moment (N, 4) of friction on the ball likewise; loss (N, 4, 3) [W] by ``CAUSES``; rest (N, 4): held by
    friction. status: one word per ball, "no load" for one that nothing presses; left: largest force out of balance [N],
    as a fraction of the ball's sum of mu F.
    """

    orbit: Array
    rotation: Array
    motion: Array
    force: Array
    moment: Array
    loss: Array
    rest: NDArray[np.bool_]
    status: tuple[str, ...]
    left: float

    @property
    def converged(self) -> bool:
        """Whether the friction of every ball balances."""
        return "failed" not in self.status

    @property
    def power(self) -> float:
        """Power lost by all contacts [W]."""
        return float(self.loss.sum())

    def wrench(self, normals: Array) -> Array:
        """Friction force and moment on the ball at each contact in x3, y3, z3, (N, 4, 6) [N, N m]."""
        return contact_wrench(normals, self.force, self.moment)


def ball_friction(scene: Scene, at: StaticContacts, friction: Friction, drive: Drive, fast: bool = False) -> BallFriction:
    """Motion of least dissipation and friction of every ball.

    Where all coefficients are zero the motion is the limit for equal ones that vanish. Valid for a helix of any hand and
    number of starts and for a ring (zero lead); groove errors and the bending of the screw enter by loads and contact
    angles, not by the directions of motion. fast: compiled kernels. Raises ValueError at rest.
    """
    if drive.speed == 0.0:
        raise ValueError("friction at rest is not determined: give a speed")
    count = at.force.shape[0]
    mu = np.array([friction.screw, friction.screw, friction.nut, friction.nut])
    top = float(mu.max())
    part = mu / top if top > 0.0 else np.ones(4)  # motion depends on ratios of coefficients alone
    path = cache(lambda radius: ball_path(scene, drive, radius))
    orbit, rotation = np.full(count, np.nan), np.full((count, 3), np.nan)
    motion, force, moment = np.zeros((count, 4, 3)), np.zeros((count, 4, 2)), np.zeros((count, 4))
    rest, status, left = np.zeros((count, 4), dtype=bool), ["no load"] * count, 0.0
    normals = at.normals
    for i in np.flatnonzero(at.force.sum(axis=1) > 0.0):
        maps, drives = path(float(at.ball_radius[i])).maps(normals[i])
        turned = np.flatnonzero(~at.across[i])
        for rows in (maps, drives):
            _quarter(rows, turned)
        contacts = Contacts(at.a[i], at.b[i], at.force[i], part)
        found = least_dissipation(Problem(contacts, maps, drives, np.zeros(4)), None, fast)
        seen, pull = found.motion.copy(), found.friction.force.copy()
        for rows in (seen, pull):
            _quarter(rows, turned, -1.0)
        orbit[i], rotation[i] = found.q[0], found.q[1:]
        motion[i], rest[i], status[i] = seen, found.rest & (at.force[i] > 0.0), found.status
        force[i], moment[i] = top * pull, top * found.friction.moment
        left = max(left, found.imbalance / float(np.sum(contacts.strength)))
    motion[at.force == 0.0] = np.nan
    wrench = np.concatenate([force, moment[..., None]], axis=-1)
    loss = np.where(at.force[..., None] > 0.0, -wrench * np.nan_to_num(motion), 0.0) + 0.0
    return BallFriction(orbit, rotation, motion, force, moment, loss, rest, tuple(status), left)


def _quarter(rows: Array, which: NDArray[np.int64], sign: float = 1.0) -> None:
    """Turn the contact axes x, z of the contacts ``which`` by a quarter about their normals, in place; sign -1: back."""
    rows[which, 0], rows[which, 1] = sign * rows[which, 1], -sign * rows[which, 0]


def closing_speeds(scene: Scene, at: StaticContacts, found: BallFriction, drive: Drive) -> Array:
    """Speed (N,) [m/s] at which a ball nears the next one of its start, at the larger azimuth; nan without one or load.

    A ring's last ball is followed by its first, where the balls fill the turn.
    """
    path = ball_path(scene, drive, scene.balls.radius)
    count, starts = at.force.shape[0], scene.track.starts
    closing = np.full(count, np.nan)
    per_start = count // starts
    for k in range(starts):
        own = np.arange(k * per_start, (k + 1) * per_start)
        order = own[np.argsort(at.layout.azimuth[own], kind="stable")]
        closing[order[:-1]] = path.radius * (found.orbit[order[:-1]] - found.orbit[order[1:]])
        if scene.track.lead == 0.0 and per_start > 1:
            closing[order[-1]] = path.radius * (found.orbit[order[-1]] - found.orbit[order[0]])
    return closing
