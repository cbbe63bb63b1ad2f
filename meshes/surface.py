"""Exact groove surfaces S(phi, gamma) with manufacturing errors, and their curvatures.

phi is the azimuth, gamma the section angle, measured from the radial direction. After Lin (2019), eqs. (2.3), (2.6), (2.27)
and (B.3) to (B.5).
"""

from __future__ import annotations

from math import cos, sin

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import GeometryWithErrors
from rollbench.meshes.helix import lead_angle, lead_per_radian
from rollbench.meshes.parts import SIDE_SIGNS, Scene

#: Unit factors (s_x, s_z) of the contact directions of the flanks ``(4, 2)``, see `meshes.parts.SIDE_SIGNS`.
SIGNS = np.array(SIDE_SIGNS)
#: Value of the argument ``side`` for all four flanks at once, in a second axis of the arrays.
ALL = slice(None)

#: Section angle [rad] of the middle of a flank, and distance from it up to which a profile error is its polynomial.
FLANK_MIDDLE, POLYNOMIAL = 0.25 * np.pi, 0.5 * np.pi


def groove_radius_with_slopes(gamma: Array, radius: float | Array, profile: Array) -> Array:
    """Compute the groove radius with profile error at given section angles, and its first two derivatives.

    Parameters
    ----------
    gamma : Array of any shape
        Section angles, around the centre of the groove's arc from the radial direction [rad].
    radius : float or Array
        Groove radius without profile error [m].
    profile : (d,) Array
        Coefficients of the inward offset by ascending powers of gamma in rad [m].

    Returns
    -------
    (3, ...) Array
        rho = radius - offset(gamma), d rho / d gamma and d2 rho / d gamma2 [m]. Far from the flank the offset is continued,
        see `angle_of_profile`.

    References
    ----------
    Lin (2019), eq. (2.27).

    Examples
    --------
    >>> groove_radius_with_slopes(np.array([0.5]), 3e-3, np.array([1e-6, 2e-6])).ravel().round(9).tolist()
    [0.002998, -2e-06, 0.0]
    """
    if not profile.size:
        flat = 0.0 * gamma
        return np.stack([radius + flat, flat, flat])
    at, turn, bend = angle_of_profile(gamma)
    poly = np.polynomial.Polynomial(profile)
    slope = -poly.deriv()(at)
    return np.stack([radius - poly(at), slope * turn, -poly.deriv(2)(at) * turn**2 + slope * bend + 0.0])


def angle_of_profile(gamma: Array) -> tuple[Array, Array, Array]:
    """Return the angle at which the polynomial of a profile error is taken, and its two derivatives by the angle gamma.

    It is the section angle gamma [rad] itself up to a right angle from the flank's middle. Further away, where there is no
    groove, it returns to the middle's angle at the opposite side, with two continuous derivatives: otherwise the profile
    would have a step there, on which no ball is in equilibrium.
    """
    t = gamma - FLANK_MIDDLE
    far = np.abs(t) > POLYNOMIAL
    if not np.any(far):
        return gamma, np.ones_like(gamma), np.zeros_like(gamma)
    t = (t + np.pi) % (2.0 * np.pi) - np.pi
    s, side = np.maximum(np.abs(t) / POLYNOMIAL - 1.0, 0.0), np.sign(t)
    back = side * POLYNOMIAL * (1.0 + s * (1.0 + s * s * (2.0 * s - 4.0)))
    at = FLANK_MIDDLE + np.where(s > 0.0, back, t)
    turn, bend = 1.0 + s * s * (8.0 * s - 12.0), side * s * (24.0 * s - 24.0) / POLYNOMIAL
    return np.where(far, at, gamma), np.where(far, turn, 1.0), np.where(far, bend, 0.0)


def surface_derivatives(scene: Scene, geometry: GeometryWithErrors, side: int | slice, gamma: Array) -> dict[str, Array]:
    """Compute points of the groove surface at each ball, and its derivatives with respect to azimuth and section angle.

    Parameters
    ----------
    scene : Scene
        Scene with the nominal geometry.
    geometry : GeometryWithErrors
        Geometry of the grooves at the balls, with errors.
    side : int | slice
        Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut; or `ALL` for all four flanks, which are then the
        second axis of the results.
    gamma : (n,) or (n, 4) Array
        Section angle at each ball, around the centre of the groove's arc from the radial direction [rad]; ``(n, 4)`` for
        all flanks.

    Returns
    -------
    dict of (n, 3) or (n, 4, 3) Arrays
        Points ``S`` [m], first derivatives ``Sp``, ``Sg`` [m/rad] and second ones ``Spp``, ``Spg``, ``Sgg`` [m/rad2], with
        p for azimuth and g for gamma. Components are radial, azimuthal and axial at the azimuth of the ball.

    References
    ----------
    Lin (2019), eq. (2.6), differentiated analytically.
    """
    sx, sz = SIGNS[side].T
    if isinstance(side, int):
        rho, rho1, rho2 = groove_radius_with_slopes(gamma, geometry.groove_radii[side], geometry.profile_coefficients[side])
    else:
        flanks = zip(gamma.T, geometry.groove_radii, geometry.profile_coefficients, strict=True)
        rho, rho1, rho2 = np.stack([groove_radius_with_slopes(*x) for x in flanks], axis=-1)
    c, s = np.cos(gamma), np.sin(gamma)
    zero = np.zeros_like(c)
    a = np.stack([sx * rho * c, sz * rho * s], -1) + geometry.groove_centres[:, side]
    a_g = np.stack([sx * (rho1 * c - rho * s), sz * (rho1 * s + rho * c)], -1)
    a_gg = np.stack([sx * ((rho2 - rho) * c - 2.0 * rho1 * s), sz * ((rho2 - rho) * s + 2.0 * rho1 * c)], -1)
    a_p, a_pp = geometry.groove_centre_derivatives[0][:, side], geometry.groove_centre_derivatives[1][:, side]

    alpha = lead_angle(scene.track)

    def cylindrical_components(plane: Array) -> Array:
        """Convert components x3 (radial) and z3 (across the track) of vectors to radial, azimuthal and axial components."""
        return np.stack([plane[..., 0], -plane[..., 1] * sin(alpha), plane[..., 1] * cos(alpha)], -1)

    def differentiate_by_azimuth(x: Array, dx: Array) -> Array:
        """Differentiate vectors ``x`` by azimuth; ``dx``: derivatives of their radial, azimuthal and axial components."""
        return np.stack([dx[..., 0] - x[..., 1], dx[..., 1] + x[..., 0], dx[..., 2]], -1)

    rise = np.stack([zero, zero, zero + lead_per_radian(scene.track)], -1)
    x = cylindrical_components(a) + np.array([scene.track.pitch_radius, 0.0, 0.0])
    x_p = cylindrical_components(a_p) + rise
    sp = differentiate_by_azimuth(x, x_p)
    spp = differentiate_by_azimuth(sp, differentiate_by_azimuth(x_p, cylindrical_components(a_pp)))
    return {
        "S": x,
        "Sp": sp,
        "Sg": cylindrical_components(a_g),
        "Spp": spp,
        "Spg": differentiate_by_azimuth(cylindrical_components(a_g), np.zeros_like(x)),
        "Sgg": cylindrical_components(a_gg),
    }


def fundamental_forms(derivatives: dict[str, Array]) -> tuple[Array, Array, Array]:
    """Compute the first and second fundamental forms of a groove surface, and its unit normal, from its derivatives.

    Parameters
    ----------
    derivatives : dict[str, Array]
        Derivatives of the surface, from `surface_derivatives`.

    Returns
    -------
    first : (..., 2, 2) Array
        First fundamental form I (metric) [m2]; the parameters are azimuth and gamma, in this order.
    second : (..., 2, 2) Array
        Second fundamental form II [m], for the normal S_phi x S_gamma (derivatives of the surface point S).
    normal : (..., 3) Array
        Unit normal S_phi x S_gamma / |S_phi x S_gamma|.

    References
    ----------
    Lin (2019), eqs. (B.4) and (B.5).
    """
    normal = np.cross(derivatives["Sp"], derivatives["Sg"])
    normal = normal / np.linalg.norm(normal, axis=-1, keepdims=True)

    def dot_products(u: Array, v: Array) -> Array:
        return np.asarray(np.einsum("...i,...i->...", u, v))

    Sp, Sg, Spp, Spg, Sgg = (derivatives[name] for name in ("Sp", "Sg", "Spp", "Spg", "Sgg"))
    E, F, G = (dot_products(u, v) for u, v in ((Sp, Sp), (Sp, Sg), (Sg, Sg)))
    L, M, N = (dot_products(u, normal) for u in (Spp, Spg, Sgg))
    first, second = (np.stack([a, b, b, c], -1).reshape((*a.shape, 2, 2)) for a, b, c in ((E, F, G), (L, M, N)))
    return first, second, normal


def principal_curvatures(scene: Scene, geometry: GeometryWithErrors, side: int | slice, gamma: Array) -> Array:
    """Compute the principal curvatures of the groove surface at each ball; convex surfaces have positive curvature.

    They are the eigenvalues of I^-1 II, with the first and second fundamental forms I and II of the surface, for the normal
    out of the material. Lin (B.4) uses the eigenvalues of II.

    Parameters
    ----------
    scene, geometry, side, gamma
        Nominal geometry, geometry with errors, flank and section angles, as for `surface_derivatives`.

    Returns
    -------
    (n, 2) or (n, 4, 2) Array
        Curvatures [1/m], ascending: across the groove, about -1/r_G with the groove radius r_G; then along the track.

    References
    ----------
    Lin (2019), eqs. (B.4) and (B.5), with I^-1 added.

    Examples
    --------
    >>> import rollbench
    >>> from rollbench.meshes.errors import draw_geometry_with_errors
    >>> from rollbench.meshes.helix import ball_layout
    >>> scene = rollbench.read("lin-case1")
    >>> drawn = draw_geometry_with_errors(scene, ball_layout(scene))
    >>> principal_curvatures(scene, drawn, 0, np.full(32, scene.track.contact_angle))[0].round(2).tolist()
    [-307.32, 46.75]
    """
    d = surface_derivatives(scene, geometry, side, gamma)
    first, second, normal = fundamental_forms(d)
    sx, sz = SIGNS[side].T
    alpha = lead_angle(scene.track)
    to_ball = -np.stack([sx * np.cos(gamma), -sz * np.sin(gamma) * sin(alpha), sz * np.sin(gamma) * cos(alpha)], axis=-1)
    outward = np.sign(np.einsum("...i,...i->...", normal, to_ball))
    shape = np.linalg.solve(first, second)
    return np.sort(-outward[..., None] * np.linalg.eigvals(shape).real, axis=-1)


def printed_principal_radii(scene: Scene, geometry: GeometryWithErrors, side: int, gamma: Array) -> Array:
    """Compute the "principal radii" printed in Table B.1 of Lin's thesis: eigenvalues of the second fundamental form II.

    These are not radii of curvature, because the first fundamental form I is not considered. They have the dimension of a
    length only because the parameters are angles. Use them only for comparison with the printed table; for the true
    curvatures see `principal_curvatures`.

    Parameters
    ----------
    scene, geometry, side, gamma
        Nominal geometry, geometry with errors, flank and section angles, as for `surface_derivatives` with one flank.

    Returns
    -------
    (n, 2) Array
        Eigenvalues of II [m], ascending, for the direction of the normal in Lin's eq. (B.5).

    References
    ----------
    Lin (2019), eqs. (B.4) and (B.5), Table B.1.
    """
    _, second, _ = fundamental_forms(surface_derivatives(scene, geometry, side, gamma))
    return np.asarray(np.linalg.eigvalsh(second))
