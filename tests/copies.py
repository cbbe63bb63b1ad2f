"""A copy of the tree to change, and rollbench run from it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

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
    environment = os.environ | {"PYTHONPATH": os.pathsep.join((str(tree / ".import"), str(tree)))}
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, env=environment, timeout=250, cwd=cwd)


def rollbench(tree, *tokens, cwd):
    return python(tree, "-m", "rollbench", *tokens, cwd=cwd)
