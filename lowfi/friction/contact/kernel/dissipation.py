"""Dissipation of one elliptical contact as a function of its sliding velocity, its spin and a regularising speed."""

from math import copysign, sqrt

from rollbench.lowfi.friction.contact.kernel_types import Array, DissipationTerms
from rollbench.lowfi.jit import kernel

from .confocal import coordinate, far, near


@kernel
def dissipation(a: float, b: float, vx: float, vz: float, spin: float, speed: float) -> DissipationTerms:
    """D = int p sqrt(|v|^2 + speed^2) dA / F with v = (vx + spin z, vz - spin x), and its derivatives.

    a >= b > 0: semi-axes along x and z [m]; vx, vz, speed >= 0 [m/s]; spin [rad/s]; p: Hertz pressure of the force F.
    Friction is -mu F dD/dv; the loss is mu F (D - speed dD/dspeed) (Lin 3.14-3.18 at speed = 0). D is convex,
    of degree one in (vx, vz, spin, speed), and smooth but at rest, where the derivatives returned are zero.
    """
    turn = spin * a
    slide = sqrt(vx * vx + vz * vz + speed * speed)
    if abs(turn) < 1e-40 * slide:
        turn = copysign(1e-40 * slide, turn)
    size = abs(turn)
    if size == 0.0:
        return DissipationTerms(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    x, y, h, b2 = vz / turn, -vx / turn, speed / size, (b / a) * (b / a)
    low = coordinate(x, y, h, b2)
    value, g_x, g_y, g_h, moment, xx, xy, yy, r_x, r_y, r_r = (
        near(x, y, h, b2, low) if low <= 1.0 else far(x, y, h, b2, low)
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
def dissipation_many(a: Array, b: Array, motion: Array, speed: float, out: Array) -> None:
    """``dissipation`` of n contacts; a, b (n,); motion (n, 3): vx, vz, spin; out (n, 11) is written."""
    for i in range(a.shape[0]):
        out[i] = dissipation(a[i], b[i], motion[i, 0], motion[i, 1], motion[i, 2], speed)
