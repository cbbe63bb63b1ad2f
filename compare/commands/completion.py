"""The command rollbench completion."""

from __future__ import annotations

import sys
from typing import Literal

from rollbench.compare.commands.terminal import Flag, app
from rollbench.compare.text.printing import Answer, print_answer, writing


@app.command
def completion(shell: Literal["bash", "zsh", "fish"], *, install: Flag = False) -> None:
    """Print what makes a shell complete commands and options, or install it.

    For this session only: eval "$(rollbench completion bash)".

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
