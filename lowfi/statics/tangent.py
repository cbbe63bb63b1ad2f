"""Tangent stiffness of a loaded ball screw between one section of the screw and the fixed nut.

The supports of the solved screw are removed, and one cross-section is clamped instead. Six small motions d of the clamp
move the flanks by R_z d. With the stiffness S^T S of all balls, and the compliance G of the bodies with the screw clamped
at this section, the forces and moments at the clamp per unit motion are

    K = (S R_z)^T (I + S G S^T)^-1 (S R_z).                                                                            (1)

K is symmetric and positive semidefinite. It is almost zero for the screw motion along the helix, which no frictionless
contact resists (a small artefact of the balls' planar sections remains, see `lowfi.statics.held`). In the model of a
machine K is the stiffness between a node of the screw and a node of the nut; shaft and bearings are modelled separately.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.lowfi.compliance.parts import REFINED, ComplianceModel
from rollbench.lowfi.statics.elastic import ElasticInput
from rollbench.lowfi.statics.kernel.elastic import write_stiffness_factors
from rollbench.lowfi.statics.problem import Problem
from rollbench.lowfi.statics.selection import choose_flanks, flanks_of_scene
from rollbench.lowfi.statics.shaft import flank_motion_coefficients
from rollbench.lowfi.statics.shape import rigid_motion_transfer_matrix
from rollbench.lowfi.statics.static import UnrestrainedProblem, pick_engine, solve_with_chosen_flanks
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import draw_geometry_with_errors
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import FREEDOMS, Scene, Support

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.bodies import CondensedCompliance


@dataclass(frozen=True)
class TangentStiffness:
    """Tangent stiffness of a loaded ball screw between a cross-section of the screw and the fixed nut."""

    #: Axial position of the cross-section [m].
    station: float
    #: Stiffness matrix ``(6, 6)`` in ux, uy, uz, rx, ry, rz [N/m, N/rad, N m/rad]; nan if the solve did not converge, and
    #: for motions that the model does not have.
    matrix: Array
    #: Whether the solve converged, and if not, the reason.
    status: str

    def rigidity(self, freedom: str) -> float:
        """Return the force or moment per unit of one motion of the cross-section, with rz fixed and all other motions free.

        The stiffness is zero if nothing resists the motion.

        Parameters
        ----------
        freedom
            Name of the motion: ux, uy, uz, rx or ry.
        """
        diagonal = np.diag(self.matrix)
        known = ~np.isnan(diagonal)
        free = [k for k, name in enumerate(FREEDOMS) if name != "rz" and known[k]]
        # rotations are multiplied by a length, to be comparable with displacements
        force, moment = float(diagonal[:3].max()), float(diagonal[3:].max())
        arm = float(np.sqrt(moment / force)) if force > 0.0 and moment > 0.0 else 1.0
        scale = np.where(np.array(free) < 3, 1.0, 1.0 / arm)
        scaled = self.matrix[np.ix_(free, free)] * scale[:, None] * scale[None, :]
        lam, V = np.linalg.eigh(scaled)
        k = free.index(FREEDOMS.index(freedom))
        if np.any((lam <= 1e-9 * lam[-1]) & (np.abs(V[k]) > 1e-6)):
            return 0.0
        kept = lam > 1e-9 * lam[-1]
        return float(1.0 / np.sum(V[k, kept] ** 2 / lam[kept]) / scale[k] ** 2)


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
    parts = scene, drawn, layout, use, pick_engine("auto", layout.z.size)
    solved = solve_with_chosen_flanks(ElasticInput(*parts, backend=backend, condensed_bodies=condensed))
    status = solved.status
    if isinstance(solved, UnrestrainedProblem) or status != "converged":
        return TangentStiffness(station, np.full((6, 6), np.nan), status)
    clamp = Support(station, tuple((name, 0.0) for name in FREEDOMS))
    held = replace(solved.build, scene=replace(scene, supports=(clamp,), loads=()))
    clamped = held.build_equations(held.build_problem())
    return TangentStiffness(station, _stiffness_at_clamp(solved.system, clamped, station), status)


def _stiffness_at_clamp(equations: Any, clamped_equations: Any, station: float) -> Array:
    """Return the tangent stiffness K ``(6, 6)`` [N/m, N, N m] between a clamped section of the screw and the fixed nut.

    It is given by equation (1) of the module.

    Parameters
    ----------
    equations
        Solved equations, which give the stiffness of the balls.
    clamped_equations
        Equations with the screw clamped at the section, which give the compliance of the bodies.
    station
        Axial position of the section [m].
    """
    N, d = equations.state.phi.shape
    rows, counts = np.zeros((N, 6, d)), np.zeros(N, dtype=np.int64)
    write_stiffness_factors(equations.kernel_arrays.contacts, equations.state.contact, rows, counts)
    used = np.arange(6)[None, :] < counts[:, None]
    ball = np.repeat(np.arange(N), counts)
    S = np.zeros((ball.size, N, d))
    S[np.arange(ball.size), ball] = rows[used]
    bodies, by_clamp = clamped_equations.kernel_arrays.bodies, flank_motions_by_clamp(clamped_equations.problem, station)
    A = np.eye(ball.size)
    if equations.only_flank_pair is None:
        screw, nut = S[:, :, :4].reshape(ball.size, 4 * N), S[:, :, 4:].reshape(ball.size, 4 * N)
        A += nut @ bodies.second_compliance @ nut.T
    else:  # the motions are those of the screw's flank relative to the nut's
        screw = S.reshape(ball.size, 2 * N)
        by_clamp = by_clamp.reshape(N, 2, 2, 6)[:, equations.only_flank_pair[0]].reshape(2 * N, 6)
    A += screw @ bodies.first_compliance @ screw.T
    moved = screw @ by_clamp
    K = moved.T @ np.linalg.solve(A, moved)
    return np.asarray(0.5 * (K + K.T))


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
