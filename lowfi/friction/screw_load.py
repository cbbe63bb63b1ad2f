"""Contact loads of balls between a rigid screw and a rigid nut: minimum of a convex energy over all positions.

Each ball moves in the plane of its groove section (x3 radial, z3 binormal), the screw by its free motions u, the nut
stands. In-plane friction enters as forces on balls and screw that do not change while they settle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .ellipse import Array
from .screw_groove import ON_SCREW, SIGN_X, SIGN_Z, ScrewGroove, frame

#: Round-off limit of the search and what counts as converged, as parts of the sum of forces.
GOAL, ACCEPTED = 1e-13, 1e-8
STEPS = 600


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


@dataclass(frozen=True)
class ScrewLoad:
    """Contact forces (N, 4) [N], actual contact angles (N, 4) [rad], positions of balls (N, 2) and screw (m,) [m].

    left: largest force out of balance [N]; converged: whether that is below 1e-8 of the sum of forces.
    """

    force: Array
    angle: Array
    ball: Array
    screw: Array
    left: float
    steps: int
    converged: bool


@dataclass(frozen=True)
class _State:
    energy: float
    ball: Array
    screw: Array
    stiff: Array
    force: Array
    normal: Array

    def worst(self) -> float:
        """Largest force out of balance [N]."""
        return float(max(np.max(np.abs(self.ball), initial=0.0), np.max(np.abs(self.screw), initial=0.0)))


def _evaluate(cell: Cell, p: Array, u: Array) -> _State:
    """Energy, gradients by balls (N, 2) and screw (m,), contact stiffness (N, 4, 2, 2), forces and normals."""
    start = cell.groove.reach * np.stack([SIGN_X * np.cos(cell.angle), SIGN_Z * np.sin(cell.angle)], axis=-1)
    move = p[:, None, :] - np.where(ON_SCREW[:, None], (cell.section @ u + cell.offset)[:, None, :], 0.0)
    w = start + move
    size = np.sqrt(np.sum(w * w, axis=-1))
    # distance less reach, built as a change so that its round-off is that of the motion
    grown = np.sum(move * (2.0 * start + move), axis=-1) / (size + cell.groove.reach)
    c = cell.groove.constants.C
    d = np.maximum(grown + cell.interference, 0.0) / c
    f = d * np.sqrt(d)
    n = w / size[..., None]
    nn = n[..., :, None] * n[..., None, :]
    k_n, k_t = 1.5 * np.sqrt(d) / c, f / size
    stiff = (k_n - k_t)[..., None, None] * nn + k_t[..., None, None] * np.eye(2)
    pull = f[..., None] * n
    screw = -np.einsum("nim,ni->m", cell.section, pull[:, ON_SCREW].sum(axis=1)) - cell.force - cell.drag
    energy = float(np.sum(0.4 * c * d * f) - np.sum(cell.push * p) - (cell.force + cell.drag) @ u)
    return _State(energy, pull.sum(axis=1) - cell.push, screw, stiff, f, n)


def _newton(cell: Cell, state: _State, floor: float) -> tuple[Array, Array]:
    """Newton step of balls (N, 2) and screw (m,); the balls are eliminated."""
    own = state.stiff.sum(axis=1) + floor * np.eye(2)
    on_screw = state.stiff[:, ON_SCREW].sum(axis=1)
    rows = cell.section
    cross = -on_screw @ rows
    inverse = np.linalg.inv(own)
    solved = inverse @ np.concatenate([cross, state.ball[..., None]], axis=2)
    m = rows.shape[2]
    if m == 0:
        return -solved[..., 0], np.zeros(0)
    schur = np.einsum("nim,nij,njk->mk", rows, on_screw, rows) + floor * np.eye(m)
    schur -= np.einsum("nim,nik->mk", cross, solved[..., :m])
    right = -state.screw + np.einsum("nim,ni->m", cross, solved[..., m])
    du = np.linalg.solve(schur, right)
    return -solved[..., m] - solved[..., :m] @ du, du


def _first_guess(cell: Cell) -> tuple[Array, Array]:
    """Screw pressed along its load by about the approach of a fair share of it, balls half way."""
    total = float(np.linalg.norm(cell.force))
    count, m = cell.angle.shape[0], cell.rows.shape[2]
    if total == 0.0 or m == 0:
        return np.zeros((count, 2)), np.zeros(m)
    approach = float(np.max(cell.groove.constants.C)) * (total / count) ** (2.0 / 3.0)
    u = cell.force / total * 4.0 * (approach + max(0.0, -float(np.min(cell.interference))))
    return 0.5 * (cell.section @ u), u


def settle(cell: Cell, start: tuple[Array, Array] | None = None) -> ScrewLoad:
    """Loads of the cell, from positions of balls (N, 2) and screw (m,) if given; forces do not depend on the start.

    Minimises sum (2/5) C^(-3/2) <approach>^(5/2) - force . u - push . p by Newton with line search.
    """
    p, u = _first_guess(cell) if start is None else (start[0].copy(), start[1].copy())
    state = _evaluate(cell, p, u)
    load = float(np.linalg.norm(cell.force) + np.linalg.norm(cell.drag) + np.sum(np.abs(cell.push)))
    steps = 0
    while steps < STEPS and state.worst() > GOAL * (load + float(np.sum(state.force))):
        steps += 1
        floor = 1e-12 * float(np.max(state.stiff)) + 1e-12 * max(load, 1e-9) / cell.groove.reach
        dp, du = _newton(cell, state, floor)
        largest = float(max(np.max(np.abs(dp)), np.max(np.abs(du), initial=0.0)))
        length = min(1.0, 0.3 * cell.groove.reach / largest)
        slope = float(np.sum(state.ball * dp) + state.screw @ du)
        work = load * float(max(np.max(np.abs(p)), np.max(np.abs(u), initial=0.0)))  # what cancels in the energy
        moved = None
        for _ in range(50):
            new = _evaluate(cell, p + length * dp, u + length * du)
            flat = -length * slope <= 1e-12 * (abs(state.energy) + work)
            if new.energy <= state.energy + 1e-4 * length * slope or (flat and new.worst() < state.worst()):
                moved = new
                break
            length *= 0.5
        if moved is None:
            break
        p, u, state = p + length * dp, u + length * du, moved
    n = np.abs(state.normal)
    left, total = state.worst(), load + float(np.sum(state.force))
    return ScrewLoad(state.force, np.arctan2(n[..., 1], n[..., 0]), p, u, left, steps, left <= ACCEPTED * total)


def screw_rows(groove: ScrewGroove, azimuth: Array, free: str) -> Array:
    """Motion (N, 3, m) along x3, y3, z3 by the screw's free translations, letters of ``free`` in order.

    "z": along the axis; "x", "y": across, in fixed axes; "r": radially at every ball (a ball with its own screw).
    Raises ValueError for other letters.
    """
    azimuth = np.asarray(azimuth, dtype=float)
    if any(letter not in "xyzr" for letter in free):
        raise ValueError(f'free motions of the screw are letters of "xyzr", not "{free}"')
    out = np.zeros((azimuth.size, 3, len(free)))
    for k, phi in enumerate(azimuth):
        turn = frame(groove, float(phi))
        for j, letter in enumerate(free):
            out[k, :, j] = (1.0, 0.0, 0.0) if letter == "r" else turn[:, "xyz".index(letter)]
    return out
