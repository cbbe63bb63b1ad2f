"""What a result warns of: where it leaves the range in which its models hold."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

Kind = Literal[
    "place",
    "two flanks",
    "size",
    "pressure",
    "wedged",
    "profile",
    "tilt",
    "rotation",
    "preload",
    "safety",
    "conformity",
    "play",
    "coefficient",
    "held load",
    "feedback",
    "slip",
    "jam",
    "balance",
    "buckling",
    "speed",
]


class Warned(str):
    """A warning: the text is its sentence, ``kind`` its subject; one with ``brief`` is printed above the answers.

    >>> found = Warned("rotation", "a section turns by 60 mrad: ...", "rotations up to 60 mrad")
    >>> found.kind, found.of("nut 1"), found.of("nut 1").brief
    ('rotation', 'nut 1: a section turns by 60 mrad: ...', 'nut 1: rotations up to 60 mrad')
    """

    kind: Kind
    brief: str

    def __new__(cls, kind: Kind, text: str, brief: str = "") -> Warned:
        """A sentence with its kind, and few words for the line above the answers where it belongs there."""
        warned = super().__new__(cls, text)
        warned.kind, warned.brief = kind, brief
        return warned

    def __getnewargs__(self) -> tuple[Kind, str, str]:  # type: ignore[override]
        """Arguments that a copy is made of, in another process too."""
        return self.kind, str(self), self.brief

    def of(self, name: str) -> Warned:
        """The same of one of several parts."""
        return Warned(self.kind, f"{name}: {self}", self.brief and f"{name}: {self.brief}")


def above(warnings: Iterable[Warned]) -> str:
    """The line above the answers, empty where none of the warnings belongs there."""
    shown = [w for w in warnings if w.brief]
    outside = " outside what the models mean" * any(w.kind not in ("play", "coefficient", "held load") for w in shown)
    return f"WARNING{outside}: {'; '.join(w.brief for w in shown)}" if shown else ""
