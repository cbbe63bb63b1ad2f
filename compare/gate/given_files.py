"""Reading of users' CSV files with values of the whole screw to be judged: quantity, value, unit, place or load."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rollbench.compare.errors import InputError
from rollbench.compare.gate.judged import DISPLACEMENT, LIFE, OF_WHOLE, RIGIDITY, TORQUE, JudgedQuantity
from rollbench.compare.models.loads_file import CsvTable, decimal_comma_advice
from rollbench.meshes.units import UnitError, dimension_words, parse_quantity

VALUE_COLUMNS = ("quantity", "value", "unit")

WHERE = "where"

VALUE_EXAMPLE = "write a first line quantity,value,unit,where and rows such as rigidity,540,N/um,5 kN"

DIMENSIONS = {DISPLACEMENT: "length", RIGIDITY: "stiffness", TORQUE: "moment"}

#: Units of life, in million revolutions.
LIVES = {"million revolutions": 1.0, "1e6 revolutions": 1.0, "revolutions": 1e-6}


@dataclass(frozen=True)
class GivenValue:
    """One value of the whole screw from a user's file."""

    #: The quantity.
    quantity: JudgedQuantity
    #: Value in SI; a life in million revolutions.
    value: float
    #: Axial load at which it applies [N]; None: the loads of the scene.
    force: float | None = None
    #: Axial position of a displacement [m]; None: the nut's centre.
    station: float | None = None
    #: Load or position as written.
    where: str = ""
    #: Set on the shaft, by number or name.
    set: str = ""

    @property
    def name(self) -> str:
        """Name of the quantity, with the load or position at which the value applies."""
        return self.quantity.name + (f" at {self.where}" if self.where else "")


def read_values(path: Path, case: str | None = None) -> tuple[list[GivenValue], tuple[str, ...]]:
    """Read the values to be judged from a CSV file.

    Parameters
    ----------
    path
        The file.
    case
        Load case whose rows are read, by the column case; None: all rows.

    Returns
    -------
    list of GivenValue
        The values.
    tuple of str
        Headings that are not known.

    Raises
    ------
    InputError
        If the file cannot be read, or a value or unit is not valid.
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
            raise InputError(str(path), f"line {number}", f"{given.name} again", "each once", "keep one of the rows")
        out[key] = given
    if not out and case is None:
        raise InputError(str(path), "file", "no values", "a row for every value", VALUE_EXAMPLE)
    return list(out.values()), tuple(f'"{title}"' for title in table.titles if title.lower() not in (*needed, *optional))


def _value_in_row(path: Path, line: str, cells: dict[str, str], *, decimal_comma: bool) -> GivenValue:
    """Return the value in a row of a file; InputError if quantity, number, unit or place is not valid."""
    name, number, unit = (cells.get(column, "") for column in VALUE_COLUMNS)
    quantity = next((q for q in OF_WHOLE if q.name == name.lower()), None)
    if quantity is None:
        allowed = ", ".join(q.name for q in OF_WHOLE)
        raise InputError(str(path), f"{line}: quantity", name or "nothing", allowed, "values of contacts go to `loads`")
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
        allowed = "an axial load, e.g. 5 kN" + (", or a station, e.g. 400 mm" if quantity is DISPLACEMENT else "")
        advice = decimal_comma_advice("leave it empty for the loads of the scene", where)
        raise InputError(str(path), f"{line}: {WHERE}", where, allowed, advice)
    return GivenValue(quantity, value, force, station, where, cells.get("set", ""))


def _life_in_revolutions(number: str, unit: str) -> float:
    """Return a life in million revolutions; ValueError for a number or unit that is not valid."""
    value = float(number) * LIVES.get(unit.lower(), float("nan"))
    if not 0.0 < value < float("inf"):
        raise ValueError(unit)
    return value


def _number_in_si(where: str, dimension: str) -> float | None:
    """Return a text such as ``5 kN`` as a number in SI; None if its unit is not of the dimension."""
    try:
        value = parse_quantity(where, dimension)
    except UnitError:
        return None
    return value if value > 0.0 or dimension == "length" else None
