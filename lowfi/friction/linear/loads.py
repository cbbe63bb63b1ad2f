"""Normal loads of one ball between two V-grooves under N_y (pressing) and N_x = rho N_y on the carriage, three ways.

Friction does not enter: in a linear bearing it acts along the track, so loads come first (Lin 3.3.2).
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from lowfi.friction.linear.bearing import SENSE, Array, LinearBearing, directions

Loads = Literal["diagonal", "balanced", "elastic"]


def diagonal_loads(vertical: float, side_ratio: Array, contact_angle: float = 0.25 * np.pi) -> Array:
    """Contact loads ``(..., 4)`` [N] equal on each diagonal, as in the text before Lin (3.54).

    F_BL = F_TR = (N_y/cos - N_x/sin)/2, F_BR = F_TL with plus. Raises ValueError where a diagonal would have to pull:
    abs(rho) > tan(contact angle).
    """
    rho = np.asarray(side_ratio, dtype=float)
    upright, across = 0.5 / np.cos(contact_angle), 0.5 * rho / np.sin(contact_angle)
    up, down = vertical * (upright - across), vertical * (upright + across)
    if np.any(np.minimum(up, down) < -1e-12 * vertical):
        raise ValueError("side force ratio rho must lie within the tangent of the contact angle: a diagonal opens")
    up, down = np.maximum(up, 0.0), np.maximum(down, 0.0)
    return np.stack([up, down, up, down], axis=-1)


def balanced_loads(angles: Array, vertical: float, side_ratio: Array) -> Array:
    """Contact loads ``(N, 4)`` [N] in equilibrium at the given contact angles ``(N, 4)``; negative ones are zero.

    Two equations give the top's two loads from the force on the carriage, two the bottom's from the ball.
    """
    n, rho = directions(angles), np.asarray(side_ratio, dtype=float)
    carriage = vertical * np.stack([rho, -np.ones_like(rho)], axis=-1)
    top = np.linalg.solve(np.swapaxes(n[:, 2:], 1, 2), -carriage[..., None])[..., 0]
    bottom = np.linalg.solve(np.swapaxes(n[:, :2], 1, 2), carriage[..., None])[..., 0]
    return np.asarray(np.maximum(np.concatenate([bottom, top], axis=1), 0.0))


def elastic_loads(bearing: LinearBearing, angles: Array, vertical: float, side_ratio: Array) -> tuple[Array, Array]:
    """Contact loads [N] and angles under load [rad], both ``(N, 4)``: Hertz contacts, no clearance, no friction.

    angles: those of the unloaded ball, which touches all four grooves. The least of the energy
    sum 2/5 C^(-3/2) <approach>^(5/2) - N_x u_x + N_y u_y over the motions of ball and carriage.
    """
    pairs = [_elastic(bearing, a, vertical, float(r)) for a, r in zip(angles, side_ratio, strict=True)]
    return np.array([p[0] for p in pairs]), np.array([p[1] for p in pairs])


def _elastic(bearing: LinearBearing, angles: Array, vertical: float, rho: float) -> tuple[Array, Array]:
    n, slack = directions(angles), bearing.ball_radius * (2.0 * bearing.conformity - 1.0)
    stiffness = float(bearing.hertz().C) ** -1.5
    motion = np.hstack([np.tile(np.eye(2), (4, 1, 1)), np.zeros((4, 2, 2))])
    motion[2:, 2:] = -np.eye(2)  # of ball (2) and carriage (2), relative to the groove, as (4, 4, 2)
    force = vertical * np.array([0.0, 0.0, rho, -1.0])

    def evaluate(q: Array) -> tuple[float, Array, Array, Array, Array]:
        move = np.einsum("kij,i->kj", motion, q)
        d = slack * n + move
        size = np.linalg.norm(d, axis=1)
        # size less slack, built as a change so that its round-off is that of the motion
        change = ((2.0 * slack * n + move) * move).sum(axis=1) / (size + slack)
        m, approach = d / size[:, None], np.maximum(change, 0.0)
        load, slope = stiffness * approach**1.5, 1.5 * stiffness * np.sqrt(approach)
        h = (slope - load / size)[:, None, None] * m[:, :, None] * m[:, None, :]
        h += (load / size)[:, None, None] * np.eye(2)
        gradient = np.einsum("kij,kj,k->i", motion, m, load) - force
        hessian = np.einsum("kia,kab,kjb->ij", motion, h, motion)
        return 0.4 * stiffness * float((approach**2.5).sum()) - float(force @ q), gradient, hessian, load, m

    depth = (vertical / stiffness) ** (2.0 / 3.0)
    q = depth * np.array([rho, -1.0, 2.0 * rho, -2.0])
    energy, gradient, hessian, load, m = evaluate(q)
    for _ in range(200):
        worst = np.abs(gradient).max()
        if worst <= 1e-12 * vertical:
            break
        floor = 1e-9 * np.trace(hessian) * min(1.0, worst / vertical)
        step = -np.linalg.solve(hessian + floor * np.eye(4), gradient)
        step *= min(1.0, 0.3 * slack / np.abs(step).max())
        t, slope, new = 1.0, float(gradient @ step), evaluate(q + step)
        while new[0] > energy + 1e-4 * t * slope and np.abs(new[1]).max() >= worst and t > 1e-12:
            t *= 0.5
            new = evaluate(q + t * step)
        q = q + t * step
        energy, gradient, hessian, load, m = new
    outward = SENSE * m
    return load, np.arctan2(outward[:, 0], outward[:, 1])
