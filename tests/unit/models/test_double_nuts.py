"""Drawn double nuts: what is drawn, what their expected error is calibrated on, and what is not covered."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.models import model_form
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.registry import run_model
from rollbench.compare.scenes import scene_file
from rollbench.compare.studies import survey
from rollbench.meshes.axis import Assembly


def drawn(number: int) -> Assembly:
    found = scene_file.parse_scene(survey.random_double_nut_scene_text(survey.SEED, number), "drawn.toml")
    assert isinstance(found, Assembly)
    return found


def test_double_nuts_are_drawn_within_catalogues_and_braced() -> None:
    for number in range(survey.DOUBLE_NUTS):
        found = drawn(number)
        assert not model_form._unlike_compared_double_nuts(found)
        a, b = (s.parts for s in found.sets)
        assert a.ball_count == b.ball_count <= 40
        gap = b.nut.position - a.nut.position - a.nut.length
        assert 0.04 < gap / a.nut.length < 0.31
        assert {s.thrust for s in found.sets} in ({"+z", "-z"}, {"both"})
    assert survey.random_double_nut_scene_text(survey.SEED, 3) == survey.random_double_nut_scene_text(survey.SEED, 3)


@pytest.mark.parametrize("model", ["lin", "refined"])
def test_a_double_nut_is_calibrated_by_double_nuts_alone(model: str) -> None:
    points = [p for p in model_form.model_errors_on_compared_scenes() if p.model == model]
    like = model_form.ScenesLike.of_kind(model_form.DOUBLE, points)
    stored = survey.built_in_survey("double nut")["scenes"]
    assert len(like.calibrating) == sum(model in r.get("models", {}) for r in stored) >= 12
    assert {len(nuts) for nuts in like.calibrating} == {2}
    assert {p.kind for p in like.fitted} == {"screw"}
    for kind in ("screw", model_form.FLANGE):
        assert model_form.DOUBLE not in {p.kind for p in model_form.ScenesLike.of_kind(kind, points).points}
    held = 0
    for nuts in like.calibrating:
        places = np.array([model_form._scaled_features(p.features, like.scales) for p in nuts])
        bound = model_form._expected_errors(like, places)["percent"]
        held += max(p.percent for p in nuts) <= bound * (1.0 + 1e-9)
    assert held == model_form.calibration_rank(len(like.calibrating))


def test_a_warmed_double_nut_is_not_covered() -> None:
    cold = drawn(0)
    result = run_model(cold, "lin", ModelOptions(estimate_beam_mesh_error=False))
    found = model_form.estimate_double_nut_error(cold, result)
    assert (found.loads is not None, found.calibrated) == (True, len(survey.built_in_survey("double nut")["scenes"]))
    for change, words in (
        ({"thermal_strain": 1e-5}, "its shaft is warmed"),
        ({"sets": (cold.sets[0], replace(cold.sets[1], housing="table"))}, "housings that can move"),
    ):
        other = model_form.estimate_double_nut_error(replace(cold, **change), result)
        assert (other.loads, words in other.words[-1]) == (None, True)
    (why,) = model_form.estimate_double_nut_error(replace(cold, sets=cold.sets[:1]), result).words
    assert "only double nuts" in why
