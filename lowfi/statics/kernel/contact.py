"""Approach of a ball to a groove flank, with its first and second derivatives in the section plane, and Hertz' law."""

from math import atan2, cos, sin, sqrt

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import Array


@kernel
def hertz(delta: float, c: float) -> tuple[float, float, float]:
    """Force [N], its slope by the approach [N/m] and energy [J] of delta = c F^(2/3) > 0 [m] (Lin 2.14)."""
    x = delta / c
    root = sqrt(x)
    return x * root, 1.5 * root / c, 0.4 * c * x * x * root


@kernel
def arc(mx: float, mz: float, wx0: float, wz0: float, size0: float, approach: float) -> tuple[float, float, float, float]:
    """Approach, normal and curvature term for a circular flank; see ``flank``.

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
    """Approach of a ball to the flank rho(gamma) (s_x cos gamma, s_z sin gamma) around the groove's centre.

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
        power, slope, bend = 1.0, 0.0, 0.0
        for k in range(profile.shape[0]):
            rho -= profile[k] * power
            rho1 -= profile[k] * slope
            rho2 -= profile[k] * bend
            bend = bend * gamma + 2.0 * slope
            slope = slope * gamma + power
            power = power * gamma
        c, s = cos(gamma), sin(gamma)
        along, across = ux * c + uz * s, -ux * s + uz * c
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
    curvature = (rho * rho + 2.0 * rho1 * rho1 - rho * rho2) / (speed * speed * speed)
    reach = 1.0 / curvature - d
    return r_ball - d, sx * nx, sz * nz, (1.0 / reach if reach > 0.0 else 0.0)
