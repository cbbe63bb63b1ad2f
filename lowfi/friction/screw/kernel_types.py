"""Arguments of the kernels of ball screws with friction, as named tuples: the plain and the compiled copy share them.

N balls, m free motions of the screw. Contacts 0 and 1 of a ball are on the screw, 2 and 3 on the nut. x3 points radially,
y3 along the path, z3 along the binormal of a groove's section.
"""

from typing import NamedTuple

from rollbench.lowfi.friction.contact.kernel_types import Array, CellArrays


class GrooveArrays(NamedTuple):
    """Geometry of the grooves of screw and nut for the motion of a ball."""

    #: Maps (3, 3, 4) of (vx, vz, spin) by x: constant, by n_x, by n_z.
    affine: Array
    #: Orbital motion (4,) of the body that a contact is on.
    ride: Array
    #: Hertz constants (4,) of the semi-axes across the groove, a = C_a F^(1/3) [m/N^(1/3)].
    C_a: Array
    #: Hertz constants (4,) of the semi-axes along the groove [m/N^(1/3)].
    C_b: Array
    #: Motion (4,) of a ball that rolls along at the nominal speed.
    nominal: Array
    #: Sliding (2, 4) at the contact of two balls by the motion of the first.
    first: Array
    #: Minus the sliding (2, 4) by the motion of the second.
    second: Array
    #: Rate at which a gap closes by x[0] of the first ball.
    closing: float
    #: Speed of the nut along the path relative to the screw [m/s].
    speed: float


class BallArrays(NamedTuple):
    """Contacts of balls of known loads; forces of friction in one unit of force."""

    #: Contact forces (N, 4) [N].
    force: Array
    #: Normals (N, 4, 2) along x3, z3.
    normal: Array
    #: Springs (N,) to the nominal motion.
    hold: Array
    #: Rate (N,) at which ball k may gain on ball k + 1, as a fraction of ``speed``.
    slack: Array
    #: 1 where ball k can touch ball k + 1, else 0 (N,).
    allowed: Array
    #: Coefficient of friction (N,) from ball k to ball k + 1.
    mu: Array
    #: Coefficient of friction of the grooves over the unit of force [1/N].
    strength: float
    #: Semi-axes [m] and mu F in the unit of force, (N, 4, 3).
    shape: Array
    #: Motion (vx, vz, spin) of the contacts as fractions of ``speed``, maps @ x + drives: (N, 4, 3, 4).
    maps: Array
    #: Contact motions without motion of the ball (N, 4, 3).
    drives: Array


class BalanceParts(NamedTuple):
    """Residual of the balance of balls in motion and its derivatives."""

    #: Generalised forces out of balance (N, 4).
    balance: Array
    #: Fischer-Burmeister function of ball-to-ball force and gap (N,).
    complementarity: Array
    #: Derivatives of this function by force and gap (N, 2).
    slopes: Array
    #: Hessian (N, 4, 4) of the grooves' dissipation.
    hessian: Array


class JointSystem(NamedTuple):
    """Loads and motion as one system of equations."""

    #: Balls between the bodies.
    cell: CellArrays
    #: Grooves.
    groove: GrooveArrays
    #: Contacts of the balls in motion.
    balls: BallArrays
    #: Unit of force [N].
    unit: float
    #: Unit of positions [m].
    length: float
    #: Directions of the force (2, 2) on either ball of a pair along x3, z3.
    push: Array
    #: Directions of the two sliding velocities (2, 2, 2) on either ball along x3, z3.
    slide: Array
    #: Displacement of the screw (N, 3, m) along x3, y3, z3 by u.
    rows: Array


class Place(NamedTuple):
    """Unknowns of the joint system."""

    #: Positions of the balls (N, 2) [m].
    ball: Array
    #: Position of the screw (m,) [m].
    screw: Array
    #: Motions (N, 4) in surface speeds per ``speed``.
    motion: Array
    #: Force (N,) of ball k on ball k + 1, in the unit of force.
    ball_force: Array


class JointMatrix(NamedTuple):
    """Residual and Jacobian of the joint system, seven unknowns a ball."""

    #: Right-hand side of the balls (7 N,).
    side: Array
    #: Right-hand side of the screw (m,).
    side_screw: Array
    #: Band (7 N, 3 x half bandwidth + 1) of the balls.
    band: Array
    #: Columns (7 N, m) by u.
    columns: Array
    #: Rows (m, 7 N) of the screw.
    lines: Array
    #: Corner of the border (m, m).
    corner: Array
