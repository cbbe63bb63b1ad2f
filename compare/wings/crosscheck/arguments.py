"""Options and help of ``rollbench crosscheck``."""

from __future__ import annotations

from pathlib import Path

from rollbench.compare.commands.arguments.terminal import Flag, Json, app, cache_folder
from rollbench.compare.commands.printing import print_answer


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
    """Compare the 3D reference with CalculiX, contact by contact: two-balls or lin-case1-cut.

    Parameters
    ----------
    scene
        Name of a shipped scene that was solved by CalculiX.
    run
        Solve with CalculiX (ccx) now those of its decks that have no stored result, and rewrite the stored results.
    fresh
        With --run: solve all decks again, up to an hour of one core.
    data
        Folder of the stored results; that of the package unless given.
    work
        Folder of the decks and their results; a deck whose result is there is not solved again.
    store
        Folder of the reference's runs, besides those shipped; computed where none is stored.
    """
    from rollbench.compare.reference.jobs import Engine
    from rollbench.compare.wings.crosscheck.command import run_crosscheck

    where = Engine(cache=cache_folder())
    found = run_crosscheck(scene, run=run, fresh=fresh, data=data, work=work, store=store, engine=where)
    return print_answer(found, as_json)
