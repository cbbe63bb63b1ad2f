"""Compliance of the washers of a thrust ball bearing: bodies of revolution with a groove in the face, held at the back."""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.compliance import fourier, groove
from rollbench.lowfi.compliance.beyond_hertz import NARROW, HalfGroove
from rollbench.meshes.arrays import Array
from rollbench.meshes.washers import Washer

#: Numbers of elements along the groove, along each land, and in depth; exponent of the depth of their ends.
ALONG, LAND, DEPTH, GRADING = 16, 4, 10, 1.5
#: Signs of a motion along r and z in the mirror image of a washer.
MIRROR = np.array([1.0, -1.0])


def washer_grid(washer: Washer, fineness: float = 1.0) -> fourier.QuadrilateralGrid:
    """Return the finite-element grid of a washer: lines from the outer edge to the bore, nodes from face to back.

    ``fineness``: factor on the numbers of elements.
    """
    along, land, depth = (int(np.ceil(fineness * n)) for n in (ALONG, LAND, DEPTH))
    low, high = washer.section_angles
    angle = np.linspace(low, high, 2 * along + 1)
    arc_r = washer.centre[0] + washer.groove_radius * np.cos(angle)
    arc_z = washer.centre[1] + washer.groove_radius * np.sin(angle)
    outside = fourier.node_positions_with_mid_nodes(np.linspace(washer.outer, arc_r[0], land + 1))[:-1]
    inside = fourier.node_positions_with_mid_nodes(np.linspace(arc_r[-1], washer.bore, land + 1))[1:]
    face = np.full(outside.size, washer.face)
    r, z = np.concatenate([outside, arc_r, inside]), np.concatenate([face, arc_z, face])
    share = fourier.node_positions_with_mid_nodes(np.linspace(0.0, 1.0, depth + 1) ** GRADING)
    depths = z[:, None] + share * (washer.back - z)[:, None]
    return fourier.QuadrilateralGrid(np.repeat(r[:, None], share.size, axis=1), depths)


def washer_compliance(flank: HalfGroove, washer: Washer, fineness: float = 1.0) -> groove.GrooveRingCompliance:
    """Return the compliance of a washer between narrow load patches in its groove.

    The back is held. The washer of the other flank is the mirror image, and a load on one does not move the other.

    ``flank``: groove of the ring; ``washer``: its cross-section; ``fineness``: factor on the numbers of elements.
    """
    m, grid = flank.groove_map, washer_grid(washer, fineness)
    radius, width = flank.contact_position()[0], NARROW * m.ball
    upright = fourier.QuadrilateralGrid(grid.z[::-1], grid.r[::-1])  # so that its second coordinate rises along the face
    share = groove.gaussian_patch_weights(upright, 0, radius, width)[0][::-1]
    nominal = m.signs[flank.flank_number] * np.array([np.cos(m.beta), np.sin(m.beta)])
    normals = groove.flank_normals(grid, 0)
    rows = np.zeros((3, *grid.shape, 3))
    rows[0, :, 0, 0] = rows[1, :, 0, 2] = share
    rows[2, :, 0, ::2] = share[:, None] * normals * np.sign(normals @ nominal)[:, None]
    held = np.zeros((*grid.shape, 3), dtype=bool)
    held[:, -1] = True
    body, free = fourier.BodyOfRevolution(grid, flank.material), ~held.ravel()
    bands, loads = body.stiffness_bands(free), rows.reshape(3, -1)[:, free].T
    n = groove.sampled_harmonics(2.6 * radius / width)
    sampled = np.array([loads.T @ fourier.solve_harmonic_displacements(bands, k, loads) for k in n.tolist()])
    S = groove.interpolate_harmonics(n, sampled)
    whole: Array = np.zeros((len(S), 4, 4))
    whole[:, 2:, 2:] = S[:, :2, :2]
    whole[:, :2, :2] = S[:, :2, :2] * np.outer(MIRROR, MIRROR)
    turned = S[:, 2, 2] - np.einsum("a,nab,b->n", nominal, S[:, :2, :2], nominal)
    factors = groove.gaussian_patch_harmonic_factors(np.arange(n[-1] + 1.0), width, radius)
    return groove.GrooveRingCompliance(whole, float(factors @ turned), width, radius)
