"""A scene of a nominal size, such as 40x10: what is usual for it, by rules that the scene states."""

from __future__ import annotations

import re
from math import ceil, floor, pi, sin
from typing import Any

from rollbench.comparison.errors import InputError
from rollbench.comparison.scenes.circuits import touching_angle

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

#: What every size assumes.
ASSUMED = """\
  "The balls are the largest in stock up to {per_lead:g} of the lead and {per_diameter:g} of the nominal diameter.",
  "Pitch circle {beyond:g} ball diameters beyond the nominal diameter, which is that of the lands.",
  "Conformity (groove radius over ball diameter) 0.525: within the usual 0.52 to 0.53; makers do not print it.",
  "{circuits} circuits of {each:g} turns, {percent:g} % filled; number and gaps of circuits differ from maker to maker.",
  "Preload of {preload:g} % of the dynamic load rating{rigid}: catalogues have 3 to 8 %.",
  "Ball radii scatter as in a lot of grade 10 (ISO 3290-1: diameters within 0.5 um, six standard deviations).",
  "Walls of the nut of {wall:g} ball diameters under the grooves; {holding}.",
  "Fixed bearing at the left end of the screw, floating bearing at the right one; {nuts} in the middle.",
"""

TEXT = (
    """\
# A ball screw of nominal size {size}, as is usual for it: edit what your drawing says otherwise.
# Solve it with: rollbench solve FILE; judge it with: rollbench check FILE. All keys: rollbench schema
title = "Ball screw {size}: {turns:g} turns of {ball:g} mm balls, preloaded, {force:g} kN"
assumed = [
"""
    + ASSUMED
    + """]

[material]
name = "bearing steel"

[track]
pitch_diameter = "{pitch:g} mm"
lead = "{lead:g} mm"
contact_angle = "45 deg"
# hand = "left"
# starts = 2

[screw]
length = "{length:g} mm"  # between the bearings
outer_diameter = "{outer:g} mm"  # of the lands
# bore = "{bore:g} mm"  # hollow screw
conformity = 0.525

[nut]
position = "{middle:g} mm"  # of its centre, from the left end of the screw
length = "{nut:g} mm"
outer_diameter = "{outside:g} mm"
conformity = 0.525

[nut.flange]
diameter = "{rim:g} mm"
thickness = "{thick:g} mm"
side = "left"
# centring = "{fit:g} mm"  # length beside the flange that fits the housing's bore

[nut.held]
at = "flange face"  # or: at = "left face", "outer surface", ...
# inner_diameter = "{outside:g} mm"  # of the annulus that bears on the housing
# outer_diameter = "{rim:g} mm"
# centring = "bonded"  # the fit holds the nut, too

[balls]
diameter = "{ball:g} mm"
filling = {filling:g}  # or: count = ...
turns = {each:g}  # of each circuit
circuits = {circuits}
circuit_gap = {gap:g}  # turns without balls from one circuit to the next
# material = {{ name = "silicon nitride" }}

[preload]
force = "{preload:g} % of C"  # or: force = "500 N", or: oversize = "3 um", added to every ball radius

[errors]
seed = 1

[errors.balls]
sigma = "{sigma:g} um"  # of the radii: a lot of grade 10, diameters within 0.5 um; for: rollbench solve FILE --members 1000

[[supports]]  # fixed bearing; the nut takes the load along the axis
at = "0 mm"
fix = ["ux", "uy", "rx", "ry", "rz"]

[[supports]]
at = "{length:g} mm"
fix = ["ux", "uy"]

[[loads]]
at = "0 mm"
force = ["0 N", "0 N", "{force:g} kN"]

# [[cases]]  # load cases in place of the one above, with their shares of the revolutions
# name = "cutting"
# share = 0.3  # or: time = "20 s" and speed = "200 rpm"
# [[cases.loads]]
# at = "0 mm"
# force = ["0 N", "0 N", "{force:g} kN"]
# [[cases]]
# name = "rapid"
# share = 0.7
# [[cases.loads]]
# at = "0 mm"
# force = ["0 N", "0 N", "{rapid:g} kN"]

# [friction]  # for: rollbench friction
# coefficient = 0.1

# [gate]  # for: rollbench check, in per cent
# max_error = 7
"""
)

DOUBLE = (
    """\
# A double nut of nominal size {size}, as is usual for it: edit what your drawing says otherwise.
# Solve it with: rollbench solve FILE. All keys: rollbench schema
title = "Double nut {size}: {turns:g} turns of {ball:g} mm balls in each nut, preloaded, {force:g} kN"
assumed = [
"""
    + ASSUMED
    + """\
  "Both nuts and the spacer between them are one rigid body, which is held.",
]
kind = "axis"

[material]
name = "bearing steel"

[screw]
length = "{length:g} mm"  # between the bearings
outer_diameter = "{outer:g} mm"  # of the lands
conformity = 0.525

[[supports]]  # fixed bearing; the nuts take the load along the axis
at = "0 mm"
fix = ["ux", "uy", "rx", "ry", "rz"]

[[supports]]
at = "{length:g} mm"
fix = ["ux", "uy"]

[[loads]]
at = "0 mm"
force = ["0 N", "0 N", "{force:g} kN"]

# [friction]  # for: rollbench friction
# coefficient = 0.1
"""
)

#: One nut of a double nut, which carries thrust one way.
NUT = """
[[sets]]
name = "nut {number}"
thrust = "{thrust}"
preload = "{preload:g} % of C"  # or: preload = "500 N"

[sets.track]
pitch_diameter = "{pitch:g} mm"
lead = "{lead:g} mm"
contact_angle = "45 deg"

[sets.nut]
position = "{at:g} mm"  # of its centre, from the left end of the screw
length = "{nut:g} mm"
outer_diameter = "{outside:g} mm"
conformity = 0.525

[sets.balls]
diameter = "{ball:g} mm"
filling = {filling:g}  # or: count = ...
turns = {each:g}  # of each circuit
circuits = {circuits}
circuit_gap = {gap:g}  # turns without balls from one circuit to the next

[sets.errors.balls]
sigma = "{sigma:g} um"  # of the radii: a lot of grade 10, diameters within 0.5 um
"""


def scene_like(size: str) -> str:
    """Text of a scene of a nominal size ``DIAMETERxLEAD`` in mm. Raises InputError where the rules do not reach."""
    values = _values(size)
    holding = f"held by a flange of {RIM:g} by {THICK:g} of its diameter"
    return _tidy(TEXT.format(**values, rigid=", between rigid bodies", nuts="the nut", holding=holding), values)


def double_nut_like(size: str) -> str:
    """Text of a double nut of a nominal size, as `scene_like`: its nuts are pressed apart by a spacer."""
    values = _values(size)
    apart = values["nut"] + max(1.0, round(SPACER * values["nut"]))
    places = [values["middle"] - 0.5 * apart, values["middle"] + 0.5 * apart]
    nuts = [
        NUT.format(**values, number=k + 1, thrust=thrust, at=at)
        for k, (thrust, at) in enumerate(zip(("-z", "+z"), places, strict=True))
    ]
    head = DOUBLE.format(**values, rigid=" of each nut", nuts="the nuts", holding="no flanges, held at the left faces")
    return _tidy("".join((head, *nuts)), values)


def _tidy(text: str, values: dict[str, Any]) -> str:
    """Nothing about gaps where there is one circuit."""
    if values["circuits"] > 1:
        return text
    return re.sub(r"(?m)^circuit_gap = .*\n", "", text).replace("1 circuits of", "1 circuit of")


def _values(size: str) -> dict[str, Any]:
    """Numbers of a size, as they stand in the file."""
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
        "turns": circuits * each,
        "length": length,
        "middle": length / 2.0,
        "nut": nut,
        "outside": outside,
        "rim": ceil(RIM * outside),
        "thick": thick,
        "fit": max(1, floor(0.5 * (nut - thick))),
        "bore": floor(0.4 * outer),
        "filling": FILLING,
        "percent": 100.0 * FILLING,
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
    found = re.fullmatch(r"\s*([0-9]{1,3}(?:\.[0-9]+)?)\s*[xX×]\s*([0-9]{1,3}(?:\.[0-9]+)?)\s*", size)
    if found is None:
        raise InputError("command line", "--like", f'"{size}"', allowed, "write diameter and lead with an x between them")
    outer, lead = float(found[1]), float(found[2])
    if not (DIAMETERS[0] <= outer <= DIAMETERS[1] and LEADS[0] <= lead <= min(LEADS[1], 2.0 * outer)):
        advice = "a lead is at most about twice the diameter; write another size by hand: rollbench new FILE"
        raise InputError("command line", "--like", f'"{size}"', allowed, advice)
    return outer, lead
