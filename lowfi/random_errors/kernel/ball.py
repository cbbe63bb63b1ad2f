"""Force of one ball over the axial motion of its groove, by three readings of the contact angle."""

from __future__ import annotations

from math import sqrt
from typing import Any

from numpy.typing import NDArray

from rollbench.lowfi.jit import kernel

#: Array of floats.
Array = NDArray[Any]
#: Readings of the contact angle: constant; by Liu's implicit equation (10); by the geometry of the groove centres.
CONSTANT, IMPLICIT, EXACT = 0, 1, 2


@kernel
def _implicit(v: float, error: float, p: Array) -> tuple[float, float, float]:
    """Approach, sine of the contact angle, d(approach)/dv of (10) and (14): approach = error + v sin(angle(approach))."""
    a = p[1] - error
    approach = error + v * p[2]
    sine, rate = p[2], 0.0
    for _ in range(8):
        grown = a + approach
        cosine = a * p[3] / grown
        sine = sqrt(1.0 - cosine * cosine)
        rate = cosine * cosine / (sine * grown)
        step = (approach - error - v * sine) / (1.0 - v * rate)
        approach -= step
        if abs(step) <= 1e-15 * p[1]:
            break
    return approach, sine, sine / (1.0 - v * rate)


@kernel
def _exact(v: float, error: float, p: Array) -> tuple[float, float, float]:
    """The same from the distance of the groove centres, whose offset across the axis no ball changes."""
    along, across = p[1] * p[2] + v, p[1] * p[3]
    distance = sqrt(along * along + across * across)
    sine = along / distance
    # distance - A without cancellation
    grown = v * (2.0 * p[1] * p[2] + v) / (distance + p[1])
    return grown + error, sine, sine


@kernel
def ball(u: float, error: float, law: int, p: Array) -> tuple[float, float, float]:
    """Contact load [N], axial force [N] and its slope [N/m] of a ball at the axial motion u [m] of its groove.

    error [m]: what the ball is too large; law: reading of the contact angle; p: Hertz stiffness [N/m^1.5], distance A of
    the groove centres [m], sine and cosine of the free contact angle, cosine of the lead angle.
    """
    v = u * p[4]
    approach, sine, slope = error + v * p[2], p[2], p[2]
    if law == EXACT:
        approach, sine, slope = _exact(v, error, p)
    elif law == IMPLICIT and approach > 0.0:
        # in (10) the approach has the sign of that at a constant angle
        approach, sine, slope = _implicit(v, error, p)
    if approach <= 0.0:
        return 0.0, 0.0, 0.0
    # d(sine)/dv, the groove centres being A - error + approach apart
    turn = (1.0 - sine * sine) * slope / (sine * (p[1] - error + approach)) if law != CONSTANT else 0.0
    root = sqrt(approach)
    load = p[0] * approach * root
    return load, load * sine * p[4], (1.5 * p[0] * root * slope * sine + load * turn) * p[4] * p[4]
