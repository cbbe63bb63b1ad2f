"""Dissipated power of one elliptical contact as a function of sliding velocity, spin and a regularising speed.

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

from math import copysign, sqrt

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import Array, DissipationTerms
from rollbench.lowfi.jit import kernel


@kernel
def _carlson_series(x: float, y: float, mean: float) -> float:
    """Return Carlson's elliptic integral R_D for nearly equal arguments by its series to the seventh order (DLMF 19.36.2).

    x, y: relative deviations of the first two arguments from ``mean``, the weighted mean of all three.
    """
    z = -(x + y) / 3.0
    xy, zz = x * y, z * z
    e2 = xy - 6.0 * zz
    e3 = (3.0 * xy - 8.0 * zz) * z
    e4 = 3.0 * (xy - zz) * zz
    e5 = xy * zz * z
    low = 1.0 - 3.0 * e2 / 14.0 + e3 / 6.0 + 9.0 * e2 * e2 / 88.0 - 3.0 * e4 / 22.0 - 9.0 * e2 * e3 / 52.0
    high = 3.0 * e5 / 26.0 - e2 * e2 * e2 / 16.0 + 3.0 * e3 * e3 / 40.0 + 3.0 * e2 * e4 / 20.0
    return (low + high + 45.0 * e2 * e2 * e3 / 272.0 - 9.0 * (e3 * e4 + e2 * e5) / 68.0) / (mean * sqrt(mean))


@kernel
def _carlson_series_derivative(x: float, y: float, dx: float, dy: float) -> float:
    """Return the derivative of the polynomial in `_carlson_series` along the direction (dx, dy).

    x, y: relative deviations of the first two arguments of R_D from their mean, at which the derivative is taken.
    """
    z, dz = -(x + y) / 3.0, -(dx + dy) / 3.0
    xy, zz = x * y, z * z
    dxy, dzz = dx * y + x * dy, 2.0 * z * dz
    e2, d2 = xy - 6.0 * zz, dxy - 6.0 * dzz
    e3, d3 = (3.0 * xy - 8.0 * zz) * z, (3.0 * dxy - 8.0 * dzz) * z + (3.0 * xy - 8.0 * zz) * dz
    e4, d4 = 3.0 * (xy - zz) * zz, 3.0 * ((dxy - dzz) * zz + (xy - zz) * dzz)
    e5, d5 = xy * zz * z, dxy * zz * z + 1.5 * xy * z * dzz
    low = -3.0 * d2 / 14.0 + d3 / 6.0 + 9.0 * e2 * d2 / 44.0 - 3.0 * d4 / 22.0 - 9.0 * (d2 * e3 + e2 * d3) / 52.0
    high = 3.0 * d5 / 26.0 - 3.0 * e2 * e2 * d2 / 16.0 + 3.0 * e3 * d3 / 20.0 + 3.0 * (d2 * e4 + e2 * d4) / 20.0
    last = 45.0 * (2.0 * e2 * d2 * e3 + e2 * e2 * d3) / 272.0
    return low + high + last - 9.0 * (d3 * e4 + e3 * d4 + d2 * e5 + e2 * d5) / 68.0


@kernel
def carlson_rd_and_slope(x: float, y: float, z: float) -> tuple[float, float]:
    """Return Carlson's elliptic integral R_D(x, y, z), then -(4/3) dR_D/dy, for x >= 0 and y, z > 0.

    The second value is the integral over t = 0 to infinity of (t+x)^(-1/2) (t+y)^(-3/2) (t+z)^(-3/2). The second value
    equals (2/3) (R_D(x, z, y) - R_D(x, y, z))/(z - y), but without the cancellation at y = z. Both values come from
    Carlson's duplication (1995), differentiated in each step.
    """
    dx, dy, dz = 0.0, 1.0, 0.0
    total, d_total, scale = 0.0, 0.0, 1.0
    for _ in range(60):
        mean = (x + y + 3.0 * z) / 5.0
        if abs(mean - x) + abs(mean - y) + abs(mean - z) < 4e-2 * mean:
            break
        sx, sy, sz = sqrt(x), sqrt(y), sqrt(z)
        tx = 0.5 * dx / sx if x > 0.0 else 0.0
        ty, tz = 0.5 * dy / sy, 0.5 * dz / sz
        shift = sx * (sy + sz) + sy * sz
        d_shift = tx * (sy + sz) + sx * (ty + tz) + ty * sz + sy * tz
        term = scale / (sz * (z + shift))
        total += term
        d_total -= term * (tz / sz + (dz + d_shift) / (z + shift))
        scale *= 0.25
        x, y, z = 0.25 * (x + shift), 0.25 * (y + shift), 0.25 * (z + shift)
        dx, dy, dz = 0.25 * (dx + d_shift), 0.25 * (dy + d_shift), 0.25 * (dz + d_shift)
    mean, d_mean = (x + y + 3.0 * z) / 5.0, (dx + dy + 3.0 * dz) / 5.0
    ux, uy = 1.0 - x / mean, 1.0 - y / mean
    end = _carlson_series(ux, uy, mean)
    bend = _carlson_series_derivative(ux, uy, (x * d_mean / mean - dx) / mean, (y * d_mean / mean - dy) / mean)
    slope = 3.0 * d_total + scale * (bend / (mean * sqrt(mean)) - 1.5 * end * d_mean / mean)
    return 3.0 * total + scale * end, -4.0 / 3.0 * slope


#: Mean distance psi and its derivatives, with r = (x, y, h) and the Hessian matrix H: psi; psi_x, psi_y, psi_h; N = psi - r
#: . grad psi; psi_xx, psi_xy, psi_yy; (H r)_x, (H r)_y; r . H r.
Potential = tuple[float, float, float, float, float, float, float, float, float, float, float]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)

#: Squares and weights of the positive Gauss nodes only, because the integrand over (-1, 1) is even.
_U2, _W = _NODES[12:] ** 2, _WEIGHTS[12:].copy()


@kernel
def confocal_coordinate(x: float, y: float, h: float, b2: float) -> float:
    """Return the confocal ellipsoidal coordinate of the point (x, y, h); zero for a point of the ellipse at h = 0.

    The coordinate is the largest root l >= 0 of x^2/(1 + l) + y^2/(b^2 + l) + h^2/l = 1. Lengths are in units of the
    semi-axis a; b2: square of the ratio b of the semi-axes.
    """
    x2, y2, h2 = x * x, y * y, h * h
    p = x2 + y2 - 1.0 - b2
    q = b2 * (x2 - 1.0) + y2
    root = 0.0
    if q > 0.0 or p > 0.0:
        gap = x2 - y2 - 1.0 + b2
        size = sqrt(gap * gap + 4.0 * x2 * y2)
        root = max(0.0, 0.5 * (p + size) if p > 0.0 else 2.0 * q / (size - p))
    if h2 == 0.0:
        return root
    # Newton on 1 / sum, increasing and concave: from the left it rises monotonically to the root
    s = max(root, h2)
    for _ in range(200):
        ux, uy, uh = 1.0 / (1.0 + s), 1.0 / (b2 + s), 1.0 / s
        total = x2 * ux + y2 * uy + h2 * uh
        slope = x2 * ux * ux + y2 * uy * uy + h2 * uh * uh
        step = total * (total - 1.0) / slope
        s += step
        if step <= 4e-16 * s:
            break
    return s


@kernel
def mean_distance_near_ellipse(x: float, y: float, h: float, b2: float, low: float) -> Potential:
    """Return the pressure-weighted mean distance psi of a contact from a point, with derivatives, by Carlson's integrals.

    The function is for points with a confocal coordinate ``low`` <= 1 (`confocal_coordinate`). x, y, h: coordinates of
    the point in units of the semi-axis a, with the height h above the ellipse; b2: square of the ratio of the
    semi-axes.
    """
    # moments i_... of the ellipsoid's potential from R_D; edge: the integrals' lower end
    cy, cx = low + b2, low + 1.0
    p, t = carlson_rd_and_slope(low, cy, cx)
    q = p + 1.5 * (1.0 - b2) * t
    edge = sqrt(low / (cy * cx))
    i_x, i_y = 2.0 * (edge + b2 * q / 3.0), 2.0 * (edge + p / 3.0)
    i_xh, i_yh = 2.0 * p / 3.0, 2.0 * q / 3.0
    i_xx, i_yy, i_xy = (2.0 * edge / cx + b2 * t) / 3.0, (2.0 * edge / cy + t) / 3.0, i_xh - b2 * t
    i_h = i_x + i_xh
    i_hh = 2.0 / (edge * cy * cx) - i_xh - i_yh if h > 0.0 else 0.0
    x2, y2, h2 = x * x, y * y, h * h
    # psi_i = x_i f_i, then second derivatives
    f_x = 0.75 * (i_x - x2 * i_xx - y2 * i_xy - h2 * i_xh)
    f_y = 0.75 * (i_y - x2 * i_xy - y2 * i_yy - h2 * i_yh)
    f_h = 0.75 * (i_h - x2 * i_xh - y2 * i_yh - h2 * i_hh)
    xx, yy, hh = f_x - 1.5 * x2 * i_xx, f_y - 1.5 * y2 * i_yy, f_h - 1.5 * h2 * i_hh
    xy, xh, yh = -1.5 * x * y * i_xy, -1.5 * x * h * i_xh, -1.5 * y * h * i_yh
    along = x2 * f_x + y2 * f_y + h2 * f_h
    base = 2.0 * edge * cy + i_x + b2 * i_xh + x2 * i_x + y2 * i_y + h2 * i_h
    r_x, r_y, r_h = xx * x + xy * y + xh * h, xy * x + yy * y + yh * h, xh * x + yh * y + hh * h
    return (
        0.1875 * base + 0.25 * along,
        x * f_x,
        y * f_y,
        h * f_h,
        0.1875 * base - 0.75 * along,
        xx,
        xy,
        yy,
        r_x,
        r_y,
        x * r_x + y * r_y + h * r_h,
    )


@kernel
def mean_distance_far_from_ellipse(x: float, y: float, h: float, b2: float, low: float) -> Potential:
    """Return the pressure-weighted mean distance psi of a contact from a point, with derivatives, by Gauss sums.

    The function is for points with a confocal coordinate ``low`` >= 1 (`confocal_coordinate`). The other arguments are
    those of `mean_distance_near_ellipse`.
    """
    rho = sqrt(low)
    x, y, h = x / rho, y / rho, h / rho
    ka, kb = 1.0 / low, b2 / low
    x2, y2, h2 = x * x, y * y, h * h
    f_x, f_y, f_h, xx, yy, xy, moment, r_x, r_y, r_r = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(_U2.shape[0]):
        u2 = _U2[k]
        p, q = 1.0 / (1.0 + ka * u2), 1.0 / (1.0 + kb * u2)
        w = 2.0 * _W[k] * sqrt(p * q)
        v = u2 * (x2 * p + y2 * q + h2)
        u = 1.0 - v
        f_x += w * p * u
        f_y += w * q * u
        f_h += w * u
        xx += w * p * p * u2
        yy += w * q * q * u2
        xy += w * p * q * u2
        e, f = ka * p + kb * q, u2 * (ka * x2 * p * p + kb * y2 * q * q)
        moment += w * u * (e * u - 4.0 * f)
        turn = 2.0 * e * u - 4.0 * f
        r_x += w * u2 * p * (turn + 4.0 * u * ka * p)
        r_y += w * u2 * q * (turn + 4.0 * u * kb * q)
        r_r += w * (v * turn + 4.0 * u * f)
    g_x, g_y, g_h = 0.75 * x * f_x, 0.75 * y * f_y, 0.75 * h * f_h
    turning = 0.1875 * moment * rho
    return (
        turning + rho * (x * g_x + y * g_y + h * g_h),
        g_x,
        g_y,
        g_h,
        turning,
        (0.75 * f_x - 1.5 * x2 * xx) / rho,
        -1.5 * x * y * xy / rho,
        (0.75 * f_y - 1.5 * y2 * yy) / rho,
        0.375 * x * r_x,
        0.375 * y * r_y,
        0.375 * r_r * rho,
    )


@kernel
def dissipation(a: float, b: float, vx: float, vz: float, spin: float, speed: float) -> DissipationTerms:
    """Return D, the power dissipated in one contact divided by its friction bound mu F, and the derivatives of D.

    D is int p sqrt(|v|^2 + speed^2) dA/F. The local sliding velocity is v = (vx + spin z, vz - spin x), p the Hertz
    pressure of the contact force F, mu the coefficient of friction. a >= b > 0: semi-axes along x and z [m]; vx, vz:
    sliding velocity at the centre [m/s]; spin [rad/s]; speed: regularising speed >= 0 [m/s]. The friction force is -mu
    F dD/dv, and the loss is mu F (D - speed dD/dspeed) (Lin 3.14-3.18 at speed = 0). D is convex and homogeneous of
    degree one in (vx, vz, spin, speed). D is smooth except at rest, where the derivatives are returned as zero.
    """
    turn = spin * a
    slide = sqrt(vx * vx + vz * vz + speed * speed)
    if abs(turn) < 1e-40 * slide:
        turn = copysign(1e-40 * slide, turn)
    size = abs(turn)
    if size == 0.0:
        return DissipationTerms(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    # centre of rotation in units of a, and the regularising speed as the height above the ellipse
    x, y, h, b2 = vz / turn, -vx / turn, speed / size, (b / a) * (b / a)
    low = confocal_coordinate(x, y, h, b2)
    value, g_x, g_y, g_h, moment, xx, xy, yy, r_x, r_y, r_r = (
        mean_distance_near_ellipse(x, y, h, b2, low) if low <= 1.0 else mean_distance_far_from_ellipse(x, y, h, b2, low)
    )
    sign, lever = copysign(1.0, turn), a / size
    return DissipationTerms(
        size * value,
        -sign * g_y,
        sign * g_x,
        sign * a * moment,
        g_h,
        yy / size,
        -xy / size,
        xx / size,
        lever * r_y,
        -lever * r_x,
        lever * a * r_r,
    )


@kernel
def dissipation_of_contacts(a: Array, b: Array, motion: Array, speed: float, out: Array) -> None:
    """Write the dissipated power divided by mu F, and its derivatives, of n contacts to out (n, 11).

    The eleven values of a row are the fields of `DissipationTerms`; mu F is the friction bound. a, b (n,): semi-axes
    [m]; motion (n, 3): sliding vx, vz along the semi-axes a, b [m/s] and spin [rad/s]; speed: regularising speed [m/s].
    """
    for i in range(a.shape[0]):
        out[i] = dissipation(a[i], b[i], motion[i, 0], motion[i, 1], motion[i, 2], speed)
