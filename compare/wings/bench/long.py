"""Jobs that people wait for and that take minutes: measured by ``bench --long``, and kept with version and day."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from shlex import split
from time import perf_counter, time_ns
from typing import Literal

from rollbench.comparison import __version__
from rollbench.comparison.errors import InputError
from rollbench.comparison.scenes.catalogue import scene_text
from rollbench.comparison.system import machine
from rollbench.comparison.wings.bench.costs.run_times import today
from rollbench.comparison.wings.bench.costs.timing import Job, launch, single_threaded
from rollbench.comparison.wings.bench.typed import BASE, COMPILED, cpu_seconds
from rollbench.comparison.writing import replace_file

CLOCKS = {
    "CPU": "CPU of the whole process",
    "wall": "wall clock of the whole process",
    "answer": "wall clock until the first line of the answer",
}
#: File of a store that holds them; seconds after which one of them is given up.
FILE, LIMIT = "waits.json", 7200.0
_IN_TIME = '\n[motion]\nturns = "screw"\nspeed = "60 rpm"\n\n[time]\nangle = "90 deg"\nsteps = 200\noutput = "torque"\n'
#: Work alone of a sample whose bodies change, or not: {count} solutions without records, after one that is not counted.
_SOLVED = (
    "from dataclasses import replace; from rollbench.comparison.scenes.catalogue import scene\n"
    "from rollbench.lowfi.statics.elastic import solve_elastic; s = scene('lin-case1')\n"
    "for k in range({{count}}): solve_elastic({}, engine='compiled')"
)
_BODIES = _SOLVED.format("replace(s, nut=replace(s.nut, outer_diameter=0.048 + 1e-7 * k))")
_LOADS = _SOLVED.format("replace(s, loads=(replace(s.loads[0], force=(0.0, 0.0, 5e3 + k)),))")
_SWEEP = 'sweep lin-case1 --vary "{vary}" --method lhs --samples {{count}} --seed {{seed}} --out {{folder}}/{{count}}'


@dataclass(frozen=True)
class Long:
    """A job: its name, the words of its command, its aim [s], code of its floor and what that is. counts: two numbers of
    samples, the job being one of those between; caches: filled by a first run, empty, or as they are; clock: seconds of a
    processor, on the wall, or there up to the first line of the answer; program: the module that runs. {folder} in words:
    an empty folder; {balls32}: a scene there; {seed}: another every time, so that no sample's bodies are known.
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

    def seconds(self, words: list[str], folder: Path) -> float | None:
        """Seconds of a Python process with these words; None where it fails."""
        with tempfile.TemporaryDirectory() as empty:
            extra = {"ROLLBENCH_CACHE": empty} if self.caches == "empty" else {}
            if self.clock == "answer":
                return _until_answer(words, extra, folder)
            if self.clock == "wall":
                seconds, done = launch(words, extra, LIMIT)
                return seconds if done.returncode == 0 else None
            return cpu_seconds(words, 1, extra, LIMIT)

    def each(self, words: str, places: dict[str, str], first: Sequence[str]) -> float | None:
        """Seconds of a command or code, or of one of its samples."""
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
            if self.caches == "warm":
                self.each(self.words, {**places, "folder": f"{name}/first"}, ("-m", self.program))
            whole = self.each(self.words, places, ("-m", self.program))
            floor = replace(self, clock="CPU", caches="warm").each(self.base, places, ("-c",))
        clock = f"CPU of a sample: {self.counts[1]} less {self.counts[0]} of them" if self.counts else CLOCKS[self.clock]
        note = f"{clock}, caches {self.caches}" if whole is not None else "not measured: the command failed"
        return Job(self.job, whole, None, None, None, note, self.aim, floor, self.base_of, None, now_and_here())


def now_and_here() -> str:
    """Version, day and machine of a time that is kept."""
    return f"{__version__}, {today()}, {machine()}"


_FIRST = "first use"
LONG = (
    Long("friction in time, 32 balls, 200 steps", "friction {balls32}", 4.0, COMPILED),
    Long("friction in time, 120 balls, 200 steps", "friction {balls120}", 60.0, COMPILED),
    Long(f"{_FIRST}: friction lin-case1", "friction lin-case1", 5.0, caches="empty", clock="answer"),
    Long(f"{_FIRST}: solve axis-fixed-fixed", "solve axis-fixed-fixed", 5.0, caches="empty", clock="answer"),
    Long(f"{_FIRST}: solve, 120 balls", "solve {balls120}", 5.0, caches="empty", clock="answer"),
    Long(
        "sample of a sweep, bodies changed",
        _SWEEP.format(vary="nut.outer_diameter=47.9 mm:48.1 mm"),
        0.25,
        _BODIES,
        "its solution alone",
        (64, 128),
    ),
    Long(
        "sample of a sweep, bodies kept",
        _SWEEP.format(vary="loads[0].force[2]=4 kN:5 kN"),
        3e-3,
        _LOADS,
        "its solution alone",
        (64, 512),
    ),
    Long("audit", "audit", 40.0, caches="as they are"),
    Long("first report", "report --out {folder}/report --store {folder}/runs", 90.0, caches="empty", clock="wall"),
    Long(
        "report --all",
        "report --all --out {folder}/report --store {folder}/runs",
        500.0,
        caches="as they are",
        clock="wall",
    ),
    Long("tests of the core", "-p no:cacheprovider", 240.0, caches="as they are", clock="wall", program="pytest"),
)


def _balls(count: int) -> str:
    """Scene of case 1 with that many balls at the same spacing, turned in time."""
    text = scene_text("lin-case1")
    turns = count / 16
    changes = (
        ("count = 32", f"count = {count}"),
        ("turns = 2", f"turns = {turns:g}"),
        ('length = "54 mm"', f'length = "{20 * turns + 14:g} mm"'),
    )
    for old, new in changes:
        if text.count(f"\n{old}\n") != 1:
            raise RuntimeError(f"bench: {old!r} stands not once in lin-case1")
        text = text.replace(f"\n{old}\n", f"\n{new}\n")
    return text + _IN_TIME


def _until_answer(arguments: list[str], extra: dict[str, str], folder: Path) -> float | None:
    """Wall clock of a Python process until the first line on its standard output, not buffered, as on a terminal [s]; the
    process is waited for to its end."""
    begin = perf_counter()
    with (
        (folder / "errors").open("w") as errors,
        subprocess.Popen(
            [sys.executable, "-u", "-P", *arguments],
            stdout=subprocess.PIPE,
            stderr=errors,
            env=single_threaded(extra),
            text=True,
        ) as process,
    ):
        assert process.stdout is not None
        first = process.stdout.readline()
        seconds = perf_counter() - begin
        process.communicate()
    return seconds if first and process.returncode == 0 else None


def keep(store: Path, jobs: Sequence[Job]) -> None:
    """Keep jobs in a store, in the order of `LONG`, in place of those of the same name. Raises InputError where it cannot
    be written."""
    found = {job.job: job for job in (*kept([store]), *jobs)}
    save(store, FILE, [found[one.job] for one in LONG if one.job in found])


def save(store: Path, file: str, jobs: Sequence[Job]) -> None:
    """Write jobs into a file of a store. Raises InputError where it cannot be written."""
    rows = ",\n ".join(json.dumps(asdict(job)) for job in jobs)
    replace_file(store / file, f"[{rows}]\n")


def kept(stores: Sequence[Path], file: str = FILE) -> list[Job]:
    """Jobs of the first store that has any."""
    for store in stores:
        with suppress(OSError, ValueError, TypeError):
            return [Job(**row) for row in json.loads((store / file).read_text(encoding="utf-8"))]
    return []


def long_jobs(names: Sequence[str], store: Path | None) -> Iterator[Job]:
    """Each job whose name begins with one of some names, all without any, as soon as it is measured, kept in a store.

    Raises InputError for a name that none begins with.
    """
    for name in names:
        if not any(one.job.startswith(name) for one in LONG):
            allowed = ", ".join(one.job for one in LONG)
            raise InputError("command line", "--long", name, allowed, "give the beginning of one")
    for one in LONG:
        if not names or one.job.startswith(tuple(names)):
            job = one.measured()
            if store is not None:
                keep(store, [job])
            yield job
