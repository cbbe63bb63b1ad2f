"""Shared by the tests of keys: every record of which a key may be made, by name, and values of its fields."""

import dataclasses
import math
import types
import typing

import numpy as np

from rollbench.compare.cases.lin.kinds import bearings
from rollbench.compare.cases.lin.kinds.screw_balls import ScrewPairScene, ScrewRunScene
from rollbench.hifi.meshing.settings import Settings
from rollbench.hifi.rolling.bodies import Sizes
from rollbench.meshes.axis import Assembly
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import Scene
from rollbench.meshes.solid import Dimensions

#: Records that hold all others.
ROOTS = (Scene, Assembly, Dimensions, Settings, Sizes, GrooveMap, ScrewPairScene, ScrewRunScene, bearings.BearingBallScene)
ROOTS += (bearings.BearingPairScene, bearings.LinearChainScene, bearings.LinearPairScene)


def keyed_records() -> dict[str, type]:
    """The roots and all records that their fields may hold. Raises ValueError where two have one name."""
    found: dict[str, type] = {}
    left: list[object] = list(ROOTS)
    while left:
        of = left.pop()
        left += typing.get_args(of)
        if not isinstance(of, type) or typing.get_origin(of) is not None:
            continue
        if not (dataclasses.is_dataclass(of) or hasattr(of, "_field_defaults")):
            continue
        if found.setdefault(of.__name__, of) is not of:
            raise ValueError(f"two records are called {of.__name__}: {of.__module__} and {found[of.__name__].__module__}")
        hints = typing.get_type_hints(of)
        left += [hints[name] for name in names(of)]
    return found


def names(record: type) -> list[str]:
    """Fields of a record class, in order."""
    return [f.name for f in dataclasses.fields(record)] if dataclasses.is_dataclass(record) else list(record._fields)


def default(record: type, name: str) -> object:
    """Today's default of a field, `dataclasses.MISSING` without one."""
    if not dataclasses.is_dataclass(record):
        return record._field_defaults.get(name, dataclasses.MISSING)
    (field,) = (f for f in dataclasses.fields(record) if f.name == name)
    return field.default if field.default_factory is dataclasses.MISSING else field.default_factory()


def built(record: type, **values: object) -> object:
    """A record of these values, the rest as usual, whether or not it would take them."""
    if not dataclasses.is_dataclass(record):
        return record(**values)
    instance = object.__new__(record)
    vars(instance).update({name: values[name] if name in values else default(record, name) for name in names(record)})
    return instance


def changed(value: object, **values: object) -> object:
    """A record with some other values, whether or not it would take them."""
    return built(type(value), **({name: getattr(value, name) for name in names(type(value))} | values))


def example(record: type) -> object:
    """A record with some value in every field without a default."""
    hints = typing.get_type_hints(record)
    return built(record, **{n: some(hints[n]) for n in names(record) if default(record, n) is dataclasses.MISSING})


def some(hint: object) -> object:
    """A value of a type."""
    hint = getattr(hint, "__value__", hint)  # of an alias, such as numpy's NDArray from 2.5 on
    origin, of = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Literal:
        return of[0]
    if origin is typing.Annotated:
        return some(of[0])
    if origin is tuple:
        return (some(of[0]),) if of[-1] is ... else tuple(map(some, of))
    if origin in (typing.Union, types.UnionType):
        return some(next(x for x in of if x is not type(None)))
    if origin is np.ndarray:
        return np.arange(3.0)
    plain = {float: 1.25, int: 3, str: "a", bool: True}
    return plain[hint] if hint in plain else example(hint)


def other(value: object, hint: object) -> object:
    """A value of a type that differs from a given one as little as it can."""
    if value is None or (isinstance(value, tuple) and not value):
        return some(hint)
    if isinstance(value, bool):
        return not value
    if isinstance(value, float | int):
        return math.nextafter(value, 9e99) if math.isfinite(value) else 1.0
    if isinstance(value, str):
        return f"{value} "
    if isinstance(value, np.ndarray):
        return value + 1e-15
    if isinstance(value, tuple):
        return (*value[:-1], other(value[-1], type(value[-1])))
    metadata = {f.name: f.metadata for f in dataclasses.fields(value)} if dataclasses.is_dataclass(value) else {}
    name = [n for n in names(type(value)) if metadata.get(n, {}).get("static", True)][-1]  # one that may change keys
    hints = typing.get_type_hints(type(value))
    return changed(value, **{name: other(getattr(value, name), hints[name])})
