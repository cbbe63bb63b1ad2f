"""Contact loads of balls between two rigid bodies: minimum of a convex energy over all positions.

One solver for balls between screw and nut, inner and outer ring, carriage and rail: the inner body moves by u, the outer
one stands, and every ball has its place in the plane of its section.
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
class Settled:
    """Contact forces (N, 4) [N], actual contact angles (N, 4) [rad], positions of balls (N, 2) and inner body (m,) [m].

    left: largest force out of balance [N]; converged: whether that is below 1e-8 of the sum of forces.
    """

    force: Array
    angle: Array
    ball: Array
    inner: Array
    left: float
    steps: int
    converged: bool


def cell_state(cell: CellArrays) -> CellState:
    """Room for the state that the kernels write."""
    n, m = cell.interference.shape[0], cell.pull.shape[0]
    return CellState(np.zeros((n, 2)), np.zeros(m), np.zeros((n, 4, 3)), np.zeros((n, 4)), np.zeros((n, 4, 2)))


def settle_cell(
    cell: CellArrays, load: float, ball: Array, inner: Array, angles: Callable[[Array], Array], fast: bool = False
) -> Settled:
    """Loads from positions of balls (N, 2) and inner body (m,) [m], overwritten; forces do not depend on the start.

    load: sum of the sizes of the given forces [N]; angles: contact angles from normals (N, 4, 2). Minimises
    sum (2/5) C^(-3/2) <approach>^(5/2) - pull . u - push . p by Newton with line search, in the compiled kernels if
    ``fast``. Valid for approaches far below the reach r_G - r_B.
    """
    state = cell_state(cell)
    steps = int(kernels(CONTACT, compiled=fast).minimise_energy(cell, load, ball, inner, state, GOAL, STEPS))
    left = float(max(np.max(np.abs(state.ball), initial=0.0), np.max(np.abs(state.inner), initial=0.0)))
    good = left <= ACCEPTED * (load + float(np.sum(state.force)))
    return Settled(state.force, angles(state.normal), ball, inner, left, steps, good)


def settle_each(
    start: Array, interference: Array, C: Array, along: Array, given: Array, shift: Array, fast: bool = False
) -> tuple[Array, Array, Array, Array]:
    """``settle_cell`` of N balls independent of each other, each with an inner body that moves along ``along`` (2,).

    start (N, 4, 2), interference (N, 4) as in ``CellArrays``, C (N, 4); given (N, 3): forces [N] on balls and inner bodies;
    shift (N, 3): places to begin from [m]. Returns places, contact forces (N, 4) [N], normals (N, 4, 2), and the largest
    force out of balance of each ball (N,) [N].
    """
    x, n = shift.copy(), len(shift)
    force, normal, left = np.zeros((n, 4)), np.zeros((n, 4, 2)), np.zeros(n)
    given_arrays = (np.ascontiguousarray(a, dtype=float) for a in (start, interference, C, along, given))
    kernels(CONTACT, compiled=fast).minimise_each(*given_arrays, x, force, normal, left, GOAL, STEPS)
    return x, force, normal, left
