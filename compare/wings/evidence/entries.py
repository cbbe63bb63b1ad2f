"""Evidence of one printed table, with its printed numbers at hand."""

from __future__ import annotations

from rollbench.comparison.printed.printed_data import load_table
from rollbench.comparison.wings.evidence.record import Sheet


class Entries(Sheet):
    """A sheet that also reads printed numbers, for arithmetic on them."""

    def printed(self, key: str) -> float:
        """Printed number of an entry. Raises KeyError for a claim or an unknown key."""
        value = next((row.value for row in load_table(self.table) if row.key == key), None)
        if value is None:
            raise KeyError(f"{self.table}: {key} is a claim or no entry")
        return value

    def numbers(self, values: dict[str, float]) -> None:
        """File right values by key."""
        for key, value in values.items():
            self.number(key, value)
