"""A grooved tube as numbers: its dimensions, the section of its groove, the outline of its flange, and the curves on it in
space and in plane coordinates."""

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

#: Circles of a flanged nut nearer to each other [m] are one.
SAME = 1e-8


@dataclass(frozen=True)
class GrooveEnds:
    """Where the groove of a nut ends that is filled beyond its loaded balls, as a recirculation leaves it.

    Along its line the groove is whole as far as `WHOLE` ball diameters (or a socket) beyond the outermost balls; over the
    next `RUN_OUT` it rises to the land: its depth below the land is a smoothstep of the azimuth there. Beyond, its flanks
    lie on the land's cylinder, so that the surface stays one of strips and meshes as ever.

    Ends of the groove of every start: its line z - rg phi [m] ``(n,)``, total azimuths ``(n, 2)`` [rad] between which it
    is whole (NaN for a start without balls), length of the run-out [rad]; reduced lead rg [m/rad]."""

    lines: Array
    whole: Array
    length: float
    rg: float

    @classmethod
    def of(cls, m: GrooveMap, sockets: Iterable[tuple[float, float, int]], size: SocketSize) -> GrooveEnds:
        """Ends beyond the balls of ``sockets`` (azimuth [rad], z [m], side). Raises ValueError for a ring."""
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
        """Depth of a line's groove at total azimuths, over that of the whole groove: 1 between the ends, 0 in the filled
        rest."""
        low, high = self.whole[int(np.abs(self.lines - line).argmin())]
        t = np.clip(np.maximum(low - phi, phi - high) / self.length, 0.0, 1.0)
        return np.asarray(np.nan_to_num(1.0 - t * t * (3.0 - 2.0 * t)))

    def in_whole(self, points: Array) -> NDArray[np.bool_]:
        """Which points ``(n, 3)`` [m] of the flanks lie where the groove is whole."""
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
    """A grooved tube between radii r_in < r_out [m] and flat ends z_low < z_high [m] (z absolute); r_in = 0: no bore.

    outer: whether the groove is cut from outside (screw) or from inside (nut); sockets: (azimuth of the ball's section
    including its start [rad], z of the ball [m], side) of every contact; fine, coarse: element sizes near and away from
    the sockets [m]; ends: whether the groove ends beyond its outermost sockets (`GrooveEnds`), or runs through;
    flange: of a nut.
    """

    r_in: float
    r_out: float
    z_low: float
    z_high: float
    outer: bool
    sockets: tuple[tuple[float, float, int], ...]
    size: SocketSize
    fine: float
    coarse: float
    ends: bool = False
    flange: Flange | None = None


def cylindrical(r: float | Array, phi: float | Array, z: float | Array) -> Array:
    """Points ``(n, 3)`` of cylindrical coordinates."""
    points = np.empty((*np.broadcast(r, phi, z).shape, 3))
    points[..., 0], points[..., 1], points[..., 2] = r * np.cos(phi), r * np.sin(phi), z
    return points


@dataclass(frozen=True)
class Groove:
    """Section of a body's groove: map, sides of its flanks (one for both where they are one arc), radii of land and of the
    smooth surface behind [m], angles gamma of apex and edge [rad], middle of the opening along z from the groove's line and
    half of the opening [m], thickness of the wall under the groove [m], where it ends (None: at the flat ends)."""

    m: GrooveMap
    sides: tuple[int, ...]
    land: float
    behind: float
    apex: float
    edge: float
    middle: float
    half: float
    wall: float
    ends: GrooveEnds | None

    @staticmethod
    def of(m: GrooveMap, spec: BodySpec) -> Groove:
        """Groove of a body. Raises ValueError where it leaves no land or no wall."""
        sides: tuple[int, ...] = (0, 1) if spec.outer else (2, 3)
        if m.one_arc:
            sides = tuple(s for s in sides if s in m.arc_sides)
        land, behind = (spec.r_out, spec.r_in) if spec.outer else (spec.r_in, spec.r_out)
        apex, edge = flank_limits(m, sides[-1], land)
        apex = max(apex, 0.0)
        gamma = np.linspace(apex, edge, 65)
        r, zeta, _ = m.unroll(*m.section(sides[-1], gamma, np.full(65, m.radius[sides[-1]])))
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
        """Radius [m], zeta [m] and turn psi [rad] of a flank at angles gamma."""
        return self.m.unroll(*self.m.section(side, gamma, np.full(gamma.shape, self.m.radius[side])))

    def profile(self, side: int, gamma: Array) -> tuple[Array, Array]:
        """Radius [m] and zeta [m] of a flank at angles gamma."""
        return self.unrolled(side, gamma)[:2]

    def radius(self, line: float, r: float | Array, phi: Array) -> float | Array:
        """Radius [m] at total azimuths along a line of what lies at r in the whole groove."""
        return r if self.ends is None else self.land + self.ends.depth(line, phi) * (r - self.land)


def level(at: float) -> Placing:
    """Plane coordinates (t, at)."""
    return lambda t: np.stack([t, np.full(t.size, at)], axis=1)


def upright(at: float) -> Placing:
    """Plane coordinates (at, t)."""
    return lambda t: np.stack([np.full(t.size, at), t], axis=1)


def flat(z: float) -> Placing:
    """Points at the height z of plane coordinates (x, y)."""
    return lambda x: np.column_stack([x, np.full(len(x), z)])


def circle(r: float, z: float) -> Placing:
    """Points at azimuths on a circle about the axis."""
    return lambda t: cylindrical(r, t, z)


def seen(r: float) -> Placing:
    """Plane coordinates (x, y) of azimuths on a circle about the axis."""
    return lambda t: cylindrical(r, t, 0.0)[:, :2]


def rail(line: float, zeta: float, rg: float, at: float | None = None) -> Placing:
    """Plane coordinates (azimuth, at) of stations z along a groove at a height zeta; at None: (azimuth, z)."""
    return lambda z: np.stack([(z - line - zeta) / rg, z if at is None else np.full(z.size, at)], axis=1)


def widest_gap(spec: BodySpec) -> float:
    """Azimuth [rad] midway between the two neighbouring sockets farthest apart, seen along the axis; 0 without sockets."""
    if not spec.sockets:
        return 0.0
    phi = np.sort(np.mod([p for p, _, _ in spec.sockets], 2.0 * np.pi))
    gaps = np.diff(np.append(phi, phi[0] + 2.0 * np.pi))
    k = int(np.round(gaps, 9).argmax())
    return float(phi[k] + 0.5 * gaps[k])


def outline(
    flange: Flange, outer: float, z: tuple[float, float], least: float = SAME
) -> tuple[list[str], list[tuple[float, float]]]:
    """Names of the surfaces outside a flanged nut of radius ``outer`` [m] from its low end on, and the circles (r, z) [m]
    before, between and behind them.

    least: width [m] below which the seat reaches the flange's rim or the nut's outer surface, and a fit is none: circles
    closer than their own edges' deviation from the arc would cross in a mesh.
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
