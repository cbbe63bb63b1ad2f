"""The error of a model's loads is one number on every page of the report and in every command."""

import re

import pytest

from rollbench.compare.gate.verdict import ErrorLimits, judge_contact_loads
from rollbench.compare.measure import load_error
from rollbench.compare.models import comparison, modelling, registry, study
from rollbench.compare.report.overview import model_accuracy_table, summarise_accuracy_by_model
from rollbench.compare.sections.ladder import model_error_table
from rollbench.compare.sections.reference import contacts_beyond_check_limit_table, load_error_table
from rollbench.compare.sections.reference_time import error_and_time_points, error_and_time_table

NAME = "unseen-thin-nut"
STUDY = study.SceneResultCache()


@pytest.fixture(scope="module")
def found():
    return STUDY.stored_reference(NAME)


def cells(table, label, column):
    """What a table says of the model in the columns of a heading and unit."""
    keys = [c.key for c in table.columns if (c.label, c.unit) == column]
    of_model = [row for row in table.rows if label in (row.get("model"), row.get("name"), row.get("label"))]
    return [row[key] for row in of_model for key in keys]


def test_every_page_says_the_same_error_of_a_thin_nut(found, monkeypatch):
    monkeypatch.setattr(modelling, "RUNGS", [registry.MODELS["lin"]])
    lin = STUDY.solve_once(NAME, "lin")
    e = load_error(lin.load, found.load)
    assert e.own_max_percent > 1.2 * e.max_percent  # so that another measure would show
    label = registry.MODELS["lin"].label
    points = {NAME: error_and_time_points(NAME, found, STUDY, lambda _: None)}
    errors, rungs = (
        load_error_table(STUDY, {NAME: found}),
        model_error_table(modelling.solve_refinement_sequence(STUDY.built_in_scene(NAME), found, STUDY.reference_folders)),
    )
    pages = (
        (errors, label),
        (rungs, "lin"),
        (error_and_time_table(points), label),
        (model_accuracy_table(summarise_accuracy_by_model(points)), "lin"),
    )
    for table, name in pages:
        over = ", maximum over the scenes" if table.name == "overview-models" else ""
        largest = f"largest contact-load error{over}"
        assert cells(table, name, (largest, "% of mean load")) == [pytest.approx(e.max_percent, rel=1e-9)], table.name
    for table, name in pages[:2]:
        assert cells(table, name, ("largest contact-load error", "% of contact's load")) == [
            pytest.approx(e.own_max_percent, rel=1e-9)
        ]
    compared = {
        r.quantity: r
        for r in comparison.comparison_rows(STUDY.built_in_scene(NAME), comparison.solution_from_result(lin), found)
    }
    of_mean = compared[f"largest error, of the mean load (ball {e.ball} {e.side})"]
    of_load = compared["largest error, of the own load"]
    assert (of_mean.value, of_load.value) == (pytest.approx(e.max_percent), pytest.approx(e.own_max_percent))
    shares = 100.0 * found.uncertainty[found.load > 0.0] / found.load[found.load > 0.0]
    assert of_load.reference_error == pytest.approx(shares.max())
    assert of_load.reference_error > of_mean.reference_error
    (verdict,) = judge_contact_loads("lin", lin.load, found, ErrorLimits())
    assert verdict.of_mean == e


def test_errors_of_loads_name_what_they_are_per_cent_of(found):
    for table in (load_error_table(STUDY, {NAME: found}), contacts_beyond_check_limit_table({NAME: found}, STUDY)):
        units = {c.label: c.unit for c in table.columns if c.unit and re.search("error|uncertainty|rigid", c.label)}
        assert units
        assert set(units.values()) <= {"% of mean load", "% of contact's load"}, table.name
