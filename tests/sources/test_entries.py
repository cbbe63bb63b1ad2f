"""Printed entries of whole sources: one finding each, counts by class and verdict, the gate, misprints with evidence."""

from collections import Counter

import pytest
from tests.evidence_study import GROUP, STUDY

from rollbench.comparison.printed.printed_data import load_table, tables
from rollbench.comparison.wings.evidence.audit import judge, misprints
from rollbench.comparison.wings.evidence.gate import evidence_row
from rollbench.comparison.wings.evidence.registry import evidence

pytestmark = pytest.mark.xdist_group(GROUP)

#: Entries by class and verdict.
COUNTS = {
    "external": {
        ("hard", "reproduced"): 45,
        ("hard", "identity"): 11,
        ("as-printed", "only as printed"): 2,
        ("band", "band"): 78,
        ("open", "not identifiable"): 13,
    },
    "liu": {
        ("hard", "reproduced"): 14,
        ("hard", "identity"): 4,
        ("as-printed", "only as printed"): 1,
        ("input", "input"): 18,
        ("band", "band"): 41,
        ("open", "not identifiable"): 6,
        ("open", "contradicted"): 19,
    },
    "smith": {
        ("hard", "reproduced"): 97,
        ("hard", "identity"): 32,
        ("as-printed", "only as printed"): 56,
        ("input", "input"): 62,
        ("band", "band"): 1,
        ("open", "not identifiable"): 49,
        ("open", "contradicted"): 43,
    },
}


def of_source(source):
    return [name for name in tables() if name.startswith(f"{source}-")]


@pytest.mark.parametrize("source", COUNTS)
def test_every_entry_has_one_finding_and_one_verdict(source):
    found = evidence(STUDY, *of_source(source))
    assert Counter((f.printed.table, f.printed.key) for f in found) == Counter(
        (name, row.key) for name in of_source(source) for row in load_table(name)
    )
    assert Counter((f.printed.cls, judge(f)[0]) for f in found) == COUNTS[source]


@pytest.mark.parametrize("source", ["liu", "smith"])
def test_gate_passes_on_what_it_holds(source):
    found = [f for f in evidence(STUDY, *of_source(source)) if f.printed.cls in ("hard", "as-printed", "input")]
    assert all(evidence_row(f, 7.0).passed for f in found)


def test_misprints_have_evidence():
    rows = list(misprints())
    assert Counter(row["source"] for row in rows) == {"lin": 23, "liu": 19, "smith": 40}
    assert all(set(row) >= {"place", "wrong", "right", "evidence"} and all(row.values()) for row in rows)
