"""Convert records to bytes and back without pickle: arrays as in an .npz file, and a description of the structure in JSON.

Reading creates only numbers, texts, and records of known packages. No code in the data is run: fields are set without
calling constructors. Values that a record has cached in addition to its fields are not written.
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

#: Packages whose records and classes may occur in the data.
TRUSTED = ("rollbench", "skfem")


def pack_record(value: object) -> bytes:
    """Convert a record to bytes.

    Parameters
    ----------
    value : object
        Record, number, text, array, sparse matrix, tuple, list, dict or class; may be nested.

    Returns
    -------
    bytes
        Contents of an .npz file.

    Raises
    ------
    TypeError
        The value, or one inside it, is of another type.

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
    """Convert bytes from `pack_record` back to the record.

    Parameters
    ----------
    content : bytes
        Bytes returned by `pack_record`.
    *packages : str
        Packages whose classes may occur, in addition to `TRUSTED`.

    Returns
    -------
    Any
        The record, or other value.

    Raises
    ------
    ValueError
        The bytes are not from `pack_record`, or contain a class of another package.
    """
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            tree, *arrays = (file[name] for name in file.files)
        return _unpack_value(json.loads(tree.tobytes()), arrays, (*TRUSTED, *packages))
    except (AttributeError, EOFError, ImportError, LookupError, RecursionError, TypeError, BadZipFile, zlib.error) as error:
        raise ValueError(f"the bytes do not contain a record: {error}") from error


def _describe_value(value: Any, arrays: list[Any]) -> Any:
    """Return the structure of a value for JSON: plain values unchanged, others as a list that begins with their kind.

    Arrays are appended to ``arrays``, and the structure refers to them by their numbers.
    """
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
    raise TypeError(f"a value of type {type(value).__name__} cannot be stored")


def _matrix_parts(matrix: Any) -> tuple[Any, Any, Any]:
    """Return the arrays of a compressed sparse matrix: values, indices and index pointers."""
    return matrix.data, matrix.indices, matrix.indptr


def _class_name(class_: type) -> str:
    """Return the name of a class with its module, as ``module:class``."""
    return f"{class_.__module__}:{class_.__qualname__}"


def _unpack_value(tree: Any, arrays: list[Any], packages: tuple[str, ...]) -> Any:
    """Build a value from its structure as returned by `_describe_value`, with classes of certain packages only."""
    if not isinstance(tree, list):
        return tree
    sort, *content = tree

    def unpack(x: Any) -> Any:
        return _unpack_value(x, arrays, packages)

    makers: dict[str, Callable[[], Any]] = {
        "array": lambda: arrays[content[0]],
        "scalar": lambda: arrays[content[0]][()],
        "tuple": lambda: tuple(map(unpack, content)),
        "list": lambda: list(map(unpack, content)),
        "dict": lambda: {unpack(k): unpack(x) for k, x in content},
        "sparse": lambda: _import_class(content[0], ("scipy",))(tuple(map(unpack, content[2:])), shape=tuple(content[1])),
        "class": lambda: _import_class(content[0], packages),
        "record": lambda: _build_record(_import_class(content[0], packages), {k: unpack(x) for k, x in content[1].items()}),
    }
    return makers[sort]()


def _import_class(name: str, packages: tuple[str, ...]) -> Any:
    """Import a class by its name ``module:class``; raise ValueError for one of a package that is not allowed."""
    module, _, path = name.partition(":")
    if module.split(".")[0] not in packages:
        raise ValueError(f"{name} does not belong to one of the packages {', '.join(packages)}")
    found: Any = import_module(module)
    for attribute in path.split("."):
        found = getattr(found, attribute)
    if not isinstance(found, type):
        raise ValueError(f"{name} is not a class")
    return found


def _build_record(class_: type, fields: dict[str, Any]) -> Any:
    """Create a record of a dataclass with the values of its fields, without calling its constructor."""
    if not dataclasses.is_dataclass(class_) or fields.keys() != {f.name for f in dataclasses.fields(class_)}:
        raise ValueError(f"{class_.__name__} is not a record with the fields {', '.join(fields)}")
    record = object.__new__(class_)
    for name, value in fields.items():
        object.__setattr__(record, name, value)
    return record
