"""A copy of the tree to change, and rollbench run from it."""

import os
import shutil
from pathlib import Path

from tests import processes

ROOT = Path(__file__).parents[1]
FOLDERS = (".import", "compare", "hifi", "lowfi", "meshes", "reports")


def copy_of_tree(folder, tests=()):
    """A copy of the product in a new folder, and of some folders or files of tests."""
    left = shutil.ignore_patterns("__pycache__", ".git", "validation", ".venv")
    folder.mkdir()
    for name in FOLDERS:
        shutil.copytree(ROOT / name, folder / name, symlinks=True, ignore=None if name == ".import" else left)
    for name in tests:
        (folder / "tests" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / "tests" / name, folder / "tests" / name)
    return folder


def python(tree, *words, cwd):
    path = os.pathsep.join((str(tree / ".import"), str(tree)))
    return processes.python(*words, environ={"PYTHONPATH": path}, cwd=cwd)


def rollbench(tree, *tokens, cwd):
    return python(tree, "-m", "rollbench", *tokens, cwd=cwd)
