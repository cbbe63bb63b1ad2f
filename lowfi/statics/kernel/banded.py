"""Symmetric positive definite banded systems, A[i, j] = band[j, i - j] for i >= j: the lower band, column by column.

Compiled: the LDL^T below. A band of 12 is that of a chain: nodes of six unknowns, each coupled to the next one only; what
the band has room for beyond is taken as zero. Its D has blocks of three, the displacements and the rotations of a node: a
third of the divisions and of the passes over the rows. Interpreted: LAPACK through scipy. A test compares them.
"""

import numpy as np

from rollbench.lowfi.jit import is_compiled, kernel, summing
from rollbench.lowfi.statics.records import Array

#: Width of the band of a chain of nodes.
CHAIN = 12


@kernel
def eliminate(band: Array, column: Array, j: int, m: int) -> None:
    """Eliminate unknown j from the m - 1 that follow it."""
    inverse = 1.0 / band[j, 0]
    for i in range(1, m):
        column[i] = band[j, i]  # a copy: the compiler then knows that the updates below do not change it
        band[j, i] = column[i] * inverse
    band[j, 0] = inverse
    for k in range(1, m):
        f = column[k] * inverse
        if f != 0.0:
            for i in range(m - k):
                band[j + k, i] -= f * column[k + i]


@kernel
def eliminate_three(band: Array, u: Array, v: Array, w: Array, j: int, m: int) -> bool:
    """Eliminate the unknowns j to j + 2 from the m - 3 that follow; u, v, w (12,): room. False where their block is not
    positive definite."""
    a, b, c, d, e, f = band[j, 0], band[j, 1], band[j, 2], band[j + 1, 0], band[j + 1, 1], band[j + 2, 0]
    xx, xy, xz = d * f - e * e, c * e - b * f, b * e - c * d
    yy, yz, zz = a * f - c * c, b * c - a * e, a * d - b * b
    det = a * xx + b * xy + c * xz
    if not (a > 0.0 and zz > 0.0 and det > 0.0):
        return False
    r = 1.0 / det
    xx, xy, xz, yy, yz, zz = xx * r, xy * r, xz * r, yy * r, yz * r, zz * r
    for i in range(3, m):
        x, y, z = band[j, i], band[j + 1, i - 1], band[j + 2, i - 2]
        u[i], v[i], w[i] = x, y, z  # copies: the compiler then knows that the updates below do not change them
        band[j, i] = xx * x + xy * y + xz * z
        band[j + 1, i - 1] = xy * x + yy * y + yz * z
        band[j + 2, i - 2] = xz * x + yz * y + zz * z
    band[j, 0], band[j, 1], band[j, 2], band[j + 1, 0], band[j + 1, 1], band[j + 2, 0] = xx, xy, xz, yy, yz, zz
    for k in range(3, m):
        x, y, z = band[j, k], band[j + 1, k - 1], band[j + 2, k - 2]
        for i in range(m - k):
            band[j + k, i] -= x * u[k + i] + y * v[k + i] + z * w[k + i]
    return True


@kernel
def factor_chain(band: Array) -> bool:
    """``ldl_factor`` of a chain of nodes."""
    u, v, w = np.empty(12), np.empty(12), np.empty(12)
    last = band.shape[0] - 6
    for j in range(0, last, 6):  # lengths by their number: the compiler then unrolls the loops
        if not (eliminate_three(band, u, v, w, j, 12) and eliminate_three(band, u, v, w, j + 3, 9)):
            return False
    return eliminate_three(band, u, v, w, last, 6) and eliminate_three(band, u, v, w, last + 3, 3)


@kernel
def ldl_factor(band: Array) -> bool:
    """Overwrite ``band`` (n, w) with the factors L (unit) and 1/D; False where the matrix is not positive definite."""
    n, width = band.shape
    if width == CHAIN:
        return factor_chain(band)
    column = np.empty(width)
    for j in range(n):
        if not band[j, 0] > 0.0:
            return False
        eliminate(band, column, j, min(width, n - j))
    return True


@kernel
def forward_three(band: Array, b: Array, j: int, m: int) -> None:
    """Take the unknowns j to j + 2 from the m - 3 that follow them."""
    x, y, z = b[j], b[j + 1], b[j + 2]
    for i in range(3, m):
        b[j + i] -= band[j, i] * x + band[j + 1, i - 1] * y + band[j + 2, i - 2] * z


@kernel
def backward_three(band: Array, b: Array, j: int, m: int) -> None:
    """Solve for the unknowns j to j + 2 by the m - 3 that follow them, of which those found last come last."""
    p, q, r, s, t, u, half = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, (m + 3) // 2
    for i in range(half, m):
        p += band[j, i] * b[j + i]
        q += band[j + 1, i - 1] * b[j + i]
        r += band[j + 2, i - 2] * b[j + i]
    for i in range(3, half):
        s += band[j, i] * b[j + i]
        t += band[j + 1, i - 1] * b[j + i]
        u += band[j + 2, i - 2] * b[j + i]
    x, y, z = b[j], b[j + 1], b[j + 2]
    b[j] = x * band[j, 0] + y * band[j, 1] + z * band[j, 2] - (p + s)
    b[j + 1] = x * band[j, 1] + y * band[j + 1, 0] + z * band[j + 1, 1] - (q + t)
    b[j + 2] = x * band[j, 2] + y * band[j + 1, 1] + z * band[j + 2, 0] - (r + u)


@kernel
def substitute_chain(band: Array, b: Array) -> None:
    """``ldl_substitute`` of a chain of nodes."""
    last = band.shape[0] - 6
    for j in range(0, last, 6):
        forward_three(band, b, j, 12)
        forward_three(band, b, j + 3, 9)
    forward_three(band, b, last, 6)
    backward_three(band, b, last + 3, 3)
    backward_three(band, b, last, 6)
    for j in range(last - 6, -1, -6):
        backward_three(band, b, j + 3, 9)
        backward_three(band, b, j, 12)


@kernel
def take_two(y: Array, first: Array, second: Array, a: float, b: float) -> None:
    """Take a first + b second from y, all of a length."""
    for i in range(y.size):
        y[i] -= first[i] * a + second[i] * b


@summing
def two_products(first: Array, second: Array, y: Array) -> tuple[float, float]:
    """Products of two rows with y, all of a length."""
    p, q = 0.0, 0.0
    for i in range(y.size):
        p += first[i] * y[i]
        q += second[i] * y[i]
    return p, q


@kernel
def ldl_substitute(band: Array, b: Array) -> None:
    """Overwrite b (n,) by the solution, from the factors."""
    n, width = band.shape
    if width == CHAIN:
        substitute_chain(band, b)
        return
    pairs = n - n % 2  # unknowns by twos: half as many passes over those that follow
    for j in range(0, pairs, 2):
        m = min(width, n - j)
        b[j + 1] -= band[j, 1] * b[j]
        take_two(b[j + 2 : j + m], band[j, 2:m], band[j + 1, 1 : m - 1], b[j], b[j + 1])
        if j + width < n:
            b[j + width] -= band[j + 1, width - 1] * b[j + 1]
    for j in range(pairs, n):
        b[j] *= band[j, 0]
    for j in range(pairs - 2, -1, -2):
        m = min(width, n - j)
        p, q = two_products(band[j, 2:m], band[j + 1, 1 : m - 1], b[j + 2 : j + m])
        if j + width < n:
            q += band[j + 1, width - 1] * b[j + width]
        b[j + 1] = b[j + 1] * band[j + 1, 0] - q
        b[j] = b[j] * band[j, 0] - p - band[j, 1] * b[j + 1]


@kernel
def take(y: Array, x: Array, f: float) -> None:
    """Take f x from y."""
    for i in range(y.size):
        y[i] -= f * x[i]


@kernel
def ldl_substitute_columns(band: Array, Y: Array) -> None:
    """``ldl_substitute`` of the columns of Y (n, k), side by side where the band is wide."""
    n, width = band.shape
    if width == CHAIN:
        rows = Y.T.copy()
        for row in rows:
            substitute_chain(band, row)
        Y[:, :] = rows.T
        return
    for j in range(n):
        for i in range(1, min(width, n - j)):
            if band[j, i] != 0.0:
                take(Y[j + i], Y[j], band[j, i])
    for j in range(n - 1, -1, -1):
        for k in range(Y.shape[1]):
            Y[j, k] *= band[j, 0]
        for i in range(1, min(width, n - j)):
            if band[j, i] != 0.0:
                take(Y[j], Y[j + i], band[j, i])


def _lapack_factor(band: Array) -> bool:
    from scipy.linalg import LinAlgError, cholesky_banded

    try:
        band[:] = cholesky_banded(band.T, lower=True, check_finite=False).T
    except LinAlgError:
        return False
    return True


def _lapack_substitute(band: Array, b: Array) -> None:
    from scipy.linalg import cho_solve_banded

    b[:] = cho_solve_banded((band.T, True), b, check_finite=False)


def _lapack_substitute_columns(band: Array, Y: Array) -> None:
    from scipy.linalg import cho_solve_banded

    Y[:] = cho_solve_banded((band.T, True), Y, check_finite=False)


factor_band = ldl_factor if is_compiled(__name__) else _lapack_factor
substitute_band = ldl_substitute if is_compiled(__name__) else _lapack_substitute
substitute_columns = ldl_substitute_columns if is_compiled(__name__) else _lapack_substitute_columns
