"""Commands return answers; one printer prints them."""

import pytest

from rollbench.compare.text.printing import CommandOutput, format_cell, print_command_output


def test_json_is_one_value_without_its_text_and_parts_are_printed_as_they_come(capsys):
    assert print_command_output(CommandOutput(lambda: {"a": 1}, (1 // 0 for _ in (1,)), 3), as_json=True) == 3
    assert capsys.readouterr().out == '{\n  "a": 1\n}\n'

    def parts():
        yield "first"
        assert capsys.readouterr().out == "first\n"
        yield "second"

    print_command_output(CommandOutput(texts_and_tables=parts()))
    assert capsys.readouterr().out == "second\n"


@pytest.mark.parametrize(
    ("value", "form", "text"),
    [(-0.001, ".2f", "0.00"), (-0.0, ".4g", "0"), (-0.004, "+.2f", "+0.00"), (-0.006, ".2f", "-0.01"), (-3, "d", "-3")],
)
def test_a_number_that_is_rounded_to_zero_has_no_minus(value: float, form: str, text: str) -> None:
    assert format_cell(value, form) == text
