"""Tables of a scene's stiffness, preload and life (``rollbench table``) as files for other programs.

Formats are CSV, JSON, Parquet, netCDF, a figure, a module for ROSS and a table file for Modelica. ROSS takes five of the 36
terms of the tangent stiffness, a Modelica CombiTable all of them. The files for ROSS and Modelica hold constant values
without damping for each combination of the keys' values.
"""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.errors import ArgumentError, InputError, one_line
from rollbench.compare.files import replace_file, replaced_file, write_csv
from rollbench.compare.quantities import count_with_noun, fields_from_json
from rollbench.compare.results.table import FORCE_UNITS, FREEDOM_UNITS, Over, Table, TableRow, parameter_values_text
from rollbench.compare.scenes.scene_file import read_scene_text
from rollbench.meshes.arrays import Array
from rollbench.meshes.libraries import pip_command, reason_of_failed_import
from rollbench.meshes.parts import FREEDOMS

#: File formats by suffix, with the package that each needs.
FORMATS = {".csv": "", ".json": "", ".parquet": "pyarrow", ".nc": "xarray"}

#: Terms of the tangent stiffness that a BearingElement of ROSS takes: name, row and column.
ROSS_TERMS = {"kxx": (0, 0), "kxy": (0, 1), "kyx": (1, 0), "kyy": (1, 1), "kzz": (2, 2)}
#: Remark on the terms that ROSS leaves out.
ROSS_DROPS = (
    "A BearingElement of ROSS (2.3.0) takes 5 of the 36 terms, kxx, kxy, kyx, kyy and kzz, and drops 31: K_ux_uz, K_uy_uz, "
    "K_uz_ux and K_uz_uy, which couple axial with radial displacement, and all 27 with rx, ry or rz: tilting and torsional "
    "stiffness, and what couples rotations with displacements. kzz is K_uz_uz, the axial stiffness with the other five "
    "freedoms held."
)
#: What the axial stiffnesses are that stand in the comment beside each row.
ROSS_POINTS = (
    "Beside each place: axial tangent in N/um of the nut or bearing, which excludes the shaft as a bearing of ROSS does, "
    "and of the load's point to ground, which contains shaft and supports; both for a change of the scene's own load."
)


def check_file_format(path: Path) -> None:
    """Raise InputError if the file name has an unknown ending, or one whose Python package is missing."""
    if path.suffix not in FORMATS:
        raise ArgumentError("out", str(path), f"a name ending in {', '.join(FORMATS)}", "choose one of these endings")
    package = FORMATS[path.suffix]
    if package and (reason := reason_of_failed_import(package)):
        raise ArgumentError("out", str(path), f"a name ending in .csv or .json, because {reason}", pip_command(package))


def write_table_file(path: Path, table: Table) -> None:
    """Write a table to a file in the format that the ending of its name states; raises InputError if that fails."""
    columns = table.columns()
    if path.suffix == ".csv":
        rows = zip(*columns.values(), strict=True)
        write_csv(path, [dict(zip(columns, row, strict=True)) for row in rows])
    elif path.suffix == ".json":
        replace_file(path, json.dumps(table.to_dict(), indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    elif path.suffix == ".parquet":
        import pyarrow
        import pyarrow.parquet

        plain, units = pyarrow.table(columns), table.units()
        fields = [field.with_metadata({"unit": units[field.name]} if field.name in units else {}) for field in plain.schema]
        attrs = json.dumps({"scene": table.scene, "model": table.model, "units": units}, ensure_ascii=False)
        schema = pyarrow.schema(fields, {"PANDAS_ATTRS": attrs})  # pandas reads it as the attrs of the frame
        with replaced_file(path) as name:
            pyarrow.parquet.write_table(plain.cast(schema), name)
    else:
        with replaced_file(path) as name:
            _netcdf_dataset(table, columns).to_netcdf(name, engine="scipy")


def _netcdf_dataset(table: Table, columns: dict[str, list[Any]]) -> Any:
    """Return a table as an xarray Dataset with a dimension for each varied key, and two for the 6 x 6 stiffness matrix.

    ``columns``: values of each column by its name.
    """
    import xarray

    dims = [x.column for x in table.over]
    shape = [len(x.values) for x in table.over]
    data: dict[str, Any] = {}
    units = {name: {"units": unit} for name, unit in table.units().items()}
    for name, column in columns.items():
        if name not in dims and not name.startswith("K_"):
            words = any(isinstance(x, str) for x in column)
            values = np.array([x or "" for x in column]) if words else np.array(column, dtype=float)
            data[name] = (dims, values.reshape(shape), units.get(name))
    if any(name.startswith("K_") for name in columns):
        of_term = {"units": "N, m, rad", "comment": "the unit of a term is its force_unit / freedom_unit"}
        data["stiffness"] = ([*dims, "force", "freedom"], table.stiffness.reshape(*shape, 6, 6), of_term)
    coords: dict[str, Any] = {x.column: (x.column, list(x.values), units.get(x.column)) for x in table.over}
    coords |= {"force": list(FREEDOMS), "force_unit": ("force", list(FORCE_UNITS))}
    coords |= {"freedom": list(FREEDOMS), "freedom_unit": ("freedom", list(FREEDOM_UNITS))}
    return xarray.Dataset(data, coords, {"scene": table.scene, "model": table.model})


def _table_from_json(data: Mapping[str, Any]) -> Table:
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
        scene=data["scene"],
        model=data["model"],
        quantities=tuple(data["quantities"]),
        stiffness_of=data["stiffness_of"],
        station=None if data["station_mm"] is None else data["station_mm"] / 1e3,
        over=tuple(Over(x["key"], x["column"], tuple(x["values"])) for x in data["over"]),
        rows=tuple(x if x.stiffness is None else replace(x, stiffness=np.array(x.stiffness, dtype=float)) for x in rows),
    )


def read_table_file(path: str) -> Table:
    """Read a table from a JSON file that ``rollbench table`` wrote; InputError for another file."""
    text = read_scene_text(path)
    try:
        return _table_from_json(json.loads(text))
    except (KeyError, TypeError, ValueError, AttributeError):
        allowed = "a JSON file that rollbench table wrote"
        raise InputError(path, "file", "other content", allowed, "write the table by --out FILE.json") from None


def ross_module_text(table: Table) -> str:
    """Return the text of a Python module for the rotor-dynamics program ROSS, with the stiffness of each table row.

    The module holds the stiffness as the list ``PLACES``, and a function ``bearing(n, place)`` that returns a
    BearingElement of ROSS. Raises InputError if no row has a stiffness.
    """
    matrices = table.stiffness
    kept = [k for k, matrix in enumerate(matrices) if all(np.isfinite(matrix[at]) for at in ROSS_TERMS.values())]
    if not kept:
        advice = "make the table with the quantity stiffness, at an axial position where no support fixes ux, uy or uz"
        raise InputError(
            table.scene, "stiffness", "no stiffness", "a file for ROSS needs a stiffness in at least one row", advice
        )
    places, lines, columns = table.places, [], table.columns()
    for k in kept:
        terms = {name: float(f"{matrices[k][at]:.9e}") for name, at in ROSS_TERMS.items()}
        of_row = {
            name: columns[name][k] for name in ("nut_tangent_N_per_um", "load_point_tangent_N_per_um") if name in columns
        }
        lines.append(f"    ({parameter_values_text(table.over, places[k])!r}, {terms!r}),  # {of_row}")
    head = [
        f"Stiffness of {table.scene} by rollbench (model {table.model}) for ROSS, in N/m; z is the axis of rotation.",
        f"The stiffness is that of: {table.stiffness_of}.",
        *textwrap.wrap(ROSS_POINTS, 100),
        *textwrap.wrap(ROSS_DROPS, 100),
        "Damping is not known here: give cxx and others to `bearing`.",
        *(f"left out: {line}" for line in _reasons_for_missing_results(table)),
    ]
    return f'''{_comment_lines(head)}

import ross

PLACES = [
{chr(10).join(lines)}
]


def bearing(n, place, cxx=0.0, **others):
    """The bearing at node n with the stiffness of PLACES[place]."""
    return ross.BearingElement(n=n, cxx=cxx, **PLACES[place][1], **others)
'''


def _reasons_for_missing_results(table: Table) -> list[str]:
    """Return a line for each reason why rows of a table have no result, with the varied keys' values in these rows."""
    return [f"{'; '.join(places)}: {reason}" for reason, places in table.failures.items()]


def _comment_lines(lines: Iterable[str]) -> str:
    """Return lines of text as comment lines ("# ...") of a Python module or a Modelica table file."""
    return "\n".join(f"# {one_line(line, 10_000)}" for line in lines)


def modelica_table_text(table: Table) -> tuple[str, list[str]]:
    """Return a table as the text of a file for Modelica.Blocks.Tables, then sentences on what the file leaves out.

    Raises InputError unless the table has one or two varied keys with numbers, at least two rows with a result, and a
    column with a number in each of these rows.
    """
    axes = [x.numbers for x in table.over]
    if not 1 <= len(axes) <= 2 or any(x is None or len(x) < 2 for x in axes):
        allowed = "a table in which one or two keys of the scene vary, each with at least two numeric values"
        advice = "make a table over one or two numeric keys"
        raise InputError(table.scene, "over", count_with_noun(len(axes), "key"), allowed, advice)
    kept = [k for k, row in enumerate(table.rows) if row.converged]
    if len(axes) == 2 and len(kept) < len(table.rows):
        reason, places = next(iter(table.failures.items()))
        advice = "make the table without these values, as a CombiTable2D must have a number in each cell"
        raise InputError(table.scene, places[0], reason, "a result in each row", advice)
    grid = [np.array(x, dtype=float) for x in axes]
    rows = {name: [column[k] for k in kept] for name, column in table.columns().items()}
    left = _reasons_for_missing_results(table)
    columns: dict[str, Array] = {}
    for name, column in rows.items():
        if name in table.places[0] or any(isinstance(x, str) for x in column):
            continue
        if None in column:
            left.append(f"{name}: no number in {count_with_noun(column.count(None), 'row')} with a result")
        else:
            columns[name] = np.array(column, dtype=float)
    if len(kept) < 2 or not columns:
        got = f"{count_with_noun(len(kept), 'row')} with a result, {count_with_noun(len(columns), 'column')} of numbers"
        allowed = "a table for Modelica needs at least two rows with a result, and one column with a number in each of them"
        advice = f"choose other values or quantities; left out of the table: {'; '.join(left) or 'columns of text'}"
        raise InputError(table.scene, "rows", got, allowed, advice)
    head = [
        f"{table.scene} by rollbench, model {table.model}; over {', '.join(x.column for x in table.over)}",
        f"stiffness K_force_freedom in N, m, rad, of: {table.stiffness_of}",
        *(f"left out: {line}" for line in left),
    ]
    if len(grid) == 1:
        head += [f"column {k}: {name}" for k, name in enumerate((table.over[0].column, *columns), 1)]
        whole = np.column_stack([grid[0][kept], *columns.values()])
        blocks = [_modelica_matrix_text("table", whole[np.argsort(whole[:, 0])])]
    else:
        order, shape, blocks = [np.argsort(x) for x in grid], [len(x) for x in grid], []
        for name, values in columns.items():
            inner = np.column_stack([grid[0][order[0]], values.reshape(shape)[np.ix_(*order)]])
            blocks.append(_modelica_matrix_text(name, np.vstack([[0.0, *grid[1][order[1]]], inner])))
    return f"#1\n{_comment_lines(head)}\n{''.join(blocks)}", left


def _modelica_matrix_text(name: str, values: Array) -> str:
    """Return a matrix as text in the format of a Modelica table file.

    ``name``: name of the matrix in the file; ``values``: the matrix, of any two dimensions.
    """
    rows: Sequence[str] = ["  ".join(f"{x:.9e}" for x in row) for row in values]
    return f"double {name}({values.shape[0]},{values.shape[1]})\n" + "\n".join(rows) + "\n"
