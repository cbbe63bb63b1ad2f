"""Rigid motions of shaft and housings that nothing resists, found before anything is solved."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import qr

from rollbench.lowfi.statics.axis.structure import held_rows, rigid_motions
from rollbench.lowfi.statics.axis.system import System
from rollbench.lowfi.statics.mechanism import drives
from rollbench.lowfi.statics.problem import wrench_rows
from rollbench.lowfi.statics.shape import unresisted
from rollbench.meshes.arrays import Array
from rollbench.meshes.parts import FREEDOMS


@dataclass(frozen=True)
class Loose:
    """Rigid motions that nothing resists: whether the loads drive one, its words, and freedoms (rows, freedom) to hold."""

    driven: bool
    text: str
    pins: tuple[tuple[int, int], ...] = ()


def loose_motions(system: System) -> Loose:
    """Motions of shaft and housings as rigid bodies without resistance from supports, springs or rolling elements.

    As `lowfi.statics.mechanism.free_motions`, the motion at a ball's centre stands for its flanks.
    """
    s = system.structure
    motions = rigid_motions(s, system.arm)
    rows = [held_rows(s, motions)]
    by_row = motions.reshape(-1, 6, motions.shape[1])
    n = s.nodes.size
    for b in system.balls:
        layout = b.problem.layout
        moved = np.zeros((2 * layout.z.size, motions.shape[1]))
        for row, sign in ((0 if b.of.carrier is None else int(b.problem.node[0, 0]), 1.0), (b.outer, -1.0)):
            if row >= 0:
                arm = layout.centre - np.array([0.0, 0.0, s.stations[row]])
                moved += sign * (wrench_rows(layout, arm) @ by_row[row]).reshape(len(moved), -1)
        rows.append(moved)
    for roller in system.rollers:
        a = roller.arrays
        moved = np.zeros((a.drop.size, motions.shape[1]))
        for end in range(2):
            if a.row[0, end] >= 0:
                moved += a.B[:, end] @ by_row[a.row[0, end]]
        rows.append(moved)
    null = unresisted(np.concatenate(rows))
    if not null.shape[0]:
        return Loose(False, "")
    free = (motions @ null.T).reshape(-1, 6, null.shape[0])
    text = words_for(system, free)
    if drives(np.einsum("rkc,rk->c", free, s.load), s.load, system.arm):
        return Loose(True, f"{text}: no support, spring or rolling element resists it, and the loads drive it")
    rows_of = [0, *range(n, s.stations.size)]
    flat = free[rows_of].reshape(-1, null.shape[0])
    arms = np.tile([1.0, 1.0, 1.0, system.arm, system.arm, system.arm], len(rows_of))
    _, _, order = qr((flat * arms[:, None]).T, pivoting=True)
    return Loose(False, text, tuple((rows_of[k // 6], int(k % 6)) for k in order[: null.shape[0]]))


def words_for(system: System, free: Array) -> str:
    """Words for motions (r, 6) or (r, 6, k) of all rows as rigid bodies."""
    free = free.reshape(len(free), 6, -1)
    s, n = system.structure, system.structure.nodes.size
    names = {row: name for name, row in s.row.items() if row >= 0}
    arms = np.array([1.0, 1.0, 1.0, system.arm, system.arm, system.arm])
    motions = []
    for row in (0, *range(n, s.stations.size)):
        size = np.abs(free[row] * arms[:, None]).max(axis=1)
        freedoms = [name for name, x in zip(FREEDOMS, size, strict=True) if x > 1e-6 * np.abs(free).max()]
        if freedoms:
            motions.append(f"{'the shaft' if row == 0 else names[row]} in {', '.join(freedoms)}")
    return "rigid motion of " + " and ".join(motions)


def pinned(system: System, loose: Loose) -> System:
    """The system with the loose motions held where they are."""
    if not loose.pins:
        return system
    fixed = system.structure.fixed.copy()
    for row, k in loose.pins:
        fixed[row, k] = True
    structure = replace(system.structure, fixed=fixed)
    return replace(system, structure=structure, axis=system.axis._replace(fixed=fixed))
