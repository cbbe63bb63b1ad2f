"""Normal forces of balls between the grooves of two rigid bodies that move against each other, as arrays.

Axes: ball, contact, component along x, z of the ball's groove section; any further axes come first. Contacts 0 and 1 of a
ball are on the inner body, which moves; the outer body is fixed.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from rollbench.meshes.arrays import Array

#: Whether each of a ball's four contacts is on the inner body.
ON_INNER = np.array([True, True, False, False])


class BallContactArrays(NamedTuple):
    """Geometry, contact stiffness and applied forces of N balls between a movable inner and a fixed outer rigid body.

    The inner body (screw, inner ring or carriage) is free in m motions u. The axes x and z lie in the plane of each
    ball's groove section. Contacts 0 and 1 of a ball are on the inner body, 2 and 3 on the outer body.
    """

    #: Vectors from the grooves' centres of curvature to the ball's centre (N, 4, 2) along x, z [m], at zero displacement.
    groove_to_ball_vectors: Array
    #: Interference of ball and groove at each contact at zero displacement, negative for clearance (N, 4) [m].
    interference: Array
    #: Hertz constants C of the approach C F^(2/3) at the four contacts of a ball (4,) [m/N^(2/3)].
    C: Array
    #: Displacement of the inner body along x, z at each ball per unit of each motion u (N, 2, m).
    inner_displacement_maps: Array
    #: Prescribed displacement of the inner body along x, z at each ball, in addition to the displacement by its free
    #: motions u (N, 2) [m].
    given_inner_displacement: Array
    #: Applied forces on the balls along x, z, other than contact loads (N, 2) [N].
    ball_forces: Array
    #: Applied forces on the inner body along its motions u (m,) [N].
    inner_body_forces: Array
    #: Distance of a groove's centre of curvature from the ball's centre [m]; Newton steps are limited to a fraction of it.
    #: A number, or one for each of several groups ``(K,)``.
    groove_ball_centre_distance: Any


class NormalForces(NamedTuple):
    """Hertz forces at the contacts of N balls, and the geometry they depend on."""

    #: Contact forces F ``(..., N, 4)`` [N].
    force: Array
    #: Derivatives of the forces by the approach ``(..., N, 4)`` [N/m].
    stiffness: Array
    #: Unit vectors from the ball's centre to the contacts ``(..., N, 4, 2)``.
    normal: Array
    #: Distances of the centres of ball and groove arc ``(..., N, 4)`` [m].
    distance: Array


def normal_forces(cell: BallContactArrays, ball: Array, inner: Array) -> NormalForces:
    """Return the normal forces after displacements of the balls ``(..., N, 2)`` and of the inner body ``(..., m)`` [m].

    ``cell``: geometry and Hertz constants C of the approach C F^(2/3).
    """
    moved = cell.given_inner_displacement + (cell.inner_displacement_maps @ inner[..., None, :, None])[..., 0]
    start, move = cell.groove_to_ball_vectors, ball[..., None, :] - np.where(ON_INNER[:, None], moved[..., None, :], 0.0)
    apart = start + move
    size, before = (np.sqrt((vector**2).sum(axis=-1)) for vector in (apart, start))
    grown = (move * (start + apart)).sum(axis=-1) / (size + before)  # change of the distance, without cancellation
    d = np.maximum(grown + cell.interference, 0.0) / cell.C
    root = np.sqrt(d)
    return NormalForces(d * root, 1.5 * root / cell.C, apart / size[..., None], size)
