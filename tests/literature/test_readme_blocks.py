"""Every block of commands in README and CONTRIBUTING is run as printed, in order, each on the files the ones before made.

What is not run is named here with its reason; a block that is neither run nor named fails.
"""

import ast
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.copies import ROOT

import rollbench

README, CONTRIBUTING = ROOT / "README.md", ROOT / "CONTRIBUTING.md"
#: Command lines that are not run, as patterns.
HEAVY = {
    "rollbench report": "the whole report, minutes: tests/unit/reports makes its pages, the continuous integration all",
    "rollbench compare my.toml --levels 1": "minutes on two cores: tests/unit/reference and tests/unit/hifi run small ones",
    "python3 -m venv .venv": "an environment from a registry: the continuous integration begins with it",
    r"\.venv/bin/pip install .*": "an environment from a registry: the continuous integration begins with it",
    r"\.venv/bin/(pytest|ruff check \.|mypy|lint-imports)": "the continuous integration runs it",
}
#: The 3D reference of a file that is new takes minutes: judged without it, so that the exit code is that of not covered.
UNCOVERED = re.compile(r"rollbench check my\.toml .*")


def blocks(path: Path) -> list[str]:
    """Indented blocks of a page."""
    found = re.findall(r"(?:\A|\n\n)((?:    .*\n|\n(?=    ))+)", path.read_text(encoding="utf-8"))
    return ["\n".join(line[4:] for line in block.splitlines()).strip("\n") for block in found]


def is_python(block: str) -> bool:
    return block.split()[0] in ("import", "def", "from")


def commands(block: str) -> Iterator[str]:
    """Command lines of a block, continued lines joined, without comments and the environment's folder; none of Python."""
    for line in [] if is_python(block) else block.replace("\\\n", " ").splitlines():
        for command in shlex.join(shlex.split(line, comments=True)).split(" '&&' "):
            yield command.removesuffix(" '&'").replace(".venv/bin/rollbench", "rollbench")


def heavy(line: str) -> bool:
    return any(re.fullmatch(pattern, line) for pattern in HEAVY)


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_blocks_of_the_readme_run_as_printed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command) -> None:
    monkeypatch.chdir(tmp_path)
    ran = []
    for block in blocks(README):
        if is_python(block):
            _python(block)
        ran += [_run(line, command) for line in commands(block) if not heavy(line)]
    for begins in (
        "sweep my.toml --vary errors.balls.oversize",
        "solve lin-random --members 1000",
        "check my.toml --loads",
    ):
        assert any(line.replace("'", "").startswith(f"rollbench {begins}") for line in ran), begins


def _run(line: str, command) -> str:
    program, *words = shlex.split(line)
    assert program == "rollbench", line
    uncovered = UNCOVERED.fullmatch(line)
    code, out, err = command(*words, *(["--no-compute"] if uncovered else []))
    assert code == (4 if uncovered else 0), (line, err[-500:], out[-500:])
    return line


def _python(block: str) -> None:
    """Run a block of Python but for its lines on the gate, which wants the 3D reference; functions are tests of pytest."""
    names_there = {"rollbench": rollbench}
    for node in ast.parse(block).body:
        text = ast.unparse(node)
        if isinstance(node, ast.FunctionDef | ast.Assert):
            assert all(hasattr(rollbench, name) for name in re.findall(r"rollbench\.(\w+)\(", text)), text
        else:
            exec(text, names_there)


def test_every_command_is_run_or_named_with_its_reason_and_every_name_is_needed() -> None:
    lines = [line for path in (README, CONTRIBUTING) for block in blocks(path) for line in commands(block)]
    assert [line for line in lines if not (line.startswith("rollbench ") or heavy(line))] == []
    assert [pattern for pattern in HEAVY if not any(re.fullmatch(pattern, line) for line in lines)] == []
