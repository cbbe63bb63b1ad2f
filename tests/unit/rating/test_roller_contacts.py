"""Line contacts of tapered rollers: pressure, static safety, warnings and what `solve` says of a row."""

from dataclasses import replace

import numpy as np
import pytest
from tests.axes import ROLLERS, assembly, solved
from tests.helpers import ALL_BUT_AXIAL
from tests.shipped_texts import changed

from rollbench.lowfi.hertz import hertz_constants
from rollbench.lowfi.rating.contacts import roller_contact_of_highest_pressure
from rollbench.lowfi.rollers import half_widths_and_pressures_of_slices
from rollbench.lowfi.statics.axis.system import tapered_bearing_of_row
from rollbench.meshes.axis import RollingSet, Segment
from rollbench.meshes.parts import Load, Support

INCH, POUND = 25.4e-3, 4.4482216152605
#: Of the bearing in Smith's figure 3-6, as its scene has it: E* and relative radius at the cone in mid-length.
MODULUS = 30e6 * POUND / INCH**2 / (2.0 * (1.0 - 0.3**2))
REACH = 0.5 * 0.33 * INCH / np.sin(np.radians(4.0))
AT_CONE = 1.0 / (1.0 / (REACH * np.tan(np.radians(4.0))) + 1.0 / (REACH * np.tan(np.radians(22.8))))


def by_hand(load: float) -> float:
    """Pressure sqrt(q E*/(pi R)) at a roller's middle [MPa]."""
    return 1e-6 * float(np.sqrt(load / (0.49 * INCH) * MODULUS / (np.pi * AT_CONE)))


def row(thrust: float, **turned: float):
    """A row of rollers on a thick shaft under a thrust [N]; turned: rotations of the shaft [rad]."""
    held = Support(0.15, tuple((name, turned.get(name, 0.0)) for name, _ in ALL_BUT_AXIAL))
    one = RollingSet("row", "tapered roller bearing", ROLLERS, 0.15, thrust="+z")
    loads = (Load(0.15, (0.0, 0.0, thrust)),)
    return assembly(one, segments=(Segment(0.0, 0.3, 30.0),), supports=(held,), loads=loads)


def limit(pressure: float) -> float:
    """Thrust [N] on the row at which the small ends of its rollers have a pressure [Pa], by closed form."""
    bearing = tapered_bearing_of_row(ROLLERS)
    small = bearing.apex_distance - 0.5 * ROLLERS.length * (1.0 - 1.0 / ROLLERS.slices)
    curvature = 1.0 / (small * np.tan(bearing.roller_angle)) + 1.0 / (small * np.tan(bearing.cone_angle))
    modulus = bearing.young / (2.0 * (1.0 - bearing.poisson**2))
    load = np.pi * pressure**2 * ROLLERS.length / (modulus * curvature)
    return float(load * ROLLERS.count * np.sin(ROLLERS.cup_angle))


def test_pressure_is_that_of_two_cylinders_and_of_the_long_ellipse():
    """A strip is the middle of an ellipse that goes on for ever: 3 F/(2 pi a b) with F/(2 a) = 2 q/3 has its pressure."""
    bearing, q = tapered_bearing_of_row(ROLLERS), np.full((1, 1), 3e5)
    half, pressure = half_widths_and_pressures_of_slices(bearing, q)
    radii = bearing.curvature_radii()
    modulus = bearing.young / (2.0 * (1.0 - bearing.poisson**2))
    for race, sign in enumerate((1.0, -1.0)):
        curvature = 1.0 / radii[0] + sign / radii[1 + race]
        assert pressure[0, 0, race] == pytest.approx(np.sqrt(q[0, 0] * modulus * curvature / np.pi), rel=1e-12)
        assert pressure[0, 0, race] * np.pi * half[0, 0, race] / 2.0 == pytest.approx(q[0, 0], rel=1e-12)
        h = hertz_constants(np.array([1e-8 * curvature]), np.array([curvature]), modulus)
        force = (q[0, 0] * 4.0 / 3.0 * float(h.C_a[0])) ** 1.5  # F = 4/3 q a, a = C_a F^(1/3)
        assert float(h.pressure(np.array([force]))[0]) == pytest.approx(pressure[0, 0, race], rel=1e-4)
        assert float(h.C_b[0]) * np.cbrt(force) == pytest.approx(half[0, 0, race], rel=1e-4)


def test_even_load_presses_hardest_at_the_small_end_of_the_cone():
    q = np.full((3, 15), 2e5)
    q[1] *= 1.5
    worst = roller_contact_of_highest_pressure(replace(ROLLERS, slices=15), q)
    assert (worst.element, worst.side) == (2, "inner")
    assert worst.force == pytest.approx(3e5 * ROLLERS.length)
    assert worst.position_along_roller == pytest.approx(-0.5 * ROLLERS.length * 14.0 / 15.0)
    reach = tapered_bearing_of_row(ROLLERS).apex_distance
    shorter = reach / (reach + worst.position_along_roller)
    assert worst.pressure / worst.uniform_load_pressure == pytest.approx(np.sqrt(shorter), rel=1e-12)
    assert worst.other_race_pressure < worst.pressure
    assert worst.safety == pytest.approx((4e9 / worst.pressure) ** 2)
    assert roller_contact_of_highest_pressure(ROLLERS, np.zeros((3, 7))) is None


@pytest.mark.parametrize(("share", "told"), [(0.95, False), (1.05, True)])
def test_pressure_that_leaves_a_dent_is_told_from_4000_MPa_on(share, told):
    found = solved(row(share * limit(4e9)))
    assert found.converged
    assert [w.kind for w in found.warnings] == (["pressure"] if told else [])


def test_a_tilt_and_a_rotation_of_the_shaft_are_told_without_balls():
    assert "tilt" in {w.kind for w in solved(row(3000.0, ry=8e-3)).warnings}
    assert [w.kind for w in solved(row(3000.0, rz=0.06)).warnings] == ["rotation"]


def test_preloaded_rows_answer_load_pressure_safety_and_preload(command):
    data = command.answer("solve", "smith-axis-taper", "--strict")
    sin = np.sin(np.radians(30.8))
    for number, one in enumerate(data["sets"], 1):
        loads = np.array([roller["load_N"] for roller in data["rollers"] if roller["set"] == number])
        found, preload = one["summary"], one["summary"]["preload"]
        assert found["loads"]["max_N"] == loads.max() == one["largest_load_N"]
        assert (found["loads"]["loaded_contacts"], found["loads"]["rollers_without_load"]) == (16, 0)
        assert sin * loads.sum() == pytest.approx(abs(one["force_on_shaft_N"][2]), rel=1e-9)
        assert 16 * sin * preload["mean_N"] == pytest.approx(abs(preload["axial_N"]), rel=1e-9)
        assert found["worst_contact"]["middle_pressure_MPa"] == pytest.approx(by_hand(loads.max()), rel=1e-9)
        assert found["static_safety"]["factor"] == pytest.approx((4000.0 / found["worst_contact"]["pressure_MPa"]) ** 2)
    whole = data["summary"]
    assert whole["worst_set"] == 3
    thrust = abs(data["sets"][2]["force_on_shaft_N"][2])
    standard = (whole["life"]["rating_as_computed_N"] / (0.4 / np.tan(np.radians(30.8)) * thrust)) ** (10.0 / 3.0)
    assert whole["life"]["L10_million_revolutions"] == pytest.approx(standard, rel=1e-9)
    assert whole["worst_contact"]["middle_pressure_MPa"] == pytest.approx(1007.5, abs=0.1)
    assert whole["axial"]["force_N"] == pytest.approx(-1000.0 * POUND)


def test_preload_without_the_stretch_is_what_the_rows_are_closed_to(command, tmp_path):
    """Either row is closed to its deflection under 1500 lbf; the 20 mm of shaft between the two give way and take some."""
    text = changed("smith-axis-taper", ('displace = { uz = "0.0015 in" }', 'displace = { uz = "0 in" }'))
    (tmp_path / "closed.toml").write_text(text, encoding="utf-8")
    for one in command.answer("solve", tmp_path / "closed.toml")["sets"]:
        assert 0.93 < abs(one["summary"]["preload"]["axial_N"]) / (1500.0 * POUND) < 1.0


def test_27700_N_on_one_roller_is_no_success_and_all_rollers_are_listed(command, tmp_path):
    """Smith's axis with 3000 lbf across its middle."""
    across = ('force = ["0 lbf", "0 lbf", "-1000 lbf"]', 'force = ["3000 lbf", "0 lbf", "0 lbf"]')
    (tmp_path / "lateral.toml").write_text(changed("smith-axis-taper", across), encoding="utf-8")
    code, data = command.json("solve", tmp_path / "lateral.toml", "--strict", "--json")
    assert (code, data["status"]) == (1, "converged")
    found = data["summary"]
    assert found["loads"]["max_N"] == pytest.approx(27711.5, rel=1e-5)
    assert found["worst_contact"]["middle_pressure_MPa"] == pytest.approx(by_hand(27711.5), rel=1e-5)
    assert by_hand(27711.5) == pytest.approx(4729.0, abs=0.5)
    assert found["worst_contact"]["pressure_MPa"] > 4729.0  # the shaft tilts the rollers
    assert found["static_safety"]["factor"] < (4000.0 / 4729.0) ** 2 < 1.0
    assert "static safety" in data["warning"]
    assert found["nut"]["secant_N_per_um"] is None  # no axial load
    worst = found["worst_contact"]
    listed = [r for r in data["rollers"] if r["set"] == data["summary"]["worst_set"]]
    assert max(r["pressure_MPa"]["inner"] for r in listed) == worst["pressure_MPa"]
    assert max(r["pressure_MPa"]["outer"] for r in listed) == worst["other_race_pressure_MPa"]
    assert all(r["pressure_MPa"] == {"inner": 0.0, "outer": 0.0} for r in listed if r["load_N"] == 0.0)
    assert "pressure MPa inner" in command.said("solve", tmp_path / "lateral.toml", "--balls")


def test_load_cases_of_rollers_have_a_worst_pressure(command, tmp_path):
    path, text = tmp_path / "thrust.toml", changed("rollers", ('warming = "10 K"', 'warming = "0 K"'))
    path.write_text(f'{text}\n[[cases]]\nname = "one"\nshare = 1\n', encoding="utf-8")
    together = command.answer("solve", path)["summary"]
    assert together["largest_pressure_MPa"] > 0.0
    assert together["least_static_safety"] == pytest.approx((4000.0 / together["largest_pressure_MPa"]) ** 2)


@pytest.mark.parametrize("angle", ["4e-12 deg", "0.4 deg"])
def test_a_roller_angle_with_a_pitch_circle_that_the_rollers_cannot_fill_is_refused(command, tmp_path, angle):
    """The pitch circle D sin(alpha - gamma)/tan(gamma) of 16 rollers grows without bound as gamma goes to zero."""
    file = tmp_path / "flat.toml"
    file.write_text(changed("smith-axis-taper", ('roller_angle = "4 deg"', f'roller_angle = "{angle}"')))
    said = command.refused("solve", file)
    assert "roller_angle" in said
    assert "pitch circle of at most 426.8918 mm" in said
