"""Commands return answers, which one printer prints: JSON, texts and tables for terminals of any width."""

import io
from itertools import product

import pytest
from rich.box import HEAVY_HEAD
from rich.console import Console
from rich.table import Table

from rollbench.compare.text.printing import CommandOutput, print_command_output, split_to_width


def balls(*, ruled: bool) -> Table:
    table = Table(title="loads", box=HEAVY_HEAD if ruled else None)
    for k, name in enumerate(("ball", "side", *(f"quantity {n} / N" for n in range(9)))):
        table.add_column(name, justify="right", no_wrap=k > 9)
    for ball, side in product(range(1, 4), ("SL", "NR")):
        table.add_row(str(ball), side, *(f"{1234.5 + ball + n:.2f}" for n in range(9)))
    return table


def shown(table: Table, width: int) -> str:
    stream = io.StringIO()
    Console(file=stream, width=width).print(table)
    return stream.getvalue()


@pytest.mark.parametrize("ruled", [True, False])
@pytest.mark.parametrize("width", [48, 60, 80])
def test_no_number_is_cut_and_every_part_names_its_rows(width: int, *, ruled: bool) -> None:
    parts = split_to_width(balls(ruled=ruled), width)
    texts = [shown(part, width) for part in parts]
    assert len(parts) > 1
    assert "…" not in "".join(texts)
    assert max(len(line.rstrip()) for text in texts for line in text.splitlines()) <= width
    assert sum(text.count("1236.5") for text in texts) == 4, "ball 1 at 1, ball 2 at 0, on both sides"
    assert all("ball" in text and text.count("SL") == 3 for text in texts)
    assert [("loads" in text) for text in texts] == [True] + [False] * (len(texts) - 1)


def test_json_is_one_value_without_its_text_and_parts_are_printed_as_they_come(capsys):
    assert print_command_output(CommandOutput(lambda: {"a": 1}, (1 // 0 for _ in (1,)), 3), as_json=True) == 3
    assert capsys.readouterr().out == '{\n  "a": 1\n}\n'

    def parts():
        yield "first"
        assert capsys.readouterr().out == "first\n"
        yield "second"

    print_command_output(CommandOutput(texts_and_tables=parts()))
    assert capsys.readouterr().out == "second\n"
