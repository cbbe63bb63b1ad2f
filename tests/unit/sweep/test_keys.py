import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.scenes import catalogue, scene_file, scene_tables, template
from rollbench.compare.studies.sweep import keys as sweep_keys


def test_forms():
    one, two, three, four = sweep_keys.read_varied_keys(
        ["errors.balls.oversize=0 um:7 um", "loads[0].force[2]=1:5 kN", "errors.seed=3:5", "track.hand=left,right"]
    )
    assert (one.key, one.low, one.high, one.unit, one.whole_numbers_only) == (
        "errors.balls.oversize",
        0.0,
        7.0,
        "um",
        False,
    )
    assert (two.low, two.high, two.unit) == (1.0, 5.0, "kN")
    assert [three.value_at_relative_position(u) for u in (0.0, 0.34, 0.67, 1.0)] == [3, 4, 5, 5]
    assert [four.value_at_relative_position(u) for u in (0.0, 0.49, 0.5, 1.0)] == ["left", "left", "right", "right"]
    assert (one.value_at_relative_position(0.5), one.as_number("3.5 um"), four.as_number("right")) == ("3.5 um", 3.5, 2.0)
    assert sweep_keys.read_varied_keys(["nut.conformity=0.52,0.56"])[0].listed_values == (0.52, 0.56), "as TOML reads them"
    assert [three.as_number(4), one.as_number("1e-07 um"), one.as_number(" 2um ")] == [4.0, 1e-7, 2.0]


@pytest.mark.parametrize(
    "text",
    ["", "track.lead", "track.lead=", "track..lead=1 mm:2 mm", "track.lead=1 mm:2 um", "track.lead=2 mm:1 mm", "a=1",
     "a=1,1", "a=1,,2", "a=x:y", "a=1:2:1", "a=1:2:3:4", "a b=1,2"],
)  # fmt: skip
def test_other_forms_a_key_twice_and_no_key_are_refused(text):
    for texts, words in (([text], "vary: got"), (["a=1,2", "a=3,4"], "each key once"), ([], "0 keys")):
        with pytest.raises(InputError, match=words):
            sweep_keys.read_varied_keys(texts)


RAW = scene_file.parse_toml(catalogue.shipped_scene_text("lin-case3"), "lin-case3.toml")


def put(key, value):
    return sweep_keys.tables_with_varied_keys(RAW, [sweep_keys.VariedKey(key, key)], [value])


def test_values_reach_the_scene():
    scene = scene_tables.single_nut_scene_from_tables(put("loads[0].force[2]", "3 kN"), "x")
    assert scene.loads[0].force == (0.0, 0.0, 3000.0)
    scene = scene_tables.single_nut_scene_from_tables(put("errors.NL.profile_sigma", ["1 um"]), "x")
    assert scene.errors.NL.profile_sigma == (1e-6,)
    assert RAW["loads"][0]["force"][2] == "5 kN"


@pytest.mark.parametrize("key", ["loads[1].force[2]", "loads.force", "track.lead.x", "errors.SL.pitch[0].sin"])
def test_what_the_scene_does_not_have_is_refused(key):
    with pytest.raises(InputError, match="vary: "):
        put(key, "1 um")


DISPLACED = [
    ("errors.balls.oversize=1 um:7 um", ["preload.force"]),
    ("preload.oversize=1 um:7 um", ["preload.force"]),
    ("track.pitch_radius=20.5 mm:21 mm", ["track.pitch_diameter"]),
    ("balls.count=40,44", ["balls.filling"]),
    ("screw.groove_radius+nut.groove_radius=3.3 mm:3.4 mm", ["screw.conformity", "nut.conformity"]),
    ("preload.force=2 kN:3 kN", []),
]


@pytest.mark.parametrize(("vary", "gone"), DISPLACED)
def test_a_varied_key_takes_the_place_of_one_that_says_the_same(vary, gone):
    raw = scene_file.parse_toml(template.ball_screw_text("40x10"), "my.toml")
    keys = sweep_keys.read_varied_keys([vary])
    assert [other for _, other in sweep_keys.varied_and_replaced_keys(raw, keys)] == gone
    first, second = (
        scene_tables.scene_from_tables(sweep_keys.tables_with_varied_keys(raw, keys, [v]), "my.toml")
        for v in keys[0].trial_values
    )
    assert first != second
    assert raw == scene_file.parse_toml(template.ball_screw_text("40x10"), "my.toml"), "the scene itself stays"


def test_the_same_in_a_set():
    raw = scene_file.parse_toml(template.double_nut_text("40x10"), "my.toml")
    keys = sweep_keys.read_varied_keys(["sets[1].nut.groove_radius=3.3 mm:3.4 mm"])
    assert sweep_keys.varied_and_replaced_keys(raw, keys) == [("sets[1].nut.groove_radius", "sets[1].nut.conformity")]
    found = scene_tables.scene_from_tables(sweep_keys.tables_with_varied_keys(raw, keys, ["3.4 mm"]), "my.toml")
    assert [s.parts.nut.groove_radius for s in found.sets] == [pytest.approx(0.525 * 6.35e-3), 3.4e-3]
