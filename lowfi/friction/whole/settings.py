"""What a scene asks of friction: whether it feeds back, and whether so many balls are solved that kernels are compiled."""

from math import pi

from rollbench.meshes.parts import Friction, Motion, Scene

#: Motion where the scene gives none: the screw turns once a second.
ONE_TURN = Motion(2.0 * pi)
#: Balls from which compiling the kernels (20 s, once) pays for a single solve, without feedback and with it.
COMPILE_ABOVE, COUPLED_ABOVE = 1000, 8


def feeds_back(scene: Scene, friction: Friction) -> bool:
    """Whether friction moves balls in their grooves: it is asked for, there is friction, and a lead."""
    return friction.feedback and scene.track.lead != 0.0 and max(friction.screw, friction.nut) > 0.0


def will_compile(scene: Scene, friction: Friction) -> bool:
    """Whether so many balls are solved that the kernels are compiled, unless machine code lies on disk (``cached``)."""
    often = feeds_back(scene, friction) or friction.neighbours
    return scene.ball_count > (COUPLED_ABOVE if often else COMPILE_ABOVE)
