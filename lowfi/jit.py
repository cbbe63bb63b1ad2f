"""One source, two engines: the kernels run interpreted (no start-up cost) or compiled by numba (many solves).

``lowfi.kernel`` is the interpreted package. ``compiled()`` loads the same files a second time as
``lowfi.kernel_compiled``, where the decorator ``kernel`` compiles; numba caches the machine code beside the sources.
"""

from __future__ import annotations

import hashlib
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


def drop_stale(folder: Path, *used: Path) -> bool:
    """Remove cached machine code made from other sources; returns whether any source had changed.

    numba keys its cache by the file of a function, not by the functions it calls in other files: after a change in one
    kernel its callers would keep the old machine code. used: other folders whose kernels those of this one call.
    """
    digest = hashlib.sha256()
    for place in (folder, *used):
        for source in sorted(place.glob("*.py")):
            digest.update(source.read_bytes())
    stamp, text = folder / "__pycache__" / "kernels.sha256", digest.hexdigest()
    try:
        if stamp.exists() and stamp.read_text(encoding="ascii") == text:
            return False
        stamp.parent.mkdir(exist_ok=True)
        for pattern in ("*.nbi", "*.nbc"):
            for file in stamp.parent.glob(pattern):
                file.unlink(missing_ok=True)
        stamp.write_text(text, encoding="ascii")
    except OSError:  # a read-only installation: its sources do not change one by one
        return False
    return True


def load_compiled(name: str, folder: Path, *used: Path) -> ModuleType:
    """The kernels of a folder loaded as a package of that ``name``, which must begin like ``COMPILED``.

    used: folders of other kernels that they call. Raises ImportError where the folder holds no package.
    """
    drop_stale(folder, *used)
    spec = importlib.util.spec_from_file_location(
        name, folder / "__init__.py", submodule_search_locations=[str(folder)]
    )
    if spec is None or spec.loader is None:
        raise ImportError(f"cannot load the kernels from {folder}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@cache
def compiled() -> ModuleType:
    """The kernels compiled by numba (loaded once; compiled on their first call, cached on disk)."""
    start = perf_counter()
    module = load_compiled(COMPILED, Path(__file__).parent / "kernel")
    timing["load"] = perf_counter() - start
    return module
