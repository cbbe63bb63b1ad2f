"""What is measured once and kept in a store, so that a report need not start every process again: run times of the
low-order models, processor time of cold set-ups (as ``tests/set_up_costs.py`` measured it), and what each release reached.

A timed report of a version that has no row among the releases yet adds it to its store. Rows of releases before that were
read off the reports that these releases shipped; what they did not measure, or measured otherwise, is said or left empty.
"""

from __future__ import annotations

import datetime
import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeVar

from rollbench.comparison.wings.bench.costs.assembly_bench import AssemblyCost
from rollbench.comparison.wings.bench.costs.cold import Cold, ColdLevel, measure
from rollbench.comparison.writing import replace_file

#: Files of a store.
RUN_TIMES, SET_UP_COSTS, HISTORY = "run_times.json", "set_up_costs.json", "history.json"
#: Quantities of a release by key, with their units; None where a release has no number.
QUANTITIES = {
    "error": "largest error / % of the mean load",
    "u": "grid uncertainty / % of the mean load",
    "cold": "run time, cold / s",
    "memory": "peak memory / MB",
}
#: What numbers are kept of: models, and the reference on its finest level.
NAMES = ("refined", "lin", "mei", "3D reference")

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
    """Times of one machine and day: ``times`` by scene and model, ``first``: a first process by model and engine,
    ``levels`` of the 3D reference, cold, ``assembly``: ways to its stiffness (none where they were not measured)."""

    machine: str
    date: str
    times: Mapping[tuple[str, str], RunTime]
    first: Mapping[tuple[str, str], Cold]
    levels: Sequence[ColdLevel] = ()
    assembly: Sequence[AssemblyCost] = ()


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
    """Costs of set-ups, measured on a machine and day."""

    machine: str
    date: str
    jobs: Sequence[SetUp]
    ways: Sequence[Way]


@dataclass(frozen=True)
class Release:
    """A release: version, day, commit, numbers by quantity and name, and what is to be known of them."""

    version: str
    date: str
    commit: str
    values: Mapping[str, Mapping[str, float | None]]
    remark: str = ""


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
        "assembly": [asdict(c) for c in kept.assembly],
    }
    head = f'"machine": {json.dumps(kept.machine)}, "date": {json.dumps(kept.date)}'
    body = ", ".join(f'"{name}": [\n {_lines(rows)}]' for name, rows in lists.items())
    replace_file(store / RUN_TIMES, f"{{{head}, {body}}}\n")


def load_times(stores: Sequence[Path]) -> Kept | None:
    """Times of the first store that has any; None without a valid file."""

    def made(data: dict[str, Any]) -> Kept:
        times = {(r["scene"], r["model"]): RunTime(r["cold"], r["warm"], r["memory"]) for r in data["times"]}
        first = {(r.pop("model"), r["engine"]): Cold(**r) for r in data["first"]}
        levels = tuple(ColdLevel(**r) for r in data.get("levels", []))
        assembly = tuple(AssemblyCost(**r) for r in data.get("assembly", []))
        return Kept(data["machine"], data["date"], times, first, levels, assembly)

    return first_kept(stores, RUN_TIMES, made)


def live(scene: str, models: Sequence[str], kept: Kept) -> str:
    """A sentence: cold times of some models on a scene measured now beside the kept ones."""
    known = {model: kept.times[scene, model].cold for model in models if (scene, model) in kept.times}
    words = [f"{m} {measure(scene, m, repeats=1).process:.2f} s (kept: {cold:.2f} s)" for m, cold in known.items()]
    return f"measured again for this report on {scene}: {', '.join(words)}"


def load_costs(stores: Sequence[Path]) -> Costs | None:
    """Costs of the first store that has any; None without a valid file."""

    def made(data: dict[str, Any]) -> Costs:
        jobs, ways = [SetUp(**row) for row in data["jobs"]], [Way(**row) for row in data["ways"]]
        return Costs(data["machine"], data["date"], jobs, ways)

    return first_kept(stores, SET_UP_COSTS, made)


def load_releases(stores: Sequence[Path]) -> tuple[Release, ...]:
    """Releases of the first store that has any, oldest first; none without a valid file."""
    return first_kept(stores, HISTORY, lambda rows: tuple(Release(**row) for row in rows)) or ()


def added(known: Sequence[Release], new: Release) -> tuple[Release, ...]:
    """The releases with a new one at the end, unless there is one of its version: a release is not rewritten."""
    return tuple(known) if any(one.version == new.version for one in known) else (*known, new)
