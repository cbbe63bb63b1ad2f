"""Coarse mesh of a ball by gmsh: second-order tetrahedra with a socket, a truncated pyramid, at every contact.

Each half of the sphere is triangulated in the plane onto which it projects from the opposite pole; sockets become holes,
and no seam is needed. The projection keeps angles, and stretches lengths by a known factor from 1/2 to 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import cos, sin
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshes.groove_map import GrooveMap
from meshes.parts import SIDES
from meshes.quality import Quality, measure, refuse_bad, straighten, untangle
from meshes.shell import BEND, POOREST, STRAIGHTENED, Shell, best_of, fill, graded
from meshes.sockets import SocketMesh, rim, socket_mesh

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Element sizes grow from `fine` to `coarse` between these distances from the sockets, over the ball's radius.
GROWTH = (0.072, 0.72)


@dataclass(frozen=True)
class BallSocket:
    """Socket of one side: half widths of the pyramid's base (tangents of its angles), depth below the surface [m]."""

    side: int
    across: float
    along: float
    depth: float


@dataclass(frozen=True)
class BallBody:
    """Mesh of a ball about its centre in the frame of azimuth 0: points ``(n, 3)`` [m], second-order tetrahedra, per
    socket its nodes and its faces' mesh, seconds it took, quality."""

    points: Array
    cells: Index
    socket_nodes: dict[int, Index]
    sockets: dict[int, SocketMesh]
    seconds: float
    quality: Quality


def directions(m: GrooveMap, side: int) -> Array:
    """Rows: contact direction, direction of growing gamma, direction of growing azimuth, at azimuth 0, ``(3, 3)``."""
    sx, sz = m.signs[side]
    x3, y3 = np.array([1.0, 0.0, 0.0]), np.array([0.0, cos(m.alpha), sin(m.alpha)])
    z3 = np.array([0.0, -sin(m.alpha), cos(m.alpha)])
    c, s = cos(m.beta), sin(m.beta)
    return np.stack([sx * c * x3 + sz * s * z3, -sx * s * x3 + sz * c * z3, y3])


def pyramid_points(m: GrooveMap, socket: BallSocket, s: Array, t: Array, depth: Array) -> Array:
    """Points ``(n, 3)`` [m] on the rays n + s t1 + t t2: depth 0 on the sphere, 1 on the inner plane."""
    n, t1, t2 = directions(m, socket.side)
    ray = n[None, :] + s[:, None] * t1 + t[:, None] * t2
    outer = m.ball / np.linalg.norm(ray, axis=1)
    return np.asarray(ray * (outer + depth * (m.ball - socket.depth - outer))[:, None])


def ball_points(m: GrooveMap, socket: BallSocket, xi: Array) -> Array:
    """Points ``(n, 3)`` [m] of local coordinates: across and along in [-1, 1], depth in [0, 1]."""
    return pyramid_points(m, socket, socket.across * xi[:, 0], socket.along * xi[:, 2], xi[:, 1])


def ball_coordinates(m: GrooveMap, socket: BallSocket, points: Array) -> Array:
    """Local coordinates xi ``(n, 3)`` of points on the socket's side of the ball; inverse of ``ball_points``."""
    n, t1, t2 = directions(m, socket.side)
    height = points @ n
    s, t = (points @ t1) / height, (points @ t2) / height
    outer = m.ball / np.sqrt(1.0 + s * s + t * t)
    return np.stack([s / socket.across, (outer - height) / (outer - (m.ball - socket.depth)), t / socket.along], axis=1)


def build_ball(m: GrooveMap, sockets: tuple[BallSocket, ...], fine: float, coarse: float, cuts: int = 2) -> BallBody:
    """Mesh a ball with a socket for each contact; fine, coarse: element sizes near and away from them [m].

    Raises ValueError where sockets overlap or no attempt gives a good mesh.
    """
    begin = perf_counter()
    boxes = [socket_mesh(partial(ball_points, m, socket), (cuts, cuts, cuts)) for socket in sockets]
    _refuse_overlap(m, sockets)
    near = np.concatenate([ball_points(m, socket, box.xi) for socket, (box, _) in zip(sockets, boxes, strict=True)])

    def attempt(gmsh: Any, plane: int, volume: int, share: float) -> tuple[BallBody, float]:
        sizes = share * fine, share * coarse
        shell = Shell(gmsh, graded(near, *sizes, *(m.ball * g for g in GROWTH)), min(sizes), plane)
        corners = []
        for socket, (box, raised) in zip(sockets, boxes, strict=True):
            corners.append(shell.socket(box, ball_points(m, socket, box.xi), ball_points(m, socket, raised)))
        sphere(m, shell, [c[rim(box)] for c, (box, _) in zip(corners, boxes, strict=True)], share)
        filled = fill(shell, volume)
        own = [filled.box_nodes(c, box) for c, (box, _) in zip(corners, boxes, strict=True)]
        points = untangle(filled.points, filled.cells, filled.on(shell.tris()))
        points, moved = straighten(points, filled.cells, np.concatenate(own), STRAIGHTENED)
        quality = measure(points, filled.cells, "P2")
        refuse_bad(quality, "ball")
        nodes = {socket.side: n for socket, n in zip(sockets, own, strict=True)}
        meshes = {socket.side: box for socket, (box, _) in zip(sockets, boxes, strict=True)}
        body = BallBody(points, filled.cells, nodes, meshes, perf_counter() - begin, quality)
        return body, moved + max(0.0, POOREST - quality.smallest)

    return best_of("ball", attempt)


def sphere(m: GrooveMap, shell: Shell, rims: list[Index], share: float) -> None:
    """Triangulate the two halves of the sphere outside the sockets' rims."""
    axis, limit = parting(m), share * BEND[1] * m.ball
    along = directions(m, 0)[2]
    middle = np.stack([along, np.cross(axis, along)])
    equator = shell.curve(lambda t: m.ball * (np.stack([np.cos(t), np.sin(t)], axis=1) @ middle), 0.0, 2.0 * np.pi, limit)

    def stretch(flat: Array) -> Array:
        return np.asarray(0.5 * (1.0 + np.sum((flat / m.ball) ** 2, axis=1)))

    for pole in (-axis, axis):

        def plane(x: Array, pole: Array = pole) -> Array:
            return np.asarray(x @ middle.T / (1.0 - x @ pole / m.ball)[:, None])

        def space(flat: Array, pole: Array = pole) -> Array:
            square = np.sum((flat / m.ball) ** 2, axis=1)[:, None]
            return np.asarray((m.ball * (square - 1.0) * pole + 2.0 * flat @ middle) / (square + 1.0))

        closed = [np.append(r, r[0]) for r in rims if shell.points[r[0]] @ pole < 0.0]
        loops = [[(n, plane(shell.points[n]))] for n in (equator.nodes, *closed)]
        shell.face("sphere", loops, space, limit, stretch)


def parting(m: GrooveMap) -> Array:
    """Normal of the plane that parts the ball away from all contacts: screw from nut, or left from right."""
    _, t1, _ = directions(m, 3)
    n = directions(m, 3)[0]
    x3, z3 = cos(m.beta) * n - sin(m.beta) * t1, sin(m.beta) * n + cos(m.beta) * t1
    return np.asarray(x3 if m.beta <= np.pi / 4 else z3)


def _refuse_overlap(m: GrooveMap, sockets: tuple[BallSocket, ...]) -> None:
    """Raise ValueError where there is no socket, one is too deep or too wide, or two share a part of the sphere."""
    if not sockets:
        raise ValueError("a ball is meshed around its contacts: give it at least one socket")
    remedy = "make the sockets smaller (meshes.sockets.fitted_socket finds a size that fits)"
    a, b = np.linspace(-1.0, 1.0, 41), np.ones(41)
    around = np.concatenate([np.stack(x, 1) for x in ((a, 0 * a, -b), (a, 0 * a, b), (-b, 0 * a, a), (b, 0 * a, a))])
    for one in sockets:
        name = f"socket {SIDES[one.side]} of a ball of {1e3 * m.ball:.4g} mm radius"
        if not 0.0 < one.depth < 0.8 * m.ball:
            raise ValueError(f"the {name} is {1e3 * one.depth:.4g} mm deep: {remedy}")
        points = ball_points(m, one, around)
        if np.ptp(np.sign(points @ parting(m))) > 0.0:
            raise ValueError(f"the {name} reaches over the ball's middle: {remedy}")
        for other in sockets:
            xi = ball_coordinates(m, other, points[points @ directions(m, other.side)[0] > 0.0])
            if other is not one and np.any((np.abs(xi[:, 0]) < 1.02) & (np.abs(xi[:, 2]) < 1.02)):
                raise ValueError(f"the {name} and its socket {SIDES[other.side]} overlap: {remedy}")
