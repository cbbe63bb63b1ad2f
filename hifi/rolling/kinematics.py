"""Balls that roll between bodies which all move along one screw motion: a straight track, a ring or a helix.

Each body moves with the field H(r) = forward + axis x r times its own speed, seen from the centre of a ball in the
ball's own axes: a carriage (axis 0, forward a unit vector, speeds in m/s), a ring (axis its axis of rotation, forward =
R_p along the path, speeds in rad/s) or a nut and a screw (forward along the helix, its length the path per angle). All
of them are unchanged by that motion, so that a contact seen from its ball's centre stays where it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.hifi.rolling.friction import Contact
from rollbench.hifi.rolling.patch import Patch
from rollbench.meshes.arrays import Array

#: Motions of a ball: along the track, and about its own three axes; all as speeds [m/s].
MOTIONS = 4


@dataclass(frozen=True)
class Track:
    """Screw motion seen from a ball: axis ``(3,)`` of rotation (zero or of unit length), forward ``(3,)`` [m]."""

    axis: Array
    forward: Array

    @property
    def length(self) -> float:
        """Path of the ball's centre per unit of speed [m]."""
        return float(np.linalg.norm(self.forward))

    @property
    def curve(self) -> tuple[float, float] | None:
        """Radius of the path's cylinder [m] and rise per angle [m/rad] of a ring or a helix; None of a straight track."""
        if not self.axis.any():
            return None
        rise = float(self.axis @ self.forward)
        return float(np.sqrt(self.length**2 - rise**2)), rise

    def field(self, at: Array) -> Array:
        """H ``(..., 3)`` at points ``(..., 3)`` [m] from the ball's centre."""
        return np.asarray(self.forward + np.cross(self.axis, at))


def motion_rows(track: Track, radius: float, at: Array) -> Array:
    """Velocity ``(n, 3, 4)`` of the ball's material at points ``(n, 3)`` per motion of the ball (`MOTIONS`)."""
    rows = np.empty((*at.shape, MOTIONS))
    rows[..., 0] = track.field(at) / track.length
    for k in range(3):
        rows[..., k + 1] = np.cross(np.eye(3)[k], at) / radius
    return rows


@dataclass(frozen=True)
class Touch:
    """Where a ball touches a groove: direction ``(3,)`` from its centre, contact force [N], relative radii [m] along and
    across the groove, speed of the groove's body along the track; bottom: direction ``(3,)`` from the ball's centre to the
    bottom of the groove (None: unknown, which half spaces do not need)."""

    normal: Array
    load: float
    radii: tuple[float, float]
    ride: float
    bottom: Array | None = None


def axes_of(touch: Touch, track: Track, radius: float, orbit: float) -> Array:
    """Rows: local x (against the flow of material), y, and the normal, ``(3, 3)``.

    orbit: speed of the ball along the track. Raises ValueError where the groove's body moves as the ball does: nothing
    rolls.
    """
    flow = (touch.ride - orbit) * track.field(radius * touch.normal)
    flow = flow - (flow @ touch.normal) * touch.normal
    speed = float(np.linalg.norm(flow))
    if speed <= 1e-12 * track.length * max(abs(touch.ride), abs(orbit), 1e-300):
        raise ValueError("a ball that moves with a groove does not roll on it")
    x = -flow / speed
    return np.stack([x, np.cross(touch.normal, x), touch.normal])


def surface(
    axes: Array, radius: float, radii: tuple[float, float], local: Array, *, curved: bool, sunk: float = 0.0
) -> tuple[Array, Array]:
    """Points ``(n, 3)`` [m] from the ball's centre and tangents ``(n, 2, 3)`` at local x, y ``(n, 2)``.

    curved: on the surface that ball and groove share, its curvature the mean of both; otherwise on the tangent plane.
    sunk: depth [m] of its middle inside the undeformed ball.
    """
    bend = (1.0 / radius - 0.5 / np.array(radii)) * (1.0 if curved else 0.0)
    fall = 0.5 * (local**2 @ bend)
    points = (radius - sunk) * axes[2] + local @ axes[:2] - fall[:, None] * axes[2]
    tangents = axes[None, :2] - (local * bend)[:, :, None] * axes[2]
    return points, tangents / np.linalg.norm(tangents, axis=2, keepdims=True)


def rolling_speed(touch: Touch, track: Track, radius: float, orbit: float) -> float:
    """Speed [m/s] at which material passes through the contact."""
    return float(np.linalg.norm((touch.ride - orbit) * track.field(radius * touch.normal)))


def ball_contact(
    touch: Touch,
    patch: Patch,
    track: Track,
    radius: float,
    orbit: float,
    mu: float,
    first: int,
    *,
    curved: bool,
    elastic: float = 1.0,
) -> Contact:
    """Contact of a ball whose motions begin at ``first``; orbit: its speed along the track by which material flows.

    elastic: share of the bodies' compliance along tangents.
    """
    axes = axes_of(touch, track, radius, orbit)
    points, tangents = surface(axes, radius, touch.radii, patch.at, curved=curved, sunk=elastic * patch.sunk)
    rows = np.einsum("nck,nkm->cnm", tangents, motion_rows(track, radius, points)).reshape(-1, MOTIONS)
    given = -touch.ride * np.einsum("nck,nk->cn", tangents, track.field(points)).ravel()
    speed = elastic * rolling_speed(touch, track, radius, orbit)
    given += speed * patch.strain
    return Contact(mu * patch.normal, speed * patch.transport, rows, first + np.arange(MOTIONS), given)
