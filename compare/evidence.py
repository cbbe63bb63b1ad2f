"""Compares every printed number and claim with a computed value, once for gate, report and literature tests.

`computations.toml` of a case names the function that computes the numbers of a printed table and the test that asserts
them. The expected verdict of an entry is stored with the printed value; `Evidence.change` is the difference.
"""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import cache
from typing import Any

import numpy as np

from rollbench.compare import files
from rollbench.compare.case import Case, every_case, files_named
from rollbench.compare.errors import InputError
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import Study
from rollbench.compare.printed import KINDS, VERDICTS, Printed, Verdict, load_table, tables, value_of


@dataclass(frozen=True)
class Evidence:
    """One printed entry with the values computed for it, and the verdict."""

    #: The printed entry.
    printed: Printed
    #: Correct value, in the printed unit.
    value: float | None = None
    #: Value with the faults of the source repeated.
    as_printed: float | None = None
    #: Value under an assumption that was inferred from the printed results, and so confirms nothing.
    reading: float | None = None
    #: Value of the 3D reference.
    reference: float | None = None
    #: Whether a claim is true.
    holds: bool | None = None
    #: Numbers behind a claim, or a remark.
    words: str = ""

    @property
    def compared(self) -> float | None:
        """Computed value that is compared with the printed number; as printed, with the source's fault repeated."""
        return self.as_printed if self.printed.cls == "as-printed" else self.value

    @property
    def error_percent(self) -> float | None:
        """Error of the compared value against the printed number [%]."""
        return self._against_printed(self.compared)

    @property
    def reading_error_percent(self) -> float | None:
        """Error of the value under the inferred assumption against the printed number [%]."""
        return self._against_printed(self.reading)

    def _against_printed(self, value: float | None) -> float | None:
        """Return the error of a value against the printed number [%]; None without either, and for a printed zero."""
        if value is None or self.printed.value is None:
            return None
        percent = float(error_percent(value, self.printed.value))
        return percent if np.isfinite(percent) else None  # of a printed zero there is none

    @property
    def agrees(self) -> bool | None:
        """Whether the computed value agrees with the printed entry; None if nothing was computed."""
        p = self.printed
        if p.value is None:
            return self.holds
        if self.compared is None:
            return None
        if p.low is not None and p.high is not None:
            return p.low <= self.compared <= p.high
        # half a unit of the last digit, with the round-off of a decimal number
        return bool(abs(self.compared - p.value) <= p.tolerance * (1.0 + 1e-9))

    @property
    def verdict(self) -> Verdict:
        """Verdict on the printed entry, by its class and the computed value."""
        p = self.printed
        if p.cls == "open":
            return "contradicted" if p.contradicted else "not identifiable"
        if p.cls == "input":
            return "contradicted" if self.agrees is False else "input"
        if not self.agrees:
            return "not identifiable" if self.agrees is None else "contradicted"
        if p.kind in ("arithmetic", "zero"):
            return "identity"
        by_class: dict[str, Verdict] = {"as-printed": "only as printed", "band": "band"}
        return by_class.get(p.cls, "reproduced")

    @property
    def reason(self) -> str:
        """Reason for the verdict; empty if it needs none."""
        why = self.printed.contradicted
        return joined_remarks(why[:1].upper() + why[1:], joined_remarks(self.printed.remark, self.words))

    @property
    def change(self) -> str:
        """Text with expected and actual verdict if they differ; else empty."""
        expected = self.printed.verdict
        if expected == self.verdict:
            return ""
        wanted = "no verdict is expected" if expected is None else f"expected {expected}"
        return f"{self.printed.name}: {wanted}, came out {self.verdict}"


class Findings:
    """Collector of the computed values of one printed table; entries without a value stay open.

    Parameters
    ----------
    table
        Name of the printed table.

    Examples
    --------
    >>> findings = Findings("lin-2.2")
    >>> findings.remark("time_proposed_1", "another machine")
    >>> [e.words for e in findings.evidence() if e.words]
    ['another machine']
    """

    def __init__(self, table: str) -> None:
        """Start with no value for any entry of ``table``; InputError for an unknown table."""
        self._entries = {row.key: Evidence(row) for row in load_table(table)}
        self.table = table

    def _file(self, key: str, **fields: float | bool | str | None) -> None:
        """Set fields of the entry with a key; KeyError for an unknown key."""
        if key not in self._entries:
            raise KeyError(f"{self.table}: no printed entry {key!r}")
        self._entries[key] = replace(self._entries[key], **fields)  # type: ignore[arg-type]

    def number(
        self,
        key: str,
        value: float | None,
        words: str = "",
        *,
        as_printed: float | None = None,
        reading: float | None = None,
        reference: float | None = None,
    ) -> None:
        """Record the computed value of an entry, in the printed unit.

        Parameters
        ----------
        key
            Key of the entry.
        value
            Correct value.
        words
            Remark.
        as_printed
            Value with the faults of the source repeated.
        reading
            Value under an assumption inferred from the printed results.
        reference
            Value of the 3D reference.

        Raises
        ------
        KeyError
            If there is no such entry.
        """
        self._file(key, value=value, as_printed=as_printed, reading=reading, reference=reference, words=words)

    def numbers(self, values: Mapping[str, float]) -> None:
        """Record correct values by key. Raises KeyError for an unknown key."""
        for key, value in values.items():
            self.number(key, float(value))

    def printed(self, key: str) -> float:
        """Return the printed number of an entry, for arithmetic; KeyError for a claim or an unknown key."""
        return value_of(self.table, key)

    def claim(self, key: str, holds: bool, words: str) -> None:
        """Record whether a claim is true, and the numbers that show it. Raises KeyError for an unknown key."""
        self._file(key, holds=bool(holds), words=words)

    def remark(self, key: str, words: str) -> None:
        """Record a remark on an entry, such as why nothing is compared. Raises KeyError for an unknown key."""
        self._file(key, words=words)

    def evidence(self) -> tuple[Evidence, ...]:
        """Return all entries in the order of the table."""
        return tuple(self._entries.values())


def joined_remarks(*texts: str) -> str:
    """Return the remarks that are not empty, joined by ". "."""
    given = [text for text in texts if text]
    return ". ".join([text.rstrip(".") for text in given[:-1]] + given[-1:])


def count_of(mask: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> str:
    """Return "k of n": the number of true values in a mask, and its size."""
    return f"{int(mask.sum())} of {mask.size}"


#: Scenes, or why there is none; empty where the kind of the entry says so (an input, arithmetic on printed numbers).
Behind = tuple[str, ...] | str


@dataclass(frozen=True)
class Computation:
    """Function that computes the entries of one printed table, with its scenes and tests."""

    #: Case of the table.
    case: Case
    #: Name of the table.
    table: str
    #: Function ``module:name`` that enters the values; empty: nothing is computed.
    computed_by: str
    #: Test file that asserts every entry.
    test: str
    #: Scenes, or the reason for none, by pattern of the key; the first that matches counts.
    behind: tuple[tuple[str, Behind], ...]

    def compute(self, study: Study) -> tuple[Evidence, ...]:
        """Compute the values of every entry of the table; imports the function, InputError if that fails."""
        if not self.computed_by:
            return tuple(Evidence(row, words=self.origin(row)[1]) for row in load_table(self.table))
        findings = Findings(self.table)
        try:
            function = self.case.import_object(self.computed_by)
        except (ImportError, AttributeError) as error:
            place = f"{self.case.name}: computations.toml"
            raise InputError(place, self.table, str(error), f"module:function in {self.case.package}", "mend it") from error
        function(findings, study)
        return findings.evidence()

    @property
    def function(self) -> str:
        """Name ``module:function`` of the computation; ``none`` if nothing is computed."""
        return f"{self.case.package}.{self.computed_by}" if self.computed_by else "none"

    @property
    def every_scene(self) -> tuple[str, ...]:
        """Names of all scenes from which entries of the table are computed, each once."""
        return tuple(dict.fromkeys(name for _, names in self.behind if not isinstance(names, str) for name in names))

    def origin(self, row: Printed) -> tuple[tuple[str, ...], str]:
        """Return the scenes from which an entry is computed, and the reason if there are none."""
        origin = next((behind for pattern, behind in self.behind if fnmatchcase(row.key, pattern)), "")
        if not isinstance(origin, str) and origin:
            return origin, ""
        if not self.computed_by:
            return (), str(origin)
        return (), KINDS[row.kind] if row.kind in ("input", "arithmetic") else str(origin or "")


@cache
def computations() -> dict[str, Computation]:
    """Return the computations of all cases by printed table, in the order of cases and files.

    InputError for a file that cannot be read, printed tables that it does not name, and tables that are not printed.
    """
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
def computations_by_table() -> dict[str, Computation]:
    """Return the computations by printed table, without tables for which nothing is computed."""
    return {name: one for name, one in computations().items() if one.computed_by}


def evidence(study: Study, *names: str) -> list[Evidence]:
    """Compute the entries of printed tables.

    Parameters
    ----------
    study
        Cache of the values (each table is computed once) and of the scenes used.
    *names
        Tables; all unless given.

    Returns
    -------
    list of Evidence
        Entries in the order of the tables.

    Raises
    ------
    InputError
        If a table is unknown.
    """
    found: list[Evidence] = []
    for name in names or computations_by_table():
        if name not in computations():
            load_table(name)  # which names the tables that there are
        computation = computations()[name]
        study.uses(computation.every_scene)
        if name not in study.evidence:
            study.evidence[name] = computation.compute(study)
        found += study.evidence[name]
    return found


@dataclass(frozen=True)
class EntryOrigin:
    """Origin of a printed entry: its scenes or why there are none, its computation (``module:function``), its test."""

    table: str
    key: str
    printed: str
    cls: str
    scenes: tuple[str, ...]
    no_scene: str
    computation: str
    test: str


def origins_of_entries(table: str = "") -> Iterator[EntryOrigin]:
    """Yield the origin of every printed entry of one table, or of all; InputError for an unknown table."""
    for name in [table] if table else tables():
        rows, computation = load_table(name), computations()[name]
        for row in rows:
            printed = row.claim or f"{row.printed} {row.unit}".rstrip()
            test = f"{computation.test}::test_entry[{row.name}]" if computation.computed_by else ""
            yield EntryOrigin(name, row.key, printed, row.cls, *computation.origin(row), computation.function, test)


#: Verdicts that are counted apart: they say nothing of a model.
APART: tuple[Verdict, ...] = ("input", "identity")


@cache
def misprints() -> list[dict[str, str]]:
    """Return a row for each misprint or fault of a source: source, place, wrong, right, evidence, command, test."""
    out = []
    for case, path in files_named("misprints.toml", every_case()).items():
        for row in tomllib.loads(path.read_text(encoding="utf-8"))["row"]:
            shown = f"rollbench check --printed --only {row['shown']}" if "shown" in row else f"pytest {row['test']}"
            kept = {key: row[key] for key in ("place", "wrong", "right", "evidence")}
            out.append({"source": case.name, **kept, "command": shown, "test": row["test"]})
    return out


def numbers_left_out() -> list[dict[str, Any]]:
    """Return a row for each group of printed numbers left out of the tables: place, quantity, count, reason."""
    rows: list[dict[str, Any]] = files.shipped_table("cases/left-out.toml")["row"]
    return rows


def publication_titles() -> list[str]:
    """Return the titles of the sources with printed tables."""
    return [case.title for case in every_case() if case.title]


def audit(study: Study, *names: str) -> list[Evidence]:
    """Return every printed entry of tables (all unless named) with its computed value and verdict.

    InputError for an unknown table.
    """
    return evidence(study, *(names or sorted(computations())))


def source(printed: Printed) -> str:
    """Return the title of the publication that printed an entry."""
    return computations()[printed.table].case.title


def counts(rows: Sequence[Evidence]) -> list[dict[str, Any]]:
    """Count printed entries by source and verdict: a row for each source, and one for all.

    Rows have the verdicts, ``judged`` (without inputs and identities) and ``all``.
    """
    out = []
    for title in (*publication_titles(), "all"):
        by_verdict = Counter(row.verdict for row in rows if title in (source(row.printed), "all"))
        if by_verdict:
            judged = sum(n for verdict, n in by_verdict.items() if verdict not in APART)
            verdicts: dict[str, Any] = {str(v): by_verdict[v] for v in VERDICTS}
            out.append({"source": title, **verdicts, "judged": judged, "all": by_verdict.total()})
    return out


def trust(row: Mapping[str, Any]) -> str:
    """Return a sentence on how many numbers of a source are reproduced, from its row of ``counts``."""
    n = row["judged"]
    if n == 0:
        return f"{row['source']}: nothing that a model could be judged by."
    share = {v: f"{row[v]} ({100.0 * row[v] / n:.0f} %)" for v in VERDICTS if v not in APART}
    return (
        f"{row['source']}: of {n} numbers and claims that a model can be judged by, {share['reproduced']} come out as "
        f"printed, {share['band']} lie within a band, {share['only as printed']} come out only with a fault repeated, "
        f"{share['contradicted']} are contradicted and {share['not identifiable']} cannot be identified from the text."
    )
