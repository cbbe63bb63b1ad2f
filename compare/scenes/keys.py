"""Keys that several kinds of scene files share: tables of material, grooves, ball path, balls, friction and motion."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cache
from typing import Annotated, Any, ClassVar, Literal, TypeVar, dataclass_transform

from pydantic import Field, TypeAdapter, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from rollbench.meshes import ranges
from rollbench.meshes.parts import ASSUMED, FIRST, SOURCE, TITLE, BallErrors, Balls, Motion, Track
from rollbench.meshes.record_keys import scene_key
from rollbench.meshes.units import UnitError, parse_quantity

# --- names of materials and diameters, as catalogues give them, are replaced by moduli and radii before the keys are
# checked

#: Materials by name: Young's modulus and Poisson's ratio, rounded values within the ranges of makers' data sheets
#: (steels of bearings and of hardened shafts: 205 to 212 GPa; silicon nitride balls: 300 to 315 GPa; zirconia balls: 205
#: to 210 GPa).
STANDARD: dict[str, tuple[str, float]] = {
    "bearing steel": ("210 GPa", 0.3),
    "silicon nitride": ("310 GPa", 0.26),
    "zirconia": ("210 GPa", 0.3),
}
#: Names of the standard materials in drawings and catalogues.
GRADES = {
    "bearing steel": ("100Cr6", "SUJ2", "AISI 52100", "42CrMo4", "50CrMo4"),
    "silicon nitride": ("Si3N4",),
    "zirconia": ("ZrO2",),
}
#: Young's modulus and Poisson's ratio of the materials, also by their names in drawings and catalogues.
MATERIALS = STANDARD | {grade: STANDARD[name] for name, grades in GRADES.items() for grade in grades}
#: Description of the key for the name of a material.
MATERIAL_NAMES = (
    "a standard material, with typical values for those of the two keys below that are left out: "
    + ", ".join(f"{name} ({', '.join(GRADES[name])}) {modulus}, {ratio:g}" for name, (modulus, ratio) in STANDARD.items())
    + "; any other name if both keys below are given"
)
#: Allowed value of the name of a material besides the standard names, in words.
OTHER_NAME = "any other name with youngs_modulus and poissons_ratio"


#: Name of a standard material, also as in drawings and catalogues.
MaterialName = Literal[
    "bearing steel", "silicon nitride", "zirconia", "100Cr6", "SUJ2", "AISI 52100", "42CrMo4", "50CrMo4", "Si3N4", "ZrO2"
]
#: Name of a standard material, whose JSON Schema also mentions other names.
StandardName = Annotated[MaterialName, Field(json_schema_extra={"x-or": OTHER_NAME})]
#: Names of degrees of freedom.
Freedoms = Annotated[tuple[Literal["ux", "uy", "uz", "rx", "ry", "rz"], ...], ranges.ListLength(0, 6)]

#: Class of a record.
Record = TypeVar("Record")


@dataclass_transform(frozen_default=True, kw_only_default=True, field_specifiers=(scene_key,))
class SceneFileTable:
    """Table of a scene file, in which unknown keys are errors; its subclasses are frozen dataclasses.

    A table that inherits from a record has those fields of the record as keys that have a description. It adds keys that
    only files have, and replaces fields in whose place a file may have another key; an annotation without a value replaces
    the type only, and one that allows None makes the key optional.
    """

    __pydantic_config__: ClassVar[Any] = {"extra": "forbid"}

    def __init_subclass__(cls, only: tuple[str, ...] = ()) -> None:
        """Make a dataclass of the subclass; fields of its record that are no keys are left out.

        ``only``: names of those fields of the record that are keys; empty: all that have a description.
        """
        own = inspect.get_annotations(cls)
        inherited: dict[str, Any] = {}
        for base in reversed(cls.__mro__[1:]):
            inherited |= base.__dict__.get("__dataclass_fields__", {})
        for name, of in inherited.items():
            if name not in own and ("description" not in of.metadata or (only and name not in only)):
                own = own | {name: ClassVar[Any]}
            elif name in own and name not in cls.__dict__:
                usual = None if str(own[name]).endswith("| None") else of.default
                setattr(cls, name, field(default=usual, metadata=of.metadata))
        cls.__annotations__ = own
        dataclass(frozen=True, kw_only=True)(cls)

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: Any, handler: Any) -> Any:
        """Return the JSON Schema of the table, with the keys in the order of the record's fields; a title comes first."""
        whole = handler(schema)
        node = handler.resolve_ref_schema(whole)
        names = {each.name: node["properties"][each.name] for each in fields(cls)}  # type: ignore[arg-type]
        node["properties"] = {name: names[name] for name in FIRST if "title" in names and name in names} | names
        node["description"] = inspect.cleandoc(cls.__doc__ or "")  # which pydantic 2.9 does not take from a dataclass
        return whole


class RadiusOrDiameter(SceneFileTable):
    """Table of a scene file that states either a radius or a diameter."""

    #: Names of the keys of the radius and of the diameter.
    NAMES: ClassVar[tuple[str, str]]

    @model_validator(mode="before")
    @classmethod
    def _fill_in_radius(cls, table: Any) -> Any:
        """Return the table, before its check, with the radius filled in if only the diameter is given.

        Halving a floating-point number is exact, so the result is the same as with the radius in the file. A diameter that
        cannot be read is reported later under its own key.
        """
        radius, diameter = cls.NAMES
        if not isinstance(table, dict) or diameter not in table or radius in table:
            return table
        try:
            half = 0.5 * parse_quantity(table[diameter], "length")
        except UnitError:
            half = 1e-3
        return table | {radius: f"{min(max(half, 1e-5), 1.0)!r} m"}

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: Any, handler: Any) -> Any:
        """Return the JSON Schema of the table, in which exactly one of the two keys is required."""
        whole = super().__get_pydantic_json_schema__(schema, handler)
        node = handler.resolve_ref_schema(whole)
        node["required"] = [name for name in node["required"] if name != cls.NAMES[0]]
        node["oneOf"] = [{"required": [name]} for name in cls.NAMES]
        return whole


def record_from_keys(record: type[Record], table: Any, **values: Any) -> Record:
    """Return a record of the class ``record`` from the keys of a table; ``values``: fields that do not equal a key."""
    names = (each.name for each in fields(record))  # type: ignore[arg-type]
    return record(**{name: values[name] if name in values else getattr(table, name) for name in names})


class MaterialKeys(SceneFileTable):
    """Isotropic elastic material; a constant that a part's table does not give is taken from the table [material]."""

    name: StandardName | None = scene_key(MATERIAL_NAMES, "bearing steel", default=None)
    unusual: ranges.Switch = scene_key(
        "true: accept a Young's modulus outside the range of materials of machine parts", True, default=False
    )
    youngs_modulus: ranges.Modulus | None = scene_key("Young's modulus", default=None)
    poissons_ratio: ranges.Poisson | None = scene_key("Poisson's ratio", default=None)

    @model_validator(mode="before")
    @classmethod
    def _fill_in_constants(cls, table: Any) -> Any:
        """Return the table, before its check, with missing elastic constants filled in from the material's name.

        An unknown name is dropped if the table gives both constants: it is then only a remark for readers of the file.
        """
        if not isinstance(table, dict) or not isinstance(name := table.get("name"), str):
            return table
        if name in MATERIALS:
            modulus, ratio = MATERIALS[name]
            return {"youngs_modulus": modulus, "poissons_ratio": ratio} | table
        both = {"youngs_modulus", "poissons_ratio"} <= table.keys()
        return {key: value for key, value in table.items() if key != "name"} if both else table

    @field_validator("youngs_modulus")
    @classmethod
    def _check_modulus(cls, value: float | None, info: ValidationInfo) -> float | None:
        """Return Young's modulus; error if no solid has such a modulus (wrong unit) and the key ``unusual`` is not true."""
        if value is None or ranges.SOLIDS[0] <= value <= ranges.SOLIDS[1] or info.data.get("unusual"):
            return value
        allowed = f"{1e-9 * ranges.SOLIDS[0]:g} GPa to {1e-9 * ranges.SOLIDS[1]:g} GPa"
        advice = 'correct the unit (steel has "210 GPa"), or write unusual = true if the value is intended'
        raise PydanticCustomError("quantity", "{advice}", {"allowed": allowed, "advice": advice})


#: Example of a table with the keys of a material.
MATERIAL = {"youngs_modulus": "210 GPa", "poissons_ratio": 0.28}


class PartMaterialKeys(SceneFileTable):
    """Material of one part."""

    material: MaterialKeys | None = scene_key(
        "material of this part, if it is not that of [material]", MATERIAL, default=None
    )


class TitleKeys(SceneFileTable):
    """Keys at the beginning of every scene file: title, source of the data, assumptions."""

    title: ranges.Sentence = scene_key(TITLE, "Screw under 5 kN")
    source: ranges.Words = scene_key(SOURCE, "Lin 2019, 2.4.1.1", default="")
    assumed: ranges.Sentences = scene_key(ASSUMED, ["The nut is rigid."], default=())


class BallPathKeys(SceneFileTable, Track, only=("pitch_radius", "lead")):
    """Nominal path of the ball centres of a screw or a bearing ring."""

    contact_angle: ranges.ContactAngle


class BallHelixKeys(SceneFileTable, Track, only=("pitch_radius", "lead", "hand")):
    """Nominal path of the ball centres, a right-handed or left-handed helix."""

    contact_angle: ranges.ContactAngle


class GrooveKeys(SceneFileTable):
    """Cross-section of a groove, by its radius or by its conformity (groove radius over ball diameter)."""

    groove_radius: ranges.Radius | None = scene_key(
        "radius of the groove's arc (give either groove_radius or conformity)", "3.254 mm", default=None
    )
    conformity: ranges.Conformity | None = scene_key(
        "ratio of groove radius to ball diameter (instead of groove_radius)", default=None
    )

    def radius_for(self, ball_radius: float) -> float:
        """Return the groove radius [m]: as stated, or as conformity times the ball diameter, twice ``ball_radius`` [m]."""
        return self.groove_radius or (self.conformity or 0.0) * (2.0 * ball_radius)


class BallSizeKeys(SceneFileTable, Balls):
    """Nominal size of the balls."""


class BallOversizeKeys(SceneFileTable, BallErrors, only=("oversize",)):
    """Deviation from the nominal ball radius that all balls have, such as an oversize for preload."""


class CoulombFrictionKeys(SceneFileTable):
    """Coulomb friction between balls and grooves."""

    coefficient: ranges.Coefficient = scene_key("coefficient of friction between balls and grooves; may be zero")


class RingSpeedKeys(SceneFileTable, Motion, only=("speed",)):
    """Angular speed of the rotating ring of a bearing."""


#: Pydantic's reader of a table, for the class of the table's keys; each is made once.
reader_of_tables: Callable[[type], TypeAdapter[Any]] = cache(TypeAdapter)


@cache
def scene_schema_of_kind(keys: type) -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of one kind of scene, with description, unit, range and example of every key.

    The returned object is cached and must not be changed.
    """
    schema: dict[str, Any] = schema_without_null(reader_of_tables(keys).json_schema())
    return schema


def schema_without_null(node: Any) -> Any:
    """Return a JSON Schema, or a part of it, without ``null``, which TOML does not have.

    Pydantic's titles and the defaults of tables are removed too.
    """
    if isinstance(node, list):
        return [schema_without_null(v) for v in node]
    if not isinstance(node, dict):
        return node
    out: dict[str, Any] = {}
    for name, value in node.items():
        if name == "anyOf":
            (kept,) = (v for v in value if v != {"type": "null"})
            out |= {k: v for k, v in schema_without_null(kept).items() if k not in node}
        elif name == "properties" or name == "$defs":
            out[name] = {k: schema_without_null(v) for k, v in value.items()}
        elif name == "default":
            if value is not None and not isinstance(value, dict):
                out[name] = _default_with_unit(value, node)
        elif name == "description":
            out[name] = value.partition("\n\n")[0]
        elif not (name == "title" and isinstance(value, str)):
            out[name] = value if name == "examples" else schema_without_null(value)
    return out


def _default_with_unit(default: Any, node: dict[str, Any]) -> Any:
    """Return the default value of a key, in SI units, as text with a unit, as it would be written in a scene file.

    ``node``: part of the JSON Schema for the key.
    """
    if isinstance(default, list):
        return [_default_with_unit(x, node.get("items", {})) for x in default]
    if isinstance(default, float) and "x-unit" in node:
        return ranges.QuantityRange(node["x-dimension"], 0, 0, node["examples"][0]).text_with_unit(default)
    return default
