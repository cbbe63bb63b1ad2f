"""Arguments of the kernels of linear bearings, as named tuples: the plain and the compiled copy share them.

There are N balls in a chain with C contacts each. Velocities are divided by the carriage's speed, forces by the largest
friction bound of a ball. The unknowns of a ball are its motion x = (v, R omega_x, R omega_y), with the ball radius R,
and one for its contact with the next ball (z of ``ChainSearchState``).
"""

from typing import Any, NamedTuple

from numpy.typing import NDArray

#: Array of floats (masks are passed the same way).
Array = NDArray[Any]


class ChainArrays(NamedTuple):
    """Contacts, friction and neighbours of N balls of one row in a linear bearing, with C contacts each."""

    #: Five values for each contact (N, C, 5): direction n_x, n_y from the ball's centre; speed of the body in contact, 0
    #: for the rail, 1 or -1 (the sign of its speed) for the carriage; friction bound; semi-axis a divided by the ball
    #: radius.
    contacts: Array
    #: Constants (b/a, q0, k1, k3) of the formulas for the friction of a contact (4,), see `contact_friction_constants`.
    friction_constants: Array
    #: 1 where balls k and k + 1 are near enough to touch, else 0 (N - 1,).
    can_touch_next: Array
    #: Coefficient of friction between two balls.
    mu: float
    #: Stiffness of weak springs that draw the motion of each ball to the nominal motion (N,).
    holding_stiffness: Array
    #: Motion (N, 3) of balls that roll at the nominal contact angle: velocity, and ball radius times two spins, divided by
    #: the carriage's speed.
    nominal_motion: Array


class ChainSearchState(NamedTuple):
    """Motion of N balls in a linear bearing during a search, sliding at their contacts, and forces between neighbours.

    All values are changed by increments, so that no accuracy is lost where contacts stick.
    """

    #: For each contact with the grooves: sliding speed along the track, and semi-axis a times spin (N, C, 2).
    groove_contact_slips: Array
    #: For balls k and k + 1: speed at which they approach each other, and two components of their sliding on each other (N
    #: - 1, 3).
    ball_to_ball_slips: Array
    #: Motion of the balls (velocity, and ball radius times two spins, divided by the carriage's speed) less the nominal
    #: motion (N, 3).
    motion_less_nominal: Array
    #: Unknown z of each ball-to-ball contact (N - 1,): where z > 0, the contact force; where z < 0, the rate at which the
    #: gap opens, with a minus sign.
    ball_to_ball_unknowns: Array


class EquationSmoothing(NamedTuple):
    """Parameters by which the equations are smoothed: Coulomb friction, and the contact condition of neighbours."""

    #: Regularising speed of friction: at sliding speeds far below it, friction is proportional to the sliding speed instead
    #: of equal to the friction bound.
    regularising_speed: float
    #: Fraction of the friction between balls that acts, 0 to 1.
    ball_friction_fraction: float
    #: Product of the force between two neighbouring balls and the opening rate of their gap; zero for exact
    #: complementarity.
    force_rate_product: float
    #: Stiffness of springs that draw the balls to nominal rolling, to which ``holding_stiffness`` of `ChainArrays` is
    #: added.
    spring_stiffness: float


class NewtonArrays(NamedTuple):
    """Work arrays for Newton's method on a row of N balls with four unknowns each."""

    #: Jacobian of the equations, stored as a band (4 N, 11).
    jacobian_band: Array
    #: Factors of the Jacobian, with additional columns for exchanged rows (4 N, 16).
    factors: Array
    #: Residual of the equations (4 N,).
    residual: Array
    #: Newton step of the unknowns (4 N,).
    step: Array
    #: Second right-hand side of the linear system with the Jacobian, which is solved together with the Newton step (4 N,).
    second_right_hand_side: Array
