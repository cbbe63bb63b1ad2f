"""Shared by the literature tests: every printed entry of a table is a test of the evidence that the project computes."""

from tests.evidence_study import STUDY

from rollbench.compare.evidence.computations import evidence
from rollbench.compare.evidence.record import Evidence
from rollbench.compare.evidence.verdicts import data_digest, stored
from rollbench.compare.printed.printed_data import Printed, load_table, tables


def of_source(source: str) -> list[str]:
    """Tables of a source."""
    return [name for name in tables() if name.startswith(f"{source}-")]


def rows(table: str) -> dict[str, Printed]:
    """Printed entries of a table by key."""
    return {row.key: row for row in load_table(table)}


def keys(*names: str) -> list[str]:
    """ "table:key" of every entry."""
    return [f"{name}:{key}" for name in names for key in rows(name)]


def found(key: str) -> Evidence:
    """Evidence of an entry "table:key"."""
    table, _, name = key.partition(":")
    return next(e for e in evidence(STUDY, table) if e.printed.key == name)


def check(key: str) -> None:
    """An open entry is not claimed as reproduced; every other one with something to compare agrees."""
    e = found(key)
    digest, verdict = stored()[key]
    if digest == data_digest(e.printed):
        assert e.verdict == verdict, "the verdict changed without its data changing: see rollbench audit"
    if e.printed.cls == "open" or (e.printed.cls == "input" and e.value is None):
        assert e.verdict in ("contradicted", "not identifiable", "input"), "an open entry must not be claimed as reproduced"
        assert e.words or e.printed.remark, "an open entry says why"
    else:
        assert e.agrees is True, f"{e.printed.label}: {e.compared} {e.words}"
