"""Contact loads of balls between two rigid bodies: minimum of a convex energy over all positions.

One solver for balls between screw and nut, inner and outer ring, carriage and rail: the inner body moves by u, the outer
one is fixed, and every ball has its position in the plane of its section.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import Array, CellArrays, CellState
from rollbench.lowfi.jit import CONTACT, kernels

#: Round-off limit of the search and what counts as converged, as parts of the sum of forces.
GOAL, ACCEPTED = 1e-13, 1e-8
STEPS = 600


@dataclass(frozen=True)
class SettledCell:
    """Contact loads of N balls between two rigid bodies."""

    #: Contact forces ``(N, 4)`` [N].
    force: Array
    #: Contact angles under load ``(N, 4)`` [rad].
    angle: Array
    #: Positions of the balls ``(N, 2)`` [m].
    ball: Array
    #: Position of the inner body ``(m,)`` [m].
    inner: Array
    #: Largest force out of balance [N].
    left: float
    #: Newton steps.
    steps: int
    #: Whether ``left`` is below 1e-8 of the sum of forces.
    converged: bool


def cell_state(cell: CellArrays) -> CellState:
    """Return arrays for the state that the kernels write."""
    n, m = cell.interference.shape[0], cell.pull.shape[0]
    return CellState(np.zeros((n, 2)), np.zeros(m), np.zeros((n, 4, 3)), np.zeros((n, 4)), np.zeros((n, 4, 2)))


def settle_cell(
    cell: CellArrays, load: float, ball: Array, inner: Array, angles: Callable[[Array], Array], fast: bool = False
) -> SettledCell:
    """Return the loads, the minimum of sum (2/5) C^(-3/2) <approach>^(5/2) - pull . u - push . p.

    By Newton's method with line search. Valid for approaches far below the reach r_G - r_B; forces do not depend on the
    start.

    Parameters
    ----------
    cell
        The balls and bodies.
    load
        Sum of the sizes of the given forces [N].
    ball, inner
        Positions of balls ``(N, 2)`` and inner body ``(m,)`` to begin from [m]; overwritten.
    angles
        Returns contact angles from normals ``(N, 4, 2)``.
    fast
        Whether to use compiled kernels.
    """
    state = cell_state(cell)
    steps = int(kernels(CONTACT, compiled=fast).minimise_energy(cell, load, ball, inner, state, GOAL, STEPS))
    left = float(max(np.max(np.abs(state.ball), initial=0.0), np.max(np.abs(state.inner), initial=0.0)))
    good = left <= ACCEPTED * (load + float(np.sum(state.force)))
    return SettledCell(state.force, angles(state.normal), ball, inner, left, steps, good)


def settle_each_ball(
    start: Array, interference: Array, C: Array, along: Array, given: Array, shift: Array, fast: bool = False
) -> tuple[Array, Array, Array, Array]:
    """Return the result of `settle_cell` for N balls independent of each other, each with its inner body.

    Parameters
    ----------
    start, interference
        ``(N, 4, 2)`` and ``(N, 4)``, as in ``CellArrays``.
    C
        Hertz constants ``(N, 4)``.
    along
        Direction in which the inner bodies move ``(2,)``.
    given
        Forces on balls and inner bodies ``(N, 3)`` [N].
    shift
        Positions to begin from ``(N, 3)`` [m].
    fast
        Whether to use compiled kernels.

    Returns
    -------
    tuple[Array, Array, Array, Array]
        Positions, contact loads ``(N, 4)`` [N], normals ``(N, 4, 2)``, and the largest force out of balance ``(N,)`` [N].
    """
    x, n = shift.copy(), len(shift)
    force, normal, left = np.zeros((n, 4)), np.zeros((n, 4, 2)), np.zeros(n)
    given_arrays = (np.ascontiguousarray(a, dtype=float) for a in (start, interference, C, along, given))
    kernels(CONTACT, compiled=fast).minimise_each(*given_arrays, x, force, normal, left, GOAL, STEPS)
    return x, force, normal, left
