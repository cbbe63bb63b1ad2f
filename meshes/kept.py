"""What depends only on a geometry, kept on disc between commands, so that a geometry that was solved once is known.

Off unless a process switches it on, as the command line does: a library, a test or a timing makes everything itself.
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
    """Keep what functions marked `kept` make in the user's cache folder, unless caches are switched off there."""
    from rollbench.meshes.cache import Cache, default_root

    root = default_root()
    _stores[:] = [] if root is None else [Cache(root / FOLDER, LIMIT)]


def switched_on() -> bool:
    """Whether results are kept here."""
    return bool(_stores)


def switch_off() -> None:
    """Make everything again."""
    _stores.clear()


@contextmanager
def made_anew() -> Iterator[None]:
    """Nothing is kept or taken from what was, for a while: for work that is timed."""
    before, _stores[:] = list(_stores), []
    try:
        yield
    finally:
        _stores[:] = before


def kept(type_: type[T]) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Mark a function of plain records, called by position, that makes a number or a record of a class of the package:
    `switch_on` lets its results be kept."""

    def mark(build: Callable[P, T]) -> Callable[P, T]:
        @wraps(build)
        def cached(*args: P.args, **kwargs: P.kwargs) -> T:
            if not _stores or kwargs:
                return build(*args, **kwargs)
            return _stores[0].get(build, args, type_)

        return cached

    return mark
