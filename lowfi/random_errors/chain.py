"""Axial load distribution in a ball screw whose balls and grooves have random errors, with unilateral Hertz contacts.

The model is that of Liu et al. (2025), section 2.2, written as a minimum of energy. Ball j = 1..M lies between nut and
screw at the spacing l (equal in the paper). u_j [m] is the axial motion of the nut relative to the screw at ball j, zero
where a ball without error just touches its grooves. The load F acts on nut and screw at the end of ball 1. In both bodies
the segment between ball j and ball j + 1 therefore carries the sum T_(j+1) of the forces of the balls beyond it:

    T_j = sum of f_i(u_i) over i >= j,    T_1 = F,    u_j - u_(j+1) = c T_(j+1),    c = l (1/(E A_n) + 1/(E A_s)),

with the axial force f_j(u) of ball j, zero unless its approach d_j is positive. These are the optimality conditions of

    min over u of  sum_j W_j(u_j) + sum_j (u_j - u_(j+1))^2 / (2 c) - F u_1,    W_j' = f_j,

which is convex, because every f_j increases. With contact load Q_j >= 0 and gap g_j = max(-d_j, 0) it is a complementarity
problem Q_j g_j = 0, so it need not be known beforehand which balls are loaded. Only neighbours are coupled, so the Hessian
is tridiagonal. Newton's step uses the linear law T_j = s_j u_j + t_j of the balls from j on:

    s_j = f_j' + s_(j+1) / (1 + c s_(j+1)),    t_j = f_j - f_j' u_j + t_(j+1) / (1 + c s_(j+1)).

These are springs in series and parallel. The recursion never divides by a compliance (c = 0 is a rigid body), and it gives
the stiffness s_1 = dF/du_1.

No line search is needed. The Hessian is an M-matrix and f_j is convex (approaches are small against A). Hence from the
second iterate on, all iterates satisfy H(u) >= F, with H(u) the gradient of the energy's two sums; they lie above the
solution in every component, and each lies below the one before it. Newton's method decreases monotonically to the minimum.

Contact angle a, with the distance A of the groove centres when an error-free ball just touches, the ball's error e, and
v = u cos(lead angle):
constant: d = e + v sin a_0. implicit (Liu's 10 and 14): cos a = (A - e) cos a_0 / (A - e + d), d = e + v sin a.
exact: the centres move along the axis only, d = e - A + sqrt((A sin a_0 + v)^2 + (A cos a_0)^2). Liu's (10) differs from
this: it also scales the offset across the axis by (A - e)/A, and takes the secant of the motion for its tangent. In all
three the axial force is Q sin a cos(lead).

In an ensemble many screws of one design with numbered random errors are solved in chunks; only a few quantities of each
screw are stored.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from rollbench.lowfi.hertz import contact_approach
from rollbench.lowfi.jit import RANDOM_ERRORS, load_kernel_package
from rollbench.meshes.arrays import Array
from rollbench.meshes.numerics import brentq

Law = Literal["constant", "implicit", "exact"]

LAWS: tuple[Law, ...] = ("constant", "implicit", "exact")


@dataclass(frozen=True)
class BallScrewChain:
    """Model of a ball screw under axial load: balls in a row, with segments of screw and nut as springs between them.

    Raises
    ------
    ValueError
        A value is out of range.
    """

    #: Number of balls M.
    balls: int
    #: Constant K of the contact load Q = K d^1.5, with the approach d of both contacts of a ball together [N/m^1.5].
    stiffness: float
    #: Compliance c of a segment of screw and nut together, as long as the mean distance of neighbouring balls [m/N].
    compliance: float
    #: Distance A of the groove centres of screw and nut at which a ball without error just touches both grooves [m].
    groove_distance: float
    #: Contact angle without load [rad].
    contact_angle: float
    #: Lead angle [rad].
    lead_angle: float
    #: How the contact angle changes under load, one of ``LAWS``: "constant" (not at all), "implicit" (by Liu's equations 10
    #: and 14), "exact" (by the geometry of the groove centres).
    law: Law = "exact"
    #: Distances between neighbouring balls as ratios to their mean ``(M - 1,)``; the compliance c is that of the mean
    #: distance. Empty for equal distances.
    spacing: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Check that the values are in range; raise ValueError otherwise."""
        if self.balls < 1 or self.stiffness <= 0.0 or self.compliance < 0.0 or self.groove_distance <= 0.0:
            raise ValueError(
                "balls, stiffness and groove distance must be positive, the compliance must not be negative, "
                f"got balls {self.balls}, stiffness {self.stiffness} N/m^1.5, groove_distance {self.groove_distance} m, "
                f"compliance {self.compliance} m/N"
            )
        if not 0.0 < self.contact_angle < 0.5 * np.pi or not 0.0 <= self.lead_angle < 0.5 * np.pi:
            raise ValueError(
                "contact angle must lie in (0, 90) deg, lead angle in [0, 90) deg, "
                f"got {np.degrees(self.contact_angle):g} and {np.degrees(self.lead_angle):g} deg"
            )
        if self.law not in LAWS:
            raise ValueError(
                f"`law`, the change of the contact angle under load, must be one of {', '.join(LAWS)}, got {self.law}"
            )
        if self.spacing and (len(self.spacing) != self.balls - 1 or min(self.spacing) < 0.0):
            given = f"{len(self.spacing)} distances, the least {min(self.spacing):g}"
            raise ValueError(f"`spacing`: got {given}; allowed: {self.balls - 1} distances between balls, none negative")

    @property
    def segment_compliances(self) -> Array:
        """Compliance of screw and nut between each ball and the preceding one ``(M,)`` [m/N]; zero for the first ball."""
        return self.compliance * np.array([0.0, *(self.spacing or (1.0,) * (self.balls - 1))])

    @property
    def kernel_parameters(self) -> tuple[Array, int, Array]:
        """Arguments of the numerical kernels: segment compliances, number of the contact-angle law, and five constants.

        The constants are, in order, the stiffness K of a ball [N/m^1.5], the distance A of the groove centres [m], sine and
        cosine of the contact angle without load, and the cosine of the lead angle.
        """
        a = self.contact_angle
        constants = np.array([self.stiffness, self.groove_distance, np.sin(a), np.cos(a), np.cos(self.lead_angle)])
        return self.segment_compliances, LAWS.index(self.law), constants

    @property
    def C(self) -> float:
        """Hertz constant C of the approach C Q^(2/3) of both contacts of a ball together [m/N^(2/3)]."""
        return float(self.stiffness ** (-2.0 / 3.0))

    @property
    def approach_per_motion(self) -> float:
        """Ratio of a ball's approach to the axial motion of the nut at small load, sin(a_0) cos(lead angle).

        a_0 is the contact angle without load.
        """
        return float(np.sin(self.contact_angle) * np.cos(self.lead_angle))


@dataclass(frozen=True)
class BallScrewState:
    """Contact loads, motions and stiffness of one ball screw with random errors under one axial load."""

    #: Contact loads Q of the M balls ``(M,)`` [N].
    load: Array
    #: Axial motion of the nut relative to the screw at each of the M balls ``(M,)`` [m]; it differs along the nut because
    #: both bodies are stretched.
    motion: Array
    #: Axial motion of the nut at which the ball with the largest error comes into contact first [m].
    first_contact_motion: float
    #: Axial stiffness dF/du_1, the derivative of the axial load F by the motion u_1 at ball 1, where the load acts [N/m].
    stiffness: float
    #: Number of Newton steps.
    iterations: int
    #: Largest unbalanced axial force on a ball at the end of the iteration, as a fraction of the axial load.
    residual: float
    #: Whether the ``residual`` is below the tolerance of Newton's method.
    converged: bool

    @property
    def loaded_balls(self) -> int:
        """Number of balls that carry load."""
        return int(np.count_nonzero(self.load > 0.0))

    @property
    def displacement(self) -> float:
        """Axial motion of the nut at ball 1, where the load acts, since the first contact of any ball [m]."""
        return float(self.motion[0] - self.first_contact_motion)

    @property
    def displacement_first_loaded(self) -> float:
        """Axial motion of the nut at the first loaded ball, since the first contact of any ball [m] (Liu's equation 19).

        It does not contain the stretch of screw and nut before this ball.
        """
        return float(self.motion[int(np.argmax(self.load > 0.0))] - self.first_contact_motion)


def checked_ball_errors(chain: BallScrewChain, errors: Array) -> Array:
    """Check number and size of the errors of M balls ``(..., M)`` [m], and return them as a contiguous array of floats.

    Raises
    ------
    ValueError
        The last axis is not as long as the number of balls, or an error reaches half the distance of the groove centres.
    """
    e = np.ascontiguousarray(errors, dtype=float)
    if e.shape[-1:] != (chain.balls,) or not np.all(np.isfinite(e)):
        raise ValueError(
            f"{chain.balls} finite errors (oversizes) are needed, one for each ball, got an array of shape {e.shape}"
        )
    if e.size and np.abs(e).max() >= 0.5 * chain.groove_distance:
        raise ValueError(
            "the error of a ball (interference with both grooves together, along the contact normal) must be below half "
            f"the distance of the groove centres, {0.5 * chain.groove_distance:g} m, got up to {np.abs(e).max():g} m"
        )
    return e


def solve_ball_screw(chain: BallScrewChain, errors: Array, load: float, *, compiled: bool = False) -> BallScrewState:
    """Return contact loads, motions and stiffness of a ball screw with errors under an axial load.

    The results are valid for approaches that are small against the distance of the groove centres.

    Parameters
    ----------
    chain
        Ball screw as a sequence of balls.
    errors
        Oversize of each ball in its grooves along the contact normal, negative for clearance ``(M,)`` [m].
    load
        Axial load F > 0 on nut and screw at the end of ball 1 [N].
    compiled
        Whether to use the compiled functions instead of plain Python.

    Raises
    ------
    ValueError
        The load is not positive, or the errors have the wrong number or size.

    References
    ----------
    Liu et al. (2025), section 2.2.

    Examples
    --------
    Equal balls between rigid bodies carry equal loads:

    >>> rigid = BallScrewChain(10, 1e10, 0.0, 0.5e-3, np.pi / 4, 0.08, "constant")
    >>> state = solve_ball_screw(rigid, np.zeros(10), 1e3)
    >>> bool(np.allclose(state.load, 1e3 / (10 * rigid.approach_per_motion)))
    True
    """
    if not 0.0 < load < np.inf:
        raise ValueError(f"the axial load on the ball screw must be positive and finite, got {load} N")
    e, u, work = checked_ball_errors(chain, errors), np.empty(chain.balls), np.empty((3, chain.balls))
    k = load_kernel_package(RANDOM_ERRORS, compiled=compiled)
    steps, residual, stiffness = k.solve_by_newton(e, float(load), *chain.kernel_parameters, u, work)
    touch = float(axial_motion_at_touch(chain, e.max()))
    return BallScrewState(work[0], u, touch, float(stiffness), int(steps), float(residual), bool(residual <= k.TOLERANCE))


def last_to_first_load_ratio(chain: BallScrewChain, load: float) -> float:
    """Return the contact load of the last ball over that of the first, where the axial load acts, for balls without errors.

    Parameters
    ----------
    chain
        Ball screw as a sequence of balls.
    load
        Axial load [N].
    """
    q = solve_ball_screw(chain, np.zeros(chain.balls), load).load
    return float(q[-1] / q[0])


def calibrate_compliance(chain: BallScrewChain, ratio: float, load: float) -> BallScrewChain:
    """Return the ball screw with the compliance of screw and nut that gives a required `last_to_first_load_ratio`.

    Parameters
    ----------
    chain
        Ball screw as a sequence of balls, whose compliance is replaced.
    ratio
        Required ratio of the contact load of the last ball to that of the first, in (0, 1).
    load
        Axial load [N].

    Raises
    ------
    ValueError
        The ratio is outside (0, 1), or there is only one ball.
    """
    if not 0.0 < ratio < 1.0 or chain.balls < 2:
        raise ValueError(
            f"the ratio of the last ball's load to the first one's must lie in (0, 1), got {ratio}; at least two balls are "
            f"needed, got {chain.balls}"
        )
    # scale: compliance at which the bodies stretch as much as a ball approaches, if all balls carry the same load
    share = load / (chain.balls * chain.approach_per_motion)
    size = 2.0 * float(contact_approach(share, chain.C)) / (chain.approach_per_motion * load * chain.balls)
    high = size
    while last_to_first_load_ratio(replace(chain, compliance=high), load) > ratio:
        high *= 4.0

    def load_ratio_above_required(scaled: float) -> float:
        """Return the load ratio of last to first ball less the required one; ``scaled``: compliance over a typical one."""
        return last_to_first_load_ratio(replace(chain, compliance=scaled * size), load) - ratio

    return replace(chain, compliance=float(brentq(load_ratio_above_required, 0.0, high / size, xtol=1e-13)) * size)


def load_at_which_ball_is_loaded(chain: BallScrewChain, errors: Array, ball: int, largest_load: float) -> float:
    """Return the axial load on a ball screw above which a given ball carries load [N]; 0 for the ball that touches first.

    There is only one such load, because the axial motion at each ball increases with the axial load.

    Parameters
    ----------
    chain, errors
        Ball screw and errors of its balls [m], as for `solve_ball_screw`.
    ball
        Number of the ball, from 0.
    largest_load
        Largest axial load of the search [N].

    Raises
    ------
    ValueError
        The ball still carries no load at the axial load ``largest_load``.
    """
    e = checked_ball_errors(chain, errors)

    def motion_beyond_touch(load: float) -> float:
        """Return the axial motion at the ball under an axial load [N], less the motion at which it touches [m]."""
        return float(solve_ball_screw(chain, e, load).motion[ball]) - start

    start = float(axial_motion_at_touch(chain, e[ball]))
    if e[ball] == e.max():
        return 0.0
    if motion_beyond_touch(largest_load) < 0.0:
        raise ValueError(f"ball {ball} is not loaded at the largest axial load of the search, {largest_load:g} N")
    return float(brentq(motion_beyond_touch, 1e-9 * largest_load, largest_load, rtol=1e-12))


def axial_motion_at_touch(chain: BallScrewChain, error: Array | float) -> Array:
    """Return the axial motion of the nut [m] at which each of several balls with errors just touches its grooves.

    ``error``: oversize of each ball along the contact normal [m], an array of any shape, which is also that of the result.
    The motion is zero for an error-free ball.
    """
    e = np.asarray(error, dtype=float)
    if chain.law != "exact":
        return -e / chain.approach_per_motion
    a, angle = chain.groove_distance, chain.contact_angle
    return np.asarray((np.sqrt((a - e) ** 2 - (a * np.cos(angle)) ** 2) - a * np.sin(angle)) / np.cos(chain.lead_angle))


#: Quantities that are stored for each screw of an ensemble: smallest and largest contact load [N], number of loaded balls,
#: axial motion since the first contact at ball 1 and at the first loaded ball (Liu's equation 19) [m], stiffness dF/du_1
#: [N/m].
Quantity = Literal["smallest", "largest", "loaded", "displacement", "displacement_first_loaded", "stiffness"]

QUANTITIES: tuple[Quantity, ...] = get_args(Quantity)

#: Number of screws solved at a time; their errors take 5 MB for 78 balls.
CHUNK = 8192


@dataclass(frozen=True)
class ScrewEnsemble:
    """Results of n ball screws of one design with random ball errors, each solved under L axial loads."""

    #: The L axial loads under which each screw is solved ``(L,)`` [N].
    loads: Array
    #: Results of each screw under each load ``(n, L, 6)``; the last axis holds smallest and largest contact load [N],
    #: number of loaded balls, axial motion at ball 1 and at the first loaded ball [m], and stiffness [N/m].
    kept: Array
    #: Largest unbalanced axial force on a ball, as a fraction of the axial load: maximum over all screws and loads.
    residual: float
    #: Number of screws for which Newton's method did not converge under at least one of the loads.
    failed: int

    def values_at(self, quantity: Quantity, load: float) -> Array:
        """Return one quantity of all n screws under one of the axial loads ``(n,)``, in the unit that `Quantity` states.

        Raises KeyError if the ensemble was not solved under this load.
        """
        at = np.flatnonzero(self.loads == load)
        if at.size != 1:
            raise KeyError(f"the ensemble of ball screws was not solved at an axial load of {load} N")
        return np.asarray(self.kept[:, at[0], QUANTITIES.index(quantity)])


def draw_uniform_errors(seed: int, first: int, count: int, balls: int, half_range: float) -> Array:
    """Return independent, uniformly distributed random errors ``(count, balls)`` [m] of the balls of several screws.

    Screw i uses the random numbers i M to (i + 1) M - 1 of the stream that ``seed`` starts, so that its errors do not
    depend on the number of screws.

    Parameters
    ----------
    seed
        Seed of the random numbers.
    first, count
        Number of the first screw, from 0, and number of screws.
    balls
        Number of balls M of a screw.
    half_range
        Largest absolute value of an error [m]; the errors lie between -half_range and +half_range.

    References
    ----------
    Liu et al. (2025), 2.1: e - 2 e rand(1, 78). The printed plus sign, which would exceed the range, is corrected.
    """
    stream = np.random.PCG64(seed)
    stream.advance(first * balls)
    return half_range * (1.0 - 2.0 * np.random.Generator(stream).random((count, balls)))


def solve_screws_with_errors(chain: BallScrewChain, errors: Array, loads: Array) -> tuple[Array, Array]:
    """Solve n ball screws with errors of their M balls under L axial loads each, by compiled functions.

    ``chain``: ball screw without errors; ``errors``: oversize of each ball ``(n, M)`` [m]; ``loads``: axial loads ``(L,)``
    [N].

    Returns
    -------
    tuple[Array, Array]
        Smallest and largest contact load, number of loaded balls, axial motion at ball 1 and at the first loaded ball, and
        stiffness ``(n, L, 6)``; and the residual of the equations: the largest unbalanced axial force on a ball, as a
        fraction of the load ``(n, L)``.

    Raises
    ------
    ValueError
        A load is not positive, or the errors have the wrong number or size.
    """
    f = np.ascontiguousarray(loads, dtype=float)
    if f.ndim != 1 or f.size == 0 or not np.all((f > 0.0) & np.isfinite(f)):
        raise ValueError(f"all axial loads on the ball screws must be positive and finite, got {f.tolist()} N")
    e = checked_ball_errors(chain, errors)
    out = np.empty((len(e), f.size, len(QUANTITIES) + 1))
    k = load_kernel_package(RANDOM_ERRORS, compiled=True)
    k.solve_batch(e, f, *chain.kernel_parameters, out)
    at = QUANTITIES.index("displacement")
    out[..., at : at + 2] -= np.asarray(axial_motion_at_touch(chain, e.max(axis=1)))[:, None, None]
    return out[..., :-1], out[..., -1]


def solve_ensemble(
    chain: BallScrewChain,
    half_range: float,
    loads: Array | list[float],
    screw_count: int,
    *,
    seed: int = 0,
    chunk: int = CHUNK,
) -> ScrewEnsemble:
    """Solve many ball screws of one design with uniformly distributed random ball errors under several axial loads.

    The memory needed is that for the ball errors of one chunk of screws, and for six results for each screw and load.

    Parameters
    ----------
    chain
        Ball screw as a sequence of balls.
    half_range
        Largest absolute value of the random errors, which are uniformly distributed [m].
    loads
        Axial loads ``(L,)`` [N].
    screw_count
        Number of screws.
    seed
        Seed of the random numbers.
    chunk
        Number of screws that are solved together, which limits the memory; the result does not depend on it.

    Raises
    ------
    ValueError
        The number of screws or the chunk is not positive, or errors as in `solve_screws_with_errors`.
    """
    if screw_count < 1 or chunk < 1 or half_range < 0.0:
        raise ValueError(
            "`screw_count` and `chunk`, numbers of screws, must be positive; `half_range` of errors must not be negative, "
            f"got screw_count {screw_count}, chunk {chunk}, half_range {half_range} m"
        )
    f = np.asarray(loads, dtype=float)
    kept, worst, failed = np.empty((screw_count, f.size, len(QUANTITIES))), 0.0, 0
    tolerance = load_kernel_package(RANDOM_ERRORS, compiled=False).TOLERANCE
    for first in range(0, screw_count, chunk):
        count = min(chunk, screw_count - first)
        errors = draw_uniform_errors(seed, first, count, chain.balls, half_range)
        kept[first : first + count], residual = solve_screws_with_errors(chain, errors, f)
        worst = max(worst, float(residual.max()))
        failed += int(np.count_nonzero((residual > tolerance).any(axis=1)))
    return ScrewEnsemble(f, kept, worst, failed)


@dataclass(frozen=True)
class PercentileRank:
    """Percentile rank of a given number in a sample of random values."""

    #: Fraction of the sample's values that are below the number.
    below: float
    #: Fraction of the sample's values that are below or equal to the number.
    at_most: float
    #: Number of values in the sample.
    size: int

    @property
    def percent(self) -> float:
        """Percentile rank of the number [%], for which values of the sample equal to it count half."""
        return 50.0 * (self.below + self.at_most)

    @property
    def standard_error(self) -> float:
        """Standard error of the percentile rank [%].

        By the rule of succession, it is never zero.
        """
        p = (0.01 * self.percent * self.size + 1.0) / (self.size + 2.0)
        return float(100.0 * np.sqrt(p * (1.0 - p) / self.size))

    @property
    def tail_probability(self) -> float:
        """One-sided tail probability: fraction of the sample at least as far from the sample's median as the number.

        Only values on the same side of the median as the number are counted.
        """
        return min(self.at_most, 1.0 - self.below)

    @property
    def tail_bound(self) -> float:
        """Upper 95 % confidence bound of ``tail_probability`` by Wilson's score interval.

        It is 2.7/size if no value of the sample is as extreme as the number.
        """
        z, n, p = 1.645, self.size, self.tail_probability
        return float((p + z * z / (2 * n) + z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))) / (1 + z * z / n))


def percentile_rank(sample: Array, value: float, rounding_error: float = 0.0) -> PercentileRank:
    """Return the percentile rank of a given number in a sample of values.

    Parameters
    ----------
    sample
        Values of the sample ``(n,)``.
    value
        The given number, in the unit of the sample.
    rounding_error
        Rounding error of the number; values of the sample that differ from the number by no more count as equal.
    """
    below, at_most = np.mean(sample < value - rounding_error), np.mean(sample <= value + rounding_error)
    return PercentileRank(float(below), float(at_most), sample.size)
