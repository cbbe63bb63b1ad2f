"""Banded systems of a chain: two right-hand sides, and the sign of the determinant."""

import numpy as np

from rollbench.lowfi.friction.linear.records import Array
from rollbench.lowfi.jit import CONTACT, is_compiled, kernel, kernels

solve_with_pivots = kernels(CONTACT, compiled=is_compiled(__name__)).solve_with_pivots
#: Columns of the banded matrix: half a band, the diagonal, half a band. A ball has four rows: x and, last, the force
#: towards the next ball.
HALF = 5
WIDTH = 11
#: Columns while rows are exchanged: what lies right of the diagonal may grow to twice the band.
FILLED = 16


@kernel
def solve_banded(K: Array, A: Array, x: Array, y: Array) -> float:
    """Solve K ``(n, 11)`` for x and y in place, with room A ``(n, 16)``; sign of K's determinant."""
    both = np.empty((x.size, 2))
    A[:, :WIDTH], A[:, WIDTH:] = K, 0.0
    both[:, 0], both[:, 1] = x, y
    sign: float = solve_with_pivots(A, both, HALF)
    x[:], y[:] = both[:, 0], both[:, 1]
    return sign
