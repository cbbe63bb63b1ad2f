"""What people wait for: commands, each in processes of its own, with an aim, a floor, and where their time goes.

Short ones are measured as they are typed, with warm caches; those that take minutes by ``bench --long``, and kept with
version and day.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from shlex import split
from time import perf_counter, time_ns
from typing import Literal

from rollbench.compare import __version__
from rollbench.compare.errors import ArgumentError
from rollbench.compare.scenes.catalogue import scene_text
from rollbench.compare.scenes.like import scene_like
from rollbench.compare.system import machine
from rollbench.compare.wings.bench.costs.kept import first_kept, save_rows, today
from rollbench.compare.wings.bench.costs.timing import Job, as_a_users, launch
from rollbench.reports.content import Quantity, Row, Table

BASE = "import numpy, cyclopts, rich.console"
#: Numba finds its own parts only with the first kernel that is run, one kept on disc here.
COMPILED = (
    f"{BASE}; from rollbench.lowfi.jit import STATICS, kernels; kernels(STATICS, compiled=True).contact.hertz(1e-6, 1e-8)"
)
CLOCKS = {
    "CPU": "CPU of the whole process",
    "wall": "wall clock of the whole process",
    "answer": "wall clock until the first line of the answer",
}
#: Sizes of new screws that are solved as typed, and their balls.
CATALOGUE = {"20x5": 54, "50x5": 134}
#: File of a store that holds the long ones; seconds after which one of them is given up.
FILE, LIMIT = "waits.json", 7200.0
_IN_TIME = '\n[motion]\nturns = "screw"\nspeed = "60 rpm"\n\n[time]\nangle = "90 deg"\nsteps = 200\noutput = "torque"\n'
#: Work alone of a sample whose bodies change, or not: {count} solutions without records, after one that is not counted.
_SOLVED = (
    "from dataclasses import replace; from rollbench.compare.scenes.catalogue import scene\n"
    "from rollbench.lowfi.statics.elastic import solve_elastic; s = scene('lin-case1')\n"
    "for k in range({{count}}): solve_elastic({}, engine='compiled')"
)
_BODIES = _SOLVED.format("replace(s, nut=replace(s.nut, outer_diameter=0.048 + 1e-7 * k))")
_LOADS = _SOLVED.format("replace(s, loads=(replace(s.loads[0], force=(0.0, 0.0, 5e3 + k)),))")
_SWEEP = 'sweep lin-case1 --vary "{vary}" --method lhs --samples {{count}} --seed {{seed}} --out {{folder}}/{{count}}'


@dataclass(frozen=True)
class Wait:
    """A job: its name, the words of its command, its aim [s], code of its floor, which loads the libraries that it cannot
    do without, and what that is. counts: two numbers of samples, the job being one of those between; caches: filled by a
    first run, empty, or as they are; clock: seconds of a processor, on the wall, or there up to the answer's first line;
    program: the module that runs; module: of the package, whose import brings all that the command is made of, none where
    that is not told; runs: least of so many counts; busy: next to a process that keeps one core busy. {folder} in words: an
    empty folder; {balls32}, {like50x5}: scenes there; {seed}: another every time, so that no sample's bodies are known.
    """

    job: str
    words: str
    aim: float
    base: str = BASE
    base_of: str = "its libraries alone"
    counts: tuple[int, ...] = ()
    caches: Literal["warm", "empty", "as they are"] = "warm"
    clock: Literal["CPU", "wall", "answer"] = "CPU"
    program: str = "rollbench"
    module: str = ""
    runs: int = 1
    busy: bool = False

    def seconds(self, words: list[str], folder: Path) -> float | None:
        """Seconds of a Python process with these words; None where it fails."""
        with tempfile.TemporaryDirectory() as empty:
            extra = {"ROLLBENCH_CACHE": empty} if self.caches == "empty" else {}
            if self.clock == "answer":
                return _until_answer(words, extra, folder)
            if self.clock == "wall":
                seconds, done = launch(words, extra, LIMIT)
                return seconds if done.returncode == 0 else None
            return cpu_seconds(words, self.runs, extra, LIMIT)

    def each(self, words: str, places: dict[str, str], first: Sequence[str] = ("-c",)) -> float | None:
        """Seconds of code, or of a command of a module (``first``), or of one of its samples."""
        found = []
        for count in self.counts or (0,):
            given = [
                x.format(count=count, seed=time_ns() % 10**9, **places)
                for x in (split(words) if first[0] == "-m" else [words])
            ]
            found.append(self.seconds([*first, *given], Path(places["folder"])))
        known = [x for x in found if x is not None]
        if len(known) < len(found):
            return None
        return known[0] if not self.counts else (known[1] - known[0]) / (self.counts[1] - self.counts[0])

    def measured(self) -> Job:
        """The job as it takes now on this machine."""
        with tempfile.TemporaryDirectory() as name:
            places = {"folder": name}
            for balls in (32, 120):
                places[f"balls{balls}"] = str(Path(name) / f"balls-{balls}.toml")
                Path(places[f"balls{balls}"]).write_text(_balls(balls), encoding="utf-8")
            for size in CATALOGUE:
                places[f"like{size}"] = str(Path(name) / f"{size}.toml")
                Path(places[f"like{size}"]).write_text(scene_like(size), encoding="utf-8")
            if self.caches == "warm":
                replace(self, runs=1).each(self.words, {**places, "folder": f"{name}/first"}, ("-m", self.program))
            with busy_process() if self.busy else nullcontext():
                whole = self.each(self.words, places, ("-m", self.program))
            plain = replace(self, clock="CPU", caches="warm")
            floor = plain.each(self.base, places)
            own = f"{self.base}; import rollbench.compare.{self.module}"
            modules = plain.each(own, places) if self.module else None
        clock = f"CPU of a sample: {self.counts[1]} less {self.counts[0]} of them" if self.counts else CLOCKS[self.clock]
        note = f"{clock}, caches {self.caches}" if whole is not None else "not measured: the command failed"
        return Job(self.job, whole, None, None, None, note, self.aim, floor, self.base_of, modules)


def _typed(words: str, aim: float, base: str, module: str, runs: int = 3) -> Wait:
    """A command as it is typed."""
    return Wait(f"{words}, as typed", words, aim, base, module=module, runs=runs)


_SOLVE, _MEMBERS = "commands.solving.solve", "wings.members.command"
TYPED = (
    _typed("list", 0.35, BASE, "commands.listing"),
    _typed("solve lin-case1", 0.6, BASE, _SOLVE),
    _typed("solve lin-case1 --model lin", 0.4, BASE, _SOLVE),
    _typed("friction lin-case1", 0.6, BASE, "wings.friction.whole"),
    _typed("solve lin-random --members 100 --model lin", 1.0, COMPILED, _MEMBERS),
    _typed("solve lin-random --members 10000 --model lin", 3.0, COMPILED, _MEMBERS, 2),
    _typed("solve lin-random --members 20", 1.0, COMPILED, _MEMBERS),
    _typed("solve lin-random --members 1000", 2.0, COMPILED, _MEMBERS, 2),
)
CATALOGUED = tuple(
    Wait(f"solve a new {size}, {balls} balls, --model {model}, next to a busy process", words, aim, busy=True)
    for size, balls in CATALOGUE.items()
    for model, aim in (("lin", 1.0), ("refined", 2.0))
    for words in (f"solve {{like{size}}} --model {model}",)
)
_FIRST, _REPORT = "first use", "report --out {folder}/report --store {folder}/runs"
_CHANGED = _SWEEP.format(vary="nut.outer_diameter=47.9 mm:48.1 mm")
_KEPT = _SWEEP.format(vary="loads[0].force[2]=4 kN:5 kN")
LONG = (
    Wait("friction in time, 32 balls, 200 steps", "friction {balls32}", 4.0, COMPILED),
    Wait("friction in time, 120 balls, 200 steps", "friction {balls120}", 60.0, COMPILED),
    Wait(f"{_FIRST}: friction lin-case1", "friction lin-case1", 5.0, caches="empty", clock="answer"),
    Wait(f"{_FIRST}: solve axis-fixed-fixed", "solve axis-fixed-fixed", 5.0, caches="empty", clock="answer"),
    Wait(f"{_FIRST}: solve, 120 balls", "solve {balls120}", 5.0, caches="empty", clock="answer"),
    Wait("sample of a sweep, bodies changed", _CHANGED, 0.25, _BODIES, "its solution alone", (64, 128)),
    Wait("sample of a sweep, bodies kept", _KEPT, 3e-3, _LOADS, "its solution alone", (64, 512)),
    Wait("audit", "audit", 40.0, caches="as they are"),
    Wait("first report", _REPORT, 90.0, caches="empty", clock="wall"),
    Wait("report --all", _REPORT.replace("report", "report --all", 1), 500.0, caches="as they are", clock="wall"),
    Wait("tests of the core", "-p no:cacheprovider", 240.0, caches="as they are", clock="wall", program="pytest"),
)


def now_and_here() -> str:
    """Version, day and machine of a time that is kept."""
    return f"{__version__}, {today()}, {machine()}"


def _balls(count: int) -> str:
    """Scene of case 1 with that many balls at the same spacing, turned in time."""
    text = scene_text("lin-case1")
    turns = count / 16
    changes = {
        "count = 32": f"count = {count}",
        "turns = 2": f"turns = {turns:g}",
        'length = "54 mm"': f'length = "{20 * turns + 14:g} mm"',
    }
    for old, new in changes.items():
        if text.count(f"\n{old}\n") != 1:
            raise RuntimeError(f"bench: {old!r} stands not once in lin-case1")
        text = text.replace(f"\n{old}\n", f"\n{new}\n")
    return text + _IN_TIME


def cpu_seconds(arguments: list[str], runs: int, extra: dict[str, str], limit: float) -> float | None:
    """Least seconds of a processor that a Python process takes, of some runs; None where one fails. extra: variables of its
    environment; limit: of its wall clock [s]."""
    found = []
    for _ in range(runs):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        plain = {"PYTHONDONTWRITEBYTECODE": ""}  # as a user's, who has nothing there
        done = launch(arguments, {**plain, **extra}, limit)[1]
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if done.returncode != 0:
            return None
        found.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return min(found)


@contextmanager
def busy_process() -> Iterator[None]:
    """A process that keeps one core busy."""
    with subprocess.Popen([sys.executable, "-c", "while True: pass"]) as process:
        try:
            yield
        finally:
            process.kill()


def _until_answer(arguments: list[str], extra: dict[str, str], folder: Path) -> float | None:
    """Wall clock of a Python process until the first line on its standard output, not buffered, as on a terminal [s]; the
    process is waited for to its end."""
    begin = perf_counter()
    words = [sys.executable, "-u", "-P", *arguments]
    with (
        (folder / "errors").open("w") as errors,
        subprocess.Popen(words, stdout=subprocess.PIPE, stderr=errors, env=as_a_users(extra), text=True) as process,
    ):
        assert process.stdout is not None
        first = process.stdout.readline()
        seconds = perf_counter() - begin
        process.communicate()
    return seconds if first and process.returncode == 0 else None


def kept(stores: Sequence[Path], file: str = FILE) -> list[Job]:
    """Jobs of the first store that has any."""
    return first_kept(stores, file, lambda rows: [Job(**row) for row in rows]) or []


def keep(store: Path, job: Job) -> None:
    """Keep a job in a store, in the order of `LONG`, in place of that of the same name. Raises InputError where it cannot
    be written."""
    found = {one.job: one for one in (*kept([store]), job)}
    save_rows(store, FILE, [found[one.job] for one in LONG if one.job in found])


def long_jobs(names: Sequence[str], store: Path | None) -> Iterator[Job]:
    """Each job whose name begins with one of some names, all without any, as soon as it is measured, kept in a store.

    Raises InputError for a name that none begins with.
    """
    for name in names:
        if not any(one.job.startswith(name) for one in LONG):
            allowed = ", ".join(one.job for one in LONG)
            raise ArgumentError("long", name, allowed, "give the beginning of one")
    for one in LONG:
        if not names or one.job.startswith(tuple(names)):
            job = replace(one.measured(), when=now_and_here())
            if store is not None:
                keep(store, job)
            yield job


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
