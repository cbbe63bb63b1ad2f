"""Solution of a symmetric positive definite banded system, overwriting its right-hand side.

Compiled: the column-wise LDL^T below. Interpreted: LAPACK through scipy. A test compares them.
"""

import numpy as np

from lowfi.jit import is_compiled, kernel
from lowfi.statics.records import Array


@kernel
def eliminate(band: Array, b: Array, column: Array, j: int, m: int) -> None:
    """Eliminate unknown j from the m - 1 that follow it, and from the right-hand side."""
    inverse = 1.0 / band[j, 0]
    for i in range(1, m):
        column[i] = band[j, i]  # a copy: the compiler then knows that the updates below do not change it
        band[j, i] = column[i] * inverse
    for k in range(1, m):
        f = column[k] * inverse
        if f != 0.0:
            for i in range(m - k):
                band[j + k, i] -= f * column[k + i]
    x = b[j]
    for i in range(1, m):
        b[j + i] -= band[j, i] * x


@kernel
def ldl_solve(band: Array, b: Array) -> bool:
    """Solve A x = b with A[i, j] = band[j, i - j], i >= j (lower band, column by column); b (n,) becomes x.

    Overwrites ``band`` with the factors L (unit) and D. Returns False where A is not positive definite.
    """
    n, width = band.shape
    column = np.empty(width)
    for j in range(n):
        if not band[j, 0] > 0.0:
            return False
        if width == 12 and j + 12 <= n:
            eliminate(band, b, column, j, 12)  # the common width, known to the compiler: its loops unroll
        else:
            eliminate(band, b, column, j, min(width, n - j))
    for j in range(n - 1, -1, -1):
        m = min(width, n - j)
        x = b[j] / band[j, 0]
        for i in range(1, m):
            x -= band[j, i] * b[j + i]
        b[j] = x
    return True


def _lapack_solve(band: Array, b: Array) -> bool:
    from scipy.linalg import LinAlgError, solveh_banded

    try:
        b[:] = solveh_banded(band.T, b, lower=True, check_finite=False)
    except LinAlgError:
        return False
    return True


solve_banded = ldl_solve if is_compiled(__name__) else _lapack_solve
