"""Friction laws with one interface: Coulomb, Coulomb regularised, and Lin's sigmoid.

Coulomb friction of elliptical Hertz contacts that slide and spin has a closed form. Each contact has its axes: x along
the semi-axis a, z along b, y the normal into the body whose motion relative to the other is (vx, vz, spin); its points move
with (vx + spin z, vz - spin x). Friction acts on that body.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from rollbench.lowfi.hertz import complete_integrals
from rollbench.lowfi.jit import CONTACT, kernels
from rollbench.meshes.arrays import Array


@dataclass(frozen=True)
class Contacts:
    """Elliptical contacts with friction, arrays ``(n,)``."""

    #: Semi-axes a >= b [m].
    a: Array
    #: Semi-axes b > 0 [m].
    b: Array
    #: Normal forces F >= 0 [N].
    load: Array
    #: Coefficients of friction.
    mu: Array

    @property
    def strength(self) -> Array:
        """Friction bound mu F ``(n,)`` [N]."""
        return np.asarray(self.mu * self.load)


@dataclass(frozen=True)
class Friction:
    """Friction on the moving body at n contacts."""

    #: Force along x and z ``(n, 2)`` [N].
    force: Array
    #: About the normal at the centre ``(n,)`` [N m].
    moment: Array
    #: ``(n,)`` [W].
    loss: Array


@dataclass(frozen=True)
class Dissipation:
    """Convex function of the motion whose negative gradient is the friction, at n contacts."""

    #: ``(n,)`` [W].
    value: Array
    #: Gradient by (vx, vz, spin) ``(n, 3)``.
    gradient: Array
    #: ``(n, 3, 3)``.
    hessian: Array
    #: Value less the loss ``(n,)`` [W], zero without a regularising speed.
    excess: Array


def equal_contacts(a: ArrayLike, b: ArrayLike, load: ArrayLike, mu: ArrayLike) -> Contacts:
    """Return contacts of one shape ``(n,)``, to which the arguments are broadcast.

    Friction is exact to 1e-10 of its size for b/a >= 0.01 (measured against quadrature), to 1e-8 at 1e-3, to 1e-7 at 1e-4.

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
        A number out of range or not finite.
    """
    arrays = np.broadcast_arrays(*(np.atleast_1d(np.asarray(v, dtype=float)) for v in (a, b, load, mu)))
    full = Contacts(*(np.array(v) for v in arrays))
    if not all(np.all(np.isfinite(v)) for v in arrays):
        raise ValueError("contacts need finite semi-axes, forces and friction coefficients")
    if np.any(full.b <= 0.0) or np.any(full.a < full.b):
        raise ValueError("semi-axes must satisfy a >= b > 0")
    if np.any(full.load < 0.0) or np.any(full.mu < 0.0):
        raise ValueError("normal force and friction coefficient must not be negative")
    return full


def about_point(spin: ArrayLike, c: ArrayLike, d: ArrayLike) -> Array:
    """Return motion ``(n, 3)`` of a body that turns with ``spin`` [rad/s] about the point x = c, z = d [m] (Lin 3.12)."""
    s, x, z = np.broadcast_arrays(*(np.atleast_1d(np.asarray(v, dtype=float)) for v in (spin, c, d)))
    return np.stack([-s * z, s * x, s], axis=1)


def dissipated_power(at: Contacts, motion: Array, speed: float = 0.0, fast: bool = False) -> Dissipation:
    """Return mu int p sqrt(|v|^2 + speed^2) dA with first and second derivatives, in closed form.

    Parameters
    ----------
    at
        The contacts.
    motion
        vx, vz [m/s], spin [rad/s], ``(n, 3)``. At rest without regularisation there is no gradient: zeros are returned.
    speed
        Regularising speed >= 0 [m/s]; the value grows by at most mu F speed.
    fast
        Whether to use compiled kernels.

    Examples
    --------
    >>> d = dissipated_power(equal_contacts(1e-3, 1e-3, 10.0, 0.1), about_point(1.0, 0.0, 0.0))
    >>> round(float(d.value[0]) / 1e-3, 9)  # (3 pi / 16) mu F a spin on a circle
    0.589048623
    """
    out = np.empty((at.a.shape[0], 11))
    motion = np.ascontiguousarray(motion, dtype=float)
    kernels(CONTACT, compiled=fast).dissipation_many(at.a, at.b, motion, float(speed), out)
    out *= at.strength[:, None]
    return Dissipation(
        value=out[:, 0],
        gradient=out[:, 1:4],
        hessian=out[:, [5, 6, 8, 6, 7, 9, 8, 9, 10]].reshape(-1, 3, 3),
        excess=speed * out[:, 4],
    )


def friction_forces(at: Contacts, motion: Array, speed: float = 0.0, fast: bool = False) -> Friction:
    """Return the friction of contacts in a given motion; arguments as for `dissipated_power`.

    References
    ----------
    Lin (2019), 3.16 to 3.18, for any d. His M_iO is taken about -y: it is minus this moment.

    Examples
    --------
    Pure sliding has the force mu F:

    >>> sliding = friction_forces(equal_contacts(1e-3, 0.5e-3, 10.0, 0.1), np.array([[0.0, 2.0, 0.0]]))
    >>> round(float(sliding.force[0, 1]), 9), round(float(sliding.loss[0]), 9)
    (-1.0, 2.0)
    """
    d = dissipated_power(at, motion, speed, fast)
    return Friction(force=-d.gradient[:, :2], moment=-d.gradient[:, 2], loss=d.value - d.excess)


def linear_factor(ratio: ArrayLike) -> Array:
    """Return the slope k_f of the normalised friction force against c/a at c = d = 0.

    k_f = (b/a)^2 R_D(0, 1, b^2/a^2)/2, from 3 pi/8 = 1.178 on a circle to 3/2 on a line.

    Parameters
    ----------
    ratio
        b/a in (0, 1].

    References
    ----------
    Lin (2019), 3.35, here exact.

    Examples
    --------
    >>> round(float(linear_factor(1.0)), 6)
    1.178097
    """
    k = np.asarray(ratio, dtype=float)
    return np.asarray(0.5 * k * k * complete_integrals(k)[2])


def cubic_factor(ratio: ArrayLike) -> Array:
    """Return g of the exact normalised force k_f t - g t^3, t = c/a, for -1 <= t <= 1 and d = 0.

    g = (b/a)^2 (R_D(0, 1, r^2) - R_D(0, r^2, 1))/(6 (1 - r^2)) by r = b/a; valid for ratio <= 1 - 1e-6.

    Parameters
    ----------
    ratio
        Ratio b/a of the semi-axes, any shape.
    """
    k = np.asarray(ratio, dtype=float)
    _, along, across = complete_integrals(k)
    return np.asarray(k * k * (across - along) / (6.0 * (1.0 - k * k)))


def linear_error(ratio: ArrayLike, factor: ArrayLike, reach: float = 0.5) -> Array:
    """Return the largest error of a linear friction law factor c/a against the exact one, over 0 < |c/a| <= reach.

    The ratio of exact to linear is k_f - g t^2, t = c/a, monotonous in t, so that the ends decide.

    Parameters
    ----------
    ratio
        b/a in (0, 1].
    factor
        Slope of the linear law; Lin uses 1.38.
    reach
        At most 1; Lin uses 0.5.

    References
    ----------
    Lin (2019), 3.35 and appendix G.
    """
    if not 0.0 < reach <= 1.0:
        raise ValueError("reach must lie in (0, 1]: the force is a cubic inside the ellipse only")
    start = linear_factor(ratio)
    end = start - cubic_factor(ratio) * reach**2
    return np.asarray(np.maximum(np.abs(np.asarray(factor) / start - 1.0), np.abs(np.asarray(factor) / end - 1.0)))


class Law(Protocol):
    """Friction law of contacts in a motion ``(n, 3)``."""

    def friction(self, at: Contacts, motion: Array, fast: bool = False) -> Friction:
        """Return the friction on the moving bodies; axes and signs as in this module's description."""


@dataclass(frozen=True)
class Coulomb:
    """Coulomb's law: mu p against the direction of the local velocity; zero at rest, where it is not determined."""

    def friction(self, at: Contacts, motion: Array, fast: bool = False) -> Friction:
        """Return the exact integrals over the ellipse."""
        return friction_forces(at, motion, 0.0, fast)


@dataclass(frozen=True)
class Regularised:
    """Regularised Coulomb law mu p v/sqrt(|v|^2 + speed^2).

    Smooth, with a convex potential at most mu F speed above Coulomb's.
    """

    #: Regularising speed > 0 [m/s].
    speed: float

    def friction(self, at: Contacts, motion: Array, fast: bool = False) -> Friction:
        """Return the exact integrals over the ellipse."""
        return friction_forces(at, motion, self.speed, fast)


@dataclass(frozen=True)
class Sigmoid:
    """Lin's friction law: Coulomb's friction times Sig(k_S spin/reference) (Lin 3.20).

    Not the gradient of a convex function; sliding without spin is frictionless.
    """

    #: k_S.
    sharpness: float
    #: Relative spin of a diagonal pair, omega_I sin(beta) [rad/s].
    reference: float
    #: Step in c/a of Lin's maps, between which he interpolates linearly, for d = 0; None for exact integrals.
    map_spacing: float | None = None
    #: Whether the factor has abs(spin); without, the sign of the spin enters twice, as 3.19 prints it, and friction no
    #: longer changes sign with the motion.
    magnitude: bool = True

    def factor(self, spin: Array) -> Array:
        """Return Sig(k_S spin/reference), written as a hyperbolic tangent, which cannot overflow."""
        x = np.abs(spin) if self.magnitude else spin
        return np.asarray(np.tanh(0.5 * self.sharpness * x / self.reference))

    def friction(self, at: Contacts, motion: Array, fast: bool = False) -> Friction:
        """Return Coulomb's friction, from exact integrals or interpolated, times the factor."""
        full = friction_forces(at, motion, 0.0, fast)
        if self.map_spacing is not None:
            full = interpolated_friction(at, motion, self.map_spacing, full, fast)
        s = self.factor(motion[:, 2])
        return Friction(force=full.force * s[:, None], moment=full.moment * s, loss=full.loss * np.abs(s))


def interpolated_friction(at: Contacts, motion: Array, spacing: float, exact: Friction, fast: bool) -> Friction:
    """Return Coulomb's friction interpolated linearly between multiples of ``spacing`` in c/a (Lin 3.2.1).

    Where the spin vanishes, c/a has no value and ``exact`` is taken. Raises ValueError for vx not 0 (d not 0).
    """
    if np.any(motion[:, 0] != 0.0):
        raise ValueError("the source's maps hold only motions with their centre on the major axis: vx = 0")
    spin = motion[:, 2]
    place = np.zeros_like(spin)
    turns = np.abs(motion[:, 1]) < 1e12 * np.abs(spin) * at.a
    place[turns] = motion[turns, 1] / (spin[turns] * at.a[turns]) / spacing
    low = np.floor(place)
    weight = (place - low)[:, None]
    ends = []
    for k in (low, low + 1.0):
        vz = np.where(turns, spin * at.a * k * spacing, motion[:, 1])
        f = friction_forces(at, np.stack([0.0 * vz, vz, spin], axis=1), 0.0, fast)
        ends.append(np.column_stack([f.force, f.moment, f.loss]))
    mixed = (1.0 - weight) * ends[0] + weight * ends[1]
    mixed = np.where(turns[:, None], mixed, np.column_stack([exact.force, exact.moment, exact.loss]))
    return Friction(force=mixed[:, :2], moment=mixed[:, 2], loss=mixed[:, 3])
