"""What is measured once and kept in a store, so that a report need not start every process again: the times of one
measuring run, and processor time of cold set-ups (as ``tests/set_up_costs.py`` measured it)."""

from __future__ import annotations

import datetime
import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeVar

from rollbench.compare.files import replace_file
from rollbench.compare.reference.measured import Measured, here
from rollbench.compare.studies.run_times.cold import Cold, ColdLevel

#: Files of a store.
RUN_TIMES, SET_UP_COSTS = "run_times.json", "set_up_costs.json"

T = TypeVar("T")


@dataclass(frozen=True)
class RunTime:
    """A model on a scene: seconds of a new process with empty caches up to its first solve, seconds of a further solve
    (compiled), peak memory [MB] of that process (None: not measured)."""

    cold: float
    warm: float
    memory: float | None


@dataclass(frozen=True)
class Kept:
    """Times of one measuring run, what it was measured with, and its day: ``times`` by scene and model, ``first``: a first
    process by model and engine, ``levels`` of the 3D reference, cold."""

    measured: Measured
    date: str
    times: Mapping[tuple[str, str], RunTime]
    first: Mapping[tuple[str, str], Cold]
    levels: Sequence[ColdLevel] = ()

    def __str__(self) -> str:
        """What it was measured with, in words."""
        older = "" if self.measured == here() else f", not with the {here().version} of this report"
        return f"Run times are of one measuring run: measured with {self.measured}, {self.date}{older}."


@dataclass(frozen=True)
class SetUp:
    """A cold set-up in one process of one thread: scene, mesh level, contacts with load; processor time [s] of every stage
    by kind of work: "all", and of it "meshing", "assembly", "elimination" and of that "dense", the dense algebra alone."""

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
    """Costs of set-ups, measured on a machine and day with a version of this program."""

    machine: str
    date: str
    jobs: Sequence[SetUp]
    ways: Sequence[Way]
    version: str = ""


def today() -> str:
    """The day, in words."""
    return datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")


def first_kept(stores: Sequence[Path], file: str, made: Callable[[Any], T]) -> T | None:
    """What the first store with a valid file of that name holds, as it is made of the JSON value; None without any."""
    for store in stores:
        with suppress(OSError, ValueError, KeyError, TypeError):
            return made(json.loads((store / file).read_text(encoding="utf-8")))
    return None


def save_rows(store: Path, file: str, records: Sequence[Any]) -> None:
    """Write records into a file of a store, a line each. Raises InputError where it cannot be written."""
    replace_file(store / file, f"[{_lines([asdict(one) for one in records])}]\n")


def _lines(rows: Sequence[Any]) -> str:
    """JSON of rows, a row a line."""
    return ",\n ".join(json.dumps(row) for row in rows)


def save_times(store: Path, kept: Kept) -> None:
    """Write times into a store. Raises InputError where it cannot be written."""
    lists = {
        "times": [{"scene": scene, "model": model, **asdict(t)} for (scene, model), t in sorted(kept.times.items())],
        "first": [{"model": model, **asdict(c)} for (model, _), c in sorted(kept.first.items())],
        "levels": [asdict(c) for c in kept.levels],
    }
    head = ", ".join(f'"{k}": {json.dumps(v)}' for k, v in {**asdict(kept.measured), "date": kept.date}.items())
    body = ", ".join(f'"{name}": [\n {_lines(rows)}]' for name, rows in lists.items())
    replace_file(store / RUN_TIMES, f"{{{head}, {body}}}\n")


def load_times(stores: Sequence[Path]) -> Kept | None:
    """Times of the first store that has any; None without a valid file."""

    def made(data: dict[str, Any]) -> Kept:
        times = {(r["scene"], r["model"]): RunTime(r["cold"], r["warm"], r["memory"]) for r in data["times"]}
        first = {(r.pop("model"), r["engine"]): Cold(**r) for r in data["first"]}
        levels = tuple(ColdLevel(**r) for r in data.get("levels", []))
        measured = Measured(data.get("version", ""), data.get("sources", ""), data["machine"])
        return Kept(measured, data["date"], times, first, levels)

    return first_kept(stores, RUN_TIMES, made)


def load_costs(stores: Sequence[Path]) -> Costs | None:
    """Costs of the first store that has any; None without a valid file."""

    def made(data: dict[str, Any]) -> Costs:
        jobs, ways = [SetUp(**row) for row in data["jobs"]], [Way(**row) for row in data["ways"]]
        return Costs(data["machine"], data["date"], jobs, ways, data.get("version", ""))

    return first_kept(stores, SET_UP_COSTS, made)
