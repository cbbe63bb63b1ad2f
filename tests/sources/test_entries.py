"""Printed entries of whole sources: one finding each, counts by class and verdict, the gate, misprints with evidence."""

import math
from collections import Counter
from dataclasses import replace

import pytest
from tests.evidence_study import GROUP, STUDY
from tests.sources.entries import keys, of_source

from rollbench.compare.evidence import computations_with_function, evidence, misprint_rows
from rollbench.compare.gate.gate import gate_check_of_published_entry

pytestmark = pytest.mark.xdist_group(GROUP)

#: Entries by class and verdict.
COUNTS = {
    ("hard", "reproduced"): {"external": 48, "lin": 32, "liu": 14, "smith": 98},
    ("hard", "identity"): {"external": 11, "lin": 14, "liu": 4, "smith": 35},
    ("as-printed", "only as printed"): {"external": 2, "lin": 63, "liu": 1, "smith": 57},
    ("as-printed", "identity"): {"lin": 4},
    ("input", "input"): {"lin": 97, "liu": 18, "smith": 78},
    ("band", "band"): {"external": 79, "lin": 11, "liu": 34, "smith": 1},
    ("open", "not identifiable"): {"external": 13, "lin": 40, "liu": 20, "smith": 50},
    ("open", "contradicted"): {"lin": 10, "liu": 12, "smith": 43},
}
#: Entries that are judged by a value or a claim.
SHIFTED = {"external": 140, "kalker": 36, "lin": 218, "liu": 71, "smith": 269}


@pytest.mark.parametrize("source", ["external", "lin", "liu", "smith"])
def test_every_entry_has_one_finding_and_one_verdict(source):
    names = [name for name in of_source(source) if name in computations_with_function()]
    found = evidence(STUDY, *names)
    assert Counter(f"{f.printed.table}:{f.printed.key}" for f in found) == Counter(keys(*names))
    counted = {kind: of[source] for kind, of in COUNTS.items() if source in of}
    assert Counter((f.printed.entry_class, f.verdict) for f in found) == counted


def wrong(e):
    """A judged entry with other values: off by twice the tolerance, beyond the band on either side, not what is claimed."""
    p = e.printed
    if p.value is None:
        return [replace(e, claim_is_true=not e.claim_is_true)]
    step = 2.0 * p.tolerance or 1e-6 * abs(p.value)  # an exact number has no tolerance
    off = e.compared_value + math.copysign(step, e.compared_value - p.value)
    others = [off] if p.entry_class != "band" else [p.low - step, p.high + step]
    return [replace(e, **{"as_printed" if p.entry_class == "as-printed" else "value": other}) for other in others]


@pytest.mark.parametrize("source", ["external", "kalker", "lin", "liu", "smith"])
def test_a_value_off_by_twice_its_tolerance_changes_the_verdict(source):
    judged = [
        e
        for e in evidence(STUDY, *of_source(source))
        if e.printed.entry_class != "open" and e.agrees_with_printed is not None
    ]
    assert len(judged) == SHIFTED[source]
    assert [e.printed.name for e in judged for other in wrong(e) if not other.verdict_change] == []


@pytest.mark.parametrize("source", ["liu", "smith"])
def test_gate_passes_on_what_it_holds(source):
    found = [f for f in evidence(STUDY, *of_source(source)) if f.printed.entry_class in ("hard", "as-printed", "input")]
    assert all(gate_check_of_published_entry(f, 7.0).passed for f in found)


def test_misprints_have_evidence():
    rows = list(misprint_rows())
    assert Counter(row["source"] for row in rows) == {"lin": 23, "liu": 19, "smith": 40}
    assert all(set(row) >= {"place", "wrong", "right", "evidence"} and all(row.values()) for row in rows)
