"""A stretch of shaft between a beam's two ends: what its contacts and its high end do to one another beyond the beam.

By Saint-Venant what lies beyond a stretch acts on it by a wrench alone. Its smooth body of revolution
(`lowfi.compliance.tube`), held by the mean motions of its low end, answers contact forces with the high end free; loaded
there it shrinks under tension, bends its outline under a moment (the anticlastic surface), warps under a shear force. By
reciprocity a contact that presses inward moves the high end away.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rollbench.lowfi.compliance.bodies import contact_frames, smooth_compliance
from rollbench.lowfi.compliance.bodies import forget as forget_bodies
from rollbench.lowfi.compliance.parts import Backend, geometry_only, held_at, with_balls
from rollbench.lowfi.compliance.tube import (
    TubeCompliance,
    cantilever,
    end_springs,
    motion_rows,
    on_line,
    patch_weights,
    points_of,
)
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.kept import kept
from rollbench.meshes.parts import Scene


@dataclass(frozen=True)
class EndResponse:
    """Beyond the smooth body as a beam, by a wrench (forces [N], moments [N m]) on its high end at station high [m]:
    contacts ``(4 N, 6)``, motions of the contacts of both flanks (all left ones, then all right ones; two axes each); own
    ``(6, 6)``, motions of that end."""

    contacts: Array
    own: Array
    high: float


def end_response(scene: Scene, layout: BallLayout, backend: Backend) -> EndResponse | None:
    """Of the screw of a scene; None where its body is no stretch of a shaft: rigid, a beam alone, or a ring on its bore.

    Kept for all load cases of the same parts and balls: not to be written to.
    """
    if backend.screw != "kernel" or held_at(geometry_only(scene), True) != "section":
        return None
    parts, azimuths = with_balls(scene)
    if np.array_equal(layout.azimuth, azimuths):
        return _known(parts, backend)
    return _response(parts, layout, backend)


@lru_cache(maxsize=8)
@kept(EndResponse)
def _known(scene: Scene, backend: Backend) -> EndResponse:
    return _response(scene, ball_layout(scene), backend)


def _response(scene: Scene, layout: BallLayout, backend: Backend) -> EndResponse:
    geometry = geometry_only(scene)
    found = smooth_compliance(geometry, True, backend)
    x, axes = contact_frames(scene, layout, True)
    tube = found.tube
    (low, high), taken = tube.ends, on_line(tube, x)
    plain = tube.section
    rows = np.concatenate([motion_rows(taken, axes), np.eye(6)])
    stations = np.append(np.repeat(x[:, 2], 2), np.full(6, high))
    shift, tilt, axial, twist = end_springs(tube)
    end = np.eye(6)
    end[0, 4], end[1, 3] = high - low, low - high
    by_springs = np.concatenate([motion_rows(taken, axes, low), end])
    beam = cantilever(rows, stations, low, plain, slice(-6, None))
    beam += (by_springs / np.array([shift, shift, axial, tilt, tilt, twist])) @ end.T
    whole = np.concatenate([contacts_by_end(found, x, axes), end_by_end(found)]) - beam
    return EndResponse(whole[:-6], 0.5 * (whole[-6:] + whole[-6:].T), high)


def contacts_by_end(found: TubeCompliance, x: Array, axes: Array) -> Array:
    """Motions ``(2 c, 6)`` of contacts at ``(c, 3)`` [m] along axes ``(c, 2, 3)`` by a wrench on the mean motions of the
    high end."""
    points = points_of(x, axes)
    weights = patch_weights(found.z, points.z, found.tube.width)
    (axial, twist), (shift, tilt) = ((part @ weights.T).swapaxes(1, 2) for part in found.ends)
    c, s = np.cos(points.azimuth)[:, None], np.sin(points.azimuth)[:, None]
    here, turned = np.hstack([c, s, c]), np.hstack([s, -c, s])  # at azimuth 0, and a quarter turn on
    by_load = (shift * here, shift * turned, axial, -tilt * turned, tilt * here, twist)
    return np.stack([np.einsum("cak,ck->ca", points.axes, u).ravel() for u in by_load], axis=1)


def end_by_end(found: TubeCompliance) -> Array:
    """Mean motions ``(6, 6)`` of the high end by a wrench on them."""
    (axial, twist), (shift, tilt) = found.own
    out = np.zeros((6, 6))
    out[2, 2], out[2, 5], out[5, 2], out[5, 5] = axial[0], axial[1], twist[0], twist[1]
    for across, about, sign in ((0, 4, 1.0), (1, 3, -1.0)):
        out[across, across], out[about, about] = shift[0], tilt[1]
        out[across, about] = out[about, across] = sign * shift[1]
    return out


def forget() -> None:
    """Clear all that is kept of bodies, so that the next solve is timed with its set-up."""
    forget_bodies()
    _known.cache_clear()
