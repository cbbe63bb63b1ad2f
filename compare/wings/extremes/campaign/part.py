"""Outcomes of a campaign that is under way, a checksummed line each, so that an interrupted one goes on."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

from rollbench.comparison import __version__
from rollbench.comparison.provenance import sources_hash
from rollbench.comparison.wings.extremes.campaign.scenes import Outcome
from rollbench.comparison.wings.sweep.store import packed, unpacked

#: Packages whose sources an outcome depends on.
PACKAGES = ("meshes", "lowfi", "compare")


def sources() -> str:
    """Digest of the Python sources that outcomes depend on."""
    return sources_hash(PACKAGES)[:16]


class Part:
    """A file beside that of the counts; it is begun anew where seed, model, version or sources are others."""

    def __init__(self, path: Path, seed: int, model: str) -> None:
        """Read the outcomes that the file has of this campaign. Raises OSError where it cannot be written."""
        self.path = path
        head = {"seed": seed, "model": model, "version": __version__, "sources": sources()}
        lines = [unpacked(line) for line in path.read_bytes().splitlines(keepends=True)] if path.exists() else []
        known = [line for line in lines[1:] if line is not None] if lines[:1] == [head] else None
        if known is None:
            path.write_bytes(packed(head))
        self.outcomes = {line["number"]: Outcome(**line) for line in known or ()}

    def add(self, outcome: Outcome) -> None:
        """Append an outcome."""
        line: dict[str, Any] = asdict(outcome)
        with self.path.open("ab") as file:
            file.write(packed(line))
        self.outcomes[outcome.number] = outcome
