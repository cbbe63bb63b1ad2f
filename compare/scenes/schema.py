"""Keys of scene files, with descriptions, units, ranges and defaults.

A scene file describes one screw or bearing, or several nuts and bearing rows on one shaft (``[[sets]]``). Values are
converted to SI units.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from rollbench.compare.scenes import keys
from rollbench.meshes import axis, parts, ranges
from rollbench.meshes.ranges import ForceOrRatingShareRange, QuantityRange, ShareOfLoadRating
from rollbench.meshes.record_keys import scene_key

#: Ball diameter [m].
BallDiameter = Annotated[float, QuantityRange("length", "0.02 mm", "2 m", "5.556 mm")]

#: Number of turns without balls between two circuits.
Gap = Annotated[float, QuantityRange("number", 0, 1000, 0.5)]

#: Preload as a force [N], or as a fraction of the dynamic load rating.
Preload = Annotated[
    float | ShareOfLoadRating, ForceOrRatingShareRange("force", "0 N", "10 MN", "500 N", lower_limit_excluded=True)
]

#: Share of a load case in all revolutions.
Share = Annotated[float, QuantityRange("number", 0, 1, 0.5)]

#: Duration of a load case [s].
CaseTime = Annotated[float, QuantityRange("time", "0 s", "1000000000 s", "2 s")]


class ClearanceKeys(keys.SceneFileTable):
    """Internal clearance of a bearing, as in data sheets: total free travel of one ring relative to the other."""

    radial: ranges.RadialClearance | None = scene_key("radial clearance; negative for a press fit", "13 um", default=None)
    axial: ranges.Clearance | None = scene_key("axial clearance (instead of radial)", "96 um", default=None)


class TrackKeys(keys.RadiusOrDiameter, parts.Track):
    """Nominal path of the ball centres: a helix, or a circle for a bearing."""

    NAMES = "pitch_radius", "pitch_diameter"
    pitch_diameter: ranges.Size | None = scene_key(
        "diameter of the helix of the ball centres (or pitch_radius)", "33 mm", default=None
    )
    contact_angle: ranges.TrackAngle | None  # type: ignore[assignment]
    clearance: ClearanceKeys | None = scene_key(
        "clearance of a bearing with single-arc grooves (deep groove, or a row with thrust), instead of contact_angle",
        {"radial": "13 um"},
        default=None,
    )


class ScrewKeys(keys.GrooveKeys, keys.PartMaterialKeys, parts.Screw):
    """Screw shaft, or inner ring of a bearing."""


class FlangeKeys(keys.SceneFileTable, parts.Flange):
    """Flange at one end of a nut; the length of the nut includes the flange."""


class NutFixingKeys(keys.SceneFileTable):
    """Surface at which a nut or outer ring is fixed."""

    at: parts.NutHeld | None = scene_key(
        "surface at which the nut or outer ring is fixed; if left out: the flange's face towards the rest of the nut, else "
        "the left face, for a bearing the outer surface (low-order models fix a whole face, except that of a flange)",
        "left face",
        default=None,
    )
    inner_diameter: ranges.Size | None = scene_key(
        "inner diameter of the fixed annulus on the flange; the nut's outer diameter if left out", "50 mm", default=None
    )
    outer_diameter: ranges.Size | None = scene_key(
        "outer diameter of the fixed annulus on the flange; that of the flange if left out", "66 mm", default=None
    )
    centring: Literal["free", "bonded"] = scene_key(
        "whether the nut is free at the centring fit of its flange, or fixed there too", "bonded", default="free"
    )
    bolts: Annotated[int, ranges.Plain("int", 0, 100)] = scene_key(
        "number of bolts of the flange; the 3D reference fixes a circle as wide as the annulus at each bolt, the first "
        "towards x; 0: the whole annulus, as always in low-order models",
        6,
        default=parts.Flange.bolts,
    )


class NutKeys(keys.GrooveKeys, keys.PartMaterialKeys, parts.Nut):
    """Nut, or outer ring of a bearing: dimensions, position, and where it is fixed."""

    flange: FlangeKeys | None = scene_key(
        "flange of a nut with a lead", {"diameter": "72 mm", "thickness": "11 mm"}, default=None
    )
    held: NutFixingKeys = scene_key(
        "surface at which the nut or outer ring is fixed", {"at": "left face"}, default=NutFixingKeys()
    )


#: Angle range that balls fill: first and last azimuth [rad].
Arc = Annotated[tuple[ranges.Azimuth, ...], ranges.ListLength(2, 2)]


class BallKeys(keys.RadiusOrDiameter, keys.PartMaterialKeys, parts.Balls):
    """Balls: size and positions, given by count (or filling) and turns, by count and arcs, or by a list of azimuths."""

    NAMES = "radius", "diameter"
    diameter: BallDiameter | None = scene_key("nominal ball diameter (or radius)", "5.556 mm", default=None)
    count: ranges.Count | None = scene_key(
        "number of balls in all starts and circuits, evenly spaced (with turns)", 32, default=None
    )
    filling: ranges.Filling | None = scene_key(
        "fraction of the length of the turns that the balls would fill if they touched (instead of count)",
        0.9,
        default=None,
    )
    turns: ranges.Turns | None = scene_key(
        "turns that the balls of each circuit fill, centred on the nut (a bearing: 1)", default=None
    )
    circuits: ranges.Circuits = scene_key("number of ball circuits of each start, one after the other", 3, default=1)
    circuit_gap: Gap | None = scene_key("number of turns without balls between two circuits", 0.5, default=None)
    azimuths: Annotated[tuple[ranges.Azimuth, ...], ranges.ListLength(1, ranges.MAX_BALLS)] | None = scene_key(  # type: ignore[assignment]
        "azimuths of the balls of one thread start, with 360 deg more for each further turn (instead of count and turns)",
        ["-90 deg", "90 deg"],
        default=None,
    )
    arcs: Annotated[tuple[Arc, ...], ranges.ListLength(1, 1000)] | None = scene_key(
        "azimuth ranges, one for each circuit, over which the balls of each thread start are evenly spread "
        "(instead of turns)",
        [["-900 deg", "-180 deg"], ["180 deg", "900 deg"]],
        default=None,
    )


class BallErrorKeys(keys.SceneFileTable, parts.BallErrors):
    """Manufacturing errors of the ball radii: of all balls, of single balls, and random ones."""

    listed: dict[str, ranges.Deviation] | None = scene_key(  # type: ignore[assignment]
        "errors of the radii of single balls, by ball number from 1 (all balls of start 1 first)",
        {"17": "1 um"},
        default=None,
    )


class ManufacturingErrorKeys(keys.SceneFileTable, parts.Errors):
    """Manufacturing errors of balls and grooves; all are zero if left out."""

    balls: BallErrorKeys


class DisplacementKeys(keys.SceneFileTable):
    """Prescribed displacements and small rotations of a support or housing."""

    ONE_OF: ClassVar = parts.FREEDOMS
    ux: ranges.Shift | None = scene_key("displacement along x", default=None)
    uy: ranges.Shift | None = scene_key("displacement along y", default=None)
    uz: ranges.Shift | None = scene_key("displacement along z", default=None)
    rx: ranges.Turn | None = scene_key("rotation about x", default=None)
    ry: ranges.Turn | None = scene_key("rotation about y", default=None)
    rz: ranges.Turn | None = scene_key("rotation about z", default=None)

    @property
    def given(self) -> dict[str, float]:
        """Prescribed displacements [m] and rotations [rad], by the name of the degree of freedom."""
        return {name: value for name in parts.FREEDOMS if (value := getattr(self, name)) is not None}


class FixedFreedomKeys(keys.SceneFileTable):
    """Degrees of freedom in which a support or housing is fixed."""

    fix: keys.Freedoms = scene_key("degrees of freedom fixed at zero", ["ux", "uy", "uz"], default=())
    displace: DisplacementKeys = scene_key(
        "degrees of freedom fixed at other values", {"ux": "300 um"}, default=DisplacementKeys()
    )

    @property
    def fixed(self) -> tuple[tuple[str, float], ...]:
        """Pairs of a fixed degree of freedom, in the order of `FREEDOMS`, and its displacement [m] or rotation [rad]."""
        held = dict.fromkeys(self.fix, 0.0) | self.displace.given
        return tuple((name, held[name]) for name in parts.FREEDOMS if name in held)


class SupportKeys(FixedFreedomKeys, parts.Support):
    """Support of the screw at one axial position."""


#: List of supports of a scene.
Supports = Annotated[tuple[SupportKeys, ...], ranges.ListLength(0, 1000)]

#: Example of load cases.
CASE = [{"name": "cutting", "share": 1.0}]


class FrictionKeys(keys.SceneFileTable, parts.Friction):
    """Coulomb friction between balls and grooves, for the command rollbench friction. It does not change static loads."""

    coefficient: ranges.Coefficient | None = scene_key(
        "coefficient of friction between balls and grooves; may be zero; needed unless screw and nut are given",
        0.1,
        default=None,
    )
    screw: ranges.Coefficient | None  # type: ignore[assignment]
    nut: ranges.Coefficient | None  # type: ignore[assignment]
    coupling: Literal["none", "ball", "balls"] | None = scene_key(
        'former key: "none" is feedback = false, "ball" feedback = true, "balls" feedback = false and neighbours = true',
        "ball",
        default=None,
    )


class PreloadKeys(keys.SceneFileTable):
    """Preload of one nut: in four-point contact by force or oversize (instead of errors.balls.oversize), or in two-point
    contact by a lead offset of its halves. Give one of the three."""  # noqa: D205, D209 - a description in the schema

    force: Preload | None = scene_key(
        "axial force on the left flanks, and the same on the right flanks, without external load and with rigid "
        'nut and screw; or per cent of the computed dynamic load rating: "5 % of C"',
        "500 N",
        default=None,
    )
    oversize: ranges.Deviation | None = scene_key("length added to the radius of every ball", "3 um", default=None)
    lead_offset: ranges.Deviation | None = scene_key(
        "axial shift of that half of the nut's groove which is at larger z than the nut's centre; a ball exactly "
        "at the centre is in the half that is not shifted (for two separate nuts use [[sets]] with an offset)",
        default=None,
    )


class LoadCaseSupportKeys(keys.SceneFileTable):
    """Prescribed displacements of one of the scene's supports in one load case."""

    at: ranges.Station = scene_key("axial position of the support in the scene", "0 mm")
    displace: Annotated[DisplacementKeys, ranges.OneKeyNeeded()] = scene_key(
        "displacements of degrees of freedom that the support fixes", {"ux": "300 um"}
    )


class LoadCaseKeys(keys.SceneFileTable):
    """One of several load cases: its loads, its support displacements, and its fraction of all revolutions."""

    name: ranges.Sentence = scene_key("name of the load case in all results: letters, digits, . _ and -", "cutting")
    share: Share | None = scene_key(
        "fraction of all revolutions that occur in this load case (sum over load cases: 1); 0: static check only",
        0.5,
        default=None,
    )
    time: CaseTime | None = scene_key(
        "duration in one duty cycle, from which the share follows (with speed)", "2 s", default=None
    )
    speed: ranges.Turning | None = scene_key(
        "angular speed of the rotating part in this load case (with time)", "600 rpm", default=None
    )
    loads: parts.Loads | None = scene_key(
        "loads on the screw, instead of those outside [[cases]]", parts.LOADED, default=None
    )
    supports: Annotated[tuple[LoadCaseSupportKeys, ...], ranges.ListLength(0, 1000)] = scene_key(
        "displacements of the scene's supports in this load case",
        [{"at": "0 mm", "displace": {"ux": "300 um"}}],
        default=(),
    )
    oversize: ranges.Deviation | None = scene_key(
        "length added to the radius of every ball, instead of the oversize outside [[cases]]", "3 um", default=None
    )


class SharedMaterialKeys(keys.SceneFileTable):
    """Material of all parts."""

    material: keys.MaterialKeys = scene_key(
        "material of all parts in whose tables no material is given", keys.MATERIAL, default=keys.MaterialKeys()
    )


class SceneKeys(SharedMaterialKeys, parts.Scene):
    """One ball screw or bearing, in one load case or several. Lengths, forces and angles are texts with a unit."""

    kind: Literal["ball screw", "bearing"] | None = scene_key(
        "what the scene describes; the lead decides if left out", "ball screw", default=None
    )
    track: TrackKeys
    screw: ScrewKeys
    nut: NutKeys
    balls: BallKeys
    errors: ManufacturingErrorKeys
    supports: Supports
    friction: FrictionKeys | None
    cases: Annotated[tuple[LoadCaseKeys, ...], ranges.ListLength(0, 1000)] = scene_key(
        "load cases of a duty cycle, all with the same bodies", CASE, default=()
    )
    preload: PreloadKeys | None = scene_key("preload of one nut", {"force": "500 N"}, default=None)


#: Temperature rise of the shaft [K].
Warming = Annotated[float, QuantityRange("temperature difference", "-500 K", "500 K", "10 K")]

#: Coefficient of thermal expansion [1/K].
Expansion = Annotated[float, QuantityRange("number", 0, 1e-3, 11.5e-6)]

#: Axial preload of a nut or bearing as a force [N], or as a fraction of the dynamic load rating; may be zero.
Push = Annotated[float | ShareOfLoadRating, ForceOrRatingShareRange("force", "0 N", "1000 MN", "500 N")]

#: Name of an arrangement of equal bearings, such as DB (back to back).
Arrangement = Literal["DB", "DF", "DT", "DBD", "DFD", "DBB", "DFF", "DBT", "DFT"]

#: Entry of a stiffness matrix.
Entry = Annotated[float, Field(strict=True, allow_inf_nan=False)]


class ShaftKeys(ScrewKeys):
    """Screw shaft; groove and diameter of its thread also apply to nuts and bearings for which no others are given."""

    plain: Annotated[tuple[axis.Segment, ...], ranges.ListLength(0, 1000)] = scene_key(
        "cylindrical sections of the shaft without groove",
        [{"start": "0 mm", "end": "60 mm", "diameter": "25 mm"}],
        default=(),
    )


class InnerRingKeys(keys.GrooveKeys):
    """Inner ring of a bearing; for a nut, the groove on the shaft if it differs from the one in [screw]."""

    outer_diameter: ranges.Size | None = scene_key(
        "diameter of the inner ring's shoulders, if not that of the shaft", "40 mm", default=None
    )
    material: keys.MaterialKeys | None = scene_key(
        "material of the inner ring, if it is not that of the shaft", keys.MATERIAL, default=None
    )


class TaperedRollerKeys(keys.SceneFileTable, axis.RollerRow):
    """One row of tapered rollers with its rings: dimensions, crowning, and contact with the rib."""

    rating: ClassVar[Any]  # type: ignore[misc]
    ring_depth: ranges.Size = scene_key("depth below both raceways down to which deformation is considered", "5 mm")
    crown: ranges.Size | None = scene_key(  # type: ignore[assignment]
        "radius of curvature of the roller's crowned profile at both raceways; straight rollers if left out",
        "2 m",
        default=None,
    )


class NutOrBearingKeys(keys.SceneFileTable, axis.RollingSet):
    """One ball nut, ball bearing (lead of zero) or row of tapered rollers on a shaft, and how it is mounted."""

    kind: Literal["ball nut", "bearing", "tapered roller bearing"] | None = scene_key(  # type: ignore[assignment]
        "type of the nut or bearing; if left out, it follows from the lead and from whether there is a table of rollers",
        "ball nut",
        default=None,
    )
    thrust: axis.Thrust | None = scene_key(  # type: ignore[assignment]
        'direction of the axial force on the shaft that the bearing carries: "both" (gothic arch), "+z" or "-z" '
        '(single arc), "deep groove" (single arc, either direction)',
        "+z",
        default=None,
    )
    preload: Push = scene_key(  # type: ignore[assignment]
        "axial preload: without external loads, the nut or outer ring is shifted along z until it carries this "
        "force, and then fixed; or per cent of the computed dynamic load rating of a ball nut or ball bearing: "
        '"5 % of C"',
        "500 N",
        default=0.0,
    )
    arrangement: Arrangement | None = scene_key(
        "arrangement of equal bearings side by side, its middle at the position, with the same gap between "
        "opposite bearings as in a pair: DB back to back, DF face to face, DBD two against one, DBB two against "
        "two, DBT three against one; the key preload is then the preload of the arrangement",
        "DBD",
        default=None,
    )
    pair_preload: ranges.Force = scene_key(
        "preload of a pair of these bearings, from which that of the arrangement follows", "2150 N", default=0.0
    )
    pair_rigidity: ranges.Spring | None = scene_key(
        "axial rigidity of this pair at its preload, as in catalogues: the conformity of both grooves follows from it",
        "750 N/um",
        default=None,
    )
    position: ranges.Station | None = scene_key(  # type: ignore[assignment]
        "for rollers: axial position of the middle of the cup's contact lines", "30 mm", default=None
    )
    track: TrackKeys | None = scene_key("path of the ball centres", default=None)
    screw: InnerRingKeys | None = scene_key(
        "inner ring of the bearing; for a nut, the groove on the shaft if it differs from the one in [screw]", default=None
    )
    nut: NutKeys | None = scene_key("nut, or outer ring", default=None)
    balls: BallKeys | None = scene_key("balls", default=None)
    errors: ManufacturingErrorKeys = scene_key(
        "manufacturing errors of balls and grooves", {"seed": 0}, default=parts.Errors()
    )
    rollers: TaperedRollerKeys | None = scene_key(
        "number and dimensions of tapered rollers, and of their contacts", default=None
    )
    rating: parts.MakerRating = scene_key(
        "load ratings by the maker; for an arrangement, of one row", {"dynamic": "23.2 kN"}, default=parts.MakerRating()
    )


class SpringKeys(keys.SceneFileTable):
    """Stiffnesses of springs along and about the axes; zero if left out."""

    ONE_OF: ClassVar = parts.FREEDOMS
    ux: ranges.Spring = scene_key("stiffness along x", "200 N/um", default=0.0)
    uy: ranges.Spring = scene_key("stiffness along y", "200 N/um", default=0.0)
    uz: ranges.Spring = scene_key("stiffness along z", "200 N/um", default=0.0)
    rx: ranges.Twist = scene_key("rotational stiffness about x: moment per radian", "5 kN m", default=0.0)
    ry: ranges.Twist = scene_key("rotational stiffness about y: moment per radian", "5 kN m", default=0.0)
    rz: ranges.Twist = scene_key("rotational stiffness about z: moment per radian", "5 kN m", default=0.0)


#: Stiffness matrix of six rows with six entries.
Matrix = Annotated[tuple[Annotated[tuple[Entry, ...], ranges.ListLength(6, 6)], ...], ranges.ListLength(6, 6)]


class StiffnessKeys(keys.SceneFileTable):
    """Stiffness of a housing or joint in six degrees of freedom, by springs or by a matrix."""

    springs: Annotated[SpringKeys, ranges.OneKeyNeeded()] | None = scene_key(
        "independent springs", {"ux": "200 N/um"}, default=None
    )
    matrix: Matrix | None = scene_key(
        "symmetric 6x6 stiffness matrix for ux, uy, uz, rx, ry, rz in N, m and rad (instead of springs)", default=None
    )


class HousingKeys(FixedFreedomKeys, StiffnessKeys, axis.Housing):
    """Rigid housing of nuts or outer rings; in directions that are not fixed or displaced, it moves against its springs."""


class JointKeys(StiffnessKeys, axis.Joint):
    """Elastic connection of two housings, such as a spacer or a bolted joint."""

    between: Annotated[tuple[ranges.Name, ...], ranges.ListLength(2, 2)] = scene_key(
        "names of the two housings", ["a", "b"]
    )


class StiffnessPositionKeys(keys.SceneFileTable):
    """Position at which the stiffness of the whole assembly is reported; if left out, where the loads act."""

    at: ranges.Station | None = scene_key(
        "axial position on the shaft at which the stiffness is reported", "400 mm", default=None
    )
    housing: ranges.Name | None = scene_key(
        "name of the housing at which the stiffness is reported (instead of at)", "carriage", default=None
    )


class ShaftHeatingKeys(keys.SceneFileTable):
    """Uniform temperature rise of the shaft relative to all other parts."""

    warming: Warming = scene_key("temperature rise of the shaft", "10 K")
    expansion: Expansion = scene_key("coefficient of thermal expansion per K", 11.5e-6)


class ShaftModelOptionKeys(keys.SceneFileTable, parts.Ingredients, only=("hertz", "section")):
    """Options of the low-order models of a shaft with nuts and bearings."""

    partition: Literal["nodal", "source"] = scene_key(
        "nodes of the shaft's beam elements: at every contact, or 15 mm apart in every nut as in Lin's thesis",
        "source",
        default="nodal",
    )


class LoadCaseHousingKeys(keys.SceneFileTable, axis.Housing, only=("force", "moment")):
    """Loads on one of the scene's housings in one load case."""

    ONE_OF: ClassVar = parts.Load.ONE_OF
    name: ranges.Name = scene_key("name of the housing in the scene", "carriage")


class ShaftLoadCaseKeys(LoadCaseKeys):
    """One of several load cases of a shaft; its oversize applies to the balls of all nuts and bearings."""

    housings: Annotated[tuple[Annotated[LoadCaseHousingKeys, ranges.OneKeyNeeded(1)], ...], ranges.ListLength(0, 100)] = (
        scene_key(
            "loads on housings, instead of those outside [[cases]]",
            [{"name": "carriage", "force": ["0 N", "0 N", "5 kN"]}],
            default=(),
        )
    )


class ShaftSceneKeys(SharedMaterialKeys, axis.Assembly):
    """One shaft with several nuts and bearings, with or without housings, in one load case or several."""

    kind: Literal["axis"] = scene_key("what the scene describes", "axis", default="axis")  # type: ignore[misc]
    screw: ShaftKeys
    sets: Annotated[tuple[NutOrBearingKeys, ...], ranges.ListLength(1, 100)]
    housings: Annotated[tuple[HousingKeys, ...], ranges.ListLength(0, 100)]
    joints: Annotated[tuple[JointKeys, ...], ranges.ListLength(0, 100)]
    supports: Supports
    cases: Annotated[tuple[ShaftLoadCaseKeys, ...], ranges.ListLength(0, 1000)] = scene_key(
        "load cases of a duty cycle, all with the same bodies", CASE, default=()
    )
    stiffness: StiffnessPositionKeys = scene_key(
        "position at which the stiffness of the assembly is reported",
        {"housing": "carriage"},
        default=StiffnessPositionKeys(),
    )
    heat: ShaftHeatingKeys | None = scene_key(
        "temperature rise of the shaft", {"warming": "10 K", "expansion": 11.5e-6}, default=None
    )
    ingredients: ShaftModelOptionKeys
    friction: FrictionKeys | None
