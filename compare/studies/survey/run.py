"""A whole survey: scenes that no record is kept of are solved, a line each; its kept record and the report's table."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare import __version__
from rollbench.compare.models.applicability import SURVEY
from rollbench.compare.reference import parallel
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.studies.survey.record import LEVEL, MODELS, Record, surveyed
from rollbench.compare.studies.sweep import store

#: Status of a scene with an answer, columns of the table, and the errors that it sums up, with their unit.
ANSWERED = "converged"
SUMS = ("model", "error", "scenes", "median", "p95", "largest")
ERRORS = ("largest_percent", "gate_percent", "rms_percent", "displacement_percent", "rigidity_percent", "pressure_percent")


def _solved(folder: Path, token: str, seed: int, number: int) -> Record | None:
    """Solve a scene and append its record, as long as the folder is this run's."""
    if not store.current(folder, token):
        return None
    with store.working(folder):
        record = surveyed(seed, number, folder / "runs")
        store.Writer(folder, token).append([record])
    return record


def run_survey(
    seed: int, count: int, folder: Path, workers: int, step: Callable[[str], None], kept: Path | None = None
) -> list[Record]:
    """Records of the first ``count`` scenes of a survey by number; those that are answered already are not solved again:
    by the folder, or by the record ``kept`` where it is of this seed, level and version.

    step: hears of every scene. Raises InputError where the folder is another's, or another run is at work in it.
    """
    store.open_folder(folder, {"survey": seed, "level": LEVEL, "version": __version__})
    with store.taken_over(folder) as token:
        before = [*_answers(kept, seed), *store.read(folder)]
        known = {record["number"]: record for record in before if not unanswered([record])}
        left = [number for number in range(count) if number not in known]
        if len(left) < count:
            step(f"{count - len(left)} scenes of {count} are known")
        jobs = [(_solved, (folder, token, seed, number)) for number in left]
        for job, record in parallel.as_done(jobs, "joblib", None, workers):
            if record is not None:
                known[left[job]] = record
                step(f"[{len(known)}/{count}] scene {left[job]}: {record['status']}, {record['seconds']:.0f} s")
    return [known[number] for number in range(count) if number in known]


def _answers(path: Path | None, seed: int) -> list[Record]:
    """Scenes of a kept record; none where there is none, or where another version or level solved them."""
    if path is None or not path.exists():
        return []
    found = json.loads(path.read_text(encoding="utf-8"))
    same = (found.get("seed"), found.get("level")) == (seed, LEVEL)
    return [record for record in found["scenes"] if same and record["version"] == __version__]


def unanswered(records: Sequence[Record]) -> list[Record]:
    """Those without an answer, or whose loads did not settle."""
    return [r for r in records if r["status"] != ANSWERED or r.get("raised_status", ANSWERED) != ANSWERED]


def text(seed: int, records: Sequence[Record]) -> str:
    """The kept record: JSON with a scene a line; its head says how many were asked for, and how many of them are there."""
    asked = 1 + max((r["number"] for r in records), default=-1)
    head = {"command": f"rollbench stability --survey {asked}", "seed": seed, "level": LEVEL, "solved": len(records)}
    rows = ",\n".join(json.dumps(r, ensure_ascii=False) for r in records)
    return json.dumps(head)[:-1] + f', "scenes": [\n{rows}\n]}}\n'


def shipped() -> dict[str, Any]:
    """The record that comes with the package; without scenes where there is none."""
    path = shipped_store() / SURVEY
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {"scenes": []}
    return found


def summary(records: Sequence[Record]) -> list[dict[str, Any]]:
    """Rows of the report's table: a model and an error, its median, 95th percentile and largest size over the scenes."""
    rows = []
    for model in MODELS:
        for error in ERRORS:
            sizes = [
                abs(errors[error])
                for r in records
                if (errors := r.get("models", {}).get(model, {})).get(error) is not None and r["status"] == ANSWERED
            ]
            if sizes:
                found = (model, error, len(sizes), *np.percentile(sizes, [50, 95]), max(sizes))
                rows.append(dict(zip(SUMS, found, strict=True)))
    return rows
