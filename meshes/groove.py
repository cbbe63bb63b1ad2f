"""A grooved tube as numbers: dimensions, section of its groove, outline of its flange, and curves on it.

Curves are given in space and in plane coordinates of the faces that they bound.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rollbench.meshes.arrays import Array
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import Flange, UnfitKey
from rollbench.meshes.shell import Placing
from rollbench.meshes.sockets import ON_GROOVE, SocketSize, flank_limits, groove_lines, whole_turns
from rollbench.meshes.solid import RUN_OUT, WHOLE

#: Distance [m] below which circles of a flanged nut count as one.
SAME = 1e-8


@dataclass(frozen=True)
class GrooveEnds:
    """Ends of a nut's groove that is filled beyond its loaded balls, as recirculation leaves it.

    The groove is whole up to `WHOLE` ball diameters (or a socket) beyond the outermost balls; over the next `RUN_OUT` it
    rises to the land: its depth below the land is a smoothstep of the azimuth there. Beyond, its flanks lie on the land's
    cylinder, so that the surface is composed of the same strips and is meshed alike.
    """

    #: z - r_g phi of the groove of every start ``(n,)`` [m].
    lines: Array
    #: Total azimuths between which it is whole ``(n, 2)`` [rad]; NaN for a start without balls.
    whole: Array
    #: Length of the run-out [rad].
    length: float
    #: Reduced lead [m/rad].
    rg: float

    @classmethod
    def of(cls, m: GrooveMap, sockets: Iterable[tuple[float, float, int]], size: SocketSize) -> GrooveEnds:
        """Place the ends beyond the balls of some sockets.

        Parameters
        ----------
        m : GrooveMap
            Track.
        sockets : Iterable[tuple[float, float, int]]
            Azimuth [rad] and station [m] of the ball, and flank, of each.
        size : SocketSize
            Size of the sockets.

        Returns
        -------
        GrooveEnds
            The ends.

        Raises
        ------
        UnfitKey
            The track is a ring, whose groove does not end.
        """
        if not m.rg:
            raise UnfitKey("solid.nut_groove", "the groove of a ring does not end: leave solid.nut_groove out")
        lines = groove_lines(m)
        ball = 2.0 * m.ball / float(np.hypot(m.R, m.rg))
        reach = max(WHOLE * ball, size.phi)
        whole = np.full((len(lines), 2), np.nan)
        for k, line in enumerate(lines):
            places = [(phi, *whole_turns(m, phi, z, line)) for phi, z, _ in sockets]
            on_line = [phi + 2.0 * np.pi * turns for phi, turns, off in places if off <= ON_GROOVE * m.ball]
            if on_line:
                whole[k] = min(on_line) - reach, max(on_line) + reach
        return cls(np.array(lines), whole, RUN_OUT * ball, m.rg)

    def depth(self, line: float, phi: Array) -> Array:
        """Depth of a groove over that of the whole groove: 1 between its ends, 0 where it is filled.

        Parameters
        ----------
        line : float
            z - r_g phi of the groove [m].
        phi : Array
            Total azimuths [rad].

        Returns
        -------
        Array of that shape
            Relative depth.
        """
        low, high = self.whole[int(np.abs(self.lines - line).argmin())]
        t = np.clip(np.maximum(low - phi, phi - high) / self.length, 0.0, 1.0)
        return np.asarray(np.nan_to_num(1.0 - t * t * (3.0 - 2.0 * t)))

    def in_whole(self, points: Array) -> NDArray[np.bool_]:
        """Mask of points on the flanks where the groove is whole.

        Parameters
        ----------
        points : (n, 3) Array
            Points on the flanks [m].

        Returns
        -------
        (n,) Mask
            True where the groove is whole.
        """
        phi = np.arctan2(points[:, 1], points[:, 0])
        off = points[:, 2] - self.rg * phi - self.lines[:, None]
        turns = np.round(off / (2.0 * np.pi * self.rg))
        nearest = np.abs(off - 2.0 * np.pi * self.rg * turns).argmin(axis=0)
        number = np.arange(len(points))
        total = phi + 2.0 * np.pi * turns[nearest, number]
        low, high = self.whole[nearest].T
        return np.asarray((total >= low) & (total <= high))


@dataclass(frozen=True)
class BodySpec:
    """Recipe of a grooved tube with flat ends: dimensions, sockets and element sizes."""

    #: Inner radius [m]; 0: no bore.
    r_in: float
    #: Outer radius [m].
    r_out: float
    #: Station of the lower end [m].
    z_low: float
    #: Station of the upper end [m].
    z_high: float
    #: Whether the groove is cut from outside (screw) or from inside (nut).
    outer: bool
    #: Of every contact, azimuth [rad] of the ball's section with the offset of its start, station [m] of the ball, and
    #: flank 0 to 3.
    sockets: tuple[tuple[float, float, int], ...]
    #: Size of the sockets.
    size: SocketSize
    #: Element size at the sockets [m].
    fine: float
    #: Element size far from them [m].
    coarse: float
    #: Whether the groove ends beyond its outermost sockets (`GrooveEnds`), or runs through.
    ends: bool = False
    #: Flange of a nut.
    flange: Flange | None = None


def points_from_cylindrical(r: float | Array, phi: float | Array, z: float | Array) -> Array:
    """Points of cylindrical coordinates.

    Parameters
    ----------
    r, phi, z : float | Array
        Radius [m], azimuth [rad] and height [m], of shapes that broadcast.

    Returns
    -------
    (..., 3) Array
        x, y, z [m].

    Examples
    --------
    >>> points_from_cylindrical(2.0, np.array([0.0, np.pi / 2.0]), 1.0).round(12).tolist()
    [[2.0, 0.0, 1.0], [0.0, 2.0, 1.0]]
    """
    points = np.empty((*np.broadcast(r, phi, z).shape, 3))
    points[..., 0], points[..., 1], points[..., 2] = r * np.cos(phi), r * np.sin(phi), z
    return points


@dataclass(frozen=True)
class Groove:
    """Section of a body's groove."""

    #: Map of the track.
    m: GrooveMap
    #: Flanks; the same one for both halves where they are one arc.
    sides: tuple[int, ...]
    #: Radius of the lands [m].
    land: float
    #: Radius of the smooth surface behind the groove [m].
    behind: float
    #: Section angle of the apex [rad].
    apex: float
    #: Section angle of the edge at the land [rad].
    edge: float
    #: Middle of the opening along z from the groove's line [m].
    middle: float
    #: Half of the opening along z [m].
    half: float
    #: Thickness of the wall under the groove [m].
    wall: float
    #: Where the groove ends; None: at the flat ends.
    ends: GrooveEnds | None

    @staticmethod
    def of(m: GrooveMap, spec: BodySpec) -> Groove:
        """Section of a body's groove.

        Parameters
        ----------
        m : GrooveMap
            Map of the track.
        spec : BodySpec
            Dimensions of the body.

        Returns
        -------
        Groove
            The section.

        Raises
        ------
        ValueError
            The groove leaves no land or no wall.
        """
        sides: tuple[int, ...] = (0, 1) if spec.outer else (2, 3)
        if m.one_arc:
            sides = tuple(s for s in sides if s in m.arc_sides)
        land, behind = (spec.r_out, spec.r_in) if spec.outer else (spec.r_in, spec.r_out)
        apex, edge = flank_limits(m, sides[-1], land)
        apex = max(apex, 0.0)
        gamma = np.linspace(apex, edge, 65)
        r, zeta, _ = m.unroll(*m.section_point(sides[-1], gamma, np.full(65, m.radius[sides[-1]])))
        middle = float(m.centre[sides[-1], 1]) if m.one_arc else 0.0
        zeta = np.abs(zeta - middle)
        wall = float(r.min() - behind if spec.outer else behind - r.max())
        if wall <= 0.0:
            raise ValueError(
                f"the groove is {-1e3 * wall:.4g} mm deeper than its wall, which ends at a radius of {1e3 * behind:.4g} "
                "mm: change the bore or the outer diameter"
            )
        pitch = 2.0 * np.pi * abs(m.rg) / m.starts
        if pitch and 2.0 * zeta.max() >= pitch:
            raise ValueError(
                f"the groove is {2e3 * zeta.max():.4g} mm wide, its next turn {1e3 * pitch:.4g} mm on: no land is left; "
                "raise the lead or move the land towards the pitch radius"
            )
        at = m.z0 + middle
        if not pitch and (at - zeta.max() <= spec.z_low or at + zeta.max() >= spec.z_high):
            raise ValueError(
                f"the groove is {2e3 * zeta.max():.4g} mm wide, the ring only {1e3 * (spec.z_high - spec.z_low):.4g} mm: "
                "widen the ring or put its middle at the groove"
            )
        ends = GrooveEnds.of(m, spec.sockets, spec.size) if spec.ends else None
        return Groove(m, sides, land, behind, apex, edge, middle, float(zeta[-1]), wall, ends)

    def unrolled(self, side: int, gamma: Array) -> tuple[Array, Array, Array]:
        """Unrolled coordinates of a flank.

        Parameters
        ----------
        side : int
            Flank 0 to 3.
        gamma : Array
            Section angles [rad].

        Returns
        -------
        r, zeta, psi : Array
            As of `GrooveMap.unroll` [m, m, rad].
        """
        return self.m.unroll(*self.m.section_point(side, gamma, np.full(gamma.shape, self.m.radius[side])))

    def profile(self, side: int, gamma: Array) -> tuple[Array, Array]:
        """Radius and unrolled height of a flank.

        Parameters
        ----------
        side : int
            Flank 0 to 3.
        gamma : Array
            Section angles [rad].

        Returns
        -------
        r, zeta : Array
            [m].
        """
        return self.unrolled(side, gamma)[:2]

    def radius(self, line: float, r: float | Array, phi: Array) -> float | Array:
        """Radius of a flank's point, raised towards the land where the groove runs out.

        Parameters
        ----------
        line : float
            z - r_g phi of the groove [m].
        r : float | Array
            Radius in the whole groove [m].
        phi : Array
            Total azimuths [rad].

        Returns
        -------
        float or Array
            [m].
        """
        return r if self.ends is None else self.land + self.ends.depth(line, phi) * (r - self.land)


def level_line(at: float) -> Placing:
    """Curve of plane coordinates (t, at)."""
    return lambda t: np.stack([t, np.full(t.size, at)], axis=1)


def upright_line(at: float) -> Placing:
    """Curve of plane coordinates (at, t)."""
    return lambda t: np.stack([np.full(t.size, at), t], axis=1)


def plane_map(z: float) -> Placing:
    """Map of plane coordinates (x, y) to points at the height z [m]."""
    return lambda x: np.column_stack([x, np.full(len(x), z)])


def circle_curve(r: float, z: float) -> Placing:
    """Curve of points on a circle of radius r [m] about the axis at the height z [m], by azimuth."""
    return lambda t: points_from_cylindrical(r, t, z)


def circle_in_plane(r: float) -> Placing:
    """Curve of plane coordinates (x, y) on a circle of radius r [m] about the axis, by azimuth, for flat faces."""
    return lambda t: points_from_cylindrical(r, t, 0.0)[:, :2]


def groove_line(line: float, zeta: float, rg: float, at: float | None = None) -> Placing:
    """Curve of plane coordinates along a groove, by height z [m].

    Parameters
    ----------
    line : float
        z - r_g phi of the groove [m].
    zeta : float
        Unrolled height on its section [m].
    rg : float
        Reduced lead [m/rad].
    at : float | None, default None
        Second coordinate; None: z.

    Returns
    -------
    Placing
        Plane coordinates (azimuth, at).
    """
    return lambda z: np.stack([(z - line - zeta) / rg, z if at is None else np.full(z.size, at)], axis=1)


def widest_gap(spec: BodySpec) -> float:
    """Azimuth midway between the two neighbouring sockets farthest apart, seen along the axis.

    Returns
    -------
    float
        [rad]; 0 without sockets.
    """
    if not spec.sockets:
        return 0.0
    phi = np.sort(np.mod([p for p, _, _ in spec.sockets], 2.0 * np.pi))
    gaps = np.diff(np.append(phi, phi[0] + 2.0 * np.pi))
    k = int(np.round(gaps, 9).argmax())
    return float(phi[k] + 0.5 * gaps[k])


def outer_surfaces(
    flange: Flange, outer: float, z: tuple[float, float], least: float = SAME
) -> tuple[list[str], list[tuple[float, float]]]:
    """Surfaces outside a flanged nut, from its lower end to its upper one.

    Parameters
    ----------
    flange : Flange
        The flange.
    outer : float
        Outer radius of the nut [m].
    z : tuple[float, float]
        Stations of its ends [m].
    least : float, default SAME
        Width [m] below which the seat is taken to reach the flange's rim or the nut's outer surface, and a centring
        fit is ignored: circles closer than their edges' deviation from the arc would intersect in a mesh.

    Returns
    -------
    names : list of str
        Names of the surfaces.
    circles : list of (r, z)
        Circles [m] before, between and behind them.
    """
    rim = flange.diameter / 2.0
    end, face, fit = flange.stations(*z)
    far = z[1] if flange.side == "left" else z[0]
    low, high = flange.seat
    high, low = rim if rim - high < least else high, outer if low - outer < least else low
    fit = face if abs(fit - face) < least else fit
    corners = [
        ("rim", (rim, face)),
        ("flange", (high, face)),
        ("seat", (low, face)),
        ("flange", (outer, face)),
        ("centring", (outer, fit)),
        ("outside", (outer, far)),
    ]
    names, places = [], [(rim, end)]
    for name, place in corners:
        if np.hypot(*np.subtract(place, places[-1])) > SAME:
            names.append(name)
            places.append(place)
        else:
            places[-1] = place
    return (names, places) if flange.side == "left" else (names[::-1], places[::-1])
