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
    """Exact map between space, groove section and the unrolled, helically invariant coordinates of a scene's track."""

    #: Pitch radius [m].
    R: float
    #: Signed reduced lead [m/rad].
    rg: float
    #: Signed lead angle [rad].
    alpha: float
    #: Nominal contact angle [rad].
    beta: float
    #: Ball radius [m].
    ball: float
    #: Signs (s_x, s_z) of the contact direction of each flank ``(4, 2)``.
    signs: Array
    #: Groove centres (x3, z3) of each flank in the section ``(4, 2)`` [m].
    centre: Array
    #: Groove radii ``(4,)`` [m].
    radius: Array
    #: Station of the nut's centre [m].
    z0: float
    #: Azimuth of the helix at the nut's centre [rad].
    phase: float
    #: Number of starts.
    starts: int
    #: Arcs of each groove, see `meshes.parts.Track`.
    arcs: Literal["two", "+z", "-z"] = usual("two")

    @staticmethod
    def of(scene: Scene) -> GrooveMap:
        """Map of a scene's nominal geometry.

        Parameters
        ----------
        scene : Scene
            Screw or bearing.

        Returns
        -------
        GrooveMap
            The map.
        """
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
        """Compare all numbers."""
        return isinstance(other, GrooveMap) and self._content == other._content

    def __hash__(self) -> int:
        """Hash all numbers."""
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
        """Flanks (0 to 3) that carry contacts in grooves of one arc each (`meshes.one_arc.sides_of_arc`)."""
        return sides_of_arcs(self.rg, self.arcs, self.at_apex)

    def axes(self) -> Array:
        """Section frame at azimuth 0.

        Returns
        -------
        (3, 3) Array
            Rows x3 (radial), y3 (along the track) and z3 (across it, in the section), in x, y, z.
        """
        c, s = cos(self.alpha), sin(self.alpha)
        return np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])

    def relative_radii(self, side: int, angle: float) -> tuple[float, float]:
        """Relative radii of curvature of ball and groove across and along the groove.

        Along the groove the screw is convex, the nut concave: normal curvature of the tube around a helix, cos(angle)
        cos^2(alpha) / r at the radius r of the contact.

        Parameters
        ----------
        side : int
            Flank 0 to 3 (SL, SR, NL, NR).
        angle : float
            Contact angle [rad].

        Returns
        -------
        across : float
            1 / (1/r_B - 1/r_G) [m].
        along : float
            1 / (1/r_B - kappa) [m], kappa positive on the nut.

        Examples
        --------
        >>> import rollbench
        >>> m = GrooveMap.of(rollbench.read("lin-case1"))
        >>> [round(1e3 * x, 3) for x in m.relative_radii(0, m.beta)]  # mm
        [18.991, 2.458]
        """
        outward = float(self.signs[side, 0] * np.cos(angle))  # below 0 on the screw
        along = outward * cos(self.alpha) ** 2 / (self.R + outward * self.ball)
        return 1.0 / (1.0 / self.ball - 1.0 / float(self.radius[side])), 1.0 / (1.0 / self.ball - along)

    def section_point(self, side: int, gamma: Array, rho: Array) -> tuple[Array, Array]:
        """Section coordinates at an angle and distance from the centre of a flank's arc.

        Parameters
        ----------
        side : int
            Flank 0 to 3.
        gamma : Array
            Section angle [rad].
        rho : Array
            Distance from the centre of the arc [m].

        Returns
        -------
        x3, z3 : Array
            Section coordinates [m].
        """
        sx, sz = self.signs[side]
        return self.centre[side, 0] + sx * rho * np.cos(gamma), self.centre[side, 1] + sz * rho * np.sin(gamma)

    def unroll(self, x3: Array, z3: Array) -> tuple[Array, Array, Array]:
        """Unrolled coordinates of points in the section.

        Parameters
        ----------
        x3, z3 : Array
            Section coordinates [m].

        Returns
        -------
        r : Array
            Radius from the screw's axis [m].
        zeta : Array
            z less r_g times the total azimuth of the point [m].
        psi : Array
            Azimuth of the point ahead of that of the section [rad].
        """
        r = np.hypot(self.R + x3, z3 * sin(self.alpha))
        psi = np.arctan2(-z3 * sin(self.alpha), self.R + x3)
        return r, z3 * cos(self.alpha) - self.rg * psi, psi

    def roll(self, r: Array, zeta: Array) -> tuple[Array, Array]:
        """Section coordinates of unrolled ones; the inverse of `unroll`.

        Newton's method in z3; converges near the groove, where abs(z3 sin alpha) < 0.9 r.

        Parameters
        ----------
        r, zeta : Array
            Radius [m] and unrolled z [m].

        Returns
        -------
        x3, z3 : Array
            Section coordinates [m].

        Examples
        --------
        >>> import rollbench
        >>> m = GrooveMap.of(rollbench.read("lin-case1"))
        >>> r, zeta, _ = m.unroll(np.array([1e-3]), np.array([2e-3]))
        >>> [float(x.round(12)[0]) for x in m.roll(r, zeta)]
        [0.001, 0.002]
        """
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
        """Polar section coordinates about the centre of a flank's arc; the inverse of `section_point`.

        Parameters
        ----------
        side : int
            Flank 0 to 3.
        x3, z3 : Array
            Section coordinates [m].

        Returns
        -------
        gamma : Array
            Section angle [rad].
        rho : Array
            Distance from the centre of the arc [m].
        """
        sx, sz = self.signs[side]
        wx, wz = x3 - self.centre[side, 0], z3 - self.centre[side, 1]
        return np.arctan2(sz * wz, sx * wx), np.hypot(wx, wz)

    def space(self, r: Array, zeta: Array, phi: Array) -> Array:
        """Points in space of unrolled coordinates.

        Parameters
        ----------
        r, zeta, phi : Array
            Radius [m], unrolled z [m] and total azimuth [rad].

        Returns
        -------
        (..., 3) Array
            x, y, z [m] in the frame of a ball at azimuth 0 and z = 0.
        """
        return np.stack([r * np.cos(phi), r * np.sin(phi), zeta + self.rg * phi], axis=-1)
