"""Compliance of screw, nut and ball between the contacts of a scene, computed by a chosen model or read from a file.

The compliance of a body is the sum of a beam with the section constants of the grooved body, of a smooth body of revolution
less its own beam, and of the true flank at each contact less the half space that Hertz's law already contains. Results that
depend only on the geometry are cached in memory and on disk; `lowfi.compliance.between` computes them.

A shaft on which a nut sits is also loaded at its ends (`screw_response_to_end_wrench`). By Saint-Venant's principle the
rest of the shaft acts on the stretch under the nut only by a wrench at its high end. The smooth body of revolution of that
stretch (`lowfi.compliance.tube`) is fixed by the mean motions of its low end. Under a wrench at its high end it contracts
laterally under tension, takes an anticlastic surface under a moment, and warps under a shear force. This moves the contacts
in addition to the beam; by reciprocity, contact loads move the high end.

The file of a condensed 3D model contains motions along the nominal contact normals; motions across them follow from the
low-order bodies. The screw's beam outside the nut, its supports and loads remain those of the low-order model.

Modes of negative compliance, which are numerical errors, are removed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path

import numpy as np

from rollbench.lowfi.compliance import between, beyond_hertz, parts
from rollbench.lowfi.compliance.between import EndWrenchMotions
from rollbench.lowfi.compliance.parts import BOTH, REFINED, ComplianceModel
from rollbench.lowfi.compliance.tube import clamped_beam_compliance, contact_motions_by_rigid_motions
from rollbench.meshes.arrays import Array
from rollbench.meshes.cache import cached_on_disk
from rollbench.meshes.condensed import CondensedBodies, digest_of_geometry, read_condensed_bodies
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.one_arc import NEAR, has_single_arc_grooves
from rollbench.meshes.parts import SIDE_SIGNS, SIDES, Scene
from rollbench.meshes.solid import dimensions_of_3d_parts
from rollbench.meshes.washers import has_washers


@dataclass(frozen=True)
class BodyCompliance:
    """Elastic compliance of the nut, or of the screw in addition to its beam, at c ball contacts."""

    #: Compliance between the contacts: all left contacts, then all right contacts, along the radial and the binormal axis
    #: each ``(2 c, 2 c)`` [m/N].
    G: Array
    #: Local compliance of the flank, the same at all contacts: motion of a contact along its normal by a unit load on this
    #: contact, in addition to the approach by Hertz's law [m/N].
    contact_compliance: float
    #: Derivative of ``contact_compliance`` with respect to the natural logarithm of the contact ellipse's mean semi-axis
    #: [m/N].
    contact_compliance_slope: float
    #: Sentences on dimensions of the body that the scene does not state and that were assumed.
    assumed_dimensions: tuple[str, ...]


@dataclass(frozen=True)
class BallCompliance:
    """Compliance of a ball as an elastic sphere at its four contacts, in addition to Hertz contact."""

    #: Motion of a contact by a unit load on it, in addition to the approach by Hertz's law [m/N]; the load on the opposite
    #: contact, which is equally large, is included.
    contact_compliance: float
    #: Derivative of ``contact_compliance`` with respect to the natural logarithm of the contact ellipse's mean semi-axis
    #: [m/N].
    contact_compliance_slope: float
    #: Square root of the magnitude of the compliance between the two pairs of opposite contacts, SL-NR and SR-NL (S: screw,
    #: N: nut; L: left, R: right): mean motion of the contacts of one pair by a unit load on a contact of the other pair
    #: [(m/N)^(1/2)].
    pair_coupling_root: float
    #: Sign of the compliance that couples the two pairs of opposite contacts, SL-NR and SR-NL.
    pair_coupling_sign: float


def body_compliance(
    scene: Scene,
    layout: BallLayout,
    screw: bool,
    backend: ComplianceModel,
    semi_axes: tuple[float, float],
    flanks: Sequence[int] = BOTH,
    compute_between_contacts: WholeBody | None = None,
) -> BodyCompliance:
    """Return the elastic compliance of the nut, or of the screw in addition to its beam, at the contacts of a scene.

    Parameters
    ----------
    scene, layout
        The scene and the positions of its balls.
    screw
        Whether the body is the screw; otherwise it is the nut.
    backend
        Model of the bodies' compliance.
    semi_axes
        Semi-axes of a typical contact ellipse, across the groove and along it [m].
    flanks
        Numbers of the flanks with contacts: 0 left, 1 right.
    compute_between_contacts
        Function used in place of `compliance_between_contacts`, for example one that reuses results of similar layouts.

    Raises
    ------
    ValueError
        The dimensions leave no groove, no wall or no land, or the contacts are at the groove's apex.
    """
    kind = backend.screw if screw else backend.nut
    zero = np.zeros((2 * len(flanks) * layout.z.size,) * 2)
    if kind == "rigid" or (screw and kind == "beam"):
        return BodyCompliance(zero, 0.0, 0.0, ())
    geometry = parts.reduce_to_compliance_geometry(scene)
    held = parts.fixed_surface(geometry, screw)
    if held == "rigid":
        return BodyCompliance(zero, 0.0, 0.0, ())
    if kind == "beam":
        return BodyCompliance(between.nut_beam_compliance(scene, layout, flanks), 0.0, 0.0, ())
    refuse_small_contact_angle(geometry, screw, backend)
    e = _cached_flank_compliance(geometry, screw, backend)
    slope = 0.0
    if backend.flank:
        e += beyond_hertz.contact_size_correction(parts.half_groove_of_body(geometry, screw), semi_axes)
        slope = beyond_hertz.contact_size_correction_slope(parts.half_groove_of_body(geometry, screw))
    dims = dimensions_of_3d_parts(geometry)
    assumed = tuple(line for line in dims.assumed if line not in dims.mesh_only)
    G = (compute_between_contacts or compliance_between_contacts)(scene, layout, screw, backend, flanks)
    return BodyCompliance(G, e, slope, assumed)


def refuse_small_contact_angle(scene: Scene, screw: bool, backend: ComplianceModel) -> None:
    """Raise ValueError if the nominal contact angle is so small that the load patch crosses the groove's apex.

    The correction for the flank would then grow in inverse proportion to the angle. A bearing ring whose groove is one
    circular arc is not checked, as one load patch at its bottom takes the place of two. ``screw``: whether the body is the
    screw (True) or the nut; ``backend``: model of the bodies.
    """
    angle = scene.track.contact_angle
    radius = (scene.screw if screw else scene.nut).groove_radius
    one_patch = has_single_arc_grooves(scene) and parts.is_elastic_bearing_ring(scene, screw)
    if not one_patch and backend.flank and radius * np.sin(angle) < NEAR * scene.balls.radius:
        least = np.degrees(np.arcsin(NEAR * scene.balls.radius / radius))
        raise ValueError(
            f"got a contact angle of {np.degrees(angle):.3g} deg; models with elastic groove flanks need at least "
            f"{least:.2g} deg for this groove, because nearer to its bottom the contacts of both flanks merge into one; "
            "use the models lin, lin-cell or lin-nut, which warn where they count such a contact twice"
        )


def compliance_between_contacts(
    scene: Scene, layout: BallLayout, screw: bool, backend: ComplianceModel, flanks: Sequence[int] = BOTH
) -> Array:
    """Return the compliance between all contacts of the nut, or of the screw in addition to its beam.

    The effect of end faces is included; the local compliance of the flank at each contact under its own load
    (`BodyCompliance.contact_compliance`) is not. The array is cached for all load cases of the same parts and balls, so it
    must not be modified.

    ``screw``: whether the body is the screw (True) or the nut; ``layout``: positions of the balls; ``backend``: model of
    the bodies' compliance; ``flanks``: numbers of the flanks with contacts, 0 left, 1 right.

    Returns
    -------
    Array
        Motions of the c contacts by loads on them, two axes each ``(2 c, 2 c)`` [m/N].
    """
    if parts.fixed_surface(parts.reduce_to_compliance_geometry(scene), screw) == "rigid":
        return np.zeros((2 * len(flanks) * layout.z.size,) * 2)
    geometry, azimuths = parts.compliance_geometry_with_balls(scene)
    if np.array_equal(layout.azimuth, azimuths):
        return parts.compliance_block_of_flanks(_cached_compliance_between_contacts(geometry, screw, backend), flanks)
    return between.compute_compliance_between_contacts(geometry, layout, screw, backend, flanks)


#: Type of a function that computes the compliance of a whole body, as `compliance_between_contacts`.
WholeBody = Callable[[Scene, BallLayout, bool, ComplianceModel, Sequence[int]], Array]


@lru_cache(maxsize=16)  # screws and nuts of eight sets on a shaft
@cached_on_disk(np.ndarray)
def _cached_compliance_between_contacts(scene: Scene, screw: bool, backend: ComplianceModel) -> Array:
    """Return the compliance between all contacts of screw or nut on both flanks, cached in memory and on disk.

    ``screw``: whether the body is the screw (True) or the nut; ``backend``: model of the bodies.
    """
    return between.compute_compliance_between_contacts(scene, ball_layout(scene), screw, backend)


@lru_cache(maxsize=64)
@cached_on_disk(float)
def _cached_flank_compliance(geometry: Scene, screw: bool, backend: ComplianceModel) -> float:
    """Return the local compliance of a groove flank at a contact [m/N], cached in memory and on disk.

    The value is that of `lowfi.compliance.between.flank_self_compliance`. ``screw``: whether the body is the screw (True)
    or the nut; ``backend``: model of the bodies.
    """
    return between.flank_self_compliance(geometry, screw, backend)


def ball_compliance(scene: Scene, semi_axes: tuple[float, float], backend: ComplianceModel) -> BallCompliance:
    """Return the compliance of a ball at its contacts, in addition to Hertz contact.

    Opposite contacts carry the same force, so the motion of one by the load on the other is added to its self-compliance.
    ``semi_axes``: semi-axes of a typical contact ellipse [m]; ``backend``: model, which may treat the ball as half spaces
    without further compliance.
    """
    if backend.ball == "half space":
        return BallCompliance(0.0, 0.0, 0.0, 1.0)
    radius, material = scene.balls.radius, scene.balls.material
    sphere = partial(beyond_hertz.sphere_compliance, radius=radius, material=material)
    alone = beyond_hertz.sphere_self_compliance(semi_axes, radius, material)
    cosine = float(np.cos(2.0 * scene.track.contact_angle))
    # a ball between two washers has one pair of contacts only; the contacts of both pairs would meet at 90 deg
    across = 0.0 if has_washers(scene) else 0.5 * (sphere(cosine) + sphere(-cosine))
    alone += sphere(-1.0) - 2.0 * abs(across)
    slope = beyond_hertz.sphere_self_compliance_slope(radius, material)
    return BallCompliance(alone, slope, float(np.sqrt(abs(across))), float(np.sign(across)))


def screw_response_to_end_wrench(scene: Scene, layout: BallLayout, backend: ComplianceModel) -> EndWrenchMotions | None:
    """Return the motions of a screw's contacts and high-z end face by six unit loads on that face, less the beam's motions.

    ``layout``: positions of the balls; ``backend``: model of the bodies' compliance. The result is None for a screw that is
    rigid or only a beam, and for a bearing ring fixed at its bore. The arrays are cached for all load cases of the same
    parts and balls, so they must not be modified.
    """
    if backend.screw != "kernel" or parts.fixed_surface(parts.reduce_to_compliance_geometry(scene), True) != "section":
        return None
    geometry, azimuths = parts.compliance_geometry_with_balls(scene)
    if np.array_equal(layout.azimuth, azimuths):
        return _cached_response_to_end_wrench(geometry, backend)
    return between.screw_motions_by_end_wrench(geometry, layout, backend)


@lru_cache(maxsize=64)
@cached_on_disk(EndWrenchMotions)
def _cached_response_to_end_wrench(scene: Scene, backend: ComplianceModel) -> EndWrenchMotions:
    """Return the result of `screw_response_to_end_wrench` for the balls of a scene, cached in memory and on disk."""
    return between.screw_motions_by_end_wrench(scene, ball_layout(scene), backend)


def screw_response_to_section_wrench(scene: Scene, layout: BallLayout, backend: ComplianceModel, section_z: float) -> Array:
    """Return the motions ``(4 N, 6)`` of a screw's contacts by six unit loads on a cross-section, less the beam's motions.

    The rows are in the order of `EndWrenchMotions.contact_motions`. The screw must be one for which
    `screw_response_to_end_wrench` is not None. ``layout``: positions of the N balls; ``section_z``: axial position of the
    section [m], between the screw's ends. The array is cached as in `screw_response_to_end_wrench`.
    """
    geometry, azimuths = parts.compliance_geometry_with_balls(scene)
    if np.array_equal(layout.azimuth, azimuths):
        return _cached_response_to_section_wrench(geometry, backend, section_z)
    return between.screw_motions_by_section_wrench(geometry, layout, backend, section_z)


@lru_cache(maxsize=64)
@cached_on_disk(np.ndarray)
def _cached_response_to_section_wrench(scene: Scene, backend: ComplianceModel, section_z: float) -> Array:
    """Return the result of `screw_response_to_section_wrench` for the balls of a scene, cached in memory and on disk."""
    return between.screw_motions_by_section_wrench(scene, ball_layout(scene), backend, section_z)


#: Names of the bodies in the file of a condensed 3D model, in addition to the balls.
PARTS = ("screw", "nut")


@dataclass(frozen=True)
class CondensedCompliance:
    """Compliance of screw, nut and balls from the file of a condensed 3D model of one geometry."""

    #: Contents of the file: compliance matrices of screw, nut and balls.
    file_contents: CondensedBodies
    #: Names of the bodies (screw, nut) whose compliance is taken from the file, the compliance of the contacts in their
    #: grooves included.
    parts: tuple[str, ...] = PARTS

    @staticmethod
    def read_checked(path: Path, scene: Scene) -> CondensedCompliance:
        """Read the file of a condensed 3D model and check that it has the geometry of a scene.

        Raises
        ------
        ValueError
            The file is damaged, or was made for other parts.
        OSError
            The file cannot be read.
        """
        bodies = read_condensed_bodies(path)
        if bodies.geometry != digest_of_geometry(scene):
            raise ValueError(
                "the file of condensed bodies was made for other parts: track, screw, nut, balls or [solid] differ from "
                "the scene"
            )
        return CondensedCompliance(bodies)

    @property
    def covers_screw_and_nut(self) -> bool:
        """Whether the compliance of both screw and nut is taken from the file."""
        return self.parts == PARTS

    def flanks_covered_by_file(self, sides: list[int]) -> list[int]:
        """Return those of the flanks ``sides`` (0, 1: screw; 2, 3: nut) whose contact compliance is read from the file."""
        return [s for s in sides if s in self.file_contents.sides and ("screw" if s < 2 else "nut") in self.parts]

    def replace_normal_compliance(
        self, scene: Scene, layout: BallLayout, sides: list[int], total: Array, backend: ComplianceModel
    ) -> Array:
        """Return the low-order compliance of screw or nut, with its part along the contact normals taken from the file.

        Motions that the file does not contain, across the normals and on other flanks, depend on the motions along the
        normals as in the low-order body, so that the matrix remains positive semidefinite. With the blocks A along the
        normals, D across them and B between both, replacing A by A' gives B' = A' A^-1 B and D' = D + B^T A^-1 (A' - A)
        A^-1 B.

        ``layout``: positions of the N balls; ``sides``: flanks of the body with contacts (0, 1: screw; 2, 3: nut);
        ``total``: low-order compliance on these flanks [m/N], ball after ball, with supports and beam.
        """
        N, screw = layout.z.size, sides[0] < 2
        geometry = parts.reduce_to_compliance_geometry(scene)
        if parts.fixed_surface(geometry, screw) == "rigid" or ("screw" if screw else "nut") not in self.parts:
            return total
        x, axes = between.contact_points_and_axes(scene, layout, screw)
        held = compliance_between_contacts(scene, layout, screw, backend)
        if screw and parts.fixed_surface(geometry, True) == "section":
            section = parts.grooved_section(geometry, True)
            rows, stations, ends = (
                contact_motions_by_rigid_motions(x, axes),
                np.repeat(x[:, 2], 2),
                (self.file_contents.base, 0.0),
            )
            held = held + clamped_beam_compliance(rows, stations, ends, "low", section)
        known = [s for s in ((0, 1) if screw else (2, 3)) if s in self.file_contents.sides]
        file_G = self.file_contents.screw if screw else self.file_contents.nut
        if file_G.shape != (N * len(known),) * 2:
            raise ValueError(
                "the file of condensed bodies does not have the scene's number of contacts: export it again for this scene"
            )
        rows = nominal_normals_matrix(scene, N, known)
        change = file_G - rows @ held @ rows.T
        common = [s for s in sides if s in known]
        if not common:
            return total
        pick = np.concatenate([np.arange(N)[:, None] * len(known) + known.index(s) for s in common], axis=1).ravel()
        along, across = normal_and_tangent_matrices(scene, N, sides, common)
        A, B = along @ total @ along.T, along @ total @ across.T
        follow = np.linalg.solve(A, B)
        spread = along + follow @ across
        return np.asarray(total + spread.T @ change[np.ix_(pick, pick)] @ spread)

    def ball_compliance_of_file(self, scene: Scene, semi_axes: tuple[float, float]) -> BallCompliance:
        """Return the compliance of a ball at its four contacts, taken from the file of the condensed 3D model.

        ``semi_axes``: semi-axes of a typical contact ellipse [m], from which the coupling follows if the file contains only
        one of both pairs of opposite contacts.
        """
        D, sides = self.file_contents.ball, [int(s) for s in self.file_contents.sides]
        closed = ball_compliance(scene, semi_axes, REFINED)
        pairs = [(sides.index(a), sides.index(3 - a)) for a in (0, 1) if a in sides and 3 - a in sides]
        alone = float(np.mean([0.5 * (D[a, a] + D[b, b]) + D[a, b] for a, b in pairs]))
        across = closed.pair_coupling_sign * closed.pair_coupling_root**2
        if len(pairs) == 2:
            (a, b), (c, d) = pairs
            across = 0.25 * float(D[a, c] + D[a, d] + D[b, c] + D[b, d])
        return BallCompliance(alone - 2.0 * abs(across), 0.0, float(np.sqrt(abs(across))), float(np.sign(across)))

    def describe_source(self) -> str:
        """Return a phrase for reports: bodies, mesh level and flanks whose compliance is taken from the file."""
        names = ", ".join(SIDES[int(s)] for s in self.file_contents.sides)
        level = self.file_contents.level
        bodies = " and ".join(self.parts) if self.parts != PARTS else "screw, nut and balls"
        return f"{bodies} from a condensed 3D model (mesh level {level}, sides {names}), along the normals"


def nominal_normals_matrix(scene: Scene, N: int, sides: list[int]) -> Array:
    """Return the matrix that converts contact motions along two axes to those along the nominal contact normals.

    ``N``: number of balls; ``sides``: f flanks of one body (0, 1: screw; 2, 3: nut). The matrix is ``(N f, 4 N)``: its
    columns are two axes for each ball on the left flank, then on the right flank; its rows go ball after ball, each with
    all flanks of ``sides``.
    """
    out, ball = np.zeros((N, len(sides), 2, N, 2)), np.arange(N)
    for k, (s, normal) in enumerate(zip(sides, nominal_normals(scene, sides), strict=True)):
        out[ball, k, s % 2, ball] = normal
    return out.reshape(N * len(sides), 4 * N)


def nominal_normals(scene: Scene, sides: list[int]) -> Array:
    """Return the nominal contact normals ``(k, 2)`` of k flanks in the section planes of the balls; ``sides``: numbers."""
    beta = scene.track.contact_angle
    return np.asarray(np.array(SIDE_SIGNS)[sides] * np.array([np.cos(beta), np.sin(beta)]))


def normal_and_tangent_matrices(scene: Scene, N: int, sides: list[int], normal_flanks: list[int]) -> tuple[Array, Array]:
    """Return two matrices that split contact motions: along the nominal normals of some flanks, and all other directions.

    ``N``: number of balls; ``sides``: f flanks with contacts; ``normal_flanks``: k of these flanks, whose motions along the
    normals are to be separated. Columns are two axes for each ball and each of its flanks ``sides``. The first matrix has a
    unit row along the normal for each ball and each flank of ``normal_flanks``, ``(N k, 2 N f)``; the rows of the second
    complete it to an orthonormal basis.
    """
    normals, pressed = nominal_normals(scene, sides), np.isin(sides, normal_flanks)
    rows = np.zeros((N, len(sides), 2, N, len(sides), 2))  # normal, then tangent of each contact
    ball, side = np.arange(N)[:, None], np.arange(len(sides))
    rows[ball, side, 0, ball, side] = normals
    rows[ball, side, 1, ball, side] = np.stack([-normals[:, 1], normals[:, 0]], axis=1)
    along, free, across = (
        x.reshape(-1, 2 * N * len(sides)) for x in (rows[:, pressed, 0], rows[:, ~pressed, 0], rows[:, :, 1])
    )
    return along, np.concatenate([free, across])


#: Largest size of a matrix whose eigenvalues are all computed, in a time that grows as its cube; for a larger matrix only
#: the smallest eigenvalues are computed.
WHOLE = 1000

#: Search for negative eigenvalues of a larger matrix: first number of vectors, number of applications of the inverse of the
#: shifted, positive matrix, and the shift over the mean of the diagonal.
FEW, INVERSES, SHIFT = 16, 20, 3e-5


def negative_eigenvalue_part(G: Array) -> tuple[Array, float]:
    """Return the part of a symmetric matrix ``(n, n)`` due to its negative eigenvalues, then the smallest eigenvalue.

    ``G``: the matrix; G less the returned part is positive semidefinite.
    """
    values, vectors = np.linalg.eigh(G) if len(G) <= WHOLE else _smallest_eigenpairs(G)
    below = values < 0.0
    return (vectors[:, below] * values[below]) @ vectors[:, below].T, float(values[0])


def _smallest_eigenpairs(G: Array) -> tuple[Array, Array]:
    """Return the smallest eigenvalues of a large symmetric matrix, including all negative ones, and their eigenvectors."""
    from scipy.linalg import cho_factor, cho_solve

    diagonal, count, shift = np.arange(len(G)), FEW, SHIFT * float(np.trace(G)) / len(G)
    while True:
        shifted = G.copy()
        shifted[diagonal, diagonal] += shift
        try:
            factor = cho_factor(shifted, lower=True, overwrite_a=True)  # raises ValueError where G is not finite
            break
        except np.linalg.LinAlgError:
            shift *= 3.0
    while count * INVERSES < len(G):
        values, vectors = _ritz_pairs(G, lambda x: np.asarray(cho_solve(factor, x, check_finite=False)), count)
        negative = int((values < 0.0).sum())  # no more than G has (Cauchy's interlacing)
        if 2 * negative < count:
            return values, vectors
        count = max(2 * count, 2 * negative + 1)
    return np.linalg.eigh(G)


def _ritz_pairs(G: Array, apply: Callable[[Array], Array], count: int) -> tuple[Array, Array]:
    """Return Ritz pairs (approximate eigenpairs) of a symmetric matrix ``G``, by a block Krylov method on its inverse.

    ``apply``: function that multiplies vectors by the shifted inverse; it is applied `INVERSES` times to ``count`` random
    vectors. The smallest eigenvalues of G converge first.
    """
    basis = np.linalg.qr(np.random.default_rng(0).standard_normal((len(G), count)))[0]
    for _ in range(INVERSES - 1):
        applied = apply(basis[:, -count:])
        for _ in range(2):  # orthogonalise twice: one pass leaves round-off errors
            applied -= basis @ (basis.T @ applied)
        basis = np.hstack([basis, np.linalg.qr(applied)[0]])
    values, turn = np.linalg.eigh(basis.T @ (G @ basis))
    return values, basis @ turn
