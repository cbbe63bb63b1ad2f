"""Cells and tables: numbers as text, CSV files, verdicts, alignment, and light records."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from tests.processes import python
from tests.report_samples import table

from rollbench.reports import cells, content
from rollbench.reports.content import Table, TableColumn
from rollbench.reports.pages import table_template_data

CELLS = [
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
            ['<b>"a"</b>', repr(1.0 / 3.0), "-0.5", "hard", "reproduced", "true"],
            ["b, c", "", "nan", "open", "contradicted", "false"],
            ["two\nlines", "210000000.0", "", "as-printed", "open", "true"],
        ]


def test_two_columns_of_one_heading_are_refused():
    columns = (content.TableColumn("a", "interval", "N", "s"), content.TableColumn("b", "interval", "um", "s"))
    content.Table("t", "intervals of two units", columns, [])
    with pytest.raises(ValueError, match="'interval'"):
        content.Table("t", "intervals", (*columns, content.TableColumn("c", "interval", "um", "s")), [])


def test_records_import_neither_matplotlib_nor_pyvista():
    heavy = "{'matplotlib', 'pyvista', 'vtk', 'jinja2'}"
    code = f"import sys, rollbench.reports.content; print(sorted({heavy} & set(sys.modules)))"
    assert python("-c", code, cwd=Path(cells.__file__).parents[1]).stdout.strip() == "[]"


def test_a_column_for_the_csv_file_only_is_in_it_and_not_on_the_page(tmp_path):
    (tmp_path / "tables").mkdir()
    shown, apart = TableColumn("a", "first"), TableColumn("b", "second")
    found = table_template_data(Table("t", "T", (shown, apart), [{"a": 1.0, "b": 2.0}], csv_only=["b"]), tmp_path)
    assert [column["label"] for column in found["columns"]] == ["first"]
    assert (tmp_path / "tables" / "t.csv").read_text(encoding="utf-8").split() == ["first,second", "1.0,2.0"]
    assert "second" in found["note"]
