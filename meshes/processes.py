"""Threads of linear algebra, worker processes, and peak memory on this machine.

Linear algebra runs on one thread: with small matrices, or beside any other busy process, more threads only wait for one
another. The command line, workers and tests call `one_thread` when they begin; a call of the library uses one thread only
until it returns, because the rest of the process is its user's. Work is shared among processes. Variables that the user
has set (`VARIABLES`) take precedence.

Workers end with the process that started them.

Peak memory is that of one piece of work in a process that does several. ``getrusage`` gives the highest memory since the
process began, so that a small run after a large one gets the large one's number. Linux resets that record when asked to
(``/proc/self/clear_refs``); elsewhere nothing is measured.
"""

from __future__ import annotations

import ctypes
import gc
import os
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

#: Variables that the libraries of linear algebra read when they are loaded; the first speaks for all of them.
VARIABLES = tuple(f"{name}_NUM_THREADS" for name in ("OMP", "OPENBLAS", "MKL", "BLIS", "VECLIB_MAXIMUM"))


def for_one_thread() -> dict[str, str]:
    """Environment variables to set for linear algebra on one thread.

    Returns
    -------
    dict[str, str]
        Values by name; only those that the user has not set, and none where the first of `VARIABLES` is set.
    """
    return {} if VARIABLES[0] in os.environ else {name: "1" for name in VARIABLES if name not in os.environ}


def one_thread() -> None:
    """Run linear algebra of this process and its child processes on one thread from now on."""
    if "numpy" in sys.modules:
        for library in _loaded_libraries():
            library.set_num_threads(1)
    os.environ.update(for_one_thread())


@contextmanager
def held_to_one_thread() -> Iterator[None]:
    """Context or decorator that limits linear algebra of this process to one thread for a while."""
    if not for_one_thread():
        yield
        return
    import scipy.linalg  # noqa: F401 - it brings another BLAS, which must be loaded before threads are limited

    libraries = [(library, library.num_threads) for library in _loaded_libraries()]
    for library, _ in libraries:
        library.set_num_threads(1)
    try:
        yield
    finally:
        for library, before in libraries:
            library.set_num_threads(before)


def _loaded_libraries() -> list[Any]:
    """Libraries that are loaded, which read no variable any more, but those that the user has set."""
    left = for_one_thread()
    if not left:
        return []
    from threadpoolctl import ThreadpoolController

    libraries = ThreadpoolController().select(user_api="blas").lib_controllers
    return [library for library in libraries if f"{library.internal_api.upper()}_NUM_THREADS" in left]


#: Seconds between two looks at whether the process that started a worker still lives.
LOOK = 0.5


def local_workers() -> Any:
    """Context of joblib in which ``Parallel`` starts workers on this machine, each with linear algebra on one thread.

    Threads as `VARIABLES` say, where those are set. A worker ends within a second of the process that started it, however
    that ended. On Windows, where a worker cannot know, workers end after five idle minutes.

    Returns
    -------
    context manager
        ``joblib.parallel_config``.
    """
    from joblib import parallel_config

    threads = None if any(name in os.environ for name in VARIABLES) else 1
    return parallel_config(
        backend="loky", inner_max_num_threads=threads, initializer=end_with_parent, initargs=(os.getpid(),)
    )


@contextmanager
def restarts_unsaid() -> Iterator[None]:
    """Suppress joblib's warning about a worker that it restarts because its jobs retain more than 300 MB."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "A worker stopped while some jobs were given")
        yield


def end_with_parent(parent: int) -> None:
    """End this process as soon as its parent is another one than the given process.

    Parameters
    ----------
    parent : int
        Process id of the present parent.
    """
    threading.Thread(target=_wait_for_end, args=(parent,), daemon=True).start()


def _wait_for_end(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK)
    os._exit(1)


#: Whether the record may include earlier work: a reset was asked for and refused.
_stale = False


def reset_peak() -> bool:
    """Start a new record of the highest resident memory of this process.

    Memory that earlier work freed is given back to the system first, as far as the C library can, so that it does not
    count.

    Returns
    -------
    bool
        Whether the system can reset its record.
    """
    global _stale
    gc.collect()
    with suppress(OSError, AttributeError, TypeError):  # another C library than glibc: its free memory counts
        ctypes.CDLL(None).malloc_trim(0)
    try:
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
        _stale = False
    except OSError:
        _stale = True
    return not _stale


def peak_MB() -> float | None:
    """Highest resident memory of this process since `reset_peak`, interpreter and libraries included.

    Returns
    -------
    float | None
        [MB]; None where the system keeps no such record, or did not reset it.
    """
    if _stale:
        return None
    try:
        lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
        return next(float(x.split()[1]) for x in lines if x.startswith("VmHWM")) * 1.024e-3
    except (OSError, StopIteration, ValueError):
        return None
