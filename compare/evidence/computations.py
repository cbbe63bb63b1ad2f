"""Which function computes the evidence of which printed table, from which scenes, and which test asserts it."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache

from rollbench.compare.case import Case, every_case
from rollbench.compare.errors import InputError
from rollbench.compare.evidence.record import Evidence, Sheet
from rollbench.compare.models.study import Study
from rollbench.compare.printed.printed_data import KINDS, Printed, load_table, tables

#: Scenes, or why there is none; empty where the kind of the entry says so (an input, arithmetic on printed numbers).
Behind = tuple[str, ...] | str


@dataclass(frozen=True)
class Computation:
    """One printed table of a case: the function ``module:name`` that files its evidence (empty: nothing is computed), the
    test file that asserts every entry of it, and what is behind its entries, by pattern of the key (the first that fits
    counts)."""

    case: Case
    table: str
    computed_by: str
    test: str
    behind: tuple[tuple[str, Behind], ...]

    def compute(self, study: Study) -> tuple[Evidence, ...]:
        """Evidence of every entry: the function, imported now, files it in a sheet of the table."""
        if not self.computed_by:
            return tuple(Evidence(row, words=self.origin(row)[1]) for row in load_table(self.table))
        sheet = Sheet(self.table)
        try:
            function = self.case.load(self.computed_by)
        except (ImportError, AttributeError) as error:
            place = f"{self.case.name}: computations.toml"
            raise InputError(place, self.table, str(error), f"module:function in {self.case.package}", "mend it") from error
        function(sheet, study)
        return sheet.evidence()

    @property
    def function(self) -> str:
        """``module:function`` of the computation."""
        return f"{self.case.package}.{self.computed_by}" if self.computed_by else "none"

    @property
    def every_scene(self) -> tuple[str, ...]:
        """Scenes behind any entry, each once."""
        return tuple(dict.fromkeys(name for _, names in self.behind if not isinstance(names, str) for name in names))

    def origin(self, row: Printed) -> tuple[tuple[str, ...], str]:
        """Scenes behind an entry, and where there are none, why."""
        origin = next((behind for pattern, behind in self.behind if fnmatchcase(row.key, pattern)), "")
        if not isinstance(origin, str) and origin:
            return origin, ""
        if not self.computed_by:
            return (), str(origin)
        return (), KINDS[row.kind] if row.kind in ("input", "arithmetic") else str(origin or "")


@cache
def computations() -> dict[str, Computation]:
    """Those of every case's ``computations.toml`` by table, in the order of cases and files. Raises InputError for a file
    that cannot be read, printed tables that it does not name, and tables that are not printed."""
    out: dict[str, Computation] = {}
    for case in every_case():
        path = case.folder / "computations.toml"
        try:
            described = tomllib.loads(path.read_text("utf-8")) if path.is_file() else {}
        except tomllib.TOMLDecodeError as error:
            raise InputError(str(path), "file", str(error), "TOML", "mend it") from None
        printed = case.files("printed")
        for table in sorted(described.keys() ^ printed.keys()):
            value = "no computation" if table in printed else "no printed table"
            advice = "say how its numbers are computed, or why none is" if table in printed else "remove it"
            raise InputError(str(path), table, value, ", ".join(printed), advice)
        for table, keys in described.items():
            behind = tuple((pattern, x if isinstance(x, str) else tuple(x)) for pattern, x in keys["behind"].items())
            out[table] = Computation(case, table, keys.get("function", ""), keys.get("test", ""), behind)
    return out


@cache
def by_table() -> dict[str, Computation]:
    """Computations by printed table, without tables that nothing is computed for."""
    return {name: one for name, one in computations().items() if one.computed_by}


def evidence(study: Study, *names: str) -> list[Evidence]:
    """Evidence of the printed tables ``names`` (all that are computed unless given), each computed once per study, which
    notes their scenes. Raises InputError for an unknown table."""
    found: list[Evidence] = []
    for name in names or by_table():
        if name not in computations():
            load_table(name)  # which names the tables that there are
        computation = computations()[name]
        study.uses(computation.every_scene)
        found += study.once(computation.compute)
    return found


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
        rows, computation = load_table(name), computations()[name]
        for row in rows:
            printed = row.claim or f"{row.printed} {row.unit}".rstrip()
            test = f"{computation.test}::test_entry[{row.name}]" if computation.computed_by else ""
            yield Trace(name, row.key, printed, row.cls, *computation.origin(row), computation.function, test)
