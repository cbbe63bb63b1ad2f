"""Arguments of the kernels of ball screws with friction, as named tuples: the plain and the compiled copy share them.

There are N balls and m free motions u of the screw. The motion of a ball x (4,) is its orbit and its spins about x3, y3, z3
as surface speeds over the speed of the nut along the path. Contacts 0 and 1 of a ball are on the screw, 2 and 3 on the nut.
x3 points radially, y3 along the path, z3 along the binormal of a groove's section.
"""

from typing import NamedTuple

from rollbench.lowfi.friction.contact.kernel_types import Array, BallContactArrays


class GrooveArrays(NamedTuple):
    """Geometry and kinematics of the grooves of screw and nut, as arrays for the kernels that solve the motion of balls.

    The motion x (4,) of a ball is its orbit and its three spins, as surface speeds divided by the speed of the nut
    along the path.
    """

    #: Three matrices A_0, A_1, A_2 (3, 3, 4). A_0 + n_x A_1 + n_z A_2 is the map from x to sliding vx, vz [m/s] and spin
    #: [rad/s] at a contact with the normal (n_x, n_z).
    contact_map_coefficients: Array
    #: Rotation about the axis of the body (screw or nut) on which each contact of a ball lies, in the unit of the orbit
    #: x[0] (4,).
    body_rotation: Array
    #: Hertz constants (4,) of the semi-axes across the groove, a = C_a F^(1/3) [m/N^(1/3)].
    C_a: Array
    #: Hertz constants (4,) of the semi-axes along the groove [m/N^(1/3)].
    C_b: Array
    #: Motion (4,) of a ball that rolls at the nominal contact angle.
    nominal: Array
    #: Velocity of the first ball's surface at the contact of two balls, along two tangents, per unit of the first ball's x
    #: (2, 4).
    first_ball_surface_speeds: Array
    #: Velocity of the second ball's surface along the same tangents, per unit of the second ball's x (2, 4).
    second_ball_surface_speeds: Array
    #: Rate at which the gap to the next ball closes, per unit of the orbit x[0] of the first ball.
    closing_rate_factor: float
    #: Speed of the nut along the path relative to the screw [m/s].
    speed: float


class BallArrays(NamedTuple):
    """Frictional contacts of N balls with the grooves and with each other, under known contact loads.

    All friction forces are in one unit of force, which is the largest friction bound mu F of a ball.
    """

    #: Contact forces (N, 4) [N].
    force: Array
    #: Contact normals along x3, z3 (N, 4, 2).
    normal: Array
    #: Stiffness (N,) of weak springs that draw the balls to the nominal motion.
    holding_stiffness: Array
    #: Largest rate at which ball k may approach ball k + 1, over ``speed`` (N,).
    allowed_closing_rate: Array
    #: 1 where ball k can touch ball k + 1, else 0 (N,).
    can_touch_next: Array
    #: Coefficient of friction (N,) from ball k to ball k + 1.
    mu: Array
    #: Coefficient of friction of the grooves divided by the unit of force [1/N].
    scaled_groove_mu: float
    #: Semi-axes a, b [m] and friction bound mu F (in the unit of force) of the contacts (N, 4, 3).
    semi_axes_and_bound: Array
    #: Matrices of the motion (vx, vz, spin) of the contacts over ``speed`` per unit of x (N, 4, 3, 4); the motion is this
    #: matrix times x plus ``imposed_contact_motions``.
    contact_motion_maps: Array
    #: Motion of the contacts over ``speed`` at x = 0, caused by screw and nut (N, 4, 3).
    imposed_contact_motions: Array


class BalanceResiduals(NamedTuple):
    """Unbalanced forces on N balls, residuals of the contact conditions between neighbours, and derivatives of both."""

    #: Generalised forces out of balance along x, in the unit of force (N, 4).
    unbalanced_forces: Array
    #: Fischer-Burmeister function f + g - sqrt(f^2 + g^2) of ball-to-ball force f and remaining closing rate g
    #: (`remaining_closing_rate`) of each gap (N,).
    complementarity: Array
    #: Derivatives of this function by the force f and by the rate g (N, 2).
    complementarity_slopes: Array
    #: Second derivatives of the dissipation in the grooves by x (N, 4, 4).
    dissipation_hessian: Array


class LoadsAndMotionSystem(NamedTuple):
    """Data of the system of equations for contact loads and ball motion together.

    There are N balls; the screw is free in m motions u.
    """

    #: Geometry, stiffness and loads of the balls between screw and nut.
    cell: BallContactArrays
    #: Geometry of the grooves for the motion of a ball.
    groove: GrooveArrays
    #: Frictional contacts of the balls at the present contact loads.
    balls: BallArrays
    #: Unit of force [N].
    force_unit: float
    #: Unit of positions [m].
    position_unit: float
    #: Direction of the contact force on the first and the second ball of a pair along x3, z3 (2, 2).
    ball_force_directions: Array
    #: Directions of the two tangents of the contact of a pair in the axes x3, z3 of the first and the second ball (2, 2,
    #: 2).
    tangent_directions: Array
    #: Displacement of the screw along x3, y3, z3 at each ball per unit of each motion u (N, 3, m).
    screw_displacement_maps: Array


class LoadsAndMotionUnknowns(NamedTuple):
    """Unknowns of N balls and the screw if contact loads and ball motion are solved as one system of equations."""

    #: Displacements of the balls along x3, z3 (N, 2) [m].
    ball: Array
    #: Displacement of the screw in its motions u (m,) [m].
    screw: Array
    #: Motions x (N, 4) of the balls, surface speeds over ``speed``.
    motion: Array
    #: Force (N,) of ball k on ball k + 1, in the unit of force.
    ball_force: Array


class LoadsAndMotionMatrix(NamedTuple):
    """Residual and Jacobian of the one system of equations for contact loads and motion: a banded matrix with a border.

    Each of the N balls has seven unknowns, and the screw has m.
    """

    #: Residual of the balls' equations (7 N,).
    ball_residual: Array
    #: Residual of the equations of the screw (m,).
    screw_residual: Array
    #: Derivatives of the balls' equations by the balls' unknowns, as a band (7 N, 3 times the half bandwidth + 1).
    ball_band: Array
    #: Derivatives of the balls' equations by u (7 N, m).
    ball_by_screw_derivatives: Array
    #: Derivatives of the screw's equations by the balls' unknowns (m, 7 N).
    screw_by_ball_derivatives: Array
    #: Derivatives of the screw's equations by u (m, m).
    screw_by_screw_derivatives: Array
