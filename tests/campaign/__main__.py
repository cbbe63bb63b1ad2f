"""Random extreme scenes, mutated files and killed processes, each outcome judged by a check of its own:

    python -m tests.campaign --random 2000 --seed 7 --keep compare/studies/campaign.json
    python -m tests.campaign --axes 300 --seed 7

It prints the counts and every bad outcome, and ends with 1 where there is one. With --keep the counts go to the file that
the report reads, and an interrupted campaign goes on from the lines it left next to that file, as long as no source has
changed.
"""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Callable
from contextlib import redirect_stdout
from functools import partial
from pathlib import Path
from typing import Any

from tests.campaign import record
from tests.campaign.scenes import Campaign, Part

from rollbench.compare.cli import app_with_commands
from rollbench.compare.errors import InputError
from rollbench.compare.files import replace_file
from rollbench.compare.models.registry import AXIS_MODELS, MODELS
from rollbench.meshes.processes import limit_to_one_thread


def captured(run: Callable[[list[str]], Any], tokens: list[str]) -> tuple[int, str]:
    """Exit code of a command and what it prints on standard output; 2 and its line where it refuses its input."""
    out = io.StringIO()
    try:
        with redirect_stdout(out):
            code = int(run(tokens))
    except InputError as error:
        return 2, str(error)
    return code, out.getvalue()


def command_line() -> Callable[[list[str]], tuple[int, str]]:
    """What runs ``rollbench solve`` in this process, and gives its exit code and text."""
    run = partial(app_with_commands("solve"), exit_on_error=False, print_error=False, result_action="return_value")
    return partial(captured, run)


def progress(done: int, total: int, text: str) -> None:
    """One line on a terminal, which the next one takes the place of."""
    if sys.stderr.isatty():
        sys.stderr.write(f"\r\033[K[{done}/{total}] {text}")


def main(arguments: list[str] | None = None) -> int:
    """Run a campaign; 1 where any outcome is bad."""
    parser = argparse.ArgumentParser(prog="python -m tests.campaign", description=__doc__.partition("\n")[0])
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--random", type=int, metavar="COUNT", help="random screws and bearings")
    what.add_argument("--axes", type=int, metavar="COUNT", help="random axes, one to five sets on one shaft")
    parser.add_argument("--seed", type=int, default=1, help="scene K of a seed is the same whatever else is run")
    parser.add_argument("--model", default="lin", choices=[name for name in MODELS if name != "condensed"])
    parser.add_argument("--files", type=int, default=0, help="mutated scene files, and half as many stored files")
    parser.add_argument("--kills", type=int, default=0, help="how often a writing process is killed")
    parser.add_argument("--keep", type=Path, help="file of records to add the counts to")
    asked = parser.parse_args(arguments)
    axes = asked.axes is not None
    count = asked.axes if axes else asked.random
    if count < 1 or min(asked.seed, asked.files, asked.kills) < 0:
        parser.error("counts are 1 or more; seed, --files and --kills 0 or more")
    if axes and asked.model not in AXIS_MODELS:
        parser.error(f"--model of axes: {', '.join(AXIS_MODELS)}")
    campaign = Campaign(asked.seed, count, asked.model, asked.files, asked.kills, axes, command_line())
    part = asked.keep and asked.keep.with_name(f"{asked.keep.name}{campaign.option}.{asked.model}-{asked.seed}.part")
    kept = part and Part(part, asked.seed, asked.model)
    found = record.run_campaign(campaign, progress, kept)
    if asked.keep:
        replace_file(asked.keep, record.text(found, asked.keep))
        part.unlink(missing_ok=True)
    print("\n".join(record.lines(found)))
    return 1 if found["bad"] else 0


if __name__ == "__main__":
    limit_to_one_thread()
    sys.exit(main())
