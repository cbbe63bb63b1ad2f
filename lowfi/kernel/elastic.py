"""Static equilibrium with elastic bodies: Newton on the contact forces, the bodies' compliance between all contacts given.

The flanks move by v = v_0 + G phi + R a: G the compliance of the bodies, R motions that nothing but the contacts resists.
Every ball takes the forces f(v) on its flanks; at the solution phi = f(v). With the stiffness S^T S of all balls, factored
ball by ball, a step solves (I + S G S^T) u = S (G (f - phi) + R da), R^T (f - S^T u) + work = 0: Newton on the convex
energy phi G phi/2 - work a + balls(v), whose unknowns never are the beam's nodes.

A ball has its centre and one amplitude of its own body for unknowns, eliminated inside, and every contact a linear part
e F beside Hertz's C F^(2/3). Where only two opposite flanks carry load, a ball knows their relative motion alone, and has a
closed form.
"""
from math import sqrt

import numpy as np

from lowfi.jit import kernel

from .arrays import Array, Arrays, Contacts
from .ball import FORCE, HERTZ, KN, KT, MX, MZ, USE, meet, start_centre
from .newton import CONVERGED, ITERATIONS, NOT_HELD, SINGULAR

LINEAR, BODY = range(2)


@kernel
def contact_law(delta: float, c: float, e: float) -> tuple[float, float, float]:
    """Force [N], its slope [N/m] and energy [J] of delta = C F^(2/3) + e F [m], delta > 0.

    A negative e (bodies stiffer than half spaces) would bend the law back at F = (2 C/3 e)^3; from an eighth of that force
    on the law goes on as C F^(2/3)/2 plus a constant, so that force and slope stay continuous and the energy convex.
    """
    x = sqrt(delta / c)
    if e < 0.0:
        limit = -c / (3.0 * e)
        edge = 2.0 / 3.0 * c * limit * limit
        if delta > edge:
            x = sqrt(limit * limit + 2.0 * (delta - edge) / c)
            below = c * limit**5 * (2.0 / 5.0 - 1.0 / 6.0)
            return x * x * x, 3.0 * x / c, below + 0.2 * c * (x**5 - limit**5)
    if e != 0.0:
        for _ in range(50):
            f = x * x * (c + e * x) - delta
            step = f / (x * (2.0 * c + 3.0 * e * x))
            x -= step
            if abs(step) <= 1e-16 * x:
                break
    fifth = x * x * x * x * x
    return x * x * x, 3.0 * x / (2.0 * c + 3.0 * e * x), fifth * (0.4 * c + 0.5 * e * x)


@kernel
def press(
    x: Array, shift: Array, geometry: Array, local: Array, r_ball: float, profile: Array, contact: Array,
) -> float:  # fmt: skip
    """Contact forces and stiffnesses with centre and amplitude x (3,); returns the energy [J]. local (4, 2): e [m/N] of
    each contact and what a unit amplitude takes from its approach [m]."""
    energy: float = 0.5 * x[2] * x[2]
    for s in range(4):
        contact[s, FORCE] = 0.0
        if geometry[s, USE] == 0.0:
            continue
        delta, mx, mz, kt = meet(x[0] - shift[s, 0], x[1] - shift[s, 1], geometry[s], r_ball, profile[s])
        contact[s, MX], contact[s, MZ] = mx, mz
        delta -= local[s, BODY] * x[2]
        if delta > 0.0:
            force, slope, work = contact_law(delta, geometry[s, HERTZ], local[s, LINEAR])
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
    x: Array, shift: Array, geometry: Array, closure: Array, local: Array, r_ball: float, profile: Array, tiny: float,
    contact: Array, work: Array,
) -> float:  # fmt: skip
    """Equilibrium of one ball at given motions of its flanks (4, 2): fills x (3,) and ``contact``; returns the energy [J].

    work (5, 3): scratch. See ``ball.settle``, of which this is the form with a body of its own.
    """
    H, g, trial = work[:3], work[3], work[4]
    start_centre(x, shift, geometry, closure)
    x[2] = 0.0
    energy = press(x, shift, geometry, local, r_ball, profile, contact)
    best = 1e300
    for _ in range(100):
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
        t, new = 1.0, energy
        ox, oz, oy = x[0], x[1], x[2]
        for _ in range(40):
            x[0], x[1], x[2] = ox + t * sx, oz + t * sz, oy + t * sy
            new = press(x, shift, geometry, local, r_ball, profile, contact)
            if new <= energy + 1e-4 * t * slope or abs(t * slope) <= 1e-13 * energy:
                break
            t *= 0.5
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
        for part in range(2):
            k = sqrt(contact[s, KN] if part == 0 else contact[s, KT])
            dx, dz = (mx, mz) if part == 0 else (-mz, mx)
            A[n, 0], A[n, 1] = k * dx, k * dz
            A[n, 2] = -k * local[s, BODY] if part == 0 else 0.0
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
def full_balls(v: Array, contacts: Contacts, inner: Array, contact: Array, f: Array, tiny: float) -> tuple[float, float]:
    """Forces f (N, 8) of all balls on their flanks at motions v (N, 8); returns energy and the largest contact force.

    contacts = (geometry, closure, local, r_ball, profile, pair); fills inner (N, 3) and contact (N, 4, 5).
    """
    geometry, closure, local, r_ball, profile = contacts[0], contacts[1], contacts[2], contacts[3], contacts[4]
    energy, scale = 0.0, 0.0
    work = np.empty((5, 3))
    for i in range(v.shape[0]):
        energy += rest(
            inner[i], v[i].reshape(4, 2), geometry[i], closure[i], local[i], r_ball[i], profile, tiny, contact[i], work
        )  # fmt: skip
        for s in range(4):
            force = contact[i, s, FORCE]
            scale = max(scale, force)
            f[i, 2 * s] = force * contact[i, s, MX] if force > 0.0 else 0.0
            f[i, 2 * s + 1] = force * contact[i, s, MZ] if force > 0.0 else 0.0
    return energy, scale


@kernel
def pair_balls(v: Array, contacts: Contacts, contact: Array, f: Array, tiny: float) -> tuple[float, float]:
    """As ``full_balls`` for balls between two opposite arcs a and b, v (N, 2) the motion of a less that of b.

    The ball's centre lies on the line of the arcs' centres D + v, and the interference is its nominal value plus
    |D + v| - |D|; the two contacts are one law in series. pair (N, 6): D, |D|, nominal interference, C and e of both
    contacts together; contact (N, 5) as one contact on flank a.
    """
    pair = contacts[5]
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
            force, slope, work = contact_law(delta, pair[i, 4], pair[i, 5])
            if force > tiny:
                energy += work
                scale = max(scale, force)
                contact[i, FORCE], contact[i, KN], contact[i, KT] = force, slope, force / size
                f[i, 0], f[i, 1] = force * contact[i, MX], force * contact[i, MZ]
    return energy, scale


@kernel
def evaluate_balls(v: Array, contacts: Contacts, state: Arrays, f: Array, tiny: float) -> tuple[float, float]:
    """Forces of all balls at motions v, by ``pair_balls`` or ``full_balls``; state = (phi, a, inner, contact)."""
    if v.shape[1] == 2:
        return pair_balls(v, contacts, state[3][:, 0], f, tiny)
    return full_balls(v, contacts, state[2], state[3], f, tiny)


@kernel
def ball_rows(contacts: Contacts, contact: Array, S: Array, counts: Array) -> int:
    """Rows S (N, 6 or 2, d) of all balls and their numbers; returns the total."""
    total = 0
    d = S.shape[2]
    for i in range(S.shape[0]):
        if d == 8:
            counts[i] = flank_rows(contact[i], contacts[2][i], S[i])
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


@kernel
def body_motion(bodies: Arrays, phi: Array, out: Array) -> None:
    """out (N, d) = G phi: first and second body act on the first and second half of the flanks (one body: on all)."""
    first, second = bodies[0], bodies[1]
    n, d = phi.shape
    if second.shape[0] == 0:
        out.ravel()[:] = np.dot(first, phi.ravel())
        return
    h = d // 2
    out[:, :h] = np.dot(first, np.ascontiguousarray(phi[:, :h]).ravel()).reshape(n, h)
    out[:, h:] = np.dot(second, np.ascontiguousarray(phi[:, h:]).ravel()).reshape(n, h)


@kernel
def couple(bodies: Arrays, S: Array, counts: Array, starts: Array, M: Array) -> None:
    """Lower triangle of M (q, q) = I + S G S^T."""
    first, second = bodies[0], bodies[1]
    balls, _, d = S.shape
    if d == 2:
        couple_pairs(first, S, counts, starts, M)
        return
    h = d if second.shape[0] == 0 else d // 2
    part = np.empty((S.shape[1], d))
    for i in range(balls):
        for j in range(i + 1):
            for p in range(counts[i]):
                for b in range(h):
                    total = 0.0
                    for a in range(h):
                        total += S[i, p, a] * first[h * i + a, h * j + b]
                    part[p, b] = total
                for b in range(d - h):
                    total = 0.0
                    for a in range(h):
                        total += S[i, p, h + a] * second[h * i + a, h * j + b]
                    part[p, h + b] = total
            for p in range(counts[i]):
                for r in range(counts[j]):
                    total = 0.0
                    for b in range(d):
                        total += part[p, b] * S[j, r, b]
                    M[starts[i] + p, starts[j] + r] = total
    for k in range(M.shape[0]):
        M[k, k] += 1.0


@kernel
def couple_pairs(G: Array, S: Array, counts: Array, starts: Array, M: Array) -> None:
    """The same for balls between two flanks: up to two rows of two entries each."""
    for i in range(S.shape[0]):
        for p in range(counts[i]):
            row = starts[i] + p
            a, b = S[i, p, 0], S[i, p, 1]
            for j in range(i + 1):
                x = a * G[2 * i, 2 * j] + b * G[2 * i + 1, 2 * j]
                z = a * G[2 * i, 2 * j + 1] + b * G[2 * i + 1, 2 * j + 1]
                for r in range(counts[j]):
                    M[row, starts[j] + r] = x * S[j, r, 0] + z * S[j, r, 1]
            M[row, row] += 1.0


@kernel
def cholesky_lower(M: Array) -> bool:
    """Overwrite M (its lower triangle given) by its Cholesky factor (LAPACK); False where M is not positive definite."""
    try:
        M[:, :] = np.linalg.cholesky(M)
    except Exception:  # the only one that numba can name; LinAlgError is all that a finite matrix can raise
        return False
    return True


@kernel
def triangular(M: Array, b: Array) -> None:
    """Overwrite b by (L L^T)^-1 b, L in the lower triangle of M."""
    n = b.shape[0]
    for j in range(n):
        v = b[j]
        for k in range(j):
            v -= M[j, k] * b[k]
        b[j] = v / M[j, j]
    for j in range(n - 1, -1, -1):
        b[j] /= M[j, j]
        v = b[j]
        for k in range(j):
            b[k] -= v * M[j, k]


@kernel
def apply_rows(S: Array, counts: Array, starts: Array, x: Array, out: Array) -> None:
    """out (q,) = S x for motions x (N, d)."""
    for i in range(S.shape[0]):
        for p in range(counts[i]):
            total = 0.0
            for a in range(S.shape[2]):
                total += S[i, p, a] * x[i, a]
            out[starts[i] + p] = total


@kernel
def forces_of_rows(S: Array, counts: Array, starts: Array, u: Array, out: Array) -> None:
    """out (N, d) -= S^T u."""
    for i in range(S.shape[0]):
        for p in range(counts[i]):
            for a in range(S.shape[2]):
                out[i, a] -= S[i, p, a] * u[starts[i] + p]


@kernel
def newton_forces(
    bodies: Arrays, contacts: Contacts, state: Arrays, f: Array, hold: float, fresh: bool, cache: Arrays, out: Arrays,
) -> bool:  # fmt: skip
    """Step of forces and free motions: out = (dphi (N, d), dv (N, d), da (k,)); False where the matrix is not positive.

    bodies = (G first, G second, R (N, d, k), v0 (N, d), work (k,)); hold [N/m]: stiffness that keeps free motions from
    running away where no contact holds them; fresh: factor anew, else use the factor in ``cache`` = (M, S, counts, starts).
    """
    R, work = bodies[2], bodies[4]
    phi = state[0]
    dphi, dv, da = out
    M, S, counts, starts = cache
    k = R.shape[2]
    total = 0
    if fresh:
        total = ball_rows(contacts, state[3], S, counts)
        first = 0
        for i in range(S.shape[0]):
            starts[i] = first
            first += counts[i]
        couple(bodies, S, counts, starts, M[: total * total].reshape(total, total))
        if not cholesky_lower(M[: total * total].reshape(total, total)):
            return False
    else:
        total = starts[-1] + counts[-1]
    L = M[: total * total].reshape(total, total)
    for i in range(phi.shape[0]):
        for a in range(phi.shape[1]):
            dphi[i, a] = f[i, a] - phi[i, a]
    body_motion(bodies, dphi, dv)
    u = np.empty(total)
    apply_rows(S, counts, starts, dv, u)
    triangular(L, u)
    if k:
        Z = np.empty((k, total))
        schur, rhs = np.zeros((k, k)), np.empty(k)
        plain = np.empty((k, total))
        for c in range(k):
            apply_rows(S, counts, starts, R[:, :, c], plain[c])
            Z[c] = plain[c]
            triangular(L, Z[c])
            rhs[c] = work[c] - np.sum(plain[c] * u)
            for i in range(f.shape[0]):
                for a in range(f.shape[1]):
                    rhs[c] += R[i, a, c] * f[i, a]
        for c in range(k):
            for e in range(k):
                schur[c, e] = np.sum(plain[c] * Z[e])
            schur[c, c] += hold
        if not cholesky_lower(schur):
            return False
        triangular(schur, rhs)
        for c in range(k):
            da[c] = rhs[c]
            for i in range(total):
                u[i] += rhs[c] * Z[c, i]
    forces_of_rows(S, counts, starts, u, dphi)
    body_motion(bodies, dphi, dv)
    for i in range(dv.shape[0]):
        for a in range(dv.shape[1]):
            for c in range(k):
                dv[i, a] += R[i, a, c] * da[c]
    return True


@kernel
def mismatch(bodies: Arrays, phi: Array, f: Array, arms: Array, scale: float) -> float:
    """Largest difference of assumed and true flank forces, and unbalanced load on a free motion, over ``scale`` [N]."""
    R, work = bodies[2], bodies[4]
    worst = 0.0
    for i in range(f.shape[0]):
        for a in range(f.shape[1]):
            worst = max(worst, abs(f[i, a] - phi[i, a]))
    for c in range(R.shape[2]):
        total = work[c]
        for i in range(f.shape[0]):
            for a in range(f.shape[1]):
                total += R[i, a, c] * f[i, a]
        worst = max(worst, abs(total) * arms[c])
    return worst / scale if scale > 0.0 else worst


@kernel
def slope_of(bodies: Arrays, f: Array, g: Array, step: Arrays) -> float:
    """Directional derivative of the energy at forces f of the balls and body motions g = G phi."""
    dphi, dv, da = step
    total = 0.0
    for i in range(f.shape[0]):
        for a in range(f.shape[1]):
            total += dphi[i, a] * g[i, a] - f[i, a] * dv[i, a]
    for c in range(da.shape[0]):
        total -= bodies[4][c] * da[c]
    return total


@kernel
def shift_state(bodies: Arrays, state: Arrays, begin: Arrays, step: Arrays, t: float, g: Array, v: Array) -> None:
    """State, body motions g and flank motions v at ``begin`` = (phi, a, g, v) plus t times the step."""
    dphi, dv, da = step
    R = bodies[2]
    phi, amplitude = state[0], state[1]
    for c in range(da.shape[0]):
        amplitude[c] = begin[1][c] + t * da[c]
    for i in range(dv.shape[0]):
        for a in range(dv.shape[1]):
            phi[i, a] = begin[0][i, a] + t * dphi[i, a]
            v[i, a] = begin[3][i, a] + t * dv[i, a]
            own = dv[i, a]
            for c in range(da.shape[0]):
                own -= R[i, a, c] * da[c]
            g[i, a] = begin[2][i, a] + t * own


@kernel
def stored(bodies: Arrays, state: Arrays, g: Array) -> float:
    """Energy of the bodies less the work of the loads on the free motions."""
    phi, amplitude = state[0], state[1]
    total = 0.0
    for i in range(phi.shape[0]):
        for a in range(phi.shape[1]):
            total += 0.5 * phi[i, a] * g[i, a]
    for c in range(amplitude.shape[0]):
        total -= bodies[4][c] * amplitude[c]
    return total


@kernel
def search_forces(
    bodies: Arrays, contacts: Contacts, state: Arrays, f: Array, g: Array, v: Array, step: Arrays, energy: float,
    slope: float, tiny: float,
) -> tuple[float, float, int]:  # fmt: skip
    """Step length along a step, as ``newton.line_search``; state, f, g and v are left at the accepted point."""
    begin = (state[0].copy(), state[1].copy(), g.copy(), v.copy())
    low, high, t = 0.0, 0.0, 1.0
    new, scale = energy, 0.0
    evaluations = 0
    while evaluations < 60:
        shift_state(bodies, state, begin, step, t, g, v)
        own, scale = evaluate_balls(v, contacts, state, f, tiny)
        new = own + stored(bodies, state, g)
        evaluations += 1
        ahead = slope_of(bodies, f, g, step)
        if ahead > 0.0:
            if ahead <= 0.5 * abs(slope) and new <= energy:
                break
            if new <= energy + 1e-4 * t * slope and ahead <= 0.9 * abs(slope):
                break
            high = t
            t = low + (0.5 if low > 0.0 else 0.35) * (high - low)
        else:
            if ahead >= 0.9 * slope or high > 0.0 or t > 1e12:
                break
            low = t
            t *= 4.0
    return new, scale, evaluations


@kernel
def place_flanks(bodies: Arrays, state: Arrays, g: Array, v: Array) -> None:
    """Fill g = G phi and v = v0 + g + R a from the state."""
    R, v0 = bodies[2], bodies[3]
    body_motion(bodies, state[0], g)
    for i in range(v.shape[0]):
        for a in range(v.shape[1]):
            v[i, a] = v0[i, a] + g[i, a]
            for c in range(R.shape[2]):
                v[i, a] += R[i, a, c] * state[1][c]


@kernel
def solve_forces(
    bodies: Arrays, contacts: Contacts, state: Arrays, options: Array, arms: Array, history: Array,
) -> tuple[int, int, int, float, float, float]:  # fmt: skip
    """Minimise the energy from the given forces; returns status, iterations, evaluations, residual, energy, scale.

    state = (phi (N, d) [N], a (k,), inner (N, 3), contact (N, 4 or 1, 5)); options (6,): tolerance, largest number of
    iterations, reference stiffness [N/m], force [N] below which a contact carries none, largest free motion [m] before the
    screw counts as not held, least force [N] that residuals are measured by. arms (k,): see `lowfi.compliance.shaft`.
    """
    tolerance, most, stiffness, tiny, bound, floor = (
        options[0], int(options[1]), options[2], options[3], options[4], options[5],
    )  # fmt: skip
    phi, amplitude = state[0], state[1]
    balls, d = phi.shape
    f, g, v = np.empty((balls, d)), np.empty((balls, d)), np.empty((balls, d))
    step = (np.empty((balls, d)), np.empty((balls, d)), np.zeros(amplitude.shape[0]))
    width = 2 if d == 2 else 6
    counts, starts = np.zeros(balls, dtype=np.int64), np.zeros(balls, dtype=np.int64)
    cache = (np.empty((width * balls) ** 2), np.zeros((balls, width, d)), counts, starts)
    place_flanks(bodies, state, g, v)
    own, scale = evaluate_balls(v, contacts, state, f, tiny)
    energy = own + stored(bodies, state, g)
    if floor == 0.0:
        floor = 1e-3 * scale
    scale = max(scale, floor)
    residual = mismatch(bodies, phi, f, arms, scale)
    history[0] = residual
    evaluations, stalled, factor, best = 1, 0, 1e-3, residual
    status, it, fresh = ITERATIONS, 0, True
    if residual <= tolerance:
        return CONVERGED, 0, 1, residual, energy, scale
    for it in range(1, most + 1):
        solved = False
        for _ in range(12):
            hold = factor * stiffness * min(1.0, residual)
            solved = newton_forces(bodies, contacts, state, f, hold, fresh, cache, step)
            if solved:
                break
            factor *= 100.0
            fresh = True
        if not solved:
            status = SINGULAR
            break
        if residual < 1e-7:
            begin = (phi.copy(), amplitude.copy(), g.copy(), v.copy())
            shift_state(bodies, state, begin, step, 1.0, g, v)
            own, scale = evaluate_balls(v, contacts, state, f, tiny)
            energy = own + stored(bodies, state, g)
            evaluations += 1
        else:
            slope = slope_of(bodies, f, g, step)
            energy, scale, used = search_forces(bodies, contacts, state, f, g, v, step, energy, slope, tiny)
            evaluations += used
        scale = max(scale, floor)
        residual = mismatch(bodies, phi, f, arms, scale)
        history[it] = residual
        factor = max(1e-3, factor * 0.1)
        if residual <= tolerance:
            status = CONVERGED
            break
        moved = 0.0
        for c in range(amplitude.shape[0]):
            moved = max(moved, abs(amplitude[c]) / arms[c])
        if moved > bound:
            status = NOT_HELD
            break
        stalled = stalled + 1 if residual >= 0.5 * best else 0
        best = min(best, residual)
        if stalled >= 2 and residual <= 1e-9:
            break
        fresh = residual > 1e-7 or stalled > 0
    place_flanks(bodies, state, g, v)
    evaluate_balls(v, contacts, state, f, tiny)
    return status, it, evaluations, residual, energy, scale


@kernel
def start_forces(bodies: Arrays, state: Arrays, springs: Array, options: Array) -> bool:
    """Start of the iteration: the bodies on one linear spring between opposite flanks in place of two contacts.

    springs (N, w, d): rows sqrt(stiffness) x direction, zero where there is none. Overwrites phi and a.
    """
    phi, amplitude = state[0], state[1]
    balls, width = springs.shape[0], springs.shape[1]
    R, v0, work = bodies[2], bodies[3], bodies[4]
    counts, starts = np.full(balls, width, dtype=np.int64), np.zeros(balls, dtype=np.int64)
    for i in range(balls):
        starts[i] = width * i
    M = np.empty((width * balls, width * balls))
    couple(bodies, springs, counts, starts, M)
    if not cholesky_lower(M):
        return False
    u = np.empty(width * balls)
    apply_rows(springs, counts, starts, v0, u)
    triangular(M, u)
    k = R.shape[2]
    if k:
        Z, plain = np.empty((k, u.shape[0])), np.empty((k, u.shape[0]))
        schur, rhs = np.zeros((k, k)), np.empty(k)
        for c in range(k):
            apply_rows(springs, counts, starts, R[:, :, c], plain[c])
            Z[c] = plain[c]
            triangular(M, Z[c])
            rhs[c] = work[c] - np.sum(plain[c] * u)
        for c in range(k):
            for e in range(k):
                schur[c, e] = np.sum(plain[c] * Z[e])
            schur[c, c] += 1e-9 * options[2]
        if not cholesky_lower(schur):
            return False
        triangular(schur, rhs)
        for c in range(k):
            amplitude[c] = rhs[c]
            for i in range(u.shape[0]):
                u[i] += rhs[c] * Z[c, i]
    phi[:, :] = 0.0
    forces_of_rows(springs, counts, starts, u, phi)
    return True
