"""Liu's elimination algorithm: equations between neighbouring loaded balls, unloaded balls removed in rounds.

Unknowns are the approaches of the balls that are still in: between neighbours q < i equation (17), with the sum to q that
(14) asks for (printed: to i and q + 1 in (23), and the brackets of 17, 23, 24 with the opposite sign),

    F - sum over j <= q of C(j) - (m + 1)^-1 (A(q) - A(i) - B(q) + B(i)) / (c cos(lead)) = 0,    C(j) axial forces,

and (18), their sum. A round solves them by Newton's method with tension allowed (C odd in the approach, on which the source
is silent), removes every negative approach, and starts again.

It ends with the active set of the complementarity problem: with tension allowed H(u) is nowhere larger, so its solution
lies above the true one in every component, and what it leaves loose is loose; dropping balls lowers it further. So no ball
is dropped in error, and the last round, without tension, solves the problem.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.hertz import contact_approach, contact_force
from rollbench.lowfi.random_errors.chain import Chain, check_errors
from rollbench.meshes.arrays import Array

#: Newton steps of a round, halvings of a step.
MAX_STEPS, MAX_HALVINGS = 100, 30
TOLERANCE = 1e-10


@dataclass(frozen=True)
class EliminationResult:
    """Result of Liu's elimination algorithm."""

    #: Contact loads ``(M,)`` [N].
    load: Array
    #: Number of rounds.
    rounds: int
    #: Newton steps of all rounds.
    steps: int
    #: Whether every round was solved.
    converged: bool


def _contact_angle_sine(chain: Chain, errors: Array, approach: Array) -> tuple[Array, Array]:
    """Return the sine of the contact angle and its derivative by the approach."""
    sine_0, cosine_0 = np.sin(chain.contact_angle), np.cos(chain.contact_angle)
    if chain.law == "constant":
        return np.full_like(approach, sine_0), np.zeros_like(approach)
    free = chain.groove_distance - (errors if chain.law == "implicit" else 0.0)
    cosine = free * cosine_0 / (chain.groove_distance - errors + approach)
    sine = np.sqrt(1.0 - cosine**2)
    return sine, cosine**2 / (sine * (chain.groove_distance - errors + approach))


def _motion_of_approach(chain: Chain, errors: Array, approach: Array) -> tuple[Array, Array]:
    """Return the motion (A - B)/cos(lead) [m] of an approach, and its derivative."""
    sine, turn = _contact_angle_sine(chain, errors, approach)
    if chain.law == "exact":
        # difference of two lengths along the axis, from that of their squares: no cancellation
        grown, a = approach - errors, chain.groove_distance
        v = grown * (grown + 2.0 * a) / ((a + grown) * sine + a * np.sin(chain.contact_angle))
        return v / np.cos(chain.lead_angle), 1.0 / (sine * np.cos(chain.lead_angle))
    v = (approach - errors) / sine
    return v / np.cos(chain.lead_angle), (1.0 - v * turn) / (sine * np.cos(chain.lead_angle))


def _axial_forces(chain: Chain, errors: Array, approach: Array) -> tuple[Array, Array]:
    """Return the axial forces C(j) [N], odd in the approach, and their derivatives."""
    sine, turn = _contact_angle_sine(chain, errors, approach)
    root, lead = np.sqrt(np.abs(approach)), np.cos(chain.lead_angle)
    load = chain.stiffness * approach * root
    return load * sine * lead, (1.5 * chain.stiffness * root * sine + load * turn) * lead


def _equations_and_jacobian(
    chain: Chain, errors: Array, at: NDArray[np.int64], load: float, approach: Array
) -> tuple[Array, Array]:
    """Return equations (17) and (18) of the balls ``at`` [N], and their Jacobian."""
    force, rate = _axial_forces(chain, errors, approach)
    motion, slope = _motion_of_approach(chain, errors, approach)
    n = at.size
    spring = 1.0 / np.diff(np.cumsum(chain.segments)[at])
    value, jacobian = load - np.cumsum(force), -np.tril(np.broadcast_to(rate, (n, n)))
    value[:-1] -= spring * (motion[:-1] - motion[1:])
    k = np.arange(n - 1)
    jacobian[k, k] -= spring * slope[:-1]
    jacobian[k, k + 1] += spring * slope[1:]
    return value, jacobian


def _solve_round(
    chain: Chain, errors: Array, at: NDArray[np.int64], load: float, approach: Array
) -> tuple[Array, int, bool]:
    """Solve the equations of the balls that are in; return approaches, steps, and whether they are solved."""
    value, jacobian = _equations_and_jacobian(chain, errors, at, load, approach)
    for step in range(MAX_STEPS):
        size = float(np.abs(value).max())
        if size <= TOLERANCE * load:
            return approach, step, True
        move = -np.linalg.solve(jacobian, value)
        fraction = 1.0
        for _ in range(MAX_HALVINGS):
            ahead = _equations_and_jacobian(chain, errors, at, load, approach + fraction * move)
            if np.abs(ahead[0]).max() < size:
                break
            fraction *= 0.5
        approach = approach + fraction * move
        value, jacobian = ahead
    return approach, MAX_STEPS, False


def solve_by_elimination(chain: Chain, errors: Array, load: float) -> EliminationResult:
    """Return contact loads by Liu's five steps.

    Parameters
    ----------
    chain
        The chain.
    errors
        Excess of each ball along the contact normal ``(M,)`` [m].
    load
        F > 0 [N].

    Raises
    ------
    ValueError
        Rigid bodies (the equations divide by the compliance), a load that is not positive, or errors that do not fit.

    References
    ----------
    Liu et al. (2025), 14 to 24.
    """
    if chain.compliance <= 0.0 or not 0.0 < load < np.inf:
        raise ValueError("the elimination needs a compliance and a load above zero")
    e = check_errors(chain, errors)
    share = float(contact_approach(load / (chain.balls * chain.slope), chain.C))
    at = np.arange(chain.balls)
    approach, steps, done = np.full(chain.balls, share), 0, True
    rounds = 0
    while at.size:
        rounds += 1
        approach, taken, solved = _solve_round(chain, e[at], at, load, approach)
        steps, done = steps + taken, done and solved
        keep = approach >= 0.0
        if keep.all() or not solved:
            break
        at, approach = at[keep], approach[keep]
    q = np.zeros(chain.balls)
    q[at] = contact_force(approach, chain.C)
    return EliminationResult(q, rounds, steps, done)
