"""Balls in steady rolling: motions that balance the friction of elastic contacts, and the forces of balls that touch.

Of a ball's six equations of equilibrium two fix its place in the section of the track, that is its contact forces,
which are given here (`hifi.rolling.scenes`); the other four fix its speed along the track and its rotation. Forces
across the track that friction adds to the given ones are in the result.

Balls that begin to roll from rest, in time: elastic displacements carried along by the material, gaps that close.

In a step dt material moves by V dt through every contact, so that

    s dt = A q(t) - A_shifted q(t - dt) + rigid slip dt,

A_shifted giving the old displacements where the material was: nothing is interpolated. First order in the step. Contact
forces are given and stay; the frame moves with each ball's centre.
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
from rollbench.hifi.rolling.friction import PATH, Contact, Friction, full_slip, solve_friction, solve_rigid
from rollbench.hifi.rolling.kinematics import Rolling, rolling_speed
from rollbench.hifi.rolling.patch import Patch, Regular, hertz_patch, seen_radii
from rollbench.meshes.arrays import Array

#: Compliance along tangents that stands for rigid bodies where grids are compared, over the true one.
NEARLY_RIGID = 0.01

#: Contact forces below this share of a ball's largest are none.
NEGLIGIBLE = 1e-9

#: Points of the quadrature of the rigid limit along each axis of the ellipse, first and last.
FIRST, POINTS = 40, 300


@dataclass(frozen=True)
class Choices:
    """Numerical choices: cells of every contact's grid along and across the groove; share of the tangential compliance
    (1, or `NEARLY_RIGID`); curved: contacts on the surface that ball and groove share, not on its tangent plane; bodies:
    meshes of finite ones (None: half spaces)."""

    shape: tuple[int, int] = (24, 24)
    elastic: float = 1.0
    curved: bool = True
    bodies: Sizes | None = None


@dataclass(frozen=True)
class ContactOut:
    """A solved contact: which ball and touch; centres ``(n, 2)`` [m], normal and tangential forces on the ball ``(n,)``,
    ``(n, 2)`` [N], slips ``(n, 2)`` [m/s], which cells stick, local axes ``(3, 3)``; loss [W], and power [W] that the
    differences along the flow lose."""

    ball: int
    touch: int
    at: Array
    size: Array
    normal: Array
    tangential: Array
    slip: Array
    stick: NDArray[np.bool_]
    axes: Array
    loss: float
    upwind: float


@dataclass(frozen=True)
class RollingResult:
    """Steady rolling: speeds of the balls along the track ``(N,)``, rotations about their own axes ``(N, 3)`` [rad/s],
    forces of meetings [N] and their losses [W], wrench of friction on every ball ``(N, 6)`` [N, N m] at its grooves,
    force of its neighbours on it ``(N, 3)`` [N], both in its own axes, power [W] put in by the bodies, the contacts,
    solver's state and seconds of processor time."""

    speed: Array
    rotation: Array
    force: Array
    ball_loss: Array
    wrench: Array
    between: Array
    power: float
    contacts: tuple[ContactOut, ...]
    status: str
    residual: float
    steps: int
    seconds: float
    friction: Friction

    @property
    def converged(self) -> bool:
        """Whether the equations hold."""
        return self.status == "converged"

    @property
    def groove_loss(self) -> float:
        """Losses at all grooves [W]."""
        return sum(c.loss for c in self.contacts)

    @property
    def loss(self) -> float:
        """All losses of friction [W]."""
        return self.groove_loss + float(self.ball_loss.sum())

    @property
    def upwind(self) -> float:
        """Power that the differences along the flow lose [W]."""
        return sum(c.upwind for c in self.contacts)


@lru_cache(maxsize=16)
def unit_patch(radii: tuple[float, float], young: float, poisson: float, shape: tuple[int, int]) -> Patch:
    """Contact under 1 N, its transport computed; every force has the same one, lengths growing by its cube root."""
    patch = hertz_patch(1.0, radii, young, poisson, shape)
    assert patch.transport.size
    return patch


@lru_cache(maxsize=64)
def finite_patch(
    load: float, radii: tuple[float, float], material: tuple[float, float], shape: tuple[int, int], kernel: Regular
) -> Patch:
    """Contact of finite bodies under a force [N]; material: Young's modulus [Pa] and Poisson's ratio."""
    return hertz_patch(load, radii, *material, shape, kernel)


def patch_of(scene: kinematics.Rolling, touch: kinematics.Touch, choices: Choices) -> Patch:
    """The contact's patch under its force. Raises ValueError as `kernel_of`."""
    kernel = kernel_of(scene, touch, choices.bodies)
    if kernel is None:
        unit = unit_patch(touch.radii, scene.young, scene.poisson, choices.shape)
        return unit.scaled(float(np.cbrt(touch.load)), touch.load)
    return finite_patch(touch.load, touch.radii, (scene.young, scene.poisson), choices.shape, kernel)


def kernel_of(scene: kinematics.Rolling, touch: kinematics.Touch, bodies: Sizes | None) -> Regular | None:
    """What finite bodies add at a contact, in its axes; None for half spaces. Raises ValueError as `place_of`."""
    if bodies is None:
        return None
    at, bottom = place_of(scene, touch)
    kernel = contact_kernel(at, _largest(scene), scene.young, scene.poisson, bodies)
    axes = kinematics.axes_of(touch, scene)
    return kernel if axes[1] @ bottom > 0.0 else kernel.turned


def prepare_bodies(scenes: Sequence[kinematics.Rolling], bodies: Sizes | None, processes: int) -> float:
    """Make bodies of scenes of one material as `hifi.rolling.bodies.make_kernels`; raises as `kernel_of`."""
    if bodies is None:
        return 0.0
    contacts = [(place_of(s, t)[0], _largest(s)) for s in scenes for _, _, t in touching(s)]
    return make_kernels(contacts, scenes[0].young, scenes[0].poisson, bodies, processes)


def _largest(scene: kinematics.Rolling) -> float:
    """Largest force of a contact [N]."""
    return max(t.load for b in scene.balls for t in b.touches)


def place_of(scene: kinematics.Rolling, touch: kinematics.Touch) -> tuple[Place, Array]:
    """Where a ball touches its groove, and the direction to its bottom. Raises ValueError where that is unknown."""
    if touch.bottom is None:
        raise ValueError("a finite groove needs the direction of its bottom")
    angle = float(np.arccos(touch.normal @ touch.bottom))
    return Place(scene.radius, touch.radii, angle, scene.track.curve), touch.bottom


def touching(scene: kinematics.Rolling) -> list[tuple[int, int, kinematics.Touch]]:
    """Ball, number and record of every touch that carries load."""
    out = []
    for b, ball in enumerate(scene.balls):
        least = NEGLIGIBLE * max((t.load for t in ball.touches), default=0.0)
        out += [(b, k, t) for k, t in enumerate(ball.touches) if t.load > least]
    return out


def contacts_of(scene: kinematics.Rolling, choices: Choices) -> list[Contact]:
    """Every loaded contact as friction needs it."""
    curved, elastic = choices.curved, choices.elastic
    return [
        kinematics.ball_contact(t, scene, b, patch_of(scene, t, choices), curved=curved, elastic=elastic)
        for b, _, t in touching(scene)
    ]


def balance_of(scene: kinematics.Rolling, contacts: Sequence[Contact]) -> kinematics.Together:
    """Meetings of the balls as the solver takes them."""
    bound = max(float(c.bound.sum()) for c in contacts)
    return kinematics.Together(scene, bound / max(float(np.abs(c.given).max()) for c in contacts))


def moving(scene: kinematics.Rolling, y: Array) -> tuple[Array, Array, Array]:
    """Of the unknowns: speeds of balls along the track ``(N,)``, rotations ``(N, 3)`` [rad/s], forces of meetings [N]."""
    count = kinematics.MOTIONS * len(scene.balls)
    motions = y[:count].reshape(-1, kinematics.MOTIONS)
    return motions[:, 0] / scene.track.length, motions[:, 1:] / scene.radius, y[count:].copy()


def meeting_losses(scene: kinematics.Rolling, y: Array) -> Array:
    """Losses of sliding friction at every meeting [W]."""
    pairs = zip(moving(scene, y)[2], scene.meetings, strict=True)
    return np.array([scene.mu_balls * f * float(np.linalg.norm((m.rows @ y[m.columns])[1:])) for f, m in pairs])


def start_of(scene: kinematics.Rolling) -> Array:
    """Motions near rolling: each ball at its nominal speed, turning so that its contacts slide least."""
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
    """Steady rolling; near: a solution on the same grid to start from; path: creeping speeds that lead to one from none
    (`hifi.rolling.friction.solve_friction`). Raises ValueError for a ball without a contact."""
    begin, choices = process_time(), choices or Choices()
    if any(max((t.load for t in b.touches), default=0.0) <= 0.0 for b in scene.balls):
        raise ValueError("a ball without a loaded contact has no steady motion")
    contacts = contacts_of(scene, choices)
    balance = balance_of(scene, contacts)
    y = start_of(scene) if near is None else near.friction.motions
    solution = solve_friction(contacts, balance, y, None if near is None else near.friction.forces, path)
    return _result(scene, choices, contacts, solution, process_time() - begin)


def _result(
    scene: kinematics.Rolling, choices: Choices, contacts: Sequence[Contact], solution: Friction, seconds: float
) -> RollingResult:
    speed, rotation, force = moving(scene, solution.motions)
    outs, power, wrench = [], 0.0, np.zeros((len(scene.balls), 6))
    for (b, i, t), c, q, s, stick in zip(
        touching(scene), contacts, solution.forces, solution.slips, solution.stick, strict=True
    ):
        patch = patch_of(scene, t, choices)
        points, tangents = kinematics.surface(t, scene, patch.at, curved=choices.curved, sunk=choices.elastic * patch.sunk)
        on_ball = np.einsum("nck,cn->nk", tangents, q.reshape(2, -1))
        wrench[b, :3] += on_ball.sum(axis=0)
        wrench[b, 3:] += np.cross(points, on_ball).sum(axis=0)
        power -= float(q @ c.given)
        pull, slip, axes = q.reshape(2, -1).T, s.reshape(2, -1).T, kinematics.axes_of(t, scene)
        loss, upwind = -float(q @ s), float(q @ (c.elastic @ q))
        outs.append(ContactOut(b, i, patch.at, patch.size, patch.normal, pull, slip, stick, axes, loss, upwind))
    between = np.zeros((len(scene.balls), 3))
    for f, m in zip(force, scene.meetings, strict=True):
        pulls = m.forces(float(f), scene.mu_balls, (m.rows @ solution.motions[m.columns])[1:])
        for ball, sign in ((m.one, 1.0), (m.two, -1.0)):
            between[ball] += sign * (scene.balls[ball].frame @ pulls)
    rub, how = meeting_losses(scene, solution.motions), (solution.status, solution.residual, solution.steps)
    return RollingResult(speed, rotation, force, rub, wrench, between, power, tuple(outs), *how, seconds, solution)


def without_meetings(scene: kinematics.Rolling) -> kinematics.Rolling:
    """The same balls out of each other's reach."""
    return replace(scene, meetings=())


def hertz_size(scene: kinematics.Rolling, touch: kinematics.Touch) -> tuple[float, float]:
    """Semi-axes [m] along and across the groove."""
    ellipse = hertz(touch.load, *touch.radii, scene.young, scene.poisson)
    return ellipse.semi_x, ellipse.semi_y


# --- the rigid limit: grooves that do not yield along tangents, Coulomb friction under Hertz's pressure by fine quadrature
#
# The limit that grids of elastic contacts are differenced against: what a grid's cells, its staircase edge and a spin
# pole within a cell do to an answer they do to nearly rigid bodies too, so that
#
#     answer = grid(elastic) - grid(nearly rigid) + limit
#
# keeps of them only what they do to the effect of elasticity.


@dataclass(frozen=True)
class RigidResult:
    """Speeds of the balls along the track ``(N,)``, rotations ``(N, 3)`` [rad/s], forces of meetings [N], losses at
    every loaded contact and meeting [W]; what the smoothing of the path leaves, over the largest slip."""

    speed: Array
    rotation: Array
    force: Array
    contact_loss: Array
    ball_loss: Array
    remainder: float

    @property
    def loss(self) -> float:
        """All losses of friction [W]."""
        return float(self.contact_loss.sum() + self.ball_loss.sum())


def quadrature(points: int) -> tuple[Array, Array]:
    """Places ``(points^2, 2)`` in the unit disk and weights ``(points^2,)``; midpoints in angles that end at the edge."""
    t = (np.arange(points) + 0.5) / points * np.pi
    u, w = np.cos(t), np.sin(t) * np.pi / points
    x, v = np.meshgrid(u, u, indexing="ij")
    weight = np.outer(w * np.sqrt(1.0 - u**2), w)
    return np.stack([x.ravel(), (v * np.sqrt(1.0 - x**2)).ravel()], axis=1), weight.ravel()


def solve_rigid_rolling(
    scene: kinematics.Rolling, points: int = POINTS, *, curved: bool = True, bodies: Sizes | None = None
) -> RigidResult:
    """Steady rolling of rigid bodies under Hertz's pressures. Raises ValueError where no balance is found.

    bodies: finite ones, by the half spaces that touch as they do (`hifi.rolling.patch.seen_radii`); None: half spaces.
    """
    y = start_of(scene)
    for count in (FIRST, points):
        contacts = _rigid_contacts(scene, count, curved, bodies)
        path = PATH if count == FIRST else PATH[-2:]
        y, remainder = solve_rigid(contacts, balance_of(scene, contacts), y, path)
    loss = np.array([-float(full_slip(c.bound, s) @ s) for c in contacts for s in (c.rigid_slip(y),)])
    return RigidResult(*moving(scene, y), loss, meeting_losses(scene, y), remainder)


def _rigid_contacts(scene: kinematics.Rolling, points: int, curved: bool, bodies: Sizes | None) -> list[Contact]:
    (unit, weight), material, contacts = quadrature(points), (scene.young, scene.poisson), []
    for b, _, touch in touching(scene):
        radii = seen_radii(touch.load, touch.radii, *material, kernel_of(scene, touch, bodies))
        ellipse = hertz(touch.load, *radii, *material)
        semi = np.array([ellipse.semi_x, ellipse.semi_y])
        local = unit * semi
        normal = ellipse.pressure(local[:, 0], local[:, 1]) * weight * semi.prod()
        normal *= touch.load / normal.sum()
        contacts.append(kinematics.rigid_contact(touch, scene, b, normal, local, curved=curved))
    return contacts


#: How far beyond its zone the kernel of finite bodies is good, over the zone's half length.
REACH = 1.2


@dataclass(frozen=True)
class TransientResult:
    """Steps of a run: ends of the steps ``(T,)`` [s], speeds of the balls along the track ``(T, N)``, rotations ``(T,
    N, 3)`` [rad/s], forces ``(T, M)`` [N] and gaps ``(T, M)`` [m] of the meetings, losses ``(T,)`` [W] of friction and of
    closing balls in the step in which they meet, power put in ``(T,)`` [W] and the rest of it that elastic displacements
    store or lose in their steps ``(T,)`` [W]; seconds of processor time; "converged", or the first step that did not and
    why."""

    time: Array
    speed: Array
    rotation: Array
    force: Array
    gap: Array
    loss: Array
    power: Array
    stored: Array
    seconds: float
    status: str

    @property
    def converged(self) -> bool:
        """Whether every step is a solution."""
        return self.status == "converged"


@dataclass(frozen=True)
class _Carried:
    """A contact without its history, its displacements now and where the material was, per force, over the step."""

    contact: Contact
    present: Array
    before: Array

    def at(self, forces: Array) -> Contact:
        """The contact with the history of ``forces`` (2 n,) [N]."""
        return replace(self.contact, elastic=self.present, given=self.contact.given - self.before @ forces)


def run_from_rest(
    scene: Rolling, duration: float, steps: int, gap: float = 0.0, choices: Choices | None = None
) -> TransientResult:
    """Equal steps of ``duration`` [s] from rest, all neighbours ``gap`` [m] apart at first.

    Raises ValueError for a duration, steps or gap that make no sense, and for finite bodies in steps that carry material
    from beyond their contact zone.
    """
    if not duration > 0.0 or steps < 1 or gap < 0.0:
        raise ValueError("need a duration > 0, at least one step and no negative gap")
    return _run(scene, duration / steps, steps, gap, choices or Choices())


def _run(scene: Rolling, dt: float, steps: int, gap: float, choices: Choices) -> TransientResult:
    begin = process_time()
    carried = _carried(scene, choices, dt)
    forces = [np.zeros(c.contact.given.size) for c in carried]
    y, gaps, out, status = start_of(scene), np.full(len(scene.meetings), gap), [], "converged"
    for step in range(steps):
        meetings = tuple(replace(m, apart=float(g) / dt) for m, g in zip(scene.meetings, gaps, strict=True))
        contacts = [c.at(q) for c, q in zip(carried, forces, strict=True)]
        balance = balance_of(replace(scene, meetings=meetings), contacts)
        solution = solve_friction(contacts, balance, y, forces)
        if not solution.converged:
            status = f"step {step + 1}: {solution.status}"
            break
        y, old, forces = solution.motions, forces, solution.forces
        closing = np.array([float(m.rows[0] @ y[m.columns]) for m in scene.meetings])
        gaps = np.maximum(gaps - dt * closing, 0.0)
        out.append(_row(scene, carried, (old, forces), solution.slips, y, gaps))
    speed, rotation, force, gap_left, loss, power, stored = (
        np.array([row[k] for row in out], dtype=float) for k in range(7)
    )
    time = np.asarray(dt * (1.0 + np.arange(len(out))))
    return TransientResult(time, speed, rotation, force, gap_left, loss, power, stored, process_time() - begin, status)


def _carried(scene: Rolling, choices: Choices, dt: float) -> list[_Carried]:
    out = []
    for (_, _, touch), contact in zip(touching(scene), contacts_of(scene, choices), strict=True):
        patch = patch_of(scene, touch, choices)
        shift = rolling_speed(touch, scene) * dt
        if patch.regular is not None and float(patch.at[:, 0].max()) + shift > REACH * patch.regular.scale[0]:
            raise ValueError(
                "a step carries material from beyond the zone of finite bodies: take shorter ones, or half spaces"
            )
        share = choices.elastic / dt
        out.append(_Carried(contact, share * patch.tangential(), share * patch.tangential(shift)))
    return out


def _row(
    scene: Rolling,
    carried: list[_Carried],
    forces: tuple[list[Array], list[Array]],
    slips: list[Array],
    y: Array,
    gaps: Array,
) -> tuple[Array, Array, Array, Array, float, float, float]:
    """Speeds, rotations, forces, gaps, loss, power put in and stored at the end of a step; forces: before and after it."""
    old, new = forces
    speed, rotation, press = moving(scene, y)
    closing = sum(float(f) * float(m.rows[0] @ y[m.columns]) for f, m in zip(press, scene.meetings, strict=True))
    rub = -sum(float(q @ s) for q, s in zip(new, slips, strict=True)) + float(meeting_losses(scene, y).sum())
    power = -sum(float(q @ c.contact.given) for q, c in zip(new, carried, strict=True))
    stored = sum(float(q @ (c.present @ q - c.before @ before)) for q, before, c in zip(new, old, carried, strict=True))
    return speed, rotation, press, gaps, rub + closing, power, stored
