"""The kernels of the linear bearing in two engines from one source, by the scheme of ``lowfi.jit``."""

from __future__ import annotations

import importlib.util
import sys
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Literal

from lowfi import jit
from lowfi.friction import linear_kernel

Engine = Literal["interpreted", "compiled"]


def engine(name: Engine) -> ModuleType:
    """The kernels as plain Python or compiled by numba."""
    return _compiled() if name == "compiled" else linear_kernel


@cache
def _compiled() -> ModuleType:
    """The kernels' file loaded a second time under a name whose functions ``lowfi.jit.kernel`` compiles.

    One file, so that numba's cache, keyed by it, never holds stale code.
    """
    name, path = f"{jit.COMPILED}_linear", Path(__file__).with_name("linear_kernel.py")
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"cannot load the kernels of {path.name}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
