"""Modes of elastic bodies that are softer than a contact: what a solver must hold exactly, the rest it may iterate on."""

from __future__ import annotations

import numpy as np

from rollbench.meshes.arrays import Array

#: A mode is soft from this fraction of a contact's compliance on.
SOFT = 0.3


def soft_modes(G: Array, contact: float) -> Array:
    """U ``(n, r)`` with U U^T the part of G ``(n, n)`` [m/N] in modes softer than ``SOFT`` of a contact [m/N]."""
    if G.size == 0:
        return np.zeros(G.shape)
    return softer(np.linalg.eigh(G), contact)


def softer(spectrum: tuple[Array, Array], contact: float) -> Array:
    """The same by the eigenvalues ``(n,)`` and eigenvectors ``(n, n)`` of G."""
    values, vectors = spectrum
    soft = values > SOFT * contact
    return np.ascontiguousarray(vectors[:, soft] * np.sqrt(values[soft]))
