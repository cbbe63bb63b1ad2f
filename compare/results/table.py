"""Records that `rollbench.table` returns: stiffness, preload, life and other quantities over values of scene parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, cast

import numpy as np

from rollbench.compare.models.stiffness import NutAndLoadPoint
from rollbench.compare.quantities import quantities_of_record, record_as_json
from rollbench.compare.results.base import JSON, TabularRecord, add_schema_version, single_values, values_in_words
from rollbench.meshes.arrays import Array, RecordWithArrays
from rollbench.meshes.parts import FREEDOMS
from rollbench.meshes.quantity import quantity_field, quantity_or_none, result_record
from rollbench.reports.content import Figure, Panel, Series

#: Status of a row with an equilibrium.
CONVERGED = "converged"

#: Quantities that a table can have, with descriptions and the fields of a row that hold them.
QUANTITIES: dict[str, tuple[str, tuple[str, ...]]] = {
    "stiffness": (
        "6 x 6 tangent stiffness, and tangents of nut and load's point",
        ("stiffness", "nut_tangent_N_per_um", "load_point_tangent_N_per_um"),
    ),
    "displacement": ("displacements of nut and load's point", ("nut_displacement_um", "load_point_displacement_um")),
    "load": ("largest contact load", ("largest_load_N",)),
    "preload": ("axial preload", ("preload_N",)),
    "pressure": ("largest Hertz pressure", ("largest_pressure_MPa",)),
    "life": ("life by the contact loads", ("life_million_revolutions",)),
}

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
class TableRow(NutAndLoadPoint, RecordWithArrays):
    """Stiffness and other results for one combination of parameter values, in SI units; expected errors are in per cent.

    A field is None if the user did not ask for it, or if there is no equilibrium.
    """

    status: str = quantity_field("status")
    """The word "converged", or the reason why there is no equilibrium."""
    stiffness: Array | None = quantity_or_none(
        "stiffness",
        "row by row: change of force [N] and moment [N m] for a unit displacement [m] or rotation [rad] of the body that "
        "`stiffness_of` names, at the axial position `station_mm`, or if that is null at the centre of the nut or bearing; "
        "for a whole shaft, at the position that the scene states",
        parts="[][]",
    )
    load: float | None = quantity_or_none(
        "largest_load_N", "largest contact load", error="`expected_error_percent.load`, of the mean load"
    )
    preload: float | None = quantity_or_none(
        "preload_N",
        "axial force between the two pairs of groove flanks without the scene's external loads",
        error="that of the loads",
    )
    pressure: float | None = quantity_or_none(
        "largest_pressure_MPa", "largest Hertz pressure", error="`expected_error_percent.pressure`", heading="pressure"
    )
    life: float | None = quantity_or_none(
        "life_million_revolutions",
        "life by the contact loads, L10 of a nut, L10r of a bearing",
        error="about three times that of the loads",
        heading="life by the contact loads",
    )
    load_error: float | None = quantity_or_none(
        "expected_error_percent.load", "expected error of the worst contact load, in per cent of the mean load"
    )
    rms_error: float | None = quantity_or_none(
        "expected_error_percent.rms_load",
        "expected root mean square error of the contact loads, in per cent of the mean load",
    )
    displacement_error: float | None = quantity_or_none(
        "expected_error_percent.displacement", "expected error of the displacement of the load's point"
    )
    rigidity_error: float | None = quantity_or_none(
        "expected_error_percent.rigidity", "expected error of the tangent of the load's point"
    )
    pressure_error: float | None = quantity_or_none(
        "expected_error_percent.pressure", "expected error of the largest pressure"
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
class Table(TabularRecord):
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
    quantities: tuple[str, ...]
    """Names of the requested quantities, such as ``stiffness`` and ``life``."""
    stiffness_of: str
    """Text that names the body whose stiffness the rows contain, and the axial position at which the stiffness is taken."""
    station: float | None
    """Axial position on the shaft at which the stiffness is taken [m]; None: the centre of the nut or bearing, or the
    position that the scene states."""
    rows: tuple[TableRow, ...]
    """A row for each combination of values. If there is no equilibrium, its status says why."""

    def to_dict(self) -> dict[str, JSON]:
        """Return the table as a dictionary, as ``rollbench table --json`` prints it.

        Returns
        -------
        dict
            JSON values by key; rows have no keys of quantities that were not requested.
        """
        return add_schema_version(
            {
                "scene": self.scene,
                "model": self.model,
                "over": [{"key": x.key, "column": x.column, "values": list(x.values)} for x in self.over],
                "quantities": list(self.quantities),
                "freedoms": list(FREEDOMS),
                "stiffness_of": self.stiffness_of,
                "station_mm": None if self.station is None else 1e3 * self.station,
                "converged": self.converged,
                "rows": self._rows_as_json(),
            }
        )

    def _rows_as_json(self) -> list[dict[str, Any]]:
        """Return the rows as JSON: values of the varied parameters, and those quantities that were asked for."""
        wanted = {name for quantity in self.quantities for name in QUANTITIES[quantity][1]}
        without = {name for _, of in QUANTITIES.values() for name in of} - wanted
        return [place | record_as_json(row, *without) for place, row in zip(self.places, self.rows, strict=True)]

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

    def frame_rows(self) -> Sequence[Mapping[str, Any]]:
        """Return a row for each combination of values: the varied parameters, status, quantities and expected errors.

        The stiffness has the columns ``K_ux_ux`` to ``K_rz_rz`` in N, m and rad.

        Returns
        -------
        list
            Row of each line of the frame, by the names of its columns.
        """
        return [
            dict(single_values({"K" if key == "stiffness" else key: _by_freedoms(key, x) for key, x in row.items()}))
            for row in self._rows_as_json()
        ]

    @property
    def _notes(self) -> tuple[str, ...]:
        """Line below the table: model, and where the stiffness is taken."""
        station = None if self.station is None else 1e3 * self.station
        return (values_in_words({"model": self.model, "stiffness_of": self.stiffness_of, "station_mm": station}),)

    def figure(self) -> Figure | None:
        """Return the figure of each quantity over the varied parameter with most values; None without such a parameter.

        Returns
        -------
        reports.content.Figure or None
            The figure, as the report draws it; None if there is nothing to draw.
        """
        return _table_figure(self)

    def unit_of_column(self, name: str) -> str:
        """Return the unit of a column. A stiffness term ``K_a_b`` has the unit of a force or moment over that of a motion.

        Parameters
        ----------
        name
            Name of the column.

        Returns
        -------
        str
            The unit; empty without one.
        """
        over = next((x for x in self.over if x.column == name), None)
        if over is not None:
            return over.unit
        term = name.removeprefix("K_").split("_")
        if name.startswith("K_"):
            return f"{FORCE_UNITS[FREEDOMS.index(term[0])]}/{FREEDOM_UNITS[FREEDOMS.index(term[1])]}"
        return "%" if name.startswith("expected_error_percent_") else super().unit_of_column(name)


#: Units of the forces and moments, and of the displacements and rotations, in the order of `FREEDOMS`.
FORCE_UNITS, FREEDOM_UNITS = ("N",) * 3 + ("N m",) * 3, ("m",) * 3 + ("rad",) * 3


def _by_freedoms(key: str, value: Any) -> Any:
    """Return a stiffness (6, 6) by the names of its terms, None for each where it is not known; other values unchanged."""
    if key != "stiffness":
        return value
    matrix = [[None] * 6] * 6 if value is None else value
    return {f"{a}_{b}": matrix[i][j] for i, a in enumerate(FREEDOMS) for j, b in enumerate(FREEDOMS)}


#: Largest number of panels of a figure.
MOST_PANELS = 6


def _table_figure(table: Table) -> Figure | None:
    """Return a figure of each quantity over one varied key, with a curve for each combination of the other keys' values.

    The horizontal axis is the key with most values, among the keys whose values are numbers. Error bars show the errors to
    expect, for quantities whose error is known. None if no key has at least two numeric values.
    """
    over = [k for k, x in enumerate(table.over) if x.numbers is not None and len(x.values) > 1]
    columns = table.columns()
    known = [name for name in ERROR_OF if any(columns.get(name, ()))]  # not what is zero everywhere
    names, others = known[:MOST_PANELS], known[MOST_PANELS:]
    if not over or not names:
        return None
    along = max(over, key=lambda k: len(table.over[k].values))
    rest = [x for k, x in enumerate(table.over) if k != along]
    curves: dict[str, list[int]] = {}
    for k, place in enumerate(table.places):
        curves.setdefault(parameter_values_text(rest, place) if rest else "", []).append(k)
    x = cast("list[float]", columns[table.over[along].column])
    xlabel = " / ".join(filter(None, (table.over[along].key, table.over[along].unit)))
    panels = []
    for name in names:
        one, y = quantities_of_record(TableRow)[name], cast("list[float]", columns[name])
        series = []
        for label, at in curves.items():
            there = [k for k in at if y[k] is not None]
            if there:
                bars = _ends_of_error_bars(table, name, there)
                series.append(Series(label, [x[k] for k in there], [y[k] for k in there], error_bars=bars))
        same = len(series) > 1 and len({tuple(s.y) for s in series}) == 1
        ylabel = f"{one.label} / {one.unit}" + ("\nthe same on all curves" if same else "")
        low, high = (of(v for v in y if v is not None) for of in (min, max))
        panels.append(Panel("", xlabel, ylabel, series, log_axes="y" if 0.0 < 20.0 * low < high else ""))
    left = len(table.rows) - table.converged
    missing = f" {left} of {len(table.rows)} combinations of values have no result." if left else ""
    missing += f" Not drawn: {', '.join(quantities_of_record(TableRow)[x].label for x in others)}." if others else ""
    title = f"{table.scene}: requested quantities over the varied keys"
    return Figure(f"{table.scene}-table", title, tuple(panels), f"Model {table.model}.{missing}")


def _ends_of_error_bars(table: Table, name: str, rows: Sequence[int]) -> tuple[list[float], list[float]] | None:
    """Return the lower ends, then the upper ends of the error bars of a quantity; None if an expected error is not known.

    ``name``: column of the quantity; ``rows``: indices of the table rows.
    """
    if ERROR_OF[name] in ("", "load_error"):
        return None
    errors = [getattr(table.rows[k], ERROR_OF[name]) for k in rows]
    if None in errors:
        return None
    values = [cast("float", table.columns()[name][k]) for k in rows]
    low, high = ([v * (1.0 + sign * 0.01 * e) for v, e in zip(values, errors, strict=True)] for sign in (-1.0, 1.0))
    return low, high


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
