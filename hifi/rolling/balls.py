"""Rolling of balls with friction: steady motion with the forces between touching balls, and motion from rest in time.

Steady rolling: of a ball's six equations of equilibrium two fix its position in the section of the track, and with it the
contact loads, which are prescribed here (`hifi.rolling.scenes`). The other four fix its speed along the track and its
rotation. Forces across the track that friction adds to the prescribed ones are part of the result.

Rolling from rest: elastic displacements move along with the material, and gaps between balls close. In a step dt material
moves by V dt through every contact, so that

    s dt = A q(t) - A_shifted q(t - dt) + rigid slip dt,

where A_shifted gives the old displacements at the old place of the material; nothing is interpolated. The method is of
first order in the step. Contact forces are prescribed and constant; the frame moves with each ball's centre.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from time import process_time

import numpy as np
from numpy.typing import NDArray

from rollbench.hifi.contact.hertz import hertz
from rollbench.hifi.rolling import kinematics
from rollbench.hifi.rolling.bodies import Place, Sizes, contact_kernel, make_kernels
from rollbench.hifi.rolling.friction import PATH, Contact, Friction, full_slip, solve_friction, solve_rigid_friction
from rollbench.hifi.rolling.kinematics import Rolling, rolling_speed
from rollbench.hifi.rolling.patch import Patch, Regular, equivalent_radii, hertz_patch
from rollbench.meshes.arrays import Array

#: Tangential compliance over the true one that represents rigid bodies where grids are compared.
NEARLY_RIGID = 0.01

#: Contact forces below this share of a ball's largest one count as zero.
NEGLIGIBLE = 1e-9

#: Points of the quadrature of the rigid limit along each axis of the ellipse, first and last.
FIRST, POINTS = 40, 300


@dataclass(frozen=True)
class Choices:
    """Numerical choices of the rolling model: grids, elasticity and meshes of bodies."""

    #: Cells of every contact's grid along and across the groove.
    shape: tuple[int, int] = (24, 24)
    #: Share of the tangential compliance: 1, or `NEARLY_RIGID`.
    elastic: float = 1.0
    #: Contacts on the surface that ball and groove share, not on its tangent plane.
    curved: bool = True
    #: Meshes of finite bodies; None: half-spaces.
    bodies: Sizes | None = None


@dataclass(frozen=True)
class ContactOut:
    """Friction solution of one contact of n cells."""

    #: Index of the ball.
    ball: int
    #: Index of its contact.
    touch: int
    #: Centres of the cells ``(n, 2)`` [m].
    at: Array
    #: Size of a cell ``(2,)`` [m].
    size: Array
    #: Normal forces ``(n,)`` [N].
    normal: Array
    #: Tangential forces on the ball ``(n, 2)`` [N].
    tangential: Array
    #: Slips ``(n, 2)`` [m/s].
    slip: Array
    #: Which cells stick ``(n,)``.
    stick: NDArray[np.bool_]
    #: Local axes ``(3, 3)``.
    axes: Array
    #: Power of friction [W].
    loss: float
    #: Power that the differences along the flow dissipate [W].
    upwind: float


@dataclass(frozen=True)
class RollingResult:
    """Steady rolling of N balls: motions, friction forces and losses."""

    #: Speeds of the balls along the track ``(N,)``.
    speed: Array
    #: Rotations about their axes ``(N, 3)`` [rad/s].
    rotation: Array
    #: Forces between balls in touch [N].
    force: Array
    #: Losses between balls in touch [W].
    ball_loss: Array
    #: Wrench of friction at the grooves on every ball ``(N, 6)`` [N, N m], in its axes.
    wrench: Array
    #: Force of its neighbours on every ball ``(N, 3)`` [N], in its axes.
    between: Array
    #: Power put in by the bodies [W].
    power: float
    #: The solved contacts.
    contacts: tuple[ContactOut, ...]
    #: "converged", or why not.
    status: str
    #: Residual of the friction solver.
    residual: float
    #: Newton steps.
    steps: int
    #: Processor time [s].
    seconds: float
    #: Solution of the friction solver.
    friction: Friction

    @property
    def converged(self) -> bool:
        """Whether the equations are satisfied."""
        return self.status == "converged"

    @property
    def groove_loss(self) -> float:
        """Friction losses at all grooves [W]."""
        return sum(c.loss for c in self.contacts)

    @property
    def loss(self) -> float:
        """All friction losses, at grooves and between balls [W]."""
        return self.groove_loss + float(self.ball_loss.sum())

    @property
    def upwind(self) -> float:
        """Power that the differences along the flow dissipate [W]."""
        return sum(c.upwind for c in self.contacts)


@lru_cache(maxsize=16)
def unit_patch(radii: tuple[float, float], young: float, poisson: float, shape: tuple[int, int]) -> Patch:
    """Solve the contact of half-spaces under 1 N on a grid, with its `Patch.transport` computed.

    The contact under any other force is similar, with lengths in proportion to the cube root of the force.
    """
    patch = hertz_patch(1.0, radii, young, poisson, shape)
    assert patch.transport.size
    return patch


@lru_cache(maxsize=64)
def finite_patch(
    load: float, radii: tuple[float, float], material: tuple[float, float], shape: tuple[int, int], kernel: Regular
) -> Patch:
    """Solve the contact of finite bodies under a force [N]; material: Young's modulus [Pa] and Poisson's ratio."""
    return hertz_patch(load, radii, *material, shape, kernel)


def grid_contact(scene: kinematics.Rolling, touch: kinematics.Touch, choices: Choices) -> Patch:
    """Compute the grid contact of a ball with a groove under its force. Raises ValueError as `finite_body_kernel`."""
    kernel = finite_body_kernel(scene, touch, choices.bodies)
    if kernel is None:
        unit = unit_patch(touch.radii, scene.young, scene.poisson, choices.shape)
        return unit.scaled(float(np.cbrt(touch.load)), touch.load)
    return finite_patch(touch.load, touch.radii, (scene.young, scene.poisson), choices.shape, kernel)


def finite_body_kernel(scene: kinematics.Rolling, touch: kinematics.Touch, bodies: Sizes | None) -> Regular | None:
    """Compute the smooth compliance of finite bodies (kernel) at a contact, in the contact's axes.

    Parameters
    ----------
    scene : kinematics.Rolling
        The balls.
    touch : kinematics.Touch
        The contact.
    bodies : Sizes | None
        Meshes of finite bodies; None: half-spaces.

    Returns
    -------
    Regular | None
        The kernel; None for half-spaces.

    Raises
    ------
    ValueError
        As `contact_place` and `hifi.rolling.bodies.contact_kernel`.
    """
    if bodies is None:
        return None
    at, bottom = contact_place(scene, touch)
    kernel = contact_kernel(at, _largest_load(scene), scene.young, scene.poisson, bodies)
    axes = kinematics.contact_axes(touch, scene)
    return kernel if axes[1] @ bottom > 0.0 else kernel.turned


def prepare_bodies(scenes: Sequence[kinematics.Rolling], bodies: Sizes | None, processes: int) -> float:
    """Compute the kernels of finite bodies for several scenes of one material, in several processes.

    See `hifi.rolling.bodies.make_kernels`.

    Parameters
    ----------
    scenes : Sequence[kinematics.Rolling]
        Scenes.
    bodies : Sizes | None
        Meshes of finite bodies; None: half-spaces, for which nothing is computed.
    processes : int
        Number of processes.

    Returns
    -------
    float
        Processor time [s].
    """
    if bodies is None:
        return 0.0
    contacts = [(contact_place(s, t)[0], _largest_load(s)) for s in scenes for _, _, t in loaded_contacts(s)]
    return make_kernels(contacts, scenes[0].young, scenes[0].poisson, bodies, processes)


def _largest_load(scene: kinematics.Rolling) -> float:
    """Return the largest contact force of all balls [N]."""
    return max(t.load for b in scene.balls for t in b.touches)


def contact_place(scene: kinematics.Rolling, touch: kinematics.Touch) -> tuple[Place, Array]:
    """Describe the position of a contact on its groove, and the direction to the groove's bottom.

    Raises ValueError if that direction is unknown.

    Parameters
    ----------
    scene : kinematics.Rolling
        The balls.
    touch : kinematics.Touch
        The contact.

    Returns
    -------
    place : Place
        The contact as the kernels need it.
    bottom : (3,) Array
        Unit vector from the ball's centre to the bottom of the groove.
    """
    if touch.bottom is None:
        raise ValueError("the contact with a finite groove needs the direction to the groove's bottom")
    angle = float(np.arccos(touch.normal @ touch.bottom))
    return Place(scene.radius, touch.radii, angle, scene.track.curve), touch.bottom


def loaded_contacts(scene: kinematics.Rolling) -> list[tuple[int, int, kinematics.Touch]]:
    """List the contacts that carry load: index of the ball, index of the contact on the ball, and the contact.

    Parameters
    ----------
    scene : kinematics.Rolling
        The balls.

    Returns
    -------
    list[tuple[int, int, kinematics.Touch]]
        Contacts with more than `NEGLIGIBLE` of the ball's largest force.
    """
    out = []
    for b, ball in enumerate(scene.balls):
        least = NEGLIGIBLE * max((t.load for t in ball.touches), default=0.0)
        out += [(b, k, t) for k, t in enumerate(ball.touches) if t.load > least]
    return out


def friction_contacts(scene: kinematics.Rolling, choices: Choices) -> list[Contact]:
    """Prepare the loaded contacts for the friction solver.

    Parameters
    ----------
    scene : kinematics.Rolling
        The balls.
    choices : Choices
        Numerical choices.

    Returns
    -------
    list[Contact]
        Contacts in the order of `loaded_contacts`.
    """
    curved, elastic = choices.curved, choices.elastic
    return [
        kinematics.ball_contact(t, scene, b, grid_contact(scene, t, choices), curved=curved, elastic=elastic)
        for b, _, t in loaded_contacts(scene)
    ]


def ball_equilibrium(scene: kinematics.Rolling, contacts: Sequence[Contact]) -> kinematics.BallEquilibrium:
    """Create the equilibrium equations of the balls for the friction solver.

    Parameters
    ----------
    scene : kinematics.Rolling
        The balls.
    contacts : Sequence[Contact]
        Their loaded contacts.

    Returns
    -------
    kinematics.Together
        Forces on the motions and complementarity of the balls in touch.
    """
    bound = max(float(c.bound.sum()) for c in contacts)
    return kinematics.BallEquilibrium(scene, bound / max(float(np.abs(c.given).max()) for c in contacts))


def split_unknowns(scene: kinematics.Rolling, y: Array) -> tuple[Array, Array, Array]:
    """Split the vector of unknowns into speeds, rotations and forces between balls.

    Parameters
    ----------
    scene : kinematics.Rolling
        The balls.
    y : Array
        The unknowns.

    Returns
    -------
    speed : (N,) Array
        Speeds of the balls along the track.
    rotation : (N, 3) Array
        Rotations [rad/s].
    force : (M,) Array
        Forces between balls in touch [N].
    """
    count = kinematics.MOTIONS * len(scene.balls)
    motions = y[:count].reshape(-1, kinematics.MOTIONS)
    return motions[:, 0] / scene.track.length, motions[:, 1:] / scene.radius, y[count:].copy()


def ball_contact_losses(scene: kinematics.Rolling, y: Array) -> Array:
    """Compute the losses of sliding friction between touching balls ``(M,)`` [W]."""
    pairs = zip(split_unknowns(scene, y)[2], scene.meetings, strict=True)
    return np.array([scene.mu_balls * f * float(np.linalg.norm((m.rows @ y[m.columns])[1:])) for f, m in pairs])


def starting_motions(scene: kinematics.Rolling) -> Array:
    """Estimate starting motions: each ball moves at its nominal speed and rotates so that its contacts slide least."""
    y = np.zeros(kinematics.MOTIONS * len(scene.balls) + len(scene.meetings))
    for b, ball in enumerate(scene.balls):
        y[kinematics.MOTIONS * b] = scene.orbit * scene.track.length
        rows, driven = [], []
        for t in ball.touches:
            if t.load > 0.0:
                at = scene.radius * t.normal
                turn = np.cross(np.eye(3), at).T / scene.radius
                rows.append(turn * t.load)
                driven.append((t.ride - scene.orbit) * scene.track.field(at) * t.load)
        y[kinematics.MOTIONS * b + 1 : kinematics.MOTIONS * (b + 1)] = np.linalg.lstsq(
            np.vstack(rows), np.concatenate(driven), rcond=1e-10
        )[0]
    return y


def solve_rolling(
    scene: kinematics.Rolling,
    choices: Choices | None = None,
    near: RollingResult | None = None,
    path: tuple[float, ...] = PATH,
) -> RollingResult:
    """Solve steady rolling of balls under prescribed contact loads.

    Parameters
    ----------
    scene : kinematics.Rolling
        The balls and their contact loads.
    choices : Choices | None, default None
        Numerical choices.
    near : RollingResult | None, default None
        Solution on the same grid to start from.
    path : tuple[float, ...], default PATH
        Creeping speeds, as for `hifi.rolling.friction.solve_friction`.

    Returns
    -------
    RollingResult
        The solution.

    Raises
    ------
    ValueError
        A ball has no loaded contact.
    """
    begin, choices = process_time(), choices or Choices()
    if any(max((t.load for t in b.touches), default=0.0) <= 0.0 for b in scene.balls):
        raise ValueError("every ball needs a loaded contact: without one it has no steady motion")
    contacts = friction_contacts(scene, choices)
    balance = ball_equilibrium(scene, contacts)
    y = starting_motions(scene) if near is None else near.friction.motions
    solution = solve_friction(contacts, balance, y, None if near is None else near.friction.forces, path)
    return _collect_result(scene, choices, contacts, solution, process_time() - begin)


def _collect_result(
    scene: kinematics.Rolling, choices: Choices, contacts: Sequence[Contact], solution: Friction, seconds: float
) -> RollingResult:
    speed, rotation, force = split_unknowns(scene, solution.motions)
    outs, power, wrench = [], 0.0, np.zeros((len(scene.balls), 6))
    for (b, i, t), c, q, s, stick in zip(
        loaded_contacts(scene), contacts, solution.forces, solution.slips, solution.stick, strict=True
    ):
        patch = grid_contact(scene, t, choices)
        points, tangents = kinematics.contact_surface(
            t, scene, patch.at, curved=choices.curved, sunk=choices.elastic * patch.sunk
        )
        on_ball = np.einsum("nck,cn->nk", tangents, q.reshape(2, -1))
        wrench[b, :3] += on_ball.sum(axis=0)
        wrench[b, 3:] += np.cross(points, on_ball).sum(axis=0)
        power -= float(q @ c.given)
        pull, slip, axes = q.reshape(2, -1).T, s.reshape(2, -1).T, kinematics.contact_axes(t, scene)
        loss, upwind = -float(q @ s), float(q @ (c.elastic @ q))
        outs.append(ContactOut(b, i, patch.at, patch.size, patch.normal, pull, slip, stick, axes, loss, upwind))
    between = np.zeros((len(scene.balls), 3))
    for f, m in zip(force, scene.meetings, strict=True):
        pulls = m.forces(float(f), scene.mu_balls, (m.rows @ solution.motions[m.columns])[1:])
        for ball, sign in ((m.one, 1.0), (m.two, -1.0)):
            between[ball] += sign * (scene.balls[ball].frame @ pulls)
    rub, how = ball_contact_losses(scene, solution.motions), (solution.status, solution.residual, solution.steps)
    return RollingResult(speed, rotation, force, rub, wrench, between, power, tuple(outs), *how, seconds, solution)


def without_ball_contacts(scene: kinematics.Rolling) -> kinematics.Rolling:
    """Return a copy of a scene whose balls cannot touch each other.

    Parameters
    ----------
    scene
        Rolling balls.
    """
    return replace(scene, meetings=())


def hertz_semi_axes(scene: kinematics.Rolling, touch: kinematics.Touch) -> tuple[float, float]:
    """Compute the Hertzian semi-axes of a contact along and across the groove [m].

    Parameters
    ----------
    scene : kinematics.Rolling
        The balls.
    touch : kinematics.Touch
        The contact.

    Returns
    -------
    tuple[float, float]
        Semi-axes [m].
    """
    ellipse = hertz(touch.load, *touch.radii, scene.young, scene.poisson)
    return ellipse.semi_x, ellipse.semi_y


# --- the rigid limit: no tangential compliance, Coulomb friction under Hertz's pressure by fine quadrature
#
# The effect of a grid's cells, its staircase edge and a spin
# pole within a cell on a solution is nearly the same for nearly rigid bodies, so that
#
#     result = grid(elastic) - grid(nearly rigid) + limit
#
# keeps of them only what they do to the effect of elasticity.


@dataclass(frozen=True)
class RigidResult:
    """Steady rolling of N rigid balls: motions, forces and losses."""

    #: Speeds of the balls along the track ``(N,)``.
    speed: Array
    #: Rotations ``(N, 3)`` [rad/s].
    rotation: Array
    #: Forces between balls in touch [N].
    force: Array
    #: Losses at every loaded contact [W].
    contact_loss: Array
    #: Losses between balls in touch [W].
    ball_loss: Array
    #: Slip left by the smoothing, relative to the largest slip.
    remainder: float

    @property
    def loss(self) -> float:
        """All friction losses, at grooves and between balls [W]."""
        return float(self.contact_loss.sum() + self.ball_loss.sum())


def disk_quadrature(points: int) -> tuple[Array, Array]:
    """Build a quadrature rule of the unit disk, by midpoints in angles.

    Parameters
    ----------
    points : int
        Points along each axis.

    Returns
    -------
    at : (points^2, 2) Array
        Places.
    weights : (points^2,) Array
        Weights.

    Examples
    --------
    >>> f"{disk_quadrature(40)[1].sum():.3f}"  # pi
    '3.142'
    """
    t = (np.arange(points) + 0.5) / points * np.pi
    u, w = np.cos(t), np.sin(t) * np.pi / points
    x, v = np.meshgrid(u, u, indexing="ij")
    weight = np.outer(w * np.sqrt(1.0 - u**2), w)
    return np.stack([x.ravel(), (v * np.sqrt(1.0 - x**2)).ravel()], axis=1), weight.ravel()


def solve_rigid_rolling(
    scene: kinematics.Rolling, points: int = POINTS, *, curved: bool = True, bodies: Sizes | None = None
) -> RigidResult:
    """Solve steady rolling of rigid bodies under Hertz's pressures.

    Parameters
    ----------
    scene : kinematics.Rolling
        The balls and their contact loads.
    points : int, default POINTS
        Points of the quadrature along each axis of an ellipse.
    curved : bool, default True
        As for `Choices`.
    bodies : Sizes | None, default None
        Finite bodies, replaced by the half-spaces that touch as they do (`hifi.rolling.patch.equivalent_radii`); None:
        half-spaces.

    Returns
    -------
    RigidResult
        The solution.

    Raises
    ------
    ValueError
        No balance is found.
    """
    y = starting_motions(scene)
    for count in (FIRST, points):
        contacts = _rigid_contacts(scene, count, curved, bodies)
        path = PATH if count == FIRST else PATH[-2:]
        y, remainder = solve_rigid_friction(contacts, ball_equilibrium(scene, contacts), y, path)
    loss = np.array([-float(full_slip(c.bound, s) @ s) for c in contacts for s in (c.rigid_slip(y),)])
    return RigidResult(*split_unknowns(scene, y), loss, ball_contact_losses(scene, y), remainder)


def _rigid_contacts(scene: kinematics.Rolling, points: int, curved: bool, bodies: Sizes | None) -> list[Contact]:
    (unit, weight), material, contacts = disk_quadrature(points), (scene.young, scene.poisson), []
    for b, _, touch in loaded_contacts(scene):
        radii = equivalent_radii(touch.load, touch.radii, *material, finite_body_kernel(scene, touch, bodies))
        ellipse = hertz(touch.load, *radii, *material)
        semi = np.array([ellipse.semi_x, ellipse.semi_y])
        local = unit * semi
        normal = ellipse.pressure(local[:, 0], local[:, 1]) * weight * semi.prod()
        normal *= touch.load / normal.sum()
        contacts.append(kinematics.rigid_contact(touch, scene, b, normal, local, curved=curved))
    return contacts


#: Largest distance from the zone's centre at which the kernel of finite bodies is valid, over the zone's half length.
REACH = 1.2


@dataclass(frozen=True)
class TransientResult:
    """Rolling from rest of N balls with M ball-to-ball contacts, in T time steps."""

    #: Ends of the steps ``(T,)`` [s].
    time: Array
    #: Speeds of the balls along the track ``(T, N)``.
    speed: Array
    #: Rotations ``(T, N, 3)`` [rad/s].
    rotation: Array
    #: Forces between balls ``(T, M)`` [N].
    force: Array
    #: Gaps between balls ``(T, M)`` [m].
    gap: Array
    #: Losses of friction, and of closing balls in the step in which they meet ``(T,)`` [W].
    loss: Array
    #: Power put in ``(T,)`` [W].
    power: Array
    #: The part of it that elastic displacements store, or lose by the steps ``(T,)`` [W].
    stored: Array
    #: Processor time [s].
    seconds: float
    #: "converged", or the first step that did not and why.
    status: str

    @property
    def converged(self) -> bool:
        """Whether every step is a solution."""
        return self.status == "converged"


@dataclass(frozen=True)
class _ContactWithoutHistory:
    """Contact without its history.

    Tangential displacements per force over the step: at the present place of the material (``present``), and at its place
    before the step (``before``).
    """

    contact: Contact
    present: Array
    before: Array

    def at(self, forces: Array) -> Contact:
        """Add the history to the contact: the displacements by the last step's ``forces`` (2 n,) [N]."""
        return replace(self.contact, elastic=self.present, given=self.contact.given - self.before @ forces)


def run_from_rest(
    scene: Rolling, duration: float, steps: int, gap: float = 0.0, choices: Choices | None = None
) -> TransientResult:
    """Compute the motion of balls from rest, in equal time steps.

    Parameters
    ----------
    scene : Rolling
        The balls and their contact loads.
    duration : float
        Duration of the run [s].
    steps : int
        Number of steps.
    gap : float, default 0.0
        Gaps between neighbours at first [m].
    choices : Choices | None, default None
        Numerical choices.

    Returns
    -------
    TransientResult
        Histories.

    Raises
    ------
    ValueError
        Duration or steps are not positive, the gap is negative, or steps carry material from beyond the contact zone
        of finite bodies.
    """
    if not duration > 0.0 or steps < 1 or gap < 0.0:
        raise ValueError("the duration must be > 0, the number of steps at least 1, and the gap not negative")
    return _run_steps(scene, duration / steps, steps, gap, choices or Choices())


def _run_steps(scene: Rolling, dt: float, steps: int, gap: float, choices: Choices) -> TransientResult:
    begin = process_time()
    carried = _contacts_without_history(scene, choices, dt)
    forces = [np.zeros(c.contact.given.size) for c in carried]
    y, gaps, out, status = starting_motions(scene), np.full(len(scene.meetings), gap), [], "converged"
    for step in range(steps):
        meetings = tuple(replace(m, apart=float(g) / dt) for m, g in zip(scene.meetings, gaps, strict=True))
        contacts = [c.at(q) for c, q in zip(carried, forces, strict=True)]
        balance = ball_equilibrium(replace(scene, meetings=meetings), contacts)
        solution = solve_friction(contacts, balance, y, forces)
        if not solution.converged:
            status = f"step {step + 1}: {solution.status}"
            break
        y, old, forces = solution.motions, forces, solution.forces
        closing = np.array([float(m.rows[0] @ y[m.columns]) for m in scene.meetings])
        gaps = np.maximum(gaps - dt * closing, 0.0)
        out.append(_step_results(scene, carried, (old, forces), solution.slips, y, gaps))
    speed, rotation, force, gap_left, loss, power, stored = (
        np.array([row[k] for row in out], dtype=float) for k in range(7)
    )
    time = np.asarray(dt * (1.0 + np.arange(len(out))))
    return TransientResult(time, speed, rotation, force, gap_left, loss, power, stored, process_time() - begin, status)


def _contacts_without_history(scene: Rolling, choices: Choices, dt: float) -> list[_ContactWithoutHistory]:
    out = []
    for (_, _, touch), contact in zip(loaded_contacts(scene), friction_contacts(scene, choices), strict=True):
        patch = grid_contact(scene, touch, choices)
        shift = rolling_speed(touch, scene) * dt
        if patch.regular is not None and float(patch.at[:, 0].max()) + shift > REACH * patch.regular.scale[0]:
            raise ValueError(
                "a time step moves material in from beyond the zone of finite bodies: use shorter steps, or half-spaces"
            )
        share = choices.elastic / dt
        out.append(_ContactWithoutHistory(contact, share * patch.tangential(), share * patch.tangential(shift)))
    return out


def _step_results(
    scene: Rolling,
    carried: list[_ContactWithoutHistory],
    forces: tuple[list[Array], list[Array]],
    slips: list[Array],
    y: Array,
    gaps: Array,
) -> tuple[Array, Array, Array, Array, float, float, float]:
    """Collect speeds, rotations, forces, gaps, loss, power put in and power stored at the end of a time step.

    forces: tangential contact forces before and after the step.
    """
    old, new = forces
    speed, rotation, press = split_unknowns(scene, y)
    closing = sum(float(f) * float(m.rows[0] @ y[m.columns]) for f, m in zip(press, scene.meetings, strict=True))
    rub = -sum(float(q @ s) for q, s in zip(new, slips, strict=True)) + float(ball_contact_losses(scene, y).sum())
    power = -sum(float(q @ c.contact.given) for q, c in zip(new, carried, strict=True))
    stored = sum(float(q @ (c.present @ q - c.before @ before)) for q, before, c in zip(new, old, carried, strict=True))
    return speed, rotation, press, gaps, rub + closing, power, stored
