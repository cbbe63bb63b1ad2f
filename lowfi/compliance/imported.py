"""Compliance between contacts from a condensed 3D model, read from a file."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lowfi.problem import Problem

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Condensed:
    """placeholder until the file format is settled."""

    nut: Array

    def correct(self, problem: Problem, screw: bool, sides: list[int], G: Array, v0: Array, normals: Array) -> tuple[Array, Array, float | None]:
        raise NotImplementedError
