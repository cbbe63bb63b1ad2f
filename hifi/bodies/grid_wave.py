"""What the place of a contact on its grid does to its approach, and how to take it out.

The continuous contact does not know where the grid lies. On the grid the approach under a force waves as the edge of
the contact passes rows of nodes; its slope, by which loads share out, waves several times as much. The wave is periodic
in the place of the contact, in both directions, with the cells (their nodes carry unlike weights, so that not every
row of nodes is like the next), so that it is gone in the mean over the places in a cell; and that goes by a smooth law
of the force (`smooth`). So each contact's gaps are corrected by that law less the approach at its own place, both of
one contact pressed straight in with all the compliance of its submodels (the wave's phase follows the ellipse, and that
what the body adds to the gap): a correction that vanishes with the cells.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.linalg.lapack import dpotrs

from rollbench.hifi.bodies.patch import CondensedPatch
from rollbench.hifi.contact.balls import picked_factor
from rollbench.hifi.contact.hertz import HertzSolution, hertz
from rollbench.hifi.elements.forms import mean_weights
from rollbench.meshes.arrays import Array
from rollbench.meshes.ball_body import directions
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import Material

Flags = NDArray[np.bool_]

#: Places in a cell across and along the groove, and forces, at which the wave is tabulated; the long axis of the ellipse
#: lies across, its pointed ends pass rows of nodes more suddenly.
ACROSS, ALONG, FORCES = 12, 8, 24
#: Places in a cell across and along over which only a mean is taken.
MEAN = (8, 8)
#: Powers of the force in an approach over Hertz's: of second-order cells beside the ellipse, none, of the body around the
#: contact (as the force), of curvatures that change over the ellipse.
POWERS = (-2.0 / 3.0, 0.0, 1.0 / 3.0, 2.0 / 3.0)
#: Part of its zone that the largest ellipse fills; least short semi-axis over the cell, and over the largest one where that
#: asks for more.
FILLED, COARSEST, LEAST = 0.85, 1.0, 0.6


def unit_hertz(m: GrooveMap, side: int, material: Material) -> HertzSolution:
    """Hertz's contact of a side under 1 N; approach as F^(2/3), semi-axes across and along the groove as F^(1/3)."""
    return hertz(1.0, *m.relative_radii(side, m.beta), material.youngs_modulus, material.poissons_ratio)


def cell_sizes(m: GrooveMap, side: int, patch: CondensedPatch) -> Array:
    """Sizes ``(2,)`` [m] of the cells of a contact's grid across and along the groove. ValueError without a grid."""
    if patch.shape is None:
        raise ValueError("only a patch of hexahedra has a grid")
    _, tangent, forward = directions(m, side)
    n, k = (count // 2 for count in patch.shape)
    x = patch.points.reshape(*patch.shape, 3)
    return np.array([(x[n + 1, k] - x[n - 1, k]) @ tangent, (x[n, k + 1] - x[n, k - 1]) @ forward])


def resolved_forces(m: GrooveMap, side: int, patch: CondensedPatch, material: Material, count: int) -> Array:
    """Forces ``(count,)`` [N] over which a patch resolves a contact: from a short semi-axis of one cell to its zone.

    On a grid too coarse for that, from a part of the largest ellipse.
    """
    unit, cells = unit_hertz(m, side, material), np.abs(cell_sizes(m, side, patch))
    assert patch.shape is not None
    half = 0.5 * cells * (np.array(patch.shape) // 2)
    high = FILLED * min(half[0] / unit.semi_x, half[1] / unit.semi_y)
    return np.asarray(np.geomspace(min(COARSEST * cells[1] / unit.semi_y, LEAST * high), high, count) ** 3)


def approaches_at(
    m: GrooveMap,
    side: int,
    patch: CondensedPatch,
    compliance: Array,
    loads: Array,
    place: tuple[float, float],
    start: Flags | None = None,
) -> tuple[Array, Flags]:
    """Approaches ``(f,)`` [m] under ``loads`` ``(f,)`` [N] of a contact of own compliance ``(c, c)``, pressed straight in
    along the normal at its place, and its closed pairs ``(f, c)``.

    place: of the contact beside the nominal one, across and along, in cells; start: closed pairs of a neighbouring place.
    """
    W = mean_weights(patch.weights)
    normal, tangent, forward = directions(m, side)
    x = patch.points - np.array([m.R, 0.0, 0.0])
    # the ball's centre moved by t: the gap is least t times (relative radius / r) beside the nominal contact
    scale = m.ball / np.array(m.relative_radii(side, m.beta))
    beside = cell_sizes(m, side, patch) * np.array(place)
    t = scale * beside
    gap = np.linalg.norm(x - t[0] * tangent - t[1] * forward, axis=1) - m.ball
    nearest = -0.5 * float((t**2 / m.ball * (1.0 / scale - 1.0)).sum())
    along = normal + (beside[0] * tangent + beside[1] * forward) / m.ball
    close = W @ (patch.normals @ (along / np.linalg.norm(along)))
    approach, closed = approaches(compliance, W @ gap, close, loads, start)
    return approach - nearest, closed


def approaches(C: Array, gap: Array, close: Array, loads: Array, start: Flags | None = None) -> tuple[Array, Flags]:
    """Approaches ``(f,)`` [m] of a unilateral contact of symmetric C under ``loads`` [N], and its closed pairs ``(f, c)``:
    pressures p >= 0, C p + gap - approach close >= 0, and close p the load.

    start: closed pairs to begin with, else those of the load before. Raises ValueError where the active set does not
    settle.
    """
    active = gap / close <= np.quantile(gap / close, 0.3)
    columns = np.column_stack([close, gap])
    out, closed = np.empty(loads.size), np.empty((loads.size, gap.size), dtype=bool)
    for k, load in enumerate(loads):
        active = active if start is None else start[k]
        for _ in range(200):
            i = np.flatnonzero(active)
            unit, by_gap = dpotrs(picked_factor(C, i), columns[i], lower=1)[0].T
            out[k] = (load + close[i] @ by_gap) / (close[i] @ unit)
            pressure = out[k] * unit - by_gap
            after = pressure @ C[i] + gap - close * out[k] < 0.0
            after[i] = pressure > 0.0
            if (after == active).all():
                break
            active = after
        else:
            raise ValueError(f"the contact of a patch under {load:.4g} N does not settle")
        closed[k] = active
    return out, closed


def smooth(loads: Array, approach: Array) -> Array:
    """Approaches ``(f,)`` [m] by the law of the force that fits them best: Hertz's F^(2/3) times a sum of ``POWERS`` of F,
    equal weights of relative errors."""
    basis = loads[:, None] ** (2.0 / 3.0 + np.array(POWERS)) / approach[:, None]
    return np.asarray(approach * (basis @ np.linalg.lstsq(basis, np.ones(loads.size), rcond=None)[0]))


def periodic_approaches(
    m: GrooveMap, side: int, patch: CondensedPatch, C: Array, loads: Array, counts: tuple[int, int]
) -> tuple[Array, Array]:
    """Approaches ``(across, along, f)`` [m] of a contact of compliance ``(c, c)`` [m/N] under ``loads`` ``(f,)`` [N] at
    even places in a cell, from the middle of the zone on; ``counts`` of places, both even.

    They are without what changes from cell to cell: away from the middle of its zone a contact finds another compliance
    beneath it, which is physics and no wave. That is the trend ``(2, f)`` [m] by the place across and along, in cells, from
    places half a cell away on either side, which comes second.
    """

    def at(x: float, y: float, start: Flags | None) -> tuple[Array, Flags]:
        return approaches_at(m, side, patch, C, loads, (x, y), start)

    first = at(0.0, 0.0, None)[1]
    left, right, back, ahead = (at(*place, first)[0] for place in ((-0.5, 0.0), (0.5, 0.0), (0.0, -0.5), (0.0, 0.5)))
    trend, table = np.array([right - left, ahead - back]), np.empty((*counts, loads.size))
    for i, x in enumerate(np.arange(counts[0]) / counts[0] - 0.5):
        near = first
        for k, y in enumerate(np.arange(counts[1]) / counts[1] - 0.5):
            approach, near = at(float(x), float(y), near)
            table[i, k] = approach - np.array([x, y]) @ trend
            first = near if k == 0 else first
    return np.asarray(np.fft.ifftshift(table, axes=(0, 1))), trend


def mean_approaches(m: GrooveMap, side: int, patch: CondensedPatch, compliance: Array, loads: Array) -> Array:
    """Approaches ``(f,)`` [m] of a contact in the middle of its zone without the grid's wave: mean over a cell."""
    return np.asarray(periodic_approaches(m, side, patch, compliance, loads, MEAN)[0].mean(axis=(0, 1)))


@dataclass(frozen=True)
class GridWave:
    """Correction of the gap of a side's contacts: forces ``(f,)`` [N], table ``(p, q, f)`` [m] at even places in a cell
    across and along the groove, that of the middle node first; sizes of a cell ``(2,)`` and the middle node ``(3,)`` [m],
    directions across and along ``(2, 3)``."""

    loads: Array
    table: Array
    cell: Array
    middle: Array
    directions: Array

    def at(self, loads: Array, centres: Array) -> Array:
        """Corrections ``(n,)`` [m] for loads ``(n,)`` [N] whose pressures have centres ``(n, 3)`` [m] in the ball's frame.

        Beyond the tabulated forces as at the nearest, in proportion to Hertz's approach. No load, no correction.
        """
        place = (centres - self.middle) @ self.directions.T / self.cell
        force = np.clip(loads, self.loads[0], self.loads[-1])
        correction = CubicSpline(np.log(self.loads), self.table, axis=2)(np.log(force))  # (p, q, n)
        for coordinate in place.T:
            correction = _periodic(correction, coordinate)
        return np.where(loads > 0.0, correction * np.cbrt(np.maximum(loads, 0.0) / force) ** 2, 0.0)


def _periodic(values: Array, place: Array) -> Array:
    """Values ``(..., n)`` at places ``(n,)`` of period 1 between even ones ``(p, ..., n)``, each column at its own."""
    grid = np.linspace(0.0, 1.0, len(values) + 1)
    around = CubicSpline(grid, np.concatenate([values, values[:1]]), bc_type="periodic")(np.mod(place, 1.0))
    return np.asarray(np.einsum("n...n->...n", around))


def grid_wave(m: GrooveMap, side: int, patch: CondensedPatch, C: Array, material: Material) -> GridWave:
    """Table of the smooth law less the approach at a contact's own place."""
    loads = resolved_forces(m, side, patch, material, FORCES)
    table = periodic_approaches(m, side, patch, C, loads, (ACROSS, ALONG))[0]
    assert patch.shape is not None
    middle = patch.points.reshape(*patch.shape, 3)[patch.shape[0] // 2, patch.shape[1] // 2]
    correction = smooth(loads, table.mean(axis=(0, 1))) - table
    return GridWave(loads, correction, cell_sizes(m, side, patch), middle, directions(m, side)[1:])
