"""Records of the random campaigns, which ``python -m tests.campaign`` of the repository runs and writes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rollbench.reports.content import Row

Record = dict[str, Any]
#: How a scene may end, the good ways first.
RIGHT, REFUSED, PROVEN, NOT_UNIQUE = "right", "refused as input", "refused, proven", "refused, contacts not unique"
WRONG, UNPROVEN, SILENT, CRASHED = "wrong", "refused, unproven", "refused without a mechanism", "traceback"
MISSTATED = "misstated by the command line"
GOOD, BAD = (RIGHT, REFUSED, PROVEN, NOT_UNIQUE), (WRONG, UNPROVEN, SILENT, CRASHED, MISSTATED)


def read(path: Path) -> list[Record]:
    """Records of a file; none where there is none, or it holds something else."""
    try:
        records = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return []
    good = isinstance(records, list) and all(
        isinstance(r, dict) and {"command", "scenes", "files", "bad"} <= set(r) for r in records
    )
    return records if good else []


def shipped() -> list[Record]:
    """Records that come with the package."""
    return read(Path(__file__).with_name("campaign.json"))


def rows(records: Sequence[Record]) -> list[Row]:
    """Rows of the report's table, a campaign each: its command and version, and how many scenes, damaged files and killed
    processes ended in which way."""
    out = []
    for r in records:
        bad: Row = {verdict: r["scenes"].get(verdict, 0) for verdict in BAD}
        files = [row for kind, row in r["files"].items() if kind != "kill"]
        ended: Row = {
            "command": r["command"],
            "version": r.get("version", ""),
            "right": r["scenes"][RIGHT],
            "refused with a proven reason": sum(r["scenes"][verdict] for verdict in GOOD[1:]),
            "wrong or unproven": sum(r["scenes"].get(verdict, 0) for verdict in BAD),
            "damaged files": sum(sum(row.values()) for row in files),
            "of these read wrongly": sum(row["bad"] for row in files),
            "killed processes": sum(r["files"].get("kill", {}).values()),
            "of these not whole": r["files"].get("kill", {}).get("bad", 0),
        }
        out.append(ended | bad)
    return out
