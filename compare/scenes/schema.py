"""Keys of scene files, with descriptions, units, ranges and defaults.

A scene file describes one screw or bearing, or several nuts and bearing rows on one shaft (``[[sets]]``). Values are
converted to SI units.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from rollbench.compare.scenes import keys
from rollbench.compare.scenes.keys import config_requiring_one_of, fill_in_radius, key
from rollbench.meshes import parts, ranges
from rollbench.meshes.axis import Drive, Segment
from rollbench.meshes.parts import Flange, Friction, Motion, NutHeld
from rollbench.meshes.ranges import ForceOrShare, Quantity, Rate, ShareOfRating

BallDiameter = Annotated[float, Quantity("length", "0.02 mm", "2 m", "5.556 mm")]

Gap = Annotated[float, Quantity("number", 0, 1000, 0.5)]

Preload = Annotated[float | ShareOfRating, ForceOrShare("force", "0 N", "10 MN", "500 N", above=True)]

Share = Annotated[float, Quantity("number", 0, 1, 0.5)]

CaseTime = Annotated[float, Rate("time", "0 s", "1000000000 s", "2 s")]


class ClearanceKeys(keys.Table):
    """Internal clearance of a bearing, as in data sheets: total free travel of one ring relative to the other."""

    radial: ranges.Clearance | None = key("radial clearance", None, "13 um")
    axial: ranges.Clearance | None = key("or axial clearance", None, "96 um")


class TrackKeys(keys.HelixKeys):
    """Nominal path of the ball centres: a helix, or a circle for a bearing."""

    model_config = config_requiring_one_of("pitch_radius", "pitch_diameter")

    contact_angle: ranges.ContactAngle | None = key(  # type: ignore[assignment]
        "nominal angle of the contact normal against the radius; of a bearing it may follow from clearance", None, "45 deg"
    )
    clearance: ClearanceKeys | None = key(
        "of a bearing whose grooves are one arc each (deep groove, or a row with thrust), in place of the contact angle",
        None,
        {"radial": "13 um"},
    )

    pitch_diameter: Annotated[ranges.Size | None, Field(exclude=True)] = key(
        "diameter of the helix of the ball centres (or pitch_radius)", None, "33 mm"
    )
    starts: Annotated[int, Field(ge=1, le=100)] = key(
        "number of starts; start k is start 1 turned by k/starts of a revolution", 1, 1
    )
    phase: ranges.Azimuth = key("azimuth of the helix at the nut's centre", "0 deg", "0 deg")

    @model_validator(mode="before")
    @classmethod
    def _fill_in_radius(cls, value: Any) -> Any:
        """Return the unchecked table with the radius filled in from the diameter."""
        return fill_in_radius(value, "pitch_radius", "pitch_diameter")


class ScrewKeys(keys.GrooveKeys):
    """Screw shaft, or inner ring of a bearing."""

    length: ranges.Size = key("length; stations run from 0 to it", example="800 mm")
    outer_diameter: ranges.Size = key("outer diameter of the thread or of the shoulders", example="32 mm")
    bore: ranges.Bore = key("diameter of the hole along the axis", "0 mm", "10 mm")
    material: keys.MaterialKeys | None = key("material of this part where it is not [material]", None, keys.MATERIAL)


class FlangeKeys(keys.Table):
    """Flange at an end of the nut, within its length."""

    diameter: ranges.Size = key("outer diameter", example="72 mm")
    thickness: ranges.Size = key("thickness", example="11 mm")
    side: Literal["left", "right"] = key("end of the nut", Flange.side, "right")
    centring: ranges.Bore = key(
        "length of the nut's outside, from the flange on, that fits the bore of the housing", "0 mm", "10 mm"
    )


class HeldKeys(keys.Table):
    """Surface at which the nut is fixed."""

    at: NutHeld | None = key(
        "surface; the flange's face towards the rest of the nut where there is a flange, else the left face, or the outer "
        "surface at zero lead (low-order models hold the whole of a face but the flange's)",
        None,
        "left face",
    )
    inner_diameter: ranges.Size | None = key("of the annulus on the flange's face; the nut's if left out", None, "50 mm")
    outer_diameter: ranges.Size | None = key("of the annulus on the flange's face; the flange's if left out", None, "66 mm")
    centring: Literal["free", "bonded"] = key(
        "of the flange's face: whether the centring fit lets the nut go, or holds it too", "free", "bonded"
    )
    bolts: Annotated[int, Field(ge=0, le=100)] = key(
        "of the flange's face: bolts, at each of which a circle as wide as the annulus is held in 3D, the first towards x; "
        "0: all of the annulus, as low-order models always do",
        Flange.bolts,
        6,
    )


class NutKeys(keys.GrooveKeys):
    """Nut, or outer ring of a bearing; it is fixed."""

    position: ranges.Station = key("station of the nut's centre along the screw", example="400 mm")
    length: ranges.Size = key("length", example="54 mm")
    outer_diameter: ranges.Size = key("outer diameter", example="48 mm")
    azimuth: ranges.Azimuth = key("angle between the axes of nut and screw; turns the nut's errors", "0 deg", "0 deg")
    flange: FlangeKeys | None = key("flange of a nut with a lead", None, {"diameter": "72 mm", "thickness": "11 mm"})
    held: HeldKeys = key("where the nut is held", HeldKeys(), {"at": "left face"})
    material: keys.MaterialKeys | None = key("material of this part where it is not [material]", None, keys.MATERIAL)


Arc = Annotated[list[ranges.Azimuth], Field(min_length=2, max_length=2)]


class BallKeys(keys.BallSizeKeys):
    """Balls: their size, and their positions by count or filling with turns, by count with arcs, or by single azimuths."""

    model_config = config_requiring_one_of("radius", "diameter")

    diameter: Annotated[BallDiameter | None, Field(exclude=True)] = key("nominal diameter (or radius)", None, "5.556 mm")
    count: keys.Count | None = key("number of balls over all starts and circuits, spread evenly (with turns)", None, 32)
    filling: ranges.Filling | None = key(
        "part of the turns that the balls would fill if they touched (or count)", None, 0.9
    )
    turns: ranges.Turns | None = key("turns filled by the balls of each circuit, centred on the nut (zero lead: 1)", None)
    circuits: Annotated[int, Field(ge=1, le=1000)] = key("circuits of each start, one after the other", 1, 3)
    circuit_gap: Gap | None = key("turns without balls from each circuit to the next", None, 0.5)
    azimuths: Annotated[list[ranges.Azimuth], Field(min_length=1, max_length=ranges.MAX_BALLS)] | None = key(
        "unwrapped azimuths of the balls of one start, instead of count and turns", None, ["-90 deg", "90 deg"]
    )
    arcs: Annotated[list[Arc], Field(min_length=1, max_length=1000)] | None = key(
        "angle ranges that the balls of each start fill evenly, instead of turns: circuits with gaps between them",
        None,
        [["-900 deg", "-180 deg"], ["180 deg", "900 deg"]],
    )
    material: keys.MaterialKeys | None = key("material of this part where it is not [material]", None, keys.MATERIAL)

    @model_validator(mode="before")
    @classmethod
    def _fill_in_radius(cls, value: Any) -> Any:
        """Return the unchecked table with the radius filled in from the diameter."""
        return fill_in_radius(value, "radius", "diameter")


class BallErrorKeys(keys.OversizeKeys):
    """Errors of the ball radii."""

    listed: dict[str, ranges.Deviation] = key(
        "added to the radius of single balls, by number from 1 (all balls of start 1 first)", {}, {"17": "1 um"}
    )
    sigma: ranges.Spread = key("standard deviation of random radius errors", "0 um", "1 um")
    distribution: Literal["normal", "uniform"] = key("distribution of the random errors", "normal", "normal")


class ErrorKeys(keys.Table):
    """Geometric errors; all are zero if left out."""

    seed: Annotated[int, Field(ge=0, le=2**63 - 1)] = key("seed of every random error", 0, 2019)
    balls: BallErrorKeys = key("errors of the ball radii", BallErrorKeys(), {"oversize": "7 um"})
    SL: parts.SideErrors = key("screw, left flank", parts.SideErrors(), {"profile": ["3 um"]})
    SR: parts.SideErrors = key("screw, right flank", parts.SideErrors(), {"profile": ["3 um"]})
    NL: parts.SideErrors = key("nut, left flank", parts.SideErrors(), {"profile": ["3 um"]})
    NR: parts.SideErrors = key("nut, right flank", parts.SideErrors(), {"profile": ["3 um"]})


class DisplaceKeys(keys.Table):
    """Prescribed displacements and small rotations."""

    ux: ranges.Shift | None = key("displacement along x", None)
    uy: ranges.Shift | None = key("displacement along y", None)
    uz: ranges.Shift | None = key("displacement along z", None)
    rx: ranges.Turn | None = key("rotation about x", None)
    ry: ranges.Turn | None = key("rotation about y", None)
    rz: ranges.Turn | None = key("rotation about z", None)

    @property
    def given(self) -> dict[str, float]:
        """Prescribed displacements [m] and rotations [rad], by the name of the degree of freedom."""
        return self.model_dump(exclude_none=True)


class SupportKeys(keys.Table):
    """Support of the screw at one axial position."""

    at: ranges.Station = key("station along the screw", example="0 mm")
    fix: keys.Freedoms = key("freedoms held at zero", [], ["ux", "uy", "uz"])
    displace: DisplaceKeys = key("freedoms held at other values", DisplaceKeys(), {"ux": "300 um"})

    @property
    def held(self) -> tuple[str, ...]:
        """Degrees of freedom that the support prescribes: first those fixed at zero, then those displaced."""
        return (*self.fix, *self.displace.given)


Supports = Annotated[list[SupportKeys], Field(max_length=1000)]

Loads = Annotated[list[parts.Load], Field(max_length=1000)]

#: Examples of loads and of load cases.
LOADED, CASE = [{"at": "0 mm", "force": ["0 N", "0 N", "5 kN"]}], [{"name": "cutting", "share": 1.0}]


class FrictionKeys(keys.Table):
    """Coulomb friction between balls and grooves, for the command rollbench friction. It does not change static loads."""

    coefficient: ranges.Coefficient | None = key(
        "coefficient of friction of ball on groove; zero is allowed; needed unless screw and nut are given", None, 0.1
    )
    screw: ranges.Coefficient | None = key("coefficient on the screw's groove, where it is another", None)
    nut: ranges.Coefficient | None = key("coefficient on the nut's groove, where it is another", None)
    balls: ranges.Coefficient | None = key(
        "coefficient from ball to ball, where it is not the larger one of the grooves", None
    )
    feedback: bool = key(
        "whether friction moves each ball across its grooves, at the axial load it carries, or does not change the loads",
        Friction.feedback,
        False,
    )
    neighbours: bool = key(
        "whether neighbours that touch push each other at the scene's instant (always in a simulation over time)",
        Friction.neighbours,
        True,
    )
    coupling: Literal["none", "ball", "balls"] | None = key(
        'former key: "none" is feedback = false, "ball" feedback = true, "balls" feedback = false and neighbours = true',
        None,
        "ball",
    )
    assumed: keys.Sentences = key(
        "sentences on where the coefficients come from", [], ["Grease-lubricated steel, assumed."]
    )


class PreloadKeys(keys.Table):
    """Preload of one nut: in four-point contact by force or oversize (instead of errors.balls.oversize), or in two-point
    contact by a lead offset of its halves. Give one of the three."""  # noqa: D205, D209 - a description in the schema

    force: Preload | None = key(
        "axial force between the two pairs of flanks of nut and screw without load, both taken as rigid; or in per cent of "
        'the dynamic load rating as computed: "5 % of C"',
        None,
        "500 N",
    )
    oversize: ranges.Deviation | None = key("added to every ball's radius", None, "3 um")
    lead_offset: ranges.Deviation | None = key(
        "shift of the nut's groove beyond its centre along the axis, against the rest, the step between two balls: one at "
        "the centre counts to the half before it (two nuts: [[sets]] with an offset)",
        None,
    )


class CaseSupportKeys(keys.Table):
    """Prescribed displacements of one of the scene's supports in one load case."""

    at: ranges.Station = key("station of the support in the scene", example="0 mm")
    displace: DisplaceKeys = key("values of freedoms that the support holds", example={"ux": "300 um"})


class CaseKeys(keys.Table):
    """One of several load cases of the same parts: its differences from the scene, and its share of the revolutions."""

    name: keys.Sentence = key("name in all results, of letters, digits, . _ and -", example="cutting")
    share: Share | None = key("part of the revolutions; 0: static check only; all cases together 1", None, 0.5)
    time: CaseTime | None = key("time in one duty cycle, from which the share follows (with speed)", None, "2 s")
    speed: ranges.Turning | None = key("speed of the part that turns in this case (with time)", None, "600 rpm")
    loads: Loads | None = key("loads in place of the scene's", None, LOADED)
    supports: Annotated[list[CaseSupportKeys], Field(max_length=1000)] = key(
        "other displacements of the scene's supports", [], [{"at": "0 mm", "displace": {"ux": "300 um"}}]
    )
    oversize: ranges.Deviation | None = key("added to every ball's radius in place of the scene's value", None, "3 um")


class SceneKeys(keys.HeadKeys):
    """One ball screw or bearing, in one load case or several. Lengths, forces and angles are texts with a unit."""

    kind: Literal["ball screw", "bearing"] | None = key("what is described; by the lead if left out", None, "ball screw")
    role: Literal["", "referenced", "unseen, changed parts", "unseen, catalogue size"] = key(
        "of a shipped scene in the report: a case study with a 3D reference, or a scene that no model was made with",
        "",
        "referenced",
    )
    members: Annotated[int, Field(ge=1, le=100_000)] = key("number of draws of the random errors", 1, 200)
    material: keys.MaterialKeys = key("material of every part that gives none", keys.MaterialKeys(), keys.MATERIAL)
    track: TrackKeys = key("path of the ball centres")
    screw: ScrewKeys = key("screw shaft, or inner ring")
    nut: NutKeys = key("nut, or outer ring")
    balls: BallKeys = key("balls")
    errors: ErrorKeys = key("geometric errors", ErrorKeys(), {"seed": 0})
    supports: Supports = key("supports of the screw", [], [{"at": "0 mm", "fix": ["ux", "uy"]}])
    loads: Loads = key("loads on the screw", [], LOADED)
    cases: Annotated[list[CaseKeys], Field(max_length=1000)] = key("load cases of the same parts", [], CASE)
    ingredients: parts.Ingredients = key("parts of the low-order model", parts.Ingredients(), {"screw": "rigid"})
    solid: parts.Solid = key("what only the 3D reference needs", parts.Solid(), {"nut_groove": "through"})
    friction: FrictionKeys | None = key("friction of balls and grooves", None, {"coefficient": 0.1})
    motion: parts.Motion | None = key("motion of screw and nut", None, {"speed": "600 rpm"})
    lubricant: parts.Lubricant | None = key("lubricant, for torques that depend on speed", None, {"viscosity": "27 mm2/s"})
    circulation: parts.Circulation | None = key("circuits of the balls", None, {"returning": 4, "filling": 0.8})
    time: parts.Time | None = key("simulation over time", None, {"angle": "360 deg"})
    preload: PreloadKeys | None = key("preload of one nut", None, {"force": "500 N"})
    gate: parts.GateLimits = key("limits for: rollbench check", parts.GateLimits(), {"max_error": 7})
    operation: parts.Operation = key("reliability, lubricant, limit of speed", parts.Operation(), {"reliability": 95})


Warming = Annotated[float, Quantity("temperature difference", "-500 K", "500 K", "10 K")]

Expansion = Annotated[float, Quantity("number", 0, 1e-3, 11.5e-6)]

Push = Annotated[float | ShareOfRating, ForceOrShare("force", "0 N", "1000 MN", "500 N")]

Name = Annotated[str, Field(min_length=1, max_length=60)]

Arrangement = Literal["DB", "DF", "DT", "DBD", "DFD", "DBB", "DFF", "DBT", "DFT"]

Entry = Annotated[float, Field(allow_inf_nan=False)]


class ShaftKeys(ScrewKeys):
    """Screw shaft, with the groove and diameters of the thread for all sets that do not state their own."""

    plain: Annotated[list[Segment], Field(max_length=1000)] = key(
        "plain stretches of the shaft", [], [{"start": "0 mm", "end": "60 mm", "diameter": "25 mm"}]
    )


class InnerKeys(keys.GrooveKeys):
    """Inner ring of a set, or its groove on the shaft, if it differs from that of the shaft."""

    outer_diameter: ranges.Size | None = key("diameter of its shoulders, where it is not the shaft's", None, "40 mm")
    material: keys.MaterialKeys | None = key("its material, where it is not the shaft's", None, keys.MATERIAL)


class RollerKeys(keys.Table):
    """One row of tapered rollers."""

    count: keys.Count = key("number of rollers", example=16)
    diameter: ranges.Size = key("mean diameter of a roller", example="8.4 mm")
    length: ranges.Size = key("effective length of a roller", example="12.4 mm")
    cup_angle: ranges.ContactAngle = key(
        "half included angle of the cup: of the outer contacts against the axis", example="30.8 deg"
    )
    roller_angle: ranges.ContactAngle = key("half included angle of a roller", example="4 deg")
    ring_depth: ranges.Size = key("depth of both rings to which their deformation counts", example="5 mm")
    crown: ranges.Size | None = key("radius of the crowning at both contacts; straight rollers if left out", None, "2 m")
    slices: Annotated[int, Field(ge=1, le=200)] = key("slices of a roller", 15, 15)
    edge_radius: ranges.Size | None = key(
        "radius of the rounding that follows the effective length at both ends, for the roller in 3D; sharp if left out",
        None,
        "1 mm",
    )
    end_radius: ranges.Size | None = key(
        "radius of the sphere of the large end, for the pressure on the rib; usually 0.8 to 0.95 of its apex distance",
        None,
        "55 mm",
    )
    rib_height: ranges.Size | None = key(
        "height of the contact with the rib above the cone's race; a tenth of the diameter if left out", None, "0.8 mm"
    )
    rib_friction: ranges.Coefficient | None = key(
        "coefficient of friction of the large end on the rib; 0.1 if left out", None, 0.1
    )
    torque_factor: ranges.TorqueFactor | None = key("the maker's factor G1, for the torque by Timken's formula", None, 40)


class SetKeys(keys.Table):
    """One set of rolling elements: a nut with its balls, a ball bearing (lead of zero), or a row of tapered rollers."""

    name: Name = key("name of the set in results", example="nut 1")
    kind: Literal["ball nut", "bearing", "tapered roller bearing"] | None = key(
        "what it is; by its tables if left out", None, "ball nut"
    )
    housing: Name | None = key("name of the housing that its outer part belongs to; held if left out", None, "carriage")
    carrier: Name | None = key("name of the housing that its inner ring sits on; the shaft if left out", None, "nut")
    thrust: Literal["both", "+z", "-z", "deep groove"] | None = key(
        'thrust on the shaft that it carries: "both" by a gothic arch, one way by an angular-contact row, or by one arc',
        None,
        "+z",
    )
    offset: ranges.Deviation = key(
        "shift of its outer part along the shaft against its housing (spacer, lead offset)", "0 um", "4 um"
    )
    preload: Push = key(
        "axial force set by such a shift at mounting, without loads and warming, and then locked; or in per cent of the "
        'dynamic load rating of balls as computed: "5 % of C"',
        "0 N",
        "500 N",
    )
    arrangement: Arrangement | None = key(
        "set of equal bearings side by side about the position, ground to equal gaps: DB back to back, DF face to face, "
        "DBD two against one, DBB two against two, DBT three against one; preload is then that of the set",
        None,
        "DBD",
    )
    pair_preload: ranges.Force = key(
        "preload of a pair of these bearings with the same gaps, from which that of the set follows", "0 N", "2150 N"
    )
    pair_rigidity: ranges.Spring | None = key(
        "axial rigidity of that pair at its preload, as makers print it: the conformity of both grooves follows from it",
        None,
        "750 N/um",
    )
    position: ranges.Station | None = key("of rollers: station of the middle of the cup's contact lines", None, "30 mm")
    track: TrackKeys | None = key("path of the ball centres", None)
    screw: InnerKeys | None = key("its inner ring, or groove on the shaft where that is another", None)
    nut: NutKeys | None = key("nut, or outer ring", None)
    balls: BallKeys | None = key("balls", None)
    errors: ErrorKeys = key("geometric errors", ErrorKeys(), {"seed": 0})
    rollers: RollerKeys | None = key("tapered rollers", None)
    seals: ranges.Torque = key(
        "friction torque of its seals or wipers as their maker gives it, of each row of an arrangement", "0 N m", "100 N mm"
    )


class SpringKeys(keys.Table):
    """Stiffnesses of springs along and about the axes; zero if left out."""

    ux: ranges.Spring = key("along x", "0 N/m", "200 N/um")
    uy: ranges.Spring = key("along y", "0 N/m", "200 N/um")
    uz: ranges.Spring = key("along z", "0 N/m", "200 N/um")
    rx: ranges.Twist = key("about x, per rad", "0 N m", "5 kN m")
    ry: ranges.Twist = key("about y, per rad", "0 N m", "5 kN m")
    rz: ranges.Twist = key("about z, per rad", "0 N m", "5 kN m")


Matrix = Annotated[list[Annotated[list[Entry], Field(min_length=6, max_length=6)]], Field(min_length=6, max_length=6)]


class StiffKeys(keys.Table):
    """Stiffness in six degrees of freedom, by springs or by a matrix."""

    springs: SpringKeys | None = key("springs that do not feel one another", None, {"ux": "200 N/um"})
    matrix: Matrix | None = key("or a symmetric matrix of six rows, in N, m and rad", None)


class HousingKeys(StiffKeys):
    """Rigid housing of outer rings or nuts. In directions that are not fixed or displaced, it moves against its springs."""

    name: Name = key("its name", example="carriage")
    at: ranges.Station = key("station where its motion, springs and loads are taken", example="400 mm")
    fix: keys.Freedoms = key("freedoms held at zero", [], ["ux", "uy", "rx", "ry", "rz"])
    displace: DisplaceKeys = key("freedoms held at other values", DisplaceKeys(), {"uz": "20 um"})
    force: ranges.Forces = key("force on it along x, y, z", ["0 N", "0 N", "0 N"], ["0 N", "0 N", "5 kN"])
    moment: ranges.Moments = key("moment on it about x, y, z", ["0 N m", "0 N m", "0 N m"], ["0 N m", "3 N m", "0 N m"])


class JointKeys(StiffKeys):
    """Elastic connection of two housings, such as a spacer or a bolted joint."""

    between: Annotated[list[Name], Field(min_length=2, max_length=2)] = key("names of the two housings", example=["a", "b"])
    at: ranges.Station = key("station where they act", example="400 mm")


class AskedKeys(keys.Table):
    """Position for which the stiffness of the whole assembly is reported; if left out, where the loads act."""

    at: ranges.Station | None = key("a station of the shaft", None, "400 mm")
    housing: Name | None = key("or a housing", None, "carriage")


class HeatKeys(keys.Table):
    """Uniform temperature rise of the shaft relative to all other parts."""

    warming: Warming = key("warming", example="10 K")
    expansion: Expansion = key("thermal expansion per K", example=11.5e-6)


class AxisIngredientKeys(keys.Table):
    """Options of the low-order model."""

    hertz: Literal["nominal", "error-free", "actual", "as printed"] = key(
        "contact constants: own radii at the nominal angle, error-free parts, actual geometry, or as in Table B.1",
        "nominal",
        "actual",
    )
    partition: Literal["nodal", "source"] = key(
        "nodes of the shaft: at every contact, or as the source (15 mm in every set)", "nodal", "source"
    )
    section: Literal["groove", "groove squared", "full"] = key(
        "section of the threaded shaft: diameters scaled by k_r (Lin C.8), by k_r without the root, or full",
        "groove",
        "full",
    )


class CaseHousingKeys(keys.Table):
    """Loads on one of the scene's housings in one load case."""

    name: Name = key("name of the housing in the scene", example="carriage")
    force: ranges.Forces = key("force on it along x, y, z", ["0 N", "0 N", "0 N"], ["0 N", "0 N", "5 kN"])
    moment: ranges.Moments = key("moment on it about x, y, z", ["0 N m", "0 N m", "0 N m"], ["0 N m", "3 N m", "0 N m"])


class AxisCaseKeys(CaseKeys):
    """One of several load cases of the same parts; an oversize applies to the balls of every set."""

    housings: Annotated[list[CaseHousingKeys], Field(max_length=100)] = key(
        "loads on housings in place of the scene's", [], [{"name": "carriage", "force": ["0 N", "0 N", "5 kN"]}]
    )


class AxisKeys(keys.HeadKeys):
    """One shaft with several nuts and bearings, with or without housings, in one load case or several."""

    kind: Literal["axis"] = key("what is described", "axis", "axis")
    material: keys.MaterialKeys = key("material of every part that gives none", keys.MaterialKeys(), keys.MATERIAL)
    screw: ShaftKeys = key("screw shaft")
    sets: Annotated[list[SetKeys], Field(min_length=1, max_length=100)] = key("rolling sets, in any order")
    housings: Annotated[list[HousingKeys], Field(max_length=100)] = key(
        "housings that move", [], [{"name": "carriage", "at": "400 mm"}]
    )
    joints: Annotated[list[JointKeys], Field(max_length=100)] = key(
        "springs between housings", [], [{"between": ["a", "b"], "at": "400 mm"}]
    )
    supports: Supports = key("supports of the shaft other than bearings", [], [{"at": "0 mm", "fix": ["rz"]}])
    loads: Loads = key("loads on the shaft", [], LOADED)
    cases: Annotated[list[AxisCaseKeys], Field(max_length=1000)] = key("load cases of the same parts", [], CASE)
    stiffness: AskedKeys = key("where the stiffness is asked for", AskedKeys(), {"housing": "carriage"})
    heat: HeatKeys | None = key("warming of the shaft", None, {"warming": "10 K", "expansion": 11.5e-6})
    ingredients: AxisIngredientKeys = key("parts of the low-order model", AxisIngredientKeys(), {"section": "full"})
    friction: FrictionKeys | None = key("friction of balls and grooves", None, {"coefficient": 0.1})
    motion: Motion | None = key("motion of the shaft", None, {"speed": "600 rpm"})
    lubricant: parts.Lubricant | None = key("lubricant, for torques that depend on speed", None, {"viscosity": "27 mm2/s"})
    drive: Drive = key("what its motor moves", Drive(), {"mass": "200 kg"})
