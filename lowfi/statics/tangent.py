"""Tangent stiffness of a loaded ball screw between one section of the screw and the fixed nut.

The supports of the solved screw are removed, and one cross-section is clamped instead. Six small motions d of the clamp
move the flanks by R_z d. With the stiffness S^T S of all balls, and the compliance G of the bodies with the screw clamped
at this section, the forces and moments at the clamp per unit motion are

    K = (S R_z)^T (I + S G S^T)^-1 (S R_z).                                                                            (1)

G contains what the clamped section itself yields (`lowfi.statics.shaft`). S belongs to the contact laws of the solved
screw, from which compliance was moved to its bodies; G therefore gets the same change as the bodies of the solved screw.

In Lin's model G is the compliance of the clamped beam; where there are many balls, its sparse stiffness takes the place of
G (`lowfi.statics.equilibrium.BeamBodies`).

K is symmetric and positive semidefinite. It is almost zero for the screw motion along the helix, which no frictionless
contact resists (a small artefact of the balls' planar sections remains, see `lowfi.statics.held`). In the model of a
machine K is the stiffness between a node of the screw and a node of the nut; shaft and bearings are modelled separately.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rollbench.lowfi.compliance.parts import REFINED, ComplianceModel
from rollbench.lowfi.statics.equations import SingleNutEquations, StaticInput
from rollbench.lowfi.statics.equilibrium import Compliances, DenseBodies, small_response
from rollbench.lowfi.statics.problem import Problem
from rollbench.lowfi.statics.rolling_elements import stiffness_factors
from rollbench.lowfi.statics.selection import choose_flanks, flanks_of_scene
from rollbench.lowfi.statics.shaft import flank_motion_coefficients
from rollbench.lowfi.statics.shape import rigid_motion_transfer_matrix
from rollbench.lowfi.statics.static import UnrestrainedProblem, solve_with_chosen_flanks
from rollbench.lowfi.together import solve_alone
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import FREEDOMS, Scene, Support
from rollbench.meshes.quantity import quantity_field, result_record

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.bodies import CondensedCompliance


@result_record(kw_only=True)
class TangentStiffness:
    """Tangent stiffness of a loaded ball screw between a cross-section of the screw and the fixed nut, or of a shaft."""

    station: float = quantity_field("station_mm", "axial position on the shaft at which the 6 x 6 stiffness is taken")
    """Axial position of the cross-section [m]; nan for the stiffness of a housing."""
    status: str = quantity_field("status", show=str)
    """Whether the solve converged, and if not, the reason."""
    freedoms: tuple[str, ...] = quantity_field("freedoms", default=FREEDOMS)
    """Names of the degrees of freedom of the rows and columns: ux, uy, uz, rx, ry, rz."""
    matrix: Array = quantity_field(
        "matrix",
        "row by row: change of force [N] and moment [N m] for a unit displacement [m] or rotation [rad] of the shaft at "
        "this position, with the nut fixed; null in degrees of freedom that a support fixes",
        parts="[][]",
    )
    """Stiffness matrix ``(6, 6)`` [N/m, N/rad, N m/rad]; nan if the solve did not converge, and for motions that the model
    does not have."""


def tangent_stiffness(
    scene: Scene,
    station: float,
    *,
    backend: ComplianceModel = REFINED,
    condensed: CondensedCompliance | None = None,
    member: int = 0,
) -> TangentStiffness:
    """Return the tangent stiffness of a loaded ball screw between a cross-section of the screw and the fixed nut.

    It is the matrix K of equation (1) of the module. Changes of Hertz constants with the contact angle, and of lever arms
    on flanks with profile errors, are neglected.

    Parameters
    ----------
    scene
        Screw, nut, balls, supports and loads.
    station
        Axial position of the screw's section [m].
    backend
        Method by which the compliance of screw, nut and balls is computed.
    condensed
        Compliance of the bodies condensed from a 3D model, in place of a computed one.
    member
        Number of the specimen, for a scene with random errors: each number gives other errors.

    Raises
    ------
    ValueError
        If the position is not on the screw, or a body has impossible dimensions.
    """
    if not 0.0 <= station <= scene.screw.length:
        length = f"{1e3 * scene.screw.length:g} mm"
        raise ValueError(f"the section must lie on the screw, at z from 0 to {length}, got {1e3 * station:g} mm")
    layout = ball_layout(scene)
    drawn = draw_geometry_with_errors(scene, layout, member)
    every = condensed is not None or "kernel" in (backend.screw, backend.nut) or drawn.profile_coefficients.shape[1] > 0
    use = flanks_of_scene(scene) if every else choose_flanks(scene, drawn)  # no negative compliance from beams
    asked = StaticInput(scene, drawn, layout, use, backend=backend, condensed_bodies=condensed)
    solved = solve_alone(solve_with_chosen_flanks(asked))
    status = solved.status
    if isinstance(solved, UnrestrainedProblem) or status != "converged":
        return TangentStiffness(station=station, matrix=np.full((6, 6), np.nan), status=status)
    clamp = Support(station, tuple((name, 0.0) for name in FREEDOMS))
    held = replace(solved.build, scene=replace(scene, supports=(clamp,), loads=()))
    matrix = _stiffness_at_clamp(solved.system, held.build_equations(held.build_problem()), station)
    return TangentStiffness(station=station, matrix=0.5 * (matrix + matrix.T), status=status)


def _stiffness_at_clamp(equations: SingleNutEquations, clamped: SingleNutEquations, station: float) -> Array:
    """Return the tangent stiffness K ``(6, 6)`` [N/m, N, N m] between a clamped section of the screw and the fixed nut.

    It is given by equation (1) of the module.

    Parameters
    ----------
    equations
        Solved equations, which give the stiffness of the balls.
    clamped
        Equations with the screw clamped at the section, which give the compliance of the bodies.
    station
        Axial position of the section [m].
    """
    S, bodies = stiffness_factors(equations.system.elements, equations.state.forces), clamped.system.bodies
    of_solved, of_clamped = equations.flank_compliance, clamped.flank_compliance
    if of_solved is not None and of_clamped is not None:
        changed = zip(of_clamped.as_computed, of_solved.changes_of_bodies, strict=True)
        bodies = DenseBodies(bodies.free, Compliances(*((x.G + change)[None] for x, change in changed)))
    by_clamp, pair = flank_motions_by_clamp(clamped.problem, station).reshape(-1, 2, 2, 6), equations.only_flank_pair
    v = np.zeros((S.shape[1], *S.shape[3:], 6))
    if pair is None:
        v[:, :2] = by_clamp
    else:  # the motions are those of the screw's flank relative to the nut's
        v[:, 0] = by_clamp[:, pair[0]]
    found = small_response(bodies, S, v, np.zeros((0, 6)))
    assert found is not None
    return np.asarray(-v.reshape(-1, 6).T @ found[0].reshape(-1, 6))


def flank_motions_by_clamp(problem: Problem, station: float) -> Array:
    """Return the motions of the screw's flanks per unit motion of a clamped section, if the screw moves as a rigid body.

    Parameters
    ----------
    problem
        Static problem of N balls.
    station
        Axial position of the section [m].

    Returns
    -------
    Array
        R_z ``(4 N, 6)`` of equation (1) of the module. Four rows for each ball: motion of the screw's left flank, radial
        and along the helix's binormal, then of the right flank likewise. Columns: six motions of the section.
    """
    dof, rows = flank_motion_coefficients(problem, [0, 1])
    nodes = np.concatenate([rigid_motion_transfer_matrix(float(z - station)) for z in problem.nodes])
    if problem.rigid_motion_basis is not None:
        nodes = np.linalg.solve(problem.rigid_motion_basis, nodes)
    moved = np.einsum("cak,ckj->caj", rows, nodes[dof])
    return np.asarray(moved.reshape(2, -1, 2, 6).transpose(1, 0, 2, 3).reshape(-1, 6))
