"""Many specimens of one screw on the motions of its flanks alone, each with its own lever arms, and balls of any contacts.

With K the stiffness of beam and contacts in the common start, forces y on the flanks move them by v - v_0 = P y, P = R
K^-1 R^T. R has three rows a flank: its motion along x3, z3 in the ball's section and its turn about the track. A groove's
centre that lies c beside that of the start moves by c times that turn more, and its force has that moment more. H and f_0
are the contacts' stiffness and forces on the flanks in the start: the equations of a specimen are r = y - H (v - v_0) -
f(v) + f_0 = 0, so that y - r is a better y, because f changes by nearly -H (v - v_0).

Contacts alone hold the screw's soft modes U, P ~ U U^T. Their step is Newton's: D is the change of the contacts'
stiffness since the start, (I + D U U^T) z = r, and y - z follows y. Beyond the modes the beam is much stiffer than the
contacts. So the error falls by the product of two small numbers, and the residual is that of the specimen's own
equations.
"""

import numpy as np

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.records import Array, FlankCommon, FlankMembers, FlankStates

from .ball import FORCE, MX, MZ, flank_hessian, settle_ball
from .coupling import cholesky_lower, triangular
from .status import CONVERGED, ITERATIONS

#: Specimens side by side, most steps, and the share of the residual that a step has to leave at most.
LANES, STEPS, LEFT = 16, 12, 0.9


@kernel
def equations(
    common: FlankCommon, members: FlankMembers, m: int, states: FlankStates, v: Array, r: Array, DU: Array
) -> float:
    """Fill the equations r (6 N,) of specimen m at motions v (6 N,) of its flanks from the start, and D U (6 N, k); settles
    its balls. Returns the largest force that is out of balance over the largest contact force, at least ``least``."""
    _, start, forces, stiffness, _, U, profile, tiny, least, spread = common
    geometry, closure, r_ball, lever = members.geometry[m], members.closure[m], members.r_ball[m], members.lever[m]
    y, p, force = states.pull[m], states.p[m], states.force[m]
    shift, contact, change = np.zeros((4, 2)), np.zeros((4, 5)), np.empty((4, 4))
    scale, worst = least, 0.0
    for i in range(r_ball.size):
        j = 6 * i
        for s in range(2):
            turn = start[i, 4 + s] + v[j + 4 + s]
            shift[s, 0] = start[i, 2 * s] + v[j + 2 * s] - lever[i, s, 1] * turn
            shift[s, 1] = start[i, 2 * s + 1] + v[j + 2 * s + 1] + lever[i, s, 0] * turn
        settle_ball(p[i], shift, geometry[i], closure[i], r_ball[i], profile, tiny, contact)
        flank_hessian(contact, change)
        for s in range(4):
            force[i, s] = contact[s, FORCE]
            scale = max(scale, force[i, s])
        for s in range(2):
            fx, fz = force[i, s] * contact[s, MX], force[i, s] * contact[s, MZ]
            r[j + 2 * s] = y[j + 2 * s] - fx + forces[i, 2 * s]
            r[j + 2 * s + 1] = y[j + 2 * s + 1] - fz + forces[i, 2 * s + 1]
            r[j + 4 + s] = y[j + 4 + s] - (lever[i, s, 0] * fz - lever[i, s, 1] * fx)
        for a in range(4):
            DU[j + a] = 0.0
            for b in range(4):
                h = stiffness[i, a, b]
                r[j + a] -= h * v[j + b]
                for c in range(U.shape[1]):
                    DU[j + a, c] += (change[a, b] - h) * U[j + b, c]
        for a in range(6):
            worst = max(worst, abs(r[j + a]))
    return spread * worst / scale


@kernel
def soften(U: Array, DU: Array, r: Array) -> None:
    """Overwrite r (6 N,) by z of (I + D U U^T) z = r; DU (6 N, k). Nothing where contacts are no longer stiff enough."""
    M = np.dot(U.T, DU)
    for c in range(M.shape[0]):
        M[c, c] += 1.0
    if cholesky_lower(M):
        g = np.dot(r, U)
        triangular(M, g)
        r -= np.dot(DU, g)


@kernel
def flank_members(common: FlankCommon, members: FlankMembers, tolerance: float, states: FlankStates) -> None:
    """Solve specimens to a relative residual, `LANES` of them at a time, whose steps are one product of matrices; fills
    ``states``. Those not solved soon have the status ``ITERATIONS``."""
    size, k = common.soft.shape
    v, r, DU, before = np.empty((LANES, size)), np.zeros((LANES, size)), np.zeros((size, k)), np.empty(LANES)
    states.status[:], states.pull[:], states.p[:] = ITERATIONS, 0.0, common.centre
    for first in range(0, states.status.size, LANES):
        live = min(LANES, states.status.size - first)
        v[:], before[:] = 0.0, 1e300
        for _ in range(STEPS):
            going = 0
            for lane in range(live):
                m = first + lane
                if before[lane] < 0.0:  # has ended
                    continue
                residual = equations(common, members, m, states, v[lane], r[lane], DU)
                states.residual[m] = residual
                if residual <= tolerance:
                    states.status[m] = CONVERGED
                if residual <= tolerance or not residual <= LEFT * before[lane]:
                    before[lane], r[lane] = -1.0, 0.0
                    continue
                before[lane] = residual
                going += 1
                soften(common.soft, DU, r[lane])
                states.pull[m] -= r[lane]
            if going == 0:
                break
            v -= np.dot(r, common.reach)
