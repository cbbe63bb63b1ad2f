import numpy as np
import pytest

from rollbench.compare.errors import InputError
from rollbench.compare.scenes import catalogue, scene_file, scene_tables, template
from rollbench.compare.studies.sweep import keys


def test_forms():
    texts = "errors.balls.oversize=0 um:7 um", "loads[0].force[2]=1:5 kN", "errors.seed=3:5", "track.hand=left,right"
    one, two, three, four, five = keys.read_varied_keys([*texts, "nut.conformity=0.52,0.56"])
    assert (one.key, one.low, one.high, one.unit, one.whole_numbers_only) == ("errors.balls.oversize", 0, 7, "um", False)
    assert (two.low, two.high, two.unit) == (1.0, 5.0, "kN")
    assert [three.value_at_relative_position(u) for u in (0.0, 0.34, 0.67, 1.0)] == [3, 4, 5, 5]
    assert [four.value_at_relative_position(u) for u in (0.0, 0.49, 0.5, 1.0)] == ["left", "left", "right", "right"]
    assert (one.value_at_relative_position(0.5), four.as_number("right"), three.as_number(4)) == ("3.5 um", 2.0, 4.0)
    assert [one.as_number(text) for text in ("3.5 um", "1e-07 um", " 2um ")] == [3.5, 1e-7, 2.0]
    assert five.listed_values == (0.52, 0.56), "as TOML reads them"
    assert keys.read_varied_keys(texts[0]) == (one,), "a single text is one key"


@pytest.mark.parametrize(
    "text",
    ["", "track.lead", "track.lead=", "track..lead=1 mm:2 mm", "track.lead=1 mm:2 um", "track.lead=2 mm:1 mm", "a=1",
     "a=1,1", "a=1,,2", "a=x:y", "a=1:2:1", "a=1:2:3:4", "a b=1,2"],
)  # fmt: skip
def test_other_forms_a_key_twice_and_no_key_are_refused(text):
    for texts, words in (([text], "vary: got"), (["a=1,2", "a=3,4"], "each key once"), ([], "0 keys")):
        with pytest.raises(InputError, match=words):
            keys.read_varied_keys(texts)


RAW = scene_file.parse_toml(catalogue.shipped_scene_text("lin-case3"), "lin-case3.toml")


def put(key, value):
    return keys.tables_with_varied_keys(RAW, [keys.VariedKey(key, key)], [value])


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
    text, varied = template.new_scene_text("ball screw", "40x10"), keys.read_varied_keys([vary])
    raw = scene_file.parse_toml(text, "my.toml")
    assert [other for _, other in keys.varied_and_replaced_keys(raw, varied)] == gone
    first, second = (
        scene_tables.scene_from_tables(keys.tables_with_varied_keys(raw, varied, [v]), "my.toml")
        for v in varied[0].trial_values
    )
    assert first != second
    assert raw == scene_file.parse_toml(text, "my.toml"), "the scene itself stays"


def test_the_same_in_a_set():
    raw = scene_file.parse_toml(template.new_scene_text("double nut", "40x10"), "my.toml")
    varied = keys.read_varied_keys(["sets[1].nut.groove_radius=3.3 mm:3.4 mm"])
    assert keys.varied_and_replaced_keys(raw, varied) == [("sets[1].nut.groove_radius", "sets[1].nut.conformity")]
    found = scene_tables.scene_from_tables(keys.tables_with_varied_keys(raw, varied, ["3.4 mm"]), "my.toml")
    assert [s.parts.nut.groove_radius for s in found.sets] == [pytest.approx(0.525 * 6.35e-3), 3.4e-3]


KEYS = keys.read_varied_keys(["a=0.0:1.0", "b=1 um:3 um", "c=x,y,z"])


def test_sobol_design_is_a_b_and_their_mixtures():
    found = keys.sample_coordinates("sobol", KEYS, 100, 1)
    n = keys.base_point_count(100, 3)
    assert (n, found.shape) == (16, (5 * 16, 3))
    a, b = found[:n], found[n : 2 * n]
    for k in range(3):
        mixed = found[(2 + k) * n : (3 + k) * n]
        assert np.array_equal(mixed[:, k], b[:, k])
        assert np.array_equal(np.delete(mixed, k, axis=1), np.delete(a, k, axis=1))


def test_latin_hypercube_has_one_sample_in_every_slice():
    slices = (50 * keys.sample_coordinates("lhs", KEYS, 50, 3)).astype(int)
    np.testing.assert_array_equal(np.sort(slices, axis=0), np.arange(50)[:, None] * np.ones((1, 3)))


def test_grid_has_all_combinations_and_the_ends():
    found = keys.sample_coordinates("grid", KEYS, 30, 0)
    rows = [tuple(keys.key_values_at_coordinates(KEYS, place)) for place in found]
    assert len(rows) == len(set(rows)) == 3 * 3 * 3
    assert [{row[k] for row in rows} for k in (1, 2)] == [{"1.0 um", "2.0 um", "3.0 um"}, {*"xyz"}]


def test_same_seed_same_places_and_another_seed_others():
    for method in ("sobol", "lhs"):
        first = keys.sample_coordinates(method, KEYS, 64, 5)
        assert np.array_equal(first, keys.sample_coordinates(method, KEYS, 64, 5))
        assert not np.array_equal(first, keys.sample_coordinates(method, KEYS, 64, 6))


@pytest.mark.parametrize(("method", "samples"), [("random", 10), ("lhs", 1), ("grid", 5), ("lhs", 10**7)])
def test_bad_designs_are_refused(method, samples):
    with pytest.raises(InputError):
        keys.sample_coordinates(method, KEYS, samples, 0)


def test_the_axial_load_has_a_short_name():
    """As in a table; a scene without one axial load is refused."""
    raw = {"loads": [{"force": ["1 N", "0 N", "0 N"]}, {"force": ["0 N", "0 N", "5 kN"]}]}
    varied = keys.read_varied_keys(["load=1 kN:5 kN", "balls.count=20,24"])
    assert [x.key for x in keys.with_axial_load_key(varied, raw, "my.toml")] == ["loads[1].force[2]", "balls.count"]
    with pytest.raises(InputError, match="one axial load"):
        keys.with_axial_load_key(varied, {"loads": [raw["loads"][1]] * 2}, "my.toml")
