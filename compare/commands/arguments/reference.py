"""The 3D reference of scenes: mesh-study, compare."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from rollbench.comparison.commands.arguments.terminal import Flag, Json, Where, app, engine
from rollbench.comparison.commands.printing import print_answer


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
    from rollbench.comparison.commands.comparing.kinds import all_rolling
    from rollbench.comparison.commands.comparing.study import run_mesh_study

    if rolling := all_rolling(scenes, bodies, "rolling study", {"--spread": spread}):
        answer = rolling(scenes, levels, store, engine(where), source=source_mesh, fresh=fresh, bodies=bodies)
    else:
        answer = run_mesh_study(scenes, levels, store, engine(where), spread=spread, source=source_mesh, fresh=fresh)
    return print_answer(answer, as_json)


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
    from rollbench.comparison.commands.comparing.kinds import all_rolling
    from rollbench.comparison.commands.comparing.study import parse_levels, run_compare

    wanted = None if levels is None else parse_levels(levels)
    means_nothing = {"--model": model is not None, "--balls": balls, "--reference": reference is not None}
    if rolling := all_rolling(scenes, bodies, "rolling compare", means_nothing):
        answer = rolling(scenes, wanted, store, engine(where), fresh=fresh, bodies=bodies)
    else:
        answer = run_compare(
            scenes, model or (), wanted, store, engine(where), fresh=fresh, balls=balls, reference=reference
        )
    return print_answer(answer, as_json)
