"""Counts of a campaign as a record: run, printed, kept in a file, read again for the report."""

from __future__ import annotations

import datetime
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rollbench.comparison import __version__
from rollbench.comparison.errors import one_line
from rollbench.comparison.wings.extremes.campaign import files, scenes
from rollbench.comparison.wings.extremes.campaign.scenes import Campaign, Part, Progress
from rollbench.reports.content import Row

Record = dict[str, Any]


def run_campaign(what: Campaign, progress: Progress = lambda *_: None, kept: Part | None = None) -> Record:
    """A campaign, JSON-ready: command, day, counts by verdict, all bad outcomes, seconds of the scenes (median, largest).

    kept: the outcomes of one that was cut short, and where this one writes its own.
    """
    outcomes = scenes.judge_scenes(what, progress, kept)
    broken = [*files.scenes(what.seed, what.files), *files.stored(what.seed, what.files // 2)]
    broken += files.kills(what.seed, what.kills)
    seconds = sorted(o.seconds for o in outcomes)
    extra = f" --files {what.files}" * bool(what.files) + f" --kills {what.kills}" * bool(what.kills)
    faults: list[tuple[str, Any, str, str]]
    faults = [("scene", o.number, o.verdict, o.words) for o in outcomes if o.verdict in scenes.BAD]
    faults += [("file", o.kind, o.verdict, o.words) for o in broken if not o.good]
    bad = [{of: which, "verdict": verdict, "words": one_line(words, 400)} for of, which, verdict, words in faults]
    return {
        "command": f"rollbench stability {what.option} {what.count} --seed {what.seed} --model {what.model}{extra}",
        "version": __version__,
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d"),
        "seed": what.seed,
        "model": what.model,
        "scenes": scenes.tally(outcomes),
        "files": files.tally(broken),
        "seconds": {"median": seconds[len(seconds) // 2], "largest": seconds[-1]},
        "bad": bad,
    }


def lines(found: Record) -> list[str]:
    """The record in words."""
    out = [found["command"]]
    out += [f"scenes {verdict}: {count}" for verdict, count in found["scenes"].items()]
    out += [f"{kind} {verdict}: {count}" for kind, row in found["files"].items() for verdict, count in row.items()]
    return out + [f"BAD: {bad}" for bad in found["bad"]]


def text(found: Record, path: Path) -> str:
    """Text of a file of records, one for each command, with this one added to what ``path`` holds."""
    others = [r for r in read(path) if r["command"] != found["command"]]
    return json.dumps([*others, found], indent=1, ensure_ascii=False) + "\n"


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
        bad: Row = {verdict: r["scenes"].get(verdict, 0) for verdict in scenes.BAD}
        files = [row for kind, row in r["files"].items() if kind != "kill"]
        ended: Row = {
            "command": r["command"],
            "version": r.get("version", ""),
            "right": r["scenes"][scenes.RIGHT],
            "refused with a proven reason": sum(r["scenes"][verdict] for verdict in scenes.GOOD[1:]),
            "wrong or unproven": sum(r["scenes"].get(verdict, 0) for verdict in scenes.BAD),
            "damaged files": sum(sum(row.values()) for row in files),
            "of these read wrongly": sum(row["bad"] for row in files),
            "killed processes": sum(r["files"].get("kill", {}).values()),
            "of these not whole": r["files"].get("kill", {}).get("bad", 0),
        }
        out.append(ended | bad)
    return out
