"""Random axes, judged from their numbers alone; the long one is ``python -m tests.campaign --axes 300 --keep FILE``."""

from dataclasses import replace

import pytest
from tests.axes import fixed_axis, solved
from tests.campaign import check_axes, scenes
from tests.campaign.__main__ import run_solve
from tests.campaign.draw_axes import axis_text

from rollbench.compare.models.registry import MODELS
from rollbench.compare.scenes import scene_file
from rollbench.compare.studies import extremes

#: Axes that were wrong or without an answer, by seed and number: what they are now, by what they needed.
ONCE_BAD = {
    (770202, 283): extremes.RIGHT,  # only round-off loads its housing
    (1, 0): extremes.RIGHT,  # a preload by force that other sets exceed without any shift
    (1, 68): extremes.PROVEN,  # a preload by force that nothing holds
    (1, 53): extremes.PROVEN,  # at mounting the shaft screws through its nut, by 30 mm
    (1, 128): extremes.PROVEN,  # a housing that goes 31 m and does not settle
    (1, 136): extremes.RIGHT,  # held at contact angles that are not the nominal ones
    (1, 248): extremes.PROVEN,  # the shaft turns by 0.27 rad
    (9201, 0): extremes.RIGHT,  # nothing presses the contacts, 1e-44 N of round-off in which were to be balanced
    (9201, 182): extremes.PROVEN,  # at mounting a preload draws the balls of another row across its groove's bottom
    (9501, 225): extremes.PROVEN,  # a ball on the bottom itself, at an angle of round-off: nothing holds its row together
    (9802, 254): extremes.RIGHT,  # rollers that nothing presses, with loads of 1e-27 N
    (880601, 215): extremes.RIGHT,  # sets that just touch: a shaft between forces of 1e-16 N was out of balance
    (881301, 90): extremes.RIGHT,  # rollers that just touch, with 3e-16 N on a housing
    (9501, 293): extremes.RIGHT,  # an outer part tied stiffly to a housing that turns by 4 mrad at mounting
    (9301, 160): extremes.PROVEN,  # the same by a preload on a housing that moves
}


@pytest.mark.parametrize(("seed", "number"), ONCE_BAD)
def test_axes_that_were_wrong_once(seed, number):
    found = scenes.judge(seed, number, "lin", draw=axis_text)
    assert found.verdict == ONCE_BAD[seed, number], found.words


def test_a_set_that_loads_open_altogether_is_answered_through_the_command_line():
    """The search of its lift-off load once ended in a traceback."""
    found = scenes.judge(880501, 46, "lin", run_solve, axis_text)
    assert found.verdict == extremes.RIGHT, found.words


def test_axes_that_are_only_warm_are_right_and_do_not_jump_under_a_small_load():
    found = [scenes.judge(5, number, "lin", draw=axis_text) for number in (7, 17)]
    assert [o.verdict for o in found] == [extremes.RIGHT] * 2, [o.words for o in found]


def test_random_axes_are_right_or_refused_with_proof():
    found = list(scenes.judge_scenes(scenes.Campaign(5, 12, axes=True)))
    assert not [o for o in found if o.verdict in extremes.BAD]
    assert sum(o.verdict == extremes.RIGHT for o in found) >= 6


def test_the_judge_sees_what_is_off():
    """A motion of the shaft, a load of a ball, a force of a spring: each by a share of 1e-6."""
    axis = fixed_axis()
    found = solved(axis)
    assert check_axes.faults(axis, found) == ""
    line = found.centreline.copy()
    line[len(line) // 2] *= 1.0 + 1e-6
    assert "out of balance" in check_axes.faults(axis, replace(found, centreline=line))
    balls = replace(found.sets[0].balls, load=found.sets[0].balls.load * (1.0 + 1e-6))
    sets = (replace(found.sets[0], balls=balls), *found.sets[1:])
    assert "Hertz' law" in check_axes.faults(axis, replace(found, sets=sets))
    pulled = replace(axis.housings[0], force=(0.0, 0.0, 600.001))
    assert "carriage is out of balance" in check_axes.faults(replace(axis, housings=(pulled,)), found)


def test_the_judge_sees_what_is_off_at_mounting():
    """A preload on a housing that moves, while another housing is held where it is: loads of the row whose balls cross its
    groove's bottom, the slide of the outer part, what pushes it, and what pushes the housing back, each by a millionth."""
    axis = check_axes.as_mounted(scene_file.parse_scene(axis_text(9301, 160), "campaign.toml"))
    found = MODELS["lin"].solve_assembly_or_reason(axis, scenes.WITHOUT_MESH_ERROR)
    assert check_axes.faults(axis, found) == ""
    assert check_axes.crossed(axis, found)
    sets = list(found.sets)
    sets[3] = replace(sets[3], balls=replace(sets[3].balls, load=sets[3].balls.load * (1.0 + 1e-6)))
    assert "Hertz' law" in check_axes.faults(axis, replace(found, sets=tuple(sets)))
    *others, seat = found.housings
    slid = (*others, replace(seat, motion=seat.motion * (1.0 + 1e-6)))
    assert "Hertz' law" in check_axes.faults(axis, replace(found, housings=slid))
    for i, name in ((1, "h1"), (2, "outer part of s0")):
        pushed = list(axis.housings)
        pushed[i] = replace(pushed[i], force=(0.0, 0.0, pushed[i].force[2] * (1.0 + 1e-6)))
        assert f"{name} is out of balance" in check_axes.faults(replace(axis, housings=tuple(pushed)), found)
