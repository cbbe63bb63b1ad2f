"""Balls between flanks of elastic bodies: forces on the flanks by their motions, and the square roots of the stiffness.

A ball has its centre and one amplitude of its own body for unknowns, eliminated inside, and every contact has parts e F and
h F^(4/3) besides Hertz's C F^(2/3). Where only two opposite flanks carry load, a ball knows only their relative motion, and
has a closed form.
"""

from math import sqrt

import numpy as np

from rollbench.lowfi.jit import kernel
from rollbench.lowfi.statics.kernel_types import Array, BallContacts, BodyState

from .ball import FORCE, HALVINGS, HERTZ, KN, KT, MX, MZ, SETTLED, SETTLING, USE, meet, start_centre
from .contact import hertz
from .rollers import roller_elements, roller_rows

LINEAR, BODY, HIGHER = range(3)


@kernel
def contact_law(delta: float, c: float, e: float, h: float) -> tuple[float, float, float]:
    """Force [N], its slope [N/m] and energy [J] of delta = C F^(2/3) + e F + h F^(4/3) [m], delta > 0.

    Negative e or h would bend the law back where 2 C + 3 e x + 4 h x^2 = 0, x = F^(1/3); from where this is down to C
    on the law goes on as C F^(2/3)/2 plus a constant, so that force and slope stay continuous and the energy convex.
    """
    if e == 0.0 and h == 0.0:
        return hertz(delta, c)
    x = sqrt(delta / c)
    low, high = 0.0, 1e300
    limit = turning(c, e, h)
    if limit > 0.0:
        edge = limit * limit * (c + limit * (e + limit * h))
        if delta > edge:
            x = sqrt(limit * limit + 2.0 * (delta - edge) / c)
            return x * x * x, 3.0 * x / c, stored(limit, c, e, h) + 0.2 * c * (x**5 - limit**5)
        high = limit
        x = min(x, limit)
    for _ in range(60):
        f = x * x * (c + x * (e + x * h)) - delta
        if f > 0.0:
            high = x
        else:
            low = x
        new = x - f / (x * (2.0 * c + x * (3.0 * e + 4.0 * h * x)))
        if abs(new - x) <= SETTLED * x:
            x = new
            break
        x = new if low < new < high else 0.5 * (low + high)
    return x * x * x, 3.0 * x / (2.0 * c + x * (3.0 * e + 4.0 * h * x)), stored(x, c, e, h)


@kernel
def turning(c: float, e: float, h: float) -> float:
    """Least x > 0 with 3 e x + 4 h x^2 = -C, 0 where there is none."""
    root = 9.0 * e * e - 16.0 * h * c
    if root < 0.0 or (e >= 0.0 and h >= 0.0):
        return 0.0
    if e > 0.0:  # either form for its sign of e: no difference of like numbers
        return -(3.0 * e + sqrt(root)) / (8.0 * h)
    return 2.0 * c / (sqrt(root) - 3.0 * e)


@kernel
def stored(x: float, c: float, e: float, h: float) -> float:
    """Energy [J] of a contact at the force x^3: force times approach less the integral of the approach by the force."""
    return x * x * x * x * x * (0.4 * c + x * (0.5 * e + 4.0 / 7.0 * h * x))


@kernel
def press(x: Array, shift: Array, geometry: Array, local: Array, r_ball: float, profile: Array, contact: Array) -> float:
    """Contact forces and stiffnesses with centre and amplitude x (3,); returns the energy [J]. local (4, 3): e [m/N] of
    each contact, what a unit amplitude takes from its approach [m], and h [m/N^(4/3)]."""
    energy: float = 0.5 * x[2] * x[2]
    for s in range(4):
        contact[s, FORCE] = 0.0
        if geometry[s, USE] == 0.0:
            continue
        delta, mx, mz, kt = meet(x[0] - shift[s, 0], x[1] - shift[s, 1], geometry[s], r_ball, profile[s])
        contact[s, MX], contact[s, MZ] = mx, mz
        delta -= local[s, BODY] * x[2]
        if delta > 0.0:
            force, slope, work = contact_law(delta, geometry[s, HERTZ], local[s, LINEAR], local[s, HIGHER])
            contact[s, FORCE] = force
            contact[s, KN] = slope
            contact[s, KT] = force * kt
            energy += work
    return energy


@kernel
def inner_gradient(x: Array, contact: Array, local: Array, out: Array) -> tuple[float, float]:
    """Gradient (3,) of a ball's energy by centre and amplitude; returns its size [N] and the largest force [N]."""
    out[0], out[1], out[2] = 0.0, 0.0, x[2]
    scale, reach = 0.0, 0.0
    for s in range(4):
        f = contact[s, FORCE]
        reach = max(reach, abs(local[s, BODY]))
        if f > 0.0:
            out[0] += f * contact[s, MX]
            out[1] += f * contact[s, MZ]
            out[2] -= f * local[s, BODY]
            scale = max(scale, f)
    size = sqrt(out[0] * out[0] + out[1] * out[1])
    if reach > 0.0:
        size = max(size, abs(out[2]) / reach)
    return size, scale


@kernel
def inner_hessian(contact: Array, local: Array, H: Array) -> None:
    """Hessian (3, 3) of a ball's energy by centre and amplitude."""
    H[:, :] = 0.0
    H[2, 2] = 1.0
    for s in range(4):
        if contact[s, FORCE] > 0.0:
            mx, mz, kn, kt = contact[s, MX], contact[s, MZ], contact[s, KN], contact[s, KT]
            g = local[s, BODY]
            H[0, 0] += kn * mx * mx + kt * mz * mz
            H[1, 1] += kn * mz * mz + kt * mx * mx
            H[0, 1] += (kn - kt) * mx * mz
            H[0, 2] -= kn * mx * g
            H[1, 2] -= kn * mz * g
            H[2, 2] += kn * g * g
    H[1, 0], H[2, 0], H[2, 1] = H[0, 1], H[0, 2], H[1, 2]


@kernel
def factor3(H: Array) -> bool:
    """Cholesky factor of a (3, 3) matrix in its lower triangle; the first two pivots are bumped by round-off."""
    bump = 1e-14 * (H[0, 0] + H[1, 1])
    H[0, 0] += bump
    H[1, 1] += bump
    for j in range(3):
        d = H[j, j]
        for k in range(j):
            d -= H[j, k] * H[j, k]
        if not d > 0.0:
            return False
        H[j, j] = sqrt(d)
        for i in range(j + 1, 3):
            v = H[i, j]
            for k in range(j):
                v -= H[i, k] * H[j, k]
            H[i, j] = v / H[j, j]
    return True


@kernel
def forward3(L: Array, b: Array) -> None:
    """Overwrite b (3,) by L^-1 b."""
    b[0] = b[0] / L[0, 0]
    b[1] = (b[1] - L[1, 0] * b[0]) / L[1, 1]
    b[2] = (b[2] - L[2, 0] * b[0] - L[2, 1] * b[1]) / L[2, 2]


@kernel
def backward3(L: Array, b: Array) -> None:
    """Overwrite b (3,) by L^-T b."""
    b[2] = b[2] / L[2, 2]
    b[1] = (b[1] - L[2, 1] * b[2]) / L[1, 1]
    b[0] = (b[0] - L[1, 0] * b[1] - L[2, 0] * b[2]) / L[0, 0]


@kernel
def rest(
    x: Array,
    shift: Array,
    geometry: Array,
    closure: Array,
    local: Array,
    r_ball: float,
    profile: Array,
    tiny: float,
    contact: Array,
    work: Array,
) -> float:
    """Equilibrium of one ball at given motions of its flanks (4, 2): fills x (3,) and ``contact``; returns the energy [J].

    work (5, 3): scratch. See ``ball.settle_ball``, of which this is the form with a body of its own.
    """
    H, g, trial = work[:3], work[3], work[4]
    start_centre(x, shift, geometry, closure)
    x[2] = 0.0
    energy = press(x, shift, geometry, local, r_ball, profile, contact)
    best = 1e300
    for _ in range(SETTLING):
        net, scale = inner_gradient(x, contact, local, g)
        if scale <= tiny:
            for k in range(4):
                contact[k, FORCE] = 0.0
            return 0.0
        if net <= 2e-15 * scale or (net <= 1e-11 * scale and net >= 0.5 * best):
            break
        best = min(best, net)
        inner_hessian(contact, local, H)
        if not factor3(H):
            break
        slope = 0.0
        trial[0], trial[1], trial[2] = -g[0], -g[1], -g[2]
        forward3(H, trial)
        backward3(H, trial)
        for k in range(3):
            slope += trial[k] * g[k]
        sx, sz, sy = trial[0], trial[1], trial[2]
        t, new, lower = 1.0, energy, False
        ox, oz, oy = x[0], x[1], x[2]
        for _ in range(HALVINGS):
            x[0], x[1], x[2] = ox + t * sx, oz + t * sz, oy + t * sy
            new = press(x, shift, geometry, local, r_ball, profile, contact)
            lower = new <= energy + 1e-4 * t * slope or abs(t * slope) <= 1e-13 * energy
            if lower:
                break
            t *= 0.5
        if not lower:
            x[0], x[1], x[2] = ox, oz, oy
            return press(x, shift, geometry, local, r_ball, profile, contact)
        energy = new
    return energy


@kernel
def flank_rows(contact: Array, local: Array, rows: Array) -> int:
    """Rows S (6, 8) with S^T S the ball's Hessian by the motions of its flanks; returns how many.

    The square roots sqrt(k) d of the contacts' stiffnesses by the flanks are orthogonalised (Householder) against those by
    centre and amplitude: no difference of large numbers.
    """
    A = np.zeros((9, 3))
    B = np.zeros((9, 8))
    n = 0
    for s in range(4):
        if contact[s, FORCE] <= 0.0:
            continue
        mx, mz = contact[s, MX], contact[s, MZ]
        for tangential in range(2):
            k = sqrt(contact[s, KN] if tangential == 0 else contact[s, KT])
            dx, dz = (mx, mz) if tangential == 0 else (-mz, mx)
            A[n, 0], A[n, 1] = k * dx, k * dz
            A[n, 2] = -k * local[s, BODY] if tangential == 0 else 0.0
            B[n, 2 * s], B[n, 2 * s + 1] = k * dx, k * dz
            n += 1
    if n == 0:
        return 0
    A[n, 2] = 1.0
    n += 1
    used = min(3, n)
    for c in range(used):
        norm = 0.0
        for i in range(c, n):
            norm += A[i, c] * A[i, c]
        norm = sqrt(norm)
        if A[c, c] > 0.0:
            norm = -norm
        A[c, c] -= norm
        size = 0.0
        for i in range(c, n):
            size += A[i, c] * A[i, c]
        if size == 0.0:
            continue
        for j in range(c + 1, 3):
            reflect(A[:, c], A[:, j], c, n, size)
        for j in range(8):
            reflect(A[:, c], B[:, j], c, n, size)
    for i in range(used, n):
        for j in range(8):
            rows[i - used, j] = B[i, j]
    return n - used


@kernel
def reflect(direction: Array, x: Array, first: int, last: int, size: float) -> None:
    """Householder reflection of x[first:last] by ``direction`` of squared length ``size``."""
    dot = 0.0
    for i in range(first, last):
        dot += direction[i] * x[i]
    dot *= 2.0 / size
    for i in range(first, last):
        x[i] -= dot * direction[i]


@kernel
def full_balls(v: Array, contacts: BallContacts, inner: Array, contact: Array, f: Array) -> tuple[float, float]:
    """Forces f (N, 8) of all balls on their flanks at motions v (N, 8); returns energy and the largest contact force.

    Fills inner (N, 3) and contact (N, 4, 5). Rollers come after the balls.
    """
    geometry, closure, local, r_ball, profile = contacts[:5]
    energy, scale, tiny = 0.0, 0.0, contacts.tiny
    work = np.empty((5, 3))
    balls = r_ball.shape[0]
    for i in range(balls):
        energy += rest(
            inner[i], v[i].reshape(4, 2), geometry[i], closure[i], local[i], r_ball[i], profile[i], tiny, contact[i], work
        )
        for s in range(4):
            force = contact[i, s, FORCE]
            scale = max(scale, force)
            f[i, 2 * s] = force * contact[i, s, MX] if force > 0.0 else 0.0
            f[i, 2 * s + 1] = force * contact[i, s, MZ] if force > 0.0 else 0.0
    stored, largest = roller_elements(v[balls:], contacts.rollers, contact[balls:], f[balls:], tiny)
    return energy + stored, max(scale, largest)


@kernel
def pair_balls(v: Array, contacts: BallContacts, contact: Array, f: Array) -> tuple[float, float]:
    """As ``full_balls`` for balls between two opposite arcs a and b, v (N, 2) the motion of a less that of b.

    The ball's centre lies on the line of the arcs' centres D + v, and the interference is its nominal value plus
    |D + v| - |D|; the two contacts are one law in series. pair (N, 7): D, |D|, nominal interference, C, e and h of
    both contacts together; contact (N, 5) as one contact on flank a.
    """
    pair = contacts.pair
    energy, scale = 0.0, 0.0
    for i in range(v.shape[0]):
        dx, dz, size0 = pair[i, 0], pair[i, 1], pair[i, 2]
        vx, vz = v[i, 0], v[i, 1]
        x, z = dx + vx, dz + vz
        size = sqrt(x * x + z * z)
        contact[i, FORCE] = 0.0
        f[i, 0], f[i, 1] = 0.0, 0.0
        if size <= 1e-30:
            continue
        delta = pair[i, 3] + (vx * (dx + x) + vz * (dz + z)) / (size + size0)
        contact[i, MX], contact[i, MZ] = -x / size, -z / size
        if delta > 0.0:
            force, slope, work = contact_law(delta, pair[i, 4], pair[i, 5], pair[i, 6])
            if force > contacts.tiny:
                energy += work
                scale = max(scale, force)
                contact[i, FORCE], contact[i, KN], contact[i, KT] = force, slope, force / size
                f[i, 0], f[i, 1] = force * contact[i, MX], force * contact[i, MZ]
    return energy, scale


@kernel
def evaluate_balls(v: Array, contacts: BallContacts, state: BodyState, f: Array) -> tuple[float, float]:
    """Forces of all balls at motions v, by ``pair_balls`` or ``full_balls``."""
    if v.shape[1] == 2:
        return pair_balls(v, contacts, state.contact[:, 0], f)
    return full_balls(v, contacts, state.inner, state.contact, f)


@kernel
def ball_rows(contacts: BallContacts, contact: Array, S: Array, counts: Array) -> int:
    """Rows S (N, 6 or 2, d) of all balls and rollers, and their numbers; returns the total."""
    total = 0
    d = S.shape[2]
    for i in range(S.shape[0]):
        if i >= contacts.r_ball.shape[0]:
            counts[i] = roller_rows(contact[i], S[i])
        elif d == 8:
            counts[i] = flank_rows(contact[i], contacts.local[i], S[i])
        elif contact[i, 0, FORCE] > 0.0:
            mx, mz = contact[i, 0, MX], contact[i, 0, MZ]
            kn, kt = sqrt(contact[i, 0, KN]), sqrt(contact[i, 0, KT])
            S[i, 0, 0], S[i, 0, 1] = kn * mx, kn * mz
            S[i, 1, 0], S[i, 1, 1] = -kt * mz, kt * mx
            counts[i] = 2
        else:
            counts[i] = 0
        total += counts[i]
    return total
