"""One ball in its grooves, for up to four contacts.

Its centre, and the amplitude of its body's deformation where it is elastic, are eliminated from the contact energy.

Packed rows, one per flank SL, SR, NL, NR:
geometry (4, 9): nominal w = (x3, z3) of the ball from the groove's centre, its size, nominal approach [m], Hertz
constant C [m/N^(2/3)], 1 or 0 whether the flank takes part, groove radius [m], and the signs s_x, s_z of
the contact direction; contact (4, 5): force [N], unit normal m (ball to groove), F' = dF/d delta and F kt [N/m]; local (4,
3), or (0, 3) for a ball that is rigid beyond its contacts: e [m/N] and h [m/N^(4/3)] of ``contact_law``, and between them
what a unit amplitude of the ball's body takes from the approach [m].
"""

from math import sqrt

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import Array

from .contact import arc, contact_law, flank, hertz

WX, WZ, SIZE, APPROACH, HERTZ, USE, RADIUS, SX, SZ = range(9)
FORCE, MX, MZ, KN, KT = range(5)
LINEAR, BODY, HIGHER = range(3)
#: Bounds of a ball's iteration: steps, and halvings of one.
SETTLING, HALVINGS = 60, 30


@kernel
def start_centre(p: Array, shift: Array, geometry: Array, closure: Array) -> int:
    """Write a start for the centre p (2,), relative to the nominal one; return how many diagonal pairs close.

    The two-contact solutions of the diagonal pairs that close, or of the only one, whose flanks share the gap; else the
    mean shift of the flanks. With D = o_a - o_b between opposite groove centres the interference is its nominal value
    ``closure`` (2,) plus |D + v_a - v_b| - |D|, and the pair shares it as C_a : C_b (exact for circular flanks).
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
            # from b's groove centre along D + v by the size of w_b that gives b its share of the interference; the
            # turn of that direction is (v - D/|D| change)/|D + v|: no difference of unit vectors
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
def meet(ux: float, uz: float, geometry: Array, r_ball: float, profile: Array) -> tuple[float, float, float, float]:
    """Return approach, normal and curvature term of the ball at (ux, uz) from its nominal position on one flank."""
    if profile.shape[0] == 0:
        return arc(ux, uz, geometry[WX], geometry[WZ], geometry[SIZE], geometry[APPROACH])
    return flank(ux, uz, geometry[WX], geometry[WZ], r_ball, geometry[RADIUS], profile, geometry[SX], geometry[SZ])


@kernel
def touch(
    x: float, z: float, y: float, shift: Array, geometry: Array, local: Array, r_ball: float, profile: Array, contact: Array
) -> float:
    """Write contact forces and stiffnesses with the ball's centre at (x, z) and the amplitude y; return the energy [J].

    Lin 2.14 integrated.
    """
    if profile.shape[1] > 0 or local.shape[0] > 0:
        return touch_any(x, z, y, shift, geometry, local, r_ball, profile, contact)
    energy = 0.0  # a separate loop for arcs, without views of rows, so that the compiler inlines it
    for s in range(4):
        contact[s, FORCE] = 0.0
        if geometry[s, USE] != 0.0:
            wx, wz, size, approach = geometry[s, WX], geometry[s, WZ], geometry[s, SIZE], geometry[s, APPROACH]
            delta, contact[s, MX], contact[s, MZ], kt = arc(x - shift[s, 0], z - shift[s, 1], wx, wz, size, approach)
            if delta > 0.0:
                force, slope, work = hertz(delta, geometry[s, HERTZ])
                contact[s, FORCE], contact[s, KN], contact[s, KT] = force, slope, force * kt
                energy += work
    return energy


@kernel
def touch_any(
    x: float, z: float, y: float, shift: Array, geometry: Array, local: Array, r_ball: float, profile: Array, contact: Array
) -> float:
    """Write and return the same as `touch` for flanks that are no arcs, and for elastic bodies."""
    energy = 0.5 * y * y  # of the body's amplitude, scaled to a stiffness of one
    for s in range(4):
        contact[s, FORCE] = 0.0
        if geometry[s, USE] == 0.0:
            continue
        met = meet(x - shift[s, 0], z - shift[s, 1], geometry[s], r_ball, profile[s])
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
def net_force(contact: Array) -> tuple[float, float]:
    """Return the size of the net force on the ball and the largest single force [N]."""
    gx, gz, scale = 0.0, 0.0, 0.0
    for s in range(4):
        f = contact[s, FORCE]
        if f > 0.0:
            gx += f * contact[s, MX]
            gz += f * contact[s, MZ]
            scale = max(scale, f)
    return sqrt(gx * gx + gz * gz), scale


@kernel
def body_force(y: float, contact: Array, local: Array) -> float:
    """Return the net force on the amplitude y of the ball's body, as a force [N] on a contact."""
    net, reach = y, 0.0
    for s in range(4):
        reach = max(reach, abs(local[s, BODY]))
        net -= max(contact[s, FORCE], 0.0) * local[s, BODY]
    return abs(net) / reach if reach > 0.0 else 0.0


@kernel
def newton_step(y: float, contact: Array, local: Array) -> tuple[float, float, float, float]:
    """Return the Newton step of centre and amplitude, and the slope of the energy along it.

    Of a rigid ball down the gradient where the Hessian is singular.
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
    bump = 1e-14 * (hxx + hzz)  # a ball on one contact is free across it
    hxx += bump
    hzz += bump
    if local.shape[0] > 0:
        return body_step(gx, gz, gy, hxx, hxz, hzz, hxy, hzy, hyy)
    det = hxx * hzz - hxz * hxz
    if det <= 0.0:
        stiff = hxx + hzz
        if stiff <= 0.0:
            return 0.0, 0.0, 0.0, 0.0
        return -gx / stiff, -gz / stiff, 0.0, -(gx * gx + gz * gz) / stiff
    sx, sz = -(hzz * gx - hxz * gz) / det, -(hxx * gz - hxz * gx) / det
    return sx, sz, 0.0, gx * sx + gz * sz


@kernel
def body_step(
    gx: float, gz: float, gy: float, hxx: float, hxz: float, hzz: float, hxy: float, hzy: float, hyy: float
) -> tuple[float, float, float, float]:
    """Return the Newton step of a centre (x, z) and an amplitude y by Cholesky's method, and the slope along it.

    Zeros where the Hessian is singular.
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
def interference(a: int, shift: Array, geometry: Array, closure: Array) -> float:
    """Return interference [m] of the diagonal pair a between its groove centres where both flanks take part, else -1."""
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
def press_pair(a: int, total: float, p: Array, shift: Array, geometry: Array, contact: Array) -> float:
    """Write the contacts of a ball that only the diagonal pair a of arcs touches, with the interference ``total`` [m].

    In closed form: forces are opposite, so each contact takes its share C/(C_a + C_b) of the interference, on the line of
    the groove centres. Writes p (2,) and ``contact``; returns the energy [J], or -1 where another flank touches the ball
    there.
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
    force, slope, energy = hertz(total, C_pair)
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
            delta, mx, mz, _ = arc(p[0] - shift[s, 0], p[1] - shift[s, 1], wx, wz, reach, geometry[s, APPROACH])
            contact[s, MX], contact[s, MZ] = mx, mz
            if delta > 0.0:
                return -1.0
    return energy


@kernel
def loosened(contact: Array, tiny: float, energy: float) -> float:
    """Return the energy [J]; zero where no contact carries more than ``tiny`` [N], with all forces set to zero."""
    for s in range(4):
        if contact[s, FORCE] > tiny:
            return energy
    for s in range(4):
        contact[s, FORCE] = 0.0
    return 0.0


@kernel
def settle_ball(
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
    """Minimise the contact energy of one ball at given motions of its flanks, over its centre and its body's amplitude.

    shift (4, 2): motion of the flanks [m]; closure (2,): nominal interference of the diagonal pairs [m]; r_ball [m];
    profile (4, d): see ``contact.flank``; tiny [N]: forces below it count as none. Fills p [m], (2,), or (3,) with the
    amplitude, and ``contact``; returns the energy [J]. The energy of exact arcs is convex for r_G >= r_B: the forces at the
    minimum are unique. Where an uneven profile leaves no step that lowers it, the ball stays out of balance, which
    ``net_force`` shows.
    """
    elastic = local.shape[0] > 0
    if profile.shape[1] == 0 and not elastic:
        first, second = interference(0, shift, geometry, closure), interference(1, shift, geometry, closure)
        energy = -1.0
        if first > 0.0 and second <= 0.0:  # the pair as a literal: the compiler then knows the offsets of its data
            energy = press_pair(0, first, p, shift, geometry, contact)
        elif second > 0.0 and first <= 0.0:
            energy = press_pair(1, second, p, shift, geometry, contact)
        if energy >= 0.0:
            return loosened(contact, tiny, energy)
    start_centre(p, shift, geometry, closure)
    x, z, y = p[0], p[1], 0.0
    energy = touch(x, z, y, shift, geometry, local, r_ball, profile, contact)
    best = 1e300
    for _ in range(SETTLING):
        net, scale = net_force(contact)
        if elastic:
            net = max(net, body_force(y, contact, local))
        if scale <= tiny:
            energy = loosened(contact, tiny, energy)
            break
        if net <= 2e-15 * scale or (net <= 1e-11 * scale and net >= 0.5 * best):
            break  # balanced, or at the round-off floor
        best = min(best, net)
        sx, sz, sy, slope = newton_step(y, contact, local)
        if slope == 0.0:
            break
        t = 1.0
        new, lower = energy, False
        for _ in range(HALVINGS):
            new = touch(x + t * sx, z + t * sz, y + t * sy, shift, geometry, local, r_ball, profile, contact)
            lower = new <= energy + 1e-4 * t * slope or abs(t * slope) <= 1e-13 * energy
            if lower:
                break
            t *= 0.5
        if not lower:
            energy = touch(x, z, y, shift, geometry, local, r_ball, profile, contact)
            break
        x, z, y, energy = x + t * sx, z + t * sz, y + t * sy, new
    p[0], p[1] = x, z
    if elastic:
        p[2] = y
    return energy


@kernel
def ball_mismatch(contact: Array, scale: float) -> float:
    """Return the largest net contact force on a ball over ``scale`` [N]; contact (N, 4, 5).

    The beam's equations do not contain it.
    """
    worst = 0.0
    for i in range(contact.shape[0]):
        worst = max(worst, net_force(contact[i])[0])
    return worst / scale if scale > 0.0 else worst


@kernel
def block(contact: Array, s: int) -> tuple[float, float, float]:
    """Return the stiffness h_s = F' m m^T + F kt t t^T of contact s: (xx, xz, zz) [N/m]."""
    if contact[s, FORCE] <= 0.0:
        return 0.0, 0.0, 0.0
    mx, mz, kn, kt = contact[s, MX], contact[s, MZ], contact[s, KN], contact[s, KT]
    return kn * mx * mx + kt * mz * mz, (kn - kt) * mx * mz, kn * mz * mz + kt * mx * mx


@kernel
def flank_hessian(contact: Array, out: Array) -> None:
    """Write the Hessian of the ball's energy by the motion of its flanks, its centre eliminated.

    out (4, 4) of the screw's flanks, or (8, 8) of all [N/m], in the order SL x, SL z, SR x, ... With H the sum of the
    blocks h_s: -h_s H^-1 h_t off the diagonal and h_s H^-1 (H - h_s) on it (the others summed, not subtracted: no
    cancellation).
    """
    out[:, :] = 0.0
    txx, txz, tzz = 0.0, 0.0, 0.0  # H, the sum of all blocks h_s
    for s in range(4):
        x, y, z = block(contact, s)
        txx, txz, tzz = txx + x, txz + y, tzz + z
    det = txx * tzz - txz * txz
    if det <= 0.0:
        return
    ixx, ixz, izz, flanks = tzz / det, -txz / det, txx / det, out.shape[0] // 2  # H^-1
    for s in range(flanks):
        if contact[s, FORCE] <= 0.0:
            continue
        hxx, hxz, hzz = block(contact, s)
        # a = h_s H^-1
        a00, a01 = hxx * ixx + hxz * ixz, hxx * ixz + hxz * izz
        a10, a11 = hxz * ixx + hzz * ixz, hxz * ixz + hzz * izz
        o = 2 * s
        for t in range(4):
            if t == s or contact[t, FORCE] <= 0.0:
                continue
            hxx, hxz, hzz = block(contact, t)
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
