"""Mesh levels of the 3D reference: complete, ordered, and in proportion to the ball."""

from dataclasses import fields

import numpy as np
import pytest

from rollbench.compare.reference import levels, variants
from rollbench.hifi.meshing.settings import Settings

#: Lengths; all other settings are counts and ratios.
LENGTHS = {"own_sizes", "own_ball_sizes", "fine", "coarse", "ball_fine", "ball_coarse", "cell", "tet"}


@pytest.mark.parametrize("level", [levels.SOURCE_LEVEL, *levels.LEVELS])
def test_lengths_go_with_the_ball_and_counts_and_ratios_stay(level):
    """Twice the ball: the same mesh twice as large; the ball they are given for: as they are."""
    given = levels.SOURCE_MESH if level == levels.SOURCE_LEVEL else levels.LEVELS[level]
    assert levels.scaled(level, levels.BALL) == given
    twice = levels.scaled(level, 2.0 * levels.BALL)
    assert twice.keys() == given.keys() <= {x.name for x in fields(Settings)}
    Settings(**twice)
    for name, value in given.items():
        expected = pytest.approx(2.0 * np.array(value)) if name in LENGTHS else value
        assert twice[name] == expected, name


def test_every_choice_is_refined_from_level_to_level_or_stays():
    assert list(levels.LEVELS) == list(range(1, len(levels.LEVELS) + 1))
    assert levels.STUDIED == (1, 2, 3, levels.PRODUCTION + 1)
    for a, b in zip(list(levels.LEVELS)[:-1], list(levels.LEVELS)[1:], strict=True):
        coarse, fine = levels.LEVELS[a], levels.LEVELS[b]
        assert coarse.keys() == fine.keys()
        for name, value in coarse.items():
            pairs = zip(value, fine[name], strict=True) if isinstance(value, tuple) else [(value, fine[name])]
            for before, after in pairs:
                finer = before >= after if name in LENGTHS | {"growth"} else before <= after
                assert finer, (a, name)
        assert 1.3 < fine["b_over_h"] / coarse["b_over_h"] < 1.4
        assert 1.15 < coarse["own_sizes"][0] / fine["own_sizes"][0] < 1.45


def test_every_choice_of_the_finest_level_can_be_refined_alone():
    """What lies beyond the finest level is finer in everything, and only the choices named are taken from it."""
    finest = levels.LEVELS[levels.PRODUCTION]
    assert levels.BEYOND.keys() == finest.keys()
    for name, value in levels.BEYOND.items():
        for further, before in zip(np.atleast_1d(value), np.atleast_1d(finest[name]), strict=True):
            assert further < before if name in LENGTHS | {"growth"} else further > before, name
    refined = levels.scaled(levels.PRODUCTION, 2.0 * levels.BALL, ("growth", "fine"))
    plain = levels.scaled(levels.PRODUCTION, 2.0 * levels.BALL)
    assert {name for name in plain if plain[name] != refined[name]} == {"growth", "fine"}
    assert refined["fine"] == pytest.approx(2.0 * levels.BEYOND["fine"])


def test_variants_refine_every_choice_of_the_finest_level_once():
    named = [name for variant in variants.VARIANTS.values() for name in variant.refined]
    assert sorted(named) == sorted(levels.LEVELS[levels.PRODUCTION])
