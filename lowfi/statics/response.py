"""Compliance of a scene's shaft and bodies at the contacts, and the flanks of a problem as the kernels take them.

Responses do not depend on the loads and the radii of the balls. They are cached for the problems that share them: load
cases, samples of a sweep, a scene with and without its loads.
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
from rollbench.lowfi.compliance.bodies import clear_kept_bodies as forget_bodies
from rollbench.lowfi.compliance.parts import Backend, parts_with_balls
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
    """Return the indices of (ball, flank, axis) in arrays ordered flank after flank, ``(N * sides * 2,)``."""
    return np.arange(sides * N * 2).reshape(sides, N, 2).swapaxes(0, 1).ravel()


def of_both(G: Array, used: NDArray[np.bool_], N: int) -> Array:
    """Return compliance ``(4 N, 4 N)`` of both flanks of a body from that of its ``used`` ones ``(2,)``, zero elsewhere."""
    full, on = np.zeros((4 * N, 4 * N)), np.tile(np.repeat(used, 2), N)
    full[np.ix_(on, on)] = G
    return full


def positive(G: Array, normals: Array, tangent: float) -> tuple[Array, Array, float]:
    """Return a compliance without negative eigenvalues, which would make the energy concave.

    Near a fixed face a body adds less than nothing to a contact's motion. Where that is no more than `LENT` of the
    ``tangent``
    compliance of a contact [m/N], it is moved into the contact's law, which loses it, and the sum is exact.

    Parameters
    ----------
    G
        Compliance ``(2 n, 2 n)`` [m/N].
    normals
        Of the contacts ``(n, 2)``.
    tangent
        Tangent compliance of a contact [m/N].

    Returns
    -------
    tuple[Array, Array, float]
        G without negative eigenvalues, what was added along the contacts' normals to that end ``(n,)`` [m/N], and the
        largest negative eigenvalue that was removed nonetheless [m/N].
    """
    mended, lent, cut = Compliance(G, normals).positive(tangent)
    return mended.G, lent, cut


class Compliance:
    """Compliance between contacts, with derived quantities that are computed once; read-only."""

    def __init__(self, G: Array, normals: Array) -> None:
        """Store a compliance G ``(2 n, 2 n)`` [m/N] between contacts of ``normals`` ``(n, 2)``."""
        self.G, self.normals = np.ascontiguousarray(G), normals

    @cached_property
    def is_positive(self) -> bool:
        """Whether it has no negative eigenvalues but for round-off."""
        return _is_positive(self.G)

    @cached_property
    def lacks(self) -> Array:
        """Compliance missing along the normals ``(n,)`` [m/N], by the negative eigenvalues."""
        negative = negative_part(self.G)[0].reshape(len(self.normals), 2, -1, 2)
        missing = np.einsum("ia,iajb,jb->ij", self.normals, negative, self.normals)
        return np.asarray(np.abs(missing).sum(axis=1))

    @cached_property
    def mended(self) -> tuple[Compliance, float]:
        """Result of `lending` all that is missing."""
        return self.lending(self.lacks)

    def lending(self, lent: Array) -> tuple[Compliance, float]:
        """Return the compliance with additions along the normals, and without what stays negative.

        Contacts without a normal, those of rollers, move as the beam does, which nothing may be taken from: of the others
        the negative part is that of the compliance with the forces on contacts without a normal eliminated.

        Parameters
        ----------
        lent
            Additions ``(n,)`` [m/N].

        Returns
        -------
        tuple[Compliance, float]
            The compliance, and the largest negative eigenvalue that was removed [m/N].
        """
        contact, G = np.arange(lent.size), self.G.copy()
        across = self.normals[:, :, None] * self.normals[:, None, :]
        G.reshape(lent.size, 2, lent.size, 2)[contact, :, contact] += lent[:, None, None] * across
        if _is_positive(G):
            return Compliance(G, self.normals), 0.0
        elastic = np.repeat(self.normals.any(axis=1), 2)
        rest, least = negative_part(reduced(G, elastic))
        G[np.ix_(elastic, elastic)] -= rest
        return Compliance(G, self.normals), max(0.0, -least)

    def positive(self, tangent: float) -> tuple[Compliance, Array, float]:
        """Return the compliance without negative eigenvalues, as the function `positive`."""
        if self.is_positive:
            return self, np.zeros(len(self.normals)), 0.0
        lent = np.minimum(self.lacks, LENT * tangent)
        mended, cut = self.mended if np.array_equal(lent, self.lacks) else self.lending(lent)
        return mended, lent, cut


def reduced(G: Array, kept: NDArray[np.bool_]) -> Array:
    """Return the compliance of the ``kept`` freedoms while the others do not move (Schur complement).

    The others' compliance may be singular: rollers on one node move together.
    """
    if kept.all():
        return G
    values, vectors = np.linalg.eigh(G[np.ix_(~kept, ~kept)])
    moving = values > 1e-12 * values[-1]
    coupled = G[np.ix_(kept, ~kept)] @ (vectors[:, moving] / np.sqrt(values[moving]))
    return np.asarray(G[np.ix_(kept, kept)] - coupled @ coupled.T)


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
    """Return unit vectors of contacts ``(..., 2)`` from the geometry of flanks (`lowfi.statics.kernel.ball`)."""
    return np.asarray(geometry[..., :2] / np.maximum(geometry[..., 2:3], 1e-30))


def typical_axes(problem: Problem, force: float) -> tuple[float, float]:
    """Return the semi-axes of a contact under a force [N], across the groove and along it [m]."""
    constants, grow = error_free_hertz(problem.scene), float(np.cbrt(force))
    return float(np.mean(constants.C_a)) * grow, float(np.mean(constants.C_b)) * grow


def one_pair(problem: Problem) -> tuple[int, int] | None:
    """Return the only diagonal pair of flanks in use, the screw's first; None where there are two or flanks are no arcs."""
    if problem.drawn.profile.shape[1] or np.all(problem.use):
        return None
    a = 0 if problem.use[0] else 1
    return a, 3 - a


#: Compliance between no contacts.
NOTHING = Compliance(np.zeros((0, 0)), np.zeros((0, 2)))


@dataclass(frozen=True)
class Response:
    """Compliance of shaft and bodies, whatever the loads, the prescribed displacements and the radii of the balls.

    Besides Hertz's law the approach of a contact has a linear term e and a term h F^(4/3), for N balls and k free motions.
    """

    #: Beam of the screw under some loads.
    shaft: Shaft
    #: Compliance of screw and nut on their built flanks, ball by ball [m/N].
    bodies: tuple[Array, Array]
    #: Compliance of both together for one pair of flanks, or of each on all its flanks.
    solved: tuple[Compliance, ...]
    #: Motion of the screw's flanks by the free motions ``(N, 2, 2, k)``.
    R: Array
    #: Coupling of contact and section forces of the shaft under those loads; None without it.
    squeeze: Squeeze | None
    #: Compliance of the balls at 1 N.
    ball: BallCompliance
    #: Linear compliance of each flank's contacts at a force of 1 N ``(4,)`` [m/N].
    e: Array
    #: ``(4,)`` [m/N^(4/3)], apart from what the slope contributes.
    h: Array
    #: Derivative of e by the logarithm of the contact's size ``(4,)`` [m/N].
    slope: Array
    #: Assumptions about the bodies.
    assumed: tuple[str, ...]


@dataclass(frozen=True)
class _Asked:
    """Request for a response; equal requests have equal ``key``."""

    key: tuple[object, ...]
    problem: Problem = field(compare=False)
    layout: BallLayout = field(compare=False)
    backend: Backend = field(compare=False)


def response_of(
    problem: Problem, layout: BallLayout, backend: Backend, condensed: Condensed | None, whole: WholeBody
) -> Response:
    """Return the response of a problem for a backend, not to be written to.

    Not cached for balls that travel, whose positions do not recur. whole: see `body_compliance`.
    """
    if condensed is not None or whole is not whole_body or layout.z.size > KEPT:
        return _response(problem, layout, backend, condensed, whole)
    layouts = layout.azimuth, layout.z, problem.drawn.centre, problem.nodes
    flanks = problem.use, problem.node, problem.B, problem.fixed, np.any(problem.load, axis=1)
    parts = parts_with_balls(problem.scene)[0], problem.scene.ingredients, problem.section, problem.sections, backend
    key = *parts, one_pair(problem), problem.basis is None, *(np.asarray(x).tobytes() for x in (*layouts, *flanks))
    return kept_response(_Asked(key, problem, layout, backend))


@lru_cache(maxsize=4)
def kept_response(asked: _Asked) -> Response:
    """Return the requested response from a cache of the last four."""
    return _response(asked.problem, asked.layout, asked.backend, None, whole_body)


def _response(
    problem: Problem, layout: BallLayout, backend: Backend, condensed: Condensed | None, whole: WholeBody
) -> Response:
    """Return the response, which is not in the cache."""
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
    """Clear the caches of bodies, so that the next solve is timed with its set-up."""
    forget_bodies()
    kept_response.cache_clear()


#: Largest number of balls: compliance between all contacts is formed whole, so memory and set-up grow as its square.
LARGEST = 1000


@dataclass(frozen=True)
class Flanks:
    """Motions of the flanks of all N balls by forces: four flanks each (d = 8 motions), or a pair's relative motion (2)."""

    #: Compliance as the kernels take it.
    bodies: Bodies
    #: Linear compliance besides Hertz ``(N, 4)`` [m/N].
    e: Array
    #: Factor of F^(4/3) besides Hertz ``(N, 4)`` [m/N^(4/3)].
    h: Array
    #: Largest negative compliance that was removed, over a contact's.
    clipped: float
    #: What the flanks' motions are computed from again: compliance of screw and nut on the built flanks, v0 ``(N, 2, 2)``
    #: and R ``(N, 2, 2, k)`` of the screw's flanks.
    kept: tuple[Array, Array, Array, Array]
    #: Derivative of e by the logarithm of the cube root of the typical force ``(4,)`` [m/N], which h has over that root.
    slope: Array
    #: Largest compliance moved from a contact's law to the bodies [m/N], see `positive`.
    lent: float
    #: Coupling with the shaft's section forces, where it carries load beyond the contacts.
    squeeze: Squeeze | None = None


def contact_compliance(problem: Problem, force: float) -> float:
    """Return the tangent compliance of a contact [m/N] under a force [N]."""
    return float(1.0 / contact_stiffness(force, float(np.mean(problem.C))))


def flanks_of(problem: Problem, force: float, shaft: Shaft, response: Response) -> Flanks:
    """Return the motions of all flanks of a problem, with what the balls add to the contacts' laws.

    Parameters
    ----------
    problem
        The problem.
    force
        Typical force [N], at which small terms are taken that depend on a contact's size.
    shaft
        The beam under the problem's loads.
    response
        Compliance of shaft and bodies.
    """
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
    """Return the rows of `lowfi.statics.kernel.elastic.pair_balls`, ``(N, 7)``."""
    a, b = pair
    geometry = problem.geometry
    D = geometry[:, b, :2] - geometry[:, a, :2]
    size = np.hypot(D[:, 0], D[:, 1])
    constant = geometry[:, a, 4] + geometry[:, b, 4]
    return np.column_stack([D, size, problem.closure[:, a], constant, e[:, a] + e[:, b], h[:, a] + h[:, b]])


def spring_rows(problem: Problem, pair: tuple[int, int] | None, stiffness: float) -> Array:
    """Return linear springs between opposite flanks, ``(N, 1, 2)`` for one pair or ``(N, 2, 8)``, for first iteration."""
    w = normals_of(problem.geometry)
    root = np.sqrt(stiffness)
    if pair is not None:
        return np.ascontiguousarray(root * w[:, pair[0], None, :])
    rows = np.zeros((w.shape[0], 2, 4, 2))
    for s in range(2):
        if problem.use[s] and problem.use[3 - s]:
            rows[:, s, s], rows[:, s, 3 - s] = root * w[:, s], -root * w[:, s]
    return rows.reshape(-1, 2, 8)
