"""What a user waits for: commands as they are typed, each in a process of its own with warm caches, and where their time
goes; and how time and memory grow with balls and members."""

from __future__ import annotations

import json
import resource
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from time import process_time

import numpy as np
from threadpoolctl import threadpool_limits

from rollbench.comparison.models.registry import Options, run_model
from rollbench.comparison.models.study import Study, with_balls
from rollbench.comparison.reference.store import shipped_store
from rollbench.comparison.scenes.catalogue import scene as shipped
from rollbench.comparison.system import machine
from rollbench.comparison.wings.bench.costs.run_times import today
from rollbench.comparison.wings.bench.costs.timing import Job, launch
from rollbench.comparison.wings.members.members import run_members
from rollbench.comparison.writing import replace_file
from rollbench.lowfi.statics.elastic_system import LARGEST
from rollbench.meshes.kept import made_anew
from rollbench.meshes.memory import peak_MB, reset_peak
from rollbench.reports.records import Figure, Panel, Quantity, Row, Series, Table

BASE = "import numpy, cyclopts, rich.console"
#: Numba finds its own parts only with the first kernel that is run, one kept on disc here.
COMPILED = (
    f"{BASE}; from rollbench.lowfi.jit import STATICS, kernels; kernels(STATICS, compiled=True).contact.hertz(1e-6, 1e-8)"
)


@dataclass(frozen=True)
class Typed:
    """A command as typed: its words; base: code of the floor, which loads the libraries that it cannot do without; module:
    of the package, whose import brings all that the command is made of; aim [s]; runs: least of so many counts."""

    words: str
    base: str
    module: str
    aim: float
    runs: int = 3

    @property
    def job(self) -> str:
        """Name of the row."""
        return f"{self.words}, as typed"


_SOLVE = "commands.solving.solve"
TYPED = (
    Typed("list", BASE, "commands.listing", 0.35),
    Typed("solve lin-case1", BASE, _SOLVE, 0.6),
    Typed("solve lin-case1 --model lin", BASE, _SOLVE, 0.4),
    Typed("friction lin-case1", BASE, "wings.friction.whole", 0.6),
    Typed("solve lin-random --members 100 --model lin", COMPILED, "wings.members.command", 1.0),
    Typed("solve lin-random --members 10000 --model lin", COMPILED, "wings.members.command", 3.0, 2),
    Typed("solve lin-random --members 20", COMPILED, "wings.members.command", 1.0),
    Typed("solve lin-random --members 1000", COMPILED, "wings.members.command", 2.0, 2),
)
#: File of a store that holds time and memory over size.
GROWTH = "growth.json"
#: Numbers of balls and of members over which they are shown, and the most members of a quick look.
BALLS, MEMBERS, FEW = (8, 16, 32, 64, 125, 250, 500, 1000), (10, 100, 1000, 10_000, 100_000), 100


def cpu_seconds(arguments: list[str], runs: int, extra: dict[str, str] | None = None, limit: float = 300.0) -> float | None:
    """Least seconds of a processor that a Python process takes, of some runs; None where one fails. extra: variables of its
    environment; limit: of its wall clock [s]."""
    found = []
    for _ in range(runs):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        plain = {"PYTHONDONTWRITEBYTECODE": ""}  # as a user's, who has nothing there
        done = launch(arguments, {**plain, **(extra or {})}, limit)[1]
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode != 0:
            return None
        found.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(found)


def as_typed(commands: Sequence[Typed] = TYPED) -> Iterator[Job]:
    """Each command as soon as it is measured."""
    for one in commands:
        command = ["-m", "rollbench", *one.words.split()]
        cpu_seconds(command, 1)  # fills the caches
        modules = f"{one.base}; import rollbench.comparison.{one.module}"
        whole, floor, imports = (cpu_seconds(code, one.runs) for code in (command, ["-c", one.base], ["-c", modules]))
        note = "CPU of the whole process, caches warm" if whole is not None else "not measured: the command failed"
        yield Job(one.job, whole, None, None, None, note, one.aim, floor, "its libraries alone", imports)


def spent_table(jobs: Sequence[Job]) -> Table:
    """Where the time of each job with an aim goes, its floor, and by how much it misses."""

    def less(a: float | None, b: float | None) -> float | None:
        return None if a is None or b is None else max(a - b, 0.0)

    rows: list[Row] = [
        {
            "job": one.job,
            Quantity("seconds", "today", "s", "g3"): one.seconds,
            Quantity("aim", "aim", "s", "g3"): one.aim,
            Quantity("misses", "times the aim", "", "g3"): None if one.seconds is None else one.seconds / one.aim,
            Quantity("floor", "floor", "s", "g3"): one.floor,
            Quantity("modules", "modules of rollbench", "s", "g3"): less(one.modules, one.floor),
            Quantity("work", "work", "s", "g3"): less(one.seconds, one.floor if one.modules is None else one.modules),
            "floor_of": one.floor_of,
            "note": one.note,
            "measured": one.when or "now",
        }
        for one in jobs
        if one.aim is not None
    ]
    return Table.of("time-spent", "Where people wait: where the time goes, and its floor", rows)


def _power(x: Sequence[float], y: Sequence[float]) -> float:
    """Exponent of y over x, by the larger half of the places."""
    some = len(x) // 2
    return float(np.polyfit(np.log(x[some:]), np.log(y[some:]), 1)[0])


def by_balls(counts: Sequence[int] = BALLS) -> dict[str, list[tuple[float, float, float]]]:
    """Balls, processor seconds with set-up and MB at the peak of one solve, by model."""
    case = shipped("lin-case1")
    found: dict[str, list[tuple[float, float, float]]] = {"lin": [], "refined": []}
    options = Options(engine="compiled", discretisation=False)
    with threadpool_limits(1, "blas"), made_anew():
        for model, points in found.items():
            for count in (8, 64):  # compiles both ways to solve
                run_model(with_balls(case, count), model, options)
            for count in (n for n in counts if model == "lin" or n <= LARGEST):
                scene = with_balls(case, count)
                reset_peak()
                length = scene.screw.length + 1e-6 * count  # another geometry for every count
                other, begin = replace(scene, screw=replace(scene.screw, length=length)), process_time()
                run_model(other, model, options)
                points.append((float(count), process_time() - begin, peak_MB() or 0.0))
    return found


def by_members(counts: Sequence[int] = MEMBERS) -> dict[str, list[tuple[float, float, float]]]:
    """Members, processor seconds and MB at the peak of an ensemble of `lin-random`, by model."""
    scene = shipped("lin-random")
    found: dict[str, list[tuple[float, float, float]]] = {"lin": [], "refined": []}
    for model, points in found.items():
        run_members(scene, model, 200)
        for count in counts:
            reset_peak()
            begin = process_time()
            run_members(scene, model, count)
            points.append((float(count), process_time() - begin, peak_MB() or 0.0))
    return found


def growth(study: Study) -> tuple[Mapping[str, Mapping[str, Sequence[Sequence[float]]]], str]:
    """Points by what grows and by model, and a sentence on where and when they were measured: those kept, measured anew and
    kept in the first store where the study is timed or none are."""
    if study.quick:
        few = [n for n in MEMBERS if n <= FEW]
        return {"balls": by_balls(BALLS[:4]), "members": by_members(few)}, "Measured for this report."
    for store in () if study.timed else (*(study.stores or ()), shipped_store()):
        with suppress(OSError, ValueError, KeyError):
            kept = json.loads((store / GROWTH).read_text(encoding="utf-8"))
            return kept["points"], f"Kept, of {kept['date']} on {kept['machine']}."
    members = by_members()  # first: what large bodies took stays with the process
    points = {"balls": by_balls(), "members": members}
    if study.stores:
        kept = {"machine": machine(), "date": today(), "points": points}
        replace_file(study.stores[0] / GROWTH, f"{json.dumps(kept, indent=1)}\n")
    return points, "Measured for this report."


def scaling(study: Study) -> tuple[Table, Figure]:
    """Time and memory over balls and members, with the observed exponents of the larger half of the sizes."""
    rows: list[Row] = []
    panels = []
    measured, origin = growth(study)
    for of, found in measured.items():
        for place, unit in ((1, "s"), (2, "MB")):
            series = []
            for model, points in found.items():
                x, y = [p[0] for p in points], [p[place] for p in points]
                series.append(Series(f"{model}: exponent {_power(x, y):.2f}", x, y, "line+markers"))
            panels.append(Panel("", of, f"{'time' if unit == 's' else 'memory'} / {unit}", tuple(series), log="xy"))
        rows += [
            {
                "model": model,
                "over": of,
                Quantity("count", "number", "", ".0f"): p[0],
                Quantity("seconds", "CPU", "s", "g3"): p[1],
                Quantity("peak_MB", "peak memory", "MB", ".0f"): p[2],
            }
            for model, points in found.items()
            for p in points
        ]
    note = f"One solve with its set-up, bodies of a new geometry; ensembles of lin-random with their bands. {origin}"
    return Table.of("scaling", "Time and memory over size", rows), Figure(
        "scaling", "Growth with size", tuple(panels), note
    )
