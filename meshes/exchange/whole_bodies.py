"""Whole screws, nuts, balls, and halves of rings and balls, without sockets: second-order tetrahedra, fine at contacts.

They serve other programs, which find the contact themselves. Surfaces are those of ``meshes.grooved_body`` and
``meshes.ball_body``, known exactly; element sizes grow in proportion to the distance from the expected contacts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from skfem import Mesh

from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.ball_body import directions, sphere
from rollbench.meshes.fem import Meshed, Quality, improve_cells, nodes_on
from rollbench.meshes.groove import (
    BodySpec,
    Groove,
    circle_curve,
    circle_in_plane,
    level_line,
    plane_map,
    points_from_cylindrical,
    upright_line,
)
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import FLANK, Surface
from rollbench.meshes.parts import SIDES
from rollbench.meshes.shell import BEND, POOREST, WALL, Curve, Placing, Shell, Side, best_mesh, fill_shell
from rollbench.meshes.sockets import SocketSize, socket_points

#: Azimuths [rad] of the two parts of the cut.
CUT = (0.0, np.pi)


def sizes_as_asked(shell: Shell) -> None:
    """Keep gmsh from making faces as fine inside as their boundary is: only the boundary of a cut is fine."""
    shell.gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)


class HalfRing:
    """Surface of half a ring, azimuths 0 to 180 deg, in a shell; the plane y = 0 is its boundary "cut".

    A pair of rings whose balls stand at 0 and 180 deg, moved within the plane y = 0, deforms symmetrically about it: the
    half at y >= 0 suffices, with as fine a mesh for half the nodes. Faces are as exact as those of
    ``meshes.grooved_body``.

    Around the section: the smooth surface behind the groove, high end, land, flank, flank, land, low end.
    """

    def __init__(self, shell: Shell, m: GrooveMap, spec: BodySpec, share: float = 1.0) -> None:
        """Divide the curves and triangulate the faces.

        Parameters
        ----------
        shell : Shell
            Shell to which the surface is added.
        m : GrooveMap
            Map of the track.
        spec : BodySpec
            Dimensions.
        share : float, default 1.0
            Factor on the usual longest edges on curved faces.

        Raises
        ------
        ValueError
            A helix, a ring without bore, a groove of one arc, or one that leaves no land or wall.
        """
        if m.rg or spec.r_in <= 0.0 or m.one_arc:
            raise ValueError("only a ring with a bore and a groove of two arcs is cut in halves")
        self.shell, self.groove, self.spec = shell, Groove.of(m, spec), spec
        sizes_as_asked(shell)
        g, line, (low, high) = self.groove, m.z0, (spec.z_low, spec.z_high)
        self.flank_limit = share * min(BEND[0] * float(m.radius[g.sides[0]]), FLANK * spec.coarse)
        self.land_limit = share * BEND[1] * g.land
        self.behind_limit = min(share * BEND[1] * g.behind, max(WALL * g.wall, shell.fine))
        r, zeta = g.profile(g.sides[0], np.array([g.apex]))
        corners = np.array(
            [
                (g.behind, low),
                (g.behind, high),
                (g.land, high),
                (g.land, line + g.half),
                (float(r[0]), line + float(zeta[0])),
                (g.land, line - g.half),
                (g.land, low),
            ]
        )
        limits = [self.behind_limit, self.behind_limit, *[self.land_limit] * 5]
        limits[3:6] = [min(self.land_limit, self.flank_limit)] * 3
        nodes = [shell.nodes(points_from_cylindrical(corners[:, 0], phi, corners[:, 1])) for phi in CUT]
        self.arcs = [
            shell.curve(circle_curve(*corners[k]), *CUT, limits[k], (int(nodes[0][k]), int(nodes[1][k]))) for k in range(7)
        ]
        self.corners, self.line = corners, line
        self.cuts = [[self._edge(k, phi, ends) for k in range(7)] for phi, ends in zip(CUT, nodes, strict=True)]
        self._faces()

    def _edge(self, k: int, phi: float, nodes: NDArray[np.int64]) -> Curve:
        """Edge k of the section at an azimuth, from corner k to the next."""
        ends = int(nodes[k]), int(nodes[(k + 1) % 7])
        if k in (3, 4):
            begin, end = self._gamma(k)
            return self.shell.curve(lambda t: self._flank(k, t, phi), begin, end, self.flank_limit, ends)
        limit = self.behind_limit if k == 0 else self.land_limit

        def space(t: Array) -> Array:
            r, z = self._straight(k, t)
            return points_from_cylindrical(r, phi, z)

        return self.shell.curve(space, 0.0, 1.0, limit, ends)

    def _gamma(self, k: int) -> tuple[float, float]:
        g = self.groove
        return (g.edge, g.apex) if k == 3 else (g.apex, g.edge)

    def _side(self, k: int) -> int:
        return self.groove.sides[1 if k == 3 else 0]

    def _flank(self, k: int, gamma: Array, phi: float | Array) -> Array:
        r, zeta = self.groove.profile(self._side(k), gamma)
        return points_from_cylindrical(r, phi, self.line + zeta)

    def _straight(self, k: int, t: Array) -> tuple[Array, Array]:
        """Radius and z along a straight edge."""
        x = self.corners[k] + t[:, None] * (self.corners[(k + 1) % 7] - self.corners[k])
        return x[:, 0], x[:, 1]

    def _section(self, k: int, t: Array) -> Array:
        """Radius and z ``(n, 2)`` along any edge."""
        if k in (3, 4):
            r, zeta = self.groove.profile(self._side(k), t)
            return np.stack([r, self.line + zeta], axis=1)
        return np.stack(self._straight(k, t), axis=1)

    def _around(self, k: int, begin: float, end: float) -> list[Side]:
        """Boundary of the face that edge k sweeps, in (azimuth, coordinate): from ``begin`` at corner k to ``end``."""

        def at(t: Array, phi: float) -> Array:
            place = begin + (end - begin) * t if k not in (3, 4) else t
            return upright_line(phi)(place)

        first, last = (cut[k] for cut in self.cuts)
        return [
            self.arcs[k].on(level_line(begin)),
            last.on(lambda t: at(t, CUT[1])),
            self.arcs[(k + 1) % 7].back(level_line(end)),
            first.back(lambda t: at(t, CUT[0])),
        ]

    def _faces(self) -> None:
        """Triangulate what the edges sweep, the flat ends, and the cut."""
        outer = self.spec.outer
        for k, name in ((0, "bore" if outer else "outside"), (2, "land"), (5, "land")):
            r, begin, end = self.corners[k, 0], self.corners[k, 1], self.corners[(k + 1) % 7, 1]
            limit = self.behind_limit if k == 0 else self.land_limit
            self._swept(name, k, (begin, end), np.array([r, 1.0]), _cylinder_curve(r), limit)
        for k in (3, 4):
            side = self._side(k)
            scale = np.array([self.corners[4, 0], float(self.groove.m.radius[side])])
            self._swept(f"flank {SIDES[side]}", k, self._gamma(k), scale, self._flank_space(k, scale), self.flank_limit)
        for k, name in ((1, "high end"), (6, "low end")):
            self._end(name, k)
        for phi, cut in zip(CUT, self.cuts, strict=True):
            loop = [cut[k].on(partial(self._section, k)) for k in range(7)]
            self.shell.face("cut", [loop], _section_space(phi), np.inf)

    def _flank_space(self, k: int, scale: Array) -> Placing:
        return lambda x: self._flank(k, x[:, 1] / scale[1], x[:, 0] / scale[0])

    def _end(self, name: str, k: int) -> None:
        """Triangulate a flat end, which edge k sweeps."""
        first, last = (cut[k] for cut in self.cuts)

        def edge(sign: float) -> Placing:
            return lambda t: np.stack([sign * self._straight(k, t)[0], np.zeros(t.size)], axis=1)

        loop = [
            self.arcs[k].on(circle_in_plane(float(self.corners[k, 0]))),
            last.on(edge(-1.0)),
            self.arcs[(k + 1) % 7].back(circle_in_plane(float(self.corners[(k + 1) % 7, 0]))),
            first.back(edge(1.0)),
        ]
        self.shell.face(name, [loop], plane_map(float(self.corners[k, 1])), np.inf)

    def _swept(self, name: str, k: int, ends: tuple[float, float], scale: Array, space: Placing, limit: float) -> None:
        loop = [(n, x * scale) for n, x in self._around(k, *ends)]
        self.shell.face(name, [loop], space, limit)


def _cylinder_curve(r: float) -> Placing:
    return lambda x: points_from_cylindrical(r, x[:, 0] / r, x[:, 1])


def _section_space(phi: float) -> Placing:
    return lambda x: points_from_cylindrical(x[:, 0], phi, x[:, 1])


def half_sphere(radius: float, shell: Shell, share: float, sign: float) -> None:
    """Triangulate the half of a sphere about the origin at sign * y >= 0: boundaries "sphere" and "cut".

    Parameters
    ----------
    radius : float
        Radius [m].
    shell : Shell
        Shell to which the faces are added.
    share : float
        Factor on the usual longest edge.
    sign : float
        1 or -1.
    """
    sizes_as_asked(shell)
    limit = share * BEND[1] * radius
    middle, pole = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.array([0.0, -sign, 0.0])
    equator = shell.curve(lambda t: radius * (np.stack([np.cos(t), np.sin(t)], axis=1) @ middle), 0.0, 2.0 * np.pi, limit)

    def space(at: Array) -> Array:
        square = np.sum((at / radius) ** 2, axis=1)[:, None]
        return np.asarray((radius * (square - 1.0) * pole + 2.0 * at @ middle) / (square + 1.0))

    def stretch(at: Array) -> Array:
        return np.asarray(0.5 * (1.0 + np.sum((at / radius) ** 2, axis=1)))

    rim = [[(equator.nodes, shell.points[equator.nodes] @ middle.T)]]  # the same in the projection from the pole
    shell.face("sphere", rim, space, limit, stretch)
    shell.face("cut", rim, lambda at: at @ middle, np.inf)


@dataclass(frozen=True)
class Refinement:
    """Element sizes that grow with the distance from points."""

    #: Points ``(k, 3)`` [m].
    near: Array
    #: Edge length at the points [m].
    fine: float
    #: Growth of the edge length per unit of distance.
    growth: float
    #: Largest edge length [m].
    coarse: float

    def size(self, share: float = 1.0) -> Placing:
        """Edge length at points ``(n, 3)``, times a factor."""
        tree = cKDTree(self.near)
        return lambda x: share * np.minimum(self.fine + self.growth * tree.query(x)[0], self.coarse)


@dataclass(frozen=True)
class WholeBody(Meshed):
    """Mesh of a whole or half body; the parts of its surface are boundaries."""

    #: Second-order tetrahedra.
    mesh: Mesh
    #: Size and quality.
    quality: Quality

    @cached_property
    def named(self) -> dict[str, Index]:
        """Nodes of the boundaries, by name."""
        return {name: nodes_on(self.mesh, name) for name in sorted(self.mesh.boundaries)}


def grid_in_ellipse(half: tuple[float, float], step: float) -> Array:
    """Points of a square grid inside an ellipse about 0, its rim included.

    Parameters
    ----------
    half : tuple[float, float]
        Semi-axes [m].
    step : float
        Largest distance of neighbours [m].

    Returns
    -------
    (k, 2) Array
        Points [m].
    """
    counts = [max(1, int(np.ceil(x / step))) for x in half]
    x, y = np.meshgrid(*(np.linspace(-1.0, 1.0, 2 * n + 1) for n in counts), indexing="ij")
    inside = x**2 + y**2 <= 1.0
    turn = np.linspace(0.0, 2.0 * np.pi, 8 * max(counts), endpoint=False)
    return np.stack(
        [half[0] * np.concatenate([x[inside], np.cos(turn)]), half[1] * np.concatenate([y[inside], np.sin(turn)])], axis=1
    )


def groove_points(m: GrooveMap, place: tuple[float, float, int], flat: Array) -> Array:
    """Points of a groove around an expected contact.

    Parameters
    ----------
    m : GrooveMap
        Track.
    place : tuple[float, float, int]
        Azimuth [rad] and station [m] of the ball, and flank 0 to 3.
    flat : (k, 2) Array
        Lengths from the contact, across and along the groove [m].

    Returns
    -------
    (k, 3) Array
        Points [m].
    """
    radius = float(m.radius[place[2]])
    xi = np.stack([flat[:, 0] / radius, np.zeros(len(flat)), flat[:, 1] / m.R], axis=1)
    return socket_points(m, SocketSize(1.0, radius, 1.0), place, xi)


def sphere_points(m: GrooveMap, side: int, radius: float, flat: Array) -> Array:
    """Points of a ball around an expected contact, in the frame of azimuth 0.

    Parameters
    ----------
    m : GrooveMap
        Track.
    side : int
        Flank 0 to 3.
    radius : float
        Radius of the ball [m].
    flat : (k, 2) Array
        Lengths from the contact, across and along the groove [m].

    Returns
    -------
    (k, 3) Array
        Points from the ball's centre [m].
    """
    n, t1, t2 = directions(m, side)
    ray = n + flat[:, :1] / radius * t1 + flat[:, 1:] / radius * t2
    return np.asarray(radius * ray / np.linalg.norm(ray, axis=1)[:, None])


def place_ball(m: GrooveMap, at: tuple[float, float], points: Array) -> Array:
    """Move points of a ball from the frame of azimuth 0 to its place.

    Parameters
    ----------
    m : GrooveMap
        Track.
    at : tuple[float, float]
        Azimuth [rad] and station [m] of the ball.
    points : (n, 3) Array
        Points from the ball's centre [m].

    Returns
    -------
    (n, 3) Array
        Points [m].
    """
    c, s = np.cos(at[0]), np.sin(at[0])
    out = points + np.array([m.R, 0.0, 0.0])
    return np.asarray(out @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + np.array([0.0, 0.0, at[1]]))


def whole_body(m: GrooveMap, spec: BodySpec, refinement: Refinement) -> WholeBody:
    """Mesh a screw or nut without sockets; boundaries as in `meshes.grooved_body`.

    Parameters
    ----------
    m : GrooveMap
        Track.
    spec : BodySpec
        Dimensions; its sockets only tell where its groove ends, if it does; its element sizes are not used.
    refinement : Refinement
        Element sizes.

    Returns
    -------
    WholeBody
        The mesh.

    Raises
    ------
    ValueError
        The groove leaves no land or wall, or no attempt of gmsh gives a good mesh.
    """
    plain, groove = replace(spec, sockets=()), Groove.of(m, spec)
    name = "screw" if spec.outer else "nut"
    return _fill_surface(name, lambda shell, share: Surface(shell, m, plain, share, groove), refinement)


def whole_ball(m: GrooveMap, radius: float, refinement: Refinement) -> WholeBody:
    """Mesh a ball about the origin.

    Parameters
    ----------
    m : GrooveMap
        Track.
    radius : float
        Radius of the ball [m].
    refinement : Refinement
        Element sizes, in the frame of azimuth 0.

    Returns
    -------
    WholeBody
        The mesh.

    Raises
    ------
    ValueError
        No attempt of gmsh gives a good mesh.
    """
    ball_map = replace(m, ball=radius)
    return _fill_surface("ball", lambda shell, share: sphere(ball_map, shell, [], share), refinement)


def half_body(m: GrooveMap, spec: BodySpec, refinement: Refinement) -> WholeBody:
    """Mesh the half of a ring at y >= 0; the plane y = 0 is its boundary "cut".

    Parameters
    ----------
    m : GrooveMap
        Track.
    spec : BodySpec
        Dimensions.
    refinement : Refinement
        Element sizes.

    Returns
    -------
    WholeBody
        The mesh.

    Raises
    ------
    ValueError
        As `whole_body`, and for a helix or a ring without bore.
    """
    name = "inner ring" if spec.outer else "outer ring"
    return _fill_surface(name, lambda shell, share: HalfRing(shell, m, spec, share), refinement)


def half_ball(radius: float, refinement: Refinement, sign: float) -> WholeBody:
    """Mesh the half of a ball about the origin at sign * y >= 0; the plane y = 0 is its boundary "cut".

    Parameters
    ----------
    radius : float
        Radius of the ball [m].
    refinement : Refinement
        Element sizes.
    sign : float
        1 or -1.

    Returns
    -------
    WholeBody
        The mesh.

    Raises
    ------
    ValueError
        No attempt of gmsh gives a good mesh.
    """
    return _fill_surface("ball", lambda shell, share: half_sphere(radius, shell, share, sign), refinement)


def _fill_surface(name: str, surface: Callable[[Shell, float], object], refinement: Refinement) -> WholeBody:
    """Fill a surface; edges that would turn cells inside out are straightened."""

    def attempt(gmsh: Any, plane: int, volume: int, share: float) -> tuple[WholeBody, float]:
        shell = Shell(gmsh, refinement.size(share), share * refinement.fine, plane)
        surface(shell, share)
        filled = fill_shell(shell, volume)
        free = np.zeros(0, dtype=np.int64)
        mesh, moved, quality = improve_cells(filled.named(shell), name, filled.on(shell.tris()), free)
        return WholeBody(mesh, quality), moved + max(0.0, POOREST - quality.smallest)

    return best_mesh(name, attempt)
