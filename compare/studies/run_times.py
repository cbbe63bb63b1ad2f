"""Run times of models, of the 3D reference and of commands: measured in new processes, and stored.

The cold time is that of a first use: a new interpreter, all imports, the set-up of the geometry and one solution, in a
process with an empty folder for meshes. The warm time is that of a further solution in the same process, with the
geometry prepared.

A store holds the times of one measuring run (``rollbench bench --store FOLDER``), each stored as soon as it is measured.
"""

from __future__ import annotations

import datetime
import json
import os
import subprocess
import sys
import tempfile
import threading
import timeit
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from statistics import median
from time import perf_counter, time
from typing import Any, TypeVar

from rollbench.compare.files import read_from_first_valid_folder, replace_file
from rollbench.compare.reference.store import UNMEASURED, MeasuringConditions, shows_times_of
from rollbench.compare.scenes.catalogue import scene
from rollbench.compare.studies.members.ensemble import solve_random_draws
from rollbench.meshes.processes import VARIABLES

T = TypeVar("T")


@dataclass(frozen=True)
class RunTimeRow:
    """One row of the table of run times that ``rollbench bench`` prints."""

    #: Description of what was timed.
    job: str
    #: Wall clock [s]; None: not measured.
    seconds: float | None
    #: Ratio of two times; ``note`` says of which.
    ratio: float | None = None
    #: Number of unknowns of the equations in the timed solution.
    unknowns: int | None = None
    #: Peak memory of the process [MB].
    peak_MB: float | None = None
    #: Median over the timed scenes of a scene's largest contact-load error [% of the contact's load; of the mean
    #: load for a nearly unloaded contact].
    error_percent: float | None = None
    #: Remark on how the time was measured.
    note: str = ""


@dataclass(frozen=True)
class TimedProcess:
    """Times, exit code and printed output of a process that has ended."""

    #: Wall clock to the end of the process [s].
    seconds: float
    #: Wall clock to the first line of output of the process [s]; None without output.
    first_line_seconds: float | None
    #: CPU time of the process and its child processes [s].
    cpu_seconds: float
    #: Exit code.
    exit_code: int
    #: Output and error messages, in the order of a terminal.
    printed_output: str

    @property
    def last_line(self) -> str:
        """Last line of the output."""
        return next(iter(self.printed_output.strip().splitlines()[-1:]), "no message")


def run_timed_python_process(arguments: list[str], extra_environment: dict[str, str], folder: str) -> TimedProcess:
    """Run a Python process as a user would start it on a terminal, and return its times, exit code and output.

    ``arguments``: arguments of the Python interpreter; ``extra_environment``: environment variables by name, which are
    added to those of this process, but for those that set thread counts; ``folder``: working folder of the process.
    The process imports no module from its working folder. The process is killed after `PATIENCE` seconds.
    """
    own = {name: value for name, value in os.environ.items() if name not in VARIABLES}  # none that sets thread counts
    environment = own | {"PYTHONUNBUFFERED": "1"} | extra_environment
    command, pipe = [sys.executable, "-P", *arguments], subprocess.PIPE
    before, begin = os.times(), perf_counter()
    process = subprocess.Popen(command, stdout=pipe, stderr=subprocess.STDOUT, text=True, env=environment, cwd=folder)
    patience = threading.Timer(PATIENCE, process.kill)
    patience.start()
    with process:
        assert process.stdout is not None
        line = process.stdout.readline()
        first = perf_counter() - begin if line else None
        written = line + process.stdout.read()
    patience.cancel()
    seconds = perf_counter() - begin
    cpu = sum(y - x for x, y in zip(before[2:4], os.times()[2:4], strict=True))  # of child processes
    return TimedProcess(seconds, first, cpu, process.returncode, written)


#: Longest time to wait for a process [s].
PATIENCE = 1200.0

#: Number of further calls, the fastest of which gives the warm time.
REPEATS = 5

#: Program that times a call: the first time with its imports, then repeatedly; it tells values of what the call returned.
CHILD = """
import sys
sys.path[:] = {path!r}
from time import perf_counter, time
from rollbench.meshes.processes import limit_to_one_thread, peak_memory_MB
limit_to_one_thread()
import json
ask = json.loads({ask!r})
space = {{}}
exec(ask["imports"], space)
call = compile(ask["call"], "call", "eval")
spent = []
for _ in range(1 + ask["repeats"]):
    start = perf_counter()
    space["found"] = eval(call, space)
    spent.append(perf_counter() - start)
    if len(spent) == 1:
        done, memory = time(), peak_memory_MB()
told = eval(ask["told"], space)
print(json.dumps({{"done": done, "warm": min(spent[1:], default=None), "memory": memory, **told}}))
"""

#: Imports and call that solve a scene by a low-order model.
MODEL = (
    "from pathlib import Path\n"
    "from rollbench.compare.scenes import catalogue\n"
    "from rollbench.compare.models.model import ModelOptions\n"
    "from rollbench.compare.models.registry import run_model\n"
    "scene = catalogue.scene({scene!r})\n"
    "options = ModelOptions(estimate_beam_mesh_error=False, condensed_bodies_file={bodies})\n",
    "run_model(scene, {model!r}, options)",
)

#: Imports and call that compute a mesh level of the 3D reference as `compare` does, without stored meshes and runs; values
#: of the run that are told.
LEVEL = (
    "from rollbench.compare.reference.computing import compute_reference_runs\n"
    "from rollbench.compare.reference.tasks import ReferenceTask\n"
    "from rollbench.compare.scenes import catalogue\n"
    "from rollbench.compare.running import usable_cores\n",
    "compute_reference_runs(ReferenceTask((catalogue.scene({scene!r}),), {level}, processes=usable_cores()))[0]",
    "dict(memory=found.peak_MB, status=found.status, contacts=int((found.load > 0.0).sum()), "
    "load_case=found.solve_seconds, stages=found.stages)",
)


@dataclass(frozen=True)
class ColdLevelTime:
    """Time of a first solution by the 3D reference on one mesh level, from the interpreter's start to the contact loads.

    A field is None if it was not measured.
    """

    #: Mesh level.
    level: int
    #: Wall-clock time of the first solution [s].
    process: float
    #: CPU time of all processes [s].
    cpu: float
    #: Sum of the peak memories of all processes [MB].
    memory: float | None
    #: Status of the solution.
    status: str
    #: Name of the scene.
    scene: str = "lin-case1"
    #: Number of loaded contacts in the solution.
    contacts: int | None = None
    #: Wall-clock time of a further load case with the same meshes [s].
    load_case: float | None = None
    #: Wall clock of each stage of the set-up, such as meshing, by name of the stage [s].
    stages: dict[str, float] | None = None


def time_model_in_new_process(scene: str, model: str, condensed: Path | None) -> RunTime:
    """Time a low-order model on a scene of the package, in a new process with empty caches.

    ``scene`` and ``model``: their names; ``condensed``: file of condensed stiffness matrices that the model reads, None for
    a model without. Raises RuntimeError if the process fails.
    """
    bodies = f"Path({str(condensed.resolve())!r})" if condensed else None
    imports, call = (code.format(scene=scene, model=model, bodies=bodies) for code in MODEL)
    return time_call_in_new_process(imports, call, f"{model} on {scene}", 1)


def time_call_in_new_process(imports: str, call: str, label: str, repeats: int = REPEATS) -> RunTime:
    """Time a Python call and its repetitions in a new process with empty caches.

    ``imports``: Python statements that are executed before the call and count as part of the cold time; ``call``: Python
    expression that is timed; ``label``: name of the call in the error message; ``repeats``: number of further calls, the
    fastest of which gives the warm time. Raises RuntimeError if the process fails.
    """
    cold, printed, _ = _run_with_empty_caches(label, imports=imports, call=call, repeats=repeats, told="{}")
    return RunTime(cold, printed["warm"], printed["memory"])


def time_mesh_level_in_new_process(scene: str, level: int) -> ColdLevelTime:
    """Time a solution of the 3D reference on one mesh level, in a new process with empty caches, on all processor cores.

    ``scene``: name of a scene of the package; ``level``: mesh level. Raises RuntimeError if the process fails.
    """
    (imports, call, told), label = LEVEL, f"level {level} of {scene}"
    code = call.format(scene=scene, level=level)
    cold, found, cpu = _run_with_empty_caches(label, imports=imports, call=code, repeats=0, told=told)
    known = {name: found[name] for name in ("memory", "status", "contacts", "load_case", "stages")}
    return ColdLevelTime(level, cold, cpu, scene=scene, **known)


def _run_with_empty_caches(label: str, **asked: Any) -> tuple[float, dict[str, Any], float]:
    """Run the program `CHILD` in a new process with empty caches.

    Returns the time from the process's start to its first answer [s], the JSON values it printed, and its CPU time [s].

    ``label``: name of the measurement in the message of the RuntimeError that is raised if the process fails; ``asked``:
    what the program reads.
    """
    with tempfile.TemporaryDirectory() as folder:
        code = CHILD.format(path=[p for p in sys.path if p], ask=json.dumps(asked))
        begin = time()
        process = run_timed_python_process(["-I", "-c", code], {"ROLLBENCH_CACHE": folder}, folder)
    if process.exit_code != 0:
        raise RuntimeError(f"the process that timed {label} failed: {process.last_line}")
    found = json.loads(process.last_line)
    return found["done"] - begin, found, process.cpu_seconds


#: Name of the file in a store.
RUN_TIMES = "run_times.json"


@dataclass(frozen=True)
class RunTime:
    """Run times of a model on a scene: of a first solution in a new process (cold), and of a further one (warm)."""

    #: Wall clock of a new process with empty caches until its first solution [s].
    cold: float
    #: Wall clock of a further solution in the same process [s].
    warm: float
    #: Peak memory of the process [MB]; None: not measured.
    memory: float | None


@dataclass(frozen=True)
class StoredRunTimes:
    """Run times that were measured together and stored, with the conditions of the measurement."""

    #: Program version, digest of the program's source files, and machine of the measurement.
    measuring_conditions: MeasuringConditions
    #: Date of the measurement.
    date: str
    #: Times by what was timed.
    times: Mapping[Timed, Measured] = field(default_factory=dict)

    def of_kind(self, kind: type[T]) -> dict[Any, T]:
        """Return the times of one kind by what was timed; ``kind``: class of the times."""
        return {timed: time for timed, time in self.times.items() if isinstance(time, kind)}

    def __str__(self) -> str:
        """Return a sentence that states with which machine and program version, and when, the run times were measured."""
        return f"Run times are of one measuring run: rollbench {self.measuring_conditions}, {self.date}."


def utc_date_today() -> str:
    """Return today's date in UTC as YYYY-MM-DD."""
    return datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")


def save_times(path: Path, conditions: MeasuringConditions, date: str, **lists: Sequence[Mapping[str, Any]]) -> None:
    """Write measured times to a JSON file, a line for each; InputError if the file cannot be written.

    ``conditions`` and ``date``: those of the measurement; ``lists``: rows of times by the name of their list.
    """
    head = json.dumps({**asdict(conditions), "date": date})
    texts = {name: ",\n".join(json.dumps(row, separators=(",", ":")) for row in rows) for name, rows in lists.items()}
    body = ", ".join(f'"{name}": [\n{text}\n]' for name, text in texts.items())
    replace_file(path, f"{head[:-1]}, {body}}}\n")


def measuring_conditions_from_json(data: Mapping[str, Any]) -> MeasuringConditions:
    """Return the conditions of a measurement from the JSON values of its file."""
    return MeasuringConditions(data.get("version", ""), data.get("sources", ""), data["machine"])


def save_run_times(store: Path, run_times: StoredRunTimes) -> None:
    """Write run times to a JSON file in the folder ``store``; InputError if the file cannot be written."""
    save_times(
        store / RUN_TIMES,
        run_times.measuring_conditions,
        run_times.date,
        times=[{"scene": s, "model": m, **asdict(t)} for (s, m), t in sorted(run_times.of_kind(RunTime).items())],
        levels=[asdict(c) for c in run_times.of_kind(ColdLevelTime).values()],
        typed=[asdict(c) for c in run_times.of_kind(CommandTime).values()],
    )


def load_run_times(stores: Sequence[Path]) -> StoredRunTimes | None:
    """Read stored run times of this version from the first folder with a valid file; None without one.

    ``stores``: the folders in the order in which they are tried.
    """

    def run_times_from_json(data: dict[str, Any]) -> StoredRunTimes:
        """Return run times from the JSON values of their file; ValueError if they are of another version."""
        conditions = measuring_conditions_from_json(data)
        if not shows_times_of(conditions.version):
            raise ValueError(UNMEASURED)
        times: dict[Timed, Measured] = {
            (r["scene"], r["model"]): RunTime(r["cold"], r["warm"], r["memory"]) for r in data["times"]
        }
        times |= {(r["scene"], r["level"]): ColdLevelTime(**r) for r in data.get("levels", [])}
        times |= {(r["command"],): CommandTime(**r) for r in data.get("typed", [])}
        return StoredRunTimes(conditions, data["date"], times)

    return read_from_first_valid_folder(stores, RUN_TIMES, run_times_from_json)


#: Command that writes the scene of a catalogue screw to ``my.toml``.
NEW = "new my.toml --like 40x10"

#: Commands that are timed. Commands on ``my.toml`` are typed after `NEW`.
COMMANDS = (
    "list",
    "solve lin-case1",
    "solve lin-case1 --model lin",
    "friction lin-case1",
    "solve lin-random --members 1000",
    "check lin-case1 --no-compute",
    "solve my.toml",
    "friction my.toml --mu 0.1",
    "compare my.toml --levels 1",
    "report",
)

#: Program that keeps a processor core busy.
BUSY = "while True: pass"

#: Number of specimens of an ensemble that is timed.
MEMBERS = 1000


@dataclass(frozen=True)
class CommandTime:
    """Times of a ``rollbench`` command typed in an empty home directory; a time is None if it was not measured."""

    #: Command and arguments that were typed.
    command: str
    #: Wall clock to the end of the command [s].
    seconds: float | None = None
    #: Wall clock to the command's first line of output [s].
    first_line: float | None = None
    #: CPU time of all processes of the command [s].
    cpu: float | None = None
    #: Wall clock of a further run in the same home directory [s], which uses the caches of the first.
    again: float | None = None
    #: CPU time of this further run [s].
    again_cpu: float | None = None
    #: Wall clock to the end in an empty home directory while another process keeps a processor core busy [s].
    beside: float | None = None
    #: CPU time in an empty home directory while another process keeps a processor core busy [s].
    beside_cpu: float | None = None
    #: Remark, such as why a time was not measured.
    note: str = ""

    @property
    def job(self) -> RunTimeRow:
        """Times of the command as a row of the table of run times."""
        name = f"{self.command}, from an empty home"
        if self.seconds is None:
            return RunTimeRow(name, None, note=self.note)
        first = "" if self.first_line is None else f"first line {self.first_line:.3g} s, "
        again = f"again: {self.again:.3g} s ({self.again_cpu:.3g} CPU)"
        beside = f"beside a busy process {self.beside:.3g} s ({self.beside_cpu:.3g} CPU)"
        note = f"wall clock of the process; {first}CPU {self.cpu:.3g} s; {again}; {beside}"
        return RunTimeRow(name, self.seconds, note=note)


#: What is timed: scene and model, scene and mesh level of the 3D reference, or a command.
Timed = tuple[str, str] | tuple[str, int] | tuple[str]
#: Time of it, as it is measured.
Measured = RunTime | ColdLevelTime | CommandTime


def measure_and_store(
    store: Path | None,
    conditions: MeasuringConditions,
    jobs: Mapping[Timed, Callable[[], Measured]],
    show_progress: Callable[[str], None],
) -> StoredRunTimes:
    """Measure run times one after the other, each stored when it is measured, and return them.

    Parameters
    ----------
    store
        Folder in which the times are stored; times there of the same conditions are not measured again. None: not stored.
    conditions
        Conditions of the measurement.
    jobs
        Function that measures a time, by what is timed.
    show_progress
        Called with a line of progress before each measurement.

    Returns
    -------
    StoredRunTimes
        All measured and stored times.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    stored = None if store is None else load_run_times((store,))
    found = stored if stored and stored.measuring_conditions == conditions else StoredRunTimes(conditions, utc_date_today())
    left = {timed: measure for timed, measure in jobs.items() if timed not in found.times}
    for number, (timed, measure) in enumerate(left.items(), 1):
        show_progress(f"[{number}/{len(left)}] {', '.join(map(str, timed))}")
        found = replace(found, times={**found.times, timed: measure()})
        if store is not None:
            save_run_times(store, found)
    return found


def time_command_in_empty_home(command: str) -> CommandTime:
    """Time a ``rollbench`` command in an empty home directory, again in the same one, and in an empty one with a busy core.

    ``command``: arguments of ``rollbench``, such as "solve lin-case1". During the third measurement another process keeps a
    processor core busy. If the command fails, the returned record has only a note.
    """
    found = _run_in_empty_home(command, 2)
    busy = subprocess.Popen([sys.executable, "-c", BUSY])
    try:
        found += _run_in_empty_home(command, 1)
    finally:
        busy.kill()
        busy.wait()
    for one in found:
        if one.exit_code != 0:
            return CommandTime(command, note=f"not measured: {one.last_line[:120]}")
    alone, again, beside = found
    spent = again.seconds, again.cpu_seconds, beside.seconds, beside.cpu_seconds
    return CommandTime(command, alone.seconds, alone.first_line_seconds, alone.cpu_seconds, *spent)


def _run_in_empty_home(command: str, run_count: int) -> list[TimedProcess]:
    """Run a ``rollbench`` command several times in one new home directory; return times and output of each run.

    If the command names ``my.toml``, this scene file is written there first. ``run_count``: number of runs.
    """
    with tempfile.TemporaryDirectory() as home:
        places = {"XDG_CACHE_HOME": "cache", "ROLLBENCH_CACHE": "cache/rollbench"}
        own = {name: str(Path(home) / place) for name, place in places.items()} | {"HOME": home}
        if "my.toml" in command:
            run_timed_python_process(["-m", "rollbench", *NEW.split()], own, home)
        return [run_timed_python_process(["-m", "rollbench", *command.split()], own, home) for _ in range(run_count)]


def time_ensemble() -> RunTimeRow:
    """Time the solution of many random draws of the scene ``lin-random`` by the model lin: the median of three runs.

    Each draw is the scene with one set of random geometric errors.
    """
    _, *seconds = timeit.repeat(partial(solve_random_draws, scene("lin-random"), MEMBERS), number=1, repeat=4)
    return RunTimeRow(f"{MEMBERS} members of lin-random", median(seconds), note="model lin")
