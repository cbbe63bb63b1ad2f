"""Printed numbers and claims of Lin (2019), 4.2: lash tests and steering gear; Smith's axis as a scene."""

from dataclasses import replace

import numpy as np
import pytest
from tests.evidence_study import GROUP, STUDY
from tests.sources.entries import check, keys

from rollbench.compare.cases.lin.evidence import steering
from rollbench.compare.cases.smith.evidence import axis
from rollbench.compare.cases.smith.evidence.bearings import APPLIED
from rollbench.compare.scenes import catalogue

pytestmark = pytest.mark.xdist_group(GROUP)


@pytest.mark.parametrize("key", keys("lin-4.2.1"))
def test_entry(key: str) -> None:
    check(key)


@pytest.mark.parametrize("pattern", steering.PATTERNS)
def test_patterns_keep_the_balls_apart_and_on_the_track(pattern: str) -> None:
    scene = catalogue.scene(steering.PATTERNS[pattern])
    at = np.array(scene.balls.azimuths)
    assert at.size == scene.ball_count == 71
    path = np.hypot(scene.track.pitch_radius, scene.track.lead / (2.0 * np.pi)) * at
    assert np.diff(path).min() >= 2.0 * scene.balls.radius
    assert np.ptp(path) + 2.0 * scene.balls.radius <= 3.75 * 2.0 * np.pi * path[0] / at[0] + 1e-6


def test_stacked_on_one_side_leaves_the_other_side_free_in_every_turn() -> None:
    at = np.array(catalogue.scene("lin-lash-one-side").balls.azimuths)
    wide = np.diff(at) > 2.0 * np.diff(at).min()
    assert wide.sum() == 4
    middles = 0.5 * (at[1:] + at[:-1])[wide]
    assert np.abs(np.cos(middles) + 1.0).max() < 0.2


def test_ratios_of_the_steering_gear_depend_on_what_is_not_printed() -> None:
    """So that 1.47 and 3.32 identify nothing: the pinion's restraint alone changes them by a third."""
    gear = steering.shipped_steering_gear()
    (pinion,) = gear.supports
    free = replace(gear, supports=(replace(pinion, fixed=(("ux", 0.0), ("uy", 0.0), ("rz", 0.0))),))
    clamped, pinned = (steering.load_ratios_at_18_degrees(one) for one in (gear, free))
    assert min(pinned[0] / clamped[0], pinned[1] / clamped[1]) > 1.2


@pytest.mark.parametrize("layout", axis.LAYOUTS, ids=lambda x: x.scene_name)
def test_smiths_axis_as_scenes_agrees_with_the_formulas(layout: axis.SupportBearingLayout) -> None:
    """Rows apart from one another on an elastic shaft share less evenly: a few per cent of the tension."""
    scene = axis.solve_by_beam_model(STUDY, layout, 0.5)
    closed = axis.solve_by_formulas(layout, 0.5)
    assert scene.right_thrust - scene.left_thrust == pytest.approx(APPLIED, abs=1e-6)
    assert scene.left_thrust == pytest.approx(closed.left_thrust, abs=0.03 * max(closed.right_thrust, APPLIED))
    assert scene.axis_stiffness == pytest.approx(closed.axis_stiffness, rel=0.015)


def test_sum_in_series_is_no_stiffness_of_any_layout() -> None:
    of = {layout: axis.solve_by_beam_model(STUDY, layout, 0.5).axis_stiffness for layout in axis.LAYOUTS}
    for layout in (axis.TRIPLEX, axis.TAPERED):
        assert axis.axis_stiffness_by_sum_in_series(layout) < 0.75 * of[layout]
    assert np.isnan(axis.axis_stiffness_by_sum_in_series(axis.SUPPORTED))
    assert of[axis.TRIPLEX] / of[axis.SUPPORTED] == pytest.approx(2.0, abs=0.05)
