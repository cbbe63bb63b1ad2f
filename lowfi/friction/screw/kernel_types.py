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

    #: Three matrices A_0, A_1, A_2 (3, 3, 4). The matrix A_0 + n_x A_1 + n_z A_2 converts the motion x of a ball to sliding
    #: vx, vz [m/s] and spin [rad/s] at a contact with the normal (n_x, n_z).
    contact_map_coefficients: Array
    #: Angular speed about the axis of the body (screw or nut) on which each of a ball's contacts lies (4,), in the unit of
    #: the ball's orbital speed x[0].
    body_rotation: Array
    #: Hertz constants (4,) of the semi-axes of the contacts across the groove, a = C_a F^(1/3) [m/N^(1/3)].
    C_a: Array
    #: Hertz constants (4,) of the semi-axes of the contacts along the groove, b = C_b F^(1/3) [m/N^(1/3)].
    C_b: Array
    #: Orbit and three spins (4,) of a ball that rolls at the nominal contact angle, as surface speeds divided by ``speed``.
    nominal: Array
    #: Velocity of the first ball's surface at its contact with the second ball, along two tangents, per unit of the first
    #: ball's motion x (2, 4).
    first_ball_surface_speeds: Array
    #: Velocity of the second ball's surface at its contact with the first ball, along the same tangents, per unit of the
    #: second ball's motion x (2, 4).
    second_ball_surface_speeds: Array
    #: Speed at which a ball approaches the next one, per unit of difference of their orbital speeds x[0]; all speeds are
    #: divided by ``speed``.
    closing_rate_factor: float
    #: Speed of the nut along the path relative to the screw [m/s].
    speed: float


class BallArrays(NamedTuple):
    """Frictional contacts of N balls with the grooves and with each other, under known contact loads.

    All friction forces are in one unit of force, which is the largest friction bound mu F of a ball.
    """

    #: Forces (N, 4) at the contacts with the grooves [N].
    force: Array
    #: Contact normals along x3, z3 (N, 4, 2).
    normal: Array
    #: Stiffness (N,) of weak springs that draw the motion of each ball to the nominal motion.
    holding_stiffness: Array
    #: Largest speed at which ball k may approach ball k + 1, divided by the speed of the nut along the path (N,).
    allowed_closing_rate: Array
    #: 1 where ball k can touch ball k + 1, else 0 (N,).
    can_touch_next: Array
    #: Coefficient of friction (N,) between ball k and ball k + 1.
    mu: Array
    #: Coefficient of friction of the grooves divided by the unit of force [1/N].
    scaled_groove_mu: float
    #: Semi-axes a, b [m] and friction bound mu F (in the unit of force) of the contacts with the grooves (N, 4, 3).
    semi_axes_and_bound: Array
    #: Matrices (N, 4, 3, 4) that convert the motion x of a ball to its part of the sliding vx, vz and spin at the contacts,
    #: divided by the speed of the nut along the path; the other part is ``imposed_contact_motions``.
    contact_motion_maps: Array
    #: Sliding vx, vz and spin (N, 4, 3) that screw and nut cause at the contacts of a resting ball (x = 0), divided by the
    #: speed of the nut along the path.
    imposed_contact_motions: Array


class BalanceResiduals(NamedTuple):
    """Unbalanced forces on N balls, residuals of the contact conditions between neighbours, and their derivatives."""

    #: Unbalanced generalised forces on the balls, one for each component of the motion x, in the unit of force (N, 4).
    unbalanced_forces: Array
    #: Fischer-Burmeister function f + g - sqrt(f^2 + g^2) of ball-to-ball force f and remaining closing rate g
    #: (`remaining_closing_rate`) of each gap (N,).
    complementarity: Array
    #: Derivatives of ``complementarity`` by the ball-to-ball force f and by the remaining closing rate g (N, 2).
    complementarity_slopes: Array
    #: Second derivatives, by the motion x, of the power dissipated between each ball and the grooves (N, 4, 4).
    dissipation_hessian: Array


class LoadsAndMotionSystem(NamedTuple):
    """Data of the one system of equations that determines contact loads and motions of the balls together.

    There are N balls; the screw is free in m motions u.
    """

    #: Geometry, stiffness and loads of the balls between screw and nut.
    cell: BallContactArrays
    #: Geometry of the grooves for the motion of a ball.
    groove: GrooveArrays
    #: Frictional contacts of the balls at the present contact loads.
    balls: BallArrays
    #: Unit of force in these equations [N]: the largest friction bound of a ball.
    force_unit: float
    #: Unit of positions in these equations [m]: approach at a contact under the sum of all contact loads.
    position_unit: float
    #: Direction, along x3 and z3, of the contact force on the first, then on the second of two touching balls (2, 2).
    ball_force_directions: Array
    #: Directions of the two tangents of the contact of two balls, along x3 and z3 of the first, then of the second ball (2,
    #: 2, 2).
    tangent_directions: Array
    #: Displacement of the screw along x3, y3, z3 at each ball per unit of each motion u (N, 3, m).
    screw_displacement_maps: Array


class LoadsAndMotionUnknowns(NamedTuple):
    """Unknowns of N balls and the screw if contact loads and ball motion are solved as one system of equations."""

    #: Displacements of the balls along x3, z3 (N, 2) [m].
    ball: Array
    #: Displacement of the screw in each motion u in which it is free (m,) [m].
    screw: Array
    #: Motions x (N, 4) of the balls: orbit and three spins as surface speeds, divided by the speed of the nut along the
    #: path.
    motion: Array
    #: Force (N,) of ball k on ball k + 1, in the unit of force.
    ball_force: Array


class LoadsAndMotionMatrix(NamedTuple):
    """Residual and Jacobian of the one system of equations for contact loads and motion: a banded matrix with a border.

    Each of the N balls has seven unknowns, and the screw has m.
    """

    #: Residual of the equations of the balls (7 N,).
    ball_residual: Array
    #: Residual of the equations of the screw (m,).
    screw_residual: Array
    #: Derivatives of the balls' equations by the balls' unknowns, stored as a band (7 N, 3 times the half bandwidth + 1).
    ball_band: Array
    #: Derivatives of the balls' equations by the displacements u of the screw (7 N, m).
    ball_by_screw_derivatives: Array
    #: Derivatives of the screw's equations by the balls' unknowns (m, 7 N).
    screw_by_ball_derivatives: Array
    #: Derivatives of the screw's equations by its displacements u (m, m).
    screw_by_screw_derivatives: Array
