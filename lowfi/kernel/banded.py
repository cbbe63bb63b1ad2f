"""Solution of a symmetric positive definite banded system, overwriting its right-hand side.

Compiled: the column-wise LDL^T below. Interpreted: LAPACK through scipy. A test compares them.
"""

import numpy as np

from lowfi.jit import is_compiled, kernel

from .arrays import Array


@kernel
def ldl_solve(band: Array, b: Array) -> bool:
    """Solve A x = b with A[i, j] = band[j, i - j], i >= j (lower band, column by column); b (n,) becomes x.

    Overwrites ``band`` with the factors L (unit) and D. Returns False where A is not positive definite.
    """
    n, width = band.shape
    column = np.empty(width)  # a copy: the compiler then knows that the updates below do not change it
    for j in range(n):
        pivot = band[j, 0]
        if not pivot > 0.0:
            return False
        m = min(width, n - j)
        inverse = 1.0 / pivot
        for i in range(1, m):
            column[i] = band[j, i]
            band[j, i] = column[i] * inverse
        for k in range(1, m):
            f = column[k] * inverse
            if f != 0.0:
                for i in range(m - k):
                    band[j + k, i] -= f * column[k + i]
        x = b[j]
        for i in range(1, m):
            b[j + i] -= band[j, i] * x
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
