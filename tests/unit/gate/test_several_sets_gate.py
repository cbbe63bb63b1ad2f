"""Several sets on one shaft against their stored 3D reference: a verdict, answers and a table of each set."""

import numpy as np
import pytest

from rollbench.compare.models import comparison as references
from rollbench.compare.reference.store import load_stored_run, shipped_store
from rollbench.compare.reference.tasks import ball_slices_by_set
from rollbench.compare.scenes import catalogue

pytestmark = pytest.mark.xdist_group("several sets against 3D")
NUTS = ["nut 1", "nut 2"]


def test_a_double_nut_is_judged_by_its_own_3d(command):
    """32.1 % at ball 68, 0.89 ball radii from its nut's free face: its load is uncertain by 1.2 %."""
    found = command.answer("check", "double-nut", "--no-compute", "--model", "lin", "--max-error", "34")
    assert [(v["scene"], v["set"], v["word"]) for v in found["verdicts"]] == [("double-nut", name, "pass") for name in NUTS]
    assert all(v["contacts"] == 136 and 1.0 < v["max_percent_of_mean"] < 30.0 for v in found["verdicts"])


def test_comparison_of_a_double_nut_names_its_sets(command, tmp_path):
    found = command.answer("compare", "double-nut", "--model", "lin", "--store", tmp_path)
    assert [(x["scene"], x["set"]) for x in found["scenes"]] == [("double-nut", name) for name in NUTS]
    assert {(row["scene"], row["set"]) for row in found["rows"]} == {("double-nut", name) for name in NUTS}
    assert all(x["expected_error_percent"] is None or x["expected_error_percent"] > 0.0 for x in found["scenes"])


def test_references_of_sets_are_parts_of_one_run():
    scene = catalogue.scene_of_any_kind("double-nut")
    run = load_stored_run(scene, 1, stores=(shipped_store(),))
    sets = references.stored_references(scene, (shipped_store(),), (1,))
    assert max(run.balance, run.screw_balance) < 1e-9
    assert [one.place_on_shaft.name for one in sets] == NUTS
    for one, place in zip(sets, ball_slices_by_set(scene), strict=True):
        np.testing.assert_array_equal(one.reference.load, run.load[place])
    along = np.where(run.load > 0.0, run.load * np.sin(np.radians(run.angle)), 0.0).sum(axis=0)
    lead = np.cos(np.arctan(0.01 / (2 * np.pi * 0.0166)))
    assert (along[0] - along[1]) * lead == pytest.approx(2000.0, rel=1e-3)
