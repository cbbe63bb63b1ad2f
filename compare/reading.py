"""A user's file as text: UTF-8, or UTF-16 where a mark at its begin says so; names like one that does not exist."""

from __future__ import annotations

import codecs
import shlex
from collections.abc import Iterable
from pathlib import Path

#: What is allowed, in words.
ENCODING = "text in UTF-8"
_MARKS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}
#: Bytes below a blank that text has: tab and line ends.
_LAYOUT = b"\t\n\r\f\v"


class NoText(ValueError):
    """Bytes that cannot be read as text; value: what they are, advice: what to do."""

    def __init__(self, value: str, advice: str) -> None:
        """Keep both."""
        super().__init__(value)
        self.value, self.advice = value, advice


def text_of(data: bytes) -> str:
    """The text of a file. Raises NoText for text in another encoding, and for what is no text.

    >>> text_of("µ".encode("utf-16")), text_of("µ".encode("utf-8"))
    ('µ', 'µ')
    """
    encoding = next((encoding for mark, encoding in _MARKS.items() if data.startswith(mark)), "utf-8")
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as error:
        raise _no_text(data, error.start) from None
    if "\0" in text:
        raise _no_text(data, data.find(b"\0"))
    return text


def _no_text(data: bytes, at: int) -> NoText:
    """What bytes are that go wrong at one of them."""
    line = data.count(b"\n", 0, at) + 1
    place = f"line {line}, byte 0x{data[at]:02X}"
    if max(data[0::2].count(0), data[1::2].count(0)) > 0.4 * len(data):  # every other byte of Latin letters and digits
        return NoText("text in UTF-16 without a mark that says so", "save it as UTF-8")
    if any(byte < 32 and byte not in _LAYOUT for byte in data) or sum(byte > 127 for byte in data) > len(data) // 2:
        return NoText("a binary file", f"{place}: name a file of text, in UTF-8")
    advice = f"{place}, is no UTF-8; Latin-1 and Windows-1252 have such bytes for letters like ä and µ: save it as UTF-8"
    return NoText("text in another encoding than UTF-8", advice)


def question(found: Iterable[str]) -> str:
    """``did you mean A or B?``, each as a shell takes it; empty without any."""
    words = " or ".join(map(shlex.quote, found))
    return f"did you mean {words}?" if words else ""


def alike(name: str, names: Iterable[str]) -> list[str]:
    """Up to three names like one, with or without ending, in capitals or not.

    >>> alike("Srcew", ["nut.toml", "screw.toml"])
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


def like_path(path: Path, others: Iterable[str] = ()) -> str:
    """The `question` for a file that does not exist: files of its folder with the same ending, or else other names."""
    try:
        files = sorted(p.name for p in path.parent.iterdir() if p.suffix == path.suffix)
    except (OSError, ValueError):
        files = []
    return question([str(path.parent / name) for name in alike(path.name, files)] or alike(path.name, others))
