"""Self-adjusting chain of balls: axial load, random errors of balls and grooves, unilateral Hertz contacts.

Liu et al. (2025), section 2.2, as a minimum. Ball j = 1..M sits between nut and screw at equal spacing l; u_j [m] is the
axial motion of the nut against the screw there, counted from where an error-free ball just touches. The load F acts on nut
and screw at the end of ball 1, so that the segment behind ball j carries what the balls behind it carry, in both bodies:

    T_j = sum of f_i(u_i) over i >= j,    T_1 = F,    u_j - u_(j+1) = c T_(j+1),    c = l (1/(E A_n) + 1/(E A_s)),

f_j(u) the axial force of ball j, zero where its approach d_j is not positive. These are the optimality conditions of

    min over u of  sum_j W_j(u_j) + sum_j (u_j - u_(j+1))^2 / (2 c) - F u_1,    W_j' = f_j:

convex, because every f_j grows. With contact load Q_j >= 0 and gap g_j = max(-d_j, 0) it is a complementarity problem
Q_j g_j = 0, so no ball need be sorted out beforehand. Only neighbours couple: the Hessian is tridiagonal. Newton's step is
solved in its mixed form, by the law T_j = s_j u_j + t_j of the balls from j on:

    s_j = f_j' + s_(j+1) / (1 + c s_(j+1)),    t_j = f_j - f_j' u_j + t_(j+1) / (1 + c s_(j+1)),

springs in series and parallel, which divides by no compliance (c = 0: rigid bodies) and leaves the stiffness s_1 = dF/du_1.

No line search is needed. The Hessian is an M-matrix and f_j is convex (approaches being small against A), so from the
second iterate on every one satisfies H(u) >= F with H(u) the left-hand side, lies above the solution in every component,
and the next lies below it: Newton's method falls monotonically to the minimum.

Contact angle, A the distance of the groove centres with an error-free ball just touching, v = u cos(lead angle):
constant: d = e + v sin a_0. implicit (Liu's 10 and 14): cos a = (A - e) cos a_0 / (A - e + d), d = e + v sin a.
exact: the centres move along the axis only, d = e - A + sqrt((A sin a_0 + v)^2 + (A cos a_0)^2); (10) scales the offset
across the axis by (A - e)/A too, and takes the secant of the motion for its tangent. In all: axial force Q sin a cos(lead).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from rollbench.lowfi.hertz import contact_approach, contact_modulus, hertz_constants
from rollbench.lowfi.jit import RANDOM_ERRORS, kernels
from rollbench.meshes.arrays import Array
from rollbench.meshes.roots import brentq

Law = Literal["constant", "implicit", "exact"]
LAWS: tuple[Law, ...] = ("constant", "implicit", "exact")


@dataclass(frozen=True)
class Chain:
    """Balls in a row between screw and nut.

    balls: M; stiffness: K [N/m^1.5] of Q = K d^1.5, both contacts; compliance: c [m/N] of screw and nut from a ball to the
    next; groove_distance: A [m]; contact_angle, lead_angle [rad]; law: reading of the contact angle.
    Raises ValueError where a number is out of range.
    """

    balls: int
    stiffness: float
    compliance: float
    groove_distance: float
    contact_angle: float
    lead_angle: float
    law: Law = "exact"

    def __post_init__(self) -> None:
        """Refuse what is no chain."""
        if self.balls < 1 or self.stiffness <= 0.0 or self.compliance < 0.0 or self.groove_distance <= 0.0:
            raise ValueError("balls, stiffness and groove distance must be positive, the compliance not negative")
        if not 0.0 < self.contact_angle < 0.5 * np.pi or not 0.0 <= self.lead_angle < 0.5 * np.pi:
            raise ValueError("contact angle must lie in (0, 90) deg, lead angle in [0, 90) deg")
        if self.law not in LAWS:
            raise ValueError(f"law of the contact angle must be one of {', '.join(LAWS)}")

    @property
    def parameters(self) -> Array:
        """Arguments of the kernels: K, A, sine and cosine of the free contact angle, cosine of the lead angle."""
        a = self.contact_angle
        return np.array([self.stiffness, self.groove_distance, np.sin(a), np.cos(a), np.cos(self.lead_angle)])

    @property
    def C(self) -> float:
        """Constant of both contacts of a ball as one [m/N^(2/3)]."""
        return float(self.stiffness ** (-2.0 / 3.0))

    @property
    def slope(self) -> float:
        """Approach of a ball over its axial motion at the free contact angle."""
        return float(np.sin(self.contact_angle) * np.cos(self.lead_angle))


@dataclass(frozen=True)
class ChainState:
    """Solution of one chain.

    load: contact loads Q (M,) [N]; motion: u (M,) [m]; touch: motion at which the first ball touches [m]; stiffness:
    dF/du_1 [N/m]; iterations; residual: largest error of a ball's force over the load; converged: whether that is small.
    """

    load: Array
    motion: Array
    touch: float
    stiffness: float
    iterations: int
    residual: float
    converged: bool

    @property
    def loaded(self) -> int:
        """Number of loaded balls."""
        return int(np.count_nonzero(self.load > 0.0))

    @property
    def displacement(self) -> float:
        """Axial motion [m] at the loaded end since the first ball touched."""
        return float(self.motion[0] - self.touch)

    @property
    def displacement_first_loaded(self) -> float:
        """The same at the first loaded ball (Liu's 19), which leaves out the segments before it."""
        return float(self.motion[int(np.argmax(self.load > 0.0))] - self.touch)


def checked(chain: Chain, errors: Array) -> Array:
    """Errors (..., M) [m] as the kernels take them. Raises ValueError for another shape, or errors that reach A / 2."""
    e = np.ascontiguousarray(errors, dtype=float)
    if e.shape[-1:] != (chain.balls,) or not np.all(np.isfinite(e)):
        raise ValueError(f"errors must be finite and as many as balls: {chain.balls}")
    if e.size and np.abs(e).max() >= 0.5 * chain.groove_distance:
        raise ValueError("errors must be small against the distance of the groove centres")
    return e


def solve_chain(chain: Chain, errors: Array, load: float, *, compiled: bool = False) -> ChainState:
    """Contact loads of a chain with errors (M,) [m], what each ball is too large, under a load F > 0 [N].

    Raises ValueError for a load that is not positive, or errors that do not fit. Valid for approaches small against A.
    """
    if not 0.0 < load < np.inf:
        raise ValueError("the load must be positive")
    e, u, work = checked(chain, errors), np.empty(chain.balls), np.empty((3, chain.balls))
    k = kernels(RANDOM_ERRORS, compiled=compiled)
    law = LAWS.index(chain.law)
    steps, residual, stiffness = k.newton(e, float(load), chain.compliance, law, chain.parameters, u, work)
    touch = float(free_motion(chain, e.max()))
    return ChainState(work[0], u, touch, float(stiffness), int(steps), float(residual), bool(residual <= k.TOLERANCE))


def ball_stiffness(
    ball_diameter: float, pitch_radius: float, groove_radius: float, contact_angle: float, young: float, poisson: float
) -> float:
    """K [N/m^1.5] of a ball between the grooves of screw and nut: exact Hertz contact, lengths [m] (Liu's 16).

    Along the track the screw's surface has the radius R_p/cos a - r, the nut's R_p/cos a + r (r of the ball); the helix
    angle is left out (a factor cos^2 on these small curvatures). One material. Raises ValueError where grooves do not fit.
    """
    r, cosine = 0.5 * ball_diameter, np.cos(contact_angle)
    across = 1.0 / r - 1.0 / groove_radius
    along = 1.0 / r + np.array([1.0, -1.0]) * cosine / (pitch_radius + np.array([-1.0, 1.0]) * r * cosine)
    c = hertz_constants(np.full(2, across), along, contact_modulus(young, poisson, young, poisson)).C
    return float(c.sum() ** -1.5)


def end_ratio(chain: Chain, load: float) -> float:
    """Contact load of the last ball over that of the first, no errors, under a load [N]."""
    q = solve_chain(chain, np.zeros(chain.balls), load).load
    return float(q[-1] / q[0])


def calibrated(chain: Chain, ratio: float, load: float) -> Chain:
    """The chain with the compliance that makes ``end_ratio`` at the load [N] the given one.

    Raises ValueError for a ratio outside (0, 1) and a chain of one ball.
    """
    if not 0.0 < ratio < 1.0 or chain.balls < 2:
        raise ValueError("the ratio must lie in (0, 1), and a chain needs two balls")
    # stretch of the whole chain against the approach of a ball, both under equal shares
    share = load / (chain.balls * chain.slope)
    size = 2.0 * float(contact_approach(share, chain.C)) / (chain.slope * load * chain.balls)
    high = size
    while end_ratio(replace(chain, compliance=high), load) > ratio:
        high *= 4.0

    def excess(scaled: float) -> float:
        return end_ratio(replace(chain, compliance=scaled * size), load) - ratio

    return replace(chain, compliance=float(brentq(excess, 0.0, high / size, xtol=1e-13)) * size)


def first_carrying_load(chain: Chain, errors: Array, ball: int, high: float) -> float:
    """Load [N], up to ``high``, from which ball ``ball`` (0-based) carries; 0 where it touches first.

    Every motion grows with the load, so there is one. Raises ValueError where the ball is loose still at ``high``.
    """
    e = checked(chain, errors)

    def gap(load: float) -> float:
        return float(solve_chain(chain, e, load).motion[ball]) - start

    start = float(free_motion(chain, e[ball]))
    if e[ball] == e.max():
        return 0.0
    if gap(high) < 0.0:
        raise ValueError("the ball is not loaded at the highest load")
    return float(brentq(gap, 1e-9 * high, high, rtol=1e-12))


def free_motion(chain: Chain, error: Array | float) -> Array:
    """Motion [m] at which balls of errors [m] just touch, shape of the errors."""
    e = np.asarray(error, dtype=float)
    if chain.law != "exact":
        return -e / chain.slope
    a, angle = chain.groove_distance, chain.contact_angle
    return np.asarray((np.sqrt((a - e) ** 2 - (a * np.cos(angle)) ** 2) - a * np.sin(angle)) / np.cos(chain.lead_angle))
