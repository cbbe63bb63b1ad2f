"""One contact on a grid of rectangles: where it lies, its normal forces, and how tangential forces displace it.

Local axes: x against the flow of material through the contact (the leading edge lies at largest x), y across, and the
normal from body 1 (the ball) into body 2 (the groove). Freedoms of a patch of n cells: (n, 2) values along x and y, as
vectors of length 2 n with all x first. Forces are those on body 1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rollbench.hifi.contact.hertz import hertz
from rollbench.hifi.rolling.elements import Solids, influence
from rollbench.hifi.rolling.normal import press
from rollbench.hifi.rolling.regular import NORMAL, TANGENTS, Regular
from rollbench.meshes.arrays import Array, Index

#: Width of a grid over that of Hertz's ellipse.
MARGIN = 1.08
#: Step of the differences along the flow, in cells; a whole one sees the same place in every cell and is less exact.
STEP = 0.5
#: Points along each axis of Hertz's ellipse at which the displacement of finite bodies is taken.
POINTS = 12


@dataclass(frozen=True)
class Patch:
    """A contact of n cells: columns and rows of the cells ``(n, 2)`` on a grid, centres x, y ``(n, 2)`` [m], size of a cell
    ``(2,)`` [m], normal forces ``(n,)`` [N], the bodies, the approach [m]; what finite bodies add to half spaces (None:
    half spaces)."""

    cells: Index
    at: Array
    size: Array
    normal: Array
    solids: Solids
    approach: float
    regular: Regular | None = None

    @property
    def load(self) -> float:
        """Normal force [N]."""
        return float(self.normal.sum())

    def tangential(self, shift: float = 0.0) -> Array:
        """Compliance ``(2 n, 2 n)`` [m/N]: displacement of body 1 past body 2 at the cells' centres, ``shift`` [m]
        upstream.

        Of unit tangential forces, each uniform over its cell.
        """
        half_space = _matrix(self.cells, _table(self, shift))
        return half_space if self.regular is None else half_space + self.regular.block(self.at, TANGENTS, TANGENTS, shift)

    @property
    def strain(self) -> Array:
        """Rate ``(2 n,)`` of tangential displacement, per length of rolling, by the normal forces: like half spaces have
        none."""
        if self.regular is None:
            return np.zeros(2 * len(self.at))
        return np.asarray(-self.regular.slope(self.at, TANGENTS, NORMAL) @ self.normal)

    @property
    def sunk(self) -> float:
        """How far the contact's middle lies inside the undeformed ball [m]: half of the approach; with half spaces, whose
        radius of rolling is the ball's own, nothing."""
        return 0.0 if self.regular is None else 0.5 * self.approach

    @cached_property
    def transport(self) -> Array:
        """D ``(2 n, 2 n)`` [1/N]: rate of the elastic displacement, per length of rolling, of material at the cells'
        centres.

        Backward differences of second order, upstream by `STEP` cells: displacements are known everywhere, so that nothing
        is interpolated. The symmetric part of D is positive: forces do work on it that the differences lose.
        """
        step = STEP * float(self.size[0])
        half_space = _matrix(self.cells, _backward([_table(self, k * step) for k in range(3)], step))
        if self.regular is None:
            return half_space
        return half_space + _backward([self.regular.block(self.at, TANGENTS, TANGENTS, k * step) for k in range(3)], step)

    def scaled(self, length: float, force: float) -> Patch:
        """The patch of a similar contact: lengths and normal forces multiplied. Raises ValueError for finite bodies."""
        if self.regular is not None:
            raise ValueError("contacts of finite bodies are not similar")
        square = length * length
        out = replace(
            self, at=self.at * length, size=self.size * length, normal=self.normal * force, approach=self.approach * square
        )
        if "transport" in self.__dict__:  # [1/N]: compliance over length
            out.__dict__["transport"] = self.transport / square
        return out


def _table(patch: Patch, shift: float) -> Array:
    """Displacements ``(2 w - 1, 2 h - 1, 2, 2)`` [m/N] along tangents by a cell's unit forces, at all offsets of a grid of
    w by h cells, ``shift`` [m] upstream."""
    span = np.ptp(patch.cells, axis=0)
    dx, dy = patch.size
    x, y = np.meshgrid(np.arange(-span[0], span[0] + 1) * dx + shift, np.arange(-span[1], span[1] + 1) * dy, indexing="ij")
    return np.asarray(influence(x, y, dx, dy, patch.solids)[..., :2, :2] / (dx * dy))


def _backward(values: list[Array], step: float) -> Array:
    """Difference of second order, per length, of values now and one and two steps [m] upstream."""
    current, before, first = values
    return np.asarray((3.0 * current - 4.0 * before + first) / (2.0 * step))


def _matrix(cells: Index, table: Array) -> Array:
    """Values ``(2 n, 2 n)`` of a table of all offsets at those of ``cells`` ``(n, 2)`` from one another."""
    span, n = np.ptp(cells, axis=0), len(cells)
    line = cells @ (2 * span[1] + 1, 1)
    apart = line[:, None] - line + ((2 * span[1] + 1) * span[0] + span[1])
    out = np.empty((2, n, 2, n))
    for a in range(2):
        for b in range(2):
            out[a, :, b] = table[..., a, b].ravel()[apart]
    return out.reshape(2 * n, 2 * n)


def grid(shape: tuple[int, int], size: Array) -> tuple[Index, Array]:
    """Cells ``(n, 2)`` and centres ``(n, 2)`` [m] of a grid about the origin."""
    i, j = np.meshgrid(np.arange(shape[0]), np.arange(shape[1]), indexing="ij")
    cells = np.stack([i.ravel(), j.ravel()], axis=1)
    return cells, (cells + 0.5 - 0.5 * np.array(shape)) * size


def seen_radii(
    load: float, radii: tuple[float, float], young: float, poisson: float, regular: Regular | None
) -> tuple[float, float]:
    """Relative radii [m] along x and y of half spaces that touch as finite bodies do: by the curvatures of the displacement
    that these add under Hertz's pressure. Those of the bodies themselves without a kernel."""
    if regular is None:
        return radii
    ellipse = hertz(load, *radii, young, poisson)
    unit = (np.arange(POINTS) + 0.5) / POINTS * 2.0 - 1.0
    at = np.stack(np.meshgrid(unit * ellipse.semi_x, unit * ellipse.semi_y, indexing="ij"), axis=-1).reshape(-1, 2)
    pressure = np.nan_to_num(ellipse.pressure(at[:, 0], at[:, 1]))
    force = load * pressure / pressure.sum()
    added = regular.block(at, NORMAL, NORMAL) @ force
    weight = np.sqrt(force)
    rows = np.column_stack([np.ones(len(at)), at, 0.5 * at**2])
    bend = np.linalg.lstsq(rows * weight[:, None], added * weight, rcond=None)[0][-2:]
    one, two = 1.0 / (1.0 / np.array(radii) + bend)
    return float(one), float(two)


def hertz_patch(
    load: float,
    radii: tuple[float, float],
    young: float,
    poisson: float,
    shape: tuple[int, int],
    regular: Regular | None = None,
    margin: float = MARGIN,
) -> Patch:
    """Contact of two bodies of one material with relative radii [m] along x and y under ``load`` [N] on a grid.

    regular: what finite bodies add to half spaces; of their pressure, what tangential forces do to it is left out. margin:
    width of the grid over that of Hertz's ellipse.

    The pressure solves the contact on the grid: cells beyond its edge are dropped. Raises ValueError for what Hertz's
    formulas refuse, and where the active set does not settle.
    """
    ellipse = hertz(load, *seen_radii(load, radii, young, poisson, regular), young, poisson)
    size = 2.0 * margin * np.array([ellipse.semi_x, ellipse.semi_y]) / np.array(shape)
    cells, at = grid(shape, size)
    solids = Solids.same(young, poisson)
    gap = 0.5 * (at[:, 0] ** 2 / radii[0] + at[:, 1] ** 2 / radii[1])
    extra = None if regular is None else regular.block(at, NORMAL, NORMAL)
    forces, approach = press(cells, size, gap, load, solids, extra)
    inside = forces > 0.0
    return Patch(cells[inside], at[inside], size, forces[inside], solids, approach, regular)
