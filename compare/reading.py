"""A user's file as text: UTF-8, or UTF-16 where a mark at its begin says so."""

from __future__ import annotations

import codecs

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
