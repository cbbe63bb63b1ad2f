"""Compliance of screw and nut at the contacts, with the shaft as a beam, as arrays.

The compliance depends neither on the loads nor on the radii of the balls. It is cached, because load cases, sweeps over
loads and specimens with other ball radii share it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rollbench.lowfi.compliance.bodies import (
    BallCompliance,
    WholeBody,
    ball_compliance,
    body_compliance,
    compliance_between_contacts,
    negative_eigenvalue_part,
)
from rollbench.lowfi.compliance.parts import ComplianceModel, compliance_geometry_with_balls
from rollbench.lowfi.hertz import contact_stiffness_under_force
from rollbench.lowfi.statics import shaft as statics_shaft
from rollbench.lowfi.statics.contacts import hertz_without_errors, oblique_pressure_coefficient
from rollbench.lowfi.statics.equilibrium import Compliances, DenseBodies, FreeMotions
from rollbench.lowfi.statics.problem import Problem
from rollbench.meshes.arrays import Array
from rollbench.meshes.cache import kept_by_content

if TYPE_CHECKING:
    from rollbench.lowfi.compliance.bodies import CondensedCompliance


#: Largest number of balls up to which compliance is cached.
KEPT = 250
#: Largest share of a contact's tangent compliance (derivative of the approach by the force) that is moved from Hertz's law
#: to the bodies, whose compliance matrix thus becomes positive. The tangent compliance falls with the cube root of the
#: force; with this share the rest stays positive up to 64 times the typical force.
LENT = 0.25


def permutation_to_ball_by_ball_order(N: int, flank_count: int) -> NDArray[np.int64]:
    """Return the permutation of flank motions from the order flank, ball, component to the order ball, flank, component.

    The array ``(2 N flank_count,)`` holds, for each position in the new order, the index in the old one. ``N``: number of
    balls; ``flank_count``: number of flanks per ball; component: one of two in the ball's section plane.
    """
    return np.arange(flank_count * N * 2).reshape(flank_count, N, 2).swapaxes(0, 1).ravel()


def compliance_of_both_flanks(G: Array, used: NDArray[np.bool_], N: int) -> Array:
    """Return the compliance ``(4 N, 4 N)`` of both flanks of screw or nut, with zeros for a flank without contacts.

    Parameters
    ----------
    G
        Compliance matrix of the flanks that have contacts [m/N], ordered by ball, flank and component in the ball's section
        plane.
    used
        Which of the two flanks have contacts ``(2,)``.
    N
        Number of balls.
    """
    full, on = np.zeros((4 * N, 4 * N)), np.tile(np.repeat(used, 2), N)
    full[np.ix_(on, on)] = G
    return full


class ContactCompliance:
    """Compliance matrix of a body between n contacts (read-only), with methods that remove its negative eigenvalues."""

    def __init__(self, G: Array, normals: Array) -> None:
        """Store the compliance matrix ``G`` ``(2 n, 2 n)`` [m/N] and the unit ``normals`` of the contacts ``(n, 2)``."""
        self.G, self.normals = np.ascontiguousarray(G), normals

    @cached_property
    def is_positive(self) -> bool:
        """Return whether the matrix has no negative eigenvalues apart from round-off."""
        return _is_positive(self.G)

    @cached_property
    def missing_compliance(self) -> Array:
        """Return the compliance ``(n,)`` [m/N] to add along the contacts' normals for a positive semidefinite matrix.

        The values are upper bounds: the matrix's negative part (that of its negative eigenvalues) is projected on the
        normals, and the magnitudes in each row of this projection are summed up.
        """
        negative = negative_eigenvalue_part(self.G)[0].reshape(len(self.normals), 2, -1, 2)
        missing = np.einsum("ia,iajb,jb->ij", self.normals, negative, self.normals)
        return np.asarray(np.abs(missing).sum(axis=1))

    @cached_property
    def with_missing_compliance(self) -> tuple[ContactCompliance, float]:
        """Return the compliance with `missing_compliance` added along the contacts' normals, without negative eigenvalues.

        The second entry is the magnitude [m/N] of the largest negative eigenvalue that remained and was set to zero; zero
        if there was none.
        """
        return self.with_added_compliance(self.missing_compliance)

    def with_added_compliance(self, lent: Array) -> tuple[ContactCompliance, float]:
        """Return a copy with compliance added along the contacts' normals; remaining negative eigenvalues are set to zero.

        The normals of rollers are zero vectors: rollers move with the beam alone, whose compliance must not change. The
        negative eigenvalues are therefore those of the other contacts while the rollers do not move
        (`condensed_compliance`).

        Parameters
        ----------
        lent
            Compliance to add at each contact ``(n,)`` [m/N].

        Returns
        -------
        tuple[ContactCompliance, float]
            The positive compliance, and the magnitude of the largest negative eigenvalue that was set to zero [m/N].
        """
        contact, G = np.arange(lent.size), self.G.copy()
        across = self.normals[:, :, None] * self.normals[:, None, :]
        G.reshape(lent.size, 2, lent.size, 2)[contact, :, contact] += lent[:, None, None] * across
        if _is_positive(G):
            return ContactCompliance(G, self.normals), 0.0
        elastic = np.repeat(self.normals.any(axis=1), 2)
        rest, least = negative_eigenvalue_part(condensed_compliance(G, elastic))
        G[np.ix_(elastic, elastic)] -= rest
        return ContactCompliance(G, self.normals), max(0.0, -least)

    def without_negative_eigenvalues(self, tangent: float) -> tuple[ContactCompliance, Array, float]:
        """Return the compliance of a body without negative eigenvalues, which would make the energy non-convex.

        The matrix holds the body's compliance less the local compliance that Hertz's law contains; near a fixed face this
        difference is negative. The compliance that is missing is taken from the contacts: it is added to the matrix along
        the contact's normal, and the caller subtracts it from the contact's law, so that the sum stays the same. At most
        the fraction `LENT` of the derivative of a contact's approach by its load is moved in this way; eigenvalues that
        stay negative are set to zero.

        Parameters
        ----------
        tangent
            Derivative of a contact's approach by its load [m/N].

        Returns
        -------
        tuple[ContactCompliance, Array, float]
            The compliance; the values that were added to it along the normals ``(n,)`` [m/N]; and the magnitude of the
            largest negative eigenvalue that was set to zero [m/N].
        """
        if self.is_positive:
            return self, np.zeros(len(self.normals)), 0.0
        lent = np.minimum(self.missing_compliance, LENT * tangent)
        whole = np.array_equal(lent, self.missing_compliance)
        mended, cut = self.with_missing_compliance if whole else self.with_added_compliance(lent)
        return mended, lent, cut


@kept_by_content(4, lambda G, normals: (G, normals))
def contact_compliance(G: Array, normals: Array) -> ContactCompliance:
    """Return the compliance ``G`` between contacts with these ``normals``; equal ones share what follows from them."""
    return ContactCompliance(G, normals)


def condensed_compliance(G: Array, kept: NDArray[np.bool_]) -> Array:
    """Return the compliance matrix of some degrees of freedom while all others are fixed (Schur complement).

    ``G`` ``(m, m)``: compliance matrix of all degrees of freedom [m/N]; ``kept`` ``(m,)``: True for each degree of freedom
    of the result. The compliance of the others may be singular, since rollers on one node move together.
    """
    if kept.all():
        return G
    values, vectors = np.linalg.eigh(G[np.ix_(~kept, ~kept)])
    moving = values > 1e-12 * values[-1]
    coupled = G[np.ix_(kept, ~kept)] @ (vectors[:, moving] / np.sqrt(values[moving]))
    return np.asarray(G[np.ix_(kept, kept)] - coupled @ coupled.T)


def _is_positive(G: Array) -> bool:
    """Return whether the symmetric matrix ``G`` is positive semidefinite.

    It is, if a Cholesky factor exists after a small addition to the diagonal (1e-10 of its mean).
    """
    if G.size == 0:
        return True
    raised, diagonal = G.copy(), np.arange(len(G))
    raised[diagonal, diagonal] += max(1e-10 * float(np.trace(G)) / len(G), 1e-300)
    try:
        np.linalg.cholesky(raised)
    except np.linalg.LinAlgError:
        return False
    return True


def typical_ellipse_semi_axes(problem: Problem, force: float) -> tuple[float, float]:
    """Return the semi-axes [m] of the mean ellipse of all contacts under a force [N]: across, then along the groove."""
    constants, grow = hertz_without_errors(problem.scene), float(np.cbrt(force))
    return float(np.mean(constants.C_a)) * grow, float(np.mean(constants.C_b)) * grow


def only_flank_pair(problem: Problem) -> tuple[int, int] | None:
    """Return the numbers of the two flanks if only one pair of diagonally opposite flanks has contacts.

    The numbers are 0 screw left, 1 screw right, 2 nut left, 3 nut right; the result is (0, 3) or (1, 2). None if all four
    flanks have contacts or the flanks are not circular arcs.
    """
    if problem.drawn.profile_coefficients.shape[1] or np.all(problem.used_flanks):
        return None
    a = 0 if problem.used_flanks[0] else 1
    return a, 3 - a


@dataclass(frozen=True)
class ScrewAndNutCompliance:
    """Compliance of screw (with its beam), nut and balls at the contacts of N balls; independent of loads and ball radii.

    The approach of a contact under the force F is C F^(2/3) (Hertz) + e F + h F^(4/3).
    """

    #: Beam of the screw with k free rigid motions, under the loads of the first problem that used this compliance.
    shaft_beam: statics_shaft.ShaftBeam
    #: Compliance matrices of screw and nut between their flanks in use, ordered ball by ball [m/N].
    screw_and_nut: tuple[Array, Array]
    #: Compliance matrices in the form that the solver uses: if only one diagonal pair of flanks has contacts, the sum of
    #: screw and nut (one element); else screw and nut separately, each with both of its flanks (two elements).
    solver_compliances: tuple[ContactCompliance, ...]
    #: Motions of the screw's flanks per metre of the free rigid motions ``(N, 2, 2, k)``.
    R: Array
    #: Coupling of contact deformation and section forces of the shaft, under the loads of the first problem that used this
    #: compliance; None: not modelled.
    coupling: statics_shaft.SectionForceCoupling | None
    #: Compliance of the balls at a force of 1 N.
    ball_compliance: BallCompliance
    #: Coefficient e of the term e F in the approach of a contact at each flank ``(4,)`` [m/N], for the contact ellipse
    #: under a force of 1 N.
    e: Array
    #: Coefficient h of the term h F^(4/3) in the approach of a contact at each flank ``(4,)`` [m/N^(4/3)]. The change of e
    #: with the size of the contact ellipse (``slope_of_e``) is not included; it is added for a given force.
    h: Array
    #: Derivative of the coefficient e by the logarithm of the size of the contact ellipse, at each flank ``(4,)`` [m/N].
    slope_of_e: Array
    #: Assumptions about the bodies, as sentences for the report.
    assumed: tuple[str, ...]


def compliance_of_screw_and_nut(
    problem: Problem, backend: ComplianceModel, condensed: CondensedCompliance | None, whole: WholeBody
) -> ScrewAndNutCompliance:
    """Return the compliance of screw (with its beam), nut and balls at the contacts of a problem, from a cache if possible.

    The result may be shared and must not be changed. It is not cached if it comes from a 3D model or from another function
    ``whole`` than the default, or if there are more than `KEPT` balls.

    Parameters
    ----------
    problem
        Static problem.
    backend
        Method by which the compliance of screw, nut and balls is computed.
    condensed
        Compliance condensed from a 3D model, in place of a computed one; None: computed.
    whole
        Function that computes the compliance of one complete screw or nut between its contacts.
    """
    if condensed is not None or whole is not compliance_between_contacts or problem.layout.z.size > KEPT:
        return _compute_compliance(problem, backend, condensed, whole)
    return cached_compliance(problem, backend)


def _determines_compliance(problem: Problem, backend: ComplianceModel) -> tuple[object, ...]:
    """Return the dimensions and options on which the compliance of a problem's bodies by the model ``backend`` depends."""
    layouts = problem.layout.azimuth, problem.layout.z, problem.drawn.groove_centres, problem.nodes
    flanks = problem.used_flanks, problem.first_nodes, problem.B, problem.fixed, np.any(problem.load, axis=1)
    scene, sections = problem.scene, (problem.section, problem.element_sections)
    parts = compliance_geometry_with_balls(scene)[0], scene.ingredients, sections, backend
    return (*parts, only_flank_pair(problem), problem.rigid_motion_basis is None, *layouts, *flanks)


@kept_by_content(4, _determines_compliance)
def cached_compliance(problem: Problem, backend: ComplianceModel) -> ScrewAndNutCompliance:
    """Return the compliance of the bodies of a problem, which is kept in memory; ``backend``: model of the bodies."""
    return _compute_compliance(problem, backend, None, compliance_between_contacts)


def _compute_compliance(
    problem: Problem, backend: ComplianceModel, condensed: CondensedCompliance | None, whole: WholeBody
) -> ScrewAndNutCompliance:
    """Compute the compliance of screw (with its beam), nut and balls at the contacts of a problem, without a cache.

    ``backend``: method; ``condensed``: compliance from a 3D model in place of a computed one;
    ``whole``: function that computes the compliance of one complete screw or nut.
    """
    scene, layout, shaft = problem.scene, problem.layout, statics_shaft.build_shaft(problem)
    N = layout.z.size
    axes = typical_ellipse_semi_axes(problem, 1.0)
    ball = ball_compliance(scene, axes, backend)
    of_file = ball if condensed is None else condensed.ball_compliance_of_file(scene, axes)
    if condensed is not None and condensed.covers_screw_and_nut:
        ball = of_file
    e, h, slope = np.zeros(4), np.zeros(4), np.zeros(4)
    if backend.ball == "sphere":
        h[:] = oblique_pressure_coefficient(hertz_without_errors(scene), scene.balls.radius)
    assumed, G, coupling, R = [], [], None, np.zeros((N, 2, 2, shaft.work_on_free_motions.size))
    for screw in (True, False):
        sides = [s for s in ((0, 1) if screw else (2, 3)) if problem.used_flanks[s]]
        body = body_compliance(scene, layout, screw, backend, axes, [s % 2 for s in sides], whole)
        assumed += [x for x in body.assumed_dimensions if x not in assumed]
        e[sides] = body.contact_compliance + ball.contact_compliance
        slope[sides] = body.contact_compliance_slope + ball.contact_compliance_slope
        order = permutation_to_ball_by_ball_order(N, len(sides))
        compliance = body.G[np.ix_(order, order)]
        if screw:
            beam = statics_shaft.flank_compliance(shaft, sides)
            stretch = statics_shaft.build_shaft_stretch(problem, scene, layout, backend, sides, slice(0, N))
            coupling = statics_shaft.couple_section_forces(shaft, sides, [stretch])
            if coupling is not None:
                beam = beam + coupling.added_compliance
            compliance = compliance + beam[np.ix_(order, order)]
            rigid = statics_shaft.flank_motions_by_free_motions(shaft, sides)[order]
            R[:, [s % 2 for s in sides]] = rigid.reshape(N, len(sides), 2, -1)
        if condensed is not None:
            for s in condensed.flanks_covered_by_file(sides):
                (e[s], h[s]), slope[s] = condensed.file_contents.fit_local_approach_over_load(s), 0.0
                e[s] += of_file.contact_compliance
            compliance = condensed.replace_normal_compliance(scene, layout, sides, compliance, backend)
        G.append(compliance)
    normals, pair = problem.balls.normals[0], only_flank_pair(problem)
    if pair is not None:
        solved = [ContactCompliance(G[0] + G[1], normals[:, pair[0]])]
    else:
        used = problem.used_flanks
        whole_bodies = (compliance_of_both_flanks(G[0], used[:2], N), compliance_of_both_flanks(G[1], used[2:], N))
        on_body = (normals[:, :2].reshape(-1, 2), normals[:, 2:].reshape(-1, 2))
        solved = [ContactCompliance(*x) for x in zip(whole_bodies, on_body, strict=True)]
    return ScrewAndNutCompliance(shaft, (G[0], G[1]), tuple(solved), R, coupling, ball, e, h, slope, tuple(assumed))


#: Largest number of balls with elastic bodies. As the compliance matrix between all contacts is dense, memory grows as the
#: square of this number.
LARGEST = 1000


@dataclass(frozen=True)
class FlankCompliance:
    """Compliance of all flanks under N balls, and terms of the contact law besides Hertz's, for given loads.

    The solver takes either the 8 motions of the four flanks of each ball, or the 2 components of the relative motion of one
    pair of diagonally opposite flanks.
    """

    #: Compliance of the bodies for the solver.
    bodies: DenseBodies
    #: Coefficient e of the term e F that is added to Hertz's approach of each contact ``(N, 4)`` [m/N].
    e: Array
    #: Coefficient h of the term h F^(4/3) that is added to Hertz's approach of each contact ``(N, 4)`` [m/N^(4/3)].
    h: Array
    #: Largest magnitude of a negative eigenvalue of a body's compliance matrix that was set to zero, as a fraction of the
    #: compliance of a contact.
    clipped_share: float
    #: Four arrays from which the result computes the flanks' motions: compliance matrices of screw and of nut between
    #: flanks with contacts, and motions of the screw's flanks by loads ``(N, 2, 2)`` and per metre of its free rigid
    #: motions ``(N, 2, 2, k)``.
    flank_motion_terms: tuple[Array, Array, Array, Array]
    #: Derivative of the coefficient e by the logarithm of s at each flank ``(4,)`` [m/N]; s is the cube root of the typical
    #: contact force, to which the size of the contact ellipse is proportional. The field h contains the term ``slope_of_e``
    #: / s.
    slope_of_e: Array
    #: Largest compliance [m/N] that was subtracted from the law of a contact and added to the bodies, so that their
    #: compliance matrices have no negative eigenvalues, see `ContactCompliance`.
    compliance_moved_to_bodies: float
    #: The same compliance matrices as ``bodies`` holds, as they were computed: negative eigenvalues included.
    as_computed: tuple[ContactCompliance, ...]
    #: Coupling of contact deformation and section forces of the shaft; None: not modelled.
    coupling: statics_shaft.SectionForceCoupling | None = None

    @property
    def changes_of_bodies(self) -> tuple[Array, ...]:
        """Return what was added to each matrix of `as_computed`, so that it has no negative eigenvalues [m/N]."""
        held = (self.bodies.compliances.first, self.bodies.compliances.second)
        mended = [x[0] for x in held if x is not None]
        return tuple(x - raw.G for x, raw in zip(mended, self.as_computed, strict=True))


def tangent_compliance_of_contact(problem: Problem, force: float) -> float:
    """Return the tangent compliance of a contact [m/N] under a force [N]: the derivative of its approach by the force.

    It follows from Hertz's law with the mean Hertz constant of all contacts of the ``problem``.
    """
    return float(1.0 / contact_stiffness_under_force(force, float(np.mean(problem.C))))


def flank_compliance_under_loads(
    problem: Problem, force: float, shaft: statics_shaft.ShaftBeam, response: ScrewAndNutCompliance
) -> FlankCompliance:
    """Return the compliance of all flanks, and the terms that are added to Hertz's contact law, for given loads.

    Parameters
    ----------
    problem
        Static problem.
    force
        Typical contact force [N], at which small terms that depend on the size of the contact ellipse are evaluated.
    shaft
        Beam of the screw under the loads of the problem.
    response
        Compliance of shaft, screw and nut.
    """
    N, coupling = len(problem.C), response.coupling
    size, tangent = float(np.cbrt(force)), tangent_compliance_of_contact(problem, force)
    sides = [s for s in (0, 1) if problem.used_flanks[s]]
    moved, v0 = statics_shaft.flank_motions_by_loads(shaft, sides), np.zeros((N, 2, 2))
    if coupling is not None:
        coupling = coupling.under_loads_of(shaft)
        moved = moved + coupling.flank_motions_by_loads
    v0[:, sides] = moved[permutation_to_ball_by_ball_order(N, len(sides))].reshape(N, len(sides), 2)
    e, h = np.zeros((N, 4)), np.zeros((N, 4))
    used = problem.used_flanks  # log F^(1/3) in e is replaced by its tangent at the typical force
    e[:, used] = (response.e + response.slope_of_e * (np.log(size) - 1.0))[used]
    h[:, used] = (response.h + response.slope_of_e / size)[used]
    pair = only_flank_pair(problem)
    if pair is not None:
        first, lent, clipped = response.solver_compliances[0].without_negative_eigenvalues(tangent)
        e[:, pair[0]] -= lent
        second, most_lent, s = None, float(lent.max(initial=0.0)), pair[0] % 2
        start, free = v0[:, s], response.R[:, s]
    else:
        mended = (body.without_negative_eigenvalues(tangent) for body in response.solver_compliances)
        (first, on_screw, low), (second, on_nut, high) = mended
        e -= np.concatenate([on_screw.reshape(N, 2), on_nut.reshape(N, 2)], axis=1)
        clipped, most_lent = max(low, high), float(max(on_screw.max(initial=0.0), on_nut.max(initial=0.0)))
        start, free = np.zeros((N, 4, 2)), np.zeros((N, 4, 2, shaft.work_on_free_motions.size))
        start[:, :2], free[:, :2] = v0, response.R
    flanks = (1, N, start.size // (2 * N), 2)
    motions = FreeMotions(start.reshape(flanks), free.reshape(*flanks, free.shape[-1]), shaft.work_on_free_motions[None])
    bodies = DenseBodies(motions, Compliances(first.G[None], None if second is None else second.G[None]))
    kept = *response.screw_and_nut, v0, response.R
    terms = clipped / tangent, kept, response.slope_of_e, most_lent
    return FlankCompliance(bodies, e, h, *terms, response.solver_compliances, coupling)
