"""``rollbench doctor``: one line for each thing, what lacks is named with its cost, exit code 0 or 1."""

import sys
import tomllib

import pytest
from tests.copies import ROOT

from rollbench.compare import running
from rollbench.compare.commands import doctor as doctor
from rollbench.meshes import libraries
from rollbench.reports import offscreen


@pytest.fixture(autouse=True)
def _drawn_already(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(offscreen, "reason_drawing_fails", lambda: "")
    monkeypatch.setattr(doctor, "gmsh_fault", lambda: "")
    monkeypatch.setattr(doctor, "available_GB", lambda: 16.0)


def test_a_machine_with_everything(command, tmp_path) -> None:
    out = command.said("doctor", "--store", tmp_path / "runs")
    assert [words for words in ("nothing is missing", "gmsh: ", "memory: 16.0 GB") if words not in out] == []
    assert not (tmp_path / "runs").exists(), "looking changes nothing"


def test_what_lacks_is_named_with_its_cost_and_remedy(command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "gmsh_fault", lambda: "libgomp.so.1: cannot open shared object file")
    monkeypatch.setattr(doctor, "available_GB", lambda: 1.5)
    code, data = command.json("doctor", "--json")
    bad = {check["name"]: check for check in data["checks"] if check["state"] == "missing"}
    assert (code, data["complete"], set(bad)) == (1, False, {"meshing", "memory"})
    assert "libgomp.so.1" in bad["meshing"]["found"]
    assert bad["meshing"]["advice"] == libraries.apt_command(libraries.MESHING)
    assert "no 3D meshes" in bad["meshing"]["cost"]
    assert bad["memory"]["found"] == "1.5 GB free"


def test_a_package_that_cannot_be_imported_is_missing(monkeypatch: pytest.MonkeyPatch, tmp_path) -> None:
    (tmp_path / "matplotlib.py").write_text("raise RuntimeError('half installed')")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "matplotlib", raising=False)
    monkeypatch.setattr(doctor, "oldest_package_versions", lambda: {"matplotlib": "3.9"})
    libraries.reason_of_failed_import.cache_clear()
    (check,) = doctor._check_packages()
    libraries.reason_of_failed_import.cache_clear()
    assert check.state == "missing"
    assert "RuntimeError: half installed" in check.found
    assert check.cost


def test_every_requirement_of_the_package_is_looked_at() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    listed = [*project["dependencies"], *(line for name in set(libraries.EXTRA.values()) for line in extras[name])]
    assert {line.partition(">=")[0] for line in listed} == set(doctor.oldest_package_versions())


def test_memory_is_what_the_system_and_the_control_group_leave(tmp_path) -> None:
    proc = tmp_path / "meminfo"
    proc.write_text("MemTotal: 9 kB\nMemAvailable:    2000000 kB\n")
    assert running.available_GB(proc, tmp_path) == pytest.approx(2.048)
    (tmp_path / "memory.current").write_text("400000000\n")
    for limit, free in (("1000000000", 0.6), ("max", 2.048)):
        (tmp_path / "memory.max").write_text(f"{limit}\n")
        assert running.available_GB(proc, tmp_path) == pytest.approx(free)
    assert running.available_GB(tmp_path / "nothing", tmp_path / "nothing") is None


def test_the_least_python_is_the_same_everywhere():
    """To its last digit: Debian 12 has 3.11.2, and functions came with later ones."""
    least = ".".join(map(str, doctor.PYTHON))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert (project["requires-python"], len(doctor.PYTHON)) == (f">={least}", 3)
    assert f"Python {least} or newer" in (ROOT / "README.md").read_text(encoding="utf-8")
