"""Force laws of contacts, and the approach of a ball to a groove flank with its derivatives, elementwise over arrays."""

from __future__ import annotations

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDE_SIGNS
from rollbench.meshes.surface import angle_of_profile

#: Signs of radial and axial component of the direction from ball to groove, for each flank SL, SR, NL, NR ``(4, 2)``.
SIGNS = np.array(SIDE_SIGNS)
#: Relative size of a Newton step for one unknown after which the iteration ends: as each step squares the error, the result
#: is then exact to round-off.
SETTLED = 1e-9
#: Largest number of such steps.
STEPS = 60


def contact_law(approach: Array, C: Array, e: Array, h: Array) -> tuple[Array, Array, Array]:
    """Return force F [N], stiffness dF/d approach [N/m] and energy [J] of contacts; zeros for an open contact.

    The law approach = C F^(2/3) + e F + h F^(4/3) adds two terms of the elastic bodies to Hertz's (equation 2.14 of Lin's
    thesis). With negative e or h the approach would decrease with the force beyond the root x = F^(1/3) of 2 C + 3 e x +
    4 h x^2 = 0. The law is therefore continued as C F^(2/3)/2 plus a constant from the point where this expression equals
    C. Force and stiffness are continuous there, and the energy remains convex.

    Parameters
    ----------
    approach
        Approach of each contact [m], of any shape; a contact is open where it is not positive.
    C, e, h
        Coefficients [m/N^(2/3)], [m/N], [m/N^(4/3)] of the same shape.
    """
    force, stiffness, energy = np.zeros((3, *approach.shape))
    on = approach > 0.0
    d, c, e, h = approach[on], C[on], e[on], h[on]
    x = np.sqrt(d / c)  # F^(1/3) of Hertz's law
    if not (e.any() or h.any()):
        force[on], stiffness[on], energy[on] = x**3, 1.5 * x / c, 0.4 * c * x**5
        return force, stiffness, energy
    limit = _root_at_continuation(c, e, h)
    edge = np.where(np.isinf(limit), np.inf, 0.0)
    ends = np.isfinite(limit)
    at = limit[ends]
    edge[ends] = at * at * (c[ends] + at * (e[ends] + at * h[ends]))
    beyond = d > edge
    x, low, high, left = np.minimum(x, limit), np.zeros_like(d), limit.copy(), ~beyond
    for _ in range(STEPS):  # Newton on C x^2 + e x^3 + h x^4 = approach, bracketed
        if not left.any():
            break
        rest = x * x * (c + x * (e + x * h)) - d
        high, low = np.where(rest > 0.0, x, high), np.where(rest > 0.0, low, x)
        new = x - rest / (x * (2.0 * c + x * (3.0 * e + 4.0 * h * x)))
        end = np.abs(new - x) <= SETTLED * x
        halved = 0.5 * (low + np.where(np.isinf(high), 2.0 * x, high))
        x = np.where(left, np.where(end | ((low < new) & (new < high)), new, halved), x)
        left &= ~end
    f, k, w = x**3, 3.0 * x / (2.0 * c + x * (3.0 * e + 4.0 * h * x)), x**5 * (0.4 * c + x * (0.5 * e + 4.0 / 7.0 * h * x))
    if beyond.any():
        c, e, h, at = c[beyond], e[beyond], h[beyond], limit[beyond]
        x = np.sqrt(at * at + 2.0 * (d - edge)[beyond] / c)
        f[beyond], k[beyond] = x**3, 3.0 * x / c
        w[beyond] = at**5 * (0.4 * c + at * (0.5 * e + 4.0 / 7.0 * h * at)) + 0.2 * c * (x**5 - at**5)
    force[on], stiffness[on], energy[on] = f, k, w
    return force, stiffness, energy


def _root_at_continuation(c: Array, e: Array, h: Array) -> Array:
    """Return F^(1/3) from which `contact_law` is continued: the smallest x > 0 with 3 e x + 4 h x^2 = -c; inf if none."""
    root = 9.0 * e * e - 16.0 * h * c
    with np.errstate(all="ignore"):  # the formula depends on the sign of e, to avoid subtracting nearly equal numbers
        x = np.where(e > 0.0, -(3.0 * e + np.sqrt(root)) / (8.0 * h), 2.0 * c / (np.sqrt(root) - 3.0 * e))
    return np.where((root < 0.0) | ((e >= 0.0) & (h >= 0.0)), np.inf, x)


def line_contact_law(approach: Array, g: Array, s: Array) -> tuple[Array, Array, Array]:
    """Return line load q [N/m], stiffness dq/d approach [N/m^2] and energy [J/m] of line contacts; zeros where open.

    The law is approach = q (g - s ln q), with constants g and s [m^2/N] of roller and raceways. The approach has a maximum
    as a function of q. Above exp(-3) times the load at this maximum, which is far above any real load, the law is continued
    along its tangent, so that the energy remains convex. The arguments have the same shape.
    """
    load, stiffness, energy = np.zeros((3, *approach.shape))
    on = approach > 0.0
    d, g, s = approach[on], g[on], s[on]
    edge = np.exp(g / s - 4.0)
    limit = edge * (g - s * np.log(edge))
    beyond, d = np.maximum(d - limit, 0.0), np.minimum(d, limit)
    q, left = d / g, np.ones(d.shape, dtype=bool)
    for _ in range(STEPS):
        if not left.any():
            break
        new = q - (q * (g - s * np.log(q)) - d) / (g - s * (1.0 + np.log(q)))
        new = np.where(left, np.where(new <= 0.0, 0.5 * q, new), q)
        left &= np.abs(new - q) > SETTLED * new
        q = new
    slope = 1.0 / (g - s * (1.0 + np.log(q)))
    stored = 0.5 * q * q * (g - s * (0.5 + np.log(q)))
    load[on], stiffness[on], energy[on] = q + slope * beyond, slope, stored + beyond * (q + 0.5 * slope * beyond)
    return load, stiffness, energy


def approach_to_arcs(moved: Array, to_ball: Array, distance: Array, nominal: Array) -> tuple[Array, Array, Array]:
    """Return approaches [m], unit normals and curvature terms [1/m] of the contacts of balls with circular flanks.

    The approach is its nominal value plus its change, so that its round-off is that of the motion (1e-22 m), not that of
    the radii (1e-18 m). The curvature term times the contact force is the tangential stiffness of the contact; here it is
    the inverse distance of groove centre and ball centre.

    Parameters
    ----------
    moved
        Motion of the ball's centre relative to each flank ``(..., 4, 2)`` [m], radial and along the helix's binormal.
    to_ball, distance
        Nominal vector from the groove's centre to the ball's centre ``(..., 4, 2)``, and its length ``(..., 4)`` [m].
    nominal
        Nominal approach ``(..., 4)`` [m].

    Returns
    -------
    tuple[Array, Array, Array]
        Approaches ``(..., 4)``, normals from ball to groove ``(..., 4, 2)``, and curvature terms ``(..., 4)``.
    """
    w = to_ball + moved
    size = lengths(w)
    apart = np.maximum(size, 1e-30)
    change = (moved * (to_ball + w)).sum(axis=-1) / (apart + distance)
    return nominal + change, w / apart[..., None], np.where(size > 1e-30, 1.0 / apart, 0.0)


def approach_to_profiles(
    moved: Array, to_ball: Array, ball_radius: Array, groove_radius: Array, profile: Array
) -> tuple[Array, Array, Array]:
    """Return approaches [m], unit normals and curvature terms [1/m] of the contacts of balls with non-circular flanks.

    The flank is the curve rho(gamma) (s_x cos gamma, s_z sin gamma) around the groove's centre, with the signs s of the
    contact direction. rho is ``groove_radius`` minus a polynomial of the contact angle gamma (equations 2.3 and 2.27 of
    Lin's thesis); far from the flank it is continued, see `meshes.surface.angle_of_profile`. The approach is r - d, with
    the ball's radius r and the signed distance d of its centre from the flank. The curvature term is 1/(R_c - d) with the
    radius of curvature R_c of the flank, or zero if the centre lies beyond the
    centre of curvature; with the normal m and the tangent t, m and this term times t t^T are the derivatives of the
    approach by the ball's position.

    Parameters
    ----------
    moved, to_ball
        As for `approach_to_arcs`, ``(..., 4, 2)`` [m].
    ball_radius, groove_radius
        Radii ``(...)`` and ``(..., 4)`` [m].
    profile
        Coefficients ``(..., 4, p)`` [m] of the polynomial, in ascending powers of gamma.
    """
    u = SIGNS * (to_ball + moved)
    gamma, left = np.arctan2(u[..., 1], u[..., 0]), np.ones(u.shape[:-1], dtype=bool)
    for _ in range(30):  # (u - A(gamma)) . A'(gamma) = 0: the line from u meets the profile at a right angle (Lin 2.27)
        rho, rho1, rho2 = radius_with_derivatives(gamma, groove_radius, profile)
        c, s = np.cos(gamma), np.sin(gamma)
        along, across = u[..., 0] * c + u[..., 1] * s, -u[..., 0] * s + u[..., 1] * c
        f = (along - rho) * rho1 + across * rho
        slope = (across - rho1) * rho1 + (along - rho) * rho2 - along * rho + across * rho1
        left &= slope < 0.0
        step = np.clip(f / np.where(left, slope, -1.0), -0.5, 0.5)
        gamma = np.where(left, gamma - step, gamma)
        left &= np.abs(step) >= 1e-15
        if not left.any():
            break
    c, s = np.cos(gamma), np.sin(gamma)
    speed = np.sqrt(rho * rho + rho1 * rho1)
    normal = np.stack([(rho * c + rho1 * s) / speed, (rho * s - rho1 * c) / speed], axis=-1)
    at = np.stack([rho * c, rho * s], axis=-1)
    d = ((at - u) * normal).sum(axis=-1)  # negative for a centre beyond the arc: the approach keeps growing
    curvature = (rho * rho + 2.0 * rho1 * rho1 - rho * rho2) / speed**3  # of a curve in polar coordinates
    reach = 1.0 / curvature - d
    return ball_radius[..., None] - d, SIGNS * normal, np.where(reach > 0.0, 1.0 / np.where(reach > 0.0, reach, 1.0), 0.0)


def radius_with_derivatives(gamma: Array, radius: Array, profile: Array) -> tuple[Array, Array, Array]:
    """Return the radius rho ``(..., 4)`` [m] of flanks at the contact angles gamma [rad], and its first two derivatives."""
    at, turn, bend = angle_of_profile(gamma)
    value, slope, half_bend = profile[..., -1] + np.zeros_like(gamma), np.zeros_like(gamma), np.zeros_like(gamma)
    for k in range(profile.shape[-1] - 2, -1, -1):  # Horner's scheme
        half_bend, slope, value = half_bend * at + slope, slope * at + value, value * at + profile[..., k]
    return radius - value, -slope * turn, -2.0 * half_bend * turn * turn - slope * bend


def lengths(vectors: Array) -> Array:
    """Return the lengths of vectors ``(..., 2)``, with a rounding that does not depend on where they lie in memory."""
    return np.asarray(np.sqrt(vectors[..., 0] * vectors[..., 0] + vectors[..., 1] * vectors[..., 1]))
