"""3D pictures of finite-element meshes and of fields on them: surfaces, cut open or whole, and plane sections.

The pictures are drawn in a child process, because VTK terminates its process on a machine without off-screen OpenGL.
"""

from __future__ import annotations

import pickle
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from textwrap import fill
from typing import Any

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.exchange.mesh_files import VTK
from rollbench.reports.content import FieldPicture, MeshPart, Picture
from rollbench.reports.figures import COLOURS
from rollbench.reports.offscreen import draw_in_child_process, set_camera_and_lights
from rollbench.reports.scene3d import SIZE

#: VTK's numbers of the element types.
TYPES = {"P1": 10, "P2": 24, "Q2": 29}
#: Number of colours of the colour scale; the borders between them are contour lines.
STEPS = 18
#: Number of colours in the PNG file.
PALETTE = 224
#: Millimetres per metre.
MM = 1e3
_LINE = "#2b3138"


def draw_field_picture(picture: FieldPicture, path: str | Path) -> None:
    """Draw finite-element meshes, or fields on them, to a PNG file; needs no display.

    Parameters
    ----------
    picture
        Meshes, fields, point of view and cutting planes.
    path
        PNG file to write.

    Raises
    ------
    RuntimeError
        If this machine cannot draw; the message names the cause and the libraries to install.
    """
    draw_in_child_process("rollbench.reports.field3d", picture, path)


def drawn_picture(picture: FieldPicture) -> Picture | FieldPicture:
    """Return the drawn picture, without its meshes; the meshes themselves where this machine cannot draw them."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        try:
            draw_field_picture(picture, path)
        except RuntimeError:
            return picture
        return Picture(picture.name, picture.title, np.fromfile(path, np.uint8), picture.caption)


def pyvista_grid_of_part(part: MeshPart) -> Any:
    """Return a finite-element mesh as an unstructured grid of pyvista, in mm, with its values at the nodes as "values"."""
    import pyvista

    cells = np.asarray(part.cells, dtype=np.int64)[:, VTK[part.kind][1]]
    grid = pyvista.UnstructuredGrid({TYPES[part.kind]: cells}, MM * np.asarray(part.points, float))
    if part.values is not None:
        grid["values"] = np.asarray(part.values, float)
    return grid


def triangulated_outer_surface(grid: Any) -> Any:
    """Return the outer surface of a mesh as triangles; a face of a second-order element becomes four or eight triangles.

    ``grid``: mesh, as an unstructured grid of pyvista. The surface is a triangle mesh of pyvista.
    """
    import pyvista
    from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

    divide = vtkDataSetSurfaceFilter()
    divide.SetInputData(grid)
    divide.SetNonlinearSubdivisionLevel(1)
    divide.Update()
    return pyvista.wrap(divide.GetOutput()).triangulate()


def _visible_elements(part: MeshPart, picture: FieldPicture) -> Any:
    """Return the elements of a mesh that are not cut away by the picture's cutting planes, as a grid of pyvista."""
    points, cells, grid = np.asarray(part.points, float), np.asarray(part.cells), pyvista_grid_of_part(part)
    if not picture.cuts:
        return grid
    middle = points[cells[:, : 8 if part.kind == "Q2" else 4]].mean(axis=1)
    front = np.all([(middle - np.asarray(o)) @ np.asarray(n) > 0.0 for o, n in picture.cuts], axis=0)
    return grid.extract_cells(~front)


def _draw_outer_surface(plotter: Any, part: MeshPart, picture: FieldPicture, look: dict[str, Any]) -> None:
    """Draw the surface of a mesh, cut open by the picture's cutting planes, with the element edges if the mesh shows them.

    ``plotter``: plotter of pyvista, to which the surface is added. ``look``: colour settings for pyvista.
    """
    grid = _visible_elements(part, picture)
    if not grid.n_cells:
        return
    surface = triangulated_outer_surface(grid).compute_normals(
        feature_angle=25.0, split_vertices=True, consistent_normals=False
    )
    actor = plotter.add_mesh(surface, ambient=0.35, diffuse=0.65, smooth_shading=True, **look)
    actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
    if part.edges:
        plotter.add_mesh(grid.extract_all_edges(), color=_LINE, line_width=part.line, lighting=False)


def _draw_plane_section(plotter: Any, part: MeshPart, picture: FieldPicture, look: dict[str, Any]) -> None:
    """Draw the plane section through a mesh, with the element edges or the outline slightly in front of the plane.

    ``plotter``: plotter of pyvista, to which the section is added. ``look``: colour settings for pyvista.
    """
    origin, normal = (np.asarray(v, float) for v in picture.cuts[0])
    plane, grid = {"normal": normal, "origin": MM * origin}, pyvista_grid_of_part(part)
    cut = grid.slice(**plane)
    if cut.n_points == 0:
        return
    plotter.add_mesh(cut, lighting=False, **look)
    ahead = 2e-3 * MM * picture.height * np.asarray(picture.sight, float) / np.linalg.norm(picture.sight)
    for wanted, cells, colour, width in (
        (part.edges, grid.separate_cells(), _LINE, 1.3),
        (part.outline, grid, "#101418", 2.4),
    ):
        lines = triangulated_outer_surface(cells).slice(**plane)
        if wanted and lines.n_points:
            plotter.add_mesh(lines.translate(ahead), color=colour, line_width=width, lighting=False)


def _colour_limits(picture: FieldPicture) -> tuple[float, float] | None:
    """Return the ends of the picture's colour scale: those prescribed, or the range of all values; None without values."""
    shown = [np.asarray(p.values, float) for p in picture.parts if p.values is not None]
    if picture.limits is not None or not shown:
        return picture.limits if shown else None
    return min(float(np.nanmin(v)) for v in shown), max(float(np.nanmax(v)) for v in shown)


def _picture_unit_vectors(picture: FieldPicture) -> tuple[Array, Array, Array]:
    """Return three unit vectors (3,): those that point right and upwards in the picture, and the one towards the viewer."""
    sight = np.asarray(picture.sight, float) / np.linalg.norm(picture.sight)
    right = np.cross(np.asarray(picture.up, float), sight)
    right /= np.linalg.norm(right)
    return right, np.cross(sight, right), sight


def _write_field_picture(picture: FieldPicture, path: str) -> None:
    """Draw meshes or fields and write the PNG file ``path``; runs in a child process of `draw_field_picture`."""
    import matplotlib
    import pyvista

    pyvista.OFF_SCREEN = True
    limits = _colour_limits(picture)
    width = round(SIZE[0] * (0.86 if limits else 1.0))
    plotter = pyvista.Plotter(off_screen=True, window_size=(width, SIZE[1]), lighting="none")
    plotter.set_background("white")
    for part in picture.parts:
        look: dict[str, Any] = {"color": part.colour}
        if part.values is not None:
            look = {"scalars": "values", "cmap": COLOURS, "clim": limits, "n_colors": STEPS}
            look |= {"show_scalar_bar": False, "log_scale": picture.log}
        (_draw_plane_section if picture.section else _draw_outer_surface)(plotter, part, picture, look)
    right, up, sight = _picture_unit_vectors(picture)
    lights = ((sight + 0.9 * up - 0.4 * right, 0.75), (sight, 0.35), (sight + 1.5 * right, 0.25))
    set_camera_and_lights(plotter, MM * np.asarray(picture.focus, float), sight, up, MM * picture.height, lights)
    image = plotter.screenshot(None, return_img=True)
    plotter.close()
    with matplotlib.rc_context():
        matplotlib.rcdefaults()  # independent of the user's own settings
        _write_annotated_image(picture, np.asarray(image), limits, path)


def _write_annotated_image(picture: FieldPicture, image: Any, limits: tuple[float, float] | None, path: str) -> None:
    """Add texts, scale bar and colour scale to the drawn image, and write it as a PNG file with few colours.

    ``image``: pixels drawn by pyvista, (rows, columns, 3). ``limits``: ends of the colour scale; None: no scale. ``path``:
    file to write.
    """
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
    right, up, _ = _picture_unit_vectors(picture)
    scale = rows / picture.height
    paper: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "boxstyle": "round,pad=0.25"}
    for place, text in picture.words:
        arm = np.asarray(place, float) - np.asarray(picture.focus, float)
        at = 0.5 * columns + scale * (arm @ right), 0.5 * rows + scale * (arm @ up)
        axes.text(*at, text, fontsize=19, ha="center", va="center", color="black", bbox=paper)
    if picture.scale_bar:
        length, low, left = scale * picture.scale_bar, 34.0, 44.0
        corner, width = (left - 10.0, low - 12.0), max(length, 80.0) + 20.0
        axes.add_patch(matplotlib.patches.FancyBboxPatch(corner, width, 58.0, **(paper | {"boxstyle": "round,pad=6"})))
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
        ticks = list(np.linspace(*limits, STEPS // 3 + 1))
        if picture.log:
            ticks = [m * 10.0**k for k in range(-12, 13) for m in (1.0, 2.0, 5.0) if limits[0] <= m * 10.0**k <= limits[1]]
        bar.set_ticks(ticks, labels=[f"{x:g}" for x in ticks])
        figure.text(columns / SIZE[0] + 0.016, 0.875, fill(picture.label, 12), fontsize=18, va="bottom")
    canvas.draw()
    flat = Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy())
    flat.quantize(PALETTE, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(path, optimize=True)


if __name__ == "__main__":
    _write_field_picture(*pickle.load(sys.stdin.buffer))
