"""Which function computes the evidence of which printed table, from which scenes, and which test asserts it."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from typing import Any

from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import KINDS, Printed, load_table, tables
from rollbench.compare.registration import load, source_files
from rollbench.compare.wings.evidence.record import Evidence, Sheet

#: Scenes, or why there is none; empty where the kind of the entry says so (an input, arithmetic on printed numbers).
Behind = tuple[str, ...] | str


@dataclass(frozen=True)
class Computation:
    """One printed table: the function that files its evidence (as `registration.load` takes it; empty: nothing is
    computed), the test file that asserts every entry of it, what is behind its entries, by pattern of the key (the first
    that fits counts), and the wings that it needs."""

    table: str
    computed_by: str
    test: str
    behind: tuple[tuple[str, Behind], ...]
    needs: tuple[str, ...] = ()

    def compute(self, study: Study) -> tuple[Evidence, ...]:
        """Evidence of every entry: the function, imported now, files it in a sheet of the table."""
        sheet = Sheet(self.table)
        load(self.computed_by)(sheet, study)
        return sheet.evidence()

    @property
    def function(self) -> str:
        """``module:function`` of the computation."""
        return f"rollbench.compare.{self.computed_by}" if self.computed_by else "none"

    @property
    def every_scene(self) -> tuple[str, ...]:
        """Scenes behind any entry, each once."""
        return tuple(dict.fromkeys(name for _, names in self.behind if not isinstance(names, str) for name in names))

    def origin(self, row: Printed) -> tuple[tuple[str, ...], str]:
        """Scenes behind an entry, and where there are none, why."""
        origin = next((behind for pattern, behind in self.behind if fnmatchcase(row.key, pattern)), "")
        if not isinstance(origin, str) and origin:
            return origin, ""
        return (), KINDS[row.kind] if row.kind in ("input", "arithmetic") else str(origin or "")


@cache
def computations() -> tuple[Computation, ...]:
    """Those of ``computations.toml`` of all sources, in order."""
    every = (
        _described(table, keys)
        for path in source_files("computations.toml")
        for table, keys in tomllib.loads(path.read_text("utf-8")).items()
    )
    return tuple(every)


def _described(table: str, keys: Mapping[str, Any]) -> Computation:
    """The computation of a printed table from its keys in the file."""
    behind = tuple((pattern, x if isinstance(x, str) else tuple(x)) for pattern, x in keys["behind"].items())
    return Computation(table, keys.get("function", ""), keys.get("test", ""), behind, tuple(keys.get("needs", ())))


@cache
def by_table() -> dict[str, Computation]:
    """Computations by printed table."""
    return {one.table: one for one in computations() if one.computed_by}


@cache
def not_computed() -> dict[str, str]:
    """Printed tables that nothing is computed for, and why."""
    return {one.table: str(one.behind[0][1]) for one in computations() if not one.computed_by}


def evidence(study: Study, *names: str) -> list[Evidence]:
    """Evidence of the printed tables ``names`` (all that are computed unless given), each computed once
    per study, which notes their scenes."""
    wanted = [by_table()[name] for name in names or by_table()]
    for computation in wanted:
        study.uses(computation.every_scene)
    return [e for computation in wanted for e in study.once(computation.compute)]


@dataclass(frozen=True)
class Trace:
    """Where a printed entry comes from: its scenes or why there are none, its one computation (``module:function``), its
    test."""

    table: str
    key: str
    printed: str
    cls: str
    scenes: tuple[str, ...]
    no_scene: str
    computation: str
    test: str


def traces(table: str = "") -> Iterator[Trace]:
    """Every printed entry of one shipped table, or of all, in order. Raises InputError for an unknown table."""
    for name in [table] if table else tables():
        computation = by_table().get(name)
        rows = load_table(name)
        if name not in by_table() and name not in not_computed():
            continue  # its wing is absent
        for row in rows:
            printed = row.claim or f"{row.printed} {row.unit}".rstrip()
            if computation is None:
                yield Trace(name, row.key, printed, row.cls, (), not_computed()[name], "none", "")
            else:
                test = f"{computation.test}::test_entry[{name}:{row.key}]"
                yield Trace(name, row.key, printed, row.cls, *computation.origin(row), computation.function, test)
