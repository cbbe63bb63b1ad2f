"""A scene with elastic bodies as arrays for the kernels: compliance at the flanks of screw and nut, balls, springs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.compliance.bodies import BallCompliance, WholeBody, ball_compliance, body_compliance, whole_body
from rollbench.lowfi.compliance.modes import negative_part, soft_modes
from rollbench.lowfi.compliance.parts import Backend, geometry_only, grooved_section
from rollbench.lowfi.hertz import contact_stiffness
from rollbench.lowfi.statics.conformity import oblique_term
from rollbench.lowfi.statics.problem import Problem, build, nominal_hertz
from rollbench.lowfi.statics.records import NO_ROLLERS, BallContacts, Bodies, BodyState, Options
from rollbench.lowfi.statics.shaft import Shaft, flank_response, shaft_of
from rollbench.lowfi.statics.squeeze import Squeeze, squeezed, stretch_of
from rollbench.lowfi.statics.static import least_force, options_of, reference_scale
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimen
from rollbench.meshes.helix import BallLayout
from rollbench.meshes.parts import Scene, UnfitKey

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.imported import Condensed

#: Largest number of balls: compliance between all contacts is formed whole, so memory and set-up grow as its square.
LARGEST = 1000
#: Share of a contact's tangent compliance that Hertz's law may lend to the bodies: it falls with the force's cube root, and
#: is left positive up to 64 times the typical force.
LENT = 0.25
#: Number of balls from which on the bodies' soft modes serve the solution, instead of a dense factor.
MODES_FROM = 24


@dataclass(frozen=True)
class Flanks:
    """How the flanks of all balls move, ball by ball: four flanks each (d = 8 motions), or one pair's relative motion (2).

    first, second: compliance [m/N] of screw and nut ``(4 N, 4 N)``, or of both together ``(2 N, 2 N)`` and nothing;
    R ``(N, d, k)`` by the free motions, v0 ``(N, d)`` [m] by loads and prescribed displacements, work ``(k,)`` of the
    loads; e ``(N, 4)`` [m/N] and h ``(N, 4)`` [m/N^(4/3)] beside Hertz; clipped: largest negative compliance cut away over
    a contact's own. own: what the flanks' motions are found from again: compliance of screw and of nut on the built sides,
    v0 ``(N, 2, 2)`` and R ``(N, 2, 2, k)`` of the screw's flanks; squeeze: what is in them of the shaft's section forces,
    where it carries anything above the contacts. slope ``(4,)`` [m/N]: what e gains by the logarithm of the cube root of
    the typical force, which h has over that root; lent [m/N]: the most that a contact lent to the bodies (`positive`).
    """

    first: Array
    second: Array
    R: Array
    v0: Array
    work: Array
    e: Array
    h: Array
    clipped: float
    own: tuple[Array, Array, Array, Array]
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


def typical_force(problem: Problem) -> float:
    """Force [N] at which small terms that depend on the contacts' size are taken: the mean share of load or squeeze."""
    return max(reference_scale(problem)[0], 1e-6)


def contact_compliance(problem: Problem, force: float) -> float:
    """Tangent compliance [m/N] of a contact under a force [N]."""
    return float(1.0 / contact_stiffness(force, float(np.mean(problem.C))))


def by_ball(N: int, sides: int) -> NDArray[np.int64]:
    """Places of (ball, side, axis) in arrays that go side after side, ``(N * sides * 2,)``."""
    return np.arange(sides * N * 2).reshape(sides, N, 2).swapaxes(0, 1).ravel()


def of_both(G: Array, used: NDArray[np.bool_], N: int) -> Array:
    """Compliance ``(4 N, 4 N)`` of both flanks of a body by that of its ``used`` ones (2,), zero elsewhere."""
    full, on = np.zeros((4 * N, 4 * N)), np.tile(np.repeat(used, 2), N)
    full[np.ix_(on, on)] = G
    return full


def positive(G: Array, normals: Array, tangent: float) -> tuple[Array, Array, float]:
    """G ``(2 n, 2 n)`` without negative eigenvalues, which would make the energy concave; what it was lent along the
    contacts' ``normals`` ``(n, 2)`` to that end ``(n,)`` [m/N], and the largest negative one cut away for all that [m/N].

    Beside a held face a body adds less than nothing to a contact's motion. Where that is no more than `LENT` of the
    ``tangent`` compliance of a contact [m/N], its own law has it less what it lent, and nothing is lost.
    """
    lent = np.zeros(len(G) // 2)
    if _is_positive(G):
        return G, lent, 0.0
    lacks = np.einsum("ia,iajb,jb->ij", normals, negative_part(G)[0].reshape(lent.size, 2, -1, 2), normals)
    lent = np.minimum(np.abs(lacks).sum(axis=1), LENT * tangent)
    each, G = np.arange(lent.size), G.copy()
    G.reshape(lent.size, 2, lent.size, 2)[each, :, each] += lent[:, None, None] * normals[:, :, None] * normals[:, None, :]
    if _is_positive(G):
        return G, lent, 0.0
    cut, least = negative_part(G)
    return G - cut, lent, max(0.0, -least)


def _is_positive(G: Array) -> bool:
    if G.size == 0:
        return True
    raised, each = G.copy(), np.arange(len(G))
    raised[each, each] += max(1e-10 * float(np.trace(G)) / len(G), 1e-300)
    try:
        np.linalg.cholesky(raised)
    except np.linalg.LinAlgError:
        return False
    return True


def normals_of(geometry: Array) -> Array:
    """Unit vectors of contacts ``(..., 2)`` from the geometry of flanks (`lowfi.statics.kernel.flanks`)."""
    return np.asarray(geometry[..., :2] / np.maximum(geometry[..., 2:3], 1e-30))


def typical_axes(problem: Problem, force: float) -> tuple[float, float]:
    """Semi-axes [m] of a contact under a force [N], across the groove and along it."""
    constants, grow = nominal_hertz(problem.scene), float(np.cbrt(force))
    return float(np.mean(constants.C_a)) * grow, float(np.mean(constants.C_b)) * grow


def flanks_of(
    problem: Problem,
    shaft: Shaft,
    backend: Backend,
    condensed: Condensed | None,
    layout: BallLayout,
    ball: BallCompliance,
    whole: WholeBody = whole_body,
) -> tuple[Flanks, tuple[str, ...]]:
    """Motions of all flanks of a problem for a backend, with what balls add to the contacts' laws, and what is assumed for
    the bodies; whole: see `body_compliance`."""
    scene, N = problem.scene, layout.z.size
    force = typical_force(problem)
    size = float(np.cbrt(force))
    oblique = oblique_term(nominal_hertz(scene), scene.balls.radius) if backend.ball == "sphere" else np.zeros(4)
    pair = one_pair(problem)
    e, h, slopes, assumed, G = np.zeros((N, 4)), np.zeros((N, 4)), np.zeros(4), [], []
    v0, R = np.zeros((N, 2, 2)), np.zeros((N, 2, 2, shaft.work.size))
    squeeze: Squeeze | None = None
    for screw in (True, False):
        sides = [s for s in ((0, 1) if screw else (2, 3)) if problem.use[s]]
        body = body_compliance(scene, layout, screw, backend, typical_axes(problem, force), [s % 2 for s in sides], whole)
        assumed += [x for x in body.assumed if x not in assumed]
        order = by_ball(N, len(sides))
        slope = body.slope + ball.slope  # by the logarithm of F^(1/3), which its tangent at the typical force stands for
        slopes[sides] = slope
        e[:, sides], h[:, sides] = body.e + ball.e - slope, oblique[sides] + slope / size
        if condensed is not None:
            for s in condensed.sides_of(sides):
                e[:, s], h[:, s] = condensed.bodies.own_law(s)
                e[:, s] += condensed.ball(scene, typical_axes(problem, force)).e
        own = body.G[np.ix_(order, order)]
        if screw:
            beam, moved, rigid = flank_response(shaft, sides)
            stretch = stretch_of(problem, scene, layout, backend, sides, slice(0, N))
            squeeze = squeezed(shaft, sides, [stretch] if stretch is not None else [])
            if squeeze is not None:
                beam, moved = beam + squeeze.added, moved + squeeze.moved
            own = own + beam[np.ix_(order, order)]
            v0[:, [s % 2 for s in sides]] = moved[order].reshape(N, len(sides), 2)
            R[:, [s % 2 for s in sides]] = rigid[order].reshape(N, len(sides), 2, -1)
        if condensed is not None:
            own = condensed.correct(scene, layout, sides, own, backend)
        G.append(own)
    normals, tangent = normals_of(problem.geometry), contact_compliance(problem, force)
    if pair is not None:
        first, lent, clipped = positive(G[0] + G[1], normals[:, pair[0]], tangent)
        e[:, pair[0]] -= lent
        most_lent = float(lent.max(initial=0.0))
        second, d = np.zeros((0, 0)), 2
        s = pair[0] % 2
        start, free = v0[:, s], R[:, s]
    else:
        (first, on_screw, low), (second, on_nut, high) = (
            positive(of_both(G[k], problem.use[side], N), normals[:, side].reshape(-1, 2), tangent)
            for k, side in enumerate((slice(0, 2), slice(2, 4)))
        )
        e -= np.concatenate([on_screw.reshape(N, 2), on_nut.reshape(N, 2)], axis=1)
        clipped, d, most_lent = max(low, high), 8, float(max(on_screw.max(initial=0.0), on_nut.max(initial=0.0)))
        start, free = np.zeros((N, 4, 2)), np.zeros((N, 4, 2, R.shape[3]))
        start[:, :2], free[:, :2] = v0, R
    flanks = Flanks(
        np.ascontiguousarray(first),
        np.ascontiguousarray(second),
        np.ascontiguousarray(free.reshape(N, d, -1)),
        np.ascontiguousarray(start.reshape(N, d)),
        shaft.work,
        e,
        h,
        clipped / tangent,
        (G[0], G[1], v0, R),
        slopes,
        most_lent,
        squeeze,
    )
    return flanks, tuple(assumed)


def one_pair(problem: Problem) -> tuple[int, int] | None:
    """The diagonal pair in use, screw's side first, where it is the only one and the flanks are arcs."""
    if problem.drawn.profile.shape[1] or np.all(problem.use):
        return None
    a = 0 if problem.use[0] else 1
    return a, 3 - a


def pair_data(problem: Problem, pair: tuple[int, int], e: Array, h: Array) -> Array:
    """Rows of `lowfi.statics.kernel.elastic_balls.pair_balls`, ``(N, 7)``."""
    a, b = pair
    geometry = problem.geometry
    D = geometry[:, b, :2] - geometry[:, a, :2]
    size = np.hypot(D[:, 0], D[:, 1])
    both = geometry[:, a, 4] + geometry[:, b, 4]
    return np.column_stack([D, size, problem.closure[:, a], both, e[:, a] + e[:, b], h[:, a] + h[:, b]])


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
    shaft = shaft_of(problem)
    axes = typical_axes(problem, typical_force(problem))
    ball = ball_compliance(problem.scene, axes, backend)
    if condensed is not None and condensed.whole:
        ball = condensed.ball(problem.scene, axes)
    flanks, assumed = flanks_of(problem, shaft, backend, condensed, layout, ball, whole)
    pair = one_pair(problem)
    local = np.zeros((N, 4, 3))
    local[..., 0] = flanks.e
    local[..., 1] = ball.g * np.array([1.0, ball.sign, ball.sign, 1.0])
    local[..., 2] = flanks.h
    rows = np.zeros((N, 7))
    if pair is not None:  # one diagonal alone: nothing to couple with
        local[..., 0] += 2.0 * ball.g**2
        rows = pair_data(problem, pair, local[..., 0], flanks.h)
    modes = [np.zeros((0, 0))] * 2
    if N >= MODES_FROM:
        modes = [soft_modes(G, contact_compliance(problem, typical_force(problem))) for G in (flanks.first, flanks.second)]
    bodies = Bodies(flanks.first, flanks.second, flanks.R, flanks.v0, flanks.work, *modes)
    profile, tiny = np.repeat(problem.drawn.profile[None], N, axis=0), least_force(problem)
    contacts = BallContacts(
        problem.geometry, problem.closure, local, problem.drawn.ball_radius, profile, rows, NO_ROLLERS, tiny
    )
    state = BodyState(
        np.zeros(flanks.v0.shape), np.zeros(flanks.work.size), np.zeros((N, 3)), np.zeros((N, 1 if pair else 4, 5))
    )
    options = options_of(problem)
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
        assumed,
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

    def __call__(self, more: Array | None = None) -> Elastic:
        """The problem, ready; ``more``: see `lowfi.statics.problem.build`."""
        problem = self.problem(more)
        return ready(problem, self.backend, self.engine, self.layout, self.condensed, self.whole)

    def pinned(self, problem: Problem) -> tuple[Rebuild, Elastic]:
        """What builds the problem anew with the freedoms held that ``problem`` holds, and ``problem`` itself, ready."""
        held = replace(self, held=(problem.fixed, problem.prescribed, problem.pins))
        return held, ready(problem, self.backend, self.engine, self.layout, self.condensed, self.whole)

    def problem(self, more: Array | None = None) -> Problem:
        """The problem with the backend's section."""
        found = build(
            self.scene,
            self.drawn,
            self.layout,
            self.use,
            everything=self.everything,
            refine=self.refine,
            more=more,
            section=grooved_section(geometry_only(self.scene), True) if self.backend.section == "cell" else None,
        )
        return (
            found if self.held is None else replace(found, fixed=self.held[0], prescribed=self.held[1], pins=self.held[2])
        )
