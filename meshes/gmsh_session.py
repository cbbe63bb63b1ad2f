"""gmsh for a while: it has one state for a process, which is begun quietly and ended whatever happens."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any

#: Signals that gmsh resets to what the system does on them.
RESET = ("SIGHUP", "SIGQUIT", "SIGPIPE", "SIGTERM")


@contextmanager
def session(options: Mapping[str, float] = MappingProxyType({})) -> Iterator[Any]:
    """gmsh with options by name; one that runs already takes them too, and goes on running afterwards.

    What this process does on signals stays as it was: gmsh would let TERM end it before it has tidied up, HUP in spite of
    nohup, and a pipe that nobody reads without a word. Only the main thread can see to that. Raises ImportError where
    gmsh, or a library of the system that it needs, is missing.
    """
    gmsh = _gmsh()
    started = not gmsh.isInitialized()
    if started:
        numbers = [getattr(signal, name) for name in RESET if hasattr(signal, name)]
        before = {number: signal.getsignal(number) for number in numbers}
        gmsh.initialize(readConfigFiles=False, interruptible=False)
        if threading.current_thread() is threading.main_thread():
            for number, handler in before.items():
                if handler is not None:  # else it is not Python's
                    signal.signal(number, handler)
    try:
        for name, value in ({"General.Terminal": 0} | dict(options)).items():
            gmsh.option.setNumber(name, value)
        yield gmsh
    finally:
        if started:
            gmsh.finalize()


def _gmsh() -> Any:
    try:
        import gmsh
    except (ImportError, OSError) as error:
        raise ImportError(
            f"gmsh cannot be loaded ({error}); install rollbench[hifi] and the system libraries libGLU and libX11"
        ) from error
    return gmsh
