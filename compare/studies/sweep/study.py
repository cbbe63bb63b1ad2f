"""The command ``rollbench sweep``."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rollbench.compare.files import replace_file, write_figure
from rollbench.compare.models.registry import DEFAULT, default_model
from rollbench.compare.reference.jobs import Engine
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.studies.sweep import run as sweeping
from rollbench.compare.studies.sweep.design import Method
from rollbench.compare.studies.sweep.keys import read_vary
from rollbench.compare.studies.sweep.run import Sweep
from rollbench.compare.studies.sweep.store import Record
from rollbench.compare.studies.sweep.summary import converged, summary
from rollbench.meshes.axis import Assembly


def sweep_of(
    scene: str, vary: Sequence[str], samples: int, method: Method, seed: int, model: str, outputs: Sequence[str] = ()
) -> Sweep:
    """The sweep of a shipped scene by name, or of a scene file, by the default model where none is named; outputs: those
    that are computed, all unless given.

    Raises InputError for what cannot be read.
    """
    found = catalogue.any_scene(scene)
    if scene in catalogue.scene_names():
        text, origin = catalogue.scene_text(scene), f"{scene}.toml"
    else:
        text, origin = scene_file.read_text(scene), scene
    model = model or (default_model(found) if isinstance(found, Assembly) else DEFAULT)
    return Sweep(text, origin, read_vary(vary), samples, method, seed, model, tuple(outputs))


def solve_sweep(sweep: Sweep, out: Path, engine: Engine, step: Callable[[str], None]) -> dict[str, Any]:
    """Solve what is missing, write the summary into the folder, return it. Raises InputError."""
    records = sweeping.run_samples(sweep, out, engine, step)
    found = summary(sweep, records)
    write(sweep, records, found, out)
    return found


def write(sweep: Sweep, records: Mapping[int, Record], found: Mapping[str, Any], out: Path) -> None:
    """Write samples.csv, summary.json and the figures into the folder."""
    from rollbench.compare.studies.sweep.figures import figures

    replace_file(out / "samples.csv", samples_csv(sweep, records))
    replace_file(out / "summary.json", json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    for figure in figures("sweep", sweep.keys, found, converged(records)):
        write_figure(out / f"{figure.name}.svg", figure)


def samples_csv(sweep: Sweep, records: Mapping[int, Record]) -> str:
    """One row a sample in order: number, values, status or reason, the outputs that are kept."""
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(["sample", *(v.key for v in sweep.keys), "status", *sweep.wanted, "at"])
    for n in sorted(records):
        row = records[n]
        kept = ["" if row.get(k) is None else row[k] for k in (*sweep.wanted, "at")]
        writer.writerow([n, *row["values"], row["status"], *kept])
    return text.getvalue()


def library(
    scene: str,
    vary: Sequence[str],
    samples: int,
    method: Method,
    model: str,
    seed: int,
    out: Path,
    outputs: Sequence[str],
    step: Callable[[str], None],
) -> dict[str, Any]:
    """JSON-ready summary of a sweep, which is written to the folder; step: takes lines of progress. Raises InputError."""
    return solve_sweep(sweep_of(scene, vary, samples, method, seed, model, outputs), out, Engine(), step)
