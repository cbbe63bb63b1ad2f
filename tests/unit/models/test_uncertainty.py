"""What a comparison is uncertain by: parts add by the root of squares, whose choices speak for a scene; validation
uncertainty, bias and scatter of known ratios, applicability."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare import files
from rollbench.compare.models import applicability, uncertainty
from rollbench.compare.models.answers import results_of_contact_loads
from rollbench.compare.models.comparison import solution_from_run
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.model_form import estimate_model_error
from rollbench.compare.models.registry import run_model
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.estimate import largest_uncertainty_percent
from rollbench.compare.sections.fit import validated_range_table
from rollbench.compare.sections.u_val import bias_and_scatter
from rollbench.meshes.parts import Material

pytestmark = pytest.mark.xdist_group("u_val")

STUDY = SceneResultCache()
KNOWN = {"lin-case1": (1.5, "lands"), "lin-case3": (2.5, "held face")}


def test_choices_speak_for_scenes_of_their_parts_or_else_the_largest() -> None:
    scene = STUDY.built_in_scene("lin-case2")
    mine = replace(scene, name="mine")
    assert uncertainty.scene_with_applicable_choices(scene, KNOWN) == "lin-case1"
    assert uncertainty.scene_with_applicable_choices(mine, KNOWN) == "lin-case3"
    assert uncertainty.scene_with_applicable_choices(mine, {}) == ""
    soft = replace(scene, nut=replace(scene.nut, material=Material(3e9, 0.4)))  # under the name of a varied one, too
    assert uncertainty.scene_with_applicable_choices(soft, KNOWN) == ""


def test_the_total_of_a_preloaded_scene(monkeypatch) -> None:
    scene, found = STUDY.built_in_scene("lin-case3"), STUDY.stored_reference("lin-case3")
    quantity = uncertainty.QUANTITIES[0]
    whole = uncertainty.uncertainty_of_loads(scene, found)
    assert (whole.discretisation, whole.shared, whole.by_experience) == (largest_uncertainty_percent(found), True, False)
    assert (whole.choices_varied_on, whole.largest_choice) == ("lin-case3", "width of the nut's held face")
    parts = uncertainty.effects_of_input_tolerances(STUDY, scene, quantity)
    assert whole.largest_input == max(parts, key=lambda k: np.abs(parts[k]).max())
    assert whole.inputs == pytest.approx(float(uncertainty.combined_input_effect(STUDY, scene, quantity)[0].max()))
    monkeypatch.setattr(uncertainty, "MODELS", {"lin": type("none", (), {"covers_scene": staticmethod(lambda _: False)})})
    assert uncertainty.uncertainty_of_loads(scene, found).inputs is None, "the model that varies them does not cover it"


def test_large_displacements_take_more_of_a_heavier_contact() -> None:
    """By the larger semi-axis, so that a load that is eight times as large loses sixteen times as much, its mean eight."""
    scene, found = STUDY.built_in_scene("lin-case1"), STUDY.stored_reference("lin-case1")
    effect = uncertainty.effect_of_large_displacements
    worst = results_of_contact_loads(scene, found.load, np.radians(found.best.angle)).worst
    mean = found.load[found.load > 0.0].mean()
    once, eight, none = (effect(scene, replace(found, load=factor * found.load)) for factor in (1.0, 8.0, 0.0))
    assert once == pytest.approx(3.0 * worst.a / scene.balls.radius * found.load.max() / mean)
    assert (eight, none) == (pytest.approx(2.0 * once, rel=1e-6), 0.0)


SCENE = "lin-case1"


def test_an_unknown_part_leaves_u_val_unknown_and_counts_nothing_where_that_is_said() -> None:
    parts = (np.array([3.0, np.nan]), 4.0)
    assert uncertainty.root_sum_of_squares(parts) == pytest.approx([5.0, np.nan], nan_ok=True)
    assert uncertainty.Uncertainty(discretisation=3.0, inputs=4.0).total == pytest.approx(5.0)


@pytest.mark.slow
@pytest.mark.parametrize("quantity", uncertainty.QUANTITIES, ids=lambda q: q.name)
def test_every_part_is_there(quantity) -> None:
    parts, _ = uncertainty.validation_uncertainty(STUDY, SCENE, quantity)
    for values in parts:
        assert np.isfinite(values).all()
        assert values.max() > 0.0
        assert (uncertainty.root_sum_of_squares(parts) >= values).all()
    if quantity is uncertainty.QUANTITIES[0]:
        ref = STUDY.stored_reference(SCENE)
        assert parts[0] == pytest.approx(100.0 * ref.uncertainty / ref.load[ref.load > 0.0].mean())


@pytest.mark.slow
def test_the_reference_itself_has_no_error_and_a_known_shift_is_found() -> None:
    answer = solution_from_run(STUDY.stored_reference(SCENE).best, "3D")
    larger = replace(answer, load=1.02 * answer.load, line=1.05 * answer.line)
    same, found = (
        {q.name: uncertainty.error_with_validation_uncertainty(STUDY, SCENE, "3D", q, a) for q in uncertainty.QUANTITIES}
        for a in (answer, larger)
    )
    assert [(one.error, one.within) for one in same.values()] == [(0.0, 1.0)] * len(same)
    assert found["largest load"].error == pytest.approx(2.0)
    assert found["displacement of the load's point"].error == pytest.approx(5.0)
    assert found[uncertainty.CONTACTS].ratio == pytest.approx([1.02] * 64)


def test_the_largest_load_is_as_uncertain_as_its_contact() -> None:
    ref, scene = STUDY.stored_reference("lin-case3"), STUDY.built_in_scene("lin-case3")
    largest = next(q for q in uncertainty.QUANTITIES if q.name == "largest load")
    bar = ref.uncertainty.ravel()[ref.load.argmax()]
    assert uncertainty.grid_uncertainty(scene, ref, largest) == pytest.approx(100.0 * bar / ref.load.max())


SPREAD = tuple(np.exp([-0.03, 0.0, 0.03]))


@pytest.mark.parametrize(
    ("ratio", "grid", "within", "bias", "scatter"),
    [
        ((1.1, 1.1, 1.1), 0.0, 1.0, 10.0, 0.0),
        (SPREAD, 0.0, 0.5, 0.0, 3.0),
        (SPREAD, 2.0, 0.5, 0.0, np.sqrt(3.0**2 - 1.0**2)),
        (SPREAD, 20.0, 0.5, 0.0, 0.0),
    ],
)
def test_bias_and_scatter_of_known_ratios(ratio, grid: float, within: float, bias: float, scatter: float) -> None:
    u_val = uncertainty.Uncertainty(discretisation=grid)
    row = uncertainty.ErrorWithUncertainty("s", "m", "q", 0.0, u_val, within, within, ratio)
    (found,) = bias_and_scatter([row])
    assert (found["bias"], found["scatter"]) == pytest.approx((bias, scatter), abs=1e-9)


def test_compared_scenes_are_inside_and_kept_places_are_theirs() -> None:
    for ring in (False, True):
        scenes = applicability.compared_scenes(of_bearings=ring)
        assert [applicability.descriptors_outside_range(scene) for scene in scenes] == [()] * len(scenes)
        for scene, kept in zip(scenes, applicability.descriptors_of_built_in_scenes(of_bearings=ring), strict=True):
            assert kept == pytest.approx({d.name: d.value_of_scene(scene) for d in applicability.DESCRIPTORS}, rel=1e-12)


@pytest.mark.parametrize(
    ("change", "name"),
    [
        (lambda s: replace(s, nut=replace(s.nut, groove_radius=1.01 * s.nut.groove_radius)), ""),
        (lambda s: replace(s, screw=replace(s.screw, groove_radius=1.3 * s.screw.groove_radius),
                           nut=replace(s.nut, groove_radius=1.3 * s.nut.groove_radius)), "conformity"),
        (lambda s: replace(s, errors=replace(s.errors, balls=replace(s.errors.balls, oversize=30e-6))), "oversize"),
        (lambda s: replace(s, supports=(replace(s.supports[0], fixed=(("ux", 2e-3),)), *s.supports[1:])), "misalignment"),
    ],
)  # fmt: skip
def test_solve_says_not_covered_where_a_scene_is_outside(change, name: str) -> None:
    """The place that is drawn and the words of a result agree."""
    base = STUDY.built_in_scene(SCENE)
    result = run_model(base, "lin", ModelOptions(estimate_beam_mesh_error=False))
    changed = change(base)
    beyond = applicability.descriptors_outside_range(changed)
    form = estimate_model_error(changed, result)
    if name:
        assert any(text.startswith(name) for text in beyond)
        assert form.loads is None
        assert any("outside the range of the compared scenes" in w or "unlike every compared" in w for w in form.words)
        cells = [r for r in validated_range_table(changed).rows if r["place_in_range"] == "OUTSIDE"]
        assert len(cells) == len(beyond)
    else:
        assert beyond == ()
        assert form.loads is not None


@pytest.mark.parametrize("left", [None, "{", "[]", '{"screws": {"a": {}}, "rings": {"a": {}}}'])
@pytest.mark.parametrize("name", [SCENE, "unseen-four-point"])
def test_nothing_is_covered_where_an_installation_lacks_what_was_compared(monkeypatch, left: str | None, name: str):
    text_of, scene = files.shipped_text, STUDY.built_in_scene(name)

    def text(path: str) -> str:
        if path.endswith("places.json") and left is None:
            raise FileNotFoundError(path)
        return left if path.endswith("places.json") else text_of(path)

    assert applicability.descriptors_outside_range(scene) == ()
    result = run_model(scene, "lin", ModelOptions(estimate_beam_mesh_error=False))
    monkeypatch.setattr(files, "shipped_text", text)
    applicability.descriptors_of_built_in_scenes.cache_clear()
    try:
        assert estimate_model_error(scene, result).loads is None
        assert "places.json is missing or damaged" in " ".join(applicability.descriptors_outside_range(scene))
    finally:
        applicability.descriptors_of_built_in_scenes.cache_clear()


def test_balls_at_the_face_of_the_nut_are_covered_as_far_as_drawn_screws_have_them() -> None:
    """Liu's screw has its last balls 1.5 radii from the face, drawn ones from 1; closer ones were never compared."""
    scene = STUDY.built_in_scene("liu-screw")
    assert not applicability.descriptors_outside_range(scene)
    shorter = replace(scene, nut=replace(scene.nut, length=scene.nut.length - 2.4 * scene.balls.radius))
    beyond = [place.descriptor.name for place in applicability.descriptors_with_ranges(shorter) if place.outside]
    assert beyond == ["nut beyond the last balls over the ball's radius"]
