"""Records that `rollbench.table` returns: stiffness, preload, life and other quantities over values of scene parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.compare.quantities import fields_from_json, name_and_unit_of_key
from rollbench.compare.results.data import Data
from rollbench.meshes.arrays import Array, RecordWithArrays
from rollbench.meshes.parts import FREEDOMS
from rollbench.meshes.quantity import quantity_field, result_record

if TYPE_CHECKING:
    import pandas

#: Status of a row with an equilibrium.
CONVERGED = "converged"

#: Quantities of a table row other than the stiffness matrix, each with the field of `TableRow` that has its expected error.
ERROR_OF = {
    "nut_tangent_N_per_um": "",
    "load_point_tangent_N_per_um": "rigidity_error",
    "nut_displacement_um": "",
    "load_point_displacement_um": "displacement_error",
    "largest_load_N": "load_error",
    "preload_N": "load_error",
    "largest_pressure_MPa": "pressure_error",
    "life_million_revolutions": "load_error",
}


@result_record
class TableRow(RecordWithArrays):
    """Stiffness and other results for one combination of parameter values, in SI units; expected errors are in per cent.

    A field is None if the user did not ask for it, or if there is no equilibrium.
    """

    status: str = quantity_field("status")
    """The word "converged", or the reason why there is no equilibrium."""
    stiffness: Array | None = quantity_field(
        "stiffness",
        "row by row: change of force [N] and moment [N m] for a unit displacement [m] or rotation [rad] of the body that "
        "`stiffness_of` names, at the axial position `station_mm`, or if that is null at the centre of the nut or bearing; "
        "for a whole shaft, at the position that the scene states",
        parts="[][]",
        default=None,
    )
    nut_tangent: float | None = quantity_field(
        "nut_tangent_N_per_um",
        "`nut.tangent_N_per_um`, without the shaft",
        heading="nut: axial rigidity, tangent",
        default=None,
    )
    load_point_tangent: float | None = quantity_field(
        "load_point_tangent_N_per_um",
        "`load_point.tangent_N_per_um`, to ground",
        error="`expected_error_percent.rigidity`",
        heading="load's point: rigidity, tangent",
        default=None,
    )
    nut_displacement: float | None = quantity_field(
        "nut_displacement_um", "`nut.displacement_um`", heading="nut: axial displacement", default=None
    )
    load_point_displacement: float | None = quantity_field(
        "load_point_displacement_um",
        "`load_point.displacement_um`",
        error="`expected_error_percent.displacement`",
        heading="load's point: displacement",
        default=None,
    )
    load: float | None = quantity_field(
        "largest_load_N", "largest contact load", error="`expected_error_percent.load`, of the mean load", default=None
    )
    preload: float | None = quantity_field(
        "preload_N",
        "axial force between the two pairs of groove flanks without the scene's external loads",
        error="that of the loads",
        default=None,
    )
    pressure: float | None = quantity_field(
        "largest_pressure_MPa",
        "largest Hertz pressure",
        error="`expected_error_percent.pressure`",
        heading="pressure",
        default=None,
    )
    life: float | None = quantity_field(
        "life_million_revolutions",
        "life by the contact loads, L10 of a nut, L10r of a bearing",
        error="about three times that of the loads",
        heading="life by the contact loads",
        default=None,
    )
    load_error: float | None = quantity_field(
        "expected_error_percent.load",
        "expected error of the worst contact load, in per cent of the mean load",
        default=None,
    )
    rms_error: float | None = quantity_field(
        "expected_error_percent.rms_load",
        "expected root mean square error of the contact loads, in per cent of the mean load",
        default=None,
    )
    displacement_error: float | None = quantity_field(
        "expected_error_percent.displacement", "expected error of the displacement of the load's point", default=None
    )
    rigidity_error: float | None = quantity_field(
        "expected_error_percent.rigidity", "expected error of the tangent of the load's point", default=None
    )
    pressure_error: float | None = quantity_field(
        "expected_error_percent.pressure", "expected error of the largest pressure", default=None
    )
    error_words: str = quantity_field("expected_error_words", default="")
    """Reason why the expected errors are not known; empty if they are known."""

    @property
    def converged(self) -> bool:
        """Whether an equilibrium was found."""
        return self.status == CONVERGED


@dataclass(frozen=True)
class Over:
    """A parameter of the scene that a table varies, with its values."""

    key: str
    """Key of the parameter in the scene file, as the user wrote it."""
    column: str
    """Name of the table's column with its values, which ends with their unit."""
    values: tuple[float | str, ...]
    """Values of the parameter in the order of the table's rows; numbers are in the unit of the column."""

    @property
    def unit(self) -> str:
        """Unit of the values, taken from the column's name, where it follows the parameter's key; empty without unit."""
        return self.column.removeprefix(self.key).lstrip("_")

    @property
    def numbers(self) -> list[float] | None:
        """Values of the parameter as numbers; None if a value is a text."""
        return [float(x) for x in self.values] if all(isinstance(x, int | float) for x in self.values) else None


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Table(Data):
    """Stiffness and other results of a scene for all combinations of the values of some of its parameters.

    Examples
    --------
    >>> import rollbench
    >>> found = rollbench.table("lin-case1", ["load=2:6:3 kN"], quantities=["displacement"], model="lin")
    >>> for place, row in zip(found.places, found.rows):
    ...     print(place["load_kN"], "kN:", round(1e6 * row.load_point_displacement, 1), "um")
    2.0 kN: 16.1 um
    4.0 kN: 28.1 um
    6.0 kN: 39.1 um
    """

    scene: str
    """Name of the scene."""
    model: str
    """Name of the model."""
    over: tuple[Over, ...]
    """Varied parameters with their values; the value of the last one changes fastest from row to row."""
    stiffness_of: str
    """Text that names the body whose stiffness the rows contain, and the axial position at which the stiffness is taken."""
    rows: tuple[TableRow, ...]
    """A row for each combination of values. If there is no equilibrium, its status says why."""

    @property
    def converged(self) -> int:
        """Number of rows with an equilibrium."""
        return sum(row.converged for row in self.rows)

    @property
    def places(self) -> list[dict[str, float | str]]:
        """Values of the varied parameters for each row of the table, by the name of their column."""
        columns = [x.column for x in self.over]
        return [dict(zip(columns, values, strict=True)) for values in product(*(x.values for x in self.over))]

    @property
    def failures(self) -> dict[str, list[str]]:
        """Combinations of parameter values without equilibrium, as texts, by the reason why there is none."""
        out: dict[str, list[str]] = {}
        for row, place in zip(self.rows, self.places, strict=True):
            if not row.converged:
                out.setdefault(row.status, []).append(parameter_values_text(self.over, place))
        return out

    @property
    def stiffness(self) -> Array:
        """Tangent stiffness of all rows, (n, 6, 6) [N/m, N/rad, N m/rad]; nan in rows without a stiffness."""
        return np.array([np.full((6, 6), np.nan) if x.stiffness is None else x.stiffness for x in self.rows])

    def columns(self) -> dict[str, list[float | str | None]]:
        """Return the table as lists of equal length, one for each number of a row, by the names of the JSON keys.

        Returns
        -------
        dict
            List of each column, by its name: values of the varied parameters, status, stiffness terms ``K_ux_ux`` to
            ``K_rz_rz`` in N, m and rad, the other quantities, and the expected errors.
        """
        flat = [dict(_flatten_table_row(row)) for row in self.values["rows"]]  # type: ignore[arg-type, union-attr]
        names = dict.fromkeys(name for row in flat for name in row)
        return {name: [row.get(name) for row in flat] for name in names}

    def units(self) -> dict[str, str]:
        """Return the unit of each column of `columns` by its name; columns without unit are left out.

        Returns
        -------
        dict
            Unit of each column, such as "N/m", by the column's name. A stiffness term ``K_a_b`` has the unit of the force
            or moment of a, divided by that of the displacement or rotation of b.
        """
        of_key = {x.column: x.unit for x in self.over}
        found = {name: of_key.get(name, _unit_of_column(name)) for name in self.columns()}
        return {name: unit for name, unit in found.items() if unit}

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the table as a pandas data frame with the columns of `columns`.

        Returns
        -------
        pandas.DataFrame
            A row for each combination of parameter values.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        import pandas

        return pandas.DataFrame(self.columns())


#: Units of the forces and moments, and of the displacements and rotations, in the order of `FREEDOMS`.
FORCE_UNITS, FREEDOM_UNITS = ("N",) * 3 + ("N m",) * 3, ("m",) * 3 + ("rad",) * 3


def _unit_of_column(name: str) -> str:
    """Return the unit of a column of computed values by its name; empty where it has none."""
    term = name.removeprefix("K_").split("_")
    if name.startswith("K_"):
        return f"{FORCE_UNITS[FREEDOMS.index(term[0])]}/{FREEDOM_UNITS[FREEDOMS.index(term[1])]}"
    if name.startswith("expected_error_percent_"):
        return "%"
    unit = name_and_unit_of_key(name)[1]
    return "" if unit is None else unit.text


def _flatten_table_row(row: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield key and value of every single number in one row of the table's JSON.

    The stiffness matrix gives 36 values, with keys such as ``K_ux_ry``; an inner JSON object gives one value for each key
    inside it, with both keys joined by ``_``.
    """
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
        The table, with numbers in SI units.

    Raises
    ------
    KeyError, TypeError
        If the JSON was written by another command.
    """
    rows = [TableRow(**fields_from_json(TableRow, row)) for row in data["rows"]]
    return Table(
        values={key: value for key, value in data.items() if key != "schema"},
        scene=data["scene"],
        model=data["model"],
        stiffness_of=data["stiffness_of"],
        over=tuple(Over(x["key"], x["column"], tuple(x["values"])) for x in data["over"]),
        rows=tuple(x if x.stiffness is None else replace(x, stiffness=np.array(x.stiffness, dtype=float)) for x in rows),
    )


def parameter_values_text(over: Sequence[Over], row: Mapping[str, Any]) -> str:
    """Return a text with the values of the varied parameters in one row of a table, such as "load 2 kN".

    Parameters
    ----------
    over
        The varied parameters.
    row
        Values of the parameters, by the name of the column.

    Returns
    -------
    str
        Text such as ``load 2 kN``; ``as it stands`` if no parameter is varied.
    """
    values = [row[x.column] for x in over]
    texts = [f"{value:g}" if isinstance(value, float) else str(value) for value in values]
    return ", ".join(f"{x.key} {text} {x.unit}".rstrip() for x, text in zip(over, texts, strict=True)) or "as it stands"
