"""Random extreme scenes, mutated files and killed processes, each outcome judged by a check of its own:

    python -m tests.campaign --random 2000 --seed 7 --keep compare/studies/campaign.json
    python -m tests.campaign --axes 300 --seed 7
    python -m tests.campaign --again compare/studies/campaign.json

It prints the counts and every bad outcome, and ends with 1 where there is one. With --keep the counts go to the file that
the report reads, and an interrupted campaign goes on from the folder it left next to that file, as long as no source has
changed. --again judges the bad scenes of such a file once more, and notes there what became of them.
"""

import argparse
import io
import json
import shutil
import sys
from contextlib import redirect_stdout
from functools import lru_cache
from pathlib import Path
from unittest.mock import patch

from tests.campaign import files, scenes
from tests.campaign.draw import scene_text
from tests.campaign.draw_axes import axis_text
from tests.campaign.scenes import Campaign

from rollbench.compare import __version__
from rollbench.compare.cli import app_with_commands
from rollbench.compare.errors import InputError, one_line
from rollbench.compare.files import replace_file
from rollbench.compare.models.registry import AXIS_MODELS, MODELS
from rollbench.compare.results import solving
from rollbench.compare.studies.extremes import BAD, Record, read_campaign_records
from rollbench.compare.studies.run_times import utc_date_today
from rollbench.meshes.processes import limit_to_one_thread

SOLVE = app_with_commands("solve")
SOLVED_ONCE = lru_cache(maxsize=1)(solving.solve_with_results)


def run_solve(tokens: list[str]) -> tuple[int, str]:
    """Exit code of ``rollbench solve`` in this process and what it prints; 2 and its line where it refuses its input.

    A scene that is asked for again, as text and as JSON, is solved once.
    """
    out = io.StringIO()
    try:
        with redirect_stdout(out), patch.object(solving, "solve_with_results", SOLVED_ONCE):
            code = int(SOLVE(tokens, exit_on_error=False, print_error=False, result_action="return_value"))
    except InputError as error:
        return 2, str(error)
    return code, out.getvalue()


def run_campaign(what: Campaign, folder: Path | None) -> Record:
    """A campaign, JSON-ready: command, day, counts by verdict, all bad outcomes, seconds of the scenes (median, largest).

    folder: keeps the outcomes of its scenes, see `scenes.judge_scenes`. A terminal shows its progress.
    """
    outcomes = []
    for outcome in scenes.judge_scenes(what, folder):
        outcomes.append(outcome)
        if sys.stderr.isatty():
            sys.stderr.write(f"\r\033[K[{len(outcomes)}/{what.count}] scene {outcome.number}: {outcome.verdict}")
    broken = [*files.scenes(what.seed, what.files), *files.stored(what.seed, what.files // 2)]
    broken += files.kills(what.seed, what.kills)
    seconds = sorted(o.seconds for o in outcomes)
    option = f"{'--axes' if what.axes else '--random'} {what.count} --seed {what.seed} --model {what.model}"
    extra = f" --files {what.files}" * bool(what.files) + f" --kills {what.kills}" * bool(what.kills)
    faults = [("scene", o.number, o.verdict, o.words) for o in outcomes if o.verdict in BAD]
    faults += [("file", o.kind, o.verdict, o.words) for o in broken if not o.good]
    return {
        "command": f"python -m tests.campaign {option}{extra}",
        "version": __version__,
        "date": utc_date_today(),
        "seed": what.seed,
        "model": what.model,
        "scenes": scenes.tally(outcomes),
        "files": files.tally(broken),
        "seconds": {"median": seconds[len(seconds) // 2], "largest": seconds[-1]},
        "bad": [{of: which, "verdict": verdict, "words": one_line(words, 400)} for of, which, verdict, words in faults],
    }


def keep(found: Record, path: Path) -> None:
    """Add a record to a file of records, one for each command."""
    others = [r for r in read_campaign_records(path) if r["command"] != found["command"]]
    replace_file(path, json.dumps([*others, found], indent=1, ensure_ascii=False) + "\n")


def judge_bad_scenes_again(path: Path) -> list[Record]:
    """Judge every bad scene of a file of records again, note outcome, version and day there, and return the bad scenes."""
    records = read_campaign_records(path)
    bad = [(record, one) for record in records for one in record["bad"] if "scene" in one]
    for record, one in bad:
        draw = axis_text if "--axes" in record["command"] else scene_text
        now = scenes.judge(record["seed"], one["scene"], record["model"], run_solve, draw)
        words = one_line(now.words, 400)
        one["again"] = {"version": __version__, "date": utc_date_today(), "verdict": now.verdict, "words": words}
    replace_file(path, json.dumps(records, indent=1, ensure_ascii=False) + "\n")
    return [one for _, one in bad]


def main(arguments: list[str] | None = None) -> int:
    """Run a campaign; 1 where any outcome is bad."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaign", description=__doc__.partition("\n")[0])
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--random", type=int, metavar="COUNT", help="random screws and bearings")
    what.add_argument("--axes", type=int, metavar="COUNT", help="random axes, one to five sets on one shaft")
    what.add_argument("--again", type=Path, metavar="FILE", help="the bad scenes of a file of records")
    parser.add_argument("--seed", type=int, default=1, help="scene K of a seed is the same whatever else is run")
    parser.add_argument("--model", default="lin", choices=[name for name in MODELS if name != "condensed"])
    parser.add_argument("--files", type=int, default=0, help="mutated scene files, and half as many stored files")
    parser.add_argument("--kills", type=int, default=0, help="how often a writing process is killed")
    parser.add_argument("--keep", type=Path, help="file of records to add the counts to")
    asked = parser.parse_args(arguments)
    if asked.again:
        again = judge_bad_scenes_again(asked.again)
        print("\n".join(map(str, again)))
        return int(any(one["again"]["verdict"] in BAD for one in again))
    axes = asked.axes is not None
    count = asked.axes if axes else asked.random
    if count < 1 or min(asked.seed, asked.files, asked.kills) < 0:
        parser.error("counts are 1 or more; seed, --files and --kills 0 or more")
    if axes and asked.model not in AXIS_MODELS:
        parser.error(f"--model of axes: {', '.join(AXIS_MODELS)}")
    campaign = Campaign(asked.seed, count, asked.model, asked.files, asked.kills, axes, run_solve)
    name = f"{asked.keep.name}{'--axes' if axes else '--random'}.{asked.model}-{asked.seed}.part" if asked.keep else ""
    folder = asked.keep.with_name(name) if asked.keep else None
    try:
        found = run_campaign(campaign, folder)
    except InputError as error:
        parser.error(str(error))
    if folder:
        keep(found, asked.keep)
        shutil.rmtree(folder)
    print(found["command"])
    for kind, row in ({"scenes": found["scenes"]} | found["files"]).items():
        print("\n".join(f"{kind} {verdict}: {number}" for verdict, number in row.items()))
    for bad in found["bad"]:
        print(f"BAD: {bad}")
    return 1 if found["bad"] else 0


if __name__ == "__main__":
    limit_to_one_thread()
    sys.exit(main())
