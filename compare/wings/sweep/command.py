"""The command ``rollbench sweep``."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rollbench.compare.commands.printing import Answer, cell, on_terminal
from rollbench.compare.commands.tables import ruled
from rollbench.compare.models.registry import DEFAULT, default_model
from rollbench.compare.reference.jobs import Engine
from rollbench.compare.scenes import catalogue, scene_file
from rollbench.compare.wings.sweep import run as sweeping
from rollbench.compare.wings.sweep.design import Method
from rollbench.compare.wings.sweep.keys import Vary, read_vary
from rollbench.compare.wings.sweep.outputs import MAIN, OUTPUTS
from rollbench.compare.wings.sweep.run import Sweep
from rollbench.compare.wings.sweep.store import Record
from rollbench.compare.wings.sweep.summary import converged, summary
from rollbench.compare.writing import no_figure, replace_file, write_figure
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


def run_sweep(sweep: Sweep, out: Path, engine: Engine) -> Answer:
    """Solve what is missing and write the summary; exit code 1 where no sample converged. Raises InputError."""
    found = solve_sweep(sweep, out, engine, on_terminal)
    written = f"{out}: written: samples.csv, summary.json and {no_figure() or 'figures (SVG)'}"
    return Answer(found, [*terminal(sweep.keys, found), written], 0 if found["converged"] else 1)


def solve_sweep(sweep: Sweep, out: Path, engine: Engine, step: Callable[[str], None]) -> dict[str, Any]:
    """Solve what is missing, write the summary into the folder, return it. Raises InputError."""
    records = sweeping.run_samples(sweep, out, engine, step)
    found = summary(sweep, records)
    write(sweep, records, found, out)
    return found


def write(sweep: Sweep, records: Mapping[int, Record], found: Mapping[str, Any], out: Path) -> None:
    """Write samples.csv, summary.json and the figures into the folder."""
    from rollbench.compare.wings.sweep.figures import figures

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


def terminal(keys: Sequence[Vary], found: Mapping[str, Any]) -> list[Any]:
    """The summary for the terminal: counts, statistics, effects and indices of the largest load, worst cases."""
    parts: list[Any] = [f"{found['solved']} samples, {found['converged']} converged"]
    parts += [f"failed: {row['samples']} samples: {row['reason']}" for row in found["failures"][:5]]
    names = ("mean", "standard_error", "standard_deviation", "smallest", "quantile_0.05", "quantile_0.95", "largest")
    rows = ([OUTPUTS[name], *(cell(x and x[n], ".5g") for n in names)] for name, x in found["outputs"].items())
    parts.append(ruled("outputs", ["", *(n.replace("_", " ") for n in names)], rows))
    parts.append(_effects(keys, found))
    worst = ([str(row["sample"]), f"{row[MAIN]:.5g}", row["at"], *map(str, row["values"])] for row in found["worst"])
    return [*parts, ruled("worst samples", ["sample", OUTPUTS[MAIN], "at", *(v.name for v in keys)], worst)]


def _effects(keys: Sequence[Vary], found: Mapping[str, Any]) -> Any:
    indices = found["indices"].get("outputs", {}).get(MAIN)
    why = found["indices"].get("none", "the largest load does not change")
    title = "effect of each key on the largest contact load" + (f" ({why})" if indices is None else "")
    rows = []
    for vary in keys:
        means = [g["mean"] for g in found["main_effects"][vary.key]]
        cells = [f"{min(means):.5g}", f"{max(means):.5g}"] if means else ["–", "–"]
        cells += [_interval(indices[vary.key], kind) if indices is not None else "–" for kind in ("first", "total")]
        rows.append([vary.label, *cells])
    return ruled(title, ("key", "smallest mean / N", "largest mean / N", "first index", "total index"), rows)


def _interval(row: Mapping[str, float], kind: str) -> str:
    return f"{row[kind]:.3f} ({row[f'{kind}_low']:.3f} to {row[f'{kind}_high']:.3f})"


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
