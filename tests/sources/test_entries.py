"""Printed entries of whole sources: one finding and the expected verdict each, and another verdict for a wrong value."""

import functools
import gc
import math
import zlib
from collections import Counter
from dataclasses import replace

import pytest
from tests.evidence_study import GROUP, STUDY
from tests.sources.entries import keys, of_source

from rollbench.compare import printed
from rollbench.compare.evidence import computations_with_function, evidence
from rollbench.compare.models.study import SceneResultCache
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
    compared = "as_printed" if p.entry_class == "as-printed" else "value"
    return [replace(e, **{"follows" if p.kind == "arithmetic" else compared: other}) for other in others]


@pytest.mark.parametrize("source", ["external", "kalker", "lin", "liu", "smith"])
def test_a_value_off_by_twice_its_tolerance_changes_the_verdict(source):
    found = evidence(STUDY, *of_source(source))
    judged = [e for e in found if e.printed.entry_class != "open" and e.agrees_with_printed is not None]
    assert len(judged) > 30
    assert [e.printed.name for e in judged for other in wrong(e) if not other.verdict_change] == []


#: Tables that few seconds compute and whose functions read printed numbers.
READING = (
    *(name for name in of_source("smith") if name != "smith-table-2-1"),
    *("lin-3.3", "lin-3.5", "lin-3.7", "lin-G", "liu-2", "liu-4.1", "liu-4.2", "external-thk"),
)
#: Printed inputs that repeat themselves; a slip of the publication that is repeated at a printed step.
ITSELF = {"liu-2:v_2pi", "liu-2:ball_error", "liu-2:profile_error", "lin-G:eta"}


@pytest.fixture
def without_kept_results():
    """Results that functions of the cases keep are dropped before and after the test."""

    def drop():
        for kept in gc.get_objects():
            if isinstance(kept, functools._lru_cache_wrapper) and kept.__module__.startswith("rollbench.compare.cases"):
                kept.cache_clear()

    drop()
    yield
    drop()


@pytest.mark.usefixtures("without_kept_results")
@pytest.mark.parametrize("name", READING)
def test_no_value_of_a_model_changes_with_a_printed_result(name, monkeypatch):
    """Printed numbers 0.1 to 0.2 % larger, each by another share: what follows from them changes, what is computed not."""

    def enlarged(table):
        def share(row):
            return 1.001 + 1e-3 * (zlib.crc32(row.name.encode()) % 1000) / 1000

        return tuple(replace(r, value=r.value and r.value * share(r)) for r in load_printed_table(table))

    before = {e.printed.name: e for e in evidence(STUDY, name)}
    monkeypatch.setattr(printed, "load_printed_table", enlarged)
    after = {e.printed.name: e for e in computations_with_function()[name].compute(SceneResultCache())}
    changed = {key for key, e in before.items() if (e.value, e.reference) != (after[key].value, after[key].reference)}
    assert changed <= ITSELF
    assert all(e.verdict != "reproduced" for e in before.values() if e.follows is not None)


def test_smith_s_units_of_force_length_and_stiffness_are_readable():
    dimension = dict.fromkeys(("lbf", "N"), "force") | dict.fromkeys(("in", "mm", "uin"), "length")
    dimension |= dict.fromkeys(("deg", "rad"), "angle") | {"in-lbf": "moment", "lbf/in": "stiffness"}
    dimension |= {"psi": "pressure", "degF": "temperature difference"}
    used = Counter(row.unit for name in of_source("smith") for row in load_printed_table(name) if row.number_as_printed)
    for unit in used.keys() & dimension.keys():
        assert units.parse_quantity(f"1 {unit}", dimension[unit]) > 0.0
    assert sum(used[u] for u in dimension) > 180
