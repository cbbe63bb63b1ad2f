"""What a level leaves out of a contact's compliance beside a free face, and what its load is wrong by."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.near_face import CASES, measured, scene_of

from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.models.uncertainty import largest_uncertainty_near_face
from rollbench.compare.reference import estimate
from rollbench.compare.reference.estimate import load_error_near_faces, load_overestimate_near_faces
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.scenes import catalogue
from rollbench.hifi.meshing.settings import hertz_contacts_under_unit_force
from rollbench.meshes.helix import ball_layout

pytestmark = pytest.mark.every_run  # only the screws that the survey drew are of a study
ROWS = json.loads((shipped_store() / estimate.LIP_FILE).read_text(encoding="utf-8"))
KNOWN = estimate.read_lip_compliance(shipped_store())


def test_the_record_is_of_its_cases_and_can_be_repeated() -> None:
    asked = [(scene_of(number).name, distance) for number, distances, _ in CASES for distance in distances]
    assert [(row["scene"], row["radii"]) for row in ROWS] == asked
    row = next(row for row in ROWS if row["radii"] == 1.35)
    assert measured(None, 1.35, 1) == pytest.approx(row["lip"] - row["missing"]["1"], abs=2e-4)


def test_finer_bodies_and_larger_distances_leave_less_out() -> None:
    """Levels 1, 3 and 4 at every distance but for the scatter of meshes; in every scene less than a fifth of the lip."""
    missing, distances, scatter = KNOWN.missing_compliance_by_level, KNOWN.relative_distances, 0.02
    for level, of_level in missing.items():
        assert (np.diff(of_level) < scatter).all()
        assert (of_level <= missing[1] + 1e-12).all(), level
    assert (missing[4] < 0.6 * missing[1])[:-1].all()
    assert KNOWN.interpolate(np.array([estimate.AWAY, 5.0]), 1)[1] == pytest.approx([0.0, 0.0])
    assert KNOWN.interpolate(np.array([1.1]), 5)[1] == pytest.approx(missing[4][2])
    slope = np.diff(missing[1]) / np.diff(distances)
    assert slope[0] == pytest.approx(slope[1])
    for row in ROWS:  # of other leads and balls too
        assert 0.0 < row["missing"]["1"] < 0.2 * row["lip"]
        assert np.interp(row["radii"], distances, missing[1]) >= row["missing"]["1"] - 1e-12


def test_a_face_three_ball_radii_away_is_not_near() -> None:
    assert KNOWN.relative_distances[-2] < 2.99
    for value in KNOWN.interpolate(np.array([2.99, 3.0, 3.01]), 1):
        assert value[0] > 0.0
        assert value[1:].tolist() == [0.0, 0.0]


def near(distance: float = 1.2, **solid):
    """Case 1 in a nut that ends so many ball radii beyond its last balls."""
    scene = catalogue.scene("lin-case1")
    z = ball_layout(scene).z - scene.nut.position
    length = 2.0 * (float(z.max()) + distance * scene.balls.radius)
    return replace(scene, nut=replace(scene.nut, length=length), solid=replace(scene.solid, **solid))


def test_it_concerns_the_flank_that_is_pressed_towards_a_free_face() -> None:
    load, scene = np.full((32, 4), 200.0), near()
    last, first = int(ball_layout(scene).z.argmax()), int(ball_layout(scene).z.argmin())
    found = load_overestimate_near_faces(scene, load, 1)
    assert found[last, [0, 3]] == pytest.approx(found.max())
    assert found[last, [1, 2]] == pytest.approx([0.0, 0.0])
    assert not found[first].any()  # held there
    turned = load_overestimate_near_faces(near(nut_held="right face"), load, 1)
    assert turned[first, [1, 2]] == pytest.approx(found[last, [0, 3]], rel=1e-9)
    assert not turned[last].any()
    assert load_overestimate_near_faces(near(nut_held="outer surface"), load, 1) == pytest.approx(np.maximum(found, turned))
    for other in (near(nut_held="both faces"), near(nut="rigid"), catalogue.scene("two-balls")):
        assert not load_overestimate_near_faces(other, np.full((other.ball_count, 4), 200.0), 1).any()
    assert not load_overestimate_near_faces(scene, 0.0 * load, 1).any()
    assert load_overestimate_near_faces(scene, load, 3).max() < 0.6 * found.max()


def test_what_contacts_beside_a_face_have_too_much_the_others_have_too_little_where_the_sum_is_held() -> None:
    scene, load = near(), np.zeros((32, 4))
    load[:16, [0, 3]], load[16:, [0, 3]] = 20.0, 160.0
    excess, found = load_overestimate_near_faces(scene, load, 1), load_error_near_faces(scene, load, 1)
    shared = found - excess
    assert excess[:, 0].any()
    assert shared.sum(axis=0) == pytest.approx(excess.sum(axis=0))
    assert not shared[:, 1:3].any()
    assert shared[20, 0] == pytest.approx(2.0 * shared[3, 0])  # by their own stiffness: the cube root of the load
    load[:, 1:3] = 1.0
    assert load_error_near_faces(scene, load, 1) == pytest.approx(load_overestimate_near_faces(scene, load, 1))


def test_the_load_that_a_missing_compliance_adds() -> None:
    """Two Hertz contacts and a lip in a row at a given approach, the lip with and without what the level leaves out."""
    scene, force = near(1.1), 300.0
    unit = 1.0 / (scene.nut.material.youngs_modulus * scene.balls.radius)
    lip, missing = (unit * float(x[0]) for x in KNOWN.interpolate(np.array([1.1]), 1))
    soft = sum(hertz_contacts_under_unit_force(scene)[s].approach for s in (0, 3))
    given = soft * force ** (2.0 / 3.0) + (lip - missing) * force
    true = brentq(lambda f: soft * f ** (2.0 / 3.0) + lip * f - given, 0.5 * force, force)
    found = load_overestimate_near_faces(scene, np.full((32, 4), force), 1).max()
    assert found == pytest.approx(force - true, rel=0.05)
    assert 0.01 * force < found < 0.05 * force


def test_the_contact_beside_a_face_is_named() -> None:
    study = SceneResultCache()
    scene, found = study.built_in_scene("liu-screw"), study.stored_reference("liu-screw")
    largest, place = largest_uncertainty_near_face(found)
    last = int(ball_layout(scene).z.argmax())
    assert place == f"ball {last + 1} SL"
    assert found.uncertainty[last, 0] > found.beside_face[last, 0] > 0.0
    assert largest > 0.0
    assert largest_uncertainty_near_face(study.stored_reference("unseen-25x5")) == (0.0, "")
