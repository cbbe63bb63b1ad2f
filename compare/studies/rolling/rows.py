"""Rolling balls: low-order models compared with the 3D model and with values of Lin's thesis, and the acceptance check.

This module also computes how ball-to-ball forces change with numerical settings and how they develop from rest, and the
rows of ``rollbench compare`` and ``rollbench mesh-study`` for scenes of rolling balls. 3D results are read from a store, or
computed and then stored.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache, partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from rollbench.compare.errors import ArgumentError
from rollbench.compare.gate.gate import GateCheck
from rollbench.compare.measure import error_percent
from rollbench.compare.models.study import SceneResultCache
from rollbench.compare.printed import printed_entry
from rollbench.compare.quantities import json_number
from rollbench.compare.reference.jobs import ComputingSettings
from rollbench.compare.reference.levels import FINITE, HALF_SPACE
from rollbench.compare.reference.store import shipped_store
from rollbench.compare.scenes.catalogue import shipped_scene_of_kind as shipped_case
from rollbench.compare.scenes.duty_cycle import FrictionScene
from rollbench.compare.studies.rolling import runs as rolling_runs
from rollbench.compare.studies.rolling.cases import prepare_rolling_case, rolling_of_kinds
from rollbench.hifi.rolling.balls import NEARLY_RIGID, RollingSettings, compute_motion_from_rest, solve_rolling
from rollbench.hifi.rolling.friction import PATH
from rollbench.hifi.rolling.kinematics import RollingBalls
from rollbench.reports.content import Row


def solve_low_order(scene: FrictionScene) -> tuple[dict[str, float], float, str]:
    """Solve a friction scene of rolling balls by the low-order model; return values by name, run time [s] and status.

    The values are forces, speeds and losses by names that end in the unit, such as "force 1-2 N". The scene is solved
    twice; the run time is that of the second solution, for which caches are filled by the first.
    """
    solver = rolling_of_kinds()[scene.kind][1]
    solver(scene)
    begin = perf_counter()
    values, status = solver(scene)
    return values, perf_counter() - begin, status


#: Safety factor on the differences between grids, as in grid convergence indices for three grids.
SAFETY = 1.25

#: Printed ball-to-ball force by scene: table of Lin's thesis, name of the value by its low-order model, name of the value
#: by ANSYS.
PRINTED = {
    "lin-pair-a": ("lin-3.5", "a_force_numerical", "a_force_ansys"),
    "lin-pair-b": ("lin-3.5", "b_force_numerical", "b_force_ansys"),
    "lin-screw-pair-a": ("lin-3.7", "force_a", "ansys_a"),
    "lin-screw-pair-a-inferred": ("lin-3.7", "force_a", "ansys_a"),
    "lin-screw-pair-b": ("lin-3.7", "force_b", "ansys_b"),
    "lin-screw-pair-b-inferred": ("lin-3.7", "force_b", "ansys_b"),
}

#: Scenes of the report and the acceptance check: those of Tables 3.5 and 3.7 of Lin's thesis, and the rotary ball of its
#: section 3.2.2.
PAIRS = tuple(PRINTED)

RINGS = ("lin-rotary-1", "lin-rotary-2", "lin-rotary-3")

#: Largest allowed error of the low-order model against the 3D model with the same contact loads [%].
LIMIT = 2.0

#: Values below this, in the unit of the quantity, count as round-off.
ROUND_OFF = 1e-6

#: Quantities that the acceptance check covers, and quantities for which the low-order model is known to exceed the limit,
#: with the cause.
GATED = ("force 1-2", "torque")

KNOWN = {
    ("lin-rotary-1", "torque"): "two contacts only: the contact that sticks between rigid bodies creeps by its elasticity, "
    "and both share the ball's spin"
}


@dataclass(frozen=True)
class RollingComparisonRow:
    """One quantity of a scene of rolling balls: by the low-order model, by the 3D model, and as printed in Lin's thesis."""

    #: Name of the scene.
    scene: str
    #: Name of the quantity, such as "force 1-2" for the force between balls 1 and 2.
    quantity: str
    #: Unit of the quantity, which is also that of all values below without a unit of their own.
    unit: str
    #: Value of the low-order model; None if this model does not compute the quantity.
    low: float | None
    #: Value of the 3D model.
    reference: float
    #: Uncertainty of the value of the 3D model.
    uncertainty: float
    #: Value that Lin's thesis prints for its low-order model; None without a printed value.
    printed: float | None
    #: Value that Lin's thesis prints for its finite elements (ANSYS); None without a printed value.
    printed_ansys: float | None
    #: Value of the 3D model with elastic bodies, if friction acts in the tangent plane instead of on the curved contact
    #: surface.
    flat: float
    #: Value of the 3D model with bodies that are rigid under tangential forces, and curved contact surfaces.
    rigid: float
    #: Error of the low-order model [% of the value of the 3D model]; None if that value is zero.
    error_percent: float | None
    #: Uncertainty of the value of the 3D model [% of this value]; None if the value is zero.
    uncertainty_percent: float | None
    #: Run time of the low-order model [s].
    low_seconds: float
    #: Run time of the 3D model [s].
    seconds: float
    #: Value of the 3D model with half-spaces, on the finest grid, to compare with ``reference`` if that is computed with
    #: finite bodies; None otherwise.
    half_space: float | None = None
    #: Origin of the scene's contact loads if Lin's thesis does not print them: "plain" if computed from its printed inputs,
    #: "inferred" if deduced from its printed results; None if the thesis prints the loads.
    load_state: str | None = None
    #: Version of rollbench and machine with which the run time of the 3D model was measured.
    measured_with: str = ""

    def as_json(self) -> dict[str, Any]:
        """Return all fields of this comparison as JSON values; None for infinity."""
        return {k: None if isinstance(v, float) and abs(v) == float("inf") else v for k, v in asdict(self).items()}


def split_name_and_unit(name: str) -> tuple[str, str]:
    """Return the quantity, then the unit, of a name such as "torque N mm"; raise KeyError without a known unit."""
    for unit in ("N mm", "rad/s", "mW", "N", "%"):
        if name.endswith(f" {unit}"):
            return name.removesuffix(f" {unit}"), unit
    raise KeyError(name)


#: Note on an effect that the uncertainty does not include, for scenes whose loads Lin's thesis does not print.
UNSTATED = ": +- is the scatter of the grids, without the uncertainty of the loads, which are not printed"


def interpretation_of_contact_loads(name: str) -> str | None:
    """Return the origin of contact loads that Lin's thesis does not print: "plain" or "inferred"; None if it prints them.

    ``name``: name of the scene. The loads are not printed for the cases of Table 3.7 of Lin's thesis, so that each has
    two scenes: with loads computed from the printed data ("plain"), and with loads inferred from printed results
    ("inferred"). None for scenes of other tables.
    """
    table = PRINTED.get(name.removesuffix(".toml"))
    if table is None or table[0] != "lin-3.7":
        return None
    return "inferred" if name.removesuffix(".toml").endswith("-inferred") else "plain"


def quantity_uncertainty(runs: Sequence[rolling_runs.RollingRun], name: str) -> float:
    """Return the uncertainty of a quantity by the 3D model of rolling, in the quantity's unit; infinite with one grid only.

    The uncertainty is `SAFETY` times the largest difference between the value on a coarser grid and the value on the finest
    grid, plus the quadrature error of the values for rigid bodies (difference between two numbers of points). ``runs``:
    solutions on several grids, from coarse to fine; ``name``: name of the quantity with its unit.
    """
    values = [r.values[name] for r in runs]
    if len(values) < 2:
        return float("inf")
    return SAFETY * max(abs(v - values[-1]) for v in values[:-1]) + runs[-1].limit_spread[name]


def compare_scene_with_rolling_runs(
    scene: FrictionScene, runs: Sequence[rolling_runs.RollingRun], half_space: rolling_runs.RollingRun | None = None
) -> list[RollingComparisonRow]:
    """Compare the low-order model of a scene with 3D solutions of rolling; return one row for each quantity.

    Parameters
    ----------
    scene
        Friction scene of rolling balls.
    runs
        Solutions by the 3D model from coarse to fine grid; the last one is the reference.
    half_space
        Solution with half-spaces on the finest grid if ``runs`` have finite bodies, else None. With finite bodies the
        uncertainty includes the effect of the settings with which they are modelled.
    """
    low, low_seconds, _ = solve_low_order(scene)
    finest = runs[-1]
    table = PRINTED.get(scene.name.removesuffix(".toml"))
    by_bodies = 0.0 if half_space is None else rolling_runs.largest_change_by_body_choice("linear" in scene.kind)
    out = []
    for name, value in finest.values.items():
        quantity, unit = split_name_and_unit(name)
        total_uncertainty = quantity_uncertainty(runs, name) + by_bodies * abs(value)
        printed = ansys = None
        if table is not None and quantity == "force 1-2":
            printed, ansys = (printed_entry(table[0], key).value for key in table[1:])
        error = float(error_percent(low[name], value)) if name in low else np.nan
        share = float(error_percent(value + total_uncertainty, value))
        if max(abs(value), abs(low.get(name, value))) < ROUND_OFF:  # both are round-off
            error, share = 0.0, np.nan
        out.append(
            RollingComparisonRow(
                scene=scene.name,
                quantity=quantity,
                unit=unit,
                low=low.get(name),
                reference=value,
                uncertainty=total_uncertainty,
                printed=printed,
                printed_ansys=ansys,
                flat=value + finest.flat[name] - finest.elastic[name],
                rigid=finest.limit[name],
                error_percent=error if np.isfinite(error) else None,
                uncertainty_percent=share if np.isfinite(share) else None,
                low_seconds=low_seconds,
                seconds=finest.seconds,
                half_space=None if half_space is None else half_space.values[name],
                load_state=interpretation_of_contact_loads(scene.name),
                measured_with=str(finest.measured),
            )
        )
    return out


def low_order_error_is_within_limit(row: RollingComparisonRow) -> bool:
    """Return whether the low-order model's error against the 3D model of rolling is at most `LIMIT`.

    The uncertainty of the 3D model, up to `LIMIT`, is first deducted from the error.
    """
    if row.error_percent is None:
        return row.low == row.reference or (row.low is not None and abs(row.low - row.reference) <= row.uncertainty + 1e-9)
    return abs(row.error_percent) - min(row.uncertainty_percent or 0.0, LIMIT) <= LIMIT


def compare_scene_with_stored_runs(
    name: str, stores: Sequence[Path], bodies: str = HALF_SPACE
) -> list[RollingComparisonRow]:
    """Compare the low-order model of a scene of the package with stored 3D solutions of rolling on all grids.

    There is one row for each quantity, and none if a solution is missing. ``name``: name of the scene; ``stores``:
    folders with solutions; ``bodies``: bodies of the 3D model, half spaces ("half-space") or finite.
    """
    scene = shipped_case(name, FrictionScene)
    found = [rolling_runs.load_rolling_run(scene, level, stores, bodies) for level in rolling_runs.LEVELS]
    runs = [run for run in found if run is not None and run.converged]
    half_space = None if bodies == HALF_SPACE else rolling_runs.load_rolling_run(scene, max(rolling_runs.LEVELS), stores)
    return compare_scene_with_rolling_runs(scene, runs, half_space) if len(runs) == len(rolling_runs.LEVELS) else []


# --- rows of the acceptance check: low-order models of rolling balls against the 3D model


def checks_of_rolling_balls(cache: SceneResultCache, max_error: float) -> list[GateCheck]:
    """Check ball-to-ball forces and torques of low-order models of rolling balls against stored 3D solutions.

    The checks are a part of ``rollbench check``. ``max_error``: largest allowed error [%]; the limit is this or `LIMIT`,
    whichever is smaller. A quantity whose error exceeds the limit passes if `KNOWN` lists it with the cause. A quantity
    that `KNOWN` lists although its error is within the limit fails.
    """
    out: list[GateCheck] = []
    stores = cache.reference_folders or (shipped_store(),)
    limit = min(LIMIT, max_error)
    for name in (*PAIRS, *RINGS):
        rows = [row for row in compare_scene_with_stored_runs(name, stores) if row.quantity in GATED]
        if not rows:
            text = f"no stored runs of the 3D model of rolling: run rollbench mesh-study {name}"
            out.append(GateCheck(f"{name}: 3D rolling", "3D rolling", None, None, None, limit, False, text))
        for row in rows:
            cause = KNOWN.get((name, row.quantity), "")
            passed = low_order_error_is_within_limit(row) != bool(cause)
            state = f", {row.load_state} load state" if row.load_state else ""
            known = f" (known: {cause})" if cause else ""
            label = f"{name}: {row.quantity} [{row.unit}] against 3D rolling{state}{known}"
            text = f"uncertainty of the 3D model {row.uncertainty:.2g} {row.unit}"
            out.append(GateCheck(label, "3D rolling", row.low, row.reference, row.error_percent, limit, passed, text))
    return out


#: Simulations from rest: duration [s], gap between the balls at the start [m], numbers of time steps (ten in section 3.3.5
#: of Lin's thesis).
DURATION, GAP, STEPS = 0.1, 1e-6, (10, 50, 100)


@dataclass(frozen=True)
class RunFromRest:
    """Motion of two balls of a linear bearing that start from rest, simulated in time steps by the 3D model of rolling."""

    #: Number of time steps.
    steps: int
    #: Times at the ends of the time steps [s].
    time: tuple[float, ...]
    #: Force between the balls at the end of each time step [N].
    force: tuple[float, ...]
    #: Speeds of both balls at the end of each time step [m/s].
    speed: tuple[tuple[float, ...], ...]
    #: Force between the balls in the steady solution on the same grid [N], to which ``force`` should converge.
    steady_force: float
    #: Processor time [s].
    seconds: float
    #: "converged", or the first time step that did not converge, with the reason.
    status: str


@lru_cache(maxsize=1)
def runs_from_rest() -> tuple[RunFromRest, ...]:
    """Simulate two balls of a linear bearing that start from rest, with each of the numbers of time steps in `STEPS`.

    The results are computed once in a process.
    """
    choices = RollingSettings(rolling_runs.SHAPE)
    scene = prepare_rolling_case(shipped_case("lin-pair-a", FrictionScene), choices).touching
    steady = float(solve_rolling(scene, choices).ball_to_ball_forces[0])
    out = []
    for count in STEPS:
        run = compute_motion_from_rest(scene, DURATION, count, GAP, choices)
        force = tuple(map(float, run.ball_to_ball_forces[:, 0]))
        speed = tuple(tuple(map(float, row)) for row in run.track_speeds)
        out.append(RunFromRest(count, tuple(map(float, run.times)), force, speed, steady, run.cpu_seconds, run.status))
    return tuple(out)


# --- change of ball-to-ball forces with numerical choices, compared with their stated uncertainty


#: A grid (cells along and across the groove) finer than those from which the uncertainty follows. Other sequences of slip
#: speeds, over the largest slip, by which Coulomb's law is smoothed (`hifi.rolling.friction`).
BEYOND = (30, 44)

PATHS = {"by threes": tuple(3.0**-k for k in range(14)), "two steps": (PATH[0], PATH[-1])}

FORCE = "force 1-2"


def force_changes_by_numerical_choices(
    stores: Sequence[Path], series: Sequence[RunFromRest], sizes: Mapping[str, rolling_runs.BodyValues]
) -> list[Row]:
    """Return how numerical settings of the 3D model of rolling change the ball-to-ball force of two scenes.

    Scenes without stored solutions are left out.

    Parameters
    ----------
    stores
        Folders with stored solutions.
    series
        Simulations of the linear bearing from rest, with several numbers of time steps.
    sizes
        Results with other settings of the finite bodies; empty: their effect is left out.
    """
    return [one for name in rolling_runs.SCENES for one in _force_changes_in_scene(name, stores, series, sizes)]


def _force_changes_in_scene(
    name: str, stores: Sequence[Path], series: Sequence[RunFromRest], sizes: Mapping[str, rolling_runs.BodyValues]
) -> Iterator[Row]:
    """Yield rows on how a scene's ball-to-ball force changes with finer grids and steps, other bodies, smoother friction.

    ``name``: name of the scene; the other arguments are those of `force_changes_by_numerical_choices`.
    """
    scene = shipped_case(name, FrictionScene)
    half, finite = (_force_uncertainty_percent(name, stores, *bodies) for bodies in ((), (FINITE,)))
    run = rolling_runs.load_rolling_run(scene, max(rolling_runs.LEVELS), stores)
    if run is None or half is None:
        return

    def row(choice: str, tried: str, change: float, uncertainty: float) -> Row:
        """Return the table row of a numerical setting: largest change of the force by other values, its uncertainty [%]."""
        return {
            "scene": name,
            "numerical_setting": choice,
            "setting_values": tried,
            "largest_force_change": change,
            "stated_force_uncertainty": uncertainty,
            "change_within_uncertainty": "within" if change <= uncertainty else "beyond",
        }

    key, case = f"{FORCE} N", prepare_rolling_case(scene, RollingSettings(rolling_runs.SHAPE)).touching
    near, elastic = (_solve_ball_to_ball_force(case, RollingSettings(BEYOND, share)) for share in (NEARLY_RIGID, 1.0))
    grid = _largest_error_percent([run.limit[key] + elastic - near], run.values[key])
    yield row("grid", f"{BEYOND[0]} x {BEYOND[1]} cells beyond {run.shape[0]} x {run.shape[1]}", grid, half)
    variants = rolling_runs.scenes_and_sizes_of_body_variants()
    finite_ones = [choice for choice, (scene_name, used) in variants.items() if scene_name == name and used is not None]
    values = [sizes[choice][key] for choice in finite_ones if choice in sizes]
    if values and finite is not None:
        tried = f"{len(values) - 1} other sizes, cells, kernels, patches"
        yield row("finite bodies", tried, _largest_error_percent(values[1:], values[0]), finite)
    if name == rolling_runs.LINEAR:
        tried = f"{', '.join(str(s.steps) for s in series)} steps from rest"
        ends = [s.force[-1] / s.steady_force if s.status == "converged" else np.nan for s in series]
        yield row("time step", tried, _largest_error_percent(ends, 1.0), half)
    settings = RollingSettings(rolling_runs.SHAPE)
    first, *others = (_solve_ball_to_ball_force(case, settings, path) for path in (PATH, *PATHS.values()))
    yield row("path of regularisation", ", ".join(PATHS), _largest_error_percent(others, first), half)


def _solve_ball_to_ball_force(scene: RollingBalls, choices: RollingSettings, path: tuple[float, ...] = PATH) -> float:
    """Solve a system of rolling balls in 3D; return the force between the first two balls [N].

    ``scene``: the system; ``choices``: grid and bodies; ``path``: slip speeds by which Coulomb's law is smoothed in
    successive solutions, divided by the largest slip. The result is nan if the solver does not converge.
    """
    found = solve_rolling(scene, choices, smoothing_ratios=path)
    return float(found.ball_to_ball_forces[0]) if found.converged else np.nan


def _largest_error_percent(values: Sequence[float], reference: float) -> float:
    """Return the largest absolute error of several values against a reference value, in % of the latter."""
    return float(np.max([abs(float(error_percent(value, reference))) for value in values]))


def _force_uncertainty_percent(name: str, stores: Sequence[Path], *bodies: str) -> float | None:
    """Return the uncertainty of the ball-to-ball force of a scene by the 3D model [%]; None without stored solutions.

    ``name``: name of the scene; ``stores``: folders with solutions; ``bodies``: bodies of the 3D model, as in
    `compare_scene_with_stored_runs`.
    """
    rows = compare_scene_with_stored_runs(name, stores, *bodies)
    return next((row.uncertainty_percent for row in rows if row.quantity == FORCE), None)


def rolling_comparison(
    scenes: Sequence[FrictionScene],
    levels: tuple[int, ...] | None,
    store: Path,
    engine: ComputingSettings,
    *,
    fresh: bool,
    bodies: str,
) -> list[RollingComparisonRow]:
    """Compare low-order models of rolling balls with the 3D model of rolling; return a row for each quantity of each scene.

    ``levels``: levels of the 3D model's grids, None for all; ``store``: folder for new 3D solutions; ``engine``: number
    of processes, or cluster, that compute them; ``fresh``: whether stored solutions are computed again; ``bodies``:
    bodies of the 3D model, a key of `runs.BODIES`. Raises InputError for an unknown level, and SceneNotCoveredError if
    a solution did not converge.
    """
    wanted = rolling_runs.check_rolling_levels(levels or tuple(rolling_runs.LEVELS))
    out: list[RollingComparisonRow] = []
    for scene in scenes:
        find = partial(rolling_runs.find_or_compute_rolling_runs, scene)
        found = find(wanted, store, engine, fresh=fresh, bodies=bodies)
        half_space = None if bodies == HALF_SPACE else find(wanted[-1:], store, ComputingSettings(), fresh=False)[0]
        out += compare_scene_with_rolling_runs(scene, found, half_space)
    return out


def rolling_mesh_study(
    scenes: Sequence[FrictionScene],
    levels: int | None,
    store: Path,
    engine: ComputingSettings,
    *,
    source: bool,
    fresh: bool,
    bodies: str,
) -> list[dict[str, Any]]:
    """Return table rows with every quantity of rolling balls on every grid of the 3D model, and the quantity's uncertainty.

    ``levels``: number of grids from the coarsest on, None for all; ``store``: folder for new solutions; ``engine``:
    number of processes, or cluster, that compute them; ``source``: whether a grid with the element size of Lin's thesis
    is added; ``fresh``: whether stored solutions are computed again; ``bodies``: bodies of the 3D model, a key of
    `runs.BODIES`. Raises InputError for a number of grids out of range, and SceneNotCoveredError if a solution did not
    converge.
    """
    levels = len(rolling_runs.LEVELS) if levels is None else levels
    if not 1 <= levels <= len(rolling_runs.LEVELS):
        advice = "take at least two levels: the uncertainty of the results comes from their differences between grids"
        raise ArgumentError("levels", str(levels), f"1 to {len(rolling_runs.LEVELS)}", advice)
    out: list[dict[str, Any]] = []
    for scene in scenes:
        coarse = [rolling_runs.SOURCE_LEVEL] if source and scene.kind in rolling_runs.SOURCE_SIZE else []
        wanted = [*coarse, *range(1, levels + 1)]
        found = rolling_runs.find_or_compute_rolling_runs(scene, wanted, store, engine, fresh=fresh, bodies=bodies)
        grids = [run for run in found if run.level != rolling_runs.SOURCE_LEVEL]
        for key in found[-1].values:
            bar = json_number(quantity_uncertainty(grids, key))
            out += [
                {
                    "scene": scene.name,
                    "load_state": interpretation_of_contact_loads(scene.name),
                    "quantity": key,
                    "level": "source" if run.level == rolling_runs.SOURCE_LEVEL else str(run.level),
                    "cells": f"{run.shape[0]} x {run.shape[1]}",
                    "value": run.values[key],
                    "grid_alone": run.elastic[key],
                    "elasticity": run.elastic[key] - run.near_rigid[key],
                    "rigid_limit": run.limit[key],
                    "energy_lost_percent": 100.0 * run.upwind,
                    "seconds": run.seconds,
                    "uncertainty": bar,
                }
                for run in found
            ]
    return out
