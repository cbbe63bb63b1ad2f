"""What a prepared geometry tells a low-order model: compliance of its bodies along the contact normals.

Every contact's force is spread like Hertz's pressure over its nodes. The fine patches alone (sockets held) give one term
for all balls: the approach of groove and ball patch under a range of forces beyond Hertz's law, solved as contact, so that
the grid's own error is averaged.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hifi.hertz import hertz
from meshes.condensed import CondensedBodies, geometry_digest

if TYPE_CHECKING:
    from hifi.setup import Setup

Array = NDArray[np.float64]

#: Forces at which the patches' own term is sampled, as shares of the force that the mesh was made for.
SHARES = np.geomspace(0.2, 1.2, 19)


def relative_radii(setup: Setup, side: int) -> tuple[float, float]:
    """Relative radii [m] of ball and groove across and along it, by the normal curvatures of the helical groove."""
    m = setup.map
    part = m.signs[side, 0] * np.cos(m.beta)
    along = part * np.cos(m.alpha) ** 2 / (m.R + part * m.ball)
    return 1.0 / (1.0 / m.ball - 1.0 / float(m.radius[side])), 1.0 / (1.0 / m.ball - along)


def spread(setup: Setup, side: int, load: float) -> Array:
    """Forces on a side's contact nodes ``(c,)`` like Hertz's pressure under ``load`` [N], of unit resultant."""
    m, material = setup.map, setup.scene.balls.material
    across, along = relative_radii(setup, side)
    found = hertz(load, across, along, material.youngs_modulus, material.poissons_ratio)
    normal, tangent, forward = frame(setup, side)
    groove = setup.patches[side].groove
    x = groove.points - np.array([m.R, 0.0, 0.0]) - m.ball * normal
    force = found.pressure(x @ tangent, x @ forward) * groove.areas
    return np.asarray(force / (force @ (groove.normals @ normal)))


def frame(setup: Setup, side: int) -> tuple[Array, Array, Array]:
    """Nominal normal (ball to groove), tangent across the groove, direction along it."""
    m = setup.map
    radial = np.array([1.0, 0.0, 0.0])
    binormal = np.array([0.0, -np.sin(m.alpha), np.cos(m.alpha)])
    forward = np.array([0.0, np.cos(m.alpha), np.sin(m.alpha)])
    sx, sz = m.signs[side]
    normal = sx * np.cos(m.beta) * radial + sz * np.sin(m.beta) * binormal
    return normal, -sx * np.sin(m.beta) * radial + sz * np.cos(m.beta) * binormal, forward


def patch_approach(setup: Setup, side: int, load: float) -> float:
    """Approach [m] of ball and groove patch, their sockets held, pressed together along the nominal normal."""
    pair = setup.patches[side]
    C = pair.groove.A + pair.ball.A
    centre = np.array([setup.map.R, 0.0, 0.0])
    gap = np.linalg.norm(pair.groove.points - centre, axis=1) - setup.map.ball
    along = pair.groove.normals @ frame(setup, side)[0]
    active = gap <= np.quantile(gap, 0.3)
    approach = 0.0
    for _ in range(80):
        i = np.flatnonzero(active)
        K = np.zeros((i.size + 1, i.size + 1))
        K[:-1, :-1], K[:-1, -1], K[-1, :-1] = C[np.ix_(i, i)], -along[i], along[i]
        x = np.linalg.solve(K, np.append(-gap[i], load))
        force = np.zeros(gap.size)
        force[i], approach = x[:-1], float(x[-1])
        after = (active & (force > 0.0)) | (~active & (C @ force + gap - along * approach < 0.0))
        if (after == active).all():
            break
        active = after
    return approach


def own_terms(setup: Setup) -> tuple[Array, Array]:
    """What the patches' approach has beyond Hertz, over the force, ``(k, f)`` [m/N], at the forces ``(f,)`` [N]."""
    material = setup.scene.balls.material
    constants = (material.youngs_modulus, material.poissons_ratio)
    units = [hertz(1.0, *relative_radii(setup, s), *constants) for s in setup.sides]
    widest = max(max(u.semi_x, u.semi_y) for u in units)
    loads = (setup.settings.semi[0] / widest) ** 3 * SHARES
    extra = [
        [patch_approach(setup, s, float(f)) / f - u.approach / np.cbrt(f) for f in loads]
        for s, u in zip(setup.sides, units, strict=True)
    ]
    return np.array(extra), loads


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
    local, forces = own_terms(setup)
    spreads = {s: spread(setup, s, float(np.median(forces))) for s in setup.sides}
    N = setup.layout.z.size
    screw = body_matrix(setup, setup.screw.stretch.F, setup.screw.modes, spreads)
    nut = np.zeros((N * sum(s >= 2 for s in setup.sides),) * 2)
    if setup.nut is not None:
        nut = body_matrix(setup, setup.nut.G, setup.nut.modes, spreads)
    sizes = [spreads[s].size for s in setup.sides]
    ends = np.cumsum([0, *sizes])
    ball = np.empty((len(sizes), len(sizes)))
    for a, s in enumerate(setup.sides):
        for b, t in enumerate(setup.sides):
            block = setup.ball[ends[a] : ends[a + 1], ends[b] : ends[b + 1]]
            if a == b:
                block = block - setup.patches[s].ball.A
            ball[a, b] = spreads[s] @ block @ spreads[t]
    return CondensedBodies(
        geometry_digest(setup.scene), level, np.array(setup.sides, dtype=float), setup.screw.stretch.base, screw, nut, ball,
        local, forces,
    )  # fmt: skip
