"""Calls of a function once more, with other numbers: they reach branches and bounds that the calls of scenes do not."""

from __future__ import annotations

import signal
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from copy import copy
from dataclasses import fields, is_dataclass
from inspect import CO_GENERATOR, CO_VARARGS, CO_VARKEYWORDS
from itertools import count, islice
from types import CellType, CodeType, FrameType, FunctionType
from typing import Any

import numpy as np

#: Ways in which numbers are others: by some share; some zero and some with the other sign; within a decade up or down.
WAYS = 3
#: Seconds after which a call is ended, and values of a generator that are looked at.
PATIENCE, VALUES = 60.0, 2000


class Late(BaseException):
    """A call with other numbers does not end."""


@contextmanager
def patience(seconds: float) -> Iterator[None]:
    """Raise `Late` after some seconds."""

    def late(*_: object) -> None:
        raise Late

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def other(value: Any, way: int, places: Iterator[int], seen: dict[int, Any]) -> Any:
    """A copy of an argument with other numbers; whole numbers, words and what is no record or container stay."""
    if isinstance(value, float | np.floating):
        return float(others(np.array([value], dtype=float), way, next(places))[0])
    if isinstance(value, np.ndarray):
        return others(value, way, next(places))
    if isinstance(value, tuple):
        below = [other(x, way, places, seen) for x in value]
        return type(value)(*below) if hasattr(value, "_fields") else tuple(below)
    if isinstance(value, list):
        return [other(x, way, places, seen) for x in value]
    if isinstance(value, dict):
        return {key: other(x, way, places, seen) for key, x in value.items()}
    record = is_dataclass(value) and not isinstance(value, type)
    if not record and not (type(value).__module__.startswith("rollbench.") and hasattr(value, "__dict__")):
        return value
    if isinstance(value, type | str) or (callable(value) and not record):
        return value
    if id(value) not in seen:
        seen[id(value)] = (new, _) = (copy(value), value)
        names = [f.name for f in fields(value)] if record else list(vars(value))
        for name in set(getattr(new, "__dict__", ())) - set(names):  # what was derived from the former numbers
            del new.__dict__[name]
        for name in names:
            if hasattr(value, name):
                object.__setattr__(new, name, other(getattr(value, name), way, places, seen))
    return seen[id(value)][0]


def others(x: np.ndarray, way: int, place: int) -> np.ndarray:
    """A copy of an array with other numbers, see `WAYS`."""
    if x.dtype.kind not in "fb":
        return x.copy()
    wave = np.cos(1.3 + 2.1 * np.arange(x.size) + place).reshape(x.shape)
    if x.dtype.kind == "b":
        return x ^ (wave > 0.6) if way == 1 else x.copy()
    with np.errstate(all="ignore"):
        return x * (1.0 + 0.3 * wave, np.where(wave < -0.5, 0.0, np.where(wave > 0.6, -1.0, 1.0)), 10.0**wave)[way]


class Call:
    """A function as it is called: what it was given, before it changes that."""

    def __init__(self, frame: FrameType) -> None:
        code, local = frame.f_code, frame.f_locals
        plain = code.co_argcount + code.co_kwonlyargcount
        self._names = code.co_varnames[:plain]
        self._count = code.co_argcount
        self._given = {name: local[name] for name in self._names}
        rest = iter(code.co_varnames[plain:])
        self._star = local[next(rest)] if code.co_flags & CO_VARARGS else ()
        self._words = local[next(rest)] if code.co_flags & CO_VARKEYWORDS else {}
        self._globals = frame.f_globals
        self._cells = {name: CellType(local[name]) if name in local else CellType() for name in code.co_freevars}

    def again(self, code: CodeType, way: int, seconds: float = PATIENCE) -> dict[str, Any]:
        """What the function answers with other numbers, or the kind of error, and what it leaves in its arguments."""
        places, seen = count(), {}
        given = {name: other(value, way, places, seen) for name, value in self._given.items()}
        star, words = other(tuple(self._star), way, places, seen), other(self._words, way, places, seen)
        cells = tuple(self._cells.get(name, CellType()) for name in code.co_freevars)
        function = FunctionType(code, self._globals, code.co_name, None, cells or None)
        at = [given[name] for name in self._names[: self._count]]
        named = {name: given[name] for name in self._names[self._count :]}
        with patience(seconds), warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            try:
                value = function(*at, *star, **named, **words)
                value = list(islice(value, VALUES)) if code.co_flags & CO_GENERATOR else value
            except Exception as error:
                value = type(error).__name__
        return {"": value, "given": given}
