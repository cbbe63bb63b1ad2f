"""Two balls in a short nut, and a coarse mesh for them: the smallest scene of the 3D reference."""

from dataclasses import replace

import numpy as np

from rollbench.compare.scenes import catalogue
from rollbench.hifi.meshing.settings import Settings
from rollbench.meshes.condensed import CondensedBodies
from rollbench.meshes.parts import Load, Support

#: Sizes of cells that are as coarse as they may be.
COARSE = {"fine": 3e-3, "coarse": 12e-3, "ball_fine": 1e-3, "ball_coarse": 2e-3}
COARSE |= {"own_cuts": (3, 2, 3), "own_sizes": (2e-3, 8e-3), "own_ball_sizes": (0.9e-3, 1.8e-3)}
AXES = (0.5e-3, 0.14e-3)
SMALL = Settings(b_over_h=0.8, semi=AXES, reach=AXES, cell=9e-3, modes=10**6, ball_modes=10**6, **COARSE)


def relative_deviation_of_fit(bodies: CondensedBodies, side: int) -> float:
    """RMS deviation of a flank's computed approaches from their fitted law, each over Hertz's approach at its force."""
    k, (e, h) = list(bodies.sides).index(side), bodies.fit_local_approach_over_load(side)
    root = np.cbrt(bodies.force[k])
    return float(np.sqrt(np.mean((root / bodies.hertz[k] * (e + h * root - bodies.local[k])) ** 2)))


def two_balls(**changes):
    """Two balls side by side in a short nut, the screw held on both sides close to it."""
    s = catalogue.scene("lin-case1")
    nut, screw = replace(s.nut, position=30e-3, length=16e-3), replace(s.screw, length=60e-3)
    balls, solid = replace(s.balls, azimuths=(-0.35, 0.3)), replace(s.solid, shaft=6e-3, shaft_diameter=30e-3)
    held = {"supports": (s.supports[0], Support(60e-3, (("ux", 0.0), ("uy", 0.0))))}
    held["loads"] = (Load(0.0, (0.0, 0.0, 400.0)),)
    return replace(replace(s, nut=nut, screw=screw, balls=balls, solid=solid, **held), **changes)
