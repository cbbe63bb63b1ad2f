"""One thing that a page or a report rests on, as it was and as it is."""

from __future__ import annotations

from dataclasses import dataclass

from rollbench.comparison.errors import escaped


@dataclass(frozen=True)
class Checked:
    """One thing that a page rests on: ``state`` is ok, changed, missing, or added."""

    name: str
    state: str
    stated: str
    found: str

    @property
    def line(self) -> str:
        """For the terminal."""
        return f"{self.state:8} {escaped(self.name)} {escaped(self.stated[:16])}" + (
            f", now {self.found[:16]}" if self.found else ""
        )
