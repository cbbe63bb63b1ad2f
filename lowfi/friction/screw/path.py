"""Kinematics of a ball between two helical bodies: contact axes, directions to the contacts, motion at the contacts.

Axes at the ball's centre (Lin 3.4.1): x3 radially outward, y3 along the helical path, z3 the binormal, about which the
lead angle tilts the screw's axis towards y3. Contacts in the order SL, SR, NL, NR (screw or nut, left or right).
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDE_SIGNS

SIGN_X, SIGN_Z = np.array(SIDE_SIGNS).T
ON_SCREW = np.array([True, True, False, False])


class HelicalMotion:
    """A ball and the helical motions of nut and screw; what follows from radii, lead and speeds alone.

    A dataclass that inherits this gives ball_radius, pitch_radius [m], contact_angle [rad], lead [m] (of a right-hand
    helix; negative: left-hand, zero: bearing) and the speeds of nut and screw [rad/s]. Both bodies move along the helix,
    so that only nut_speed - screw_speed matters to the contacts.
    """

    ball_radius: float
    pitch_radius: float
    contact_angle: float
    lead: float
    nut_speed: float
    screw_speed: float

    @property
    def ratio(self) -> float:
        """Advance per angle, lead / (2 pi) [m/rad] (Lin 3.55)."""
        return self.lead / (2.0 * np.pi)

    @property
    def radius(self) -> float:
        """Length of path per angle, L / (2 pi) [m] (Lin 3.66)."""
        return float(np.hypot(self.pitch_radius, self.ratio))

    @property
    def lead_angle(self) -> float:
        """Lead angle [rad] (Lin 3.63)."""
        return float(np.arctan2(self.ratio, self.pitch_radius))

    @property
    def axis(self) -> Array:
        """Direction of the screw's axis in x3, y3, z3 (3,)."""
        return np.array([0.0, np.sin(self.lead_angle), np.cos(self.lead_angle)])

    @property
    def speed(self) -> float:
        """Speed of the nut relative to the screw [rad/s]."""
        return self.nut_speed - self.screw_speed

    @property
    def nominal_orbit(self) -> float:
        """omega_B [rad/s] of a ball that rolls at the nominal contact angle (3.65, F.5 without sliding along y3)."""
        lever = self.ball_radius * float(np.cos(self.contact_angle) * np.cos(self.lead_angle)) / self.radius
        return 0.5 * (self.nut_speed + self.screw_speed + lever * self.speed)

    def normals(self, angle: ArrayLike) -> Array:
        """Directions (..., 4, 3) from the ball's centre to its contacts at contact angles (..., 4) [rad] (Lin 3.58)."""
        beta = np.asarray(angle, dtype=float)
        return np.stack([SIGN_X * np.cos(beta), np.zeros_like(beta), SIGN_Z * np.sin(beta)], axis=-1)

    def maps(self, normals: Array, ball_radius: Array | None = None) -> tuple[Array, Array]:
        """Maps (..., 4, 3, 4) and drives (..., 4, 3) of the contacts' (vx, vz, spin) for directions (..., 4, 3).

        ball_radius (...,) [m] in place of that of all balls.

        Unknowns: omega_B (orbit), omega_x, omega_y, omega_z [rad/s], the latter relative to the turning frame.
        Contact axes: x across the groove, z along the path, y into the ball. Rederived from 3.57-3.64 (gives 3.65,
        F.4-F.6).
        """
        axes = contact_axes(normals)
        size = self.ball_radius if ball_radius is None else np.asarray(ball_radius)[..., None, None, None]
        slide = size * np.einsum("jik,...k->...ij", self.crosses, normals)
        slide[..., 1, 0] += self.radius
        maps = np.matmul(axes, slide)
        maps[..., 2, :] = -normals @ self.turns.T
        body = np.where(ON_SCREW, self.screw_speed, self.nut_speed)
        return maps, -body[:, None] * maps[..., 0]

    @cached_property
    def turns(self) -> Array:
        """Rotation axes of the four unknowns in x3, y3, z3, (4, 3)."""
        return np.concatenate([self.axis[None, :], np.eye(3)])

    @cached_property
    def crosses(self) -> Array:
        """Matrices (4, 3, 3) of the cross products with ``turns``."""
        return np.array([np.cross(t, np.eye(3)).T for t in self.turns])


def contact_axes(normals: Array) -> Array:
    """Rows x (across the groove), z (along the path), y (into the ball) of the contacts' axes, (..., 4, 3, 3)."""
    axes = np.zeros((*normals.shape, 3))
    axes[..., 0, 0], axes[..., 0, 2] = normals[..., 2], -normals[..., 0]
    axes[..., 1, 1] = 1.0
    axes[..., 2, :] = -normals
    return axes
