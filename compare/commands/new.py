"""The commands ``new`` and ``schema``: a scene file to edit, and the JSON Schema of all."""

from __future__ import annotations

from pathlib import Path
from shlex import quote

from rollbench.compare.commands.terminal import Word, app
from rollbench.compare.text.printing import Answer, print_answer, print_json


@app.command
def new(file: Path, *, kind: Word = "", like: Word = "") -> None:
    """Write a commented scene to edit.

    Parameters
    ----------
    file
        Where to write it; an existing file is never overwritten.
    kind
        ball-screw unless given, bearing, several sets on one shaft: axis, double-nut, angular-contact-bearing,
        support-bearings; or what only friction solves: bearing-ball, bearing-pair, linear-pair, linear-chain,
        screw-pair, screw-run.
    like
        Nominal diameter and lead of a ball screw or double nut in mm, such as 40x10: the rest as is usual for such a
        size.
    """
    from rollbench.compare import files
    from rollbench.compare.files import write_new
    from rollbench.compare.scenes.duty_cycle import WHOLE
    from rollbench.compare.scenes.template import AXES, BEARINGS, text_of

    schema_line = f"#:schema {files.place('scene.schema.json').as_uri()}\n"  # editors complete and check keys by it
    write_new(file, schema_line + text_of(kind, like))
    command = "solve" if (kind or "ball screw").replace("-", " ") in (*WHOLE, *AXES, *BEARINGS) else "friction"
    print_answer(Answer(parts=[f"wrote {file}; solve it with: rollbench {command} {quote(str(file))}"]))


@app.command
def schema() -> None:
    """Print the JSON Schema of a scene file, of all kinds."""
    from rollbench.compare.scenes.friction_kinds.table import json_schema

    print_json(json_schema())
