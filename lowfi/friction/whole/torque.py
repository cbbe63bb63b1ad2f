"""Torques, axial loads and efficiencies of a ball screw, and the torque of a bearing, from the friction of its balls.

Virtual work, with Omega the angular speed of the screw against the nut, r = lead/(2 pi) (negative: left-hand) the
advance per angle, T and F the torque and the axial load on the screw along +z, P the power lost: the balls roll along the
helix, so that any state in balance obeys

    T Omega + F r Omega = P                                                                                            (1)

exactly, P taken at the true loads. Friction changes the contact loads by parts of the order of mu: with P at the loads
without friction T = P/Omega - r F has an error of second order in mu, small in preloaded four-point contact, large in
two-point contact; ``ball_feedback`` takes P at loads with friction.

Also here: whether a scene's friction feeds back, and whether kernels are compiled for so many balls.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from rollbench.lowfi.friction.screw.groove import ON_SCREW
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import reduced_lead
from rollbench.meshes.parts import Friction, Motion, Scene

if TYPE_CHECKING:
    from rollbench.lowfi.friction.whole.contacts import StaticContacts
    from rollbench.lowfi.friction.whole.losses import BallFriction


#: Axial load over the sum of contact loads below which it is round-off: no efficiency is made of it.
ROUND_OFF = 1e-6


@dataclass(frozen=True)
class ScrewTorque:
    """Sums of the friction of all balls; everything along +z."""

    #: Speed of the screw against the nut [rad/s].
    speed: float
    #: Advance per angle, lead/(2 pi), signed by the hand [m/rad].
    ratio: float
    #: External axial load on the screw that the contacts carry [N].
    load: float
    #: Lost in the contacts [W].
    power: float
    #: Axial force of friction on the screw, which the loads leave out [N].
    pull: float
    #: Work of the drive of the screw, and of the nut, per angle of its helical motion [N m]: moments and forces of all
    #: contacts about the axis, normal forces included.
    helical: tuple[float, float]
    #: Largest friction in the plane of a ball's section over its largest contact load.
    tilt: float
    #: Sum of all contact loads [N].
    carried: float
    #: Lost by the reversed motion [W], another one where friction feeds back on the loads.
    reverse_power: float

    @property
    def friction(self) -> float:
        """Friction torque, the power lost per angle [N m]: it opposes the screw, its opposite the nut."""
        return self.power / abs(self.speed)

    @property
    def on_screw(self) -> float:
        """Torque about +z that drives the screw at this speed (negative: brakes it); the opposite on the nut [N m]."""
        return self.power / self.speed - self.ratio * self.load

    @property
    def input_power(self) -> float:
        """Power that the contacts take from screw and nut [W]: summed from forces and moments in space, not from losses."""
        return self.helical[0] * self.speed

    @property
    def translating(self) -> bool:
        """Whether there is an axial load beyond round-off and a lead to move it."""
        return self.ratio != 0.0 and abs(self.load) > ROUND_OFF * self.carried

    @property
    def ideal(self) -> float:
        """Torque that balances the axial load without friction [N m]."""
        return abs(self.ratio * self.load)

    @property
    def forward(self) -> float:
        """Torque that moves the screw against the axial load [N m]."""
        with_load = self.load * self.ratio * self.speed > 0.0
        return self.ideal + (self.reverse_power if with_load else self.power) / abs(self.speed)

    @property
    def backward(self) -> float:
        """Braking torque of the screw while the axial load drives it [N m]; negative: the screw must be driven."""
        with_load = self.load * self.ratio * self.speed > 0.0
        return self.ideal - (self.power if with_load else self.reverse_power) / abs(self.speed)

    @property
    def efficiency(self) -> tuple[float, float]:
        """Efficiencies forward (work on the load over work of the torque) and backward; nan without axial load.

        Backward it is negative where the screw locks itself.
        """
        if not self.translating:
            return float("nan"), float("nan")
        return self.ideal / self.forward, self.backward / self.ideal

    @property
    def locking(self) -> bool:
        """Whether the axial load cannot drive the screw."""
        return self.translating and self.backward <= 0.0


def sum_friction(
    scene: Scene, at: StaticContacts, by_ball: BallFriction, drive: Motion, coupled: bool = False
) -> ScrewTorque:
    """Return the sums over all contacts of a scene whose screw or nut turns with ``drive``.

    coupled: whether contact loads and friction together carry the axial load, or only the contact loads.
    """
    normals, frames = at.normals, at.frames
    friction = by_ball.wrench(normals)
    total = friction.copy()
    total[..., :3] -= at.force[..., None] * normals
    axial, moment = axial_force_and_moment(at, total)
    ratio = reduced_lead(scene.track)
    speed = drive.speed if drive.turns == "screw" else -drive.speed
    helical = moment + ratio * axial  # on the balls: the drives push with it
    plane = friction[:, :, [0, 2]].sum(axis=1)
    most = at.force.max(axis=1, initial=0.0)
    loaded = most > 0.0
    tilt = np.hypot(plane[loaded, 0], plane[loaded, 1]) / most[loaded]
    pull = -np.einsum("nsi,ni->", friction[:, ON_SCREW, :3], frames[:, :, 2])
    return ScrewTorque(
        speed=speed,
        ratio=ratio,
        load=-at.axial_force - (float(pull) if coupled else 0.0),
        power=by_ball.power,
        pull=float(pull),
        reverse_power=by_ball.power,
        helical=(float(helical[:, ON_SCREW].sum()), float(helical[:, ~ON_SCREW].sum())),
        tilt=float(tilt.max(initial=0.0)),
        carried=float(at.force.sum()),
    )


def axial_force_and_moment(at: StaticContacts, wrench: Array) -> tuple[Array, Array]:
    """Return axial forces [N] and moments about axis [N m], ``(N, 4)`` each, of wrenches ``(N, 4, 6)`` at the contacts."""
    turn = at.frames
    force = np.einsum("nsi,nij->nsj", wrench[..., :3], turn)
    moment = np.einsum("nsi,nij->nsj", wrench[..., 3:], turn)
    arm = np.einsum("nsi,nij->nsj", at.ball_radius[:, None, None] * at.normals, turn) + at.layout.centre[:, None]
    return force[..., 2], moment[..., 2] + arm[..., 0] * force[..., 1] - arm[..., 1] * force[..., 0]


#: Motion where the scene gives none: the screw turns once a second.
ONE_TURN = Motion(2.0 * pi)

#: Balls from which compiling the kernels (20 s, once) pays for a single solve, without feedback and with it.
COMPILE_ABOVE, COUPLED_ABOVE = 1000, 8


def feeds_back(scene: Scene, friction: Friction) -> bool:
    """Return whether friction displaces balls in their grooves: it is requested, and there is friction and a lead."""
    return friction.feedback and scene.track.lead != 0.0 and max(friction.screw, friction.nut) > 0.0


def will_compile(scene: Scene, friction: Friction) -> bool:
    """Return whether so many balls are solved that kernels are compiled, unless machine code is on disk (``cached``).

    Parameters
    ----------
    scene
        Screw or bearing.
    friction
        Coefficients of friction.
    """
    often = feeds_back(scene, friction) or friction.neighbours
    return scene.ball_count > (COUPLED_ABOVE if often else COMPILE_ABOVE)
