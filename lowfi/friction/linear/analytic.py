"""Closed formulas of Lin 3.3.3, rederived: ball velocity, ball-to-ball force and loss in four-point contact.

Valid where all four contacts carry load and their velocity centres stay within about half a semi-axis of the contact
centres. The printed (3.42), (3.43), (3.51) carry 1 - cos 2 beta_0 where the derivation gives tan beta_0; both are 1 at
the 45 degrees of the case study. Contacts are ordered BL, BR, TR, TL.
"""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.friction.linear.bearing import LinearBearing
from rollbench.meshes.arrays import Array


def second_kind(axis_ratio: float) -> float:
    """Complete elliptic integral E(e) of an ellipse b/a."""
    from scipy.special import ellipe

    return float(ellipe(1.0 - axis_ratio**2))


def velocity_deviation(contact_angle: float, deviation: Array, up: Array, down: Array) -> Array:
    """Epsilon of (3.43) with tan beta_0, from Delta beta ``(..., 4)`` [rad] and the diagonals' loads F_U, F_D [N]."""
    bl, br, tr, tl = np.moveaxis(np.asarray(deviation, dtype=float), -1, 0)
    u, d = np.cbrt(np.square(up)), np.cbrt(np.square(down))
    return np.asarray(0.5 * np.tan(contact_angle) * ((tr - bl) * u + (tl - br) * d) / (u + d))


def ball_force(bearing: LinearBearing, loads: Array, difference: Array, k_f: float) -> Array:
    """Force [N] between two balls in reach: (3.51) with exponents +2/3 and tan beta_0; zero unless they close.

    loads ``(..., 2, 2)``: F_U, F_D [N] of balls 1 and 2; difference: epsilon_1 - epsilon_2; k_f as in ``shifts``.
    """
    stiff = np.cbrt(np.square(loads)).sum(axis=-1)
    in_series = stiff[..., 0] * stiff[..., 1] / (stiff[..., 0] + stiff[..., 1])
    factor = 2.0 * k_f * bearing.mu * np.cbrt(bearing.ball_radius**2) / (bearing.psi() * np.tan(bearing.contact_angle))
    return np.asarray(factor * in_series * np.maximum(difference, 0.0))


def sliding_speed(bearing: LinearBearing) -> float:
    """Speed [m/s] at which two rolling balls rub on each other: abs(v) / cos beta_0 (3.52)."""
    return float(abs(bearing.speed) / np.cos(bearing.contact_angle))


def ball_loss(bearing: LinearBearing, force: Array) -> Array:
    """Loss [W] between two balls under ``force`` [N] (3.53)."""
    return np.asarray(bearing.mu_balls * force * sliding_speed(bearing))


def spin_loss(bearing: LinearBearing, loads: Array) -> Array:
    """Groove loss [W] of contacts that spin about their centres at nominal rolling: omega = v tan(beta_0) / (2 R_B).

    Moment 3/8 mu F a E(e) of (3.32); loads [N] of any shape. The baseline that (3.53) is compared with.
    """
    constants = bearing.hertz()
    spin = 0.5 * abs(bearing.speed) * np.tan(bearing.contact_angle) / bearing.ball_radius
    ellip = second_kind(float(constants.C_b / constants.C_a))
    return np.asarray(0.375 * bearing.mu * loads * constants.C_a * np.cbrt(loads) * ellip * spin)
