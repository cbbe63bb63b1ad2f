"""Linear algebra of balls that are coupled through elastic bodies: I + S G S^T, S the rows of all balls' stiffness."""

import numpy as np

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.records import Array, Bodies


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
def couple(bodies: Bodies, S: Array, counts: Array, starts: Array, M: Array) -> None:
    """Lower triangle of M (q, q) = I + S G S^T."""
    first, second = bodies.first, bodies.second
    balls, _, d = S.shape
    if d == 2:
        couple_pairs(first, S, counts, starts, M)
        return
    h = d if second.shape[0] == 0 else d // 2
    product = np.empty((S.shape[1], d))
    for i in range(balls):
        for j in range(i + 1):
            for p in range(counts[i]):
                for b in range(h):
                    total = 0.0
                    for a in range(h):
                        total += S[i, p, a] * first[h * i + a, h * j + b]
                    product[p, b] = total
                for b in range(d - h):
                    total = 0.0
                    for a in range(h):
                        total += S[i, p, h + a] * second[h * i + a, h * j + b]
                    product[p, h + b] = total
            for p in range(counts[i]):
                for r in range(counts[j]):
                    total = 0.0
                    for b in range(d):
                        total += product[p, b] * S[j, r, b]
                    M[starts[i] + p, starts[j] + r] = total
    for k in range(M.shape[0]):
        M[k, k] += 1.0


@kernel
def couple_pairs(G: Array, S: Array, counts: Array, starts: Array, M: Array) -> None:
    """The same for balls between two flanks: up to two rows of two entries each."""
    for i in range(S.shape[0]):
        for p in range(counts[i]):
            row = starts[i] + p
            a, b = S[i, p, 0], S[i, p, 1]
            for j in range(i + 1):
                x = a * G[2 * i, 2 * j] + b * G[2 * i + 1, 2 * j]
                z = a * G[2 * i, 2 * j + 1] + b * G[2 * i + 1, 2 * j + 1]
                for r in range(counts[j]):
                    M[row, starts[j] + r] = x * S[j, r, 0] + z * S[j, r, 1]
            M[row, row] += 1.0


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
    n = b.shape[0]
    for j in range(n):
        v = b[j]
        for k in range(j):
            v -= M[j, k] * b[k]
        b[j] = v / M[j, j]
    for j in range(n - 1, -1, -1):
        b[j] /= M[j, j]
        v = b[j]
        for k in range(j):
            b[k] -= v * M[j, k]


@kernel
def apply_rows(S: Array, counts: Array, starts: Array, x: Array, out: Array) -> None:
    """out (q,) = S x for motions x (N, d)."""
    for i in range(S.shape[0]):
        for p in range(counts[i]):
            total = 0.0
            for a in range(S.shape[2]):
                total += S[i, p, a] * x[i, a]
            out[starts[i] + p] = total


@kernel
def forces_of_rows(S: Array, counts: Array, starts: Array, u: Array, out: Array) -> None:
    """out (N, d) -= S^T u."""
    for i in range(S.shape[0]):
        for p in range(counts[i]):
            for a in range(S.shape[2]):
                out[i, a] -= S[i, p, a] * u[starts[i] + p]


@kernel
def border(
    R: Array, S: Array, counts: Array, starts: Array, L: Array, u: Array, target: Array, hold: float, out: Array
) -> bool:
    """Amplitudes a (k,) of the free motions R (N, d, k) with (S R)^T u = target (k,), and u (q,) with them.

    u holds M^-1 b on entry and M^-1 (b + S R a) on return, L the factor of M; hold [N/m]: stiffness added to the free
    motions. Fills out with a; False where a free motion is not held.
    """
    k, total = R.shape[2], u.shape[0]
    plain, Z = np.empty((k, total)), np.empty((k, total))
    schur, rhs = np.zeros((k, k)), np.empty(k)
    for c in range(k):
        apply_rows(S, counts, starts, R[:, :, c], plain[c])
        Z[c] = plain[c]
        triangular(L, Z[c])
        rhs[c] = target[c] - np.sum(plain[c] * u)
    for c in range(k):
        for e in range(k):
            schur[c, e] = np.sum(plain[c] * Z[e])
        schur[c, c] += hold
    if not cholesky_lower(schur):
        return False
    triangular(schur, rhs)
    for c in range(k):
        out[c] = rhs[c]
        for i in range(total):
            u[i] += rhs[c] * Z[c, i]
    return True
