"""The linear systems of a contact with given closed pairs, solved patch by patch.

With the pairs of a set closed, the others free of force:

    C_aa lambda_a - N_a y = -g0_a,    N_a^T lambda_a = f                                            (1)

C = blkdiag(A_p) + U G U^T. Each block's closed part has a Cholesky factor of its own, kept while its set stays; the
low-rank coupling enters by the identity of Woodbury, C^-1 = D^-1 - D^-1 U M U^T D^-1 with M = G (1 + T G)^-1 and
T = U^T D^-1 U; what remains are systems as small as G and as the number of rigid motions.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.linalg import LinAlgError, cho_factor, cho_solve, eigh, lu_factor, lu_solve

from hifi.compliance import Compliance

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]

#: Rigid motions whose contact stiffness is below this fraction of the stiffest one count as not held.
LOOSE = 1e-12


class Unpositive(Exception):
    """A compliance block, or the coupled compliance, is not positive definite."""


@dataclass(frozen=True)
class State:
    """Solution of (1): forces (n,) [N], motions (k,) [m, rad]; escape (k,): the motion that the load drives and no
    closed pair holds, or None where the loads are in equilibrium."""

    forces: Array
    motions: Array
    escape: Array | None


@dataclass(frozen=True)
class _Factor:
    """One block with a given closed set: its pairs, and D^-1 applied to its directions and modes."""

    closed: Indices  # numbers in the block
    factor: Any
    directions: Array  # N_a, (closed, motions of the block)
    modes: Array  # U_a
    solved_directions: Array  # D^-1 N_a
    solved_modes: Array  # D^-1 U_a


class ActiveSystem:
    """A contact's data in the form that changing closed sets need: each block with its rows of N and U."""

    def __init__(
        self, compliance: Compliance, gap: Array, directions: Any, load: Array, prescribed: Array | None
    ) -> None:
        """See `hifi.contact.solve_contact` for the arguments; raises ValueError for shapes that do not fit."""
        matrix = sparse.csr_array(directions, dtype=float)
        self.compliance, self.size = compliance, compliance.size
        self.gap, self.load = np.asarray(gap, float), np.asarray(load, float)
        count = self.load.size
        if self.gap.shape != (self.size,) or matrix.shape != (self.size, count) or self.load.shape != (count,):
            raise ValueError(
                f"compliance of {self.size} pairs, gaps of shape {self.gap.shape}, directions of shape {matrix.shape}, "
                f"load of shape {self.load.shape}; pairs and motions must agree"
            )
        given = np.full(count, np.nan) if prescribed is None else np.asarray(prescribed, float)
        if given.shape != (count,):
            raise ValueError(f"prescribed has shape {given.shape}; one value or nan for each of the {count} motions")
        if not all(np.isfinite(values).all() for values in (self.gap, self.load, matrix.data)):
            raise ValueError("gaps, directions and load must be finite")
        self.free, self._given = np.isnan(given), given
        self._matrix, self._transposed = matrix, sparse.csr_array(matrix.T)
        size = np.sqrt(np.asarray(matrix.multiply(matrix).sum(axis=0)).ravel())
        #: Size of each motion's effect on the gaps (1 if it has none), to compare translations with rotations: (k,).
        self.motion_scale = np.where(size > 0.0, size, 1.0)
        self._spans = list(pairwise(compliance.starts))
        self._motions: list[Indices] = [np.unique(matrix[i:j].indices).astype(np.int64) for i, j in self._spans]
        self._rows: list[Array] = [
            matrix[i:j].toarray()[:, m] for (i, j), m in zip(self._spans, self._motions, strict=True)
        ]
        self._factors: list[_Factor | None] = [None] * len(self._spans)

    def rest(self) -> Array:
        """Motions to begin with: the prescribed ones, zero for the rest; (k,)."""
        return np.where(self.free, 0.0, self._given)

    def close(self, motions: Array) -> Array:
        """N y (n,) [m]."""
        return np.asarray(self._matrix @ motions)

    def gaps(self, forces: Array, motions: Array) -> tuple[Array, float]:
        """Gaps (n,) [m], and the largest of the terms they are summed from [m]."""
        terms = (self.gap, self.compliance.apply(forces), self.close(motions))
        scale = max(float(np.abs(term).max(initial=0.0)) for term in terms)
        return np.asarray(terms[0] + terms[1] - terms[2]), scale

    def imbalance(self, forces: Array) -> float:
        """The largest |N^T lambda - f|_j over (|N|^T |lambda| + |f|)_j, over the free motions."""
        residual = np.abs(self._transposed @ forces - self.load)[self.free]
        scale = (abs(self._transposed) @ np.abs(forces) + np.abs(self.load))[self.free]
        return float(np.max(np.where(residual > 0.0, residual / np.maximum(scale, 1e-300), 0.0), initial=0.0))

    def equilibrium_rows(self) -> tuple[Any, Array]:
        """N and f of the free motions: (n, free) sparse, (free,)."""
        return self._matrix[:, np.flatnonzero(self.free)], self.load[self.free]

    def solve(self, closed: Flags, before: Array) -> State:
        """Forces and motions with the flagged pairs closed, (1).

        Args:
            closed: (n,) closed pairs.
            before: (k,) motions of the step before, kept where nothing holds them.

        Raises:
            Unpositive: a block, or the coupled compliance of the closed pairs, is not positive definite.
        """
        factors = [self._factor(p, closed[i:j]) for p, (i, j) in enumerate(self._spans)]
        system = _Reduced(self, factors)
        forces, motions, escape = system.solve(self.gap, self.load, before)
        # One step of refinement: Woodbury's identity loses digits where the coupling is softer than the patches.
        gaps, _ = self.gaps(forces, motions)
        unbalanced = self.load - self._transposed @ forces
        change, moved, _ = system.solve(gaps, unbalanced, np.zeros_like(motions), correct=True)
        return State(forces + change, motions + moved, escape)

    def _factor(self, p: int, closed: Flags) -> _Factor:
        """Cholesky factor of block p's closed pairs, from the step before if they have not changed."""
        numbers = np.flatnonzero(closed)
        kept = self._factors[p]
        if kept is not None and np.array_equal(kept.closed, numbers):
            return kept
        try:
            part = self.compliance.blocks[p][np.ix_(numbers, numbers)]
            factor = cho_factor(part, lower=True) if len(numbers) else None
        except LinAlgError:
            raise Unpositive(
                f"the compliance of block {p} is not positive definite: check its mesh and its supports"
            ) from None
        rows, modes = self._rows[p][numbers], self.compliance.modes[p][numbers]
        made = _Factor(numbers, factor, rows, modes, _back(factor, rows), _back(factor, modes))
        self._factors[p] = made
        return made


def _back(factor: Any, rhs: Array) -> Array:
    return np.asarray(cho_solve(factor, rhs)) if factor is not None and rhs.size else np.zeros_like(rhs)


class _Reduced:
    """(1) reduced to the rigid motions, for one closed set."""

    def __init__(self, system: ActiveSystem, factors: list[_Factor]) -> None:
        self.system, self.factors = system, factors
        count, rank = system.load.size, len(system.compliance.coupling)
        held, soft, mixed = np.zeros((count, count)), np.zeros((rank, rank)), np.zeros((rank, count))
        for f, motions, columns in zip(factors, system._motions, system.compliance.columns, strict=True):
            held[np.ix_(motions, motions)] += f.directions.T @ f.solved_directions
            soft[np.ix_(columns, columns)] += f.modes.T @ f.solved_modes
            mixed[np.ix_(columns, motions)] += f.modes.T @ f.solved_directions
        self.mixed = mixed
        self.woodbury = _woodbury(system.compliance.coupling, soft)
        self.stiffness = held - mixed.T @ self.woodbury @ mixed
        self._split_motions()

    def _split_motions(self) -> None:
        """Motions that the closed pairs hold, with their stiffness, and those that they do not."""
        free = np.flatnonzero(self.system.free)
        scale = self.system.motion_scale[free]
        reduced = self.stiffness[np.ix_(free, free)] / np.outer(scale, scale)
        values, vectors = eigh(0.5 * (reduced + reduced.T)) if free.size else (np.zeros(0), np.zeros((0, 0)))
        firm = values > LOOSE * np.abs(values).max(initial=0.0)
        self.free, self.scale = free, scale
        self.values, self.firm, self.loose = values[firm], vectors[:, firm], vectors[:, ~firm]

    def solve(
        self, gap: Array, load: Array, before: Array, *, correct: bool = False
    ) -> tuple[Array, Array, Array | None]:
        """Forces (n,), motions (k,) and escaping motion; `correct`: a correction, whose prescribed motions are zero."""
        system = self.system
        columns, pieces = system.compliance.columns, [gap[i:j] for i, j in system._spans]
        solved = [_back(f.factor, piece[f.closed]) for f, piece in zip(self.factors, pieces, strict=True)]
        by_motion, by_mode = np.zeros(load.size), np.zeros(len(self.woodbury))
        for f, piece, moved, column in zip(self.factors, solved, system._motions, columns, strict=True):
            by_motion[moved] += f.directions.T @ piece
            by_mode[column] += f.modes.T @ piece
        motions = before.copy() if correct else np.where(system.free, before, system.rest())
        balance = load + by_motion - self.mixed.T @ (self.woodbury @ by_mode) - self.stiffness @ motions
        scaled = balance[self.free] / self.scale
        motions[self.free] += self.firm @ ((self.firm.T @ scaled) / self.values) / self.scale
        driven = self.loose @ (self.loose.T @ (load[self.free] / self.scale))
        escape = None
        if np.abs(driven).max(initial=0.0) > 1e-11 * np.abs(load[self.free] / self.scale).max(initial=0.0):
            escape = np.zeros_like(load)
            escape[self.free] = driven / self.scale
        amplitude = self.woodbury @ (self.mixed @ motions - by_mode)
        forces = np.zeros(system.size)
        for f, piece, moved, column, (i, _) in zip(
            self.factors, solved, system._motions, columns, system._spans, strict=True
        ):
            forces[i + f.closed] = f.solved_directions @ motions[moved] - piece - f.solved_modes @ amplitude[column]
        return forces, motions, escape


def _woodbury(coupling: Array, soft: Array) -> Array:
    """M = G (1 + T G)^-1, symmetric."""
    if not len(coupling):
        return coupling
    factor = lu_factor((np.eye(len(coupling)) + soft @ coupling).T)
    inner = np.asarray(lu_solve(factor, coupling.T)).T
    if not np.isfinite(inner).all():
        raise Unpositive("the coupled compliance is singular: check the coupling and its supports")
    return np.asarray(0.5 * (inner + inner.T))
