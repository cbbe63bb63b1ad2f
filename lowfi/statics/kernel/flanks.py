"""Many specimens of one screw on the motions of its flanks alone, each with its own lever arms, and balls of any contacts.

As in ``press``, with K the stiffness of beam and contacts in the common start, forces y on the flanks move them by P y, P =
R K^-1 R^T, and r = y - H (v - v_0) + f(v) - f_0 = 0 is solved. Here R has three rows a flank: its motion in the ball's
section and its turn about the track. A groove's centre that lies c beside that of the start moves by c times that turn
more, and its force has that moment more.

A step is Newton's on the screw's soft modes U, P ~ U U^T, which the contacts alone hold, and by P beyond them, where the
beam is much stiffer than the contacts: with D the change of the contacts' stiffness since the start, (I + D U U^T) z = r
and y - z. Balls go along with their flanks. So the error falls by the product of two small numbers, and the residual is
that of the specimen's own equations.

Specimens go side by side: arrays are flat, by rows of ``LANES`` specimens, and the places of a ball's rows are constants,
by which the compiler knows that they do not overlap and computes several specimens at a time.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.records import Array, BeamOptions, FlankCommon, FlankMembers, PairStates

from .contact import arc
from .newton import CONVERGED, ITERATIONS

#: Specimens side by side, most steps, and the share of the residual that a step has to leave at most.
LANES, STEPS, LEFT = 16, 12, 0.9
#: Places of a ball's rows: arcs (w, its size, approach, 1 / Hertz constant; four flanks), lever arms (x3, z3; two flanks),
#: motions (6) from the start and forces (6), the centre (2) and its motion by the flanks (2, 4), contact forces (4); how
#: many there are, and rows of a ball's change of stiffness, a triangle of (4, 4).
ARC, LEVER, MOVED, PULL, CENTRE, FOLLOWS, LOAD, ROWS, CHANGES = 0, 20, 24, 30, 36, 38, 46, 50, 10
#: Rows of what is largest: force, and residual.
SCALE, WORST = 0, 1
#: Distance [m] of flanks that take no part.
FAR = 1.0
#: Share of the stiffness that is added to it, as in ``ball.newton_step``.
BUMP = 1e-14


@kernel
def press_arc(
    ux: float, uz: float, wx: float, wz: float, size: float, approach: float, softness: float
) -> tuple[float, float, float, float, float, float]:
    """Contact force on one arc, its components, and its stiffness (xx, xz, zz), of the ball at (ux, uz) from its nominal
    place; softness: 1 / Hertz constant."""
    delta, mx, mz, turn = arc(ux, uz, wx, wz, size, approach)
    x = delta * softness if delta > 0.0 else 0.0
    root = sqrt(x)
    force, kn = x * root, 1.5 * root * softness
    kt = force * turn
    return force, force * mx, force * mz, kn * mx * mx + kt * mz * mz, (kn - kt) * mx * mz, kn * mz * mz + kt * mx * mx


@kernel
def meet_flanks(common: FlankCommon, i: int, a: Array, d: Array, step: Array, z: Array, worst: Array) -> None:
    """Take the step and the correction z (6 rows) of ball i's flanks, and fill z with its equations there and d with its
    change of stiffness; its rows a: see ``ARC``; worst: see ``SCALE``."""
    n, h, f, q, tiny, spread = LANES, common.stiffness[i], common.force[i], common.motion[i], common.tiny, common.spread
    q0, q1, q2, q3, q4, q5, f0, f1, f2, f3 = q[0], q[1], q[2], q[3], q[4], q[5], f[0], f[1], f[2], f[3]
    h00, h01, h02, h03, h11, h12 = h[0, 0], h[0, 1], h[0, 2], h[0, 3], h[1, 1], h[1, 2]
    h13, h22, h23, h33 = h[1, 3], h[2, 2], h[2, 3], h[3, 3]
    for m in range(n):
        cx, cz, ex, ez = a[LEVER * n + m], a[(LEVER + 1) * n + m], a[(LEVER + 2) * n + m], a[(LEVER + 3) * n + m]
        s0, s1, s2, s3, s4, s5 = step[m], step[n + m], step[2 * n + m], step[3 * n + m], step[4 * n + m], step[5 * n + m]
        v0, v1, v2 = a[MOVED * n + m] - s0, a[(MOVED + 1) * n + m] - s1, a[(MOVED + 2) * n + m] - s2
        v3, v4, v5 = a[(MOVED + 3) * n + m] - s3, a[(MOVED + 4) * n + m] - s4, a[(MOVED + 5) * n + m] - s5
        a[MOVED * n + m], a[(MOVED + 1) * n + m], a[(MOVED + 2) * n + m] = v0, v1, v2
        a[(MOVED + 3) * n + m], a[(MOVED + 4) * n + m], a[(MOVED + 5) * n + m] = v3, v4, v5
        s0, s1, s2, s3 = s0 - cz * s4, s1 + cx * s4, s2 - ez * s5, s3 + ex * s5
        o = FOLLOWS * n + m
        x = a[CENTRE * n + m] - (a[o] * s0 + a[o + n] * s1 + a[o + 2 * n] * s2 + a[o + 3 * n] * s3)
        o += 4 * n
        y = a[(CENTRE + 1) * n + m] - (a[o] * s0 + a[o + n] * s1 + a[o + 2 * n] * s2 + a[o + 3 * n] * s3)
        ux, uz = x - (q0 + v0 - cz * (q4 + v4)), y - (q1 + v1 + cx * (q4 + v4))
        wx, wz = x - (q2 + v2 - ez * (q5 + v5)), y - (q3 + v3 + ex * (q5 + v5))
        o = ARC * n + m
        p, pf, pg, pxx, pxz, pzz = press_arc(ux, uz, a[o], a[o + n], a[o + 2 * n], a[o + 3 * n], a[o + 4 * n])
        o += 5 * n
        r, rf, rg, rxx, rxz, rzz = press_arc(wx, wz, a[o], a[o + n], a[o + 2 * n], a[o + 3 * n], a[o + 4 * n])
        o += 5 * n
        t, tf, tg, txx, txz, tzz = press_arc(x, y, a[o], a[o + n], a[o + 2 * n], a[o + 3 * n], a[o + 4 * n])
        o += 5 * n
        u, uf, ug, uxx, uxz, uzz = press_arc(x, y, a[o], a[o + n], a[o + 2 * n], a[o + 3 * n], a[o + 4 * n])
        largest = max(max(p, r), max(t, u))
        on = 1.0 if largest > tiny else 0.0
        gx, gz = on * (pf + rf + tf + uf), on * (pg + rg + tg + ug)
        xx, xz, zz = pxx + rxx + txx + uxx, pxz + rxz + txz + uxz, pzz + rzz + tzz + uzz
        bump = BUMP * (xx + zz)
        xx, zz = xx + bump, zz + bump
        det = xx * zz - xz * xz
        inverse = on / det if det > 0.0 else 0.0
        xx, xz, zz = zz * inverse, -xz * inverse, xx * inverse
        dx, dz = -(xx * gx + xz * gz), -(xz * gx + zz * gz)
        a[CENTRE * n + m], a[(CENTRE + 1) * n + m] = x + dx, y + dz
        a[LOAD * n + m], a[(LOAD + 1) * n + m] = on * p, on * r
        a[(LOAD + 2) * n + m], a[(LOAD + 3) * n + m] = on * t, on * u
        k00, k01, k02, k03 = xx * pxx + xz * pxz, xx * pxz + xz * pzz, xx * rxx + xz * rxz, xx * rxz + xz * rzz
        k10, k11, k12, k13 = xz * pxx + zz * pxz, xz * pxz + zz * pzz, xz * rxx + zz * rxz, xz * rxz + zz * rzz
        o = FOLLOWS * n + m
        a[o], a[o + n], a[o + 2 * n], a[o + 3 * n] = k00, k01, k02, k03
        o += 4 * n
        a[o], a[o + n], a[o + 2 * n], a[o + 3 * n] = k10, k11, k12, k13
        d[m], d[n + m] = pxx - (pxx * k00 + pxz * k10) - h00, pxz - (pxx * k01 + pxz * k11) - h01
        d[2 * n + m], d[3 * n + m] = -(pxx * k02 + pxz * k12) - h02, -(pxx * k03 + pxz * k13) - h03
        d[4 * n + m], d[5 * n + m] = pzz - (pxz * k01 + pzz * k11) - h11, -(pxz * k02 + pzz * k12) - h12
        d[6 * n + m], d[7 * n + m] = -(pxz * k03 + pzz * k13) - h13, rxx - (rxx * k02 + rxz * k12) - h22
        d[8 * n + m], d[9 * n + m] = rxz - (rxx * k03 + rxz * k13) - h23, rzz - (rxz * k03 + rzz * k13) - h33
        pf, pg, rf, rg = (
            pf + pxx * dx + pxz * dz,
            pg + pxz * dx + pzz * dz,
            rf + rxx * dx + rxz * dz,
            rg + rxz * dx + rzz * dz,
        )
        pf, pg, rf, rg = on * pf, on * pg, on * rf, on * rg
        o = PULL * n + m
        y0, y1, y2 = a[o] - z[m], a[o + n] - z[n + m], a[o + 2 * n] - z[2 * n + m]
        y3, y4, y5 = a[o + 3 * n] - z[3 * n + m], a[o + 4 * n] - z[4 * n + m], a[o + 5 * n] - z[5 * n + m]
        a[o], a[o + n], a[o + 2 * n], a[o + 3 * n], a[o + 4 * n], a[o + 5 * n] = y0, y1, y2, y3, y4, y5
        y0 -= pf - f0 + (h00 * v0 + h01 * v1 + h02 * v2 + h03 * v3)
        y1 -= pg - f1 + (h01 * v0 + h11 * v1 + h12 * v2 + h13 * v3)
        y2 -= rf - f2 + (h02 * v0 + h12 * v1 + h22 * v2 + h23 * v3)
        y3 -= rg - f3 + (h03 * v0 + h13 * v1 + h23 * v2 + h33 * v3)
        y4 -= cx * pg - cz * pf
        y5 -= ex * rg - ez * rf
        z[m], z[n + m], z[2 * n + m], z[3 * n + m], z[4 * n + m], z[5 * n + m] = y0, y1, y2, y3, y4, y5
        most = max(max(max(abs(y0), abs(y1)), max(abs(y2), abs(y3))), max(abs(y4), abs(y5)))
        worst[SCALE * n + m] = max(worst[SCALE * n + m], largest)
        worst[WORST * n + m] = max(worst[WORST * n + m], max(spread * most, sqrt(gx * gx + gz * gz)))


@kernel
def soft_solution(M: Array, g: Array) -> None:
    """Overwrite g (k, `LANES`) by the solutions of I + M, triangles of symmetric matrices row by row, which are lost."""
    k = g.shape[0]
    for j in range(k):
        pivot = M[j * (j + 3) // 2]
        for m in range(LANES):
            pivot[m] = 1.0 / (1.0 + pivot[m])
        for i in range(j + 1, k):
            at = M[i * (i + 1) // 2 + j]
            for m in range(LANES):
                g[i, m] -= at[m] * pivot[m] * g[j, m]
            for e in range(j + 1, i + 1):
                to, other = M[i * (i + 1) // 2 + e], M[e * (e + 1) // 2 + j]
                for m in range(LANES):
                    to[m] -= at[m] * pivot[m] * other[m]
    for j in range(k - 1, -1, -1):
        for i in range(j + 1, k):
            at = M[i * (i + 1) // 2 + j]
            for m in range(LANES):
                g[j, m] -= at[m] * g[i, m]
        pivot = M[j * (j + 3) // 2]
        for m in range(LANES):
            g[j, m] *= pivot[m]


@kernel
def soften(d: Array, w: Array, z: Array) -> None:
    """Take from the forces z of a ball what its change of stiffness d makes of the motions w."""
    n = LANES
    for m in range(n):
        w0, w1, w2, w3 = w[m], w[n + m], w[2 * n + m], w[3 * n + m]
        d1, d2, d3 = d[n + m], d[2 * n + m], d[3 * n + m]
        d5, d6, d8 = d[5 * n + m], d[6 * n + m], d[8 * n + m]
        z[m] -= d[m] * w0 + d1 * w1 + d2 * w2 + d3 * w3
        z[n + m] -= d1 * w0 + d[4 * n + m] * w1 + d5 * w2 + d6 * w3
        z[2 * n + m] -= d2 * w0 + d5 * w1 + d[7 * n + m] * w2 + d8 * w3
        z[3 * n + m] -= d3 * w0 + d6 * w1 + d8 * w2 + d[9 * n + m] * w3


@kernel
def place(common: FlankCommon, members: FlankMembers, first: int, work: Array) -> None:
    """Fill the rows of all balls of the specimens from ``first`` on, those beyond the last one as it; at rest."""
    n, last = LANES, members.offset.shape[0] - 1
    for i in range(common.centre.shape[0]):
        a = work[ROWS * n * i : ROWS * n * (i + 1)]
        a[:] = 0.0
        for m in range(n):
            own = min(first + m, last)
            for s in range(4):
                o, row = (ARC + 5 * s) * n + m, members.offset[own, i, s]
                a[o], a[o + n], a[o + 2 * n] = row[0], row[1], row[2]
                a[o + 3 * n] = row[3] if common.use[s] else -FAR
                a[o + 4 * n] = 1.0 / members.C[own, i, s]
            o, lever = LEVER * n + m, members.lever[own, i]
            a[o], a[o + n], a[o + 2 * n], a[o + 3 * n] = lever[0, 0], lever[0, 1], lever[1, 0], lever[1, 1]
            a[CENTRE * n + m], a[(CENTRE + 1) * n + m] = common.centre[i, 0], common.centre[i, 1]


@kernel
def keep(work: Array, lane: int, m: int, found: PairStates) -> None:
    """Forces and places of the specimen in a lane, its number m."""
    n = LANES
    for i in range(found.p.shape[1]):
        o = ROWS * n * i + lane
        found.p[m, i, 0], found.p[m, i, 1] = work[o + CENTRE * n], work[o + (CENTRE + 1) * n]
        for s in range(4):
            found.force[m, i, s] = work[o + (LOAD + s) * n]
        for e in range(6):
            found.pull[m, 6 * i + e] = work[o + (PULL + e) * n]


@kernel
def flank_members(common: FlankCommon, options: BeamOptions, members: FlankMembers, found: PairStates) -> None:
    """Solve specimens; fills ``found``. Those not solved soon have the status ``ITERATIONS``."""
    count, n, (size, k) = common.centre.shape[0], LANES, common.soft.shape
    work, worst, before = np.empty(ROWS * n * count), np.empty(2 * n), np.empty(n)
    z, step, w, change = np.empty((size, n)), np.empty((size, n)), np.empty((size, n)), np.empty((CHANGES * count, n))
    M, g, forces, steps = np.empty((common.bent.shape[0], n)), np.empty((k, n)), z.ravel(), step.ravel()
    softs, changes = w.ravel(), change.ravel()
    for first in range(0, members.offset.shape[0], n):
        place(common, members, first, work)
        live = min(n, members.offset.shape[0] - first)
        z[:], step[:], before[:], left = 0.0, 0.0, 1e300, live
        found.status[first : first + live] = ITERATIONS
        for _ in range(STEPS):
            worst[:n], worst[n:] = options.floor, 0.0
            for i in range(count):
                rows, six = work[ROWS * n * i : ROWS * n * (i + 1)], slice(6 * n * i, 6 * n * (i + 1))
                ten = slice(CHANGES * n * i, CHANGES * n * (i + 1))
                meet_flanks(common, i, rows, changes[ten], steps[six], forces[six], worst)
            for lane in range(live):
                m, residual = first + lane, worst[n + lane] / worst[lane]
                if before[lane] < 0.0:  # has ended
                    continue
                found.residual[m] = residual
                if residual <= options.tolerance:
                    found.status[m] = CONVERGED
                    keep(work, lane, m, found)
                going = residual > options.tolerance and residual <= LEFT * before[lane]
                before[lane] = residual if going else -1.0
                left -= 0 if going else 1
            if left == 0:
                break
            np.dot(common.bent, change, M)
            np.dot(common.soft.T, z, g)
            soft_solution(M, g)
            np.dot(common.soft, g, w)
            for i in range(count):
                six, ten = slice(6 * n * i, 6 * n * (i + 1)), slice(CHANGES * n * i, CHANGES * n * (i + 1))
                soften(changes[ten], softs[six], forces[six])
            np.dot(common.reach, z, step)
