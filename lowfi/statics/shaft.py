"""Screw or shaft as a beam with supports and loads, condensed to the motions of the flanks under the balls.

The condensation is exact for the beam. A beam's sections are rigid, however. In a solid shaft, section forces deform the
grooves and so change the contacts' approach, and contact forces strain the shaft. `SectionForceCoupling` holds this
coupling.

Consider the stretch of shaft under one nut or bearing, cut out of the shaft. Contact loads f act on it, and at its upper
end the wrench F (force and moment) of the shaft above; the lower end carries the resultant. Fixed at its lower end the
stretch has the complementary energy

    f . G f / 2 + f . D^T F + F . H F / 2                                                                              (1)

in addition to that of the beam. G is the compliance of `lowfi.compliance.bodies`. D and H come from
`lowfi.compliance.between` and contain among others Saint-Venant's lateral contraction under tension and bending, and the
warping under shear. The beam has the wrench F = S q from the motions q of its nodes. The stretch adds a jump
d = D f + H F of the motion at its upper cut. With these jumps the beam responds to nodal loads p by
q = K^-1 (p + S^T d), and the wrench is F = S q - k d (k: stiffness of the cut element). With p = L^T f follows

    F = (I + B H)^-1 (A - B D) f,   A = S K^-1 L^T,   B = k - S K^-1 S^T,                                              (2)

where B is the stiffness of the supported shaft against a jump: zero if the shaft is statically determinate. Contacts move
by L q + G f + D^T F. The energy of a body does not depend on the end at which it is fixed, hence the result does not
either, for any number of stretches. The jump of each contact is located at the contact's axial position: sections between
this position and the cut move by it too, and by reciprocity a load on such a section moves the contacts below it.

A load p on a section between the contacts moves them by E p beyond the beam, and contact forces move this section by E^T f.
E is the same whether the section is loaded, supported or only looked at. A support holds the motion q + E^T f, so the beam
there moves by -E^T f, and its reaction r moves the contacts by E r. This is one more jump d = D f with D = -E^T, whose
wrench is F = -r: in equation (2) S is then the support's row of the beam's stiffness matrix with the opposite sign, and H
is zero. With a statically determinate support G becomes G - E R^T - R E^T, R being the contacts' motions by a unit motion
of the support.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.compliance.bodies import screw_response_to_end_wrench, screw_response_to_section_wrench
from rollbench.lowfi.compliance.parts import ComplianceModel
from rollbench.lowfi.statics.beam import (
    BandFactor,
    beam_stiffness_band,
    end_stiffness,
    factor_band,
    nodal_forces,
    substitute,
)
from rollbench.lowfi.statics.problem import BeamProblem
from rollbench.lowfi.statics.shape import (
    independent_columns,
    right_singular_vectors,
    rigid_motion_transfer_matrix,
    thermal_nodal_loads,
)
from rollbench.meshes.arrays import Array
from rollbench.meshes.cache import kept_by_content
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import Scene
from rollbench.meshes.section import MERGE, contact_force_positions

#: Stiffness matrix of a frame, motions of all flanks by its motions, and the functions between its motions and loads.
SparseFrame = tuple[Any, Any, Callable[[Array], Array], Callable[[Array], Array]]
#: Number of load cases of the beam that are solved at a time, to limit memory.
CHUNK = 512
#: Number of beams whose factors and compliances are kept.
KEPT = 8
#: Largest number of corrections of a beam's motions by their residual, and the largest correction, as a fraction of the
#: largest motion, that is the last one: the next would be about its square.
CORRECTIONS, CORRECTED = 4, 1e-8


def _beam_of_flanks(shaft: ShaftBeam, screw_flanks: list[int]) -> tuple[Any, ...]:
    """Return the arrays on which `flank_compliance` depends."""
    lengths = np.diff(shaft.problem.nodes)
    return lengths, shaft.element_sections, shaft.free_dofs, *flank_motion_coefficients(shaft.problem, screw_flanks)


@dataclass
class ShaftBeam:
    """Beam model of a screw with n nodes on its supports.

    If the supports leave k rigid motions of the screw free, one node is held against them ("pinned") in the stiffness
    matrix, and the amplitudes of these motions are additional unknowns.
    """

    #: Arrays of the static problem.
    problem: BeamProblem
    #: Free rigid motions of the screw ``(6, k)``, as motions of the node ``pinned_node`` per metre of amplitude; a
    #: rotation's amplitude is the angle times the pitch radius.
    free_rigid_motions: Array
    #: Work of the external loads on the free rigid motions per metre of amplitude ``(k,)`` [N].
    work_on_free_motions: Array
    #: Number of the node held against free rigid motions ("pinned"), the one nearest to the nut.
    pinned_node: int
    #: Whether each degree of freedom of the nodes is free: neither fixed by a support nor pinned ``(6 n,)``.
    free_dofs: NDArray[np.bool_]
    #: Cholesky factor of the stiffness matrix (`beam.factor_band`).
    stiffness_factor: BandFactor = field(repr=False)
    #: EA [N], EI [N m^2], GJ [N m^2], kappa G A [N] of each element ``(4, n - 1)``.
    element_sections: Array = field(repr=False)

    def with_loads_of(self, problem: BeamProblem) -> ShaftBeam:
        """Return a copy of this beam model under the external loads and prescribed displacements of another problem."""
        work = _work_of_external_loads(problem, self.free_rigid_motions, self.pinned_node)
        return replace(self, problem=problem, work_on_free_motions=work)

    def motions_under_loads(self, loads: Array) -> Array:
        """Return the motions ``(6 n, c)`` [m, rad] of the n nodes under c cases of nodal ``loads`` ``(6 n, c)`` [N, N m].

        Fixed and pinned degrees of freedom do not move. The solution is corrected by its residual, see `beam.nodal_forces`:
        once, but more often on a long shaft with thousands of nodes, where the factor has lost most of its digits.
        """
        out = np.where(self.free_dofs[:, None], loads, 0.0)
        if self.free_dofs.any():
            applied = out.copy()
            substitute(self.stiffness_factor, out)
            for _ in range(CORRECTIONS):
                rest = np.where(self.free_dofs[:, None], applied - self.nodal_forces(out), 0.0)
                substitute(self.stiffness_factor, rest)
                out += rest
                if np.abs(rest).max(initial=0.0) <= CORRECTED * np.abs(out).max(initial=0.0):
                    break
        return out

    @cached_property
    def motions_by_loads(self) -> tuple[Array, Array]:
        """Return the nodal motions ``(6 n,)`` [m, rad] by external loads and prescribed displacements, in two parts.

        If the prescribed displacements agree with a rigid motion of the shaft, this motion is the first part; otherwise the
        first part is zero. The second part is the rest. The rigid part is separated because its round-off, multiplied by
        the stiffness, would appear as a strain of the beam. The motions are computed once.
        """
        problem, held = self.problem, self.problem.fixed
        prescribed = np.where(held, self.problem.prescribed, 0.0)
        moved, loads = np.zeros_like(prescribed), problem.load.ravel()
        if prescribed.any():
            rigid = rigid_motion_transfer_matrix(problem.nodes - problem.nodes[self.pinned_node])
            nearest = rigid @ np.linalg.lstsq(rigid[held], prescribed[held])[0]
            remainder = np.where(held, prescribed - nearest, 0.0)
            if np.abs(remainder).max() <= 1e-12 * np.abs(prescribed).max():
                moved, prescribed = nearest, remainder
            loads = loads - self.nodal_forces(prescribed.ravel())
        return moved.ravel(), prescribed.ravel() + self.motions_under_loads(loads[:, None])[:, 0]

    def nodal_forces(self, q: Array) -> Array:
        """Return the nodal forces K q ``(6 n, ...)`` [N, N m]; K: stiffness matrix, q: nodal motions [m, rad]."""
        return nodal_forces(np.diff(self.problem.nodes), self.element_sections, q)


def rigid_motions_free_of_supports(problem: BeamProblem) -> Array:
    """Return the k rigid motions of the screw that no support prevents ``(6, k)``.

    Each column is the motion of the node nearest to the nut, per metre of amplitude: displacements [m/m] and rotations
    [rad/m]. A rotation's amplitude is the angle times the pitch radius.
    """
    scale, z = motions_per_metre_of_amplitude(problem), problem.nodes
    origin = z[node_nearest_to_nut(problem)]
    rows = rigid_motion_transfer_matrix(z - origin)[problem.fixed] * scale
    if rows.size == 0:
        return np.diag(scale)
    sv, vt = right_singular_vectors(rows)
    rank = int((sv > 1e-9 * sv[0]).sum())
    return np.asarray(scale[:, None] * vt[rank:].T)


def motions_per_metre_of_amplitude(problem: BeamProblem) -> Array:
    """Return the factors ``(6,)`` from amplitudes in metres to the screw's displacements [m/m] and rotations [rad/m].

    The factors are 1 for the three displacements and 1/pitch radius for the three rotations, because a rotation's amplitude
    is the angle times the pitch radius.
    """
    return np.repeat([1.0, 1.0 / problem.moment_arm], 3)


def node_nearest_to_nut(problem: BeamProblem) -> int:
    """Return the number of the node nearest to the nut's centre."""
    return int(np.abs(problem.nodes - problem.middle).argmin())


def build_shaft(problem: BeamProblem) -> ShaftBeam:
    """Return the beam model of a problem's screw with its factored stiffness matrix.

    A rigid screw has no stiffness matrix, only the rigid motions that its supports leave free.
    """
    if problem.rigid_motion_basis is not None:
        motions = np.diag(motions_per_metre_of_amplitude(problem))[:, ~problem.fixed[0]]
        work, free, no = _work_of_external_loads(problem, motions, 0), np.zeros(6, dtype=bool), np.zeros((0, 6, 6))
        return ShaftBeam(problem, motions, work, 0, free, (no, no), np.zeros((4, 0)))
    lengths = np.diff(problem.nodes)
    sections = problem.element_sections or (problem.section,) * lengths.size
    constants = np.array([(s.EA, s.EI, s.GJ, s.kGA) for s in sections]).reshape(-1, 4).T
    band = beam_stiffness_band(lengths, constants)
    motions = rigid_motions_free_of_supports(problem)
    pin = node_nearest_to_nut(problem)
    held = problem.fixed.copy()
    if motions.shape[1]:
        held[pin, independent_columns(motions.T)] = True
    free = ~held.ravel()
    work = _work_of_external_loads(problem, motions, pin)
    factor = _factor_beam_stiffness(band, free)
    return ShaftBeam(problem, motions, work, pin, free, factor, constants)


def _work_of_external_loads(problem: BeamProblem, motions: Array, pin: int) -> Array:
    """Return the work of the external loads on the k free rigid motions, per metre of amplitude ``(k,)`` [N].

    ``motions`` ``(6, k)``: the motions at the node with the number ``pin``. ``problem``: static problem with the loads.
    """
    if problem.rigid_motion_basis is not None:
        return np.asarray(problem.load[0] @ motions)
    at_pin = np.einsum("nij,ni->j", rigid_motion_transfer_matrix(problem.nodes - problem.nodes[pin]), problem.load)
    return np.asarray(motions.T @ at_pin)


@kept_by_content(KEPT, lambda band, free: (band, free))
def _factor_beam_stiffness(band: Array, free: NDArray[np.bool_]) -> BandFactor:
    """Return the Cholesky factor of a beam's stiffness matrix, see `beam.factor_band`.

    ``band`` ``(6 n, 12)``: lower band of the matrix; ``free`` ``(6 n,)``: whether a degree of freedom is free. The others
    are decoupled and get a unit diagonal.
    """
    kept = band.copy()
    for k in range(1, band.shape[1]):
        kept[: len(free) - k, k] *= free[: len(free) - k] & free[k:]
    kept[~free, 0] = 1.0
    return factor_band(kept)


def flank_motion_coefficients(problem: BeamProblem, screw_flanks: list[int]) -> tuple[NDArray[np.int64], Array]:
    """Return which m motions of nodes move each screw flank at each ball, and the flank's motion per unit of each of them.

    Parameters
    ----------
    problem
        Static problem of N balls.
    screw_flanks
        Numbers of the screw flanks in use, 0 for the left one and 1 for the right one. The result has a row for each of
        these flanks at each ball, c = N len(screw_flanks) rows: first all balls of the first flank, then all balls of the
        second.

    Returns
    -------
    tuple[NDArray[np.int64], Array]
        Indices of the m motions among the 6 n motions of all nodes ``(c, m)``, and the motions of the flank per unit of
        them ``(c, 2, m)``: two components in the ball's section plane.
    """
    m = problem.B.shape[3]
    dof = [6 * problem.first_nodes[:, s, None] + np.arange(m) for s in screw_flanks]
    return np.concatenate(dof), np.concatenate([problem.B[:, s] for s in screw_flanks])


@kept_by_content(KEPT, _beam_of_flanks)
def flank_compliance(shaft: ShaftBeam, screw_flanks: list[int]) -> Array:
    """Return how the screw's flanks move by deformation of the beam under contact forces.

    Parameters
    ----------
    shaft
        The beam.
    screw_flanks
        Numbers of the screw flanks in use, 0 for the left one and 1 for the right one. Each counts once per ball, which
        gives c flanks.

    Returns
    -------
    Array
        Compliance ``(2 c, 2 c)`` [m/N] of the flanks by the beam; two components per flank, in the order of
        `flank_motion_coefficients`. It is shared by all beams of equal form and must not be changed.
    """
    problem = shaft.problem
    dof, rows = flank_motion_coefficients(problem, screw_flanks)
    count = rows.shape[0]
    if problem.rigid_motion_basis is not None:
        return np.zeros((2 * count, 2 * count))
    size = 6 * problem.nodes.size
    G = np.zeros((2 * count, 2 * count))
    for start in range(0, 2 * count, CHUNK):
        pick = np.arange(start, min(start + CHUNK, 2 * count))
        loads = np.zeros((size, pick.size))
        loads[dof[pick // 2].T, np.arange(pick.size)] = rows[pick // 2, pick % 2].T
        q = shaft.motions_under_loads(loads)
        G[:, pick] = np.einsum("cak,ckp->cap", rows, q[dof]).reshape(2 * count, pick.size)
    return 0.5 * (G + G.T)


def flank_motions_by_free_motions(shaft: ShaftBeam, screw_flanks: list[int]) -> Array:
    """Return the motions ``(2 c, k)`` of c screw flanks per metre of each free rigid motion, ordered as by loads.

    ``screw_flanks``: numbers of the screw flanks in use (0: left, 1: right).
    """
    dof, rows = flank_motion_coefficients(shaft.problem, screw_flanks)
    if shaft.problem.rigid_motion_basis is not None:
        return rows.reshape(2 * len(rows), -1) @ shaft.free_rigid_motions
    moved = np.einsum("cak,ckp->cap", rows, nodal_motions_of_rigid_screw(shaft)[dof])
    return np.asarray(moved.reshape(2 * len(rows), -1))


def sparse_beam(shaft: ShaftBeam, screw_flanks: list[int], flank_count: int) -> SparseFrame:
    """Return a beam's stiffness matrix and the motions of the flanks by its degrees of freedom, as sparse matrices.

    Parameters
    ----------
    shaft
        The beam.
    screw_flanks
        Numbers of the screw flanks in use (0: left, 1: right).
    flank_count
        Number of flanks of each ball in the rows of the second matrix: four, or one for a flank pair.

    Returns
    -------
    SparseFrame
        Stiffness matrix of the free degrees of freedom; motions ``(2 N flank_count, ...)`` of all flanks, ordered by ball,
        flank and component; function from loads on the free degrees of freedom ``(...,)`` to their motions; and function
        from motions ``(..., c)`` to loads.
    """
    from scipy.sparse import coo_array, dia_array

    free, size = np.flatnonzero(shaft.free_dofs), shaft.free_dofs.size
    band = np.zeros((12, size))
    if shaft.element_sections.size:
        band[:] = beam_stiffness_band(np.diff(shaft.problem.nodes), shaft.element_sections).T
    lower = dia_array((band, -np.arange(len(band))), shape=(size, size)).tocsr()
    K = (lower + lower.T - dia_array((band[:1], [0]), shape=(size, size))).tocsc()[free][:, free]
    dof, rows = flank_motion_coefficients(shaft.problem, screw_flanks)
    N = len(shaft.problem.first_nodes)
    places = np.array([0] if flank_count == 1 else screw_flanks)
    flank = (flank_count * np.arange(N)[None, :] + places[:, None]).ravel()
    at = np.broadcast_to(2 * flank[:, None, None] + np.arange(2)[:, None], rows.shape)
    columns = np.broadcast_to(dof[:, None, :], rows.shape)
    L = coo_array((rows.ravel(), (at.ravel(), columns.ravel())), shape=(2 * N * flank_count, size)).tocsc()[:, free]

    def moved(loads: Array) -> Array:
        every = np.zeros((size, 1))
        every[free, 0] = loads
        return np.asarray(shaft.motions_under_loads(every)[free, 0])

    def loads(motions: Array) -> Array:
        every = np.zeros((size, motions.shape[1]))
        every[free] = motions
        return shaft.nodal_forces(every)[free] if free.size else motions

    return K, L.tocsr(), moved, loads


def flank_motions_by_loads(shaft: ShaftBeam, screw_flanks: list[int]) -> Array:
    """Return the motions ``(2 c,)`` [m] of c screw flanks that external loads and prescribed displacements cause.

    ``screw_flanks``: numbers of the screw flanks in use (0: left, 1: right). Each counts once per ball, which gives c
    flanks: first all balls of the first flank, then all balls of the second, each with two components in the ball's section
    plane.
    """
    problem = shaft.problem
    dof, rows = flank_motion_coefficients(problem, screw_flanks)
    if problem.rigid_motion_basis is not None:
        return np.asarray(rows.reshape(2 * len(rows), -1) @ np.where(problem.fixed[0], problem.prescribed[0], 0.0))
    return np.asarray(np.einsum("cak,ck->ca", rows, np.add(*shaft.motions_by_loads)[dof]).ravel())


def nodal_motions_of_rigid_screw(shaft: ShaftBeam) -> Array:
    """Return the motions ``(6 n, k)`` [m, rad] of all n nodes per metre of each of the k free rigid motions."""
    z = shaft.problem.nodes
    motions = rigid_motion_transfer_matrix(z - z[shaft.pinned_node]) @ shaft.free_rigid_motions
    return np.asarray(motions.reshape(6 * z.size, -1))


def nodal_motions_under_loads(shaft: ShaftBeam, loads: Array, amplitudes: Array) -> Array:
    """Return the nodal motions ``(n, 6, ...)`` [m, rad] by external loads, further nodal loads, and free rigid motions.

    Parameters
    ----------
    shaft
        The beam.
    loads
        Nodal loads ``(6 n, ...)`` [N, N m] in addition to the external loads; a further axis are load cases.
    amplitudes
        Amplitudes of the free rigid motions ``(k, ...)`` [m].
    """
    problem, cases = shaft.problem, loads.shape[1:]
    if problem.rigid_motion_basis is not None:
        given, moved = np.where(problem.fixed, problem.prescribed, 0.0), shaft.free_rigid_motions @ amplitudes
        return given.reshape(1, 6, *np.ones(len(cases), dtype=int)) + moved.reshape(1, 6, *cases)
    moved, bent = shaft.motions_by_loads
    q = shaft.motions_under_loads(loads.reshape(len(loads), -1)) + bent[:, None]
    rigid = nodal_motions_of_rigid_screw(shaft) @ amplitudes.reshape(amplitudes.shape[0], q.shape[1])
    return np.asarray((moved[:, None] + q + rigid).reshape(-1, 6, *cases))


def nodal_forces_under_loads(shaft: ShaftBeam, loads: Array) -> Array:
    """Return the forces and moments ``(n, 6)`` [N, N m] on the beam's nodes: external and further loads, and reactions.

    The result is the stiffness matrix times the nodal motions of `nodal_motions_under_loads`. ``loads`` ``(6 n,)`` [N, N
    m]: nodal loads in addition to the external loads.
    """
    return shaft.nodal_forces(shaft.motions_by_loads[1] + shaft.motions_under_loads(loads[:, None])[:, 0]).reshape(-1, 6)


def nodal_loads_of_flank_forces(problem: BeamProblem, forces: Array, screw_flanks: list[int]) -> Array:
    """Return the nodal loads ``(6 n,)`` [N, N m] equivalent to the contact forces ``(c, 2)`` [N] on the screw's flanks.

    ``screw_flanks``: numbers of the screw flanks in use (0: left, 1: right). Each counts once per ball, which gives c
    flanks: first all balls of the first flank, then all balls of the second.
    """
    dof, rows = flank_motion_coefficients(problem, screw_flanks)
    out = np.zeros(6 * problem.nodes.size)
    np.add.at(out, dof, np.einsum("cak,ca->ck", rows, forces))
    return out


Ints = NDArray[np.int64]


@dataclass(frozen=True)
class ShaftStretch:
    """Part of the shaft under one nut or bearing, whose cross-sections deform, unlike the rigid sections of a beam.

    The part is considered cut out of the shaft at its upper end, the end at the larger axial position; see the module.
    """

    #: Indices ``(m,)`` of the m flank motions of this stretch (two per flank and ball) among those of all flanks of the
    #: shaft.
    flank_motion_indices: Ints
    #: Axial position of the contact to which each of the m flank motions belongs ``(m,)`` [m].
    contact_positions: Array
    #: Motions of the flanks per unit force and moment at the upper end of the stretch, where it is cut from the shaft
    #: ``(m, 6)``: D^T of equation (1) of the module.
    flank_motions_per_wrench: Array
    #: Additional motion ("jump") of the shaft at the upper end of the stretch, by deformation of the stretch, per unit
    #: force and moment at this end ``(6, 6)``: H of equation (1) of the module.
    jump_per_wrench: Array
    #: Number of the node at the upper end of the stretch, at larger z than all its contacts.
    cut_node: int
    #: For each node within the stretch that is loaded, supported or looked at, by its number: motions of the flanks per
    #: unit load on the node ``(m, 6)``, without those that the shaft's section force and moment at the contacts cause.
    flank_motions_by_node_load: dict[int, Array]
    #: The same for nodes with supports, with those by section force and moment: E of the module ``(m, 6)``.
    flank_motions_by_reaction: dict[int, Array]


@dataclass(frozen=True)
class SectionForceCoupling:
    """Coupling of contact deformation and section forces of a shaft, which is cut at the upper ends of nuts and bearings.

    It is equation (2) of the module. The shaft has n nodes, and c flanks under the balls. Its section forces deform the
    grooves and so move the flanks; contact forces in turn strain the shaft. A cut is the upper end of the part of the shaft
    under a nut or bearing; each cut through which load passes contributes 6 components of section force and moment
    ("wrench"), W in all. A jump is the motion that the deformation of this part adds to the beam's motion at the cut, see
    the module. Only ``flank_motions_by_loads`` and ``jumps_by_external_loads`` depend on the external loads.
    """

    #: Compliance ``(2 c, 2 c)`` [m/N] of the c flanks, two motions each, that the coupling adds to the compliance of beam
    #: and bodies.
    added_compliance: Array
    #: Motions of the c flanks ``(2 c,)`` [m] that the coupling adds to those of the beam under external loads and
    #: prescribed displacements.
    flank_motions_by_loads: Array
    #: Section forces and moments at the cuts, W components in all, per unit motion of the n nodes ``(W, 6 n)``: S of
    #: equation (2) of the module.
    wrenches_per_nodal_motion: Array
    #: Wrench components per unit load on the nodes ``(W, 6 n)``: 1 where a support takes a load on its own node, else 0.
    wrenches_per_nodal_load: Array
    #: Motions of the c flanks per unit of the W section forces and moments at the cuts, for the beam without coupling
    #: ``(2 c, W)``.
    flank_motions_per_wrench: Array
    #: Motions of the n nodes per unit of the W section forces and moments at the cuts, for the beam without coupling
    #: ``(6 n, W)``.
    nodal_motions_per_wrench: Array
    #: Jumps of the shaft's motion at the cuts (W components) per unit force on the c flanks ``(W, 2 c)``.
    jumps_per_flank_force: Array
    #: Jumps of the shaft's motion at the cuts (W components) by external loads ``(W,)`` [m, rad].
    jumps_by_external_loads: Array
    #: Arrays of the static problem.
    problem: BeamProblem
    #: Parts of the shaft under nuts and bearings.
    stretches: Sequence[ShaftStretch]
    #: Jumps of the shaft's motion at the cuts per unit of the W section forces and moments there ``(W, W)``.
    jumps_per_wrench: Array

    def _motions_per_jump(self, stretch: ShaftStretch) -> tuple[Array, Ints]:
        """Return the motions of nodes per unit jump at the cut of a stretch, and the first node above each contact.

        A stretch is the part of the shaft under a nut or bearing, its cut is its upper end. A jump is the motion, taken at
        the cut, that the deformation of the stretch under a contact force adds to the shaft above the contact. The first
        array ``(m, 6, 6)`` has the axes node, motion of the node and component of the jump; it covers the m nodes up to the
        cut, or all nodes if the shaft carries no load above the cut. The second array holds for each flank motion of the
        stretch the number of the first node above its contact.
        """
        nodes = self.problem.nodes
        z = nodes[: stretch.cut_node + 1] if is_loaded_above_node(self.problem, stretch.cut_node) else nodes
        above = np.searchsorted(z, stretch.contact_positions - MERGE)
        return rigid_motion_transfer_matrix(z - nodes[stretch.cut_node]), above

    def nodal_motions_by_flank_forces(self, pushes: Array) -> Array:
        """Return the motions ``(6 n,)`` [m, rad] of the n nodes by the jumps that the contact forces on c flanks cause.

        A jump is the motion of the shaft above a contact that the contact force causes by deformation of the part of the
        shaft under the nut or bearing; the motion of the beam is not included. ``pushes`` ``(2 c,)`` [N]: forces on the
        flanks, two components in the ball's section plane each.
        """
        out = np.zeros((self.problem.nodes.size, 6))
        for x in self.stretches:
            moves, first = self._motions_per_jump(x)
            jumps = np.zeros((len(moves) + 1, 6))
            np.add.at(jumps, first, x.flank_motions_per_wrench * pushes[x.flank_motion_indices, None])
            out[: len(moves)] += np.einsum("nij,nj->ni", moves, jumps.cumsum(axis=0)[:-1])
            for node, beyond in x.flank_motions_by_node_load.items():
                out[node] += pushes[x.flank_motion_indices] @ beyond
        return out.ravel()

    def flank_motions_by_nodal_loads(self, loads: Array) -> Array:
        """Return the motions ``(2 c, k)`` [m] of c flanks by k cases of nodal ``loads`` ``(6 n, k)`` [N, N m].

        Only the motions by deformation of the parts of the shaft under nuts and bearings are returned, without those of the
        beam. By Maxwell's reciprocity, the matrix from the loads to these motions is the transpose of the matrix from flank
        forces to nodal motions in `nodal_motions_by_flank_forces`.
        """
        out, nodal = (
            np.zeros((len(self.added_compliance), loads.shape[1])),
            loads.reshape(len(loads) // 6, 6, loads.shape[1]),
        )
        for x in self.stretches:
            moves, first = self._motions_per_jump(x)
            wrenches = np.zeros((len(moves) + 1, *nodal.shape[1:]))
            wrenches[:-1] = np.einsum("nij,nik->njk", moves, nodal[: len(moves)])
            at_contacts = wrenches[::-1].cumsum(axis=0)[::-1][first]
            out[x.flank_motion_indices] += np.einsum("cj,cjk->ck", x.flank_motions_per_wrench, at_contacts)
            for node, beyond in x.flank_motions_by_node_load.items():
                out[x.flank_motion_indices] += beyond @ nodal[node]
        return out

    def under_loads_of(
        self, shaft: ShaftBeam, thermal: Array | float = 0.0, thermal_loads: Array | float = 0.0
    ) -> SectionForceCoupling:
        """Return a copy of the coupling for the external loads and prescribed displacements of another beam model.

        Parameters
        ----------
        shaft
            The beam with its loads.
        thermal
            Section forces and moments at the cuts ``(W,)`` [N, N m] that stand for free thermal expansion, which causes no
            stress; they are subtracted.
        thermal_loads
            Nodal loads ``(n, 6)`` [N, N m] among those of the beam that stand for it; they are subtracted too.
        """
        wrench = self.wrenches_per_nodal_motion @ shaft.motions_by_loads[1] - thermal
        wrench += self.wrenches_per_nodal_load @ shaft.problem.load.ravel()
        real = shaft.problem.load - thermal_loads
        inside = self.flank_motions_by_nodal_loads(real.reshape(-1, 1))[:, 0]
        moved = self.flank_motions_per_wrench @ wrench + inside
        return replace(self, flank_motions_by_loads=moved, jumps_by_external_loads=self.jumps_per_wrench @ wrench)

    def nodal_loads_of_jumps(self, pushes: Array) -> Array:
        """Return the nodal loads ``(6 n,)`` [N, N m] on the beam that are equivalent to the jumps at the cuts.

        A cut is the upper end of the part of the shaft under a nut or bearing. A jump is the motion at the cut that the
        deformation of this part adds to the motion of the beam, under external loads and under forces on the flanks.
        ``pushes`` ``(2 c,)`` [N]: these forces, two components for each of the c flanks of the shaft.
        """
        jumps = self.jumps_per_flank_force @ pushes + self.jumps_by_external_loads
        return np.asarray(self.wrenches_per_nodal_motion.T @ jumps)

    def add_jumps_inside_stretches(self, motion: Array, pushes: Array, fixed: NDArray[np.bool_]) -> Array:
        """Return nodal motions ``(n, 6)`` [m, rad] plus the shifts of the nodes under nuts and bearings by contact forces.

        A force on a flank deforms the part of the shaft under the nut or bearing, and so shifts the shaft's sections
        between the contact and that end of this part which has the larger axial coordinate.

        Parameters
        ----------
        motion
            Motions of the nodes ``(n, 6)`` [m, rad] without this shift; the array is not changed.
        pushes
            Forces on the c screw flanks ``(2 c,)`` [N], two components each.
        fixed
            Which degrees of freedom are fixed ``(n, 6)``; nothing is added to them.
        """
        shift = self.nodal_motions_by_flank_forces(pushes.ravel()).reshape(-1, 6)
        return np.where(fixed, motion, motion + shift)

    def motions_by_loads(self, loads: Array, motions: Array) -> tuple[Array, Array]:
        """Return the motions of flanks ``(2 c, k)`` [m] and nodes ``(6 n, k)`` [m, rad] by the coupling under k load cases.

        Parameters
        ----------
        loads
            Nodal loads ``(6 n, k)`` [N, N m].
        motions
            Motions of the beam's nodes ``(6 n, k)`` [m, rad] under these loads without the coupling.
        """
        wrench = self.wrenches_per_nodal_motion @ motions + self.wrenches_per_nodal_load @ loads
        inside = self.flank_motions_by_nodal_loads(loads)
        return self.flank_motions_per_wrench @ wrench + inside, self.nodal_motions_per_wrench @ wrench


def build_shaft_stretch(
    problem: BeamProblem,
    scene: Scene,
    layout: BallLayout,
    backend: ComplianceModel,
    screw_flanks: Sequence[int],
    balls: slice,
    read: Sequence[float] = (),
) -> ShaftStretch | None:
    """Return the part of the shaft under the balls of one nut or bearing; None if it is rigid or no flank is in use.

    Parameters
    ----------
    problem
        Static problem of all balls on the shaft.
    scene
        The nut or bearing with its part of the shaft.
    layout
        Positions of its balls.
    backend
        Method by which the compliance of the shaft is computed.
    screw_flanks
        Numbers of the screw flanks in use, 0 for the left one and 1 for the right one.
    balls
        Indices of its balls among all balls of the problem.
    read
        Further axial positions [m] whose motion is asked for: nodes there respond to contact forces as loaded ones do.
    """
    response = None if problem.rigid_motion_basis is not None else screw_response_to_end_wrench(scene, layout, backend)
    if response is None or not screw_flanks:
        return None
    cut = int(problem.first_nodes[balls][:, list(screw_flanks)].max()) + (problem.B.shape[3] == 12)
    N, first = problem.first_nodes.shape[0], np.arange(layout.z.size) + range(problem.first_nodes.shape[0])[balls].start
    places = np.array([2 * (k * N + first)[:, None] + np.arange(2) for k in range(len(screw_flanks))], dtype=np.int64)
    up = rigid_motion_transfer_matrix(float(problem.nodes[cut]) - response.high_end)
    feel = response.contact_motions.reshape(2, -1, 6)[list(screw_flanks)].reshape(-1, 6) @ up.T
    stations = np.repeat(contact_force_positions(scene, layout)[:, list(screw_flanks)].T.ravel(), 2)
    sections, held = {}, {}
    looked_at = np.abs(problem.nodes[:cut, None] - np.append(section_positions(scene, layout), read)).min(axis=1) <= MERGE
    for node in np.flatnonzero(looked_at | problem.load[:cut].any(axis=1) | problem.fixed[:cut].any(axis=1)).tolist():
        at = float(problem.nodes[node])
        if response.low_end < at:
            of_both = screw_response_to_section_wrench(scene, layout, backend, at).reshape(2, -1, 6)
            by_section = of_both[list(screw_flanks)].reshape(-1, 6)
            felt = feel @ rigid_motion_transfer_matrix(at - float(problem.nodes[cut])).T
            sections[node] = by_section - np.where(stations[:, None] - MERGE <= at, felt, 0.0)
            if problem.fixed[node].any():
                held[node] = by_section
    return ShaftStretch(places.ravel(), stations, feel, up @ response.end_motions @ up.T, cut, sections, held)


def section_positions(scene: Scene, layout: BallLayout) -> Array:
    """Return the axial positions [m] of the screw's sections whose motion is that of the screw in its nut.

    It is the nut's centre; of a bearing, where its contacts load the shaft. ``layout``: positions of the balls.
    """
    return np.array([scene.nut.position]) if scene.track.lead else np.unique(contact_force_positions(scene, layout))


def is_loaded_above_node(problem: BeamProblem, cut: int) -> bool:
    """Return whether a support, load or contact acts on the beam above a cut, so that the cut carries a section force.

    Parameters
    ----------
    problem
        Static problem.
    cut
        Number of the node at which the shaft is cut; nodes with larger numbers are above it.
    """
    beyond = slice(cut + 1, None)
    return bool(problem.fixed[beyond].any() or problem.load[beyond].any() or (problem.first_nodes > cut).any())


def stiffness_at_cut(problem: BeamProblem, cut: int) -> tuple[Array, Array]:
    """Return the stiffness of the beam element above a cut: force and moment ("wrench") at the cut per unit motion.

    Parameters
    ----------
    problem
        Static problem.
    cut
        Number of the node at the cut.

    Returns
    -------
    tuple[Array, Array]
        Two values: k ``(6, 6)``, decrease of the wrench per unit jump (a jump is the motion that the deformation of the
        shaft under a nut or bearing adds at the cut); S ``(6, 12)``, wrench per unit motion of the element's two nodes.
    """
    section = problem.section if problem.element_sections is None else problem.element_sections[cut]
    length = float(problem.nodes[cut + 1] - problem.nodes[cut])
    k = end_stiffness(length, np.array([section.EA, section.EI, section.GJ, section.kGA]))
    T = rigid_motion_transfer_matrix(length)
    return T.T @ k @ T, T.T @ k @ np.hstack([-T, np.eye(6)])


def couple_section_forces(
    shaft: ShaftBeam, screw_flanks: Sequence[int], all_stretches: Sequence[ShaftStretch | None], strain: float = 0.0
) -> SectionForceCoupling | None:
    """Return the coupling between contact deformation and section forces of a shaft; None if it is not modelled.

    Parameters
    ----------
    shaft
        The beam.
    screw_flanks
        Numbers of the screw flanks in use, 0 for the left one and 1 for the right one.
    all_stretches
        Part of the shaft under each nut and bearing; None for a part that is modelled as rigid. If all are rigid, the
        coupling is not modelled.
    strain
        Free thermal strain of the shaft, dimensionless; it causes no section forces.
    """
    stretches = [x for x in all_stretches if x is not None]
    if not stretches:
        return None
    problem = shaft.problem
    dof, rows = flank_motion_coefficients(problem, list(screw_flanks))
    count = 2 * len(rows)
    loaded = [x for x in stretches if is_loaded_above_node(problem, x.cut_node)]
    held = [
        (x, node, k) for x in stretches for node in x.flank_motions_by_reaction for k in np.flatnonzero(problem.fixed[node])
    ]
    cuts, W = 6 * len(loaded), 6 * len(loaded) + len(held)
    S, P, k, warm = (
        np.zeros((W, 6 * problem.nodes.size)),
        np.zeros((W, 6 * problem.nodes.size)),
        np.zeros((W, W)),
        np.zeros(W),
    )
    sections = (
        [problem.section] * (problem.nodes.size - 1) if problem.element_sections is None else problem.element_sections
    )
    D, H = np.zeros((W, count)), np.zeros((W, W))
    for i, x in enumerate(loaded):
        block = slice(6 * i, 6 * i + 6)
        stiff, S[block, 6 * x.cut_node : 6 * x.cut_node + 12] = stiffness_at_cut(problem, x.cut_node)
        for j, other in enumerate(loaded):  # jumps at the same cut share the stiffness of one element
            if other.cut_node == x.cut_node:
                k[block, 6 * j : 6 * j + 6] = stiff
        D[block, x.flank_motion_indices], H[block, block] = x.flank_motions_per_wrench.T, x.jump_per_wrench
        warm[6 * i + 2] = sections[x.cut_node].EA * strain
    for i, (x, node, freedom) in enumerate(held, cuts):
        P[i, 6 * node + freedom] = 1.0
        S[i] = -shaft.nodal_forces(P[i])
        D[i, x.flank_motion_indices] = -x.flank_motions_by_reaction[node][:, freedom]
    X = shaft.motions_under_loads(S.T) + P.T
    A = np.einsum("cak,ckw->wca", rows, X[dof]).reshape(W, count)
    B = k - S @ X
    B[:, :cuts] -= P @ S[:cuts].T
    M = np.linalg.inv(np.eye(W) + 0.5 * (B + B.T) @ H)
    per_wrench, by_forces = (D.T + A.T @ H) @ M, A - B @ D
    added = A.T @ D + per_wrench @ by_forces
    compliance, jumps, none = 0.5 * (added + added.T), H @ M, np.zeros(0)
    by_flanks = D + jumps @ by_forces
    coupling = SectionForceCoupling(
        compliance, none, S, P, per_wrench, X @ H @ M, by_flanks, none, problem, stretches, jumps
    )
    return coupling.under_loads_of(shaft, warm, thermal_nodal_loads(np.array([s.EA for s in sections]), strain))
