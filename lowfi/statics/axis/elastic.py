"""Refined model of a shaft with several bearings and ball nuts, whose shaft, screws, nuts and balls are elastic.

The shaft is a beam on its supports. In addition, the screw, nut and balls of one bearing or nut deform under their own
contact forces as in the refined model of a single one (`lowfi.compliance`). Different bearings and nuts affect each other
only through the beam, the housings, and the beam's section forces, which change the contacts' approach
(`lowfi.statics.shaft`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from types import ModuleType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, cho_factor, cho_solve

from rollbench.lowfi.compliance.bodies import ball_compliance, body_compliance
from rollbench.lowfi.compliance.parts import REFINED, ComplianceModel, grooved_section, reduce_to_compliance_geometry
from rollbench.lowfi.statics import response
from rollbench.lowfi.statics import shaft as statics_shaft
from rollbench.lowfi.statics.axis import solve
from rollbench.lowfi.statics.axis import system as axis_system
from rollbench.lowfi.statics.axis.structure import Structure, first_ball_nut
from rollbench.lowfi.statics.axis.system import AssemblyArrays, BallSet, RollerElements, roller_elements
from rollbench.lowfi.statics.contacts import hertz_without_errors, oblique_pressure_coefficient
from rollbench.lowfi.statics.elastic import CONDENSED
from rollbench.lowfi.statics.kernel_types import BallContacts, BodySystem, ElasticBodies, ForceState, MotionState
from rollbench.lowfi.statics.problem import Problem
from rollbench.lowfi.statics.result import AxisResult
from rollbench.lowfi.statics.settle import ContactState, ModelDescription, residual_by_round_off, solver_options
from rollbench.lowfi.statics.shape import independent_columns, rigid_motion_transfer_matrix
from rollbench.lowfi.statics.static import Engine
from rollbench.lowfi.statics.summary import ELASTIC_ASSUMPTIONS
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.section import BeamSection

#: Assumptions of every result of the refined model on an assembly.
ASSUMPTIONS = (
    "the shaft is a Timoshenko beam between its bearings and nuts; in addition the screw, nut and balls of each bearing or "
    "nut deform under their own contact forces, and respond to contacts elsewhere only by the section forces of the shaft",
    "housings are rigid; nuts and outer rings are fixed in them as the nut of a single ball screw is fixed in its scene",
    *ELASTIC_ASSUMPTIONS,
)
#: Effect that the model neglects for tapered roller bearings.
RIGID_RINGS = (
    "elastic rings: cone and cup are rigid apart from the line contacts, whose force law includes the local deformation"
)

#: Effect that the model neglects for an inner ring that a housing carries.
RIGID_INNER = "elastic inner ring: apart from its contacts it is rigid, like the housing that carries it"


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
class ElasticAssemblyEquations(solve.AssemblyEquations):
    """Equations of an assembly (shaft, bearings, nuts, m moving housings) with elastic bodies, and N balls and rollers."""

    SOLVER = "solve_forces"
    #: Arrays of bodies and rolling elements for the kernels.
    kernel_arrays: BodySystem
    #: Unknowns of the iteration: contact forces, free rigid motions of the bodies (which only contacts resist), contacts.
    state: ForceState
    #: Method by which the compliance of screws, nuts and balls is computed.
    backend: ComplianceModel
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
    #: screw (or inner ring), and of its nut (or outer ring), per unit contact force of the same bearing or nut.
    own_compliances: list[tuple[Array, Array]]
    #: Assumptions about the bodies, as sentences for the report.
    assumed: tuple[str, ...]
    #: Coupling of the shaft's section forces, which deform its grooves, with the contacts' approaches; None: not modelled.
    coupling: statics_shaft.SectionForceCoupling | None

    def contact_states(self) -> Sequence[ContactState]:
        """Return contact forces, ball centres and flank motions of each bearing and nut, as the iteration has them now."""
        return axis_system.contact_states_of_sets(
            self.assembly_arrays, self.motions_and_reactions()[0], self.flank_motions()
        )

    def with_lever_arms(self, arms: Sequence[Array]) -> Self:
        """Return these equations with other lever arms of the contact forces; the next solution starts from this state.

        ``arms``: for each bearing or nut with N balls, the shifts ``(N, 4, 2)`` [m] of the flanks' centres of curvature by
        profile errors; contact forces act through these centres.
        """
        system = axis_system.replace_lever_arms(self.assembly_arrays, arms)
        longer: Any = elastic_equations(system, self.engine, self.backend).copy_state_from(self)
        return longer  # type: ignore[no-any-return]

    def round_off_residual(self) -> float:
        """Return the relative residual that rounding errors leave, from the largest motion and the stiffest contact."""
        state, v0 = self.state, self.kernel_arrays.bodies.v0
        motion = 2.0 * float(np.abs(v0).max(initial=0.0)) + float(np.abs(state.ball_unknowns[:, :2]).max(initial=0.0))
        stiffest = float(state.contact[..., 3].max(initial=0.0))
        return residual_by_round_off(motion, stiffest, self.residual_force_scale, self.problems)

    def model_description(self) -> ModelDescription:
        """Return the formulation, number of unknowns and assumptions of the model for the record of the solution."""
        return ModelDescription(CONDENSED, self.state.phi.size + self.state.a.size, self.assumed)

    def forces_on_flanks(self) -> Array:
        """Return the ball forces on the flanks ``(N, 4, 2)`` [N] with which the elastic bodies are in equilibrium.

        They differ from the forces by the contact law by the residual of the iteration. The forces by the contact law must
        not be used instead: even so small an error moves a long, compliant shaft noticeably.
        """
        return self.state.phi.reshape(-1, 4, 2)

    def flank_motions(self) -> Array:
        """Return the motions of all flanks ``(N, 4, 2)`` [m] in the present state, in the balls' section planes.

        They consist of deformations of the bodies, their free rigid motions (which only contacts resist), and the
        prescribed offsets of nuts and outer rings.
        """
        bodies, forces = self.kernel_arrays.bodies, self.forces_on_flanks()
        N = len(forces)
        out = (bodies.v0 + bodies.R @ self.state.a).reshape(N, 4, 2)
        for G, half in ((bodies.first_compliance, slice(2)), (bodies.second_compliance, slice(2, 4))):
            out[:, half] += (G @ forces[:, half].ravel()).reshape(N, 2, 2)
        return np.asarray(out)

    def motions_and_reactions(self) -> tuple[MotionState, Array]:
        """Return the present state (motions of shaft nodes and housings, ball centres, contacts), and support reactions.

        The reactions ``(r, 6)`` [N, N m] act on the r shaft nodes and housings and are zero at free degrees of freedom.
        """
        system, shaft, h, a = self.assembly_arrays, self.shaft, self.housings, self.state.a
        structure, forces, coupling = system.structure, self.forces_on_flanks(), self.coupling
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
        slices = np.zeros((system.slice_arrays.gap.size, 2))
        self.engine.add_roller_forces(system.slice_arrays, q, slices, np.zeros_like(q))
        if coupling is not None:
            q[:n] = coupling.add_jumps_inside_stretches(q[:n], pushes, structure.fixed[:n])
        state = MotionState(q, np.zeros((n - 1, 6)), self.state.ball_unknowns[:, :2], self.state.contact, slices)
        return state, held

    def stiffness_of_sets_and_assembly(self) -> tuple[Sequence[Array], Array | None]:
        """Return the tangent stiffness ``(6, 6)`` [N/m, N, N m] of each bearing or nut, and of the assembly.

        The assembly's stiffness is taken at the shaft node or housing for which it is reported; None if nothing resists
        some motion there (`stiffness_of_elastic_assembly`).
        """
        S = square_root_stiffness_of_balls(self)
        sets = zip(self.assembly_arrays.ball_sets, self.own_compliances, strict=True)
        own = [stiffness_of_elastic_nut_or_bearing(self, b, G, S[b.ball_indices]) for b, G in sets]
        return own, stiffness_of_elastic_assembly(self, S)


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


def combined_problem(system: AssemblyArrays, rollers: RollerElements) -> Problem:
    """Return all balls, then all rollers of an assembly as one contact problem on the shaft's beam.

    It serves to compute the response of the beam to contact forces. Its scene and manufacturing errors are those of the
    first ball bearing or nut and are not valid for the others. ``system``: arrays of the assembly; ``rollers``: its rollers
    as elements between rigid rings.
    """
    s, problems = system.structure, [b.problem for b in system.ball_sets]
    for i, p in enumerate(problems):  # the shaft does not move the flanks of an inner ring that a housing carries
        if system.ball_sets[i].of.carrier is not None:
            problems[i] = replace(p, first_nodes=np.zeros_like(p.first_nodes), B=np.zeros_like(p.B))
    first = problems[0]
    on_cones = np.stack([rollers.B[:, 0], np.zeros((rollers.count, 2, 6))], axis=1)
    at_cones = np.repeat(rollers.cone_nodes[:, None], 2, axis=1)
    at_cones, on_cones = axis_system.pad_coefficients_to_two_bodies(at_cones, on_cones, first.B.shape[3], s.nodes.size)
    return replace(
        first,
        fixed=s.fixed[: s.nodes.size],
        first_nodes=np.concatenate([*(p.first_nodes for p in problems), at_cones]),
        B=np.concatenate([*(p.B for p in problems), on_cones]),
        geometry=system.ball_arrays.geometry,
        interference=system.ball_arrays.interference,
        used_flanks=np.ones(4, dtype=bool),
        element_sections=s.sections,
    )


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
        Compliance matrices ``(4 N, 4 N)`` of screw and nut [m/N]; terms of the contact law ``(N, 4, 3)``, see
        `BallContacts`; assumptions as sentences.
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


def flank_motions_by_housings(system: AssemblyArrays, rollers: RollerElements) -> tuple[Array, Array]:
    """Return the motions of the flanks of outer and of inner rings per unit motion of the m moving housings.

    The first matrix ``(4 N, 6 m)`` holds the motions of the flanks of nuts and outer rings, the second those of inner rings
    that a housing carries. The rows are two flanks with two components for each of N rolling elements: balls come first,
    then ``rollers``, whose outer flank is the cup. ``system``: arrays of the assembly.
    """
    n, m, balls = system.structure.nodes.size, system.structure.housing_positions.size, system.ball_arrays.r_ball.size
    outer, inner = np.zeros((2, balls + rollers.count, 2, 2, 6 * m))
    for b in system.ball_sets:
        carrier = -1 if b.of.carrier is None else int(b.problem.first_nodes[0, 0])
        for rows, row, flanks in ((outer, b.outer_body_row, slice(2, 4)), (inner, carrier, slice(2))):
            if row >= 0:
                rows[b.ball_indices, :, :, 6 * (row - n) : 6 * (row - n) + 6] = b.flank_motions_per_body_motion(flanks)
    for i in np.flatnonzero(rollers.cup_body_rows >= 0):
        j = 6 * (int(rollers.cup_body_rows[i]) - n)
        outer[balls + i, 0, :, j : j + 6] = rollers.B[i, 1]
    return outer.reshape(4 * len(outer), 6 * m), inner.reshape(4 * len(inner), 6 * m)


def elastic_equations(system: AssemblyArrays, engine: ModuleType, backend: ComplianceModel) -> ElasticAssemblyEquations:
    """Return the equations of an assembly with elastic bodies.

    Parameters
    ----------
    system
        Arrays of the assembly, with at least one ball nut or ball bearing, and the shaft section of
        `grooved_shaft_section`.
    engine
        Module of the numerical kernels, compiled or interpreted.
    backend
        Method by which the compliance of screws, nuts and balls is computed.

    Raises
    ------
    ValueError
        If an inner ring sits on a housing that stands on springs, there are more than `LARGEST` rolling elements, or a
        body has impossible dimensions.
    """
    rollers, given, sets = roller_elements(system.roller_sets), system.ball_arrays, system.ball_sets
    balls = given.r_ball.size
    N = balls + rollers.count
    if N > response.LARGEST:
        raise ValueError(
            f"elastic bodies are allowed with at most {response.LARGEST} balls and rollers, got {N}; use the model lin"
        )
    whole, both = combined_problem(system, rollers), [0, 1]
    shaft, housings = statics_shaft.build_shaft(whole), build_housings(system.structure, system.moment_arm)
    order = response.permutation_to_ball_by_ball_order(N, 2)
    beam, rigid = statics_shaft.flank_compliance_and_free_motions(shaft, both)
    moved = statics_shaft.flank_motions_by_loads(shaft, both)
    on_shaft = ((b.problem, b.ball_indices) for b in sets if b.of.carrier is None)
    stretches = [statics_shaft.build_shaft_stretch(whole, p.scene, p.layout, backend, both, i) for p, i in on_shaft]
    coupling = statics_shaft.couple_section_forces(shaft, both, stretches, system.assembly.thermal_strain)
    if coupling is not None:
        beam, moved = beam + coupling.added_compliance, moved + coupling.flank_motions_by_loads
    forces = [axis_system.typical_contact_force(system, b) for b in sets]
    parts = [compliance_of_screw_and_nut(b, backend, x) for b, x in zip(sets, forces, strict=True)]
    outer, inner = flank_motions_by_housings(system, rollers)
    if np.any(inner @ housings.motions_under_loads(inner.T)):
        raise ValueError(
            "an inner ring sits on a housing that stands on springs: the motion of the housing couples inner and outer "
            "flanks, which the model with elastic bodies cannot represent; use the model lin"
        )
    rigid_rings = np.zeros((4 * rollers.count,) * 2)
    tangent = min(response.tangent_compliance_of_contact(b.problem, x) for b, x in zip(sets, forces, strict=True))
    normals = np.concatenate([response.contact_normals(given.geometry), np.zeros((rollers.count, 4, 2))])
    carriers = (beam[np.ix_(order, order)], normals[:, :2]), (outer @ housings.motions_under_loads(outer.T), normals[:, 2:])
    bodies = (
        response.ContactCompliance(G + block_diag(*(own[k] for own, _, _ in parts), rigid_rings), n.reshape(-1, 2))
        for k, (G, n) in enumerate(carriers)
    )
    (first, on_inner, low), (second, on_outer, high) = (x.without_negative_eigenvalues(tangent) for x in bodies)
    v0, k = np.zeros((N, 4, 2)), shaft.work_on_free_motions.size
    R = np.zeros((N, 4, 2, k + housings.work_on_free_motions.size))
    v0[:, :2], R[:, :2, :, :k] = moved[order].reshape(N, 2, 2), rigid[order].reshape(N, 2, 2, -1)
    v0[:, :2] += (inner @ housings.motions_by_external_loads).reshape(N, 2, 2)
    v0[:, 2:] = (outer @ housings.motions_by_external_loads).reshape(N, 2, 2)
    v0[:balls, 2:] += given.v0[:, 2:]
    R[:, :2, :, k:] = (inner @ housings.free_rigid_motions).reshape(N, 2, 2, -1)
    R[:, 2:, :, k:] = (outer @ housings.free_rigid_motions).reshape(N, 2, 2, -1)
    terms = np.concatenate([x for _, x, _ in parts])
    terms[..., 0] -= np.concatenate([on_inner.reshape(N, 2), on_outer.reshape(N, 2)], axis=1)[:balls]
    work = np.concatenate([shaft.work_on_free_motions, housings.work_on_free_motions])
    scale, used = axis_system.assembly_residual_scale(system), given.geometry[..., 5] > 0.0
    of_balls = response.starting_spring_factors(whole, None, scale.stiffness) * used[:, None, :].repeat(2, axis=2)
    springs = np.concatenate([of_balls, axis_system.starting_spring_factors_of_rollers(rollers.count, scale.stiffness)])
    contact_data = given.geometry, given.interference, terms, given.r_ball, given.profile, np.zeros((balls, 7))
    cut = max(low, high) / tangent
    clipped = f"negative compliance of the bodies, up to {100 * cut:.2g} % of a contact's, is set to zero"
    assumed = dict.fromkeys(f"{b.of.name}: {x}" for b, (_, _, texts) in zip(sets, parts, strict=True) for x in texts)
    return ElasticAssemblyEquations(
        engine=engine,
        kernel_arrays=BodySystem(
            ElasticBodies(first.G, second.G, R.reshape(N, 8, -1), v0.reshape(N, 8), work),
            BallContacts(*contact_data, rollers.roller_contacts, scale.unloaded_force_limit),
            np.ascontiguousarray(springs),
        ),
        state=ForceState(np.zeros((N, 8)), np.zeros(work.size), np.zeros((N, 3)), np.zeros((N, 4, 5))),
        options=solver_options(scale, system.moment_arm, float(given.r_ball.max())),
        assembly_arrays=system,
        backend=backend,
        shaft=shaft,
        housings=housings,
        outer_by_housings=outer,
        inner_by_housings=inner,
        own_compliances=[own for own, _, _ in parts],
        assumed=(*assumed, *((clipped,) if cut > 1e-6 else ())),
        coupling=coupling,
    )


def square_root_stiffness_of_balls(elastic: ElasticAssemblyEquations) -> list[Array]:
    """Return for each ball or roller i a matrix S_i such that S_i^T S_i is its stiffness [N/m] for motions of its flanks.

    S_i ``(rows, 8)`` has at most six rows. The eight columns are the four flanks (screw left, screw right, nut left, nut
    right) with two components in the ball's section plane each; for a roller see `kernel.rollers`. ``elastic``: solved
    assembly.
    """
    N = elastic.state.contact.shape[0]
    S, counts = np.zeros((N, 6, 8)), np.zeros(N, dtype=np.int64)
    elastic.engine.write_stiffness_factors(elastic.kernel_arrays.contacts, elastic.state.contact, S, counts)
    return [S[i, : counts[i]] for i in range(N)]


def compliance_ordered_ball_by_ball(first: Array, second: Array) -> Array:
    """Return the compliance matrix ``(8 N, 8 N)`` [m/N] of all four flanks of N balls, from those of screw and nut.

    Rows and columns are ordered ball by ball.

    Parameters
    ----------
    first, second
        Compliance matrices ``(4 N, 4 N)`` [m/N] of the screw (or inner rings) and of the nut (or outer rings).
    """
    N = len(first) // 4
    out = np.zeros((N, 2, 4, N, 2, 4))
    out[:, 0, :, :, 0] = first.reshape(N, 4, N, 4)
    out[:, 1, :, :, 1] = second.reshape(N, 4, N, 4)
    return out.reshape(8 * N, 8 * N)


def stiffness_of_elastic_nut_or_bearing(
    elastic: ElasticAssemblyEquations, ball_set: BallSet, own: tuple[Array, Array], S: list[Array]
) -> Array:
    """Return the stiffness ``(6, 6)`` [N/m, N, N m] of one ball nut or bearing with elastic screw and nut, or rings.

    The stiffness acts against a rigid motion of screw or inner ring, to which the deformation of both bodies is added,
    while nut or outer ring are fixed where they are mounted.

    Parameters
    ----------
    elastic
        Solved assembly.
    ball_set
        The ball nut or bearing, with N balls.
    own
        Compliance matrices ``(4 N, 4 N)`` [m/N] of its screw (or inner ring) and nut (or outer ring).
    S
        Square roots of the stiffness of its balls, from `square_root_stiffness_of_balls`.
    """
    root = block_diag(*S)
    rows = np.zeros((len(S), 8, 6))
    rows[:, :4] = solve.screw_flank_motions_per_rigid_motion(ball_set, elastic.assembly_arrays.structure.body_positions)
    moved = root @ rows.reshape(-1, 6)
    compliance = compliance_ordered_ball_by_ball(*own)
    return np.asarray(moved.T @ np.linalg.solve(np.eye(len(root)) + root @ compliance @ root.T, moved))


def stiffness_of_elastic_assembly(elastic: ElasticAssemblyEquations, S: list[Array]) -> Array | None:
    """Return the tangent stiffness ``(6, 6)`` [N/m, N, N m] of the whole assembly at the reported shaft node or housing.

    None if this housing is fixed, or the assembly has no resistance to some motion. ``elastic``: solved assembly; ``S``:
    square roots of the balls' stiffness, from `square_root_stiffness_of_balls`. `stiffness_of_rigid_assembly` is the
    counterpart for rigid bodies (model lin).
    """
    system, shaft, housings, coupling = elastic.assembly_arrays, elastic.shaft, elastic.housings, elastic.coupling
    structure, row = system.structure, axis_system.body_of_reported_stiffness(system)
    if row < 0:
        return None
    n, k, N = structure.nodes.size, shaft.work_on_free_motions.size, len(S)
    v, work = np.zeros((N, 4, 2, 6)), np.zeros((elastic.state.a.size, 6))
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
        v[:, 2:] = (elastic.outer_by_housings @ answer).reshape(N, 2, 2, 6)
        work[k:] = housings.free_rigid_motions.T @ unit
    root, load, bodies = block_diag(*S), v.reshape(8 * N, 6), elastic.kernel_arrays.bodies
    SR, G = root @ bodies.R.reshape(8 * N, -1), compliance_ordered_ball_by_ball(*bodies[:2])
    matrix = np.block([[np.eye(len(root)) + root @ G @ root.T, -SR], [SR.T, np.zeros((SR.shape[1],) * 2)]])
    try:
        x = np.linalg.solve(matrix, np.concatenate([root @ load, work]))
    except np.linalg.LinAlgError:
        return None
    compliance = answer[at : at + 6] - load.T @ (root.T @ x[: len(root)]) + work.T @ x[len(root) :]
    return solve.stiffness_from_compliance(0.5 * (compliance + compliance.T), ~structure.fixed[row], system.moment_arm)


def solve_assembly_with_elastic_bodies(
    assembly: Assembly,
    *,
    engine: Engine = "auto",
    member: int = 0,
    backend: ComplianceModel = REFINED,
    name: str = "refined",
) -> AxisResult:
    """Compute contact forces, stiffness and motions of an assembly with elastic bodies.

    If all bearings are roller bearings, only the shaft's beam and the line contacts are elastic; the model lin is solved.

    Parameters
    ----------
    assembly
        Shaft with bearings and ball nuts.
    engine
        Numerical kernels: ``"interpreted"``, ``"compiled"``, or ``"auto"``, which chooses by the size of the problem.
    member
        Number of the specimen: each number gives other random errors.
    backend
        Method by which the compliance of screws, nuts and balls is computed.
    name
        Name of the model in the result.

    Raises
    ------
    ValueError
        If an inner ring sits on a housing that stands on springs, there are more than `LARGEST` balls and rollers, or a
        body has impossible dimensions.
    """
    rigid = describe_rigid_rings(assembly)
    if not assembly.ball_count:
        result = solve.solve_assembly(assembly, engine=engine, member=member)
        return replace(result, model=name, left_out=(*result.left_out, *rigid))

    again = partial(solve_assembly_with_elastic_bodies, engine=engine, member=member, backend=backend, name=name)
    build, section = partial(elastic_equations, backend=backend), grooved_shaft_section(assembly, backend)
    model = solve.AssemblyModel(name, ASSUMPTIONS, rigid, build, section, False)
    return solve.solve_assembly_by_model(assembly, model, engine, member, again)


def describe_rigid_rings(assembly: Assembly) -> tuple[str, ...]:
    """Return a sentence for each roller bearing and each inner ring on a housing; the model takes their rings as rigid."""
    rollers = tuple(f"{s.name}: {RIGID_RINGS}" for s in assembly.sets if isinstance(s.parts, RollerRow))
    return rollers + tuple(f"{s.name}: {RIGID_INNER}" for s in assembly.sets if s.carrier is not None)
