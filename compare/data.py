"""Shipped texts and tables, by their path below the folder ``compare``."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib import resources
from typing import Any


def text(path: str) -> str:
    """What a shipped file says."""
    return resources.files("rollbench.comparison").joinpath(*path.split("/")).read_text(encoding="utf-8")


@cache
def table(path: str) -> dict[str, Any]:
    """A shipped TOML file, read once: not to be changed."""
    return tomllib.loads(text(path))
