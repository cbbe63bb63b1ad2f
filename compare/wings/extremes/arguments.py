"""Options and help of ``rollbench stability``."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from rollbench.comparison.commands.arguments.terminal import Json, Word, app
from rollbench.comparison.commands.printing import print_answer
from rollbench.comparison.errors import InputError


@app.command
def stability(
    *,
    random: int | None = None,
    axes: int | None = None,
    seed: int = 1,
    model: Word = "",
    files: int = 0,
    kills: int = 0,
    survey: int | None = None,
    out: Path = Path("rollbench-survey"),
    workers: int = 1,
    keep: Path | None = None,
    as_json: Json = False,
) -> int:
    """Run the table of stiff and extreme scenes; exit 1 where this project's solver fails on any.

    With --random instead: a campaign of random extreme screws and bearings, each outcome judged by a check of its own, and
    what rollbench solve prints of it, as text and as JSON. With --survey instead: ordinary catalogue screws on the 3D
    reference, half a minute to some minutes each; exit 1 where one has no answer or did not settle.

    Parameters
    ----------
    random
        Number of random extreme scenes.
    axes
        In place of --random: number of random axes, one to five sets of balls or rollers on one shaft.
    seed
        Seed of the campaign; scene K of a seed is the same whatever else is run.
    model
        Model of the campaign's contact loads; lin unless given.
    files
        Also this many mutated scene files, and half as many mutated stored files.
    kills
        Also kill a writing process this many times.
    survey
        Number of drawn catalogue screws; the report's are 200.
    out
        Folder of the survey: a line a scene, and the runs of the 3D reference; an interrupted survey resumes there.
    workers
        Number of scenes of the survey in parallel; each needs up to 4 GB.
    keep
        File to write the campaign's counts or the survey's record to, for the report's table; an interrupted campaign goes
        on from what it left there, and a survey does not solve the scenes again that this file answers.
    """
    from rollbench.comparison.commands.arguments import commands
    from rollbench.comparison.wings.extremes.campaign.scenes import Campaign
    from rollbench.comparison.wings.extremes.command import captured, run_campaign, run_drawn, run_stability

    if survey is not None:
        if random is not None or axes is not None or seed != 1 or model or files or kills:
            given = "--random, --axes, --seed, --model, --files, --kills"
            raise InputError("command line", given, "given", "without --survey", "its scenes are always the same")
        return print_answer(run_drawn(survey, out, workers, keep), as_json)
    if random is not None and axes is not None:
        raise InputError("command line", "--axes", str(axes), "without --random", "run one campaign after the other")
    count = random if axes is None else axes
    if count is None:
        if seed != 1 or model or files or kills or keep is not None:
            raise InputError(
                "command line", "--seed, --model, --files, --kills, --keep", "given", "with --random or --axes", "add it"
            )
        return print_answer(run_stability(as_json=as_json), as_json)
    run = partial(commands("solve"), exit_on_error=False, print_error=False, result_action="return_value")
    what = Campaign(count=count, seed=seed, model=model or "lin", files=files, kills=kills, axes=axes is not None)
    return print_answer(run_campaign(replace(what, command=partial(captured, run)), keep), as_json)
