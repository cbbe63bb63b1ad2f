"""Balls that touch: force and closing speed not negative and complementary, sliding friction at the point of contact.

Two balls of a track turn the same way, so that where they touch they rub at about the full speed of their surfaces: the
whole contact, some hundredths of a radius wide, slides one way, and a point stands for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollbench.hifi.rolling.kinematics import MOTIONS, Track, motion_rows
from rollbench.meshes.arrays import Array


@dataclass(frozen=True)
class Meeting:
    """Balls ``one`` and ``two`` (indices) in touch: rows ``(3, 8)`` of closing speed and sliding of ball one past ball
    two per their motions; directions ``(3, 3)`` of these in common axes; speed [m/s] at which they may close without
    touching."""

    one: int
    two: int
    rows: Array
    axes: Array
    apart: float

    def forces(self, force: float, mu: float, slide: Array) -> Array:
        """Force ``(3,)`` on ball one in common axes at a sliding ``(2,)``; the other's is its opposite."""
        size = float(np.linalg.norm(slide))
        rub = mu * force / size * slide if size > 0.0 else np.zeros(2)
        return np.asarray(-force * self.axes[0] - rub @ self.axes[1:])

    @property
    def columns(self) -> NDArray[np.int64]:
        """Motions of both balls."""
        return np.concatenate([MOTIONS * k + np.arange(MOTIONS) for k in (self.one, self.two)])


def meeting(
    one: int, two: int, frames: tuple[Array, Array], line: Array, track: Track, radius: float, apart: float = 0.0
) -> Meeting:
    """Two balls whose own axes are the rows of ``frames`` ``(3, 3)``, the second along ``line`` ``(3,)`` from the first."""
    side = np.cross(line, np.eye(3)[int(np.argmin(np.abs(line)))])
    side /= np.linalg.norm(side)
    axes = np.stack([line, side, np.cross(line, side)])
    parts = []
    for frame, sign in zip(frames, (1.0, -1.0), strict=True):
        local = axes @ frame.T  # the three directions in the ball's own axes
        at = sign * radius * local[0]
        rows = local @ motion_rows(track, radius, at[None])[0]
        parts.append(sign * rows)
    return Meeting(one, two, np.hstack(parts), axes, apart)


@dataclass(frozen=True)
class Together:
    """f of (2) in `hifi.rolling.friction` for balls with meetings: motions of all balls, then the force of each meeting
    [N].

    mu: coefficient of friction between balls; push ``(4 N,)``: what else acts on the motions [N]; weight: of closing speeds
    beside forces [N s/m].
    """

    count: int
    meetings: Sequence[Meeting]
    mu: float
    push: Array
    weight: float

    def __call__(self, y: Array) -> tuple[Array, Array]:
        """Forces on the motions and the complementarity of every meeting, with their derivative."""
        m = MOTIONS * self.count
        f, S = np.zeros(y.size), np.zeros((y.size, y.size))
        f[:m] += self.push
        for k, pair in enumerate(self.meetings):
            i, row = pair.columns, m + k
            force, speeds = float(y[row]), pair.rows @ y[i]
            closing, slide = speeds[0] - pair.apart, speeds[1:]
            size = float(np.linalg.norm(slide))
            unit = slide / size if size > 0.0 else slide
            turn = (np.eye(2) - np.outer(unit, unit)) / size if size > 0.0 else np.zeros((2, 2))
            f[i] -= force * (pair.rows[0] + self.mu * unit @ pair.rows[1:])
            S[i, row] -= pair.rows[0] + self.mu * unit @ pair.rows[1:]
            S[np.ix_(i, i)] -= force * self.mu * pair.rows[1:].T @ turn @ pair.rows[1:]
            if force + self.weight * closing > 0.0:
                f[row] = self.weight * closing
                S[row, i] = self.weight * pair.rows[0]
            else:
                f[row] = force
                S[row, row] = 1.0
        return f, S
