"""What is shipped, one scene's files, and one scene by a low-order model: list, schema, new, solve, condense."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import Annotated

from cyclopts import Parameter

from rollbench.compare.commands.arguments.terminal import Flag, Json, Word, app, cache_folder
from rollbench.compare.commands.printing import Answer, print_answer, print_json
from rollbench.compare.errors import ArgumentError
from rollbench.compare.registration import needed


@app.command(name="list")
def list_(*, trace: Flag = False, table: Word = "", as_json: Json = False) -> None:
    """List the scenes, the models and the printed tables that are shipped.

    Parameters
    ----------
    trace
        Instead: every printed number and claim with its scenes, or why it has none, the function that computes it and its
        test.
    table
        The same for the numbers of one printed table.
    """
    from rollbench.compare.commands import listing

    if trace or table:
        from rollbench.compare.commands.printed import traced

        print_answer(traced(table), as_json)
    else:
        print_answer(listing.shipped(), as_json)


@app.command
def schema() -> None:
    """Print the JSON Schema of a scene file, of all kinds."""
    from rollbench.compare.scenes.kinds import json_schema

    print_json(json_schema())


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
    from rollbench.compare.registration import ROOT
    from rollbench.compare.scenes.names import WHOLE
    from rollbench.compare.scenes.template import AXES, BEARINGS, text_of
    from rollbench.compare.writing import write_new

    schema_line = f"#:schema {(ROOT / 'scene.schema.json').as_uri()}\n"  # editors complete and check keys by it
    write_new(file, schema_line + text_of(kind, like))
    command = "solve" if (kind or "ball screw").replace("-", " ") in (*WHOLE, *AXES, *BEARINGS) else "friction"
    print_answer(Answer(parts=[f"wrote {file}; solve it with: rollbench {command} {quote(str(file))}"]))


@app.command
def solve(
    scene: str,
    *,
    model: Word = "",
    as_json: Json = False,
    everything: Annotated[Flag, Parameter(name="--all")] = False,
    member: int = 0,
    condensed: Path | None = None,
    balls: Flag = False,
    stiffness_at: Word = "",
    matrix: Path | None = None,
    curve: Path | None = None,
    loads_csv: Path | None = None,
    members: int | None = None,
    csv: Path | None = None,
    seed: int | None = None,
    workers: int | None = None,
    time_limit: float | None = None,
    strict: Flag = False,
    assumptions: Flag = False,
) -> int:
    """Solve one scene with one model, or many members of a scene with random errors.

    The answers come first: loads, rigidity, pressure, safety, preload, friction, life.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file.
    model
        refined unless given, or "condensed" where its file is given; see: rollbench list.
    everything
        Build all parts, even those that the scene does not need.
    member
        Number of the specimen, for a scene with random errors.
    condensed
        File that rollbench condense made of these parts: bodies of a condensed 3D model, for the model "condensed".
    balls
        Print the table of all balls.
    stiffness_at
        Also the 6 x 6 tangent stiffness at a station of the screw, such as "400 mm", against the held nut.
    matrix
        File for that matrix: .mtx (Matrix Market) or .dmig (Nastran).
    curve
        File (.csv) for displacement, stiffness, largest load and torque at 0 to 1.5 times the loads; a figure beside it.
    loads_csv
        File for all contact loads, as check --loads reads it: ball, flank, newton, azimuth_deg, z_mm; of load cases with a
        column case.
    members
        Number of members to solve: distributions of the largest load, stiffness, lost contacts, life; with --balls bands of
        every ball.
    csv
        With --members: file with one row per member.
    seed
        With --members: seed of the random errors in place of the scene's.
    workers
        With --members: number of parallel processes.
    time_limit
        Seconds after which to give up, with exit code 1; none unless given.
    strict
        Exit with 1 if a WARNING line stands above the answers: pressure, preload, static safety or rotations beyond the
        validity of the models, or a load of which little reaches the contacts.
    assumptions
        Also print the assumptions, what is left out, the balance and the solver.
    """
    from rollbench.compare.commands.solving.solve import Choices, run_solve

    if members is not None:
        from rollbench.compare.reference.jobs import Engine

        members_of = needed("members", "command line", "--members", str(members))

        if stiffness_at or strict or any(file is not None for file in (matrix, curve, loads_csv)):
            named = "stiffness_at, matrix, curve, loads_csv, strict"
            raise ArgumentError(named, "given", "without --members", "they are of one member: --member K")
        how = Engine(workers=workers)
        return print_answer(members_of(scene, model, members, csv_out=csv, seed=seed, engine=how, balls=balls), as_json)
    if csv is not None or seed is not None or workers is not None:
        raise ArgumentError("csv, seed, workers", "given", "with --members", "add --members N")
    choices = Choices(
        model, everything, member, condensed, balls, stiffness_at, matrix, curve, loads_csv, time_limit, strict, assumptions
    )
    return print_answer(run_solve(scene, choices), as_json)


@app.command
def condense(scene: str, *, out: Path | None = None, level: int = 1) -> int:
    """Condense the 3D bodies of a scene to the contacts, for: rollbench solve SCENE --condensed FILE.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file. The file serves all loads, supports and errors of the same parts.
    out
        File to write, replaced if it exists; <scene>-condensed.npz unless given.
    level
        Mesh level, 1 (coarse) to 3.
    """
    from rollbench.compare.commands.comparing.condense import run_condense

    return print_answer(run_condense(scene, out, level, cache=cache_folder()))
