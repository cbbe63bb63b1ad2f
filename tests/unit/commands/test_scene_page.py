"""The page of one scene: what stands in it, that it needs nothing from outside, and that its hashes tell what changed."""

import json
import re
from dataclasses import replace

import pytest
from tests.load_cases import written

from rollbench.compare.report import scene_page, several, verify
from rollbench.meshes.parts import SIDES
from rollbench.reports.cells import with_typographic_signs
from rollbench.reports.scene_page import html_without_manifest, read_page_data, scene_page_html, sha256

pytestmark = pytest.mark.xdist_group("scene page")

#: Four balls: the least that a scene solves in, with stored runs of the reference.
SCENE = "two-balls"


STORES = (scene_page.shipped_store(),)


@pytest.fixture(scope="module")
def page():
    return replace(scene_page.solve_and_make_page(SCENE, STORES), picture=None)


@pytest.fixture(scope="module")
def html(page) -> str:
    return scene_page_html(page)


def test_the_page_answers_first_and_needs_nothing_from_outside(page, html: str) -> None:
    assert page.verdict.startswith("The contact with the highest pressure (ball ")
    assert html.index(with_typographic_signs(page.verdict)) < html.index("<table")
    assert [row["quantity"] for row in page.table.rows][:2] == ["largest contact load", "mean contact load"]
    assert not re.search(r'(src|href)="(?!data:|#)', html)
    assert {part.name for part in page.parts} == {"scene", "loads", "stiffness", "error", "assumptions"}
    for name in ("table-contacts", "table-rigidity", "table-applicability", "figure-sketch", "figure-loads"):
        assert f'id="{name}"' in html
    shown = re.sub(r"<script.*?</script>|<pre>.*?</pre>", "", html, flags=re.DOTALL)
    assert "µm" in shown
    assert not re.search(r"\bum\b", shown)
    assert page.scene_text.count(" um") == read_page_data(html)["scene"].count(" um") > 0
    assert " um" in re.search(r"<pre>.*?</pre>", html, flags=re.DOTALL)[0]
    (table,) = (i for part in page.parts for i in part.items if getattr(i, "name", "") == "contacts")
    loads = [load for ball in page.results["balls"] for load in ball["load_N"].values() if load]
    assert [row["load"] for row in table.rows] == pytest.approx(loads)


def test_manifest_holds_until_something_is_changed(html: str) -> None:
    blocks = read_page_data(html)
    assert blocks["manifest"]["page"] == sha256(html_without_manifest(html))
    assert all(len(x) == 64 for x in blocks["manifest"]["files"].values())
    assert {row.comparison_result for row in verify.check_page_hashes(html, blocks, STORES)} == {"ok"}
    shown = html.replace("The contact with the highest", "The contact with the lowest")
    assert [
        row.name
        for row in verify.check_page_hashes(shown, read_page_data(shown), STORES)
        if row.comparison_result == "changed"
    ] == ["page"]
    lead = json.dumps(blocks["scene"])[1:40]
    assert lead in html
    other = html.replace(lead, lead[:-2] + "  ", 1)
    wrong = {
        row.name
        for row in verify.check_page_hashes(other, read_page_data(other), STORES)
        if row.comparison_result == "changed"
    }
    assert wrong == {"page", "scene"}
    without = {**blocks, "manifest": {**blocks["manifest"], "files": {"x.json": "0"}}}
    gone = list(verify.check_page_hashes(html, without, ()))
    assert gone[-1].comparison_result == "missing"


def test_a_scene_text_cannot_end_its_block(page) -> None:
    evil = replace(page, scene_text='title = "</script><script>alert(1)</script>"', parts=())
    html = scene_page_html(evil)
    assert "<script>alert" not in html
    assert read_page_data(html)["scene"] == evil.scene_text


def test_verify_by_the_command_line(html: str, tmp_path, command) -> None:
    (tmp_path / "index.html").write_text(html, encoding="utf-8")
    assert "hashes hold: the same inputs and code" in command.said("verify", tmp_path)
    (tmp_path / "index.html").write_text(html.replace("carries", "bears", 1), encoding="utf-8")
    code, out, _ = command("verify", tmp_path / "index.html")
    assert (code, "changed  page" in out) == (1, True)


def test_what_moved() -> None:
    old = {"a": 1.0, "b": [1.0, 2.0], "c": {"d": "x", "e": None}, "f": True}
    assert list(verify.result_differences(old, old)) == []
    new = {"a": 1.0 + 1e-12, "b": [1.0, 2.2], "c": {"d": "y", "e": 1.0}, "f": False}
    assert list(verify.result_differences(old, new)) == [
        "b[2]: 2 became 2.2 (+10 %)",
        "c.d: x became y",
        "c.e: nothing became 1.0",
        "f: True became False",
    ]


def test_the_same_page_made_again_has_not_moved(html: str, tmp_path, monkeypatch) -> None:
    old, new = tmp_path / "old", tmp_path / "new"
    for folder in (old, new):
        folder.mkdir()
    (old / "index.html").write_text(html, encoding="utf-8")

    def written_later(scenes, out, *_: object):
        again = scene_page.solve_and_make_page(*scenes, STORES)
        later = replace(again, picture=None, provenance={**again.provenance, "date": "later"})
        (out / "index.html").write_text(scene_page_html(later), encoding="utf-8")
        return [later]

    monkeypatch.setattr(verify, "write_scene_pages", written_later)
    found = verify.write_and_compare_pages([SCENE], new, tmp_path, old)
    assert (found.exit_code, found.texts_and_tables[-1]) == (0, "nothing changed")


def test_the_page_can_be_turned_and_says_what_its_results_say(html: str) -> None:
    view = json.loads(re.search(r'id="view-data">(.*?)</script>', html, flags=re.DOTALL)[1])
    (one,) = view["cases"][0]["sets"]
    balls = read_page_data(html)["results"]["balls"]
    assert len(one["places"]) == len(balls)
    sizes = [[sum(x * x for x in force) ** 0.5 for force in row] for row in one["forces"]]
    assert sizes == [pytest.approx([ball["load_N"][side] for side in SIDES], rel=1e-5) for ball in balls]
    assert one["reference"]["label"] == "3D reference"


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """A report on two scenes, one of three load cases, and what the terminal is told."""
    folder = tmp_path_factory.mktemp("several")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            several, "solve_and_make_page", lambda *given: replace(scene_page.solve_and_make_page(*given), picture=None)
        )
        said = verify.write_and_compare_pages([SCENE, written(folder)], folder / "out", folder)
    return folder, said


def test_scenes_stand_side_by_side_with_the_numbers_of_their_pages(both) -> None:
    folder, said = both
    assert said.exit_code == 0
    assert sorted(path.name for path in (folder / "out").iterdir()) == ["index.html", "two-balls.html", "two.html"]
    index = (folder / "out" / "index.html").read_text(encoding="utf-8")
    assert re.findall(r'<dt><a href="(.*?)">', index) == ["two-balls.html", "two.html"]
    head, *lines = re.findall(r"<tr>(.*?)</tr>", index, flags=re.DOTALL)
    assert re.findall(r"<th[^>]*>([^<]*)", head)[2:] == ["two-balls", "two, balls", "two, push", "two, loose"]
    cells = {row[0]: row[2:] for row in (re.findall(r"<td[^>]*>([^<]*)", line) for line in lines)}
    files = (folder / "out" / name for name in ("two-balls.html", "two.html"))
    one, cases = (read_page_data(path.read_text(encoding="utf-8"))["results"] for path in files)
    summaries = [one["summary"], *(case["summary"] for case in cases["cases"])]
    for words, group, key in (
        ("loads: max", "loads", "max_N"),
        ("worst contact: pressure", "worst_contact", "pressure_MPa"),
        ("static safety: factor", "static_safety", "factor"),
    ):
        assert [float(x) for x in cells[words]] == pytest.approx([s[group][key] for s in summaries], rel=6e-4), words
    life = cells["life of all cases: L10"]
    assert (life[0], float(life[1])) == ("–", pytest.approx(cases["summary"]["life"]["L10_million_revolutions"], rel=6e-4))


def test_the_first_page_says_when_another_one_was_changed(both, command) -> None:
    folder, _ = both
    assert "hashes hold: the same inputs and code" in command.said("verify", folder / "out")
    page = folder / "out" / "two.html"
    text = page.read_text(encoding="utf-8")
    page.write_text(text.replace("carries", "bears", 1), encoding="utf-8")
    code, out, _ = command("verify", folder / "out")
    page.write_text(text, encoding="utf-8")
    assert (code, "changed  two.html" in out) == (1, True)


def test_a_bad_file_among_several_is_one_line_and_leaves_what_was_there(both, command, monkeypatch) -> None:
    folder, _ = both
    before = {path.name: path.read_bytes() for path in (folder / "out").iterdir()}
    monkeypatch.setattr(several, "solve_and_make_page", lambda *_: pytest.fail("work was done"))
    assert "missing.toml" in command.refused("report", SCENE, folder / "missing.toml", "--out", folder / "out")
    assert "missing.toml" in command.refused("report", SCENE, folder / "missing.toml", "--out", folder / "none")
    assert "--against" in command.refused("report", SCENE, SCENE, "--against", folder / "out", "--out", folder / "none")
    assert {path.name: path.read_bytes() for path in (folder / "out").iterdir()} == before
    assert not (folder / "none").exists()


def test_files_of_equal_names_have_pages_of_their_own() -> None:
    assert several._page_file_names(["a/x.toml", "b/X.toml", "index.toml", "x y.toml"]) == [
        "x.html",
        "X-2.html",
        "index-2.html",
        "x-y.html",
    ]


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
