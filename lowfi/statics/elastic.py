"""Static load distribution with elastic bodies: the refined model, and every step between it and the source's.

The same contact mechanics as `lowfi.statics.static`, but the flanks of screw and nut answer forces by a compliance matrix
with a pluggable origin (`lowfi.compliance.bodies`, or a condensed 3D model read from a file).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from rollbench.lowfi.compliance.bodies import WholeBody, whole_body
from rollbench.lowfi.compliance.parts import REFINED, Backend, geometry_only, grooved_section, idealised
from rollbench.lowfi.hertz import contact_stiffness
from rollbench.lowfi.statics.elastic_system import LARGEST, Flanks, flanks_of, pair_data, spring_rows
from rollbench.lowfi.statics.kernel_types import NO_ROLLERS, RIGID, BallContacts, BodyState, BodySystem, Outcome
from rollbench.lowfi.statics.problem import Problem, SolvedState
from rollbench.lowfi.statics.response import one_pair, response_of
from rollbench.lowfi.statics.result import StaticResult
from rollbench.lowfi.statics.selection import all_clear, all_sides, choose_sides
from rollbench.lowfi.statics.settle import SetFlanks, least_residual
from rollbench.lowfi.statics.shaft import Shaft, flank_loads, node_forces, node_motions
from rollbench.lowfi.statics.static import Build, Engine, OneSet, Words, options_of, pick_engine, scale_of, solve_built
from rollbench.lowfi.statics.summary import ELASTIC_ASSUMPTIONS
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import specimen
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene, UnfitKey
from rollbench.meshes.section import BeamSection

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.bodies import Condensed

#: Formulation of a solution with elastic bodies.
CONDENSED = "convex energy, elastic bodies condensed to the contacts"
#: A flank that was left out counts as touching when it comes this near [m].
MARGIN = 0.2e-6


@dataclass(kw_only=True)
class Elastic(OneSet):
    """Elastic bodies of a scene; assumed: statements about the bodies."""

    SOLVER = "solve_forces"
    given: BodySystem
    state: BodyState
    shaft: Shaft
    bodies: Flanks
    assumed: tuple[str, ...]

    @property
    def pair(self) -> tuple[int, int] | None:
        """Sides of the one diagonal that the closed form serves, screw's first; None where all four flanks take part."""
        if self.given.bodies.second.size:
            return None
        a = 0 if self.problem.use[0] else 1
        return a, 3 - a

    def iterate(self, start: bool = True) -> Outcome:
        """As `Prepared.iterate`, with the problem's Hertz constants."""
        if self.pair is not None:
            self.given.contacts.pair[:, 4] = self.problem.C[:, list(self.pair)].sum(axis=1)
        return super().iterate(start)

    def flanks(self) -> Sequence[SetFlanks]:
        """Contacts at the state."""
        problem, state, moved, pair = self.problem, self.state, self.shifts(), self.pair
        if pair is None:
            return (SetFlanks(problem, state.contact, state.inner[:, :2].copy(), moved),)
        a, b = pair
        N = len(moved)
        contact, p, single = np.zeros((N, 4, 5)), np.zeros((N, 2)), np.zeros((4, 5))
        contact[:, a] = contact[:, b] = state.contact[:, 0]
        contact[:, b, 1:3] *= -1.0
        geometry, closure, drawn, tiny = problem.geometry, problem.closure, problem.drawn, self.given.contacts.tiny
        for i in range(N):  # the centre follows from the motions of both flanks
            ball = geometry[i], closure[i], RIGID, drawn.ball_radius[i], drawn.profile
            self.engine.settle_ball(p[i], moved[i].copy(), *ball, tiny, single)
        return (SetFlanks(problem, contact, p, moved),)

    def forces(self) -> Array:
        """Forces ``(N, 4, 2)`` [N] of the balls on all flanks."""
        pair, contact = self.pair, self.state.contact
        pushes = contact[..., 0, None] * contact[..., 1:3]
        if pair is None:
            return np.asarray(pushes)
        out = np.zeros((contact.shape[0], 4, 2))
        out[:, pair[0]], out[:, pair[1]] = pushes[:, 0], -pushes[:, 0]
        return out

    def shifts(self) -> Array:
        """Motions ``(N, 4, 2)`` [m] of all built flanks at the state."""
        screw, nut, v0, R = self.bodies.kept
        forces = self.forces()
        N, out = len(forces), np.zeros(forces.shape)
        for G, sides in ((screw, (0, 1)), (nut, (2, 3))):
            used = [s for s in sides if self.problem.use[s]]
            out[:, used] = (G @ forces[:, used].ravel()).reshape(N, len(used), 2)
        out[:, :2] += v0 + R @ self.state.a
        return out

    def round_off(self) -> float:
        """By the largest motions and the stiffest contact."""
        problem, v0 = self.problem, self.given.bodies.v0
        stiff = float(contact_stiffness(self.state.contact[..., 0], problem.C.min()).max(initial=0.0))
        motion = float(np.abs(self.shifts()).max()) + float(np.abs(v0).max(initial=0.0))
        return least_residual(motion, stiff, self.scale, [problem])

    def clears(self) -> bool:
        """Whether no ball comes within MARGIN of an omitted flank, as `lowfi.statics.selection.all_clear` has it.

        A flank that was left out moves with its neighbour on the same ridge, up to their own elastic difference.
        """
        problem, contact, p, shift = self.flanks()[0]
        for s in np.flatnonzero(~problem.use):
            shift[:, s] = shift[:, int(s) ^ 1]
        force = contact[None, ..., 0]
        return bool(all_clear(p[None], shift[None], problem.geometry[None], force, problem.use, MARGIN)[0])

    def solved(self) -> SolvedState:
        """The state with the motions of the nodes and the reactions, which the condensed system does not hold itself."""
        problem, squeeze = self.problem, self.bodies.squeeze
        used = [s for s in range(2) if problem.use[s]]
        pushes = self.forces()[:, used].transpose(1, 0, 2).reshape(-1, 2)
        by_flanks = flank_loads(problem, pushes, used)
        if squeeze is not None:
            by_flanks += squeeze.node_loads(pushes.ravel())
        motion, nodal = node_motions(self.shaft, by_flanks, self.state.a), np.zeros((problem.nodes.size, 6))
        if problem.basis is None:
            nodal = node_forces(self.shaft, by_flanks) - problem.load - by_flanks.reshape(-1, 6)
        if squeeze is not None:
            motion = squeeze.with_inside(motion, pushes, problem.fixed)
        held = np.where(problem.fixed, nodal, 0.0)
        scale = max(self.scale, float(np.abs(held[:, :3]).max(initial=0.0)))
        _, contact, centre, shifts = self.flanks()[0]
        return SolvedState(problem, motion, centre, contact[..., 0], contact[..., 1:3], held, shifts, scale)

    def words(self) -> Words:
        """As `OneSet.words`: with what was done to keep the compliance positive."""
        build, clipped = self.build, self.bodies.clipped
        assert isinstance(build, ElasticBuild)
        source = idealised(build.backend, build.scene) if build.condensed is None else (build.condensed.describe(),)
        size = self.state.phi.size + self.state.a.size
        cut = (f"negative compliance of the bodies, up to {100 * clipped:.2g} % of a contact's: cut away",)
        assumed = (*ELASTIC_ASSUMPTIONS, *source, *self.assumed)
        return Words(CONDENSED, size, assumed, cut if clipped > 1e-6 else ())


@dataclass(frozen=True, kw_only=True)
class ElasticBuild(Build):
    """As `Build`, with elastic bodies: backend: what answers the contact forces; condensed: compliance from a 3D model
    instead; whole: see `body_compliance`."""

    backend: Backend = REFINED
    condensed: Condensed | None = None
    whole: WholeBody = whole_body

    @property
    def section(self) -> BeamSection | None:
        """That of the backend."""
        return grooved_section(geometry_only(self.scene), True) if self.backend.section == "cell" else None

    def ready(self, problem: Problem) -> Elastic:
        """A problem, ready for the kernels. Raises ValueError for more than ``LARGEST`` balls or impossible dimensions of
        the bodies."""
        N = self.layout.z.size
        if N > LARGEST:
            reason = f"balls.count of {N} balls: elastic bodies are limited to {LARGEST}; use the model lin"
            raise UnfitKey("balls.count", reason)
        response = response_of(problem, self.layout, self.backend, self.condensed, self.whole)
        shaft, ball, scale = response.shaft.under(problem), response.ball, scale_of(problem)
        flanks, pair, drawn = flanks_of(problem, scale.typical, shaft, response), one_pair(problem), problem.drawn
        local, rows = np.zeros((N, 4, 3)), np.zeros((N, 7))
        local[..., 0], local[..., 2] = flanks.e, flanks.h
        local[..., 1] = ball.g * np.array([1.0, ball.sign, ball.sign, 1.0])
        if pair is not None:  # one diagonal alone: nothing to couple with
            local[..., 0] += 2.0 * ball.g**2
            rows = pair_data(problem, pair, local[..., 0], flanks.h)
        balls = problem.geometry, problem.closure, local, drawn.ball_radius, np.repeat(drawn.profile[None], N, axis=0)
        v0, k, options = flanks.bodies.v0, flanks.bodies.work.size, options_of(problem, scale)
        springs = spring_rows(problem, pair, options.stiffness)
        return Elastic(
            engine=self.engine,
            given=BodySystem(flanks.bodies, BallContacts(*balls, rows, NO_ROLLERS, scale.none), shaft.arms, springs),
            state=BodyState(np.zeros(v0.shape), np.zeros(k), np.zeros((N, 3)), np.zeros((N, 1 if pair else 4, 5))),
            options=options,
            problem=problem,
            build=self,
            shaft=shaft,
            bodies=flanks,
            assumed=response.assumed,
        )

    def touched(self) -> str:
        """As `Build.touched`."""
        return "two of the four sides may touch in the solution without them: solved again with all four"


def solve_elastic(
    scene: Scene,
    *,
    backend: Backend = REFINED,
    condensed: Condensed | None = None,
    name: str = "refined",
    engine: Engine = "auto",
    everything: bool = False,
    member: int = 0,
    refine: int = 1,
) -> StaticResult:
    """Contact loads, contact angles and shaft motion of a scene in static equilibrium with elastic bodies.

    backend: what answers the contact forces; condensed: compliance from a 3D model instead; name: of the model, for the
    record; engine, everything, member, refine: as for `lowfi.statics.static.solve_static`. Raises ValueError for bodies
    that the dimensions make impossible; a scene without equilibrium is named in ``status``.
    """
    start = perf_counter()
    layout = ball_layout(scene)
    drawn = specimen(scene, layout, member)
    uneven = drawn.profile.shape[1] > 0
    kernels = pick_engine(engine, layout.z.size, uneven)
    use = all_sides(scene) if everything or uneven else choose_sides(scene, drawn)
    parts = scene, drawn, layout, use, kernels, everything, refine
    return solve_built(ElasticBuild(*parts, backend=backend, condensed=condensed), name, start)
