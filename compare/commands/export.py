"""The commands ``export`` and ``condense``: meshes, decks and condensed bodies of the 3D reference as files."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from rollbench.compare.commands.terminal import Word, app, cache_folder
from rollbench.compare.errors import ArgumentError, InputError, Refusal
from rollbench.compare.running import cores, need_gmsh, need_packages, need_reference, on_terminal, out_of_memory
from rollbench.compare.text.printing import Answer, print_answer

if TYPE_CHECKING:
    from rollbench.compare.reference.tasks import Solvable
    from rollbench.meshes.arrays import Array
    from rollbench.meshes.parts import Scene


@app.command
def export(
    scene: str,
    part: Word = "",
    *,
    out: Path | None = None,
    format: Annotated[Word, Parameter(name="--format")] = "",
    level: int = 1,
    ball: int | None = None,
    deck: Word = "",
    unit: str = "mm",
    balls: Word = "",
    b_over_h: float = 1.5,
    growth: float = 0.4,
    stiffness: float = 2e8,
    ross: Path | None = None,
    modelica: Path | None = None,
    rexs: Path | None = None,
    model: Word = "",
) -> int:
    """Write meshes and results of the 3D reference, CAD parts, a CalculiX deck, or bearings as REXS, for other programs.

    Meshes and result fields: VTU, MSH, MED or INP, lengths in m. All parts as CAD: STEP, lengths in mm. A small scene as
    one deck that CalculiX runs: --deck ccx. The bearings of a shaft with their results: --rexs.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file.
    part
        screw, nut, ball or whole; screw-with-sockets, nut-with-sockets, ball-with-sockets: the body with a hole at every
        contact, as the reference condenses it; patch-SL (SR, NL, NR) and ball-patch-SL: the fine meshes that fill these
        holes; block-source. Not with --deck or --format step.
    out
        File to write; an existing file is replaced. Default: <scene>-<part>.vtu, <scene>.step or, with --deck,
        <scene>.inp.
    format
        vtu, msh, med, inp, step, or json (the input of --model-command). Default: by the file's suffix.
    level
        Mesh level, 1 (coarse) to 3; 0 is the source's mesh.
    ball
        Solve the scene and add displacement and stress of this ball and its patches, or of screw or nut with sockets.
    deck
        Program to write the whole contact problem for: ccx (CalculiX; Abaqus reads the same file).
    unit
        Unit of length in the deck: mm (with N and MPa) or m (with N and Pa).
    balls
        Keep only some neighbouring balls in the deck, and cut the screw to them: 3:5 keeps balls 3, 4 and 5.
    b_over_h
        Elements of the deck across the minor semi-axis of a contact of mean load.
    growth
        Growth of the deck's element size with the distance from the contacts.
    stiffness
        Contact pressure per overclosure in the deck, in N/mm3.
    ross
        Write a Python module with a BearingElement of ROSS for each row of a table; SCENE is then the JSON file of
        rollbench table.
    modelica
        Write the same table for Modelica's CombiTable1Ds (one key) or CombiTable2Ds (two keys).
    rexs
        Write a REXS file (1.7): bearings with rows and rolling elements, shaft and loads of an axis, and their results.
    model
        With --rexs: low-order model of the results. Default: refined.
    """
    from rollbench.compare.scenes import catalogue, scene_file

    if model and rexs is None:
        raise ArgumentError("model", model, "with `rexs`", "leave it out")
    if rexs is not None and (ross is not None or modelica is not None):
        raise ArgumentError("rexs", str(rexs), "without `ross` and `modelica`, which are of a table", "give one of them")
    if ross is not None or modelica is not None or rexs is not None:
        if part or format or out is not None or level != 1 or ball is not None or deck:
            raise ArgumentError("ross, modelica, rexs", "given", "none of the options of meshes with it", "leave them out")
        if rexs is not None:
            return print_answer(run_rexs(scene, rexs, model))
        return print_answer(run_table(scene, ross, modelica))

    if deck:
        if part or format or level != 1 or ball is not None:
            raise ArgumentError("deck", deck, "no `part`, `format`, `level` or `ball` with it", "leave them out")
        need_packages("scikit-fem")
        from rollbench.compare.studies.export import write_deck

        return print_answer(
            Answer(parts=[write_deck(deck, unit, balls, b_over_h, growth, stiffness, catalogue.scene(scene), out)])
        )
    if (unit, balls, b_over_h, growth, stiffness) != ("mm", "", 1.5, 0.4, 2e8):
        raise ArgumentError("unit, balls, b_over_h, growth, stiffness", "given", "with --deck", "add --deck ccx")
    if format == "json" or (not format and out is not None and out.suffix == ".json"):
        if part or level != 1 or ball is not None:
            raise ArgumentError("format", "json", "no `part`, `level` or `ball` with it", "leave them out")
        return print_answer(run_json(catalogue.scene(scene), out))
    if format == "step" or (not format and out is not None and out.suffix == ".step"):
        if part or level != 1 or ball is not None:
            raise ArgumentError("format", "step", "no `part`, `level` or `ball` with it", "leave them out")
        return print_answer(run_step(scene_file.solvable(catalogue.any_scene(scene), scene), out))
    return print_answer(run_export(catalogue.scene(scene), part, format, out, level, cache=cache_folder(), ball=ball))


def run_json(scene: Scene, out: Path | None) -> Answer:
    """Write a scene as the input file of an external model. Raises InputError as `export`.

    out: ``<scene>.json`` by default.
    """
    from rollbench.compare.files import replace_file
    from rollbench.compare.models.programs import scene_json

    out = out or Path(f"{scene.name}.json")
    replace_file(out, scene_json(scene))
    return Answer(parts=[f"wrote {out}: the scene in SI units, its balls with their errors and Hertz constants"])


def run_export(
    scene: Scene, part: str, form: str, out: Path | None, level: int, *, cache: Path | None = None, ball: int | None = None
) -> Answer:
    """Write the mesh of a part, with named groups for its surfaces; lengths in m.

    Groups are flanks, lands, ends, sockets and contact zones. ball: solve the scene and add displacement [m], stress and
    von Mises stress [Pa] of the parts of that ball (from 1), or of screw or nut as solved, with sockets; None: only the
    mesh. form: vtu, msh, med or inp; default: by the suffix of ``out``, else vtu. out: the file, replaced if it exists;
    None: ``<scene>-<part>.<form>``. level: mesh level of the reference (0: the source's mesh). cache: folder of the
    reference's meshes, None for none.

    Raises InputError for an unknown part, format or level, a missing package, a mesh that cannot be built and a file that
    cannot be written; all but the last two before anything is meshed, as is the field of a screw that the scene supports
    or loads beyond the low end of its 3D stretch.
    """
    need_gmsh()
    need_packages("scikit-fem")
    from rollbench.compare.studies.export import BLOCK, BODIES, SOCKETS, exported_parts, part_mesh, result_fields
    from rollbench.meshes.exchange.mesh_files import FORMATS, form_of, need, reduced, write_mesh

    if part not in exported_parts(scene):
        raise ArgumentError("part", part, ", ".join(exported_parts(scene)), "choose one of these")
    if form and form not in FORMATS:
        raise ArgumentError("format", form, ", ".join(FORMATS), "leave it out to go by the file's name")
    if out is None:
        out = Path(f"{scene.name}-{part}.{form or 'vtu'}")
    elif out.suffix == "":
        out = out.with_name(f"{out.name}.{form or 'vtu'}")
    try:
        form = form_of(out, form)
        need(form)
    except ValueError:
        allowed = ", ".join(f".{name}" for name in FORMATS)
        raise ArgumentError("out", str(out), f"a name ending in {allowed}", "or give `format`") from None
    except ImportError as error:
        raise ArgumentError("format", form, "a format whose packages are installed", str(error)) from None
    if ball is not None and not (1 <= ball <= scene.ball_count and part != BLOCK and form != "inp"):
        allowed = f"1 to {scene.ball_count}, for parts of the scene, in vtu, msh or med"
        raise ArgumentError("ball", str(ball), allowed, "leave it out for the mesh only")
    lines = []
    if ball is not None and part in BODIES:
        lines.append(f"fields are those of the {part} that is solved, with a socket at every contact: {part}{SOCKETS}")
        part += SOCKETS
    fields: dict[str, Array] = {}
    try:
        if ball is not None and part.startswith(("screw", "patch-S")):
            from rollbench.hifi.fields import refuse_beyond_low_end
            from rollbench.meshes.solid import dimensions

            refuse_beyond_low_end(scene, dimensions(scene))
        mesh = part_mesh(scene, part, level, cache)
        if ball is not None:
            fields = result_fields(scene, part, level, ball - 1, cache)
    except ValueError as error:
        raise Refusal(scene.name, part, str(error), "see solid.* and the nut's length in the scene") from error
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        write_mesh(out, mesh, fields, region=part, form=form)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(str(out), "file", reason, "a folder that can be written to", "check the path") from None
    from rollbench.meshes.fem import kind_of

    nodes, cells = mesh.doflocs.shape[1], f"{mesh.nelements} {_LABELS[kind_of(mesh)]}"
    lines.append(f"wrote {out}: {nodes} nodes, {cells}; lengths in m; groups: {', '.join(mesh.boundaries) or 'none'}")
    if reduced(mesh, form):
        lines.append(f".{form} holds no 27-node hexahedra: their face and centre nodes were left out (20 nodes remain)")
    return Answer(parts=lines)


def run_rexs(typed: str, out: Path, model: str = "") -> Answer:
    """Solve an axis and write it as REXS.

    Raises InputError for another kind of scene, Refusal for what REXS cannot hold.
    """
    from rollbench.compare.files import need_writable, replace_file
    from rollbench.compare.models.load_cases import SolvedAxis, solve_axis
    from rollbench.compare.models.registry import Options, default_model
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.duty_cycle import DutyCycle
    from rollbench.compare.studies.to_rexs import rexs_text
    from rollbench.meshes.axis import Assembly

    described = catalogue.any_scene(typed)
    each = [case.scene for case in described.cases] if isinstance(described, DutyCycle) else [described]
    solved: list[SolvedAxis] = []
    need_writable(out)
    for scene in each:
        if not isinstance(scene, Assembly):
            raise InputError(
                typed, "kind", getattr(scene, "kind", "one set"), 'kind = "axis"', "write bearings as [[sets]]"
            )
        solved.append(solve_axis(scene, model or default_model(scene), Options()))
        if not solved[-1].result.converged:
            raise Refusal(scene.name, "loads", str(solved[-1].result.status), "see rollbench solve")
    assert isinstance(described, Assembly | DutyCycle)
    text, notes = rexs_text(described, solved)
    replace_file(out, text)
    cases = f"{len(solved)} load cases" if len(solved) > 1 else "its results as load case 1"
    lines = [f"not in REXS: {note}" for note in notes]
    return Answer(parts=[*lines, f"wrote {out}: REXS 1.7, {cases}"], folded=True)


def run_table(scene: str, ross: Path | None, modelica: Path | None) -> Answer:
    """Write the table of a JSON file for ROSS and Modelica. Raises InputError for another file and for a grid with gaps."""
    from rollbench.compare.files import replace_file
    from rollbench.compare.studies.table_files import ROSS_DROPS, modelica_text, read_table, ross_text
    from rollbench.compare.text.table import failure_words

    table = read_table(scene)
    lines = [f"left out: {line}" for line in failure_words(table)]
    if ross is not None:
        replace_file(ross, ross_text(table))
        lines.append(f"wrote {ross}. {ROSS_DROPS}")
    if modelica is not None:
        text, left = modelica_text(table)
        replace_file(modelica, text)
        lines += [f"left out: {line}" for line in left[len(table.failures) :]]
        lines.append(f"wrote {modelica}: drops no term; written by the format's definition, OpenModelica was not run")
    return Answer(parts=lines, folded=True)


_LABELS = {"P1": "4-node tetrahedra", "P2": "10-node tetrahedra", "Q1": "8-node hexahedra", "Q2": "27-node hexahedra"}


def run_step(described: Solvable, out: Path | None) -> Answer:
    """Write the parts of a scene as STEP files, lengths in mm (`rollbench.meshes.exchange.step_files`).

    out: the file of the bodies, replaced if it exists; ``<scene>.step`` unless given. Raises InputError where gmsh is
    missing or a file cannot be written, Refusal for sets of rollers, which have no groove, and for parts without a wall.
    """
    need_gmsh()
    need_packages("scikit-fem")
    from rollbench.compare.studies.export import placed_sets
    from rollbench.meshes.exchange.step_files import write_step

    out = Path(f"{described.name}.step") if out is None else out
    out = out.with_name(f"{out.name}.step") if out.suffix == "" else out
    try:
        files = write_step(out, placed_sets(described))
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(str(out), "file", reason, "a folder that can be written to", "check the path") from None
    except ValueError as error:
        raise Refusal(described.name, "step", str(error), "see solid.* and the nut's length in the scene") from error
    bodies, *grooves = files
    lines = [f"wrote {bodies}: shaft, nuts and balls{' without their grooves' if grooves else ''}; lengths in mm"]
    for path in grooves:
        off = f"up to {1e6 * files[path]:.2g} um from the exact ones"
        lines.append(f"wrote {path}: flanks of the grooves as surfaces, {off}; lengths in mm")
    return Answer({"files": [str(path) for path in files], "largest_distance_um": 1e6 * max(files.values())}, lines)


def run_condense(typed: str, out: Path | None, level: int, *, cache: Path | None) -> Answer:
    """Mesh and condense all four flanks, for all load cases of a scene; write the file completely or not at all.

    Raises InputError for a level out of range, a mesh that cannot be built, and a file that cannot be written.
    """
    from rollbench.compare.files import need_writable, written
    from rollbench.compare.reference.levels import LEVELS
    from rollbench.compare.reference.tasks import settings_of
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.scene_file import each_case, whole

    if level not in LEVELS:
        raise ArgumentError("level", str(level), f"1 to {len(LEVELS)}", "choose a mesh level")
    described = catalogue.any_scene(typed)
    scenes = [whole(x, typed) for x in each_case(described, typed)]
    scene = scenes[0]
    out = out or Path(f"{described.name}-condensed.npz")
    need_writable(out)
    need_reference()
    from rollbench.hifi.condensed import condensed_bodies
    from rollbench.hifi.setup import prepare
    from rollbench.meshes.cache import Cache

    try:
        setup = prepare(scene, (0, 1, 2, 3), settings_of(scenes, level), on_terminal, cache=Cache(cache), processes=cores())
    except MemoryError as error:
        raise out_of_memory(error) from error
    except ValueError as error:
        raise Refusal(scene.name, "3D bodies", str(error), "change what it names") from error
    with written(out):
        condensed_bodies(setup, level).save(out)
    command = f"rollbench solve {shlex.quote(typed)} --condensed {shlex.quote(str(out))}"
    return Answer(parts=[f"wrote {out}; use it with: {command}"])


@app.command
def condense(scene: str, *, out: Path | None = None, level: int = 1) -> int:
    """Reduce the 3D bodies of a scene to compliances of their contacts, for: rollbench solve SCENE --condensed FILE.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file. The result serves all loads, supports and errors of the same parts.
    out
        File to write; an existing file is replaced. Default: <scene>-condensed.npz.
    level
        Mesh level, 1 (coarse) to 3.
    """
    return print_answer(run_condense(scene, out, level, cache=cache_folder()))
