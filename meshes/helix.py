"""The nominal ball path and the section frames that follow it (Lin 2.1, 2.2, 2.5, 2.6; Appendix A, rot_y mended)."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, pi, sin

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDE_SIGNS, Scene, Track


def reduced_lead(track: Track) -> float:
    """Signed gear ratio r_g = lead / (2 pi) [m/rad] (Lin 2.2), negative for a left-hand track."""
    return (1.0 if track.hand == "right" else -1.0) * track.lead / (2.0 * pi)


def lead_angle(track: Track) -> float:
    """Signed lead angle alpha [rad] at the pitch radius (Lin 2.5)."""
    return atan2(reduced_lead(track), track.pitch_radius)


@dataclass(frozen=True)
class BallLayout:
    """Where the balls are, start after start.

    azimuth: unwrapped azimuth of each ball, including its start's offset, shape ``(n,)`` [rad].
    z: station of each ball's centre, shape ``(n,)`` [m].
    centre: nominal ball centres, shape ``(n, 3)`` [m].
    radial, binormal, tangent: unit vectors x3, z3, y3 of each section frame, shape ``(n, 3)``.
    """

    azimuth: Array
    z: Array
    centre: Array
    radial: Array
    binormal: Array
    tangent: Array


def ball_layout(scene: Scene) -> BallLayout:
    """Nominal ball centres and section frames of a scene (Lin 2.1, 2.6).

    The helix of start k passes the azimuth ``phase + 2 pi k / starts`` at the nut's centre.
    """
    track = scene.track
    offsets = 2.0 * pi * np.arange(track.starts) / track.starts
    azimuths = np.asarray(scene.balls.azimuths, dtype=float)
    azimuth = (azimuths[None, :] + offsets[:, None]).ravel()
    z = scene.nut.position + reduced_lead(track) * np.tile(azimuths - track.phase, track.starts)
    return layout_at(track, azimuth, z)


def layout_at(track: Track, azimuth: Array, z: Array) -> BallLayout:
    """Centres and section frames of balls at azimuths (n,) [rad] and stations (n,) [m] of a track."""
    alpha = lead_angle(track)
    c, s = np.cos(azimuth), np.sin(azimuth)
    radial, binormal, tangent, centre = np.zeros((4, azimuth.size, 3))
    radial[:, 0], radial[:, 1] = c, s
    binormal[:, 0], binormal[:, 1], binormal[:, 2] = s * sin(alpha), -c * sin(alpha), cos(alpha)
    tangent[:, 0], tangent[:, 1], tangent[:, 2] = -s * cos(alpha), c * cos(alpha), sin(alpha)
    centre[:, 0], centre[:, 1], centre[:, 2] = track.pitch_radius * c, track.pitch_radius * s, z
    return BallLayout(azimuth, z, centre, radial, binormal, tangent)


def groove_radii(scene: Scene) -> Array:
    """Nominal groove radius of each side, shape ``(4,)`` [m]."""
    return np.array(_radii(scene))


def _radii(scene: Scene) -> list[float]:
    return [scene.screw.groove_radius] * 2 + [scene.nut.groove_radius] * 2


def nominal_groove_centres(scene: Scene) -> Array:
    """Groove centres in the section frame, shape ``(4, 2)`` [m]: (r_G - r_B) opposite to the contact (Lin 2.4)."""
    return _along_contacts(scene, [-(r - scene.balls.radius) for r in _radii(scene)])


def nominal_contact_points(scene: Scene) -> Array:
    """Nominal contact points in the section frame, shape ``(4, 2)`` [m]: r_B along the contact direction."""
    return _along_contacts(scene, [scene.balls.radius] * 4)


def _along_contacts(scene: Scene, distance: list[float]) -> Array:
    """Points ``(4, 2)`` [m] so far along the contact direction of each side."""
    c, s = cos(scene.track.contact_angle), sin(scene.track.contact_angle)
    return np.array([(d * (x * c), d * (z * s)) for d, (x, z) in zip(distance, SIDE_SIGNS, strict=True)])


def spread_over_turns(balls: int, turns: float, phase: float, circuits: int = 1, gap: float = 0.0) -> tuple[float, ...]:
    """Azimuths [rad] of balls spread evenly over the turns of each circuit, circuits with gaps of some turns between them,
    centred on a phase [rad]."""
    spacing, pitch = 2.0 * pi * turns / balls, 2.0 * pi * (turns + gap)
    middles = (phase + (k - (circuits - 1) / 2.0) * pitch for k in range(circuits))
    return tuple(middle + (i - (balls - 1) / 2.0) * spacing for middle in middles for i in range(balls))
