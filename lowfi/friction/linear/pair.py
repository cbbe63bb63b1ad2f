"""Two balls under opposite side forces: the case study of Lin 3.3.4, by the numerical model and by the formulas."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rollbench.lowfi.friction.linear import analytic
from rollbench.lowfi.friction.linear.bearing import (
    LinearBearing,
    Loads,
    balanced_loads,
    deviations,
    diagonal_loads,
    elastic_loads,
)
from rollbench.lowfi.friction.linear.chain import ChainResult, prepare, solve_linear_chain
from rollbench.meshes.arrays import Array


@dataclass(frozen=True)
class PairResult:
    """Two balls without contact and in reach of each other; ``free.deviation`` are the epsilons of Table 3.4."""

    free: ChainResult
    touching: ChainResult

    @property
    def force(self) -> float:
        """Ball-to-ball force [N]."""
        return float(self.touching.ball_force[0])

    @property
    def difference(self) -> float:
        """epsilon_1 - epsilon_2 of the balls without contact; they close in where it is positive."""
        return float(self.free.deviation[0] - self.free.deviation[1])

    @property
    def friction_increase(self) -> float:
        """Relative increase of the drive force by ball-to-ball contact, and of the losses."""
        return self.touching.loss / self.free.loss - 1.0

    @property
    def rubbing_ratio(self) -> float:
        """Groove loss of the balls without contact plus ball-to-ball loss, over the former (Lin Figure 3.15 (c))."""
        return 1.0 + float(self.touching.ball_loss[0]) / self.free.loss


def pair_state(
    bearing: LinearBearing, theta: float, rho: float, vertical: float, *, mated: bool = False, loads: Loads = "balanced"
) -> tuple[Array, Array]:
    """Contact angles [rad] and loads [N], ``(2, 4)``, of two balls under N_y and N_x = rho N_y, -rho N_y."""
    angles = bearing.contact_angle + deviations(np.array([theta, theta]), mated=mated)
    side = np.array([rho, -rho])
    if loads == "diagonal":
        return angles, diagonal_loads(vertical, side, bearing.contact_angle)
    if loads == "balanced":
        return angles, balanced_loads(angles, vertical, side)
    force, turned = elastic_loads(bearing, angles, vertical, side)
    return turned, force


def solve_pair(
    bearing: LinearBearing,
    theta: float,
    rho: float,
    vertical: float,
    *,
    mated: bool = False,
    loads: Loads = "balanced",
    fast: bool = True,
) -> PairResult:
    """Case study of Lin 3.3.4: theta [rad] on the bottom groove, side force ratio rho, N_y [N] on each ball.

    loads "balanced" gives the printed epsilons of Table 3.4; "diagonal" is the text before (3.54), which makes both
    equal and opposite; "elastic" lets the angles follow the loads. mated: design (b).
    """
    angles, force = pair_state(bearing, theta, rho, vertical, mated=mated, loads=loads)
    apart, together = (prepare(bearing, angles, force, touching) for touching in (False, True))
    return PairResult(solve_linear_chain(apart, fast=fast), solve_linear_chain(together, fast=fast))


class BothModels(NamedTuple):
    """One quantity by the numerical model and by the formulas, each ``(T, R)``."""

    numerical: Array
    formula: Array

    @property
    def error(self) -> Array:
        """Error of the formula."""
        return np.asarray(self.formula - self.numerical)


@dataclass(frozen=True)
class PairMaps:
    """Figures 3.14 and 3.15 over theta ``(T,)`` [rad] and rho ``(R,)``.

    difference: epsilon_1 - epsilon_2; force [N]; ratio: baseline plus ball-to-ball loss over baseline. failures: solutions
    not converged.
    """

    theta: Array
    rho: Array
    difference: BothModels
    force: BothModels
    ratio: BothModels
    failures: int


def maps(bearing: LinearBearing, theta: Array, rho: Array, vertical: float, k_f: float) -> PairMaps:
    """Both models over theta [rad] and rho (Lin Figures 3.14, 3.15)."""
    values, failures = np.empty((3, 2, len(theta), len(rho))), 0
    for i, j in np.ndindex(len(theta), len(rho)):
        result = solve_pair(bearing, float(theta[i]), float(rho[j]), vertical)
        failures += sum(r.status != "converged" for r in (result.free, result.touching))
        values[:, 0, i, j] = result.difference, result.force, result.rubbing_ratio
        values[:, 1, i, j] = pair_formulas(bearing, float(theta[i]), float(rho[j]), vertical, k_f)
    difference, force, ratio = (BothModels(*both) for both in values)
    return PairMaps(theta, rho, difference, force, ratio, failures)


def pair_formulas(
    bearing: LinearBearing, theta: float, rho: float, vertical: float, k_f: float, *, mated: bool = False
) -> tuple[float, float, float]:
    """epsilon_1 - epsilon_2, force [N] and ratio of losses by (3.43), (3.51), (3.53) at the loads before (3.54)."""
    loads = diagonal_loads(vertical, np.array([rho, -rho]), bearing.contact_angle)
    turn = deviations(np.array([theta, theta]), mated=mated)
    epsilon = analytic.velocity_deviation(bearing.contact_angle, turn, loads[:, 0], loads[:, 1])
    difference = float(epsilon[0] - epsilon[1])
    force = analytic.ball_force(bearing, loads[:, :2], np.array(difference), k_f)
    baseline = float(analytic.spin_loss(bearing, loads).sum())
    return difference, float(force), 1.0 + float(analytic.ball_loss(bearing, force)) / baseline
