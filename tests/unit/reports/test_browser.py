"""The report in a real browser, Debian's Chromium: no message on its console, search, contents, dark mode, widths.

One start of the browser opens every page at both widths in frames of one page, works on them and writes what it found.
"""

import json
import re
from html import unescape
from pathlib import Path

import pytest
from tests.processes import ran
from tests.report_samples import CHROMIUM, WITH_CHROMIUM, paged

from rollbench.reports.content import Figure, Panel, Report, Section, Series, Summary, Table, TableColumn, Text
from rollbench.reports.pages import write_report

pytestmark = [WITH_CHROMIUM, pytest.mark.xdist_group("browser"), pytest.mark.slow]
WIDTHS = {1400: 900, 390: 844}
PAGES = ("index.html", "loads.html", "tables.html")
#: Opens the pages, waits, works on each, and writes what it found into itself.
WORK = (Path(__file__).parent / "work.html").read_text(encoding="utf-8")


def small_report() -> Report:
    curves = (Series("refined", [1.0, 2.0, 3.0], [210.0, 220.5, 230.0]), Series("lin", [1.0, 2.0], [200.0, 260.0]))
    panels = (Panel("SL", "ball", "load / N", curves), Panel("NR", "ball", "load / N", curves))
    wide = Table("wide", "All of it", {TableColumn(f"c{k}", f"a long heading {k}"): [1e3] for k in range(24)})
    narrow = Table("narrow", "Tightness of balls", {TableColumn("a", "a"): [1.0]})
    panels = (*panels, Panel("both", "ball", "load / N", curves))
    first = Figure("first", "Error against time", panels[:1], columns=1)
    summary = Summary("How far?", [("How far", "As far as 2.6 % after 1 s. " * 6)], first, ["all"], ["none"])
    sections = (
        Section(
            "loads",
            "Loads",
            (Text(["Words."]), Figure("three", "Loads", panels), Figure("two", "Loads", panels[:2])),
            summary=summary,
        ),
        Section("tables", "Tables", (wide, narrow)),
    )
    return Report("A report", "On what", {"a": "b"}, paged(*sections))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Holds the report, and the page that works on its pages."""
    folder = tmp_path_factory.mktemp("browser")
    write_report(small_report(), folder / "out")
    constants = f"const FOLDER = 'out/', PAGES = {json.dumps(PAGES)}, WIDTHS = {json.dumps(list(WIDTHS.items()))};"
    (folder / "work.html").write_text(WORK.replace("<script>", f"<script>{constants}", 1), encoding="utf-8")
    return folder


@pytest.fixture(scope="module", params=["light", "dark"])
def seen(request, folder):
    """What the browser found, page by page, and what it wrote on its console."""
    scheme = 0 if request.param == "dark" else 1
    command = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--allow-file-access-from-files"]
    command += [f"--blink-settings=preferredColorScheme={scheme}", f"--user-data-dir={folder / request.param}"]
    command += ["--enable-logging=stderr", "--virtual-time-budget=20000", "--dump-dom", (folder / "work.html").as_uri()]
    done = ran(*command, timeout=120)
    result = re.search(r'<pre id="found">(.*?)</pre>', done.stdout, re.DOTALL)
    assert result is not None, done.stderr[-2000:]
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    return request.param, json.loads(unescape(result[1])), console


def test_both_widths_have_no_overflow_a_figure_that_can_be_read_on_a_phone_and_nothing_on_the_console(seen):
    _, pages, console = seen
    assert console == []
    assert len(pages) == len(PAGES) * len(WIDTHS)
    assert {name: page["overflow"] for name, page in pages.items() if page["overflow"] > 0} == {}
    wide, phone = (pages[f"loads.html {width}"] for width in WIDTHS)
    assert [image["file"].partition("#")[0] for image in wide["images"]] == ["three.svg"] * 4 + ["two.svg"] * 3
    assert len({image["width"] for image in wide["images"][:3]}) == 1, "panels side by side, the legend below"
    assert all(300 < image["width"] < 390 for image in phone["images"]), "each panel fills a phone's width"


def test_first_screen_answers_without_scrolling_and_tables_fit(seen):
    for width, height in WIDTHS.items():
        assert 200 < seen[1][f"index.html {width}"]["bottom"] < height
        assert seen[1][f"tables.html {width}"]["clipped"] == [width > 390, False], "on a phone the wide one is a list"


def test_contents_and_bar_stay_and_search_finds_on_other_pages(seen):
    for name, page in seen[1].items():
        assert (page["stays"], page["contents"], page.get("menu", True)) == (0, name.endswith("1400"), True)
        assert (page["hits"], page["none"]) == (["tables.html#table-narrow"], "nothing found")


def test_colours_follow_the_system_and_the_switch(seen):
    scheme, pages, _ = seen
    light, dark = "rgb(255, 255, 255)", "rgb(21, 24, 29)"
    for page in pages.values():
        assert (page["paper"], page["switched"]) == ((dark, light) if scheme == "dark" else (light, dark))
