"""A negative clearance of a bearing, by a press fit."""

import numpy as np
import pytest
from tests.shipped_texts import changed

from rollbench.compare.scenes.scene_file import parse_scene
from rollbench.lowfi.statics.axis.solve import solve_assembly


def loads(clearance, oversize):
    """Contact loads of a deep groove bearing whose inner ring is held: it bears no load but the press fit's."""
    held = ('fix = ["uy"', 'fix = ["ux", "uz", "uy"')
    fit = ('contact_angle = "15.44449456 deg"', f'clearance = {{ radial = "{clearance} um" }}')
    text = changed("public/b1-nptel-clearance", held, fit) + f'[sets.errors.balls]\noversize = "{oversize} um"\n'
    return solve_assembly(parse_scene(text, "press.toml")).sets[0].balls.load


def test_a_press_fit_is_an_oversize_of_a_quarter_and_adds_to_it():
    pressed = loads(-8, 0)
    assert pressed.max() > 10.0
    np.testing.assert_allclose(pressed, loads(0, 2), rtol=1e-12)
    np.testing.assert_allclose(loads(-4, 1), pressed, rtol=1e-12)
    assert pressed.max() == pytest.approx(2.0**1.5 * loads(-4, 0).max(), rel=5e-3)
