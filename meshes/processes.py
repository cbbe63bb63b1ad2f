"""Number of threads for linear algebra, worker processes, and measurement of peak memory.

Linear algebra uses one thread: for small matrices, or on a busy machine, several threads only wait for one another. The
command line, workers and tests call `limit_to_one_thread` at their start. A call of the library limits threads only until
it returns, because the rest of the process belongs to the caller. Parallel work is done by several processes. Environment
variables that the user has set (`VARIABLES`) take precedence.

Worker processes end when the process that started them ends.

The peak memory is that of one computation in a process that does several. ``getrusage`` gives the largest memory since the
start of the process, so that a small computation after a large one would get the number of the large one. Linux can reset
this record (``/proc/self/clear_refs``); on other systems the peak memory is not measured.
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

#: Environment variables that libraries for linear algebra read when they are loaded; the first variable holds for all of
#: these libraries.
VARIABLES = tuple(f"{name}_NUM_THREADS" for name in ("OMP", "OPENBLAS", "MKL", "BLIS", "VECLIB_MAXIMUM"))


def one_thread_environment() -> dict[str, str]:
    """Return the environment variables that still have to be set so that linear algebra uses one thread.

    Returns
    -------
    dict[str, str]
        Values by the variables' names, without variables that the user has set; empty where the first of `VARIABLES` is
        set.
    """
    return {} if VARIABLES[0] in os.environ else {name: "1" for name in VARIABLES if name not in os.environ}


def limit_to_one_thread() -> None:
    """Limit linear algebra of this process, and of child processes started from now on, to one thread."""
    if "numpy" in sys.modules:
        for library in _loaded_blas_libraries():
            library.set_num_threads(1)
    os.environ.update(one_thread_environment())


@contextmanager
def limited_to_one_thread() -> Iterator[None]:
    """Limit linear algebra of this process to one thread during a ``with`` block, or a call of a decorated function."""
    if not one_thread_environment():
        yield
        return
    import scipy.linalg  # noqa: F401 - scipy loads another BLAS, which must be loaded before threads are limited

    libraries = [(library, library.num_threads) for library in _loaded_blas_libraries()]
    for library, _ in libraries:
        library.set_num_threads(1)
    try:
        yield
    finally:
        for library, before in libraries:
            library.set_num_threads(before)


def _loaded_blas_libraries() -> list[Any]:
    """Return those loaded libraries for linear algebra (BLAS) whose number of threads the user has not set.

    A loaded library does not read environment variables any more, so that its number of threads must be set directly.
    """
    left = one_thread_environment()
    if not left:
        return []
    from threadpoolctl import ThreadpoolController

    libraries = ThreadpoolController().select(user_api="blas").lib_controllers
    return [library for library in libraries if f"{library.internal_api.upper()}_NUM_THREADS" in left]


#: Interval [s] at which a worker checks whether the process that started it is still running.
LOOK = 0.5


def single_thread_workers() -> Any:
    """Return a context manager in which joblib's ``Parallel`` starts worker processes, each with one thread.

    Where the user has set `VARIABLES`, these give the number of threads. A worker ends within a second after the process
    that started it, for whatever reason that process ended. On Windows, where a worker cannot detect this, workers end
    after five idle minutes.

    Returns
    -------
    context manager
        Result of ``joblib.parallel_config``.
    """
    from joblib import parallel_config

    threads = None if any(name in os.environ for name in VARIABLES) else 1
    return parallel_config(
        backend="loky", inner_max_num_threads=threads, initializer=end_process_with_parent, initargs=(os.getpid(),)
    )


@contextmanager
def without_restart_warnings() -> Iterator[None]:
    """Suppress joblib's warning about a worker that it restarts because its memory has grown by more than 300 MB."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "A worker stopped while some jobs were given")
        yield


def end_process_with_parent(parent_id: int) -> None:
    """Start a thread that ends this process as soon as its parent process has ended.

    Parameters
    ----------
    parent_id : int
        Process id of the present parent process.
    """
    threading.Thread(target=_wait_for_parent_to_end, args=(parent_id,), daemon=True).start()


def _wait_for_parent_to_end(parent_id: int) -> None:
    """Wait until this process has another parent than ``parent_id``, because that one has ended; then end this process."""
    while os.getppid() == parent_id:
        time.sleep(LOOK)
    os._exit(1)


#: Whether the system's record of peak memory may include earlier computations, because resetting it failed.
_stale = False


def reset_peak_memory() -> bool:
    """Reset the system's record of the largest resident memory of this process.

    Before this, freed memory is returned to the system, where the C library can do so; otherwise it would be counted.

    Returns
    -------
    bool
        Whether the system has reset its record.
    """
    global _stale
    gc.collect()
    with suppress(OSError, AttributeError, TypeError):  # a C library other than glibc: freed memory is counted
        ctypes.CDLL(None).malloc_trim(0)
    try:
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
        _stale = False
    except OSError:
        _stale = True
    return not _stale


def peak_memory_MB() -> float | None:
    """Return the largest resident memory of this process since `reset_peak_memory`, including interpreter and libraries.

    Returns
    -------
    float | None
        Memory [MB]; None where the system does not record it, or the record was not reset.
    """
    if _stale:
        return None
    try:
        lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
        return next(float(x.split()[1]) for x in lines if x.startswith("VmHWM")) * 1.024e-3
    except (OSError, StopIteration, ValueError):
        return None
