"""Loads of drawn catalogue screws on levels 1 to 3, by which bars of discretisation are judged.

``python -m tests.judging_levels`` computes those that ``compare/references/judging_levels.json`` lacks (one to five minutes
of one core for a screw) and writes it after each.
"""

import json
from itertools import product

import numpy as np

from rollbench.compare.reference.computing import compute_reference_runs
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.reference.tasks import ReferenceTask
from rollbench.compare.scenes import scene_file
from rollbench.compare.sections.u_val import JUDGES
from rollbench.compare.studies.survey import SEED, TUBES, built_in_survey, random_screw_scene_text

LEVELS = (1, 2, 3)
#: Screws, those that were chosen before the others, contacts that a screw has at most, and what the others are drawn by.
COUNT, FIRST, MOST, DRAWN_BY = 20, (69, 109), 80, (SEED, 200)


def chosen() -> tuple[int, ...]:
    """Numbers of the screws, drawn from those of the survey that have few contacts."""
    rows = [row for row in built_in_survey()["scenes"] if row["number"] < TUBES and row["contacts"] <= MOST]
    few = [row["number"] for row in rows if row["number"] not in FIRST]
    drawn = np.random.default_rng(DRAWN_BY).permutation(few)
    return (*FIRST, *(int(k) for k in drawn[: COUNT - len(FIRST)]))


def name_of(number: int) -> str:
    """Name of a screw of the survey."""
    return f"survey-{SEED}-{number}"


def main() -> None:
    """Compute what is missing; write the record after each, a line for every scene; loads to six digits."""
    path = shipped_store() / JUDGES
    data = json.loads(path.read_text(encoding="utf-8"))
    for number, level in product(chosen(), LEVELS):
        name, text = name_of(number), random_screw_scene_text(SEED, number)
        loads = data.setdefault(name, {})
        loads["scene"] = text
        if str(level) not in loads:
            (run,) = compute_reference_runs(ReferenceTask((scene_file.scene_from_text(text, f"{name}.toml"),), level))
            loads[str(level)] = [[float(f"{x:.6g}") for x in row] for row in run.load.tolist()]
            print(f"{name}, level {level}: {run.status}", flush=True)
        lines = ",\n".join(f" {json.dumps(name)}: {json.dumps(loads)}" for name, loads in data.items())
        path.write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
