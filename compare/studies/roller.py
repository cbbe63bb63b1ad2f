"""Tapered rollers of a scene in 3D, level by level, and what low-order laws say of them (``rollbench mesh-study``).

Each different roller of a scene is pressed between its races with the largest load that a roller of its kind carries in the
scene, a half and a quarter of it. The 3D model is `rollbench.hifi.contact.roller`. Low-order laws: the slices that every
solve uses (`rollbench.lowfi.rollers`), and the spring of ISO/TS 16281.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

from rollbench.compare.errors import ArgumentError, Refusal
from rollbench.compare.files import replace_file
from rollbench.compare.measure import error_percent
from rollbench.compare.models.registry import run_model
from rollbench.compare.reference.convergence import Convergence, observe
from rollbench.compare.reference.store import measuring_conditions, sealed, shipped_store, unsealed, versions
from rollbench.compare.scenes.duty_cycle import Described, DutyCycle
from rollbench.lowfi.hertz import contact_modulus
from rollbench.lowfi.rollers import approach_of, circular_crown, half_width, pressure, slice_state, sliced, tapered
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.canonical import digest

#: Version of the mechanics; bump it when they change.
SCHEMA = 1
#: Loads over the largest one of the scene; the first has the pressures.
SHARES = (1.0, 0.5, 0.25)
#: Mesh levels.
LEVELS = (1, 2, 3)
#: Spring of a steel roller between both races, Q = c L^(8/9) delta^(10/9) in N and mm (ISO/TS 16281).
NORM = 35948.0
RACES = ("outer", "inner")
#: Columns that the terminal leaves out.
HIDDEN = ("order", "extrapolated", "low_order", "norm", "line_contact")


@dataclass(frozen=True)
class RollerRun:
    """Stored result of one roller on one mesh level; SI, races in the order outer, inner."""

    #: Mesh level.
    level: int
    #: Cells across half of the zone that may touch, of all meshes, and their degrees of freedom.
    across: int
    cells: int
    unknowns: int
    #: Loads, approaches, stiffnesses.
    load: list[float]
    approach: list[float]
    stiffness: list[float]
    #: Load per length in the middle for each load.
    middle_line_load: list[list[float]]
    #: Under the first load: pressure in the middle, and the largest one, which stands at the ends of a straight roller.
    middle_pressure: list[float]
    largest_pressure: list[float]
    #: Under the first load, along the roller: places, line loads and largest pressures across.
    along: list[float]
    line_load: list[list[float]]
    along_pressure: list[list[float]]
    #: Across the middle: places where the roller has its mean diameter, and pressures.
    across_place: list[float]
    across_pressure: list[list[float]]
    #: Largest difference of the sum of the pressures from a load, over the load.
    imbalance: float
    #: Wall and processor time.
    seconds: float
    cpu_seconds: float
    #: Versions of the programs, digest of the sources, machine and day.
    versions: dict[str, str]
    sources: str
    machine: str
    date: str


@dataclass(frozen=True)
class LoadedRoller:
    """A kind of roller of a scene, and its load."""

    #: Its row, without what does not matter to a roller between its races.
    row: RollerRow
    #: Sets that have it.
    sets: tuple[str, ...]
    #: Largest load of the scene on a roller of the kind, to four digits [N].
    load: float


def has_rollers(scene: Described) -> bool:
    """Whether a scene, or the first of its load cases, has rows of rollers."""
    one = scene.cases[0].scene if isinstance(scene, DutyCycle) else scene
    return isinstance(one, Assembly) and any(isinstance(s.parts, RollerRow) for s in one.sets)


def loaded_rollers(assembly: Assembly) -> list[LoadedRoller]:
    """Return the kinds of rollers of a scene with their largest loads; empty without rollers.

    Raises Refusal where the scene has no equilibrium, or loads no roller.
    """
    rows = {s.name: _without_irrelevant_fields(s.parts) for s in assembly.sets if isinstance(s.parts, RollerRow)}
    if not rows:
        return []
    result = run_model(assembly)
    if not result.converged:
        raise Refusal(assembly.name, "3D roller", f"the scene has no equilibrium: {result.status}", "see `solve`")
    loads = {s.of.name: float(s.loads.max()) for s in result.sets if s.of.name in rows}
    out = []
    for row in dict.fromkeys(rows.values()):
        names = tuple(name for name, of in rows.items() if of == row)
        load = float(f"{max(loads[name] for name in names):.4g}")
        if load <= 0.0:
            raise Refusal(assembly.name, ", ".join(names), "carries no load", "give the scene a load")
        out.append(LoadedRoller(row, names, load))
    return out


def _without_irrelevant_fields(row: RollerRow) -> RollerRow:
    """Return the row without the fields that do not affect the 3D roller, such as phase and rib."""
    return replace(row, phase=0.0, end_radius=None, rib_height=None, rib_friction=None, torque_factor=None)


def run_file_name(roller: LoadedRoller, level: int) -> str:
    """Return the name of the file of a run in a store."""
    key = digest("roller", SCHEMA, replace(roller.row, slices=1), roller.load, SHARES)[:16]
    return f"roller-level{level}-{key}.json"


def stored_run(roller: LoadedRoller, level: int, stores: Sequence[Path]) -> RollerRun | None:
    """Return the stored run of a roller on a mesh level, from the first store that has it; None without one."""
    for store in stores:
        try:
            return RollerRun(**unsealed(store / run_file_name(roller, level)))
        except (OSError, ValueError, TypeError):
            continue
    return None


def load_or_compute_run(roller: LoadedRoller, level: int, stores: Sequence[Path], *, fresh: bool = False) -> RollerRun:
    """Return the run of a roller on a mesh level: a stored one, else a new one, saved in the first store.

    Raises
    ------
    Refusal
        A straight roller with sharp ends, or a contact that leaves what the model describes.
    """
    if not fresh and (known := stored_run(roller, level, stores)) is not None:
        return known
    from rollbench.hifi.contact import roller as hifi

    try:
        bodies = hifi.condense(roller.row, hifi.LEVELS[level], roller.load)
        states = [hifi.press(bodies, share * roller.load) for share in SHARES]
    except hifi.RollerError as error:
        raise Refusal(", ".join(roller.sets), "3D roller", str(error), error.advice) from None
    first, now = states[0], measuring_conditions()
    run = RollerRun(
        level=level,
        across=hifi.LEVELS[level],
        cells=bodies.cells,
        unknowns=bodies.unknowns,
        load=[s.load for s in states],
        approach=[s.approach for s in states],
        stiffness=[s.stiffness for s in states],
        middle_line_load=[s.middle_line_load.tolist() for s in states],
        middle_pressure=first.middle_pressure.tolist(),
        largest_pressure=first.pressure.max(axis=(1, 2)).tolist(),
        along=bodies.along.tolist(),
        line_load=first.line_load.tolist(),
        along_pressure=first.pressure.max(axis=2).tolist(),
        across_place=bodies.across.tolist(),
        across_pressure=first.pressure[:, len(bodies.along) // 2].tolist(),
        imbalance=max(s.imbalance for s in states),
        seconds=bodies.seconds + sum(s.seconds for s in states),
        cpu_seconds=bodies.cpu_seconds + sum(s.cpu_seconds for s in states),
        versions=versions() | {"rollbench": now.version},
        sources=now.sources,
        machine=now.machine,
        date=datetime.now(UTC).date().isoformat(),
    )
    replace_file(stores[0] / run_file_name(roller, level), sealed(asdict(run)))
    return run


@dataclass(frozen=True)
class LowOrderStiffness:
    """Approach and stiffness of a roller under a load by low-order laws; SI."""

    #: Approach and stiffness of the slices' law, which every solve uses.
    approach: float
    stiffness: float
    #: The same of the spring of ISO/TS 16281, for steel.
    norm_approach: float
    norm_stiffness: float


def low_order_stiffness(row: RollerRow, load: float) -> LowOrderStiffness:
    """Return approach and stiffness by low-order laws of a roller that its races press with a load [N]."""
    roller = sliced(tapered(row), row.slices, circular_crown(row.crown))
    approach = approach_of(roller, load)
    norm = 1e-3 * (load / (NORM * (1e3 * row.length) ** (8.0 / 9.0))) ** 0.9
    return LowOrderStiffness(approach, slice_state(roller, approach).stiffness, norm, load / (0.9 * norm))


def line_contact_pressures(row: RollerRow, line_loads: Sequence[float]) -> list[float]:
    """Return Hertz's largest pressure [Pa] in mid-roller at outer and inner contact, from loads per length [N/m]."""
    bearing = tapered(row)
    roller, cone, cup = (float(r) for r in bearing.radii())
    modulus = contact_modulus(bearing.young, bearing.poisson, bearing.young, bearing.poisson)
    curved = (1.0 / roller - 1.0 / cup, 1.0 / roller + 1.0 / cone)
    return [float(pressure(q, half_width(q, k, modulus))) for q, k in zip(line_loads, curved, strict=True)]


def _value_at_load(name: str, k: int, run: RollerRun) -> float:
    """Return a field's value at load number ``k`` of a run."""
    return float(getattr(run, name)[k])


def _value_at_race(name: str, race: int, run: RollerRun) -> float:
    """Return a field's value at one race under the first load of a run."""
    return float(getattr(run, name)[0][race])


def quantity_rows(roller: LoadedRoller, runs: Sequence[RollerRun]) -> list[dict[str, Any]]:
    """Return a row for each quantity: its value on every level, uncertainty, low-order values and their errors [%].

    Parameters
    ----------
    roller
        The roller.
    runs
        Its runs, coarsest first.
    """
    rows = []

    def add(name: str, unit: str, scale: float, take: Callable[[RollerRun], float], **low: float) -> None:
        values = [scale * take(run) for run in runs]
        found = run_convergence(values, runs)
        row: dict[str, Any] = {"quantity": name, "unit": unit}
        row |= {f"level {run.level}": value for run, value in zip(runs, values, strict=True)}
        row |= {"order": found.order, "extrapolated": found.extrapolated, "uncertainty": found.uncertainty}
        for key in ("low_order", "norm", "line_contact"):
            value = low.get(key)
            row[key] = None if value is None else scale * value
            row[f"{key}_error_percent"] = None if value is None else float(error_percent(scale * value, values[-1]))
        rows.append(row)

    for k, load in enumerate(runs[-1].load):
        low = low_order_stiffness(roller.row, load)
        at = f"under {load:.4g} N"
        add(
            f"approach {at}",
            "um",
            1e6,
            partial(_value_at_load, "approach", k),
            low_order=low.approach,
            norm=low.norm_approach,
        )
        both = {"low_order": low.stiffness, "norm": low.norm_stiffness}
        add(f"stiffness {at}", "N/um", 1e-6, partial(_value_at_load, "stiffness", k), **both)
    hertz = line_contact_pressures(roller.row, runs[-1].middle_line_load[0])
    for i, race in enumerate(RACES):
        add(f"middle line load, {race}", "N/mm", 1e-3, partial(_value_at_race, "middle_line_load", i))
        add(f"middle pressure, {race}", "MPa", 1e-6, partial(_value_at_load, "middle_pressure", i), line_contact=hertz[i])
        add(f"largest pressure, {race}", "MPa", 1e-6, partial(_value_at_load, "largest_pressure", i))
    return rows


def terminal_rows(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return `quantity_rows` for the terminal, without the columns ``HIDDEN``."""
    return [{k: v for k, v in row.items() if k not in HIDDEN} for row in rows]


def run_convergence(values: Sequence[float], runs: Sequence[RollerRun]) -> Convergence:
    """Return the convergence of a quantity over runs on finer and finer meshes."""
    return observe(values, [1.0 / run.across for run in runs])


def approach_uncertainty_percent(runs: Sequence[RollerRun]) -> float | None:
    """Return the grid uncertainty of the finest run's approach [%]; None with a single run."""
    bar = run_convergence([run.approach[0] for run in runs], runs).uncertainty
    return None if bar is None else float(error_percent(bar, 0.0, runs[-1].approach[0]))


def level_rows(runs: Sequence[RollerRun]) -> list[dict[str, Any]]:
    """Return a row for each level: cells, time, the approach against the finest level, its uncertainty, balance."""
    return [
        {
            "level": run.level,
            "cell_size": runs[-1].across / run.across,
            "cells": run.cells,
            "unknowns": run.unknowns,
            "seconds": run.seconds,
            "cpu_seconds": run.cpu_seconds,
            "difference_percent": float(error_percent(run.approach[0], runs[-1].approach[0])),
            "enough_for_percent": approach_uncertainty_percent(runs[: k + 1]),
            "imbalance_percent": 100.0 * run.imbalance,
        }
        for k, run in enumerate(runs)
    ]


def study_rollers(
    assembly: Assembly, count: int | None, stores: Sequence[Path], step: Callable[[str], None], *, fresh: bool = False
) -> list[tuple[LoadedRoller, list[RollerRun]]]:
    """Return runs of every kind of roller of a scene on levels 1 to ``count``, all unless given.

    Raises
    ------
    InputError
        Other levels; as Refusal where a roller cannot be solved.
    """
    count = len(LEVELS) if count is None else count
    if not 1 <= count <= len(LEVELS):
        raise ArgumentError("levels", str(count), f"1 to {len(LEVELS)} of rollers", "three levels give an order")
    out = []
    for roller in loaded_rollers(assembly):
        runs = []
        for level in LEVELS[:count]:
            step(f"{assembly.name}: a roller of {', '.join(roller.sets)} on level {level}")
            runs.append(load_or_compute_run(roller, level, stores, fresh=fresh))
        out.append((roller, runs))
    return out


def low_order_sentence(roller: LoadedRoller, runs: Sequence[RollerRun]) -> str:
    """Return what the study says of the low-order law."""
    low, best = low_order_stiffness(roller.row, roller.load), runs[-1]
    off = float(error_percent(low.stiffness, best.stiffness[0]))
    norm = float(error_percent(low.norm_stiffness, best.stiffness[0]))
    hertz = line_contact_pressures(roller.row, best.middle_line_load[0])
    middle = max(abs(float(error_percent(p, h))) for p, h in zip(best.middle_pressure, hertz, strict=True))
    return (
        f"Stiffness of a roller under {roller.load:.4g} N against 3D: slices {off:+.1f} %, spring of ISO/TS 16281 "
        f"{norm:+.1f} %. Pressure in the middle within {middle:.2g} % of line contact. {best.cpu_seconds:.0f} s of "
        f"a processor on level {best.level}, measured with {best.versions['rollbench']}."
    )


def study_json(roller: LoadedRoller, runs: Sequence[RollerRun]) -> dict[str, Any]:
    """Return the JSON of a roller's study."""
    best = runs[-1]
    profile = [
        {"along_mm": 1e3 * x, **{f"line_load_{r}_N_per_mm": 1e-3 * best.line_load[i][k] for i, r in enumerate(RACES)}}
        | {f"pressure_{r}_MPa": 1e-6 * best.along_pressure[i][k] for i, r in enumerate(RACES)}
        for k, x in enumerate(best.along)
    ]
    return {
        "set": ", ".join(roller.sets),
        "load_N": roller.load,
        "levels": level_rows(runs),
        "quantities": quantity_rows(roller, runs),
        "profile": profile,
    }


def roller_study_for_library(
    assembly: Assembly, levels: int | None, step: Callable[[str], None], store: Path
) -> tuple[dict[str, Any], str, tuple[str, ...]]:
    """Return JSON, the key of the table to show, and closing lines for `rollbench.mesh_study`."""
    found = study_rollers(assembly, levels, (store, shipped_store()), step)
    sets = [{"scene": assembly.name} | study_json(one, runs) for one, runs in found]
    return {"scene": assembly.name, "sets": sets}, "sets", tuple(low_order_sentence(one, runs) for one, runs in found)
