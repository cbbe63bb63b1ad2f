"""Command ``rollbench mesh-study``: solves the 3D reference on several mesh levels, and estimates its uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.commands.terminal import ComputeOptions, Flag, Json, app, engine_from_options, refuse_given_arguments
from rollbench.compare.running import show_progress_message
from rollbench.compare.text.printing import CommandOutput, print_command_output, table_of_records

if TYPE_CHECKING:
    from rollbench.compare.reference.store import Run
    from rollbench.compare.reference.tasks import Solvable
    from rollbench.compare.results.mesh_study import MeshStudy
    from rollbench.compare.studies.roller import RollerRun


@app.command(name="mesh-study")
def mesh_study(
    scenes: list[str],
    *,
    levels: int | None = None,
    store: Path = Path("rollbench-reference"),
    spread: Flag = False,
    source_mesh: Flag = False,
    fresh: Flag = False,
    bodies: str = "half-space",
    as_json: Json = False,
    where: ComputeOptions | None = None,
) -> int:
    """Solve the 3D reference on several mesh levels, and print the order of convergence and the uncertainty of its results.

    For a scene with tapered rollers, one roller of each kind is pressed between its races by the largest load that it
    carries in the scene, and compared with low-order laws.

    Exit code 5 if contact loads of a run still change after the last update of the contact normals and gaps: their
    remaining change is printed, stored with the run, and added to the uncertainty of its loads.

    Parameters
    ----------
    scenes
        Names of shipped scenes, or scene files; scenes with the same parts share their meshes.
    levels
        Number of the finest mesh level; all levels from 1 to this one are solved. Default: levels 1 and 3, of which 3 is
        clearly more accurate (for scenes of single rolling balls, or of rollers: 1, 2 and 3). Each run is stored when it is
        complete, so an interrupted study resumes.
    store
        Folder to which runs, the table (CSV) and the figure (SVG) are written.
    spread
        Also vary, on the coarsest level, the modelling choices that the publication of the scene leaves open.
    source_mesh
        Also solve on the mesh of Lin's thesis: first-order tetrahedra of 0.08 mm around every contact.
    fresh
        Compute runs even if they are stored.
    bodies
        Bodies of the 3D model of rolling contact, for scenes of single rolling balls: half-space, or finite (bodies of
        finite size: pieces of screw, ring, nut and ball as in the static 3D reference; for a linear bearing, a ball and
        grooved bars).
    """
    from rollbench.compare.commands.compare import exit_code_of_references, scenes_of_friction_or_none
    from rollbench.compare.files import reason_without_figure, write_csv, write_figure, written_together
    from rollbench.compare.reference.store import shipped_store
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.scene_file import scenes_to_solve
    from rollbench.compare.studies import mesh_study as study_of

    unused = {"spread": spread, "source_mesh": source_mesh, "bodies": bodies != "half-space"}
    if are_all_roller_scenes(scenes, unused, where):
        return print_command_output(study_single_rollers(scenes, levels, store, fresh=fresh), as_json)
    rolling = scenes_of_friction_or_none(scenes, bodies, {"spread": spread})
    engine, how = engine_from_options(where), {"source": source_mesh, "fresh": fresh}
    if rolling:
        from rollbench.compare.studies.rolling.rows import rolling_mesh_study

        rows = rolling_mesh_study(rolling, levels, store, engine, **how, bodies=bodies)
        parts = list[Any]()
        for name in dict.fromkeys(row["scene"] for row in rows):
            of_scene = [{k: v for k, v in row.items() if k != "scene"} for row in rows if row["scene"] == name]
            parts += [f"mesh study of {name}", "", table_of_records(of_scene, ".6g")]
        return print_command_output(CommandOutput(rows, parts), as_json)
    solvable: list[Solvable] = [x for name in scenes for x in scenes_to_solve(catalogue.scene_of_any_kind(name), name)]
    stores, numbers = (store,) if fresh else (store, shipped_store()), study_of.mesh_levels_of_study(levels)
    references = study_of.compute_references_on_levels(
        solvable, numbers, stores, engine, show_progress_message, **how, spread=spread
    )
    tables: dict[str, list[dict[str, Any]]] = {scene.name: [] for scene in solvable}
    parts = list[Any]()
    for one in references:
        study, stem = study_of.mesh_study_of_reference(one, stores, numbers), store / f"{one.scene.name}-mesh-study"
        table = [x.as_json() for x in study.quantities]
        rows = table if one.assembly is None else [{"set": one.set_name, **row} for row in table]
        tables[one.described_scene.name] += rows
        figure = study.figure()
        with written_together():
            write_csv(Path(f"{stem}.csv"), rows)
            if figure is not None:
                write_figure(Path(f"{stem}.svg"), figure)
        quantities = study_of.mesh_study_rows_for_terminal(study.quantities)
        parts += tables_of_study(one.reference.scene, study, one.reference.runs, quantities)
        parts += filter(None, [one.reference.unsettled])
        parts.append(f"every contact: {stem}.csv and {reason_without_figure() or '.svg'}")
    answer = CommandOutput(tables, parts, exit_code_of_references(one.reference for one in references))
    return print_command_output(answer, as_json)


def tables_of_study(
    title: str, study: MeshStudy, runs: Sequence[Run | RollerRun], quantities: Sequence[Mapping[str, Any]]
) -> list[Any]:
    """Return the tables of the mesh levels and of the quantities of a study, with its notes, for the terminal.

    ``runs``: the run on each mesh level: times measured with another version are left out; ``quantities``: rows of the
    second table.
    """
    from rollbench.compare.quantities import record_as_json
    from rollbench.compare.reference.store import shows_times_of

    unknown = dict.fromkeys(("seconds", "cpu_seconds", "measured_with"))
    shown = [shows_times_of(run.versions.get("rollbench", "")) for run in runs]
    levels = [record_as_json(level) | ({} if known else unknown) for level, known in zip(study.levels, shown, strict=True)]
    return [f"mesh study of {title}", "", table_of_records(levels), "", table_of_records(quantities), "", *study.notes]


def are_all_roller_scenes(names: Sequence[str], unused_arguments: Mapping[str, bool], where: ComputeOptions | None) -> bool:
    """Return whether all scenes have tapered roller bearings, so that single rollers are studied instead of whole scenes.

    ``names``: names or files of the scenes. ``unused_arguments``: for each option that has no effect on rollers, whether
    the user gave it. ``where``: options for parallel runs, which have no effect on rollers either. Raises InputError if
    only some scenes have rollers, or if all have rollers and the user gave an option without effect.
    """
    from rollbench.compare.errors import ArgumentError
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.studies.roller import has_rollers

    have = [has_rollers(catalogue.scene_of_any_kind(name)) for name in names]
    if any(have) and not all(have):
        allowed = "either scenes with tapered rollers, or scenes without"
        raise ArgumentError("scenes", " ".join(names), allowed, "study them in separate runs")
    if any(have):
        given, allowed = "this option for scenes with tapered rollers", "this option only for screws and ball bearings"
        unused = {**unused_arguments, "backend": where}
        refuse_given_arguments(unused, allowed, "leave it out: it would change nothing", given)
    return any(have)


def study_single_rollers(names: Sequence[str], count: int | None, store: Path, *, fresh: bool) -> CommandOutput:
    """Compute missing 3D runs of single tapered rollers on several mesh levels, and return a table for each kind of roller.

    ``names``: scenes with roller bearings. ``count``: number of the finest mesh level; None: 3. ``store``: folder of stored
    runs. ``fresh``: compute stored runs again. Raises InputError in the cases in which
    `compare.studies.roller.compute_runs_of_roller_kinds` raises it.
    """
    from rollbench.compare.files import write_csv, written_together
    from rollbench.compare.reference.store import shipped_store
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.scene_file import scenes_to_solve
    from rollbench.compare.studies import roller
    from rollbench.meshes.axis import Assembly

    found: dict[str, list[dict[str, Any]]] = {}
    parts, stores = list[Any](), (store, shipped_store())
    for scene in [x for name in names for x in scenes_to_solve(catalogue.scene_of_any_kind(name), name)]:
        assert isinstance(scene, Assembly)
        kinds = roller.compute_runs_of_roller_kinds(scene, count, stores, show_progress_message, fresh=fresh)
        for one, runs in kinds:
            study = roller.roller_mesh_study(scene.name, one, runs)
            found.setdefault(scene.name, []).append(study.as_json())
            stem = store / f"{scene.name}-{one.bearing_names[0]}-roller".replace(" ", "-")
            with written_together():
                write_csv(Path(f"{stem}.csv"), study.frame_rows())
                write_csv(Path(f"{stem}-profile.csv"), study.profile)
            title = f"{scene.name}: a roller of {study.set}"
            parts += tables_of_study(title, study, runs, roller.roller_rows_for_terminal(study.quantities))
            parts.append(f"along the roller: {stem}-profile.csv")
    return CommandOutput(found, parts)
