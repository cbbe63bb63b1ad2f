"""Results that are a record of named values."""

from __future__ import annotations

from dataclasses import dataclass

from rollbench.compare.results.base import JSON, Record, with_schema


@dataclass(frozen=True)
class Data(Record):
    """A result as the JSON that its command prints. values: without the version; shown: path of what tables show ("": all);
    notes: sentences below tables."""

    values: dict[str, JSON]
    shown: str = ""
    notes: tuple[str, ...] = ()

    def __getitem__(self, path: str) -> JSON:
        """The value at a path of keys, such as ``"torque.friction_torque_Nmm"``. Raises KeyError with the keys that there
        are."""
        return self._at(path)

    def to_dict(self) -> dict[str, JSON]:
        """The values, with the version of their keys first."""
        return with_schema(self.values)

    @property
    def _shown(self) -> str:
        return self.shown

    @property
    def _notes(self) -> tuple[str, ...]:
        return self.notes


@dataclass(frozen=True)
class Friction(Data):
    """Friction of a scene: torques, efficiencies, losses."""

    @property
    def converged(self) -> bool:
        """Whether loads and friction balance; ``status`` of the values says what happened if not."""
        return bool(self.values["converged"])
