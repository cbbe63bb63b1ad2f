"""Compliance that grooves and end faces of screw or nut add to that of the smooth body, between neighbouring contacts.

It is computed from finite elements of half a lead and more, for contacts far from an end face and near one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rollbench.lowfi.compliance import fourier, groove, tube
from rollbench.lowfi.compliance.beyond_hertz import NARROW, half_space_compliance
from rollbench.lowfi.compliance.tube import HalfGroove
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


class PatchResolution(NamedTuple):
    """Size of the Gaussian load patch on a groove flank, with the mesh and the highest harmonic that resolve it."""

    #: Standard deviation of the load patch, divided by the ball's radius.
    width: float
    #: Numbers of elements on a loaded flank (half as many on the other flanks) and in depth.
    mesh: tuple[int, int]
    #: Number of the highest Fourier harmonic around the body's axis, multiplied by the ball's radius and divided by the
    #: distance of the contacts from this axis.
    highest: float


#: Load patch for contacts far from an end face, where smaller contacts differ only by the flank's curvature; and load patch
#: for distances from a face down to a contact's size, with the mean square of the contact's long axis.
FAR, BESIDE_FACE = PatchResolution(NARROW, (4, 4), 4.0), PatchResolution(0.07, (8, 6), 12.0)


@dataclass(frozen=True)
class GrooveAndFaceCompliance:
    """Compliance between contacts on the flanks of one groove that grooves and an end face add to the smooth screw or nut.

    Arrays are for k distances of the end face from the middle of the groove, n harmonics around the axis, and f loaded
    flanks.
    """

    #: Distances of the end face from the middle of the groove, for which ``face_gain`` was computed ``(k,)`` [m].
    face_distances: Array
    #: Compliance added by an end face ``(2, n, 2, 2, f, 2, k)`` [m/N]. Axes of the array: face free or fixed; Fourier
    #: harmonic around the body's axis, n in all; flank that moves, the one pressed towards the face or the other one; its
    #: motion along the nominal load or across it; loaded flank, of this groove (f = 2) or also of the groove behind it (f =
    #: 4); direction of the load, along the nominal load or across it; distance of the face. The compliance is zero beyond
    #: the last distance and constant below the first. The effect of a fixed face on motions across the loads, a tenth of
    #: the effect of a free face, is neglected.
    face_gain: Array
    #: Axial distance of the contacts from the middle of the groove [m].
    contact_to_mid_groove: float
    #: Compliance that grooves add between contacts far from any end face ``(n, 2, f)`` [m/N]: Fourier harmonic around the
    #: axis, flank that moves, loaded flank.
    far_gain: Array
    #: Motion of a contact far from any face by a unit load on itself, less the motions by Hertz's law and by the smooth
    #: body, for a narrow load patch; `contact_size_correction` adds the influence of the contact's size [m/N].
    self_compliance: float
    #: Local motions of a contact along r and z (columns) by a unit tension [m/N], then by a unit bending moment [1/N], on
    #: its cross-section (rows) ``(2, 2)``, see `contact_motions_by_tension_and_moment`; zero for a body without a beam.
    section_strain_motions: Array

    @property
    def coupled_turns(self) -> int:
        """Number of groove turns whose contacts are coupled: 1 (the same turn only) or 2 (also the neighbouring turn).

        Each of the two arrays knows the turns that its own grid contains, and the lengths of the grids differ a little.
        """
        return int(min(self.far_gain.shape[2], self.face_gain.shape[4])) // 2

    def compliance_by_face(self, held: bool, angle: Array, distance: Array) -> Array:
        """Return the compliance ``(m, 2, 2, f, 2)`` [m/N] that an end face adds between m pairs of contacts.

        The axes after the first are flank that moves, its direction, loaded flank and direction of the load, as in the
        field ``face_gain``.

        Parameters
        ----------
        held
            Whether the face is fixed; otherwise it is free.
        angle
            Angles between the contacts of each pair ``(m,)`` [rad].
        distance
            Distances of the face from the groove of the contact nearer to it ``(m,)`` [m].
        """
        known = np.log(self.face_distances - self.contact_to_mid_groove)
        place = np.log(np.clip(distance, self.face_distances[0], self.face_distances[-1]) - self.contact_to_mid_groove)
        share = groove.cubic_spline(known, np.eye(known.size))(place)
        return np.asarray(np.einsum("m...k,mk->m...", cosine_series_values(self.face_gain[int(held)], angle), share))

    def compliance_far_from_faces(self, angle: Array) -> Array:
        """Return the compliance ``(m, 2, f)`` [m/N] between contacts far from any end face, less that of the smooth body.

        ``angle`` ``(m,)``: angles around the axis between the contacts of m pairs [rad]. The last two axes are for the
        flank that moves and the loaded flank.
        """
        return cosine_series_values(self.far_gain, angle)


def cosine_series_values(waves: Array, angle: Array) -> Array:
    """Return the values ``(m, ...)`` of a Fourier cosine series at m angles.

    ``waves`` ``(n, ...)``: coefficients of the harmonics; ``angle`` ``(m,)``: angles [rad].
    """
    step = np.pi / (4 * len(waves))
    sums = np.fft.hfft(0.5 * np.concatenate([2.0 * waves[:1], waves[1:]]), 8 * len(waves), axis=0)
    turned = np.abs((angle + np.pi) % (2.0 * np.pi) - np.pi)
    known = step * np.arange(-2, 4 * len(waves) + 3)
    return np.asarray(groove.cubic_spline(known, sums[np.arange(-2, 4 * len(waves) + 3)])(turned))


def compute_groove_and_face_compliance(
    flank: HalfGroove,
    smooth: tube.SmoothBody,
    section: BeamSection,
    held_radii: tuple[float, float],
    *,
    has_near_face: bool = True,
) -> GrooveAndFaceCompliance:
    """Return the compliance that grooves and an end face add to the ungrooved smooth body that represents screw or nut.

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
    has_near_face
        Whether an end face lies within `REACH` ball radii of a contact, so that its effect is computed.

    Raises
    ------
    ValueError
        ``has_near_face`` is True, and the groove ends at the land before it reaches the nominal contact.
    """
    if has_near_face:
        _check_groove_reaches_contact(flank)
    a_beam = smooth.held not in ("bore", "outer") and flank.groove_map.rg != 0.0
    strains = groove.contact_motions_by_tension_and_moment(flank, smooth) if a_beam else np.zeros((2, 2))

    def added_compliances(
        finer: PatchResolution, last: slice, kinds: int, radii: tuple[float, float]
    ) -> tuple[Array, fourier.QuadrilateralGrid, Array]:
        """Return the compliance added by grooves and end faces, the grid, and distances of the faces from mid groove [m].

        ``finer``: load patch and mesh; ``last``: which end faces are computed, as an index range of `CUTS`, their distances
        from mid groove divided by the ball's radius; ``kinds``: 1 for motions along the loads, 2 also across them;
        ``radii``: range of radii in which a face is fixed [m].
        """
        grid, cuts = grooved_body_grid(flank, finer.mesh)
        cuts, z = cuts[last], grid.z[:, 0]
        gain = motions_beyond_smooth_body(flank, smooth, grid, cuts, radii, finer, kinds)
        if smooth.held not in ("bore", "outer"):
            ends = [(float(z[0]), float(z[cut])) for cut in cuts]
            beams = [motions_beyond_smooth_beam(flank, smooth, section, strains, between) for between in ends]
            gain[1, :2, :, 0, :, 0] -= np.stack(beams, axis=-1)
        return gain, grid, z[cuts]

    gain, grid, distance = added_compliances(FAR, slice(-1, None), 1, WHOLE)
    far = average_with_mirror_image(gain[1, :, :, 0, :, 0, -1])
    alone = float(far[:, 0, 0].sum())
    alone += groove.motion_unresolved_by_grid(flank, half_lead_part_of_grid(flank, grid), len(far) - 1)
    alone -= half_space_compliance(NARROW * flank.groove_map.ball, flank.material)
    if has_near_face:
        gain, _, distance = added_compliances(BESIDE_FACE, slice(None), 2, held_radii)
        gain[1, :, :, 1], gain[1, ..., 1, :] = 0.0, 0.0
    return GrooveAndFaceCompliance(
        distance, gain - gain[..., -1:], flank.contact_position()[1], append_high_harmonics(flank, far), alone, strains
    )


def _check_groove_reaches_contact(flank: HalfGroove) -> None:
    """Raise UnfitKey if the groove ends at the land before it reaches the nominal contact."""
    edge = flank.profile_points(2)[1][-1]
    if flank.contact_position()[1] < edge:
        return
    body, key = ("screw", "screw.outer_diameter") if flank.is_screw else ("nut", "solid.nut_inner_diameter")
    angle, verb = np.degrees(flank.groove_map.beta), "raise" if flank.is_screw else "lower"
    raise UnfitKey(
        key, f"the flank of the {body}'s groove meets the land before the contact angle of {angle:.4g} deg: {verb} {key}"
    )


def average_with_mirror_image(waves: Array) -> Array:
    """Average the motions of groove flanks far from end faces with those in the mirror image of the body.

    ``waves`` ``(n, 2, f)``: motions of 2 flanks by loads on f flanks in n harmonics [m/N]. By symmetry, the motion of flank
    a by a load on flank b of the next groove turn at lower z equals the motion of the flank opposite to b by a load on the
    flank opposite to a. In the finite-element body the two motions differ, because its ends are equally far from the loaded
    groove instead of from the land between both turns.
    """
    pairs = waves.reshape(len(waves), 2, -1, 2)
    return np.asarray(0.5 * (pairs + pairs[:, ::-1, :, ::-1].swapaxes(1, 3))).reshape(waves.shape)


def append_high_harmonics(flank: HalfGroove, waves: Array) -> Array:
    """Append higher Fourier harmonics, estimated from a half space, to the computed motions of narrow load patches.

    ``waves`` ``(n, ...)``: motions of the flanks of the groove ``flank`` in n harmonics [m/N]. On a half space the mutual
    compliance of two Gaussian patches of standard deviation s in a wave of wavenumber k is proportional to exp(x) K_0(x)
    exp(-2 x) with x = (k s)^2/2 and the modified Bessel function K_0.
    """
    from scipy.special import k0e

    radius, width, last = flank.contact_position()[0], NARROW * flank.groove_map.ball, len(waves) - 1
    n = np.arange(float(last), int(TAIL * radius / width))
    plane = k0e(0.5 * (n * width / radius) ** 2) * groove.gaussian_patch_harmonic_factors(n, width, radius)
    return np.concatenate([waves[:-1], waves[-1] * (plane / plane[0]).reshape(-1, *[1] * (waves.ndim - 1))])


def contact_motions_by_own_section_wrench(points: tube.ContactPoints, flank_signs: Array, strains: Array) -> Array:
    """Return the local motions ``(k c, 6)`` of c contacts, along k axes each, by six unit loads on the contact's section.

    The loads are three forces and three moments; only tension and bending moments have an effect. ``points``: the contacts;
    ``flank_signs`` ``(c,)``: -1 for a flank at negative z of its groove, 1 at positive z; ``strains``: see
    `contact_motions_by_tension_and_moment`.
    """
    along_r, along_z = points.axes[..., 0], points.axes[..., 2] * flank_signs[:, None]
    stretch, bend = (along_r * x + along_z * y for x, y in strains)
    c, s = np.cos(points.azimuth)[:, None], np.sin(points.azimuth)[:, None]
    none = np.zeros_like(stretch)
    return np.stack([none, none, stretch, s * bend, -c * bend, none], axis=-1).reshape(-1, 6)


def motions_beyond_smooth_beam(
    flank: HalfGroove, smooth: tube.SmoothBody, section: BeamSection, strains: Array, ends: tuple[float, float]
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
        radius = smooth.contact_radius
        if sign < 0.0:
            radius = float(np.clip(radius, smooth.bore_radius, smooth.outer_radius))
        turned = radius * np.repeat([1.0, -1.0], half)  # here, and on the other side of the axis
        x = np.stack([turned, np.zeros(2 * half), places], axis=1)
        axes = np.stack([along[:, 0] * np.sign(turned), np.zeros(2 * half), along[:, 1]], axis=1)[:, None]
        local = None
        if sign > 0.0:
            local = contact_motions_by_own_section_wrench(tube.convert_contacts_to_cylindrical(x, axes), side, strains)
        rows = tube.contact_motions_by_rigid_motions(x, axes)
        out += sign * tube.clamped_beam_compliance(rows, places, ends, "both", beam, local)
    return np.stack([out[:2, :half] + out[:2, half:], out[:2, :half] - out[:2, half:]]) / 2.0


def motions_beyond_smooth_body(
    flank: HalfGroove,
    smooth: tube.SmoothBody,
    grid: fourier.QuadrilateralGrid,
    face_lines: Sequence[int],
    held_radii: tuple[float, float],
    patch: PatchResolution,
    direction_count: int,
) -> Array:
    """Return the motions of load patches by unit loads on the grooved flanks, less those on the smooth body [m/N].

    The load patches of the two bodies differ in width. ``smooth``: smooth body of revolution, with the width of its
    patches; ``grid``: grid of the grooved body; ``patch``: size of the load patch and fineness of mesh and harmonics for
    the true flanks; the other arguments and the axes of the result are those of `patch_motions_for_end_faces`.
    """
    width = patch.width * flank.groove_map.ball
    true = flank_patch_loads(flank, grid, face_lines, width, direction_count)
    r_ends, line = tube.radial_element_ends(smooth)
    plain = fourier.tube_grid(r_ends, grid.z[::2, 0])
    loads = smooth_patch_loads(flank, plain, line, face_lines, smooth.patch_width, direction_count)
    n = groove.sampled_harmonics(patch.highest * flank.contact_position()[0] / flank.groove_map.ball, STEP)
    held = smooth.held
    grooved = patch_motions_for_end_faces(flank, grid, face_lines, n, held_radii, held, true, width)
    return grooved - patch_motions_for_end_faces(
        flank, plain, face_lines, n, WHOLE, held, loads, smooth.patch_width, smooth.groove_layer
    )


def half_lead_part_of_grid(flank: HalfGroove, grid: fourier.QuadrilateralGrid) -> fourier.QuadrilateralGrid:
    """Return the part of a grooved body's grid between the middle of the loaded groove and the middle of the land."""
    z = grid.z[:, 0]
    half = slice(int(np.abs(z).argmin()), int(np.abs(z - flank.half_length).argmin()) + 1)
    return fourier.QuadrilateralGrid(grid.r[half], grid.z[half])


def grooved_body_grid(flank: HalfGroove, mesh: tuple[int, int]) -> tuple[fourier.QuadrilateralGrid, list[int]]:
    """Return the finite-element grid of a grooved body, then the numbers of its lines in z at which an end face may lie.

    The grid reaches from the clamped end to the end face that is furthest from the loaded groove, whose middle is at z = 0.
    ``mesh``: numbers of elements on the loaded flank and in depth.
    """
    ball, reach = flank.groove_map.ball, REACH * flank.groove_map.ball
    longest = LAND * ball
    ends = longest * np.array([0.25, 0.6, *np.arange(1.2, flank.half_length / longest)])
    r, z = groove_surface_nodes(flank, mesh[0], ends)
    edge = float(z[z.size // 2 + 2 * mesh[0]])
    beyond = max(0, int(np.ceil((reach / flank.half_length - 1.0) / 2.0)))
    next_r, next_z = groove_surface_nodes(flank, mesh[0] // 2, longest * np.arange(1.0, flank.half_length / longest))
    shift = 2.0 * flank.half_length * np.arange(1.0, beyond + 1.0)[:, None]
    r = np.concatenate([np.tile(next_r[:-1], beyond), r, np.tile(next_r[1:], beyond)])
    z = np.concatenate([(next_z[:-1] - shift[::-1]).ravel(), z, (next_z[1:] + shift).ravel()])
    last = 2 * int(np.abs(z[::2] - reach).argmin())  # both ends as far: the body must be its own mirror image
    r, z = r[z.size - 1 - last : last + 1], z[z.size - 1 - last : last + 1]
    faces = np.arange(0, z.size, 2)[z[::2] > edge - 0.01 * ball]
    cuts = sorted({int(faces[np.abs(z[faces] - x * ball).argmin()]) for x in CUTS})
    power = np.log(abs(flank.land_radius - flank.plain_radius) / (FIRST * ball)) / np.log(mesh[1])
    return flank.grid_below_surface(r, z, 1.0 - np.linspace(1.0, 0.0, mesh[1] + 1) ** max(power, 1.0)), cuts


def groove_surface_nodes(flank: HalfGroove, count: int, ends: Array) -> tuple[Array, Array]:
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
    r, z = flank.profile_points(2 * count + 1)
    land = flank.half_length - float(z[-1])
    inside = ends[ends < land - 0.15 * flank.groove_map.ball]
    along = fourier.node_positions_with_mid_nodes(np.concatenate([[0.0], inside, [land]]))[1:]
    r, z = np.append(r, np.full(along.size, flank.land_radius)), np.append(z, z[-1] + along)
    return np.append(r[:0:-1], r), np.append(-z[:0:-1], z)


def perpendicular_directions(along: Array) -> Array:
    """Turn directions ``(..., 2)`` in the plane (r, z) by 90 deg from r towards z.

    ``along`` ``(..., 2)``: the directions (r, z) before turning.
    """
    return np.stack([-along[..., 1], along[..., 0]], axis=-1)


def flank_patch_loads(
    flank: HalfGroove, grid: fourier.QuadrilateralGrid, face_lines: Sequence[int], width: float, direction_count: int = 1
) -> Array:
    """Return the nodal forces of unit loads on the flanks of the grooved body, each a Gaussian patch about one contact.

    Loads act along the direction of the nominal contact load and, if ``direction_count`` is 2, also across it; a load
    across it is the difference of two slightly shifted patches. Patches end at the end face. ``face_lines``: numbers of the
    grid lines in z at which the end face may be; ``width``: standard deviation of the patches [m].

    Returns
    -------
    Array
        Forces ``(f, d, e, nodes of the grid, 3)`` for f flanks, d directions of the load and e positions of the end face.
    """
    line = flank.surface_line
    normals = groove.flank_normals(grid, line)
    places, directions = contact_positions_and_directions(flank, grid.z[0, 0])
    out = np.zeros((len(places), direction_count, len(face_lines), *grid.shape, 3))
    for away, (place, along) in enumerate(zip(places, directions, strict=True)):
        pressing = normals * np.sign(normals @ along)[:, None]
        for kind, direction in enumerate((along, perpendicular_directions(along))[:direction_count]):
            share = groove.gaussian_patch_weights(grid, line, place, width, moment=kind)
            for k, cut in enumerate(face_lines):
                force = share[: cut + 1, None] * pressing[: cut + 1]
                total = share[: cut + 1].sum() if kind == 0 else (force @ direction).sum()
                out[away, kind, k, : cut + 1, line, ::2] = force / total
    return out


def smooth_patch_loads(
    flank: HalfGroove,
    grid: fourier.QuadrilateralGrid,
    line: int,
    face_lines: Sequence[int],
    width: float,
    direction_count: int = 1,
) -> Array:
    """Return nodal forces of unit loads on one axial grid line of the smooth body, shaped as those of `flank_patch_loads`.

    ``line``: number of the grid line in r; ``face_lines``: numbers of the lines in z at which the end face may be;
    ``width``: standard deviation of the patches [m]; ``direction_count``: 1 for loads along the nominal load, 2 also across
    it.
    """
    places, directions = contact_positions_and_directions(flank, grid.z[0, 0])
    out = np.zeros((len(places), direction_count, len(face_lines), *grid.shape, 3))
    for away, (place, along) in enumerate(zip(places, directions, strict=True)):
        for k, cut in enumerate(face_lines):
            share = tube.gaussian_weights_on_line(grid.z[: cut + 1, 0], np.array([place]), width)[0]
            for kind, direction in enumerate((along, perpendicular_directions(along))[:direction_count]):
                out[away, kind, k, : cut + 1, line, ::2] = share[:, None] * direction
    return out


def contact_positions_and_directions(flank: HalfGroove, low: float) -> tuple[Array, Array]:
    """Return axial positions ``(f,)`` [m] and nominal load directions (r, z) ``(f, 2)`` of the contacts on f flanks.

    The first groove turn lies at z = 0: its flank pressed towards high z comes first, then its other flank. Both flanks of
    the next groove turn at lower z follow if the body, which begins at z = ``low`` [m], contains it.
    """
    m = flank.groove_map
    place, along = flank.contact_position()[1], flank.nominal_normal
    places, turns = np.array([place, -place]), 2 if low < -2.0 * flank.half_length - m.ball else 1
    shifted = [places - 2.0 * flank.half_length * turn for turn in range(turns)]
    return np.concatenate(shifted), np.concatenate([[along, along * np.array([1.0, -1.0])]] * turns)


def patch_motions_for_end_faces(
    flank: HalfGroove,
    grid: fourier.QuadrilateralGrid,
    face_lines: Sequence[int],
    harmonics: Array,
    held_radii: tuple[float, float],
    fixing: str,
    loads: Array,
    width: float,
    layer: fourier.GrooveLayer | None = None,
) -> Array:
    """Return the motions of load patches in every harmonic, for several positions of the body's end face.

    Parameters
    ----------
    flank, grid
        Groove of the body, and its grid.
    face_lines
        Numbers of the grid lines in z at which the end face may be.
    harmonics
        Harmonics that are computed; the others are interpolated.
    held_radii
        Range of radii in which the end face is fixed [m].
    fixing
        Fixed surface, see `SmoothBody.held`; ``"bore"`` and ``"outer"`` surfaces are fixed in addition to the clamped end.
    loads
        Nodal forces, see `flank_patch_loads`.
    width
        Standard deviation of the patches [m].
    layer
        Anisotropic layer that represents grooves.

    Returns
    -------
    Array
        Motions ``(2, n, 2, d, f, d, e)`` [m/N]: face free or fixed, harmonic, flank that moves, its direction, loaded
        flank, direction of the load, position of the end face.
    """
    from scipy.linalg import cholesky_banded
    from scipy.linalg.lapack import dtbtrs

    columns = grid.shape[1]
    body = fourier.BodyOfRevolution(grid, flank.material, layer)
    held = np.zeros((*grid.shape, 3), dtype=bool)
    held[0] = True
    held[:, 0 if fixing == "bore" else -1 if fixing == "outer" else slice(0, 0)] = True
    beyond = body.stiffness_of_rows()[:, :, 0, :, 0]
    patches, kinds = loads.shape[:2]
    watched = 2 * kinds
    sampled = np.empty((harmonics.size, 2, watched, patches * kinds, len(face_lines)))
    distinct, of = distinct_load_cases(loads.reshape(-1, *loads.shape[2:]), face_lines)
    for values, harmonic in zip(sampled, harmonics.tolist(), strict=True):
        free, bands = body.free_stiffness_bands(harmonic, held)
        powers = fourier.stiffness_part_factors(harmonic)
        L = cholesky_banded(np.tensordot(powers, bands, 1), overwrite_ab=True, lower=True, check_finite=False)
        Y = dtbtrs(L, distinct[:, free].T, uplo="L")[0]
        for k, cut in enumerate(face_lines):
            solution = Y[:, of[k]]
            line = np.flatnonzero(free[3 * cut * columns : 3 * (cut + 1) * columns])
            first = int(np.count_nonzero(free[: 3 * cut * columns]))
            corner = fourier.diagonal_block_of_bands(L, first, line.size)
            S, g = corner @ corner.T, corner @ solution[first : first + line.size]
            if cut < grid.shape[0] - 1:  # L holds what follows the cut, too
                S -= np.tensordot(powers, beyond[:, cut // 2][:, line[:, None], line], 1)
            r = grid.r[cut, line // 3]
            work = solution[:first, :watched].T @ solution[:first]
            for face, moves in enumerate((np.full(line.size, True), (r < held_radii[0]) | (r > held_radii[1]))):
                values[face, ..., k] = work + g[moves, :watched].T @ np.linalg.solve(S[np.ix_(moves, moves)], g[moves])
    motions = groove.interpolate_harmonics(harmonics, sampled)
    shares = groove.gaussian_patch_harmonic_factors(np.arange(float(len(motions))), width, flank.contact_position()[0])
    motions *= shares[:, None, None, None, None]
    return np.moveaxis(motions, 1, 0).reshape(2, len(motions), 2, kinds, patches, kinds, len(face_lines))


def distinct_load_cases(loads: Array, face_lines: Sequence[int]) -> tuple[Array, list[list[int]]]:
    """Find the distinct load cases among those for several end face positions, so that each is solved only once.

    ``loads`` ``(f, e, nodes of the grid, 3)``: nodal forces of f load patches for e positions of the end face;
    ``face_lines``: numbers of the grid lines in z at which the end face may be. A patch that lies entirely below an end
    face has the same load as for the end face furthest from the loaded groove.

    Returns
    -------
    tuple[Array, list[list[int]]]
        The different load cases, one in each row ``(cases, 3 nodes)``; and for each end face the numbers of the rows that
        hold the loads of the f patches.
    """
    rows, of = [x.ravel() for x in loads[:, -1]], [[0] * len(loads) for _ in face_lines]
    for k, cut in enumerate(face_lines):
        for f, load in enumerate(loads):
            alike = np.abs(load[k, : cut + 1] - load[-1, : cut + 1]).max() < SAME * np.abs(load[-1]).max()
            of[k][f] = f if alike else len(rows)
            rows += [] if alike else [load[k].ravel()]
    return np.stack(rows), of
