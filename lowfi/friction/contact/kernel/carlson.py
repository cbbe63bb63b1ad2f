"""Carlson's R_D with its derivative by the second argument, by duplication."""

from math import sqrt

from rollbench.lowfi.jit import kernel


@kernel
def _series(x: float, y: float, mean: float) -> float:
    """R_D (x + ..)^(3/2) about equal arguments, to the seventh order (DLMF 19.36.2); x, y: relative deviations."""
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
def _series_slope(x: float, y: float, dx: float, dy: float) -> float:
    """Derivative of the bracket of ``_series`` along (dx, dy)."""
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
def rd_and_slope(x: float, y: float, z: float) -> tuple[float, float]:
    """R_D(x, y, z) and -(4/3) dR_D/dy = integral over t of (t+x)^(-1/2) (t+y)^(-3/2) (t+z)^(-3/2), t = 0 to infinity.

    x >= 0, y, z > 0, dimensionless. The second is (2/3) (R_D(x, z, y) - R_D(x, y, z)) / (z - y) without its
    cancellation at y = z. Duplication (Carlson 1995), differentiated step by step.
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
    end = _series(ux, uy, mean)
    bend = _series_slope(ux, uy, (x * d_mean / mean - dx) / mean, (y * d_mean / mean - dy) / mean)
    slope = 3.0 * d_total + scale * (bend / (mean * sqrt(mean)) - 1.5 * end * d_mean / mean)
    return 3.0 * total + scale * end, -4.0 / 3.0 * slope
