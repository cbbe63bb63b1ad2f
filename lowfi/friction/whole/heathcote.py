"""Heathcote slip: what the curvature of the contact across the groove adds to the losses of flat contact ellipses.

Ball and groove meet in a surface of radius R_d across the groove, 1 / R_d = (1 / R_ball + 1 / R_groove) / 2. A ball that
rolls with the angular speed Omega about the axis across the groove moves a point at distance x from the contact's middle by
Omega x^2 / (2 R_d) more along the path than the middle. The motion of least dissipation is found once with that speed and
once without, both by quadrature over the ellipses, so that balls find the motion that makes the most of their contacts.
"""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.friction.screw.groove import ON_SCREW, contact_axes
from rollbench.lowfi.friction.whole.contacts import StaticContacts
from rollbench.lowfi.friction.whole.losses import BallFriction, ball_path, shares
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import groove_radii
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: Points of the quadrature from the middle of a contact outwards and around it.
OUTWARDS, ROUND = 10, 20
#: Regularising speeds as parts of the sliding without curvature, Newton steps at each, halvings of a step.
SPEEDS, STEPS, HALVINGS = (0.3, 0.1, 0.03, 0.01, 0.003), 12, 12
#: Part of the losses from which they are warned of.
WIDE = 0.03


def quadrature(outwards: int = OUTWARDS, around: int = ROUND) -> tuple[Array, Array, Array]:
    """Points x, z (k,) of the unit disc and weights (k,) under Hertz's pressure, which sum up to one."""
    node, weight = np.polynomial.legendre.leggauss(outwards)
    height, half = 0.5 * (1.0 + node), 0.5 * weight  # radius^2 = 1 - height^2 makes pressure a polynomial
    radius = np.sqrt(1.0 - height**2)
    turn = 2.0 * np.pi * (np.arange(around) + 0.5) / around
    mass = np.repeat(3.0 * half * height**2 / around, around)
    return np.outer(radius, np.cos(turn)).ravel(), np.outer(radius, np.sin(turn)).ravel(), mass


def surface_speeds(scene: Scene, at: StaticContacts, drive: Drive, curved: float) -> tuple[Array, Array]:
    """Sliding of the contacts' points as rows (N, 4, k, 2, 4) in a ball's motion and what the drives add (N, 4, k, 2).

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
    """Least power (N,) [W] over the motions of N balls, by Newton's method at falling regularising speeds.

    strength (N, 4): mu F [N]; start (N, 4): motions to begin from; slide: a typical sliding speed [m/s].
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
    """Part by which Heathcote slip raises the losses of all contacts at their loads; nan where nothing is lost.

    Good to about 0.002 (quadrature and regularising speeds, the same with and without curvature).
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
