"""Commands ``new``, which writes a scene file to edit, and ``schema``, which prints the JSON Schema of scene files."""

from __future__ import annotations

import re
from pathlib import Path
from shlex import quote

from rollbench.compare.commands.terminal import Word, app
from rollbench.compare.errors import ArgumentError
from rollbench.compare.text.printing import CommandOutput, print_command_output, print_json


@app.command
def new(file: Path, *, kind: Word = "", like: Word = "") -> None:
    """Write a scene file with comments, to be edited by the user.

    Parameters
    ----------
    file
        File to write; an existing file is never overwritten.
    kind
        Kind of scene: ball-screw (default) or bearing; for several nuts or bearings on one shaft: axis, double-nut,
        angular-contact-bearing, support-bearings; for friction only: bearing-ball (one ball of a rotary bearing),
        bearing-pair (a four-point and a double-row bearing), linear-pair (two balls of a linear bearing), linear-chain
        (more balls of it), screw-pair (two balls of a ball screw), screw-run (a ball screw that turns for some time).
    like
        Nominal diameter and lead of a ball screw or double nut in mm, such as 40x10; or a maker's name of a nut or bearing,
        such as "HIWIN R40-10T4-FSI", for what is printed of it: see rollbench list --makers HIWIN. Other dimensions are
        typical.
    """
    from rollbench.compare import files
    from rollbench.compare.scenes.catalogue_part import scene_text_of_catalogue_part
    from rollbench.compare.scenes.duty_cycle import WHOLE
    from rollbench.compare.scenes.template import AXES, BEARINGS, new_scene_text

    if not like and re.fullmatch(r"\d+(\.\d+)?x\d+(\.\d+)?", file.name):
        raise ArgumentError("file", str(file), "the name of a file", f"write: rollbench new my.toml --like {file.name}")
    text = scene_text_of_catalogue_part(like, kind) if re.search(r"[A-WYZa-wyz]", like) else new_scene_text(kind, like)
    files.write_new_file(file, text)
    command = "solve" if (kind or "ball screw").replace("-", " ") in (*WHOLE, *AXES, *BEARINGS) else "friction"
    line = f"wrote {file}; solve it with: rollbench {command} {quote(str(file))}"
    print_command_output(CommandOutput(texts_and_tables=[line]))


@app.command
def schema() -> None:
    """Print the JSON Schema of scene files of all kinds."""
    from rollbench.compare.scenes.kinds import scene_json_schema

    print_json(scene_json_schema())
