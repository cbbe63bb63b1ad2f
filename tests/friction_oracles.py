"""Oracles of the friction tests: one ball of a screw coupled to its loads, and Lin (3.32)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ellipe

from rollbench.lowfi.friction.contact.dissipation import dissipation_ratio
from rollbench.lowfi.friction.contact.laws import EllipticalContacts
from rollbench.lowfi.friction.screw import motion
from rollbench.lowfi.friction.screw.coupled import CoupledChainSolution, search_coupled_chain
from rollbench.lowfi.friction.screw.groove import ScrewGroove
from rollbench.lowfi.together import solve_alone
from rollbench.meshes.arrays import Array


def pure_spin_moment(at: EllipticalContacts) -> Array:
    """Moment (n,) [N m] that resists spin about the centre, (3/8) mu F a E(e) (Lin 3.32)."""
    return np.asarray(0.375 * at.friction_bound * at.a * ellipe(1.0 - (at.b / at.a) ** 2))


def ball_cell(
    groove: ScrewGroove, deviation: Array, oversize: float, free: str, force: Array
) -> motion.BallsBetweenGrooves:
    """One ball at azimuth 0: deviations (4,) of its groove angles [rad], oversize of its radius [m], free, force (m,)."""
    angle = np.asarray(groove.contact_angle + deviation, dtype=float)[None, :]
    rows, pull = motion.screw_displacement_maps(groove, np.zeros(1), free), np.asarray(force, dtype=float)
    return motion.balls_without_friction(groove, angle, np.full((1, 4), float(oversize)), rows, pull)


class ContactDissipation(NamedTuple):
    """Power that friction dissipates in each of n contacts, with its first and second derivatives by the sliding motion.

    Friction force and moment on the moving body are the negative gradient of this power.
    """

    #: Dissipated power, a convex function of the motion ``(n,)`` [W].
    power: Array
    #: Derivatives of the dissipated power by vx, vz [N] and spin [N m] ``(n, 3)``.
    gradient: Array
    #: Second derivatives of the dissipated power by vx, vz and spin ``(n, 3, 3)`` [N s/m, N s, N m s].
    hessian: Array
    #: Dissipated power less the friction loss ``(n,)`` [W]; zero without a regularising speed.
    excess_over_loss: Array


def motion_of_rotation_about_point(spin: ArrayLike, c: ArrayLike, d: ArrayLike) -> Array:
    """Return the sliding and spin of a contact whose motion is a rotation about a point of the contact plane.

    The result ``(n, 3)`` has vx, vz [m/s] and spin [rad/s] for n contacts, by eq. (3.12) of Lin's thesis. ``spin``:
    angular speed about the contact normal [rad/s]; ``c``, ``d``: coordinates of the point along x and z of the contact
    plane [m].
    """
    s, x, z = np.broadcast_arrays(*(np.atleast_1d(np.asarray(v, dtype=float)) for v in (spin, c, d)))
    return np.stack([-s * z, s * x, s], axis=1)


def dissipated_power(contacts: EllipticalContacts, motion: Array, regularising_speed: float = 0.0) -> ContactDissipation:
    """Return the power that friction dissipates in each of n contacts, with its derivatives, in closed form.

    The power is mu int p sqrt(|v|^2 + speed^2) dA, with the local sliding velocity v, the Hertz pressure p, the coefficient
    of friction mu and the regularising speed.

    Parameters
    ----------
    contacts
        Ellipses, loads and coefficients of friction of n contacts.
    motion
        Sliding vx, vz of the contacts along the semi-axes a, b [m/s] and their spin [rad/s] ``(n, 3)``. A contact at
        rest without regularisation has no gradient; zeros are returned.
    regularising_speed
        Regularising speed >= 0 [m/s], which raises the power by at most mu F times this speed, with the normal force F.

    Examples
    --------
    >>> d = dissipated_power(contacts_from_values(1e-3, 1e-3, 10.0, 0.1), motion_of_rotation_about_point(1.0, 0.0, 0.0))
    >>> round(float(d.power[0]) / 1e-3, 9)  # (3 pi / 16) mu F a spin on a circle
    0.589048623
    """
    ratio, bound = dissipation_ratio(contacts.a, contacts.b, motion, regularising_speed), contacts.friction_bound
    return ContactDissipation(
        power=bound * ratio.value,
        gradient=bound[:, None] * ratio.gradient,
        hessian=bound[:, None, None] * ratio.hessian,
        excess_over_loss=bound * regularising_speed * ratio.by_speed,
    )


def coupled_ball(cell: motion.BallsBetweenGrooves, coupling: motion.Coupling = "ball and screw") -> CoupledChainSolution:
    """Loads and motion of the one ball of a cell in agreement, which touches no other."""
    return solve_alone(search_coupled_chain(cell, np.full(1, np.inf), coupling))
