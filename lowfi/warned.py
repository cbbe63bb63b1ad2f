"""Warnings attached to a result: each states why the result is outside the range of validity of its models."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal, get_args

#: Subjects of warnings that a result is outside the range of validity of its models: geometry, loads, friction.
Geometry = Literal["off arc", "two flanks", "motion", "size", "profile", "tilt", "rotation"]
Load = Literal["pressure", "wedged", "preload", "safety", "buckling", "speed", "balance"]
OfFriction = Literal["jam", "feedback", "slip"]
#: Subjects of warnings that the scene should state more, or something else, if its result is to mean what is asked.
Input = Literal["conformity", "play", "coefficient", "held load", "lost preload"]
#: Subjects of remarks, with which the result holds.
Remark = Literal["edge", "jam search", "third flank", "balance of slip"]
Kind = Geometry | Load | OfFriction | Input | Remark
#: All subjects by what they say of a result: the one table that `solve`, `friction`, `check` and ``--strict`` ask.
VALIDITY = (*get_args(Geometry), *get_args(Load), *get_args(OfFriction))
INPUT, REMARK = get_args(Input), get_args(Remark)
#: Words for a result outside the range of validity of its models.
OUTSIDE = "outside what the models mean"


class ResultWarning(str):
    """Text of a warning about a result, with a keyword for its subject and a short form for the line above the results.

    Every warning has a short form but remarks; with ``--strict``, a command ends with exit code 1 if there is one.

    Examples
    --------
    >>> found = ResultWarning("rotation", "a section turns by 60 mrad: ...", "rotations up to 60 mrad")
    >>> found.kind, found.with_part_name("nut 1"), found.with_part_name("nut 1").brief
    ('rotation', 'nut 1: a section turns by 60 mrad: ...', 'nut 1: rotations up to 60 mrad')
    """

    #: Keyword for the subject of the warning, such as "pressure".
    kind: Kind
    #: Short form of the warning for the line above a printed table of results; empty for a remark.
    brief: str

    def __new__(cls, kind: Kind, text: str, brief: str = "") -> ResultWarning:
        """Create a warning from its subject, its text and its short form (empty: the text, unless it is a remark)."""
        warned = super().__new__(cls, text)
        warned.kind, warned.brief = kind, "" if kind in REMARK else brief or text
        return warned

    @property
    def outside_validity(self) -> bool:
        """Whether the warning says that the result is outside the range of validity of its models."""
        return self.kind in VALIDITY

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
        Warnings of a result; remarks are left out of the line.
    """
    shown = [w for w in warnings if w.brief]
    outside = f" {OUTSIDE}" * any(w.outside_validity for w in shown)
    return f"WARNING{outside}: {'; '.join(w.brief for w in shown)}" if shown else ""
