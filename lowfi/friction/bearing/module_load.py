"""Loads of one ball between an inner and an outer ring, rigid but for Hertz contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.friction.contact.records import CellArrays
from rollbench.lowfi.friction.contact.rings import settle_cell
from rollbench.meshes.arrays import Array


@dataclass(frozen=True)
class ModuleLoad:
    """Contact forces (4,) [N]; contact angles (4,) [rad] from the radial line; inner ring (2,) and ball (2,) [m].

    imbalance: largest force left [N]; steps; converged: whether it is below 1e-8 of the sum of forces.
    """

    force: Array
    angle: Array
    ring: Array
    ball: Array
    imbalance: float
    steps: int
    converged: bool


def settle_module(normals: Array, reach: float, play: float, C: Array, force: float, u_y: float) -> ModuleLoad:
    """Contact loads of a ball for the axial force on the inner ring [N] and its radial displacement u_y [m].

    normals (4, 2): nominal directions (axial, radial) from the ball's centre to its contacts, inner ring first; reach:
    r_G - r_B > 0 [m]; play [m] along each; C (4,): approach = C F^(2/3). A ring is a screw of zero lead: the least of the
    energy of `lowfi.friction.contact.rings` over its axial displacement and the ball's centre. Contact forces are unique;
    with no force and play the ball floats, and its place is where the search ends.
    """
    cell = CellArrays(
        start=np.ascontiguousarray(reach * normals[None]),
        interference=np.full((1, 4), -play),
        C=np.ascontiguousarray(C, dtype=float),
        section=np.array([[[1.0], [0.0]]]),
        offset=np.array([[0.0, u_y]]),
        push=np.zeros((1, 2)),
        pull=np.array([force]),
        reach=reach,
    )
    typical = float(np.max(C)) * max(abs(force), 1e-6) ** (2.0 / 3.0) + max(play, 0.0) + abs(u_y)
    way = typical * float(np.sign(force))
    settled = settle_cell(cell, abs(force), np.array([[2.0 * way, 0.5 * u_y]]), np.array([4.0 * way]))
    n = np.abs(settled.normal[0])
    return ModuleLoad(
        force=settled.force[0],
        angle=np.arctan2(n[:, 0], n[:, 1]),
        ring=np.array([settled.inner[0], u_y]),
        ball=settled.ball[0],
        imbalance=settled.left,
        steps=settled.steps,
        converged=settled.converged,
    )
