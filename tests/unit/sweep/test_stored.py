"""The shipped study of tolerances: of the scene as it is, and its worst screw solved again."""

import pytest

from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.sections import tolerances as tolerances
from rollbench.compare.studies.sweep.keys import read_vary
from rollbench.compare.studies.sweep.outputs import MAIN
from rollbench.compare.studies.sweep.sample import solve_sample

FOUND = tolerances.stored()
KEYS = read_vary(FOUND["vary"])
NAME = FOUND["scene"].removesuffix(".toml")


def test_scene_is_that_of_the_study_and_worst_screw_what_the_model_gives_now():
    text, worst = catalogue.scene_text(NAME), FOUND["worst"][0]
    assert FOUND["scene_hash"] == scene_file.scene_hash(text), f"compute it again: {tolerances.command(FOUND)}"
    again = solve_sample(text, FOUND["scene"], KEYS, worst["values"], FOUND["model"], "interpreted")
    assert (again["status"], again["at"]) == ("converged", worst["at"])
    assert again[MAIN] == pytest.approx(worst[MAIN], rel=1e-8)


def test_table_has_every_key_and_the_one_that_matters_most_first():
    rows = tolerances.effects(KEYS, FOUND)
    assert len(rows) == len(KEYS) == 5
    assert [row["total"] for row in rows] == sorted((row["total"] for row in rows), reverse=True)
    assert len({row["key"] for row in rows}) == 5
    assert all(tolerances.words(vary) != vary.name for vary in KEYS)
