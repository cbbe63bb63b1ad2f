"""Validation uncertainty and applicability: parts add by the root of squares, bias and scatter of known ratios."""

from dataclasses import replace

import numpy as np
import pytest

from rollbench.compare import files
from rollbench.compare.models import applicability, uncertainty
from rollbench.compare.models.comparison import solution_from_run
from rollbench.compare.models.model_form import estimate_model_error
from rollbench.compare.models.registry import ModelOptions, run_model
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.sections.fit import validated_range_table

pytestmark = pytest.mark.xdist_group("u_val")

STUDY = SceneResultCache()
SCENE = "lin-case1"


def test_an_unknown_part_leaves_u_val_unknown_and_counts_nothing_where_that_is_said() -> None:
    parts = uncertainty.UncertaintyParts({"a": np.array([3.0, np.nan]), "b": 4.0})
    assert parts.root_sum_of_squares() == pytest.approx([5.0, np.nan], nan_ok=True)
    assert parts.root_sum_of_squares(unknown=0.0) == pytest.approx([5.0, 4.0])


@pytest.mark.parametrize("quantity", uncertainty.QUANTITIES, ids=lambda q: q.name)
def test_every_part_is_there(quantity) -> None:
    found = uncertainty.validation_uncertainty(STUDY, SCENE, quantity)
    assert len(found.parts) == 3
    for values in found.parts.values():
        assert np.isfinite(values).all()
        assert values.max() > 0.0
        assert (found.root_sum_of_squares() >= values).all()


def test_the_grid_s_part_of_loads_is_that_of_the_reference() -> None:
    ref = STUDY.stored_reference(SCENE)
    found = uncertainty.validation_uncertainty(STUDY, SCENE, uncertainty.QUANTITIES[0])
    assert found.parts[uncertainty.GRID] == pytest.approx(100.0 * ref.uncertainty / ref.load[ref.load > 0.0].mean())


def test_the_reference_itself_has_no_error_and_a_known_shift_is_found() -> None:
    ref = STUDY.stored_reference(SCENE)
    answer = solution_from_run(ref.best, "3D")
    for quantity in uncertainty.QUANTITIES:
        same = uncertainty.error_with_validation_uncertainty(STUDY, SCENE, "3D", quantity, answer)
        assert (same.error, same.within) == (0.0, 1.0)
    larger = replace(answer, load=1.02 * answer.load, line=1.05 * answer.line)
    found = {
        q.name: uncertainty.error_with_validation_uncertainty(STUDY, SCENE, "3D", q, larger) for q in uncertainty.QUANTITIES
    }
    assert found["largest load"].error == pytest.approx(2.0)
    assert found["axial displacement"].error == pytest.approx(5.0)
    assert found[uncertainty.CONTACTS].ratio == pytest.approx([1.02] * 64)


def test_the_largest_load_is_as_uncertain_as_its_contact() -> None:
    ref, scene = STUDY.stored_reference("lin-case3"), STUDY.built_in_scene("lin-case3")
    largest = next(q for q in uncertainty.QUANTITIES if q.name == "largest load")
    bar = ref.uncertainty.ravel()[ref.load.argmax()]
    assert uncertainty.grid_uncertainty(scene, ref, largest) == pytest.approx(100.0 * bar / ref.load.max())


def row(ratio: tuple[float, ...], grid: float, within: float) -> uncertainty.ErrorWithUncertainty:
    return uncertainty.ErrorWithUncertainty("s", "m", "q", 0.0, grid, 0.0, 0.0, grid, within, within, ratio, "")


def test_bias_and_scatter_of_known_ratios() -> None:
    (exact,) = uncertainty.bias_and_scatter([row((1.1, 1.1, 1.1), 0.0, 1.0)])
    assert (exact.bias, exact.scatter) == (pytest.approx(10.0), pytest.approx(0.0, abs=1e-9))
    spread = tuple(np.exp([-0.03, 0.0, 0.03]))
    (noisy,) = uncertainty.bias_and_scatter([row(spread, 0.0, 0.5)])
    assert (noisy.bias, noisy.scatter) == (pytest.approx(0.0, abs=1e-9), pytest.approx(3.0))
    (less,) = uncertainty.bias_and_scatter([row(spread, 2.0, 0.5)])
    assert less.scatter == pytest.approx(np.sqrt(3.0**2 - 1.0**2))
    (none,) = uncertainty.bias_and_scatter([row(spread, 20.0, 0.5)])
    assert none.scatter == 0.0


def test_compared_scenes_are_inside() -> None:
    for ring in (False, True):
        assert all(
            applicability.descriptors_outside_range(scene) == ()
            for scene in applicability.compared_scenes(of_bearings=ring)
        )
    assert (
        len(applicability.compared_scenes(of_bearings=False)) + len(applicability.compared_scenes(of_bearings=True)) == 15
    )


def test_kept_places_are_those_of_the_scenes() -> None:
    for ring in (False, True):
        found = [
            {d.name: pytest.approx(d.value_of_scene(scene), rel=1e-12) for d in applicability.DESCRIPTORS}
            for scene in applicability.compared_scenes(of_bearings=ring)
        ]
        assert list(applicability.descriptors_of_built_in_scenes(of_bearings=ring)) == found


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
        assert form.percent is None
        assert any("outside the range of the compared scenes" in w or "unlike every compared" in w for w in form.words)
        cells = [r for r in validated_range_table(changed).rows if r["where"] == "OUTSIDE"]
        assert len(cells) == len(beyond)
    else:
        assert beyond == ()
        assert form.percent is not None


@pytest.mark.parametrize("left", [None, "{", "[]", '{"screws": {"a": {}}, "rings": {"a": {}}}'])
@pytest.mark.parametrize("name", [SCENE, "unseen-four-point"])
def test_nothing_is_covered_where_an_installation_lacks_what_was_compared(monkeypatch, left: str | None, name: str):
    def text(path: str) -> str:
        if not path.endswith("places.json"):
            return text_of(path)
        if left is None:
            raise FileNotFoundError(path)
        return left

    text_of, scene = files.shipped_text, STUDY.built_in_scene(name)
    assert applicability.descriptors_outside_range(scene) == ()
    result = run_model(scene, "lin", ModelOptions(estimate_beam_mesh_error=False))
    monkeypatch.setattr(files, "shipped_text", text)
    applicability.descriptors_of_built_in_scenes.cache_clear()
    try:
        assert estimate_model_error(scene, result).percent is None
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
