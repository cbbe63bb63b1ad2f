"""Several rolling sets on one shaft: plain records in SI units.

A shaft in its supports carries ball nuts and bearings. The outer part of each (nut, outer ring) is held, or belongs to a
housing: a rigid body that is held in some freedoms, stands on springs, or is joined to another housing by springs.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from rollbench.meshes.fields import about, keyed, usual
from rollbench.meshes.parts import FREEDOMS, Friction, Ingredients, Load, Lubricant, Material, Motion, Scene, Screw, Support
from rollbench.meshes.ranges import Bore, ContactAngle, Density, Duration, Efficiency, Inertia, Mass, Size, Station, Torque

#: A symmetric stiffness (6, 6), rows by FREEDOMS [N/m, N, N m].
Stiffness = tuple[tuple[float, ...], ...]
#: Direction of the thrust on the shaft that a set can carry: a gothic arch or a row each for both, one row of an
#: angular-contact bearing for one; the one arc of a deep groove carries both and turns its contact angle.
Thrust = Literal["both", "+z", "-z", "deep groove"]


#: Rows of a set of equal bearings from left to right, by its name: the thrust on the shaft that each carries. B: back to
#: back, F: face to face, T: tandem; a third letter adds one row (D), a pair (B, F), or two rows (T) beside the second.
ARRANGEMENTS: dict[str, tuple[Literal["+z", "-z"], ...]] = {
    "DB": ("-z", "+z"),
    "DF": ("+z", "-z"),
    "DT": ("+z", "+z"),
    "DBD": ("-z", "+z", "+z"),
    "DFD": ("+z", "-z", "-z"),
    "DBB": ("-z", "-z", "+z", "+z"),
    "DFF": ("+z", "+z", "-z", "-z"),
    "DBT": ("-z", "+z", "+z", "+z"),
    "DFT": ("+z", "-z", "-z", "-z"),
}


@keyed
@dataclass(frozen=True)
class Segment:
    """A plain stretch of the shaft.

    Stations, diameter and bore [m].
    """

    start: Station = field(metadata=about("station where it begins", "0 mm"))
    end: Station = field(metadata=about("station where it ends", "60 mm"))
    diameter: Size = field(metadata=about("its diameter", "25 mm"))
    bore: Bore = usual(0.0, "diameter of its hole", "6 mm")


@keyed
@dataclass(frozen=True)
class Housing:
    """Rigid body that carries nuts or outer rings; its motion is taken at station ``at`` [m] on the shaft's axis.

    fixed: pairs (freedom, displacement [m] or rotation [rad]); stiffness: of its springs to the frame at ``at``, or None;
    force [N] and moment [N m] on it, there.
    """

    name: str
    at: float
    fixed: tuple[tuple[str, float], ...] = usual(())
    stiffness: Stiffness | None = usual(None)
    force: tuple[float, float, float] = usual((0.0, 0.0, 0.0))
    moment: tuple[float, float, float] = usual((0.0, 0.0, 0.0))

    @property
    def stands(self) -> bool:
        """Whether it cannot move at all."""
        return {name for name, value in self.fixed if value == 0.0} == set(FREEDOMS)


@dataclass(frozen=True)
class Joint:
    """Springs between two housings, by name, at station ``at`` [m] on the axis."""

    first: str
    second: str
    at: float
    stiffness: Stiffness


@keyed
@dataclass(frozen=True)
class RollerRow:
    """One row of tapered rollers, every cone of it with its apex on the axis: number, mean diameter and effective length of
    a roller [m], half included angles of cup and roller [rad], depth of both rings to which deformation counts [m],
    material; crown: radius of the crowning at both contacts [m], infinite for straight rollers; slices of a roller;
    azimuth of the first one [rad]. end_radius: of the sphere of the large end [m], None where it is not known; rib_height:
    of the contact with the rib above the cone's race [m], None for the usual one; rib_friction: coefficient of friction
    there, None for the usual one; torque_factor: the maker's G_1 of Timken's formula, None where it is not known."""

    count: int
    diameter: Size
    length: Size
    cup_angle: ContactAngle
    roller_angle: ContactAngle
    depth: Size
    material: Material
    crown: float = usual(float("inf"))
    slices: int = usual(15)
    phase: float = usual(0.0)
    end_radius: Size | None = usual(None)
    rib_height: Size | None = usual(None)
    rib_friction: float | None = usual(None)
    torque_factor: float | None = usual(None)


@keyed
@dataclass(frozen=True)
class RollingSet:
    """One set on the shaft. parts: its track, grooves, balls and errors as a scene without supports and loads whose screw
    is the shaft with this set's inner groove, or a row of rollers; ``position``: station of the outer part's centre, of the
    middle of the cup's contact lines [m].

    housing: the name of the housing of its outer part, None where that is held; offset: shift of the outer part along
    +z against its housing [m]; preload: axial force [N] that is set by such a shift at mounting, without external loads,
    and then locked (0: none); thrust: which thrust on the shaft the set carries; carrier: the name of the housing that its
    inner part belongs to, as the bearing around a nut does, None for the shaft; seals: friction torque of its seals or
    wipers as given [N m].
    """

    name: str
    kind: Literal["ball nut", "bearing", "tapered roller bearing"]
    parts: Scene | RollerRow
    position: float
    housing: str | None = usual(None)
    offset: float = usual(0.0)
    preload: float = usual(0.0)
    thrust: Thrust = usual("both")
    carrier: str | None = usual(None)
    seals: float = usual(0.0)


@keyed
@dataclass(frozen=True)
class Drive:
    """What the motor of a shaft moves besides it, for the torque and the inertia of the axis.

    Mass [kg], inertia [kg m^2], time [s], torque [N m], density [kg/m^3].
    """

    mass: Mass = usual(0.0, "mass that the nut moves along the shaft", "200 kg")
    motor_inertia: Inertia = usual(0.0, "moment of inertia of motor and coupling", "20 kg cm2")
    time: Duration | None = usual(None, "time in which it comes evenly from rest to the speed of [motion]", "100 ms")
    efficiency: Efficiency | None = usual(
        None, "efficiency of the nut while it accelerates the mass; 0.90 to 0.95 if left out (Smith 4.3.1)", 0.92
    )
    torque: Torque = usual(0.0, "friction torque of all else, as given: guides, motor, coupling", "0.5 N m")
    density: Density = usual(7850.0, "density of the shaft", "7850 kg/m3")


@keyed
@dataclass(frozen=True)
class Assembly:
    """One load case of a shaft with its rolling sets. screw: the shaft; segments: its plain stretches.

    stiffness_at: station [m], or name of the housing, whose tangent stiffness is asked for (None: where the loads act);
    thermal_strain: of the free shaft, the same along all of it.
    """

    name: str
    title: str
    screw: Screw
    sets: tuple[RollingSet, ...]
    segments: tuple[Segment, ...] = usual(())
    housings: tuple[Housing, ...] = usual(())
    joints: tuple[Joint, ...] = usual(())
    supports: tuple[Support, ...] = usual(())
    loads: tuple[Load, ...] = usual(())
    ingredients: Ingredients = usual(Ingredients())
    source: str = usual("")
    assumed: tuple[str, ...] = usual(())
    friction: Friction | None = usual(None)
    motion: Motion | None = usual(None)
    lubricant: Lubricant | None = usual(None)
    stiffness_at: float | str | None = usual(None)
    thermal_strain: float = usual(0.0)
    drive: Drive = usual(Drive())
    kind: ClassVar[str] = "axis"

    def to_toml(self) -> str:
        """Text of a scene file that is read as this shaft with its sets."""
        from rollbench.meshes.scene_text import axis_tables, to_toml

        return to_toml(axis_tables(self))

    @property
    def ball_count(self) -> int:
        """Number of balls of all sets."""
        return sum(s.parts.ball_count for s in self.sets if isinstance(s.parts, Scene))


def diagonal(values: tuple[float, float, float, float, float, float]) -> Stiffness:
    """Stiffness of six springs that do not feel one another."""
    return full(np.diag(np.asarray(values)))


def full(matrix: NDArray[np.float64]) -> Stiffness:
    """A matrix (6, 6) as a record. Raises ValueError unless it is symmetric and has no negative eigenvalue."""
    if matrix.shape != (6, 6) or not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0.0):
        raise ValueError("a stiffness is a symmetric matrix of six rows")
    scale = np.sqrt(np.where(np.diag(matrix) > 0.0, np.diag(matrix), 1.0))
    if float(np.linalg.eigvalsh(matrix / scale[:, None] / scale[None, :]).min()) < -1e-9:
        raise ValueError("a stiffness must not be negative in any direction")
    return tuple(tuple(float(x) for x in row) for row in matrix)
