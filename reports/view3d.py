"""A loaded screw that can be turned: glTF written by pyvista, in a page of its own with the viewer that trimesh brings.

The page holds scene and viewer and loads nothing, so that it works from a file without network. pyvista runs in a child
process, as for pictures.
"""

from __future__ import annotations

import json
import pickle
import sys
from dataclasses import dataclass
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from rollbench.meshes.libraries import EXTRAS
from rollbench.reports import scene3d
from rollbench.reports.offscreen import draw_in_child
from rollbench.reports.records import LoadedScrew

#: What installs the viewer.
REMEDY = EXTRAS["trimesh"][1]
#: Edge of the triangles, as a multiple of that of a picture.
COARSE = 5.0
#: Shares of a colour that are seen in the viewer's light and without it.
DIFFUSE, AMBIENT = 0.45, 0.2
#: What the page says of the mouse.
HOW = "Drag to turn, wheel to come closer, right button to shift."
_STYLE = "position:fixed;left:12px;top:10px;max-width:60ch;font:13px/1.4 sans-serif;color:#1d2127;text-shadow:0 0 3px #fff"


def view_file(picture: LoadedScrew) -> str:
    """Name of the page of a picture that can be turned."""
    return f"view-{picture.name}.html"


def write_view(picture: LoadedScrew, path: Path, marker: str, back: str) -> None:
    """Write the page of a loaded screw that can be turned.

    Args:
        picture: the record; lengths in m, forces on the balls in N.
        path: the file to write.
        marker: an HTML element for its head, by which it is known as a page of a report.
        back: the address that the page's link leads to.

    Raises:
        ImportError: trimesh is not installed.
        RuntimeError: pyvista cannot write the scene on this machine; says what is missing.
    """
    from trimesh.viewer import scene_to_html

    with TemporaryDirectory() as folder:
        scene = Path(folder) / "scene.gltf"
        draw_in_child("rollbench.reports.view3d", picture, scene)
        html: str = scene_to_html(_Exported(_finished(scene.read_text(encoding="utf-8"))))
    title = escape(picture.title)
    words = (
        f'<p style="{_STYLE}"><b>{title}</b><br>{escape(picture.caption)} {HOW}<br><a href="{escape(back)}">back</a></p>'
    )
    head, rest = html.split("<head>", 1)
    rest = rest.replace("trimesh: threejs viewer", title, 1).replace("<body>", f"<body>{words}", 1)
    path.write_text(f"{head}<head>{marker}{rest}", encoding="utf-8")


@dataclass(frozen=True)
class _Exported:
    """A scene as trimesh's viewer asks for one: its glTF is there already, and has a camera."""

    gltf: bytes
    camera: None = None

    def export(self, file_type: str) -> bytes:  # noqa: ARG002 - the viewer takes both kinds of glTF
        return self.gltf


def _finished(gltf: str) -> bytes:
    """The exported scene with surfaces that show both sides, as bright as they are meant in the viewer's light."""
    scene = json.loads(gltf)
    for material in scene["materials"]:
        surface = material["pbrMetallicRoughness"]
        colour = surface["baseColorFactor"][:3]
        surface["baseColorFactor"] = [*(DIFFUSE * part for part in colour), 1.0]
        material |= {"doubleSided": True, "emissiveFactor": [AMBIENT * part for part in colour]}
    return json.dumps(scene, separators=(",", ":")).encode("utf-8")


def _export(picture: LoadedScrew, path: str) -> None:
    """Build the scene and write it as glTF; runs in the child process."""
    import pyvista

    pyvista.OFF_SCREEN = True
    plotter = pyvista.Plotter(off_screen=True, window_size=(800, 600))
    middle = np.array([0.0, 0.0, picture.nut_position * 1e3])  # the viewer's light shines towards the origin
    for mesh, colour in scene3d.bodies(picture, COARSE):
        faces = pyvista.PolyData(mesh.points - middle, mesh.faces)  # without lines, which would take the colour alone
        plotter.add_mesh(faces, color=colour)
    extent = 1e3 * max(2.0 * picture.nut_radius, picture.nut_length)
    plotter.camera.focal_point = (0.0, 0.0, 0.0)
    plotter.camera.position = 3.2 * extent * scene3d.sight()
    plotter.camera.up = scene3d.directions()[1]
    plotter.camera.clipping_range = (0.02 * extent, 50.0 * extent)
    plotter.export_gltf(path, rotate_scene=False)
    plotter.close()


if __name__ == "__main__":
    _export(*pickle.load(sys.stdin.buffer))
