"""Geometries that are kept between commands: off unless switched on, read where their file is whole, else made again."""

import pytest

from rollbench.meshes import cache, parts
from rollbench.meshes.section import BeamSection, tube_section

calls: list[float] = []


@cache.cached_on_disk(BeamSection)
def section(outer: float) -> BeamSection:
    calls.append(outer)
    return tube_section(outer, 0.01, parts.Material(2.1e11, 0.3))


@pytest.fixture
def on(tmp_path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("ROLLBENCH_CACHE", str(tmp_path))
    calls.clear()
    cache.switch_on_geometry_cache()
    yield tmp_path
    cache.switch_off_geometry_cache()


def test_made_once_and_read_after_but_for_what_is_timed_and_what_is_damaged(on) -> None:
    whole = section(0.04)
    assert section(0.04) == whole
    assert calls == [0.04]
    with cache.without_geometry_cache():
        section(0.04)
    section(0.04)
    assert calls == [0.04] * 2
    (file,) = (on / cache.GEOMETRIES).rglob("*.npz")
    content = bytearray(file.read_bytes())
    content[-40] ^= 1
    file.write_bytes(content)
    assert section(0.04) == whole
    assert calls == [0.04] * 3


def test_nothing_is_kept_unless_switched_on(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROLLBENCH_CACHE", str(tmp_path))
    section(0.05)
    assert not list(tmp_path.iterdir())
