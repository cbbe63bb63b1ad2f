"""Motions of contacts and of the high end of a stretch of shaft by a wrench on that end, computed: see `ends`."""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.compliance.between import contact_frames, smooth_compliance
from rollbench.lowfi.compliance.parts import Backend, geometry_only
from rollbench.lowfi.compliance.tube import (
    TubeCompliance,
    cantilever,
    end_springs,
    motion_rows,
    on_line,
    patch_weights,
    points_of,
)
from rollbench.lowfi.threads import one_thread
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import Scene


@one_thread()
def motions_by_end(scene: Scene, layout: BallLayout, backend: Backend) -> tuple[Array, Array, float]:
    """The fields of `lowfi.compliance.ends.EndResponse` of a screw that is held by its section."""
    geometry = geometry_only(scene)
    compliance = smooth_compliance(geometry, True, backend)
    x, axes = contact_frames(scene, layout, True)
    tube = compliance.tube
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
    motions = np.concatenate([contacts_by_end(compliance, x, axes), end_by_end(compliance)]) - beam
    return motions[:-6], 0.5 * (motions[-6:] + motions[-6:].T), high


def contacts_by_end(compliance: TubeCompliance, x: Array, axes: Array) -> Array:
    """Motions ``(2 c, 6)`` of contacts at ``(c, 3)`` [m] along axes ``(c, 2, 3)`` by a wrench on the mean motions of the
    high end."""
    points = points_of(x, axes)
    weights = patch_weights(compliance.z, points.z, compliance.tube.width)
    (axial, twist), (shift, tilt) = ((motions @ weights.T).swapaxes(1, 2) for motions in compliance.ends)
    c, s = np.cos(points.azimuth)[:, None], np.sin(points.azimuth)[:, None]
    here, turned = np.hstack([c, s, c]), np.hstack([s, -c, s])  # at azimuth 0, and a quarter turn on
    by_load = (shift * here, shift * turned, axial, -tilt * turned, tilt * here, twist)
    return np.stack([np.einsum("cak,ck->ca", points.axes, u).ravel() for u in by_load], axis=1)


def end_by_end(compliance: TubeCompliance) -> Array:
    """Mean motions ``(6, 6)`` of the high end by a wrench on them."""
    (axial, twist), (shift, tilt) = compliance.corner
    out = np.zeros((6, 6))
    out[2, 2], out[2, 5], out[5, 2], out[5, 5] = axial[0], axial[1], twist[0], twist[1]
    for across, about, sign in ((0, 4, 1.0), (1, 3, -1.0)):
        out[across, across], out[about, about] = shift[0], tilt[1]
        out[across, about] = out[about, across] = sign * shift[1]
    return out
