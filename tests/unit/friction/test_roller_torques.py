"""Friction of rows of tapered rollers as `friction` prints it: a band, in N mm and in-lbf, beside Timken's formula."""

import pytest

from rollbench.compare.scenes.catalogue import shipped_scene_text

pytestmark = pytest.mark.slow

INCH_POUND = 25.4 * 4.4482216152605


def test_friction_prints_the_band_of_every_row_and_timken_s_torque(command, tmp_path) -> None:
    file, angle = tmp_path / "g1.toml", 'roller_angle = "4 deg"'
    given = f'{angle}\ntorque_factor = 51\nend_radius = "58 mm"'
    file.write_text(shipped_scene_text("smith-axis-taper").replace(angle, given))
    data, said = command.answer("friction", file), command.said("friction", file)
    rows = data["roller_torques"]
    assert [x["name"] for x in rows] == ["left 1", "left 2", "right 1", "right 2"]
    ends = [[x[key] / INCH_POUND for key in ("low_Nmm", "high_Nmm")] for x in rows]
    assert [x["band_Nmm"] for x in rows] == [[x["low_Nmm"], x["high_Nmm"]] for x in rows]
    assert (min(x[0] for x in ends), max(x[1] for x in ends)) == pytest.approx((3.94, 16.4), rel=5e-3)
    first = next(line for line in said.splitlines() if "in-lbf" not in line and "4.50 to 9.33" in line)
    timken = rows[0]["timken_Nmm"]
    assert [float(x) for x in first.split()[-2:]] == pytest.approx([timken, timken / INCH_POUND], rel=5e-4)
    row = next(line for line in command.said("solve", file).splitlines() if line.startswith("1 left 1 "))
    low, high = (f"{rows[0][key]:.3g}" for key in ("low_Nmm", "high_Nmm"))
    assert f"{float(low):.0f} to {float(high):.0f} " in row
    assert f" {rows[0]['timken_Nmm']:.0f} " in row
