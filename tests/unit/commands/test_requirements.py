"""Pinned lines of what a command needs, and the gate in an environment of just these."""

import os
import sys
import venv

import pytest
from hatchling.builders.wheel import WheelBuilder
from tests.copies import ROOT
from tests.processes import ran

from rollbench.comparison.errors import InputError
from rollbench.comparison.wings.doctor import requirements as module
from rollbench.meshes.libraries import NEEDED_BY, ONLY_FOR, version

#: Largest environment of the gate beside stored runs [MB].
LARGEST_MB = 400


def lines(command: str) -> list[str]:
    return module.run_requirements(command).data["requirements"]


def names(command: str) -> set[str]:
    return {line.partition("==")[0] for line in lines(command)}


def test_commands_need_no_more_than_they_say_in_the_versions_of_this_environment() -> None:
    for name, _, pinned in (line.partition("==") for line in lines("all")):
        assert version(name) == pinned
    assert {"numpy", "scipy", "pydantic", "rich", "attrs", "markdown-it-py"} <= names("check"), "with what these need"
    assert not names("check") & {*ONLY_FOR, "llvmlite", "vtk", "jinja2"}
    assert names("solve") - names("check") == {"numba", "llvmlite"}
    assert names("solve") < names("compare") < names("report") == names("all")
    assert {"gmsh", "scikit-fem", "pymetis", "matplotlib"} <= names("compare")
    assert {"vtk", "trimesh"} <= names("report")
    text = "\n".join(module.run_requirements("check").parts)
    assert all(f"# without {name}: " in text for name in ONLY_FOR)
    assert all(line.startswith("#") or "==" in line for line in text.splitlines())


def test_a_package_that_is_not_installed_has_no_version(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "version", lambda name: None if name == "trimesh" else version(name))
    with pytest.raises(InputError, match=r"--requirements: got trimesh is not installed.*pip install trimesh"):
        module.closure(["trimesh"])
    assert "trimesh" not in names("check")
    assert set(NEEDED_BY) == {"check", "solve", "compare", "report", "all"}


@pytest.mark.installs
def test_the_gate_runs_in_an_environment_of_these_lines_alone(tmp_path) -> None:
    (wheel,) = WheelBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"])
    (tmp_path / "requirements.txt").write_text("\n".join(lines("check")) + "\n", encoding="utf-8")
    venv.create(tmp_path / "small", with_pip=False)
    python = tmp_path / "small" / "bin" / "python"
    clean = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"} | {"ROLLBENCH_CACHE": str(tmp_path / "cache")}
    pip = (sys.executable, "-m", "pip", "--python", python, "install", "-q", "--no-deps")
    for what in (("-r", tmp_path / "requirements.txt"), (wheel,)):
        installed = ran(*pip, *what, cwd=tmp_path, env=clean)
        assert installed.returncode == 0, installed.stderr
    check = "check", "lin-case1", "--no-compute", "--max-error", "7"
    found = ran(tmp_path / "small" / "bin" / "rollbench", *check, cwd=tmp_path, env=clean)
    assert found.returncode == 0, found.stderr
    assert found.stdout.startswith("PASS: lin-case1, refined: "), found.stdout
    size = sum(path.stat().st_size for path in (tmp_path / "small").rglob("*") if not path.is_symlink())
    assert size < LARGEST_MB * 1e6
