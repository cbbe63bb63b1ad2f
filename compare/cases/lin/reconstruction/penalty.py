"""The 3D reference with contacts that a penalty presses apart: pressure in proportion to a penetration that is left.

An augmented Lagrangian lowers the penetration only where it is beyond a tolerance. Below that it is a penalty: each pair of
nodes has a spring k A in series, k the penalty [N/m3], A the area of its pressure hat. What the place on its grid does to a
contact's approach is known where nothing penetrates, and left out: a mesh on which it is small is needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from rollbench.compare.reference.store import Run
from rollbench.compare.reference.tasks import settings_of
from rollbench.hifi.reference import solve_reference
from rollbench.hifi.setup import Setup, prepare
from rollbench.meshes.cache import Cache
from rollbench.meshes.parts import Scene

#: What patches are larger by: a contact that penetrates is.
LARGER = 1.45


def penalised(setup: Setup, penalty: float) -> Setup:
    """The set-up with springs of ``penalty`` [N/m3] times the hat's area in series at every pair of contact nodes."""
    patches = {
        side: replace(pair, local=pair.local + np.diag(1.0 / (penalty * pair.groove.areas)), wave=None)
        for side, pair in setup.patches.items()
    }
    return replace(setup, patches=patches)


def with_penalty(scenes: Sequence[Scene], runs: Sequence[Run], share: float, cache: Path | None) -> list[Run]:
    """Runs of scenes of one geometry, made from those without a penalty; share: of E/h, Young's modulus of the balls
    over the size of the source's elements. Raises ValueError where one does not converge."""
    settings = settings_of(scenes, runs[0].level)
    settings = replace(settings, reach=(LARGER * settings.reach[0], LARGER * settings.reach[1]))
    penalty = share * scenes[0].balls.material.youngs_modulus / settings.tet
    setup = penalised(prepare(scenes[0], runs[0].sides, settings, scenes=scenes[1:], cache=Cache(cache)), penalty)
    out = []
    for scene, run in zip(scenes, runs, strict=True):
        found = solve_reference(setup, scene, frozen=True)
        if found.status != "converged" or found.frozen is None:
            raise ValueError(f"{scene.name}: {found.status}")
        changed = replace(
            run,
            scene=scene.name,
            load=found.load,
            angle=np.degrees(found.contact_angle),
            frozen=found.frozen,
            centreline=np.column_stack([found.stations, found.centreline[:, :3]]),
            settings=run.settings | {"reach": settings.reach, "penalty_N_m3": penalty},
            stages=setup.seconds,
            solve_seconds=found.seconds,
        )
        out.append(changed)
    return out
