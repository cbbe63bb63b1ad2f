"""Computation of 3D reference runs: meshing and condensing the parts, solving load cases, enlarging contact patches."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING

import numpy as np

from rollbench.compare import __version__
from rollbench.compare.reference import tasks
from rollbench.compare.reference.levels import LEVELS, VARIANTS
from rollbench.compare.reference.store import Run, measuring_conditions, program_versions
from rollbench.compare.running import check_reference_programs, out_of_memory_error
from rollbench.meshes.arrays import Array
from rollbench.meshes.cache import StageMessage
from rollbench.meshes.condensed import CondensedBodies
from rollbench.meshes.parts import Scene
from rollbench.meshes.processes import peak_memory_MB

if TYPE_CHECKING:
    from rollbench.hifi.meshing.settings import Settings
    from rollbench.hifi.reference import ReferenceResult
    from rollbench.hifi.setup import CondensedGeometry

#: Function that is called with each line of progress.
Step = Callable[[str], None]

#: Enlargement of patches (finely meshed parts of a surface) whose rim a contact reaches: largest number of enlargements,
#: factor of one step, largest number of steps in one enlargement.
ENLARGE, BEYOND, LARGER = 3, 1.2, 4
#: Share of the length of skew contacts along the groove that a patch must cover; with 0.995, no contact of the random
#: screws reaches the rim.
ALIKE = 0.99
#: Smallest relative enlargement for which a patch is meshed again.
GROWN = 5e-3


def compute_reference_runs(task: tasks.ReferenceTask, step: Step = lambda _: None) -> list[Run]:
    """Compute the results (runs) of the 3D reference for the scenes of a task.

    Parameters
    ----------
    task
        Scenes, mesh level and variant.
    step
        Function that is called with lines of progress.

    Returns
    -------
    list of Run
        A run for each scene.

    Raises
    ------
    InputError
        If a mesh cannot be built, or memory runs out.
    """
    return compute_runs_and_bodies(task, step)[0]


def compute_runs_and_bodies(
    task: tasks.ReferenceTask, step: Step = lambda _: None
) -> tuple[list[Run], CondensedBodies | None]:
    """Compute the results (runs) of the 3D reference for the scenes of a task, and its condensed screw and nut.

    If a contact reaches the rim of its patch (the finely meshed part of the surface), the patches are enlarged as the loads
    require, and the scenes are solved again.

    Parameters
    ----------
    task
        Scenes, mesh level and variant.
    step
        Function that is called with lines of progress.

    Returns
    -------
    list of Run
        A run for each scene.
    CondensedBodies or None
        Condensed screw and nut; None if a run did not converge, or `are_condensed_bodies_stored` is false for the task.

    Raises
    ------
    InputError
        If a mesh cannot be built, or memory runs out.
    """
    check_reference_programs()
    from rollbench.hifi.condensed import collect_condensed_bodies
    from rollbench.hifi.reference import AT_RIM

    change = VARIANTS[task.variant].change if task.variant else lambda scene: scene
    scenes = [change(scene) if isinstance(scene, Scene) else scene for scene in task.scenes]
    balls, ratio = tasks.ball_slices_by_set(scenes[0]), task.cut_end_cell_ratio
    ups: tuple[tasks.MeshSpecification, ...] = tuple(
        replace(up, mesh_settings=replace(up.mesh_settings, cell=ratio * up.mesh_settings.cell))
        for up in tasks.mesh_specifications(scenes, task.level, task.variant)
    )
    for attempt in range(ENLARGE + 1):
        setups = _mesh_and_condense_each_set(task, scenes, ups, step)
        results = [_solve_load_case(scene, setups, step) for scene in scenes]
        full = [(result.contact_loads, result.contact_angles) for result in results if result.status == AT_RIM]
        if not full:
            break
        larger = []
        for up in ups:
            contacts = [(load[balls[k]], angle[balls[k]]) for load, angle in full for k in up.set_numbers]
            settings, why = settings_with_larger_patches(setups[up.set_numbers[0]], contacts, max(0, ENLARGE - 1 - attempt))
            larger.append(up if settings is None else replace(up, mesh_settings=settings))
        words = "a contact reaches the rim of its patch"
        if tuple(larger) == ups or attempt == ENLARGE:
            results = [replace(r, status=f"{words}: {why}") if r.status == AT_RIM else r for r in results]
            break
        ups = tuple(larger)
        step(f"{words}, larger patches: {why}")
    runs = [_create_run_record(task, k, scene, results[k], setups, ups) for k, scene in enumerate(scenes)]
    good = are_condensed_bodies_stored(task) and all(run.answers for run in runs)
    return runs, collect_condensed_bodies(setups[0], task.level) if good else None


def _mesh_and_condense_each_set(
    task: tasks.ReferenceTask, scenes: Sequence[tasks.Solvable], ups: Sequence[tasks.MeshSpecification], step: Step
) -> list[CondensedGeometry]:
    """Mesh and condense the parts of each nut or bearing row on the shaft, and return them row by row.

    ``scenes``: load cases of the task; ``ups``: bodies, flanks and mesh settings of each nut or row to be meshed; equal
    rows share the same condensed parts; ``step``: function that is called with lines of progress. InputError if a mesh
    cannot be built or memory is too small.
    """
    from rollbench.hifi.setup import mesh_and_condense_geometry
    from rollbench.meshes.cache import Cache

    by_set: dict[int, CondensedGeometry] = {}
    for up in ups:
        if not isinstance(scenes[0], Scene):
            step(f"bodies of {', '.join(scenes[0].sets[k].name for k in up.set_numbers)}")
        more = [scene for scene in scenes[1:] if isinstance(scene, Scene)]
        try:
            setup = mesh_and_condense_geometry(
                up.parts,
                up.meshed_flanks,
                up.mesh_settings,
                step,
                more,
                cache=Cache(task.cache_folder),
                processes=task.processes,
            )
        except MemoryError as error:
            raise out_of_memory_error(error) from error
        except ValueError as error:
            raise tasks.not_covered_by_3d_reference_error(scenes[0], error) from error
        by_set |= dict.fromkeys(up.set_numbers, setup)
    return [by_set[k] for k in sorted(by_set)]


def _solve_load_case(scene: tasks.Solvable, setups: Sequence[CondensedGeometry], step: Step) -> ReferenceResult:
    """Solve one load case by the 3D reference.

    ``setups``: meshed and condensed parts of each nut or bearing row; ``step``: function that is called with lines of
    progress. SceneNotCoveredError if the 3D reference does not cover the scene.
    """
    from rollbench.hifi.reference import solve_reference
    from rollbench.hifi.several_sets import solve_nuts_on_one_shaft

    try:
        if isinstance(scene, Scene):
            result = solve_reference(setups[0], scene, sides=tasks.flanks_to_mesh(scene), frozen=True, step=step)
        else:
            result = solve_nuts_on_one_shaft(scene, setups, frozen=True, step=step)
    except ValueError as error:
        raise tasks.not_covered_by_3d_reference_error(scene, error) from error
    step(StageMessage("contact loads", f"{result.solve_seconds:.1f} s, {scene.name} {result.status}"))
    return result


def _create_run_record(
    task: tasks.ReferenceTask,
    number: int,
    scene: tasks.Solvable,
    result: ReferenceResult,
    setups: Sequence[CondensedGeometry],
    ups: Sequence[tasks.MeshSpecification],
) -> Run:
    """Create the record that is stored for one load case which the 3D reference has solved.

    ``number``: index of the load case in the task; ``scene``: its scene, changed by the variant of the task; ``setups``:
    condensed parts of each nut or bearing row; ``ups``: bodies, flanks and mesh settings of each.
    """
    from rollbench.hifi.reference import INGREDIENTS, solve_reference

    without = {}
    if task.leave_out_each_part and isinstance(scene, Scene):
        flanks = tasks.flanks_to_mesh(scene)
        for name in INGREDIENTS:
            without[name] = solve_reference(setups[0], scene, sides=flanks, leave_out=frozenset([name]))
    shared = list({id(s): s for s in setups}.values())
    settings = tasks.mesh_settings_to_store(ups)
    if task.single_row_scenes:
        settings = asdict(ups[0].mesh_settings) | {"stations": tasks.stations_of_load_cases(*task.scenes)}
    assert result.loads_with_nominal_normals is not None
    return Run(
        scene=task.scenes[number].name,
        level=task.level,
        variant=task.variant,
        status=result.status,
        moving=result.remaining_load_change,
        load=result.contact_loads,
        angle=np.degrees(result.contact_angles),
        frozen=result.loads_with_nominal_normals,
        centreline=np.column_stack([result.centreline_positions, result.centreline_motion[:, :3]]),
        without={name: ablated.contact_loads for name, ablated in without.items()},
        without_seconds={name: ablated.solve_seconds for name, ablated in without.items()},
        sides=tuple(sorted({side for s in setups for side in s.loaded_flanks})),
        unknowns=result.degree_of_freedom_count,
        stages={name: sum(s.seconds_by_stage.get(name, 0.0) for s in shared) for name in shared[0].seconds_by_stage},
        solve_seconds=result.solve_seconds,
        peak_MB=None if (peak := peak_memory_MB()) is None else peak + max(s.worker_peak_memory_MB for s in shared),
        balance=result.unbalanced_ball_force,
        along_groove=result.unbalanced_force_along_groove,
        screw_balance=result.unbalanced_shaft_force,
        quality=shared[0].mesh_quality
        | {name: min(s.mesh_quality[name] for s in shared) for name in ("screw", "nut", "ball")},
        settings=settings,
        assumed=tuple(dict.fromkeys(line for s in shared for line in s.solid_dimensions.assumed)),
        versions={"rollbench": __version__, **program_versions()},
        sources=measuring_conditions().sources,
        machine=measuring_conditions().machine,
        date=datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d"),
    )


def settings_with_larger_patches(
    setup: CondensedGeometry, loads_and_angles: Sequence[tuple[Array, Array]], steps_left: int
) -> tuple[Settings | None, str]:
    """Return mesh settings whose contact patches (fine meshes) are large enough for computed contact loads.

    Patches grow by a fixed factor. Because of the lead angle, contact ellipses are skew to the mesh lines of a patch and
    reach further along the groove than their semi-axis. If the remaining steps would not make the patches long enough for
    this, they are enlarged to the required length at once.

    Parameters
    ----------
    setup
        Meshed and condensed parts with the present patches.
    loads_and_angles
        Computed contact loads (n, 4) [N] and contact angles (n, 4) [rad] of n balls on 4 flanks, for each load case.
    steps_left
        Number of enlargements that are still possible after this one.

    Returns
    -------
    Settings or None
        The settings; None if the patches cannot be enlarged.
    str
        Text with the required and the present size of the patches; without settings, also the reason.
    """
    from rollbench.hifi.meshing.part_meshes import (
        choose_patch_cells,
        choose_refinement_box_size,
        reach_of_ellipses_along_groove,
    )
    from rollbench.hifi.meshing.settings import hertz_contacts_under_unit_force

    def half_widths_of_contact_zone(settings: Settings) -> tuple[float, float]:
        """Return the half widths [m] of the contact zone of a patch (fine mesh), across and along the groove."""
        size = choose_refinement_box_size(
            setup.scene, setup.groove_map, setup.ball_positions, setup.loaded_flanks, setup.solid_dimensions, settings
        )
        widths = (size.gamma * float(setup.groove_map.radius.mean()), size.phi * setup.groove_map.R)
        share = choose_patch_cells(settings, widths, size.depth)[1]
        return share[0] * widths[0], share[1] * widths[1]

    def patch_size_text(lengths: tuple[float, float]) -> str:
        return f"{1e3 * lengths[0]:.3g} mm across and {1e3 * lengths[1]:.3g} mm along the groove"

    m, needs, askew = setup.groove_map, np.zeros(2), 0.0
    units = hertz_contacts_under_unit_force(setup.scene)
    for load, touched in loads_and_angles:
        size, angle = np.cbrt(load), np.where(load > 0.0, touched, m.beta)
        across, along = (size * np.array([getattr(unit, name) for unit in units]) for name in ("semi_x", "semi_y"))
        needs = np.maximum(needs, [float((across + np.abs(angle - m.beta) * m.radius).max()), float(along.max())])
        askew = max(
            askew,
            *(reach_of_ellipses_along_groove(m, s, angle[:, s], across[:, s], along[:, s]) for s in setup.loaded_flanks),
        )
    has, reach = half_widths_of_contact_zone(setup.mesh_settings), np.array(setup.mesh_settings.reach)
    required = patch_size_text((float(needs[0]), float(needs[1])))
    words = f"the computed loads need {required}, the patch has {patch_size_text(has)}"
    refused, wide = "", max(float(reach[0]), float(needs[0]))
    longer = replace(setup.mesh_settings, reach=(wide, askew))
    try:
        last = BEYOND**steps_left * max(float(reach[1]), float(needs[1]) / BEYOND if steps_left else 0.0)
        short, long = (half_widths_of_contact_zone(x)[1] for x in (replace(longer, reach=(wide, last)), longer))
        if short < ALIKE * askew <= long:
            return longer, f"{words}; skew contacts need {1e3 * askew:.3g} mm along the groove"
    except ValueError as error:
        refused = f"; a larger one is refused: {error}"
    # a small step may be less than one cell, and a large step may exceed the available space: then the largest that fits
    for factor in (*(BEYOND**power for power in range(1, LARGER + 1)), *np.linspace(BEYOND, 1.0, 41)[1:-1]):
        a, b = np.maximum(factor * reach, 0.0 if refused else needs).tolist()
        larger = replace(setup.mesh_settings, reach=(a, b))
        try:
            after = half_widths_of_contact_zone(larger)
        except ValueError as error:
            refused = refused or f"; a larger one is refused: {error}"
            continue
        if max(after[0] / has[0], after[1] / has[1]) > 1.0 + GROWN:
            return larger, words
    return None, words + (
        refused or ", the largest for which there is space; reduce the load, or leave more space around the contact"
    )


def are_condensed_bodies_stored(task: tasks.ReferenceTask) -> bool:
    """Return whether the condensed screw and nut of a task are stored together with its results.

    They are stored for scenes with one nut or bearing row, without a variant, on a regular mesh level.
    """
    return bool(task.single_row_scenes) and not task.variant and task.level in LEVELS
