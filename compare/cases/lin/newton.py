"""Lin's Newton method as a check of the energy solver, and on hard-to-solve scenes.

It is started in three ways: from the nominal state; from a good guess, in which the screw is moved along its axis as if all
balls shared the axial load equally; and from that guess with the load applied in ten steps.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from rollbench.meshes.axis import Assembly
from rollbench.meshes.parts import Scene

if TYPE_CHECKING:
    from rollbench.compare.gate.gate import GateCheck
    from rollbench.compare.models.study import SceneResultCache
    from rollbench.compare.studies.extreme_cases import HardScene
    from rollbench.compare.studies.extremes import FormulationOutcome
    from rollbench.lowfi.as_source.newton import Start
    from rollbench.lowfi.statics.result import StaticResult

#: Largest number of unknowns for which the dense Jacobian of Lin's thesis is attempted.
DENSE_LIMIT = 2000


def check_against_energy_solver(cache: SceneResultCache, max_error: float) -> list[GateCheck]:
    """Check that the energy solver and Lin's Newton method find the same contact loads.

    The limit of the errors is `EXACT`, which leaves room for round-off only, or ``max_error`` [%] if that is smaller.
    """
    from rollbench.compare.gate.gate import EXACT, GateCheck
    from rollbench.compare.measure import load_error
    from rollbench.lowfi.as_source.newton import solve_lin_equations_with_fallback

    rows, limit = [], min(EXACT, max_error)
    for name in ("lin-case1", "lin-case3-offset"):
        by_source = solve_lin_equations_with_fallback(cache.built_in_scene(name), "arc")
        e = load_error(cache.solve_once(name).load, by_source.contact_loads)
        passed = by_source.converged and e.max_percent <= limit
        label = f"{name}: contact loads by the energy solver against Lin's Newton method, same equations"
        words = f"largest difference at ball {e.ball} {e.side}; Lin's Newton method: {by_source.status}"
        rows.append(GateCheck(label, "two solvers", None, None, e.max_percent, limit, passed, words))
    return rows


def unknown_count_of_thesis_equations(scene: Scene) -> int:
    """Return the number of unknowns of a scene in the equations of Lin's thesis."""
    from rollbench.lowfi.statics.problem import build_problem
    from rollbench.meshes.errors import draw_geometry_with_errors
    from rollbench.meshes.helix import ball_layout

    layout = ball_layout(scene)
    problem = build_problem(scene, draw_geometry_with_errors(scene, layout), layout, np.ones(4, dtype=bool))
    return 6 * layout.z.size + problem.unknowns


@lru_cache(maxsize=1)
def _result_by_energy_solver(scene: Scene) -> StaticResult:
    """Solve a scene by the energy solver, once for all starts of Newton's method."""
    from rollbench.lowfi.statics.static import solve_static

    return solve_static(scene)


def solve_hard_scene_by_newton(hard_scene: HardScene, formulation: str) -> FormulationOutcome:
    """Solve a hard-to-solve scene by Newton's method as in Lin's thesis, and return the outcome.

    The beam has a node every 15 mm. For the comparison of their contact loads the energy solver is run with these nodes,
    too, and both methods take the flanks as rigid circular arcs (``kinematics="arc"``), so that they solve the same
    equations. ``formulation``: a key of `FORMULATIONS`.
    """
    from rollbench.compare.quantities import json_number
    from rollbench.compare.studies import extremes
    from rollbench.lowfi.as_source.newton import solve_by_lin_equations

    if isinstance(hard_scene.scene, Assembly):
        status = "not attempted: Lin's thesis has a single nut on its shaft"
        return extremes.outcome_with_status(hard_scene, formulation, status, reason=status)
    scene = replace(hard_scene.scene, ingredients=replace(hard_scene.scene.ingredients, partition="source"))
    unknowns = unknown_count_of_thesis_equations(scene)
    iterations, residual, seconds, difference = 0, math.nan, 0.0, None
    if unknowns > DENSE_LIMIT:
        status = f"not attempted: dense Jacobian of {unknowns} unknowns"
    elif scene.ingredients.screw == "rigid":
        status = "not attempted: the screw of Lin's thesis is a beam, not rigid"
    else:
        found = solve_by_lin_equations(scene, kinematics="arc", start_values=STARTS[formulation])
        status, iterations, residual, seconds = found.status, found.iterations, found.residual, found.seconds
        if found.converged and (energy_result := _result_by_energy_solver(scene)).converged:
            difference = extremes.largest_load_difference(found.contact_loads, energy_result.load)
    reason = extremes.first_clause_of_status(status)
    if difference is not None and difference > extremes.SAME:
        root = "another root of the contact conditions (beyond the arc)"
        reason += f"; loads differ from the energy solver's by {difference:.3g} %: {root}"
    return extremes.outcome_with_status(
        hard_scene,
        formulation,
        status,
        iterations=iterations,
        residual=json_number(residual),
        seconds=seconds,
        unknowns=unknowns,
        difference_percent=difference,
        reason=reason,
    )


#: Starts of Newton's method as in Lin's thesis, by the name of the formulation.
STARTS: dict[str, Start] = {
    "Lin's Newton method, started from the nominal geometry": "nominal",
    "Lin's Newton method, started from a good guess": "guess",
    "Lin's Newton method, load applied in steps": "load steps",
}

#: Formulations of the equations that are tried on the hard-to-solve scenes.
FORMULATIONS = dict.fromkeys(STARTS, solve_hard_scene_by_newton)
