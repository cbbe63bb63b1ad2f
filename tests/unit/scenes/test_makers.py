"""Scenes that start from a maker's catalogue name: what is printed is taken over, what is not is assumed and said so."""

import math

import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.scenes import makers, scene_file
from rollbench.compare.scenes.catalogue_part import scene_text_of_bearings, scene_text_of_catalogue_part, scene_text_of_nut
from rollbench.meshes.axis import Assembly

pytestmark = pytest.mark.slow


def scene(name: str, kind: str = ""):
    return scene_file.parse_scene(scene_text_of_catalogue_part(name, kind), "my.toml")


def test_every_nut_of_the_tables_gives_a_scene_with_what_is_printed() -> None:
    parts = makers.nuts_in_catalogues()
    assert (len(parts), len({part.label for part in parts})) == (582, 582)
    for part in parts:
        found = scene_file.parse_scene(scene_text_of_nut(part), part.label)
        assert isinstance(found, Assembly) == (part.type != "single nut")
        one = found.sets[0].parts if isinstance(found, Assembly) else found
        printed = makers.printed_values(part)
        assert 1e3 * one.track.lead == pytest.approx(printed["lead_mm"])
        assert 1e3 * one.screw.outer_diameter == pytest.approx(printed["diameter_mm"])
        assert printed["ball_mm"] is None or 2e3 * one.balls.radius == pytest.approx(printed["ball_mm"])
        wrong = (printed["misprint"] or "").split(", ")
        for key, value in (("C", one.rating.dynamic), ("C0", one.rating.static)):
            assert value is None if key in wrong else value == pytest.approx(1e3 * printed[f"{key}_kN"], rel=1e-4)


def test_a_double_nut_is_asked_for_or_is_what_the_maker_prints() -> None:
    assert not isinstance(scene("40x10Rx6-4"), Assembly)
    rexroth = "Rexroth 40 x 10R x 6-4"
    for name, kind in ((rexroth, "double-nut"), (f"{rexroth} double nut", ""), ("BIF 2005-5", "")):
        found = scene(name, kind)
        assert [one.thrust for one in found.sets] == ["-z", "+z"]
        assert len({one.parts.rating.dynamic for one in found.sets} - {None}) == 1
    assert scene("Rexroth 40 x 10L x 6-4").track.hand == "left"


def test_a_misprint_is_not_taken_over_silently() -> None:
    found = scene("SFE5050-6")
    assert (found.rating.dynamic, round(found.rating.static)) == (None, round(27600 * 9.80665, -1))
    assert '# dynamic = "71.196 kN"' in scene_text_of_catalogue_part("SFE5050-6")
    assert scene("R80-10T4-FSI").rating.static is None, "21,118 N, below C"


def test_names_that_are_not_one_row() -> None:
    for name, near in (
        ("R32-10K5-FSC", [f'"HIWIN R32-10K5-FSC ball {ball}"' for ball in ("3.969", "4.763", "6.35")]),
        ("HIWIN R40-10T4-FSX", ["HIWIN R40-10T4-FSI"]),
        ("HIWIN R40-10T4", ['"HIWIN R40-10T4-FSI"', '"HIWIN R40-10T4-RSI"']),
        ("7010C", [f'"NSK 7010C {name}"' for name in ("EL", "L", "M", "H")]),
        ("nothing of this kind", ["list --makers"]),
    ):
        with pytest.raises(InputError) as caught:
            scene_text_of_catalogue_part(name)
        assert (caught.value.key, [text for text in near if text not in caught.value.advice]) == ("like", [])
    assert scene("r32-10k5-fsc BALL 4.763").balls.radius == pytest.approx(4.763e-3 / 2.0)


def test_bearings_of_all_tables_give_scenes_with_the_printed_preload() -> None:
    parts = makers.bearings_in_catalogues()
    assert (len(parts), len({part.label for part in parts})) == (1868, 1868)
    for part in parts[::23]:
        found = scene_file.parse_scene(scene_text_of_bearings(part), part.label)
        printed = makers.printed_values(part)
        one = found.sets[0].parts
        assert math.degrees(one.track.contact_angle) == pytest.approx(printed["angle_deg"])
        assert 1e3 * found.screw.outer_diameter == pytest.approx(printed["bore_mm"])
        assert printed["balls"] in (None, one.ball_count)
        assert one.rating.dynamic == (printed["C_kN"] and pytest.approx(1e3 * printed["C_kN"]))


def test_from_the_command_line(tmp_path, command) -> None:
    file = tmp_path / "my.toml"
    assert command("new", file, "--like", "NSK 7010C M").code == 0
    text = file.read_text(encoding="utf-8")
    file.write_text(text.replace('"390 N"]', '"1 N"]'), encoding="utf-8")
    forces = [abs(one["force_on_shaft_N"][2]) for one in command.answer("solve", file)["sets"]]
    assert forces == pytest.approx([390.0, 390.0], rel=5e-3)
    assert "support-bearings" in command.refused("new", tmp_path / "b.toml", "--like", "NSK 7010C M", "--kind", "bearing")
    assert "R40-10T4-FSI" in command.refused("new", tmp_path / "b.toml", "--like", "HIWIN R40-10T4")
    assert not (tmp_path / "b.toml").exists()
    listed = command.answer("list", "--makers", "HIWIN R40-10T4")
    assert [row["name"] for row in listed["nuts"]] == ["HIWIN R40-10T4-FSI", "HIWIN R40-10T4-RSI"]
    assert listed["nuts"][0]["rigidity_N_per_um"] == pytest.approx(510.0)
    assert "1868 bearings" in command.said("list", "--makers", "")
    assert "--makers" in command.refused("list", "--makers", "R99-99")
