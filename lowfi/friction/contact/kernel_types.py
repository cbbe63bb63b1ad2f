"""Arguments and results of the kernels of contacts, as named tuples: the plain and the compiled copy share them."""

from typing import Any, NamedTuple

from numpy.typing import NDArray

#: Array of floats (masks are passed the same way).
Array = NDArray[Any]


class DissipationTerms(NamedTuple):
    """Dissipation D of one contact per friction bound mu F [m/s], and its derivatives.

    By the sliding velocity (vx, vz) [m/s], the spin [rad/s] and the regularising speed [m/s].
    """

    #: D [m/s].
    value: float
    #: dD/dvx.
    by_vx: float
    #: dD/dvz.
    by_vz: float
    #: dD/dspin [m].
    by_spin: float
    #: dD/dspeed.
    by_speed: float
    #: Second derivative by vx and vx [s/m].
    xx: float
    #: Second derivative by vx and vz [s/m].
    xz: float
    #: Second derivative by vz and vz [s/m].
    zz: float
    #: Second derivative by vx and spin [s].
    x_spin: float
    #: Second derivative by vz and spin [s].
    z_spin: float
    #: Second derivative by spin and spin [m s].
    spin_spin: float


class CellArrays(NamedTuple):
    """N balls pressed between the grooves of two rigid bodies: the inner one moves by u (m,), the outer one is fixed.

    In the plane of each ball's section, axes x and z; contacts 0 and 1 are on the inner body, 2 and 3 on the outer one.
    """

    #: Start from the grooves' centres to the ball (N, 4, 2) along x, z [m], at which the contacts' interference is given.
    start: Array
    #: Interference (N, 4) [m] along ``start``.
    interference: Array
    #: Hertz constants (4,) [m/N^(2/3)].
    C: Array
    #: Displacement of the inner body (N, 2, m) along x, z by u.
    section: Array
    #: Further displacement of the inner body (N, 2) [m].
    offset: Array
    #: Given forces on the balls (N, 2) [N].
    push: Array
    #: Forces (m,) on the inner body along its motions [N].
    pull: Array
    #: Distance of a groove's centre from the ball [m], to limit steps.
    reach: float


class CellState(NamedTuple):
    """What the energy of a cell gives at positions of balls and inner body."""

    #: Gradient by the balls (N, 2) [N].
    ball: Array
    #: Gradient by the inner body (m,) [N].
    inner: Array
    #: Stiffness of the contacts (N, 4, 3) as xx, xz, zz [N/m].
    stiffness: Array
    #: Contact forces (N, 4) [N].
    force: Array
    #: Normals (N, 4, 2) along x, z.
    normal: Array
