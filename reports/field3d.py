"""Meshes and fields as 3D pictures: surfaces with the cells' edges, cut open, or plane sections with a field on them.

As in `reports.scene3d`, a child process draws, because VTK ends the process on a machine without off-screen OpenGL.
"""

from __future__ import annotations

import pickle
import sys
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np

from rollbench.meshes.arrays import Array, Index
from rollbench.reports.figures import COLOURS
from rollbench.reports.offscreen import draw_in_child
from rollbench.reports.records import FieldPicture, MeshPart
from rollbench.reports.scene3d import SIZE

_TET_FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
_TET_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3))  # midpoints 4 to 9, gmsh's order
_HEX_FACES = ((0, 3, 2, 1), (0, 1, 5, 4), (0, 4, 7, 3), (1, 2, 6, 5), (2, 3, 7, 6), (4, 5, 6, 7))  # centres 20 to 25
_HEX_EDGES = ((0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7))
_HEX_CORNERS = ((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2))
_TEN_SPLIT = (
    (0, 4, 6, 7),
    (4, 1, 5, 9),
    (6, 5, 2, 8),
    (7, 9, 8, 3),
    (4, 8, 5, 6),
    (4, 8, 6, 7),
    (4, 8, 7, 9),
    (4, 8, 9, 5),
)
STEPS = 18  # of the colour scale: their borders are lines of equal value
PALETTE = 224  # colours of the file
MM = 1e3
KINDS = {"P1": 4, "P2": 10, "Q2": 27}
_LINE = "#2b3138"


def draw_field(picture: FieldPicture, path: str | Path) -> None:
    """Write a PNG of meshes or fields, without an X server.

    Raises ValueError for arrays that do not belong together, RuntimeError where this machine cannot draw it.
    """
    check(picture)
    draw_in_child("rollbench.reports.field3d", picture, path)


def check(picture: FieldPicture) -> None:
    """Refuse what cannot be drawn. Raises ValueError."""
    for number, part in enumerate(picture.parts, start=1):
        place = f"picture {picture.name!r}, part {number}"
        points, cells = np.asarray(part.points, float), np.asarray(part.cells)
        if part.kind not in KINDS:
            raise ValueError(f"{place}: kind is {part.kind!r}; it must be one of {', '.join(KINDS)}")
        if points.ndim != 2 or points.shape[1] != 3 or not np.all(np.isfinite(points)):
            raise ValueError(f"{place}: points must be finite and of shape (n, 3); they have {points.shape}")
        if cells.ndim != 2 or cells.shape[1] != KINDS[part.kind]:
            raise ValueError(f"{place}: {part.kind} cells need {KINDS[part.kind]} nodes; they have shape {cells.shape}")
        if cells.size and not 0 <= cells.min() <= cells.max() < len(points):
            raise ValueError(f"{place}: cells name nodes that are not there")
        if part.values is not None and np.shape(part.values) != (len(points),):
            raise ValueError(f"{place}: {np.shape(part.values)} values for {len(points)} points")
    if not picture.parts or (picture.section and len(picture.cuts) != 1):
        raise ValueError(f"picture {picture.name!r}: it needs parts, and a section exactly one cut")


def pieces(cells: Index, kind: str) -> Index:
    """First-order cells that second-order ones fall into: 4 or 8 nodes each, in VTK's order."""
    if kind == "P1":
        return cells
    if kind == "P2":
        return cells[:, np.array(_TEN_SPLIT)].reshape(-1, 4)
    grid = _grid()
    local = [[grid[tuple(np.array(start) + np.array(c) // 2)] for c in _HEX_CORNERS] for start in product((0, 1), repeat=3)]
    return cells[:, np.array(local)].reshape(-1, 8)


def _grid() -> Index:
    """Number of the node at (i, j, k) in {0, 1, 2}^3 of a 27-node hexahedron."""
    grid = np.full((3, 3, 3), 26, dtype=np.int64)
    corners = np.array(_HEX_CORNERS)
    for n, c in enumerate(corners):
        grid[tuple(c)] = n
    for n, pair in enumerate(_HEX_EDGES, start=8):
        grid[tuple(corners[list(pair)].sum(axis=0) // 2)] = n
    for n, face in enumerate(_HEX_FACES, start=20):
        grid[tuple(corners[list(face)].sum(axis=0) // 4)] = n
    return grid


def faces(cells: Index, kind: str) -> Index:
    """All faces of all cells ``(f, m)``: corners, then midpoints of the edges after each corner, then the centre."""
    hexa = kind == "Q2"
    edges = {frozenset(e): (8 if hexa else 4) + n for n, e in enumerate(_HEX_EDGES if hexa else _TET_EDGES)}
    rows = []
    for n, face in enumerate(_HEX_FACES if hexa else _TET_FACES):
        row = list(face)
        if kind != "P1":
            row += [edges[frozenset((a, face[(k + 1) % len(face)]))] for k, a in enumerate(face)]
        rows.append([*row, 20 + n] if hexa else row)
    return np.asarray(cells[:, np.array(rows)].reshape(-1, len(rows[0])))


def skin(cells: Index, kind: str) -> Index:
    """Faces that belong to one cell only."""
    every = faces(cells, kind)
    corners = np.sort(every[:, : 4 if kind == "Q2" else 3], axis=1)
    _, first, count = np.unique(corners, axis=0, return_index=True, return_counts=True)
    return np.asarray(every[np.sort(first[count == 1])])


def _shape(bary: Array, edges: Sequence[tuple[int, int]]) -> Array:
    """Second-order shape functions ``(q, n)`` of a simplex at barycentric coordinates ``(q, corners)``."""
    i, j = np.array(edges).T
    return np.hstack([bary * (2.0 * bary - 1.0), 4.0 * bary[:, i] * bary[:, j]])


def _lattice() -> tuple[Array, Index, Index]:
    """Triangle cut into 16: shape functions ``(15, 6)`` of its points, small triangles, pieces of its edges."""
    n = 4
    place = {(i, j): k for k, (i, j) in enumerate((i, j) for i in range(n + 1) for j in range(n + 1 - i))}
    x = np.array(list(place), dtype=float) / n
    bary = np.column_stack([1.0 - x.sum(axis=1), x])
    up = [(place[i, j], place[i + 1, j], place[i, j + 1]) for i, j in place if i + j < n]
    down = [(place[i + 1, j], place[i + 1, j + 1], place[i, j + 1]) for i, j in place if i + j < n - 1]
    walk = [(k, 0) for k in range(n)] + [(n - k, k) for k in range(n)] + [(0, n - k) for k in range(n)]
    ring = [place[w] for w in walk]
    return (
        _shape(bary, ((0, 1), (1, 2), (2, 0))),
        np.array(up + down, dtype=np.int64),
        np.stack([ring, np.roll(ring, -1)], axis=1).astype(np.int64),
    )


def drawn_faces(points: Array, face: Index, kind: str) -> tuple[Array, Array, Index, Index]:
    """Faces as drawn, second-order ones curved: shape functions ``(q, m)`` and points ``(f q, 3)``, faces' nodes being
    weighted by them; triangles ``(t, 3)`` and straight pieces of the edges ``(e, 2)`` of these points."""
    if kind == "P1":
        shape, small, ring = np.eye(3), np.array([[0, 1, 2]]), np.array([[0, 1], [1, 2], [2, 0]])
    elif kind == "P2":
        shape, small, ring = _lattice()
    else:
        shape = np.eye(9)
        small = np.array([t for k in range(4) for t in ((k, 4 + k, 8), (k, 8, 4 + (k - 1) % 4))])
        ring = np.array([e for k in range(4) for e in ((k, 4 + k), (4 + k, (k + 1) % 4))])
    where = np.einsum("qm,fmx->fqx", shape, points[face]).reshape(-1, 3)
    first = len(shape) * np.arange(len(face))[:, None, None]
    return shape, where, (first + small).reshape(-1, 3), (first + ring).reshape(-1, 2)


def drawn_cells(part: MeshPart, cells: Index) -> tuple[Array, Index, Array | None]:
    """Points, first-order cells and values as drawn in a section: second-order tetrahedra become 64 each."""
    points = np.asarray(part.points, float)
    values = None if part.values is None else np.asarray(part.values, float)
    if part.kind != "P2":
        return points, pieces(cells, part.kind), values
    corner = np.eye(4)
    ten = np.vstack([corner, *[0.5 * (corner[i] + corner[j]) for i, j in _TET_EDGES]])
    small = []
    for sub in _TEN_SPLIT:
        nodes = ten[list(sub)]
        small.append(np.vstack([nodes, *[0.5 * (nodes[i] + nodes[j]) for i, j in _TET_EDGES]]))
    shape = _shape(np.concatenate(small), _TET_EDGES)
    where = np.einsum("qm,cmx->cqx", shape, points[cells]).reshape(-1, 3)
    new = pieces(np.arange(len(where)).reshape(-1, 10), "P2")
    return where, new, None if values is None else (values[cells] @ shape.T).ravel()


def _kept(part: MeshPart, picture: FieldPicture) -> Index:
    """Cells that are not in front of all cuts."""
    points, cells = np.asarray(part.points, float), np.asarray(part.cells, dtype=np.int64)
    if not picture.cuts:
        return cells
    middle = points[cells[:, : 8 if part.kind == "Q2" else 4]].mean(axis=1)
    front = np.all([(middle - np.asarray(o)) @ np.asarray(n) > 0.0 for o, n in picture.cuts], axis=0)
    return np.asarray(cells[~front])


def _poly(points: Array, cells: Index, *, lines: bool = False) -> Any:
    """Triangles or lines as a surface."""
    import pyvista

    rows = np.column_stack([np.full(len(cells), cells.shape[1]), cells]).ravel()
    return pyvista.PolyData(points, **{"lines" if lines else "faces": rows})


def _add_skin(plotter: Any, part: MeshPart, picture: FieldPicture, look: dict[str, Any]) -> None:
    """The surface of what the cuts leave, with the cells' edges."""
    outside = skin(_kept(part, picture), part.kind)
    if not len(outside):
        return
    shape, points, triangles, edges = drawn_faces(MM * np.asarray(part.points, float), outside, part.kind)
    surface = _poly(points, triangles)
    if part.values is not None:
        surface["values"] = (np.asarray(part.values, float)[outside] @ shape.T).ravel()
    surface = surface.clean(tolerance=1e-7, absolute=True)
    surface = surface.compute_normals(feature_angle=25.0, split_vertices=True, consistent_normals=False)
    actor = plotter.add_mesh(surface, ambient=0.35, diffuse=0.65, smooth_shading=True, **look)
    actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
    if part.edges:
        plotter.add_mesh(_poly(points, edges, lines=True), color=_LINE, line_width=part.line, lighting=False)


def _crossing(points: Array, cells: Index, picture: FieldPicture) -> Index:
    """Cells that the only cut passes through, and some beside it."""
    origin, normal = (np.asarray(v, float) for v in picture.cuts[0])
    away = (points[cells] - origin) @ normal
    slack = 0.3 * np.ptp(away, axis=1)  # curved cells reach beyond their nodes
    return np.asarray(cells[(away.min(axis=1) <= slack) & (away.max(axis=1) >= -slack)])


def _add_section(plotter: Any, part: MeshPart, picture: FieldPicture, look: dict[str, Any]) -> None:
    """The plane section of a part, with the cells' edges in it or its rim; lines a hair before the plane."""
    import pyvista

    plain, every = np.asarray(part.points, float), np.asarray(part.cells, dtype=np.int64)
    cells = _crossing(plain, every, picture)
    if not len(cells):
        return
    origin, normal = (np.asarray(v, float) for v in picture.cuts[0])
    plane = {"normal": normal, "origin": MM * origin}
    points, small, values = drawn_cells(part, cells)
    grid = pyvista.UnstructuredGrid(
        {pyvista.CellType.TETRA if small.shape[1] == 4 else pyvista.CellType.HEXAHEDRON: small}, MM * points
    )
    if values is not None:
        grid["values"] = values
    cut = grid.slice(**plane)
    if cut.n_points == 0:
        return
    plotter.add_mesh(cut, lighting=False, **look)
    ahead = 2e-3 * MM * picture.height * np.asarray(picture.sight, float) / np.linalg.norm(picture.sight)
    for wanted, face, colour, width in (
        (part.edges, faces(cells, part.kind), _LINE, 1.3),
        (part.outline, skin(every, part.kind), "#101418", 2.4),
    ):
        if wanted:
            _, where, triangles, _ = drawn_faces(MM * plain, _crossing(plain, face, picture), part.kind)
            lines = _poly(where, triangles).slice(**plane)
            if lines.n_points:
                plotter.add_mesh(lines.translate(ahead), color=colour, line_width=width, lighting=False)


def _limits(picture: FieldPicture) -> tuple[float, float] | None:
    """Ends of the scale of the values; None without values."""
    shown = [np.asarray(p.values, float) for p in picture.parts if p.values is not None]
    if picture.limits is not None or not shown:
        return picture.limits if shown else None
    return min(float(np.nanmin(v)) for v in shown), max(float(np.nanmax(v)) for v in shown)


def _axes(picture: FieldPicture) -> tuple[Array, Array, Array]:
    """Unit vectors to the right, upwards and to the viewer."""
    sight = np.asarray(picture.sight, float) / np.linalg.norm(picture.sight)
    right = np.cross(np.asarray(picture.up, float), sight)
    right /= np.linalg.norm(right)
    return right, np.cross(sight, right), sight


def _render(picture: FieldPicture, path: str) -> None:
    """Build the picture and write it; runs in the child process."""
    import matplotlib
    import pyvista

    pyvista.OFF_SCREEN = True
    limits = _limits(picture)
    width = round(SIZE[0] * (0.86 if limits else 1.0))
    plotter = pyvista.Plotter(off_screen=True, window_size=(width, SIZE[1]), lighting="none")
    plotter.set_background("white")
    for part in picture.parts:
        look: dict[str, Any] = {"color": part.colour}
        if part.values is not None:
            look = {
                "scalars": "values",
                "cmap": COLOURS,
                "clim": limits,
                "show_scalar_bar": False,
                "n_colors": STEPS,
                "log_scale": picture.log,
            }
        (_add_section if picture.section else _add_skin)(plotter, part, picture, look)
    right, up, sight = _axes(picture)
    focus, height = MM * np.asarray(picture.focus, float), MM * picture.height
    plotter.camera.focal_point = focus
    plotter.camera.position = focus + 20.0 * height * sight
    plotter.camera.up = up
    plotter.enable_parallel_projection()
    plotter.camera.parallel_scale = 0.5 * height
    for direction, strength in ((sight + 0.9 * up - 0.4 * right, 0.75), (sight, 0.35), (sight + 1.5 * right, 0.25)):
        light = pyvista.Light(position=focus + 50.0 * height * direction, focal_point=focus, intensity=strength)
        light.positional = False
        plotter.add_light(light)
    plotter.reset_camera_clipping_range()
    plotter.enable_anti_aliasing("ssaa")
    image = plotter.screenshot(None, return_img=True)
    plotter.close()
    with matplotlib.rc_context():
        matplotlib.rcdefaults()  # whatever a matplotlibrc says
        _compose(picture, np.asarray(image), limits, path)


def _compose(picture: FieldPicture, image: Any, limits: tuple[float, float] | None, path: str) -> None:
    """Words, scale bar and colour scale around the image; few colours keep the file small."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm, Normalize
    from matplotlib.figure import Figure
    from PIL import Image

    rows, columns = image.shape[:2]
    figure = Figure(figsize=(SIZE[0] / 100.0, SIZE[1] / 100.0), dpi=100)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, columns / SIZE[0], 1.0))
    axes.imshow(image, interpolation="none", aspect="auto", extent=(0.0, columns, 0.0, rows))
    axes.set_axis_off()
    right, up, _ = _axes(picture)
    scale = rows / picture.height
    paper = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "boxstyle": "round,pad=0.25"}
    for place, text in picture.words:
        arm = np.asarray(place, float) - np.asarray(picture.focus, float)
        at = 0.5 * columns + scale * (arm @ right), 0.5 * rows + scale * (arm @ up)
        axes.text(*at, text, fontsize=19, ha="center", va="center", color="black", bbox=paper)
    if picture.scale_bar:
        length, low, left = scale * picture.scale_bar, 34.0, 44.0
        box = matplotlib.patches.FancyBboxPatch(
            (left - 10.0, low - 12.0),
            max(length, 80.0) + 20.0,
            58.0,
            boxstyle="round,pad=6",
            facecolor="white",
            edgecolor="none",
            alpha=0.85,
        )
        axes.add_patch(box)
        start = left + 0.5 * (max(length, 80.0) - length)
        axes.plot([start, start + length], [low, low], color="black", linewidth=4.0, solid_capstyle="butt")
        axes.text(start + 0.5 * length, low + 8.0, f"{MM * picture.scale_bar:g} mm", fontsize=18, ha="center", va="bottom")
    if limits:
        norm = LogNorm(*limits) if picture.log else Normalize(*limits)
        beside = figure.add_axes((columns / SIZE[0] + 0.022, 0.08, 0.02, 0.76))
        colours = ScalarMappable(norm, matplotlib.colormaps[COLOURS].resampled(STEPS))
        bar = figure.colorbar(colours, cax=beside)
        bar.ax.tick_params(labelsize=18, length=5)
        bar.ax.minorticks_off()
        if picture.log:
            ticks = [m * 10.0**k for k in range(-12, 13) for m in (1.0, 2.0, 5.0) if limits[0] <= m * 10.0**k <= limits[1]]
        else:
            ticks = list(np.linspace(*limits, STEPS // 3 + 1))
        bar.set_ticks(ticks, labels=[f"{x:g}" for x in ticks])
        figure.text(columns / SIZE[0] + 0.016, 0.875, fill(picture.label, 12), fontsize=18, va="bottom")
    canvas.draw()
    flat = Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy())
    flat.quantize(PALETTE, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(path, optimize=True)


if __name__ == "__main__":
    _render(*pickle.load(sys.stdin.buffer))
