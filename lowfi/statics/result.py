"""Results of the static models: frozen records in SI; a failure is part of the record, not an exception."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Equilibrium:
    """Forces [N] and moments about the origin [N m] on the screw, ``(3,)`` each; residuals relative to the largest.

    The contact forces are summed at their contact points, the reactions come from the beam: the balance is a check.
    """

    applied_force: Array
    applied_moment: Array
    reaction_force: Array
    reaction_moment: Array
    contact_force: Array
    contact_moment: Array
    force_residual: float
    moment_residual: float


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
class ModelForm:
    """What a result may be worth: errors of the same model against a 3D reference on scenes like it.

    percent, rms_percent: largest and RMS error to expect, in per cent of the mean contact load; both None where nothing
    like the scene was ever compared: not covered. distance: to the nearest compared scene, 1 at the edge of what counts as
    like it; nearest: that scene; compared: how many scenes of its kind were; words: which ingredients are in, and what is
    unlike.
    """

    percent: float | None
    rms_percent: float | None
    distance: float
    nearest: str
    compared: int
    words: tuple[str, ...]


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
    warnings: tuple[str, ...] = ()
    model_form: ModelForm | None = None
    member: int = 0

    @property
    def converged(self) -> bool:
        """Whether the loads may be used."""
        return self.status == "converged"
