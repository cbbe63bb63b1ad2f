"""A negative clearance of a bearing, by a press fit."""

import numpy as np
import pytest

from rollbench.compare.scenes.scene_file import parse_scene
from rollbench.lowfi.statics.axis.solve import solve_assembly

BEARING = """
title = "6205"
kind = "axis"
[material]
youngs_modulus = "206 GPa"
poissons_ratio = 0.3
[screw]
length = "100 mm"
outer_diameter = "25 mm"
conformity = 0.52
[[supports]]
at = "50 mm"
fix = ["ux", "uy", "uz", "rx", "ry", "rz"]
[[sets]]
name = "row"
thrust = "deep groove"
[sets.track]
pitch_diameter = "39 mm"
lead = "0 mm"
clearance = { radial = "CLEARANCE um" }
[sets.screw]
outer_diameter = "33 mm"
conformity = 0.52
[sets.nut]
position = "50 mm"
length = "15 mm"
outer_diameter = "52 mm"
conformity = 0.53
[sets.balls]
diameter = "7.938 mm"
count = 9
turns = 1
[sets.errors.balls]
oversize = "OVERSIZE um"
"""


def loads(clearance, oversize):
    text = BEARING.replace("CLEARANCE", str(clearance)).replace("OVERSIZE", str(oversize))
    return solve_assembly(parse_scene(text, "press.toml")).sets[0].balls.load


def test_a_press_fit_is_an_oversize_of_a_quarter_and_adds_to_it():
    pressed = loads(-8, 0)
    assert pressed.max() > 10.0
    np.testing.assert_allclose(pressed, loads(0, 2), rtol=1e-12)
    np.testing.assert_allclose(loads(-4, 1), pressed, rtol=1e-12)
    assert pressed.max() == pytest.approx(2.0**1.5 * loads(-4, 0).max(), rel=5e-3)
