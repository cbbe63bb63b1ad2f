"""What keys of several kinds of scenes share: quantities with ranges, tables of material, grooves, path, motion."""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from rollbench.compare.scenes.catalogue_input import MATERIAL_NAMES, OTHER_NAME, with_material
from rollbench.compare.scenes.quantity import Quantity, Rate, key

MAX_BALLS = 100_000


Size = Annotated[float, Quantity("length", "0.01 mm", "100 m", "20 mm")]
Radius = Annotated[float, Quantity("length", "0.01 mm", "1 m", "2.778 mm")]
Bore = Annotated[float, Quantity("length", "0 mm", "100 m", "10 mm")]
Station = Annotated[float, Quantity("length", "0 mm", "100 m", "400 mm")]
Lead = Annotated[float, Quantity("length", "0 mm", "1 m", "20 mm")]
Deviation = Annotated[float, Quantity("length", "-10 mm", "10 mm", "1 um")]
Spread = Annotated[float, Quantity("length", "0 mm", "10 mm", "1 um")]
Shift = Annotated[float, Quantity("length", "-1 m", "1 m", "300 um")]
Turn = Annotated[float, Quantity("angle", "-200 mrad", "200 mrad", "1 mrad")]
Azimuth = Annotated[float, Quantity("angle", "-1000000 deg", "1000000 deg", "-360 deg")]
ContactAngle = Annotated[float, Quantity("angle", "0 deg", "90 deg", "45 deg", above=True, below=True)]
Modulus = Annotated[float, Quantity("pressure", "1 MPa", "5000 GPa", "210 GPa")]
Poisson = Annotated[float, Quantity("number", 0, 0.5, 0.28, below=True)]
Conformity = Annotated[float, Quantity("number", 0.5, 5, 0.52, above=True)]
Turns = Annotated[float, Quantity("number", 0, 10_000, 2, above=True)]
Harmonic = Annotated[float, Quantity("number", 0, 10_000, 1)]
Force = Annotated[float, Quantity("force", "-1000 MN", "1000 MN", "5 kN")]
Moment = Annotated[float, Quantity("moment", "-1000000 kN m", "1000000 kN m", "3 N m")]
#: A force and a moment by x, y, z.
Forces = Annotated[list[Force], Field(min_length=3, max_length=3)]
Moments = Annotated[list[Moment], Field(min_length=3, max_length=3)]
Element = Annotated[float, Quantity("length", "0.01 mm", "1 m", "1 mm")]
Coefficient = Annotated[float, Quantity("number", 0, 2, 0.1)]
Clearance = Annotated[float, Quantity("length", "0 mm", "1 m", "50 um")]
Filling = Annotated[float, Quantity("number", 0, 1, 0.8, above=True)]
Travel = Annotated[float, Quantity("angle", "0.001 deg", "1000000 deg", "360 deg")]
Duration = Annotated[float, Rate("time", "0 s", "1000000 s", "1 s", above=True)]
StepGoal = Annotated[float, Quantity("number", 0.0001, 0.1, 0.01)]
Turning = Annotated[float, Rate("angular speed", "-100000 rps", "100000 rps", "600 rpm")]
Count = Annotated[int, Field(ge=1, le=MAX_BALLS)]
Sentence = Annotated[str, Field(min_length=1, max_length=2000)]
Sentences = Annotated[list[Sentence], Field(max_length=100)]
MaterialName = Literal[
    "bearing steel", "silicon nitride", "zirconia", "100Cr6", "SUJ2", "AISI 52100", "42CrMo4", "50CrMo4", "Si3N4", "ZrO2"
]
StandardName = Annotated[MaterialName, Field(json_schema_extra={"x-or": OTHER_NAME})]
Freedoms = Annotated[list[Literal["ux", "uy", "uz", "rx", "ry", "rz"]], Field(max_length=6)]
#: Young's moduli [Pa] of solids that parts of machines are made of.
SOLIDS = (1e9, 1e12)


class Table(BaseModel):
    """A table of a scene file: no other keys, no silent conversions."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, validate_default=True, defer_build=True)


class MaterialKeys(Table):
    """Isotropic elastic material. A part that gives only one of the two takes the other from [material]."""

    name: StandardName | None = key(MATERIAL_NAMES, None, "bearing steel")
    unusual: bool = key("the modulus is meant as it stands, although no solid of a machine has it", False, True)
    youngs_modulus: Modulus | None = key("Young's modulus", None)
    poissons_ratio: Poisson | None = key("Poisson's ratio", None)

    @model_validator(mode="before")
    @classmethod
    def _by_name(cls, value: Any) -> Any:
        return with_material(value)

    @field_validator("youngs_modulus")
    @classmethod
    def _of_a_solid(cls, value: float | None, info: ValidationInfo) -> float | None:
        """A modulus that is a slip of a unit is refused, unless the table says that it is meant."""
        if value is None or SOLIDS[0] <= value <= SOLIDS[1] or info.data.get("unusual"):
            return value
        allowed = f"{1e-9 * SOLIDS[0]:g} GPa to {1e-9 * SOLIDS[1]:g} GPa"
        advice = 'steel has "210 GPa"; if it is meant, write unusual = true with it'
        raise PydanticCustomError("quantity", "{advice}", {"allowed": allowed, "advice": advice})


MATERIAL = {"youngs_modulus": "210 GPa", "poissons_ratio": 0.28}


class HeadKeys(Table):
    """What a scene of every kind begins with."""

    title: Sentence = key("one line saying what the scene is", example="Screw under 5 kN")
    source: Annotated[str, Field(max_length=2000)] = key("where the numbers come from", "", "Lin 2019, 2.4.1.1")
    assumed: Sentences = key("sentences on what the source leaves open", [], ["The nut is rigid."])


class PathKeys(Table):
    """Nominal path of the ball centres of a screw or a ring."""

    pitch_radius: Size = key("radius of the helix of the ball centres", example="16.5 mm")
    lead: Lead = key('advance of the helix per turn; "0 mm" is a ball bearing')
    contact_angle: ContactAngle = key("nominal angle of the contact normal against the radius")


class HelixKeys(PathKeys):
    """Nominal path of the ball centres, of either hand."""

    hand: Literal["right", "left"] = key("hand of the helix", "right", "right")


class GrooveKeys(Table):
    """Section of a groove: its radius, or that over the ball's diameter."""

    groove_radius: Radius | None = key("radius of curvature of the groove (or conformity)", None, "3.254 mm")
    conformity: Conformity | None = key("groove radius over ball diameter (or groove_radius)", None)


class BallSizeKeys(Table):
    """Size of the balls."""

    radius: Radius = key("nominal radius")


class OversizeKeys(Table):
    """Error that all ball radii share."""

    oversize: Deviation = key("added to every ball's radius (preload if positive)", "0 um", "7 um")


class CoulombKeys(Table):
    """Coulomb friction of the balls on the grooves."""

    coefficient: Coefficient = key("coefficient of friction of ball on groove; zero is allowed")


class SpeedKeys(Table):
    """Motion of a ring."""

    speed: Turning = key("angular speed of the part that turns, about +z; negative: the other way")


class MotionKeys(SpeedKeys):
    """Which part turns and how fast, for: rollbench friction."""

    turns: Literal["screw", "nut"] = key(
        "the part that turns; the other one does not, and they move apart along the axis by the lead", "screw", "nut"
    )


@cache
def tidy_schema(keys: type[BaseModel]) -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of one kind of scene, with description, unit, range and example of every key.

    Cached: do not change it.
    """
    schema: dict[str, Any] = without_null(keys.model_json_schema())
    return schema


def without_null(node: Any) -> Any:
    """Drop ``null`` (TOML has none) and pydantic's titles, and defaults that are whole tables."""
    if isinstance(node, list):
        return [without_null(v) for v in node]
    if not isinstance(node, dict):
        return node
    out: dict[str, Any] = {}
    for name, value in node.items():
        if name == "anyOf":
            (kept,) = (v for v in value if v != {"type": "null"})
            out |= {k: v for k, v in without_null(kept).items() if k not in node}
        elif name == "properties" or name == "$defs":
            out[name] = {k: without_null(v) for k, v in value.items()}
        elif name == "default":
            if value is not None and not isinstance(value, dict):
                out[name] = value
        elif not (name == "title" and isinstance(value, str)):
            out[name] = value if name == "examples" else without_null(value)
    return out
