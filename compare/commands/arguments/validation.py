"""Models beside the 3D reference, the whole validation, and the shell: compare, report, verify, check, completion."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from rollbench.compare.commands.arguments.terminal import Flag, Json, Where, Word, app, cache_folder, engine
from rollbench.compare.commands.printing import Answer, print_answer, writing
from rollbench.compare.errors import ArgumentError

#: Names after one option, none unless given.
Names = Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")]


@app.command
def compare(
    scenes: list[str],
    *,
    model: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    levels: str | None = None,
    store: Path = Path("rollbench-reference"),
    fresh: Flag = False,
    balls: Flag = False,
    reference: Path | None = None,
    bodies: str = "half-space",
    as_json: Json = False,
    where: Where | None = None,
) -> int:
    """Compare low-order models with the 3D reference of scenes; the reference is computed where none is stored.

    A verdict, ten answers beside the reference's, a table of models; every contact goes to <scene>-compare.csv and .svg in
    the store. For a page to send: rollbench report SCENE. Exit code 5 where loads of the reference did not settle: what
    they may still move by is said, kept with the run and added to its uncertainty.

    Parameters
    ----------
    scenes
        Names of shipped scenes, or scene files.
    model
        Low-order models of rollbench list; condensed takes the bodies of the reference's finest level. Unless given:
        refined, the default of every command, whose error is the verdict, and beside it the others that the report
        compares.
    levels
        Mesh levels of the reference: 3 for levels 1 to 3, or a list such as source,1,2; the best stored one unless given,
        levels 1 and 3 where there is none.
    store
        Folder of the reference's results, besides those shipped.
    fresh
        Compute runs even where they are stored or shipped.
    balls
        Also print every contact.
    reference
        Compare with this file in place of the 3D reference, which stands beside it where it is stored; as for rollbench
        check.
    bodies
        Of scenes of friction: half-space, or finite (patches of the static reference, or a ball and grooved bars).
    """
    from rollbench.compare.commands.comparing.kinds import all_rolling
    from rollbench.compare.commands.comparing.study import parse_levels, run_compare

    wanted = None if levels is None else parse_levels(levels)
    means_nothing = {"model": model is not None, "balls": balls, "reference": reference is not None}
    if rolling := all_rolling(scenes, bodies, "rolling compare", means_nothing):
        answer = rolling(scenes, wanted, store, engine(where), fresh=fresh, bodies=bodies)
    else:
        answer = run_compare(
            scenes, model or (), wanted, store, engine(where), fresh=fresh, balls=balls, reference=reference
        )
    return print_answer(answer, as_json)


@app.command
def report(
    scene: str | None = None,
    /,
    *,
    only: Annotated[list[str] | None, Parameter(consume_multiple=True, negative="")] = None,
    out: Path = Path("rollbench-report"),
    quick: Flag = False,
    stored: Flag = False,
    store: Path = Path("rollbench-reference"),
    fresh: Flag = False,
    everything: Annotated[Flag, Parameter(name="--all")] = False,
    where: Where | None = None,
    against: Path | None = None,
    reference: Path | None = None,
) -> int:
    """Regenerate the validation report: HTML, its tables as CSV, its figures as SVG; with a scene: one page on it.

    Shipped runs of the 3D reference are used; one is recomputed, and the agreement printed. What cannot be made on this
    machine is left out and named at the end, with what to install. Exit code 1 where the run recomputed does not agree.
    The page of a scene carries the answers, the error to expect or measured, assumptions, and the hashes of all that it
    rests on; see rollbench verify.

    Parameters
    ----------
    scene
        A shipped name or a scene file: write one self-contained page on it instead. The 3D reference is set beside it where
        runs are stored; none is computed.
    only
        Names of the sections to make; all but the costly ones unless given. With timing all run times are measured
        again, models and levels of the 3D reference, an hour on a quiet machine, and kept in --store: reference timing.
    out
        Folder to write to.
    quick
        Compute the 3D reference of cases 1 and 2 on the coarsest mesh only, and make the sections that rest on it; what
        sources printed, errors, friction, rolling and the rest are left out, and the report names them.
    stored
        Compute no run of the 3D reference: use those that come with the package, and leave out what they do not hold.
    store
        Folder of the runs of the 3D reference that are computed; an interrupted report resumes there. Runs of the
        package are used where the key of all that they depend on holds.
    fresh
        Recompute all runs, whatever is stored, and make all sections.
    everything
        Also make the slow sections: pictures, friction, rolling, verification, stability, timing. Run times are the stored
        ones.
    against
        An earlier report, or with a scene an earlier page on it, to list what moved.
    reference
        With a scene: your own reference in place of the 3D reference, as for rollbench check.
    """
    if scene is not None:
        from rollbench.compare.system import need_packages
        from rollbench.meshes.libraries import PAGES

        need_packages(*PAGES)  # some of which the next line imports
        from rollbench.compare.commands.reporting.verify import run_page

        given = {"only": only, "quick": quick, "stored": stored, "fresh": fresh, "scheduler": where and where.scheduler}
        for name, value in given.items():
            if value:
                raise ArgumentError(name, str(value), "without a scene", "leave it out")
        return print_answer(run_page(scene, out, store, against, reference))
    if reference is not None:
        raise ArgumentError("reference", str(reference), "with a scene", "name the scene that it is of")
    from rollbench.compare.commands.reporting.report import make_report

    kinds: dict[str, Any] = {"quick": quick, "stored": stored, "fresh": fresh, "everything": everything}
    return print_answer(make_report(only or (), out, store=store, engine=engine(where, 2), against=against, **kinds))


@app.command
def verify(report: Path, /, *, store: Path = Path("rollbench-reference")) -> int:
    """Recompute the hashes of a scene's page or of a whole report: its files, scenes, sources, printed data, reference
    runs; exit 1 where one differs.

    Parameters
    ----------
    report
        The page or folder that rollbench report wrote, with or without a scene.
    store
        Folder of the reference's runs, besides those shipped.
    """
    from rollbench.compare.system import need_packages
    from rollbench.meshes.libraries import PAGES

    need_packages(*PAGES)  # some of which the next line imports
    from rollbench.compare.commands.reporting.verify import run_verify

    return print_answer(run_verify(report, store))


@app.command
def check(
    scenes: list[str] | None = None,
    /,
    *,
    model: Word = "",
    loads: Path | None = None,
    values: Path | None = None,
    max_error: float | None = None,
    limit: Annotated[list[str] | None, Parameter(negative="")] = None,
    strict: Flag = False,
    reference: Path | None = None,
    levels: int | None = None,
    stored: Path | None = None,
    no_compute: Flag = False,
    store: Path = Path("rollbench-reference"),
    junit: Path | None = None,
    markdown: Path | None = None,
    csv: Path | None = None,
    baseline: Path | None = None,
    printed: Flag = False,
    source: Names = None,
    only: Names = None,
    as_json: Json = False,
) -> int:
    """Judge scenes against their 3D reference; without scenes: the gate of what is shipped (printed values, closed forms,
    balance, 3D references); with --printed: every number and claim that the sources print.

    A scene passes where error + u is within the limit, u the reference's own uncertainty; it fails where error - u is
    beyond the limit, and is undecided between. It is not covered where no reference is stored and none may be computed. The
    error of a contact load is in per cent of its reference load (of the mean load below a tenth of it).

    Exit codes: 0 all pass (without scenes: no row fails); 1 one fails; 2 bad input; 3 none fails, but one is undecided; 4
    none of these, but one is not covered.

    Parameters
    ----------
    scenes
        Names of shipped scenes, or scene files. A scene may set its own limits in a table [gate].
    model
        Low-order model that is judged: refined unless given.
    loads
        Judge the loads of another program instead: CSV file with the columns ball, flank (SL, SR, NL, NR), newton; with
        azimuth_deg and z_mm too, balls are matched by these. Columns contact_angle_deg, approach_um, pressure_MPa are
        judged too. Headings say the unit: load_kN, angle_rad, z_um.
    values
        Judge values of the whole screw by another program: CSV file with the columns quantity (displacement, rigidity,
        torque, life), value, unit, where (empty: the scene's loads; an axial load such as 5 kN, or of a displacement a
        station such as 400 mm).
    max_error
        Limit of the error of loads in per cent, in place of the scenes' own; 7 where neither is given.
    limit
        Limit of another quantity, NAME=NUMBER in per cent, of a contact angle in degrees; may be given several times.
        Unless given: contact angle 1, approach two thirds, pressure a third and life three times the limit of the loads,
        which is also that of the others. A model is judged on the quantities that are named.
    strict
        Treat an unknown column as an error, not as a warning.
    reference
        Judge by this file in place of the 3D reference: your own loads in the columns of --loads, of every flank, with a
        column uncertainty_N, or a line "# uncertainty: 0.5 %" above, and "# provenance: words"; without, zero is taken.
    levels
        Compute mesh levels 1 to N of the reference where they are not stored; the best stored unless given, 2 where there
        are fewer. Level 1 alone has an uncertainty from experience with other scenes.
    stored
        Take the reference from runs stored in this folder, besides those shipped, and compute none.
    no_compute
        Compute no run of the reference.
    store
        Folder of the reference's runs, besides those shipped.
    junit
        Also write the verdicts as JUnit XML.
    markdown
        Also write them as Markdown for a comment, with a chart of the worst ball and its neighbours, and add it to the
        summary that the environment names (GITHUB_STEP_SUMMARY).
    csv
        Also write them as CSV.
    baseline
        Report what changed since this file of verdicts, written by an earlier --csv or --json.
    printed
        Judge what the sources print instead: each entry gets a verdict, and the exit code is 1 where one differs from the
        verdict that is expected of it.
    source
        With --printed: the sources to judge, such as lin; all unless given.
    only
        With --printed: the tables or entries to judge, such as lin-3.5 or lin-3.5:a_force_numerical; all unless given.
    """
    if printed:
        given: dict[str, object] = {"scenes": scenes, "model": model, "loads": loads, "values": values}
        given |= {"max_error": max_error, "limits": limit, "strict": strict, "reference": reference, "levels": levels}
        given |= {"stored": stored, "no_compute": no_compute, "junit": junit, "markdown": markdown, "csv": csv}
        refuse_given(
            given | {"baseline": baseline}, "without --printed", "leave it out: printed data have their own limits"
        )
        from rollbench.compare.commands.printed import run_printed

        return print_answer(run_printed(source or (), only or ()), as_json)
    refuse_given({"source": source, "only": only}, "with --printed", "add it")
    from rollbench.compare.commands.comparing.check import Files, run_check, run_shipped
    from rollbench.compare.gate.user import asked
    from rollbench.compare.reference.jobs import Engine

    files = Files(junit, markdown, csv, baseline)
    request = asked(
        model=model,
        loads=loads,
        values=values,
        max_error=max_error,
        limits=limit or (),
        strict=strict,
        reference=reference,
        levels=levels,
        store=store,
        stored=stored,
        compute=not no_compute,
    )
    if scenes:
        return print_answer(run_check(scenes, request, Engine(cache=cache_folder()), files), as_json)
    given = {"model": model, "loads": loads, "values": values, "limits": limit}
    given |= {"reference": reference, "strict": strict, "levels": levels, "stored": stored, "no_compute": no_compute}
    refuse_given(given, "with a scene", "name the scenes that are judged")
    return print_answer(run_shipped(max_error, files), as_json)


def refuse_given(given: Mapping[str, object], allowed: str, advice: str) -> None:
    """Raise ArgumentError for the first argument that is given where it means nothing."""
    for name, value in given.items():
        if value:
            text = ", ".join(map(str, value)) if isinstance(value, list) else str(value)
            raise ArgumentError(name, text, allowed, advice)


@app.command
def audit(*, only: Names = None, write: Path | None = None, as_json: Json = False) -> int:
    """Judge every printed entry of the sources: the name that rollbench check --printed had, kept until 1.0.

    Parameters
    ----------
    only
        Names of printed tables or entries; all unless given.
    write
        File to write the verdicts to.
    """
    from rollbench.compare.commands.printed import run_printed

    return print_answer(run_printed((), only or (), write), as_json)


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
