"""Manifest of a report, with the SHA-256 checksums of its inputs, and the checksums of its files."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

#: Name of the manifest file in the folder of a report.
FILE = "manifest.json"
#: Name of the file with the checksums of all files of a report, as the program ``sha256sum`` reads it.
SUMS = "SHA256SUMS"
#: Size of a report's file above which it is not read [bytes]; about ten times the largest page.
LARGEST = 200_000_000


def sha256(data: str | bytes) -> str:
    """Return the SHA-256 checksum, as hexadecimal digits, of bytes or of a text in UTF-8."""
    return hashlib.sha256(data.encode("utf-8", "surrogatepass") if isinstance(data, str) else data).hexdigest()


def write_manifest(folder: Path, origin: Mapping[str, Any]) -> None:
    """Write the manifest of a report, which describes its inputs, and the checksums of all its files.

    ``sha256sum -c SHA256SUMS``, in the report's folder, shows whether a file was changed. ``origin``: the report's inputs.
    """
    text = json.dumps(origin, indent=1, ensure_ascii=False)
    (folder / FILE).write_text(text + "\n", encoding="utf-8", newline="\n")
    files = sorted(p for p in folder.rglob("*") if p.is_file() and p.name != SUMS)
    lines = (f"{sha256(p.read_bytes())}  {p.relative_to(folder).as_posix()}\n" for p in files)
    (folder / SUMS).write_text("".join(lines), encoding="utf-8", newline="\n")


def read_report_file(path: Path) -> str:
    """Return the text of one file in a report's folder; files above `LARGEST` bytes are refused.

    Raises OSError if the file is missing, and ValueError if it is no regular file or is too large.
    """
    if path.exists() and not path.is_file():
        raise ValueError("a report file must be a regular file, not a pipe, a device or a folder")
    if (size := path.stat().st_size) > LARGEST:
        raise ValueError(
            f"the file has {size:.3g} bytes; the largest permitted size of a report file is {LARGEST:.3g} bytes"
        )
    return path.read_text(encoding="utf-8")
