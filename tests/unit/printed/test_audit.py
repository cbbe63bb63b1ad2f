"""Verdicts by rule and as they are expected, misprints with a test each; ``rollbench check --printed``."""

import re
from collections import Counter
from dataclasses import replace

import pytest
from tests.copies import ROOT

from rollbench.compare.evidence import (
    PrintedEntryComparison,
    count_entries_by_verdict,
    misprint_rows,
    publication_titles,
    reproduction_sentence,
)
from rollbench.compare.printed import VERDICTS, PrintedEntry, load_printed_table, printed_table_names

ENTRIES = [row for name in printed_table_names() for row in load_printed_table(name)]
PLAIN = PrintedEntry("lin-x", "a", "b", 1.0, "N", "Lin (2019), 1", "hard", 0.005, "why", "1.00")


RULES = [
    ({}, {"value": 1.004}, "reproduced"),
    ({}, {"value": 1.1}, "contradicted"),
    ({}, {}, "not identifiable"),
    ({"entry_class": "as-printed"}, {"value": 2.0, "as_printed": 1.0}, "only as printed"),
    ({"entry_class": "band", "low": 0.5, "high": 2.0}, {"value": 1.5}, "band"),
    ({"entry_class": "band", "low": 0.5, "high": 2.0}, {"value": 2.5}, "contradicted"),
    ({"entry_class": "input", "kind": "input"}, {}, "input"),
    ({"entry_class": "input", "kind": "input"}, {"value": 2.0}, "contradicted"),
    ({"kind": "arithmetic"}, {"follows": 1.0, "value": 2.0}, "identity"),
    ({"kind": "arithmetic"}, {"follows": 2.0}, "contradicted"),
    ({"kind": "arithmetic"}, {"value": 1.0}, "not identifiable"),
    ({}, {"follows": 1.0}, "not identifiable"),
    ({"kind": "zero"}, {"value": 1.0}, "identity"),
    ({"entry_class": "open"}, {"value": 1.0}, "not identifiable"),
    ({"entry_class": "open", "value": None, "claim": "so"}, {"claim_is_true": True}, "not identifiable"),
    ({"value": None, "claim": "so"}, {"claim_is_true": True}, "reproduced"),
    ({"value": None, "claim": "so"}, {"claim_is_true": False}, "contradicted"),
    ({"entry_class": "open", "contradicting_statement": "its sums"}, {"value": 1.0}, "contradicted"),
]


@pytest.mark.parametrize(("change", "found", "verdict"), RULES)
def test_verdict_by_rule(change, found, verdict):
    assert PrintedEntryComparison(replace(PLAIN, **change), **found).verdict == verdict


def test_every_entry_has_an_expected_verdict_and_what_contradicts_an_open_one_a_reason():
    assert [row.name for row in ENTRIES if row.expected_verdict is None] == []
    opened = [row for row in ENTRIES if row.entry_class == "open"]
    assert all((row.expected_verdict == "contradicted") == bool(row.contradicting_statement) for row in opened)


def test_counts_by_source_add_up():
    rows = [PrintedEntryComparison(row) for row in ENTRIES]
    counted = count_entries_by_verdict(rows)
    assert [row["source"] for row in counted] == [*publication_titles(), "all"]
    total = Counter(row.verdict for row in rows)
    assert {v: counted[-1][v] for v in VERDICTS} == {v: total[v] for v in VERDICTS}
    assert counted[-1]["all"] == len(ENTRIES) == sum(row["all"] for row in counted[:-1])
    assert all(row["judged"] == row["all"] - row["input"] - row["identity"] for row in counted)
    assert all(str(row["contradicted"]) in reproduction_sentence(row) for row in counted)


@pytest.mark.parametrize("row", misprint_rows(), ids=lambda row: f"{row['source']}-{row['place']}-{row['wrong'][:20]}")
def test_every_misprint_has_a_command_and_a_test(row):
    path, _, name = row["test"].partition("::")
    assert re.search(rf"^def {name}\(", (ROOT / path).read_text(encoding="utf-8"), re.MULTILINE), row["test"]
    if row["command"].startswith("rollbench"):
        assert row["command"].split()[-1] in printed_table_names()
    else:
        assert row["command"] == f"pytest {row['test']}"


HERE = ("check", "--printed")


def test_sources_tables_and_entries_can_be_chosen(command):
    whole = command.answer(*HERE, "--only", "lin-B1")
    assert {row["entry"] for row in whole["entries"]} == {row.name for row in load_printed_table("lin-B1")}
    assert command.answer("audit", "--only", "lin-B1") == whole
    (one,) = command.answer(*HERE, "--only", "lin-B1:e_S")["entries"]
    assert one in whole["entries"]
    kalker = command.answer(*HERE, "--source", "kalker", "--only", "kalker-E3")
    assert {row["source"] for row in kalker["entries"]} == {"Kalker (1990)"}


def test_a_verdict_that_differs_from_the_expected_is_shown_and_fails(command, monkeypatch):
    rows = load_printed_table("lin-B1")
    other = tuple(replace(row, expected_verdict="identity") if row.key == "e_S" else row for row in rows)
    monkeypatch.setattr("rollbench.compare.evidence.load_printed_table", lambda _: other)
    code, data = command.json(*HERE, "--only", "lin-B1:e_S", "--json")
    assert code == 1
    said = "lin-B1:e_S: the expected verdict is identity, the actual verdict is only as printed"
    assert data["changed_verdicts"] == [said]
    code, out, _ = command(*HERE, "--only", "lin-B1")
    assert (code, "changed: lin-B1:e_S" in out) == (1, True)
    assert command(*HERE, "--only", "lin-B1:rho_eq_S").code == 0
