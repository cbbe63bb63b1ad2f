"""Pages of a report: files, escaping, search, first screen, marks; a report written over another: what is removed, brought
back or refused."""

from html.parser import HTMLParser
from pathlib import Path
from unittest.mock import Mock

import pytest
from tests.report_samples import contents, figure, report, screw, table

from rollbench.reports import field3d, pages, scene3d
from rollbench.reports import pages as html
from rollbench.reports.content import FieldPicture, Table, TableColumn
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
    monkeypatch.setattr(field3d, "draw_field_picture", fail)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Folder of one report, which tests read and leave as it is."""
    return html.write_report(report(), tmp_path_factory.mktemp("report") / "out").parent


VERDICTS = [
    *(("Reproduced", "good"), ("converged", "good"), ("not converged", "bad"), ("no convergence", "bad")),
    *(("nominal only", "other"), ("open", "open"), ("left out", "other")),
]


COLUMNS = [
    *(([7, "12"], True), (["−3.5", None, "–"], True), ([1.5e-3], True)),
    *((["7 of 9"], False), (["a"], False), ([None], False)),
]


@pytest.mark.usefixtures("no_picture")
class TestPage:
    def test_pages_are_balanced_marked_and_load_nothing_from_elsewhere(self, written):
        pages = {p.name: Page(p.read_text(encoding="utf-8")) for p in written.glob("*.html")}
        for name, page in pages.items():
            assert not page.open
            assert MARKER in (written / name).read_text(encoding="utf-8")
            assert not {"link", "iframe", "object"} & {tag for tag, _ in page.elements}
            assert SEARCH in page.attributes("src")
            assert all((written / file).is_file() for file in page.attributes("src"))
            known = page.attributes("id")
            assert len(set(known)) == len(known)
            for target in page.attributes("href"):
                file, _, anchor = target.partition("#")
                assert not file or (written / file).is_file(), target
                if anchor and (not file or file in pages):
                    assert anchor in pages[file or name].attributes("id")

    @pytest.mark.parametrize(("rows", "folded"), [(12, False), (30, True)])
    def test_a_long_table_is_folded_with_all_its_rows_and_columns(self, tmp_path, rows, folded):
        keys = [*"abcdefghij", "verdict"]
        all_of = [TableColumn(k, k, format="s") for k in keys]
        html.write_report(
            report(Table("t", "T", all_of, [dict.fromkeys(keys, f"x{n}") for n in range(rows)])), tmp_path / "out"
        )
        text = (tmp_path / "out" / "first.html").read_text(encoding="utf-8")
        assert (text.count("<tr>"), text.count("<th ")) == (rows + 1, len(keys))
        assert ("<details" in text) is folded
        assert (tmp_path / "out" / "tables" / "t.csv").read_text(encoding="utf-8").count("\n") == rows + 1

    def test_everything_is_escaped_and_nothing_is_missing(self, written):
        page = Page("".join(p.read_text(encoding="utf-8") for p in sorted(written.glob("*.html"))))
        whole = ("Report <1>", "Sub & title", "1.2.3", "<unknown>", "First & foremost", "A < B.", "two <i>")
        tables = ("Table printed. Printed <and> computed", '<b>"a"</b>', "Error: 1 < 2.", "Force [N]", "no rows")
        others = ("Table empty. None", "Figure loads. Loads & errors. Axial load.")
        assert [words for words in (*whole, *tables, *others) if words not in page.words] == []
        assert "b" not in {tag for tag, attrs in page.elements if attrs.get("class") == "text"}
        assert "i" not in {tag for tag, _ in page.elements}

    @pytest.mark.parametrize("picture", [screw(), FieldPicture("cube", "A cube", (), (), (), (), 2.0)])
    def test_a_picture_that_cannot_be_drawn_is_left_out_and_said_so(self, tmp_path, picture):
        lines = []
        html.write_report(report(picture), tmp_path / "out", lines.append)
        page = (tmp_path / "out" / "first.html").read_text(encoding="utf-8")
        assert "This picture could not be drawn. install libgl1 &amp; co" in page
        assert lines[0] == "report: [1/2] First & foremost"
        assert "libgl1" in lines[1]
        assert not list((tmp_path / "out" / "figures").iterdir())

    def test_same_report_same_bytes(self, tmp_path, written):
        html.write_report(report(), tmp_path / "b")
        assert contents(written) == contents(tmp_path / "b")


UNFIT = [((table(), table("Printed")), "twice"), ((figure("../up"),), "letters, digits")]


class TestReplacing:
    def test_leftovers_of_an_older_report_are_removed(self, tmp_path):
        (tmp_path / "out").mkdir()  # an empty directory is taken
        html.write_report(report(table("old"), figure("old")), tmp_path / "out")
        html.write_report(report(table("new")), tmp_path / "out")
        files = {"index.html", "first.html", "second.html", "search.js"}
        assert set(contents(tmp_path / "out")) == files | {"tables/new.csv", "tables/empty.csv"}
        assert [entry.name for entry in tmp_path.iterdir()] == ["out"]

    @pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt])
    def test_failure_while_drawing_leaves_the_earlier_report(self, tmp_path, monkeypatch, error):
        html.write_report(report(table()), tmp_path / "out")
        before = contents(tmp_path)
        monkeypatch.setattr(pages.figures, "draw_figure", Mock(side_effect=error))
        with pytest.raises(error):
            html.write_report(report(table("new"), figure("new")), tmp_path / "out")
        assert contents(tmp_path) == before
        assert [entry.name for entry in tmp_path.iterdir()] == ["out"]

    @pytest.mark.parametrize(("error", "raised"), [(KeyboardInterrupt, KeyboardInterrupt), (OSError, ValueError)])
    def test_failure_while_swapping_brings_the_earlier_report_back(self, tmp_path, monkeypatch, error, raised):
        html.write_report(report(table()), tmp_path / "out")
        before = contents(tmp_path)
        rename = Path.rename

        def fail_on_new(self, target):
            if self.name.endswith(".new"):
                raise error
            return rename(self, target)

        monkeypatch.setattr(Path, "rename", fail_on_new)
        with pytest.raises(raised):
            html.write_report(report(table("new")), tmp_path / "out")
        assert contents(tmp_path) == before

    @pytest.mark.parametrize("name", ["notes.txt", "index.html"])
    def test_a_foreign_directory_is_refused(self, tmp_path, name):
        (tmp_path / name).write_text("<html>mine</html>", encoding="utf-8")
        with pytest.raises(ValueError, match="no rollbench report"):
            html.write_report(report(table()), tmp_path)
        assert contents(tmp_path) == {name: b"<html>mine</html>"}

    @pytest.mark.parametrize("name", ["notes.txt", "mine.html", "tables/mine.xlsx", "figures/more/a.svg"])
    def test_a_report_with_foreign_files_in_it_is_refused(self, tmp_path, name):
        html.write_report(report(table()), tmp_path / "out")
        mine = tmp_path / "out" / name
        mine.parent.mkdir(exist_ok=True)
        mine.write_text("mine", encoding="utf-8")
        with pytest.raises(ValueError, match="would be deleted"):
            html.write_report(report(table()), tmp_path / "out")
        assert mine.read_text(encoding="utf-8") == "mine"
        with pytest.raises(ValueError, match="is a file"):
            html.write_report(report(table()), mine)

    @pytest.mark.parametrize(("items", "words"), UNFIT)
    def test_unfit_names_are_refused(self, tmp_path, items, words):
        with pytest.raises(ValueError, match=words):
            html.write_report(report(*items), tmp_path / "out")
        assert not list(tmp_path.iterdir())
