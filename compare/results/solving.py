"""Solve a scene with one load case, and fill `Result` with all that follows: life, stiffness, preload, friction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

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
from rollbench.compare.models.stiffness import place_of_displacement, stiffness_of_scene
from rollbench.compare.results.solved import AxialResults, CycleResult, Result
from rollbench.compare.scenes.duty_cycle import DutyCycle
from rollbench.lowfi.rating.catalogue_checks import shaft_limits, warn_of_overall_friction_coefficient
from rollbench.lowfi.rating.displacement import motion_at
from rollbench.lowfi.rating.rigidity import axial_force
from rollbench.lowfi.statics.result import AxisResult, StaticResult
from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene


def solve_with_results(
    scene: Scene | Assembly,
    model: str,
    options: ModelOptions,
    stiffness_at: float | None = None,
    *,
    stiffness: bool = False,
    drives: bool = True,
) -> Result:
    """Solve a scene with one load case by a model, and compute all results: pressure, life, rigidity, preload, friction.

    The scene is solved once more without loads, some times with scaled loads to find those that open a contact, and, if
    several bodies are loaded, once for each of them without the loads on this body.

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
    drives
        Whether the friction of the nuts of a shaft, the torques at its motor and the life of the axis are computed.

    Returns
    -------
    Result
        The results.

    Raises
    ------
    InputError
        If the model does not cover the scene.
    """
    if isinstance(scene, Assembly) and stiffness_at is not None:
        scene = replace(scene, stiffness_at=stiffness_at)
    result = run_model(scene, model, options)
    if not result.converged:
        return Result(described=scene, solution=result, sets=answers.unsolved_sets(scene, result))
    solutions = loading.SolutionsByLoad(scene, result, model, options)
    model, bare, at = result.model, solutions.at(0.0), place_of_displacement(scene)
    stated = stiffness_of_scene(scene, result, bare, model, options)
    moved = motion_at(result, at) - answers.motion_of_unloaded_screw(bare, at)
    lift_off = loading.find_lift_off_loads(solutions)
    sets = answers.results_of_sets(scene, result, bare, stated.sets, lift_off)
    if drives or isinstance(scene, Scene):
        sets = with_friction_of_nuts(scene, sets, options.member)
    path = loading.load_path(scene, result, bare)
    warned = [
        w.with_part_name(name) if name else w
        for name, s in sets.items()
        for w in answers.warnings_of_set(s, loading.absolute_axial_preload(s.preload))
    ]
    each_nut = (shaft_limits(scene, result, s.parts) for s in sets.values() if isinstance(s.parts, Scene))
    shaft = min((x for x in each_nut if x is not None), key=lambda x: x.allowed_speed, default=None)
    of_scene: dict[str, Any] = {}
    paths: tuple[loading.LoadPath | None, ...] = (path,)
    if isinstance(scene, Scene):
        assert isinstance(result, StaticResult), "a scene with one nut or bearing has the result of one"
        warned += [] if scene.friction is None else warn_of_overall_friction_coefficient(scene.track, scene.friction)
        axial = AxialResults(axial_force(result), answers.load_step_stiffness(scene, model, options))
        expected = estimate_model_error(scene, result)
        if stiffness_at is not None:
            of_scene["tangent"] = answers.tangent_stiffness_at(scene, stiffness_at, model, options)
        elif stiffness:
            of_scene["tangent"] = answers.tangent_stiffness_at_nut(scene, model, options)
    else:
        assert isinstance(result, AxisResult), "an assembly has the result of an axis"
        axial, expected = AxialResults(loading.axial_load(scene)), estimate_double_nut_error(scene, result)
        paths = answers.load_paths_by_body(scene, result, path)
        if drives:
            speed = None if scene.motion is None else scene.motion.speed
            of_scene["drive"] = motor_torques_and_inertias(scene, sets)
            of_scene["axis_life"] = life_of_turning_sets(scene, sets.items(), speed)
    warned += [w for x in paths for w in loading.load_path_warnings(x)]
    warned += loading.lost_preload_warnings(solutions)
    warned += [*(() if shaft is None else shaft.warnings), *answers.axial_play_warnings(scene)]
    return Result(
        described=scene,
        solution=replace(result, warnings=(*result.warnings, *warned)),
        sets=sets,
        axial=axial,
        load_point=stated.load_point,
        tangent_words=stated.words,
        displacement=None if np.isnan(moved).all() else moved,
        shaft=shaft,
        load_path=path,
        expected_error=expected,
        **of_scene,
    )


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
