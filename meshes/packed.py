"""Records as bytes and back without pickle: a description of their structure, and their arrays as npz.

Reading makes numbers, texts and records of named packages, and runs none of what it reads: fields are set, no constructor
is called. What a record computed and cached besides its fields is left out.
"""

from __future__ import annotations

import dataclasses
import io
import json
import zlib
from collections.abc import Callable
from importlib import import_module
from typing import Any
from zipfile import BadZipFile

import numpy as np

#: Packages whose records and classes may be named.
TRUSTED = ("rollbench", "skfem")


def pack_record(value: object) -> bytes:
    """Bytes of a record.

    Parameters
    ----------
    value : object
        Record, number, text, array, sparse matrix, tuple, list, dict or class; nested as you like.

    Returns
    -------
    bytes
        Contents of an .npz file.

    Raises
    ------
    TypeError
        A value of any other type.

    Examples
    --------
    >>> unpack_record(pack_record((1, {"a": [2.5, None]})))
    (1, {'a': [2.5, None]})
    """
    arrays: list[Any] = []
    tree = json.dumps(_describe_value(value, arrays))
    stream = io.BytesIO()
    np.savez(stream, np.frombuffer(tree.encode(), np.uint8), *arrays)
    return stream.getvalue()


def unpack_record(content: bytes, *packages: str) -> Any:
    """Record of bytes that `pack_record` made.

    Parameters
    ----------
    content : bytes
        The bytes.
    *packages : str
        Packages besides `TRUSTED` whose classes may appear.

    Returns
    -------
    Any
        The record.

    Raises
    ------
    ValueError
        The bytes hold something else, or a class of another package.
    """
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            tree, *arrays = (file[name] for name in file.files)
        return _unpack_value(json.loads(tree.tobytes()), arrays, (*TRUSTED, *packages))
    except (AttributeError, EOFError, ImportError, LookupError, RecursionError, TypeError, BadZipFile, zlib.error) as error:
        raise ValueError(f"no record: {error}") from error


def _describe_value(value: Any, arrays: list[Any]) -> Any:
    """JSON of a value: plain values unchanged, others as a list that begins with their kind; arrays go to ``arrays``."""
    if value is None or type(value) in (bool, int, float, str):
        return value
    if isinstance(value, np.ndarray | np.generic) and value.dtype != object:
        arrays.append(value)
        return ["array" if isinstance(value, np.ndarray) else "scalar", len(arrays) - 1]
    if type(value).__module__.startswith("scipy.sparse"):
        matrix: Any = value if value.format in ("csr", "csc") else value.tocsr()
        return [
            "sparse",
            _class_name(type(matrix)),
            list(matrix.shape),
            *(_describe_value(x, arrays) for x in _matrix_parts(matrix)),
        ]
    if type(value) in (tuple, list):
        return [type(value).__name__, *(_describe_value(x, arrays) for x in value)]
    if type(value) is dict:
        return ["dict", *([_describe_value(k, arrays), _describe_value(x, arrays)] for k, x in value.items())]
    if isinstance(value, type):
        return ["class", _class_name(value)]
    if dataclasses.is_dataclass(value):
        fields = {f.name: _describe_value(getattr(value, f.name), arrays) for f in dataclasses.fields(value)}
        return ["record", _class_name(type(value)), fields]
    raise TypeError(f"{type(value).__name__} cannot be kept")


def _matrix_parts(matrix: Any) -> tuple[Any, Any, Any]:
    return matrix.data, matrix.indices, matrix.indptr


def _class_name(class_: type) -> str:
    return f"{class_.__module__}:{class_.__qualname__}"


def _unpack_value(tree: Any, arrays: list[Any], packages: tuple[str, ...]) -> Any:
    if not isinstance(tree, list):
        return tree
    sort, *content = tree

    def unpacked(x: Any) -> Any:
        return _unpack_value(x, arrays, packages)

    makers: dict[str, Callable[[], Any]] = {
        "array": lambda: arrays[content[0]],
        "scalar": lambda: arrays[content[0]][()],
        "tuple": lambda: tuple(map(unpacked, content)),
        "list": lambda: list(map(unpacked, content)),
        "dict": lambda: {unpacked(k): unpacked(x) for k, x in content},
        "sparse": lambda: _import_class(content[0], ("scipy",))(tuple(map(unpacked, content[2:])), shape=tuple(content[1])),
        "class": lambda: _import_class(content[0], packages),
        "record": lambda: _build_record(
            _import_class(content[0], packages), {k: unpacked(x) for k, x in content[1].items()}
        ),
    }
    return makers[sort]()


def _import_class(name: str, packages: tuple[str, ...]) -> Any:
    """Import a class by its module and name. Raises ValueError for one of another package."""
    module, _, path = name.partition(":")
    if module.split(".")[0] not in packages:
        raise ValueError(f"{name}: of none of {', '.join(packages)}")
    found: Any = import_module(module)
    for attribute in path.split("."):
        found = getattr(found, attribute)
    if not isinstance(found, type):
        raise ValueError(f"{name}: no class")
    return found


def _build_record(class_: type, fields: dict[str, Any]) -> Any:
    if not dataclasses.is_dataclass(class_) or fields.keys() != {f.name for f in dataclasses.fields(class_)}:
        raise ValueError(f"{class_.__name__}: no record of these fields")
    record = object.__new__(class_)
    for name, value in fields.items():
        object.__setattr__(record, name, value)
    return record
