"""Section constants of a grooved shaft or nut from half a lead of it, a ring groove in place of the helix.

The groove has the exact axial section of the helical one. Between two planes of symmetry (mid groove, mid land) the cell is
stretched, twisted and bent by the motions that symmetry leaves to those planes; what it stores gives EA, GJ and EI.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from rollbench.lowfi.compliance.fourier import Body, Grid, refine_lines, solved
from rollbench.meshes.arrays import Array
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import Material
from rollbench.meshes.section import BeamSection, shear_coefficient

#: Elements of the cell: along the groove's flank, along the land, and in depth.
MESH = (8, 5, 8)


@dataclass(frozen=True)
class CellSection:
    """Beam section of a grooved body, and the free radii [m] of plain ones of equal axial, bending and torsional
    stiffness (outer radius of a shaft, bore radius of a nut)."""

    section: BeamSection
    radii: tuple[float, float, float]


def groove_line(m: GrooveMap, land: float, screw: bool, count: int) -> tuple[Array, Array]:
    """Points (r, zeta) ``(count,)`` [m] of one flank from the apex (zeta = 0) to the edge of the land at radius ``land``.

    Raises ValueError where the land's cylinder does not cut the flank.
    """
    side = 1 if screw else 3
    centre, radius = m.centre[side], m.radius[side]
    apex = np.arcsin(np.clip(-m.signs[side, 1] * centre[1] / radius, -1.0, 1.0))
    low, high = apex, 0.5 * pi - 1e-6
    sign = -1.0 if screw else 1.0

    def beyond(gamma: float) -> bool:
        x3, z3 = m.section(side, np.array(gamma), radius)
        return bool(sign * (float(m.unroll(x3, z3)[0]) - land) < 0.0)

    if beyond(low) or not beyond(high):
        raise ValueError("the land's cylinder does not cut the groove")
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if beyond(middle) else (middle, high)
    x3, z3 = m.section(side, np.linspace(apex, low, count), radius)
    r, zeta, _ = m.unroll(x3, z3)
    zeta[0], r[-1] = 0.0, land
    return r, zeta


def cell_grid(
    m: GrooveMap, land: float, far: float, screw: bool, mesh: tuple[int, int, int] = MESH, half: float | None = None
) -> Grid:
    """Half a lead of the body between mid groove and mid land; ``far``: its plain surface (bore or outer radius) [m].

    half: length [m] of a body without lead on each side of its groove.

    Raises ValueError where grooves of neighbouring turns overlap.
    """
    half = pi * abs(m.rg) / m.starts if half is None else half
    r, zeta = groove_line(m, land, screw, 2 * mesh[0] + 1)
    if zeta[-1] >= half:
        raise ValueError("the grooves of neighbouring turns overlap")
    along = refine_lines(np.linspace(zeta[-1], half, mesh[1] + 1))[1:]
    surface, z = np.append(r, np.full(along.size, land)), np.append(zeta, along)
    share = refine_lines(1.0 - np.linspace(1.0, 0.0, mesh[2] + 1) ** 1.5)
    low, high = (np.full_like(surface, far), surface) if screw else (surface, np.full_like(surface, far))
    depth = share if screw else (1.0 - share)[::-1]
    return Grid(low[:, None] + depth * (high - low)[:, None], np.broadcast_to(z[:, None], (z.size, depth.size)).copy())


def cell_section(m: GrooveMap, land: float, far: float, screw: bool, material: Material) -> CellSection:
    """Section constants of a grooved shaft (``screw``) or nut; shear as for the plain section of equal torsional stiffness:
    both are shear along the axis.

    land: radius of the lands; far: bore of the shaft, or outer radius of the nut [m]. A track without lead has no cell.
    """
    if m.rg == 0.0:
        raise ValueError("a track without lead has no repeating cell")
    grid = cell_grid(m, land, far, screw)
    young, poisson = material.youngs_modulus, material.poissons_ratio
    body = Body(grid, young, poisson)
    length = float(grid.z[-1, 0])
    EA, GJ, EI = (stiffness_of(body, kind) * length for kind in ("axial", "torsion", "bending"))
    shear = material.shear_modulus
    sign = 1.0 if screw else -1.0
    radii = (
        float(np.sqrt(far**2 + sign * EA / (young * pi))),
        float((far**4 + sign * 4.0 * EI / (young * pi)) ** 0.25),
        float((far**4 + sign * 2.0 * GJ / (shear * pi)) ** 0.25),
    )
    outer, bore = (radii[2], far) if screw else (far, radii[2])
    kappa = shear_coefficient(bore / outer, poisson)
    return CellSection(BeamSection(EA, EI, GJ, kappa * shear * pi * (outer**2 - bore**2)), radii)


def stiffness_of(body: Body, kind: str) -> float:
    """Stiffness of the cell [N/m or N m]: twice its energy when its far plane of symmetry moves by one unit.

    axial: u_z = 1; torsion: u_t = r; bending: u_z = r cos t.
    """
    shape = body.grid.shape
    n = 1 if kind == "bending" else 0
    fixed, value = ~body.axis_free(n).reshape(*shape, 3), np.zeros((*shape, 3))
    if kind == "torsion":
        fixed[..., 0] = fixed[..., 2] = True
        fixed[0, :, 1] = fixed[-1, :, 1] = True
        value[-1, :, 1] = body.grid.r[-1]
    else:
        fixed[0, :, 2] = fixed[-1, :, 2] = True
        value[-1, :, 2] = 1.0 if kind == "axial" else body.grid.r[-1]
        if kind == "axial":
            fixed[..., 1] = True
        else:
            fixed[0, -1, 0] = True  # the rigid shift across
    K, held, q = body.stiffness(n), fixed.ravel(), value.ravel()
    q[~held] = solved(body.bands(~held), n, -(K @ q)[~held])
    return float(q @ (K @ q))
