"""Grooved shaft as a uniform beam: its stiffnesses, and the effect of cutting it by a flat rigid section.

Averaged over a lead, a long grooved shaft under constant force and moment is a uniform beam. About that beam its sections
sway with the groove: an axial force bends the shaft towards the groove, and half a lead further the other way. A rigid
section at its end stops the sway at one phase, and also keeps the cross-section flat. Therefore, if a shaft of length L
along z is cut and rigid at both ends and fixed at the lower one (a), its upper end (b) moves by the flexibility

    F = U(L) + T(L) A T(L)^T + R_b E R_b^T,   A = R_a M E M R_a^T,

where U is the flexibility of a uniform cantilever, T the transport along the axis, and E ``(6, 6)`` the flexibility of one
cut end: motion of the rigid section against the beam, by force and moment on the section, in the frame of the cut (origin
on the axis, x towards the middle of the groove, z along the screw). R turns that frame by the groove's azimuth at the cut.
The lower cut is the upper one after half a turn M about x, which maps a helix, of either hand and with any number of
starts, onto itself. The interaction of both ends is left out: it decays within about a diameter.

E is fitted by least squares to three 3D shafts of different length, clamped at one flat end and loaded at the other, a
rigid section. The first is a whole number of leads long, the second twice as long. Both leave the terms undetermined that
change sign from end to end, so the third shaft ends at another phase of the groove. The difference of the first two is the
flexibility of the leads between. It serves only to fit E, because these meshes are too stiff, by a per cent in bending.

The stiffnesses are exact but for a plane mesh, because the shaft is invariant under the helix of its groove. With (r,
zeta, phi) of `meshes.groove_map`, zeta = z - r_g phi, the geometry does not depend on phi, nor does the strain of an
average stretch and twist of the shaft; that of an average curvature goes with exp(i phi). So does the section's response:
u = w(r, zeta) exp(i n phi) in the directions r, phi and z, periodic in zeta with the lead over the starts, n = 0 or 1,
and derivatives around the axis at constant z are d_theta = i n - r_g d_zeta. The energy at the minimum over w gives the
stiffnesses. (Helically symmetric bodies: Treyssede 2008; the average is that over a lead.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu
from skfem import Basis, ElementQuad2, ElementVector, MeshQuad

from rollbench.hifi.bodies.coarse import all_freedoms_with_rigid_end
from rollbench.hifi.elements.forms import elastic_stiffness
from rollbench.hifi.elements.rigid import rigid_motion_transfer_along_z
from rollbench.hifi.linear_algebra import symmetric_compliance_of_loads
from rollbench.hifi.shaft.beam import ShaftSection, end_flexibility_of_cantilever, round_section
from rollbench.meshes.arrays import Array
from rollbench.meshes.groove import GroovedBodySpec
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import mesh_grooved_body
from rollbench.meshes.parts import Material
from rollbench.meshes.sockets import RefinementBoxSize

#: Factors on the components of motions, and of forces and moments, by half a turn about x.
HALF_TURN = np.diag([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])

_UPPER = np.triu_indices(6)

#: Basis of the symmetric matrices ``(21, 6, 6)``: each has ones at one entry and its transposed entry, else zeros.
_UNITS = np.zeros((21, 6, 6))

_UNITS[(np.arange(21), *_UPPER)] = _UNITS[(np.arange(21), *_UPPER[::-1])] = 1.0


def groove_azimuth(m: GrooveMap, z: float) -> float:
    """Return the azimuth [rad] of the middle of the first start's groove at the axial position z [m].

    ``m``: geometry of the track.
    """
    return m.phase + (z - m.z0) / m.rg


def rotate_flexibility(flexibility: Array, azimuth: float) -> Array:
    """Rotate a (6, 6) flexibility matrix about z, from a frame at a given azimuth into the fixed frame.

    Parameters
    ----------
    flexibility : (6, 6) Array
        Flexibility in the rotated frame [m/N, 1/N, 1/(N m)].
    azimuth : float
        Azimuth of that frame [rad].

    Returns
    -------
    (6, 6) Array
        Flexibility in the fixed frame [m/N, 1/N, 1/(N m)].
    """
    c, s = np.cos(azimuth), np.sin(azimuth)
    R = np.kron(np.eye(2), np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))
    return np.asarray(R @ flexibility @ R.T)


def flexibility_of_lower_cut_end(cut_end_flexibility: Array, m: GrooveMap, z: float) -> Array:
    """Compute the flexibility that the cut lower end of a shaft adds to that of its uniform beam.

    The flexibility is the motion of the beam's end, by unit forces and moments, relative to the fixed flat section at the
    cut, in the fixed frame.

    Parameters
    ----------
    cut_end_flexibility : (6, 6) Array
        Flexibility E of a cut end, in the frame of the cut [m/N, 1/N, 1/(N m)].
    m : GrooveMap
        Geometry of the track.
    z : float
        Axial position of the end [m].

    Returns
    -------
    (6, 6) Array
        Flexibility [m/N, 1/N, 1/(N m)].
    """
    return rotate_flexibility(HALF_TURN @ cut_end_flexibility @ HALF_TURN, groove_azimuth(m, z))


def flexibility_of_upper_cut_end(cut_end_flexibility: Array, m: GrooveMap, z: float) -> Array:
    """Compute the flexibility that the cut upper end of a shaft adds to that of its uniform beam.

    The flexibility is the motion of the rigid flat section at the cut, by unit forces and moments, relative to the beam's
    end, in the fixed frame.

    Parameters
    ----------
    cut_end_flexibility : (6, 6) Array
        Flexibility E of a cut end, in the frame of the cut [m/N, 1/N, 1/(N m)].
    m : GrooveMap
        Geometry of the track.
    z : float
        Axial position of the end [m].

    Returns
    -------
    (6, 6) Array
        Flexibility [m/N, 1/N, 1/(N m)].
    """
    return rotate_flexibility(cut_end_flexibility, groove_azimuth(m, z))


def fit_flexibility_of_cut_end(m: GrooveMap, flexibilities: Sequence[tuple[float, Array]], per_length: Array) -> Array:
    """Find the flexibility E that a cut end adds to a uniform beam, by a fit to the flexibilities of several 3D shafts.

    The middle of every shaft lies at ``m.z0``. A flexibility per unit length that couples shear force and bending moment
    about the same axis, equal for x and y, is fitted together with E, but not returned. The shear flexibility of the beam
    is prescribed; another value would only change the definition of the beam's rotation, and E with it.

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.
    flexibilities : Sequence[tuple[float, Array]]
        For every shaft its length [m], and the flexibility F of its upper end with the
        lower end fixed ``(6, 6)`` [m/N, 1/N, 1/(N m)].
    per_length : (6, 6) Array
        Flexibility of the uniform beam per unit length.

    Returns
    -------
    (6, 6) Array
        Flexibility E of one cut end, in the frame of the cut [m/N, 1/N, 1/(N m)].
    """
    unit = np.array([m.R, m.R, m.R, 1.0, 1.0, 1.0])
    scale = np.outer(unit, unit)
    chiral = np.zeros((6, 6))
    chiral[[0, 1, 3, 4], [3, 4, 0, 1]] = m.R
    columns, wanted = [], []
    for length, F in flexibilities:
        rows = [_flexibility_of_both_cut_ends(m, length, e * scale) for e in _UNITS]
        rows.append(end_flexibility_of_cantilever(length, chiral))
        columns.append(np.array([(x / scale)[_UPPER] for x in rows]).T)
        wanted.append(((F - end_flexibility_of_cantilever(length, per_length)) / scale)[_UPPER])
    coefficients = np.linalg.lstsq(np.concatenate(columns), np.concatenate(wanted))[0]
    return np.asarray(np.tensordot(coefficients[:-1], _UNITS, 1) * scale)


def _flexibility_of_both_cut_ends(m: GrooveMap, length: float, cut: Array) -> Array:
    """Compute the flexibility ``(6, 6)`` that both cut ends of a shaft add at its upper end.

    ``length``: length of the shaft [m]; ``cut``: flexibility E of one cut end, in the frame of the cut.
    """
    T, half = rigid_motion_transfer_along_z(length), length / 2.0
    lower, upper = flexibility_of_lower_cut_end(cut, m, m.z0 - half), flexibility_of_upper_cut_end(cut, m, m.z0 + half)
    return np.asarray(T @ lower @ T.T + upper)  # T A T^T + R_b E R_b^T


@dataclass(frozen=True)
class EquivalentBeam:
    """Uniform beam equivalent to a grooved shaft, and the flexibility that a cut end adds to it."""

    #: Stiffnesses of the beam's cross-section.
    section: ShaftSection
    #: Radii of three smooth shafts that have the same axial, the same bending and the same torsional stiffness [m].
    equivalent_radii: tuple[float, float, float]
    #: Axial-torsional coupling: ratio of the twist by a unit axial force to the geometric mean of axial and torsional
    #: flexibility.
    axial_torsional_coupling: float
    #: Flexibility E that a cut end of the shaft adds to the beam ``(6, 6)``, in the frame of the cut.
    cut_end_flexibility: Array


#: Number of leads by which the third shaft is longer than the first: a quarter changes the phase of terms that vary once
#: or twice in a lead.
OTHER_PHASE = 0.25


def choose_lengths_of_fitted_shafts(m: GrooveMap) -> tuple[float, float, float]:
    """Choose the lengths of the three 3D shafts to which `compute_equivalent_beam` fits the equivalent beam.

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.

    Returns
    -------
    tuple[float, float, float]
        Lengths of the short, the long and the third shaft [m]; the first two are whole numbers of leads.
    """
    lead = 2.0 * np.pi * abs(m.rg)
    leads = int(np.ceil(2.4 * m.R / lead))
    return lead * leads, lead * 2 * leads, lead * (leads + OTHER_PHASE)


def compute_equivalent_beam(
    m: GrooveMap, bore: float, material: Material, section: tuple[Array, float], shafts: Sequence[tuple[float, Array]]
) -> EquivalentBeam:
    """Compute the uniform beam equivalent to a grooved shaft, and the flexibility that a cut end adds.

    The beam's stiffnesses come from the helical section, the flexibility of a cut end from three 3D shafts.

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.
    bore : float
        Radius of the bore [m].
    material : Material
        Elastic material.
    section : tuple[Array, float]
        Stiffness against stretch and twist ``(2, 2)`` [N, N m; N m, N m2] and bending stiffness [N m2], as from
        `stiffness_of_grooved_shaft`.
    shafts : Sequence[tuple[float, Array]]
        Length [m] and flexibility ``(6, 6)`` of the short, the long and the third shaft, of `meshed_shaft_flexibility`.

    Returns
    -------
    EquivalentBeam
        The uniform beam.
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
    return EquivalentBeam(ShaftSection(EA, EI, GJ, kGA), radii, coupling, fit_flexibility_of_cut_end(m, shafts, uniform))


def meshed_shaft_flexibility(
    m: GrooveMap, land_radius: float, bore_radius: float, material: Material, element_size: float, length: float
) -> tuple[float, Array]:
    """Mesh a grooved shaft in 3D, clamped at its lower end, and compute the flexibility of its rigid upper end.

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.
    land_radius : float
        Radius of the lands [m].
    bore_radius : float
        Radius of the bore of the mesh [m], which may need one where the shaft has none.
    material : Material
        Elastic material.
    element_size : float
        Element size [m].
    length : float
        Length of the shaft [m].

    Returns
    -------
    length : float
        Length of the shaft [m].
    F : (6, 6) Array
        Motion of the rigid end by unit forces and moments on it [m/N, 1/N, 1/(N m)].
    """
    ends, no_box = (m.z0 - length / 2.0, m.z0 + length / 2.0), RefinementBoxSize(0.3, 1e-3, 0.05)
    spec = GroovedBodySpec(bore_radius, land_radius, *ends, True, (), no_box, element_size, element_size)
    mesh = mesh_grooved_body(m, spec)
    K = elastic_stiffness(mesh.mesh, material.youngs_modulus, material.poissons_ratio)
    T = all_freedoms_with_rigid_end(mesh.mesh, spec.z_high)
    return length, symmetric_compliance_of_loads((T.T @ K @ T).tocsc(), sp.eye_array(T.shape[1], format="csr")[-6:])


#: Strains of an average stretch, twist or curvature: their component (as in `_strain_components`), and the power of the
#: radius with which they grow.
STRETCH, TWIST, CURVATURE = (2, 0), (5, 1), (2, 1)

#: Second-order cells along the groove, along the land, and in depth.
CELLS = (32, 12, 12)


def stiffness_of_grooved_shaft(
    m: GrooveMap, outer: float, bore: float, material: Material, cells: tuple[int, int, int] = CELLS
) -> tuple[Array, float]:
    """Compute the axial, torsional and bending stiffness of a long grooved shaft on a plane mesh of its helical section.

    The displacement fields have the helical symmetry of the groove.

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.
    outer : float
        Radius of the lands [m].
    bore : float
        Radius of the bore [m]; 0: solid.
    material : Material
        Elastic material.
    cells : tuple[int, int, int], default CELLS
        Second-order cells along the groove, along the land, and in depth.

    Returns
    -------
    axial : (2, 2) Array
        Stiffness against stretch and twist per length [N, N m; N m, N m2].
    bending : float
        Bending stiffness [N m2].

    Raises
    ------
    ValueError
        Grooves of neighbouring turns overlap, or the bore cuts them.

    References
    ----------
    Helically symmetric bodies: Treyssede (2008).
    """
    mesh, period = _mesh_helical_section(m, outer, bore, cells)
    basis = Basis(mesh, ElementVector(ElementQuad2(), 3), intorder=6)
    axial = _stiffness_against_mean_strains(basis, m.rg, 0, material, period, (STRETCH, TWIST))
    bending = _stiffness_against_mean_strains(basis, m.rg, 1, material, period, (CURVATURE,))
    return axial * 2.0 * np.pi / period, float((bending * np.pi / period)[0, 0])


def _mesh_helical_section(m: GrooveMap, outer: float, bore: float, cells: tuple[int, int, int]) -> tuple[MeshQuad, float]:
    """Mesh the section (r, zeta) of a grooved shaft over one period along z, with the middle of the groove at zeta = 0.

    ``outer``, ``bore``: radii of lands and bore [m]; ``cells``: numbers of cells along the groove, along the land and in
    depth. Returns the mesh and the length of the period [m].
    """
    along, land, deep = cells
    period = 2.0 * np.pi * abs(m.rg) / m.starts
    gamma = np.linspace(0.0, np.pi / 2.0, 4001)
    r, zeta, _ = m.section_to_unrolled(*m.polar_to_section(1, gamma, np.full(gamma.size, m.radius[1])))
    kept = (zeta >= 0.0) & (r <= outer)
    r, zeta = r[kept], zeta[kept]
    edge = float(zeta[-1])
    if edge >= 0.5 * period:
        raise ValueError(
            f"the grooves of neighbouring turns of a shaft overlap: got a groove {2e3 * edge:.4g} mm wide; allowed: "
            f"less than their distance of {1e3 * period:.4g} mm"
        )
    if bore >= r.min():
        raise ValueError(
            f"the bore of a shaft cuts its groove: got a bore radius of {1e3 * bore:.4g} mm; allowed: less than "
            f"{1e3 * r.min():.4g} mm"
        )
    length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(r), np.diff(zeta)))])  # even cells along the flank
    at = np.linspace(0.0, length[-1], along // 2 + 1)
    flank, surface = np.interp(at, length, zeta), np.interp(at, length, r)
    flank[0], surface[-1] = 0.0, outer
    flat = np.linspace(edge, 0.5 * period, land // 2 + 1)[1:]
    z, top = np.concatenate([flank, flat]), np.concatenate([surface, np.full(flat.size, outer)])
    z, top = np.concatenate([-z[:0:-1], z]), np.concatenate([top[:0:-1], top])
    depth = 1.0 - np.linspace(1.0, 0.0, deep + 1) ** 1.5  # finer towards the surface
    mesh = MeshQuad.init_tensor(np.arange(depth.size, dtype=float), np.arange(z.size, dtype=float))
    i, j = mesh.p.round().astype(int)
    return mesh.translated(np.stack([bore + depth[i] * (top[j] - bore), z[j]]) - mesh.p[:, :]), period


def _strain_components(value: Any, slope: Any, r: Array, rg: float, n: int) -> list[Any]:
    """Compute the strains rr, tt, zz, rz, rt, tz (engineering shears) of a displacement w(r, zeta) exp(i n phi).

    ``value``: the three components of w; ``slope``: their derivatives along r and zeta; ``r``: radii of the points [m];
    ``rg``: rise of the helix [m/rad]; n: number of waves around the axis.
    """
    u, v, w = value
    (u_r, u_z), (v_r, v_z), (w_r, w_z) = slope
    turn = 1j * n if n else 0.0
    u_t, v_t, w_t = (turn * f - rg * f_z for f, f_z in ((u, u_z), (v, v_z), (w, w_z)))
    return [u_r, (v_t + u) / r, w_z, u_z + w_r, (u_t - v) / r + v_r, w_t / r + v_z]


def _stiffness_against_mean_strains(
    basis: Basis, rg: float, n: int, material: Material, period: float, mean_strains: Sequence[tuple[int, int]]
) -> Array:
    """Compute the stiffness ``(k, k)`` of one period of a shaft against k average strains, from its least strain energy.

    ``basis``: finite-element space of the section; ``rg``: rise of the helix [m/rad]; n: number of waves around the axis;
    ``period``: length of the section's period [m]; ``mean_strains``: component of each average strain in
    `_strain_components`, and the power of the radius with which it grows.
    """
    e, nu = material.youngs_modulus, material.poissons_ratio
    shear = e / (2.0 * (1.0 + nu))
    hooke = np.diag(shear * np.array([2.0, 2.0, 2.0, 1.0, 1.0, 1.0]))
    hooke[:3, :3] += 2.0 * shear * nu / (1.0 - 2.0 * nu)
    r = np.asarray(basis.global_coordinates()[0])
    weight = np.repeat(r * basis.dx, len(hooke), axis=1)

    def strains_by_cell(strains: list[list[Array]]) -> Array:
        """Arrange strains of shape functions as an array ``(cells, functions, points and components)``."""
        values = np.array(strains).transpose(2, 0, 3, 1)
        return np.ascontiguousarray(values).reshape(*values.shape[:2], -1)

    def weighted_stresses(strains: Array) -> Array:
        """Compute stresses times the integration weight of each point, ``(cells, points and components, functions)``."""
        values = (strains.reshape(-1, len(hooke)) @ hooke).reshape(strains.shape)
        return np.asarray((values * weight[:, None]).swapaxes(1, 2))

    B = strains_by_cell([_strain_components(f[0], f[0].grad, r, rg, n) for f in basis.basis])
    mean = strains_by_cell([[r**power if k == of else 0.0 * r for k in range(6)] for of, power in mean_strains])
    nodes, size = basis.element_dofs.T, basis.N
    lines, columns = np.repeat(nodes, nodes.shape[1], axis=1).ravel(), np.tile(nodes, nodes.shape[1]).ravel()
    K = sp.csr_array(((B.conj() @ weighted_stresses(B)).ravel(), (lines, columns)), (size, size))
    F = np.zeros((size, len(mean_strains)), dtype=B.dtype)
    np.add.at(F, nodes, B.conj() @ weighted_stresses(mean))
    prescribed = (mean @ weighted_stresses(mean)).sum(axis=0)
    T = _periodic_constraints(basis, period)
    # the axis moves as a whole: n = 0 along and around, n = 1 across
    top = int(np.argmax(basis.doflocs[0]))
    point = np.flatnonzero(np.linalg.norm(basis.doflocs - basis.doflocs[:, [top]], axis=0) < 1e-12)
    held = T[point[1:] if n == 0 else point[:1]].nonzero()[1]
    free = np.setdiff1d(np.arange(T.shape[1]), held)
    T = T[:, free]
    answer = splu((T.T @ K @ T).tocsc(), permc_spec="MMD_AT_PLUS_A").solve(T.T @ F)
    return np.asarray((prescribed - np.conj(T.T @ F).T @ answer).real)


def _periodic_constraints(basis: Basis, period: float) -> sp.csr_array:
    """Return the matrix ``(n, m)`` that gives the n degrees of freedom of a periodic mesh from the m independent ones.

    The degrees of freedom at both ends of the period, whose length is ``period`` [m], are equal.
    """
    x = basis.doflocs
    low, high = (np.flatnonzero(np.abs(x[1] - s * 0.5 * period) < 1e-9 * period) for s in (-1.0, 1.0))
    low, high = (at[np.lexsort((at, x[0, at]))] for at in (low, high))
    master = np.arange(x.shape[1])
    master[high] = low
    left, place = np.unique(master, return_inverse=True)
    return sp.csr_array((np.ones(place.size), (np.arange(place.size), place)), (place.size, left.size))
