"""Forces and stiffness of bearing rollers, each divided into slices that are line contacts with the two raceways.

The rings are rigid. The approach of each slice follows either from the six motions of the bodies that carry the rings
(`add_roller_forces`) or, on an elastic shaft, from two motions of each ring at the roller
(`compute_roller_forces`): displacement along the contact normal at the roller's middle, and the slope
along the roller times the roller's length, both in metres. These motions are stored in the arrays of a ball, with the cone
(inner ring) in place of its flank SL and the cup (outer ring) in place of its flank NL.
"""

from math import exp, log, sqrt

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import Array, AxisRollers, RollerContacts

from .ball import FORCE, KN, KT, MX, MZ
from .contact import SETTLED

#: Positions in the arrays of a ball's four flanks at which the cone (inner ring) and cup (outer ring) of a roller are
#: stored.
CONE, CUP = 0, 2
#: A roller slice counts as unloaded if its approach is at most this fraction of the sum of the absolute values of the
#: terms of the approach, because the approach is then round-off.
ROUND_OFF = 2.0**-52


@kernel
def line_contact_law(delta: float, g: float, s: float) -> tuple[float, float, float]:
    """Return line load q [N/m], stiffness dq/d delta [N/m^2] and energy [J/m] of a line contact of approach delta > 0 [m].

    The law is delta = q (g - s ln q), with constants g and s [m^2/N] of roller and raceways. delta has a maximum as a
    function of q. Above exp(-3) times the load at this maximum, which is far above any real load, the law is continued
    along its tangent, so that the energy remains convex.
    """
    edge = exp(g / s - 4.0)
    limit = edge * (g - s * log(edge))
    rest = delta - limit
    delta = min(delta, limit)
    q = delta / g
    for _ in range(60):
        step = (q * (g - s * log(q)) - delta) / (g - s * (1.0 + log(q)))
        new = q - step
        if new <= 0.0:
            new = 0.5 * q
        change, q = abs(new - q), new
        if change <= SETTLED * q:
            break
    slope = 1.0 / (g - s * (1.0 + log(q)))
    energy = 0.5 * q * q * (g - s * (0.5 + log(q)))
    if rest > 0.0:
        energy += rest * (q + 0.5 * slope * rest)
        q += slope * rest
    return q, slope, energy


@kernel
def add_roller_forces(rollers: AxisRollers, q: Array, slices: Array, gradient: Array) -> tuple[float, float]:
    """Compute forces and stiffness of all roller slices between rigid rings; return energy [J] and largest slice force [N].

    q (r, 6): motions of the bodies that carry the rings [m, rad]. Writes force [N] and stiffness [N/m] of each slice to
    ``slices`` (M, 2) and adds the forces and moments on the bodies to the gradient (r, 6) of the energy [N, N m]. rollers:
    coefficients of the slices' approaches, their gaps, widths and force law.
    """
    energy, scale = 0.0, 0.0
    for i in range(rollers.gap.shape[0]):
        delta, terms = -rollers.gap[i], abs(rollers.gap[i])
        for end in range(2):
            row = rollers.ring_bodies[i, end]
            if row >= 0:
                for k in range(6):
                    moved = rollers.B[i, end, k] * q[row, k]
                    delta, terms = delta + moved, terms + abs(moved)
        slices[i, 0], slices[i, 1] = 0.0, 0.0
        if delta <= ROUND_OFF * terms:
            continue
        load, slope, stored = line_contact_law(delta, rollers.g[i], rollers.s[i])
        force = rollers.width[i] * load
        slices[i, 0], slices[i, 1] = force, rollers.width[i] * slope
        energy += rollers.width[i] * stored
        scale = max(scale, force)
        for end in range(2):
            row = rollers.ring_bodies[i, end]
            if row >= 0:
                for k in range(6):
                    gradient[row, k] += force * rollers.B[i, end, k]
    return energy, scale


@kernel
def compute_roller_forces(v: Array, rollers: RollerContacts, contact: Array, f: Array, tiny: float) -> tuple[float, float]:
    """Compute the forces of rollers between rings on an elastic shaft; return energy [J] and the largest roller force [N].

    v (M, 8): motions of cone (inner ring) and cup (outer ring) at each of M rollers [m], see the module. Writes the forces
    on the rings to f (M, 8) [N], and force and direction of each roller to ``contact`` (M, 4, 5), in the columns of a
    ball's contacts. The symmetric stiffness matrix of displacement and slope of one ring against the other has three
    different coefficients: force by displacement (in the column of the cone's normal stiffness), force by slope (cone's
    tangential stiffness), and moment by slope (cup's normal stiffness). A roller whose force is at most ``tiny`` [N] counts
    as unloaded.
    """
    energy, scale = 0.0, 0.0
    for i in range(v.shape[0]):
        contact[i, :, FORCE] = 0.0
        f[i, :] = 0.0
        approach, tilt = v[i, 2 * CONE] - v[i, 2 * CUP], v[i, 2 * CONE + 1] - v[i, 2 * CUP + 1]
        force, moment, kff, kfm, kmm, work = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(rollers.slice_positions.shape[1]):
            x, width = rollers.slice_positions[i, k], rollers.width[i, k]
            delta = approach + tilt * x - rollers.gap[i, k]
            if delta <= 0.0 or width == 0.0:
                continue
            load, slope, stored = line_contact_law(delta, rollers.g[i], rollers.s[i])
            force += width * load
            moment += width * load * x
            kff += width * slope
            kfm += width * slope * x
            kmm += width * slope * x * x
            work += width * stored
        if force <= tiny:
            continue
        energy += work
        scale = max(scale, force)
        size = sqrt(force * force + moment * moment)
        for flank, sign in ((CONE, -1.0), (CUP, 1.0)):
            contact[i, flank, FORCE] = size
            contact[i, flank, MX], contact[i, flank, MZ] = sign * force / size, sign * moment / size
            f[i, 2 * flank], f[i, 2 * flank + 1] = sign * force, sign * moment
        contact[i, CONE, KN], contact[i, CONE, KT], contact[i, CUP, KN] = kff, kfm, kmm
    return energy, scale


@kernel
def write_stiffness_factors_of_roller(contact: Array, rows: Array) -> int:
    """Write factors S of a roller's stiffness S^T S against the eight motions of its rings; return the number of rows of S.

    contact (4, 5): stiffness of the roller, from `compute_roller_forces`. Writes S to ``rows`` (6, 8), of
    which at most two rows are used; the number is 0 for a roller without force.
    """
    if contact[CONE, FORCE] <= 0.0:
        return 0
    root = sqrt(contact[CONE, KN])
    side = contact[CONE, KT] / root
    rest = sqrt(max(0.0, contact[CUP, KN] - side * side))
    rows[:2, :] = 0.0
    for flank, sign in ((CONE, 1.0), (CUP, -1.0)):
        rows[0, 2 * flank], rows[0, 2 * flank + 1] = sign * root, sign * side
        rows[1, 2 * flank + 1] = sign * rest
    return 2
