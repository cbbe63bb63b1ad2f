"""Equations of a single ball screw or ball bearing: elastic or rigid screw, nut and balls, and their contacts.

Every model of the ladder from Lin's to the refined one is a compliance at the contacts, which is given to one solver
(`lowfi.statics.equilibrium`). In Lin's model screw, nut and balls are rigid apart from Hertz's contacts, and the compliance
is that of the screw's beam between the nodes of the scene's partition. In the others the flanks of screw and nut also
deform under contact forces by a compliance matrix, which is computed (`lowfi.compliance.bodies`) or read from the file of a
condensed 3D model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.compliance.bodies import WholeBody, compliance_between_contacts
from rollbench.lowfi.compliance.parts import (
    LADDER,
    ComplianceModel,
    grooved_section,
    idealisation_statements,
    reduce_to_compliance_geometry,
)
from rollbench.lowfi.hertz import contact_force, contact_stiffness_under_force
from rollbench.lowfi.statics import response, settle
from rollbench.lowfi.statics import shaft as statics_shaft
from rollbench.lowfi.statics.equilibrium import (
    ADDED,
    CONVERGED,
    ITERATIONS,
    RIGID,
    SOLVED,
    TOLERANCE,
    BeamBodies,
    Compliances,
    DenseBodies,
    FreeMotions,
    Outcome,
    StaticSystem,
    evaluated,
    newton_step,
    unbalanced_forces,
)
from rollbench.lowfi.statics.problem import ContactState, Problem, SolvedState, build_problem, round_off_approach
from rollbench.lowfi.statics.response import LARGEST, FlankCompliance, only_flank_pair
from rollbench.lowfi.statics.rolling_elements import (
    Balls,
    FlankPairs,
    RollingElements,
    between_opposite_flanks,
    first_ball_centres,
    starting_springs,
)
from rollbench.lowfi.statics.selection import (
    all_flank_motions_by_screw,
    place_unloaded_balls_clear,
    solutions_clear_of_left_out_flanks,
    touched_flanks,
)
from rollbench.lowfi.statics.settle import FORCE_SETTLED, ResidualScale
from rollbench.lowfi.statics.summary import ELASTIC_ASSUMPTIONS, model_assumptions
from rollbench.lowfi.together import Search
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.errors import GeometryWithErrors
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import SIDES, Scene, UnfitKey
from rollbench.meshes.section import BeamSection

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.bodies import CondensedCompliance


#: Distance [m] of a ball from a flank that the equations leave out, below which the ball counts as touching it; for elastic
#: bodies, whose flanks without contacts move in a way that is not computed.
MARGIN = 0.2e-6
#: Number of balls above which the beam between rigid bodies is solved by its sparse stiffness matrix, and number of balls
#: and of iterations up to and above which the dense matrix is taken after all: it needs more time and keeps digits that the
#: sparse one of a very long shaft loses.
SPARSE, DENSE, MANY = 100, 300, 30
#: Number of corrections by which the contacts follow the motions of the beam's nodes, and relative residual up to which
#: they follow them anyway.
CORRECTIONS, FOLLOWED = 4, 3e-13


def residual_scale(problem: Problem, known: float = 0.0) -> ResidualScale:
    """Return the typical force and stiffness of a problem's contacts, by which the solver scales residuals.

    ``known``: lower bound of the typical force [N] that is known otherwise, such as from a solution. See `residual_scales`.
    """
    scales = residual_scales(problem, problem.balls.C, problem.balls.interference, known)
    return ResidualScale(*(float(x[0]) for x in scales))


def residual_scales(problem: Problem, C: Array, interference: Array, known: float = 0.0) -> ResidualScale:
    """Return the typical force and stiffness of the contacts of M specimens of a problem, with arrays ``(M,)``.

    A contact counts as unloaded if its force is below a limit: the round-off of the typical force. If there are prescribed
    displacements, but neither loads nor preload, perhaps no contact resists the displacements and all contact forces tend
    to zero. The limit is then higher, so that such contacts count as unloaded.

    Parameters
    ----------
    problem
        Arrays of the static problem of one specimen.
    C
        Hertz constants ``(M, N, 4)`` [m/N^(2/3)] of the specimens.
    interference
        Nominal interferences ``(M, N, 2)`` [m] of their balls with both pairs of opposite flanks.
    known
        Lower bound of the typical force [N] that is known otherwise, such as from a solution.
    """
    arm, load = problem.moment_arm, np.abs(problem.load)
    pair = (C[..., 0] + C[..., 3]).mean(axis=1)
    closed = interference.max(axis=(1, 2), initial=0.0)
    squeeze = contact_force(np.where(closed > round_off_approach(problem), closed, 0.0), pair)
    (applied, turning), (largest, most) = ((x[:3], x[3:]) for x in (load.sum(axis=0), load.max(axis=0)))
    share = float(applied.sum() + turning.sum() / arm) / max(1, problem.C.shape[0])
    force = np.maximum(squeeze, max(share, known))
    # without any: only prescribed displacements, or errors by which three flanks clamp a ball
    force = np.where(force > 0.0, force, contact_force(1e-6, pair))
    floor = np.maximum(squeeze, max(float(largest.max()), float(most.max()) / arm))
    return ResidualScale(force, np.cbrt(force) / pair, floor, np.where(floor > 0.0, 1e-14, 1e-10) * force)


def largest_force_by_supports(problem: Problem) -> float:
    """Return the force [N] of a contact that takes up the largest displacement which supports prescribe; 0 without any.

    ``problem``: arrays of the static problem. Rotations count as rotation times pitch radius. The force is an upper bound,
    as the shaft takes up most of such a displacement.
    """
    moved = np.abs(problem.prescribed) * np.repeat([1.0, problem.scene.track.pitch_radius], 3)
    pair = float((problem.C[:, 0] + problem.C[:, 3]).mean()) if problem.C.size else float("nan")
    return float(contact_force(float(moved.max(initial=0.0)), pair))


@dataclass(kw_only=True)
class SingleNutEquations(settle.StaticEquations):
    """Equations of one ball nut or ball bearing: bodies and balls for the solver, with the state of its iteration."""

    #: Arrays of the static problem.
    problem: Problem
    #: Input of the problem, from which it is built again for other lever arms or another typical force.
    problem_input: StaticInput
    #: All balls between four flanks, as one member, also where the solver takes them between one pair.
    balls: Balls
    #: The screw's beam with its supports.
    shaft: statics_shaft.ShaftBeam
    #: Compliance of screw, nut and balls at the flanks; None: they are rigid apart from Hertz's contacts.
    flank_compliance: FlankCompliance | None
    #: Typical contact force [N] at which the terms of the contact law are evaluated.
    typical_force: float
    #: Assumptions about the bodies, as sentences for the report.
    assumed: tuple[str, ...]
    #: Motions of the beam's nodes in the solution ``(n, 6)`` [m, rad]; None before, and with elastic bodies.
    nodal_motion: Array | None = None

    @property
    def problems(self) -> Sequence[Problem]:
        """Return the contact problem of the nut or bearing, in a sequence of length one."""
        return (self.problem,)

    @property
    def only_flank_pair(self) -> tuple[int, int] | None:
        """Return the numbers of the two flanks if only one pair of diagonally opposite flanks has contacts.

        The numbers are 0 screw left, 1 screw right, 2 nut left, 3 nut right; the screw's flank comes first. None if all
        four flanks have contacts. For such a pair the position of the ball follows in closed form.
        """
        return only_flank_pair(self.problem)

    def solve_by_newton(self, from_linear: bool = True) -> Search[Outcome]:
        """Solve the equilibrium by Newton's method with the present Hertz constants.

        Parameters
        ----------
        from_linear
            Whether to start from the solution with linear springs in place of the contacts; otherwise from the present
            state.
        """
        balls, pair = self.system.elements.balls, self.only_flank_pair
        if pair is not None:
            assert isinstance(balls, FlankPairs)
            balls.C[0] = self.problem.C[:, list(pair)].sum(axis=1)
        self.nodal_motion = None
        outcome = yield from super().solve_by_newton(from_linear)
        slow = outcome.status != CONVERGED or outcome.iterations > MANY
        if slow and isinstance(self.system.bodies, BeamBodies) and len(self.problem.C) <= DENSE:
            self.system = replace(self.system, bodies=bodies_on_beam(self.problem, self.shaft, False))
            outcome = yield from super().solve_by_newton(from_linear)
        if self.flank_compliance is None:
            self.nodal_motion = self.motion_of_nodes()
            largest = float(self.state.forces.largest[0])
            solved = outcome.status == CONVERGED or (outcome.status == ITERATIONS and outcome.residual <= SOLVED)
            if solved and largest > 0.0 and self.problem.rigid_motion_basis is None:
                self.let_contacts_follow_nodes(largest)
        return outcome

    def motion_of_nodes(self) -> Array:
        """Return the motions of the beam's nodes ``(n, 6)`` [m, rad] by the contact forces and free motions."""
        return statics_shaft.nodal_motions_under_loads(self.shaft, self.nodal_loads(self.state.phi[0]), self.state.a[0])

    def let_contacts_follow_nodes(self, scale: float) -> None:
        """Correct the solution until the contact forces are those by the motions of the nodes, to the last digits.

        Motions of a long shaft under contact forces that almost cancel have more round-off than the contacts tell apart. It
        stays in the motions of the nodes, as a tiny error of the beam, while Newton's steps, whose own round-off is
        proportional to their size, bring the contacts into balance with it. ``scale``: largest contact force [N], by which
        residuals are divided.
        """
        assert self.nodal_motion is not None
        used, best = np.flatnonzero(self.problem.used_flanks[:2]), np.inf
        motion, state, pair = self.nodal_motion, self.state, self.only_flank_pair
        for _ in range(CORRECTIONS):
            moved, v = all_flank_motions_by_screw(self.problem, motion), np.zeros_like(state.motions)
            v[0, :, [0] if pair is not None else used] = moved[:, used].swapaxes(0, 1)
            state = evaluated(self.system, state.phi, state.a, state.elastic, v)
            residual = float(unbalanced_forces(self.system, state)[0]) / scale
            if not residual < 0.5 * best or residual <= FOLLOWED < best == np.inf:
                return
            if best < np.inf or residual <= SOLVED:  # a first state that is no solution must be improved before it counts
                self.nodal_motion, self._state = motion, state
            best = residual
            step, solved = newton_step(self.system, state, ADDED * residual * self.system.limits.stiffness)
            if residual <= TOLERANCE or not solved[0]:
                return
            bent = self.shaft.motions_under_loads(self.nodal_loads(step.phi[0])[:, None])[:, 0]
            rigid = statics_shaft.nodal_motions_of_rigid_screw(self.shaft) @ step.a[0]
            motion = motion + (bent + rigid).reshape(motion.shape)
            state = replace(state, phi=state.phi + step.phi, a=state.a + step.a, elastic=state.elastic + step.elastic)

    def with_lever_arms(self, arms: Sequence[Array]) -> Self:
        """Return equations with new lever arms of the contact forces, and with the present unknowns as initial values.

        ``arms``: sequence of one array ``(N, 4, 2)`` [m], the shifts of the flanks' centres of curvature by profile errors:
        N balls, four flanks (screw left, screw right, nut left, nut right), radial and along the helix's binormal. Contact
        forces act through these centres.
        """
        longer: Any = self.problem_input.build_equations(self.problem_input.build_problem(arms[0]))
        longer.problem.C[:] = self.problem.C
        return longer.start_from(self)  # type: ignore[no-any-return]

    def contact_states(self) -> Sequence[ContactState]:
        """Return contact forces, ball centres and flank motions, as the iteration has them now."""
        problem, forces, moved, pair = self.problem, self.state.forces, self.flank_motions(), self.only_flank_pair
        c = forces.contacts
        if pair is None:
            return (ContactState(problem, c.force[0], c.normal[0], c.tangential[0], forces.centres[0], moved),)
        a, b = pair
        force, normal, tangential = np.zeros((len(moved), 4)), np.zeros((len(moved), 4, 2)), np.zeros((len(moved), 4))
        for s, sign in ((a, 1.0), (b, -1.0)):
            force[:, s], normal[:, s], tangential[:, s] = c.force[0, :, 0], sign * c.normal[0, :, 0], c.tangential[0, :, 0]
        centres = first_ball_centres(problem.balls.one_by_one(), moved)  # it follows from both flanks' motions
        if self.flank_compliance is None and not settle.has_profile_errors(problem):
            centres = place_unloaded_balls_clear(problem, moved, centres, force)
        return (ContactState(problem, force, normal, tangential, centres, moved),)

    def at_forces_of_solution(self) -> Self:
        """Return equations whose typical contact force fits the present state; the same ones if it does already."""
        if self.flank_compliance is None:
            return self
        known = settle.least_typical_force(self.state.forces.contacts.force)
        fitting = residual_scale(self.problem, known).typical_force_for_ellipse
        if abs(fitting - self.typical_force) <= FORCE_SETTLED * self.typical_force:
            return self
        again: Any = replace(self.problem_input, known_force=known).build_equations(self.problem)
        return again.start_from(self)  # type: ignore[no-any-return]

    def forces_on_flanks(self, pushes: Array) -> Array:
        """Return forces on all flanks ``(N, 4, 2)`` [N], radial and along the helix's binormal.

        ``pushes`` ``(N, F, 2)``: those of the state, with which the bodies are in equilibrium. Those by the contact law
        differ by the residual; even so small an error moves a long, compliant screw noticeably.
        """
        pair = self.only_flank_pair
        if pair is None:
            return np.asarray(pushes)
        out = np.zeros((len(pushes), 4, 2))
        out[:, pair[0]], out[:, pair[1]] = pushes[:, 0], -pushes[:, 0]
        return out

    def nodal_loads(self, forces: Array) -> Array:
        """Return the loads ``(6 n,)`` [N, N m] on the beam's nodes that are equivalent to contact forces ``(N, F, 2)``."""
        used = [s for s in range(2) if self.problem.used_flanks[s]]
        pushes = self.forces_on_flanks(forces)[:, used].transpose(1, 0, 2).reshape(-1, 2)
        loads = statics_shaft.nodal_loads_of_flank_forces(self.problem, pushes, used)
        coupling = self.flank_compliance and self.flank_compliance.coupling
        return loads + coupling.nodal_loads_of_jumps(pushes.ravel()) if coupling else loads

    def flank_motions(self) -> Array:
        """Return the motions of the four flanks ``(N, 4, 2)`` [m] in the present state.

        The last axis holds two components in the ball's section plane, radial and along the helix's binormal. A flank
        without contacts moves with the screw's rigid section, or not at all on an elastic body.
        """
        amplitudes = self.state.a[0]
        if self.flank_compliance is None:
            motion = self.motion_of_nodes() if self.nodal_motion is None else self.nodal_motion
            return all_flank_motions_by_screw(self.problem, motion)
        screw, nut, v0, R = self.flank_compliance.flank_motion_terms
        forces = self.forces_on_flanks(self.state.phi[0])
        N, out = len(forces), np.zeros(forces.shape)
        for G, sides in ((screw, (0, 1)), (nut, (2, 3))):
            used = [s for s in sides if self.problem.used_flanks[s]]
            out[:, used] = (G @ forces[:, used].ravel()).reshape(N, len(used), 2)
        out[:, :2] += v0 + R @ amplitudes
        return out

    def round_off_residual(self) -> float:
        """Return the relative residual that rounding errors leave, from the largest motion and the stiffest contact.

        On rigid bodies the contacts at one node of the beam count together. In the balance of a screw that contacts hold,
        the errors of all uneven flanks add up, as independent ones do, at their levers along the nut.
        """
        problem, v0 = self.problem, self.system.bodies.free.v0
        moved = float(np.abs(self.flank_motions()).max()) + float(np.abs(v0).max(initial=0.0))
        if self.flank_compliance is None:
            on_screw = self.contact_states()[0].force[:, :2]
            each = contact_stiffness_under_force(on_screw, problem.C[:, :2])
            stiff = float(np.bincount(problem.first_nodes.ravel(), weights=each.ravel()).max(initial=0.0))
            if settle.has_profile_errors(problem) and self.state.a.size:
                lever = (
                    float(np.abs(problem.layout.z - problem.scene.nut.position).max()) / problem.scene.track.pitch_radius
                )
                stiff = max(stiff, float(np.linalg.norm(each)) * max(1.0, lever))
        else:
            stiff = float(contact_stiffness_under_force(self.state.forces.contacts.force, problem.C.min()).max(initial=0.0))
        return settle.residual_by_round_off(moved, stiff, self.residual_force_scale, [problem])

    def are_balls_clear_of_left_out_flanks(self) -> bool:
        """Return whether no ball touches a flank that the equations leave out.

        On rigid bodies the equilibrium of every ball is computed with all four flanks, while the screw keeps its motion. On
        elastic bodies every ball must be ``MARGIN`` away from these flanks, each of which is taken to move like the other
        flank of the same groove; ``MARGIN`` covers the elastic deformation between both.
        """
        problem, state = self.problem, self.contact_states()[0]
        if self.flank_compliance is None:
            motion = self.motion_of_nodes() if self.nodal_motion is None else self.nodal_motion
            return not np.any(touched_flanks(problem, motion, state.ball_centres, state.force) & ~problem.used_flanks)
        shift = state.flank_motions
        for s in np.flatnonzero(~problem.used_flanks):
            shift[:, s] = shift[:, int(s) ^ 1]
        parts = state.ball_centres[None], shift[None], problem.balls, state.force[None]
        return bool(solutions_clear_of_left_out_flanks(*parts, problem.used_flanks, MARGIN)[0])

    def solved_state(self) -> SolvedState:
        """Return the solution: motions, contact forces and support reactions.

        Neither the motions of the beam's nodes nor the reactions are unknowns of the equations; both follow from the
        contact forces.
        """
        problem, by_flanks = self.problem, self.nodal_loads(self.state.phi[0])
        motion = self.motion_of_nodes() if self.nodal_motion is None else self.nodal_motion
        nodal = np.zeros((problem.nodes.size, 6))
        if problem.rigid_motion_basis is None:
            nodal = statics_shaft.nodal_forces_under_loads(self.shaft, by_flanks) - problem.load - by_flanks.reshape(-1, 6)
        coupling = self.flank_compliance and self.flank_compliance.coupling
        if coupling:
            used = [s for s in range(2) if problem.used_flanks[s]]
            pushes = self.forces_on_flanks(self.state.phi[0])[:, used].transpose(1, 0, 2).reshape(-1, 2)
            motion = coupling.add_jumps_inside_stretches(motion, pushes, problem.fixed)
        held = np.where(problem.fixed, nodal, 0.0)
        scale = max(self.residual_force_scale, float(np.abs(held[:, :3]).max(initial=0.0)))
        return SolvedState(self.contact_states()[0], motion, held, scale)

    def assumed_and_left_out(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Return the assumptions of the model, and the effects that it neglects, as sentences."""
        build = self.problem_input
        if build.backend == LADDER["lin"]:
            return model_assumptions(build.scene), ()
        of_file = build.condensed_bodies
        source = (of_file.describe_source(),) if of_file else idealisation_statements(build.backend, build.scene)
        clipped = self.flank_compliance.clipped_share if self.flank_compliance else 0.0
        cut = f"negative compliance of the bodies, up to {100 * clipped:.2g} % of a contact's, is set to zero"
        return (*ELASTIC_ASSUMPTIONS, *source, *self.assumed), (cut,) if clipped > 1e-6 else ()


def bodies_on_beam(problem: Problem, shaft: statics_shaft.ShaftBeam, sparse: bool) -> DenseBodies | BeamBodies:
    """Return a rigid nut and a screw that is rigid but for its beam, as bodies of one member.

    Parameters
    ----------
    problem
        Arrays of the static problem.
    shaft
        The screw's beam with the supports and loads of the problem.
    sparse
        Whether to solve it by the beam's sparse stiffness matrix, which many balls need.
    """
    pair, N, k = only_flank_pair(problem), len(problem.C), shaft.work_on_free_motions.size
    sides = [s for s in range(2) if problem.used_flanks[s]]
    order = response.permutation_to_ball_by_ball_order(N, len(sides))
    flanks = [0] if pair is not None else sides
    v0, R = np.zeros((1, N, 1 if pair else 4, 2)), np.zeros((1, N, 1 if pair else 4, 2, k))
    v0[0, :, flanks] = statics_shaft.flank_motions_by_loads(shaft, sides).reshape(len(sides), N, 2)
    R[0, :, flanks] = statics_shaft.flank_motions_by_free_motions(shaft, sides).reshape(len(sides), N, 2, k)
    free = FreeMotions(v0, R, shaft.work_on_free_motions[None])
    if sparse:
        return BeamBodies(free, *statics_shaft.sparse_beam(shaft, sides, v0.shape[2]))
    G = statics_shaft.flank_compliance(shaft, sides)[np.ix_(order, order)]
    if pair is not None:
        return DenseBodies(free, Compliances(G[None]))
    screw = response.compliance_of_both_flanks(G, problem.used_flanks[:2], N)
    return DenseBodies(free, Compliances(screw[None], RIGID))


@dataclass(frozen=True)
class StaticInput:
    """Input from which a ball screw's static problem is built, and can be built again.

    It is built again with contacts on other flanks, with other fixed degrees of freedom, or with other lever arms of the
    contact forces.
    """

    #: Scene: screw, nut, balls, supports and loads.
    scene: Scene
    #: Dimensions of screw, nut and balls with their manufacturing errors.
    drawn: GeometryWithErrors
    #: Positions of the balls.
    layout: BallLayout
    #: Which of the four flanks (screw left, screw right, nut left, nut right) get contacts ``(4,)``.
    used_flanks: Mask
    #: Whether to model also flanks that cannot touch a ball, and ends of the shaft that carry no load.
    everything: bool = False
    #: Number of elements that each beam element is split into.
    refine: int = 1
    #: Three entries: which degrees of freedom of the n nodes are fixed ``(n, 6)``; their prescribed values ``(n, 6)`` [m,
    #: rad]; and the "pins", numbers of the degrees of freedom of the first node that are fixed although no support fixes
    #: them. None: only those degrees of freedom are fixed that the scene's supports fix.
    fixed_dofs: tuple[NDArray[np.bool_], Array, tuple[int, ...]] | None = None

    #: Method by which the compliance of screw, nut and balls is computed.
    backend: ComplianceModel = LADDER["lin"]
    #: Compliance of the bodies condensed from a 3D model, in place of a computed one; None: computed.
    condensed_bodies: CondensedCompliance | None = None
    #: Function that computes the compliance of one complete screw or nut between its contacts.
    compute_body_compliance: WholeBody = compliance_between_contacts
    #: Least typical contact force by a solution of the same problem [N]; None: estimated from prescribed displacements.
    known_force: float | None = None

    @property
    def has_rigid_bodies(self) -> bool:
        """Return whether screw, nut and balls are rigid apart from Hertz's contacts and the screw's beam."""
        of = self.backend
        rigid = (of.screw, of.nut, of.ball, of.flank) == ("beam", "rigid", "half space", False)
        return rigid and self.condensed_bodies is None

    @property
    def replacement_section(self) -> BeamSection | None:
        """Return the screw's cross-section with its groove, if the ``backend`` computes one; None: a plain section is used.

        The plain section follows from the scene's dimensions.
        """
        return grooved_section(reduce_to_compliance_geometry(self.scene), True) if self.backend.section == "cell" else None

    def least_force(self, problem: Problem) -> float:
        """Return the least typical force [N] of the contacts of a ``problem`` that is known otherwise than by its loads."""
        if self.has_rigid_bodies:
            return 0.0
        return largest_force_by_supports(problem) if self.known_force is None else self.known_force

    def build_problem(self, arms: Array | None = None) -> Problem:
        """Return the arrays of the static problem.

        Parameters
        ----------
        arms
            Shifts of the flanks' centres of curvature by profile errors ``(N, 4, 2)`` [m], None for zero: N balls, four
            flanks (screw left, screw right, nut left, nut right), radial and along the helix's binormal.
        """
        parts = self.scene, self.drawn, self.layout, self.used_flanks
        how: dict[str, Any] = {"everything": self.everything, "refine": self.refine}
        found = build_problem(*parts, arms=arms, section=self.replacement_section, **how)
        held = self.fixed_dofs
        return found if held is None else replace(found, fixed=held[0], prescribed=held[1], pins=held[2])

    def with_supports_of(self, pinned: Problem) -> Self:
        """Return a copy of this input with the fixed degrees of freedom of the problem ``pinned``.

        Pins, which are fixed although no support fixes them, are included.
        """
        return replace(self, fixed_dofs=(pinned.fixed, pinned.prescribed, pinned.pins))

    def build_equations(self, problem: Problem) -> SingleNutEquations:
        """Return the equations of the problem.

        Raises
        ------
        UnfitKey
            If there are more than ``LARGEST`` balls between elastic bodies.
        ValueError
            If a body has impossible dimensions.
        """
        N = self.layout.z.size
        scale, pair = residual_scale(problem, self.least_force(problem)), only_flank_pair(problem)
        balls = problem.balls
        flanks: FlankCompliance | None = None
        assumed: tuple[str, ...] = ()
        bodies: DenseBodies | BeamBodies
        if self.has_rigid_bodies:
            shaft = statics_shaft.build_shaft(problem)
            bodies = bodies_on_beam(problem, shaft, N > SPARSE)
        else:
            if N > LARGEST:
                reason = (
                    f"balls.count gives {N} balls: elastic bodies are allowed with at most {LARGEST}; use the model lin"
                )
                raise UnfitKey("balls.count", reason)
            how = self.backend, self.condensed_bodies, self.compute_body_compliance
            compliance = response.compliance_of_screw_and_nut(problem, *how)
            shaft, assumed = compliance.shaft_beam.with_loads_of(problem), compliance.assumed
            flanks = response.flank_compliance_under_loads(problem, scale.typical_force_for_ellipse, shaft, compliance)
            ball, bodies = compliance.ball_compliance, flanks.bodies
            coupled, e = np.zeros((1, N, 4)), flanks.e
            if pair is None:
                sign = ball.pair_coupling_sign
                coupled[...] = ball.pair_coupling_root * np.array([1.0, sign, sign, 1.0])
            else:  # there is no other pair with which the ball could couple it
                e = e + 2.0 * ball.pair_coupling_root**2
            balls = replace(balls, e=e[None], h=flanks.h[None], body=coupled)
        between = balls if pair is None else between_opposite_flanks(balls, pair[0])
        system = StaticSystem(
            bodies,
            RollingElements(between, None, np.array([scale.unloaded_force_limit])),
            starting_springs(balls, pair, scale.stiffness),
            settle.limits_of(scale, float(problem.drawn.ball_radii.max())),
        )
        return SingleNutEquations(
            system=system,
            problem=problem,
            problem_input=self,
            balls=balls,
            shaft=shaft,
            flank_compliance=flanks,
            typical_force=scale.typical_force_for_ellipse,
            assumed=assumed,
        )

    def note_on_touched_flanks(self) -> str:
        """Return the note for the result that balls touched left-out flanks, so that all four flanks were solved."""
        if not self.has_rigid_bodies:
            return "two of the four flanks may touch balls in the solution without them: solved again with all four flanks"
        names = ", ".join(name for name, used in zip(SIDES, self.used_flanks, strict=True) if not used)
        return f"flanks {names} touch balls in the solution without these flanks: solved again with all four flanks"
