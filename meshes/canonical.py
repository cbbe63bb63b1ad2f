"""One exact text for what results depend on, and its digest: keys of stored runs and of cached parts.

A record (dataclass or named tuple) is its name and, by name, those fields that differ from their frozen default: that of
the day they were added (`meshes.fields`). So a field that is added changes no key, and a default that is changed later
changes the key of all that relied on it. Equal numbers have one text, whatever their type; negative zero differs from
zero, and all not-a-numbers are one value. The module of a record's class does not count, its name does.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from typing import Any

import numpy as np

from rollbench.meshes.fields import FROZEN

#: Version of the form, part of every digest: bump it when the same value gets another text.
FORM = 1


@dataclass(frozen=True)
class Fields:
    """Fields of a record as read back from a file."""

    #: Class of the record.
    record: type
    #: Values by field; one that is absent has its frozen default.
    values: Mapping[str, object]


def digest(*parts: object) -> str:
    """Digest of the canonical form of some values.

    Parameters
    ----------
    *parts : object
        Values, as `canonical` takes them.

    Returns
    -------
    str
        SHA-256 as 64 hexadecimal digits.

    Raises
    ------
    TypeError
        As `canonical`.

    Examples
    --------
    >>> digest(3) == digest(3.0), len(digest(3))
    (True, 64)
    """
    return hashlib.sha256(f"form {FORM}: {canonical(parts)}".encode()).hexdigest()


def canonical(value: object) -> str:
    """Text of a value: equal for equal values, different for different ones.

    Parameters
    ----------
    value : object
        Record, tuple, list, dict (whatever its order), None, truth value, number, text, class, array (as type, shape
        and digest of its values) or compressed sparse matrix; nested as you like.

    Returns
    -------
    str
        The text.

    Raises
    ------
    TypeError
        A value of any other type.

    Examples
    --------
    >>> canonical((3, 3.0, 0.1, -0.0, True, "a", None))
    '(3, 3, 0.1, -0, True, "a", None)'
    """
    write = _WRITERS.get(type(value))
    if write is not None:
        return write(value)
    if is_dataclass(value) and not isinstance(value, type):
        return _record_text(type(value), {f.name: getattr(value, f.name) for f in fields(value)})
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return _record_text(type(value), value._asdict())
    if isinstance(value, str):  # a text that knows more of itself, as a status
        return canonical(str(value))
    if isinstance(value, type):
        return f"class {value.__module__}.{value.__qualname__}"
    if isinstance(value, np.bool | np.integer | np.float64 | np.float32 | np.float16 | np.str_):
        return canonical(value.item())
    kind = getattr(value, "format", "")
    if type(value).__module__.startswith("scipy.sparse") and kind in ("csr", "csc"):  # a matrix or an array
        return f"{kind}_matrix{canonical([getattr(value, x) for x in ('shape', 'data', 'indices', 'indptr')])}"
    raise TypeError(f"{type(value).__module__}.{type(value).__qualname__} has no canonical form")


def _record_text(record: type, values: Mapping[str, object]) -> str:
    name, usual = record.__name__, _frozen_default_texts(record)
    texts = {field: canonical(value) for field, value in values.items()}
    return f"{name}({', '.join(f'{field}={texts[field]}' for field in sorted(texts) if texts[field] != usual.get(field))})"


@cache
def _frozen_default_texts(record: type) -> Mapping[str, str]:
    """Texts of the frozen defaults of a record, by field; none of a record that is not `keyed`."""
    frozen = FROZEN.get(record.__name__, {})
    return {field: f"{type(x).__name__}()" if is_dataclass(x) else canonical(x) for field, x in frozen.items()}


def _float_text(value: float) -> str:
    if value.is_integer():
        return str(int(value)) if value or math.copysign(1.0, value) > 0.0 else "-0"
    return repr(value)


def _array_text(value: np.ndarray[Any, Any]) -> str:
    if value.dtype.kind not in "biufc":
        raise TypeError(f"an array of {value.dtype} has no canonical form")
    return f"array({value.dtype.str}, {value.shape}, {hashlib.sha256(np.ascontiguousarray(value).data).hexdigest()})"


def _dict_text(value: Mapping[object, object]) -> str:
    return "{" + ", ".join(sorted(f"{canonical(k)}: {canonical(v)}" for k, v in value.items())) + "}"


#: How values of exactly these classes are written.
_WRITERS: Mapping[type, Callable[[Any], str]] = {
    type(None): str,
    bool: str,
    int: str,
    float: _float_text,
    str: json.dumps,
    tuple: lambda value: f"({', '.join(map(canonical, value))})",
    list: lambda value: f"[{', '.join(map(canonical, value))}]",
    dict: _dict_text,
    np.ndarray: _array_text,
    Fields: lambda value: _record_text(value.record, value.values),
}
