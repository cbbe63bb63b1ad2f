"""The 3D reference with penalty contacts, whose pressure is proportional to penetration.

An augmented Lagrangian reduces the penetration only where it exceeds a tolerance; below that it acts as a penalty: each
pair of contact nodes has a spring k A in series, with k the penalty [N/m3] and A the area over which the node's pressure
acts. How the position of a contact on its grid changes the result is known only without penetration. This effect is left
out here, so a mesh is needed on which it is small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from rollbench.compare.reference.store import Run
from rollbench.compare.reference.tasks import mesh_settings
from rollbench.hifi.reference import solve_reference
from rollbench.hifi.setup import CondensedGeometry, mesh_and_condense_geometry
from rollbench.meshes.cache import Cache
from rollbench.meshes.parts import Scene

#: Factor on the size of the refined mesh zones at contacts, since contacts with penetration are larger.
LARGER = 1.45


def add_penalty_springs(setup: CondensedGeometry, penalty: float) -> CondensedGeometry:
    """Return the 3D contact problem with a penalty spring added in series at each pair of contact nodes.

    ``setup``: prepared 3D contacts without penalty. The stiffness of a spring is ``penalty`` [N/m3] times the area that
    belongs to its node.
    """
    patches = {
        side: replace(
            pair,
            local_compliance=pair.local_compliance + np.diag(1.0 / (penalty * pair.groove_patch.nodal_areas)),
            gap_correction=None,
        )
        for side, pair in setup.patches_by_flank.items()
    }
    return replace(setup, patches_by_flank=patches)


def solve_with_penalty_contacts(
    scenes: Sequence[Scene], runs: Sequence[Run], penalty_ratio: float, cache: Path | None
) -> list[Run]:
    """Solve scenes of one geometry in 3D with penalty contacts, starting from their solutions without a penalty.

    ``scenes``: ball screws of equal geometry; ``runs``: stored solutions without a penalty, one for each scene;
    ``penalty_ratio``: penalty over E/h, with Young's modulus E of the balls and Lin's element size h; ``cache``: folder for
    intermediate results, or None. Raises ValueError if a solution does not converge.
    """
    settings = mesh_settings(scenes, runs[0].level)
    settings = replace(settings, reach=(LARGER * settings.reach[0], LARGER * settings.reach[1]))
    penalty = penalty_ratio * scenes[0].balls.material.youngs_modulus / settings.tet
    setup = add_penalty_springs(
        mesh_and_condense_geometry(scenes[0], runs[0].sides, settings, scenes=scenes[1:], cache=Cache(cache)), penalty
    )
    out = []
    for scene, run in zip(scenes, runs, strict=True):
        found = solve_reference(setup, scene, frozen=True)
        if found.status != "converged" or found.loads_with_nominal_normals is None:
            raise ValueError(f"scene {scene.name}: no convergence in 3D with penalty contacts, status {found.status!r}")
        changed = replace(
            run,
            scene=scene.name,
            load=found.contact_loads,
            angle=np.degrees(found.contact_angles),
            frozen=found.loads_with_nominal_normals,
            centreline=np.column_stack([found.centreline_positions, found.centreline_motion[:, :3]]),
            settings=run.settings | {"reach": settings.reach, "penalty_N_m3": penalty},
            stages=setup.seconds_by_stage,
            solve_seconds=found.solve_seconds,
        )
        out.append(changed)
    return out
