"""Contact loads without a full result record: of balls at any positions, and the number of contacts of the nominal screw.

How many contacts the nominal screw loads is what the mean contact load of a scene is divided by. The nominal screw is
the scene with its preload (oversize of all balls, lead offset), supports and loads, and without all other errors of balls
and grooves. Its contacts are those that Lin's model (`lin`) finds loaded: one number for a scene, whatever model, mesh or
drawn specimen the loads are of.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from rollbench.lowfi.compliance.bodies import WholeBody, whole_body
from rollbench.lowfi.compliance.parts import REFINED, Backend
from rollbench.lowfi.statics.elastic import ElasticBuild
from rollbench.lowfi.statics.problem import centre_distances
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.selection import all_sides, choose_sides
from rollbench.lowfi.statics.settle import contact_angles
from rollbench.lowfi.statics.static import Build, Engine, Solution, UnrestrainedProblem, pick_engine, solve_sides
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimen, specimen
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.parts import BallErrors, Errors, Scene


@dataclass(frozen=True)
class ContactLoads:
    """Contact loads of N balls."""

    #: Contact forces ``(N, 4)`` [N].
    load: Array
    #: ``(N, 4)`` [rad]; nan without contact.
    contact_angle: Array
    #: Hertz constants ``(N, 4)`` [m/N^(2/3)].
    hertz_C: Array
    #: How the solution ended.
    status: str

    @property
    def converged(self) -> bool:
        """Whether the loads may be used."""
        return self.status == "converged"


def beam_loads(scene: Scene, drawn: Specimen, layout: BallLayout, engine: Engine = "auto") -> ContactLoads:
    """Return the contact loads of balls with errors ``drawn`` at positions ``layout`` by `solve_static`'s model."""
    known = centre_distances(scene, drawn)
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
    """Return contact loads of balls with errors ``drawn`` at positions ``layout`` with elastic bodies (`solve_elastic`).

    whole: computes the compliance of a whole body, see `body_compliance`.
    """
    use = all_sides(scene) if drawn.profile.shape[1] else choose_sides(scene, drawn)
    parts = scene, drawn, layout, use, pick_engine(engine, layout.z.size)
    return _loads(solve_sides(ElasticBuild(*parts, backend=backend, whole=whole)))


def _loads(solved: Solution | UnrestrainedProblem) -> ContactLoads:
    if isinstance(solved, UnrestrainedProblem):
        C = solved.problem.C.copy()
        return ContactLoads(np.full(C.shape, np.nan), np.full(C.shape, np.nan), C, solved.status)
    problem, contact, _, _ = solved.system.flanks()[0]
    force = contact[..., 0].copy()
    angle = np.where(force > 0.0, contact_angles(contact[..., 1:3]), np.nan)
    return ContactLoads(force, angle, problem.C.copy(), solved.status)


def nominal(scene: Scene) -> Scene:
    """Return the scene with its preload but without other errors, and without names, on which no number depends.

    Parameters
    ----------
    scene
        Screw or bearing.
    """
    errors = Errors(balls=BallErrors(scene.errors.balls.oversize), lead_offset=scene.errors.lead_offset)
    return replace(scene, name="", title="", assumed=(), errors=errors)


def nominal_contacts(scene: Scene, solved: StaticResult | None = None) -> int:
    """Return the number of contacts that the nominal screw loads; 0 where it loads none or has no equilibrium.

    Parameters
    ----------
    scene
        The scene.
    solved
        A converged result of the scene, whose contacts are counted where it is of `lin` and the scene has no other errors.
    """
    bare = nominal(scene)
    if solved is not None and solved.model == "lin" and bare == replace(scene, name="", title="", assumed=()):
        return int(np.count_nonzero(solved.load > 0.0))
    return _contacts(bare)


@lru_cache(maxsize=256)
def _contacts(scene: Scene) -> int:
    layout = ball_layout(scene)
    try:
        result = beam_loads(scene, specimen(scene, layout), layout)
    except ValueError:  # an impossible scene is reported by its solution
        return 0
    return int(np.count_nonzero(result.load > 0.0)) if result.converged else 0
