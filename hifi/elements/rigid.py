"""Rigid motions of nodes and sections, which strain nothing."""

from __future__ import annotations

import numpy as np

from rollbench.meshes.arrays import Array


def rigid_modes(points: Array, centre: Array | None = None) -> Array:
    """Three translations and three small rotations about the centre (default: the origin) of points (n, 3), (3n, 6)."""
    x = np.asarray(points, dtype=float) - (0.0 if centre is None else np.asarray(centre, dtype=float))
    modes = np.zeros((len(x), 3, 6))
    modes[:, :, :3] = np.eye(3)
    for k, axis in enumerate(np.eye(3)):
        modes[:, :, 3 + k] = np.cross(axis, x)
    return modes.reshape(-1, 6)


def transport(arm: float) -> Array:
    """Motion (6, 6) of the point at z + arm when the section at z moves rigidly by (u, rotation)."""
    t = np.eye(6)
    t[0, 4], t[1, 3] = arm, -arm
    return t
