"""Access to shipped files by their path below the folder ``compare``, reading of text, and safe writing of files.

A user's file is UTF-8, or UTF-16 if a byte order mark says so. For a name that does not exist, similar names are suggested.
"""

from __future__ import annotations

import codecs
import io
import os
import shlex
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.errors import InputError
from rollbench.meshes.leftovers import make_folder_for_group, make_readable_for_group, temporary_name
from rollbench.meshes.libraries import import_fault, pip_command

if TYPE_CHECKING:
    from rollbench.reports.content import Figure


def place(path: str) -> Path:
    """Return the path of a shipped file or folder."""
    return Path(str(resources.files("rollbench.compare").joinpath(*path.split("/"))))


def text(path: str) -> str:
    """Return the text of a shipped file."""
    return place(path).read_text(encoding="utf-8")


@cache
def shipped_table(path: str) -> dict[str, Any]:
    """Return the contents of a shipped TOML file; the result is cached and must not be changed."""
    return tomllib.loads(text(path))


#: Allowed encodings, in words.
ENCODING = "text in UTF-8"

_MARKS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}

#: Bytes below the space character that text may have: tab and line ends.
_LAYOUT = b"\t\n\r\f\v"


class NotTextError(ValueError):
    """Error for bytes that cannot be read as text; value: what they are, advice: what to do."""

    def __init__(self, value: str, advice: str) -> None:
        """Store value and advice."""
        super().__init__(value)
        self.value, self.advice = value, advice


def text_of(data: bytes) -> str:
    """Return the bytes of a file as text; NoText for another encoding or binary data.

    Examples
    --------
    >>> text_of("µ".encode("utf-16")), text_of("µ".encode("utf-8"))
    ('µ', 'µ')
    """
    encoding = next((encoding for mark, encoding in _MARKS.items() if data.startswith(mark)), "utf-8")
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as error:
        raise _not_text_error(data, error.start) from None
    if "\0" in text:
        raise _not_text_error(data, data.find(b"\0"))
    return text


def _not_text_error(data: bytes, at: int) -> NotTextError:
    """Return the error for bytes that cannot be decoded at a position, with a guess of the cause."""
    line = data.count(b"\n", 0, at) + 1
    place = f"line {line}, byte 0x{data[at]:02X}"
    if max(data[0::2].count(0), data[1::2].count(0)) > 0.4 * len(data):  # every other byte of Latin letters and digits
        return NotTextError("text in UTF-16 without a mark that says so", "save it as UTF-8")
    if any(byte < 32 and byte not in _LAYOUT for byte in data) or sum(byte > 127 for byte in data) > len(data) // 2:
        return NotTextError("a binary file", f"{place}: name a file of text, in UTF-8")
    advice = f"{place}, is no UTF-8; Latin-1 and Windows-1252 have such bytes for letters like ä and µ: save it as UTF-8"
    return NotTextError("text in another encoding than UTF-8", advice)


def did_you_mean(found: Iterable[str]) -> str:
    """Return ``did you mean A or B?``, with names quoted for a shell; empty without any."""
    words = " or ".join(map(shlex.quote, found))
    return f"did you mean {words}?" if words else ""


def similar_names(name: str, names: Iterable[str]) -> list[str]:
    """Return up to three names that are similar to the given one; endings and capitals do not count.

    Examples
    --------
    >>> similar_names("Srcew", ["nut.toml", "screw.toml"])
    ['screw.toml']
    """
    import difflib

    spelt: dict[str, str] = {}
    for known in names:
        spelt.setdefault(known.lower(), known)
        spelt.setdefault(Path(known).stem.lower(), known)
    asked = name.lower(), Path(name).stem.lower()
    close = [near for text in asked for near in difflib.get_close_matches(text, spelt, n=3)]
    return list(dict.fromkeys(spelt[near] for near in close))[:3]


def similar_paths(path: Path, others: Iterable[str] = ()) -> str:
    """Return a `did_you_mean` with names similar to a missing file: from its folder, else from ``others``."""
    try:
        files = sorted(p.name for p in path.parent.iterdir() if p.suffix == path.suffix)
    except (OSError, ValueError):
        files = []
    return did_you_mean(
        [str(path.parent / name) for name in similar_names(path.name, files)] or similar_names(path.name, others)
    )


@contextmanager
def os_errors_as_input_errors(path: Path, allowed: str = "a folder that can be written to") -> Iterator[None]:
    """Convert an OSError inside the block, on writing the file ``path``, to InputError."""
    try:
        yield
    except OSError as error:
        raise InputError(str(path), "file", error.strerror or str(error), allowed, "check the path") from None


def write_new(path: Path, text: str) -> None:
    """Write ``text`` to a file that must not exist yet; nothing half-written is left.

    InputError if the file exists or cannot be written.
    """
    if path.exists():
        raise InputError(str(path), "file", "an existing file", "a new name", "choose another name or remove it")
    with os_errors_as_input_errors(path):
        name = temporary_name(path)
        file = open(name, "x", encoding="utf-8")  # noqa: SIM115 - closed below
    try:
        with os_errors_as_input_errors(path, "a file that can be written"):
            with file:
                file.write(text)
            os.link(name, path)
    finally:
        os.unlink(name)


def replace_file(path: Path, text: str) -> None:
    """Write ``text`` to a file, completely or not at all, replacing an earlier one; InputError if it cannot be written."""
    with os_errors_as_input_errors(path):
        make_folder_for_group(path.parent)
        name = temporary_name(path)
        try:
            with open(name, "x", encoding="utf-8") as file:
                file.write(text)
            make_readable_for_group(name)
            os.replace(name, path)
        finally:
            name.unlink(missing_ok=True)


def write_csv(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write rows (values by column name) as a CSV file, like `replace_file`; no text can be run as a formula."""
    import csv

    from rollbench.reports.cells import escape_formula

    text = io.StringIO()
    writer = csv.DictWriter(text, list(dict.fromkeys(name for row in rows for name in row)), lineterminator="\n")
    writer.writeheader()
    writer.writerows({k: escape_formula(v) if isinstance(v, str) else v for k, v in row.items()} for row in rows)
    replace_file(path, text.getvalue())


def why_no_figure() -> str:
    """Return why no figure can be drawn on this machine, and advice; empty if figures can be drawn."""
    reason = import_fault("matplotlib")
    return f"no figure ({reason}: {pip_command('matplotlib')})" if reason else ""


def write_figure(path: Path, figure: Figure) -> str:
    """Write a figure as SVG; return the name of the file, or why there is none. InputError if it cannot be written."""
    if reason := why_no_figure():
        return reason
    from rollbench.reports.figures import draw_figure

    replace_file(path, draw_figure(figure))
    return str(path)


def need_writable(path: Path) -> None:
    """Raise InputError unless a file can be written at ``path``, before anything is computed for it."""
    if path.is_dir():
        raise InputError(str(path), "file", "a folder", "a file name", "add the file's name")
    with os_errors_as_input_errors(path):
        make_folder_for_group(path.parent)
        probe = temporary_name(path)
        probe.touch(exist_ok=False)
        probe.unlink()
