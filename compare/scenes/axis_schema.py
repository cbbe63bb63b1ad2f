"""Keys of a scene with several rolling sets on one shaft, ``[[sets]]``."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from rollbench.compare.scenes import keys, schema
from rollbench.compare.scenes.keys import key
from rollbench.meshes import ranges
from rollbench.meshes.axis import Segment
from rollbench.meshes.parts import Motion
from rollbench.meshes.ranges import ForceOrShare, Quantity, ShareOfRating

Warming = Annotated[float, Quantity("temperature difference", "-500 K", "500 K", "10 K")]
Expansion = Annotated[float, Quantity("number", 0, 1e-3, 11.5e-6)]
Push = Annotated[float | ShareOfRating, ForceOrShare("force", "0 N", "1000 MN", "500 N")]
Name = Annotated[str, Field(min_length=1, max_length=60)]
Arrangement = Literal["DB", "DF", "DT", "DBD", "DFD", "DBB", "DFF", "DBT", "DFT"]
Entry = Annotated[float, Field(allow_inf_nan=False)]


class ShaftKeys(schema.ScrewKeys):
    """Screw shaft; groove and diameters of the thread, where a set does not say its own."""

    plain: Annotated[list[Segment], Field(max_length=1000)] = key(
        "plain stretches of the shaft", [], [{"start": "0 mm", "end": "60 mm", "diameter": "25 mm"}]
    )


class InnerKeys(keys.GrooveKeys):
    """Inner ring of a set whose groove is not the shaft's."""

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


class SetKeys(keys.Table):
    """One rolling set: a nut with its balls, a ball bearing (lead of zero), or a row of tapered rollers."""

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
    track: schema.TrackKeys | None = key("path of the ball centres", None)
    screw: InnerKeys | None = key("its inner ring, or groove on the shaft where that is another", None)
    nut: schema.NutKeys | None = key("nut, or outer ring", None)
    balls: schema.BallKeys | None = key("balls", None)
    errors: schema.ErrorKeys = key("geometric errors", schema.ErrorKeys(), {"seed": 0})
    rollers: RollerKeys | None = key("tapered rollers", None)


class SpringKeys(keys.Table):
    """Springs along and about the axes; freedoms left out have none."""

    ux: ranges.Spring = key("along x", "0 N/m", "200 N/um")
    uy: ranges.Spring = key("along y", "0 N/m", "200 N/um")
    uz: ranges.Spring = key("along z", "0 N/m", "200 N/um")
    rx: ranges.Twist = key("about x, per rad", "0 N m", "5 kN m")
    ry: ranges.Twist = key("about y, per rad", "0 N m", "5 kN m")
    rz: ranges.Twist = key("about z, per rad", "0 N m", "5 kN m")


Matrix = Annotated[list[Annotated[list[Entry], Field(min_length=6, max_length=6)]], Field(min_length=6, max_length=6)]


class StiffKeys(keys.Table):
    """A stiffness in six freedoms."""

    springs: SpringKeys | None = key("springs that do not feel one another", None, {"ux": "200 N/um"})
    matrix: Matrix | None = key("or a symmetric matrix of six rows, in N, m and rad", None)


class HousingKeys(StiffKeys):
    """Rigid body that carries outer rings or nuts. What is neither fixed nor displaced moves against its springs."""

    name: Name = key("its name", example="carriage")
    at: ranges.Station = key("station where its motion, springs and loads are taken", example="400 mm")
    fix: keys.Freedoms = key("freedoms held at zero", [], ["ux", "uy", "rx", "ry", "rz"])
    displace: schema.DisplaceKeys = key("freedoms held at other values", schema.DisplaceKeys(), {"uz": "20 um"})
    force: ranges.Forces = key("force on it along x, y, z", ["0 N", "0 N", "0 N"], ["0 N", "0 N", "5 kN"])
    moment: ranges.Moments = key("moment on it about x, y, z", ["0 N m", "0 N m", "0 N m"], ["0 N m", "3 N m", "0 N m"])


class JointKeys(StiffKeys):
    """Springs between two housings, such as a spacer or a bolted joint."""

    between: Annotated[list[Name], Field(min_length=2, max_length=2)] = key("names of the two housings", example=["a", "b"])
    at: ranges.Station = key("station where they act", example="400 mm")


class AskedKeys(keys.Table):
    """Where the stiffness of the whole is asked for; where the loads act if left out."""

    at: ranges.Station | None = key("a station of the shaft", None, "400 mm")
    housing: Name | None = key("or a housing", None, "carriage")


class HeatKeys(keys.Table):
    """Uniform warming of the shaft against all else."""

    warming: Warming = key("warming", example="10 K")
    expansion: Expansion = key("thermal expansion per K", example=11.5e-6)


class AxisIngredientKeys(keys.Table):
    """Which parts of the low-order model are used."""

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
    """Loads on one of the scene's housings in a case."""

    name: Name = key("name of the housing in the scene", example="carriage")
    force: ranges.Forces = key("force on it along x, y, z", ["0 N", "0 N", "0 N"], ["0 N", "0 N", "5 kN"])
    moment: ranges.Moments = key("moment on it about x, y, z", ["0 N m", "0 N m", "0 N m"], ["0 N m", "3 N m", "0 N m"])


class AxisCaseKeys(schema.CaseKeys):
    """One of several load cases of the same parts; an oversize is that of the balls of every set."""

    housings: Annotated[list[CaseHousingKeys], Field(max_length=100)] = key(
        "loads on housings in place of the scene's", [], [{"name": "carriage", "force": ["0 N", "0 N", "5 kN"]}]
    )


class AxisKeys(keys.HeadKeys):
    """One shaft with several rolling sets, nuts, bearings, housings, in one load case or several."""

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
    supports: schema.Supports = key("supports of the shaft besides its bearings", [], [{"at": "0 mm", "fix": ["rz"]}])
    loads: schema.Loads = key("loads on the shaft", [], schema.LOADED)
    cases: Annotated[list[AxisCaseKeys], Field(max_length=1000)] = key("load cases of the same parts", [], schema.CASE)
    stiffness: AskedKeys = key("where the stiffness is asked for", AskedKeys(), {"housing": "carriage"})
    heat: HeatKeys | None = key("warming of the shaft", None, {"warming": "10 K", "expansion": 11.5e-6})
    ingredients: AxisIngredientKeys = key("parts of the low-order model", AxisIngredientKeys(), {"section": "full"})
    friction: schema.FrictionKeys | None = key("friction of balls and grooves", None, {"coefficient": 0.1})
    motion: Motion | None = key("motion of the shaft", None, {"speed": "600 rpm"})
