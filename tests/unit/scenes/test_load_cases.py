"""``[[cases]]``: what they become, and what is refused in one line."""

from dataclasses import replace

import pytest
from tests.load_cases import SHIPPED, TEXT, case

from rollbench.compare.errors import InputError
from rollbench.compare.scenes import scene_file, template

LIKE = template.new_scene_text("ball screw", "40x10")
TIMED = case("cutting", "8 kN", time="30 s", speed="200 rpm") + case("rapid", time="10 s", speed="-1000 rpm")
TIMED += case("crash", "40 kN", share=0.0)


def bare(scene):
    return replace(scene, name="", friction=None)


def test_cases_are_the_scene_with_what_differs():
    cycle = scene_file.parse_scene(TEXT, "two.toml")
    first, second, third = (one.scene for one in cycle.cases)
    assert (cycle.name, cycle.revolution_shares) == ("two", (0.75, 0.25, 0.0))
    assert [one.name for one in (first, second, third)] == ["two-balls", "two-push", "two-loose"]
    assert bare(first) == bare(SHIPPED), "nothing else is changed: stored runs serve"
    assert dict(second.supports[0].fixed) == dict(SHIPPED.supports[0].fixed) | {"uz": 8e-6}
    assert replace(bare(second), supports=SHIPPED.supports) == bare(SHIPPED)
    assert third.errors.balls.oversize == 2e-6
    assert scene_file.kind_of_scene(cycle) == "bearing"
    assert scene_file.parse_scene(cycle.to_toml(), "two.toml") == cycle


def test_shares_follow_from_times_and_speeds():
    cycle = scene_file.parse_scene(LIKE + TIMED, "my.toml")
    cutting, rapid, crash = cycle.cases
    assert cycle.revolution_shares == pytest.approx((6000 / 16000, 10000 / 16000, 0.0))
    assert cycle.speed == pytest.approx(2 * 3.141592653589793 * 16000 / 60 / 40), "turns over time"
    assert [one.scene.loads[0].force[2] for one in (cutting, crash)] == [8e3, 4e4]
    assert rapid.scene.loads == cycle.parts.loads, "its own where it has none"
    assert rapid.scene.motion.speed < 0.0
    assert scene_file.parse_scene(cycle.to_toml(), "my.toml") == cycle


def test_the_commented_cases_of_a_new_scene_are_read():
    start = LIKE.index("# [[cases]]")
    shown = LIKE[:start] + "\n".join(x.removeprefix("# ") for x in LIKE[start : LIKE.index("# [friction]")].splitlines())
    assert [one.name for one in scene_file.parse_scene(shown, "my.toml").cases] == ["cutting", "rapid"]
    assert not hasattr(scene_file.parse_scene(LIKE, "my.toml"), "cases"), "comments only"


def test_commands_of_one_load_case_refuse_several():
    with pytest.raises(InputError, match=r"cases: got 3 cases; allowed: a scene without \[\[cases\]\]"):
        scene_file.scene_from_text(TEXT, "two.toml")
