"""Exact coordinate transformations between space, the groove section and unrolled coordinates along the groove's helix.

A point (x3, z3) of the groove section at azimuth phi has the radius r = |(R_p + x3, z3 sin alpha)|, the azimuth phi + psi
with psi = atan2(-z3 sin alpha, R_p + x3), and z = zeta + r_g (phi + psi) with zeta = z3 cos alpha - r_g psi. Here R_p is
the pitch radius, alpha the lead angle and r_g the lead per radian. Since r and zeta do not depend on phi, the groove is a
straight prism in the unrolled coordinates (phi, zeta, r), and nodes of a mesh are mapped without error.
"""

from __future__ import annotations

from math import cos, sin
from typing import Literal

import numpy as np

from rollbench.meshes.arrays import Array, RecordWithArrays
from rollbench.meshes.helix import lead_angle, lead_per_radian, nominal_groove_centres, nominal_groove_radii
from rollbench.meshes.one_arc import contacts_merge_at_apex, flanks_with_contacts_of_arcs
from rollbench.meshes.parts import SIDE_SIGNS, Scene
from rollbench.meshes.record_keys import frozen_default, frozen_record


@frozen_record
class GrooveMap(RecordWithArrays):
    """Nominal groove surfaces of a scene, with coordinate transformations between space and the groove section."""

    #: Pitch radius [m].
    R: float
    #: Lead per radian r_g = lead / (2 pi) [m/rad]; negative for a left-hand helix, 0 for a bearing.
    rg: float
    #: Signed lead angle [rad].
    alpha: float
    #: Nominal contact angle [rad].
    beta: float
    #: Ball radius [m].
    ball: float
    #: Signs of the radial (x3) and the transverse (z3) component of the direction from the ball's centre to the contact,
    #: for each flank ``(4, 2)``.
    signs: Array
    #: Centre of each flank's arc relative to the ball's centre ``(4, 2)`` [m]: x3 radial, z3 across the track, in the
    #: section normal to the helix.
    centre: Array
    #: Groove radii ``(4,)`` [m].
    radius: Array
    #: Axial position of the nut's centre [m].
    z0: float
    #: Azimuth of the helix at the nut's centre [rad].
    phase: float
    #: Number of starts.
    starts: int
    #: Arcs of each groove, see `meshes.parts.Track`.
    arcs: Literal["two", "+z", "-z"] = frozen_default("two")

    @staticmethod
    def from_scene(scene: Scene) -> GrooveMap:
        """Create the groove surfaces of a scene from its nominal dimensions.

        Parameters
        ----------
        scene : Scene
            Scene with a screw or bearing.

        Returns
        -------
        GrooveMap
            Nominal groove surfaces.
        """
        track = scene.track
        return GrooveMap(
            track.pitch_radius,
            lead_per_radian(track),
            lead_angle(track),
            track.contact_angle,
            scene.balls.radius,
            np.array(SIDE_SIGNS),
            nominal_groove_centres(scene),
            nominal_groove_radii(scene),
            scene.nut.position,
            track.phase,
            track.starts,
            track.arcs,
        )

    @property
    def touches_at_apex(self) -> bool:
        """Whether a ball touches a bearing's groove at one point near the apex, not at both flanks (`meshes.one_arc`)."""
        return self.rg == 0.0 and contacts_merge_at_apex(float(self.radius.min()), self.beta, self.ball)

    @property
    def has_single_arc(self) -> bool:
        """Whether each groove is a single arc, not a gothic arch."""
        return bool(self.flanks_of_single_arc)

    @property
    def flanks_of_single_arc(self) -> tuple[int, ...]:
        """Flanks (0 to 3) that carry contacts where each groove is a single arc; empty for gothic arches."""
        return flanks_with_contacts_of_arcs(self.rg, self.arcs, self.touches_at_apex)

    def section_axes(self) -> Array:
        """Return the unit vectors of the frame of the groove section (normal to the helix) at azimuth 0.

        Returns
        -------
        (3, 3) Array
            Rows: x3 (radial), y3 (along the track) and z3 (across the track), as components x, y, z.
        """
        c, s = cos(self.alpha), sin(self.alpha)
        return np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])

    def relative_curvature_radii(self, side: int, angle: float) -> tuple[float, float]:
        """Compute the relative radii of curvature of ball and groove at a contact, across and along the groove.

        Along the groove the screw is convex and the nut concave. Its curvature is that of a tube around a helix,
        cos(angle) cos^2(alpha) / r at the radius r of the contact, with the lead angle alpha.

        Parameters
        ----------
        side : int
            Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut.
        angle : float
            Contact angle [rad].

        Returns
        -------
        across : float
            Relative radius across the groove, 1 / (1/r_B - 1/r_G) [m], with ball radius r_B and groove radius r_G.
        along : float
            Relative radius along the groove, 1 / (1/r_B - kappa) [m]; the groove's curvature kappa is positive on the nut.

        Examples
        --------
        >>> import rollbench
        >>> m = GrooveMap.from_scene(rollbench.read("lin-case1"))
        >>> [round(1e3 * x, 3) for x in m.relative_curvature_radii(0, m.beta)]  # mm
        [18.991, 2.458]
        """
        outward = float(self.signs[side, 0] * np.cos(angle))  # negative on the screw
        along = outward * cos(self.alpha) ** 2 / (self.R + outward * self.ball)
        return 1.0 / (1.0 / self.ball - 1.0 / float(self.radius[side])), 1.0 / (1.0 / self.ball - along)

    def polar_to_section(self, side: int, gamma: Array, rho: float | Array) -> tuple[Array, Array]:
        """Convert polar coordinates about the centre of a flank's arc to coordinates x3, z3 in the groove section.

        Parameters
        ----------
        side : int
            Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut.
        gamma : Array
            Section angle, measured from the radial direction [rad].
        rho : float or Array
            Distance from the centre of the arc [m].

        Returns
        -------
        x3, z3 : Array
            Coordinates in the groove section: x3 radial, z3 across the track [m].
        """
        sx, sz = self.signs[side]
        return self.centre[side, 0] + sx * rho * np.cos(gamma), self.centre[side, 1] + sz * rho * np.sin(gamma)

    def flank_to_unrolled(self, side: int, gamma: Array) -> tuple[Array, Array, Array]:
        """Return the unrolled coordinates of points on the exact surface of a flank, as `section_to_unrolled` does.

        Parameters
        ----------
        side : int
            Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut.
        gamma : Array
            Section angles of the points: around the centre of the flank's arc, from the radial direction [rad].

        Returns
        -------
        r, zeta, psi : Array
            Radius [m], axial coordinate zeta [m] and azimuth psi [rad].
        """
        return self.section_to_unrolled(*self.polar_to_section(side, gamma, self.radius[side]))

    def section_to_unrolled(self, x3: Array, z3: Array) -> tuple[Array, Array, Array]:
        """Convert coordinates x3, z3 in the groove section to unrolled coordinates along the groove's helix.

        Parameters
        ----------
        x3, z3 : Array
            Coordinates in the groove section: x3 radial, z3 across the track [m].

        Returns
        -------
        r : Array
            Distance of the point from the screw's axis [m].
        zeta : Array
            Axial position of the point minus r_g times its azimuth [m], with the lead per radian r_g, for a section whose
            origin is at azimuth 0 and z = 0.
        psi : Array
            Azimuth of the point minus that of the section's origin [rad].
        """
        r = np.hypot(self.R + x3, z3 * sin(self.alpha))
        psi = np.arctan2(-z3 * sin(self.alpha), self.R + x3)
        return r, z3 * cos(self.alpha) - self.rg * psi, psi

    def unrolled_to_section(self, r: Array, zeta: Array) -> tuple[Array, Array]:
        """Convert unrolled coordinates to coordinates x3, z3 in the groove section; inverse of `section_to_unrolled`.

        Newton's method for z3, which converges near the groove, where abs(z3 sin alpha) < 0.9 r.

        Parameters
        ----------
        r, zeta : Array
            Radius, and axial coordinate zeta along the unrolled groove, as returned by `section_to_unrolled` [m].

        Returns
        -------
        x3, z3 : Array
            Coordinates in the groove section: x3 radial, z3 across the track [m].

        Examples
        --------
        >>> import rollbench
        >>> m = GrooveMap.from_scene(rollbench.read("lin-case1"))
        >>> r, zeta, _ = m.section_to_unrolled(np.array([1e-3]), np.array([2e-3]))
        >>> [float(x.round(12)[0]) for x in m.unrolled_to_section(r, zeta)]
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

    def section_to_polar(self, side: int, x3: Array, z3: Array) -> tuple[Array, Array]:
        """Convert coordinates x3, z3 in the groove section to polar coordinates about the centre of a flank's arc.

        This is the inverse of `polar_to_section`.

        Parameters
        ----------
        side : int
            Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut.
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

    def distances_from_flank(self, side: int, points: Array) -> Array:
        """Return the distances of points from the exact surface of a flank, each in the section normal to the helix.

        Parameters
        ----------
        side : int
            Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut.
        points : (n, 3) Array
            Points [m].

        Returns
        -------
        (n,) Array
            Signed distances [m], positive where the distance of a point from the centre of the arc exceeds its radius.
        """
        r, zeta = np.hypot(points[:, 0], points[:, 1]), points[:, 2] - self.z0
        if self.rg:
            zeta = zeta - self.rg * (np.arctan2(points[:, 1], points[:, 0]) - self.phase)
            pitch = 2.0 * np.pi * abs(self.rg) / self.starts
            zeta = zeta - pitch * np.round(zeta / pitch)
        return np.asarray(self.section_to_polar(side, *self.unrolled_to_section(r, zeta))[1] - self.radius[side])

    def unrolled_to_cartesian(self, r: Array, zeta: Array, phi: Array) -> Array:
        """Convert unrolled coordinates along the groove's helix to Cartesian coordinates.

        Parameters
        ----------
        r, zeta, phi : Array
            Radius [m], axial coordinate along the unrolled groove [m] and azimuth [rad].

        Returns
        -------
        (..., 3) Array
            Coordinates x, y, z [m] in the frame of a ball at azimuth 0 and z = 0.
        """
        return np.stack([r * np.cos(phi), r * np.sin(phi), zeta + self.rg * phi], axis=-1)
