"""Meshes and fields as 3D pictures: surfaces with the cells' edges, cut open, or plane sections with a field on them.

As in `reports.scene3d`, a child process draws, because VTK ends the process on a machine without off-screen OpenGL.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.records import FieldPicture, MeshPart
from reports.scene3d import ADVICE, SIZE, TIMEOUT

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_TET_FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
_TET_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3))  # midpoints 4 to 9, gmsh's order
_HEX_FACES = ((0, 3, 2, 1), (0, 1, 5, 4), (0, 4, 7, 3), (1, 2, 6, 5), (2, 3, 7, 6), (4, 5, 6, 7))  # centres 20 to 25
_HEX_EDGES = (
    (0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7),
)  # fmt: skip
_HEX_CORNERS = ((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2))
_TEN_SPLIT = ((0, 4, 6, 7), (4, 1, 5, 9), (6, 5, 2, 8), (7, 9, 8, 3), (4, 8, 5, 6), (4, 8, 6, 7), (4, 8, 7, 9), (4, 8, 9, 5))
COLOURS = 18  # steps of the colour scale: their borders are lines of equal value
KINDS = {"P1": 4, "P2": 10, "Q2": 27}
_LINE = "#2b3138"


def draw_field(picture: FieldPicture, path: str | Path) -> None:
    """Write a PNG of meshes or fields, without an X server.

    Raises ValueError for arrays that do not belong together, RuntimeError where this machine cannot draw it.
    """
    check(picture)
    search = os.pathsep.join([str(Path(__file__).resolve().parents[1]), *filter(None, sys.path)])
    try:
        child = subprocess.run(
            [sys.executable, "-m", "reports.field3d"], input=pickle.dumps((picture, str(Path(path).resolve()))),
            capture_output=True, timeout=TIMEOUT, env={**os.environ, "PYTHONPATH": search}, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise RuntimeError(f"3D picture: not finished after {TIMEOUT:.0f} s; {ADVICE}") from None
    if child.returncode == 0:
        return
    words = child.stderr.decode(errors="replace").strip().splitlines() or ["no message"]
    if child.returncode < 0:
        raise RuntimeError(f"3D picture: no off-screen OpenGL on this machine; {ADVICE}")
    if words[-1].startswith(("ImportError", "ModuleNotFoundError")):
        raise RuntimeError(f"3D picture: pyvista cannot be loaded ({words[-1]}); install it, and {ADVICE}")
    raise RuntimeError(f"3D picture: {words[-1]}")


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
    return cells[:, np.array(rows)].reshape(-1, len(rows[0]))


def skin(cells: Index, kind: str) -> Index:
    """Faces that belong to one cell only."""
    every = faces(cells, kind)
    corners = np.sort(every[:, : 4 if kind == "Q2" else 3], axis=1)
    _, first, count = np.unique(corners, axis=0, return_index=True, return_counts=True)
    return every[np.sort(first[count == 1])]


def flat(face: Index, kind: str) -> Index:
    """Triangles ``(t, 3)`` of second-order faces."""
    local: tuple[tuple[int, ...], ...]
    if kind == "P1":
        return face
    if kind == "P2":
        local = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))
    else:
        local = tuple(t for k in range(4) for t in ((k, 4 + k, 8), (k, 8, 4 + (k - 1) % 4)))
    return face[:, np.array(local)].reshape(-1, 3)


def rims(face: Index, kind: str) -> Index:
    """Straight pieces ``(e, 2)`` of the faces' edges, each once."""
    corners = 4 if kind == "Q2" else 3
    pairs = []
    for k in range(corners):
        if kind == "P1":
            pairs.append(face[:, [k, (k + 1) % corners]])
        else:
            pairs += [face[:, [k, corners + k]], face[:, [corners + k, (k + 1) % corners]]]
    return np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)


def _kept(part: MeshPart, picture: FieldPicture) -> Index:
    """Cells that are not in front of all cuts."""
    points, cells = np.asarray(part.points, float), np.asarray(part.cells, dtype=np.int64)
    if not picture.cuts:
        return cells
    middle = points[cells[:, : 8 if part.kind == "Q2" else 4]].mean(axis=1)
    front = np.all([(middle - np.asarray(o)) @ np.asarray(n) > 0.0 for o, n in picture.cuts], axis=0)
    return cells[~front]


def _poly(points: Array, cells: Index, lines: bool = False) -> Any:
    """Triangles or lines as a surface, unused points left away."""
    import pyvista

    used, local = np.unique(cells, return_inverse=True)
    rows = np.column_stack([np.full(len(cells), cells.shape[1]), local.reshape(cells.shape)]).ravel()
    return pyvista.PolyData(points[used], **{"lines" if lines else "faces": rows}), used


def _add_skin(plotter: Any, part: MeshPart, picture: FieldPicture, look: dict[str, Any]) -> None:
    """The surface of what the cuts leave, with the cells' edges."""
    points = 1e3 * np.asarray(part.points, float)
    outside = skin(_kept(part, picture), part.kind)
    if not len(outside):
        return
    surface, used = _poly(points, flat(outside, part.kind))
    if part.values is not None:
        surface["values"] = np.asarray(part.values, float)[used]
    surface = surface.compute_normals(feature_angle=30.0, split_vertices=True, consistent_normals=False)
    actor = plotter.add_mesh(surface, ambient=0.35, diffuse=0.65, smooth_shading=False, **look)
    actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
    if part.edges:
        edges, _ = _poly(points, rims(outside, part.kind), lines=True)
        plotter.add_mesh(edges, color=_LINE, line_width=1.1, lighting=False)


def _add_section(plotter: Any, part: MeshPart, picture: FieldPicture, look: dict[str, Any]) -> None:
    """The plane section of a part, with the cells' edges in it or its rim; drawn in the plane, lines a hair before it."""
    import pyvista

    points = 1e3 * np.asarray(part.points, float)
    cells = np.asarray(part.cells, dtype=np.int64)
    origin, normal = (np.asarray(v, float) for v in picture.cuts[0])
    small = pieces(cells, part.kind)
    kind = pyvista.CellType.TETRA if small.shape[1] == 4 else pyvista.CellType.HEXAHEDRON
    grid = pyvista.UnstructuredGrid({kind: small}, points)
    if part.values is not None:
        grid["values"] = np.asarray(part.values, float)
    plane = {"normal": normal, "origin": 1e3 * origin}
    cut = grid.slice(**plane)
    if cut.n_points == 0:
        return
    plotter.add_mesh(cut, lighting=False, **look)
    ahead = 2e-3 * 1e3 * picture.height * np.asarray(picture.sight, float) / np.linalg.norm(picture.sight)
    if part.edges:
        walls, _ = _poly(points, np.unique(flat(faces(cells, part.kind), part.kind), axis=0))
        lines = walls.slice(**plane)
        if lines.n_points:
            plotter.add_mesh(lines.translate(ahead), color=_LINE, line_width=1.2, lighting=False)
    if part.outline:
        rim, _ = _poly(points, flat(skin(cells, part.kind), part.kind))
        lines = rim.slice(**plane)
        if lines.n_points:
            plotter.add_mesh(lines.translate(ahead), color="#101418", line_width=2.2, lighting=False)


def _render(picture: FieldPicture, path: str) -> None:
    """Build the picture and write it; runs in the child process."""
    import pyvista

    pyvista.OFF_SCREEN = True
    plotter = pyvista.Plotter(off_screen=True, window_size=SIZE, lighting="none")
    plotter.set_background("white")
    shown = [np.asarray(p.values, float) for p in picture.parts if p.values is not None]
    limits = picture.limits
    if limits is None and shown:
        limits = (min(float(np.nanmin(v)) for v in shown), max(float(np.nanmax(v)) for v in shown))
    for part in picture.parts:
        look: dict[str, Any] = {"color": part.colour}
        if part.values is not None:
            look = {"scalars": "values", "cmap": "turbo", "clim": limits, "show_scalar_bar": False}
            look |= {"n_colors": COLOURS, "log_scale": picture.log}
        (_add_section if picture.section else _add_skin)(plotter, part, picture, look)
    if shown and limits:
        plotter.add_scalar_bar(
            picture.label + "\n", mapper=_mapper(plotter), color="black", fmt="%.4g", n_labels=_labels(limits, picture.log), vertical=True,
            position_x=0.865, position_y=0.16, width=0.07, height=0.68, title_font_size=24, label_font_size=24,
        )  # fmt: skip
    _set_view(plotter, picture)
    plotter.screenshot(path)
    plotter.close()


def _labels(limits: tuple[float, float], log: bool) -> int:
    """Number of labels: one for each ten of a scale by tens, else seven, every third step."""
    return round(float(np.log10(limits[1] / limits[0]))) + 1 if log else COLOURS // 3 + 1


def _mapper(plotter: Any) -> Any:
    """Mapper of the first part that shows values."""
    return next(a.mapper for a in plotter.actors.values() if getattr(a.mapper, "scalar_visibility", False))


def _set_view(plotter: Any, picture: FieldPicture) -> None:
    """Camera, lights, words and scale bar."""
    import pyvista

    sight = np.asarray(picture.sight, float) / np.linalg.norm(picture.sight)
    right = np.cross(np.asarray(picture.up, float), sight)
    right /= np.linalg.norm(right)
    up = np.cross(sight, right)
    focus, height = 1e3 * np.asarray(picture.focus, float), 1e3 * picture.height
    plotter.camera.focal_point = focus
    plotter.camera.position = focus + 20.0 * height * sight
    plotter.camera.up = up
    plotter.enable_parallel_projection()
    plotter.camera.parallel_scale = 0.5 * height
    for direction, strength in ((sight + 0.9 * up - 0.4 * right, 0.75), (sight, 0.35), (sight + 1.5 * right, 0.25)):
        light = pyvista.Light(position=focus + 50.0 * height * direction, focal_point=focus, intensity=strength)
        light.positional = False
        plotter.add_light(light)
    near = 4.0 * height * sight
    if picture.words:
        places = np.array([1e3 * np.asarray(p, float) for p, _ in picture.words]) + near
        plotter.add_point_labels(
            places, [t for _, t in picture.words], font_size=26, text_color="black", shape_color="white",
            shape_opacity=0.85, margin=5, show_points=False, always_visible=True, font_family="arial",
            justification_horizontal="center", justification_vertical="center",
        )  # fmt: skip
    if picture.scale_bar:
        half = 0.5 * height * SIZE[0] / SIZE[1]
        start = focus + near - 0.93 * half * right - 0.455 * height * up
        end = start + 1e3 * picture.scale_bar * right
        plotter.add_mesh(pyvista.Line(start, end), color="black", line_width=5, lighting=False)
        plotter.add_point_labels(
            [0.5 * (start + end) + 0.03 * height * up], [f"{1e3 * picture.scale_bar:g} mm"], font_size=26,
            text_color="black", shape_color="white", shape_opacity=0.7, margin=4, show_points=False, always_visible=True,
            font_family="arial", justification_horizontal="center", justification_vertical="center",
        )  # fmt: skip
    plotter.reset_camera_clipping_range()
    plotter.enable_anti_aliasing("ssaa")


if __name__ == "__main__":
    _render(*pickle.load(sys.stdin.buffer))
