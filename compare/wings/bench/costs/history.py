"""What each release reached on the case studies: errors, the reference's uncertainty, run times and memory.

The rows are kept with the package: a timed report of a version that has none yet adds it to its store. Rows of releases
before that were read off the reports that these releases shipped; what they did not measure, or measured otherwise, is said
or left empty.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from rollbench.comparison.writing import replace_file

#: File of a store that holds them.
FILE = "history.json"
#: Quantities by key, with their units; None where a release has no number.
QUANTITIES = {
    "error": "largest error / % of the mean load",
    "u": "grid uncertainty / % of the mean load",
    "cold": "run time, cold / s",
    "memory": "peak memory / MB",
}
#: What numbers are kept of: models, and the reference on its finest level.
NAMES = ("refined", "lin", "mei", "3D reference")

Values = Mapping[str, Mapping[str, float | None]]


@dataclass(frozen=True)
class Release:
    """A release: version, day, commit, numbers by quantity and name, and what is to be known of them."""

    version: str
    date: str
    commit: str
    values: Values
    remark: str = ""


def load(stores: Sequence[Path]) -> tuple[Release, ...]:
    """Releases of the first store that has any, oldest first; none without a valid file."""
    for store in stores:
        try:
            rows = json.loads((store / FILE).read_text(encoding="utf-8"))
            return tuple(Release(**row) for row in rows)
        except (OSError, ValueError, TypeError):
            continue
    return ()


def save(store: Path, releases: Sequence[Release]) -> None:
    """Write releases into a store. Raises InputError where it cannot be written."""
    rows = ",\n ".join(json.dumps(asdict(release)) for release in releases)
    replace_file(store / FILE, f"[{rows}]\n")


def added(known: Sequence[Release], new: Release) -> tuple[Release, ...]:
    """The releases with a new one at the end, unless there is one of its version: a release is not rewritten."""
    return tuple(known) if any(one.version == new.version for one in known) else (*known, new)
