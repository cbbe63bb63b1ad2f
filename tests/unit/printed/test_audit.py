"""The audit: verdicts by rule, the stored list, misprints with a test each."""

import re
from dataclasses import replace

import pytest
from tests.copies import ROOT

from rollbench.compare.printed.printed_data import Printed, load_table, tables
from rollbench.compare.wings.evidence import audit, record

ENTRIES = [row for name in tables() for row in load_table(name)]
PLAIN = Printed("lin-x", "a", "b", 1.0, "N", "Lin (2019), 1", "hard", 0.005, "why", "1.00")


RULES = [
    ({}, {"value": 1.004}, "reproduced"),
    ({}, {"value": 1.1}, "contradicted"),
    ({}, {}, "not identifiable"),
    ({"cls": "as-printed"}, {"value": 2.0, "as_printed": 1.0}, "only as printed"),
    ({"cls": "band", "low": 0.5, "high": 2.0}, {"value": 1.5}, "band"),
    ({"cls": "band", "low": 0.5, "high": 2.0}, {"value": 2.5}, "contradicted"),
    ({"cls": "input", "kind": "input"}, {}, "input"),
    ({"cls": "input", "kind": "input"}, {"value": 2.0}, "contradicted"),
    ({"kind": "arithmetic"}, {"value": 1.0}, "identity"),
    ({"kind": "zero"}, {"value": 1.0}, "identity"),
    ({"cls": "open"}, {"value": 1.0}, "not identifiable"),
    ({"cls": "open", "value": None, "claim": "so"}, {"holds": False}, "not identifiable"),
    ({"cls": "open", "value": None, "claim": "so"}, {"holds": True}, "not identifiable"),
    ({"value": None, "claim": "so"}, {"holds": True}, "reproduced"),
    ({"value": None, "claim": "so"}, {"holds": False}, "contradicted"),
    ({"cls": "open", "table": "liu-4.2", "key": "plus_Q33_5000"}, {"value": 142.9}, "contradicted"),
]


@pytest.mark.parametrize(("change", "found", "verdict"), RULES)
def test_verdict_by_rule(change, found, verdict):
    assert audit.judge(record.Evidence(replace(PLAIN, **change), **found))[0] == verdict


def test_every_entry_is_in_the_stored_list_with_its_data():
    names = {f"{row.table}:{row.key}": row for row in ENTRIES}
    assert set(audit.stored()) == set(names)
    for name, row in names.items():
        digest, verdict = audit.stored()[name]
        assert digest == audit.data_digest(row), f"{name}: its data changed; judge it again: rollbench audit --write"
        assert verdict in audit.VERDICTS


def test_a_verdict_that_changes_without_its_data_is_named(monkeypatch):
    (row,) = (r for r in ENTRIES if (r.table, r.key) == ("lin-B1", "e_S"))
    one = audit.Audited(record.Evidence(row), "contradicted", "")
    held = {one.name: (audit.data_digest(row), "only as printed")}
    monkeypatch.setattr(audit, "stored", lambda: held)
    assert audit.changes([one]) == ["lin-B1:e_S: only as printed became contradicted, without its data changing"]
    held[one.name] = ("x", "only as printed")
    assert "so did its data" in audit.changes([one])[0]
    held[one.name] = (audit.data_digest(row), "contradicted")
    assert audit.changes([one]) == []


@pytest.mark.parametrize("row", audit.misprints(), ids=lambda row: f"{row['source']}-{row['place']}-{row['wrong'][:20]}")
def test_every_misprint_has_a_command_and_a_test(row):
    path, _, name = row["test"].partition("::")
    assert re.search(rf"^def {name}\(", (ROOT / path).read_text(encoding="utf-8"), re.MULTILINE), row["test"]
    if row["command"].startswith("rollbench"):
        assert row["command"].split()[-1] in tables()
    else:
        assert row["command"] == f"pytest {row['test']}"
