"""What the motor of an axis turns: sums, energy, directions, bearings without a nut, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from tests.axes import ROLLERS, assembly, bearing, fixed_axis

from rollbench.compare.errors import InputError
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.results.solving import solve_with_results as solve
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.studies.friction.solve import solve_friction_of_shaft
from rollbench.compare.studies.friction.whole import FrictionChoices
from rollbench.lowfi.bearings.torque import roller_bearing_torque
from rollbench.meshes.axis import Drive, RollingSet
from rollbench.meshes.parts import Friction, Load, Lubricant, Motion

LIN = FrictionChoices(model="lin")
OIL, FAST = Lubricant(50e-6), Motion(120.0)


def driven(mu=0.1, motion=FAST, **drive):
    """The axis of the tests, with lubricant, seals and what its motor moves."""
    axis = fixed_axis()
    sets = tuple(replace(s, seals=0.02) for s in axis.sets)
    made = Friction(mu, mu, neighbours=False)
    return replace(axis, sets=sets, friction=made, motion=motion, lubricant=OIL, drive=Drive(torque=0.3, **drive))


def test_the_torque_is_the_sum_of_nuts_bearings_seals_and_all_else():
    data = solve_friction_of_shaft(driven(), LIN).as_json()
    drive, of_nut = data["drive"], data["sets"][4]
    assert [x["name"] for x in drive["sets"]] == ["left +", "left -", "right +", "right -", "nut"]
    assert drive["sets"][4]["running_Nmm"] == pytest.approx([of_nut["driving_torque_on_screw_Nmm"]] * 2)
    assert drive["seals_Nmm"] == pytest.approx(5 * 20.0) == sum(x["seals_Nmm"] for x in drive["sets"])
    for whole, one in (("running_torque_Nmm", "running_Nmm"), ("starting_torque_Nmm", "starting_Nmm")):
        sums = np.sum([x[one] for x in drive["sets"]], axis=0) + 100.0 + 300.0
        assert drive[whole] == pytest.approx(sums, rel=1e-12)
    alone = solve(driven(), "lin", ModelOptions())
    assert alone.drive is not None
    assert 1e3 * np.array(alone.drive.running) == pytest.approx(drive["running_torque_Nmm"], rel=1e-9)


@pytest.mark.parametrize("name", ["axis-fixed-fixed", "smith-axis"])
def test_a_shipped_axis_answers_the_torque_of_its_motor(name):
    torques = solve(catalogue.shipped_scene(name), "lin", ModelOptions()).drive
    assert torques is not None
    assert torques.running is not None
    assert 0.0 < torques.running[0] <= torques.running[1]


def test_acceleration_puts_in_the_energy_of_all_that_moves():
    time, mass, motor = 0.2, 150.0, 2e-3
    moved = driven(mass=mass, motor_inertia=motor, time=time)
    drive, unknown = (
        solve_friction_of_shaft(replace(moved, drive=replace(moved.drive, efficiency=e)), LIN).as_json()["drive"]
        for e in (1.0, None)
    )
    turning = 0.5 * (1e-6 * drive["shaft_inertia_kg_mm2"] + motor) * FAST.speed**2
    moving = 0.5 * mass * (10e-3 / (2.0 * np.pi) * FAST.speed) ** 2
    extra = 1e-3 * (np.array(drive["accelerating_torque_Nmm"]) - drive["running_torque_Nmm"])
    assert extra * FAST.speed * time / 2.0 == pytest.approx(turning + moving, rel=1e-12)
    low, high = 1e-3 * (np.array(unknown["accelerating_torque_Nmm"]) - unknown["running_torque_Nmm"]) - extra
    share = mass * (10e-3 / (2.0 * np.pi)) ** 2 * FAST.speed / time
    assert (low, high) == pytest.approx((share * (1 / 0.95 - 1), share * (1 / 0.9 - 1)), rel=1e-9)


def test_a_load_hinders_one_way_and_drives_the_other_and_friction_always_hinders():
    """Without friction in the nut, what is left of both ways together is twice the rest."""
    there, back = (solve_friction_of_shaft(driven(0.0, Motion(w)), LIN).as_json()["drive"] for w in (120.0, -120.0))
    nuts = [x["sets"][4]["running_Nmm"][0] for x in (there, back)]
    assert nuts[0] == pytest.approx(-nuts[1], rel=1e-6)
    assert abs(nuts[0]) == pytest.approx(1e3 * 600.0 * 10e-3 / (2.0 * np.pi), rel=1e-3)
    rest = np.array(there["running_torque_Nmm"]) - nuts[0]
    assert rest == pytest.approx(np.array(back["running_torque_Nmm"]) - nuts[1], rel=1e-6)
    assert rest.min() > 0.0


def test_a_shaft_in_rollers_alone_answers_without_a_coefficient():
    places = (("rollers +", 0.03, "+z", -3e-6), ("rollers -", 0.07, "-z", 3e-6))
    rows = [RollingSet(name, "tapered roller bearing", ROLLERS, z, offset=by, thrust=t) for name, z, t, by in places]
    axis = replace(assembly(*rows), loads=(Load(0.05, (0.0, 0.0, 500.0)),), supports=fixed_axis().supports)
    axis = replace(axis, motion=FAST, lubricant=OIL)
    found, alone = solve_friction_of_shaft(axis, LIN), solve(axis, "lin", ModelOptions())
    by_hand = [roller_bearing_torque(s.of.parts, s.line_loads, FAST.speed, OIL) for s in alone.solution.sets]
    low, high = found.drive.running
    assert low < sum(x.torque for x in by_hand) < high
    assert solve_friction_of_shaft(replace(axis, motion=None), LIN).drive.running is None
    assert solve_friction_of_shaft(replace(axis, friction=Friction(0.1, 0.1)), LIN).drive == found.drive
    with pytest.raises(InputError, match=r"mu: got 0\.1.*rollers"):
        solve_friction_of_shaft(axis, FrictionChoices(model="lin", mu=(0.1,)))


def test_several_coefficients_make_a_table():
    found = solve_friction_of_shaft(replace(driven(), friction=None), FrictionChoices(model="lin", mu=(0.05, 0.1)))
    low, high = (row["friction_torque_Nmm"] for row in found.as_json()["over_friction"])
    assert low < high
    assert found.as_json()["torque"]["friction_torque_Nmm"] == pytest.approx(low)


@pytest.mark.parametrize("force", [1.0, 4.0])
def test_load_s_part_grows_as_the_friction_of_the_balls_in_their_contacts_does(force):
    """Two formulations, one by coefficients of makers and one by sliding and spin of every ball: their ratio stays."""

    def ratio(scale):
        axis = assembly(bearing("row", 0.1, "+z"), supports=fixed_axis().supports)
        axis = replace(axis, loads=(Load(0.1, (0.0, 0.0, 1000.0 * scale)),), friction=Friction(0.1, 0.1), motion=FAST)
        data = solve_friction_of_shaft(axis, LIN).as_json()
        assert data["converged"]
        return data["sets"][0]["friction_torque_Nmm"] / data["drive"]["sets"][0]["starting_Nmm"][0]

    assert ratio(force) == pytest.approx(ratio(2.0), rel=0.05)
    assert 0.25 < ratio(force) < 2.0


def test_life_of_all_sets_is_that_of_parts_in_series():
    one = solve(driven(), "lin", ModelOptions())
    sets, life = [*one.sets.values()], one.axis_life
    for found, lives in (
        (life.revolutions, [x.life_by_loads.revolutions for x in sets]),
        (life.basic, [x.life.revolutions for x in sets]),
    ):
        assert found == pytest.approx((np.array(lives) ** (-10 / 9)).sum() ** -0.9, rel=1e-9)
    assert life.distance == pytest.approx(1e6 * life.revolutions * 10e-3)
    assert life.hours == pytest.approx(1e6 * life.revolutions * 2.0 * np.pi / 120.0 / 3600.0)


OILED = '[lubricant]\nviscosity = "27 mm2/s"'
REFUSED = [
    ("axis-fixed-fixed", '[lubricant]\nviscosity = "27"', "lubricant.viscosity", "mm2/s"),
    ("axis-fixed-fixed", f'{OILED}\nsupply = "spray"', "lubricant.supply", "grease"),
    ("axis-fixed-fixed", '[drive]\nmass = "-3 kg"', "drive.mass", "0 kg"),
    ("axis-fixed-fixed", '[drive]\nmotor_inertia = "3 kg"', "drive.motor_inertia", "kg cm2"),
    ("axis-fixed-fixed", '[drive]\ntime = "0.1 s"', "drive.time", "motion"),
    ("axis-fixed-fixed", "[drive]\nefficiency = 0.9", "drive.efficiency", "mass and time"),
    ("axis-fixed-fixed", '[motion]\nspeed = "0 rpm"', "motion.speed", "any angular speed but zero"),
    ("double-nut", OILED, "lubricant: got ", "bearing"),
    ("smith-axis", '[drive]\nmass = "100 kg"', "drive.mass", "nuts of equal lead"),
]


@pytest.mark.parametrize(("name", "tables", "key", "advice"), REFUSED)
def test_keys_of_an_axis_are_refused_with_what_to_do(name, tables, key, advice):
    text = catalogue.shipped_scene_text(name)
    for table in ('[motion]\nspeed = "1200 rpm"\n', '[lubricant]\nviscosity = "68 mm2/s"\n'):
        text = text.replace(table, "")
    with pytest.raises(InputError) as refused:
        scene_file.parse_scene(f"{text}\n{tables}\n", "mine.toml")
    assert key in str(refused.value)
    assert advice in str(refused.value)


def test_what_drives_an_axis_is_written_as_it_is_read():
    axis = replace(driven(mass=200.0, motor_inertia=2e-3, time=0.1), name="mine")
    assert scene_file.parse_scene(axis.to_toml(), "mine.toml").drive == axis.drive
    assert scene_file.parse_scene(axis.to_toml(), "mine.toml").lubricant == OIL
