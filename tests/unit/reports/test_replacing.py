"""A report written over another: what is removed, brought back or refused."""

from pathlib import Path

import pytest
from tests.report_samples import contents, figure, report, table

from rollbench.reports import html, pages


class TestReplacing:
    def test_leftovers_of_an_older_report_are_removed(self, tmp_path):
        html.write(report(table("old"), figure("old")), tmp_path / "out")
        html.write(report(table("new")), tmp_path / "out")
        pages = {"index.html", "first.html", "second.html", "search.js"}
        assert set(contents(tmp_path / "out")) == pages | {"tables/new.csv", "tables/empty.csv"}
        assert [entry.name for entry in tmp_path.iterdir()] == ["out"]

    @pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt])
    def test_failure_while_drawing_leaves_the_earlier_report(self, tmp_path, monkeypatch, error):
        html.write(report(table()), tmp_path / "out")
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
        html.write(report(table()), tmp_path / "out")
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
        assert html.write(report(table()), tmp_path / "out").is_file()

    @pytest.mark.parametrize("name", ["notes.txt", "index.html"])
    def test_a_foreign_directory_is_refused(self, tmp_path, name):
        (tmp_path / name).write_text("<html>mine</html>", encoding="utf-8")
        with pytest.raises(ValueError, match="holds no rollbench report"):
            html.write(report(table()), tmp_path)
        assert contents(tmp_path) == {name: b"<html>mine</html>"}

    @pytest.mark.parametrize("name", ["notes.txt", "mine.html", "tables/mine.xlsx", "figures/more/a.svg"])
    def test_a_report_with_foreign_files_in_it_is_refused(self, tmp_path, name):
        html.write(report(table()), tmp_path / "out")
        mine = tmp_path / "out" / name
        mine.parent.mkdir(exist_ok=True)
        mine.write_text("mine", encoding="utf-8")
        with pytest.raises(ValueError, match="would be lost"):
            html.write(report(table()), tmp_path / "out")
        assert mine.read_text(encoding="utf-8") == "mine"

    def test_a_file_is_refused(self, tmp_path):
        (tmp_path / "out").write_text("mine", encoding="utf-8")
        with pytest.raises(ValueError, match="is a file"):
            html.write(report(table()), tmp_path / "out")

    @pytest.mark.parametrize(
        ("items", "words"), [((table(), table("Printed")), "given twice"), ((figure("../up"),), "letters, digits")]
    )
    def test_unfit_names_are_refused(self, tmp_path, items, words):
        with pytest.raises(ValueError, match=words):
            html.write(report(*items), tmp_path / "out")
        assert not list(tmp_path.iterdir())
