"""What keys of several kinds of scenes share: quantities with ranges, tables of material, grooves, path, motion."""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from rollbench.compare.scenes.catalogue_input import MATERIAL_NAMES, OTHER_NAME, with_material
from rollbench.meshes.ranges import (
    MAX_BALLS,
    SOLIDS,
    Coefficient,
    Conformity,
    ContactAngle,
    Deviation,
    Lead,
    Modulus,
    Poisson,
    Quantity,
    Radius,
    Size,
    Turning,
)

Count = Annotated[int, Field(ge=1, le=MAX_BALLS)]
Sentence = Annotated[str, Field(min_length=1, max_length=2000)]
Sentences = Annotated[list[Sentence], Field(max_length=100)]
MaterialName = Literal[
    "bearing steel", "silicon nitride", "zirconia", "100Cr6", "SUJ2", "AISI 52100", "42CrMo4", "50CrMo4", "Si3N4", "ZrO2"
]
StandardName = Annotated[MaterialName, Field(json_schema_extra={"x-or": OTHER_NAME})]
Freedoms = Annotated[list[Literal["ux", "uy", "uz", "rx", "ry", "rz"]], Field(max_length=6)]


def key(description: str, default: Any = ..., example: Any = None) -> Any:
    """A key of the file. ``default`` is written as in a scene; without it the key is required."""
    examples = None if example is None else [example]
    return Field(default=default, description=description, examples=examples)


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
                out[name] = _as_in_a_file(value, node)
        elif name == "description":
            out[name] = value.partition("\n\n")[0]
        elif not (name == "title" and isinstance(value, str)):
            out[name] = value if name == "examples" else without_null(value)
    return out


def _as_in_a_file(default: Any, node: dict[str, Any]) -> Any:
    """A default as a file has it: a record has it in SI units."""
    if isinstance(default, list):
        return [_as_in_a_file(x, node.get("items", {})) for x in default]
    if isinstance(default, float) and "x-unit" in node:
        return Quantity(node["x-dimension"], 0, 0, node["examples"][0]).written(default)
    return default
