"""Section of a grooved shaft, homogenised: stiffnesses of the beam that stretches, bends and twists like the 3D shaft.

Its stiffnesses are exact but for a plane mesh (`hifi.shaft.helical_section`). What happens where it is cut
(`hifi.shaft.cut`) follows from 3D shafts of one and two whole numbers of leads, and a third one that ends in another phase
of the groove, clamped at one flat end and loaded at the other, a rigid section; the difference of the first two is that of
the leads between. Their meshes are too stiff, by a per cent in bending, so that this difference serves only the cut.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from rollbench.hifi.bodies.coarse import end_transform
from rollbench.hifi.elements.assembly import assemble
from rollbench.hifi.elements.forms import elasticity
from rollbench.hifi.linear_algebra.solvers import compliance
from rollbench.hifi.shaft.beam import ShaftSection, round_section
from rollbench.hifi.shaft.cut import cut_flexibility
from rollbench.meshes.arrays import Array
from rollbench.meshes.groove import BodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import build_body
from rollbench.meshes.parts import Material
from rollbench.meshes.sockets import SocketSize


@dataclass(frozen=True)
class Homogenised:
    """Section, and the radii [m] of plain shafts of equal axial, bending and torsional stiffness; axial-torsional
    coupling (twist by an axial force over the geometric mean of both flexibilities); flexibility ``(6, 6)`` of a cut that
    ends the shaft, in the frame of the cut (`hifi.shaft.cut`)."""

    section: ShaftSection
    radii: tuple[float, float, float]
    coupling: float
    cut: Array


#: Leads by which the third shaft is longer than the first: a quarter turns both what sways once in a lead and what sways
#: twice.
OTHER_PHASE = 0.25


def lengths(m: GrooveMap) -> tuple[float, float, float]:
    """Lengths [m] of the short, the long and the third of the 3D shafts."""
    lead = 2.0 * np.pi * abs(m.rg)
    leads = int(np.ceil(2.4 * m.R / lead))
    return lead * leads, lead * 2 * leads, lead * (leads + OTHER_PHASE)


def homogenise(
    m: GrooveMap, bore: float, material: Material, section: tuple[Array, float], shafts: Sequence[tuple[float, Array]]
) -> Homogenised:
    """Homogenised section of a shaft with a bore of this radius [m].

    section: its stiffnesses by `hifi.shaft.helical_section.helical_stiffness`; shafts: short, long and third one by
    `meshed_shaft`. A shaft without lead is plain beyond its groove.
    """
    young, poisson = material.youngs_modulus, material.poissons_ratio
    (least, short), (most, long), _ = shafts
    per_length = (long - short) / (most - least)
    stiffness, EI = section
    yielding = np.linalg.inv(stiffness)
    EA, GJ = 1.0 / yielding[0, 0], 1.0 / yielding[1, 1]
    shear = young / (2.0 * (1.0 + poisson))
    radii = (
        float(np.sqrt(EA / (young * np.pi) + bore**2)),
        float((4.0 * EI / (young * np.pi) + bore**4) ** 0.25),
        float((2.0 * GJ / (shear * np.pi) + bore**4) ** 0.25),
    )
    kGA = round_section(radii[1], young, poisson, bore).kGA
    coupling = float(yielding[0, 1] / np.sqrt(yielding[0, 0] * yielding[1, 1]))
    bend = 0.5 * (per_length[3, 3] + per_length[4, 4])
    uniform = np.diag([1.0 / kGA, 1.0 / kGA, per_length[2, 2], bend, bend, per_length[5, 5]])
    uniform[2, 5] = uniform[5, 2] = per_length[2, 5]
    return Homogenised(ShaftSection(EA, EI, GJ, kGA), radii, coupling, cut_flexibility(m, shafts, uniform))


def meshed_shaft(
    m: GrooveMap, outer: float, hole: float, material: Material, size: float, length: float
) -> tuple[float, Array]:
    """Length [m] of a 3D shaft of elements of ``size`` [m], and motion (6, 6) of its rigid end section by loads on it, the
    other end clamped; outer: radius of its lands [m].

    hole: radius of the bore of the mesh [m], which may need one where the shaft has none.
    """
    spec = BodySpec(
        hole, outer, m.z0 - length / 2.0, m.z0 + length / 2.0, True, (), SocketSize(0.3, 1e-3, 0.05), size, size
    )
    mesh = build_body(m, spec)
    K = assemble(elasticity(material.youngs_modulus, material.poissons_ratio), mesh.mesh)
    T = end_transform(mesh.mesh, spec.z_high)
    return length, compliance((T.T @ K @ T).tocsc(), sp.eye_array(T.shape[1], format="csr")[-6:])
