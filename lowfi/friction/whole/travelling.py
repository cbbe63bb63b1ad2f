"""Loads again and again while balls travel along the track: their bodies' compliance changes slowly."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

import numpy as np

from rollbench.lowfi.compliance.bodies import whole_body
from rollbench.lowfi.compliance.parts import Backend
from rollbench.lowfi.statics.nominal import ContactLoads, beam_loads, elastic_loads
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import BallLayout, layout_at, reduced_lead
from rollbench.meshes.parts import Scene, Track

#: Length of a window of `Travelling` and the least one [rad], how far beyond it balls may be as a part of it, and how far
#: they may move against each other [rad].
WINDOW, LEAST, BEYOND, APART = np.radians(8.0), 1e-4, 0.01, 5e-4


class Window(NamedTuple):
    """Compliance of a body ``(3, 2 c, 2 c)`` [m/N] where its balls are, and half a length [rad] and a length on."""

    azimuth: Array
    z: Array
    length: float
    G: tuple[Array, Array, Array]


@dataclass
class Travelling:
    """Compliance of bodies between contacts that travel round the track together, in place of `whole_body`: computed at
    three places of a window, between them by the parabola through these.

    ahead: length of a window [rad], signed as the balls travel in the nut. A body of revolution with a groove in it answers
    balls that turn and advance together alike, but for its ends: the compliance changes slowly. Where balls move by more
    than ``APART`` against each other, or others are on the loaded arc, a new window begins. Kept for one scene and backend.
    """

    ahead: float
    windows: dict[tuple[object, ...], list[Window]] = field(default_factory=dict)

    def __call__(self, scene: Scene, layout: BallLayout, screw: bool, backend: Backend, flanks: Sequence[int]) -> Array:
        """As `whole_body`."""
        track, rate = scene.track, reduced_lead(scene.track)
        known = self.windows.setdefault((screw, tuple(flanks), layout.z.size), [])
        for window in known:
            moved = layout.azimuth - window.azimuth
            share = float(np.mean(moved if rate == 0.0 else (layout.z - window.z) / rate)) / window.length
            apart = np.abs(moved - moved.mean()).max()
            if apart <= APART and -BEYOND <= share <= 1.0 + BEYOND:
                break
        else:
            share, window = 0.0, self.begin(layout, track, lambda place: whole_body(scene, place, screw, backend, flanks))
            known.append(window)
        first, second, third = window.G
        left = 1.0 - share
        return np.asarray(left * (left - share) * first + 4.0 * share * left * second + share * (share - left) * third)

    def begin(self, layout: BallLayout, track: Track, compute: Callable[[BallLayout], Array]) -> Window:
        """A window from ``layout`` on, shorter where a ball would pass the nut's face. Raises as `whole_body`."""
        rate, length = reduced_lead(track), self.ahead
        while True:
            places = (layout_at(track, layout.azimuth + s, layout.z + s * rate) for s in (length, 0.5 * length, 0.0))
            try:
                third, second, first = map(compute, places)
            except ValueError:
                if abs(length) < LEAST:
                    raise
                length /= 8.0
                continue
            return Window(layout.azimuth, layout.z, length, (first, second, third))


def in_motion(model: str, ahead: float) -> Callable[..., ContactLoads]:
    """How a model finds the loads of balls that travel; ahead: 1.0 or -1.0, as they do in the nut."""
    if model != "refined":
        return AGAIN[model]
    return partial(elastic_loads, whole=Travelling(WINDOW * ahead))


#: How the models of a static run find loads again and again, by name.
AGAIN: dict[str, Callable[..., ContactLoads]] = {"lin": beam_loads, "refined": elastic_loads}
