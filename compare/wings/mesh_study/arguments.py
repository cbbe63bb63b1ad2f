"""Options and help of ``rollbench mesh-study``."""

from __future__ import annotations

from pathlib import Path

from rollbench.compare.commands.arguments.terminal import Flag, Json, Where, app, engine
from rollbench.compare.commands.printing import print_answer


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
    from rollbench.compare.commands.comparing.kinds import all_rolling
    from rollbench.compare.wings.mesh_study.command import run_mesh_study

    if rolling := all_rolling(scenes, bodies, "rolling study", {"spread": spread}):
        answer = rolling(scenes, levels, store, engine(where), source=source_mesh, fresh=fresh, bodies=bodies)
    else:
        answer = run_mesh_study(scenes, levels, store, engine(where), spread=spread, source=source_mesh, fresh=fresh)
    return print_answer(answer, as_json)
