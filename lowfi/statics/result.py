"""Results of the static models, of one set of balls or several: frozen records in SI units.

A scene without equilibrium is no exception: the record's status says why there are no loads.
"""

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
    """Return a motion ``(6,)`` [m, rad] by the names of its freedoms, in um and mrad.

    Parameters
    ----------
    motion
        Displacements and rotations, ``(6,)`` [m, rad].
    """
    return {name: factor * x for (name, factor), x in zip(MOTION, motion, strict=True)}


class Status(str):
    """How a solution ended, as text: its kind and, where it did not converge, the reason.

    Examples
    --------
    >>> found = Status("not held", "rotation about the screw's axis")
    >>> found, found.kind, found.reason
    ("not held: rotation about the screw's axis", 'not held', "rotation about the screw's axis")
    """

    #: Converged; not held: the loads drive a motion that nothing resists; not converged; stopped by a matrix that is not
    #: positive definite.
    kind: Ended
    #: Why there is no solution; empty where there is one.
    reason: str
    #: Known cause: a bearing row loaded against its direction, preloads not reached at mounting, contacts that are not
    #: unique.
    cause: Cause

    def __new__(cls, kind: Ended, reason: str = "", cause: Cause = "") -> Status:
        """Make a status, whose text is the kind where there is no reason to give."""
        status = super().__new__(cls, f"{kind}: {reason}" if reason else kind)
        status.kind, status.reason, status.cause = kind, reason, cause
        return status

    def __getnewargs__(self) -> tuple[Ended, str, Cause]:  # type: ignore[override]
        """Return the arguments from which a copy is made, also in another process."""
        return self.kind, self.reason, self.cause


@record
class Equilibrium:
    """Global balance of the screw: forces [N] and moments about the origin [N m] on it.

    The contact forces are summed at their contact points and the reactions come from the beam, so that the balance checks
    the solution independently. A free motion that nothing drives is prevented by a pin; what the pin carries, because the
    model's sections are planar, is no reaction of the scene. The residuals include the pin.
    """

    #: Sum of the loads ``(3,)`` [N].
    applied_force: Array = quantity("external_force_N", "sum of the loads, x, y, z", parts="[]")
    #: Their moment ``(3,)`` [N m].
    applied_moment: Array = quantity("external_moment_Nm", "their moment about the origin", parts="[]")
    #: Sum of the supports' reactions ``(3,)`` [N].
    reaction_force: Array = quantity("reaction_force_N", "sum of the supports' reactions", parts="[]")
    #: Their moment ``(3,)`` [N m].
    reaction_moment: Array = quantity("reaction_moment_Nm", "their moment", parts="[]")
    #: Sum of the contact forces on the screw ``(3,)`` [N].
    contact_force: Array = quantity("contact_force_N", "sum of the contact forces on the screw", parts="[]")
    #: Their moment ``(3,)`` [N m].
    contact_moment: Array = quantity("contact_moment_Nm", "their moment", parts="[]")
    #: Largest component of the sum of all forces over the largest force.
    force_residual: float = quantity(
        "force_residual",
        "sum of loads, reactions and contact forces over the largest force; does not use the solved equations",
    )
    #: Largest component of the sum of all moments over the largest moment.
    moment_residual: float = quantity("moment_residual", "the same of moments")
    #: Force of the pin ``(3,)`` [N].
    pin_force: Array = quantity(
        "pin_force_N",
        "what the pin of a free motion takes; no reaction of the scene",
        parts="[]",
        default_factory=lambda: np.zeros(3),
    )
    #: Moment of the pin ``(3,)`` [N m].
    pin_moment: Array = quantity("pin_moment_Nm", "its moment", parts="[]", default_factory=lambda: np.zeros(3))
    #: Largest component of the pin's force or moment over the largest force or moment.
    pin_share: float = quantity("pin_share", "its largest part over the largest force or moment", default=0.0)
    #: Largest net contact force on a ball over the largest force.
    ball_residual: float = quantity(
        "ball_residual", "largest unbalanced force of a ball over the largest force", default=0.0
    )
    #: Number of that ball, from 1.
    worst_ball: int = 0

    @property
    def largest(self) -> float:
        """Largest residual of screw and balls."""
        return max(self.force_residual, self.moment_residual, self.ball_residual)


@record
class SolverReport:
    """Effort and accuracy of a solve."""

    #: Newton steps.
    iterations: int = quantity("iterations", "Newton steps")
    #: Evaluations of the equations.
    evaluations: int = quantity("evaluations", "evaluations of the equations")
    #: Largest unbalanced force over the largest force.
    residual: float = quantity("residual", "largest unbalanced force of the solved equations over the largest force")
    #: Time of the solve [s].
    seconds: float = quantity("seconds", "time of the solve")
    #: Number of unknowns.
    unknowns: int = quantity("unknowns", "unknowns of the solve")
    #: Number of beam elements.
    elements: int = quantity("elements", "beam elements")
    #: ``"interpreted"`` or ``"compiled"`` kernels.
    engine: str = quantity("engine")
    #: What is solved.
    formulation: str = quantity("formulation")
    #: Residual that rounding in double precision can leave.
    round_off_bound: float = quantity("round_off_bound", "bound of the residual that rounding alone makes", default=0.0)
    #: Largest change of a contact load with a finer beam [N]; None where it was not computed.
    discretisation: float | None = quantity(
        "discretisation_percent",
        "change of the loads when every beam element is halved, in per cent of the mean load",
        show=lambda _: None,
        default=None,
    )
    #: Time before the iteration [s].
    setup_seconds: float = 0.0
    #: What happened during the solve.
    notes: tuple[str, ...] = quantity("notes", default=())


@dataclass(frozen=True)
class Answering:
    """Record with results that are set to nan where the solution did not converge."""

    #: Names of the fields that are results.
    ANSWERS: ClassVar[tuple[str, ...]] = ()

    def without_answers(self) -> Self:
        """Return a copy with nan in place of the results, also of nested records."""
        return replace(self, **{name: unknown(getattr(self, name)) for name in self.ANSWERS})


@dataclass(frozen=True, kw_only=True)
class Solved(Answering):
    """Static solution of a shaft, whatever its model."""

    #: Name of the model.
    model: str
    #: How the solution ended.
    status: Status
    #: Stations along the shaft ``(k,)`` [m].
    centreline_z: Array
    #: Displacements and rotations there ``(k, 6)`` [m, rad].
    centreline: Array
    #: Balance of the shaft; None without a solution.
    equilibrium: Equilibrium | None
    #: Effort and accuracy.
    solver: SolverReport
    #: Assumptions, of the scene and of the model.
    assumed: tuple[str, ...]
    #: What the solution leaves out, and why.
    left_out: tuple[str, ...]
    #: Where the solution leaves the range of validity.
    warnings: tuple[Warned, ...] = ()
    #: Number of the specimen, for a scene with random errors.
    member: int = 0
    #: Force and moment of every support on the shaft, at its station ``(s, 6)`` [N, N m].
    reactions: Array = field(default_factory=lambda: np.zeros((0, 6)))
    #: Names of the fields that are results.
    ANSWERS: ClassVar[tuple[str, ...]] = ("centreline", "equilibrium", "reactions")

    @property
    def converged(self) -> bool:
        """Whether the loads may be used."""
        return self.status == "converged"

    def of_balls(self) -> tuple[StaticResult, ...]:
        """Return the contacts of each set of balls."""
        return ()

    def answers(self) -> Self:
        """Return the result itself where it converged, else `without_answers`."""
        return self if self.converged else self.without_answers()


@dataclass(frozen=True, kw_only=True)
class StaticResult(Solved):
    """Static load distribution of one set of n balls, by ball and flank (SL, SR, NL, NR: screw and nut, left and right)."""

    #: Of the balls ``(n,)`` [rad].
    azimuth: Array
    #: Of the balls ``(n,)`` [m].
    z: Array
    #: Contact forces ``(n, 4)`` [N].
    load: Array
    #: ``(n, 4)`` [rad]; nan without contact.
    contact_angle: Array
    #: In space ``(n, 4, 3)`` [m].
    contact_point: Array
    #: Unit vectors of the forces on the ball ``(n, 4, 3)``.
    force_direction: Array
    #: Motion of the ball's centre in its section plane ``(n, 2)`` [m].
    centre_shift: Array
    #: Hertz constants ``(n, 4)`` [m/N^(2/3)].
    hertz_C: Array
    #: Largest pressures ``(n, 4)`` [Pa] of a model that computes them; None: by Hertz from the loads.
    pressure: Array | None = None
    #: Names of the fields that are results.
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
        """Return the result itself, the contacts of its only set."""
        return (self,)


@record
class SetResult(Answering):
    """One set of rolling elements of an assembly."""

    #: The set.
    of: RollingSet = quantity(
        "name",
        "",
        Stated("kind", show=lambda of: of.kind),
        Stated("position_mm", "station of the set's centre", show=lambda of: of.position),
        Stated("housing", show=lambda of: of.housing),
        Stated("offset_um", "axial offset of its outer body", show=lambda of: of.offset),
        show=lambda of: of.name,
    )
    #: Force of its elements on the shaft ``(3,)`` [N].
    force: Array = quantity("force_on_shaft_N", "force of the set on the shaft, x, y, z", parts="[]")
    #: Their moment about the axis point at the set's position ``(3,)`` [N m].
    moment: Array = quantity("moment_on_shaft_Nm", "its moment about the set's centre", parts="[]")
    #: Force and moment on the outer part there ``(6,)`` [N, N m], the opposite but for lever arms that grow with the
    #: displacements.
    reaction: Array
    #: Tangent stiffness of the set between inner and outer part ``(6, 6)`` [N/m, N, N m].
    stiffness: Array = quantity("stiffness", "the same of one set between its two bodies", parts="[][]")
    #: Motion of the outer part at the set's position, with its offset ``(6,)`` [m, rad].
    outer: Array = quantity("outer_motion", "displacement and rotation of its outer body", show=by_freedoms, parts=".*")
    #: Contacts, without ``equilibrium``; None for rollers.
    balls: StaticResult | None = None
    #: Of the rollers ``(count,)`` [rad]; None for balls.
    roller_azimuth: Array | None = None
    #: Force of either race on each roller ``(count,)`` [N]; None for balls.
    roller_load: Array | None = None
    #: Loads per length of the rollers' slices ``(count, slices)`` [N/m]; None for balls.
    line_loads: Array | None = None
    #: Names of the fields that are results.
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
        """Forces of the contacts of balls ``(n, 4)``, or of the rollers ``(count,)`` [N]."""
        return self.balls.load if self.balls is not None else np.zeros(0) if self.roller_load is None else self.roller_load


@record
class HousingResult(Answering):
    """Housing of an assembly."""

    #: Its name.
    name: str = quantity("name")
    #: Displacement and rotation at its station ``(6,)`` [m, rad].
    motion: Array = quantity(
        "motion", "displacement and rotation of the housing at its station", show=by_freedoms, parts=".*"
    )
    #: Force and moment of the frame on it there, by fixed freedoms and springs ``(6,)`` [N, N m].
    wrench: Array = quantity(
        "frame_force_N",
        "force on it of what holds it and of its springs, x, y, z",
        Stated("frame_moment_Nm", "their moment about its station", show=lambda wrench: wrench[3:], parts="[]"),
        show=lambda wrench: wrench[:3],
        parts="[]",
    )
    #: Unbalanced force and moment over the largest force.
    residual: float = quantity("residual", "what is left of its balance, over the largest force")
    #: Names of the fields that are results.
    ANSWERS: ClassVar[tuple[str, ...]] = ("motion", "wrench", "residual")


@dataclass(frozen=True, kw_only=True)
class AxisResult(Solved):
    """Static equilibrium of an assembly: a shaft with several sets of rolling elements."""

    #: Its sets.
    sets: tuple[SetResult, ...] = ()
    #: Its housings.
    housings: tuple[HousingResult, ...] = ()
    #: What ``stiffness`` refers to: a station of the shaft or a housing.
    stiffness_at: str = ""
    #: That station [m]; None for a housing.
    station: float | None = None
    #: Tangent stiffness of the whole assembly there ``(6, 6)`` [N/m, N, N m]; None where that is fixed.
    stiffness: Array | None = None
    #: Names of the fields that are results.
    ANSWERS: ClassVar[tuple[str, ...]] = (*Solved.ANSWERS, "sets", "housings")

    def of_balls(self) -> tuple[StaticResult, ...]:
        """Return the contacts of each set of balls."""
        return tuple(s.balls for s in self.sets if s.balls is not None)

    def without_answers(self) -> Self:
        """Return a copy with nan or None in place of loads, motions, stiffness and balance."""
        return replace(super().without_answers(), stiffness=None)


def unknown(value: Any) -> Any:
    """Return the placeholder of a result that is not known: nan for numbers, also within records; None for a balance."""
    if isinstance(value, tuple):
        return tuple(unknown(x) for x in value)
    if isinstance(value, Answering):
        return value.without_answers()
    if isinstance(value, float):
        return float("nan")
    return None if value is None or isinstance(value, Equilibrium) else np.full(value.shape, np.nan)
