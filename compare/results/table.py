"""What `rollbench.table` gives: a scene at places of its keys, each with its stiffness and the error to expect."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.quantities import from_json
from rollbench.compare.results.data import Data
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import FREEDOMS
from rollbench.meshes.quantity import quantity, record

if TYPE_CHECKING:
    import pandas

CONVERGED = "converged"

#: What rows may have beside the stiffness, with the field of the error to expect of it.
ERROR_OF = {
    "axial_rigidity_N_per_um": "rigidity_error",
    "displacement_um": "displacement_error",
    "largest_load_N": "load_error",
    "preload_N": "load_error",
    "largest_pressure_MPa": "pressure_error",
    "life_million_revolutions": "load_error",
}


@record
class TableRow:
    """One place of a table, in SI units; None where it has no such answer or nobody asked. Errors in per cent."""

    status: str = quantity("status")
    stiffness: Array | None = quantity(
        "stiffness",
        "row by row: change of force [N] and moment [N m] for a unit displacement [m] or rotation [rad] of what "
        "`stiffness_of` says, at `station_mm`, "
        "at the set's centre where that is null, of a whole shaft where the scene asks for it",
        error="`expected_error_percent.rigidity`, on its axial term",
        parts="[][]",
        default=None,
    )
    rigidity: float | None = quantity(
        "axial_rigidity_N_per_um",
        "force per axial displacement of that section, rotation about the axis held, all else free",
        error="`expected_error_percent.rigidity`",
        heading="rigidity",
        default=None,
    )
    displacement: float | None = quantity(
        "displacement_um",
        "displacement of the loaded stations along the forces there, from the nominal place",
        error="`expected_error_percent.displacement`",
        default=None,
    )
    load: float | None = quantity(
        "largest_load_N", "largest contact load", error="`expected_error_percent.load`, of the mean load", default=None
    )
    preload: float | None = quantity(
        "preload_N", "axial force between the two pairs of flanks without the scene's loads", error="that of the loads",
        default=None,
    )  # fmt: skip
    pressure: float | None = quantity(
        "largest_pressure_MPa",
        "largest Hertz pressure",
        error="`expected_error_percent.pressure`",
        heading="pressure",
        default=None,
    )
    life: float | None = quantity(
        "life_million_revolutions",
        "life L10 of the load distribution",
        error="some three times that of the loads",
        heading="life L10",
        default=None,
    )
    load_error: float | None = quantity(
        "expected_error_percent.load", "to expect of the worst contact load, in per cent of the mean load", default=None
    )
    rms_error: float | None = quantity(
        "expected_error_percent.rms_load", "the same, root mean square of all contacts", default=None
    )
    displacement_error: float | None = quantity(
        "expected_error_percent.displacement", "of the axial displacement", default=None
    )
    rigidity_error: float | None = quantity("expected_error_percent.rigidity", "of the axial rigidity", default=None)
    pressure_error: float | None = quantity("expected_error_percent.pressure", "of the largest pressure", default=None)
    error_words: str = quantity("expected_error_words", default="")

    @property
    def converged(self) -> bool:
        """Whether there is an equilibrium at this place."""
        return self.status == CONVERGED


@dataclass(frozen=True)
class Over:
    """A key that a table goes over: as it was asked for, its column, and its values in order, numbers in the unit that the
    column's name ends with."""

    key: str
    column: str
    values: tuple[float | str, ...]

    @property
    def unit(self) -> str:
        """The unit that the column's name ends with; empty without."""
        return self.column.removeprefix(self.key).lstrip("_")

    @property
    def numbers(self) -> list[float] | None:
        """The values as numbers; None where one is a word."""
        return [float(x) for x in self.values] if all(isinstance(x, int | float) for x in self.values) else None


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Table(Data):
    """A scene at places of its keys."""

    scene: str
    """Name of the scene."""
    model: str
    """Model that solved it."""
    over: tuple[Over, ...]
    """Keys in the order of the rows: the last changes from row to row."""
    stiffness_of: str
    """What it is the stiffness of."""
    rows: tuple[TableRow, ...]
    """All places, also those without an answer, whose status says why."""

    @property
    def converged(self) -> int:
        """How many places have an equilibrium."""
        return sum(row.converged for row in self.rows)

    @property
    def places(self) -> list[dict[str, float | str]]:
        """The place of each row: its values by the columns of the keys."""
        columns = [x.column for x in self.over]
        return [dict(zip(columns, values, strict=True)) for values in product(*(x.values for x in self.over))]

    @property
    def failures(self) -> dict[str, list[str]]:
        """Why places have no answer: the places in words, by the reason."""
        out: dict[str, list[str]] = {}
        for row, place in zip(self.rows, self.places, strict=True):
            if not row.converged:
                out.setdefault(row.status, []).append(place_words(self.over, place))
        return out

    @property
    def stiffness(self) -> Array:
        """All stiffnesses ``(n, 6, 6)`` [N/m, N/rad, N m/rad]; nan without."""
        return np.array([np.full((6, 6), np.nan) if x.stiffness is None else x.stiffness for x in self.rows])

    def columns(self) -> dict[str, list[float | str | None]]:
        """Columns of a flat table, by the keys of the JSON: the place, the status, ``K_ux_ux`` to ``K_rz_rz`` in N, m and
        rad, the quantities that were asked for, and the errors to expect of them."""
        flat = [dict(_flat(row)) for row in self.values["rows"]]  # type: ignore[arg-type, union-attr]
        names = dict.fromkeys(name for row in flat for name in row)
        return {name: [row.get(name) for row in flat] for name in names}

    def to_dataframe(self) -> pandas.DataFrame:
        """`columns` as a data frame. Raises ImportError without pandas."""
        import pandas

        return pandas.DataFrame(self.columns())


def _flat(row: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for key, value in row.items():
        if key == "stiffness":
            matrix = [[None] * 6] * 6 if value is None else value
            yield from ((f"K_{a}_{b}", matrix[i][j]) for i, a in enumerate(FREEDOMS) for j, b in enumerate(FREEDOMS))
        elif isinstance(value, Mapping):
            yield from ((f"{key}_{name}", x) for name, x in value.items())
        else:
            yield key, value


def table_of(data: Mapping[str, Any]) -> Table:
    """The record of what ``rollbench table`` answers. Raises KeyError and TypeError for JSON of another kind."""
    rows = [TableRow(**from_json(TableRow, row)) for row in data["rows"]]
    return Table(
        values={key: value for key, value in data.items() if key != "schema"},
        scene=data["scene"],
        model=data["model"],
        stiffness_of=data["stiffness_of"],
        over=tuple(Over(x["key"], x["column"], tuple(x["values"])) for x in data["over"]),
        rows=tuple(x if x.stiffness is None else replace(x, stiffness=np.array(x.stiffness, dtype=float)) for x in rows),
    )


def place_words(over: Sequence[Over], row: Mapping[str, Any]) -> str:
    """The place of a row in words."""
    values = [row[x.column] for x in over]
    texts = [f"{value:g}" if isinstance(value, float) else str(value) for value in values]
    return ", ".join(f"{x.key} {text} {x.unit}".rstrip() for x, text in zip(over, texts, strict=True)) or "as it stands"
