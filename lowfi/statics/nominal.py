"""Contact loads of balls at arbitrary positions, and the number of loaded contacts of a screw without errors.

The mean contact load of a scene is the sum of its contact loads divided by the number of loaded contacts of the nominal
screw. The nominal screw has the preload (oversize of all balls, lead offset), supports and loads of the scene, but no other
errors of balls and grooves. Its loaded contacts are counted by Lin's model. Thus there is one number for a scene, whichever
model, mesh or specimen with random errors is evaluated.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from rollbench.lowfi.compliance.bodies import WholeBody, compliance_between_contacts
from rollbench.lowfi.compliance.parts import LADDER, ComplianceModel
from rollbench.lowfi.statics import static
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.settle import contact_angles
from rollbench.lowfi.together import solve_alone
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import GeometryWithErrors, draw_geometry_with_errors
from rollbench.meshes.helix import BallLayout, ball_layout
from rollbench.meshes.parts import BallErrors, Errors, Scene


@dataclass(frozen=True)
class ContactLoads:
    """Contact forces and contact angles of N balls, without the other results of a static solution."""

    #: Contact forces ``(N, 4)`` [N].
    load: Array
    #: Contact angles ``(N, 4)`` [rad] from the groove's bottom; nan without contact.
    contact_angle: Array
    #: Hertz constants C ``(N, 4)`` [m/N^(2/3)]: approach = C load^(2/3).
    hertz_C: Array
    #: Whether the solve converged, and if not, the reason.
    status: str

    @property
    def converged(self) -> bool:
        """Return whether the solve converged, so that the contact forces are valid."""
        return self.status == "converged"


def contact_loads(
    scene: Scene,
    drawn: GeometryWithErrors,
    layout: BallLayout,
    backend: ComplianceModel = LADDER["lin"],
    whole: WholeBody = compliance_between_contacts,
) -> ContactLoads:
    """Return the contact loads of balls at given positions; without equilibrium forces and angles are nan.

    Parameters
    ----------
    scene
        Screw, nut, balls, supports and loads.
    drawn
        Dimensions of the parts with their manufacturing errors.
    layout
        Positions of the balls.
    backend
        Method by which the compliance of screw, nut and balls is computed; by default they are rigid (Lin's model).
    whole
        Function that computes the compliance of one complete screw or nut between its contacts.
    """
    problem_input = static.static_input(scene, drawn, layout, backend=backend, compute_body_compliance=whole)
    solved = solve_alone(static.solve_with_chosen_flanks(problem_input))
    if isinstance(solved, static.UnrestrainedProblem):
        C = solved.problem.C.copy()
        return ContactLoads(np.full(C.shape, np.nan), np.full(C.shape, np.nan), C, solved.status)
    problem, state = solved.system.problem, solved.system.contact_states()[0]
    force = state.force.copy()
    angle = np.where(force > 0.0, contact_angles(state.normal), np.nan)
    return ContactLoads(force, angle, problem.C.copy(), solved.status)


def nominal_scene(scene: Scene) -> Scene:
    """Return a copy of a scene with nominal dimensions, except for the preload by oversized balls and lead offset.

    Name, title and assumptions are empty, so that scenes with the same nominal dimensions compare as equal.

    Parameters
    ----------
    scene
        Screw or bearing.
    """
    errors = Errors(balls=BallErrors(scene.errors.balls.oversize), lead_offset=scene.errors.lead_offset)
    return replace(scene, name="", title="", assumed=(), errors=errors)


def count_nominal_contacts(scene: Scene, solved: StaticResult | None = None) -> int:
    """Return the number of loaded contacts of a scene without errors except preload; 0 without load or equilibrium.

    Parameters
    ----------
    scene
        Screw, nut, balls, supports and loads.
    solved
        Converged result of the scene, if there is one. Its loaded contacts are counted, without a new solve, if it was
        computed by the model lin and the scene has no errors except preload.
    """
    bare = nominal_scene(scene)
    if solved is not None and solved.model == "lin" and bare == replace(scene, name="", title="", assumed=()):
        return int(np.count_nonzero(solved.load > 0.0))
    return _count_loaded_contacts(bare)


@lru_cache(maxsize=256)
def _count_loaded_contacts(scene: Scene) -> int:
    """Return the number of loaded contacts of a nominal scene, computed by the model lin; the results are cached."""
    layout = ball_layout(scene)
    try:
        result = contact_loads(scene, draw_geometry_with_errors(scene, layout), layout)
    except ValueError:  # the solve of the scene itself reports impossible dimensions
        return 0
    return int(np.count_nonzero(result.load > 0.0)) if result.converged else 0
