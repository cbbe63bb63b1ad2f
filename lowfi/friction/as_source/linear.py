"""The source's method for balls in a linear bearing, kept for comparison: a root at given loads (Lin 3.3.1, 3.3.2)."""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.friction.as_source.chain import SHARPNESS, Balls, Neighbours, SourceMotion, solve_by_root
from rollbench.lowfi.friction.contact.ellipse import contacts
from rollbench.lowfi.friction.contact.laws import Coulomb, Law, Sigmoid
from rollbench.lowfi.friction.linear.bearing import MOVING, LinearBearing, directions, semi_axes
from rollbench.lowfi.friction.linear.pair import pair_state
from rollbench.meshes.arrays import Array, Mask


def neighbours(bearing: LinearBearing) -> Neighbours:
    """Balls of a linear bearing in touch (Lin 3.26-3.29); unknowns v, omega_x, omega_y."""
    r, v = bearing.ball_radius, bearing.speed
    turns = np.array([[0.0, 0.0, r], [0.0, -r, 0.0]])
    nominal = np.array([0.5 * v, 0.5 * v / (r * np.cos(bearing.contact_angle)), 0.0])
    return Neighbours(turns, -turns, 1.0, bearing.mu_balls, np.array([1.0, r, r]), nominal)


def linear_balls(bearing: LinearBearing, angles: Array, loads: Array) -> Balls:
    """N balls with contact angles [rad] and normal loads [N], both (N, 4), in the order BL, BR, TR, TL.

    Contact motions by Lin 3.22-3.24. Raises ValueError for loads that are negative.
    """
    angles, loads = np.atleast_2d(np.asarray(angles, dtype=float)), np.atleast_2d(np.asarray(loads, dtype=float))
    r, n = bearing.ball_radius, directions(angles)
    a, b = semi_axes(bearing, np.maximum(loads, max(1e-9 * float(loads.max()), 1e-30)))
    at = contacts(a.ravel(), b.ravel(), loads.ravel(), bearing.mu)
    maps = np.zeros((*loads.shape, 3, 3))
    maps[..., 1, 0] = 1.0
    maps[..., 1, 1], maps[..., 1, 2] = r * n[..., 1], -r * n[..., 0]
    maps[..., 2, 1], maps[..., 2, 2] = n[..., 0], n[..., 1]
    drives = np.zeros((*loads.shape, 3))
    drives[..., 1] = -MOVING * bearing.speed
    return Balls(at, maps, drives, neighbours(bearing))


def linear_law(bearing: LinearBearing, sharpness: float | None = SHARPNESS) -> Law:
    """Sigmoid of Lin 3.20 with k_S = ``sharpness`` and the nominal spin v tan(beta) / (2 R_B); None: Coulomb.

    The reference is an assumption: 3.25 prints no sigmoid, and the rotary bearing's (difference of the rings' spins)
    is zero between grooves that do not turn.
    """
    if sharpness is None:
        return Coulomb()
    return Sigmoid(sharpness, 0.5 * abs(bearing.speed) * float(np.tan(bearing.contact_angle)) / bearing.ball_radius)


def solve_linear_by_root(
    bearing: LinearBearing, angles: Array, loads: Array, reach: Mask | bool = True, law: Law | None = None
) -> SourceMotion:
    """Balls in a linear bearing as the source solves them (Lin 3.25-3.31); law: Coulomb's, as 3.25 prints it, if None.

    angles [rad], loads [N]: (N, 4); reach (N-1,): neighbours near enough to touch.
    """
    balls = linear_balls(bearing, angles, loads)
    near = np.broadcast_to(np.asarray(reach, dtype=bool), (balls.count - 1,))
    return solve_by_root(balls, Coulomb() if law is None else law, near)


def linear_pair_by_root(
    bearing: LinearBearing, theta: float, rho: float, vertical: float, law: Law | None = None
) -> SourceMotion:
    """Case study of Lin 3.3.4 by the source's method: theta [rad], side force ratio rho, N_y [N] on each ball, in reach.

    Loads in equilibrium at the given angles, in closed form as in the linear pair here.
    """
    return solve_linear_by_root(bearing, *pair_state(bearing, theta, rho, vertical), True, law)
