"""One way to solve many: rows of inputs, solved one after the other, in several processes or on a cluster, and stored.

Sweeps, tables, specimens, load curves, load cases, scenes side by side and the survey are spellings of `solve_many`.

Results may be stored in a folder. It has a file that states the whole, and files with one line per row, which is appended
when the row is solved and never changed. Every process writes to a separate file, the lines of a row in one call and each
with a checksum. Whenever a process is killed, finished rows are therefore complete, and a torn line is recognised.

Each run writes a token (random text) into the folder. A process that outlives its run stops after its row, because the
token in the folder is no longer that of its run. A new run waits, by a lock that each process holds while it solves, until
such processes have stopped; only then does it read the folder, so that nothing is solved twice.
"""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, perf_counter
from typing import TYPE_CHECKING, Any, TypeVar
from uuid import uuid4

from rollbench.compare.errors import ArgumentError
from rollbench.compare.files import replace_file
from rollbench.meshes.files import machine_code

if TYPE_CHECKING:
    from rollbench.compare.reference import parallel
    from rollbench.compare.reference.jobs import ComputingSettings

#: Function that shows a line of progress.
Step = Callable[[str], None]
#: Result of a row as JSON values by name; it has a status and, if the row could not be solved, the reason.
Record = dict[str, Any]
#: Result of a row.
T = TypeVar("T")
#: Status of a solved row.
CONVERGED = "converged"
#: Time of the remaining rows [s] below which no further processes are started, because each must import first.
WORTH_WORKERS = 10.0
#: Names of files and folders in the folder of stored rows.
HEADER, TOKEN, LOCKS, RECORDS = "sweep.json", "token", "locks", "records"
#: Longest time to wait for processes of an earlier run [s].
PATIENCE = 600.0


def solve_many(
    solve: Callable[..., T],
    rows: Mapping[int, tuple[Any, ...]],
    engine: ComputingSettings | None = None,
    show_progress: Step = lambda _: None,
    *,
    noun: str = "",
    store: Store | None = None,
) -> Iterator[tuple[int, T]]:
    """Solve rows of inputs, and yield the number and the result of each as soon as it is available.

    Parameters
    ----------
    solve
        Function that returns the result of a row; it says in the result's status why a row has no values.
    rows
        Arguments of ``solve`` for each row, by its number.
    engine
        Number of processes, or cluster, that solve the rows; None: this process.
    show_progress
        Function that is called with a line if the rows are solved faster without more processes.
    noun
        Noun in the plural for the rows, such as "samples": with several processes, the first two rows are solved in this
        process, and the others, too, if that is faster than starting processes. Empty: processes are started at once.
    store
        Folder in which the results are stored, each of which is a record or a list of records then; None: none.

    Yields
    ------
    tuple
        Number of the row and its result.

    Raises
    ------
    InputError
        If workers are lost.
    """
    numbers = list(rows)
    jobs = [(_solve_row, (solve, rows[n], store)) for n in numbers]
    solved: Iterator[tuple[int, Any]] = ((k, job(*of)) for k, (job, of) in enumerate(jobs))
    for k, (result, stored) in solved if engine is None else _run_jobs(jobs, engine, show_progress, noun):
        if store is not None and not stored:
            store.append(result)
        yield numbers[k], result


def in_order(results: Iterator[tuple[int, T]], numbers: Sequence[int]) -> Iterator[tuple[int, T]]:
    """Yield numbers and results of rows in the order of ``numbers``, whichever is finished first."""
    waiting: dict[int, T] = {}
    left = iter(numbers)
    following = next(left, None)
    for number, result in results:
        waiting[number] = result
        while following in waiting:
            yield following, waiting.pop(following)
            following = next(left, None)


def _solve_row(solve: Callable[..., T], row: tuple[Any, ...], store: Store | None) -> tuple[T, bool]:
    """Solve a row; return its result, and whether it was already appended to the folder.

    A worker process that does not see the folder, or whose run is over, does not write there and only returns the result.
    """
    if store is None or not store.is_of_current_run():
        return solve(*row), False
    with store.process_lock():
        found = solve(*row)
        store.append(found)
    return found, True


def _run_jobs(
    jobs: Sequence[parallel.Job], engine: ComputingSettings, show_progress: Step, noun: str
) -> Iterator[tuple[int, Any]]:
    """Run independent jobs, in other processes only if that saves time, and yield number and result of each.

    With several workers, the first two jobs run in this process. The time of the second job, for which all modules are
    loaded, shows whether the remaining jobs would take longer than starting other processes; if not, they run here, too.
    """
    from rollbench.compare.reference import parallel  # not needed for rows that are solved in this process

    workers, here = engine.parallel_jobs, 0
    if noun and (workers or 1) > 1 and engine.backend == "joblib":
        start, here = perf_counter(), min(2, len(jobs))
        for number, result in parallel.run_jobs(jobs[:here]):
            left, start = (perf_counter() - start) * (len(jobs) - here), perf_counter()
            yield number, result
        if here and left < WORTH_WORKERS:
            more = "starting more processes takes longer"
            show_progress(f"one process: the remaining {noun} take about {left:.1f} s; {more}")
            workers = 1
    for number, result in parallel.run_jobs(jobs[here:], engine.backend, engine.scheduler_address, workers):
        yield here + number, result


@dataclass(frozen=True)
class Store:
    """Folder in which the rows of one run are stored."""

    #: The folder.
    folder: Path
    #: Text in the folder that identifies the present run.
    token: str

    def is_of_current_run(self) -> bool:
        """Return whether the folder is seen here and reserved for this run."""
        try:
            return (self.folder / TOKEN).read_text(encoding="utf-8") == self.token
        except OSError:
            return False

    @contextmanager
    def process_lock(self) -> Iterator[None]:
        """Hold a lock file of this process while it solves; a later run waits until the lock is released."""
        from filelock import FileLock

        with FileLock(self.folder / LOCKS / _machine_and_process_name()):
            yield

    def append(self, result: Any) -> None:
        """Append a record, or several, to the file of this process in one call; OSError if the disk does not take all."""
        path = self.folder / RECORDS / f"{self.token[:8]}-{_machine_and_process_name()}.lines"
        lines = b"".join(map(record_as_checked_line, result if isinstance(result, list) else [result]))
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0), 0o644)
        try:
            if os.write(handle, lines) != len(lines):
                raise OSError(28, "the disk is full: the records of samples were not written completely", str(path))
        finally:
            os.close(handle)


@contextmanager
def open_store(folder: Path, header: Mapping[str, Any]) -> Iterator[Store]:
    """Create the folder that stores rows, or check that it belongs to this computation, and reserve it for this run.

    First wait until no process of an earlier run writes to the folder. ``header``: JSON values that identify the
    computation, such as its scene and keys; they are written to a file of the folder. Raises InputError if the folder holds
    other files or another computation, or if another run is active there.
    """
    from filelock import FileLock, Timeout

    _create_or_check_folder(folder, header)
    try:
        reserved = FileLock(folder / "run", timeout=0).acquire()
    except Timeout:
        given, allowed = "the folder of a sweep that is running", "a folder in which no run is active"
        raise ArgumentError("out", given, allowed, "wait for that run, or end it", str(folder)) from None
    with reserved:
        store = Store(folder.resolve(), uuid4().hex)
        replace_file(folder / TOKEN, store.token)
        _wait_for_earlier_runs(folder)
        yield store


def _create_or_check_folder(folder: Path, header: Mapping[str, Any]) -> None:
    """Create the folder of stored rows, or check that an existing one has this header; InputError if it has not."""
    path = folder / HEADER
    text = json.dumps(header, indent=1, ensure_ascii=False) + "\n"
    allowed, advice = "a new folder, or that of this sweep", "choose another folder for another sweep"
    if path.exists():
        if path.read_text(encoding="utf-8") != text:
            raise ArgumentError("out", "the folder of another sweep", allowed, advice, str(folder))
    else:
        if folder.exists() and any(folder.iterdir()):
            raise ArgumentError("out", "a folder with other files", allowed, advice, str(folder))
        replace_file(path, text)
    (folder / RECORDS).mkdir(exist_ok=True)
    (folder / LOCKS).mkdir(exist_ok=True)


def _wait_for_earlier_runs(folder: Path) -> None:
    """Wait until the processes of earlier runs have finished their batches, and remove their lock files.

    Raises InputError if the processes take longer than `PATIENCE` seconds.
    """
    from filelock import FileLock, Timeout

    until = monotonic() + PATIENCE
    for path in (folder / LOCKS).iterdir():
        try:
            with FileLock(path, timeout=max(until - monotonic(), 0.0), poll_interval=0.02):
                path.unlink(missing_ok=True)
        except Timeout:
            given = "a folder to which processes of an earlier run of the sweep still write"
            allowed, advice = "a folder to which no other process writes", "end the processes of the earlier run"
            raise ArgumentError("out", given, allowed, advice, str(folder)) from None


def _machine_and_process_name() -> str:
    """Return digits for this machine and the number of this process, by which files of a folder are named."""
    return f"{machine_code()}-{os.getpid()}"


def record_as_checked_line(record: Record) -> bytes:
    """Return a record as one line: a checksum, then JSON."""
    body = json.dumps(record, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode()
    return b"%08x %s\n" % (zlib.crc32(body), body)


def record_from_checked_line(line: bytes) -> Record | None:
    """Return the record in a line with checksum and JSON; None if the line is incomplete or damaged."""
    checksum, _, body = line.rstrip(b"\n").partition(b" ")
    if not line.endswith(b"\n") or checksum != b"%08x" % zlib.crc32(body):
        return None
    found: Record = json.loads(body)
    return found


def stored_records(folder: Path) -> Iterator[Record]:
    """Yield all undamaged records in a folder of stored rows, file by file."""
    for path in sorted((folder / RECORDS).glob("*.lines")):
        with path.open("rb") as file:
            for line in file:
                record = record_from_checked_line(line)
                if record is not None:
                    yield record
