"""Linear algebra of balls that are coupled through elastic bodies: I + S G S^T, S the rows of all balls' stiffness."""

import numpy as np

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import Array, BallRows, Bodies


@kernel
def body_motion(bodies: Bodies, phi: Array, out: Array) -> None:
    """out (N, d) = G phi: first and second body act on the first and second half of the flanks (one body: on all)."""
    first, second = bodies.first, bodies.second
    n, d = phi.shape
    if second.shape[0] == 0:
        out.ravel()[:] = np.dot(first, phi.ravel())
        return
    h = d // 2
    out[:, :h] = np.dot(first, np.ascontiguousarray(phi[:, :h]).ravel()).reshape(n, h)
    out[:, h:] = np.dot(second, np.ascontiguousarray(phi[:, h:]).ravel()).reshape(n, h)


@kernel
def couple(bodies: Bodies, rows: BallRows, M: Array) -> None:
    """M (q, q) = I + S G S^T."""
    half = rows.S.shape[2] // (2 if bodies.second.shape[0] else 1)
    M[:] = np.eye(M.shape[0])
    add_body(bodies.first, rows, 0, half, M)
    if bodies.second.shape[0]:
        add_body(bodies.second, rows, half, half, M)


@kernel
def add_body(G: Array, rows: BallRows, first: int, width: int, M: Array) -> None:
    """Add S G S^T of a body whose flanks' motions are ``width`` of each ball's, from ``first`` on."""
    S, counts, starts = rows
    moved = np.empty((M.shape[0], G.shape[0]))
    for i in range(S.shape[0]):
        of_ball = np.ascontiguousarray(S[i, : counts[i], first : first + width])
        moved[starts[i] : starts[i] + counts[i]] = np.dot(of_ball, G[width * i : width * (i + 1)])
    for i in range(S.shape[0]):
        of_ball = np.ascontiguousarray(S[i, : counts[i], first : first + width].T)
        by_ball = np.ascontiguousarray(moved[:, width * i : width * (i + 1)])
        M[:, starts[i] : starts[i] + counts[i]] += np.dot(by_ball, of_ball)


@kernel
def cholesky_lower(M: Array) -> bool:
    """Overwrite M (its lower triangle given) by its Cholesky factor (LAPACK); False where M is not positive definite."""
    try:
        M[:, :] = np.linalg.cholesky(M)
    except Exception:  # the only one that numba can name; LinAlgError is all that a finite matrix can raise
        return False
    return True


@kernel
def triangular(M: Array, b: Array) -> None:
    """Overwrite b by (L L^T)^-1 b, L in the lower triangle of M."""
    for j in range(b.shape[0]):
        b[j] = (b[j] - np.sum(M[j, :j] * b[:j])) / M[j, j]
    for j in range(b.shape[0] - 1, -1, -1):
        b[j] /= M[j, j]
        b[:j] -= b[j] * M[j, :j]


@kernel
def apply_rows(rows: BallRows, x: Array, out: Array) -> None:
    """out (q,) = S x for motions x (N, d)."""
    S, counts, starts = rows
    for i in range(S.shape[0]):
        for p in range(counts[i]):
            out[starts[i] + p] = np.sum(S[i, p] * x[i])


@kernel
def forces_of_rows(rows: BallRows, u: Array, out: Array) -> None:
    """out (N, d) -= S^T u."""
    S, counts, starts = rows
    for i in range(S.shape[0]):
        for p in range(counts[i]):
            out[i] -= S[i, p] * u[starts[i] + p]


@kernel
def border(R: Array, rows: BallRows, L: Array, u: Array, target: Array, hold: float, out: Array) -> bool:
    """Amplitudes a (k,) of the free motions R (N, d, k) with (S R)^T u = target (k,), and u (q,) with them.

    u holds M^-1 b on entry and M^-1 (b + S R a) on return, L the factor of M; hold [N/m]: stiffness added to the free
    motions. Fills out with a; False where a free motion is not held.
    """
    k, total = R.shape[2], u.shape[0]
    plain, Z = np.empty((k, total)), np.empty((k, total))
    for c in range(k):
        apply_rows(rows, R[:, :, c], plain[c])
        Z[c] = plain[c]
        triangular(L, Z[c])
    schur = np.dot(plain, Z.T) + hold * np.eye(k)
    if not cholesky_lower(schur):
        return False
    out[:] = target - np.dot(plain, u)
    triangular(schur, out)
    u += np.dot(out, Z)
    return True
