"""The exact map between space and the unrolled, helically invariant coordinates of a grooved body.

A point (x3, z3) of the groove section at azimuth phi lies at r = |(R_p + x3, z3 sin alpha)|, at the total azimuth
phi + psi with psi = atan2(-z3 sin alpha, R_p + x3), and at z = zeta + r_g (phi + psi) with zeta = z3 cos alpha - r_g psi:
(r, zeta) do not depend on phi, so the groove is a straight prism in (phi, zeta, r) and nodes are mapped without error.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from math import cos, sin
from typing import Literal

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.fields import keyed, usual
from rollbench.meshes.helix import groove_radii, lead_angle, nominal_groove_centres, reduced_lead
from rollbench.meshes.one_arc import near_apex, sides_of_arcs
from rollbench.meshes.parts import SIDE_SIGNS, Scene


@keyed
@dataclass(frozen=True, eq=False)
class GrooveMap:
    """Track of one scene: pitch radius R, reduced lead rg [m/rad], lead angle alpha, contact angle beta [rad], ball
    radius; per side: signs (4, 2), groove centres (4, 2) and radii (4,) in the section [m]; z of the nut's centre, phase,
    starts; arcs: as of `meshes.parts.Track`."""

    R: float
    rg: float
    alpha: float
    beta: float
    ball: float
    signs: Array
    centre: Array
    radius: Array
    z0: float
    phase: float
    starts: int
    arcs: Literal["two", "+z", "-z"] = usual("two")

    @staticmethod
    def of(scene: Scene) -> GrooveMap:
        """Map of a scene (nominal geometry)."""
        track = scene.track
        return GrooveMap(
            track.pitch_radius,
            reduced_lead(track),
            lead_angle(track),
            track.contact_angle,
            scene.balls.radius,
            np.array(SIDE_SIGNS),
            nominal_groove_centres(scene),
            groove_radii(scene),
            scene.nut.position,
            track.phase,
            track.starts,
            track.arcs,
        )

    @cached_property
    def _content(self) -> tuple[object, ...]:
        values = (getattr(self, field.name) for field in fields(self))
        return tuple(value.tobytes() if isinstance(value, np.ndarray) else value for value in values)

    def __eq__(self, other: object) -> bool:
        """Whether all numbers are equal."""
        return isinstance(other, GrooveMap) and self._content == other._content

    def __hash__(self) -> int:
        """By all numbers."""
        return hash(self._content)

    @property
    def at_apex(self) -> bool:
        """Whether both flanks of a ring's groove have one contact, at its bottom (`meshes.one_arc`)."""
        return self.rg == 0.0 and near_apex(float(self.radius.min()), self.beta, self.ball)

    @property
    def one_arc(self) -> bool:
        """Whether each groove is one arc."""
        return bool(self.arc_sides)

    @property
    def arc_sides(self) -> tuple[int, ...]:
        """Sides of the contacts in grooves of one arc each (`meshes.one_arc.sides_of_arc`)."""
        return sides_of_arcs(self.rg, self.arcs, self.at_apex)

    def axes(self) -> Array:
        """Rows: radial, along the track, and across it in the groove's section, at azimuth 0, ``(3, 3)``."""
        c, s = cos(self.alpha), sin(self.alpha)
        return np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])

    def relative_radii(self, side: int, angle: float) -> tuple[float, float]:
        """Relative radii [m] of ball and groove across and along it at a contact angle [rad]: along the groove the screw is
        convex, the nut hollow.

        Source: normal curvature of the tube around a helix, cos(angle) cos^2(lead angle) / r at radius r.
        """
        outward = float(self.signs[side, 0] * np.cos(angle))  # below 0 on the screw
        along = outward * cos(self.alpha) ** 2 / (self.R + outward * self.ball)
        return 1.0 / (1.0 / self.ball - 1.0 / float(self.radius[side])), 1.0 / (1.0 / self.ball - along)

    def section(self, side: int, gamma: Array, rho: Array) -> tuple[Array, Array]:
        """Section coordinates (x3, z3) [m] at angle gamma and distance rho from the centre of a side's arc."""
        sx, sz = self.signs[side]
        return self.centre[side, 0] + sx * rho * np.cos(gamma), self.centre[side, 1] + sz * rho * np.sin(gamma)

    def unroll(self, x3: Array, z3: Array) -> tuple[Array, Array, Array]:
        """(r, zeta, psi) of section coordinates."""
        r = np.hypot(self.R + x3, z3 * sin(self.alpha))
        psi = np.arctan2(-z3 * sin(self.alpha), self.R + x3)
        return r, z3 * cos(self.alpha) - self.rg * psi, psi

    def roll(self, r: Array, zeta: Array) -> tuple[Array, Array]:
        """Section coordinates (x3, z3) of (r, zeta): Newton in z3; inverse of ``unroll`` near the groove."""
        z3 = np.array(zeta, dtype=float)
        s, c = sin(self.alpha), cos(self.alpha)
        for _ in range(30):
            q = np.clip(z3 * s / r, -0.9, 0.9)
            f = z3 * c + self.rg * np.arcsin(q) - zeta
            step = f / (c + self.rg * s / (r * np.sqrt(1.0 - q * q)))
            z3 = z3 - step
            if float(np.abs(step).max(initial=0.0)) < 1e-18:
                break
        return np.sqrt(np.maximum(r * r - (z3 * s) ** 2, 0.0)) - self.R, z3

    def polar(self, side: int, x3: Array, z3: Array) -> tuple[Array, Array]:
        """(gamma, rho) about the centre of a side's arc."""
        sx, sz = self.signs[side]
        wx, wz = x3 - self.centre[side, 0], z3 - self.centre[side, 1]
        return np.arctan2(sz * wz, sx * wx), np.hypot(wx, wz)

    def space(self, r: Array, zeta: Array, phi: Array) -> Array:
        """Points ``(..., 3)`` [m] of (r, zeta) at the total azimuth phi, in the frame of a ball at azimuth 0 and z = 0."""
        return np.stack([r * np.cos(phi), r * np.sin(phi), zeta + self.rg * phi], axis=-1)
