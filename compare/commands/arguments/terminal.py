"""The application that the commands of the command line are added to, and how they print."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated, Any

from cyclopts import App, Parameter

from compare import __version__

app = App(
    name="rollbench",
    help="Validation workbench for ball screws and rolling bearings: low-order models and their references.",
    version=__version__,
    help_format="plaintext",
)

Json = Annotated[bool, Parameter(name="--json", negative="", help="Print exactly one JSON value.")]


def print_json(value: Any) -> None:
    """Print one JSON value on standard output. Raises ValueError for a number that is not finite."""
    sys.stdout.write(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def show(*parts: Any) -> None:
    """Print texts and tables of rich, 160 columns wide where standard output is no terminal."""
    from rich.console import Console

    width = None if sys.stdout.isatty() else 160
    console = Console(width=width, soft_wrap=True, highlight=False, markup=False)
    for part in parts:
        console.print(part)


def cache_folder() -> Path | None:
    """Folder of meshes and condensed parts, None for none."""
    from meshes.cache import default_root

    return default_root()
