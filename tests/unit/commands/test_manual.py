"""The manual: pages that the program writes, its workflow, and paths and links that it names."""

import csv
import os
import re
import shutil
import subprocess
from hashlib import sha256
from pathlib import Path
from typing import Any

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


class Service:
    """Stands for the service that runs the workflow: its caches, newest last, and what its jobs have computed and judged.

    ``wanted`` is the file that a study stores and the gate looks for; an update of rollbench changes it.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.caches, self.computed = folder, dict[str, dict[str, bytes]](), list[str]()
        (folder / "bin").mkdir()
        study = 'mkdir -p rollbench-reference\n[ -e "rollbench-reference/$WANTED" ] || echo "$WANTED" | tee -a ../computed'
        study += ' > "rollbench-reference/$WANTED"\nexit "${STUDY:-0}"\n'
        check = 'case "$*" in *--stored*) [ -e "rollbench-reference/$WANTED" ] || exit 4 ;; *) exit 4 ;; esac\n'
        rollbench = f"case $1 in mesh-study)\n{study};;\ncheck)\n{check};;\nesac\n"
        for name, text in {"sudo": "", "pip": "", "rollbench": rollbench}.items():
            (folder / "bin" / name).write_text(f"#!/bin/sh\n{text}", encoding="utf-8")
            (folder / "bin" / name).chmod(0o755)

    def value(self, text: object, known: dict[str, str]) -> str:
        """Return a text with its expressions in braces replaced by their values."""

        def hashed(_: re.Match[str]) -> str:
            files = sorted(p for p in (self.folder / "work/rollbench-reference").rglob("*") if p.is_file())
            return sha256(b"".join(p.name.encode() + p.read_bytes() for p in files)).hexdigest() if files else ""

        found = re.sub(r"\$\{\{ hashFiles\('rollbench-reference/\*\*'\) \}\}", hashed, str(text))
        return re.sub(r"\$\{\{ ([\w.-]+) \}\}", lambda m: known.get(m[1], ""), found)

    def applies(self, condition: str, known: dict[str, str], *, failed: bool) -> bool:
        """Return whether a step runs: conditions are terms between &&, each always() or a comparison of two values."""
        terms = [term.strip() for term in condition.split("&&")]
        values = [[known.get(x.strip(), x.strip().strip("'")) for x in term.split("!=")] for term in terms if "!=" in term]
        return ("always()" in terms or not failed) and all(a != b for a, b in values)

    def run(self, job: dict[str, Any], known: dict[str, str], wanted: str, study: int = 0) -> int:
        """Run the steps of a job in an empty folder, and return the exit code of the step that failed, or 0."""
        work = self.folder / "work"
        shutil.rmtree(work, ignore_errors=True)
        work.mkdir()
        return self.run_steps(job["steps"], known, wanted, study)

    def run_steps(self, steps: list[dict[str, Any]], known: dict[str, str], wanted: str, study: int) -> int:
        """Run steps, those of this project's action of the reference one by one, and return as `run` does."""
        work, failed, output = self.folder / "work", 0, self.folder / "output"
        there = {"PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}", "WANTED": wanted, "STUDY": str(study)}
        for step in steps:
            if not self.applies(step.get("if", ""), known, failed=bool(failed)):
                continue
            action, given = step.get("uses", ""), {k: self.value(v, known) for k, v in step.get("with", {}).items()}
            script, env = step.get("run"), {k: self.value(v, known) for k, v in step.get("env", {}).items()}
            if "/actions/reference" in action:
                inner = yaml.safe_load((ROOT / ".github/actions/reference/action.yml").read_text(encoding="utf-8"))
                inputs = {name: one.get("default", "") for name, one in inner["inputs"].items()} | given
                there_known = known | {f"inputs.{name}": text for name, text in inputs.items()}
                failed = failed or self.run_steps(inner["runs"]["steps"], there_known, wanted, study)
                for name, one in inner["outputs"].items():
                    known[f"steps.{step.get('id')}.outputs.{name}"] = self.value(one["value"], there_known)
            if "/actions/check" in action:
                steps = yaml.safe_load((ROOT / ".github/actions/check/action.yml").read_text(encoding="utf-8"))
                script = next(one["run"] for one in steps["runs"]["steps"] if one.get("id") == "check")
                inputs = {name: one.get("default", "") for name, one in steps["inputs"].items()} | given
                env = {name.upper().replace("-", "_"): text for name, text in inputs.items()}
            if "cache/restore" in action:
                prefixes = given["key"], given.get("restore-keys", given["key"])
                found = next((k for p in prefixes for k in reversed(self.caches) if p and k.startswith(p)), "")
                known[f"steps.{step.get('id')}.outputs.cache-matched-key"] = found
                for name, content in self.caches.get(found, {}).items():
                    (work / given["path"]).mkdir(exist_ok=True)
                    (work / given["path"] / name).write_bytes(content)
            elif "cache/save" in action:
                assert given["key"] not in ("", *self.caches), "a cache is never written again"
                self.caches[given["key"]] = {p.name: p.read_bytes() for p in (work / given["path"]).iterdir()}
            elif script is not None:
                output.write_text("", encoding="utf-8")
                done = subprocess.run(
                    ["bash", "-e", "-c", script], cwd=work, env=there | env | {"GITHUB_OUTPUT": str(output)}, check=False
                )
                failed = failed or done.returncode
                for line in output.read_text(encoding="utf-8").splitlines():
                    name, _, text = line.partition("=")
                    known[f"steps.{step.get('id')}.outputs.{name}"] = text
        return failed

    def push(self, wanted: str, study: int = 0) -> tuple[int, int | None, int, int]:
        """Run the workflow; return exit codes of both jobs, how often a study has computed, and the number of caches."""
        jobs, known = yaml.safe_load((DOCS / "gate.yml").read_text(encoding="utf-8"))["jobs"], dict[str, str]()
        first, then = self.run(jobs["reference"], known, wanted, study), None
        needs = {f"needs.reference.outputs.{k}": self.value(v, known) for k, v in jobs["reference"]["outputs"].items()}
        if not first:
            then = self.run(jobs["gate"], needs, wanted)
        computed = self.folder / "computed"
        return first, then, len(computed.read_text("utf-8").split()) if computed.exists() else 0, len(self.caches)


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash here")
def test_the_workflow_computes_what_is_not_stored_and_keeps_it(tmp_path) -> None:
    service = Service(tmp_path)
    assert service.push("first") == (0, 0, 1, 1)
    assert service.push("first") == (0, 0, 1, 1), "nothing is computed again, and no cache written"
    assert service.push("after-update") == (0, 0, 2, 2), "an update of what is stored, with the same scene"
    assert service.push("first") == (0, 0, 2, 2)
    assert service.push("failed", study=1) == (1, None, 3, 3), "what a failed study has stored is kept"
    assert service.push("failed") == (0, 0, 3, 3)


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
