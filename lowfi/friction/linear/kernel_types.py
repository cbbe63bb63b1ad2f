"""Arguments of the kernels of linear bearings, as named tuples: the plain and the compiled copy share them.

N balls of a chain with C contacts each. Velocities are in units of the carriage's speed, forces in units of the largest
friction bound of a ball. Unknowns of a ball: x = (v, R omega_x, R omega_y), and the force towards the next ball.
"""

from typing import Any, NamedTuple

from numpy.typing import NDArray

#: Array of floats (masks are passed the same way).
Array = NDArray[Any]


class ChainArrays(NamedTuple):
    """Contacts and neighbours of the balls."""

    #: Direction (n_x, n_y), speed of the body in contact, friction bound, semi-axis a over the ball's radius; (N, C, 5).
    contacts: Array
    #: Constants (4,) of the contacts' friction, see `lowfi.friction.linear.chain.contact_shape`.
    shape: Array
    #: 1 where neighbours touch, else 0 (N - 1,).
    closed: Array
    #: Coefficient of friction from ball to ball.
    mu: float
    #: Springs (N,) to the nominal motion.
    hold: Array
    #: Nominal motion (N, 3).
    nominal: Array


class ChainPoint(NamedTuple):
    """Linear functions of the unknowns and ball-to-ball contacts.

    Moved by increments, so that nothing cancels where contacts stick.
    """

    #: Sliding and spinning speed of the contacts (N, C, 2).
    slip: Array
    #: Closing speed and sliding (2) of neighbours (N - 1, 3).
    pair: Array
    #: Deviation (N, 3) from the nominal motion.
    drift: Array
    #: Unknowns (N - 1,) of the contacts: force where positive, rate of the gap turned round where negative.
    z: Array


class Smoothing(NamedTuple):
    """How far the equations are from Coulomb's law and exact complementarity."""

    #: Creeping speed.
    eps: float
    #: Fraction of the friction between balls.
    share: float
    #: Force times rate of a gap.
    smooth: float
    #: Stiffness towards nominal rolling besides the balls' own.
    spring: float


class Work(NamedTuple):
    """Work arrays for Newton's method."""

    #: Banded matrix (4 N, 11).
    K: Array
    #: Factors, with columns for exchanged rows (4 N, 16).
    factors: Array
    #: Residual (4 N,).
    g: Array
    #: Newton step (4 N,).
    step: Array
    #: Second right-hand side (4 N,).
    other: Array
