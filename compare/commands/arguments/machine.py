"""The machine that rollbench runs on: doctor, completion."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Literal

from rollbench.comparison.commands.arguments.terminal import Flag, Json, app
from rollbench.comparison.commands.printing import Answer, print_answer, writing


@app.command
def doctor(
    *,
    store: Path = Path("rollbench-reference"),
    requirements: Literal["check", "solve", "compare", "report", "all"] | None = None,
    as_json: Json = False,
) -> int:
    """Check this machine: packages, system libraries, drawing, folders, memory; what is missing and disabled; licences.

    Exit codes: 0 nothing is missing (programs marked optional may be), 1 something is.

    Parameters
    ----------
    store
        Folder of the reference's runs.
    requirements
        Instead: the pinned lines of packages that a command needs, as installed here: check beside stored runs, solve,
        compare, report, or all.
    """
    if requirements is not None:
        from rollbench.comparison.commands.requirements import run_requirements

        return print_answer(run_requirements(requirements), as_json)
    from rollbench.comparison.commands.doctor import run_doctor

    return print_answer(run_doctor(store), as_json)


@app.command
def completion(shell: Literal["bash", "zsh", "fish"], *, install: Flag = False) -> None:
    """Print what makes a shell complete commands and options, or install it.

    For this session alone: eval "$(rollbench completion bash)".

    Parameters
    ----------
    shell
        bash, zsh or fish.
    install
        Write it where the shell looks for it in the home folder, and print where that is.
    """
    text = app.generate_completion(prog_name="rollbench", shell=shell)
    if install:
        print_answer(Answer(parts=[f"{app.install_completion(shell=shell)} written; open a new shell"]))
    else:
        with writing():
            sys.stdout.write(f"{text}\n")
