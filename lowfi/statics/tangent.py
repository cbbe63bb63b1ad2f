"""Tangent stiffness of a solved scene at one section of the screw, against the fixed nut.

The supports of the screw are taken away and its section at the station is clamped. Small motions d (6) of the clamp move
the flanks by R_z d; with the stiffness S^T S of all balls and G the compliance of the bodies, the screw clamped there,

    K = (S R_z)^T (I + S G S^T)^-1 (S R_z),                                                                            (1)

the forces and moments (6) at the clamp per motion: symmetric, not negative, and next to zero along the helix, which no
frictionless contact resists (planar sections of the balls leave a trace: see `lowfi.statics.held`). A machine model
takes it between the screw's node and the nut's, and adds its shaft and bearings.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from rollbench.lowfi.compliance.parts import REFINED, Backend
from rollbench.lowfi.statics.elastic import ElasticBuild
from rollbench.lowfi.statics.kernel.elastic import ball_rows
from rollbench.lowfi.statics.problem import Problem
from rollbench.lowfi.statics.selection import all_sides, choose_sides
from rollbench.lowfi.statics.shaft import rows_of
from rollbench.lowfi.statics.shape import rigid_transport
from rollbench.lowfi.statics.static import UnrestrainedProblem, pick_engine, solve_sides
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import FREEDOMS, Scene, Support

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.bodies import Condensed


@dataclass(frozen=True)
class Tangent:
    """Tangent stiffness at a section of the screw."""

    #: Station of the section [m].
    station: float
    #: ``(6, 6)``, freedoms ux, uy, uz, rx, ry, rz [N/m, N/rad, N m/rad]; nan without convergence, and for freedoms that a
    #: model does not have.
    matrix: Array
    #: How the solution ended.
    status: str

    def rigidity(self, freedom: str) -> float:
        """Return force (moment) per motion of one freedom, with rz fixed and all others free; zero without resistance."""
        known = ~np.isnan(np.diag(self.matrix))
        free = [k for k, name in enumerate(FREEDOMS) if name != "rz" and known[k]]
        arm = self._arm()
        scale = np.where(np.array(free) < 3, 1.0, 1.0 / arm)
        scaled = self.matrix[np.ix_(free, free)] * scale[:, None] * scale[None, :]
        lam, V = np.linalg.eigh(scaled)
        k = free.index(FREEDOMS.index(freedom))
        if np.any((lam <= 1e-9 * lam[-1]) & (np.abs(V[k]) > 1e-6)):
            return 0.0
        kept = lam > 1e-9 * lam[-1]
        return float(1.0 / np.sum(V[k, kept] ** 2 / lam[kept]) / scale[k] ** 2)

    def _arm(self) -> float:
        """Length [m] that makes rotations comparable with displacements."""
        diagonal = np.diag(self.matrix)
        force, moment = float(diagonal[:3].max()), float(diagonal[3:].max())
        return float(np.sqrt(moment / force)) if force > 0.0 and moment > 0.0 else 1.0


def tangent_stiffness(
    scene: Scene, station: float, *, backend: Backend = REFINED, condensed: Condensed | None = None, member: int = 0
) -> Tangent:
    """Return the tangent stiffness at a station of the screw in the equilibrium of a scene, by (1).

    The change of Hertz constants with the contact angle and of the lever arms of uneven profiles is neglected.

    Parameters
    ----------
    scene
        The scene.
    station
        [m].
    backend
        Model of the bodies' compliance.
    condensed
        Compliance from a 3D model instead.
    member
        Number of the specimen, for a scene with random errors.

    Raises
    ------
    ValueError
        A station off the screw, or bodies with impossible dimensions.
    """
    if not 0.0 <= station <= scene.screw.length:
        raise ValueError(f"the screw reaches from 0 to {1e3 * scene.screw.length:g} mm")
    layout = ball_layout(scene)
    drawn = specimen(scene, layout, member)
    every = condensed is not None or "kernel" in (backend.screw, backend.nut) or drawn.profile.shape[1] > 0
    use = all_sides(scene) if every else choose_sides(scene, drawn)  # a beam's compliance lends nothing to contacts
    parts = scene, drawn, layout, use, pick_engine("auto", layout.z.size)
    solved = solve_sides(ElasticBuild(*parts, backend=backend, condensed=condensed))
    status = solved.status
    if isinstance(solved, UnrestrainedProblem) or status != "converged":
        return Tangent(station, np.full((6, 6), np.nan), status)
    clamp = Support(station, tuple((name, 0.0) for name in FREEDOMS))
    held = replace(solved.build, scene=replace(scene, supports=(clamp,), loads=()))
    return Tangent(station, _condensed(solved.system, held.ready(held.problem()), station), status)


def _condensed(solved: Any, clamped: Any, station: float) -> Array:
    """Return K of (1) from the balls of the solved system and the bodies of the clamped one."""
    N, d = solved.state.phi.shape
    rows, counts = np.zeros((N, 6, d)), np.zeros(N, dtype=np.int64)
    ball_rows(solved.given.contacts, solved.state.contact, rows, counts)
    used = np.arange(6)[None, :] < counts[:, None]
    ball = np.repeat(np.arange(N), counts)
    S = np.zeros((ball.size, N, d))
    S[np.arange(ball.size), ball] = rows[used]
    bodies, by_clamp = clamped.given.bodies, flanks_by_clamp(clamped.problem, station)
    A = np.eye(ball.size)
    if solved.pair is None:
        screw, nut = S[:, :, :4].reshape(ball.size, 4 * N), S[:, :, 4:].reshape(ball.size, 4 * N)
        A += nut @ bodies.second @ nut.T
    else:  # motions of the screw's flank less those of the nut's
        screw = S.reshape(ball.size, 2 * N)
        by_clamp = by_clamp.reshape(N, 2, 2, 6)[:, solved.pair[0]].reshape(2 * N, 6)
    A += screw @ bodies.first @ screw.T
    moved = screw @ by_clamp
    K = moved.T @ np.linalg.solve(A, moved)
    return np.asarray(0.5 * (K + K.T))


def flanks_by_clamp(problem: Problem, station: float) -> Array:
    """Return the motions of the screw's flanks by those of a section at ``station`` [m] that moves the screw rigidly.

    Returns
    -------
    Array
        R_z ``(4 N, 6)``, ball after ball (SL x3, z3, SR x3, z3).
    """
    dof, rows = rows_of(problem, [0, 1])
    nodes = np.concatenate([rigid_transport(float(z - station)) for z in problem.nodes])
    if problem.basis is not None:
        nodes = np.linalg.solve(problem.basis, nodes)
    moved = np.einsum("cak,ckj->caj", rows, nodes[dof])
    return np.asarray(moved.reshape(2, -1, 2, 6).transpose(1, 0, 2, 3).reshape(-1, 6))
