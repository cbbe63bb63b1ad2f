"""Lin (2019), section 4.3: friction of two bearings, geometric errors and ball-to-ball contact."""

from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
from tests.evidence_study import GROUP
from tests.sources.entries import check, keys, rows

from rollbench.compare.cases.lin.evidence.source_cases import double_row_bearing, four_point_bearing
from rollbench.compare.scenes.catalogue import scene
from rollbench.lowfi.friction import bearing
from rollbench.lowfi.friction.screw.groove import azimuth_between_touching_balls
from rollbench.lowfi.friction.whole.circuit import NUT, ContactOnset, contact_onset
from rollbench.lowfi.friction.whole.losses import ball_kinematics
from rollbench.lowfi.statics.static import solve_static

pytestmark = pytest.mark.xdist_group(GROUP)

ANGLES = np.radians(np.arange(0.0, 18.1, 2.0))
MAKERS = {"4P": four_point_bearing, "DR": double_row_bearing}


@pytest.mark.parametrize("key", keys("lin-4.2", "lin-4.3"))
def test_entry(key: str) -> None:
    check(key)


@cache
def curve(name: str, tilt: bool, **changes) -> bearing.BearingStates:
    return bearing.solve_bearing(MAKERS[name](tilt=tilt, **changes), ANGLES)


@cache
def assumptions() -> list[float]:
    ratios = []
    for phase, clearance, hertz in product((0.0, 0.25, 0.5), (0.0, 5e-6, -1e-6), ("right", "as printed")):
        case = four_point_bearing(tilt=True, phase=phase, clearance=clearance)
        found = bearing.solve_bearing(replace(case, groove=replace(case.groove, hertz=hertz)), ANGLES)
        assert found.converged.all()
        ratios.append(found.largest_over_smallest_torque)
    return ratios


def test_ratio_of_the_four_point_bearing() -> None:
    row = rows("lin-4.3")["ratio_4p"]
    found = assumptions()
    assert row.low <= min(found) < row.value < max(found) <= row.high
    tilted = curve("4P", True)
    assert tilted.largest_over_smallest_torque == pytest.approx(5.573, abs=2e-3)
    assert (tilted.balls_beyond_two_contacts[0], tilted.balls_beyond_two_contacts[-1]) == (0, 3)
    assert np.all(np.diff(tilted.torque) > 0.0)


def test_an_inner_ring_that_cannot_tilt_shows_no_transition() -> None:
    assert curve("4P", False).largest_over_smallest_torque < 1.03
    assert np.all(curve("4P", False).balls_beyond_two_contacts == 0)
    later = bearing.solve_bearing(four_point_bearing(tilt=False), np.radians([0.0, 30.0, 45.0]))
    assert later.largest_over_smallest_torque > 3.0
    assert later.balls_beyond_two_contacts[-1] > 0


def test_double_row_varies_less() -> None:
    for tilt, most in ((False, 1.03), (True, 1.28)):
        dr = curve("DR", tilt)
        assert dr.converged.all()
        assert not dr.balls_beyond_two_contacts.any()
        assert dr.largest_over_smallest_torque < most
    face = curve("DR", True, rows=(bearing.BallRow(-6e-3, bearing.DIAGONAL), bearing.BallRow(6e-3, bearing.OTHER)))
    assert face.largest_over_smallest_torque < 1.28
    assert min(assumptions()) > 3.0 * face.largest_over_smallest_torque


@pytest.mark.parametrize("tilt", [False, True])
@pytest.mark.parametrize("name", MAKERS)
def test_bearing_in_equilibrium(name: str, tilt: bool) -> None:
    """Force and moment on the inner ring, from the contact forces alone; power in is dissipation."""
    case, angle = MAKERS[name](tilt=tilt, arm=2e-3), np.radians(12.0)
    s = bearing.solve_bearing(case, angle)
    assert s.converged.all()
    assert s.input_power[0] == pytest.approx(s.loss.sum(), rel=1e-9)
    assert s.torque[0] * case.groove.speed == pytest.approx(-s.loss.sum(), rel=1e-9)
    n = case.groove.normals(s.load[0].angle)
    force, moment = np.zeros(3), np.zeros(3)
    for k in range(s.loss.shape[1]):
        row, azimuth = case.rows[k // case.count], 2.0 * np.pi * (k % case.count) / case.count
        out = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        around = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        on_ring = s.force[0, k, :2] @ n[k, :2] @ np.stack([out, around, [0.0, 0.0, 1.0]])
        force += on_ring
        moment += np.cross(case.groove.pitch_radius * out + [0.0, 0.0, row.place], on_ring)
    expected = 3000.0 * np.array([np.sin(angle), 0.0, np.cos(angle)])
    assert force == pytest.approx(-expected, abs=1e-5)
    if tilt:
        assert moment[:2] == pytest.approx(-np.cross([0.0, 0.0, 2e-3], expected)[:2], abs=1e-6)
    assert np.all((s.force[0] > 0.0).sum(axis=1) <= (4 if name == "4P" else 2))


def test_mirrored_load() -> None:
    """The force at minus the angle, seen from the other side: the same torque; rows swap."""
    for make in MAKERS.values():
        case = make(tilt=True)
        one, two = (bearing.solve_bearing(case, np.radians(a)) for a in (15.0, -15.0))
        if case.count % 2:  # half a ball distance turns the pattern of an odd number by half a turn
            two = bearing.solve_bearing(replace(case, phase=0.5), np.radians(-15.0))
        reverse = bearing.solve_bearing(case, np.radians(180.0 - 15.0))
        assert [two.torque[0], reverse.torque[0]] == pytest.approx(2 * [one.torque[0]], rel=1e-8)


def test_torque_goes_with_friction_and_not_with_speed() -> None:
    def torque(**changes: float) -> float:
        case = four_point_bearing(tilt=True)
        return bearing.solve_bearing(replace(case, groove=replace(case.groove, **changes)), 0.2).torque[0]

    assert torque(mu=0.2) == pytest.approx(2.0 * torque(), rel=1e-9)
    assert torque(screw_speed=200.0) == pytest.approx(torque(), rel=1e-9)


@cache
def onset(name: str, idle: float) -> ContactOnset:
    s = scene(name)
    return contact_onset(s, solve_static(s), unloaded_speed_ratio=idle)


def test_roundness_brings_balls_together_sooner_than_pitch() -> None:
    """Screw of Table 4.1, errors of 5 um: lost balls are run into, and only roundness errors make them."""
    pitch, nominal = onset("lin-pitch-4p1", 0.0), onset("lin-nominal-4p1", 0.0)
    for idle in (0.0, 0.9):
        round_ = onset("lin-roundness-4p1", idle)
        assert round_.converged
        assert (round_.contact_load_sums == 0.0).sum() > 10
        assert round_.rotation_to_first_meeting < 0.2 * 2.0 * np.pi
        assert np.isfinite(round_.rotation_to_meeting).sum() > 0
        assert round_.rotation_to_first_meeting < 0.01 * pitch.rotation_to_first_meeting
    assert (pitch.contact_load_sums > 0.0).all()
    assert nominal.rotation_to_first_meeting > pitch.rotation_to_first_meeting > 10.0 * 2.0 * np.pi
    assert np.degrees(onset("lin-roundness-4p1", 0.0).rotation_to_first_meeting) == pytest.approx(5.85, abs=0.05)


def test_onset_is_gap_over_closing_speed_and_lost_balls_that_roll_along_do_not_meet_sooner() -> None:
    """The conclusion rests on what lost balls do: at the nominal velocity it is gone."""
    assert onset("lin-roundness-4p1", 1.0).rotation_to_first_meeting > 10.0 * 2.0 * np.pi
    o, s = onset("lin-roundness-4p1", 0.0), scene("lin-roundness-4p1")
    k = int(np.argmin(o.rotation_to_meeting))
    first, second = o.neighbour_pairs[k]
    assert o.contact_load_sums[first] > 0.0 == o.contact_load_sums[second]
    assert o.rotation_to_first_meeting == pytest.approx(o.pair_gaps[k] / o.orbital_speeds[first], rel=1e-12)
    touching = azimuth_between_touching_balls(ball_kinematics(s, NUT, s.balls.radius))
    assert o.pair_gaps[k] == pytest.approx(2.0 * np.pi * 3.75 / 71 - touching, rel=1e-9)


def test_scenes_and_bearings_that_friction_cannot_take() -> None:
    with pytest.raises(ValueError, match="zero lead"):
        four_point_bearing(tilt=False, groove=replace(four_point_bearing(tilt=False).groove, lead=1e-3))
    assert four_point_bearing(tilt=False).rows[0].contacts == bearing.ALL
