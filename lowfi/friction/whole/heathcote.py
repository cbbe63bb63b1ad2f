"""Heathcote slip: motion, friction and losses of balls whose contacts are curved across the groove.

The motions of ``lowfi.friction.whole.losses`` are those of flat contact ellipses. Ball and groove meet in a surface of
radius R_d across the groove, 1/R_d = (1/R_ball + 1/R_groove)/2. A ball that rolls with the angular speed Omega about the
axis across the groove moves a point at distance x from the contact's middle by Omega x^2 /(2 R_d) more along the path than
the middle. The motion of least dissipation with that speed is found by quadrature over the ellipses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rollbench.lowfi.friction.screw.groove import ON_SCREW, contact_axes
from rollbench.lowfi.friction.whole.contacts import StaticContacts
from rollbench.lowfi.friction.whole.losses import (
    BallFriction,
    BallsUnderLoad,
    ball_friction_from_motions,
    ball_kinematics,
    friction_of_groups,
    relative_friction_coefficients,
)
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import nominal_groove_radii
from rollbench.meshes.parts import Motion as Drive
from rollbench.meshes.parts import Scene

#: Numbers of quadrature points of a contact ellipse: along a radius, and around the ellipse.
OUTWARDS, ROUND = 10, 20

#: Regularising speeds of friction as fractions of a typical sliding speed, used one after the other; largest number of
#: Newton steps at each; largest number of halvings of a step.
SPEEDS, STEPS, HALVINGS = (0.03, 3e-3, 3e-4, 1e-4), 12, 12

#: Largest force or moment on a ball, as a fraction of its bound of friction, that counts as balance.
BALANCED = 1e-4


def hertz_pressure_quadrature(outwards: int = OUTWARDS, around: int = ROUND) -> tuple[Array, Array, Array]:
    """Return points x, z, then weights of a quadrature over the unit disc, with the Hertz pressure as weight function.

    ``outwards``, ``around``: numbers of points along a radius and around the disc, k in all.

    Returns
    -------
    tuple
        Coordinates x, then z, of the points ``(k,)`` as fractions of the semi-axes of a contact ellipse, then the weights
        ``(k,)``, whose sum is 1.
    """
    node, weight = np.polynomial.legendre.leggauss(outwards)
    height, half = 0.5 * (1.0 + node), 0.5 * weight  # radius^2 = 1 - height^2 makes pressure a polynomial
    radius = np.sqrt(1.0 - height**2)
    turn = 2.0 * np.pi * (np.arange(around) + 0.5) / around
    mass = np.repeat(3.0 * half * height**2 / around, around)
    return np.outer(radius, np.cos(turn)).ravel(), np.outer(radius, np.sin(turn)).ravel(), mass


class SurfaceSpeeds(NamedTuple):
    """Sliding of k points in each of four contacts of n balls, a linear function of the motions of the balls."""

    #: Sliding across and along the groove per unit of a ball's four motions ``(n, 4, k, 2, 4)`` [m].
    rows: Array
    #: Sliding by screw and nut while the ball rests ``(n, 4, k, 2)`` [m/s].
    added: Array
    #: Places of the points across and along the groove, from the middle of each contact ``(n, 4, k, 2)`` [m].
    place: Array


def surface_speeds_in_contacts(scene: Scene, contacts: StaticContacts, drive: Drive) -> SurfaceSpeeds:
    """Return the sliding velocities of the points of `hertz_pressure_quadrature` in each contact, which is curved.

    ``contacts``: contacts of the balls; ``drive``: which part turns, screw or nut, and its angular speed.
    """
    path = ball_kinematics(scene, drive, scene.balls.radius)
    maps, drives = path.contact_kinematics(contacts.normals, contacts.ball_radius)
    body = np.where(ON_SCREW, path.screw_speed, path.nut_speed)
    # angular speed Omega of a ball about the axis across the groove: rolling @ q less the part of screw or nut
    rolling = np.einsum("nsi,ji->nsj", contact_axes(contacts.normals)[:, :, 0], path.ball_rotation_axes)
    bend = 0.25 * (1.0 / contacts.ball_radius[:, None] + 1.0 / nominal_groove_radii(scene))
    x, z, _ = hertz_pressure_quadrature()
    px = np.where(contacts.across, contacts.a, contacts.b)[..., None] * x
    pz = np.where(contacts.across, contacts.b, contacts.a)[..., None] * z
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
    return SurfaceSpeeds(rows, added, np.stack([px, pz], axis=-1))


def least_dissipation_of_curved(
    speeds: SurfaceSpeeds, strength: Array, start: Array, typical_sliding_speed: float
) -> tuple[Array, Array, Array, Array]:
    """Return the motion of least dissipation of each of n balls with curved contacts.

    The motion is found by Newton's method. The sliding speed v is regularised as sqrt(v^2 + eps^2), with eps reduced in
    steps. ``speeds``: sliding of the points in the contacts; ``strength`` ``(n, 4)``: friction bound of each contact,
    coefficient times force [N] (if the coefficients are ratios, power and friction are in the same proportion); ``start``
    ``(n, 4)``: motions to begin from [rad/s]; ``typical_sliding_speed``: a typical sliding speed [m/s], which sets the
    scale of eps.

    Returns
    -------
    tuple
        Motions of the balls ``(n, 4)`` [rad/s]; friction of the ball on the body in each contact, force across and along
        the groove, then moment about the normal ``(n, 4, 3)`` [N, N m]; power lost in each contact ``(n, 4)`` [W]; largest
        derivative of the power of each ball by a motion, as a fraction of what full sliding would give ``(n,)``.
    """
    count, loaded = len(strength), np.flatnonzero((strength > 0.0).any(axis=0))
    mass = strength[:, loaded, None] * hertz_pressure_quadrature()[2]
    weight = mass.reshape(count, -1)
    rows, added = speeds.rows[:, loaded].reshape(count, -1, 4), speeds.added[:, loaded].reshape(*weight.shape, 2)
    q = start.copy()

    def power_and_sliding(motion: Array, eps: float) -> tuple[Array, Array, Array]:
        """Return the dissipated power of each ball [W], then sliding velocities and regularised speeds in contacts [m/s].

        ``motion`` ``(n, 4)``: motions of the n balls [rad/s]. The regularised speed of a sliding velocity v is
        sqrt(v^2 + eps^2).
        """
        v = (rows @ motion[..., None]).reshape(added.shape) + added
        size = np.sqrt(v[..., 0] ** 2 + v[..., 1] ** 2 + eps * eps)
        return (weight * size).sum(axis=1), v, size

    for eps in typical_sliding_speed * np.array(SPEEDS):
        total, v, size = power_and_sliding(q, eps)
        for _ in range(STEPS):
            w = weight / size
            along = np.einsum("npci,npc->npi", rows.reshape(*v.shape, 4), v)
            gradient = (w[:, None] @ along)[:, 0]
            hessian = rows.swapaxes(1, 2) @ (np.repeat(w, 2, axis=1)[..., None] * rows)
            hessian -= along.swapaxes(1, 2) @ ((w / size**2)[..., None] * along)
            floor = 1e-10 * np.einsum("nii->n", hessian)
            step = -np.linalg.solve(hessian + floor[:, None, None] * np.eye(4), gradient[..., None])[..., 0]
            length = np.ones(count)
            for _ in range(HALVINGS):
                worse = ~(power_and_sliding(q + length[:, None] * step, eps)[0] <= total)
                if not worse.any():
                    break
                length = np.where(worse, 0.5 * length, length)
            length[worse] = 0.0
            before, q = total, q + length[:, None] * step
            total, v, size = power_and_sliding(q, eps)
            if float((before - total).max()) <= 1e-12 * float(before.max()):
                break
    share = (weight / size)[..., None] * v
    gradient = np.abs(np.einsum("npci,npc->ni", rows.reshape(*v.shape, 4), share))
    bound = np.einsum("npci,np->ni", np.abs(rows.reshape(*v.shape, 4)), weight)
    parts = share.reshape(count, loaded.size, -1, 2)
    place = speeds.place[:, loaded]
    pull, power = np.zeros((count, 4, 3)), np.zeros((count, 4))
    pull[:, loaded, :2] = parts.sum(axis=2)
    pull[:, loaded, 2] = (place[..., 1] * parts[..., 0] - place[..., 0] * parts[..., 1]).sum(axis=2)
    power[:, loaded] = (weight * np.hypot(v[..., 0], v[..., 1])).reshape(count, loaded.size, -1).sum(axis=2)
    return q, pull, power, (gradient / np.where(bound > 0.0, bound, 1.0)).max(axis=1)


def friction_of_curved_contacts(groups: Sequence[BallsUnderLoad], starts: Sequence[Array] = ()) -> list[BallFriction]:
    """Return motion and friction of every ball of several groups at given contact loads, with Heathcote slip.

    The arguments and results are those of `friction_of_groups`, but the losses have a fourth part, the slip that the
    curvature of the contacts adds. A contact never sticks: friction is regularised at a sliding speed of 1e-4 of the
    largest one. ``starts``: motions to begin from, for every ball with load.
    """
    begin = starts or [by_ball.ball_motions for by_ball in friction_of_groups(groups)]
    return [_friction_in_curved_contacts(balls, start) for balls, start in zip(groups, begin, strict=True)]


def _friction_in_curved_contacts(balls: BallsUnderLoad, start: Array) -> BallFriction:
    """Return motion and friction of the N balls of one group, with Heathcote slip.

    ``start``: motions ``(N, 4)`` [rad/s] to begin from, nan for a ball without load.
    """
    loaded = np.flatnonzero(np.isfinite(start[:, 0]) & (balls.contacts.force > 0.0).any(axis=1))
    (share, top), power = relative_friction_coefficients(balls.friction), np.zeros((len(start), 4))
    moved, status, left = (np.zeros((0, 4)), np.zeros((0, 4, 3)), np.zeros((0, 4, 3))), list[str](), 0.0
    if loaded.size:
        pressed = balls.contacts.subset(loaded)
        path = ball_kinematics(balls.scene, balls.drive, balls.scene.balls.radius)
        maps, drives = path.contact_kinematics(pressed.normals, pressed.ball_radius)
        before = np.einsum("nsij,nj->nsi", maps, start[loaded]) + drives
        rubs = pressed.force > 0.0
        slide = float(np.hypot(np.hypot(before[..., 0], before[..., 1]), pressed.a * before[..., 2])[rubs].max())
        speeds = surface_speeds_in_contacts(balls.scene, pressed, balls.drive)
        found, rubs_back, lost, imbalances = least_dissipation_of_curved(
            speeds, share * pressed.force, start[loaded], slide
        )
        moved = found, np.einsum("nsij,nj->nsi", maps, found) + drives, -top * rubs_back
        power[loaded], left = top * lost, float(imbalances.max())
        status = ["regularised" if imbalance <= BALANCED else "failed" for imbalance in imbalances]
    rigid = ball_friction_from_motions(balls.contacts, loaded, moved, status, left)
    curvature = (power - rigid.loss.sum(axis=2))[..., None]
    return replace(rigid, loss=np.concatenate([rigid.loss, curvature], axis=2))
