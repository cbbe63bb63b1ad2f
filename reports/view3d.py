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

from rollbench.meshes.helix import ball_layout
from rollbench.meshes.libraries import pip
from rollbench.reports import scene3d
from rollbench.reports.content import LoadedScrew
from rollbench.reports.offscreen import draw_in_child

#: What installs the viewer.
REMEDY = pip("trimesh")
#: Edge of the triangles, as a multiple of that of a picture.
COARSE = 5.0
#: Shares of a colour that are seen in the viewer's light and without it.
DIFFUSE, AMBIENT = 0.45, 0.2
#: What the page says of the mouse.
HOW = "Drag to turn, wheel to come closer, right button to shift; point at a ball for its load."
#: Angle [deg] between faces up to which a surface is shaded as a smooth one.
SMOOTH = 35.0
_STYLE = "position:fixed;left:12px;top:10px;max-width:60ch;font:13px/1.4 sans-serif;color:#1d2127;text-shadow:0 0 3px #fff"
_CORNER = "position:fixed;right:18px;bottom:18px;font:13px/1.2 sans-serif;color:#1d2127"
_VALUE = (
    "position:fixed;pointer-events:none;background:#fff;border:1px solid #8a8f98;border-radius:4px;padding:3px 8px;"
    "font:13px sans-serif"
)
#: The viewer has its camera, scene and renderer under these names; a ball is hit where the first surface under the pointer
#: is its own.
_POINT = """
const known = DATA, shown = document.getElementById("value"), ray = new THREE.Raycaster();
function ballAt(x, y) {
  if (!camera) return -1;
  ray.setFromCamera(new THREE.Vector2(2 * x / innerWidth - 1, 1 - 2 * y / innerHeight), camera);
  const hit = ray.intersectObjects(scene.children, true)[0];
  if (!hit) return -1;
  return known.balls.findIndex(b => hit.point.distanceTo(new THREE.Vector3(b[0], b[1], b[2])) < 1.02 * known.radius);
}
const loading = setInterval(() => {
  if (!camera) return;
  clearInterval(loading);
  scene.traverse(part => {  // the scene's file has no normals; its vertices are apart at edges
    if (!part.isMesh) return;
    part.geometry.computeVertexNormals();
    part.material.flatShading = false;
    part.material.needsUpdate = true;
  });
  render();
}, 50);
addEventListener("pointermove", event => {
  const at = ballAt(event.clientX, event.clientY);
  shown.hidden = at < 0;
  if (at < 0) return;
  shown.textContent = `ball ${at + 1}: ${known.balls[at][3].toFixed(1)} N`;
  shown.style.left = `${event.clientX + 14}px`;
  shown.style.top = `${event.clientY + 10}px`;
});
"""


def view_file(picture: LoadedScrew) -> str:
    """Name of the page of a picture that can be turned."""
    return f"view-{picture.name}.html"


def write_view(picture: LoadedScrew, path: Path, marker: str = "", back: str = "") -> None:
    """Write the page of a loaded screw that can be turned.

    Args:
        picture: the record; lengths in m, forces on the balls in N.
        path: the file to write.
        marker: an HTML element for its head, by which it is known as a page of a report.
        back: the address that the page's link leads to; no link without one.

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
    link = f'<br><a href="{escape(back)}">back</a>' if back else ""
    words = f'<p style="{_STYLE}"><b>{title}</b><br>{escape(picture.caption)} {HOW}{link}</p>'
    head, rest = html.split("<head>", 1)
    rest = rest.replace("trimesh: threejs viewer", title, 1).replace("<body>", f"<body>{words}", 1)
    rest = rest.replace("</body>", f"{_scale(picture)}{_pointer(picture)}</body>", 1)
    path.write_text(f"{head}<head>{marker}{rest}", encoding="utf-8")


def _scale(picture: LoadedScrew) -> str:
    """The scale of the balls' colours, from top to bottom."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    low, high = scene3d.load_scale(picture)
    stops = ", ".join(to_hex(colormaps["viridis"](share)) for share in np.linspace(0.0, 1.0, 9))
    bar = f"height:180px;width:16px;background:linear-gradient(to top, {stops})"
    labels = "".join(f"<span>{value:.4g}</span>" for value in np.linspace(high, low, 5))
    column = "display:flex;flex-direction:column;justify-content:space-between;padding-left:6px"
    return (
        f'<div id="scale" style="{_CORNER}">ball load [N]<div style="display:flex;margin-top:6px">'
        f'<div style="{bar}"></div><div style="{column}">{labels}</div></div></div>'
    )


def _pointer(picture: LoadedScrew) -> str:
    """Label with the load of the ball under the pointer."""
    centres = 1e3 * (ball_layout(picture.scene).centre - np.array([0.0, 0.0, picture.scene.nut.position]))
    data = {
        "radius": 1e3 * scene3d.ball_radius(picture.scene),
        "balls": [[*c, load] for c, load in zip(centres.round(4).tolist(), picture.load.max(axis=1).tolist(), strict=True)],
    }
    return f'<div id="value" style="{_VALUE}" hidden></div><script>{_POINT.replace("DATA", json.dumps(data))}</script>'


@dataclass(frozen=True)
class _Exported:
    """A scene for trimesh's viewer, with its glTF and camera made."""

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
        surface["baseColorFactor"] = [*(DIFFUSE * channel for channel in colour), 1.0]
        material |= {"doubleSided": True, "emissiveFactor": [AMBIENT * channel for channel in colour]}
    return json.dumps(scene, separators=(",", ":")).encode("utf-8")


def _export(picture: LoadedScrew, path: str) -> None:
    """Build the scene and write it as glTF; runs in the child process."""
    import pyvista

    pyvista.OFF_SCREEN = True
    plotter = pyvista.Plotter(off_screen=True, window_size=(800, 600))
    middle = np.array([0.0, 0.0, picture.scene.nut.position * 1e3])  # the viewer's light shines towards the origin
    for mesh, colour in scene3d.bodies(picture, COARSE):
        faces = pyvista.PolyData(mesh.points - middle, mesh.faces)  # without lines, or only these would take the colour
        smooth = faces.compute_normals(feature_angle=SMOOTH, split_vertices=True, cell_normals=False)
        plotter.add_mesh(smooth, color=colour)
    extent = 1e3 * max(picture.scene.nut.outer_diameter, picture.scene.nut.length)
    plotter.camera.focal_point = (0.0, 0.0, 0.0)
    plotter.camera.position = 3.2 * extent * scene3d.sight()
    plotter.camera.up = scene3d.directions()[1]
    plotter.camera.clipping_range = (0.02 * extent, 50.0 * extent)
    plotter.export_gltf(path, rotate_scene=False)
    plotter.close()


if __name__ == "__main__":
    _export(*pickle.load(sys.stdin.buffer))
