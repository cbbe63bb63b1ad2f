"""Many specimens of one ball screw or bearing with random errors, solved together as members of one system.

The compliance of bodies, shaft and supports is the same for all specimens whose random errors concern the radii of the
balls only; approaches, Hertz constants, and the terms that depend on the typical contact force differ. Between rigid bodies
the errors of the grooves' centres may differ too: each specimen then has lever arms, and so a compliance, of its own.
Flanks that should carry no load are left out; specimens whose errors bring them near their balls form a second group with
all flanks. Each specimen is solved from the solution of the first one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.compliance.parts import LADDER, ComplianceModel
from rollbench.lowfi.statics import problem as statics_problem
from rollbench.lowfi.statics import shaft as statics_shaft
from rollbench.lowfi.statics import static
from rollbench.lowfi.statics.contacts import hertz_constants_by_scene_choice
from rollbench.lowfi.statics.equations import (
    MARGIN,
    SPARSE,
    SingleNutEquations,
    StaticInput,
    bodies_on_beam,
    residual_scales,
)
from rollbench.lowfi.statics.equilibrium import (
    CONVERGED,
    ITERATIONS,
    ForceState,
    Limits,
    StaticSystem,
    find_equilibrium,
    stacked,
)
from rollbench.lowfi.statics.problem import PlacedBalls, place_balls
from rollbench.lowfi.statics.rolling_elements import Balls, between_opposite_flanks, first_ball_centres
from rollbench.lowfi.statics.selection import (
    all_flank_motions_by_screw,
    choose_flanks,
    flanks_of_scene,
    solutions_clear_of_left_out_flanks,
)
from rollbench.lowfi.statics.settle import ACCEPTED
from rollbench.lowfi.statics.shape import rigid_motion_transfer_matrix
from rollbench.lowfi.together import solve_alone
from rollbench.meshes import errors
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene

Ints = NDArray[np.int64]
#: Distance [m] of a ball from a left-out flank of a rigid body below which a specimen is solved with all flanks.
NEAR = 1e-7


@dataclass(frozen=True)
class MemberLoads:
    """Solutions of M consecutive specimens; all values are nan for a specimen that needs `solve_elastic`."""

    #: Contact loads ``(M, N, 4)`` [N].
    loads: Array
    #: Relative residuals ``(M,)``.
    residuals: Array
    #: Motions ``(M, s, 6)`` [m, rad] of s sections of the screw.
    motions: Array
    #: Axial force ``(M,)`` [N] of the screw on the nut.
    forces: Array
    #: Number of specimens that were solved with contacts on all flanks.
    all_flanks_count: int


class _Group(NamedTuple):
    """Solved specimens with contacts on the same flanks."""

    #: Numbers of the specimens among those that were asked for.
    members: Ints
    phi: Array
    a: Array


def can_share_equations(scene: Scene, backend: ComplianceModel) -> bool:
    """Return whether the specimens of a scene can be solved together (`SpecimensOfScene`).

    Their flanks must be equal circular arcs and their Hertz constants must not depend on the actual contact angle. Between
    elastic bodies, and where many balls need the sparse stiffness of the beam, only the radii of the balls may differ.

    Parameters
    ----------
    scene
        Scene with random errors.
    backend
        Method by which the compliance of screw, nut and balls is computed.
    """
    if not errors.have_equal_circular_grooves(scene) or scene.ingredients.hertz == "actual":
        return False
    rigid = backend in (LADDER["lin"], LADDER["lin-cell"])
    if rigid and scene.ball_count <= SPARSE:
        return True
    two = errors.draw_geometries_with_errors(scene, ball_layout(scene), 0, 2)
    return len(two.groove_centres) == 1 and (rigid or scene.ingredients.screw != "rigid")


class SpecimensOfScene:
    """Solver for specimens of a ball screw with random errors; `can_share_equations` tells whether it fits a scene."""

    def __init__(
        self,
        scene: Scene,
        backend: ComplianceModel,
        previous: SpecimensOfScene | None = None,
        sections: tuple[float, ...] = (),
    ) -> None:
        """Store the scene; the equations are built when the first specimen is solved.

        Parameters
        ----------
        scene
            Screw, nut and balls with random errors, supports and loads.
        backend
            Method by which the compliance of screw, nut and balls is computed.
        previous
            The same specimens under nearly the same loads, solved before; their solutions are the starts of the iteration.
            None: each specimen starts from the solution of specimen 0.
        sections
            Axial positions [m] of the sections of the screw whose motions are asked for.
        """
        self.scene, self.backend, self.previous, self.sections = scene, backend, previous, sections
        self.layout = ball_layout(scene)
        self._equations: dict[bytes, _SharedEquations | None] = {}
        self._groups: dict[tuple[int, bytes], _Group] = {}  # by number of the first specimen, and flanks

    def solve(self, first: int, count: int) -> MemberLoads:
        """Compute the contact loads of consecutive specimens.

        Parameters
        ----------
        first
            Number of the first specimen.
        count
            Number of specimens.
        """
        drawn = errors.draw_geometries_with_errors(self.scene, self.layout, first, count)
        nominal = errors.draw_geometry_with_errors(errors.scene_without_random_errors(self.scene), self.layout)
        placed, C = place_balls(self.scene, drawn), hertz_constants_by_scene_choice(self.scene, nominal, drawn.ball_radii)
        loads, (residuals, forces) = np.full((count, self.layout.z.size, 4), np.nan), np.full((2, count), np.nan)
        motions = np.full((count, len(self.sections), 6), np.nan)
        self._groups.clear()
        whole, every, members = flanks_of_scene(self.scene), 0, np.arange(count)
        # flanks that carry no load if no ball is too large are left out, which is then verified specimen by specimen
        few = choose_flanks(self.scene, replace(nominal, ball_radii=drawn.ball_radii.min(axis=0)))
        for use in (few, whole) if not np.array_equal(few, whole) else (whole,):
            equations = self._equations_for_flanks(use)
            if equations is None or not members.size:
                continue
            near = self.previous._groups.get((first, use.tobytes())) if self.previous else None
            near = near if near is not None and np.array_equal(near.members, members) else None
            of = PlacedBalls(*(np.broadcast_to(x, (count, *x.shape[1:]))[members] for x in placed))
            own = drawn.groove_centres[members] if len(drawn.groove_centres) > 1 else None
            state, found, good = equations.solve(of, C[members], drawn.ball_radii[members], own, near)
            self._groups[first, use.tobytes()] = _Group(members, state.phi, state.a)
            done = members[good]
            loads[done], residuals[done], motions[done], forces[done] = (x[good] for x in found)
            every += int(good.sum()) if np.array_equal(equations.of.problem.used_flanks, whole) else 0
            members = members[~good]
        return MemberLoads(loads, residuals, motions, forces, every)

    def _equations_for_flanks(self, used: Mask) -> _SharedEquations | None:
        """Return the equations with contacts on the flanks ``used``, solved for specimen 0, for use by other specimens.

        If balls of specimen 0 touch a flank that was left out, the equations have all four flanks. None if specimen 0 has
        no solution or its equations fit no other specimen.
        """
        key = used.tobytes()
        if key not in self._equations:
            self._equations[key] = None
            drawn = errors.draw_geometry_with_errors(self.scene, self.layout)
            problem_input = StaticInput(self.scene, drawn, self.layout, used, backend=self.backend)
            solved = solve_alone(static.solve_with_chosen_flanks(problem_input))
            if isinstance(solved, static.SolvedEquations) and solved.status == "converged":
                flanks = solved.system.flank_compliance
                if flanks is None or flanks.compliance_moved_to_bodies == 0.0:
                    self._equations[key] = _SharedEquations(solved.system, self.sections)
        return self._equations[key]


class _SharedEquations:
    """Equations of one solved specimen, from which those of other specimens are made."""

    def __init__(self, of: SingleNutEquations, sections: tuple[float, ...]) -> None:
        """Store solved equations, whose solution is the start of the iteration for other specimens.

        ``sections``: axial positions [m] of the sections of the screw whose motions are asked for.
        """
        self.of = of
        basis, nodes = of.problem.rigid_motion_basis, of.problem.nodes
        #: Motions of s sections per unit motion of the n nodes ``(6 s, 6 n)``; axial force on the nut per unit load on a
        #: node by the contacts ``(6,)``.
        self.of_nodes, self.axial = np.zeros((0, 6 * nodes.size)), -np.eye(6)[2]
        if basis is not None:
            self.axial = -np.linalg.inv(basis)[:, 2]
            if sections:
                self.of_nodes = (rigid_motion_transfer_matrix(np.array(sections) - nodes[0]) @ basis).reshape(-1, 6)
        elif sections:
            weights = np.array([np.interp(sections, nodes, one) for one in np.eye(nodes.size)])
            self.of_nodes = np.kron(weights.T, np.eye(6))
        self.terms = None if of.flank_compliance is None else _motions_of_sections(of, self.of_nodes)

    def solve(
        self, placed: PlacedBalls, C: Array, radii: Array, centres: Array | None, near: _Group | None
    ) -> tuple[ForceState, tuple[Array, Array, Array, Array], Mask]:
        """Compute the contact loads of M specimens.

        Parameters
        ----------
        placed
            Where the balls lie between the flanks, with M as first axis.
        C
            Hertz constants ``(M, N, 4)`` [m/N^(2/3)].
        radii
            Radii of the balls ``(M, N)`` [m].
        centres
            Centres of the groove arcs ``(M, N, 4, 2)`` [m] in the balls' section planes; None: those of specimen 0.
        near
            Solutions from which to iterate; None: that of specimen 0.

        Returns
        -------
        tuple[ForceState, tuple[Array, Array, Array, Array], Mask]
            States; contact loads ``(M, N, 4)`` [N], relative residuals ``(M,)``, motions of the s sections ``(M, s, 6)``
            [m, rad] and axial forces of the screw on the nut ``(M,)`` [N]; and which specimens are solved: converged, and
            clear of the flanks that were left out.
        """
        of, count = self.of, len(C)
        B = None if centres is None else statics_problem.flank_motions_of_specimens(of.problem, centres)
        system, balls = self._system(placed, C, radii, B)
        start = (near.phi, near.a) if near else tuple(np.repeat(x, count, axis=0) for x in (of.state.phi, of.state.a))
        state, outcome = find_equilibrium(system, (start[0], start[1]))
        contacts, pair = state.forces.contacts, of.only_flank_pair
        loads, pushes = np.zeros((count, *C.shape[1:])), np.zeros((count, *C.shape[1:], 2))
        for k, s in enumerate(range(4) if pair is None else pair):
            c = k if pair is None else 0
            loads[:, :, s] = contacts.force[:, :, c]
            sign = -1.0 if pair is not None and k == 1 else 1.0
            pushes[:, :, s] = sign * contacts.force[:, :, c, None] * contacts.normal[:, :, c]
        good = np.isin(outcome.status, (CONVERGED, ITERATIONS)) & (outcome.residual <= ACCEPTED)
        moved, motions, forces = self._motions_and_forces(pushes, state.a, B)
        if not np.array_equal(of.problem.used_flanks, flanks_of_scene(of.problem.scene)):
            where = state.forces.centres
            if pair is not None:
                where = first_ball_centres(balls.one_by_one(count), moved.reshape(-1, 4, 2)).reshape(count, -1, 2)
            margin = NEAR if of.flank_compliance is None else MARGIN
            good &= solutions_clear_of_left_out_flanks(where, moved, balls, loads, of.problem.used_flanks, margin)
        return state, (loads, outcome.residual, motions, forces), good

    def _system(self, placed: PlacedBalls, C: Array, radii: Array, B: Array | None) -> tuple[StaticSystem, Balls]:
        """Return bodies and balls of M specimens; ``B``: motions of the screw's flanks per unit motion of the nodes."""
        of, pair, bodies = self.of, self.of.only_flank_pair, self.of.system.bodies
        known = of.problem_input.least_force(of.problem)
        scale = residual_scales(of.problem, C, placed.interference, known)
        balls = replace(of.balls, **placed._asdict(), C=C, radius=radii)
        if of.flank_compliance is not None:
            size, first = np.cbrt(scale.typical_force_for_ellipse)[:, None, None], float(np.cbrt(of.typical_force))
            slope = of.flank_compliance.slope_of_e
            balls = replace(
                balls, e=of.balls.e + slope * np.log(size / first), h=of.balls.h + slope * (1.0 / size - 1.0 / first)
            )
        if B is not None:
            problems = (replace(of.problem, B=b) for b in B)
            bodies = stacked([bodies_on_beam(p, replace(of.shaft, problem=p), sparse=False) for p in problems])
        between = balls if pair is None else between_opposite_flanks(balls, pair[0])
        limits = Limits(scale.stiffness, scale.least_force_scale, radii.max(axis=1))
        elements = replace(of.system.elements, balls=between, unloaded=scale.unloaded_force_limit)
        return replace(of.system, bodies=bodies, elements=elements, limits=limits), balls

    def _motions_and_forces(self, pushes: Array, a: Array, B: Array | None) -> tuple[Array, Array, Array]:
        """Return the motions of all flanks ``(M, N, 4, 2)`` [m] and of the sections, and the forces on the nut.

        Motions of the sections ``(M, s, 6)`` [m, rad]; axial forces of the screw on the nut ``(M,)`` [N]. A flank without
        contacts moves with the screw's rigid section, or like the other flank of its groove on an elastic body. ``pushes``
        ``(M, N, 4, 2)``: forces on the flanks [N]; ``a`` ``(M, k)``: amplitudes of the free motions [m].
        """
        of, problem = self.of, self.of.problem
        used = [s for s in range(2) if problem.used_flanks[s]]
        on_screw = pushes[:, :, used].swapaxes(1, 2)
        rows = np.broadcast_to(problem.B if B is None else B, (len(pushes), *problem.B.shape))
        on_nodes = np.einsum("mnsak,mnsa->mk", rows[:, :, used], pushes[:, :, used])
        forces = on_nodes.reshape(len(pushes), -1, 6).sum(axis=1) @ self.axial
        if of.flank_compliance is None:
            loads = np.zeros((6 * problem.nodes.size, len(pushes)))
            for k, s in enumerate(used):
                dof = 6 * problem.first_nodes[:, s, None] + np.arange(problem.B.shape[3])
                added = np.einsum("mnak,mna->nkm", rows[:, :, s], on_screw[:, k])
                np.add.at(loads, dof, added)
            motion = statics_shaft.nodal_motions_under_loads(of.shaft, loads, a.T).transpose(2, 0, 1)
            motions = motion.reshape(len(pushes), -1) @ self.of_nodes.T
            return all_flank_motions_by_screw(problem, motion), motions.reshape(len(pushes), -1, 6), forces
        screw, nut, v0, R = of.flank_compliance.flank_motion_terms
        out = np.zeros(pushes.shape)
        for G, sides in ((screw, (0, 1)), (nut, (2, 3))):
            own = [s for s in sides if problem.used_flanks[s]]
            out[:, :, own] = (pushes[:, :, own].reshape(len(pushes), -1) @ G).reshape(len(pushes), -1, len(own), 2)
        out[:, :, :2] += v0 + np.einsum("nsak,mk->mnsa", R, a)
        for left_out in np.flatnonzero(~problem.used_flanks).tolist():
            out[:, :, left_out] = out[:, :, left_out ^ 1]
        assert self.terms is not None
        by_pushes, by_motions, at_rest = self.terms
        motions = on_screw.reshape(len(pushes), -1) @ by_pushes + a @ by_motions + at_rest
        return out, motions.reshape(len(pushes), -1, 6), forces


def _motions_of_sections(of: SingleNutEquations, of_nodes: Array) -> tuple[Array, Array, Array]:
    """Return the coefficients of a linear function that gives the motions of s sections of the screw ``(6 s,)`` [m, rad].

    Variables of the function are contact forces and amplitudes of the rigid motions that no support prevents (free
    motions). Returns three values: the derivatives by the forces of the balls on the c screw flanks ``(2 c, 6 s)`` [m/N],
    those by the amplitudes of the k free motions ``(k, 6 s)``, and the constant part. By Maxwell's reciprocity the first
    are the motions of the flanks by unit loads on the sections. ``of_nodes``: see `_SharedEquations`.
    """
    assert of.flank_compliance is not None
    problem, shaft, coupling = of.problem, of.shaft, of.flank_compliance.coupling
    load = of_nodes.T
    dof, rows = statics_shaft.flank_motion_coefficients(problem, [s for s in range(2) if problem.used_flanks[s]])
    by_flanks = np.zeros((len(load), 2 * len(rows)))
    for c in range(len(rows)):
        by_flanks[dof[c], 2 * c], by_flanks[dof[c], 2 * c + 1] = rows[c]
    given, inside = np.zeros(len(load)), np.zeros((by_flanks.shape[1], load.shape[1]))
    if coupling is not None:
        by_flanks += coupling.wrenches_per_nodal_motion.T @ coupling.jumps_per_flank_force
        given = coupling.wrenches_per_nodal_motion.T @ coupling.jumps_by_external_loads
        inside = coupling.flank_motions_by_nodal_loads(np.where(problem.fixed.reshape(-1, 1), 0.0, load))
    moved = statics_shaft.nodal_motions_under_loads(shaft, given, np.zeros(of.state.a.size)).ravel()
    by_motions = statics_shaft.nodal_motions_of_rigid_screw(shaft).T @ load
    return by_flanks.T @ shaft.motions_under_loads(load) + inside, by_motions, moved @ load
