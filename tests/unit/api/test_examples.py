"""The examples that are shipped run, and give what they say."""

import ast
import html
import json
from importlib import resources

import pytest

from rollbench.compare.examples import catalogue_page, judge_a_spreadsheet


def test_a_catalogue_page_is_solved() -> None:
    assert catalogue_page.main().converged


@pytest.mark.parametrize(("factor", "word"), [(1.08, "fail"), (1.0, "pass")])
def test_a_spreadsheet_that_is_8_percent_off_fails(factor: float, word: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert judge_a_spreadsheet.main(factor).word == word
    assert ("(ball 5 SL)" in capsys.readouterr().out) is (word == "fail")


def shown(value) -> str:
    """What a notebook keeps of the value of a cell: its table, or its text."""
    return str(value._repr_html_()) if hasattr(value, "_repr_html_") else repr(value)


def test_the_notebook_is_shipped_with_the_outputs_that_it_gives(monkeypatch: pytest.MonkeyPatch, tmp_path) -> None:
    monkeypatch.chdir(tmp_path)
    text = resources.files("rollbench.compare").joinpath("examples", "notebook.ipynb").read_text(encoding="utf-8")
    names = {}
    for cell in json.loads(text)["cells"]:
        if cell["cell_type"] == "code":
            *body, last = ast.parse("".join(cell["source"])).body
            exec(compile(ast.Module(body, []), "cell", "exec"), names)
            assert isinstance(last, ast.Expr)
            (output,) = cell["outputs"]
            kept = output["data"].get("text/html") or output["data"]["text/plain"]
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
            assert "".join(kept) == shown(value), "run: jupyter execute --inplace compare/examples/notebook.ipynb"
    page = names["result"]._repr_html_()
    assert all(html.escape(row.quantity) in page for row in names["result"].table())
