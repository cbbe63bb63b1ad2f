"""What a catalogue gives in place of what the physics takes: diameters, materials by name, circuits, filling.

Rewritten before the keys are read (``with_material``, ``with_radius``), so that the physics knows one way of saying it.
"""

from __future__ import annotations

from math import floor, hypot, pi, sin
from typing import TYPE_CHECKING, Any

from pydantic import ConfigDict

from compare.scenes import units

if TYPE_CHECKING:
    from compare.scenes.schema import BallKeys, TrackKeys

#: Materials by name: Young's modulus and Poisson's ratio, rounded values within the ranges of makers' data sheets
#: (bearing steel 100Cr6: 205 to 212 GPa; silicon nitride balls: 300 to 315 GPa; zirconia balls: 205 to 210 GPa).
MATERIALS: dict[str, tuple[str, float]] = {
    "bearing steel": ("210 GPa", 0.3),
    "silicon nitride": ("310 GPa", 0.26),
    "zirconia": ("210 GPa", 0.3),
}
MATERIAL_NAMES = "a standard material, typical values in place of the two keys below, which go before it: " + ", ".join(
    f"{name} {modulus}, {ratio:g}" for name, (modulus, ratio) in MATERIALS.items()
)


def with_material(table: Any) -> Any:
    """A raw table of a material, the values that it leaves out filled in by its name."""
    if not isinstance(table, dict) or table.get("name") not in MATERIALS:
        return table
    modulus, ratio = MATERIALS[table["name"]]
    return {"youngs_modulus": modulus, "poissons_ratio": ratio} | table


def with_radius(table: Any, radius: str, diameter: str) -> Any:
    """A raw table with a radius in place of a diameter that is given alone.

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


def balls_of_circuit(balls: BallKeys, track: TrackKeys) -> int:
    """Balls of one circuit: the count shared, or as many as fill the part of its turns that is asked for, at least one."""
    if balls.count is not None:
        return balls.count // (track.starts * balls.circuits)
    touching = touching_angle(track.pitch_radius, track.lead, 2.0 * balls.radius)
    return max(1, floor((balls.filling or 0.0) * 2.0 * pi * (balls.turns or 1.0) / touching + 1e-9))


def touching_angle(radius: float, lead: float, ball: float) -> float:
    """Angle [rad] between neighbours on a helix (radius, lead [m]) that touch: their chord is the ball's diameter [m].

    chord^2 = (2 R sin(phi/2))^2 + (lead phi / 2 pi)^2; half a turn where even that is shorter than a ball.
    """
    from scipy.optimize import brentq

    def gap(angle: float) -> float:
        return hypot(2.0 * radius * sin(angle / 2.0), lead * angle / (2.0 * pi)) - ball

    return float(brentq(gap, 0.0, pi, xtol=1e-14)) if gap(pi) > 0.0 else pi


def ball_total(balls: BallKeys, track: TrackKeys) -> int:
    """Number of balls over all starts and circuits."""
    return balls.count or balls_of_circuit(balls, track) * balls.circuits * track.starts


def azimuths(balls: BallKeys, track: TrackKeys) -> tuple[float, ...]:
    """Azimuths of one start [rad]: the balls of a circuit evenly over its turns, circuits centred on the nut with gaps."""
    n = balls_of_circuit(balls, track)
    turns = balls.turns or 1.0
    spacing, pitch = 2.0 * pi * turns / n, 2.0 * pi * (turns + (balls.circuit_gap or 0.0))
    middles = (track.phase + (k - (balls.circuits - 1) / 2.0) * pitch for k in range(balls.circuits))
    return tuple(middle + (i - (n - 1) / 2.0) * spacing for middle in middles for i in range(n))
