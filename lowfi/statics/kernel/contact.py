"""Approach of a ball to a groove flank, with its derivatives by the ball's position, and force laws of a contact."""

from math import atan2, cos, sin, sqrt

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import Array

#: Relative size of a Newton step for one unknown after which the iteration ends: as each step squares the error, the result
#: is then exact to round-off.
SETTLED = 1e-9


@kernel
def hertz_law(delta: float, c: float) -> tuple[float, float, float]:
    """Return force F [N], stiffness dF/d delta [N/m] and energy [J] of a Hertzian contact of approach delta > 0 [m].

    The law is delta = c F^(2/3) with the Hertz constant c [m/N^(2/3)], equation 2.14 of Lin's thesis.
    """
    x = delta / c  # F^(2/3)
    root = sqrt(x)
    return x * root, 1.5 * root / c, 0.4 * c * x * x * root


@kernel
def contact_law(delta: float, c: float, e: float, h: float) -> tuple[float, float, float]:
    """Return force F [N], stiffness dF/d delta [N/m] and energy [J] of a contact of approach delta > 0 [m].

    The law delta = c F^(2/3) + e F + h F^(4/3) adds two terms of the elastic bodies to Hertz's. With negative e or h, the
    approach would decrease with the force above the point where 2 c + 3 e x + 4 h x^2 = 0, x = F^(1/3). The law is
    therefore continued as c F^(2/3)/2 plus a constant from the point where this expression equals c. Force and stiffness
    are continuous there, and the energy remains convex. Units: c [m/N^(2/3)], e [m/N], h [m/N^(4/3)].
    """
    if e == 0.0 and h == 0.0:
        return hertz_law(delta, c)
    x = sqrt(delta / c)  # F^(1/3) of Hertz's law, where the search begins
    low, high = 0.0, 1e300
    limit = force_root_at_continuation(c, e, h)
    if limit > 0.0:
        # beyond the edge: delta = edge + C (x^2 - limit^2)/2
        edge = limit * limit * (c + limit * (e + limit * h))
        if delta > edge:
            x = sqrt(limit * limit + 2.0 * (delta - edge) / c)
            return x * x * x, 3.0 * x / c, contact_energy(limit, c, e, h) + 0.2 * c * (x**5 - limit**5)
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
    return x * x * x, 3.0 * x / (2.0 * c + x * (3.0 * e + 4.0 * h * x)), contact_energy(x, c, e, h)


@kernel
def force_root_at_continuation(c: float, e: float, h: float) -> float:
    """Return the cube root of the force [N^(1/3)] from which `contact_law` continues as c F^(2/3)/2 + constant; 0 if none.

    This cube root is the smallest x > 0 with 3 e x + 4 h x^2 = -c, where the law is delta = c x^2 + e x^3 + h x^4 at the
    approach delta and the force x^3.
    """
    root = 9.0 * e * e - 16.0 * h * c
    if root < 0.0 or (e >= 0.0 and h >= 0.0):
        return 0.0
    if e > 0.0:  # the formula depends on the sign of e, to avoid subtracting nearly equal numbers
        return -(3.0 * e + sqrt(root)) / (8.0 * h)
    return 2.0 * c / (sqrt(root) - 3.0 * e)


@kernel
def contact_energy(x: float, c: float, e: float, h: float) -> float:
    """Return the elastic energy [J] of a contact that follows `contact_law`, at the force x^3 [N].

    The energy is force times approach, minus the integral of the approach over the force. c, e, h: coefficients of the law
    approach = c F^(2/3) + e F + h F^(4/3).
    """
    return x * x * x * x * x * (0.4 * c + x * (0.5 * e + 4.0 / 7.0 * h * x))


@kernel
def approach_to_arc(
    mx: float, mz: float, wx0: float, wz0: float, size0: float, approach: float
) -> tuple[float, float, float, float]:
    """Return approach [m], unit normal (x, z) and curvature term [1/m] of a ball's contact with a circular groove flank.

    x is the radial component, z the one along the helix's binormal. (mx, mz): motion of the ball's centre relative to the
    flank [m]; (wx0, wz0): its nominal position from the groove's centre [m], of length size0; approach: nominal approach
    [m]. The approach is computed as its nominal value plus its change, so that its round-off is that of the motion
    (1e-22 m), not that of the radii (1e-18 m). The curvature term times the contact force is the tangential stiffness
    of the contact; here it is the inverse distance of groove centre and ball centre.
    """
    wx, wz = wx0 + mx, wz0 + mz
    size = sqrt(wx * wx + wz * wz)
    if size <= 1e-30:
        return approach - size0, 0.0, 0.0, 0.0
    change = (mx * (2.0 * wx0 + mx) + mz * (2.0 * wz0 + mz)) / (size + size0)
    return approach + change, wx / size, wz / size, 1.0 / size


@kernel
def approach_to_profile(
    mx: float, mz: float, wx0: float, wz0: float, r_ball: float, radius: float, profile: Array, sx: float, sz: float
) -> tuple[float, float, float, float]:
    """Return approach [m], unit normal (x, z) and curvature term [1/m] of a ball's contact with a non-circular flank.

    The flank is the curve rho(gamma) (s_x cos gamma, s_z sin gamma) around the groove's centre. rho is ``radius`` [m] minus
    the polynomial ``profile`` (d,) in ascending powers of the contact angle gamma (equations 2.3 and 2.27 of Lin's thesis).
    (mx, mz): motion of the ball's centre relative to the flank [m]; (wx0, wz0): its nominal position w from the groove's
    centre [m]; r_ball: ball radius [m]; sx, sz: signs of the contact direction.

    The approach is delta = r_ball - d, with the signed distance d of the ball's centre from the flank. m is the unit normal
    from ball to groove. The curvature term is kt = 1/(R_c - d), with the radius of curvature R_c of the flank, or zero if
    the centre lies beyond the centre of curvature. The derivatives of delta by w are the gradient m and the Hessian
    kt t t^T, with the tangent t normal to m.
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
    # curvature of a curve in polar coordinates
    curvature = (rho * rho + 2.0 * rho1 * rho1 - rho * rho2) / (speed * speed * speed)
    reach = 1.0 / curvature - d
    return r_ball - d, sx * nx, sz * nz, (1.0 / reach if reach > 0.0 else 0.0)
