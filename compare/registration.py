"""Where the files of the sources are: tables, scenes, computations."""

from __future__ import annotations

from functools import cache
from importlib import import_module, resources
from pathlib import Path
from typing import Any

#: The folder of this package.
ROOT = Path(str(resources.files("rollbench.compare")))

#: Order of the sources; others follow by name.
ORDER = ("lin", "smith", "kalker", "liu", "external")


@cache
def data_files(folder: str) -> dict[str, Path]:
    """Shipped TOML files by name without ending, sorted: those of ``compare/FOLDER``, of every source's folder of that name
    and of folders in there."""
    paths = (path for place in (f"{folder}/*.toml", f"sources/*/{folder}/**/*.toml") for path in ROOT.glob(place))
    return {path.stem: path for path in sorted(paths, key=lambda path: path.stem)}


def source_files(name: str) -> list[Path]:
    """Files of that name, one a source, in the order of the sources."""
    paths = {path.parent.name: path for path in ROOT.glob(f"sources/*/{name}")}
    return [paths[name] for name in (*ORDER, *sorted(paths.keys() - set(ORDER))) if name in paths]


#: Titles of the sources with printed tables, by the beginning of the tables' names.
TITLES = {
    "lin": "Lin (2019)",
    "smith": "Smith (1994)",
    "kalker": "Kalker (1990)",
    "liu": "Liu et al. (2025)",
    "external": "other programs, makers, textbooks",
}


def load(function: str) -> Any:
    """The object that ``module:name`` names, imported now."""
    module, _, name = function.partition(":")
    return getattr(import_module(f"{__package__}.{module}"), name)
