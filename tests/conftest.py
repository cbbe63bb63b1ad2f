"""Linear algebra on one thread in every worker, as on the command line. What takes long is begun first."""

import gc
import json
import os
import re
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import pytest

TESTS = Path(__file__).parent


def begin() -> None:
    """Make the links that a source archive does not hold; linear algebra on one thread."""
    project = tomllib.loads((TESTS.parent / "pyproject.toml").read_text(encoding="utf-8"))
    build = project["tool"].get("hatch", {}).get("build")  # none in a folder of tests alone
    for folder, package in build["targets"]["wheel"]["sources"].items() if build else ():
        link = TESTS.parent / build["dev-mode-dirs"][0] / package
        if not link.exists():
            link.symlink_to(os.path.relpath(TESTS.parent / folder, link.parent))
    from rollbench.meshes.processes import limit_to_one_thread

    limit_to_one_thread()


begin()
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # or each process that a test starts compiles all modules again

#: What one solve does without: a module of tests that imports one of these packages, or a helper that does, is marked so.
FURTHER = re.compile(
    r"^\s*(?:from|import) rollbench\."
    r"(?:compare\.(?:cases|evidence|report|studies)|lowfi\.(?:friction|bearings|as_source\.liu)|hifi\.rolling|meshes\.exchange)\b",
    re.MULTILINE,
)
HELPER = re.compile(r"^from (tests\.[\w.]+) import ", re.MULTILINE)


@cache
def is_further(path: Path) -> bool:
    """Whether a module of tests, or a helper of it, imports a package that one solve does without."""
    text = path.read_text(encoding="utf-8")
    helpers = (TESTS.parent.joinpath(*name.split(".")).with_suffix(".py") for name in HELPER.findall(text))
    return FURTHER.search(text) is not None or any(map(is_further, helpers))


def pytest_configure(config: pytest.Config) -> None:
    """Leave out further tests and what is slow where the command names neither paths nor marks."""
    as_configured = config.option.markexpr == config.getini("addopts")[-1]
    if as_configured and config.args_source is pytest.Config.ArgsSource.TESTPATHS:
        config.option.markexpr += " and (every_run or not further and not slow)"


def pytest_itemcollected(item: pytest.Item) -> None:
    """Mark the tests of cases, studies, the report and their physics."""
    if "sources" in item.path.parts or is_further(item.path):
        item.add_marker("further")


def begun(item: pytest.Item) -> bool:
    """Place of a test: the slow ones first, so that none is left at the end with one worker waiting for the other."""
    return item.get_closest_marker("slow") is None


def keep_group(item: pytest.Item) -> None:
    """Let a test's id name its group: xdist 3.8 writes it where pytest 9.2 no longer looks (pytest-xdist issue 1386), and
    tests of one group went to all workers, each of which made their set-up."""
    named = getattr(item, "_nodeid", item.nodeid)
    if named != item.nodeid:
        item._id = type(item.id).parse(named)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """What collection makes lives as long as the process: garbage is not looked for among it, then or later."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(5000)  # of 700: solving makes many small objects that live on
        gc.enable()


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=begun)
    for item in items:
        keep_group(item)


class Said(NamedTuple):
    """How a command ended: its exit code, and what it wrote on standard output and on standard error."""

    code: int
    out: str
    err: str


def refuse(word: str) -> None:
    raise AssertionError(f"no JSON: {word}")


class Command:
    """The command line in this process."""

    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self.capsys = capsys

    def __call__(self, *words: object) -> Said:
        from rollbench.compare.cli import main

        with pytest.raises(SystemExit) as stop:
            main([str(word) for word in words])
        return Said(int(stop.value.code or 0), *self.capsys.readouterr())

    def json(self, *words: object) -> tuple[int, Any]:
        """Exit code, and the one JSON value on standard output, without nan and infinity."""
        said = self(*words)
        return said.code, json.loads(said.out, parse_constant=refuse)

    def said(self, *words: object) -> str:
        """Standard output of a command that ends with 0."""
        code, out, err = self(*words)
        assert code == 0, err
        return out

    def answer(self, *words: object) -> Any:
        """The one JSON value of a command that ends with 0."""
        return json.loads(self.said(*words, "--json"), parse_constant=refuse)

    def refused(self, *words: object) -> str:
        """The one line on standard error of a command that refuses its input: exit status 2, nothing on standard output."""
        code, out, err = self(*words)
        assert (code, out, err.count("\n")) == (2, "", 1), err
        assert err.startswith("rollbench: ")
        return err


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Command:
    """Runs a command with its words."""
    return Command(capsys)
