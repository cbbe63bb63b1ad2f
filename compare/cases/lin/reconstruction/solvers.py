"""The 3D reference with penalty contacts, whose pressure is proportional to penetration, and with sliding friction.

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
from rollbench.hifi.coupling import PlacedNut, compliance_of_supported_screw, normal_motion_of_nodes
from rollbench.hifi.reference import ROUNDS, ContactRound, LoadCase, solve_reference
from rollbench.hifi.setup import CondensedGeometry, mesh_and_condense_geometry
from rollbench.hifi.shaft.beam import ShaftSupports
from rollbench.meshes.arrays import Array
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


class SlidingLoadCase(LoadCase):
    """A load case of the 3D reference in which grooves slide on balls that do not turn, with friction of ``mu`` times load.

    ``mu``: coefficient of friction. Friction resists an axial motion of the screw in the direction of its load; with
    negative ``mu``, an axial motion against its load. The friction forces at both contacts of a ball balance each other. On
    each body, the friction of a contact is applied by normal forces on the contact's nodes, whose resultant is
    perpendicular to the contact load and passes through the centre of the groove's arc. The moment of the friction about
    this centre (arc radius times mu times contact load) is neglected.
    """

    def __init__(self, setup: CondensedGeometry, scene: Scene, mu: float) -> None:
        """Make the load case of one ball screw.

        ``setup``: prepared 3D contacts; ``scene``: screw and loads; ``mu``: coefficient of friction, with its sign.
        """
        super().__init__(
            (PlacedNut(setup, scene, setup.loaded_flanks),),
            ShaftSupports.from_scene(scene),
            compliance_of_supported_screw(setup, scene),
        )
        self.mu, self.smooth, self.still = mu, self.mounted, self.at_rest

    def solve_next_round(self, last: ContactRound, *, moving: bool) -> ContactRound:
        """Return the next iterate of contact loads and motion, with friction from the contact loads of the last iterate.

        ``last``: last iterate; ``moving``: whether normals and gaps of the contacts follow the motion; if not, only the
        gaps are corrected for the position of the contact on the mesh grid.
        """
        across = self.friction_as_normal_forces(last).ravel()
        self.at_rest = self.still + self.C.mode_compliance @ self.C.modal_forces(across)
        self.load_motion = normal_motion_of_nodes(self.C, self.at_rest)
        self.mounted = replace(
            self.smooth,
            work_on_free_motions=self.smooth.work_on_free_motions + last.normal_motion_by_free_motions.T @ across,
        )
        return super().solve_next_round(last, moving=moving)

    def friction_as_normal_forces(self, last: ContactRound) -> Array:
        """Return normal forces [N] on the n contact nodes of each ball that together act as the friction on it, (balls, n).

        The forces act along the nodes' normals. ``last``: iterate of the contact solution, whose loads determine the
        friction.
        """
        (forces,), (normals,), (placed,) = last.nodal_forces_by_set, last.contact_normals, self.sets
        section = placed.geometry.groove_map.section_axes()[[0, 2]]
        out = np.zeros_like(forces)
        for nodes, _ in placed.node_slices_of_flanks:
            for k in np.flatnonzero(forces[:, nodes].any(axis=1)):
                load, n = forces[k, nodes], normals[k, nodes] @ section.T
                x, z = load @ n
                friction = self.mu * np.sign(x * z) * np.array([-z, x])
                out[k, nodes] = load * (n @ np.linalg.solve((load * n.T) @ n, friction))
        return out


def solve_with_sliding_balls(scenes: Sequence[Scene], runs: Sequence[Run], mu: float, cache: Path | None) -> list[Run]:
    """Solve scenes of one geometry in 3D with balls that do not turn, so that the grooves slide on them with friction.

    ``scenes``: ball screws of equal geometry; ``runs``: solutions without friction, one for each scene; ``mu``: coefficient
    of friction, negative where the screw moves against its load; ``cache``: folder for intermediate results, or None.
    Returns the solutions with changed contact loads and contact angles. Raises ValueError if the iteration of load and
    friction does not converge.
    """
    settings = mesh_settings(scenes, runs[0].level)
    setup = mesh_and_condense_geometry(scenes[0], runs[0].sides, settings, scenes=scenes[1:], cache=Cache(cache))
    out = []
    for scene, run in zip(scenes, runs, strict=True):
        ended = SlidingLoadCase(setup, scene, mu).solve(ROUNDS)
        if ended.status != "converged":
            raise ValueError(f"scene {scene.name}: no convergence in 3D with sliding balls, status {ended.status!r}")
        out.append(replace(run, load=ended.contact_loads, angle=np.degrees(ended.contact_angles)))
    return out
