"""The manual: pages that the program writes, its workflow, and paths and links that it names."""

import csv
import re

import pytest
import yaml
from tests.copies import ROOT, docs_module, of_report

DOCS = ROOT / "docs"
#: Pages of the manual, and those that a reader opens first.
PAGES = [*sorted(DOCS.rglob("*.md")), *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"))]
drawings, generate = map(docs_module, ("drawings", "generate"))


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory):
    folder = tmp_path_factory.mktemp("reference")
    generate.pages(folder)
    return folder


def test_reference_has_every_command_key_and_quantity_with_its_unit(written) -> None:
    commands = (written / "commands.md").read_text(encoding="utf-8")
    for name in ("solve", "compare", "check", "friction", "doctor"):
        assert f"## `rollbench {name}`" in commands
    scene = (written / "scene-file.md").read_text(encoding="utf-8")
    assert [table for table in ("[track]", "[[sets]]".strip("[]"), "[nut.flange]", "[cases") if table not in scene] == []
    text = (written / "quantities.md").read_text(encoding="utf-8")
    units = {"axial.rigidity_N_per_um": "N/µm", "loads.worst_ball": "–", "rigidities_N_per_um.with_bodies": "N/µm"}
    assert "`loads.max_N`" in text
    assert all(f"| `{key}` | {unit} |" in text for key, unit in units.items())
    assert "Table B.1" in (written / "misprints.md").read_text(encoding="utf-8")


def test_workflow_keeps_the_reference_also_when_the_job_fails(written) -> None:
    workflow = yaml.safe_load((DOCS / "gate.yml").read_text(encoding="utf-8"))
    reference, job = workflow["jobs"]["reference"]["steps"], workflow["jobs"]["gate"]
    restore = next(step for step in reference if step.get("uses", "").startswith("actions/cache/restore@"))
    (save,) = [step for step in reference if step.get("uses", "").startswith("actions/cache/save@")]
    assert save["if"].startswith("always() && ")
    assert "job.status == 'success'" in save["with"]["key"]
    assert restore["with"]["restore-keys"].startswith("rollbench-part-")
    assert "part-{0}-{1}" in save["with"]["key"]
    assert any("-c rollbench/.ci/constraints.txt" in step.get("run", "") for step in reference)
    assert set(workflow[True]) == {"push", "pull_request"}  # the word "on" is true in YAML 1.1
    for one in workflow["jobs"].values():
        assert all({"uses", "run"} & step.keys() for step in one["steps"])
        assert one["runs-on"]
    uses = [step.get("uses", "") for step in job["steps"]]
    assert any(use.startswith("actions/cache/restore@") for use in uses)
    for step in job["steps"]:
        if step.get("uses", "").startswith(("actions/cache/save@", "actions/upload-artifact@")):
            assert step["if"] == "always()"
    action = yaml.safe_load((ROOT / ".github/actions/check/action.yml").read_text(encoding="utf-8"))
    (judged,) = [step["with"] for step in job["steps"] if step.get("uses", "").endswith("/.github/actions/check")]
    assert set(judged) <= set(action["inputs"])
    assert {name for name, one in action["inputs"].items() if one.get("required")} <= set(judged)
    script = next(step["run"] for step in action["runs"]["steps"] if step.get("id") == "check")
    check = (written / "commands.md").read_text(encoding="utf-8").partition("## `rollbench check`")[2].partition("\n## ")[0]
    assert [option for option in re.findall(r"--[\w-]+", script) if option not in check] == []
    (kept,) = [step["with"] for step in job["steps"] if step.get("uses", "").startswith("actions/upload-artifact@")]
    assert kept["path"] == action["inputs"]["report"]["default"]


@of_report
@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_named_files_exist(page) -> None:
    text = page.read_text(encoding="utf-8")
    for named in re.findall(r"`((?:lowfi|hifi|compare|meshes|reports|tests|docs)/[\w./*-]+)`", text):
        assert list(ROOT.glob(named.rstrip("/"))), named
    for target in re.findall(r"\]\(([^)#:]+?)(?:#[^)]*)?\)", text):
        file = page.parent / target
        assert file.exists() or file.stem in ("commands", "quantities", "scene-file", "misprints"), target


def test_every_drawing_is_made_and_shown(tmp_path, written) -> None:
    drawings.draw(tmp_path)
    scene = (written / "scene-file.md").read_text(encoding="utf-8")
    assert [drawn for drawn in tmp_path.glob("*.svg") if f"_static/{drawn.name}" not in scene] == []
    lengths = " ".join(p.read_text(encoding="utf-8") for p in tmp_path.glob("*.svg"))
    keys = "screw.length nut.length track.lead nut.flange.seat solid.shaft groove_radius screw.bore"
    assert [key for key in keys.split() if key not in lengths] == []


@of_report
@pytest.mark.parametrize(("page", "model"), [("refined-model", "refined"), ("beam-model", "lin")])
def test_errors_of_models_on_their_page_and_the_first_are_the_report_s(page: str, model: str) -> None:
    survey = (ROOT / "reports/validation/tables/stability-survey.csv").read_text(encoding="utf-8")
    rows = csv.DictReader(survey.splitlines())
    kind = "largest error of a contact load, in per cent of the mean load"
    row = next(r for r in rows if (r["model"], r["kind of error"]) == (model, kind))
    median, most = float(row["median error over the screws [%]"]), float(row["95th percentile of the error [%]"])
    first, text = ((DOCS / file).read_text(encoding="utf-8") for file in ("index.md", f"theory/{page}.md"))
    for words in (f"{median:.1f} %", f"{row['number of screws']} screws"):
        assert words in re.sub(r"\s+", " ", first)
    assert f"{median:.1f} %" in text
    assert re.search(rf"{most:.2g} %\s+at the\s+95th percentile", text)
