"""The friction kernels interpreted (no start-up cost) or compiled by numba (many calls), as ``lowfi.jit`` does it."""

from __future__ import annotations

import importlib
from functools import cache
from pathlib import Path
from types import ModuleType

from lowfi.jit import COMPILED, load_compiled

#: Begins like the name of the other compiled kernels, so that the decorator ``kernel`` compiles here too.
NAME = f"{COMPILED}_friction"


def interpreted() -> ModuleType:
    """The kernels as plain Python."""
    return importlib.import_module("lowfi.friction.kernel")


@cache
def compiled() -> ModuleType:
    """The kernels compiled by numba (loaded once; compiled on their first call, cached on disk)."""
    return load_compiled(NAME, Path(__file__).parent / "kernel")


def cached() -> bool:
    """Whether machine code of the kernels lies on disk, so that the compiled ones cost no half minute of compiling."""
    return any((Path(__file__).parent / "kernel" / "__pycache__").glob("*.nbi"))


def engine(fast: bool) -> ModuleType:
    """The compiled kernels if ``fast``, else the interpreted ones."""
    return compiled() if fast else interpreted()
