"""The commands ``new`` (a scene file to edit) and ``schema`` (the JSON Schema of scene files)."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import Annotated

from cyclopts import Parameter

from rollbench.compare.commands.terminal import Word, app
from rollbench.compare.errors import ArgumentError
from rollbench.compare.text.printing import Answer, print_answer, print_json


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
    """Write a commented scene file to edit.

    Parameters
    ----------
    file
        File to write; an existing file is never overwritten.
    kind
        ball-screw (default), bearing; several sets on one shaft: axis, double-nut, angular-contact-bearing,
        support-bearings; for friction only: bearing-ball, bearing-pair, linear-pair, linear-chain, screw-pair, screw-run.
    like
        Nominal diameter and lead of a ball screw or double nut in mm, such as 40x10; other dimensions are typical of that
        size.
    rexs
        REXS file (1.7) with bearings on a shaft, from which to make the scene.
    shaft
        With --rexs: name or id of the shaft, if the file has several.
    set
        With --rexs: value that the file lacks, KEY=VALUE, such as --set "left.rollers.ring_depth=5 mm"; may be repeated.
    """
    from rollbench.compare import files
    from rollbench.compare.files import write_new
    from rollbench.compare.scenes.duty_cycle import WHOLE
    from rollbench.compare.scenes.template import AXES, BEARINGS, text_of

    if rexs is not None:
        if kind or like:
            raise ArgumentError("rexs", str(rexs), "no `kind` or `like` with it", "leave them out")
        print_answer(new_of_rexs(file, rexs, shaft, set or []))
        return
    if shaft or set:
        raise ArgumentError("shaft, set", "given", "with `rexs`", "name the REXS file")
    schema_line = f"#:schema {files.place('scene.schema.json').as_uri()}\n"  # editors complete and check keys by it
    write_new(file, schema_line + text_of(kind, like))
    command = "solve" if (kind or "ball screw").replace("-", " ") in (*WHOLE, *AXES, *BEARINGS) else "friction"
    print_answer(Answer(parts=[f"wrote {file}; solve it with: rollbench {command} {quote(str(file))}"]))


def new_of_rexs(file: Path, rexs: Path, shaft: str, given: list[str]) -> Answer:
    """Write the scene of a REXS file.

    Raises InputError for missing values, and where the file does not give a valid scene.
    """
    from rollbench.compare.files import write_new
    from rollbench.compare.scenes import scene_file
    from rollbench.compare.scenes.from_rexs import tables_of
    from rollbench.meshes.scene_text import given_keys as filled
    from rollbench.meshes.scene_text import to_toml

    pairs = {}
    for text in given:
        key, equals, value = text.partition("=")
        if not equals:
            raise ArgumentError("set", text, 'KEY=VALUE, such as "left.rollers.ring_depth=5 mm"', "write both")
        pairs[key.strip()] = value.strip()
    tables, notes = tables_of(rexs, shaft, pairs)
    text = to_toml(filled(**tables))
    scene_file.parse_scene(text, str(file))
    write_new(file, text)
    lines = [f"left out: {note}" for note in notes]
    lines.append(f"wrote {file}; solve it with: rollbench solve {quote(str(file))}")
    return Answer(parts=lines, folded=True)


@app.command
def schema() -> None:
    """Print the JSON Schema of scene files of all kinds."""
    from rollbench.compare.scenes.friction_kinds.table import json_schema

    print_json(json_schema())
