"""Stiffness of shaft, springs, balls and rollers in the envelope of `lowfi.statics.kernel.skyline`."""

from itertools import product

import numpy as np

from rollbench.lowfi.jit import is_compiled, kernel
from rollbench.lowfi.statics.kernel_types import Array, AxisArrays, AxisBalls, AxisRollers

from .beam import add_element


@kernel
def add_block(values: Array, axis: AxisArrays, a: int, b: int, block: Array) -> None:
    """Add a block (6, 6) at rows a, columns b of motions, and what symmetry makes of it; a = b: its lower half."""
    if axis.place[a] >= axis.place[b]:
        rows, columns = 6 * axis.place[a], 6 * axis.place[b]
        for i in range(6):
            at = axis.start[rows + i] + columns
            for j in range(i + 1 if a == b else 6):
                values[at + j] += block[i, j]
    else:
        rows, columns = 6 * axis.place[b], 6 * axis.place[a]
        for i in range(6):
            at = axis.start[rows + i] + columns
            for j in range(6):
                values[at + j] += block[j, i]


@kernel
def add_axis(values: Array, axis: AxisArrays) -> None:
    """Add the shaft's elements and the springs."""
    band, block = np.empty((12, 12)), np.empty((6, 6))
    for e in range(axis.lengths.shape[0]):
        band[:, :] = 0.0
        add_element(band, 0, axis.lengths[e], axis.sections[e])
        for half in range(3):
            first, second = (0, 0) if half == 0 else ((6, 0) if half == 1 else (6, 6))
            for i in range(6):
                for j in range(6):
                    row, column = max(first + i, second + j), min(first + i, second + j)
                    block[i, j] = band[column, row - column]
            add_block(values, axis, e + first // 6, e + second // 6, block)
    for k in range(axis.ends.shape[0]):
        for i in range(2):
            for j in range(i + 1):
                if axis.ends[k, i] >= 0 and axis.ends[k, j] >= 0:
                    block[:, :] = 0.0
                    for a in range(6):
                        for b in range(6):
                            for c in range(6):
                                for d in range(6):
                                    block[a, b] += axis.reach[k, i, c, a] * axis.springs[k, c, d] * axis.reach[k, j, d, b]
                    add_block(values, axis, axis.ends[k, i], axis.ends[k, j], block)


@kernel
def loop_balls(values: Array, axis: AxisArrays, balls: AxisBalls, hessians: Array) -> None:
    """Add the balls' stiffness: B^T h B for every two flanks that move, and every two rows that move them."""
    spans, block = balls.B.shape[3] // 6, np.empty((6, 6))
    for i in range(balls.row.shape[0]):
        for s in range(4):
            row = balls.row[i, s]
            if row < 0 or (hessians[i, 2 * s, 2 * s] == 0.0 and hessians[i, 2 * s + 1, 2 * s + 1] == 0.0):
                continue
            for t in range(s + 1):
                column = balls.row[i, t]
                if column < 0 or (hessians[i, 2 * t, 2 * t] == 0.0 and hessians[i, 2 * t + 1, 2 * t + 1] == 0.0):
                    continue
                h = hessians[i, 2 * s : 2 * s + 2, 2 * t : 2 * t + 2]
                for a in range(spans):
                    for b in range(a + 1 if s == t else spans):
                        turned_block(balls.B[i, s, :, 6 * a :], h, balls.B[i, t, :, 6 * b :], block)
                        if s != t and row + a == column + b:  # both halves of a block on the diagonal
                            for j in range(6):
                                for k in range(j):
                                    block[j, k] += block[k, j]
                                block[j, j] *= 2.0
                        add_block(values, axis, row + a, column + b, block)


@kernel
def turned_block(left: Array, h: Array, right: Array, block: Array) -> None:
    """block (6, 6) = left^T h right, of the first six columns of left and right (2, 6 or more) and h (2, 2)."""
    for j in range(6):
        x = left[0, j] * h[0, 0] + left[1, j] * h[1, 0]
        z = left[0, j] * h[0, 1] + left[1, j] * h[1, 1]
        for k in range(6):
            block[j, k] = x * right[0, k] + z * right[1, k]


@kernel
def add_rollers(values: Array, axis: AxisArrays, rollers: AxisRollers, slices: Array) -> None:
    """Add the stiffness of the rollers' slices."""
    block = np.empty((6, 6))
    for i in range(slices.shape[0]):
        if slices[i, 1] == 0.0:
            continue
        for s in range(2):
            for t in range(s + 1):
                if rollers.row[i, s] >= 0 and rollers.row[i, t] >= 0:
                    for j in range(6):
                        for k in range(6):
                            block[j, k] = slices[i, 1] * rollers.B[i, s, j] * rollers.B[i, t, k]
                    add_block(values, axis, rollers.row[i, s], rollers.row[i, t], block)


@kernel
def hold(values: Array, axis: AxisArrays, shift: Array) -> None:
    """Add ``shift`` (6,) to the diagonal and make unit lines of the held freedoms."""
    n = axis.first.shape[0]
    for i in range(axis.fixed.shape[0]):
        for k in range(6):
            line = 6 * axis.place[i] + k
            values[axis.start[line] + line] += shift[k]
            if not axis.fixed[i, k]:
                continue
            for j in range(axis.first[line], line):
                values[axis.start[line] + j] = 0.0
            values[axis.start[line] + line] = 1.0
            for other in range(line + 1, n):
                if axis.first[other] <= line:
                    values[axis.start[other] + line] = 0.0


def _balls_at_once(values: Array, axis: AxisArrays, balls: AxisBalls, hessians: Array) -> None:
    """As ``loop_balls``, for the interpreter."""
    six, spans = np.arange(6), range(balls.B.shape[3] // 6)
    for s, t, a, b in product(range(4), range(4), spans, spans):
        both = np.flatnonzero((balls.row[:, s] >= 0) & (balls.row[:, t] >= 0))
        left, right = balls.B[both, s][:, :, 6 * a : 6 * a + 6], balls.B[both, t][:, :, 6 * b : 6 * b + 6]
        h = hessians[both, 2 * s : 2 * s + 2, 2 * t : 2 * t + 2]
        K = np.einsum("nai,nab,nbj->nij", left, h, right)
        lines = (6 * axis.place[balls.row[both, s] + a])[:, None, None] + six[None, :, None]
        columns = (6 * axis.place[balls.row[both, t] + b])[:, None, None] + six[None, None, :]
        lower = (lines >= columns) & (K != 0.0)
        np.add.at(values, (axis.start[lines] + columns)[lower], K[lower])


add_balls = loop_balls if is_compiled(__name__) else _balls_at_once
