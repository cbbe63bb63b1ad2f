"""Where the printed errors of Lin 2.4.1 come from: readings judged by the printed ratio alone predict them."""

import numpy as np
import pytest

from rollbench.comparison.evidence.audit import judge
from rollbench.comparison.evidence.registry import evidence
from rollbench.comparison.models.study import Study
from rollbench.comparison.sources.lin.reconstruction import scatter
from rollbench.comparison.sources.lin.reconstruction.combined import (
    ERRORS,
    LOW_MOVERS,
    combinations,
    low_loads,
    meeting,
    predicted,
    ratio,
    solid_loads,
)
from rollbench.comparison.sources.lin.reconstruction.readings import LOW, SOLID, key_of, together
from rollbench.comparison.sources.lin.reconstruction.runs import MOVERS, stored, wanted
from rollbench.comparison.sources.lin.sections.other_statements import has_shape, other_table
from rollbench.comparison.sources.lin.sections.reconstruction import (
    combination_table,
    first_paragraph,
    met_table,
    second_paragraph,
)

pytestmark = pytest.mark.xdist_group("reconstruction")


@pytest.fixture(scope="module")
def study():
    return Study()


def test_readings_that_are_combined_are_those_that_move_the_ratio(study):
    for readings, loads, movers in ((LOW, low_loads, LOW_MOVERS), (SOLID, solid_loads, MOVERS)):
        base = ratio(loads(study, ())[0])
        moves = {r.key for r in readings if not r.by_text and abs(ratio(loads(study, (r,))[0]) / base - 1.0) > 0.005}
        assert moves == set(movers)


def test_combinations_are_of_different_choices():
    for c in together(SOLID, 3):
        assert len({r.choice for r in c}) == len(c)
    assert len(wanted()) == len({key_of(c) for c in wanted()}) == 19
    assert all(stored(c) is not None for c in wanted())


def test_the_defaults_contradict_the_ratio_and_two_readings_meet_it(study):
    found = study.once(combinations)
    base, good = found[0], meeting(found)
    assert (base.low_ratio, base.solid_ratio) == pytest.approx((1.308, 1.406), abs=1e-3)
    assert (key_of(good[0].low), key_of(good[0].solid)) == ("squared+source", "plain")
    assert {key_of(c.solid) for c in good} == {"plain", "runout"}
    assert all("squared" in key_of(c.low) for c in good)
    assert good[0].errors["own"] == pytest.approx((5.36, 2.51, 5.32, 2.51), abs=0.02)


def test_what_comes_out_and_what_does_not(study):
    own = {p.key: p for p in predicted(study, "own")}
    assert [key for key in ERRORS if own[key].comes_out] == ["case1_max_error", "case2_max_error", "case2_rms_error"]
    assert all(p.meshed_low < p.low <= p.nearest <= p.high < p.meshed_high for p in own.values())
    verdicts = {e.printed.key: judge(e)[0] for e in evidence(study, "lin-2.4.1")}
    assert [key for key in ERRORS if verdicts[key] == "inferred"] == [key for key in ERRORS if own[key].comes_out]
    assert verdicts["case1_rms_error"] == "not identifiable"


def test_a_number_that_readings_miss_is_not_inferred(study):
    found = next(e for e in evidence(study, "lin-2.4.1") if e.printed.key == "case1_rms_error")
    assert found.reading is not None
    assert found.holds is False


def test_the_page_answers_first(study):
    text = first_paragraph(study)
    assert text.startswith("Where does 5.38 % come from? It comes out at 5.36 %")
    more = second_paragraph(study, study.once(combinations))
    assert "within 1 % no combinations; within 3 % " in more


def test_scatter_of_the_mesh_is_what_is_measured():
    pytest.importorskip("gmsh")
    found = scatter.mesh_scatter()
    assert found.approach == pytest.approx(scatter.APPROACH, rel=1e-4)
    assert found.bias == pytest.approx(scatter.BIAS, abs=0.3)
    assert found.percent == pytest.approx(scatter.SCATTER, rel=0.3)


def test_drawn_errors_are_those_of_the_loads_without_scatter(study):
    best = meeting(study.once(combinations))[0]
    loads = low_loads(study, best.low), solid_loads(study, best.solid)
    for own, definition in ((True, "own"), (False, "mean")):
        still = scatter.drawn_errors(*loads, 0.0, own=own)
        assert np.ptp(still, axis=0) == pytest.approx(0.0, abs=1e-9)
        assert still[0] == pytest.approx(best.errors[definition], rel=2e-3)
    drawn = scatter.drawn_errors(*loads, 1.0)
    assert (np.median(drawn, axis=0) > still[0]).all()
    assert 0.0 < scatter.share_of_closure(loads[1]) < 1.5  # less than between rigid bodies
    assert scatter.probability(drawn, 0.265, 0.15) > 10.0 * scatter.probability(
        scatter.drawn_errors(*loads, 0.2), 0.265, 0.15
    )


def test_the_shape_of_case_3_is_a_rise_on_the_inner_flanks_of_the_last_balls():
    change = np.zeros((32, 4))
    change[31, 2] = 5.0
    assert has_shape(change)
    assert not has_shape(-change)
    assert not has_shape(change[::-1])
    assert not has_shape(change[:, ::-1] * [0, 0, 0, 0] + np.eye(32, 4, k=-28) * 6.0)


def test_other_statements(study):
    rows = {
        row["place"]: [r for r in other_table(study).rows if r["place"] == row["place"]] for row in other_table(study).rows
    }
    assert all(r["verdict"].count("held") == 3 for r in rows["2.4.1.3, case 3"])
    assert "may be its mesh" in rows["Table 3.5 (a)"][0]["verdict"]
    assert all("load state" in rows[f"Table 3.7 ({case})"][0]["verdict"] for case in "ab")


def test_the_table_of_combinations_has_every_pair_once_and_says_which_meet_the_ratio(study):
    found = study.once(combinations)
    rows = combination_table(found).rows
    pairs = [(row["low order"], row["3D"]) for row in rows]
    assert len(pairs) == len(set(pairs)) == len(found)
    near = {pair for pair, row in zip(pairs, rows, strict=True) if row["meets the ratio"] == "yes"}
    ratios = {pair: (row["low_ratio"], row["solid_ratio"]) for pair, row in zip(pairs, rows, strict=True)}
    assert near == {pair for pair, own in ratios.items() if all(abs(x / 1.34 - 1.0) <= 0.015 for x in own)}
    allowed = {pair for pair, row in zip(pairs, rows, strict=True) if row["text"] == "silent"}
    assert near & allowed == {(row["low order"], row["3D"]) for row in met_table(found).rows}
    assert near - allowed
