"""Solution paths of equations with one parameter, followed by arc length: round folds, at which the parameter turns back.

The last coordinate of a point is the part of the way from the first to the last value of the parameter, 0 to 1. It is an
unknown as the others are (pseudo-arclength continuation: Keller 1977).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import Self, TypeVar

import numpy as np

from rollbench.meshes.arrays import Array

#: Residual up to which a point counts as on the path (root of the sum of squares). Residual up to which it does so too if
#: Newton's step is no longer than `SETTLED`: rounding errors of many equations leave no smaller one. Largest number of
#: Newton steps from a predicted point back to the path.
ON_PATH, NEARLY, SETTLED, STEPS = 1e-10, 1e-9, 1e-11, 8

#: Length of the first step along the path and length of the shortest, in scaled units; distance by which a predicted point
#: may always be moved back to the path, also after a shorter step: the path bends sharply where a contact closes or opens.
FIRST, SHORTEST, NEAR = 0.3, 1e-9, 0.02

#: Change of the part of the way in differences for the derivative of the residual.
DIFFERENCE = 1e-6


class PathPoint(ABC):
    """Abstract class for n equations with one parameter at a point, on or near the path of their solutions."""

    #: Scaled unknowns, and last the part of the way ``(n + 1,)``.
    point: Array
    #: Residuals of the equations ``(n,)``.
    residual: Array
    #: Residual up to which the point counts as on the path.
    on_path: float = ON_PATH

    @abstractmethod
    def at(self, point: Array) -> Self:
        """Return the equations at another point ``(n + 1,)``."""

    @abstractmethod
    def solve(self, sides: Array) -> Array:
        """Solve the linear system with the Jacobian by the n unknowns for c right-hand sides ``(n, c)``."""

    @abstractmethod
    def rescaled(self) -> tuple[Self, Array | float]:
        """Return the equations of this solution in scales of its own, and the old units of the point over the new ones."""

    @cached_property
    def steps(self) -> tuple[Array, Array]:
        """Newton's step at a constant part of the way, and change of the solution with this part ``(n,)`` each."""
        ahead = self.point + DIFFERENCE * (np.arange(self.point.size) == self.point.size - 1)
        by_way = (self.at(ahead).residual - self.residual) / DIFFERENCE
        step, change = self.solve(-np.stack([self.residual, by_way], axis=1)).T
        return step, change

    @property
    def tangent(self) -> Array:
        """Tangent of the path, of unit length, along which the part of the way rises ``(n + 1,)``."""
        along = np.append(self.steps[1], 1.0)
        return np.asarray(along / np.linalg.norm(along))

    def next_on_path(self, tangent: Array, length: float, ends: bool) -> tuple[Self | None, int]:
        """Return the point of the path some length along its tangent, None if none is near, and the number of Newton steps.

        The steps back to the path are normal to the tangent or, if the path ``ends`` there, at a constant part of the
        way. They may not exceed most of the ``length``, because they could lead to another path.
        """
        at, moved = self.at(self.point + length * tangent), 0.0
        for count in range(STEPS + 1):
            residual = np.linalg.norm(at.residual)
            if residual <= self.on_path:
                return at, count
            step, change = at.steps
            if residual <= NEARLY and np.linalg.norm(step) <= SETTLED:
                return at, count
            further = 0.0 if ends else -float(tangent[:-1] @ step) / float(tangent[-1] + tangent[:-1] @ change)
            move = np.append(step + further * change, further)
            moved += float(np.linalg.norm(move))
            if not moved < 0.7 * max(length, NEAR):
                return None, count
            at = at.at(at.point + move)
        return None, STEPS


#: The equations whose path is followed.
P = TypeVar("P", bound="PathPoint")


def follow_path(begin: P, limit: int) -> tuple[P, bool, int]:
    """Follow a path of solutions from its beginning to its end.

    Parameters
    ----------
    begin
        Point on the path at the part 0 of the way.
    limit
        Number of Newton steps after which no further step along the path is taken.

    Returns
    -------
    tuple
        The last point on the path, whether it is the end of the path, and the number of Newton steps.
    """
    here, length, last, total = begin, FIRST, np.zeros(0), 0
    while total < limit and here.point[-1] > -NEAR:
        tangent = here.tangent if not last.size or here.tangent @ last > 0.0 else -here.tangent
        found, total = None, total + 1
        while found is None and length >= SHORTEST:
            ends = bool(here.point[-1] + length * tangent[-1] >= 1.0)
            length = (1.0 - float(here.point[-1])) / float(tangent[-1]) if ends else length
            found, used = here.next_on_path(tangent, length, ends)
            total += used
            length *= 0.4 if found is None else 2.0 if used <= 2 else 1.3 if used == 3 else 1.0 if used <= 5 else 0.8
        if found is None:
            break
        here, units = found.rescaled()
        last = tangent * units
        if ends:
            return here, True, total
    return here, False, total
