"""Elliptical Hertz contact; its elliptic integrals are computed by the arithmetic-geometric mean.

The integrals are Carlson's R_F and R_D. They keep their accuracy from the circular contact to the line contact, where
formulas with the complete integrals K and E lose all digits by cancellation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.meshes.arrays import Array

#: Number of steps of the arithmetic-geometric mean; each step doubles the number of correct digits.
MEANS = 9


@dataclass(frozen=True)
class HertzConstants:
    """Constants of an elliptical Hertz contact, which give approach and semi-axes as powers of the normal force F.

    Each array has the shape of the relative curvatures from which `hertz_constants` computed it. The pressure is
    semi-ellipsoidal over the contact ellipse; its largest value, at the centre, is 3 F/(2 pi a b).
    """

    #: Constant C of the approach delta = C F^(2/3) [m/N^(2/3)].
    C: Array
    #: Constant of the major semi-axis, a = C_a F^(1/3) [m/N^(1/3)], a >= b.
    C_a: Array
    #: Constant of the minor semi-axis, b = C_b F^(1/3) [m/N^(1/3)].
    C_b: Array
    #: Eccentricity of the contact ellipse, sqrt(1 - b^2/a^2).
    eccentricity: Array

    def pressure(self, force: Array) -> Array:
        """Return the largest contact pressure, at the centre of the ellipse, 3 F/(2 pi a b) [Pa] (Johnson 1985, 4.30).

        `lowfi.rating.contacts` calls it for all balls of a solved scene.

        Parameters
        ----------
        force
            Normal force F [N], of the shape of the constants.
        """
        return np.asarray(1.5 * np.cbrt(force) / (np.pi * self.C_a * self.C_b))


def contact_force(approach: Array | float, C: Array | float) -> Array:
    """Return the normal force F = (approach/C)^(3/2) [N]; zero where the surfaces do not touch.

    Parameters
    ----------
    approach
        Approach of the bodies' distant points [m], negative for a gap.
    C
        Constant of the contact [m/N^(2/3)], see `HertzConstants`. Shapes broadcast. For two contacts in series, which carry
        the same force, pass the sum of both constants.

    Examples
    --------
    >>> [round(float(x), 12) for x in (contact_force(4e-6, 1e-6), 1e6 * contact_approach(8.0, 1e-6))]
    [8.0, 4.0]
    >>> float(contact_stiffness_at_approach(4e-6, 1e-6)), float(contact_stiffness_under_force(8.0, 1e-6))
    (3000000.0, 3000000.0)
    """
    return np.asarray((np.maximum(approach, 0.0) / C) ** 1.5)


def contact_approach(force: Array | float, C: Array | float) -> Array:
    """Return the approach C F^(2/3) [m] of two bodies in contact under a normal force; inverse of `contact_force`.

    Parameters
    ----------
    force
        Normal force F [N], not negative.
    C
        Constant of the contact [m/N^(2/3)]; shapes broadcast.
    """
    return np.asarray(C * force ** (2.0 / 3.0))


def contact_stiffness_at_approach(approach: Array | float, C: Array | float) -> Array:
    """Return the contact stiffness dF/d(approach) = 3 (approach/C)^(1/2)/(2 C) [N/m] at an approach; zero for a gap.

    Parameters
    ----------
    approach
        Approach of the bodies' distant points [m], negative for a gap.
    C
        Constant of the contact [m/N^(2/3)]; shapes broadcast.
    """
    return np.asarray(1.5 * np.sqrt(np.maximum(approach, 0.0) / C) / C)


def contact_stiffness_under_force(force: Array | float, C: Array | float) -> Array:
    """Return the contact stiffness dF/d(approach) = 3 F^(1/3)/(2 C) [N/m] at a normal force.

    Parameters
    ----------
    force
        Normal force F [N].
    C
        Constant of the contact [m/N^(2/3)]; shapes broadcast.
    """
    return np.asarray(1.5 * np.cbrt(force) / C)


def contact_modulus(e1: float, nu1: float, e2: float, nu2: float) -> float:
    """Return the contact modulus E* of two elastic bodies, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.

    Parameters
    ----------
    e1
        Young's modulus of the first body [Pa].
    nu1
        Poisson's ratio of the first body.
    e2
        Young's modulus of the second body [Pa].
    nu2
        Poisson's ratio of the second body.

    Returns
    -------
    float
        E* [Pa]. Some authors call twice this value the equivalent modulus.

    References
    ----------
    Lin (2019), B.6; Johnson (1985), 4.23.

    Examples
    --------
    >>> round(contact_modulus(210e9, 0.3, 210e9, 0.3) / 1e9, 3)
    115.385
    """
    return 1.0 / ((1.0 - nu1**2) / e1 + (1.0 - nu2**2) / e2)


def ellipse_semi_axis_ratio(curvature_ratio: Array) -> Array:
    """Return the ratio b/a of a contact ellipse's semi-axes from the ratio A/B of the relative curvatures.

    Solves A/B = R_D(0, k^2, 1)/R_D(0, 1, k^2) for k = b/a by Newton's method in log k, to round-off. R_D is Carlson's
    elliptic integral of the second kind.

    Parameters
    ----------
    curvature_ratio
        A/B <= 1: relative curvature along the major semi-axis a over that along the minor semi-axis b; any shape.

    Returns
    -------
    Array
        b/a, of the same shape, at most 1.

    Raises
    ------
    ValueError
        The curvature ratio is outside (0, 1]. The result is accurate for ratios above 1e-12.

    References
    ----------
    Johnson (1985), 4.28; Lin (2019), B.8, whose printed ratio is upside down.

    Examples
    --------
    >>> ellipse_semi_axis_ratio(np.array([1.0, 0.1])).round(6).tolist()
    [1.0, 0.22225]
    """
    ratio = np.asarray(curvature_ratio, dtype=float)
    if np.any(ratio <= 0.0) or np.any(ratio > 1.0 + 1e-12):
        worst = float(np.min(ratio)) if np.any(ratio <= 0.0) else float(np.max(ratio))
        raise ValueError(f"ratio of relative curvatures is {worst:.3g}: it must lie in (0, 1]")
    few, place = np.unique(ratio, return_inverse=True)  # most contacts of a scene are alike
    target = np.log(np.minimum(few, 1.0))
    x = 0.636 * target
    for _ in range(60):
        f = _log_curvature_ratio(x) - target
        h = 1e-6
        slope = (_log_curvature_ratio(x + h) - _log_curvature_ratio(x - h)) / (2.0 * h)
        step = f / slope
        x = np.minimum(x - step, 0.0)
        if np.all(np.abs(step) <= 4e-16 * np.maximum(1.0, np.abs(x)) * 4.0):
            break
    return np.asarray(np.exp(x)[place].reshape(ratio.shape))


def _log_curvature_ratio(x: Array) -> Array:
    """Return log(A/B) for x = log(b/a): A/B is the ratio of relative curvatures, b/a that of the ellipse's semi-axes."""
    _, along, across = complete_elliptic_integrals(np.exp(x))
    return np.asarray(np.log(along / across))


def complete_elliptic_integrals(k: Array) -> tuple[Array, Array, Array]:
    """Return Carlson's elliptic integrals R_F(0, 1, k^2), R_D(0, k^2, 1) and R_D(0, 1, k^2), to a few round-offs.

    R_F is pi/2 over the arithmetic-geometric mean of 1 and k. With a sum s over the iterations of this mean,
    R_D(0, k^2, 1) = 3 R_F (1/2 + s) and R_D(0, 1, k^2) = 3 R_F (1/2 - s)/k^2. scipy.special offers the integrals too, but
    importing it takes longer than solving a scene.

    Parameters
    ----------
    k
        Ratio b/a of semi-axes, 1e-6 <= k <= 1, any shape.

    References
    ----------
    NIST Digital Library of Mathematical Functions (DLMF), 19.8.5 and 19.8.7.

    Examples
    --------
    >>> [round(float(x), 12) for x in complete_elliptic_integrals(np.array(1.0))]
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
    """Return the constants of elliptical Hertz contact for given relative principal curvatures.

    With the largest pressure p0, the semi-axes a >= b and the halved relative curvatures A <= B,
    p0 a b R_D(0, a^2, b^2)/(3 E*) = B, the same for A with a and b exchanged, and approach = p0 a b R_F(0, a^2, b^2)/E*.
    R_D and R_F are Carlson's elliptic integrals. Valid for semi-axes small against the radii of curvature, without friction
    and plastic deformation.

    Parameters
    ----------
    curvature_1, curvature_2
        Relative principal curvatures [1/m], each the sum over both bodies, positive for convex ones; in either order,
        shapes broadcast.
    modulus
        Contact modulus E* [Pa] (`contact_modulus`).

    Raises
    ------
    ValueError
        A relative curvature is not positive: the surfaces conform and Hertz's theory does not apply.

    References
    ----------
    Johnson, *Contact Mechanics* (1985), 4.2. Lin (2019), B.1, B.8 and B.11 with their misprints corrected.

    Examples
    --------
    A ball of 5.556 mm on a flat under 225 N, for which the closed form is (9 F^2/(16 E*^2 R))^(1/3):

    >>> E = contact_modulus(210e9, 0.28, 210e9, 0.28)
    >>> R, F = 2.778e-3, 225.0
    >>> c = hertz_constants(1 / R, 1 / R, E)
    >>> round(float(c.C) * F ** (2 / 3) * 1e6, 5), round((9 * F**2 / (16 * E**2 * R)) ** (1 / 3) * 1e6, 5)
    (9.24316, 9.24316)
    >>> round(float(c.pressure(np.array(F))) / 1e9, 4), round((6 * F * E**2 / (np.pi**3 * R**2)) ** (1 / 3) / 1e9, 4)
    (4.1838, 4.1838)
    """
    k1, k2 = np.broadcast_arrays(np.asarray(curvature_1, float), np.asarray(curvature_2, float))
    low, high = np.minimum(k1, k2), np.maximum(k1, k2)
    if np.any(low <= 0.0) or not np.all(np.isfinite(high)):
        raise ValueError(
            "Hertz's theory does not apply where the surfaces of ball and groove conform: relative curvatures must be "
            "positive and finite"
        )
    k = ellipse_semi_axis_ratio(low / high)
    # with lengths in units of a: (3F / (2 pi a^2)) R_D(0, 1, k^2) / (3 E* a) = high / 2
    K, _, across = complete_elliptic_integrals(k)
    c_a = np.cbrt(across / (np.pi * modulus * high))
    c = 1.5 * K / (np.pi * modulus * c_a)
    return HertzConstants(C=c, C_a=c_a, C_b=k * c_a, eccentricity=np.sqrt((1.0 - k) * (1.0 + k)))


@dataclass(frozen=True)
class PrintedHertzConstants:
    """Hertz constants of a ball on one raceway as Table B.1 of Lin's thesis prints them, misprints included."""

    #: First eigenvalue of the raceway's second fundamental form, which Lin takes for a radius of curvature [m].
    rho_1: float
    #: Second eigenvalue of the raceway's second fundamental form, which Lin takes for a radius of curvature [m].
    rho_2: float
    #: Smaller relative radius of curvature [m].
    R_1: float
    #: Larger relative radius of curvature [m].
    R_2: float
    #: Equivalent relative radius of curvature sqrt(R_1 R_2) [m].
    rho_eq: float
    #: Eccentricity of the contact ellipse, sqrt(1 - b^2/a^2).
    e: float
    #: Correction factor of the approach in eq. B.11 of Lin's thesis; the table uses 1.
    F_1: float
    #: Constant C of the approach C F^(2/3) [m/N^(2/3)].
    C: float
    #: Constant C_a of the major semi-axis C_a F^(1/3) [m/N^(1/3)].
    C_a: float
    #: Constant C_b of the minor semi-axis C_b F^(1/3) [m/N^(1/3)].
    C_b: float


def hertz_constants_as_printed(
    ball_radius: float, form_eigenvalues: tuple[float, float], modulus: float
) -> PrintedHertzConstants:
    """Compute Hertz constants by eqs. B.1 to B.11 of Lin's thesis with the misprints of Table B.1, to show their effect.

    The misprints are: radii of curvature from the second fundamental form only, a correction factor F_1 = 1 of the approach
    (B.11), and the inverted ratio of B.8.

    Parameters
    ----------
    ball_radius
        Radius of the ball [m].
    form_eigenvalues
        The two eigenvalues of the raceway's second fundamental form [m], in the order of the table's rows.
    modulus
        Contact modulus E* [Pa].

    References
    ----------
    Lin (2019), appendix B and Table B.1.
    """
    relative = [1.0 / (1.0 / ball_radius + 1.0 / r) for r in form_eigenvalues]
    r_1, r_2 = min(relative), max(relative)  # the table's labels: 1 the smaller
    rho_eq = float(np.sqrt(r_1 * r_2))
    k = float(ellipse_semi_axis_ratio(np.array(r_1 / r_2)))
    c = float(np.cbrt(9.0 / (16.0 * modulus**2 * rho_eq)))
    c_ab = float(np.cbrt(0.75 * rho_eq / modulus))
    return PrintedHertzConstants(
        rho_1=form_eigenvalues[0],
        rho_2=form_eigenvalues[1],
        R_1=r_1,
        R_2=r_2,
        rho_eq=rho_eq,
        e=float(np.sqrt(1.0 - k * k)),
        F_1=1.0,
        C=c,
        C_a=c_ab / np.sqrt(k),
        C_b=c_ab * np.sqrt(k),
    )
