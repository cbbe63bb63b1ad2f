"""The page of one scene: what stands in it, that it needs nothing from outside, and that its hashes tell what changed."""

import json
import re
from dataclasses import replace

import pytest

from rollbench.compare.report import scene_page, verify
from rollbench.reports.cells import typeset
from rollbench.reports.scene_page import read_page, render, sha256, without_manifest

pytestmark = pytest.mark.xdist_group("scene page")

#: Four balls: the least that a scene solves in, with stored runs of the reference.
SCENE = "two-balls"


STORES = (scene_page.shipped_store(),)


@pytest.fixture(scope="module")
def page():
    return replace(scene_page.page_of(SCENE, STORES), picture=None)


@pytest.fixture(scope="module")
def html(page) -> str:
    return render(page)


def test_the_page_answers_first_and_needs_nothing_from_outside(page, html: str) -> None:
    assert page.verdict.startswith("The most pressed contact (ball ")
    assert html.index(typeset(page.verdict)) < html.index("<table")
    assert [label for label, _ in page.answers][:3] == ["loads", "axial", "contact"]
    assert not re.search(r'(src|href)="(?!data:|#)', html)
    assert {part.name for part in page.parts} == {"scene", "loads", "stiffness", "error", "assumptions"}
    for name in ("table-contacts", "table-rigidity", "table-applicability", "figure-sketch", "figure-loads"):
        assert f'id="{name}"' in html
    shown = re.sub(r"<script.*?</script>|<pre>.*?</pre>", "", html, flags=re.DOTALL)
    assert "µm" in shown
    assert not re.search(r"\bum\b", shown)
    assert page.scene_text.count(" um") == read_page(html)["scene"].count(" um") > 0
    assert " um" in re.search(r"<pre>.*?</pre>", html, flags=re.DOTALL)[0]
    (table,) = (i for part in page.parts for i in part.items if getattr(i, "name", "") == "contacts")
    loads = [load for ball in page.results["balls"] for load in ball["load_N"].values() if load]
    assert [row["load"] for row in table.rows] == pytest.approx(loads)


def test_manifest_holds_until_something_is_changed(html: str) -> None:
    blocks = read_page(html)
    assert blocks["manifest"]["page"] == sha256(without_manifest(html))
    assert all(len(x) == 64 for x in blocks["manifest"]["files"].values())
    assert {row.state for row in verify.checked_page(html, blocks, STORES)} == {"ok"}
    shown = html.replace("The most pressed contact", "The least pressed contact")
    assert [row.name for row in verify.checked_page(shown, read_page(shown), STORES) if row.state == "changed"] == ["page"]
    lead = json.dumps(blocks["scene"])[1:40]
    assert lead in html
    other = html.replace(lead, lead[:-2] + "  ", 1)
    wrong = {row.name for row in verify.checked_page(other, read_page(other), STORES) if row.state == "changed"}
    assert wrong == {"page", "scene"}
    without = {**blocks, "manifest": {**blocks["manifest"], "files": {"x.json": "0"}}}
    gone = list(verify.checked_page(html, without, ()))
    assert gone[-1].state == "missing"


def test_a_scene_text_cannot_end_its_block(page) -> None:
    evil = replace(page, scene_text='title = "</script><script>alert(1)</script>"', parts=())
    html = render(evil)
    assert "<script>alert" not in html
    assert read_page(html)["scene"] == evil.scene_text


def test_verify_by_the_command_line(html: str, tmp_path, command) -> None:
    (tmp_path / "index.html").write_text(html, encoding="utf-8")
    assert "hashes hold: the same inputs and code" in command.said("verify", tmp_path)
    (tmp_path / "index.html").write_text(html.replace("carries", "bears", 1), encoding="utf-8")
    code, out, _ = command("verify", tmp_path / "index.html")
    assert (code, "changed  page" in out) == (1, True)


def test_what_moved() -> None:
    old = {"a": 1.0, "b": [1.0, 2.0], "c": {"d": "x", "e": None}, "f": True}
    assert list(verify.moved(old, old)) == []
    new = {"a": 1.0 + 1e-12, "b": [1.0, 2.2], "c": {"d": "y", "e": 1.0}, "f": False}
    assert list(verify.moved(old, new)) == [
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

    def written_later(scene: str, out, *_: object):
        again = scene_page.page_of(scene, STORES)
        later = replace(again, picture=None, provenance={**again.provenance, "date": "later"})
        (out / "index.html").write_text(render(later), encoding="utf-8")
        return later

    monkeypatch.setattr(verify, "make_page", written_later)
    found = verify.run_page(SCENE, new, tmp_path, old)
    assert (found.code, found.parts[-1]) == (0, "nothing moved")
