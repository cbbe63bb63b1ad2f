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
REACH = [("b1-nptel-clearance", 55.80), ("b8b-7010c-heavy", 55.5), ("b4-qj309-moment", 56.27)]


def text(name: str) -> str:
    return (SCENES / f"{name}.toml").read_text(encoding="utf-8")


@pytest.fixture
def solved(command, tmp_path: Path):
    """Answer of a scene file by its text."""

    def solve(scene: str, model: str = "lin") -> dict:
        path = tmp_path / "scene.toml"
        path.write_text(scene, encoding="utf-8")
        found = command.answer("solve", path, "--model", model)
        assert found["status"] == "converged"
        return found

    return solve


def displacement(found: dict, station: float) -> dict:
    """Displacements of the shaft at a station [mm]."""
    return min(found["centreline"], key=lambda row: abs(row["z_mm"] - station))


@pytest.mark.parametrize(("name", "load", "station", "moved"), CASES)
def test_loads_and_displacements_of_an_independent_solver(solved, name: str, load: float, station: float, moved) -> None:
    found = solved(text(name))
    digit = 0.5 * 10.0 ** -len(str(load).partition(".")[2])
    assert max(x for ball in found["balls"] for x in ball["load_N"].values()) == pytest.approx(load, rel=1e-5, abs=digit)
    for key, value in moved.items():
        assert displacement(found, station)[key] == pytest.approx(value, rel=1e-5, abs=1e-3)


def test_each_nut_of_a_preloaded_pair_takes_its_part_of_the_load(solved) -> None:
    found = solved(text("s2-double-nut-3000"))
    assert [abs(s["force_on_shaft_N"][2]) for s in found["sets"]] == pytest.approx([3700.0, 700.0], abs=0.5)


@pytest.mark.parametrize("model", ["lin", "refined"])
@pytest.mark.parametrize(("name", "limit"), REACH)
def test_a_groove_of_one_arc_reaches_from_land_to_land(solved, name: str, limit: float, model: str) -> None:
    found = solved(text(name), model)
    reach = found["summary"]["truncation"]
    assert (reach["contacts_cut"], reach["edge"]) == (0, "land")
    assert abs(reach["edge_angle_deg"]) == pytest.approx(limit, abs=0.05)
    assert not any("beyond" in words and "arc" in words for words in found["warnings"])


def test_a_groove_of_two_arcs_keeps_its_apex(solved) -> None:
    """The four-point bearing with thrust all but taken away: its balls lie near the apex."""
    found = solved(text("b4-qj309-moment").replace('"35 deg"', '"10 deg"').replace('"4000 N"', '"400 N"'))
    assert found["summary"]["truncation"]["edge"] == "apex"
    assert found["summary"]["truncation"]["contacts_cut"] > 0


@pytest.mark.parametrize("given", ['radial = "13 um"', 'axial = "95.8697 um"'])
def test_clearance_as_data_sheets_give_it_is_the_contact_angle_at_rest(solved, given: str) -> None:
    """13 um radial and 95.87 um axial are one bearing: cos(15.444 deg) = 1 - 13 um/(2 A), A = 2 x 3.09 mm - 6 mm."""
    bearing = text("b1-nptel-clearance").replace('thrust = "deep groove"\n', "")
    found = solved(bearing.replace('contact_angle = "15.44449456 deg"', f"clearance = {{ {given} }}"))
    (row,) = found["sets"]
    clearance = {"rest_angle_deg": 15.444495, "radial_um": 13.0, "axial_um": 95.8697}
    assert row["summary"]["clearance"] == pytest.approx(clearance, rel=1e-5)
    place = displacement(found, 100.0)
    assert (place["ux_um"], place["uz_um"]) == pytest.approx((19.1610, -47.9349), rel=1e-5)
    assert not any("axial play of" in words for words in found["warnings"])


def test_a_held_uz_that_keeps_a_ring_at_one_end_of_its_play_is_told(solved) -> None:
    """In the middle of its play the ring moves across as a free one does; at the end by a third less."""
    moved, told = {}, {}
    for name, place in (("end", "0 um"), ("middle", "-47.9349 um")):
        held = f'"rz"]\ndisplace = {{ uz = "{place}" }}'
        found = solved(text("b1-nptel-clearance").replace('"rz"]', held, 1))
        moved[name] = displacement(found, 100.0)["ux_um"]
        told[name] = any("end of the bearing's axial play" in words for words in found["warnings"])
    assert told == {"end": True, "middle": False}
    assert moved["middle"] == pytest.approx(19.1610, rel=1e-4)
    assert moved["end"] < 0.7 * moved["middle"]
