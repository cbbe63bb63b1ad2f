"""A stretch of shaft between a beam's two ends: what its contacts and its high end do to one another beyond the beam.

By Saint-Venant what lies beyond a stretch acts on it only by a wrench. Its smooth body of revolution
(`lowfi.compliance.tube`), held by the mean motions of its low end, answers contact forces with the high end free; loaded
there it shrinks under tension, bends its outline under a moment (the anticlastic surface), warps under a shear force. By
reciprocity a contact that presses inward moves the high end away.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rollbench.lowfi.compliance.bodies import forget as forget_bodies
from rollbench.lowfi.compliance.parts import Backend, geometry_only, held_at, with_balls
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.kept import kept
from rollbench.meshes.parts import Scene


@dataclass(frozen=True)
class EndResponse:
    """Beyond the smooth body as a beam, by a wrench (forces [N], moments [N m]) on its high end at station high [m]:
    contacts ``(4 N, 6)``, motions of the contacts of both flanks (all left ones, then all right ones; two axes each); end
    ``(6, 6)``, motions of that end."""

    contacts: Array
    end: Array
    high: float


def end_response(scene: Scene, layout: BallLayout, backend: Backend) -> EndResponse | None:
    """Of the screw of a scene; None where its body is no stretch of a shaft: rigid, only a beam, or a ring on its bore.

    Kept for all load cases of the same parts and balls: not to be written to.
    """
    if backend.screw != "kernel" or held_at(geometry_only(scene), True) != "section":
        return None
    parts, azimuths = with_balls(scene)
    if np.array_equal(layout.azimuth, azimuths):
        return _known(parts, backend)
    from rollbench.lowfi.compliance.between import motions_by_end

    return EndResponse(*motions_by_end(parts, layout, backend))


@lru_cache(maxsize=8)
@kept(EndResponse)
def _known(scene: Scene, backend: Backend) -> EndResponse:
    from rollbench.lowfi.compliance.between import motions_by_end

    return EndResponse(*motions_by_end(scene, ball_layout(scene), backend))


def forget() -> None:
    """Clear all that is kept of bodies, so that the next solve is timed with its set-up."""
    forget_bodies()
    _known.cache_clear()
