"""Approach of a ball to a groove flank, with its first and second derivatives in the section plane, and contact laws."""

from math import atan2, cos, sin, sqrt

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import Array

#: Relative step of Newton's method in one unknown after which it has all digits: each squares the error of the one before.
SETTLED = 1e-9


@kernel
def hertz(delta: float, c: float) -> tuple[float, float, float]:
    """Return force [N], its slope by the approach [N/m] and energy [J] of delta = c F^(2/3) > 0 [m] (Lin 2.14)."""
    x = delta / c  # F^(2/3)
    root = sqrt(x)
    return x * root, 1.5 * root / c, 0.4 * c * x * x * root


@kernel
def contact_law(delta: float, c: float, e: float, h: float) -> tuple[float, float, float]:
    """Return force [N], its slope [N/m] and energy [J] of delta = C F^(2/3) + e F + h F^(4/3) [m], delta > 0.

    Negative e or h would bend the law back where 2 C + 3 e x + 4 h x^2 = 0, x = F^(1/3); from where this is down to C
    on the law goes on as C F^(2/3)/2 plus a constant, so that force and slope stay continuous and the energy convex.
    """
    if e == 0.0 and h == 0.0:
        return hertz(delta, c)
    x = sqrt(delta / c)  # F^(1/3) of Hertz's law, where the search begins
    low, high = 0.0, 1e300
    limit = turning(c, e, h)
    if limit > 0.0:
        # beyond the edge: delta = edge + C (x^2 - limit^2)/2
        edge = limit * limit * (c + limit * (e + limit * h))
        if delta > edge:
            x = sqrt(limit * limit + 2.0 * (delta - edge) / c)
            return x * x * x, 3.0 * x / c, stored(limit, c, e, h) + 0.2 * c * (x**5 - limit**5)
        high = limit
        x = min(x, limit)
    for _ in range(60):  # Newton on C x^2 + e x^3 + h x^4 = delta, bracketed
        f = x * x * (c + x * (e + x * h)) - delta
        if f > 0.0:
            high = x
        else:
            low = x
        new = x - f / (x * (2.0 * c + x * (3.0 * e + 4.0 * h * x)))
        if abs(new - x) <= SETTLED * x:
            x = new
            break
        x = new if low < new < high else 0.5 * (low + high)
    return x * x * x, 3.0 * x / (2.0 * c + x * (3.0 * e + 4.0 * h * x)), stored(x, c, e, h)


@kernel
def turning(c: float, e: float, h: float) -> float:
    """Return the least x > 0 with 3 e x + 4 h x^2 = -C, 0 where there is none."""
    root = 9.0 * e * e - 16.0 * h * c
    if root < 0.0 or (e >= 0.0 and h >= 0.0):
        return 0.0
    if e > 0.0:  # either form for its sign of e: no difference of like numbers
        return -(3.0 * e + sqrt(root)) / (8.0 * h)
    return 2.0 * c / (sqrt(root) - 3.0 * e)


@kernel
def stored(x: float, c: float, e: float, h: float) -> float:
    """Return the energy [J] of a contact at the force x^3.

    Force times approach less the integral of the approach by the force.
    """
    return x * x * x * x * x * (0.4 * c + x * (0.5 * e + 4.0 / 7.0 * h * x))


@kernel
def arc(mx: float, mz: float, wx0: float, wz0: float, size0: float, approach: float) -> tuple[float, float, float, float]:
    """Return approach, normal and curvature term for a circular flank; see `flank`.

    (wx0, wz0), size0: the nominal w and its size; approach: nominal approach [m]. The approach is built as nominal
    value plus change, so that its round-off is that of the motion (1e-22 m), not that of the radii (1e-18 m).
    """
    wx, wz = wx0 + mx, wz0 + mz
    size = sqrt(wx * wx + wz * wz)
    if size <= 1e-30:
        return approach - size0, 0.0, 0.0, 0.0
    change = (mx * (2.0 * wx0 + mx) + mz * (2.0 * wz0 + mz)) / (size + size0)
    return approach + change, wx / size, wz / size, 1.0 / size


@kernel
def flank(
    mx: float, mz: float, wx0: float, wz0: float, r_ball: float, radius: float, profile: Array, sx: float, sz: float
) -> tuple[float, float, float, float]:
    """Return the approach of a ball to the flank rho(gamma) (s_x cos gamma, s_z sin gamma) around the groove's centre.

    (mx, mz): motion of the ball's centre relative to the flank [m]; (wx0, wz0): its nominal position from the groove's
    centre [m]; rho is ``radius`` minus the polynomial ``profile`` (d,), ascending powers of gamma (Lin 2.3, 2.27).
    Returns the approach delta = r_B - d, d the signed distance to the arc, its outward unit normal m, and
    kt = 1/(R_c - d) [1/m]: delta has gradient m and Hessian kt t t^T by w,
    with t normal to m and R_c the profile's radius of curvature.
    """
    ux, uz = sx * (wx0 + mx), sz * (wz0 + mz)
    gamma = atan2(uz, ux)
    rho, rho1, rho2 = radius, 0.0, 0.0
    for _ in range(30):
        rho, rho1, rho2 = radius, 0.0, 0.0
        power, slope, bend = 1.0, 0.0, 0.0  # gamma^k and its two derivatives
        for k in range(profile.shape[0]):
            rho -= profile[k] * power
            rho1 -= profile[k] * slope
            rho2 -= profile[k] * bend
            bend = bend * gamma + 2.0 * slope
            slope = slope * gamma + power
            power = power * gamma
        c, s = cos(gamma), sin(gamma)
        along, across = ux * c + uz * s, -ux * s + uz * c
        # (u - A(gamma)) . A'(gamma) = 0: the line from the centre u meets the profile at a right angle (Lin 2.27)
        f = (along - rho) * rho1 + across * rho
        slope_f = (across - rho1) * rho1 + (along - rho) * rho2 - along * rho + across * rho1
        if slope_f >= 0.0:
            break
        step = min(0.5, max(-0.5, f / slope_f))
        gamma -= step
        if abs(step) < 1e-15:
            break
    c, s = cos(gamma), sin(gamma)
    speed = sqrt(rho * rho + rho1 * rho1)
    nx, nz = (rho * c + rho1 * s) / speed, (rho * s - rho1 * c) / speed
    d = (rho * c - ux) * nx + (rho * s - uz) * nz  # negative for a centre beyond the arc: the approach keeps growing
    # of a curve in polar coordinates
    curvature = (rho * rho + 2.0 * rho1 * rho1 - rho * rho2) / (speed * speed * speed)
    reach = 1.0 / curvature - d
    return r_ball - d, sx * nx, sz * nz, (1.0 / reach if reach > 0.0 else 0.0)
