"""Commands return answers; one printer prints them."""

import ast
from pathlib import Path

import pytest

from rollbench import compare
from rollbench.compare.text.printing import Answer, cell, print_answer

#: What writes to standard output itself: the printer, a completion script, the progress of a report.
WRITERS = {"printing.py", "completion.py", "report.py"}


def writes(path: Path) -> bool:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        called = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print"
        if (called and "file" not in [k.arg for k in node.keywords]) or getattr(node, "attr", "") == "stdout":
            return True
    return False


def test_one_module_prints_answers():
    folders = [Path(compare.__file__).with_name(name) for name in ("commands", "report", "text")]
    assert {path.name for folder in folders for path in folder.rglob("*.py") if writes(path)} == WRITERS


def test_json_is_one_value_without_its_text_and_parts_are_printed_as_they_come(capsys):
    assert print_answer(Answer(lambda: {"a": 1}, (1 // 0 for _ in (1,)), 3), as_json=True) == 3
    assert capsys.readouterr().out == '{\n  "a": 1\n}\n'

    def parts():
        yield "first"
        assert capsys.readouterr().out == "first\n"
        yield "second"

    print_answer(Answer(parts=parts()))
    assert capsys.readouterr().out == "second\n"


@pytest.mark.parametrize(
    ("value", "form", "text"),
    [(-0.001, ".2f", "0.00"), (-0.0, ".4g", "0"), (-0.004, "+.2f", "+0.00"), (-0.006, ".2f", "-0.01"), (-3, "d", "-3")],
)
def test_a_number_that_is_rounded_to_zero_has_no_minus(value: float, form: str, text: str) -> None:
    assert cell(value, form) == text
