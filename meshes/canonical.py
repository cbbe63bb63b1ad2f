"""Canonical text of values and its digest, from which the keys of stored runs and of cached results are computed.

The text of a record (dataclass or named tuple) is its class's name and those fields that differ from their frozen defaults,
sorted by name. A frozen default is the one on the day the field was added (`meshes.fields`). So a new field changes no key,
and a default that is changed later changes the keys of all records that used it. Equal numbers have the same text whatever
their type; negative zero differs from zero, and all NaN values are the same. The module of a record's class does not
matter.
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

#: Version of the canonical text, a part of every digest; increase it when the text of any value changes.
FORM = 1


@dataclass(frozen=True)
class Fields:
    """Class and fields of a record as read from a file; has the same canonical text as the record."""

    #: Class of the record.
    record: type
    #: Values by the fields' names; a field that is absent has its frozen default.
    values: Mapping[str, object]


def digest(*parts: object) -> str:
    """Compute the digest of values from their canonical text.

    Parameters
    ----------
    *parts : object
        Values of the types that `canonical` accepts.

    Returns
    -------
    str
        SHA-256 digest as 64 hexadecimal digits.

    Raises
    ------
    TypeError
        A value has no canonical text.

    Examples
    --------
    >>> digest(3) == digest(3.0), len(digest(3))
    (True, 64)
    """
    return hashlib.sha256(f"form {FORM}: {canonical(parts)}".encode()).hexdigest()


def canonical(value: object) -> str:
    """Return the canonical text of a value: the same for equal values, and different for different ones.

    Parameters
    ----------
    value : object
        Record, tuple, list, dict (in any order), None, bool, number, text, class, array (written as type, shape and digest
        of its values) or compressed sparse matrix; may be nested.

    Returns
    -------
    str
        Canonical text.

    Raises
    ------
    TypeError
        The value, or one inside it, is of another type.

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
    if isinstance(value, str):  # a subclass of str with further attributes, such as a status
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
    """Return the canonical text of a record from its class and the values of its fields."""
    name, usual = record.__name__, _frozen_default_texts(record)
    texts = {field: canonical(value) for field, value in values.items()}
    return f"{name}({', '.join(f'{field}={texts[field]}' for field in sorted(texts) if texts[field] != usual.get(field))})"


@cache
def _frozen_default_texts(record: type) -> Mapping[str, str]:
    """Return the canonical texts of a record's frozen defaults by field; empty for a record that is not `keyed`."""
    frozen = FROZEN.get(record.__name__, {})
    return {field: f"{type(x).__name__}()" if is_dataclass(x) else canonical(x) for field, x in frozen.items()}


def _float_text(value: float) -> str:
    """Return the canonical text of a number; whole numbers are written as integers."""
    if value.is_integer():
        return str(int(value)) if value or math.copysign(1.0, value) > 0.0 else "-0"
    return repr(value)


def _array_text(value: np.ndarray[Any, Any]) -> str:
    """Return the canonical text of an array: its type, its shape and the digest of its values."""
    if value.dtype.kind not in "biufc":
        raise TypeError(f"an array of {value.dtype} has no canonical form")
    return f"array({value.dtype.str}, {value.shape}, {hashlib.sha256(np.ascontiguousarray(value).data).hexdigest()})"


def _dict_text(value: Mapping[object, object]) -> str:
    """Return the canonical text of a dict, with sorted items."""
    return "{" + ", ".join(sorted(f"{canonical(k)}: {canonical(v)}" for k, v in value.items())) + "}"


#: For values of exactly these classes, the function that returns their canonical text.
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
