"""Motion, friction and losses of every ball of a screw or bearing at the contact loads of a static model.

The motion of each ball is that of least dissipation (``lowfi.friction.screw.motion``); friction does not change the loads.
The torques and efficiencies that follow from the losses are in ``lowfi.friction.whole.torque``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from rollbench.lowfi.friction.contact.equilibrium import STATUS
from rollbench.lowfi.friction.contact.least_dissipation import (
    FrictionalBodies,
    LeastDissipation,
    least_dissipation_of_bodies,
)
from rollbench.lowfi.friction.screw.groove import GroovesInMotion
from rollbench.lowfi.friction.screw.motion import friction_wrench_at_contacts
from rollbench.lowfi.friction.whole.contacts import StaticContacts
from rollbench.meshes.arrays import Array, Index, Mask
from rollbench.meshes.helix import lead_per_radian
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: Causes of the losses of a contact: sliding of its centre across the groove, sliding of its centre along the path, spin
#: about the normal.
CAUSES = ("sliding_across", "sliding_along", "spin")


@dataclass(frozen=True)
class BallKinematics(GroovesInMotion):
    """Radii, contact angle, lead and speeds of screw and nut that determine the motion of a ball; lead 0 for a bearing."""

    #: Radius of the ball [m].
    ball_radius: float
    #: Radius of the helix of ball centres [m].
    pitch_radius: float
    #: Nominal contact angle [rad].
    contact_angle: float
    #: Advance per turn [m], negative for a left-hand thread.
    lead: float
    #: Angular speed of the nut [rad/s].
    nut_speed: float
    #: Angular speed of the screw [rad/s].
    screw_speed: float


@lru_cache(maxsize=64)
def ball_kinematics(scene: Scene, drive: Drive, ball_radius: float) -> BallKinematics:
    """Return the helix, contact angle and body speeds that determine the motion of a ball; results are cached.

    ``scene``: screw or bearing; ``drive``: which part turns, screw or nut, and its angular speed; ``ball_radius``: radius
    of the ball [m].
    """
    screw = drive.speed if drive.turns == "screw" else 0.0
    track = scene.track
    lead = 2.0 * np.pi * lead_per_radian(track)
    return BallKinematics(ball_radius, track.pitch_radius, track.contact_angle, lead, drive.speed - screw, screw)


@dataclass(frozen=True)
class BallFriction:
    """Motion, friction and losses of N balls; four contacts each, in the order SL, SR, NL, NR (screw, nut; left, right)."""

    #: Angular speed of each ball's centre about the screw's axis, relative to the part (screw or nut) that does not rotate
    #: ``(N,)`` [rad/s]; nan for a ball without load.
    orbital_speed: Array
    #: Angular speeds of each ball about x3, y3, z3, relative to these axes, which go round with the ball ``(N, 3)``
    #: [rad/s]; nan for a ball without load.
    rotation: Array
    #: Motion of the ball relative to the groove at each contact: sliding of the contact's centre across (x) and along (z)
    #: the groove [m/s], and spin about the normal [rad/s] ``(N, 4, 3)``.
    contact_motions: Array
    #: Force of friction on the ball at each contact, across (x) and along (z) the groove ``(N, 4, 2)`` [N].
    force: Array
    #: Moment of friction on the ball about the normal of each contact ``(N, 4)`` [N m].
    moment: Array
    #: Power lost in each contact by sliding across the groove, by sliding along it, by spin and, in curved contacts, by
    #: the slip of their curvature ``(N, 4, 3)`` or ``(N, 4, 4)`` [W].
    loss: Array
    #: Whether each contact sticks ``(N, 4)``.
    sticking_contacts: Mask
    #: Status of the solution for each ball, such as ``"exact"`` or ``"failed"``; ``"no load"`` for a ball without contact
    #: forces.
    status: tuple[str, ...]
    #: Largest ratio, over all balls, of the unbalanced force on a ball to the sum of its friction bounds mu F (coefficient
    #: of friction times contact force).
    largest_imbalance_ratio: float

    @property
    def converged(self) -> bool:
        """Whether the friction forces on every ball are in balance."""
        return "failed" not in self.status

    @property
    def ball_motions(self) -> Array:
        """Motions of the balls ``(N, 4)`` [rad/s]: orbital speed, then the three rotations."""
        return np.column_stack([self.orbital_speed, self.rotation])

    @property
    def total_power_lost(self) -> float:
        """Power lost by friction in all contacts of all balls [W]."""
        return float(self.loss.sum())

    def contact_wrenches(self, normals: Array) -> Array:
        """Return force, then moment of friction on each ball at its contacts, along x3, y3, z3 each ``(N, 4, 6)`` [N, N m].

        x3 is radial, y3 along the track, z3 the binormal. ``normals``: unit vectors from each ball's centre to its
        contacts in these axes ``(N, 4, 3)``.
        """
        return friction_wrench_at_contacts(normals, self.force, self.moment)


class BallsUnderLoad(NamedTuple):
    """Balls at given contact loads, with what their motion and friction depend on."""

    #: Screw or bearing.
    scene: Scene
    #: Contacts of its N balls.
    contacts: StaticContacts
    #: Coefficients of friction.
    friction: Friction
    #: Which part turns, screw or nut, and its angular speed.
    drive: Drive


def ball_friction(balls: BallsUnderLoad, start: Array | None = None) -> BallFriction:
    """Return the motion of least dissipation and the friction of every ball; see `friction_of_groups`.

    ``start``: first estimates of the motions ``(N, 4)`` [rad/s], nan for balls without one; None if there are none.
    """
    return friction_of_groups([balls], [start])[0]


def friction_of_groups(groups: Sequence[BallsUnderLoad], starts: Sequence[Array | None] = ()) -> list[BallFriction]:
    """Return the motion of least dissipation and the friction of every ball of several groups at given contact loads.

    If all coefficients of friction are zero, the motion is the limit of motions with equal coefficients that tend to
    zero. The function is valid for a helix of any hand and number of starts and for a ring (zero lead). Groove errors
    and the bending of the screw influence the loads and contact angles, but not the directions in which screw and nut
    move. Balls in equal states are solved once.

    Parameters
    ----------
    groups
        The groups of balls.
    starts
        For each group first estimates of the motions ``(N, 4)`` [rad/s], from a similar state
        (``BallFriction.ball_motions``), nan for balls without an estimate; None if there are no estimates.

    Raises
    ------
    ValueError
        The speed of screw and nut is zero.
    """
    if any(balls.drive.speed == 0.0 for balls in groups):
        raise ValueError("screw or nut must turn: the speed is zero, and friction at rest is not determined")
    loaded = [np.flatnonzero(balls.contacts.force.sum(axis=1) > 0.0) for balls in groups]
    pressed = [balls.contacts.subset(which) for balls, which in zip(groups, loaded, strict=True)]
    bodies, begin = [], []
    for k, (balls, which) in enumerate(zip(groups, loaded, strict=True)):
        share, _ = relative_friction_coefficients(balls.friction)
        bodies.append(friction_contacts(balls.scene, pressed[k], share, balls.drive))
        start = starts[k] if starts else None
        begin.append(np.full((which.size, 4), np.nan) if start is None else start[which])
    found = _motions_of_distinct_bodies(bodies, begin)
    return [_friction_in_groove_axes(*of_group) for of_group in zip(groups, loaded, pressed, bodies, found, strict=True)]


#: Largest number of bodies that are solved at the same time; it limits the memory.
BLOCK = 4096


def _motions_of_distinct_bodies(groups: Sequence[FrictionalBodies], starts: Sequence[Array]) -> list[LeastDissipation]:
    """Return the motions of least dissipation of the balls of each group; equal balls with equal starts are solved once."""
    bodies = FrictionalBodies(*map(np.concatenate, zip(*groups, strict=True)))
    start, count = np.concatenate(starts), len(bodies.a)
    rows = np.concatenate([values.reshape(count, math.prod(values.shape[1:])) for values in (*bodies, start)], axis=1)
    first: dict[bytes, int] = {}
    known = np.array([first.setdefault(row.tobytes(), k) for k, row in enumerate(rows)], dtype=int)
    distinct, place = np.unique(known, return_inverse=True)
    blocks = np.split(distinct, range(BLOCK, distinct.size, BLOCK))
    solved = [least_dissipation_of_bodies(bodies.take(block), start[block], near=True) for block in blocks]
    parts = np.split(place, np.cumsum([len(group.a) for group in groups])[:-1])
    whole = [np.concatenate(values) for values in zip(*solved, strict=True)]
    return [LeastDissipation(*(values[part] for values in whole)) for part in parts]


def _friction_in_groove_axes(
    balls: BallsUnderLoad, loaded: Index, pressed: StaticContacts, bodies: FrictionalBodies, found: LeastDissipation
) -> BallFriction:
    """Return motion and friction of all N balls of a group from the motions of its n loaded ones.

    ``loaded``: their numbers ``(n,)``; ``pressed``: their contacts; ``bodies``, ``found``: problem and solution.
    """
    _, top = relative_friction_coefficients(balls.friction)
    seen, forces = bodies.contact_motions(found.q), found.forces.copy()
    seen[found.rest] = 0.0
    rotate_to_groove_axes(pressed, seen)
    rotate_to_groove_axes(pressed, forces)
    rest = found.rest & (pressed.force > 0.0)
    status = [STATUS[k] if good else "failed" for k, good in zip(found.status, found.balanced(bodies), strict=True)]
    left = float((found.imbalance / bodies.bound.sum(axis=1)).max(initial=0.0))
    return ball_friction_from_motions(balls.contacts, loaded, (found.q, seen, -top * forces, rest), status, left)


def ball_friction_from_motions(
    contacts: StaticContacts, balls: Index, moved: Sequence[Array | Mask], status: Sequence[str], imbalance: float
) -> BallFriction:
    """Return motion, friction and losses of N balls as one record; the losses are friction times motion.

    ``contacts``: contacts of all balls; ``balls``: numbers of the n balls whose motion is known ``(n,)``; ``moved``: their
    motions ``(n, 4)`` [rad/s], orbit and then rotation; sliding of their contacts across and along the groove [m/s], and
    spin about the normal [rad/s], ``(n, 4, 3)``; friction on the ball, force across and along the groove [N], and moment
    about the normal [N m], ``(n, 4, 3)``; whether each contact sticks ``(n, 4)``, False if left out; ``status``: status of
    the solution for each of these balls; ``imbalance``: largest unbalanced force on a ball, as a fraction of the sum of
    friction bounds (coefficient of friction times contact force) of this ball.
    """
    count, words = len(contacts.force), np.full(len(contacts.force), "no load", dtype=object)
    motions, motion, pull = np.full((count, 4), np.nan), np.zeros((count, 4, 3)), np.zeros((count, 4, 3))
    rest, words[balls] = np.zeros((count, 4), dtype=bool), status
    for whole, part in zip((motions, motion, pull, rest), moved, strict=False):
        whole[balls] = part
    loaded = contacts.force[..., None] > 0.0
    loss = np.where(loaded, -pull * np.nan_to_num(motion), 0.0) + 0.0
    seen = np.where(loaded, motion, np.nan)
    return BallFriction(
        motions[:, 0], motions[:, 1:], seen, pull[..., :2], pull[..., 2], loss, rest, tuple(words), imbalance
    )


def relative_friction_coefficients(friction: Friction) -> tuple[Array, float]:
    """Return the ratios of the contacts' coefficients of friction to the largest one ``(4,)``, then the largest one.

    The ratios are in the order screw left, screw right, nut left, nut right. The ratios are 1 if all coefficients are zero:
    the motions depend only on the ratios, so that motions without friction are the limit for equal coefficients that tend
    to zero. ``friction``: coefficients of friction of screw and nut.
    """
    mu = np.array([friction.screw, friction.screw, friction.nut, friction.nut])
    top = float(mu.max())
    return (mu / top if top > 0.0 else np.ones(4)), top


def friction_contacts(
    scene: Scene, contacts: StaticContacts, friction_coefficients: Array, drive: Drive
) -> FrictionalBodies:
    """Return ellipses, friction bounds and kinematics of all contacts, with x along the long semi-axis of each ellipse.

    ``contacts``: contact forces and ellipses; ``friction_coefficients``: coefficients of friction of the contacts with the
    four flanks (screw left, screw right, nut left, nut right) ``(4,)``, or their ratios to the largest one; the friction
    bounds in the result are the products of these values and the forces. ``drive``: which part turns, screw or nut, and its
    angular speed.
    """
    path = ball_kinematics(scene, drive, scene.balls.radius)
    maps, drives = path.contact_kinematics(contacts.normals, contacts.ball_radius)
    for rows in (maps, drives):
        rows[~contacts.across] = _rotate_quarter_turn(rows[~contacts.across])
    bound, none = friction_coefficients * contacts.force, np.zeros((len(maps), 4))
    return FrictionalBodies(contacts.a, contacts.b, bound, maps, drives, none)


def rotate_to_groove_axes(at: StaticContacts, values: Array) -> None:
    """Rotate components from axes x, z along the semi-axes of each contact ellipse to axes x across the groove, z along it.

    On input, x lies along the long semi-axis of each ellipse, as in `friction_contacts`. ``at``: contacts of the N balls;
    ``values`` ``(N, 4, 3)``: components along x and z and about the normal for each contact, which are overwritten.
    """
    values[~at.across] = _rotate_quarter_turn(values[~at.across], -1.0)


def _rotate_quarter_turn(components: Array, sign: float = 1.0) -> Array:
    """Return the components of k contacts after their axes x, z have turned by 90 degrees about the contact normal.

    ``components`` ``(k, 3, ...)``: components along x and z and about the normal; ``sign``: 1 or, for the opposite sense,
    -1.
    """
    return np.stack([sign * components[:, 1], -sign * components[:, 0], components[:, 2]], axis=1)


def closing_speeds_of_neighbours(scene: Scene, contacts: StaticContacts, by_ball: BallFriction, drive: Drive) -> Array:
    """Return the speed at which each ball approaches the next one of the same thread start ``(N,)`` [m/s].

    The speed is negative if the balls separate. The next ball is the neighbour at the larger azimuth; in a ring, the last
    ball is followed by the first. The speed is nan for a ball without a next one, and where one of the two balls has no
    load. ``contacts``: contacts of the N balls; ``by_ball``: their motions; ``drive``: which part turns, screw or nut, and
    its angular speed.
    """
    path = ball_kinematics(scene, drive, scene.balls.radius)
    azimuth, speed = (values.reshape(scene.track.starts, -1) for values in (contacts.layout.azimuth, by_ball.orbital_speed))
    order = np.argsort(azimuth, axis=1, kind="stable")
    speed = np.take_along_axis(speed, order, axis=1)
    rate, closing = path.radius * (speed - np.roll(speed, -1, axis=1)), np.empty_like(speed)
    if scene.track.lead != 0.0 or order.shape[1] == 1:
        rate[:, -1] = np.nan
    np.put_along_axis(closing, order, rate, axis=1)
    return closing.ravel()
