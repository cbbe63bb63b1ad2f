"""Hashes of a report's inputs and files: they show what changed, but not who wrote it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

#: File with the hashes in the folder of a report.
FILE = "manifest.json"
#: Largest file of a report that is read [bytes]: ten times the largest page.
LARGEST = 200_000_000


def sha256(data: str | bytes) -> str:
    """Return the SHA-256 of bytes, or of a text as UTF-8."""
    return hashlib.sha256(data.encode("utf-8", "surrogatepass") if isinstance(data, str) else data).hexdigest()


def file_hashes(folder: Path) -> dict[str, str]:
    """Return the SHA-256 of every file in a report's folder, except the manifest, by relative path."""
    files = sorted(p for p in folder.rglob("*") if p.is_file() and p.name != FILE)
    return {p.relative_to(folder).as_posix(): sha256(p.read_bytes()) for p in files}


def write_manifest(folder: Path, origin: Mapping[str, Any]) -> None:
    """Write the manifest of a report: its inputs (``origin``, plain data) and the hashes of its files."""
    text = json.dumps({**origin, "files": file_hashes(folder)}, indent=1, ensure_ascii=False)
    (folder / FILE).write_text(text + "\n", encoding="utf-8", newline="\n")


def page_text(path: Path) -> str:
    """Return the text of a file in a report's folder.

    OSError if it is missing; ValueError for a pipe, a device, a folder or too large a file.
    """
    if path.exists() and not path.is_file():
        raise ValueError("a pipe, a device or a folder")
    if (size := path.stat().st_size) > LARGEST:
        raise ValueError(f"{size:.3g} bytes; pages have at most {LARGEST:.3g}")
    return path.read_text(encoding="utf-8")


def parse_manifest(text: str) -> Any:
    """Parse a text as JSON; ValueError if it is not JSON or nested too deeply."""
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("brackets are nested too deeply") from None


def all_texts(found: object) -> bool:
    """Return whether a part of a manifest maps names to texts."""
    return isinstance(found, dict) and all(isinstance(value, str) for value in found.values())


def read_manifest(folder: Path) -> dict[str, Any]:
    """Return the manifest of a report's folder; OSError if there is none, ValueError if it is damaged."""
    found = parse_manifest(page_text(folder / FILE))
    if not isinstance(found, dict) or not all(all_texts(found.get(key)) for key in ("inputs", "files")):
        raise ValueError(f"{FILE} is damaged")
    return found
