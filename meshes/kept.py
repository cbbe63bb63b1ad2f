"""Cache on disk for results that depend only on a geometry, shared by all commands.

It is off until a process calls `switch_on`, as the command line does. So calls of the library, tests and timings compute
all results.
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

#: Name of this cache's folder inside the folder of all caches, and largest size of its files together [bytes].
FOLDER, LIMIT = "geometries", 300_000_000

_stores: list[Cache] = []


def switch_on() -> None:
    """Store results of functions decorated by `kept` in the user's cache folder, unless ROLLBENCH_CACHE is "off"."""
    from rollbench.meshes.cache import Cache, default_root

    root = default_root()
    _stores[:] = [] if root is None else [Cache(root / FOLDER, LIMIT)]


def switched_on() -> bool:
    """Return whether results of functions decorated by `kept` are stored on disk and read from there."""
    return bool(_stores)


def switch_off() -> None:
    """Stop the use of the cache on disk: all results are computed from now on."""
    _stores.clear()


@contextmanager
def no_cache() -> Iterator[None]:
    """Disable the cache on disk during a ``with`` block, for timings."""
    before, _stores[:] = list(_stores), []
    try:
        yield
    finally:
        _stores[:] = before


def kept(type_: type[T]) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Make a decorator for functions whose results are stored in the cache on disk, where that is on (`switch_on`).

    Parameters
    ----------
    type_ : type[T]
        Class of the results: a number, or a record of this package.

    Returns
    -------
    decorator
        Decorator for a function whose arguments are plain records. Only calls with positional arguments use the cache.
    """

    def decorate(build: Callable[P, T]) -> Callable[P, T]:
        @wraps(build)
        def cached(*args: P.args, **kwargs: P.kwargs) -> T:
            if not _stores or kwargs:
                return build(*args, **kwargs)
            return _stores[0].get(build, args, type_)

        return cached

    return decorate
