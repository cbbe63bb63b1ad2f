"""Pictures drawn by pyvista in a child process: VTK ends its process where a machine has no off-screen OpenGL."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import tempfile
from pathlib import Path

from rollbench.meshes.libraries import PICTURES, install

TIMEOUT = 180.0  # s; two seconds are usual
ADVICE = f"install the off-screen OpenGL libraries (Debian: {install(PICTURES)})"


def draw_in_child(module: str, picture: object, path: str | Path) -> None:
    """Run ``python -m module`` with the pickled (picture, file to write) on its standard input.

    Nothing is imported from the working folder.
    Raises RuntimeError where this machine cannot draw it: says which libraries are missing, or what else went wrong.
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
        raise RuntimeError(f"3D picture: not finished after {TIMEOUT:.0f} s; {ADVICE}") from None
    if child.returncode == 0:
        return
    words = child.stderr.decode(errors="replace").strip().splitlines() or ["no message"]
    if child.returncode < 0:
        raise RuntimeError(f"3D picture: no off-screen OpenGL on this machine; {ADVICE}")
    if words[-1].startswith(("ImportError", "ModuleNotFoundError")):
        raise RuntimeError(f"3D picture: pyvista cannot be loaded ({words[-1]}); install it, and {ADVICE}")
    raise RuntimeError(f"3D picture: {words[-1]}")


def fault() -> str:
    """Why no picture can be drawn here, by drawing a small one (some seconds); empty where it can."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            draw_in_child("rollbench.reports.offscreen", None, Path(folder) / "sphere.png")
        except RuntimeError as error:
            return str(error)
    return ""


def _draw_sphere(path: str) -> None:
    import pyvista

    pyvista.OFF_SCREEN = True
    plotter = pyvista.Plotter(off_screen=True, window_size=(64, 64))
    plotter.add_mesh(pyvista.Sphere())
    plotter.screenshot(path)


if __name__ == "__main__":
    _draw_sphere(pickle.load(sys.stdin.buffer)[1])
