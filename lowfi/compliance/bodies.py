"""Compliance of screw, nut and ball between the contacts of a scene, by backend.

Each body's compliance is that of a beam with the section constants of the grooved body, plus what a smooth body of
revolution does beyond the same beam theory, plus each contact's own flank, less the half space that Hertz already holds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rollbench.lowfi.compliance.faces import REACH, NearFace, near_face, turned
from rollbench.lowfi.compliance.groove import (
    NARROW,
    RingCompliance,
    at_size,
    half_space,
    ring_compliance,
    ring_contacts,
    size_slope,
)
from rollbench.lowfi.compliance.parts import (
    CLAMPED,
    REFINED,
    Backend,
    clamp,
    flank_of,
    geometry_only,
    grooved_section,
    held_at,
    is_ring,
    smooth_body,
    with_balls,
)
from rollbench.lowfi.compliance.sphere import own_compliance, own_slope, sphere_compliance
from rollbench.lowfi.compliance.tube import (
    TubeCompliance,
    clamped,
    contact_compliance,
    motion_rows,
    on_line,
    points_of,
    spring_compliance,
    tube_compliance,
)
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import BallLayout, ball_layout, nominal_contact_points
from rollbench.meshes.kept import kept
from rollbench.meshes.one_arc import NEAR, is_one_arc
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import dimensions

#: How far beyond the nut's faces the screw takes loads, over the patch's width: a contact beside a face keeps its patch.
BESIDE = 2.5
#: Left and right flank of a groove.
BOTH = (0, 1)
#: Assumptions about the solid parts that only a mesh needs.
MESH_ONLY = ("A hole of", "The screw is three-dimensional")


@dataclass(frozen=True)
class Coupling:
    """Compliance ``(4 N, 4 N)`` [m/N] between all contacts of a body, not to be written to."""

    G: Array


@dataclass(frozen=True)
class BodyCompliance:
    """Compliance of a body beyond the screw's beam: G ``(2 c, 2 c)`` [m/N] of its flanks' contacts (all left ones, then
    all right ones; two axes each), e [m/N] of each contact beside Hertz, and slope [m/N], what e gains by the logarithm of
    the contact's size."""

    G: Array
    e: float
    slope: float
    assumed: tuple[str, ...]


@dataclass(frozen=True)
class BallCompliance:
    """Ball as an elastic sphere: e [m/N] of each contact beside Hertz, slope [m/N], what e gains by the logarithm of the
    contact's size, coupling g [(m/N)^(1/2)] of the pairs SL-NR and SR-NL and its sign."""

    e: float
    slope: float
    g: float
    sign: float


def axes_of(layout: BallLayout) -> Array:
    """Radial and binormal axes of every ball, ``(N, 2, 3)``."""
    return np.stack([layout.radial, layout.binormal], axis=1)


def contact_frames(scene: Scene, layout: BallLayout, screw: bool, flanks: Sequence[int] = BOTH) -> tuple[Array, Array]:
    """Nominal contact points ``(c, 3)`` [m] and section axes ``(c, 2, 3)`` of a body's flanks, of N balls each."""
    at = nominal_contact_points(scene)[:2] if screw else nominal_contact_points(scene)[2:]
    x = [layout.centre + at[s][0] * layout.radial + at[s][1] * layout.binormal for s in flanks]
    return np.concatenate(x), np.concatenate([axes_of(layout)] * len(flanks))


@lru_cache(maxsize=32)
def smooth_compliance(geometry: Scene, screw: bool, backend: Backend) -> TubeCompliance:
    """Compliance of the smooth body over the stretch that the nut covers, kept for all scenes of one geometry."""
    tube, position = smooth_body(geometry, screw, backend), geometry.nut.position
    half = geometry.nut.length / 2.0 + BESIDE * tube.width
    return tube_compliance(tube, (position - half, position + half))


@lru_cache(maxsize=32)
@kept(RingCompliance)
def whole_ring(geometry: Scene, screw: bool) -> RingCompliance:
    """Compliance of a ring with its groove, kept for all scenes of one geometry."""
    return ring_compliance(flank_of(geometry, screw), held_at(geometry, screw))


@lru_cache(maxsize=64)
def own_flank(geometry: Scene, screw: bool, backend: Backend) -> float:
    """e [m/N] of a contact on the true flank, for a narrow patch (`NearFace`)."""
    flank = flank_of(geometry, screw)
    if is_ring(geometry, screw):
        return whole_ring(geometry, screw).normals - half_space(NARROW * flank.map.ball, flank.material)
    tube = smooth_body(geometry, screw, backend)
    if not backend.flank:  # the half space at the smooth body's own patch only
        return -half_space(tube.width, tube.material)
    return kept_near_face(geometry, screw, backend).own


def kernel_part(scene: Scene, layout: BallLayout, screw: bool, backend: Backend, flanks: Sequence[int] = BOTH) -> Array:
    """Compliance ``(2 c, 2 c)`` [m/N] of the smooth body beyond the same body as a beam."""
    geometry = geometry_only(scene)
    x, axes = contact_frames(scene, layout, screw, flanks)
    if float(np.abs(x[:, 2] - scene.nut.position).max()) > 0.5 * scene.nut.length:
        raise ValueError("a contact lies beyond the nut's faces: lengthen the nut or reduce the turns")
    found = smooth_compliance(geometry, screw, backend)
    G = contact_compliance(found, points_of(x, axes))
    tube = found.tube
    plain = tube.section
    x = on_line(tube, x)
    rows, stations = motion_rows(x, axes), np.repeat(x[:, 2], 2)
    if tube.held == "section":
        G = G - spring_compliance(tube, x, axes) - clamped(rows, stations, tube.ends, "low", plain)
    elif tube.held in CLAMPED:
        G = G - clamped(rows, stations, *clamp(tube), plain)
    return G


def nut_beam(scene: Scene, layout: BallLayout, flanks: Sequence[int] = BOTH) -> Array:
    """Compliance ``(2 c, 2 c)`` [m/N] of the nut as a Timoshenko tube clamped at its faces, or at its flange; zero if held
    outside."""
    geometry = geometry_only(scene)
    x, axes = contact_frames(scene, layout, False, flanks)
    if held_at(geometry, False) not in CLAMPED:
        return np.zeros((2 * len(x),) * 2)
    section, tube = grooved_section(geometry, False), smooth_body(geometry, False, REFINED)
    return clamped(motion_rows(x, axes), np.repeat(x[:, 2], 2), *clamp(tube), section)


@lru_cache(maxsize=32)
@kept(NearFace)
def kept_near_face(geometry: Scene, screw: bool, backend: Backend) -> NearFace:
    """What grooves and faces of screw or nut add between contacts of a turn, kept for all scenes of one geometry."""
    radii = (0.0, np.inf) if screw else dimensions(geometry).held_radii
    section, tube = grooved_section(geometry, screw), smooth_body(geometry, screw, backend)
    low, high = (abs(end - geometry.nut.position) - 0.5 * geometry.nut.length for end in tube.ends)
    near = min(low, high) < REACH * geometry.balls.radius
    return near_face(flank_of(geometry, screw), tube, section, radii, near=near)


def grooved_part(scene: Scene, layout: BallLayout, screw: bool, backend: Backend, flanks: Sequence[int] = BOTH) -> Array:
    """What grooves and faces of screw or nut add to the compliance ``(2 c, 2 c)`` [m/N] between contacts less than half a
    lead apart: along their normals, and near a free face across them; far from a face, nothing to a contact's own
    (`own_flank` has that)."""
    geometry = geometry_only(scene)
    flank, held, found = flank_of(geometry, screw), held_at(geometry, screw), kept_near_face(geometry, screw, backend)
    z = contact_frames(scene, layout, screw, flanks)[0][:, 2]
    azimuth, side = np.tile(layout.azimuth, len(flanks)), np.repeat(flanks, layout.z.size)
    middle = z - found.beside * np.where(side == 0, -1.0, 1.0)
    ahead = middle[:, None] - middle
    i, j = np.nonzero((ahead >= 0.0) & (ahead < (2 * found.turns - 1) * flank.half))
    turn = np.rint((middle[i] - middle[j]) / (2.0 * flank.half)).astype(int)
    angle, between = azimuth[i] - azimuth[j], 0.5 * (middle[i] + middle[j])
    gain = np.zeros((i.size, 2, 2))
    gain[:, 0, 0] = np.where(i == j, 0.0, found.between(angle)[np.arange(i.size), 1 - side[i], 2 * turn + 1 - side[j]])
    for high, face in enumerate(smooth_body(geometry, screw, backend).ends):
        distance = np.abs(face - between) - turn * flank.half
        near = np.flatnonzero(distance < REACH * scene.balls.radius)
        if not near.size:
            continue
        away = (side != high).astype(int)
        fixed = held in ("both", "high" if high else "low")
        front, back = (i[near], j[near]) if high else (j[near], i[near])
        added = found.by_face(fixed, angle[near], distance[near])
        own = added[np.arange(near.size), away[front], :, 2 * turn[near] + away[back]]
        gain[near] += own if high else own.swapaxes(1, 2) * np.array([[1.0, -1.0], [-1.0, 1.0]])  # seen from its other end
    signs = flank.map.signs[[s if screw else s + 2 for s in BOTH]][side]
    normal = signs * np.array([np.cos(flank.map.beta), np.sin(flank.map.beta)])
    axes = np.stack([normal, turned(normal)], axis=1)
    G = np.zeros((side.size, 2, side.size, 2))
    G[i, :, j] = axes[i].swapaxes(1, 2) @ gain @ axes[j]
    G[j, :, i] = G[i, :, j].swapaxes(1, 2)
    return G.reshape(2 * side.size, -1)


def body_compliance(
    scene: Scene,
    layout: BallLayout,
    screw: bool,
    backend: Backend,
    semi_axes: tuple[float, float],
    flanks: Sequence[int] = BOTH,
    whole: WholeBody | None = None,
) -> BodyCompliance:
    """Compliance of screw (beyond its beam) or nut between the contacts of a scene, and what is assumed for it.

    semi_axes: of a typical contact [m], across the groove and along it; flanks: 0 left, 1 right; whole: what computes
    `whole_body`, for layouts that have much in common. Raises ValueError for
    dimensions that leave no groove, no wall or no land, and for contacts at the groove's apex.
    """
    kind = backend.screw if screw else backend.nut
    zero = np.zeros((2 * len(flanks) * layout.z.size,) * 2)
    if kind == "rigid" or (screw and kind == "beam"):
        return BodyCompliance(zero, 0.0, 0.0, ())
    geometry = geometry_only(scene)
    held = held_at(geometry, screw)
    if held == "rigid":
        return BodyCompliance(zero, 0.0, 0.0, ())
    if kind == "beam":
        return BodyCompliance(nut_beam(scene, layout, flanks), 0.0, 0.0, ())
    refuse_flat(geometry, screw, backend)
    e = own_flank(geometry, screw, backend)
    slope = 0.0
    if backend.flank:
        e += at_size(flank_of(geometry, screw), semi_axes)
        slope = size_slope(flank_of(geometry, screw))
    assumed = tuple(x for x in dimensions(geometry).assumed if not x.startswith(MESH_ONLY))
    return BodyCompliance((whole or whole_body)(scene, layout, screw, backend, flanks), e, slope, assumed)


def refuse_flat(scene: Scene, screw: bool, backend: Backend) -> None:
    """Raise ValueError where a contact of the nominal angle lies so near the groove's apex that its patch crosses it: the
    flank's correction then grows as one over the angle. A ring whose groove is one arc has one patch there instead."""
    angle = scene.track.contact_angle
    radius = (scene.screw if screw else scene.nut).groove_radius
    one_arc = is_one_arc(scene) and is_ring(scene, screw)
    if not one_arc and backend.flank and radius * np.sin(angle) < NEAR * scene.balls.radius:
        least = np.degrees(np.arcsin(NEAR * scene.balls.radius / radius))
        raise ValueError(
            f"contact angle {np.degrees(angle):.3g} deg, but the elastic flanks of this groove need {least:.2g} deg: "
            "nearer to the apex, the contacts of both flanks are one; the models lin, lin-cell and lin-nut solve it, and "
            "warn where they count one contact twice"
        )


def whole_body(scene: Scene, layout: BallLayout, screw: bool, backend: Backend, flanks: Sequence[int] = BOTH) -> Array:
    """Compliance ``(2 c, 2 c)`` [m/N] of the nut, or of the screw beyond its beam, without each contact's own flank, but
    with what faces add to it.

    Kept for all load cases of the same parts and balls: not to be written to.
    """
    if held_at(geometry_only(scene), screw) == "rigid":
        return np.zeros((2 * len(flanks) * layout.z.size,) * 2)
    geometry, azimuths = with_balls(scene)
    if np.array_equal(layout.azimuth, azimuths):
        return of_flanks(_whole_body(geometry, screw, backend).G, flanks)
    return _body_at(geometry, layout, screw, backend, flanks)


#: What computes `whole_body`.
WholeBody = Callable[[Scene, BallLayout, bool, Backend, Sequence[int]], Array]


def of_flanks(G: Array, flanks: Sequence[int]) -> Array:
    """Rows and columns of some flanks ``(2 c, 2 c)`` of a matrix of both ``(4 N, 4 N)``."""
    if len(flanks) == len(BOTH):
        return G
    half = len(G) // 2
    return np.concatenate([np.concatenate([G[i * half :][:half, j * half :][:, :half] for j in flanks], 1) for i in flanks])


@lru_cache(maxsize=8)
@kept(Coupling)
def _whole_body(scene: Scene, screw: bool, backend: Backend) -> Coupling:
    return Coupling(_body_at(scene, ball_layout(scene), screw, backend))


def _body_at(scene: Scene, layout: BallLayout, screw: bool, backend: Backend, flanks: Sequence[int] = BOTH) -> Array:
    held = held_at(scene, screw)
    if is_ring(geometry_only(scene), screw):
        G = of_flanks(ring_contacts(whole_ring(geometry_only(scene), screw), layout.azimuth), flanks)
    else:
        G = kernel_part(scene, layout, screw, backend, flanks)
        if not screw and held != "outer":
            G = G + nut_beam(scene, layout, flanks)
        if backend.flank:
            G = G + grooved_part(scene, layout, screw, backend, flanks)
    G = 0.5 * (G + G.T)
    G.flags.writeable = False
    return G


def ball_compliance(scene: Scene, semi_axes: tuple[float, float], backend: Backend) -> BallCompliance:
    """The ball's own body: opposite contacts share their force, so what they do to one another joins each one's own."""
    if backend.ball == "half space":
        return BallCompliance(0.0, 0.0, 0.0, 1.0)
    radius, material = scene.balls.radius, scene.balls.material
    own = own_compliance(semi_axes, radius, material)
    opposite = sphere_compliance(-1.0, radius, material)
    cosine = float(np.cos(2.0 * scene.track.contact_angle))
    across = 0.5 * (sphere_compliance(cosine, radius, material) + sphere_compliance(-cosine, radius, material))
    own += opposite - 2.0 * abs(across)
    return BallCompliance(own, own_slope(radius, material), float(np.sqrt(abs(across))), float(np.sign(across)))


def forget() -> None:
    """Clear the per-geometry caches, so that the next solve is timed with its set-up."""
    for memory in (
        geometry_only,
        with_balls,
        flank_of,
        held_at,
        grooved_section,
        smooth_compliance,
        whole_ring,
        own_flank,
        kept_near_face,
        _whole_body,
    ):
        memory.cache_clear()
