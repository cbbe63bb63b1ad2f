"""Where the groove of a nut ends that is filled beyond its loaded balls, as a recirculation leaves it.

Along its line the groove is whole as far as `WHOLE` ball diameters (or a socket) beyond the outermost balls; over the next
`RUN_OUT` it rises to the land: its depth below the land is a smoothstep of the azimuth there. Beyond, its flanks lie on the
land's cylinder, so that the surface stays one of strips and meshes as ever.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollbench.meshes.arrays import Array
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import UnfitKey
from rollbench.meshes.sockets import ON_GROOVE, SocketSize, groove_lines, whole_turns
from rollbench.meshes.solid import RUN_OUT, WHOLE


@dataclass(frozen=True)
class GrooveEnds:
    """Ends of the groove of every start: its line z - rg phi [m] ``(n,)``, total azimuths ``(n, 2)`` [rad] between which it
    is whole (NaN for a start without balls), length of the run-out [rad]; reduced lead rg [m/rad]."""

    lines: Array
    whole: Array
    length: float
    rg: float

    @classmethod
    def of(cls, m: GrooveMap, sockets: Iterable[tuple[float, float, int]], size: SocketSize) -> GrooveEnds:
        """Ends beyond the balls of ``sockets`` (azimuth [rad], z [m], side). Raises ValueError for a ring."""
        if not m.rg:
            raise UnfitKey("solid.nut_groove", "the groove of a ring does not end: leave solid.nut_groove out")
        lines = groove_lines(m)
        ball = 2.0 * m.ball / float(np.hypot(m.R, m.rg))
        reach = max(WHOLE * ball, size.phi)
        whole = np.full((len(lines), 2), np.nan)
        for k, line in enumerate(lines):
            places = [(phi, *whole_turns(m, phi, z, line)) for phi, z, _ in sockets]
            on_line = [phi + 2.0 * np.pi * turns for phi, turns, off in places if off <= ON_GROOVE * m.ball]
            if on_line:
                whole[k] = min(on_line) - reach, max(on_line) + reach
        return cls(np.array(lines), whole, RUN_OUT * ball, m.rg)

    def depth(self, line: float, phi: Array) -> Array:
        """Depth of a line's groove at total azimuths, over that of the whole groove: 1 between the ends, 0 in the filled
        rest."""
        low, high = self.whole[int(np.abs(self.lines - line).argmin())]
        t = np.clip(np.maximum(low - phi, phi - high) / self.length, 0.0, 1.0)
        return np.asarray(np.nan_to_num(1.0 - t * t * (3.0 - 2.0 * t)))

    def in_whole(self, points: Array) -> NDArray[np.bool_]:
        """Which points ``(n, 3)`` [m] of the flanks lie where the groove is whole."""
        phi = np.arctan2(points[:, 1], points[:, 0])
        off = points[:, 2] - self.rg * phi - self.lines[:, None]
        turns = np.round(off / (2.0 * np.pi * self.rg))
        nearest = np.abs(off - 2.0 * np.pi * self.rg * turns).argmin(axis=0)
        number = np.arange(len(points))
        total = phi + 2.0 * np.pi * turns[nearest, number]
        low, high = self.whole[nearest].T
        return np.asarray((total >= low) & (total <= high))
