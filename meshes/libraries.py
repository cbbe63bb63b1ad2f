"""System libraries that only meshing and pictures need, by the Debian package that holds them, and Python packages of
single files: the one list of them."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping

#: Shared libraries that gmsh loads; everything but meshing runs without.
MESHING = {
    "libGLU.so.1": "libglu1-mesa",
    "libGL.so.1": "libgl1",
    "libXrender.so.1": "libxrender1",
    "libXcursor.so.1": "libxcursor1",
    "libXfixes.so.3": "libxfixes3",
    "libXft.so.2": "libxft2",
    "libXinerama.so.1": "libxinerama1",
    "libfontconfig.so.1": "libfontconfig1",
    "libgomp.so.1": "libgomp1",
}
#: Shared libraries that VTK draws with where there is no screen; everything but 3D pictures runs without.
PICTURES = {"libEGL.so.1": "libegl1", "libGL.so.1": "libgl1", "libXrender.so.1": "libxrender1"}
#: Python packages that one file of the report needs each: the file, and what installs the package.
EXTRAS = {
    "typst": ("the PDF of the first pages", "pip install typst"),
    "trimesh": ("the view that can be turned", "pip install trimesh"),
}


def install(*lists: Mapping[str, str]) -> str:
    """The command that installs the packages of lists, on Debian and what descends from it.

    >>> install(PICTURES)
    'apt-get install libegl1 libgl1 libxrender1'
    """
    names = dict.fromkeys(name for libraries in lists for name in libraries.values())
    return f"apt-get install {' '.join(sorted(names))}"


def missing(libraries: Mapping[str, str]) -> list[str]:
    """Names of the libraries that this process cannot load."""
    lacking = []
    for name in libraries:
        try:
            ctypes.CDLL(name)
        except OSError:
            lacking.append(name)
    return lacking
