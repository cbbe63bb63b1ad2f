"""The friction kernels interpreted (no start-up cost) or compiled by numba (many calls), as ``lowfi.jit`` does it."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from functools import cache
from pathlib import Path
from types import ModuleType

from lowfi.jit import COMPILED, drop_stale

#: Begins like the name of the other compiled kernels, so that the decorator ``kernel`` compiles here too.
NAME = f"{COMPILED}_friction"


def interpreted() -> ModuleType:
    """The kernels as plain Python."""
    return importlib.import_module("lowfi.friction.kernel")


@cache
def compiled() -> ModuleType:
    """The kernels compiled by numba (loaded once; compiled on their first call, cached on disk)."""
    folder = Path(__file__).parent / "kernel"
    drop_stale(folder)
    where = [str(folder)]
    spec = importlib.util.spec_from_file_location(NAME, folder / "__init__.py", submodule_search_locations=where)
    if spec is None or spec.loader is None:
        raise ImportError(f"cannot load the kernels from {folder}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[NAME] = module
    spec.loader.exec_module(module)
    return module


def engine(fast: bool) -> ModuleType:
    """The compiled kernels if ``fast``, else the interpreted ones."""
    return compiled() if fast else interpreted()
