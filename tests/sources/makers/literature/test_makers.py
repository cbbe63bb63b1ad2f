"""Makers' tables and measurements: what is predicted without a free parameter, what lies in bands, what is not judged."""

from dataclasses import replace

import numpy as np
import pytest
from tests.evidence_study import GROUP, STUDY

from rollbench.compare.cases.makers import bearings, from_catalogue, nuts, outside, page
from rollbench.compare.scenes import makers

pytestmark = pytest.mark.xdist_group(GROUP)


def one(value: float, computed: outside.ComputedBand, **said: object) -> outside.PublishedValue:
    shared = {word: word for word in ("quantity", "law", "maker", "part", "kind_of_source", "origin", "unit")}
    return outside.PublishedValue(**shared, value=value, rounding=0.5, computed=computed, **said)


def held_to(values: list[outside.PublishedValue], number: int, bias: float, scatter: float) -> None:
    """So many values count, with a mean error and a scatter below these [%]."""
    found = outside.error_statistics(values)
    assert found["published_values"] == number
    assert abs(found["bias_f1"]) < bias
    assert found["scatter_f1"] < scatter


def test_sets_of_equal_gaps_at_a_constant_angle() -> None:
    """Closed forms: a row of a pair deflects by u; of three rows, one by P^(2/3), two by (P/2)^(2/3), 2 u in all."""
    preload = (2.0 / (1.0 + 2.0 ** (-2 / 3))) ** 1.5
    found = bearings.bearing_set_over_pair_ratios("DBD")
    grown = (preload ** (k / 3) * 0.5 * (1.0 + 2.0 * 2.0 ** (-k / 3)) for k in (1, 4))
    assert found == pytest.approx((preload, *grown), rel=1e-12)
    assert bearings.bearing_set_over_pair_ratios("DBB") == pytest.approx((2.0, 2.0, 2.0), rel=1e-12)
    triple = (2.0 / (1.0 + 3.0 ** (-2 / 3))) ** 1.5
    assert bearings.bearing_set_over_pair_ratios("DBT")[0] == pytest.approx(triple, rel=1e-12)


@pytest.mark.parametrize(("quantity", "number", "bias", "scatter"), [("preload", 80, 0.5, 1.0), ("rigidity", 77, 1.0, 2.0)])
def test_nsk_sets_follow_from_their_pairs(quantity: str, number: int, bias: float, scatter: float) -> None:
    values = [x for x in bearings.compare_nsk_bearing_sets() if x.quantity == quantity and not x.part.endswith(" DB")]
    held_to(values, number, bias, scatter)
    wrong = [x.part for x in values if x.left == "a misprint"]
    assert wrong == ([f"{bore}TAC47B C9 DBD" for bore in (15, 17, 20)] if quantity == "rigidity" else [])


def test_nsk_clearances_and_rigidities_without_a_free_parameter() -> None:
    found = list(bearings.compare_nsk_ball_bearings())
    clear = np.array([x.computed.value - x.value for x in found if x.quantity == "displacement"])
    assert (clear.size, np.sqrt((clear**2).mean()) < 0.6, (np.abs(clear) <= 1.0).mean() > 0.94) == (728, True, True)
    for quantity, number, bias, scatter in (("rigidity", 546, 0.6, 2.0), ("rating", 91, 0.1, 1.0)):
        held_to([x for x in found if x.quantity == quantity], number, bias, scatter)


def test_balls_come_back_from_their_ratings() -> None:
    ring = bearings.single_row_bearing_scene(14, 6e-3, 40e-3, np.radians(15.0))
    both = bearings.dynamic_rating(ring), bearings.static_rating(ring)
    count, ball = bearings.ball_count_and_diameter_from_ratings(*both, 40e-3, np.radians(15.0))
    assert (count, ball) == pytest.approx((14.0, 6e-3), rel=1e-4)


def test_two_ratings_of_a_nut_count_the_same_balls() -> None:
    """C and C_0 are two formulas; HIWIN's nuts of deflectors are rated with two thirds of a turn, the others with all."""
    shares: dict[str, list[float]] = {}
    source = makers.read_maker_table("nuts-hiwin")
    for row in source.rows:
        if not source.is_listed_as_misprint(row["nut"]):
            name, nut = nuts.maker_and_rated_nut_type(source, row), nuts.nut_of_catalogue_row(source, row)
            dynamic, static = nuts.nut_load_ratings(nut, nuts.CONFORMITY, 1.0)
            shares.setdefault(name, []).append(source.parse_number(row["C0"]) / static)
            shares.setdefault(f"{name} by C", []).append((source.parse_number(row["C"]) / dynamic) ** 1.5)
    middle = {name: float(np.median(x)) for name, x in shares.items()}
    for name, share in (("HIWIN, whole recirculation", 1.0), ("HIWIN, one-turn recirculation", 2.0 / 3.0)):
        assert middle[name] == pytest.approx(share, rel=0.03)
        assert middle[f"{name} by C"] == pytest.approx(share, rel=0.03)


def test_ratings_of_fewer_balls_and_more_turns() -> None:
    one = nuts.CatalogueNut(6.35e-3, 41.4e-3, 10e-3, 1.0, has_one_turn_circuits=False)
    full, half = nuts.nut_load_ratings(one, 0.52, 1.0), nuts.nut_load_ratings(replace(one, turns=3.0), 0.52, 0.5)
    assert half[0] / full[0] == pytest.approx(0.5 ** (2 / 3) * 3.0**0.86)
    assert half[1] / full[1] == pytest.approx(1.5)


def test_formulas_in_disguise_are_computed_and_not_judged() -> None:
    found = list(bearings.compare_snfa_pair_rigidities())
    assert (len(found), outside.error_statistics(found)) == (1020, None)
    ratio = np.median([x.computed.value / x.value for x in found])
    assert ratio == pytest.approx(1.0, abs=0.25)


def test_four_fifths_of_the_computed_rigidity_is_what_makers_print() -> None:
    judged = [x for x in nuts.compare_nut_rigidity() if not x.left]
    errors = np.array([(x.practice or 0.0) / x.value - 1.0 for x in judged])
    assert (len(judged), abs(np.median(errors)) < 0.1, (np.abs(errors) < 0.2).mean() > 0.85) == (472, True, True)
    held_to([x for x in nuts.compare_preloaded_nuts() if x.law == "growth with preload"], 126, 2.0, 2.0)


def test_circuits_as_printed() -> None:
    known = {
        ("4", "T4 of the name"): (4, 1.0, False),
        ("31", "rows x turns"): (3, 1.0, False),
        ("22.8", "rows x turns"): (2, 2.8, False),
        ("1x4", "1x4"): (4, 1.0, False),
        ("4", "K4 of the name"): (1, 4.0, False),
        ("2", "1.7"): (2, 1.7, False),
        ("", "1,2x4"): (4, 1.2, True),
        ("", "6"): (1, 6.0, False),
    }
    for (circuits, turns), expected in known.items():
        assert makers.read_circuits({"circuits": circuits, "turns": turns}) == expected


def test_nuts_from_their_names_alone_are_near_what_their_makers_print() -> None:
    """No ball is counted from a rating; what is far off is named: a nut whose printed C is below that of a smaller one."""
    table = from_catalogue.catalogue_ratios_table()
    found = from_catalogue.ratios_of_all_nuts()
    assert len(found) == 582
    for key in ("C", "C0", "K"):
        values = np.array(
            [x for one in found if not one.group.startswith("Rexroth") and (x := one.ratios[key]) is not None]
        )
        assert (0.8 < np.median(values) < 1.25, ((values > 0.7) & (values < 1.4)).mean() > 0.75) == (True, True)
    named = " ".join(str(cell) for row in table.rows for cell in row.values())
    assert "R16-2T4-RSI: C 2.39" in named
    assert "SFE5050-6: C" not in named, "a misprint of C is left out"
    assert "K of all" in named


def test_no_ball_is_counted_from_a_rating() -> None:
    part = makers.find_part("THK BNF 2005-5")
    other = replace(part, row=dict(part.row) | {"C": "30", "C0": "70"})
    first, second = map(from_catalogue.scene_of_part, (part, other))
    assert second.rating.static == 2.0 * first.rating.static
    assert replace(second, rating=first.rating) == first


def test_drag_torque_of_the_measured_screws() -> None:
    """New screws lie in the band of what is not printed; over the lead sliding grows less than all formulas but one."""
    new = [x for x in nuts.compare_measured_drag_torques() if x.part.endswith("new")]
    assert [x.verdict for x in new] == ["in the band"] * 2
    assert {x.kind_of_source for x in new} == {outside.MEASURED}
    columns = page.drag_torque_table().columns
    grows = nuts.fit_power_exponent(columns["drag_torque_single"], columns["lead"])
    assert 0.1 < grows < 0.2
    thk = nuts.FORMULAS["THK: 0.05/sqrt(tan beta) F P/2 pi"]
    assert thk(3000.0, 41.75e-3, 10e-3) == pytest.approx(0.865, rel=2e-3)  # THK's example


def test_all_values_and_their_table() -> None:
    found = page.all_published_values(STUDY)
    judged = [x for x in found if not x.left]
    assert len(judged) >= 1500
    assert {"contact load", "displacement", "pressure", "torque", "rigidity", "rating"} <= {x.quantity for x in judged}
    assert all(x.computed.low <= x.computed.value <= x.computed.high and x.origin for x in found)
    assert len(outside.bias_and_scatter_table(found).rows) <= 31
    columns = page.first_page(STUDY)
    assert sum(row["values"] for row in columns.values()) == len(judged)
    assert abs(columns["preload"]["bias"]) < 0.5


def test_section_says_its_conclusion_first() -> None:
    found = page.make_section(STUDY, lambda _: None)
    judged = [x for x in page.all_published_values(STUDY) if not x.left]
    assert found.conclusion.startswith(f"Of {len(judged)} values")
    assert "1020: a formula in disguise" in found.items[1].note


def test_half_of_the_last_step() -> None:
    steps = {"2 150": 5.0, "0.14": 0.005, "7": 0.5, "1,5": 0.05, "-12": 0.5, "300": 50.0}
    assert {text: makers.half_step_of_last_digit(text) for text in steps} == pytest.approx(steps)


def test_verdicts_and_what_does_not_count() -> None:
    band = outside.ComputedBand.from_relative_half_width(100.0, 0.02)
    verdicts = [one(x, band).verdict for x in (97.4, 97.6, 102.4, 102.6)]
    assert verdicts == ["below the band", *2 * ["in the band"], "above the band"]
    formula = replace(one(97.0, band), left="a formula in disguise")
    assert formula.verdict == "a formula in disguise"
    assert outside.error_statistics([formula]) is None
    both = outside.error_statistics([one(80.0, band), one(125.0, band), formula])
    assert [both[key] for key in ("published_values", "bias_f1", "scatter_f1")] == pytest.approx([2, 2.5, 22.5])


def test_numbers_as_tables_write_them() -> None:
    assert makers.MakerTable("x", {"decimal": ","}, ()).parse_number("1 250,5") == 1250.5
    assert makers.MakerTable("x", {"thousands": ","}, ()).parse_number("12,500") == 12500.0
    assert makers.MakerTable("x", {}, ()).parse_number("\u00a02 150") == 2150.0
