"""Cells of a row of a report's table by the keys of its columns, whatever their headings say."""

from rollbench.reports.content import Cell, Row


def cells_by_key(row: Row) -> dict[str, Cell]:
    return {column if isinstance(column, str) else column.key: cell for column, cell in row.items()}
