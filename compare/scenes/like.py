"""A scene of a nominal size, such as 40x10: what is usual for it, by rules that the scene states."""

from __future__ import annotations

import re
from collections.abc import Mapping
from math import ceil, floor, pi, sin
from typing import Any

from rollbench.compare import data
from rollbench.compare.errors import ArgumentError
from rollbench.compare.scenes.from_keys import touching_angle

#: Ball diameters that are kept in stock [mm].
STOCK = (0.8, 1.0, 1.2, 1.588, 2.0, 2.381, 2.778, 3.175, 3.5, 3.969, 4.763, 5.556, 6.35, 7.144, 7.938, 9.525, 12.7)
#: Sizes that the rules are for [mm].
DIAMETERS, LEADS = (6.0, 160.0), (1.0, 100.0)
#: Ball diameter over lead and over nominal diameter at most; pitch circle beyond the land, in ball diameters; wall of the
#: nut under its grooves, in ball diameters; part of the turns filled with balls.
PER_LEAD, PER_DIAMETER, BEYOND, WALL, FILLING = 0.635, 0.2, 0.11, 1.2, 0.9
#: Outer diameter and thickness of a flange over the nut's outer diameter: those of catalogues are 1.4 to 1.7, 0.18 to 0.35.
RIM, THICK = 1.5, 0.2
#: Load of a ball over its diameter squared [N/mm2], about 13 % of a usual dynamic rating, and preload between rigid bodies
#: in per cent of the dynamic rating: catalogues have 3 to 8 %.
LOAD, PRELOAD = 3.7, 5.0
#: Load of rapid travel over that of cutting, in the commented cases.
RAPID = 0.3
#: Standard deviation of the ball radii [um]: the diameters of a lot of grade 10 lie within 0.5 um (ISO 3290-1), taken as
#: six standard deviations.
SIGMA = 0.04

#: Share of a nut's length between the nuts of a double nut.
SPACER = 0.1


def scene_like(size: str) -> str:
    """Text of a scene of a nominal size ``DIAMETERxLEAD`` in mm. Raises InputError where the rules do not reach."""
    values = values_like(size)
    return _tidy(_text("screw", values), values)


def double_nut_like(size: str) -> str:
    """Text of a double nut of a nominal size, as `scene_like`: its nuts are pressed apart by a spacer."""
    values = values_like(size)
    apart = values["nut"] + max(1.0, round(SPACER * values["nut"]))
    places = [values["middle"] - 0.5 * apart, values["middle"] + 0.5 * apart]
    nuts = [
        _text("nut", values, number=k + 1, thrust=thrust, at=at)
        for k, (thrust, at) in enumerate(zip(("-z", "+z"), places, strict=True))
    ]
    return _tidy("".join((_text("double-nut", values), *nuts)), values)


def _text(name: str, values: Mapping[str, Any], **words: object) -> str:
    """A text of the folder ``like_texts``, filled; title and assumptions in it name nothing that is edited later."""
    return data.text(f"scenes/like_texts/{name}.txt").format(**values, **words)


def _tidy(text: str, values: dict[str, Any]) -> str:
    """The text without gaps where there is one circuit."""
    return text if values["circuits"] > 1 else re.sub(r"(?m)^circuit_gap = .*\n", "", text)


def values_like(size: str) -> dict[str, Any]:
    """Numbers of a size by the names in the texts, as they stand in the file: lengths in mm. Raises InputError."""
    outer, lead = _size(size)
    ball = max(b for b in STOCK if b <= max(STOCK[0], 1.01 * min(PER_LEAD * lead, PER_DIAMETER * outer)))
    pitch = round(outer + 2.0 * BEYOND * ball, 2)
    circuits = 2 if lead <= 0.5 * outer else 1
    each, gap = (1.5, 0.5) if circuits == 2 else (2.0 if lead <= outer else 1.0, 0.0)
    reach = circuits * each + (circuits - 1) * gap
    count = circuits * max(1, floor(FILLING * each * 2.0 * pi / touching_angle(pitch / 2.0, lead, ball)))
    length = 50.0 * ceil(20.0 * outer / 50.0)
    nut, outside = ceil(reach * lead + 3.0 * ball), ceil(pitch + (1.0 + 2.0 * WALL) * ball)
    thick = max(1, min(ceil(THICK * outside), floor(0.4 * nut)))
    force = float(f"{LOAD * ball**2 * count * sin(pi / 4.0) / 1e3:.2g}")
    return {
        "size": f"{outer:g}x{lead:g}",
        "outer": outer,
        "lead": lead,
        "ball": ball,
        "pitch": pitch,
        "circuits": circuits,
        "each": each,
        "gap": gap,
        "length": length,
        "middle": length / 2.0,
        "nut": nut,
        "outside": outside,
        "rim": ceil(RIM * outside),
        "rim_of": RIM,
        "thick_of": THICK,
        "thick": thick,
        "fit": max(1, floor(0.5 * (nut - thick))),
        "bore": floor(0.4 * outer),
        "filling": FILLING,
        "preload": PRELOAD,
        "sigma": SIGMA,
        "force": force,
        "rapid": float(f"{RAPID * force:.2g}"),
        "per_lead": PER_LEAD,
        "per_diameter": PER_DIAMETER,
        "beyond": BEYOND,
        "wall": WALL,
    }


def _size(size: str) -> tuple[float, float]:
    """Nominal diameter and lead [mm]."""
    allowed = f"DIAMETERxLEAD in mm, {DIAMETERS[0]:g} to {DIAMETERS[1]:g} x {LEADS[0]:g} to {LEADS[1]:g}, e.g. 40x10"
    match = re.fullmatch(r"\s*([0-9]{1,3}(?:\.[0-9]+)?)\s*[xX×]\s*([0-9]{1,3}(?:\.[0-9]+)?)\s*", size)
    if match is None:
        raise ArgumentError("like", f'"{size}"', allowed, "write diameter and lead with an x between them")
    outer, lead = float(match[1]), float(match[2])
    if not (DIAMETERS[0] <= outer <= DIAMETERS[1] and LEADS[0] <= lead <= min(LEADS[1], 2.0 * outer)):
        advice = "a lead is at most about twice the diameter; write another size by hand: rollbench new FILE"
        raise ArgumentError("like", f'"{size}"', allowed, advice)
    return outer, lead
