"""Linear algebra on one thread."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from threadpoolctl import ThreadpoolController


@contextmanager
def one_thread() -> Iterator[None]:
    """Linear algebra on one thread, as a context or a decorator: with small matrices, more only wait for one another.

    Only libraries that are loaded when it begins are held: scipy brings one of its own beside numpy's.
    """
    with _libraries("scipy.linalg" in sys.modules).limit(limits=1, user_api="blas"):
        yield


@cache
def _libraries(_: bool) -> Any:
    """The libraries of linear algebra of this process, without scipy's and with it: to find them takes as long as to solve
    a scene."""
    return ThreadpoolController()
