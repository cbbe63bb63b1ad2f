"""What this project finds for each printed number and claim of the source, with evidence and a verdict."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compare.measure import error_percent
from compare.printed.printed_data import Printed, load_table

#: Verdict of a number or claim of class band that agrees: no more can be said of it.
WITHIN = "within its band"
#: Verdict of an input that a scene holds: nothing was computed.
TAKEN = "taken over"


@dataclass(frozen=True)
class Finding:
    """One printed entry and ours.

    value: the right value in the printed unit; as_printed: ours with the source's faults repeated; holds: whether a
    claim is borne out; evidence: the figures behind it.
    """

    printed: Printed
    value: float | None = None
    as_printed: float | None = None
    holds: bool | None = None
    evidence: str = ""

    @property
    def compared(self) -> float | None:
        """The value that is held against the printed one."""
        return self.as_printed if self.printed.cls == "as-printed" else self.value

    @property
    def error_percent(self) -> float | None:
        """Error of the compared value against the printed number."""
        if self.compared is None or self.printed.value is None:
            return None
        return float(error_percent(self.compared, self.printed.value))

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
    def verdict(self) -> str:
        """In words: reproduced, within its band, taken over (an input), not so, or open with what we see."""
        agrees = self.agrees
        if self.printed.cls == "open":
            if agrees is None or self.printed.value is not None:
                return "open"
            return "open: holds here" if agrees else "open: does not hold here"
        if agrees is None:
            return "open"
        if self.printed.cls == "input":
            return TAKEN if agrees else f"not {TAKEN}"
        if self.printed.cls == "as-printed":
            return "reproduced as printed" if agrees else "not reproduced"
        if self.printed.cls == "band" and agrees:
            return WITHIN
        return "reproduced" if agrees else "not reproduced"


def sentences(*texts: str) -> str:
    """Remarks one after the other, each with one full stop between it and the next; empty ones left out."""
    given = [text for text in texts if text]
    return ". ".join([text.rstrip(".") for text in given[:-1]] + given[-1:])


def collect(table: str, found: dict[str, Finding]) -> list[Finding]:
    """Findings of a table in its order; entries without one stay open."""
    rows = load_table(table)
    unknown = set(found) - {row.key for row in rows}
    if unknown:
        raise KeyError(f"{table}: no printed entry {sorted(unknown)}")
    return [found.get(row.key, Finding(row)) for row in rows]


def entry(table: str, key: str) -> Printed:
    """Printed entry of a table by key."""
    return next(row for row in load_table(table) if row.key == key)


def share(mask: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> str:
    """ "k of n" of a mask."""
    return f"{int(mask.sum())} of {mask.size}"
