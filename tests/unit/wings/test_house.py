"""The manual's drawing of the house shows the imports, and these go down only."""

import re

import pytest
from tests.copies import ROOT, docs_module

house = docs_module("house")
FLOOR = {name: k for k, row in enumerate(house.ROWS) for name in row}
PLANTED = """
from . import records
def later():
    from rollbench.compare.{} import {}
"""


def test_each_wing_and_source_is_drawn_and_has_its_door() -> None:
    folders = {path.parent.name for place in ("wings", "sources") for path in ROOT.glob(f"compare/{place}/*/__init__.py")}
    doors = {path.parent.name for path in ROOT.glob("compare/*/*/registration.py")}
    assert folders == doors == FLOOR.keys() - set(house.CORE)


def test_arrows_go_down_only() -> None:
    assert [(start, end) for start, end in house.arrows() if FLOOR[start] >= FLOOR[end]] == []
    assert not {end for start, end in house.arrows() if start in house.CORE} - set(house.CORE)


def test_what_is_drawn_is_imported(tmp_path) -> None:
    house.draw(tmp_path / "house.svg")
    found = re.findall(r'id="(\w+) to (\w+): (\d+)"', (tmp_path / "house.svg").read_text(encoding="utf-8"))
    drawn = {(start, end): int(count) for start, end, count in found}
    assert {pair: n for pair, n in drawn.items() if "core" not in pair} == {
        (start, end): n for (start, end), n in house.arrows().items() if (start in house.CORE) == (end in house.CORE)
    }
    assert sum(drawn.values()) == sum(house.arrows().values())
    assert "_static/house.svg" in (ROOT / "docs/inside.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("words", [("models.friction_sums", "torque"), ("wings", "friction")])
def test_an_import_of_a_wing_within_a_function_of_the_core_is_an_arrow(tmp_path, words) -> None:
    (tmp_path / "lowfi").mkdir()
    (tmp_path / "lowfi/planted.py").write_text(PLANTED.format(*words), encoding="utf-8")
    assert house.arrows(tmp_path) == {("lowfi", "friction"): 1}
