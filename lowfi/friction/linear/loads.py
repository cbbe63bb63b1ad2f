"""Normal loads of one ball between two V-grooves under N_y (pressing) and N_x = rho N_y on the carriage, three ways.

Friction does not enter: in a linear bearing it acts along the track, so loads come first (Lin 3.3.2).
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from rollbench.lowfi.friction.contact.records import CellArrays
from rollbench.lowfi.friction.contact.rings import settle_cell
from rollbench.lowfi.friction.linear.bearing import SENSE, LinearBearing, directions
from rollbench.meshes.arrays import Array

Loads = Literal["diagonal", "balanced", "elastic"]
#: Contacts with those of the carriage first, and back again.
TOP_FIRST = [2, 3, 0, 1]


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
    sum 2/5 C^(-3/2) <approach>^(5/2) - N_x u_x + N_y u_y over the motions of ball and carriage. Raises ArithmeticError
    where the search finds no balance.
    """
    pairs = [_elastic(bearing, a, vertical, float(r)) for a, r in zip(angles, side_ratio, strict=True)]
    return np.array([p[0] for p in pairs]), np.array([p[1] for p in pairs])


def _elastic(bearing: LinearBearing, angles: Array, vertical: float, rho: float) -> tuple[Array, Array]:
    """Loads and angles (4,) of one ball; the carriage, on contacts 2 and 3, is the inner body of the cell."""
    n, slack, C = directions(angles), bearing.ball_radius * (2.0 * bearing.conformity - 1.0), float(bearing.hertz().C)
    pull, place = vertical * np.array([rho, -1.0]), np.array([rho, -1.0]) * C * vertical ** (2.0 / 3.0)
    cell = CellArrays(
        start=np.ascontiguousarray(slack * n[None, TOP_FIRST]),
        interference=np.zeros((1, 4)),
        C=np.full(4, C),
        section=np.eye(2)[None],
        offset=np.zeros((1, 2)),
        push=np.zeros((1, 2)),
        pull=pull,
        reach=slack,
    )

    def angles_of(normal: Array) -> Array:
        outward = SENSE * normal[:, TOP_FIRST]
        return np.asarray(np.arctan2(outward[..., 0], outward[..., 1]))

    settled = settle_cell(cell, float(np.linalg.norm(pull)), place[None].copy(), 2.0 * place, angles_of)
    if not settled.converged:
        raise ArithmeticError(f"contact loads out of balance by {settled.left:.1e} N after {settled.steps} steps")
    return settled.force[0, TOP_FIRST], settled.angle[0]
