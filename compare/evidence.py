"""Comparison of the numbers and claims that publications print with the values that rollbench computes for them.

Commands, report and tests use the same comparison. For each printed table of a publication, `computations.toml` in the
publication's folder names the function that computes the table's numbers and the test that asserts them. The expected
verdict on a number or claim is stored with it; `PrintedEntryComparison.verdict_change` states where the actual verdict
differs.
"""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from typing import Any

import numpy as np

from rollbench.compare import files
from rollbench.compare.case import Case, all_cases, case_files_named, modules_for_all_scenes
from rollbench.compare.errors import InputError
from rollbench.compare.measure import error_percent
from rollbench.compare.models.stored_study import Study
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import (
    KINDS,
    VERDICTS,
    PrintedEntry,
    Verdict,
    load_printed_table,
    printed_table_names,
    printed_value,
)
from rollbench.meshes.libraries import optional_package_of_module


@dataclass(frozen=True)
class PrintedEntryComparison:
    """One number or claim that a publication prints, with the values computed for it and the resulting verdict."""

    #: The printed number or claim.
    printed: PrintedEntry
    #: Value computed without the mistake of the publication, in the printed unit.
    value: float | None = None
    #: Value computed with the publication's mistakes repeated, in the printed unit; None: no mistake affects this
    #: number.
    as_printed: float | None = None
    #: Value computed under an assumption that was inferred from the printed results, so that agreement with these
    #: results confirms nothing.
    reading: float | None = None
    #: Value that follows from other printed numbers, such as their sum, in the printed unit; None: not computed. It tests
    #: the publication's arithmetic and no model.
    follows: float | None = None
    #: Value computed by the 3D model, in the printed unit; None: not computed in 3D.
    reference: float | None = None
    #: Whether a claim in words is true; None for a number, or if the claim was not tested.
    claim_is_true: bool | None = None
    #: Text with the numbers that support or contradict a claim, or a remark on a number.
    remark: str = ""

    @property
    def compared_value(self) -> float | None:
        """Value that is compared with the printed number, in the printed unit.

        It is computed without the publication's mistakes. Only for numbers of the class "as-printed", which cannot be
        reproduced otherwise, a mistake is repeated. For a number of the kind "arithmetic" it is the value that follows from
        other printed numbers.
        """
        return self.follows if self.printed.kind == "arithmetic" else self.model_value

    @property
    def model_value(self) -> float | None:
        """Value of a model, in the printed unit: that without the publication's mistakes, or with them ("as-printed")."""
        return self.as_printed if self.printed.entry_class == "as-printed" else self.value

    @property
    def error_percent(self) -> float | None:
        """Error of the model's value against the printed number [%]; None if there is no value or no number."""
        return self._error_against_printed_number(self.model_value)

    @property
    def reading_error_percent(self) -> float | None:
        """Error [%] of the value computed under an assumption that was inferred from the publication's printed results."""
        return self._error_against_printed_number(self.reading)

    def _error_against_printed_number(self, value: float | None) -> float | None:
        """Return the error of ``value`` against the printed number [%]; None if one is missing or the number is zero."""
        if value is None or self.printed.value is None:
            return None
        percent = float(error_percent(value, self.printed.value))
        return percent if np.isfinite(percent) else None  # an error relative to zero is not defined

    @property
    def agrees_with_printed(self) -> bool | None:
        """Whether the computed value agrees with the printed number, or whether a claim is true; None if not computed."""
        p = self.printed
        if p.value is None:
            return self.claim_is_true
        if self.compared_value is None:
            return None
        if p.low is not None and p.high is not None:
            return p.low <= self.compared_value <= p.high
        # half a unit of the last digit, with the round-off of a decimal number
        return bool(abs(self.compared_value - p.value) <= p.tolerance * (1.0 + 1e-9))

    @property
    def verdict(self) -> Verdict:
        """Verdict on the printed number or claim, such as "reproduced" or "contradicted"."""
        p = self.printed
        if p.entry_class == "open":
            return "contradicted" if p.contradicting_statement else "not identifiable"
        if p.entry_class == "input":
            return "contradicted" if self.agrees_with_printed is False else "input"
        if not self.agrees_with_printed:
            return "not identifiable" if self.agrees_with_printed is None else "contradicted"
        if p.kind in ("arithmetic", "zero"):
            return "identity"
        by_class: dict[str, Verdict] = {"as-printed": "only as printed", "band": "band"}
        return by_class.get(p.entry_class, "reproduced")

    @property
    def reason(self) -> str:
        """Sentences that explain the verdict; empty if no explanation is needed."""
        why = self.printed.contradicting_statement
        return join_remarks(why[:1].upper() + why[1:], join_remarks(self.printed.remark, self.remark))

    @property
    def verdict_change(self) -> str:
        """Text that states the expected and the actual verdict if they differ; otherwise empty."""
        expected = self.printed.expected_verdict
        if expected == self.verdict:
            return ""
        wanted = "no expected verdict is stored" if expected is None else f"the expected verdict is {expected}"
        return f"{self.printed.name}: {wanted}, the actual verdict is {self.verdict}"


class ComputedEntryValues:
    """Values computed for the numbers and claims of one printed table, for comparison with them.

    A computation adds its values by the keys of the table.

    Parameters
    ----------
    table
        Name of the printed table.

    Examples
    --------
    >>> findings = ComputedEntryValues("lin-2.2")
    >>> findings.add_remark("time_proposed_1", "another machine")
    >>> [e.remark for e in findings.comparisons() if e.remark]
    ['another machine']
    """

    def __init__(self, table: str) -> None:
        """Read the numbers and claims of the printed table; InputError for an unknown table."""
        self._rows = {row.key: row for row in load_printed_table(table)}
        self.table = table
        #: Values of fields of `PrintedEntryComparison`, by the keys of the table and by field.
        self.values: dict[str, dict[str, Any]] = {}

    def add_number(self, key: str, value: float | None, words: str = "", **others: float | None) -> None:
        """Add the values computed for one printed number, in the printed unit.

        Parameters
        ----------
        key
            Key of the printed number in its table.
        value
            Value that a model computes without the mistake of the publication; it depends on no printed result. None: none.
        words
            Remark on the value.
        **others
            Further fields of `PrintedEntryComparison`: ``as_printed`` (with the publication's mistakes repeated),
            ``reading`` (under an assumption that was inferred from the printed results), ``follows`` (from other printed
            numbers) and ``reference`` (of the 3D reference).

        Raises
        ------
        KeyError
            If the table has no such key.
        """
        self._row(key).update({"value": value, "as_printed": None, "reading": None, "follows": None, "reference": None})
        self._row(key).update({"remark": words} | others)

    def _row(self, key: str) -> dict[str, Any]:
        """Return the fields of the number or claim ``key`` that are set so far; KeyError for an unknown key."""
        if key not in self._rows:
            raise KeyError(f"table {self.table} of a publication: no printed number or claim has the key {key!r}")
        return self.values.setdefault(key, {})

    def numbers(self, values: Mapping[str, Any]) -> None:
        """Add the correct values computed for several printed numbers, by key; KeyError for an unknown key."""
        for key, value in values.items():
            self.add_number(key, float(value))

    def follow(self, values: Mapping[str, float]) -> None:
        """Add the values of several printed numbers that follow from other printed ones; KeyError for an unknown key."""
        for key, value in values.items():
            self.add_number(key, None, follows=float(value))

    def printed(self, key: str) -> float:
        """Return the printed number ``key``, for use in a computation; KeyError for a claim or an unknown key."""
        return printed_value(self.table, key)

    def add_claim(self, key: str, holds: bool, words: str) -> None:
        """Add whether the printed claim ``key`` is true (``holds``), and a text ``words`` with the numbers that show it."""
        self._row(key).update(claim_is_true=bool(holds), remark=words)

    def add_remark(self, key: str, words: str) -> None:
        """Add the remark ``words`` on the printed number or claim ``key``, such as the reason why it is not compared."""
        self._row(key).update(remark=words)

    def comparisons(self) -> tuple[PrintedEntryComparison, ...]:
        """Return every number and claim of the printed table with its computed values and verdict, in the table's order."""
        return tuple(PrintedEntryComparison(row, **self.values.get(key, {})) for key, row in self._rows.items())


def join_remarks(*texts: str) -> str:
    """Return the non-empty remarks joined by ". " to one text."""
    given = [text for text in texts if text]
    return ". ".join([text.rstrip(".") for text in given[:-1]] + given[-1:])


def count_in_words(mask: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> str:
    """Return the text "k of n" for a mask of n truth values, k of which are true."""
    return f"{int(mask.sum())} of {mask.size}"


#: Names of the scenes from which the value for a printed number is computed, or a text with the reason for none. The
#: text is empty if the kind of the number implies the reason (an input of the publication, or arithmetic on printed
#: numbers).
Behind = tuple[str, ...] | str


@dataclass(frozen=True)
class PrintedTableComputation:
    """How the values for one printed table are computed: by which function, from which scenes, asserted by which test."""

    #: Publication that prints the table.
    case: Case
    #: Name of the table.
    table: str
    #: Function ``module:name`` that computes the values; empty if nothing is computed.
    function_path: str
    #: Test file that asserts every number and claim of the table.
    test_file: str
    #: Pairs: a pattern for keys of the table, and the scenes from which the values of all keys that match it are
    #: computed (or the reason why no scene is used). If several patterns match a key, the first one applies.
    scenes_or_reason_by_key_pattern: tuple[tuple[str, Behind], ...]

    def compute(self, cache: SceneResultCache) -> tuple[PrintedEntryComparison, ...]:
        """Compute the values for all numbers and claims of the printed table, and return each entry with value and verdict.

        ``cache``: cache of computed values. InputError if the function that computes the values cannot be imported.
        """
        rows = load_printed_table(self.table)
        if not self.function_path:
            return tuple(PrintedEntryComparison(row, remark=self.scenes_or_reason(row)[1]) for row in rows)
        if cache.stored_studies is None:
            found = self.computed_values(cache)
        else:
            found = cache.stored_studies.value(cache, self.study)
        return tuple(PrintedEntryComparison(row, **found.get(row.key, {})) for row in rows)

    @property
    def study(self) -> Study:
        """How the values are computed, as a study whose value can be stored."""
        return Study(self.table, (self.case.module_of(self.function_path), *modules_for_all_scenes()), self.computed_values)

    def computed_values(self, cache: SceneResultCache) -> dict[str, dict[str, Any]]:
        """Compute and return the values of fields of `PrintedEntryComparison`, by the keys of the table and by field.

        ``cache``: cache of computed values. InputError if the function that computes the values cannot be imported.
        """
        findings = ComputedEntryValues(self.table)
        try:
            function = self.case.import_object(self.function_path)
        except (ImportError, AttributeError) as error:
            if isinstance(error, ImportError) and optional_package_of_module(error.name):
                raise  # the name is right, and what it imports is not installed
            place = f"{self.case.name}: computations.toml"
            allowed = f"module:function in {self.case.package}"
            raise InputError(place, self.table, str(error), allowed, "correct the name of the function") from error
        function(findings, cache)
        return findings.values

    @property
    def function_name(self) -> str:
        """Name ``module:function`` of the function that computes the values; ``none`` if nothing is computed."""
        return f"{self.case.package}.{self.function_path}" if self.function_path else "none"

    @property
    def scene_names(self) -> tuple[str, ...]:
        """Names of all scenes from which values for the printed table are computed, without repetition."""
        behind = (names for _, names in self.scenes_or_reason_by_key_pattern if not isinstance(names, str))
        return tuple(dict.fromkeys(name for names in behind for name in names))

    def scenes_or_reason(self, row: PrintedEntry) -> tuple[tuple[str, ...], str]:
        """Return the names of the scenes from which the value for a printed entry is computed, or the reason for none.

        ``row``: the printed number or claim. The names are empty if no scene is used; the reason is empty if one is used.
        """
        patterns = self.scenes_or_reason_by_key_pattern
        origin = next((behind for pattern, behind in patterns if fnmatchcase(row.key, pattern)), "")
        if not isinstance(origin, str) and origin:
            return origin, ""
        if not self.function_path:
            return (), str(origin)
        return (), KINDS[row.kind] if row.kind in ("input", "arithmetic") else str(origin or "")


@cache
def all_computations() -> dict[str, PrintedTableComputation]:
    """Return how the values for each printed table of all publications are computed, by the name of the table.

    InputError if a file `computations.toml` cannot be read, misses a printed table, or names a table that does not exist.
    """
    out: dict[str, PrintedTableComputation] = {}
    for case in all_cases():
        path = case.folder / "computations.toml"
        try:
            described = tomllib.loads(path.read_text("utf-8")) if path.is_file() else {}
        except tomllib.TOMLDecodeError as error:
            raise InputError(str(path), "file", str(error), "a file in TOML format", "correct its syntax") from None
        printed = case.files("printed")
        for table in sorted(described.keys() ^ printed.keys()):
            if table in printed:
                value = "no computation for this table of the publication"
                advice = f"add a section [{table}] with the function that computes the table, or why nothing is computed"
            else:
                value, advice = "a section for a table that the publication does not have", "remove the section"
            allowed = f"one section [NAME] for each table of the publication: {', '.join(printed)}"
            raise InputError(str(path), table, value, allowed, advice)
        for table, keys in described.items():
            behind = tuple((pattern, x if isinstance(x, str) else tuple(x)) for pattern, x in keys["behind"].items())
            out[table] = PrintedTableComputation(case, table, keys.get("function", ""), keys.get("test", ""), behind)
    return out


@cache
def computations_with_function() -> dict[str, PrintedTableComputation]:
    """Return the computations by name of the printed table, without tables for which nothing is computed."""
    return {name: one for name, one in all_computations().items() if one.function_path}


def evidence(cache: SceneResultCache, *names: str) -> list[PrintedEntryComparison]:
    """Compute values for the numbers and claims of printed tables, and return each number or claim with its value.

    Parameters
    ----------
    cache
        Cache in which computed values are stored, so that each table is computed once; it also records which scenes are
        used.
    *names
        Names of the tables; if none are given, all tables for which something is computed.

    Returns
    -------
    list of PrintedEntryComparison
        Printed numbers and claims with their computed values, in the order of the tables.

    Raises
    ------
    InputError
        If a table is unknown.
    """
    found: list[PrintedEntryComparison] = []
    for name in names or computations_with_function():
        if name not in all_computations():
            load_printed_table(name)  # raises an error that lists the known tables
        found += cache.compute_once(evidence_of_table, name)
    return found


def evidence_of_table(cache: SceneResultCache, name: str) -> tuple[PrintedEntryComparison, ...]:
    """Return the numbers and claims of the printed table ``name`` with their computed values, and record its scenes."""
    computation = all_computations()[name]
    cache.record_used_scenes(computation.scene_names)
    return computation.compute(cache)


def computations_of_entries(table: str = "") -> Iterator[dict[str, Any]]:
    """Yield, for every printed number and claim, how the value for it is computed; InputError for an unknown table.

    The keys are the printed table; the key of the number or claim; what is printed, with its unit; its class; the names of
    the scenes, or the reason why no scene is used; the function that computes the value ("none" without one); the test that
    asserts it (empty if nothing is computed). ``table``: name of the printed table; empty: all tables.
    """
    for name in [table] if table else printed_table_names():
        rows, computation = load_printed_table(name), all_computations()[name]
        for row in rows:
            printed = row.claim or f"{row.number_as_printed} {row.unit}".rstrip()
            test = f"{computation.test_file}::test_entry[{row.name}]" if computation.function_path else ""
            scenes, reason = computation.scenes_or_reason(row)
            yield {
                "table": name,
                "key": row.key,
                "printed": printed,
                "cls": row.entry_class,
                "scenes": scenes,
                "no_scene": reason,
                "computation": computation.function_name,
                "test": test,
            }


#: Verdicts on printed numbers that are counted separately, because they do not judge a model.
APART: tuple[Verdict, ...] = ("input", "identity")


@cache
def misprint_rows() -> list[dict[str, str]]:
    """Return a row for each known misprint or mistake in a publication, for the table of misprints.

    The keys of a row are source (the publication), place, wrong (text), right (text), evidence, command (which shows it)
    and test.
    """
    out = []
    for case, path in case_files_named("misprints.toml", all_cases()).items():
        for row in tomllib.loads(path.read_text(encoding="utf-8"))["row"]:
            shown = f"rollbench check --printed --only {row['shown']}" if "shown" in row else f"pytest {row['test']}"
            kept = {key: row[key] for key in ("place", "wrong", "right", "evidence")}
            out.append({"source": case.name, **kept, "command": shown, "test": row["test"]})
    return out


def uncompared_number_rows() -> list[dict[str, Any]]:
    """Return a row for each group of printed numbers that rollbench does not compare: place, quantity, count, reason."""
    rows: list[dict[str, Any]] = files.read_shipped_toml("cases/left-out.toml")["row"]
    return rows


def publication_titles() -> list[str]:
    """Return the titles of the publications whose printed numbers are compared."""
    return [case.title for case in all_cases() if case.title]


def publication_title_of(entry: PrintedEntry) -> str:
    """Return the title of the publication that prints a number or claim."""
    return all_computations()[entry.table].case.title


def count_entries_by_verdict(rows: Sequence[PrintedEntryComparison]) -> list[dict[str, Any]]:
    """Count printed numbers and claims by publication and verdict.

    ``rows``: printed numbers and claims with their verdicts. Returned is a row for each publication, and a last one for all
    publications, with the counts by verdict, ``judged`` (count of the entries that test a model: all except input data and
    arithmetic on other printed numbers) and ``all`` (count of all entries).
    """
    out = []
    for title in (*publication_titles(), "all"):
        by_verdict = Counter(row.verdict for row in rows if title in (publication_title_of(row.printed), "all"))
        if by_verdict:
            judged = sum(n for verdict, n in by_verdict.items() if verdict not in APART)
            verdicts: dict[str, Any] = {str(v): by_verdict[v] for v in VERDICTS}
            out.append({"source": title, **verdicts, "judged": judged, "all": by_verdict.total()})
    return out


def reproduction_sentence(counts_of_publication: Mapping[str, Any]) -> str:
    """Return a sentence on how many numbers of a publication are reproduced.

    ``counts_of_publication``: its row of `count_entries_by_verdict`.
    """
    n = counts_of_publication["judged"]
    if n == 0:
        return f"{counts_of_publication['source']}: no number or claim by which a model can be judged."
    share = {
        v: f"{counts_of_publication[v]} ({100.0 * counts_of_publication[v] / n:.0f} %)" for v in VERDICTS if v not in APART
    }
    return (
        f"Of the {n} numbers and claims of {counts_of_publication['source']} by which a model can be judged, "
        f"{share['reproduced']} are reproduced, {share['band']} lie within a tolerance band, {share['only as printed']} "
        f"are reproduced only if the publication's mistake is repeated, {share['contradicted']} are contradicted, and "
        f"{share['not identifiable']} are not determined by the data in the publication."
    )
