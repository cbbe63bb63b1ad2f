"""Disk cache of what depends only on a geometry, shared by commands.

Off unless a process switches it on, as the command line does: a library, a test or a timing computes everything.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import TYPE_CHECKING, ParamSpec, TypeVar

if TYPE_CHECKING:
    from rollbench.meshes.cache import Cache

P = ParamSpec("P")
T = TypeVar("T")

#: Folder in that of caches, and largest size of its files [bytes].
FOLDER, LIMIT = "geometries", 300_000_000

_stores: list[Cache] = []


def switch_on() -> None:
    """Keep results of functions marked `kept` in the user's cache folder, unless ROLLBENCH_CACHE is "off"."""
    from rollbench.meshes.cache import Cache, default_root

    root = default_root()
    _stores[:] = [] if root is None else [Cache(root / FOLDER, LIMIT)]


def switched_on() -> bool:
    """Whether results are kept here."""
    return bool(_stores)


def switch_off() -> None:
    """Compute everything again."""
    _stores.clear()


@contextmanager
def no_cache() -> Iterator[None]:
    """Context in which nothing is read from the cache or written to it, for work that is timed."""
    before, _stores[:] = list(_stores), []
    try:
        yield
    finally:
        _stores[:] = before


def kept(type_: type[T]) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Decorate a function whose results may be cached on disk; see `switch_on`.

    Parameters
    ----------
    type_ : type[T]
        Class of the results: a number, or a record of this package.

    Returns
    -------
    decorator
        For a function of plain records, called by position. Calls with keywords are never cached.
    """

    def mark(build: Callable[P, T]) -> Callable[P, T]:
        @wraps(build)
        def cached(*args: P.args, **kwargs: P.kwargs) -> T:
            if not _stores or kwargs:
                return build(*args, **kwargs)
            return _stores[0].get(build, args, type_)

        return cached

    return mark
