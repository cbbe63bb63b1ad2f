"""How many contacts the nominal screw loads: what the mean contact load of a scene is shared out by.

The nominal screw is the scene with its preload (oversize of all balls, lead offset), supports and loads, and without all
other errors of balls and grooves. Its contacts are those that the source's model (`lin`) finds loaded: one number for a
scene, whatever model, mesh or drawn specimen the loads are of.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from rollbench.lowfi.statics.again import beam_loads
from rollbench.lowfi.statics.result import StaticResult
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import BallErrors, Errors, Scene


def nominal(scene: Scene) -> Scene:
    """The scene without errors but for its preload, and without words, on which no number depends."""
    errors = Errors(balls=BallErrors(scene.errors.balls.oversize), lead_offset=scene.errors.lead_offset)
    return replace(scene, name="", title="", assumed=(), errors=errors)


def nominal_contacts(scene: Scene, solved: StaticResult | None = None) -> int:
    """Number of contacts that the nominal screw loads; 0 where it loads none or has no equilibrium.

    solved: a converged result of the scene, which says so itself where it is of `lin` and the scene has no other errors.
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
    except ValueError:  # what makes the scene itself impossible is said by its own solution
        return 0
    return int(np.count_nonzero(result.load > 0.0)) if result.converged else 0
