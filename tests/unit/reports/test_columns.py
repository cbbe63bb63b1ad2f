"""Columns of the report's tables: their file, and tables made of them."""

import pytest

from rollbench.reports.cells import format_cell
from rollbench.reports.content import Table, _entries_of_columns, table_column


@pytest.mark.parametrize("name", _entries_of_columns())
def test_every_format_shows_a_number(name):
    column = table_column((name, "5", "6"))
    assert format_cell(2, column.format)
    assert "{" not in column.label + column.format


def test_a_table_takes_heading_unit_and_format_from_the_file():
    table = Table.from_rows("t", "T", [{"ball": 1, ("load_of", "3D reference"): 2.5}, {"ball": 2, "flank": "SL"}])
    heads = [(head.label, head.unit, head.format) for head in table.heads.values()]
    assert heads == [("ball", "", "g4"), ("contact load, 3D reference", "N", ".1f"), ("flank", "", "s")]
    assert table.columns == {"ball": [1, 2], ("load_of", "3D reference"): [2.5, None], "flank": [None, "SL"]}
    assert table_column(("value_low_order", "6")).format == "g6"
    assert table.rows[1] == {"ball": 2, ("load_of", "3D reference"): None, "flank": "SL"}


def test_a_column_that_the_file_does_not_have_is_refused():
    with pytest.raises(KeyError, match="bal"):
        Table("t", "T", {"bal": [1]})
    with pytest.raises(ValueError, match="different lengths"):
        Table("t", "T", {"ball": [1], "flank": []})
    with pytest.raises(IndexError):
        table_column("load_of")
