"""Compliance of the bodies of a prepared geometry along the contact normals, for a low-order model.

Every contact's force is spread like Hertz's pressure over its nodes, and the matrices are for one force. What a contact's
approach has besides them and Hertz's law is sampled over the forces that its patch can carry: the fine patches of groove
and ball, sockets fixed, solved as contact, and the change of the remaining response of both bodies for a smaller or
larger ellipse. The grid's wave is removed as everywhere in the reference (`hifi.bodies.grid_wave`).
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


#: Number of forces at which the approach of a contact is sampled.
SAMPLES = 16


def forces_of(setup: Setup, side: int) -> Array:
    """Choose the forces at which the approach of a flank's contact is sampled ``(f,)`` [N]."""
    return resolved_forces(setup.map, side, setup.patches[side].groove, setup.scene.balls.material, SAMPLES)


def _unit(setup: Setup, side: int) -> float:
    """Hertz's approach [m] under 1 N."""
    return float(unit_hertz(setup.map, side, setup.scene.balls.material).approach)


def patch_approaches(setup: Setup, side: int, loads: Array) -> Array:
    """Approaches of ball and groove by a contact's local compliance, without the grid's wave.

    Parameters
    ----------
    setup : Setup
        The prepared geometry.
    side : int
        Flank 0 to 3.
    loads : (f,) Array
        Forces [N].

    Returns
    -------
    (f,) Array
        Approaches [m].
    """
    pair = setup.patches[side]
    return mean_approaches(setup.map, side, pair.groove, pair.local, loads)


def spread(setup: Setup, side: int, load: float) -> Array:
    """Nodal forces of a contact like Hertz's pressure, of unit resultant along the contact normal.

    Parameters
    ----------
    setup : Setup
        The prepared geometry.
    side : int
        Flank 0 to 3.
    load : float
        Load whose ellipse is taken [N].

    Returns
    -------
    (c,) Array
        Forces on the contact nodes.
    """
    m, material = setup.map, setup.scene.balls.material
    ellipse = hertz(load, *m.relative_radii(side, m.beta), material.youngs_modulus, material.poissons_ratio)
    normal, tangent, forward = directions(m, side)
    groove = setup.patches[side].groove
    x = groove.points - np.array([m.R, 0.0, 0.0]) - m.ball * normal
    force = ellipse.pressure(x @ tangent, x @ forward) * groove.areas
    return np.asarray(force / (force @ (mean_weights(groove.weights) @ (groove.normals @ normal))))


def body_motion(setup: Setup, side: int, force: Array) -> float:
    """Displacement of a contact per unit of its force through the body (screw or nut), mean over all balls.

    Parameters
    ----------
    setup : Setup
        The prepared geometry.
    side : int
        Flank 0 to 3.
    force : (c,) Array
        Nodal forces of unit resultant.

    Returns
    -------
    float
        [m/N]; 0 for a rigid body.
    """
    body = setup.body(side)
    if body is None:
        return 0.0
    z = body.modes[side].T @ force
    own = [np.ix_(rows, rows) for rows in (body.mode_rows(side, i) for i in range(setup.layout.z.size))]
    return float(np.mean([z @ body.G[block] @ z for block in own]))


def ball_matrix(setup: Setup, spreads: dict[int, Array]) -> Array:
    """Compliance of one ball between its contacts, without the local compliance of its patches.

    Parameters
    ----------
    setup : Setup
        The prepared geometry.
    spreads : dict[int, Array]
        Nodal forces of unit resultant, by flank.

    Returns
    -------
    (k, k) Array
        [m/N].
    """
    amplitudes = block_diag(*[spreads[s] @ setup.ball.modes[s] for s in setup.sides])
    return np.asarray(amplitudes @ setup.ball.G @ amplitudes.T)


def beyond_patches(setup: Setup, spreads: dict[int, Array]) -> Array:
    """Displacement of every contact per unit of its force beyond its patches.

    Through its body and, with the opposite contact, the ball, of whose response half counts to each of the two contacts.

    Parameters
    ----------
    setup : Setup
        The prepared geometry.
    spreads : dict[int, Array]
        Nodal forces of unit resultant, by flank.

    Returns
    -------
    (k,) Array
        [m/N].
    """
    D = ball_matrix(setup, spreads)
    order = [setup.sides.index(3 - s) for s in setup.sides]
    diagonal = np.diag(D)
    ball = 0.5 * (diagonal + diagonal[order]) + D[np.arange(len(diagonal)), order]
    return np.asarray(ball + [body_motion(setup, s, spreads[s]) for s in setup.sides])


def local_terms(setup: Setup, spreads: dict[int, Array]) -> tuple[Array, Array]:
    """Approach of every flank's contact over its force, beyond Hertz's law and the matrices.

    Parameters
    ----------
    setup : Setup
        The prepared geometry.
    spreads : dict[int, Array]
        Nodal forces of unit resultant with which the matrices were computed, by flank.

    Returns
    -------
    local : (k, f) Array
        [m/N].
    force : (k, f) Array
        Forces [N].
    """
    loads = np.array([forces_of(setup, s) for s in setup.sides])
    extra = np.array(
        [
            (patch_approaches(setup, s, f) - _unit(setup, s) * np.cbrt(f) ** 2) / f
            for s, f in zip(setup.sides, loads, strict=True)
        ]
    )
    fixed = beyond_patches(setup, spreads)
    for k in range(loads.shape[1]):
        at_load = {s: spread(setup, s, float(f)) for s, f in zip(setup.sides, loads[:, k], strict=True)}
        extra[:, k] += beyond_patches(setup, at_load) - fixed
    return extra, loads


def body_matrix(balls: int, body: ScrewResponse | NutResponse, spreads: dict[int, Array]) -> Array:
    """Compliance between the contacts of a body, ball after ball, from that of their modes.

    Parameters
    ----------
    balls : int
        Number of balls.
    body : ScrewResponse | NutResponse
        Screw or nut.
    spreads : dict[int, Array]
        Nodal forces of unit resultant, by flank.

    Returns
    -------
    (N k', N k') Array
        [m/N].
    """
    z = np.zeros((balls * len(body.modes), len(body.G)))
    for row, (i, s) in zip(z, product(range(balls), body.modes), strict=True):
        row[body.mode_rows(s, i)] = body.modes[s].T @ spreads[s]
    return np.asarray(z @ body.G @ z.T)


def condensed_bodies(setup: Setup, level: int) -> CondensedBodies:
    """Collect everything of a prepared geometry that a low-order model can use.

    Parameters
    ----------
    setup : Setup
        The prepared geometry.
    level : int
        Mesh level.

    Returns
    -------
    CondensedBodies
        Contents of a file.
    """
    spreads = {s: spread(setup, s, float(np.median(forces_of(setup, s)))) for s in setup.sides}
    local, forces = local_terms(setup, spreads)
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
