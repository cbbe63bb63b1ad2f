"""A left-hand screw of two starts with friction and motion, as text, changed, and its answer."""

from tests.shipped_texts import changed, own_text

from rollbench.compare.scenes import scene_file
from rollbench.compare.studies.friction.whole import Choices, solve_scene

MINE = own_text("feed-drive")


def mine(*changes):
    return scene_file.scene_of_text(changed("feed-drive", *changes), "my.toml")


def answer(scene, model="lin", **choices):
    return solve_scene(scene, Choices(model, **choices))
