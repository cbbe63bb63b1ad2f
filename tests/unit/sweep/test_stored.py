"""The shipped study of tolerances: of the scene as it is, and its worst screw solved again."""

import pytest

from rollbench.comparison.scenes import catalogue
from rollbench.comparison.scenes.scene_file import scene_hash
from rollbench.comparison.wings.sweep import section as tolerances
from rollbench.comparison.wings.sweep.keys import read_vary
from rollbench.comparison.wings.sweep.sample import solve_sample
from rollbench.comparison.wings.sweep.summary import MAIN

FOUND = tolerances.stored()
KEYS = read_vary(FOUND["vary"])
NAME = FOUND["scene"].removesuffix(".toml")


def test_scene_is_that_of_the_study():
    assert FOUND["scene_hash"] == scene_hash(catalogue.scene_text(NAME)), f"compute it anew: {tolerances.command(FOUND)}"


def test_worst_screw_is_what_the_model_gives_now():
    worst = FOUND["worst"][0]
    again = solve_sample(catalogue.scene_text(NAME), FOUND["scene"], KEYS, worst["values"], FOUND["model"], "interpreted")
    assert again["status"] == "converged"
    assert again[MAIN] == pytest.approx(worst[MAIN], rel=1e-8)
    assert again["at"] == worst["at"]


def test_table_has_every_key_and_the_one_that_matters_most_first():
    rows = tolerances.effects(KEYS, FOUND)
    assert len(rows) == len(KEYS) == 5
    assert [row["total"] for row in rows] == sorted((row["total"] for row in rows), reverse=True)
    assert len({row["key"] for row in rows}) == 5
    assert all(tolerances.words(vary) != vary.name for vary in KEYS)
