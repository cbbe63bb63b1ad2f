"""Solution of banded linear systems by Gaussian elimination with row exchange.

Row exchange is needed because friction between balls makes the matrix unsymmetric and, beyond a fold of the solution,
indefinite.
"""

from rollbench.lowfi.friction.contact.kernel_types import Array
from rollbench.lowfi.jit import kernel


@kernel
def solve_with_pivots(K: Array, x: Array, half: int) -> float:
    """Solve a banded linear system by Gaussian elimination with row exchange; return the sign of its determinant.

    Entry (i, j) of the matrix is K[i, half + j - i]; K (n, 3 half + 1) has room for entries that row exchange adds. The
    right-hand sides x (n, c) are overwritten by the solutions, K by its factors. For a singular K the solutions are huge.
    """
    n, sign = x.shape[0], 1.0
    for c in range(n):
        low, right, top = min(n, c + half + 1), min(n, c + 2 * half + 1), c
        for r in range(c + 1, low):
            if abs(K[r, half + c - r]) > abs(K[top, half + c - top]):
                top = r
        if top != c:
            sign = -sign
            for j in range(c, right):
                K[c, half + j - c], K[top, half + j - top] = K[top, half + j - top], K[c, half + j - c]
            for q in range(x.shape[1]):
                x[c, q], x[top, q] = x[top, q], x[c, q]
        if K[c, half] == 0.0:
            K[c, half] = 1e-300
        if K[c, half] < 0.0:
            sign = -sign
        for r in range(c + 1, low):
            ratio = K[r, half + c - r] / K[c, half]
            if ratio != 0.0:
                for j in range(c + 1, right):
                    K[r, half + j - r] -= ratio * K[c, half + j - c]
                for q in range(x.shape[1]):
                    x[r, q] -= ratio * x[c, q]
    for c in range(n - 1, -1, -1):
        for q in range(x.shape[1]):
            for j in range(c + 1, min(n, c + 2 * half + 1)):
                x[c, q] -= K[c, half + j - c] * x[j, q]
            x[c, q] /= K[c, half]
    return sign
