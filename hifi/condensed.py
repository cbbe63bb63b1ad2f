"""What a prepared geometry tells a low-order model: compliance of its bodies along the contact normals.

Every contact's force is spread like Hertz's pressure over its nodes, and the matrices are for one force. What a contact's
own approach has beside them and Hertz's law is sampled over the forces that its patch can carry: the fine patches of
groove and ball, sockets held, solved as contact, and how the rest of both bodies answers a smaller or larger ellipse.
Pressures are hats on half cells and gaps their weighted means; every force is solved at four places a quarter of a cell
beside the nodes, whose waves cancel: 0.1 % of the approach are left, where forces on nodes leave 1 to 2 %.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from hifi.hertz import HertzSolution, hertz
from hifi.pressures import mean_weights
from meshes.condensed import CondensedBodies, geometry_digest

if TYPE_CHECKING:
    from hifi.setup import Setup

Array = NDArray[np.float64]

#: Number of forces at which a contact's own approach is sampled; part of its zone that the largest ellipse fills; least
#: short semi-axis over the cell, and over the largest one where that asks for more.
SAMPLES, FILLED, COARSEST, LEAST = 16, 0.85, 1.0, 0.6
#: Places of the contact beside the middle node, in half cells: odd quarters of a cell on either side.
PLACES = ((0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75))


def relative_radii(setup: Setup, side: int) -> tuple[float, float]:
    """Relative radii [m] of ball and groove across and along it, by the normal curvatures of the helical groove."""
    m = setup.map
    part = m.signs[side, 0] * np.cos(m.beta)
    along = part * np.cos(m.alpha) ** 2 / (m.R + part * m.ball)
    return 1.0 / (1.0 / m.ball - 1.0 / float(m.radius[side])), 1.0 / (1.0 / m.ball - along)


def unit_hertz(setup: Setup, side: int) -> HertzSolution:
    """Hertz's contact of a side under 1 N; approach as F^(2/3), semi-axes across and along the groove as F^(1/3)."""
    material = setup.scene.balls.material
    return hertz(1.0, *relative_radii(setup, side), material.youngs_modulus, material.poissons_ratio)


def spread(setup: Setup, side: int, load: float) -> Array:
    """Forces on a side's contact nodes ``(c,)`` like Hertz's pressure under ``load`` [N], of unit resultant."""
    m, material = setup.map, setup.scene.balls.material
    found = hertz(load, *relative_radii(setup, side), material.youngs_modulus, material.poissons_ratio)
    normal, tangent, forward = frame(setup, side)
    groove = setup.patches[side].groove
    x = groove.points - np.array([m.R, 0.0, 0.0]) - m.ball * normal
    force = found.pressure(x @ tangent, x @ forward) * groove.areas
    return np.asarray(force / (force @ (mean_weights(groove.weights) @ (groove.normals @ normal))))


def frame(setup: Setup, side: int) -> tuple[Array, Array, Array]:
    """Nominal normal (ball to groove), tangent across the groove, direction along it."""
    m = setup.map
    radial = np.array([1.0, 0.0, 0.0])
    binormal = np.array([0.0, -np.sin(m.alpha), np.cos(m.alpha)])
    forward = np.array([0.0, np.cos(m.alpha), np.sin(m.alpha)])
    sx, sz = m.signs[side]
    normal = sx * np.cos(m.beta) * radial + sz * np.sin(m.beta) * binormal
    return normal, -sx * np.sin(m.beta) * radial + sz * np.cos(m.beta) * binormal, forward


def forces_of(setup: Setup, side: int) -> Array:
    """Forces ``(f,)`` [N] over which a side's patch resolves a contact: from a short semi-axis of one cell to its zone.

    On a grid too coarse for that, from a part of the largest ellipse.
    """
    m, unit = setup.map, unit_hertz(setup, side)
    groove = setup.patches[side].groove
    assert groove.shape is not None
    _, tangent, forward = frame(setup, side)
    x = (groove.points - np.array([m.R, 0.0, 0.0])).reshape(*groove.shape, 3)
    half = np.abs(x[-1, 0] @ tangent - x[0, 0] @ tangent) / 2.0, np.abs(x[0, -1] @ forward - x[0, 0] @ forward) / 2.0
    cell = 2.0 * half[1] / (groove.shape[1] // 2)
    high = FILLED * min(half[0] / unit.semi_x, half[1] / unit.semi_y)
    return np.asarray(np.geomspace(min(COARSEST * cell / unit.semi_y, LEAST * high), high, SAMPLES) ** 3)


def patch_approaches(setup: Setup, side: int, loads: Array) -> Array:
    """Approach [m] of ball and groove patch under ``loads`` [N], sockets held, pressed together along the nominal normal:
    mean over the contact's `PLACES` on the grid."""
    pair, m = setup.patches[side], setup.map
    W, C = mean_weights(pair.groove.weights), pair.own
    normal, tangent, forward = frame(setup, side)
    x = pair.groove.points - np.array([m.R, 0.0, 0.0])
    close = W @ (pair.groove.normals @ normal)
    assert pair.groove.shape is not None
    n, k = pair.groove.shape
    middle = x.reshape(n, k, 3)[n // 2 : n // 2 + 2, k // 2 : k // 2 + 2]
    # the ball's centre moved by t: the gap is least t times (relative radius / r) beside the nominal contact
    scale = m.ball / np.array(relative_radii(setup, side))
    step = scale * np.array([(middle[1, 0] - middle[0, 0]) @ tangent, (middle[0, 1] - middle[0, 0]) @ forward])
    out = np.zeros(loads.size)
    for place in PLACES:
        t = step * np.array(place)
        gap = np.linalg.norm(x - t[0] * tangent - t[1] * forward, axis=1) - m.ball
        nearest = -0.5 * float((t**2 / m.ball * (1.0 / scale - 1.0)).sum())
        out += (approaches(C, W @ gap, close, loads) - nearest) / len(PLACES)
    return out


def approaches(C: Array, gap: Array, close: Array, loads: Array) -> Array:
    """Approach [m] of a unilateral contact under ``loads`` [N]: pressures p >= 0, C p + gap - approach close >= 0, and
    close p the load. Raises ValueError where the active set does not settle."""
    active = gap / close <= np.quantile(gap / close, 0.3)
    out = np.empty(loads.size)
    for k, load in enumerate(loads):
        for _ in range(200):
            i = np.flatnonzero(active)
            K = np.zeros((i.size + 1, i.size + 1))
            K[:-1, :-1], K[:-1, -1], K[-1, :-1] = C[np.ix_(i, i)], -close[i], close[i]
            found = np.linalg.solve(K, np.append(-gap[i], load))
            pressure = np.zeros(gap.size)
            pressure[i], out[k] = found[:-1], found[-1]
            after = (active & (pressure > 0.0)) | (~active & (C @ pressure + gap - close * out[k] < 0.0))
            if (after == active).all():
                break
            active = after
        else:
            raise ValueError(f"the contact of a patch under {load:.4g} N does not settle")
    return out


def body_motion(setup: Setup, side: int, force: Array) -> float:
    """Motion [m/N] of a contact by its own ``force`` on its nodes through the body, mean over all balls."""
    if side >= 2 and setup.nut is None:
        return 0.0
    G = setup.screw.stretch.F if side < 2 or setup.nut is None else setup.nut.G
    body = setup.screw if side < 2 or setup.nut is None else setup.nut
    sides = [s for s in setup.sides if s in body.modes]
    counts = [body.modes[s].shape[1] for s in sides]
    first, amplitude = sum(counts[: sides.index(side)]), body.modes[side].T @ force
    starts = first + sum(counts) * np.arange(setup.layout.z.size)
    return float(np.mean([amplitude @ G[a : a + amplitude.size, a : a + amplitude.size] @ amplitude for a in starts]))


def ball_matrix(setup: Setup, spreads: dict[int, Array]) -> Array:
    """Compliance ``(k, k)`` [m/N] of one ball between its contacts, without its patches' own part."""
    amplitudes = block_diag(*[spreads[s] @ setup.ball.modes[s] for s in setup.sides])
    return np.asarray(amplitudes @ setup.ball.G @ amplitudes.T)


def rest_of(setup: Setup, spreads: dict[int, Array]) -> Array:
    """Motion ``(k,)`` [m/N] of every contact by its own force beyond its patches: through its body and, pressed by the
    opposite contact, the ball; what the two do to a ball is shared."""
    D = ball_matrix(setup, spreads)
    order = [setup.sides.index(3 - s) for s in setup.sides]
    own = np.diag(D)
    ball = 0.5 * (own + own[order]) + D[np.arange(len(own)), order]
    return np.asarray(ball + [body_motion(setup, s, spreads[s]) for s in setup.sides])


def own_terms(setup: Setup, spreads: dict[int, Array]) -> tuple[Array, Array]:
    """What every side's own approach has beside Hertz and the matrices with ``spreads``, over the force, ``(k, f)`` [m/N],
    and the forces ``(k, f)`` [N]."""
    loads = np.array([forces_of(setup, s) for s in setup.sides])
    extra = np.array(
        [
            (patch_approaches(setup, s, f) - unit_hertz(setup, s).approach * np.cbrt(f) ** 2) / f
            for s, f in zip(setup.sides, loads, strict=True)
        ]
    )
    fixed = rest_of(setup, spreads)
    for k in range(loads.shape[1]):
        own = {s: spread(setup, s, float(f)) for s, f in zip(setup.sides, loads[:, k], strict=True)}
        extra[:, k] += rest_of(setup, own) - fixed
    return extra, loads


def body_matrix(setup: Setup, G: Array, modes: dict[int, Array], spreads: dict[int, Array]) -> Array:
    """Compliance between the contacts of a body, ball after ball, from that of their modes."""
    sides = [s for s in setup.sides if s in modes]
    own = {s: modes[s].T @ spreads[s] for s in sides}
    per = sum(own[s].size for s in sides)
    N = setup.layout.z.size
    rows = np.zeros((N * len(sides), N * per))
    for i in range(N):
        start = i * per
        for k, s in enumerate(sides):
            rows[i * len(sides) + k, start : start + own[s].size] = own[s]
            start += own[s].size
    return np.asarray(rows @ G[: N * per, : N * per] @ rows.T)


def condensed_bodies(setup: Setup, level: int) -> CondensedBodies:
    """Everything of a prepared geometry that a low-order model can use."""
    spreads = {s: spread(setup, s, float(np.median(forces_of(setup, s)))) for s in setup.sides}
    local, forces = own_terms(setup, spreads)
    N = setup.layout.z.size
    screw = body_matrix(setup, setup.screw.stretch.F, setup.screw.modes, spreads)
    nut = np.zeros((N * sum(s >= 2 for s in setup.sides),) * 2)
    if setup.nut is not None:
        nut = body_matrix(setup, setup.nut.G, setup.nut.modes, spreads)
    return CondensedBodies(
        geometry_digest(setup.scene), level, np.array(setup.sides, dtype=float), setup.screw.stretch.base, screw, nut,
        ball_matrix(setup, spreads), local, forces, np.array([unit_hertz(setup, s).approach for s in setup.sides]),
    )  # fmt: skip
