"""Nominal path of the balls (a helix or circle), positions of the balls on it, and frames of the groove section along it.

A section frame has the axes x3 (radial), y3 (along the track) and z3 (across the track).

After Lin (2019), eqs. (2.1), (2.2), (2.5), (2.6) and Appendix A, whose printed rotation about y is corrected.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, pi, sin

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDE_SIGNS, Scene, Track


def lead_per_radian(track: Track) -> float:
    """Return the signed lead per radian of a track.

    Parameters
    ----------
    track : Track
        Nominal path of the balls; lead in m.

    Returns
    -------
    float
        r_g = lead / (2 pi) [m/rad]; negative for a left-hand helix, 0 for a bearing.

    References
    ----------
    Lin (2019), eq. (2.2).

    Examples
    --------
    >>> from math import radians
    >>> round(1e3 * lead_per_radian(Track(16.5e-3, 20e-3, radians(45.0))), 4)  # mm/rad
    3.1831
    """
    return (1.0 if track.hand == "right" else -1.0) * track.lead / (2.0 * pi)


def lead_angle(track: Track) -> float:
    """Return the signed lead angle of a track at its pitch radius.

    Parameters
    ----------
    track : Track
        Nominal path of the balls; pitch radius and lead in m.

    Returns
    -------
    float
        alpha = atan(r_g / R_p) [rad], with the pitch radius R_p; negative for a left-hand helix, 0 for a bearing.

    References
    ----------
    Lin (2019), eq. (2.5).

    Examples
    --------
    >>> from math import degrees, radians
    >>> round(degrees(lead_angle(Track(16.5e-3, 20e-3, radians(45.0)))), 3)
    10.919
    """
    return atan2(lead_per_radian(track), track.pitch_radius)


@dataclass(frozen=True)
class BallLayout:
    """Nominal positions of n balls, one thread start after the other, and the axes of the groove section at each ball."""

    #: Azimuths of the balls ``(n,)`` [rad], counted on over whole turns; they include the offset of the thread start.
    azimuth: Array
    #: Axial positions of the ball centres ``(n,)`` [m].
    z: Array
    #: Coordinates of the ball centres ``(n, 3)`` [m]; the screw's axis is z.
    centre: Array
    #: Unit vectors x3 of the section frames ``(n, 3)``: radially outward.
    radial: Array
    #: Unit vectors z3 of the section frames ``(n, 3)``: across the groove, in its section.
    binormal: Array
    #: Unit vectors y3 of the section frames ``(n, 3)``: along the track.
    tangent: Array


def ball_layout(scene: Scene) -> BallLayout:
    """Compute the nominal centres of all balls of a scene, and at each the frame of the groove section.

    The helix of thread start k, counted from 0, has the azimuth ``phase + 2 pi k / starts`` at the nut's centre.

    Parameters
    ----------
    scene : Scene
        Scene with a ball screw or bearing.

    Returns
    -------
    BallLayout
        Positions of all balls, one thread start after the other.

    References
    ----------
    Lin (2019), eqs. (2.1) and (2.6).

    Examples
    --------
    >>> import rollbench
    >>> places = ball_layout(rollbench.read("lin-case1"))
    >>> places.centre.shape, (1e3 * places.z[:3]).round(3).tolist()  # mm
    ((32, 3), [380.625, 381.875, 383.125])
    """
    track = scene.track
    offsets = 2.0 * pi * np.arange(track.starts) / track.starts
    azimuths = np.asarray(scene.balls.azimuths, dtype=float)
    azimuth = (azimuths[None, :] + offsets[:, None]).ravel()
    z = scene.nut.position + lead_per_radian(track) * np.tile(azimuths - track.phase, track.starts)  # (2.1)
    return ball_layout_at_positions(track, azimuth, z)


def ball_layout_at_positions(track: Track, azimuth: Array, z: Array) -> BallLayout:
    """Compute the centres of balls, and the frames of the groove section there, from azimuths and axial positions.

    Parameters
    ----------
    track : Track
        Nominal path of the balls.
    azimuth : (n,) Array
        Azimuths of the balls [rad].
    z : (n,) Array
        Axial positions of the ball centres [m].

    Returns
    -------
    BallLayout
        Positions of the n balls.

    References
    ----------
    Lin (2019), eqs. (2.1) and (2.6).
    """
    alpha = lead_angle(track)
    c, s = np.cos(azimuth), np.sin(azimuth)
    radial, binormal, tangent, centre = np.zeros((4, azimuth.size, 3))
    radial[:, 0], radial[:, 1] = c, s  # x3, z3 and y3 of (2.6)
    binormal[:, 0], binormal[:, 1], binormal[:, 2] = s * sin(alpha), -c * sin(alpha), cos(alpha)
    tangent[:, 0], tangent[:, 1], tangent[:, 2] = -s * cos(alpha), c * cos(alpha), sin(alpha)
    centre[:, 0], centre[:, 1], centre[:, 2] = track.pitch_radius * c, track.pitch_radius * s, z
    return BallLayout(azimuth, z, centre, radial, binormal, tangent)


def nominal_groove_radii(scene: Scene) -> Array:
    """Return the nominal groove radii of the four flanks (screw left, screw right, nut left, nut right).

    Parameters
    ----------
    scene : Scene
        Scene with the groove radii of screw and nut.

    Returns
    -------
    (4,) Array
        Groove radii [m].
    """
    return np.array([scene.screw.groove_radius] * 2 + [scene.nut.groove_radius] * 2)


def nominal_groove_centres(scene: Scene) -> Array:
    """Return the nominal centres of the arcs of the four flanks, relative to the ball's centre.

    Parameters
    ----------
    scene : Scene
        Scene with the radii and the contact angle.

    Returns
    -------
    (4, 2) Array
        Coordinates x3 (radial) and z3 (across the track) [m] for screw left, screw right, nut left, nut right: at the
        distance r_G - r_B from the ball's centre, opposite to the contact, with the radii r_G of the groove and r_B of the
        ball.

    References
    ----------
    Lin (2019), eq. (2.4).

    Examples
    --------
    >>> import rollbench
    >>> (1e3 * nominal_groove_centres(rollbench.read("lin-case1"))[0]).round(4).tolist()  # mm
    [0.3366, 0.3366]
    """
    return _points_along_contact_directions(scene, scene.balls.radius - nominal_groove_radii(scene))


def nominal_contact_points(scene: Scene) -> Array:
    """Return the nominal contact points of a ball on the four flanks, relative to the ball's centre.

    Parameters
    ----------
    scene : Scene
        Scene with the ball radius and the contact angle.

    Returns
    -------
    (4, 2) Array
        Coordinates x3 (radial) and z3 (across the track) [m] for screw left, screw right, nut left, nut right; the distance
        from the ball's centre is the ball's radius.

    Examples
    --------
    >>> import rollbench
    >>> (1e3 * nominal_contact_points(rollbench.read("lin-case1"))[0]).round(4).tolist()  # mm
    [-1.9643, -1.9643]
    """
    return _points_along_contact_directions(scene, np.full(4, scene.balls.radius))


def _points_along_contact_directions(scene: Scene, distances: Array) -> Array:
    """Return one point for each flank, at a given distance from the ball's centre along the contact direction.

    ``distances``: distance for each of the four flanks (screw left, screw right, nut left, nut right) [m]. The points are
    given by their coordinates (x3, z3) in the section ``(4, 2)`` [m]; a negative distance is opposite to the contact.
    """
    c, s = cos(scene.track.contact_angle), sin(scene.track.contact_angle)
    return np.array([(d * (x * c), d * (z * s)) for d, (x, z) in zip(distances, SIDE_SIGNS, strict=True)])
