"""A whole ball screw over time: order, gaps, energy, recirculation, limits."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import rollbench
from rollbench.compare.cases.lin.evidence.source_cases import simulation_inputs
from rollbench.compare.scenes import catalogue
from rollbench.lowfi.friction.screw import run as screw_run
from rollbench.lowfi.friction.screw.motion import solve_ball_motion
from rollbench.lowfi.friction.screw.travel import TravelHistory

pytestmark = pytest.mark.xdist_group("whole run of the source")


@cache
def result(**changes) -> TravelHistory:
    return screw_run.simulate_equal_steps(simulation_inputs(**changes))


CASES = {
    "nominal": {},
    "no oversize": {"oversize": 0.0, "coupling": "ball and screw", "steps": 60, "duration": 0.6},
    "tube": {"tube": 0.4, "amplitude": np.radians(5.0), "steps": 80},
    "coarse": {"steps": 40},
    "backwards": {"phase": 0.5, "steps": 80},
}


@pytest.mark.parametrize("name", CASES)
def test_balls_keep_their_order_never_overlap_and_push_only_where_they_touch(name: str) -> None:
    r = result(**CASES[name])
    run = r.setting
    assert r.converged.all()
    assert r.gap.min() >= 0.0
    free = run.ring - run.count * run.groove.pair.spacing
    assert r.gap.sum(axis=1) == pytest.approx(np.full(run.steps, free), abs=1e-11)
    ahead = np.diff(np.column_stack([r.azimuth, r.azimuth[:, 0] + run.ring]), axis=1)
    assert ahead[1:] == pytest.approx(r.spacing[:-1], abs=1e-11)
    assert ahead.min() >= run.groove.pair.spacing - 1e-11
    assert r.presses_on_next.any()
    assert r.ball_force.min() >= 0.0
    assert np.max(r.gap[r.presses_on_next]) < 1e-10
    assert np.abs(r.imbalance).max() < 1e-8
    loaded = np.array([run.fold_into_track(a, n)[1] for a, n in zip(r.azimuth, r.nut_angle, strict=True)])
    assert np.array_equal(r.load.sum(axis=2) > 0.0, loaded), "balls in the tube bear no load"
    assert (0.0 < np.mean(~loaded) < 0.1) == (name == "tube")


def test_many_balls_with_a_contact_that_hardly_bears_find_their_balance(tmp_path) -> None:
    """A third of the balls lies between two and three contacts: round-off leaves no residual of 1e-10 on their path."""
    text = catalogue.shipped_scene_text("lin-screw-run")
    for old, new in (('"1.7 um"', '"1 um"'), ('"2 s"', '"0.32 s"'), ("steps = 200", "steps = 4")):
        assert text.count(old) == 1
        text = text.replace(old, new)
    path = tmp_path / "run.toml"
    path.write_text(text, encoding="utf-8")
    found = rollbench.friction(path)
    assert found.converged


def test_without_deviation_nothing_touches() -> None:
    r = result(amplitude=0.0, steps=20, duration=0.2)
    assert not r.presses_on_next.any()
    assert np.ptp(r.omega) < 1e-6 * r.setting.groove.speed
    assert np.all(r.ball_torque == 0.0)


def test_free_balls_follow_their_speeds() -> None:
    """While nothing touches, each ball's azimuth is the integral of its own speed over theta: separate quadrature."""
    r = result(amplitude=np.radians(0.5), steps=200, duration=0.4)
    run = r.setting
    assert not r.presses_on_next.any()
    turned, loads = np.radians(np.linspace(-0.5, 0.5, 9)), np.median(r.load.reshape(-1, 4), axis=0)
    angles = run.groove.contact_angle + turned[:, None] * np.array(run.pattern)
    orbits = [solve_ball_motion(run.groove, loads, angle).motion.unknown_velocities[0] for angle in angles]
    speed = CubicSpline(turned, orbits)
    azimuth, h = r.azimuth[0].copy(), run.duration / run.steps
    for _ in range(run.steps - 1):
        half = azimuth + 0.5 * h * speed(screw_run.contact_angle_deviation(run, azimuth))
        azimuth += h * speed(screw_run.contact_angle_deviation(run, half))
    assert np.diff(r.azimuth[-1]) == pytest.approx(np.diff(azimuth), abs=3e-5)
    assert np.abs(r.spacing[-1] - r.spacing[0]).max() > 1e-3  # what the tolerance has to tell apart


def test_recirculation_folds_balls_into_the_nut() -> None:
    run = simulation_inputs(tube=0.4)
    azimuth = np.array([-7.0, -6.0, 0.0, 6.0, 6.4, 6.9])
    there, loaded = run.fold_into_track(azimuth, 0.0)
    assert there == pytest.approx([-7.0 + run.ring, -6.0, 0.0, 6.0, 6.4, -6.9 + 2.0 * 6.9 - run.ring], abs=1e-12)
    assert list(loaded) == [True, True, True, True, False, True]
    later, _ = run.fold_into_track(azimuth + 1.0, 1.0)
    assert later == pytest.approx(there + 1.0)
    cell = screw_run.balls_at_instant(run, there, loaded, 0.0)
    assert cell.interference[4].max() < -1e-4


def test_summary() -> None:
    s = screw_run.summarise_screw_run(result())
    assert s.most_touching_groups == 4
    assert 0.0 < s.nut_angle_of_largest_ratio < s.nut_angle_without_contact


@pytest.mark.parametrize("coupling", ["ball", "ball and screw"])
def test_rounds_agree_in_every_step(coupling: str) -> None:
    """Loads and friction of each step, begun from the step before; with one round the friction lags behind."""
    lagged, agreed = (result(coupling=coupling, rounds=n, steps=25, duration=0.25) for n in (1, 100))
    assert agreed.converged.all()
    assert np.all(agreed.change <= 1e-11 * agreed.load.sum(axis=(1, 2)))
    assert np.all(lagged.change > 1e-6 * lagged.load.sum(axis=(1, 2)))  # what the rounds are for
    assert agreed.presses_on_next.any()
    assert np.abs(agreed.imbalance).max() < 1e-8


def test_runs_side_by_side_are_those_of_each_alone() -> None:
    """Runs that differ in pattern, direction or friction: the same motion."""
    run = simulation_inputs(steps=6, duration=0.06)
    back, rough = replace(run.groove, nut_speed=-run.groove.nut_speed), replace(run.groove, mu=0.05)
    runs = [run, replace(run, pattern=screw_run.SHIFTED), replace(run, groove=back), replace(run, groove=rough)]
    alone = [screw_run.simulate_equal_steps(one) for one in runs]
    together = screw_run.simulate_runs_in_equal_steps(runs)
    for one, other in zip(alone, together, strict=True):
        assert other.status == one.status == "converged"
        assert other.torque == pytest.approx(one.torque, rel=1e-9)
        assert other.omega == pytest.approx(one.omega, rel=1e-9)
