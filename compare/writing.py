"""Writing files whole or not at all."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.errors import InputError
from rollbench.meshes.leftovers import folder_for_group, for_group, temporary
from rollbench.meshes.libraries import fault, pip

if TYPE_CHECKING:
    from rollbench.reports.content import Figure


@contextmanager
def written(path: Path, allowed: str = "a folder that can be written to") -> Iterator[None]:
    """Raise InputError where the file ``path`` cannot be written inside."""
    try:
        yield
    except OSError as error:
        raise InputError(str(path), "file", error.strerror or str(error), allowed, "check the path") from None


def write_new(path: Path, text: str) -> None:
    """Write ``text`` to a file that must not exist yet; nothing half-written is left behind.

    Raises InputError where the file exists or cannot be written.
    """
    if path.exists():
        raise InputError(str(path), "file", "an existing file", "a new name", "choose another name or remove it")
    with written(path):
        name = temporary(path)
        file = open(name, "x", encoding="utf-8")  # noqa: SIM115 - closed below
    try:
        with written(path, "a file that can be written"):
            with file:
                file.write(text)
            os.link(name, path)
    finally:
        os.unlink(name)


def replace_file(path: Path, text: str) -> None:
    """Write ``text`` to a file, whole or not at all; an earlier file is replaced. Raises InputError if it cannot be."""
    with written(path):
        folder_for_group(path.parent)
        name = temporary(path)
        try:
            with open(name, "x", encoding="utf-8") as file:
                file.write(text)
            for_group(name)
            os.replace(name, path)
        finally:
            name.unlink(missing_ok=True)


def write_csv(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write rows by the names of their columns as CSV, as `replace_file` does; texts so that no program runs them."""
    import csv

    from rollbench.reports.cells import harmless

    text = io.StringIO()
    writer = csv.DictWriter(text, list(dict.fromkeys(name for row in rows for name in row)), lineterminator="\n")
    writer.writeheader()
    writer.writerows({k: harmless(v) if isinstance(v, str) else v for k, v in row.items()} for row in rows)
    replace_file(path, text.getvalue())


def no_figure() -> str:
    """Why no figure can be drawn, and what helps; empty where one can."""
    reason = fault("matplotlib")
    return f"no figure ({reason}: {pip('matplotlib')})" if reason else ""


def write_figure(path: Path, figure: Figure) -> str:
    """Draw a figure into a file, SVG; the file's name, or why there is none. Raises InputError if it cannot be written."""
    if reason := no_figure():
        return reason
    from rollbench.reports.figures import draw

    replace_file(path, draw(figure))
    return str(path)


def need_writable(path: Path) -> None:
    """Raise InputError unless a file can be written at ``path``, before anything is computed for it."""
    if path.is_dir():
        raise InputError(str(path), "file", "a folder", "a file name", "add the file's name")
    with written(path):
        folder_for_group(path.parent)
        probe = temporary(path)
        probe.touch(exist_ok=False)
        probe.unlink()
