"""Closed formulas of Lin 3.3.3, rederived: ball velocity, ball-to-ball force and loss in four-point contact.

Valid where all four contacts carry load and their velocity centres stay within about half a semi-axis of the contact
centres. The printed (3.42), (3.43), (3.51) carry 1 - cos 2 beta_0 where the derivation gives tan beta_0; both are 1 at
the 45 degrees of the case study. Contacts are ordered BL, BR, TR, TL.
"""

from __future__ import annotations

import numpy as np

from lowfi.friction.linear.bearing import Array, LinearBearing

#: Slope of friction force over c/a read off Lin's Figure 3.11.
K_F = 1.38
_FORCE_SENSE = np.array([1.0, 1.0, -1.0, -1.0])
_SPIN_SENSE = np.array([1.0, -1.0, -1.0, 1.0])


def ball_velocity(angles: Array) -> Array:
    """Velocity of a ball over that of the carriage from the angles gamma ``(..., 4)`` of its points of no slip.

    Mends (3.41): sin(BL+BR) / (sin(BL+BR) + sin(BL+TL) + sin(BR-TL)); the fourth angle must fit (``mismatch`` zero).
    """
    bl, br, _, tl = np.moveaxis(np.asarray(angles, dtype=float), -1, 0)
    return np.asarray(np.sin(bl + br) / (np.sin(bl + br) + np.sin(bl + tl) + np.sin(br - tl)))


def mismatch(angles: Array) -> Array:
    """Left minus right side of (3.38): zero where one rigid motion has its points of no slip at gamma ``(..., 4)``."""
    bl, br, tr, tl = np.moveaxis(np.asarray(angles, dtype=float), -1, 0)
    return np.asarray(np.sin(bl + tl) + np.sin(br - tl) - np.sin(br + tr) - np.sin(bl - tr))


def shifts(bearing: LinearBearing, deviation: Array, loads: Array, force: float = 0.0, k_f: float = K_F) -> Array:
    """Shifts Delta eta + Delta zeta ``(4,)`` [rad] of the points of no slip, loads of the four contacts unequal.

    Solves (3.37) or (3.45), mended, with (3.40), (3.47): force and moments in balance with an axial ``force`` [N]
    against the ball's motion, and one rigid motion. deviation ``(4,)``: Delta beta [rad].
    """
    beta = bearing.contact_angle + np.asarray(deviation, dtype=float)
    constants, radius = bearing.hertz(), bearing.ball_radius
    a = constants.C_a * np.cbrt(loads)
    stiff = _FORCE_SENSE * k_f * bearing.mu * loads * radius / a
    ellip = _second_kind(float(constants.C_b / constants.C_a))
    moment = -_SPIN_SENSE * 0.375 * bearing.mu * loads * a * ellip / radius
    c, s = np.cos(beta), np.sin(beta)
    up = np.array([-1.0, -1.0, 1.0, 1.0])
    side = np.array([1.0, -1.0, -1.0, 1.0])
    rigid = np.array([1.0, -1.0, -1.0, 1.0])
    matrix = np.array([stiff, up * c * stiff, side * s * stiff, rigid * stiff.max()])
    load = np.array([force, -(side * s) @ moment, up @ (c * moment), -stiff.max() * (rigid @ deviation)])
    return np.linalg.solve(matrix, load)


def _second_kind(axis_ratio: float) -> float:
    from scipy.special import ellipe

    return float(ellipe(1.0 - axis_ratio**2))


def deviation_from_shifts(bearing: LinearBearing, deviation: Array, shift: Array) -> float:
    """Deviation epsilon of the ball's velocity from half the carriage's, relative to it: (3.42) with tan beta_0."""
    moved = np.asarray(deviation, dtype=float) + shift
    return float(0.5 * np.tan(bearing.contact_angle) * (moved[3] - moved[1]))


def velocity_deviation(contact_angle: float, deviation: Array, up: Array, down: Array) -> Array:
    """Epsilon of (3.43) with tan beta_0, from Delta beta ``(..., 4)`` [rad] and the diagonals' loads F_U, F_D [N]."""
    bl, br, tr, tl = np.moveaxis(np.asarray(deviation, dtype=float), -1, 0)
    u, d = np.cbrt(np.square(up)), np.cbrt(np.square(down))
    return np.asarray(0.5 * np.tan(contact_angle) * ((tr - bl) * u + (tl - br) * d) / (u + d))


def ball_force(bearing: LinearBearing, loads: Array, difference: Array, k_f: float = K_F) -> Array:
    """Force [N] between two balls in reach: (3.51) with exponents +2/3 and tan beta_0; zero unless they close.

    loads ``(..., 2, 2)``: F_U, F_D [N] of balls 1 and 2; difference: epsilon_1 - epsilon_2.
    """
    stiff = np.cbrt(np.square(loads)).sum(axis=-1)
    both = stiff[..., 0] * stiff[..., 1] / (stiff[..., 0] + stiff[..., 1])
    factor = 2.0 * k_f * bearing.mu * np.cbrt(bearing.ball_radius**2) / (bearing.psi() * np.tan(bearing.contact_angle))
    return np.asarray(factor * both * np.maximum(difference, 0.0))


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
    ellip = _second_kind(float(constants.C_b / constants.C_a))
    return np.asarray(0.375 * bearing.mu * loads * constants.C_a * np.cbrt(loads) * ellip * spin)
