"""All faults of a file are told at once, each on its line, unknown keys with what a scene calls them."""

import pickle

import pytest

from rollbench.compare.errors import InputError, SceneError, SceneNotCoveredError
from rollbench.compare.scenes import scene_file
from rollbench.compare.scenes.template import commented_template

GOOD = commented_template()


def faults(*changes: tuple[str, str]) -> SceneError:
    text = GOOD
    for old, new in changes:
        assert f"\n{old}" in text, old
        text = text.replace(f"\n{old}", f"\n{new}", 1)
    with pytest.raises(SceneError) as caught:
        scene_file.scene_from_text(text, "my.toml")
    return caught.value


def keys(error: SceneError) -> list[str]:
    return [error.key, *(other.key for other in error.others)]


def test_keys_choices_and_bodies_are_told_together() -> None:
    title = ('title = "My ball screw"', "title = 1\ncolour = 3")
    wall = ('outer_diameter = "48 mm"', 'outer_diameter = "38 mm"')
    twice = ('at = "0 mm"\nfix = ["ux"', 'at = "0 mm"\nfix = []\n[[supports]]\nat = "0 mm"\nfix = ["ux"')
    error = faults(title, wall)
    assert keys(error) == ["colour", "title", "nut.outer_diameter"]
    assert str(error).endswith("(and 2 more faults)")
    assert keys(faults(title, wall, twice)) == ["colour", "title", "supports[0].fix"], "no bodies beside wrong choices"
    assert keys(faults(("turns = 2", 'turns = "2"'), twice)) == ["balls.turns", "supports[0].fix"]


def test_what_a_faulty_value_may_have_caused_is_not_told() -> None:
    """Without its count, nothing can be said of the balls in the nut; a missing key not beside the unknown one that stands
    for it."""
    error = faults(("count = 32", "cout = 32"), ('length = "54 mm"', 'length = "5 mm"'))
    assert (keys(error), error.advice) == (["balls.cout"], "unknown key; did you mean count?")
    error = faults(('pitch_radius = "16.5 mm"', 'pitch_radus = "16.5 mm"'), ("[screw]", "[shaft]"))
    assert sorted(keys(error)) == ["shaft", "track.pitch_radus"]


def test_each_fault_is_a_line_of_the_command_line(command, tmp_path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(GOOD.replace('"20 mm"', '"20"').replace("count = 32", "count = 0"), encoding="utf-8")
    code, _, err = command("solve", file)
    assert (code, "more fault" in err) == (2, False)
    assert [line.startswith(f"rollbench: {file}: ") for line in err.splitlines()] == [True, True]


def test_many_faults_are_cut() -> None:
    listed = ", ".join(['"1"'] * 1000)
    error = faults(("count = 32", f"azimuths = [{listed}]"))
    assert (error.more, len(error.lines()), error.lines()[-1]) == (999, 31, "my.toml: and 970 more faults")


@pytest.mark.parametrize("error", [InputError("a", "b", "c", "d", "e", 3), SceneNotCoveredError("a", "b", "c", "e")])
def test_errors_travel_between_processes(error) -> None:
    back = pickle.loads(pickle.dumps(error))
    assert (type(back), str(back)) == (type(error), str(error))
