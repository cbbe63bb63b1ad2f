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

#: Unbalanced force, over the sum of all forces, at which the iteration ends, and up to which its result counts as
#: converged.
GOAL, ACCEPTED = 1e-13, 1e-8
#: Largest number of Newton steps.
STEPS = 600


@dataclass(frozen=True)
class SettledCell:
    """Contact loads of N balls between two rigid bodies, the inner of which has m free motions."""

    #: Contact forces ``(N, 4)`` [N].
    force: Array
    #: Contact angles under load ``(N, 4)`` [rad].
    angle: Array
    #: Displacements of the balls along x, z of their sections ``(N, 2)`` [m].
    ball: Array
    #: Displacement of the inner body along its free motions ``(m,)`` [m].
    inner: Array
    #: Largest unbalanced force [N].
    left: float
    #: Number of Newton steps.
    steps: int
    #: Whether the unbalanced force is below 1e-8 times the sum of forces.
    converged: bool


def cell_state(cell: CellArrays) -> CellState:
    """Return arrays of zeros, of the size of ``cell``, to which the kernels write forces, stiffness and gradients."""
    n, m = cell.interference.shape[0], cell.pull.shape[0]
    return CellState(np.zeros((n, 2)), np.zeros(m), np.zeros((n, 4, 3)), np.zeros((n, 4)), np.zeros((n, 4, 2)))


def settle_cell(
    cell: CellArrays, load: float, ball: Array, inner: Array, angles: Callable[[Array], Array], fast: bool = False
) -> SettledCell:
    """Return the contact loads of balls between two rigid bodies, by Newton's method with line search.

    They are the minimum of sum (2/5) C^(-3/2) <approach>^(5/2) - pull . u - push . p over the displacements u of the inner
    body and p of the balls. The model is valid for approaches far below the distance r_G - r_B of groove and ball centres.
    The loads do not depend on the start.

    Parameters
    ----------
    cell
        Geometry, stiffness and loads of balls and bodies.
    load
        Sum of the magnitudes of the applied forces [N].
    ball, inner
        Displacements of the balls ``(N, 2)`` and of the inner body ``(m,)`` [m] from which the search begins; both are
        overwritten by the result.
    angles
        Function that computes contact angles ``(N, 4)`` [rad] from contact normals ``(N, 4, 2)``.
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
    start
        Vectors from the grooves' centres of curvature to the ball's centre along x, z ``(N, 4, 2)`` [m].
    interference
        Interference of ball and groove before any displacement ``(N, 4)`` [m].
    C
        Hertz constants C of the approach C F^(2/3) ``(N, 4)`` [m/N^(2/3)].
    along
        Direction along x, z in which the inner bodies move ``(2,)``.
    given
        Applied forces: on the ball along x, z, and on the inner body along its motion ``(N, 3)`` [N].
    shift
        Displacements of ball (x, z) and inner body from which the search begins ``(N, 3)`` [m].
    fast
        Whether to use compiled kernels.

    Returns
    -------
    tuple[Array, Array, Array, Array]
        Displacements of ball and inner body ``(N, 3)`` [m], contact loads ``(N, 4)`` [N], contact normals along x, z
        ``(N, 4, 2)``, and largest unbalanced force ``(N,)`` [N].
    """
    x, n = shift.copy(), len(shift)
    force, normal, left = np.zeros((n, 4)), np.zeros((n, 4, 2)), np.zeros(n)
    given_arrays = (np.ascontiguousarray(a, dtype=float) for a in (start, interference, C, along, given))
    kernels(CONTACT, compiled=fast).minimise_each(*given_arrays, x, force, normal, left, GOAL, STEPS)
    return x, force, normal, left
