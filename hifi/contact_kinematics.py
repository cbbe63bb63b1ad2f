"""Gaps, directions and places of all contacts of a set on its shaft, and how motions of balls and screw change them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from rollbench.hifi.coupling import PlacedSet
from rollbench.hifi.elements.pressures import mean_weights
from rollbench.hifi.meshing.part_meshes import rotation
from rollbench.meshes.arrays import Array
from rollbench.meshes.errors import Specimen
from rollbench.meshes.helix import groove_radii, nominal_groove_centres
from rollbench.meshes.surface import groove_profile


def expected_touch(p: PlacedSet, gap: Array) -> Array:
    """Contact nodes ``(balls, n)`` expected to touch, by their gaps ``(balls, n)`` [m]: the nearest third of each side."""
    out = np.zeros(gap.shape, dtype=bool)
    for nodes, _ in p.zones:
        gaps = gap[:, nodes]
        third = gaps.shape[1] // 3
        out[:, nodes] = gaps < np.partition(gaps, third, axis=1)[:, third, None]
    return out


def over_hats(p: PlacedSet, values: Array) -> Array:
    """Means over the pressure hats of values ``(balls, n, ...)`` of the contact nodes."""
    out = np.empty_like(values)
    for nodes, s in p.zones:
        by_node = np.moveaxis(values[:, nodes], 1, 0)
        mean = mean_weights(p.setup.patches[s].groove.weights) @ by_node.reshape(len(by_node), -1)
        out[:, nodes] = np.moveaxis(mean.reshape(by_node.shape), 0, 1)
    return out


def wave_gaps(p: PlacedSet, forces: Array, directions: Array) -> Array:
    """Corrections ``(balls, n)`` [m] of all gaps for the places of the contacts on their grids
    (`hifi.bodies.grid_wave`)."""
    out = np.zeros_like(forces)
    for nodes, s in p.zones:
        pair = p.setup.patches[s]
        if pair.wave is not None:
            pressed = forces[:, nodes]
            centres = (pressed @ pair.groove.points) / np.maximum(pressed.sum(axis=1), 1e-300)[:, None]
            loads = np.linalg.norm(np.einsum("ic,icx->ix", pressed, directions[:, nodes]), axis=1)
            out[:, nodes] = pair.wave.at(loads, centres)[:, None]
    return out


def node_arms(p: PlacedSet, drawn: Specimen) -> Array:
    """Places of the nodes of the grooves from their ball's centre, ``(balls, n, 3)`` [m] in the ball's frame: nominal ones,
    with each groove's geometric errors, and the nut's shift (along its own track a groove is the same everywhere)."""
    m = p.setup.map
    x3, _, z3 = m.axes()
    nominal_centres, radii = nominal_groove_centres(p.setup.scene), groove_radii(p.setup.scene)
    rows = []
    for s in p.sides:
        local = p.setup.patches[s].groove.points - np.array([m.R, 0.0, 0.0])
        offset = drawn.centre[:, s] - nominal_centres[s]
        shift = offset[:, :1, None] * x3 + offset[:, 1:, None] * z3
        gamma, _ = m.polar(s, local @ x3, local @ z3)
        inward = radii[s] - groove_profile(gamma, drawn.radius[s], drawn.profile[s])[0]
        sx, sz = m.signs[s]
        outward = sx * np.cos(gamma)[:, None] * x3 + sz * np.sin(gamma)[:, None] * z3
        by_nut = p.offset * np.cos(m.alpha) * z3 if s >= 2 else np.zeros(3)
        rows.append(local + (shift - (inward[:, None] * outward)[None]) + by_nut)
    return np.concatenate(rows, axis=1)


def directions_matrix(directions: Sequence[Array], unheld: Array) -> sp.csr_array:
    """N: gap closed by unit motions of each ball (3), by the normals ``(balls, n, 3)`` of every set, and by the unheld
    rigid motions, which move the grooves' nodes along their normals by ``unheld`` ``(pairs, k)``."""
    balls = sp.block_diag([sp.csr_array(normals) for of_set in directions for normals in of_set])
    return sp.hstack([balls, sp.csr_array(-unheld)]).tocsr()


def rigid_rows(p: PlacedSet, directions: Array, origin: float, *, screw: bool) -> Array:
    """Motion of the contact nodes of the screw, or of the nut, along their normals by its rigid motion about the station
    ``origin`` [m] of the shaft, ``(c, n, 6)``."""
    layout = p.setup.layout
    out = np.zeros((*directions.shape[:2], 6))
    for nodes, s in p.zones:
        if (s < 2) != screw:
            continue
        for i in range(p.count):
            R = rotation(float(layout.azimuth[i]))
            x = p.setup.patches[s].groove.points @ R.T + np.array([0.0, 0.0, layout.z[i] - (origin - p.shift)])
            d = directions[i, nodes] @ R.T
            out[i, nodes, :3], out[i, nodes, 3:] = d, np.cross(x, d)
    return out


def relative_motion(p: PlacedSet, balls: Array, along: Array, directions: Array) -> tuple[Array, Array]:
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
    motion = np.zeros((len(balls), len(p.zones), 3))
    for k, (nodes, _) in enumerate(p.zones):
        for i in range(len(balls)):
            motion[i, k] = balls[i] - np.linalg.lstsq(directions[i, nodes], along[i, nodes], rcond=1e-6)[0]
    y3 = p.setup.map.axes()[1]
    slid = motion @ y3
    shift = motion - slid[..., None] * y3
    sizes = [nodes.stop - nodes.start for nodes, _ in p.zones]
    return np.repeat(shift, sizes, axis=1), np.repeat(slid - slid.mean(axis=1, keepdims=True), sizes, axis=1)


def along_track(p: PlacedSet) -> Array:
    """Helical motion of the track at the contact nodes, ``(n, 3)``, of unit length at the ball's centre."""
    m = p.setup.map
    x = np.concatenate([p.setup.patches[s].groove.points for s in p.sides])
    return np.asarray(np.stack([-x[:, 1], x[:, 0], np.full(len(x), m.rg)], axis=1) * (np.cos(m.alpha) / m.R))
