"""Loads of drawn catalogue screws on levels 1 to 3, by which bars of discretisation are judged.

``python -m tests.judging_levels`` computes those that ``compare/references/judging_levels.json`` lacks (one to five minutes
of one core for a screw) and writes it after each.
"""

import json
from pathlib import Path

import numpy as np

from rollbench.compare.models.applicability import SURVEY
from rollbench.compare.reference.computing import compute_reference_runs
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.reference.tasks import ReferenceTask
from rollbench.compare.scenes import scene_file
from rollbench.compare.sections.u_val import JUDGES
from rollbench.compare.studies.survey import SEED, TUBES, random_screw_scene_text

LEVELS = (1, 2, 3)
#: Screws, those that were chosen before the others, contacts that a screw has at most, and what the others are drawn by.
COUNT, FIRST, MOST, DRAWN_BY = 20, (69, 109), 80, (SEED, 200)


def chosen() -> tuple[int, ...]:
    """Numbers of the screws, drawn from those of the survey that have few contacts."""
    rows = json.loads((shipped_store() / SURVEY).read_text(encoding="utf-8"))["scenes"]
    few = [
        row["number"] for row in rows if row["number"] < TUBES and row["contacts"] <= MOST and row["number"] not in FIRST
    ]
    drawn = np.random.default_rng(DRAWN_BY).permutation(few)
    return (*FIRST, *(int(k) for k in drawn[: COUNT - len(FIRST)]))


def name_of(number: int) -> str:
    """Name of a screw of the survey."""
    return f"survey-{SEED}-{number}"


def write(path: Path, data: dict[str, object]) -> None:
    """Write the record, a line for every scene; loads to six digits."""
    lines = (f" {json.dumps(name)}: {json.dumps(loads, separators=(', ', ': '))}" for name, loads in data.items())
    path.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def main() -> None:
    """Compute what is missing."""
    path = shipped_store() / JUDGES
    data = json.loads(path.read_text(encoding="utf-8"))
    for number in chosen():
        name, text = name_of(number), random_screw_scene_text(SEED, number)
        loads = data.setdefault(name, {})
        loads["scene"] = text
        for level in LEVELS:
            if str(level) not in loads:
                (run,) = compute_reference_runs(ReferenceTask((scene_file.scene_from_text(text, f"{name}.toml"),), level))
                loads[str(level)] = [[float(f"{x:.6g}") for x in row] for row in run.load.tolist()]
                print(f"{name}, level {level}: {run.status}", flush=True)
                write(path, data)
    write(path, data)


if __name__ == "__main__":
    main()
