"""One source, two engines: the kernels run interpreted (no start-up cost) or compiled by numba (many solves).

``lowfi.kernel`` is the interpreted package. ``compiled()`` loads the same files a second time as
``lowfi.kernel_compiled``, where the decorator ``kernel`` compiles; numba caches the machine code beside the sources.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from time import perf_counter
from types import ModuleType
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

COMPILED = "lowfi.kernel_compiled"
#: Seconds spent loading and compiling in this process, by stage.
timing: dict[str, float] = {}


def is_compiled(module_name: str) -> bool:
    """Whether a module of that name belongs to the compiled copy."""
    return module_name.startswith(COMPILED)


def kernel(function: F) -> F:
    """Compile ``function`` where its module belongs to the compiled copy; otherwise return it as it is."""
    if not is_compiled(function.__module__):
        return function
    import numba

    compiled_function: F = numba.njit(cache=True, error_model="numpy", fastmath=False)(function)
    return compiled_function


def interpreted() -> ModuleType:
    """The kernels as plain Python."""
    return importlib.import_module("lowfi.kernel")


@cache
def compiled() -> ModuleType:
    """The kernels compiled by numba (loaded once; compiled on their first call, cached on disk)."""
    start = perf_counter()
    folder = Path(__file__).parent / "kernel"
    spec = importlib.util.spec_from_file_location(
        COMPILED, folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    if spec is None or spec.loader is None:
        raise ImportError(f"cannot load the kernels from {folder}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[COMPILED] = module
    spec.loader.exec_module(module)
    timing["load"] = perf_counter() - start
    return module
