"""The command rollbench mesh-study."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.commands.terminal import Flag, Json, Where, app, engine
from rollbench.compare.running import on_terminal
from rollbench.compare.text.printing import Answer, aligned, print_answer

if TYPE_CHECKING:
    from rollbench.compare.reference.jobs import Engine
    from rollbench.compare.reference.tasks import Solvable


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
    where: Where | None = None,
) -> int:
    """Run the 3D reference on several mesh levels: observed orders, uncertainty, modelling spread.

    Exit code 5 where loads did not settle: what they may still move by is said, kept with the run and added to its bars.

    Parameters
    ----------
    scenes
        Names of shipped scenes, or scene files; those of the same parts share their meshes.
    levels
        Levels 1 to this one; unless given, levels 1 and 3, of which the second is clearly more accurate (of scenes of
        friction 1 to 3). Each is stored when it is done, so an interrupted study resumes.
    store
        Folder of the results; the table goes there as CSV, the figure as SVG.
    spread
        Also vary the modelling choices that are not printed, on the coarsest level.
    source_mesh
        Also run the source's mesh: first-order tetrahedra of 0.08 mm around every contact.
    fresh
        Compute runs even where they are stored.
    bodies
        Of scenes of friction: half-space, or finite (patches of the static reference, or a ball and grooved bars).
    """
    from rollbench.compare.commands.compare import all_rolling, run_rolling_study

    if all_rolling(scenes, bodies, {"spread": spread}):
        answer = run_rolling_study(scenes, levels, store, engine(where), source=source_mesh, fresh=fresh, bodies=bodies)
    else:
        answer = run_mesh_study(scenes, levels, store, engine(where), spread=spread, source=source_mesh, fresh=fresh)
    return print_answer(answer, as_json)


def run_mesh_study(
    names: Sequence[str], count: int | None, store: Path, engine: Engine, *, spread: bool, source: bool, fresh: bool = False
) -> Answer:
    """Compute what is missing (fresh: everything again), answer with the table, write it as CSV and SVG into the store.

    count: as for `levels_of`. Raises InputError for other levels, Refusal for a scene of which no run converged.
    """
    from rollbench.compare.commands.compare import code_of
    from rollbench.compare.files import no_figure, write_csv, write_figure
    from rollbench.compare.reference.store import shipped_store
    from rollbench.compare.scenes import catalogue
    from rollbench.compare.scenes.scene_file import each_case
    from rollbench.compare.sections.curves import study_figure
    from rollbench.compare.studies.mesh_study import closing, compute_study, extremes, level_rows, levels_of, table_of

    scenes: list[Solvable] = [x for name in names for x in each_case(catalogue.any_scene(name), name)]
    stores, levels = (store,) if fresh else (store, shipped_store()), levels_of(count)
    references = compute_study(scenes, levels, stores, engine, on_terminal, spread=spread, source=source, fresh=fresh)
    tables: dict[str, list[dict[str, Any]]] = {scene.name: [] for scene in scenes}
    parts: list[Any] = []
    for one in references:
        table, stem = table_of(one, stores, levels), store / f"{one.scene.name}-mesh-study"
        rows = table if one.of is None else [{"set": one.of.name, **row} for row in table]
        tables[one.scene.name if one.of is None else one.of.assembly.name] += rows
        write_csv(Path(f"{stem}.csv"), rows)
        figure = study_figure(one.scene.name, table, one.found)
        if figure is not None:
            write_figure(Path(f"{stem}.svg"), figure)
        parts += [f"mesh study of {one.found.scene}", "", aligned(level_rows(one.found)), "", aligned(extremes(table)), ""]
        parts += [closing(one.found), *filter(None, [one.found.unsettled])]
        parts.append(f"every contact: {stem}.csv and {no_figure() or '.svg'}")
    return Answer(tables, parts, code_of(one.found for one in references))
