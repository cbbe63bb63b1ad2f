"""Drawing and writing of reports: record kinds, escaping, files, determinism, and that nothing is lost."""

import csv
import json
import math
import re
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from reports import cells, figures, html, pages, scene3d
from reports.pages import SEARCH
from reports.panels import draw_parts
from reports.records import Column, Figure, LoadedScrew, Panel, Report, Section, Series, Summary, Table, Text

SVG = "{http://www.w3.org/2000/svg}"
PNG_START = b"\x89PNG\r\n\x1a\n"


def figure(name="loads", **changes):
    ball = [1, 2, 3, 4]
    curves = (
        Series("computed", ball, [210.0, 220.0, 230.0, 225.0], emphasis=True),
        Series("printed", ball, [211.0, 219.0, math.nan, 226.0], "markers"),
        Series("source", ball, [212.0, 222.0, 232.0, 227.0], "line"),
        Series("95 % band", ball, [200.0, 210.0, 220.0, 215.0], "band", [220.0, 230.0, 240.0, 235.0]),
    )
    panels = (
        Panel("Case <1>", "ball number", "normal force [N]", curves, integer_x=True, zero=True),
        Panel("Error", "load [N]", "error [–]", [Series("computed", [1, 10, 1e6], [1e-9, 0.0, 1e-3])], log="xy"),
    )
    return Figure(**{"name": name, "title": "Loads & errors", "panels": panels, "caption": "Axial load."} | changes)


def table(name="printed"):
    columns = (
        Column("q", "Quantity, of all", format="s"),
        Column("force", "Force", "N"),
        Column("error", "Error", "%", ".2f"),
        Column("class", "Class", format="s"),
        Column("verdict", "Verdict", format="s"),
        Column("ok", "Met"),
    )
    rows = (
        {"q": '<b>"a"</b>', "force": 1.0 / 3.0, "error": -0.5, "class": "hard", "verdict": "reproduced", "ok": True},
        {"q": "b, c", "force": None, "error": math.nan, "class": "open", "verdict": "not reproduced", "ok": False},
        {"q": "two\nlines", "force": np.float64(2.1e8), "class": "as-printed", "verdict": "open", "ok": np.True_},
    )
    return Table(name, "Printed <and> computed", columns, rows, note="Error: 1 < 2.")


def screw(lead=0.02, groove_radius=0.003254):
    turns = 2 if lead else 1
    phi = (np.arange(16 * turns) - 8 * turns) * 2.0 * np.pi / 16
    track, ball, position = 0.0165, 0.002778, 0.4
    path = np.linspace(phi[0], phi[-1], 100)

    def on_track(azimuth):
        height = position + lead * azimuth / (2.0 * np.pi)
        return np.stack([track * np.cos(azimuth), track * np.sin(azimuth), height], axis=1)

    radial = np.stack([np.cos(phi), np.sin(phi), np.zeros_like(phi)], axis=1)
    line = (radial + np.array([0.0, 0.0, 1.0])) / np.sqrt(2.0)
    force = 225.0 + 8.0 * np.cos(phi)[:, None]
    return LoadedScrew(
        name="screw",
        title="The loaded screw",
        screw_length=0.8,
        screw_radius=0.016,
        nut_position=position,
        nut_length=0.054,
        nut_radius=0.024,
        track_radius=track,
        ball_radius=ball,
        ball_radii_centres=on_track(phi),
        ball_loads=force[:, 0],
        helix=on_track(path),
        contact_points=np.concatenate([on_track(phi) - ball * line, on_track(phi) + ball * line]),
        contact_forces=np.concatenate([force * line, -force * line]),
        groove_radius=groove_radius,
        lead=lead,
        caption="Arrows are forces.",
    )


def report(*items):
    sections = (
        Section("first", "First & foremost", items or (Text(["A < B."]), table(), figure())),
        Section(
            "second", "Second", (Text(["one", "two <i>"], bullets=True), Table("empty", "None", [Column("a", "A")], []))
        ),
    )
    provenance = {"Version": "1.2.3", "Machine": "<unknown>"}
    return Report("Report <1>", "Sub & title", provenance, sections, {"case.toml": "abc123"})


class Page(HTMLParser):
    """Tags, attributes and text of a page; complains about unbalanced elements."""

    VOID = frozenset({"meta", "img", "br", "link", "hr", "input"})

    def __init__(self, text):
        super().__init__()
        self.elements, self.text, self.open = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)

    def attributes(self, name):
        return [attrs[name] for _, attrs in self.elements if name in attrs]


@pytest.fixture
def no_picture(monkeypatch):
    """Stands in for the 3D picture: one that cannot be drawn on this machine."""

    def fail(_, path):
        Path(path).write_bytes(b"half a picture")
        raise RuntimeError("install libgl1 & co")

    monkeypatch.setattr(scene3d, "draw_loaded_screw", fail)


def contents(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


class TestFigures:
    def test_same_data_same_bytes(self):
        assert figures.draw(figure()) == figures.draw(figure())

    def test_no_date_and_no_version_in_the_file(self):
        svg = figures.draw(figure())
        assert "dc:date" not in svg
        assert "matplotlib.org" not in svg

    def test_is_well_formed_and_shows_labels_and_escapes(self):
        root = ElementTree.fromstring(figures.draw(figure()))
        words = {"".join(element.itertext()) for element in root.iter(f"{SVG}text")}
        assert {"Case <1>", "normal force [N]", "computed", "printed", "source", "95 % band"} <= words
        assert "10⁻³" in words

    def test_identifiers_of_two_figures_do_not_meet_and_references_resolve(self):
        svgs = [figures.draw(figure(name)) for name in ("one", "two")]
        ids = [set(re.findall(r'\bid="([^"]+)"', svg)) for svg in svgs]
        assert ids[0]
        assert not ids[0] & ids[1]
        for svg, known in zip(svgs, ids, strict=True):
            used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', svg))
            assert used
            assert used <= known

    def test_data_change_the_drawing(self):
        other = Panel("Case <1>", "ball number", "normal force [N]", [Series("computed", [1, 2], [1.0, 5.0])])
        assert figures.draw(figure(panels=[other])) != figures.draw(figure())

    def test_equal_labels_have_equal_numbers_in_all_panels(self):
        def panel(*labels):
            return Panel("", "", "", [Series(label, [], []) for label in labels])

        first, second = figures._orders([panel("a", "b", "c"), panel("d", "c")])
        assert first["c"] == second["c"]
        assert sorted(first.values()) == [0, 1, 2]
        assert sorted(second.values()) == [0, 1]

    @pytest.mark.parametrize("count", [1, 3, 4, 6])
    def test_up_to_six_panels(self, count):
        panels = [figure().panels[number % 2] for number in range(count)]
        root = ElementTree.fromstring(figures.draw(figure(panels=panels, columns=3)))
        axes = [e for e in root.iter(f"{SVG}g") if re.fullmatch(r"fig-loads-axes_\d+", e.get("id", ""))]
        assert len(axes) == count

    @pytest.mark.parametrize("log", ["", "x", "y", "xy"])
    @pytest.mark.parametrize("values", [[], [math.nan, math.nan], [0.0, 0.0], [-1.0, -2.0], [3.0, 3.0]])
    def test_poor_data_are_drawn_without_warning(self, log, values):
        x = [float(number) for number in range(len(values))]
        panel = Panel("t", "x", "y", [Series("s", x, values)], log=log, zero=True)
        ElementTree.fromstring(figures.draw(figure(panels=[panel])))

    @pytest.mark.parametrize(
        ("series", "log", "words"),
        [
            (Series("s", [1, 2], [1]), "", "2 x values but 1 y"),
            (Series("s", [1], [1], "dots"), "", "style is 'dots'"),
            (Series("s", [1], [1], "band"), "", "needs y2"),
            (Series("s", [1], [1]), "z", "log is 'z'"),
        ],
    )
    def test_refuses_inconsistent_curves(self, series, log, words):
        with pytest.raises(ValueError, match=words):
            figures.draw(figure(panels=[Panel("t", "x", "y", [series], log=log)]))

    @pytest.mark.parametrize("count", [0, 7])
    def test_refuses_wrong_number_of_panels(self, count):
        with pytest.raises(ValueError, match=f"{count} panels"):
            figures.draw(figure(panels=[figure().panels[0]] * count))


class TestPanels:
    def test_values_lie_on_the_curves_and_the_panel_holds_them(self):
        drawn = draw_parts(figure())
        assert drawn.whole == figures.draw(figure())
        assert len(drawn.panels) == 2
        first = ElementTree.fromstring(drawn.panels[0])
        left, top, width, height = map(float, first.get("viewBox").split())
        marks = [(float(c.get("cx")), float(c.get("cy")), c[0].text) for c in first.iter(f"{SVG}circle")]
        assert len(marks) == 4 + 3 + 4 + 4  # the one that is no number is not drawn
        assert all(left < x < left + width and top < y < top + height for x, y, _ in marks)
        assert "computed\n1\n210" in [text for *_, text in marks]
        uses = [(float(u.get("x")), float(u.get("y"))) for u in first.iter(f"{SVG}use")]
        x, y, _ = next(m for m in marks if m[2] == "computed\n1\n210")
        assert min(math.hypot(x - a, y - b) for a, b in uses) < 0.1

    def test_a_legend_of_all_panels_is_an_element_of_its_own(self):
        drawn = draw_parts(figure(panels=[figure().panels[0]] * 2))
        words = "".join(ElementTree.fromstring(drawn.legend).itertext())
        assert all(label in words for label in ("computed", "printed", "source", "95 % band"))
        assert "legend" not in "".join(drawn.panels)
        assert draw_parts(figure()).legend == ""

    def test_colours_are_the_page_s_to_set_and_references_resolve(self):
        drawn = draw_parts(figure())
        text = "".join(drawn.panels)
        assert {"var(--ink, #222222)", "var(--paper, #ffffff)", "var(--c0, #0072b2)"} <= set(
            re.findall(r"var\([^)]*\)", text)
        )
        assert "var(" not in drawn.whole
        used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', text))
        assert used <= set(re.findall(r'\bid="([^"]+)"', text))

    def test_texts_stand_beside_their_points_and_apart(self):
        x, y = [1.0, 1.1, 1.2, 90.0], [5.0, 5.01, 5.02, 0.1]
        named = Series("s", x, y, "markers", texts=["one", "two", "three", "far"], light=False)
        panel = Panel("", "x", "y", [named], log="xy")
        root = ElementTree.fromstring(draw_parts(figure(panels=[panel], size=(5.0, 3.0))).panels[0])
        found = {"".join(t.itertext()): t for t in root.iter(f"{SVG}text")}
        heights = sorted(_place(found[name])[1] for name in ("one", "two", "three"))
        assert min(np.diff(heights)) > 9.0
        points = [float(c.get("cx")) for c in root.iter(f"{SVG}circle")]
        assert _place(found["one"])[0] < min(points)
        assert _place(found["far"])[0] > max(points)

    def test_texts_and_names_must_fit_the_points(self):
        for extra in ({"texts": ["a"]}, {"names": ["a"]}):
            with pytest.raises(ValueError, match=r"1 (texts|names) for 2 points"):
                figures.draw(figure(panels=[Panel("", "x", "y", [Series("s", [1, 2], [1, 2], **extra)])]))


def _place(text):
    """Where an SVG text stands."""
    if text.get("x"):
        return float(text.get("x")), float(text.get("y"))
    return tuple(float(v) for v in re.search(r"translate\(([-\d.]+)[ ,]+([-\d.]+)", text.get("transform"))[1:])


class TestCells:
    @pytest.mark.parametrize(
        ("value", "form", "text"),
        [
            (0.0, "g4", "0"),
            (225.0, "g4", "225.0"),
            (-0.0123456, "g4", "−0.01235"),
            (9.9999, "g3", "10.0"),
            (208000.0, "g4", "208000"),
            (2.1e8, "g4", "2.100×10⁸"),
            (-1.5e-12, "g3", "−1.50×10⁻¹²"),
            (1234567, "g4", "1234567"),
            (-3.14159, ".2f", "−3.14"),
            (np.float64(2.5), ".1f", "2.5"),
            (None, ".2f", "–"),
            (True, "g4", "yes"),
            (np.False_, "s", "no"),
            (math.nan, ".2f", "n/a"),
            (-math.inf, "g4", "−∞"),
            ("as-printed", "s", "as-printed"),
            ("text", ".2f", "text"),
        ],
    )
    def test_format(self, value, form, text):
        assert html.format_cell(value, form) == text

    def test_csv(self, tmp_path):
        html.write_csv(table(), tmp_path / "t.csv")
        raw = (tmp_path / "t.csv").read_bytes()
        assert raw.startswith(b'"Quantity, of all",Force [N],Error [%],Class,Verdict,Met\r\n')
        with open(tmp_path / "t.csv", newline="", encoding="utf-8") as stream:
            rows = list(csv.reader(stream))
        assert float(rows[1][1]) == 1.0 / 3.0
        assert rows[1] == ['<b>"a"</b>', repr(1.0 / 3.0), "-0.5", "hard", "reproduced", "true"]
        assert rows[2] == ["b, c", "", "nan", "open", "not reproduced", "false"]
        assert rows[3] == ["two\nlines", "210000000.0", "", "as-printed", "open", "true"]
        assert len(rows) == 4


@pytest.mark.usefixtures("no_picture")
class TestPage:
    def test_files(self, tmp_path):
        assert html.write(report(), tmp_path / "out") == tmp_path / "out" / "index.html"
        files = {name.removeprefix("out/") for name in contents(tmp_path)}
        pages = {"index.html", "first.html", "second.html", "search.js"}
        assert files == pages | {"tables/printed.csv", "tables/empty.csv", "figures/loads.svg"}
        assert (tmp_path / "out" / "figures" / "loads.svg").read_text(encoding="utf-8") == figures.draw(figure())

    def test_pages_are_balanced_marked_and_load_nothing_from_elsewhere(self, tmp_path):
        html.write(report(), tmp_path / "out")
        pages = {p.name: Page(p.read_text(encoding="utf-8")) for p in (tmp_path / "out").glob("*.html")}
        for name, page in pages.items():
            assert not page.open
            assert html.MARKER in (tmp_path / "out" / name).read_text(encoding="utf-8")
            assert not {"link", "iframe", "object"} & {tag for tag, _ in page.elements}
            assert page.attributes("src") == [SEARCH]
            known = page.attributes("id")
            assert len(set(known)) == len(known)
            for target in page.attributes("href"):
                file, _, anchor = target.partition("#")
                assert not file or (tmp_path / "out" / file).is_file(), target
                if anchor and (not file or file in pages):
                    assert anchor in pages[file or name].attributes("id")

    def test_every_title_and_table_is_found_by_the_search(self, tmp_path):
        html.write(report(), tmp_path / "out")
        text = (tmp_path / "out" / SEARCH).read_text(encoding="utf-8")
        entries = json.loads(text.removeprefix("window.rollbenchSearch = ").strip().removesuffix(";"))
        assert [(e["t"], e["h"]) for e in entries] == [
            ("First & foremost", "first.html"),
            ("Printed <and> computed", "first.html#table-printed"),
            ("Loads & errors", "first.html#figure-loads"),
            ("Second", "second.html"),
            ("None", "second.html#table-empty"),
        ]
        assert "two lines" in entries[1]["x"]
        assert "A < B." in entries[0]["x"]

    def test_first_screen_comes_before_all_else(self, tmp_path):
        small = figure("small", panels=figure().panels[:1])
        summary = Summary("How far?", "So far: 2 um.", small, figure("narrow", panels=small.panels), ["all"], ["none"])
        made = report()
        made = replace(made, sections=(replace(made.sections[0], summary=summary), made.sections[1]))
        index = Page(html.write(made, tmp_path / "out").read_text(encoding="utf-8"))
        text = " ".join("".join(index.text).split())
        places = [
            text.index(words)
            for words in ("How far?", "So far: 2 µm.", "Case <1>", "What this covers", "Sub & title", "Where the")
        ]
        assert places == sorted(places)
        assert (tmp_path / "out" / "figures" / "small.svg").is_file()
        assert len({i for i in index.attributes("id") if i.startswith("fig-")}) > 10

    def test_an_appendix_stands_under_its_own_heading(self, tmp_path):
        made = report()
        made = replace(made, sections=(made.sections[0], replace(made.sections[1], appendix=True)))
        html.write(made, tmp_path / "out")
        text = (tmp_path / "out" / "first.html").read_text(encoding="utf-8")
        assert text.index("first.html") < text.index(">Appendix<") < text.index("second.html")
        html.write(report(), tmp_path / "out")
        assert ">Appendix<" not in (tmp_path / "out" / "first.html").read_text(encoding="utf-8")

    def test_everything_is_escaped_and_nothing_is_missing(self, tmp_path):
        html.write(report(), tmp_path / "out")
        page = Page("".join(p.read_text(encoding="utf-8") for p in sorted((tmp_path / "out").glob("*.html"))))
        text = " ".join("".join(page.text).split())
        for words in (
            "Report <1>",
            "Sub & title",
            "1.2.3",
            "<unknown>",
            "First & foremost",
            "A < B.",
            "two <i>",
            "Table 1. Printed <and> computed",
            "Table 2. None",
            "Figure 1. Loads & errors. Axial load.",
            '<b>"a"</b>',
            "Error: 1 < 2.",
            "Force [N]",
            "case.toml",
            "abc123",
            "no rows",
            "95 % band 2 210 to 230",
        ):
            assert words in text, words
        assert "b" not in {tag for tag, attrs in page.elements if attrs.get("class") == "text"}
        assert "i" not in {tag for tag, _ in page.elements}

    def test_classes_and_verdicts_are_marked(self, tmp_path):
        html.write(report(), tmp_path / "out")
        page = Page((tmp_path / "out" / "first.html").read_text(encoding="utf-8"))
        marks = [attrs["class"] for tag, attrs in page.elements if tag == "span" and "class" in attrs]
        wanted = ["tag tag-hard", "verdict verdict-good", "tag tag-open", "verdict verdict-bad"]
        wanted += ["tag tag-as-printed", "verdict verdict-open"]
        assert [mark for mark in marks if mark.startswith(("tag", "verdict"))] == wanted

    @pytest.mark.parametrize(
        ("text", "kind"),
        [
            ("Reproduced", "good"),
            ("converged", "good"),
            ("not converged", "bad"),
            ("no convergence", "bad"),
            ("nominal only", "other"),
            ("open", "open"),
            ("left out", "other"),
        ],
    )
    def test_verdicts(self, text, kind):
        assert cells.verdict(text) == kind

    def test_a_picture_that_cannot_be_drawn_is_left_out_and_said_so(self, tmp_path):
        lines = []
        html.write(report(screw()), tmp_path / "out", lines.append)
        page = (tmp_path / "out" / "first.html").read_text(encoding="utf-8")
        assert "This picture was left out. install libgl1 &amp; co" in page
        assert lines[0] == "report: 1/2 First & foremost"
        assert "libgl1" in lines[1]
        assert not list((tmp_path / "out" / "figures").iterdir())

    def test_a_picture_is_a_file_of_its_own(self, tmp_path, monkeypatch):
        monkeypatch.setattr(scene3d, "draw_loaded_screw", lambda _, path: path.write_bytes(PNG_START))
        html.write(report(screw()), tmp_path / "out")
        page = Page((tmp_path / "out" / "first.html").read_text(encoding="utf-8"))
        assert page.attributes("src") == ["figures/screw.png", SEARCH]
        assert (tmp_path / "out" / "figures" / "screw.png").read_bytes() == PNG_START

    def test_columns_without_an_entry_are_left_out_and_named(self, tmp_path):
        columns = (Column("a", "ball", format="s"), Column("b", "as printed"), Column("c", "claim", format="s"))
        rows = [{"a": 7, "b": None, "c": "words"}, {"a": "12", "b": None, "c": "more"}]
        html.write(report(Table("t", "T", columns, rows)), tmp_path / "out")
        page = (tmp_path / "out" / "first.html").read_text(encoding="utf-8")
        assert page.count("<th ") == 2 + page.count('class="text">A</th>')
        assert "No row has an entry under: as printed." in page
        assert (tmp_path / "out" / "tables" / "t.csv").read_text(encoding="utf-8").startswith("ball,as printed,claim")

    @pytest.mark.parametrize(
        ("cells_", "number"),
        [
            ([7, "12"], True),
            (["−3.5", None, "–"], True),
            ([1.5e-3], True),
            (["7 of 9"], False),
            (["a"], False),
            ([None], False),
        ],
    )
    def test_whole_numbers_and_numbers_as_text_are_set_to_the_right(self, cells_, number):
        column = Column("a", "a", format="s")
        assert cells.is_number(column, Table("t", "T", (column,), [{"a": c} for c in cells_])) is number

    def test_same_report_same_bytes(self, tmp_path):
        html.write(report(), tmp_path / "a")
        html.write(report(), tmp_path / "b")
        assert contents(tmp_path / "a") == contents(tmp_path / "b")


class TestReplacing:
    def test_leftovers_of_an_older_report_are_removed(self, tmp_path):
        html.write(report(table("old"), figure("old")), tmp_path / "out")
        html.write(report(table("new")), tmp_path / "out")
        pages = {"index.html", "first.html", "second.html", "search.js"}
        assert set(contents(tmp_path / "out")) == pages | {"tables/new.csv", "tables/empty.csv"}
        assert [entry.name for entry in tmp_path.iterdir()] == ["out"]

    @pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt])
    def test_failure_while_drawing_leaves_the_earlier_report(self, tmp_path, monkeypatch, error):
        html.write(report(), tmp_path / "out")
        before = contents(tmp_path)

        def fail(_):
            raise error

        monkeypatch.setattr(pages, "draw_parts", fail)
        with pytest.raises(error):
            html.write(report(table("new"), figure("new")), tmp_path / "out")
        assert contents(tmp_path) == before
        assert [entry.name for entry in tmp_path.iterdir()] == ["out"]

    @pytest.mark.parametrize(("error", "raised"), [(KeyboardInterrupt, KeyboardInterrupt), (OSError, ValueError)])
    def test_failure_while_swapping_brings_the_earlier_report_back(self, tmp_path, monkeypatch, error, raised):
        html.write(report(), tmp_path / "out")
        before = contents(tmp_path)
        rename = Path.rename

        def fail_on_new(self, target):
            if self.name.endswith(".new"):
                raise error
            return rename(self, target)

        monkeypatch.setattr(Path, "rename", fail_on_new)
        with pytest.raises(raised):
            html.write(report(table("new")), tmp_path / "out")
        assert contents(tmp_path) == before

    def test_an_empty_directory_is_taken(self, tmp_path):
        (tmp_path / "out").mkdir()
        assert html.write(report(), tmp_path / "out").is_file()

    @pytest.mark.parametrize("name", ["notes.txt", "index.html"])
    def test_a_foreign_directory_is_refused(self, tmp_path, name):
        (tmp_path / name).write_text("<html>mine</html>", encoding="utf-8")
        with pytest.raises(ValueError, match="holds no rollbench report"):
            html.write(report(), tmp_path)
        assert contents(tmp_path) == {name: b"<html>mine</html>"}

    @pytest.mark.parametrize("name", ["notes.txt", "mine.html", "tables/mine.xlsx", "figures/more/a.svg"])
    def test_a_report_with_foreign_files_in_it_is_refused(self, tmp_path, name):
        html.write(report(), tmp_path / "out")
        mine = tmp_path / "out" / name
        mine.parent.mkdir(exist_ok=True)
        mine.write_text("mine", encoding="utf-8")
        with pytest.raises(ValueError, match="would be lost"):
            html.write(report(), tmp_path / "out")
        assert mine.read_text(encoding="utf-8") == "mine"

    def test_a_file_is_refused(self, tmp_path):
        (tmp_path / "out").write_text("mine", encoding="utf-8")
        with pytest.raises(ValueError, match="is a file"):
            html.write(report(), tmp_path / "out")

    @pytest.mark.parametrize(
        ("items", "words"), [((table(), table("Printed")), "given twice"), ((figure("../up"),), "letters, digits")]
    )
    def test_unfit_names_are_refused(self, tmp_path, items, words):
        with pytest.raises(ValueError, match=words):
            html.write(report(*items), tmp_path / "out")
        assert not list(tmp_path.iterdir())


class TestScene:
    def test_groove_holds_the_balls_and_leaves_the_lands(self):
        picture = screw()
        grooves = scene3d._grooves(picture)
        centres = np.asarray(picture.ball_radii_centres)
        phi, z = np.arctan2(centres[:, 1], centres[:, 0]), centres[:, 2]
        under = grooves.surface(phi, z, picture.screw_radius)
        gap = picture.track_radius - picture.ball_radius - under
        assert np.all(gap > 0.0)
        assert np.all(gap < 0.15e-3)
        assert np.all(grooves.surface(phi, z, 0.017) - (picture.track_radius + picture.ball_radius) > 0.0)
        np.testing.assert_allclose(grooves.surface(phi, z + 0.5 * picture.lead, picture.screw_radius), 0.016)

    def test_starts_are_read_off_the_balls(self):
        one = screw()
        turned = np.asarray(one.ball_radii_centres) * np.array([-1.0, -1.0, 1.0])
        both = np.concatenate([one.ball_radii_centres, turned])
        two = LoadedScrew(**{**vars(one), "ball_radii_centres": both, "ball_loads": [1.0] * len(both)})
        assert len(scene3d._grooves(one).phases) == 1
        grooves = scene3d._grooves(two)
        assert len(grooves.phases) == 2
        azimuth = np.arctan2(both[:, 1], both[:, 0])
        assert np.all(grooves.surface(azimuth, both[:, 2], one.screw_radius) < one.track_radius - one.ball_radius)

    @pytest.mark.parametrize(
        ("low", "high", "expected"),
        [(215.1, 230.1, (215.0, 235.0, 5)), (0.0, 100.0, (0.0, 100.0, 5)), (5.0, 5.0, (4.5, 5.5, 5))],
    )
    def test_colour_scale_has_round_ends(self, low, high, expected):
        first, last, labels = scene3d._round_scale(low, high)
        assert first <= low <= high <= last
        assert (first, last) == pytest.approx(expected[:2])
        assert labels == expected[2]

    @pytest.mark.parametrize(
        ("changes", "words"),
        [
            ({"ball_loads": [1.0]}, "32 balls but 1 loads"),
            ({"contact_forces": [[0.0, 0.0, 1.0]]}, "64 contact points but 1 forces"),
            ({"helix": [[0.0, 0.0, 0.0]]}, "at least two"),
            ({"contact_points": [[0.0, math.nan, 0.0]]}, "must be finite"),
        ],
    )
    def test_refuses_arrays_that_do_not_belong_together(self, tmp_path, changes, words):
        with pytest.raises(ValueError, match=words):
            scene3d.draw_loaded_screw(LoadedScrew(**{**vars(screw()), **changes}), tmp_path / "s.png")

    @pytest.mark.parametrize(
        ("code", "stderr", "words"),
        [
            (-11, b"", "no off-screen OpenGL.*libegl1 libgl1 libxrender1"),
            (1, b"ImportError: libGL.so.1: cannot open", "libGL.so.1.*libgl1"),
            (1, b"Traceback\nTypeError: odd", "TypeError: odd"),
        ],
    )
    def test_says_why_a_picture_cannot_be_drawn(self, tmp_path, monkeypatch, code, stderr, words):
        def run(command, **_):
            return subprocess.CompletedProcess(command, code, b"", stderr)

        monkeypatch.setattr(subprocess, "run", run)
        with pytest.raises(RuntimeError, match=words):
            scene3d.draw_loaded_screw(screw(), tmp_path / "s.png")

    @pytest.mark.slow
    @pytest.mark.parametrize("lead", [0.02, 0.0])
    def test_picture_without_a_display(self, tmp_path, monkeypatch, lead):
        monkeypatch.delenv("DISPLAY", raising=False)
        try:
            scene3d.draw_loaded_screw(screw(lead=lead), tmp_path / "s.png")
        except RuntimeError as error:
            if "libgl1" in str(error):
                pytest.skip(str(error))
            raise
        data = (tmp_path / "s.png").read_bytes()
        assert data.startswith(PNG_START)
        assert (int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")) == scene3d.SIZE
        assert len(data) > 50_000


def test_records_import_neither_matplotlib_nor_pyvista():
    heavy = "{'matplotlib', 'pyvista', 'vtk', 'jinja2'}"
    code = f"import sys, reports.records; print(sorted({heavy} & set(sys.modules)))"
    root = Path(html.__file__).parents[1]
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=root)
    assert done.stdout.strip() == "[]"
