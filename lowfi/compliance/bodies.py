"""Compliance of screw, nut and ball between the contacts of a scene, by backend.

Each body's compliance is that of a beam with the section constants of the grooved body, plus what a smooth body of
revolution does beyond the same beam theory, plus each contact's own flank, less the half space that Hertz already holds.
What only the geometry decides is kept; what computes it (`lowfi.compliance.between`) is imported where it is not known yet.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rollbench.lowfi.compliance.flank import at_size, size_slope
from rollbench.lowfi.compliance.parts import (
    BOTH,
    Backend,
    flank_of,
    geometry_only,
    grooved_section,
    held_at,
    is_ring,
    of_flanks,
    section_of,
    with_balls,
)
from rollbench.lowfi.compliance.sphere import own_compliance, own_slope, sphere_compliance
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.kept import kept
from rollbench.meshes.one_arc import NEAR, is_one_arc
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import dimensions


@dataclass(frozen=True)
class Coupling:
    """Compliance ``(4 N, 4 N)`` [m/N] between all contacts of a body, not to be written to."""

    G: Array


@dataclass(frozen=True)
class BodyCompliance:
    """Compliance of a body beyond the screw's beam: G ``(2 c, 2 c)`` [m/N] of its flanks' contacts (all left ones, then
    all right ones; two axes each), e [m/N] of each contact besides Hertz, and slope [m/N], what e gains by the logarithm of
    the contact's size."""

    G: Array
    e: float
    slope: float
    assumed: tuple[str, ...]


@dataclass(frozen=True)
class BallCompliance:
    """Ball as an elastic sphere: e [m/N] of each contact besides Hertz, slope [m/N], what e gains by the logarithm of the
    contact's size, coupling g [(m/N)^(1/2)] of the pairs SL-NR and SR-NL and its sign."""

    e: float
    slope: float
    g: float
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
        from rollbench.lowfi.compliance.between import nut_beam

        return BodyCompliance(nut_beam(scene, layout, flanks), 0.0, 0.0, ())
    refuse_flat(geometry, screw, backend)
    e = _own_flank(geometry, screw, backend)
    slope = 0.0
    if backend.flank:
        e += at_size(flank_of(geometry, screw), semi_axes)
        slope = size_slope(flank_of(geometry, screw))
    parts = dimensions(geometry)
    assumed = tuple(line for line in parts.assumed if line not in parts.mesh_only)
    return BodyCompliance((whole or whole_body)(scene, layout, screw, backend, flanks), e, slope, assumed)


def refuse_flat(scene: Scene, screw: bool, backend: Backend) -> None:
    """Raise ValueError where a contact of the nominal angle lies so near the groove's apex that its patch crosses it: the
    flank's correction then grows as one over the angle. A ring whose groove is one arc has one patch there instead."""
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
    """Compliance ``(2 c, 2 c)`` [m/N] of the nut, or of the screw beyond its beam, without each contact's own flank, but
    with what faces add to it.

    Kept for all load cases of the same parts and balls: not to be written to.
    """
    if held_at(geometry_only(scene), screw) == "rigid":
        return np.zeros((2 * len(flanks) * layout.z.size,) * 2)
    geometry, azimuths = with_balls(scene)
    if np.array_equal(layout.azimuth, azimuths):
        return of_flanks(_whole_body(geometry, screw, backend).G, flanks)
    from rollbench.lowfi.compliance.between import body_at

    return body_at(geometry, layout, screw, backend, flanks)


#: What computes `whole_body`.
WholeBody = Callable[[Scene, BallLayout, bool, Backend, Sequence[int]], Array]


@lru_cache(maxsize=8)
@kept(Coupling)
def _whole_body(scene: Scene, screw: bool, backend: Backend) -> Coupling:
    from rollbench.lowfi.compliance.between import body_at

    return Coupling(body_at(scene, ball_layout(scene), screw, backend))


@lru_cache(maxsize=64)
@kept(float)
def _own_flank(geometry: Scene, screw: bool, backend: Backend) -> float:
    from rollbench.lowfi.compliance.between import own_flank

    return own_flank(geometry, screw, backend)


def ball_compliance(scene: Scene, semi_axes: tuple[float, float], backend: Backend) -> BallCompliance:
    """The ball's own body: opposite contacts share their force, so what they do to one another joins each one's own."""
    if backend.ball == "half space":
        return BallCompliance(0.0, 0.0, 0.0, 1.0)
    radius, material = scene.balls.radius, scene.balls.material
    alone = own_compliance(semi_axes, radius, material)
    opposite = sphere_compliance(-1.0, radius, material)
    cosine = float(np.cos(2.0 * scene.track.contact_angle))
    across = 0.5 * (sphere_compliance(cosine, radius, material) + sphere_compliance(-cosine, radius, material))
    alone += opposite - 2.0 * abs(across)
    return BallCompliance(alone, own_slope(radius, material), float(np.sqrt(abs(across))), float(np.sign(across)))


def forget() -> None:
    """Clear the per-geometry caches, so that the next solve is timed with its set-up."""
    from rollbench.lowfi.compliance.between import kept_near_face, of_sections, of_tube, smooth_compliance, whole_ring

    for memory in (
        geometry_only,
        with_balls,
        flank_of,
        held_at,
        grooved_section,
        section_of,
        smooth_compliance,
        of_tube,
        of_sections,
        whole_ring,
        _own_flank,
        kept_near_face,
        _whole_body,
    ):
        memory.cache_clear()
