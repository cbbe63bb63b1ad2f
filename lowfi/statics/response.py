"""How a scene's shaft and bodies answer at the contacts, and the flanks of a problem as the kernels take them: compliance,
motions by loads, springs to start with.

Responses do not depend on the loads and the radii of the balls. They are kept for the problems that share them: load cases,
samples of a sweep, a scene with and without its loads.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.compliance.bodies import (
    BallCompliance,
    WholeBody,
    ball_compliance,
    body_compliance,
    negative_part,
    whole_body,
)
from rollbench.lowfi.compliance.bodies import forget as forget_bodies
from rollbench.lowfi.compliance.parts import Backend, with_balls
from rollbench.lowfi.hertz import contact_stiffness
from rollbench.lowfi.statics.contacts import error_free_hertz, oblique_term
from rollbench.lowfi.statics.kernel_types import Bodies
from rollbench.lowfi.statics.problem import Problem
from rollbench.lowfi.statics.shaft import (
    Shaft,
    Squeeze,
    flank_motions_by_loads,
    flank_response,
    shaft_of,
    squeezed,
    stretch_of,
)
from rollbench.meshes.arrays import Array
from rollbench.meshes.helix import BallLayout

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.bodies import Condensed


#: Largest number of balls whose responses are kept.
KEPT = 250
#: Share of a contact's tangent compliance that Hertz's law may lend to the bodies: it falls with the force's cube root, and
#: is left positive up to 64 times the typical force.
LENT = 0.25


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
    mended, lent, cut = Compliance(G, normals).positive(tangent)
    return mended.G, lent, cut


class Compliance:
    """A compliance ``G`` ``(2 n, 2 n)`` [m/N] between contacts of ``normals`` ``(n, 2)``, and what is found of it once;
    neither is to be written to."""

    def __init__(self, G: Array, normals: Array) -> None:
        """Nothing is found yet."""
        self.G, self.normals = np.ascontiguousarray(G), normals

    @cached_property
    def is_positive(self) -> bool:
        """Whether it has no negative eigenvalues but for round-off."""
        return _is_positive(self.G)

    @cached_property
    def lacks(self) -> Array:
        """Compliance that it lacks along the normals ``(n,)`` [m/N], by its negative eigenvalues."""
        negative = negative_part(self.G)[0].reshape(len(self.normals), 2, -1, 2)
        missing = np.einsum("ia,iajb,jb->ij", self.normals, negative, self.normals)
        return np.asarray(np.abs(missing).sum(axis=1))

    @cached_property
    def mended(self) -> tuple[Compliance, float]:
        """`lending` all that it lacks."""
        return self.lending(self.lacks)

    def lending(self, lent: Array) -> tuple[Compliance, float]:
        """Itself with what it is lent along the normals ``(n,)`` [m/N], and without what is negative for all that; the
        largest of this [m/N]."""
        contact, G = np.arange(lent.size), self.G.copy()
        across = self.normals[:, :, None] * self.normals[:, None, :]
        G.reshape(lent.size, 2, lent.size, 2)[contact, :, contact] += lent[:, None, None] * across
        if _is_positive(G):
            return Compliance(G, self.normals), 0.0
        cut, least = negative_part(G)
        return Compliance(G - cut, self.normals), max(0.0, -least)

    def positive(self, tangent: float) -> tuple[Compliance, Array, float]:
        """`positive`."""
        if self.is_positive:
            return self, np.zeros(len(self.normals)), 0.0
        lent = np.minimum(self.lacks, LENT * tangent)
        mended, cut = self.mended if np.array_equal(lent, self.lacks) else self.lending(lent)
        return mended, lent, cut


def _is_positive(G: Array) -> bool:
    if G.size == 0:
        return True
    raised, diagonal = G.copy(), np.arange(len(G))
    raised[diagonal, diagonal] += max(1e-10 * float(np.trace(G)) / len(G), 1e-300)
    try:
        np.linalg.cholesky(raised)
    except np.linalg.LinAlgError:
        return False
    return True


def normals_of(geometry: Array) -> Array:
    """Unit vectors of contacts ``(..., 2)`` from the geometry of flanks (`lowfi.statics.kernel.ball`)."""
    return np.asarray(geometry[..., :2] / np.maximum(geometry[..., 2:3], 1e-30))


def typical_axes(problem: Problem, force: float) -> tuple[float, float]:
    """Semi-axes [m] of a contact under a force [N], across the groove and along it."""
    constants, grow = error_free_hertz(problem.scene), float(np.cbrt(force))
    return float(np.mean(constants.C_a)) * grow, float(np.mean(constants.C_b)) * grow


def one_pair(problem: Problem) -> tuple[int, int] | None:
    """The diagonal pair in use, screw's side first, where it is the only one and the flanks are arcs."""
    if problem.drawn.profile.shape[1] or np.all(problem.use):
        return None
    a = 0 if problem.use[0] else 1
    return a, 3 - a


#: Compliance between no contacts.
NOTHING = Compliance(np.zeros((0, 0)), np.zeros((0, 2)))


@dataclass(frozen=True)
class Response:
    """How shaft and bodies answer, whatever the loads, the prescribed displacements and the radii of the balls.

    shaft: under some loads; bodies: compliance [m/N] of screw and nut on their built sides, ball by ball; solved: of both
    together for one pair, or of each on all its sides; R ``(N, 2, 2, k)``: motion of the screw's flanks by the free ones;
    squeeze: under those loads. Beside Hertz a contact of each side has e [m/N] at a force of 1 N, slope ``(4,)`` of it by
    the logarithm of the contact's size, and h ``(4,)`` [m/N^(4/3)] apart from what the slope makes; ball: at 1 N.
    """

    shaft: Shaft
    bodies: tuple[Array, Array]
    solved: tuple[Compliance, ...]
    R: Array
    squeeze: Squeeze | None
    ball: BallCompliance
    e: Array
    h: Array
    slope: Array
    assumed: tuple[str, ...]


@dataclass(frozen=True)
class _Asked:
    """A response that is asked for, by all that it depends on (``key``)."""

    key: tuple[object, ...]
    problem: Problem = field(compare=False)
    layout: BallLayout = field(compare=False)
    backend: Backend = field(compare=False)


def response_of(
    problem: Problem, layout: BallLayout, backend: Backend, condensed: Condensed | None, whole: WholeBody
) -> Response:
    """The response of a problem for a backend, not to be written to; whole: see `body_compliance`. Of balls that travel
    none is kept: their places do not come again."""
    if condensed is not None or whole is not whole_body or layout.z.size > KEPT:
        return _response(problem, layout, backend, condensed, whole)
    layouts = layout.azimuth, layout.z, problem.drawn.centre, problem.nodes
    flanks = problem.use, problem.node, problem.B, problem.fixed, np.any(problem.load, axis=1)
    parts = with_balls(problem.scene)[0], problem.scene.ingredients, problem.section, problem.sections, backend
    key = *parts, one_pair(problem), problem.basis is None, *(np.asarray(x).tobytes() for x in (*layouts, *flanks))
    return kept_response(_Asked(key, problem, layout, backend))


@lru_cache(maxsize=4)
def kept_response(asked: _Asked) -> Response:
    """The response that is asked for; at most four are kept."""
    return _response(asked.problem, asked.layout, asked.backend, None, whole_body)


def _response(
    problem: Problem, layout: BallLayout, backend: Backend, condensed: Condensed | None, whole: WholeBody
) -> Response:
    scene, shaft, N = problem.scene, shaft_of(problem), layout.z.size
    axes = typical_axes(problem, 1.0)
    ball = ball_compliance(scene, axes, backend)
    of_file = ball if condensed is None else condensed.ball(scene, axes)
    if condensed is not None and condensed.whole:
        ball = of_file
    e, h, slope = np.zeros(4), np.zeros(4), np.zeros(4)
    if backend.ball == "sphere":
        h[:] = oblique_term(error_free_hertz(scene), scene.balls.radius)
    assumed, G, squeeze, R = [], [], None, np.zeros((N, 2, 2, shaft.work.size))
    for screw in (True, False):
        sides = [s for s in ((0, 1) if screw else (2, 3)) if problem.use[s]]
        body = body_compliance(scene, layout, screw, backend, axes, [s % 2 for s in sides], whole)
        assumed += [x for x in body.assumed if x not in assumed]
        e[sides], slope[sides] = body.e + ball.e, body.slope + ball.slope
        order = by_ball(N, len(sides))
        compliance = body.G[np.ix_(order, order)]
        if screw:
            beam, rigid = flank_response(shaft, sides)
            stretch = stretch_of(problem, scene, layout, backend, sides, slice(0, N))
            squeeze = squeezed(shaft, sides, [stretch] if stretch is not None else [])
            if squeeze is not None:
                beam = beam + squeeze.added
            compliance = compliance + beam[np.ix_(order, order)]
            R[:, [s % 2 for s in sides]] = rigid[order].reshape(N, len(sides), 2, -1)
        if condensed is not None:
            for s in condensed.sides_of(sides):
                (e[s], h[s]), slope[s] = condensed.bodies.local_law(s), 0.0
                e[s] += of_file.e
            compliance = condensed.correct(scene, layout, sides, compliance, backend)
        G.append(compliance)
    normals, pair = normals_of(problem.geometry), one_pair(problem)
    if pair is not None:
        solved = [Compliance(G[0] + G[1], normals[:, pair[0]])]
    else:
        solved = [
            Compliance(of_both(G[k], problem.use[side], N), normals[:, side].reshape(-1, 2))
            for k, side in enumerate((slice(0, 2), slice(2, 4)))
        ]
    return Response(shaft, (G[0], G[1]), tuple(solved), R, squeeze, ball, e, h, slope, tuple(assumed))


def forget() -> None:
    """Clear all that is kept of bodies, so that the next solve is timed with its set-up."""
    forget_bodies()
    kept_response.cache_clear()


#: Largest number of balls: compliance between all contacts is formed whole, so memory and set-up grow as its square.
LARGEST = 1000


@dataclass(frozen=True)
class Flanks:
    """How the flanks of all balls move, ball by ball: four flanks each (d = 8 motions), or one pair's relative motion (2).

    e ``(N, 4)`` [m/N] and h ``(N, 4)`` [m/N^(4/3)] besides Hertz; clipped: largest negative compliance cut away
    over a contact's own. kept: what the flanks' motions are found from again: compliance of screw and of nut on the
    built sides, v0 ``(N, 2, 2)`` and R ``(N, 2, 2, k)`` of the screw's flanks;
    squeeze: what is in them of the shaft's section forces, where it carries anything above the contacts. slope ``(4,)``
    [m/N]: what e gains by the logarithm of the cube root of the typical force, which h has over that root; lent [m/N]: the
    most that a contact lent to the bodies (`positive`).
    """

    bodies: Bodies
    e: Array
    h: Array
    clipped: float
    kept: tuple[Array, Array, Array, Array]
    slope: Array
    lent: float
    squeeze: Squeeze | None = None


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
    R, moved = np.ascontiguousarray(free.reshape(N, start[0].size, -1)), np.ascontiguousarray(start.reshape(N, -1))
    bodies = Bodies(first.G, second.G, R, moved, shaft.work)
    kept = *response.bodies, v0, response.R
    return Flanks(bodies, e, h, clipped / tangent, kept, response.slope, most_lent, squeeze)


def pair_data(problem: Problem, pair: tuple[int, int], e: Array, h: Array) -> Array:
    """Rows of `lowfi.statics.kernel.elastic.pair_balls`, ``(N, 7)``."""
    a, b = pair
    geometry = problem.geometry
    D = geometry[:, b, :2] - geometry[:, a, :2]
    size = np.hypot(D[:, 0], D[:, 1])
    constant = geometry[:, a, 4] + geometry[:, b, 4]
    return np.column_stack([D, size, problem.closure[:, a], constant, e[:, a] + e[:, b], h[:, a] + h[:, b]])


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
