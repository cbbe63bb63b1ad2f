"""Dissipated power of elliptical contacts as a function of sliding velocity, spin and a regularising speed, as arrays.

The local sliding speed is proportional to the distance from the centre of rotation. The power is therefore the mean
distance psi of the points of the contact from this centre, weighted with the pressure. For unit force and a = 1 the Hertz
pressure is the mass density of a homogeneous ellipsoid with semi-axes (1, b, 0), flattened to its plane; the regularising
speed is a height h above the plane. The derivatives of psi are

    psi_i = (3/4) x_i int_l^oo U s / ((a_i^2 + s) S) ds,   S = sqrt(s (s + b^2) (s + 1)),
    U = 1 - x^2/(1 + s) - y^2/(b^2 + s) - h^2/s,

with the largest root l of U (zero for a point of the ellipse). U vanishes at l, so that second derivatives need no
derivative of l. For l <= 1 the integrals are Carlson's R_D, computed by duplication; for larger l they are Gauss sums of a
smooth even function.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rollbench.meshes.arrays import Array


class ContactDissipationRatio(NamedTuple):
    """Dissipated power of contacts divided by their friction bounds mu F: the ratio D, with its derivatives."""

    #: Ratio D, a convex function of the motion ``(...)`` [m/s].
    value: Array
    #: Derivatives of D by vx, vz [-] and spin [m] ``(..., 3)``.
    gradient: Array
    #: Derivative of D by the regularising speed ``(...)`` [-].
    by_speed: Array
    #: Second derivatives of D by vx, vz and spin ``(..., 3, 3)`` [s/m, s, m s].
    hessian: Array


def dissipation_ratio(a: Array, b: Array, motion: Array, speed: Array | float) -> ContactDissipationRatio:
    """Return the power dissipated in contacts divided by their friction bounds mu F, and its derivatives, in closed form.

    D is int p sqrt(|v|^2 + speed^2) dA/F. The local sliding velocity is v = (vx + spin z, vz - spin x), p the Hertz
    pressure of the contact force F, mu the coefficient of friction. The friction force is -mu F dD/dv, and the loss is
    mu F (D - speed dD/dspeed) (Lin 3.14-3.18 at speed = 0). D is convex and homogeneous of degree one in (vx, vz, spin,
    speed). D is smooth except at rest, where the derivatives are returned as zero.

    Parameters
    ----------
    a, b
        Semi-axes a >= b > 0 along x and z ``(...)`` [m].
    motion
        Sliding velocity vx, vz at the centre [m/s] and spin [rad/s] ``(..., 3)``.
    speed
        Regularising speed >= 0 ``(...)`` [m/s].
    """
    full = np.broadcast_shapes(np.shape(a), np.shape(b), motion.shape[:-1], np.shape(speed))
    vx, vz, spin = (np.broadcast_to(v, full).ravel() for v in np.moveaxis(motion, -1, 0))
    a, b, eps = (np.broadcast_to(v, full).ravel() for v in (a, b, speed))
    turn = spin * a
    least = 1e-40 * np.sqrt(vx * vx + vz * vz + eps * eps)
    turn = np.where(np.abs(turn) < least, np.copysign(least, turn), turn)
    size = np.abs(turn)
    moves = size > 0.0
    if not moves.all():
        at_rest = np.zeros(full), np.zeros((*full, 3)), np.zeros(full), np.zeros((*full, 3, 3))
        moving = dissipation_ratio(a[moves], b[moves], _rows(vx, vz, spin)[moves], eps[moves])
        for whole, part in zip(at_rest, moving, strict=True):
            whole[moves.reshape(full)] = part
        return ContactDissipationRatio(*at_rest)
    # centre of rotation in units of a, and the regularising speed as the height above the ellipse
    psi = _mean_distance(vz / turn, -vx / turn, eps / size, (b / a) ** 2)
    sign, lever = np.copysign(1.0, turn), a / size
    xz, x_spin, z_spin = -psi.xy / size, lever * psi.ry, -lever * psi.rx
    hessian = _rows(psi.yy / size, xz, x_spin, xz, psi.xx / size, z_spin, x_spin, z_spin, lever * a * psi.rr)
    return ContactDissipationRatio(
        value=(size * psi.value).reshape(full),
        gradient=_rows(-sign * psi.y, sign * psi.x, sign * a * psi.turning).reshape(*full, 3),
        by_speed=psi.h.reshape(full),
        hessian=hessian.reshape(*full, 3, 3),
    )


def _rows(*columns: Array) -> Array:
    """Return arrays ``(n,)`` as the columns of one array ``(n, k)``."""
    return np.stack(columns, axis=-1)


class _MeanDistance(NamedTuple):
    """Mean distance psi of contacts from points r = (x, y, h), with its gradient and Hessian H, arrays ``(n,)``."""

    #: Mean distance psi.
    value: Array
    #: Derivative of psi by x.
    x: Array
    #: Derivative of psi by y.
    y: Array
    #: Derivative of psi by h.
    h: Array
    #: psi - r . grad psi, the mean distance that spin contributes.
    turning: Array
    #: Second derivative by x, twice.
    xx: Array
    #: Second derivative by x and y.
    xy: Array
    #: Second derivative by y, twice.
    yy: Array
    #: First component of H r.
    rx: Array
    #: Second component of H r.
    ry: Array
    #: Scalar r . H r.
    rr: Array


def _mean_distance(x: Array, y: Array, h: Array, b2: Array) -> _MeanDistance:
    """Return the pressure-weighted mean distance psi of n contacts from points, with derivatives.

    ``x``, ``y``, ``h``: coordinates of the points in units of the semi-axis a, with the height h above the ellipse; ``b2``:
    square of the ratio of the semi-axes; all ``(n,)``.
    """
    low = confocal_coordinate(x, y, h, b2)
    near = low <= 1.0
    if near.all():
        return _near_ellipse(x, y, h, b2, low)
    if not near.any():
        return _far_from_ellipse(x, y, h, b2, low)
    out = np.empty((len(_MeanDistance._fields), x.size))
    for law, where in ((_near_ellipse, near), (_far_from_ellipse, ~near)):
        out[:, where] = law(*(values[where] for values in (x, y, h, b2, low)))
    return _MeanDistance(*out)


def confocal_coordinate(x: Array, y: Array, h: Array, b2: Array) -> Array:
    """Return the confocal ellipsoidal coordinate of points (x, y, h) ``(n,)``; zero on the ellipse at h = 0.

    The coordinate is the largest root l >= 0 of x^2/(1 + l) + y^2/(b^2 + l) + h^2/l = 1. Lengths are in units of the
    semi-axis a; ``b2``: square of the ratio b of the semi-axes.
    """
    x2, y2, h2 = x * x, y * y, h * h
    p, q, gap = x2 + y2 - 1.0 - b2, b2 * (x2 - 1.0) + y2, x2 - y2 - 1.0 + b2
    size = np.sqrt(gap * gap + 4.0 * x2 * y2)
    behind = np.where(p > 0.0, 1.0, size - p)  # where p > 0 the other formula of the root is free of cancellation
    root = np.maximum(np.where(p > 0.0, 0.5 * (p + size), 2.0 * q / np.where(behind > 0.0, behind, 1.0)), 0.0)
    above = h2 > 0.0
    if above.any():
        root[above] = _root_above_ellipse(x2[above], y2[above], h2[above], b2[above], root[above])
    return np.asarray(root)


def _root_above_ellipse(x2: Array, y2: Array, h2: Array, b2: Array, root: Array) -> Array:
    """Return the confocal coordinate of points above the ellipse, h > 0, from that at h = 0; squares as arguments ``(n,)``.

    Newton's method on 1 / sum, which is increasing and concave: from the left it rises monotonically to the root.
    """
    s, rises = np.maximum(root, h2), np.ones(root.size, dtype=bool)
    for _ in range(200):
        ux, uy, uh = 1.0 / (1.0 + s), 1.0 / (b2 + s), 1.0 / s
        tx, ty, th = x2 * ux, y2 * uy, h2 * uh
        total = tx + ty + th
        step = total * (total - 1.0) / (tx * ux + ty * uy + th * uh)
        s = s + rises * step
        rises = rises & (step > 4e-16 * s)  # once at the root, round-off may seem to rise on
        if not rises.any():
            break
    return np.asarray(s)


def _near_ellipse(x: Array, y: Array, h: Array, b2: Array, low: Array) -> _MeanDistance:
    """Return the mean distance psi for points with a confocal coordinate ``low`` <= 1, by Carlson's integrals.

    The other arguments are those of `_mean_distance`.
    """
    # moments i_... of the ellipsoid's potential from R_D; edge: the integrals' lower end
    cy, cx = low + b2, low + 1.0
    p, t = carlson_rd_and_slope(low, cy, cx)
    q = p + 1.5 * (1.0 - b2) * t
    edge = np.sqrt(low / (cy * cx))
    i_x, i_y = 2.0 * (edge + b2 * q / 3.0), 2.0 * (edge + p / 3.0)
    i_xh, i_yh = 2.0 * p / 3.0, 2.0 * q / 3.0
    i_xx, i_yy, i_xy = (2.0 * edge / cx + b2 * t) / 3.0, (2.0 * edge / cy + t) / 3.0, i_xh - b2 * t
    i_h = i_x + i_xh
    above = h > 0.0
    i_hh = np.where(above, 2.0 / (np.where(above, edge, 1.0) * cy * cx) - i_xh - i_yh, 0.0)
    x2, y2, h2 = x * x, y * y, h * h
    # psi_i = x_i f_i, then second derivatives
    f_x = 0.75 * (i_x - x2 * i_xx - y2 * i_xy - h2 * i_xh)
    f_y = 0.75 * (i_y - x2 * i_xy - y2 * i_yy - h2 * i_yh)
    f_h = 0.75 * (i_h - x2 * i_xh - y2 * i_yh - h2 * i_hh)
    xx, yy, hh = f_x - 1.5 * x2 * i_xx, f_y - 1.5 * y2 * i_yy, f_h - 1.5 * h2 * i_hh
    xy, xh, yh = -1.5 * x * y * i_xy, -1.5 * x * h * i_xh, -1.5 * y * h * i_yh
    along = x2 * f_x + y2 * f_y + h2 * f_h
    base = 0.1875 * (2.0 * edge * cy + i_x + b2 * i_xh + x2 * i_x + y2 * i_y + h2 * i_h)
    rx, ry, rh = xx * x + xy * y + xh * h, xy * x + yy * y + yh * h, xh * x + yh * y + hh * h
    turning, rr = base - 0.75 * along, x * rx + y * ry + h * rh
    return _MeanDistance(base + 0.25 * along, x * f_x, y * f_y, h * f_h, turning, xx, xy, yy, rx, ry, rr)


_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)

#: Squares and weights of the positive Gauss nodes only, because the integrand over (-1, 1) is even.
_U2, _W = _NODES[12:] ** 2, 2.0 * _WEIGHTS[12:]


def _far_from_ellipse(x: Array, y: Array, h: Array, b2: Array, low: Array) -> _MeanDistance:
    """Return the mean distance psi for points with a confocal coordinate ``low`` >= 1, by Gauss sums (axes contact, node).

    The other arguments are those of `_mean_distance`.
    """
    rho = np.sqrt(low)
    x, y, h = x / rho, y / rho, h / rho
    ka, kb, x2, y2, h2 = (values[:, None] for values in (1.0 / low, b2 / low, x * x, y * y, h * h))
    p, q = 1.0 / (1.0 + ka * _U2), 1.0 / (1.0 + kb * _U2)
    w = _W * np.sqrt(p * q)
    wp, wq = w * p, w * q
    v = _U2 * (x2 * p + y2 * q + h2)
    u = 1.0 - v
    e, f = ka * p + kb * q, _U2 * (ka * x2 * p * p + kb * y2 * q * q)
    turn = 2.0 * e * u - 4.0 * f
    f_x, f_y, f_h = (wp * u).sum(-1), (wq * u).sum(-1), (w * u).sum(-1)
    xx, yy, xy = (wp * p) @ _U2, (wq * q) @ _U2, (wp * q) @ _U2
    rx, ry = (wp * (turn + 4.0 * u * ka * p)) @ _U2, (wq * (turn + 4.0 * u * kb * q)) @ _U2
    rr = (w * (v * turn + 4.0 * u * f)).sum(-1)
    turning = 0.1875 * rho * (w * u * (e * u - 4.0 * f)).sum(-1)
    g_x, g_y, g_h = 0.75 * x * f_x, 0.75 * y * f_y, 0.75 * h * f_h
    bend_x, bend_y = (0.75 * f_x - 1.5 * x * x * xx) / rho, (0.75 * f_y - 1.5 * y * y * yy) / rho
    value, twist = turning + rho * (x * g_x + y * g_y + h * g_h), -1.5 * x * y * xy / rho
    moments = 0.375 * x * rx, 0.375 * y * ry, 0.375 * rr * rho
    return _MeanDistance(value, g_x, g_y, g_h, turning, bend_x, twist, bend_y, *moments)


def carlson_rd_and_slope(x: Array, y: Array, z: Array) -> tuple[Array, Array]:
    """Return Carlson's elliptic integral R_D(x, y, z), then -(4/3) dR_D/dy, for x >= 0 and y, z > 0, ``(n,)`` each.

    The second value is the integral over t = 0 to infinity of (t+x)^(-1/2) (t+y)^(-3/2) (t+z)^(-3/2). It equals (2/3)
    (R_D(x, z, y) - R_D(x, y, z))/(z - y), but without the cancellation at y = z: the derivative is the imaginary part of
    R_D at a y with an imaginary part, which is too small to change the real part.
    """
    from scipy.special import elliprd  # loads slowly

    found = elliprd(x, y * (1.0 + 1e-30j), z)
    return found.real, -4.0 / 3.0 * found.imag / (1e-30 * y)
