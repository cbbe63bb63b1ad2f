"""Tapered rollers of a scene in 3D on several mesh levels, compared with low-order laws (``rollbench mesh-study``).

Each kind of roller of a scene is pressed between its races with the largest load that a roller of this kind carries in the
scene, with half of it and with a quarter. The 3D model is `rollbench.hifi.contact.roller`. The low-order laws are the slice
model that every solution uses (`rollbench.lowfi.rollers`), and the load-deflection law of ISO/TS 16281.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from rollbench.compare.errors import ArgumentError, SceneNotCoveredError
from rollbench.compare.files import replace_file
from rollbench.compare.measure import error_percent
from rollbench.compare.models.registry import run_model
from rollbench.compare.reference import store as run_store
from rollbench.compare.reference.convergence import Convergence, grid_convergence
from rollbench.compare.results.mesh_study import MeshLevel, MeshQuantity, MeshStudy
from rollbench.compare.scenes.duty_cycle import Described, DutyCycle
from rollbench.compare.studies.run_times import utc_date_today
from rollbench.lowfi import rollers
from rollbench.lowfi.hertz import contact_modulus
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.parts import MakerRating
from rollbench.meshes.record_keys import digest_of_values

#: Version of the 3D roller model in the names of stored runs; raise it when the mechanics change.
SCHEMA = 1
#: Loads over the largest load on a roller of the kind; pressures are stored for the first load only.
SHARES = (1.0, 0.5, 0.25)
#: Mesh levels.
LEVELS = (1, 2, 3)
#: Constant c of a steel roller between both races, Q = c L^(8/9) delta^(10/9), with the load Q in N, effective length L and
#: approach delta in mm (ISO/TS 16281).
NORM = 35948.0
#: Names of the races, in the order of lists over them.
RACES = ("outer", "inner")
#: Low-order laws with which the 3D values are compared: their names in results, and in words.
LAWS = {"low_order": "slices of the roller", "norm": "the spring law of ISO/TS 16281", "line_contact": "Hertz line contact"}


@dataclass(frozen=True)
class RollerRun:
    """Stored 3D solution of one roller on one mesh level, in SI units; lists over the races have the outer race first."""

    #: Mesh level.
    level: int
    #: Number of cells across half the width of the zone in which contact is possible.
    across: int
    #: Number of cells of the meshes of roller and races.
    cells: int
    #: Number of degrees of freedom of all meshes.
    unknowns: int
    #: Forces that press the roller between its races, largest first [N].
    load: list[float]
    #: Approach of the races under each force of ``load`` [m].
    approach: list[float]
    #: Stiffness of the roller between its races under each force of ``load`` [N/m].
    stiffness: list[float]
    #: Load per length in the middle of the roller, for each force and race [N/m].
    middle_line_load: list[list[float]]
    #: Largest pressure in the middle of the roller on each race, under the largest force [Pa].
    middle_pressure: list[float]
    #: Largest pressure on each race under the largest force [Pa]; for a straight roller it lies at the ends.
    largest_pressure: list[float]
    #: Positions along the roller at which line load and pressure are stored [m].
    along: list[float]
    #: Load per length on each race at each position along the roller, under the largest force [N/m].
    line_load: list[list[float]]
    #: Largest pressure across the contact on each race at each position along the roller, under the largest force [Pa].
    along_pressure: list[list[float]]
    #: Positions across the contact, in the cross-section with the roller's mean diameter, at which pressure is stored [m].
    across_place: list[float]
    #: Pressure on each race at each position across the contact, under the largest force [Pa].
    across_pressure: list[list[float]]
    #: Largest difference between a force of ``load`` and the integral of the contact pressure, over this force.
    imbalance: float
    #: Wall-clock time of the solution [s].
    seconds: float
    #: Processor time of the solution [s].
    cpu_seconds: float
    #: Versions of the programs by name of the program.
    versions: dict[str, str]
    #: Digest (hash value) of the source files of the program that solved the roller.
    sources: str
    #: Machine on which the roller was solved.
    machine: str
    #: Date of the solution.
    date: str


@dataclass(frozen=True)
class RollerKindWithLoad:
    """One kind of roller among the bearings of a shaft, with the largest load on a roller of this kind."""

    #: Bearing row of the roller; fields that do not affect one roller between its races have their default values.
    roller_row: RollerRow
    #: Names of the bearing rows that have this kind of roller.
    bearing_names: tuple[str, ...]
    #: Largest load on a roller of this kind in the scene, rounded to four digits [N].
    largest_load: float


def has_rollers(scene: Described) -> bool:
    """Return whether a scene, or the first load case of a duty cycle, is a shaft with roller bearings."""
    one = scene.cases[0].scene if isinstance(scene, DutyCycle) else scene
    return isinstance(one, Assembly) and any(isinstance(s.parts, RollerRow) for s in one.sets)


def roller_kinds_with_largest_load(assembly: Assembly) -> list[RollerKindWithLoad]:
    """Return the kinds of rollers on a shaft, each with the largest load on a roller of this kind; empty without rollers.

    Raises SceneNotCoveredError if the shaft has no equilibrium, or if no roller of a kind carries load.
    """
    without: dict[str, Any] = dict.fromkeys(("end_radius", "rib_height", "rib_friction", "torque_factor"))
    without |= {"rating": MakerRating()}  # no effect in 3D, like the others
    rows = {s.name: replace(s.parts, phase=0.0, **without) for s in assembly.sets if isinstance(s.parts, RollerRow)}
    if not rows:
        return []
    result = run_model(assembly)
    if not result.converged:
        raise SceneNotCoveredError(
            assembly.name, "3D roller", f"the scene has no equilibrium: {result.status}", "see the result of `solve`"
        )
    loads = {s.of.name: float(s.loads.max()) for s in result.sets if s.of.name in rows}
    out = []
    for row in dict.fromkeys(rows.values()):
        names = tuple(name for name, of in rows.items() if of == row)
        load = float(f"{max(loads[name] for name in names):.4g}")
        if load <= 0.0:
            raise SceneNotCoveredError(assembly.name, ", ".join(names), "carries no load", "give the scene a load")
        out.append(RollerKindWithLoad(row, names, load))
    return out


def roller_run_file_name(roller: RollerKindWithLoad, level: int) -> str:
    """Return the name of the JSON file that stores the 3D solution of a roller on a mesh level."""
    key = digest_of_values("roller", SCHEMA, replace(roller.roller_row, slices=1), roller.largest_load, SHARES)[:16]
    return f"roller-level{level}-{key}.json"


def stored_roller_run(roller: RollerKindWithLoad, level: int, stores: Sequence[Path]) -> RollerRun | None:
    """Return the stored 3D solution of a roller on a mesh level, from the first folder that has it; None without one."""
    for store in stores:
        try:
            return RollerRun(**run_store.read_checked_data(store / roller_run_file_name(roller, level)))
        except (OSError, ValueError, TypeError):
            continue
    return None


def load_or_compute_roller_run(
    roller: RollerKindWithLoad, level: int, stores: Sequence[Path], *, fresh: bool = False
) -> RollerRun:
    """Return the 3D solution of a roller on a mesh level: a stored one, else a new one, which is saved in the first folder.

    ``level``: mesh level; ``stores``: folders of solutions; ``fresh``: whether a stored solution is computed again.

    Raises
    ------
    SceneNotCoveredError
        If the roller is straight with sharp ends, or the contact becomes wider than the 3D model allows.
    """
    if not fresh and (known := stored_roller_run(roller, level, stores)) is not None:
        return known
    from rollbench.hifi.contact import roller as hifi

    try:
        bodies = hifi.condense_roller(roller.roller_row, hifi.LEVELS[level], roller.largest_load)
        states = [hifi.press_roller_between_races(bodies, share * roller.largest_load) for share in SHARES]
    except hifi.RollerError as error:
        raise SceneNotCoveredError(", ".join(roller.bearing_names), "3D roller", str(error), error.advice) from None
    first, now = states[0], run_store.measuring_conditions()
    run = RollerRun(
        level=level,
        across=hifi.LEVELS[level],
        cells=bodies.cell_count,
        unknowns=bodies.degree_of_freedom_count,
        load=[s.race_force for s in states],
        approach=[s.approach for s in states],
        stiffness=[s.stiffness for s in states],
        middle_line_load=[s.line_load_at_middle.tolist() for s in states],
        middle_pressure=first.largest_pressure_at_middle.tolist(),
        largest_pressure=first.pressures.max(axis=(1, 2)).tolist(),
        along=bodies.positions_along.tolist(),
        line_load=first.line_loads.tolist(),
        along_pressure=first.pressures.max(axis=2).tolist(),
        across_place=bodies.positions_across.tolist(),
        across_pressure=first.pressures[:, len(bodies.positions_along) // 2].tolist(),
        imbalance=max(s.load_imbalance for s in states),
        seconds=bodies.elapsed_seconds + sum(s.elapsed_seconds for s in states),
        cpu_seconds=bodies.cpu_seconds + sum(s.cpu_seconds for s in states),
        versions=run_store.program_versions() | {"rollbench": now.version},
        sources=now.sources,
        machine=now.machine,
        date=utc_date_today(),
    )
    replace_file(stores[0] / roller_run_file_name(roller, level), run_store.run_text_with_checksum(asdict(run)))
    return run


def approach_and_stiffness_by_laws(row: RollerRow, load: float) -> dict[str, tuple[float, float]]:
    """Return approach [m] and stiffness [N/m] of a roller pressed between its races, by the name of the low-order law.

    The laws are the slice model, which every low-order solution uses, and the spring of ISO/TS 16281 for steel.

    ``row``: bearing row of the roller; ``load``: force that presses it between the races [N].
    """
    crown = rollers.circular_crown_profile(row.crown)
    sliced = rollers.TaperedRow(rollers.tapered_bearing_of_row(row), row.slices, crown)
    tilt = np.sin(row.cup_angle)
    deflection = sliced.deflection(load * row.count * tilt)
    norm = 1e-3 * (load / (NORM * (1e3 * row.length) ** (8.0 / 9.0))) ** 0.9
    stiffness = sliced.stiffness(deflection) / (row.count * tilt**2)
    return {"low_order": (float(deflection * tilt), float(stiffness)), "norm": (norm, load / (0.9 * norm))}


def line_contact_pressures(row: RollerRow, line_loads: Sequence[float]) -> list[float]:
    """Return Hertz's largest line-contact pressure [Pa] in the middle of a roller on the outer and on the inner race.

    ``row``: bearing row of the roller; ``line_loads``: load per length on each of the races [N/m].
    """
    bearing = rollers.tapered_bearing_of_row(row)
    roller, cone, cup = (float(r) for r in bearing.curvature_radii())
    modulus = contact_modulus(bearing.young, bearing.poisson, bearing.young, bearing.poisson)
    curved = (1.0 / roller - 1.0 / cup, 1.0 / roller + 1.0 / cone)
    return [
        float(rollers.line_contact_pressure(q, rollers.line_contact_half_width(q, k, modulus)))
        for q, k in zip(line_loads, curved, strict=True)
    ]


def roller_quantities(roller: RollerKindWithLoad, runs: Sequence[RollerRun]) -> list[MeshQuantity]:
    """Return each quantity of a roller: its 3D value on every mesh level, and the errors of low-order laws.

    Parameters
    ----------
    roller
        Kind of roller with its load.
    runs
        Runs of this roller, coarsest first.
    """
    rows, levels = list[MeshQuantity](), tuple(run.level for run in runs)

    def add_row(name: str, unit: str, scale: float, found_in_3d: Sequence[float], **low: float) -> None:
        """Add one quantity.

        ``name`` and ``unit``: name and unit of the quantity; ``scale``: factor from SI units to this unit;
        ``found_in_3d``: its value in each 3D solution in SI units; ``low``: values by low-order laws in SI units.
        """
        values = tuple(scale * value for value in found_in_3d)
        found = roller_quantity_convergence(values, runs)
        observed = found.credible_order, found.extrapolated_value, found.uncertainty
        by_laws = {law: scale * low[law] if law in low else None for law in LAWS}
        rows.append(MeshQuantity(name, unit, levels, values, *observed, by_laws=by_laws))

    for k, load in enumerate(runs[-1].load):
        low, at = approach_and_stiffness_by_laws(roller.roller_row, load), f"under {load:.4g} N"
        for i, (name, unit, scale) in enumerate((("approach", "um", 1e6), ("stiffness", "N/um", 1e-6))):
            found = [getattr(r, name)[k] for r in runs]
            add_row(f"{name} {at}", unit, scale, found, **{law: of[i] for law, of in low.items()})
    hertz = line_contact_pressures(roller.roller_row, runs[-1].middle_line_load[0])
    for i, race in enumerate(RACES):
        add_row(f"middle line load, {race}", "N/mm", 1e-3, [r.middle_line_load[0][i] for r in runs])
        add_row(f"middle pressure, {race}", "MPa", 1e-6, [r.middle_pressure[i] for r in runs], line_contact=hertz[i])
        add_row(f"largest pressure, {race}", "MPa", 1e-6, [r.largest_pressure[i] for r in runs])
    return rows


def roller_rows_for_terminal(quantities: Sequence[MeshQuantity]) -> list[dict[str, Any]]:
    """Return the table of `roller_quantities` for the terminal: values, uncertainty, and errors of the laws."""
    return [
        {"quantity": x.name, "unit": x.unit, **x.on_levels, "uncertainty": x.uncertainty}
        | {f"{law}_error_percent": error for law, error in x.law_errors.items()}
        for x in quantities
    ]


def roller_quantity_convergence(values: Sequence[float], runs: Sequence[RollerRun]) -> Convergence:
    """Return order of convergence and mesh uncertainty of one quantity in a roller's 3D solutions.

    ``values``: values of the quantity in the 3D solutions ``runs``, coarsest mesh first.
    """
    return grid_convergence(values, [1.0 / run.across for run in runs])


def approach_uncertainty_percent(runs: Sequence[RollerRun]) -> float | None:
    """Return the mesh uncertainty of the approach of the races by the finest 3D solution [%]; None with a single solution.

    ``runs``: 3D solutions of a roller, coarsest mesh first.
    """
    bar = roller_quantity_convergence([run.approach[0] for run in runs], runs).uncertainty
    return None if bar is None else float(error_percent(bar, 0.0, runs[-1].approach[0]))


def roller_mesh_levels(runs: Sequence[RollerRun]) -> list[MeshLevel]:
    """Return each mesh level of a roller: cells, time, force balance, and accuracy of the approach.

    The accuracy is given as uncertainty and as difference from the finest level. ``runs``: 3D solutions of a roller,
    coarsest mesh first.
    """
    return [
        MeshLevel(
            level=run.level,
            cell_size=runs[-1].across / run.across,
            unknowns=run.unknowns,
            seconds=run.seconds,
            cells=run.cells,
            cpu_seconds=run.cpu_seconds,
            imbalance=100.0 * run.imbalance,
            difference=float(error_percent(run.approach[0], runs[-1].approach[0])),
            enough_for=approach_uncertainty_percent(runs[: k + 1]),
        )
        for k, run in enumerate(runs)
    ]


def compute_runs_of_roller_kinds(
    assembly: Assembly,
    count: int | None,
    stores: Sequence[Path],
    show_progress: Callable[[str], None],
    *,
    fresh: bool = False,
) -> list[tuple[RollerKindWithLoad, list[RollerRun]]]:
    """Return the 3D solutions of every kind of roller of a shaft on several mesh levels, coarsest first.

    ``count``: number of levels from the coarsest on, None for all; ``stores``: folders with solutions, the first of which
    takes new ones; ``show_progress``: function that is called with each line of progress; ``fresh``: whether stored
    solutions are computed again.

    Raises
    ------
    InputError
        For a number of levels out of range; its subclass SceneNotCoveredError if a roller cannot be solved.
    """
    count = len(LEVELS) if count is None else count
    if not 1 <= count <= len(LEVELS):
        advice = "take three levels, which give an order of convergence"
        raise ArgumentError("levels", str(count), f"1 to {len(LEVELS)} for rollers", advice)
    out = []
    for roller in roller_kinds_with_largest_load(assembly):
        runs = []
        for level in LEVELS[:count]:
            show_progress(f"{assembly.name}: a roller of {', '.join(roller.bearing_names)} on level {level}")
            runs.append(load_or_compute_roller_run(roller, level, stores, fresh=fresh))
        out.append((roller, runs))
    return out


def low_order_error_sentence(roller: RollerKindWithLoad, runs: Sequence[RollerRun]) -> str:
    """Return sentences on the errors of two low-order laws for a roller against its 3D solution on the finest mesh."""
    low, best = approach_and_stiffness_by_laws(roller.roller_row, roller.largest_load), runs[-1]
    off, norm = (float(error_percent(low[law][1], best.stiffness[0])) for law in ("low_order", "norm"))
    hertz = line_contact_pressures(roller.roller_row, best.middle_line_load[0])
    middle = max(abs(float(error_percent(p, h))) for p, h in zip(best.middle_pressure, hertz, strict=True))
    return (
        f"Errors of the stiffness of a roller under {roller.largest_load:.4g} N against 3D: slice model {off:+.1f} %, "
        f"spring of ISO/TS 16281 {norm:+.1f} %. Pressure in the middle within {middle:.2g} % of line contact."
    )


def roller_mesh_study(scene: str, roller: RollerKindWithLoad, runs: Sequence[RollerRun]) -> MeshStudy:
    """Return a roller's mesh study: mesh levels, quantities, and load profiles along the roller."""
    best = runs[-1]
    profile = [{"along_mm": 1e3 * x} for x in best.along]
    for k, row in enumerate(profile):
        row |= {f"line_load_{r}_N_per_mm": 1e-3 * of[k] for r, of in zip(RACES, best.line_load, strict=True)}
        row |= {f"pressure_{r}_MPa": 1e-6 * of[k] for r, of in zip(RACES, best.along_pressure, strict=True)}
    return MeshStudy(
        scene=scene,
        set=", ".join(roller.bearing_names),
        load=roller.largest_load,
        levels=tuple(roller_mesh_levels(runs)),
        quantities=tuple(roller_quantities(roller, runs)),
        profile=tuple(profile),
        notes=(low_order_error_sentence(roller, runs),),
    )


def run_roller_mesh_study(
    assembly: Assembly, levels: int | None, show_progress: Callable[[str], None], store: Path
) -> MeshStudy:
    """Run the mesh study of a shaft's rollers for `rollbench.mesh_study`.

    ``levels``: number of mesh levels, None for all; ``show_progress``: function that is called with each line of progress;
    ``store``: folder in which new 3D solutions are stored. The study has an entry for
    each kind of roller.
    """
    found = compute_runs_of_roller_kinds(assembly, levels, (store, run_store.shipped_store()), show_progress)
    each = [roller_mesh_study(assembly.name, one, runs) for one, runs in found]
    notes = tuple(line for one in each for line in one.notes)
    return MeshStudy(scene=assembly.name, sets={one.set: one for one in each}, notes=notes)
