"""Modes of elastic bodies at either end of their spectrum: those softer than a contact, which a solver must hold exactly
(the rest it may iterate on), and those of negative compliance, which no body has."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rollbench.lowfi.threads import one_thread
from rollbench.meshes.arrays import Array

#: A mode is soft from this fraction of a contact's compliance on.
SOFT = 0.3
#: Largest compliance whose modes are all found at once, in time that grows as its cube; of a larger one only those wanted.
WHOLE = 1000
#: Of a larger one: vectors that a search for soft modes begins with, over the number of motions, and how often the
#: compliance is applied to them.
SHARE, DEPTH = 1.0 / 64.0, 5
#: The same of a search for negative modes, by the inverse of what is positive by this shift, over the mean on the diagonal.
FEW, INVERSES, SHIFT = 16, 20, 3e-5


def soft_modes(G: Array, contact: float) -> Array:
    """U ``(n, r)`` with U U^T the part of G ``(n, n)`` [m/N] in modes softer than ``SOFT`` of a contact [m/N]; from more
    than ``WHOLE`` motions on those close to that limit are mixed with stiffer ones."""
    if G.size == 0:
        return np.zeros(G.shape)
    return softer(np.linalg.eigh(G) if len(G) <= WHOLE else _largest(G, SOFT * contact), contact)


def softer(spectrum: tuple[Array, Array], contact: float) -> Array:
    """The same by eigenvalues and eigenvectors of G, which hold the soft ones."""
    values, vectors = spectrum
    soft = values > SOFT * contact
    return np.ascontiguousarray(vectors[:, soft] * np.sqrt(values[soft]))


def _largest(G: Array, limit: float) -> tuple[Array, Array]:
    """Eigenvalues of G, of which those above a limit are found, and vectors."""
    count = int(SHARE * len(G))
    while count * DEPTH < len(G):
        values, vectors = _ritz(G, lambda x: G @ x, count, DEPTH)
        if 2 * (values > limit).sum() < values.size:
            return values, vectors
        count *= 2
    return np.linalg.eigh(G)


def _ritz(G: Array, apply: Callable[[Array], Array], count: int, depth: int) -> tuple[Array, Array]:
    """Eigenvalues and vectors of G within what an operator makes of some vectors when it is applied to them ``depth`` times
    (a block Krylov space): those at the far end of the operator's spectrum are those of G."""
    basis = np.linalg.qr(np.random.default_rng(0).standard_normal((len(G), count)))[0]
    for _ in range(depth - 1):
        applied = apply(basis[:, -count:])
        for _ in range(2):  # once leaves round-off of what is taken away
            applied -= basis @ (basis.T @ applied)
        basis = np.hstack([basis, np.linalg.qr(applied)[0]])
    values, turn = np.linalg.eigh(basis.T @ (G @ basis))
    return values, basis @ turn


def negative_part(G: Array) -> tuple[Array, float]:
    """The part ``(n, n)`` of a symmetric G in modes of negative eigenvalues, and the least eigenvalue."""
    values, vectors = np.linalg.eigh(G) if len(G) <= WHOLE else _smallest(G)
    below = values < 0.0
    return (vectors[:, below] * values[below]) @ vectors[:, below].T, float(values[0])


def _smallest(G: Array) -> tuple[Array, Array]:
    """Eigenvalues of G, of which those below zero are found, and vectors."""
    from scipy.linalg import cho_factor, cho_solve

    diagonal, count, shift = np.arange(len(G)), FEW, SHIFT * float(np.trace(G)) / len(G)
    with one_thread():  # scipy has a library of its own
        while True:
            shifted = G.copy()
            shifted[diagonal, diagonal] += shift
            try:
                factor = cho_factor(shifted, lower=True, overwrite_a=True)  # raises ValueError where G is not finite
                break
            except np.linalg.LinAlgError:
                shift *= 3.0
        while count * INVERSES < len(G):
            values, vectors = _ritz(G, lambda x: np.asarray(cho_solve(factor, x, check_finite=False)), count, INVERSES)
            if 2 * (values < 0.0).sum() < count:
                return values, vectors
            count *= 2
    return np.linalg.eigh(G)
