"""A copy of the tree to change, and rollbench run from it."""

import os
import shutil
from importlib import import_module
from pathlib import Path

import pytest
from tests import processes

ROOT = Path(__file__).parents[1]
#: Of tests that read the last report, which a source archive leaves out.
of_report = pytest.mark.skipif(not (ROOT / "reports/validation").is_dir(), reason="no report in a source archive")
FOLDERS = ("src", "compare", "hifi", "lowfi", "meshes", "reports")


def docs_module(name):
    """A program of the manual."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "docs")
        return import_module(name)


def copy_of_tree(folder, tests=()):
    """A copy of the product in a new folder, and of some folders or files of tests."""
    left = shutil.ignore_patterns("__pycache__", ".git", "validation", ".venv")
    folder.mkdir()
    for name in FOLDERS:
        shutil.copytree(ROOT / name, folder / name, symlinks=True, ignore=None if name == "src" else left)
    for name in tests:
        (folder / "tests" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / "tests" / name, folder / "tests" / name)
    return folder


def python(tree, *words, cwd):
    path = os.pathsep.join((str(tree / "src"), str(tree)))
    return processes.python(*words, environ={"PYTHONPATH": path}, cwd=cwd)


def rollbench(tree, *tokens, cwd):
    return python(tree, "-m", "rollbench", *tokens, cwd=cwd)
