"""Expected errors of nuts held by a flange: from all screws with those of flanges; of other nuts as without them."""

from dataclasses import replace

import pytest

from rollbench.compare.models import model_form
from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.scenes import catalogue
from rollbench.meshes.parts import Flange

SCENE = catalogue.scene("lin-case1")
ON_FLANGE = replace(SCENE, nut=replace(SCENE.nut, flange=Flange(72e-3, 11e-3, (24e-3, 36e-3))))
RESULT = run_model(SCENE, "lin", ModelOptions(estimate_beam_mesh_error=False, engine="interpreted"))
PLAIN = [
    p for p in model_form.model_errors_on_compared_scenes() if model_form.FLANGE not in p.features and p.model == "lin"
]


def flanged(count: int, factor: float):
    """Compared scenes made up: those of the package, off by a factor more, on flanges."""
    screws = [p for p in PLAIN if p.features["lead"] > 0.0][:count]
    held = {model_form.FLANGE: 1.0}
    return [replace(p, scene=f"{p.scene}, flange", percent=factor * p.percent, features=p.features | held) for p in screws]


def test_a_nut_on_a_flange_is_not_covered_by_nuts_without() -> None:
    assert model_form.FLANGE in model_form.features_of_scene(ON_FLANGE, RESULT)
    assert model_form.FLANGE not in model_form.features_of_scene(SCENE, RESULT)
    found = model_form.estimate_model_error(ON_FLANGE, RESULT, [*PLAIN, *flanged(2, 1.0)])
    assert (found.percent, "too few nuts held by a flange" in found.words[-1]) == (None, True)


def test_flanges_with_larger_errors_are_expected_to_have_them_and_change_no_other() -> None:
    many = [*PLAIN, *flanged(40, 5.0)]
    plain, other = (
        model_form.estimate_model_error(SCENE, RESULT, PLAIN),
        model_form.estimate_model_error(SCENE, RESULT, many),
    )
    assert other == plain
    on_flange = model_form.estimate_model_error(ON_FLANGE, RESULT, many).percent
    assert on_flange > 2.0 * plain.percent
    judged = {x.point.scene: x for x in model_form.leave_one_out_errors(many, "lin")}
    alone = {x.point.scene: x for x in model_form.leave_one_out_errors(PLAIN, "lin")}
    assert {k: v for k, v in judged.items() if model_form.FLANGE not in v.point.features} == alone
    assert len(judged) == len(alone) + 40


def test_a_flange_that_does_not_hold_its_nut_is_of_no_compared_kind() -> None:
    face = replace(ON_FLANGE, solid=replace(SCENE.solid, nut_held="left face"))
    found = model_form.estimate_model_error(face, RESULT, PLAIN)
    assert (found.percent, "is not fixed at it" in found.words[-1]) == (None, True)
    plain = model_form.estimate_model_error(replace(SCENE, solid=face.solid), RESULT, PLAIN)
    assert plain.percent == pytest.approx(model_form.estimate_model_error(SCENE, RESULT, PLAIN).percent)
