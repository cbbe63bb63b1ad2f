"""The manual: its workflow, paths and links that it names, and the errors that it states."""

import csv
import re

import pytest
import yaml
from tests.copies import ROOT, of_report

from rollbench.compare.cli import app_with_commands

DOCS = ROOT / "docs"
#: Pages of the manual, and those that a reader opens first.
PAGES = [*sorted(DOCS.rglob("*.md")), *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"))]


def steps_that_use(steps, action):
    return [step for step in steps if action in step.get("uses", "")]


def test_the_gate_hands_the_action_what_it_knows() -> None:
    gate = yaml.safe_load((DOCS / "gate.yml").read_text(encoding="utf-8"))["jobs"]["gate"]["steps"]
    kept = steps_that_use(gate, "actions/upload-artifact@")
    assert [step["if"] for step in kept] == ["always()"]
    action = yaml.safe_load((ROOT / ".github/actions/check/action.yml").read_text(encoding="utf-8"))
    assert [step["with"]["path"] for step in kept] == [action["inputs"]["report"]["default"]]
    (judged,) = [set(step["with"]) for step in steps_that_use(gate, "/.github/actions/check")]
    assert {name for name, one in action["inputs"].items() if one.get("required")} <= judged <= set(action["inputs"])
    script = next(step["run"] for step in action["runs"]["steps"] if step.get("id") == "check")
    known = {name for x in app_with_commands("check")["check"].assemble_argument_collection() for name in x.names}
    assert set(re.findall(r"--[\w-]+", script)) <= known


@of_report
@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_named_files_exist(page) -> None:
    text = page.read_text(encoding="utf-8")
    for named in re.findall(r"`((?:lowfi|hifi|compare|meshes|reports|tests|docs)/[\w./*-]+)`", text):
        assert list(ROOT.glob(named.rstrip("/"))), named
    for target in re.findall(r"\]\((?!\.\./\.\./actions/)([^)#:]+?)(?:#[^)]*)?\)", text):
        file = page.parent / target
        assert file.exists() or file.stem in ("commands", "quantities", "scene-file", "misprints"), target


@of_report
@pytest.mark.parametrize(("page", "model"), [("refined-model", "refined"), ("beam-model", "lin")])
def test_errors_of_models_on_their_page_and_the_first_are_the_report_s(page: str, model: str) -> None:
    judged = (ROOT / "reports/validation/tables/stability-unseen.csv").read_text(encoding="utf-8")
    rows = csv.DictReader(judged.splitlines())
    row = next(r for r in rows if (r["model"], r["screws"]) == (model, "drawn later"))
    names = ("median", "95th percentile")
    median, most = (
        next(float(v) for k, v in row.items() if k.startswith(f"largest contact-load error, {n}")) for n in names
    )
    first, text = ((DOCS / file).read_text(encoding="utf-8") for file in ("index.md", f"theory/{page}.md"))
    for words in (f"{median:.1f} %", f"{row['number of screws']} screws"):
        assert words in re.sub(r"\s+", " ", first)
    assert f"{median:.1f} %" in text
    assert re.search(rf"{most:.2g} %\s+at the\s+95th percentile", text)
