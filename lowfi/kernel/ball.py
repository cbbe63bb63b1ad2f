"""One ball in its grooves: its centre eliminated from the contact energy (2 x 2), for up to four contacts."""

from math import hypot, sqrt

import numpy as np

from lowfi.jit import kernel

from .contact import flank


@kernel
def start_centre(p, shift, offset, closure, C, use):  # type: ignore[no-untyped-def]
    """Starting centre: two-contact solutions of the diagonal pairs that close, else the mean shift of the flanks.

    With D = o_a - o_b between opposite groove centres the interference is its nominal value ``closure`` (2,) plus
    |D + v_a - v_b| - |D|, and the pair shares it as C_a : C_b (exact for circular flanks). Writes p (2,), relative to
    the nominal centre; returns how many pairs close.
    """
    count = 0
    x, z = 0.0, 0.0
    for a in range(2):
        b = 3 - a
        if not (use[a] and use[b]):
            continue
        dx, dz = offset[b, 0] - offset[a, 0], offset[b, 1] - offset[a, 1]
        vx, vz = shift[a, 0] - shift[b, 0], shift[a, 1] - shift[b, 1]
        dist0, dist = hypot(dx, dz), hypot(dx + vx, dz + vz)
        if dist <= 1e-30:
            continue
        total = closure[a] + (vx * (2.0 * dx + vx) + vz * (2.0 * dz + vz)) / (dist + dist0)
        if total > 0.0:
            # from b's groove centre along D + v by the size of w_b that gives b its share of the interference
            ex, ez = (dx + vx) / dist, (dz + vz) / dist
            more = total * C[b] / (C[a] + C[b]) - offset[b, 3]
            size = offset[b, 2]
            x += shift[b, 0] + ex * more + (ex * size - offset[b, 0])
            z += shift[b, 1] + ez * more + (ez * size - offset[b, 1])
            count += 1
    if count > 0:
        p[0], p[1] = x / count, z / count
        return count
    n = 0
    for s in range(4):
        if use[s]:
            x += shift[s, 0]
            z += shift[s, 1]
            n += 1
    p[0], p[1] = x / max(n, 1), z / max(n, 1)
    return 0


@kernel
def touch(p, shift, offset, r_ball, radius, profile, signs, C, use, force, normal, tangent):  # type: ignore[no-untyped-def]
    """Contact forces and stiffnesses with the ball's centre at p; returns the energy [J] (Lin 2.14 integrated).

    Fills force (4,) [N], normal (4, 2) (ball to groove), tangent (4, 2): F' = dF/d delta and F kt [N/m].
    """
    energy = 0.0
    for s in range(4):
        force[s], tangent[s, 0], tangent[s, 1] = 0.0, 0.0, 0.0
        if not use[s]:
            continue
        delta, mx, mz, kt = flank(
            p[0] - shift[s, 0],
            p[1] - shift[s, 1],
            offset[s],
            r_ball,
            radius[s],
            profile[s],
            signs[s, 0],
            signs[s, 1],
        )
        normal[s, 0], normal[s, 1] = mx, mz
        if delta > 0.0:
            x = delta / C[s]
            root = sqrt(x)
            force[s] = x * root
            energy += 0.4 * C[s] * x * x * root
            tangent[s, 0] = 1.5 * root / C[s]
            tangent[s, 1] = force[s] * kt
    return energy


@kernel
def newton_step(force, normal, tangent):  # type: ignore[no-untyped-def]
    """Newton step of the centre, slope along it, net force and largest force; zero step where singular."""
    gx, gz, hxx, hxz, hzz, scale = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for s in range(4):
        f = force[s]
        if f <= 0.0:
            continue
        mx, mz = normal[s, 0], normal[s, 1]
        kn, kt = tangent[s, 0], tangent[s, 1]
        gx += f * mx
        gz += f * mz
        hxx += kn * mx * mx + kt * mz * mz
        hzz += kn * mz * mz + kt * mx * mx
        hxz += (kn - kt) * mx * mz
        scale = max(scale, f)
    bump = 1e-14 * (hxx + hzz)
    hxx += bump
    hzz += bump
    det = hxx * hzz - hxz * hxz
    if det <= 0.0:
        return 0.0, 0.0, 0.0, hypot(gx, gz), scale
    sx, sz = -(hzz * gx - hxz * gz) / det, -(hxx * gz - hxz * gx) / det
    return sx, sz, gx * sx + gz * sz, hypot(gx, gz), scale


@kernel
def ball(p, shift, offset, closure, r_ball, radius, profile, signs, C, use, tiny, force, normal, tangent):  # type: ignore[no-untyped-def]
    """Equilibrium of one ball at given motions of its flanks: minimises its contact energy over its centre.

    shift (4, 2): motion of the flanks [m]; offset (4, 4): see ``contact.flank``; closure (2,): nominal interference of
    the diagonal pairs [m]; radius, C, use (4,): groove radii, Hertz constants, flanks that take part; tiny [N]: forces
    below it count as none. Fills p (2,) [m], force, normal, tangent (see ``touch``); returns the energy [J].
    The energy is convex for r_G >= r_B: the forces at the minimum are unique.
    """
    start_centre(p, shift, offset, closure, C, use)
    energy = touch(p, shift, offset, r_ball, radius, profile, signs, C, use, force, normal, tangent)
    trial = np.empty(2)
    best = 1e300
    for _ in range(100):
        sx, sz, slope, net, scale = newton_step(force, normal, tangent)
        if scale <= tiny or net <= 4e-16 * scale or slope == 0.0:
            break
        if net <= 1e-11 * scale and net >= 0.5 * best:
            break  # round-off floor
        best = min(best, net)
        t = 1.0
        new = energy
        for _ in range(40):
            trial[0], trial[1] = p[0] + t * sx, p[1] + t * sz
            new = touch(trial, shift, offset, r_ball, radius, profile, signs, C, use, force, normal, tangent)
            if new <= energy + 1e-4 * t * slope or abs(t * slope) <= 1e-13 * energy:
                break
            t *= 0.5
        p[0], p[1], energy = trial[0], trial[1], new
    return energy


@kernel
def reduced_hessian(force, normal, tangent, out):  # type: ignore[no-untyped-def]
    """Hessian of the ball's energy by the motion of its screw flanks, its centre eliminated: out (4, 4) [N/m].

    With h_s = F' m m^T + F kt t t^T and H their sum: -h_s H^-1 h_t off the diagonal and h_s H^-1 (H - h_s) on it
    (the others summed, not subtracted: no cancellation). Order SL x, SL z, SR x, SR z.
    """
    out[:, :] = 0.0
    h = np.zeros((4, 3))
    for s in range(4):
        if force[s] > 0.0:
            mx, mz = normal[s, 0], normal[s, 1]
            kn, kt = tangent[s, 0], tangent[s, 1]
            h[s, 0] = kn * mx * mx + kt * mz * mz
            h[s, 1] = (kn - kt) * mx * mz
            h[s, 2] = kn * mz * mz + kt * mx * mx
    txx, txz, tzz = h[:, 0].sum(), h[:, 1].sum(), h[:, 2].sum()
    det = txx * tzz - txz * txz
    if det <= 0.0:
        return
    ixx, ixz, izz = tzz / det, -txz / det, txx / det
    for s in range(2):
        a00 = h[s, 0] * ixx + h[s, 1] * ixz
        a01 = h[s, 0] * ixz + h[s, 1] * izz
        a10 = h[s, 1] * ixx + h[s, 2] * ixz
        a11 = h[s, 1] * ixz + h[s, 2] * izz
        for t in range(2):
            sign = -1.0
            bxx, bxz, bzz = h[t, 0], h[t, 1], h[t, 2]
            if s == t:
                sign = 1.0
                bxx, bxz, bzz = 0.0, 0.0, 0.0
                for r in range(4):
                    if r != s:
                        bxx += h[r, 0]
                        bxz += h[r, 1]
                        bzz += h[r, 2]
            out[2 * s, 2 * t] = sign * (a00 * bxx + a01 * bxz)
            out[2 * s, 2 * t + 1] = sign * (a00 * bxz + a01 * bzz)
            out[2 * s + 1, 2 * t] = sign * (a10 * bxx + a11 * bxz)
            out[2 * s + 1, 2 * t + 1] = sign * (a10 * bxz + a11 * bzz)
