"""Deliberately broken friction scenes: each gives one line that says where, what and what to do; and their schema."""

import json

import pytest
from tests.shipped_texts import changed

from rollbench.comparison.errors import InputError, SceneError
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.scenes.keys import tidy_schema
from rollbench.comparison.wings.friction.kinds.table import KINDS

COULOMB = 'law = "coulomb"'
CASES = {  # name: (scene, changes, key, value as found, a part of range or advice)
    "no kind": ("lin-rotary-1", [('kind = "bearing ball"', "")], "kind", "nothing", "[load] belongs"),
    "unknown kind": (
        "lin-rotary-1",
        [('kind = "bearing ball"', 'kind = "baring ball"')],
        "kind",
        '"baring ball"',
        "did you mean",
    ),
    "kind of another type": ("lin-rotary-1", [('"bearing ball"', "3")], "kind", "3", '"bearing ball"'),
    "unknown key": ("lin-rotary-1", [("conformity", "conformty")], "screw.conformty", "0.54", "mean conformity"),
    "unknown table": ("lin-rotary-1", [("[motion]", "[moton]")], "moton", "{ speed", "did you mean motion"),
    "key of another kind": (
        "lin-pair-a",
        [("[track]", '[track]\npitch_radius = "3 mm"')],
        "track.pitch_radius",
        '"3 mm"',
        "unknown key",
    ),
    "missing key": ("lin-rotary-1", [('pitch_radius = "35 mm"', "")], "track.pitch_radius", "nothing", "16.5 mm"),
    "missing table": ("lin-pair-a", [('[motion]\ncarriage = "10 mm/s"', "")], "motion", "nothing", "[motion] table"),
    "no unit": ("lin-rotary-1", [('"6.25 mm"', "6.25")], "balls.radius", "6.25", "0.01 mm to 1 m"),
    "speed without unit": ("lin-rotary-1", [('"10 rps"', '"10"')], "motion.speed", '"10"', "rad/s, deg/s, rps"),
    "speed as a number": ("lin-rotary-1", [('"10 rps"', "10")], "motion.speed", "10", "an angular speed"),
    "speed of another kind": ("lin-pair-a", [('"10 mm/s"', '"10 rps"')], "motion.carriage", '"10 rps"', "a speed"),
    "speed too large": ("lin-pair-a", [('"10 mm/s"', '"1e5 m/s"')], "motion.carriage", '"1e5 m/s"', "-1000 m/s to"),
    "speed not finite": ("lin-pair-a", [('"10 mm/s"', '"nan mm/s"')], "motion.carriage", '"nan mm/s"', "a number"),
    "no groove": ("lin-rotary-1", [("conformity = 0.54", "")], "screw.groove_radius", "neither", "one of"),
    "two grooves": (
        "lin-rotary-1",
        [("conformity = 0.54", 'conformity = 0.54\ngroove_radius = "7 mm"')],
        "screw.groove_radius",
        "both",
        "one of",
    ),
    "groove below the ball": (
        "lin-rotary-1",
        [("conformity = 0.54", 'groove_radius = "6 mm"')],
        "screw.groove_radius",
        '"6 mm"',
        "above 6.25 mm",
    ),
    "conformity": ("lin-pair-a", [("0.56", "0.5")], "grooves.conformity", "0.5", "above 0.5"),
    "small ring": ("lin-rotary-1", [('"35 mm"', '"6 mm"')], "track.pitch_radius", '"6 mm"', "above 6.75 mm"),
    "contact angle": ("lin-rotary-1", [('"45 deg"', '"90 deg"')], "track.contact_angle", '"90 deg"', "below 90 deg"),
    "clearance": (
        "lin-rotary-1",
        [("[load]", '[errors.balls]\noversize = "0.6 mm"\n[load]')],
        "errors.balls.oversize",
        '"0.6 mm"',
        "between -0.5 mm and 0.5 mm",
    ),
    "displacement": ("lin-rotary-1", [('"0 um"', '"0.6 mm"')], "load.radial_displacement", '"0.6 mm"', "-0.5 mm"),
    "modulus": ("lin-rotary-1", [('"210 GPa"', '"210 N"')], "material.youngs_modulus", '"210 N"', "1 MPa"),
    "Poisson's ratio": ("lin-rotary-1", [("0.28", "0.5")], "material.poissons_ratio", "0.5", "below 0.5"),
    "coefficient": ("lin-rotary-1", [("ient = 0.1", "ient = -0.1")], "friction.coefficient", "-0.1", "0 to 2"),
    "unlike grooves": (
        "lin-rotary-1",
        [("[nut]\nconformity = 0.54", "[nut]\nconformity = 0.55")],
        "nut.conformity",
        "0.55",
        "6.75 mm",
    ),
    "ring with a lead": ("lin-rotary-1", [('"0 mm"', '"1 mm"')], "track.lead", '"1 mm"', '"0 mm"'),
    "no material": ("lin-rotary-1", [("poissons_ratio = 0.28", "")], "material.poissons_ratio", "nothing", "0.28"),
    "no sharpness": ("lin-rotary-1", [(COULOMB, 'law = "sigmoid"')], "friction.sharpness", "nothing", "k_S"),
    "unknown law": ("lin-rotary-1", [(COULOMB, 'law = "stribeck"')], "friction.law", '"stribeck"', '"sigmoid"'),
    "law of a linear bearing": (
        "lin-pair-a",
        [("balls = 0.1", 'law = "sigmoid"')],
        "friction.law",
        '"sigmoid"',
        "unknown key",
    ),
    "no creep": ("lin-rotary-1", [(COULOMB, 'law = "regularised"')], "friction.creep", "nothing", "above 0 m/s"),
    "creep zero": (
        "lin-rotary-1",
        [(COULOMB, 'law = "regularised"\ncreep = "0 m/s"')],
        "friction.creep",
        '"0 m/s"',
        "above 0 m/s",
    ),
    "key of another law": (
        "lin-rotary-1",
        [(COULOMB, COULOMB + "\nsharpness = 9")],
        "friction.sharpness",
        "9",
        'law = "sigmoid"',
    ),
    "sigmoid at rest": ("lin-rotary-1-printed", [('"10 rps"', '"0 rps"')], "motion.speed", '"0 rps"', "not zero"),
    "Hertz": (
        "lin-rotary-1",
        [("[load]", '[ingredients]\nhertz = "actual"\n[load]')],
        "ingredients.hertz",
        '"actual"',
        '"as printed"',
    ),
    "side force pulls": ("lin-pair-a", [("-0.6", "-0.94")], "load.side_force_ratio", "-0.94", "-0.9325 to 1"),
    "side force pulls the second": ("lin-pair-a", [("-0.6", "0.94")], "load.side_force_ratio", "0.94", "-1 to 0.9325"),
    "side force beyond a diagonal": (
        "lin-pair-a",
        [("-0.6", "-1.01"), ('"balanced"', '"diagonal"')],
        "load.side_force_ratio",
        "-1.01",
        "-1 to 1",
    ),
    "no vertical force": ("lin-pair-a", [('"100 N"', '"0 N"')], "load.vertical_force", '"0 N"', "above 0 N"),
    "unknown distribution": ("lin-pair-a", [('"balanced"', '"even"')], "load.distribution", '"even"', '"elastic"'),
    "angles past 90 deg": (
        "lin-pair-a",
        [('"2 deg"', '"14 deg"'), ('"45 deg"', '"80 deg"')],
        "angles.deviation",
        '"14 deg"',
        "below 90 deg",
    ),
    "mated": ("lin-pair-a", [("mated = false", 'mated = "no"')], "angles.mated", '"no"', "true, false"),
    "three deviations": ("lin-chain-10", [('"-2 deg", ', "")], "chain[0].angle_deviations", '["2 deg"', "4 entries"),
    "ball's side force": ("lin-chain-10", [("-0.6", "-0.95")], "chain[0].side_force_ratio", "-0.95", "-0.9325 to 1"),
    "negative gap": ("lin-chain-10", [("-0.6\n", '-0.6\ngap = "-1 um"\n')], "chain[0].gap", '"-1 um"', "0 mm to 1 m"),
    "gap after the last": ("lin-chain-10", [("= 0.6\n", '= 0.6\ngap = "1 um"\n')], "chain[9].gap", '"1 um"', "last"),
    "no title": ("lin-pair-a", [("title =", "source2 =")], "source2", '"Two', "did you mean source"),
    "not TOML": ("lin-pair-a", [("[grooves]", "[grooves")], "line 18, column 9", "[grooves", "TOML"),
}


@pytest.mark.parametrize("case", list(CASES))
def test_bad_input_is_one_line(tmp_path, case):
    name, changes, key, value, hint = CASES[case]
    path = tmp_path / "my.toml"
    path.write_text(changed(name, *changes), encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        catalogue.any_scene(str(path))
    error, line = caught.value, str(caught.value)
    assert (error.file, error.key) == (str(path), key)
    assert error.value.startswith(value)
    assert hint in line
    assert line.startswith(str(path)[:40])
    for part in ("; allowed: ", "; advice: "):
        assert part in line
    assert "\n" not in line
    assert line.isprintable()
    assert "pydantic" not in line


def test_files_and_names_that_do_not_exist(tmp_path):
    with pytest.raises(InputError, match="did you mean lin-rotary-1"):
        catalogue.any_scene("lin-rotary1")
    with pytest.raises(SceneError, match="no such file"):
        catalogue.any_scene(str(tmp_path / "none.toml"))
    empty = tmp_path / "empty.toml"
    empty.write_text("", encoding="utf-8")
    with pytest.raises(SceneError, match="title: got nothing"):
        catalogue.any_scene(str(empty))


@pytest.mark.parametrize("kind", list(KINDS))
def test_schema_describes_every_key(kind):
    schema = tidy_schema(KINDS[kind].keys)
    nodes = [schema, *schema["$defs"].values()]
    for node in nodes:
        for name, entry in node.get("properties", {}).items():
            assert entry.get("description"), name
    json.dumps(schema, allow_nan=False)
