"""Command ``rollbench crosscheck``: compares the contact loads of the 3D reference with those by CalculiX."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rollbench.compare.commands.terminal import Flag, Json, app, cache_folder
from rollbench.compare.errors import InputError
from rollbench.compare.running import need_gmsh, on_terminal
from rollbench.compare.text.printing import Answer, cell, print_answer, ruled_table

if TYPE_CHECKING:
    from rollbench.compare.reference.estimate import Reference
    from rollbench.compare.reference.jobs import Engine
    from rollbench.compare.studies.crosscheck.results import ContactRow, CrossData
    from rollbench.meshes.parts import Scene


def run_crosscheck(
    name: str, *, run: bool, fresh: bool, data: Path | None, work: Path, store: Path, engine: Engine
) -> Answer:
    """Compare the contact loads of a scene by the 3D reference with those by CalculiX, and return tables and sentences.

    ``run``: solve decks without stored result with CalculiX. ``fresh``: solve all decks again. ``data``: folder of stored
    results. ``work``: folder of decks. ``store``: folder of runs of the 3D reference. Raises InputError for a scene without
    results, for results of another scene of that name, and if CalculiX fails.
    """
    from rollbench.compare.studies.crosscheck.results import (
        agreement_sentence,
        contact_rows,
        load_results,
        save_results,
        shipped_results,
    )
    from rollbench.compare.studies.crosscheck.study import (
        NUT_SCENE,
        compare_nut_compliance,
        load_nut,
        run_study,
        save_nut,
        scene_key,
        studied_scene,
    )

    scene, folder = studied_scene(name), data or shipped_results()
    written = []
    if run:
        need_gmsh()
        kept = None if fresh else load_results(folder, scene.name)
        stored_runs = kept.runs if kept is not None and kept.key == scene_key(scene.name) else ()
        written.append(f"wrote {save_results(folder, run_study(scene, work, on_terminal, stored_runs))}")
        if scene.name == NUT_SCENE and (fresh or load_nut(folder) is None):
            written.append(f"wrote {save_nut(folder, compare_nut_compliance(scene, work, key=scene_key(scene.name)))}")
    found = stored_crosscheck_results(folder, scene)
    ours = _reference_of_scene(scene, store, engine)
    rows = contact_rows(found, ours)
    agreed = agreement_sentence(scene.name, rows)
    alone = load_nut(folder)
    sentence = [alone.sentence()] if alone is not None and alone.key == scene_key(scene.name) else []
    answer = {"scene": scene.name, "agreement": agreed, "contacts": [r.cells() for r in rows]}
    return Answer(answer, [*written, _loads_table(scene, rows), agreed, *sentence])


def stored_crosscheck_results(folder: Path, scene: Scene) -> CrossData:
    """Return the stored results of CalculiX for a scene.

    Raises InputError if there are none, or if they belong to another scene of the same name.
    """
    from rollbench.compare.studies.crosscheck.results import load_results
    from rollbench.compare.studies.crosscheck.study import STUDIES, scene_key

    found = load_results(folder, scene.name)
    if found is None:
        allowed, advice = ", ".join(STUDIES), "solve the scene with CalculiX by `run=True`"
        raise InputError(scene.name, "crosscheck", "a scene without stored results", allowed, advice)
    if found.key != scene_key(scene.name):
        wanted = "results of the present scene", "solve the scene again by `run=True`"
        raise InputError(scene.name, "crosscheck", "results of another scene with this name", *wanted)
    return found


def _reference_of_scene(scene: Scene, store: Path, engine: Engine) -> Reference:
    """Return the 3D reference of a scene, computed if no run is stored; InputError if no run converged."""
    from rollbench.compare.reference.estimate import reference
    from rollbench.compare.reference.jobs import ensure, plan
    from rollbench.compare.reference.levels import LEVELS
    from rollbench.compare.reference.store import shipped_store

    stores = (store, shipped_store())
    found = reference(scene, stores)
    if found is None:
        ensure(plan([scene], tuple(LEVELS)), store, engine, on_terminal, stores)
        found = reference(scene, stores)
    if found is None:
        wanted = "a scene whose contact problem has a solution", f"read the status of the runs in the folder {store}"
        raise InputError(scene.name, "3D reference", "no converged run", *wanted)
    return found


def _loads_table(scene: Scene, rows: Sequence[ContactRow]) -> Any:
    """Return the table that compares the loads of every contact by CalculiX and by the 3D reference."""
    from rollbench.compare.studies.crosscheck.results import COLUMNS

    heads = {c.key: "\n".join((*c.label.split(", "), *([c.unit] if c.unit else ()))) for c in COLUMNS}
    texts = ([cell(row.cells().get(c.key), c.format) for c in COLUMNS] for row in rows)
    title = f"{scene.name}: contact loads, those by CalculiX extrapolated to zero cell size (--json lists every mesh)"
    return ruled_table(title, heads.values(), texts, [heads["side"]])


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
    from rollbench.compare.reference.jobs import Engine

    where = Engine(cache=cache_folder())
    found = run_crosscheck(scene, run=run, fresh=fresh, data=data, work=work, store=store, engine=where)
    return print_answer(found, as_json)
