"""Parts of one set-up made in several processes of this machine: gmsh and the sparse factor serve one at a time in each."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any, Generic, NamedTuple, TypeVar

from meshes.cache import Cache
from meshes.memory import peak_MB, reset_peak

T = TypeVar("T")


class Part(NamedTuple):
    """A record to be made, or read from the cache: kind, recipe and class as for `Cache.get`; a function and its arguments
    that make it, picklable; name of its stage."""

    stage: str
    kind: str
    recipe: object
    build: Callable[..., Any]
    arguments: tuple[Any, ...]
    type_: type


@dataclass(frozen=True)
class Made(Generic[T]):
    """A record, seconds it took, whether it came from the cache; process that made it, and its peak of memory [MB] (None:
    not measured)."""

    value: T
    seconds: float
    cached: bool
    process: int
    peak_MB: float | None


def make(parts: Sequence[Part], cache: Cache, processes: int) -> list[Made[Any]]:
    """Records of independent parts, in their order, by so many processes at once, one thread each; by this one alone for
    one. Raises what a part raises, and MemoryError where a process was ended from outside."""
    if processes == 1 or len(parts) < 2:
        return [_make(part, cache) for part in parts]
    from joblib import Parallel, delayed, parallel_config
    from joblib.externals.loky.process_executor import BrokenProcessPool

    with parallel_config(backend="loky", inner_max_num_threads=1):
        try:
            made = Parallel(n_jobs=processes, batch_size=1, max_nbytes=None)(
                delayed(_elsewhere)(part, cache) for part in parts
            )
        except BrokenProcessPool as error:
            raise MemoryError("a process of the set-up was ended from outside: is there memory for it?") from error
    cache.hits += sum(one.cached for one in made)
    cache.misses += sum(not one.cached for one in made)
    return list(made)


def _elsewhere(part: Part, cache: Cache) -> Made[Any]:
    """In another process, whose record of memory starts anew."""
    reset_peak()
    return _make(part, cache)


def _make(part: Part, cache: Cache) -> Made[Any]:
    start, hits = perf_counter(), cache.hits
    value = cache.get(part.kind, part.recipe, lambda: part.build(*part.arguments), part.type_)
    return Made(value, perf_counter() - start, cache.hits > hits, os.getpid(), peak_MB())
