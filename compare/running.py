"""Checks before long computations (gmsh, packages, memory), progress messages on the terminal, and a time limit."""

from __future__ import annotations

import os
import platform
import re
import select
import shutil
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic

from rollbench.compare.errors import ArgumentError, InputError
from rollbench.meshes import libraries


def gmsh_fault() -> str:
    """Return the reason why gmsh cannot be loaded, with the missing shared libraries; empty if it can be loaded."""
    reason = libraries.reason_of_failed_import("gmsh")
    if not reason or libraries.installed_version("gmsh") is None:
        return reason
    lacking = [name for name in libraries.missing_system_libraries(libraries.MESHING) if name not in reason]
    return reason + (f"; also missing: {', '.join(lacking)}" if lacking else "")


def gmsh_install_advice() -> str:
    """Return advice on how to install gmsh, or the shared libraries that it lacks."""
    installed = libraries.installed_version("gmsh") is not None
    return libraries.apt_command(libraries.MESHING) if installed else libraries.pip_command("gmsh")


def check_gmsh() -> None:
    """Raise InputError if gmsh cannot be loaded."""
    if reason := gmsh_fault():
        raise _missing_package_error("gmsh", reason)


def check_packages(*packages: str) -> None:
    """Raise InputError for the first of the Python packages that cannot be imported."""
    for package in packages:
        if reason := libraries.reason_of_failed_import(package):
            raise _missing_package_error(package, reason)


def input_error_of_failed_import(error: ImportError) -> InputError | None:
    """Return the InputError for an import that failed because an optional package is missing; None for another import."""
    package = libraries.optional_package_of_module(error.name)
    reason = gmsh_fault() if package == "gmsh" else libraries.reason_of_failed_import(package) if package else ""
    return _missing_package_error(package, reason or str(error)) if package else None


def _missing_package_error(package: str, reason: str) -> InputError:
    """Return the InputError for a missing Python package; ``reason``: why it cannot be imported, in words."""
    if package == "gmsh":
        advice = f"{gmsh_install_advice()}, or use commands without the 3D reference; rollbench doctor lists what works"
        return InputError("this computer", "gmsh", reason, "gmsh with its shared libraries", advice)
    advice = f"{libraries.pip_command(package)}; rollbench doctor lists what works without it"
    return InputError("this computer", package, reason, "an installed package, which this command needs", advice)


def check_reference_programs() -> None:
    """Raise InputError if gmsh or a package that the 3D reference needs cannot be used."""
    check_gmsh()
    check_packages(*libraries.REFERENCE)


def package_versions(packages: Sequence[str]) -> str:
    """Return a text with the names of packages and their installed versions, such as "numpy 2.1, gmsh not installed"."""
    return ", ".join(f"{name} {libraries.installed_version(name) or 'not installed'}" for name in packages)


def machine_description() -> str:
    """Return a text with the processor and the number of cores of this computer."""
    cpu = platform.processor() or platform.machine()
    with suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        cpu = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), cpu)
    return f"{cpu}, {os.cpu_count()} cores"


def usable_cores() -> int:
    """Return the number of processor cores that this process is allowed to use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def out_of_memory_error(reason: object) -> InputError:
    """Return the InputError for a computation that needs more memory than this computer has.

    ``reason``: the error that was raised for lack of memory.
    """
    advice = "end other programs, choose a coarser mesh level or fewer workers, or use a cluster (`backend=dask`)"
    return InputError("this computer", "memory", str(reason) or "no free memory", "enough memory for the run", advice)


def available_GB(proc: Path = Path("/proc/meminfo"), group: Path = Path("/sys/fs/cgroup")) -> float | None:
    """Return the memory that this process can still use without swapping [GB]; None if not known.

    ``proc``: file with the free memory of the computer; ``group``: folder of the control group, whose limit counts, too.
    """
    limits = []
    with suppress(OSError, ValueError, StopIteration):
        lines = proc.read_text(encoding="ascii").splitlines()
        limits.append(1.024e-6 * float(next(line.split()[1] for line in lines if line.startswith("MemAvailable"))))
    with suppress(OSError, ValueError):  # "max": no limit
        limit, used = ((group / name).read_text(encoding="ascii") for name in ("memory.max", "memory.current"))
        limits.append(max(1e-9 * (float(limit) - float(used)), 0.0))
    return min(limits, default=None)


#: Time until the first message that a computation is still running, and time between two such messages [s].
FIRST, AGAIN = 2.0, 1.0

#: Characters of a full progress bar; control sequence that erases the line; start of the process, for the time left.
BAR, ERASE, START = 24, "\r\033[K", monotonic()
_drawn = False
#: Without a terminal: largest number of stages of which each gets a line, and least time between other lines [s].
STAGES, SELDOM = 100, 30.0
_logged, _last = START, ""

#: Environment variable that leaves out all progress with the value "off"; warnings stay.
PROGRESS = "ROLLBENCH_PROGRESS"

#: Exit code of a command that the time limit ends; it is the same as for a scene without equilibrium.
ENDED = 1


def checked_time_limit(limit: float | None) -> float | None:
    """Return the time limit ``limit`` [s] (None: no limit); InputError unless it is above 0 s and at most 1e9 s."""
    if limit is not None and not 0.0 < limit <= 1e9:
        raise ArgumentError("time_limit", str(limit), "above 0 to 1e9 seconds", "state a time in seconds, such as 60")
    return limit


@contextmanager
def watch_running_time(label: str, limit: float | None = None) -> Iterator[None]:
    """Show how long the computation ``label`` has been running, and end the process after ``limit`` [s] (None: never).

    The process ends at once, even inside a function of a library, which cannot be interrupted otherwise. So the ``with``
    block must not write files.
    """
    done = threading.Event()
    watcher = threading.Thread(target=_show_running_time, args=(label, limit, done), daemon=True)
    watcher.start()
    try:
        yield
    finally:
        done.set()
        watcher.join()


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[str, float], None]]:
    """Show a progress bar on the terminal while the computation ``label`` runs.

    Yields a function that updates the bar; its arguments are a text and the share of the work that is done (0 to 1).
    Nothing is shown if standard error is no terminal, or in the first two seconds (`FIRST`).
    """
    begin = monotonic()

    def show(what: str, share: float) -> None:
        """Draw the bar with the text ``what`` and the ``share`` of the work that is done (0 to 1)."""
        if monotonic() - begin >= FIRST and sys.stderr.isatty() and not _is_progress_off():
            _draw_progress_line(f"{label}: {what}{_remaining_time_text(monotonic() - begin, share)}", share)

    try:
        yield show
    finally:
        clear_progress_line()


def show_progress_message(text: str) -> None:
    """Show a progress message on standard error.

    On a terminal, a text that states a share of work, such as ``[3/12]`` or ``34%``, replaces the progress line, with a bar
    and the time left; other texts are printed above this line. In a file or pipe, texts that begin with WARNING are printed
    and, after the first two seconds (`FIRST`), a line for each stage. Of texts that are indented, count many steps or
    differ from the last line in numbers only, one in half a minute is printed. With ROLLBENCH_PROGRESS=off in the
    environment, only warnings are printed.

    Parameters
    ----------
    text
        The message.
    """
    global _drawn
    if _is_progress_off() and not text.startswith("WARNING"):
        return
    found = re.search(r"\[(\d+)/(\d+)\]|(\d+)%", text)
    if not sys.stderr.isatty():
        if text.startswith("WARNING") or _is_due_in_log(text, found):
            _write_to_stderr(f"rollbench: {text.strip()}\n")
        return
    if found is None:  # above the line of progress, which another process may have drawn
        _write_to_stderr(f"{ERASE * sys.stderr.isatty()}rollbench: {text}\n")
        _drawn = False
        return
    done, of, percent = (int(x or 0) for x in found.groups())
    share = done / of if of else percent / 100.0
    _draw_progress_line(text + ("" if " left" in text else _remaining_time_text(monotonic() - START, share)), share)


def restart_clock() -> None:
    """Count the time of the present command from now: called when a command begins."""
    global START
    START = monotonic()


def _is_progress_off() -> bool:
    """Return whether the environment leaves out progress."""
    return os.environ.get(PROGRESS) == "off"


def _is_due_in_log(text: str, share: re.Match[str] | None) -> bool:
    """Return whether a progress message is printed in a file or pipe; ``share``: share of work that it states, or None."""
    global _logged, _last
    now, words, stage = monotonic(), re.sub(r"[\d.]+", "", text), not text.startswith(" ")
    if share is not None:
        stage = share[2] is not None and int(share[2]) <= STAGES
    if now - START < FIRST or not ((stage and words != _last) or now - _logged >= SELDOM):
        return False
    _logged, _last = now, words
    return True


def clear_progress_line() -> None:
    """Erase the progress line on the terminal; called before anything else is printed."""
    global _drawn
    if _drawn and sys.stderr.isatty():
        _write_to_stderr(ERASE)
    _drawn = False


def format_duration(seconds: float) -> str:
    """Format a duration as a rounded number with its unit.

    Parameters
    ----------
    seconds
        The duration [s].

    Returns
    -------
    str
        Text with number and unit: s, min or h.

    Examples
    --------
    >>> format_duration(42.0), format_duration(600.0), format_duration(9000.0)
    ('40 s', '10 min', '2.5 h')
    """
    if seconds < 90.0:
        return f"{10 * max(round(seconds / 10), 1)} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400.0 else f"{seconds / 3600:.1f} h"


def _remaining_time_text(spent: float, share: float) -> str:
    """Return a text with the remaining time, from the time spent [s] and the share of work done; empty if not known."""
    return f", about {format_duration(spent * (1.0 - share) / share)} left" if 0.0 < share < 1.0 else ""


def _draw_progress_line(text: str, share: float | None = None) -> None:
    """Draw the progress line on standard error, with a bar if the share of work done (0 to 1) is known."""
    global _drawn
    full = round(BAR * (share or 0.0))
    line = text if share is None else f"[{'#' * full}{'.' * (BAR - full)}] {text}"
    _write_to_stderr(ERASE + line[: shutil.get_terminal_size((80, 24)).columns - 1])
    _drawn = True


def output_closed(outputs: Sequence[int] = (1, 2)) -> bool:
    """Return whether standard output or error is a pipe whose reader has ended, as in ``| head``.

    ``outputs``: numbers of the checked outputs, 1 for standard output, 2 for standard error.
    """
    if not hasattr(select, "poll"):
        return False
    poll = select.poll()
    for number in outputs:
        poll.register(number, 0)
    return any(event & select.POLLERR for _, event in poll.poll(0))


def _show_running_time(label: str, limit: float | None, done: threading.Event) -> None:
    """Show the running time on the terminal until ``done`` is set; end the process at the time limit ``limit`` [s]."""
    begin = monotonic()
    while True:
        spent = monotonic() - begin
        if limit is not None and spent >= limit:
            clear_progress_line()
            _write_to_stderr(f"rollbench: {label}: stopped, because the time limit of {limit:g} s is reached\n")
            sys.stdout.flush()
            os._exit(ENDED)
        pause = max(FIRST - spent, AGAIN) if spent < FIRST else AGAIN
        if done.wait(pause if limit is None else min(pause, limit - spent)):
            break
        if monotonic() - begin >= FIRST and sys.stderr.isatty() and not _is_progress_off():
            _draw_progress_line(f"rollbench: {label}: running for {monotonic() - begin:.0f} s")
    clear_progress_line()


def _write_to_stderr(text: str) -> None:
    """Write a text to standard error, and ignore the error if that is closed."""
    with suppress(OSError, ValueError):  # nobody reads it any more
        sys.stderr.write(text)
        sys.stderr.flush()
