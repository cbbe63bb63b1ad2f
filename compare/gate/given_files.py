"""Reads users' CSV files with values of the whole screw that the gate judges, such as rigidity or life."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rollbench.compare.errors import InputError
from rollbench.compare.gate.judged import DISPLACEMENT, LIFE, OF_WHOLE, RIGIDITY, TORQUE, JudgedQuantity
from rollbench.compare.models.loads_file import CsvTable, decimal_comma_advice
from rollbench.meshes.units import UnitError, dimension_words, parse_quantity

VALUE_COLUMNS = ("quantity", "value", "unit")

WHERE = "where"

VALUE_EXAMPLE = "begin with the line quantity,value,unit,where and add rows such as rigidity,540,N/um,5 kN"

DIMENSIONS = {DISPLACEMENT: "length", RIGIDITY: "stiffness", TORQUE: "moment"}

#: Accepted units of life, each with its size in million revolutions.
LIVES = {"million revolutions": 1.0, "1e6 revolutions": 1.0, "revolutions": 1e-6}


@dataclass(frozen=True)
class GivenValue:
    """Value of one quantity of the whole screw (such as rigidity or life) from a user's file."""

    #: Quantity that the value belongs to.
    quantity: JudgedQuantity
    #: Value in SI units; a life in million revolutions.
    value: float
    #: Axial load at which the value applies [N]; None: the loads of the scene.
    force: float | None = None
    #: Axial position of a displacement [m]; None: the nut's centre.
    station: float | None = None
    #: Load or position as written in the file.
    where: str = ""
    #: Number or name of the set of balls on the shaft, as written in the file.
    set: str = ""

    @property
    def name(self) -> str:
        """Name of the quantity, with the load or position at which the value applies."""
        return self.quantity.name + (f" at {self.where}" if self.where else "")


def read_values(path: Path, case: str | None = None) -> tuple[list[GivenValue], tuple[str, ...]]:
    """Read from a CSV file the values of the whole screw that the gate judges.

    Parameters
    ----------
    path
        Path of the file, with the columns quantity, value and unit, and optionally where, set and case.
    case
        Load case whose rows are read, as named in the column ``case``; None: all rows.

    Returns
    -------
    list of GivenValue
        Values in the order of the rows.
    tuple of str
        Column headings of the file that are not known.

    Raises
    ------
    InputError
        If the file cannot be read, a value or unit is not valid, or a value is stated twice.
    """
    needed = (*VALUE_COLUMNS, *(("case",) if case else ()))
    optional = (WHERE, "set")
    table = CsvTable.from_csv(path, needed, VALUE_EXAMPLE, optional)
    out: dict[tuple[str, ...], GivenValue] = {}
    for number, cells in table.rows:
        if case is not None and cells.get("case") != case:
            continue
        given = _value_in_row(path, f"line {number}", cells, decimal_comma=table.decimal_comma)
        key = (given.name, given.set)
        if key in out:
            allowed = "each quantity once, at each load or position"
            raise InputError(str(path), f"line {number}", f"{given.name} again", allowed, "delete one of the rows")
        out[key] = given
    if not out and case is None:
        raise InputError(str(path), "file", "no values", "a row for each value", VALUE_EXAMPLE)
    return list(out.values()), tuple(f'"{title}"' for title in table.titles if title.lower() not in (*needed, *optional))


def _value_in_row(path: Path, line: str, cells: dict[str, str], *, decimal_comma: bool) -> GivenValue:
    """Return the value in one row of a user's file; InputError if quantity, number, unit, load or position is invalid."""
    name, number, unit = (cells.get(column, "") for column in VALUE_COLUMNS)
    quantity = next((q for q in OF_WHOLE if q.name == name.lower()), None)
    if quantity is None:
        allowed = ", ".join(q.name for q in OF_WHOLE)
        advice = "choose one of these quantities; put values of single contacts into the file of `loads`"
        raise InputError(str(path), f"{line}: quantity", name or "nothing", allowed, advice)
    text = f"{number.replace(',', '.') if decimal_comma else number} {unit}"
    try:
        value = (
            _life_in_revolutions(text.split(" ")[0], unit)
            if quantity is LIFE
            else parse_quantity(text, DIMENSIONS[quantity])
        )
    except UnitError as error:
        allowed, advice = dimension_words(DIMENSIONS[quantity]), decimal_comma_advice(error.advice, f"{number},{unit}")
        raise InputError(str(path), f"{line}: value, unit", text.strip() or "nothing", allowed, advice) from None
    except ValueError:
        allowed, advice = f"a number and one of: {', '.join(LIVES)}", decimal_comma_advice(VALUE_EXAMPLE, text)
        raise InputError(str(path), f"{line}: value, unit", text.strip() or "nothing", allowed, advice) from None
    where = cells.get(WHERE, "")
    force, station = (_number_in_si(where.replace(",", ".") if decimal_comma else where, of) for of in ("force", "length"))
    if where and force is None and (station is None or quantity is not DISPLACEMENT):
        position = ", or an axial position such as 400 mm" if quantity is DISPLACEMENT else ""
        allowed = f"an axial load such as 5 kN{position}"
        advice = decimal_comma_advice("leave it empty for the loads of the scene", where)
        raise InputError(str(path), f"{line}: {WHERE}", where, allowed, advice)
    return GivenValue(quantity, value, force, station, where, cells.get("set", ""))


def _life_in_revolutions(number: str, unit: str) -> float:
    """Return a life, written as a number and a unit, in million revolutions; ValueError if either is not valid."""
    value = float(number) * LIVES.get(unit.lower(), float("nan"))
    if not 0.0 < value < float("inf"):
        raise ValueError(unit)
    return value


def _number_in_si(where: str, dimension: str) -> float | None:
    """Parse a load or length such as ``5 kN`` and return it in SI units; None if its unit is not of the dimension.

    Loads that are not positive also give None.
    """
    try:
        value = parse_quantity(where, dimension)
    except UnitError:
        return None
    return value if value > 0.0 or dimension == "length" else None
