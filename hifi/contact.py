"""Frictionless unilateral contact in compliance form, by a primal-dual active set.

Contact pairs i carry forces lambda_i >= 0 [N], pressing the bodies apart, and have gaps g_i >= 0 [m]:

    g = g0 + C lambda - N y,   lambda >= 0,   g >= 0,   lambda_i g_i = 0,   N^T lambda = f          (1)

g0: gaps of the undeformed bodies at rest; C: compliance, symmetric positive definite; y: rigid motions of the free
bodies (translations [m], rotations [rad]), column j of N being the gap closed by a unit of motion j; f: loads on them
[N, N m], positive where they do work in a closing motion. These are the optimality conditions of the convex problem
min 1/2 lambda^T C lambda + g0^T lambda over lambda >= 0 with N^T lambda = f, so a solution's forces are unique.

Method: for a trial set of closed pairs (1) is linear; pairs that pull are opened, pairs that overlap are closed, all at
once (Hintermueller, Ito and Kunisch, SIAM J. Optim. 13 (2002) 865). When the number of wrong pairs stops falling, one
pair at a time changes, the last wrong one (Murty's rule; Judice and Pires, Comput. Oper. Res. 21 (1994) 587), which
cannot cycle where C is positive definite and the bodies stay held. A body left without support moves along its
unbalanced load until a pair closes; if none can, that motion proves that the scene cannot be held.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from hifi.active_set import ActiveSystem, Unpositive
from hifi.compliance import Compliance

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: Forces and gaps below this fraction of the largest of their kind count as zero.
ROUND_OFF = 1e-13
#: Iterations that may pass without fewer wrong pairs before pairs change one at a time.
PATIENCE = 5


@dataclass(frozen=True)
class ContactResult:
    """Solution of (1), or the last state and the reason why it is none.

    forces: (n,) [N]; gaps: (n,) [m], round-off on closed pairs; motions: (k,) rigid motions y [m, rad]; iterations:
    linear systems solved; status: "converged", or why not and what to do; complementarity: the largest
    |min(lambda_i / lambda_max, g_i / g_scale)|, g_scale being the largest of the terms of g; equilibrium: the largest
    |N^T lambda - f|_j over (|N|^T |lambda| + |f|)_j, over the motions that are free.
    """

    forces: Array
    gaps: Array
    motions: Array
    iterations: int
    status: str
    complementarity: float
    equilibrium: float

    @property
    def converged(self) -> bool:
        """Whether (1) holds."""
        return self.status == "converged"


def solve_contact(
    compliance: Compliance,
    gap: Array,
    directions: Any,
    load: Array,
    *,
    prescribed: Array | None = None,
    start: Flags | None = None,
    max_iterations: int = 200,
) -> ContactResult:
    """Forces, gaps and rigid motions of a frictionless contact, equations (1) of this module.

    Args:
        compliance: C, n pairs [m/N].
        gap: g0 (n,) [m], negative where the undeformed bodies overlap.
        directions: N (n, k), array or scipy sparse matrix; k may be 0.
        load: f (k,) [N, N m]; ignored where the motion is prescribed.
        prescribed: y (k,), nan where a motion is free; all free if left out.
        start: (n,) closed pairs to begin with, such as those of a neighbouring load case; all if left out.
        max_iterations: linear systems to solve at most.

    Returns:
        The result; failure to converge, a compliance that is not positive definite, and a scene that cannot be held
        are told in its status. Motions that change no gap stay zero.

    Raises:
        ValueError: shapes that do not fit, or values that are not finite.
    """
    system = ActiveSystem(compliance, gap, directions, load, prescribed)
    closed = np.ones(system.size, dtype=bool) if start is None else np.array(start, dtype=bool)
    if closed.shape != (system.size,):
        raise ValueError(f"start has shape {closed.shape}; one flag for each of the {system.size} pairs is needed")
    best, patience = system.size + 1, PATIENCE
    forces, motions = np.zeros(system.size), system.rest()
    status = ""
    iteration = 0
    while iteration < max_iterations:
        iteration += 1
        try:
            state = system.solve(closed, motions)
        except Unpositive as error:
            status = str(error)
            break
        forces, motions = state.forces, state.motions
        if state.escape is not None:
            touching, status = _until_touch(system, forces, motions, state.escape, closed)
            if status:
                break
            motions, closed = motions + touching[0], closed | touching[1]
            continue
        wrong = _wrong_pairs(system, forces, motions, closed)
        count = int(wrong.sum())
        if count == 0:
            status = "converged"
            break
        patience = PATIENCE if count < best else patience - 1
        best = min(best, count)
        closed = closed ^ (wrong if patience > 0 else _last(wrong))
    if not status:
        status = _why_not(system, max_iterations)
    return _result(system, forces, motions, iteration, status)


def _wrong_pairs(system: ActiveSystem, forces: Array, motions: Array, closed: Flags) -> Flags:
    """Closed pairs that pull and open pairs that overlap, (n,)."""
    gaps, scale = system.gaps(forces, motions)
    pull = forces < -ROUND_OFF * np.abs(forces).max(initial=0.0)
    return np.where(closed, pull, gaps < -ROUND_OFF * scale)


def _last(wrong: Flags) -> Flags:
    single = np.zeros_like(wrong)
    single[np.flatnonzero(wrong)[-1]] = True
    return single


def _until_touch(
    system: ActiveSystem, forces: Array, motions: Array, escape: Array, closed: Flags
) -> tuple[tuple[Array, Flags], str]:
    """Step along the unbalanced motion until an open pair closes: ((step, pairs closed), reason if none can)."""
    gaps, scale = system.gaps(forces, motions)
    closing = system.close(escape)
    able = ~closed & (closing > 1e-9 * np.abs(closing).max(initial=0.0))
    if not able.any():
        return (escape, able), f"not held: {_describe(system, escape)}"
    reach = np.full(system.size, np.inf)
    reach[able] = np.maximum(gaps[able], 0.0) / closing[able]
    nearest = float(reach.min())
    return (nearest * escape, reach <= nearest + 1e-9 * scale / float(closing[able].max())), ""


def _describe(system: ActiveSystem, escape: Array) -> str:
    largest = int(np.argmax(np.abs(escape) * system.motion_scale))
    return (
        f"the load drives a motion that no contact stops (largest in motion {largest}); "
        "support the body, prescribe this motion, or change the load"
    )


def _why_not(system: ActiveSystem, iterations: int) -> str:
    """What stands in the way: a load that no forces >= 0 can balance (a linear programme), or too few iterations."""
    matrix, load = system.equilibrium_rows()
    if load.size:
        scale = np.abs(load).max(initial=0.0) or 1.0
        feasible = linprog(np.zeros(system.size), A_eq=matrix.T, b_eq=load / scale, bounds=(0, None), method="highs")
        if feasible.status == 2:
            return "not held: no forces >= 0 balance the load; support the body or prescribe its motion"
    return (
        f"not converged after {iterations} iterations, though the load can be held: raise max_iterations or start "
        "from a neighbouring solution"
    )


def _result(system: ActiveSystem, forces: Array, motions: Array, iterations: int, status: str) -> ContactResult:
    gaps, gap_scale = system.gaps(forces, motions)
    force_scale = float(np.abs(forces).max(initial=0.0)) or 1.0
    natural = np.minimum(forces / force_scale, gaps / (gap_scale or 1.0))
    return ContactResult(
        forces=forces,
        gaps=gaps,
        motions=motions,
        iterations=iterations,
        status=status,
        complementarity=float(np.abs(natural).max(initial=0.0)),
        equilibrium=system.imbalance(forces),
    )
