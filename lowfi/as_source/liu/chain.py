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

S screws, or states of one screw, are solved together: in all arrays the axes are screw, then ball.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from rollbench.lowfi.hertz import contact_approach
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
    def C(self) -> float:
        """Hertz constant C of the approach C Q^(2/3) of both contacts of a ball together [m/N^(2/3)]."""
        return float(self.stiffness ** (-2.0 / 3.0))

    @property
    def approach_per_motion(self) -> float:
        """Ratio of a ball's approach to the axial motion of the nut at small load, sin(a_0) cos(lead angle).

        a_0 is the contact angle without load.
        """
        return float(np.sin(self.contact_angle) * np.cos(self.lead_angle))


class BallScrewState(NamedTuple):
    """Contact loads, motions and stiffness of one ball screw with random errors under one axial load.

    For S screws, each under an axial load of its own, all fields and properties have the axis of the screws in front.
    """

    #: Contact loads Q of the M balls ``(M,)`` [N].
    load: Array
    #: Axial motion of the nut relative to the screw at each of the M balls ``(M,)`` [m]; it differs along the nut because
    #: both bodies are stretched.
    motion: Array
    #: Axial motion of the nut at which the ball with the largest error comes into contact first [m].
    first_contact_motion: Any
    #: Axial stiffness dF/du_1, the derivative of the axial load F by the motion u_1 at ball 1, where the load acts [N/m].
    stiffness: Any
    #: Number of Newton steps.
    iterations: Any
    #: Largest unbalanced axial force on a ball at the end of the iteration, as a fraction of the axial load.
    residual: Any

    @property
    def converged(self) -> Any:
        """Whether the ``residual`` is below the tolerance of Newton's method."""
        return self.residual <= TOLERANCE

    @property
    def loaded_balls(self) -> Any:
        """Number of balls that carry load."""
        return np.count_nonzero(self.load > 0.0, axis=-1)

    @property
    def displacement(self) -> Any:
        """Axial motion of the nut at ball 1, where the load acts, since the first contact of any ball [m]."""
        return self.motion[..., 0] - self.first_contact_motion

    @property
    def displacement_first_loaded(self) -> Any:
        """Axial motion of the nut at the first loaded ball, since the first contact of any ball [m] (Liu's equation 19).

        It does not contain the stretch of screw and nut before this ball.
        """
        first = np.argmax(self.load > 0.0, axis=-1, keepdims=True)
        return np.take_along_axis(self.motion, first, axis=-1)[..., 0] - self.first_contact_motion


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


class ForceOfBalls(NamedTuple):
    """Forces of balls at given motions, arrays of the shape of the motions; all are zero at a ball without contact."""

    #: Contact loads Q [N].
    contact_load: Array
    #: Axial forces f(u) = Q sin(contact angle) cos(lead angle) [N].
    axial: Array
    #: Derivatives f'(u) of the axial forces by the motions [N/m].
    slope: Array


def force_of_balls(chain: BallScrewChain, motion: Array, error: Array) -> ForceOfBalls:
    """Return contact loads and axial forces of balls, by the law of the contact angle of ``chain``.

    ``motion``: axial motion u of the nut at each ball [m]; ``error``: oversize of each ball [m]; both in any shape.

    References
    ----------
    Liu et al. (2025), equations (10) and (14) for the law "implicit".
    """
    K, A, a0, lead = chain.stiffness, chain.groove_distance, chain.contact_angle, np.cos(chain.lead_angle)
    v, e = motion * lead, np.broadcast_to(error, np.shape(motion))
    sine, approach = np.full(v.shape, np.sin(a0)), e + v * np.sin(a0)
    by_v = sine  # d(approach)/dv
    if chain.law == "exact":
        along, across = A * np.sin(a0) + v, A * np.cos(a0)
        distance = np.hypot(along, across)
        sine = by_v = along / distance
        approach = v * (2.0 * A * np.sin(a0) + v) / (distance + A) + e  # distance - A + e without cancellation
    elif chain.law == "implicit":
        touch = approach > 0.0  # in (10) the approach has the sign of that at a constant angle
        by_v = sine.copy()
        approach[touch], sine[touch], by_v[touch] = _implicit_approach(chain, v[touch], e[touch])
    d = np.maximum(approach, 0.0)
    root = np.sqrt(d)
    load = K * d * root
    turn = 0.0 if chain.law == "constant" else (1.0 - sine**2) * by_v / (sine * (A - e + d))  # d(sine)/dv
    return ForceOfBalls(load, load * sine * lead, (1.5 * K * root * by_v * sine + load * turn) * lead**2)


def _implicit_approach(chain: BallScrewChain, v: Array, error: Array) -> tuple[Array, Array, Array]:
    """Return approach [m], sine of the contact angle, and d(approach)/dv of k balls by Liu's equations (10) and (14).

    The equation solved is approach = error + v sin(angle(approach)). ``v``: axial motion of the groove times the cosine
    of the lead angle ``(k,)`` [m]; ``error``: oversize of the balls ``(k,)`` [m].
    """
    free = chain.groove_distance - error
    approach = error + v * np.sin(chain.contact_angle)
    for _ in range(8):
        apart = free + approach
        cosine = free * np.cos(chain.contact_angle) / apart
        sine = np.sqrt(1.0 - cosine**2)
        turn = cosine**2 / (sine * apart)  # d(sine)/d(approach)
        step = (approach - error - v * sine) / (1.0 - v * turn)
        approach = approach - step
        if np.all(np.abs(step) <= 1e-15 * chain.groove_distance):
            break
    return approach, sine, sine / (1.0 - v * turn)


def contact_angle_sine(chain: BallScrewChain, errors: Array, approach: Array) -> tuple[Array, Array]:
    """Return the sine of the contact angle of k balls, and its derivative by the ball's approach [1/m], ``(k,)`` each.

    ``chain``: ball screw, which says how the contact angle changes under load; ``errors``, ``approach``: oversize and
    approach of the k balls ``(k,)`` [m].
    """
    sine_0, cosine_0 = np.sin(chain.contact_angle), np.cos(chain.contact_angle)
    if chain.law == "constant":
        return np.full_like(approach, sine_0), np.zeros_like(approach)
    free = chain.groove_distance - (errors if chain.law == "implicit" else 0.0)
    cosine = free * cosine_0 / (chain.groove_distance - errors + approach)
    sine = np.sqrt(1.0 - cosine**2)
    return sine, cosine**2 / (sine * (chain.groove_distance - errors + approach))


#: Number of Newton steps after which the iteration ends without convergence.
MAX_ITERATIONS = 60

#: Largest error of a ball's axial force, as a ratio to the axial load of the screw, that counts as converged.
TOLERANCE = 1e-10


def solve_screws(chain: BallScrewChain, errors: Array, loads: Array) -> BallScrewState:
    """Solve the axial equilibrium of the balls of S screws by Newton's method, with the equations of this module.

    The method starts from the motions of rigid bodies, plus the stretch if all balls carried the same load. Screws that
    have converged leave the iteration. ``errors``: oversize of each ball ``(S, M)`` [m]; ``loads``: axial load F > 0 of
    each screw ``(S,)`` [N].
    """
    c, (count, balls) = chain.segment_compliances, errors.shape
    behind = np.append(c[1:] * np.arange(balls - 1, 0, -1) / balls, 0.0)  # stretch of the segment behind each ball over F
    stretch = np.cumsum(behind[::-1])[::-1]
    e, F = errors, loads[:, None]
    u = _motion_of_rigid_bodies(chain, e, F) + F * stretch
    touch, steps = axial_motion_at_touch(chain, e.max(axis=1)), np.empty(count, dtype=int)
    out = BallScrewState(np.empty_like(e), np.empty_like(e), touch, np.empty(count), steps, np.empty(count))
    screw, expected = np.arange(count), np.full(e.shape, np.inf)
    for step in range(MAX_ITERATIONS + 1):
        f = force_of_balls(chain, u, e)
        left = np.abs(f.axial - expected).max(axis=1) / F[:, 0]
        s, t = _forces_of_balls_behind(c, f, u)
        done = (left <= TOLERANCE) | (step == MAX_ITERATIONS)
        results = zip((out.load, out.motion, out.stiffness, out.residual), (f.contact_load, u, s[:, 0], left), strict=True)
        for kept, value in results:
            kept[screw[done]] = value[done]
        steps[screw[done]] = step
        if done.all():
            break
        screw, e, F, s, t = (x[~done] for x in (screw, e, F, s, t))
        u, expected = _newton_motions(c, s, t, F[:, 0])
    return out


def _motion_of_rigid_bodies(chain: BallScrewChain, errors: Array, loads: Array) -> Array:
    """Return the axial motion of the nut ``(S, 1)`` [m] if screw and nut are rigid and the contact angle is constant.

    At this motion the axial forces of the balls add up to the load or at most 1 % more, so that at least one ball is
    loaded. ``errors``: oversize of the balls ``(S, M)`` [m]; ``loads``: axial loads ``(S, 1)`` [N].
    """
    k, K, M = chain.approach_per_motion, chain.stiffness, chain.balls
    u = ((loads / (k * K * M)) ** (2.0 / 3.0) - errors.min(axis=1, keepdims=True)) / k
    for _ in range(MAX_ITERATIONS):
        d = np.maximum(errors + k * u, 0.0)
        excess = k * K * (d * np.sqrt(d)).sum(axis=1, keepdims=True) - loads
        far = excess > 0.01 * loads
        if not far.any():
            break
        u = np.where(far, u - excess / (1.5 * k * k * K * np.sqrt(d).sum(axis=1, keepdims=True)), u)
    return np.asarray(u)


def _forces_of_balls_behind(c: Array, f: ForceOfBalls, u: Array) -> tuple[Array, Array]:
    """Return s [N/m] and t [N], ``(S, M)`` each, of the linear law T_j = s_j u_j + t_j of the balls from j on.

    ``c``: compliance of the segment before each ball ``(M,)`` [m/N]; ``f``: forces of the balls at the motions ``u``
    ``(S, M)`` [m].
    """
    s, t = f.slope.copy(), f.axial - f.slope * u
    for j in range(c.size - 2, -1, -1):
        yields = 1.0 + c[j + 1] * s[:, j + 1]
        s[:, j] += s[:, j + 1] / yields
        t[:, j] += t[:, j + 1] / yields
    return s, t


def _newton_motions(c: Array, s: Array, t: Array, loads: Array) -> tuple[Array, Array]:
    """Return the motions of the balls by Newton's step [m], and the axial forces [N] it expects there, ``(S, M)`` each.

    The motion of ball 1 follows from the whole load, those of the others ball by ball. ``c``: compliance of the segment
    before each ball ``(M,)`` [m/N]; ``s``, ``t``: law by `_forces_of_balls_behind`; ``loads``: axial loads ``(S,)`` [N].
    """
    u, T = np.empty_like(s), np.zeros((len(s), c.size + 1))
    u[:, 0], T[:, 0] = (loads - t[:, 0]) / s[:, 0], loads
    for j in range(1, c.size):
        T[:, j] = (s[:, j] * u[:, j - 1] + t[:, j]) / (1.0 + c[j] * s[:, j])
        u[:, j] = u[:, j - 1] - c[j] * T[:, j]
    return u, T[:, :-1] - T[:, 1:]


def solve_ball_screw(chain: BallScrewChain, errors: Array, load: float) -> BallScrewState:
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
    e = checked_ball_errors(chain, errors)
    return BallScrewState(*(values[0] for values in solve_screws(chain, e[None], np.array([float(load)]))))


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
