"""Run times of models, of the 3D reference and of typed commands, measured and kept.

Cold is what somebody waits for who has done nothing yet: a new interpreter, all imports, the set-up of the geometry and
one solve, in a process with empty folders for meshes and for machine code. Compiled kernels are timed cold too, as their
first call compiles. Warm is a further solve in the same process: bodies of the geometry known, kernels compiled.

A store keeps the times of one measuring run, and processor time of cold set-ups (as ``tests/set_up_costs.py`` measured
it), so that a report need not start every process again.
"""

from __future__ import annotations

import datetime
import gc
import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from time import perf_counter, time
from typing import Any, TypeVar

from rollbench.compare.files import replace_file
from rollbench.compare.models.study import Study
from rollbench.compare.reference.store import Measured, here, shipped_store
from rollbench.compare.scenes.catalogue import scene
from rollbench.compare.studies.members.ensemble import run_ensemble
from rollbench.meshes.processes import VARIABLES


@dataclass(frozen=True)
class Job:
    """A timed job: wall clock [s] (None: not measured), a ratio and what it is over (in ``note``), unknowns of one solve,
    peak memory of the process [MB], largest error of a contact load [% of the mean load]."""

    job: str
    seconds: float | None
    ratio: float | None = None
    unknowns: int | None = None
    peak_MB: float | None = None
    error_percent: float | None = None
    note: str = ""


def timed(work: Callable[[], object], repeats: int, reset: Callable[[], object] | None = None) -> float:
    """Median wall clock of ``work`` [s], after one run that is not counted; ``reset`` runs before each, untimed."""
    seconds = []
    gc.collect()
    enabled = gc.isenabled()
    gc.disable()
    try:
        for _ in range(repeats + 1):
            if reset is not None:
                reset()
            begin = perf_counter()
            work()
            seconds.append(perf_counter() - begin)
    finally:
        if enabled:
            gc.enable()
    return median(seconds[1:])


def as_a_users(extra: dict[str, str] | None = None) -> dict[str, str]:
    """Environment of a process that is timed, with further variables: that of a user who has set no number of threads."""
    return {name: value for name, value in os.environ.items() if name not in VARIABLES} | (extra or {})


@dataclass(frozen=True)
class Launched:
    """A process that ended: seconds of wall clock to its end and to its first line (None: it wrote none), CPU seconds of it
    and its own processes, exit code, and what it wrote, as on a terminal."""

    seconds: float
    first_line: float | None
    cpu: float
    code: int
    output: str


def launch(arguments: list[str], extra: dict[str, str] | None = None, folder: str | None = None) -> Launched:
    """Run a Python process, which imports nothing from its working folder, as a user would on a terminal. It is ended
    after `PATIENCE`."""
    environment = as_a_users({"PYTHONUNBUFFERED": "1"} | (extra or {}))
    before, begin = os.times(), perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-P", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=environment,
        cwd=folder,
    )
    patience = threading.Timer(PATIENCE, process.kill)
    patience.start()
    with process:
        assert process.stdout is not None
        line = process.stdout.readline()
        first = perf_counter() - begin if line else None
        written = line + process.stdout.read()
    patience.cancel()
    seconds = perf_counter() - begin
    return Launched(seconds, first, _cpu(before, os.times()), process.returncode, written)


def _cpu(before: os.times_result, after: os.times_result) -> float:
    """CPU seconds of processes that ended in between."""
    return sum(y - x for x, y in zip(before[2:4], after[2:4], strict=True))


#: Longest wait for a process [s].
PATIENCE = 1200.0

#: Solves whose fastest is the warm time.
REPEATS = 5

CHILD = """
import sys
sys.path[:] = {path!r}
from time import perf_counter, time
from pathlib import Path
from rollbench.meshes.processes import one_thread
one_thread()
import json
from rollbench.compare.scenes import catalogue
from rollbench.meshes.processes import peak_MB
from rollbench.compare.models.registry import Options, run_model
ask = json.loads({ask!r})
scene = catalogue.scene(ask["scene"])
path = Path(ask["condensed"]) if ask["condensed"] else None
options = Options(discretisation=False, engine=ask["engine"], condensed=path)
spent = []
for _ in range(1 + ask["repeats"]):
    start = perf_counter()
    result = run_model(scene, ask["model"], options)
    spent.append(perf_counter() - start)
    if len(spent) == 1:
        done, memory = time(), peak_MB()
print(json.dumps({{"done": done, "first": spent[0], "warm": min(spent[1:]), "memory": memory, "status": result.status}}))
"""


#: Any call, after imports that only its first time includes.
CALL_CHILD = """
import sys
sys.path[:] = {path!r}
from time import perf_counter, time
from rollbench.meshes.processes import one_thread, peak_MB
one_thread()
import json
ask = json.loads({ask!r})
space = {{}}
exec(ask["imports"], space)
call = compile(ask["call"], "call", "eval")
spent = []
for _ in range(1 + ask["repeats"]):
    start = perf_counter()
    eval(call, space)
    spent.append(perf_counter() - start)
    if len(spent) == 1:
        done, memory = time(), peak_MB()
print(json.dumps({{"done": done, "warm": min(spent[1:]), "memory": memory}}))
"""


#: A level as `compare` computes it, without a cache to read or a store to write.
LEVEL_CHILD = """
import sys
sys.path[:] = {path!r}
from time import time
from rollbench.meshes.processes import one_thread
one_thread()
import json
from rollbench.compare.reference.computing import compute
from rollbench.compare.reference.tasks import Task
from rollbench.compare.scenes import catalogue
from rollbench.compare.running import cores
ask = json.loads({ask!r})
(run,) = compute(Task((catalogue.scene(ask["scene"]),), ask["level"], processes=cores()))
contacts = int((run.load > 0.0).sum())
own = {{"memory": run.peak_MB, "status": run.status, "contacts": contacts, "load_case": run.solve_seconds}}
print(json.dumps({{"done": time(), "stages": run.stages, **own}}))
"""


@dataclass(frozen=True)
class ColdLevel:
    """A level of the 3D reference, from the start of the interpreter to its loads: seconds, CPU seconds of all processes,
    sum of their peaks of memory [MB] (None: not measured), status; scene, contacts with load, seconds that a further load
    case takes, and those of every stage of the set-up by name (None: not measured)."""

    level: int
    process: float
    cpu: float
    memory: float | None
    status: str
    scene: str = "lin-case1"
    contacts: int | None = None
    load_case: float | None = None
    stages: dict[str, float] | None = None


@dataclass(frozen=True)
class Cold:
    """Seconds of a model on a scene: ``process``, interpreter, imports and the first solve; ``first``, that solve alone;
    ``warm``, the fastest further one; peak memory [MB] of the process (None: not measured); engine; the solve's status."""

    process: float
    first: float
    warm: float
    memory: float | None
    engine: str
    status: str


def measure(
    scene: str, model: str, *, engine: str = "interpreted", condensed: Path | None = None, repeats: int = REPEATS
) -> Cold:
    """Times of a shipped scene in a new process with empty caches. Raises RuntimeError where the process fails."""
    ask = {
        "scene": scene,
        "model": model,
        "engine": engine,
        "repeats": repeats,
        "condensed": str(condensed.resolve()) if condensed else "",
    }
    begin, printed = _alone(CHILD, ask, f"{model} on {scene}")
    return Cold(printed["done"] - begin, printed["first"], printed["warm"], printed["memory"], engine, printed["status"])


def measure_call(imports: str, call: str, what: str, repeats: int = REPEATS) -> RunTime:
    """Times of a call in a new process with empty caches, and of further ones there. Raises RuntimeError where the process
    fails."""
    begin, printed = _alone(CALL_CHILD, {"imports": imports, "call": call, "repeats": repeats}, what)
    return RunTime(printed["done"] - begin, printed["warm"], printed["memory"])


def measure_level(scene: str, level: int) -> ColdLevel:
    """Times of a level of the 3D reference of a shipped scene in a new process with empty caches, on all cores. Raises
    RuntimeError where the process fails."""
    before = os.times()
    begin, printed = _alone(LEVEL_CHILD, {"scene": scene, "level": level}, f"level {level} of {scene}")
    after = os.times()
    cpu = _cpu(before, after)
    known = {name: printed[name] for name in ("contacts", "load_case", "stages")}
    return ColdLevel(level, printed["done"] - begin, cpu, printed["memory"], printed["status"], scene, **known)


def _alone(child: str, ask: dict[str, Any], what: str) -> tuple[float, dict[str, Any]]:
    """Run a new process with empty caches; when it began, and what it printed."""
    with tempfile.TemporaryDirectory() as folder:
        caches = {name: str(Path(folder) / name.lower()) for name in ("ROLLBENCH_CACHE", "NUMBA_CACHE_DIR")}
        for place in caches.values():
            Path(place).mkdir()
        code = child.format(path=[p for p in sys.path if p], ask=json.dumps(ask))
        begin = time()
        process = subprocess.run(
            [sys.executable, "-I", "-c", code],
            capture_output=True,
            text=True,
            check=False,
            timeout=PATIENCE,
            env=as_a_users(caches),
        )
    if process.returncode != 0:
        last = process.stderr.strip().splitlines()[-1:] or ["no message"]
        raise RuntimeError(f"{what}: the timing process failed: {last[0]}")
    return begin, json.loads(process.stdout)


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
    process by model and engine, ``levels`` of the 3D reference, cold, ``typed`` commands."""

    measured: Measured
    date: str
    times: Mapping[tuple[str, str], RunTime]
    first: Mapping[tuple[str, str], Cold]
    levels: Sequence[ColdLevel] = ()
    typed: Sequence[Typed] = ()

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


def file_of(source: str) -> str:
    """File of the times of a case's page, or of those of all compared scenes."""
    return f"run_times_{source}.json" if source else RUN_TIMES


def save_times(store: Path, kept: Kept, source: str = "") -> None:
    """Write times into a store; source: those of a case's page. Raises InputError where it cannot be written."""
    lists = {
        "times": [{"scene": scene, "model": model, **asdict(t)} for (scene, model), t in sorted(kept.times.items())],
        "first": [{"model": model, **asdict(c)} for (model, _), c in sorted(kept.first.items())],
        "levels": [asdict(c) for c in kept.levels],
        "typed": [asdict(c) for c in kept.typed],
    }
    head = ", ".join(f'"{k}": {json.dumps(v)}' for k, v in {**asdict(kept.measured), "date": kept.date}.items())
    body = ", ".join(f'"{name}": [\n {_lines(rows)}]' for name, rows in lists.items())
    replace_file(store / file_of(source), f"{{{head}, {body}}}\n")


def times_of(study: Study, source: str) -> Kept | None:
    """Times of a case's page as one measuring run has them; those of all compared scenes where none is kept; None without
    any."""
    stores = (*(study.stores or ()), shipped_store())
    return load_times(stores, source) or load_times(stores)


def load_times(stores: Sequence[Path], source: str = "") -> Kept | None:
    """Times of the first store that has any; source: those of a case's page. None without a valid file."""

    def made(data: dict[str, Any]) -> Kept:
        times = {(r["scene"], r["model"]): RunTime(r["cold"], r["warm"], r["memory"]) for r in data["times"]}
        first = {(r.pop("model"), r["engine"]): Cold(**r) for r in data["first"]}
        levels = tuple(ColdLevel(**r) for r in data.get("levels", []))
        measured = Measured(data.get("version", ""), data.get("sources", ""), data["machine"])
        commands = tuple(Typed(**r) for r in data.get("typed", []))
        return Kept(measured, data["date"], times, first, levels, commands)

    return first_kept(stores, file_of(source), made)


def load_costs(stores: Sequence[Path]) -> Costs | None:
    """Costs of the first store that has any; None without a valid file."""

    def made(data: dict[str, Any]) -> Costs:
        jobs, ways = [SetUp(**row) for row in data["jobs"]], [Way(**row) for row in data["ways"]]
        return Costs(data["machine"], data["date"], jobs, ways, data.get("version", ""))

    return first_kept(stores, SET_UP_COSTS, made)


#: A new catalogue screw.
NEW = "new my.toml --like 40x10"

#: Commands that are timed, and what they are to take from an empty home on two cores; those of ``my.toml`` after `NEW`.
COMMANDS = {
    "list": "",
    "solve lin-case1": "",
    "solve lin-case1 --model lin": "",
    "friction lin-case1": "",
    "solve lin-random --members 1000": "",
    "check lin-case1 --no-compute": "",
    "solve my.toml": "1.5 s",
    "friction my.toml --mu 0.1": "5 s to its first line",
    "compare my.toml --levels 1": "20 s of CPU time",
    "report": "120 s",
}

#: A process that keeps a core busy.
BUSY = "while True: pass"

#: Members of an ensemble, and numbers of threads.
MEMBERS, THREADS = 1000, (1, 2)


@dataclass(frozen=True)
class Typed:
    """A command typed in an empty home: seconds to its end and to its first line, CPU seconds of all its processes; seconds
    and CPU seconds typed once more there, which is what does not come of the empty home; and from an empty home beside one
    busy process. None: not measured, as the note says."""

    command: str
    seconds: float | None = None
    first_line: float | None = None
    cpu: float | None = None
    again: float | None = None
    again_cpu: float | None = None
    beside: float | None = None
    beside_cpu: float | None = None
    note: str = ""

    @property
    def job(self) -> Job:
        """As a row of the bench."""
        if self.seconds is None:
            return Job(f"{self.command}, from an empty home", None, note=self.note)
        first = "" if self.first_line is None else f"first line {self.first_line:.3g} s, "
        again = f"again: {self.again:.3g} s ({self.again_cpu:.3g} CPU)"
        beside = f"beside a busy process {self.beside:.3g} s ({self.beside_cpu:.3g} CPU)"
        note = f"wall clock of the process; {first}CPU {self.cpu:.3g} s; {again}; {beside}"
        return Job(f"{self.command}, from an empty home", self.seconds, note=note)


def typed(command: str) -> Typed:
    """Times of a command as typed, with a note where it fails."""
    found = _in_empty_home(command, 2)
    busy = subprocess.Popen([sys.executable, "-c", BUSY])
    try:
        found += _in_empty_home(command, 1)
    finally:
        busy.kill()
        busy.wait()
    for one in found:
        if one.code != 0:
            last = one.output.strip().splitlines()[-1:] or ["no message"]
            return Typed(command, note=f"not measured: {last[0][:120]}")
    alone, again, beside = found
    spent = again.seconds, again.cpu, beside.seconds, beside.cpu
    return Typed(command, alone.seconds, alone.first_line, alone.cpu, *spent)


def _in_empty_home(command: str, times: int) -> list[Launched]:
    """A command typed some times in a home that is empty at first, but for a new scene where the command names it."""
    with tempfile.TemporaryDirectory() as home:
        places = {"XDG_CACHE_HOME": "cache", "ROLLBENCH_CACHE": "cache/rollbench", "NUMBA_CACHE_DIR": "cache/numba"}
        own = {name: str(Path(home) / place) for name, place in places.items()} | {"HOME": home}
        if "my.toml" in command:
            launch(["-m", "rollbench", *NEW.split()], own, home)
        return [launch(["-m", "rollbench", *command.split()], own, home) for _ in range(times)]


def in_threads(count: int = MEMBERS, repeats: int = 3) -> Iterator[Job]:
    """An ensemble of ``lin-random`` by the model lin in one and in two threads; ratio: one thread's time over it."""
    parts = scene("lin-random")
    alone = 0.0
    for threads in THREADS:

        def work(threads: int = threads) -> object:
            return run_ensemble(parts, count, threads=threads)

        seconds = timed(work, repeats)
        alone = alone or seconds
        name = f"{count} members of lin-random, threads: {threads}"
        yield Job(name, seconds, alone / seconds, note="model lin, compiled; ratio: one thread's time over this")
