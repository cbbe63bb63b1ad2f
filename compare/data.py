"""Shipped files: texts, tables and folders, by their path below the folder ``compare``."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any


def place(path: str) -> Path:
    """Where a shipped file or folder is."""
    return Path(str(resources.files("rollbench.compare").joinpath(*path.split("/"))))


def text(path: str) -> str:
    """The text of a shipped file."""
    return place(path).read_text(encoding="utf-8")


@cache
def table(path: str) -> dict[str, Any]:
    """A shipped TOML file, read once and cached: do not change it."""
    return tomllib.loads(text(path))
