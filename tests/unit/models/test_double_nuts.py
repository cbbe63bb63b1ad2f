"""Drawn double nuts: what is drawn, what their expected error is calibrated on, and what is not covered."""

from dataclasses import replace

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
