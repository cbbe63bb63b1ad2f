"""Solution of a symmetric positive definite banded system, overwriting its right-hand side.

Compiled: the column-wise Cholesky below. Interpreted: LAPACK through scipy. A test compares them.
"""

from math import sqrt

from lowfi.jit import is_compiled, kernel


@kernel
def cholesky_solve(band, b):  # type: ignore[no-untyped-def]
    """Solve A x = b with A[i, j] = band[j, i - j], i >= j (lower band, column by column); b (n,) becomes x.

    Overwrites ``band`` with the factor. Returns False where A is not positive definite.
    """
    n, width = band.shape
    for j in range(n):
        pivot = band[j, 0]
        if not pivot > 0.0:
            return False
        root = sqrt(pivot)
        band[j, 0] = root
        m = min(width, n - j)
        inv = 1.0 / root
        for i in range(1, m):
            band[j, i] *= inv
        for k in range(1, m):
            f = band[j, k]
            if f != 0.0:
                for i in range(m - k):
                    band[j + k, i] -= f * band[j, k + i]
        b[j] *= inv
        x = b[j]
        for i in range(1, m):
            b[j + i] -= band[j, i] * x
    for j in range(n - 1, -1, -1):
        m = min(width, n - j)
        x = b[j]
        for i in range(1, m):
            x -= band[j, i] * b[j + i]
        b[j] = x / band[j, 0]
    return True


def _lapack_solve(band, b):  # type: ignore[no-untyped-def]
    from scipy.linalg import LinAlgError, solveh_banded

    try:
        b[:] = solveh_banded(band.T, b, lower=True, check_finite=False)
    except LinAlgError:
        return False
    return True


solve_banded = cholesky_solve if is_compiled(__name__) else _lapack_solve
