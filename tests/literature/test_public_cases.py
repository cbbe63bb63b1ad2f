"""Bearings and screws of public material through the command line, against an independent solver: rigid rings or a rigid
screw on Hertz springs, their constants by complete elliptic integrals; `lin` with a stiff shaft must give its numbers."""

from pathlib import Path

import pytest

SCENES = Path(__file__).parents[1] / "scenes" / "public"
#: Scene, largest contact load [N], and displacement [um] of the shaft at a station [mm], along an axis.
CASES = [
    ("b1-nptel-clearance", 288.675, 100.0, {"ux_um": 19.1610, "uz_um": -47.9349}),
    ("b3-218-eccentric-20", 3555.0, 100.0, {}),
    ("b4-qj309-moment", 2578.6673, 12.5, {"uz_um": 24.9049}),
    ("b5-6201-stiffness", 309.81, 100.0, {"ux_um": 10.6002}),
    ("h3-hybrid-7208", 503.82, 100.0, {"uz_um": 26.4143}),
    ("s4-tilted-nut", 499.0923, 100.0, {"uz_um": 3.085}),
]
#: Rows whose ellipses cross the bottom of a groove of one arc, and one between two arcs that they clear.
REACH = [("b1-nptel-clearance", "land", 55.80), ("b8b-7010c-heavy", "land", 55.5), ("b4-qj309-moment", "land", 56.27)]


@pytest.mark.parametrize(("name", "load", "station", "moved"), CASES)
def test_loads_and_displacements_of_an_independent_solver(command, name: str, load: float, station: float, moved) -> None:
    code, found = command.json("solve", SCENES / f"{name}.toml", "--model", "lin", "--json")
    assert (code, found["status"]) == (0, "converged")
    digit = 0.5 * 10.0 ** -len(str(load).partition(".")[2])
    assert max(x for ball in found["balls"] for x in ball["load_N"].values()) == pytest.approx(load, rel=1e-5, abs=digit)
    place = min(found["centreline"], key=lambda row: abs(row["z_mm"] - station))
    for key, value in moved.items():
        assert place[key] == pytest.approx(value, rel=1e-5, abs=1e-3)


def test_each_nut_of_a_preloaded_pair_takes_its_part_of_the_load(command) -> None:
    found = command.json("solve", SCENES / "s2-double-nut-3000.toml", "--model", "lin", "--json")[1]
    assert [abs(s["force_on_shaft_N"][2]) for s in found["sets"]] == pytest.approx([3700.0, 700.0], abs=0.5)


@pytest.mark.parametrize("model", ["lin", "refined"])
@pytest.mark.parametrize(("name", "edge", "limit"), REACH)
def test_a_groove_of_one_arc_reaches_from_land_to_land(command, name: str, edge: str, limit: float, model: str) -> None:
    code, found = command.json("solve", SCENES / f"{name}.toml", "--model", model, "--json")
    reach = found["summary"]["truncation"]
    assert (code, reach["contacts_cut"], reach["edge"]) == (0, 0, edge)
    assert abs(reach["edge_angle_deg"]) == pytest.approx(limit, abs=0.05)
    assert not any("beyond" in words and "arc" in words for words in found["warnings"])


def test_a_groove_of_two_arcs_keeps_its_apex(command, tmp_path: Path) -> None:
    """The four-point bearing with thrust all but taken away: its balls lie near the apex."""
    text = (SCENES / "b4-qj309-moment.toml").read_text(encoding="utf-8")
    low = text.replace('"35 deg"', '"10 deg"').replace('"4000 N"', '"400 N"')
    (tmp_path / "low.toml").write_text(low, encoding="utf-8")
    found = command.json("solve", tmp_path / "low.toml", "--model", "lin", "--json")[1]
    assert found["summary"]["truncation"]["edge"] == "apex"
    assert found["summary"]["truncation"]["contacts_cut"] > 0


def test_clearance_as_data_sheets_give_it_is_the_contact_angle_at_rest(command, tmp_path: Path) -> None:
    """13 um radial and 95.87 um axial are one bearing: cos(15.444 deg) = 1 - 13 um/(2 A), A = 2 x 3.09 mm - 6 mm."""
    text = (SCENES / "b1-nptel-clearance.toml").read_text(encoding="utf-8").replace('thrust = "deep groove"\n', "")
    for given in ('radial = "13 um"', 'axial = "95.8697 um"'):
        file = tmp_path / "clear.toml"
        file.write_text(text.replace('contact_angle = "15.44449456 deg"', f"clearance = {{ {given} }}"), encoding="utf-8")
        found = command.json("solve", file, "--model", "lin", "--json")[1]
        (row,) = found["sets"]
        assert row["summary"]["clearance"] == pytest.approx(
            {"rest_angle_deg": 15.444495, "radial_um": 13.0, "axial_um": 95.8697}, rel=1e-5
        )
        place = min(found["centreline"], key=lambda x: abs(x["z_mm"] - 100.0))
        assert (place["ux_um"], place["uz_um"]) == pytest.approx((19.1610, -47.9349), rel=1e-5)
        assert not any("axial play of" in words for words in found["warnings"])


def test_a_held_uz_that_keeps_a_ring_at_one_end_of_its_play_is_told(command, tmp_path: Path) -> None:
    """In the middle of its play the ring moves across as a free one does; at the end by a third less."""
    text = (SCENES / "b1-nptel-clearance.toml").read_text(encoding="utf-8")
    moved, told = {}, {}
    for name, place in (("end", "0 um"), ("middle", "-47.9349 um")):
        file = tmp_path / f"{name}.toml"
        held = f'"rz"]\ndisplace = {{ uz = "{place}" }}'
        file.write_text(text.replace('"rz"]', held, 1), encoding="utf-8")
        found = command.json("solve", file, "--model", "lin", "--json")[1]
        moved[name] = min(found["centreline"], key=lambda x: abs(x["z_mm"] - 100.0))["ux_um"]
        told[name] = any("end of the bearing's axial play" in words for words in found["warnings"])
    assert told == {"end": True, "middle": False}
    assert moved["middle"] == pytest.approx(19.1610, rel=1e-4)
    assert moved["end"] < 0.7 * moved["middle"]
