"""Writing files whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from compare.errors import InputError


def write_new(path: Path, text: str) -> None:
    """Write ``text`` to a file that must not exist yet; nothing half-written is left behind.

    Raises InputError where the file exists or cannot be written.
    """
    if path.exists():
        raise InputError(str(path), "file", "an existing file", "a new name", "choose another name or remove it")
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".tmp")
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(str(path), "file", reason, "a folder that can be written to", "check the path") from None
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        os.link(name, path)
    except FileExistsError:
        raise InputError(str(path), "file", "an existing file", "a new name", "choose another name") from None
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(str(path), "file", reason, "a file that can be written", "check the path") from None
    finally:
        os.unlink(name)


def replace_file(path: Path, text: str) -> None:
    """Write ``text`` to a file, whole or not at all; an earlier file is replaced. Raises InputError if it cannot be."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".tmp")
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        os.replace(name, path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(str(path), "file", reason, "a folder that can be written to", "check the path") from None
