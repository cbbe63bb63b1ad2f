"""Rounds of the 3D reference on two balls: those that settle, those that do not, what is told and kept of them."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.shipped_texts import own_text

from rollbench.hifi import reference, setup
from rollbench.meshes.parts import Support

pytestmark = pytest.mark.xdist_group("helped by processes")


def test_a_helical_motion_of_the_screw_changes_no_load(small):
    """A screw that is turned by 2 mrad and free to follow its lead; by linear kinematics its radius would grow by 33 nm."""
    at_rest = reference.solve_reference(small, small.scene)
    first = small.scene.supports[0]
    held = tuple((name, 2e-3 if name == "rz" else value) for name, value in first.fixed)
    turned = replace(small.scene, supports=(replace(first, fixed=held), *small.scene.supports[1:]))
    result = reference.solve_reference(small, turned)
    assert result.status == "converged"
    assert result.normal_update_count <= 5  # by the middle of the pressures, which sticks to so few nodes, it were 12
    np.testing.assert_allclose(result.contact_loads, at_rest.contact_loads, rtol=0, atol=1e-4 * at_rest.contact_loads.max())
    across = np.nan_to_num(result.contact_angles - at_rest.contact_angles)
    assert np.abs(across).max() < 1e-4  # a straight step along a curved track: 16 um leave 8 nm of its section
    axial = result.contact_loads[:, 0] @ np.sin(result.contact_angles[:, 0]) * np.cos(small.groove_map.alpha)
    assert axial == pytest.approx(400.0, rel=2e-4)


def test_loads_that_did_not_settle_say_what_they_may_still_move_by(small):
    """Places of the balls are solved with the loads, so that few rounds settle these."""
    turned = replace(
        small.scene, supports=(Support(0.0, small.scene.supports[0].fixed), Support(60e-3, (("ux", 5e-6), ("uy", 0.0))))
    )
    whole = reference.solve_reference(small, turned)
    assert (whole.status, whole.remaining_load_change) == ("converged", 0.0)
    assert whole.normal_update_count <= 3
    few = reference.solve_reference(small, turned, updates=1)
    assert few.status.startswith("not settled: loads may still move by")
    assert 0.0 < np.abs(few.contact_loads - whole.contact_loads).max() <= few.remaining_load_change < np.inf


@pytest.mark.slow
def test_a_command_whose_reference_does_not_settle_says_so_keeps_it_and_ends_with_a_code_of_its_own(
    small, tmp_path, monkeypatch, command
):
    """One update of directions and gaps does not settle these loads."""
    file, store = tmp_path / "two.toml", tmp_path / "store"
    file.write_text(own_text("two-balls-across"))
    monkeypatch.setattr(setup, "mesh_and_condense_geometry", lambda *given, **_: replace(small, mesh_settings=given[2]))
    for updates, code in ((1, 5), (reference.ROUNDS, 0)):
        monkeypatch.setitem(reference.solve_reference.__kwdefaults__, "updates", updates)
        ended, found = command.json("compare", file, "--levels", "1", "--fresh", "--store", store, "--json")
        assert ended == code
        (said,) = found["scenes"]
        (kept,) = (json.loads(run.read_text()) for run in store.glob("two-level1-*.json"))
        load, stated = np.array(kept["load"]), said["uncertainty"]["discretisation_percent"]
        may_move = 100.0 * kept["moving"] / load[load > 0.0].mean()
        if code:
            assert kept["status"].startswith("not settled: loads may still move by")
            assert said["reference_status"] == f"level 1 {kept['status']}"
            assert stated >= may_move > 1.0
        else:
            assert (kept["status"], said["reference_status"], may_move) == ("converged", "converged", 0.0)
            assert stated < 1.0


def test_what_is_left_is_the_rest_of_a_geometric_series():
    loads = [np.array([[10.0 - 4.0 * 0.25**k, 5.0]]) for k in range(4)]
    left = {1: np.inf, 2: 99.0 * 3.0, 3: 10.0 - loads[2][0, 0], 4: 10.0 - loads[3][0, 0]}
    assert {k: reference.remaining_load_change(loads[:k]) for k in left} == pytest.approx(left)
    assert reference.remaining_load_change([loads[0]] * 2) == 0.0
