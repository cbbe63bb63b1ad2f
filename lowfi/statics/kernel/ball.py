"""One ball in its grooves: its centre eliminated from the contact energy (2 x 2), for up to four contacts.

Packed rows, one per side SL, SR, NL, NR:
geometry (4, 9): nominal w = (x3, z3) of the ball from the groove's centre, its size, nominal approach [m], Hertz
constant C [m/N^(2/3)], 1 or 0 whether the flank takes part, groove radius [m], and the signs s_x, s_z of
the contact direction;
contact (4, 5): force [N], unit normal m (ball to groove), F' = dF/d delta and F kt [N/m].
"""

from math import sqrt

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import Array

from .contact import arc, flank, hertz

WX, WZ, SIZE, APPROACH, HERTZ, USE, RADIUS, SX, SZ = range(9)
FORCE, MX, MZ, KN, KT = range(5)
#: Bounds of a ball's iteration: steps, and halvings of one.
SETTLING, HALVINGS = 60, 30
#: Relative step of Newton's method in one unknown after which it has all digits: each squares the error of the one before.
SETTLED = 1e-9


@kernel
def start_centre(p: Array, shift: Array, geometry: Array, closure: Array) -> int:
    """Starting centre: two-contact solutions of the diagonal pairs that close, or of the only one, whose flanks share the
    gap; else the mean shift of the flanks.

    With D = o_a - o_b between opposite groove centres the interference is its nominal value ``closure`` (2,) plus
    |D + v_a - v_b| - |D|, and the pair shares it as C_a : C_b (exact for circular flanks). Writes p (2,), relative to
    the nominal centre; returns how many pairs close.
    """
    count = 0
    x, z = 0.0, 0.0
    for a in range(2):
        b = 3 - a
        if geometry[a, USE] == 0.0 or geometry[b, USE] == 0.0:
            continue
        dx, dz = geometry[b, WX] - geometry[a, WX], geometry[b, WZ] - geometry[a, WZ]
        vx, vz = shift[a, 0] - shift[b, 0], shift[a, 1] - shift[b, 1]
        dist0 = sqrt(dx * dx + dz * dz)
        dist = sqrt((dx + vx) * (dx + vx) + (dz + vz) * (dz + vz))
        if dist <= 1e-30 or dist0 <= 1e-30:
            continue
        change = (vx * (2.0 * dx + vx) + vz * (2.0 * dz + vz)) / (dist + dist0)
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
    """Approach, normal and curvature term of the ball at (ux, uz) from its nominal place on one flank, arc or not."""
    if profile.shape[0] == 0:
        return arc(ux, uz, geometry[WX], geometry[WZ], geometry[SIZE], geometry[APPROACH])
    return flank(ux, uz, geometry[WX], geometry[WZ], r_ball, geometry[RADIUS], profile, geometry[SX], geometry[SZ])


@kernel
def touch(px: float, pz: float, shift: Array, geometry: Array, r_ball: float, profile: Array, contact: Array) -> float:
    """Contact forces and stiffnesses with the ball's centre at p; returns the energy [J] (Lin 2.14 integrated)."""
    if profile.shape[1] > 0:
        return touch_uneven(px, pz, shift, geometry, r_ball, profile, contact)
    energy = 0.0  # arcs by themselves, no rows taken out: the compiler puts it where it is called
    for s in range(4):
        contact[s, FORCE] = 0.0
        if geometry[s, USE] != 0.0:
            wx, wz, size, approach = geometry[s, WX], geometry[s, WZ], geometry[s, SIZE], geometry[s, APPROACH]
            met = arc(px - shift[s, 0], pz - shift[s, 1], wx, wz, size, approach)
            energy += press(contact, s, met, geometry[s, HERTZ])
    return energy


@kernel
def touch_uneven(
    px: float, pz: float, shift: Array, geometry: Array, r_ball: float, profile: Array, contact: Array
) -> float:
    """``touch`` for flanks that are no arcs."""
    energy = 0.0
    for s in range(4):
        contact[s, FORCE] = 0.0
        if geometry[s, USE] != 0.0:
            met = meet(px - shift[s, 0], pz - shift[s, 1], geometry[s], r_ball, profile[s])
            energy += press(contact, s, met, geometry[s, HERTZ])
    return energy


@kernel
def press(contact: Array, s: int, met: tuple[float, float, float, float], c: float) -> float:
    """Fill the contact s as it has met its flank (see ``meet``), c its Hertz constant; returns its energy [J]."""
    delta, contact[s, MX], contact[s, MZ], kt = met
    if not delta > 0.0:
        return 0.0
    force, slope, energy = hertz(delta, c)
    contact[s, FORCE], contact[s, KN], contact[s, KT] = force, slope, force * kt
    return energy


@kernel
def net_force(contact: Array) -> tuple[float, float]:
    """Size of the net force on the ball and the largest single force [N]."""
    gx, gz, scale = 0.0, 0.0, 0.0
    for s in range(4):
        f = contact[s, FORCE]
        if f > 0.0:
            gx += f * contact[s, MX]
            gz += f * contact[s, MZ]
            scale = max(scale, f)
    return sqrt(gx * gx + gz * gz), scale


@kernel
def newton_step(contact: Array) -> tuple[float, float, float]:
    """Newton step of the centre and the slope of the energy along it; down the gradient where the Hessian is singular."""
    gx, gz, hxx, hxz, hzz = 0.0, 0.0, 0.0, 0.0, 0.0
    for s in range(4):
        f = contact[s, FORCE]
        if f > 0.0:
            mx, mz, kn, kt = contact[s, MX], contact[s, MZ], contact[s, KN], contact[s, KT]
            gx += f * mx
            gz += f * mz
            hxx += kn * mx * mx + kt * mz * mz
            hzz += kn * mz * mz + kt * mx * mx
            hxz += (kn - kt) * mx * mz
    bump = 1e-14 * (hxx + hzz)
    hxx += bump
    hzz += bump
    det = hxx * hzz - hxz * hxz
    if det <= 0.0:
        stiff = hxx + hzz
        if stiff <= 0.0:
            return 0.0, 0.0, 0.0
        return -gx / stiff, -gz / stiff, -(gx * gx + gz * gz) / stiff
    sx, sz = -(hzz * gx - hxz * gz) / det, -(hxx * gz - hxz * gx) / det
    return sx, sz, gx * sx + gz * sz


@kernel
def interference(a: int, shift: Array, geometry: Array, closure: Array) -> float:
    """Interference [m] of the diagonal pair a between its groove centres where both its flanks take part, else -1."""
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
    """Contacts of a ball that the diagonal pair a of arcs holds alone, with the interference ``total`` [m]: closed form.

    Forces are opposite, so each contact takes its share C/(C_a + C_b) of the interference, on the line of the groove
    centres. Writes p (2,) and ``contact``; returns the energy [J], or -1 where another flank touches the ball there.
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
    """The energy [J], zero where no contact carries more than ``tiny`` [N]: its forces are then set to none."""
    for s in range(4):
        if contact[s, FORCE] > tiny:
            return energy
    for s in range(4):
        contact[s, FORCE] = 0.0
    return 0.0


@kernel
def settle_ball(
    p: Array, shift: Array, geometry: Array, closure: Array, r_ball: float, profile: Array, tiny: float, contact: Array
) -> float:
    """Equilibrium of one ball at given motions of its flanks: minimises its contact energy over its centre.

    shift (4, 2): motion of the flanks [m]; closure (2,): nominal interference of the diagonal pairs [m]; r_ball [m];
    profile (4, d): see ``contact.flank``; tiny [N]: forces below it count as none. Fills p (2,) [m] and ``contact``;
    returns the energy [J]. The energy of exact arcs is convex for r_G >= r_B: the forces at the minimum are unique. Where
    an uneven profile leaves no step that lowers it, the ball stays out of balance, which ``net_force`` shows.
    """
    if profile.shape[1] == 0:
        first, second = interference(0, shift, geometry, closure), interference(1, shift, geometry, closure)
        energy = -1.0
        if first > 0.0 and second <= 0.0:  # the pair by its number: the compiler then knows the places of its data
            energy = press_pair(0, first, p, shift, geometry, contact)
        elif second > 0.0 and first <= 0.0:
            energy = press_pair(1, second, p, shift, geometry, contact)
        if energy >= 0.0:
            return loosened(contact, tiny, energy)
    start_centre(p, shift, geometry, closure)
    energy = touch(p[0], p[1], shift, geometry, r_ball, profile, contact)
    best = 1e300
    for _ in range(SETTLING):
        net, scale = net_force(contact)
        if scale <= tiny:
            return loosened(contact, tiny, energy)
        if net <= 2e-15 * scale or (net <= 1e-11 * scale and net >= 0.5 * best):
            break  # balanced, or at the round-off floor
        best = min(best, net)
        sx, sz, slope = newton_step(contact)
        if slope == 0.0:
            break
        t = 1.0
        new, lower = energy, False
        for _ in range(HALVINGS):
            new = touch(p[0] + t * sx, p[1] + t * sz, shift, geometry, r_ball, profile, contact)
            lower = new <= energy + 1e-4 * t * slope or abs(t * slope) <= 1e-13 * energy
            if lower:
                break
            t *= 0.5
        if not lower:
            return touch(p[0], p[1], shift, geometry, r_ball, profile, contact)
        p[0] += t * sx
        p[1] += t * sz
        energy = new
    return energy


@kernel
def ball_mismatch(contact: Array, scale: float) -> float:
    """Largest net contact force on a ball over ``scale`` [N]; contact (N, 4, 5). The beam's equations do not see it."""
    worst = 0.0
    for i in range(contact.shape[0]):
        worst = max(worst, net_force(contact[i])[0])
    return worst / scale if scale > 0.0 else worst


@kernel
def block(contact: Array, s: int) -> tuple[float, float, float]:
    """Stiffness h_s = F' m m^T + F kt t t^T of contact s: (xx, xz, zz) [N/m]."""
    if contact[s, FORCE] <= 0.0:
        return 0.0, 0.0, 0.0
    mx, mz, kn, kt = contact[s, MX], contact[s, MZ], contact[s, KN], contact[s, KT]
    return kn * mx * mx + kt * mz * mz, (kn - kt) * mx * mz, kn * mz * mz + kt * mx * mx


@kernel
def flank_hessian(contact: Array, out: Array) -> None:
    """Hessian of the ball's energy by the motion of its flanks, its centre eliminated: out (4, 4) of the screw's, or (8, 8)
    of all [N/m], in the order SL x, SL z, SR x, ...

    With H the sum of the blocks h_s: -h_s H^-1 h_t off the diagonal and h_s H^-1 (H - h_s) on it (the others summed,
    not subtracted: no cancellation).
    """
    out[:, :] = 0.0
    txx, txz, tzz = 0.0, 0.0, 0.0
    for s in range(4):
        x, y, z = block(contact, s)
        txx, txz, tzz = txx + x, txz + y, tzz + z
    det = txx * tzz - txz * txz
    if det <= 0.0:
        return
    ixx, ixz, izz, flanks = tzz / det, -txz / det, txx / det, out.shape[0] // 2
    for s in range(flanks):
        if contact[s, FORCE] <= 0.0:
            continue
        hxx, hxz, hzz = block(contact, s)
        a00, a01 = hxx * ixx + hxz * ixz, hxx * ixz + hxz * izz
        a10, a11 = hxz * ixx + hzz * ixz, hxz * ixz + hzz * izz
        o = 2 * s
        for t in range(4):
            if t == s or contact[t, FORCE] <= 0.0:
                continue
            hxx, hxz, hzz = block(contact, t)
            x, y = a00 * hxx + a01 * hxz, a00 * hxz + a01 * hzz
            z, w = a10 * hxx + a11 * hxz, a10 * hxz + a11 * hzz
            out[o, o] += x
            out[o, o + 1] += y
            out[o + 1, o] += z
            out[o + 1, o + 1] += w
            if t < flanks:
                c = 2 * t
                out[o, c], out[o, c + 1], out[o + 1, c], out[o + 1, c + 1] = -x, -y, -z, -w
