"""Peak memory of one piece of work in a process that does several: the kernel's own record, reset before each.

``getrusage`` gives the highest memory since the process began, so that a small run after a large one gets the large one's
number. Linux forgets that record when asked to (``/proc/self/clear_refs``); elsewhere nothing is measured.
"""

from __future__ import annotations

import ctypes
import gc
from contextlib import suppress
from pathlib import Path

#: Whether the record may hold earlier work: a reset was asked for and refused.
_stale = False


def reset_peak() -> bool:
    """Start a new record of the highest resident memory of this process; whether the system can.

    What earlier work freed is given back to the system first, as far as the C library can, so that it does not count.
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
    """Highest resident memory of this process since ``reset_peak`` [MB], interpreter and libraries included; None where
    the system keeps no such record, or did not reset it."""
    if _stale:
        return None
    try:
        lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
        return next(float(x.split()[1]) for x in lines if x.startswith("VmHWM")) * 1.024e-3
    except (OSError, StopIteration, ValueError):
        return None
