"""Results of the static models for a single ball screw or bearing, and for shafts with several: frozen records in SI units.

A scene without equilibrium raises no exception; the status of its result gives the reason.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal, Self

import numpy as np

from rollbench.lowfi.warned import ResultWarning
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollingSet
from rollbench.meshes.quantity import QuantityDescription, quantity_field, result_record

#: How a solve ended, see `Status`.
Ended = Literal["converged", "not held", "not converged", "stopped"]
#: Known cause of a failed solve, see `Status`.
Cause = Literal["", "crossed row", "mounting", "not unique"]

#: Keys of the six motions in JSON results, with their units, and factors from m and rad to these units.
MOTION = (("ux_um", 1e6), ("uy_um", 1e6), ("uz_um", 1e6), ("rx_mrad", 1e3), ("ry_mrad", 1e3), ("rz_mrad", 1e3))

#: Effect that every model neglects for a shaft with a thermal strain.
HEAT = (
    "growth of inner rings and rolling elements by heat, which presses on them: heat lengthens the shaft between the inner "
    "contact points of its bearings and nuts, and does nothing else"
)


def motion_in_um_and_mrad(motion: Array) -> dict[str, float]:
    """Return three displacements and three rotations as a dictionary in um and mrad with keys such as "ux_um".

    Parameters
    ----------
    motion
        Displacements and rotations, ``(6,)`` [m, rad].
    """
    return {name: factor * x for (name, factor), x in zip(MOTION, motion, strict=True)}


class Status(str):
    """Text that states whether a solve converged, and if not, the kind of failure and its reason.

    Examples
    --------
    >>> found = Status("not held", "rotation about the screw's axis")
    >>> found, found.kind, found.reason
    ("not held: rotation about the screw's axis", 'not held', "rotation about the screw's axis")
    """

    #: "converged"; "not held": the loads drive a motion that no support or contact resists; "not converged"; or "stopped":
    #: a stiffness matrix was not positive definite.
    kind: Ended
    #: Reason why there is no solution; empty if converged.
    reason: str
    #: Known cause of the failure: "crossed row", a bearing loaded against its direction of thrust; "mounting", preloads
    #: that are not reached; "not unique", several possible contact patterns; empty if unknown.
    cause: Cause

    def __new__(cls, kind: Ended, reason: str = "", cause: Cause = "") -> Status:
        """Make a status with the text "kind: reason", or the kind alone if there is no reason.

        ``cause``: known cause of the failure; empty if it is unknown.
        """
        status = super().__new__(cls, f"{kind}: {reason}" if reason else kind)
        status.kind, status.reason, status.cause = kind, reason, cause
        return status

    def __getnewargs__(self) -> tuple[Ended, str, Cause]:  # type: ignore[override]
        """Return the constructor's arguments, from which pickle makes a copy."""
        return self.kind, self.reason, self.cause


@result_record
class Equilibrium:
    """Check of equilibrium of a screw or shaft: sums of the forces [N], and of the moments about the origin [N m], on it.

    Contact forces are summed at their contact points, and reactions are computed from the beam, so that the sums check the
    solution independently of the solved equations. A rigid motion that neither support nor contact resists and no load
    drives is prevented by a pin, a degree of freedom that is fixed although no support fixes it. Since the model keeps
    balls in their section planes, the pin may carry a small load, which is not a reaction of a support. The residuals
    include this load.
    """

    #: Sum of the external loads ``(3,)`` [N].
    applied_force: Array = quantity_field("external_force_N", "sum of the external loads, x, y, z", parts="[]")
    #: Moment of the external loads about the origin ``(3,)`` [N m].
    applied_moment: Array = quantity_field(
        "external_moment_Nm", "moment of the external loads about the origin, x, y, z", parts="[]"
    )
    #: Sum of the supports' reactions ``(3,)`` [N].
    reaction_force: Array = quantity_field("reaction_force_N", "sum of the supports' reactions", parts="[]")
    #: Moment of the supports' reactions about the origin ``(3,)`` [N m].
    reaction_moment: Array = quantity_field(
        "reaction_moment_Nm", "moment of the supports' reactions about the origin", parts="[]"
    )
    #: Sum of the contact loads on the screw ``(3,)`` [N].
    contact_force: Array = quantity_field("contact_force_N", "sum of the contact loads on the screw", parts="[]")
    #: Moment of the contact loads about the origin ``(3,)`` [N m].
    contact_moment: Array = quantity_field("contact_moment_Nm", "moment of the contact loads about the origin", parts="[]")
    #: Largest component of the sum of all forces, divided by the largest force.
    force_residual: float = quantity_field(
        "force_residual",
        "sum of loads, reactions and contact loads over the largest force; does not use the solved equations",
    )
    #: Largest component of the sum of all moments, divided by the largest moment.
    moment_residual: float = quantity_field(
        "moment_residual", "sum of the moments of loads, reactions and contact loads over the largest moment"
    )
    #: Force on the screw ``(3,)`` [N] at a pin, a degree of freedom that the model fixes although no support does.
    pin_force: Array = quantity_field(
        "pin_force_N",
        "force of the pin that prevents a motion which nothing else resists; not a reaction of a support",
        parts="[]",
        default_factory=lambda: np.zeros(3),
    )
    #: Moment on the screw about the origin ``(3,)`` [N m] at a pin, a degree of freedom that the model fixes although no
    #: support does.
    pin_moment: Array = quantity_field(
        "pin_moment_Nm", "moment about the origin that the pin exerts", parts="[]", default_factory=lambda: np.zeros(3)
    )
    #: Largest component of the force or moment at a pin (a degree of freedom that the model fixes although no support
    #: does), as a fraction of the largest force or moment.
    pin_share: float = quantity_field(
        "pin_share", "largest component of the pin's force or moment over the largest force or moment", default=0.0
    )
    #: Largest resultant of the contact forces on a ball, which is zero in equilibrium, divided by the largest force.
    ball_residual: float = quantity_field(
        "ball_residual", "largest unbalanced force of a ball over the largest force", default=0.0
    )
    #: Number of the ball, from 1, with the largest resultant of its contact forces, which is zero in equilibrium; 0: none.
    worst_ball: int = 0

    @property
    def largest(self) -> float:
        """Return the largest of the relative residuals of forces, of moments, and of the forces on each ball."""
        return max(self.force_residual, self.moment_residual, self.ball_residual)


@result_record
class SolverReport:
    """Effort and accuracy of a static solve: iterations, residual, time, size of the system, and notes."""

    #: Number of Newton steps.
    iterations: int = quantity_field("iterations", "Newton steps")
    #: Number of evaluations of the equations.
    evaluations: int = quantity_field("evaluations", "evaluations of the equations")
    #: Largest unbalanced force of the solved equations, divided by the largest force.
    residual: float = quantity_field("residual", "largest unbalanced force of the solved equations over the largest force")
    #: Time of the solve [s].
    seconds: float = quantity_field("seconds", "time of the solve")
    #: Number of unknowns of the equations.
    unknowns: int = quantity_field("unknowns", "unknowns of the solve")
    #: Number of beam elements of the shaft.
    elements: int = quantity_field("elements", "beam elements")
    #: Mathematical formulation that is solved, for example "convex energy".
    formulation: str = quantity_field("formulation")
    #: Relative residual that rounding errors in double precision can leave.
    round_off_bound: float = quantity_field("round_off_bound", "residual that rounding errors can leave", default=0.0)
    #: Estimated error by the beam's discretisation [N]: largest change of a contact load if every beam element is halved
    #: or, if the beam's nodes are not at the contacts, if a node is placed at every contact; None if it was not computed.
    discretisation: float | None = quantity_field(
        "discretisation_percent",
        "largest change of a contact load if every beam element is halved, in per cent of the mean load",
        show=lambda _: None,
        default=None,
    )
    #: Time to set up the equations, before the iteration [s].
    setup_seconds: float = 0.0
    #: Sentences on special events of the solve, such as a second solve with more flanks.
    notes: tuple[str, ...] = quantity_field("notes", default=())


@dataclass(frozen=True)
class NanUnlessConverged:
    """Base class of results, which can replace the fields that are valid only for a converged solution by nan."""

    #: Names of the fields whose values are replaced by nan if the solution did not converge.
    ANSWERS: ClassVar[tuple[str, ...]] = ()

    def with_nan_answers(self) -> Self:
        """Return a copy of the result with nan in the fields named in ``ANSWERS``, also in nested records.

        The check of equilibrium (field ``equilibrium``) becomes None.
        """
        return replace(self, **{name: nan_in_place_of(getattr(self, name)) for name in self.ANSWERS})


@dataclass(frozen=True, kw_only=True)
class StaticSolution(NanUnlessConverged):
    """Static solution by any model: fields that results of a single screw and of an assembly of bearings have in common."""

    #: Name of the model.
    model: str
    #: Whether the solve converged, and if not, the reason.
    status: Status
    #: Axial positions along the shaft's centreline ``(k,)`` [m].
    centreline_z: Array = field(default_factory=lambda: np.zeros(0))
    #: Displacements and rotations of the shaft at the positions ``centreline_z``: ``(k, 6)`` [m, rad].
    centreline: Array = field(default_factory=lambda: np.zeros((0, 6)))
    #: Check of equilibrium: sums of forces and moments on the shaft; None without a solution.
    equilibrium: Equilibrium | None = None
    #: Effort and accuracy of the solve.
    solver: SolverReport
    #: Assumptions of the scene and of the model, as sentences.
    assumed: tuple[str, ...] = ()
    #: Neglected effects with reasons, as sentences.
    left_out: tuple[str, ...] = ()
    #: Warnings where the solution leaves the model's range of validity.
    warnings: tuple[ResultWarning, ...] = ()
    #: Number of the specimen, for a scene with random errors.
    member: int = 0
    #: Force and moment of every support on the shaft, at the support's axial position ``(s, 6)`` [N, N m].
    reactions: Array = field(default_factory=lambda: np.zeros((0, 6)))
    #: Names of the fields that are replaced by nan if the solution did not converge.
    ANSWERS: ClassVar[tuple[str, ...]] = ("centreline", "equilibrium", "reactions")

    @property
    def converged(self) -> bool:
        """Return whether the solve converged, so that loads and motions are valid."""
        return self.status == "converged"

    def ball_results(self) -> tuple[StaticResult, ...]:
        """Return the static result of each ball nut and ball bearing on the shaft."""
        return ()

    def nan_unless_converged(self) -> Self:
        """Return this result if it converged, else a copy with nan in place of loads and motions."""
        return self if self.converged else self.with_nan_answers()


@dataclass(frozen=True, kw_only=True)
class StaticResult(StaticSolution):
    """Static load distribution over the n balls of one ball nut or ball bearing.

    Arrays with an axis of length 4 are ordered by flank: SL, SR, NL, NR, which are screw (or inner ring) left and right,
    nut (or outer ring) left and right.
    """

    #: Azimuth of the balls ``(n,)`` [rad].
    azimuth: Array
    #: Axial position of the balls ``(n,)`` [m].
    z: Array
    #: Contact forces ``(n, 4)`` [N].
    load: Array
    #: Contact angles ``(n, 4)`` [rad] from the groove's bottom; nan without contact.
    contact_angle: Array
    #: Contact points in space ``(n, 4, 3)`` [m].
    contact_point: Array
    #: Unit vectors of the contact forces on the balls ``(n, 4, 3)``.
    force_direction: Array
    #: Displacement of the ball's centre in its section plane ``(n, 2)`` [m].
    centre_shift: Array
    #: Hertz constants C ``(n, 4)`` [m/N^(2/3)]: approach = C load^(2/3).
    hertz_C: Array
    #: Largest contact pressures ``(n, 4)`` [Pa], if the model computes them; None: they follow from the contact forces by
    #: Hertz's theory.
    pressure: Array | None = None
    #: Names of the fields that are replaced by nan if the solution did not converge.
    ANSWERS: ClassVar[tuple[str, ...]] = (
        *StaticSolution.ANSWERS,
        "load",
        "contact_angle",
        "contact_point",
        "force_direction",
        "centre_shift",
        "pressure",
    )

    def ball_results(self) -> tuple[StaticResult, ...]:
        """Return a tuple with this result as its only element."""
        return (self,)


@result_record
class SetResult(NanUnlessConverged):
    """Result of one bearing or ball nut of an assembly: forces on shaft and housing, stiffness, and contact loads."""

    #: The bearing or ball nut.
    of: RollingSet = quantity_field(
        "name",
        "",
        QuantityDescription("kind", show=lambda of: of.kind),
        QuantityDescription(
            "position_mm", "axial position of the centre of the bearing or nut", show=lambda of: of.position
        ),
        QuantityDescription("housing", show=lambda of: of.housing),
        QuantityDescription("offset_um", "axial offset of the outer ring or nut", show=lambda of: of.offset),
        show=lambda of: of.name,
    )
    #: Force of the balls or rollers on the shaft ``(3,)`` [N].
    force: Array = quantity_field("force_on_shaft_N", "force of the bearing or nut on the shaft, x, y, z", parts="[]")
    #: Moment of the balls or rollers on the shaft, about the axis point at the centre of the bearing or nut ``(3,)`` [N m].
    moment: Array = quantity_field(
        "moment_on_shaft_Nm", "moment of the bearing or nut on the shaft about its centre, x, y, z", parts="[]"
    )
    #: Force and moment of the balls or rollers on the outer ring or nut, about the axis point at its centre ``(6,)``
    #: [N, N m]. They are opposite to those on the shaft except for the change of lever arms by displacements.
    reaction: Array
    #: Tangent stiffness between inner and outer ring, or screw and nut ``(6, 6)`` [N/m, N, N m].
    stiffness: Array = quantity_field(
        "stiffness",
        "tangent stiffness of one bearing or nut between its inner and outer part: change of force and moment for one of "
        "the six motions, the other five held; the axial rigidity with the scene's own motions is `nut.tangent_N_per_um`",
        parts="[][]",
    )
    #: Motion of the outer ring or nut at its centre, its offset included ``(6,)`` [m, rad].
    outer: Array = quantity_field(
        "outer_motion", "displacement and rotation of the outer ring or nut", show=motion_in_um_and_mrad, parts=".*"
    )
    #: Contact results of balls, without ``equilibrium``; None for rollers.
    balls: StaticResult | None = None
    #: Azimuth of the rollers ``(count,)`` [rad]; None for balls.
    roller_azimuth: Array | None = None
    #: Force between each roller and either raceway ``(count,)`` [N]; None for balls.
    roller_load: Array | None = None
    #: Load per unit length of the rollers' slices ``(count, slices)`` [N/m]; None for balls.
    line_loads: Array | None = None
    #: Names of the fields that are replaced by nan if the solution did not converge.
    ANSWERS = ("force", "moment", "reaction", "stiffness", "outer", "balls", "roller_load", "line_loads")

    @property
    @QuantityDescription(
        "largest_load_N",
        "largest contact or roller load of the bearing or nut",
        error="model form",
        show=lambda loads: loads.max(initial=0.0),
    )
    @QuantityDescription(
        "loaded",
        "number of loaded contacts or rollers of the bearing or nut",
        show=lambda loads: int((loads > 0.0).sum()) if np.isfinite(loads).all() else None,
    )
    def loads(self) -> Array:
        """Return the contact forces of the balls ``(n, 4)`` [N], or of each roller with either raceway ``(count,)`` [N]."""
        return self.balls.load if self.balls is not None else np.zeros(0) if self.roller_load is None else self.roller_load


@result_record
class HousingResult(NanUnlessConverged):
    """Result of one housing of an assembly: motion, force and moment by supports and springs, and unbalanced force."""

    #: Name of the housing.
    name: str = quantity_field("name")
    #: Displacement and rotation of the housing at its reference point, the point of the shaft's axis at the housing's axial
    #: position ``(6,)`` [m, rad].
    motion: Array = quantity_field(
        "motion", "displacement and rotation of the housing at its axial position", show=motion_in_um_and_mrad, parts=".*"
    )
    #: Force and moment that supports (fixed degrees of freedom) and springs exert on the housing, about the point of the
    #: shaft's axis at its axial position ``(6,)`` [N, N m].
    wrench: Array = quantity_field(
        "frame_force_N",
        "force on the housing by its fixed freedoms and its springs, x, y, z",
        QuantityDescription(
            "frame_moment_Nm",
            "moment on the housing by its fixed freedoms and its springs, about its axial position",
            show=lambda wrench: wrench[3:],
            parts="[]",
        ),
        show=lambda wrench: wrench[:3],
        parts="[]",
    )
    #: Unbalanced force and moment on the housing, divided by the largest force.
    residual: float = quantity_field("residual", "unbalanced force and moment on the housing over the largest force")
    #: Names of the fields that are replaced by nan if the solution did not converge.
    ANSWERS: ClassVar[tuple[str, ...]] = ("motion", "wrench", "residual")


@dataclass(frozen=True, kw_only=True)
class AxisResult(StaticSolution):
    """Static equilibrium of an assembly: a shaft with several bearings and ball nuts."""

    #: Results of the bearings and ball nuts.
    sets: tuple[SetResult, ...] = ()
    #: Results of the housings.
    housings: tuple[HousingResult, ...] = ()
    #: Location at which ``stiffness`` is taken, as text: an axial position of the shaft, or a housing.
    stiffness_at: str = ""
    #: Axial position at which ``stiffness`` is taken [m]; None for a housing.
    station: float | None = None
    #: Tangent stiffness of the whole assembly at the location ``stiffness_at``: ``(6, 6)`` [N/m, N, N m]; None if this
    #: location is fixed.
    stiffness: Array | None = None
    #: Names of the fields that are replaced by nan if the solution did not converge.
    ANSWERS: ClassVar[tuple[str, ...]] = (*StaticSolution.ANSWERS, "sets", "housings")

    def ball_results(self) -> tuple[StaticResult, ...]:
        """Return the static result of each ball nut and ball bearing on the shaft."""
        return tuple(s.balls for s in self.sets if s.balls is not None)

    def with_nan_answers(self) -> Self:
        """Return a copy with nan or None in place of loads, motions, stiffness and equilibrium sums."""
        return replace(super().with_nan_answers(), stiffness=None)


def nan_in_place_of(value: Any) -> Any:
    """Return the value (nan or None) that replaces ``value`` in the result if the solution did not converge.

    Numbers and arrays become nan, also within records and tuples; an `Equilibrium` becomes None.
    """
    if isinstance(value, tuple):
        return tuple(nan_in_place_of(x) for x in value)
    if isinstance(value, NanUnlessConverged):
        return value.with_nan_answers()
    if isinstance(value, float):
        return float("nan")
    return None if value is None or isinstance(value, Equilibrium) else np.full(value.shape, np.nan)
