"""Processor time of cold set-ups, and what cheaper ones would change, as ``tests/set_up_costs.py`` measured it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

#: File of a store that holds them.
FILE = "set_up_costs.json"


@dataclass(frozen=True)
class Job:
    """A cold job in one process of one thread: scene, mesh level, contacts with load; processor time [s] of every stage by
    kind of work: "all", and of it "meshing", "assembly", "elimination" and of that "dense", the dense algebra alone."""

    scene: str
    level: int
    contacts: int
    stages: Mapping[str, Mapping[str, float]]

    def of(self, kind: str) -> float:
        """Seconds of a kind of work in all stages."""
        return sum(stage.get(kind, 0.0) for stage in self.stages.values())


@dataclass(frozen=True)
class Way:
    """A cheaper set-up of a scene on level 1: processor time saved [s], largest change of a load [% of the mean load]."""

    scene: str
    way: str
    saved: float
    moved: float


@dataclass(frozen=True)
class Costs:
    """What was measured, on a machine and day."""

    machine: str
    date: str
    jobs: Sequence[Job]
    ways: Sequence[Way]


def load(stores: Sequence[Path]) -> Costs | None:
    """Costs of the first store that has any; None without a valid file."""
    for store in stores:
        try:
            data = json.loads((store / FILE).read_text(encoding="utf-8"))
            jobs, ways = [Job(**row) for row in data["jobs"]], [Way(**row) for row in data["ways"]]
            return Costs(str(data["machine"]), str(data["date"]), jobs, ways)
        except (OSError, ValueError, KeyError, TypeError):
            continue
    return None
