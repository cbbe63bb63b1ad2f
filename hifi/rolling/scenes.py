"""Scenes of a linear bearing, a ball screw and a ring for `hifi.rolling.balls`, and their contact loads.

The caller chooses the order of a ball's grooves and the sense of their directions. Contact angles and directions are
prescribed; contact loads are prescribed or solved here.

Contact forces between two rigid bodies with Hertz contacts, with rolling or without: each ball moves in the section of
its track, the inner body (screw, inner ring, carriage) by its free motions u, the outer one is fixed. The arc of groove i
has its centre at d_i from the ball's: with the ball displaced by p and the inner body by u,

    d_i = reach n_i + p - (rows u on the inner body's grooves),   approach_i = |d_i| - reach + interference_i,

and the forces C_i^(-3/2) approach_i^(3/2) along d_i are in equilibrium with the applied ones where the energy sum 2/5
C_i^(-3/2) approach_i^(5/2) - pull u - push p is least, with the applied forces pull on the inner body and push on the
balls. Contact angles follow the loads.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize, root

from rollbench.hifi.contact.hertz import solve_hertz
from rollbench.hifi.rolling import balls as rolling_balls
from rollbench.hifi.rolling import kinematics
from rollbench.meshes.arrays import Array
from rollbench.meshes.numerics import brentq


@dataclass(frozen=True)
class BallLayoutOnTrack:
    """Geometry and speeds of N rolling balls and of the k groove contacts of each ball."""

    #: Screw motion of the track, in the axes of every ball.
    track: kinematics.TrackMotion
    #: Axes of each ball as rows, in common axes ``(N, 3, 3)``.
    ball_axes: Array
    #: Two unit vectors that span the track's cross-section, in a ball's axes ``(2, 3)``.
    section_directions: Array
    #: Ball radius [m].
    ball_radius: float
    #: Groove radius [m].
    groove_radius: float
    #: Relative radii of curvature of ball and groove, along and across each of the k grooves ``(k, 2)`` [m].
    relative_radii: Array
    #: Speeds of the bodies with the grooves along the track ``(k,)`` [m/s on a straight track, rad/s on a ring or helix].
    groove_speeds: Array
    #: Nominal speed of the balls along the track [m/s on a straight track, rad/s on a ring or helix].
    nominal_track_speed: float
    #: Contacts between neighbouring balls.
    ball_to_ball_contacts: tuple[kinematics.BallPairContact, ...]


@dataclass(frozen=True)
class RollingMaterial:
    """Elastic constants of balls and grooves (one material), and coefficients of friction."""

    #: Young's modulus [Pa].
    young: float
    #: Poisson's ratio.
    poisson: float
    #: Coefficient of friction at the grooves.
    groove_friction_coefficient: float
    #: Coefficient of friction between balls.
    ball_friction_coefficient: float


def create_rolling_balls(
    layout: BallLayoutOnTrack, material: RollingMaterial, contact_normals: Array, loads: Array
) -> kinematics.RollingBalls:
    """Create the input of the rolling model from the positions of balls, and the directions and loads of their contacts.

    Parameters
    ----------
    layout : BallLayoutOnTrack
        Positions of balls and grooves.
    material : RollingMaterial
        Elastic material and friction.
    contact_normals : (N, k, 2) Array
        Unit vectors from each ball's centre to its k contacts, in the plane of the section.
    loads : (N, k) Array
        Contact loads [N].

    Returns
    -------
    RollingBalls
        The rolling balls.
    """
    balls = []
    for frame, n, force in zip(layout.ball_axes, contact_normals, loads, strict=True):
        touches = []
        for k, ((along, across), speed) in enumerate(zip(layout.relative_radii, layout.groove_speeds, strict=True)):
            bottom = _direction_to_groove_bottom(n, layout.groove_speeds, k) @ layout.section_directions
            normal = n[k] @ layout.section_directions
            touches.append(kinematics.GrooveContact(normal, float(force[k]), (along, across), float(speed), bottom))
        balls.append(kinematics.RollingBall(frame, tuple(touches)))
    m, speed, mutual = material, layout.nominal_track_speed, layout.ball_to_ball_contacts
    constants = m.young, m.poisson, m.groove_friction_coefficient, m.ball_friction_coefficient
    return kinematics.RollingBalls(layout.track, layout.ball_radius, *constants, speed, tuple(balls), mutual)


def _direction_to_groove_bottom(normals: Array, groove_speeds: Array, k: int) -> Array:
    """Return the unit vector from a ball's centre to the bottom of a groove, in the plane of the section ``(2,)``.

    ``k``: index of a contact with the groove. The vector lies between the contacts with both arcs of the groove.
    ``normals``: unit vectors to the c contacts of the ball (c, 2); ``groove_speeds``: speed of the body that each contact
    touches (c,), by which the two arcs of one body are recognised.
    """
    bottom = normals[groove_speeds == groove_speeds[k]].sum(axis=0)
    return np.asarray(bottom / np.linalg.norm(bottom))


def hertz_constants(layout: BallLayoutOnTrack, material: RollingMaterial) -> Array:
    """Compute the Hertz constant C of a ball's contact with each groove, for the approach C F^(2/3) under the force F.

    Parameters
    ----------
    layout : BallLayoutOnTrack
        Positions of balls and grooves, with the relative radii of the k grooves.
    material : RollingMaterial
        Elastic material.

    Returns
    -------
    (k,) Array
        Constants [m/N^(2/3)].
    """
    return np.array([solve_hertz(1.0, a, b, material.young, material.poisson).approach for a, b in layout.relative_radii])


# --- layouts


def place_balls_on_straight_track(
    radius: float, groove_radius: float, count: int, groove_moves: ArrayLike, speed: float, neighbours_may_touch: ArrayLike
) -> BallLayoutOnTrack:
    """Place balls in a row on a straight track along z (linear bearing); sections of the track lie in x and y.

    Parameters
    ----------
    radius, groove_radius : float
        Radii of balls and grooves [m].
    count : int
        Number of balls.
    groove_moves : (k,) array
        1 or True for each groove that moves, else 0.
    speed : float
        Speed of these grooves [m/s].
    neighbours_may_touch : (count - 1,) array
        1 or True for each pair of neighbouring balls that can touch, else 0.

    Returns
    -------
    BallLayoutOnTrack
        Positions of balls and grooves.
    """
    track = kinematics.TrackMotion(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    frames = np.repeat(np.eye(3)[None], count, axis=0)
    along = np.array([0.0, 0.0, 1.0])
    touching = np.flatnonzero(np.asarray(neighbours_may_touch)).tolist()
    axes = np.eye(3), np.eye(3)
    pairs = tuple(kinematics.ball_to_ball_contact(k, k + 1, axes, along, track, radius) for k in touching)
    radii = np.tile([radius, 1.0 / (1.0 / radius - 1.0 / groove_radius)], (np.size(groove_moves), 1))
    speeds = speed * np.asarray(groove_moves, float)
    return BallLayoutOnTrack(track, frames, np.eye(3)[:2], radius, groove_radius, radii, speeds, 0.5 * speed, pairs)


def relative_radius_along(radius: float, pitch_radius: float, lead_angle: float, outward: float) -> float:
    """Compute the relative radius of curvature of ball and groove along a helix or ring.

    Parameters
    ----------
    radius : float
        Ball radius [m].
    pitch_radius : float
        Pitch radius [m].
    lead_angle : float
        Lead angle [rad].
    outward : float
        Radial component of the unit vector from the ball's centre to the contact; negative on the screw.

    Returns
    -------
    float
        Relative radius of curvature [m].

    Examples
    --------
    >>> round(1e3 * relative_radius_along(2.778e-3, 16.5e-3, 0.19057395, -np.cos(np.pi / 4)), 3)  # mm, Lin's case 1
    2.458
    """
    return float(1.0 / (1.0 / radius - outward * np.cos(lead_angle) ** 2 / (pitch_radius + outward * radius)))


def place_balls_along_helix(
    radius: float,
    groove_radius: float,
    pitch_radius: float,
    lead: float,
    contact_angle: float,
    groove_sides: Array,
    groove_speeds: Array,
    count: int,
) -> BallLayoutOnTrack:
    """Place touching balls along a helix, in the axes of Lin (2019), section 3.4.1.

    The axes of a ball are x3, radially outward; y3, along the helix; and z3, across the helix.

    Parameters
    ----------
    radius, groove_radius, pitch_radius : float
        Radii of the balls, of the grooves and of the pitch circle [m].
    lead : float
        Lead of the helix [m]; negative: left-hand.
    contact_angle : float
        Contact angle [rad].
    groove_sides : (k,) Array
        -1 for the screw's grooves, 1 for the nut's.
    groove_speeds : (k,) Array
        Speeds of the grooves' bodies [rad/s].
    count : int
        Number of balls.

    Returns
    -------
    BallLayoutOnTrack
        Positions of balls and grooves.
    """
    rise = lead / (2.0 * np.pi)
    length, angle = float(np.hypot(pitch_radius, rise)), float(np.arctan2(rise, pitch_radius))
    track = kinematics.TrackMotion(np.array([0.0, np.sin(angle), np.cos(angle)]), np.array([0.0, length, 0.0]))

    def gap_of_neighbours(step: float) -> float:
        """Return the gap [m] between neighbouring balls whose azimuths differ by ``step`` [rad]."""
        return float(np.hypot(2.0 * pitch_radius * np.sin(0.5 * step), rise * step)) - 2.0 * radius

    step = float(brentq(gap_of_neighbours, 0.0, 0.5 * np.pi, xtol=1e-15)) if count > 1 else 0.0
    azimuth = (np.arange(count) - 0.5 * (count - 1)) * step
    frames = np.array([_ball_axes(phi, angle) for phi in azimuth])
    centres = np.stack([pitch_radius * np.cos(azimuth), pitch_radius * np.sin(azimuth), rise * azimuth], axis=1)
    pairs = []
    for k in range(count - 1):
        line = centres[k + 1] - centres[k]
        line = line / np.linalg.norm(line)
        pairs.append(kinematics.ball_to_ball_contact(k, k + 1, (frames[k], frames[k + 1]), line, track, radius))
    radii, section = (radius, groove_radius, pitch_radius), np.eye(3)[[0, 2]]
    relative, orbit = _relative_radii_and_orbit(radii, rise, contact_angle, groove_sides, groove_speeds)
    return BallLayoutOnTrack(track, frames, section, radius, groove_radius, relative, groove_speeds, orbit, tuple(pairs))


def _relative_radii_and_orbit(
    radii: tuple[float, float, float], rise: float, contact_angle: float, groove_sides: Array, groove_speeds: Array
) -> tuple[Array, float]:
    """Compute the relative radii of ball and grooves ``(k, 2)`` [m], and the nominal speed of the balls [rad/s].

    The track is a helix, or a ring. ``radii``: radii of the balls, of the grooves and of the pitch circle [m]; ``rise``:
    axial rise of the helix per angle of turn [m/rad], 0 for a ring; ``groove_sides``: -1 for grooves of the inner body, 1
    for those of the outer one (k,); ``groove_speeds``: speeds of the grooves' bodies (k,) [rad/s].
    """
    radius, groove_radius, pitch_radius = radii
    length, lead_angle = float(np.hypot(pitch_radius, rise)), float(np.arctan2(rise, pitch_radius))
    cos, across = np.cos(contact_angle), 1.0 / (1.0 / radius - 1.0 / groove_radius)
    relative = [[relative_radius_along(radius, pitch_radius, lead_angle, o * cos), across] for o in groove_sides]
    inner, outer = (float(np.mean(groove_speeds[groove_sides == o])) for o in (-1.0, 1.0))
    lever = radius * cos * np.cos(lead_angle) / length
    return np.array(relative), 0.5 * (outer + inner + lever * (outer - inner))


def _ball_axes(azimuth: float, angle: float) -> Array:
    """Return the axes x3, y3, z3 of a ball as rows in fixed coordinates ``(3, 3)`` (Lin 2019, eq. (3.62)).

    ``azimuth``: azimuth of the ball [rad]; ``angle``: lead angle [rad].
    """
    c, s, ca, sa = np.cos(azimuth), np.sin(azimuth), np.cos(angle), np.sin(angle)
    return np.array([[c, s, 0.0], [-ca * s, ca * c, sa], [sa * s, -sa * c, ca]])


def place_ball_in_ring(
    radius: float,
    groove_radius: float,
    pitch_radius: float,
    contact_angle: float,
    groove_sides: Array,
    groove_speeds: Array,
) -> BallLayoutOnTrack:
    """Place one ball in a ring bearing: x along its axis, y radially outward, z along the path (Lin 2019, section 3.2.1).

    Parameters
    ----------
    radius, groove_radius, pitch_radius : float
        Radii of the ball, of the grooves and of the pitch circle [m].
    contact_angle : float
        Contact angle [rad].
    groove_sides : (k,) Array
        -1 for the inner ring's grooves, 1 for the outer ring's.
    groove_speeds : (k,) Array
        Speeds of the grooves' bodies [rad/s].

    Returns
    -------
    BallLayoutOnTrack
        Position of the ball and its grooves.
    """
    track = kinematics.TrackMotion(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, pitch_radius]))
    radii = radius, groove_radius, pitch_radius
    axes, section = np.eye(3)[None], np.eye(3)[:2]
    relative, orbit = _relative_radii_and_orbit(radii, 0.0, contact_angle, groove_sides, groove_speeds)
    return BallLayoutOnTrack(track, axes, section, radius, groove_radius, relative, groove_speeds, orbit, ())


#: Number of Newton's steps that follow the search for the minimum of energy, and largest unbalanced force over the sum of
#: contact loads in an equilibrium.
POLISH, BALANCED = 30, 1e-9


@dataclass(frozen=True)
class StaticProblem:
    """Static contact problem of N balls with k grooves each, between a fixed outer and a movable inner body.

    The inner body (screw, inner ring, carriage) has m free motions: rigid-body motions that no support prevents.
    """

    #: Unit vectors from each ball's centre to its k contacts in the unloaded state, in the track's cross-section ``(N, k,
    #: 2)``.
    unloaded_normals: Array
    #: Groove radius less ball radius [m].
    radius_difference: float
    #: Interference of ball and groove in the undisplaced state ``(N, k)`` [m].
    interference: Array
    #: Hertz constants C of the contacts ``(N, k)`` [m/N^(2/3)], for the approach C F^(2/3).
    hertz_constants: Array
    #: Whether each of a ball's k grooves belongs to the inner body ``(k,)``.
    on_inner_body: NDArray[np.bool_]
    #: Displacement of the inner body in the track's cross-section at each ball, by a unit of each free motion
    #: ``(N, 2, m)``.
    inner_body_motions: Array
    #: Prescribed displacement of the inner body in the track's cross-section at each ball ``(N, 2)`` [m].
    inner_body_displacement: Array
    #: Applied forces on the inner body along its free motions ``(m,)`` [N].
    forces_on_inner_body: Array
    #: Applied forces on the balls in the track's cross-section ``(N, 2)`` [N].
    forces_on_balls: Array


@dataclass(frozen=True)
class StaticEquilibrium:
    """Contact forces and displacements in the static equilibrium of the balls and the inner body."""

    #: Contact forces of the N balls with their k grooves ``(N, k)`` [N].
    force: Array
    #: Unit vectors from each ball's centre to its k contacts, in the track's cross-section ``(N, k, 2)``.
    normal: Array
    #: Displacements of the balls in the track's cross-section ``(N, 2)`` [m].
    ball: Array
    #: Displacements of the inner body along its free motions ``(m,)`` [m].
    body: Array
    #: Ratio of the largest unbalanced force on a ball or the inner body to the sum of the contact loads.
    left: float

    @property
    def converged(self) -> bool:
        """Whether the contact forces and the applied forces are in equilibrium."""
        return self.left <= BALANCED


def solve_static_problem(problem: StaticProblem) -> StaticEquilibrium:
    """Solve the static equilibrium of balls and inner body (screw, inner ring or carriage) with Hertz contacts.

    Parameters
    ----------
    problem : StaticProblem
        The static problem.

    Returns
    -------
    StaticEquilibrium
        Contact forces and displacements; ``converged`` is False if there is no equilibrium.
    """
    N, pull = problem.unloaded_normals.shape[0], problem.forces_on_inner_body
    size = float(np.abs(pull).sum() + np.abs(problem.forces_on_balls).sum())
    stiff = problem.hertz_constants.mean()
    moved = (problem.interference, problem.inner_body_displacement)
    squeezed = float(sum(np.abs(x).max(initial=0.0) for x in moved))
    size = max(size, (squeezed / stiff) ** 1.5)
    unit = stiff * size ** (2.0 / 3.0)
    start = np.concatenate([np.zeros(2 * N), pull / size * 4.0])
    if pull.size:
        start[: 2 * N] = 0.5 * np.einsum("nim,m->ni", problem.inner_body_motions, start[2 * N :]).ravel()

    def scaled_energy_and_gradient(x: Array) -> tuple[float, Array]:
        e, g, _ = _energy_derivatives(problem, x * unit)
        return e / (size * unit), g / size

    def scaled_hessian(x: Array) -> Array:
        return np.asarray(_energy_derivatives(problem, x * unit)[2] * (unit / size)) + 1e-9 * np.eye(x.size)

    search = {"method": "trust-exact", "options": {"gtol": 1e-8, "maxiter": 500}}
    x = best = minimize(scaled_energy_and_gradient, start, jac=True, hess=scaled_hessian, **search).x
    for _ in range(POLISH):
        g = scaled_energy_and_gradient(x)[1]
        if np.linalg.norm(g) < np.linalg.norm(scaled_energy_and_gradient(best)[1]):
            best = x
        x = x - np.linalg.solve(scaled_hessian(x), g)
    force, normal, _ = _contact_forces_at_displacements(problem, best * unit)
    left = float(np.abs(scaled_energy_and_gradient(best)[1]).max()) * size / max(float(force.sum()), 1e-300)
    turned = (normal * problem.unloaded_normals).sum(axis=2) <= 0.0
    if np.any((force > 0.0) & turned):  # a ball that left its groove for the far side
        left = np.inf
    return StaticEquilibrium(force, normal, best[: 2 * N].reshape(N, 2) * unit, best[2 * N :] * unit, left)


def _contact_forces_at_displacements(problem: StaticProblem, x: Array) -> tuple[Array, Array, Array]:
    """Compute the contact forces of balls and grooves at given displacements of the balls and the inner body.

    x: displacements of the balls, then free motions of the inner body (2 N + m,) [m]. Returns the forces (N, k) [N], their
    directions (N, k, 2), and the distances (N, k) [m] of the centre of each groove's arc from the ball's centre.
    """
    N, reach = problem.unloaded_normals.shape[0], problem.radius_difference
    p, u = x[: 2 * N].reshape(N, 2), x[2 * N :]
    body = problem.inner_body_displacement
    if u.size:
        body = problem.inner_body_motions @ u + body
    d = reach * problem.unloaded_normals + p[:, None] - problem.on_inner_body[None, :, None] * body[:, None]
    length = np.linalg.norm(d, axis=2)
    approach = np.maximum(length - reach + problem.interference, 0.0)
    force = (approach / problem.hertz_constants) ** 1.5  # F = (approach / C)^(3/2) along d
    return force, d / length[:, :, None], length


def _energy_derivatives(problem: StaticProblem, x: Array) -> tuple[float, Array, Array]:
    """Compute the potential energy at given displacements of the balls and the inner body, with its two derivatives.

    x: displacements of the balls, then free motions of the inner body (2 N + m,) [m]. Returns the energy [J], its gradient
    (2 N + m,) [N] and its Hessian [N/m].
    """
    N, push, pull = len(problem.unloaded_normals), problem.forces_on_balls.ravel(), problem.forces_on_inner_body
    force, n, length = _contact_forces_at_displacements(problem, x)
    approach = problem.hertz_constants * np.cbrt(force) ** 2
    e = float((0.4 * force * approach).sum() - push @ x[: 2 * N] - pull @ x[2 * N :])
    g = np.concatenate([-push, -pull])
    H = np.zeros((x.size, x.size))
    stiff = np.divide(1.5 * force, approach, out=np.zeros_like(force), where=approach > 0.0)
    for i in range(N):
        for k in range(problem.on_inner_body.size):
            T = np.zeros((2, x.size))  # derivative of d by ball and inner body
            T[:, 2 * i : 2 * i + 2] = np.eye(2)
            if pull.size and problem.on_inner_body[k]:
                T[:, 2 * N :] = -problem.inner_body_motions[i]
            nn = np.outer(n[i, k], n[i, k])
            g += force[i, k] * (T.T @ n[i, k])
            # stiffness along the normal, and that of the force as d turns
            H += T.T @ (stiff[i, k] * nn + force[i, k] / length[i, k] * (np.eye(2) - nn)) @ T
    return e, g, H


# --- loads and rolling together: friction and neighbours push the balls across the track, which changes the contact loads


#: Accepted difference between the friction force and the one assumed for the loads, over the largest load.
AGREED = 1e-7

#: Options of Anderson's acceleration, which alternates solutions for contact loads and for friction.
SEARCH = {"fatol": 0.1 * AGREED, "maxiter": 40, "line_search": None, "jac_options": {"M": 4, "alpha": 1.0, "w0": 1e-6}}

#: Numbers of cells of the coarse grid on which loads and friction are brought together first.
COARSE = (10, 10)


def copy_with_fixed_inner_body(problem: StaticProblem, loads: StaticEquilibrium) -> StaticProblem:
    """Return a copy of a static problem in which the inner body is fixed in its position of equilibrium.

    Parameters
    ----------
    problem : StaticProblem
        The static problem.
    loads : StaticEquilibrium
        Equilibrium of that problem.

    Returns
    -------
    StaticProblem
        Static problem whose inner body has no free motions.
    """
    moved = problem.inner_body_motions @ loads.body if problem.forces_on_inner_body.size else 0.0
    motions = np.zeros((*problem.inner_body_motions.shape[:2], 0))
    return replace(
        problem,
        inner_body_displacement=problem.inner_body_displacement + moved,
        inner_body_motions=motions,
        forces_on_inner_body=np.zeros(0),
    )


def solve_loads_with_rolling(
    layout: BallLayoutOnTrack,
    material: RollingMaterial,
    problem: StaticProblem,
    choices: rolling_balls.RollingSettings,
    *,
    balls_may_touch: bool,
) -> tuple[StaticEquilibrium, bool]:
    """Solve contact loads and steady rolling together, as friction forces across the track change the contact loads.

    The inner body stays at its equilibrium without friction. The friction forces on the balls across the track are found by
    fixed-point iteration with Anderson's acceleration, first on a coarse grid.

    Parameters
    ----------
    layout : BallLayoutOnTrack
        Positions of balls and grooves.
    material : RollingMaterial
        Elastic material and friction.
    problem : StaticProblem
        The static problem.
    choices : RollingSettings
        Numerical settings of rolling.
    balls_may_touch : bool
        Whether neighbouring balls may touch each other.

    Returns
    -------
    loads : StaticEquilibrium
        Contact forces with friction.
    converged : bool
        Whether contact loads and friction forces are consistent to the tolerance `AGREED`, and both solutions converged.
    """
    loads = solve_static_problem(problem)
    held = copy_with_fixed_inner_body(problem, loads)
    scale, last = float(loads.force.max()), dict[tuple[int, int], rolling_balls.RollingResult]()

    def solve_with_forces_on_balls(
        push: Array, grid: rolling_balls.RollingSettings
    ) -> tuple[StaticEquilibrium, rolling_balls.RollingResult, Array]:
        pushed = solve_static_problem(replace(held, forces_on_balls=problem.forces_on_balls + push))
        scene = create_rolling_balls(layout, material, pushed.normal, pushed.force)
        loaded = [(b, k) for b, k, _ in rolling_balls.loaded_contacts(scene)]
        near = last.get(grid.grid_shape)  # from which the solver starts if the same contacts are loaded
        if near is not None and [(c.ball_index, c.contact_index) for c in near.contacts] != loaded:
            near = None
        scene = scene if balls_may_touch else replace(scene, ball_to_ball_contacts=())
        rolling = last[grid.grid_shape] = rolling_balls.solve_rolling(scene, grid, near)
        on_balls = rolling.groove_friction_wrenches[:, :3] + rolling.forces_by_neighbours
        return pushed, rolling, on_balls @ layout.section_directions.T

    def mismatch_of_forces_on_balls(push: Array, grid: rolling_balls.RollingSettings) -> Array:
        two = push.reshape(-1, 2) * scale
        return np.asarray((solve_with_forces_on_balls(two, grid)[2] - two).ravel() / scale)

    push = np.zeros(2 * len(problem.forces_on_balls))
    for shape in (COARSE, choices.grid_shape):
        grid = replace(choices, grid_shape=shape)
        push = root(lambda x, grid=grid: mismatch_of_forces_on_balls(x, grid), push, method="anderson", options=SEARCH).x
    pushed, rolling, force = solve_with_forces_on_balls(push.reshape(-1, 2) * scale, choices)
    agree = np.abs(force / scale - push.reshape(-1, 2)).max() <= AGREED
    return pushed, bool(agree and pushed.converged and rolling.converged)
