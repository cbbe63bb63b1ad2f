"""Evidence of printed numbers: sheets filed entry by entry, the table that shows them, one computation per study."""

import pytest

from rollbench.compare import evidence
from rollbench.compare.evidence import ComputedEntryValues, PrintedEntryComparison
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import load_printed_table, printed_entry


def test_sheet_keeps_the_order_of_the_table_leaves_the_rest_open_and_refuses_what_is_not_printed():
    findings = ComputedEntryValues("lin-3.3")
    findings.add_claim("sign_region", True, "why")
    findings.add_number("mu", 0.1)
    found = findings.comparisons()
    assert [e.printed for e in found] == list(load_printed_table("lin-3.3"))
    filed = {e.printed.key: e.verdict for e in found if e.agrees_with_printed is not None}
    assert filed == {"mu": "input", "sign_region": "reproduced"}
    with pytest.raises(KeyError, match=r"lin-3\.3 of a publication: no printed number or claim has the key 'my'"):
        ComputedEntryValues("lin-3.3").add_number("my", 1.0)
    with pytest.raises(KeyError, match="no printed number or claim has the key"):
        printed_entry("lin-3.3", "my")


def test_compared_value_follows_the_class():
    row = next(r for r in load_printed_table("lin-3.2") if r.entry_class == "as-printed")
    values = {"value": 2.0 * row.value, "as_printed": row.value, "reading": 1.5 * row.value}
    e = PrintedEntryComparison(row, **values)
    assert (e.verdict, e.error_percent) == ("only as printed", 0.0)
    assert e.reading_error_percent == pytest.approx(50.0)


def test_every_computation_fills_its_own_table_only_and_no_screws_are_drawn_unless_asked_for():
    study, computations = SceneResultCache(random_draw_count=0), evidence.computations_with_function()
    for name in ("lin-B1", "lin-3.1", "lin-G", "lin-4.2"):
        assert [e.printed for e in computations[name].compute(study)] == list(load_printed_table(name))
    found = {e.printed.key: e for e in evidence.evidence(study, "lin-2.4.2")}
    assert [found[k].agrees_with_printed for k in ("random_two_point", "random_much", "combined_four_point")] == [None] * 3
    assert found["pitch_much"].agrees_with_printed is True
    assert not any(getattr(key[0], "__name__", "") == "_ensemble" for key in study.computed_values)
