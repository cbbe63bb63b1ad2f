"""The manual: pages that the program writes, its workflow, and paths and links that it names."""

import csv
import re

import pytest
import yaml
from tests.copies import ROOT, docs_module, of_report

pytestmark = pytest.mark.xdist_group("manual")

DOCS = ROOT / "docs"
#: Pages of the manual, and those that a reader opens first.
PAGES = [*sorted(DOCS.rglob("*.md")), *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"))]
drawings, generate = map(docs_module, ("drawings", "generate"))


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory):
    folder = tmp_path_factory.mktemp("reference")
    generate.pages(folder)
    return folder


@pytest.mark.slow
def test_reference_has_commands_keys_and_quantities_with_their_units(written) -> None:
    texts = {
        name: (written / f"{name}.md").read_text(encoding="utf-8") for name in ("commands", "scene-file", "quantities")
    }
    expected = {
        "commands": [f"## `rollbench {name}`" for name in ("solve", "compare", "check", "friction", "doctor")],
        "scene-file": ["[track]", "sets", "[nut.flange]", "[cases"],
        "quantities": ["| `nut.secant_N_per_um` | N/µm |", "| `loads.worst_ball` | – |", "`loads.max_N`"],
    }
    assert [(name, words) for name, many in expected.items() for words in many if words not in texts[name]] == []
    assert "Table B.1" in (written / "misprints.md").read_text(encoding="utf-8")


def steps_that_use(steps, action):
    return [step for step in steps if action in step.get("uses", "")]


@pytest.mark.slow
def test_the_gate_hands_the_action_what_it_knows(written) -> None:
    gate = yaml.safe_load((DOCS / "gate.yml").read_text(encoding="utf-8"))["jobs"]["gate"]["steps"]
    kept = steps_that_use(gate, "actions/upload-artifact@")
    assert [step["if"] for step in kept] == ["always()"]
    action = yaml.safe_load((ROOT / ".github/actions/check/action.yml").read_text(encoding="utf-8"))
    assert [step["with"]["path"] for step in kept] == [action["inputs"]["report"]["default"]]
    (judged,) = [set(step["with"]) for step in steps_that_use(gate, "/.github/actions/check")]
    assert {name for name, one in action["inputs"].items() if one.get("required")} <= judged <= set(action["inputs"])
    script = next(step["run"] for step in action["runs"]["steps"] if step.get("id") == "check")
    check = (written / "commands.md").read_text(encoding="utf-8").partition("## `rollbench check`")[2].partition("\n## ")[0]
    assert [option for option in re.findall(r"--[\w-]+", script) if option not in check] == []


@of_report
@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_named_files_exist(page) -> None:
    text = page.read_text(encoding="utf-8")
    for named in re.findall(r"`((?:lowfi|hifi|compare|meshes|reports|tests|docs)/[\w./*-]+)`", text):
        assert list(ROOT.glob(named.rstrip("/"))), named
    for target in re.findall(r"\]\((?!\.\./\.\./actions/)([^)#:]+?)(?:#[^)]*)?\)", text):
        file = page.parent / target
        assert file.exists() or file.stem in ("commands", "quantities", "scene-file", "misprints"), target


@pytest.mark.slow
def test_every_drawing_is_made_and_shown(tmp_path, written) -> None:
    drawings.draw(tmp_path)
    pages = [written / "scene-file.md", *(DOCS / "theory").glob("*.md")]
    shown = "".join(page.read_text(encoding="utf-8") for page in pages)
    assert [drawn for drawn in tmp_path.glob("*.svg") if f"_static/{drawn.name}" not in shown] == []
    drawn = " ".join(p.read_text(encoding="utf-8") for p in tmp_path.glob("*.svg"))
    assert [key for key in ("screw.length", "track.lead", "nut.flange.seat", "groove_radius") if key not in drawn] == []


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
