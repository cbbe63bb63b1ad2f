"""Draw 3D pictures with pyvista in a child process, because VTK ends its process where off-screen OpenGL is missing."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rollbench.meshes.arrays import Array
from rollbench.meshes.libraries import PICTURES, apt_command

#: Time after which drawing a picture is aborted [s]; two seconds are usual.
TIMEOUT = 180.0
#: Advice in the message of `DrawingError`.
ADVICE = f"install the off-screen OpenGL libraries (Debian: {apt_command(PICTURES)})"

#: Lights of a picture: direction and intensity of each.
Lights = Sequence[tuple[Array, float]]


class DrawingError(RuntimeError):
    """Error: a 3D picture could not be drawn. Its message gives the cause and advice."""

    def __init__(self, cause: str, advice: str = "") -> None:
        """Store the cause, and compose the message from cause and advice.

        ``advice``: what the user can do about it; empty: no advice.
        """
        super().__init__(f"3D picture: {cause}" + (f"; {advice}" if advice else ""))
        self.cause = cause


def draw_in_child_process(module: str, picture: object, path: str | Path) -> None:
    """Draw a 3D picture in a child process, by running a module with ``python -m``.

    The module reads the picture and the path of the file, pickled, from its standard input. It imports nothing from the
    current directory.

    Parameters
    ----------
    module
        Full name of the module that draws the picture.
    picture
        Contents of the picture.
    path
        PNG file to write.

    Raises
    ------
    DrawingError
        If this machine cannot draw; the message names the cause and the libraries to install.
    """
    here = os.getcwd()
    search = os.pathsep.join(p for p in sys.path if p and os.path.abspath(p) != here)
    try:
        child = subprocess.run(
            [sys.executable, "-P", "-m", module],
            input=pickle.dumps((picture, str(Path(path).resolve()))),
            capture_output=True,
            timeout=TIMEOUT,
            env={**os.environ, "PYTHONPATH": search},
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise DrawingError(f"drawing took longer than {TIMEOUT:.0f} s and was aborted", ADVICE) from None
    if child.returncode == 0:
        return
    words = child.stderr.decode(errors="replace").strip().splitlines() or ["no message"]
    if child.returncode < 0:
        raise DrawingError("this machine has no off-screen OpenGL", ADVICE)
    if words[-1].startswith(("ImportError", "ModuleNotFoundError")):
        raise DrawingError(f"pyvista cannot be loaded ({words[-1]})", f"install it, and {ADVICE}")
    raise DrawingError(words[-1])


def set_camera_and_lights(
    plotter: Any, focus: Array, toward_viewer: Array, up: Array, height: float, lights: Lights
) -> None:
    """Set the camera (parallel projection), the lights and the anti-aliasing of a pyvista plotter.

    Parameters
    ----------
    plotter
        Plotter of pyvista that draws the picture.
    focus
        Point in the middle of the picture [mm].
    toward_viewer, up
        Unit vectors towards the viewer and upwards in the picture.
    height
        Visible height [mm].
    lights
        Direction and intensity of each light.
    """
    import pyvista

    plotter.camera.focal_point = focus
    plotter.camera.position = focus + 20.0 * height * toward_viewer
    plotter.camera.up = up
    plotter.enable_parallel_projection()
    plotter.camera.parallel_scale = 0.5 * height
    for direction, strength in lights:
        light = pyvista.Light(position=focus + 50.0 * height * direction, focal_point=focus, intensity=strength)
        light.positional = False
        plotter.add_light(light)
    plotter.reset_camera_clipping_range()
    plotter.enable_anti_aliasing("ssaa")


def reason_drawing_fails() -> str:
    """Draw a test picture, for some seconds, and return the reason if this machine cannot draw; empty if it can."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            draw_in_child_process("rollbench.reports.offscreen", None, Path(folder) / "sphere.png")
        except DrawingError as error:
            return error.cause
    return ""


def _draw_test_picture(path: str) -> None:
    """Write a PNG file with a picture of a sphere, to test whether this machine can draw."""
    import pyvista

    pyvista.OFF_SCREEN = True
    plotter = pyvista.Plotter(off_screen=True, window_size=(64, 64))
    plotter.add_mesh(pyvista.Sphere())
    plotter.screenshot(path)


if __name__ == "__main__":
    _draw_test_picture(pickle.load(sys.stdin.buffer)[1])
