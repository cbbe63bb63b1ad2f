"""Commands return answers, which one printer prints: JSON, texts and tables for terminals of any width."""

from itertools import product

import pytest

from rollbench.compare.text.printing import CommandOutput, TextTable, print_command_output

NAMES = ("ball", "side", *(f"quantity {n} / N" for n in range(9)))
ROWS = [
    (str(ball), side, *(f"{1234.5 + ball + n:.2f}" for n in range(9))) for ball, side in product(range(1, 4), ("SL", "NR"))
]


@pytest.mark.parametrize("width", [48, 60, 80])
def test_no_number_is_cut_and_every_part_names_its_rows(width: int) -> None:
    text = TextTable(NAMES, ROWS, "loads").text(width)
    assert max(map(len, text.splitlines())) <= width
    assert text.count("1236.5") == 4, "ball 1 at 1, ball 2 at 0, on both sides"
    parts = text.count("ball")
    assert parts > 1
    assert text.count("SL") == 3 * parts
    assert text.startswith("loads\n")
    assert text.count("loads") == 1


def test_table_that_fits_and_table_without_terminal_are_in_one_part() -> None:
    whole = TextTable(NAMES, ROWS, "loads", "caption")
    assert len(whole.text().splitlines()) == 1 + 1 + len(ROWS) + 1
    assert whole.text(200) == whole.text()


def test_json_is_one_value_without_its_text_and_parts_are_printed_as_they_come(capsys):
    assert print_command_output(CommandOutput(lambda: {"a": 1}, (1 // 0 for _ in (1,)), 3), as_json=True) == 3
    assert capsys.readouterr().out == '{\n  "a": 1\n}\n'

    def parts():
        yield "first"
        assert capsys.readouterr().out == "first\n"
        yield "second"

    print_command_output(CommandOutput(texts_and_tables=parts()))
    assert capsys.readouterr().out == "second\n"
