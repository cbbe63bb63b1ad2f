"""Canonical text of records and other values, from which the keys of stored 3D runs and cached results are computed.

A stored run is found again by a key, a digest of the canonical text of its inputs. The text of a record (dataclass or named
tuple) is its class's name and those fields that differ from their frozen defaults, sorted by name. A frozen default is the
default on the day on which the field was added. So a new field changes no key of older runs, provided that `frozen_default`
defines its default; `frozen_record` raises an error at import otherwise. A default that is changed later changes
the keys of all records that used it. Equal numbers have the same text whatever their type; negative zero differs from zero,
and all NaN values are the same. The module of a record's class does not matter.

For fields that are also keys of a scene file, the type gives unit and range (`meshes.ranges`), and `scene_key` or
`frozen_default` gives description and example.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, field, fields, is_dataclass, replace
from functools import cache
from typing import Any, TypeVar, dataclass_transform

import numpy as np

T = TypeVar("T")

#: Frozen defaults: for the name of each record, the default of each field by the field's name.
FROZEN: dict[str, dict[str, object]] = {}
#: Stands for an argument that is not given.
_NONE: Any = object()


def scene_key(
    description: str = "", example: object = None, *, static: bool = True, usual: Any = _NONE, **more: Any
) -> Any:
    """Return a dataclass field that is also a key of scene files; without a default, a file must have the key.

    Parameters
    ----------
    description : str, optional
        Description of the key, for the JSON schema and the manual; without it the field is no key.
    example : object, default None
        Example of a value as written in a scene file; that of the field's type if left out.
    static : bool, default True
        Whether the field has an effect on static contact loads, and so is a part of the keys of stored runs and bodies.
    usual : object, optional
        Frozen default, as `frozen_default` sets it; the default of today may be another.
    **more : Any
        Further arguments of ``dataclasses.field``, such as the default in SI units.

    Returns
    -------
    dataclasses.Field
        The field, for the body of a dataclass.
    """
    key = {"description": description or None, "examples": None if example is None else [example], "static": static}
    said = {name: value for name, value in key.items() if value is not None}
    return field(metadata=said if usual is _NONE else said | {"usual": usual}, **more)


def frozen_default(
    default: Any, description: str = "", example: object = None, *, static: bool = True, compare: bool = True
) -> Any:
    """Return a dataclass field with a frozen default: a value equal to it does not change the keys of stored 3D runs.

    The frozen default must never be changed, because the keys of stored runs depend on it.

    Parameters
    ----------
    default : Any
        Frozen default, on the day on which the field was added.
    description, example, static : str, object and bool, optional
        Description and example of the field as a key of scene files, and whether it affects static contact loads, as for
        `scene_key`.
    compare : bool, default True
        Whether the field counts when records are compared and hashed.

    Returns
    -------
    dataclasses.Field
        The field, for the body of a dataclass.
    """
    return scene_key(description, example, static=static, usual=default, default=default, compare=compare)


@dataclass_transform(frozen_default=True, field_specifiers=(scene_key,))
def frozen_record(record: type[T]) -> type[T]:
    """Make a frozen dataclass of a class from whose fields keys of stored 3D runs are made (a class decorator).

    Parameters
    ----------
    record : type[T]
        The class with its fields.

    Returns
    -------
    type
        The same class as a dataclass; its frozen defaults are now in `FROZEN`.

    Raises
    ------
    TypeError
        The default of a field is not defined by `frozen_default`.
    """
    dataclass(frozen=True)(record)
    frozen: dict[str, object] = {}
    for each in fields(record):  # type: ignore[arg-type]
        if "usual" in each.metadata:
            frozen[each.name] = each.metadata["usual"]
        elif each.default is not MISSING or each.default_factory is not MISSING:
            advice = (
                "write frozen_default(DEFAULT), which keeps the keys of runs stored before this field existed; otherwise "
                "these runs are no longer found"
            )
            raise TypeError(f"{record.__name__}.{each.name}: its default is not frozen: {advice}")
    FROZEN[record.__name__] = frozen
    record.__pydantic_config__ = {"extra": "forbid"}  # type: ignore[attr-defined]
    return record


def static_part(record: Any) -> Any:
    """Return a record with those fields reset that have no effect on static contact loads, also in records inside it.

    Parameters
    ----------
    record : Any
        Record, tuple of records, or any other value.

    Returns
    -------
    Any
        The record with the frozen default, or an empty text, in these fields; another value unchanged.
    """
    if type(record) is tuple:
        return tuple(map(static_part, record))
    if not is_dataclass(record):
        return record
    changes = {
        each.name: static_part(getattr(record, each.name))
        if each.metadata.get("static", True)
        else each.metadata.get("usual", "")
        for each in fields(record)
        if each.init
    }
    return replace(record, **changes)  # type: ignore[type-var]


#: Version of the canonical text, a part of every digest; increase it when the text of any value changes.
FORM = 1


@dataclass(frozen=True)
class RecordFields:
    """Class and field values of a record that is read from a file; it has the same canonical text as the record."""

    #: Class of the record.
    record: type
    #: Values by the fields' names; a field that is absent has its frozen default.
    values: Mapping[str, object]


def digest_of_values(*parts: object) -> str:
    """Compute a digest of values from their canonical texts; equal values have equal digests.

    Parameters
    ----------
    *parts : object
        Values of the types that `canonical_text` accepts.

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
    >>> digest_of_values(3) == digest_of_values(3.0), len(digest_of_values(3))
    (True, 64)
    """
    return hashlib.sha256(f"form {FORM}: {canonical_text(parts)}".encode()).hexdigest()


def canonical_text(value: object) -> str:
    """Return the canonical text of a value: the same for equal values, and different for different values.

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
    >>> canonical_text((3, 3.0, 0.1, -0.0, True, "a", None))
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
        return canonical_text(str(value))
    if isinstance(value, type):
        return f"class {value.__module__}.{value.__qualname__}"
    if isinstance(value, np.bool | np.integer | np.float64 | np.float32 | np.float16 | np.str_):
        return canonical_text(value.item())
    kind = getattr(value, "format", "")
    if type(value).__module__.startswith("scipy.sparse") and kind in ("csr", "csc"):  # a matrix or an array
        return f"{kind}_matrix{canonical_text([getattr(value, x) for x in ('shape', 'data', 'indices', 'indptr')])}"
    raise TypeError(
        f"{type(value).__module__}.{type(value).__qualname__}: values of this type have no canonical text, from which the "
        "key of a stored run is computed"
    )


def _record_text(record: type, values: Mapping[str, object]) -> str:
    """Return the canonical text of a record; ``record``: its class; ``values``: its values by the fields' names."""
    name, usual = record.__name__, _frozen_default_texts(record)
    texts = {field: canonical_text(value) for field, value in values.items()}
    return f"{name}({', '.join(f'{field}={texts[field]}' for field in sorted(texts) if texts[field] != usual.get(field))})"


@cache
def _frozen_default_texts(record: type) -> Mapping[str, str]:
    """Return the canonical texts of the frozen defaults of the class ``record``, by the names of the fields.

    They are empty for a class that is not decorated by `frozen_record`.
    """
    frozen = FROZEN.get(record.__name__, {})
    return {field: f"{type(x).__name__}()" if is_dataclass(x) else canonical_text(x) for field, x in frozen.items()}


def _float_text(value: float) -> str:
    """Return the canonical text of a floating-point number; whole numbers are written as integers."""
    if value.is_integer():
        return str(int(value)) if value or math.copysign(1.0, value) > 0.0 else "-0"
    return repr(value)


def _array_text(value: np.ndarray[Any, Any]) -> str:
    """Return the canonical text of an array: its type, its shape and the digest of its values."""
    if value.dtype.kind not in "biufc":
        raise TypeError(
            f"an array of {value.dtype} has no canonical text, from which the key of a stored run is computed: its entries "
            "are not numbers"
        )
    return f"array({value.dtype.str}, {value.shape}, {hashlib.sha256(np.ascontiguousarray(value).data).hexdigest()})"


def _dict_text(value: Mapping[object, object]) -> str:
    """Return the canonical text of a dict, with sorted items."""
    return "{" + ", ".join(sorted(f"{canonical_text(k)}: {canonical_text(v)}" for k, v in value.items())) + "}"


#: For values of exactly these classes, the function that returns their canonical text.
_WRITERS: Mapping[type, Callable[[Any], str]] = {
    type(None): str,
    bool: str,
    int: str,
    float: _float_text,
    str: json.dumps,
    tuple: lambda value: f"({', '.join(map(canonical_text, value))})",
    list: lambda value: f"[{', '.join(map(canonical_text, value))}]",
    dict: _dict_text,
    np.ndarray: _array_text,
    RecordFields: lambda value: _record_text(value.record, value.values),
}
