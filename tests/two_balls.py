"""Two balls in a short nut, and a coarse mesh for them: the smallest scene of the 3D reference."""

from dataclasses import replace

from rollbench.comparison.scenes import catalogue
from rollbench.hifi.meshing.settings import Settings
from rollbench.meshes.parts import Load, Support

SMALL = Settings(
    b_over_h=0.8,
    semi=(0.5e-3, 0.14e-3),
    reach=(0.5e-3, 0.14e-3),
    fine=3e-3,
    coarse=12e-3,
    ball_fine=1e-3,
    ball_coarse=2e-3,
    cell=9e-3,
    modes=10**6,
    ball_modes=10**6,
    own_cuts=(3, 2, 3),
    own_sizes=(2e-3, 8e-3),
    own_ball_sizes=(0.9e-3, 1.8e-3),
)


def two_balls(**changes):
    """Two balls side by side in a short nut, the screw held on both sides close to it."""
    s = catalogue.scene("lin-case1")
    scene = replace(
        s,
        nut=replace(s.nut, position=30e-3, length=16e-3),
        screw=replace(s.screw, length=60e-3),
        supports=(s.supports[0], Support(60e-3, (("ux", 0.0), ("uy", 0.0)))),
        balls=replace(s.balls, azimuths=(-0.35, 0.3)),
        loads=(Load(0.0, (0.0, 0.0, 400.0)),),
        solid=replace(s.solid, shaft=6e-3, shaft_diameter=30e-3),
    )
    return replace(scene, **changes)
