"""Stored runs as text with a checksum: what was damaged or changed by hand is not used."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

#: Largest file of a run [bytes], and deepest nesting of its brackets: the largest shipped one has a tenth, and 4.
LARGEST, DEEPEST = 8_000_000, 8


def sealed(data: Mapping[str, Any]) -> str:
    """Text of a run's file: its data, rows of numbers line by line, with their checksum."""
    whole = {**data, "checksum": checksum(data)}
    return json.dumps(whole, separators=(",", ":")).replace("],[", "],\n[") + "\n"


def unsealed(path: Path) -> dict[str, Any]:
    """Data of a run's file. Raises ValueError for one that is too large, too deep, no run, or does not fit its checksum;
    OSError where it cannot be read."""
    data = _parsed(path)
    if data.pop("checksum", None) != checksum(data):
        raise ValueError("the checksum does not fit")
    return data


def checksum(data: Mapping[str, Any]) -> str:
    """Digest of JSON data, whatever the order of its keys and the layout of its text."""
    return hashlib.sha256(json.dumps(data, sort_keys=True, separators=(",", ":")).encode()).hexdigest()[:32]


def _parsed(path: Path) -> dict[str, Any]:
    if not path.is_file():
        raise ValueError("no regular file")
    with open(path, "rb") as file:
        content = file.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise ValueError(f"more than {LARGEST} bytes")
    text, depth = content.decode("utf-8"), 0
    for mark in (c for c in text if c in "[]{}"):
        depth += 1 if mark in "[{" else -1
        if depth > DEEPEST:
            raise ValueError(f"brackets nested more than {DEEPEST} deep")
    data = json.loads(text)
    if not isinstance(data, dict):
        raise ValueError("no table of a run")
    return data
