"""Several rolling sets with elastic bodies: compliance of shaft, housings and of each set's bodies at all flanks.

The shaft is a beam with its supports; beyond it the screw, nut and balls of a set respond to contact loads as in the
refined model of one set (`lowfi.compliance`), as long as the force is of that set: between sets act only beam and housings,
and the beam's section forces, which squeeze the contacts (`lowfi.statics.shaft`).
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
from rollbench.lowfi.compliance.parts import REFINED, Backend, geometry_only, grooved_section
from rollbench.lowfi.statics.axis.solve import Model, Sets, equilibrium, inverse, rigid_rows, solve_assembly
from rollbench.lowfi.statics.axis.structure import Structure, threaded
from rollbench.lowfi.statics.axis.system import (
    BallSet,
    RollerElements,
    System,
    asked_row,
    roller_elements,
    roller_springs,
    scale_of,
    set_flanks,
    typical_force,
    widened,
    with_arms,
)
from rollbench.lowfi.statics.contacts import error_free_hertz, oblique_term
from rollbench.lowfi.statics.elastic import CONDENSED
from rollbench.lowfi.statics.kernel_types import BallContacts, Bodies, BodyState, BodySystem, RowState
from rollbench.lowfi.statics.problem import Problem
from rollbench.lowfi.statics.response import (
    LARGEST,
    by_ball,
    contact_compliance,
    normals_of,
    positive,
    spring_rows,
    typical_axes,
)
from rollbench.lowfi.statics.result import AxisResult
from rollbench.lowfi.statics.settle import Description, SetFlanks, least_residual, options_of
from rollbench.lowfi.statics.shaft import (
    Shaft,
    Squeeze,
    flank_loads,
    flank_motions_by_loads,
    flank_response,
    node_forces,
    node_motions,
    shaft_of,
    squeezed,
    stretch_of,
)
from rollbench.lowfi.statics.shape import pivots
from rollbench.lowfi.statics.static import Engine
from rollbench.lowfi.statics.summary import ELASTIC_ASSUMPTIONS
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly, RollerRow
from rollbench.meshes.section import BeamSection

#: Statements that hold for every run of the refined model on several sets.
ASSUMPTIONS = (
    "the shaft is a Timoshenko beam between its sets; beyond the beam the screw, nut and balls of a set are elastic for "
    "that set's own contacts, and feel those of another set by the section forces of the shaft",
    "housings are rigid; nuts and outer rings are held in them as a scene of one set holds them",
    *ELASTIC_ASSUMPTIONS,
)
#: What a row of rollers leaves out.
RIGID_RINGS = "elastic rings: cone and cup are rigid beyond the line contacts, whose law holds both to their depth"

#: What an inner ring on a housing leaves out.
RIGID_INNER = "elastic inner ring: as the housing that it sits on, it is rigid beyond its contacts"


@dataclass(frozen=True)
class Housings:
    """Housings of an assembly as one linear body of m moving housings."""

    #: Free freedoms.
    free: NDArray[np.int64]
    #: Factor of their stiffness.
    factor: tuple[Array, bool] | None
    #: Stiffness of all freedoms.
    stiffness: Array
    #: Motions that nothing resists ``(6 m, k)``, which pins at some freedoms determine.
    motions: Array
    #: Motion by loads and prescribed displacements ``(6 m,)``.
    given: Array
    #: Work of the loads on the motions ``(k,)``.
    work: Array

    def solve(self, loads: Array) -> Array:
        """Return motions ``(6 m, c)`` by loads ``(6 m, c)``, with the loose motions pinned."""
        out = np.zeros_like(loads)
        if self.factor is not None:
            out[self.free] = cho_solve(self.factor, loads[self.free])
        return out


@dataclass(kw_only=True)
class ElasticSets(Sets):
    """Assembly of elastic bodies with N balls and m housings, ready for the kernels."""

    SOLVER = "solve_forces"
    #: Bodies and rolling elements as the kernels take them.
    given: BodySystem
    #: Forces, free motions and contacts.
    state: BodyState
    #: Model of the bodies' compliance.
    backend: Backend
    #: All balls and rollers as one problem on the shaft.
    whole: Problem
    #: Beam of the shaft.
    shaft: Shaft
    #: The housings.
    housings: Housings
    #: Motion of the nuts' flanks by the housings ``(4 N, 6 m)``.
    on_housings: Array
    #: Motion of inner flanks that housings carry ``(4 N, 6 m)``.
    carried: Array
    #: Compliance of each set's screw and nut, ball by ball ``(4 N_s, 4 N_s)`` each [m/N].
    own: list[tuple[Array, Array]]
    #: Assumptions about the bodies.
    assumed: tuple[str, ...]
    #: Coupling with the shaft's section forces; None without it.
    squeeze: Squeeze | None

    def flanks(self) -> Sequence[SetFlanks]:
        """Return the contacts at the state."""
        return set_flanks(self.system, self.row_states()[0], self.shifts())

    def with_arms(self, arms: Sequence[Array]) -> Self:
        """Return the system with longer lever arms, as `Prepared.with_arms`."""
        longer: Any = ready(with_arms(self.system, arms), self.backend, self.engine).at_state(self)
        return longer  # type: ignore[no-any-return]

    def round_off(self) -> float:
        """Return the residual that rounding leaves, by the largest motions and the stiffest contact."""
        state, v0 = self.state, self.given.bodies.v0
        motion = 2.0 * float(np.abs(v0).max(initial=0.0)) + float(np.abs(state.inner[:, :2]).max(initial=0.0))
        return least_residual(motion, float(state.contact[..., 3].max(initial=0.0)), self.scale, self.problems)

    def description(self) -> Description:
        """Return the description of the model, as `Prepared.description`."""
        return Description(CONDENSED, self.state.phi.size + self.state.a.size, self.assumed)

    def forces(self) -> Array:
        """Return the forces of the balls on their flanks ``(N, 4, 2)`` [N]: those that the bodies are in equilibrium with.

        A long shaft makes motions of their difference from the contacts' law.
        """
        return self.state.phi.reshape(-1, 4, 2)

    def shifts(self) -> Array:
        """Return the motions of all flanks ``(N, 4, 2)`` [m]."""
        bodies, forces = self.given.bodies, self.forces()
        N = len(forces)
        out = (bodies.v0 + bodies.R @ self.state.a).reshape(N, 4, 2)
        for G, half in ((bodies.first, slice(2)), (bodies.second, slice(2, 4))):
            out[:, half] += (G @ forces[:, half].ravel()).reshape(N, 2, 2)
        return np.asarray(out)

    def row_states(self) -> tuple[RowState, Array]:
        """Return motions and reactions, as `Sets.row_states`."""
        system, shaft = self.system, self.shaft
        structure, forces = system.structure, self.forces()
        n, k = structure.nodes.size, shaft.work.size
        pushes = forces[:, :2].transpose(1, 0, 2).reshape(-1, 2)
        q = np.zeros((structure.stations.size, 6))
        by_flanks = flank_loads(self.whole, pushes, [0, 1])
        if self.squeeze is not None:
            by_flanks += self.squeeze.node_loads(pushes.ravel())
        q[:n] = node_motions(shaft, by_flanks, self.state.a[:k])
        on_outer = self.on_housings.T @ forces[:, 2:].ravel() + self.carried.T @ forces[:, :2].ravel()
        h = self.housings
        outer = h.given + h.solve(on_outer[:, None])[:, 0] + h.motions @ self.state.a[k:]
        q[n:] = outer.reshape(-1, 6)
        loads = structure.load.copy()
        loads[:n] += by_flanks.reshape(-1, 6)
        loads[n:] += on_outer.reshape(-1, 6)
        taken = np.concatenate([node_forces(shaft, by_flanks), (h.stiffness @ outer).reshape(-1, 6)])
        held = np.where(structure.fixed, taken - loads, 0.0)
        slices = np.zeros((system.slices.drop.size, 2))
        self.engine.roller_forces(system.slices, q, slices, np.zeros_like(q))
        if self.squeeze is not None:
            q[:n] = self.squeeze.with_inside(q[:n], pushes, structure.fixed[:n])
        state = RowState(q, np.zeros((n - 1, 6)), self.state.inner[:, :2], self.state.contact, slices)
        return state, held

    def stiffness(self) -> tuple[Sequence[Array], Array | None]:
        """Return stiffness matrices, as `Sets.stiffness`."""
        S = ball_roots(self)
        return [own_stiffness(self, i, b, S) for i, b in enumerate(self.system.balls)], elastic_stiffness(self, S)


def housings_of(structure: Structure, arm: float) -> Housings:
    """Return the housings with the springs between them and to the frame."""
    n, m = structure.nodes.size, structure.at.size
    K = np.zeros((6 * m, 6 * m))
    for ends, reach, stiffness in zip(structure.ends, structure.reach, structure.springs, strict=True):
        J = np.zeros((6, 6 * m))
        for e, row in enumerate(ends):
            if row >= 0:
                J[:, 6 * (row - n) : 6 * (row - n) + 6] += reach[e]
        K += J.T @ stiffness @ J
    held, prescribed = structure.fixed[n:].ravel(), structure.prescribed[n:].ravel()
    load, free = structure.load[n:].ravel(), np.flatnonzero(~structure.fixed[n:].ravel())
    scale = np.tile([1.0, 1.0, 1.0, 1.0 / arm, 1.0 / arm, 1.0 / arm], m)
    motions = np.zeros((6 * m, 0))
    if free.size:
        value, vector = np.linalg.eigh(scale[free, None] * K[np.ix_(free, free)] * scale[None, free])
        loose = vector[:, value <= 1e-12 * max(float(value.max()), 1e-300)]
        motions = np.zeros((6 * m, loose.shape[1]))
        motions[free] = scale[free, None] * loose
        if loose.shape[1]:
            free = np.delete(free, pivots(loose.T))
    given = np.where(held, prescribed, 0.0)
    factor = cho_factor(K[np.ix_(free, free)], lower=True) if free.size else None
    found = Housings(free, factor, K, motions, given, motions.T @ load)
    return replace(found, given=given + found.solve((load - K @ given)[:, None])[:, 0])


def on_shaft(b: BallSet) -> Problem:
    """Return the set's problem with inner flanks on the shaft, or on nothing where a housing carries them."""
    p = b.problem
    return p if b.of.carrier is None else replace(p, node=np.zeros_like(p.node), B=np.zeros_like(p.B))


def section_of(assembly: Assembly, backend: Backend) -> BeamSection | None:
    """Return the section of the threaded shaft by a backend; None: the scene's."""
    thread = threaded(assembly) if backend.section == "cell" else None
    return None if thread is None else grooved_section(geometry_only(thread), True)


def combined(system: System, rollers: RollerElements) -> Problem:
    """Return all balls of all sets, then all rollers, as one problem on one shaft, for the beam only."""
    s, problems = system.structure, [on_shaft(b) for b in system.balls]
    first = problems[0]
    on_cones = np.stack([rollers.B[:, 0], np.zeros((rollers.count, 2, 6))], axis=1)
    at_cones = np.repeat(rollers.node[:, None], 2, axis=1)
    at_cones, on_cones = widened(at_cones, on_cones, first.B.shape[3], s.nodes.size)
    return replace(
        first,
        fixed=s.fixed[: s.nodes.size],
        node=np.concatenate([*(p.node for p in problems), at_cones]),
        B=np.concatenate([*(p.B for p in problems), on_cones]),
        geometry=system.contacts.geometry,
        closure=system.contacts.closure,
        use=np.ones(4, dtype=bool),
        sections=s.sections,
    )


def own_bodies(
    b: BallSet, backend: Backend, force: float
) -> tuple[tuple[Array, Array], Array, Array, Array, tuple[str, ...]]:
    """Return the compliance of a set's screw and nut, and the terms of its contacts besides Hertz.

    Parameters
    ----------
    b
        The set.
    backend
        Model of the bodies' compliance.
    force
        Of a typical contact [N], at which terms that depend on its size are taken.

    Returns
    -------
    tuple[tuple[Array, Array], Array, Array, Array, tuple[str, ...]]
        Compliance ``(4 N, 4 N)`` of screw and nut [m/N]; e and h ``(N, 4)``; the ball's coupling g ``(4,)``; assumptions.
    """
    problem, scene = b.problem, b.problem.scene
    N, layout = problem.layout.z.size, problem.layout
    axes, size = typical_axes(problem, force), float(np.cbrt(force))
    ball = ball_compliance(scene, axes, backend)
    oblique = oblique_term(error_free_hertz(scene), scene.balls.radius) if backend.ball == "sphere" else np.zeros(4)
    e, h, blocks, assumed = np.zeros((N, 4)), np.zeros((N, 4)), [], []
    for screw in (True, False):
        sides = (0, 1) if screw else (2, 3)
        carried = screw and b.of.carrier is not None
        body = body_compliance(scene, layout, screw, replace(backend, screw="beam") if carried else backend, axes)
        assumed += [x for x in body.assumed if x not in assumed]
        slope = body.slope + ball.slope
        e[:, sides], h[:, sides] = body.e + ball.e - slope, oblique[list(sides)] + slope / size
        order = by_ball(N, 2)
        blocks.append(body.G[np.ix_(order, order)])
    return (blocks[0], blocks[1]), e, h, ball.g * np.array([1.0, ball.sign, ball.sign, 1.0]), tuple(assumed)


def housing_rows(system: System, rollers: RollerElements) -> tuple[Array, Array]:
    """Return the motions ``(4 N, 6 m)`` of flanks and cups on housings per unit motion of m housings."""
    n, m, balls = system.structure.nodes.size, system.structure.at.size, system.contacts.r_ball.size
    outer, inner = np.zeros((2, balls + rollers.count, 2, 2, 6 * m))
    for b in system.balls:
        carrier = -1 if b.of.carrier is None else int(b.problem.node[0, 0])
        for rows, row, flanks in ((outer, b.outer, slice(2, 4)), (inner, carrier, slice(2))):
            if row >= 0:
                rows[b.balls, :, :, 6 * (row - n) : 6 * (row - n) + 6] = b.of_one_row(flanks)
    for i in np.flatnonzero(rollers.outer >= 0):
        j = 6 * (int(rollers.outer[i]) - n)
        outer[balls + i, 0, :, j : j + 6] = rollers.B[i, 1]
    return outer.reshape(4 * len(outer), 6 * m), inner.reshape(4 * len(inner), 6 * m)


def ready(system: System, backend: Backend, engine: ModuleType) -> ElasticSets:
    """Return a system ready for the kernels.

    Some set has balls, and the system was built with `section_of` the backend.

    Raises
    ------
    ValueError
        Inner rings on housings that stand on springs, too many elements, or bodies with impossible dimensions.
    """
    rollers = roller_elements(system.rollers)
    balls = system.contacts.r_ball.size
    N = balls + rollers.count
    if N > LARGEST:
        raise ValueError(f"{N} balls and rollers: elastic bodies are limited to {LARGEST}; use the model lin")
    whole, s = combined(system, rollers), system.structure
    shaft, housings = shaft_of(whole), housings_of(s, system.arm)
    order = by_ball(N, 2)
    (beam, rigid), moved = flank_response(shaft, [0, 1]), flank_motions_by_loads(shaft, [0, 1])
    stretches = [
        stretch_of(whole, b.problem.scene, b.problem.layout, backend, [0, 1], b.balls)
        for b in system.balls
        if b.of.carrier is None
    ]
    squeeze = squeezed(shaft, [0, 1], [x for x in stretches if x is not None], system.assembly.thermal_strain)
    if squeeze is not None:
        beam, moved = beam + squeeze.added, moved + squeeze.moved
    forces = [typical_force(system, b) for b in system.balls]
    parts = [own_bodies(b, backend, x) for b, x in zip(system.balls, forces, strict=True)]
    flat, carried = housing_rows(system, rollers)
    if np.any(carried @ housings.solve(carried.T)):
        raise ValueError(
            "an inner ring on a housing that stands on springs: its motion couples inner and outer flanks, which elastic "
            "bodies keep apart: use the model lin"
        )
    rigid_rings = np.zeros((4 * rollers.count,) * 2)
    compliance = min(contact_compliance(b.problem, x) for b, x in zip(system.balls, forces, strict=True))
    normals = np.concatenate([normals_of(system.contacts.geometry), np.zeros((rollers.count, 4, 2))])
    (first, on_inner, low), (second, on_outer, high) = (
        positive(G + block_diag(*(p[0][k] for p in parts), rigid_rings), n.reshape(-1, 2), compliance)
        for k, (G, n) in enumerate(
            ((beam[np.ix_(order, order)], normals[:, :2]), (flat @ housings.solve(flat.T), normals[:, 2:]))
        )
    )
    v0, k = np.zeros((N, 4, 2)), shaft.work.size
    R = np.zeros((N, 4, 2, k + housings.work.size))
    v0[:, :2], R[:, :2, :, :k] = moved[order].reshape(N, 2, 2), rigid[order].reshape(N, 2, 2, -1)
    v0[:, :2] += (carried @ housings.given).reshape(N, 2, 2)
    R[:, :2, :, k:] = (carried @ housings.motions).reshape(N, 2, 2, -1)
    v0[:, 2:] = (flat @ housings.given).reshape(N, 2, 2)
    v0[:balls, 2:] += system.contacts.v0[:, 2:]
    R[:, 2:, :, k:] = (flat @ housings.motions).reshape(N, 2, 2, -1)
    local = np.zeros((balls, 4, 3))
    for b, p in zip(system.balls, parts, strict=True):
        local[b.balls, :, 0], local[b.balls, :, 2], local[b.balls, :, 1] = p[1], p[2], p[3]
    local[..., 0] -= np.concatenate([on_inner.reshape(N, 2), on_outer.reshape(N, 2)], axis=1)[:balls]
    work = np.concatenate([shaft.work, housings.work])
    bodies = Bodies(first, second, R.reshape(N, 8, -1), v0.reshape(N, 8), work)
    scale = scale_of(system)
    used = system.contacts.geometry[..., 5] > 0.0
    springs = np.concatenate(
        [
            spring_rows(whole, None, scale.stiffness) * used[:, None, :].repeat(2, axis=2),
            roller_springs(rollers.count, scale.stiffness),
        ]
    )
    options = options_of(scale, system.arm, float(system.contacts.r_ball.max()))
    contacts = BallContacts(
        geometry=system.contacts.geometry,
        closure=system.contacts.closure,
        local=local,
        r_ball=system.contacts.r_ball,
        profile=system.contacts.profile,
        pair=np.zeros((balls, 7)),
        rollers=rollers.contacts,
        tiny=scale.none,
    )
    state = BodyState(np.zeros((N, 8)), np.zeros(work.size), np.zeros((N, 3)), np.zeros((N, 4, 5)))
    cut = max(low, high) / compliance
    notes = (f"negative compliance of the bodies, up to {100 * cut:.2g} % of a contact's: cut away",) if cut > 1e-6 else ()
    assumed = tuple(dict.fromkeys(f"{b.of.name}: {x}" for b, p in zip(system.balls, parts, strict=True) for x in p[4]))
    return ElasticSets(
        engine=engine,
        given=BodySystem(bodies, contacts, np.ascontiguousarray(springs)),
        state=state,
        options=options,
        system=system,
        backend=backend,
        whole=whole,
        shaft=shaft,
        housings=housings,
        on_housings=flat,
        carried=carried,
        own=[p[0] for p in parts],
        assumed=(*assumed, *notes),
        squeeze=squeeze,
    )


def ball_roots(elastic: ElasticSets) -> list[Array]:
    """Return square roots S_i ``(rows, 8)`` of the balls' stiffness by the motion of their flanks."""
    N = elastic.state.contact.shape[0]
    S, counts = np.zeros((N, 6, 8)), np.zeros(N, dtype=np.int64)
    elastic.engine.ball_rows(elastic.given.contacts, elastic.state.contact, S, counts)
    return [S[i, : counts[i]] for i in range(N)]


def spread(S: list[Array]) -> Array:
    """Return the square roots of all balls as one matrix ``(rows, 8 N)``."""
    out = np.zeros((sum(len(s) for s in S), 8 * len(S)))
    row = 0
    for i, s in enumerate(S):
        out[row : row + len(s), 8 * i : 8 * i + 8] = s
        row += len(s)
    return out


def both(first: Array, second: Array) -> Array:
    """Return the compliance ``(8 N, 8 N)`` of all flanks, ball by ball, from that of screw and nut ``(4 N, 4 N)``."""
    N = len(first) // 4
    out = np.zeros((N, 2, 4, N, 2, 4))
    out[:, 0, :, :, 0] = first.reshape(N, 4, N, 4)
    out[:, 1, :, :, 1] = second.reshape(N, 4, N, 4)
    return out.reshape(8 * N, 8 * N)


def own_stiffness(elastic: ElasticSets, i: int, b: BallSet, S: list[Array]) -> Array:
    """Return the stiffness ``(6, 6)`` of one set with its elastic bodies, inner part moved rigidly, outer part fixed."""
    root = spread(S[b.balls])
    rows = np.zeros((b.problem.layout.z.size, 8, 6))
    rows[:, :4] = rigid_rows(b, elastic.system.structure.stations)
    moved = root @ rows.reshape(-1, 6)
    return np.asarray(moved.T @ np.linalg.solve(np.eye(len(root)) + root @ both(*elastic.own[i]) @ root.T, moved))


def elastic_stiffness(elastic: ElasticSets, S: list[Array]) -> Array | None:
    """Return the tangent stiffness ``(6, 6)`` of the whole at the reported row, as `whole_stiffness` of the model lin."""
    system, structure = elastic.system, elastic.system.structure
    row = asked_row(system)
    if row < 0:
        return None
    n, k, N = structure.nodes.size, elastic.shaft.work.size, len(S)
    v, work = np.zeros((N, 4, 2, 6)), np.zeros((elastic.state.a.size, 6))
    unit = np.zeros((6 * (n if row < n else structure.at.size), 6))
    at = 6 * (row if row < n else row - n)
    unit[at : at + 6] = np.diag((~structure.fixed[row]).astype(float))
    if row < n:
        answer = elastic.shaft.solve(unit)
        B = elastic.whole.B
        v[:, :2] = np.einsum("nsak,nskj->nsaj", B, answer[6 * elastic.whole.node[..., None] + np.arange(B.shape[3])])
        if elastic.squeeze is not None:
            added, besides = elastic.squeeze.by_loads(unit, answer)
            v[:, :2] += added.reshape(2, N, 2, 6).transpose(1, 0, 2, 3)
            answer = answer + besides
        rigid = np.eye(6)
        z = float(structure.nodes[row] - structure.nodes[elastic.shaft.pin])
        rigid[0, 4], rigid[1, 3] = z, -z
        work[:k] = (rigid @ elastic.shaft.motions).T @ unit[at : at + 6]
    else:
        answer = elastic.housings.solve(unit)
        v[:, 2:] = (elastic.on_housings @ answer).reshape(N, 2, 2, 6)
        work[k:] = elastic.housings.motions.T @ unit
    root, load = spread(S), v.reshape(8 * N, 6)
    SR = root @ elastic.given.bodies.R.reshape(8 * N, -1)
    matrix = np.block(
        [
            [np.eye(len(root)) + root @ both(elastic.given.bodies.first, elastic.given.bodies.second) @ root.T, -SR],
            [SR.T, np.zeros((SR.shape[1],) * 2)],
        ]
    )
    try:
        x = np.linalg.solve(matrix, np.concatenate([root @ load, work]))
    except np.linalg.LinAlgError:
        return None
    compliance = answer[at : at + 6] - load.T @ (root.T @ x[: len(root)]) + work.T @ x[len(root) :]
    return inverse(0.5 * (compliance + compliance.T), ~structure.fixed[row], system.arm)


def solve_refined(
    assembly: Assembly, *, engine: Engine = "auto", member: int = 0, backend: Backend = REFINED, name: str = "refined"
) -> AxisResult:
    """Compute loads, stiffness and motions of an assembly with elastic bodies.

    An assembly with rollers only has nothing elastic but the beam and the line contacts: the model lin.

    Parameters
    ----------
    assembly
        The assembly.
    engine, member
        As for `solve_assembly`.
    backend
        Model of the bodies' compliance.
    name
        Of the model, for the record.

    Raises
    ------
    ValueError
        Inner rings on housings that stand on springs, more than `LARGEST` balls and rollers, or bodies with impossible
        dimensions.
    """
    rigid = rigid_rings(assembly)
    if not assembly.ball_count:
        result = solve_assembly(assembly, engine=engine, member=member)
        return replace(result, model=name, left_out=(*result.left_out, *rigid))

    def made_ready(system: System, kernels: ModuleType) -> ElasticSets:
        return ready(system, backend, kernels)

    again = partial(solve_refined, engine=engine, member=member, backend=backend, name=name)
    model = Model(name, ASSUMPTIONS, rigid, made_ready, section_of(assembly, backend), False)
    return equilibrium(assembly, model, engine, member, again)


def rigid_rings(assembly: Assembly) -> tuple[str, ...]:
    """Return sentences on what rows of rollers and inner rings on housings leave out."""
    rollers = tuple(f"{s.name}: {RIGID_RINGS}" for s in assembly.sets if isinstance(s.parts, RollerRow))
    return rollers + tuple(f"{s.name}: {RIGID_INNER}" for s in assembly.sets if s.carrier is not None)
