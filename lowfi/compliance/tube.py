"""Plain tube or shaft loaded over small patches on its groove: compliance between contacts by Fourier harmonics.

Section constants of a grooved shaft or nut from half a lead of it, a ring groove in place of the helix: the groove has the
exact axial section of the helical one. Between two planes of symmetry (mid groove, mid land) the cell is stretched, twisted
and bent by the motions that symmetry leaves to those planes; its strain energy gives EA, GJ and EI.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import pi

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.compliance.fourier import (
    BlockSum,
    Body,
    Grid,
    Layer,
    end_motions,
    factor_c,
    line_compliance,
    quadratic_shape_functions,
    refine_lines,
    solve_harmonic,
    tube_grid,
)
from rollbench.meshes.arrays import Array
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import Flange, Material
from rollbench.meshes.section import BeamSection, shear_coefficient, tube_section

#: Elements of the cell: along the groove's flank, along the land, and in depth.
MESH = (8, 5, 8)


@dataclass(frozen=True)
class CellSection:
    """Beam section of a grooved body."""

    #: Section constants.
    section: BeamSection
    #: Free radii [m] of plain bodies of equal axial, bending and torsional stiffness: outer radius of a shaft, bore radius
    #: of a nut.
    radii: tuple[float, float, float]


def groove_line(m: GrooveMap, land: float, screw: bool, count: int) -> tuple[Array, Array]:
    """Return points (r, zeta) ``(count,)`` [m] of one flank from the apex (zeta = 0) to the edge of the land.

    Raises
    ------
    ValueError
        A land whose cylinder does not cut the flank.
    """
    side = 1 if screw else 3
    centre, radius = m.centre[side], m.radius[side]
    apex = np.arcsin(np.clip(-m.signs[side, 1] * centre[1] / radius, -1.0, 1.0))
    low, high = apex, 0.5 * pi - 1e-6
    sign = -1.0 if screw else 1.0

    def beyond(gamma: float) -> bool:
        x3, z3 = m.section_point(side, np.array(gamma), radius)
        return bool(sign * (float(m.unroll(x3, z3)[0]) - land) < 0.0)

    if beyond(low) or not beyond(high):
        raise ValueError("the land's cylinder does not cut the groove")
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if beyond(middle) else (middle, high)
    x3, z3 = m.section_point(side, np.linspace(apex, low, count), radius)
    r, zeta, _ = m.unroll(x3, z3)
    zeta[0], r[-1] = 0.0, land
    return r, zeta


def cell_grid(
    m: GrooveMap, land: float, far: float, screw: bool, mesh: tuple[int, int, int] = MESH, half: float | None = None
) -> Grid:
    """Return the grid of half a lead of the body between mid groove and mid land.

    Parameters
    ----------
    m
        Geometry of the groove.
    land
        Radius of the lands [m].
    far
        Radius of the plain surface, bore or outer radius [m].
    screw
        Whether of the screw; otherwise of the nut.
    mesh
        Numbers of elements.
    half
        Length of a body without lead on each side of its groove [m].

    Raises
    ------
    ValueError
        Grooves of neighbouring turns that overlap.
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
    """Return the section constants of a grooved shaft or nut.

    Shear as for the plain section of equal torsional stiffness: both are shear along the axis.

    Parameters
    ----------
    m
        Geometry of the groove; a track without lead has no cell.
    land
        Radius of the lands [m].
    far
        Bore radius of the shaft, or outer radius of the nut [m].
    screw
        Whether of the screw; otherwise of the nut.
    material
        Of the body.
    """
    if m.rg == 0.0:
        raise ValueError("a track without lead has no repeating cell")
    grid = cell_grid(m, land, far, screw)
    young, poisson = material.youngs_modulus, material.poissons_ratio
    body = Body(grid, young, poisson)
    length = float(grid.z[-1, 0])
    EA, GJ, EI = (cell_stiffness(body, kind) * length for kind in ("axial", "torsion", "bending"))
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


def cell_stiffness(body: Body, kind: str) -> float:
    """Return the stiffness of the cell [N/m or N m] (`strained_cell`)."""
    return strained_cell(body, kind)[0]


def strained_cell(body: Body, kind: str) -> tuple[float, Array]:
    """Return the stiffness of the cell [N/m or N m] and its motion ``(lines in z, lines in r, 3)`` [m].

    The stiffness is twice the energy when its far plane of symmetry moves by one unit. axial: u_z = 1; torsion: u_t = r;
    bending: u_z = r cos t.
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
    q[~held] = solve_harmonic(body.bands(~held), n, -(K @ q)[~held])
    return float(q @ (K @ q)), q.reshape(*shape, 3)


#: Which motion (r, t, z) by which load the parts of a harmonic hold. The first ``EVEN`` go as the cosine of its multiple of
#: the angle between two contacts, the others as the sine.
PARTS = ((0, 0), (1, 1), (2, 2), (0, 2), (1, 0), (1, 2))

EVEN = 4

#: Share of a patch on a node below which the patch does not reach it: less than round-off.
UNREACHED = 1e-18

#: Contacts whose loads are taken at once.
CHUNK = 64

#: Half the thickness of the slice of a shaft that a load on one of its sections acts on, over the shaft's radius.
SLICE = 0.25

#: Lines of a grid as near as this [m] are one; ends of elements as near to a flange's, over their length, give way to it.
SAME, NEAR = 1e-9, 0.4

#: Points and weights of the quadrature over a patch, and the shapes of an element there.
NODE, WEIGHT = np.polynomial.legendre.leggauss(8)

SHAPES = quadratic_shape_functions(NODE)[0]


@dataclass(frozen=True)
class Tube:
    """Plain body of revolution that represents screw or nut."""

    #: Bore radius [m].
    bore: float
    #: Outer radius [m].
    outer: float
    #: Stations of its ends [m].
    ends: tuple[float, float]
    #: Where it is fixed: ``"low"``, ``"high"``, ``"both"`` faces, ``"bore"``, ``"outer"``, ``"flange"``, or ``"section"``:
    #: its low end on springs by its mean motions.
    held: str
    #: Radius at which contacts load it [m].
    radius: float
    #: Standard deviation of the patches [m].
    width: float
    #: Number of harmonics.
    harmonics: int
    #: Element sizes in z and r [m].
    size: tuple[float, float]
    #: Material of the body.
    material: Material
    #: Layer that represents grooves in its bore.
    layer: Layer | None = None
    #: Flange around it.
    flange: Flange | None = None

    def body(self, grid: Grid) -> Body:
        """Return the stiffness of the tube on a grid, which may extend beyond the tube around a flange."""
        return Body(grid, self.material.youngs_modulus, self.material.poissons_ratio, self.layer, self.solid(grid))

    def solid(self, grid: Grid) -> NDArray[np.bool_]:
        """Return which elements of a grid the tube fills ``(elements,)``; with the sleeve, those of the flange."""
        r, z = (x[1::2, 1::2].ravel() for x in (grid.r, grid.z))
        if self.flange is None:
            return np.ones(r.size, dtype=bool)
        end, face, _ = self.flange.stations(*self.ends)
        return np.asarray((r < self.outer) | ((z > min(end, face)) & (z < max(end, face))))

    @cached_property
    def section(self) -> BeamSection:
        """Return the beam that stretches, twists and bends like it far from loads and ends."""
        if self.layer is None:
            return tube_section(2.0 * self.outer, 2.0 * self.bore, self.material)
        length = self.size[0]
        slice_ = self.body(tube_grid(radial_ends(self)[0], np.array([0.0, length])))
        EA, GJ, EI = (length * cell_stiffness(slice_, kind) for kind in ("axial", "torsion", "bending"))
        shear, poisson = self.material.shear_modulus, self.material.poissons_ratio
        bore = (self.outer**4 - 2.0 * GJ / (shear * np.pi)) ** 0.25
        kappa = shear_coefficient(bore / self.outer, poisson)
        return BeamSection(EA, EI, GJ, kappa * shear * np.pi * (self.outer**2 - bore**2))


@dataclass(frozen=True)
class TubeCompliance:
    """Motion of the loaded grid line by loads on it, at k stations."""

    #: The body.
    tube: Tube
    #: Stations ``(k,)`` [m].
    z: Array
    #: For each harmonic a symmetric matrix ``(3 k, 3 k)`` [m/N], freedoms r, t, z station by station. Of a shaft fixed by
    #: its section, in harmonics 0 and 1, two rows and columns more, for loads on the mean motions of its high end.
    line: tuple[BlockSum, ...]
    #: Motion of the line (r, t, z) by those loads ``(2, 3, k)``.
    ends: tuple[Array, ...] = ()
    #: Mean motions of the high end by those loads ``(2, 2)``.
    corner: tuple[Array, ...] = ()


@dataclass(frozen=True)
class Points:
    """Contact points on a body."""

    #: ``(c,)`` [rad].
    azimuth: Array
    #: ``(c,)`` [m].
    z: Array
    #: Axes of their motion in (r, t, z) there ``(c, 2, 3)``.
    axes: Array


def points_in_space(x: Array, axes: Array) -> Points:
    """Return points ``(c, 3)`` [m] and axes ``(c, 2, 3)`` in space in cylindrical components."""
    t = np.arctan2(x[:, 1], x[:, 0])
    c, s = np.cos(t), np.sin(t)
    r_hat = np.stack([c, s, 0 * c], axis=-1)
    t_hat = np.stack([-s, c, 0 * c], axis=-1)
    parts = (np.einsum("cak,ck->ca", axes, r_hat), np.einsum("cak,ck->ca", axes, t_hat), axes[..., 2])
    return Points(t, x[:, 2], np.stack(parts, axis=-1))


def radial_ends(tube: Tube) -> tuple[Array, int]:
    """Return element ends in r with one at the loaded radius, fine near it, and the index of that node line."""
    low, high, at = tube.bore, tube.outer, float(np.clip(tube.radius, tube.bore, tube.outer))
    h = tube.size[1]

    def graded(length: float) -> Array:
        count = max(1, round(2.0 * (np.sqrt(1.0 + length / h) - 1.0)))
        return np.asarray(length * (np.arange(count + 1) / count) ** 1.6)

    inner = at - graded(at - low)[::-1] if at > low else np.array([at])
    inner[0] = low
    outer = np.array([at])
    for end in (high,) if tube.layer is None else (tube.layer.radii[-1], high):  # none of them across the layer's end
        if end > outer[-1]:
            outer = np.append(outer, outer[-1] + graded(end - outer[-1])[1:])
    return np.append(inner, outer[1:]), 2 * (inner.size - 1)


def axial_ends(tube: Tube, zone: tuple[float, float]) -> Array:
    """Return element ends in z: uniform over ``zone`` [m], which the contacts load, growing beyond it."""
    (low, high), h = tube.ends, tube.size[0]
    a, b = max(low, zone[0]), min(high, zone[1])
    middle = np.linspace(a, b, max(2, int(np.ceil((b - a) / h))) + 1)

    def beyond(length: float) -> Array:
        if length <= 0.0:
            return np.zeros(0)
        count = max(1, round(2.5 * (np.sqrt(1.0 + length / h) - 1.0)))
        return np.asarray(length * (np.arange(1, count + 1) / count) ** 1.5)

    return np.concatenate([a - beyond(a - low)[::-1], middle, b + beyond(high - b)])


def add_flange_ends(tube: Tube, r_ends: Array, z_ends: Array) -> tuple[Array, Array]:
    """Return element ends in r and z with those of the tube's flange and of where it may be fixed."""
    if tube.flange is None:
        return r_ends, z_ends
    size, stops = tube.size[0], np.unique([tube.outer, *tube.flange.seat, tube.flange.diameter / 2.0])
    for low, high in pairwise(stops[np.diff(stops, prepend=0.0) > SAME]):
        r_ends = np.append(r_ends, np.linspace(low, high, int(np.ceil((high - low) / size)) + 1)[1:])
    stations = np.array(tube.flange.stations(*tube.ends))
    far = (np.abs(z_ends[:, None] - stations) > NEAR * size).all(axis=1)
    far[[0, -1]] = True
    z_ends = np.sort(np.append(z_ends[far], stations))
    return r_ends, z_ends[np.diff(z_ends, prepend=-np.inf) > SAME]


def fixed_freedoms(tube: Tube, grid: Grid) -> NDArray[np.bool_]:
    """Return which freedoms ``(3 nodes,)`` of a grid are fixed, with those of nodes beyond the tube."""
    beyond = np.ones(grid.r.size, dtype=bool)
    beyond[grid.cells()[tube.solid(grid)].ravel()] = False
    held = np.repeat(beyond, 3).reshape(*grid.shape, 3)
    if tube.held in ("low", "both"):
        held[0] = True
    if tube.held in ("high", "both"):
        held[-1] = True
    if tube.held == "bore":
        held[:, 0] = True
    if tube.held == "outer":
        held[np.abs(grid.r - tube.outer) < SAME] = True
    if tube.held == "flange" and tube.flange is not None:
        (low, high), (_, face, fit) = tube.flange.seat, tube.flange.stations(*tube.ends)
        held[(np.abs(grid.z - face) < SAME) & (grid.r > low - SAME) & (grid.r < high + SAME)] = True
        if tube.flange.bonded:
            between = (grid.z > min(face, fit) - SAME) & (grid.z < max(face, fit) + SAME)
            held[(np.abs(grid.r - tube.outer) < SAME) & between] = True
    return held.ravel()


def tube_compliance(tube: Tube, zone: tuple[float, float]) -> TubeCompliance:
    """Return compliance of the loaded line for all harmonics; ``zone``: stretch in z [m] that contains every contact."""
    r_ends, line = radial_ends(tube)
    grid = tube_grid(*add_flange_ends(tube, r_ends, axial_ends(tube, zone)))
    z = grid.z[:, 0]
    inside = np.flatnonzero((z >= zone[0] - 1e-9) & (z <= zone[1] + 1e-9))
    first, last = int(inside[0]) // 2 * 2, (int(inside[-1]) + 1) // 2 * 2
    rows = (first, last + 1)
    body = tube.body(grid)
    held = fixed_freedoms(tube, grid)
    springs = end_springs(tube) if tube.held == "section" else ()
    by_harmonic = line_compliance(body, range(tube.harmonics + 1), held, line, rows, springs)
    size = 3 * (rows[1] - rows[0])
    by_end = [S.whole()[size:] for S in by_harmonic[:2]] if springs else []
    ends, corner = tuple(S[:, :size].reshape(2, -1, 3).swapaxes(1, 2) for S in by_end), tuple(S[:, size:] for S in by_end)
    return TubeCompliance(tube, z[rows[0] : rows[1]], tuple(by_harmonic), ends, corner)


def motions_by_section_load(tube: Tube, zone: tuple[float, float], at: float) -> TubeCompliance:
    """Return the motion ``(2, 3, k)`` (`TubeCompliance.ends`) of the loaded line of a shaft by loads on a section.

    The shaft is fixed by its low section; the loads act on the mean rigid motions, by least squares, of the material in a
    slice at the station ``at`` [m] of its stretch.
    """
    r_ends, line = radial_ends(tube)
    grid = tube_grid(r_ends, axial_ends(tube, zone))
    body, z, half = tube.body(grid), grid.z[:, 0], min(SLICE * tube.outer, at - tube.ends[0], tube.ends[1] - at)
    shares, levers = slice_shares(z, at, half)
    inertia, springs, ends = 0.25 * (tube.outer**2 + tube.bore**2), end_springs(tube), []
    for n, stiff in ((0, springs[2:]), (1, springs[:2])):
        free, motions = body.axis_free(n), end_motions(body, n)
        rows = shares[:, None, None] * motions
        if n == 1:
            rows[:, 1] = (inertia * rows[:, 1] + levers[:, None] * motions[0]) / (inertia + half**2 / 3.0)
        bands, held = body.bands(free), motions[:, free[: motions.shape[1]]]
        i, j = np.tril_indices(held.shape[1])
        bands[0, i - j, j] += ((held.T * stiff) @ held)[i, j] / factor_c(n)
        moved = np.zeros((free.size, 2))
        moved[free] = solve_harmonic(bands, n, rows.swapaxes(1, 2).reshape(-1, 2)[free])
        ends.append(moved.reshape(*grid.shape, 3, 2)[:, line].T)
    return TubeCompliance(tube, z, (), tuple(ends))


def slice_shares(z: Array, at: float, half: float) -> tuple[Array, Array]:
    """Return the shares ``(k,)`` of nodes z ``(k,)`` of quadratic elements in two means over a slice around a station [m].

    The mean of what is in the slice, ``half`` [m] on either side, and that of it times its distance [m] from the station.
    """
    out = np.zeros((2, z.size))
    for a in range(0, z.size - 2, 2):
        low, high = max(z[a], at - half), min(z[a + 2], at + half)
        if high > low:
            points = 0.5 * (low + high) + 0.5 * (high - low) * NODE
            N = quadratic_shape_functions(2.0 * (points - z[a]) / (z[a + 2] - z[a]) - 1.0)[0]
            weight = WEIGHT * (high - low) / (4.0 * half)
            out[:, a : a + 3] += np.stack([weight, weight * (points - at)]) @ N
    return out[0], out[1]


def end_springs(tube: Tube) -> tuple[float, float, float, float]:
    """Return springs [N/m, N m] at the low end of a shaft fixed by its mean motions: shift, tilt, axial, twist."""
    stiff = tube.material.youngs_modulus * tube.outer
    return stiff, stiff * tube.outer**2, stiff, stiff * tube.outer**2


def patch_weights(z: Array, at: Array, width: float) -> Array:
    """Return shares ``(c, k)`` of a Gaussian patch around ``at`` ``(c,)`` on the nodes of quadratic elements z ``(k,)``."""
    low, high = z[:-2:2], z[2::2]
    x = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * NODE
    density = np.exp(-0.5 * ((x[None] - at[:, None, None]) / width) ** 2) * (0.5 * (high - low)[:, None] * WEIGHT)
    shares = density @ SHAPES
    out = np.zeros((at.size, z.size))
    for k in range(3):
        out[:, k : k + z.size - 2 : 2] += shares[:, :, k]
    return np.asarray(out / out.sum(axis=1, keepdims=True))


def contact_compliance(compliance: TubeCompliance, points: Points, *, resultant: bool = True) -> Array:
    """Return the compliance ``(2 c, 2 c)`` [m/N] between all contacts, each a Gaussian patch with two axes.

    Spreading a force around the axis lessens what it does to harmonic n by exp(-(n width / radius)^2 / 2), but for 0 and 1:
    there a patch must have the resultant of its force, to which a beam responds too (``resultant``; else they are lessened
    like the others, as a true patch is).

    A load at azimuth s makes cos(n (t - s)) of radial and axial motion and sin(n (t - s)) of the other (the reverse if it
    acts around the axis), so that only the angle between two contacts counts.
    """
    from scipy.sparse import csr_array

    tube, k, count = compliance.tube, compliance.z.size, points.z.size
    order = np.argsort(points.z, kind="stable")
    azimuth, weights = points.azimuth[order], patch_weights(compliance.z, points.z[order], tube.width)
    weights[np.abs(weights) <= UNREACHED] = 0.0
    near, touched = csr_array(weights), weights != 0.0
    first, last = touched.argmax(axis=1), k - touched[:, ::-1].argmax(axis=1)  # lines of each contact, in order
    chunks = [slice(i, min(i + CHUNK, count)) for i in range(0, count, CHUNK)]
    total = [np.zeros((count, len(PARTS), x.stop - x.start)) for x in chunks]
    for n, line in enumerate(compliance.line):
        S = line.whole()[: 3 * k, : 3 * k].reshape(k, 3, k, 3)
        share = np.exp(-((n * tube.width / tube.radius) ** 2)) if n > 1 or not resultant else 1.0
        c, s = np.cos(n * azimuth), np.sin(n * azimuth)
        for loads, by_them in zip(chunks, total, strict=True):
            a, b = int(first[loads][0]), int(last[loads][-1])
            low, high = (x // 3 for x in line.reach(3 * a, 3 * b))
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


def project_on_surface(tube: Tube, x: Array) -> Array:
    """Return the points ``(c, 3)`` [m] at which a tube takes the loads of contacts at x.

    They lie on its surface where the contacts lie outside it.
    """
    far = np.hypot(x[:, 0], x[:, 1])
    return np.asarray(x * np.stack([np.clip(far, tube.bore, tube.outer) / far] * 2 + [np.ones(len(x))], axis=1))


def motion_rows(x: Array, axes: Array, origin: float | None = None) -> Array:
    """Return the motion of contacts along their axes by that of their section ``(2 c, 6)``.

    Contacts ``(c, 3)`` [m], axes ``(c, 2, 3)``; the section taken at each contact's station or at ``origin`` [m].
    """
    arm = x * np.array([1.0, 1.0, 0.0]) if origin is None else x - np.array([0.0, 0.0, origin])
    out = np.empty((*axes.shape[:2], 6))
    out[..., :3] = axes
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):  # the cross product of arm and axis
        out[..., 3 + i] = arm[:, j, None] * axes[..., k] - arm[:, k, None] * axes[..., j]
    return out.reshape(-1, 6)


def spring_compliance(tube: Tube, x: Array, axes: Array) -> Array:
    """Return the share ``(2 c, 2 c)`` of the end springs in the compliance of a shaft fixed by its section."""
    shift, tilt, axial, twist = end_springs(tube)
    rows = motion_rows(x, axes, tube.ends[0])
    return np.asarray((rows / np.array([shift, shift, axial, tilt, tilt, twist])) @ rows.T)


def cantilever_compliance(
    rows: Array, stations: Array, base: float, section: BeamSection, loaded: slice = slice(None)
) -> Array:
    """Return the compliance ``(k, m)`` of motions on a Timoshenko cantilever.

    Parameters
    ----------
    rows
        Of the section's motion ``(k, 6)``.
    stations
        ``(k,)`` [m].
    base
        Station of the fixed end [m].
    section
        Of the beam.
    loaded
        Which m of the motions are loaded.
    """
    left, shift, turn = (stations - base)[:, None], rows[:, :2], rows[:, [4, 3]] * np.array([1.0, -1.0])
    yielding = rows[:, 2:] / np.array([section.EA, section.EI, section.EI, section.GJ])
    by = np.arange(len(rows))[loaded]
    out = np.empty((len(rows), by.size))
    for first in range(0, by.size, CHUNK):
        chunk = by[first : first + CHUNK]
        right = left[chunk, 0]
        m = np.where(left * right > 0.0, np.minimum(np.abs(left), np.abs(right)), 0.0)
        m1, m2 = 0.5 * m * m * np.sign(left), m * m * m / 3.0
        uu = (left * right * m - (left + right) * m1 + m2) / section.EI + m / section.kGA
        ur = (left * m - m1) / section.EI  # deflection by a moment
        ru = (right * m - m1) / section.EI
        G = uu * (shift @ shift[chunk].T) + ur * (shift @ turn[chunk].T) + ru * (turn @ shift[chunk].T)
        out[:, first : first + CHUNK] = G + m * (yielding @ rows[chunk, 2:].T)
    return out


def section_jump_compliance(feel: Array, rows: Array, stations: Array, base: float) -> Array:
    """Return what ``feel`` ``(k, 6)`` adds to the compliance ``(k, k)`` of motions fixed at ``base`` [m].

    feel: motion of each by the wrench, on its section, of all loads beyond its station and half of those at it. By
    reciprocity its load moves all that is beyond.
    """
    reach, side = stations[:, None] - stations, np.sign(stations - base)
    moved = rows @ feel.T + reach * (np.outer(rows[:, 0], feel[:, 4]) - np.outer(rows[:, 1], feel[:, 3]))
    moved *= side * np.heaviside(reach * side, 0.5)
    return np.asarray(moved + moved.T)


def clamped_beam_compliance(
    rows: Array, stations: Array, ends: tuple[float, float], held: str, section: BeamSection, feel: Array | None = None
) -> Array:
    """Return the compliance ``(k, k)`` of motions on a Timoshenko beam clamped at its "low", "high" or "both" ends [m].

    feel: see `section_jump_compliance`.
    """
    low, high = ends
    if held != "both":
        base = low if held == "low" else high
        G = cantilever_compliance(rows, stations, base, section)
        return G if feel is None else G + section_jump_compliance(feel, rows, stations, base)
    rows, stations = np.concatenate([rows, np.eye(6)]), np.append(stations, np.full(6, high))
    G, k = cantilever_compliance(rows, stations, low, section), len(rows) - 6
    if feel is not None:
        G += section_jump_compliance(np.concatenate([feel, np.zeros((6, 6))]), rows, stations, low)
    return np.asarray(G[:k, :k] - G[:k, k:] @ np.linalg.solve(G[k:, k:], G[k:, :k]))
