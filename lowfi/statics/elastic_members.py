"""Many members of a scene with elastic bodies that differ only in the radii of their balls: one system serves them all.

The bodies' compliance, the shaft and its supports are those of the scene; a member has its own approaches, Hertz constants
and terms that follow the typical force of a contact. Each is solved from the solution of the first one.
"""

from __future__ import annotations

from types import ModuleType

import numpy as np

from rollbench.lowfi.compliance.parts import Backend
from rollbench.lowfi.statics.elastic import Elastic, ElasticBuild
from rollbench.lowfi.statics.elastic_system import pair_data
from rollbench.lowfi.statics.kernel.status import CONVERGED, ITERATIONS
from rollbench.lowfi.statics.problem import distances, hertz_C
from rollbench.lowfi.statics.selection import all_sides, choose_sides
from rollbench.lowfi.statics.settle import ACCEPTED
from rollbench.lowfi.statics.shaft import node_motions, rigid_nodes, rows_of
from rollbench.lowfi.statics.static import Solution, scale_of, solve_sides
from rollbench.meshes.arrays import Array, Mask
from rollbench.meshes.errors import alike_in_shape, specimen, specimens, without_draws
from rollbench.meshes.helix import ball_layout
from rollbench.meshes.parts import Scene


class ElasticMembers:
    """Members of a scene whose random errors are those of the balls' radii (`shared`)."""

    def __init__(self, scene: Scene, backend: Backend, engine: ModuleType, like: ElasticMembers | None = None) -> None:
        """Nothing is built yet. backend: what answers the contact forces; engine: kernels; like: the same members under
        nearly the same loads, solved before, whose solutions these start from."""
        self.scene, self.backend, self.engine, self.like = scene, backend, engine, like
        self.layout = ball_layout(scene)
        self._systems: dict[bytes, _System | None] = {}
        self._states: dict[tuple[int, bytes], list[Array]] = {}  # of the last members by number and sides

    def solve(self, first: int, count: int) -> tuple[Array, Array, Array]:
        """Loads ``(count, N, 4)`` [N], relative residuals and works ``(count,)`` [J], loads times the motions of their
        stations, of members from ``first`` on; nan for those that have to be solved by themselves."""
        drawn = specimens(self.scene, self.layout, first, count)
        offset, closure = distances(self.scene, drawn)
        nominal = specimen(without_draws(self.scene), self.layout)
        C = hertz_C(self.scene, nominal, drawn.ball_radius)
        loads, numbers = np.full((count, self.layout.z.size, 4), np.nan), np.full((2, count), np.nan)
        self._states.clear()
        for k in range(count):
            dims = drawn.ball_radius[k], offset[k], closure[k], C[k]
            use = choose_sides(self.scene, nominal, dims[1:3])
            solved = self._member(first + k, use, dims)
            if solved is None and not np.array_equal(use, all_sides(self.scene)):
                solved = self._member(first + k, all_sides(self.scene), dims)
            if solved is not None:
                loads[k], numbers[:, k] = solved[0], solved[1:]
        return loads, *numbers

    def _member(self, number: int, use: Mask, dims: tuple[Array, Array, Array, Array]) -> tuple[Array, float, float] | None:
        """One member with some sides, as `_System.solve` takes it (``dims``) and gives it."""
        system, key = self._system(use), (number, use.tobytes())
        if system is None:
            return None
        solved = system.solve(*dims, start=None if self.like is None else self.like._states.get(key))
        if solved is not None:
            self._states[key] = [array.copy() for array in system.elastic.state]
        return solved

    def _system(self, use: Mask) -> _System | None:
        """The system with some sides, or with all where they are touched, in the solution of member 0, whatever members are
        asked for; None where it serves no other member."""
        key = use.tobytes()
        if key not in self._systems:
            self._systems[key] = None
            drawn = specimen(self.scene, self.layout)
            solved = solve_sides(ElasticBuild(self.scene, drawn, self.layout, use, self.engine, backend=self.backend))
            if isinstance(solved, Solution) and solved.outcome.status == CONVERGED:
                elastic = solved.system
                if isinstance(elastic, Elastic) and elastic.bodies.lent == 0.0:
                    self._systems[key] = _System(elastic)
        return self._systems[key]


def shared(scene: Scene) -> bool:
    """Whether members of a scene differ only in the radii of their balls, and one pass of the solver finishes each."""
    alike = alike_in_shape(scene) and len(specimens(scene, ball_layout(scene), 0, 2).centre) == 1
    return alike and scene.ingredients.hertz != "actual" and scene.ingredients.screw != "rigid"


class _System:
    """Elastic bodies in the solution of one member, and what the others change in it."""

    def __init__(self, elastic: Elastic) -> None:
        self.elastic = elastic
        self.start = [array.copy() for array in elastic.state]
        self.local = elastic.given.contacts.local.copy()
        self.size = float(np.cbrt(scale_of(elastic.problem).typical))
        self.by_pushes, self.by_motions, self.at_rest = _work(elastic)

    def solve(
        self, radii: Array, offset: Array, closure: Array, C: Array, start: list[Array] | None
    ) -> tuple[Array, float, float] | None:
        """Loads ``(N, 4)`` [N], relative residual and work [J] of a member: radii ``(N,)`` [m], `distances` and Hertz
        constants ``(N, 4)``; None where it does not converge, or a flank that was left out may be touched. start: state
        to start from, in place of the first member's."""
        self._place(radii, offset, closure, C)
        for array, first in zip(self.elastic.state, start or self.start, strict=True):
            array[:] = first
        elastic = self.elastic
        outcome = elastic.iterate(False)
        if outcome.status not in (CONVERGED, ITERATIONS):
            return None
        if outcome.residual > ACCEPTED and outcome.residual > elastic.round_off():
            return None
        whole = np.array_equal(elastic.problem.use, all_sides(elastic.problem.scene))
        if not whole and (outcome.status != CONVERGED or not elastic.clears()):
            return None
        contact = elastic.state.contact
        loads = np.zeros(offset.shape[:2])
        loads[:, slice(None) if elastic.pair is None else elastic.pair] = contact[..., 0]
        on_screw = elastic.forces()[:, [s for s in (0, 1) if elastic.problem.use[s]]].swapaxes(0, 1).ravel()
        work = float(self.by_pushes @ on_screw + self.by_motions @ elastic.state.a) + self.at_rest
        return loads, outcome.residual, work

    def _place(self, radii: Array, offset: Array, closure: Array, C: Array) -> None:
        """Put a member's balls into the arrays of the kernels."""
        elastic, problem = self.elastic, self.elastic.problem
        problem.geometry[..., :4], problem.geometry[..., 4] = offset, C
        problem.closure[:], problem.drawn.ball_radius[:] = closure, radii
        scale, slope = scale_of(problem), elastic.bodies.slope
        size = float(np.cbrt(scale.typical))
        local = elastic.given.contacts.local
        local[:] = self.local
        local[..., 0] += slope * np.log(size / self.size)
        local[..., 2] += slope * (1.0 / size - 1.0 / self.size)
        if elastic.pair is not None:
            elastic.given.contacts.pair[:] = pair_data(problem, elastic.pair, local[..., 0], local[..., 2])
        elastic.given = elastic.given._replace(contacts=elastic.given.contacts._replace(tiny=scale.none))
        elastic.options = elastic.options._replace(floor=scale.floor, furthest=float(radii.max()))


def _work(elastic: Elastic) -> tuple[Array, Array, float]:
    """Loads of the scene times the motions of their stations [J]: by the flanks' forces ``(2 c,)`` [N], side after side, by
    the amplitudes ``(k,)`` of the free motions, and without either."""
    problem, shaft, squeeze = elastic.problem, elastic.shaft, elastic.bodies.squeeze
    load = problem.load.ravel()
    dof, rows = rows_of(problem, [s for s in range(2) if problem.use[s]])
    by_flanks = np.zeros((load.size, 2 * len(rows)))
    for c in range(len(rows)):
        by_flanks[dof[c], 2 * c], by_flanks[dof[c], 2 * c + 1] = rows[c]
    given, inside = np.zeros(load.size), np.zeros(by_flanks.shape[1])
    if squeeze is not None:
        by_flanks += squeeze.wrenches.T @ squeeze.jumps
        given = squeeze.wrenches.T @ squeeze.given
        inside = squeeze.inside.by_loads(np.where(problem.fixed, 0.0, problem.load).reshape(-1, 1))[:, 0]
    moved = node_motions(shaft, given, np.zeros(elastic.state.a.size)).ravel()
    return load @ shaft.solve(by_flanks) + inside, load @ rigid_nodes(shaft), float(load @ moved)
