"""Hashes: of what a report rests on, and of the files it consists of. They tell what changed; they prove nothing of who
wrote it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

#: File of a report's folder that holds them.
FILE = "manifest.json"


def sha256(data: str | bytes) -> str:
    """SHA-256 of bytes, or of a text as UTF-8."""
    return hashlib.sha256(data.encode("utf-8", "surrogatepass") if isinstance(data, str) else data).hexdigest()


def hashes(folder: Path) -> dict[str, str]:
    """SHA-256 of every file of a report's folder but the manifest, by its path in there."""
    files = sorted(p for p in folder.rglob("*") if p.is_file() and p.name != FILE)
    return {p.relative_to(folder).as_posix(): sha256(p.read_bytes()) for p in files}


def write_manifest(folder: Path, origin: Mapping[str, Any]) -> None:
    """Write what a report rests on (``origin``, plain data) and the hashes of its files into its folder."""
    text = json.dumps({**origin, "files": hashes(folder)}, indent=1, ensure_ascii=False)
    (folder / FILE).write_text(text + "\n", encoding="utf-8", newline="\n")


def read_manifest(folder: Path) -> dict[str, Any]:
    """The manifest of a report's folder. Raises OSError where there is none, ValueError where it is damaged."""
    found = json.loads((folder / FILE).read_text(encoding="utf-8"))
    if not isinstance(found, dict) or not all(isinstance(found.get(key), dict) for key in ("inputs", "files")):
        raise ValueError(f"{FILE} is damaged")
    return found
