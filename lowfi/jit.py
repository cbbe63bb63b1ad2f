"""Numerical kernels (functions with the loops of a solver), run as plain Python or as machine code compiled by numba.

Plain Python has no start-up cost and suits one small solve; machine code suits many solves.

A kernel package (a folder named ``kernel``) is written in the subset of Python that numba compiles.
``load_kernel_package(package, compiled=False)`` is the package itself; ``compiled=True`` loads the same files a second time
under another name, where the decorator ``kernel`` compiles. Named tuples that kernels take or return are in
``kernel_types.py`` next to that folder, because the plain and the compiled package must use the same classes. numba gives a
literal number or truth value in a call another type than a variable, and compiles the called kernel once for each type:
where calls would differ so, ``int(np.int64(60))`` or ``bool(np.bool_(False))`` is passed instead of the literal.

This module ensures that

* a single solve compiles nothing, even with an empty cache: the solver asks `is_machine_code_cached` and `is_copy_loaded`
  whether machine code exists, runs plain Python if not, and may register a job (`register_compile_job`) that compiles the
  kernels after the result is printed;
* outdated machine code is never used: it is stored in the user's cache under a digest of the sources of all kernels,
  because numba compares only the file of the function itself. As machine code is executed, only the user may write to its
  folder;
* an interrupt while numba compiles is safe: it takes effect when the current kernel is compiled.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import os
import shutil
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from rollbench.meshes.files import create_private_folder

F = TypeVar("F", bound=Callable[..., Any])

#: Names of the kernel packages, each with the names of the packages whose kernels it calls.
PACKAGES: dict[str, tuple[str, ...]] = {
    "rollbench.lowfi.statics.kernel": (),
    "rollbench.lowfi.friction.contact.kernel": (),
    "rollbench.lowfi.friction.linear.kernel": ("rollbench.lowfi.friction.contact.kernel",),
    "rollbench.lowfi.friction.screw.kernel": ("rollbench.lowfi.friction.contact.kernel",),
    "rollbench.lowfi.random_errors.kernel": (),
}
STATICS, CONTACT, LINEAR, SCREW, RANDOM_ERRORS = PACKAGES
#: Part of the module names of a compiled copy, by which it is recognised.
_MARK = "_compiled_"
#: Number of folders of machine code, one for each version of the sources, that stay in the user's cache: those used last.
_KEPT = 4


def is_compiled_module(module_name: str) -> bool:
    """Return whether a module, given by its name, belongs to a copy of a kernel package that numba compiles."""
    return _MARK in module_name


def kernel(function: F) -> F:
    """Decorate a kernel (a function with numerical loops): in a compiled copy of its package, numba compiles it.

    In the plain package the function is returned unchanged.
    """
    if not is_compiled_module(function.__module__):
        return function
    import numba

    _delay_signals_while_compiling()
    compiled_function: F = numba.njit(cache=machine_code_folder() is not None, nogil=True, error_model="numpy")(function)
    return compiled_function


def load_kernel_package(package: str, *, compiled: bool) -> ModuleType:
    """Return a kernel package as a module, in plain Python or with its functions compiled by numba.

    A kernel is a function with the numerical loops of a solver. The compiled copy is loaded once in a process, and each
    kernel is compiled at its first call. If numba is missing, the plain package is returned and a message is printed on
    standard error.

    Parameters
    ----------
    package
        Name of a kernel package in ``PACKAGES``.
    compiled
        Whether the kernels are compiled.

    Raises
    ------
    KeyError
        The name is not in ``PACKAGES``.
    """
    used = PACKAGES[package]
    if not (compiled and _numba_works()):
        return importlib.import_module(package)
    for other in used:
        _load_compiled_copy(other)
    return _load_compiled_copy(package)


@cache
def _numba_works() -> bool:
    """Return whether numba can be imported; print a message on standard error if it cannot."""
    from rollbench.meshes.libraries import ONLY_FOR, pip_command, reason_of_failed_import

    missing = reason_of_failed_import("numba")
    if missing:
        sys.stderr.write(f"rollbench: {missing}: {ONLY_FOR['numba']}; {pip_command('numba')}\n")
    return not missing


def _compiled_module_name(package: str) -> str:
    """Return the module name under which the compiled copy of a kernel package is loaded."""
    return f"rollbench.lowfi.{_MARK}{package.removeprefix('rollbench.lowfi.').replace('.', '_')}"


def _package_folder(package: str) -> Path:
    """Return the folder with the source files of a kernel package."""
    return Path(__file__).parents[1].joinpath(*package.split(".")[1:])


@cache
def _load_compiled_copy(package: str) -> ModuleType:
    """Load the source files of a kernel package a second time, as the copy whose functions numba compiles."""
    with _set_numba_cache_folder(package):
        return _load_source_file_as_module(_compiled_module_name(package), _package_folder(package) / "__init__.py")


def _load_source_file_as_module(name: str, path: Path, **given: Any) -> ModuleType:
    """Load a source file as a module of a given name; an ``__init__.py`` becomes a package.

    The keyword arguments are global variables that the module has before its code runs. Raises ImportError if the file
    cannot be loaded.
    """
    inside = [str(path.parent)] if path.name == "__init__.py" else None
    spec = importlib.util.spec_from_file_location(name, path, submodule_search_locations=inside)
    if spec is None or spec.loader is None:
        raise ImportError(f"the source file {path} of numerical kernels cannot be loaded as a Python module")
    module = importlib.util.module_from_spec(spec)
    vars(module).update(given)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def load_solver_copy(system: str, solver_file: str) -> ModuleType:
    """Load a separate copy of a solver's source file for one system of equations, so that numba can cache its machine code.

    ``system``: name of the module with the functions of the equations (energy, gradient, ...); ``solver_file``: name of the
    solver's file in the same folder, without its suffix. The copy gets the module as its global ``system``. Passing the
    functions as arguments instead would need closures, whose machine code numba does not cache.
    """
    of = sys.modules[system]
    return _load_source_file_as_module(
        f"{system}_{solver_file}", Path(str(of.__file__)).with_name(f"{solver_file}.py"), system=of
    )


# A single solve compiles no kernel


def is_copy_loaded(package: str) -> bool:
    """Return whether this process has already loaded the compiled copy of a kernel package."""
    return _compiled_module_name(package) in sys.modules


def is_machine_code_cached(package: str = "") -> bool:
    """Return whether the user's cache holds machine code of a kernel package in its present version.

    Parameters
    ----------
    package
        Name of a kernel package; empty for any package.
    """
    folder = machine_code_folder()
    return folder is not None and any(folder.glob(f"{package or '*'}/*/*.nbi"))


#: Jobs that compile the kernels of a package (the key) after the result is printed, for later commands.
_afterwards: dict[str, Callable[[], object]] = {}


def register_compile_job(package: str, job: Callable[[], object]) -> None:
    """Register a function that calls, and so compiles, the kernels of a package after the result of a command is printed.

    Commands call `run_compile_jobs` last, which calls the registered functions. ``package``: name of the kernel package;
    ``job``: function without arguments.
    """
    _afterwards[package] = job


def run_compile_jobs() -> None:
    """Run the registered jobs; they compile, for later processes, the kernels that this process ran as plain Python."""
    while _afterwards:
        _afterwards.popitem()[1]()


# Machine code of outdated sources is never used


@cache
def digest_of_kernel_sources() -> str:
    """Return a digest (20 hexadecimal digits) of the sources of all kernels, their argument types and this module."""
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for package in PACKAGES:
        folder = _package_folder(package)
        for source in (*sorted(folder.glob("*.py")), *folder.parent.glob("kernel_types.py")):
            digest.update(source.read_bytes())
    return digest.hexdigest()[:20]


@cache
def machine_code_folder() -> Path | None:
    """Return the folder for machine code of the present sources, in NUMBA_CACHE_DIR or in the user's cache of rollbench.

    Folders of other versions of the sources are removed, except those used last. Returns None if the cache is switched off
    (ROLLBENCH_CACHE=off). Also returns None, with a message on standard error, if the folder cannot be written to or if
    others can write to it. Every process then compiles again.
    """
    from rollbench.meshes.cache import default_cache_folder

    named = os.environ.get("NUMBA_CACHE_DIR", "").strip()
    root = Path(named) if named else default_cache_folder()
    if root is None:
        return None
    try:
        folder = create_private_folder(root, "kernels", digest_of_kernel_sources())
        os.utime(folder)
        if not os.access(folder, os.W_OK):
            raise PermissionError(13, os.strerror(13), str(folder))
    except OSError as error:
        advice = "set ROLLBENCH_CACHE to a folder that only you can write to"
        sys.stderr.write(f"rollbench: compiled kernels are not stored: {error.filename}: {error.strerror}; {advice}\n")
        return None
    with suppress(OSError):
        for old in sorted(folder.parent.iterdir(), key=lambda f: -f.stat().st_mtime)[_KEPT:]:
            shutil.rmtree(old, ignore_errors=True)
    return folder


@contextmanager
def _set_numba_cache_folder(package: str) -> Iterator[None]:
    """Set numba's cache folder to that of a kernel package during a ``with`` block.

    The kernels of the package are declared in the block; each remembers this folder.
    """
    import numba

    before, folder = numba.config.CACHE_DIR, machine_code_folder()
    if folder is not None:
        numba.config.CACHE_DIR = str(folder / package)
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before


# An interrupt while numba compiles is safe


@cache
def _delay_signals_while_compiling() -> None:
    """Delay the signals INT and TERM (if Python handles them) until numba has compiled the current kernel.

    An exception raised during compilation is swallowed by llvmlite's callbacks, or ends in a segmentation fault.
    """
    from numba.core import event

    class SignalHold(event.Listener):  # type: ignore[misc]
        """Listener that withholds signals while the main thread, the only one that handles them, has numba's lock."""

        def __init__(self) -> None:
            """Create a listener that has not yet withheld a signal."""
            self.depth = 0
            self.came: list[int] = []
            self.before: dict[int, Any] = {}

        def on_start(self, event: Any) -> None:
            """Replace the signal handlers by `note_signal` when numba takes its lock."""
            if event.kind == KERNEL:
                _print_compilation_notice()
            if event.kind == LOCK and threading.current_thread() is threading.main_thread():
                self.depth += 1
                if self.depth == 1:
                    handled = (number for number in (signal.SIGINT, signal.SIGTERM) if callable(signal.getsignal(number)))
                    self.before = {number: signal.signal(number, self.note_signal) for number in handled}

        def note_signal(self, number: int, _: object) -> None:
            """Record a signal instead of handling it, and print when it will take effect."""
            self.came.append(number)
            sys.stderr.write("rollbench: interrupted: the program ends as soon as numba has compiled the current kernel\n")

        def on_end(self, event: Any) -> None:
            """Restore the signal handlers when numba releases its lock, and raise the first signal that arrived."""
            if threading.current_thread() is threading.main_thread():
                self.depth -= event.kind == LOCK
                if self.depth == 0 or (self.came and event.kind == KERNEL):
                    while self.before:
                        signal.signal(*self.before.popitem())
                    came, self.came = self.came, []
                    if came:
                        signal.raise_signal(came[0])

    LOCK, KERNEL = "numba:compiler_lock", "numba:compile"
    hold = SignalHold()
    event.register(LOCK, hold)
    event.register(KERNEL, hold)


@cache
def _print_compilation_notice() -> None:
    """Print, before the first kernel is compiled, that this takes a while; only in the main process, on a terminal."""
    import multiprocessing

    if multiprocessing.parent_process() is None and sys.stderr.isatty():
        sys.stderr.write("rollbench: compiling kernels, once on this machine: 20 to 60 s\n")
