"""Mesh study of the 3D reference (``rollbench mesh-study``): contact loads and displacements on each mesh level."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rollbench.compare.errors import ArgumentError
from rollbench.compare.measure import load_error
from rollbench.compare.models.comparison import SceneWithReference, stored_references
from rollbench.compare.models.modelling import run_without_changed_choices
from rollbench.compare.reference import estimate, jobs
from rollbench.compare.reference.convergence import grid_convergence, pooled_grid_uncertainty
from rollbench.compare.reference.levels import ADVISED, LEVELS, VARIANTS
from rollbench.compare.reference.store import Run, load_stored_run, shipped_store, shows_times_of
from rollbench.compare.reference.tasks import ReferenceTask, Solvable
from rollbench.compare.results.comparing import error_for_unconverged_reference
from rollbench.compare.results.mesh_study import MeshLevel, MeshQuantity, MeshStudy
from rollbench.lowfi.statics.nominal import count_nominal_contacts
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import SIDES, Scene


class StudiedQuantity(NamedTuple):
    """Quantity that a mesh study compares between the solutions of the 3D reference."""

    #: Name and unit.
    name: str
    unit: str
    #: Function that reads the value from a solution.
    value: Callable[[Run], float]
    #: Numbers of ball and flank, from 0, if it is the load of a contact on the finest level; None for a displacement.
    contact: tuple[int, int] | None


#: A mesh level is advised only if its mesh uncertainty is at most this share of that of the coarser level advised before.
CLEARLY = 0.8

#: Remark on contact loads, for which no order of convergence is given.
SCATTERS = "no order: contact loads scatter from mesh to mesh"


def studied_quantities(run: Run) -> Iterator[StudiedQuantity]:
    """Yield the quantities that a mesh study compares.

    ``run``: solution of the 3D reference on the finest level, which determines the balls, flanks and axial positions, and
    which contact has the largest or smallest load of a flank.
    """
    for s, side in enumerate(SIDES):
        if not (run.load[:, s] > 0.0).any():
            continue
        for word, sign in (("largest", 1.0), ("smallest", -1.0)):
            extreme = int((sign * run.load[:, s]).argmax()), s
            yield StudiedQuantity(f"{word} load, {side}", "N", partial(_extreme_flank_load, s, sign), extreme)
        for i in range(len(run.load)):
            name = f"load of ball {i + 1}, {side}"
            yield StudiedQuantity(name, "N", lambda of, at=(i, s): float(of.load[at]), (i, s))  # type: ignore[misc]
    for k in sorted({0, len(run.centreline) // 2}):
        for axis, name in enumerate("xyz", 1):
            of_axis = f"centreline u{name} at {1e3 * run.centreline[k, 0]:.4g} mm"
            at = k, axis
            yield StudiedQuantity(of_axis, "um", lambda of, at=at: float(1e6 * of.centreline[at]), None)  # type: ignore[misc]


def _extreme_flank_load(side: int, sign: float, run: Run) -> float:
    """Return the largest or smallest contact load on one flank by a solution of the 3D reference [N].

    ``side``: number of the flank, 0 to 3 for SL, SR, NL, NR (screw left and right, nut left and right); ``sign``: 1 for the
    largest load, -1 for the smallest; ``run``: the solution.
    """
    return float(sign * (sign * run.load[:, side]).max())


def reference_from_stored_runs(
    scene: Scene, stores: Sequence[Path] | None, levels: Sequence[int] = tuple(LEVELS)
) -> estimate.Reference | None:
    """Return the 3D reference of a scene with its uncertainty, from the stored solutions on several mesh levels.

    None if no solution is stored.

    Parameters
    ----------
    scene
        Scene of one nut or bearing.
    stores
        Folders with stored 3D solutions; None: those of the package.
    levels
        Mesh levels.
    """
    runs = tuple(r for k in levels if (r := load_stored_run(scene, k, stores=stores)) is not None)
    return estimate.reference_from_runs(scene.name, scene, runs, contacts=count_nominal_contacts(scene)) if runs else None


def mesh_levels_of_reference(reference: estimate.Reference) -> list[MeshLevel]:
    """Return size, time and accuracy of each mesh level, coarsest first.

    Parameters
    ----------
    reference
        3D reference with its solutions on several mesh levels.

    Returns
    -------
    list of MeshLevel
        For each mesh level: ratio of the cell size to that of the finest level; number of unknowns that one mesh of all
        bodies would have; seconds for set-up and solution without cached parts, with the conditions of their measurement;
        largest difference of a contact load from the finest level, and uncertainty by `load_uncertainty_up_to_run`, each in
        % of the mean load.
    """
    return [
        MeshLevel(
            level=run.level,
            cell_size=size / reference.sizes[-1],
            unknowns=run.unknowns,
            seconds=run.setup_seconds + run.solve_seconds,
            measured_with=str(run.measured),
            difference=load_error(run.load, reference.load, reference.contacts).max_percent,
            enough_for=load_uncertainty_up_to_run(reference, k),
        )
        for k, (run, size) in enumerate(zip(reference.runs, reference.sizes, strict=True))
    ]


def load_uncertainty_up_to_run(reference: estimate.Reference, run_index: int) -> float:
    """Estimate the mesh uncertainty of a run's contact loads as if there were no runs on finer meshes [% of the mean load].

    ``reference``: 3D reference with its runs; ``run_index``: number of the run from 0, coarsest mesh first. The uncertainty
    is the root mean square over the contacts. For the coarsest mesh it is the uncertainty of that mesh level on other
    scenes.
    """
    loads = {run.level: run.load for run in reference.runs[max(0, run_index + 1 - estimate.FITTED) : run_index + 1]}
    return estimate.mesh_uncertainty(loads, estimate.read_uncertainty_of_other_scenes(shipped_store())).uncertainty


def mesh_accuracy_sentence(reference: estimate.Reference) -> str:
    """Return a sentence on accuracy and time of each mesh level, and on levels hardly more accurate than the next coarser.

    Percentages are rounded up. Times are given if all are of this version.
    """
    timed = all(shows_times_of(run.measured.version) for run in reference.runs)
    steps, idle = list[tuple[str, float]](), list[int]()
    for row in mesh_levels_of_reference(reference):
        good, time = row.enough_for or 0.0, f" ({row.seconds:.0f} s)" if timed else ""
        if steps and good > CLEARLY * steps[-1][1]:
            idle.append(row.level)
            continue
        level = f"levels up to {row.level}" if steps else f"level {row.level}, estimated from other scenes"
        of = "" if steps else " of the mean load"
        steps.append((f"{_rounded_up_percent_text(good)} %{of} with {level}{time}", good))
    tail = f" Hardly more accurate than the level before: level {', '.join(map(str, idle))}." if idle else ""
    return f"Uncertainty of the contact loads from the mesh: {'; '.join(text for text, _ in steps)}.{tail}"


def _rounded_up_percent_text(percent: float) -> str:
    """Return a percentage as text, rounded up to two digits.

    Examples
    --------
    >>> _rounded_up_percent_text(1.21), _rounded_up_percent_text(0.031), _rounded_up_percent_text(2.0)
    ('1.3', '0.031', '2')
    """
    unit = 10.0 ** (math.floor(math.log10(percent)) - 1) if percent > 0.0 else 1.0
    return f"{math.ceil(percent / unit - 1e-9) * unit:.2g}"


def mesh_study_table_of_scene(
    scene: Scene, stores: Sequence[Path] | None, levels: Sequence[int] = tuple(LEVELS)
) -> list[MeshQuantity]:
    """Return the quantities of a mesh study of a scene: the value of each quantity on each mesh level, and its uncertainty.

    Contact loads have the uncertainty of their contact on the finest level and no order of convergence, because they
    scatter from mesh to mesh. The uncertainty of a displacement follows from its order of convergence; with two levels
    only, from the order of all displacements together.

    Parameters
    ----------
    scene
        Scene of one nut or bearing.
    stores
        Folders with stored 3D solutions; None: those of the package.
    levels
        Mesh levels.

    Returns
    -------
    list of MeshQuantity
        For each quantity that is not fixed at zero: value on each level, order of convergence, extrapolated value, mesh
        uncertainty, and a remark on why the order could or could not be determined. If modelling choices of the 3D
        reference were varied, also their combined effect (root of the sum of squares), and the largest change due to
        boundary conditions that the scene file must define, such as how the nut is fixed.
    """
    reference = reference_from_stored_runs(scene, stores, levels)
    if reference is None:
        return []
    coarsest = min(LEVELS)
    base = run_without_changed_choices(scene, coarsest, stores)
    others = [v for v, variant in VARIANTS.items() if v != "base" and not variant.refined]
    changed = {v: r for v in others if (r := load_stored_run(scene, coarsest, v, stores)) is not None}
    return mesh_study_table_of_reference(reference, base, changed)


def mesh_study_table_of_reference(
    reference: estimate.Reference, unchanged_run: Run | None, changed_runs: Mapping[str, Run]
) -> list[MeshQuantity]:
    """Return the quantities of a mesh study from the solutions of a 3D reference, as `mesh_study_table_of_scene` does.

    Parameters
    ----------
    reference
        3D reference with its solutions on several mesh levels.
    unchanged_run
        Run with the usual modelling choices, with which the variants are compared; None: no variants.
    changed_runs
        Runs with one modelling choice changed, by the name of the variant.
    """
    runs, table = reference.runs, list[MeshQuantity]()
    levels = tuple(run.level for run in runs)
    shown = [x for x in studied_quantities(runs[-1]) if any(x.value(r) for r in runs)]
    lines = [x for x in shown if x.contact is None]
    of_two: dict[str, float] = {}
    if len(runs) == 2 and lines:  # each alone may agree by chance
        bars = pooled_grid_uncertainty([[x.value(r) for x in lines] for r in runs], reference.sizes)
        of_two = dict(zip((x.name for x in lines), bars.tolist(), strict=True))
    for name, unit, take, contact in shown:
        values = tuple(take(r) for r in runs)
        further = dict[str, Any]()
        if len(runs) >= 2:
            observed = grid_convergence(values, reference.sizes) if contact is None else None
            bar = of_two.get(name, observed.uncertainty) if observed else float(reference.uncertainty[contact])
            if observed:
                further = {"order": observed.credible_order, "extrapolated": observed.extrapolated_value}
            further |= {"uncertainty": bar, "kind": observed.kind_text if observed else SCATTERS}
        if unchanged_run is not None and changed_runs:
            moves = {v: abs(take(r) - take(unchanged_run)) for v, r in changed_runs.items()}
            further["modelling_spread"] = _combined_choice_effect(moves)
            further["scene_choices"] = max((m for v, m in moves.items() if VARIANTS[v].kind == "scene"), default=None)
        table.append(MeshQuantity(name, unit, levels, values, **further))
    return table


def _combined_choice_effect(changes_by_variant: Mapping[str, float]) -> float | None:
    """Return the combined effect of modelling choices on a quantity: root of the sum of squares; None without effects.

    ``changes_by_variant``: change of the quantity by each variant of a choice; a choice with several variants counts with
    the largest.
    """
    by_choice: dict[str, float] = {}
    for name, move in changes_by_variant.items():
        variant = VARIANTS[name]
        if variant.kind == "modelling":
            by_choice[variant.choice] = max(move, by_choice.get(variant.choice, 0.0))
    return float(np.linalg.norm(list(by_choice.values()))) if by_choice else None


def mesh_levels_of_study(count: int | None) -> tuple[int, ...]:
    """Return the numbers of the mesh levels of a mesh study: 1 to ``count``, or `ADVISED` if ``count`` is None.

    Raises InputError if ``count`` is out of range.
    """
    if count is None:
        return ADVISED
    if not 1 <= count <= len(LEVELS):
        advice = "take three levels, which give an order of convergence"
        raise ArgumentError("levels", str(count), f"1 to {len(LEVELS)}", advice)
    return tuple(range(1, count + 1))


def mesh_study_table_of_bearing(
    referenced: SceneWithReference, stores: Sequence[Path], levels: Sequence[int]
) -> list[MeshQuantity]:
    """Return the mesh-study quantities of a nut or bearing: loads and displacements on each level of its 3D reference.

    ``referenced``: nut or bearing with its 3D reference; ``stores``: folders with solutions; ``levels``: mesh levels. The
    effects of modelling choices are left out if the nut or bearing is one of several on a shaft.
    """
    if referenced.assembly is None:
        return mesh_study_table_of_scene(referenced.scene, stores, levels)
    return mesh_study_table_of_reference(referenced.reference, None, {})


def compute_references_on_levels(
    scenes: Sequence[Solvable],
    levels: Sequence[int],
    stores: Sequence[Path],
    engine: jobs.ComputingSettings,
    show_progress: Callable[[str], None],
    *,
    spread: bool = False,
    source: bool = False,
    fresh: bool = False,
) -> list[SceneWithReference]:
    """Compute the 3D references of scenes by solutions on several mesh levels, and store new solutions in the first folder.

    Parameters
    ----------
    scenes
        Scenes with one load case each.
    levels
        Mesh levels.
    stores
        Folders with stored 3D solutions; the first takes new ones.
    engine
        Number of processes, or cluster, that compute the solutions.
    show_progress
        Function that is called with each line of progress.
    spread
        Whether the coarsest level is also solved with varied modelling choices.
    source
        Whether the mesh of Lin's thesis (first-order tetrahedra) is also used.
    fresh
        Whether stored solutions are computed again.

    Returns
    -------
    list of SceneWithReference
        3D reference of each nut or bearing.

    Raises
    ------
    InputError
        If ``spread`` is used for a shaft with several nuts or bearings. Its subclass SceneNotCoveredError is raised if no
        run of a scene converged.
    """
    tasks = jobs.plan_reference_tasks(scenes, levels, with_source_mesh=source)
    several = next((s.name for s in scenes if isinstance(s, Assembly)), None) if spread else None
    if several is not None:
        given = f"{several}, which has several nuts and bearings"
        allowed = "the varied modelling choices of this option only for scenes with a single nut or bearing"
        raise ArgumentError("spread", given, allowed, "leave `spread` out")
    if spread:
        tasks += [t for s in scenes for t in jobs.plan_reference_tasks([s], (), jobs.variant_names(refined=False))]

    def show_loads_of_coarsest_level(task: ReferenceTask) -> None:
        """Show the contact loads by the coarsest mesh level while finer levels are computed."""
        for scene in task.scenes if task.level == min(LEVELS) and not task.variant else ():
            for one in stored_references(scene, stores[:1], (task.level,)):
                table = quantities_without_single_balls(mesh_study_table_of_bearing(one, stores[:1], (task.level,)))
                values = (f"{x.name} {x.values[0]:.4g} {x.unit}" for x in table)
                show_progress(f"{one.reference.scene}, by level {task.level} alone: {'; '.join(values)}")

    show = show_loads_of_coarsest_level
    failed = jobs.ensure_runs_are_stored(
        tasks, stores[0], engine, show_progress, stores[1:], compute_again=fresh, after_each_stored_task=show
    )
    references = []
    for scene in scenes:
        sets = stored_references(scene, stores, tuple(levels), run_count=len(levels))
        if not sets:
            raise error_for_unconverged_reference(scene.name, failed)
        references += sets
    return references


def quantities_without_single_balls(quantities: Sequence[MeshQuantity]) -> list[MeshQuantity]:
    """Return the quantities of a mesh study that tables show: without the loads of single balls."""
    return [x for x in quantities if "load of ball" not in x.name]


def mesh_study_rows_for_terminal(quantities: Sequence[MeshQuantity]) -> list[dict[str, Any]]:
    """Return a mesh-study table for the terminal, without rows of single balls, columns of percentages and remarks."""
    return [
        {
            "quantity": x.name,
            "unit": x.unit,
            **x.on_levels,
            "order": x.order,
            "extrapolated": x.extrapolated,
            "uncertainty": x.uncertainty,
            "modelling_spread": x.modelling_spread,
            "scene_choices": x.scene_choices,
        }
        for x in quantities_without_single_balls(quantities)
    ]


def mesh_study_of_reference(referenced: SceneWithReference, stores: Sequence[Path], levels: Sequence[int]) -> MeshStudy:
    """Return the mesh study of a nut or bearing.

    ``referenced``: nut or bearing with its 3D reference; ``stores``: folders with solutions; ``levels``: mesh levels.
    """
    return MeshStudy(
        scene=referenced.described_scene.name,
        set=referenced.set_name,
        levels=tuple(mesh_levels_of_reference(referenced.reference)),
        quantities=tuple(mesh_study_table_of_bearing(referenced, stores, levels)),
        notes=(mesh_accuracy_sentence(referenced.reference),),
    )


def run_mesh_study(
    target: Solvable, levels: int | None, show_progress: Callable[[str], None], *, spread: bool, store: Path
) -> MeshStudy:
    """Run a mesh study of one scene for `rollbench.mesh_study`.

    Parameters
    ----------
    target
        Scene of one nut or bearing, or of a shaft with several.
    levels
        Number of levels; None: `ADVISED`.
    show_progress
        Function that is called with each line of progress.
    spread
        Whether modelling choices are varied.
    store
        Folder in which new 3D solutions are stored.

    Returns
    -------
    MeshStudy
        Mesh study of the scene, or of each nut or bearing on the shaft.
    """
    from rollbench.meshes.cache import default_cache_folder

    stores, wanted = (store, shipped_store()), mesh_levels_of_study(levels)
    engine = jobs.ComputingSettings(cache_folder=default_cache_folder())
    references = compute_references_on_levels([target], wanted, stores, engine, show_progress, spread=spread)
    each = [mesh_study_of_reference(x, stores, wanted) for x in references]
    if isinstance(target, Scene):
        return each[0]
    notes = tuple(line for one in each for line in one.notes)
    return MeshStudy(scene=target.name, sets={one.set: replace(one, notes=()) for one in each}, notes=notes)
