"""Try one-line mutants: ``python tests/mutants/run.py [NAME ...]``; each must make one of its tests fail.

Every mutant is written into a copy of the sources; the tree itself is never touched. The tests must pass without a mutant
first. Exit code 1 where a mutant survives that is not marked as equivalent, 2 where the tests do not run.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
PARTS = (
    ".ci",
    ".import",
    "lowfi",
    "hifi",
    "meshes",
    "compare",
    "reports",
    "tests",
    "docs",
    "pyproject.toml",
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "CITATION.cff",
    "LICENSE",
)


def copied(folder: Path) -> Path:
    """A copy of what tests need, in a folder."""
    for name in PARTS:
        source = ROOT / name
        if source.is_dir():
            leave = shutil.ignore_patterns("__pycache__")
            shutil.copytree(source, folder / name, ignore=leave, dirs_exist_ok=True, symlinks=True)
        elif source.exists():
            shutil.copy(source, folder / name)
    return folder


def pytest(
    options: Sequence[str], folder: Path, patience: float | None = None, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run tests in the copy; none has a limit of time of its own, because the first one compiles kernels.

    Raises RuntimeError where they do not run, TimeoutExpired after ``patience`` [s].
    """
    own = {"PYTHONPATH": str(folder / ".import"), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "-P", "-m", "pytest", "-q", "--timeout", "0", *options],
        cwd=folder,
        env={**os.environ, **own, **environment},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
        timeout=patience,
    )
    if done.returncode not in (0, 1):
        said = done.stdout[-2000:] + done.stderr[-2000:]
        raise RuntimeError(f"pytest ended with {done.returncode}: {' '.join(options)}\n{said}")
    return done


def passes(tests: Sequence[str], folder: Path, patience: float | None = None, **environment: str) -> bool:
    """Whether tests pass in the copy, as `pytest` runs them in one process until one fails."""
    return pytest(["-n", "0", "-x", *tests], folder, patience, **environment).returncode == 0


def survives(mutant: dict[str, Any], folder: Path) -> bool:
    """Whether all tests of a mutant pass in the copy that holds it."""
    path = folder / mutant["file"]
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace(mutant["old"], mutant["new"]), encoding="utf-8")
    try:
        return passes(mutant["tests"], folder)
    finally:
        path.write_text(text, encoding="utf-8")


def main(names: list[str]) -> int:
    """Try the mutants of these names, or all."""
    listed = tomllib.loads((Path(__file__).parent / "mutants.toml").read_text(encoding="utf-8"))["mutant"]
    unknown = sorted(set(names) - {m["name"] for m in listed})
    if unknown:
        print(f"no such mutant: {', '.join(unknown)}", file=sys.stderr)
        return 2
    picked = [m for m in listed if not names or m["name"] in names]
    alive = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = copied(Path(temporary))
        tests = sorted({test for mutant in picked if not mutant.get("equivalent") for test in mutant["tests"]})
        try:
            if tests and not passes(tests, folder):
                print("the tests fail without a mutant", file=sys.stderr)
                return 2
        except RuntimeError as error:
            print(error, file=sys.stderr)
            return 2
        for number, mutant in enumerate(picked, start=1):
            if mutant.get("equivalent"):
                print(f"[{number}/{len(picked)}] {mutant['name']}: equivalent: {mutant['equivalent']}", flush=True)
                continue
            lives = survives(mutant, folder)
            alive += [mutant["name"]] if lives else []
            print(f"[{number}/{len(picked)}] {mutant['name']}: {'SURVIVES' if lives else 'killed'}", flush=True)
    print(f"{len(picked)} mutants, {len(alive)} survive")
    return 1 if alive else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
