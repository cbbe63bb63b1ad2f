"""Coarse mesh of a ball by gmsh: second-order tetrahedra with a socket, a truncated pyramid, at every contact.

Each half of the sphere is triangulated in the plane onto which it projects from the opposite pole; sockets become holes,
and no seam is needed. The projection keeps angles, and stretches lengths by a known factor from 1/2 to 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import cos, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skfem import Mesh

from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.fem import Meshed, Quality, improve_cells
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import SIDES
from rollbench.meshes.shell import BEND, POOREST, Shell, best_mesh, fill_shell, graded_size
from rollbench.meshes.sockets import SocketMesh, SocketSize, local_points, side_socket, socket_mesh, socket_rim

Flags = NDArray[np.bool_]

#: Element sizes grow from `fine` to `coarse` between these distances from the sockets, over the ball's radius.
GROWTH = (0.072, 0.72)
#: Depth of a ball's socket over that of the groove's; least depth of its corners, over the ball's radius.
SHALLOWER, CORNER = 0.75, 0.12


@dataclass(frozen=True)
class BallSocket:
    """Socket of one side of a ball."""

    #: Flank 0 to 3 that it faces.
    side: int
    #: Socket of the groove that it faces.
    groove: SocketSize
    #: Depth below the sphere [m].
    depth: float
    #: Share of its length in which its rays pass exactly through the groove's surface.
    exact: float = 0.5


@dataclass(frozen=True)
class BallBody(Meshed):
    """Mesh of a ball about its centre, in the frame of azimuth 0; boundaries "sphere", "socket SL" and so on."""

    #: Second-order tetrahedra.
    mesh: Mesh
    #: Nodes of the inner faces of each socket, by flank.
    socket_nodes: dict[int, Index]
    #: Mesh of the sockets' faces, by flank.
    sockets: dict[int, SocketMesh]
    #: Size and quality.
    quality: Quality


def directions(m: GrooveMap, side: int) -> Array:
    """Contact frame of a flank, for a ball at azimuth 0.

    Parameters
    ----------
    m : GrooveMap
        Track.
    side : int
        Flank 0 to 3.

    Returns
    -------
    (3, 3) Array
        Rows: contact normal from the ball to the groove, direction of growing gamma, direction of growing azimuth.
    """
    sx, sz = m.signs[side]
    x3, y3, z3 = m.axes()
    c, s = cos(m.beta), sin(m.beta)
    return np.stack([sx * c * x3 + sz * s * z3, -sx * s * x3 + sz * c * z3, y3])


def rays(m: GrooveMap, socket: BallSocket, xi: Array) -> Array:
    """Rays from the ball's centre through local coordinates of a socket.

    They pass through the groove's surface at the same gamma and azimuth. Towards the ends of the socket, beyond ``exact``
    of its length, they turn into planes through the ball's centre, because the cone of rays through a section of the
    groove is concave in its middle.

    Parameters
    ----------
    m : GrooveMap
        Track.
    socket : BallSocket
        Socket of the ball.
    xi : (n, 3) Array
        Local coordinates.

    Returns
    -------
    (n, 3) Array
        Rays with a component of 1 along the contact normal.
    """
    n, t1, t2 = directions(m, socket.side)

    def flat(at: Array) -> tuple[Array, Array]:
        x = local_points(m, socket.groove, socket.side, at * [1.0, 0.0, 1.0]) - np.array([m.R, 0.0, 0.0])
        return (x @ t1) / (x @ n), (x @ t2) / (x @ n)

    line = np.linspace(-1.0, 1.0, 9)
    along = max(float(np.abs(flat(np.stack([line, 0.0 * line, end + 0.0 * line], axis=1))[1]).max()) for end in (-1.0, 1.0))
    s, t = flat(xi)
    u = np.clip((np.abs(xi[:, 2]) - socket.exact) / (1.0 - socket.exact), 0.0, 1.0)
    w = u * u * (3.0 - 2.0 * u)
    t = t * (1.0 - w) + w * along * xi[:, 2]
    return np.asarray(n[None, :] + s[:, None] * t1 + t[:, None] * t2)


def ball_points(m: GrooveMap, socket: BallSocket, xi: Array) -> Array:
    """Points of local coordinates in a ball's socket: on their rays, on the sphere at depth 0, on a plane at depth 1.

    Parameters
    ----------
    m, socket, xi
        As for `rays`.

    Returns
    -------
    (n, 3) Array
        Points from the ball's centre [m].
    """
    ray = rays(m, socket, xi)
    outer = m.ball / np.linalg.norm(ray, axis=1)
    return np.asarray(ray * (outer + xi[:, 1] * (m.ball - socket.depth - outer))[:, None])


def ball_depth(m: GrooveMap, size: SocketSize, side: int) -> float:
    """Depth of the socket of a ball: `SHALLOWER` of the groove's, or what leaves its corners `CORNER` ball radii deep.

    Parameters
    ----------
    m : GrooveMap
        Track.
    size : SocketSize
        Socket of the groove.
    side : int
        Flank 0 to 3.

    Returns
    -------
    float
        [m].
    """
    corners = np.array([[a, 0.0, b] for a in (-1.0, 1.0) for b in (-1.0, 1.0)])
    widest = float(np.linalg.norm(rays(m, BallSocket(side, size, size.depth), corners), axis=1).max())
    return max(SHALLOWER * size.depth, m.ball * (1.0 - (1.0 - CORNER) / widest))


def build_ball(
    m: GrooveMap, sockets: tuple[BallSocket, ...], fine: float, coarse: float, cuts: tuple[int, int, int] = (2, 2, 2)
) -> BallBody:
    """Mesh a ball with a socket for each contact.

    Sockets of right flanks are those of left ones turned. Two sockets that face each other closely can have rectangles of
    edges across the gap, which gmsh fills with flat cells; then every socket is divided independently, and no patch of
    the ball is a turned one.

    Parameters
    ----------
    m : GrooveMap
        Track.
    sockets : tuple[BallSocket, ...]
        Sockets of the contacts.
    fine, coarse : float
        Element sizes at the sockets and far from them [m].
    cuts : tuple[int, int, int], optional
        Subdivisions of the sockets' edges.

    Returns
    -------
    BallBody
        The mesh.

    Raises
    ------
    ValueError
        There is no socket, sockets overlap, or no attempt of gmsh gives a good mesh.
    """

    def places(side: int) -> Callable[[Array], Array]:
        like = next(socket for socket in sockets if socket.side // 2 == side // 2)
        return partial(ball_points, m, replace(like, side=side))

    _refuse_overlap(m, sockets)
    try:
        return _meshed(m, sockets, [side_socket(places, socket.side, cuts) for socket in sockets], fine, coarse)
    except ValueError:
        if not any(socket.side % 2 for socket in sockets):
            raise
    return _meshed(m, sockets, [socket_mesh(places(socket.side), cuts) for socket in sockets], fine, coarse)


def _meshed(
    m: GrooveMap, sockets: tuple[BallSocket, ...], boxes: list[tuple[SocketMesh, Array]], fine: float, coarse: float
) -> BallBody:
    """Mesh of a ball with sockets of given meshes and raised corners."""
    near = np.concatenate([ball_points(m, socket, box.xi) for socket, (box, _) in zip(sockets, boxes, strict=True)])

    def attempt(gmsh: Any, plane: int, volume: int, share: float) -> tuple[BallBody, float]:
        sizes = share * fine, share * coarse
        shell = Shell(gmsh, graded_size(near, *sizes, *(m.ball * g for g in GROWTH)), min(sizes), plane)
        corners = []
        for socket, (box, raised) in zip(sockets, boxes, strict=True):
            places = (ball_points(m, socket, xi) for xi in (box.xi, raised))
            corners.append(shell.socket(f"socket {SIDES[socket.side]}", box, *places))
        sphere(m, shell, [c[socket_rim(box)] for c, (box, _) in zip(corners, boxes, strict=True)], share)
        filled = fill_shell(shell, volume)
        box_nodes = [filled.box_nodes(c, box) for c, (box, _) in zip(corners, boxes, strict=True)]
        kept = np.concatenate(box_nodes)
        mesh, moved, quality = improve_cells(filled.named(shell), "ball", filled.on(shell.tris()), kept)
        nodes = {socket.side: n for socket, n in zip(sockets, box_nodes, strict=True)}
        meshes = {socket.side: box for socket, (box, _) in zip(sockets, boxes, strict=True)}
        body = BallBody(mesh, nodes, meshes, quality)
        return body, moved + max(0.0, POOREST - quality.smallest)

    return best_mesh("ball", attempt)


def sphere(m: GrooveMap, shell: Shell, rims: list[Index], share: float) -> None:
    """Triangulate the two halves of a sphere outside the sockets' rims.

    Parameters
    ----------
    m : GrooveMap
        Track; gives the ball's radius.
    shell : Shell
        Shell to which the faces are added.
    rims : list[Index]
        Corners around every socket.
    share : float
        Factor on the usual longest edge.
    """
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
    """Compute the normal of a plane through the ball's centre that keeps away from all contacts.

    It separates screw from nut, or left flanks from right ones.

    Parameters
    ----------
    m
        Map of the groove's coordinates.
    """
    _, t1, _ = directions(m, 3)
    n = directions(m, 3)[0]
    x3, z3 = cos(m.beta) * n - sin(m.beta) * t1, sin(m.beta) * n + cos(m.beta) * t1
    return np.asarray(x3 if m.beta <= np.pi / 4 else z3)


def _refuse_overlap(m: GrooveMap, sockets: tuple[BallSocket, ...]) -> None:
    """Raise ValueError where there is no socket, one is too deep or too wide, or two share a part of the sphere."""
    if not sockets:
        raise ValueError("a ball is meshed around its contacts: give it at least one socket")
    remedy = "make the sockets smaller (rollbench.meshes.sockets.fitted_socket finds a size that fits)"
    a, b = np.linspace(-1.0, 1.0, 41)[:-1], np.ones(40)
    around = np.concatenate([np.stack(x, 1) for x in ((a, 0 * a, -b), (b, 0 * a, a), (-a, 0 * a, b), (-b, 0 * a, -a))])
    outlines = {socket.side: ball_points(m, socket, 1.02 * around) for socket in sockets}
    for socket in sockets:
        name = f"socket {SIDES[socket.side]} of a ball of {1e3 * m.ball:.4g} mm radius"
        if not 0.0 < socket.depth < 0.8 * m.ball:
            raise ValueError(f"the {name} is {1e3 * socket.depth:.4g} mm deep: {remedy}")
        points = ball_points(m, socket, around)
        if np.linalg.norm(rays(m, socket, around), axis=1).max() * (m.ball - socket.depth) >= m.ball:
            raise ValueError(f"the {name} is wider than its depth of {1e3 * socket.depth:.4g} mm allows: {remedy}")
        if np.ptp(np.sign(points @ parting(m))) > 0.0:
            raise ValueError(f"the {name} reaches over the ball's middle: {remedy}")
        for other in sockets:
            if other is not socket and _inside(outlines[other.side], points, directions(m, other.side)).any():
                raise ValueError(f"the {name} and its socket {SIDES[other.side]} overlap: {remedy}")


def _inside(outline: Array, points: Array, frame: Array) -> Flags:
    """Mask of points ``(n, 3)`` in the cone from the ball's centre through a closed outline ``(k, 3)``.

    By the winding number in the plane onto which both project; frame: its normal and axes ``(3, 3)``.
    """
    before = points @ frame[0] > 0.0
    turn = np.zeros(len(points))
    flat = outline @ frame[1:].T / (outline @ frame[0])[:, None]
    at = points[before] @ frame[1:].T / (points[before] @ frame[0])[:, None]
    arms = flat[None] - at[:, None]
    angle = np.unwrap(np.arctan2(arms[..., 1], arms[..., 0])[:, [*range(len(flat)), 0]], axis=1)
    turn[before] = np.abs(angle[:, -1] - angle[:, 0])
    return np.asarray(turn > np.pi)
