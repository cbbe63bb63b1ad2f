"""Solve a scene with one load case, and fill `Result` with all that follows: life, stiffness, preload, friction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rollbench.compare.models import answers, loading
from rollbench.compare.models.load_cases import (
    compute_duty_cycle_results,
    life_of_turning_sets,
    motor_torques_and_inertias,
    with_friction_of_nuts,
)
from rollbench.compare.models.model import ModelOptions
from rollbench.compare.models.model_form import estimate_double_nut_error, estimate_model_error
from rollbench.compare.models.registry import run_model
from rollbench.compare.models.set_results import SetResult
from rollbench.compare.models.stiffness import place_of_displacement, stiffness_of_scene
from rollbench.compare.results.solved import AxialResults, CycleResult, Result
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.lowfi.rating.catalogue_checks import shaft_limits, warn_of_overall_friction_coefficient
from rollbench.lowfi.rating.displacement import motion_at
from rollbench.lowfi.rating.rigidity import axial_force
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene


def solve_with_results(
    scene: Scene | Assembly,
    model: str,
    options: ModelOptions,
    stiffness_at: float | None = None,
    *,
    stiffness: bool = False,
) -> Result:
    """Solve a scene with one load case by a model, and compute all results: pressure, life, rigidity, preload, friction.

    Parameters
    ----------
    scene
        Scene with one nut or bearing row, or with several on one shaft.
    model
        Name of the model.
    options
        Options of the model.
    stiffness_at
        Axial position on the shaft [m] at which the stiffness is computed; None: as ``stiffness`` says.
    stiffness
        Whether the 6 x 6 stiffness at the nut's centre of a single nut or bearing row is computed.

    Returns
    -------
    Result
        The results.

    Raises
    ------
    InputError
        If the model does not cover the scene.
    """
    if isinstance(scene, Assembly):
        shaft_scene = scene if stiffness_at is None else replace(scene, stiffness_at=stiffness_at)
        return _with_drive_and_life(solve_shaft(shaft_scene, model, options.member))
    result = run_model(scene, model, options)
    if not result.converged:
        return Result(described=scene, solution=result, sets={"": SetResult(parts=scene, balls=result)})
    solutions = loading.SolutionsByLoad(scene, result, model, options)
    bare = solutions.at(0.0)
    stated = stiffness_of_scene(scene, result, bare, model, options)
    at = place_of_displacement(scene)
    moved = motion_at(result, at) - answers.motion_of_unloaded_screw(bare, at)
    (lift_off,) = loading.find_lift_off_loads(solutions)
    one = answers.results_of_single(scene, result, bare, stated.nut, lift_off, options.member)
    path = loading.load_path_of_scene(scene, result, bare)
    warned = [*answers.warnings_of_set(one, loading.absolute_axial_preload(one.preload))]
    if scene.friction is not None:
        warned += warn_of_overall_friction_coefficient(scene.track, scene.friction)
    warned += [*loading.load_path_warnings(path), *answers.axial_play_warnings(scene)]
    shaft = shaft_limits(scene, result)
    warned += [] if shaft is None else shaft.warnings
    tangent = None
    if stiffness_at is not None:
        tangent = answers.tangent_stiffness_at(scene, stiffness_at, model, options)
    elif stiffness:
        tangent = answers.tangent_stiffness_at_nut(scene, model, options)[0]
    return Result(
        described=scene,
        solution=replace(result, warnings=(*result.warnings, *warned)),
        sets={"": one},
        axial=AxialResults(axial_force(result), answers.load_step_stiffness(scene, model, options)),
        load_point=stated.load_point,
        tangent=tangent,
        tangent_words=stated.words,
        displacement=None if np.isnan(moved).all() else moved,
        shaft=shaft,
        load_path=path,
        expected_error=estimate_model_error(scene, result),
    )


def solve_shaft(assembly: Assembly, model: str, member: int = 0) -> Result:
    """Solve a shaft with several nuts or bearing rows, and compute all results but friction of nuts, drive and axis life.

    The shaft is solved once more without loads, some times with scaled loads to find those that open a contact, and, if
    several bodies are loaded, once for each of them without the loads on this body.

    Parameters
    ----------
    assembly
        Shaft with several nuts or bearing rows.
    model
        Name of the model.
    member
        Number of the random draw of the geometric errors, from 0; 0 without random errors.

    Returns
    -------
    Result
        The results.

    Raises
    ------
    InputError
        If the model does not cover the assembly.
    """
    options = ModelOptions(member=member)
    result = run_model(assembly, model, options)
    if not result.converged:
        bare_sets = {s.of.name: SetResult(name=s.of.name, parts=s.of.parts, balls=s.balls, on_shaft=s) for s in result.sets}
        return Result(described=assembly, solution=result, sets=bare_sets)
    solutions = loading.SolutionsByLoad(assembly, result, result.model, options)
    bare, moved = solutions.at(0.0), None
    if bare.converged:
        at = place_of_displacement(assembly)
        moved = motion_at(result, at) - motion_at(bare, at)
    stiffness = stiffness_of_scene(assembly, result, bare, result.model, options)
    unloaded = bare.sets if bare.converged else [None] * len(result.sets)
    lift_off = loading.find_lift_off_loads(solutions)
    each = zip(result.sets, unloaded, stiffness.sets, lift_off, strict=True)
    sets = {one[0].of.name: answers.results_of_set(assembly, *one, result.member) for one in each}
    path = loading.load_path_of_assembly(assembly, result, bare)
    warned = [
        w.with_part_name(s.name)
        for s in sets.values()
        for w in answers.warnings_of_set(s, loading.absolute_axial_preload(s.preload))
    ]
    warned += [w for x in answers.load_paths_by_body(assembly, result, path) for w in loading.load_path_warnings(x)]
    warned += loading.lost_preload_warnings(solutions)
    each_nut = (shaft_limits(assembly, result, s.parts) for s in sets.values() if isinstance(s.parts, Scene))
    shaft = min((x for x in each_nut if x is not None), key=lambda x: x.allowed_speed, default=None)
    warned += [] if shaft is None else shaft.warnings
    warned += answers.axial_play_warnings(assembly)
    return Result(
        described=assembly,
        solution=replace(result, warnings=(*result.warnings, *warned)),
        sets=sets,
        axial=AxialResults(loading.axial_load(assembly)),
        load_point=stiffness.load_point,
        tangent_words=stiffness.words,
        displacement=moved,
        shaft=shaft,
        load_path=path,
        expected_error=estimate_double_nut_error(assembly, result),
    )


def _with_drive_and_life(found: Result) -> Result:
    """Return the results of a shaft with the friction of its nuts, the torques at its motor and the life of the axis."""
    assembly = found.described
    if not found.converged or not isinstance(assembly, Assembly):
        return found
    sets = with_friction_of_nuts(assembly, found.sets, found.member)
    speed = None if assembly.motion is None else assembly.motion.speed
    life = life_of_turning_sets(assembly, sets.items(), speed)
    return replace(found, sets=sets, drive=motor_torques_and_inertias(assembly, sets), axis_life=life)


def combine_load_cases(cycle: DutyCycle, results: Sequence[Result]) -> CycleResult:
    """Combine the results of the load cases of a duty cycle, and compute extremes and lives over all of them.

    Parameters
    ----------
    cycle
        The duty cycle.
    results
        Results of its load cases, in order.
    """
    statuses = ["" if one.converged else str(one.solution.status) for one in results]
    together = compute_duty_cycle_results(
        cycle, [one.sets for one in results], statuses, [one.expected_error for one in results]
    )
    return CycleResult(
        described=replace(results[0].described, title=cycle.title),
        solution=results[0].solution,
        axis_life=together.axis_life,
        cases={case.name: one for case, one in zip(cycle.cases, results, strict=True)},
        cycle=cycle,
        together=together,
    )
