"""Balls that roll between bodies which all move along one screw motion: a straight track, a ring or a helix.

Each body moves with the field H(r) = forward + axis x r times its own speed, seen from the centre of a ball in the
ball's own axes: a carriage (axis 0, forward a unit vector, speeds in m/s), a ring (axis its axis of rotation, forward =
R_p along the path, speeds in rad/s) or a nut and a screw (forward along the helix, its length the path per angle). All
of them are unchanged by that motion, so that a contact seen from its ball's centre stays where it is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rollbench.hifi.rolling.friction import Contact
from rollbench.hifi.rolling.patch import Patch
from rollbench.meshes.arrays import Array, Index

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


@dataclass(frozen=True)
class Meeting:
    """Balls ``one`` and ``two`` (indices) in touch: rows ``(3, 8)`` of closing speed and sliding of ball one past ball
    two per their motions; directions ``(3, 3)`` of these in common axes; speed [m/s] at which they may close without
    touching."""

    one: int
    two: int
    rows: Array
    axes: Array
    apart: float

    def forces(self, force: float, mu: float, slide: Array) -> Array:
        """Force ``(3,)`` on ball one in common axes at a sliding ``(2,)``; the other's is its opposite."""
        size = float(np.linalg.norm(slide))
        rub = mu * force / size * slide if size > 0.0 else np.zeros(2)
        return np.asarray(-force * self.axes[0] - rub @ self.axes[1:])

    @property
    def columns(self) -> Index:
        """Motions of both balls."""
        return np.concatenate([MOTIONS * k + np.arange(MOTIONS) for k in (self.one, self.two)])


@dataclass(frozen=True)
class Ball:
    """A ball: its own axes as rows in common ones ``(3, 3)``, and where it touches grooves."""

    frame: Array
    touches: tuple[Touch, ...]


@dataclass(frozen=True)
class Rolling:
    """Balls of radius [m] on a track, of one material (Young's modulus [Pa], Poisson's ratio) with their grooves;
    coefficients of friction at the grooves and between balls; orbit: nominal speed of the balls; which balls touch."""

    track: Track
    radius: float
    young: float
    poisson: float
    mu: float
    mu_balls: float
    orbit: float
    balls: tuple[Ball, ...]
    meetings: tuple[Meeting, ...] = ()


def axes_of(touch: Touch, scene: Rolling) -> Array:
    """Rows: local x (against the flow of material), y, and the normal, ``(3, 3)``. Raises ValueError where the groove's
    body moves as the ball does: nothing rolls."""
    ride, track = touch.ride - scene.orbit, scene.track
    flow = ride * track.field(scene.radius * touch.normal)
    flow = flow - (flow @ touch.normal) * touch.normal
    speed = float(np.linalg.norm(flow))
    if speed <= 1e-12 * track.length * max(abs(touch.ride), abs(scene.orbit), 1e-300):
        raise ValueError("a ball that moves with a groove does not roll on it")
    x = -flow / speed
    return np.stack([x, np.cross(touch.normal, x), touch.normal])


def surface(touch: Touch, scene: Rolling, local: Array, *, curved: bool, sunk: float = 0.0) -> tuple[Array, Array]:
    """Points ``(n, 3)`` [m] from the ball's centre and tangents ``(n, 2, 3)`` at local x, y ``(n, 2)``.

    curved: on the surface that ball and groove share, its curvature the mean of both; otherwise on the tangent plane.
    sunk: depth [m] of its middle inside the undeformed ball.
    """
    axes = axes_of(touch, scene)
    bend = (1.0 / scene.radius - 0.5 / np.array(touch.radii)) * (1.0 if curved else 0.0)
    fall = 0.5 * (local**2 @ bend)
    points = (scene.radius - sunk) * axes[2] + local @ axes[:2] - fall[:, None] * axes[2]
    tangents = axes[None, :2] - (local * bend)[:, :, None] * axes[2]
    return points, tangents / np.linalg.norm(tangents, axis=2, keepdims=True)


def rolling_speed(touch: Touch, scene: Rolling) -> float:
    """Speed [m/s] at which material passes through the contact."""
    return float(np.linalg.norm((touch.ride - scene.orbit) * scene.track.field(scene.radius * touch.normal)))


def rigid_contact(
    touch: Touch, scene: Rolling, ball: int, normal: Array, local: Array, *, curved: bool, sunk: float = 0.0
) -> Contact:
    """Contact of a ball with its groove under normal forces ``(n,)`` [N] at local x, y ``(n, 2)`` [m], as rigid bodies have
    it; curved, sunk: as in `surface`."""
    points, tangents = surface(touch, scene, local, curved=curved, sunk=sunk)
    rows = np.einsum("nck,nkm->cnm", tangents, motion_rows(scene.track, scene.radius, points)).reshape(-1, MOTIONS)
    given = -touch.ride * np.einsum("nck,nk->cn", tangents, scene.track.field(points)).ravel()
    return Contact(scene.mu * normal, np.zeros((0, 0)), rows, MOTIONS * ball + np.arange(MOTIONS), given)


def ball_contact(touch: Touch, scene: Rolling, ball: int, patch: Patch, *, curved: bool, elastic: float = 1.0) -> Contact:
    """The same on the grid of a patch; elastic: share of the bodies' compliance along tangents."""
    rigid = rigid_contact(touch, scene, ball, patch.normal, patch.at, curved=curved, sunk=elastic * patch.sunk)
    speed = elastic * rolling_speed(touch, scene)
    return replace(rigid, elastic=speed * patch.transport, given=rigid.given + speed * patch.strain)


# --- balls that touch: force and closing speed not negative and complementary, sliding friction at the point of contact
#
# Two balls of a track turn the same way, so that where they touch they rub at about the full speed of their surfaces: the
# whole contact, some hundredths of a radius wide, slides one way, and a point stands for it.


def meeting(
    one: int, two: int, frames: tuple[Array, Array], line: Array, track: Track, radius: float, apart: float = 0.0
) -> Meeting:
    """Two balls whose own axes are the rows of ``frames`` ``(3, 3)``, the second along ``line`` ``(3,)`` from the first."""
    side = np.cross(line, np.eye(3)[int(np.argmin(np.abs(line)))])
    side /= np.linalg.norm(side)
    axes = np.stack([line, side, np.cross(line, side)])
    parts = []
    for frame, sign in zip(frames, (1.0, -1.0), strict=True):
        local = axes @ frame.T  # the three directions in the ball's own axes
        at = sign * radius * local[0]
        rows = local @ motion_rows(track, radius, at[None])[0]
        parts.append(sign * rows)
    return Meeting(one, two, np.hstack(parts), axes, apart)


@dataclass(frozen=True)
class Together:
    """f of (2) in `hifi.rolling.friction` for the balls of a scene: motions of all, then the force of each meeting [N];
    weight: of closing speeds beside forces [N s/m]."""

    scene: Rolling
    weight: float

    def __call__(self, y: Array) -> tuple[Array, Array]:
        """Forces on the motions and the complementarity of every meeting, with their derivative."""
        mu, m = self.scene.mu_balls, MOTIONS * len(self.scene.balls)
        f, S = np.zeros(y.size), np.zeros((y.size, y.size))
        for k, pair in enumerate(self.scene.meetings):
            i, row = pair.columns, m + k
            force, speeds = float(y[row]), pair.rows @ y[i]
            closing, slide = speeds[0] - pair.apart, speeds[1:]
            size = float(np.linalg.norm(slide))
            unit = slide / size if size > 0.0 else slide
            turn = (np.eye(2) - np.outer(unit, unit)) / size if size > 0.0 else np.zeros((2, 2))
            along = pair.rows[0] + mu * unit @ pair.rows[1:]
            f[i] -= force * along
            S[i, row] -= along
            S[np.ix_(i, i)] -= force * mu * pair.rows[1:].T @ turn @ pair.rows[1:]
            if force + self.weight * closing > 0.0:
                f[row] = self.weight * closing
                S[row, i] = self.weight * pair.rows[0]
            else:
                f[row] = force
                S[row, row] = 1.0
        return f, S
