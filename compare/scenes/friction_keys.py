"""Keys of friction scenes: quantities with units and ranges, tables of a rotary bearing, a linear pair, a linear chain."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from compare.scenes.quantity import Quantity, Rate, key
from compare.scenes.schema import Conformity, ContactAngle, Modulus, Poisson, Radius, Sentence, Size, Table
from lowfi.friction.bearing.rotary import Mode
from lowfi.friction.linear.loads import Loads

Law = Literal["coulomb", "regularised", "sigmoid"]
Kind = Literal["rotary bearing", "linear pair", "linear chain", "screw pair", "screw run", "bearing pair"]
Speed = Annotated[float, Rate("speed", "-1000 m/s", "1000 m/s", "10 mm/s")]
Creep = Annotated[float, Rate("speed", "0 m/s", "1 m/s", "0.1 mm/s", above=True)]
Turning = Annotated[float, Rate("angular speed", "-100000 rps", "100000 rps", "10 rps")]
Play = Annotated[float, Quantity("length", "-1 mm", "1 mm", "-1 um")]
Move = Annotated[float, Quantity("length", "-1 mm", "1 mm", "5 um")]
Gap = Annotated[float, Quantity("length", "0 mm", "1 m", "0.5 mm")]
Axial = Annotated[float, Quantity("force", "-1 MN", "1 MN", "100 N")]
Pressing = Annotated[float, Quantity("force", "0 N", "1 MN", "100 N", above=True)]
Coefficient = Annotated[float, Quantity("number", 0, 2, 0.1, above=True)]
Rubbing = Annotated[float, Quantity("number", 0, 2, 0.1)]
SideRatio = Annotated[float, Quantity("number", -10, 10, -0.6)]
Deviation = Annotated[float, Quantity("angle", "-15 deg", "15 deg", "2 deg")]
Sharpness = Annotated[float, Quantity("number", 0, 1_000_000, 100, above=True)]
MapStep = Annotated[float, Quantity("number", 0, 1, 0.08, above=True)]


class MaterialKeys(Table):
    """Isotropic elastic material of rings, rails and balls."""

    youngs_modulus: Modulus = key("Young's modulus")
    poissons_ratio: Poisson = key("Poisson's ratio")


class LinearBearingKeys(Table):
    """A ball between two gothic grooves."""

    ball_radius: Radius = key("radius of the balls")
    groove_radius: Radius | None = key("radius of curvature of the grooves (or conformity)", None, "5.6 mm")
    conformity: Conformity | None = key("groove radius over ball diameter (or groove_radius)", None)
    contact_angle: ContactAngle = key("nominal angle of the contact normals against the pressing direction or radius")


class RotaryBearingKeys(LinearBearingKeys):
    """One ball of a rotary bearing with gothic grooves."""

    pitch_radius: Size = key("radius of the circle of ball centres", example="35 mm")
    clearance: Play = key("play of the ball along each contact normal; negative: interference", "0 um", "-1 um")


class RotaryLoadKeys(Table):
    """What is done to the inner ring."""

    axial_force: Axial = key("force along the axis, towards +x")
    radial_displacement: Move = key("displacement towards the ball", "0 um", "5 um")


_DISTRIBUTION = "loads in balance at the angles, equal on each diagonal, or with angles that follow"


class PairLoadKeys(Table):
    """Force of the carriage on each ball; the side force acts on the second ball in the opposite sense."""

    vertical_force: Pressing = key("force that presses on each ball")
    side_force_ratio: SideRatio = key("side force on the first ball over vertical_force")
    distribution: Loads = key(_DISTRIBUTION, "balanced", "elastic")


class ChainLoadKeys(Table):
    """Force of the carriage on every ball."""

    vertical_force: Pressing = key("force that presses on each ball")
    distribution: Loads = key(_DISTRIBUTION, "balanced", "elastic")


class RotaryMotionKeys(Table):
    """Motion of the inner ring."""

    inner_ring: Turning = key("angular speed about the axis")


class LinearMotionKeys(Table):
    """Motion of the carriage."""

    carriage: Speed = key("speed along the track")


class RotaryFrictionKeys(Table):
    """Friction of the contacts."""

    coefficient: Coefficient = key("friction coefficient")
    law: Law = key("Coulomb's, Coulomb's regularised, or the sigmoid of Lin 3.20", "coulomb", "coulomb")
    creep: Creep | None = key('speed that regularises, for law = "regularised"', None)
    sharpness: Sharpness | None = key('k_S, for law = "sigmoid"', None)
    map_step: MapStep | None = key("step in c/a of the source's maps; exact integrals if left out", None)


class LinearFrictionKeys(Table):
    """Friction of grooves and balls."""

    coefficient: Coefficient = key("friction coefficient of the grooves")
    between_balls: Rubbing | None = key("friction coefficient of ball on ball; as the grooves if left out", None)
    law: Law = key('only "coulomb" for balls in contact', "coulomb", "coulomb")


class GrooveKeys(Table):
    """Contact angles of the pair: bottom left less, bottom right more by the deviation."""

    angle_deviation: Deviation = key("deviation theta of the bottom groove's contact angles")
    mated: bool = key("top groove made to match (Lin 3.3.4.2)", False, False)


class BallKeys(Table):
    """One ball of a chain, in order along the track."""

    side_force_ratio: SideRatio = key("side force over vertical_force", 0.0)
    angle_deviations: Annotated[list[Deviation], Field(min_length=4, max_length=4)] = key(
        "deviations of the contact angles at BL, BR, TR, TL",
        ["0 deg", "0 deg", "0 deg", "0 deg"],
        ["-2 deg", "2 deg", "0 deg", "0 deg"],
    )
    gap: Gap = key("gap to the next ball; none: in reach of each other", "0 mm", "0.5 mm")


class CommonKeys(Table):
    """What every friction scene has."""

    title: Sentence = key("one line saying what the scene is", example="Ball of Table 3.1")
    source: Annotated[str, Field(max_length=2000)] = key("where the numbers come from", "", "Lin 2019, Table 3.1")
    assumed: Annotated[list[Sentence], Field(max_length=100)] = key("what the source leaves open", [], ["No clearance."])
    kind: Kind = key("what the scene describes", example="rotary bearing")
    material: MaterialKeys = key("material of all parts")


class HertzKeys(CommonKeys):
    """Scenes that may take the source's Hertz constants."""

    hertz: Mode = key("Hertz constants: exact, or with the source's faults", "right", "right")


class RotaryKeys(HertzKeys):
    """One ball of a rotary bearing."""

    bearing: RotaryBearingKeys = key("geometry")
    loads: RotaryLoadKeys = key("loads")
    motion: RotaryMotionKeys = key("motion")
    friction: RotaryFrictionKeys = key("friction")


class PairKeys(CommonKeys):
    """Two balls of a linear bearing."""

    bearing: LinearBearingKeys = key("geometry")
    grooves: GrooveKeys = key("contact angles")
    loads: PairLoadKeys = key("loads")
    motion: LinearMotionKeys = key("motion")
    friction: LinearFrictionKeys = key("friction")


class ChainKeys(CommonKeys):
    """A chain of balls in a linear bearing."""

    bearing: LinearBearingKeys = key("geometry")
    loads: ChainLoadKeys = key("loads")
    balls: Annotated[list[BallKeys], Field(min_length=1, max_length=500)] = key("balls in order along the track")
    motion: LinearMotionKeys = key("motion")
    friction: LinearFrictionKeys = key("friction")


KINDS: dict[str, type[CommonKeys]] = {"rotary bearing": RotaryKeys, "linear pair": PairKeys, "linear chain": ChainKeys}
