"""Printed entries of whole sources: one finding and the expected verdict each, and another verdict for a wrong value."""

import math
from collections import Counter
from dataclasses import replace

import pytest
from tests.evidence_study import GROUP, STUDY
from tests.sources.entries import keys, of_source

from rollbench.compare.evidence import computations_with_function, evidence
from rollbench.compare.printed import load_printed_table
from rollbench.meshes import units

pytestmark = pytest.mark.xdist_group(GROUP)


@pytest.mark.parametrize("source", ["external", "lin", "liu", "smith"])
def test_every_entry_has_one_finding_and_one_verdict(source):
    names = [name for name in of_source(source) if name in computations_with_function()]
    found = evidence(STUDY, *names)
    assert Counter(f"{f.printed.table}:{f.printed.key}" for f in found) == Counter(keys(*names))
    assert [f.printed.name for f in found if f.verdict_change] == []


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
    found = evidence(STUDY, *of_source(source))
    judged = [e for e in found if e.printed.entry_class != "open" and e.agrees_with_printed is not None]
    assert len(judged) > 30
    assert [e.printed.name for e in judged for other in wrong(e) if not other.verdict_change] == []


def test_smith_s_units_of_force_length_and_stiffness_are_readable():
    dimension = dict.fromkeys(("lbf", "N"), "force") | dict.fromkeys(("in", "mm", "uin"), "length")
    dimension |= dict.fromkeys(("deg", "rad"), "angle") | {"in-lbf": "moment", "lbf/in": "stiffness"}
    dimension |= {"psi": "pressure", "degF": "temperature difference"}
    used = Counter(row.unit for name in of_source("smith") for row in load_printed_table(name) if row.number_as_printed)
    for unit in used.keys() & dimension.keys():
        assert units.parse_quantity(f"1 {unit}", dimension[unit]) > 0.0
    assert sum(used[u] for u in dimension) > 180
