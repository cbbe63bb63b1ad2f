"""Linear ball bearing of two V-grooves: its description, contact directions and Hertz contacts.

Contacts are ordered BL, BR, TR, TL (bottom left, bottom right, top right, top left; Lin Figure 3.10). The bottom is at
rest, the top (the carriage) moves along z. Angles are measured from -y (bottom) and +y (top) towards the sides.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rollbench.lowfi.hertz import HertzConstants, contact_modulus, hertz_constants
from rollbench.meshes.arrays import Array

CONTACTS = ("BL", "BR", "TR", "TL")
#: Sense of the contacts' directions from the ball's centre: x, y.
SENSE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
#: Contacts on the moving carriage.
MOVING = np.array([0.0, 0.0, 1.0, 1.0])


@dataclass(frozen=True)
class LinearBearing:
    """Parameters of Lin's Table 3.3, in SI.

    conformity: groove radius over ball diameter; speed of the carriage along z, of either sign; mu of the grooves,
    mu_balls of balls against each other; contact_angle: nominal [rad].
    """

    ball_radius: float
    conformity: float
    contact_angle: float
    speed: float
    mu: float
    mu_balls: float
    young: float
    poisson: float

    def __post_init__(self) -> None:
        """Raise ValueError for values outside their range."""
        if not self.ball_radius > 0.0 or not self.young > 0.0 or not -1.0 < self.poisson <= 0.5:
            raise ValueError("ball radius and Young's modulus must be positive, Poisson's ratio in (-1, 0.5]")
        if not self.conformity > 0.5:
            raise ValueError(f"conformity must exceed 0.5 (groove wider than the ball), not {self.conformity}")
        if not 0.0 < self.contact_angle < 0.5 * np.pi:
            raise ValueError(f"contact angle must lie between 0 and 90 degrees, not {self.contact_angle} rad")
        if not (self.mu >= 0.0 and self.mu_balls >= 0.0 and np.isfinite(self.mu + self.mu_balls + self.speed)):
            raise ValueError("mu and mu_balls must not be negative, the speed finite")

    def hertz(self) -> HertzConstants:
        """Hertz constants of a ball in a straight groove; semi-axis a lies in the section, b along the track."""
        return _hertz(self.ball_radius, self.conformity, self.young, self.poisson)

    def psi(self) -> float:
        """Constant of a = Psi R_B^(1/3) F^(1/3) (Lin 3.36) [(m2/N)^(1/3)]."""
        return float(self.hertz().C_a / np.cbrt(self.ball_radius))


@lru_cache(maxsize=64)
def _hertz(ball_radius: float, conformity: float, young: float, poisson: float) -> HertzConstants:
    across = 1.0 - 0.5 / conformity
    modulus = contact_modulus(young, poisson, young, poisson)
    return hertz_constants(np.array(1.0 / ball_radius), np.array(across / ball_radius), modulus)


def directions(angles: Array) -> Array:
    """Unit vectors ``(..., 4, 2)`` in (x, y) from the ball's centre to its contacts, from contact angles [rad]."""
    return np.asarray(SENSE * np.stack([np.sin(angles), np.cos(angles)], axis=-1))


def semi_axes(bearing: LinearBearing, loads: Array) -> tuple[Array, Array]:
    """Semi-axes a >= b [m] of the contacts under normal forces ``loads`` [N]."""
    constants, root = bearing.hertz(), np.cbrt(loads)
    return np.asarray(constants.C_a * root), np.asarray(constants.C_b * root)


def deviations(theta: Array, *, mated: bool = False) -> Array:
    """Deviations ``(..., 4)`` of the contact angles [rad] in the case study: -theta, theta on the bottom groove.

    mated: design (b) of Lin 3.3.4.2, the top groove made to match (see ``mated_top``).
    """
    t = np.asarray(theta, dtype=float)
    bottom = np.stack([-t, t], axis=-1)
    top = mated_top(bottom) if mated else np.zeros_like(bottom)
    return np.concatenate([bottom, top], axis=-1)


def mated_top(bottom: Array) -> Array:
    """Deviations (TR, TL) of the top groove that take ball velocity's dependence on load away, from (BL, BR).

    Rule of Lin 3.3.4.2: each diagonal keeps its contacts opposite, so that (3.43) vanishes under any load.
    """
    return np.asarray(bottom, dtype=float).copy()
