"""Self-adjusting chain of balls: axial load, random errors of balls and grooves, unilateral Hertz contacts.

Liu et al. (2025), section 2.2, as a minimum. Ball j = 1..M sits between nut and screw at spacing l (equal in the source);
u_j [m] is the axial motion of the nut against the screw there, counted from where an error-free ball just touches. The
load F acts on nut and screw at the end of ball 1, so that the segment behind ball j carries what the balls behind it
carry, in both bodies:

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

An ensemble: many chains of one design, drawn by number, solved in chunks; only a few quantities of each are stored.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from rollbench.lowfi.hertz import contact_approach
from rollbench.lowfi.jit import RANDOM_ERRORS, kernels
from rollbench.meshes.arrays import Array
from rollbench.meshes.numerics import brentq

Law = Literal["constant", "implicit", "exact"]

LAWS: tuple[Law, ...] = ("constant", "implicit", "exact")


@dataclass(frozen=True)
class Chain:
    """Balls in a row between screw and nut under axial load.

    Raises
    ------
    ValueError
        A number out of range.
    """

    #: Number of balls M.
    balls: int
    #: K of Q = K d^1.5, both contacts together [N/m^1.5].
    stiffness: float
    #: Compliance of screw and nut from a ball to the next, c [m/N].
    compliance: float
    #: Distance A of the groove centres [m].
    groove_distance: float
    #: Contact angle without load [rad].
    contact_angle: float
    #: [rad].
    lead_angle: float
    #: Interpretation of the equation of the contact angle.
    law: Law = "exact"
    #: Each distance to the next ball over their mean, to which c belongs ``(M - 1,)``; empty for equal ones.
    spacing: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Refuse numbers out of range."""
        if self.balls < 1 or self.stiffness <= 0.0 or self.compliance < 0.0 or self.groove_distance <= 0.0:
            raise ValueError("balls, stiffness and groove distance must be positive, the compliance not negative")
        if not 0.0 < self.contact_angle < 0.5 * np.pi or not 0.0 <= self.lead_angle < 0.5 * np.pi:
            raise ValueError("contact angle must lie in (0, 90) deg, lead angle in [0, 90) deg")
        if self.law not in LAWS:
            raise ValueError(f"law of the contact angle must be one of {', '.join(LAWS)}")
        if self.spacing and (len(self.spacing) != self.balls - 1 or min(self.spacing) < 0.0):
            raise ValueError(f"distances between balls must not be negative, and as many as gaps: {self.balls - 1}")

    @property
    def segments(self) -> Array:
        """Compliance of screw and nut from the ball before ``(M,)`` [m/N], zero for the first."""
        return self.compliance * np.array([0.0, *(self.spacing or (1.0,) * (self.balls - 1))])

    @property
    def parameters(self) -> Array:
        """Arguments of the kernels: K, A, sine and cosine of the free contact angle, cosine of the lead angle."""
        a = self.contact_angle
        return np.array([self.stiffness, self.groove_distance, np.sin(a), np.cos(a), np.cos(self.lead_angle)])

    @property
    def C(self) -> float:
        """Hertz constant of both contacts of a ball together [m/N^(2/3)]."""
        return float(self.stiffness ** (-2.0 / 3.0))

    @property
    def slope(self) -> float:
        """Approach of a ball over its axial motion at the free contact angle."""
        return float(np.sin(self.contact_angle) * np.cos(self.lead_angle))


@dataclass(frozen=True)
class ChainState:
    """Solution of one chain."""

    #: Contact loads Q ``(M,)`` [N].
    load: Array
    #: Axial motions u ``(M,)`` [m].
    motion: Array
    #: Motion at which the first ball touches [m].
    touch: float
    #: dF/du_1 [N/m].
    stiffness: float
    #: Newton steps.
    iterations: int
    #: Largest error of a ball's force over the load.
    residual: float
    #: Whether the residual is small.
    converged: bool

    @property
    def loaded(self) -> int:
        """Number of loaded balls."""
        return int(np.count_nonzero(self.load > 0.0))

    @property
    def displacement(self) -> float:
        """Axial motion at the loaded end since the first ball touched [m]."""
        return float(self.motion[0] - self.touch)

    @property
    def displacement_first_loaded(self) -> float:
        """Axial motion at the first loaded ball [m] (Liu's 19), which leaves out the segments before it."""
        return float(self.motion[int(np.argmax(self.load > 0.0))] - self.touch)


def check_errors(chain: Chain, errors: Array) -> Array:
    """Return errors ``(..., M)`` [m] as the kernels take them.

    Raises
    ------
    ValueError
        Another shape, or errors that reach A/2.
    """
    e = np.ascontiguousarray(errors, dtype=float)
    if e.shape[-1:] != (chain.balls,) or not np.all(np.isfinite(e)):
        raise ValueError(f"errors must be finite and as many as balls: {chain.balls}")
    if e.size and np.abs(e).max() >= 0.5 * chain.groove_distance:
        raise ValueError("errors must be small against the distance of the groove centres")
    return e


def solve_chain(chain: Chain, errors: Array, load: float, *, compiled: bool = False) -> ChainState:
    """Return the contact loads of a chain under an axial load.

    Valid for approaches small against the distance of the groove centres.

    Parameters
    ----------
    chain
        The chain.
    errors
        Excess of each ball along the contact normal ``(M,)`` [m].
    load
        F > 0 [N].
    compiled
        Whether to use compiled kernels.

    Raises
    ------
    ValueError
        A load that is not positive, or errors that do not fit.

    References
    ----------
    Liu et al. (2025), section 2.2.

    Examples
    --------
    Equal balls between rigid bodies share the load equally:

    >>> rigid = Chain(10, 1e10, 0.0, 0.5e-3, np.pi / 4, 0.08, "constant")
    >>> state = solve_chain(rigid, np.zeros(10), 1e3)
    >>> bool(np.allclose(state.load, 1e3 / (10 * rigid.slope)))
    True
    """
    if not 0.0 < load < np.inf:
        raise ValueError("the load must be positive")
    e, u, work = check_errors(chain, errors), np.empty(chain.balls), np.empty((3, chain.balls))
    k = kernels(RANDOM_ERRORS, compiled=compiled)
    law = LAWS.index(chain.law)
    steps, residual, stiffness = k.newton(e, float(load), chain.segments, law, chain.parameters, u, work)
    touch = float(free_motion(chain, e.max()))
    return ChainState(work[0], u, touch, float(stiffness), int(steps), float(residual), bool(residual <= k.TOLERANCE))


def end_ratio(chain: Chain, load: float) -> float:
    """Return the contact load of the last ball over that of the first under a load [N], without errors.

    Parameters
    ----------
    chain
        The chain of balls.
    load
        Total load [N].
    """
    q = solve_chain(chain, np.zeros(chain.balls), load).load
    return float(q[-1] / q[0])


def calibrate_compliance(chain: Chain, ratio: float, load: float) -> Chain:
    """Return the chain with the compliance for which `end_ratio` has a given value.

    Parameters
    ----------
    chain
        The chain.
    ratio
        Contact load of the last ball over that of the first, in (0, 1).
    load
        Axial load [N].

    Raises
    ------
    ValueError
        A ratio outside (0, 1), or a chain of one ball.
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
    """Return the load [N], up to ``high``, from which a ball carries; 0 where it touches first.

    Every motion grows with the load, so there is one.

    Parameters
    ----------
    chain, errors
        As for `solve_chain`.
    ball
        Number of the ball, from 0.
    high
        Largest load [N].

    Raises
    ------
    ValueError
        A ball that is still loose at ``high``.
    """
    e = check_errors(chain, errors)

    def gap(load: float) -> float:
        return float(solve_chain(chain, e, load).motion[ball]) - start

    start = float(free_motion(chain, e[ball]))
    if e[ball] == e.max():
        return 0.0
    if gap(high) < 0.0:
        raise ValueError("the ball is not loaded at the highest load")
    return float(brentq(gap, 1e-9 * high, high, rtol=1e-12))


def free_motion(chain: Chain, error: Array | float) -> Array:
    """Return the motion at which balls of given errors [m] just touch [m], of the shape of the errors."""
    e = np.asarray(error, dtype=float)
    if chain.law != "exact":
        return -e / chain.slope
    a, angle = chain.groove_distance, chain.contact_angle
    return np.asarray((np.sqrt((a - e) ** 2 - (a * np.cos(angle)) ** 2) - a * np.sin(angle)) / np.cos(chain.lead_angle))


#: What is kept of each chain: smallest and largest contact load [N], loaded balls, motion since the first touch of ball 1
#: and of the first loaded ball (Liu's 19) [m], stiffness dF/du_1 [N/m].
Quantity = Literal["smallest", "largest", "loaded", "displacement", "displacement_first_loaded", "stiffness"]

QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)

#: Chains solved at a time: 5 MB of errors for 78 balls.
CHUNK = 8192


@dataclass(frozen=True)
class Ensemble:
    """Quantities of n solved chains under L loads."""

    #: The loads ``(L,)`` [N].
    loads: Array
    #: The quantities ``(n, L, 6)``, last axis as ``QUANTITIES``.
    kept: Array
    #: Largest residual over the load.
    residual: float
    #: Number of chains that did not converge under some load.
    failed: int

    def values_at(self, quantity: Quantity, load: float) -> Array:
        """Return one quantity of every chain at a load [N], ``(n,)``; raises KeyError for a load that was not solved."""
        at = np.flatnonzero(self.loads == load)
        if at.size != 1:
            raise KeyError(f"no load of {load} N in this ensemble")
        return np.asarray(self.kept[:, at[0], QUANTITIES.index(quantity)])


def draw_errors(seed: int, first: int, count: int, balls: int, half_range: float) -> Array:
    """Return errors ``(count, balls)`` [m] of some chains, uniform and independent within the half range.

    Chain i has the numbers i M to (i + 1) M - 1 of the stream of ``seed``, so a chain does not depend on how many are
    drawn.

    Parameters
    ----------
    seed
        Of the random numbers.
    first, count
        Number of the first chain, and of chains.
    balls
        Number of balls M of a chain.
    half_range
        Largest size of an error [m].

    References
    ----------
    Liu et al. (2025), 2.1: e - 2 e rand(1, 78), with his plus sign corrected, which would leave the band.
    """
    stream = np.random.PCG64(seed)
    stream.advance(first * balls)
    return half_range * (1.0 - 2.0 * np.random.Generator(stream).random((count, balls)))


def solve_errors(chain: Chain, errors: Array, loads: Array) -> tuple[Array, Array]:
    """Return quantities ``(n, L, 6)`` and residuals ``(n, L)`` of chains with errors ``(n, M)`` [m] at loads ``(L,)`` [N].

    Raises
    ------
    ValueError
        A load that is not positive, or errors that do not fit.
    """
    f = np.ascontiguousarray(loads, dtype=float)
    if f.ndim != 1 or f.size == 0 or not np.all((f > 0.0) & np.isfinite(f)):
        raise ValueError("loads must be positive")
    e = check_errors(chain, errors)
    out = np.empty((len(e), f.size, len(QUANTITIES) + 1))
    k = kernels(RANDOM_ERRORS, compiled=True)
    k.batch(e, f, chain.segments, LAWS.index(chain.law), chain.parameters, out)
    at = QUANTITIES.index("displacement")
    out[..., at : at + 2] -= np.asarray(free_motion(chain, e.max(axis=1)))[:, None, None]
    return out[..., :-1], out[..., -1]


def solve_ensemble(
    chain: Chain, half_range: float, loads: Array | list[float], members: int, *, seed: int = 0, chunk: int = CHUNK
) -> Ensemble:
    """Return quantities of many chains with random errors.

    Memory: one chunk of errors, and six numbers a chain and load.

    Parameters
    ----------
    chain
        The chain.
    half_range
        Largest size of an error [m].
    loads
        ``(L,)`` [N].
    members
        Number of chains.
    seed
        Of the random numbers.
    chunk
        Number of chains solved at a time; the result does not depend on it.

    Raises
    ------
    ValueError
        Numbers of members or of a chunk that are not positive, or errors as in `solve_errors`.
    """
    if members < 1 or chunk < 1 or half_range < 0.0:
        raise ValueError("members and chunk must be positive, the range of errors not negative")
    f = np.asarray(loads, dtype=float)
    kept, worst, failed = np.empty((members, f.size, len(QUANTITIES))), 0.0, 0
    tolerance = kernels(RANDOM_ERRORS, compiled=False).TOLERANCE
    for first in range(0, members, chunk):
        count = min(chunk, members - first)
        errors = draw_errors(seed, first, count, chain.balls, half_range)
        kept[first : first + count], residual = solve_errors(chain, errors, f)
        worst = max(worst, float(residual.max()))
        failed += int(np.count_nonzero((residual > tolerance).any(axis=1)))
    return Ensemble(f, kept, worst, failed)


@dataclass(frozen=True)
class PercentileRank:
    """Rank of a number in a sample."""

    #: Share of the sample below it, and the standard error of the share.
    below: float
    #: Share of the sample at or below it, likewise; they differ where values repeat.
    at_most: float
    #: Size of the sample.
    size: int

    @property
    def middle(self) -> float:
        """Percentile [%], a repeated value counted half."""
        return 50.0 * (self.below + self.at_most)

    @property
    def error(self) -> float:
        """Standard error [%]; by the rule of succession, so that none is zero."""
        p = (0.01 * self.middle * self.size + 1.0) / (self.size + 2.0)
        return float(100.0 * np.sqrt(p * (1.0 - p) / self.size))

    @property
    def tail(self) -> float:
        """One-sided tail probability: chance of a value at least this extreme, on the nearer side."""
        return min(self.at_most, 1.0 - self.below)

    @property
    def tail_bound(self) -> float:
        """Upper 95 % bound of ``tail`` (Wilson; 2.7/size where no value reaches it)."""
        z, n, p = 1.645, self.size, self.tail
        return float((p + z * z / (2 * n) + z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))) / (1 + z * z / n))


def percentile_rank(sample: Array, value: float, width: float = 0.0) -> PercentileRank:
    """Return the rank of a number in a sample.

    Parameters
    ----------
    sample
        ``(n,)``.
    value
        The number, in the sample's unit.
    width
        Half of what rounding hides of it, counted as equal.
    """
    return PercentileRank(float(np.mean(sample < value - width)), float(np.mean(sample <= value + width)), sample.size)
