"""From a catalogue page to loads, stiffness and pressure: python -m compare.examples.catalogue_page"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import rollbench

#: What a catalogue prints; everything else is as usual, and the scene says what was assumed.
SCREW = """
title = "Ball screw 32 x 10 from a catalogue page"
[material]
name = "bearing steel"
[track]
pitch_diameter = "33.4 mm"
lead = "10 mm"
contact_angle = "45 deg"
[screw]
length = "600 mm"
outer_diameter = "32 mm"
conformity = 0.525
[nut]
position = "300 mm"
length = "60 mm"
outer_diameter = "50 mm"
conformity = 0.525
[balls]
diameter = "6.35 mm"
count = 30
turns = 2.5
[preload]
oversize = "2 um"
[[supports]]
at = "0 mm"
fix = ["ux", "uy", "rx", "ry", "rz"]
[[supports]]
at = "600 mm"
fix = ["ux", "uy"]
[[loads]]
at = "0 mm"
force = ["0 N", "0 N", "4 kN"]
"""


def main() -> rollbench.Solution:
    """Solve it and print the answers."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "catalogue.toml"
        path.write_text(SCREW, encoding="utf-8")
        solution = rollbench.solve(path)
    for name in ("axial.displacement_um", "axial.rigidity_N_per_um", "worst_contact.pressure_MPa", "preload.mean_N"):
        print(f"{name.split('.')[1].rsplit('_')[0]:15} {solution.quantity(f'summary.{name}'):.4g~P}")
    return solution


if __name__ == "__main__":
    main()
