"""Run times of the low-order models as measured once and kept, so that a report need not start every process anew."""

from __future__ import annotations

import datetime
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from rollbench.comparison.wings.bench.costs.assembly_bench import AssemblyCost
from rollbench.comparison.wings.bench.costs.cold import Cold, ColdLevel, measure
from rollbench.comparison.writing import replace_file

#: File of a store that holds them.
FILE = "run_times.json"


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


def today() -> str:
    """The day, in words."""
    return datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")


def save(store: Path, kept: Kept) -> None:
    """Write times into a store. Raises InputError where it cannot be written."""
    times = [{"scene": scene, "model": model, **asdict(t)} for (scene, model), t in sorted(kept.times.items())]
    first = [{"model": model, **asdict(c)} for (model, _), c in sorted(kept.first.items())]
    others = {name: [asdict(c) for c in costs] for name, costs in (("levels", kept.levels), ("assembly", kept.assembly))}
    lists = {"times": times, "first": first, **others}
    rows = {name: ",\n ".join(json.dumps(row) for row in listed) for name, listed in lists.items()}
    head = f'"machine": {json.dumps(kept.machine)}, "date": {json.dumps(kept.date)}'
    body = ", ".join(f'"{name}": [\n {text}]' for name, text in rows.items())
    replace_file(store / FILE, f"{{{head}, {body}}}\n")


def load(stores: Sequence[Path]) -> Kept | None:
    """Times of the first store that has any; None without a valid file."""
    for store in stores:
        try:
            data = json.loads((store / FILE).read_text(encoding="utf-8"))
            times = {(r["scene"], r["model"]): RunTime(r["cold"], r["warm"], r["memory"]) for r in data["times"]}
            first = {(r.pop("model"), r["engine"]): Cold(**r) for r in data["first"]}
            levels = tuple(ColdLevel(**r) for r in data.get("levels", []))
            assembly = tuple(AssemblyCost(**r) for r in data.get("assembly", []))
            return Kept(str(data["machine"]), str(data["date"]), times, first, levels, assembly)
        except (OSError, ValueError, KeyError, TypeError):
            continue
    return None


def live(scene: str, models: Sequence[str], kept: Kept) -> str:
    """A sentence: cold times of some models on a scene measured now beside the kept ones."""
    words = []
    for model in models:
        known = kept.times.get((scene, model))
        if known is not None:
            words.append(f"{model} {measure(scene, model, repeats=1).process:.2f} s (kept: {known.cold:.2f} s)")
    return f"measured anew for this report on {scene}: {', '.join(words)}"
