"""Kinematics of balls that roll between bodies which all move along one screw motion: a straight track, a ring or a helix.

Each body moves with the field H(r) = forward + axis x r times its speed, seen from the centre of a ball in the ball's
axes: a carriage (axis 0, forward a unit vector, speeds in m/s), a ring (axis its axis of rotation, forward = R_p along
the path, speeds in rad/s) or a nut and a screw (forward along the helix, its length the path per angle). All of them are
unchanged by that motion, so that a contact seen from its ball's centre stays where it is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rollbench.hifi.rolling.friction import FrictionContact
from rollbench.hifi.rolling.patch import GridContact
from rollbench.meshes.arrays import Array, Index

#: Number of motions of a ball: along the track, and rotation about its three axes times its radius; all are speeds [m/s].
MOTIONS = 4


@dataclass(frozen=True)
class TrackMotion:
    """Screw motion along a track (straight, ring or helix) in the axes of a ball, per unit of the track's speed.

    The speed is in m/s on a straight track, and in rad/s on a ring or helix.
    """

    #: Axis about which the track turns ``(3,)``: a unit vector, or zero for a straight track.
    rotation_axis: Array
    #: Velocity of the ball's centre per unit of the track's speed ``(3,)`` [1 on a straight track, m on a ring or helix].
    centre_velocity: Array

    @property
    def centre_speed(self) -> float:
        """Speed of the ball's centre per unit of the track's speed [1 on a straight track, m on a ring or helix]."""
        return float(np.linalg.norm(self.centre_velocity))

    @property
    def path_radius_and_rise(self) -> tuple[float, float] | None:
        """Radius of the path's cylinder [m] and rise per angle [m/rad], for a ring or a helix; None: a straight track."""
        if not self.rotation_axis.any():
            return None
        rise = float(self.rotation_axis @ self.centre_velocity)
        return float(np.sqrt(self.centre_speed**2 - rise**2)), rise

    def track_velocity_field(self, at: Array) -> Array:
        """Compute the velocity field of the screw motion per unit of the track's speed ``(..., 3)``.

        ``at``: points relative to the ball's centre (..., 3) [m]. Points and velocities are in the ball's axes.
        """
        return np.asarray(self.centre_velocity + np.cross(self.rotation_axis, at))


def velocities_by_ball_motions(track: TrackMotion, radius: float, at: Array) -> Array:
    """Compute the velocity of a ball's material at given points per unit of each of the ball's four motions.

    The four motions are the speed along the track, and the rotations about the ball's three axes times its radius, all in
    m/s (`MOTIONS`).

    Parameters
    ----------
    track : TrackMotion
        Screw motion of the track.
    radius : float
        Radius of the ball [m].
    at : (n, 3) Array
        Points relative to the ball's centre, in the ball's axes [m].

    Returns
    -------
    (n, 3, 4) Array
        Velocities of each point along the ball's axes, by 1 m/s of each motion.
    """
    rows = np.empty((*at.shape, MOTIONS))
    rows[..., 0] = track.track_velocity_field(at) / track.centre_speed
    for k in range(3):
        rows[..., k + 1] = np.cross(np.eye(3)[k], at) / radius
    return rows


@dataclass(frozen=True)
class GrooveContact:
    """Contact of a rolling ball with a groove: direction, prescribed force, radii and the groove's speed."""

    #: Unit vector from the ball's centre to the contact, in the ball's axes ``(3,)``.
    contact_normal: Array
    #: Contact force [N].
    contact_force: float
    #: Relative radii of curvature of ball and groove along and across the groove [m].
    relative_radii: tuple[float, float]
    #: Speed of the groove's body along the track [m/s on a straight track, rad/s on a ring or helix].
    groove_speed: float
    #: Unit vector from the ball's centre to the bottom of the groove ``(3,)``; None: unknown (half-spaces do not need it).
    direction_to_groove_bottom: Array | None = None


@dataclass(frozen=True)
class BallPairContact:
    """Sliding contact between two neighbouring balls of a track, at one point."""

    #: Index of the contact's first ball.
    first_ball: int
    #: Index of the contact's second ball.
    second_ball: int
    #: Closing speed (first row) and two sliding speeds of the first ball past the second, by 1 m/s of each motion of both
    #: balls ``(3, 8)``: for either ball its speed along the track, and its rotations about three axes times its radius.
    speeds_by_ball_motions: Array
    #: Directions of the three speeds in ``speeds_by_ball_motions`` as rows, in common axes ``(3, 3)``: from the first ball
    #: to the second, and two tangents.
    axes: Array
    #: Closing speed of the balls up to which they stay apart [m/s]: in a time step, their gap over the step's duration.
    separating_speed: float

    def force_on_first_ball(self, force: float, mu: float, slide: Array) -> Array:
        """Compute the force on the first ball, contact force plus friction, in common axes; the second has the opposite.

        Parameters
        ----------
        force : float
            Normal force [N].
        mu : float
            Coefficient of friction.
        slide : (2,) Array
            Sliding speed of the first ball past the second, along the two tangents [m/s].

        Returns
        -------
        (3,) Array
            Force on the first ball [N].
        """
        size = float(np.linalg.norm(slide))
        rub = mu * force / size * slide if size > 0.0 else np.zeros(2)
        return np.asarray(-force * self.axes[0] - rub @ self.axes[1:])

    @property
    def motion_indices(self) -> Index:
        """Indices of the motions of both balls in the vector of the motions of all balls ``(8,)``."""
        return np.concatenate([MOTIONS * k + np.arange(MOTIONS) for k in (self.first_ball, self.second_ball)])

    def closing_and_sliding_speeds(self, y: Array) -> Array:
        """Compute the closing speed of the balls and the two sliding speeds of the first past the second ``(3,)`` [m/s].

        ``y``: motions of all balls [m/s].
        """
        return np.asarray(self.speeds_by_ball_motions @ y[self.motion_indices])


@dataclass(frozen=True)
class RollingBall:
    """One rolling ball: its axes and its contacts with grooves."""

    #: Axes of the ball as rows, in common coordinates ``(3, 3)``.
    axes: Array
    #: Contacts of the ball with grooves.
    groove_contacts: tuple[GrooveContact, ...]


@dataclass(frozen=True)
class RollingBalls:
    """Input of the rolling model: balls on a track with material, friction coefficients and all contacts."""

    #: Screw motion of the track (straight, ring or helix).
    track: TrackMotion
    #: Radius of the balls [m].
    ball_radius: float
    #: Young's modulus [Pa].
    young: float
    #: Poisson's ratio.
    poisson: float
    #: Coefficient of friction at the grooves.
    groove_friction_coefficient: float
    #: Coefficient of friction between balls.
    ball_friction_coefficient: float
    #: Nominal speed of the balls along the track [m/s on a straight track, rad/s on a ring or helix].
    nominal_track_speed: float
    #: Axes and groove contacts of each ball.
    balls: tuple[RollingBall, ...]
    #: Contacts between neighbouring balls.
    ball_to_ball_contacts: tuple[BallPairContact, ...] = ()


def contact_axes(touch: GrooveContact, scene: RollingBalls) -> Array:
    """Compute the local axes of a contact: x against the flow of material, y across it, and the normal.

    Parameters
    ----------
    touch : GrooveContact
        The contact.
    scene : RollingBalls
        The rolling balls.

    Returns
    -------
    (3, 3) Array
        Unit vectors x, y and normal as rows, in the ball's axes.

    Raises
    ------
    ValueError
        The groove's body moves at the ball's speed along the track, so that nothing rolls.
    """
    ride, track = touch.groove_speed - scene.nominal_track_speed, scene.track
    flow = ride * track.track_velocity_field(scene.ball_radius * touch.contact_normal)
    flow = flow - (flow @ touch.contact_normal) * touch.contact_normal
    speed = float(np.linalg.norm(flow))
    if speed <= 1e-12 * track.centre_speed * max(abs(touch.groove_speed), abs(scene.nominal_track_speed), 1e-300):
        raise ValueError(
            "ball and groove move along the track at the same speed of "
            f"{track.centre_speed * touch.groove_speed:.4g} m/s, so that the ball does not roll on the groove; allowed: "
            "different speeds"
        )
    x = -flow / speed
    return np.stack([x, np.cross(touch.contact_normal, x), touch.contact_normal])


def surface_points_and_tangents(
    touch: GrooveContact, scene: RollingBalls, local: Array, *, curved: bool, depth: float = 0.0
) -> tuple[Array, Array]:
    """Compute points on the curved contact surface between ball and groove, and the unit tangents of the surface there.

    Parameters
    ----------
    touch : GrooveContact
        The contact.
    scene : RollingBalls
        The rolling balls.
    local : (n, 2) Array
        Coordinates of n points along the contact's axes x and y [m].
    curved : bool
        Whether the points lie on the surface that ball and groove share, whose curvature is the mean of both; otherwise
        they lie on the tangent plane.
    depth : float, default 0.0
        Depth of the contact's centre inside the undeformed ball [m].

    Returns
    -------
    points : (n, 3) Array
        Points relative to the ball's centre, in the ball's axes [m].
    tangents : (n, 2, 3) Array
        Unit tangents of the surface at each point, along x and y of the contact, in the ball's axes.
    """
    axes = contact_axes(touch, scene)
    bend = (1.0 / scene.ball_radius - 0.5 / np.array(touch.relative_radii)) * (1.0 if curved else 0.0)
    fall = 0.5 * (local**2 @ bend)
    points = (scene.ball_radius - depth) * axes[2] + local @ axes[:2] - fall[:, None] * axes[2]
    tangents = axes[None, :2] - (local * bend)[:, :, None] * axes[2]
    return points, tangents / np.linalg.norm(tangents, axis=2, keepdims=True)


def rolling_speed(touch: GrooveContact, scene: RollingBalls) -> float:
    """Compute the rolling speed of a ball on a groove: the speed at which material passes through the contact.

    Parameters
    ----------
    touch : GrooveContact
        The contact.
    scene : RollingBalls
        The rolling balls.

    Returns
    -------
    float
        Rolling speed [m/s].
    """
    field = scene.track.track_velocity_field(scene.ball_radius * touch.contact_normal)
    return float(np.linalg.norm((touch.groove_speed - scene.nominal_track_speed) * field))


def rigid_friction_contact(
    touch: GrooveContact, scene: RollingBalls, ball: int, normal: Array, local: Array, *, curved: bool, depth: float = 0.0
) -> FrictionContact:
    """Create the friction solver's input for a ball's contact with a groove, for rigid bodies.

    Parameters
    ----------
    touch : GrooveContact
        The contact.
    scene : RollingBalls
        The rolling balls.
    ball : int
        Index of the ball.
    normal : (n,) Array
        Normal forces [N].
    local : (n, 2) Array
        Coordinates of the normal forces along the contact's axes x and y [m].
    curved : bool
        Whether the contact lies on the curved surface that ball and groove share; otherwise it lies on the tangent plane.
    depth : float, default 0.0
        Depth of the contact's centre inside the undeformed ball [m].

    Returns
    -------
    FrictionContact
        The contact, for the friction solver.
    """
    points, tangents = surface_points_and_tangents(touch, scene, local, curved=curved, depth=depth)
    by_motions = velocities_by_ball_motions(scene.track, scene.ball_radius, points)
    rows = np.einsum("nck,nkm->cnm", tangents, by_motions).reshape(-1, MOTIONS)
    given = -touch.groove_speed * np.einsum("nck,nk->cn", tangents, scene.track.track_velocity_field(points)).ravel()
    limits, motions = scene.groove_friction_coefficient * normal, MOTIONS * ball + np.arange(MOTIONS)
    return FrictionContact(limits, np.zeros((0, 0)), rows, motions, given)


def elastic_friction_contact(
    touch: GrooveContact, scene: RollingBalls, ball: int, patch: GridContact, *, curved: bool, elastic_factor: float = 1.0
) -> FrictionContact:
    """Create the friction solver's input for a ball's contact with a groove, for elastic bodies on the contact's grid.

    Parameters
    ----------
    touch : GrooveContact
        The contact.
    scene : RollingBalls
        The rolling balls.
    ball : int
        Index of the ball.
    patch : GridContact
        Solution of the normal contact on the grid.
    curved : bool
        Whether the contact lies on the curved surface that ball and groove share; otherwise it lies on the tangent plane.
    elastic_factor : float, default 1.0
        Factor on the tangential compliance of the bodies.

    Returns
    -------
    FrictionContact
        The contact, for the friction solver.
    """
    normal, local, depth = patch.normal_forces, patch.cell_centres, elastic_factor * patch.depth_of_contact_centre
    rigid = rigid_friction_contact(touch, scene, ball, normal, local, curved=curved, depth=depth)
    speed = elastic_factor * rolling_speed(touch, scene)
    return replace(
        rigid,
        elastic_slip_matrix=speed * patch.elastic_slip_per_rolling_length,
        prescribed_slip=rigid.prescribed_slip + speed * patch.tangential_displacement_rate,
    )


# --- balls that touch: force and closing speed not negative and complementary, sliding friction at the point of contact
#
# Two balls of a track rotate in the same sense, so that where they touch they slide at about the full speed of their
# surfaces: the whole contact, some hundredths of a radius wide, slides in one direction, and is represented by a point.


def ball_to_ball_contact(
    one: int, two: int, frames: tuple[Array, Array], line: Array, track: TrackMotion, radius: float
) -> BallPairContact:
    """Create the contact of two touching neighbouring balls from their axes and the line between their centres.

    Parameters
    ----------
    one, two : int
        Indices of the balls.
    frames : tuple[Array, Array]
        Axes of each ball as rows, in common axes ``(3, 3)``.
    line : (3,) Array
        Unit vector from the centre of the first ball to that of the second, in common axes.
    track : TrackMotion
        Screw motion of the track.
    radius : float
        Radius of the balls [m].

    Returns
    -------
    BallPairContact
        The contact.
    """
    side = np.cross(line, np.eye(3)[int(np.argmin(np.abs(line)))])
    side /= np.linalg.norm(side)
    axes = np.stack([line, side, np.cross(line, side)])
    parts = []
    for frame, sign in zip(frames, (1.0, -1.0), strict=True):
        local = axes @ frame.T  # the three directions in the ball's axes
        at = sign * radius * local[0]
        parts.append(sign * (local @ velocities_by_ball_motions(track, radius, at[None])[0]))
    return BallPairContact(one, two, np.hstack(parts), axes, separating_speed=0.0)


@dataclass(frozen=True)
class BallEquilibrium:
    """Equilibrium of all balls under the forces between them, as equations f(y) for the friction solver.

    The equations give all generalised forces f on the balls' motions except friction at the grooves
    (`hifi.rolling.friction`). The unknowns y are the motions of all balls, then the force of each ball-to-ball contact [N].
    """

    #: Balls, contacts and friction coefficients.
    rolling_balls: RollingBalls
    #: Factor that converts closing speeds of neighbouring balls to forces in the contact condition between them [N s/m].
    force_per_closing_speed: float

    def __call__(self, y: Array) -> tuple[Array, Array]:
        """Evaluate the equations and their derivatives at motions and forces ``y`` (u,).

        Returns f ``(u,)``, the forces on each motion [N] and then the complementarity of each ball-to-ball contact [N], and
        df/dy ``(u, u)``.
        """
        mu, m = self.rolling_balls.ball_friction_coefficient, MOTIONS * len(self.rolling_balls.balls)
        f, S = np.zeros(y.size), np.zeros((y.size, y.size))
        for k, pair in enumerate(self.rolling_balls.ball_to_ball_contacts):
            i, row = pair.motion_indices, m + k
            force, speeds = float(y[row]), pair.closing_and_sliding_speeds(y)
            by_closing, by_sliding = pair.speeds_by_ball_motions[0], pair.speeds_by_ball_motions[1:]
            closing, slide = speeds[0] - pair.separating_speed, speeds[1:]
            size = float(np.linalg.norm(slide))
            unit = slide / size if size > 0.0 else slide
            turn = (np.eye(2) - np.outer(unit, unit)) / size if size > 0.0 else np.zeros((2, 2))
            along = by_closing + mu * unit @ by_sliding
            f[i] -= force * along
            S[i, row] -= along
            S[np.ix_(i, i)] -= force * mu * by_sliding.T @ turn @ by_sliding
            if force + self.force_per_closing_speed * closing > 0.0:
                f[row] = self.force_per_closing_speed * closing
                S[row, i] = self.force_per_closing_speed * by_closing
            else:
                f[row] = force
                S[row, row] = 1.0
        return f, S
