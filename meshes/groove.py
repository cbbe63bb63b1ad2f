"""Geometry of a grooved screw, nut or ring for meshing: dimensions, groove section, contour of a flange, and curves.

Curves are functions of one parameter. They return points in space, or plane coordinates on the faces that they bound.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollbench.meshes import sockets
from rollbench.meshes.arrays import Array
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import Flange
from rollbench.meshes.shell import Placing
from rollbench.meshes.solid import RUN_OUT, WHOLE

#: Distance [m] below which two circles on the contour of a flanged nut count as one circle.
SAME = 1e-8


@dataclass(frozen=True)
class GrooveRunOut:
    """Azimuths at which a nut's groove ends beyond its loaded balls, because balls leave it there for the return path.

    The groove has its full depth up to `WHOLE` ball diameters (or the length of a refinement box) beyond the outermost
    balls. Over the next `RUN_OUT` ball diameters its depth below the land decreases to zero, as a smoothstep of the
    azimuth. Further on, its flanks lie on the cylinder of the land, so that the surface consists of the same faces
    everywhere.
    """

    #: Constant z - r_g phi of the helix of each of n starts ``(n,)`` [m], with the lead per radian r_g.
    helix_constants: Array
    #: Azimuths, counted along the helix, between which the groove has its full depth ``(n, 2)`` [rad]; NaN for a start
    #: without balls.
    full_depth_azimuths: Array
    #: Angle over which the depth decreases to zero [rad].
    run_out_angle: float
    #: Lead per radian r_g [m/rad].
    rg: float

    @classmethod
    def from_ball_positions(
        cls, m: GrooveMap, contacts: Iterable[sockets.ContactPosition], size: sockets.RefinementBoxSize
    ) -> GrooveRunOut:
        """Compute where the groove of each thread start ends, from the positions of the loaded balls.

        Parameters
        ----------
        m : GrooveMap
            Groove surfaces of the track, which is a helix.
        contacts : Iterable[ContactPosition]
            For each contact, azimuth [rad] and axial position [m] of its ball, and flank 0 to 3.
        size : RefinementBoxSize
            Size of the refinement boxes (boxes left free for the fine contact patches).

        Returns
        -------
        GrooveRunOut
            Ends of the groove of each thread start.
        """
        lines = sockets.helix_constants_of_starts(m)
        ball = 2.0 * m.ball / float(np.hypot(m.R, m.rg))
        reach = max(WHOLE * ball, size.phi)
        whole = np.full((len(lines), 2), np.nan)
        for k, line in enumerate(lines):
            places = [(phi, *sockets.turns_and_distance_to_groove(m, phi, z, line)) for phi, z, _ in contacts]
            on_line = [phi + 2.0 * np.pi * turns for phi, turns, off in places if off <= sockets.ON_GROOVE * m.ball]
            if on_line:
                whole[k] = min(on_line) - reach, max(on_line) + reach
        return cls(np.array(lines), whole, RUN_OUT * ball, m.rg)

    def relative_depth(self, line: float, phi: Array) -> Array:
        """Return the ratio of a groove's depth to its full depth, at given azimuths: 1 at full depth, 0 beyond its end.

        Parameters
        ----------
        line : float
            Constant z - r_g phi of the groove [m], with the lead per radian r_g.
        phi : Array
            Azimuths, counted along the helix [rad].

        Returns
        -------
        Array
            Ratio of the depths at each azimuth, of the shape of ``phi``.
        """
        low, high = self.full_depth_azimuths[int(np.abs(self.helix_constants - line).argmin())]
        t = np.clip(np.maximum(low - phi, phi - high) / self.run_out_angle, 0.0, 1.0)
        return np.asarray(np.nan_to_num(1.0 - t * t * (3.0 - 2.0 * t)))

    def has_full_depth(self, points: Array) -> NDArray[np.bool_]:
        """Return whether the groove has its full depth at points on its flanks.

        Parameters
        ----------
        points : (n, 3) Array
            Points on the flanks [m].

        Returns
        -------
        (n,) Mask
            True where the groove has its full depth.
        """
        phi = np.arctan2(points[:, 1], points[:, 0])
        off = points[:, 2] - self.rg * phi - self.helix_constants[:, None]
        turns = np.round(off / (2.0 * np.pi * self.rg))
        nearest = np.abs(off - 2.0 * np.pi * self.rg * turns).argmin(axis=0)
        number = np.arange(len(points))
        total = phi + 2.0 * np.pi * turns[nearest, number]
        low, high = self.full_depth_azimuths[nearest].T
        return np.asarray((total >= low) & (total <= high))


@dataclass(frozen=True)
class GroovedBodySpec:
    """Dimensions, contact positions and element sizes for the mesh of a grooved screw, nut or ring with flat ends."""

    #: Inner radius of the body [m]; 0 for a body without bore.
    inner_radius: float
    #: Outer radius of the body [m].
    outer_radius: float
    #: Axial position of the body's flat end at smaller z [m].
    z_low: float
    #: Axial position of the body's flat end at larger z [m].
    z_high: float
    #: Whether the groove is in the outer surface (True, screw) or in the inner one (False, nut).
    groove_outside: bool
    #: For each contact, azimuth [rad] of the ball including the offset of its start, axial position [m] of the ball, and
    #: flank 0 to 3. Around each contact the mesh leaves a refinement box free for a finer mesh.
    contact_positions: tuple[sockets.ContactPosition, ...]
    #: Size of the refinement boxes.
    refinement_box_size: sockets.RefinementBoxSize
    #: Element size at the refinement boxes [m].
    cell_size_at_contacts: float
    #: Element size far from the refinement boxes [m].
    cell_size_far_away: float
    #: Whether the groove ends beyond the outermost balls (`GrooveRunOut`), or runs through the whole body.
    groove_ends_inside: bool = False
    #: Flange of a nut; None for a body without flange.
    flange: Flange | None = None

    @property
    def part_name(self) -> str:
        """Name of the part for messages: "screw" or "nut"."""
        return "screw" if self.groove_outside else "nut"

    @property
    def land_and_back_radii(self) -> tuple[float, float]:
        """Radius of the lands, and radius of the surface behind the groove: bore of a screw, outside of a nut [m]."""
        return (self.outer_radius, self.inner_radius) if self.groove_outside else (self.inner_radius, self.outer_radius)


def points_from_cylindrical(r: float | Array, phi: float | Array, z: float | Array) -> Array:
    """Convert cylindrical coordinates to Cartesian coordinates.

    Parameters
    ----------
    r, phi, z : float | Array
        Radius [m], azimuth [rad] and axial coordinate [m], of shapes that broadcast.

    Returns
    -------
    (..., 3) Array
        Coordinates x, y, z [m].

    Examples
    --------
    >>> points_from_cylindrical(2.0, np.array([0.0, np.pi / 2.0]), 1.0).round(12).tolist()
    [[2.0, 0.0, 1.0], [0.0, 2.0, 1.0]]
    """
    points = np.empty((*np.broadcast(r, phi, z).shape, 3))
    points[..., 0], points[..., 1], points[..., 2] = r * np.cos(phi), r * np.sin(phi), z
    return points


@dataclass(frozen=True)
class GrooveCrossSection:
    """Cross-section of the groove of a screw, nut or ring: section angles of its flanks, opening, wall thickness."""

    #: Groove surfaces of the track.
    groove_map: GrooveMap
    #: Flanks 0 to 3 of the groove: two for a gothic arch, one where the groove is a single arc.
    sides: tuple[int, ...]
    #: Radius of the lands [m].
    land_radius: float
    #: Radius of the smooth surface opposite the groove [m]: the bore of a screw, or the outside of a nut.
    back_radius: float
    #: Section angle of the apex between the two arcs [rad].
    apex_angle: float
    #: Section angle of the edge at which a flank meets the land [rad].
    edge_angle: float
    #: Axial distance from the groove's centre line to the middle of the groove's opening at the land [m].
    opening_position: float
    #: Half width of the groove's opening along z [m].
    opening_half_width: float
    #: Thickness of the wall under the groove [m].
    wall_thickness: float
    #: Azimuths at which the groove ends; None for a groove that runs up to the flat ends.
    run_out: GrooveRunOut | None

    @staticmethod
    def from_body(m: GrooveMap, spec: GroovedBodySpec) -> GrooveCrossSection:
        """Compute the cross-section of the groove of a screw, nut or ring.

        Parameters
        ----------
        m : GrooveMap
            Groove surfaces of the track.
        spec : GroovedBodySpec
            Dimensions of the body.

        Returns
        -------
        GrooveCrossSection
            Cross-section of the groove.

        Raises
        ------
        ValueError
            The groove is so wide or deep that no land or no wall remains.
        """
        sides: tuple[int, ...] = (0, 1) if spec.groove_outside else (2, 3)
        if m.has_single_arc:
            sides = tuple(s for s in sides if s in m.flanks_of_single_arc)
        land, behind = spec.land_and_back_radii
        apex, edge = sockets.section_angles_of_flank(m, sides[-1], land)
        apex = max(apex, 0.0)
        gamma = np.linspace(apex, edge, 65)
        r, zeta, _ = m.flank_to_unrolled(sides[-1], gamma)
        middle = float(m.centre[sides[-1], 1]) if m.has_single_arc else 0.0
        zeta = np.abs(zeta - middle)
        wall = float(r.min() - behind if spec.groove_outside else behind - r.max())
        if wall <= 0.0:
            raise ValueError(
                f"the groove is {-1e3 * wall:.4g} mm deeper than the wall of the part, which ends at a radius of "
                f"{1e3 * behind:.4g} mm: change the bore or the outer diameter"
            )
        pitch = 2.0 * np.pi * abs(m.rg) / m.starts
        if pitch and 2.0 * zeta.max() >= pitch:
            raise ValueError(
                f"the groove is {2e3 * zeta.max():.4g} mm wide, and its next turn is {1e3 * pitch:.4g} mm away: no land "
                "remains between them; raise the lead or move the land towards the pitch radius"
            )
        at = m.z0 + middle
        if not pitch and (at - zeta.max() <= spec.z_low or at + zeta.max() >= spec.z_high):
            raise ValueError(
                f"the groove is {2e3 * zeta.max():.4g} mm wide, but the ring only {1e3 * (spec.z_high - spec.z_low):.4g} "
                "mm: widen the ring or centre it on the groove"
            )
        ends = None
        if spec.groove_ends_inside:
            ends = GrooveRunOut.from_ball_positions(m, spec.contact_positions, spec.refinement_box_size)
        return GrooveCrossSection(m, sides, land, behind, apex, edge, middle, float(zeta[-1]), wall, ends)

    def profile_points(self, side: int, gamma: Array) -> tuple[Array, Array]:
        """Return radius and axial distance from the groove's centre line of points on the profile of a flank.

        Parameters
        ----------
        side : int
            Flank: 0 and 1 are left and right on the screw, 2 and 3 on the nut.
        gamma : Array
            Section angles of the points: around the centre of the flank's arc, from the radial direction [rad].

        Returns
        -------
        r, zeta : Array
            Radii, and axial distances from the helix of the groove's centre [m].
        """
        return self.groove_map.flank_to_unrolled(side, gamma)[:2]

    def radius_with_run_out(self, line: float, r: float | Array, phi: Array) -> float | Array:
        """Return the radius of points on a flank; where the groove ends, this radius passes into that of the land.

        Parameters
        ----------
        line : float
            Constant z - r_g phi of the groove [m], with the lead per radian r_g.
        r : float | Array
            Radius that the points have where the groove has its full depth [m].
        phi : Array
            Azimuths of the points, counted along the helix [rad].

        Returns
        -------
        float or Array
            Radius of the points [m].
        """
        if self.run_out is None:
            return r
        return self.land_radius + self.run_out.relative_depth(line, phi) * (r - self.land_radius)


def line_along_first_axis(second_coordinate: float) -> Placing:
    """Return the straight curve with the plane coordinates (t, ``second_coordinate``), as a function of its parameter t."""
    return lambda t: np.stack([t, np.full(t.size, second_coordinate)], axis=1)


def line_along_second_axis(first_coordinate: float) -> Placing:
    """Return the straight curve with the plane coordinates (``first_coordinate``, t), as a function of its parameter t."""
    return lambda t: np.stack([np.full(t.size, first_coordinate), t], axis=1)


def point_map_at_z(z: float) -> Placing:
    """Return the function that maps plane coordinates (x, y) [m] to points in space at the axial position ``z`` [m]."""
    return lambda x: np.column_stack([x, np.full(len(x), z)])


def cylinder_point_map(r: float) -> Placing:
    """Return the function that maps plane coordinates (arc length, z) [m] to points on the cylinder of radius ``r`` [m]."""
    return lambda x: points_from_cylindrical(r, x[:, 0] / r, x[:, 1])


def circle_in_space(r: float, z: float) -> Placing:
    """Return a circle about the screw's axis as a curve in space: a function that maps azimuths [rad] to points [m].

    ``r``: radius of the circle [m]; ``z``: its axial position [m].
    """
    return lambda t: points_from_cylindrical(r, t, z)


def circle_in_plane(r: float) -> Placing:
    """Return a circle of radius ``r`` [m] in a flat face as a function that maps azimuths [rad] to coordinates x, y [m]."""
    return lambda t: points_from_cylindrical(r, t, 0.0)[:, :2]


def helix_in_plane_coordinates(
    helix_constant: float, zeta: float, rg: float, second_coordinate: float | None = None
) -> Placing:
    """Return a curve along a helical groove in the plane coordinates of a face, as a function of the axial position z.

    Parameters
    ----------
    helix_constant : float
        Constant z - r_g phi of the groove [m].
    zeta : float
        Axial distance of the curve from the helix along the groove's centre [m].
    rg : float
        Lead per radian r_g [m/rad].
    second_coordinate : float | None, default None
        Second plane coordinate of all points of the curve, such as the section angle on a flank; None: their axial
        position z.

    Returns
    -------
    Placing
        Function that returns, at axial positions ``(n,)``, the plane coordinates ``(n, 2)``: azimuth [rad], and
        ``second_coordinate`` or z [m].
    """
    return lambda z: np.stack(
        [(z - helix_constant - zeta) / rg, z if second_coordinate is None else np.full(z.size, second_coordinate)], axis=1
    )


def azimuth_of_widest_gap(spec: GroovedBodySpec) -> float:
    """Return the azimuth in the middle of the widest gap between contacts of a ring; there its closed faces are cut open.

    Parameters
    ----------
    spec : GroovedBodySpec
        Dimensions and contact positions of the ring.

    Returns
    -------
    float
        Azimuth [rad]; 0 for a body without refinement boxes.
    """
    if not spec.contact_positions:
        return 0.0
    phi = np.sort(np.mod([p for p, _, _ in spec.contact_positions], 2.0 * np.pi))
    gaps = np.diff(np.append(phi, phi[0] + 2.0 * np.pi))
    k = int(np.round(gaps, 9).argmax())
    return float(phi[k] + 0.5 * gaps[k])


def outer_surfaces_of_flanged_nut(
    flange: Flange, outer_radius: float, end_positions: tuple[float, float], smallest_width: float = SAME
) -> tuple[list[str], list[tuple[float, float]]]:
    """List the outer surfaces of a flanged nut, and the circles between them, from smaller to larger z.

    Parameters
    ----------
    flange : Flange
        Dimensions of the flange.
    outer_radius : float
        Outer radius of the nut [m].
    end_positions : tuple[float, float]
        Axial positions of the nut's ends [m].
    smallest_width : float, default SAME
        Smallest width of a surface [m]. A narrower ring between the flange's fixed ring (its seat) and either the flange's
        rim or the nut's outer surface is added to the seat; a shorter centring fit is ignored. Otherwise the straight edges
        of neighbouring circles would intersect in the mesh.

    Returns
    -------
    names : list of str
        Names of the surfaces.
    circles : list of (r, z)
        Radius and axial position [m] of the circles that bound the surfaces; there is one more circle than surfaces.
    """
    rim = flange.diameter / 2.0
    end, face, fit = flange.stations(*end_positions)
    far = end_positions[1] if flange.side == "left" else end_positions[0]
    low, high = flange.seat
    high, low = rim if rim - high < smallest_width else high, outer_radius if low - outer_radius < smallest_width else low
    fit = face if abs(fit - face) < smallest_width else fit
    corners = [
        ("rim", (rim, face)),
        ("flange", (high, face)),
        ("seat", (low, face)),
        ("flange", (outer_radius, face)),
        ("centring", (outer_radius, fit)),
        ("outside", (outer_radius, far)),
    ]
    names, places = [], [(rim, end)]
    for name, place in corners:
        if np.hypot(*np.subtract(place, places[-1])) > SAME:
            names.append(name)
            places.append(place)
        else:
            places[-1] = place
    return (names, places) if flange.side == "left" else (names[::-1], places[::-1])
