"""Balls on grooves that do not yield along tangents: Coulomb friction under Hertz's pressure by fine quadrature.

The limit that grids of elastic contacts are differenced against: what a grid's cells, its staircase edge and a spin
pole within a cell do to an answer they do to nearly rigid bodies too, so that

    answer = grid(elastic) - grid(nearly rigid) + limit

keeps of them only what they do to the effect of elasticity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from rollbench.hifi.contact.hertz import hertz
from rollbench.hifi.rolling.balls import Rolling, balance_of, kernel_of, start_of, touching
from rollbench.hifi.rolling.bodies import Sizes
from rollbench.hifi.rolling.friction import PATH, Contact, full_slip, solve_rigid
from rollbench.hifi.rolling.kinematics import MOTIONS, axes_of, motion_rows, surface
from rollbench.hifi.rolling.patch import seen_radii
from rollbench.meshes.arrays import Array

#: Points of the quadrature along each axis of the ellipse, first and last.
FIRST, POINTS = 40, 300


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
    scene: Rolling, points: int = POINTS, *, curved: bool = True, bodies: Sizes | None = None
) -> RigidResult:
    """Steady rolling of rigid bodies under Hertz's pressures. Raises ValueError where no balance is found.

    bodies: finite ones, by the half spaces that touch as they do (`hifi.rolling.patch.seen_radii`); None: half spaces.
    """
    y = start_of(scene)
    with threadpool_limits(1):  # as `hifi.rolling.balls.solve_rolling`
        for count in (FIRST, points):
            contacts = _contacts(scene, count, curved, bodies)
            path = PATH if count == FIRST else PATH[-2:]
            y, remainder = solve_rigid(contacts, balance_of(scene, contacts), y, path)
    return _result(scene, contacts, y, remainder)


def _contacts(scene: Rolling, points: int, curved: bool, bodies: Sizes | None) -> list[Contact]:
    unit, weight = quadrature(points)
    contacts = []
    for b, _, touch in touching(scene):
        material = scene.young, scene.poisson
        ellipse = hertz(
            touch.load, *seen_radii(touch.load, touch.radii, *material, kernel_of(scene, touch, bodies)), *material
        )
        semi = np.array([ellipse.semi_x, ellipse.semi_y])
        local = unit * semi
        normal = ellipse.pressure(local[:, 0], local[:, 1]) * weight * semi.prod()
        axes = axes_of(touch, scene.track, scene.radius, scene.orbit)
        at, tangents = surface(axes, scene.radius, touch.radii, local, curved=curved)
        rows = np.einsum("nck,nkm->cnm", tangents, motion_rows(scene.track, scene.radius, at)).reshape(-1, MOTIONS)
        given = -touch.ride * np.einsum("nck,nk->cn", tangents, scene.track.field(at)).ravel()
        normal *= touch.load / normal.sum()
        contacts.append(Contact(scene.mu * normal, np.zeros((0, 0)), rows, MOTIONS * b + np.arange(MOTIONS), given))
    return contacts


def _result(scene: Rolling, contacts: list[Contact], y: Array, remainder: float) -> RigidResult:
    count = len(scene.balls)
    motions, force = y[: MOTIONS * count].reshape(count, MOTIONS), y[MOTIONS * count :]
    slips = [c.rigid_slip(y) for c in contacts]
    loss = [-float(full_slip(c.bound, s) @ s) for c, s in zip(contacts, slips, strict=True)]
    rub = [
        scene.mu_balls * f * float(np.linalg.norm((m.rows @ y[m.columns])[1:]))
        for f, m in zip(force, scene.meetings, strict=True)
    ]
    return RigidResult(
        motions[:, 0] / scene.track.length, motions[:, 1:] / scene.radius, force, np.array(loss), np.array(rub), remainder
    )
