"""Pages of a report made in two processes are those made here, one after the other."""

import re

import pytest

from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.report.pages import SECTIONS
from rollbench.compare.report.report import make_sections

pytestmark = pytest.mark.further


def shown(sections: object) -> str:
    """All that sections say; functions by their names."""
    return re.sub(" at 0x[0-9a-f]+", "", repr(sections))


def test_pages_made_side_by_side_are_those_made_in_turn() -> None:
    parts = [part for part in SECTIONS if part.name in ("how-to-read", "hertz", "fit")]
    alone, together, announced = SceneResultCache(), SceneResultCache(), list[str]()
    one = make_sections(parts, lambda _: None, lambda _: None, alone)
    two = make_sections(parts, announced.append, lambda _: None, together, process_count=2)
    assert {name: shown(sections) for name, sections in two.items()} == {n: shown(s) for n, s in one.items()}
    assert sorted(announced) == sorted(part.name for part in parts)
    assert together.used_scenes.keys() == alone.used_scenes.keys() != set()
