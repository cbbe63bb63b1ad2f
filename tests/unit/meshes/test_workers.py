"""Worker processes end with the process that started them, whatever they are at; peak memory of one piece of work."""

import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

from rollbench.meshes import processes

PARENT = """
import os, sys, time
from joblib import Parallel, delayed
from rollbench.meshes.processes import single_thread_workers
def work(k):
    os.write(1, f"{os.getpid()}\\n".encode())
    if k == 0:
        time.sleep(120.0)
    return bytes(3_000_000)
with single_thread_workers():
    Parallel(n_jobs=2, batch_size=1, max_nbytes=None)(delayed(work)(k) for k in range(2))
"""
#: Parts of a set-up, of which a helper makes the first and the parent the other, for so many seconds.
SET_UP = """
from rollbench.hifi.setup import RecordJob, compute_records
from rollbench.meshes.cache import Cache
work = "print(__import__('os').getpid(), flush=True), __import__('time').sleep({})"
compute_records([RecordJob("any", eval, (work.format(seconds),), tuple) for seconds in (120.0, OWN)], Cache(None), 2)
"""


def command(program: str) -> str:
    """A program as the command line runs it."""
    return f"""
from rollbench.compare import cli
cli.app_with_commands = lambda _: lambda *_, **__: exec({program!r}, {{"__name__": "jobs"}})
cli.main([])
"""


def alive(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def left(workers: list[int], seconds: float) -> list[int]:
    """Workers that still live after so many seconds at most."""
    end = time.monotonic() + seconds
    while any(map(alive, workers)) and time.monotonic() < end:
        time.sleep(0.05)
    return [pid for pid in workers if alive(pid)]


PROGRAMS = {
    "workers": PARENT,
    "at its own part of a set-up": SET_UP.replace("OWN", "120.0"),
    "waiting for the other part": SET_UP.replace("OWN", "0.0"),
}


@pytest.mark.slow
@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="looks for processes in /proc")
@pytest.mark.parametrize(
    ("name", "number", "code"),
    [*((name, signal.SIGKILL, -9) for name in PROGRAMS), ("workers", signal.SIGTERM, 143), ("workers", signal.SIGINT, 130)],
)
def test_no_worker_outlives_the_process_that_started_it_and_nobody_waits_for_its_part(name, number, code):
    """Both processes that a program prints are gone soon after its end. One worker is at work, the other has a result that
    is too large for a pipe that nobody reads, as their parent does nothing meanwhile."""
    program, stopped = PROGRAMS[name] if number == signal.SIGKILL else command(PROGRAMS[name]), name == "workers"
    heard = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)  # what runs in the background of a shell ignores it
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", program], preexec_fn=heard, **pipes) as parent:
        workers = [int(parent.stdout.readline()) for _ in range(2)]
        if stopped:
            os.kill(parent.pid, signal.SIGSTOP)
        time.sleep(0.2)
        os.kill(parent.pid, number)
        if stopped:
            os.kill(parent.pid, signal.SIGCONT)
        lasting = left(workers, 60.0)
        for pid in lasting:
            os.kill(pid, signal.SIGKILL)
        assert lasting == []
        error = parent.communicate()[1].decode()
    assert parent.returncode == code
    if code > 0:
        assert error == "rollbench: interrupted; nothing was left half-written\n"


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the record can be started again on Linux only")
def test_every_piece_of_work_has_its_own_peak(monkeypatch: pytest.MonkeyPatch) -> None:
    """And none is quoted where the record could not be started anew."""
    assert processes.reset_peak_memory()
    before = processes.peak_memory_MB()
    np.ones(40_000_000).sum()
    large = processes.peak_memory_MB()
    assert processes.reset_peak_memory()
    np.ones(5_000_000).sum()
    small = processes.peak_memory_MB()
    assert large - before > 250.0
    assert small < large - 200.0
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_text", Mock(side_effect=PermissionError))
        assert (processes.reset_peak_memory(), processes.peak_memory_MB()) == (False, None)
    assert processes.reset_peak_memory()
