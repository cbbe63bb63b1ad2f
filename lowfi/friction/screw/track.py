"""A closed track of balls: where on it they are, and when one reaches an end of its loaded arc."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rollbench.meshes.arrays import Array


class Track(NamedTuple):
    """One closed track: start from 0, azimuth where its loaded arc begins, arc, whole length, distance of touching nominal
    balls [rad], its balls."""

    start: int
    first: float
    arc: float
    ring: float
    spacing: float
    balls: slice

    def along(self, azimuth: Array, turned: float = 0.0) -> Array:
        """Places of its balls on the track, 0 to its length, from azimuths (N,) of all; turned: of the track [rad]."""
        return np.asarray(np.mod(azimuth[self.balls] - turned - self.first, self.ring))

    def to_end(self, azimuth: Array, rate: Array, turned: float = 0.0) -> float:
        """Time [s] until one of its balls passes an end of the loaded arc; rate (N,) of all on the track [rad/s]."""
        along, rate = self.along(azimuth, turned), rate[self.balls]
        forward = np.where(along < self.arc, self.arc, self.ring) - along
        distance = np.where(rate > 0.0, forward, along - np.where(along > self.arc, self.arc, 0.0))
        return float(np.divide(distance, np.abs(rate), out=np.full_like(rate, np.inf), where=rate != 0.0).min())
