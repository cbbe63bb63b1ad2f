"""Every number of the output is defined, and every definition is of a number that some command prints."""

import contextlib
import io
import json
from collections.abc import Iterator
from itertools import chain

import pytest

from rollbench.comparison.cli import main
from rollbench.comparison.definitions import _known, definition
from rollbench.comparison.registration import data_files
from rollbench.comparison.scenes.template import template

#: Keys that number, name or count, in tables whose headings say what they are.
NO_QUANTITY = (
    *("index", "member", "members", "seed", "set", "level", "levels[]", "converged", "contacts", "seconds", "ball"),
    *("printed", "value", "reference", "reference_error", "error_percent", "station_mm", "screw", "nut"),
)


def leaves(value: object, path: str = "") -> Iterator[tuple[str, object]]:
    """Paths and values of all that an answer holds."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(inner, f"{path}.{key}".lstrip("."))
    elif isinstance(value, (list, tuple)):
        for inner in value:
            yield from leaves(inner, f"{path}[]")
    else:
        yield path, value


COMMANDS = (
    "solve lin-case1 --model lin",
    "solve lin-case3 --model lin --stiffness-at 400_mm",
    "solve double-nut --model lin",
    "solve lin-random --model lin --members 3 --balls",
    "friction lin-case3 --model lin --mu 0.1",
    "friction lin-case1 --model lin --mu 0.1",
    "check lin-case1 --model lin --no-compute --limit angle=1",
    "compare lin-case1 --model lin",
)


def answered(command: str) -> object:
    """The JSON of a command line."""
    output = io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(io.StringIO()), contextlib.suppress(SystemExit):
        main([word.replace("_mm", " mm") for word in [*command.split(), "--json"]])
    return json.loads(output.getvalue())


@pytest.fixture(scope="module")
def printed(tmp_path_factory) -> list[tuple[str, object]]:
    turning = tmp_path_factory.mktemp("definitions") / "turning.toml"
    turning.write_text(f'{data_files("scenes")["lin-case1"].read_text()}\n[motion]\nspeed = "60 rpm"\n')
    bearings = turning.with_name("bearings.toml")
    bearings.write_text(template("support-bearings"))
    cases = turning.with_name("lin.toml")  # its only case has the stored runs of lin-case1
    cases.write_text(f'{data_files("scenes")["lin-case1"].read_text()}\n[[cases]]\nname = "case1"\nshare = 1\n')
    sets = turning.with_name("sets.toml")
    sets.write_text(f'{data_files("scenes")["double-nut"].read_text()}\n[[cases]]\nname = "one"\nshare = 1\n')
    of_cases = [f"{one} {cases} --model lin" for one in ("solve", "friction", "compare", "check --no-compute")]
    commands = (*COMMANDS, *of_cases, *(f"solve {file} --model lin" for file in (turning, bearings, sets)))
    return list(chain.from_iterable(leaves(answered(command)) for command in commands))


def test_every_number_is_defined(printed):
    numbers = {path for path, value in printed if isinstance(value, (int, float)) and not isinstance(value, bool)}
    assert not sorted(path for path in numbers if definition(path) is None and path.rsplit(".")[-1] not in NO_QUANTITY)


def test_every_definition_is_of_something_printed(printed):
    paths = {path for path, _ in printed}
    assert not [pattern.pattern for pattern, _ in _known() if not any(map(pattern.fullmatch, paths))]
