"""Drawing by pyvista in a child process, because VTK ends its process on a machine without off-screen OpenGL."""

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

TIMEOUT = 180.0  # s; two seconds are usual
ADVICE = f"install the off-screen OpenGL libraries (Debian: {apt_command(PICTURES)})"

#: Directions and intensities of lights.
Lights = Sequence[tuple[Array, float]]


class CannotDraw(RuntimeError):
    """Error for a picture that could not be drawn, with its cause and advice."""

    def __init__(self, cause: str, advice: str = "") -> None:
        """Make the message from cause and advice."""
        super().__init__(f"3D picture: {cause}" + (f"; {advice}" if advice else ""))
        self.cause = cause


def draw_in_child(module: str, picture: object, path: str | Path) -> None:
    """Run ``python -m module`` with the pickled (picture, file to write) on its standard input.

    Nothing is imported from the working folder.

    Parameters
    ----------
    module
        Module that draws.
    picture
        Record of the picture.
    path
        File to write.

    Raises
    ------
    CannotDraw
        If this machine cannot draw it: names missing libraries, or the cause.
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
        raise CannotDraw(f"not finished after {TIMEOUT:.0f} s", ADVICE) from None
    if child.returncode == 0:
        return
    words = child.stderr.decode(errors="replace").strip().splitlines() or ["no message"]
    if child.returncode < 0:
        raise CannotDraw("no off-screen OpenGL on this machine", ADVICE)
    if words[-1].startswith(("ImportError", "ModuleNotFoundError")):
        raise CannotDraw(f"pyvista cannot be loaded ({words[-1]})", f"install it, and {ADVICE}")
    raise CannotDraw(words[-1])


def set_view(plotter: Any, focus: Array, sight: Array, up: Array, height: float, lights: Lights) -> None:
    """Set the camera (parallel projection), lights and anti-aliasing of a plotter.

    Parameters
    ----------
    plotter
        Plotter of pyvista.
    focus
        Point in the middle.
    sight, up
        Unit vectors to the viewer and upwards.
    height
        Visible height.
    lights
        Directions and intensities of lights.
    """
    import pyvista

    plotter.camera.focal_point = focus
    plotter.camera.position = focus + 20.0 * height * sight
    plotter.camera.up = up
    plotter.enable_parallel_projection()
    plotter.camera.parallel_scale = 0.5 * height
    for direction, strength in lights:
        light = pyvista.Light(position=focus + 50.0 * height * direction, focal_point=focus, intensity=strength)
        light.positional = False
        plotter.add_light(light)
    plotter.reset_camera_clipping_range()
    plotter.enable_anti_aliasing("ssaa")


def drawing_fault() -> str:
    """Return why 3D pictures cannot be drawn on this machine, after a trial of some seconds; empty if they can."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            draw_in_child("rollbench.reports.offscreen", None, Path(folder) / "sphere.png")
        except CannotDraw as error:
            return error.cause
    return ""


def _draw_sphere(path: str) -> None:
    """Write a PNG of a sphere, as a trial whether this machine can draw."""
    import pyvista

    pyvista.OFF_SCREEN = True
    plotter = pyvista.Plotter(off_screen=True, window_size=(64, 64))
    plotter.add_mesh(pyvista.Sphere())
    plotter.screenshot(path)


if __name__ == "__main__":
    _draw_sphere(pickle.load(sys.stdin.buffer)[1])
