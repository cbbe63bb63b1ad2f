"""Worker processes end with the process that started them, whatever they are at."""

import os
import signal
import subprocess
import sys
import time

import pytest

PARENT = """
import os, sys, time
from joblib import Parallel, delayed
from rollbench.meshes.workers import local
def work(k):
    os.write(1, f"{os.getpid()}\\n".encode())
    if k == 0:
        time.sleep(120.0)
    return bytes(3_000_000)
with local():
    Parallel(n_jobs=2, batch_size=1, max_nbytes=None)(delayed(work)(k) for k in range(2))
"""
#: The same, as the command line runs it.
COMMAND = f"""
from rollbench.comparison import cli
cli.commands = lambda _: lambda *_, **__: exec({PARENT!r}, {{"__name__": "jobs"}})
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


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="looks for processes in /proc")
@pytest.mark.parametrize(
    ("program", "number", "code"),
    [(PARENT, signal.SIGKILL, -9), (COMMAND, signal.SIGTERM, 143), (COMMAND, signal.SIGINT, 130)],
)
def test_no_worker_outlives_the_process_that_started_it(program, number, code):
    """One worker is at work, the other has a result that is too large for a pipe that nobody reads."""
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as parent:
        workers = [int(parent.stdout.readline()) for _ in range(2)]
        os.kill(parent.pid, signal.SIGSTOP)
        time.sleep(0.2)
        os.kill(parent.pid, number)
        os.kill(parent.pid, signal.SIGCONT)
        assert left(workers, 10.0) == []
        told = parent.communicate()[1].decode()
    assert parent.returncode == code
    if code > 0:
        assert told == "rollbench: interrupted; nothing was left half-written\n"
