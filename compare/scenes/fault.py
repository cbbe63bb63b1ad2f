"""A fault of a scene file, and how lengths are written in it."""

from __future__ import annotations

from dataclasses import dataclass

#: Lengths that differ by less than this [m] count as equal.
TOLERANCE = 1e-9


@dataclass(frozen=True)
class Fault:
    """One fault: the keys it may be blamed on (the first one that the file has is named), and what to say.

    ``value`` is left empty where the text found in the file says it best.
    """

    keys: tuple[str, ...]
    allowed: str
    advice: str
    value: str = ""


def mm(length: float) -> str:
    """A length [m] for a message: in mm, or in um below 0.1 mm."""
    return f"{length * 1e6:.6g} um" if 0.0 < abs(length) < 1e-4 else f"{length * 1e3:.7g} mm"
