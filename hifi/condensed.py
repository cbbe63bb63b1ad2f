"""What a low-order model takes from a prepared geometry: compliance of its bodies along the contact normals.

Every contact's force is spread like Hertz's pressure over its nodes, and the matrices are for one force. What a contact's
own approach has besides them and Hertz's law is sampled over the forces that its patch can carry: the fine patches of
groove and ball, sockets held, solved as contact, and how the rest of both bodies answers a smaller or larger ellipse.
The grid's wave is taken out as everywhere in the reference (`hifi.bodies.grid_wave`).
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import block_diag

from rollbench.hifi.bodies.grid_wave import mean_approaches, resolved_forces, unit_hertz
from rollbench.hifi.contact.hertz import hertz
from rollbench.hifi.elements.forms import mean_weights
from rollbench.meshes.arrays import Array
from rollbench.meshes.ball_body import directions
from rollbench.meshes.condensed import CondensedBodies, geometry_digest

if TYPE_CHECKING:
    from rollbench.hifi.condensation import NutResponse, ScrewResponse
    from rollbench.hifi.setup import Setup


#: Number of forces at which a contact's own approach is sampled.
SAMPLES = 16


def forces_of(setup: Setup, side: int) -> Array:
    """Forces ``(f,)`` [N] at which a side's own approach is sampled."""
    return resolved_forces(setup.map, side, setup.patches[side].groove, setup.scene.balls.material, SAMPLES)


def _unit(setup: Setup, side: int) -> float:
    """Hertz's approach [m] under 1 N."""
    return float(unit_hertz(setup.map, side, setup.scene.balls.material).approach)


def patch_approaches(setup: Setup, side: int, loads: Array) -> Array:
    """Approach [m] of ball and groove by a contact's own compliance under ``loads`` [N], without the grid's wave."""
    pair = setup.patches[side]
    return mean_approaches(setup.map, side, pair.groove, pair.local, loads)


def spread(setup: Setup, side: int, load: float) -> Array:
    """Forces on a side's contact nodes ``(c,)`` like Hertz's pressure under ``load`` [N], of unit resultant."""
    m, material = setup.map, setup.scene.balls.material
    ellipse = hertz(load, *m.relative_radii(side, m.beta), material.youngs_modulus, material.poissons_ratio)
    normal, tangent, forward = directions(m, side)
    groove = setup.patches[side].groove
    x = groove.points - np.array([m.R, 0.0, 0.0]) - m.ball * normal
    force = ellipse.pressure(x @ tangent, x @ forward) * groove.areas
    return np.asarray(force / (force @ (mean_weights(groove.weights) @ (groove.normals @ normal))))


def body_motion(setup: Setup, side: int, force: Array) -> float:
    """Motion [m/N] of a contact by its own ``force`` on its nodes through the body, mean over all balls."""
    body = setup.body(side)
    if body is None:
        return 0.0
    z = body.modes[side].T @ force
    own = [np.ix_(rows, rows) for rows in (body.rows(side, i) for i in range(setup.layout.z.size))]
    return float(np.mean([z @ body.G[block] @ z for block in own]))


def ball_matrix(setup: Setup, spreads: dict[int, Array]) -> Array:
    """Compliance ``(k, k)`` [m/N] of one ball between its contacts, without its patches' own part."""
    amplitudes = block_diag(*[spreads[s] @ setup.ball.modes[s] for s in setup.sides])
    return np.asarray(amplitudes @ setup.ball.G @ amplitudes.T)


def rest_of(setup: Setup, spreads: dict[int, Array]) -> Array:
    """Motion ``(k,)`` [m/N] of every contact by its own force beyond its patches: through its body and, pressed by the
    opposite contact, the ball; what the two do to a ball is shared."""
    D = ball_matrix(setup, spreads)
    order = [setup.sides.index(3 - s) for s in setup.sides]
    diagonal = np.diag(D)
    ball = 0.5 * (diagonal + diagonal[order]) + D[np.arange(len(diagonal)), order]
    return np.asarray(ball + [body_motion(setup, s, spreads[s]) for s in setup.sides])


def own_terms(setup: Setup, spreads: dict[int, Array]) -> tuple[Array, Array]:
    """What every side's own approach has besides Hertz and the matrices with ``spreads``, over the force, ``(k, f)`` [m/N],
    and the forces ``(k, f)`` [N]."""
    loads = np.array([forces_of(setup, s) for s in setup.sides])
    extra = np.array(
        [
            (patch_approaches(setup, s, f) - _unit(setup, s) * np.cbrt(f) ** 2) / f
            for s, f in zip(setup.sides, loads, strict=True)
        ]
    )
    fixed = rest_of(setup, spreads)
    for k in range(loads.shape[1]):
        at_load = {s: spread(setup, s, float(f)) for s, f in zip(setup.sides, loads[:, k], strict=True)}
        extra[:, k] += rest_of(setup, at_load) - fixed
    return extra, loads


def body_matrix(balls: int, body: ScrewResponse | NutResponse, spreads: dict[int, Array]) -> Array:
    """Compliance between the contacts of a body, ball after ball, from that of their modes."""
    z = np.zeros((balls * len(body.modes), len(body.G)))
    for row, (i, s) in zip(z, product(range(balls), body.modes), strict=True):
        row[body.rows(s, i)] = body.modes[s].T @ spreads[s]
    return np.asarray(z @ body.G @ z.T)


def condensed_bodies(setup: Setup, level: int) -> CondensedBodies:
    """Everything of a prepared geometry that a low-order model can use."""
    spreads = {s: spread(setup, s, float(np.median(forces_of(setup, s)))) for s in setup.sides}
    local, forces = own_terms(setup, spreads)
    N = setup.layout.z.size
    nut = np.zeros((N * sum(s >= 2 for s in setup.sides),) * 2)
    if setup.nut is not None:
        nut = body_matrix(N, setup.nut, spreads)
    return CondensedBodies(
        geometry_digest(setup.scene),
        level,
        np.array(setup.sides, dtype=float),
        setup.screw.stretch.base,
        body_matrix(N, setup.screw, spreads),
        nut,
        ball_matrix(setup, spreads),
        local,
        forces,
        np.array([_unit(setup, s) for s in setup.sides]),
    )
