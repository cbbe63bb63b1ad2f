"""The command line. Modules that a command does not need are imported inside the command."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Annotated, Any

from cyclopts import App, CycloptsError, Parameter

from compare import __version__
from compare.errors import InputError, one_line

app = App(
    name="rollbench",
    help="Validation workbench for ball screws and rolling bearings: low-order models and their references.",
    version=__version__,
    help_format="plaintext",
)

Json = Annotated[bool, Parameter(name="--json", negative="", help="Print exactly one JSON value.")]


def _print_json(value: Any) -> None:
    sys.stdout.write(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def _show(*parts: Any) -> None:
    from rich.console import Console

    width = None if sys.stdout.isatty() else 160
    console = Console(width=width, soft_wrap=True, highlight=False, markup=False)
    for part in parts:
        console.print(part)


@app.command(name="list")
def list_(*, trace: Annotated[bool, Parameter(negative="")] = False, as_json: Json = False) -> None:
    """List the scenes, the models and the printed tables that are shipped.

    Parameters
    ----------
    trace
        Instead: every printed number and claim with its scenes, the function that computes it and its test.
    """
    from compare.commands import listing

    if trace:
        _print_json(listing.trace_json()) if as_json else _show(listing.trace_table())
    elif as_json:
        _print_json(listing.shipped_json())
    else:
        _show(*listing.shipped_lines())


@app.command
def schema() -> None:
    """Print the JSON Schema of a scene file, of all kinds."""
    from compare.scenes.kinds.table import json_schema

    _print_json(json_schema())


@app.command
def new(file: Path, *, kind: str = "ball-screw") -> None:
    """Write a commented scene to edit.

    Parameters
    ----------
    file
        Where to write it; an existing file is never overwritten.
    kind
        ball-screw, bearing, axis, double-nut, or what only friction solves: bearing-ball, bearing-pair, linear-pair,
        linear-chain, screw-pair, screw-run.
    """
    from compare.scenes.keys import WHOLE
    from compare.scenes.template import AXES, template
    from compare.writing import write_new

    write_new(file, template(kind))
    command = "solve" if kind.replace("-", " ") in (*WHOLE, *AXES) else "friction"
    _show(f"wrote {file}; solve it with: rollbench {command} {file}")


@app.command
def solve(
    scene: str,
    *,
    model: str = "",
    as_json: Json = False,
    everything: Annotated[bool, Parameter(name="--all", negative="")] = False,
    member: int = 0,
    condensed: Path | None = None,
) -> int:
    """Solve one scene with one model.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file.
    model
        refined unless given, or "condensed" where its file is given; see: rollbench list.
    everything
        Build everything, also what the scene does not need.
    member
        Which specimen of a scene with random errors.
    condensed
        File that rollbench condense made of these parts: bodies of a condensed 3D model, for the model "condensed".
    """
    from compare.commands.solve_output import as_json as to_json
    from compare.commands.solve_output import as_table
    from compare.models.model_form import estimate
    from compare.models.registry import DEFAULT, Options, run_model
    from compare.scenes import catalogue
    from compare.scenes.scene_file import whole
    from meshes.axis import Assembly

    asked, model = model, model or (DEFAULT if condensed is None else "condensed")
    if condensed is not None and model != "condensed":
        raise InputError("command line", "--condensed", str(condensed), "the model condensed", "leave --model out")
    if not 0 <= member < 10**9:
        raise InputError("command line", "--member", str(member), "0 to 999999999", "give the specimen's number")
    found = catalogue.any_scene(scene)
    if isinstance(found, Assembly):
        from compare.commands.axis_output import solve_shown

        return solve_shown(found, asked, (everything, member, condensed), as_json, _show, _print_json)
    parts = whole(found, scene)
    result = run_model(parts, model, Options(everything=everything, member=member, condensed=condensed))
    worth = estimate(parts, result) if result.converged else None
    if as_json:
        _print_json(to_json(parts, result, worth))
    else:
        _show(*as_table(parts, result, worth))
    return 0 if result.converged else 1


@app.command
def report(
    *,
    only: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    out: Path = Path("rollbench-report"),
    quick: Annotated[bool, Parameter(negative="")] = False,
    stored: Annotated[bool, Parameter(negative="")] = False,
    store: Path = Path("rollbench-reference"),
    fresh: Annotated[bool, Parameter(negative="")] = False,
    backend: str = "joblib",
    scheduler: str | None = None,
    workers: int | None = None,
) -> int:
    """Regenerate the validation report: one HTML file, its tables as CSV, its figures as SVG.

    Parameters
    ----------
    only
        Names of the sections to make; all of them unless given.
    out
        Folder to write to.
    quick
        Coarsest mesh of the 3D reference and cases 1 and 2 only, no pictures, stability or timing; the report says so.
    stored
        Compute no run of the 3D reference: use those that come with the package, and leave out what they do not hold.
    store
        Folder of the runs of the 3D reference that are computed; an interrupted report goes on from there. Runs of the
        package are used where the key of all that they depend on holds.
    fresh
        Compute all runs anew, whatever the folder and the package hold.
    backend
        joblib (this machine) or dask (a cluster), for the 3D reference.
    scheduler
        Address of the Dask scheduler.
    workers
        Runs of the 3D reference at the same time, each of up to 4 GB; 2 here, or what the cluster has, unless given.
    """
    from compare.commands.report import make_report
    from compare.reference.jobs import Engine

    engine = Engine(backend, scheduler, workers or (2 if scheduler is None else None), _cache())
    return make_report(only or (), out, quick=quick, stored=stored, store=store, engine=engine, fresh=fresh)


def _cache() -> Path | None:
    from meshes.cache import default_root

    return default_root()


@app.command
def check(*, max_error: float = 7.0, as_json: Json = False) -> int:
    """Check against hard printed values and closed forms; exit 1 and the rows where the error is too large.

    Parameters
    ----------
    max_error
        Largest error allowed, in per cent, for rows that have no tighter tolerance of their own.
    """
    from compare.gate.gate import run_gate

    if not 0.0 < max_error <= 100.0:
        raise InputError("command line", "--max-error", str(max_error), "above 0 to 100 per cent", "the gate uses 7")
    rows = run_gate(max_error)
    bad = [row for row in rows if not row.passed]
    if as_json:
        _print_json({"max_error_percent": max_error, "passed": not bad, "rows": [row.as_json() for row in rows]})
    else:
        from compare.gate.gate import as_table

        _show(as_table(rows), f"{len(rows) - len(bad)} passed, {len(bad)} failed")
    return 1 if bad else 0


@app.command(name="mesh-study")
def mesh_study(
    scenes: list[str],
    *,
    levels: int = 3,
    store: Path = Path("rollbench-reference"),
    spread: Annotated[bool, Parameter(negative="")] = False,
    source_mesh: Annotated[bool, Parameter(negative="")] = False,
    fresh: Annotated[bool, Parameter(negative="")] = False,
    as_json: Json = False,
    backend: str = "joblib",
    scheduler: str | None = None,
    workers: int | None = None,
) -> int:
    """Run the 3D reference on several mesh levels: observed orders, uncertainty, modelling spread.

    Parameters
    ----------
    scenes
        Names of shipped scenes, or scene files; those of the same parts share their meshes.
    levels
        Number of mesh levels; each is stored when it is done, so an interrupted study resumes.
    store
        Folder of the results; the table goes there as CSV, the figure as SVG.
    spread
        Also vary the modelling choices that are not printed, on the coarsest level.
    source_mesh
        Also run the source's mesh: first-order tetrahedra of 0.08 mm around every contact.
    fresh
        Compute runs even where they are stored.
    backend
        joblib (this machine) or dask (a cluster).
    scheduler
        Address of the Dask scheduler.
    workers
        Runs at the same time, each of up to 4 GB; 1 here, or what the cluster has, unless given.
    """
    from compare.commands.study import run_mesh_study
    from compare.reference.jobs import Engine

    return run_mesh_study(
        scenes,
        levels,
        store,
        Engine(backend, scheduler, workers, _cache()),
        spread=spread,
        source=source_mesh,
        json_out=as_json,
        show=_show,
        print_json=_print_json,
        fresh=fresh,
    )


@app.command
def compare(
    scenes: list[str],
    *,
    model: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    levels: str | None = None,
    store: Path = Path("rollbench-reference"),
    fresh: Annotated[bool, Parameter(negative="")] = False,
    as_json: Json = False,
    backend: str = "joblib",
    scheduler: str | None = None,
    workers: int | None = None,
) -> int:
    """Compare low-order models with the 3D reference of scenes; the reference is computed where none is stored.

    Parameters
    ----------
    scenes
        Names of shipped scenes, or scene files.
    model
        Low-order models: lin, lin-source-partition, lin-printed-hertz, mei, mei-nut; all that suit the scene unless given.
    levels
        Mesh levels of the reference: 3 for levels 1 to 3, or a list such as source,1,2; the best stored one unless given.
    store
        Folder of the reference's results, besides those shipped.
    fresh
        Compute runs even where they are stored or shipped.
    backend
        joblib (this machine) or dask (a cluster).
    scheduler
        Address of the Dask scheduler.
    workers
        Runs at the same time, each of up to 4 GB; 1 here, or what the cluster has, unless given.
    """
    from compare.commands.study import parse_levels, run_compare
    from compare.reference.jobs import Engine

    return run_compare(
        scenes,
        model or (),
        None if levels is None else parse_levels(levels),
        store,
        Engine(backend, scheduler, workers, _cache()),
        json_out=as_json,
        show=_show,
        print_json=_print_json,
        fresh=fresh,
    )


@app.command
def export(
    scene: str,
    part: str = "",
    *,
    out: Path | None = None,
    format: Annotated[str, Parameter(name="--format")] = "",
    level: int = 1,
    ball: int | None = None,
    deck: str = "",
    unit: str = "mm",
    balls: str = "",
    b_over_h: float = 1.5,
    growth: float = 0.4,
    stiffness: float = 2e8,
) -> int:
    """Write a mesh or a result field of the 3D reference for other programs (VTU, MSH, MED or INP, lengths in m), or a
    small scene as one deck that CalculiX runs (--deck ccx).

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file.
    part
        screw, nut, ball, patch-SL (the groove's fine patch; SR, NL, NR), ball-patch-SL, or block-source; none with --deck.
    out
        File to write, replaced if it exists; <scene>-<part>.vtu unless given, <scene>.inp with --deck.
    format
        vtu, msh, med or inp; by the file's name unless given.
    level
        Mesh level, 1 (coarse) to 3; 0 is the source's mesh.
    ball
        Solve the scene and add displacement and stress: of this ball and its patches, or of the whole screw or nut.
    deck
        Program to write the whole contact problem for: ccx (CalculiX; Abaqus reads the same file).
    unit
        Unit of length in the deck: mm (with N and MPa) or m (with N and Pa).
    balls
        Cut the screw of the deck to some neighbouring balls: 3:5 keeps balls 3, 4 and 5.
    b_over_h
        Elements of the deck across the short half axis of a contact of mean load.
    growth
        Growth of the deck's element sizes per distance from the contacts.
    stiffness
        Contact pressure per overclosure of the deck, in N/mm3.
    """
    from compare.commands.export import run_export
    from compare.scenes import catalogue

    if deck:
        from compare.commands.deck import DeckChoices, run_deck

        if part or format or level != 1 or ball is not None:
            raise InputError(
                "command line", "--deck", deck, "no part, --format, --level or --ball with it", "leave them out"
            )
        choices = DeckChoices(deck, unit, balls, b_over_h, growth, stiffness)
        return run_deck(catalogue.scene(scene), choices, out, _show)
    if (unit, balls, b_over_h, growth, stiffness) != ("mm", "", 1.5, 0.4, 2e8):
        raise InputError(
            "command line", "--unit, --balls, --b-over-h, --growth, --stiffness", "given", "with --deck", "add --deck ccx"
        )
    return run_export(catalogue.scene(scene), part, format, out, level, cache=_cache(), show=_show, ball=ball)


@app.command
def crosscheck(
    scene: str,
    *,
    run: Annotated[bool, Parameter(negative="")] = False,
    data: Path | None = None,
    work: Path = Path("rollbench-crosscheck"),
    store: Path = Path("rollbench-reference"),
    as_json: Json = False,
) -> int:
    """Compare the 3D reference with CalculiX, contact by contact: two-balls or lin-case1-cut.

    Parameters
    ----------
    scene
        Name of a shipped scene that was solved by CalculiX.
    run
        Solve its decks with CalculiX (ccx) now, 10 to 20 min of one core, and rewrite the stored results.
    data
        Folder of the stored results; that of the package unless given.
    work
        Folder of the decks and their results; a deck whose result is there is not solved again.
    store
        Folder of the reference's runs, besides those shipped; computed where none is stored.
    """
    from compare.commands.crosscheck import run_crosscheck
    from compare.reference.jobs import Engine

    return run_crosscheck(
        scene,
        run=run,
        data=data,
        work=work,
        store=store,
        engine=Engine(cache=_cache()),
        json_out=as_json,
        show=_show,
        print_json=_print_json,
    )


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
    from compare.commands.condense import run_condense
    from compare.scenes import catalogue

    return run_condense(catalogue.scene(scene), out, level, cache=_cache(), show=_show)


@app.command
def friction(
    scene: str,
    *,
    model: str = "",
    mu: Annotated[list[float] | None, Parameter(negative="")] = None,
    member: int = 0,
    condensed: Path | None = None,
    as_json: Json = False,
) -> int:
    """Friction of a screw or bearing at its static loads: ball motion, losses, friction torque, efficiency, drag.

    Also solves the kinds of scenes that only friction solves: balls of a rotary or linear bearing, two balls or a whole
    ball screw in time, bearings in pairs; these take no further options.

    Parameters
    ----------
    scene
        Name of a shipped scene of any kind, or a scene file.
    model
        Model of the contact loads: refined unless given, or "condensed" where its file is given; see: rollbench list.
    mu
        Coefficient of friction in place of the scene's; several: a table over them, with the balls of the first.
    member
        Which specimen of a scene with random errors.
    condensed
        File that rollbench condense made of these parts: bodies of a condensed 3D model, for the model "condensed".
    """
    from compare.commands.friction import Choices, run

    choices = Choices(model, tuple(mu or ()), member, condensed)
    return run(scene, choices, as_json, _show, _print_json)


@app.command
def stability(*, as_json: Json = False) -> int:
    """Run the table of stiff and extreme scenes; exit 1 where this project's solver fails on any."""
    from compare.commands.stability import run_stability

    return run_stability(as_json=as_json, show=_show, print_json=_print_json)


@app.command
def bench(*, as_json: Json = False) -> int:
    """Measure run times as ratios to the source's formulation in the same process."""
    from compare.commands.bench import run_bench_command

    return run_bench_command(as_json=as_json, show=_show, print_json=_print_json)


def main(tokens: list[str] | None = None) -> None:
    """Entry point: bad input gives one line on standard error and exit code 2, an interrupt 130."""
    try:
        code = app(tokens, exit_on_error=False, print_error=False, result_action="return_value")
    except InputError as error:
        sys.stderr.write(f"rollbench: {error}\n")
        sys.exit(2)
    except CycloptsError as error:
        text = one_line(" ".join(str(error).split()), 400)
        sys.stderr.write(f"rollbench: command line: {text} Advice: see rollbench --help\n")
        sys.exit(2)
    except KeyboardInterrupt:
        sys.stderr.write("rollbench: interrupted; nothing was left half-written\n")
        sys.exit(130)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(141)
    sys.exit(code if isinstance(code, int) else 0)
