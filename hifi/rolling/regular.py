"""What finite bodies add to a half space's displacements in a contact: a smooth kernel in polynomials.

The displacement at x by a force at x' on a finite body is the half space's, singular where they meet, plus a part that
varies slowly over a contact,

    G(x, x') = G_half(x, x') + Phi(x) M Phi(x')^T,

Phi the monomials of x and y for each of the three directions. Rows: displacement of the ball past the groove along x and y,
and the parting along the normal; columns: forces on the ball along x and y, and normal force, as in
`hifi.rolling.patch.influence`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rollbench.meshes.arrays import Array


def exponents(degree: int) -> Array:
    """Powers of x and y ``(k, 2)`` of all monomials up to a degree."""
    return np.array([(i, n - i) for n in range(degree + 1) for i in range(n, -1, -1)])


def monomials(at: Array, scale: tuple[float, float], degree: int) -> Array:
    """Values ``(n, k)`` at ``(n, 2)`` [m], coordinates over ``scale`` [m]."""
    unit = at / np.array(scale)
    return np.asarray(np.prod(unit[:, None] ** exponents(degree), axis=2))


@dataclass(frozen=True, eq=False)
class Regular:
    """M ``(3 k, 3 k)`` [m/N], directions slowest; scale [m] and degree of the monomials."""

    M: Array
    scale: tuple[float, float]
    degree: int

    def __add__(self, other: Regular) -> Regular:
        """The sum of two bodies. Raises ValueError for other monomials."""
        if (self.scale, self.degree) != (other.scale, other.degree):
            raise ValueError("kernels of two bodies need the same monomials")
        return replace(self, M=self.M + other.M)

    @cached_property
    def turned(self) -> Regular:
        """The same seen from axes turned by 180 degrees about the normal."""
        odd = (-1.0) ** exponents(self.degree).sum(axis=1)
        signs = np.concatenate([-odd, -odd, odd])
        return replace(self, M=self.M * np.outer(signs, signs))

    @cached_property
    def even(self) -> Regular:
        """The mean with its mirror image in x: for bodies that are given no sense of rolling."""
        odd = (-1.0) ** exponents(self.degree)[:, 0]
        signs = np.concatenate([-odd, odd, odd])
        return replace(self, M=0.5 * (self.M + self.M * np.outer(signs, signs)))

    def _part(self, rows: slice, columns: slice) -> Array:
        k = len(self.M) // 3
        return self.M[rows.start * k : rows.stop * k, columns.start * k : columns.stop * k]

    def block(self, at: Array, rows: slice, columns: slice, shift: float = 0.0) -> Array:
        """Displacements ``(r n, c n)`` [m/N] at ``at + (shift, 0)`` by unit forces at ``at`` ``(n, 2)`` [m]; rows, columns:
        directions, slowest."""
        to = monomials(at + np.array([shift, 0.0]), self.scale, self.degree)
        by = monomials(at, self.scale, self.degree)
        left = np.kron(np.eye(rows.stop - rows.start), to)
        right = np.kron(np.eye(columns.stop - columns.start), by)
        return np.asarray(left @ self._part(rows, columns) @ right.T)

    def slope(self, at: Array, rows: slice, columns: slice) -> Array:
        """Derivative of `block` along x [1/N]."""
        powers = exponents(self.degree)
        lower = np.maximum(powers - np.array([1, 0]), 0)
        unit = at / np.array(self.scale)
        to = powers[:, 0] / self.scale[0] * np.prod(unit[:, None] ** lower, axis=2)
        by = monomials(at, self.scale, self.degree)
        left = np.kron(np.eye(rows.stop - rows.start), to)
        right = np.kron(np.eye(columns.stop - columns.start), by)
        return np.asarray(left @ self._part(rows, columns) @ right.T)


#: Directions of a kernel: along tangents, and the normal.
TANGENTS, NORMAL = slice(0, 2), slice(2, 3)
