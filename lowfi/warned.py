"""Warnings attached to a result: each states why the result is outside the range of validity of its models."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

#: Keywords for the subject of a warning about geometry, about loads and strength, and about friction.
Geometry = Literal["place", "two flanks", "size", "profile", "tilt", "rotation", "conformity", "play"]
Load = Literal["pressure", "wedged", "preload", "safety", "held load", "buckling", "speed"]
FrictionSubject = Literal["coefficient", "feedback", "slip", "jam", "balance"]
Kind = Geometry | Load | FrictionSubject


class ResultWarning(str):
    """Text of a warning about a result, with a keyword for its subject and a short form for the line above the results.

    Examples
    --------
    >>> found = ResultWarning("rotation", "a section turns by 60 mrad: ...", "rotations up to 60 mrad")
    >>> found.kind, found.with_part_name("nut 1"), found.with_part_name("nut 1").brief
    ('rotation', 'nut 1: a section turns by 60 mrad: ...', 'nut 1: rotations up to 60 mrad')
    """

    #: Keyword for the subject of the warning, such as "pressure".
    kind: Kind
    #: Short form of the warning for the line above a printed table of results; empty if it does not appear in that line.
    brief: str

    def __new__(cls, kind: Kind, text: str, brief: str = "") -> ResultWarning:
        """Create a warning from its subject, its text and its short form (empty: not in the line above the results)."""
        warned = super().__new__(cls, text)
        warned.kind, warned.brief = kind, brief
        return warned

    def __getnewargs__(self) -> tuple[Kind, str, str]:  # type: ignore[override]
        """Return the arguments of the constructor, with which pickle makes a copy of the warning."""
        return self.kind, str(self), self.brief

    def with_part_name(self, name: str) -> ResultWarning:
        """Return this warning with the name of the part concerned in front of its text, as in "nut 1: ..."."""
        return ResultWarning(self.kind, f"{name}: {self}", self.brief and f"{name}: {self.brief}")


def join_brief_warnings(warnings: Iterable[ResultWarning]) -> str:
    """Join the short forms of a result's warnings to the line that is printed above the results; empty if there are none.

    Parameters
    ----------
    warnings
        Warnings of a result; those without a short form are left out of the line.
    """
    shown = [w for w in warnings if w.brief]
    outside = " outside what the models mean" * any(w.kind not in ("play", "coefficient", "held load") for w in shown)
    return f"WARNING{outside}: {'; '.join(w.brief for w in shown)}" if shown else ""
