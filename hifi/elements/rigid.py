"""Rigid motions of nodes and sections, which cause no strain."""

from __future__ import annotations

import numpy as np

from rollbench.meshes.arrays import Array


def nodal_displacements_of_rigid_motions(points: Array, centre: Array | None = None) -> Array:
    """Compute the nodal displacements of six unit rigid motions: translations, and small rotations about a centre.

    Parameters
    ----------
    points : (n, 3) Array
        Coordinates of the n nodes [m].
    centre : (3,) Array, optional, default None
        Centre of the rotations [m]; None: the origin.

    Returns
    -------
    (3 n, 6) Array
        Displacements of the nodes by three unit translations, then by three small unit rotations, as columns.

    Examples
    --------
    A rotation about z moves a point on y along -x:

    >>> nodal_displacements_of_rigid_motions(np.array([[0.0, 2.0, 0.0]]))[:, 5].tolist()
    [-2.0, 0.0, 0.0]
    """
    x = np.asarray(points, dtype=float) - (0.0 if centre is None else np.asarray(centre, dtype=float))
    modes = np.zeros((len(x), 3, 6))
    modes[:, :, :3] = np.eye(3)
    for k, axis in enumerate(np.eye(3)):
        modes[:, :, 3 + k] = np.cross(axis, x)
    return modes.reshape(-1, 6)


def rigid_motion_transfer_along_z(distance: float) -> Array:
    """Return the matrix that gives the motion of one point on the z axis from that of another, for a small rigid motion.

    Parameters
    ----------
    distance : float
        Position z of the first point less that of the second [m].

    Returns
    -------
    (6, 6) Array
        Translation and rotation of the first point from those of the second.

    Examples
    --------
    >>> (rigid_motion_transfer_along_z(0.5) @ np.array([0.0, 0.0, 0.0, 0.0, 1e-3, 0.0])).tolist()
    [0.0005, 0.0, 0.0, 0.0, 0.001, 0.0]
    """
    t = np.eye(6)
    t[0, 4], t[1, 3] = distance, -distance
    return t
