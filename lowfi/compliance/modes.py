"""Modes of negative compliance, which no body has."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rollbench.meshes.arrays import Array

#: Largest compliance whose modes are all found at once, in time that grows as its cube; of a larger one only those wanted.
WHOLE = 1000
#: Of a larger one: vectors that a search for negative modes begins with, how often the inverse of what is positive by a
#: shift is applied to them, and that shift over the mean on the diagonal.
FEW, INVERSES, SHIFT = 16, 20, 3e-5


def negative_part(G: Array) -> tuple[Array, float]:
    """The part ``(n, n)`` of a symmetric G in modes of negative eigenvalues, and the least eigenvalue."""
    values, vectors = np.linalg.eigh(G) if len(G) <= WHOLE else _smallest(G)
    below = values < 0.0
    return (vectors[:, below] * values[below]) @ vectors[:, below].T, float(values[0])


def _smallest(G: Array) -> tuple[Array, Array]:
    """Eigenvalues of G, of which those below zero are found, and vectors."""
    from scipy.linalg import cho_factor, cho_solve

    diagonal, count, shift = np.arange(len(G)), FEW, SHIFT * float(np.trace(G)) / len(G)
    while True:
        shifted = G.copy()
        shifted[diagonal, diagonal] += shift
        try:
            factor = cho_factor(shifted, lower=True, overwrite_a=True)  # raises ValueError where G is not finite
            break
        except np.linalg.LinAlgError:
            shift *= 3.0
    while count * INVERSES < len(G):
        values, vectors = _ritz(G, lambda x: np.asarray(cho_solve(factor, x, check_finite=False)), count)
        if 2 * (values < 0.0).sum() < count:
            return values, vectors
        count *= 2
    return np.linalg.eigh(G)


def _ritz(G: Array, apply: Callable[[Array], Array], count: int) -> tuple[Array, Array]:
    """Eigenvalues and vectors of G within what an operator makes of some vectors when it is applied to them ``INVERSES``
    times (a block Krylov space): those at the far end of the operator's spectrum are those of G."""
    basis = np.linalg.qr(np.random.default_rng(0).standard_normal((len(G), count)))[0]
    for _ in range(INVERSES - 1):
        applied = apply(basis[:, -count:])
        for _ in range(2):  # once leaves round-off of what is taken away
            applied -= basis @ (basis.T @ applied)
        basis = np.hstack([basis, np.linalg.qr(applied)[0]])
    values, turn = np.linalg.eigh(basis.T @ (G @ basis))
    return values, basis @ turn
