"""The report's section on how a nut is held: ways, rows, its first sentence."""

from dataclasses import replace

import pytest

from rollbench.comparison.models.study import Study
from rollbench.comparison.scenes import catalogue
from rollbench.comparison.sources.external import holding
from rollbench.comparison.sources.external.evidence.screws import scene_name
from rollbench.meshes.solid import dimensions
from rollbench.reports.records import Table, Text


def test_ways_differ_in_how_the_nut_is_held_alone() -> None:
    scene = catalogue.scene(scene_name("bnf-4010-5"))
    found = holding.ways(scene)
    held = [dimensions(x).nut_held for x in found.values()]
    assert held == ["left face", "right face", "outer surface", *["flange face"] * 3, "flange face and centring"]
    for other in found.values():
        assert replace(other, nut=scene.nut, solid=scene.solid) == scene
    inner, outer = (found[f"flange, {x} half of its face"].nut.flange for x in ("inner", "outer"))
    assert inner is not None
    assert outer is not None
    assert inner.seat[1] == outer.seat[0] == pytest.approx(51.25e-3)


def test_a_model_with_a_rigid_nut_sees_no_difference(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(holding, "DEFAULT", "lin")
    monkeypatch.setattr(holding, "SIZES", ("bnf-4010-5",))
    text, table = holding.section(Study(), lambda _: None).items
    assert isinstance(text, Text)
    assert isinstance(table, Table)
    assert text.paragraphs[0].startswith("The way of holding a nut moves its largest load by +0.0 to +0.0 %, its life by ")
    assert len(table.rows) == 7
    assert {row["rigidity_change"] for row in table.rows} == {0.0}
    assert table.rows[0]["share"] == pytest.approx(0.62, abs=0.06)
