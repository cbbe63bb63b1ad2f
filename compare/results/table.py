"""Result of `rollbench.table`: stiffness and other quantities over given values of keys, with the error to expect."""

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

#: Quantities of a row besides the stiffness, with the field that holds the error to expect of each.
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
    """Row of a table: quantities at one combination of values of the keys, in SI units; errors in per cent.

    A field is None if it was not asked for or there is no equilibrium.
    """

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
        """Whether there is an equilibrium."""
        return self.status == CONVERGED


@dataclass(frozen=True)
class Over:
    """A key of a table, with its values."""

    key: str
    """Key of the scene, as it was given."""
    column: str
    """Name of its column, which ends with the unit of the values."""
    values: tuple[float | str, ...]
    """Values in the order of the rows; numbers in the unit of the column."""

    @property
    def unit(self) -> str:
        """Unit at the end of the column's name; empty if it has none."""
        return self.column.removeprefix(self.key).lstrip("_")

    @property
    def numbers(self) -> list[float] | None:
        """Values as numbers; None if one of them is text."""
        return [float(x) for x in self.values] if all(isinstance(x, int | float) for x in self.values) else None


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Table(Data):
    """Quantities of a scene for all combinations of values of its keys.

    Examples
    --------
    >>> import rollbench
    >>> found = rollbench.table("lin-case1", ["load=2:6:3 kN"], quantities=["displacement"], model="lin")
    >>> for place, row in zip(found.places, found.rows):
    ...     print(place["load_kN"], "kN:", round(1e6 * row.displacement, 1), "um")
    2.0 kN: 16.1 um
    4.0 kN: 28.1 um
    6.0 kN: 39.1 um
    """

    scene: str
    """Name of the scene."""
    model: str
    """Name of the model."""
    over: tuple[Over, ...]
    """Keys with their values; that of the last key changes fastest from row to row."""
    stiffness_of: str
    """Body and station whose stiffness the rows give, in words."""
    rows: tuple[TableRow, ...]
    """A row for each combination; without equilibrium its status says why."""

    @property
    def converged(self) -> int:
        """Number of rows with an equilibrium."""
        return sum(row.converged for row in self.rows)

    @property
    def places(self) -> list[dict[str, float | str]]:
        """Values of the keys for each row, by column."""
        columns = [x.column for x in self.over]
        return [dict(zip(columns, values, strict=True)) for values in product(*(x.values for x in self.over))]

    @property
    def failures(self) -> dict[str, list[str]]:
        """Texts of the combinations of key values without equilibrium, by reason."""
        out: dict[str, list[str]] = {}
        for row, place in zip(self.rows, self.places, strict=True):
            if not row.converged:
                out.setdefault(row.status, []).append(place_words(self.over, place))
        return out

    @property
    def stiffness(self) -> Array:
        """Tangent stiffness of all rows, (n, 6, 6) [N/m, N/rad, N m/rad]; nan where there is none."""
        return np.array([np.full((6, 6), np.nan) if x.stiffness is None else x.stiffness for x in self.rows])

    def columns(self) -> dict[str, list[float | str | None]]:
        """Return the columns of a flat table, named as the keys of the JSON.

        Returns
        -------
        dict
            Lists by column: values of the keys, status, ``K_ux_ux`` to ``K_rz_rz`` in N, m and rad, the other quantities
            and the errors to expect.
        """
        flat = [dict(_flatten_row(row)) for row in self.values["rows"]]  # type: ignore[arg-type, union-attr]
        names = dict.fromkeys(name for row in flat for name in row)
        return {name: [row.get(name) for row in flat] for name in names}

    def to_dataframe(self) -> pandas.DataFrame:
        """Return `columns` as a data frame, which needs the package pandas.

        Returns
        -------
        pandas.DataFrame
            A row for each combination.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        import pandas

        return pandas.DataFrame(self.columns())


def _flatten_row(row: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield keys and values of a row's JSON with inner tables flattened; the stiffness as 36 terms."""
    for key, value in row.items():
        if key == "stiffness":
            matrix = [[None] * 6] * 6 if value is None else value
            yield from ((f"K_{a}_{b}", matrix[i][j]) for i, a in enumerate(FREEDOMS) for j, b in enumerate(FREEDOMS))
        elif isinstance(value, Mapping):
            yield from ((f"{key}_{name}", x) for name, x in value.items())
        else:
            yield key, value


def table_from_json(data: Mapping[str, Any]) -> Table:
    """Convert the JSON of ``rollbench table`` to a record.

    Parameters
    ----------
    data
        JSON of the table.

    Returns
    -------
    Table
        The record.

    Raises
    ------
    KeyError, TypeError
        If the JSON is of another kind.
    """
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
    """Return a text with a row's values of the table's keys.

    Parameters
    ----------
    over
        The keys.
    row
        Values by column.

    Returns
    -------
    str
        Such as ``load 2 kN``; ``as it stands`` without keys.
    """
    values = [row[x.column] for x in over]
    texts = [f"{value:g}" if isinstance(value, float) else str(value) for value in values]
    return ", ".join(f"{x.key} {text} {x.unit}".rstrip() for x, text in zip(over, texts, strict=True)) or "as it stands"
