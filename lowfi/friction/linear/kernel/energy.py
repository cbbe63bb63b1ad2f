"""Dissipation of a chain of balls, its gradient and banded Hessian.

Velocities are in units of the carriage's speed, forces in units of the largest friction bound of a ball. Unknowns of a
ball: axial velocity and ball radius times the two spin components across the track, x = (v, R omega_x, R omega_y).
"""

from rollbench.lowfi.friction.linear.records import Array, ChainArrays, ChainState
from rollbench.lowfi.jit import kernel

from .band import HALF
from .law import regularised


@kernel
def add_contacts(chain: ChainArrays, state: ChainState, eps: float, K: Array, g: Array) -> float:
    """Contacts' part of energy, gradient g ``(4N,)`` and banded Hessian K ``(4N, 11)``."""
    contacts, shapes, nodes, slip = chain.contacts, chain.shapes, chain.nodes, state.slip
    energy = 0.0
    for j in range(contacts.shape[0]):
        for i in range(contacts.shape[1]):
            bound = contacts[j, i, 3]
            if bound == 0.0:
                continue
            s, w = slip[j, i, 0], slip[j, i, 1]
            e, f, m, ss, sw, ww = regularised(s, w, shapes[j, i], nodes, eps)
            energy += bound * e
            nx, ny, arm = contacts[j, i, 0], contacts[j, i, 1], contacts[j, i, 4]
            rows = ((1.0, 0.0), (ny, arm * nx), (-nx, arm * ny))
            for k in range(3):
                a, b = rows[k]
                g[4 * j + k] += bound * (a * f + b * m)
                left, right = a * ss + b * sw, a * sw + b * ww
                for q in range(3):
                    c, d = rows[q]
                    K[4 * j + k, HALF + q - k] += bound * (left * c + right * d)
    return energy


@kernel
def assemble(chain: ChainArrays, state: ChainState, eps: float, lam: Array, rho: float, K: Array, g: Array) -> float:
    """Convex energy without friction between balls, its gradient g ``(4N,)`` and the banded matrix of Newton's step.

    The order of the velocities enters by its augmented Lagrangian, multipliers lam and penalty rho.
    """
    drift, closed, hold = state.drift, chain.closed, chain.hold
    K[:] = 0.0
    g[:] = 0.0
    energy = 0.0
    for j in range(drift.shape[0]):
        for k in range(3):
            energy += 0.5 * hold[j] * drift[j, k] * drift[j, k]
            g[4 * j + k] = hold[j] * drift[j, k]
            K[4 * j + k, HALF] = hold[j]
        K[4 * j + 3, HALF] = -1.0
    energy += add_contacts(chain, state, eps, K, g)
    for k in range(closed.shape[0]):
        i = 4 * k + 3
        push = lam[k] + rho * state.pair[k, 0]
        if closed[k] == 0.0 or push <= 0.0:
            continue
        energy += 0.5 * push * push / rho
        g[i - 3] += push
        g[i + 1] -= push
        K[i, HALF] = -1.0 / rho
        K[i, HALF - 3] = 1.0
        K[i, HALF + 1] = -1.0
        K[i - 3, HALF + 3] = 1.0
        K[i + 1, HALF - 1] = -1.0
    return energy


@kernel
def rebuild(chain: ChainArrays, state: ChainState) -> None:
    """Slips and differences of neighbours from the drift of the motion."""
    contacts, nominal = chain.contacts, chain.nominal
    slip, pair, drift = state
    for j in range(contacts.shape[0]):
        v, p, q = nominal[j, 0] + drift[j, 0], nominal[j, 1] + drift[j, 1], nominal[j, 2] + drift[j, 2]
        for i in range(contacts.shape[1]):
            nx, ny = contacts[j, i, 0], contacts[j, i, 1]
            slip[j, i, 0] = v + ny * p - nx * q - contacts[j, i, 2]
            slip[j, i, 1] = contacts[j, i, 4] * (nx * p + ny * q)
        if j > 0:
            pair[j - 1, 0] = nominal[j - 1, 0] + drift[j - 1, 0] - v
            pair[j - 1, 1] = nominal[j - 1, 1] + drift[j - 1, 1] + p
            pair[j - 1, 2] = nominal[j - 1, 2] + drift[j - 1, 2] + q


@kernel
def move(chain: ChainArrays, state: ChainState, step: Array, t: float) -> None:
    """Add t times the step ``(4N,)`` of the unknowns to everything that depends on them."""
    contacts = chain.contacts
    slip, pair, drift = state
    for j in range(contacts.shape[0]):
        dv, dp, dq = t * step[4 * j], t * step[4 * j + 1], t * step[4 * j + 2]
        drift[j, 0] += dv
        drift[j, 1] += dp
        drift[j, 2] += dq
        for i in range(contacts.shape[1]):
            nx, ny = contacts[j, i, 0], contacts[j, i, 1]
            slip[j, i, 0] += dv + ny * dp - nx * dq
            slip[j, i, 1] += contacts[j, i, 4] * (nx * dp + ny * dq)
        if j > 0:
            pair[j - 1, 0] -= dv
            pair[j - 1, 1] += dp
            pair[j - 1, 2] += dq
        if j < contacts.shape[0] - 1:
            pair[j, 0] += dv
            pair[j, 1] += dp
            pair[j, 2] += dq
