"""Timoshenko beam in element deformations: the state is what each element strains, not where its nodes are.

Node positions of a long slender shaft cancel to a part in 1e12 when subtracted; element deformations do not.
An element from node 1 to node 2 strains by d = q_2 - T q_1, T the rigid transport over its length.
"""

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import Array


@kernel
def element_constants(length: float, section: Array) -> tuple[float, float, float, float, float]:
    """Stiffnesses of an element's end deformation: k_uu, k_uu L/2, k_rr, axial, torsional (mends Lin D.1, D.2).

    section (4,): EA, EI, GJ, kappa G A. k_uu = 1/(L (L^2/(12 EI) + 1/(kappa G A))), k_rr = k_uu L^2/3 + k_uu EI/(kGA).
    """
    kuu = 1.0 / (length * (length * length / (12.0 * section[1]) + 1.0 / section[3]))
    krr = kuu * (length * length / 3.0 + section[1] / section[3])
    return kuu, 0.5 * length * kuu, krr, section[0] / length, section[2] / length


@kernel
def force_of(d: Array, constants: tuple[float, float, float, float, float], out: Array) -> None:
    """Force and moment (6,) at node 2 that the deformation d (6,) of an element takes, from its constants."""
    kuu, kur, krr, ka, kt = constants
    out[0] = kuu * d[0] - kur * d[4]
    out[4] = krr * d[4] - kur * d[0]
    out[1] = kuu * d[1] + kur * d[3]
    out[3] = krr * d[3] + kur * d[1]
    out[2] = ka * d[2]
    out[5] = kt * d[5]


@kernel
def add_element(band: Array, node: int, length: float, section: Array) -> None:
    """Add an element's stiffness between ``node`` and the next one to the lower band (see ``banded``)."""
    kuu, kur, krr, ka, kt = element_constants(length, section)
    off = length * kur - krr
    i, j = 6 * node, 6 * node + 6
    # plane x-z (ux, ry): sign +; plane y-z (uy, rx): sign -
    for plane in range(2):
        sign = 1.0 if plane == 0 else -1.0
        u, r = (0, 4) if plane == 0 else (1, 3)
        band[i + u, 0] += kuu
        band[i + r, 0] += krr
        band[i + u, r - u] += sign * kur
        band[i + u, j - i] -= kuu
        band[i + u, j + r - i - u] += sign * kur
        band[i + r, j + u - i - r] -= sign * kur
        band[i + r, j - i] += off
        band[j + u, 0] += kuu
        band[j + r, 0] += krr
        band[j + u, r - u] -= sign * kur
    band[i + 2, 0] += ka
    band[i + 2, 6] -= ka
    band[j + 2, 0] += ka
    band[i + 5, 0] += kt
    band[i + 5, 6] -= kt
    band[j + 5, 0] += kt


@kernel
def assemble_beam(lengths: Array, sections: Array, constants: Array, band: Array) -> None:
    """Fill the constants (n - 1, 5) of the elements of sections (n - 1, 4), and add their stiffness to the lower band."""
    for e in range(lengths.shape[0]):
        kuu, kur, krr, ka, kt = element_constants(lengths[e], sections[e])
        constants[e, 0], constants[e, 1], constants[e, 2], constants[e, 3], constants[e, 4] = kuu, kur, krr, ka, kt
        add_element(band, e, lengths[e], sections[e])
