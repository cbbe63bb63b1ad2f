"""Findings of one printed table, filled entry by entry."""

from __future__ import annotations

from compare.printed.findings import Finding, collect
from compare.printed.printed_data import Printed, load_table


class Entries:
    """Printed rows of a table and our findings for them; an entry without one stays open."""

    def __init__(self, table: str) -> None:
        """Read the table."""
        self.table = table
        self.rows: dict[str, Printed] = {row.key: row for row in load_table(table)}
        self.found: dict[str, Finding] = {}

    def printed(self, key: str) -> float:
        """Printed number of an entry, for arithmetic on printed numbers. Raises KeyError for a claim."""
        value = self.rows[key].value
        if value is None:
            raise KeyError(f"{self.table}: {key} is a claim")
        return value

    def number(self, key: str, right: float | None, as_printed: float | None = None, evidence: str = "") -> None:
        """Our right value, and the one with the source's faults, in the printed unit."""
        self.found[key] = Finding(self.rows[key], right, as_printed, evidence=evidence)

    def numbers(self, values: dict[str, float]) -> None:
        """Right values by key."""
        for key, value in values.items():
            self.number(key, value)

    def claim(self, key: str, holds: bool, evidence: str) -> None:
        """Whether a claim holds."""
        self.found[key] = Finding(self.rows[key], holds=holds, evidence=evidence)

    def all(self) -> list[Finding]:
        """Every entry of the table in its order."""
        return collect(self.table, self.found)
