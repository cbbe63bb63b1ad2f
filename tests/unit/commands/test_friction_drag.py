"""Drag torque of whole screws: without loads, with supports that press, unknown; the band over measured coefficients."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.feed_drive import answer, mine
from tests.helpers import ALL_BUT_AXIAL, small_screw

from rollbench.compare.studies.friction.answer import format_three_digits
from rollbench.lowfi.friction.whole import feedback as ball_feedback
from rollbench.meshes.parts import Errors, Friction


def test_drag_is_the_friction_torque_of_the_scene_without_loads_and_without_preload_nothing():
    scene = mine()
    bare = answer(replace(scene, loads=())).data["torque"]
    assert answer(scene).data["torque"]["drag_torque_Nmm"] == pytest.approx(bare["friction_torque_Nmm"], rel=1e-9)
    assert bare["drag_torque_Nmm"] == bare["friction_torque_Nmm"]
    assert bare["axial_load_N"] == 0.0
    unknown = [bare[key] for key in ("efficiency_forward_percent", "self_locking", "load_moves")]
    assert unknown == [None] * 3, "no efficiency of a load that is round-off"
    loose = answer(small_screw(force=(0.0, 0.0, 500.0)), mu=(0.1,)).data
    assert (loose["torque"]["drag_torque_Nmm"], loose["drag_unknown"], loose["drag_note"]) == (0.0, None, None)


@pytest.mark.parametrize("oversize", [0.0, 5e-6])
def test_drag_where_supports_press_is_that_of_the_screw_left_free_along_its_axis(oversize):
    pressed = (*ALL_BUT_AXIAL, ("uz", 3e-6))
    held, free = (answer(small_screw(fixed=fixed, oversize=oversize), mu=(0.1,)).data for fixed in (pressed, ALL_BUT_AXIAL))
    assert abs(held["torque"]["axial_load_N"]) > 1.0
    assert held["torque"]["friction_torque_Nmm"] > 1.01 * held["torque"]["drag_torque_Nmm"]
    assert held["torque"]["drag_torque_Nmm"] == pytest.approx(free["torque"]["drag_torque_Nmm"], rel=1e-9)
    assert (free["torque"]["drag_torque_Nmm"] > 0.0) == (oversize > 0.0)
    assert "left free along its axis: its supports press it with" in held["drag_note"]
    assert (held["drag_unknown"], free["drag_note"]) == (None, None)


def test_balls_that_do_not_settle_are_named_and_leave_no_drag(monkeypatch):
    monkeypatch.setattr(ball_feedback, "ROUNDS", 0)
    monkeypatch.setattr("scipy.optimize.root", lambda _, start, **__: SimpleNamespace(x=start))
    found = answer(mine())
    assert not found.converged
    assert found.data["status"].startswith("friction and position do not agree on 20 balls: 1, 2")
    assert "feedback = false" in found.data["status"]
    assert (found.data["torque"]["drag_torque_Nmm"], found.data["drag_unknown"]) == (None, "no balance of friction found")
    assert found.data["feedback"]["unsettled_balls"] == 20


def test_torques_over_the_measured_coefficients_stand_beside_the_maker_s_formula():
    scene = replace(small_screw(force=(0.0, 0.0, 300.0), oversize=3e-6), friction=Friction(0.05, 0.05))
    found = answer(scene)
    data = found.data["band"]
    for mu, torque in zip((0.003, 0.1), data["friction_torque_Nmm"], strict=True):
        alone = answer(replace(scene, friction=Friction(mu, mu))).data["torque"]
        assert torque == pytest.approx(alone["friction_torque_Nmm"], rel=1e-9)
    assert data["drag_torque_Nmm"][1] == pytest.approx(alone["drag_torque_Nmm"], rel=1e-9)
    tangent = scene.track.lead / (2 * np.pi * scene.track.pitch_radius)
    formula = 0.05 / np.sqrt(tangent) * data["preload_N"] * 1e3 * scene.track.lead / (2 * np.pi)
    assert data["makers_formula_Nmm"] == pytest.approx(formula, rel=1e-9)
    assert 0.5 < data["drag_torque_Nmm"][1] / data["makers_formula_Nmm"] < 2.0
    assert f"{format_three_digits(data['makers_formula_Nmm'])} N mm" in found.text
    bare = answer(replace(scene, errors=Errors())).data["band"]
    assert (bare["makers_formula_Nmm"], bare["drag_torque_Nmm"]) == (None, None)
