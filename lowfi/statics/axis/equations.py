"""Equations of a shaft with several bearings and ball nuts, on its supports and housings.

The shaft is a beam on its supports, housings are rigid. In the model lin all other bodies are rigid too. In the models with
elastic bodies the screw, nut and balls of one bearing or nut deform under their own contact forces as in the model of a
single one (`lowfi.compliance`); different bearings and nuts affect each other only through the beam, the housings, and the
beam's section forces, which change the contacts' approach (`lowfi.statics.shaft`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, cho_factor, cho_solve

from rollbench.lowfi.compliance.bodies import ball_compliance, body_compliance
from rollbench.lowfi.compliance.parts import ComplianceModel, grooved_section, reduce_to_compliance_geometry
from rollbench.lowfi.statics import response
from rollbench.lowfi.statics import shaft as statics_shaft
from rollbench.lowfi.statics.axis import system as axis_system
from rollbench.lowfi.statics.axis.structure import Structure, first_ball_nut, largest_spring_force_term
from rollbench.lowfi.statics.axis.system import AssemblyArrays, BallSet, all_rollers
from rollbench.lowfi.statics.contacts import hertz_without_errors, oblique_pressure_coefficient
from rollbench.lowfi.statics.equilibrium import (
    BeamBodies,
    Compliances,
    DenseBodies,
    FreeMotions,
    StaticSystem,
    small_response,
)
from rollbench.lowfi.statics.problem import BeamProblem, ContactState, Problem
from rollbench.lowfi.statics.rolling_elements import (
    RollingElements,
    slice_forces,
    starting_springs,
    starting_springs_of_rollers,
    stiffness_factors,
)
from rollbench.lowfi.statics.settle import (
    FORCE_SETTLED,
    StaticEquations,
    least_typical_force,
    limits_of,
    residual_by_round_off,
)
from rollbench.lowfi.statics.shape import independent_columns, rigid_motion_transfer_matrix
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.section import BeamSection

#: Least typical contact force [N], at which the contact law of a set without load is evaluated.
LEAST_FORCE = 1e-6
#: Number of balls and rollers above which rigid bodies on a shaft are solved by its sparse stiffness matrix, which has more
#: round-off on long shafts.
SPARSE = 300


@dataclass(frozen=True)
class Housings:
    """The m moving housings of an assembly and the springs between them, as one linear elastic system.

    If no spring resists k rigid motions of the housings, k degrees of freedom are fixed in the stiffness matrix, and the
    amplitudes of these motions are additional unknowns.
    """

    #: Indices of the degrees of freedom that are free in the stiffness matrix: neither supported nor fixed against a rigid
    #: motion.
    free_dof_indices: NDArray[np.int64]
    #: Cholesky factor of the stiffness matrix of the free degrees of freedom; None: there are none.
    stiffness_factor: tuple[Array, bool] | None
    #: Stiffness matrix of all degrees of freedom ``(6 m, 6 m)``.
    stiffness: Array
    #: Rigid motions ``(6 m, k)`` that no spring resists, per metre of amplitude.
    free_rigid_motions: Array
    #: Motions ``(6 m,)`` [m, rad] of the housings that external loads and prescribed displacements cause.
    motions_by_external_loads: Array
    #: Work of the external loads on the k rigid motions that no spring resists, per metre of amplitude ``(k,)`` [N].
    work_on_free_motions: Array

    def motions_under_loads(self, loads: Array) -> Array:
        """Return the housings' motions ``(6 m, c)`` [m, rad] under c load cases ``loads`` ``(6 m, c)`` [N, N m].

        Prescribed displacements and rigid motions that no spring resists are taken as zero.
        """
        out = np.zeros_like(loads)
        if self.stiffness_factor is not None:
            out[self.free_dof_indices] = cho_solve(self.stiffness_factor, loads[self.free_dof_indices])
        return out


@dataclass(kw_only=True)
class AssemblyEquations(StaticEquations):
    """Equations of an assembly (shaft, bearings, nuts, m moving housings) with N balls and rollers."""

    #: Shaft, housings, bearings and nuts of the assembly as arrays.
    assembly_arrays: AssemblyArrays
    #: Method by which the compliance of screws, nuts and balls is computed; None: they are rigid (model lin).
    backend: ComplianceModel | None
    #: The shaft as a beam on its supports, with all balls and rollers as one contact problem.
    shaft: statics_shaft.ShaftBeam
    #: The moving housings with the springs that hold them.
    housings: Housings
    #: Motions of the flanks of nuts and outer rings (two flanks with two components for each of N balls and rollers) per
    #: unit motion of the m housings ``(4 N, 6 m)``.
    outer_by_housings: Array
    #: Motions of the flanks of those inner rings that sit on housings, per unit motion of the m housings ``(4 N, 6 m)``.
    inner_by_housings: Array
    #: For each ball bearing or nut with n balls, two compliance matrices ``(4 n, 4 n)`` [m/N]: motions of the flanks of its
    #: screw (or inner ring), and of its nut (or outer ring), per unit contact force of the same bearing or nut; None: rigid
    own_compliances: list[tuple[Array, Array]] | None
    #: Assumptions about the bodies, as sentences for the report.
    assumed: tuple[str, ...]
    #: Coupling of the shaft's section forces, which deform its grooves, with the contacts' approaches; None: not modelled.
    coupling: statics_shaft.SectionForceCoupling | None
    #: Typical contact force of each ball nut and ball bearing [N], at which the terms of its contact law are evaluated.
    typical_forces: list[float]
    #: Least typical force of each of them by a solution [N], see `typical_contact_forces`; None: estimated.
    known_forces: list[float] | None

    @property
    def problems(self) -> Sequence[Problem]:
        """Return the contact problem of each ball nut and ball bearing."""
        return [b.problem for b in self.assembly_arrays.ball_sets]

    def contact_states(self) -> Sequence[ContactState]:
        """Return contact forces, ball centres and flank motions of each bearing and nut, as the iteration has them now."""
        forces, arrays = self.state.forces, self.assembly_arrays
        contacts, moved = forces.contacts, self.state.motions[0, : arrays.ball_count]
        of = contacts.force[0], contacts.normal[0], contacts.tangential[0], forces.centres[0], moved
        return [ContactState(b.problem, *(x[b.ball_indices] for x in of)) for b in arrays.ball_sets]

    def with_lever_arms(self, arms: Sequence[Array]) -> Self:
        """Return these equations with other lever arms of the contact forces; the next solution starts from this state.

        ``arms``: for each bearing or nut with N balls, the shifts ``(N, 4, 2)`` [m] of the flanks' centres of curvature by
        profile errors; contact forces act through these centres.
        """
        arrays = axis_system.replace_lever_arms(self.assembly_arrays, arms)
        longer: Any = assembly_equations(arrays, self.backend, self.known_forces).start_from(self)
        return longer  # type: ignore[no-any-return]

    def at_forces_of_solution(self) -> Self:
        """Return equations whose typical contact forces fit the present state; the same ones if they do already."""
        if self.backend is None:
            return self
        arrays, forces = self.assembly_arrays, self.state.forces.contacts.force[0]
        known = [least_typical_force(forces[b.ball_indices]) for b in arrays.ball_sets]
        fitting = axis_system.typical_contact_forces(arrays, known)
        if np.allclose(np.maximum(fitting, LEAST_FORCE), self.typical_forces, rtol=FORCE_SETTLED, atol=0.0):
            return self
        again: Any = assembly_equations(arrays, self.backend, known).start_from(self)
        return again  # type: ignore[no-any-return]

    def round_off_residual(self) -> float:
        """Return the relative residual that rounding errors leave, from the largest motion and the stiffest contact.

        Between rigid housings, that of the springs' forces counts too.
        """
        forces, v0, scale = self.state.forces, self.system.bodies.free.v0, self.residual_force_scale
        motion = 2.0 * float(np.abs(v0).max(initial=0.0)) + float(np.abs(forces.centres).max(initial=0.0))
        stiffest = float(forces.contacts.stiffness.max(initial=0.0)) + float(forces.roller_stiffness.max(initial=0.0))
        contacts = residual_by_round_off(motion, stiffest, scale, self.problems)
        if self.backend is not None:
            return contacts
        arrays, q = self.assembly_arrays, self.body_motions_and_reactions()[0]
        springs = largest_spring_force_term(arrays.structure, q, arrays.moment_arm)
        moved = residual_by_round_off(float(np.abs(q[:, :3]).max(initial=0.0)), stiffest, scale, self.problems)
        return max(contacts, moved, residual_by_round_off(springs, 1.0, scale, ()))

    def body_motions_and_reactions(self) -> tuple[Array, Array]:
        """Return the motions of shaft nodes and moving housings, and the forces at their fixed degrees of freedom.

        Motions ``(r, 6)`` [m, rad] come first, then forces and moments ``(r, 6)`` [N, N m], zero at free degrees of
        freedom. All follow from the forces with which the bodies are in equilibrium, not from those by the contact law,
        which differ by the residual: even so small an error moves a long, compliant shaft noticeably.
        """
        arrays, shaft, h, a = self.assembly_arrays, self.shaft, self.housings, self.state.a[0]
        structure, forces, coupling = arrays.structure, self.state.phi[0], self.coupling
        n, k = structure.nodes.size, shaft.work_on_free_motions.size
        pushes = forces[:, :2].transpose(1, 0, 2).reshape(-1, 2)
        by_flanks = statics_shaft.nodal_loads_of_flank_forces(shaft.problem, pushes, [0, 1])
        if coupling is not None:
            by_flanks += coupling.nodal_loads_of_jumps(pushes.ravel())
        on_inner, on_outer = forces[:, :2].ravel(), forces[:, 2:].ravel()
        on_housings = self.outer_by_housings.T @ on_outer + self.inner_by_housings.T @ on_inner
        elastic = h.motions_under_loads(on_housings[:, None])[:, 0]
        outer = h.motions_by_external_loads + elastic + h.free_rigid_motions @ a[k:]
        q = np.concatenate([statics_shaft.nodal_motions_under_loads(shaft, by_flanks, a[:k]), outer.reshape(-1, 6)])
        loads = structure.load + np.concatenate([by_flanks, on_housings]).reshape(-1, 6)
        on_nodes = statics_shaft.nodal_forces_under_loads(shaft, by_flanks)
        taken = np.concatenate([on_nodes, (h.stiffness @ outer).reshape(-1, 6)])
        held = np.where(structure.fixed, taken - loads, 0.0)
        if coupling is not None:
            q[:n] = coupling.add_jumps_inside_stretches(q[:n], pushes, structure.fixed[:n])
        return q, held

    def forces_and_stiffness_of_slices(self) -> tuple[Array, Array]:
        """Return force [N] and stiffness [N/m] of the slices of all rollers ``(R, K)``; zeros for unused slices.

        They follow from the motions of the rings at the rollers, whose round-off is less than that of the bodies' motions.
        """
        rollers, rings = self.system.elements.rollers, self.state.motions[:, self.assembly_arrays.ball_count :]
        assert rollers is not None
        force, stiffness, _ = slice_forces(rollers, rings[:, :, 0] - rings[:, :, 2])
        return force[0], stiffness[0]

    def stiffness_of_sets_and_assembly(self) -> tuple[Sequence[Array], Array | None]:
        """Return the tangent stiffness ``(6, 6)`` [N/m, N, N m] of each bearing or nut, and of the assembly.

        The assembly's stiffness is taken at the shaft node or housing for which it is reported; None if this housing is
        fixed or nothing resists some motion there (`stiffness_of_assembly`).
        """
        S = stiffness_factors(self.system.elements, self.state.forces)
        at, sets = self.assembly_arrays.structure.body_positions, self.assembly_arrays.ball_sets
        own = self.own_compliances
        of_sets = [
            stiffness_of_nut_or_bearing(b, at, S[:, b.ball_indices], None if own is None else own[i])
            for i, b in enumerate(sets)
        ]
        return of_sets, stiffness_of_assembly(self, S)


def build_housings(structure: Structure, arm: float) -> Housings:
    """Return the moving housings, and the springs between them and to the fixed frame, as one linear elastic system.

    Parameters
    ----------
    structure
        Shaft, housings and springs.
    arm
        Length [m] by which rotations are multiplied to be comparable with translations, in the search for motions that no
        spring resists.
    """
    n, m = structure.nodes.size, structure.housing_positions.size
    K = np.zeros((6 * m, 6 * m))
    for ends, reach, stiffness in structure.each_spring():
        J = np.zeros((6, 6 * m))
        for e, row in enumerate(ends):
            if row >= 0:
                J[:, 6 * (row - n) : 6 * (row - n) + 6] += reach[e]
        K += J.T @ stiffness @ J
    held, prescribed = structure.fixed[n:].ravel(), structure.prescribed[n:].ravel()
    load, free = structure.load[n:].ravel(), np.flatnonzero(~structure.fixed[n:].ravel())
    scale = np.tile(np.repeat([1.0, 1.0 / arm], 3), m)
    motions = np.zeros((6 * m, 0))
    if free.size:
        value, vector = np.linalg.eigh(scale[free, None] * K[np.ix_(free, free)] * scale[None, free])
        loose = vector[:, value <= 1e-12 * max(float(value.max()), 1e-300)]
        motions = np.zeros((6 * m, loose.shape[1]))
        motions[free] = scale[free, None] * loose
        if loose.shape[1]:
            free = np.delete(free, independent_columns(loose.T))
    given = np.where(held, prescribed, 0.0)
    factor = cho_factor(K[np.ix_(free, free)], lower=True) if free.size else None
    found = Housings(free, factor, K, motions, given, motions.T @ load)
    return replace(found, motions_by_external_loads=given + found.motions_under_loads((load - K @ given)[:, None])[:, 0])


def grooved_shaft_section(assembly: Assembly, backend: ComplianceModel) -> BeamSection | None:
    """Return the stiffness of the threaded shaft's section with its groove; None: it follows from the shaft's dimensions.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    backend
        Method of computing compliance. Only with ``section`` "cell" the section with its groove is computed.
    """
    thread = first_ball_nut(assembly) if backend.section == "cell" else None
    return None if thread is None else grooved_section(reduce_to_compliance_geometry(thread), True)


def compliance_of_screw_and_nut(
    ball_set: BallSet, backend: ComplianceModel, force: float
) -> tuple[tuple[Array, Array], Array, list[str]]:
    """Return the compliance of screw and nut of one ball nut, or of the rings of one bearing, and terms of the contact law.

    The terms are added to Hertz's approach of a contact.

    Parameters
    ----------
    ball_set
        The ball nut or bearing, with N balls.
    backend
        Method by which the compliance of screw, nut and balls is computed.
    force
        Force of a typical contact [N], at which terms that depend on the size of the contact ellipse are evaluated.

    Returns
    -------
    tuple[tuple[Array, Array], Array, list[str]]
        Compliance matrices ``(4 N, 4 N)`` of screw and nut [m/N]; terms e, decrease of the approach by the ball's
        deformation, and h of the contact law ``(N, 4, 3)``, see `Balls`; assumptions as sentences.
    """
    problem, scene, layout = ball_set.problem, ball_set.problem.scene, ball_set.problem.layout
    N = layout.z.size
    axes, size = response.typical_ellipse_semi_axes(problem, force), float(np.cbrt(force))
    ball = ball_compliance(scene, axes, backend)
    terms, blocks, assumed = np.zeros((N, 4, 3)), [], list[str]()
    terms[..., 1] = ball.pair_coupling_root * np.array([1.0, ball.pair_coupling_sign, ball.pair_coupling_sign, 1.0])
    if backend.ball == "sphere":
        terms[..., 2] = oblique_pressure_coefficient(hertz_without_errors(scene), scene.balls.radius)
    order = response.permutation_to_ball_by_ball_order(N, 2)
    for screw, sides in ((True, slice(2)), (False, slice(2, 4))):
        carried = screw and ball_set.of.carrier is not None
        body = body_compliance(scene, layout, screw, replace(backend, screw="beam") if carried else backend, axes)
        assumed += [x for x in body.assumed_dimensions if x not in assumed]
        slope = body.contact_compliance_slope + ball.contact_compliance_slope
        terms[:, sides, 0] = body.contact_compliance + ball.contact_compliance - slope
        terms[:, sides, 2] += slope / size
        blocks.append(body.G[np.ix_(order, order)])
    return (blocks[0], blocks[1]), terms, assumed


def flank_motions_by_housings(system: AssemblyArrays) -> tuple[Array, Array]:
    """Return the motions of the flanks of outer and of inner rings per unit motion of the m moving housings.

    The first matrix ``(4 N, 6 m)`` holds the motions of the flanks of nuts and outer rings, the second those of inner rings
    that a housing carries. The rows are two flanks with two components for each of N rolling elements: balls come first,
    then rollers, whose outer flank is the cup. ``system``: arrays of the assembly.
    """
    n, m, balls = system.structure.nodes.size, system.structure.housing_positions.size, system.ball_count
    outer, inner = np.zeros((2, balls + system.roller_count, 2, 2, 6 * m))
    for b in system.ball_sets:
        carrier = -1 if b.of.carrier is None else int(b.problem.first_nodes[0, 0])
        for rows, row, flanks in ((outer, b.outer_body_row, slice(2, 4)), (inner, carrier, slice(2))):
            if row >= 0:
                rows[b.ball_indices, :, :, 6 * (row - n) : 6 * (row - n) + 6] = b.flank_motions_per_body_motion(flanks)
    for r in system.roller_sets:
        first = 6 * (r.ring_bodies[1] - n)
        if first >= 0:
            outer[balls:][r.roller_indices, 0, :, first : first + 6] = r.B[:, 1]
    return outer.reshape(4 * len(outer), 6 * m), inner.reshape(4 * len(inner), 6 * m)


def problem_of_beam(arrays: AssemblyArrays) -> BeamProblem:
    """Return how all balls, then all rollers of an assembly lie on the shaft's beam.

    ``arrays``: arrays of the assembly.
    """
    s, sets, n = arrays.structure, arrays.ball_sets, arrays.structure.nodes.size
    width = sets[0].problem.B.shape[3] if sets else 6
    # the shaft does not move the flanks of an inner ring that a housing carries
    on_shaft = [float(b.of.carrier is None) for b in sets]
    nodes = [(x * b.problem.first_nodes).astype(np.int64) for x, b in zip(on_shaft, sets, strict=True)]
    cones = (
        (np.full((r.row.count, 2), r.ring_bodies[0]), np.stack([r.B[:, 0], 0.0 * r.B[:, 0]], axis=1))
        for r in arrays.roller_sets
    )
    rollers = [axis_system.pad_coefficients_to_two_bodies(at, B, width, n) for at, B in cones]
    return BeamProblem(
        nodes=s.nodes,
        fixed=s.fixed[:n],
        prescribed=s.prescribed[:n],
        load=s.load[:n],
        first_nodes=np.concatenate([*nodes, *(at for at, _ in rollers)]),
        B=np.concatenate([*(x * b.problem.B for x, b in zip(on_shaft, sets, strict=True)), *(B for _, B in rollers)]),
        section=s.sections[0],
        element_sections=s.sections,
        moment_arm=sets[0].problem.moment_arm if sets else arrays.moment_arm,
        middle=sets[0].problem.middle if sets else arrays.assembly.sets[0].position,
    )


def assembly_equations(
    arrays: AssemblyArrays, backend: ComplianceModel | None, known: list[float] | None = None
) -> AssemblyEquations:
    """Return the equations of an assembly.

    Parameters
    ----------
    arrays
        Arrays of the assembly; with elastic bodies it has at least one ball nut or ball bearing, and the shaft section of
        `grooved_shaft_section`.
    backend
        Method by which the compliance of screws, nuts and balls is computed; None: they are rigid.
    known
        Least typical contact force of each ball nut and ball bearing by a solution [N]; None: estimated.

    Raises
    ------
    ValueError
        With elastic bodies: if an inner ring sits on a housing that stands on springs, there are more than `LARGEST`
        rolling elements, or a body has impossible dimensions.
    """
    balls, sets, count = arrays.balls, arrays.ball_sets, arrays.ball_count
    N = count + arrays.roller_count
    if backend is not None and N > response.LARGEST:
        raise ValueError(
            f"elastic bodies are allowed with at most {response.LARGEST} balls and rollers, got {N}; use the model lin"
        )
    shaft, both = statics_shaft.build_shaft(problem_of_beam(arrays)), [0, 1]
    housings = build_housings(arrays.structure, arrays.moment_arm)
    outer, inner = flank_motions_by_housings(arrays)
    free = motions_without_contacts(arrays, shaft, housings, (outer, inner))
    scale = axis_system.assembly_residual_scale(arrays, known)
    largest = float(balls.radius.max()) if count else max(r.row.length for r in arrays.roller_sets)
    joined = bool(np.any(inner @ housings.motions_under_loads(inner.T)))
    typical, own, assumed, coupling = [0.0] * len(sets), None, (), None
    bodies: DenseBodies | BeamBodies
    if backend is None and (joined or N > SPARSE):
        bodies = BeamBodies(free, *sparse_frame(shaft, housings, (outer, inner)))
    elif backend is None:
        order = response.permutation_to_ball_by_ball_order(N, 2)
        beam = statics_shaft.flank_compliance(shaft, both)[np.ix_(order, order)]
        bodies = DenseBodies(free, Compliances(beam[None], (outer @ housings.motions_under_loads(outer.T))[None]))
    elif joined:
        raise ValueError(
            "an inner ring sits on a housing that stands on springs: the motion of the housing couples inner and outer "
            "flanks, which the model with elastic bodies cannot represent; use the model lin"
        )
    else:
        typical = [max(x, LEAST_FORCE) for x in axis_system.typical_contact_forces(arrays, known)]
        on_shaft = ((b.problem, b.ball_indices) for b in sets if b.of.carrier is None)
        whole, reported = shaft.problem, arrays.assembly.stiffness_at
        read = [reported] if isinstance(reported, float) else []
        stretches = [
            statics_shaft.build_shaft_stretch(whole, p.scene, p.layout, backend, both, i, read) for p, i in on_shaft
        ]
        coupling = statics_shaft.couple_section_forces(shaft, both, stretches, arrays.assembly.thermal_strain)
        parts = [compliance_of_screw_and_nut(b, backend, x) for b, x in zip(sets, typical, strict=True)]
        own, terms = [x for x, _, _ in parts], np.concatenate([x for _, x, _ in parts])
        bodies, lent, cut = elastic_bodies(arrays, shaft, housings, outer, own, typical, coupling, free)
        balls = replace(balls, e=(terms[..., 0] - lent[:count])[None], body=terms[None, ..., 1], h=terms[None, ..., 2])
        clipped = f"negative compliance of the bodies, up to {100 * cut:.2g} % of a contact's, is set to zero"
        texts = dict.fromkeys(f"{b.of.name}: {x}" for b, (_, _, of) in zip(sets, parts, strict=True) for x in of)
        assumed = (*texts, *((clipped,) if cut > 1e-6 else ()))
    springs = starting_springs(balls, None, scale.stiffness), starting_springs_of_rollers(N - count, scale.stiffness)
    elements = RollingElements(balls, all_rollers(arrays.roller_sets), np.array([scale.unloaded_force_limit]))
    return AssemblyEquations(
        system=StaticSystem(bodies, elements, np.concatenate(springs, axis=1), limits_of(scale, largest)),
        assembly_arrays=arrays,
        backend=backend,
        shaft=shaft,
        housings=housings,
        outer_by_housings=outer,
        inner_by_housings=inner,
        own_compliances=own,
        assumed=assumed,
        coupling=coupling,
        typical_forces=typical,
        known_forces=known,
    )


def motions_without_contacts(
    arrays: AssemblyArrays, shaft: statics_shaft.ShaftBeam, housings: Housings, by_housings: tuple[Array, Array]
) -> FreeMotions:
    """Return the motions of all flanks by external loads and by the free motions of shaft and housings.

    ``by_housings``: motions of the flanks of outer and of inner rings by those of the housings.
    """
    (outer, inner), N = by_housings, len(shaft.problem.first_nodes)
    v0, k = np.zeros((N, 4, 2)), shaft.work_on_free_motions.size
    R = np.zeros((N, 4, 2, k + housings.work_on_free_motions.size))
    order = response.permutation_to_ball_by_ball_order(N, 2)
    v0[:, :2] = statics_shaft.flank_motions_by_loads(shaft, [0, 1])[order].reshape(N, 2, 2)
    R[:, :2, :, :k] = statics_shaft.flank_motions_by_free_motions(shaft, [0, 1])[order].reshape(N, 2, 2, k)
    for rows, flanks in ((inner, slice(2)), (outer, slice(2, 4))):
        v0[:, flanks] += (rows @ housings.motions_by_external_loads).reshape(N, 2, 2)
        R[:, flanks, :, k:] = (rows @ housings.free_rigid_motions).reshape(N, 2, 2, -1)
    v0[: arrays.ball_count] += arrays.prescribed_flank_motions
    work = np.concatenate([shaft.work_on_free_motions, housings.work_on_free_motions])
    return FreeMotions(v0[None], R[None], work[None])


def sparse_frame(
    shaft: statics_shaft.ShaftBeam, housings: Housings, by_housings: tuple[Array, Array]
) -> statics_shaft.SparseFrame:
    """Return the stiffness matrix of shaft and housings, and the motions of all flanks by their degrees of freedom.

    Both are sparse; the rows of the second are ordered by ball, flank and component. Then follow the functions from loads
    on the degrees of freedom to their motions, and from motions to loads. ``by_housings``: motions of the flanks of outer
    and of inner rings by those of the housings.
    """
    from scipy.sparse import block_diag, csr_array, hstack

    (outer, inner), at = by_housings, housings.free_dof_indices
    K, L, of_shaft, on_shaft = statics_shaft.sparse_beam(shaft, [0, 1], 4)
    moved = np.concatenate([x.reshape(len(shaft.problem.first_nodes), 4, -1) for x in (inner, outer)], axis=1)
    rows = csr_array(moved.reshape(L.shape[0], outer.shape[1])[:, at])
    count = K.shape[0]

    def motions_of_both(loads: Array) -> Array:
        on_housings = np.zeros((outer.shape[1], 1))
        on_housings[at, 0] = loads[count:]
        return np.concatenate([of_shaft(loads[:count]), housings.motions_under_loads(on_housings)[at, 0]])

    of_housings = housings.stiffness[np.ix_(at, at)]

    def loads_of_both(motions: Array) -> Array:
        return np.concatenate([on_shaft(motions[:count]), of_housings @ motions[count:]])

    both = block_diag([K, csr_array(of_housings)], format="csc")
    return both, hstack([L, rows], format="csr"), motions_of_both, loads_of_both


def elastic_bodies(
    arrays: AssemblyArrays,
    shaft: statics_shaft.ShaftBeam,
    housings: Housings,
    outer: Array,
    own: list[tuple[Array, Array]],
    typical: list[float],
    coupling: statics_shaft.SectionForceCoupling | None,
    free: FreeMotions,
) -> tuple[DenseBodies, Array, float]:
    """Return the elastic bodies of an assembly without negative eigenvalues, and what the contacts must lend them for it.

    Parameters
    ----------
    arrays, shaft, housings
        Assembly, its beam and its moving housings.
    outer
        Motions of the flanks of outer rings per unit motion of the housings ``(4 N, 6 m)``.
    own, typical
        Compliance matrices of screw and nut, and typical contact force [N], of each ball nut and ball bearing.
    coupling
        Coupling of section forces and contacts; None: not modelled.
    free
        Motions of the flanks without contact forces; those by the coupling are added.

    Returns
    -------
    tuple[DenseBodies, Array, float]
        Bodies; compliance ``(N, 4)`` [m/N] that was added to them along the contacts' normals; and the largest negative
        eigenvalue that was set to zero, as a fraction of a contact's compliance.
    """
    N = len(shaft.problem.first_nodes)
    rigid_rings, order = np.zeros((4 * (N - arrays.ball_count),) * 2), response.permutation_to_ball_by_ball_order(N, 2)
    beam = statics_shaft.flank_compliance(shaft, [0, 1])
    if coupling is not None:
        beam = beam + coupling.added_compliance
        free.v0[0, :, :2] += coupling.flank_motions_by_loads[order].reshape(N, 2, 2)
    tangent = min(
        response.tangent_compliance_of_contact(b.problem, x) for b, x in zip(arrays.ball_sets, typical, strict=True)
    )
    normals = np.zeros((N, 4, 2))
    normals[: arrays.ball_count] = arrays.balls.normals[0]
    carriers = (beam[np.ix_(order, order)], normals[:, :2]), (outer @ housings.motions_under_loads(outer.T), normals[:, 2:])
    mended = (
        response.contact_compliance(G + block_diag(*(x[k] for x in own), rigid_rings), n.reshape(-1, 2))
        for k, (G, n) in enumerate(carriers)
    )
    (first, on_inner, low), (second, on_outer, high) = (x.without_negative_eigenvalues(tangent) for x in mended)
    lent = np.concatenate([on_inner.reshape(N, 2), on_outer.reshape(N, 2)], axis=1)
    return DenseBodies(free, Compliances(first.G[None], second.G[None])), lent, max(low, high) / tangent


def stiffness_of_nut_or_bearing(ball_set: BallSet, stations: Array, S: Array, own: tuple[Array, Array] | None) -> Array:
    """Return the stiffness ``(6, 6)`` [N/m, N, N m] between screw and nut, or between the rings of a bearing.

    The stiffness acts against a rigid motion of screw or inner ring, to which the deformation of both bodies is added,
    while nut or outer ring are fixed where they are mounted.

    Parameters
    ----------
    ball_set
        The ball nut or bearing, with N balls.
    stations
        Axial positions of all shaft nodes and moving housings [m].
    S
        Factors ``(1, N, w, 4, 2)`` of the stiffness of its balls.
    own
        Compliance matrices ``(4 N, 4 N)`` [m/N] of its screw (or inner ring) and nut (or outer ring); None: rigid.
    """
    N = S.shape[1]
    v, none = np.zeros((N, 4, 2, 6)), FreeMotions(np.zeros((1, N, 4, 2)), np.zeros((1, N, 4, 2, 0)), np.zeros((1, 0)))
    v[:, :2] = ball_set.flank_motions(rigid_motion_transfer_matrix(stations - ball_set.of.position))[:, :2]
    first, second = own or (np.zeros((0, 0)), np.zeros((0, 0)))
    found = small_response(DenseBodies(none, Compliances(first[None], second[None])), S, v, np.zeros((0, 6)))
    assert found is not None
    return np.asarray(-v.reshape(-1, 6).T @ found[0].reshape(-1, 6))


def stiffness_of_assembly(equations: AssemblyEquations, S: Array) -> Array | None:
    """Return the tangent stiffness ``(6, 6)`` [N/m, N, N m] of the whole assembly at the reported shaft node or housing.

    It is the force and moment per unit motion of that node or housing while all other bodies follow freely. Rows and
    columns of fixed degrees of freedom are nan. None if the housing is fixed, or the contacts carry too little load to
    resist.

    Parameters
    ----------
    equations
        Solved equations.
    S
        Factors ``(1, N, w, 4, 2)`` of the stiffness of all balls and rollers.
    """
    arrays, shaft, housings, coupling = equations.assembly_arrays, equations.shaft, equations.housings, equations.coupling
    structure, row = arrays.structure, axis_system.body_of_reported_stiffness(arrays)
    if row < 0:
        return None
    n, k, N = structure.nodes.size, shaft.work_on_free_motions.size, S.shape[1]
    v, work = np.zeros((N, 4, 2, 6)), np.zeros((equations.state.a.size, 6))
    unit = np.zeros((6 * (n if row < n else structure.housing_positions.size), 6))
    at = 6 * (row if row < n else row - n)
    unit[at : at + 6] = np.diag((~structure.fixed[row]).astype(float))
    if row < n:
        answer = shaft.motions_under_loads(unit)
        B, nodes = shaft.problem.B, shaft.problem.first_nodes
        v[:, :2] = np.einsum("nsak,nskj->nsaj", B, answer[6 * nodes[..., None] + np.arange(B.shape[3])])
        if coupling is not None:
            added, besides = coupling.motions_by_loads(unit, answer)
            v[:, :2] += added.reshape(2, N, 2, 6).transpose(1, 0, 2, 3)
            answer = answer + besides
        rigid = rigid_motion_transfer_matrix(float(structure.nodes[row] - structure.nodes[shaft.pinned_node]))
        work[:k] = (rigid @ shaft.free_rigid_motions).T @ unit[at : at + 6]
    else:
        answer = housings.motions_under_loads(unit)
        v[:, 2:] = (equations.outer_by_housings @ answer).reshape(N, 2, 2, 6)
        v[:, :2] = (equations.inner_by_housings @ answer).reshape(N, 2, 2, 6)
        work[k:] = housings.free_rigid_motions.T @ unit
    found = small_response(equations.system.bodies, S, v, work)
    if found is None:
        return None
    forces, amplitudes = found
    compliance = answer[at : at + 6] + v.reshape(8 * N, 6).T @ forces.reshape(8 * N, 6) + work.T @ amplitudes
    return stiffness_from_compliance(0.5 * (compliance + compliance.T), ~structure.fixed[row], arrays.moment_arm)


def stiffness_from_compliance(compliance: Array, free: NDArray[np.bool_], arm: float) -> Array | None:
    """Return the stiffness ``(6, 6)`` [N/m, N, N m] of the free degrees of freedom of a body; nan for the fixed ones.

    None if the matrix is not positive definite but consists of round-off, as happens if no contact carries load.

    Parameters
    ----------
    compliance
        Compliance matrix ``(6, 6)`` of the body [m/N, 1/N, 1/(N m)], whose inverse is the result.
    free
        Which degrees of freedom are free ``(6,)``.
    arm
        Length [m] by which rotations are multiplied to be comparable with displacements when the matrix is inverted.
    """
    rows = np.flatnonzero(free)
    out = np.full((6, 6), np.nan)
    if rows.size:
        size = np.where(rows < 3, 1.0, 1.0 / arm)
        scaled = compliance[np.ix_(rows, rows)] / size[:, None] / size[None, :]
        if not (np.diag(scaled) > 0.0).all():
            return None
        try:
            stiffness = np.linalg.inv(scaled)
        except np.linalg.LinAlgError:
            return None
        stiffness = stiffness / size[:, None] / size[None, :]
        out[np.ix_(rows, rows)] = 0.5 * (stiffness + stiffness.T)
    return out
