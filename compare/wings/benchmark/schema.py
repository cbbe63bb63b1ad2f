"""The JSON Schema of a problem of the benchmark."""

from __future__ import annotations

from typing import Any

from rollbench.comparison.wings.benchmark.neutral import UNITS
from rollbench.comparison.wings.benchmark.problems import NAME, PROBLEMS
from rollbench.meshes.parts import FREEDOMS, SIDES

NUMBER = {"type": "number"}
POSITIVE = {"type": "number", "exclusiveMinimum": 0}


def schema() -> dict[str, Any]:
    """JSON Schema (2020-12) of a problem."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"A problem of {NAME}, in SI units",
        **_object(
            benchmark={"const": NAME},
            problem={"enum": list(PROBLEMS)},
            title=_text("what it is"),
            shows=_text("what it is there for"),
            units={"const": UNITS},
            shaft=_object(
                "screw, or inner ring",
                z=_numbers(2, "ends along the axis"),
                land_radius=POSITIVE | {"description": "of the cylinder between the grooves"},
                bore_radius=POSITIVE | {"description": "of the hole along the axis"},
                bore_moves_as_rigid_body={"type": "boolean"},
                material=_material(),
            ),
            sets={"type": "array", "minItems": 1, "items": _set()},
            supports={"type": "array", "items": _object(z=NUMBER, motion=_motion("of the shaft's section, m or rad"))},
            loads={"type": "array", "items": _object(z=NUMBER, force=_numbers(3, "N"), moment=_numbers(3, "N m"))},
        ),
    }


def _set() -> dict[str, Any]:
    flank = _object(
        radius=POSITIVE, centre_x3_z3=_numbers(2, "middle of the arc in the section of a ball, before any load")
    )
    return _object(
        "a nut or outer ring with its balls",
        name=_text("empty where there is one set"),
        helix=_object(
            pitch_radius=POSITIVE,
            lead={"type": "number", "minimum": 0, "description": "0: a ring"},
            hand={"enum": ["right", "left"]},
            azimuth_at_nut_centre=NUMBER,
        ),
        contact_angle=NUMBER | {"description": "of the flanks' centres, from the radius"},
        nut=_object(
            z=_numbers(2, "its faces: left, right"),
            shift_z=NUMBER | {"description": "by which it is pushed along z when it is mounted"},
            land_radius=POSITIVE,
            outer_radius=POSITIVE,
            material=_material(),
            held=_object(
                surface={"enum": ["left face", "right face", "outer surface"]}, motion=_motion("of all its points")
            ),
        ),
        flanks=_object(**dict.fromkeys(SIDES, flank)),
        stretch_meshed_by_the_reference=_numbers(2, "beyond it the reference has beams of the grooved shaft's section"),
        ball_material=_material(),
        balls={
            "type": "array",
            "items": _object(
                number={"type": "integer", "minimum": 1}, radius=POSITIVE, azimuth=NUMBER, centre=_numbers(3, "x, y, z")
            ),
        },
    )


def _object(description: str = "", /, **properties: dict[str, Any]) -> dict[str, Any]:
    about = {"description": description} if description else {}
    return about | {"type": "object", "properties": properties, "required": list(properties), "additionalProperties": False}


def _material() -> dict[str, Any]:
    return _object(youngs_modulus=POSITIVE, poissons_ratio=NUMBER)


def _motion(description: str) -> dict[str, Any]:
    motions = {"type": "object", "properties": dict.fromkeys(FREEDOMS, NUMBER), "additionalProperties": False}
    return motions | {"description": description}


def _numbers(count: int, description: str) -> dict[str, Any]:
    return {"type": "array", "items": NUMBER, "minItems": count, "maxItems": count, "description": description}


def _text(description: str) -> dict[str, Any]:
    return {"type": "string", "description": description}
