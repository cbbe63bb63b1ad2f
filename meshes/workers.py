"""Worker processes of this machine, which end with the process that started them."""

from __future__ import annotations

import os
import threading
import time
from typing import Any

from rollbench.meshes.threads import VARIABLES

#: Seconds between two looks at whether the process that started a worker still lives.
LOOK = 0.5


def local() -> Any:
    """joblib's context in which ``Parallel`` starts workers of this machine, each with linear algebra on one thread, or on
    as many as the variables say that are set here (`rollbench.meshes.threads`). A worker ends within a second of the
    process that started it, however that ended: one that was killed leaves none. On Windows, which does not tell, they end
    when they have been idle for five minutes."""
    from joblib import parallel_config

    threads = None if any(name in os.environ for name in VARIABLES) else 1
    return parallel_config(
        backend="loky", inner_max_num_threads=threads, initializer=end_with_parent, initargs=(os.getpid(),)
    )


def end_with_parent(parent: int) -> None:
    """End this process at once, whatever it does, as soon as process ``parent`` is not its parent any more."""
    threading.Thread(target=_wait_for_end, args=(parent,), daemon=True).start()


def _wait_for_end(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK)
    os._exit(1)
