"""Run times shown next to those of Tables 2.2, 3.5 and 3.7, all from one measuring run.

``rollbench bench --source lin --store FOLDER`` measures and stores them. Cold: a new process with empty caches,
imports included. Further: the next load case in the same process.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rollbench.compare.models.registry import MODELS, Options
from rollbench.compare.models.study import Study
from rollbench.compare.reference.store import measuring_conditions, shipped_store
from rollbench.compare.scenes.catalogue import case
from rollbench.compare.scenes.friction_kinds.common import KindScene
from rollbench.compare.sections.reference_time import warm_seconds
from rollbench.compare.studies.rolling.runs import LEVELS, load_run
from rollbench.compare.studies.run_times import (
    ColdLevelTime,
    Kept,
    RunTime,
    measure_call,
    measure_level,
    measure_model,
    times_of_page,
    today,
)

#: Scenes of the case studies of Table 2.2, by number; of Tables 3.5 and 3.7 by case.
STATIC = {1: "lin-case1", 2: "lin-case2", 3: "lin-case3-offset"}
LINEAR, SCREW = {c: f"lin-pair-{c}" for c in "ab"}, {c: f"lin-screw-pair-{c}" for c in "ab"}

#: What is timed of two balls: imports, and the call.
CALLS = {
    "numerical": ("import rollbench", "rollbench.friction({name!r})"),
    "formula": (
        "from rollbench.compare.cases.lin.evidence.rotary_linear import formula_force",
        "formula_force(mated={mated})",
    ),
    "3D": (
        "from rollbench.compare.running import cores\n"
        "from rollbench.compare.scenes.catalogue import case\n"
        "from rollbench.compare.scenes.friction_kinds.common import KindScene\n"
        "from rollbench.compare.studies.rolling.runs import compute",
        "compute(case({name!r}, KindScene), {level}, processes=cores())",
    ),
}


def measured_now(study: Study, step: Callable[[str], None]) -> Kept:
    """Return all run times of the page, measured now (takes five minutes on two idle cores)."""
    times: dict[tuple[str, str], RunTime] = {}
    levels: list[ColdLevelTime] = []
    for name in STATIC.values():
        step(f"{name}, source's model: cold and further")
        cold, model = measure_model(name, "lin", repeats=1), MODELS["lin"]
        further = warm_seconds(model, study.scene(name), Options(discretisation=False, engine="compiled"))
        times[name, "lin"] = RunTime(cold.process, further, cold.memory)
        found = study.reference(name)
        if found is not None:
            step(f"{name}, level {found.best.level} of the 3D reference: cold and a further load case")
            levels.append(measure_level(name, found.best.level))
    for name in (*LINEAR.values(), *SCREW.values()):
        for way, (imports, call) in CALLS.items():
            if way != "formula" or name in LINEAR.values():
                step(f"{name}, {way}: cold and further")
                words = call.format(name=name, mated=name == LINEAR["b"], level=max(LEVELS))
                times[name, way] = measure_call(imports, words, f"{way} of {name}")
    return Kept(measuring_conditions(), today(), times, {}, levels)


@dataclass(frozen=True)
class Seconds:
    """Seconds cold and of a further load case (None: not measured), and an older time in words."""

    cold: float | None = None
    further: float | None = None
    older: str = ""


def seconds(study: Study, name: str, way: str) -> Seconds:
    """Return the stored times of a scene by ``lin``, ``numerical``, ``formula`` or ``3D``."""
    kept = study.once(times_of_page, "lin")
    found = study.reference(name) if name in STATIC.values() and way == "3D" else None
    if found is not None:
        for level in () if kept is None else kept.levels:
            if (level.scene, level.level) == (name, found.best.level):
                return Seconds(level.process, level.load_case)
        run = found.best
        return Seconds(older=f"{run.setup_seconds + run.solve_seconds:.3g} s, measured with {run.measured}")
    known = None if kept is None else kept.times.get((name, way))
    if known is not None:
        return Seconds(known.cold, known.warm)
    if way != "3D":
        return Seconds()
    two = load_run(case(name, KindScene), max(LEVELS), study.stores or (shipped_store(),))
    return (
        Seconds() if two is None else Seconds(older=f"{two.seconds:.3g} s of processor time, measured with {two.measured}")
    )
