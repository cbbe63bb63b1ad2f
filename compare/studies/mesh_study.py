"""Mesh study of the 3D reference (``rollbench mesh-study``): loads and displacements level by level."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.errors import ArgumentError
from rollbench.compare.measure import error_percent, load_error
from rollbench.compare.models.comparison import Referenced, referenced
from rollbench.compare.models.modelling import base_run
from rollbench.compare.reference.convergence import observe, pool
from rollbench.compare.reference.estimate import FITTED, Reference, reference_of
from rollbench.compare.reference.grid_parts import parts, read_experience
from rollbench.compare.reference.jobs import Engine, all_variants, ensure, plan
from rollbench.compare.reference.levels import ADVISED, LEVELS
from rollbench.compare.reference.store import Run, load_run, measuring_conditions, shipped_store
from rollbench.compare.reference.tasks import Solvable, Task
from rollbench.compare.reference.variants import VARIANTS
from rollbench.compare.results.comparison import named, unconverged
from rollbench.lowfi.statics.nominal import nominal_contacts
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import SIDES, Scene

Take = partial[float]

#: A level is worth its time if its uncertainty is at most this share of that of the level before.
CLEARLY = 0.8

#: Why a contact's load has no order.
SCATTERS = "no order: contact loads scatter from mesh to mesh"


def _extreme_load(side: int, sign: float, run: Run) -> float:
    return float(sign * (sign * run.load[:, side]).max())


def _ball_load(ball: int, side: int, run: Run) -> float:
    return float(run.load[ball, side])


def _centreline_displacement(station: int, axis: int, run: Run) -> float:
    """Return the displacement at one of the stations that all levels share [um]."""
    return float(1e6 * run.centreline[station, 1 + axis])


def study_quantities(run: Run) -> list[tuple[str, str, Take]]:
    """Return the quantities of a mesh study: name, unit, function that takes it from a run."""
    out: list[tuple[str, str, Take]] = []
    for s, side in enumerate(SIDES):
        if (run.load[:, s] > 0.0).any():
            out += [
                (f"largest load, {side}", "N", partial(_extreme_load, s, 1.0)),
                (f"smallest load, {side}", "N", partial(_extreme_load, s, -1.0)),
            ]
            out += [(f"load of ball {i + 1}, {side}", "N", partial(_ball_load, i, s)) for i in range(len(run.load))]
    for k in sorted({0, len(run.centreline) // 2}):
        for axis, name in enumerate("xyz"):
            z = 1e3 * run.centreline[k, 0]
            out.append((f"centreline u{name} at {z:.4g} mm", "um", partial(_centreline_displacement, k, axis)))
    return out


def reference_from_stored_runs(
    scene: Scene, stores: Sequence[Path] | None, levels: Sequence[int] = tuple(LEVELS)
) -> Reference | None:
    """Return the reference of all stored runs on some levels; None without any.

    Parameters
    ----------
    scene
        Scene with one set.
    stores
        Folders with runs; None: those of the package.
    levels
        Mesh levels.
    """
    runs = tuple(r for k in levels if (r := load_run(scene, k, stores=stores)) is not None)
    return reference_of(scene.name, scene, runs, contacts=nominal_contacts(scene)) if runs else None


def level_rows(reference: Reference) -> list[dict[str, Any]]:
    """Return a row for each level, coarsest first.

    Parameters
    ----------
    reference
        The reference.

    Returns
    -------
    list of dict
        Cell size over that of the finest level, unknowns of the equivalent single mesh, seconds without cached parts and
        the conditions of their measurement, largest difference of a contact load from the finest level, and
        `load_uncertainty_percent` [% of the mean load].
    """
    return [
        {
            "level": run.level,
            "cell_size": size / reference.sizes[-1],
            "unknowns": run.unknowns,
            "seconds": run.setup_seconds + run.solve_seconds,
            "measured_with": str(run.measured),
            "difference_percent": load_error(run.load, reference.load, reference.contacts).max_percent,
            "enough_for_percent": load_uncertainty_percent(reference, k),
        }
        for k, (run, size) in enumerate(zip(reference.runs, reference.sizes, strict=True))
    ]


def load_uncertainty_percent(reference: Reference, k: int) -> float:
    """Return the uncertainty of the contact loads by run ``k`` and the coarser runs [% of the mean load].

    RMS over the contacts; that of the first run alone is from experience with other scenes.
    """
    loads = {run.level: run.load for run in reference.runs[max(0, k + 1 - FITTED) : k + 1]}
    return parts(loads, read_experience(shipped_store())).bar


def accuracy_sentence(reference: Reference) -> str:
    """Return a sentence on the accuracy of each level, and on levels that are not worth their time.

    Percentages are rounded up. Times are given if all are of one measuring run.
    """
    stamps = {run.measured for run in reference.runs}
    steps, idle = list[tuple[str, float]](), list[int]()
    for row in level_rows(reference):
        good, time = row["enough_for_percent"], f" ({row['seconds']:.0f} s)" if len(stamps) == 1 else ""
        if steps and good > CLEARLY * steps[-1][1]:
            idle.append(row["level"])
            continue
        text = f"level {row['level']}{' with those before it' if steps else ''} for {_rounded_up(good)} %"
        steps.append((f"{text}{'' if steps else ' of the mean contact load, by experience with other scenes'}{time}", good))
    (first, _), *others = steps
    rest = "".join(f", {text}" for text, _ in others)
    tail = f" Hardly better than the one before: level {', '.join(map(str, idle))}." if idle else ""
    stamp = reference.best.measured
    older = f" Times measured with {stamp}." if stamps == {stamp} != {measuring_conditions()} else ""
    return f"Enough: {first}{rest}.{tail}{older}"


def _rounded_up(percent: float) -> str:
    """Return a percentage rounded up to two digits.

    Examples
    --------
    >>> _up(1.21), _up(0.031), _up(2.0)
    ('1.3', '0.031', '2')
    """
    unit = 10.0 ** (math.floor(math.log10(percent)) - 1) if percent > 0.0 else 1.0
    return f"{math.ceil(percent / unit - 1e-9) * unit:.2g}"


def study_table(scene: Scene, stores: Sequence[Path] | None, levels: Sequence[int] = tuple(LEVELS)) -> list[dict[str, Any]]:
    """Return the table of a mesh study.

    Contact loads, extremes included, have the uncertainty of their contact on the finest level, and no order; displacements
    that of their order of convergence, or with two levels that of all displacements together.

    Parameters
    ----------
    scene
        Scene with one set.
    stores
        Folders with runs; None: those of the package.
    levels
        Mesh levels.

    Returns
    -------
    list of dict
        For each quantity that is not fixed at zero: value on each level, order, extrapolated value, grid uncertainty, why
        it has an order or none; modelling uncertainty (root of squares over the varied choices) and the effect of choices
        that belong to the scene.
    """
    reference = reference_from_stored_runs(scene, stores, levels)
    if reference is None:
        return []
    coarsest = min(LEVELS)
    base = base_run(scene, coarsest, stores)
    others = [v for v, variant in VARIANTS.items() if v != "base" and not variant.refined]
    return quantity_table(
        reference, base, {v: r for v in others if (r := load_run(scene, coarsest, v, stores)) is not None}
    )


def quantity_table(reference: Reference, base: Run | None, changed: Mapping[str, Run]) -> list[dict[str, Any]]:
    """Return the table that `study_table` describes, from a reference and its runs.

    Parameters
    ----------
    reference
        The reference.
    base
        Run with which variants of modelling choices are compared; None: without these.
    changed
        Run of each variant.
    """
    runs, table = reference.runs, []
    shown = [(name, unit, take) for name, unit, take in study_quantities(runs[-1]) if any(take(r) for r in runs)]
    lines = [take for _, _, take in shown if take.func is _centreline_displacement]
    of_two: dict[Take, float] = {}
    if len(runs) == 2 and lines:  # each alone may agree by chance
        of_two = dict(zip(lines, pool([[take(r) for take in lines] for r in runs], reference.sizes).tolist(), strict=True))
    for name, unit, take in shown:
        values = [take(r) for r in runs]
        row: dict[str, Any] = {"quantity": name, "unit": unit}
        row |= {f"level {r.level}": v for r, v in zip(runs, values, strict=True)}
        if len(runs) >= 2:
            contact = _contact_of_quantity(take, runs[-1])
            observed = observe(values, reference.sizes) if contact is None else None
            bar = of_two.get(take, observed.uncertainty) if observed else float(reference.uncertainty[contact])
            row |= {
                "order": observed and observed.order,
                "extrapolated": observed and observed.extrapolated,
                "uncertainty": bar,
                "uncertainty_percent": _percent_of(bar, values[-1]),
                "kind": observed.text if observed else SCATTERS,
            }
        if base is not None and changed:
            moves = {v: abs(take(r) - take(base)) for v, r in changed.items()}
            row["modelling_spread"] = _root_of_squares(moves)
            row["scene_choices"] = max((m for v, m in moves.items() if VARIANTS[v].kind == "scene"), default=None)
        table.append(row)
    return table


def _contact_of_quantity(take: Take, finest: Run) -> tuple[int, int] | None:
    """Return ball and flank of the contact whose load the quantity gives on the finest level.

    None if it is not a contact load.
    """
    if take.func is _ball_load:
        return take.args[0], take.args[1]
    if take.func is not _extreme_load:
        return None
    side, sign = take.args
    return int((sign * finest.load[:, side]).argmax()), side


def _percent_of(value: float | None, of: float) -> float | None:
    """Return ``value`` in per cent of ``of``; None without a value, or if only ``of`` is zero."""
    if value is None or (of == 0.0 and value != 0.0):
        return None
    return float(error_percent(value, 0.0, of))


def _root_of_squares(moves: Mapping[str, float]) -> float | None:
    """Return the root of summed squares over modelling choices, by the largest variant of each; None without any."""
    by_choice: dict[str, float] = {}
    for name, move in moves.items():
        variant = VARIANTS[name]
        if variant.kind == "modelling":
            by_choice[variant.choice] = max(move, by_choice.get(variant.choice, 0.0))
    return float(np.linalg.norm(list(by_choice.values()))) if by_choice else None


def chosen_levels(count: int | None) -> tuple[int, ...]:
    """Return the levels of a mesh study: `ADVISED`, or 1 to ``count``; InputError if ``count`` is out of range."""
    if count is None:
        return ADVISED
    if not 1 <= count <= len(LEVELS):
        raise ArgumentError("levels", str(count), f"1 to {len(LEVELS)}", "three levels give an order")
    return tuple(range(1, count + 1))


def table_of_reference(one: Referenced, stores: Sequence[Path], levels: Sequence[int]) -> list[dict[str, Any]]:
    """Return the table of a mesh study; of one of several sets without the effect of modelling choices."""
    return study_table(one.scene, stores, levels) if one.of is None else quantity_table(one.found, None, {})


def compute_study(
    scenes: Sequence[Solvable],
    levels: Sequence[int],
    stores: Sequence[Path],
    engine: Engine,
    step: Callable[[str], None],
    *,
    spread: bool = False,
    source: bool = False,
    fresh: bool = False,
) -> list[Referenced]:
    """Compute references of scenes from runs on ``levels``; new runs are stored in the first store.

    Parameters
    ----------
    scenes
        Scenes with one load case each.
    levels
        Mesh levels.
    stores
        Folders with runs.
    engine
        Where runs are computed.
    step
        Called with lines of progress.
    spread
        Whether modelling choices are varied.
    source
        Whether the source's mesh is added.
    fresh
        Whether stored runs are computed again.

    Returns
    -------
    list of Referenced
        Reference of each set.

    Raises
    ------
    InputError
        For ``spread`` of several sets on one shaft; as Refusal if no run of a scene converged.
    """
    tasks = plan(scenes, levels, source=source)
    several = next((s.name for s in scenes if isinstance(s, Assembly)), None) if spread else None
    if several is not None:
        raise ArgumentError("spread", f"with {several}", "scenes of one set", "leave it out")
    if spread:
        tasks += [t for s in scenes for t in plan([s], (), all_variants())]

    def first(task: Task) -> None:
        """Say what the coarsest level found while finer ones are computed."""
        for scene in task.scenes if task.level == min(LEVELS) and not task.variant else ():
            for one in referenced(scene, stores[:1], (task.level,)):
                table = terminal_rows(table_of_reference(one, stores[:1], (task.level,)))
                values = (f"{row['quantity']} {row[f'level {task.level}']:.4g} {row['unit']}" for row in table)
                step(f"{one.found.scene}, by level {task.level} alone: {'; '.join(values)}")

    failed = ensure(tasks, stores[0], engine, step, stores[1:], fresh=fresh, stored=first)
    references = []
    for scene in scenes:
        sets = referenced(scene, stores, tuple(levels), fitted=len(levels))
        if not sets:
            raise unconverged(scene.name, failed)
        references += sets
    return references


def terminal_rows(table: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the table for the terminal: without rows of single balls and uncertainty in per cent."""
    return [
        {k: v for k, v in row.items() if k not in ("uncertainty_percent", "kind")}
        for row in table
        if "load of ball" not in row["quantity"]
    ]


def mesh_study_for_library(
    target: Solvable, levels: int | None, step: Callable[[str], None], *, spread: bool, store: Path
) -> tuple[dict[str, Any], str, tuple[str, ...]]:
    """Run a mesh study for `rollbench.mesh_study`.

    Parameters
    ----------
    target
        Scene with one set or several.
    levels
        Number of levels; None: `ADVISED`.
    step
        Called with lines of progress.
    spread
        Whether modelling choices are varied.
    store
        Folder that takes new runs.

    Returns
    -------
    dict
        JSON values.
    str
        Key of the table to show.
    tuple of str
        Closing lines.
    """
    from rollbench.meshes.cache import default_root

    stores, wanted = (store, shipped_store()), chosen_levels(levels)
    references = compute_study([target], wanted, stores, Engine(cache=default_root()), step, spread=spread)
    results = [
        {"scene": target.name, "levels": level_rows(x.found), "quantities": table_of_reference(x, stores, wanted)}
        | named(x)
        for x in references
    ]
    lines = tuple(accuracy_sentence(one.found) for one in references)
    if isinstance(target, Scene):
        return results[0], "levels", lines
    return {"scene": target.name, "sets": results}, "sets", lines
