"""Friction of one elliptical contact that slides along the track and spins."""

from math import sqrt

from rollbench.lowfi.friction.linear.records import Array
from rollbench.lowfi.jit import kernel


@kernel
def slide_and_spin(s: float, w: float, shape: Array, nodes: Array) -> tuple[float, float, float, float, float]:
    """Friction of one elliptical contact sliding at s along its minor axis and spinning at w / a, per unit bound.

    shape: (b2/a2, q0, k1, k3) of ``contact_shape``; nodes: squared sines and weights, ``(2, m)``. Returns force and
    moment / a (gradient of the dissipation phi = s f + w m, a norm), phi, and (h, side): the Hessian is h n n^T with
    n = (kappa, -1) outside the ellipse (side 1, kappa = w/s), n = (1, -t) inside it (side 0, t = s/w).
    """
    size_s, size_w = abs(s), abs(w)
    if size_s + size_w == 0.0:
        return 0.0, 0.0, 0.0, 0.0, -1.0
    sign_s = 1.0 if s > 0.0 else -1.0
    sign_w = 1.0 if w > 0.0 else -1.0
    if size_s < size_w:
        t = s / w
        t2 = t * t
        f = sign_w * t * (shape[2] - shape[3] * t2)
        m = sign_w * (shape[1] - t2 * (0.5 * shape[2] - 0.75 * shape[3] * t2))
        return f, m, s * f + w * m, (shape[2] - 3.0 * shape[3] * t2) / size_w, 0.0
    kappa = w / s
    k2, flat = kappa * kappa, 1.0 - shape[0]
    force, moment, bend = 0.0, 0.0, 0.0
    for i in range(nodes.shape[1]):
        y2, weight = nodes[0, i], nodes[1, i]
        top, bottom = 1.0 - k2 * y2, 1.0 - flat * k2 * y2
        ratio = sqrt(top / bottom)
        term = weight * (1.0 - y2)
        force += term * ratio
        term *= ratio / (top * bottom)
        moment += term * (1.0 - y2)
        bend += term * y2
    f = sign_s * 1.5 * force
    m = sign_s * kappa * 0.375 * shape[0] * moment
    return f, m, s * f + w * m, 1.5 * shape[0] * bend / size_s, 1.0


@kernel
def regularised(
    s: float, w: float, shape: Array, nodes: Array, eps: float
) -> tuple[float, float, float, float, float, float]:
    """Energy sqrt(phi2 + eps2) - eps per unit bound, its gradient (2) and Hessian (3: ss, sw, ww) by (s, w).

    Convex; the force is phi / sqrt(phi2 + eps2) times Coulomb's, so contacts stick at creeping speeds below eps.
    """
    f, m, phi, h, side = slide_and_spin(s, w, shape, nodes)
    eta = sqrt(phi * phi + eps * eps)
    if side < 0.0:
        return 0.0, 0.0, 0.0, 1.0 / eps, 0.0, shape[1] * shape[1] / eps
    n_s, n_w = 1.0, 0.0
    if side > 0.5:
        n_s, n_w = w / s, -1.0
    else:
        n_w = -s / w
    a = phi / eta * h
    b = (eps / eta) * (eps / eta) / eta
    c = phi / eta
    return (
        phi * phi / (eta + eps),
        c * f,
        c * m,
        a * n_s * n_s + b * f * f,
        a * n_s * n_w + b * f * m,
        a * n_w * n_w + b * m * m,
    )
