"""Errors and times of two mesh levels of the 3D reference, and of the models, on screws chosen from the drawn ones.

The survey compares models with level 1, which has errors of its own. On `COUNT` of its screws, chosen by a seed, level 2 is
solved too, so that the error of level 1 and the time of either level are known. Times are processor times of one process
with one thread: all of a new screw from the set-up on, and of a further load case.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from time import process_time

import numpy as np

from rollbench.compare.files import replace_file
from rollbench.compare.measure import load_error
from rollbench.compare.models.applicability import KNOWN_SCREWS
from rollbench.compare.models.registry import Options, run_model
from rollbench.compare.reference import parallel
from rollbench.compare.reference.computing import compute_runs
from rollbench.compare.reference.store import Measured, measuring_conditions
from rollbench.compare.reference.tasks import Task
from rollbench.compare.running import cores
from rollbench.compare.studies import survey
from rollbench.compare.studies.run_times import load_first_valid, today
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import Scene
from rollbench.meshes.processes import one_thread

#: Number of chosen screws, and the mesh levels solved on each.
COUNT, LEVELS = 24, (1, 2)
#: How the line of progress of a solved load case begins.
SOLVED = "contact loads"
#: File of the runs in a store.
RUNS = "survey-levels.json"


@dataclass(frozen=True)
class LevelRun:
    """Solution of a randomly drawn screw on a mesh level of the 3D reference."""

    #: Number of the screw.
    number: int
    #: Mesh level.
    level: int
    #: Status of the run, "converged" for a solution.
    status: str
    #: Processor time of a new screw: meshes, condensation and one load case [s].
    seconds: float
    #: Processor time of a further load case [s].
    further_seconds: float
    #: Contact loads of the n balls on the flanks SL, SR, NL, NR, (n, 4) [N].
    load: list[list[float]]


@dataclass(frozen=True)
class StoredLevelRuns:
    """Stored runs, with the conditions and the date of their measurement."""

    #: Conditions of the measurement.
    measured: Measured
    #: Date of the last run.
    date: str
    #: The runs.
    runs: Sequence[LevelRun]


@dataclass(frozen=True)
class Standing:
    """Largest errors and times of a model or mesh level; arrays with one entry for each randomly drawn screw."""

    #: Name of the model or mesh level.
    name: str
    #: Mesh level of the 3D reference with which its loads are compared; empty without a comparison.
    judged_by: str
    #: Largest error of a contact load by the rule of the gate [%]; empty if it is not known.
    errors: Array
    #: Largest error of a contact load [% of the mean load]; empty if it is not known.
    of_mean: Array
    #: Processor time of a new screw [s], for each screw.
    seconds: Array
    #: Processor time of a further load case [s], for each screw.
    further: Array


def chosen_screws() -> list[int]:
    """Return the numbers of the screws that level 2 is solved on, in the order in which they are solved."""
    chosen = np.random.default_rng([survey.SEED, COUNT]).choice(KNOWN_SCREWS, COUNT, replace=False)
    return [int(number) for number in chosen]


def drawn_screw(number: int) -> tuple[Scene, Scene]:
    """Return random screw ``number`` under its loads, then under raised ones, which give the tangent rigidity."""
    name = f"survey-{survey.SEED}-{number}"
    return survey.load_cases(survey.scene_text(survey.SEED, number), name)


def solve_level(number: int, level: int) -> LevelRun:
    """Solve a randomly drawn screw on a mesh level in this process, with one thread and without cache, and time it.

    ``number``: number of the screw. Level 1 has the coarser cells at the cut ends of the shaft that the survey uses. Raises
    InputError if the screw cannot be meshed.
    """
    one_thread()
    cases = drawn_screw(number)
    solved: list[float] = []

    def note_time(text: str) -> None:
        if text.startswith(SOLVED):
            solved.append(process_time())

    begin = process_time()
    cells = survey.CUT_CELLS if level == survey.LEVEL else 1.0
    run, _ = compute_runs(Task(cases, level, cut_cells=cells), note_time)
    new, further = solved[-2] - begin, solved[-1] - solved[-2]
    load = [[float(f"{x:.6g}") for x in row] for row in run.load]
    return LevelRun(number, level, str(run.status), round(new, 2), round(further, 3), load)


def measure_levels(store: Path, step: Callable[[str], None], count: int = COUNT) -> StoredLevelRuns:
    """Solve the first ``count`` chosen screws on all levels, as many processes at a time as there are cores.

    Each run is written to the store when it is done; runs that the store has from the same sources on the same machine are
    not repeated. ``step``: called with lines of progress. Raises InputError if the file cannot be written.
    """
    conditions, known = measuring_conditions(), load_levels((store,))
    runs = list(known.runs) if known is not None and known.measured == conditions else []
    done = {(run.number, run.level) for run in runs}
    jobs = [(n, level) for n in chosen_screws()[:count] for level in LEVELS if (n, level) not in done]
    found = StoredLevelRuns(conditions, today(), runs)
    for _, run in parallel.as_done([(solve_level, job) for job in jobs], "joblib", None, cores()):
        runs.append(run)
        found = StoredLevelRuns(conditions, today(), sorted(runs, key=lambda one: (one.number, one.level)))
        save_levels(store, found)
        step(f"[{len(runs)}/{count * len(LEVELS)}] drawn screw {run.number}, level {run.level}: {run.seconds:.0f} s")
    return found


def save_levels(store: Path, found: StoredLevelRuns) -> None:
    """Write runs to a store, one per line; InputError if the file cannot be written."""
    head = json.dumps({**asdict(found.measured), "date": found.date})
    rows = ",\n".join(json.dumps(asdict(run), separators=(",", ":")) for run in found.runs)
    replace_file(store / RUNS, f'{head[:-1]}, "runs": [\n{rows}\n]}}\n')


def load_levels(stores: Sequence[Path]) -> StoredLevelRuns | None:
    """Return the runs in the first store with a valid file; None without one."""

    def read(data: dict[str, object]) -> StoredLevelRuns:
        measured = Measured(str(data["version"]), str(data["sources"]), str(data["machine"]))
        rows = data["runs"]
        assert isinstance(rows, list)
        return StoredLevelRuns(measured, str(data["date"]), [LevelRun(**row) for row in rows])

    return load_first_valid(stores, RUNS, read)


def levels_and_models(runs: Sequence[LevelRun], records: Sequence[survey.Record]) -> list[Standing]:
    """Return errors and times of models and mesh levels: on all random screws by level 1, on chosen ones by level 2.

    Parameters
    ----------
    runs
        Runs of the chosen screws.
    records
        Records of the survey, with errors against level 1 and times of the models.
    """
    answers = {model: [r["models"][model] for r in records if model in r.get("models", {})] for model in survey.MODELS}
    keys = ("gate_percent", "largest_percent", *SECONDS)
    found = [
        Standing(model, "level 1", *(np.array([abs(row[key]) for row in rows if row[key] is not None]) for key in keys))
        for model, rows in answers.items()
    ]
    by_level = {level: {r.number: r for r in runs if r.level == level and r.status == survey.ANSWERED} for level in LEVELS}
    coarse, fine = (by_level[level] for level in LEVELS)
    both = sorted(coarse.keys() & fine.keys())
    times = {r["number"]: r["models"] for r in records if "models" in r}
    for model in survey.MODELS if both else ():
        loads = [run_model(drawn_screw(n)[0], model, Options(discretisation=False)).load for n in both]
        new, further = (np.array([times[number][model][key] for number in both]) for key in SECONDS)
        found.append(Standing(model, "level 2", *_largest_errors(loads, [fine[n] for n in both]), new, further))
    for level in LEVELS if both else ():
        of_level = [by_level[level][number] for number in both]
        new, further = (np.array([getattr(run, key) for run in of_level]) for key in SECONDS)
        loads = [np.array(run.load) for run in of_level]
        errors = _largest_errors(loads, [fine[n] for n in both]) if level < max(LEVELS) else (np.zeros(0), np.zeros(0))
        found.append(Standing(f"3D level {level}", "level 2" if level < max(LEVELS) else "", *errors, new, further))
    return found


def _largest_errors(loads: Sequence[Array], truths: Sequence[LevelRun]) -> tuple[Array, Array]:
    """Return the largest load error of each screw by the rule of the gate [%], then in per cent of the mean load.

    ``loads``: contact loads (n, 4) [N] of each screw; ``truths``: run of each screw by which they are judged.
    """
    found = [
        load_error(load, np.array(truth.load), nominal_contacts(drawn_screw(truth.number)[0]))
        for load, truth in zip(loads, truths, strict=True)
    ]
    return np.array([e.gate_percent for e in found]), np.array([e.max_percent for e in found])


#: Keys of a model's times in the survey's record: of a new screw, and of a further load case.
SECONDS = ("seconds", "further_seconds")
