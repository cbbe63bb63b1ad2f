"""What times were measured with, and the rule that those in one table, figure or ratio are of one measuring run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

from rollbench.compare import __version__
from rollbench.compare.provenance import sources_hash
from rollbench.compare.running import machine

#: Folders whose sources decide how long a solution takes.
SOLVERS = ("hifi", "lowfi", "meshes")


@dataclass(frozen=True)
class Measured:
    """What a time was measured with: version of this program, digest of the solvers' sources, machine; what runs of before
    0.15 do not say is empty."""

    version: str
    sources: str = ""
    machine: str = ""

    def __str__(self) -> str:
        """In words, after "measured with"."""
        return f"{self.version or 'an unknown version'}{f' on {self.machine}' if self.machine else ''}"


@cache
def here() -> Measured:
    """What a time that is measured by this process is measured with."""
    return Measured(__version__, sources_hash(SOLVERS)[:16], machine())


def one_run(times: Iterable[Measured]) -> Measured | None:
    """What some times were measured with; None of no times. Raises ValueError for times of several measuring runs."""
    found = set(times)
    if len(found) > 1:
        raise ValueError(f"times of several measuring runs: {', '.join(sorted(map(str, found)))}")
    return next(iter(found), None)


def most_of(times: Iterable[Measured]) -> Measured | None:
    """What most of some times were measured with, those that a table can show beside one another; None of no times."""
    common = Counter(times).most_common(1)
    return common[0][0] if common else None
