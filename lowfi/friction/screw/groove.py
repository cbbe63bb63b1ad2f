"""A ball between the grooves of two helical bodies with friction: kinematics, Hertz constants, scaled units.

Axes at the ball's centre (section 3.4.1 of Lin's thesis): x3 radially outward, y3 along the helical path, z3 the binormal,
about which the lead angle tilts the screw's axis towards y3. Contacts in the order SL, SR, NL, NR (screw or nut, left or
right).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rollbench.lowfi.hertz import HertzConstants
from rollbench.lowfi.statics.contacts import hertz_without_errors, misprinted_hertz_of_flanks
from rollbench.meshes.arrays import Array
from rollbench.meshes.numerics import brentq
from rollbench.meshes.parts import SIDE_SIGNS, Balls, Material, Nut, Scene, Screw, Track
from rollbench.meshes.record_keys import frozen_default, frozen_record

#: How Hertz constants are computed: exactly ("right"), or with the errors of Lin's Table B.1 ("as printed").
Mode = Literal["right", "as printed"]
#: Signs of the components, along x3 (radial) and z3 (binormal), of the directions from the ball's centre to its contacts
#: SL, SR, NL, NR (screw or nut, left or right).
SIGN_X, SIGN_Z = np.array(SIDE_SIGNS).T
#: Whether each of the contacts SL, SR, NL, NR (screw or nut, left or right) is on the screw.
ON_SCREW = np.array([True, True, False, False])


class HelicalMotion:
    """Kinematics of a ball between a nut and a screw that turn and advance along the helix.

    Each of the two bodies moves along the helix, so that only the difference of their speeds influences the contacts. A
    bearing ring has zero lead.
    """

    #: Ball radius R_B [m].
    ball_radius: float
    #: Radius of the helix of ball centres [m].
    pitch_radius: float
    #: Nominal contact angle [rad].
    contact_angle: float
    #: Lead of a right-hand helix [m]; negative: left-hand, zero: bearing.
    lead: float
    #: Angular speed of the nut about the axis [rad/s].
    nut_speed: float
    #: Angular speed of the screw about the axis [rad/s].
    screw_speed: float

    @property
    def advance_per_radian(self) -> float:
        """Advance along the axis per angle, lead/(2 pi) [m/rad] (Lin 3.55)."""
        return self.lead / (2.0 * np.pi)

    @property
    def radius(self) -> float:
        """Length of the helical path of ball centres per angle, L/(2 pi) with the length L of one turn [m] (Lin 3.66)."""
        return float(np.hypot(self.pitch_radius, self.advance_per_radian))

    @property
    def lead_angle(self) -> float:
        """Lead angle of the helix of ball centres [rad] (Lin 3.63)."""
        return float(np.arctan2(self.advance_per_radian, self.pitch_radius))

    @property
    def screw_axis_direction(self) -> Array:
        """Unit vector along the screw's axis in a ball's axes x3 (radial), y3 (along the track), z3 (binormal) ``(3,)``."""
        return np.array([0.0, np.sin(self.lead_angle), np.cos(self.lead_angle)])

    @property
    def speed(self) -> float:
        """Angular speed of the nut relative to the screw [rad/s]."""
        return self.nut_speed - self.screw_speed

    @property
    def nominal_orbit(self) -> float:
        """Orbital speed omega_B of a ball that rolls at the nominal contact angle [rad/s] (Lin 3.65).

        The formula is eq. (F.5) of Lin's thesis without sliding along y3.
        """
        lever = self.ball_radius * float(np.cos(self.contact_angle) * np.cos(self.lead_angle)) / self.radius
        return 0.5 * (self.nut_speed + self.screw_speed + lever * self.speed)

    def normals(self, angle: ArrayLike) -> Array:
        """Return unit vectors from the ball's centre to its contacts in the axes x3, y3, z3 ``(..., 4, 3)`` (Lin 3.58).

        x3 is radial, y3 along the track and z3 the binormal. ``angle``: contact angles ``(..., 4)`` [rad].
        """
        beta = np.asarray(angle, dtype=float)
        return np.stack([SIGN_X * np.cos(beta), np.zeros_like(beta), SIGN_Z * np.sin(beta)], axis=-1)

    def contact_kinematics(self, normals: Array, ball_radius: Array | None = None) -> tuple[Array, Array]:
        """Return the linear relation between the motion of a ball and the sliding and spin at its four contacts.

        The motion at a contact is the sliding vx, vz [m/s] and the spin [rad/s] of the ball relative to screw or nut,
        in the axes x across the groove, z along the path, y into the ball. This motion is ``maps @ q + drives`` with
        the ball's motion q: omega_B (orbit) and omega_x, omega_y, omega_z [rad/s], the latter three relative to the
        axes x3 (radial), y3 (along the track), z3 (binormal), which turn with the orbit.

        Parameters
        ----------
        normals
            Directions from the ball's centre to the contacts in x3, y3, z3 ``(..., 4, 3)``.
        ball_radius
            Radii of the balls ``(...,)`` [m]; with None all have the nominal radius.

        Returns
        -------
        tuple[Array, Array]
            First ``maps``, motion of the contacts per unit of q ``(..., 4, 3, 4)``; then ``drives``, motion of the contacts
            at q = 0, which screw and nut impose ``(..., 4, 3)``.

        References
        ----------
        Rederived from Lin (2019), 3.57 to 3.64; the result contains Lin's eqs. (3.65) and (F.4) to (F.6).
        """
        axes = contact_axes(normals)
        size = self.ball_radius if ball_radius is None else np.asarray(ball_radius)[..., None, None, None]
        slide = size * np.einsum("jik,...k->...ij", self.cross_product_matrices, normals)
        slide[..., 1, 0] += self.radius
        maps = np.matmul(axes, slide)
        maps[..., 2, :] = -normals @ self.ball_rotation_axes.T
        body = np.where(ON_SCREW, self.screw_speed, self.nut_speed)
        return maps, -body[:, None] * maps[..., 0]

    @cached_property
    def ball_rotation_axes(self) -> Array:
        """Axes of a ball's four rotations (orbit about the screw's axis, three spins), unit vectors ``(4, 3)``.

        Components are those along x3 (radial), y3 (along the track), z3 (binormal).
        """
        return np.concatenate([self.screw_axis_direction[None, :], np.eye(3)])

    @cached_property
    def cross_product_matrices(self) -> Array:
        """Matrices M ``(4, 3, 3)`` with M v = t x v for each axis t in ``ball_rotation_axes`` and any vector v."""
        return np.ascontiguousarray(np.cross(self.ball_rotation_axes[:, None], np.eye(3)).swapaxes(1, 2))


def contact_axes(normals: Array) -> Array:
    """Return the contacts' axes x (across the groove), z (along the path), y (into the ball) as rows ``(..., 4, 3, 3)``.

    Components are those along x3 (radial), y3 (along the track), z3 (binormal) of the ball. ``normals``: directions
    from the ball's centre to the contacts in the same axes ``(..., 4, 3)``.
    """
    axes = np.zeros((*normals.shape, 3))
    axes[..., 0, 0], axes[..., 0, 2] = normals[..., 2], -normals[..., 0]
    axes[..., 1, 1] = 1.0
    axes[..., 2, :] = -normals
    return axes


class ScaledTrack(NamedTuple):
    """Kinematics of the balls of a track in scaled units.

    The motion x (4,) of a ball is its motion along the track and its three spins, as surface speeds divided by the speed of
    the moving groove along the track.
    """

    #: Velocity of the first ball's surface at its contact with the second ball, along two tangents, per unit of the first
    #: ball's motion x (2, 4).
    first_ball_surface_speeds: Array
    #: Velocity of the second ball's surface at its contact with the first ball, along the same tangents, per unit of the
    #: second ball's motion x (2, 4).
    second_ball_surface_speeds: Array
    #: Speed at which a ball approaches the next one, per unit of the difference of their motions x (4,).
    approach: Array


class TrackInMotion(ABC):
    """Abstract class for a track of balls between two grooves, one of which moves along it.

    The motion q (4,) of a ball is its motion along the track and three spins [rad/s] about the axes x3 (across the track),
    y3 (along the track) and z3.
    """

    @property
    @abstractmethod
    def levers(self) -> Array:
        """Surface speed of a ball per unit of each component of its motion ``(4,)``."""

    @property
    @abstractmethod
    def speed_along_path(self) -> float:
        """Speed of the moving groove along the track [m/s], positive; 1 m/s for grooves at rest."""

    @property
    @abstractmethod
    def nominal_motion(self) -> Array:
        """Motion of a ball that rolls at the nominal contact angle ``(4,)``."""

    @property
    @abstractmethod
    def pair(self) -> TouchingBallsGeometry:
        """Geometry of the contact of two touching balls of nominal size."""

    @cached_property
    def scaled(self) -> ScaledTrack:
        """Kinematics of the balls in scaled units."""
        unit, pair = self.levers, self.pair
        return ScaledTrack(
            first_ball_surface_speeds=pair.first_ball_surface_speeds / unit,
            second_ball_surface_speeds=pair.second_ball_surface_speeds / unit,
            approach=pair.closing_speed_factor * np.array([1.0, 0.0, 0.0, 0.0]) / unit,
        )


class GroovesInMotion(HelicalMotion, TrackInMotion):
    """Grooves of screw and nut that move along the helix."""

    @cached_property
    def pair(self) -> TouchingBallsGeometry:
        """Geometry of the contact of two touching balls of nominal size."""
        return touching_balls_geometry(self)

    @property
    def levers(self) -> Array:
        """Length of the path per angle, then three times the ball radius ``(4,)`` [m]."""
        return np.array([self.radius, self.ball_radius, self.ball_radius, self.ball_radius])

    @property
    def speed_along_path(self) -> float:
        """Speed of the nut relative to the screw along the helical path [m/s]; 1 m/s if both are at rest."""
        return float(abs(self.speed) * self.radius) or 1.0

    @cached_property
    def affine_contact_maps(self) -> tuple[Array, Array]:
        """Three matrices A_0, A_1, A_2 ``(3, 3, 4)``, and the motions ``(4, 4)`` of the bodies on which the contacts lie.

        Both are for the motion of a ball as surface speeds divided by the speed along the path. The matrix A_0 + n_x A_1
        + n_z A_2 converts it to sliding vx, vz [m/s] and spin [rad/s] at a contact with the normal (n_x, n_z).
        """
        scale, orbit = self.speed_along_path / self.levers, np.array([1.0, 0.0, 0.0, 0.0])
        ends = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        at = self.contact_kinematics(np.repeat(ends[:, None, :], 4, axis=1))[0][:, 0] * scale
        middle = 0.5 * (at[0] + at[1])  # maps are affine in the normal, so that three directions tell them
        body = np.where(ON_SCREW, self.screw_speed, self.nut_speed)
        return np.stack([middle, at[0] - middle, at[2] - middle]), body[:, None] * orbit / scale

    @property
    def nominal_motion(self) -> Array:
        """Motion of a ball that rolls at the nominal contact angle ``(4,)`` [rad/s]."""
        return np.array([self.nominal_orbit, 0.0, 0.0, 0.0])


@frozen_record
class ScrewGroove(GroovesInMotion):
    """Grooves of a ball screw with four contacts per ball, with coefficients of friction and speeds of screw and nut.

    Screw and nut each turn and advance along the helix, so that only the difference of their speeds influences the
    contacts.
    """

    #: Ball radius R_B [m].
    ball_radius: float
    #: Radius of the arcs of the groove's section [m].
    groove_radius: float
    #: Radius of the helix of ball centres [m].
    pitch_radius: float
    #: Lead of a right-hand helix [m]; negative: left-hand, zero: bearing.
    lead: float
    #: Nominal contact angle [rad].
    contact_angle: float
    #: Young's modulus [Pa].
    young: float
    #: Poisson's ratio.
    poisson: float
    #: Coefficient of friction of the grooves.
    mu: float
    #: Angular speed of the nut about the axis [rad/s].
    nut_speed: float
    #: Angular speed of the screw about the axis [rad/s].
    screw_speed: float = frozen_default(0.0)
    #: Coefficient of friction between touching balls; None: the same value as for the grooves.
    mu_balls: float | None = frozen_default(None)
    #: Whether the Hertz constants are exact ("right") or have the errors of Lin's Table B.1 ("as printed").
    hertz: Mode = frozen_default("right")

    def __post_init__(self) -> None:
        """Raise ValueError for radii, angles or material constants out of range."""
        if not 0.0 < self.ball_radius < self.groove_radius or self.pitch_radius <= self.groove_radius:
            raise ValueError(
                "ball, groove and pitch radius must be positive and increase in this order, "
                f"got {self.ball_radius}, {self.groove_radius} and {self.pitch_radius} m"
            )
        if not 0.0 < self.contact_angle < 0.5 * np.pi:
            raise ValueError(f"the contact angle must lie between 0 and pi/2, got {self.contact_angle} rad")
        if self.young <= 0.0 or not 0.0 <= self.poisson < 0.5 or self.mu < 0.0 or (self.mu_balls or 0.0) < 0.0:
            raise ValueError(
                "Young's modulus must be positive, Poisson's ratio lie in [0, 0.5), and no coefficient of friction be "
                f"negative, got young {self.young} Pa, poisson {self.poisson}, mu {self.mu}, mu_balls {self.mu_balls}"
            )

    @property
    def ball_to_ball_mu(self) -> float:
        """Coefficient of friction between touching balls."""
        return self.mu if self.mu_balls is None else self.mu_balls

    @property
    def groove_ball_centre_distance(self) -> float:
        """Groove radius less ball radius: the distance of the centres of ball and groove arc where both just touch [m]."""
        return self.groove_radius - self.ball_radius

    @cached_property
    def contact_hertz_constants(self) -> HertzConstants:
        """Hertz constants at the nominal contact angle, from the exact helicoids or with the errors of Lin's Table B.1."""
        steel = Material(self.young, self.poisson)
        scene = Scene(
            "groove",
            "groove",
            Track(self.pitch_radius, abs(self.lead), self.contact_angle, "left" if self.lead < 0.0 else "right"),
            Screw(0.1, 2.0 * self.pitch_radius, self.groove_radius, steel),
            Nut(0.05, 0.05, 4.0 * self.pitch_radius, self.groove_radius, steel),
            Balls(self.ball_radius, steel, (0.0,)),
        )
        return hertz_without_errors(scene) if self.hertz == "right" else printed_hertz_constants(scene)


def printed_hertz_constants(scene: Scene) -> HertzConstants:
    """Return the Hertz constants of the four flanks ``(4,)`` by Table B.1 of Lin's thesis, for parts without errors."""
    rows = np.array([(x.C, x.C_a, x.C_b, x.e) for x in misprinted_hertz_of_flanks(scene)])
    return HertzConstants(*np.repeat(rows, 2, axis=0).T)


@dataclass(frozen=True)
class TouchingBallsGeometry:
    """Geometry of the contact of two neighbouring balls that touch; the second ball is the one at the larger azimuth.

    Vectors are in the axes x3 (radial), y3 (along the track), z3 (binormal) of the ball to which they belong.
    """

    #: Difference of the azimuths of the two balls [rad].
    spacing: float
    #: Speed at which two balls approach each other, per unit of difference of their orbital speeds omega_B [m].
    closing_speed_factor: float
    #: Velocity of the first ball's surface at the contact, along two tangents, per unit of each of the ball's four angular
    #: speeds (orbit and three spins) ``(2, 4)`` [m].
    first_ball_surface_speeds: Array
    #: Velocity of the second ball's surface at the contact, along the same tangents, per unit of each of this ball's four
    #: angular speeds ``(2, 4)`` [m].
    second_ball_surface_speeds: Array
    #: Direction of the contact force on the first and on the second ball ``(2, 3)``.
    force_directions: Array
    #: Directions of the two tangents of the contact, in the axes of the first, then of the second ball ``(2, 2, 3)``.
    tangent_directions: Array


def azimuth_between_touching_balls(screw: HelicalMotion) -> float:
    """Return the difference of the azimuths of two neighbouring balls that touch [rad].

    The centres of the balls lie on the helix at a distance of two ball radii R_B.

    Parameters
    ----------
    screw
        Ball radius, pitch radius and lead.

    Raises
    ------
    ValueError
        Balls so large that touching neighbours lie a quarter turn or more apart.

    References
    ----------
    Lin (2019), 3.72, prints 2 arcsin(R_B/(L/2 pi)) with the length L of one turn of the helix. This formula is exact for
    zero lead only.
    """
    pitch, rise, reach = screw.pitch_radius, screw.advance_per_radian, 2.0 * screw.ball_radius

    def distance_above_ball_diameter(angle: float) -> float:
        """Return by how much the distance of two ball centres exceeds the ball diameter [m].

        ``angle``: difference of the azimuths of the balls [rad].
        """
        return float(np.hypot(2.0 * pitch * np.sin(0.5 * angle), rise * angle)) - reach

    if distance_above_ball_diameter(0.5 * np.pi) <= 0.0:
        raise ValueError(
            f"the ball radius {screw.ball_radius} m is too large for the pitch radius {pitch} m: two balls that touch must "
            "lie less than a quarter turn apart"
        )
    return float(brentq(distance_above_ball_diameter, 0.0, 0.5 * np.pi, xtol=1e-15, rtol=1e-14))


def section_axes(screw: HelicalMotion, azimuth: ArrayLike) -> Array:
    """Return the axes x3, y3, z3 of the groove sections at several balls, as rows in fixed axes ``(..., 3, 3)`` (Lin 3.62).

    x3 is radial, y3 along the track, z3 the binormal. ``screw``: the helix, of which only the lead angle is used;
    ``azimuth``: azimuths of the balls ``(...)`` [rad].
    """
    c, s, ca, sa = np.cos(azimuth), np.sin(azimuth), np.cos(screw.lead_angle), np.sin(screw.lead_angle)
    rows = np.array([[c, s, 0.0 * c], [-ca * s, ca * c, sa + 0.0 * c], [sa * s, -sa * c, ca + 0.0 * c]])
    return np.moveaxis(rows, (0, 1), (-2, -1))


def touching_balls_geometry(screw: HelicalMotion) -> TouchingBallsGeometry:
    """Return the geometry of the contact of two balls of nominal size that touch, on the exact helix.

    Parameters
    ----------
    screw
        Ball radius and helix.

    References
    ----------
    Corrects Lin (2019), 3.73 to 3.75, which take a circle of radius L/2 pi in place of a helix whose turn has the
    length L.
    """
    spacing = azimuth_between_touching_balls(screw)
    azimuths = (-0.5 * spacing, 0.5 * spacing)
    frames = [section_axes(screw, azimuth) for azimuth in azimuths]
    heights = [np.array([0.0, 0.0, screw.advance_per_radian * azimuth]) for azimuth in azimuths]
    first, second = (screw.pitch_radius * f[0] + height for f, height in zip(frames, heights, strict=True))
    line = second - first
    line /= np.linalg.norm(line)
    across = np.cross(line, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    tangents = np.stack([across, np.cross(line, across)])
    sliding = []
    for f, sign in zip(frames, (1.0, -1.0), strict=True):
        turns = np.concatenate([[[0.0, 0.0, 1.0]], f])
        move = np.cross(turns, sign * screw.ball_radius * line)
        move[0] += screw.radius * f[1]
        sliding.append(tangents @ move.T)
    return TouchingBallsGeometry(
        spacing=spacing,
        closing_speed_factor=float(screw.radius * line @ frames[0][1]),
        first_ball_surface_speeds=sliding[0],
        second_ball_surface_speeds=sliding[1],
        force_directions=np.stack([-(frames[0] @ line), frames[1] @ line]),
        tangent_directions=np.stack([tangents @ frames[0].T, tangents @ frames[1].T]),
    )
