"""Results with units: the values that the command line prints as JSON, by path, as tables in a notebook, as arrays."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any

import numpy as np

from rollbench.compare.definitions import definition
from rollbench.compare.quantities import split_unit, unit_of
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import SIDES
from rollbench.reports.cells import micro


@dataclass(frozen=True)
class Result:
    """Values of a result by path: ``result["axial.displacement_um"]`` is a number or what JSON has in its place,
    ``result.quantity("axial.displacement_um")`` the same with its unit, for who has pint.

    data: all that the command prints with ``--json``; shown: what the table shows, by its path in data ("": all); notes:
    sentences below the table.
    """

    data: Mapping[str, Any]
    shown: str = ""
    notes: tuple[str, ...] = ()

    def __getitem__(self, path: str) -> Any:
        """The value at a path of keys with dots between. Raises KeyError with the keys that there are."""
        value: Any = self.data
        for key in path.split(".") if path else ():
            if not isinstance(value, Mapping) or key not in value:
                there = ", ".join(map(str, value)) if isinstance(value, Mapping) else "none, this is a value"
                raise KeyError(f"{path}: no {key!r}; keys here: {there}")
            value = value[key]
        return value

    def quantity(self, path: str) -> Any:
        """The number, or the list of numbers, at a path with the unit that its key ends with: a quantity of the package
        pint, which is not installed with this one.

        Raises KeyError for a path that is not there, ValueError for one that names no unit or holds no number, ImportError
        without pint.
        """
        try:
            import pint
        except ImportError as error:
            raise ImportError("quantities with units need the package pint: pip install pint") from error

        value = self[path]
        keys = reversed(path.split("."))  # a table of one unit has it in its own name
        unit = next((unit for key in keys if (unit := unit_of(key)[1]) is not None), None)
        if unit is None or value is None or isinstance(value, (str, bool, Mapping)):
            raise ValueError(f"{path}: {'no value' if value is None else 'no number with a unit'}")
        return pint.application_registry.get().Quantity(value, unit.text.replace("million ", "mega"))

    def definition(self, path: str) -> str:
        """What the number at a path is, and what its error is; empty where nothing is said of it. Raises KeyError for a
        path that is not there."""
        self[path]
        meaning = definition(path)
        return "" if meaning is None else meaning.text + (f"; its error: {meaning.error}" if meaning.error else "")

    def rows(self) -> list[tuple[str, str, str]]:
        """Name, value and unit of every single value that the table shows."""
        return [(name, _text(value), unit) for name, value, unit in _flat(self[self.shown], "")]

    def __str__(self) -> str:
        """The table as aligned text."""
        rows = self.rows()
        width = max((len(name) for name, *_ in rows), default=0)
        return "\n".join([*(f"{name:<{width}}  {value} {unit}".rstrip() for name, value, unit in rows), *self.notes])

    def _repr_html_(self) -> str:
        """The table for a notebook, a heading for every quantity that has parts."""
        body = ""
        for group, rows in groupby(self.rows(), lambda row: row[0].rpartition(": ")[0]):
            body += f"<tr><th colspan='3' style='text-align:left'>{html.escape(group)}</th></tr>" if group else ""
            body += "".join(
                f"<tr><td style='text-align:left'>{html.escape(name.removeprefix(f'{group}: '))}</td>"
                f"<td style='text-align:right'>{html.escape(value)}</td>"
                f"<td style='text-align:left'>{html.escape(micro(unit))}</td></tr>"
                for name, value, unit in rows
            )
        notes = "".join(f"<p>{html.escape(note)}</p>" for note in self.notes)
        head = "<thead><tr><th>quantity</th><th>value</th><th>unit</th></tr></thead>"
        return f"<table>{head}<tbody>{body}</tbody></table>{notes}"


@dataclass(frozen=True, repr=False)
class Solution(Result):
    """A solved scene. load: contact loads ``(balls, 4)`` [N] of the flanks SL, SR, NL, NR; angle: contact angles
    ``(balls, 4)`` [deg], nan without load; of several load cases ``(cases, balls, 4)``; both empty for a shaft with several
    sets, whose balls are in ``data``."""

    load: Array = field(default_factory=lambda: np.zeros((0, 4)))
    angle: Array = field(default_factory=lambda: np.zeros((0, 4)))

    @property
    def converged(self) -> bool:
        """Whether the model found an equilibrium; ``data["status"]`` says what happened if not."""
        return bool(self.data["status"] == "converged")

    def __repr__(self) -> str:
        """Scene, model and status; then loads, displacement, pressure and life in one line each."""
        lines = [f"{self.data['scene']}, {self.data['model']}: {self.data['status']}"]
        groups = (("loads", "max_N"), ("axial", "displacement_um"), ("worst_contact", "pressure_MPa"), ("life", ""))
        for group, key in groups:
            group_values = (self.data.get("summary") or {}).get(group) or {}
            key = key or next(iter(group_values), "")
            words, unit = split_unit(key)
            value = group_values.get(key)
            lines.append(
                f"{group.replace('_', ' ')}: {words} {_text(value)} {unit}" if value is not None else f"{group}: none"
            )
        return "\n".join(lines)

    def balls(self) -> str:
        """Loads of all balls [N] as text, one line each, of every case in order."""
        head = "ball " + "".join(f"{side:>10}" for side in SIDES)
        lines = []
        for load in self.load.reshape(-1, *self.load.shape[-2:]):
            lines += [head, *(f"{i + 1:<5}" + "".join(f"{x:10.1f}" for x in row) for i, row in enumerate(load))]
        return "\n".join(lines)


@dataclass(frozen=True)
class Friction(Result):
    """Friction of a scene: torques, efficiencies, losses."""

    @property
    def converged(self) -> bool:
        """Whether loads and friction balance; ``data["status"]`` says what happened if not."""
        return bool(self.data["converged"])


@dataclass(frozen=True)
class Judged(Result):
    """Verdicts on a scene: ``word`` is pass, fail, undecided or not covered."""

    @property
    def word(self) -> str:
        """The gravest of the verdicts."""
        return str(self.data["verdict"])

    @property
    def passed(self) -> bool:
        """Whether all pass."""
        return self.word == "pass"


def _flat(value: Any, name: str, of_all: str = "") -> Iterator[tuple[str, Any, str]]:
    """Single values below a value, with the words and the unit of their keys (or of what holds them: ``of_all``); None,
    and lists of records, left out."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            words, unit = split_unit(str(key))
            whole = f"{name}: {words}" if name else words
            if isinstance(inner, Mapping):
                yield from _flat(inner, whole, unit or of_all)
            elif inner is not None and not (isinstance(inner, list) and any(isinstance(x, (Mapping, list)) for x in inner)):
                yield whole, inner, unit or of_all
    elif isinstance(value, list):
        for number, inner in enumerate(value, start=1):
            yield from _flat(inner, f"{name} {number}".strip())


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.5g}"
    if isinstance(value, list):
        return ", ".join(map(_text, value))
    return str(value)
