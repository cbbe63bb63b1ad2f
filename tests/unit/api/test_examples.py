"""The examples that are shipped run, and give what they say."""

import json
from importlib import resources
from typing import Any

import pytest

from rollbench.comparison.examples import catalogue_page, judge_a_spreadsheet


def test_a_catalogue_page_gives_stiffness_and_pressure(capsys: pytest.CaptureFixture[str]) -> None:
    solution = catalogue_page.main()
    assert solution.converged
    out = capsys.readouterr().out
    assert "N/µm" in out
    assert "MPa" in out


@pytest.mark.parametrize(("factor", "word"), [(1.08, "fail"), (1.0, "pass")])
def test_a_spreadsheet_that_is_8_percent_off_fails(factor: float, word: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert judge_a_spreadsheet.main(factor).word == word
    assert ("(ball 5 SL)" in capsys.readouterr().out) is (word == "fail")


def test_the_notebook_runs_from_top_to_bottom(monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    monkeypatch.chdir(tmp_path)
    text = resources.files("rollbench.comparison").joinpath("examples", "notebook.ipynb").read_text(encoding="utf-8")
    names: dict[str, Any] = {}
    for cell in json.loads(text)["cells"]:
        assert not cell.get("outputs")
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)
    assert names["solution"].converged
    assert names["judged"].word in ("pass", "fail")
    assert "<table>" in names["beside"]._repr_html_()
