"""Files of verdicts; what changed since earlier ones, in text, JSON and Markdown."""

import csv
import html
import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest
from markdown_it import MarkdownIt

from rollbench.compare.gate import publish
from rollbench.compare.gate.verdict import Judgement, VerdictRow


def row(word: str, error: float, quantity: str = "largest error", scene: str = "mine") -> VerdictRow:
    limit, unit = (1.0, "deg") if quantity == "contact angle" else (7.0, "%")
    return VerdictRow(scene, "a.csv", quantity, Judgement(word), error, 0.1, limit, 4, "SL", unit=unit)


def test_the_command_tells_what_changed_since_a_file_of_either_form(command, tmp_path) -> None:
    old, new = tmp_path / "old.csv", tmp_path / "gate.md"
    check = "check", "two-balls", "--no-compute"
    said = command(*check, "--model", "lin", "--csv", old, "--json").out
    (tmp_path / "old.json").write_text(said, encoding="utf-8")
    (line,) = (x for x in command(*check, "--baseline", old, "--markdown", new).out.splitlines() if x.startswith("since"))
    said = r"since old\.csv: two-balls: largest error of a contact load .* -> .* %, limit 7, fail -> pass"
    assert re.fullmatch(said, line)
    assert f"- {line}" in new.read_text(encoding="utf-8")
    assert new.with_suffix(".svg").read_text(encoding="utf-8").count("<svg") == 1
    _, data = command.json(*check, "--baseline", tmp_path / "old.json", "--json")
    (change,) = data["changed"]
    assert (change["quantity"], change["verdict"]) == ("largest error of a contact load", ["fail", "pass"])
    assert f" a contact load {' -> '.join(change['error'])} %, limit 7" in line


#: Names of scenes, models and files in which Markdown, GitHub or GitLab find markup, links, people, issues, labels.
HOSTILE = [
    "[click](https://evil.example) ![x](y.png)",
    "see https://evil.example/a?b and www.evil.example, a@evil.example",
    "@owner, @org/team and you@owner",
    "fixes #12, owner/rollbench#12, GH-12, gh-12, !12, &12, ~bug, %4, $5",
    "<img src=x onerror=y> <!-- --> <details> &lt;b&gt; &#64;owner",
    "*a* _b_ __c__ **d** ~~e~~ `f` ``g`` $h$ a_b _ \\ \\_ \\| |",
]


@pytest.mark.parametrize("name", HOSTILE)
def test_names_are_shown_as_they_are_in_markdown(name: str) -> None:
    """No markup, and nothing that hosts turn into a link or a message to a person."""
    one = replace(row("fail", 9.0, scene=name), judged=name, detail=name, near=((3, 1.0, 2.0, 0.1),))
    markdown = MarkdownIt("commonmark", {"html": True}).enable("table")
    text = publish.markdown_text([one], [name])
    inline = [child for token in markdown.parse(text) for child in token.children or ()]
    assert {child.type for child in inline} <= {"text", "text_special"}
    shown = [re.sub(r"</?\w+>", "", line) for line in markdown.render(text).replace("\u2060", "").splitlines()]
    assert [html.unescape(line) for line in shown].count(name) == 4  # scene, model, note of the row; note of the table
    before_fence = html.unescape(markdown.render(text)).partition("xychart-beta")[0]
    found = re.search(r"[@#!~%$&](?=[a-z0-9])|\bgh-\d|https?://|www\.", before_fence, re.IGNORECASE)
    assert found is None, found


def test_files_of_verdicts(monkeypatch, tmp_path) -> None:
    green = replace(row("pass", 8.5), judged="a|b", uncertainty=1.0)
    rows = [green, replace(green, judgement=Judgement.FAIL, detail="=1+1 <b>")]
    suite = ElementTree.fromstring(publish.junit_xml(rows))
    assert (suite.get("tests"), suite.get("failures")) == ("2", "1")
    none, failure = (case.find("failure") for case in suite.iter("testcase"))
    assert (none, failure.get("type")) == (None, "fail")
    assert "error %: 8.5; uncertainty %: 1; limit %: 7" in str(failure.get("message"))
    text = publish.markdown_text(rows)
    assert "<b>" not in text
    read = list(csv.reader(publish.verdicts_csv(rows).splitlines()))
    assert (read[0], read[2][-1]) == (list(publish.HEADINGS), "'=1+1 <b>")
    summary, other = tmp_path / "summary.md", tmp_path / "b.csv"
    summary.write_text("before\n", encoding="utf-8")
    files = {"markdown_file": tmp_path / "a.md", "junit_file": tmp_path / "a.xml", "csv_file": tmp_path / "a.csv"}
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(summary))
    assert set(publish.write_verdicts(rows, **files)) == {*files.values(), summary}
    assert summary.read_text(encoding="utf-8") == "before\n" + text
    assert publish.write_verdicts(rows, csv_file=other) == [other]
