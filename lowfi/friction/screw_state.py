"""Friction of a whole screw or bearing at the loads that a static model gives: one call from scene to sums."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lowfi.result import StaticResult
from meshes.parts import Friction, Scene
from meshes.parts import Motion as Drive

from .ellipse import Array
from .screw_losses import BallFriction, ball_friction, closing_speeds
from .screw_torque import ScrewTorque, sum_up
from .static_contacts import StaticContacts, contacts_of

#: Balls from which compiling the kernels pays for a single solve.
COMPILE_ABOVE = 1000


@dataclass(frozen=True)
class FrictionState:
    """Contacts, friction of every ball, sums, and closing speeds (N,) [m/s] of a scene at one pair of coefficients."""

    at: StaticContacts
    balls: BallFriction
    torque: ScrewTorque
    closing: Array

    @property
    def loaded(self) -> bool:
        """Whether any contact carries load."""
        return bool(np.any(self.at.force > 0.0))


def friction_state(
    scene: Scene, result: StaticResult, friction: Friction, drive: Drive, member: int = 0
) -> FrictionState:
    """Friction of a solved scene; arguments as for ``contacts_of`` and ``ball_friction``, which say what they refuse."""
    at = contacts_of(scene, result, member)
    balls = ball_friction(scene, at, friction, drive, fast=scene.ball_count > COMPILE_ABOVE)
    return FrictionState(at, balls, sum_up(scene, at, balls, drive), closing_speeds(scene, at, balls, drive))
