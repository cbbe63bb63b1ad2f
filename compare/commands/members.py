"""``rollbench solve SCENE --members N``: bands and distributions of a scene with random errors."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from compare.commands.solve_output import number
from compare.commands.study import on_terminal
from compare.errors import InputError
from compare.models.members import KEPT, Array, Members, run_members, statistics
from compare.reference.jobs import Engine
from compare.scenes import catalogue
from compare.scenes.scene_file import whole
from meshes.axis import Assembly
from meshes.parts import SIDES, Scene

Row = Callable[[int, str, Array], None]


def run(
    name: str,
    model: str,
    count: int,
    *,
    csv_out: Path | None,
    seed: int | None,
    engine: Engine,
    json_out: bool,
    show: Callable[..., None],
    print_json: Callable[[Any], None],
) -> int:
    """Solve, write one CSV row a member as they come, print; 1 where none converged. Raises InputError."""
    described = catalogue.any_scene(name)
    if isinstance(described, Assembly):
        advice = 'take one by --member K, or many by: rollbench sweep SCENE --vary "sets[0].errors.seed=0:999"'
        raise InputError(described.name, "--members", str(count), "one set: bands are of its contacts", advice)
    scene = whole(described, name)
    if seed is not None:
        scene = _with_seed(scene, seed)
    with _rows(csv_out) as row:
        found = run_members(scene, model, count, engine, on_terminal, row)
    if json_out:
        print_json(as_json(found))
    else:
        show(*as_table(found), *([f"{csv_out}: one row a member"] if csv_out else []))
    return 0 if len(found.failed) < count else 1


def _with_seed(scene: Scene, seed: int) -> Scene:
    if not 0 <= seed < 2**63:
        raise InputError("command line", "--seed", str(seed), "0 to 9223372036854775807", "leave it out for the scene's")
    return replace(scene, errors=replace(scene.errors, seed=seed))


@contextmanager
def _rows(path: Path | None) -> Iterator[Row]:
    """What writes a member's row to the file, which takes its name only when it is whole."""
    if path is None:
        yield lambda *_: None
        return
    part = path.with_name(f".{path.name}.part")
    try:
        with part.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["member", "status", *KEPT])

            def row(member: int, status: str, kept: Array) -> None:
                writer.writerow([member, status, *("" if np.isnan(v) else repr(float(v)) for v in kept)])

            yield row
        os.replace(part, path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(str(path), "--csv", reason, "a file that can be written", "check the path") from None
    finally:
        part.unlink(missing_ok=True)


def as_json(found: Members) -> dict[str, Any]:
    """JSON-ready: statistics of what is kept, failures, bands of every contact that any member loads."""
    quantiles = {level: found.quantile(level) for level in (0.05, 0.5, 0.95)}
    return {
        "scene": found.scene.name,
        "model": found.model,
        "seed": found.scene.errors.seed,
        "members": len(found.kept),
        "converged": len(found.kept) - len(found.failed),
        "failed": [{"member": m, "status": s} for m, s in sorted(found.failed.items())],
        "statistics": {key: statistics(found.kept[:, k]) for k, key in enumerate(KEPT)},
        "band_resolution_N": number(found.width),
        "balls": [
            {
                "index": i + 1,
                "side": side,
                "without_random_errors_N": number(found.nominal[i, s]),
                "mean_N": number(found.mean[i, s]),
                "standard_deviation_N": number(found.deviation[i, s]),
                "smallest_N": number(found.smallest[i, s]),
                **{f"quantile_{level:g}_N": number(q[i, s]) for level, q in quantiles.items()},
                "largest_N": number(found.largest[i, s]),
                "loaded_share": number(found.loaded[i, s]),
            }
            for i in range(found.nominal.shape[0])
            for s, side in enumerate(SIDES)
            if found.largest[i, s] > 0.0
        ],
    }


def as_table(found: Members) -> list[Any]:
    """The same for the terminal."""
    from rich.table import Table

    data = as_json(found)
    parts: list[Any] = [
        f"{data['scene']}, model {data['model']}, seed {data['seed']}: {data['members']} members, {data['converged']} "
        f"converged, {1e3 * found.seconds / data['members']:.3g} ms a member"
    ]
    parts += [f"member {row['member']}: {row['status']}" for row in data["failed"][:5]]
    table = Table(title="members (in brackets: 95 % interval of the quantile)", title_justify="left")
    for heading in ("", "mean", "standard error", "deviation", "smallest", "5 %", "median", "95 %", "99 %", "largest"):
        table.add_column(heading, justify="right")
    for key, own in data["statistics"].items():
        if own is None:
            continue
        q = {row["level"]: f"{row['value']:.4g} ({row['low']:.4g} to {row['high']:.4g})" for row in own["quantiles"]}
        first = (f"{own[k]:.4g}" for k in ("mean", "standard_error", "standard_deviation", "smallest"))
        table.add_row(KEPT[key], *first, q[0.05], q[0.5], q[0.95], q[0.99], f"{own['largest']:.4g}")
    balls = Table(title=f"bands of the contact loads / N (to {found.width:.2g} N)", title_justify="left")
    keys = ("index", "side", "without_random_errors_N", "mean_N", "standard_deviation_N", "smallest_N", "quantile_0.05_N",
            "quantile_0.95_N", "largest_N", "loaded_share")  # fmt: skip
    for key in keys:
        balls.add_column(key.removesuffix("_N").replace("_", " "), justify="right")
    for row in data["balls"]:
        balls.add_row(*(v if isinstance(v, str) else f"{v:.4g}" for v in (row[k] for k in keys)))
    life = "life: ISO/TS 16281 equivalent loads, raceways equally strong; stiffness: tangent, by 0.1 % more load"
    return [*parts, balls, table, life]
