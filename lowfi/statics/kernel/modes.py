"""Conjugate gradients on I + S G S^T with the bodies' softest modes taken exactly.

G = U U^T + rest: U the few modes of the bodies that are softer than a contact, the rest is small beside the contacts, so
that P = I + (S U)(S U)^T is nearly the matrix itself and each step gains more than a digit.
"""

import numpy as np

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.records import Array, Bodies

from .coupling import apply_rows, body_motion, cholesky_lower, forces_of_rows, triangular

#: Most steps before the matrix is factored whole instead: then a contact is far stiffer than the modes were chosen for.
LIMIT = 60


@kernel
def soft_rows(modes: tuple[Array, Array], S: Array, counts: Array, starts: Array, W: Array) -> None:
    """W (q, r) = S U: modes = (U first, U second), of the first and second half of the flanks (one body: of all)."""
    first, second = modes
    balls, _, d = S.shape
    r, r_second = first.shape[1], second.shape[1]
    h = d if second.shape[0] == 0 else d // 2
    W[:] = 0.0
    for i in range(balls):
        for p in range(counts[i]):
            row = starts[i] + p
            for a in range(h):
                s = S[i, p, a]
                for m in range(r):
                    W[row, m] += s * first[h * i + a, m]
            for a in range(d - h):
                s = S[i, p, h + a]
                for m in range(r_second):
                    W[row, r + m] += s * second[h * i + a, m]


@kernel
def soften(W: Array, C: Array, b: Array) -> None:
    """Overwrite b (q,) by P^-1 b = b - W (C C^T)^-1 W^T b, C the Cholesky factor of I + W^T W."""
    x = np.dot(b, W)
    triangular(C, x)
    b -= np.dot(W, x)


@kernel
def soft_factor(modes: tuple[Array, Array], S: Array, counts: Array, starts: Array, W: Array, C: Array) -> bool:
    """Fill W = S U and the factor C (r, r); False where it is not positive (numbers out of range)."""
    soft_rows(modes, S, counts, starts, W)
    C[:, :] = np.dot(W.T, W) + np.eye(C.shape[0])
    return cholesky_lower(C)


@kernel
def soft_border(W: Array, C: Array, B: Array, Z: Array, hold: float, schur: Array) -> bool:
    """Z (k, q) = P^-1 B and the factor of B P^-1 B^T + hold, for rows B (k, q) of the free motions."""
    k = B.shape[0]
    for c in range(k):
        Z[c] = B[c]
        soften(W, C, Z[c])
    schur[:, :] = np.dot(B, Z.T) + hold * np.eye(k)
    return cholesky_lower(schur)


@kernel
def near(W: Array, C: Array, B: Array, Z: Array, schur: Array, target: Array, u: Array, a: Array) -> None:
    """Solve P u - B^T a = u (given), B u + hold a = target (k,): overwrites u, fills a (k,)."""
    soften(W, C, u)
    if B.shape[0]:
        a[:] = target - np.dot(B, u)
        triangular(schur, a)
        u += np.dot(a, Z)


@kernel
def coupled(
    bodies: Bodies,
    S: Array,
    counts: Array,
    starts: Array,
    B: Array,
    u: Array,
    a: Array,
    work: tuple[Array, Array],
    out: Array,
) -> None:
    """out (q,) = (I + S G S^T) u - B^T a; work: two arrays (N, d)."""
    force, motion = work
    force[:] = 0.0
    forces_of_rows(S, counts, starts, u, force)
    body_motion(bodies, force, motion)
    apply_rows(S, counts, starts, motion, out)
    out[:] = u - out
    if B.shape[0]:
        out -= np.dot(a, B)


@kernel
def gradients(
    bodies: Bodies,
    S: Array,
    counts: Array,
    starts: Array,
    soft: tuple[Array, Array],
    target: Array,
    hold: float,
    wanted: float,
    u: Array,
    a: Array,
) -> int:
    """Solve (I + S G S^T) u - B^T a = u (given), B u + hold a = target, B = (S R)^T of the free motions R.

    Conjugate gradients in the space that keeps the second equation, preconditioned by P (W and its factor in ``soft``).
    wanted: residual over that of u = 0, in the norm of P^-1. Returns the number of steps, -1 where that is not reached.
    """
    W, C = soft
    R = bodies.R
    q, k = u.shape[0], R.shape[2]
    B, Z, schur = np.empty((k, q)), np.empty((k, q)), np.zeros((k, k))
    for c in range(k):
        apply_rows(S, counts, starts, R[:, :, c], B[c])
    if k and not soft_border(W, C, B, Z, hold, schur):
        return -1
    work = (np.empty(R.shape[:2]), np.empty(R.shape[:2]))
    residual, image, none = u.copy(), np.empty(q), np.zeros(k)
    near(W, C, B, Z, schur, target, u, a)
    coupled(bodies, S, counts, starts, B, u, a, work, image)
    start = np.sum(u * image)
    if k:
        start += np.dot(a, np.dot(B, u))
    residual -= image
    z, da = residual.copy(), np.zeros(k)
    near(W, C, B, Z, schur, none, z, da)
    p, pa = z.copy(), da.copy()
    norm = np.sum(residual * z)
    for step in range(LIMIT):
        if abs(norm) <= wanted * wanted * start:
            return step
        if not norm > 0.0:  # round-off, or numbers out of range
            return -1
        coupled(bodies, S, counts, starts, B, p, pa, work, image)
        t = norm / np.sum(p * image)
        u += t * p
        a += t * pa
        residual -= t * image
        z[:] = residual
        near(W, C, B, Z, schur, none, z, da)
        new = np.sum(residual * z)
        p, pa = z + new / norm * p, da + new / norm * pa
        norm = new
    return -1
