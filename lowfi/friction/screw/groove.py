"""Ball, grooves and helix of a ball screw as friction sees them: Hertz constants, directions and kinematic maps.

Axes and order of contacts as in ``screw_path``, which holds the kinematics.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from rollbench.lowfi.friction.screw.path import HelicalMotion
from rollbench.lowfi.hertz import contact_modulus, printed_hertz
from rollbench.lowfi.statics.problem import nominal_hertz
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Balls, Material, Nut, Scene, Screw, Track
from rollbench.meshes.roots import brentq
from rollbench.meshes.surface import printed_radii

Mode = Literal["right", "as printed"]


@dataclass(frozen=True)
class Constants:
    """Hertz constants (4,): approach = C F^(2/3), semi-axes = C_a F^(1/3) across and C_b F^(1/3) along the groove."""

    C: Array
    C_a: Array
    C_b: Array


class Grooved(HelicalMotion, ABC):
    """Helical motions with grooves: largest coefficient mu, Hertz constants of nominal contacts, and touching balls."""

    mu: float

    @property
    @abstractmethod
    def constants(self) -> Constants:
        """Hertz constants of nominal contacts."""

    @cached_property
    def pair(self) -> PairGeometry:
        """Two nominal balls that touch."""
        return pair_geometry(self)


@dataclass(frozen=True)
class ScrewGroove(Grooved):
    """Four-point ball screw: lengths [m], angle [rad], Young's modulus [Pa], speeds of nut and screw [rad/s].

    lead: of a right-hand helix (negative: left-hand, zero: bearing); both bodies move along the helix, so that only
    nut_speed - screw_speed matters; mu at the grooves, mu_balls from ball to ball (the same where None); hertz: exact
    constants, or those with the faults of Table B.1.
    """

    ball_radius: float
    groove_radius: float
    pitch_radius: float
    lead: float
    contact_angle: float
    young: float
    poisson: float
    mu: float
    nut_speed: float
    screw_speed: float = 0.0
    mu_balls: float | None = None
    hertz: Mode = "right"

    def __post_init__(self) -> None:
        """Refuse what the model cannot treat."""
        if not 0.0 < self.ball_radius < self.groove_radius or self.pitch_radius <= self.groove_radius:
            raise ValueError("need 0 < ball_radius < groove_radius < pitch_radius")
        if not 0.0 < self.contact_angle < 0.5 * np.pi:
            raise ValueError("contact_angle must lie between 0 and pi/2")
        if self.young <= 0.0 or not 0.0 <= self.poisson < 0.5 or self.mu < 0.0 or (self.mu_balls or 0.0) < 0.0:
            raise ValueError("need young > 0, 0 <= poisson < 0.5, mu >= 0 and mu_balls >= 0")

    @property
    def reach(self) -> float:
        """Groove radius less ball radius [m]."""
        return self.groove_radius - self.ball_radius

    @cached_property
    def constants(self) -> Constants:
        """Hertz constants at the nominal contact angle, from the exact helicoids or with the faults of Table B.1."""
        steel = Material(self.young, self.poisson)
        scene = Scene(
            "groove",
            "groove",
            Track(self.pitch_radius, abs(self.lead), self.contact_angle, "left" if self.lead < 0.0 else "right"),
            Screw(0.1, 2.0 * self.pitch_radius, self.groove_radius, steel),
            Nut(0.05, 0.05, 4.0 * self.pitch_radius, self.groove_radius, steel),
            Balls(self.ball_radius, steel, (0.0,)),
        )
        if self.hertz == "right":
            h = nominal_hertz(scene)
            return Constants(h.C, h.C_a, h.C_b)
        drawn = specimen(scene, ball_layout(scene))
        modulus = contact_modulus(self.young, self.poisson, self.young, self.poisson)
        angle = np.full(1, self.contact_angle)
        radii = [printed_radii(scene, drawn, side, angle)[0] for side in (0, 3)]
        two = [printed_hertz(self.ball_radius, (float(r[0]), float(r[1])), modulus) for r in radii]
        table = np.array([[h.C, h.C_a, h.C_b] for h in two])[[0, 0, 1, 1]]
        return Constants(*table.T)


@dataclass(frozen=True)
class PairGeometry:
    """Two touching balls, the second at the larger azimuth.

    spacing: difference of azimuths [rad]; closing: closing velocity per difference of omega_B [m]; first, second
    (2, 4): sliding of each ball's surface at the contact by its motion; push (2, 3), slide (2, 2, 3): the direction of
    the force on each ball and of the two sliding velocities, in the ball's own axes.
    """

    spacing: float
    closing: float
    first: Array
    second: Array
    push: Array
    slide: Array


def contact_spacing(screw: HelicalMotion) -> float:
    """Difference of azimuths [rad] at which two balls touch: their centres, on the helix, are 2 R_B apart.

    The source's 2 arcsin(R_B / (L / 2 pi)) (Lin 3.72) is the same for zero lead only. Raises ValueError for balls so
    large that they cannot.
    """
    pitch, rise, reach = screw.pitch_radius, screw.ratio, 2.0 * screw.ball_radius

    def excess(angle: float) -> float:
        return float(np.hypot(2.0 * pitch * np.sin(0.5 * angle), rise * angle)) - reach

    if excess(0.5 * np.pi) <= 0.0:
        raise ValueError("balls too large for the pitch radius")
    return float(brentq(excess, 0.0, 0.5 * np.pi, xtol=1e-15, rtol=1e-14))


def frame(screw: HelicalMotion, azimuth: ArrayLike) -> Array:
    """Rows x3, y3, z3 in fixed axes (..., 3, 3) for balls at azimuths (...) [rad] (Lin 3.62)."""
    c, s, ca, sa = np.cos(azimuth), np.sin(azimuth), np.cos(screw.lead_angle), np.sin(screw.lead_angle)
    rows = np.array([[c, s, 0.0 * c], [-ca * s, ca * c, sa + 0.0 * c], [sa * s, -sa * c, ca + 0.0 * c]])
    return np.moveaxis(rows, (0, 1), (-2, -1))


def pair_geometry(screw: HelicalMotion) -> PairGeometry:
    """Ball-to-ball contact on the exact helix (mends Lin 3.73-3.75, which take a circle of radius L / 2 pi)."""
    spacing = contact_spacing(screw)
    frames = [frame(screw, -0.5 * spacing), frame(screw, 0.5 * spacing)]
    centres = [
        screw.pitch_radius * f[0] + np.array([0.0, 0.0, screw.ratio * s * 0.5 * spacing])
        for f, s in zip(frames, (-1.0, 1.0), strict=True)
    ]
    line = centres[1] - centres[0]
    line /= np.linalg.norm(line)
    across = np.cross(line, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    tangents = np.stack([across, np.cross(line, across)])
    sliding = []
    for f, sign in zip(frames, (1.0, -1.0), strict=True):
        turns = np.concatenate([[[0.0, 0.0, 1.0]], f])
        move = np.cross(turns, sign * screw.ball_radius * line)
        move[0] += screw.radius * f[1]
        sliding.append(tangents @ move.T)
    return PairGeometry(
        spacing=spacing,
        closing=float(screw.radius * line @ frames[0][1]),
        first=sliding[0],
        second=sliding[1],
        push=np.stack([-(frames[0] @ line), frames[1] @ line]),
        slide=np.stack([tangents @ frames[0].T, tangents @ frames[1].T]),
    )
