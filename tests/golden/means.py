"""What golden answers keep of many numbers: of each name how many there are, their mean size, and a weighted mean."""

import contextlib
import io
import json
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.conftest import refuse

from rollbench.compare.cli import main

#: Relative, and what is round-off in every unit of an answer.
TOLERANCE, ROUND_OFF = 1e-6, 1e-9


def leaves(
    value: Any, left_out: Callable[[str], Any], name: str = "", *, properties: bool = False
) -> Iterator[tuple[str, Any]]:
    """Names and values of all numbers, truth values and arrays below a value; places in lists are no part of a name.
    properties: those of records too."""
    if is_dataclass(value) and not isinstance(value, type):
        also = [key for key, x in vars(type(value)).items() if properties and isinstance(x, property | cached_property)]
        value = {key: getattr(value, key) for key in (*(f.name for f in fields(value)), *also)}
    elif hasattr(value, "_asdict") and not isinstance(value, type):
        value = value._asdict()
    if isinstance(value, dict):
        for key, below in value.items():
            if not left_out(f"{name}.{key}"):
                yield from leaves(below, left_out, f"{name}.{key}", properties=properties)
    elif isinstance(value, list | tuple):
        for below in value:
            yield from leaves(below, left_out, name, properties=properties)
    elif isinstance(value, np.ndarray | np.generic | int | float) and np.asarray(value).dtype.kind in "biuf":
        yield name.removeprefix("."), value


def numbers_by_name(value: Any, left_out: Callable[[str], Any], *, properties: bool = False) -> dict[str, np.ndarray]:
    """All numbers of each name."""
    found = defaultdict(list)
    for name, number in leaves(value, left_out, properties=properties):
        found[name].append(np.asarray(number, dtype=float).ravel())
    return {name: np.concatenate(numbers) for name, numbers in found.items()}


def means(value: Any, left_out: Callable[[str], Any], *, properties: bool = False) -> dict[str, list[float]]:
    """Of each name: how many finite numbers, their mean size, and their mean weighted by their place."""
    out = {}
    for name, numbers in numbers_by_name(value, left_out, properties=properties).items():
        x = numbers[np.isfinite(numbers)]
        if x.size:
            out[name] = [x.size, *(float(f"{m:.9g}") for m in (np.abs(x).mean(), (x * np.cos(np.arange(x.size))).mean()))]
    return out


def answered(words: list[str], scene: str = "") -> tuple[int, dict[str, Any], str]:
    """Exit code of a command in a folder with the file drawn.toml, its strict JSON, and what it says of a refusal."""
    said, unsaid = io.StringIO(), io.StringIO()
    with (
        tempfile.TemporaryDirectory() as folder,
        contextlib.chdir(folder),
        contextlib.redirect_stdout(said),
        contextlib.redirect_stderr(unsaid),
    ):
        Path("drawn.toml").write_text(scene, encoding="utf-8")
        with pytest.raises(SystemExit) as stop:
            main([*words, "--json"])
    return stop.value.code, json.loads(said.getvalue() or "{}", parse_constant=refuse), unsaid.getvalue()


def write(record: Path, rows: dict[str, Any]) -> None:
    """Write a record, a line for every row."""
    lines = [f"{json.dumps(name)}: {json.dumps(row)}" for name, row in rows.items()]
    record.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def same(
    found: dict[str, list[float]],
    expected: dict[str, list[float]],
    round_off: float = ROUND_OFF,
    tolerance: float = TOLERANCE,
) -> None:
    """Assert that no number has moved; others may be new."""
    assert not expected.keys() - found.keys()
    for name, (count, size, mean) in expected.items():
        assert found[name] == pytest.approx([count, size, mean], rel=tolerance, abs=max(tolerance * size, round_off)), name
