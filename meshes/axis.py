"""Records that describe a shaft with several ball nuts and bearings (rolling sets), in SI units.

The outer part of each rolling set (nut or outer ring) is fixed, or belongs to a housing. A housing is a rigid body; some of
its degrees of freedom may be fixed, and springs may connect it to the frame or to another housing.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from rollbench.meshes import parts as parts_records
from rollbench.meshes.parts import FREEDOMS, Friction, Ingredients, Load, Lubricant, Material, Motion, Scene, Screw, Support
from rollbench.meshes.ranges import Bore, ContactAngle, Density, Duration, Efficiency, Inertia, Mass, Size, Station, Torque
from rollbench.meshes.record_keys import frozen_default, register_frozen_defaults, scene_key_metadata

#: A symmetric 6x6 stiffness matrix as nested tuples; rows and columns are in the order of FREEDOMS [N/m, N, N m].
Stiffness = tuple[tuple[float, ...], ...]
#: Direction of the thrust on the shaft that a rolling set can carry. A gothic arch, or two rows, carry both directions; one
#: row of an angular contact bearing carries one. The single arc of a deep groove carries both directions, and its contact
#: angle changes sign.
Thrust = Literal["both", "+z", "-z", "deep groove"]


#: Arrangements of equal bearings by their names: direction of the thrust on the shaft that each row carries, from left to
#: right. B: back to back, F: face to face, T: tandem. In names of three letters, the third one adds rows next to the second
#: row, which carry the same thrust as the second: one (D, B, F) or two (T); with B and F the first row is doubled too.
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


@register_frozen_defaults
@dataclass(frozen=True)
class Segment:
    """A cylindrical segment of the shaft without groove.

    Axial positions, diameter and bore are in metres.
    """

    start: Station = field(metadata=scene_key_metadata("axial position at which the segment begins", "0 mm"))
    end: Station = field(metadata=scene_key_metadata("axial position at which the segment ends", "60 mm"))
    diameter: Size = field(metadata=scene_key_metadata("diameter of the segment", "25 mm"))
    bore: Bore = frozen_default(0.0, "diameter of the segment's bore", "6 mm")


@register_frozen_defaults
@dataclass(frozen=True)
class Housing:
    """Rigid housing that carries nuts or outer rings; its motion is described at a reference point on the shaft's axis."""

    #: Name of the housing, to which rolling sets, joints and results refer.
    name: str
    #: Axial position z of the housing's reference point [m].
    at: float
    #: Pairs of a degree of freedom (of `FREEDOMS`) and its prescribed displacement [m] or rotation [rad].
    fixed: tuple[tuple[str, float], ...] = frozen_default(())
    #: Stiffness of the springs between housing and frame, at the reference point; None without springs.
    stiffness: Stiffness | None = frozen_default(None)
    #: Force on the housing at the reference point [N].
    force: tuple[float, float, float] = frozen_default((0.0, 0.0, 0.0))
    #: Moment on the housing [N m].
    moment: tuple[float, float, float] = frozen_default((0.0, 0.0, 0.0))

    @property
    def is_fixed(self) -> bool:
        """Whether all degrees of freedom of the housing are fixed at zero."""
        return {name for name, value in self.fixed if value == 0.0} == set(FREEDOMS)


@dataclass(frozen=True)
class Joint:
    """Springs between two housings, as a stiffness matrix at one position on the shaft's axis."""

    #: Name of the first of the two housings.
    first: str
    #: Name of the second of the two housings.
    second: str
    #: Axial position on the shaft's axis at which the springs act [m].
    at: float
    #: Stiffness matrix ``(6, 6)`` for the motion of the second housing relative to the first one at this position.
    stiffness: Stiffness


@register_frozen_defaults
@dataclass(frozen=True)
class RollerRow:
    """One row of tapered rollers with its rings: dimensions, material, and data for friction at the rib."""

    #: Number of rollers.
    count: int
    #: Mean diameter of a roller [m].
    diameter: Size
    #: Effective length of a roller [m].
    length: Size
    #: Half included angle of the raceway of the cup (outer ring) [rad].
    cup_angle: ContactAngle
    #: Half included angle of a roller [rad].
    roller_angle: ContactAngle
    #: Depth below the raceways of both rings down to which their deformation is considered [m].
    depth: Size
    #: Elastic material of rollers and rings.
    material: Material
    #: Radius of the crowning of the contact lines with both raceways [m]; infinite for straight rollers.
    crown: float = frozen_default(float("inf"))
    #: Number of slices into which a roller is divided for computing its contact forces.
    slices: int = frozen_default(15)
    #: Azimuth of the first roller [rad].
    phase: float = frozen_default(0.0)
    #: Radius of the spherical large end of a roller [m]; None where unknown.
    end_radius: Size | None = frozen_default(None)
    #: Height of the contact with the rib above the raceway of the cone (inner ring) [m]; None: a tenth of the roller
    #: diameter.
    rib_height: Size | None = frozen_default(None)
    #: Coefficient of friction between the large end of a roller and the rib; None: 0.1.
    rib_friction: float | None = frozen_default(None)
    #: Manufacturer's factor G_1 of Timken's formula for the friction torque; None where unknown.
    torque_factor: float | None = frozen_default(None)
    #: Radius of the rounded edges at both ends of the contact line [m]; None for sharp edges.
    edge_radius: Size | None = frozen_default(None)
    #: Load ratings by the maker.
    rating: parts_records.MakerRating = frozen_default(parts_records.MakerRating())


@register_frozen_defaults
@dataclass(frozen=True)
class RollingSet:
    """Rolling set: one ball nut, ball bearing or row of tapered rollers on the shaft, and how it is mounted."""

    #: Name of the rolling set, to which results refer.
    name: str
    #: Type of the rolling set.
    kind: Literal["ball nut", "bearing", "tapered roller bearing"]
    #: For balls, a scene without supports and loads: track, grooves, balls and errors; its screw is the shaft with this
    #: rolling set's inner groove. For tapered rollers, the row of rollers.
    parts: Scene | RollerRow
    #: Axial position of the centre of the outer part, or of the middle of the contact lines on the cup [m].
    position: float
    #: Name of the housing of the outer part; None where the outer part is fixed.
    housing: str | None = frozen_default(None)
    #: Displacement of the outer part along +z relative to its housing, fixed at mounting [m].
    offset: float = frozen_default(0.0)
    #: Axial preload [N]: at mounting, without external loads, the outer part is displaced until the rolling set carries
    #: this axial force, and is then fixed to its housing; 0 for no preload.
    preload: float = frozen_default(0.0)
    #: Direction of the axial force on the shaft that the rolling set can carry.
    thrust: Thrust = frozen_default("both")
    #: Name of the housing on which the inner part sits, as the inner ring of a bearing around a nut does; None: it sits on
    #: the shaft.
    carrier: str | None = frozen_default(None)
    #: Friction torque of the seals or wipers [N m].
    seals: float = frozen_default(0.0)


@register_frozen_defaults
@dataclass(frozen=True)
class Drive:
    """Data of a machine axis for motor torque and moment of inertia: moved mass, motor, friction and acceleration."""

    mass: Mass = frozen_default(0.0, "mass that the nut moves along the shaft", "200 kg")
    motor_inertia: Inertia = frozen_default(0.0, "moment of inertia of motor and coupling", "20 kg cm2")
    time: Duration | None = frozen_default(
        None, "time of the uniform acceleration from rest to the speed in [motion]", "100 ms"
    )
    efficiency: Efficiency | None = frozen_default(
        None, "efficiency of the ball screw during acceleration; 0.90 to 0.95 if left out (Smith 4.3.1)", 0.92
    )
    torque: Torque = frozen_default(0.0, "friction torque of all other parts: guides, motor, coupling", "0.5 N m")
    density: Density = frozen_default(7850.0, "density of the shaft", "7850 kg/m3")


@register_frozen_defaults
@dataclass(frozen=True)
class Assembly:
    """One load case of a shaft with several ball nuts and bearings, in SI units."""

    #: Name of the scene.
    name: str
    #: Title of the scene, for reports.
    title: str
    #: Dimensions and material of the shaft.
    screw: Screw
    #: Ball nuts and bearings on the shaft.
    sets: tuple[RollingSet, ...]
    #: Segments of the shaft without groove.
    segments: tuple[Segment, ...] = frozen_default(())
    #: Rigid housings that carry nuts or outer rings.
    housings: tuple[Housing, ...] = frozen_default(())
    #: Springs between pairs of housings.
    joints: tuple[Joint, ...] = frozen_default(())
    #: Supports of the shaft.
    supports: tuple[Support, ...] = frozen_default(())
    #: Loads on the shaft.
    loads: tuple[Load, ...] = frozen_default(())
    #: Options of the low-order models.
    ingredients: Ingredients = frozen_default(Ingredients())
    #: Publication from which the scene is taken.
    source: str = frozen_default("")
    #: Assumptions on data that the publication `source` does not give, as sentences.
    assumed: tuple[str, ...] = frozen_default(())
    #: Coulomb friction of the balls; None: no friction.
    friction: Friction | None = frozen_default(None)
    #: Rotating part and its angular speed.
    motion: Motion | None = frozen_default(None)
    #: Oil, or base oil of the grease.
    lubricant: Lubricant | None = frozen_default(None)
    #: Axial position [m], or name of the housing, at which the tangent stiffness is computed; None: where the loads act.
    stiffness_at: float | str | None = frozen_default(None)
    #: Thermal strain of the unconstrained shaft, uniform along it.
    thermal_strain: float = frozen_default(0.0)
    #: What the motor drives in addition to the shaft: moved mass, inertia, friction torque, and time of acceleration.
    drive: Drive = frozen_default(Drive())
    #: Kind of the scene, as its file names it.
    kind: ClassVar[str] = "axis"

    def to_toml(self) -> str:
        """Return the shaft with its ball nuts and bearings as the text of a TOML scene file."""
        from rollbench.meshes.scene_text import scene_file_tables_of_shaft, toml_of_tables

        return toml_of_tables(scene_file_tables_of_shaft(self))

    @property
    def ball_count(self) -> int:
        """Number of balls of all ball nuts and ball bearings on the shaft together."""
        return sum(s.parts.ball_count for s in self.sets if isinstance(s.parts, Scene))


def diagonal_stiffness(values: tuple[float, float, float, float, float, float]) -> Stiffness:
    """Return the stiffness matrix of six uncoupled springs, one for each degree of freedom.

    Parameters
    ----------
    values : tuple[float, float, float, float, float, float]
        Stiffnesses in the order ux, uy, uz, rx, ry, rz (`FREEDOMS`): three in N/m, three in N m/rad.

    Returns
    -------
    (6, 6) tuple
        Diagonal stiffness matrix.

    Raises
    ------
    ValueError
        A stiffness is negative.

    Examples
    --------
    >>> diagonal_stiffness((1.0, 1.0, 2.0, 0.0, 0.0, 0.0))[2]
    (0.0, 0.0, 2.0, 0.0, 0.0, 0.0)
    """
    return checked_stiffness(np.diag(np.asarray(values)))


def checked_stiffness(matrix: NDArray[np.float64]) -> Stiffness:
    """Check that a stiffness matrix is symmetric and positive semidefinite, and convert it to nested tuples.

    Parameters
    ----------
    matrix : (6, 6) array
        Stiffness matrix [N/m, N, N m]; rows and columns in the order ux, uy, uz, rx, ry, rz (`FREEDOMS`).

    Returns
    -------
    (6, 6) tuple
        The same numbers, row by row.

    Raises
    ------
    ValueError
        The matrix is not symmetric (to 1e-9), or has a negative eigenvalue.
    """
    if matrix.shape != (6, 6) or not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0.0):
        raise ValueError("a stiffness must be a symmetric matrix with six rows and six columns")
    scale = np.sqrt(np.where(np.diag(matrix) > 0.0, np.diag(matrix), 1.0))
    if float(np.linalg.eigvalsh(matrix / scale[:, None] / scale[None, :]).min()) < -1e-9:
        raise ValueError("a stiffness must not be negative in any direction: the matrix has a negative eigenvalue")
    return tuple(tuple(float(x) for x in row) for row in matrix)
