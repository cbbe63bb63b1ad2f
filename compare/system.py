"""What the machine must have for the 3D reference, checked before anything is computed."""

from __future__ import annotations

from compare.errors import InputError

#: Debian packages of the shared libraries that gmsh loads.
PACKAGES = "libglu1-mesa libgl1 libxrender1 libxcursor1 libxfixes3 libxft2 libxinerama1 libfontconfig1"


def need_gmsh() -> None:
    """Raise InputError where gmsh cannot be loaded."""
    try:
        import gmsh  # noqa: F401
    except (ImportError, OSError) as error:
        raise InputError(
            "this machine",
            "gmsh",
            str(error),
            "gmsh with its shared libraries",
            f"install them (Debian: apt-get install {PACKAGES}), or leave the 3D reference out",
        ) from None
