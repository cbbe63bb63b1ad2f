"""Compliance that grooves and end faces of screw or nut add to that of the smooth body, between neighbouring contacts.

It is computed from finite elements of half a lead and more, for contacts far from an end face and near one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rollbench.lowfi.compliance.beyond_hertz import NARROW, Flank, half_space_compliance
from rollbench.lowfi.compliance.fourier import (
    Body,
    Grid,
    Layer,
    add_mid_nodes,
    circumference_integral_factor,
    diagonal_block_of_bands,
    tube_grid,
)
from rollbench.lowfi.compliance.groove import (
    contact_motions_by_tension_and_moment,
    cubic_spline,
    flank_normals,
    gaussian_patch_harmonic_factors,
    gaussian_patch_weights,
    interpolate_harmonics,
    sampled_harmonics,
    unresolved_motion,
)
from rollbench.lowfi.compliance.tube import (
    Points,
    Tube,
    clamped_beam_compliance,
    contact_motions_by_rigid_motions,
    flank_profile_points,
    gaussian_weights_on_line,
    points_in_space,
    radial_element_ends,
)
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import UnfitKey
from rollbench.meshes.section import BeamSection

#: Range of radii [m] in which a face is fixed if it is fixed as a whole.
WHOLE = (0.0, np.inf)
#: Distance over the ball's radius within which an end face influences a contact; in the computation the body is clamped at
#: this distance on the other side of the contact.
REACH = 7.0
#: Distances of the end faces from mid groove over the ball's radius for which results are computed; the first is at the
#: groove's edge.
CUTS = (0.0, 1.2, 1.6, 2.4, 4.0, REACH)
#: Length of the longest element on a land over the ball's radius.
LAND = 0.9
#: Depth of the first element below the groove's surface, over the ball's radius.
FIRST = 0.3
#: Ratio of successive Fourier harmonics that are computed.
STEP = 1.5
#: Highest harmonic, which is estimated from a half space, times the load patch's width over the contacts' radius.
TAIL = 2.6
#: Difference of the nodal forces of two load cases, over the largest one, below which the cases count as equal.
SAME = 1e-3


class Patch(NamedTuple):
    """Size of the Gaussian load patch on a groove flank, with the fineness of mesh and harmonics that resolves it."""

    #: Standard deviation of the patch over the ball's radius.
    width: float
    #: Numbers of elements on a loaded flank (half as many on the others) and in depth.
    mesh: tuple[int, int]
    #: Highest harmonic times the ball's radius over the radius at which the contacts lie.
    highest: float


#: Load patch for contacts far from an end face, where smaller contacts differ only by the flank's curvature; and load patch
#: for distances from a face down to a contact's size, with the mean square of the contact's long axis.
FAR, BESIDE_FACE = Patch(NARROW, (4, 4), 4.0), Patch(0.07, (8, 6), 12.0)


@dataclass(frozen=True)
class NearFace:
    """Compliance that ring grooves and an end face add between contacts on the flanks of one groove.

    Arrays are for k distances of the end face, n harmonics around the axis, and f loaded flanks.
    """

    #: Distances of the end face from mid groove ``(k,)`` [m].
    distance: Array
    #: Compliance added by a face ``(2, n, 2, 2, f, 2, k)`` [m/N]. Axes: face free or fixed; harmonic around the axis; flank
    #: that moves, the one pressed towards the face or the other one; its motion along the nominal load or across it; loaded
    #: flank, of this groove (f = 2) or also of the groove behind it (f = 4); direction of the load, along the nominal
    #: load or across it; distance of the face. The compliance is zero beyond the last distance and constant below the
    #: first. The effect of a fixed face on motions across the loads, a tenth of the effect of a free face, is
    #: neglected.
    gain: Array
    #: Axial distance of the contacts from mid groove [m].
    beside: float
    #: Compliance added between contacts far from any face ``(n, 2, f)`` [m/N].
    far: Array
    #: Motion of a contact far from any face by a unit load on itself, less the motions by Hertz's law and by the smooth
    #: body, for a narrow load patch; `contact_size_correction` adds the influence of the contact's size [m/N].
    alone: float
    #: Motions of the contacts by tension and bending moment on their cross-section, as from
    #: `contact_motions_by_tension_and_moment` ``(2, 2)``; zero for a body without a beam.
    strains: Array

    @property
    def turns(self) -> int:
        """Number of neighbouring groove turns whose contacts are coupled: one or two."""
        return int(self.far.shape[2]) // 2

    def face_compliance(self, held: bool, angle: Array, distance: Array) -> Array:
        """Return the compliance ``(m, 2, 2, f, 2)`` [m/N] that an end face adds between m pairs of contacts.

        The axes after the first are flank that moves, its direction, loaded flank and direction of the load, as in the
        field ``gain``.

        Parameters
        ----------
        held
            Whether the face is fixed; otherwise it is free.
        angle
            Angles between the contacts of each pair ``(m,)`` [rad].
        distance
            Distances of the face from the groove of the contact nearer to it ``(m,)`` [m].
        """
        known = np.log(self.distance - self.beside)
        place = np.log(np.clip(distance, self.distance[0], self.distance[-1]) - self.beside)
        share = cubic_spline(known, np.eye(known.size))(place)
        return np.asarray(np.einsum("m...k,mk->m...", sum_of_harmonics(self.gain[int(held)], angle), share))

    def compliance_between(self, angle: Array) -> Array:
        """Return the compliance ``(m, 2, f)`` [m/N] between contacts far from any face, less that of the smooth body.

        ``angle`` ``(m,)``: angles around the axis between the contacts of m pairs [rad]. The last two axes are for the
        flank that moves and the loaded flank.
        """
        return sum_of_harmonics(self.far, angle)


def sum_of_harmonics(waves: Array, angle: Array) -> Array:
    """Return the values ``(m, ...)`` of a Fourier cosine series at m angles.

    ``waves`` ``(n, ...)``: coefficients of the harmonics; ``angle`` ``(m,)``: angles [rad].
    """
    step = np.pi / (4 * len(waves))
    sums = np.fft.hfft(0.5 * np.concatenate([2.0 * waves[:1], waves[1:]]), 8 * len(waves), axis=0)
    turned = np.abs((angle + np.pi) % (2.0 * np.pi) - np.pi)
    known = step * np.arange(-2, 4 * len(waves) + 3)
    return np.asarray(cubic_spline(known, sums[np.arange(-2, 4 * len(waves) + 3)])(turned))


def near_face_compliance(
    flank: Flank, smooth: Tube, section: BeamSection, held_radii: tuple[float, float], *, near: bool = True
) -> NearFace:
    """Return the compliance that grooves and an end face add to the smooth body that represents screw or nut.

    Parameters
    ----------
    flank
        Groove of the body.
    smooth
        Smooth body of revolution.
    section
        Section of the body's beam, whose motions are computed elsewhere and therefore subtracted.
    held_radii
        Range of radii in which an end face is fixed, if it is fixed [m].
    near
        Whether an end face lies within `REACH` ball radii of a contact, so that its effect is computed.

    Raises
    ------
    ValueError
        ``near`` is True, and the groove ends at the land before it reaches the nominal contact.
    """
    if near:
        _check_land(flank)
    a_beam = smooth.held not in ("bore", "outer") and flank.map.rg != 0.0
    strains = contact_motions_by_tension_and_moment(flank, smooth) if a_beam else np.zeros((2, 2))

    def gains(finer: Patch, last: slice, kinds: int, radii: tuple[float, float]) -> tuple[Array, Grid, Array]:
        """Return the compliance that grooves and end faces add, the grid of the grooved body, and the faces' distances [m].

        ``finer``: load patch and mesh; ``last``: selection of the end faces at the distances `CUTS`; ``kinds``: 1 for
        motions along the loads, 2 also across them; ``radii``: range of radii in which a face is fixed [m].
        """
        grid, cuts = grooved_grid(flank, finer.mesh)
        cuts, z = cuts[last], grid.z[:, 0]
        gain = motions_beyond_smooth_body(flank, smooth, grid, cuts, radii, finer, kinds)
        if smooth.held not in ("bore", "outer"):
            beams = [
                motions_beyond_smooth_beam(flank, smooth, section, strains, (float(z[0]), float(z[cut]))) for cut in cuts
            ]
            gain[1, :2, :, 0, :, 0] -= np.stack(beams, axis=-1)
        return gain, grid, z[cuts]

    gain, grid, distance = gains(FAR, slice(-1, None), 1, WHOLE)
    far = average_mirror_images(gain[1, :, :, 0, :, 0, -1])
    alone = float(far[:, 0, 0].sum()) + unresolved_motion(flank, half_lead_grid(flank, grid), len(far) - 1)
    alone -= half_space_compliance(NARROW * flank.map.ball, flank.material)
    if near:
        gain, _, distance = gains(BESIDE_FACE, slice(None), 2, held_radii)
        gain[1, :, :, 1], gain[1, ..., 1, :] = 0.0, 0.0
    return NearFace(distance, gain - gain[..., -1:], flank.contact()[1], append_high_harmonics(flank, far), alone, strains)


def _check_land(flank: Flank) -> None:
    """Raise UnfitKey if the groove ends at the land before it reaches the nominal contact."""
    edge = flank_profile_points(flank.map, flank.land, flank.screw, 2)[1][-1]
    if flank.contact()[1] < edge:
        return
    body, key = ("screw", "screw.outer_diameter") if flank.screw else ("nut", "solid.nut_inner_diameter")
    angle, verb = np.degrees(flank.map.beta), "raise" if flank.screw else "lower"
    raise UnfitKey(
        key, f"the {body}'s groove ends at the land before the contact at {angle:.4g} deg, near an end face: {verb} {key}"
    )


def average_mirror_images(waves: Array) -> Array:
    """Average the motions of groove flanks far from any end face with those of the mirror image of the body.

    ``waves`` ``(n, 2, f)``: motions of 2 flanks by loads on f flanks in n harmonics [m/N]. By symmetry, flank a moves by a
    load on flank b of the groove behind as the flank opposite to b does by a load on the flank opposite to a. The computed
    body does not have this symmetry, as its ends are equally far from the loaded groove and not from the land between both
    grooves.
    """
    pairs = waves.reshape(len(waves), 2, -1, 2)
    return np.asarray(0.5 * (pairs + pairs[:, ::-1, :, ::-1].swapaxes(1, 3))).reshape(waves.shape)


def append_high_harmonics(flank: Flank, waves: Array) -> Array:
    """Append higher Fourier harmonics, estimated from a half space, to the computed motions of narrow load patches.

    ``waves`` ``(n, ...)``: motions of the flanks of the groove ``flank`` in n harmonics [m/N]. On a half space the mutual
    compliance of two Gaussian patches of standard deviation s in a wave of wavenumber k is proportional to exp(x) K_0(x)
    exp(-2 x) with x = (k s)^2/2.
    """
    from scipy.special import k0e

    radius, width, last = flank.contact()[0], NARROW * flank.map.ball, len(waves) - 1
    n = np.arange(float(last), int(TAIL * radius / width))
    plane = k0e(0.5 * (n * width / radius) ** 2) * gaussian_patch_harmonic_factors(n, width, radius)
    return np.concatenate([waves[:-1], waves[-1] * (plane / plane[0]).reshape(-1, *[1] * (waves.ndim - 1))])


def contact_motions_by_own_section_wrench(points: Points, side: Array, strains: Array) -> Array:
    """Return the local motions ``(k c, 6)`` of c contacts, k axes each, by a unit wrench on each one's own cross-section.

    The wrench consists of three forces and three moments; only tension and bending moments have an effect. ``points``: the
    contacts; ``side`` ``(c,)``: -1 for a flank at negative z of its groove, 1 at positive z; ``strains``: see
    `contact_motions_by_tension_and_moment`.
    """
    along_r, along_z = points.axes[..., 0], points.axes[..., 2] * side[:, None]
    stretch, bend = (along_r * x + along_z * y for x, y in strains)
    c, s = np.cos(points.azimuth)[:, None], np.sin(points.azimuth)[:, None]
    none = np.zeros_like(stretch)
    return np.stack([none, none, stretch, s * bend, -c * bend, none], axis=-1).reshape(-1, 6)


def motions_beyond_smooth_beam(
    flank: Flank, smooth: Tube, section: BeamSection, strains: Array, ends: tuple[float, float]
) -> Array:
    """Return the motions ``(2, 2, f)`` [m/N] of both flanks by the grooved body's beam, less those by the smooth beam.

    The first axis is for harmonics 0 and 1 around the axis, the second for the flank that moves, the third for the loaded
    flank. ``flank``: groove of the body; ``smooth``: smooth body of revolution; ``section``: section of the grooved beam;
    ``ends``: axial positions at which it is clamped [m]; ``strains``: see `contact_motions_by_tension_and_moment`.
    """
    plain = smooth.section
    places, along = (np.concatenate([x, x]) for x in contact_positions_and_directions(flank, ends[0]))
    half = len(places) // 2
    out = np.zeros((2 * half, 2 * half))
    side = np.tile([1.0, -1.0], half)
    for sign, beam in ((1.0, section), (-1.0, plain)):
        radius = smooth.radius if sign > 0.0 else float(np.clip(smooth.radius, smooth.bore, smooth.outer))
        turned = radius * np.repeat([1.0, -1.0], half)  # here, and on the other side of the axis
        x = np.stack([turned, np.zeros(2 * half), places], axis=1)
        axes = np.stack([along[:, 0] * np.sign(turned), np.zeros(2 * half), along[:, 1]], axis=1)[:, None]
        feel = contact_motions_by_own_section_wrench(points_in_space(x, axes), side, strains) if sign > 0.0 else None
        out += sign * clamped_beam_compliance(contact_motions_by_rigid_motions(x, axes), places, ends, "both", beam, feel)
    return np.stack([out[:2, :half] + out[:2, half:], out[:2, :half] - out[:2, half:]]) / 2.0


def motions_beyond_smooth_body(
    flank: Flank, smooth: Tube, grid: Grid, cuts: Sequence[int], held_radii: tuple[float, float], finer: Patch, kinds: int
) -> Array:
    """Return the motions of load patches on the flanks of the grooved body, less those on the smooth body [m/N].

    The load patches of the two bodies differ in width. ``smooth``: smooth body of revolution, with the width of its
    patches; ``grid``: grid of the grooved body; ``finer``: size of the load patch and fineness of mesh and harmonics for
    the true flanks; the other arguments and the axes of the result are those of `patch_motions_for_end_faces`.
    """
    width = finer.width * flank.map.ball
    true = flank_patch_loads(flank, grid, cuts, width, kinds)
    r_ends, line = radial_element_ends(smooth)
    plain = tube_grid(r_ends, grid.z[::2, 0])
    loads = smooth_patch_loads(flank, plain, line, cuts, smooth.width, kinds)
    n = sampled_harmonics(finer.highest * flank.contact()[0] / flank.map.ball, STEP)
    return patch_motions_for_end_faces(
        flank, grid, cuts, n, held_radii, smooth.held, true, width
    ) - patch_motions_for_end_faces(flank, plain, cuts, n, WHOLE, smooth.held, loads, smooth.width, smooth.layer)


def half_lead_grid(flank: Flank, grid: Grid) -> Grid:
    """Return the part of a grooved body's grid between the middle of the loaded groove and the middle of the land."""
    z = grid.z[:, 0]
    half = slice(int(np.abs(z).argmin()), int(np.abs(z - flank.half).argmin()) + 1)
    return Grid(grid.r[half], grid.z[half])


def grooved_grid(flank: Flank, mesh: tuple[int, int]) -> tuple[Grid, list[int]]:
    """Return the finite-element grid of a grooved body, then the numbers of its lines in z at which an end face may lie.

    The grid reaches from the clamped end to the end face that is furthest from the loaded groove, whose middle is at z = 0.
    ``mesh``: numbers of elements on the loaded flank and in depth.
    """
    ball, reach = flank.map.ball, REACH * flank.map.ball
    r, z = groove_surface_nodes(
        flank, mesh[0], LAND * ball * np.array([0.25, 0.6, *np.arange(1.2, flank.half / (LAND * ball))])
    )
    edge = float(z[z.size // 2 + 2 * mesh[0]])
    beyond = max(0, int(np.ceil((reach / flank.half - 1.0) / 2.0)))
    next_r, next_z = groove_surface_nodes(flank, mesh[0] // 2, LAND * ball * np.arange(1.0, flank.half / (LAND * ball)))
    shift = 2.0 * flank.half * np.arange(1.0, beyond + 1.0)[:, None]
    r = np.concatenate([np.tile(next_r[:-1], beyond), r, np.tile(next_r[1:], beyond)])
    z = np.concatenate([(next_z[:-1] - shift[::-1]).ravel(), z, (next_z[1:] + shift).ravel()])
    last = 2 * int(np.abs(z[::2] - reach).argmin())  # both ends as far: the body must be its own mirror image
    r, z = r[z.size - 1 - last : last + 1], z[z.size - 1 - last : last + 1]
    faces = np.arange(0, z.size, 2)[z[::2] > edge - 0.01 * ball]
    cuts = sorted({int(faces[np.abs(z[faces] - x * ball).argmin()]) for x in CUTS})
    power = np.log(abs(flank.land - flank.far) / (FIRST * ball)) / np.log(mesh[1])
    share = add_mid_nodes(1.0 - np.linspace(1.0, 0.0, mesh[1] + 1) ** max(power, 1.0))
    inner, outer = (np.full_like(r, flank.far), r) if flank.screw else (r, np.full_like(r, flank.far))
    depth = share if flank.screw else (1.0 - share)[::-1]
    radii = inner[:, None] + depth * (outer - inner)[:, None]
    return Grid(radii, np.broadcast_to(z[:, None], radii.shape).copy()), cuts


def groove_surface_nodes(flank: Flank, count: int, ends: Array) -> tuple[Array, Array]:
    """Return the radii r and axial positions z [m] of the nodes on a groove's surface, from mid land to mid land.

    Parameters
    ----------
    flank
        The groove.
    count
        Number of elements on a flank.
    ends
        Distances of the land's element ends from the edge of the groove [m].
    """
    r, z = flank_profile_points(flank.map, flank.land, flank.screw, 2 * count + 1)
    land = flank.half - float(z[-1])
    along = add_mid_nodes(np.concatenate([[0.0], ends[ends < land - 0.15 * flank.map.ball], [land]]))[1:]
    r, z = np.append(r, np.full(along.size, flank.land)), np.append(z, z[-1] + along)
    return np.append(r[:0:-1], r), np.append(-z[:0:-1], z)


def perpendicular_directions(along: Array) -> Array:
    """Return directions ``(..., 2)`` in the plane (r, z), turned by 90 deg from r towards z.

    ``along`` ``(..., 2)``: the directions (r, z) before turning.
    """
    return np.stack([-along[..., 1], along[..., 0]], axis=-1)


def flank_patch_loads(flank: Flank, grid: Grid, cuts: Sequence[int], width: float, kinds: int = 1) -> Array:
    """Return the nodal forces of unit loads on the flanks of the grooved body, each a Gaussian patch about one contact.

    Loads act along the nominal load and, if ``kinds`` is 2, also across it; the latter is the difference of two slightly
    shifted patches. Patches end at the end face. ``cuts``: numbers of the grid lines in z at which the end face may be;
    ``width``: standard deviation of the patches [m].

    Returns
    -------
    Array
        Forces ``(f, kinds, cuts, nodes of the grid, 3)``.
    """
    line = grid.shape[1] - 1 if flank.screw else 0
    normals = flank_normals(grid, line)
    places, directions = contact_positions_and_directions(flank, grid.z[0, 0])
    out = np.zeros((len(places), kinds, len(cuts), *grid.shape, 3))
    for away, (place, along) in enumerate(zip(places, directions, strict=True)):
        pressing = normals * np.sign(normals @ along)[:, None]
        for kind, direction in enumerate((along, perpendicular_directions(along))[:kinds]):
            share = gaussian_patch_weights(grid, line, place, width, moment=kind)[0]
            for k, cut in enumerate(cuts):
                force = share[: cut + 1, None] * pressing[: cut + 1]
                total = share[: cut + 1].sum() if kind == 0 else (force @ direction).sum()
                out[away, kind, k, : cut + 1, line, ::2] = force / total
    return out


def smooth_patch_loads(flank: Flank, grid: Grid, line: int, cuts: Sequence[int], width: float, kinds: int = 1) -> Array:
    """Return nodal forces of unit loads on one axial grid line of the smooth body, shaped as those of `flank_patch_loads`.

    ``line``: number of the grid line in r; ``cuts``: numbers of the lines in z at which the end face may be; ``width``:
    standard deviation of the patches [m]; ``kinds``: 1 for loads along the nominal load, 2 also across it.
    """
    places, directions = contact_positions_and_directions(flank, grid.z[0, 0])
    out = np.zeros((len(places), kinds, len(cuts), *grid.shape, 3))
    for away, (place, along) in enumerate(zip(places, directions, strict=True)):
        for k, cut in enumerate(cuts):
            share = gaussian_weights_on_line(grid.z[: cut + 1, 0], np.array([place]), width)[0]
            for kind, direction in enumerate((along, perpendicular_directions(along))[:kinds]):
                out[away, kind, k, : cut + 1, line, ::2] = share[:, None] * direction
    return out


def contact_positions_and_directions(flank: Flank, low: float) -> tuple[Array, Array]:
    """Return axial positions ``(f,)`` [m] and nominal load directions (r, z) ``(f, 2)`` of the contacts on f flanks.

    The flank pressed towards high z comes first, then the other one. Both flanks of the
    groove behind follow if the body, which begins at z = ``low`` [m], contains it.
    """
    m = flank.map
    place, along = flank.contact()[1], m.signs[flank.side] * np.array([np.cos(m.beta), np.sin(m.beta)])
    places, turns = np.array([place, -place]), 2 if low < -2.0 * flank.half - m.ball else 1
    return (
        np.concatenate([places - 2.0 * flank.half * turn for turn in range(turns)]),
        np.concatenate([[along, along * np.array([1.0, -1.0])]] * turns),
    )


def patch_motions_for_end_faces(
    flank: Flank,
    grid: Grid,
    cuts: Sequence[int],
    n: Array,
    held_radii: tuple[float, float],
    fixing: str,
    loads: Array,
    width: float,
    layer: Layer | None = None,
) -> Array:
    """Return the motions of load patches in every harmonic, for a body with its end face at each of several grid lines.

    Parameters
    ----------
    flank, grid
        Groove of the body, and its grid.
    cuts
        Numbers of the grid lines in z at which the end face may be.
    n
        Harmonics that are computed; the others are interpolated.
    held_radii
        Range of radii in which the end face is fixed [m].
    fixing
        Fixed surface, see `Tube.held`; ``"bore"`` and ``"outer"`` surfaces are fixed in addition to the clamped end.
    loads
        Nodal forces, see `flank_patch_loads`.
    width
        Standard deviation of the patches [m].
    layer
        Anisotropic layer that represents grooves.

    Returns
    -------
    Array
        Motions ``(2, n, 2, kinds, f, kinds, cuts)`` [m/N]: face free or fixed, harmonic, flank that moves, its direction,
        loaded flank, direction of the load, end face.
    """
    from scipy.linalg import cholesky_banded
    from scipy.linalg.lapack import dtbtrs

    columns = grid.shape[1]
    body = Body(grid, flank.material.youngs_modulus, flank.material.poissons_ratio, layer)
    held = np.zeros((*grid.shape, 3), dtype=bool)
    held[0] = True
    held[:, 0 if fixing == "bore" else -1 if fixing == "outer" else slice(0, 0)] = True
    beyond = body.stiffness_of_rows()[:, :, 0, :, 0]
    patches, kinds = loads.shape[:2]
    watched = 2 * kinds
    sampled = np.empty((n.size, 2, watched, patches * kinds, len(cuts)))
    distinct, of = merge_equal_loads(loads.reshape(-1, *loads.shape[2:]), cuts)
    kept: dict[bytes, Array] = {}
    for values, harmonic in zip(sampled, n.tolist(), strict=True):
        free = ~held.ravel() & body.freedoms_regular_on_axis(harmonic)
        if free.tobytes() not in kept:
            kept[free.tobytes()] = body.bands(free)
        powers = circumference_integral_factor(harmonic) * np.array([1.0, harmonic, harmonic * harmonic])
        L = cholesky_banded(
            np.tensordot(powers, kept[free.tobytes()], 1), overwrite_ab=True, lower=True, check_finite=False
        )
        Y = dtbtrs(L, distinct[:, free].T, uplo="L")[0]
        for k, cut in enumerate(cuts):
            solution = Y[:, of[k]]
            line = np.flatnonzero(free[3 * cut * columns : 3 * (cut + 1) * columns])
            first = int(np.count_nonzero(free[: 3 * cut * columns]))
            corner = diagonal_block_of_bands(L, first, line.size)
            S, g = corner @ corner.T, corner @ solution[first : first + line.size]
            if cut < grid.shape[0] - 1:  # L holds what follows the cut, too
                S -= np.tensordot(powers, beyond[:, cut // 2][:, line[:, None], line], 1)
            r = grid.r[cut, line // 3]
            work = solution[:first, :watched].T @ solution[:first]
            for face, moves in enumerate((np.full(line.size, True), (r < held_radii[0]) | (r > held_radii[1]))):
                values[face, ..., k] = work + g[moves, :watched].T @ np.linalg.solve(S[np.ix_(moves, moves)], g[moves])
    motions = interpolate_harmonics(n, sampled)
    shares = gaussian_patch_harmonic_factors(np.arange(float(len(motions))), width, flank.contact()[0])
    motions *= shares[:, None, None, None, None]
    return np.moveaxis(motions, 1, 0).reshape(2, len(motions), 2, kinds, patches, kinds, len(cuts))


def merge_equal_loads(loads: Array, cuts: Sequence[int]) -> tuple[Array, list[list[int]]]:
    """Return the distinct load cases among those for several positions of the end face, so that each is solved only once.

    ``loads`` ``(f, cuts, nodes of the grid, 3)``: nodal forces of f load patches for each end face; ``cuts``: numbers of
    the grid lines in z at which the end face may be. A patch that lies entirely below an end face has the same load as for
    the end face furthest from the loaded groove.

    Returns
    -------
    tuple[Array, list[list[int]]]
        The different load cases, one in each row ``(cases, 3 nodes)``; and for each end face the numbers of the rows that
        hold the loads of the f patches.
    """
    rows, of = [x.ravel() for x in loads[:, -1]], [[0] * len(loads) for _ in cuts]
    for k, cut in enumerate(cuts):
        for f, load in enumerate(loads):
            alike = np.abs(load[k, : cut + 1] - load[-1, : cut + 1]).max() < SAME * np.abs(load[-1]).max()
            of[k][f] = f if alike else len(rows)
            rows += [] if alike else [load[k].ravel()]
    return np.stack(rows), of
