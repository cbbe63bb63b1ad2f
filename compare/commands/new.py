"""Commands ``new``, which writes a scene file to edit, and ``schema``, which prints the JSON Schema of scene files."""

from __future__ import annotations

import re
from pathlib import Path
from shlex import quote
from typing import Annotated

from cyclopts import Parameter

from rollbench.compare.commands.terminal import Word, app
from rollbench.compare.errors import ArgumentError
from rollbench.compare.text.printing import CommandOutput, print_command_output, print_json


@app.command
def new(
    file: Path,
    *,
    kind: Word = "",
    like: Word = "",
    rexs: Path | None = None,
    shaft: Word = "",
    set: Annotated[list[str] | None, Parameter(name="--set")] = None,
) -> None:
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
        Nominal diameter and lead of a ball screw or double nut in mm, such as 40x10; other dimensions are typical of this
        size.
    rexs
        REXS file (version 1.7) with bearings on a shaft, from which the scene is made.
    shaft
        With --rexs: name or id of the shaft, if the file has several.
    set
        With --rexs: value that is missing in the file, as KEY=VALUE, such as --set "left.rollers.ring_depth=5 mm"; may be
        repeated.
    """
    from rollbench.compare import files
    from rollbench.compare.scenes.duty_cycle import WHOLE
    from rollbench.compare.scenes.template import AXES, BEARINGS, new_scene_text

    if rexs is not None:
        if kind or like:
            allowed = "`rexs` without `kind` and `like`: the REXS file determines the kind and size of the scene"
            raise ArgumentError("rexs", f"{rexs} with `kind` or `like`", allowed, "leave these options out")
        print_command_output(write_scene_from_rexs(file, rexs, shaft, set or []))
        return
    if shaft or set:
        advice = "add `rexs` with the name of the file"
        raise ArgumentError("shaft, set", "one of these options without a REXS file", "only with `rexs`", advice)
    if not like and re.fullmatch(r"\d+(\.\d+)?x\d+(\.\d+)?", file.name):
        raise ArgumentError("file", str(file), "the name of a file", f"write: rollbench new my.toml --like {file.name}")
    schema_line = f"#:schema {files.shipped_path('scene.schema.json').as_uri()}\n"  # lets editors complete and check keys
    files.write_new_file(file, schema_line + new_scene_text(kind, like))
    command = "solve" if (kind or "ball screw").replace("-", " ") in (*WHOLE, *AXES, *BEARINGS) else "friction"
    line = f"wrote {file}; solve it with: rollbench {command} {quote(str(file))}"
    print_command_output(CommandOutput(texts_and_tables=[line]))


def write_scene_from_rexs(file: Path, rexs: Path, shaft: str, given: list[str]) -> CommandOutput:
    """Convert bearings on a shaft from a REXS file to a scene file, and return lines on what was not converted.

    ``file``: scene file to write. ``shaft``: name or id of the shaft. ``given``: texts KEY=VALUE with values that the REXS
    file lacks. Raises InputError if values are missing, or if the scene is not valid.
    """
    from rollbench.compare.files import write_new_file
    from rollbench.compare.scenes import scene_file
    from rollbench.compare.scenes.from_rexs import scene_tables_from_rexs
    from rollbench.meshes.scene_text import toml_of_tables
    from rollbench.meshes.scene_text import without_empty_values as filled

    pairs = {}
    for text in given:
        key, equals, value = text.partition("=")
        if not equals:
            allowed = 'KEY=VALUE, such as "left.rollers.ring_depth=5 mm"'
            raise ArgumentError("set", text, allowed, "write key and value with = between them")
        pairs[key.strip()] = value.strip()
    tables, notes = scene_tables_from_rexs(rexs, shaft, pairs)
    text = toml_of_tables(filled(**tables))
    scene_file.parse_scene(text, str(file))
    write_new_file(file, text)
    lines = [f"not converted: {note}" for note in notes]
    lines.append(f"wrote {file}; solve it with: rollbench solve {quote(str(file))}")
    return CommandOutput(texts_and_tables=lines, wrap_always=True)


@app.command
def schema() -> None:
    """Print the JSON Schema of scene files of all kinds."""
    from rollbench.compare.scenes.friction_kinds.table import scene_json_schema

    print_json(scene_json_schema())
