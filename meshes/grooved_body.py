"""Coarse mesh of a screw or nut: second-order tetrahedra by gmsh, with a socket at every contact.

The surface is put together from smooth faces, each with plane coordinates in which it is known exactly: flanks in
(azimuth, gamma), lands and bores in (azimuth, z), the flat ends as they are. On a helix, flanks and lands are strips that
end at the flat ends, so nothing has to be cut open; a ring is cut open midway between two sockets. Curves are divided
once, gmsh triangulates the plane faces between them and fills the closed surface with tetrahedra, and the midpoints of
the edges on the surface are put onto it. Units inside: mm (gmsh), metres outside.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from time import perf_counter
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from meshes.groove_map import GrooveMap
from meshes.quality import TET_EDGES, Quality, arc_deviation, measure, refuse_bad, straighten, untangle
from meshes.sockets import (
    ON_GROOVE,
    SocketMesh,
    SocketSize,
    flank_limits,
    groove_lines,
    local_points,
    refuse_misfit,
    rim,
    socket_centre,
    socket_mesh,
    socket_points,
    whole_turns,
)

__all__ = ["MM", "BodySpec", "GroovedBody", "Shell", "SocketMesh", "SocketSize", "build_body", "fill", "local_points"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Placing = Callable[[Array], Array]
#: Nodes along a side of a face and their plane coordinates ``(n, 2)`` [m].
Side = tuple[Index, Array]
Body = TypeVar("Body")
MM = 1e3

#: Element sizes grow from `fine` to `coarse` between these distances from the sockets, over the ball's radius.
GROWTH = (0.18, 2.9)
#: Longest edges on curved faces over their radius: flanks; lands, bores and outsides.
BEND = (0.8, 1.1)
#: Longest edges of the smooth surface behind a groove over the wall's thickness.
WALL = 1.6
#: How fast edges grow away from the surface.
INWARD = 0.5
#: gmsh's options: no output, one thread and no other chance than its own fixed seed, sizes from faces inwards.
OPTIONS = {
    "General.Terminal": 0, "General.NumThreads": 1, "Mesh.MaxNumThreads1D": 1, "Mesh.MaxNumThreads2D": 1,
    "Mesh.MaxNumThreads3D": 1, "Mesh.RandomSeed": 1, "Mesh.RandomFactor": 1e-9, "Mesh.RandomFactor3D": 1e-12,
    "Mesh.MeshSizeExtendFromBoundary": 1, "Mesh.MeshSizeFromPoints": 0, "Mesh.MeshSizeFromCurvature": 0,
    "Mesh.Optimize": 1, "Mesh.OptimizeThreshold": 0.5,
}  # fmt: skip
#: Sine of an angle from which a triangle is sound.
SLENDER = 0.3
#: Cells below this scaled Jacobian have their edges straightened, though the surface suffers.
STRAIGHTENED = 0.01
#: What is tried in turn: gmsh's algorithms for faces (6 frontal, 5 Delaunay) and volume (1 Delaunay, 4 frontal), share of
#: the element sizes.
ATTEMPTS = ((6, 1, 1.0), (5, 1, 1.0), (6, 1, 0.85), (5, 1, 0.75), (6, 1, 0.6), (5, 4, 0.6))
#: Flanks as near as this [m] to where they should be are without fault; else the nearest of all attempts is taken.
EXACT = 1e-9
#: So are meshes without a cell of a smaller scaled Jacobian.
POOREST = 0.005


@dataclass(frozen=True)
class Curve:
    """A divided curve: nodes ``(n + 1,)``, parameters ``(n + 1,)``."""

    nodes: Index
    t: Array

    def on(self, plane: Placing) -> Side:
        """The curve as side of a face whose plane coordinates ``plane`` gives."""
        return self.nodes, plane(self.t)

    def back(self, plane: Placing) -> Side:
        """The same, backwards."""
        return self.nodes[::-1], plane(self.t[::-1])


@dataclass
class Face:
    """A triangulated face: its nodes' numbers ``(n,)`` and plane coordinates ``(n, 2)`` (a node on a seam has two), its
    triangles ``(t, 3)`` of them, points of plane coordinates (None: a socket's faces, which stay as they are)."""

    name: str
    number: Index
    plane: Array
    local: Index
    space: Placing | None

    @property
    def tris(self) -> Index:
        """Triangles ``(t, 3)`` of nodes' numbers."""
        return self.number[self.local]

    @property
    def pairs(self) -> Index:
        """Edges ``(3 t, 2)`` of the triangles."""
        return np.concatenate([self.local[:, [0, 1]], self.local[:, [1, 2]], self.local[:, [2, 0]]])

    def turn(self, first: int, second: int) -> bool:
        """Exchange the common edge of two triangles for the other diagonal, if both stay sound in the plane."""
        one, two = ([int(k) for k in self.local[t]] for t in (first, second))
        start = next((k for k in range(3) if one[k] in two and one[(k + 1) % 3] in two), None)
        if start is None:
            return False
        a, b, c = one[start], one[(start + 1) % 3], one[(start + 2) % 3]
        d = next(k for k in two if k not in (a, b))
        new = np.array([[c, a, d], [d, b, c]])
        if corner_sine(self.plane[new]).min() < min(SLENDER, 0.5 * float(corner_sine(self.plane[[one, two]]).min())):
            return False
        self.local[[first, second]] = new
        return True


def corner_sine(corners: Array) -> Array:
    """Sine of the smallest angle of triangles ``(t, 3, 2)`` in the plane; negative for one that turns right."""
    u, v, w = (corners[:, (k + 1) % 3] - corners[:, k] for k in range(3))
    long = np.sort([np.linalg.norm(x, axis=1) for x in (u, v, w)], axis=0)
    return np.asarray((u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / (long[1] * long[2]))


class Shell:
    """A closed surface under construction: nodes, divided curves, triangulated faces, exact midpoints of edges."""

    def __init__(self, gmsh: Any, size: Placing, fine: float, algorithm: int) -> None:
        """size: edge length [m] at points; fine: the smallest [m]; algorithm: gmsh's for plane faces."""
        self.gmsh, self.size, self.fine, self.algorithm = gmsh, size, fine, algorithm
        self.points = np.zeros((0, 3))
        self.faces: list[Face] = []
        self.middles: list[tuple[Index, Array]] = []
        self.raised: list[tuple[Index, Array]] = []

    def nodes(self, points: Array) -> Index:
        """Numbers of new nodes at points ``(n, 3)`` [m]."""
        first = len(self.points)
        self.points = np.concatenate([self.points, points])
        return np.arange(first, len(self.points))

    def curve(
        self, space: Placing, start: float, end: float, limit: float, ends: tuple[int, int] | None = None
    ) -> Curve:
        """Divide a curve ``space(t)``; ends: nodes there (None: a closed curve, at least five edges)."""
        t = np.linspace(start, end, 65)
        length = float(np.linalg.norm(np.diff(space(t), axis=0), axis=1).sum())
        t = np.linspace(start, end, int(np.clip(length / (0.3 * self.fine), 64, 40000)) + 1)
        x = space(t)
        steps = np.linalg.norm(np.diff(x, axis=0), axis=1) / np.minimum(self.size(0.5 * (x[1:] + x[:-1])), limit)
        total = np.concatenate([[0.0], np.cumsum(steps)])
        count = max(int(np.ceil(total[-1])), 5 if ends is None else 1)
        t = np.interp(np.linspace(0.0, total[-1], count + 1), total, t)
        inner = self.nodes(space(t[:-1] if ends is None else t[1:-1]))
        number = np.append(inner, inner[0]) if ends is None else np.array([ends[0], *inner, ends[1]])
        self.middles.append((np.stack([number[:-1], number[1:]], 1), space(0.5 * (t[1:] + t[:-1]))))
        return Curve(number, t)

    def face(
        self, name: str, loops: Sequence[Sequence[Side]], space: Placing, limit: float, stretch: Placing | None = None
    ) -> None:
        """Triangulate a face; loops: its boundary, then its holes, as sides in order; space: plane coordinates to points.

        limit: longest edge [m]; stretch: length in the plane over length in space, at plane coordinates (None: 1).
        """
        rings = [(np.concatenate([n[:-1] for n, _ in loop]), np.concatenate([x[:-1] for _, x in loop])) for loop in loops]
        own = np.concatenate([n for n, _ in rings])
        plane = np.concatenate([x for _, x in rings])

        def length(at: Array) -> float:
            found = min(float(self.size(space(at[:, :2]))[0]), limit)
            return found if stretch is None else found * float(stretch(at[:, :2])[0])

        sizes = callback(length, 0.3 * self.fine)
        tris, inner = triangulate(self.gmsh, [len(n) for n, _ in rings], plane, sizes, self.algorithm)
        number = np.concatenate([own, self.nodes(space(inner))])
        plane = np.concatenate([plane, inner])
        self.faces.append(Face(name, number, plane, tris, space))

    def socket(self, mesh: SocketMesh, points: Array, raised: Array) -> Index:
        """Add the inner faces of a socket, its nodes at ``points``, its corners ``raised`` while the volume is filled;
        returns the corners' numbers."""
        count = len(mesh.xi) - len(mesh.edges)
        number = self.nodes(points[:count])
        pairs = np.array(list(mesh.edges), dtype=np.int64)
        self.middles.append((number[pairs], points[list(mesh.edges.values())]))
        self.raised.append((number, raised))
        self.faces.append(Face("socket", number, np.zeros((count, 2)), mesh.triangles[:, :3], None))
        return number

    def tris(self, name: str = "") -> Index:
        """Triangles ``(t, 3)`` of all faces, or of those of that name."""
        return np.concatenate([f.tris for f in self.faces if name in ("", f.name)])

    def exact(self) -> tuple[Index, Array]:
        """Edges ``(k, 2)`` of the surface and their exact midpoints ``(k, 3)`` [m]; first those of the curves."""
        own = [(f.number[f.pairs], f.space(f.plane[f.pairs].mean(axis=1))) for f in self.faces if f.space is not None]
        edges, points = zip(*self.middles, *own, strict=True)
        return np.concatenate(edges), np.concatenate(points)


def callback(length: Callable[[Array], float], grain: float) -> Callable[..., float]:
    """Answers to gmsh's question for sizes: ``length`` at a point ``(1, 3)`` [m], once for every cube of edge grain [m]."""
    known = dict[tuple[int, int, int], float]()
    inverse = 1.0 / (MM * grain)

    def answer(_dim: int, _tag: int, x: float, y: float, z: float, lc: float) -> float:
        key = (round(x * inverse), round(y * inverse), round(z * inverse))
        if key not in known:
            known[key] = MM * length(grain * np.array([key]))
        return min(known[key], lc)

    return answer


def triangulate(
    gmsh: Any, counts: Sequence[int], plane: Array, sizes: Callable[..., float], algorithm: int
) -> tuple[Index, Array]:
    """Triangles of a plane region without new nodes on its boundary, and its inner nodes ``(k, 2)``.

    counts: nodes of each closed loop, the outer one first; plane: the nodes, loop after loop ``(n, 2)`` [m]; sizes: answers
    gmsh's question for them. The triangles count the boundary's nodes first and turn left.
    """
    gmsh.model.add("face")
    geo, mesh = gmsh.model.geo, gmsh.model.mesh
    for x, y in MM * plane:
        geo.addPoint(x, y, 0.0)
    wires, first = [], 1
    for count in counts:
        lines = [geo.addLine(first + k, first + (k + 1) % count) for k in range(count)]
        for line in lines:
            geo.mesh.setTransfiniteCurve(line, 2)
        wires.append(geo.addCurveLoop(lines))
        first += count
    face = geo.addPlaneSurface(wires)
    geo.synchronize()
    gmsh.option.setNumber("Mesh.Algorithm", algorithm)
    mesh.setSizeCallback(sizes)
    mesh.generate(2)
    mesh.removeSizeCallback()
    tags, xyz, _ = mesh.getNodes(2, face)
    boundary, at, _ = mesh.getNodes(0, -1)
    inner = xyz.reshape(-1, 3)[:, :2] / MM
    if len(boundary) != len(plane) or not np.allclose(at.reshape(-1, 3)[:, :2], MM * plane, atol=1e-9):
        raise ValueError("gmsh changed the boundary of a face")
    number = np.full(int(max(tags.max(initial=0), boundary.max())) + 1, -1, dtype=np.int64)
    number[boundary.astype(np.int64)] = np.arange(len(plane))
    number[tags.astype(np.int64)] = len(plane) + np.arange(len(tags))
    _, corners = mesh.getElementsByType(2)
    tris = number[corners.astype(np.int64)].reshape(-1, 3)
    gmsh.model.remove()
    a, b, c = (np.concatenate([plane, inner])[tris[:, k]] for k in range(3))
    turned = (b - a)[:, 0] * (c - a)[:, 1] < (b - a)[:, 1] * (c - a)[:, 0]
    tris[turned] = tris[turned][:, [0, 2, 1]]
    return tris, inner


def tetrahedra(
    gmsh: Any, points: Array, tris: Index, sizes: Callable[..., float], algorithm: int
) -> tuple[Index, Array]:
    """Tetrahedra inside a closed triangulated surface, which they keep, and the inner nodes ``(k, 3)`` [m].

    Raises ValueError where the surface is not closed.
    """
    edges = np.sort(np.concatenate([tris[:, [0, 1]], tris[:, [1, 2]], tris[:, [2, 0]]]), axis=1)
    if np.any(np.unique(edges, axis=0, return_counts=True)[1] != 2):
        raise ValueError("the surface is not closed")
    gmsh.model.add("volume")
    surface = gmsh.model.addDiscreteEntity(2)
    count = len(points)
    gmsh.model.mesh.addNodes(2, surface, np.arange(1, count + 1), (MM * points).ravel())
    gmsh.model.mesh.addElementsByType(surface, 2, [], (tris + 1).ravel())
    gmsh.model.geo.addVolume([gmsh.model.geo.addSurfaceLoop([surface])])
    gmsh.model.geo.synchronize()
    gmsh.option.setNumber("Mesh.Algorithm3D", algorithm)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.model.mesh.setSizeCallback(sizes)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.removeSizeCallback()
    tags, xyz, _ = gmsh.model.mesh.getNodes(3, -1)
    number = np.full(int(max(tags.max(initial=0), count)) + 1, -1, dtype=np.int64)
    number[1 : count + 1] = np.arange(count)
    number[tags.astype(np.int64)] = count + np.arange(len(tags))
    _, corners = gmsh.model.mesh.getElementsByType(4)
    cells = number[corners.astype(np.int64)].reshape(-1, 4)
    gmsh.model.remove()
    if not len(cells):
        raise ValueError("gmsh left the volume empty")
    return cells, xyz.reshape(-1, 3) / MM


@dataclass(frozen=True)
class Filled:
    """Points ``(n, 3)`` [m] and second-order tetrahedra ``(m, 10)`` in a shell; keys of the edges in order, their first
    midpoint's number, the number of corners."""

    points: Array
    cells: Index
    keys: Index
    corners: int

    def middle(self, pairs: Index) -> Index:
        """Nodes in the middle of edges, by their corners ``(k, 2)``."""
        keys = np.sort(pairs, axis=1) @ np.array([self.corners, 1])
        return np.asarray(self.corners + np.searchsorted(self.keys, keys))

    def box_nodes(self, corners: Index, box: SocketMesh) -> Index:
        """Nodes of a socket's faces in the order of ``box``, from those of its corners."""
        return np.concatenate([corners, self.middle(corners[np.array(list(box.edges), dtype=np.int64)])])

    def on(self, tris: Index) -> Index:
        """All nodes of triangles ``(t, 3)`` of the surface, ascending."""
        pairs = np.concatenate([tris[:, [0, 1]], tris[:, [1, 2]], tris[:, [2, 0]]])
        return np.unique(np.concatenate([tris.ravel(), self.middle(pairs)]))


def turned_right(points: Array, cells: Index) -> Index:
    """Tetrahedra ``(m, 4)`` with positive volume."""
    a, b, c, d = (points[cells[:, k]] for k in range(4))
    turned = np.einsum("ni,ni->n", np.cross(b - a, c - a), d - a) < 0.0
    return np.where(turned[:, None], cells[:, [0, 2, 1, 3]], cells)


def freed(shell: Shell, points: Array, cells: Index) -> Index:
    """Tetrahedra without flat ones on the surface; the shell's triangles are changed to match.

    A cell with two triangles of the same smooth face has no volume along their common edge once that is bent. It is left
    out, and the two triangles are exchanged for its other two.
    """
    base = np.array([len(points) ** 2, len(points), 1])
    for _ in range(6):
        keys = np.concatenate([np.sort(f.tris, axis=1) @ base for f in shell.faces])
        face = np.concatenate([np.full(len(f.local), -1 if f.space is None else k) for k, f in enumerate(shell.faces)])
        row = np.concatenate([np.arange(len(f.local)) for f in shell.faces])
        order = np.argsort(keys)
        sides = np.stack([np.sort(np.delete(cells, k, axis=1), axis=1) @ base for k in range(4)], axis=1)
        place = order[np.minimum(np.searchsorted(keys, sides, sorter=order), len(keys) - 1)]
        own = np.where(keys[place] == sides, face[place], -1 - np.arange(4))  # the face opposite each corner
        edges = set(np.concatenate([np.sort(f.number[f.pairs], axis=1) @ base[1:] for f in shell.faces]).tolist())
        pairs = [(i, j) for i in range(4) for j in range(i)]
        alike = np.stack([(own[:, i] == own[:, j]) & (own[:, i] >= 0) for i, j in pairs], axis=1)
        gone, changed = [], set[tuple[int, int]]()
        for number in np.flatnonzero(alike.any(axis=1)):
            ends = list(pairs[int(alike[number].argmax())])
            which, rows = int(own[number, ends[0]]), [int(k) for k in row[place[number, ends]]]
            both = {(which, k) for k in rows}
            fresh = int(np.sort(cells[number, ends]) @ base[1:]) not in edges and not changed & both
            if fresh and shell.faces[which].turn(rows[0], rows[1]):
                changed |= both
                gone.append(number)
        if not gone:
            break
        cells = np.delete(cells, gone, axis=0)
    return cells


def fill(shell: Shell, algorithm: int) -> Filled:
    """Second-order tetrahedra inside a shell, growing away from it. Raises ValueError for an open shell."""
    points = shell.points.copy()
    for number, place in shell.raised:
        points[number] = place
    tris = shell.tris()
    ends = np.concatenate([tris[:, [0, 1]], tris[:, [1, 2]], tris[:, [2, 0]]])
    long = np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
    near = np.bincount(ends[:, 0], long) / np.bincount(ends[:, 0])
    tree = cKDTree(points)

    def length(x: Array) -> float:
        distance, node = tree.query(x[0])
        return float(min(shell.size(x)[0], near[node] + INWARD * distance))

    cells, inner = tetrahedra(shell.gmsh, points, tris, callback(length, 0.6 * shell.fine), algorithm)
    cells = turned_right(np.concatenate([points, inner]), cells)
    corners = np.concatenate([shell.points, inner])
    cells = freed(shell, corners, cells)
    used = np.zeros(len(corners), dtype=bool)
    used[: len(shell.points)] = True
    used[cells] = True
    cells, corners = (np.cumsum(used) - 1)[cells], corners[used]
    pairs = np.sort(cells[:, np.array(TET_EDGES)].reshape(-1, 2), axis=1)
    count = len(corners)
    keys, inverse = np.unique(pairs @ np.array([count, 1]), return_inverse=True)
    middle = corners[np.stack(np.divmod(keys, count), 1)].mean(axis=1)
    edges, exact = shell.exact()
    known, first = np.unique(np.sort(edges, axis=1) @ np.array([count, 1]), return_index=True)
    where = np.searchsorted(keys, known)
    if not np.array_equal(keys[np.minimum(where, len(keys) - 1)], known):
        raise ValueError("gmsh lost an edge of the surface")
    middle[where] = exact[first]
    ten = np.concatenate([cells, count + inverse.reshape(-1, 6)], axis=1)
    return Filled(np.concatenate([corners, middle]), ten, keys, count)


def graded(near: Array, fine: float, coarse: float, first: float, last: float) -> Placing:
    """Edge length [m] at points: fine up to a distance ``first`` from any of ``near`` ``(k, 3)``, coarse from ``last``."""
    if not len(near):
        return lambda x: np.full(len(x), coarse)
    tree = cKDTree(near)

    def size(x: Array) -> Array:
        share = (tree.query(x)[0] - first) / (last - first)
        return np.asarray(fine + (coarse - fine) * np.clip(share, 0.0, 1.0))

    return size


def best_of(name: str, attempt: Callable[[Any, int, int, float], tuple[Body, float]]) -> Body:
    """First mesh without fault of gmsh's algorithms and sizes in turn, or else that with the smallest fault.

    attempt: mesh and its fault, by gmsh, algorithm for faces, for the volume, share of the sizes. Raises ValueError where
    no attempt gives a mesh.
    """
    import gmsh

    failures: list[str] = []
    found: list[tuple[Body, float]] = []
    for plane, volume, share in ATTEMPTS:
        gmsh.initialize(readConfigFiles=False, interruptible=False)
        try:
            for option, value in OPTIONS.items():
                gmsh.option.setNumber(option, value)
            found.append(attempt(gmsh, plane, volume, share))
        except Exception as error:  # gmsh raises nothing more special
            failures.append(str(error).strip())
        finally:
            gmsh.finalize()
        if found and found[-1][1] == 0.0:
            break
    if not found:
        raise ValueError(f"gmsh finds no good mesh of the {name}: " + "; ".join(dict.fromkeys(failures)))
    return min(found, key=lambda x: x[1])[0]


@dataclass(frozen=True)
class BodySpec:
    """A grooved tube between radii r_in < r_out [m] and flat ends z_low < z_high [m] (z absolute); r_in = 0: no bore.

    outer: whether the groove is cut from outside (screw) or from inside (nut); sockets: (azimuth of the ball's section
    including its start [rad], z of the ball [m], side) of every contact; fine, coarse: element sizes near and away from
    the sockets [m].
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


@dataclass(frozen=True)
class GroovedBody:
    """Mesh: points ``(n, 3)`` [m], second-order tetrahedra ``(m, 10)``; per socket the nodes of its inner faces in the
    order of its side's ``sockets`` mesh ``(count, k)``; nodes of the flat ends; largest distance [m] of the flanks' nodes,
    the sockets' rims among them, from the exact flanks; seconds it took; nodes of the cylinder r = r_out; quality."""

    points: Array
    cells: Index
    socket_nodes: Index
    sockets: dict[int, SocketMesh]
    low_end: Index
    high_end: Index
    deviation: float
    seconds: float
    side: Index
    quality: Quality


def cylindrical(r: float | Array, phi: float | Array, z: float | Array) -> Array:
    """Points ``(n, 3)`` of cylindrical coordinates."""
    return np.stack(np.broadcast_arrays(r * np.cos(phi), r * np.sin(phi), z), axis=-1).astype(float)


@dataclass(frozen=True)
class Groove:
    """Section of a body's groove: map, sides of its flanks, radii of land and of the smooth surface behind [m], angles
    gamma of apex and edge [rad], half opening along z [m], thickness of the wall under the groove [m]."""

    m: GrooveMap
    sides: tuple[int, int]
    land: float
    behind: float
    apex: float
    edge: float
    half: float
    wall: float

    @staticmethod
    def of(m: GrooveMap, spec: BodySpec) -> Groove:
        """Groove of a body. Raises ValueError where it leaves no land or no wall."""
        sides = (0, 1) if spec.outer else (2, 3)
        land, behind = (spec.r_out, spec.r_in) if spec.outer else (spec.r_in, spec.r_out)
        apex, edge = flank_limits(m, sides[1], land)
        gamma = np.linspace(apex, edge, 65)
        r, zeta, _ = m.unroll(*m.section(sides[1], gamma, np.full(65, m.radius[sides[1]])))
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
        if not pitch and (m.z0 - zeta.max() <= spec.z_low or m.z0 + zeta.max() >= spec.z_high):
            raise ValueError(
                f"the groove is {2e3 * zeta.max():.4g} mm wide, the ring only {1e3 * (spec.z_high - spec.z_low):.4g} mm: "
                "widen the ring or put its middle at the groove"
            )
        return Groove(m, sides, land, behind, apex, edge, float(zeta[-1]), wall)

    def profile(self, side: int, gamma: Array) -> tuple[Array, Array]:
        """Radius [m] and zeta [m] of a flank at angles gamma."""
        r, zeta, _ = self.m.unroll(*self.m.section(side, gamma, np.full(gamma.shape, self.m.radius[side])))
        return r, zeta


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


class Surface:
    """The surface of a grooved body in a shell; plane coordinates are (azimuth, gamma) or (azimuth, z)."""

    def __init__(self, shell: Shell, m: GrooveMap, spec: BodySpec, share: float = 1.0) -> None:
        """Divide and triangulate all of it; ``corners``: of every socket, in the order of ``spec.sockets``; share: of the
        usual longest edges on curved faces."""
        self.shell, self.m, self.spec = shell, m, spec
        self.groove = Groove.of(m, spec)
        self.z = (spec.z_low, spec.z_high)
        kinds = {s: socket_mesh(partial(local_points, m, spec.size, s), spec.size.cuts) for s in self.groove.sides}
        self.boxes = {side: kinds[side][0] for side in sorted({s for _, _, s in spec.sockets})}
        self.corners = []
        for socket in spec.sockets:
            box, raised = kinds[socket[2]]
            places = (socket_points(m, spec.size, socket, x) for x in (box.xi, raised))
            self.corners.append(shell.socket(box, *places))
        self.flank_limit = share * BEND[0] * float(m.radius[self.groove.sides[0]])
        self.bend = share * BEND[1]
        self.start = widest_gap(spec)
        self._ends(self._helix() if m.rg else self._ring())

    def _holes(self, side: int, line: float) -> list[list[Side]]:
        """Rims of the sockets on a flank of a groove line."""
        m, spec = self.m, self.spec
        holes = []
        for corners, (phi, z, own) in zip(self.corners, spec.sockets, strict=True):
            turns, off = whole_turns(m, phi, z, line)
            if own != side or off > ON_GROOVE * m.ball:
                continue
            top = rim(self.boxes[side])
            top = np.append(top, top[0])
            xi = self.boxes[side].xi[top]
            middle = phi + 2.0 * np.pi * turns + socket_centre(m, side)[2]
            if not m.rg:
                middle = self.start + np.mod(middle - self.start, 2.0 * np.pi)
            at = np.stack([middle + spec.size.phi * xi[:, 2], m.beta + spec.size.gamma * xi[:, 0]], axis=1)
            holes.append([(corners[top], at)])
        return holes

    def _flank(self, side: int, line: float, boundary: list[Side]) -> None:
        """Triangulate a flank of a groove line; the plane keeps angles best if azimuths count from the balls' sections."""
        m = self.m
        scale = np.array([np.hypot(m.rg, socket_centre(m, side)[0]), float(m.radius[side])])

        def turn(gamma: Array) -> Array:
            return m.unroll(*m.section(side, gamma, np.full(gamma.shape, m.radius[side])))[2]

        def laid(x: Array) -> Array:
            return scale * np.stack([x[:, 0] - turn(x[:, 1]), x[:, 1]], axis=1)

        def space(plane: Array) -> Array:
            along, gamma = (plane / scale).T
            phi = along + turn(gamma)
            r, zeta = self.groove.profile(side, gamma)
            return cylindrical(r, phi, line + zeta + m.rg * phi)

        loops = [[(n, laid(x)) for n, x in loop] for loop in (boundary, *self._holes(side, line))]
        self.shell.face(f"flank {side}", loops, space, self.flank_limit)

    def _cylinder(self, name: str, r: float, boundary: list[Side], limit: float) -> None:
        """Triangulate a face of constant radius."""
        scale = np.array([r, 1.0])
        loop = [(n, x * scale) for n, x in boundary]
        self.shell.face(name, [loop], lambda x: cylindrical(r, x[:, 0] / r, x[:, 1]), limit)

    def _circle(self, r: float, z: float, limit: float) -> Curve:
        return self.shell.curve(circle(r, z), self.start, self.start + 2.0 * np.pi, limit)

    def _around(self, low: Curve, high: Curve, at: tuple[float, float], seam: Placing, limit: float) -> list[Side]:
        """Sides of a face between two circles at second coordinates ``at``, cut open along the curve ``seam``."""
        cut = self.shell.curve(seam, *at, limit, (int(low.nodes[0]), int(high.nodes[0])))
        begin, end = upright(self.start), upright(self.start + 2.0 * np.pi)
        return [low.on(level(at[0])), cut.on(end), high.back(level(at[1])), cut.back(begin)]

    def _tube(self, name: str, r: float, low: Curve, high: Curve, z: tuple[float, float], limit: float) -> None:
        """A closed cylinder between two circles."""
        seam = self._around(low, high, z, lambda t: cylindrical(r, self.start, t), limit)
        self._cylinder(name, r, seam, limit)

    def _ends(self, bounds: list[list[Side]]) -> None:
        """The smooth surface behind the groove, if any, and the flat ends; bounds: their loops at the groove's side."""
        r = self.groove.behind
        loops = [[bound] for bound in bounds]
        if r > 0.0:
            limit = min(self.bend * r, max(WALL * self.groove.wall, self.shell.fine))
            circles = [self._circle(r, z, limit) for z in self.z]
            self._tube("behind", r, circles[0], circles[1], self.z, limit)
            for loop, ring in zip(loops, circles, strict=True):
                loop.insert(1 if self.spec.outer else 0, [ring.on(seen(r))])
        for name, z, loop in zip(("low", "high"), self.z, loops, strict=True):
            self.shell.face(name, loop, flat(z), np.inf)

    def _ring(self) -> list[list[Side]]:
        """Flanks and lands of a ring; returns the land's circles at both ends."""
        g, line = self.groove, self.m.z0
        limit = self.bend * g.land
        circles = [self._circle(g.land, z, limit) for z in self.z]
        left, right = (self._circle(g.land, line + sign * g.half, min(limit, self.flank_limit)) for sign in (-1.0, 1.0))
        self._tube("land", g.land, circles[0], left, (self.z[0], line - g.half), limit)
        self._tube("land", g.land, right, circles[1], (line + g.half, self.z[1]), limit)
        r, zeta = g.profile(g.sides[0], np.array([g.apex]))
        apex = self._circle(float(r[0]), line + float(zeta[0]), min(limit, self.flank_limit))
        for side, edge in zip(g.sides, (left, right), strict=True):

            def seam(gamma: Array, side: int = side) -> Array:
                r, zeta = g.profile(side, gamma)
                return cylindrical(r, self.start, line + zeta)

            self._flank(side, line, self._around(apex, edge, (g.apex, g.edge), seam, self.flank_limit))
        return [[c.on(seen(g.land))] for c in circles]

    def _helix(self) -> list[list[Side]]:
        """Flanks and lands of all starts; returns the loops around both ends."""
        g, rg, lines = self.groove, self.m.rg, groove_lines(self.m)
        threads = [Thread(self.shell, g, line, self.z, min(self.flank_limit, self.bend * g.land)) for line in lines]
        pitch = 2.0 * np.pi * abs(rg) / self.m.starts
        arcs = []
        for k, own in enumerate(threads):
            for place, side in enumerate(g.sides):
                self._flank(side, own.line, own.flank(place))
            following = threads[(k - 1 if rg > 0.0 else k + 1) % len(threads)]
            near, far = rail(own.line, g.half, rg), rail(own.line, pitch - g.half, rg)
            pair = []
            for end, z in zip((0, -1), self.z, strict=True):
                begin, stop = (float(x(np.array([z]))[0, 0]) for x in (near, far))
                ends = int(own.rails[2].nodes[end]), int(following.rails[0].nodes[end])
                pair.append(self.shell.curve(circle(g.land, z), begin, stop, self.bend * g.land, ends))
            low, high = pair[0].on(level(self.z[0])), pair[1].back(level(self.z[1]))
            boundary = [low, following.rails[0].on(far), high, own.rails[2].back(near)]
            self._cylinder("land", g.land, boundary, self.bend * g.land)
            arcs.append(pair)
        return [self._bound(threads, [pair[end] for pair in arcs], end) for end in (0, 1)]

    def _bound(self, threads: list[Thread], arcs: list[Curve], end: int) -> list[Side]:
        """Loop around a flat end: out of a groove, along the land, into the next groove."""
        g, step = self.groove, -1 if self.m.rg > 0.0 else 1
        loop, k = [], 0
        for _ in threads:
            n = (k + step) % len(threads)
            loop += [
                threads[k].cuts[1][end].on(threads[k].flat(1, end)),
                arcs[k].on(seen(g.land)),
                threads[n].cuts[0][end].back(threads[n].flat(0, end)),
            ]
            k = n
        return loop


class Thread:
    """Curves of one start's groove: rails along left edge, apex and right edge; cuts of both flanks by both ends."""

    def __init__(self, shell: Shell, groove: Groove, line: float, z: tuple[float, float], limit: float) -> None:
        """Divide them; line: z - rg phi of the groove [m]."""
        self.groove, self.line, self.z = groove, line, z
        r, zeta = groove.profile(groove.sides[0], np.array([groove.apex]))
        places = ((groove.land, -groove.half), (float(r[0]), float(zeta[0])), (groove.land, groove.half))
        self.zeta = [p[1] for p in places]
        self.rails = []
        for radius, height in places:

            def space(t: Array, radius: float = radius, height: float = height) -> Array:
                return cylindrical(radius, (t - line - height) / groove.m.rg, t)

            first, last = shell.nodes(space(np.array(z)))
            self.rails.append(shell.curve(space, *z, limit, (int(first), int(last))))
        self.cuts = [
            [
                shell.curve(
                    self._space(place, end), groove.apex, groove.edge, limit,
                    (int(self.rails[1].nodes[-end]), int(self.rails[2 * place].nodes[-end])),
                )
                for end in (0, 1)
            ]
            for place in (0, 1)
        ]  # fmt: skip

    def _azimuth(self, place: int, end: int, gamma: Array) -> tuple[Array, Array]:
        r, zeta = self.groove.profile(self.groove.sides[place], gamma)
        return r, (self.z[end] - self.line - zeta) / self.groove.m.rg

    def _space(self, place: int, end: int) -> Placing:
        """Points of the cut of a flank (0 left, 1 right) by an end (0 low, 1 high) at angles gamma."""
        return lambda gamma: cylindrical(*self._azimuth(place, end, gamma), self.z[end])

    def flat(self, place: int, end: int) -> Placing:
        """The same in the plane of the end."""
        return lambda gamma: self._space(place, end)(gamma)[:, :2]

    def flank(self, place: int) -> list[Side]:
        """Boundary of a flank in (azimuth, gamma)."""
        g = self.groove

        def cut(end: int) -> Placing:
            return lambda gamma: np.stack([self._azimuth(place, end, gamma)[1], gamma], axis=1)

        apex, edge = (rail(self.line, self.zeta[k], g.m.rg, at) for k, at in ((1, g.apex), (2 * place, g.edge)))
        low, high = self.cuts[place]
        return [low.on(cut(0)), self.rails[2 * place].on(edge), high.back(cut(1)), self.rails[1].back(apex)]


def widest_gap(spec: BodySpec) -> float:
    """Azimuth [rad] midway between the two neighbouring sockets farthest apart, seen along the axis; 0 without sockets."""
    if not spec.sockets:
        return 0.0
    phi = np.sort(np.mod([p for p, _, _ in spec.sockets], 2.0 * np.pi))
    gaps = np.diff(np.append(phi, phi[0] + 2.0 * np.pi))
    k = int(np.round(gaps, 9).argmax())
    return float(phi[k] + 0.5 * gaps[k])


def build_body(m: GrooveMap, spec: BodySpec) -> GroovedBody:
    """Mesh a grooved body. Raises ValueError where a socket does not fit or no attempt gives a good mesh."""
    begin = perf_counter()
    land, behind = (spec.r_out, spec.r_in) if spec.outer else (spec.r_in, spec.r_out)
    refuse_misfit(m, spec.size, spec.sockets, land, behind, (spec.z_low, spec.z_high))
    Groove.of(m, spec)
    xi = np.array(list(product((-1.0, 0.0, 1.0), (0.0, 0.5, 1.0), (-1.0, 0.0, 1.0))))
    near = np.concatenate([np.zeros((0, 3)), *(socket_points(m, spec.size, socket, xi) for socket in spec.sockets)])

    def attempt(gmsh: Any, plane: int, volume: int, share: float) -> tuple[GroovedBody, float]:
        sizes = share * spec.fine, share * spec.coarse
        shell = Shell(gmsh, graded(near, *sizes, *(m.ball * g for g in GROWTH)), min(sizes), plane)
        surface = Surface(shell, m, spec, share)
        body = _collected(surface, fill(shell, volume), begin)
        off = body.deviation / m.ball if body.deviation > EXACT else 0.0
        return body, off + max(0.0, POOREST - body.quality.smallest)

    return best_of("screw" if spec.outer else "nut", attempt)


def _collected(surface: Surface, filled: Filled, begin: float) -> GroovedBody:
    """The mesh and the numbers of its named nodes; edges that would turn cells inside out are straightened."""
    m, spec, shell = surface.m, surface.spec, surface.shell
    named = {name: filled.on(shell.tris(name)) for name in {f.name for f in shell.faces}}
    places = zip(surface.corners, spec.sockets, strict=True)
    rows = [filled.box_nodes(corners, surface.boxes[side]) for corners, (_, _, side) in places]
    sockets = np.array(rows, dtype=np.int64).reshape(len(rows), -1 if rows else 0)
    points = untangle(filled.points, filled.cells, filled.on(shell.tris()))
    points, _ = straighten(points, filled.cells, sockets, STRAIGHTENED)
    quality = measure(points, filled.cells, "P2")
    refuse_bad(quality, "screw" if spec.outer else "nut")
    deviation = max(_flank_deviation(m, s, points[named[f"flank {s}"]]) for s in surface.groove.sides)
    return GroovedBody(
        points, filled.cells, sockets, surface.boxes, named["low"], named["high"], deviation, perf_counter() - begin,
        named["land" if spec.outer else "behind"], quality,
    )  # fmt: skip


def _flank_deviation(m: GrooveMap, side: int, points: Array) -> float:
    """Largest distance [m] of points from a flank."""
    r, zeta = np.hypot(points[:, 0], points[:, 1]), points[:, 2] - m.z0
    if m.rg:
        zeta = zeta - m.rg * (np.arctan2(points[:, 1], points[:, 0]) - m.phase)
        pitch = 2.0 * np.pi * abs(m.rg) / m.starts
        zeta = zeta - pitch * np.round(zeta / pitch)
    return arc_deviation(*m.roll(r, zeta), m.centre[side], float(m.radius[side]))
