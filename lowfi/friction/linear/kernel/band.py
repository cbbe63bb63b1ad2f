"""Banded systems of a chain: two right-hand sides, rows exchanged, and the sign of the determinant."""

from rollbench.lowfi.friction.linear.records import Array
from rollbench.lowfi.jit import kernel

#: Columns of the banded matrix: half a band, the diagonal, half a band. A ball has four rows: x and, last, the force
#: towards the next ball.
HALF = 5
WIDTH = 11
#: Columns while rows are exchanged: what lies right of the diagonal may grow to twice the band.
FILLED = 16


@kernel
def _exchange(A: Array, i: int, p: int, right: int) -> None:
    """Exchange rows i < p from column i on; ``right``: end of what they may hold."""
    for c in range(i, right):
        a, b = A[i, HALF + c - i], 0.0
        if HALF + c - p < FILLED:
            b = A[p, HALF + c - p]
            A[p, HALF + c - p] = a
        A[i, HALF + c - i] = b


@kernel
def solve_banded(K: Array, A: Array, x: Array, y: Array) -> float:
    """Solve K ``(n, 11)`` for x and y in place, partial pivoting in A ``(n, 16)``; sign of K's determinant.

    Rows are exchanged because friction between balls makes K unsymmetric and, beyond a fold, indefinite.
    """
    n, sign = x.shape[0], 1.0
    A[:, :WIDTH] = K
    A[:, WIDTH:] = 0.0
    for i in range(n):
        last, right = min(n, i + HALF + 1), min(n, i + FILLED - HALF)
        p, best = i, abs(A[i, HALF])
        for r in range(i + 1, last):
            if abs(A[r, HALF + i - r]) > best:
                p, best = r, abs(A[r, HALF + i - r])
        if p != i:
            sign = -sign
            _exchange(A, i, p, right)
            x[i], x[p] = x[p], x[i]
            y[i], y[p] = y[p], y[i]
        if best == 0.0:
            A[i, HALF] = 1e-300
        if A[i, HALF] < 0.0:
            sign = -sign
        for r in range(i + 1, last):
            factor = A[r, HALF + i - r] / A[i, HALF]
            if factor != 0.0:
                for c in range(i + 1, right):
                    A[r, HALF + c - r] -= factor * A[i, HALF + c - i]
                x[r] -= factor * x[i]
                y[r] -= factor * y[i]
    _substitute(A, x, y)
    return sign


@kernel
def _substitute(A: Array, x: Array, y: Array) -> None:
    n = x.shape[0]
    for i in range(n - 1, -1, -1):
        for c in range(i + 1, min(n, i + FILLED - HALF)):
            x[i] -= A[i, HALF + c - i] * x[c]
            y[i] -= A[i, HALF + c - i] * y[c]
        x[i] /= A[i, HALF]
        y[i] /= A[i, HALF]
