"""Types of the kernels' arguments."""

from typing import Any

from numpy.typing import NDArray

#: Array of floats (masks are passed the same way).
Array = NDArray[Any]
#: Contacts 0 and 1 of a ball are on the screw, 2 and 3 on the nut.
ON_SCREW = 2
#: Grooves: (affine (3, 3, 4), ride (4,), C_a (4,), C_b (4,), nominal (4,), first (2, 4), second (2, 4), closing,
#: speed).
#: A contact's motion is map @ (x - ride e_0), its map affine[0] + n_x affine[1] + n_z affine[2], x the ball's motion as
#: surface speeds per ``speed``; the rest as in ``screw_groove.PairGeometry``, for such x.
Groove = tuple[Array, Array, Array, Array, Array, Array, Array, float, float]
#: Balls: (force (N, 4) [N], normal (N, 4, 2) along x3, z3, hold (N,), slack (N,), allowed (N,), mu (N,), strength,
#: shape (N, 4, 3), maps (N, 4, 3, 4), drives (N, 4, 3)); strength: groove friction coefficient over the unit of force; mu
#: from ball to ball; slack as a fraction of ``speed``; shape: semi-axes [m] and mu F in the unit of force; maps @ x +
#: drives: what a contact sees (vx, vz, spin), as fractions of ``speed``.
Balls = tuple[Array, Array, Array, Array, Array, Array, float, Array, Array, Array]
#: Cell: (start (N, 4, 2), interference (N, 4), C (4,), section (N, 2, m), offset (N, 2), push (N, 2), pull (m,),
#: reach); start: from the grooves' centres to the ball [m]; pull: force and drag along the screw's motions [N].
Cell = tuple[Array, Array, Array, Array, Array, Array, Array, float]
