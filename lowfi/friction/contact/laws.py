"""Friction laws of sliding and spinning contacts: Coulomb, regularised Coulomb, and Lin's sigmoid.

Coulomb friction of elliptical Hertz contacts that slide and spin has a closed form. Each contact has its own axes: x along
the semi-axis a, z along b, and y the normal into the moving body. The motion of this body relative to the other one is (vx,
vz, spin), so that its points slide with (vx + spin z, vz - spin x). The friction computed is that on the moving body.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rollbench.lowfi.friction.contact.dissipation import dissipation_ratio
from rollbench.lowfi.hertz import complete_elliptic_integrals
from rollbench.meshes.arrays import Array, Index


@dataclass(frozen=True)
class EllipticalContacts:
    """Semi-axes, normal forces and coefficients of friction of n elliptical contacts, arrays ``(n,)``."""

    #: Larger semi-axes a of the contact ellipses, a >= b [m].
    a: Array
    #: Smaller semi-axes b of the contact ellipses, b > 0 [m].
    b: Array
    #: Normal forces F >= 0 [N].
    load: Array
    #: Coefficients of friction of the contacts.
    mu: Array

    @property
    def friction_bound(self) -> Array:
        """Friction bound mu F (coefficient of friction times normal force) of each contact ``(n,)`` [N]."""
        return np.asarray(self.mu * self.load)

    def take(self, contacts: Index) -> EllipticalContacts:
        """Return some of the contacts, given by their numbers."""
        return EllipticalContacts(self.a[contacts], self.b[contacts], self.load[contacts], self.mu[contacts])


@dataclass(frozen=True)
class ContactFriction:
    """Friction force, friction moment and friction loss at n contacts, acting on the moving body."""

    #: Friction force on the moving body along x and z ``(n, 2)`` [N].
    force: Array
    #: Friction moment on the moving body about the contact normal through the ellipse's centre ``(n,)`` [N m].
    moment: Array
    #: Friction loss ``(n,)`` [W].
    loss: Array


def contacts_from_values(a: ArrayLike, b: ArrayLike, load: ArrayLike, mu: ArrayLike) -> EllipticalContacts:
    """Return the data of n contacts from numbers or arrays that broadcast to ``(n,)``, after checking them.

    Values out of range are refused. The relative error of friction that is computed with these contacts is 1e-10 for
    b/a >= 0.01 (against quadrature), 1e-8 at b/a = 1e-3, and 1e-7 at b/a = 1e-4.

    Parameters
    ----------
    a, b
        Semi-axes a >= b > 0 [m].
    load
        Normal force F >= 0 [N].
    mu
        Coefficient of friction >= 0.

    Raises
    ------
    ValueError
        A value is out of range or not finite.
    """
    arrays = np.broadcast_arrays(*(np.atleast_1d(np.asarray(v, dtype=float)) for v in (a, b, load, mu)))
    full = EllipticalContacts(*(np.array(v) for v in arrays))
    if not all(np.all(np.isfinite(v)) for v in arrays):
        raise ValueError("semi-axes, normal forces and coefficients of friction of contacts must be finite")
    if np.any(full.b <= 0.0) or np.any(full.a < full.b):
        raise ValueError("the semi-axes of every contact ellipse must satisfy a >= b > 0")
    if np.any(full.load < 0.0) or np.any(full.mu < 0.0):
        raise ValueError("no normal force and no coefficient of friction of a contact may be negative")
    return full


def friction_forces(contacts: EllipticalContacts, motion: Array, regularising_speed: float = 0.0) -> ContactFriction:
    """Return friction force, moment and loss of contacts for a given sliding motion.

    ``contacts``: ellipses, loads and coefficients of friction of n contacts; ``motion``: their sliding vx, vz along the
    semi-axes a, b [m/s] and spin [rad/s] ``(n, 3)``; ``regularising_speed``: regularising speed >= 0 [m/s], 0 for exact
    Coulomb friction.

    References
    ----------
    Lin (2019), equations 3.16 to 3.18; the centre of rotation may lie anywhere on the z axis. Lin's moment M_iO is about
    -y, so that its sign is opposite to that of the moment here.

    Examples
    --------
    The friction force of pure sliding is mu F, coefficient of friction times normal force:

    >>> sliding = friction_forces(contacts_from_values(1e-3, 0.5e-3, 10.0, 0.1), np.array([[0.0, 2.0, 0.0]]))
    >>> round(float(sliding.force[0, 1]), 9), round(float(sliding.loss[0]), 9)
    (-1.0, 2.0)
    """
    ratio, bound = dissipation_ratio(contacts.a, contacts.b, motion, regularising_speed), contacts.friction_bound
    pull, excess = bound[:, None] * ratio.gradient, bound * regularising_speed * ratio.by_speed
    return ContactFriction(force=-pull[:, :2], moment=-pull[:, 2], loss=bound * ratio.value - excess)


def linear_friction_force_factor(axis_ratio: ArrayLike) -> Array:
    """Return the slope k_f of friction force over c/a for an elliptical contact that rotates about a point near its centre.

    The force is divided by mu F, coefficient of friction times normal force. c is the distance of the centre of
    rotation from the centre of the contact ellipse along its semi-axis a. The slope is k_f = (b/a)^2 R_D(0, 1,
    b^2/a^2)/2 with Carlson's elliptic integral R_D; it is 3 pi/8 = 1.178 for a circle and 3/2 in the limit of a line.

    Parameters
    ----------
    axis_ratio
        Ratio b/a of the semi-axes, in (0, 1].

    References
    ----------
    Lin (2019), 3.35, here without approximation.

    Examples
    --------
    >>> round(float(linear_friction_force_factor(1.0)), 6)
    1.178097
    """
    k = np.asarray(axis_ratio, dtype=float)
    return np.asarray(0.5 * k * k * complete_elliptic_integrals(k)[2])


def cubic_friction_force_factor(axis_ratio: ArrayLike) -> Array:
    """Return the factor g of the cubic term in the friction force of a rotating contact, force/(mu F) = k_f t - g t^3.

    mu F is the coefficient of friction times the normal force; t = c/a, and c is the distance of the centre of rotation
    from the centre of the contact ellipse along its semi-axis a. The formula is exact for -1 <= t <= 1; k_f is
    `linear_friction_force_factor`. The factor is g = (b/a)^2 (R_D(0, 1, r^2) - R_D(0, r^2, 1))/(6 (1 - r^2)), with r =
    b/a <= 1 - 1e-6 and Carlson's elliptic integral R_D.

    Parameters
    ----------
    axis_ratio
        Ratio b/a of the semi-axes, any shape.
    """
    k = np.asarray(axis_ratio, dtype=float)
    _, along, across = complete_elliptic_integrals(k)
    return np.asarray(k * k * (across - along) / (6.0 * (1.0 - k * k)))


def error_of_linear_friction_force(axis_ratio: ArrayLike, force_slope: ArrayLike) -> Array:
    """Return the largest relative error of a friction force that is assumed to be linear in c/a, for 0 < |c/a| <= 1/2.

    c is the distance of the centre of rotation from the centre of the contact ellipse along its semi-axis a. The ratio
    of the exact force to t = c/a is k_f - g t^2 (`linear_friction_force_factor`, `cubic_friction_force_factor`). This
    ratio is monotonous in t, so the error is largest at an end of the range.

    Parameters
    ----------
    axis_ratio
        Ratio b/a of the semi-axes, in (0, 1].
    force_slope
        Slope of the linear law: friction force divided by mu F (coefficient of friction times normal force), per c/a;
        Lin uses 1.38.

    References
    ----------
    Lin (2019), 3.35 and appendix G.
    """
    start = linear_friction_force_factor(axis_ratio)
    end = start - cubic_friction_force_factor(axis_ratio) * 0.5**2
    slope = np.asarray(force_slope)
    return np.asarray(np.maximum(np.abs(slope / start - 1.0), np.abs(slope / end - 1.0)))


#: Friction law: the friction on the moving body at each of n contacts, from their ellipses, loads and coefficients of
#: friction, and their motion: sliding vx, vz along the semi-axes a, b [m/s] and spin [rad/s] ``(n, 3)``. Coulomb's law is
#: `friction_forces`.
FrictionLaw = Callable[[EllipticalContacts, Array], ContactFriction]


@dataclass(frozen=True)
class SigmoidLaw:
    """Lin's friction law: Coulomb friction multiplied by a sigmoid of the spin, Sig(k_S spin/reference) (Lin 3.20).

    k_S is the sharpness of the sigmoid function Sig, and reference the reference spin. The law is not the gradient of a
    convex function, and a contact that slides without spin has no friction.
    """

    #: Sharpness k_S of the sigmoid.
    sharpness: float
    #: Reference spin, omega_I sin(beta) for a bearing with the speed omega_I of the inner ring and the contact angle beta
    #: [rad/s].
    reference_spin: float
    #: Step in c/a of Lin's table of friction forces, in which he interpolates linearly; None for exact integrals. c is the
    #: distance of the centre of rotation from the centre of the contact ellipse along its semi-axis a.
    map_spacing: float | None = None

    def __call__(self, at: EllipticalContacts, motion: Array) -> ContactFriction:
        """Return Coulomb friction of n contacts at the given motion, exact or interpolated, times the sigmoid.

        The sigmoid of the spin's magnitude is computed as a hyperbolic tangent, which cannot overflow.
        """
        full = friction_forces(at, motion, 0.0)
        if self.map_spacing is not None:
            full = interpolated_friction(at, motion, self.map_spacing, full)
        s = np.tanh(0.5 * self.sharpness * np.abs(motion[:, 2]) / self.reference_spin)
        return ContactFriction(force=full.force * s[:, None], moment=full.moment * s, loss=full.loss * s)


def interpolated_friction(
    contacts: EllipticalContacts, motion: Array, spacing: float, exact: ContactFriction
) -> ContactFriction:
    """Return Coulomb friction of n contacts, interpolated linearly in c/a as in section 3.2.1 of Lin's thesis.

    c is the distance of the centre of rotation from the centre of the contact ellipse along its semi-axis a. ``motion``:
    sliding vx, vz along the semi-axes a, b [m/s] and spin [rad/s] ``(n, 3)``; ``spacing``: step of c/a in the table;
    ``exact``: friction without interpolation, which is returned for contacts without spin, whose c/a is not defined.
    Raises ValueError if vx is not 0, because the centre of rotation then does
    not lie on the semi-axis a.
    """
    if np.any(motion[:, 0] != 0.0):
        raise ValueError(
            "Lin's tables of friction forces cover only rotations about a point on the major axis of the contact: the "
            f"sliding velocity vx along that axis must be 0, got up to {float(np.max(np.abs(motion[:, 0])))} m/s"
        )
    spin = motion[:, 2]
    place = np.zeros_like(spin)
    turns = np.abs(motion[:, 1]) < 1e12 * np.abs(spin) * contacts.a
    place[turns] = motion[turns, 1] / (spin[turns] * contacts.a[turns]) / spacing
    low = np.floor(place)
    weight = (place - low)[:, None]
    ends = []
    for k in (low, low + 1.0):
        vz = np.where(turns, spin * contacts.a * k * spacing, motion[:, 1])
        f = friction_forces(contacts, np.stack([0.0 * vz, vz, spin], axis=1), 0.0)
        ends.append(np.column_stack([f.force, f.moment, f.loss]))
    mixed = (1.0 - weight) * ends[0] + weight * ends[1]
    mixed = np.where(turns[:, None], mixed, np.column_stack([exact.force, exact.moment, exact.loss]))
    return ContactFriction(force=mixed[:, :2], moment=mixed[:, 2], loss=mixed[:, 3])
