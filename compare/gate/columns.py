"""Columns of a table of contacts: what a heading names, and its unit."""

from __future__ import annotations

from typing import NamedTuple

from rollbench.comparison.scenes.units import COMMON, UnitError, parse, tidy

#: Words of a row.
WORDS = ("ball", "flank", "case", "set")
#: Numbers of a row by the name that headings have for them: the name here, and its dimension; none goes without unit.
NAMES = {
    "contact_angle": ("angle", "angle"),
    "contact_load": ("load", "force"),
    "peak_pressure": ("pressure", "pressure"),
    "uncertainty": ("uncertainty", "force"),
    "approach": ("approach", "length"),
    "pressure": ("pressure", "pressure"),
    "azimuth": ("azimuth", "angle"),
    "angle": ("angle", "angle"),
    "force": ("load", "force"),
    "load": ("load", "force"),
    "z": ("z", "length"),
}
#: Units as they are spelt in headings without capitals; ``mn`` may mean two.
FOLDED = {unit.lower(): unit for unit in COMMON if unit != "MN"}


class Column(NamedTuple):
    """What a heading names, as `WORDS` and `NAMES` have it, or ``uncertain share``, of a load (empty: nothing known, or no
    unit that fits), and the factor of its numbers to SI."""

    name: str
    factor: float = 1.0


def column(head: str) -> Column:
    """What a heading names: ``newton`` or any unit of force is the load, others are a name with its unit.

    >>> column("approach_um"), column("Contact angle [deg]").name, column("load / kN"), column("note")
    (Column(name='approach', factor=1e-06), 'angle', Column(name='load', factor=1000.0), Column(name='', factor=1.0))
    """
    text = head.strip()
    plain = text.lower().replace(" ", "_")
    if plain in WORDS:
        return Column(plain)
    for start, (name, dimension) in NAMES.items():
        if plain.startswith(start):
            return _with_unit(name, text[len(start) :], dimension)
    return _with_unit("load", text, "force")


def _with_unit(name: str, text: str, dimension: str) -> Column:
    unit = tidy(text.strip(" _[]()/"))
    if name == "uncertainty" and unit in ("%", "percent"):
        return Column("uncertain share", 0.01)
    try:
        return Column(name, parse(f"1 {FOLDED.get(unit.lower(), unit)}", dimension))
    except UnitError:
        return Column("")
