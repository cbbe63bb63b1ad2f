"""Shared by the literature tests: every printed entry of a table is a test of the evidence that the project computes."""

from tests.evidence_study import STUDY

from rollbench.compare.evidence import PrintedEntryComparison, evidence
from rollbench.compare.printed import PrintedEntry, load_printed_table, printed_table_names


def of_source(source: str) -> list[str]:
    """Tables of a source."""
    return [name for name in printed_table_names() if name.startswith(f"{source}-")]


def rows(table: str) -> dict[str, PrintedEntry]:
    """Printed entries of a table by key."""
    return {row.key: row for row in load_printed_table(table)}


def keys(*names: str) -> list[str]:
    """ "table:key" of every entry."""
    return [f"{name}:{key}" for name in names for key in rows(name)]


def found(key: str) -> PrintedEntryComparison:
    """Evidence of an entry "table:key"."""
    table, _, name = key.partition(":")
    return next(e for e in evidence(STUDY, table) if e.printed.key == name)


def check(key: str) -> None:
    """The verdict of an entry is the one that is expected of it, and an open one says why."""
    e = found(key)
    assert not e.verdict_change, (e.compared_value, e.printed.number_as_printed, e.remark)
    assert e.printed.entry_class != "open" or e.reason, "an open entry says why"
