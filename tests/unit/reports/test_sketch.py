"""Sketches of scenes: what they show, where, and that a sheet has sketch, inputs, result and verdict."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest

from rollbench.compare.scenes import catalogue
from rollbench.compare.sections.sheets import sketch_scene
from rollbench.reports.content import Sketch
from rollbench.reports.sketch import FORCE, INK, WIDTH, draw_sketch

SVG = "{http://www.w3.org/2000/svg}"


def drawn(name: str) -> tuple[Sketch, ElementTree.Element]:
    sketch = sketch_scene(catalogue.scene(name), "s", "S")
    return sketch, ElementTree.fromstring(draw_sketch(sketch))


def test_a_screw_shows_nut_balls_support_and_load_with_their_words() -> None:
    sketch, root = drawn("lin-case3-offset")
    assert len(list(root.iter(f"{SVG}circle"))) == 32
    words = {"nut 54 mm, Ø 48", "screw 800 mm, Ø 32", "fixes ux uy rx ry rz", "fixes uy", "ux = 300 µm", "Fz 5 kN"}
    assert words < {str(t.text) for t in root.iter(f"{SVG}text")}
    assert re.search(r"lead 20 mm.*ball radii \+7 um", sketch.caption)


def test_arrows_point_where_loads_push() -> None:
    scene = catalogue.scene("lin-case1")
    heads = []
    for force in ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)):
        other = replace(scene, loads=(replace(scene.loads[0], force=force),))
        root = ElementTree.fromstring(draw_sketch(sketch_scene(other, "s", "S")))
        (head,) = (p.get("points", "") for p in root.iter(f"{SVG}polygon") if p.get("fill") == FORCE)
        (x, y), (x1, y1), (x2, y2) = (tuple(map(float, point.split(","))) for point in head.split())
        heads.append((x - (x1 + x2) / 2, y - (y1 + y2) / 2))
    assert heads == [pytest.approx(v, abs=0.11) for v in ((9.0, 0.0), (-9.0, 0.0), (0.0, -9.0), (0.0, 9.0))]


def test_nothing_leaves_the_drawing_and_inks_follow_the_page() -> None:
    for name in ("lin-case3-offset", "unseen-four-point", "unseen-63x20"):
        _, root = drawn(name)
        for text in root.iter(f"{SVG}text"):
            assert 0.0 < float(text.get("x", "")) < WIDTH
            assert text.get("fill") in (INK, FORCE)
