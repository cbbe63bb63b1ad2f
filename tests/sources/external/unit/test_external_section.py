"""Sections on external evidence and on u_val: what their tables are made of."""

import numpy as np
from tests.sources.entries import of_source, rows

from rollbench.compare.cases.external import page
from rollbench.compare.evidence import PrintedEntryComparison
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.models.uncertainty import BiasAndScatter, ErrorWithUncertainty
from rollbench.compare.sections.u_val import bias_and_scatter_figure, bias_and_scatter_table, errors_with_u_val_table
from rollbench.reports.figures import draw_figure


def test_every_external_table_has_a_title():
    assert sorted(page.TITLES) == sorted(page.SOURCES) == of_source("external")


def test_summary_counts_what_comes_out():
    computed = {"radial": 15.1102, "tilt": 3.65, "axial": 140.0}
    found = [PrintedEntryComparison(rows("external-masta")[key], value) for key, value in computed.items()]
    assert page.agreement_sentence(found).startswith(
        "2 of 3 published values and claims agree with the computed ones. Of these, 1 agree"
    )
    assert "1 within a band" in page.agreement_sentence(found)


def test_what_was_inferred_is_listed():
    study = SceneResultCache()
    study.record_used_scenes(("external-masta-radial", "external-thk-bnf-4010-5"))
    cases = {row["case"] for row in page.assumptions_table(study).rows}
    assert {"external-masta-radial", "external-thk-bnf-4010-5", "external-gmn", "external-snfa"} <= cases


def test_catalogue_over_the_three_rigidities():
    rigidities = {"contacts": 1000.0, "bodies": 900.0, "unequal": 800.0, "printed": 600.0}
    (row,) = page.nut_rigidities_table(SceneResultCache(reference_folders=()), [("a", 5000.0, rigidities)], ()).rows
    shares = [row[f"share_{key}"] for key in ("contacts", "bodies", "unequal")]
    assert np.allclose(shares, [0.6, 2.0 / 3.0, 0.75])


def test_u_val_says_what_an_error_is_worth_and_bias_and_scatter_are_drawn():
    small = ErrorWithUncertainty("s", "refined", "contact loads", 0.5, 0.1, 0.3, 1.0, 1.05, 1.0, 0.8, (1.0,), "lin-case1")
    large = ErrorWithUncertainty("s", "lin", "contact loads", -6.0, 0.1, 0.3, 1.0, 1.05, 0.5, 0.2, (0.9,), "lin-case1")
    says = [row["says"] for row in errors_with_u_val_table([small, large]).rows]
    assert says == ["E within u_val", "error of the model, E ± u_val"]
    found = [BiasAndScatter("lin", "contact loads", 15, 900, 0.3, 2.9, 0.8, 0.5)]
    assert bias_and_scatter_table(found).rows[0]["within_own"] == 50.0
    assert "<svg" in draw_figure(bias_and_scatter_figure(found))
