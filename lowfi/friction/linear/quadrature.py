"""Friction of an elliptical Hertz contact whose velocity centre lies on its major axis, by single integrals.

The dissipation under spin omega about (c, 0) is |omega| psi(c), psi the biharmonic potential of the flattened ellipsoid
of pressure. Its force psi' is a cubic of c/a inside the ellipse and one smooth integral outside.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rollbench.meshes.arrays import Array

#: Narrowest ellipse b/a with which the quadrature is used.
NARROWEST = 1e-3


@dataclass(frozen=True)
class Nodes:
    """Quadrature of int_0^1 g(y2) dy: squared abscissae and weights, ``(2, m)``; see ``nodes``."""

    table: Array


@lru_cache(maxsize=64)
def nodes(count: int) -> Nodes:
    """Gauss-Legendre rule in the angle theta, y = sin theta, with ``count`` points."""
    x, weight = np.polynomial.legendre.leggauss(count)
    theta = 0.25 * np.pi * (x + 1.0)
    return Nodes(np.array([np.sin(theta) ** 2, 0.25 * np.pi * weight * np.cos(theta)]))


def node_count(axis_ratio: float) -> int:
    """Points for about 1e-12 with b/a >= ``axis_ratio``: the integrand has a pole about b/a off the interval's end."""
    z = 1.0 + 1j * max(axis_ratio, NARROWEST) * 4.0 / np.pi
    growth = float(np.log(np.abs(z + np.sqrt(z * z - 1.0))))
    return int(np.clip(np.ceil(16.0 / growth), 24, 400))


@lru_cache(maxsize=64)
def contact_shape(axis_ratio: float) -> tuple[float, float, float, float]:
    """Constants (b2/a2, q0, k1, k3) of an ellipse b/a: inside it, with t = c/a and force F, mu = 1,

    f = F (k1 t - k3 t^3) and moment about the contact's centre M = a F (q0 - k1 t2/2 + 3 k3 t4/4); q0 = 3 E(e)/8 is
    Lin (3.32). Raises ValueError outside 1e-3 <= b/a <= 1.

    >>> [round(x, 6) for x in contact_shape(1.0)]
    [1.0, 0.589049, 1.178097, 0.294524]
    """
    if not NARROWEST <= axis_ratio <= 1.0:
        raise ValueError(f"ratio b/a of the semi-axes must lie in [{NARROWEST}, 1], not {axis_ratio}")
    x, weight = np.polynomial.legendre.leggauss(node_count(axis_ratio))
    theta = 0.25 * np.pi * (x + 1.0)
    s2, c2 = np.sin(theta) ** 2, np.cos(theta) ** 2
    root = np.sqrt(c2 + axis_ratio**2 * s2)
    w = 0.25 * np.pi * weight
    q0 = 0.375 * float(w @ root)
    k1 = 1.5 * float(w @ (c2 / root))
    k3 = 1.5 * float(w @ (c2 * s2 / root))
    return axis_ratio**2, q0, k1, k3
