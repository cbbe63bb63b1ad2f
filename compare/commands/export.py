"""Commands ``export``, ``condense`` and ``crosscheck``: files for other programs, and a comparison with CalculiX.

``export`` and ``condense`` write meshes, input decks and condensed bodies of the 3D reference. ``crosscheck`` compares the
contact loads of the 3D reference with those by CalculiX.
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from rollbench.compare import running
from rollbench.compare.commands.terminal import Flag, Json, Word, app, cache_folder, refuse_given_arguments
from rollbench.compare.errors import ArgumentError, InputError, SceneNotCoveredError
from rollbench.compare.text.printing import CommandOutput, TextTable, format_cell, print_command_output

if TYPE_CHECKING:
    from rollbench.compare.reference.estimate import Reference
    from rollbench.compare.reference.jobs import ComputingSettings
    from rollbench.compare.reference.tasks import Solvable
    from rollbench.compare.studies.crosscheck.results import CalculixRunsOfScene, Row
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
) -> int:
    """Write meshes, result fields, CAD parts, a CalculiX deck or a table of stiffnesses to files for other programs.

    Meshes and result fields of the 3D reference are written as VTU, MSH, MED or INP, with lengths in m. All parts are
    written as CAD bodies in STEP, with lengths in mm. A small scene is written as a deck that CalculiX can run by --deck
    ccx.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file.
    part
        Part to mesh: screw, nut, ball or whole; screw-with-sockets, nut-with-sockets, ball-with-sockets: the body with a
        hole (socket) at every contact, as the 3D reference condenses it; patch-SL and ball-patch-SL: the fine meshes that
        fill these holes (SL: left flank of the screw; also SR, NL, NR, with N for nut, R for right); block-source: the mesh
        of one contact in Lin's thesis. Not with --deck or --format step.
    out
        File to write; an existing file is replaced. Default: <scene>-<part>.vtu, <scene>.step or, with --deck,
        <scene>.inp.
    format
        vtu, msh, med, inp, step, or json (the input of --model-command). Default: from the suffix of the file name.
    level
        Mesh level, 1 (coarse) to 3; 0 is the mesh of the publication.
    ball
        Number of a ball, from 1. Solves the scene and adds displacement and stress to the mesh of this ball and of its
        patches, or of the screw or nut with sockets.
    deck
        Program for which the whole contact problem is written: ccx (CalculiX; Abaqus reads the same file).
    unit
        Unit of length in the deck: mm (with N and MPa) or m (with N and Pa).
    balls
        Neighbouring balls that the deck contains, such as 3:5 for balls 3, 4 and 5; the screw is cut to them. Default: all.
    b_over_h
        Number of elements in the deck along the minor semi-axis of the contact ellipse under the mean load.
    growth
        Increase of the deck's element size per unit of distance from the contacts.
    stiffness
        Contact pressure in the deck per mm of overlap of the surfaces, in N/mm3.
    ross
        Write a Python module with a BearingElement of the package ROSS for each row of a table. SCENE is then the JSON
        file that rollbench table wrote.
    modelica
        Write the table of --ross for Modelica's CombiTable1Ds (one varied key) or CombiTable2Ds (two varied keys).
    """
    from rollbench.compare.scenes import catalogue, scene_file

    of_meshes, advice = {"part": part, "level": level if level != 1 else None, "ball": ball}, "leave it out"
    if ross is not None or modelica is not None:
        given = {**of_meshes, "format": format, "out": out, "deck": deck}
        refuse_given_arguments(given, "only without `ross` and `modelica`, which convert a whole table", advice)
        return print_command_output(write_stiffness_tables(scene, ross, modelica))

    if deck:
        given = {**of_meshes, "format": format}
        refuse_given_arguments(given, "only without `deck`, which contains the whole scene", advice)
        running.check_packages("scikit-fem")
        from rollbench.compare.studies.export import write_calculix_deck

        line = write_calculix_deck(deck, unit, balls, b_over_h, growth, stiffness, catalogue.scene(scene), out)
        return print_command_output(CommandOutput(texts_and_tables=[line]))
    usual = {"unit": (unit, "mm"), "balls": (balls, ""), "b_over_h": (b_over_h, 1.5), "growth": (growth, 0.4)}
    usual["stiffness"] = stiffness, 2e8
    unused = {name: value for name, (value, default) in usual.items() if value != default}
    refuse_given_arguments(unused, "only with `deck`", "add --deck ccx")
    form = format or ("" if out is None else out.suffix.removeprefix("."))
    if form in ("json", "step"):
        refuse_given_arguments(of_meshes, f"only without the format {form}, which describes the whole scene", advice)
    if form == "json":
        return print_command_output(write_scene_json(catalogue.scene(scene), out))
    if form == "step":
        described = scene_file.scene_or_shaft_or_raise(catalogue.scene_of_any_kind(scene), scene)
        return print_command_output(write_step_bodies(described, out))
    found = write_part_mesh(catalogue.scene(scene), part, format, out, level, cache=cache_folder(), ball=ball)
    return print_command_output(found)


def write_scene_json(scene: Scene, out: Path | None) -> CommandOutput:
    """Write a scene as JSON, the input of an external program that serves as a low-order model.

    ``out``: the file; None: ``<scene>.json``. Raises InputError if it cannot be written.
    """
    from rollbench.compare.files import replace_file
    from rollbench.compare.models.programs import scene_json

    out = out or Path(f"{scene.name}.json")
    replace_file(out, scene_json(scene))
    line = f"wrote {out}: the scene in SI units, its balls with their errors and Hertz constants"
    return CommandOutput(texts_and_tables=[line])


def write_part_mesh(
    scene: Scene, part: str, form: str, out: Path | None, level: int, *, cache: Path | None = None, ball: int | None = None
) -> CommandOutput:
    """Write the mesh of one part of a scene, with named groups for its surfaces; lengths are in m.

    The groups are groove flanks, lands, end faces, sockets (holes at the contacts) and contact zones.

    ``form``: format of the file (vtu, msh, med or inp); if empty, it follows from the suffix of ``out``, and is vtu without
    ``out``. ``out``: the file, replaced if it exists; None: ``<scene>-<part>.<form>``. ``level``: mesh level of the 3D
    reference (0: the mesh of the publication). ``cache``: folder of stored meshes; None: no cache. ``ball``: number of a
    ball, from 1; the scene is then solved, and displacement [m], stress and von Mises stress [Pa] are added to the mesh of
    that ball or its patches, or of the screw or nut with sockets.

    Raises InputError for an unknown part, format or level, a missing package, a mesh that cannot be built, a file that
    cannot be written, and a result field that cannot be computed: the screw's 3D mesh is fixed at its end of lower z, so
    no support or load may act on the screw at larger z.
    """
    running.check_gmsh()
    running.check_packages("scikit-fem")
    from rollbench.compare.files import replaced_file
    from rollbench.compare.studies import export as parts
    from rollbench.meshes.exchange import mesh_files

    if part not in parts.names_of_exportable_parts(scene):
        raise ArgumentError("part", part, ", ".join(parts.names_of_exportable_parts(scene)), "choose one of these")
    if form and form not in mesh_files.FORMATS:
        raise ArgumentError(
            "format", form, ", ".join(mesh_files.FORMATS), "choose one of these, or let the file's suffix decide"
        )
    if out is None:
        out = Path(f"{scene.name}-{part}.{form or 'vtu'}")
    elif out.suffix == "":
        out = out.with_name(f"{out.name}.{form or 'vtu'}")
    try:
        form = mesh_files.mesh_format(out, form)
        mesh_files.check_packages_for_format(form)
    except ValueError:
        allowed = ", ".join(f".{name}" for name in mesh_files.FORMATS)
        advice = "change the suffix, or add `format`"
        raise ArgumentError("out", str(out), f"a name that ends in {allowed}", advice) from None
    except ImportError as error:
        raise ArgumentError("format", form, "a format whose packages are installed", str(error)) from None
    if ball is not None and not (1 <= ball <= scene.ball_count and part != parts.BLOCK and form != "inp"):
        allowed = f"1 to {scene.ball_count}, with a part of the scene and the format vtu, msh or med"
        advice = "leave `ball` out to write the mesh without displacement and stress"
        raise ArgumentError("ball", str(ball), allowed, advice)
    lines = []
    if ball is not None and part in parts.BODIES:
        lines.append(f"wrote {part}{parts.SOCKETS} instead, because the {part} is solved with a socket at every contact")
        part += parts.SOCKETS
    fields: dict[str, Array] = {}
    try:
        if ball is not None and part.startswith(("screw", "patch-S")):
            from rollbench.hifi.fields import refuse_supports_beyond_low_end
            from rollbench.meshes.solid import dimensions_of_3d_parts

            refuse_supports_beyond_low_end(scene, dimensions_of_3d_parts(scene))
        mesh = parts.part_mesh(scene, part, level, cache)
        if ball is not None:
            fields = parts.solve_displacement_and_stress_of_part(scene, part, level, ball - 1, cache)
    except ValueError as error:
        advice = "change the keys of [solid] or the nut's length in the scene"
        raise SceneNotCoveredError(scene.name, part, str(error), advice) from error
    with replaced_file(out) as file:
        mesh_files.write_mesh(file, mesh, fields, region=part, file_format=form)
    from rollbench.meshes.fem import element_type_of_mesh

    nodes, cells = mesh.doflocs.shape[1], f"{mesh.nelements} {_LABELS[element_type_of_mesh(mesh)]}"
    lines.append(f"wrote {out}: {nodes} nodes, {cells}; lengths in m; groups: {', '.join(mesh.boundaries) or 'none'}")
    if mesh_files.loses_nodes_in_format(mesh, form):
        lines.append(f".{form} files cannot contain 27-node hexahedra: 20-node hexahedra were written")
    return CommandOutput(texts_and_tables=lines)


def write_stiffness_tables(scene: str, ross: Path | None, modelica: Path | None) -> CommandOutput:
    """Convert a table of stiffnesses, which ``rollbench table`` wrote as JSON, to files for the programs ROSS and Modelica.

    ``scene``: the JSON file. ``ross``, ``modelica``: files to write; None: not written. Raises InputError if ``scene``
    is no such file, or if the table lacks a combination of its parameter values.
    """
    from rollbench.compare.files import replace_file, written_together
    from rollbench.compare.studies.table_files import ROSS_DROPS, modelica_table_text, read_table_file, ross_module_text
    from rollbench.compare.text.solved import missing_result_lines

    table = read_table_file(scene)
    lines = [f"left out: {line}" for line in missing_result_lines(table)]
    with written_together():
        if ross is not None:
            replace_file(ross, ross_module_text(table))
            lines.append(f"wrote {ross}. {ROSS_DROPS}")
        if modelica is not None:
            text, left = modelica_table_text(table)
            replace_file(modelica, text)
            lines += [f"left out: {line}" for line in left[len(table.failures) :]]
            lines.append(f"wrote {modelica}: all terms, by the definition of the format; not tested with OpenModelica")
    return CommandOutput(texts_and_tables=lines, wrap_always=True)


#: Names of the finite elements of a mesh, by their type.
_LABELS = {"P1": "4-node tetrahedra", "P2": "10-node tetrahedra", "Q1": "8-node hexahedra", "Q2": "27-node hexahedra"}


def write_step_bodies(described: Solvable, out: Path | None) -> CommandOutput:
    """Write the parts of a scene as CAD bodies and groove surfaces to STEP files, with lengths in mm.

    ``out``: file of the bodies, replaced if it exists; None: ``<scene>.step``. Raises InputError if gmsh is missing or a
    file cannot be written, SceneNotCoveredError for roller bearings (which have no groove) and for parts without wall
    thickness.
    """
    running.check_gmsh()
    running.check_packages("scikit-fem")
    from rollbench.compare.files import raise_input_error_if_not_writable
    from rollbench.compare.studies.export import nuts_and_bearings_on_shaft
    from rollbench.meshes.exchange.step_files import write_step
    from rollbench.meshes.files import create_folder_for_group

    out = Path(f"{described.name}.step") if out is None else out
    out = out.with_name(f"{out.name}.step") if out.suffix == "" else out
    try:
        with raise_input_error_if_not_writable(out):
            create_folder_for_group(out.parent)
            with TemporaryDirectory(dir=out.parent) as folder:  # both files or none
                written = write_step(Path(folder, out.name), nuts_and_bearings_on_shaft(described))
                files = {path.replace(out.with_name(path.name)): off for path, off in written.items()}
    except ValueError as error:
        advice = "change the keys of [solid] or the nut's length in the scene"
        raise SceneNotCoveredError(described.name, "step", str(error), advice) from error
    bodies, *grooves = files
    lines = [f"wrote {bodies}: shaft, nuts and balls{' without their grooves' if grooves else ''}; lengths in mm"]
    for path in grooves:
        off = f"at most {1e6 * files[path]:.2g} um from the exact surfaces"
        lines.append(f"wrote {path}: flanks of the grooves as surfaces, {off}; lengths in mm")
    return CommandOutput({"files": [str(path) for path in files], "largest_distance_um": 1e6 * max(files.values())}, lines)


@app.command
def condense(scene: str, *, out: Path | None = None, level: int = 1) -> int:
    """Reduce the 3D bodies of a scene to the compliances of their contacts, for rollbench solve --condensed.

    Parameters
    ----------
    scene
        Name of a shipped scene, or a scene file. The written file is valid for all loads, supports and errors of the same
        parts.
    out
        File to write; an existing file is replaced. Default: <scene>-condensed.npz.
    level
        Mesh level, 1 (coarse) to 3.
    """
    from rollbench.compare.files import check_writable, raise_input_error_if_not_writable
    from rollbench.compare.reference.levels import LEVELS
    from rollbench.compare.reference.tasks import mesh_settings
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.scene_file import scenes_to_solve, single_nut_scene_or_raise

    if level not in LEVELS:
        raise ArgumentError("level", str(level), f"1 to {len(LEVELS)}", "choose a mesh level")
    described = catalogue.scene_of_any_kind(scene)
    scenes = [single_nut_scene_or_raise(x, scene) for x in scenes_to_solve(described, scene)]
    out = out or Path(f"{described.name}-condensed.npz")
    check_writable(out)
    running.check_reference_programs()
    from rollbench.hifi.condensed import collect_condensed_bodies
    from rollbench.hifi.setup import mesh_and_condense_geometry
    from rollbench.meshes.cache import Cache

    try:
        settings, step = mesh_settings(scenes, level), running.show_progress_message
        how: dict[str, Any] = {"cache": Cache(cache_folder()), "processes": running.usable_cores()}
        setup = mesh_and_condense_geometry(scenes[0], (0, 1, 2, 3), settings, step, **how)
    except MemoryError as error:
        raise running.out_of_memory_error(error) from error
    except ValueError as error:
        advice = "change the keys that the reason names"
        raise SceneNotCoveredError(scenes[0].name, "3D bodies", str(error), advice) from error
    with raise_input_error_if_not_writable(out):
        collect_condensed_bodies(setup, level).save(out)
    command = f"rollbench solve {shlex.quote(scene)} --condensed {shlex.quote(str(out))}"
    return print_command_output(CommandOutput(texts_and_tables=[f"wrote {out}; use it with: {command}"]))


def stored_calculix_results(folder: Path, scene: Scene) -> CalculixRunsOfScene:
    """Return the stored results of CalculiX for a scene.

    Raises InputError if there are none, or if they belong to another scene of the same name.
    """
    from rollbench.compare.studies.crosscheck import results, study

    found = results.load_calculix_results(folder, scene.name)
    if found is None:
        allowed, advice = ", ".join(study.STUDIES), "solve the scene with CalculiX by `run=True`"
        raise InputError(scene.name, "crosscheck", "a scene without stored results of CalculiX", allowed, advice)
    if found.key != study.digest_of_shipped_scene(scene.name):
        wanted = "results of the present scene", "solve the scene again by `run=True`"
        raise InputError(scene.name, "crosscheck", "stored results for another scene of this name", *wanted)
    return found


def _find_or_compute_reference(scene: Scene, store: Path, engine: ComputingSettings) -> Reference:
    """Return the 3D reference of a scene; it is computed if no run is stored.

    ``store``: folder of stored runs. ``engine``: computes missing runs. Raises InputError if no run converged.
    """
    from rollbench.compare.reference.estimate import reference_of_scene
    from rollbench.compare.reference.jobs import ensure_runs_are_stored, plan_reference_tasks
    from rollbench.compare.reference.levels import LEVELS
    from rollbench.compare.reference.store import shipped_store

    stores = (store, shipped_store())
    found = reference_of_scene(scene, stores)
    if found is None:
        tasks = plan_reference_tasks([scene], tuple(LEVELS))
        ensure_runs_are_stored(tasks, store, engine, running.show_progress_message, stores)
        found = reference_of_scene(scene, stores)
    if found is None:
        wanted = "a scene whose contact problem has a solution", f"read the status of the runs in the folder {store}"
        raise InputError(scene.name, "3D reference", "no converged run", *wanted)
    return found


def _calculix_loads_table(scene: Scene, rows: Sequence[Row]) -> TextTable:
    """Return the table that compares the loads of every contact by CalculiX and by the 3D reference.

    ``rows``: for each contact, the loads with their errors and uncertainties.
    """
    from rollbench.compare.studies.crosscheck import results
    from rollbench.reports.content import table_column

    columns = {key: table_column(name) for name, key in results.COLUMNS.items()}
    heads = ["\n".join((*c.label.split(", "), *([c.unit] if c.unit else ()))) for c in columns.values()]
    texts = [[format_cell(row[key], c.format) for key, c in columns.items()] for row in rows]
    title = f"{scene.name}: contact loads, those by CalculiX extrapolated to zero cell size (--json lists every mesh)"
    return TextTable(heads, texts, title)


@app.command
def crosscheck(
    scene: str,
    *,
    run: Flag = False,
    fresh: Flag = False,
    data: Path | None = None,
    work: Path = Path("rollbench-crosscheck"),
    store: Path = Path("rollbench-reference"),
    as_json: Json = False,
) -> int:
    """Compare the contact loads of the 3D reference with those by CalculiX, on the scene two-balls or lin-case1-cut.

    Parameters
    ----------
    scene
        Name of a shipped scene for which a deck of CalculiX exists.
    run
        Solve the decks that have no stored result with CalculiX (program ccx), and store their results.
    fresh
        With --run: solve all decks again, which takes up to an hour on one core.
    data
        Folder of the stored results of CalculiX. Default: the shipped results.
    work
        Folder of the decks and the output of CalculiX; a deck whose output exists is not solved again.
    store
        Folder of stored runs of the 3D reference, used in addition to the shipped runs; a missing run is computed.
    """
    from rollbench.compare.reference.jobs import ComputingSettings
    from rollbench.compare.studies.crosscheck import results, study

    of, folder = study.scene_compared_with_calculix(scene), data or results.shipped_calculix_results_folder()
    written = []
    if run:
        running.check_gmsh()
        kept = None if fresh else results.load_calculix_results(folder, of.name)
        stored_runs = kept.runs if kept is not None and kept.key == study.digest_of_shipped_scene(of.name) else ()
        solved = study.solve_decks_of_scene(of, work, running.show_progress_message, stored_runs)
        written.append(f"wrote {results.save_calculix_results(folder, solved)}")
        if of.name == study.NUT_SCENE and (fresh or study.load_nut_compliance(folder) is None):
            compliance = study.compare_nut_compliance(of, work, key=study.digest_of_shipped_scene(of.name))
            written.append(f"wrote {study.save_nut_compliance(folder, compliance)}")
    found = stored_calculix_results(folder, of)
    ours = _find_or_compute_reference(of, store, ComputingSettings(cache_folder=cache_folder()))
    rows = results.compare_contact_loads(found, ours)
    agreed = results.agreement_sentence(of.name, rows)
    parts = [*written, _calculix_loads_table(of, rows), agreed]
    alone = study.load_nut_compliance(folder)
    if alone is not None and alone.key == study.digest_of_shipped_scene(of.name):
        parts.append(alone.sentence_on_agreement())
    answer = CommandOutput({"scene": of.name, "agreement": agreed, "contacts": rows}, parts)
    return print_command_output(answer, as_json)
