"""Fields of the records that keys of stored runs are made of.

A field has a description, an example, a default, and the default by which it is hashed. A key leaves out a field that has
its frozen default, that of the day it was added (`meshes.canonical`). So a new field with a default changes no key, if
the default is given by `usual`; `keyed` refuses a record at import where one is not. Fields that a scene file has under
the same name carry what the file needs: unit and range by their type (`meshes.ranges`), description and example by
`about` and `usual`.
"""

from __future__ import annotations

import dataclasses
from dataclasses import field
from typing import Any, TypeVar

T = TypeVar("T")

#: Frozen defaults by names of record and field.
FROZEN: dict[str, dict[str, object]] = {}
_NONE: Any = object()


def about(description: str, example: object = None) -> dict[str, Any]:
    """Metadata of a field that is a key of scene files.

    Parameters
    ----------
    description : str
        What the key is, for schema and manual.
    example : object, default None
        Value as it stands in a file.

    Returns
    -------
    dict
        For ``dataclasses.field(metadata=...)``.
    """
    return {"description": description} | ({} if example is None else {"examples": [example]})


def usual(default: Any, description: str = "", example: object = None, *, now: Any = _NONE, compare: bool = True) -> Any:
    """Field with a frozen default, by which it is hashed.

    Keys of stored runs rest on the frozen default, so it stays as it is on the day the field is added.

    Parameters
    ----------
    default : Any
        The frozen default.
    description, example : , default ''
        As for `about`.
    now : object, optional, default _NONE
        Default of today where that has changed since.
    compare : bool, default True
        Whether the field counts in comparisons and hashes.

    Returns
    -------
    dataclasses.Field
        The field.
    """
    metadata = {"usual": default} | (about(description, example) if description else {})
    return field(default=default if now is _NONE else now, metadata=metadata, compare=compare)


def keyed(record: type[T]) -> type[T]:
    """Mark a frozen dataclass of which keys are made.

    Parameters
    ----------
    record : type[T]
        The dataclass.

    Returns
    -------
    type
        The same class, registered in `FROZEN`.

    Raises
    ------
    TypeError
        A field has a default that is not given by `usual`.
    """
    frozen: dict[str, object] = {}
    for each in dataclasses.fields(record):  # type: ignore[arg-type]
        if "usual" in each.metadata:
            frozen[each.name] = each.metadata["usual"]
        elif each.default is not dataclasses.MISSING or each.default_factory is not dataclasses.MISSING:
            advice = "write usual(DEFAULT), or a key of stored runs has it in it"
            raise TypeError(f"{record.__name__}.{each.name}: its default is not frozen: {advice}")
    FROZEN[record.__name__] = frozen
    record.__pydantic_config__ = {"extra": "forbid"}  # type: ignore[attr-defined]
    return record
