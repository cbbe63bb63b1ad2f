"""Displacements of an elastic half space's surface by uniform tractions on a rectangle, in closed form.

Boussinesq's and Cerruti's point forces (Johnson, Contact Mechanics, 1985, 3.2 and 3.6) integrated over a rectangle; two
bodies in contact see opposite tractions, and what counts is the motion of one surface past the other. Where both are of one
material, normal tractions part the surfaces along the normal only, and tangential ones along tangents only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.meshes.arrays import Array


@dataclass(frozen=True)
class Solids:
    """Two elastic bodies: shear moduli [Pa] and Poisson's ratios of the first (the ball) and the second (the groove)."""

    shear: tuple[float, float]
    poisson: tuple[float, float]

    def __post_init__(self) -> None:
        """Raise ValueError for moduli that are not positive and ratios outside [0, 0.5]."""
        if min(self.shear) <= 0.0 or min(self.poisson) < 0.0 or max(self.poisson) > 0.5:
            raise ValueError("need shear moduli > 0 and Poisson's ratios from 0 to 0.5")

    @staticmethod
    def same(young: float, poisson: float) -> Solids:
        """Two bodies of one material, Young's modulus in Pa."""
        return Solids((0.5 * young / (1.0 + poisson),) * 2, (poisson, poisson))

    @property
    def upright(self) -> float:
        """Sum over the bodies of (1 - nu)/(2 pi G) [1/Pa]."""
        return float(sum((1.0 - n) / g for g, n in zip(self.shear, self.poisson, strict=True)) / (2.0 * np.pi))

    @property
    def aslant(self) -> float:
        """Sum over the bodies of nu/(2 pi G) [1/Pa]."""
        return float(sum(n / g for g, n in zip(self.shear, self.poisson, strict=True)) / (2.0 * np.pi))

    @property
    def coupling(self) -> float:
        """(1 - 2 nu)/(4 pi G) of the first body less that of the second [1/Pa]; zero for one material."""
        one, two = ((1.0 - 2.0 * n) / (4.0 * np.pi * g) for g, n in zip(self.shear, self.poisson, strict=True))
        return one - two


def _over_rectangle(corner: Array) -> Array:
    """Double integral from a double antiderivative's values (2, 2, ...) at the corners."""
    return np.asarray(corner[0, 0] - corner[0, 1] - corner[1, 0] + corner[1, 1])


def _corners(x: Array, y: Array, dx: float, dy: float) -> tuple[Array, Array]:
    """Coordinates (2, 2, ...) of the points x, y seen from the corners of a rectangle about the origin."""
    ends = np.array([0.5, -0.5])
    X = np.broadcast_to(x + dx * ends.reshape(2, 1, *([1] * np.ndim(x))), (2, 2, *np.shape(x)))
    Y = np.broadcast_to(y + dy * ends.reshape(1, 2, *([1] * np.ndim(y))), (2, 2, *np.shape(y)))
    return X, Y


def _log_sum(x: Array, y: Array) -> Array:
    """x ln(y + R) up to a function of x alone, without cancellation for y < 0; its limit 0 at x = 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(x == 0.0, 0.0, x * np.arcsinh(y / np.abs(x)))


def influence(x: Array, y: Array, dx: float, dy: float, solids: Solids) -> Array:
    """Relative displacement ``(..., 3, 3)`` [m/Pa] of the surfaces at x, y [m] by unit tractions on a rectangle.

    The rectangle dx by dy lies about the origin. Rows: displacement of body 1 past body 2 along x, y, and the parting along
    the normal; columns: traction on body 1 along x, y, and pressure. Johnson (3.22), (3.75) and (3.77), integrated exactly.
    """
    X, Y = _corners(x, y, dx, dy)
    R = np.hypot(X, Y)
    along_x, along_y = _log_sum(Y, X), _log_sum(X, Y)  # integrals of X^2/R^3 and Y^2/R^3
    with np.errstate(divide="ignore", invalid="ignore"):
        log = np.where(R == 0.0, 0.0, np.log(R))
        by_x = Y * log + np.where(X == 0.0, 0.0, X * np.arctan(Y / X))  # integral of X/R^2
        by_y = X * log + np.where(Y == 0.0, 0.0, Y * np.arctan(X / Y))
    over = _over_rectangle
    inverse, k = over(along_x) + over(along_y), solids.coupling
    out = np.empty((*np.shape(x), 3, 3))
    out[..., 0, 0] = solids.upright * inverse + solids.aslant * over(along_x)
    out[..., 1, 1] = solids.upright * inverse + solids.aslant * over(along_y)
    out[..., 0, 1] = out[..., 1, 0] = solids.aslant * over(-R)
    out[..., 2, 2] = solids.upright * inverse
    out[..., 0, 2], out[..., 1, 2] = -k * over(by_x), -k * over(by_y)
    out[..., 2, 0], out[..., 2, 1] = k * over(by_x), k * over(by_y)
    return out
