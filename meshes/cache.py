"""Disk cache of records that are slow to compute, keyed by the recipe that computes them: a function and its arguments.

A record is a file, whole or not at all; those used longest ago are dropped first. It begins with a digest of the rest,
which is read only where that matches, so that a damaged file is computed again; only data are read (`meshes.packed`),
from a folder of this user only (`meshes.private`).

The key covers the function's name, the canonical form of its arguments, the record's class, the versions of gmsh,
scikit-fem and rollbench, and the sources of the packages that make the record, because a version number stays the same
while a mesh generator is being changed.
"""

from __future__ import annotations

import glob
import hashlib
import os
import re
import shutil
import struct
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import TypeVar

from rollbench.meshes.canonical import digest
from rollbench.meshes.leftovers import temporary_name
from rollbench.meshes.packed import pack_record, unpack_record
from rollbench.meshes.private import private_folder


class StageDone(str):
    """Progress message of a finished stage: its name ``stage``, and ``cached``: whether all of it was read from a cache."""

    stage: str
    cached: bool

    def __new__(cls, stage: str, text: str, *, cached: bool = False) -> StageDone:
        """Make the text ``stage: text``."""
        done = super().__new__(cls, f"{stage}: {text}")
        done.stage, done.cached = stage, cached
        return done


T = TypeVar("T")

#: Folder of the records in that of a cache, and where versions before 0.5 had theirs.
RECORDS, BEFORE = "records", ("joblib", "rollbench")
#: Length of the digest that a file begins with.
_DIGEST = 32
#: Seconds that a record took to make, before its content.
_SECONDS = struct.Struct("<d")
#: Largest size of a cache [bytes], by default.
LIMIT = 4_000_000_000

_BEGAN = time.time()


def default_root() -> Path | None:
    """Folder of the cache: environment variable ROLLBENCH_CACHE, else "rollbench" in the user's cache folder.

    Returns
    -------
    Path | None
        The folder; None where the variable is "off".
    """
    named = os.environ.get("ROLLBENCH_CACHE", "").strip()
    if named.lower() == "off":
        return None
    if named:
        return Path(named).expanduser()
    from platformdirs import user_cache_dir

    return Path(user_cache_dir("rollbench", appauthor=False))


class Cache:
    """Records by the content of their recipes.

    A folder that cannot be written to, or that others may write to, or a full disk is reported once on standard error;
    work goes on without the cache. ``hits`` and ``misses`` count the answers of `get`; ``cold_seconds`` adds up the
    seconds that the records took to compute; ``fault`` is what there is to report; ``quiet`` leaves reporting to another
    process.

    Parameters
    ----------
    root : Path | None
        Folder, made when first used; None switches the cache off.
    limit : int, default LIMIT
        Largest size of all files [bytes].
    """

    def __init__(self, root: Path | None, limit: int = LIMIT) -> None:
        """Open a cache; nothing is read or written yet."""
        self.root = root
        self.limit = limit
        self.hits = 0
        self.misses = 0
        self.cold_seconds = 0.0
        self.quiet = False
        self.fault = ""

    def get(self, build: Callable[..., T], arguments: tuple[object, ...], type_: type[T]) -> T:
        """Read the result of a function from its file, or compute and store it.

        Parameters
        ----------
        build : Callable[..., T]
            Function of a module, whose result depends only on its arguments.
        arguments : tuple[object, ...]
            Its arguments.
        type_ : type[T]
            Class of the result.

        Returns
        -------
        T
            The result.

        Raises
        ------
        TypeError
            The result is no ``type_``, or no key can be made of function or arguments.
        """
        path = self._path(build, arguments, type_)
        record = None if path is None else _read_record(path, type_)
        if record is not None:
            self.hits += 1
            self.cold_seconds += record[1]
            return record[0]
        self.misses += 1
        start = time.perf_counter()
        value = build(*arguments)
        spent = time.perf_counter() - start
        self.cold_seconds += spent
        if not isinstance(value, type_):
            raise TypeError(f"{build.__qualname__}: built a {type(value).__name__}, not a {type_.__name__}")
        if path is not None and not self.fault:
            self._write(path, _SECONDS.pack(spent) + pack_record(value))
        return value

    def report(self, fault: str) -> None:
        """Note why nothing is written any more, and print it once on standard error."""
        if fault and not self.fault and not self.quiet:
            print(f"rollbench: cache {self.root}: {fault}; going on without it", file=sys.stderr)
        self.fault = self.fault or fault

    def _path(self, build: Callable[..., object], arguments: tuple[object, ...], type_: type) -> Path | None:
        """File of a record; None without a folder that is only this user's."""
        if self.root is None:
            return None
        key = content_key(build, arguments, type_)
        try:
            return private_folder(self.root, RECORDS) / f"{key}.npz"
        except OSError as error:
            self.report(error.strerror or str(error))
            return None

    def _write(self, path: Path, content: bytes) -> None:
        """Write a record, and remove old ones that exceed the limit."""
        if len(content) > self.limit:
            return
        try:
            new = temporary_name(path)
            try:
                new.write_bytes(hashlib.sha256(content).digest() + content)
                new.replace(path)
            finally:
                new.unlink(missing_ok=True)
            _remove_oldest_files(path.parent, self.limit)
            shutil.rmtree(path.parents[1].joinpath(*BEFORE), ignore_errors=True)
        except OSError as error:
            self.report(error.strerror or str(error))


def _remove_oldest_files(folder: Path, limit: int) -> None:
    """Remove the files used longest ago until all together are no larger than a limit [bytes]."""
    kept = []
    for file in folder.glob("*.npz"):
        with suppress(FileNotFoundError):  # another process removed it
            kept.append((file.stat(), file))
    total = sum(status.st_size for status, _ in kept)
    for status, file in sorted(kept, key=lambda item: item[0].st_mtime):
        if total <= limit:
            return
        file.unlink(missing_ok=True)
        total -= status.st_size


def _read_record(path: Path, type_: type[T]) -> tuple[T, float] | None:
    """Record in a file, and the seconds that it took to compute; None without a file that is exactly as written."""
    try:
        with path.open("rb") as file:
            digest, content = file.read(_DIGEST), file.read()
        if hashlib.sha256(content).digest() != digest:
            return None
        value = unpack_record(content[_SECONDS.size :], type_.__module__.split(".")[0])
    except (OSError, ValueError):  # none, or of other sources: it is built again
        return None
    with suppress(OSError):  # a folder that may only be read
        os.utime(path)
    return (value, *_SECONDS.unpack_from(content)) if isinstance(value, type_) else None


def content_key(build: Callable[..., object], arguments: tuple[object, ...], type_: type) -> str:
    """Content key of a recipe.

    Parameters
    ----------
    build, arguments, type_ : Callable[..., object]
        As for `Cache.get`.

    Returns
    -------
    str
        64 hexadecimal digits.

    Raises
    ------
    TypeError
        The function is local or a lambda, or arguments have no canonical form.
    """
    name = f"{build.__module__}.{build.__qualname__}"
    if "<" in name:
        raise TypeError(f"{name}: what is kept is made by a function of a module")
    made_by = sorted({"rollbench.meshes", _package_of_module(build.__module__), _package_of_module(type_.__module__)})
    programs = [*map(_installed_version, ("gmsh", "scikit-fem", "rollbench")), *map(sources_digest, made_by)]
    return digest(name, type_, programs, arguments)


def _package_of_module(module: str) -> str:
    """Package of a module: rollbench.hifi of rollbench.hifi.setup, else the first name."""
    parts = module.split(".")
    return ".".join(parts[: 2 if parts[0] == "rollbench" else 1])


@lru_cache
def sources_digest(package: str) -> str:
    """Digest of all Python sources of an installed package; empty where there are none (built-ins, archives).

    A source that was changed since this process began makes the digest unique, so that no other process finds it: nobody
    knows whether the old or the new source is running.
    """
    spec = find_spec(package)
    digest, count = hashlib.sha256(), 0
    for folder in dict.fromkeys((spec.submodule_search_locations or []) if spec else []):
        for path in sorted(glob.iglob("**/*.py", root_dir=folder, recursive=True)):
            with open(os.path.join(folder, path), "rb") as file:
                text = file.read()
                changed = os.fstat(file.fileno()).st_mtime
            digest.update(f"{path} {len(text)}\n".encode() + text)
            if changed > _BEGAN:
                digest.update(os.urandom(16))
            count += 1
    return digest.hexdigest() if count else ""


@lru_cache
def _installed_version(package: str) -> str:
    """Version of an installed package, from the name of its metadata folder.

    `importlib.metadata` takes longer to import than a screw to solve; it is asked where there is no such folder.
    """
    name = re.sub("[-_.]+", "_", package)
    folders = [found for place in sys.path for found in glob.iglob(f"{name}-*.dist-info", root_dir=place or ".")]
    if folders:
        return " ".join(sorted(folders))
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"
