"""What compare prints and writes: verdict, one table that fits, no row of the reference against itself."""

import csv
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rollbench.compare.commands import compare as output
from rollbench.compare.errors import InputError
from rollbench.compare.models.comparison import ContactSolution, SceneWithReference, comparison_options
from rollbench.compare.models.model_form import estimate_model_error, model_errors_on_compared_scenes
from rollbench.compare.models.registry import MODELS, run_model
from rollbench.compare.models.uncertainty import Uncertainty
from rollbench.compare.reference import store
from rollbench.compare.reference.estimate import MeshUncertainty, Reference, reference_of_scene
from rollbench.compare.results import comparing
from rollbench.compare.results.comparison import Comparison
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.rating.rigidity import axial_force

TOTAL = Uncertainty(discretisation=0.2, by_experience=True, choices=3.0, inputs=2.0, second_order=0.1)


@pytest.fixture
def case():
    """A scene, a model that is 1 % off on it, and its reference."""
    scene = catalogue.scene("lin-case1")
    exact, line = np.zeros((scene.ball_count, 4)), np.array([[0.0, 0.0, 1e-5]] * 2)
    exact[:, [0, 3]] = 200.0 + np.arange(scene.ball_count)[:, None]
    angle, stations = np.where(exact > 0.0, 45.0, np.nan), np.array([0.0, scene.screw.length])
    answer = ContactSolution("refined", 1.01 * exact, angle, stations, 1.01 * line, 1.0)
    runs = (SimpleNamespace(level=1, moving=0.0),)
    return scene, answer, Reference(scene.name, runs, exact, np.where(exact > 0.0, 0.5, 0.0), MeshUncertainty(0.2))


def test_a_contact_of_nearly_nothing_does_not_head_the_comparison(case) -> None:
    """Of 0.01 N in the reference and 0.1 N in the model: 900 % of its own load, 0.04 % of the mean."""
    scene, answer, found = case
    small = found.load.copy()
    small[0, 0], answer.load[0, 0] = 0.01, 0.1
    one = comparing.compare_loads_with_reference(scene, answer, replace(found, load=small))
    of = SceneWithReference(scene, found)
    text = Comparison(scene=scene.name, of=of, reference=one, models={"refined": one}, uncertainty=TOTAL).verdict
    assert one.error.own_max_percent > 800.0
    assert ", 1.00 % as judged by rollbench check" in text


def test_every_contact_is_written_beside_its_reference(case, tmp_path) -> None:
    scene, answer, found = case
    models = {"refined": comparing.compare_loads_with_reference(scene, answer, found)}
    exact = comparing.compare_loads_with_reference(scene, replace(answer, model="3D reference", load=found.load), None)
    whole = Comparison(scene=scene.name, of=SceneWithReference(scene, found), reference=exact, models=models)
    said = output.write_contact_loads(whole, tmp_path / "lin-case1-compare")
    rows = list(csv.DictReader((tmp_path / "lin-case1-compare.csv").read_text().splitlines()))
    assert len(rows) == 2 * scene.ball_count
    assert float(rows[0]["refined_N"]) == pytest.approx(1.01 * float(rows[0]["reference_N"]))
    assert rows[0]["uncertainty_N"] == "0.5"
    assert (tmp_path / "lin-case1-compare.svg").stat().st_size > 1000
    assert "lin-case1-compare.csv" in said


def test_compare_measures_what_solve_expects_by_every_kind_of_model(tmp_path) -> None:
    scene, stores = catalogue.scene("unseen-short-nut"), (tmp_path, store.shipped_store())
    found = reference_of_scene(scene, stores)
    models = [MODELS["refined"], MODELS["condensed"]]
    whole = comparing.compare_models_with_reference(SceneWithReference(scene, found), models, stores)
    refined, condensed = whole.models["refined"], whole.models["condensed"]
    result = run_model(scene, "refined")
    assert refined.axial_force == pytest.approx(axial_force(result), rel=1e-6)
    wanted = estimate_model_error(scene, result, [p for p in model_errors_on_compared_scenes() if p.scene != scene.name])
    assert (whole.expected_error.loads, whole.expected_error.distance) == pytest.approx(
        (wanted.loads, wanted.distance), rel=1e-9
    )
    assert whole.expected_error.distance > estimate_model_error(scene, result).distance, "not expected of itself"
    assert whole.uncertainty.choices_varied_on == "lin-case3", "not varied on these parts"
    assert condensed.error.max_percent < 0.5 * refined.error.max_percent
    assert whole.reference.displacement == pytest.approx(condensed.displacement, rel=0.01)


def test_bodies_that_no_store_has_are_asked_for(tmp_path) -> None:
    scene = catalogue.scene("unseen-four-point")
    with pytest.raises(InputError, match=r"model: got .condensed.*level 4"):
        comparison_options(MODELS["condensed"], scene, reference_of_scene(scene), (tmp_path,))
