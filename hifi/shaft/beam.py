"""The shaft beyond the 3D stretch: a Timoshenko beam of given section stiffnesses, independent of the low-order model's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.hifi.elements.rigid import transport
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Material


@dataclass(frozen=True)
class ShaftSection:
    """EA [N], EI [N m2], GJ [N m2], kappa G A [N]."""

    EA: float
    EI: float
    GJ: float
    kGA: float

    @property
    def per_length(self) -> Array:
        """Flexibility ``(6, 6)`` of a metre."""
        yielding = [self.kGA, self.kGA, self.EA, self.EI, self.EI, self.GJ]
        return np.asarray(np.diag(1.0 / np.array(yielding)))


def round_section(radius: float, young: float, poisson: float, bore: float = 0.0) -> ShaftSection:
    """Circular section of a radius [m], with a bore [m] or solid; shear coefficient of Cowper 1966 for either."""
    area, inertia = np.pi * (radius**2 - bore**2), np.pi * (radius**4 - bore**4) / 4.0
    shear, squares = young / (2.0 * (1.0 + poisson)), (bore / radius) ** 2
    ring = (20.0 + 12.0 * poisson) * squares / (1.0 + squares) ** 2
    kappa = 6.0 * (1.0 + poisson) / (7.0 + 6.0 * poisson + ring)
    return ShaftSection(young * area, young * inertia, 2.0 * shear * inertia, kappa * shear * area)


def tube(radius: float, bore: float, material: Material) -> ShaftSection:
    """Round section of these radii [m], with a hole unless that has none."""
    return round_section(radius, material.youngs_modulus, material.poissons_ratio, bore)


def uniform_cantilever(length: float, per_length: Array) -> Array:
    """Flexibility ``(6, 6)`` of the end of a cantilever along z from that of a metre ``(6, 6)``."""
    t = transport(1.0) - np.eye(6)
    first = t @ per_length
    return np.asarray(length * per_length + length**2 / 2.0 * (first + first.T) + length**3 / 3.0 * first @ t.T)


def beam_stiffness(length: float, section: ShaftSection) -> Array:
    """Stiffness ``(12, 12)`` of a uniform shaft along z from the flexibility of its cantilever (equilibrium transport)."""
    end, T = np.linalg.inv(uniform_cantilever(length, section.per_length)), transport(length)
    return np.block([[T.T @ end @ T, -T.T @ end], [-end @ T, end]])
