"""A left-hand screw of two starts with friction and motion, as text, changed, and its answer."""

from tests.shipped_texts import changed, own_text

from rollbench.compare.scenes import scene_file
from rollbench.compare.studies.friction.whole import FrictionChoices, solve_friction_of_screw_or_bearing

MINE = own_text("feed-drive")


def mine(*changes):
    return scene_file.scene_from_text(changed("feed-drive", *changes), "my.toml")


def answer(scene, model="lin", **choices):
    return solve_friction_of_screw_or_bearing(scene, FrictionChoices(model, **choices))
