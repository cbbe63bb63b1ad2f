"""Cache on disk for results that are slow to compute, such as meshes; the key is the function and its arguments.

Each result is one file, and is never left incomplete; files not used for the longest time are deleted first. A file begins
with a digest of its contents; if they do not match, the result is computed again. Files are read only from a folder to
which only this user can write (`meshes.files`).

The key is computed from the function's name, the canonical text of its arguments, the result's class, the versions of gmsh,
scikit-fem and rollbench, and the sources of the packages that compute the result, because a version number does not change
while a mesh generator is being developed.

Results are stored without pickle: arrays as in an .npz file, and a description of the structure in JSON. Reading creates
only numbers, texts, and records of known packages. No code in the data is run: fields are set without calling constructors.
Values that a record has cached in addition to its fields are not written.

The decorator `cached_on_disk` stores results that depend only on a geometry, for all commands. It does so only after a
process has called `switch_on_geometry_cache`, as the command line does. So calls of the library, tests and timings compute
all results.
"""

from __future__ import annotations

import dataclasses
import glob
import hashlib
import io
import json
import os
import re
import struct
import sys
import time
import zlib
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache, update_wrapper, wraps
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Generic, ParamSpec, TypeVar
from zipfile import BadZipFile

import numpy as np

from rollbench.meshes.files import create_private_folder, temporary_path
from rollbench.meshes.record_keys import digest_of_values


class StageMessage(str):
    """Progress message that a stage of a computation, such as meshing, is finished.

    The attribute ``stage`` is the name of the stage; ``cached`` tells whether all its results were read from the cache.
    """

    #: Name of the finished stage.
    stage: str
    #: Whether all results of the stage were read from the cache.
    cached: bool

    def __new__(cls, stage: str, text: str, *, cached: bool = False) -> StageMessage:
        """Create the message "STAGE: TEXT"; ``cached``: whether all results of the stage were read from the cache."""
        done = super().__new__(cls, f"{stage}: {text}")
        done.stage, done.cached = stage, cached
        return done


P = ParamSpec("P")
T = TypeVar("T")

#: Largest size of the arrays [bytes] on which a result that is kept in memory depends.
LARGEST_KEPT = 2**25

#: Subfolder of a cache for the files of its results.
RECORDS = "records"
#: Length of the digest at the beginning of a result's file [bytes].
_DIGEST = 32
#: Binary format of a result's computing time [s], which its file holds between the digest and the result itself.
_SECONDS = struct.Struct("<d")
#: Default limit of the size of all files of a cache together [bytes].
LIMIT = 4_000_000_000
#: Folder of the results of functions decorated by `cached_on_disk`, inside the folder of all caches, and largest size of
#: its files together [bytes].
GEOMETRIES, GEOMETRIES_LIMIT = "geometries", 300_000_000
#: Packages whose records and classes may occur in stored results.
TRUSTED = ("rollbench", "skfem")

#: Time at which this process loaded the module; sources changed later may differ from the running ones.
_BEGAN = time.time()


def default_cache_folder() -> Path | None:
    """Return the folder for all caches of this user: ROLLBENCH_CACHE, or else "rollbench" in the user's cache folder.

    Returns
    -------
    Path | None
        The folder; None where the environment variable ROLLBENCH_CACHE is "off", which switches caches off.
    """
    named = os.environ.get("ROLLBENCH_CACHE", "").strip()
    if named.lower() == "off":
        return None
    if named:
        return Path(named).expanduser()
    from platformdirs import user_cache_dir

    return Path(user_cache_dir("rollbench", appauthor=False))


class Cache:
    """Cache on disk for results of functions; a result is found again by the function's name and arguments.

    If the folder cannot be written to, if other users may write to it, or if the disk is full, one message is printed on
    standard error, and the computation continues without the cache. ``hits`` is the number of results that `get` read from
    files, ``misses`` the number that it computed. ``cold_seconds`` is the total time for computing all these results; for a
    result read from a file it is the time taken when the result was stored. ``fault`` is the text of the message, empty
    without an error; if ``quiet`` is True, it is not printed, because another process prints it.

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
            The result is not a ``type_``; or the file's name cannot be computed, because the function is local or an
            argument has no canonical text (`record_keys.canonical_text`).
        """

        def build_one(_: object) -> list[T]:
            value = build(*arguments)
            if not isinstance(value, type_):
                raise TypeError(f"{build.__qualname__} returned a {type(value).__name__}, not a {type_.__name__}")
            return [value]

        return self._get_or_build(build, build_one, [arguments], type_)[0]

    def get_each(
        self, build: Callable[[Sequence[Any]], Sequence[T]], arguments: Sequence[tuple[object, ...]], type_: type[T]
    ) -> list[T]:
        """Read results of a function from their files, or compute and store them: all that are missing in one call.

        Parameters
        ----------
        build : Callable[[Sequence[Any]], Sequence[T]]
            Function at module level that returns a result for each of several tuples of arguments; each result depends
            only on its own arguments.
        arguments : Sequence[tuple[object, ...]]
            Arguments of each result.
        type_ : type[T]
            Class of the results.

        Returns
        -------
        list[T]
            Results in the order of their arguments.

        Raises
        ------
        TypeError
            The name of a file cannot be computed, see `Cache.get`.
        """
        return self._get_or_build(build, build, arguments, type_)

    def _get_or_build(
        self,
        named: Callable[..., object],
        build: Callable[[Sequence[Any]], Sequence[T]],
        arguments: Sequence[tuple[object, ...]],
        type_: type[T],
    ) -> list[T]:
        """Read results from their files, or compute and store all that are missing by one call of ``build``.

        ``named``: function whose name is a part of the files' names; ``arguments``, ``type_``: as for `Cache.get_each`.
        """
        paths = [self._path_of_result(named, each, type_) for each in arguments]
        records = [None if path is None else _read_stored_result(path, type_) for path in paths]
        missing = [k for k, record in enumerate(records) if record is None]
        start = time.perf_counter()
        values = build([arguments[k] for k in missing]) if missing else ()
        spent = (time.perf_counter() - start) / max(1, len(missing))
        for k, value in zip(missing, values, strict=True):
            records[k], path = (value, spent), paths[k]
            if path is not None and not self.fault:
                self._write_result(path, _SECONDS.pack(spent) + record_to_bytes(value))
        self.hits, self.misses = self.hits + len(records) - len(missing), self.misses + len(missing)
        found = [record for record in records if record is not None]
        self.cold_seconds += sum(seconds for _, seconds in found)
        return [value for value, _ in found]

    def report_fault_and_stop(self, fault: str) -> None:
        """Stop the use of the cache because of ``fault``, a reason in words, and print it once on standard error."""
        if fault and not self.fault and not self.quiet:
            print(f"rollbench: cache {self.root}: {fault}; the computation continues without the cache", file=sys.stderr)
        self.fault = self.fault or fault

    def _path_of_result(self, build: Callable[..., object], arguments: tuple[object, ...], type_: type) -> Path | None:
        """Return the path of the file for a result of a function; None without a folder to which only this user can write.

        ``build``, ``arguments``, ``type_``: function, its arguments and the class of its result, as for `Cache.get`.
        """
        if self.root is None:
            return None
        key = key_of_result(build, arguments, type_)
        try:
            return create_private_folder(self.root, RECORDS) / f"{key}.npz"
        except OSError as error:
            self.report_fault_and_stop(error.strerror or str(error))
            return None

    def _write_result(self, path: Path, content: bytes) -> None:
        """Write the file of a result, and delete the files not used for the longest time if all together exceed the limit.

        ``path``: file to write; ``content``: computing time and result as bytes. A result larger than the limit is not
        stored.
        """
        if len(content) > self.limit:
            return
        try:
            new = temporary_path(path)
            try:
                new.write_bytes(hashlib.sha256(content).digest() + content)
                new.replace(path)
            finally:
                new.unlink(missing_ok=True)
            _remove_oldest_files(path.parent, self.limit)
        except OSError as error:
            self.report_fault_and_stop(error.strerror or str(error))


def _remove_oldest_files(folder: Path, limit: int) -> None:
    """Delete the least recently used files of the cache folder, until the remaining files fit into ``limit``.

    ``limit``: largest size of all files together [bytes].
    """
    stored = []
    for file in folder.glob("*.npz"):
        with suppress(FileNotFoundError):  # another process removed it
            stored.append((file.stat(), file))
    total = sum(status.st_size for status, _ in stored)
    for status, file in sorted(stored, key=lambda item: item[0].st_mtime):
        if total <= limit:
            return
        file.unlink(missing_ok=True)
        total -= status.st_size


def _read_stored_result(path: Path, type_: type[T]) -> tuple[T, float] | None:
    """Read the result of a function and its computing time [s] from its file in the cache.

    ``type_``: class of the result. None is returned where the file is missing or damaged, or has a result of another class.
    """
    try:
        with path.open("rb") as file:
            digest, content = file.read(_DIGEST), file.read()
        if hashlib.sha256(content).digest() != digest:
            return None
        value = record_from_bytes(content[_SECONDS.size :], type_.__module__.split(".")[0])
    except (OSError, ValueError):  # no file, or one written by other sources: the result is computed again
        return None
    with suppress(OSError):  # the folder may be read-only
        os.utime(path)
    return (value, *_SECONDS.unpack_from(content)) if isinstance(value, type_) else None


def key_of_result(function: Callable[..., object], arguments: tuple[object, ...], result_class: type) -> str:
    """Compute the key under which the cache stores the result of a function for some arguments.

    Parameters
    ----------
    function, arguments, result_class
        Function, its arguments, and the class of its result, as for `Cache.get`.

    Returns
    -------
    str
        64 hexadecimal digits.

    Raises
    ------
    TypeError
        The function is local or a lambda, or an argument has no canonical text (`record_keys.canonical_text`).
    """
    name = f"{function.__module__}.{function.__qualname__}"
    if "<" in name:
        raise TypeError(f"{name} is not defined at module level: only results of such functions can be stored")
    made_by = sorted({"rollbench.meshes", *(_package_of_module(x.__module__) for x in (function, result_class))})
    programs = [*map(_installed_version, ("gmsh", "scikit-fem", "rollbench")), *map(digest_of_sources, made_by)]
    return digest_of_values(name, result_class, programs, arguments)


def _package_of_module(module: str) -> str:
    """Return the package to which a module belongs: rollbench.hifi for rollbench.hifi.setup, numpy for numpy.linalg."""
    parts = module.split(".")
    return ".".join(parts[: 2 if parts[0] == "rollbench" else 1])


@lru_cache
def digest_of_sources(package: str) -> str:
    """Compute a digest of all Python sources of an installed package; empty where it has none (built-ins, archives).

    If a source was changed after the start of this process, it is unknown whether the old or the new source is running.
    Then the digest is made unique, so that no other process finds results stored under it.
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

    `importlib.metadata`, whose import takes longer than solving a screw, is used only where there is no such folder.
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


#: The cache of functions decorated by `cached_on_disk`, as the only entry; empty while it is switched off.
_stores: list[Cache] = []


def switch_on_geometry_cache() -> None:
    """Use the user's cache folder from now on for the results of all functions decorated by `cached_on_disk`.

    Where the environment variable ROLLBENCH_CACHE is "off", results are computed, and neither stored nor read.
    """
    root = default_cache_folder()
    _stores[:] = [] if root is None else [Cache(root / GEOMETRIES, GEOMETRIES_LIMIT)]


def is_geometry_cache_on() -> bool:
    """Return whether results of functions decorated by `cached_on_disk` are stored on disk and read from there."""
    return bool(_stores)


def cached_on_disk(result_class: type[T]) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Return a decorator that stores the results of a function in the cache on disk, while that is switched on.

    Parameters
    ----------
    result_class : type[T]
        Class of the results: a number, or a record of this package.

    Returns
    -------
    decorator
        Decorator for a function whose arguments are plain records. Calls with keyword arguments do not use the cache.
    """

    def decorate_function(build: Callable[P, T]) -> Callable[P, T]:
        @wraps(build)
        def cached(*args: P.args, **kwargs: P.kwargs) -> T:
            if not _stores or kwargs:
                return build(*args, **kwargs)
            return _stores[0].get(build, args, result_class)

        return cached

    return decorate_function


def each_cached_on_disk(
    result_class: type[T],
) -> Callable[[Callable[[Sequence[Any]], Sequence[T]]], Callable[[Sequence[Any]], list[T]]]:
    """Return a decorator as `cached_on_disk`, for a function that returns a result for each of several tuples of arguments.

    Parameters
    ----------
    result_class : type[T]
        Class of each result: a number, or a record of this package.

    Returns
    -------
    decorator
        Decorator for a function whose argument is a sequence of tuples of plain records. It is called with those tuples
        whose results are not stored.
    """

    def decorate_function(build: Callable[[Sequence[Any]], Sequence[T]]) -> Callable[[Sequence[Any]], list[T]]:
        @wraps(build)
        def cached(arguments: Sequence[Any]) -> list[T]:
            return _stores[0].get_each(build, arguments, result_class) if _stores else list(build(arguments))

        return cached

    return decorate_function


@dataclasses.dataclass(eq=False)
class KeptByContent(Generic[P, T]):
    """Function whose last results are kept in memory, see `kept_by_content`."""

    #: The function.
    function: Callable[P, T]
    #: Number of results that are kept.
    count: int
    #: Function that returns what the result depends on.
    moved_by: Callable[P, Sequence[Any]]
    #: Results by the content of what they depend on, the latest last.
    kept: dict[tuple[object, ...], T] = dataclasses.field(default_factory=dict)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> T:
        """Return the result for the arguments, which must not be changed."""
        inputs = self.moved_by(*args, **kwargs)
        if sum(x.nbytes for x in inputs if isinstance(x, np.ndarray)) > LARGEST_KEPT:
            return self.function(*args, **kwargs)
        key = tuple((x.shape, x.tobytes()) if isinstance(x, np.ndarray) else x for x in inputs)
        found = self.kept.pop(key) if key in self.kept else self.function(*args, **kwargs)
        self.kept[key] = found
        if len(self.kept) > self.count:
            del self.kept[next(iter(self.kept))]
        return found

    def cache_clear(self) -> None:
        """Delete all results."""
        self.kept.clear()


def kept_by_content(count: int, moved_by: Callable[P, Sequence[Any]]) -> Callable[[Callable[P, T]], KeptByContent[P, T]]:
    """Return a decorator for a function of arrays that keeps its last results in memory, by the content of the arrays.

    ``count``: number of results that are kept; ``moved_by``: function that returns the arrays and other values on which the
    result depends. Results of more than `LARGEST_KEPT` bytes of input are not kept.
    """
    return lambda function: update_wrapper(KeptByContent(function, count, moved_by), function)  # type: ignore[return-value]


def forget_kept_results(package: str) -> None:
    """Delete all results that functions of the package ``package`` keep in memory, so that they are computed again."""
    for module in [m for name, m in sys.modules.items() if name.startswith(f"{package}.")]:
        for function in vars(module).values():
            if hasattr(function, "cache_clear"):
                function.cache_clear()


def record_to_bytes(value: object, *, compressed: bool = False) -> bytes:
    """Convert a dataclass record, or another plain value, to the bytes of an .npz file without pickled objects.

    Parameters
    ----------
    value : object
        Record, number, text, array, sparse matrix, tuple, list, range, dict or class; may be nested.
    compressed : bool, default False
        Whether the file is compressed, which takes more time.

    Returns
    -------
    bytes
        Contents of the .npz file.

    Raises
    ------
    TypeError
        The value, or one inside it, is of another type.

    Examples
    --------
    >>> record_from_bytes(record_to_bytes((1, {"a": [2.5, None]})))
    (1, {'a': [2.5, None]})
    """
    arrays: list[Any] = []
    tree = json.dumps(_json_structure(value, arrays))
    stream = io.BytesIO()
    save = np.savez_compressed if compressed else np.savez
    save(stream, np.frombuffer(tree.encode(), np.uint8), *arrays)
    return stream.getvalue()


def record_from_bytes(content: bytes, *packages: str) -> Any:
    """Convert bytes that `record_to_bytes` returned back to the record or other value.

    Parameters
    ----------
    content : bytes
        Bytes returned by `record_to_bytes`.
    *packages : str
        Packages whose classes may occur, in addition to `TRUSTED`.

    Returns
    -------
    Any
        The record, or other value.

    Raises
    ------
    ValueError
        The bytes are not from `record_to_bytes`, or contain a class of another package.
    """
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            tree, *arrays = (file[name] for name in file.files)
        return _unpack_value(json.loads(tree.tobytes()), arrays, (*TRUSTED, *packages))
    except (AttributeError, EOFError, ImportError, LookupError, RecursionError, TypeError, BadZipFile, zlib.error) as error:
        raise ValueError(f"the cached data are damaged, or were not written by record_to_bytes: {error}") from error


def _json_structure(value: Any, arrays: list[Any]) -> Any:
    """Return a description of a value that can be written as JSON; plain values are unchanged, other values become a list.

    The list begins with the type of the value, such as "tuple". ``arrays``: list to which the arrays in the value are
    appended; the description refers to them by their indices in this list.
    """
    if value is None or type(value) in (bool, int, float, str):
        return value
    if isinstance(value, str) and not isinstance(value, np.generic):  # with attributes, such as a warning
        return ["text", _qualified_class_name(type(value)), *value.__getnewargs__()]
    if isinstance(value, np.generic) and value.dtype.kind in "biufU":
        return ["scalar", value.dtype.str, value.item()]
    if isinstance(value, np.ndarray) and value.dtype != object:
        arrays.append(value)
        return ["array", len(arrays) - 1]
    if type(value).__module__.startswith("scipy.sparse"):
        matrix: Any = value if value.format in ("csr", "csc") else value.tocsr()
        parts = (_json_structure(x, arrays) for x in (matrix.data, matrix.indices, matrix.indptr))
        return ["sparse", _qualified_class_name(type(matrix)), list(matrix.shape), *parts]
    if type(value) in (tuple, list):
        return [type(value).__name__, *(_json_structure(x, arrays) for x in value)]
    if type(value) is range:
        return ["range", value.start, value.stop, value.step]
    if type(value) is dict:
        return ["dict", *([_json_structure(k, arrays), _json_structure(x, arrays)] for k, x in value.items())]
    if isinstance(value, type):
        return ["class", _qualified_class_name(value)]
    if dataclasses.is_dataclass(value):
        fields = {f.name: _json_structure(getattr(value, f.name), arrays) for f in dataclasses.fields(value)}
        return ["record", _qualified_class_name(type(value)), fields]
    raise TypeError(f"a value of type {type(value).__name__} cannot be stored in the cache")


def _qualified_class_name(class_: type) -> str:
    """Return the name of a class with its module, as ``module:class``."""
    return f"{class_.__module__}:{class_.__qualname__}"


def _unpack_value(structure: Any, arrays: list[Any], packages: tuple[str, ...]) -> Any:
    """Rebuild a value from its description, as returned by `_json_structure`.

    ``structure``: the description; ``arrays``: the arrays to which it refers; ``packages``: names of the packages whose
    classes may occur.
    """
    if not isinstance(structure, list):
        return structure
    sort, *content = structure

    def unpack_part(x: Any) -> Any:
        return _unpack_value(x, arrays, packages)

    makers: dict[str, Callable[[], Any]] = {
        "array": lambda: arrays[content[0]],
        "scalar": lambda: np.dtype(content[0]).type(content[1]),
        "tuple": lambda: tuple(map(unpack_part, content)),
        "list": lambda: list(map(unpack_part, content)),
        "range": lambda: range(*content),
        "text": lambda: _import_class(content[0], packages)(*content[1:]),
        "dict": lambda: {unpack_part(k): unpack_part(x) for k, x in content},
        "sparse": lambda: _import_class(content[0], ("scipy",))(
            tuple(map(unpack_part, content[2:])), shape=tuple(content[1])
        ),
        "class": lambda: _import_class(content[0], packages),
        "record": lambda: _build_record(
            _import_class(content[0], packages), {k: unpack_part(x) for k, x in content[1].items()}
        ),
    }
    return makers[sort]()


def _import_class(name: str, packages: tuple[str, ...]) -> Any:
    """Return the class with the name ``module:class``; ValueError where its package is not allowed.

    ``packages``: names of the allowed packages.
    """
    module, _, path = name.partition(":")
    if module.split(".")[0] not in packages:
        raise ValueError(f"the class {name} does not belong to one of the packages {', '.join(packages)}")
    found: Any = import_module(module)
    for attribute in path.split("."):
        found = getattr(found, attribute)
    if not isinstance(found, type):
        raise ValueError(f"{name} is not a class")
    return found


def _build_record(class_: type, fields: dict[str, Any]) -> Any:
    """Create an object of the dataclass ``class_`` from the values of its fields, without calling its constructor.

    ``fields``: values by the names of the fields. ValueError unless these are exactly the fields of the class.
    """
    if not dataclasses.is_dataclass(class_) or fields.keys() != {f.name for f in dataclasses.fields(class_)}:
        raise ValueError(f"{class_.__name__} is not a dataclass with the fields {', '.join(fields)}")
    record = object.__new__(class_)
    for name, value in fields.items():
        object.__setattr__(record, name, value)
    return record
