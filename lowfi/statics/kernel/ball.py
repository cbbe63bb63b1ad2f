"""Equilibrium of one ball between the groove flanks of screw and nut, with up to four contacts.

The unknowns are the position of the ball's centre in its section plane (x3: radial, z3: along the helix's binormal) and,
for an elastic ball, one amplitude of the deformation of its body. They minimise the contact energy at given motions of the
flanks.

The functions use arrays with one row for each flank, in the order SL, SR, NL, NR (screw left, screw right, nut left, nut
right):

geometry (4, 9)
    Nominal vector w = (x3, z3) from the groove's centre to the ball's centre and its length |w| [m], nominal approach [m],
    Hertz constant C [m/N^(2/3)], 1 if the flank can carry load or 0, groove radius [m], signs s_x and s_z of the contact
    direction.
contact (4, 5)
    Force F [N], unit normal m from ball to groove, normal stiffness F' = dF/d delta [N/m], and tangential stiffness F kt
    [N/m] by the curvature of the flank.
local (4, 3), or (0, 3) for a ball that is rigid apart from its contacts
    e [m/N] of ``contact_law``, decrease of the approach by a unit amplitude of the ball's deformation, and h [m/N^(4/3)] of
    ``contact_law``.
"""

from math import sqrt

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import Array

from .contact import approach_to_arc, approach_to_profile, contact_law, hertz_law

#: Columns of the array ``geometry``, see the description of this module.
WX, WZ, SIZE, APPROACH, HERTZ, USE, RADIUS, SX, SZ = range(9)
#: Columns of the array ``contact``: force, unit normal (x, z), normal and tangential stiffness.
FORCE, MX, MZ, KN, KT = range(5)
#: Columns of the array ``local``: e, decrease of the approach by the ball's deformation, h.
LINEAR, BODY, HIGHER = range(3)
#: Largest number of Newton steps to find a ball's equilibrium, and largest number of times that one step is halved.
SETTLING, HALVINGS = 60, 30


@kernel
def guess_ball_centre(p: Array, shift: Array, geometry: Array, closure: Array) -> int:
    """Write a first guess of the ball's centre p (2,) [m] for Newton's method; return the number of flank pairs used.

    p is the displacement from the nominal position of the centre. A diagonal pair is two opposite flanks a, b of screw and
    nut. The guess is the mean of the two-contact solutions of all pairs with interference, or the mean motion of the flanks
    if there is none. If only one pair can carry load, it is used even with clearance. With D from the groove centre of b to
    that of a, and the motions v_a, v_b of both flanks, the interference is its nominal value in ``closure`` (2,) [m] plus
    |D + v_a - v_b| - |D|. The contacts share it in the ratio of their Hertz constants, which is exact for circular flanks.
    shift (4, 2): motions of the flanks [m]; geometry (4, 9): contact data, see the module.
    """
    count = 0
    x, z = 0.0, 0.0
    for a in range(2):
        b = 3 - a
        if geometry[a, USE] == 0.0 or geometry[b, USE] == 0.0:
            continue
        # D = o_a - o_b, from the nominal w of both flanks, and its change v_a - v_b
        dx, dz = geometry[b, WX] - geometry[a, WX], geometry[b, WZ] - geometry[a, WZ]
        vx, vz = shift[a, 0] - shift[b, 0], shift[a, 1] - shift[b, 1]
        dist0 = sqrt(dx * dx + dz * dz)
        dist = sqrt((dx + vx) * (dx + vx) + (dz + vz) * (dz + vz))
        if dist <= 1e-30 or dist0 <= 1e-30:
            continue
        change = (vx * (2.0 * dx + vx) + vz * (2.0 * dz + vz)) / (dist + dist0)  # |D + v| - |D| without cancellation
        total, alone = closure[a] + change, geometry[1 - a, USE] == 0.0 and geometry[2 + a, USE] == 0.0
        if total > 0.0 or alone:
            # The ball's centre lies on the line D + v, at the distance from b's groove centre that gives b its share of the
            # interference. The rotation of that line is (v - D/|D| change)/|D + v|, without subtracting unit vectors.
            nx, nz = dx / dist0, dz / dist0
            share = geometry[b, HERTZ] / (geometry[a, HERTZ] + geometry[b, HERTZ])
            added, size = total * share - geometry[b, APPROACH], geometry[b, SIZE]
            x += shift[b, 0] + ((dx + vx) * added + (vx - nx * change) * size) / dist + (nx * size - geometry[b, WX])
            z += shift[b, 1] + ((dz + vz) * added + (vz - nz * change) * size) / dist + (nz * size - geometry[b, WZ])
            count += 1
    if count > 0:
        p[0], p[1] = x / count, z / count
        return count
    n = 0
    for s in range(4):
        if geometry[s, USE] != 0.0:
            x += shift[s, 0]
            z += shift[s, 1]
            n += 1
    p[0], p[1] = x / max(n, 1), z / max(n, 1)
    return 0


@kernel
def approach_to_flank(
    ux: float, uz: float, geometry: Array, r_ball: float, profile: Array
) -> tuple[float, float, float, float]:
    """Return the approach [m], unit normal (x, z) and curvature term kt [1/m] of a ball's contact with one groove flank.

    (ux, uz): displacement of the ball's centre from its nominal position relative to the flank [m]; geometry (9,): contact
    data of the flank, see the module; r_ball: ball radius [m]; profile: coefficients of the flank's deviation from a
    circular arc, empty for an exact arc. A contact with the force F has the tangential stiffness F kt.
    """
    if profile.shape[0] == 0:
        return approach_to_arc(ux, uz, geometry[WX], geometry[WZ], geometry[SIZE], geometry[APPROACH])
    return approach_to_profile(
        ux, uz, geometry[WX], geometry[WZ], r_ball, geometry[RADIUS], profile, geometry[SX], geometry[SZ]
    )


@kernel
def ball_contact_forces(
    x: float, z: float, y: float, shift: Array, geometry: Array, local: Array, r_ball: float, profile: Array, contact: Array
) -> float:
    """Compute forces and stiffnesses of a ball's four contacts, for its centre displaced by (x, z) [m] and deformed by y.

    y is the amplitude of the ball's deformation. Writes force, normal and stiffness to ``contact`` (4, 5) and returns the
    contact energy [J]: the integral of Hertz's law, equation 2.14 of Lin's thesis. shift (4, 2): motions of the flanks [m];
    geometry (4, 9), local (4, 3): contact data and compliance terms, see the module; r_ball: ball radius [m]; profile
    (4, d): deviations of the flanks from circular arcs.
    """
    if profile.shape[1] > 0 or local.shape[0] > 0:
        return general_ball_contact_forces(x, z, y, shift, geometry, local, r_ball, profile, contact)
    energy = 0.0  # a separate loop for circular flanks, without views of rows, so that the compiler inlines it
    for s in range(4):
        contact[s, FORCE] = 0.0
        if geometry[s, USE] != 0.0:
            wx, wz, size, approach = geometry[s, WX], geometry[s, WZ], geometry[s, SIZE], geometry[s, APPROACH]
            mx, mz = x - shift[s, 0], z - shift[s, 1]
            delta, contact[s, MX], contact[s, MZ], kt = approach_to_arc(mx, mz, wx, wz, size, approach)
            if delta > 0.0:
                force, slope, work = hertz_law(delta, geometry[s, HERTZ])
                contact[s, FORCE], contact[s, KN], contact[s, KT] = force, slope, force * kt
                energy += work
    return energy


@kernel
def general_ball_contact_forces(
    x: float, z: float, y: float, shift: Array, geometry: Array, local: Array, r_ball: float, profile: Array, contact: Array
) -> float:
    """Compute contact forces and energy of a ball, also for non-circular flanks and for an elastic ball.

    (x, z): displacement of the ball's centre, radial and along the helix's binormal [m]; y: amplitude of its deformation;
    shift (4, 2): motions of the flanks [m]; geometry (4, 9): contact data; local (4, 3): compliance terms of the contacts,
    empty for a rigid ball; r_ball: ball radius [m]; profile (4, d): deviations of the flanks from circular arcs. Writes the
    contacts to ``contact`` (4, 5) and returns the energy [J]. The arrays are described in the module.
    """
    energy = 0.5 * y * y  # energy of the ball's deformation; its amplitude is scaled to a stiffness of one
    for s in range(4):
        contact[s, FORCE] = 0.0
        if geometry[s, USE] == 0.0:
            continue
        met = approach_to_flank(x - shift[s, 0], z - shift[s, 1], geometry[s], r_ball, profile[s])
        delta, contact[s, MX], contact[s, MZ], kt = met
        e, h = 0.0, 0.0
        if local.shape[0] > 0:
            e, h = local[s, LINEAR], local[s, HIGHER]
            delta -= local[s, BODY] * y
        if delta > 0.0:
            force, slope, work = contact_law(delta, geometry[s, HERTZ], e, h)
            contact[s, FORCE], contact[s, KN], contact[s, KT] = force, slope, force * kt
            energy += work
    return energy


@kernel
def net_and_largest_contact_force(contact: Array) -> tuple[float, float]:
    """Return the magnitude of the net force on the ball and the largest of its contact forces [N].

    contact (4, 5): force, unit normal (x, z), and two stiffnesses of each contact.
    """
    gx, gz, scale = 0.0, 0.0, 0.0
    for s in range(4):
        f = contact[s, FORCE]
        if f > 0.0:
            gx += f * contact[s, MX]
            gz += f * contact[s, MZ]
            scale = max(scale, f)
    return sqrt(gx * gx + gz * gz), scale


@kernel
def unbalanced_deformation_force(y: float, contact: Array, local: Array) -> float:
    """Return the force [N] by which the contact forces and the ball's deformation of amplitude y are out of balance.

    contact (4, 5): forces and stiffnesses of the contacts; local (4, 3): compliance terms of the contacts.
    """
    net, reach = y, 0.0
    for s in range(4):
        reach = max(reach, abs(local[s, BODY]))
        net -= max(contact[s, FORCE], 0.0) * local[s, BODY]
    return abs(net) / reach if reach > 0.0 else 0.0


@kernel
def newton_step_of_ball(y: float, contact: Array, local: Array) -> tuple[float, float, float, float]:
    """Return the Newton step of a ball's centre (x, z) and deformation (y), and the derivative of the energy along it [J].

    y: amplitude of the deformation before the step; contact (4, 5), local (4, 3): forces and compliance terms of the
    contacts, see the module. For a rigid ball whose stiffness matrix is singular, the step follows the gradient; all four
    values are zero if no contact carries load.
    """
    gx, gz, hxx, hxz, hzz = 0.0, 0.0, 0.0, 0.0, 0.0
    gy, hxy, hzy, hyy = y, 0.0, 0.0, 1.0
    for s in range(4):
        f = contact[s, FORCE]
        if f > 0.0:
            mx, mz, kn, kt = contact[s, MX], contact[s, MZ], contact[s, KN], contact[s, KT]
            gx += f * mx
            gz += f * mz
            # block centre-centre: F' m m^T + F kt t t^T, as in `block`
            hxx += kn * mx * mx + kt * mz * mz
            hzz += kn * mz * mz + kt * mx * mx
            hxz += (kn - kt) * mx * mz
            if local.shape[0] > 0:
                g = local[s, BODY]
                gy -= f * g
                # blocks centre-amplitude and amplitude-amplitude: the approach is m . w - g y
                hxy -= kn * mx * g
                hzy -= kn * mz * g
                hyy += kn * g * g
    bump = 1e-14 * (hxx + hzz)  # a ball with one contact has no stiffness tangential to it
    hxx += bump
    hzz += bump
    if local.shape[0] > 0:
        return newton_step_of_elastic_ball(gx, gz, gy, hxx, hxz, hzz, hxy, hzy, hyy)
    det = hxx * hzz - hxz * hxz
    if det <= 0.0:
        stiff = hxx + hzz
        if stiff <= 0.0:
            return 0.0, 0.0, 0.0, 0.0
        return -gx / stiff, -gz / stiff, 0.0, -(gx * gx + gz * gz) / stiff
    sx, sz = -(hzz * gx - hxz * gz) / det, -(hxx * gz - hxz * gx) / det
    return sx, sz, 0.0, gx * sx + gz * sz


@kernel
def newton_step_of_elastic_ball(
    gx: float, gz: float, gy: float, hxx: float, hxz: float, hzz: float, hxy: float, hzy: float, hyy: float
) -> tuple[float, float, float, float]:
    """Return the Newton step of an elastic ball's centre (x, z) and deformation (y), and the energy's derivative along it.

    The step is computed by Cholesky's method from the gradient (gx, gz, gy) of the contact energy and the coefficients hxx,
    hxz, ... of its Hessian. Returns zeros if the Hessian is not positive definite.
    """
    # L L^T of the Hessian in the order (x, z, y)
    if hxx <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    lxx = sqrt(hxx)
    lxz, lxy = hxz / lxx, hxy / lxx
    left = hzz - lxz * lxz
    if left <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    lzz = sqrt(left)
    lzy = (hzy - lxy * lxz) / lzz
    left = hyy - lxy * lxy - lzy * lzy
    if left <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    lyy = sqrt(left)
    # forward and backward substitution of -gradient
    sx = -gx / lxx
    sz = (-gz - lxz * sx) / lzz
    sy = (-gy - lxy * sx - lzy * sz) / lyy / lyy
    sz = (sz - lzy * sy) / lzz
    sx = (sx - lxz * sz - lxy * sy) / lxx
    return sx, sz, sy, sx * gx + sz * gz + sy * gy


@kernel
def interference_with_flank_pair(a: int, shift: Array, geometry: Array, closure: Array) -> float:
    """Return the interference [m] of a ball between two opposite flanks, numbers a and 3 - a; negative for clearance.

    shift (4, 2): motions of the flanks [m]; geometry (4, 9): contact data, see the module; closure (2,): nominal
    interference of the two pairs [m]. The result follows from the distance of the groove centres. Returns -1 if one of the
    flanks cannot carry load.
    """
    b = 3 - a
    if geometry[a, USE] == 0.0 or geometry[b, USE] == 0.0:
        return -1.0
    dx, dz = geometry[b, WX] - geometry[a, WX], geometry[b, WZ] - geometry[a, WZ]
    vx, vz = shift[a, 0] - shift[b, 0], shift[a, 1] - shift[b, 1]
    dist0, dist = sqrt(dx * dx + dz * dz), sqrt((dx + vx) * (dx + vx) + (dz + vz) * (dz + vz))
    if dist <= 1e-30 or dist0 <= 1e-30:
        return -1.0
    total: float = closure[a] + (vx * (2.0 * dx + vx) + vz * (2.0 * dz + vz)) / (dist + dist0)
    return total


@kernel
def solve_opposite_flank_pair(a: int, total: float, p: Array, shift: Array, geometry: Array, contact: Array) -> float:
    """Solve a ball that touches only two opposite circular flanks, with the numbers a and b = 3 - a, in closed form.

    total: interference of the ball between the two flanks [m]; shift (4, 2): motions of the flanks [m];
    geometry (4, 9): contact data, see the module. The forces are equal and opposite, so the contacts share the interference
    in the ratio of their Hertz constants, and the ball's centre lies on the line through the groove centres. Writes the
    centre p (2,) [m] and the contacts (4, 5). Returns the energy [J], or -1 if a third flank would touch the ball.
    """
    b = 3 - a
    C_pair = geometry[a, HERTZ] + geometry[b, HERTZ]
    dx, dz = geometry[b, WX] - geometry[a, WX], geometry[b, WZ] - geometry[a, WZ]
    vx, vz = shift[a, 0] - shift[b, 0], shift[a, 1] - shift[b, 1]
    dist0, dist = sqrt(dx * dx + dz * dz), sqrt((dx + vx) * (dx + vx) + (dz + vz) * (dz + vz))
    nx, nz = dx / dist0, dz / dist0
    change = (vx * (2.0 * dx + vx) + vz * (2.0 * dz + vz)) / (dist + dist0)
    added, size = total * geometry[b, HERTZ] / C_pair - geometry[b, APPROACH], geometry[b, SIZE]
    p[0] = shift[b, 0] + ((dx + vx) * added + (vx - nx * change) * size) / dist + (nx * size - geometry[b, WX])
    p[1] = shift[b, 1] + ((dz + vz) * added + (vz - nz * change) * size) / dist + (nz * size - geometry[b, WZ])
    force, slope, energy = hertz_law(total, C_pair)
    for s in range(4):
        contact[s, FORCE] = 0.0
        if s == a or b == s:
            sign, C = (1.0 if s == b else -1.0) / dist, geometry[s, HERTZ]
            contact[s, FORCE] = force
            contact[s, MX], contact[s, MZ] = sign * (dx + vx), sign * (dz + vz)
            contact[s, KN] = slope * C_pair / C
            contact[s, KT] = force / (geometry[s, SIZE] + total * C / C_pair - geometry[s, APPROACH])
        elif geometry[s, USE] != 0.0:
            wx, wz, reach = geometry[s, WX], geometry[s, WZ], geometry[s, SIZE]
            delta, mx, mz, _ = approach_to_arc(p[0] - shift[s, 0], p[1] - shift[s, 1], wx, wz, reach, geometry[s, APPROACH])
            contact[s, MX], contact[s, MZ] = mx, mz
            if delta > 0.0:
                return -1.0
    return energy


@kernel
def clear_negligible_forces(contact: Array, tiny: float, energy: float) -> float:
    """Set all contact forces of a ball to zero if none exceeds ``tiny`` [N]; return the ball's contact energy [J].

    contact (4, 5): contacts of the ball, changed in place. The result is ``energy``, or zero if the forces are set to zero.
    """
    for s in range(4):
        if contact[s, FORCE] > tiny:
            return energy
    for s in range(4):
        contact[s, FORCE] = 0.0
    return 0.0


@kernel
def find_ball_equilibrium(
    p: Array,
    shift: Array,
    geometry: Array,
    closure: Array,
    local: Array,
    r_ball: float,
    profile: Array,
    tiny: float,
    contact: Array,
) -> float:
    """Find the equilibrium of one ball at known motions of its flanks, by minimising its contact energy.

    shift (4, 2): motions of the flanks [m]; closure (2,): nominal interference of the two pairs of opposite flanks [m];
    r_ball: ball radius [m]; profile (4, d): deviation of the flanks from a circular arc, see `contact.approach_to_profile`;
    tiny [N]: smaller forces count as zero; geometry (4, 9), local (4, 3): contact data and compliance terms, see the
    module. Writes the position p of the centre [m], (2,), or (3,) with the amplitude of the ball's deformation, and
    ``contact`` (4, 5). Returns the energy [J].

    For circular flanks with groove radius >= ball radius the energy is convex, and the forces at the minimum are unique. If
    a flank is so uneven that no step lowers the energy, the iteration ends with a ball out of equilibrium;
    `net_and_largest_contact_force` then gives its unbalanced force.
    """
    elastic = local.shape[0] > 0
    if profile.shape[1] == 0 and not elastic:
        first = interference_with_flank_pair(0, shift, geometry, closure)
        second = interference_with_flank_pair(1, shift, geometry, closure)
        energy = -1.0
        if first > 0.0 and second <= 0.0:  # the literal 0 lets the compiler compute the offsets of the pair's data
            energy = solve_opposite_flank_pair(0, first, p, shift, geometry, contact)
        elif second > 0.0 and first <= 0.0:
            energy = solve_opposite_flank_pair(1, second, p, shift, geometry, contact)
        if energy >= 0.0:
            return clear_negligible_forces(contact, tiny, energy)
    guess_ball_centre(p, shift, geometry, closure)
    x, z, y = p[0], p[1], 0.0
    energy = ball_contact_forces(x, z, y, shift, geometry, local, r_ball, profile, contact)
    best = 1e300
    for _ in range(SETTLING):
        net, scale = net_and_largest_contact_force(contact)
        if elastic:
            net = max(net, unbalanced_deformation_force(y, contact, local))
        if scale <= tiny:
            energy = clear_negligible_forces(contact, tiny, energy)
            break
        if net <= 2e-15 * scale or (net <= 1e-11 * scale and net >= 0.5 * best):
            break  # balanced, or at the round-off floor
        best = min(best, net)
        sx, sz, sy, slope = newton_step_of_ball(y, contact, local)
        if slope == 0.0:
            break
        t = 1.0
        new, lower = energy, False
        for _ in range(HALVINGS):
            new = ball_contact_forces(x + t * sx, z + t * sz, y + t * sy, shift, geometry, local, r_ball, profile, contact)
            lower = new <= energy + 1e-4 * t * slope or abs(t * slope) <= 1e-13 * energy
            if lower:
                break
            t *= 0.5
        if not lower:
            energy = ball_contact_forces(x, z, y, shift, geometry, local, r_ball, profile, contact)
            break
        x, z, y, energy = x + t * sx, z + t * sz, y + t * sy, new
    p[0], p[1] = x, z
    if elastic:
        p[2] = y
    return energy


@kernel
def largest_net_ball_force(contact: Array, scale: float) -> float:
    """Return the largest net contact force on any of N balls, as a fraction of ``scale`` [N] or in newtons if that is zero.

    The net force is zero in equilibrium. The check is separate, because the equilibrium equations of the beam do not
    contain the equilibrium of the balls. contact (N, 4, 5): forces and normals of the contacts.
    """
    worst = 0.0
    for i in range(contact.shape[0]):
        worst = max(worst, net_and_largest_contact_force(contact[i])[0])
    return worst / scale if scale > 0.0 else worst


@kernel
def contact_stiffness_entries(contact: Array, s: int) -> tuple[float, float, float]:
    """Return the entries xx, xz, zz [N/m] of the stiffness matrix F' m m^T + F kt t t^T of a ball's contact on flank s.

    contact (4, 5): contacts of a ball; s: number of the flank. m is the unit normal and t the tangent of the contact, F its
    force with the derivative F' by the approach, and kt the curvature term [1/m] of `approach_to_flank`. Zeros if the
    contact carries no force.
    """
    if contact[s, FORCE] <= 0.0:
        return 0.0, 0.0, 0.0
    mx, mz, kn, kt = contact[s, MX], contact[s, MZ], contact[s, KN], contact[s, KT]
    return kn * mx * mx + kt * mz * mz, (kn - kt) * mx * mz, kn * mz * mz + kt * mx * mx


@kernel
def write_ball_stiffness(contact: Array, out: Array) -> None:
    """Write the stiffness matrix of a ball against motions of its groove flanks, while its centre moves to equilibrium.

    contact (4, 5): contacts of the ball; out: (4, 4) for the screw's flanks or (8, 8) for all flanks [N/m], in the order
    screw left, screw right, nut left, nut right, with two components each (x: radial, z: along the helix's binormal). With
    the stiffness h_s (2, 2) of the contact on flank s and the sum H over all contacts, the block of flanks s and t is
    -h_s H^-1 h_t, and the block of flank s on the diagonal is h_s H^-1 (H - h_s). H - h_s is summed over the other
    contacts, which avoids cancellation.
    """
    out[:, :] = 0.0
    txx, txz, tzz = 0.0, 0.0, 0.0  # H, the sum of all blocks h_s
    for s in range(4):
        x, y, z = contact_stiffness_entries(contact, s)
        txx, txz, tzz = txx + x, txz + y, tzz + z
    det = txx * tzz - txz * txz
    if det <= 0.0:
        return
    ixx, ixz, izz, flanks = tzz / det, -txz / det, txx / det, out.shape[0] // 2  # H^-1
    for s in range(flanks):
        if contact[s, FORCE] <= 0.0:
            continue
        hxx, hxz, hzz = contact_stiffness_entries(contact, s)
        # a = h_s H^-1
        a00, a01 = hxx * ixx + hxz * ixz, hxx * ixz + hxz * izz
        a10, a11 = hxz * ixx + hzz * ixz, hxz * ixz + hzz * izz
        o = 2 * s
        for t in range(4):
            if t == s or contact[t, FORCE] <= 0.0:
                continue
            hxx, hxz, hzz = contact_stiffness_entries(contact, t)
            # h_s H^-1 h_t = ((x, y), (z, w)): added to block (s, s), negative in block (s, t)
            x, y = a00 * hxx + a01 * hxz, a00 * hxz + a01 * hzz
            z, w = a10 * hxx + a11 * hxz, a10 * hxz + a11 * hzz
            out[o, o] += x
            out[o, o + 1] += y
            out[o + 1, o] += z
            out[o + 1, o + 1] += w
            if t < flanks:
                c = 2 * t
                out[o, c], out[o, c + 1], out[o + 1, c], out[o + 1, c + 1] = -x, -y, -z, -w
