"""Contact loads of balls between two rigid bodies, by the minimum of a convex energy over all positions.

The bodies are screw and nut, inner and outer ring, or carriage and rail. The inner body moves by u, the outer body is
fixed, and the unknowns of every ball are its two coordinates in the plane of its groove section.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import Array, CellArrays, CellState
from rollbench.lowfi.jit import CONTACT, kernels

#: Imbalance at which the iteration ends, and largest imbalance of a converged result, over the sum of forces.
GOAL, ACCEPTED = 1e-13, 1e-8
#: Largest number of Newton steps.
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
    #: Largest unbalanced force [N].
    left: float
    #: Number of Newton steps.
    steps: int
    #: Whether the unbalanced force is below 1e-8 times the sum of forces.
    converged: bool


def cell_state(cell: CellArrays) -> CellState:
    """Return empty arrays for the results that the kernels write."""
    n, m = cell.interference.shape[0], cell.pull.shape[0]
    return CellState(np.zeros((n, 2)), np.zeros(m), np.zeros((n, 4, 3)), np.zeros((n, 4)), np.zeros((n, 4, 2)))


def settle_cell(
    cell: CellArrays, load: float, ball: Array, inner: Array, angles: Callable[[Array], Array], fast: bool = False
) -> SettledCell:
    """Return the contact loads of balls between two rigid bodies, by Newton's method with line search.

    They are the minimum of sum (2/5) C^(-3/2) <approach>^(5/2) - pull . u - push . p over the positions u of the inner body
    and p of the balls. Valid for approaches far below the distance r_G - r_B of groove and ball centres. The forces do not
    depend on the start.

    Parameters
    ----------
    cell
        Geometry, stiffness and loads of balls and bodies.
    load
        Sum of the magnitudes of the applied forces [N].
    ball, inner
        First positions of balls ``(N, 2)`` and inner body ``(m,)`` [m]; overwritten.
    angles
        Function that computes contact angles from contact normals ``(N, 4, 2)``.
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
    """Return the contact loads of N independent balls, each between its own inner body and the fixed outer body.

    Parameters
    ----------
    start, interference
        Arrays ``(N, 4, 2)`` and ``(N, 4)`` as in ``CellArrays``.
    C
        Hertz constants ``(N, 4)`` [m/N^(2/3)].
    along
        Direction in which the inner bodies move ``(2,)``.
    given
        Forces on ball and inner body ``(N, 3)`` [N].
    shift
        First positions of ball and inner body ``(N, 3)`` [m].
    fast
        Whether to use compiled kernels.

    Returns
    -------
    tuple[Array, Array, Array, Array]
        Positions ``(N, 3)`` [m], contact loads ``(N, 4)`` [N], contact normals ``(N, 4, 2)``, and largest unbalanced force
        ``(N,)`` [N].
    """
    x, n = shift.copy(), len(shift)
    force, normal, left = np.zeros((n, 4)), np.zeros((n, 4, 2)), np.zeros(n)
    given_arrays = (np.ascontiguousarray(a, dtype=float) for a in (start, interference, C, along, given))
    kernels(CONTACT, compiled=fast).minimise_each(*given_arrays, x, force, normal, left, GOAL, STEPS)
    return x, force, normal, left
