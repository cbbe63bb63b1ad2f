"""Command ``rollbench mesh-study``: solves the 3D reference on several mesh levels, and estimates its uncertainty."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.commands.terminal import ComputeOptions, Flag, Json, app, engine_of
from rollbench.compare.running import on_terminal
from rollbench.compare.text.printing import Answer, aligned_table, print_answer

if TYPE_CHECKING:
    from rollbench.compare.reference.jobs import Engine
    from rollbench.compare.reference.tasks import Solvable
    from rollbench.compare.scenes.friction_kinds.common import KindScene


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

    Exit code 5 if loads did not converge with mesh refinement: the remaining change is printed, stored with the run and
    added to its uncertainty.

    Parameters
    ----------
    scenes
        Names of shipped scenes, or scene files; scenes with the same parts share their meshes.
    levels
        Number of the finest mesh level; all levels from 1 to this one are solved. Default: levels 1 and 3, of which 3 is
        clearly more accurate (for scenes of friction and of rollers: 1 to 3). Each run is stored when it is complete, so an
        interrupted study resumes.
    store
        Folder to which runs, the table (CSV) and the figure (SVG) are written.
    spread
        Also vary, on the coarsest level, the modelling choices that the scene's source leaves open.
    source_mesh
        Also solve on the mesh of Lin's thesis: first-order tetrahedra of 0.08 mm around every contact.
    fresh
        Compute runs even if they are stored.
    bodies
        Bodies of the 3D model for scenes of friction: half-space, or finite (the meshes of the static reference around
        each contact, or a ball and grooved bars).
    """
    from rollbench.compare.commands.compare import rolling_scenes

    if all_rollers(scenes, {"spread": spread, "source_mesh": source_mesh, "bodies": bodies != "half-space"}, where):
        answer = run_roller_study(scenes, levels, store, fresh=fresh)
    elif rolling := rolling_scenes(scenes, bodies, {"spread": spread}):
        answer = run_rolling_study(rolling, levels, store, engine_of(where), source=source_mesh, fresh=fresh, bodies=bodies)
    else:
        answer = run_mesh_study(scenes, levels, store, engine_of(where), spread=spread, source=source_mesh, fresh=fresh)
    return print_answer(answer, as_json)


def run_rolling_study(
    scenes: Sequence[KindScene], levels: int | None, store: Path, engine: Engine, *, source: bool, fresh: bool, bodies: str
) -> Answer:
    """Compute missing runs of the 3D model of rolling contact, and return a table of mesh levels for each scene.

    ``levels``: number of the finest level. ``source``: also use the element size of Lin's thesis. ``fresh``: compute
    stored runs again. ``bodies``: "half-space", or "finite" for bodies of finite size.
    """
    from rollbench.compare.studies.rolling.rows import rolling_mesh_study

    rows = rolling_mesh_study(scenes, levels, store, engine, source=source, fresh=fresh, bodies=bodies)
    parts: list[Any] = []
    for name in dict.fromkeys(row["scene"] for row in rows):
        of_scene = [{k: v for k, v in row.items() if k != "scene"} for row in rows if row["scene"] == name]
        parts += [f"mesh study of {name}", "", aligned_table(of_scene, ".6g")]
    return Answer(rows, parts)


def run_mesh_study(
    names: Sequence[str], count: int | None, store: Path, engine: Engine, *, spread: bool, source: bool, fresh: bool = False
) -> Answer:
    """Compute missing runs of the 3D reference on several mesh levels, and return the tables of the study.

    The tables are also written as CSV and SVG to the folder ``store``. ``count``: number of the finest level, see
    `chosen_levels`. ``spread``: also vary modelling choices. ``source``: also use the mesh of Lin's thesis. ``fresh``:
    compute stored runs again. Raises InputError for unknown levels, Refusal if no run of a scene converged.
    """
    from rollbench.compare.commands.compare import exit_code
    from rollbench.compare.files import why_no_figure, write_csv, write_figure
    from rollbench.compare.reference.store import shipped_store
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.scene_file import each_case
    from rollbench.compare.sections.curves import study_figure
    from rollbench.compare.studies.mesh_study import (
        accuracy_sentence,
        chosen_levels,
        compute_study,
        level_rows,
        table_of_reference,
        terminal_rows,
    )

    scenes: list[Solvable] = [x for name in names for x in each_case(catalogue.any_scene(name), name)]
    stores, levels = (store,) if fresh else (store, shipped_store()), chosen_levels(count)
    references = compute_study(scenes, levels, stores, engine, on_terminal, spread=spread, source=source, fresh=fresh)
    tables: dict[str, list[dict[str, Any]]] = {scene.name: [] for scene in scenes}
    parts: list[Any] = []
    for one in references:
        table, stem = table_of_reference(one, stores, levels), store / f"{one.scene.name}-mesh-study"
        rows = table if one.of is None else [{"set": one.of.name, **row} for row in table]
        tables[one.scene.name if one.of is None else one.of.assembly.name] += rows
        write_csv(Path(f"{stem}.csv"), rows)
        figure = study_figure(one.scene.name, table, one.found)
        if figure is not None:
            write_figure(Path(f"{stem}.svg"), figure)
        parts += [
            f"mesh study of {one.found.scene}",
            "",
            aligned_table(level_rows(one.found)),
            "",
            aligned_table(terminal_rows(table)),
            "",
        ]
        parts += [accuracy_sentence(one.found), *filter(None, [one.found.unsettled])]
        parts.append(f"every contact: {stem}.csv and {why_no_figure() or '.svg'}")
    return Answer(tables, parts, exit_code(one.found for one in references))


def all_rollers(names: Sequence[str], means_nothing: Mapping[str, bool], where: ComputeOptions | None) -> bool:
    """Return whether all scenes have tapered roller bearings, for which `run_roller_study` is used.

    ``names``: names or files of the scenes. ``means_nothing``: options that have no effect on rollers, each with whether it
    was used. ``where``: options for parallel runs, which have no effect either. Raises InputError if only some scenes have
    rollers, or if one of these options was used with rollers.
    """
    from rollbench.compare.errors import ArgumentError
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.studies.roller import has_rollers

    have = [has_rollers(catalogue.any_scene(name)) for name in names]
    if any(have) and not all(have):
        allowed = "either scenes with tapered rollers, or scenes without"
        raise ArgumentError("scenes", " ".join(names), allowed, "study them in separate runs")
    for argument in (
        name for name, given in ({**means_nothing, "backend": where is not None}).items() if given and any(have)
    ):
        given, allowed = "this option for scenes with tapered rollers", "only for screws and ball bearings"
        raise ArgumentError(argument, given, allowed, "leave it out: it would change nothing")
    return any(have)


def run_roller_study(names: Sequence[str], count: int | None, store: Path, *, fresh: bool) -> Answer:
    """Compute missing runs of single tapered rollers in 3D, and return the tables for each kind of roller.

    ``count``: number of the finest mesh level; None: 3. ``fresh``: compute stored runs again. Raises InputError as
    `compare.studies.roller.study_rollers`.
    """
    from rollbench.compare.files import write_csv
    from rollbench.compare.reference.store import shipped_store
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.scene_file import each_case
    from rollbench.compare.studies import roller
    from rollbench.meshes.axis import Assembly

    found: dict[str, list[dict[str, Any]]] = {}
    parts: list[Any] = []
    for scene in [x for name in names for x in each_case(catalogue.any_scene(name), name)]:
        assert isinstance(scene, Assembly)
        for one, runs in roller.study_rollers(scene, count, (store, shipped_store()), on_terminal, fresh=fresh):
            said = roller.study_json(one, runs)
            found.setdefault(scene.name, []).append(said)
            stem = store / f"{scene.name}-{one.sets[0]}-roller".replace(" ", "-")
            write_csv(Path(f"{stem}.csv"), said["quantities"])
            write_csv(Path(f"{stem}-profile.csv"), said["profile"])
            parts += [
                f"mesh study of {scene.name}: a roller of {', '.join(one.sets)}",
                "",
                aligned_table(said["levels"]),
                "",
            ]
            parts += [aligned_table(roller.terminal_rows(said["quantities"])), "", roller.low_order_sentence(one, runs)]
            parts.append(f"along the roller: {stem}-profile.csv")
    return Answer(found, parts)
