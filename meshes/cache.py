"""Cache on disk for results that are slow to compute, such as meshes; the key is the function and its arguments.

Each result is one file, and is never left incomplete; files not used for the longest time are deleted first. A file begins
with a digest of its contents; if they do not match, the result is computed again. Only data are read, never pickled objects
(`meshes.packed`), and only from a folder of this user (`meshes.private`).

The key is computed from the function's name, the canonical form of its arguments, the result's class, the versions of gmsh,
scikit-fem and rollbench, and the sources of the packages that compute the result, because a version number does not change
while a mesh generator is being developed.
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
    """Progress message of a finished stage of a computation.

    The attribute ``stage`` is the stage's name; ``cached`` tells whether all its results were read from the cache.
    """

    stage: str
    cached: bool

    def __new__(cls, stage: str, text: str, *, cached: bool = False) -> StageDone:
        """Create the message with the text ``stage: text``."""
        done = super().__new__(cls, f"{stage}: {text}")
        done.stage, done.cached = stage, cached
        return done


T = TypeVar("T")

#: Subfolder of a cache for its files, and the one that versions before 0.5 used.
RECORDS, BEFORE = "records", ("joblib", "rollbench")
#: Length of the digest at the beginning of a file [bytes].
_DIGEST = 32
#: Computing time of a result [s], stored between digest and content.
_SECONDS = struct.Struct("<d")
#: Default of the largest size of a cache [bytes].
LIMIT = 4_000_000_000

_BEGAN = time.time()


def default_root() -> Path | None:
    """Return the folder of the cache: environment variable ROLLBENCH_CACHE, else "rollbench" in the user's cache folder.

    Returns
    -------
    Path | None
        The folder; None where the variable is "off", which switches the cache off.
    """
    named = os.environ.get("ROLLBENCH_CACHE", "").strip()
    if named.lower() == "off":
        return None
    if named:
        return Path(named).expanduser()
    from platformdirs import user_cache_dir

    return Path(user_cache_dir("rollbench", appauthor=False))


class Cache:
    """Cache on disk for results of functions, found again by the functions' names and arguments.

    If the folder cannot be written to, if other users may write to it, or if the disk is full, one message is printed on
    standard error, and the computation continues without the cache. ``hits`` and ``misses`` count the results that `get`
    read and computed. ``cold_seconds`` is the sum of the computing times of all these results. ``fault`` is the message,
    empty without an error; with ``quiet`` it is not printed, and left to another process.

    Parameters
    ----------
    root : Path | None
        Folder of the cache, created when first used; None switches the cache off.
    limit : int, default LIMIT
        Largest size of all files together [bytes].
    """

    def __init__(self, root: Path | None, limit: int = LIMIT) -> None:
        """Create a cache without reading or writing files."""
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
            Function at module level whose result depends only on its arguments.
        arguments : tuple[object, ...]
            Arguments of the function.
        type_ : type[T]
            Class of the result.

        Returns
        -------
        T
            Result of the function.

        Raises
        ------
        TypeError
            The result is not a ``type_``; or no key can be computed, because the function is local or an argument has no
            canonical form.
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
            raise TypeError(f"{build.__qualname__} returned a {type(value).__name__}, not a {type_.__name__}")
        if path is not None and not self.fault:
            self._write(path, _SECONDS.pack(spent) + pack_record(value))
        return value

    def report(self, fault: str) -> None:
        """Store the reason for which the cache is not used any more, and print it once on standard error."""
        if fault and not self.fault and not self.quiet:
            print(f"rollbench: cache {self.root}: {fault}; the computation continues without the cache", file=sys.stderr)
        self.fault = self.fault or fault

    def _path(self, build: Callable[..., object], arguments: tuple[object, ...], type_: type) -> Path | None:
        """Return the path of the file for a result; None without a folder to which only this user can write."""
        if self.root is None:
            return None
        key = content_key(build, arguments, type_)
        try:
            return private_folder(self.root, RECORDS) / f"{key}.npz"
        except OSError as error:
            self.report(error.strerror or str(error))
            return None

    def _write(self, path: Path, content: bytes) -> None:
        """Write the file of a result, and delete the oldest files where all together exceed the limit."""
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
    """Delete the files not used for the longest time, until the rest together does not exceed a limit [bytes]."""
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
    """Read a result and its computing time [s] from a file; None where the file is missing, damaged or of another class."""
    try:
        with path.open("rb") as file:
            digest, content = file.read(_DIGEST), file.read()
        if hashlib.sha256(content).digest() != digest:
            return None
        value = unpack_record(content[_SECONDS.size :], type_.__module__.split(".")[0])
    except (OSError, ValueError):  # no file, or one of other sources: the result is computed again
        return None
    with suppress(OSError):  # the folder may be read-only
        os.utime(path)
    return (value, *_SECONDS.unpack_from(content)) if isinstance(value, type_) else None


def content_key(build: Callable[..., object], arguments: tuple[object, ...], type_: type) -> str:
    """Compute the key under which the result of a function with its arguments is stored.

    Parameters
    ----------
    build, arguments, type_ : Callable[..., object]
        Function, its arguments, and the class of its result, as for `Cache.get`.

    Returns
    -------
    str
        64 hexadecimal digits.

    Raises
    ------
    TypeError
        The function is local or a lambda, or an argument has no canonical form.
    """
    name = f"{build.__module__}.{build.__qualname__}"
    if "<" in name:
        raise TypeError(f"{name} is not defined at module level: only results of such functions can be stored")
    made_by = sorted({"rollbench.meshes", _package_of_module(build.__module__), _package_of_module(type_.__module__)})
    programs = [*map(_installed_version, ("gmsh", "scikit-fem", "rollbench")), *map(sources_digest, made_by)]
    return digest(name, type_, programs, arguments)


def _package_of_module(module: str) -> str:
    """Return the package of a module: rollbench.hifi for rollbench.hifi.setup; for other packages the first name."""
    parts = module.split(".")
    return ".".join(parts[: 2 if parts[0] == "rollbench" else 1])


@lru_cache
def sources_digest(package: str) -> str:
    """Compute a digest of all Python sources of an installed package; empty where there are none (built-ins, archives).

    If a source was changed after the start of this process, the digest is made unique, so that no other process finds the
    results: whether the old or the new source is running cannot be known.
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
    """Return the version of an installed package, from the name of its metadata folder.

    `importlib.metadata`, which takes longer to import than a screw to solve, is used only where there is no such folder.
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
