"""Pages of a report: files, escaping, search, first screen, marks; a report written over another: what is removed, brought
back or refused."""

import csv
import math
import subprocess
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from tests.report_samples import contents, figure, report, screw, table

from rollbench.meshes.cache import record_from_bytes, record_to_bytes
from rollbench.reports import cells, field3d, pages, scene3d
from rollbench.reports.content import FieldPicture, Picture, Table, TableColumn
from rollbench.reports.pages import MARKER, SEARCH


class Page(HTMLParser):
    """Tags, attributes and text of a page; complains about unbalanced elements."""

    VOID = frozenset({"meta", "img", "br", "link", "hr", "input"})

    def __init__(self, text):
        super().__init__()
        self.elements, self.text, self.open = [], [], []
        self.feed(text)
        self.words = " ".join("".join(self.text).split())

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert tag in self.VOID or self.open.pop() == tag

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
    monkeypatch.setattr(field3d, "draw_field_picture", fail)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Folder of one report, which tests read and leave as it is."""
    return pages.write_report(report(), tmp_path_factory.mktemp("report") / "out").parent


@pytest.mark.slow
def test_figures_that_several_processes_draw_are_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(pages, "WORTH_PROCESSES", 2)
    several = report(*(figure(f"figure-{k}", title=f"Figure {k}") for k in range(3)), table())
    alone, together = (pages.write_report(several, tmp_path / str(k), processes=k).parent for k in (1, 2))
    assert contents(together) == contents(alone)
    assert len(list(together.glob("figures/*.svg"))) == 3


@pytest.mark.usefixtures("no_picture")
class TestPage:
    def test_pages_are_balanced_marked_and_load_nothing_from_elsewhere(self, written):
        found = {p.name: Page(p.read_text(encoding="utf-8")) for p in written.glob("*.html")}
        for name, page in found.items():
            assert not page.open
            assert MARKER in (written / name).read_text(encoding="utf-8")
            assert not {"link", "iframe", "object"} & {tag for tag, _ in page.elements}
            assert SEARCH in page.attributes("src")
            for file, _, view in (source.partition("#") for source in page.attributes("src")):
                assert (written / file).is_file()
                assert not view or f'<view id="{view}"' in (written / file).read_text(encoding="utf-8")
            known = page.attributes("id")
            assert len(set(known)) == len(known)
            for target in page.attributes("href"):
                file, _, anchor = target.partition("#")
                assert not file or (written / file).is_file(), target
                if anchor and (not file or file in found):
                    assert anchor in found[file or name].attributes("id")

    def test_everything_is_escaped_and_nothing_is_missing(self, written):
        page = Page("".join(p.read_text(encoding="utf-8") for p in sorted(written.glob("*.html"))))
        whole = ("Report <1>", "Sub & title", "1.2.3", "<unknown>", "First & foremost", "A < B.", "two <i>")
        items = ("Printed <and> computed", '<b>"a"</b>', "Error: 1 < 2.", "Force [N]", "no rows", "Loads & errors")
        assert [words for words in (*whole, *items) if words not in page.words] == []
        assert "b" not in {tag for tag, attrs in page.elements if attrs.get("class") == "text"}
        assert "i" not in {tag for tag, _ in page.elements}

    @pytest.mark.parametrize("picture", [screw(), FieldPicture("cube", "A cube", (), (), (), (), 2.0)])
    def test_a_picture_that_cannot_be_drawn_is_left_out_and_said_so(self, tmp_path, picture):
        lines = []
        pages.write_report(report(picture), tmp_path / "out", lines.append)
        assert "install libgl1 &amp; co" in (tmp_path / "out" / "first.html").read_text(encoding="utf-8")
        assert "libgl1" in lines[1]
        assert not list((tmp_path / "out" / "figures").iterdir())

    def test_a_drawn_picture_is_stored_and_written_as_it_is(self, tmp_path):
        drawn = record_from_bytes(record_to_bytes(Picture("cube", "A cube", np.arange(9, dtype=np.uint8))))
        pages.write_report(report(drawn), tmp_path / "out")
        assert (tmp_path / "out" / "figures" / "cube.png").read_bytes() == bytes(range(9))
        assert 'src="figures/cube.png"' in (tmp_path / "out" / "first.html").read_text(encoding="utf-8")

    def test_a_text_of_the_first_page_is_replaced_and_the_sums_agree(self, tmp_path):
        page = pages.write_report(replace(report(), origin={"date": "today"}), tmp_path / "out")
        before = page.read_text(encoding="utf-8")
        pages.replace_in_first_page(page, "<unknown>", "known & checked", {"date": "tomorrow"})
        assert page.read_text(encoding="utf-8") == before.replace("&lt;unknown&gt;", "known &amp; checked") != before
        done = subprocess.run(["sha256sum", "-c", "SHA256SUMS"], cwd=page.parent, capture_output=True, check=False)
        assert done.returncode == 0
        assert "tomorrow" in (page.parent / "manifest.json").read_text(encoding="utf-8")

    def test_same_report_same_bytes(self, tmp_path, written):
        pages.write_report(report(), tmp_path / "b")
        assert contents(written) == contents(tmp_path / "b")


class TestReplacing:
    def test_leftovers_of_an_older_report_are_removed(self, tmp_path):
        (tmp_path / "out").mkdir()  # an empty directory is taken
        pages.write_report(report(table("old"), figure("old")), tmp_path / "out")
        pages.write_report(report(table("new")), tmp_path / "out")
        files = {"index.html", "first.html", "second.html", "search.js"}
        assert set(contents(tmp_path / "out")) == files | {"tables/new.csv", "tables/empty.csv"}
        assert [entry.name for entry in tmp_path.iterdir()] == ["out"]

    @pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt])
    def test_failure_while_drawing_leaves_the_earlier_report(self, tmp_path, monkeypatch, error):
        pages.write_report(report(table()), tmp_path / "out")
        before = contents(tmp_path)
        monkeypatch.setattr(pages.figures, "draw_panels_in_column", Mock(side_effect=error))
        with pytest.raises(error):
            pages.write_report(report(table("new"), figure("new")), tmp_path / "out")
        assert contents(tmp_path) == before
        assert [entry.name for entry in tmp_path.iterdir()] == ["out"]

    @pytest.mark.parametrize(("error", "raised"), [(KeyboardInterrupt, KeyboardInterrupt), (OSError, ValueError)])
    def test_failure_while_swapping_brings_the_earlier_report_back(self, tmp_path, monkeypatch, error, raised):
        pages.write_report(report(table()), tmp_path / "out")
        before = contents(tmp_path)
        rename = Path.rename

        def fail_on_new(self, target):
            if self.name.endswith(".new"):
                raise error
            return rename(self, target)

        monkeypatch.setattr(Path, "rename", fail_on_new)
        with pytest.raises(raised):
            pages.write_report(report(table("new")), tmp_path / "out")
        assert contents(tmp_path) == before

    @pytest.mark.parametrize("name", ["notes.txt", "index.html"])
    def test_a_foreign_directory_is_refused(self, tmp_path, name):
        (tmp_path / name).write_text("<html>mine</html>", encoding="utf-8")
        with pytest.raises(ValueError, match="no rollbench report"):
            pages.write_report(report(table()), tmp_path)
        assert contents(tmp_path) == {name: b"<html>mine</html>"}

    @pytest.mark.parametrize("name", ["notes.txt", "mine.html", "tables/mine.xlsx", "figures/more/a.svg"])
    def test_a_report_with_foreign_files_in_it_is_refused(self, tmp_path, name):
        pages.write_report(report(table()), tmp_path / "out")
        mine = tmp_path / "out" / name
        mine.parent.mkdir(exist_ok=True)
        mine.write_text("mine", encoding="utf-8")
        with pytest.raises(ValueError, match="would be deleted"):
            pages.write_report(report(table()), tmp_path / "out")
        assert mine.read_text(encoding="utf-8") == "mine"
        with pytest.raises(ValueError, match="is a file"):
            pages.write_report(report(table()), mine)


CELLS = [
    (0.0, "g4", "0"),
    (-0.0123456, "g4", "−0.01235"),
    (9.9999, "g3", "10.0"),
    (2.1e8, "g4", "2.100×10⁸"),
    (None, ".2f", "–"),
    (True, "g4", "yes"),
    (np.False_, "s", "no"),
    (math.nan, ".2f", "n/a"),
    (-math.inf, "g4", "−∞"),
    ("text", ".2f", "text"),
]


class TestCells:
    @pytest.mark.parametrize(("value", "form", "text"), CELLS)
    def test_format(self, value, form, text):
        assert cells.format_cell(value, form) == text

    def test_csv(self, tmp_path):
        cells.write_csv(table(), tmp_path / "t.csv")
        raw = (tmp_path / "t.csv").read_bytes()
        assert raw.startswith(b'"Quantity, of all",Force [N],Error [%],Class,Verdict,Met\r\n')
        with open(tmp_path / "t.csv", newline="", encoding="utf-8") as stream:
            rows = list(csv.reader(stream))
        assert rows[1:] == [
            ['<b>"a"</b>', "0.3333333333", "-0.5", "hard", "reproduced", "true"],
            ["b, c", "", "nan", "open", "contradicted", "false"],
            ["two\nlines", "210000000.0", "", "as-printed", "open", "true"],
        ]


def test_rows_for_the_csv_file_only_are_in_it_and_not_on_the_page(tmp_path):
    table = Table("t", "T", {TableColumn("a", "first", format="s"): [f"x{n}" for n in range(30)]}, rows_csv_only=True)
    pages.write_report(report(table), tmp_path / "out")
    text = (tmp_path / "out" / "first.html").read_text(encoding="utf-8")
    assert ("x7" in text, "<td" in text, "30 rows" in text, "tables/t.csv" in text) == (False, False, True, True)
    assert len((tmp_path / "out" / "tables" / "t.csv").read_text(encoding="utf-8").split()) == 31
