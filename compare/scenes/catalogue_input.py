"""What a catalogue gives in place of what the physics takes: diameters, materials by name.

Rewritten before the keys are read (``with_material``, ``with_radius``), so that the physics knows one way of saying it.
"""

from __future__ import annotations

from typing import Any

from pydantic import ConfigDict

from rollbench.meshes import units

#: Materials by name: Young's modulus and Poisson's ratio, rounded values within the ranges of makers' data sheets
#: (steels of bearings and of hardened shafts: 205 to 212 GPa; silicon nitride balls: 300 to 315 GPa; zirconia balls: 205
#: to 210 GPa).
STANDARD: dict[str, tuple[str, float]] = {
    "bearing steel": ("210 GPa", 0.3),
    "silicon nitride": ("310 GPa", 0.26),
    "zirconia": ("210 GPa", 0.3),
}
#: Grades of these materials as drawings and catalogues name them.
GRADES = {
    "bearing steel": ("100Cr6", "SUJ2", "AISI 52100", "42CrMo4", "50CrMo4"),
    "silicon nitride": ("Si3N4",),
    "zirconia": ("ZrO2",),
}
MATERIALS = STANDARD | {grade: STANDARD[name] for name, grades in GRADES.items() for grade in grades}
MATERIAL_NAMES = (
    "a standard material, typical values in place of the two keys below, which go before it: "
    + ", ".join(f"{name} ({', '.join(GRADES[name])}) {modulus}, {ratio:g}" for name, (modulus, ratio) in STANDARD.items())
    + "; with both keys below any other name"
)
OTHER_NAME = "any other name with youngs_modulus and poissons_ratio"


def with_material(table: Any) -> Any:
    """A raw table of a material, the values that it leaves out filled in by its name. Another name that stands with both
    values is a word for the reader of the file, and goes."""
    if not isinstance(table, dict) or not isinstance(name := table.get("name"), str):
        return table
    if name in MATERIALS:
        modulus, ratio = MATERIALS[name]
        return {"youngs_modulus": modulus, "poissons_ratio": ratio} | table
    both = {"youngs_modulus", "poissons_ratio"} <= table.keys()
    return {key: value for key, value in table.items() if key != "name"} if both else table


def with_radius(table: Any, radius: str, diameter: str) -> Any:
    """A raw table with a radius in place of a diameter that is given without one.

    Halving a binary number is exact: the radius is the one that its own text would give. A diameter that cannot be read is
    refused under its own name, so that any radius will do.
    """
    if not isinstance(table, dict) or diameter not in table or radius in table:
        return table
    try:
        half = 0.5 * units.parse(table[diameter], "length")
    except units.UnitError:
        half = 1e-3
    return table | {radius: f"{min(max(half, 1e-5), 1.0)!r} m"}


def either(radius: str, diameter: str) -> ConfigDict:
    """Configuration of a table that needs a radius or a diameter, for its JSON Schema."""

    def change(schema: dict[str, Any]) -> None:
        schema["required"] = [name for name in schema["required"] if name != radius]
        schema["oneOf"] = [{"required": [radius]}, {"required": [diameter]}]

    return ConfigDict(json_schema_extra=change)
