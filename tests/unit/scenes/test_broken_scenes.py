"""Deliberately broken scene files: each gives one line that says where, what and what to do."""

import re
import tomllib
from math import asin, degrees
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.shipped_texts import changed, parse_file

from rollbench.compare.errors import SceneError
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.scenes.template import commented_template

GOOD = commented_template()
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
        catalogue.scene_of_any_kind(str(path))
    return caught.value


def check_line(error: SceneError, file: str) -> str:
    line = str(error)
    assert line.isprintable()  # so that it is one line
    assert len(line) < 1000
    assert line.startswith(f"{file}: {error.key}: got ")
    assert all([error.key, error.value, error.allowed, error.advice])
    assert [words in line for words in ("; allowed: ", "; advice: ", "Traceback", "pydantic")] == [True, True, False, False]
    return line


BASES = {"template": GOOD, "bearing": broken(BEARING), "empty": ""}
CASES = tomllib.loads(Path(__file__).with_name("broken.toml").read_text(encoding="utf-8"))
#: Changes to the template that no file of cases should hold, key, value as found, a part of range or advice.
HUGE = {
    "too many listed balls": (
        {"count = 32": "azimuths = [" + '"0 deg", ' * 50_001 + "]", "turns = 2": "", "[screw]": "starts = 2\n[screw]"},
        "balls.azimuths",
        "100002 balls",
        "at most 100000",
    ),
    "TOML nested too deeply": ({"turns = 2": "turns = " + "[" * 5000}, "file", "text that is not TOML", "nested"),
    "TOML huge integer": ({"count = 32": "count = " + "9" * 5000}, "file", "text that is not TOML", "digits"),
}


@pytest.mark.parametrize("name", CASES)
def test_broken_scene(name, tmp_path):
    case = CASES[name]
    file, changes = case["file"], case.get("changes", ())
    text = broken(dict(changes), BASES[file]) if file in BASES else changed(file, *changes)
    further = refused(tmp_path, text + case.get("end", ""), case["key"], case["value"], case.get("advice", "")).more
    assert further == case.get("more", further)


@pytest.mark.parametrize("name", HUGE)
def test_file_that_is_too_much(name, tmp_path):
    changes, *expected = HUGE[name]
    refused(tmp_path, broken(changes), *expected)


def refused(tmp_path, text: str, key: str, value: str, advice: str) -> SceneError:
    error = refusal(tmp_path, text)
    line = check_line(error, str(tmp_path / "my.toml"))
    assert (error.key, value in error.value, advice in line) == (key, True, True)
    return error


def test_binary_file(tmp_path):
    for content in (b"\x89PNG\r\n\x1a\n\x00\x00", b"title = \x00", bytes(range(128, 256))):
        assert refused(tmp_path, content, "file", "a binary file", "").value.startswith("a binary file (line 1, ")


UNREADABLE = [("", "a directory"), ("none.toml", "no such file"), ("a\0b.toml", "null byte"), ("x" * 5000, "too long")]


@pytest.mark.parametrize(("name", "value"), UNREADABLE)
def test_unreadable(tmp_path, name, value):
    with pytest.raises(SceneError) as caught:
        parse_file(f"{tmp_path}/{name}" if name else tmp_path)
    assert (value in caught.value.value, str(caught.value).isprintable(), caught.value.key) == (True, True, "file")


def test_huge_file_is_not_read_whole(tmp_path, monkeypatch):
    monkeypatch.setattr(scene_file, "MAX_BYTES", 1_000_000)
    assert "more than 1 MB" in refusal(tmp_path, b"#" * 1_000_001).value


def test_unequal_balls_that_are_not_nearest_neighbours_overlap(tmp_path):
    """Balls 2 and 3 overlap, yet each has a nearer neighbour, small enough not to touch it."""
    listed = '[errors.balls.listed]\n1 = "-0.3 mm"\n3 = "0.3 mm"\n4 = "-0.4 mm"\n[[supports]]'
    places = 'azimuths = ["-19.4 deg", "0 deg", "20 deg", "39.4 deg"]'
    text = broken({"count = 32": places, "turns = 2": "", "[[supports]]": listed})
    assert "balls 2 and 3" in refusal(tmp_path, text).value
    scene_file.scene_from_text(text.replace('3 = "0.3 mm"', '3 = "0.2 mm"'), "a.toml")


def test_full_complement_of_touching_balls_is_allowed_and_the_bearing_that_cases_start_from_is_sound():
    """So it is their change that is refused."""
    assert scene_file.scene_from_text(broken(BEARING), "b.toml").ball_count == 16
    step = degrees(2 * asin(2.778 / 16.5))
    azimuths = ", ".join(f'"{i * step!r} deg"' for i in range(18))
    text = broken({'lead = "20 mm"': 'lead = "0 mm"', "turns = 2": "", "count = 32": f"azimuths = [{azimuths}]"})
    assert scene_file.scene_from_text(text, "full.toml").ball_count == 18


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_any_mutilation_is_one_line_or_a_scene(data):
    """Random cuts, swaps and insertions of text never escape as anything but a SceneError of one line."""
    text = GOOD
    for _ in range(data.draw(st.integers(1, 3))):
        i = data.draw(st.integers(0, len(text)))
        j = min(len(text), i + data.draw(st.integers(0, 12)))
        pieces = ['"', "[", "]", "=", "\n", "nan", "-", "1e400", "{", "}", "0", "", "é", "\x7f", "5 kN"]
        piece = data.draw(st.sampled_from(pieces))
        text = text[:i] + piece + text[j:]
    try:
        scene_file.scene_from_text(text, "m.toml")
    except SceneError as error:
        check_line(error, "m.toml")
