"""Comparison of low-order models with the 3D reference: errors of contact loads, and the uncertainty of the reference.

A scene with one nut or bearing row is compared as a whole. Of several nuts or rows on one shaft, each is compared
separately, with the force and moment that the model computes for it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from rollbench.compare import files
from rollbench.compare.errors import InputError
from rollbench.compare.measure import error_percent, load_error, load_scale_of_check_errors
from rollbench.compare.models.loading import solve_with_scaled_loads, with_scaled_loads
from rollbench.compare.models.model import Model, ModelOptions
from rollbench.compare.models.registry import MODELS, run_model
from rollbench.compare.printed import printed_entry
from rollbench.compare.quantities import json_number
from rollbench.compare.reference.convergence import pooled_grid_uncertainty
from rollbench.compare.reference.estimate import FITTED, Reference, largest_uncertainty_percent, reference_from_runs
from rollbench.compare.reference.levels import LEVELS
from rollbench.compare.reference.store import Run, load_stored_run, measuring_conditions, path_of_bodies, shipped_store
from rollbench.compare.reference.tasks import Solvable, ball_slices_by_set
from rollbench.compare.scenes.catalogue import names_of_scenes_with_role
from rollbench.lowfi.statics.nominal import count_nominal_contacts, nominal_scene
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import SIDES, Scene

#: Names of the scenes whose runs of the 3D reference are included with rollbench.
REFERENCED = names_of_scenes_with_role("referenced")

#: Definition of the error that is compared with the limit (`measure.load_scale_of_check_errors`), as text.
RULE = "in per cent of the contact's own load, or of the mean load if its own load is below a tenth of the mean"

#: For each scene of Lin's thesis, the keys of its printed errors (largest, RMS) and of its printed load ratio; empty: none.
PRINTED = {
    "lin-case1": ("case1_max_error", "case1_rms_error", "case1_ratio"),
    "lin-case2": ("case2_max_error", "case2_rms_error", ""),
}


def models_shown_for_scene(scene: Scene | Assembly) -> list[Model]:
    """Return the models that ``rollbench compare`` shows by default and that cover a scene.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row, or with several on one shaft.

    Returns
    -------
    list of Model
        The models.
    """
    compared = [m for m in MODELS.values() if m.compared]
    if isinstance(scene, Scene):
        return [m for m in compared if m.covers_scene(scene)]
    return [m for m in compared if callable(m.solve_assembly_or_reason)]


def path_of_condensed_bodies(scene: Scene, reference: Reference, stores: Sequence[Path] | None) -> Path | None:
    """Return the path of the file with the condensed stiffness of screw and nut by the finest 3D run, if it is stored.

    ``reference``: 3D reference of the scene; ``stores``: folders with its runs; None: the included one. None if
    no folder has the file, or if the user gave the reference as a file.
    """
    if reference.stated:
        return None
    for store in (shipped_store(),) if stores is None else stores:
        path = path_of_bodies(store, scene, reference.best)
        if path.exists():
            return path
    return None


def comparison_options(model: Model, scene: Scene, reference: Reference, stores: Sequence[Path] | None) -> ModelOptions:
    """Return the options with which a low-order model is solved for its comparison with the 3D reference.

    The model "condensed" gets the stiffness of screw and nut by the finest run of the reference.

    Parameters
    ----------
    model
        The model.
    scene
        Scene with one nut or bearing row.
    reference
        Reference of the scene.
    stores
        Folders with runs of the 3D reference; None: those included with rollbench.

    Returns
    -------
    ModelOptions
        The options.

    Raises
    ------
    InputError
        If the model is "condensed" and no folder has the stiffness of screw and nut by the finest run.
    """
    if model.name != "condensed":
        return ModelOptions(estimate_beam_mesh_error=False)
    path = path_of_condensed_bodies(scene, reference, stores)
    if path is None:
        allowed = f"condensed only with stored condensed bodies (3D reference, mesh level {reference.best.level})"
        advice = "run mesh-study with `fresh=True`, which computes and stores them"
        raise InputError(scene.name, "model", '"condensed"', allowed, advice)
    return ModelOptions(estimate_beam_mesh_error=False, condensed_bodies_file=path)


@dataclass(frozen=True)
class ComparisonRow:
    """Value of one quantity (such as one contact load) by a model and by the 3D reference: a row of ``compare --json``."""

    #: Name of the scene.
    scene: str
    #: Name of the compared quantity, such as "contact angle".
    quantity: str
    #: Number of the ball, from 1; None for a quantity of the whole screw.
    ball: int | None
    #: Flank of the contact: SL, SR, NL, NR; None for a quantity of the whole screw.
    side: str | None
    #: Unit of the quantity's values.
    unit: str
    #: Value that the scene's publication prints; None if it prints none.
    printed: float | None
    #: Name of the model.
    model: str
    #: Value of the quantity by the model.
    value: float | None
    #: Value of the quantity by the 3D reference.
    reference: float | None
    #: Uncertainty of the value by the 3D reference, in the unit of the value; None: not known.
    reference_error: float | None
    #: Error of the model against the 3D reference in per cent; None: not defined.
    error_percent: float | None
    #: Computing time of the model or 3D run [s].
    seconds: float | None
    #: Program version and machine with which the time was measured; empty: measured by the running program.
    measured_with: str = ""

    def as_json(self) -> dict[str, Any]:
        """Return the fields of this row by name as JSON values; nan and infinity become None."""
        return {k: None if isinstance(v, float) and not np.isfinite(v) else v for k, v in asdict(self).items()}


#: Function that returns a row of a comparison: `_row_of_quantity`, of which the first two arguments are already given.
RowOf = Callable[..., ComparisonRow]


@dataclass(frozen=True)
class ContactSolution:
    """Contact loads, contact angles and displacements of a scene, by a low-order model or by a run of the 3D reference."""

    #: Name of the model or of the 3D run.
    model: str
    #: Contact loads of n balls on the flanks SL, SR, NL and NR, (n, 4) [N].
    load: Array
    #: Contact angles of n balls on the flanks SL, SR, NL and NR, (n, 4) [deg].
    angle: Array
    #: Axial positions at which the displacement of the screw is given, (k,) [m].
    stations: Array
    #: Displacement (x, y, z) of the screw's axis at the axial positions ``stations``, (k, 3) [m].
    line: Array
    #: Computing time of the model or 3D run [s]; None: not measured.
    seconds: float | None
    #: Program version and machine with which the time was measured; empty: measured by the running program.
    measured: str = ""
    #: Largest pressure of each contact, (n, 4) [Pa]; None: the model gives none, so it is computed from the loads by Hertz.
    pressure: Array | None = None


def solution_from_result(result: StaticResult, seconds: float | None = None) -> ContactSolution:
    """Return the contact loads and displacements of a low-order model's result in the form used for comparisons.

    Parameters
    ----------
    result
        Result of the model.
    seconds
        Computing time [s]; None: not measured.

    Returns
    -------
    ContactSolution
        Loads, angles in degrees, and displacements of the screw's axis.
    """
    line = result.centreline[:, :3]
    angle = np.degrees(result.contact_angle)
    return ContactSolution(result.model, result.load, angle, result.centreline_z, line, seconds, pressure=result.pressure)


def solution_from_run(run: Run, name: str) -> ContactSolution:
    """Return the contact loads and displacements of a stored 3D run in the form used for comparisons.

    The computing time includes meshing all parts and condensing their stiffness.

    Parameters
    ----------
    run
        The run.
    name
        Name of the run in tables.

    Returns
    -------
    ContactSolution
        Loads, angles in degrees, and displacements of the screw's axis.
    """
    line, seconds = run.centreline, run.setup_seconds + run.solve_seconds
    measured = "" if run.measured == measuring_conditions() else str(run.measured)
    return ContactSolution(name, run.load, run.angle, line[:, 0], line[:, 1:], seconds, measured)


def solutions_of_reference_runs(reference: Reference, source_mesh_run: Run | None) -> list[ContactSolution]:
    """Return the contact loads and displacements of every run of the 3D reference, from the coarsest mesh to the finest.

    ``source_mesh_run``: run on the mesh of Lin's thesis, which comes first; None if there is none. The list is empty for a
    reference that the user gave as a file.
    """
    if reference.stated:
        return []
    out = [solution_from_run(run, f"3D level {run.level}") for run in reference.runs]
    if source_mesh_run is not None:
        out.insert(0, solution_from_run(source_mesh_run, "3D source mesh"))
    return out


def comparison_rows(scene: Scene, solution: ContactSolution, reference: Reference) -> list[ComparisonRow]:
    """Compare a model's results with the 3D reference: loads, contact angles, displacements, load ratio, errors.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row.
    solution
        Loads and displacements by a model or a run of the 3D reference.
    reference
        3D reference of the scene.

    Returns
    -------
    list of ComparisonRow
        A row for each quantity.
    """
    row = partial(_row_of_quantity, scene, solution)
    return [
        *_contact_comparison_rows(row, solution, reference),
        *_axis_displacement_rows(row, solution, reference),
        *_error_rows(row, scene, solution, reference),
    ]


def _row_of_quantity(
    scene: Scene,
    solution: ContactSolution,
    quantity: str,
    unit: str,
    values: tuple[float, float],
    uncertainty: float | None,
    error: float | None,
    contact: tuple[int | None, str | None] = (None, None),
    printed: float | None = None,
) -> ComparisonRow:
    """Return the row that compares one quantity by a model with its value by the 3D reference.

    ``solution``: results of the model; ``quantity``: name of the quantity; ``values``: its values by model and reference in
    ``unit``; ``uncertainty``: uncertainty of the reference in this unit; ``error``: error of the model [%]; ``contact``:
    number of the ball and name of its flank, both None for a quantity of the whole screw; ``printed``: value that the
    scene's publication prints; None: none.
    """
    compared, measured = (*values, uncertainty, error, solution.seconds), solution.measured
    return ComparisonRow(scene.name, quantity, *contact, unit, printed, solution.model, *compared, measured_with=measured)


def mesh_uncertainties(reference: Reference, quantities_of_run: Callable[[Run], Array]) -> Array:
    """Return the uncertainty due to the mesh of similar quantities of a 3D reference, such as all its contact angles.

    All of them are assumed to converge with the same order.

    Parameters
    ----------
    reference
        The reference, with a run for each mesh level.
    quantities_of_run
        Function that returns the quantities of a run, for example all contact angles, in any shape.

    Returns
    -------
    Array
        Uncertainty of each quantity; nan with one level, or where a level lacks the quantity.
    """
    values = np.stack([quantities_of_run(run) for run in reference.runs])
    bars = np.full(values.shape[1:], np.nan)
    known = np.isfinite(values).all(axis=0)
    if known.any():
        bars[known] = pooled_grid_uncertainty(values[:, known], reference.sizes)
    return bars


def _contact_comparison_rows(make_row: RowOf, solution: ContactSolution, reference: Reference) -> Iterator[ComparisonRow]:
    """Yield the rows that compare load and contact angle of each contact that carries load by the model or the reference.

    ``make_row``: function that returns a row from quantity, values and errors; ``solution``: results of the model.
    """
    best, turns = reference.best, mesh_uncertainties(reference, lambda run: run.angle)
    for i, s in np.ndindex(solution.load.shape):
        value, ref = float(solution.load[i, s]), float(reference.load[i, s])
        if value == 0.0 and ref == 0.0:
            continue
        bar = float(reference.uncertainty[i, s])
        percent = float(error_percent(value, ref)) if ref > 0.0 else None
        yield make_row("load", "N", (value, ref), bar, percent, (i + 1, SIDES[s]))
        if value > 0.0 and ref > 0.0:
            angle, ref_angle = float(solution.angle[i, s]), float(best.angle[i, s])
            error, off = json_number(float(turns[i, s])), float(error_percent(angle, ref_angle))
            yield make_row("contact angle", "deg", (angle, ref_angle), error, off, (i + 1, SIDES[s]))


def _axis_displacement_rows(make_row: RowOf, solution: ContactSolution, reference: Reference) -> Iterator[ComparisonRow]:
    """Yield the rows that compare the displacement of the screw's axis at the axial positions where the reference gives it.

    ``make_row``: function that returns a row from quantity, values and errors; ``solution``: results of the model. Errors
    are in per cent of the largest displacement in the same direction. There are no rows if the model gives the displacement
    at one position only and the reference at several.
    """
    line = reference.best.centreline
    if solution.stations.size < min(2, len(line)):
        return
    for k, axis in enumerate("xyz"):
        largest = float(np.abs(line[:, 1 + k]).max(initial=0.0))
        values = np.interp(line[:, 0], solution.stations, solution.line[:, k])
        bars = mesh_uncertainties(reference, lambda run, k=k: 1e6 * run.centreline[:, 1 + k])  # type: ignore[misc]
        for z, value, ref, bar in zip(line[:, 0], values, line[:, 1 + k], bars, strict=True):
            name, off = f"centreline u{axis} at {1e3 * z:.4g} mm", float(error_percent(value, ref, largest))
            yield make_row(name, "um", (1e6 * float(value), 1e6 * float(ref)), json_number(bar), off)


def _error_rows(make_row: RowOf, scene: Scene, solution: ContactSolution, reference: Reference) -> Iterator[ComparisonRow]:
    """Yield the rows with largest error, RMS error and load ratio of a model, and their values printed in Lin's thesis.

    ``make_row``: function that returns a row from quantity, values and errors; ``solution``: results of the model.
    """
    e = load_error(solution.load, reference.load, reference.contacts)
    keys = PRINTED.get(scene.name, ("", "", ""))

    def value_printed_in_thesis(key: str) -> float | None:
        """Return the error or load ratio of Lin's model as printed in Lin's thesis; None for other models than "lin".

        ``key``: key of the number in the printed table lin-2.4.1; for an empty key, None is returned.
        """
        return printed_entry("lin-2.4.1", key).value if key and solution.model.startswith("lin") else None

    loaded = reference.load > 0.0
    bar = largest_uncertainty_percent(reference)
    own_bar = float(error_percent(reference.uncertainty[loaded], 0.0, reference.load[loaded]).max())
    for name, value, uncertain, key in (
        (f"largest error, of the mean load (ball {e.ball} {e.side})", e.max_percent, bar, ""),
        ("RMS error, of the mean load", e.rms_percent, bar, ""),
        ("largest error, of the own load", e.own_max_percent, own_bar, keys[0]),
        ("RMS error, of the own load", e.own_rms_percent, own_bar, keys[1]),
    ):
        yield make_row(name, "%", (value, 0.0), uncertain, value, printed=value_printed_in_thesis(key))
    ratio, ref_ratio = load_ratio(solution.load), load_ratio(reference.load)
    off = float(error_percent(ratio, ref_ratio)) if np.isfinite([ratio, ref_ratio]).all() else None
    name, uncertainty = "largest over smallest load, SL", load_ratio_uncertainty(reference)
    printed = value_printed_in_thesis(keys[2])
    yield make_row(name, "", (ratio, ref_ratio), uncertainty, off, printed=printed)


def load_ratio(load: Array) -> float:
    """Return the ratio of largest to smallest contact load on the screw's left flank; infinite if a ball carries no load.

    ``load``: contact loads (n, 4) [N]; column 0 is the left flank of the screw.
    """
    smallest = float(load[:, 0].min())
    return float(load[:, 0].max()) / smallest if smallest > 0.0 else float("inf")


def load_ratio_uncertainty(reference: Reference) -> float | None:
    """Return the uncertainty of `load_ratio` of a 3D reference due to its mesh; None if the ratio is infinite.

    The relative uncertainties of both loads are added, because the loads may err in opposite directions.
    """
    ratio = load_ratio(reference.load)
    if not np.isfinite(ratio):
        return None
    loads = reference.load[:, 0]
    ends = [int(loads.argmax()), int(loads.argmin())]
    return ratio * float(sum(reference.uncertainty[k, 0] / loads[k] for k in ends))


@dataclass(frozen=True)
class KnownExceedance:
    """Contact of a built-in scene where the load by the model "lin" has a known error above the limit, with the cause."""

    #: Name of the scene.
    scene: str
    #: Number of the ball, from 1.
    ball: int
    #: Flank: SL, SR, NL, NR.
    side: str
    #: Text on the cause of the error.
    cause: str


def known_exceedances() -> list[KnownExceedance]:
    """Read from a built-in file the contacts on which the load by the model "lin" has a known error above the limit."""
    return [KnownExceedance(**row) for row in files.read_shipped_toml("references/known_exceedances.toml").get("row", [])]


class ContactError(NamedTuple):
    """Error of a value on one contact, such as its load, against the reference, with the uncertainty of the reference."""

    #: Error [% of the contact's reference value, for small loads of that at the mean load; deg for contact angles].
    error: float
    #: Uncertainty of the reference on this contact, in the same unit; nan: not known.
    uncertainty: float
    #: Number of the ball, from 1.
    ball: int
    #: Flank: SL, SR, NL, NR.
    side: str

    def exceeds(self, limit: float) -> bool:
        """Return whether the magnitude of the error, less the uncertainty, exceeds a limit in the unit of the error."""
        return abs(self.error) - self.uncertainty > limit


def contact_load_errors(reference: Reference, load: Array) -> list[ContactError]:
    """Return the error of each contact load by a model against the reference, in the per cent of `rollbench check`.

    Contacts that are unloaded both by the model and in the reference are omitted.

    Parameters
    ----------
    reference
        Reference of the scene.
    load
        Contact loads of the model for n balls on 4 flanks, (n, 4) [N].

    Returns
    -------
    list of ContactError
        Error of each contact that carries load by the model or in the reference.
    """
    scales = load_scale_of_check_errors(reference.load, reference.mean)
    points = []
    for i, s in zip(*np.nonzero((reference.load > 0.0) | (load > 0.0)), strict=True):
        scale = float(scales[i, s])
        error = float(error_percent(load[i, s], reference.load[i, s], scale))
        bar = float(error_percent(reference.uncertainty[i, s], 0.0, scale))
        points.append(ContactError(error, bar, int(i) + 1, SIDES[int(s)]))
    return points


def scene_of_set(assembly: Assembly, index: int) -> Scene:
    """Return a nut or bearing row on a shaft as a separate scene, named after the assembly and the nut or row.

    ``index``: its number on the shaft, from 0. Raises ValueError for a row of rollers.
    """
    one = assembly.sets[index]
    if not isinstance(one.parts, Scene):
        raise ValueError(f"{one.name} has rollers: only a nut or bearing row with balls can be a scene of its own")
    return replace(one.parts, name=re.sub(r"[^\w.-]+", "-", f"{assembly.name}-{one.name}"))


@dataclass(frozen=True)
class SceneWithReference:
    """Nut or bearing (alone in its scene or one of several on a shaft) with its 3D reference or a user's reference."""

    #: Nut or bearing as a separate scene.
    scene: Scene
    #: Reference of the nut or bearing.
    reference: Reference
    #: Shaft with all nuts or bearings; None for a scene with a single one.
    assembly: Assembly | None = None
    #: Number of the nut or bearing on its shaft, from 0.
    index: int = 0

    @property
    def described_scene(self) -> Solvable:
        """Scene that the user described: the assembly if the shaft has several nuts or bearings."""
        return self.scene if self.assembly is None else self.assembly

    @property
    def set_name(self) -> str:
        """Name of the nut or bearing on its shaft; empty if the scene has a single one."""
        return "" if self.assembly is None else self.assembly.sets[self.index].name


def stored_references(
    scene: Solvable, stores: Sequence[Path] | None, levels: Sequence[int] = tuple(LEVELS), run_count: int = FITTED
) -> list[SceneWithReference]:
    """Return the stored 3D reference of each nut or bearing of a scene, formed from the stored runs on the finest meshes.

    Parameters
    ----------
    scene
        Scene with one nut or bearing or several.
    stores
        Folders with runs of the 3D reference; None: those included with rollbench.
    levels
        Mesh levels whose runs may be used.
    run_count
        Number of runs, counted from the finest, from which the uncertainty is estimated.

    Returns
    -------
    list of SceneWithReference
        Reference of each nut or bearing; empty if no run is stored.
    """
    runs = tuple(run for level in levels if (run := load_stored_run(scene, level, stores=stores)) is not None)
    return references_from_runs(scene, runs[-run_count:]) if runs else []


def references_from_runs(scene: Solvable, runs: tuple[Run, ...]) -> list[SceneWithReference]:
    """Return the 3D reference of each nut or bearing of a scene from its ``runs`` on mesh levels, sorted coarse to fine."""
    if isinstance(scene, Scene):
        reference = reference_from_runs(scene.name, scene, runs, contacts=count_nominal_contacts(scene))
        return [SceneWithReference(scene, reference)]
    out = []
    for k, rows in enumerate(ball_slices_by_set(scene)):
        name, parts = f"{scene.name}, {scene.sets[k].name}", scene_of_set(scene, k)
        of_set = tuple(replace(r, load=r.load[rows], angle=r.angle[rows], frozen=r.frozen[rows]) for r in runs)
        reference = reference_from_runs(name, parts, of_set, contacts=loaded_contact_counts(scene)[k])
        out.append(SceneWithReference(parts, reference, scene, k))
    return out


@lru_cache(maxsize=64)
def loaded_contact_counts(assembly: Assembly) -> tuple[int, ...]:
    """Return how many ball contacts of each nut or bearing carry load if the parts have preload but no geometric errors.

    The loads are computed by the model "lin". The number is 0 for rollers, and for all if there is no equilibrium.
    """
    sets = tuple(replace(s, parts=nominal_scene(s.parts)) if isinstance(s.parts, Scene) else s for s in assembly.sets)
    result = run_model(replace(assembly, sets=sets), "lin")
    balls = [s.balls if result.converged else None for s in result.sets]
    return tuple(0 if b is None else int(np.count_nonzero(b.load > 0.0)) for b in balls)


@lru_cache(maxsize=16)
def solve_loaded_and_unloaded(assembly: Assembly, model: str) -> tuple[AxisResult, AxisResult, float]:
    """Solve a shaft with several nuts or bearings by the model ``model`` under its loads and without them.

    Returns the result under the loads, the result without them, and the computing time of the first [s]. The most
    recent results are cached.
    """
    start, options = perf_counter(), ModelOptions()
    result = run_model(assembly, model, options)
    seconds = perf_counter() - start
    return result, run_model(with_scaled_loads(assembly, 0.0), model, options), seconds


def solve_nut_or_bearing(
    one: SceneWithReference, model: Model, stores: Sequence[Path] | None
) -> tuple[StaticResult, StaticResult, float] | str:
    """Solve a nut or bearing by a low-order model, under the loads of its scene or shaft and without them.

    The computing time does not include elastic bodies that are cached from an earlier solution of the same geometry.

    Parameters
    ----------
    one
        The nut or bearing, and its reference.
    model
        The model.
    stores
        Folders with runs of the 3D reference; None: those included with rollbench.

    Returns
    -------
    tuple or str
        Result under the loads, result without them, and computing time of the first [s]; or the reason why the shaft has no
        equilibrium.

    Raises
    ------
    InputError
        If the model covers only scenes with one nut or bearing, or needs condensed bodies and no folder has them.
    """
    if one.assembly is None:
        options, start = comparison_options(model, one.scene, one.reference, stores), perf_counter()
        result = run_model(one.scene, model.name, options)
        seconds = perf_counter() - start
        return result, solve_with_scaled_loads(one.scene, 0.0, model.name, options), seconds
    on_shaft, unloaded, seconds = solve_loaded_and_unloaded(one.assembly, model.name)
    if not on_shaft.converged:
        return on_shaft.status
    balls, idle = (x.sets[one.index].balls if x.converged else None for x in (on_shaft, unloaded))
    assert balls is not None, "a scene with a reference has balls"
    balls, idle = (replace(x, model=model.name) for x in (balls, balls.with_nan_answers() if idle is None else idle))
    return balls, idle, seconds
