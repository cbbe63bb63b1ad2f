"""Models beside the 3D reference of scenes: compare."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from rollbench.comparison.commands.arguments.terminal import Flag, Json, Where, app, engine
from rollbench.comparison.commands.printing import print_answer


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
