"""Gaps, directions and places of all contacts of a prepared geometry, and how motions of balls and screw change them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from rollbench.hifi.coupling import Zones
from rollbench.hifi.elements.pressures import mean_weights
from rollbench.hifi.meshing.part_meshes import rotation
from rollbench.hifi.setup import Setup
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimen
from rollbench.meshes.helix import groove_radii, nominal_groove_centres
from rollbench.meshes.surface import groove_profile


def expected_touch(gap: Array, zones: Zones) -> Array:
    """Contact nodes ``(balls, n)`` expected to touch, by their gaps ``(balls, n)`` [m]: the nearest third of each side."""
    out = np.zeros(gap.shape, dtype=bool)
    for nodes in zones.parts:
        gaps = gap[:, nodes]
        third = gaps.shape[1] // 3
        out[:, nodes] = gaps < np.partition(gaps, third, axis=1)[:, third, None]
    return out


def over_hats(setup: Setup, zones: Zones, values: Array) -> Array:
    """Means over the pressure hats of values ``(balls, n, ...)`` of the contact nodes."""
    out = np.empty_like(values)
    for nodes, s in zip(zones.parts, zones.sides, strict=True):
        by_node = np.moveaxis(values[:, nodes], 1, 0)
        mean = mean_weights(setup.patches[s].groove.weights) @ by_node.reshape(len(by_node), -1)
        out[:, nodes] = np.moveaxis(mean.reshape(by_node.shape), 0, 1)
    return out


def wave_gaps(setup: Setup, zones: Zones, forces: Array, directions: Array) -> Array:
    """Corrections ``(balls, n)`` [m] of all gaps for the places of the contacts on their grids
    (`hifi.bodies.grid_wave`)."""
    out = np.zeros_like(forces)
    for nodes, s in zip(zones.parts, zones.sides, strict=True):
        wave = setup.patches[s].wave
        if wave is None:
            continue
        pressed = forces[:, nodes]
        total = pressed.sum(axis=1)
        centres = (pressed @ setup.patches[s].groove.points) / np.maximum(total, 1e-300)[:, None]
        loads = np.linalg.norm(np.einsum("ic,icx->ix", pressed, directions[:, nodes]), axis=1)
        out[:, nodes] = wave.at(loads, centres)[:, None]
    return out


def groove_errors(setup: Setup, drawn: Specimen, sides: tuple[int, ...]) -> Array:
    """Displacement of each groove by its geometric errors at every contact node, ``(balls, n, 3)`` in the ball's frame."""
    m = setup.map
    x3, z3 = np.array([1.0, 0.0, 0.0]), np.array([0.0, -np.sin(m.alpha), np.cos(m.alpha)])
    rows = []
    nominal_centres, radii = nominal_groove_centres(setup.scene), groove_radii(setup.scene)
    for s in sides:
        points = setup.patches[s].groove.points
        offset = drawn.centre[:, s] - nominal_centres[s]
        shift = offset[:, :1, None] * x3 + offset[:, 1:, None] * z3
        local = points - np.array([m.R, 0.0, 0.0])
        gamma, _ = m.polar(s, local @ x3, local @ z3)
        inward = radii[s] - groove_profile(gamma, drawn.radius[s], drawn.profile[s])[0]
        sx, sz = m.signs[s]
        outward = sx * np.cos(gamma)[:, None] * x3 + sz * np.sin(gamma)[:, None] * z3
        rows.append(shift - (inward[:, None] * outward)[None])
    return np.concatenate(rows, axis=1)


def directions_matrix(directions: Sequence[Array], unheld: Array) -> sp.csr_matrix:
    """N: gap closed by unit motions of each ball (3), by the normals ``(balls, n, 3)`` of every set, and by the unheld
    rigid motions, which move the grooves' nodes along their normals by ``unheld`` ``(pairs, k)``."""
    balls = sp.block_diag([normals for of_set in directions for normals in of_set])
    return sp.hstack([balls, sp.csr_matrix(-unheld)]).tocsr()


def rigid_rows(setup: Setup, directions: Array, zones: Zones, origin: float, *, screw: bool) -> Array:
    """Motion of the contact nodes of the screw, or of the nut, along their normals by its rigid motion about the station
    ``origin`` [m] of the set-up, ``(c, n, 6)``."""
    count, n, _ = directions.shape
    out = np.zeros((count, n, 6))
    for nodes, s in zip(zones.parts, zones.sides, strict=True):
        if (s < 2) != screw:
            continue
        local = setup.patches[s].groove.points
        for i in range(count):
            R = rotation(float(setup.layout.azimuth[i]))
            x = local @ R.T + np.array([0.0, 0.0, setup.layout.z[i] - origin])
            d = directions[i, nodes] @ R.T
            out[i, nodes, :3] = d
            out[i, nodes, 3:] = np.cross(x, d)
    return out


def relative_motion(setup: Setup, balls: Array, along: Array, directions: Array, zones: Zones) -> tuple[Array, Array]:
    """Motion of each ball's centre relative to each of its grooves, the same for a side's nodes: in the section plane
    ``(balls, n, 3)``, and along the track ``(balls, n)``, less what the sides of a ball have in common [m].

    balls: motions of the centres ``(balls, 3)``; along: those of the grooves' nodes along their normals ``(balls, n)``, by
    the bodies' modes and rigid motions [m]. What the ball's centre moves beyond the groove across its track is what turns
    the normals; a ball may stand anywhere along it.

    A groove is invariant under its helical motion, which therefore changes no gap, and does no work on what presses on it
    without friction: every contact stands abreast of the ball. By linear kinematics a screw that winds up by theta moves
    its contacts R theta/2 along, and R theta^2/2 out of their section. The middle of the pressures would show the same
    motion, but on the grid: under a light contact that closes few nodes it sticks to them, or jumps.
    """
    motion = np.zeros((len(balls), len(zones.parts), 3))
    for k, nodes in enumerate(zones.parts):
        for i in range(len(balls)):
            motion[i, k] = balls[i] - np.linalg.lstsq(directions[i, nodes], along[i, nodes], rcond=1e-6)[0]
    y3 = tangent(setup)
    slid = motion @ y3
    shift = motion - slid[..., None] * y3
    sizes = [nodes.stop - nodes.start for nodes in zones.parts]
    return np.repeat(shift, sizes, axis=1), np.repeat(slid - slid.mean(axis=1, keepdims=True), sizes, axis=1)


def tangent(setup: Setup) -> Array:
    """Unit tangent of the track at the ball's centre, ``(3,)``, in the frame of a ball at azimuth 0."""
    return np.array([0.0, np.cos(setup.map.alpha), np.sin(setup.map.alpha)])


def along_track(setup: Setup, sides: tuple[int, ...]) -> Array:
    """Helical motion of the track at the contact nodes, ``(n, 3)``, of unit length at the ball's centre."""
    m = setup.map
    x = np.concatenate([setup.patches[s].groove.points for s in sides])
    return np.asarray(np.stack([-x[:, 1], x[:, 0], np.full(len(x), m.rg)], axis=1) * (np.cos(m.alpha) / m.R))
