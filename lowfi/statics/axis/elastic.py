"""Several rolling sets with elastic bodies: the compliance of shaft, housings and of each set's own bodies at all flanks.

The shaft is a beam with its supports; beyond it the screw, nut and balls of a set answer contact forces as in the refined
model of one set (`lowfi.compliance`), as long as the force is of that set: from set to set only beam and housings reach,
and the beam's section forces, which squeeze the contacts (`lowfi.statics.squeeze`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, cho_factor, cho_solve, qr

from rollbench.lowfi.compliance.bodies import ball_compliance, body_compliance
from rollbench.lowfi.compliance.parts import Backend, geometry_only, grooved_section
from rollbench.lowfi.statics.axis.rollers import RollerElements, roller_elements, roller_springs
from rollbench.lowfi.statics.axis.structure import Structure, threaded
from rollbench.lowfi.statics.axis.system import BallSet, System, widened
from rollbench.lowfi.statics.axis.typical import typical, typical_force
from rollbench.lowfi.statics.conformity import oblique_term
from rollbench.lowfi.statics.elastic_system import LARGEST, contact_compliance, spring_rows
from rollbench.lowfi.statics.problem import Problem, nominal_hertz
from rollbench.lowfi.statics.records import BallContacts, Bodies, BodyState, Options
from rollbench.lowfi.statics.response import by_ball, normals_of, positive, typical_axes
from rollbench.lowfi.statics.shaft import Shaft, flank_motions_by_loads, flank_response, shaft_of
from rollbench.lowfi.statics.squeeze import Squeeze, squeezed, stretch_of
from rollbench.lowfi.statics.static import MAX_ITERATIONS, TOLERANCE
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import Assembly
from rollbench.meshes.section import BeamSection


@dataclass(frozen=True)
class Housings:
    """Housings as a linear body: stiffness of what is free, factored; motions (6 m, k) that nothing holds, which some
    freedoms pin; given (6 m,): motion by loads and prescribed displacements; work (k,) of the loads on the motions."""

    free: NDArray[np.int64]
    factor: tuple[Array, bool] | None
    stiffness: Array
    motions: Array
    given: Array
    work: Array

    def solve(self, loads: Array) -> Array:
        """Motions (6 m, c) by loads (6 m, c), with the loose motions pinned."""
        out = np.zeros_like(loads)
        if self.factor is not None:
            out[self.free] = cho_solve(self.factor, loads[self.free])
        return out


@dataclass
class ElasticAxis:
    """An assembly ready for `lowfi.statics.kernel.elastic.solve_forces`.

    rows (4 N, 6 m): motion of the nut's flanks by the housings, carried (4 N, 6 m): of inner flanks on them; local:
    compliance of each set's own screw and nut, ball by ball (4 N_s, 4 N_s); assumed: statements on the bodies.
    """

    system: System
    whole: Problem
    shaft: Shaft
    housings: Housings
    rows: Array
    carried: Array
    local: list[tuple[Array, Array]]
    bodies: Bodies
    contacts: BallContacts
    state: BodyState
    springs: Array
    options: Options
    arms: Array
    engine: ModuleType
    assumed: tuple[str, ...]
    squeeze: Squeeze | None


def housings_of(structure: Structure, arm: float) -> Housings:
    """Springs between housings and to the frame, with what holds them."""
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
            _, _, order = qr(loose.T, pivoting=True)
            free = np.delete(free, order[: loose.shape[1]])
    given = np.where(held, prescribed, 0.0)
    factor = cho_factor(K[np.ix_(free, free)], lower=True) if free.size else None
    found = Housings(free, factor, K, motions, given, motions.T @ load)
    return replace(found, given=given + found.solve((load - K @ given)[:, None])[:, 0])


def on_shaft(b: BallSet) -> Problem:
    """The set's problem, whose inner flanks are on the shaft, or nowhere where a housing carries them."""
    p = b.problem
    return p if b.of.carrier is None else replace(p, node=np.zeros_like(p.node), B=np.zeros_like(p.B))


def section_of(assembly: Assembly, backend: Backend) -> BeamSection | None:
    """Section of the threaded shaft; None: the scene's."""
    thread = threaded(assembly) if backend.section == "cell" else None
    return None if thread is None else grooved_section(geometry_only(thread), True)


def combined(system: System, rollers: RollerElements) -> Problem:
    """All balls of all sets, then all rollers, as one problem on one shaft, for the beam alone."""
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
    """Compliance of a set's own screw and nut (4 N, 4 N) [m/N]; e, h (N, 4) beside Hertz; the ball's coupling g (4,).

    force [N]: of a typical contact, at which terms that depend on its size are taken.
    """
    problem, scene = b.problem, b.problem.scene
    N, layout = problem.layout.z.size, problem.layout
    axes, size = typical_axes(problem, force), float(np.cbrt(force))
    ball = ball_compliance(scene, axes, backend)
    oblique = oblique_term(nominal_hertz(scene), scene.balls.radius) if backend.ball == "sphere" else np.zeros(4)
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


def outer_rows(system: System, rollers: RollerElements) -> Array:
    """Motion (4 N, 6 m) of the outer flanks of all balls, then of the cups of all rollers, by that of m housings."""
    n, m, balls = system.structure.nodes.size, system.structure.at.size, system.contacts.r_ball.size
    rows = np.zeros((balls + rollers.count, 2, 2, 6 * m))
    for b in system.balls:
        if b.outer >= 0:
            j = 6 * (b.outer - n)
            rows[b.balls, :, :, j : j + 6] = b.of_one_row(slice(2, 4))
    for i in np.flatnonzero(rollers.outer >= 0):
        j = 6 * (int(rollers.outer[i]) - n)
        rows[balls + i, 0, :, j : j + 6] = rollers.B[i, 1]
    return rows.reshape(4 * (balls + rollers.count), 6 * m)


def inner_rows(system: System, rollers: RollerElements) -> Array:
    """Motion (4 N, 6 m) of the inner flanks that m housings carry, by these."""
    n, m, balls = system.structure.nodes.size, system.structure.at.size, system.contacts.r_ball.size
    rows = np.zeros((balls + rollers.count, 2, 2, 6 * m))
    for b in system.balls:
        if b.of.carrier is not None:
            j = 6 * (int(b.problem.node[0, 0]) - n)
            rows[b.balls, :, :, j : j + 6] = b.of_one_row(slice(2))
    return rows.reshape(4 * (balls + rollers.count), 6 * m)


def ready(system: System, backend: Backend, engine: ModuleType) -> ElasticAxis:
    """Arrays for the kernels.

    Some set has balls, and the system has the `section_of` the backend. Raises ValueError for inner rings on housings that
    stand on springs, too many elements, or bodies that the dimensions make impossible.
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
    flat, carried = outer_rows(system, rollers), inner_rows(system, rollers)
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
    force, stiffness, floor = typical(system)
    used = system.contacts.geometry[..., 5] > 0.0
    springs = np.concatenate(
        [spring_rows(whole, None, stiffness) * used[:, None, :].repeat(2, axis=2), roller_springs(rollers.count, stiffness)]
    )
    furthest = float(system.contacts.r_ball.max())
    options = Options(TOLERANCE, MAX_ITERATIONS, stiffness, system.arm, 1e3, floor, furthest)
    contacts = BallContacts(
        system.contacts.geometry,
        system.contacts.closure,
        local,
        system.contacts.r_ball,
        system.contacts.profile,
        np.zeros((balls, 7)),
        rollers.contacts,
        1e-14 * force,
    )
    state = BodyState(np.zeros((N, 8)), np.zeros(work.size), np.zeros((N, 3)), np.zeros((N, 4, 5)))
    cut = max(low, high) / compliance
    notes = (f"negative compliance of the bodies, up to {100 * cut:.2g} % of a contact's: cut away",) if cut > 1e-6 else ()
    assumed = tuple(dict.fromkeys(f"{b.of.name}: {x}" for b, p in zip(system.balls, parts, strict=True) for x in p[4]))
    arms = np.concatenate([shaft.arms, np.ones(housings.work.size)])
    return ElasticAxis(
        system,
        whole,
        shaft,
        housings,
        flat,
        carried,
        [p[0] for p in parts],
        bodies,
        contacts,
        state,
        np.ascontiguousarray(springs),
        options,
        arms,
        engine,
        (*assumed, *notes),
        squeeze,
    )
