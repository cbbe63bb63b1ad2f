"""All balls of a scene in their circuits: sizes, places, and the gaps between neighbours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.friction.screw.track import Track
from rollbench.lowfi.friction.whole.chain import SceneGrooves, grooves_of
from rollbench.lowfi.friction.whole.circuit import circuits
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Drawn, draw_ball_radii
from rollbench.meshes.helix import BallLayout, layout_at, reduced_lead
from rollbench.meshes.parts import Friction, Scene
from rollbench.meshes.parts import Motion as Drive

#: Sum of gaps [rad] below which a closed track is full: forces between its balls are not determined.
FULL = 1e-9


@dataclass(frozen=True)
class Balls:
    """All N balls of a scene, circuit after circuit: radius (N,) [m], azimuth (N,) in the nut's frame [rad] at the start,
    number (N,) in the scene or -1; tracks: of the circuits; spacing (N,): azimuth by which ball k + 1 of a circuit,
    or its first one, is ahead of ball k where they touch [rad].
    """

    tracks: tuple[Track, ...]
    radius: Array
    number: NDArray[np.int64]
    azimuth: Array
    spacing: Array
    grooves: SceneGrooves

    def gaps(self, azimuth: Array) -> Array:
        """Gaps (N,) [rad] to the next ball of the circuit at azimuths (N,)."""
        out = np.empty_like(azimuth)
        for track in self.tracks:
            balls = track.balls
            out[balls] = np.diff(azimuth[balls], append=azimuth[balls.start] + track.ring)
        return np.asarray(out - self.spacing)

    def place(self, azimuth: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Azimuths (N,) on the helix of start 1 folded into the circuits, and which balls are on a loaded arc."""
        folded, loaded = np.empty_like(azimuth), np.zeros(azimuth.size, dtype=bool)
        for track in self.tracks:
            along = track.along(azimuth)
            folded[track.balls], loaded[track.balls] = track.first + along, along < track.arc
        return folded, loaded

    def layout(self, scene: Scene, folded: Array, turned: float = 0.0) -> BallLayout:
        """Places of all balls at azimuths ``folded`` (N,), as ``place`` gives them, where the nut has turned [rad]."""
        track, starts = scene.track, np.empty(folded.size)
        for loop in self.tracks:
            starts[loop.balls] = loop.start
        space = folded + turned + 2.0 * np.pi * starts / track.starts
        return layout_at(track, space, scene.nut.position + reduced_lead(track) * (folded - track.phase))


def balls_of(scene: Scene, friction: Friction, drive: Drive, drawn: Drawn, member: int = 0) -> Balls:
    """The balls of a scene in their circuits at the beginning.

    Raises CircuitError for circuits that cannot be, ValueError where balls overlap or a circuit has no clearance.
    """
    tracks, azimuths, numbers = zip(*circuits(scene), strict=True)
    azimuth, number = np.concatenate(azimuths), np.concatenate(numbers)
    grooves = grooves_of(scene, friction, drive)
    radius = np.where(number >= 0, drawn.ball_radius[np.maximum(number, 0)], 0.0)
    rng = np.random.default_rng([scene.errors.seed, member, 1])  # the draws of the scene's own balls stay what they are
    radius[number < 0] = draw_ball_radii(scene, rng, int(np.sum(number < 0)))
    excess, pair = radius - scene.balls.radius, grooves.pair
    spacing = np.empty_like(radius)
    for members in (track.balls for track in tracks):
        spacing[members] = pair.spacing + (excess[members] + np.roll(excess[members], -1)) / pair.closing
    balls = Balls(tracks, radius, number, azimuth, spacing, grooves)
    gaps = balls.gaps(azimuth)
    if gaps.min() < -FULL:
        raise ValueError(f"balls overlap by {-1e6 * pair.closing * gaps.min():.3g} um where the run begins")
    for members in (track.balls for track in tracks):
        if members.stop - members.start > 1 and gaps[members].sum() < FULL:
            raise ValueError("a circuit without any clearance: forces between its balls are not determined")
    return balls
