"""Whole screws, nuts and balls, without sockets: second-order tetrahedra, fine where contacts are expected.

They serve other programs, which find the contact themselves. Surfaces are those of ``meshes.grooved_body`` and
``meshes.ball_body``, known exactly; element sizes grow in proportion to the distance from the expected contacts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial import cKDTree
from skfem import Mesh

from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.ball_body import directions, sphere
from rollbench.meshes.fem import Meshed, nodes_on
from rollbench.meshes.groove import BodySpec, Groove
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.grooved_body import Surface
from rollbench.meshes.half_bodies import HalfRing, half_sphere
from rollbench.meshes.quality import Quality, measure, refuse_bad, straighten, untangle
from rollbench.meshes.shell import POOREST, STRAIGHTENED, Placing, Shell, best_of, fill
from rollbench.meshes.sockets import SocketSize, socket_points


@dataclass(frozen=True)
class Refinement:
    """Element sizes [m]: ``fine`` on the points ``near`` ``(k, 3)`` [m], growing by ``growth`` per length away from them
    up to ``coarse``."""

    near: Array
    fine: float
    growth: float
    coarse: float

    def size(self, share: float = 1.0) -> Placing:
        """Edge length at points ``(n, 3)``, times ``share``."""
        tree = cKDTree(self.near)
        return lambda x: share * np.minimum(self.fine + self.growth * tree.query(x)[0], self.coarse)


@dataclass(frozen=True)
class WholeBody(Meshed):
    """Second-order tetrahedra, the parts of their surface as boundaries; quality."""

    mesh: Mesh
    quality: Quality

    @cached_property
    def named(self) -> dict[str, Index]:
        """Nodes of the named parts of the surface."""
        return {name: nodes_on(self.mesh, name) for name in sorted(self.mesh.boundaries)}


def grid(half: tuple[float, float], step: float) -> Array:
    """Points ``(k, 2)`` of a square grid inside an ellipse about 0, its rim included; half axes and step in m."""
    counts = [max(1, int(np.ceil(x / step))) for x in half]
    x, y = np.meshgrid(*(np.linspace(-1.0, 1.0, 2 * n + 1) for n in counts), indexing="ij")
    inside = x**2 + y**2 <= 1.0
    turn = np.linspace(0.0, 2.0 * np.pi, 8 * max(counts), endpoint=False)
    return np.stack(
        [half[0] * np.concatenate([x[inside], np.cos(turn)]), half[1] * np.concatenate([y[inside], np.sin(turn)])], axis=1
    )


def groove_points(m: GrooveMap, place: tuple[float, float, int], flat: Array) -> Array:
    """Points ``(k, 3)`` [m] of a groove about an expected contact: lengths ``(k, 2)`` [m] across and along from it.

    place: azimuth [rad] and z [m] of the ball, side.
    """
    radius = float(m.radius[place[2]])
    xi = np.stack([flat[:, 0] / radius, np.zeros(len(flat)), flat[:, 1] / m.R], axis=1)
    return socket_points(m, SocketSize(1.0, radius, 1.0), place, xi)


def sphere_points(m: GrooveMap, side: int, radius: float, flat: Array) -> Array:
    """The same on a ball of a radius [m] about the origin, in the frame of azimuth 0."""
    n, t1, t2 = directions(m, side)
    ray = n + flat[:, :1] / radius * t1 + flat[:, 1:] / radius * t2
    return np.asarray(radius * ray / np.linalg.norm(ray, axis=1)[:, None])


def place_ball(m: GrooveMap, at: tuple[float, float], points: Array) -> Array:
    """Points ``(n, 3)`` [m] of a ball in the frame of azimuth 0 where it belongs; at: azimuth [rad] and z [m]."""
    c, s = np.cos(at[0]), np.sin(at[0])
    out = points + np.array([m.R, 0.0, 0.0])
    return np.asarray(out @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + np.array([0.0, 0.0, at[1]]))


def whole_body(m: GrooveMap, spec: BodySpec, refinement: Refinement) -> WholeBody:
    """Mesh a screw or nut; ``spec``'s sockets say where its groove ends, if it does; its sizes are not used. The parts of
    its surface are named as in `meshes.grooved_body`.

    Raises ValueError where the groove leaves no land or wall, or no attempt gives a good mesh.
    """
    plain, groove = replace(spec, sockets=()), Groove.of(m, spec)
    name = "screw" if spec.outer else "nut"
    return _meshed(name, lambda shell, share: Surface(shell, m, plain, share, groove), refinement)


def whole_ball(m: GrooveMap, radius: float, refinement: Refinement) -> WholeBody:
    """Mesh a ball of a radius [m] about the origin in the frame of azimuth 0; ``refinement`` is in that frame.

    Raises ValueError where no attempt gives a good mesh.
    """
    ball_map = replace(m, ball=radius)
    return _meshed("ball", lambda shell, share: sphere(ball_map, shell, [], share), refinement)


def half_body(m: GrooveMap, spec: BodySpec, refinement: Refinement) -> WholeBody:
    """The half of a ring at y >= 0; the plane y = 0 is its part "cut". Raises ValueError as ``whole_body`` does, and for a
    helix or a ring without bore."""
    name = "inner ring" if spec.outer else "outer ring"
    return _meshed(name, lambda shell, share: HalfRing(shell, m, spec, share), refinement)


def half_ball(radius: float, refinement: Refinement, sign: float) -> WholeBody:
    """The half at sign * y >= 0 of a ball of a radius [m] about the origin; the plane y = 0 is its part "cut".

    Raises ValueError where no attempt gives a good mesh.
    """
    return _meshed("ball", lambda shell, share: half_sphere(radius, shell, share, sign), refinement)


def _meshed(name: str, surface: Callable[[Shell, float], object], refinement: Refinement) -> WholeBody:
    """Fill a surface; edges that would turn cells inside out are straightened."""

    def attempt(gmsh: Any, plane: int, volume: int, share: float) -> tuple[WholeBody, float]:
        shell = Shell(gmsh, refinement.size(share), share * refinement.fine, plane)
        surface(shell, share)
        filled = fill(shell, volume)
        mesh = untangle(filled.named(shell), filled.on(shell.tris()))
        mesh, moved = straighten(mesh, np.zeros(0, dtype=np.int64), STRAIGHTENED)
        quality = measure(mesh)
        refuse_bad(quality, name)
        return WholeBody(mesh, quality), moved + max(0.0, POOREST - quality.smallest)

    return best_of(name, attempt)
