"""One way to solve many: rows of inputs, solved one after the other, in several processes or on a cluster, and stored.

Sweeps, tables, specimens, load curves, load cases, scenes side by side and the survey are spellings of `solve_many`.

Results may be stored in a folder: rows that it holds are read from it, the others are solved and appended. It has a file
that states the whole, and files with one line per row, which is appended when the row is solved and never changed. Every
process writes to a separate file, each line in one call and with a checksum. Whenever a process is killed, finished rows
are therefore complete, and a torn line is recognised.

Each run writes a token (random text) into the folder. A process that outlives its run stops after its row, because the
token in the folder is no longer that of its run. A new run waits, by a lock that each process holds while it solves, until
such processes have stopped; only then does it read the folder, so that nothing is solved twice.
"""

from __future__ import annotations

import json
import os
import zlib
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import monotonic, perf_counter
from typing import TYPE_CHECKING, Any, TypeVar
from uuid import uuid4

from rollbench.compare import __version__
from rollbench.compare.errors import ArgumentError
from rollbench.compare.files import replace_file
from rollbench.meshes.cache import record_from_bytes, record_to_bytes
from rollbench.meshes.files import machine_code
from rollbench.meshes.record_keys import digest_of_values

if TYPE_CHECKING:
    from rollbench.compare.reference import parallel
    from rollbench.compare.reference.jobs import ComputingSettings

#: Function that shows a line of progress.
Step = Callable[[str], None]
#: Result of a row as JSON values by name; it has a status and, if the row could not be solved, the reason.
Record = dict[str, Any]
#: Number of a row and its result as JSON, as they are stored.
StoredRow = tuple[int, Any]
#: Result of a row.
T = TypeVar("T")
#: Status of a solved row.
CONVERGED = "converged"
#: Time of the remaining rows [s] below which no further processes are started, because each must import first.
WORTH_WORKERS = 10.0
#: Names of files and folders in the folder of stored rows.
HEADER, TOKEN, LOCKS, RECORDS = "computation.json", "token", "locks", "records"
#: Longest time to wait for processes of an earlier run [s].
PATIENCE = 600.0


@dataclass(frozen=True)
class StoredIn:
    """Folder in which the rows of a computation are looked up and stored, and what identifies the computation."""

    #: The folder.
    folder: Path
    #: JSON values that identify the computation, such as its scene and keys.
    header: Mapping[str, Any]
    #: Argument by which the user names the folder, for error messages.
    argument: str = "store"
    #: Whether a stored result is final, as rows with other results are solved again; None: all results are.
    is_final: Callable[[Any], bool] | None = None


def stored_in(folder: str | Path | None, spelling: str, model: str, *inputs: object) -> StoredIn | None:
    """Return where the rows of a computation are stored; None without a folder.

    ``spelling``: name of the computation, such as "table"; ``model``: name of the model, empty for the default;
    ``inputs``: all other values on which the results depend, of the types that `canonical_text` accepts.
    """
    if folder is None:
        return None
    from rollbench.compare.models import registry, user_models

    header = {"rollbench": __version__, "computation": spelling, "model": model, "inputs": digest_of_values(*inputs)}
    if model and model not in registry.MODELS:
        header["model_of"] = user_models.origin_of_model(model)
    return StoredIn(Path(folder), header)


def solve_many(
    solve: Callable[..., T],
    rows: Mapping[int, tuple[Any, ...]],
    engine: ComputingSettings | None = None,
    show_progress: Step = lambda _: None,
    *,
    noun: str = "",
    stored: StoredIn | None = None,
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
        Function that is called with a line on how many rows are stored, and with another if the rows are solved faster
        without more processes.
    noun
        Noun in the plural for the rows, such as "samples": with several processes, the first two rows are solved in this
        process, and the others, too, if that is faster than starting processes. Empty: processes are started at once.
    stored
        Folder whose rows are not solved again, and to which the others are appended; None: none. Results are lists or
        dictionaries of JSON values, or records, arrays and other values that `record_to_bytes` accepts.

    Yields
    ------
    tuple
        Number of the row and its result. Stored rows come first, and have the same result as when they were solved.

    Raises
    ------
    InputError
        If workers are lost, if the folder holds other files or another computation, or if another run is active there.
    """
    with nullcontext() if stored is None else open_store(stored.folder, stored.header, stored.argument) as store:
        known: dict[int, Callable[[], T]] = {}
        if stored is not None:
            each, is_final = stored_rows(stored.folder), stored.is_final
            known = {n: read for n, read in each if n in rows and (is_final is None or is_final(read()))}
            counts = f"{len(rows)} {noun or 'rows'}, {len(known)} stored in {stored.folder}"
            show_progress(f"{counts}, {len(rows) - len(known)} to solve")
        for number, read in known.items():
            yield number, read()
        numbers = [number for number in rows if number not in known]
        jobs = [(_solve_row, (solve, rows[number], number, store)) for number in numbers]
        solved: Iterator[tuple[int, Any]] = ((k, job(*of)) for k, (job, of) in enumerate(jobs))
        for k, (result, appended) in solved if engine is None else _run_jobs(jobs, engine, show_progress, noun):
            if store is not None and not appended:
                store.append(result)
            yield numbers[k], result if store is None else result_from_json(result[1])


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


def _solve_row(
    solve: Callable[..., T], row: tuple[Any, ...], number: int, store: Store | None
) -> tuple[T | StoredRow, bool]:
    """Solve a row; return its result, or the row as it is stored, and whether it was already appended to the folder.

    A worker process that does not see the folder, or whose run is over, does not write there and only returns the row.
    """
    if store is None:
        return solve(*row), False
    if not store.is_of_current_run():
        return (number, result_as_json(solve(*row))), False
    with store.process_lock():
        found = number, result_as_json(solve(*row))
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

    def append(self, row: StoredRow) -> None:
        """Append a row to the file of this process in one call; OSError if the disk does not take all."""
        path, line = self.folder / RECORDS / f"{self.token[:8]}-{_machine_and_process_name()}.lines", _row_as_line(row)
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0), 0o644)
        try:
            if os.write(handle, line) != len(line):
                raise OSError(28, "the disk is full: a row was not written completely", str(path))
        finally:
            os.close(handle)


@contextmanager
def open_store(folder: Path, header: Mapping[str, Any], argument: str = "store") -> Iterator[Store]:
    """Create the folder that stores rows, or check that it belongs to this computation, and reserve it for this run.

    First wait until no process of an earlier run writes to the folder. ``header``: JSON values that identify the
    computation, such as its scene and keys; they are written to a file of the folder. ``argument``: argument by which the
    user names the folder, for error messages. Raises InputError if the folder holds other files or another computation, or
    if another run is active there.
    """
    from filelock import FileLock, Timeout

    _create_or_check_folder(folder, header, argument)
    try:
        reserved = FileLock(folder / "run", timeout=0).acquire()
    except Timeout:
        given, allowed = "the folder of a computation that is running", "a folder in which no run is active"
        raise ArgumentError(argument, given, allowed, "wait for that run, or end it", str(folder)) from None
    with reserved:
        store = Store(folder.resolve(), uuid4().hex)
        replace_file(folder / TOKEN, store.token)
        _wait_for_earlier_runs(folder, argument)
        yield store


def _create_or_check_folder(folder: Path, header: Mapping[str, Any], argument: str) -> None:
    """Create the folder of stored rows, or check that an existing one has this header; InputError if it has not."""
    path = folder / HEADER
    text = json.dumps(header, indent=1, ensure_ascii=False) + "\n"
    allowed, advice = "a new folder, or that of this computation", "choose another folder for another computation"
    if path.exists():
        if path.read_text(encoding="utf-8") != text:
            given = f"the folder of another computation{_differences(path, header)}"
            raise ArgumentError(argument, given, allowed, advice, str(folder))
    else:
        if folder.exists() and any(folder.iterdir()):
            raise ArgumentError(argument, "a folder with other files", allowed, advice, str(folder))
        replace_file(path, text)
    (folder / RECORDS).mkdir(exist_ok=True)
    (folder / LOCKS).mkdir(exist_ok=True)


def _differences(path: Path, header: Mapping[str, Any]) -> str:
    """Return which values of a stored header differ from those of ``header``, as the end of a message."""
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))
        names = [name for name in {**stored, **header} if stored.get(name) != header.get(name)]
    except (ValueError, TypeError, AttributeError):
        return ""
    return f", with other values of {', '.join(names)}" if names else ""


def _wait_for_earlier_runs(folder: Path, argument: str) -> None:
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
            given = "a folder to which processes of an earlier run still write"
            allowed, advice = "a folder to which no other process writes", "end the processes of the earlier run"
            raise ArgumentError(argument, given, allowed, advice, str(folder)) from None


def _machine_and_process_name() -> str:
    """Return digits for this machine and the number of this process, by which files of a folder are named."""
    return f"{machine_code()}-{os.getpid()}"


def result_as_json(result: Any) -> Any:
    """Return the result of a row as JSON: a list or dictionary as it is, another value as the text of its bytes."""
    if isinstance(result, list | dict):
        return json.loads(json.dumps(result, allow_nan=False))
    return b64encode(record_to_bytes(result, compressed=True)).decode()


def result_from_json(data: Any) -> Any:
    """Return the result of a row from what `result_as_json` returned."""
    return record_from_bytes(b64decode(data)) if isinstance(data, str) else data


def _row_as_line(row: StoredRow) -> bytes:
    """Return a row as one line: a checksum, then JSON."""
    body = json.dumps(row, ensure_ascii=False, separators=(",", ":")).encode()
    return b"%08x %s\n" % (zlib.crc32(body), body)


def _row_from_line(line: bytes) -> StoredRow | None:
    """Return the row in a line with checksum and JSON; None if the line is incomplete or damaged."""
    checksum, _, body = line.rstrip(b"\n").partition(b" ")
    if not line.endswith(b"\n") or checksum != b"%08x" % zlib.crc32(body):
        return None
    number, result = json.loads(body)
    return number, result


def stored_rows(folder: Path) -> Iterator[tuple[int, Callable[[], Any]]]:
    """Yield number of each undamaged row in a folder, file by file, and a function that reads the row's result."""
    for path in sorted((folder / RECORDS).glob("*.lines")):
        start = 0
        with path.open("rb") as file:
            for line in file:
                if (row := _row_from_line(line)) is not None:
                    yield row[0], partial(_stored_result, path, start)
                start += len(line)


def _stored_result(path: Path, start: int) -> Any:
    """Return the result of the row whose line begins at the byte ``start`` of a file."""
    with path.open("rb") as file:
        file.seek(start)
        row = _row_from_line(file.readline())
    return None if row is None else result_from_json(row[1])
