"""Exact groove surfaces S(phi, gamma) with their errors, and their curvatures (Lin 2.3, 2.6, 2.27, B.3-B.5)."""

from __future__ import annotations

from math import cos, sin

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimen
from rollbench.meshes.helix import lead_angle, reduced_lead
from rollbench.meshes.parts import SIDE_SIGNS, Scene

SIGNS = np.array(SIDE_SIGNS)
#: In place of a side: all four, in a second axis.
ALL = slice(None)


def groove_profile(gamma: Array, radius: float | Array, profile: Array) -> Array:
    """Groove radius rho(gamma) = r - offset(gamma) and its first two derivatives, shape ``(3, ...)`` [m].

    ``profile``: polynomial coefficients of the inward offset [m], ascending powers of gamma [rad] (Lin 2.27).
    """
    if not profile.size:
        flat = 0.0 * gamma
        return np.stack([radius + flat, flat, flat])
    poly = np.polynomial.Polynomial(profile)
    return np.stack([radius - poly(gamma), -poly.deriv()(gamma), -poly.deriv(2)(gamma) + 0.0 * gamma])


def surface_derivatives(scene: Scene, drawn: Specimen, side: int | slice, gamma: Array) -> dict[str, Array]:
    """Groove surface of a side at each ball's section and the angle ``gamma`` of each ball, with its derivatives.

    gamma: shape ``(n,)`` [rad], or ``(n, 4)`` for all sides at once (``ALL``). Returns ``S, Sp, Sg, Spp, Spg, Sgg``
    (subscripts p: azimuth, g: gamma), each ``(..., 3)`` [m] in the cylindrical frame (radial, azimuthal, axial) of the
    ball's azimuth (Lin 2.6; analytic).
    """
    sx, sz = SIGNS[side].T
    if isinstance(side, int):
        rho, rho1, rho2 = groove_profile(gamma, drawn.radius[side], drawn.profile[side])
    else:
        flanks = zip(gamma.T, drawn.radius, drawn.profile, strict=True)
        rho, rho1, rho2 = np.stack([groove_profile(*x) for x in flanks], axis=-1)
    c, s = np.cos(gamma), np.sin(gamma)
    zero = np.zeros_like(c)
    a = np.stack([sx * rho * c, sz * rho * s], -1) + drawn.centre[:, side]
    a_g = np.stack([sx * (rho1 * c - rho * s), sz * (rho1 * s + rho * c)], -1)
    a_gg = np.stack([sx * ((rho2 - rho) * c - 2.0 * rho1 * s), sz * ((rho2 - rho) * s + 2.0 * rho1 * c)], -1)
    a_p, a_pp = drawn.centre_slopes[0][:, side], drawn.centre_slopes[1][:, side]

    alpha = lead_angle(scene.track)

    def local(plane: Array) -> Array:
        """From (x3, z3) to (radial, azimuthal, axial)."""
        return np.stack([plane[..., 0], -plane[..., 1] * sin(alpha), plane[..., 1] * cos(alpha)], -1)

    def turn(x: Array, dx: Array) -> Array:
        """Derivative by azimuth of a vector given in the turning frame."""
        return np.stack([dx[..., 0] - x[..., 1], dx[..., 1] + x[..., 0], dx[..., 2]], -1)

    rise = np.stack([zero, zero, zero + reduced_lead(scene.track)], -1)
    x = local(a) + np.array([scene.track.pitch_radius, 0.0, 0.0])
    x_p = local(a_p) + rise
    sp = turn(x, x_p)
    spp = turn(sp, turn(x_p, local(a_pp)))
    return {"S": x, "Sp": sp, "Sg": local(a_g), "Spp": spp, "Spg": turn(local(a_g), np.zeros_like(x)), "Sgg": local(a_gg)}


def fundamental_forms(d: dict[str, Array]) -> tuple[Array, Array, Array]:
    """First and second fundamental forms ``(..., 2, 2)`` and the unit normal S_phi x S_gamma ``(..., 3)`` (Lin B.5)."""
    normal = np.cross(d["Sp"], d["Sg"])
    normal = normal / np.linalg.norm(normal, axis=-1, keepdims=True)

    def pair(u: Array, v: Array) -> Array:
        return np.asarray(np.einsum("...i,...i->...", u, v))

    cross = pair(d["Sp"], d["Sg"])
    shape = (*cross.shape, 2, 2)
    first = np.stack([pair(d["Sp"], d["Sp"]), cross, cross, pair(d["Sg"], d["Sg"])], -1).reshape(shape)
    mixed = pair(d["Spg"], normal)
    second = np.stack([pair(d["Spp"], normal), mixed, mixed, pair(d["Sgg"], normal)], -1).reshape(shape)
    return first, second, normal


def principal_curvatures(scene: Scene, drawn: Specimen, side: int | slice, gamma: Array) -> Array:
    """Principal curvatures of the groove body at each ball, shape ``(..., 2)`` [1/m], ascending, convex positive; side and
    gamma: as for `surface_derivatives`.

    Eigenvalues of I^-1 II with the normal turned out of the material; Lin B.4 takes those of II only.
    """
    d = surface_derivatives(scene, drawn, side, gamma)
    first, second, normal = fundamental_forms(d)
    sx, sz = SIGNS[side].T
    alpha = lead_angle(scene.track)
    to_ball = -np.stack([sx * np.cos(gamma), -sz * np.sin(gamma) * sin(alpha), sz * np.sin(gamma) * cos(alpha)], axis=-1)
    outward = np.sign(np.einsum("...i,...i->...", normal, to_ball))
    shape = np.linalg.solve(first, second)
    return np.sort(-outward[..., None] * np.linalg.eigvals(shape).real, axis=-1)


def printed_radii(scene: Scene, drawn: Specimen, side: int, gamma: Array) -> Array:
    """Table B.1's "principal radii": eigenvalues of II only, with the normal of B.5, ``(n, 2)`` [m], ascending.

    As printed only. They have the dimension of a length because the parameters are angles; I^-1 is missing.
    """
    _, second, _ = fundamental_forms(surface_derivatives(scene, drawn, side, gamma))
    return np.asarray(np.linalg.eigvalsh(second))
