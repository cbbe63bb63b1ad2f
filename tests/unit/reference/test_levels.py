"""Mesh levels of the 3D reference: complete, ordered, and in proportion to the ball."""

from dataclasses import fields

import numpy as np
import pytest

from rollbench.compare.reference import levels
from rollbench.hifi.meshing.settings import Settings

#: Lengths; all other settings are counts and ratios.
LENGTHS = {"own_sizes", "own_ball_sizes", "fine", "coarse", "ball_fine", "ball_coarse", "cell", "tet"}


@pytest.mark.parametrize("level", [levels.SOURCE_LEVEL, *levels.LEVELS])
def test_lengths_go_with_the_ball_and_counts_and_ratios_stay(level):
    """Twice the ball: the same mesh twice as large; the ball they are given for: as they are."""
    given = levels.SOURCE_MESH if level == levels.SOURCE_LEVEL else levels.LEVELS[level]
    assert levels.mesh_settings_of_level(level, levels.BALL) == given
    twice = levels.mesh_settings_of_level(level, 2.0 * levels.BALL)
    assert twice.keys() == given.keys() <= {x.name for x in fields(Settings)}
    Settings(**twice)
    for name, value in given.items():
        expected = pytest.approx(2.0 * np.array(value)) if name in LENGTHS else value
        assert twice[name] == expected, name
