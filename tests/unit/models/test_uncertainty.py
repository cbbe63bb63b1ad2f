"""What a comparison is uncertain by: parts, their words, and whose choices speak for a scene."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare.models import uncertainty
from rollbench.compare.models import uncertainty as models_uncertainty
from rollbench.compare.models.answers import results_of_contact_loads
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.quantities import record_as_json
from rollbench.compare.reference.estimate import largest_uncertainty_percent
from rollbench.meshes.parts import Material

pytestmark = pytest.mark.xdist_group("u_val")

STUDY = SceneResultCache()
KNOWN = {
    "lin-case1": models_uncertainty.LargestChoiceEffects("lin-case1", 1.5, "lands", 1.2),
    "lin-case3": models_uncertainty.LargestChoiceEffects("lin-case3", 2.5, "held face", 2.4),
}
WHOLE = models_uncertainty.LoadUncertainty(0.3, False, KNOWN["lin-case3"], 0.4, "angle, where there is one", 1.2, True)


def test_parts_add_by_squares_and_the_largest_are_named() -> None:
    assert WHOLE.percent == pytest.approx(np.sqrt(0.3**2 + 2.5**2 + 0.4**2 + 1.2**2))
    assert WHOLE.uncertainty_text == (
        "uncertain by 2.82 % in total: discretisation 0.30 %; modelling choices 2.50 %, mainly held face; inputs 0.40 %, "
        "mainly angle; large displacements 1.20 %"
    )
    assert "0.12 to 0.19 % larger" in WHOLE.shared_error_sentence
    less = replace(WHOLE, choices=None, inputs=None, by_experience=True, shared=False)
    assert less.percent == pytest.approx(np.hypot(0.3, 1.2))
    assert "by experience with other scenes; modelling choices not known; inputs not known; large" in less.uncertainty_text
    assert less.shared_error_sentence == ""
    assert record_as_json(less)["modelling_dominated_by"] is None


def test_choices_speak_for_scenes_of_their_parts_or_else_the_largest(tmp_path) -> None:
    scene = STUDY.built_in_scene("lin-case2")
    mine = replace(scene, name="mine")
    assert models_uncertainty.applicable_choice_effects(scene, KNOWN) == KNOWN["lin-case1"]
    assert models_uncertainty.applicable_choice_effects(mine, KNOWN) == KNOWN["lin-case3"]
    assert models_uncertainty.applicable_choice_effects(mine, {}) is None
    soft = replace(scene, nut=replace(scene.nut, material=Material(3e9, 0.4)))  # under the name of a varied one, too
    assert models_uncertainty.applicable_choice_effects(soft, KNOWN) is None
    models_uncertainty.save_choice_effects(tmp_path, KNOWN)
    assert models_uncertainty.read_choice_effects(tmp_path) == KNOWN


def test_the_total_of_a_preloaded_scene() -> None:
    scene, found = STUDY.built_in_scene("lin-case3"), STUDY.stored_reference("lin-case3")
    whole = models_uncertainty.uncertainty_of_loads(scene, found)
    assert (whole.discretisation, whole.shared, whole.by_experience) == (largest_uncertainty_percent(found), True, False)
    assert (whole.choices.scene, whole.choices.choice) == ("lin-case3", "width of the nut's held face")
    parts = models_uncertainty.effects_of_input_tolerances(STUDY, scene, models_uncertainty.QUANTITIES[0])
    assert whole.inputs == pytest.approx(
        float(models_uncertainty.combined_input_effect(STUDY, scene, models_uncertainty.QUANTITIES[0])[0].max())
    )
    assert whole.input == max(parts, key=lambda k: np.abs(parts[k]).max())
    assert 0.0 < whole.percent < 15.0


def test_large_displacements_take_more_of_a_heavier_contact() -> None:
    """By the larger semi-axis, so that a load that is eight times as large loses sixteen times as much, its mean eight."""
    scene, found = STUDY.built_in_scene("lin-case1"), STUDY.stored_reference("lin-case1")
    worst = results_of_contact_loads(scene, found.load, np.radians(found.best.angle)).worst_contact
    mean = found.load[found.load > 0.0].mean()
    assert models_uncertainty.effect_of_large_displacements(scene, found) == pytest.approx(
        3.0 * worst.a / scene.balls.radius * found.load.max() / mean
    )
    eight = replace(found, load=8.0 * found.load)
    assert models_uncertainty.effect_of_large_displacements(scene, eight) == pytest.approx(
        2.0 * models_uncertainty.effect_of_large_displacements(scene, found), rel=1e-6
    )
    assert models_uncertainty.effect_of_large_displacements(scene, replace(found, load=0.0 * found.load)) == 0.0


def test_a_scene_that_the_cheap_model_does_not_suit_has_no_known_inputs(monkeypatch) -> None:
    scene, found = STUDY.built_in_scene("lin-case1"), STUDY.stored_reference("lin-case1")
    monkeypatch.setattr(uncertainty, "MODELS", {"lin": type("none", (), {"covers_scene": staticmethod(lambda _: False)})})
    assert models_uncertainty.uncertainty_of_loads(scene, found).inputs is None
