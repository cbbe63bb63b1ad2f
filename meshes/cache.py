"""A cache on disc of records that are slow to make, keyed by the content of the recipe that makes them.

A record is a frozen dataclass of numpy arrays, scipy sparse matrices, numbers, strings, None, and dataclasses, tuples,
lists and dicts of such. Its file is an ordinary .npz without pickles: first the structure as JSON, in which arrays are
numbers, then the arrays, last a checksum over the key and all bytes before it. Nothing of a file is parsed before its
checksum is right, so a damaged, truncated or foreign file is only ever rebuilt and replaced. The checksum guards
against accidents, not against somebody who may write to the cache's folder and computes it anew; even that file can
bring nothing but numbers.

The key covers the recipe, the kind, the record's class, the versions of gmsh and rollbench, and the sources of the
packages that make the record, because a version number stands still while a mesh generator is being worked on.
"""

from __future__ import annotations

import hashlib
import json
import os
import struct
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import fields, is_dataclass
from functools import lru_cache
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any, TypeVar

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

T = TypeVar("T")

#: Number of this file format; files of another are not read.
SCHEMA = 1
#: Largest size of a cache [bytes], unless told otherwise.
LIMIT = 4_000_000_000
#: Temporary files of interrupted writers are removed at this age [s].
STALE = 86_400.0

_BEGAN = time.time()

# Attributes that make up a sparse matrix, by format.
_SPARSE = {
    "csr": ("data", "indices", "indptr"),
    "csc": ("data", "indices", "indptr"),
    "bsr": ("data", "indices", "indptr"),
    "coo": ("data", "coords"),
    "dia": ("data", "offsets"),
}
_SPARSE_CLASSES = {f"{form}_{kind}": getattr(sp, f"{form}_{kind}") for form in _SPARSE for kind in ("matrix", "array")}


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

    root: the folder, made when first written to; None switches the cache off. limit: largest size of all files [bytes];
    those used longest ago go first. A folder that cannot be written to, or a full disc, is reported once on standard
    error, and work goes on without writing.
    """

    def __init__(self, root: Path | None, limit: int = LIMIT) -> None:
        """Open a cache; nothing is read or written yet."""
        self.root = root
        self.limit = limit
        self.hits = 0
        self.misses = 0
        self._writing = root is not None

    def get(self, kind: str, recipe: object, build: Callable[[], T], type_: type[T]) -> T:
        """The record of that recipe: from its file, else built, and kept.

        kind: lower-case word for the file's name; recipe: all that the result depends on, of the types a record may have;
        type_: class of the result. Raises ValueError for another kind, TypeError for a recipe or a result that cannot be
        stored, or a result that is no `type_`.
        """
        if self.root is None:
            self.misses += 1
            return build()
        key = key_of(kind, recipe, type_)
        path = self.root / f"{kind}-{key}.npz"
        found = _load(path, key, type_)
        if found is not None:
            self.hits += 1
            with suppress(OSError):  # a folder that is only read
                os.utime(path, ns=(time.time_ns(), time.time_ns()))
            return found
        self.misses += 1
        value = build()
        if not isinstance(value, type_):
            raise TypeError(f"{kind}: built a {type(value).__name__}, not a {type_.__name__}")
        arrays: list[NDArray[Any]] = []
        structure = json.dumps(encode(value, arrays), allow_nan=False, separators=(",", ":")).encode("ascii")
        if self._writing and len(structure) + sum(a.nbytes for a in arrays) <= self.limit:
            try:
                _store(path, key, structure, arrays)
                self._prune()
            except OSError as error:
                self._writing = False
                reason = error.strerror or str(error)
                print(f"rollbench: cache {self.root}: {reason}; going on without it", file=sys.stderr)
        return value

    def _prune(self) -> None:
        """Drop the files used longest ago until the rest fits, and what interrupted writers left."""
        assert self.root is not None
        found = []
        for path in self.root.iterdir():
            with suppress(FileNotFoundError):  # another process was faster
                state = path.stat()
                if path.suffix == ".npz":
                    found.append((state.st_mtime_ns, state.st_size, path))
                elif path.suffix == ".tmp" and time.time() - state.st_mtime > STALE:
                    path.unlink()
        total = sum(size for _, size, _ in found)
        for _, size, path in sorted(found):
            if total <= self.limit:
                return
            path.unlink(missing_ok=True)
            total -= size


def key_of(kind: str, recipe: object, type_: type) -> str:
    """Content key of a recipe, 32 hexadecimal digits.

    Dicts count without their order, arrays by values, type and shape; numbers of different types differ (1, 1.0, True).
    """
    if not (kind.isascii() and kind.replace("-", "").isalnum() and kind == kind.lower()):
        raise ValueError(f"kind {kind!r}: expected lower-case letters, digits and hyphens")
    arrays: list[NDArray[Any]] = []
    made_by = sorted({"meshes", type_.__module__.partition(".")[0]})
    head = [
        SCHEMA, kind, f"{type_.__module__}:{type_.__qualname__}", _version("gmsh"), _version("rollbench"),
        [sources(name) for name in made_by], encode(recipe, arrays, canonical=True),
        [[a.dtype.str, list(a.shape)] for a in arrays],
    ]  # fmt: skip
    digest = hashlib.sha256(json.dumps(head, allow_nan=False).encode("ascii"))
    for array in arrays:
        digest.update(np.ascontiguousarray(array).reshape(-1).view(np.uint8).data if array.nbytes else b"")
    return digest.hexdigest()[:32]


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


def encode(value: object, arrays: list[NDArray[Any]], *, canonical: bool = False) -> Any:
    """Structure of a value for JSON; its arrays are appended to `arrays` and named by their numbers.

    Floats go by their bits. canonical: dicts in the order of their keys' structures. Raises TypeError for other types.
    """

    def number_of(array: NDArray[Any]) -> int:
        if type(array) is not np.ndarray or array.dtype.hasobject or array.dtype.names or array.dtype.kind == "V":
            raise TypeError(f"a cached record cannot hold a {type(array).__name__} of {array.dtype}")
        arrays.append(array)
        return len(arrays) - 1

    def walk(x: Any) -> Any:
        kind = type(x)
        if x is None or kind in (bool, int, str):
            return x
        if kind is float:
            return ["float", struct.pack(">d", x).hex()]
        if kind is complex:
            return ["complex", struct.pack(">dd", x.real, x.imag).hex()]
        if kind is bytes:
            return ["bytes", x.hex()]
        if isinstance(x, np.ndarray):
            return ["array", number_of(x)]
        if isinstance(x, np.generic):
            return ["scalar", number_of(np.asarray(x))]
        if kind in (tuple, list):
            return [kind.__name__, *map(walk, x)]
        if kind is dict:
            pairs = [(k, v) for k, v in x.items()]
            if canonical:
                pairs.sort(key=lambda pair: json.dumps(encode(pair[0], [])))
            return ["dict", *([walk(k), walk(v)] for k, v in pairs)]
        if kind.__name__ in _SPARSE_CLASSES and sp.issparse(x):
            parts = [getattr(x, name) for name in _SPARSE[x.format]]
            return ["sparse", kind.__name__, list(map(int, x.shape)), *map(walk, parts)]
        if is_dataclass(x) and not isinstance(x, type):
            own = fields(x)
            if not all(f.init for f in own):
                raise TypeError(f"a cached record cannot hold a {kind.__name__}: a field is not set by its constructor")
            return ["record", f"{kind.__module__}:{kind.__qualname__}", {f.name: walk(getattr(x, f.name)) for f in own}]
        raise TypeError(f"a cached record cannot hold a {kind.__module__}.{kind.__qualname__}")

    return walk(value)


def decode(structure: Any, arrays: list[NDArray[Any]]) -> Any:
    """The value of a structure; raises ValueError, TypeError, KeyError or IndexError where it makes no sense."""
    if not isinstance(structure, list):
        return structure
    kind, *rest = structure
    inner = [decode(x, arrays) for x in rest] if kind in ("tuple", "list") else []
    if kind == "float":
        return struct.unpack(">d", bytes.fromhex(rest[0]))[0]
    if kind == "complex":
        return complex(*struct.unpack(">dd", bytes.fromhex(rest[0])))
    if kind == "bytes":
        return bytes.fromhex(rest[0])
    if kind == "array":
        return arrays[rest[0]]
    if kind == "scalar":
        return arrays[rest[0]][()]
    if kind in ("tuple", "list"):
        return tuple(inner) if kind == "tuple" else inner
    if kind == "dict":
        return {decode(k, arrays): decode(v, arrays) for k, v in rest}
    if kind == "sparse":
        return _sparse(rest[0], tuple(rest[1]), [decode(x, arrays) for x in rest[2:]])
    if kind == "record":
        module, _, name = rest[0].partition(":")
        found: Any = sys.modules[module]  # nothing is imported because a file says so
        for part in name.split("."):
            found = getattr(found, part)
        if not (isinstance(found, type) and is_dataclass(found)):
            raise TypeError(f"{rest[0]} is no record")
        return found(**{k: decode(v, arrays) for k, v in rest[1].items()})
    raise ValueError(f"unknown structure {kind!r}")


def _sparse(name: str, shape: tuple[int, ...], parts: list[Any]) -> Any:
    """Sparse matrix of its parts, index types and order kept."""
    form = name.partition("_")[0]
    make = _SPARSE_CLASSES[name]
    if form in ("coo", "dia"):
        matrix = make((parts[0], parts[1]), shape=shape)
    elif form == "bsr":
        matrix = make(shape, blocksize=parts[0].shape[1:], dtype=parts[0].dtype)
    else:
        matrix = make(shape, dtype=parts[0].dtype)
    for attribute, part in zip(_SPARSE[form], parts, strict=True):
        setattr(matrix, attribute, part)
    if form in ("csr", "csc", "bsr"):
        matrix.check_format(full_check=True)
    return matrix


class _Digesting:
    """A file to write to that keeps a digest of what went through it."""

    def __init__(self, file: IO[bytes], digest: Any) -> None:
        self.file = file
        self.digest = digest

    def write(self, data: Any) -> int:
        self.digest.update(data)
        return self.file.write(data)


def _start(key: str) -> Any:
    return hashlib.sha256(f"rollbench cache {SCHEMA} {key}\n".encode())


def _store(path: Path, key: str, structure: bytes, arrays: list[NDArray[Any]]) -> None:
    """Write a record's file whole or not at all. Raises OSError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}.", suffix=".tmp")
    try:
        digest = _start(key)
        with os.fdopen(handle, "wb") as file, zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as archive:
            members = [("structure", np.frombuffer(structure, dtype=np.uint8))]
            members += [(f"array{k}", array) for k, array in enumerate(arrays)]
            for member, array in members:
                with archive.open(zipfile.ZipInfo(f"{member}.npy"), "w", force_zip64=True) as entry:
                    np.lib.format.write_array(_Digesting(entry, digest), array, allow_pickle=False)
            with archive.open(zipfile.ZipInfo("checksum.npy"), "w") as entry:
                np.lib.format.write_array(entry, np.frombuffer(digest.digest(), dtype=np.uint8), allow_pickle=False)
        os.replace(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def _load(path: Path, key: str, type_: type[T]) -> T | None:
    """The record of a file, or None if there is none or it is not exactly what was written."""
    try:
        with zipfile.ZipFile(path) as archive:
            _verify(archive, key)
            *entries, _ = archive.infolist()
            structure, *arrays = [_array(archive, entry) for entry in entries]
            value = decode(json.loads(structure.tobytes()), arrays)
    except Exception:  # whatever a damaged file leads to: it is rebuilt
        return None
    return value if isinstance(value, type_) else None


def _array(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> NDArray[Any]:
    with archive.open(entry) as stream:
        found: NDArray[Any] = np.lib.format.read_array(stream, allow_pickle=False)
        return found


def _verify(archive: zipfile.ZipFile, key: str) -> None:
    """Raise ValueError unless the checksum, the last entry, fits the key and the bytes of all other entries."""
    *entries, last = archive.infolist()
    if any(entry.compress_type != zipfile.ZIP_STORED for entry in (*entries, last)):
        raise ValueError("not a file of this cache")
    digest = _start(key)
    for entry in entries:
        with archive.open(entry) as stream:
            while block := stream.read(1 << 20):
                digest.update(block)
    if archive.read(last)[-digest.digest_size :] != digest.digest():
        raise ValueError("wrong checksum")
