"""Results of the static models, of one set or several: frozen records in SI; a failure is part of the record, not an
exception."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal, Self

import numpy as np

from rollbench.lowfi.warned import Warned
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollingSet

Ended = Literal["converged", "not held", "not converged", "stopped"]
Cause = Literal["", "crossed row", "mounting", "not unique"]


class Status(str):
    """How a solution ended: a sentence of its ``kind`` and its ``reason``. cause: what lies behind it, where that is known:
    a row of bearings pulled the way it cannot carry, preloads not met at mounting, contacts that are not unique.

    >>> found = Status("not held", "rotation about the screw's axis")
    >>> found, found.kind, found.reason
    ("not held: rotation about the screw's axis", 'not held', "rotation about the screw's axis")
    """

    kind: Ended
    reason: str
    cause: Cause

    def __new__(cls, kind: Ended, reason: str = "", cause: Cause = "") -> Status:
        """The sentence, which is only the kind where there is no reason to give."""
        status = super().__new__(cls, f"{kind}: {reason}" if reason else kind)
        status.kind, status.reason, status.cause = kind, reason, cause
        return status

    def __getnewargs__(self) -> tuple[Ended, str, Cause]:  # type: ignore[override]
        """Arguments that a copy is made of, in another process too."""
        return self.kind, self.reason, self.cause


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

    discretisation: largest change of a contact load against a finer beam [N], or None; notes: what happened on the way.
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
    discretisation: float | None = None
    setup_seconds: float = 0.0
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Answering:
    """A record whose fields in ``ANSWERS`` are no answers where the solution did not converge."""

    ANSWERS: ClassVar[tuple[str, ...]] = ()

    def without_answers(self) -> Self:
        """The record with nan in place of its answers, and of those of its parts."""
        return replace(self, **{name: unknown(getattr(self, name)) for name in self.ANSWERS})


@dataclass(frozen=True, kw_only=True)
class Solved(Answering):
    """What every static solution holds of the shaft. status: "converged" or what went wrong; centreline: stations
    ``(k,)`` [m] and motions ``(k, 6)`` [m, rad]; member: which specimen of a scene with random errors; reactions: of every
    support of the scene on the shaft, at its station ``(s, 6)`` [N, N m]."""

    model: str
    status: Status
    centreline_z: Array
    centreline: Array
    equilibrium: Equilibrium | None
    solver: SolverReport
    assumed: tuple[str, ...]
    left_out: tuple[str, ...]
    warnings: tuple[Warned, ...] = ()
    member: int = 0
    reactions: Array = field(default_factory=lambda: np.zeros((0, 6)))
    ANSWERS: ClassVar[tuple[str, ...]] = ("centreline", "equilibrium", "reactions")

    @property
    def converged(self) -> bool:
        """Whether the loads may be used."""
        return self.status == "converged"

    def of_balls(self) -> tuple[StaticResult, ...]:
        """Contacts of each set of balls."""
        return ()

    def answers(self) -> Self:
        """Itself where it converged, else `without_answers`."""
        return self if self.converged else self.without_answers()


@dataclass(frozen=True, kw_only=True)
class StaticResult(Solved):
    """Static load distribution of one scene, or the contacts of one set of an assembly.

    Per ball: azimuth ``(n,)`` [rad], z ``(n,)`` [m]; per ball and side (SL, SR, NL, NR): load ``(n, 4)`` [N], contact angle
    ``(n, 4)`` [rad] (nan without contact), contact point in space ``(n, 4, 3)`` [m], unit force direction on the ball
    ``(n, 4, 3)``, Hertz constant C ``(n, 4)``; ball centre shift ``(n, 2)`` in the section [m].
    """

    azimuth: Array
    z: Array
    load: Array
    contact_angle: Array
    contact_point: Array
    force_direction: Array
    centre_shift: Array
    hertz_C: Array
    ANSWERS: ClassVar[tuple[str, ...]] = (
        *Solved.ANSWERS,
        "load",
        "contact_angle",
        "contact_point",
        "force_direction",
        "centre_shift",
    )

    def of_balls(self) -> tuple[StaticResult, ...]:
        """Itself: the contacts of the one set."""
        return (self,)


@dataclass(frozen=True)
class SetResult(Answering):
    """One set. force, moment (3,): of its elements on the shaft, the moment about the axis at the set's position [N, N m];
    reaction (6,): what they do to the outer part there, the opposite but for arms that grow with the displacements;
    stiffness (6, 6): of the set alone, tangent, its inner part moved at its position and the outer one held [N/m, N, N m];
    outer (6,): motion of the outer part there, with its offset [m, rad]; balls: contacts as of a scene of one set, without
    ``equilibrium``, None for rollers; azimuth [rad] and load [N] of each roller (count,), line_loads (count, slices) [N/m].
    """

    of: RollingSet
    force: Array
    moment: Array
    reaction: Array
    stiffness: Array
    outer: Array
    balls: StaticResult | None = None
    roller_azimuth: Array | None = None
    roller_load: Array | None = None
    line_loads: Array | None = None
    ANSWERS: ClassVar[tuple[str, ...]] = (
        "force",
        "moment",
        "reaction",
        "stiffness",
        "outer",
        "balls",
        "roller_load",
        "line_loads",
    )

    @property
    def loads(self) -> Array:
        """Loads [N] of the contacts (N, 4), or of the rollers (count,)."""
        return self.balls.load if self.balls is not None else np.zeros(0) if self.roller_load is None else self.roller_load


@dataclass(frozen=True)
class HousingResult(Answering):
    """Motion (6,) of a housing at its station; what the frame does to it there: wrench (6,) [N, N m] of what holds it and
    of its springs; residual: unbalanced force and moment over the largest force."""

    name: str
    motion: Array
    wrench: Array
    residual: float
    ANSWERS: ClassVar[tuple[str, ...]] = ("motion", "wrench", "residual")


@dataclass(frozen=True, kw_only=True)
class AxisResult(Solved):
    """Static equilibrium of an assembly. station [m]: of the shaft that ``stiffness_at`` says, None for a housing;
    stiffness (6, 6): tangent stiffness of the whole there [N/m, N, N m], None where that is held."""

    sets: tuple[SetResult, ...] = ()
    housings: tuple[HousingResult, ...] = ()
    stiffness_at: str = ""
    station: float | None = None
    stiffness: Array | None = None
    ANSWERS: ClassVar[tuple[str, ...]] = (*Solved.ANSWERS, "sets", "housings")

    def of_balls(self) -> tuple[StaticResult, ...]:
        """Contacts of each set of balls."""
        return tuple(s.balls for s in self.sets if s.balls is not None)

    def without_answers(self) -> Self:
        """The result without loads, motions, stiffness and balance."""
        return replace(super().without_answers(), stiffness=None)


def unknown(value: Any) -> Any:
    """Placeholder for an answer that is not known: nan for numbers, the same in parts of a result; None for a balance."""
    if isinstance(value, tuple):
        return tuple(unknown(x) for x in value)
    if isinstance(value, Answering):
        return value.without_answers()
    if isinstance(value, float):
        return float("nan")
    return None if value is None or isinstance(value, Equilibrium) else np.full(value.shape, np.nan)
