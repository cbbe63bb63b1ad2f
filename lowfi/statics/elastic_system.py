"""A scene with elastic bodies as arrays for the kernels: compliance at the flanks of screw and nut, balls, springs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.compliance.bodies import WholeBody, whole_body
from rollbench.lowfi.compliance.parts import Backend, geometry_only, grooved_section
from rollbench.lowfi.hertz import contact_stiffness
from rollbench.lowfi.statics.problem import Problem, build
from rollbench.lowfi.statics.records import NO_ROLLERS, BallContacts, Bodies, BodyState, Options
from rollbench.lowfi.statics.response import NOTHING, Response, by_ball, normals_of, one_pair, response_of
from rollbench.lowfi.statics.shaft import Shaft, flank_motions_by_loads
from rollbench.lowfi.statics.squeeze import Squeeze
from rollbench.lowfi.statics.static import options_of, scale_of
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimen
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import Scene, UnfitKey

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.imported import Condensed

#: Largest number of balls: compliance between all contacts is formed whole, so memory and set-up grow as its square.
LARGEST = 1000


@dataclass(frozen=True)
class Flanks:
    """How the flanks of all balls move, ball by ball: four flanks each (d = 8 motions), or one pair's relative motion (2).

    first, second: compliance [m/N] of screw and nut ``(4 N, 4 N)``, or of both together ``(2 N, 2 N)`` and nothing;
    R ``(N, d, k)`` by the free motions, v0 ``(N, d)`` [m] by loads and prescribed displacements, work ``(k,)`` of
    loads; e ``(N, 4)`` [m/N] and h ``(N, 4)`` [m/N^(4/3)] beside Hertz; clipped: largest negative compliance cut away
    over a contact's own. kept: what the flanks' motions are found from again: compliance of screw and of nut on the
    built sides, v0 ``(N, 2, 2)`` and R ``(N, 2, 2, k)`` of the screw's flanks;
    squeeze: what is in them of the shaft's section forces, where it carries anything above the contacts. slope ``(4,)``
    [m/N]: what e gains by the logarithm of the cube root of the typical force, which h has over that root; lent [m/N]: the
    most that a contact lent to the bodies (`positive`).
    """

    first: Array
    second: Array
    R: Array
    v0: Array
    work: Array
    e: Array
    h: Array
    clipped: float
    kept: tuple[Array, Array, Array, Array]
    slope: Array
    lent: float
    squeeze: Squeeze | None = None


@dataclass
class Elastic:
    """A problem ready for the kernels, in the order of `lowfi.statics.kernel.elastic.solve_forces`.

    bodies, contacts, state, options, arms, history: its arguments; springs: those of `start_forces`; assumed: statements
    about the bodies; scale: largest force of the last run [N].
    """

    problem: Problem
    shaft: Shaft
    flanks: Flanks
    engine: ModuleType
    bodies: Bodies
    contacts: BallContacts
    state: BodyState
    springs: Array
    options: Options
    arms: Array
    history: Array
    assumed: tuple[str, ...]
    scale: float = 0.0

    @property
    def pair(self) -> tuple[int, int] | None:
        """Sides of the one diagonal that the closed form serves, screw's first; None where all four flanks take part."""
        if self.bodies.second.size:
            return None
        a = 0 if self.problem.use[0] else 1
        return a, 3 - a


def contact_compliance(problem: Problem, force: float) -> float:
    """Tangent compliance [m/N] of a contact under a force [N]."""
    return float(1.0 / contact_stiffness(force, float(np.mean(problem.C))))


def flanks_of(problem: Problem, force: float, shaft: Shaft, response: Response) -> Flanks:
    """Motions of all flanks of a problem, with what balls add to the contacts' laws; force [N]: at which small terms are
    taken that depend on a contact's size; shaft: under the problem's loads."""
    N, squeeze = len(problem.C), response.squeeze
    size, tangent = float(np.cbrt(force)), contact_compliance(problem, force)
    sides = [s for s in (0, 1) if problem.use[s]]
    moved, v0 = flank_motions_by_loads(shaft, sides), np.zeros((N, 2, 2))
    if squeeze is not None:
        squeeze = squeeze.under(shaft)
        moved = moved + squeeze.moved
    v0[:, sides] = moved[by_ball(N, len(sides))].reshape(N, len(sides), 2)
    e, h = np.zeros((N, 4)), np.zeros((N, 4))
    used = problem.use  # e by its tangent at the typical force, as the logarithm of F^(1/3) is taken
    e[:, used] = (response.e + response.slope * (np.log(size) - 1.0))[used]
    h[:, used] = (response.h + response.slope / size)[used]
    pair = one_pair(problem)
    if pair is not None:
        first, lent, clipped = response.solved[0].positive(tangent)
        e[:, pair[0]] -= lent
        second, most_lent, s = NOTHING, float(lent.max(initial=0.0)), pair[0] % 2
        start, free = v0[:, s], response.R[:, s]
    else:
        (first, on_screw, low), (second, on_nut, high) = (body.positive(tangent) for body in response.solved)
        e -= np.concatenate([on_screw.reshape(N, 2), on_nut.reshape(N, 2)], axis=1)
        clipped, most_lent = max(low, high), float(max(on_screw.max(initial=0.0), on_nut.max(initial=0.0)))
        start, free = np.zeros((N, 4, 2)), np.zeros((N, 4, 2, shaft.work.size))
        start[:, :2], free[:, :2] = v0, response.R
    return Flanks(
        first.G,
        second.G,
        np.ascontiguousarray(free.reshape(N, start[0].size, -1)),
        np.ascontiguousarray(start.reshape(N, -1)),
        shaft.work,
        e,
        h,
        clipped / tangent,
        (*response.bodies, v0, response.R),
        response.slope,
        most_lent,
        squeeze,
    )


def pair_data(problem: Problem, pair: tuple[int, int], e: Array, h: Array) -> Array:
    """Rows of `lowfi.statics.kernel.elastic_balls.pair_balls`, ``(N, 7)``."""
    a, b = pair
    geometry = problem.geometry
    D = geometry[:, b, :2] - geometry[:, a, :2]
    size = np.hypot(D[:, 0], D[:, 1])
    constant = geometry[:, a, 4] + geometry[:, b, 4]
    return np.column_stack([D, size, problem.closure[:, a], constant, e[:, a] + e[:, b], h[:, a] + h[:, b]])


def ready(
    problem: Problem,
    backend: Backend,
    kernels: ModuleType,
    layout: BallLayout,
    condensed: Condensed | None = None,
    whole: WholeBody = whole_body,
) -> Elastic:
    """Arrays for the kernels. Raises ValueError for more than ``LARGEST`` balls or impossible dimensions of the bodies."""
    N = layout.z.size
    if N > LARGEST:
        reason = f"balls.count of {N} balls: elastic bodies are limited to {LARGEST}; use the model lin"
        raise UnfitKey("balls.count", reason)
    response = response_of(problem, layout, backend, condensed, whole)
    shaft, ball, scale = response.shaft.under(problem), response.ball, scale_of(problem)
    flanks, pair = flanks_of(problem, scale.typical, shaft, response), one_pair(problem)
    local = np.zeros((N, 4, 3))
    local[..., 0] = flanks.e
    local[..., 1] = ball.g * np.array([1.0, ball.sign, ball.sign, 1.0])
    local[..., 2] = flanks.h
    rows = np.zeros((N, 7))
    if pair is not None:  # one diagonal alone: nothing to couple with
        local[..., 0] += 2.0 * ball.g**2
        rows = pair_data(problem, pair, local[..., 0], flanks.h)
    bodies = Bodies(flanks.first, flanks.second, flanks.R, flanks.v0, flanks.work)
    profile = np.repeat(problem.drawn.profile[None], N, axis=0)
    contacts = BallContacts(
        problem.geometry, problem.closure, local, problem.drawn.ball_radius, profile, rows, NO_ROLLERS, scale.none
    )
    state = BodyState(
        np.zeros(flanks.v0.shape), np.zeros(flanks.work.size), np.zeros((N, 3)), np.zeros((N, 1 if pair else 4, 5))
    )
    options = options_of(problem, scale)
    return Elastic(
        problem,
        shaft,
        flanks,
        kernels,
        bodies,
        contacts,
        state,
        spring_rows(problem, pair, options.stiffness),
        options,
        shaft.arms,
        np.zeros(options.most + 1),
        response.assumed,
    )


def spring_rows(problem: Problem, pair: tuple[int, int] | None, stiffness: float) -> Array:
    """Linear springs between opposite flanks, ``(N, 1, 2)`` for one pair or ``(N, 2, 8)``."""
    w = normals_of(problem.geometry)
    root = np.sqrt(stiffness)
    if pair is not None:
        return np.ascontiguousarray(root * w[:, pair[0], None, :])
    rows = np.zeros((w.shape[0], 2, 4, 2))
    for s in range(2):
        if problem.use[s] and problem.use[3 - s]:
            rows[:, s, s], rows[:, s, 3 - s] = root * w[:, s], -root * w[:, s]
    return rows.reshape(-1, 2, 8)


@dataclass(frozen=True)
class Rebuild:
    """Builds a problem anew with other lever arms; held: freedoms of the nodes and their values,
    ``(n, 6)`` each, and which of the first node are pins; whole: see `body_compliance`."""

    scene: Scene
    drawn: Specimen
    layout: BallLayout
    use: NDArray[np.bool_]
    held: tuple[NDArray[np.bool_], Array, tuple[int, ...]] | None
    backend: Backend
    condensed: Condensed | None
    engine: ModuleType
    everything: bool
    refine: int = 1
    whole: WholeBody = whole_body

    def __call__(self, arms: Array | None = None) -> Elastic:
        """The problem, ready; ``arms``: see `lowfi.statics.problem.build`."""
        problem = self.problem(arms)
        return ready(problem, self.backend, self.engine, self.layout, self.condensed, self.whole)

    def pinned(self, problem: Problem) -> tuple[Rebuild, Elastic]:
        """This, with the freedoms held that ``problem`` holds, and ``problem`` itself, ready."""
        held = replace(self, held=(problem.fixed, problem.prescribed, problem.pins))
        return held, ready(problem, self.backend, self.engine, self.layout, self.condensed, self.whole)

    def problem(self, arms: Array | None = None) -> Problem:
        """The problem with the backend's section."""
        found = build(
            self.scene,
            self.drawn,
            self.layout,
            self.use,
            everything=self.everything,
            refine=self.refine,
            arms=arms,
            section=grooved_section(geometry_only(self.scene), True) if self.backend.section == "cell" else None,
        )
        return (
            found if self.held is None else replace(found, fixed=self.held[0], prescribed=self.held[1], pins=self.held[2])
        )
