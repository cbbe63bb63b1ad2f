"""One scene solved for many places of its balls: contact loads only, by the same equations as a single solution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.compliance.bodies import WholeBody, whole_body
from rollbench.lowfi.compliance.parts import REFINED, Backend
from rollbench.lowfi.statics.elastic import ElasticBuild
from rollbench.lowfi.statics.problem import distances
from rollbench.lowfi.statics.selection import all_sides, choose_sides
from rollbench.lowfi.statics.settle import contact_angles
from rollbench.lowfi.statics.static import Build, Engine, Solution, Unheld, pick_engine, solve_sides
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimen
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import Scene


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
    return _loads(solve_sides(Build(scene, drawn, layout, use, pick_engine(engine, layout.z.size), known=known)))


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
    parts = scene, drawn, layout, use, pick_engine(engine, layout.z.size)
    return _loads(solve_sides(ElasticBuild(*parts, backend=backend, whole=whole)))


def _loads(solved: Solution | Unheld) -> ContactLoads:
    if isinstance(solved, Unheld):
        C = solved.problem.C.copy()
        return ContactLoads(np.full(C.shape, np.nan), np.full(C.shape, np.nan), C, solved.status)
    problem, contact, _, _ = solved.system.flanks()[0]
    force = contact[..., 0].copy()
    angle = np.where(force > 0.0, contact_angles(contact[..., 1:3]), np.nan)
    return ContactLoads(force, angle, problem.C.copy(), solved.verdict())
