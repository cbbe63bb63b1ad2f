"""Compliance of a smooth tube or shaft between load patches on its surface, by Fourier harmonics around the axis.

The module also computes the section constants of a grooved shaft or nut. Half a lead of the body is modelled with a ring
groove in place of the helix, with the exact axial section of the helical groove. Between two planes of symmetry (mid
groove, mid land) this cell is stretched, twisted and bent; its strain energy gives EA, GJ and EI.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import pi

import numpy as np

from rollbench.lowfi.compliance import fourier
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import Flange, Material
from rollbench.meshes.section import BeamSection, shear_coefficient, tube_section

#: Numbers of finite elements of half a lead: along the groove's flank, along the land, and in depth.
MESH = (8, 5, 8)
#: The same for a narrow load patch on the flank.
PATCH_MESH = (8, 4, 10)


@dataclass(frozen=True)
class HalfGroove:
    """Half a groove of screw, nut or bearing ring, from mid groove to mid land, with the body below it."""

    #: Geometry of the groove.
    groove_map: GrooveMap
    #: Radius of the lands, the cylindrical surface between the turns of the groove [m].
    land_radius: float
    #: Radius of the plain surface: bore of the screw or outer radius of the nut [m].
    plain_radius: float
    #: Whether the body is the screw or inner ring; otherwise it is the nut or outer ring.
    is_screw: bool
    #: Axial distance from mid groove to mid land [m]: half a lead, or half the width of a ring.
    half_length: float
    #: Material of the body.
    material: Material

    @property
    def flank_number(self) -> int:
        """Number of the right flank, which is computed: 1 of the screw or 3 of the nut; the left is its mirror image."""
        return 1 if self.is_screw else 3

    @property
    def surface_line(self) -> int:
        """Number of the grid line on the grooved surface of `finite_element_grid`: the last one in r, or the first."""
        return -1 if self.is_screw else 0

    @property
    def nominal_normal(self) -> Array:
        """Direction ``(2,)`` of the nominal contact load in the plane (r, z)."""
        m = self.groove_map
        return np.asarray(m.signs[self.flank_number] * np.array([np.cos(m.beta), np.sin(m.beta)]))

    def contact_position(self) -> tuple[float, float]:
        """Return the position of the nominal contact [m]: distance from the axis, then axial distance from mid groove."""
        m = self.groove_map
        x3, z3 = m.ball * self.nominal_normal
        r, zeta, _ = m.section_to_unrolled(np.array(x3), np.array(z3))
        return float(r), float(zeta)

    def profile_points(self, count: int) -> tuple[Array, Array]:
        """Return points on one groove flank from the apex to the edge of the land: radii, then axial positions [m].

        Each array is ``(count,)``; the axial position is zero at the apex.

        Raises
        ------
        ValueError
            The cylinder of the land does not cut the flank.
        """
        m, side = self.groove_map, self.flank_number
        centre, radius = m.centre[side], m.radius[side]
        apex = np.arcsin(np.clip(-m.signs[side, 1] * centre[1] / radius, -1.0, 1.0))
        low, high = apex, 0.5 * pi - 1e-6
        sign = -1.0 if self.is_screw else 1.0

        def is_beyond_land(gamma: float) -> bool:
            """Return whether the flank's point at the contact angle gamma [rad] lies past the cylinder of the land."""
            x3, z3 = m.polar_to_section(side, np.array(gamma), radius)
            return bool(sign * (float(m.section_to_unrolled(x3, z3)[0]) - self.land_radius) < 0.0)

        if is_beyond_land(low) or not is_beyond_land(high):
            raise ValueError(
                "the cylinder of the land does not cut the groove's flank; allowed: a land radius between the groove's "
                "apex and the end of the groove's arc"
            )
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if is_beyond_land(middle) else (middle, high)
        x3, z3 = m.polar_to_section(side, np.linspace(apex, low, count), radius)
        r, zeta, _ = m.section_to_unrolled(x3, z3)
        zeta[0], r[-1] = 0.0, self.land_radius
        return r, zeta

    def finite_element_grid(self, mesh: tuple[int, int, int] = PATCH_MESH) -> fourier.QuadrilateralGrid:
        """Return the finite-element grid of the body between mid groove and mid land.

        ``mesh``: numbers of elements along the flank, along the land, and in depth. Raises ValueError if the grooves of
        neighbouring turns overlap.
        """
        r, zeta = self.profile_points(2 * mesh[0] + 1)
        if zeta[-1] >= self.half_length:
            raise ValueError("the grooves of neighbouring turns overlap: increase the lead or make the groove narrower")
        along = fourier.node_positions_with_mid_nodes(np.linspace(zeta[-1], self.half_length, mesh[1] + 1))[1:]
        surface, z = np.append(r, np.full(along.size, self.land_radius)), np.append(zeta, along)
        return self.grid_below_surface(surface, z, 1.0 - np.linspace(1.0, 0.0, mesh[2] + 1) ** 1.5)

    def grid_below_surface(self, r: Array, z: Array, depth_ends: Array) -> fourier.QuadrilateralGrid:
        """Return the grid with nodes (r, z) [m] on the grooved surface and lines from there to the plain surface.

        ``depth_ends``: ends of the elements on a line, from 0 at the screw's bore to 1 at its surface; in a nut the line
        begins at the grooved surface.
        """
        share = fourier.node_positions_with_mid_nodes(depth_ends)
        plain = np.full_like(r, self.plain_radius)
        low, high, depth = (plain, r, share) if self.is_screw else (r, plain, (1.0 - share)[::-1])
        radii = low[:, None] + depth * (high - low)[:, None]
        return fourier.QuadrilateralGrid(radii, np.broadcast_to(z[:, None], radii.shape).copy())


def grooved_beam_section(flank: HalfGroove) -> BeamSection:
    """Return the beam stiffnesses of a grooved shaft or nut, by finite elements of half a lead.

    ``flank``: half a groove of the body. Raises ValueError if the groove has no lead.
    """
    if flank.groove_map.rg == 0.0:
        raise ValueError(
            "the beam section of a grooved shaft is computed on half a lead and needs a lead other than 0, got 0"
        )
    body = fourier.BodyOfRevolution(flank.finite_element_grid(MESH), flank.material)
    return section_of_cell(body, flank.plain_radius, flank.is_screw, flank.material)


def section_of_cell(body: fourier.BodyOfRevolution, plain_radius: float, shaft: bool, material: Material) -> BeamSection:
    """Return the beam stiffnesses of a shaft or tube from a cell of it between two planes of symmetry.

    The shear stiffness is that of the plain cylinder with the same torsional stiffness, because a shear force and a torque
    both shear the body along its axis.

    Parameters
    ----------
    body
        Finite elements of the cell, which begins at z = 0.
    plain_radius
        Bore radius of the shaft, or outer radius of the tube [m].
    shaft
        Whether the body is a shaft; otherwise it is a tube.
    material
        Material of the body.
    """
    length = float(body.grid.z[-1, 0])
    EA, GJ, EI = (solve_half_lead_under_unit_motion(body, k)[0] * length for k in ("axial", "torsion", "bending"))
    shear = material.shear_modulus
    other = (plain_radius**4 + (1.0 if shaft else -1.0) * 2.0 * GJ / (shear * pi)) ** 0.25
    outer, bore = (other, plain_radius) if shaft else (plain_radius, other)
    kappa = shear_coefficient(bore / outer, material.poissons_ratio)
    return BeamSection(EA, EI, GJ, kappa * shear * pi * (outer**2 - bore**2))


def solve_half_lead_under_unit_motion(body: fourier.BodyOfRevolution, kind: str) -> tuple[float, Array]:
    """Return the stiffness of half a lead of a body, and the motion of its nodes, for a unit motion of one end.

    One plane of symmetry is fixed and the other one moves by one unit: u_z = 1 for the ``kind`` "axial" (stiffness in N/m),
    u_t = r for "torsion", u_z = r cos t for "bending" (N m). The stiffness is twice the strain energy. The second result
    has the displacements along r, t and z at the grid's nodes (lines in z, lines in r, 3) [m].
    """
    shape = body.grid.shape
    n = 1 if kind == "bending" else 0
    fixed, value = ~body.freedoms_regular_on_axis(n).reshape(*shape, 3), np.zeros((*shape, 3))
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
    K, held, q = body.harmonic_stiffness(n), fixed.ravel(), value.ravel()
    q[~held] = fourier.solve_harmonic_displacements(body.stiffness_bands(~held), n, -(K @ q)[~held])
    return float(q @ (K @ q)), q.reshape(*shape, 3)


#: Pairs (direction of motion, direction of load) of r, t, z for which a harmonic's compliance is computed. The first
#: ``EVEN`` pairs vary as the cosine of n times the angle between two contacts, the others as the sine.
PARTS = ((0, 0), (1, 1), (2, 2), (0, 2), (1, 0), (1, 2))

#: Number of pairs in ``PARTS`` that vary as the cosine.
EVEN = 4

#: Weight of a node in a load patch below which it counts as zero; less than round-off.
UNREACHED = 1e-18

#: Number of contacts whose loads are processed at once.
CHUNK = 64

#: Half the thickness, over the shaft's radius, of the slice of a shaft on which a load on a cross-section acts.
SLICE = 0.25

#: Distance of grid lines [m] below which they count as one; distance of an element's end from a flange's surface, over the
#: element's length, below which that end is removed.
SAME, NEAR = 1e-9, 0.4

#: Points and weights of the Gauss quadrature over an element.
NODE, WEIGHT = np.polynomial.legendre.leggauss(8)

#: Shape functions of an element at the points ``NODE``.
SHAPES = fourier.quadratic_shape_functions(NODE)[0]


@dataclass(frozen=True)
class SmoothBody:
    """Smooth elastic body of revolution, without grooves, that represents screw or nut."""

    #: Bore radius [m].
    bore_radius: float
    #: Outer radius [m].
    outer_radius: float
    #: Axial positions of the body's ends [m].
    ends: tuple[float, float]
    #: Surface at which the body is fixed: ``"low"``, ``"high"`` or ``"both"`` faces, ``"bore"``, ``"outer"``, ``"flange"``,
    #: or ``"section"``: springs support the mean motions of its low-z end face.
    held: str
    #: Radius at which contacts load the body [m].
    contact_radius: float
    #: Standard deviation of the Gaussian load patches [m].
    patch_width: float
    #: Number of the highest Fourier harmonic around the axis.
    harmonics: int
    #: Sizes of the finite elements in z and in r near the contacts [m].
    size: tuple[float, float]
    #: Material of the body.
    material: Material
    #: Anisotropic layer that represents the grooves in the nut's bore; None: no layer.
    groove_layer: fourier.GrooveLayer | None = None
    #: Flange of the nut; None: no flange.
    flange: Flange | None = None

    def finite_element_body(self, grid: fourier.QuadrilateralGrid) -> fourier.BodyOfRevolution:
        """Return the finite-element model of the tube on a grid, which may extend beyond the tube around a flange."""
        return fourier.BodyOfRevolution(grid, self.material, self.groove_layer, self.filled_elements(grid))

    def filled_elements(self, grid: fourier.QuadrilateralGrid) -> Mask:
        """Return whether each element of a grid is filled with material of the tube or its flange ``(elements,)``."""
        r, z = (x[1::2, 1::2].ravel() for x in (grid.r, grid.z))
        if self.flange is None:
            return np.ones(r.size, dtype=bool)
        end, face, _ = self.flange.stations(*self.ends)
        return np.asarray((r < self.outer_radius) | ((z > min(end, face)) & (z < max(end, face))))

    @cached_property
    def section(self) -> BeamSection:
        """Return the section of the beam that has the tube's stiffness far from loads and ends."""
        if self.groove_layer is None:
            return tube_section(2.0 * self.outer_radius, 2.0 * self.bore_radius, self.material)
        ends = radial_element_ends(self)[0], np.array([0.0, self.size[0]])
        cell = self.finite_element_body(fourier.tube_grid(*ends))
        return section_of_cell(cell, self.outer_radius, False, self.material)


@dataclass(frozen=True)
class SmoothBodyCompliance:
    """Compliance between k axial positions of a tube at the radius of the contacts, in Fourier harmonics."""

    #: Smooth body of revolution (tube).
    tube: SmoothBody
    #: Axial positions of the loaded nodes ``(k,)`` [m].
    z: Array
    #: For each harmonic the symmetric compliance ``(3 k, 3 k)`` [m/N], in radial, circumferential and axial direction (r,
    #: t, z) for each position. For a shaft whose mean motions are fixed at the low-z end, harmonics 0 and 1 have two more
    #: rows and columns: the mean motions at the high-z end.
    line_compliance: tuple[fourier.OverlappingBlockMatrix, ...]
    #: Motions (r, t, z) of the k axial positions by two unit loads on the high-z end face, ``(2, 3, k)`` each: axial force
    #: and torque in harmonic 0; lateral force and bending moment in harmonic 1.
    line_motions_by_end: tuple[Array, ...] = ()
    #: Mean motions of the high-z end face by these loads, ``(2, 2)`` each: axial motion and twist in harmonic 0; lateral
    #: shift and tilt in harmonic 1.
    end_compliance: tuple[Array, ...] = ()


@dataclass(frozen=True)
class ContactPoints:
    """Contact points on a body of revolution, in cylindrical coordinates."""

    #: Azimuths of the contact points ``(c,)`` [rad].
    azimuth: Array
    #: Axial positions of the contact points ``(c,)`` [m].
    z: Array
    #: Directions of motion of each contact, in (r, t, z) components ``(c, 2, 3)``.
    axes: Array


def convert_contacts_to_cylindrical(contact_points: Array, axes: Array) -> ContactPoints:
    """Convert positions and directions of motion of c contacts from Cartesian to cylindrical coordinates.

    ``contact_points``: contact points (c, 3) [m]; ``axes``: unit vectors of the two directions in which each contact moves
    (c, 2, 3).
    """
    t = np.arctan2(contact_points[:, 1], contact_points[:, 0])
    c, s = np.cos(t), np.sin(t)
    r_hat = np.stack([c, s, 0 * c], axis=-1)
    t_hat = np.stack([-s, c, 0 * c], axis=-1)
    parts = (np.einsum("cak,ck->ca", axes, r_hat), np.einsum("cak,ck->ca", axes, t_hat), axes[..., 2])
    return ContactPoints(t, contact_points[:, 2], np.stack(parts, axis=-1))


def radial_element_ends(tube: SmoothBody) -> tuple[Array, int]:
    """Return the radii at which a tube's finite elements end [m], then the number of the contacts' radial grid line.

    Elements are small near the radius of the contacts. Grid lines are numbered from 0 at the bore, and include those
    through the elements' mid nodes.
    """
    low, high, h = tube.bore_radius, tube.outer_radius, tube.size[1]
    at = float(np.clip(tube.contact_radius, low, high))

    def growing_element_ends(length: float) -> Array:
        """Return distances of element ends from 0 to ``length`` [m]; the elements grow with the distance."""
        count = max(1, round(2.0 * (np.sqrt(1.0 + length / h) - 1.0)))
        return np.asarray(length * (np.arange(count + 1) / count) ** 1.6)

    inner = at - growing_element_ends(at - low)[::-1] if at > low else np.array([at])
    inner[0] = low
    outer = np.array([at])
    # no element lies across the end of the layer
    for end in (high,) if tube.groove_layer is None else (tube.groove_layer.radii[-1], high):
        if end > outer[-1]:
            outer = np.append(outer, outer[-1] + growing_element_ends(end - outer[-1])[1:])
    return np.append(inner, outer[1:]), 2 * (inner.size - 1)


def axial_element_ends(tube: SmoothBody, loaded_range: tuple[float, float]) -> Array:
    """Return the axial positions at which a tube's finite elements end [m].

    Elements are equally long over the loaded zone, and longer outside it. ``loaded_range``: lower and upper end of the
    loaded zone [m].
    """
    (low, high), h = tube.ends, tube.size[0]
    a, b = max(low, loaded_range[0]), min(high, loaded_range[1])
    middle = np.linspace(a, b, max(2, int(np.ceil((b - a) / h))) + 1)

    def element_ends_beyond_loaded_zone(length: float) -> Array:
        """Return distances of element ends from the loaded zone, up to ``length`` [m]; elements grow outwards."""
        if length <= 0.0:
            return np.zeros(0)
        count = max(1, round(2.5 * (np.sqrt(1.0 + length / h) - 1.0)))
        return np.asarray(length * (np.arange(1, count + 1) / count) ** 1.5)

    return np.concatenate(
        [a - element_ends_beyond_loaded_zone(a - low)[::-1], middle, b + element_ends_beyond_loaded_zone(high - b)]
    )


def add_element_ends_of_flange(tube: SmoothBody, r_ends: Array, z_ends: Array) -> tuple[Array, Array]:
    """Return the radii and axial positions at which elements end [m], with those at the surfaces of the flange added.

    ``r_ends``, ``z_ends``: element ends of the tube without its flange [m].
    """
    if tube.flange is None:
        return r_ends, z_ends
    size, stops = tube.size[0], np.unique([tube.outer_radius, *tube.flange.seat, tube.flange.diameter / 2.0])
    for low, high in pairwise(stops[np.diff(stops, prepend=0.0) > SAME]):
        r_ends = np.append(r_ends, np.linspace(low, high, int(np.ceil((high - low) / size)) + 1)[1:])
    stations = np.array(tube.flange.stations(*tube.ends))
    far = (np.abs(z_ends[:, None] - stations) > NEAR * size).all(axis=1)
    far[[0, -1]] = True
    z_ends = np.sort(np.append(z_ends[far], stations))
    return r_ends, z_ends[np.diff(z_ends, prepend=-np.inf) > SAME]


def fixed_freedoms(tube: SmoothBody, grid: fourier.QuadrilateralGrid) -> Mask:
    """Return whether each degree of freedom ``(3 nodes,)`` of a tube's grid is fixed; nodes outside the tube are fixed."""
    beyond = np.ones(grid.r.size, dtype=bool)
    beyond[grid.element_nodes()[tube.filled_elements(grid)].ravel()] = False
    held = np.repeat(beyond, 3).reshape(*grid.shape, 3)
    if tube.held in ("low", "both"):
        held[0] = True
    if tube.held in ("high", "both"):
        held[-1] = True
    if tube.held == "bore":
        held[:, 0] = True
    if tube.held == "outer":
        held[np.abs(grid.r - tube.outer_radius) < SAME] = True
    if tube.held == "flange" and tube.flange is not None:
        (low, high), (_, face, fit) = tube.flange.seat, tube.flange.stations(*tube.ends)
        held[(np.abs(grid.z - face) < SAME) & (grid.r > low - SAME) & (grid.r < high + SAME)] = True
        if tube.flange.bonded:
            between = (grid.z > min(face, fit) - SAME) & (grid.z < max(face, fit) + SAME)
            held[(np.abs(grid.r - tube.outer_radius) < SAME) & between] = True
    return held.ravel()


def tube_compliance(tube: SmoothBody, loaded_range: tuple[float, float]) -> SmoothBodyCompliance:
    """Return the compliance of a tube between the nodes at the contacts' radius, in all Fourier harmonics.

    ``loaded_range``: lower and upper end of the axial range that contains all contacts [m], over which the nodes are
    loaded.
    """
    r_ends, line = radial_element_ends(tube)
    grid = fourier.tube_grid(*add_element_ends_of_flange(tube, r_ends, axial_element_ends(tube, loaded_range)))
    z = grid.z[:, 0]
    inside = np.flatnonzero((z >= loaded_range[0] - 1e-9) & (z <= loaded_range[1] + 1e-9))
    first, last = int(inside[0]) // 2 * 2, (int(inside[-1]) + 1) // 2 * 2
    rows = (first, last + 1)
    body = tube.finite_element_body(grid)
    held = fixed_freedoms(tube, grid)
    springs = low_end_spring_stiffnesses(tube) if tube.held == "section" else ()
    by_harmonic = fourier.grid_line_compliance(body, range(tube.harmonics + 1), held, line, rows, springs)
    size = 3 * (rows[1] - rows[0])
    by_end = [S.full_matrix()[size:] for S in by_harmonic[:2]] if springs else []
    ends, corner = tuple(S[:, :size].reshape(2, -1, 3).swapaxes(1, 2) for S in by_end), tuple(S[:, size:] for S in by_end)
    return SmoothBodyCompliance(tube, z[rows[0] : rows[1]], tuple(by_harmonic), ends, corner)


def shaft_motions_by_section_loads(
    tube: SmoothBody, loaded_range: tuple[float, float], section_z: float
) -> SmoothBodyCompliance:
    """Return the motions of a shaft's nodes at the contacts' radius by unit loads on one of its cross-sections.

    The motions are in the field ``line_motions_by_end`` of the result; its field ``line_compliance`` is empty. The shaft is
    supported by springs on the mean motions of its end face at low z (`low_end_spring_stiffnesses`). Each load is spread
    over the material in a thin slice at the axial position ``section_z`` [m] so that its work is the load times the mean
    rigid motion of the slice (by least squares) in its direction. ``loaded_range``: lower and upper end of the axial range
    that contains all contacts [m].
    """
    r_ends, line = radial_element_ends(tube)
    grid = fourier.tube_grid(r_ends, axial_element_ends(tube, loaded_range))
    body = tube.finite_element_body(grid)
    z = grid.z[:, 0]
    half = min(SLICE * tube.outer_radius, section_z - tube.ends[0], tube.ends[1] - section_z)
    shares, levers = slice_mean_weights(z, section_z, half)
    inertia, springs, ends = 0.25 * (tube.outer_radius**2 + tube.bore_radius**2), low_end_spring_stiffnesses(tube), []
    for n, stiff in ((0, springs[2:]), (1, springs[:2])):
        free, motions = body.freedoms_regular_on_axis(n), fourier.mean_rigid_motion_matrix(grid.r[0], n)
        rows = shares[:, None, None] * motions
        if n == 1:
            rows[:, 1] = (inertia * rows[:, 1] + levers[:, None] * motions[0]) / (inertia + half**2 / 3.0)
        bands, held = body.stiffness_bands(free), motions[:, free[: motions.shape[1]]]
        i, j = np.tril_indices(held.shape[1])
        bands[0, i - j, j] += ((held.T * stiff) @ held)[i, j] / fourier.circumference_integral_factor(n)
        moved = np.zeros((free.size, 2))
        moved[free] = fourier.solve_harmonic_displacements(bands, n, rows.swapaxes(1, 2).reshape(-1, 2)[free])
        ends.append(moved.reshape(*grid.shape, 3, 2)[:, line].T)
    return SmoothBodyCompliance(tube, z, (), tuple(ends))


def slice_mean_weights(z: Array, slice_middle: float, half_thickness: float) -> tuple[Array, Array]:
    """Return the nodes' weights for the mean of a field, then for its mean first moment, over a slice of a shaft ``(k,)``.

    ``z`` ``(k,)``: positions of the nodes [m]. The slice reaches from ``slice_middle`` - ``half_thickness``
    to ``slice_middle`` + ``half_thickness`` [m]. The first weights give the mean of the field, the second ones the mean of
    the field times the distance from ``slice_middle`` [m]. Elements are quadratic.
    """
    out = np.zeros((2, z.size))
    for a in range(0, z.size - 2, 2):
        low, high = max(z[a], slice_middle - half_thickness), min(z[a + 2], slice_middle + half_thickness)
        if high > low:
            points = 0.5 * (low + high) + 0.5 * (high - low) * NODE
            N = fourier.quadratic_shape_functions(2.0 * (points - z[a]) / (z[a + 2] - z[a]) - 1.0)[0]
            weight = WEIGHT * (high - low) / (4.0 * half_thickness)
            out[:, a : a + 3] += np.stack([weight, weight * (points - slice_middle)]) @ N
    return out[0], out[1]


def low_end_spring_stiffnesses(tube: SmoothBody) -> tuple[float, float, float, float]:
    """Return the stiffnesses of the four springs that support the mean motions of a shaft's end at low z.

    They are, in order, those of lateral shift [N/m], tilt [N m], axial motion [N/m] and twist [N m]; the last two are equal
    to the first two.
    """
    stiff = tube.material.youngs_modulus * tube.outer_radius
    return stiff, stiff * tube.outer_radius**2, stiff, stiff * tube.outer_radius**2


def gaussian_weights_on_line(z: Array, patch_middles: Array, width: float) -> Array:
    """Return the weights ``(c, k)`` of k nodes for c Gaussian load patches on an axial grid line.

    ``z`` ``(k,)``: positions of the nodes [m]; ``patch_middles`` ``(c,)``: middles of the patches [m]; ``width``: standard
    deviation of the patches [m]. Elements are quadratic; the weights of a patch sum up to 1.
    """
    low, high = z[:-2:2], z[2::2]
    x = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * NODE
    density = np.exp(-0.5 * ((x[None] - patch_middles[:, None, None]) / width) ** 2)
    shares = (density * (0.5 * (high - low)[:, None] * WEIGHT)) @ SHAPES
    out = np.zeros((patch_middles.size, z.size))
    for k in range(3):
        out[:, k : k + z.size - 2 : 2] += shares[:, :, k]
    return np.asarray(out / out.sum(axis=1, keepdims=True))


def contact_compliance(compliance: SmoothBodyCompliance, points: ContactPoints, *, resultant: bool = True) -> Array:
    """Return the compliance ``(2 c, 2 c)`` [m/N] of a tube between c contacts, each a Gaussian patch with two axes.

    ``compliance``: compliance of the tube's nodes; ``points``: positions and axes of the contacts.

    Spreading a force around the axis multiplies its harmonic n by exp(-(n width / radius)^2 / 2). ``resultant``: whether
    harmonics 0 and 1 are left out of this reduction, so that a patch has the resultant of its force, to which the beam
    responds too; if False, they are reduced like the others, as for a true patch.

    In harmonic n a radial or axial load at azimuth s causes, at azimuth t, radial and axial motions ~ cos(n (t - s)) and
    circumferential motions ~ sin(n (t - s)); for a circumferential load it is the reverse. Only the angle between two
    contacts therefore has an influence.
    """
    from scipy.sparse import csr_array

    tube, k, count = compliance.tube, compliance.z.size, points.z.size
    order = np.argsort(points.z, kind="stable")
    azimuth, weights = points.azimuth[order], gaussian_weights_on_line(compliance.z, points.z[order], tube.patch_width)
    weights[np.abs(weights) <= UNREACHED] = 0.0
    near, touched = csr_array(weights), weights != 0.0
    first, last = touched.argmax(axis=1), k - touched[:, ::-1].argmax(axis=1)  # lines of each contact, in order
    chunks = [slice(i, min(i + CHUNK, count)) for i in range(0, count, CHUNK)]
    total = [np.zeros((count, len(PARTS), x.stop - x.start)) for x in chunks]
    for n, line in enumerate(compliance.line_compliance):
        S = line.full_matrix()[: 3 * k, : 3 * k].reshape(k, 3, k, 3)
        share = np.exp(-((n * tube.patch_width / tube.contact_radius) ** 2)) if n > 1 or not resultant else 1.0
        c, s = np.cos(n * azimuth), np.sin(n * azimuth)
        for loads, by_them in zip(chunks, total, strict=True):
            a, b = int(first[loads][0]), int(last[loads][-1])
            low, high = (x // 3 for x in line.nonzero_row_range(3 * a, 3 * b))
            high = min(high, k)
            moves = slice(int(np.searchsorted(last, low, "right")), int(np.searchsorted(first, high, "left")))
            parts = np.stack([S[low:high, i, a:b, j] for i, j in PARTS], axis=1).reshape(-1, b - a)
            by_load = (parts @ weights[loads, a:b].T).reshape(high - low, -1)
            moved = (near[moves, low:high] @ by_load).reshape(-1, len(PARTS), loads.stop - loads.start)
            moving, loading = share * np.stack([c[moves], s[moves]], axis=1), np.stack([c[loads], s[loads]])
            # cosine and sine of n times the angle between two contacts
            moved[:, :EVEN] *= (moving @ loading)[:, None]
            moved[:, EVEN:] *= (moving[:, ::-1] * [1.0, -1.0] @ loading)[:, None]
            by_them[moves] += moved
    G, places = np.empty((count, 2, count, 2)), np.argsort(order)
    for moves, by_these in zip(chunks, total, strict=True):
        block = np.empty((moves.stop - moves.start, 3, 3, count))
        of_these = np.concatenate([x[moves] for x in total], axis=2)
        for entry, (i, j) in enumerate(PARTS):
            block[:, i, j], block[:, j, i] = of_these[:, entry], by_these[:, entry].T
        one_side = points.axes[order[moves]] @ block.reshape(-1, 3, 3 * count)
        one_side = one_side.reshape(-1, 2, 3, count)[..., places].transpose(3, 0, 1, 2).reshape(count, -1, 3)
        G[order[moves]] = (one_side @ points.axes.swapaxes(1, 2)).reshape(count, -1, 2, 2).transpose(1, 2, 0, 3)
    square = G.reshape(2 * count, 2 * count)
    return np.asarray(0.5 * (square + square.T))


def move_contacts_to_surface(tube: SmoothBody, contact_points: Array) -> Array:
    """Move those of c contact points (c, 3) [m] that lie outside the tube's material radially to its surface."""
    far = np.hypot(contact_points[:, 0], contact_points[:, 1])
    across = np.clip(far, tube.bore_radius, tube.outer_radius) / far
    return np.asarray(contact_points * np.stack([across, across, np.ones(len(contact_points))], axis=1))


def contact_motions_by_rigid_motions(contact_points: Array, axes: Array, origin: float | None = None) -> Array:
    """Return the motions ``(2 c, 6)`` that six unit rigid motions of a section cause at c contacts, along two axes each.

    ``contact_points`` ``(c, 3)``: contact points [m]; ``axes`` ``(c, 2, 3)``: directions of their motions; ``origin``:
    axial position of the section's centre [m], None for the axial position of each contact. The rigid motions are three
    translations along x, y, z, then three rotations about these axes.
    """
    arm = contact_points * np.array([1.0, 1.0, 0.0]) if origin is None else contact_points - np.array([0.0, 0.0, origin])
    out = np.empty((*axes.shape[:2], 6))
    out[..., :3] = axes
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):  # the cross product of arm and axis
        out[..., 3 + i] = arm[:, j, None] * axes[..., k] - arm[:, k, None] * axes[..., j]
    return out.reshape(-1, 6)


def low_end_spring_compliance(tube: SmoothBody, contact_points: Array, axes: Array) -> Array:
    """Return the compliance ``(2 c, 2 c)`` [m/N] between c contacts that is due to the springs at a shaft's end at low z.

    The springs are those of `low_end_spring_stiffnesses`. ``contact_points`` ``(c, 3)``: contact points [m]; ``axes`` ``(c,
    2, 3)``: directions of their motions.
    """
    rows = contact_motions_by_rigid_motions(contact_points, axes, tube.ends[0])
    return np.asarray((rows / np.repeat(low_end_spring_stiffnesses(tube)[:2], 3)) @ rows.T)


def cantilever_compliance(
    rigid_motion_rows: Array, stations: Array, base: float, section: BeamSection, loaded: slice = slice(None)
) -> Array:
    """Return the compliance ``(k, m)`` of a Timoshenko cantilever: k motions of points on it by m unit loads along them.

    Parameters
    ----------
    rigid_motion_rows
        Displacement of each of the k points by six unit rigid motions of its cross-section ``(k, 6)``
        (`contact_motions_by_rigid_motions`).
    stations
        Axial positions of the cross-sections ``(k,)`` [m].
    base
        Axial position of the fixed end [m].
    section
        Section of the beam.
    loaded
        Selection of the m motions along which unit loads act.
    """
    left = (stations - base)[:, None]
    shift = rigid_motion_rows[:, :2]
    turn = rigid_motion_rows[:, [4, 3]] * np.array([1.0, -1.0])
    yielding = rigid_motion_rows[:, 2:] / np.array([section.EA, section.EI, section.EI, section.GJ])
    by = np.arange(len(rigid_motion_rows))[loaded]
    out = np.empty((len(rigid_motion_rows), by.size))
    for first in range(0, by.size, CHUNK):
        chunk = by[first : first + CHUNK]
        right = left[chunk, 0]
        m = np.where(left * right > 0.0, np.minimum(np.abs(left), np.abs(right)), 0.0)
        m1, m2 = 0.5 * m * m * np.sign(left), m * m * m / 3.0
        uu = (left * right * m - (left + right) * m1 + m2) / section.EI + m / section.kGA
        ur = (left * m - m1) / section.EI  # deflection by a moment
        ru = (right * m - m1) / section.EI
        G = uu * (shift @ shift[chunk].T) + ur * (shift @ turn[chunk].T) + ru * (turn @ shift[chunk].T)
        out[:, first : first + CHUNK] = G + m * (yielding @ rigid_motion_rows[chunk, 2:].T)
    return out


def compliance_of_local_groove_strains(
    section_strain_motions: Array, rigid_motion_rows: Array, stations: Array, base: float
) -> Array:
    """Return the compliance ``(k, k)`` [m/N] between k points of a beam that is due to additional strains at its grooves.

    ``section_strain_motions`` ``(k, 6)``: motion of each point by a unit wrench (three forces, three moments) that its
    cross-section transmits, which is the resultant of all loads beyond the section and of half the loads in it. By
    reciprocity a load at a section also moves all points beyond that section. ``base``: axial position at which the beam is
    fixed [m]; ``rigid_motion_rows``, ``stations``: see `cantilever_compliance`.
    """
    reach, side = stations[:, None] - stations, np.sign(stations - base)
    moved = rigid_motion_rows @ section_strain_motions.T + reach * (
        np.outer(rigid_motion_rows[:, 0], section_strain_motions[:, 4])
        - np.outer(rigid_motion_rows[:, 1], section_strain_motions[:, 3])
    )
    moved *= side * np.heaviside(reach * side, 0.5)
    return np.asarray(moved + moved.T)


def clamped_beam_compliance(
    rigid_motion_rows: Array,
    stations: Array,
    ends: tuple[float, float],
    clamped_ends: str,
    section: BeamSection,
    section_strain_motions: Array | None = None,
) -> Array:
    """Return the compliance ``(k, k)`` [m/N] between k points of a Timoshenko beam that is clamped at one or both ends.

    ``rigid_motion_rows``, ``stations``: see `cantilever_compliance`; ``ends``: axial positions of the low and the high end
    [m]; ``clamped_ends``: clamped ends, "low", "high" or "both"; ``section_strain_motions``: local motions at grooves, see
    `compliance_of_local_groove_strains`, None to neglect them.
    """
    low, high = ends
    if clamped_ends != "both":
        base = low if clamped_ends == "low" else high
        G = cantilever_compliance(rigid_motion_rows, stations, base, section)
        if section_strain_motions is None:
            return G
        return G + compliance_of_local_groove_strains(section_strain_motions, rigid_motion_rows, stations, base)
    rigid_motion_rows, stations = np.concatenate([rigid_motion_rows, np.eye(6)]), np.append(stations, np.full(6, high))
    G, k = cantilever_compliance(rigid_motion_rows, stations, low, section), len(rigid_motion_rows) - 6
    if section_strain_motions is not None:
        local = np.concatenate([section_strain_motions, np.zeros((6, 6))])
        G += compliance_of_local_groove_strains(local, rigid_motion_rows, stations, low)
    return np.asarray(G[:k, :k] - G[:k, k:] @ np.linalg.solve(G[k:, k:], G[k:, :k]))
