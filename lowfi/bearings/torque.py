"""Friction torque of ball and tapered roller bearings: Palmgren's and Timken's empirical formulas, in SI units.

Palmgren's constants come from units of kg, mm and s; they are kept as published and converted here.
"""

from __future__ import annotations

import numpy as np

from rollbench.meshes.quantity import quantity, record

#: One kilogram-force [N].
KILOGRAM_FORCE = 9.80665
#: Least kinematic viscosity times speed [mm^2/s rpm] at which the film, and with it the formula, holds.
LEAST_FILM = 2000.0
_INCH, _POUND = 0.0254, 4.4482216152605


def viscous_torque(factor: float, pitch_diameter: float, viscosity: float, speed: float) -> float:
    """Load-independent torque M_0 [N m] of a ball bearing: 1e-8 kg f_0 (nu n)^(2/3) d_m^3 in mm, mm^2/s, rpm (Smith 2.32).

    factor: f_0, design and lubrication; pitch_diameter [m]; viscosity: kinematic [m^2/s]; speed [rad/s].
    His 2.31 with the exponent 2/3 (printed 3/2) and atmospheric pressure agrees to 2 % for oil of 900 kg/m^3. Valid for
    nu n >= 2000 mm^2/s rpm, where the film is above a micron; ValueError below.
    """
    film = 1e6 * viscosity * speed * 30.0 / np.pi
    if film < LEAST_FILM:
        raise ValueError(f"viscosity times speed is {film:.3g} mm2/s rpm: the formula needs at least {LEAST_FILM:g}")
    return float(1e-8 * KILOGRAM_FORCE * 1e-3 * factor * film ** (2.0 / 3.0) * (1e3 * pitch_diameter) ** 3)


@record
class LoadTorque:
    """Load-dependent torque M_1 [N m] of a ball bearing, factor f_1, equivalent load P_0 [N], static rating C_0 [N]."""

    torque: float = quantity(
        "torque_Nmm",
        "starting torque of one bearing under its preload, by Palmgren's load formula M = f1 F dm (Smith 2.33 to 2.38), "
        "without lubricant and seals",
        error="empirical",
    )
    factor: float = quantity("factor", "its f1 = 0.0013 (P0/C0)^(1/3)")
    equivalent_load: float = quantity("equivalent_load_N", "its static equivalent load P0")
    rating: float = quantity("static_rating_N", "its static rating C0 by Palmgren's formula")


def static_rating(rows: int, balls: int, ball_diameter: float, angle: float, across: float, along: float) -> float:
    """Static load rating C_0 [N] = k_0 i Z sin(alpha) D^2, k_0 = 2.8 kg/mm^2 / (D sqrt(across along)) (Smith 2.36, 2.37).

    ball_diameter [m]; angle [rad]; across, along: relative curvatures [1/m] of the inner contact across the groove and
    along the track, (rho_11 + rho_21) and (rho_12 + rho_22): as printed, (rho_11 + rho_12)(rho_21 + rho_22) is negative.
    """
    k = 2.8 * KILOGRAM_FORCE * 1e6 / (ball_diameter * np.sqrt(across * along))
    return float(k * rows * balls * np.sin(angle) * ball_diameter**2)


def load_torque(
    axial: float, radial: float, pitch_diameter: float, rating: float, *, axial_factor: float = 0.3
) -> LoadTorque:
    """Load-dependent torque M_1 = f_1 g_1 P_0 d_m [N m] (Smith 2.33-2.38).

    axial, radial: static loads [N]; pitch_diameter [m]; rating C_0 [N]; axial_factor: Y_0 of P_0 = 0.5 F_r + Y_0 F_a.
    f_1 = 0.0013 (P_0/C_0)^(1/3) for contact angles of about 60 degrees; g_1 P_0 = F_a, so that Y_0 enters by f_1 only.
    """
    equivalent = 0.5 * radial + axial_factor * axial
    factor = 0.0013 * float(np.cbrt(equivalent / rating))
    return LoadTorque(factor * axial * pitch_diameter, factor, equivalent, rating)


def taper_torque(geometry: float, viscosity: float, speed: float, axial: float) -> float:
    """Running torque [N m] of a tapered roller bearing under thrust: 3.54e-5 G_1 (n mu)^0.62 F_a^0.30 in-lb (Smith 3.29).

    geometry: the maker's factor G_1, an input; viscosity: dynamic [Pa s]; speed [rad/s]; axial [N].
    Too low below 1700 F_a^0.67/(G_2 mu) rpm in lb and cP (Smith 3.30). Run-in bearings in circulating oil.
    """
    rpm_centipoise = 1e3 * viscosity * speed * 30.0 / np.pi
    pounds = 3.54e-5 * geometry * rpm_centipoise**0.62 * (axial / _POUND) ** 0.30
    return float(pounds * _INCH * _POUND)


def taper_geometry(torque: float, viscosity: float, speed: float, axial: float) -> float:
    """Factor G_1 that a running torque [N m] implies: the inverse of `taper_torque`, for a maker's curve or a test."""
    return torque / taper_torque(1.0, viscosity, speed, axial)
