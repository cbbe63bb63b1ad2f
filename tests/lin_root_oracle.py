"""Balls of a linear bearing and their friction law by Lin's method, where only tests use it.

Numbers of equations are those of Lin's thesis (2019).
"""

import numpy as np

from rollbench.lowfi.as_source import balls as lin
from rollbench.lowfi.friction.contact import laws
from rollbench.lowfi.friction.contact.laws import FrictionLaw
from rollbench.lowfi.friction.linear.bearing import LinearBearing
from rollbench.lowfi.friction.linear.chain import prepare_linear_chain
from rollbench.meshes.arrays import Array

#: Unknowns of a ball of a linear bearing in Lin's thesis, among the four of `StraightTrack`: its speed v along the track
#: [m/s] and its angular speeds omega_x and omega_y about the two axes across the track [rad/s].
ACROSS = [0, 3, 1]


def balls_of_linear_bearing(bearing: LinearBearing, angles: Array, loads: Array) -> lin.LoadedBalls:
    """Return N balls of a linear bearing with the kinematics of their contacts, by equations 3.22 to 3.29 of Lin's thesis.

    ``bearing``: the bearing with its speed; ``angles``: contact angles ``(N, 4)`` [rad]; ``loads``: normal loads ``(N, 4)``
    [N], both in the order BL, BR, TR, TL (bottom or top, left or right). Raises ValueError if a load is negative.
    """
    chain = prepare_linear_chain(bearing, angles, loads)
    track, rubs = chain.groove, chain.friction_contacts
    first, second = track.pair.first_ball_surface_speeds[:, ACROSS], track.pair.second_ball_surface_speeds[:, ACROSS]
    units, nominal = track.levers[ACROSS], track.nominal_motion[ACROSS]
    between = lin.BallToBallContact(first, second, track.pair.closing_speed_factor, bearing.mu_balls, units, nominal)
    at = laws.contacts_from_values(rubs.a.ravel(), rubs.b.ravel(), chain.force.ravel(), bearing.mu)
    return lin.LoadedBalls(at, rubs.maps[..., ACROSS], rubs.drives, between)


def linear_bearing_friction_law(bearing: LinearBearing, sharpness: float | None = lin.SHARPNESS) -> FrictionLaw:
    """Return the sigmoid friction law of equation 3.20 of Lin's thesis for a linear bearing, or Coulomb's law.

    ``bearing``: bearing with carriage speed v, contact angle beta and ball radius R_B; ``sharpness``: factor k_S of the
    sigmoid; None: Coulomb's law. The reference spin of the sigmoid is the nominal spin v tan(beta)/(2 R_B). This is an
    assumption: equation 3.25 contains no sigmoid, and the reference for rotary bearings, the difference of the spins of
    both rings, is zero between grooves that do not turn.
    """
    if sharpness is None:
        return laws.friction_forces
    return laws.SigmoidLaw(sharpness, 0.5 * abs(bearing.speed) * float(np.tan(bearing.contact_angle)) / bearing.ball_radius)
