"""All balls of a scene in their circuits: sizes, places, and the gaps between neighbours."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.friction.whole.chain import SceneGrooves, grooves_of
from rollbench.lowfi.friction.whole.circuit import Circuit, circuits
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Drawn, draw_ball_radii
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: Sum of gaps [rad] below which a closed track is full: forces between its balls are not determined.
FULL = 1e-9


@dataclass(frozen=True)
class Balls:
    """All N balls of a scene, circuit after circuit: radius (N,) [m], azimuth (N,) in the nut's frame [rad] at the start,
    number (N,) in the scene or -1; bounds: slices of the circuits; spacing (N,): azimuth by which ball k + 1 of a circuit,
    or its first one, is ahead of ball k where they touch [rad].
    """

    tracks: tuple[Circuit, ...]
    bounds: tuple[slice, ...]
    radius: Array
    number: NDArray[np.int64]
    azimuth: Array
    spacing: Array
    grooves: SceneGrooves

    @property
    def circuits(self) -> list[tuple[Circuit, slice]]:
        """The circuits with the slices of their balls."""
        return list(zip(self.tracks, self.bounds, strict=True))

    def gaps(self, azimuth: Array) -> Array:
        """Gaps (N,) [rad] to the next ball of the circuit at azimuths (N,)."""
        out = np.empty_like(azimuth)
        for track, own in self.circuits:
            out[own] = np.diff(azimuth[own], append=azimuth[own.start] + track.ring)
        return np.asarray(out - self.spacing)

    def place(self, azimuth: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Azimuths (N,) on the helix of start 1 folded into the circuits, and which balls are on a loaded arc."""
        folded, loaded = np.empty_like(azimuth), np.zeros(azimuth.size, dtype=bool)
        for track, own in self.circuits:
            along = np.mod(azimuth[own] - track.first, track.ring)
            folded[own], loaded[own] = track.first + along, along < track.arc
        return folded, loaded


def balls_of(scene: Scene, friction: Friction, drive: Drive, drawn: Drawn, member: int = 0) -> Balls:
    """The balls of a scene in their circuits at the beginning.

    Raises CircuitError for circuits that cannot be, ValueError where balls overlap or a circuit has no clearance.
    """
    tracks, grooves = circuits(scene), grooves_of(scene, friction, drive)
    ends = np.cumsum([0, *(t.azimuth.size for t in tracks)])
    bounds = tuple(slice(int(a), int(b)) for a, b in pairwise(ends))
    number = np.concatenate([t.ball for t in tracks])
    radius = np.where(number >= 0, drawn.ball_radius[np.maximum(number, 0)], 0.0)
    rng = np.random.default_rng([scene.errors.seed, member, 1])  # the draws of the scene's own balls stay what they are
    radius[number < 0] = draw_ball_radii(scene, rng, int(np.sum(number < 0)))
    excess, pair = radius - scene.balls.radius, grooves.pair
    spacing = np.empty_like(radius)
    for own in bounds:
        spacing[own] = pair.spacing + (excess[own] + np.roll(excess[own], -1)) / pair.closing
    azimuth = np.concatenate([t.azimuth for t in tracks])
    found = Balls(tracks, bounds, radius, number, azimuth, spacing, grooves)
    gaps = found.gaps(azimuth)
    if gaps.min() < -FULL:
        raise ValueError(f"balls overlap by {-1e6 * pair.closing * gaps.min():.3g} um where the run begins")
    for own in bounds:
        if own.stop - own.start > 1 and gaps[own].sum() < FULL:
            raise ValueError("a circuit without any clearance: forces between its balls are not determined")
    return found
