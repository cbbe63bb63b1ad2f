"""Files that do harm: damaged, endless, hostile. One line and exit code 2, whatever they hold."""

import io
import os
import struct
import zipfile
from dataclasses import asdict, replace
from functools import cache

import numpy as np
import pytest

from rollbench.compare.reference.store import DEEPEST, read_checked_data, run_text_with_checksum
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.meshes import condensed
from rollbench.meshes.condensed import CondensedBodies, digest_of_geometry, read_condensed_bodies

SCENE = "lin-case1"


@cache
def bodies():
    scene = catalogue.scene(SCENE)
    body, small = np.eye(2 * scene.ball_count) * 1e-9, np.eye(4) * 1e-10
    line, force = np.full((4, 3), 1e-11), np.tile([10.0, 100.0, 300.0], (4, 1))
    digest, sides = digest_of_geometry(scene), np.arange(4.0)
    return CondensedBodies(digest, 1, sides, 0.3, body, body, small, line, force, np.full(4, 1e-7))


#: Arrays that no part has, each by the name of its array.
BODIES = {
    "nan": ("screw", lambda: np.full_like(bodies().screw, np.nan)),
    "infinite": ("local", lambda: bodies().local * np.inf),
    "negative": ("nut", lambda: -bodies().nut),
    "not symmetric": ("screw", lambda: bodies().screw + 1e-10 * np.eye(len(bodies().screw), k=1)),
    "side twice": ("sides", lambda: np.array([0.0, 0.0, 1.0, 3.0])),
    "no such side": ("sides", lambda: np.array([0.0, 1.0, 2.0, 7.0])),
    "Hertz of zero": ("hertz", lambda: np.zeros(4)),
    "negative contact": ("local", lambda: -1e3 * bodies().local - 1e-6),
    "contact that yields": ("local", lambda: np.tile([1e-6, 1e-8, -3e-8], (4, 1))),
    "contact of 1e200": ("local", lambda: np.full((4, 3), 1e200)),
    "base at 1e200": ("base", lambda: 1e200),
}


@pytest.fixture
def path(tmp_path):
    """A file of good bodies."""
    bodies().save(tmp_path / "x.npz")
    return tmp_path / "x.npz"


@pytest.fixture
def refused(path, command):
    """What the command says, in one line, of that file as it has become."""
    return lambda: command.refused("solve", SCENE, "--condensed", path)


@pytest.mark.parametrize("how", BODIES)
def test_bodies_that_no_part_has_are_refused(how, path, refused):
    name, value = BODIES[how]
    with np.errstate(all="ignore"):
        replace(bodies(), **{name: value()}).save(path)
    refused()


def rewritten(path, **members):
    """A file with other arrays under its old checksum."""
    with np.load(path) as data:
        values = {name: data[name] for name in data.files}
    np.savez_compressed(path, **(values | members))


def test_a_changed_number_does_not_fit_the_checksum(path, refused):
    rewritten(path, screw=bodies().screw * 1.001)
    assert "checksum" in refused()


@pytest.mark.parametrize("value", [np.array("text"), np.array([b"x"]), np.zeros((2, 2, 2)), np.array([], dtype=complex)])
@pytest.mark.parametrize("name", ["format", "level", "screw", "geometry", "sides"])
def test_arrays_of_another_kind_are_refused(name, value, path, refused):
    rewritten(path, **{name: value})
    refused()


def test_good_bodies_are_read_and_damaged_bytes_refused(path, refused):
    """Single flipped bytes all over the file: zlib, headers, directory."""
    assert np.array_equal(read_condensed_bodies(path).screw, bodies().screw)
    whole = path.read_bytes()
    for place in np.linspace(0, len(whole) - 1, 60).astype(int):
        broken = bytearray(whole)
        broken[place] ^= 0xFF
        path.write_bytes(bytes(broken))
        try:
            found = read_condensed_bodies(path)
        except ValueError:
            continue
        assert all(np.array_equal(a, b) for a, b in zip(asdict(found).values(), asdict(bodies()).values(), strict=True))
    path.write_bytes(whole[: len(whole) // 2])
    refused()


def test_a_small_file_that_declares_a_huge_one_is_refused(path, refused, monkeypatch):
    head = "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000, 1000000000), }".ljust(117) + "\n"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("screw.npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head.encode())
    assert "a size other than that of the array" in refused()
    monkeypatch.setattr(condensed, "LARGEST_FILE", 1_000_000)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        np.lib.format.write_array(member := io.BytesIO(), np.zeros(130_000))
        archive.writestr("screw.npy", member.getvalue())
    assert path.stat().st_size < 10_000
    assert "bytes of content" in refused()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
@pytest.mark.parametrize("line", ["solve {}", "friction {}", "solve lin-case1 --condensed {}"])
def test_pipes_and_devices_are_no_files(line, tmp_path, command):
    os.mkfifo(tmp_path / "pipe.toml")
    reading, writing = os.pipe()
    try:
        for path in (tmp_path / "pipe.toml", "/dev/zero", f"/dev/fd/{reading}"):
            if os.path.exists(path):
                command.refused(*line.format(path).split())
    finally:
        os.close(reading)
        os.close(writing)


def test_a_stored_run_fits_its_checksum(tmp_path):
    path = tmp_path / "run.json"
    data = {"load": [[1.0, 2.0], [3.0, 4.0]], "scene": "x"}
    path.write_text(run_text_with_checksum(data), encoding="utf-8")
    assert read_checked_data(path) == data
    changed, nested = run_text_with_checksum(data).replace("3.0", "3.1"), "[" * (DEEPEST + 1) + "]" * (DEEPEST + 1)
    for text, words in ((changed, "checksum"), ('{"load":[[1.0]]}', "checksum"), (nested, "nested")):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(ValueError, match=words):
            read_checked_data(path)
    with pytest.raises(ValueError, match="regular"):
        read_checked_data(tmp_path)


@pytest.mark.parametrize("key", ["a" + ".a" * 100_000, "\"a\" . 'b' " + ".\t'c'" * 40, "x = { y" + ".y" * 40])
def test_a_key_of_very_many_parts_is_refused_at_once(key, scene_file, command):
    said = command.refused("solve", scene_file(f"title = 'a'\n{key} = 1\n"))
    assert ("line 2" in said, "a key of up to 32 names" in said) == (True, True)


def test_long_words_and_numbers_are_no_keys():
    text = f"title = '{'a' * 1_000_000}'\nassumed = ['{'-' * 1_000_000}', '{'1.2 ' * 100_000}']\n[a.b.c.d]\ne.f = 1\n"
    assert set(scene_file.parse_toml(text, "x")) == {"title", "assumed", "a"}


def page(manifest="{}", results="{}"):
    blocks = {"manifest": manifest, "scene": '"x"', "results": results}
    return "".join(f'<script type="application/json" id="{name}">{text}</script>' for name, text in blocks.items())


PAGES = {
    "no manifest": "<html></html>",
    "half a manifest": '<script type="application/json" id="manifest">{</script>',
    "brackets": page(results="[" * 100_000),
    "files are a text": page('{"files": "abc"}'),
    "files of numbers": page('{"files": {"a": 1}}'),
    "provenance is a list": page('{"provenance": [1]}'),
    "results are a list": page(results="[1]"),
}


@pytest.mark.parametrize("how", PAGES)
def test_pages_that_no_report_wrote_are_refused(how, tmp_path, command):
    (tmp_path / "x.html").write_text(PAGES[how])
    assert "a page with a manifest" in command.refused("report", "two-balls", "--against", tmp_path / "x.html")


def test_a_page_of_a_terabyte_is_refused(tmp_path, command):
    with open(tmp_path / "large.html", "wb") as file:
        file.truncate(10**12)
    assert "largest permitted size" in command.refused("report", "two-balls", "--against", tmp_path / "large.html")
