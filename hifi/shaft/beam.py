"""The shaft beyond the 3D stretch: a Timoshenko beam of given section stiffnesses, independent of the low-order model's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Material


@dataclass(frozen=True)
class ShaftSection:
    """EA [N], EI [N m2], GJ [N m2], kappa G A [N]."""

    EA: float
    EI: float
    GJ: float
    kGA: float


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


def beam_stiffness(length: float, section: ShaftSection) -> Array:
    """Stiffness ``(12, 12)`` of a uniform shaft along z from the flexibility of its cantilever (equilibrium transport)."""
    f = np.zeros((6, 6))
    bend = length**3 / (3.0 * section.EI) + length / section.kGA
    f[0, 0] = f[1, 1] = bend
    f[0, 4] = f[4, 0] = length**2 / (2.0 * section.EI)
    f[1, 3] = f[3, 1] = -(length**2) / (2.0 * section.EI)
    f[3, 3] = f[4, 4] = length / section.EI
    f[2, 2], f[5, 5] = length / section.EA, length / section.GJ
    end = np.linalg.inv(f)
    transport = np.eye(6)
    transport[0, 4], transport[1, 3] = length, -length
    full = np.zeros((12, 12))
    full[6:, 6:] = end
    full[:6, 6:] = -transport.T @ end
    full[6:, :6] = full[:6, 6:].T
    full[:6, :6] = transport.T @ end @ transport
    return full
