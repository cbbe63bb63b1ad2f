"""Modes of elastic bodies at either end of their spectrum: those softer than a contact, which a solver must hold exactly
(the rest it may iterate on), and those of negative compliance, which no body has."""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.threads import one_thread
from rollbench.meshes.arrays import Array

#: A mode is soft from this fraction of a contact's compliance on.
SOFT = 0.3
#: Largest compliance whose modes are all found at once, in time that grows as its cube; of a larger one only those wanted.
WHOLE = 1000
#: Of a larger one: share of its modes that are looked at first, and how often the compliance is applied to them.
SHARE, PASSES = 1.0 / 16.0, 4
#: Negative modes looked for first, and shift that makes a compliance positive, over its mean on the diagonal.
FEW, SHIFT = 4, 3e-5


def soft_modes(G: Array, contact: float) -> Array:
    """U ``(n, r)`` with U U^T the part of G ``(n, n)`` [m/N] in modes softer than ``SOFT`` of a contact [m/N]; from more
    than ``WHOLE`` motions on those close to that limit are mixed with stiffer ones."""
    if G.size == 0:
        return np.zeros(G.shape)
    values, vectors = np.linalg.eigh(G) if len(G) <= WHOLE else _largest(G, SOFT * contact)
    soft = values > SOFT * contact
    return np.ascontiguousarray(vectors[:, soft] * np.sqrt(values[soft]))


def _largest(G: Array, limit: float) -> tuple[Array, Array]:
    """Eigenvalues and vectors of G down to a limit or below it, by iteration of a subspace."""
    draw, count = np.random.default_rng(0), int(SHARE * len(G))
    while True:
        V = draw.standard_normal((len(G), count))
        for _ in range(PASSES):
            V = np.linalg.qr(G @ V)[0]
        values, turn = np.linalg.eigh(V.T @ (G @ V))
        if values[0] <= limit or 2 * count > len(G):
            return values, V @ turn
        count *= 2


def negative_part(G: Array) -> tuple[Array, float]:
    """The part ``(n, n)`` of a symmetric G in modes of negative eigenvalues, and the least eigenvalue or one above it that
    is not negative. Raises LinAlgError where they are not found."""
    values, vectors = np.linalg.eigh(G) if len(G) <= WHOLE else _smallest(G)
    below = values < 0.0
    return (vectors[:, below] * values[below]) @ vectors[:, below].T, float(values.min())


def _smallest(G: Array) -> tuple[Array, Array]:
    """Eigenvalues and vectors of G from below up to zero or beyond: the largest of the inverse of G, shifted to be positive."""
    from scipy.linalg import cho_factor, cho_solve
    from scipy.sparse.linalg import LinearOperator, eigsh

    each, count, shift = np.arange(len(G)), FEW, SHIFT * float(np.trace(G)) / len(G)
    with one_thread():  # scipy's library too
        while True:
            shifted = G.copy()
            shifted[each, each] += shift
            try:
                factor = cho_factor(shifted, lower=True, overwrite_a=True, check_finite=False)
                break
            except np.linalg.LinAlgError:
                shift *= 3.0
        inverse = LinearOperator(G.shape, matvec=lambda x: cho_solve(factor, x, check_finite=False), dtype=float)
        start = np.random.default_rng(0).standard_normal(len(G))
        while count < len(G) // 8:
            over, vectors = eigsh(inverse, count, which="LA", v0=start)
            values = 1.0 / over - shift
            if values.max() >= 0.0:
                return values, vectors
            count *= 2
        return np.linalg.eigh(G)
