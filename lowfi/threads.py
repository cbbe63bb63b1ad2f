"""Linear algebra on one thread."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from threadpoolctl import ThreadpoolController

#: Libraries that a context of this thread holds already: to set them takes as long as to solve a small system.
_held = threading.local()


@contextmanager
def one_thread() -> Iterator[None]:
    """Linear algebra on one thread, as a context or a decorator: with small matrices, more only wait for one another.

    Only libraries that are loaded when it begins are held: scipy brings one of its own besides numpy's.
    """
    libraries, before = _libraries("scipy.linalg" in sys.modules), getattr(_held, "libraries", None)
    if libraries is before:
        yield
        return
    with libraries.limit(limits=1, user_api="blas"):
        _held.libraries = libraries
        try:
            yield
        finally:
            _held.libraries = before


@cache
def _libraries(_: bool) -> Any:
    """The libraries of linear algebra of this process, without scipy's and with it: to find them takes as long as to solve
    a scene."""
    return ThreadpoolController()
