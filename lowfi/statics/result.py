"""Results of the static models, of one set or several: frozen records in SI; a failure is part of the record, not an
exception."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal, Self

import numpy as np

from rollbench.lowfi.warned import Warned
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollingSet
from rollbench.meshes.quantity import Stated, quantity, record

Ended = Literal["converged", "not held", "not converged", "stopped"]
Cause = Literal["", "crossed row", "mounting", "not unique"]

#: Units of the six motions in results, and factors to them.
MOTION = (("ux_um", 1e6), ("uy_um", 1e6), ("uz_um", 1e6), ("rx_mrad", 1e3), ("ry_mrad", 1e3), ("rz_mrad", 1e3))


def by_freedoms(motion: Array) -> dict[str, float]:
    """A motion ``(6,)`` [m, rad] in um and mrad by its freedoms."""
    return {name: factor * x for (name, factor), x in zip(MOTION, motion, strict=True)}


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


@record
class Equilibrium:
    """Forces [N] and moments about the origin [N m] on the screw, ``(3,)`` each; residuals relative to the largest.

    The contact forces are summed at their contact points, the reactions of the scene's supports come from the beam: the
    balance is a check. A free motion that nothing drives is held by a pin; what that takes, because sections of the model
    are planar, is no reaction: pin_force, pin_moment, and pin_share over the largest force or moment. The residuals are
    those with the pin. ball_residual: largest net contact force on a ball, on number ``worst_ball`` (from 1).
    """

    applied_force: Array = quantity("external_force_N", "sum of the loads, x, y, z", parts="[]")
    applied_moment: Array = quantity("external_moment_Nm", "their moment about the origin", parts="[]")
    reaction_force: Array = quantity("reaction_force_N", "sum of the supports' reactions", parts="[]")
    reaction_moment: Array = quantity("reaction_moment_Nm", "their moment", parts="[]")
    contact_force: Array = quantity("contact_force_N", "sum of the contact forces on the screw", parts="[]")
    contact_moment: Array = quantity("contact_moment_Nm", "their moment", parts="[]")
    force_residual: float = quantity(
        "force_residual",
        "sum of loads, reactions and contact forces over the largest force; does not use the solved equations",
    )
    moment_residual: float = quantity("moment_residual", "the same of moments")
    pin_force: Array = quantity(
        "pin_force_N",
        "what the pin of a free motion takes; no reaction of the scene",
        parts="[]",
        default_factory=lambda: np.zeros(3),
    )
    pin_moment: Array = quantity("pin_moment_Nm", "its moment", parts="[]", default_factory=lambda: np.zeros(3))
    pin_share: float = quantity("pin_share", "its largest part over the largest force or moment", default=0.0)
    ball_residual: float = quantity(
        "ball_residual", "largest unbalanced force of a ball over the largest force", default=0.0
    )
    worst_ball: int = 0

    @property
    def largest(self) -> float:
        """Largest of the residuals of screw and balls."""
        return max(self.force_residual, self.moment_residual, self.ball_residual)


@record
class SolverReport:
    """How the solution came about. ``residual`` is the largest unbalanced force over the largest force.

    discretisation: largest change of a contact load against a finer beam [N], or None; notes: what happened on the way.
    """

    iterations: int = quantity("iterations", "Newton steps")
    evaluations: int = quantity("evaluations", "evaluations of the equations")
    residual: float = quantity("residual", "largest unbalanced force of the solved equations over the largest force")
    seconds: float = quantity("seconds", "time of the solve")
    unknowns: int = quantity("unknowns", "unknowns of the solve")
    elements: int = quantity("elements", "beam elements")
    engine: str = quantity("engine")
    formulation: str = quantity("formulation")
    round_off_bound: float = quantity("round_off_bound", "bound of the residual that rounding alone makes", default=0.0)
    discretisation: float | None = quantity(
        "discretisation_percent",
        "change of the loads when every beam element is halved, in per cent of the mean load",
        show=lambda _: None,
        default=None,
    )
    setup_seconds: float = 0.0
    notes: tuple[str, ...] = quantity("notes", default=())


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
    ``(n, 4, 3)``, Hertz constant C ``(n, 4)``; ball centre shift ``(n, 2)`` in the section [m]; pole pressure ``(n, 4)``
    [Pa] of a model that gives one, by Hertz from the loads where it is None.
    """

    azimuth: Array
    z: Array
    load: Array
    contact_angle: Array
    contact_point: Array
    force_direction: Array
    centre_shift: Array
    hertz_C: Array
    pressure: Array | None = None
    ANSWERS: ClassVar[tuple[str, ...]] = (
        *Solved.ANSWERS,
        "load",
        "contact_angle",
        "contact_point",
        "force_direction",
        "centre_shift",
        "pressure",
    )

    def of_balls(self) -> tuple[StaticResult, ...]:
        """Itself: the contacts of the one set."""
        return (self,)


@record
class SetResult(Answering):
    """One set. force, moment (3,): of its elements on the shaft, the moment about the axis at the set's position [N, N m];
    reaction (6,): what they do to the outer part there, the opposite but for arms that grow with the displacements;
    stiffness (6, 6): of the set alone, tangent, its inner part moved at its position and the outer one held [N/m, N, N m];
    outer (6,): motion of the outer part there, with its offset [m, rad]; balls: contacts as of a scene of one set, without
    ``equilibrium``, None for rollers; azimuth [rad] and load [N] of each roller (count,), line_loads (count, slices) [N/m].
    """

    of: RollingSet = quantity(
        "name",
        "",
        Stated("kind", show=lambda of: of.kind),
        Stated("position_mm", "station of the set's centre", show=lambda of: of.position),
        Stated("housing", show=lambda of: of.housing),
        Stated("offset_um", "axial offset of its outer body", show=lambda of: of.offset),
        show=lambda of: of.name,
    )
    force: Array = quantity("force_on_shaft_N", "force of the set on the shaft, x, y, z", parts="[]")
    moment: Array = quantity("moment_on_shaft_Nm", "its moment about the set's centre", parts="[]")
    reaction: Array
    stiffness: Array = quantity("stiffness", "the same of one set between its two bodies", parts="[][]")
    outer: Array = quantity("outer_motion", "displacement and rotation of its outer body", show=by_freedoms, parts=".*")
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
    @Stated(
        "largest_load_N",
        "its largest load of a contact or roller",
        error="model form",
        show=lambda loads: loads.max(initial=0.0),
    )
    @Stated(
        "loaded",
        "its loaded contacts or rollers",
        show=lambda loads: int((loads > 0.0).sum()) if np.isfinite(loads).all() else None,
    )
    def loads(self) -> Array:
        """Loads [N] of the contacts (N, 4), or of the rollers (count,)."""
        return self.balls.load if self.balls is not None else np.zeros(0) if self.roller_load is None else self.roller_load


@record
class HousingResult(Answering):
    """Motion (6,) of a housing at its station; what the frame does to it there: wrench (6,) [N, N m] of what holds it and
    of its springs; residual: unbalanced force and moment over the largest force."""

    name: str = quantity("name")
    motion: Array = quantity(
        "motion", "displacement and rotation of the housing at its station", show=by_freedoms, parts=".*"
    )
    wrench: Array = quantity(
        "frame_force_N",
        "force on it of what holds it and of its springs, x, y, z",
        Stated("frame_moment_Nm", "their moment about its station", show=lambda wrench: wrench[3:], parts="[]"),
        show=lambda wrench: wrench[:3],
        parts="[]",
    )
    residual: float = quantity("residual", "what is left of its balance, over the largest force")
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
