"""Definitions for the fields of records from which the keys of stored 3D runs are computed.

A stored run is found again by a key, a hash of its inputs. Each field has a frozen default: the default on the day on which
the field was added. A field whose value equals its frozen default does not enter the key (`meshes.canonical`). So a new
field changes no key of older runs, provided that `usual` defines its default; `keyed` raises an error at import otherwise.
For fields that are also keys of a scene file, the type gives unit and range (`meshes.ranges`), and `about` or `usual` gives
description and example.
"""

from __future__ import annotations

import dataclasses
from dataclasses import field
from typing import Any, TypeVar

T = TypeVar("T")

#: Frozen defaults: for the name of each record, the default of each field by the field's name.
FROZEN: dict[str, dict[str, object]] = {}
_NONE: Any = object()


def about(description: str, example: object = None) -> dict[str, Any]:
    """Make the metadata of a dataclass field that is also a key of scene files.

    Parameters
    ----------
    description : str
        Description of the key, for the JSON schema and the manual.
    example : object, default None
        Example of a value as written in a scene file.

    Returns
    -------
    dict
        Argument ``metadata`` of ``dataclasses.field``.
    """
    return {"description": description} | ({} if example is None else {"examples": [example]})


def usual(default: Any, description: str = "", example: object = None, *, now: Any = _NONE, compare: bool = True) -> Any:
    """Make a dataclass field with a default; a value equal to this default does not enter the keys of stored runs.

    The default given here is frozen: it must never be changed, because the keys of stored runs depend on it.

    Parameters
    ----------
    default : Any
        Frozen default, on the day on which the field was added.
    description, example : , default ''
        Description of the field as a key of scene files, and an example of its value, as for `about`.
    now : object, optional, default _NONE
        Default that is used today, where it differs from the frozen one.
    compare : bool, default True
        Whether the field counts when records are compared and hashed.

    Returns
    -------
    dataclasses.Field
        The field, for the body of a dataclass.
    """
    metadata = {"usual": default} | (about(description, example) if description else {})
    return field(default=default if now is _NONE else now, metadata=metadata, compare=compare)


def keyed(record: type[T]) -> type[T]:
    """Register the frozen defaults of a dataclass whose fields enter the keys of stored runs (a class decorator).

    Parameters
    ----------
    record : type[T]
        The frozen dataclass.

    Returns
    -------
    type
        The same class; its frozen defaults are now in `FROZEN`.

    Raises
    ------
    TypeError
        The default of a field is not defined by `usual`.
    """
    frozen: dict[str, object] = {}
    for each in dataclasses.fields(record):  # type: ignore[arg-type]
        if "usual" in each.metadata:
            frozen[each.name] = each.metadata["usual"]
        elif each.default is not dataclasses.MISSING or each.default_factory is not dataclasses.MISSING:
            advice = "write usual(DEFAULT), or the new field changes the keys of stored runs"
            raise TypeError(f"{record.__name__}.{each.name}: its default is not frozen: {advice}")
    FROZEN[record.__name__] = frozen
    record.__pydantic_config__ = {"extra": "forbid"}  # type: ignore[attr-defined]
    return record
