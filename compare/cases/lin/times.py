"""Run times of the models, compared with those printed in Tables 2.2, 3.5 and 3.7 of Lin's thesis.

``rollbench bench --store FOLDER`` measures and stores all these times. A cold run is made in a new process with empty
caches, and its time includes imports. A further run is the next load case in the same process.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.running import show_progress_message
from rollbench.compare.sections.reference_time import level_time_jobs, run_times_to_show
from rollbench.compare.studies.rolling.runs import LEVELS
from rollbench.compare.studies.run_times import ColdLevelTime, Measured, RunTime, Timed, time_call_in_new_process

#: Scenes of the case studies of Table 2.2, by number; scenes of Tables 3.5 and 3.7, by case.
STATIC = {1: "lin-case1", 2: "lin-case2", 3: "lin-case3-offset"}
LINEAR, SCREW = {c: f"lin-pair-{c}" for c in "ab"}, {c: f"lin-screw-pair-{c}" for c in "ab"}

#: Code whose run time is measured for two balls, by model: imports, and the call.
CALLS = {
    "numerical": ("import rollbench", "rollbench.friction({name!r})"),
    "formula": (
        "from rollbench.compare.cases.lin.evidence.rotary_linear import formula_force",
        "formula_force(mated={mated})",
    ),
    "3D": (
        "from rollbench.compare.running import usable_cores\nfrom rollbench.compare.scenes.catalogue import "
        "shipped_scene_of_kind\nfrom rollbench.compare.scenes.duty_cycle import FrictionScene\nfrom "
        "rollbench.compare.studies.rolling.runs import compute_run",
        "compute_run(shipped_scene_of_kind({name!r}, FrictionScene), {level}, processes=usable_cores())",
    ),
}


def time_jobs(cache: SceneResultCache) -> dict[Timed, Callable[[], Measured]]:
    """Return functions that measure further run times that are compared with those printed in Lin's thesis.

    They time each mesh level of the 3D reference on the case studies, and two balls between grooves by each model.
    ``cache``: gives stored 3D references. The key of a function is what it times.
    """
    jobs = level_time_jobs(cache, tuple(STATIC.values()))
    for name in (*LINEAR.values(), *SCREW.values()):
        for way, (imports, call) in CALLS.items():
            if way != "formula" or name in LINEAR.values():
                words = call.format(name=name, mated=name == LINEAR["b"], level=max(LEVELS))
                jobs[name, way] = partial(time_call_in_new_process, imports, words, f"{way} of {name}")
    return jobs


def stored_run_times(cache: SceneResultCache, name: str, model: str) -> tuple[float | None, float | None]:
    """Return the stored run times [s] of one model for a scene, each None if it was not measured.

    First: the first load case in a new process, imports included; second: the next load case in the same process.
    ``name``: name of the scene; ``model``: model, "lin" (static model), "numerical" (friction model of two balls),
    "formula" (Lin's formula for two balls) or "3D". ``cache``: gives solved scenes and stored 3D results.
    """
    kept = cache.compute_once(run_times_to_show, show_progress_message)
    if kept is None:
        return None, None
    found = cache.stored_reference(name) if name in STATIC.values() and model == "3D" else None
    level = None if found is None else kept.of_kind(ColdLevelTime).get((name, found.best.level))
    if level is not None:
        return level.process, level.load_case
    known = kept.of_kind(RunTime).get((name, model))
    return (None, None) if known is None else (known.cold, known.warm)
