"""The refined model on the command line, condensed bodies as a file, the ladder and what a result may be worth."""

import json
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np
import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.models import model_form, modelling
from rollbench.compare.models.registry import DEFAULT, ModelOptions, run_model
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.reference.estimate import reference_of_scene
from rollbench.compare.reference.store import load_stored_run, path_of_bodies, shipped_store
from rollbench.compare.scenes import catalogue
from rollbench.meshes.parts import Scene

QUIET = ModelOptions(estimate_beam_mesh_error=False, engine="compiled")


@pytest.fixture(autouse=True)
def kept_bodies(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a climb times from nothing is kept here from one rung to the next, and compiled kernels serve."""
    monkeypatch.setattr(modelling, "clear_compliance_caches", lambda: None)
    monkeypatch.setattr(
        modelling, "ModelOptions", lambda **_: ModelOptions(estimate_beam_mesh_error=False, engine="compiled")
    )


def bodies(name: str = "lin-case1", level: int = 3) -> Path:
    run = load_stored_run(catalogue.scene(name), level)
    assert run is not None
    return path_of_bodies(shipped_store(), catalogue.scene(name), run)


def test_the_default_is_refined_and_says_what_it_is_worth(command) -> None:
    code, data = command.json("solve", "lin-case1", "--json")
    assert (code, data["model"]) == (0, DEFAULT)
    worth = data["model_form"]
    assert 0.3 < worth["largest_percent_of_mean"] < 4.0
    assert worth["rms_percent_of_mean"] < worth["largest_percent_of_mean"]
    assert worth["nearest"] in ("lin-case1", "lin-case2")
    for name in ("displacement", "pressure"):
        assert 0.0 < worth[f"{name}_percent"] < 4.0, name
    assert "elastic" in worth["words"][0]
    code, out, _ = command("solve", "lin-case1", "--model", "mei", "--json")
    unknown = json.loads(out)["model_form"]
    assert unknown["largest_percent_of_mean"] is None
    assert "axial bars" in unknown["words"][0]


def test_condensed_bodies_from_a_file(command) -> None:
    code, out, err = command("solve", "lin-case1", "--condensed", str(bodies()), "--json")
    assert (code, err) == (0, "")
    data = json.loads(out)
    assert data["model"] == "condensed"
    assert any("condensed 3D model (mesh level 3" in line for line in data["assumed"])


def test_bodies_of_other_parts_are_refused() -> None:
    with pytest.raises(InputError, match="other parts"):
        run_model(catalogue.scene("unseen-lead10"), "condensed", replace(QUIET, condensed_bodies_file=bodies()))


def test_condensed_bodies_are_close_to_their_own_reference_and_to_the_refined_ones() -> None:
    start = perf_counter()
    rung = rungs_of(catalogue.scene("lin-case1"))
    assert 0.0 < sum(r.seconds for r in rung.values()) < perf_counter() - start
    assert rung["condensed"].load_error.max_percent < 0.5
    assert rung["condensed"].load_error.rms_percent < 0.25
    assert rung["refined"].load_error.max_percent < 1.2
    assert rung["refined"].load_error.rms_percent < 0.45
    assert (
        rung["lin"].load_error.max_percent
        > rung["lin-cell"].load_error.max_percent
        > rung["lin-nut"].load_error.max_percent
    )
    assert rung["lin-nut"].load_error.max_percent > 2.0 * rung["refined"].load_error.max_percent


def rungs_of(scene: Scene) -> dict[str, modelling.RefinementStepResult]:
    found = reference_of_scene(scene)
    assert found is not None
    return {r.model: r for r in modelling.solve_refinement_sequence(scene, found, None)}


@pytest.mark.slow
def test_unseen_screws_hold(monkeypatch: pytest.MonkeyPatch) -> None:
    study, held = SceneResultCache(), ("refined", "condensed", "lin")
    monkeypatch.setattr(modelling, "RUNGS", [model for model in modelling.RUNGS if model.name in held])
    for name in modelling.UNSEEN:
        rungs = rungs_of(study.built_in_scene(name))
        bar = rungs["refined"].reference_uncertainty or 0.0  # none of one level
        # thin nut: 2.57 - 0.11 (its bar was 1.06); its grooved wall is no smooth tube
        assert rungs["refined"].load_error.max_percent - bar < (2.5 if name == "unseen-thin-nut" else 1.4)
        if study.built_in_scene(name).track.lead:  # rings are short: their wall is what little both models lack
            assert rungs["lin"].load_error.max_percent > 3.0 * rungs["refined"].load_error.max_percent
        assert rungs["condensed"].load_error.max_percent <= max(
            0.8, 1.1 * bar
        )  # hollow: 0.75 with preload and offset, +- 0.39


def test_kept_points_are_what_the_ladder_gives_now() -> None:
    study = SceneResultCache()
    kept = {(p.scene, p.model): p for p in model_form.model_errors_on_compared_scenes()}
    assert {m for _, m in kept} == {m.name for m in modelling.RUNGS}
    for name in ("lin-case1", "unseen-flange"):
        for p in modelling.model_errors_on_built_in_scenes(study, list(rungs_of(study.built_in_scene(name)).values())):
            old = kept[p.scene, p.model]
            assert p.percent == pytest.approx(old.percent, abs=2e-3)
            assert p.features == pytest.approx(old.features, abs=2e-3)


def test_what_is_expected_grows_where_errors_do_and_ends_where_nothing_was_compared() -> None:
    scene = catalogue.scene("lin-case1")
    result = run_model(scene, "refined", QUIET)
    near = model_form.estimate_model_error(scene, result)
    short = replace(scene, nut=replace(scene.nut, length=0.045))
    further = model_form.estimate_model_error(short, result)
    assert near.percent is not None
    assert further.percent is not None
    assert further.percent > 1.3 * near.percent, "balls close to the nut's faces"
    thick = replace(scene, nut=replace(scene.nut, outer_diameter=0.150))
    far = model_form.estimate_model_error(thick, result)
    assert (far.percent, far.rms_percent, far.displacement_percent) == (None, None, None)
    assert far.nearest
    assert any("wall of the nut" in w for w in far.words)
    nothing = model_form.estimate_model_error(scene, result, [])
    assert (nothing.percent, nothing.compared) == (None, 0)
    assert nothing.words[-1] == "no scene was compared with the 3D reference"


def test_nine_of_ten_compared_screws_are_within_what_the_others_expect() -> None:
    """The refined model, each screw judged by all others: covered, held, and no promise of fifty per cent."""
    found = model_form.leave_one_out_errors(model_form.model_errors_on_compared_scenes(), DEFAULT)
    covered = [one for one in found if one.expected is not None]
    assert len(covered) >= 0.9 * len(found)
    assert sum(one.point.scene.startswith("survey") for one in found) >= 190
    for quantity in model_form.QUANTITIES:
        pairs = [(getattr(one.point, quantity), one.expected[quantity]) for one in covered]  # type: ignore[index]
        errors, expected = np.abs(np.array([(e, x) for e, x in pairs if e is not None], float)).T
        assert np.mean(errors <= expected) >= 0.9, quantity
        if quantity in model_form.QUANTITIES[:2]:
            assert np.median(expected / errors) <= 2.6, quantity  # 2.59 since what contacts carry counts, not the loads


#: Drawn screws on which the refined model is beyond 1.5 % of the mean load, or 0.5 % RMS, and those that the other ones
#: would have promised less: a tenth at most. What is known of the causes: docs/trust.md.
BEYOND_REACH = {2, 15, 28, 37, 66, 75, 86, 89, 104, 130, 187, 191, 194, 201, 204, 211, 214, 223, 235}
BEYOND_EXPECTED = {2, 28, 48, 50, 55, 66, 88, 89, 96, 130, 139, 147, 165, 187, 194, 201, 211}
SHIPPED_BEYOND_EXPECTED = {"unseen-40x10", "unseen-thin-nut"}


def test_every_compared_screw_beyond_reach_or_expectation_is_known() -> None:
    """One more fails, one less too: the list is then wrong."""
    found = model_form.leave_one_out_errors(model_form.model_errors_on_compared_scenes(), DEFAULT)
    far = {one.point.scene for one in found if one.point.percent > 1.5 or one.point.rms_percent > 0.5}
    beyond = {one.point.scene for one in found if one.expected and one.point.percent > (one.expected["percent"] or np.inf)}
    assert far == {f"survey {number}" for number in BEYOND_REACH}
    assert beyond == {f"survey {number}" for number in BEYOND_EXPECTED} | SHIPPED_BEYOND_EXPECTED


def test_an_expected_error_holds_the_share_that_it_says() -> None:
    """Drawn scenes whose errors follow their features but for a scatter that is not normal: new ones are held as told."""
    rng = np.random.default_rng(7)

    def drawn(count: int) -> tuple[np.ndarray, np.ndarray]:
        x = rng.normal(size=(count, 4))
        return x, np.exp(x @ [0.8, -0.4, 0.0, 0.2] + rng.exponential(0.5, count))

    held = []
    for _ in range(30):
        x, errors = drawn(120)
        new, found = drawn(20)
        held += [
            e <= model_form.upper_bound_of_model_error(x, errors, here, 0.01) for here, e in zip(new, found, strict=True)
        ]
    assert np.mean(held) == pytest.approx(model_form.SHARE, abs=0.03)


def test_a_bearing_with_a_closed_form_gets_no_invented_error() -> None:
    """Two opposite balls in rigid rings: the model is exact (Hertz alone), and nothing like it was compared."""
    from rollbench.compare.gate.gate import two_ball_load_by_solver_and_formula
    from rollbench.compare.models.load_cases import SceneSolution
    from rollbench.compare.results.rows import expected_error_sentence
    from rollbench.compare.results.scene_json import solved_case_json

    found, closed = two_ball_load_by_solver_and_formula(catalogue.scene("lin-case1"))
    assert found == pytest.approx(closed, rel=1e-9)
    scene = catalogue.scene("two-balls")
    for other in (scene, replace(scene, solid=replace(scene.solid, nut="rigid"))):
        result = run_model(other, "lin", QUIET)
        form = model_form.estimate_model_error(other, result)
        worth = solved_case_json(SceneSolution(other, result, None, form))["model_form"]
        assert [worth[f"{name}_percent_of_mean"] for name in ("largest", "rms")] == [None, None]
        assert worth["covered"] is False
        words = expected_error_sentence(form)
        assert "not covered" in words
        assert "%" not in words


def test_an_estimate_is_made_from_scenes_of_the_same_kind() -> None:
    """A ring from rings, of which too few were compared, a screw from screws; a rigid nut, or a rigid screw with a lead,
    was never compared."""
    scene, ring = catalogue.scene("lin-case1"), catalogue.scene("unseen-four-point")
    points = model_form.model_errors_on_compared_scenes()
    rings = {p.scene for p in points if p.features["lead"] == 0.0}
    of_ring = model_form.estimate_model_error(ring, run_model(ring, "lin", QUIET))
    assert of_ring.percent is None
    assert of_ring.compared == len(rings) < model_form.FEWEST
    result = run_model(scene, "lin", QUIET)
    only_rings = model_form.estimate_model_error(scene, result, [p for p in points if p.scene in rings])
    assert only_rings.percent is None
    assert "too few screws were compared" in only_rings.words[-1]
    for other in (
        replace(scene, solid=replace(scene.solid, nut="rigid")),
        replace(scene, ingredients=replace(scene.ingredients, screw="rigid")),
    ):
        assert model_form.estimate_model_error(other, result).percent is None
