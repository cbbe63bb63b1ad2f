"""The fixture ``rollbench`` fails a test with the verdict's own line, and is found by its entry point."""

import os
import subprocess
import sys
import tomllib
from importlib import import_module

import pytest
from tests.copies import ROOT

from rollbench.compare.scenes.catalogue import shipped_scene_text
from rollbench.fixture import RollbenchFixture


def test_a_scene_that_passes_and_one_that_does_not(tmp_path) -> None:
    (tmp_path / "two-balls.toml").write_text(shipped_scene_text("two-balls"), encoding="utf-8")
    here = RollbenchFixture(tmp_path)
    (verdict,) = here.check("two-balls.toml", max_error=7, compute=False)
    assert verdict.judgement == "pass"
    with pytest.raises(pytest.fail.Exception, match=r"UNDECIDED: two-balls, refined: .* limit 0\.4 %"):
        here.check("two-balls.toml", max_error=0.4, compute=False)


def test_the_entry_point_names_the_plug_in() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert hasattr(import_module(project["entry-points"]["pytest11"]["rollbench"]), "rollbench")


def test_in_a_pytest_of_its_own(tmp_path) -> None:
    """Another project's test, three lines long, beside a compare.py of that project; the plug-in loads no part of the
    workbench before it is used."""
    (tmp_path / "compare.py").write_text("raise SystemExit('not rollbench')\n", encoding="utf-8")
    first = "import sys\n\nassert 'compare' not in sys.modules\n\n\n"
    test = "def test_my_screw(rollbench):\n    rollbench.check('none.toml', max_error=7)\n"
    (tmp_path / "test_mine.py").write_text(first + test, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "rollbench.fixture", "-p", "no:cacheprovider", "."]
    alone = os.environ | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTHONPATH": str(ROOT / "src"), "PYTEST_ADDOPTS": ""}
    done = subprocess.run(command, cwd=tmp_path, env=alone, capture_output=True, text=True, timeout=250, check=False)
    assert done.returncode == 1, done.stdout + done.stderr
    assert "none.toml: file: got no such file or directory" in done.stdout
