"""Compliance of the washers of a thrust ball bearing: bodies of revolution with a groove in the face, held at the back."""

from __future__ import annotations

import numpy as np

from rollbench.lowfi.compliance import fourier, groove
from rollbench.lowfi.compliance.beyond_hertz import NARROW
from rollbench.lowfi.compliance.tube import HalfGroove
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
    grid = washer_grid(washer, fineness)
    radius, width = flank.contact_position()[0], NARROW * flank.groove_map.ball
    upright = fourier.QuadrilateralGrid(grid.z[::-1], grid.r[::-1])  # so that its second coordinate rises along the face
    share = groove.gaussian_patch_weights(upright, 0, radius, width)[::-1]
    normals = groove.flank_normals(grid, 0)
    rows = np.zeros((3, *grid.shape, 3))
    rows[0, :, 0, 0] = rows[1, :, 0, 2] = share
    rows[2, :, 0, ::2] = share[:, None] * normals * np.sign(normals @ flank.nominal_normal)[:, None]
    held = np.zeros((*grid.shape, 3), dtype=bool)
    held[:, -1] = True
    body = fourier.BodyOfRevolution(grid, flank.material)
    S, correction = groove.patch_harmonics_and_correction(flank, body, held, rows, width)
    whole: Array = np.zeros((len(S), 4, 4))
    whole[:, 2:, 2:] = S[:, :2, :2]
    whole[:, :2, :2] = S[:, :2, :2] * np.outer(MIRROR, MIRROR)
    return groove.GrooveRingCompliance(whole, correction, width, radius)
