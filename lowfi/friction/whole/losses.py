"""Motion, friction and losses of every ball of a screw or bearing at the contact loads of a static model.

The motion of each ball is that of least dissipation (``motion``); friction does not change the loads. The sums that
follow from it, torques and efficiencies, are in ``screw_torque``.

Heathcote slip is what the curvature of the contact across the groove adds to the losses of flat contact ellipses. Ball and
groove meet in a surface of radius R_d across the groove, 1/R_d = (1/R_ball + 1/R_groove)/2. A ball that rolls with
the angular speed Omega about the axis across the groove moves a point at distance x from the contact's middle by Omega x^2
/(2 R_d) more along the path than the middle. The motion of least dissipation is found once with that speed and once
without, both by quadrature over the ellipses, so that balls find the motion that makes the most of their contacts.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.friction.contact.motion import STATUS
from rollbench.lowfi.friction.screw.chain import FrictionContacts
from rollbench.lowfi.friction.screw.groove import ON_SCREW, HelicalMotion, contact_axes
from rollbench.lowfi.friction.screw.motion import contact_wrench
from rollbench.lowfi.friction.whole.contacts import StaticContacts
from rollbench.lowfi.jit import CONTACT, kernels
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import groove_radii, reduced_lead
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: What a contact loses power by: sliding of its centre across the groove, along the path, spin about the normal.
CAUSES = ("sliding_across", "sliding_along", "spin")

#: Force out of balance, as a part of a ball's sum of mu F, beyond which its motion has failed.
UNBALANCED = 1e-6


@dataclass(frozen=True)
class BallPath(HelicalMotion):
    """Ball of a given radius on the scene's helix."""

    #: [m].
    ball_radius: float
    #: [m].
    pitch_radius: float
    #: [rad].
    contact_angle: float
    #: [m].
    lead: float
    #: [rad/s].
    nut_speed: float
    #: [rad/s].
    screw_speed: float


@lru_cache(maxsize=64)
def ball_path(scene: Scene, drive: Drive, ball_radius: float) -> BallPath:
    """Return the kinematics of a ball of a radius [m] in a scene whose screw or nut turns; cached."""
    screw = drive.speed if drive.turns == "screw" else 0.0
    track = scene.track
    lead = 2.0 * np.pi * reduced_lead(track)
    return BallPath(ball_radius, track.pitch_radius, track.contact_angle, lead, drive.speed - screw, screw)


@dataclass(frozen=True)
class BallFriction:
    """Motion and friction of N balls, contacts in the order SL, SR, NL, NR."""

    #: Speed about the axis of a frame in which the part that does not rotate is at rest ``(N,)`` [rad/s]; nan without load.
    orbit: Array
    #: About x3, y3, z3, relative to that turning frame ``(N, 3)`` [rad/s]; nan without load.
    rotation: Array
    #: Of the ball against the groove: sliding of the contact's centre across (x) and along (z) the groove, and spin about
    #: the normal ``(N, 4, 3)`` [m/s, rad/s].
    motion: Array
    #: Force of friction on the ball along x and z ``(N, 4, 2)`` [N].
    force: Array
    #: Moment of friction on the ball about the normal ``(N, 4)`` [N m].
    moment: Array
    #: Loss by ``CAUSES`` ``(N, 4, 3)`` [W].
    loss: Array
    #: Which contacts stick ``(N, 4)``.
    rest: NDArray[np.bool_]
    #: Status of each ball; ``"no load"`` for one that nothing presses.
    status: tuple[str, ...]
    #: Largest force out of balance, as a fraction of the ball's sum of mu F.
    left: float

    @property
    def converged(self) -> bool:
        """Whether the friction of every ball balances."""
        return "failed" not in self.status

    @property
    def q(self) -> Array:
        """Motions ``(N, 4)`` [rad/s]: orbit, then rotation."""
        return np.column_stack([self.orbit, self.rotation])

    @property
    def power(self) -> float:
        """Power lost by all contacts [W]."""
        return float(self.loss.sum())

    def wrench(self, normals: Array) -> Array:
        """Return the friction force and moment on the ball at each contact in x3, y3, z3 ``(N, 4, 6)`` [N, N m]."""
        return contact_wrench(normals, self.force, self.moment)


def ball_friction(
    scene: Scene, at: StaticContacts, friction: Friction, drive: Drive, fast: bool = False, near: Array | None = None
) -> BallFriction:
    """Return the motion of least dissipation and the friction of every ball.

    Where all coefficients are zero the motion is the limit for equal ones that vanish. Valid for a helix of any hand and
    number of starts and for a ring (zero lead); groove errors and the bending of the screw enter by loads and contact
    angles, not by the directions of motion.

    Parameters
    ----------
    scene, at
        The scene and the contacts of its balls.
    friction, drive
        Coefficients, and the motion of screw or nut.
    fast
        Whether to use compiled kernels.
    near
        Motions of a similar state to begin from ``(N, 4)`` (``BallFriction.q``), nan where none is known.

    Raises
    ------
    ValueError
        No motion.
    """
    if drive.speed == 0.0:
        raise ValueError("friction at rest is not determined: give a speed")
    count = at.force.shape[0]
    loaded = np.flatnonzero(at.force.sum(axis=1) > 0.0)
    pressed = at.subset(loaded)
    share, top = shares(friction)
    rubs = rubs_of(scene, pressed, share, drive)
    n = loaded.size
    q = np.full((n, 4), np.nan) if near is None else near[loaded]
    forces, rests, outcome = np.zeros((n, 4, 3)), np.zeros((n, 4)), np.zeros((n, 2))
    kernels(CONTACT, compiled=fast).least_dissipation_of_bodies(
        rubs.shape, rubs.maps, rubs.drives, q, forces, rests, outcome
    )
    seen = rubs.drives + np.einsum("nirj,nj->nir", rubs.maps, q)
    seen[rests > 0.0] = 0.0
    turn_back(pressed, seen)
    turn_back(pressed, forces)
    every, motion, pull = np.full((count, 4), np.nan), np.zeros((count, 4, 3)), np.zeros((count, 4, 3))
    rest, status = np.zeros((count, 4), dtype=bool), ["no load"] * count
    every[loaded], motion[loaded], pull[loaded] = q, seen, -top * forces
    rest[loaded] = (rests > 0.0) & (pressed.force > 0.0)
    left = outcome[:, 1] / rubs.shape[..., 2].sum(axis=1)
    for k, code, off in zip(loaded, outcome[:, 0].astype(int), left, strict=True):
        status[k] = STATUS[code] if off <= UNBALANCED else "failed"
    return from_motions(at, every, motion, pull, rest, status, float(left.max(initial=0.0)))


def from_motions(
    at: StaticContacts, q: Array, motion: Array, pull: Array, rest: NDArray[np.bool_], status: list[str], left: float
) -> BallFriction:
    """Return the record of N balls from their motions.

    q ``(N, 4)``: motions, nan without load; pull ``(N, 4, 3)``: force and moment of friction; the rest as in the record.
    """
    loaded = at.force[..., None] > 0.0
    loss = np.where(loaded, -pull * np.nan_to_num(motion), 0.0) + 0.0
    seen = np.where(loaded, motion, np.nan)
    return BallFriction(q[:, 0], q[:, 1:], seen, pull[..., :2], pull[..., 2], loss, rest, tuple(status), left)


def shares(friction: Friction) -> tuple[Array, float]:
    """Return the coefficients at the contacts as parts of the largest ``(4,)``, and that one; ones where all are zero.

    Motions depend only on ratios of coefficients: without friction they are the limit for equal ones that vanish.
    """
    mu = np.array([friction.screw, friction.screw, friction.nut, friction.nut])
    top = float(mu.max())
    return (mu / top if top > 0.0 else np.ones(4)), top


def rubs_of(scene: Scene, at: StaticContacts, share: Array, drive: Drive) -> FrictionContacts:
    """Return the contacts as friction needs them, with coefficients ``share`` ``(4,)``; axes x along the long semi-axis."""
    maps, drives = ball_path(scene, drive, scene.balls.radius).maps(at.normals, at.ball_radius)
    for rows in (maps, drives):
        rows[~at.across] = _quarter(rows[~at.across])
    return FrictionContacts(
        np.stack([at.a, at.b, share * at.force], axis=-1), np.ascontiguousarray(maps), np.ascontiguousarray(drives)
    )


def turn_back(at: StaticContacts, values: Array) -> None:
    """Rotate values in the axes of `rubs_of` ``(N, 4, 3)`` to x across the groove and z along it, in place."""
    values[~at.across] = _quarter(values[~at.across], -1.0)


def _quarter(rows: Array, sign: float = 1.0) -> Array:
    """Return components ``(k, 3, ...)`` along contact axes x, z turned by a quarter about their normals; sign -1: back."""
    return np.stack([sign * rows[:, 1], -sign * rows[:, 0], rows[:, 2]], axis=1)


def closing_speeds(scene: Scene, at: StaticContacts, by_ball: BallFriction, drive: Drive) -> Array:
    """Return the speed at which a ball approaches the next one of its start ``(N,)`` [m/s]; nan without one or load.

    The next one is at the larger azimuth; a ring's last ball is followed by its first, where the balls fill the turn.
    """
    path = ball_path(scene, drive, scene.balls.radius)
    count, starts = at.force.shape[0], scene.track.starts
    closing = np.full(count, np.nan)
    per_start = count // starts
    for k in range(starts):
        balls = np.arange(k * per_start, (k + 1) * per_start)
        order = balls[np.argsort(at.layout.azimuth[balls], kind="stable")]
        closing[order[:-1]] = path.radius * (by_ball.orbit[order[:-1]] - by_ball.orbit[order[1:]])
        if scene.track.lead == 0.0 and per_start > 1:
            closing[order[-1]] = path.radius * (by_ball.orbit[order[-1]] - by_ball.orbit[order[0]])
    return closing


#: Points of the quadrature from the middle of a contact outwards and around it.
OUTWARDS, ROUND = 10, 20

#: Regularising speeds as parts of the sliding without curvature, Newton steps at each, halvings of a step.
SPEEDS, STEPS, HALVINGS = (0.3, 0.1, 0.03, 0.01, 0.003), 12, 12

#: Part of the losses from which they are warned of.
WIDE = 0.03


def quadrature(outwards: int = OUTWARDS, around: int = ROUND) -> tuple[Array, Array, Array]:
    """Return points x, z ``(k,)`` of the unit disc and weights ``(k,)`` under Hertz's pressure, which sum up to one."""
    node, weight = np.polynomial.legendre.leggauss(outwards)
    height, half = 0.5 * (1.0 + node), 0.5 * weight  # radius^2 = 1 - height^2 makes pressure a polynomial
    radius = np.sqrt(1.0 - height**2)
    turn = 2.0 * np.pi * (np.arange(around) + 0.5) / around
    mass = np.repeat(3.0 * half * height**2 / around, around)
    return np.outer(radius, np.cos(turn)).ravel(), np.outer(radius, np.sin(turn)).ravel(), mass


def surface_speeds(scene: Scene, at: StaticContacts, drive: Drive, curved: float) -> tuple[Array, Array]:
    """Return the sliding of the contacts' points by a ball's motion ``(N, 4, k, 2, 4)`` and by the drives ``(N, 4, k, 2)``.

    curved: factor of the contacts' curvature, 0 for flat ellipses.
    """
    path = ball_path(scene, drive, scene.balls.radius)
    maps, drives = path.maps(at.normals, at.ball_radius)
    body = np.where(ON_SCREW, path.screw_speed, path.nut_speed)
    rolling = np.einsum("nsi,ji->nsj", contact_axes(at.normals)[:, :, 0], path.turns)  # Omega = rolling @ q - body part
    bend = 0.25 * curved * (1.0 / at.ball_radius[:, None] + 1.0 / groove_radii(scene))
    x, z, _ = quadrature()
    px = np.where(at.across, at.a, at.b)[..., None] * x
    pz = np.where(at.across, at.b, at.a)[..., None] * z
    lift = bend[..., None] * px**2
    rows = np.stack(
        [
            maps[:, :, None, 0] + pz[..., None] * maps[:, :, None, 2],
            maps[:, :, None, 1] - px[..., None] * maps[:, :, None, 2] + lift[..., None] * rolling[:, :, None],
        ],
        axis=3,
    )
    roll = -(body * rolling[..., 0])[..., None] * lift
    added = np.stack(
        [drives[..., None, 0] + pz * drives[..., None, 2], drives[..., None, 1] - px * drives[..., None, 2] + roll], axis=-1
    )
    return rows, added


def least_power(rows: Array, added: Array, strength: Array, start: Array, slide: float) -> Array:
    """Return the least power over the motions of N balls ``(N,)`` [W], by Newton's method at falling regularising speeds.

    strength ``(N, 4)``: mu F [N]; start ``(N, 4)``: motions to begin from; slide: a typical sliding speed [m/s].
    """
    loaded = (strength > 0.0).any(axis=0)
    weight = (strength[:, loaded, None] * quadrature()[2]).reshape(len(strength), -1)
    rows, added = rows[:, loaded].reshape(len(weight), -1, 4), added[:, loaded].reshape(*weight.shape, 2)
    q = start.copy()

    def value(motion: Array, eps: float) -> tuple[Array, Array, Array]:
        v = (rows @ motion[..., None]).reshape(added.shape) + added
        size = np.sqrt(v[..., 0] ** 2 + v[..., 1] ** 2 + eps * eps)
        return (weight * size).sum(axis=1), v, size

    for eps in slide * np.array(SPEEDS):
        total, v, size = value(q, eps)
        for _ in range(STEPS):
            w = weight / size
            along = np.einsum("npci,npc->npi", rows.reshape(*v.shape, 4), v)
            gradient = (w[:, None] @ along)[:, 0]
            hessian = rows.swapaxes(1, 2) @ (np.repeat(w, 2, axis=1)[..., None] * rows)
            hessian -= along.swapaxes(1, 2) @ ((w / size**2)[..., None] * along)
            floor = 1e-10 * np.einsum("nii->n", hessian)
            step = -np.linalg.solve(hessian + floor[:, None, None] * np.eye(4), gradient[..., None])[..., 0]
            length = np.ones(q.shape[0])
            for _ in range(HALVINGS):
                worse = ~(value(q + length[:, None] * step, eps)[0] <= total)
                if not worse.any():
                    break
                length = np.where(worse, 0.5 * length, length)
            length[worse] = 0.0
            before, q = total, q + length[:, None] * step
            total, v, size = value(q, eps)
            if float((before - total).max()) <= 1e-12 * float(before.max()):
                break
    return value(q, 0.0)[0]


def heathcote(scene: Scene, at: StaticContacts, by_ball: BallFriction, friction: Friction, drive: Drive) -> float:
    """Return the part by which Heathcote slip raises the losses of all contacts at their loads; nan where nothing is lost.

    Accurate to about 0.002 (quadrature and regularising speeds, the same with and without curvature).

    Parameters
    ----------
    scene
        Screw or bearing.
    at
        Contacts under the static loads.
    by_ball
        Motion and friction of each ball.
    friction
        Coefficients of friction.
    drive
        Motion of screw and nut.
    """
    balls = np.flatnonzero(np.isfinite(by_ball.orbit))
    if balls.size == 0:
        return float("nan")
    pressed, share = at.subset(balls), shares(friction)[0]
    strength = share * pressed.force
    start = np.column_stack([by_ball.orbit, by_ball.rotation])[balls]
    seen = np.nan_to_num(by_ball.motion[balls])
    slide = float(np.sqrt(np.max(seen[..., 0] ** 2 + seen[..., 1] ** 2 + (pressed.a * seen[..., 2]) ** 2)))
    if slide == 0.0:
        return float("nan")
    flat, curved = (
        float(least_power(*surface_speeds(scene, pressed, drive, factor), strength, start, slide).sum())
        for factor in (0.0, 1.0)
    )
    return curved / flat - 1.0
