"""One scene solved for many places of its balls: contact loads alone, by the same equations as a single solution."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.lowfi.compliance.bodies import WholeBody, whole_body
from rollbench.lowfi.compliance.parts import REFINED, Backend
from rollbench.lowfi.statics import elastic, static
from rollbench.lowfi.statics.elastic_system import Elastic, Rebuild
from rollbench.lowfi.statics.problem import Problem, distances
from rollbench.lowfi.statics.selection import all_sides, choose_sides
from rollbench.lowfi.statics.settle import contact_angles, verdict
from rollbench.lowfi.statics.static import Engine, Unheld, pick_engine, round_off_bound, unheld
from rollbench.lowfi.threads import one_thread
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.errors import Specimen
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import Scene

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.imported import Condensed


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
    """Contact loads of balls with errors ``drawn`` at places ``layout``: ``solve_static``."""
    known = distances(scene, drawn)
    use = choose_sides(scene, drawn, known)
    solved = static.solve_sides(scene, drawn, layout, pick_engine(engine, layout.z.size), use, known=known)
    if isinstance(solved, Unheld):
        return _none(solved.problem.C, solved.status)
    prepared, outcome = solved.prepared, solved.outcome
    status = verdict(outcome, round_off_bound(prepared, outcome.scale), partial(unheld, prepared.problem))
    return _loads(prepared.force, prepared.normal, prepared.problem.C, status)


def elastic_loads(
    scene: Scene,
    drawn: Specimen,
    layout: BallLayout,
    engine: Engine = "auto",
    backend: Backend = REFINED,
    whole: WholeBody = whole_body,
) -> ContactLoads:
    """The same with elastic bodies, ``solve_elastic``; whole: see `body_compliance`."""
    use = all_sides(scene) if drawn.profile.shape[1] else choose_sides(scene, drawn)
    with one_thread():
        system, status = solved_system(scene, drawn, layout, backend, None, engine, use, whole)
        if isinstance(system, Problem):
            return _none(system.C, status)
        _, contact, _ = elastic.contacts_of(system)
    return _loads(contact[..., 0], contact[..., 1:3], system.problem.C, status)


def solved_system(
    scene: Scene,
    drawn: Specimen,
    layout: BallLayout,
    backend: Backend,
    condensed: Condensed | None,
    engine: Engine,
    use: Mask,
    whole: WholeBody = whole_body,
) -> tuple[Elastic | Problem, str]:
    """Elastic bodies at their solution, with the sides ``use`` (4,) or all four, and its status; the problem alone where
    nothing holds the screw."""
    kernels = pick_engine(engine, layout.z.size)
    solved = elastic.solve_sides(Rebuild(scene, drawn, layout, use, None, backend, condensed, kernels, False, 1, whole))
    if isinstance(solved, Unheld):
        return solved.problem, solved.status
    system, outcome = solved.elastic, solved.outcome
    return system, verdict(outcome, elastic.round_off(system, outcome.scale), partial(unheld, system.problem))


def _loads(force: Array, normal: Array, C: Array, status: str) -> ContactLoads:
    angle = np.where(force > 0.0, contact_angles(normal), np.nan)
    return ContactLoads(force.copy(), angle, C.copy(), status)


def _none(C: Array, status: str) -> ContactLoads:
    nan: Any = np.full(C.shape, np.nan)
    return ContactLoads(nan, nan, C.copy(), status)
