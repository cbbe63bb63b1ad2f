"""Counts of a campaign as a record: run, printed, kept in a file for the report."""

from __future__ import annotations

import datetime
import json
from pathlib import Path
from typing import Any

from tests.campaign import files, scenes
from tests.campaign.scenes import Campaign, Part, Progress

from rollbench.compare import __version__
from rollbench.compare.errors import one_line
from rollbench.compare.studies.extremes import Record, read_campaign_records


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
        "command": f"python -m tests.campaign {what.option} {what.count} --seed {what.seed} --model {what.model}{extra}",
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
    others = [r for r in read_campaign_records(path) if r["command"] != found["command"]]
    return json.dumps([*others, found], indent=1, ensure_ascii=False) + "\n"
