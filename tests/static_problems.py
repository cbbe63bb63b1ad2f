"""Scenes of one set of every kind that the static solvers take, and the equations of elastic bodies on them."""

from dataclasses import replace

import numpy as np
from tests.helpers import FLANK_ERRORS, small_screw, with_ingredients

from rollbench.compare.scenes import catalogue
from rollbench.lowfi.compliance.parts import REFINED
from rollbench.lowfi.statics.equations import StaticInput
from rollbench.lowfi.statics.held import find_unresisted_motions
from rollbench.lowfi.statics.static import pin_free_motions
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import BallErrors

#: Scenes on which solvers are compared with one another.
SCENES = {
    name: catalogue.scene(name) for name in ("lin-case1", "lin-case3-offset", "lin-combined", "bearing-9-preload")
} | {
    "clearance": small_screw(count=9, oversize=-5e-6, force=(100.0, 0.0, 1500.0)),
    "source partition": with_ingredients(catalogue.scene("lin-case2"), partition="source"),
    "uneven flanks": replace(
        small_screw(count=9, force=(200.0, -100.0, 1500.0)), errors=replace(FLANK_ERRORS, balls=BallErrors(oversize=2e-6))
    ),
}


def elastic_equations(scene, backend=REFINED, use=(True,) * 4):
    """Equations of a scene with elastic bodies, with the flanks ``use``."""
    layout = ball_layout(scene)
    drawn = draw_geometry_with_errors(scene, layout)
    made = StaticInput(scene, drawn, layout, np.array(use), backend=backend)
    problem = made.build_problem()
    return made.build_equations(pin_free_motions(problem, find_unresisted_motions(problem)))
