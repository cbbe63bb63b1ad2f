"""Contact of many balls coupled through elastic bodies: Newton with line search on the convex dual energy.

With C = blkdiag(D_i) + U G U^T (one block per ball), gaps g = g0 + C lambda - N y, equilibrium N^T lambda = f:

    Phi(w, y) = 1/2 w^T G w - f^T y + sum_i psi_i(g0_i + U_i G w - N_i y)
    psi_i(g) = -min_{lambda >= 0} (1/2 lambda^T D_i lambda + g^T lambda)

is convex; at its minimum w = U^T lambda and the rigid motions y are in equilibrium. Each psi_i is the energy of one ball
between fixed grooves, a small contact problem solved exactly by an active set. So the contacts of every step are converged,
and the line search can use the energy. A plain active set on all balls at once may cycle, because the equilibrium of free
balls gives equality constraints.

Contact pairs i carry forces lambda_i >= 0 [N], pressing the bodies apart, and have gaps g_i >= 0 [m]:

    g = g0 + C lambda - N y,   lambda >= 0,   g >= 0,   lambda_i g_i = 0,   N^T lambda = f          (1)

g0: gaps of the undeformed bodies at rest; C: compliance, symmetric positive definite; y: rigid motions of the free
bodies (translations [m], rotations [rad]), column j of N being the gap closed by a unit of motion j; f: loads on them
[N, N m], positive where they do work in a closing motion. These are the optimality conditions of the convex problem
min 1/2 lambda^T C lambda + g0^T lambda over lambda >= 0 with N^T lambda = f, so a solution's forces are unique.

C has three parts: local to each contact, coupling the contacts of a ball, and coupling all contacts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.linalg import block_diag, lu_factor, lu_solve
from scipy.linalg.blas import dtrsm
from scipy.linalg.lapack import dpotrf, dpotrs, dpstrf
from scipy.optimize import nnls

from rollbench.meshes.arrays import Array

Indices = NDArray[np.int64]

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class BallContactCompliance:
    """Compliance D = blkdiag(A_s) + V G V^T between the contact pairs of one ball, flank after flank.

    A_s: local compliance of flank s, between its n_s contact pairs; V: few smooth modes by which the ball couples its
    flanks; G: compliance between these modes. Factorising D in this form costs sum n_s^3 instead of (sum n_s)^3 operations.
    """

    #: Compliance A_s between the n_s contact pairs of each flank ``(n_s, n_s)`` [m/N], symmetric positive definite.
    local_compliance: tuple[Array, ...]
    #: Smooth displacement modes V_s ``(n_s, k_s)`` by which the contact on a flank is coupled to the ball's other flanks.
    coupling_modes: tuple[Array, ...]
    #: Compliance G between the modes of all flanks ``(k, k)`` [m/N], k = sum k_s, symmetric positive semidefinite.
    mode_compliance: Array

    @cached_property
    def pair_slices_by_flank(self) -> tuple[slice, ...]:
        """For each groove flank, the slice of its contact pairs among all contact pairs of the ball."""
        return consecutive_slices([len(a) for a in self.local_compliance])

    @cached_property
    def _modes_of_all_flanks(self) -> Array:
        """Modes V that couple the ball's flanks, of all flanks in one block-diagonal matrix ``(n, k)``."""
        return np.asarray(block_diag(*self.coupling_modes))

    def __len__(self) -> int:
        """Return the number of contact pairs of the ball."""
        return sum(len(a) for a in self.local_compliance)

    def compute_opened_gaps(self, forces: Array) -> Array:
        """Compute the increase D f ``(n,)`` [m] of the ball's n gaps by its own contact forces f ``(n,)`` [N]."""
        each, V = zip(self.local_compliance, self.pair_slices_by_flank, strict=True), self._modes_of_all_flanks
        alone = np.concatenate([a @ forces[pairs] for a, pairs in each])
        return np.asarray(alone + V @ (self.mode_compliance @ (forces @ V)))

    def dense_compliance_matrix(self) -> Array:
        """Return the compliance D between the ball's n contact pairs as a dense matrix ``(n, n)`` [m/N].

        It is needed only in the rare case that the active-set method cycles.
        """
        V = self._modes_of_all_flanks
        return np.asarray(block_diag(*self.local_compliance) + V @ self.mode_compliance @ V.T)

    def factorise_active_pairs(self, active: Flags, other: BallComplianceFactor | None = None) -> BallComplianceFactor:
        """Factorise the compliance D between the active contact pairs (those in contact).

        Parameters
        ----------
        active : (n,) Flags
            Whether each contact pair is active, that is in contact.
        other : BallComplianceFactor | None, default None
            Factor of another active set; the factors of flanks on which both sets agree are reused.

        Returns
        -------
        BallComplianceFactor
            Inverse D_aa^-1 of the compliance between the active pairs, in factorised form.
        """
        sides = []
        for s, pairs in enumerate(self.pair_slices_by_flank):
            pick = active[pairs]
            if other is not None and np.array_equal(pick, other.active_pairs[pairs]):
                sides.append(other.flank_factors[s])
                continue
            closed, V = np.flatnonzero(pick), self.coupling_modes[s][pick]
            cholesky = cholesky_of_selected_rows(self.local_compliance[s], closed) if closed.size else None
            solved = V if cholesky is None else dpotrs(cholesky, V, lower=1)[0]
            sides.append(FlankFactor(pairs.start + closed, cholesky, solved, V.T @ solved))
        k, G = len(self.mode_compliance), self.mode_compliance
        stiffness = block_diag(*(side.mode_stiffness for side in sides))
        woodbury = np.linalg.solve(np.eye(k) + G @ stiffness, G) if k else G
        return BallComplianceFactor(active.copy(), tuple(sides), woodbury)


def cholesky_of_selected_rows(matrix: Array, selected: Indices) -> Array:
    """Compute the lower Cholesky factor of selected rows and columns of a symmetric matrix.

    Parameters
    ----------
    matrix : (n, n) Array
        Symmetric positive definite matrix.
    selected : Indices
        Indices of k rows and columns.

    Returns
    -------
    (k, k) Array
        Lower factor; entries above the diagonal are arbitrary.

    Raises
    ------
    numpy.linalg.LinAlgError
        The selected part of the matrix is not positive definite.
    """
    return cholesky_in_place(matrix[selected[:, None], selected].T)


def cholesky_in_place(matrix: Array) -> Array:
    """Compute the lower Cholesky factor of a matrix in Fortran order, in place; entries above the diagonal are arbitrary.

    LAPACK is called directly, because SciPy's checks of small matrices take as long as their factorisation.

    Parameters
    ----------
    matrix : (k, k) Array
        Symmetric positive definite matrix in Fortran order; overwritten.

    Returns
    -------
    (k, k) Array
        Lower factor.

    Raises
    ------
    numpy.linalg.LinAlgError
        The matrix is not positive definite.
    """
    L, fault = dpotrf(matrix, lower=1, clean=0, overwrite_a=1)
    if fault:
        raise np.linalg.LinAlgError(
            f"leading minor {fault} of a compliance matrix is not positive: its Cholesky factor exists only for a positive "
            "definite matrix"
        )
    return np.asarray(L)


class FlankFactor(NamedTuple):
    """Factorised compliance between the active contact pairs (those in contact) on one groove flank of a ball."""

    #: Indices of the active pairs among the contact pairs of the flank.
    active_pairs: Indices
    #: Lower Cholesky factor of A_aa, the compliance between the active pairs; None where no pair is active.
    cholesky_factor: Array | None
    #: A_aa^-1 V ``(active pairs, k_s)``: forces of the active pairs by unit displacements of the flank's modes V.
    solved_modes: Array
    #: Stiffness V^T A_aa^-1 V of the active pairs against the flank's modes V ``(k_s, k_s)``.
    mode_stiffness: Array


@dataclass(frozen=True, eq=False)
class BallComplianceFactor:
    """Factorised compliance D_aa between the active contact pairs (those in contact) of one ball.

    It consists of a Cholesky factor for each flank, and of the matrix of Woodbury's formula for the coupling V G V^T of the
    flanks: V are smooth modes of the ball, G is the compliance between them (`BallContactCompliance`).
    """

    #: Whether each of the ball's contact pairs is active ``(n,)``.
    active_pairs: Flags
    #: Factorised compliance of each flank.
    flank_factors: tuple[FlankFactor, ...]
    #: Matrix of Woodbury's formula, (I + G V^T A_aa^-1 V)^-1 G ``(k, k)``.
    woodbury_matrix: Array

    def solve_forces(self, rhs: Array) -> Array:
        """Compute the forces of the active contact pairs that produce given displacements there: D_aa^-1 rhs.

        Parameters
        ----------
        rhs : (n,) or (n, m) Array
            One or m vectors of displacements at all n contact pairs [m]; values at inactive pairs are ignored.

        Returns
        -------
        Array of the shape of ``rhs``
            Contact forces [N]; zero on inactive pairs.
        """
        out, sides = np.zeros(rhs.shape), self.flank_factors
        for side in sides:
            if side.cholesky_factor is not None:
                solved = dpotrs(side.cholesky_factor, rhs[side.active_pairs], lower=1)[0]
                out[side.active_pairs] = solved.reshape(-1, *rhs.shape[1:])
        z = self.woodbury_matrix @ np.concatenate([side.solved_modes.T @ rhs[side.active_pairs] for side in sides])
        columns_by_flank = consecutive_slices([side.solved_modes.shape[1] for side in sides])
        for side, columns in zip(sides, columns_by_flank, strict=True):
            out[side.active_pairs] -= side.solved_modes @ z[columns]
        return out


def ball_block_from_dense_matrix(matrix: Array) -> BallContactCompliance:
    """Make a `BallContactCompliance` without coupling modes from the compliance matrix ``(n, n)`` of n contacts [m/N]."""
    return BallContactCompliance((matrix,), (np.zeros((len(matrix), 0)),), np.zeros((0, 0)))


@dataclass(frozen=True)
class ContactCompliance:
    """Compliance C = blkdiag(D_p) + U G U^T of the contacts of all balls, with U = blkdiag(U_p); C itself is never formed.

    D_p: compliance of ball p alone; U_p: modes by which its contacts act on screw and nut; G: compliance between the modes
    of all balls. Create it with `contact_compliance_of_single_ball` or `contact_compliance_of_coupled_balls`, which check
    the matrices.
    """

    #: Compliance D_p between the n_p contact pairs of each ball p.
    ball_compliances: tuple[BallContactCompliance, ...]
    #: Modes U_p of each ball ``(n_p, r_p)`` by which its contacts are coupled to those of other balls.
    modes_by_ball: tuple[Array, ...]
    #: Compliance G between the modes of all balls ``(r, r)`` [m/N], symmetric, r = sum r_p.
    mode_compliance: Array

    @cached_property
    def pair_slices_by_ball(self) -> tuple[slice, ...]:
        """For each ball, the slice of its contact pairs among the contact pairs of all balls."""
        return consecutive_slices([len(block) for block in self.ball_compliances])

    @cached_property
    def mode_slices_by_ball(self) -> tuple[slice, ...]:
        """For each ball, the slice of its coupling modes among those of all balls: columns of U, rows of G in U G U^T."""
        return consecutive_slices([modes.shape[1] for modes in self.modes_by_ball])

    def modal_forces(self, forces: Array) -> Array:
        """Compute the forces U^T lambda ``(r,)`` [N] on the coupling modes U by the contact forces lambda ``(n,)`` [N]."""
        each = zip(self.pair_slices_by_ball, self.modes_by_ball, strict=True)
        return np.concatenate([modes.T @ forces[pairs] for pairs, modes in each])


def consecutive_slices(counts: Sequence[int]) -> tuple[slice, ...]:
    """Build consecutive slices of the given lengths: each slice begins where the preceding slice ends."""
    return tuple(slice(i, j) for i, j in pairwise(np.cumsum([0, *counts]).tolist()))


def contact_compliance_of_single_ball(block: Array | BallContactCompliance) -> ContactCompliance:
    """Create the `ContactCompliance` of a problem with a single ball, from a `BallContactCompliance` or a dense matrix.

    Parameters
    ----------
    block : BallContactCompliance or (n, n) Array
        Compliance D between n contact pairs [m/N].

    Returns
    -------
    ContactCompliance
        The compliance, without coupling to other balls.

    Raises
    ------
    ValueError
        A matrix is not finite, or not symmetric to 1e-8 of its largest entry.
    """
    return contact_compliance_of_coupled_balls([block], [np.zeros((len(block), 0))], np.zeros((0, 0)))


def contact_compliance_of_coupled_balls(
    blocks: Sequence[Array | BallContactCompliance], modes: Sequence[Array], coupling: Array
) -> ContactCompliance:
    """Create the compliance blkdiag(D_p) + U G U^T of several balls and check its matrices.

    Parameters
    ----------
    blocks : Sequence of BallContactCompliance or (n_p, n_p) Array
        Compliance D_p between the n_p contact pairs of each ball [m/N].
    modes : (n_p, r_p) Arrays
        Modes U_p of each ball by which its contacts are coupled to those of other balls.
    coupling : (r, r) Array
        Compliance G between the modes of all balls [m/N], r = sum r_p.

    Returns
    -------
    ContactCompliance
        The compliance.

    Raises
    ------
    ValueError
        A matrix is not finite, or not symmetric to 1e-8 of its largest entry.
    """
    made: dict[int, BallContactCompliance] = {}  # congruent balls share one block
    for p, block in enumerate(blocks):
        if id(block) not in made:
            given = block if isinstance(block, BallContactCompliance) else ball_block_from_dense_matrix(block)
            *local, G = (_symmetrise_checked(f"block {p}", x) for x in (*given.local_compliance, given.mode_compliance))
            made[id(block)] = BallContactCompliance(tuple(local), given.coupling_modes, G)
    by_ball = tuple(made[id(block)] for block in blocks)
    return ContactCompliance(by_ball, tuple(modes), _symmetrise_checked("the coupling", coupling))


def _symmetrise_checked(name: str, matrix: Array) -> Array:
    """Return a matrix made exactly symmetric; raise ValueError unless it is finite, and symmetric up to round-off.

    ``name``: name of the matrix for the error message.
    """
    if not np.isfinite(matrix).all():
        raise ValueError(f"the compliance matrix of {name} contains values that are not finite: all must be finite")
    skew = np.abs(matrix - matrix.T).max(initial=0.0)
    if skew > 1e-8 * np.abs(matrix).max(initial=0.0):
        raise ValueError(
            f"the compliance matrix of {name} is not symmetric: it differs from its transpose by up to {skew:.3g} m/N"
        )
    return np.asarray(0.5 * (matrix + matrix.T))


#: Largest number of Newton iterations over all balls.
MOST = 60

#: Stiffness [N/m] that regularises, far from equilibrium, motions that no contact resists: a ten thousandth of the
#: stiffness of a contact.
HOLD = 1e4

#: Factorised Newton equations are reused as long as each step reduces the residual below this fraction of the last one.
KEPT = 0.2

#: Ratio of the coupled compliance of the bodies to the local compliance of the contacts, for one distribution of forces,
#: below which Newton's step neglects the coupled compliance.
FEEBLE = 1e-4


@dataclass(frozen=True)
class ContactResult:
    """Contact forces, gaps and rigid motions of all balls; without convergence, the last iterate and the reason."""

    #: Contact forces ``(n,)`` [N].
    forces: Array
    #: Gaps between ball and groove at the contact pairs ``(n,)`` [m]; zero up to round-off where a pair is closed.
    gaps: Array
    #: Rigid motions y of balls, shaft and housings ``(k,)`` [m, rad].
    rigid_motions: Array
    #: Number of iterations of Newton's method.
    iterations: int
    #: "converged", or the reason why the solution did not converge.
    status: str
    #: Largest unbalanced force over the largest force on a ball, the residual by which convergence is judged.
    unbalanced_force_ratio: float

    @property
    def converged(self) -> bool:
        """Whether contact conditions and equilibrium are satisfied."""
        return self.status == "converged"


@dataclass
class BallContactState:
    """Contact state of one ball: forces, active contact pairs (those in contact), and energy."""

    #: Forces at the contact pairs of the ball ``(n,)`` [N].
    forces: Array
    #: Whether each contact pair of the ball is active, that is in contact ``(n,)``.
    active_pairs: Flags
    #: Factorised compliance between the active contact pairs; None: not yet computed.
    compliance_factor: BallComplianceFactor | None
    #: Contact energy of the ball [J]: -min (1/2 l^T D l + g^T l) over its contact forces l >= 0, with its gaps g.
    contact_energy: float


def solve_contacts_of_one_ball(
    block: BallContactCompliance, gap: Array, first_guess: BallContactState | Flags, max_changes: int = 60
) -> BallContactState:
    """Solve the unilateral contact of one ball between fixed grooves: min 1/2 l^T D l + g^T l over forces l >= 0.

    The solution is found by an active-set method, or by non-negative least squares if that cycles.

    Parameters
    ----------
    block : BallContactCompliance
        Compliance D between the n contact pairs of the ball.
    gap : (n,) Array
        Gaps g without contact forces of this ball [m].
    first_guess : BallContactState | Flags
        First guess: whether each pair is active (n,), or an earlier contact state, whose factors of unchanged flanks are
        reused.
    max_changes : int, default 60
        Largest number of changes of the active set.

    Returns
    -------
    BallContactState
        Contact state at the minimum.
    """
    known = first_guess.compliance_factor if isinstance(first_guess, BallContactState) else None
    active = (first_guess.active_pairs if isinstance(first_guess, BallContactState) else first_guess).copy()
    scale = float(np.abs(gap).max(initial=0.0))
    seen: set[bytes] = set()
    for _ in range(max_changes):
        if known is None or not np.array_equal(known.active_pairs, active):
            known = block.factorise_active_pairs(active, known)
        forces = known.solve_forces(-gap)
        slack = gap + block.compute_opened_gaps(forces)
        new = np.where(active, forces > 0.0, slack < -1e-13 * scale)
        if np.array_equal(new, active):
            return BallContactState(forces, active, known, -0.5 * float(forces @ (gap + slack)))
        key = new.tobytes()
        if key in seen:
            break
        seen.add(key)
        active = new
    L = np.linalg.cholesky(block.dense_compliance_matrix())
    forces, _ = nnls(L.T, np.linalg.solve(L, -gap), maxiter=30 * gap.size)
    active = forces > 1e-12 * max(float(forces.max(initial=0.0)), 1e-300)
    energy = float(-0.5 * forces @ block.compute_opened_gaps(forces) - gap @ forces)
    return BallContactState(forces, active, block.factorise_active_pairs(active), energy)


class NewtonFactor(NamedTuple):
    """Factorised equations of one Newton step for all balls; unknowns: modal forces w and rigid motions y."""

    #: For every ball in contact: the slice of its c amplitudes in w, and the low-rank factor R ``(c, rank)`` of U^T D^-1 U
    #: = R R^T, where D is the compliance of the ball's contact pairs and U their coupling modes.
    low_rank_factors: list[tuple[slice, Array]]
    #: Index of the first column of each ball's low-rank factor R among the columns of all balls' factors.
    column_starts: list[int]
    #: Coefficients T ``(sum of ranks, number of rigid motions)`` in U^T D^-1 N = R T; N: gaps closed by unit rigid motions.
    motion_coefficients: Array
    #: Lower Cholesky factor of I + R^T G R; G: compliance between the coupling modes.
    inner_cholesky_factor: Array
    #: LU factor and pivots of the reduced equations for the step of the rigid motions.
    motion_lu_factor: tuple[Array, Indices]

    def newton_step(self, mode_residual: Array, mode_displacement: Array, unbalanced_loads: Array) -> tuple[Array, Array]:
        """Compute the Newton step of modal forces w and rigid motions y from the residuals of their equations.

        U: coupling modes of all balls; G: compliance between these modes; lambda: contact forces; f: loads on the rigid
        motions; N: gaps closed by unit rigid motions.

        Parameters
        ----------
        mode_residual : (r,) Array
            Residual U^T lambda - w of the modal forces [N].
        mode_displacement : (r,) Array
            Displacements G (U^T lambda - w) of the modes by that residual [m].
        unbalanced_loads : (k,) Array
            Unbalanced loads f - N^T lambda on the k rigid motions [N, N m].

        Returns
        -------
        dw : (r,) Array
            Step of the modal forces w [N].
        dy : (k,) Array
            Step of the rigid motions y [m, rad].
        """
        moved = np.concatenate([np.zeros(0), *(R.T @ mode_displacement[c] for c, R in self.low_rank_factors)])
        answer = self._solve_low_rank_system(moved)
        dy = lu_solve(self.motion_lu_factor, unbalanced_loads + self.motion_coefficients.T @ answer, check_finite=False)
        amplitude = self._solve_low_rank_system(self.motion_coefficients @ dy) - answer
        dw = mode_residual.copy()
        for (c, R), (i, j) in zip(self.low_rank_factors, pairwise(self.column_starts), strict=True):
            dw[c] += R @ amplitude[i:j]
        return dw, dy

    def _solve_low_rank_system(self, rhs: Array) -> Array:
        """Compute (I + R^T G R)^-1 rhs with the low-rank factors R of all balls and the compliance G between modes.

        ``rhs`` has one entry for each column of R.
        """
        return dpotrs(self.inner_cholesky_factor, rhs, lower=1)[0].ravel() if rhs.size else rhs


def factorise_at_low_rank(matrix: Array, loads: Array, scale: Array) -> tuple[Array, Array]:
    """Approximate a positive semidefinite matrix by R R^T of low rank, and write vectors in its range as R T.

    R is a pivoted Cholesky factor, stopped when the remainder of the matrix, with rows and columns multiplied by ``scale``,
    is below `FEEBLE`.

    Parameters
    ----------
    matrix : (n, n) Array
        Positive semidefinite matrix.
    loads : (n, k) Array
        k vectors in the range of the matrix.
    scale : (n,) Array
        Factors on the rows and columns of the matrix.

    Returns
    -------
    R : (n, rank) Array
        Low-rank factor of the matrix.
    T : (rank, k) Array
        Coefficients of the vectors, in the columns of R.
    """
    packed, order, rank, _ = dpstrf(matrix * np.outer(scale, scale), tol=FEEBLE, lower=1)
    L, order = np.tril(packed)[:, :rank], order - 1
    R = np.empty((len(matrix), rank))
    R[order] = L / scale[order, None]
    first = order[:rank]
    return R, np.asarray(dtrsm(1.0, L[:rank], scale[first, None] * loads[first], lower=1)) if rank else loads[:0]


@dataclass
class SolverState:
    """State of the contact solver after a solution, from which the solution of a similar problem can start."""

    #: Modal amplitudes w of the contact forces ``(r,)`` [N].
    modal_forces: Array
    #: Rigid motions y of balls, shaft and housings ``(k,)`` [m, rad].
    rigid_motions: Array
    #: Contact states of the balls, which a start reuses if the compliance is the same; None: not yet computed.
    ball_states: list[BallContactState] | None = None
    #: Factorised equations of the last Newton step; None: not yet computed.
    newton_factor: NewtonFactor | None = None


class _ContactEnergyProblem:
    """Contact problem of all balls as the minimum of an energy Phi; evaluates Phi, its residuals and Newton's equations.

    C: compliance of n contact pairs; ``gap``: gaps of the undeformed bodies (n,) [m]; N: gaps closed by a unit of each of k
    rigid motions (n, k); f: loads on them (k,) [N, N m]; ``balls``: contact states to start from, or None.
    """

    def __init__(
        self, C: ContactCompliance, gap: Array, N: sp.csr_array, f: Array, balls: list[BallContactState] | None
    ) -> None:
        self.C, self.f = C, f
        self.gaps = [gap[pairs] for pairs in C.pair_slices_by_ball]
        self.rows = []
        for pairs in C.pair_slices_by_ball:
            block = N[pairs]
            columns = np.unique(block.indices)
            self.rows.append((columns, block[:, columns].toarray()))
        at_rest = (BallContactState(np.zeros(g.size), g < np.quantile(g, 0.2), None, 0.0) for g in self.gaps)
        self.balls = list(balls or at_rest)

    def evaluate_energy(self, w: Array, y: Array) -> tuple[float, Array, Array]:
        """Evaluate the energy Phi [J] at modal forces w and rigid motions y, and store the contact states of the balls.

        Returns Phi and the two residuals U^T lambda - w ``(r,)`` [N] and f - N^T lambda ``(k,)`` [N, N m]. U: coupling
        modes; lambda: contact forces of all balls; f: loads on the rigid motions; N: gaps closed by unit rigid motions.
        """
        phi = 0.5 * float(w @ (self.C.mode_compliance @ w)) - float(self.f @ y)
        for i, gap in enumerate(self.gaps_without_local_compliance(w, y)):
            self.balls[i] = solve_contacts_of_one_ball(self.C.ball_compliances[i], gap, self.balls[i])
            phi += self.balls[i].contact_energy
        return phi, *self.residuals(w)

    def gaps_without_local_compliance(self, w: Array, y: Array) -> list[Array]:
        """Compute the gaps of each ball ``(n_i,)`` [m] without the displacements by its own compliance D_i.

        These gaps result from the undeformed gaps, the rigid motions, and the coupling with other balls. ``w``: forces on
        the r modes that couple the balls (r,) [N]; ``y``: rigid motions (k,) [m, rad].
        """
        z = self.C.mode_compliance @ w
        each = zip(self.gaps, self.C.modes_by_ball, self.C.mode_slices_by_ball, self.rows, strict=True)
        return [gap + U @ z[c] - n @ y[columns] for gap, U, c, (columns, n) in each]

    def residuals(self, w: Array) -> tuple[Array, Array]:
        """Compute the residuals U^T lambda - w ``(r,)`` [N] and f - N^T lambda ``(k,)`` [N, N m] of Newton's method.

        U: coupling modes; lambda: contact forces in the stored states of the balls; ``w``: modal forces (r,) [N]; f: loads
        on the rigid motions; N: gaps closed by unit rigid motions.
        """
        balance = self.f.copy()
        for ball, (columns, n) in zip(self.balls, self.rows, strict=True):
            balance[columns] -= n.T @ ball.forces
        return self.C.modal_forces(np.concatenate([ball.forces for ball in self.balls])) - w, balance

    def starting_values_for_touching_pairs(self, touching: Sequence[Flags]) -> tuple[Array, Array]:
        """Compute starting values of modal forces w and rigid motions y from a guess of the contact pairs that touch.

        ``touching``: for each ball, whether each pair is expected to touch (n_i,). Returns the modal forces w (r,) [N]
        and the rigid motions y (k,) [m, rad]; the forces of some pairs may be negative.
        """
        for i, (gap, active) in enumerate(zip(self.gaps, touching, strict=True)):
            factor = self.C.ball_compliances[i].factorise_active_pairs(active)
            self.balls[i] = BallContactState(factor.solve_forces(-gap), active, factor, 0.0)
        back, balance = self.residuals(np.zeros(len(self.C.mode_compliance)))
        return self.factorise_newton_equations(HOLD).newton_step(back, self.C.mode_compliance @ back, balance)

    def factorise_newton_equations(self, regularising_stiffness: float) -> NewtonFactor:
        """Assemble and factorise Newton's equations for w and y at the present contact states of the balls.

        ``regularising_stiffness``: stiffness [N/m] that regularises rigid motions which no contact resists.

        D: compliance of the active contact pairs; U: coupling modes; G: compliance between these modes; N: gaps closed by
        unit rigid motions; f: loads on the rigid motions; lambda: contact forces. With M = U^T D^-1 U = R R^T (zero between
        balls), U^T D^-1 N = R T, and w eliminated from

            (I + M G) dw - R T dy = U^T lambda - w,  -T^T R^T G dw + N^T D^-1 N dy = f - N^T lambda,

        the matrix N^T D^-1 N - T^T T + T^T (I + R^T G R)^-1 T remains for dy. R and T are those of `factorise_at_low_rank`,
        which makes this matrix positive; the step is Newton's up to negligible terms. Raises numpy.linalg.LinAlgError if G
        is not the compliance of an elastic body.
        """
        G = self.C.mode_compliance
        outer, size = regularising_stiffness * np.eye(self.f.size), np.sqrt(G.diagonal())
        traces, answers, loads, starts = [], [], [], [0]
        for i, ball in enumerate(self.balls):
            if ball.compliance_factor is None or not ball.active_pairs.any():
                continue
            d, n = self.rows[i]
            c, r = self.C.mode_slices_by_ball[i], self.C.modes_by_ball[i].shape[1]
            columns = np.hstack([self.C.modes_by_ball[i], n])
            M = columns.T @ ball.compliance_factor.solve_forces(columns)  # zero on the open pairs
            R, T_ball = factorise_at_low_rank(M[:r, :r], M[:r, r:], size[c])
            T = np.zeros((len(T_ball), self.f.size))
            T[:, d] = T_ball
            outer[np.ix_(d, d)] += M[r:, r:]
            traces.append((c, R))
            answers.append(G[c].T @ R)
            loads.append(T)
            starts.append(starts[-1] + len(T))
        T, inner = np.vstack([np.zeros((0, self.f.size)), *loads]), np.zeros((0, 0))
        if len(T):
            answer = np.hstack(answers)
            inner = np.vstack([R.T @ answer[c] for c, R in traces])
            inner[np.diag_indices(len(inner))] += 1.0
            inner = cholesky_in_place(inner.T)
            solved = dtrsm(1.0, inner, T, lower=1)
            outer += solved.T @ solved - T.T @ T
        return NewtonFactor(traces, starts, T, inner, lu_factor(outer, overwrite_a=True, check_finite=False))


def solve_contacts_of_all_balls(
    C: ContactCompliance,
    gap: Array,
    N: sp.csr_array,
    f: Array,
    *,
    start: SolverState | None = None,
    touching: Sequence[Flags] = (),
    tolerance: float = 1e-10,
) -> tuple[ContactResult, SolverState]:
    """Solve the unilateral contact of all balls for contact forces lambda, gaps g and rigid motions y.

    The equations are g = g0 + C lambda - N y >= 0, lambda >= 0, lambda_i g_i = 0 at each pair, and N^T lambda = f. The
    residual is the unbalanced force (and the mismatch of the modal forces) over the largest force on a ball. If there is no
    equilibrium, the status says that the solution did not converge.

    Parameters
    ----------
    C : ContactCompliance
        Compliance C between n contact pairs.
    gap : (n,) Array
        Gaps g0 of the undeformed bodies [m].
    N : (n, k) sparse array
        Gap of each pair that a unit of each rigid motion closes.
    f : (k,) Array
        Loads on the rigid motions [N, N m].
    start : SolverState | None, default None
        State at the end of the solution of a similar problem, as the first guess; None: the undeformed bodies.
    touching : sequence of (n_i,) Flags, optional
        Contact pairs of each ball that are expected to touch; used if there is no ``start``.
    tolerance : float, default 1e-10
        Largest relative residual of a converged solution.

    Returns
    -------
    result : ContactResult
        The solution, or the last state and the reason why it did not converge.
    state : SolverState
        State from which the solution of a similar problem may start.
    """
    begin = SolverState(np.zeros(C.mode_compliance.shape[0]), np.zeros(f.size)) if start is None else start
    system = _ContactEnergyProblem(C, gap, N, f, begin.ball_states)
    w, y = begin.modal_forces.copy(), begin.rigid_motions.copy()
    if touching and start is None:
        w, y = system.starting_values_for_touching_pairs(touching)
    phi, back, balance = system.evaluate_energy(w, y)
    status, iteration, residual, factor, before = "", 0, np.inf, begin.newton_factor, np.inf
    for iteration in range(1, MOST + 1):  # noqa: B007
        heaviest = max(float(b.forces.sum()) for b in system.balls)
        scale = max(heaviest, float(np.abs(f).max(initial=0.0)) / len(system.balls))
        residual = float(np.abs(balance).max(initial=0.0)) / scale
        mismatch = float(np.abs(back).max(initial=0.0)) / max(float(np.abs(w).max(initial=0.0)), 1e-300)
        if residual <= tolerance and mismatch <= tolerance:
            status = "converged"
            break
        error = max(residual, mismatch)
        kept = factor is not None and error <= KEPT * before
        if factor is None or not kept:
            factor = system.factorise_newton_equations(HOLD * min(1.0, residual))
        before = error
        moved = C.mode_compliance @ back
        dw, dy = factor.newton_step(back, moved, balance)
        slope = -float(dw @ moved) - float(dy @ balance)
        t, done = 1.0, False
        for _ in range(30):
            trial = system.evaluate_energy(w + t * dw, y + t * dy)
            if trial[0] <= phi + 1e-4 * t * slope or abs(t * slope) <= 1e-12 * abs(phi):
                done = True
                break
            t *= 0.4
        w, y = w + t * dw, y + t * dy
        phi, back, balance = trial
        if not done and kept:
            before = 0.0  # the next step uses a new factor
        elif not done:
            status = f"stalled at a relative residual of {residual:.1e}"
            break
    if not status:
        status = f"not converged after {MOST} iterations (relative residual {residual:.1e})"
    forces = [ball.forces for ball in system.balls]
    each = zip(system.gaps_without_local_compliance(w, y), C.ball_compliances, forces, strict=True)
    gaps = [between + block.compute_opened_gaps(f) for between, block, f in each]
    result = ContactResult(np.concatenate(forces), np.concatenate(gaps), y, iteration, status, residual)
    return result, SolverState(w, y, system.balls, factor)
