"""Compliance of screw, nut and ball between the contacts of a scene: by backend, or read from a file.

Each body's compliance is that of a beam with the section constants of the grooved body, plus what a smooth body of
revolution does beyond the same beam theory, plus each contact's own flank, less the half space that Hertz already contains.
What depends on the geometry only is cached; what computes it (`lowfi.compliance.between`) is imported where it is not
cached.

A stretch of shaft between a beam's two ends (`end_response`): what its contacts and its high end do to one another beyond
the beam. By Saint-Venant what lies beyond a stretch acts on it only by a wrench. Its smooth body of revolution
(`lowfi.compliance.tube`), fixed by the mean motions of its low end, responds to contact loads with the high end free;
loaded there it shrinks under tension, bends its outline under a moment (the anticlastic surface), warps under a shear
force. By reciprocity a contact that presses inward moves the high end away.

A file of a condensed 3D model contains motions along the nominal normals; the low-order bodies keep what lies across them.
The screw's beam beyond the nut, its supports and loads stay those of the low-order model.

Modes of negative compliance, which no body has, are removed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from rollbench.lowfi.compliance.between import contact_frames
from rollbench.lowfi.compliance.beyond_hertz import (
    flank_size_correction,
    flank_size_slope,
    sphere_compliance,
    sphere_self_compliance,
    sphere_self_compliance_slope,
)
from rollbench.lowfi.compliance.parts import (
    BOTH,
    REFINED,
    Backend,
    fixed_surface,
    geometry_only,
    groove_of_body,
    grooved_body_section,
    grooved_section,
    is_ring,
    parts_with_balls,
    select_flanks,
)
from rollbench.lowfi.compliance.tube import clamped_beam_compliance, motion_rows
from rollbench.meshes.arrays import Array
from rollbench.meshes.condensed import CondensedBodies, geometry_digest, load_condensed
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.kept import kept
from rollbench.meshes.one_arc import NEAR, is_one_arc
from rollbench.meshes.parts import SIDE_SIGNS, SIDES, Scene
from rollbench.meshes.solid import dimensions


@dataclass(frozen=True)
class Coupling:
    """Compliance between all contacts of a body; not to be written to."""

    #: ``(4 N, 4 N)`` [m/N].
    G: Array


@dataclass(frozen=True)
class BodyCompliance:
    """Compliance of a body beyond the screw's beam, at c contacts."""

    #: Between its flanks' contacts, all left ones, then all right ones, two axes each ``(2 c, 2 c)`` [m/N].
    G: Array
    #: Linear compliance of each contact besides Hertz [m/N].
    e: float
    #: Derivative of e by the logarithm of the contact's size [m/N].
    slope: float
    #: Assumptions about the body.
    assumed: tuple[str, ...]


@dataclass(frozen=True)
class BallCompliance:
    """Ball as an elastic sphere."""

    #: Linear compliance of each contact besides Hertz [m/N].
    e: float
    #: Derivative of e by the logarithm of the contact's size [m/N].
    slope: float
    #: Coupling of the opposite contacts SL-NR and SR-NL [(m/N)^(1/2)].
    g: float
    #: Sign of the coupling between the two pairs.
    sign: float


def body_compliance(
    scene: Scene,
    layout: BallLayout,
    screw: bool,
    backend: Backend,
    semi_axes: tuple[float, float],
    flanks: Sequence[int] = BOTH,
    whole: WholeBody | None = None,
) -> BodyCompliance:
    """Return the compliance of screw (beyond its beam) or nut between the contacts of a scene.

    Parameters
    ----------
    scene, layout
        The scene and the positions of its balls.
    screw
        Whether of the screw; otherwise of the nut.
    backend
        Model of the bodies' compliance.
    semi_axes
        Of a typical contact, across the groove and along it [m].
    flanks
        0 left, 1 right.
    whole
        Computes `whole_body`, for layouts that have much in common.

    Raises
    ------
    ValueError
        Dimensions that leave no groove, no wall or no land, or contacts at the groove's apex.
    """
    kind = backend.screw if screw else backend.nut
    zero = np.zeros((2 * len(flanks) * layout.z.size,) * 2)
    if kind == "rigid" or (screw and kind == "beam"):
        return BodyCompliance(zero, 0.0, 0.0, ())
    geometry = geometry_only(scene)
    held = fixed_surface(geometry, screw)
    if held == "rigid":
        return BodyCompliance(zero, 0.0, 0.0, ())
    if kind == "beam":
        from rollbench.lowfi.compliance.between import nut_beam

        return BodyCompliance(nut_beam(scene, layout, flanks), 0.0, 0.0, ())
    refuse_flat_contact_angle(geometry, screw, backend)
    e = _cached_flank_compliance(geometry, screw, backend)
    slope = 0.0
    if backend.flank:
        e += flank_size_correction(groove_of_body(geometry, screw), semi_axes)
        slope = flank_size_slope(groove_of_body(geometry, screw))
    parts = dimensions(geometry)
    assumed = tuple(line for line in parts.assumed if line not in parts.mesh_only)
    return BodyCompliance((whole or whole_body)(scene, layout, screw, backend, flanks), e, slope, assumed)


def refuse_flat_contact_angle(scene: Scene, screw: bool, backend: Backend) -> None:
    """Raise ValueError where the nominal contact angle is so flat that the contact patch crosses the groove's apex.

    The flank's correction then grows as one over the angle. A ring whose groove is one arc has one patch there instead.
    """
    angle = scene.track.contact_angle
    radius = (scene.screw if screw else scene.nut).groove_radius
    one_patch = is_one_arc(scene) and is_ring(scene, screw)
    if not one_patch and backend.flank and radius * np.sin(angle) < NEAR * scene.balls.radius:
        least = np.degrees(np.arcsin(NEAR * scene.balls.radius / radius))
        raise ValueError(
            f"contact angle {np.degrees(angle):.3g} deg, but the elastic flanks of this groove need {least:.2g} deg: "
            "nearer to the apex, the contacts of both flanks are one; the models lin, lin-cell and lin-nut solve it, and "
            "warn where they count one contact twice"
        )


def whole_body(scene: Scene, layout: BallLayout, screw: bool, backend: Backend, flanks: Sequence[int] = BOTH) -> Array:
    """Return the compliance of the nut, or of the screw beyond its beam, without each contact's own flank.

    With what faces add to it. Cached for all load cases of the same parts and balls: not to be written to.

    Returns
    -------
    Array
        ``(2 c, 2 c)`` [m/N].
    """
    if fixed_surface(geometry_only(scene), screw) == "rigid":
        return np.zeros((2 * len(flanks) * layout.z.size,) * 2)
    geometry, azimuths = parts_with_balls(scene)
    if np.array_equal(layout.azimuth, azimuths):
        return select_flanks(_cached_whole_body(geometry, screw, backend).G, flanks)
    from rollbench.lowfi.compliance.between import body_between_contacts

    return body_between_contacts(geometry, layout, screw, backend, flanks)


#: What computes `whole_body`.
WholeBody = Callable[[Scene, BallLayout, bool, Backend, Sequence[int]], Array]


@lru_cache(maxsize=8)
@kept(Coupling)
def _cached_whole_body(scene: Scene, screw: bool, backend: Backend) -> Coupling:
    from rollbench.lowfi.compliance.between import body_between_contacts

    return Coupling(body_between_contacts(scene, ball_layout(scene), screw, backend))


@lru_cache(maxsize=64)
@kept(float)
def _cached_flank_compliance(geometry: Scene, screw: bool, backend: Backend) -> float:
    from rollbench.lowfi.compliance.between import flank_self_compliance

    return flank_self_compliance(geometry, screw, backend)


def ball_compliance(scene: Scene, semi_axes: tuple[float, float], backend: Backend) -> BallCompliance:
    """Return compliance of the ball; opposite contacts share their force, so their mutual motion adds to each one's own."""
    if backend.ball == "half space":
        return BallCompliance(0.0, 0.0, 0.0, 1.0)
    radius, material = scene.balls.radius, scene.balls.material
    alone = sphere_self_compliance(semi_axes, radius, material)
    opposite = sphere_compliance(-1.0, radius, material)
    cosine = float(np.cos(2.0 * scene.track.contact_angle))
    across = 0.5 * (sphere_compliance(cosine, radius, material) + sphere_compliance(-cosine, radius, material))
    alone += opposite - 2.0 * abs(across)
    return BallCompliance(
        alone, sphere_self_compliance_slope(radius, material), float(np.sqrt(abs(across))), float(np.sign(across))
    )


@dataclass(frozen=True)
class EndResponse:
    """Response of a stretch of the screw to a wrench (forces [N], moments [N m]) on its high end, beyond the beam."""

    #: Motions of the contacts of both flanks, all left ones, then all right ones, two axes each ``(4 N, 6)``.
    contacts: Array
    #: Motions of that end ``(6, 6)``.
    end: Array
    #: Stations of the low and the high end [m].
    low: float
    high: float


def end_response(scene: Scene, layout: BallLayout, backend: Backend) -> EndResponse | None:
    """Return the response of a scene's screw; None where its body is no stretch of a shaft.

    That is rigid, only a beam, or a ring on its bore. Cached for all load cases of the same parts and balls: not to be
    written to.
    """
    if backend.screw != "kernel" or fixed_surface(geometry_only(scene), True) != "section":
        return None
    parts, azimuths = parts_with_balls(scene)
    if np.array_equal(layout.azimuth, azimuths):
        return _cached_end_response(parts, backend)
    from rollbench.lowfi.compliance.between import motions_by_end

    return EndResponse(*motions_by_end(parts, layout, backend))


@lru_cache(maxsize=8)
@kept(EndResponse)
def _cached_end_response(scene: Scene, backend: Backend) -> EndResponse:
    from rollbench.lowfi.compliance.between import motions_by_end

    return EndResponse(*motions_by_end(scene, ball_layout(scene), backend))


def section_response(scene: Scene, layout: BallLayout, backend: Backend, at: float) -> Array:
    """Return the motions ``(4 N, 6)`` of the contacts, as `EndResponse.contacts`, by a wrench on a section between them.

    at: its station [m], inside the stretch of a screw that has an `end_response`. Cached as that one.
    """
    parts, azimuths = parts_with_balls(scene)
    if np.array_equal(layout.azimuth, azimuths):
        return _cached_section_response(parts, backend, at).G
    from rollbench.lowfi.compliance.between import motions_by_section

    return motions_by_section(parts, layout, backend, at)


@lru_cache(maxsize=8)
@kept(Coupling)
def _cached_section_response(scene: Scene, backend: Backend, at: float) -> Coupling:
    from rollbench.lowfi.compliance.between import motions_by_section

    return Coupling(motions_by_section(scene, ball_layout(scene), backend, at))


def clear_kept_bodies() -> None:
    """Clear all that is kept of bodies, so that the next solve is timed with its set-up."""
    from rollbench.lowfi.compliance.between import (
        cached_near_face,
        cached_section_motions,
        cached_tube_compliance,
        grooved_ring_compliance,
        near_face_of_body,
        smooth_compliance,
    )

    for memory in (
        geometry_only,
        parts_with_balls,
        groove_of_body,
        fixed_surface,
        grooved_section,
        grooved_body_section,
        smooth_compliance,
        cached_tube_compliance,
        cached_section_motions,
        cached_near_face,
        grooved_ring_compliance,
        _cached_flank_compliance,
        near_face_of_body,
        _cached_whole_body,
        _cached_end_response,
        _cached_section_response,
    ):
        memory.cache_clear()


#: Bodies that a file holds, besides the balls.
PARTS = ("screw", "nut")


@dataclass(frozen=True)
class Condensed:
    """Bodies of a condensed 3D model for one geometry."""

    #: The compliance in the file.
    bodies: CondensedBodies
    #: Bodies that are taken from it, with the laws of the contacts on their grooves and the ball's share of these.
    parts: tuple[str, ...] = PARTS

    @staticmethod
    def read(path: Path, scene: Scene) -> Condensed:
        """Read a file for a scene.

        Raises
        ------
        ValueError
            A damaged file, or one of other parts.
        OSError
            A file that cannot be read.
        """
        bodies = load_condensed(path)
        if bodies.geometry != geometry_digest(scene):
            raise ValueError("made for other parts (track, screw, nut, balls or [solid] differ)")
        return Condensed(bodies)

    @property
    def whole(self) -> bool:
        """Whether both bodies are those of the file."""
        return self.parts == PARTS

    def sides_of(self, sides: list[int]) -> list[int]:
        """Return those of some flanks whose contacts follow the file."""
        return [s for s in sides if s in self.bodies.sides and ("screw" if s < 2 else "nut") in self.parts]

    def correct(self, scene: Scene, layout: BallLayout, sides: list[int], total: Array, backend: Backend) -> Array:
        """Return the compliance of a body with its part along the normals from the file.

        What the file does not contain, across the normals and on other flanks, follows what all contacts move along theirs
        as in the low-order body, so that the result stays positive semidefinite: with A, B, D the blocks along, between
        and across, A' for A gives B' = A' A^-1 B and D' = D + B^T A^-1 (A' - A) A^-1 B.

        total: the low-order compliance on these flanks, ball after ball, supports and beam included.
        """
        N, screw = layout.z.size, sides[0] < 2
        geometry = geometry_only(scene)
        if fixed_surface(geometry, screw) == "rigid" or ("screw" if screw else "nut") not in self.parts:
            return total
        x, axes = contact_frames(scene, layout, screw)
        held = whole_body(scene, layout, screw, backend)
        if screw and fixed_surface(geometry, True) == "section":
            section = grooved_section(geometry, True)
            held = held + clamped_beam_compliance(
                motion_rows(x, axes), np.repeat(x[:, 2], 2), (self.bodies.base, 0.0), "low", section
            )
        known = [s for s in ((0, 1) if screw else (2, 3)) if s in self.bodies.sides]
        file_G = self.bodies.screw if screw else self.bodies.nut
        if file_G.shape != (N * len(known),) * 2:
            raise ValueError("the file of condensed bodies has another number of contacts")
        rows = normal_rows(scene, N, known)
        change = file_G - rows @ held @ rows.T
        common = [s for s in sides if s in known]
        if not common:
            return total
        pick = np.concatenate([np.arange(N)[:, None] * len(known) + known.index(s) for s in common], axis=1).ravel()
        along, across = normal_and_tangent_rows(scene, N, sides, common)
        A, B = along @ total @ along.T, along @ total @ across.T
        follow = np.linalg.solve(A, B)
        spread = along + follow @ across
        return np.asarray(total + spread.T @ change[np.ix_(pick, pick)] @ spread)

    def ball(self, scene: Scene, semi_axes: tuple[float, float]) -> BallCompliance:
        """Return the ball from the file: what opposite contacts do to themselves and each other, and across."""
        D, sides = self.bodies.ball, [int(s) for s in self.bodies.sides]
        closed = ball_compliance(scene, semi_axes, REFINED)
        pairs = [(sides.index(a), sides.index(3 - a)) for a in (0, 1) if a in sides and 3 - a in sides]
        alone = float(np.mean([0.5 * (D[a, a] + D[b, b]) + D[a, b] for a, b in pairs]))
        across = closed.sign * closed.g**2
        if len(pairs) == 2:
            (a, b), (c, d) = pairs
            across = 0.25 * float(D[a, c] + D[a, d] + D[b, c] + D[b, d])
        return BallCompliance(alone - 2.0 * abs(across), 0.0, float(np.sqrt(abs(across))), float(np.sign(across)))

    def describe(self) -> str:
        """Return a description for the record."""
        names = ", ".join(SIDES[int(s)] for s in self.bodies.sides)
        level = self.bodies.level
        bodies = " and ".join(self.parts) if self.parts != PARTS else "screw, nut and balls"
        return f"{bodies} from a condensed 3D model (mesh level {level}, sides {names}), along the normals"


def normal_rows(scene: Scene, N: int, sides: list[int]) -> Array:
    """Return rows for the motion along the nominal normals, from arrays ordered flank after flank.

    The rows go ball after ball and flank after flank.
    """
    beta = scene.track.contact_angle
    out = np.zeros((N * len(sides), 4 * N))
    for k, s in enumerate(sides):
        direction = np.array(SIDE_SIGNS[s]) * np.array([np.cos(beta), np.sin(beta)])
        for i in range(N):
            first = 2 * ((s % 2) * N + i)
            out[i * len(sides) + k, first : first + 2] = direction
    return out


def normal_and_tangent_rows(scene: Scene, N: int, sides: list[int], known: list[int]) -> tuple[Array, Array]:
    """Return rows along the nominal normals of the ``known`` flanks, and the complement across them.

    On arrays that go ball after ball and flank after flank, ``(N known, 2 N sides)`` and the rest.
    """
    beta = scene.track.contact_angle
    along: list[Array] = []
    across: list[Array] = []
    for i in range(N):
        for k, s in enumerate(sides):
            first = 2 * (i * len(sides) + k)
            normal = np.array(SIDE_SIGNS[s]) * np.array([np.cos(beta), np.sin(beta)])
            for direction, rows in ((normal, along if s in known else across), (np.array([-normal[1], normal[0]]), across)):
                row = np.zeros(2 * N * len(sides))
                row[first : first + 2] = direction
                rows.append(row)
    return np.array(along), np.array(across)


#: Largest compliance whose modes are all found at once, in time that grows as its cube; of a larger one only those wanted.
WHOLE = 1000

#: Of a larger one: vectors that a search for negative modes begins with, how often the inverse of what is positive by a
#: shift is applied to them, and that shift over the mean on the diagonal.
FEW, INVERSES, SHIFT = 16, 20, 3e-5


def negative_part(G: Array) -> tuple[Array, float]:
    """Return the part of a symmetric G ``(n, n)`` in modes of negative eigenvalues, and the least eigenvalue."""
    values, vectors = np.linalg.eigh(G) if len(G) <= WHOLE else _smallest_eigenpairs(G)
    below = values < 0.0
    return (vectors[:, below] * values[below]) @ vectors[:, below].T, float(values[0])


def _smallest_eigenpairs(G: Array) -> tuple[Array, Array]:
    """Return eigenvalues of G, all negative ones among them, and their vectors."""
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
    """Return eigenvalues and vectors of G within a block Krylov space of an operator.

    The operator is applied to some vectors ``INVERSES`` times; those at the far end of its spectrum are those of G.
    """
    basis = np.linalg.qr(np.random.default_rng(0).standard_normal((len(G), count)))[0]
    for _ in range(INVERSES - 1):
        applied = apply(basis[:, -count:])
        for _ in range(2):  # once leaves round-off of what is taken away
            applied -= basis @ (basis.T @ applied)
        basis = np.hstack([basis, np.linalg.qr(applied)[0]])
    values, turn = np.linalg.eigh(basis.T @ (G @ basis))
    return values, basis @ turn
