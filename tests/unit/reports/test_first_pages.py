"""The PDF of the first two pages: written with the report where typst is installed, and its lack is said."""

import re
import sys
import zlib
from dataclasses import replace

import pytest
from tests.report_samples import paged

from rollbench.reports import first_pages, html
from rollbench.reports.content import Figure, Panel, Quantity, Report, Section, Series, Summary, Table

FIGURE = Figure("error-time", "Error against run time", (Panel("", "s", "%", (Series("lin", [1.0], [2.0]),)),), "In um.")
COLUMNS = (Quantity("name", "name", "", "s"), Quantity("x", "largest error", "% of mean", ".2f"), Quantity("gone", "empty"))
TABLE = Table("models", "Models over all scenes", COLUMNS, ({"name": 'a "b" #c *d* [e] \\ um', "x": 1.234},), "A note.")
NARROW = replace(FIGURE, name="narrow")
SUMMARY = Summary("How far?", "Up to 2 um.", FIGURE, NARROW, ["covers #this"], ["limits *that*"], TABLE)
OVERVIEW = Section("overview", "Overview", (), summary=SUMMARY)
REPORT = Report("a report", "", {"rollbench": "1.0", "date": "a day"}, paged(OVERVIEW))


def test_pages_hold_question_answer_table_and_limits_as_they_are_written():
    data = first_pages._data(REPORT, SUMMARY)
    assert (data["question"], data["answer"], data["origin"]) == ("How far?", "Up to 2 µm.", "rollbench 1.0, date a day")
    assert [c["label"] for c in data["columns"]] == ["name", "largest error"]
    assert data["rows"] == [['a "b" #c *d* [e] \\ µm', "1.23"]]
    assert (data["coverage"], data["limits"]) == (["covers #this"], ["limits *that*"])
    assert data["caption"] == "Error against run time. In µm."


def test_a_report_has_a_pdf_of_two_pages_and_may_be_replaced(tmp_path):
    pytest.importorskip("typst", reason="the PDF is written by typst, which is optional")
    page = html.write(REPORT, tmp_path / "report")
    pdf = (page.parent / first_pages.FILE).read_bytes()
    streams = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pdf, re.DOTALL)
    inner = pdf + b"".join(zlib.decompress(s) for s in streams if s[:1] == b"x")
    assert len(re.findall(rb"/Type\s*/Page\b", inner)) == 2
    assert f'href="{first_pages.FILE}"' in page.read_text(encoding="utf-8")
    html.check_target(page.parent)


def test_without_typst_the_report_is_whole_and_says_what_installs_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "typst", None)
    said = []
    page = html.write(REPORT, tmp_path / "report", said.append)
    assert not (page.parent / first_pages.FILE).exists()
    assert first_pages.FILE not in page.read_text(encoding="utf-8")
    assert any(first_pages.FILE in line and "pip install typst" in line for line in said)
