"""Elimination algorithm of Liu et al. (2025) for the contact loads of a ball screw with random errors.

Balls that would carry tension are removed in rounds. The unknowns are the approaches of the balls that are not yet removed.
Between neighbours q < i of these balls Liu's equation (17) holds, with the sum up to q that (14) requires (printed: up to
i, and q + 1 in (23); the brackets of 17, 23 and 24 are printed with the opposite sign),

    F - sum over j <= q of C(j) - (m + 1)^-1 (A(q) - A(i) - B(q) + B(i)) / (c cos(lead)) = 0,    C(j) axial forces,

and the sum of the axial forces is F (18). Each round solves these equations by Newton's method, with tension allowed (C is
odd in the approach; the paper does not say so), and removes all balls with a negative approach.

The last round has the active set of the complementarity problem in `lowfi.as_source.liu.chain`. With tension allowed, the
sum of forces H(u) is nowhere larger than without, and removing balls lowers H further. The solution of a round therefore
lies above the true one in every component. A ball without contact there has no contact in the true solution either, so that
no ball is removed in error. The last round, in which no ball carries tension, solves the problem.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.as_source.liu.chain import BallScrewChain, checked_ball_errors, contact_angle_sine
from rollbench.lowfi.hertz import contact_approach, contact_force
from rollbench.meshes.arrays import Array

#: Largest number of Newton steps in a round of the elimination, and largest number of halvings of a step.
MAX_STEPS, MAX_HALVINGS = 100, 30
#: Residual of the equations over the load at which Newton's method ends.
TOLERANCE = 1e-10


@dataclass(frozen=True)
class EliminationResult:
    """Contact loads of M balls by Liu's elimination algorithm, with the number of rounds."""

    #: Contact loads of the M balls ``(M,)`` [N].
    contact_loads: Array
    #: Number of rounds of the algorithm; after each round the balls without contact are eliminated.
    rounds: int
    #: Whether Newton's method converged in every round.
    converged: bool


def _axial_nut_motion_from_approach(chain: BallScrewChain, errors: Array, approach: Array) -> tuple[Array, Array]:
    """Return the axial motion of the nut at k balls [m], and its derivative by the ball's approach, ``(k,)`` each.

    With the terms A and B of equation (17) of Liu et al., the motion is (A - B)/cos(lead angle). ``chain``: ball screw;
    ``errors``, ``approach``: oversize and approach of the k balls ``(k,)`` [m].
    """
    sine, turn = contact_angle_sine(chain, errors, approach)
    if chain.law == "exact":
        # difference of two lengths along the axis, from that of their squares: no cancellation
        grown, a = approach - errors, chain.groove_distance
        v = grown * (grown + 2.0 * a) / ((a + grown) * sine + a * np.sin(chain.contact_angle))
        return v / np.cos(chain.lead_angle), 1.0 / (sine * np.cos(chain.lead_angle))
    v = (approach - errors) / sine
    return v / np.cos(chain.lead_angle), (1.0 - v * turn) / (sine * np.cos(chain.lead_angle))


def _axial_forces(chain: BallScrewChain, errors: Array, approach: Array) -> tuple[Array, Array]:
    """Return the axial forces of k balls on the nut [N], and their derivatives by the ball's approach, ``(k,)`` each.

    The forces are the terms C(j) of equation (17) of Liu et al. Tension is allowed: the forces
    are odd functions of the approach. ``chain``: ball screw; ``errors``, ``approach``: oversize and approach of the k balls
    ``(k,)`` [m].
    """
    sine, turn = contact_angle_sine(chain, errors, approach)
    root, lead = np.sqrt(np.abs(approach)), np.cos(chain.lead_angle)
    load = chain.stiffness * approach * root
    return load * sine * lead, (1.5 * chain.stiffness * root * sine + load * turn) * lead


def _equations_and_jacobian(
    chain: BallScrewChain, errors: Array, remaining: NDArray[np.int64], load: float, approach: Array
) -> tuple[Array, Array]:
    """Return the residuals of equations (17) and (18) of Liu et al. ``(k,)`` [N], and their Jacobian ``(k, k)`` [N/m].

    ``remaining``: numbers of the k balls that are not eliminated; ``errors``, ``approach``: their oversize and approach
    ``(k,)`` [m]; ``load``: axial load [N].
    """
    force, rate = _axial_forces(chain, errors, approach)
    motion, slope = _axial_nut_motion_from_approach(chain, errors, approach)
    n = remaining.size
    spring = 1.0 / np.diff(np.cumsum(chain.segment_compliances)[remaining])
    value, jacobian = load - np.cumsum(force), -np.tril(np.broadcast_to(rate, (n, n)))
    value[:-1] -= spring * (motion[:-1] - motion[1:])
    k = np.arange(n - 1)
    jacobian[k, k] -= spring * slope[:-1]
    jacobian[k, k + 1] += spring * slope[1:]
    return value, jacobian


def _solve_elimination_round(
    chain: BallScrewChain, errors: Array, remaining: NDArray[np.int64], load: float, approach: Array
) -> tuple[Array, bool]:
    """Solve the equations of one elimination round by Newton's method, for the balls that are not yet eliminated.

    ``remaining``: numbers of the k balls that are not eliminated; ``errors``: their oversize ``(k,)`` [m]; ``load``: axial
    load [N]; ``approach``: approaches of these balls from which the method starts ``(k,)`` [m].

    Returns
    -------
    tuple
        Approaches of the k balls ``(k,)`` [m]; whether the method converged.
    """
    value, jacobian = _equations_and_jacobian(chain, errors, remaining, load, approach)
    for _ in range(MAX_STEPS):
        size = float(np.abs(value).max())
        if size <= TOLERANCE * load:
            return approach, True
        move = -np.linalg.solve(jacobian, value)
        fraction = 1.0
        for _ in range(MAX_HALVINGS):
            ahead = _equations_and_jacobian(chain, errors, remaining, load, approach + fraction * move)
            if np.abs(ahead[0]).max() < size:
                break
            fraction *= 0.5
        approach = approach + fraction * move
        value, jacobian = ahead
    return approach, False


def solve_by_elimination(chain: BallScrewChain, errors: Array, load: float) -> EliminationResult:
    """Return the contact loads of balls with random errors between screw and nut by Liu's elimination algorithm.

    Parameters
    ----------
    chain
        Balls between screw and nut.
    errors
        Oversize of each ball in its grooves along the contact normal ``(M,)`` [m].
    load
        Axial load F > 0 [N].

    Raises
    ------
    ValueError
        The bodies are rigid (the equations divide by the compliance), the load is not positive, or the errors have the
        wrong number or size.

    References
    ----------
    Liu et al. (2025), equations (14) to (24).
    """
    if chain.compliance <= 0.0 or not 0.0 < load < np.inf:
        raise ValueError(
            "Liu's elimination algorithm needs a compliance of screw and nut and an axial load, both above zero, "
            f"got {chain.compliance} m/N and {load} N"
        )
    e = checked_ball_errors(chain, errors)
    share = float(contact_approach(load / (chain.balls * chain.approach_per_motion), chain.C))
    at = np.arange(chain.balls)
    approach, rounds, done = np.full(chain.balls, share), 0, True
    while at.size:
        rounds += 1
        approach, solved = _solve_elimination_round(chain, e[at], at, load, approach)
        done = done and solved
        keep = approach >= 0.0
        if keep.all() or not solved:
            break
        at, approach = at[keep], approach[keep]
    q = np.zeros(chain.balls)
    q[at] = contact_force(approach, chain.C)
    return EliminationResult(q, rounds, done)
