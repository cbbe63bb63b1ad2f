"""Sketches of scenes: what they show, where, and that a sheet has sketch, inputs, result and verdict."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest

from rollbench.compare.gate.verdict import Limits, judge
from rollbench.compare.models.study import Study
from rollbench.compare.scenes import catalogue
from rollbench.compare.sections import sheets
from rollbench.compare.sections.sketch import sketch_of
from rollbench.reports.content import Sketch, Table, Text
from rollbench.reports.sketch import FORCE, INK, WIDTH, _held, draw, faces

SVG = "{http://www.w3.org/2000/svg}"


def drawn(name: str) -> tuple[Sketch, ElementTree.Element]:
    sketch = sketch_of(catalogue.scene(name), "s", "S")
    return sketch, ElementTree.fromstring(draw(sketch))


def waves(root: ElementTree.Element) -> int:
    """How many wavy lines cut a part off."""
    return sum(" q " in p.get("d", "") for p in root.iter(f"{SVG}path"))


def test_a_screw_shows_nut_balls_support_and_load_with_their_words() -> None:
    sketch, root = drawn("lin-case3-offset")
    assert len(list(root.iter(f"{SVG}circle"))) == 32
    words = {"nut 54 mm, Ø 48", "screw 800 mm, Ø 32", "holds ux uy rx ry rz", "holds uy", "ux = 300 µm", "Fz 5 kN"}
    assert words < {str(t.text) for t in root.iter(f"{SVG}text")}
    assert re.search(r"lead 20 mm.*ball radii \+7 um", sketch.caption)


def test_the_stretch_about_the_nut_is_to_scale_and_long_ends_are_cut() -> None:
    sketch, root = drawn("lin-case1")
    nut = next(r for r in root.iter(f"{SVG}rect") if r.get("fill") == "#9fb4d3")
    ball = next(root.iter(f"{SVG}circle"))
    scale = float(nut.get("width", "")) / 54.0
    assert float(ball.get("r", "")) == pytest.approx(2.778 * scale, abs=0.06)
    assert waves(root) == 6  # two ends, each white with two lines
    scene = sketch.scene
    short = replace(sketch, scene=replace(scene, screw=replace(scene.screw, length=0.4 + 0.027 + 0.02)))
    assert waves(ElementTree.fromstring(draw(short))) == 3


def test_what_the_nut_hides_is_said_beside_it() -> None:
    sketch, root = drawn("unseen-four-point")
    places = {str(t.text): float(t.get("x", "")) for t in root.iter(f"{SVG}text")}
    rings = [float(r.get("x", "")) for r in root.iter(f"{SVG}rect")]
    assert places["shaft: holds rz"] > max(rings)
    assert places["Fx 1.5 kN, Fz 8 kN"] < min(rings)
    assert any(text.startswith("inner ring 18 mm") for text in places)
    assert sketch.caption.startswith("12 balls of 12.7 mm, ball bearing")


def test_arrows_point_where_loads_push() -> None:
    scene = catalogue.scene("lin-case1")
    heads = []
    for force in ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)):
        other = replace(scene, loads=(replace(scene.loads[0], force=force),))
        root = ElementTree.fromstring(draw(sketch_of(other, "s", "S")))
        (head,) = (p.get("points", "") for p in root.iter(f"{SVG}polygon") if p.get("fill") == FORCE)
        (x, y), (x1, y1), (x2, y2) = (tuple(map(float, point.split(","))) for point in head.split())
        heads.append((x - (x1 + x2) / 2, y - (y1 + y2) / 2))
    assert heads == [pytest.approx(v, abs=0.11) for v in ((9.0, 0.0), (-9.0, 0.0), (0.0, -9.0), (0.0, 9.0))]


@pytest.mark.parametrize(("name", "rings"), [("unseen-four-point", 0), ("unseen-flange", 1), ("lin-case1", 1)])
def test_the_nut_is_hatched_where_it_is_held(name: str, rings: int, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = catalogue.scene(name)
    held, outside = _held(scene, *faces(scene))
    assert (len(held), outside) == (rings, rings == 0)
    monkeypatch.setattr("rollbench.reports.sketch._held", lambda *_: ([], False))
    _, root = drawn(name)
    monkeypatch.undo()
    assert len(list(drawn(name)[1].iter(f"{SVG}line"))) > len(list(root.iter(f"{SVG}line")))


def test_nothing_leaves_the_drawing_and_inks_follow_the_page() -> None:
    for name in ("lin-case3-offset", "unseen-four-point", "unseen-63x20"):
        _, root = drawn(name)
        for text in root.iter(f"{SVG}text"):
            assert 0.0 < float(text.get("x", "")) < WIDTH
            assert text.get("fill") in (INK, FORCE)


def test_a_sheet_has_verdict_trust_sketch_and_results() -> None:
    study = Study(None)
    reference = study.reference("lin-case1")
    judged = sheets.judge(study, "lin-case1")
    text, sketch, table = sheets.sheet(study, "lin-case1", reference, judged)
    assert [type(item) for item in (text, sketch, table)] == [Text, Sketch, Table]
    begins = (
        r"Verdict: refined passes the gate's 7 %: [+−]0\.\d\d % on ball \d+ \w\w; lin fails the gate's 7 %: [+−](.+) % on"
    )
    lin = re.match(begins, text.paragraphs[0])
    gate = judge("lin", study.solve("lin-case1", "lin").load, reference, Limits())[0]  # as rollbench check
    assert float(lin[1]) == pytest.approx(abs(gate.error), abs=0.005)
    assert gate.word == "fail"
    displacement = judged["refined", "axial displacement"]
    row = next(r for r in table.rows if r["quantity"] == "axial displacement [um]")
    assert row["error-refined"] == displacement.error
    assert 100.0 * (row["refined"] / row["3D reference"] - 1.0) == pytest.approx(displacement.error)
    by_gate, of_mean = (r for r in table.rows if "worst contact load" in r["quantity"])
    assert by_gate["error-lin"] == gate.error
    assert abs(of_mean["error-lin"]) == pytest.approx(gate.of_mean.max_percent)
    assert "verdict" not in {c.key for c in table.columns}, "a tick of one model next to errors of two"
    assert f"u_val {judged['refined', 'contact loads'].combined:.2f} %" in text.paragraphs[1]
    said = sheets.conclusion({"lin-case1": judged})
    assert said.endswith("on the 1 case studies of the source, in per cent of the mean load.")
