"""Arguments and results of the kernels for contacts, as named tuples that their plain and compiled copies share."""

from typing import Any, NamedTuple

from numpy.typing import NDArray

#: Array of floats (masks are passed the same way).
Array = NDArray[Any]


class DissipationTerms(NamedTuple):
    """Power dissipated by friction in one contact, divided by its friction bound mu F, and the derivatives of this ratio.

    The ratio D has the unit of a speed [m/s]. D is differentiated by the sliding velocity (vx, vz) [m/s], by the spin
    [rad/s] and by the regularising speed of Coulomb friction [m/s].
    """

    #: Power dissipated in the contact, divided by its friction bound mu F: the ratio D [m/s].
    value: float
    #: First derivative of D, the dissipated power over mu F, by the sliding velocity vx, without unit.
    by_vx: float
    #: First derivative of D, the dissipated power over mu F, by the sliding velocity vz, without unit.
    by_vz: float
    #: First derivative of D, the dissipated power over mu F, by the spin [m].
    by_spin: float
    #: First derivative of D, the dissipated power over mu F, by the regularising speed, without unit.
    by_speed: float
    #: Second derivative of D, the dissipated power over mu F, by the sliding velocity vx, twice [s/m].
    xx: float
    #: Second derivative of D, the dissipated power over mu F, by the sliding velocities vx and vz [s/m].
    xz: float
    #: Second derivative of D, the dissipated power over mu F, by the sliding velocity vz, twice [s/m].
    zz: float
    #: Second derivative of D, the dissipated power over mu F, by vx and the spin [s].
    x_spin: float
    #: Second derivative of D, the dissipated power over mu F, by vz and the spin [s].
    z_spin: float
    #: Second derivative of D, the dissipated power over mu F, by the spin, twice [m s].
    spin_spin: float


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
    groove_ball_centre_distance: float


class BallContactState(NamedTuple):
    """Contact forces and unbalanced forces of N balls and the inner body at given displacements, written by the kernels.

    An unbalanced force is the derivative of the elastic energy less the work of the applied forces by a displacement.
    """

    #: Unbalanced forces on the balls along x, z (N, 2) [N]: derivatives, by the positions of the balls, of the elastic
    #: energy less the work of the applied forces.
    ball_unbalanced_forces: Array
    #: Unbalanced forces on the inner body along its motions u (m,) [N]: derivatives, by these motions, of the elastic
    #: energy less the work of the applied forces.
    inner_unbalanced_forces: Array
    #: Stiffness of the contacts against displacements of the ball, entries xx, xz, zz of a symmetric matrix (N, 4, 3)
    #: [N/m].
    stiffness: Array
    #: Contact forces (N, 4) [N].
    force: Array
    #: Contact normals along x, z (N, 4, 2).
    normal: Array
