"""Evidence: what this project finds for a printed number or claim of a source, and the verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from rollbench.compare.measure import error_percent
from rollbench.compare.printed.printed_data import Printed, Verdict, load_table, value_of


@dataclass(frozen=True)
class Evidence:
    """One printed entry and what is computed for it.

    value: the right value in the printed unit; as_printed: the value with the source's faults repeated; reading: the
    value under an assumption that was inferred from the printed results, which confirms nothing; reference: what the 3D
    reference gives; holds: whether a claim is borne out; words: the figures behind it.
    """

    printed: Printed
    value: float | None = None
    as_printed: float | None = None
    reading: float | None = None
    reference: float | None = None
    holds: bool | None = None
    words: str = ""

    @property
    def compared(self) -> float | None:
        """The value that is held against the printed one."""
        return self.as_printed if self.printed.cls == "as-printed" else self.value

    @property
    def error_percent(self) -> float | None:
        """Error of the compared value against the printed number."""
        return self._against_printed(self.compared)

    @property
    def reading_error_percent(self) -> float | None:
        """Error of the value under the inferred reading against the printed number."""
        return self._against_printed(self.reading)

    def _against_printed(self, value: float | None) -> float | None:
        if value is None or self.printed.value is None:
            return None
        percent = float(error_percent(value, self.printed.value))
        return percent if np.isfinite(percent) else None  # of a printed zero there is none

    @property
    def agrees(self) -> bool | None:
        """Whether the entry is reproduced; None where that cannot be said."""
        p = self.printed
        if p.value is None:
            return self.holds
        if self.compared is None:
            return None
        if p.low is not None and p.high is not None:
            return p.low <= self.compared <= p.high
        # half a unit of the last digit, with the round-off of a decimal number
        return bool(abs(self.compared - p.value) <= p.tolerance * (1.0 + 1e-9))

    @property
    def verdict(self) -> Verdict:
        """The verdict on the entry."""
        p = self.printed
        if p.cls == "open":
            return "contradicted" if p.contradicted else "not identifiable"
        if p.cls == "input":
            return "contradicted" if self.agrees is False else "input"
        if not self.agrees:
            return "not identifiable" if self.agrees is None else "contradicted"
        if p.kind in ("arithmetic", "zero"):
            return "identity"
        by_class: dict[str, Verdict] = {"as-printed": "only as printed", "band": "band"}
        return by_class.get(p.cls, "reproduced")

    @property
    def reason(self) -> str:
        """Why, in sentences; empty where that needs none."""
        why = self.printed.contradicted
        return sentences(why[:1].upper() + why[1:], sentences(self.printed.remark, self.words))

    @property
    def change(self) -> str:
        """How the verdict differs from the expected one, in words; empty where it does not."""
        expected = self.printed.verdict
        if expected == self.verdict:
            return ""
        wanted = "no verdict is expected" if expected is None else f"expected {expected}"
        return f"{self.printed.name}: {wanted}, came out {self.verdict}"


class Sheet:
    """Evidence of one printed table, filed entry by entry; an entry that nothing is filed for stays open.

    >>> sheet = Sheet("lin-2.2")
    >>> sheet.words("time_proposed_1", "another machine")
    >>> [e.words for e in sheet.evidence() if e.words]
    ['another machine']
    """

    def __init__(self, table: str) -> None:
        """Start with every entry of ``table`` open. Raises InputError for an unknown table."""
        self._entries = {row.key: Evidence(row) for row in load_table(table)}
        self.table = table

    def _file(self, key: str, **fields: float | bool | str | None) -> None:
        if key not in self._entries:
            raise KeyError(f"{self.table}: no printed entry {key!r}")
        self._entries[key] = replace(self._entries[key], **fields)  # type: ignore[arg-type]

    def number(
        self,
        key: str,
        value: float | None,
        words: str = "",
        *,
        as_printed: float | None = None,
        reading: float | None = None,
        reference: float | None = None,
    ) -> None:
        """File a number in the printed unit. Raises KeyError for an unknown key."""
        self._file(key, value=value, as_printed=as_printed, reading=reading, reference=reference, words=words)

    def numbers(self, values: Mapping[str, float]) -> None:
        """File right values by key. Raises KeyError for an unknown key."""
        for key, value in values.items():
            self.number(key, float(value))

    def printed(self, key: str) -> float:
        """Printed number of an entry, for arithmetic. Raises KeyError for a claim or an unknown key."""
        return value_of(self.table, key)

    def claim(self, key: str, holds: bool, words: str) -> None:
        """File whether a claim holds, and the figures behind it. Raises KeyError for an unknown key."""
        self._file(key, holds=bool(holds), words=words)

    def words(self, key: str, words: str) -> None:
        """File why nothing is compared, or a remark on what is filed already. Raises KeyError for an unknown key."""
        self._file(key, words=words)

    def evidence(self) -> tuple[Evidence, ...]:
        """All entries in the order of the table."""
        return tuple(self._entries.values())


def sentences(*texts: str) -> str:
    """Join the remarks that are not empty by ". "."""
    given = [text for text in texts if text]
    return ". ".join([text.rstrip(".") for text in given[:-1]] + given[-1:])


def count_of(mask: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> str:
    """ "k of n" of a mask."""
    return f"{int(mask.sum())} of {mask.size}"
