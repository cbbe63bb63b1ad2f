"""Many specimens of one screw whose balls are held by one diagonal pair each: solved on the motions of the flanks alone.

With K the stiffness of beam and contacts in the common start, B the flanks' motion by that of the nodes, and H, f_0 the
contacts' stiffness and forces there, every motion that forces on the flanks cause is K^-1 B^T y. The equations of a
specimen then are r = y - H (v - v_0) + f(v) - f_0 = 0 with v = v_0 + P y and P = B K^-1 B^T, which is kept; y - r is a
better y, because f changes by nearly H (v - v_0). The error falls by the change of the stiffness, some per cent, at each
step, and the residual is that of the specimen's own equations. The product with P is quadratic in the number of balls.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.records import Array, BeamOptions, PairCommon, PairMembers, PairStates

from .ball import APPROACH, SIZE, WX, WZ
from .members import CHORDS, LEFT
from .newton import CONVERGED, ITERATIONS
from .pair import stand, stretched


@kernel
def moved_by(reach: Array, r: Array, v: Array) -> None:
    """Take reach r from v: reach (k, k) symmetric, k even."""
    k = v.size
    for j in range(0, k, 2):
        a, b = r[j], r[j + 1]
        one, two = reach[j], reach[j + 1]
        for i in range(k):
            v[i] -= a * one[i] + b * two[i]


@kernel
def press_members(common: PairCommon, options: BeamOptions, tiny: float, members: PairMembers, found: PairStates) -> None:
    """Solve specimens by the pair's closed form; fills ``found``. Those not solved soon have the status ``ITERATIONS``."""
    side, reach = common.side, common.reach
    offset, closure, C = members
    other, count = 3 - side, offset.shape[1]
    v, y, r = np.empty(2 * count), np.empty(2 * count), np.empty(2 * count)
    lines, own = np.empty((count, 3)), np.empty((count, 2))
    for m in range(offset.shape[0]):
        for i in range(count):
            a, b = offset[m, i, side], offset[m, i, other]
            dx, dz = b[WX] - a[WX], b[WZ] - a[WZ]
            lines[i, 0], lines[i, 1], lines[i, 2] = dx, dz, sqrt(dx * dx + dz * dz)
            own[i, 0], own[i, 1] = closure[m, i, side], 1.0 / (C[m, i, side] + C[m, i, other])
            for k in range(2):
                v[2 * i + k], y[2 * i + k] = common.motion[i, k], 0.0
        status, residual, before, last = ITERATIONS, 0.0, 1e300, 1e300
        for _ in range(CHORDS):
            worst, scale = 0.0, options.floor
            for i in range(count):
                vx, vz = v[2 * i], v[2 * i + 1]
                nx, nz, _, change = stretched((lines[i, 0], lines[i, 1], lines[i, 2]), vx, vz)
                part = max(0.0, (own[i, 0] + change) * own[i, 1])
                force = part * sqrt(part)
                if force <= tiny:
                    force = 0.0
                vx -= common.motion[i, 0]
                vz -= common.motion[i, 1]
                h = common.stiffness[i]
                x = y[2 * i] + force * nx - common.force[i, 0] - (h[0, 0] * vx + h[0, 1] * vz)
                z = y[2 * i + 1] + force * nz - common.force[i, 1] - (h[1, 0] * vx + h[1, 1] * vz)
                r[2 * i], r[2 * i + 1] = x, z
                scale = max(scale, force)
                worst = max(worst, abs(x), abs(z))
            residual = worst * common.spread / scale
            if residual <= options.tolerance:
                status = CONVERGED
                break
            if not residual <= LEFT * before:
                break
            before, last = last, residual
            for i in range(2 * count):
                y[i] -= r[i]
            moved_by(reach, r, v)
        found.status[m], found.residual[m] = status, residual
        found.pull[m] = y
        for i in range(count):
            b = offset[m, i, other]
            line, moved = (lines[i, 0], lines[i, 1], lines[i, 2]), (v[2 * i], v[2 * i + 1])
            now = stretched(line, moved[0], moved[1])
            part = (own[i, 0] + now[3]) * own[i, 1]
            more = part * C[m, i, other] - b[APPROACH]
            found.p[m, i, 0], found.p[m, i, 1] = stand(line, moved, now, (b[WX], b[WZ], b[SIZE]), more)
            force = max(0.0, part) * sqrt(max(0.0, part))
            for s in range(4):
                found.force[m, i, s] = force if force > tiny and s in (side, other) else 0.0
