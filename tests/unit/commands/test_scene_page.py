"""The page of one scene: what stands in it, that it needs nothing from outside, and that its hashes tell what changed;
several sets on a shaft and load cases on it."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from tests.axes import ON_A_SHAFT
from tests.load_cases import written
from tests.report_samples import contents

import rollbench
from rollbench.compare.errors import ArgumentError
from rollbench.compare.report import changes, scene_page, several
from rollbench.meshes.parts import SIDES
from rollbench.reports.cells import with_typographic_signs
from rollbench.reports.scene_html import read_page_data, scene_page_html

pytestmark = pytest.mark.xdist_group("scene page")

#: Four balls: the least that a scene solves in, with stored runs of the reference.
SCENE = "two-balls"


STORES = (scene_page.shipped_store(),)


@pytest.fixture(scope="module")
def page():
    return replace(scene_page.solve_and_make_page(SCENE, STORES)[0], picture=None)


@pytest.fixture(scope="module")
def html(page) -> str:
    return scene_page_html(page)


def test_the_page_answers_first_and_needs_nothing_from_outside(page, html: str) -> None:
    assert page.verdict.startswith("The contact with the highest pressure (ball ")
    assert html.index(with_typographic_signs(page.verdict)) < html.index("<table")
    assert not re.search(r'(src|href)="(?!data:|#)', html)
    assert {part.name for part in page.parts} == {"scene", "loads", "stiffness", "error", "assumptions"}
    shown = re.sub(r"<script.*?</script>|<pre>.*?</pre>", "", html, flags=re.DOTALL)
    assert "µm" in shown
    assert not re.search(r"\bum\b", shown)
    assert page.scene_text.count(" um") == read_page_data(html)["scene"].count(" um") > 0
    assert " um" in re.search(r"<pre>.*?</pre>", html, flags=re.DOTALL)[0]
    (table,) = (i for part in page.parts for i in part.items if getattr(i, "name", "") == "contacts")
    loads = [load for ball in page.results["balls"] for load in ball["load_N"].values() if load]
    assert table.columns["load_of", "refined model"] == pytest.approx(loads)


def test_a_scene_text_cannot_end_its_block(page) -> None:
    evil = replace(page, scene_text='title = "</script><script>alert(1)</script>"', parts=())
    html = scene_page_html(evil)
    assert "<script>alert" not in html
    assert read_page_data(html)["scene"] == evil.scene_text


def test_what_moved_beyond_round_off() -> None:
    old = {"a": 1.0, "b": [1.0, 2.0], "c": {"d": "x", "e": None}}
    new = {"a": 1.0 + 1e-12, "b": [1.0, 2.2], "c": {"d": "y", "e": 1.0}}
    said = ["b[2]: 2 became 2.2 (+10 %)", "c.d: x became y", "c.e: nothing became 1.0"]
    assert list(changes.result_differences(old, new)) == said


def test_the_same_page_made_again_has_not_moved(html: str, tmp_path, monkeypatch) -> None:
    old, new = tmp_path / "old.html", tmp_path / "new"
    old.write_text(html, encoding="utf-8")
    new.mkdir()
    again, _ = scene_page.solve_and_make_page(SCENE, STORES)
    later = replace(again, picture=None, provenance={**again.provenance, "date": "later"})
    (new / "index.html").write_text(scene_page_html(later), encoding="utf-8")
    monkeypatch.setattr(changes, "write_scene_pages", lambda *_: [later])
    assert changes.write_and_compare_pages([SCENE], new, tmp_path, old).texts_and_tables[-1] == "nothing changed"


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """A report on two scenes, one of three load cases, and what the terminal is told."""
    folder = tmp_path_factory.mktemp("several")

    def without_picture(*given):
        page, found = scene_page.solve_and_make_page(*given)
        return replace(page, picture=None), found

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(several, "solve_and_make_page", without_picture)
        said = changes.write_and_compare_pages([SCENE, written(folder)], folder / "out", folder)
    return folder, said


def test_scenes_stand_side_by_side_with_the_numbers_of_their_pages(both) -> None:
    folder, said = both
    assert said.exit_code == 0
    assert sorted(path.name for path in (folder / "out").iterdir()) == ["index.html", "two-balls.html", "two.html"]
    index = (folder / "out" / "index.html").read_text(encoding="utf-8")
    assert re.findall(r'<dt><a href="(.*?)">', index) == ["two-balls.html", "two.html"]
    _, *lines = re.findall(r"<tr>(.*?)</tr>", index, flags=re.DOTALL)
    cells = {row[0]: [x.replace("−", "-") for x in row[2:]] for row in (re.findall(r"<td[^>]*>([^<]*)", x) for x in lines)}
    pages = ((folder / "out" / name).read_text(encoding="utf-8") for name in ("two-balls.html", "two.html"))
    one, cases = (read_page_data(page)["results"] for page in pages)
    summaries = [one["summary"], *(case["summary"] for case in cases["cases"])]
    for words, group, key in (
        ("largest contact load", "loads", "max_N"),
        ("peak pressure", "worst_contact", "pressure_MPa"),
        ("static safety", "static_safety", "factor"),
    ):
        values = [s[group][key] for s in summaries]
        first, *others = cells[words]
        assert [float(first), *map(float, others[::2])] == pytest.approx(values, rel=6e-4), words
        off = [100.0 * (x / values[0] - 1.0) for x in values[1:]]
        assert [float(x) for x in others[1::2]] == pytest.approx(off, abs=0.051), words


def test_a_bad_file_among_several_is_one_line_and_leaves_what_was_there(both, command, monkeypatch) -> None:
    folder, _ = both
    before = contents(folder / "out")
    monkeypatch.setattr(several, "solve_and_make_page", lambda *_: pytest.fail("work was done"))
    for out in ("out", "none"):
        assert "missing.toml" in command.refused("report", SCENE, folder / "missing.toml", "--out", folder / out)
    assert "--against" in command.refused("report", SCENE, SCENE, "--against", folder / "out", "--out", folder / "none")
    assert contents(folder / "out") == before
    assert not (folder / "none").exists()


def test_view_writes_a_file_and_shows_it(tmp_path, command, monkeypatch) -> None:
    shown: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda address: bool(shown.append(address)) or True)
    monkeypatch.setenv("BROWSER", "any")
    out = tmp_path / "a view.html"
    words = ("view", SCENE, "--model", "lin", "--out", out)
    assert str(out) in command.said(*words)
    assert shown == [out.as_uri()]
    command.said(*words, "--no-open")
    assert len(shown) == 1
    for name in ("BROWSER", "DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert ("no browser was found" in command.said(*words), len(shown)) == (True, 1)
    other = tmp_path / "notes.html"
    other.write_text("mine", encoding="utf-8")
    assert "notes.html" in command.refused("view", SCENE, "--out", other)
    assert other.read_text(encoding="utf-8") == "mine"
    assert "rollbench friction" in command.refused("view", "lin-pair-a", "--out", out)


def test_the_page_of_an_axis_has_the_numbers_of_its_results():
    page, _ = scene_page.solve_and_make_page("smith-axis-taper", STORES)
    html, solved = scene_page_html(page), rollbench.solve("smith-axis-taper")
    assert page.verdict.startswith("The contact with the highest pressure, in right 1, carries")
    tables = {item.name: item for part in page.parts for item in part.items if hasattr(item, "rows")}
    loads = [load for s in solved.sets.values() for load in s.roller_loads]
    assert tables["rollers"].columns["roller_load"] == pytest.approx(loads)
    (forces,) = (cells for head, cells in tables["sets"].columns.items() if head.label == "force on shaft N")
    shown = [float(force) for force in forces]
    assert shown == pytest.approx([s.force[2] for s in solved.sets.values()], rel=1e-3)
    view = json.loads(re.search(r'id="view-data">(.*?)</script>', html, flags=re.DOTALL)[1])
    assert [one["name"] for one in view["cases"][0]["sets"]] == [*solved.sets]


def test_the_page_of_a_double_nut_draws_loads_and_friction_nut_by_nut():
    page, found = scene_page.solve_and_make_page("double-nut", STORES)
    assert f"an error of up to {found.expected_error.loads:.1f} % of the mean load" in page.verdict
    items = {item.name: item for part in page.parts for item in part.items if hasattr(item, "name")}
    flanks = [
        f"{name}, flank {side}" for name, s in found.sets.items() for k, side in enumerate(SIDES) if s.loads[:, k].any()
    ]
    assert [panel.title for panel in items["loads"].panels] == flanks
    friction = rollbench.friction("double-nut")
    assert [panel.title for panel in items["friction"].panels] == [*found.sets]
    for number, panel in enumerate(items["friction"].panels, 1):
        for series in panel.series:
            lost = [1e3 * ball.loss[series.label] for ball in friction.balls if ball.set == number]
            assert series.y == pytest.approx(lost)
    assert next(iter(items["torques"].columns.values()))[0] == "friction torque"
    assert items["tangent"].columns["component"] == ["uz"], "no row of a held freedom"


def test_a_reference_of_several_sets_is_refused(tmp_path):
    with pytest.raises(ArgumentError, match="a single nut or bearing"):
        scene_page.solve_and_make_page(str(ON_A_SHAFT), STORES, Path(tmp_path / "any.csv"))
