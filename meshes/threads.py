"""Linear algebra on one thread: with small matrices, and next to any other busy process, more only wait for one another.

One rule: the command line, workers and tests call `one_thread` when they begin; a call of the library has one thread until
it returns, because the rest of the process is its user's. Work is shared among processes. A user's own variable wins.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

#: Variables that the libraries of linear algebra read when they are loaded; the first speaks for all of them.
VARIABLES = tuple(f"{name}_NUM_THREADS" for name in ("OMP", "OPENBLAS", "MKL", "BLIS", "VECLIB_MAXIMUM"))


def for_one_thread() -> dict[str, str]:
    """Variables to set for one thread: none that the user has set, and none at all where he has set the first."""
    return {} if VARIABLES[0] in os.environ else {name: "1" for name in VARIABLES if name not in os.environ}


def one_thread() -> None:
    """Linear algebra of this process, and of those that it starts, on one thread from now on. A second call changes
    nothing."""
    if "numpy" in sys.modules:
        for library in _loaded():
            library.set_num_threads(1)
    os.environ.update(for_one_thread())


@contextmanager
def held_to_one_thread() -> Iterator[None]:
    """The same, as a context or a decorator, for a while and in this process alone."""
    if not for_one_thread():
        yield
        return
    import scipy.linalg  # noqa: F401 - it brings a library of its own: later it would not be held

    libraries = [(library, library.num_threads) for library in _loaded()]
    for library, _ in libraries:
        library.set_num_threads(1)
    try:
        yield
    finally:
        for library, before in libraries:
            library.set_num_threads(before)


def _loaded() -> list[Any]:
    """Libraries that are loaded, which read no variable any more, but those that the user has set."""
    left = for_one_thread()
    if not left:
        return []
    from threadpoolctl import ThreadpoolController

    libraries = ThreadpoolController().select(user_api="blas").lib_controllers
    return [library for library in libraries if f"{library.internal_api.upper()}_NUM_THREADS" in left]
