"""Friction laws behind one interface: Coulomb, Coulomb regularised, and the sigmoid of the source."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rollbench.lowfi.friction.contact.ellipse import Contacts, Friction, friction
from rollbench.meshes.arrays import Array


class Law(Protocol):
    """Anything that gives the friction of contacts in a motion (n, 3)."""

    def friction(self, at: Contacts, motion: Array, fast: bool = False) -> Friction:
        """Friction on the moving bodies; see ``lowfi.friction.contact.ellipse`` for axes and signs."""


@dataclass(frozen=True)
class Coulomb:
    """mu p against the direction of the local velocity; zero at rest, where it is not determined by the motion."""

    def friction(self, at: Contacts, motion: Array, fast: bool = False) -> Friction:
        """Exact integrals over the ellipse."""
        return friction(at, motion, 0.0, fast)


@dataclass(frozen=True)
class Regularised:
    """mu p v / sqrt(|v|^2 + speed^2): smooth, the gradient of a convex function at most mu F speed above Coulomb's.

    speed > 0 [m/s].
    """

    speed: float

    def friction(self, at: Contacts, motion: Array, fast: bool = False) -> Friction:
        """Exact integrals over the ellipse."""
        return friction(at, motion, self.speed, fast)


@dataclass(frozen=True)
class Sigmoid:
    """The source's law: Coulomb's friction times Sig(k_S spin / reference) (Lin 3.20), as k_S = ``sharpness``.

    reference: relative spin of a diagonal pair [rad/s], omega_I sin(beta). Not the gradient of a convex function, and
    sliding without spin is frictionless. ``magnitude``: the factor of abs(spin); without it the sign of the spin enters
    twice, as 3.19 prints it, and friction no longer changes sign with the motion.
    map_spacing: step in c/a of the source's maps between which it interpolates linearly; None for exact integrals.
    Only for d = 0 then.
    """

    sharpness: float
    reference: float
    map_spacing: float | None = None
    magnitude: bool = True

    def factor(self, spin: Array) -> Array:
        """Sig(k_S spin / reference), written as a hyperbolic tangent, which cannot overflow."""
        x = np.abs(spin) if self.magnitude else spin
        return np.asarray(np.tanh(0.5 * self.sharpness * x / self.reference))

    def friction(self, at: Contacts, motion: Array, fast: bool = False) -> Friction:
        """Coulomb's friction, from exact integrals or interpolated, times the factor."""
        full = friction(at, motion, 0.0, fast)
        if self.map_spacing is not None:
            full = interpolated(at, motion, self.map_spacing, full, fast)
        s = self.factor(motion[:, 2])
        return Friction(force=full.force * s[:, None], moment=full.moment * s, loss=full.loss * np.abs(s))


def interpolated(at: Contacts, motion: Array, spacing: float, exact: Friction, fast: bool) -> Friction:
    """Coulomb's friction interpolated linearly between multiples of ``spacing`` in c/a (Lin 3.2.1).

    Where the spin vanishes, c/a has no value and ``exact`` stands. Raises ValueError for vx not 0 (d not 0).
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
        f = friction(at, np.stack([0.0 * vz, vz, spin], axis=1), 0.0, fast)
        ends.append(np.column_stack([f.force, f.moment, f.loss]))
    mixed = (1.0 - weight) * ends[0] + weight * ends[1]
    mixed = np.where(turns[:, None], mixed, np.column_stack([exact.force, exact.moment, exact.loss]))
    return Friction(force=mixed[:, :2], moment=mixed[:, 2], loss=mixed[:, 3])
