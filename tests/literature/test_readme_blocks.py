"""Every block of commands in README and CONTRIBUTING is run as printed, in order, each on the files the ones before made.

What is not run is named here with its reason; a block that is neither run nor named fails.
"""

import ast
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
README, CONTRIBUTING = ROOT / "README.md", ROOT / "CONTRIBUTING.md"
SOLVES_3D = "solves 3D models, minutes on two cores: tests/unit/reference and tests/unit/hifi run small ones"
#: Command lines that are not run, as patterns.
HEAVY = {
    "rollbench report": "the whole report, minutes: tests/unit/reports makes its pages, the continuous integration all",
    "rollbench compare my.toml --levels 1": SOLVES_3D,
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


def kind(block: str) -> str:
    """What a block is written in."""
    first = block.split()[0]
    return "python" if first in ("import", "def", "from") else "shell"


def commands(block: str) -> Iterator[str]:
    """Command lines of a block, continued lines joined, without comments and the environment's folder."""
    for line in block.replace("\\\n", " ").splitlines():
        for command in shlex.join(shlex.split(line, comments=True)).split(" '&&' "):
            yield command.removesuffix(" '&'").replace(".venv/bin/rollbench", "rollbench")


def run(line: str, command) -> None:
    words = shlex.split(line)
    assert words[0] == "rollbench", line
    uncovered = UNCOVERED.fullmatch(line)
    code, out, err = command(*words[1:], *(["--no-compute"] if uncovered else []))
    assert code == (4 if uncovered else 0), (line, err[-500:], out[-500:])


def heavy(line: str) -> bool:
    return any(re.fullmatch(pattern, line) for pattern in HEAVY)


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_blocks_of_the_readme_run_as_printed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command) -> None:
    monkeypatch.chdir(tmp_path)
    ran = []
    for block in blocks(README):
        if kind(block) == "python":
            _python(block)
        else:
            for line in commands(block):
                if not heavy(line):
                    run(line, command)
                    ran.append(line)
    for begins in (
        "sweep my.toml --vary errors.balls.oversize",
        "solve lin-random --members 1000",
        "check my.toml --loads",
    ):
        assert any(line.replace("'", "").startswith(f"rollbench {begins}") for line in ran), begins


def _python(block: str) -> None:
    """Run a block of Python but for its lines on the gate, which wants the 3D reference; functions are tests of pytest."""
    import rollbench

    tree, names_there = ast.parse(block), {"rollbench": rollbench}
    for node in tree.body:
        text = ast.unparse(node)
        if isinstance(node, ast.FunctionDef) or text.startswith("rollbench.check("):
            names = re.findall(r"rollbench\.(\w+)\(", text)
            assert all(hasattr(rollbench, name) for name in names), text
        else:
            exec(text, names_there)


def test_every_command_is_run_or_named_with_its_reason_and_every_name_is_needed() -> None:
    shells = [block for path in (README, CONTRIBUTING) for block in blocks(path) if kind(block) == "shell"]
    lines = [line for block in shells for line in commands(block)]
    assert [line for line in lines if not (line.startswith("rollbench ") or heavy(line))] == []
    assert [pattern for pattern in HEAVY if not any(re.fullmatch(pattern, line) for line in lines)] == []
