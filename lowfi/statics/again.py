"""One scene solved for many places of its balls: contact loads alone, by the same equations as a single solution."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from lowfi.compliance.bodies import REFINED, Backend
from lowfi.compliance.imported import Condensed
from lowfi.statics import elastic as elastic_solver
from lowfi.statics.elastic_system import Elastic, Rebuild, one_thread
from lowfi.statics.mechanism import free_motions
from lowfi.statics.problem import Problem, build
from lowfi.statics.records import Outcome
from lowfi.statics.static import (
    ACCEPTED,
    Engine,
    contact_angles,
    follow_profile,
    pick_engine,
    pin,
    prepare,
    round_off_bound,
    solve_with_hertz,
    verdict,
)
from meshes.arrays import Array
from meshes.errors import Specimen
from meshes.helix import BallLayout
from meshes.parts import Scene


@dataclass(frozen=True)
class ContactLoads:
    """Contact forces (N, 4) [N], contact angles (N, 4) [rad], nan without contact, Hertz constants (N, 4), and status."""

    load: Array
    contact_angle: Array
    hertz_C: Array
    status: str

    @property
    def converged(self) -> bool:
        """Whether forces are in balance."""
        return self.status == "converged"


def beam_loads(scene: Scene, drawn: Specimen, layout: BallLayout, engine: Engine = "auto") -> ContactLoads:
    """Contact loads of balls with errors ``drawn`` at places ``layout``: ``solve_static`` with all four flanks."""
    kernels, use = pick_engine(engine, layout.z.size), np.ones(4, dtype=bool)
    problem = build(scene, drawn, layout, use)
    mechanism = free_motions(problem)
    if mechanism.driven:
        return _none(problem.C, f"not held: {mechanism.text}")
    prepared = prepare(pin(problem, mechanism), kernels)
    outcome = solve_with_hertz(prepared)
    if drawn.profile.shape[1] and scene.ingredients.arm != "nominal":
        outcome = follow_profile(prepared, outcome, layout, everything=False, refine=1)
    status = verdict(outcome, round_off_bound(prepared, outcome.scale), prepared.problem)
    return _loads(prepared.force, prepared.normal, prepared.problem.C, status)


def elastic_loads(
    scene: Scene, drawn: Specimen, layout: BallLayout, engine: Engine = "auto", backend: Backend = REFINED
) -> ContactLoads:
    """The same with elastic bodies, ``solve_elastic`` with all four flanks."""
    with one_thread():
        system, status = solved_system(scene, drawn, layout, backend, None, engine)
        if isinstance(system, Problem):
            return _none(system.C, status)
        _, contact, _ = elastic_solver.contacts_of(system)
    return _loads(contact[..., 0], contact[..., 1:3], system.problem.C, status)


def solved_system(
    scene: Scene, drawn: Specimen, layout: BallLayout, backend: Backend, condensed: Condensed | None, engine: Engine
) -> tuple[Elastic | Problem, str]:
    """Elastic bodies with all four flanks at their solution, and its status; the problem alone where nothing holds the
    screw."""
    kernels, use = pick_engine(engine, layout.z.size), np.ones(4, dtype=bool)
    rebuild = Rebuild(scene, drawn, layout, use, None, backend, condensed, kernels, False, 1)
    problem = rebuild.problem()
    mechanism = free_motions(problem)
    if mechanism.driven:
        return problem, f"not held: {mechanism.text}"
    rebuild, system = rebuild.pinned(pin(problem, mechanism))
    outcome: Outcome = elastic_solver.solve_with_hertz(system)
    if drawn.profile.shape[1] and scene.ingredients.arm != "nominal":
        system, outcome = elastic_solver.follow_profile(system, outcome, rebuild)
    return system, verdict(outcome, max(elastic_solver.round_off(system, outcome.scale), ACCEPTED), system.problem)


#: How the models of a static run find loads again and again, by name.
AGAIN: dict[str, Callable[..., ContactLoads]] = {"lin": beam_loads, "refined": elastic_loads}


def _loads(force: Array, normal: Array, C: Array, status: str) -> ContactLoads:
    angle = np.where(force > 0.0, contact_angles(normal), np.nan)
    return ContactLoads(force.copy(), angle, C.copy(), status)


def _none(C: Array, status: str) -> ContactLoads:
    nan: Any = np.full(C.shape, np.nan)
    return ContactLoads(nan, nan, C.copy(), status)
