"""The folder of a sweep: what is swept, and one line a sample, appended when its batch is solved and never touched again.

Every process writes lines to a file of its own, those of a batch in one call and each with a checksum, so that whatever
moment a process is killed at, every finished batch is there and a torn line is told from a whole one. A process that
outlives the run it belonged to stops after its batch: the run's token is no longer the folder's. A new run waits, by a lock
that each process holds while it solves, until such processes have stopped; only then it reads what there is, so that no
sample is solved twice.
"""

from __future__ import annotations

import json
import os
import platform
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from time import monotonic
from typing import Any
from uuid import uuid4

from rollbench.compare.errors import ArgumentError
from rollbench.compare.files import replace_file

HEADER, TOKEN, LOCKS, RECORDS = "sweep.json", "token", "locks", "records"
#: Longest wait for processes of an earlier run [s].
PATIENCE = 600.0

Record = dict[str, Any]


def open_folder(folder: Path, header: Mapping[str, Any]) -> None:
    """Make the folder that of this sweep. Raises InputError where it is another's, or cannot be written to."""
    path = folder / HEADER
    text = json.dumps(header, indent=1, ensure_ascii=False) + "\n"
    advice = "choose another folder for another sweep"
    if path.exists():
        if path.read_text(encoding="utf-8") != text:
            raise ArgumentError(
                "out", "the folder of another sweep", "a new one, or that of this sweep", advice, str(folder)
            )
    else:
        if folder.exists() and any(folder.iterdir()):
            raise ArgumentError("out", "a folder with other files", "a new one, or that of this sweep", advice, str(folder))
        replace_file(path, text)
    (folder / RECORDS).mkdir(exist_ok=True)
    (folder / LOCKS).mkdir(exist_ok=True)


@contextmanager
def taken_over(folder: Path) -> Iterator[str]:
    """Take the folder for a run: its token, once no process of an earlier run writes any more.

    Raises InputError where another run is at work in it.
    """
    from filelock import FileLock, Timeout

    with ExitStack() as held:
        try:
            held.enter_context(FileLock(folder / "run", timeout=0))
        except Timeout:
            advice = "wait for it, or end it"
            raise ArgumentError("out", "a sweep under way", "one run at a time", advice, str(folder)) from None
        token = uuid4().hex
        replace_file(folder / TOKEN, token)
        _wait_for_others(folder)
        yield token


def _wait_for_others(folder: Path) -> None:
    """Wait for the processes of earlier runs, and remove their locks."""
    from filelock import FileLock, Timeout

    until = monotonic() + PATIENCE
    for path in (folder / LOCKS).iterdir():
        try:
            with FileLock(path, timeout=max(until - monotonic(), 0.0), poll_interval=0.02):
                path.unlink(missing_ok=True)
        except Timeout:
            advice = "end the processes of the earlier run"
            raise ArgumentError("out", "processes of an earlier run", "none", advice, str(folder)) from None


@contextmanager
def working(folder: Path) -> Iterator[None]:
    """Keep a new run waiting while this process solves samples."""
    from filelock import FileLock

    with FileLock(folder / LOCKS / _process()):
        yield


def _process() -> str:
    """This process on this machine, as part of a file's name."""
    return f"{platform.node()}-{os.getpid()}"


def current(folder: Path, token: str) -> bool:
    """Whether the folder is here and belongs to the run of ``token``."""
    try:
        return (folder / TOKEN).read_text(encoding="utf-8") == token
    except OSError:
        return False


class Writer:
    """Appends records to a file of this process's own."""

    def __init__(self, folder: Path, token: str) -> None:
        """Open the file when the first record comes."""
        self._path = folder / RECORDS / f"{token[:8]}-{_process()}.lines"

    def append(self, records: Sequence[Record]) -> None:
        """Append records in one call. Raises OSError where the disk does not take them."""
        lines = b"".join(map(packed, records))
        handle = os.open(self._path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0), 0o644)
        try:
            if os.write(handle, lines) != len(lines):
                raise OSError(28, "records were not written whole", str(self._path))
        finally:
            os.close(handle)


def packed(record: Record) -> bytes:
    """A record as a line with its checksum."""
    body = json.dumps(record, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode()
    return b"%08x %s\n" % (zlib.crc32(body), body)


def unpacked(line: bytes) -> Record | None:
    """The record of a line; None for one that is torn or damaged."""
    checksum, _, body = line.rstrip(b"\n").partition(b" ")
    if not line.endswith(b"\n") or checksum != b"%08x" % zlib.crc32(body):
        return None
    found: Record = json.loads(body)
    return found


def read(folder: Path) -> Iterator[Record]:
    """All whole records of a folder, file by file."""
    for path in sorted((folder / RECORDS).glob("*.lines")):
        with path.open("rb") as file:
            for line in file:
                record = unpacked(line)
                if record is not None:
                    yield record


def load(folder: Path) -> dict[int, Record]:
    """Records by the sample's number from 0."""
    return {int(record["sample"]): record for record in read(folder)}
