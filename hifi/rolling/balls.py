"""Rolling of balls with friction: steady motion with the forces between touching balls, and transient motion from rest.

Steady rolling: of a ball's six equations of equilibrium two fix its position in the section of the track, and with it the
contact loads, which are prescribed here (`hifi.rolling.scenes`). The other four fix its speed along the track and its
rotation. Friction forces across the track, which act in addition to the prescribed contact loads, are part of the result.

Rolling from rest: elastic displacements move along with the material, and gaps between balls close. In a step dt material
moves by V dt through every contact, so that

    s dt = A q(t) - A_shifted q(t - dt) + rigid slip dt,

with the slip s, the tangential compliance A and the tangential forces q. A_shifted gives the old displacements at the old
position of the material; nothing is interpolated. The method is of first order in the step. Contact forces are prescribed
and constant; the frame moves with each ball's centre.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from time import process_time

import numpy as np
from numpy.typing import NDArray

from rollbench.hifi.contact.hertz import solve_hertz
from rollbench.hifi.rolling import friction, kinematics
from rollbench.hifi.rolling import patch as rolling_patch
from rollbench.hifi.rolling.bodies import ContactGeometry, Sizes, compliance_kernel_of_contact, compute_and_cache_kernels
from rollbench.hifi.rolling.kinematics import MOTIONS, GrooveContact, RollingBalls
from rollbench.hifi.rolling.patch import ComplianceKernel, GridContact
from rollbench.meshes.arrays import Array

#: Ratio of the tangential compliance of nearly rigid bodies to that of the elastic ones.
NEARLY_RIGID = 0.01

#: Contact forces below this share of a ball's largest contact force count as zero.
NEGLIGIBLE = 1e-9

#: Points of the quadrature along each axis of the contact ellipse of rigid bodies: of the first solution, which gives
#: starting values, and of the last one.
FIRST, POINTS = 40, 300


@dataclass(frozen=True)
class RollingSettings:
    """Numerical settings of the rolling model: contact grids, elasticity, and meshes of finite bodies."""

    #: Numbers of cells of every contact's grid along and across the groove.
    grid_shape: tuple[int, int] = (24, 24)
    #: Factor on the tangential compliance of the bodies: 1 for elastic bodies, `NEARLY_RIGID` (0.01) for nearly rigid ones.
    elastic_factor: float = 1.0
    #: Whether friction acts on the curved surface that ball and groove share; otherwise it acts in its tangent plane.
    curved_contacts: bool = True
    #: Mesh settings of finite bodies; None: half-spaces.
    finite_bodies: Sizes | None = None


@dataclass(frozen=True)
class ContactFriction:
    """Tangential forces, slips and friction loss in the n cells of a ball's contact with a groove."""

    #: Index of the ball.
    ball_index: int
    #: Index of the contact among the ball's contacts with grooves.
    contact_index: int
    #: Centres of the cells along the contact's axes x and y ``(n, 2)`` [m].
    cell_centres: Array
    #: Lengths of a cell along x and y ``(2,)`` [m].
    cell_size: Array
    #: Normal forces of the cells ``(n,)`` [N].
    normal_forces: Array
    #: Tangential forces of the groove on the ball in the cells ``(n, 2)`` [N].
    tangential_forces: Array
    #: Slips of the ball past the groove in the cells ``(n, 2)`` [m/s].
    slips: Array
    #: Whether each cell sticks, that is does not slip ``(n,)``.
    sticks: NDArray[np.bool_]
    #: Unit vectors of the contact's axes x, y and normal as rows, in the ball's axes ``(3, 3)``.
    axes: Array
    #: Power dissipated by friction in the contact [W].
    friction_loss: float
    #: Power dissipated by the error of the finite differences along the flow of material [W].
    numerical_dissipation: float


@dataclass(frozen=True)
class RollingResult:
    """Steady rolling of N balls with M contacts between balls: motions, friction forces and losses."""

    #: Speeds of the balls along the track ``(N,)`` [m/s on a straight track, rad/s on a ring or helix].
    track_speeds: Array
    #: Angular velocities of the balls, in each ball's axes ``(N, 3)`` [rad/s].
    rotations: Array
    #: Normal forces between balls ``(M,)`` [N].
    ball_to_ball_forces: Array
    #: Friction losses at the contacts between balls ``(M,)`` [W].
    ball_to_ball_losses: Array
    #: Force, and moment about the ball's centre, that friction at the grooves exerts on every ball, in the ball's axes
    #: ``(N, 6)`` [N, N m].
    groove_friction_wrenches: Array
    #: Force that neighbouring balls exert on every ball, in the ball's axes ``(N, 3)`` [N].
    forces_by_neighbours: Array
    #: Power that the moving grooves put into the balls [W].
    driving_power: float
    #: Friction in every loaded contact of a ball with a groove.
    contacts: tuple[ContactFriction, ...]
    #: "converged", or the reason why the solution did not converge.
    status: str
    #: Residual of the friction solver: `FrictionSolution.residual`.
    residual: float
    #: Processor time of the solution [s].
    cpu_seconds: float
    #: Full solution of the friction solver: forces, slips and motions.
    friction_solution: friction.FrictionSolution

    @property
    def converged(self) -> bool:
        """Whether friction law and equilibrium are satisfied."""
        return self.status == "converged"

    @property
    def groove_losses(self) -> Array:
        """Friction losses at every loaded contact with a groove, in the order of ``contacts`` [W]."""
        return np.array([c.friction_loss for c in self.contacts])

    @property
    def friction_loss(self) -> float:
        """All friction losses, at grooves and between balls [W]."""
        return sum(c.friction_loss for c in self.contacts) + float(self.ball_to_ball_losses.sum())

    @property
    def numerical_dissipation(self) -> float:
        """Spurious power that the upwind finite differences along the rolling direction dissipate in all contacts [W]."""
        return sum(c.numerical_dissipation for c in self.contacts)


@lru_cache(maxsize=16)
def solve_half_space_contact_under_1_N(
    radii: tuple[float, float], young: float, poisson: float, shape: tuple[int, int]
) -> GridContact:
    """Solve the contact of two half-spaces under 1 N on a grid of cells, and compute its elastic slip per rolling length.

    ``radii``: relative radii along and across the groove [m]; ``shape``: numbers of cells along and across. The contact
    under any other force is similar, with lengths in proportion to the cube root of the force.
    """
    patch = rolling_patch.solve_elastic_contact_on_grid(1.0, radii, young, poisson, shape)
    assert patch.elastic_slip_per_rolling_length.size
    return patch


@lru_cache(maxsize=64)
def solve_finite_body_contact(
    load: float, radii: tuple[float, float], material: tuple[float, float], shape: tuple[int, int], kernel: ComplianceKernel
) -> GridContact:
    """Solve the normal contact of two finite bodies on a grid of cells.

    ``load``: contact force [N]; ``radii``: relative radii along and across the groove [m]; ``material``: Young's modulus
    [Pa] and Poisson's ratio; ``shape``: numbers of cells along and across; ``kernel``: compliance of the finite bodies
    less that of half-spaces.
    """
    return rolling_patch.solve_elastic_contact_on_grid(load, radii, *material, shape, kernel)


def solve_normal_contact_with_groove(scene: RollingBalls, touch: GrooveContact, choices: RollingSettings) -> GridContact:
    """Solve the normal contact of a ball with a groove on a grid of cells, under the contact's prescribed force.

    ``scene``: the rolling balls; ``touch``: the contact of one of them with a groove; ``choices``: numerical settings.
    Raises ValueError if the direction to the groove's bottom is unknown, or a finite body has no room for the contact
    zone.
    """
    kernel = finite_body_kernel_at_contact(scene, touch, choices.finite_bodies)
    if kernel is None:
        unit = solve_half_space_contact_under_1_N(touch.relative_radii, scene.young, scene.poisson, choices.grid_shape)
        return unit.similar_contact(float(np.cbrt(touch.contact_force)), touch.contact_force)
    material = scene.young, scene.poisson
    return solve_finite_body_contact(touch.contact_force, touch.relative_radii, material, choices.grid_shape, kernel)


def finite_body_kernel_at_contact(
    scene: RollingBalls, touch: GrooveContact, bodies: Sizes | None
) -> ComplianceKernel | None:
    """Compute the contact compliance of finite bodies less that of half-spaces (kernel), in the axes of a contact.

    Parameters
    ----------
    scene : RollingBalls
        The rolling balls.
    touch : GrooveContact
        The contact.
    bodies : Sizes | None
        Mesh settings of finite bodies; None: half-spaces.

    Returns
    -------
    ComplianceKernel | None
        The kernel; None if ``bodies`` is None.

    Raises
    ------
    ValueError
        The direction to the groove's bottom is unknown, or the groove, ring or nut has no room for the contact zone or for
        a patch.
    """
    if bodies is None:
        return None
    at, bottom = position_of_contact_on_groove(scene, touch)
    kernel = compliance_kernel_of_contact(at, _largest_groove_contact_load(scene), scene.young, scene.poisson, bodies)
    axes = kinematics.contact_axes(touch, scene)
    return kernel if axes[1] @ bottom > 0.0 else kernel.rotated_by_half_turn


def cache_kernels_of_scenes(scenes: Sequence[RollingBalls], bodies: Sizes | None, processes: int) -> float:
    """Compute and cache the compliance kernels of finite bodies for several scenes of one material, in several processes.

    See `hifi.rolling.bodies.compute_and_cache_kernels`.

    Parameters
    ----------
    scenes : Sequence[RollingBalls]
        Rolling balls of each scene.
    bodies : Sizes | None
        Mesh settings of finite bodies; None: half-spaces, for which nothing is computed.
    processes : int
        Number of processes.

    Returns
    -------
    float
        Processor time of the kernels that were computed [s].
    """
    if bodies is None:
        return 0.0
    each = [(s, touch) for s in scenes for _, _, touch in loaded_contacts(s)]
    contacts = [(position_of_contact_on_groove(s, touch)[0], _largest_groove_contact_load(s)) for s, touch in each]
    return compute_and_cache_kernels(contacts, scenes[0].young, scenes[0].poisson, bodies, processes)


def _largest_groove_contact_load(scene: RollingBalls) -> float:
    """Return the largest contact force between any ball and a groove [N]."""
    return max(t.contact_force for b in scene.balls for t in b.groove_contacts)


def position_of_contact_on_groove(scene: RollingBalls, touch: GrooveContact) -> tuple[ContactGeometry, Array]:
    """Return where a ball touches its groove (radii, angle, path), and the direction to the bottom of the groove.

    Parameters
    ----------
    scene : RollingBalls
        The balls.
    touch : GrooveContact
        The contact.

    Returns
    -------
    place : ContactGeometry
        Position of the contact, for `hifi.rolling.bodies.compliance_kernel_of_contact`.
    bottom : (3,) Array
        Unit vector from the ball's centre to the bottom of the groove.

    Raises
    ------
    ValueError
        The direction to the groove's bottom is unknown.
    """
    bottom = touch.direction_to_groove_bottom
    if bottom is None:
        raise ValueError(
            "the direction from the ball's centre to the bottom of the groove is missing: contacts of finite bodies need it"
        )
    angle = float(np.arccos(touch.contact_normal @ bottom))
    return ContactGeometry(scene.ball_radius, touch.relative_radii, angle, scene.track.path_radius_and_rise), bottom


def loaded_contacts(scene: RollingBalls) -> list[tuple[int, int, GrooveContact]]:
    """List the loaded contacts of all balls with grooves.

    Parameters
    ----------
    scene : RollingBalls
        The rolling balls.

    Returns
    -------
    list[tuple[int, int, GrooveContact]]
        For each contact whose force exceeds `NEGLIGIBLE` times the ball's largest contact force: the index of the ball, the
        index of the contact among the ball's contacts with grooves, and the contact.
    """
    out = []
    for b, ball in enumerate(scene.balls):
        least = NEGLIGIBLE * max((t.contact_force for t in ball.groove_contacts), default=0.0)
        out += [(b, k, t) for k, t in enumerate(ball.groove_contacts) if t.contact_force > least]
    return out


def prepare_friction_contacts(scene: RollingBalls, choices: RollingSettings) -> list[friction.FrictionContact]:
    """Create the input of the friction solver for all loaded contacts of elastic balls with grooves.

    Parameters
    ----------
    scene : RollingBalls
        The balls.
    choices : RollingSettings
        Numerical settings.

    Returns
    -------
    list[FrictionContact]
        Contacts in the order of `loaded_contacts`.
    """
    out, curved, elastic = [], choices.curved_contacts, choices.elastic_factor
    for b, _, touch in loaded_contacts(scene):
        patch = solve_normal_contact_with_groove(scene, touch, choices)
        out.append(kinematics.elastic_friction_contact(touch, scene, b, patch, curved=curved, elastic_factor=elastic))
    return out


def equilibrium_equations_of_balls(
    scene: RollingBalls, contacts: Sequence[friction.FrictionContact]
) -> kinematics.BallEquilibrium:
    """Create the equilibrium equations of all balls for the friction solver.

    Parameters
    ----------
    scene : RollingBalls
        The balls.
    contacts : Sequence[FrictionContact]
        Loaded contacts of the balls, as from `prepare_friction_contacts`.

    Returns
    -------
    kinematics.BallEquilibrium
        Equilibrium of the forces and moments on the balls, and the condition that two neighbouring balls either touch or
        exert no force on each other.
    """
    bound = max(float(c.friction_limits.sum()) for c in contacts)
    return kinematics.BallEquilibrium(scene, bound / max(float(np.abs(c.prescribed_slip).max()) for c in contacts))


def split_motions_and_forces(scene: RollingBalls, y: Array) -> tuple[Array, Array, Array]:
    """Split the friction solver's vector of unknowns into speeds and rotations of the balls and forces between balls.

    Parameters
    ----------
    scene : RollingBalls
        The N rolling balls, with M contacts between balls.
    y : (4 N + M,) Array
        Unknowns of `hifi.rolling.kinematics.BallEquilibrium`: the motions of each ball as speeds [m/s], then the forces
        between balls [N].

    Returns
    -------
    speed : (N,) Array
        Speeds of the balls along the track [m/s on a straight track, rad/s on a ring or helix].
    rotation : (N, 3) Array
        Rotations of the balls about their axes [rad/s].
    force : (M,) Array
        Normal forces between balls [N].
    """
    count = MOTIONS * len(scene.balls)
    motions = y[:count].reshape(-1, MOTIONS)
    return motions[:, 0] / scene.track.centre_speed, motions[:, 1:] / scene.ball_radius, y[count:].copy()


def ball_contact_losses(scene: RollingBalls, y: Array) -> Array:
    """Compute the losses of sliding friction at the M contacts between balls ``(M,)`` [W].

    ``y``: motions of all balls and forces between them, as in `split_motions_and_forces`.
    """
    pairs = zip(split_motions_and_forces(scene, y)[2], scene.ball_to_ball_contacts, strict=True)
    mu = scene.ball_friction_coefficient
    return np.array([mu * f * float(np.linalg.norm(m.closing_and_sliding_speeds(y)[1:])) for f, m in pairs])


def estimate_starting_unknowns(scene: RollingBalls) -> Array:
    """Estimate starting values of the friction solver's unknowns for N balls with M mutual contacts ``(4 N + M,)``.

    Order and units of these unknowns are those of `split_motions_and_forces`. Each ball moves at its nominal speed along
    the track and rotates so that its contacts with grooves slide least; the forces between balls are zero.
    """
    y = np.zeros(MOTIONS * len(scene.balls) + len(scene.ball_to_ball_contacts))
    for b, ball in enumerate(scene.balls):
        y[MOTIONS * b] = scene.nominal_track_speed * scene.track.centre_speed
        rows, driven = [], []
        for t in ball.groove_contacts:
            if t.contact_force > 0.0:
                at = scene.ball_radius * t.contact_normal
                turn = np.cross(np.eye(3), at).T / scene.ball_radius
                rows.append(turn * t.contact_force)
                ride = t.groove_speed - scene.nominal_track_speed
                driven.append(ride * scene.track.track_velocity_field(at) * t.contact_force)
        turning = np.linalg.lstsq(np.vstack(rows), np.concatenate(driven), rcond=1e-10)[0]
        y[MOTIONS * b + 1 : MOTIONS * (b + 1)] = turning
    return y


def solve_rolling(
    scene: RollingBalls,
    choices: RollingSettings | None = None,
    start_result: RollingResult | None = None,
    smoothing_ratios: tuple[float, ...] = friction.PATH,
) -> RollingResult:
    """Solve steady rolling of balls under prescribed contact loads.

    Parameters
    ----------
    scene : RollingBalls
        The balls and their contact loads.
    choices : RollingSettings | None, default None
        Numerical settings; None: the defaults of `RollingSettings`.
    start_result : RollingResult | None, default None
        Solution on the same grid, whose motions and forces are the starting values; None: estimated starting values.
    smoothing_ratios : tuple[float, ...], default PATH
        Slip speeds by which Coulomb's law is smoothed in successive solutions, divided by the largest slip, in descending
        order, as for `hifi.rolling.friction.solve_friction`.

    Returns
    -------
    RollingResult
        The solution.

    Raises
    ------
    ValueError
        A ball has no loaded contact.
    """
    begin, choices = process_time(), choices or RollingSettings()
    if any(max((t.contact_force for t in b.groove_contacts), default=0.0) <= 0.0 for b in scene.balls):
        raise ValueError(
            "a ball has no loaded contact with a groove, and so no steady motion: every ball needs a contact force > 0"
        )
    contacts = prepare_friction_contacts(scene, choices)
    balance = equilibrium_equations_of_balls(scene, contacts)
    near = None if start_result is None else start_result.friction_solution
    y, q = (estimate_starting_unknowns(scene), None) if near is None else (near.motions, near.forces)
    solution = friction.solve_friction(contacts, balance, y, q, smoothing_ratios)
    return _collect_rolling_result(scene, choices, contacts, solution, process_time() - begin)


def _collect_rolling_result(
    scene: RollingBalls,
    choices: RollingSettings,
    contacts: Sequence[friction.FrictionContact],
    solution: friction.FrictionSolution,
    seconds: float,
) -> RollingResult:
    """Collect the motions, forces and losses of all balls from the solution of the friction solver.

    ``contacts``: contacts of the friction solver, in the order of `loaded_contacts`; ``seconds``: processor time of the
    solution [s].
    """
    speed, rotation, force = split_motions_and_forces(scene, solution.motions)
    outs, power, wrench = [], 0.0, np.zeros((len(scene.balls), 6))
    for (b, i, t), c, q, s, stick in zip(
        loaded_contacts(scene), contacts, solution.forces, solution.slips, solution.stick, strict=True
    ):
        patch = solve_normal_contact_with_groove(scene, t, choices)
        at, curved, depth = patch.cell_centres, choices.curved_contacts, patch.depth_of_contact_centre
        depth *= choices.elastic_factor
        points, tangents = kinematics.surface_points_and_tangents(t, scene, at, curved=curved, depth=depth)
        on_ball = np.einsum("nck,cn->nk", tangents, q.reshape(2, -1))
        wrench[b, :3] += on_ball.sum(axis=0)
        wrench[b, 3:] += np.cross(points, on_ball).sum(axis=0)
        power -= float(q @ c.prescribed_slip)
        pull, slip, axes = q.reshape(2, -1).T, s.reshape(2, -1).T, kinematics.contact_axes(t, scene)
        loss, upwind = -float(q @ s), float(q @ (c.elastic_slip_matrix @ q))
        normal = patch.normal_forces
        outs.append(ContactFriction(b, i, at, patch.cell_size, normal, pull, slip, stick, axes, loss, upwind))
    between = np.zeros((len(scene.balls), 3))
    for f, m in zip(force, scene.ball_to_ball_contacts, strict=True):
        slide = m.closing_and_sliding_speeds(solution.motions)[1:]
        pulls = m.force_on_first_ball(float(f), scene.ball_friction_coefficient, slide)
        for ball, sign in ((m.first_ball, 1.0), (m.second_ball, -1.0)):
            between[ball] += sign * (scene.balls[ball].axes @ pulls)
    rub, how = ball_contact_losses(scene, solution.motions), (solution.status, solution.residual)
    return RollingResult(speed, rotation, force, rub, wrench, between, power, tuple(outs), *how, seconds, solution)


def hertz_semi_axes(scene: RollingBalls, touch: GrooveContact) -> tuple[float, float]:
    """Compute the semi-axes of the Hertzian contact ellipse between a ball and a groove.

    Parameters
    ----------
    scene : RollingBalls
        The balls.
    touch : GrooveContact
        The contact.

    Returns
    -------
    tuple[float, float]
        Semi-axes along and across the groove [m].
    """
    ellipse = solve_hertz(touch.contact_force, *touch.relative_radii, scene.young, scene.poisson)
    return ellipse.semi_x, ellipse.semi_y


# --- the rigid limit: no tangential compliance, Coulomb friction under Hertz's pressure by fine quadrature
#
# A grid changes a solution by the size of its cells, by its staircase edge, and by a point without slip that lies within a
# cell. These errors are nearly the same for nearly rigid bodies as for elastic ones, and cancel in
#
#     result = grid(elastic) - grid(nearly rigid) + limit,
#
# where "limit" is the solution for rigid bodies by fine quadrature, without a grid.


@dataclass(frozen=True)
class RigidRollingResult:
    """Steady rolling of N rigid balls with M contacts between balls: motions, forces and losses."""

    #: Speeds of the balls along the track ``(N,)`` [m/s on a straight track, rad/s on a ring or helix].
    track_speeds: Array
    #: Angular velocities of the balls, in each ball's axes ``(N, 3)`` [rad/s].
    rotations: Array
    #: Normal forces between balls ``(M,)`` [N].
    ball_to_ball_forces: Array
    #: Friction losses at every loaded contact with a groove, in the order of `loaded_contacts` [W].
    groove_losses: Array
    #: Friction losses at the contacts between balls ``(M,)`` [W].
    ball_to_ball_losses: Array
    #: Error left by the smoothing of Coulomb's law, over the largest slip (see
    #: `hifi.rolling.friction.solve_rigid_friction`).
    smoothing_error: float

    @property
    def friction_loss(self) -> float:
        """All friction losses, at grooves and between balls [W]."""
        return float(self.groove_losses.sum() + self.ball_to_ball_losses.sum())


def quadrature_of_unit_disk(points: int) -> tuple[Array, Array]:
    """Build a quadrature rule for the unit disk: midpoint rules in angles t with x = cos(t), and likewise for y.

    Parameters
    ----------
    points : int
        Number of points along each axis.

    Returns
    -------
    at : (points^2, 2) Array
        Coordinates x, y of the quadrature points.
    weights : (points^2,) Array
        Weights of the points; their sum is the area of the disk.

    Examples
    --------
    >>> f"{quadrature_of_unit_disk(40)[1].sum():.3f}"  # pi
    '3.142'
    """
    t = (np.arange(points) + 0.5) / points * np.pi
    u, w = np.cos(t), np.sin(t) * np.pi / points
    x, v = np.meshgrid(u, u, indexing="ij")
    weight = np.outer(w * np.sqrt(1.0 - u**2), w)
    return np.stack([x.ravel(), (v * np.sqrt(1.0 - x**2)).ravel()], axis=1), weight.ravel()


def solve_rigid_rolling(
    scene: RollingBalls, points: int = POINTS, *, curved: bool = True, bodies: Sizes | None = None
) -> RigidRollingResult:
    """Solve steady rolling of balls without tangential elasticity, with Coulomb friction under Hertz's pressures.

    Parameters
    ----------
    scene : RollingBalls
        The balls and their contact loads.
    points : int, default POINTS
        Number of quadrature points along each axis of a contact ellipse.
    curved : bool, default True
        Whether friction acts on the curved surface that ball and groove share; otherwise it acts in its tangent plane.
    bodies : Sizes | None, default None
        Mesh settings of finite bodies; None: half-spaces. The relative radii at each contact are replaced by those with
        which half-spaces have an equivalent contact (`hifi.rolling.patch.equivalent_half_space_radii`).

    Returns
    -------
    RigidRollingResult
        The solution.

    Raises
    ------
    ValueError
        The solver finds no equilibrium of the balls.
    """
    y = estimate_starting_unknowns(scene)
    for count in (FIRST, points):
        contacts = _prepare_rigid_contacts(scene, count, curved, bodies)
        path = friction.PATH if count == FIRST else friction.PATH[-2:]
        y, remainder = friction.solve_rigid_friction(contacts, equilibrium_equations_of_balls(scene, contacts), y, path)
    slips = [(c.friction_limits, c.rigid_slip(y)) for c in contacts]
    loss = np.array([-float(friction.coulomb_friction_forces(limits, s) @ s) for limits, s in slips])
    return RigidRollingResult(*split_motions_and_forces(scene, y), loss, ball_contact_losses(scene, y), remainder)


def _prepare_rigid_contacts(
    scene: RollingBalls, points: int, curved: bool, bodies: Sizes | None
) -> list[friction.FrictionContact]:
    """Create the input of the friction solver for all loaded contacts of rigid bodies, with Hertz's pressure by quadrature.

    ``points``: number of quadrature points along each axis of an ellipse; the other arguments are those of
    `solve_rigid_rolling`.
    """
    (unit, weight), material, contacts = quadrature_of_unit_disk(points), (scene.young, scene.poisson), []
    for b, _, touch in loaded_contacts(scene):
        force, kernel = touch.contact_force, finite_body_kernel_at_contact(scene, touch, bodies)
        radii = rolling_patch.equivalent_half_space_radii(force, touch.relative_radii, *material, kernel)
        ellipse = solve_hertz(force, *radii, *material)
        semi = np.array([ellipse.semi_x, ellipse.semi_y])
        local = unit * semi
        normal = ellipse.pressure(local[:, 0], local[:, 1]) * weight * semi.prod()
        normal *= force / normal.sum()
        contacts.append(kinematics.rigid_friction_contact(touch, scene, b, normal, local, curved=curved))
    return contacts


#: Largest distance from the zone's centre at which the kernel of finite bodies is valid, over the zone's half length.
REACH = 1.2


@dataclass(frozen=True)
class MotionFromRest:
    """Rolling from rest of N balls with M ball-to-ball contacts, in T time steps."""

    #: Times of the ends of the steps ``(T,)`` [s].
    times: Array
    #: Speeds of the balls along the track ``(T, N)`` [m/s on a straight track, rad/s on a ring or helix].
    track_speeds: Array
    #: Angular velocities of the balls, in each ball's axes ``(T, N, 3)`` [rad/s].
    rotations: Array
    #: Normal forces between balls ``(T, M)`` [N].
    ball_to_ball_forces: Array
    #: Gaps between balls ``(T, M)`` [m].
    ball_to_ball_gaps: Array
    #: Power lost by friction, and by the impact of balls in the step in which they meet ``(T,)`` [W].
    losses: Array
    #: Power that the moving grooves put into the balls ``(T,)`` [W].
    driving_power: Array
    #: Part of ``driving_power`` that is stored as elastic energy or dissipated by the error of the time steps ``(T,)`` [W].
    stored_power: Array
    #: Processor time of the simulation [s].
    cpu_seconds: float
    #: "converged", or the first time step that did not converge, with the reason.
    status: str

    @property
    def converged(self) -> bool:
        """Whether all time steps have converged."""
        return self.status == "converged"


@dataclass(frozen=True)
class _ContactWithoutHistory:
    """Contact for the friction solver in one time step, without the displacements that the preceding step left."""

    #: Input of the friction solver for the contact between rigid bodies.
    contact: friction.FrictionContact
    #: Tangential displacements by unit forces, divided by the duration of the step, at the points where the material is at
    #: the end of the step ``(2 n, 2 n)`` [m/s/N].
    displacement_at_present_place: Array
    #: Tangential displacements by unit forces, divided by the duration of the step, at the points where the same material
    #: was at the beginning of the step ``(2 n, 2 n)`` [m/s/N].
    displacement_at_previous_place: Array

    def add_displacements_of_last_step(self, forces: Array) -> friction.FrictionContact:
        """Return the friction solver's input for a time step, with the displacements that the last step's forces left.

        ``forces``: tangential forces at the end of the last step, all x and then all y (2 n,) [N].
        """
        return replace(
            self.contact,
            elastic_slip_matrix=self.displacement_at_present_place,
            prescribed_slip=self.contact.prescribed_slip - self.displacement_at_previous_place @ forces,
        )

    def stored_power(self, before: Array, after: Array) -> float:
        """Compute the power [W] that is stored as elastic energy or dissipated by the error of the time step.

        ``before``, ``after``: tangential forces at the beginning and at the end of the step (2 n,) [N].
        """
        moved = self.displacement_at_present_place @ after - self.displacement_at_previous_place @ before
        return float(after @ moved)


def compute_motion_from_rest(
    scene: RollingBalls, duration: float, steps: int, gap: float = 0.0, choices: RollingSettings | None = None
) -> MotionFromRest:
    """Compute the motion of balls that start from rest, with friction and elastic displacements, in equal time steps.

    Parameters
    ----------
    scene : RollingBalls
        The balls and their contact loads.
    duration : float
        Simulated time from rest [s].
    steps : int
        Number of time steps.
    gap : float, default 0.0
        Gap between neighbouring balls at the beginning [m].
    choices : RollingSettings | None, default None
        Numerical settings; None: the defaults of `RollingSettings`.

    Returns
    -------
    MotionFromRest
        Motions, forces and losses at the end of every step.

    Raises
    ------
    ValueError
        Duration or number of steps is not positive, the gap is negative, or a step carries material from outside the
        contact zone of finite bodies.
    """
    if not duration > 0.0 or steps < 1 or gap < 0.0:
        raise ValueError(
            f"rolling from rest got a duration of {duration} s, {steps} steps and a gap of {gap} m; "
            "allowed: a duration > 0, at least 1 step, and a gap >= 0"
        )
    begin, choices = process_time(), choices or RollingSettings()
    dt, mutual = duration / steps, scene.ball_to_ball_contacts
    carried = _prepare_contacts_without_history(scene, choices, dt)
    forces = [np.zeros(c.contact.prescribed_slip.size) for c in carried]
    y, gaps, status = estimate_starting_unknowns(scene), np.full(len(mutual), gap), "converged"
    out: list[tuple[Array, Array, Array, Array, float, float, float]] = []
    for step in range(steps):
        meetings = tuple(replace(m, separating_speed=float(g) / dt) for m, g in zip(mutual, gaps, strict=True))
        contacts = [c.add_displacements_of_last_step(q) for c, q in zip(carried, forces, strict=True)]
        balance = equilibrium_equations_of_balls(replace(scene, ball_to_ball_contacts=meetings), contacts)
        solution = friction.solve_friction(contacts, balance, y, forces)
        if not solution.converged:
            status = f"step {step + 1}: {solution.status}"
            break
        y, old, forces = solution.motions, forces, solution.forces
        closing = np.array([float(m.speeds_by_ball_motions[0] @ y[m.motion_indices]) for m in mutual])
        gaps = np.maximum(gaps - dt * closing, 0.0)
        speed, rotation, press = split_motions_and_forces(scene, y)
        loss = -sum(float(q @ s) for q, s in zip(forces, solution.slips, strict=True))
        loss += float(ball_contact_losses(scene, y).sum())
        loss += sum(float(f) * float(v) for f, v in zip(press, closing, strict=True))
        power = -sum(float(q @ c.contact.prescribed_slip) for q, c in zip(forces, carried, strict=True))
        stored = sum(c.stored_power(before, q) for c, before, q in zip(carried, old, forces, strict=True))
        out.append((speed, rotation, press, gaps, loss, power, stored))
    columns = (np.array([row[k] for row in out], dtype=float) for k in range(7))
    speeds, rotations, forces_between, gaps_left, losses, driving, stores = columns
    times = np.asarray(dt * (1.0 + np.arange(len(out))))
    seconds = process_time() - begin
    return MotionFromRest(times, speeds, rotations, forces_between, gaps_left, losses, driving, stores, seconds, status)


def _prepare_contacts_without_history(
    scene: RollingBalls, choices: RollingSettings, dt: float
) -> list[_ContactWithoutHistory]:
    """Prepare all loaded contacts for time steps, without the displacements that the forces of the preceding step left.

    ``dt``: length of a step [s].
    """
    out = []
    for (_, _, touch), contact in zip(loaded_contacts(scene), prepare_friction_contacts(scene, choices), strict=True):
        patch = solve_normal_contact_with_groove(scene, touch, choices)
        shift = kinematics.rolling_speed(touch, scene) * dt
        kernel, farthest = patch.finite_body_kernel, float(patch.cell_centres[:, 0].max()) + shift
        if kernel is not None and farthest > REACH * kernel.coordinate_scales[0]:
            raise ValueError(
                "in one time step, material enters a contact from outside the zone in which the compliance of the finite "
                "bodies is known: use shorter time steps, or half-spaces"
            )
        share = choices.elastic_factor / dt
        here, before = share * patch.tangential_compliance(), share * patch.tangential_compliance(shift)
        out.append(_ContactWithoutHistory(contact, here, before))
    return out
