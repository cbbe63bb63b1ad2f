"""Records that describe a shaft with several ball nuts and bearings (rolling sets), in SI units.

The outer part of each rolling set (nut or outer ring) is fixed, or belongs to a housing. A housing is a rigid body; some of
its degrees of freedom may be fixed, and springs may connect it to the frame or to another housing.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from rollbench.meshes import parts as parts_records
from rollbench.meshes import ranges
from rollbench.meshes.parts import FREEDOMS, Friction, Ingredients, Lubricant, Material, Motion, Scene, Screw, Support
from rollbench.meshes.record_keys import frozen_default, frozen_record, scene_key
from rollbench.meshes.scene_text import Table, fixed_keys, keys_of_record, toml_of_tables, with_unit, without_empty_values
from rollbench.meshes.stated import groove_table

#: A symmetric 6x6 stiffness matrix as nested tuples; rows and columns are in the order of FREEDOMS [N/m, N, N m].
Stiffness = tuple[tuple[float, ...], ...]
#: Direction of the thrust on the shaft that a rolling set can carry. A gothic arch, or two rows, carry both directions; one
#: row of an angular contact bearing carries one. The single arc of a deep groove carries both directions, and its contact
#: angle changes sign.
Thrust = Literal["both", "+z", "-z", "deep groove"]
#: Coefficient of thermal expansion of steel [1/K], with which a thermal strain is written as a temperature rise.
STEEL = 11.5e-6


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


@frozen_record
class Segment:
    """A cylindrical segment of the shaft without groove.

    Axial positions, diameter and bore are in metres.
    """

    start: ranges.Station = scene_key("axial position at which the segment begins", "0 mm")
    end: ranges.Station = scene_key("axial position at which the segment ends", "60 mm")
    diameter: ranges.Size = scene_key("diameter of the segment", "25 mm")
    bore: ranges.Bore = frozen_default(0.0, "diameter of the segment's bore", "6 mm")


@frozen_record
class Housing:
    """Rigid housing that carries nuts or outer rings; its motion is described at a reference point on the shaft's axis."""

    name: ranges.Name = scene_key("name of the housing", "carriage")
    at: ranges.Station = scene_key("axial position to which motion, springs and loads of the housing refer", "400 mm")
    #: Pairs of a degree of freedom (of `FREEDOMS`) and its prescribed displacement [m] or rotation [rad].
    fixed: tuple[tuple[str, float], ...] = frozen_default(())
    #: Stiffness of the springs between housing and frame, at the reference point; None without springs.
    stiffness: Stiffness | None = frozen_default(None)
    force: ranges.Forces = frozen_default((0.0, 0.0, 0.0), "force on the housing along x, y, z", ["0 N", "0 N", "5 kN"])
    moment: ranges.Moments = frozen_default(
        (0.0, 0.0, 0.0), "moment on the housing about x, y, z", ["0 N m", "3 N m", "0 N m"]
    )

    @property
    def is_fixed(self) -> bool:
        """Whether all degrees of freedom of the housing are fixed at zero."""
        return {name for name, value in self.fixed if value == 0.0} == set(FREEDOMS)

    def file_keys(self) -> Table:
        """Return the keys of the housing in a scene file."""
        return keys_of_record(self, **fixed_keys(self.fixed), **_stiffness_keys(self.stiffness))


@frozen_record
class Joint:
    """Springs between two housings, as a stiffness matrix at one position on the shaft's axis."""

    #: Name of the first of the two housings.
    first: str
    #: Name of the second of the two housings.
    second: str
    at: ranges.Station = scene_key("axial position at which the springs of the joint act", "400 mm")
    #: Stiffness matrix ``(6, 6)`` for the motion of the second housing relative to the first one at this position.
    stiffness: Stiffness

    def file_keys(self) -> Table:
        """Return the keys of the joint in a scene file."""
        return keys_of_record(self, between=[self.first, self.second], **_stiffness_keys(self.stiffness))


def _stiffness_keys(matrix: Stiffness | None) -> Table:
    """Return the key that states a 6x6 stiffness: ``springs`` for a diagonal matrix, else ``matrix``; empty for None."""
    if matrix is None:
        return {}
    if any(x for i, row in enumerate(matrix) for j, x in enumerate(row) if i != j):
        return {"matrix": [[*row] for row in matrix]}
    springs = {
        n: with_unit(ranges.Spring if n[0] == "u" else ranges.Twist, matrix[i][i])
        for i, n in enumerate(FREEDOMS)
        if matrix[i][i]
    }
    return {"springs": springs or {"ux": "0 N/m"}}


@frozen_record
class RollerRow:
    """One row of tapered rollers with its rings: dimensions, material, and data for friction at the rib."""

    count: ranges.Count = scene_key("number of rollers", 16)
    diameter: ranges.Size = scene_key("mean diameter of a roller", "8.4 mm")
    length: ranges.Size = scene_key("effective length of a roller", "12.4 mm")
    cup_angle: ranges.ContactAngle = scene_key(
        "half included angle of the cup: angle between its raceway and the axis", "30.8 deg"
    )
    roller_angle: ranges.ContactAngle = scene_key("half included angle of a roller", "4 deg")
    #: Depth below the raceways of both rings down to which their deformation is considered [m].
    depth: ranges.Size
    #: Elastic material of rollers and rings.
    material: Material
    #: Radius of the crowning of the contact lines with both raceways [m]; infinite for straight rollers.
    crown: float = frozen_default(float("inf"))
    slices: ranges.Slices = frozen_default(15, "number of slices into which a roller is divided", 15)
    #: Azimuth of the first roller [rad].
    phase: float = frozen_default(0.0)
    end_radius: ranges.Size | None = frozen_default(
        None,
        "radius of the spherical large end, for the pressure at the rib; usually 0.8 to 0.95 of its distance from the apex",
        "55 mm",
    )
    rib_height: ranges.Size | None = frozen_default(
        None, "height of the rib contact above the cone's raceway; a tenth of the roller diameter if left out", "0.8 mm"
    )
    rib_friction: ranges.Coefficient | None = frozen_default(
        None, "coefficient of friction between large end and rib; 0.1 if left out", 0.1
    )
    torque_factor: ranges.TorqueFactor | None = frozen_default(
        None, "manufacturer's factor G1 of Timken's formula for the friction torque", 40
    )
    edge_radius: ranges.Size | None = frozen_default(
        None,
        "radius of the edges at both ends of the effective length, for the roller in 3D; sharp edges if left out",
        "1 mm",
    )
    #: Load ratings by the maker.
    rating: parts_records.MakerRating = frozen_default(parts_records.MakerRating(), static=False)

    def file_keys(self) -> Table:
        """Return the keys of the table ``rollers`` of a scene file."""
        crown = {} if self.crown == float("inf") else {"crown": with_unit(ranges.Size, self.crown)}
        return keys_of_record(self, "rating", ring_depth=with_unit(ranges.Size, self.depth), **crown)


@frozen_record
class RollingSet:
    """Rolling set: one ball nut, ball bearing or row of tapered rollers on the shaft, and how it is mounted."""

    name: ranges.Name = scene_key("name of the nut or bearing in results", "nut 1", static=False)
    #: Type of the rolling set.
    kind: Literal["ball nut", "bearing", "tapered roller bearing"]
    #: For balls, a scene without supports and loads: track, grooves, balls and errors; its screw is the shaft with this
    #: rolling set's inner groove. For tapered rollers, the row of rollers.
    parts: Scene | RollerRow
    #: Axial position of the centre of the outer part, or of the middle of the contact lines on the cup [m].
    position: float
    housing: ranges.Name | None = frozen_default(
        None, "name of the housing that holds the nut or outer ring; if left out, the nut or ring is fixed", "carriage"
    )
    offset: ranges.Deviation = frozen_default(
        0.0, "shift of nut or outer ring relative to its housing, along z (spacer, lead offset)", "4 um"
    )
    #: Axial preload [N]: at mounting, without external loads, the outer part is displaced until the rolling set carries
    #: this axial force, and is then fixed to its housing; 0 for no preload.
    preload: float = frozen_default(0.0)
    #: Direction of the axial force on the shaft that the rolling set can carry.
    thrust: Thrust = frozen_default("both")
    carrier: ranges.Name | None = frozen_default(
        None, "name of the housing on which its inner ring sits; the shaft if left out", "nut"
    )
    seals: ranges.Torque = frozen_default(
        0.0, "friction torque of the seals or wipers as in catalogues; for an arrangement, of each row", "100 N mm"
    )

    def file_keys(self, shaft: Screw, shared: Material) -> Table:
        """Return the keys of the rolling set in a scene file.

        Its inner ring (table ``screw``) is written only if its groove, diameter or material differs from that of the shaft.

        Parameters
        ----------
        shaft : Screw
            Shaft on which it sits.
        shared : Material
            Material at the head of the scene file; parts of this material get no key for it.

        Returns
        -------
        Table
            Keys and their values, with units.
        """
        parts, rollers = self.parts, isinstance(self.parts, RollerRow)
        bearing = isinstance(parts, Scene) and parts.track.lead == 0.0
        table = keys_of_record(
            self,
            kind=self.kind,
            thrust=self.thrust if bearing or self.thrust != "both" else "",
            preload=with_unit(ranges.Force, self.preload) if self.preload else "",
            position=with_unit(ranges.Size, self.position) if rollers else "",
            rating=keys_of_record(parts.rating),
        )
        if isinstance(parts, RollerRow):
            return table | {"rollers": parts.file_keys()}
        inner, ring = {}, parts.screw
        if ring != shaft:
            inner = groove_table(ring.groove_radius, parts.balls.radius) | ring.material.file_keys(shaft.material)
            if ring.outer_diameter != shaft.outer_diameter:
                inner["outer_diameter"] = with_unit(ranges.Size, ring.outer_diameter)
        return table | without_empty_values(
            track=parts.track_table(by_thrust=True),
            screw=inner,
            nut=parts.nut.file_keys(parts.balls.radius, parts.solid.nut_held, shared),
            balls=parts.balls.file_keys(parts.track, shared),
            errors={"seed": parts.errors.seed} | parts.errors.file_keys(),
        )


@frozen_record
class Drive:
    """Data of a machine axis for motor torque and moment of inertia: moved mass, motor, friction and acceleration."""

    mass: ranges.Mass = frozen_default(0.0, "mass that the nut moves along the shaft", "200 kg")
    motor_inertia: ranges.Inertia = frozen_default(0.0, "moment of inertia of motor and coupling", "20 kg cm2")
    time: ranges.Duration | None = frozen_default(
        None, "time of the uniform acceleration from rest to the speed in [motion]", "100 ms"
    )
    efficiency: ranges.Efficiency | None = frozen_default(
        None, "efficiency of the ball screw during acceleration; 0.90 to 0.95 if left out (Smith 4.3.1)", 0.92
    )
    torque: ranges.Torque = frozen_default(0.0, "friction torque of all other parts: guides, motor, coupling", "0.5 N m")
    density: ranges.Density = frozen_default(7850.0, "density of the shaft", "7850 kg/m3")


@frozen_record
class Assembly:
    """One load case of a shaft with several ball nuts and bearings, in SI units."""

    #: Name of the scene.
    name: str = scene_key(static=False)
    title: ranges.Sentence = scene_key(parts_records.TITLE, "Screw under 5 kN", static=False)
    screw: Screw = scene_key("screw shaft")
    sets: tuple[RollingSet, ...] = scene_key("ball nuts and bearings, in any order")
    #: Segments of the shaft without groove.
    segments: tuple[Segment, ...] = frozen_default(())
    housings: tuple[Housing, ...] = frozen_default((), "housings that move", [{"name": "carriage", "at": "400 mm"}])
    joints: tuple[Joint, ...] = frozen_default((), "springs between housings", [{"between": ["a", "b"], "at": "400 mm"}])
    supports: tuple[Support, ...] = frozen_default(
        (), "supports of the shaft other than bearings", [{"at": "0 mm", "fix": ["rz"]}]
    )
    loads: parts_records.Loads = frozen_default((), "loads on the shaft", parts_records.LOADED)
    ingredients: Ingredients = frozen_default(Ingredients(), "options of the low-order models", {"section": "full"})
    source: ranges.Words = frozen_default("", parts_records.SOURCE, "Lin 2019, 2.4.1.1", static=False)
    assumed: ranges.Sentences = frozen_default((), parts_records.ASSUMED, ["The nut is rigid."], static=False)
    friction: Friction | None = frozen_default(None, "friction of balls and grooves", {"coefficient": 0.1}, static=False)
    motion: Motion | None = frozen_default(
        None, "part that rotates, and its angular speed", {"speed": "600 rpm"}, static=False
    )
    lubricant: Lubricant | None = frozen_default(
        None, "lubricant, for torques that depend on speed", {"viscosity": "27 mm2/s"}, static=False
    )
    #: Axial position [m], or name of the housing, at which the tangent stiffness is computed; None: where the loads act.
    stiffness_at: float | str | None = frozen_default(None, static=False)
    #: Thermal strain of the unconstrained shaft, uniform along it.
    thermal_strain: float = frozen_default(0.0)
    drive: Drive = frozen_default(
        Drive(),
        "what the motor drives in addition to the shaft: moved mass, inertia, friction torque, and time of acceleration",
        {"mass": "200 kg"},
    )
    #: Kind of the scene, as its file names it.
    kind: ClassVar[str] = "axis"

    def to_toml(self) -> str:
        """Return the shaft with its ball nuts and bearings as the text of a TOML scene file."""
        return toml_of_tables(self.file_tables())

    def file_tables(self) -> Table:
        """Return the keys and tables of the scene's file, without keys that have their default values."""
        shared = next((s.parts.material for s in self.sets if isinstance(s.parts, RollerRow)), self.screw.material)
        shaft = keys_of_record(self.screw) | self.screw.material.file_keys(shared)
        if self.screw.groove_radius:
            shaft["groove_radius"] = with_unit(ranges.Size, self.screw.groove_radius)
        at, strain = self.stiffness_at, self.thermal_strain
        expansion = STEEL if strain / STEEL == round(strain / STEEL, 9) else abs(strain)
        ask = {"housing": at} if isinstance(at, str) else {} if at is None else {"at": with_unit(ranges.Size, at)}
        tables = keys_of_record(
            self,
            kind="axis",
            **shared.file_keys(None),
            screw=shaft | without_empty_values(plain=[*map(keys_of_record, self.segments)]),
            sets=[one.file_keys(self.screw, shared) for one in self.sets],
            housings=[housing.file_keys() for housing in self.housings],
            joints=[joint.file_keys() for joint in self.joints],
            supports=[support.file_keys() for support in self.supports],
            ingredients=keys_of_record(self.ingredients, "screw", "element_length", "arm"),
            friction={} if self.friction is None else self.friction.file_keys(),
            stiffness=ask,
            heat={"warming": f"{strain / expansion:.12g} K", "expansion": expansion} if strain else {},
        )
        return parts_records.with_first_keys_first(tables)

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
