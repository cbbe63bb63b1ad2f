"""Results of one nut or bearing: the only one of a scene, or one of several on a shaft.

A field states the key, the definition and the heading of its quantity; JSON, tables and the manual follow from it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from rollbench.compare.measure import count_contacts, mean_load
from rollbench.compare.models.friction_torques import FrictionTorques
from rollbench.compare.models.loading import LiftOff, Preload
from rollbench.compare.models.stiffness import NutStiffness
from rollbench.compare.quantities import json_number, record_as_json
from rollbench.lowfi.bearings.tapered_roller import RibContact
from rollbench.lowfi.bearings.torque import BallBearingTorque, PalmgrenLoadTorque, RollerBearingTorque
from rollbench.lowfi.rating.contacts import (
    RACES,
    EllipseTruncation,
    Ratings,
    WorstContact,
    contact_pressures,
    race_pressures,
)
from rollbench.lowfi.rating.iso_lives import ModifiedLife, ReferenceLife
from rollbench.lowfi.rating.life import Life
from rollbench.meshes import one_arc
from rollbench.meshes.arrays import Array
from rollbench.meshes.axis import RollerRow
from rollbench.meshes.parts import SIDES, Scene
from rollbench.meshes.quantity import QuantityDescription, quantity_field, quantity_or_none, result_record, text_or_none

if TYPE_CHECKING:
    from rollbench.lowfi.rating.rigidity import AxialRigidities
    from rollbench.lowfi.statics.result import SetResult as SetOnShaft
    from rollbench.lowfi.statics.result import StaticResult

#: Life that follows from the loads of all contacts: L10 of a nut, L10r of a bearing.
LifeByLoads: TypeAlias = Life | ReferenceLife


def values_by_flank(row: Array) -> dict[str, float | None]:
    """Return one ball's four values by groove flank: SL, SR, NL, NR (screw or nut, left or right); nan becomes None."""
    return {side: json_number(value) for side, value in zip(SIDES, row, strict=True)}


@result_record
class BallResult:
    """Position of one ball, and its load, contact angle and pressure on the four groove flanks, (4,) each, in SI units.

    The flanks are SL, SR, NL, NR (screw or nut, left or right).
    """

    index: int = quantity_field("index", "number of the ball along its track, from 1")
    azimuth: float = quantity_field(
        "azimuth_deg", "nominal azimuth of the ball, from x to y; it keeps increasing after each turn of the helix"
    )
    z: float = quantity_field("z_mm", "nominal axial position of the ball's centre along the screw")
    load: Array = quantity_field(
        "load_N",
        "contact load of this ball on this flank; 0 without contact",
        error="model form: `model_form`; measured: `compare`",
        parts=".FLANK",
        show=values_by_flank,
    )
    angle: Array = quantity_field(
        "contact_angle_deg",
        "angle between the contact normal and the radial direction, in the axial plane through the ball's solved position; "
        "null without load",
        error="of the order of the elastic approach divided by the groove's excess radius",
        parts=".FLANK",
        show=values_by_flank,
    )
    pressure: Array = quantity_field(
        "pressure_MPa",
        "largest pressure of this contact, from the load and the radii with their errors by Hertz's theory, or as the "
        "model gives it; 0 without contact",
        error="a third of that of the load",
        parts=".FLANK",
        show=values_by_flank,
    )


@result_record
class RollerResult:
    """Position, load, largest load per length and largest pressures of one roller, in SI units."""

    index: int = quantity_field("index", "number of the roller in its row, from 1")
    azimuth: float = quantity_field("azimuth_deg", "azimuth of the roller, from x to y")
    load: float = quantity_field("load_N", "load of the roller on either race", error="not compared with a 3D model")
    line_load: float = quantity_field(
        "largest_line_load_N_mm",
        "largest load per length of any of the equal slices into which the roller is divided",
        error="that of the slice model, which neglects the stress concentration at the ends of straight rollers",
    )
    pressure: dict[str, float] = quantity_field(
        "pressure_MPa",
        "largest pressure along the roller on inner and outer race, from sqrt(q E*/(pi R)) with the line load q and the "
        "relative radius R of each slice",
        error="half that of the line load",
        parts=".*",
    )


@result_record
class BallLoadSummary:
    """Summary of the contact loads of all balls: largest, mean and smallest load [N], and numbers of contacts."""

    ball: int = quantity_field("worst_ball", "number of the ball with the largest contact load")
    side: str = quantity_field("worst_side", "groove flank with the largest contact load")
    largest: float = quantity_field(
        "max_N",
        "largest contact load",
        error="model form, `largest_percent_of_mean`",
        heading="largest contact load",
        expected=("loads", 1.0),
        note="ball {worst_ball} {worst_side}",
    )
    mean: float = quantity_field(
        "mean_N",
        "mean contact load: sum of the loads, divided by the number of contacts that are loaded in the screw without "
        "geometric errors",
        error="small: equilibrium fixes the sum",
        heading="mean contact load",
    )
    smallest: float = quantity_field(
        "min_N",
        "smallest load of a loaded contact",
        error="model form, `largest_percent_of_mean`",
        heading="smallest contact load",
        expected=("loads", 1.0),
        note="of {loaded_contacts} loaded",
    )
    loaded_contacts: int = quantity_field("loaded_contacts", "number of loaded contacts")
    contacts_in_mean: int = quantity_field(
        "contacts_in_mean", "number of contacts by which the sum of the loads is divided for the mean"
    )
    unloaded_balls: int = quantity_field(
        "balls_without_load", "number of balls without any load", heading="balls without load"
    )


@result_record
class RollerLoadSummary:
    """Summary of the loads of a row of rollers: largest, mean and smallest load [N], and numbers of rollers."""

    roller: int = quantity_field(
        "worst_roller",
        "number of the roller with the largest load; for a row of rollers this table counts rollers instead of contacts, "
        "since each roller has the same load on both races",
    )
    largest: float = quantity_field("max_N", heading="largest roller load", note="roller {worst_roller}")
    mean: float = quantity_field("mean_N", heading="mean roller load")
    smallest: float = quantity_field("min_N", heading="smallest roller load", note="of {loaded_contacts} loaded")
    loaded_rollers: int = quantity_field("loaded_contacts")
    unloaded_rollers: int = quantity_field(
        "rollers_without_load", "number of rollers without any load", heading="rollers without load"
    )


@result_record
class FlankLoadSummary:
    """Summary of the contact loads on one groove flank: largest and smallest load [N], their ratio, numbers of contacts."""

    largest: float = quantity_field("max_N", "largest load on this flank", error="as `loads.max_N`")
    smallest: float = quantity_field("min_N", "smallest load of a loaded contact on this flank", error="as `loads.min_N`")
    ratio: float = quantity_field(
        "ratio",
        "largest load on this flank, divided by the smallest",
        error="that of both loads; in the worst case their errors have opposite signs",
    )
    loaded_contacts: int = quantity_field("loaded", "number of loaded contacts on this flank")
    unloaded_contacts: int = quantity_field("lost", "number of contacts on this flank that carry no load")


def ball_load_summary(load: Array, contacts: int = 0) -> BallLoadSummary | None:
    """Return the summary of the contact loads of balls; None if no contact is loaded.

    ``load``: contact loads of n balls on the four flanks, (n, 4) [N]. ``contacts``: number by which the sum of the loads is
    divided for the mean load; 0: the number of contacts that bear 1 % of the largest load or more (`count_contacts`).
    """
    loaded = load > 0.0
    if not loaded.any():
        return None
    carried, mean = load[loaded], mean_load(load, contacts)
    i, s = np.unravel_index(int(load.argmax()), load.shape)
    empty = int((~loaded.any(axis=1)).sum())
    ends, counts = (carried.max(), mean, carried.min()), (int(carried.size), count_contacts(load, contacts), empty)
    return BallLoadSummary(int(i) + 1, SIDES[int(s)], *ends, *counts)


def roller_load_summary(load: Array) -> RollerLoadSummary | None:
    """Return the summary of the loads (count,) [N] of a row of rollers; None if all are zero."""
    carried = load[load > 0.0]
    if not carried.size:
        return None
    ends, empty = (carried.max(), carried.mean(), carried.min()), int(load.size - carried.size)
    return RollerLoadSummary(int(load.argmax()) + 1, *ends, int(carried.size), empty)


def flank_load_summaries(load: Array) -> dict[str, FlankLoadSummary]:
    """Return the summary of the contact loads of n balls, (n, 4) [N], on each loaded groove flank, by its name."""
    out = {}
    for side, values in zip(SIDES, load.T, strict=True):
        loaded = values[values > 0.0]
        if loaded.size:
            most, least, lost = loaded.max(), loaded.min(), int(values.size - loaded.size)
            out[side] = FlankLoadSummary(most, least, most / least, int(loaded.size), lost)
    return out


def clearance_of_deep_groove(parts: Scene, thrust: str = "deep groove") -> one_arc.InternalClearance | None:
    """Return the clearance of a deep-groove ball bearing row; None for other rows and for rows without play.

    Parameters
    ----------
    parts
        Bearing row as a scene.
    thrust
        Direction of the axial force that the row can carry: "+z", "-z", "both", or "deep groove" (both directions).

    Returns
    -------
    InternalClearance or None
        Axial and radial play [m], and the contact angle at the end of the play [rad].
    """
    found = one_arc.internal_clearance(parts) if thrust == "deep groove" else None
    return found if found is not None and found.axial > 0.0 else None


def palmgren_load_torque(parts: Scene, thrust: float) -> PalmgrenLoadTorque:
    """Return the load-dependent friction torque of a ball bearing by Palmgren's formula (Smith, equations 2.33 to 2.38).

    ``thrust`` is the axial load [N]. The formula is for contact angles of about 60 deg.
    """
    from rollbench.lowfi.bearings.torque import load_dependent_torque, palmgren_static_rating
    from rollbench.lowfi.statics.contacts import nominal_curvatures

    ball, track = 2.0 * parts.balls.radius, parts.track
    across, along = nominal_curvatures(parts)[0]
    rated = palmgren_static_rating(1, parts.ball_count, ball, track.contact_angle, float(across), float(along))
    return load_dependent_torque(abs(thrust), 0.0, 2.0 * track.pitch_radius, rated)


def _if_finite(values: Array | None) -> Array | None:
    """Return an array of a solution; None without equilibrium, which leaves nan, or if there is no such array."""
    return None if values is None or not np.isfinite(values).all() else values


@result_record(eq=False, repr=False, kw_only=True)
class Balls:
    """Positions of n balls, and the loads, angles and pressures of their contacts, as arrays with a row for each ball.

    The four columns are the groove flanks SL, SR, NL, NR (screw or nut, left or right, seen along +z). All are None for
    rollers. Without an equilibrium, loads, angles and pressure are None too.
    """

    @property
    def ball_sets(self) -> list[tuple[Scene, StaticResult]]:
        """Geometry and solution of each nut or bearing with balls."""
        return []

    def _of_balls(self, name: str) -> Array | None:
        """Return the field ``name`` of the solutions of all balls, joined; None without balls, or if it is not known."""
        each = [getattr(balls, name) for _, balls in self.ball_sets]
        joined = np.concatenate(each) if each else None
        return None if joined is None or (name == "load" and not np.isfinite(joined).all()) else joined

    @property
    def azimuth(self) -> Array | None:
        """Azimuth of every ball about the axis, (n,) [rad]."""
        return self._of_balls("azimuth")

    @property
    def z(self) -> Array | None:
        """Axial position of every ball, (n,) [m]."""
        return self._of_balls("z")

    @property
    def loads(self) -> Array | None:
        """Contact loads of n balls on the four groove flanks, (n, 4) [N]; zero without contact."""
        return self._of_balls("load")

    @property
    def angles(self) -> Array | None:
        """Contact angles of n balls under load, from the radial plane, (n, 4) [rad]; nan without contact."""
        loads, angles = self.loads, self._of_balls("contact_angle")
        return None if loads is None or angles is None else np.where(loads > 0.0, angles, np.nan)

    @property
    def pressure(self) -> Array | None:
        """Largest pressure in every contact of n balls, by the model or Hertz's theory, (n, 4) [Pa]; zero without one."""
        if self.loads is None:
            return None
        return np.concatenate([contact_pressures(*each) for each in self.ball_sets])


@result_record(eq=False, repr=False, kw_only=True)
class SetResult(Balls):
    """Results of one nut, ball bearing or roller bearing: the only one of a scene, or one of several on a shaft."""

    name: str = ""
    """Name of the nut or bearing in the scene; empty if the scene has only one."""
    parts: Scene | RollerRow
    """Geometry and materials of the nut or bearing."""
    balls: StaticResult | None = None
    """Solution of the contacts of balls; None for rollers."""
    on_shaft: SetOnShaft | None = None
    """Solution of this nut or bearing as one of several on a shaft; None if the scene has only one."""
    nominal_contacts: int = 0
    """Number of contacts by which the sum of the loads is divided for the mean load; 0 for that of the loaded ones."""
    nut: NutStiffness | None = quantity_or_none("nut")
    """Axial displacement [m] and stiffness [N/m] of this nut or bearing between its two parts, under the scene's loads."""
    rigidities: AxialRigidities | None = None
    """Axial rigidity [N/m] of a single nut or bearing by several definitions; None without axial force."""
    worst: WorstContact | None = quantity_or_none(
        "worst_contact", "", QuantityDescription("static_safety", show=lambda worst: worst and worst.static_safety)
    )
    """Contact with the highest pressure; None if no contact is loaded."""
    rib: RibContact | None = quantity_or_none("rib_contact")
    """Contact of the most loaded roller with the rib of its ring; None for balls, and if no contact is loaded."""
    truncation: EllipseTruncation | None = quantity_or_none("truncation")
    """Contact ellipse that comes closest to the edge of its groove; None for rollers."""
    preload: Preload | None = quantity_or_none("preload")
    """Contact loads without the external loads of the scene; None if there is no equilibrium without external loads."""
    lift_off: LiftOff | None = quantity_or_none("contact_lost")
    """External load at which the first preloaded contact opens; None without preload."""
    friction: FrictionTorques | None = quantity_or_none(
        "friction", show=lambda torques: None if torques is None else torques.torques_as_json()
    )
    """Friction torques and efficiencies; None if not computed."""
    friction_words: str = text_or_none("friction_words", "why the friction torques are not computed; null if they are")
    """Why the friction torques are not computed; empty if they are, and for bearings on a shaft."""
    torque: RollerBearingTorque | None = quantity_or_none("roller_torque")
    """Friction torque of a row of rollers [N m], from the work of friction and from Timken's formula; None for balls, and
    if no contact is loaded."""
    bearing_torque: BallBearingTorque | None = quantity_or_none("bearing_torque")
    """Friction torque of a ball bearing [N m]; None for nuts, and if no contact is loaded."""
    life: Life | None = quantity_or_none("life")
    """Life L10; None if no contact is loaded, and where `life_words` or `rating_refused` gives another reason."""
    modified_life: ModifiedLife | None = quantity_or_none("modified_life")
    """Life modified for reliability, lubricant and contamination [10^6 revolutions]; None if the scene states none of the
    three, and for rollers."""
    reference_life: ReferenceLife | None = quantity_or_none("reference_life")
    """Life of a bearing by ISO/TS 16281 [10^6 revolutions]; None for nuts, and if no contact is loaded."""
    life_words: str = text_or_none(
        "life_words",
        "why there is no life L10: what ISO 281 does not cover, or that the rings do not turn; null if there is one",
    )
    """Why there is no life L10, such as a load that ISO 281 does not cover, or rings that do not turn; else empty."""
    ratings: Ratings | None = quantity_or_none("ratings")
    """Dynamic and static load ratings."""
    rating_refused: str = text_or_none("rating_refused", "why no life and no load ratings can be computed")
    """Why no life and no load ratings can be computed; empty if they can."""

    @property
    def ball_sets(self) -> list[tuple[Scene, StaticResult]]:
        """Geometry and solution of the balls; empty for rollers."""
        return [(self.parts, self.balls)] if isinstance(self.parts, Scene) and self.balls is not None else []

    @property
    def kind(self) -> str:
        """Kind of machine element, such as ball nut, bearing, or tapered roller bearing."""
        if self.on_shaft is not None:
            return self.on_shaft.of.kind
        return "ball nut" if isinstance(self.parts, Scene) and self.parts.track.lead else "bearing"

    @property
    def position(self) -> float:
        """Axial position on the shaft [m]."""
        if self.on_shaft is None:
            assert isinstance(self.parts, Scene), "a row of rollers is on a shaft"
            return self.parts.nut.position
        return self.on_shaft.of.position

    @property
    def force(self) -> Array | None:
        """Resultant force of the balls or rollers on the shaft, (3,) [N]."""
        if self.on_shaft is not None:
            return _if_finite(self.on_shaft.force)
        return None if self.balls is None or self.balls.equilibrium is None else self.balls.equilibrium.contact_force

    @property
    def moment(self) -> Array | None:
        """Moment of the balls or rollers on the shaft, about the shaft's axis at `position`, (3,) [N m]."""
        if self.on_shaft is not None:
            return _if_finite(self.on_shaft.moment)
        if self.balls is None or self.balls.equilibrium is None:
            return None
        whole = self.balls.equilibrium
        return whole.contact_moment - np.cross([0.0, 0.0, self.position], whole.contact_force)

    @property
    def stiffness(self) -> Array | None:
        """Tangent stiffness between shaft and fixed outer part, (6, 6) [N/m, N, N m], in ux, uy, uz, rx, ry, rz.

        None for the only nut or bearing of a scene, see `Result.stiffness`.
        """
        return None if self.on_shaft is None else _if_finite(self.on_shaft.stiffness)

    @property
    def roller_loads(self) -> Array | None:
        """Loads of the rollers, (count,) [N]; None for balls."""
        return None if self.on_shaft is None else _if_finite(self.on_shaft.roller_load)

    @property
    def life_loads(self) -> Array | None:
        """Loads from which the life follows: of n balls' contacts (n, 4) [N], or lines of rollers (count, slices) [N/m]."""
        return self.balls.load if self.balls is not None else None if self.on_shaft is None else self.on_shaft.line_loads

    @property
    def preload_of_halves(self) -> float:
        """Axial force with which two halves of a nut with lead offset press against each other [N]; 0 for other nuts.

        On a shaft it is part of `force` already.
        """
        halves = self.on_shaft is None and isinstance(self.parts, Scene) and self.parts.errors.lead_offset
        return abs(self.preload.axial) if halves and self.preload is not None else 0.0

    @property
    def life_by_loads(self) -> LifeByLoads | None:
        """Life that follows from the contact loads: L10 of a nut, L10r of a bearing; None if it is not known."""
        if self.reference_life is not None or isinstance(self.parts, RollerRow):
            return self.reference_life
        return self.life

    @property
    @QuantityDescription("sides")
    def load_of_flanks(self) -> dict[str, FlankLoadSummary] | None:
        """Summary of the contact loads on each loaded groove flank, by its name; None for rollers."""
        return None if self.loads is None else flank_load_summaries(self.loads)

    @property
    @QuantityDescription("loads")
    def load_summary(self) -> BallLoadSummary | RollerLoadSummary | None:
        """Largest, mean and smallest load of contacts or rollers; None if none is loaded."""
        if self.loads is not None:
            return ball_load_summary(self.loads, self.nominal_contacts)
        return None if self.roller_loads is None else roller_load_summary(self.roller_loads)

    @property
    @QuantityDescription("clearance")
    def clearance(self) -> one_arc.InternalClearance | None:
        """Axial and radial play of a deep-groove ball bearing; None for other nuts and bearings."""
        thrust = "deep groove" if self.on_shaft is None else self.on_shaft.of.thrust
        return clearance_of_deep_groove(self.parts, thrust) if isinstance(self.parts, Scene) else None

    @property
    @QuantityDescription("starting_torque")
    def starting_torque(self) -> PalmgrenLoadTorque | None:
        """Starting torque of a preloaded ball bearing that carries thrust in one direction; None for others."""
        if self.on_shaft is None or not isinstance(self.parts, Scene) or not (self.preload and self.preload.axial):
            return None
        one_way = self.on_shaft.of.kind == "bearing" and self.on_shaft.of.thrust in ("+z", "-z")
        return palmgren_load_torque(self.parts, self.preload.axial) if one_way else None

    def to_json(self) -> dict[str, Any]:
        """Return all quantities as JSON; empty without equilibrium.

        Returns
        -------
        dict
            JSON values by key.
        """
        if self.loads is None and self.roller_loads is None:
            return {}
        data = record_as_json(self) | (record_as_json(self.rigidities) or {"rigidities_N_per_um": None})
        return {key: data[key] for key in ("sides", "loads")} | data

    def ball_rows(self) -> Iterator[BallResult]:
        """Yield position, loads, contact angles and pressures of every ball, numbered from 1."""
        for parts, balls in self.ball_sets:
            rows = zip(
                balls.azimuth, balls.z, balls.load, balls.contact_angle, contact_pressures(parts, balls), strict=True
            )
            yield from (BallResult(i, *row) for i, row in enumerate(rows, 1))

    def roller_rows(self) -> Iterator[RollerResult]:
        """Yield position, load, largest line load and pressures of every roller, numbered from 1."""
        s = self.on_shaft
        if s is None or not isinstance(self.parts, RollerRow) or s.roller_azimuth is None or s.line_loads is None:
            return
        pressures = race_pressures(self.parts, s.line_loads)
        each = zip(s.roller_azimuth, s.loads, s.line_loads.max(axis=1), pressures, strict=True)
        for i, (azimuth, load, line_load, of_races) in enumerate(each, 1):
            yield RollerResult(i, azimuth, load, line_load, dict(zip(RACES, of_races, strict=True)))

    def __repr__(self) -> str:
        """Return name, kind and largest contact load of the nut or bearing."""
        loads = self.loads if self.loads is not None else self.roller_loads
        head = f"{self.name} ({self.kind})" if self.name else self.kind
        return f"{head}: " + ("no loads" if loads is None else f"largest load {loads.max():.5g} N")
