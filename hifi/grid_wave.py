"""What the place of a contact on its grid does to its approach, and how to take it out.

The continuous contact does not know where the grid lies. On the grid the approach under a force waves as the edge of
the contact passes rows of nodes; its slope, by which loads share out, waves several times as much. The wave is periodic
in the place of the contact, with the distance of the nodes, so that little of it is left in the mean over four places a
quarter of that apart, in both directions; and that goes by a smooth law of the force (`smooth`). So each contact's gaps
are corrected by that law less the approach at its own place, both of one contact pressed straight in with all the
compliance of its submodels (the wave's phase follows the ellipse, and that what the body adds to the gap): a correction
that vanishes with the cells.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from hifi.hertz import HertzSolution, hertz
from hifi.patch import CondensedPatch
from hifi.pressures import mean_weights
from meshes.groove_map import GrooveMap
from meshes.parts import Material

Array = NDArray[np.float64]

#: Places of a contact beside a node, in distances of the nodes, whose mean has no wave.
QUARTERS = (-0.375, -0.125, 0.125, 0.375)
PLACES = tuple(product(QUARTERS, QUARTERS))
#: Places across the groove and forces at which the wave is tabulated.
ACROSS, FORCES = 16, 64
#: Powers of the force in an approach over Hertz's: of second-order cells beside the ellipse, none, of the body around the
#: contact (as the force), of curvatures that change over the ellipse.
POWERS = (-2.0 / 3.0, 0.0, 1.0 / 3.0, 2.0 / 3.0)
#: Part of its zone that the largest ellipse fills; least short semi-axis over the cell, and over the largest one where that
#: asks for more.
FILLED, COARSEST, LEAST = 0.85, 1.0, 0.6


def relative_radii(m: GrooveMap, side: int) -> tuple[float, float]:
    """Relative radii [m] of ball and groove across and along it, by the normal curvatures of the helical groove."""
    part = m.signs[side, 0] * np.cos(m.beta)
    along = part * np.cos(m.alpha) ** 2 / (m.R + part * m.ball)
    return 1.0 / (1.0 / m.ball - 1.0 / float(m.radius[side])), 1.0 / (1.0 / m.ball - along)


def contact_frame(m: GrooveMap, side: int) -> tuple[Array, Array, Array]:
    """Nominal normal (ball to groove), tangent across the groove, direction along it."""
    radial = np.array([1.0, 0.0, 0.0])
    binormal = np.array([0.0, -np.sin(m.alpha), np.cos(m.alpha)])
    forward = np.array([0.0, np.cos(m.alpha), np.sin(m.alpha)])
    sx, sz = m.signs[side]
    normal = sx * np.cos(m.beta) * radial + sz * np.sin(m.beta) * binormal
    return normal, -sx * np.sin(m.beta) * radial + sz * np.cos(m.beta) * binormal, forward


def unit_hertz(m: GrooveMap, side: int, material: Material) -> HertzSolution:
    """Hertz's contact of a side under 1 N; approach as F^(2/3), semi-axes across and along the groove as F^(1/3)."""
    return hertz(1.0, *relative_radii(m, side), material.youngs_modulus, material.poissons_ratio)


def node_steps(m: GrooveMap, side: int, patch: CondensedPatch) -> Array:
    """Distances ``(2,)`` [m] of the nodes of a contact's grid across and along the groove. ValueError without a grid."""
    if patch.shape is None:
        raise ValueError("only a patch of hexahedra has a grid")
    _, tangent, forward = contact_frame(m, side)
    n, k = patch.shape
    x = patch.points.reshape(n, k, 3)
    middle, beside, ahead = x[n // 2, k // 2], x[n // 2 + 1, k // 2], x[n // 2, k // 2 + 1]
    return np.array([(beside - middle) @ tangent, (ahead - middle) @ forward])


def resolved_forces(m: GrooveMap, side: int, patch: CondensedPatch, material: Material, count: int) -> Array:
    """Forces ``(count,)`` [N] over which a patch resolves a contact: from a short semi-axis of one cell to its zone.

    On a grid too coarse for that, from a part of the largest ellipse.
    """
    unit, steps = unit_hertz(m, side, material), np.abs(node_steps(m, side, patch))
    assert patch.shape is not None
    half = steps * (np.array(patch.shape) // 2)
    high = FILLED * min(half[0] / unit.semi_x, half[1] / unit.semi_y)
    return np.asarray(np.geomspace(min(COARSEST * 2.0 * steps[1] / unit.semi_y, LEAST * high), high, count) ** 3)


def approaches_at(
    m: GrooveMap, side: int, patch: CondensedPatch, own: Array, loads: Array, place: tuple[float, float]
) -> Array:
    """Approaches ``(f,)`` [m] under ``loads`` ``(f,)`` [N] of a contact of own compliance ``(c, c)``, pressed straight in.

    place: of the contact beside the nominal one, across and along, in distances of the nodes.
    """
    W = mean_weights(patch.weights)
    normal, tangent, forward = contact_frame(m, side)
    x = patch.points - np.array([m.R, 0.0, 0.0])
    # the ball's centre moved by t: the gap is least t times (relative radius / r) beside the nominal contact
    scale = m.ball / np.array(relative_radii(m, side))
    t = scale * node_steps(m, side, patch) * np.array(place)
    gap = np.linalg.norm(x - t[0] * tangent - t[1] * forward, axis=1) - m.ball
    nearest = -0.5 * float((t**2 / m.ball * (1.0 / scale - 1.0)).sum())
    return approaches(own, W @ gap, W @ (patch.normals @ normal), loads) - nearest


def approaches(C: Array, gap: Array, close: Array, loads: Array) -> Array:
    """Approach [m] of a unilateral contact under ``loads`` [N]: pressures p >= 0, C p + gap - approach close >= 0, and
    close p the load. Raises ValueError where the active set does not settle."""
    active = gap / close <= np.quantile(gap / close, 0.3)
    out = np.empty(loads.size)
    for k, load in enumerate(loads):
        for _ in range(200):
            i = np.flatnonzero(active)
            K = np.zeros((i.size + 1, i.size + 1))
            K[:-1, :-1], K[:-1, -1], K[-1, :-1] = C[np.ix_(i, i)], -close[i], close[i]
            found = np.linalg.solve(K, np.append(-gap[i], load))
            pressure = np.zeros(gap.size)
            pressure[i], out[k] = found[:-1], found[-1]
            after = (active & (pressure > 0.0)) | (~active & (C @ pressure + gap - close * out[k] < 0.0))
            if (after == active).all():
                break
            active = after
        else:
            raise ValueError(f"the contact of a patch under {load:.4g} N does not settle")
    return out


def smooth(loads: Array, approach: Array) -> Array:
    """Approaches ``(f,)`` [m] by the law of the force that fits them best: Hertz's F^(2/3) times a sum of ``POWERS`` of F,
    equal weights of relative errors."""
    basis = loads[:, None] ** (2.0 / 3.0 + np.array(POWERS)) / approach[:, None]
    return np.asarray(approach * (basis @ np.linalg.lstsq(basis, np.ones(loads.size), rcond=None)[0]))


@dataclass(frozen=True)
class PeriodicApproach:
    """Approach of a contact over its place on the grid, without what changes from node to node: away from the middle of its
    zone a contact finds another compliance beneath it, which is physics and no wave.

    loads ``(f,)`` [N]; trend ``(4, f)`` [m]: by the place across, its square, that along and its square, in distances of
    the nodes, from the places one node away on every side.
    """

    m: GrooveMap
    side: int
    patch: CondensedPatch
    C: Array
    loads: Array
    trend: Array

    @classmethod
    def of(cls, m: GrooveMap, side: int, patch: CondensedPatch, C: Array, loads: Array) -> PeriodicApproach:
        """Of a contact of compliance ``(c, c)`` [m/N] under ``loads`` ``(f,)`` [N]."""
        middle, *around = (
            approaches_at(m, side, patch, C, loads, (float(x), float(y)))
            for x, y in ((0, 0), (-1, 0), (1, 0), (0, -1), (0, 1))
        )
        trend = [
            term
            for before, after in (around[:2], around[2:])
            for term in (0.5 * (after - before), 0.5 * (after + before) - middle)
        ]
        return cls(m, side, patch, C, loads, np.array(trend))

    def at(self, place: tuple[float, float]) -> Array:
        """Approaches ``(f,)`` [m] at a place, less the trend."""
        x, y = place
        found = approaches_at(self.m, self.side, self.patch, self.C, self.loads, place)
        return np.asarray(found - np.array([x, x * x, y, y * y]) @ self.trend)

    def mean(self) -> Array:
        """Mean ``(f,)`` [m] over `PLACES`: without the grid's wave."""
        return np.asarray(np.mean([self.at(place) for place in PLACES], axis=0))


def mean_approaches(m: GrooveMap, side: int, patch: CondensedPatch, own: Array, loads: Array) -> Array:
    """Approaches ``(f,)`` [m] of a contact in the middle of its zone without the grid's wave: mean over `PLACES`."""
    return PeriodicApproach.of(m, side, patch, own, loads).mean()


@dataclass(frozen=True)
class GridWave:
    """Correction of the gap of a side's contacts: forces ``(f,)`` [N], table ``(p, f)`` [m] over places across the groove
    from 0 to 1 distance of the nodes (the last is the first), that distance [m] and the middle node's place ``(3,)`` [m],
    tangent across the groove ``(3,)``."""

    loads: Array
    table: Array
    step: float
    middle: Array
    tangent: Array

    def at(self, loads: Array, centres: Array) -> Array:
        """Corrections ``(n,)`` [m] for loads ``(n,)`` [N] whose pressures have centres ``(n, 3)`` [m] in the ball's frame.

        Beyond the tabulated forces as at the nearest, in proportion to Hertz's approach. No load, no correction.
        """
        place = np.mod((centres - self.middle) @ self.tangent / self.step, 1.0)
        force = np.clip(loads, self.loads[0], self.loads[-1])
        along = CubicSpline(np.log(self.loads), self.table, axis=1)(np.log(force))  # (p, n)
        grid = np.linspace(0.0, 1.0, len(along))
        around = CubicSpline(grid, along, bc_type="periodic")
        found = around(place)[np.arange(place.size), np.arange(place.size)]
        return np.where(loads > 0.0, found * np.cbrt(np.maximum(loads, 0.0) / force) ** 2, 0.0)


def grid_wave(m: GrooveMap, side: int, patch: CondensedPatch, C: Array, material: Material) -> GridWave:
    """Table of the smooth law less the approach at a contact's own place; along the groove contacts lie in the middle."""
    loads = resolved_forces(m, side, patch, material, FORCES)
    places = np.linspace(-0.5, 0.5, ACROSS, endpoint=False)
    approach = PeriodicApproach.of(m, side, patch, C, loads)
    table = smooth(loads, approach.mean()) - np.array([approach.at((float(x), 0.0)) for x in np.roll(places, ACROSS // 2)])
    assert patch.shape is not None
    n, k = patch.shape
    middle = patch.points.reshape(n, k, 3)[n // 2, k // 2]
    step = float(node_steps(m, side, patch)[0])
    return GridWave(loads, np.vstack([table, table[:1]]), step, middle, contact_frame(m, side)[1])
