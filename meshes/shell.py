"""Mesh a body whose faces are known exactly: gmsh triangulates the faces and fills the body with second-order tetrahedra.

Each curve between two faces is divided once. gmsh triangulates the faces in plane coordinates and fills the closed surface
with tetrahedra. Then the midside nodes on the surface are moved onto the exact surface. Lengths are in metres; only gmsh
gets millimetres.

gmsh has one global state for each process: `gmsh_session` initialises it without output and finalises it after errors too.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import product
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
from scipy.spatial import cKDTree
from skfem import Mesh, MeshTet1

from rollbench.meshes import fem
from rollbench.meshes.arrays import Array, Index
from rollbench.meshes.sockets import RefinementBoxFaces

#: Names of the signals whose handlers gmsh replaces by the default handlers of the operating system.
RESET = ("SIGHUP", "SIGQUIT", "SIGPIPE", "SIGTERM")


@contextmanager
def gmsh_session(options: Mapping[str, float] = MappingProxyType({})) -> Iterator[Any]:
    """Initialise gmsh for a ``with`` block, set its options, and finalise it at the end of the block.

    If gmsh is initialised already, only the options are set, and gmsh is not finalised.

    The signal handlers of this process, which gmsh replaces, are restored. With gmsh's handlers, SIGTERM would end the
    process before it has cleaned up, SIGHUP would end it in spite of nohup, and SIGPIPE without a message. Only the main
    thread can restore handlers.

    Parameters
    ----------
    options : Mapping[str, float], optional
        Values of gmsh's options, by the option's name.

    Yields
    ------
    module
        The module gmsh.

    Raises
    ------
    ImportError
        The package gmsh, or a system library that it needs, is missing.
    """
    try:
        import gmsh
    except (ImportError, OSError) as error:
        raise ImportError(
            f"gmsh cannot be loaded ({error}); install rollbench[reference]; rollbench doctor names the system libraries",
            name="gmsh",
        ) from error
    started = not gmsh.isInitialized()
    if started:
        numbers = [getattr(signal, name) for name in RESET if hasattr(signal, name)]
        before = {number: signal.getsignal(number) for number in numbers}
        gmsh.initialize(readConfigFiles=False, interruptible=False)
        if threading.current_thread() is threading.main_thread():
            for number, handler in before.items():
                if handler is not None:  # None: the handler was not installed from Python
                    signal.signal(number, handler)
    try:
        for name, value in ({"General.Terminal": 0} | dict(options)).items():
            gmsh.option.setNumber(name, value)
        yield gmsh
    finally:
        if started:
            gmsh.finalize()


def set_element_size_formula(gmsh: Any, formula: str) -> None:
    """Make gmsh use the edge lengths that a formula of x, y, z gives, and disable its other rules for element sizes."""
    fields = gmsh.model.mesh.field
    size = fields.add("MathEval")
    fields.setString(size, "F", formula)
    fields.setAsBackgroundMesh(size)
    for name in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
        gmsh.option.setNumber(f"Mesh.{name}", 0)


def take_nodes_and_cells(gmsh: Any, element_type: int, nodes_per_cell: int) -> tuple[Array, Index]:
    """Return the mesh of gmsh's current model, and remove the model.

    Parameters
    ----------
    gmsh : Any
        The module gmsh, in a `gmsh_session`.
    element_type : int
        gmsh's number of the element type.
    nodes_per_cell : int
        Number of nodes of this element type.

    Returns
    -------
    points : (n, 3) Array
        Coordinates of all nodes of the model.
    cells : (m, nodes_per_cell) Index
        Nodes of the cells of this type, in gmsh's order.
    """
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    ascending = np.argsort(tags)
    cells = number_elements(gmsh, element_type, tags[ascending], nodes_per_cell)
    gmsh.model.remove()
    return xyz.reshape(-1, 3)[ascending], cells


def number_elements(gmsh: Any, element_type: int, tags: Array, nodes_per_element: int, entity: int = -1) -> Index:
    """Return the nodes of gmsh's elements of one type, numbered by their places in a list of node tags.

    Parameters
    ----------
    gmsh : Any
        The module gmsh, in a `gmsh_session`.
    element_type : int
        gmsh's number of the element type.
    tags : (n,) Array
        gmsh's tags of the nodes, in the order in which they are numbered from 0.
    nodes_per_element : int
        Number of nodes of this element type.
    entity : int, default -1
        Number of the curve, surface or volume whose elements are returned; -1: all.

    Returns
    -------
    (m, nodes_per_element) Index
        Nodes of the elements.
    """
    number = np.full(int(tags.max(initial=0)) + 1, -1, dtype=np.int64)
    number[tags.astype(np.int64)] = np.arange(len(tags))
    nodes = gmsh.model.mesh.getElementsByType(element_type, entity)[1]
    return np.asarray(number[nodes.astype(np.int64)].reshape(-1, nodes_per_element))


#: Function that maps an array of coordinates or parameters to an array of coordinates or lengths.
Placing = Callable[[Array], Array]

#: One segment of the boundary of a face: its nodes in order, and their plane coordinates ``(n, 2)`` [m].
Side = tuple[Index, Array]

Body = TypeVar("Body")

#: Millimetres per metre: factor on lengths for gmsh.
MM = 1e3

#: Distances from the refinement boxes between which the element size grows from the fine to the coarse size, as ratios to
#: the ball's radius.
GROWTH = (0.18, 2.9)

#: Longest edges on curved faces, as ratios to the face's radius: on flanks; on lands, bores and outer surfaces.
BEND = (1.2, 1.1)

#: Longest edges on the smooth surface behind a groove, as a ratio to the wall's thickness.
WALL = 1.6

#: Increase of the edge length of tetrahedra per unit of distance from the body's surface.
INWARD = 0.5

#: Number of cubes along x, y and z for which gmsh's size callback evaluates sizes at once: on faces, and in volumes.
FACE_BLOCK, VOLUME_BLOCK = (12, 12, 1), (4, 4, 4)

#: gmsh's options: one thread and a fixed seed for reproducible meshes; element sizes extend from the faces inwards.
OPTIONS = {
    "General.NumThreads": 1,
    "Mesh.MaxNumThreads1D": 1,
    "Mesh.MaxNumThreads2D": 1,
    "Mesh.MaxNumThreads3D": 1,
    "Mesh.RandomSeed": 1,
    "Mesh.RandomFactor": 1e-9,
    "Mesh.RandomFactor3D": 1e-12,
    "Mesh.MeshSizeExtendFromBoundary": 1,
    "Mesh.MeshSizeFromPoints": 0,
    "Mesh.MeshSizeFromCurvature": 0,
    "Mesh.Optimize": 1,
    "Mesh.OptimizeThreshold": 0.5,
}

#: A triangle counts as well shaped if the sine of its smallest angle is at least this.
SLENDER = 0.3

#: Attempts at meshing, in this order: gmsh's algorithm for faces (6 frontal, 5 Delaunay), its algorithm for the volume
#: (1 Delaunay, 4 frontal), and a factor on the element sizes.
ATTEMPTS = ((6, 1, 1.0), (5, 1, 1.0), (6, 1, 0.85), (5, 1, 0.75), (6, 1, 0.6), (5, 4, 0.6))

#: Deviation of the flanks from the exact surface [m] up to which a mesh counts as exact.
EXACT = 1e-9

#: Smallest scaled Jacobian from which a mesh counts as free of faults.
POOREST = 0.005


@dataclass(frozen=True)
class DividedCurve:
    """A curve on the surface of a body, divided into n edges of a triangle mesh."""

    #: Numbers of the n + 1 nodes along the curve, in order; the first and last are the same for a closed curve.
    nodes: Index
    #: Values of the curve's parameter at these nodes ``(n + 1,)``.
    parameters: Array

    def side(self, plane: Placing) -> Side:
        """Return the curve as a boundary segment of a face: the nodes in order, and their plane coordinates on the face.

        ``plane``: function that maps values of the curve's parameter ``(n + 1,)`` to plane coordinates ``(n + 1, 2)``.
        """
        return self.nodes, plane(self.parameters)

    def reversed_side(self, plane: Placing) -> Side:
        """Return the curve as a boundary segment of a face as `side` does, but with nodes in reverse order."""
        return self.nodes[::-1], plane(self.parameters[::-1])


def edges_of_triangles(triangles: Index) -> Index:
    """Return the edges of triangles ``(3 t, 2)``: first to second corner of all, second to third, third to first.

    ``triangles``: corners of the triangles ``(t, 3)``.
    """
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


@dataclass
class TriangulatedFace:
    """One smooth face of a body's surface, divided into triangles with n nodes."""

    #: Name of the boundary of the mesh to which the face belongs, such as a flank.
    boundary_name: str
    #: Numbers of its nodes in the `ClosedSurfaceMesh` ``(n,)``.
    node_numbers: Index
    #: Plane coordinates of its nodes ``(n, 2)``; a node on the seam of a face that closes around the axis occurs twice.
    plane_coordinates: Array
    #: Triangles ``(t, 3)``, as indices into `node_numbers`.
    local_triangles: Index
    #: Function that maps plane coordinates ``(k, 2)`` to points in space ``(k, 3)`` [m]; None for the faces of a refinement
    #: box around a contact, whose triangles and nodes must not be changed.
    point_map: Placing | None

    @property
    def triangles(self) -> Index:
        """Corner nodes of the face's triangles ``(t, 3)``, by their numbers in the `ClosedSurfaceMesh`."""
        return self.node_numbers[self.local_triangles]

    @property
    def local_edges(self) -> Index:
        """Edges of the face's triangles ``(3 t, 2)``, as indices into `node_numbers`, the nodes of the face."""
        return edges_of_triangles(self.local_triangles)

    def flip_common_edge(self, first: int, second: int) -> bool:
        """Replace the common edge of two triangles by the other diagonal of their quadrilateral, if both stay well shaped.

        Parameters
        ----------
        first, second : int
            Indices of the two triangles in `local_triangles`, which is changed in place.

        Returns
        -------
        bool
            True if the edge was replaced; False if nothing was changed.
        """
        one, two = ([int(k) for k in self.local_triangles[t]] for t in (first, second))
        start = next((k for k in range(3) if one[k] in two and one[(k + 1) % 3] in two), None)
        if start is None:
            return False
        a, b, c = one[start], one[(start + 1) % 3], one[(start + 2) % 3]
        d = next(k for k in two if k not in (a, b))
        new = np.array([[c, a, d], [d, b, c]])
        if sine_of_smallest_angle(self.plane_coordinates[new]).min() < min(
            SLENDER, 0.5 * float(sine_of_smallest_angle(self.plane_coordinates[[one, two]]).min())
        ):
            return False
        self.local_triangles[[first, second]] = new
        return True


def sine_of_smallest_angle(corners: Array) -> Array:
    """Return the sine of the smallest angle of plane triangles; negative for triangles with clockwise corners.

    Parameters
    ----------
    corners : (t, 3, 2) Array
        Coordinates of the three corners of each triangle.

    Returns
    -------
    (t,) Array
        Sine for each triangle.

    Examples
    --------
    >>> sine_of_smallest_angle(np.array([[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]])).round(4).tolist()
    [0.7071]
    """
    u, v, w = (corners[:, (k + 1) % 3] - corners[:, k] for k in range(3))
    long = np.sort([np.linalg.norm(x, axis=1) for x in (u, v, w)], axis=0)
    return np.asarray((u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / (long[1] * long[2]))


class ClosedSurfaceMesh:
    """Closed triangulated surface of a body while the body's mesh is built: nodes, divided curves and faces.

    Attributes: ``points``: coordinates of the nodes ``(n, 3)`` [m]; ``faces``: the triangulated faces; ``middles``: edges
    of curves and refinement boxes, as pairs of nodes, with their exact midpoints [m], which become the midside nodes of
    second-order tetrahedra; ``raised``: corner nodes of refinement boxes, with the coordinates [m] that they have only
    while gmsh fills the body.
    """

    def __init__(self, gmsh: Any, size: Placing, fine: float, algorithm: int) -> None:
        """Create a closed surface that has no nodes and faces yet.

        Parameters
        ----------
        gmsh : Any
            The module gmsh, in a `gmsh_session`.
        size : Placing
            Function that returns the wanted edge lengths ``(n,)`` [m] at points ``(n, 3)`` [m].
        fine : float
            Smallest wanted edge length [m].
        algorithm : int
            Number of gmsh's algorithm for plane faces.
        """
        self.gmsh, self.size, self.fine, self.algorithm = gmsh, size, fine, algorithm
        self.points = np.zeros((0, 3))
        self.faces: list[TriangulatedFace] = []
        self.middles: list[tuple[Index, Array]] = []
        self.raised: list[tuple[Index, Array]] = []

    def add_nodes(self, points: Array) -> Index:
        """Add nodes at the points ``points`` ``(n, 3)`` [m] to the surface, and return their numbers ``(n,)``."""
        first = len(self.points)
        self.points = np.concatenate([self.points, points])
        return np.arange(first, len(self.points))

    def add_curve(
        self, space: Placing, start: float, end: float, limit: float, ends: tuple[int, int] | None = None
    ) -> DividedCurve:
        """Divide a curve into edges of the wanted length, and add its nodes to this surface.

        Parameters
        ----------
        space : Placing
            Function that maps parameters ``(n,)`` of the curve to points ``(n, 3)`` [m].
        start, end : float
            First and last value of the curve's parameter.
        limit : float
            Length of the longest edge [m].
        ends : tuple[int, int] | None, default None
            Numbers of the nodes at the curve's ends; None for a closed curve, which gets at least five edges.

        Returns
        -------
        DividedCurve
            The divided curve.
        """
        t = np.linspace(start, end, 65)
        length = float(np.linalg.norm(np.diff(space(t), axis=0), axis=1).sum())
        t = np.linspace(start, end, int(np.clip(length / (0.3 * self.fine), 64, 40000)) + 1)
        x = space(t)
        steps = np.linalg.norm(np.diff(x, axis=0), axis=1) / np.minimum(self.size(0.5 * (x[1:] + x[:-1])), limit)
        total = np.concatenate([[0.0], np.cumsum(steps)])
        count = max(int(np.ceil(total[-1])), 5 if ends is None else 1)
        t = np.interp(np.linspace(0.0, total[-1], count + 1), total, t)
        inner = self.add_nodes(space(t[:-1] if ends is None else t[1:-1]))
        number = np.append(inner, inner[0]) if ends is None else np.array([ends[0], *inner, ends[1]])
        self.middles.append((np.stack([number[:-1], number[1:]], 1), space(0.5 * (t[1:] + t[:-1]))))
        return DividedCurve(number, t)

    def add_face(
        self, name: str, loops: Sequence[Sequence[Side]], space: Placing, limit: float, stretch: Placing | None = None
    ) -> None:
        """Triangulate a face in its plane coordinates, and add it to this surface.

        Parameters
        ----------
        name : str
            Name of the boundary of the mesh to which the face belongs.
        loops : Sequence[Sequence[Side]]
            The face's outer boundary, then one loop for each hole. A loop is a list of boundary segments in order around
            it; each segment holds node numbers and their plane coordinates.
        space : Placing
            Function that maps plane coordinates ``(n, 2)`` to points ``(n, 3)`` [m].
        limit : float
            Length of the longest edge [m].
        stretch : Placing | None, default None
            Function that returns, at plane coordinates ``(n, 2)``, the ratio of a length in the plane to the same length in
            space ``(n,)``; None: the ratio is 1 everywhere.
        """
        rings = [(np.concatenate([n[:-1] for n, _ in loop]), np.concatenate([x[:-1] for _, x in loop])) for loop in loops]
        boundary = np.concatenate([n for n, _ in rings])
        plane = np.concatenate([x for _, x in rings])

        def edge_lengths(at: Array) -> Array:
            size = np.minimum(self.size(space(at[:, :2])), limit)
            return size if stretch is None else size * stretch(at[:, :2])

        sizes = gmsh_size_callback(edge_lengths, 0.3 * self.fine, FACE_BLOCK)
        tris, inner = triangulate_plane_region(self.gmsh, [len(n) for n, _ in rings], plane, sizes, self.algorithm)
        number = np.concatenate([boundary, self.add_nodes(space(inner))])
        plane = np.concatenate([plane, inner])
        self.faces.append(TriangulatedFace(name, number, plane, tris, space))

    def add_refinement_box(self, name: str, mesh: RefinementBoxFaces, points: Array, raised: Array) -> Index:
        """Add the faces of a refinement box, which is left free around a contact for a finer mesh, to this surface.

        Parameters
        ----------
        name : str
            Name of the boundary of the mesh to which the faces belong.
        mesh : RefinementBoxFaces
            Mesh of the refinement box's faces, with k nodes, of which the first c are corner nodes.
        points : (k, 3) Array
            Coordinates of these nodes [m].
        raised : (c, 3) Array
            Coordinates that the corner nodes have only while gmsh fills the body [m]; the faces then bulge into the body.

        Returns
        -------
        (c,) Index
            Numbers of the corner nodes in this surface.
        """
        count = len(mesh.xi) - len(mesh.midside_node_of_edge)
        number = self.add_nodes(points[:count])
        pairs = np.array(list(mesh.midside_node_of_edge), dtype=np.int64)
        self.middles.append((number[pairs], points[list(mesh.midside_node_of_edge.values())]))
        self.raised.append((number, raised))
        self.faces.append(TriangulatedFace(name, number, np.zeros((count, 2)), mesh.triangles[:, :3], None))
        return number

    def triangles_on_boundary(self, name: str = "") -> Index:
        """Return the corner nodes of all triangles on the boundary ``name``, or on all faces if it is empty ``(t, 3)``."""
        return np.concatenate([f.triangles for f in self.faces if name in ("", f.boundary_name)])

    def exact_edge_midpoints(self) -> tuple[Index, Array]:
        """Return the point of the exact curve or face at the middle of each edge, at which its midside node is placed.

        Edges of curves and refinement boxes come first, then those of faces. An edge that lies on a curve or in two
        triangles occurs several times; its first midpoint is the one to use.

        Returns
        -------
        edges : (k, 2) Index
            Numbers of the two nodes of each edge.
        points : (k, 3) Array
            Midpoint of each edge [m].
        """
        middles = list(self.middles)
        for f in self.faces:
            if f.point_map is not None:
                at = f.plane_coordinates[f.local_edges].mean(axis=1)
                middles.append((f.node_numbers[f.local_edges], f.point_map(at)))
        edges, points = zip(*middles, strict=True)
        return np.concatenate(edges), np.concatenate(points)


def gmsh_size_callback(
    length_function: Placing, cube_edge: float, cubes_per_block: tuple[int, int, int]
) -> Callable[..., float]:
    """Make the function that gmsh calls for the element size at a point; it computes sizes for many points at once.

    The sizes are stored for later calls.

    Parameters
    ----------
    length_function : Placing
        Function that returns the wanted edge lengths ``(n,)`` [m] at points ``(n, 3)`` [m].
    cube_edge : float
        Edge of the cubes in which the edge length counts as constant [m].
    cubes_per_block : tuple[int, int, int]
        Number of cubes along x, y and z that are evaluated at once.

    Returns
    -------
    callable
        Function to pass to gmsh's ``setSizeCallback``.
    """
    known = dict[tuple[int, int, int], list[float]]()
    inverse, (a, b, c) = 1.0 / (MM * cube_edge), cubes_per_block
    cubes = np.array(list(product(*map(range, cubes_per_block))))

    def element_size_at_point(_dim: int, _tag: int, x: float, y: float, z: float, lc: float) -> float:
        i, j, k = round(x * inverse), round(y * inverse), round(z * inverse)
        key = (i // a, j // b, k // c)
        sizes = known.get(key)
        if sizes is None:
            sizes = known[key] = (MM * length_function(cube_edge * (np.multiply(key, cubes_per_block) + cubes))).tolist()
        return min(sizes[((i % a) * b + j % b) * c + k % c], lc)

    return element_size_at_point


def triangulate_plane_region(
    gmsh: Any, loop_node_counts: Sequence[int], loop_coordinates: Array, size_callback: Callable[..., float], algorithm: int
) -> tuple[Index, Array]:
    """Triangulate a plane region, which may have holes, by gmsh; no nodes are added on its boundary.

    Parameters
    ----------
    gmsh : Any
        The module gmsh, in a `gmsh_session`.
    loop_node_counts : Sequence[int]
        Number of nodes of each closed loop of the boundary, the outer one first.
    loop_coordinates : (n, 2) Array
        Coordinates of the loops' nodes, one loop after another [m].
    size_callback : Callable[..., float]
        Function for gmsh's element sizes, from `gmsh_size_callback`.
    algorithm : int
        Number of gmsh's algorithm for plane faces.

    Returns
    -------
    triangles : (t, 3) Index
        Nodes of the triangles, counter-clockwise. The boundary's nodes have the numbers 0 to n - 1, new ones those from n.
    inner : (k, 2) Array
        Coordinates of the new nodes inside the region [m].

    Raises
    ------
    ValueError
        gmsh changed the nodes of the boundary.
    """
    gmsh.model.add("face")
    geo, mesh = gmsh.model.geo, gmsh.model.mesh
    for x, y in MM * loop_coordinates:
        geo.addPoint(x, y, 0.0)
    wires, first = [], 1
    for count in loop_node_counts:
        lines = [geo.addLine(first + k, first + (k + 1) % count) for k in range(count)]
        for line in lines:
            geo.mesh.setTransfiniteCurve(line, 2)
        wires.append(geo.addCurveLoop(lines))
        first += count
    face = geo.addPlaneSurface(wires)
    geo.synchronize()
    gmsh.option.setNumber("Mesh.Algorithm", algorithm)
    mesh.setSizeCallback(size_callback)
    mesh.generate(2)
    mesh.removeSizeCallback()
    tags, xyz, _ = mesh.getNodes(2, face)
    boundary, at, _ = mesh.getNodes(0, -1)
    inner = xyz.reshape(-1, 3)[:, :2] / MM
    if len(boundary) != len(loop_coordinates) or not np.allclose(
        at.reshape(-1, 3)[:, :2], MM * loop_coordinates, atol=1e-9
    ):
        raise ValueError("gmsh added or moved nodes on the boundary of a face, whose nodes must not change")
    tris = number_elements(gmsh, 2, np.concatenate([boundary, tags]), 3)
    gmsh.model.remove()
    a, b, c = (np.concatenate([loop_coordinates, inner])[tris[:, k]] for k in range(3))
    turned = (b - a)[:, 0] * (c - a)[:, 1] < (b - a)[:, 1] * (c - a)[:, 0]
    tris[turned] = tris[turned][:, [0, 2, 1]]
    return tris, inner


def fill_with_tetrahedra(
    gmsh: Any, points: Array, triangles: Index, size_callback: Callable[..., float], algorithm: int
) -> tuple[Index, Array]:
    """Fill a closed triangulated surface with tetrahedra by gmsh, without changing the surface.

    Parameters
    ----------
    gmsh : Any
        The module gmsh, in a `gmsh_session`.
    points : (n, 3) Array
        Coordinates of the surface's nodes [m].
    triangles : (t, 3) Index
        Triangles of the surface.
    size_callback : Callable[..., float]
        Function for gmsh's element sizes, from `gmsh_size_callback`.
    algorithm : int
        Number of gmsh's algorithm for volumes.

    Returns
    -------
    cells : (m, 4) Index
        Nodes of the tetrahedra. The surface's nodes have the numbers 0 to n - 1, new ones those from n.
    inner : (k, 3) Array
        Coordinates of the new nodes inside the volume [m].

    Raises
    ------
    ValueError
        The surface is not closed, or gmsh leaves the volume empty.
    """
    edges = np.sort(edges_of_triangles(triangles), axis=1)
    if np.any(np.unique(edges @ np.array([len(points), 1]), return_counts=True)[1] != 2):
        raise ValueError("the triangles do not form a closed surface: some of their edges do not belong to two triangles")
    gmsh.model.add("volume")
    surface = gmsh.model.addDiscreteEntity(2)
    count = len(points)
    gmsh.model.mesh.addNodes(2, surface, np.arange(1, count + 1), (MM * points).ravel())
    gmsh.model.mesh.addElementsByType(surface, 2, [], (triangles + 1).ravel())
    gmsh.model.geo.addVolume([gmsh.model.geo.addSurfaceLoop([surface])])
    gmsh.model.geo.synchronize()
    gmsh.option.setNumber("Mesh.Algorithm3D", algorithm)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.model.mesh.setSizeCallback(size_callback)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.removeSizeCallback()
    tags, xyz, _ = gmsh.model.mesh.getNodes(3, -1)
    cells = number_elements(gmsh, 4, np.append(np.arange(1, count + 1), tags), 4)
    gmsh.model.remove()
    if not len(cells):
        raise ValueError("gmsh made no tetrahedra inside the closed surface")
    return cells, xyz.reshape(-1, 3) / MM


@dataclass(frozen=True)
class FilledSurfaceMesh:
    """Second-order tetrahedra inside a closed surface (`ClosedSurfaceMesh`), whose corner nodes keep their numbers."""

    #: Mesh of second-order tetrahedra.
    mesh: Mesh
    #: One integer for each edge of the mesh, computed from the numbers of its two corners; in ascending order.
    edge_keys: Index
    #: Number of the midside node of each edge, in the order of `edge_keys`.
    midside_nodes: Index

    def midside_nodes_of_edges(self, corner_pairs: Index) -> Index:
        """Return the midside nodes of edges, each given by its two corner nodes.

        Parameters
        ----------
        corner_pairs : (k, 2) Index
            Numbers of the two corners of each edge.

        Returns
        -------
        (k,) Index
            Numbers of the midside nodes.

        Raises
        ------
        ValueError
            A pair of corners is not an edge of the mesh.
        """
        keys = np.sort(corner_pairs, axis=1) @ np.array([self.mesh.nvertices, 1])
        place = np.minimum(np.searchsorted(self.edge_keys, keys), len(self.edge_keys) - 1)
        if not np.array_equal(self.edge_keys[place], keys):
            raise ValueError("an edge of the surface triangles is not an edge of gmsh's tetrahedra")
        return np.asarray(self.midside_nodes[place])

    def nodes_on_refinement_box(self, corners: Index, box_faces: RefinementBoxFaces) -> Index:
        """Return all nodes on the faces of a refinement box, which is left free around a contact for a finer mesh.

        Parameters
        ----------
        corners : (c,) Index
            Numbers of the refinement box's corner nodes in this mesh.
        box_faces : RefinementBoxFaces
            Mesh of the refinement box's faces.

        Returns
        -------
        (k,) Index
            Numbers of all nodes on the faces, in the order of the nodes of ``box_faces``.
        """
        pairs = np.array(list(box_faces.midside_node_of_edge), dtype=np.int64)
        return np.concatenate([corners, self.midside_nodes_of_edges(corners[pairs])])

    def improved_mesh(
        self, surface: ClosedSurfaceMesh, body_name: str, nodes_to_keep: Index
    ) -> tuple[Mesh, int, fem.MeshQuality]:
        """Return the mesh with named boundaries and improved curved cells, as `fem.improve_curved_cells` does.

        Parameters
        ----------
        surface : ClosedSurfaceMesh
            Closed surface that this mesh fills; the names of its faces become those of the boundaries.
        body_name : str
            Name of the body, for the error message.
        nodes_to_keep : Index
            Numbers of the nodes that are never moved.

        Returns
        -------
        mesh : Mesh
            Improved mesh.
        moved : int
            Number of midside nodes, on the surface or inside, that were moved to straighten edges.
        quality : MeshQuality
            Quality of the improved mesh.

        Raises
        ------
        ValueError
            A triangle of the surface is not a face of the mesh, or a cell is still inverted.
        """
        names = dict.fromkeys(f.boundary_name for f in surface.faces)
        named = fem.with_boundaries_from_corners(self.mesh, {name: surface.triangles_on_boundary(name) for name in names})
        corners = surface.triangles_on_boundary()
        nodes = np.unique(np.concatenate([corners.ravel(), self.midside_nodes_of_edges(edges_of_triangles(corners))]))
        return fem.improve_curved_cells(named, body_name, nodes, nodes_to_keep)


def tetrahedra_with_positive_volumes(points: Array, cells: Index) -> Index:
    """Return the corner nodes of tetrahedra ``(m, 4)``, reordered where needed so that all volumes are positive.

    ``points``: coordinates of the mesh's nodes ``(n, 3)`` [m]; ``cells``: corner nodes of the tetrahedra ``(m, 4)``.
    """
    a, b, c, d = (points[cells[:, k]] for k in range(4))
    turned = np.einsum("ni,ni->n", np.cross(b - a, c - a), d - a) < 0.0
    return np.where(turned[:, None], cells[:, [0, 2, 1, 3]], cells)


def remove_cells_flat_on_surface(surface: ClosedSurfaceMesh, points: Array, cells: Index) -> Index:
    """Remove tetrahedra with two triangles on one smooth face; their other two triangles become part of the surface.

    When the common edge of two such triangles is curved, the tetrahedron degenerates along it. A tetrahedron is kept where
    the new surface triangles would be badly shaped.

    Parameters
    ----------
    surface : ClosedSurfaceMesh
        Closed surface of the mesh; its triangles are changed in place.
    points : (n, 3) Array
        Coordinates of the mesh's corner nodes [m].
    cells : (m, 4) Index
        Nodes of the tetrahedra.

    Returns
    -------
    (k, 4) Index
        Nodes of the remaining tetrahedra.
    """
    base = np.array([len(points) ** 2, len(points), 1])
    for _ in range(6):
        keys = np.concatenate([np.sort(f.triangles, axis=1) @ base for f in surface.faces])
        owners = [(-1 if f.point_map is None else k, len(f.local_triangles)) for k, f in enumerate(surface.faces)]
        face = np.concatenate([np.full(count, k) for k, count in owners])
        row = np.concatenate([np.arange(len(f.local_triangles)) for f in surface.faces])
        order = np.argsort(keys)
        sides = np.stack([np.sort(np.delete(cells, k, axis=1), axis=1) @ base for k in range(4)], axis=1)
        place = order[np.minimum(np.searchsorted(keys, sides, sorter=order), len(keys) - 1)]
        opposite = np.where(keys[place] == sides, face[place], -1 - np.arange(4))  # the face opposite each corner
        edge_keys = [np.sort(f.node_numbers[f.local_edges], axis=1) @ base[1:] for f in surface.faces]
        edges = set(np.concatenate(edge_keys).tolist())
        pairs = [(i, j) for i in range(4) for j in range(i)]
        alike = np.stack([(opposite[:, i] == opposite[:, j]) & (opposite[:, i] >= 0) for i, j in pairs], axis=1)
        gone, changed = [], set[tuple[int, int]]()
        for number in np.flatnonzero(alike.any(axis=1)):
            ends = list(pairs[int(alike[number].argmax())])
            face_index, rows = int(opposite[number, ends[0]]), [int(k) for k in row[place[number, ends]]]
            turned = {(face_index, k) for k in rows}
            fresh = int(np.sort(cells[number, ends]) @ base[1:]) not in edges and not changed & turned
            if fresh and surface.faces[face_index].flip_common_edge(rows[0], rows[1]):
                changed |= turned
                gone.append(number)
        if not gone:
            break
        cells = np.delete(cells, gone, axis=0)
    return cells


def mesh_inside_closed_surface(surface: ClosedSurfaceMesh, algorithm: int) -> FilledSurfaceMesh:
    """Fill a closed surface with second-order tetrahedra, whose edges become longer with the distance from the surface.

    Parameters
    ----------
    surface : ClosedSurfaceMesh
        Closed surface of the body.
    algorithm : int
        Number of gmsh's algorithm for volumes.

    Returns
    -------
    FilledSurfaceMesh
        The mesh; its surface nodes lie exactly on the body's surface.

    Raises
    ------
    ValueError
        The surface is not closed, gmsh leaves the volume empty, or an edge of the surface is not an edge of the mesh.
    """
    points = surface.points.copy()
    for number, place in surface.raised:
        points[number] = place
    tris = surface.triangles_on_boundary()
    ends = edges_of_triangles(tris)
    long = np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
    near = np.bincount(ends[:, 0], long) / np.bincount(ends[:, 0])
    tree = cKDTree(points)

    def edge_lengths(x: Array) -> Array:
        distance, node = tree.query(x)
        return np.asarray(np.minimum(surface.size(x), near[node] + INWARD * distance))

    size_callback = gmsh_size_callback(edge_lengths, 0.6 * surface.fine, VOLUME_BLOCK)
    cells, inner = fill_with_tetrahedra(surface.gmsh, points, tris, size_callback, algorithm)
    cells = tetrahedra_with_positive_volumes(np.concatenate([points, inner]), cells)
    corners = np.concatenate([surface.points, inner])
    cells = remove_cells_flat_on_surface(surface, corners, cells)
    used = np.zeros(len(corners), dtype=bool)
    used[: len(surface.points)] = True
    used[cells] = True
    cells, corners = (np.cumsum(used) - 1)[cells], corners[used]
    straight = fem.to_second_order_mesh(MeshTet1(np.ascontiguousarray(corners.T), np.ascontiguousarray(cells.T)))
    pairs = np.sort(straight.edges, axis=0).T @ np.array([len(corners), 1])
    order = np.argsort(pairs)
    filled = FilledSurfaceMesh(straight, pairs[order], straight.dofs.edge_dofs[0, order].astype(np.int64))
    edges, exact = surface.exact_edge_midpoints()
    number = filled.midside_nodes_of_edges(edges)[::-1]  # where an edge has several midpoints, the first one counts
    points = straight.doflocs.T.copy()
    points[number] = exact[::-1]
    return replace(filled, mesh=fem.with_node_coordinates(straight, points))


def edge_length_growing_with_distance(
    fine_points: Array, smallest_size: float, largest_size: float, fine_distance: float, coarse_distance: float
) -> Placing:
    """Return a function for the wanted edge length, which grows with the distance from the nearest of given points.

    Parameters
    ----------
    fine_points : (k, 3) Array
        Points around which the mesh is fine [m]; without points, the edge length is ``largest_size`` everywhere.
    smallest_size, largest_size : float
        Edge length up to the distance ``fine_distance``, and from the distance ``coarse_distance`` on [m].
    fine_distance, coarse_distance : float
        Distances between which the edge length grows linearly [m].

    Returns
    -------
    callable
        Function that returns the edge lengths ``(n,)`` [m] at points ``(n, 3)`` [m].
    """
    if not len(fine_points):
        return lambda x: np.full(len(x), largest_size)
    tree = cKDTree(fine_points)

    def edge_length_at_points(x: Array) -> Array:
        share = (tree.query(x, distance_upper_bound=coarse_distance)[0] - fine_distance) / (coarse_distance - fine_distance)
        return np.asarray(smallest_size + (largest_size - smallest_size) * np.minimum(np.maximum(share, 0.0), 1.0))

    return edge_length_at_points


def best_mesh_of_attempts(name: str, attempt: Callable[[Any, int, int, float], tuple[Body, float]]) -> Body:
    """Mesh a body with one of gmsh's algorithms and element sizes of `ATTEMPTS` after another, until a mesh has no fault.

    Parameters
    ----------
    name : str
        Name of the body, for the error message.
    attempt : Callable[[Any, int, int, float], tuple[Body, float]]
        Function that meshes the body once, and returns the mesh and a measure of its worst fault, such as a badly shaped
        cell (0: no fault). Its arguments: the module gmsh, the number of gmsh's algorithm for faces, that of its algorithm
        for volumes, and a factor on the element sizes.

    Returns
    -------
    Body
        The first mesh without a fault, or else the mesh with the smallest fault.

    Raises
    ------
    ValueError
        Every attempt raises an error.
    """
    failures: list[str] = []
    attempts: list[tuple[Body, float]] = []
    for plane, volume, share in ATTEMPTS:
        with gmsh_session(OPTIONS) as gmsh:
            try:
                attempts.append(attempt(gmsh, plane, volume, share))
            except Exception as error:  # gmsh raises plain exceptions only
                failures.append(str(error).strip())
        if attempts and attempts[-1][1] == 0.0:
            break
    if not attempts:
        raise ValueError(f"gmsh cannot mesh the {name}: " + "; ".join(dict.fromkeys(failures)))
    return min(attempts, key=lambda x: x[1])[0]
