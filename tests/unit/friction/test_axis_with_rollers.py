"""Friction of balls on an axis that stands on rollers too, whose loads and warnings it leaves as they are."""

from dataclasses import replace

import pytest
from tests.axes import ROLLERS, fixed_axis, solved

from rollbench.compare.studies.friction.solve import solve_friction_of_shaft
from rollbench.compare.studies.friction.whole import FrictionChoices
from rollbench.meshes.axis import RollingSet


@pytest.mark.parametrize(("offset", "pressed"), [(2e-6, False), (150e-6, True)])
def test_friction_warns_of_pressed_rollers_as_statics_does(offset, pressed):
    places = (("rollers +", 0.03, "+z", -offset), ("rollers -", 0.07, "-z", offset))
    rows = [RollingSet(name, "tapered roller bearing", ROLLERS, z, offset=by, thrust=t) for name, z, t, by in places]
    axis = fixed_axis((0.0, 0.0, 600.0))
    axis = replace(axis, sets=(*rows, *axis.sets[2:]))
    of_rollers = [w for w in solved(axis).warnings if w.startswith("rollers") and w.kind == "pressure"]
    assert bool(of_rollers) is pressed
    warned = solve_friction_of_shaft(axis, FrictionChoices(model="lin", mu=(0.1,))).as_json()["warnings"]
    assert [w for w in warned if w.startswith("rollers") and w.kind == "pressure"] == of_rollers
