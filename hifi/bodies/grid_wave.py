"""Dependence of a contact's approach on its position on the mesh grid, and the correction that removes it.

The continuous contact does not depend on the grid. On the grid the approach under a force oscillates as the edge of the
contact passes rows of nodes; its slope, which governs how loads are shared, oscillates several times as much. This "grid
wave" is periodic in the position of the contact, in both directions, with the period of a cell. (The nodes of a cell have
unequal weights, so that a row of nodes is not like the next one.) It therefore vanishes in the mean over the positions in a
cell, and the mean follows a smooth law of the force (`fit_smooth_force_law`).

Each contact's gaps are corrected by that law less the approach at the contact's position. Both are computed for one contact
pressed straight in, with the whole compliance of finely meshed pieces of both bodies (`hifi.bodies.coarse`): where the
oscillation begins depends on the size of the ellipse, and that on the compliance of the bodies around the contact. The
correction vanishes with the cell size.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.linalg.lapack import dpotrs

from rollbench.hifi.bodies.patch import CondensedPatch
from rollbench.hifi.contact.balls import cholesky_of_selected_rows
from rollbench.hifi.contact.hertz import HertzSolution, solve_hertz
from rollbench.hifi.elements.forms import normalise_weight_rows
from rollbench.meshes.arrays import Array
from rollbench.meshes.ball_body import contact_frame_vectors
from rollbench.meshes.groove_map import GrooveMap
from rollbench.meshes.parts import Material

Flags = NDArray[np.bool_]

#: Numbers of positions in a cell across and along the groove, and of forces, at which the grid wave is tabulated. The long
#: axis of the ellipse lies across the groove, and its pointed ends pass rows of nodes more suddenly.
ACROSS, ALONG, FORCES = 12, 8, 24
#: Numbers of positions in a cell, across and along the groove, over which an approach is averaged.
MEAN = (8, 8)
#: Powers of the force in the ratio of the approach to Hertz's approach. They represent second-order cells at the edge of
#: the ellipse (-2/3), Hertz's law (0), the body around the contact, in proportion to the force (1/3), and curvatures that
#: change over the ellipse (2/3).
POWERS = (-2.0 / 3.0, 0.0, 1.0 / 3.0, 2.0 / 3.0)
#: Size of the largest contact ellipse over that of the contact zone; smallest short semi-axis over the cell size; size of
#: the smallest ellipse over that of the largest one, on grids that are too coarse for that semi-axis.
FILLED, COARSEST, LEAST = 0.85, 1.0, 0.6


def hertz_contact_under_unit_force(m: GrooveMap, side: int, material: Material) -> HertzSolution:
    """Solve the Hertz contact of ball and groove at a flank under 1 N, with x across the groove and y along it.

    The approach grows as F^(2/3), the semi-axes as F^(1/3).

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
    material : Material
        Material of both bodies.

    Returns
    -------
    HertzSolution
        Approach, semi-axes and pressure under 1 N.
    """
    return solve_hertz(1.0, *m.relative_curvature_radii(side, m.beta), material.youngs_modulus, material.poissons_ratio)


def grid_cell_sizes(m: GrooveMap, side: int, patch: CondensedPatch) -> Array:
    """Compute the cell sizes of the mesh grid in a contact zone, across and along the groove.

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
    patch : CondensedPatch
        Condensed fine mesh (patch) of the groove at the contact.

    Returns
    -------
    (2,) Array
        Cell sizes [m]; negative in a direction in which the indices of the grid's nodes fall.

    Raises
    ------
    ValueError
        The patch has no grid.
    """
    if patch.contact_grid_shape is None:
        raise ValueError(
            "the contact nodes of a mesh form no grid, so that its cell sizes are unknown: use a mesh of hexahedra"
        )
    _, tangent, forward = contact_frame_vectors(m, side)
    n, k = (count // 2 for count in patch.contact_grid_shape)
    x = patch.contact_points.reshape(*patch.contact_grid_shape, 3)
    return np.array([(x[n + 1, k] - x[n - 1, k]) @ tangent, (x[n, k + 1] - x[n, k - 1]) @ forward])


def forces_resolved_by_grid(m: GrooveMap, side: int, patch: CondensedPatch, material: Material, count: int) -> Array:
    """Choose contact forces whose contact ellipse is neither too small for the mesh grid nor larger than the contact zone.

    Under the largest force the ellipse nearly fills the contact zone (`FILLED`). Under the smallest force the short
    semi-axis is one cell long; on grids too coarse for that, the ellipse is `LEAST` times as long as under the largest
    force.

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
    patch : CondensedPatch
        Condensed fine mesh (patch) of the groove at the contact.
    material : Material
        Material of ball and groove.
    count : int
        Number of forces.

    Returns
    -------
    (count,) Array
        Forces [N], ascending.
    """
    unit, cells = hertz_contact_under_unit_force(m, side, material), np.abs(grid_cell_sizes(m, side, patch))
    assert patch.contact_grid_shape is not None
    half = 0.5 * cells * (np.array(patch.contact_grid_shape) // 2)
    high = FILLED * min(half[0] / unit.semi_x, half[1] / unit.semi_y)
    return np.asarray(np.geomspace(min(COARSEST * cells[1] / unit.semi_y, LEAST * high), high, count) ** 3)


def approaches_at_grid_position(
    m: GrooveMap,
    side: int,
    patch: CondensedPatch,
    compliance: Array,
    loads: Array,
    grid_position: tuple[float, float],
    first_guess: Flags | None = None,
) -> tuple[Array, Flags]:
    """Compute the approach of ball and groove under several normal forces, for a contact at a given position on its grid.

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
    patch : CondensedPatch
        Condensed fine mesh (patch) of the groove at the contact.
    compliance : (c, c) Array
        Compliance between the c contact nodes [m/N].
    loads : (f,) Array
        Forces [N].
    grid_position : tuple[float, float]
        Distances of the contact from its nominal position, across and along the groove, as numbers of cells.
    first_guess : (f, c) Flags, optional, default None
        First guess: whether each contact pair is closed, as at a neighbouring position; None: no guess.

    Returns
    -------
    approach : (f,) Array
        Approach under each force [m].
    closed : (f, c) Flags
        Whether each contact pair is closed under each force.

    Raises
    ------
    ValueError
        The set of closed pairs does not converge.
    """
    W = normalise_weight_rows(patch.pressure_weights)
    normal, tangent, forward = contact_frame_vectors(m, side)
    x = patch.contact_points - np.array([m.R, 0.0, 0.0])
    # the ball's centre moved by t: the gap is least at t times (relative radius / r) from the nominal contact
    scale = m.ball / np.array(m.relative_curvature_radii(side, m.beta))
    beside = grid_cell_sizes(m, side, patch) * np.array(grid_position)
    t = scale * beside
    gap = np.linalg.norm(x - t[0] * tangent - t[1] * forward, axis=1) - m.ball
    nearest = -0.5 * float((t**2 / m.ball * (1.0 / scale - 1.0)).sum())
    along = normal + (beside[0] * tangent + beside[1] * forward) / m.ball
    close = W @ (patch.normals @ (along / np.linalg.norm(along)))
    approach, closed = solve_unilateral_contact(compliance, W @ gap, close, loads, first_guess)
    return approach - nearest, closed


def solve_unilateral_contact(
    C: Array, gap: Array, gap_closing: Array, loads: Array, first_guess: Flags | None = None
) -> tuple[Array, Flags]:
    """Compute the approach of two bodies in unilateral contact under several loads.

    Nodal forces p >= 0 and gaps C p + gap - approach * gap_closing >= 0 are complementary: at each node one of the two is
    zero. The sum of gap_closing * p equals the load.

    Parameters
    ----------
    C : (c, c) Array
        Compliance between the c contact nodes, symmetric [m/N].
    gap : (c,) Array
        Gaps of the undeformed bodies [m].
    gap_closing : (c,) Array
        Gap closed at each node by a unit of the approach.
    loads : (f,) Array
        Loads [N].
    first_guess : (f, c) Flags, optional, default None
        First guess: whether each pair is closed under each load; None: the pairs that are closed under the load before.

    Returns
    -------
    approach : (f,) Array
        Approach under each load [m].
    closed : (f, c) Flags
        Whether each pair is closed under each load.

    Raises
    ------
    ValueError
        The set of closed pairs does not converge.
    """
    active = gap / gap_closing <= np.quantile(gap / gap_closing, 0.3)
    columns = np.column_stack([gap_closing, gap])
    out, closed = np.empty(loads.size), np.empty((loads.size, gap.size), dtype=bool)
    for k, load in enumerate(loads):
        active = active if first_guess is None else first_guess[k]
        for _ in range(200):
            i = np.flatnonzero(active)
            unit, by_gap = dpotrs(cholesky_of_selected_rows(C, i), columns[i], lower=1)[0].T
            out[k] = (load + gap_closing[i] @ by_gap) / (gap_closing[i] @ unit)
            pressure = out[k] * unit - by_gap
            after = pressure @ C[i] + gap - gap_closing * out[k] < 0.0
            after[i] = pressure > 0.0
            if (after == active).all():
                break
            active = after
        else:
            raise ValueError(
                f"contact on a mesh under {load:.4g} N: the set of nodes in contact still changes after 200 iterations; "
                "change the load or the mesh"
            )
        closed[k] = active
    return out, closed


def fit_smooth_force_law(loads: Array, approach: Array) -> Array:
    """Fit a smooth law to approaches under several forces F: Hertz's F^(2/3) times a linear combination of powers of F.

    The powers are `POWERS`. The fit minimises the squares of relative errors.

    Parameters
    ----------
    loads : (f,) Array
        Forces [N].
    approach : (f,) Array
        Approaches [m].

    Returns
    -------
    (f,) Array
        Fitted approaches [m].

    Examples
    --------
    >>> force = np.array([1.0, 8.0, 27.0, 64.0, 125.0])
    >>> bool(np.allclose(fit_smooth_force_law(force, 1e-6 * np.cbrt(force) ** 2), 1e-6 * np.cbrt(force) ** 2))
    True
    """
    basis = loads[:, None] ** (2.0 / 3.0 + np.array(POWERS)) / approach[:, None]
    return np.asarray(approach * (basis @ np.linalg.lstsq(basis, np.ones(loads.size), rcond=None)[0]))


def approaches_over_grid_cell(
    m: GrooveMap, side: int, patch: CondensedPatch, C: Array, loads: Array, counts: tuple[int, int]
) -> tuple[Array, Array]:
    """Compute the approach of ball and groove for a contact at evenly spaced positions within one cell of its mesh grid.

    The linear trend across the cell is subtracted, because it is physical and not an effect of the grid: the compliance of
    the body varies with the position of the contact. The trend is the change of the approach between positions half a cell
    away on either side.

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
    patch : CondensedPatch
        Condensed fine mesh (patch) of the groove at the contact.
    C : (c, c) Array
        Compliance between the c contact nodes [m/N].
    loads : (f,) Array
        Forces [N].
    counts : tuple[int, int]
        Numbers of positions in a cell across and along the groove, both even.

    Returns
    -------
    table : (across, along, f) Array
        Approach at each position and force [m]; the first position is the middle of the zone.
    trend : (2, f) Array
        Change of the approach across and along the groove [m per cell].
    """

    def approaches_at(x: float, y: float, start: Flags | None) -> tuple[Array, Flags]:
        return approaches_at_grid_position(m, side, patch, C, loads, (x, y), start)

    first = approaches_at(0.0, 0.0, None)[1]
    half_cells_away = (-0.5, 0.0), (0.5, 0.0), (0.0, -0.5), (0.0, 0.5)
    left, right, back, ahead = (approaches_at(*place, first)[0] for place in half_cells_away)
    trend, table = np.array([right - left, ahead - back]), np.empty((*counts, loads.size))
    for i, x in enumerate(np.arange(counts[0]) / counts[0] - 0.5):
        near = first
        for k, y in enumerate(np.arange(counts[1]) / counts[1] - 0.5):
            approach, near = approaches_at(float(x), float(y), near)
            table[i, k] = approach - np.array([x, y]) @ trend
            first = near if k == 0 else first
    return np.asarray(np.fft.ifftshift(table, axes=(0, 1))), trend


@dataclass(frozen=True)
class GapCorrectionTable:
    """Table of gap corrections that cancel the dependence of a contact's approach on its position on the mesh grid."""

    #: Contact forces at which the gap corrections are tabulated ``(f,)`` [N].
    tabulated_loads: Array
    #: Corrections of the gap for p contact positions across and q along the groove, evenly spaced in a grid cell
    #: ``(p, q, f)`` [m]; the first position is the middle node.
    gap_corrections: Array
    #: Cell sizes of the mesh grid across and along the groove ``(2,)`` [m].
    cell_sizes: Array
    #: Position of the contact zone's middle node in the ball's frame ``(3,)`` [m].
    middle_node: Array
    #: Unit vectors of the mesh grid across and along the groove ``(2, 3)``.
    grid_directions: Array

    def interpolate(self, loads: Array, centres: Array) -> Array:
        """Interpolate in the table the gap corrections of n contacts for their loads and positions.

        Beyond the tabulated forces, the correction at the nearest force is scaled in proportion to Hertz's approach. A
        contact without load has no correction.

        Parameters
        ----------
        loads : (n,) Array
            Loads of the contacts [N].
        centres : (n, 3) Array
            Centres of pressure of the contacts, in the frames of their balls [m].

        Returns
        -------
        (n,) Array
            Corrections to be added to the gaps of each contact [m].
        """
        place = (centres - self.middle_node) @ self.grid_directions.T / self.cell_sizes
        force = np.clip(loads, self.tabulated_loads[0], self.tabulated_loads[-1])
        correction = CubicSpline(np.log(self.tabulated_loads), self.gap_corrections, axis=2)(np.log(force))  # (p, q, n)
        for coordinate in place.T:
            correction = _interpolate_periodic(correction, coordinate)
        return np.where(loads > 0.0, correction * np.cbrt(np.maximum(loads, 0.0) / force) ** 2, 0.0)


def _interpolate_periodic(values: Array, place: Array) -> Array:
    """Interpolate n periodic functions, one for each contact, at one position each ``(..., n)``.

    ``values``: values at p evenly spaced positions in a period of length 1 (p, ..., n); ``place``: positions (n,).
    """
    grid = np.linspace(0.0, 1.0, len(values) + 1)
    around = CubicSpline(grid, np.concatenate([values, values[:1]]), bc_type="periodic")(np.mod(place, 1.0))
    return np.asarray(np.einsum("n...n->...n", around))


def tabulate_gap_corrections(
    m: GrooveMap, side: int, patch: CondensedPatch, C: Array, material: Material
) -> GapCorrectionTable:
    """Tabulate the gap corrections of the contacts on one flank over positions in a grid cell and several forces.

    A correction is the approach by a smooth force law, fitted to the approaches, less the approach computed at the
    position.

    Parameters
    ----------
    m : GrooveMap
        Geometry of the track.
    side : int
        Groove flank: 0, 1 on the screw (left, right), 2, 3 on the nut.
    patch : CondensedPatch
        Condensed fine mesh (patch) of the groove at the contact.
    C : (c, c) Array
        Compliance between the c contact nodes [m/N].
    material : Material
        Material of ball and groove.

    Returns
    -------
    GapCorrectionTable
        Table of the corrections.
    """
    loads = forces_resolved_by_grid(m, side, patch, material, FORCES)
    table = approaches_over_grid_cell(m, side, patch, C, loads, (ACROSS, ALONG))[0]
    assert patch.contact_grid_shape is not None
    n, k = patch.contact_grid_shape
    middle = patch.contact_points.reshape(n, k, 3)[n // 2, k // 2]
    correction = fit_smooth_force_law(loads, table.mean(axis=(0, 1))) - table
    cells, directions = grid_cell_sizes(m, side, patch), contact_frame_vectors(m, side)[1:]
    return GapCorrectionTable(loads, correction, cells, middle, directions)
