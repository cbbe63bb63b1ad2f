"""One source, two engines: the kernels run interpreted (no start-up cost) or compiled by numba (many solves).

A kernel package (a folder named ``kernel``) is written in the subset of Python that numba compiles. ``kernels(package,
compiled=False)`` is the package itself; ``compiled=True`` loads the same files a second time under another name, where the
decorator ``kernel`` compiles. Named tuples that kernels take or return stand in ``kernel_types.py`` next to that folder:
both copies must mean the same classes. Machine code is kept in the user's cache folder, under a digest of the sources of
all kernels, so that none outlives the sources it was made from: numba by itself looks only at the file of a function. It
files machine code by the path of the source; what is compiled is loaded from a copy of the sources in that folder, so that
all checkouts and environments with the same kernels share what one of them compiled.

To numba a number or truth value written out in a call has a type of its own, and the kernel that is called is compiled for
each of them: where calls differ, ``int(np.int64(60))`` or ``bool(np.bool_(False))`` is passed instead.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import os
import shutil
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
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
    """Whether a module of that name belongs to a compiled copy."""
    return _MARK in module_name


def kernel(function: F) -> F:
    """Compile ``function`` where its module belongs to a compiled copy; otherwise return it unchanged."""
    if not is_compiled(function.__module__):
        return function
    import numba

    _hold_signals_back()
    keep = code_folder() is not None
    compiled_function: F = numba.njit(cache=keep, nogil=True, error_model="numpy")(function)
    return compiled_function


@cache
def _hold_signals_back() -> None:
    """From now on let an interrupt, or TERM where Python handles it, wait until numba has compiled the kernel at hand: an
    exception in between is swallowed by llvmlite's callbacks, or ends the process in a segmentation fault."""
    from numba.core import event

    class Hold(event.Listener):  # type: ignore[misc]
        """While numba holds its lock in the main thread, the only one that handles signals."""

        def __init__(self) -> None:
            self.depth = 0
            self.came: list[int] = []
            self.before: dict[int, Any] = {}

        def on_start(self, event: Any) -> None:
            if event.kind == KERNEL:
                _announce()
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
def _announce() -> None:
    """Say, when the first kernel is about to be compiled, why nothing else is printed for a while."""
    import multiprocessing

    if multiprocessing.parent_process() is None:
        sys.stderr.write("rollbench: compiling kernels, once on this machine: 20 to 60 s\n")


#: What compiles kernels once the answer is out, for the commands to come, by package.
_afterwards: dict[str, Callable[[], object]] = {}


def afterwards(package: str, job: Callable[[], object]) -> None:
    """Have a job that uses the compiled kernels of a package done by `compile_afterwards`, which commands call last."""
    _afterwards[package] = job


def compile_afterwards() -> None:
    """Compile what this process did without, so that the next one need not."""
    while _afterwards:
        _afterwards.popitem()[1]()


def kernels(package: str, *, compiled: bool) -> ModuleType:
    """A kernel package as plain Python or compiled (loaded once in a process, compiled on the first call of each kernel);
    without numba always as plain Python, and standard error says so.

    Raises KeyError for a package that ``PACKAGES`` does not name.
    """
    used = PACKAGES[package]
    if not (compiled and _numba_works()):
        return importlib.import_module(package)
    for other in used:
        _load(other)
    return _load(package)


@cache
def _numba_works() -> bool:
    from rollbench.meshes.libraries import ONLY_FOR, fault, pip

    missing = fault("numba")
    if missing:
        sys.stderr.write(f"rollbench: {missing}: {ONLY_FOR['numba']}; {pip('numba')}\n")
    return not missing


def loaded(package: str) -> bool:
    """Whether this process holds the compiled copy of a kernel package."""
    return _copy_name(package) in sys.modules


def cached(package: str = "") -> bool:
    """Whether machine code of these sources lies on disk, of a package or of any, so that it need not be made again."""
    folder = code_folder()
    return folder is not None and any(folder.glob(f"{package}*/*.nbi"))


@cache
def code_folder() -> Path | None:
    """Folder of the machine code of these sources: in NUMBA_CACHE_DIR, else in the user's cache of rollbench; None where
    the cache is switched off (ROLLBENCH_CACHE=off). Where nothing can be written there, standard error says so, and a
    folder of this user's own in that of temporary files serves; without that, kernels are compiled in every process."""
    from rollbench.meshes.cache import default_root

    named = os.environ.get("NUMBA_CACHE_DIR", "").strip()
    root = Path(named) if named else default_root()
    if root is None:
        return None
    advice = "name a folder that only you can write to by ROLLBENCH_CACHE"
    try:
        return _opened(root)
    except OSError as error:
        reason = f"{error.filename}: {error.strerror}"
    user = os.getuid() if hasattr(os, "getuid") else 0
    try:
        kept = _opened(private_folder(Path(tempfile.gettempdir()), f"rollbench-{user}"))
    except OSError as error:
        sys.stderr.write(f"rollbench: compiled kernels are not kept: {reason}; {error}; {advice}\n")
        return None
    sys.stderr.write(f"rollbench: compiled kernels are kept in {kept}: {reason}; {advice}\n")
    return kept


def _opened(root: Path) -> Path:
    """The folder of these sources in a root, made if need be: machine code is run, so nobody else may write there.

    Raises OSError where nothing can be written, and where others can.
    """
    folder = private_folder(root, "kernels", digest())
    os.utime(folder)
    if not os.access(folder, os.W_OK):
        raise PermissionError(13, os.strerror(13), str(folder))
    _drop_old(folder.parent)
    return folder


@cache
def digest() -> str:
    """Digest of the sources of all kernel packages, of the types they take, and of this module."""
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for package in PACKAGES:
        folder = _folder(package)
        for source in (*sorted(folder.glob("*.py")), *folder.parent.glob("kernel_types.py")):
            digest.update(source.read_bytes())
    return digest.hexdigest()[:20]


def _drop_old(parent: Path) -> None:
    """Remove machine code of other sources but that used last."""
    with suppress(OSError):
        for old in sorted(parent.iterdir(), key=lambda f: -f.stat().st_mtime)[_KEPT:]:
            shutil.rmtree(old, ignore_errors=True)


def _folder(package: str) -> Path:
    return Path(__file__).parents[1].joinpath(*package.split(".")[1:])


def _sources(package: str) -> Path:
    """Folder that a package is compiled from: the copy of its files next to the machine code, made if need be; the
    package's own where nothing is kept, or where the copy is not what it should be."""
    folder, kept = _folder(package), code_folder()
    if kept is None:
        return folder
    copy = kept / "sources" / package
    if not copy.is_dir():
        with suppress(OSError), tempfile.TemporaryDirectory(dir=kept) as temporary:
            new = Path(temporary) / package
            new.mkdir()
            for name, content in _contents(folder).items():
                (new / name).write_bytes(content)
            copy.parent.mkdir(exist_ok=True)
            new.rename(copy)  # whole or not at all, whoever is first
    return copy if copy.is_dir() and _contents(copy) == _contents(folder) else folder


def _contents(folder: Path) -> dict[str, bytes]:
    """The Python files of a folder by name."""
    return {source.name: source.read_bytes() for source in folder.glob("*.py")}


def _copy_name(package: str) -> str:
    return f"rollbench.lowfi.{_MARK}{package.removeprefix('rollbench.lowfi.').replace('.', '_')}"


@cache
def _load(package: str) -> ModuleType:
    """The files of a package loaded as another package. Raises ImportError where the folder holds no package."""
    folder, name = _sources(package), _copy_name(package)
    spec = importlib.util.spec_from_file_location(name, folder / "__init__.py", submodule_search_locations=[str(folder)])
    if spec is None or spec.loader is None:
        raise ImportError(f"cannot load the kernels from {folder}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    with _numba_writes_to(code_folder()):
        spec.loader.exec_module(module)
    return module


def part_of(package: str, kernels: Mapping[str, Sequence[str]], name: str) -> Any:
    """The object ``name`` of a package whose modules are imported when first asked for: one of its ``kernels``, by their
    module, or a module. Raises AttributeError for another name."""
    module = next((module for module, names in kernels.items() if name in names), "")
    if not (module or importlib.util.find_spec(f"{package}.{name}")):
        raise AttributeError(f"{package} has no {name}")
    with _numba_writes_to(code_folder()) if is_compiled(package) else nullcontext():
        found = importlib.import_module(f"{package}.{module or name}")
    return getattr(found, name) if module else found


def driver_of(system: str, driver: str) -> ModuleType:
    """The module ``driver`` of a kernel package, loaded once more for the module of name ``system`` there, whose functions
    it then calls (`system_of`): numba keeps machine code of functions, but not of closures over other functions."""
    package = system.rpartition(".")[0]
    name = f"{package}.{driver}_of_{system.rpartition('.')[2]}"
    if name not in sys.modules:
        source = importlib.util.find_spec(f"{package}.{driver}")
        spec = importlib.util.spec_from_file_location(name, source.origin) if source and source.origin else None
        if spec is None or spec.loader is None:
            raise ImportError(f"no module {driver} in {package}")
        sys.modules[name] = module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    return sys.modules[name]


def system_of(name: str) -> ModuleType:
    """The module of functions that a driver loaded under a name serves, see `driver_of`.

    Raises ImportError for a driver that is imported by its own name.
    """
    package, _, driver = name.rpartition(".")
    system = sys.modules.get(f"{package}.{driver.partition('_of_')[2]}")
    if system is None:
        raise ImportError(f"{name} serves no system: see rollbench.lowfi.jit.driver_of")
    return system


@contextmanager
def _numba_writes_to(folder: Path | None) -> Iterator[None]:
    """numba's cache folder while kernels are declared: each keeps the folder that it finds then."""
    import numba

    before = numba.config.CACHE_DIR
    if folder is not None:
        numba.config.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before
