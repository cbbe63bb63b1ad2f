"""Kernels as plain Python (no start-up cost: one small solve) or compiled by numba (many), from one source.

A kernel package (a folder named ``kernel``) is written in the subset of Python that numba compiles. ``kernels(package,
compiled=False)`` is the package itself; ``compiled=True`` loads the same files a second time under another name, where the
decorator ``kernel`` compiles. Named tuples that kernels take or return are in ``kernel_types.py`` next to that folder:
both copies must mean the same classes. To numba a number or truth value written out in a call has a type different from
that of a variable, and the called kernel is compiled for each of them: where calls differ, ``int(np.int64(60))`` or
``bool(np.bool_(False))`` is passed instead.

What this module is for:

* One solve compiles nothing, even without any cache: code that solves once asks by `is_machine_code_cached` and `is_copy_loaded` whether machine
  code is there, takes plain Python where it is not, and may have it compiled once the result is printed (`register_compile_job`).
* Stale machine code is never used: it is in the user's cache under a digest of the sources of all kernels, as numba itself
  looks only at the file of a function, in a folder that nobody else may write to, as it is executed.
* An interrupt while numba compiles is safe: it waits until the kernel at hand is compiled.
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

from rollbench.meshes.private import private_folder

F = TypeVar("F", bound=Callable[..., Any])

#: Kernel packages, each with those whose kernels it calls.
PACKAGES: dict[str, tuple[str, ...]] = {
    "rollbench.lowfi.statics.kernel": (),
    "rollbench.lowfi.friction.contact.kernel": (),
    "rollbench.lowfi.friction.linear.kernel": ("rollbench.lowfi.friction.contact.kernel",),
    "rollbench.lowfi.friction.screw.kernel": ("rollbench.lowfi.friction.contact.kernel",),
    "rollbench.lowfi.random_errors.kernel": (),
}
STATICS, CONTACT, LINEAR, SCREW, RANDOM_ERRORS = PACKAGES
#: Part of the name under which a package is loaded a second time.
_MARK = "_compiled_"
#: Folders of machine code kept in the user's cache: those of the sources used last.
_KEPT = 4


def is_compiled(module_name: str) -> bool:
    """Return whether a module of that name belongs to a compiled copy."""
    return _MARK in module_name


def kernel(function: F) -> F:
    """Compile ``function`` where its module belongs to a compiled copy; otherwise return it unchanged."""
    if not is_compiled(function.__module__):
        return function
    import numba

    _hold_signals_back()
    compiled_function: F = numba.njit(cache=code_folder() is not None, nogil=True, error_model="numpy")(function)
    return compiled_function


def kernels(package: str, *, compiled: bool) -> ModuleType:
    """Return a kernel package as plain Python or compiled.

    The compiled copy is loaded once in a process, and each kernel is compiled at its first call. Without numba it is always
    plain Python, with a message on standard error.

    Parameters
    ----------
    package
        Name of a kernel package in ``PACKAGES``.
    compiled
        Whether the kernels are compiled.

    Raises
    ------
    KeyError
        A package that ``PACKAGES`` does not name.
    """
    used = PACKAGES[package]
    if not (compiled and _numba_works()):
        return importlib.import_module(package)
    for other in used:
        _load_copy(other)
    return _load_copy(package)


@cache
def _numba_works() -> bool:
    from rollbench.meshes.libraries import ONLY_FOR, import_fault, pip_command

    missing = import_fault("numba")
    if missing:
        sys.stderr.write(f"rollbench: {missing}: {ONLY_FOR['numba']}; {pip_command('numba')}\n")
    return not missing


def _compiled_name(package: str) -> str:
    return f"rollbench.lowfi.{_MARK}{package.removeprefix('rollbench.lowfi.').replace('.', '_')}"


def _package_folder(package: str) -> Path:
    return Path(__file__).parents[1].joinpath(*package.split(".")[1:])


@cache
def _load_copy(package: str) -> ModuleType:
    """Load the files of a package as another package."""
    with _numba_writes_to(package):
        return _load_file_as(_compiled_name(package), _package_folder(package) / "__init__.py")


def _load_file_as(name: str, path: Path, **given: Any) -> ModuleType:
    """Load a file as a module of a given name, or as a package where it is an ``__init__.py``.

    given: global variables that it has from the start. Raises ImportError where there is no such file.
    """
    inside = [str(path.parent)] if path.name == "__init__.py" else None
    spec = importlib.util.spec_from_file_location(name, path, submodule_search_locations=inside)
    if spec is None or spec.loader is None:
        raise ImportError(f"cannot load kernels from {path}")
    module = importlib.util.module_from_spec(spec)
    vars(module).update(given)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def load_driver(system: str, driver: str) -> ModuleType:
    """Load the module ``driver`` of a kernel package once more, for the module of name ``system`` there.

    Its global ``system`` is that module, whose functions it calls: numba caches machine code of functions, but not of
    closures over others.
    """
    of = sys.modules[system]
    return _load_file_as(f"{system}_{driver}", Path(str(of.__file__)).with_name(f"{driver}.py"), system=of)


# One solve compiles nothing


def is_copy_loaded(package: str) -> bool:
    """Return whether the compiled copy of a kernel package is loaded in this process."""
    return _compiled_name(package) in sys.modules


def is_machine_code_cached(package: str = "") -> bool:
    """Return whether machine code of these sources is on disk, of a package or of any.

    Parameters
    ----------
    package
        Name of a kernel package; empty: any.
    """
    folder = code_folder()
    return folder is not None and any(folder.glob(f"{package or '*'}/*/*.nbi"))


#: Jobs that compile kernels after the result is printed, for later commands, by package.
_afterwards: dict[str, Callable[[], object]] = {}


def register_compile_job(package: str, job: Callable[[], object]) -> None:
    """Register a job that uses the compiled kernels of a package, for `compile_afterwards`, which commands call last."""
    _afterwards[package] = job


def compile_afterwards() -> None:
    """Compile the kernels that this process did without, for the next one."""
    while _afterwards:
        _afterwards.popitem()[1]()


# Stale machine code is never used


@cache
def digest() -> str:
    """Return a digest of the sources of all kernel packages, of the types they take, and of this module."""
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for package in PACKAGES:
        folder = _package_folder(package)
        for source in (*sorted(folder.glob("*.py")), *folder.parent.glob("kernel_types.py")):
            digest.update(source.read_bytes())
    return digest.hexdigest()[:20]


@cache
def code_folder() -> Path | None:
    """Return the folder of the machine code of these sources, in NUMBA_CACHE_DIR or in the user's cache of rollbench.

    Folders of other sources are removed, but for the last ones used. None where the cache is switched off
    (ROLLBENCH_CACHE=off),
    and where nothing can be written there or others can write there, with a message on standard error: every process then
    compiles again.
    """
    from rollbench.meshes.cache import default_root

    named = os.environ.get("NUMBA_CACHE_DIR", "").strip()
    root = Path(named) if named else default_root()
    if root is None:
        return None
    try:
        folder = private_folder(root, "kernels", digest())
        os.utime(folder)
        if not os.access(folder, os.W_OK):
            raise PermissionError(13, os.strerror(13), str(folder))
    except OSError as error:
        advice = "name a folder that only you can write to by ROLLBENCH_CACHE"
        sys.stderr.write(f"rollbench: compiled kernels are not kept: {error.filename}: {error.strerror}; {advice}\n")
        return None
    with suppress(OSError):
        for old in sorted(folder.parent.iterdir(), key=lambda f: -f.stat().st_mtime)[_KEPT:]:
            shutil.rmtree(old, ignore_errors=True)
    return folder


@contextmanager
def _numba_writes_to(package: str) -> Iterator[None]:
    """Let numba write to the folder of a package while its kernels are declared; each keeps that folder."""
    import numba

    before, folder = numba.config.CACHE_DIR, code_folder()
    if folder is not None:
        numba.config.CACHE_DIR = str(folder / package)
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before


# An interrupt while numba compiles is safe


@cache
def _hold_signals_back() -> None:
    """Delay interrupts, and TERM where Python handles it, until numba has compiled the kernel at hand.

    An exception in between is swallowed by llvmlite's callbacks, or ends the process in a segmentation fault.
    """
    from numba.core import event

    class Hold(event.Listener):  # type: ignore[misc]
        """While numba holds its lock in the main thread, the only one that handles signals."""

        def __init__(self) -> None:
            self.depth = 0
            self.came: list[int] = []
            self.before: dict[int, Any] = {}

        def on_start(self, event: Any) -> None:
            if event.kind == KERNEL:
                _announce_compilation()
            if event.kind == LOCK and threading.current_thread() is threading.main_thread():
                self.depth += 1
                if self.depth == 1:
                    handled = (number for number in (signal.SIGINT, signal.SIGTERM) if callable(signal.getsignal(number)))
                    self.before = {number: signal.signal(number, self.note) for number in handled}

        def note(self, number: int, _: object) -> None:
            self.came.append(number)
            sys.stderr.write("rollbench: interrupted: ends when the kernel at hand is compiled\n")

        def on_end(self, event: Any) -> None:
            if threading.current_thread() is threading.main_thread():
                self.depth -= event.kind == LOCK
                if self.depth == 0 or (self.came and event.kind == KERNEL):
                    while self.before:
                        signal.signal(*self.before.popitem())
                    came, self.came = self.came, []
                    if came:
                        signal.raise_signal(came[0])

    LOCK, KERNEL = "numba:compiler_lock", "numba:compile"
    hold = Hold()
    event.register(LOCK, hold)
    event.register(KERNEL, hold)


@cache
def _announce_compilation() -> None:
    """Print, before the first kernel is compiled, why nothing else is printed for a while."""
    import multiprocessing

    if multiprocessing.parent_process() is None and sys.stderr.isatty():
        sys.stderr.write("rollbench: compiling kernels, once on this machine: 20 to 60 s\n")
