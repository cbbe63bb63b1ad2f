"""Access to files that are included with rollbench, decoding of users' text files, and writing of complete files only.

A user's file is read as UTF-8, or as UTF-16 if it starts with that byte order mark. If a file does not exist, error
messages suggest similar names.
"""

from __future__ import annotations

import codecs
import io
import json
import os
import shlex
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from rollbench.compare.errors import InputError
from rollbench.meshes.files import create_folder_for_group, make_readable_for_group, temporary_path
from rollbench.meshes.libraries import pip_command, reason_of_failed_import

if TYPE_CHECKING:
    from rollbench.reports.content import Figure

T = TypeVar("T")


def shipped_path(path: str) -> Path:
    """Return the path of a file or folder that is included with rollbench; ``path`` is relative to the folder `compare`."""
    return Path(str(resources.files("rollbench.compare").joinpath(*path.split("/"))))


def shipped_text(path: str) -> str:
    """Return the text of a file that is included with rollbench; ``path`` is relative to the folder `compare`."""
    return shipped_path(path).read_text(encoding="utf-8")


@cache
def read_shipped_toml(path: str) -> dict[str, Any]:
    """Return the contents of a built-in TOML file from a cache; callers must not change the returned dictionary."""
    return tomllib.loads(shipped_text(path))


#: Text that names the allowed encoding in error messages.
ENCODING = "text in UTF-8"

_MARKS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}

#: Control characters that a text file may contain: tab and line ends.
_LAYOUT = b"\t\n\r\f\v"


def decode_text(data: bytes) -> str:
    """Decode the bytes of a file to text, in UTF-8 or UTF-16.

    ValueError for other bytes; its two arguments are what they are, such as "a binary file", and advice to the user.

    Examples
    --------
    >>> decode_text("µ".encode("utf-16")), decode_text("µ".encode("utf-8"))
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


def _not_text_error(data: bytes, at: int) -> ValueError:
    """Return the error for bytes that cannot be decoded at the index ``at``, with a guess of the cause."""
    line = data.count(b"\n", 0, at) + 1
    place = f"line {line}, byte 0x{data[at]:02X}"
    if max(data[0::2].count(0), data[1::2].count(0)) > 0.4 * len(data):  # every other byte of Latin letters and digits
        return ValueError("text in UTF-16 without a byte order mark", "save the file as UTF-8")
    if any(byte < 32 and byte not in _LAYOUT for byte in data) or sum(byte > 127 for byte in data) > len(data) // 2:
        return ValueError(f"a binary file ({place})", "name a text file in UTF-8")
    advice = "save the file as UTF-8 (Latin-1 and Windows-1252 have such bytes for letters like ä and µ)"
    return ValueError(f"text in another encoding ({place})", advice)


def did_you_mean(names: Iterable[str]) -> str:
    """Return the question ``did you mean A or B?`` with the names ``names``, quoted for a shell; empty without names."""
    words = " or ".join(map(shlex.quote, names))
    return f"did you mean {words}?" if words else ""


def similar_names(name: str, names: Iterable[str]) -> list[str]:
    """Return up to three of ``names`` that are similar to ``name``; file suffixes and capital letters are ignored.

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
    """Return the question "did you mean ...?" with names similar to the missing file ``path``; empty if none is similar.

    The names are those of files in the same folder; if none of these is similar, those in ``others``. See `did_you_mean`.
    """
    try:
        files = sorted(p.name for p in path.parent.iterdir() if p.suffix == path.suffix)
    except (OSError, ValueError):
        files = []
    near = [str(path.parent / name) for name in similar_names(path.name, files)]
    return did_you_mean(near or similar_names(path.name, others))


def read_text_file(
    path: str | Path,
    kind: str,
    limit: int,
    others: Iterable[str] = (),
    advice: str = "check the path",
    error: type[InputError] = InputError,
) -> str:
    """Return the text of a file of a user; an error if it cannot be read, is not text, or is too large.

    Parameters
    ----------
    path
        Path of the file.
    kind
        What the file is, such as "TOML file", for the error message.
    limit
        Largest size [bytes].
    others
        Names that a path may have been meant for, if no file in its folder has a similar name.
    advice
        Advice if the file cannot be opened and no name is similar.
    error
        Class of the error.
    """
    allowed, size = f"a readable {kind}", f"{limit // 1_000_000} MB"
    try:
        if Path(path).is_dir():
            raise error(str(path), "file", "a directory", allowed, "name a file inside it")
        if Path(path).exists() and not Path(path).is_file():
            raise error(str(path), "file", "a pipe or device", allowed, "name a regular file")
        with open(path, "rb") as file:
            data = file.read(limit + 1)
    except (OSError, ValueError) as reason:
        value = getattr(reason, "strerror", None) or str(reason)
        near = similar_paths(Path(path), others) if isinstance(reason, FileNotFoundError) else ""
        raise error(str(path), "file", value.lower(), allowed, near or advice) from None
    if len(data) > limit:
        raise error(str(path), "file", f"more than {size}", f"up to {size}", f"check whether this is a {kind}")
    try:
        return decode_text(data)
    except ValueError as reason:
        raise error(str(path), "file", reason.args[0], f"a {kind}, {ENCODING}", reason.args[1]) from None


@contextmanager
def raise_input_error_if_not_writable(path: Path, allowed: str = "a folder that can be written to") -> Iterator[None]:
    """Raise InputError if the ``with`` block cannot write the file ``path``.

    ``allowed``: what is allowed, as text for the message.
    """
    try:
        yield
    except OSError as error:
        raise InputError(str(path), "file", error.strerror or str(error), allowed, "check the path") from None


def write_new_file(path: Path, text: str) -> None:
    """Write a text to a new file, completely or not at all; InputError if the file exists or cannot be written."""
    if path.exists():
        raise InputError(str(path), "file", "an existing file", "a new file", "choose another name, or remove the file")
    with raise_input_error_if_not_writable(path):
        name = temporary_path(path)
        try:
            name.write_text(text, encoding="utf-8")
            os.link(name, path)
        finally:
            name.unlink(missing_ok=True)


def read_from_first_valid_folder(stores: Sequence[Path], file_name: str, build_object: Callable[[Any], T]) -> T | None:
    """Read an object from a JSON file in the first folder that has a valid file; None if no folder has one.

    ``stores``: folders in the order in which they are tried; ``file_name``: name of the file, with "*" for any text;
    ``build_object``: function that builds the object from the file's JSON values, and raises ValueError, KeyError or
    TypeError if they are not valid.
    """
    for path in (path for store in stores for path in sorted(store.glob(file_name))):
        with suppress(OSError, ValueError, KeyError, TypeError):
            return build_object(json.loads(path.read_text(encoding="utf-8")))
    return None


#: Complete temporary files with the files that they will replace, inside `written_together`; None outside.
_complete: ContextVar[list[tuple[Path, Path]] | None] = ContextVar("complete", default=None)


@contextmanager
def written_together() -> Iterator[None]:
    """Let all files that the ``with`` block writes by `replaced_file` appear at its end, or none of them if it fails."""
    if _complete.get() is not None:  # a part of what a caller writes together
        yield
        return
    complete: list[tuple[Path, Path]] = []
    token = _complete.set(complete)
    try:
        yield
        for name, path in complete:
            with raise_input_error_if_not_writable(path):
                os.replace(name, path)
    finally:
        _complete.reset(token)
        for name, _ in complete:
            name.unlink(missing_ok=True)


@contextmanager
def replaced_file(path: Path) -> Iterator[Path]:
    """Yield the path of a new file, with the suffix of ``path``, which replaces the file ``path`` if the block succeeds.

    InputError if the file cannot be written.
    """
    with raise_input_error_if_not_writable(path):
        create_folder_for_group(path.parent)
        name = temporary_path(path, path.suffix.removeprefix(".") or "tmp")
        complete = _complete.get()
        try:
            yield name
            make_readable_for_group(name)
            if complete is None:
                os.replace(name, path)
            else:
                complete.append((name, path))
        except BaseException:
            name.unlink(missing_ok=True)
            raise


def replace_file(path: Path, text: str) -> None:
    """Write a text to a file, completely or not at all; an existing file is replaced. InputError if it is not writable."""
    with replaced_file(path) as name, open(name, "x", encoding="utf-8") as file:
        file.write(text)


def write_csv(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write rows (values by column name) to a CSV file, which is replaced if it exists.

    Texts are changed so that no spreadsheet program can run them as a formula.
    """
    import csv

    from rollbench.reports.cells import escape_formula

    text = io.StringIO()
    writer = csv.DictWriter(text, list(dict.fromkeys(name for row in rows for name in row)), lineterminator="\n")
    writer.writeheader()
    writer.writerows({k: escape_formula(v) if isinstance(v, str) else v for k, v in row.items()} for row in rows)
    replace_file(path, text.getvalue())


def reason_without_figure() -> str:
    """Return a text on why figures cannot be drawn (matplotlib is missing), with advice; empty if they can."""
    reason = reason_of_failed_import("matplotlib")
    return f"no figure ({reason}: {pip_command('matplotlib')})" if reason else ""


def write_figure(path: Path, figure: Figure) -> str:
    """Write a figure to an SVG file, and return the file's name, or the reason why no figure can be drawn.

    InputError if the file cannot be written.
    """
    if reason := reason_without_figure():
        return reason
    from rollbench.reports.figures import draw_figure

    replace_file(path, draw_figure(figure))
    return str(path)


def check_writable(path: Path) -> None:
    """Raise InputError unless the file ``path`` can be written; called before the results for this file are computed."""
    if path.is_dir():
        raise InputError(str(path), "file", "a folder", "a file", "add the name of a file to the path")
    with raise_input_error_if_not_writable(path):
        create_folder_for_group(path.parent)
        probe = temporary_path(path)
        probe.touch(exist_ok=False)
        probe.unlink()
