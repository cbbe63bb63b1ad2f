"""3D picture of a loaded screw: the nut is cut open, balls are coloured by their load, contact forces are arrows.

The picture is drawn in a child process, because VTK terminates its process on a machine without off-screen OpenGL. If that
happens, an exception says which libraries to install.
"""

from __future__ import annotations

import pickle
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout, lead_per_radian
from rollbench.meshes.parts import Scene
from rollbench.reports.content import LoadedScrew
from rollbench.reports.offscreen import draw_in_child_process, set_camera_and_lights

#: Width and height of a picture [pixels].
SIZE = (1600, 900)

_VIEW = np.radians(155.0)  # azimuth of the viewer and of the opening in the nut; z points to the right
_ARROW = 3.6  # length of the longest arrow, in ball radii
#: Colours of shaft, nut, and cut faces of the nut.
STEEL, _NUT, _CUT = "#c3c8ce", "#9fb0c2", "#5f7d9c"
_SCREW_SIDE, _NUT_SIDE, _IDLE = "#d1495b", "#1b1f24", "#eeeeee"

#: Surface given by a grid of points: their radius [m], azimuth [rad] and axial position [m], each (rows, columns).
Grid = tuple[Array, Array, Array]


def draw_loaded_screw(picture: LoadedScrew, path: str | Path) -> None:
    """Draw a loaded screw with its nut and balls to a PNG file; needs no display.

    Parameters
    ----------
    picture
        Geometry, contact loads and contact forces.
    path
        PNG file to write.

    Raises
    ------
    RuntimeError
        If this machine cannot draw; the message names the cause and the libraries to install.
    """
    draw_in_child_process("rollbench.reports.scene3d", picture, path)


@dataclass(frozen=True)
class _DrawnGrooves:
    """Gothic-arch grooves of a screw and its nut as they are drawn, along helices.

    Each start of the screw is one helix: ``z = axial_offset + advance_per_radian * (phi - start_azimuth)``, where phi is
    the azimuth [rad].
    """

    #: Pitch radius of the ball track [m].
    track_radius: float
    #: Groove radius: radius of the two arcs of the gothic arch [m].
    groove_radius: float
    #: Offset of the centre of each arc from the centre of the balls [m]; it is equal in radial direction and across the
    #: groove.
    arc_centre_offset: float
    #: Axial advance of the helix per angle [m/rad].
    advance_per_radian: float
    #: Azimuth of each start [rad].
    start_azimuths: Array
    #: Axial distance between neighbouring grooves [m].
    groove_spacing: float
    #: Axial position of each helix at its start azimuth [m].
    axial_offset: float

    def groove_depth(self, phi: Array, z: Array) -> Array:
        """Return the radial distance of the groove surface from the pitch radius [m] at azimuth phi [rad], position z [m].

        It is nan outside the groove. It is the same for the screw's groove, where it is measured inwards, and for the
        nut's groove, where it is measured outwards.
        """
        path = self.axial_offset + self.advance_per_radian * (phi[..., None] - self.start_azimuths)
        away = z[..., None] - path
        if self.groove_spacing > 0.0:
            away = (away + 0.5 * self.groove_spacing) % self.groove_spacing - 0.5 * self.groove_spacing
        lead_angle = np.arctan(abs(self.advance_per_radian) / self.track_radius)
        reach = np.min(np.abs(away), axis=-1) * np.cos(lead_angle) + self.arc_centre_offset
        half: Array = (
            np.sqrt(np.where(reach < self.groove_radius, self.groove_radius**2 - reach**2, np.nan)) - self.arc_centre_offset
        )
        return half

    def surface_radius(self, phi: Array, z: Array, land_radius: float) -> Array:
        """Return the radius [m] of the grooved surface of screw or nut at azimuth phi [rad] and axial position z [m].

        ``land_radius``: radius between the grooves [m]. The surface is that of the screw if this radius is smaller than the
        pitch radius, and that of the nut otherwise.
        """
        depth = self.groove_depth(phi, z)
        if land_radius < self.track_radius:
            return np.fmin(land_radius, self.track_radius - depth)
        return np.fmax(land_radius, self.track_radius + depth)


def _drawn_grooves(scene: Scene) -> _DrawnGrooves:
    """Return the grooves of a scene, for drawing, as gothic arches that touch the balls at a contact angle of 45°."""
    track, radius = scene.track, scene.screw.groove_radius
    phases = track.phase + 2.0 * np.pi * np.arange(track.starts) / track.starts
    offset = (radius - drawn_ball_radius(scene)) * np.sqrt(0.5)
    return _DrawnGrooves(track.pitch_radius, radius, offset, lead_per_radian(track), phases, track.lead, scene.nut.position)


def drawn_ball_radius(scene: Scene) -> float:
    """Return the radius [m] with which all balls are drawn: that of the largest ball of the scene."""
    return float(draw_geometry_with_errors(scene, ball_layout(scene)).ball_radii.max())


def _grooved_cylinder_grid(
    grooves: _DrawnGrooves, phi: Array, ends: tuple[float, float], step: float
) -> tuple[Array, Array]:
    """Return azimuths [rad] and axial positions [m] of the grid points on a grooved cylinder, each (rows, columns).

    The grid lines follow the helix of the groove, so that the groove's edges are sharp. ``phi``: azimuths of the rows
    [rad]. ``ends``: axial range [m]. ``step``: axial distance of the grid lines [m].
    """
    rise = grooves.advance_per_radian * (phi - phi[0])
    low, high = ends[0] - max(rise.max(), 0.0), ends[1] - min(rise.min(), 0.0)
    lines = np.linspace(low, high, max(2, round((high - low) / step)))
    z = np.clip(lines[None, :] + rise[:, None], *ends)
    return np.broadcast_to(phi[:, None], z.shape), z


def _pyvista_mesh_of_surface(grid: Grid) -> Any:
    """Return a surface as a triangle mesh of pyvista, in mm.

    ``grid``: radius [m], azimuth [rad] and axial position [m] of its points.
    """
    import pyvista

    sheet = pyvista.StructuredGrid(*(np.ascontiguousarray(1e3 * x)[..., None] for x in cylindrical_to_cartesian(grid)))
    return sheet.extract_geometry().triangulate().clean(tolerance=1e-9, absolute=True)


def cylindrical_to_cartesian(grid: Grid) -> tuple[Array, Array, Array]:
    """Return x, y, z [m] of surface points that are given by radius [m], azimuth [rad] and axial position [m]."""
    radius, phi, z = grid
    return radius * np.cos(phi), radius * np.sin(phi), z


def _screw_surfaces_near_nut(scene: Scene, coarsening: float = 1.0, length_beyond_nut: float = 0.8) -> list[Grid]:
    """Return the surfaces of the part of the screw near the nut: the grooved surface, both end faces, and the bore.

    Parameters
    ----------
    scene
        Geometry of screw and nut.
    coarsening
        Step of the grid, as a multiple of the step used in a picture.
    length_beyond_nut
        Length of screw that is drawn on each side of the nut's centre, as a multiple of the nut's length.
    """
    grooves, half = _drawn_grooves(scene), length_beyond_nut * scene.nut.length
    low = max(0.0, scene.nut.position - half)
    high = min(max(scene.screw.length, low + 0.1 * half), scene.nut.position + half)
    back = _VIEW + np.pi
    around = np.linspace(back, back + 2.0 * np.pi, round(360 / coarsening) + 1)
    phi, z = _grooved_cylinder_grid(grooves, around, (low, high), 0.06 * coarsening * drawn_ball_radius(scene))
    radius = grooves.surface_radius(phi, z, scene.screw.outer_diameter / 2.0)
    grids, inner = [(radius, phi, z)], scene.screw.bore / 2.0
    for column in (0, -1):
        share = np.linspace(0.0, 1.0, 12)[None, :]
        flat = np.zeros_like(share)
        grids.append((inner + (radius[:, column, None] - inner) * share, phi[:, :1] + flat, z[:, column, None] + flat))
    if inner > 0.0:
        ends = z[:, [0, -1]]
        grids.append((np.full_like(ends, inner), phi[:, :2], ends))
    return grids


def _opened_nut_surfaces(scene: Scene, coarsening: float = 1.0) -> tuple[list[Grid], list[Grid]]:
    """Return two lists: surfaces of the half of the nut behind the screw, and this half's two cut faces.

    ``coarsening``: step of the grid, as a multiple of the step used in a picture.
    """
    grooves = _drawn_grooves(scene)
    bore = 2.0 * scene.track.pitch_radius - scene.screw.outer_diameter / 2.0
    ends = (scene.nut.position - 0.5 * scene.nut.length, scene.nut.position + 0.5 * scene.nut.length)
    around = np.linspace(_VIEW + 0.5 * np.pi, _VIEW + 1.5 * np.pi, round(180 / coarsening) + 1)
    phi, z = _grooved_cylinder_grid(grooves, around, ends, 0.06 * coarsening * drawn_ball_radius(scene))
    inner = np.minimum(grooves.surface_radius(phi, z, bore), 0.98 * scene.nut.outer_diameter / 2.0)
    outer = np.full_like(inner, scene.nut.outer_diameter / 2.0)
    share = np.linspace(0.0, 1.0, 8)

    def radial_face(index: Any) -> Grid:
        """Return a flat face of the half nut, from bore to outer diameter, at one edge of the grid of the nut's bore.

        ``index``: index of this edge in the arrays of the grid, the first or last of its rows or columns.
        """
        wall = inner[index][:, None] * (1.0 - share) + outer[index][:, None] * share
        flat = np.zeros_like(wall)
        return wall, phi[index][:, None] + flat, z[index][:, None] + flat

    everywhere = slice(None)
    body = [(inner, phi, z), (outer, phi, z)]
    body += [radial_face((everywhere, 0)), radial_face((everywhere, -1))]
    return body, [radial_face((0, everywhere)), radial_face((-1, everywhere))]


def viewer_and_upward_vectors() -> tuple[Array, Array]:
    """Return two unit vectors normal to the screw's axis: one towards the viewer, and one upwards in the picture."""
    cosine, sine = np.cos(_VIEW), np.sin(_VIEW)
    return np.array([cosine, sine, 0.0]), np.array([sine, -cosine, 0.0])


def direction_to_viewer() -> Array:
    """Return the unit vector from the nut to the viewer: out of the nut's open side, slightly upwards and towards +z."""
    outward, upward = viewer_and_upward_vectors()
    eye: Array = outward + 0.22 * upward + 0.34 * np.array([0.0, 0.0, 1.0])
    return eye / float(np.linalg.norm(eye))


def screw_and_nut_surfaces_by_colour(scene: Scene, coarsening: float, length_beyond_nut: float) -> dict[str, list[Grid]]:
    """Return the surfaces of the screw, of the opened nut and of the nut's cut faces, by their colour.

    ``coarsening``: step of the grid, as a multiple of the step used in a picture. ``length_beyond_nut``: length of screw
    that is drawn on each side of the nut's centre, as a multiple of the nut's length.
    """
    body, cuts = _opened_nut_surfaces(scene, coarsening)
    return {STEEL: _screw_surfaces_near_nut(scene, coarsening, length_beyond_nut), _NUT: body, _CUT: cuts}


def _write_loaded_screw_picture(picture: LoadedScrew, path: str) -> None:
    """Draw a loaded screw and write the PNG file ``path``; runs in a child process of `draw_loaded_screw`."""
    import pyvista
    from PIL import Image

    pyvista.OFF_SCREEN = True
    plotter = pyvista.Plotter(off_screen=True, window_size=SIZE, lighting="none")
    plotter.set_background("white")
    steel = {"smooth_shading": True, "ambient": 0.3, "diffuse": 0.7, "specular": 0.35, "specular_power": 25}
    # In a parallel projection, a shift along the line of sight does not change the image of a body. The screw is moved
    # back by the length of an arrow, so that it does not hide the arrows of the forces that it exerts.
    behind = -1e3 * _ARROW * drawn_ball_radius(picture.scene) * direction_to_viewer()
    for grid in _screw_surfaces_near_nut(picture.scene):
        plotter.add_mesh(_pyvista_mesh_of_surface(grid).translate(behind), color=STEEL, **steel)
    body, cuts = _opened_nut_surfaces(picture.scene)
    for grid in body:
        plotter.add_mesh(_pyvista_mesh_of_surface(grid), color=_NUT, **steel)
    for grid in cuts:
        plotter.add_mesh(_pyvista_mesh_of_surface(grid), color=_CUT, ambient=0.6, diffuse=0.4)
    _draw_balls(plotter, picture)
    _draw_contact_forces(plotter, picture)
    _set_camera_and_axes(plotter, picture)
    seen = Image.fromarray(plotter.screenshot(return_img=True))
    plotter.close()
    seen.quantize(method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(path, optimize=True)


def _rounded_colour_limits(low: float, high: float) -> tuple[float, float, int]:
    """Return round limits of a colour scale that contains ``low`` and ``high``, and the number of evenly spaced labels."""
    if high - low < 1e-3 * high:
        low, high = 0.9 * low, 1.1 * high
    decade = 10.0 ** np.floor(np.log10((high - low) / 4.0))
    least = (high - low) / 4.0 - 1e-12 * high
    step = next(m * decade for m in (1.0, 2.0, 2.5, 5.0, 10.0, 20.0) if m * decade >= least)
    first, last = np.floor(low / step + 1e-9), np.ceil(high / step - 1e-9)
    return float(first * step), float(last * step), int(last - first) + 1


def _draw_balls(plotter: Any, picture: LoadedScrew) -> None:
    """Draw the balls with colours by their largest contact load, unloaded balls white, and the colour scale.

    ``plotter``: plotter of pyvista, to which they are added. ``picture``: geometry and loads.
    """
    import pyvista

    centres = 1e3 * ball_layout(picture.scene).centre
    loads = picture.load.max(axis=1)
    ball = pyvista.Sphere(radius=drawn_ball_radius(picture.scene) * 1e3, theta_resolution=40, phi_resolution=40)
    finish = {"smooth_shading": True, "ambient": 0.3, "diffuse": 0.7, "specular": 0.5, "specular_power": 30}
    idle = ~(loads > 0.0)
    if np.any(idle):
        unloaded = pyvista.PolyData(centres[idle]).glyph(geom=ball, scale=False, orient=False)
        plotter.add_mesh(unloaded, color=_IDLE, **finish)
        words = "White balls carry no load"
        plotter.add_text(words, position=(40, 132), font_size=10, color="black", font="arial")
    if np.all(idle):
        return
    cloud = pyvista.PolyData(centres[~idle])
    cloud["load"] = loads[~idle]
    low, high, labels = _rounded_colour_limits(float(loads[~idle].min()), float(loads[~idle].max()))
    plotter.add_mesh(
        cloud.glyph(geom=ball, scale=False, orient=False),
        scalars="load",
        cmap="viridis",
        clim=(low, high),
        scalar_bar_args={
            "title": "Ball load [N]\n",
            "color": "black",
            "fmt": "%.4g",
            "n_labels": labels,
            "position_x": 0.60,
            "position_y": 0.035,
            "width": 0.36,
            "height": 0.085,
            "title_font_size": 22,
            "label_font_size": 20,
        },
        **finish,
    )


def _contact_force_arrows(picture: LoadedScrew) -> Iterator[tuple[Any, str]]:
    """Yield the arrows of the contact forces on the balls with their colour: first from the screw, then from the nut.

    The arrows are a mesh of pyvista, in mm. They end at the contacts, and their lengths are proportional to the forces.
    Only contacts on the open side of the nut have an arrow.
    """
    import pyvista

    points = 1e3 * picture.contact_points
    forces = picture.contact_forces
    size = np.linalg.norm(forces, axis=1)
    longest = _ARROW * drawn_ball_radius(picture.scene) * 1e3
    facing = points[:, :2] @ np.array([np.cos(_VIEW), np.sin(_VIEW)]) > -0.02 * picture.scene.track.pitch_radius * 1e3
    inside = np.hypot(points[:, 0], points[:, 1]) < picture.scene.track.pitch_radius * 1e3
    for group, colour in ((inside, _SCREW_SIDE), (~inside, _NUT_SIDE)):
        chosen = facing & group & (size > 1e-3 * size.max(initial=0.0))
        if not np.any(chosen):
            continue
        arrows = pyvista.PolyData(points[chosen] - forces[chosen] / size.max() * longest)
        arrows["force"] = forces[chosen] / size.max() * longest
        arrow = pyvista.Arrow(tip_length=0.28, tip_radius=0.075, shaft_radius=0.028)
        yield arrows.glyph(orient="force", scale="force", geom=arrow), colour


def _draw_contact_forces(plotter: Any, picture: LoadedScrew) -> None:
    """Draw the arrows of the contact forces on the balls, and the legend of their colours.

    ``plotter``: plotter of pyvista, to which they are added. ``picture``: geometry and contact forces.
    """
    size = np.linalg.norm(picture.contact_forces, axis=1)
    if not np.any(size > 0.0):
        return
    for mesh, colour in _contact_force_arrows(picture):
        plotter.add_mesh(mesh, color=colour, ambient=0.45, diffuse=0.55, smooth_shading=True)
    for text, colour, height in (
        ("Forces on the balls:", "black", 96),
        ("from the screw", _SCREW_SIDE, 66),
        (f"from the nut; longest arrow {size.max():.4g} N", _NUT_SIDE, 36),
    ):
        plotter.add_text(text, position=(40, height), font_size=10, color=colour, font="arial")


def _set_camera_and_axes(plotter: Any, picture: LoadedScrew) -> None:
    """Set the camera and the lights of the plotter, and draw the directions of the axes x, y, z."""
    outward, upward = viewer_and_upward_vectors()
    extent = 1e3 * max(picture.scene.nut.outer_diameter, 1.6 * picture.scene.nut.length * SIZE[1] / SIZE[0])
    focus = np.array([0.0, 0.0, picture.scene.nut.position * 1e3]) - 0.05 * extent * upward
    above = outward + 1.4 * upward - np.array([0.0, 0.0, 0.6])
    beside = outward - 0.3 * upward + np.array([0.0, 0.0, 2.5])
    set_camera_and_lights(
        plotter,
        focus,
        direction_to_viewer(),
        upward,
        1.32 * extent,
        ((above, 0.75), (direction_to_viewer(), 0.3), (beside, 0.3)),
    )
    plotter.add_axes(xlabel="x", ylabel="y", zlabel="z", line_width=4, color="black", viewport=(0.0, 0.72, 0.16, 1.0))


if __name__ == "__main__":
    _write_loaded_screw_picture(*pickle.load(sys.stdin.buffer))
