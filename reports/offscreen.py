"""Pictures drawn by pyvista in a child process: VTK ends its process where a machine has no off-screen OpenGL."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path

TIMEOUT = 180.0  # s; two seconds are usual
ADVICE = "install the off-screen OpenGL libraries (Debian: apt-get install libegl1 libgl1 libxrender1)"


def draw_in_child(module: str, picture: object, path: str | Path) -> None:
    """Run ``python -m module`` with the pickled (picture, file to write) on its standard input.

    Nothing is imported from the working folder, unless that holds this program.
    Raises RuntimeError where this machine cannot draw it: says which libraries are missing, or what else went wrong.
    """
    here, root = os.getcwd(), str(Path(__file__).resolve().parents[1])
    search = os.pathsep.join([root, *(p for p in sys.path if p and os.path.abspath(p) != here)])
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
