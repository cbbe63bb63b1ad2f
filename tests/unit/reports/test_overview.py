"""The first screen: medians, Pareto front, answer and figure, from points that are known; whose line 7 % is."""

from dataclasses import replace

import pytest

from rollbench.compare.models.applicability import descriptors_of_built_in_scenes, survey_records_of_random_screws
from rollbench.compare.models.model_form import DOUBLE, model_errors_on_compared_scenes
from rollbench.compare.models.registry import MODELS
from rollbench.compare.report import overview
from rollbench.compare.sections.reference_time import ErrorAndRunTime


def point(label: str, error: float, cold: float, kind: str = "model", **changes: object) -> ErrorAndRunTime:
    name = next((m.name for m in MODELS.values() if m.label == label), label.replace("3D reference, level", "3D level"))
    low, high = 0.9 * error, 1.1 * error + 0.1
    gate = 1.2 * error, 1.2 * high
    measured = ErrorAndRunTime(label, kind, error, error / 2.0, low, high, cold, 0.1, 65, 100.0, name, *gate)  # type: ignore[arg-type]
    return replace(measured, **changes)  # type: ignore[arg-type]


def scene(factor: float) -> list[ErrorAndRunTime]:
    return [
        point(MODELS["refined"].label, 1.0 * factor, 2.0),
        point(MODELS["lin"].label, 6.0 * factor, 1.0),
        point(MODELS["source"].label, 6.0 * factor, 1.5),
        point(MODELS["mei"].label, 20.0 * factor, 1.2, status="no convergence" if factor > 2.0 else "converged"),
        point("3D reference, level 1", 0.2 * factor, 40.0, "level"),
        point("3D reference, level 3", 0.0, 130.0, "level"),
    ]


POINTS = {"a": scene(1.0), "b": scene(2.0), "c": scene(3.0)}


def test_standings_are_medians_and_worst_cases_of_what_converged() -> None:
    table = overview.model_accuracy_table(POINTS)
    found = {row["model_or_level"]: row for row in table.rows}
    within, largest, median = ("scenes_within", "7"), "largest_load_error_over_scenes", overview.MEDIAN
    refined = found["refined"]
    assert (refined["scenes"], refined[within], refined["scene_of_largest_error"]) == (3, 3, "c")
    assert (refined[median], refined[largest]) == (2.0, 3.0)
    assert (refined["rms_error_over_scenes_median"], refined["rms_error_over_scenes"]) == (1.0, 1.5)
    assert refined["check_error_median"] == pytest.approx(2.4)
    # 6 % of the mean load, 7.2 % by the gate's rule: within no line of 7 %
    assert (found["mei"]["scenes"], found["mei"][largest], found["lin"][within]) == (2, 40.0, 0)
    assert found["3D level 3"][median] == pytest.approx(0.1)  # its uncertainty: it is the best estimate itself
    assert table.columns[median] == sorted(table.columns[median], reverse=True), "least accurate first"


def test_every_screw_that_was_compared_is_in_the_first_figure() -> None:
    single = [errors for errors in model_errors_on_compared_scenes() if errors.kind != DOUBLE]
    screws = overview.largest_load_errors_on_screws(single)
    rows = {row["number"]: row["models"] for row in survey_records_of_random_screws() if row.get("models")}
    panel = overview.error_distribution_and_time_figure(screws, []).panels[0]
    for model, curve in zip(screws, panel.series, strict=True):
        drawn = [models[model]["largest_percent"] for models in rows.values()]
        assert len(drawn) > 200
        assert set(drawn) <= set(curve.x)
        assert len(curve.x) == len(drawn) + len(descriptors_of_built_in_scenes(of_bearings=False))
        assert (curve.y[-1], sorted(curve.x)) == (pytest.approx(100.0), list(curve.x))

    assert not [curve for curve in panel.series if 7.0 in curve.x and len(set(curve.x)) == 1], "no line on the mean load"
