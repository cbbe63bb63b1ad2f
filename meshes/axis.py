"""Several rolling sets on one shaft: plain records in SI units.

A shaft on its supports carries ball nuts and bearings. The outer part of each (nut, outer ring) is fixed, or belongs to a
housing: a rigid body with some freedoms fixed, on springs, or joined to another housing by springs.
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
#: back, F: face to face, T: tandem; a third letter adds one row (D), a pair (B, F), or two rows (T) next to the second.
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
    """Rigid body that carries nuts or outer rings; its motion is that of its point on the shaft's axis."""

    #: Name, by which sets, joints and results refer to it.
    name: str
    #: Station of its reference point [m].
    at: float
    #: Pairs of a freedom (of `FREEDOMS`) and its prescribed displacement [m] or rotation [rad].
    fixed: tuple[tuple[str, float], ...] = usual(())
    #: Stiffness of its springs to the frame, at the reference point; None without springs.
    stiffness: Stiffness | None = usual(None)
    #: Force on it [N], at the reference point.
    force: tuple[float, float, float] = usual((0.0, 0.0, 0.0))
    #: Moment on it [N m].
    moment: tuple[float, float, float] = usual((0.0, 0.0, 0.0))

    @property
    def stands(self) -> bool:
        """Whether all freedoms of the housing are fixed at zero."""
        return {name for name, value in self.fixed if value == 0.0} == set(FREEDOMS)


@dataclass(frozen=True)
class Joint:
    """Springs between two housings."""

    #: Name of one housing.
    first: str
    #: Name of the other housing.
    second: str
    #: Station on the axis at which the springs act [m].
    at: float
    #: Stiffness against their relative motion there.
    stiffness: Stiffness


@keyed
@dataclass(frozen=True)
class RollerRow:
    """One row of tapered rollers; the cones of race and rollers have their apexes on the axis."""

    #: Number of rollers.
    count: int
    #: Mean diameter of a roller [m].
    diameter: Size
    #: Effective length of a roller [m].
    length: Size
    #: Half included angle of the cup [rad].
    cup_angle: ContactAngle
    #: Half included angle of a roller [rad].
    roller_angle: ContactAngle
    #: Depth of both rings to which deformation counts [m].
    depth: Size
    #: Elastic material of rollers and rings.
    material: Material
    #: Radius of the crowning at both contacts [m]; infinite for straight rollers.
    crown: float = usual(float("inf"))
    #: Slices into which a roller is divided.
    slices: int = usual(15)
    #: Azimuth of the first roller [rad].
    phase: float = usual(0.0)
    #: Radius of the spherical large end [m]; None where unknown.
    end_radius: Size | None = usual(None)
    #: Height of the rib contact above the cone's race [m]; None for the usual one.
    rib_height: Size | None = usual(None)
    #: Coefficient of friction at the rib; None for the usual one.
    rib_friction: float | None = usual(None)
    #: The maker's G_1 of Timken's torque formula; None where unknown.
    torque_factor: float | None = usual(None)
    #: Radius of the rounding at both ends of the contact line [m]; None for sharp ends.
    edge_radius: Size | None = usual(None)


@keyed
@dataclass(frozen=True)
class RollingSet:
    """One ball nut or bearing on the shaft."""

    #: Name, by which results refer to it.
    name: str
    #: Kind of rolling set.
    kind: Literal["ball nut", "bearing", "tapered roller bearing"]
    #: Track, grooves, balls and errors as a scene without supports and loads, whose screw is the shaft with this set's
    #: inner groove; or a row of rollers.
    parts: Scene | RollerRow
    #: Station of the centre of the outer part, or of the middle of the cup's contact lines [m].
    position: float
    #: Name of the housing of the outer part; None where that is fixed.
    housing: str | None = usual(None)
    #: Shift of the outer part along +z against its housing [m].
    offset: float = usual(0.0)
    #: Axial force [N] that such a shift sets at mounting, without external loads, before it is locked; 0: none.
    preload: float = usual(0.0)
    #: Thrust on the shaft that the set can carry.
    thrust: Thrust = usual("both")
    #: Name of the housing that the inner part belongs to, as of a bearing around a nut; None for the shaft.
    carrier: str | None = usual(None)
    #: Friction torque of its seals or wipers, as given [N m].
    seals: float = usual(0.0)


@keyed
@dataclass(frozen=True)
class Drive:
    """Parts driven by the motor in addition to the shaft, for torque and inertia of the axis."""

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
    """One load case of a shaft with its rolling sets."""

    #: Name of the scene.
    name: str
    #: Title of the scene.
    title: str
    #: The shaft.
    screw: Screw
    #: Ball nuts and bearings on it.
    sets: tuple[RollingSet, ...]
    #: Plain stretches of the shaft.
    segments: tuple[Segment, ...] = usual(())
    #: Rigid bodies that carry outer parts.
    housings: tuple[Housing, ...] = usual(())
    #: Springs between housings.
    joints: tuple[Joint, ...] = usual(())
    #: Supports of the shaft.
    supports: tuple[Support, ...] = usual(())
    #: Loads on the shaft.
    loads: tuple[Load, ...] = usual(())
    #: Parts of the low-order model that are used.
    ingredients: Ingredients = usual(Ingredients())
    #: Where the case comes from.
    source: str = usual("")
    #: Statements about what the source leaves open.
    assumed: tuple[str, ...] = usual(())
    #: Coulomb friction of the balls.
    friction: Friction | None = usual(None)
    #: Which part turns, and how fast.
    motion: Motion | None = usual(None)
    #: Oil or base oil.
    lubricant: Lubricant | None = usual(None)
    #: Station [m] or name of the housing whose tangent stiffness is asked for; None: where the loads act.
    stiffness_at: float | str | None = usual(None)
    #: Thermal strain of the free shaft, the same all along it.
    thermal_strain: float = usual(0.0)
    #: Parts that the motor moves in addition to the shaft.
    drive: Drive = usual(Drive())
    kind: ClassVar[str] = "axis"

    def to_toml(self) -> str:
        """Text of a scene file that reads back as this shaft with its sets."""
        from rollbench.meshes.scene_text import axis_tables, to_toml

        return to_toml(axis_tables(self))

    @property
    def ball_count(self) -> int:
        """Number of balls of all sets."""
        return sum(s.parts.ball_count for s in self.sets if isinstance(s.parts, Scene))


def diagonal_stiffness(values: tuple[float, float, float, float, float, float]) -> Stiffness:
    """Stiffness of six uncoupled springs.

    Parameters
    ----------
    values : tuple[float, float, float, float, float, float]
        Stiffness by `FREEDOMS`: three [N/m], three [N m/rad].

    Returns
    -------
    (6, 6) tuple
        Diagonal stiffness.

    Raises
    ------
    ValueError
        As `full`.

    Examples
    --------
    >>> diagonal_stiffness((1.0, 1.0, 2.0, 0.0, 0.0, 0.0))[2]
    (0.0, 0.0, 2.0, 0.0, 0.0, 0.0)
    """
    return full_stiffness(np.diag(np.asarray(values)))


def full_stiffness(matrix: NDArray[np.float64]) -> Stiffness:
    """Stiffness record of a matrix.

    Parameters
    ----------
    matrix : (6, 6) array
        Rows and columns by `FREEDOMS` [N/m, N, N m].

    Returns
    -------
    (6, 6) tuple
        The same numbers.

    Raises
    ------
    ValueError
        The matrix is not symmetric (to 1e-9), or has a negative eigenvalue.
    """
    if matrix.shape != (6, 6) or not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0.0):
        raise ValueError("a stiffness is a symmetric matrix of six rows")
    scale = np.sqrt(np.where(np.diag(matrix) > 0.0, np.diag(matrix), 1.0))
    if float(np.linalg.eigvalsh(matrix / scale[:, None] / scale[None, :]).min()) < -1e-9:
        raise ValueError("a stiffness must not be negative in any direction")
    return tuple(tuple(float(x) for x in row) for row in matrix)
