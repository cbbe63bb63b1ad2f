"""Elliptical Hertz contact from complete elliptic integrals by the arithmetic-geometric mean.

The integrals are Carlson's R_F and R_D: they run from the circle to the line contact without cancellation, where formulas
with K and E of the eccentricity lose all digits at both ends.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.meshes.arrays import Array

#: Steps of the arithmetic-geometric mean, each of which doubles the digits.
MEANS = 9


@dataclass(frozen=True)
class HertzConstants:
    """Constants of elliptical contact, each of the shape of the curvatures they belong to.

    C: approach = C F^(2/3) [m/N^(2/3)]; C_a, C_b: semi-axes = C_a F^(1/3) [m/N^(1/3)], a >= b;
    eccentricity: sqrt(1 - b2/a2); the pole pressure is 3 F / (2 pi a b).
    """

    C: Array
    C_a: Array
    C_b: Array
    eccentricity: Array

    def pressure(self, force: Array) -> Array:
        """Pole pressure [Pa] at normal force [N]."""
        return np.asarray(1.5 * np.cbrt(force) / (np.pi * self.C_a * self.C_b))


def contact_force(approach: Array | float, C: Array | float) -> Array:
    """Force F = (approach/C)^(3/2) [N] of contacts with constants C [m/N^(2/3)] at approaches [m]; none where they gape.

    Shapes broadcast. C of two contacts in series is the sum of theirs, as they carry one force.

    >>> [round(float(x), 12) for x in (contact_force(4e-6, 1e-6), 1e6 * contact_approach(8.0, 1e-6))]
    [8.0, 4.0]
    >>> float(contact_slope(4e-6, 1e-6)), float(contact_stiffness(8.0, 1e-6))
    (3000000.0, 3000000.0)
    """
    return np.asarray((np.maximum(approach, 0.0) / C) ** 1.5)


def contact_approach(force: Array | float, C: Array | float) -> Array:
    """Approach C F^(2/3) [m] under forces [N]: the inverse of `contact_force`."""
    return np.asarray(C * force ** (2.0 / 3.0))


def contact_slope(approach: Array | float, C: Array | float) -> Array:
    """Tangent stiffness dF/d(approach) = 3 (approach/C)^(1/2)/(2 C) [N/m] at approaches [m]; none where contacts gape."""
    return np.asarray(1.5 * np.sqrt(np.maximum(approach, 0.0) / C) / C)


def contact_stiffness(force: Array | float, C: Array | float) -> Array:
    """The same under forces [N]: 3 F^(1/3)/(2 C)."""
    return np.asarray(1.5 * np.cbrt(force) / C)


def contact_modulus(e1: float, nu1: float, e2: float, nu2: float) -> float:
    """Contact modulus E* [Pa], 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 (Lin B.6)."""
    return 1.0 / ((1.0 - nu1**2) / e1 + (1.0 - nu2**2) / e2)


def axis_ratio(curvature_ratio: Array) -> Array:
    """Ratio b/a of the contact ellipse from the ratio A/B <= 1 of the relative curvatures, along a over along b.

    Solves A/B = R_D(0, k^2, 1) / R_D(0, 1, k^2) for k = b/a by Newton's method in log k, to round-off.
    Equivalent to Lin B.8 with the ratio the right way round (Johnson 1985, 4.28). Valid for 1e-12 <= A/B <= 1.
    """
    ratio = np.asarray(curvature_ratio, dtype=float)
    if np.any(ratio <= 0.0) or np.any(ratio > 1.0 + 1e-12):
        worst = float(np.min(ratio)) if np.any(ratio <= 0.0) else float(np.max(ratio))
        raise ValueError(f"ratio of relative curvatures {worst:.3g} must lie in (0, 1]")
    few, place = np.unique(ratio, return_inverse=True)  # most contacts of a scene are alike
    target = np.log(np.minimum(few, 1.0))
    x = 0.636 * target
    for _ in range(60):
        f = _log_ratio(x) - target
        h = 1e-6
        slope = (_log_ratio(x + h) - _log_ratio(x - h)) / (2.0 * h)
        step = f / slope
        x = np.minimum(x - step, 0.0)
        if np.all(np.abs(step) <= 4e-16 * np.maximum(1.0, np.abs(x)) * 4.0):
            break
    return np.asarray(np.exp(x)[place].reshape(ratio.shape))


def _log_ratio(x: Array) -> Array:
    _, along, across = complete_integrals(np.exp(x))
    return np.asarray(np.log(along / across))


def complete_integrals(k: Array) -> tuple[Array, Array, Array]:
    """R_F(0, 1, k^2), R_D(0, k^2, 1) and R_D(0, 1, k^2) for 1e-6 <= k <= 1, to some round-offs.

    By the arithmetic-geometric mean of 1 and k (DLMF 19.8.5, 19.8.7): R_F = K, and with the sum s of its differences
    R_D(0, k^2, 1) = 3 K (1/2 + s), R_D(0, 1, k^2) = 3 K (1/2 - s)/k^2. scipy.special has them too, but takes longer to
    import than a scene takes to be solved.

    >>> [round(float(x), 12) for x in complete_integrals(np.array(1.0))]
    [1.570796326795, 2.356194490192, 2.356194490192]
    """
    a, g, term, total = np.ones_like(k), k, np.full_like(k, 0.5), np.zeros_like(k)
    for _ in range(MEANS):
        term = 0.5 * term * (a - g) / (a + g)
        total = total + term
        a, g = 0.5 * (a + g), np.sqrt(a * g)
    K = 0.5 * np.pi / a
    return K, 3.0 * K * (0.5 + total), 3.0 * K * (0.5 - total) / (k * k)


def hertz_constants(curvature_1: Array, curvature_2: Array, modulus: float | Array) -> HertzConstants:
    """Hertz constants for relative principal curvatures [1/m] (sum over both bodies, positive) and E* [Pa].

    With a >= b, A <= B the halved relative curvatures: p0 a b R_D(0, a^2, b^2) / (3 E*) = B and the same for A with
    a, b exchanged; approach = p0 a b R_F(0, a^2, b^2) / E* (Johnson 1985, 4.2; mends Lin B.1, B.8, B.11).
    Raises ValueError where a curvature is not positive: the surfaces conform and Hertz does not apply.

    >>> c = hertz_constants(1 / 2.778e-3, 1 / 2.778e-3, contact_modulus(210e9, 0.28, 210e9, 0.28))
    >>> round(float(c.C) * 225 ** (2 / 3) * 1e6, 5)
    9.24316
    """
    k1, k2 = np.broadcast_arrays(np.asarray(curvature_1, float), np.asarray(curvature_2, float))
    low, high = np.minimum(k1, k2), np.maximum(k1, k2)
    if np.any(low <= 0.0) or not np.all(np.isfinite(high)):
        raise ValueError("relative curvatures must be positive and finite: ball and groove conform")
    k = axis_ratio(low / high)
    # with lengths in units of a: (3F / (2 pi a^2)) R_D(0, 1, k^2) / (3 E* a) = high / 2
    K, _, across = complete_integrals(k)
    c_a = np.cbrt(across / (np.pi * modulus * high))
    c = 1.5 * K / (np.pi * modulus * c_a)
    return HertzConstants(C=c, C_a=c_a, C_b=k * c_a, eccentricity=np.sqrt((1.0 - k) * (1.0 + k)))


@dataclass(frozen=True)
class PrintedHertz:
    """One side of Lin's Table B.1 as printed; lengths [m], constants in SI. Faults kept on purpose."""

    rho_1: float
    rho_2: float
    R_1: float
    R_2: float
    rho_eq: float
    e: float
    F_1: float
    C: float
    C_a: float
    C_b: float


def printed_hertz(ball_radius: float, radii: tuple[float, float], modulus: float) -> PrintedHertz:
    """Lin B.1-B.11 with the faults of Table B.1: radii from II only, F_1 = 1, the ratio of B.8 inverted.

    radii: the two eigenvalues of II [m] in the order of the table's rows (1, 2). Only for showing what the faults do.
    """
    relative = [1.0 / (1.0 / ball_radius + 1.0 / r) for r in radii]
    r_1, r_2 = min(relative), max(relative)  # the table's labels: 1 the smaller
    rho_eq = float(np.sqrt(r_1 * r_2))
    k = float(axis_ratio(np.array(r_1 / r_2)))
    c = float(np.cbrt(9.0 / (16.0 * modulus**2 * rho_eq)))
    c_ab = float(np.cbrt(0.75 * rho_eq / modulus))
    return PrintedHertz(
        rho_1=radii[0],
        rho_2=radii[1],
        R_1=r_1,
        R_2=r_2,
        rho_eq=rho_eq,
        e=float(np.sqrt(1.0 - k * k)),
        F_1=1.0,
        C=c,
        C_a=c_ab / np.sqrt(k),
        C_b=c_ab * np.sqrt(k),
    )
