"""A cache on disc of records that are slow to make, keyed by the content of the recipe that makes them.

joblib.Memory keeps the files: whole or not at all, those used longest ago dropped first. A record is stored with a digest
of its bytes and read only where that fits, so that a damaged file is built anew. Records are pickled: as with every such
cache, the folder must not be writable by others.

The key covers the recipe, the kind, the record's class, the versions of gmsh, scikit-fem and rollbench, and the sources of
the packages that make the record, because a version number stands still while a mesh generator is being worked on.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar

from joblib import Memory
from joblib.hashing import NumpyHasher

T = TypeVar("T")

#: Largest size of a cache [bytes], unless told otherwise.
LIMIT = 4_000_000_000

_BEGAN = time.time()


def default_root() -> Path | None:
    """Folder of the environment variable ROLLBENCH_CACHE ("off": None), else "rollbench" in the user's cache folder."""
    named = os.environ.get("ROLLBENCH_CACHE", "").strip()
    if named.lower() == "off":
        return None
    if named:
        return Path(named).expanduser()
    from platformdirs import user_cache_dir

    return Path(user_cache_dir("rollbench", appauthor=False))


class Cache:
    """Records by the content of their recipes; `hits` and `misses` count the answers of `get`.

    root: the folder, made when first used; None switches the cache off. limit: largest size of all files [bytes]. A folder
    that cannot be written to, or a full disc, is reported once on standard error, and work goes on without writing.
    """

    def __init__(self, root: Path | None, limit: int = LIMIT) -> None:
        """Open a cache; nothing is read or written yet."""
        self.root = root
        self.limit = limit
        self.hits = 0
        self.misses = 0
        self._writing = True

    def get(self, kind: str, recipe: object, build: Callable[[], T], type_: type[T]) -> T:
        """The record of that recipe: from its file, else built, and kept.

        kind: what the record is; recipe: all that the result depends on, picklable; type_: class of the result. Raises
        TypeError for a result that is no `type_`.
        """
        found, kept, key = None, None, ""
        if self.root is not None:
            key = key_of(kind, recipe, type_)
            with self._attempt():
                kept = Memory(self.root, verbose=0).cache(_kept, ignore=["content"], verbose=0)
                found = _read(kept, key, type_)
        if found is not None:
            self.hits += 1
            return found
        self.misses += 1
        value = build()
        if not isinstance(value, type_):
            raise TypeError(f"{kind}: built a {type(value).__name__}, not a {type_.__name__}")
        content = pickle.dumps(value, protocol=pickle.HIGHEST_PROTOCOL) if kept is not None and self._writing else b""
        if kept is not None and 0 < len(content) <= self.limit:
            with self._attempt():
                kept.call(key, (hashlib.sha256(content).digest(), content))
                Memory(self.root, verbose=0).reduce_size(bytes_limit=self.limit)
        return value

    @contextmanager
    def _attempt(self) -> Iterator[None]:
        """Work with the files; the first failure ends writing and is reported."""
        reason = ""
        with warnings.catch_warnings(record=True) as told:  # joblib warns where it cannot write
            warnings.simplefilter("always")
            try:
                yield
            except OSError as error:
                reason = error.strerror or str(error)
        for warning in told:
            reason = reason or str(warning.message)
        if reason and self._writing:
            self._writing = False
            print(f"rollbench: cache {self.root}: {reason}; going on without it", file=sys.stderr)


def _kept(key: str, content: tuple[bytes, bytes] | None) -> tuple[bytes, bytes] | None:  # noqa: ARG001  # the key is joblib's
    """What joblib keeps under a key: a record's bytes and their digest."""
    return content


def _read(kept: Any, key: str, type_: type[T]) -> T | None:
    """The record of a key, or None if there is none or it is not exactly what was written."""
    with suppress(Exception), warnings.catch_warnings():  # whatever a damaged file leads to: it is built anew
        warnings.simplefilter("ignore")
        if not kept.check_call_in_cache(key, None):
            return None
        digest, content = kept(key, None)
        if hashlib.sha256(content).digest() == digest:
            value = pickle.loads(content)
            return value if isinstance(value, type_) else None
    return None


def key_of(kind: str, recipe: object, type_: type) -> str:
    """Content key of a recipe, 40 hexadecimal digits.

    Dicts count without their order, arrays by values, type, shape and layout; numbers of different types differ.
    """
    made_by = sorted({"meshes", type_.__module__.partition(".")[0]})
    head = (
        kind,
        f"{type_.__module__}:{type_.__qualname__}",
        *map(_version, ("gmsh", "scikit-fem", "rollbench")),
        *map(sources, made_by),
        recipe,
    )
    hasher = NumpyHasher(hash_name="sha1")
    hasher.fast = True  # equal parts count the same whether or not they are one object
    return str(hasher.hash(head))


@lru_cache
def sources(package: str) -> str:
    """Digest of all Python sources of an installed package; empty where there are none (built-ins, archives).

    A source that was changed since this process began makes the digest one of its own, which no other process finds:
    nobody knows whether the old or the new source is running.
    """
    spec = find_spec(package)
    digest, count = hashlib.sha256(), 0
    for folder in dict.fromkeys((spec.submodule_search_locations or []) if spec else []):
        for path in sorted(Path(folder).rglob("*.py")):
            text = path.read_bytes()
            digest.update(f"{path.relative_to(folder).as_posix()} {len(text)}\n".encode() + text)
            if path.stat().st_mtime > _BEGAN:
                digest.update(os.urandom(16))
            count += 1
    return digest.hexdigest() if count else ""


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"
