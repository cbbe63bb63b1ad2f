"""Torques, axial loads and efficiencies of a ball screw, and the torque of a bearing, from the friction of its balls.

Virtual work gives the torque, with Omega the angular speed of the screw against the nut, r = lead/(2 pi) (negative:
left-hand) the advance per angle, T and F the torque and the axial load on the screw along +z, P the power lost: the balls
roll along the helix, so that any state in balance obeys

    T Omega + F r Omega = P                                                                                            (1)

exactly, with P at the true loads. Friction changes the contact loads by a fraction of the order of mu. With P at the loads
without friction, T = P/Omega - r F therefore has an error of second order in mu, which is small in preloaded four-point
contact and large in two-point contact. With feedback (``lowfi.friction.whole.feedback``) P is taken at the loads with
friction.

`friction_displaces_balls` returns whether the friction of a scene displaces its balls.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from rollbench.lowfi.friction.screw.groove import ON_SCREW
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import lead_per_radian
from rollbench.meshes.parts import Friction, Motion, Scene

if TYPE_CHECKING:
    from rollbench.lowfi.friction.whole.contacts import StaticContacts
    from rollbench.lowfi.friction.whole.losses import BallFriction


#: Ratio of axial load to the sum of contact loads below which the axial load counts as round-off, so that no efficiency is
#: computed.
ROUND_OFF = 1e-6


@dataclass(frozen=True)
class FrictionSums:
    """Torque, axial force and power of the friction of a screw or bearing, summed over all balls.

    Forces are positive along +z, torques and angles about +z.
    """

    #: Angular speed of the screw relative to the nut, about +z [rad/s].
    speed: float
    #: Advance per angle, lead/(2 pi) [m/rad], negative for a left-hand thread.
    advance_per_radian: float
    #: External axial load on the screw, in balance with the forces at the contacts [N].
    axial_load: float
    #: Power lost by friction in all contacts [W].
    power: float
    #: Axial force of friction on the screw [N], which the contact loads of the static model do not balance.
    axial_friction_on_screw: float
    #: Work per angle of rotation that the drive of the screw, then the drive of the nut, does in a helical motion [N m]. It
    #: is done against the moments about the axis and the axial forces of both normal forces and friction at all contacts.
    helical_work_per_radian: tuple[float, float]
    #: Largest ratio, over all balls, of the friction on a ball in the plane of its groove section (across the groove) to
    #: the largest contact load of this ball.
    cross_groove_friction_ratio: float
    #: Sum of all contact loads [N].
    contact_load_sum: float
    #: Power lost by friction in the reversed motion [W]; it differs from ``power`` if friction changes the contact loads.
    reverse_power: float

    @property
    def friction_torque(self) -> float:
        """Friction torque on the screw [N m]: power lost divided by the angular speed of the screw relative to the nut.

        The friction torque on the nut has the opposite sign.
        """
        return self.power / abs(self.speed)

    @property
    def driving_torque_on_screw(self) -> float:
        """Torque about +z that keeps the screw at its speed relative to the nut, friction included [N m].

        It brakes the screw if it has the opposite sign to the speed. The torque on the nut is opposite to that on the
        screw.
        """
        return self.power / self.speed - self.advance_per_radian * self.axial_load

    @property
    def input_power(self) -> float:
        """Power that the contacts take from screw and nut [W]: forces and moments on screw and nut times their motions."""
        return self.helical_work_per_radian[0] * self.speed

    @property
    def moves_axial_load(self) -> bool:
        """Whether the rotation moves an axial load: the lead is not zero, and the load is more than round-off."""
        return self.advance_per_radian != 0.0 and abs(self.axial_load) > ROUND_OFF * self.contact_load_sum

    @property
    def frictionless_torque(self) -> float:
        """Torque on the screw that would balance the axial load if there were no friction, as a magnitude [N m]."""
        return abs(self.advance_per_radian * self.axial_load)

    @property
    def forward_torque(self) -> float:
        """Torque that turns the screw against the axial load, friction included [N m]."""
        with_load = self.axial_load * self.advance_per_radian * self.speed > 0.0
        return self.frictionless_torque + (self.reverse_power if with_load else self.power) / abs(self.speed)

    @property
    def backward_torque(self) -> float:
        """Braking torque of the screw while the axial load drives it back [N m]; negative: the screw must be driven."""
        with_load = self.axial_load * self.advance_per_radian * self.speed > 0.0
        return self.frictionless_torque - (self.power if with_load else self.reverse_power) / abs(self.speed)

    @property
    def efficiency(self) -> tuple[float, float]:
        """Efficiencies, first forward (work on the axial load over work of the torque), then backward.

        The backward efficiency is negative if the screw locks itself. Both efficiencies are nan without axial load.
        """
        if not self.moves_axial_load:
            return float("nan"), float("nan")
        return self.frictionless_torque / self.forward_torque, self.backward_torque / self.frictionless_torque

    @property
    def is_self_locking(self) -> bool:
        """Whether friction locks the screw, so that the axial load cannot drive it."""
        return self.moves_axial_load and self.backward_torque <= 0.0


def sum_friction_over_contacts(
    scene: Scene, contacts: StaticContacts, by_ball: BallFriction, drive: Motion, coupled: bool = False
) -> FrictionSums:
    """Return torque, axial force and power of the friction of a scene, as sums over all contacts.

    ``scene``: screw or bearing; ``contacts``: contacts of its balls; ``by_ball``: friction of each ball; ``drive``: which
    part turns, screw or nut, and its angular speed; ``coupled``: whether contact loads and friction together balance the
    axial load (True), or the contact loads alone (False).
    """
    normals, frames = contacts.normals, contacts.section_axes
    friction = by_ball.contact_wrenches(normals)
    total = friction.copy()
    total[..., :3] -= contacts.force[..., None] * normals
    axial, moment = axial_forces_and_moments(contacts, total)
    ratio = lead_per_radian(scene.track)
    speed = drive.speed if drive.turns == "screw" else -drive.speed
    helical = moment + ratio * axial  # on the balls: the drives push with it
    plane = friction[:, :, [0, 2]].sum(axis=1)
    most = contacts.force.max(axis=1, initial=0.0)
    loaded = most > 0.0
    tilt = np.hypot(plane[loaded, 0], plane[loaded, 1]) / most[loaded]
    pull = float(-np.einsum("nsi,ni->", friction[:, ON_SCREW, :3], frames[:, :, 2]))
    return FrictionSums(
        speed=speed,
        advance_per_radian=ratio,
        axial_load=-contacts.axial_force - (pull if coupled else 0.0),
        power=by_ball.total_power_lost,
        axial_friction_on_screw=pull,
        reverse_power=by_ball.total_power_lost,
        helical_work_per_radian=(float(helical[:, ON_SCREW].sum()), float(helical[:, ~ON_SCREW].sum())),
        cross_groove_friction_ratio=float(tilt.max(initial=0.0)),
        contact_load_sum=float(contacts.force.sum()),
    )


def axial_forces_and_moments(contacts: StaticContacts, wrench: Array) -> tuple[Array, Array]:
    """Return axial force [N], then moment about the screw's axis [N m], of the wrench at each contact, ``(N, 4)`` each.

    ``contacts``: contacts of the N balls; ``wrench``: force (first three components) and moment at each contact in the
    axes x3 (radial), y3 (along the track), z3 (binormal) of the ball's section ``(N, 4, 6)`` [N, N m].
    """
    turn = contacts.section_axes
    force = np.einsum("nsi,nij->nsj", wrench[..., :3], turn)
    moment = np.einsum("nsi,nij->nsj", wrench[..., 3:], turn)
    arm = np.einsum("nsi,nij->nsj", contacts.ball_radius[:, None, None] * contacts.normals, turn)
    arm += contacts.layout.centre[:, None]
    return force[..., 2], moment[..., 2] + arm[..., 0] * force[..., 1] - arm[..., 1] * force[..., 0]


#: Motion that is assumed if the scene gives none: the screw turns once a second.
ONE_TURN = Motion(2.0 * pi)


def friction_displaces_balls(scene: Scene, friction: Friction) -> bool:
    """Return whether friction is to displace the balls of a scene in their grooves and so change the contact loads.

    Friction does so if ``friction`` requests this feedback, one of its coefficients is above zero, and the track of
    ``scene`` has a lead.
    """
    return friction.feedback and scene.track.lead != 0.0 and max(friction.screw, friction.nut) > 0.0
