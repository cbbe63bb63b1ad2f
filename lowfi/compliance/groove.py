"""Corrections of the smooth body of revolution for its groove: radius of its surface, and compliance of the true flank.

The motion of a contact by its own load is the sum of three terms: that of the smooth body under a wide patch; the
difference between the true flank under a narrow patch and the smooth body under the wide one, both on half a lead with the
same supports; and minus that of a half space under the narrow patch, which Hertz's law contains already. Pressure acts
along the flank's normals, whose direction varies over the patch, and motions are measured along them; loads in one fixed
direction would give a motion larger by (1 - 2 nu)/(8 pi G rho). For contacts smaller than the narrow patch only the flank's
curvature has an influence, through the logarithm of the contact's size and through its shape (`contact_size_correction`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rollbench.lowfi.compliance import fourier, tube
from rollbench.lowfi.compliance.beyond_hertz import NARROW
from rollbench.lowfi.compliance.tube import HalfGroove
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.numerics import brentq
from rollbench.meshes.section import BeamSection

#: Least fraction of a cylinder through the grooves that counts as filled with material.
LEAST_SHARE = 0.02
#: Largest exponent of the filled fraction in the stiffness of a layer along the axis.
LARGEST_POWER = 200.0


def equivalent_cylinder_radius(flank: HalfGroove, power: int) -> float:
    """Return the radius of the smooth cylinder that replaces the grooved surface of screw or nut [m].

    ``flank``: groove of the body; ``power``: 2 for the same volume of the body; 3, for a nut, for the same mean cube of the
    wall thickness, to which the bending stiffness of a ring is proportional.
    """
    grid = flank.finite_element_grid()
    r, z = grid.r[:, flank.surface_line], grid.z[:, flank.surface_line]
    f = r**2 if power == 2 else (flank.plain_radius - r) ** 3
    mean = float(((f[:-2:2] + 4.0 * f[1:-1:2] + f[2::2]) / 6.0 * (z[2::2] - z[:-2:2])).sum() / z[-1])
    return float(np.sqrt(mean)) if power == 2 else flank.plain_radius - float(np.cbrt(mean))


def groove_layer(flank: HalfGroove, section: BeamSection) -> fourier.GrooveLayer:
    """Return the anisotropic layer that represents the nut's grooves, between the radii of lands and groove bottom.

    With it the smooth nut has the axial and torsional stiffness of the grooved ``section``.
    """
    r, zeta = (x[::-1] for x in flank.profile_points(33))
    share = np.maximum(1.0 - zeta / flank.half_length, LEAST_SHARE)
    young, shear, (root, far) = flank.material.youngs_modulus, flank.material.shear_modulus, (r[-1], flank.plain_radius)
    area = section.EA / (np.pi * young) - (far**2 - root**2)
    twist = 2.0 * section.GJ / (np.pi * shear) - (far**4 - root**4)

    def stiffness_exponent(weight: Array, wanted: float) -> float:
        """Return the exponent p for which ``weight`` (filled fraction)^p, integrated over the layer, gives ``wanted``."""
        exponent = brentq(lambda p: float(np.trapezoid(weight * share**p, r)) - wanted, 1e-3, LARGEST_POWER)
        return float(exponent)

    tilt = float(np.arctan(flank.groove_map.rg / flank.contact_position()[0]))
    exponents = (stiffness_exponent(2.0 * r, area), stiffness_exponent(4.0 * r**3, twist))
    return fourier.GrooveLayer(tuple(r), tuple(share), *exponents, tilt)


def contact_motions_by_tension_and_moment(flank: HalfGroove, smooth: tube.SmoothBody) -> Array:
    """Return the local motions ``(2, 2)`` of a contact along r and z by a unit tension, then by a unit bending moment.

    Tension and moment act on the contact's cross-section; the motions are in m/N and 1/N. The contact is on the flank at
    positive z, and the moment stretches the body's side with the contact. Motions of a beam as stiff as the grooved body,
    and local motions of the smooth body, are subtracted. A remainder is left because at a groove the body is thinner, and
    strains more, than on average. ``flank``: groove of the body; ``smooth``: smooth body of revolution.
    """
    grid, (radius, zeta) = flank.finite_element_grid(), flank.contact_position()
    line, (r_ends, loaded) = flank.surface_line, tube.radial_element_ends(smooth)
    share = gaussian_patch_weights(grid, line, zeta, NARROW * flank.groove_map.ball)
    plain = fourier.tube_grid(r_ends, np.array([0.0, flank.half_length]))
    out = np.empty((2, 2))
    for k, kind in enumerate(("axial", "bending")):
        stiffness, motion = tube.solve_half_lead_under_unit_motion(fourier.BodyOfRevolution(grid, flank.material), kind)
        smooth_stiffness, smooth_motion = tube.solve_half_lead_under_unit_motion(smooth.finite_element_body(plain), kind)
        at = share @ motion[:, line, ::2] - (radius if k else 1.0) * np.array([0.0, zeta / flank.half_length])
        widens = float(smooth_motion[0, loaded, 0])
        if kind == "bending":  # from the beam's axis, the mean of the section, which bends away from the stretched side
            axis = [float(fourier.mean_rigid_motion_matrix(grid.r[i], 1)[0] @ motion[i].ravel()) for i in (0, -1)]
            at[0] += (zeta**2 - 0.5 * flank.half_length**2) / (2.0 * flank.half_length) - 0.5 * sum(axis)
            widens -= float(fourier.mean_rigid_motion_matrix(plain.r[0], 1)[0] @ smooth_motion[0].ravel())
            widens -= smooth.patch_width**2 / (2.0 * flank.half_length)
        out[k] = at / stiffness - np.array([widens, 0.0]) / smooth_stiffness
    return out


def gaussian_patch_weights(grid: fourier.QuadrilateralGrid, line: int, zeta: float, width: float, moment: int = 0) -> Array:
    """Return the weights ``(k,)`` of a Gaussian load patch on k surface nodes of a flank, then their axial positions.

    The patch is Gaussian in the arc length from the point at z = ``zeta`` and has the standard deviation ``width`` [m].
    ``line``: number of the grid line on the surface; ``moment``: 0, or 1 to multiply the density by the arc length over the
    width.
    """
    r, z = grid.r[:, line], grid.z[:, line]
    node, weight = np.polynomial.legendre.leggauss(8)
    N, slope = fourier.quadratic_shape_functions(node)
    fine = np.linspace(-1.0, 1.0, 65)
    fine_slope = fourier.quadratic_shape_functions(fine)[1]
    start, arcs, heights, sizes = 0.0, [], [], []
    for a in range(0, r.size - 2, 2):
        speed = np.hypot(fine_slope @ r[a : a + 3], fine_slope @ z[a : a + 3])
        along = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(fine))])
        arcs.append(start + np.interp(node, fine, along))
        heights.append(N @ z[a : a + 3])
        sizes.append(np.hypot(slope @ r[a : a + 3], slope @ z[a : a + 3]) * weight)
        start += float(along[-1])
    s = np.concatenate(arcs)
    centre = float(np.interp(zeta, np.concatenate(heights), s))
    away = (s - centre) / width
    density = np.exp(-0.5 * away**2) * np.concatenate(sizes)
    density /= density.sum()
    out = np.zeros(r.size)
    for e, a in enumerate(range(0, r.size - 2, 2)):
        out[a : a + 3] += N.T @ (density * away**moment)[8 * e : 8 * e + 8]
    return out


def sampled_harmonics(limit: float, step: float = 1.28, first: int = 0) -> Array:
    """Return the numbers of the Fourier harmonics that are computed; the others are interpolated (`interpolate_harmonics`).

    ``limit``: number that the highest computed harmonic must reach; ``step``: ratio of successive harmonics above the
    fourth (up to the fourth all are computed); ``first``: lowest harmonic.
    """
    harmonics = [first]
    while harmonics[-1] < limit:
        harmonics.append(max(harmonics[-1] + 1, int(np.ceil(step * harmonics[-1])) if harmonics[-1] > 3 else 0))
    return np.array(harmonics)


def cubic_spline(known: ArrayLike, values: Array) -> Callable[[Array], Array]:
    """Return the cubic spline, as a function of position, through values ``(k, ...)`` at the positions ``known`` ``(k,)``.

    scipy.interpolate is imported here because it loads slowly and is not needed if the compliance is in the cache.
    """
    from scipy.interpolate import CubicSpline

    found: Callable[[Array], Array] = CubicSpline(known, values)
    return found


def interpolate_harmonics(harmonics: Array, values: Array) -> Array:
    """Interpolate values ``(k, ...)``, computed for k harmonics, to all harmonics from the first to the last."""
    return np.asarray(cubic_spline(np.log1p(harmonics), values)(np.log1p(np.arange(harmonics[0], harmonics[-1] + 1))))


def flank_normals(grid: fourier.QuadrilateralGrid, line: int) -> Array:
    """Return unit normals ``(k, 2)`` (r, z) of a body's surface at k nodes of a grid line.

    At a node between two elements they are averaged over both. Whether they point into or out of the body is not defined.
    """
    r, z = grid.r[:, line], grid.z[:, line]
    slope = fourier.quadratic_shape_functions(np.array([-1.0, 0.0, 1.0]))[1]
    along = np.zeros((r.size, 2))
    for a in range(0, r.size - 2, 2):
        tangent = slope @ np.column_stack([r[a : a + 3], z[a : a + 3]])
        along[a : a + 3] += tangent / np.linalg.norm(tangent, axis=1)[:, None]
    along /= np.linalg.norm(along, axis=1)[:, None]
    return np.column_stack([-along[:, 1], along[:, 0]])


def nodal_forces_along_flank_normals(
    flank: HalfGroove, grid: fourier.QuadrilateralGrid, width: float, zeta: float
) -> Array:
    """Return the nodal forces ``(k, 2)`` (r, z) of a patch of unit load along the flank's normals, at z = ``zeta`` [m].

    ``grid``: grid of the body; ``width``: standard deviation of the Gaussian patch [m].
    """
    share, normals = gaussian_patch_weights(grid, flank.surface_line, zeta, width), flank_normals(grid, flank.surface_line)
    return np.asarray(share[:, None] * normals * np.sign(normals @ flank.nominal_normal)[:, None])


def patch_self_motion_harmonics(
    flank: HalfGroove, grid: fourier.QuadrilateralGrid, force: Array, harmonics: Array
) -> Array:
    """Return the motion of a load patch on one flank by its own unit load in each harmonic [m/N].

    It is the mean of the motions by loads on both flanks, symmetric and antisymmetric to mid groove. ``force``: nodal
    forces ``(lines in z, lines in r, 3)`` of the patch on the grid ``grid``.
    """
    rows, columns = grid.shape
    turned = fourier.QuadrilateralGrid(grid.r[::-1], -grid.z[::-1])  # so that the plane at mid groove is last
    body = fourier.BodyOfRevolution(turned, flank.material)
    loads = (force[::-1] * np.array([1.0, 1.0, -1.0])).reshape(-1, 1)
    held = np.zeros((rows, columns, 3), dtype=bool)
    held[0] = True
    if not flank.is_screw:
        held[:, -1] = True
    values = np.empty((harmonics.size, 2))
    for k, harmonic in enumerate(harmonics.tolist()):
        free, bands = body.free_stiffness_bands(harmonic, held)
        along = np.flatnonzero(free[-3 * columns :]) % 3 == 2
        S, g, work = fourier.condense_to_last_freedoms(bands, harmonic, loads[free], along.size)
        for case, moves in enumerate((~along, along)):  # symmetric, antisymmetric to mid groove
            values[k, case] = work[0, 0] + g[moves, 0] @ np.linalg.solve(S[np.ix_(moves, moves)], g[moves, 0])
    return np.asarray(values.mean(axis=1))


def forces_of_patch(flank: HalfGroove, grid: fourier.QuadrilateralGrid, width: float) -> Array:
    """Return the nodal forces ``(lines in z, lines in r, 3)`` of a unit load on the nominal contact of a flank.

    ``grid``: grid of the body; ``width``: standard deviation of the Gaussian patch [m].
    """
    force = np.zeros((*grid.shape, 3))
    force[:, flank.surface_line, ::2] = nodal_forces_along_flank_normals(flank, grid, width, flank.contact_position()[1])
    return force


def motion_unresolved_by_grid(flank: HalfGroove, coarse: fourier.QuadrilateralGrid, last: int) -> float:
    """Return the part of a narrow load patch's motion by its own unit load that a coarse grid does not resolve [m/N].

    This part is the difference of the motions on a fine and on the coarse grid, in harmonics up to ``last``, plus the
    motion in all higher harmonics on the fine grid.
    """
    fine, radius, width = flank.finite_element_grid(), flank.contact_position()[0], NARROW * flank.groove_map.ball
    low, high = np.unique([min(2, last), last // 4, last // 2, last]), sampled_harmonics(2.6 * radius / width, first=last)
    on_fine, on_coarse = (forces_of_patch(flank, grid, width) for grid in (fine, coarse))
    sampled = patch_self_motion_harmonics(flank, fine, on_fine, np.concatenate([low[:-1], high]))
    change = sampled[: low.size] - patch_self_motion_harmonics(flank, coarse, on_coarse, low)
    harmonics = np.arange(high[-1] + 1.0)
    waves = np.empty(harmonics.size)
    waves[:last] = cubic_spline(np.log1p(low), change)(np.log1p(harmonics[:last]))
    waves[0] = 0.5 * waves[1]  # a wave has half the mean square of a constant
    waves[last:] = interpolate_harmonics(high, sampled[low.size - 1 :])
    waves[last] = change[-1]
    return float(waves @ gaussian_patch_harmonic_factors(harmonics, width, radius))


@dataclass(frozen=True)
class GrooveRingCompliance:
    """Compliance of both flanks of a grooved bearing ring, in Fourier harmonics around the axis.

    A ring with its groove is a body of revolution, so that no beam, smooth body or correction is needed.
    """

    #: Compliance between the motions of left flank (r, z) and right flank (r, z) in each harmonic ``(harmonics, 4, 4)``
    #: [m/N].
    harmonics: Array
    #: Change of a contact's compliance if pressure acts along the local surface normals instead of the nominal contact
    #: normal [m/N].
    local_normal_correction: float
    #: Standard deviation of the Gaussian load patches [m].
    patch_width: float
    #: Radius at which the contacts lie, from the ring's axis [m].
    contact_radius: float


def ring_compliance(flank: HalfGroove, fixed_surface: str) -> GrooveRingCompliance:
    """Return the compliance of a grooved bearing ring between narrow load patches on its flanks.

    ``fixed_surface``: fixed surface of the ring, ``"bore"``, ``"outer"`` surface, or ``"low"``, ``"high"`` or ``"both"``
    faces.
    """
    half = flank.finite_element_grid()
    grid = fourier.QuadrilateralGrid(np.concatenate([half.r[:0:-1], half.r]), np.concatenate([-half.z[:0:-1], half.z]))
    fixed = np.zeros((*grid.shape, 3), dtype=bool)
    fixed[0 if fixed_surface == "low" else slice(0, 0)] = True
    fixed[[0, -1] if fixed_surface == "both" else -1 if fixed_surface == "high" else slice(0, 0)] = True
    fixed[:, 0 if fixed_surface == "bore" else -1 if fixed_surface == "outer" else slice(0, 0)] = True
    radius, zeta = flank.contact_position()
    line, width = flank.surface_line, NARROW * flank.groove_map.ball
    rows = np.zeros((5, *grid.shape, 3))
    if flank.groove_map.touches_at_apex:  # both flanks are the same patch
        share = gaussian_patch_weights(grid, line, 0.0, width)
        rows[0, :, line, 0] = rows[2, :, line, 0] = rows[1, :, line, 2] = rows[3, :, line, 2] = share
        rows[4, :, line, ::2] = nodal_forces_along_flank_normals(flank, grid, width, 0.0)
    else:
        share = gaussian_patch_weights(half, line, zeta, width)
        count = half.shape[0]
        rows[0, :count, line, 0] = rows[1, :count, line, 2] = share[::-1]
        rows[2, count - 1 :, line, 0] = rows[3, count - 1 :, line, 2] = share
        rows[4, count - 1 :, line, ::2] = nodal_forces_along_flank_normals(flank, half, width, zeta)
    S, correction = patch_harmonics_and_correction(
        flank, fourier.BodyOfRevolution(grid, flank.material), fixed, rows, width
    )
    return GrooveRingCompliance(S[:, :4, :4], correction, width, radius)


def patch_harmonics_and_correction(
    flank: HalfGroove, body: fourier.BodyOfRevolution, held: Mask, rows: Array, width: float
) -> tuple[Array, float]:
    """Return the motions of load patches on a ring in each harmonic, and what loads along the surface normals change.

    Parameters
    ----------
    flank
        Groove of the ring.
    body
        Finite elements of the ring.
    held
        Which degrees of freedom are fixed, of the shape of a row of ``rows``.
    rows
        Nodal forces ``(k, lines in z, lines in r, 3)`` of k unit loads. The last three act on one flank: along r, along z,
        and along the local surface normals.
    width
        Standard deviation of the Gaussian patches [m].

    Returns
    -------
    tuple[Array, float]
        Motions by the loads ``(harmonics, k, k)`` [m/N]; and the compliance of a contact by pressure along the local
        surface normals less that along the nominal normal [m/N].
    """
    radius, normal, free = flank.contact_position()[0], flank.nominal_normal, ~held.ravel()
    n = sampled_harmonics(2.6 * radius / width)
    bands, loads = body.stiffness_bands(free), rows.reshape(len(rows), -1)[:, free].T
    sampled = np.array([loads.T @ fourier.solve_harmonic_displacements(bands, harmonic, loads) for harmonic in n.tolist()])
    S = interpolate_harmonics(n, sampled)
    turned = S[:, -1, -1] - np.einsum("a,nab,b->n", normal, S[:, -3:-1, -3:-1], normal)
    factors = gaussian_patch_harmonic_factors(np.arange(n[-1] + 1.0), width, radius)
    return S, float(factors @ turned)


def gaussian_patch_harmonic_factors(harmonics: Array, width: float, radius: float) -> Array:
    """Return the factors by which a Gaussian load patch reduces the harmonics ``harmonics`` of the motion by a point load.

    ``width``: standard deviation along the circumference [m]; ``radius``: radius at which the patch lies [m]. Harmonics 0
    and 1, the rigid motions, are not reduced.
    """
    return np.where(harmonics > 1, np.exp(-((harmonics * width / radius) ** 2)), 1.0)


def compliance_between_ring_contacts(ring: GrooveRingCompliance, azimuth: Array) -> Array:
    """Return the compliance ``(4 N, 4 N)`` [m/N] between the contacts of a bearing ring with N balls.

    ``azimuth`` ``(N,)``: positions of the balls [rad]. All left contacts come first; each contact has the axes r and z.
    """
    N, n = azimuth.size, np.arange(len(ring.harmonics))
    shares = gaussian_patch_harmonic_factors(n.astype(float), ring.patch_width, ring.contact_radius)
    S = shares[:, None] * np.reshape(ring.harmonics, (n.size, 16))
    cosine, sine = np.cos(n * azimuth[:, None]), np.sin(n * azimuth[:, None])
    G = np.empty((2, N, 2, 2, N, 2))
    for place, of_harmonics in zip(np.ndindex(2, 2, 2, 2), S.T, strict=True):
        s, a, t, b = place  # side and axis of the motion, then of the load
        G[s, :, a, t, :, b] = (of_harmonics * cosine) @ cosine.T + (of_harmonics * sine) @ sine.T
    return np.asarray(G.reshape(4 * N, 4 * N))
