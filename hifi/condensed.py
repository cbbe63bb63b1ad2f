"""Compliance of screw, nut and balls along the contact normals, computed by 3D meshes for a low-order model.

Every contact force is distributed over its nodes like Hertz's pressure, and the compliance matrices hold for one value of
this force. The remainder of a contact's approach, besides these matrices and Hertz's law, is sampled over the forces that
its patch can resolve. It has two parts: the approach of the fine patches of groove and ball with fixed refinement boxes,
solved as a contact problem, and the change of the bodies' compliance for a smaller or larger contact ellipse. The
oscillation of the approach with the contact's position on its mesh grid is removed as everywhere in the reference
(`hifi.bodies.grid_wave`).
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import block_diag

from rollbench.hifi.bodies import grid_wave
from rollbench.hifi.contact.hertz import solve_hertz
from rollbench.hifi.elements.forms import normalise_weight_rows
from rollbench.meshes.arrays import Array
from rollbench.meshes.ball_body import contact_frame_vectors
from rollbench.meshes.condensed import CondensedBodies, digest_of_geometry

if TYPE_CHECKING:
    from rollbench.hifi.condensation import CondensedNut, CondensedScrew
    from rollbench.hifi.setup import CondensedGeometry


#: Number of forces at which the approach of a contact is sampled.
SAMPLES = 16


def sampled_contact_forces(setup: CondensedGeometry, side: int) -> Array:
    """Return the f forces ``(f,)`` [N] at which the force-approach curve of ball and groove is sampled on one flank.

    ``side``: groove flank, 0 or 1 on the screw, 2 or 3 on the nut.
    """
    patch, material = setup.patches_by_flank[side].groove_patch, setup.scene.balls.material
    return grid_wave.forces_resolved_by_grid(setup.groove_map, side, patch, material, SAMPLES)


def _unit_hertz_approach(setup: CondensedGeometry, side: int) -> float:
    """Return the approach of ball and groove at a flank (0 to 3) under 1 N by Hertz's theory [m]."""
    return float(grid_wave.hertz_contact_under_unit_force(setup.groove_map, side, setup.scene.balls.material).approach)


def approaches_with_fixed_bodies(setup: CondensedGeometry, side: int, loads: Array) -> Array:
    """Compute the approach of ball and groove if only the fine meshes around their contact deform.

    The coarse bodies around the fine meshes are taken as rigid. The result is the mean over positions of the contact within
    one cell of its mesh grid.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
    loads : (f,) Array
        Contact forces [N].

    Returns
    -------
    (f,) Array
        Approach under each force [m].
    """
    pair = setup.patches_by_flank[side]
    given = setup.groove_map, side, pair.groove_patch, pair.local_compliance, loads
    return np.asarray(grid_wave.approaches_over_grid_cell(*given, grid_wave.MEAN)[0].mean(axis=(0, 1)))


def hertz_shares_of_nodes(setup: CondensedGeometry, side: int, load: float) -> Array:
    """Distribute a unit force along the contact normal over the contact nodes in proportion to Hertz's pressure.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
    load : float
        Contact load by which the contact ellipse is computed [N].

    Returns
    -------
    (c,) Array
        Fraction of the unit force on each contact node (on its pressure basis function).
    """
    m, material = setup.groove_map, setup.scene.balls.material
    ellipse = solve_hertz(load, *m.relative_curvature_radii(side, m.beta), material.youngs_modulus, material.poissons_ratio)
    normal, tangent, forward = contact_frame_vectors(m, side)
    groove = setup.patches_by_flank[side].groove_patch
    x = groove.contact_points - np.array([m.R, 0.0, 0.0]) - m.ball * normal
    force = ellipse.pressure(x @ tangent, x @ forward) * groove.nodal_areas
    return np.asarray(force / (force @ (normalise_weight_rows(groove.pressure_weights) @ (groove.normals @ normal))))


def mean_contact_compliance_of_body(setup: CondensedGeometry, side: int, nodal_shares: Array) -> float:
    """Compute how far a contact moves under a unit force on it because the screw or nut deforms.

    The result is the mean over the contacts of all balls on one flank.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
    nodal_shares : (c,) Array
        Fractions of a unit contact force that act on the contact nodes, from `hertz_shares_of_nodes`.

    Returns
    -------
    float
        Displacement of a contact per unit of the force on it [m/N]; 0 for a rigid body.
    """
    body = setup.condensed_body_of_flank(side)
    if body is None:
        return 0.0
    z = body.modes_by_flank[side].T @ nodal_shares
    own = body.compliance_blocks_of_contacts(side, setup.ball_positions.z.size)
    return float(np.mean([z @ body.G[block] @ z for block in own]))


def ball_compliance_matrix(setup: CondensedGeometry, nodal_shares: dict[int, Array]) -> Array:
    """Compute the compliance matrix between the contacts of one ball, without the local compliance at each contact.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    nodal_shares : dict[int, Array]
        For each flank, the fractions of a unit contact force that act on the contact nodes, from `hertz_shares_of_nodes`.

    Returns
    -------
    (k, k) Array
        Compliance between the contacts on the k flanks of the ball [m/N].
    """
    amplitudes = block_diag(*[nodal_shares[s] @ setup.condensed_ball.modes_by_flank[s] for s in setup.loaded_flanks])
    return np.asarray(amplitudes @ setup.condensed_ball.G @ amplitudes.T)


def contact_compliance_of_bodies(setup: CondensedGeometry, nodal_shares: dict[int, Array]) -> Array:
    """Compute how far screw or nut and ball deform at each contact per unit of its force, without local compliance.

    The result is the sum of the displacement of screw or nut and of half the response of the ball to two opposite forces.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    nodal_shares : dict[int, Array]
        For each flank, the fractions of a unit contact force that act on the contact nodes, from `hertz_shares_of_nodes`.

    Returns
    -------
    (k,) Array
        Displacement of the contact on each of k flanks per unit of its force [m/N].
    """
    D = ball_compliance_matrix(setup, nodal_shares)
    order = [setup.loaded_flanks.index(3 - s) for s in setup.loaded_flanks]
    diagonal = np.diag(D)
    ball = 0.5 * (diagonal + diagonal[order]) + D[np.arange(len(diagonal)), order]
    return np.asarray(ball + [mean_contact_compliance_of_body(setup, s, nodal_shares[s]) for s in setup.loaded_flanks])


def unexplained_approach_over_force(setup: CondensedGeometry, nodal_shares: dict[int, Array]) -> tuple[Array, Array]:
    """Compute the remainder of the approach beyond Hertz's law and the bodies' compliance, divided by the contact force.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    nodal_shares : dict[int, Array]
        For each flank, the fractions of a unit contact force that act on the contact nodes (`hertz_shares_of_nodes`), with
        which the compliance matrices were computed.

    Returns
    -------
    local : (k, f) Array
        Remainder of the approach over the force, on k flanks at f forces [m/N].
    force : (k, f) Array
        These forces [N].
    """
    sides = setup.loaded_flanks
    loads = np.array([sampled_contact_forces(setup, s) for s in sides])
    extra = np.empty_like(loads)
    for row, s, f in zip(extra, sides, loads, strict=True):
        row[:] = (approaches_with_fixed_bodies(setup, s, f) - _unit_hertz_approach(setup, s) * np.cbrt(f) ** 2) / f
    fixed = contact_compliance_of_bodies(setup, nodal_shares)
    for k in range(loads.shape[1]):
        at_load = {s: hertz_shares_of_nodes(setup, s, float(f)) for s, f in zip(sides, loads[:, k], strict=True)}
        extra[:, k] += contact_compliance_of_bodies(setup, at_load) - fixed
    return extra, loads


def body_compliance_matrix(ball_count: int, body: CondensedScrew | CondensedNut, nodal_shares: dict[int, Array]) -> Array:
    """Compute the compliance matrix between all contacts of screw or nut, for nodal forces shared as by Hertz's pressure.

    The contacts are ordered by ball, then by flank. The matrix follows from the compliance between the displacement modes
    of the contacts.

    Parameters
    ----------
    ball_count : int
        Number of balls N.
    body : CondensedScrew | CondensedNut
        Condensed screw or nut.
    nodal_shares : dict[int, Array]
        For each flank, the fractions of a unit contact force that act on the contact nodes, from `hertz_shares_of_nodes`.

    Returns
    -------
    (N k', N k') Array
        Compliance between the contacts of N balls on the k' flanks of that body [m/N].
    """
    z = np.zeros((ball_count * len(body.modes_by_flank), len(body.G)))
    for row, (i, s) in zip(z, product(range(ball_count), body.modes_by_flank), strict=True):
        row[body.mode_indices_of_contact(s, i)] = body.modes_by_flank[s].T @ nodal_shares[s]
    return np.asarray(z @ body.G @ z.T)


def collect_condensed_bodies(setup: CondensedGeometry, level: int) -> CondensedBodies:
    """Collect the compliance matrices of screw, nut and balls for use in a low-order model.

    Parameters
    ----------
    setup : CondensedGeometry
        Meshed and condensed parts of one geometry.
    level : int
        Refinement level of the meshes.

    Returns
    -------
    CondensedBodies
        Compliances of screw, nut and balls, as written to a file.
    """
    middle = {s: float(np.median(sampled_contact_forces(setup, s))) for s in setup.loaded_flanks}
    spreads = {s: hertz_shares_of_nodes(setup, s, load) for s, load in middle.items()}
    local, forces = unexplained_approach_over_force(setup, spreads)
    N = setup.ball_positions.z.size
    nut = np.zeros((N * sum(s >= 2 for s in setup.loaded_flanks),) * 2)
    if setup.condensed_nut is not None:
        nut = body_compliance_matrix(N, setup.condensed_nut, spreads)
    return CondensedBodies(
        digest_of_geometry(setup.scene),
        level,
        np.array(setup.loaded_flanks, dtype=float),
        setup.condensed_screw.stretch.base_position,
        body_compliance_matrix(N, setup.condensed_screw, spreads),
        nut,
        ball_compliance_matrix(setup, spreads),
        local,
        forces,
        np.array([_unit_hertz_approach(setup, s) for s in setup.loaded_flanks]),
    )
