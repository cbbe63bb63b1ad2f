"""Results of the static models: frozen records in SI; a failure is part of the record, not an exception."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from rollbench.lowfi.warned import Warned
from rollbench.meshes.arrays import Array


@dataclass(frozen=True)
class Equilibrium:
    """Forces [N] and moments about the origin [N m] on the screw, ``(3,)`` each; residuals relative to the largest.

    The contact forces are summed at their contact points, the reactions of the scene's supports come from the beam: the
    balance is a check. A free motion that nothing drives is held by a pin; what that takes, because sections of the model
    are planar, is no reaction: pin_force, pin_moment, and pin_share over the largest force or moment. The residuals are
    those with the pin. ball_residual: largest net contact force on a ball, on number ``worst_ball`` (from 1).
    """

    applied_force: Array
    applied_moment: Array
    reaction_force: Array
    reaction_moment: Array
    contact_force: Array
    contact_moment: Array
    force_residual: float
    moment_residual: float
    pin_force: Array = field(default_factory=lambda: np.zeros(3))
    pin_moment: Array = field(default_factory=lambda: np.zeros(3))
    pin_share: float = 0.0
    ball_residual: float = 0.0
    worst_ball: int = 0

    @property
    def largest(self) -> float:
        """Largest of the residuals of screw and balls."""
        return max(self.force_residual, self.moment_residual, self.ball_residual)


@dataclass(frozen=True)
class SolverReport:
    """How the solution came about. ``residual`` is the largest unbalanced force over the largest force.

    discretisation: largest change of a contact load against a finer beam and the mean loaded contact [N], or None; notes:
    what happened on the way.
    """

    iterations: int
    evaluations: int
    residual: float
    seconds: float
    unknowns: int
    elements: int
    engine: str
    formulation: str
    round_off_bound: float = 0.0
    discretisation: tuple[float, float] | None = None
    setup_seconds: float = 0.0
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class StaticResult:
    """Static load distribution of one scene.

    status: ``"converged"`` or what went wrong. Per ball: azimuth ``(n,)`` [rad], z ``(n,)`` [m]; per ball and side
    (SL, SR, NL, NR): load ``(n, 4)`` [N], contact angle ``(n, 4)`` [rad] (nan without contact), contact point in space
    ``(n, 4, 3)`` [m], unit force direction on the ball ``(n, 4, 3)``, Hertz constant C ``(n, 4)`` and semi-axes
    constants; ball centre shift ``(n, 2)`` in the section [m]. Centreline: stations ``(k,)`` [m] and motions
    ``(k, 6)`` [m, rad]. member: which specimen of a scene with random errors.
    """

    model: str
    status: str
    azimuth: Array
    z: Array
    load: Array
    contact_angle: Array
    contact_point: Array
    force_direction: Array
    centre_shift: Array
    hertz_C: Array
    centreline_z: Array
    centreline: Array
    equilibrium: Equilibrium | None
    solver: SolverReport
    assumed: tuple[str, ...]
    left_out: tuple[str, ...]
    warnings: tuple[Warned, ...] = ()
    member: int = 0

    @property
    def converged(self) -> bool:
        """Whether the loads may be used."""
        return self.status == "converged"

    def answers(self) -> StaticResult:
        """Itself where it converged, else `without_answers`."""
        return self if self.converged else self.without_answers()

    def without_answers(self) -> StaticResult:
        """The result without loads, motions and balance, which are no answers where it did not converge: nan, or None."""
        names = ("load", "contact_angle", "contact_point", "force_direction", "centre_shift", "centreline")
        each: dict[str, Any] = {name: unknown(getattr(self, name)) for name in names}
        return replace(self, **each, equilibrium=None)


def unknown(values: Array) -> Array:
    """Values in the shape of others that say nothing."""
    return np.full(values.shape, np.nan)
