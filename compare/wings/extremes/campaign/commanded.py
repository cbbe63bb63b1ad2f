"""A scene file of the campaign through the command line, as text and as JSON: they must say what the models found."""

from __future__ import annotations

import json
import re
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.comparison.errors import InputError
from rollbench.lowfi.statics.result import Solved
from rollbench.meshes.parts import SIDES

#: Tokens of a command to its exit code and what it prints; the line that it refuses with for exit code 2.
Command = Callable[[list[str]], tuple[int, str]]
#: Loads may differ by this share of the largest: the command chooses its engine itself.
SAME = 1e-5


def misstated(text: str, model: str, found: Solved | InputError, command: Command) -> str:
    """What ``rollbench solve`` says of a scene file otherwise than the model did, in words; empty where all agree."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "campaign.toml"
        path.write_text(text, encoding="utf-8")
        tokens = ["solve", str(path), "--model", model, "--balls"]
        (printed, words), (code, data) = command(tokens), command([*tokens, "--json"])
    expected = 2 if isinstance(found, InputError) else 1 - found.converged
    if (printed, code) != (expected, expected):
        return f"exit codes {printed} (text) and {code} (JSON) instead of {expected}: {data if code == 2 else words}"
    if isinstance(found, InputError):
        return ""
    if found.status not in " ".join(words.split()):
        return "the text does not say the status"
    number = re.search(r"(?<![\w.])[+-]?(nan|inf)\b", words)
    return f"the text says {number[0]}" if number else _in_json(data, found)


def _in_json(text: str, found: Solved) -> str:
    try:
        data = json.loads(text, parse_constant=_refuse)
    except ValueError as error:
        return f"no strict JSON: {error}"
    if data["status"] != found.status:
        return f"the JSON's status is {data['status']}"
    rows = [[row["load_N"][side] for side in SIDES] for row in data["balls"]]
    load = np.array(rows, dtype=float).reshape(-1, 4)  # null becomes nan
    known = np.concatenate([np.zeros((0, 4)), *(b.load for b in found.of_balls())])
    if not np.allclose(load, known, rtol=0.0, atol=SAME * float(np.nanmax(known, initial=0.0)), equal_nan=True):
        return "the JSON's loads are others"
    return ""


def _refuse(word: str) -> Any:
    raise ValueError(f"{word} is no JSON number")
