"""What wings and sources add to the core. The core finds their registrations here and names none of them.

A wing (``compare/wings/NAME``) is what a user may leave out, a source (``compare/sources/NAME``) what one publication
printed. Each says in its ``registration.py`` what it adds, functions as ``module:function`` in words, so that nothing of it
is imported before it is called. Where a folder is absent, or one that it needs, nothing of it is there.
"""

from __future__ import annotations

from functools import cache
from importlib import resources
from pathlib import Path

#: The folder of this package.
ROOT = Path(str(resources.files("rollbench.comparison")))

#: Order of the sources; others follow by name.
ORDER = ("lin", "smith", "kalker", "liu", "external")


@cache
def data_files(folder: str) -> dict[str, Path]:
    """Shipped TOML files by name without ending, sorted: those of ``compare/FOLDER`` and of every source's folder of that
    name."""
    found = (*ROOT.glob(f"{folder}/*.toml"), *ROOT.glob(f"sources/*/{folder}/*.toml"))
    return {path.stem: path for path in sorted(found, key=lambda path: path.stem)}


def misprint_files() -> list[Path]:
    """Lists of misprints, one a source, in the order of the sources."""
    found = {path.parent.name: path for path in ROOT.glob("sources/*/misprints.toml")}
    return [found[name] for name in (*ORDER, *sorted(found.keys() - set(ORDER))) if name in found]
