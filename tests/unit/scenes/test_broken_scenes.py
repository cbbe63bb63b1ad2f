"""Deliberately broken scene files: each gives one line that says where, what and what to do."""

import re
from math import asin, degrees

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rollbench.comparison.errors import SceneError
from rollbench.comparison.scenes import scene_file
from rollbench.comparison.scenes.template import template

GOOD = template()
BEARING = {'lead = "20 mm"': 'lead = "0 mm"', "turns = 2": "turns = 1", "count = 32": "count = 16"}


def broken(changes: dict[str, str], text: str = GOOD) -> str:
    for old, new in changes.items():
        assert len(re.findall(rf"(?m)^{re.escape(old)}", text)) >= 1, f"the template has no line {old}"
        text = re.sub(rf"(?m)^{re.escape(old)}", lambda _, new=new: new, text, count=1)
    return text


def refusal(tmp_path, content: str | bytes) -> SceneError:
    path = tmp_path / "my.toml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(SceneError) as caught:
        scene_file.load(path)
    return caught.value


def check_line(error: SceneError, file: str) -> str:
    line = str(error)
    assert "\n" not in line
    assert line.isprintable()
    assert len(line) < 1000
    assert line.startswith(f"{file}: {error.key}: got ")
    assert all([error.key, error.value, error.allowed, error.advice])
    assert "; allowed: " in line
    assert "; advice: " in line
    assert "Traceback" not in line
    assert "pydantic" not in line
    return line


SUPPORT_TWICE = '[[supports]]\nat = "0.0 m"\n'
CASES = {  # name: (changes to the template, key, value as found, a part of range or advice)
    "unknown key": ({"pitch_radius =": "pitch_radus ="}, "track.pitch_radus", '"16.5 mm"', "did you mean pitch_radius"),
    "unknown table": ({"[screw]": "[shaft]"}, "shaft", "{ length", "screw"),
    "missing key": ({'radius = "2.778 mm"': ""}, "balls.radius", "nothing", 'add radius = "2.778 mm"'),
    "nut lands inside the pitch cylinder": (
        {"# [solid]": "[solid]", '# nut_inner_diameter = "34 mm"': 'nut_inner_diameter = "33 mm"'},
        "solid.nut_inner_diameter",
        '"33 mm"',
        "above 33 mm, below 39.508 mm",
    ),
    "hole through the groove": (
        {"# [solid]": "[solid]", '# hole_diameter = "6 mm"': 'hole_diameter = "27 mm"'},
        "solid.hole_diameter",
        '"27 mm"',
        "from 0 mm, below 26.492 mm",
    ),
    "held by a bore that is not there": (
        {"# [solid]": "[solid]", '# screw_held = "ends"': 'screw_held = "bore"'},
        "solid.screw_held",
        '"bore"',
        "give screw.bore",
    ),
    "missing unit": ({'length = "800 mm"': "length = 800"}, "screw.length", "800", "has no unit"),
    "missing unit in text": ({'length = "800 mm"': 'length = "800"'}, "screw.length", '"800"', "has no unit"),
    "wrong dimension": ({'length = "800 mm"': 'length = "8 kN"'}, "screw.length", '"8 kN"', "is a force"),
    "unknown unit": ({'length = "800 mm"': 'length = "800 mn"'}, "screw.length", '"800 mn"', "no such unit"),
    "unit on a number": (
        {"poissons_ratio = 0.28": 'poissons_ratio = "0.28"'},
        "material.poissons_ratio",
        '"0.28"',
        "plain",
    ),
    "not a number": ({'radius = "2.778 mm"': 'radius = "nan mm"'}, "balls.radius", '"nan mm"', "finite"),
    "infinite": ({"poissons_ratio = 0.28": "poissons_ratio = inf"}, "material.poissons_ratio", "inf", "finite"),
    "nan turns": ({"turns = 2": "turns = nan"}, "balls.turns", "nan", "finite"),
    "infinite force": (
        {'force = ["0 N", "0 N", "5 kN"]': 'force = ["0 N", "0 N", "inf N"]'},
        "loads[0].force[2]",
        '"inf N"',
        "finite",
    ),
    "two forces": ({'force = ["0 N", "0 N", "5 kN"]': 'force = ["0 N", "5 kN"]'}, "loads[0].force", '["0 N"', "list of 3"),
    "expression": ({'pitch_radius = "16.5 mm"': 'pitch_radius = "2*10 mm"'}, "track.pitch_radius", '"2*10 mm"', "unit"),
    "code": ({"title =": "title = 1 # "}, "title", "1", "text"),
    "zero radius": ({'radius = "2.778 mm"': 'radius = "0 mm"'}, "balls.radius", '"0 mm"', "0.01 mm to 1 m"),
    "negative length": ({'length = "54 mm"': 'length = "-54 mm"'}, "nut.length", '"-54 mm"', "0.01 mm to 100 m"),
    "zero modulus": (
        {'youngs_modulus = "210 GPa"': 'youngs_modulus = "0 GPa"'},
        "material.youngs_modulus",
        '"0 GPa"',
        "1 MPa",
    ),
    "no modulus": ({'youngs_modulus = "210 GPa"': ""}, "screw.material.youngs_modulus", "nothing", "[material]"),
    "incompressible": ({"poissons_ratio = 0.28": "poissons_ratio = 0.5"}, "material.poissons_ratio", "0.5", "below 0.5"),
    "contact angle 90": (
        {'contact_angle = "45 deg"': 'contact_angle = "90 deg"'},
        "track.contact_angle",
        '"90 deg"',
        "below 90 deg",
    ),
    "contact angle 0": (
        {'contact_angle = "45 deg"': 'contact_angle = "0 deg"'},
        "track.contact_angle",
        '"0 deg"',
        "above 0 deg",
    ),
    "negative lead": ({'lead = "20 mm"': 'lead = "-20 mm"'}, "track.lead", '"-20 mm"', "0 mm to 1 m"),
    "negative count": ({"count = 32": "count = -32"}, "balls.count", "-32", "whole number from 1"),
    "broken count": ({"count = 32": "count = 31.5"}, "balls.count", "31.5", "whole number from 1"),
    "true count": ({"count = 32": "count = true"}, "balls.count", "true", "whole number from 1"),
    "too many balls": ({"count = 32": "count = 100001"}, "balls.count", "100001", "to 100000"),
    "count not divisible": ({"[screw]": "starts = 3\n[screw]"}, "balls.count", "32", "multiple of the 3 starts"),
    "count and azimuths": ({"turns = 2": 'turns = 2\nazimuths = ["0 deg"]'}, "balls.azimuths", "both", "either"),
    "neither count nor azimuths": ({"count = 32": ""}, "balls.count", "nothing", "either"),
    "no turns": ({"turns = 2": ""}, "balls.turns", "nothing", "turns = 2"),
    "both grooves": (
        {'groove_radius = "3.254 mm"': 'groove_radius = "3.254 mm"\nconformity = 0.56'},
        "screw.groove_radius",
        "both",
        "one",
    ),
    "no groove": ({'groove_radius = "3.254 mm"': ""}, "screw.groove_radius", "neither", "one of"),
    "groove below ball": (
        {'groove_radius = "3.254 mm"': 'groove_radius = "2.7 mm"'},
        "screw.groove_radius",
        '"2.7 mm"',
        "jam",
    ),
    "groove equal to ball": (
        {'groove_radius = "3.254 mm"': 'groove_radius = "2.778 mm"'},
        "screw.groove_radius",
        '"2.778 mm"',
        "above 2.778 mm",
    ),
    "conformity below half": ({'groove_radius = "3.254 mm"': "conformity = 0.5"}, "screw.conformity", "0.5", "above 0.5"),
    "groove below oversized ball": (
        {"[[supports]]": '[errors.balls]\noversize = "0.5 mm"\n[[supports]]'},
        "screw.groove_radius",
        '"3.254 mm"',
        "3.278 mm",
    ),
    "groove below listed ball": (
        {"[[supports]]": '[errors.balls]\nlisted = { 3 = "0.5 mm" }\n[[supports]]'},
        "screw.groove_radius",
        '"3.254 mm"',
        "3.278 mm",
    ),
    "groove far too flat": (
        {'groove_radius = "3.254 mm"': 'groove_radius = "32.54 cm"'},
        "screw.groove_radius",
        '"32.54 cm"',
        "27.78 mm",
    ),
    "random balls jam": (
        {"[[supports]]": '[errors.balls]\nsigma = "0.1 mm"\n[[supports]]'},
        "errors.balls.sigma",
        '"0.1 mm"',
        "sigma too large",
    ),
    "profile jams": (
        {"[[supports]]": '[errors.SR]\nprofile = ["0.5 mm"]\n[[supports]]'},
        "errors.SR.profile",
        "an offset of 0.5 mm",
        "jam",
    ),
    "ball vanishes": (
        {"[[supports]]": '[errors.balls]\noversize = "-3 mm"\n[[supports]]'},
        "errors.balls.oversize",
        "ball 1",
        "positive",
    ),
    "overlapping balls": ({"count = 32": "count = 40"}, "balls.count", "balls 1 and 2", "5.556 mm"),
    "overlapping azimuths": (
        {"count = 32": 'azimuths = ["0 deg", "90 deg", "91 deg"]', "turns = 2": ""},
        "balls.azimuths",
        "balls 2 and 3",
        "5.556 mm",
    ),
    "coinciding azimuths": (
        {"count = 32": 'azimuths = ["0 deg", "90 deg", "0 deg"]', "turns = 2": ""},
        "balls.azimuths",
        "balls 1 and 3",
        "5.556 mm",
    ),
    "bearing circle too full": (
        {'lead = "20 mm"': 'lead = "0 mm"', "turns = 2": "turns = 1", "count = 32": "count = 19"},
        "balls.count",
        "balls 1 and 2",
        "fewer",
    ),
    "bearing does not close": (  # ends of a listed row that meet across 0 deg
        {'lead = "20 mm"': 'lead = "0 mm"', "turns = 2": "", "count = 32": 'azimuths = ["0 deg", "180 deg", "350 deg"]'},
        "balls.azimuths",
        "balls 1 and 3",
        "fewer",
    ),
    "two turns of a bearing": ({'lead = "20 mm"': 'lead = "0 mm"'}, "balls.turns", "2", "up to 1"),
    "bearing of two starts": ({**BEARING, "[screw]": "starts = 2\n[screw]"}, "track.starts", "2", "1 for zero lead"),
    "neighbouring turns": ({'lead = "20 mm"': 'lead = "5.5 mm"'}, "track.lead", '"5.5 mm"', "neighbouring turns"),
    "neighbouring starts": ({"[screw]": "starts = 4\n[screw]"}, "track.lead", '"20 mm"', "neighbouring turns"),
    "balls reach the axis": (
        {'pitch_radius = "16.5 mm"': 'pitch_radius = "2.5 mm"'},
        "track.pitch_radius",
        '"2.5 mm"',
        "2.778 mm",
    ),
    "screw below the groove": (
        {'outer_diameter = "32 mm"': 'outer_diameter = "27 mm"'},
        "screw.outer_diameter",
        '"27 mm"',
        "above 27.444 mm",
    ),
    "screw beyond the balls": (
        {'outer_diameter = "32 mm"': 'outer_diameter = "39 mm"'},
        "screw.outer_diameter",
        '"39 mm"',
        "below 38.556 mm",
    ),
    "bore too wide": (
        {'outer_diameter = "32 mm"': 'outer_diameter = "32 mm"\nbore = "27.5 mm"'},
        "screw.bore",
        '"27.5 mm"',
        "root",
    ),
    "groove takes the whole screw": (
        {
            'pitch_radius = "16.5 mm"': 'pitch_radius = "3.2 mm"',
            'lead = "20 mm"': 'lead = "6 mm"',
            'outer_diameter = "32 mm"': 'outer_diameter = "6.4 mm"',
        },
        "track.lead",
        '"6 mm"',
        "leaves no screw",
    ),
    "bore as wide as the reduced beam": (
        {
            'lead = "20 mm"': 'lead = "6 mm"',
            'outer_diameter = "32 mm"': 'outer_diameter = "32 mm"\nbore = "27.4 mm"',
            "[[supports]]": '[ingredients]\nsection = "groove squared"\n[[supports]]',
        },
        "screw.bore",
        '"27.4 mm"',
        "reduced by the groove",
    ),
    "too many listed balls": (
        {"count = 32": "azimuths = [" + '"0 deg", ' * 50_001 + "]", "turns = 2": "", "[screw]": "starts = 2\n[screw]"},
        "balls.azimuths",
        "100002 balls",
        "at most 100000",
    ),
    "100000 balls in two turns": ({"count = 32": "count = 100000"}, "balls.count", "balls 1 and 2", "5.556 mm"),
    "nut too thin": ({'outer_diameter = "48 mm"': 'outer_diameter = "38 mm"'}, "nut.outer_diameter", '"38 mm"', "enclose"),
    "nut off the screw": ({'position = "400 mm"': 'position = "790 mm"'}, "nut.position", '"790 mm"', "27 mm to 773 mm"),
    "nut longer than the screw": ({'length = "54 mm"': 'length = "1 m"'}, "nut.length", '"1 m"', "up to 800 mm"),
    "balls outside the nut": (
        {'length = "54 mm"': 'length = "30 mm"'},
        "balls.turns",
        "ball 1 at z = 380.625 mm",
        "fewer turns",
    ),
    "support off the screw": ({'at = "0 mm"': 'at = "801 mm"'}, "supports[0].at", '"801 mm"', "0 mm to 800 mm"),
    "load off the screw": ({'[[loads]]\nat = "0 mm"': '[[loads]]\nat = "1 m"'}, "loads[0].at", '"1 m"', "0 mm to 800 mm"),
    "fixed twice": (
        {"[[loads]]": SUPPORT_TWICE + 'fix = ["uz", "uy"]\n[[loads]]'},
        "supports[1].fix",
        '"uy" twice',
        "already held",
    ),
    "fixed and displaced": (
        {"[[loads]]": 'displace = { ux = "1 um" }\n[[loads]]'},
        "supports[0].displace.ux",
        '"ux" twice',
        "supports[0].fix",
    ),
    "same freedom listed twice": (
        {'fix = ["ux", "uy",': 'fix = ["ux", "ux",'},
        "supports[0].fix",
        '"ux" twice',
        "once per station",
    ),
    "unknown freedom": ({'fix = ["ux", "uy",': 'fix = ["uxx", "uy",'}, "supports[0].fix[0]", '"uxx"', 'did you mean "ux"'),
    "support without freedom": (
        {'fix = ["ux", "uy", "rx", "ry", "rz"]': ""},
        "supports[0].fix",
        "no freedom",
        "at least one",
    ),
    "ball number out of range": (
        {"[[supports]]": '[errors.balls]\nlisted = { 33 = "1 um" }\n[[supports]]'},
        "errors.balls.listed.33",
        "ball 33",
        "1 to 32",
    ),
    "ball number 0": (
        {"[[supports]]": '[errors.balls]\nlisted = { 0 = "1 um" }\n[[supports]]'},
        "errors.balls.listed.0",
        "ball 0",
        "1 to 32",
    ),
    "ball named in words": (
        {"[[supports]]": '[errors.balls]\nlisted = { first = "1 um" }\n[[supports]]'},
        "errors.balls.listed.first",
        "ball first",
        "1 to 32",
    ),
    "ball listed twice": (
        {"[[supports]]": '[errors.balls]\nlisted = { 7 = "1 um", 07 = "2 um" }\n[[supports]]'},
        "errors.balls.listed.07",
        "ball 07",
        "listed twice",
    ),
    "profile of degree 7": (
        {"[[supports]]": "[errors.NL]\nprofile = [" + '"1 um", ' * 8 + "]\n[[supports]]"},
        "errors.NL.profile",
        '["1 um"',
        "7 entries",
    ),
    "no members": ({"[material]": "members = 0\n[material]"}, "members", "0", "from 1 to 100000"),
    "unknown choice": ({"[screw]": 'hand = "rigth"\n[screw]'}, "track.hand", '"rigth"', 'did you mean "right"'),
    "table for a value": ({'length = "800 mm"': "length = { mm = 800 }"}, "screw.length", "{ mm = 800 }", "not text"),
    "value for a table": ({"[[supports]]\n": "[errors]\nSL = 3\n[[supports]]\n"}, "errors.SL", "3", "a table of profile"),
    "TOML syntax": ({'length = "800 mm"': 'length = "800 mm'}, "line 30, column 17", 'length = "800 mm', "TOML"),
    "TOML key twice": ({"turns = 2": "turns = 2\nturns = 3"}, "line 66, column 10", "turns = 3", "overwrite"),
    "TOML nested too deeply": ({"turns = 2": "turns = " + "[" * 5000}, "file", "text that is not TOML", "nested"),
    "TOML huge integer": ({"count = 32": "count = " + "9" * 5000}, "file", "text that is not TOML", "digits"),
    "empty file": (None, "title", "nothing", "add title"),
}


@pytest.mark.parametrize("name", CASES)
def test_broken_scene(name, tmp_path):
    changes, key, value, part = CASES[name]
    error = refusal(tmp_path, "" if changes is None else broken(changes))
    line = check_line(error, str(tmp_path / "my.toml"))
    assert error.key == key
    assert value in error.value
    assert part in line


def test_bearing_variant_is_sound():
    """The bearing that several cases start from loads, so it is their change that is refused."""
    assert scene_file.loads(broken(BEARING), "b.toml").ball_count == 16


def test_missing_table_is_named(tmp_path):
    error = refusal(tmp_path, re.sub(r"(?s)\[nut\].*?\[balls\]", "[balls]", GOOD))
    check_line(error, str(tmp_path / "my.toml"))
    assert (error.key, error.value) == ("nut", "nothing")
    assert "[nut]" in error.advice


def test_further_faults_are_counted(tmp_path):
    error = refusal(
        tmp_path, broken({'lead = "20 mm"': 'lead = "20"', "count = 32": "count = 0", "turns = 2": "turns = -1"})
    )
    assert error.more == 2
    assert str(error).endswith("(and 2 more faults)")


def test_further_bodies_that_cannot_be_built_are_counted(tmp_path):
    changes = {'outer_diameter = "48 mm"': 'outer_diameter = "38 mm"', "count = 32": "count = 40"}
    error = refusal(tmp_path, broken(changes))
    assert (error.key, error.more) == ("nut.outer_diameter", 1)
    assert str(error).endswith("(and 1 more fault)")


def test_binary_file(tmp_path):
    for content in (b"\x89PNG\r\n\x1a\n\x00\x00", b"title = \x00", bytes(range(128, 256))):
        error = refusal(tmp_path, content)
        assert (error.key, error.value) == ("file", "a binary file")
        check_line(error, str(tmp_path / "my.toml"))


@pytest.mark.parametrize(
    ("name", "value"),
    [("", "a directory"), ("none.toml", "no such file"), ("a\0b.toml", "null byte"), ("x" * 5000, "too long")],
)
def test_unreadable(tmp_path, name, value):
    with pytest.raises(SceneError) as caught:
        scene_file.load(f"{tmp_path}/{name}" if name else tmp_path)
    assert value in caught.value.value
    assert "\n" not in str(caught.value)
    assert str(caught.value).isprintable()
    assert caught.value.key == "file"


def test_huge_file_is_not_read_whole(tmp_path, monkeypatch):
    monkeypatch.setattr(scene_file, "MAX_BYTES", 1_000_000)
    assert "more than 1 MB" in refusal(tmp_path, b"#" * 1_000_001).value


def test_unequal_balls_that_are_not_nearest_neighbours_overlap(tmp_path):
    """Balls 2 and 3 overlap, yet each has a nearer neighbour, small enough not to touch it."""
    text = broken(
        {
            "count = 32": 'azimuths = ["-19.4 deg", "0 deg", "20 deg", "39.4 deg"]',
            "turns = 2": "",
            "[[supports]]": '[errors.balls.listed]\n1 = "-0.3 mm"\n3 = "0.3 mm"\n4 = "-0.4 mm"\n[[supports]]',
        }
    )
    assert "balls 2 and 3" in refusal(tmp_path, text).value
    scene_file.loads(text.replace('3 = "0.3 mm"', '3 = "0.2 mm"'), "a.toml")


def test_full_complement_of_touching_balls_is_allowed():
    step = degrees(2 * asin(2.778 / 16.5))
    azimuths = ", ".join(f'"{i * step!r} deg"' for i in range(18))
    text = broken({'lead = "20 mm"': 'lead = "0 mm"', "turns = 2": "", "count = 32": f"azimuths = [{azimuths}]"})
    assert scene_file.loads(text, "full.toml").ball_count == 18


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_any_mutilation_is_one_line_or_a_scene(data):
    """Random cuts, swaps and insertions of text never escape as anything but a SceneError of one line."""
    text = GOOD
    for _ in range(data.draw(st.integers(1, 3))):
        i = data.draw(st.integers(0, len(text)))
        j = min(len(text), i + data.draw(st.integers(0, 12)))
        piece = data.draw(
            st.sampled_from(['"', "[", "]", "=", "\n", "nan", "-", "1e400", "{", "}", "0", "", "é", "\x7f", "5 kN"])
        )
        text = text[:i] + piece + text[j:]
    try:
        scene_file.loads(text, "m.toml")
    except SceneError as error:
        check_line(error, "m.toml")
