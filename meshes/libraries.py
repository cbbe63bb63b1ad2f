"""System libraries and Python packages that only some functions need, and the commands that install them."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from functools import cache
from importlib import import_module, metadata

#: Shared libraries that gmsh loads for meshing, each with the Debian package that contains it.
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
#: Shared libraries with which VTK draws 3D pictures where there is no screen, each with its Debian package.
PICTURES = {"libEGL.so.1": "libegl1", "libGL.so.1": "libgl1", "libXrender.so.1": "libxrender1"}
#: Python packages that are optional, and the extra of rollbench that installs each; all commands need the other packages.
EXTRA = {
    **dict.fromkeys(("gmsh", "scikit-fem", "meshio", "h5py", "pymetis"), "reference"),
    **dict.fromkeys(("matplotlib", "pillow", "jinja2", "pyvista"), "report"),
    **dict.fromkeys(("dask", "distributed"), "cluster"),
    **dict.fromkeys(("pyarrow", "xarray"), "tables"),
}
#: What is missing without a package that meshes or solves the 3D reference.
_NO_RUN = "no run of the 3D reference is computed; stored ones are read"
#: What rollbench cannot do, or does more slowly, without an optional Python package, by the name of the package.
ONLY_FOR = {
    "gmsh": f"no 3D meshes: no export and no condense, {_NO_RUN}",
    "meshio": "no export of meshes",
    "h5py": "no export as MED",
    "scikit-fem": f"no export of meshes, no whole report, no 3D model of rolling, {_NO_RUN}",
    "pymetis": _NO_RUN,
    "pyvista": "the report has no 3D pictures",
    "pillow": "no report",
    "jinja2": "no report",
    "dask": "no sweep or reference on a cluster",
    "distributed": "no sweep or reference on a cluster",
    "pyarrow": "no tables as Parquet",
    "xarray": "no tables as netCDF",
    "matplotlib": "no report; compare, mesh-study, sweep and the curve of solve write tables without figures",
}
#: Optional Python packages that are needed to compute a run of the 3D reference.
REFERENCE = ("gmsh", "scikit-fem", "pymetis")
#: Optional Python packages that are needed to write the pages of a report.
PAGES = ("matplotlib", "pillow", "jinja2")
#: Name under which a Python package is imported, where it differs from the name of the package.
_MODULES = {"scikit-fem": "skfem", "pillow": "PIL"}


def pip_command(package: str) -> str:
    """Return the pip command that installs a Python package, by an optional extra of rollbench where one contains it.

    Parameters
    ----------
    package
        Name of the package.

    Examples
    --------
    >>> pip_command("gmsh")
    "pip install 'rollbench[reference]'"
    """
    extra = EXTRA.get(package)
    return f"pip install 'rollbench[{extra}]'" if extra else f"pip install {package}"


def optional_package_of_module(module: str | None) -> str:
    """Return the optional Python package to which a module belongs; an empty text for a module of no such package.

    Parameters
    ----------
    module
        Name of the module, with or without those that contain it, such as ``ImportError.name``.

    Examples
    --------
    >>> optional_package_of_module("skfem.helpers"), optional_package_of_module("numpy"), optional_package_of_module(None)
    ('scikit-fem', '', '')
    """
    top = (module or "").partition(".")[0]
    return next((package for package in EXTRA if _MODULES.get(package, package) == top), "")


@cache
def reason_of_failed_import(package: str) -> str:
    """Return in words why a Python package cannot be imported.

    Parameters
    ----------
    package : str
        Name of the package.

    Returns
    -------
    str
        The reason; an empty text where the package can be imported.

    Examples
    --------
    >>> reason_of_failed_import("numpy"), reason_of_failed_import("no-such-package")
    ('', 'no-such-package is not installed')
    """
    try:
        import_module(_MODULES.get(package, package))
    except Exception as error:  # a damaged package can raise any exception
        if installed_version(package) is None:
            return f"{package} is not installed"
        return f"{package} cannot be imported ({type(error).__name__}: {error})"
    return ""


def installed_version(package: str) -> str | None:
    """Return the version of an installed Python package; None where it is not installed.

    Parameters
    ----------
    package
        Name of the package.
    """
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def apt_command(*lists: Mapping[str, str]) -> str:
    """Return the command that installs system libraries on Debian and its derivatives.

    Parameters
    ----------
    *lists : dict
        Debian package of each system library by the library's name, such as `MESHING`.

    Examples
    --------
    >>> apt_command(PICTURES)
    'apt-get install libegl1 libgl1 libxrender1'
    """
    names = dict.fromkeys(name for libraries in lists for name in libraries.values())
    return f"apt-get install {' '.join(sorted(names))}"


def missing_system_libraries(libraries: Mapping[str, str]) -> list[str]:
    """Return the names of those system libraries that this process cannot load.

    Parameters
    ----------
    libraries : Mapping[str, str]
        Debian package of each system library by the library's name, such as `MESHING`.
    """
    lacking = []
    for name in libraries:
        try:
            ctypes.CDLL(name)
        except OSError:
            lacking.append(name)
    return lacking
