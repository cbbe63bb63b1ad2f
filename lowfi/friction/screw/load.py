"""Contact loads of balls between a rigid screw and a rigid nut: minimum of a convex energy over all positions.

Each ball moves in the plane of its groove section (x3 radial, z3 binormal), the screw by its free motions u, the nut
stands. In-plane friction enters as forces on balls and screw that do not change while they settle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rollbench.lowfi.friction.contact.kernel_types import CellArrays
from rollbench.lowfi.friction.contact.rings import Settled, settle_cell
from rollbench.lowfi.friction.screw.groove import SIGN_X, SIGN_Z, ScrewGroove, frame, plain_array
from rollbench.lowfi.statics.settle import contact_angles
from rollbench.meshes.arrays import Array


def bare_cell(groove: ScrewGroove, angle: Array, interference: Array, rows: Array, force: Array) -> Cell:
    """A cell with no forces but ``force`` on the screw, which begins at its place."""
    none = np.zeros((angle.shape[0], 2))
    return Cell(groove, angle, interference, rows, force, none, none, np.zeros(force.size))


@dataclass(frozen=True)
class Cell:
    """N balls: groove angles (N, 4) [rad], interference (N, 4) [m] along each, screw's motion rows (N, 3, m) per u.

    Rows are along x3, y3, z3; offset (N, 2): further displacement of the screw along x3, z3 [m]; force (m,): on the
    screw along u; push (N, 2): on the balls along x3, z3 [N]; drag (m,): more force along u.
    """

    groove: ScrewGroove
    angle: Array
    interference: Array
    rows: Array
    force: Array
    offset: Array
    push: Array
    drag: Array

    @property
    def section(self) -> Array:
        """The rows along x3 and z3, (N, 2, m)."""
        return self.rows[:, [0, 2]]


def load_arrays(cell: Cell) -> CellArrays:
    """The cell as the kernels take it."""
    start = cell.groove.reach * np.stack([SIGN_X * np.cos(cell.angle), SIGN_Z * np.sin(cell.angle)], axis=-1)
    start, interference, C, section, offset, push, pull = map(
        plain_array,
        (start, cell.interference, cell.groove.constants.C, cell.section, cell.offset, cell.push, cell.force + cell.drag),
    )
    return CellArrays(start, interference, C, section, offset, push, pull, float(cell.groove.reach))


def _first_guess(cell: Cell) -> tuple[Array, Array]:
    """Screw pressed along its load by about the approach of a fair share of it, balls half way."""
    total = float(np.linalg.norm(cell.force))
    count, m = cell.angle.shape[0], cell.rows.shape[2]
    if total == 0.0 or m == 0:
        return np.zeros((count, 2)), np.zeros(m)
    approach = float(np.max(cell.groove.constants.C)) * (total / count) ** (2.0 / 3.0)
    u = cell.force / total * 4.0 * (approach + max(0.0, -float(np.min(cell.interference))))
    return 0.5 * (cell.section @ u), u


def settle_load(cell: Cell, start: tuple[Array, Array] | None = None, fast: bool = True) -> Settled:
    """Loads of the cell, from positions of balls (N, 2) and screw (m,) [m] if given; forces do not depend on the start.

    Minimises sum (2/5) C^(-3/2) <approach>^(5/2) - force . u - push . p by Newton with line search, in the compiled
    kernels if ``fast``.
    """
    load = float(np.linalg.norm(cell.force) + np.linalg.norm(cell.drag) + np.sum(np.abs(cell.push)))
    p, u = _first_guess(cell) if start is None else (plain_array(start[0]).copy(), plain_array(start[1]).copy())
    settled = settle_cell(load_arrays(cell), load, p, u, contact_angles, fast)
    # from a distant start a nearly unloaded ball may creep along a flat energy
    return settled if settled.converged or start is None else settle_load(cell, None, fast)


def screw_rows(groove: ScrewGroove, azimuth: Array, free: str) -> Array:
    """Motion (N, 3, m) along x3, y3, z3 by the screw's free translations, letters of ``free`` in order.

    "z": along the axis; "x", "y": across, in fixed axes; "r": radially at every ball (a ball with its own screw).
    Raises ValueError for other letters.
    """
    if any(letter not in "xyzr" for letter in free):
        raise ValueError(f'free motions of the screw are letters of "xyzr", not "{free}"')
    turn = frame(groove, azimuth)
    out = np.zeros((*turn.shape[:2], len(free)))
    for j, letter in enumerate(free):
        out[..., j] = (1.0, 0.0, 0.0) if letter == "r" else turn[..., "xyz".index(letter)]
    return out
